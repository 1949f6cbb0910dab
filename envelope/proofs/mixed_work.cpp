#include "mixed_work.hpp"

namespace vcell {

std::vector<FormId> PieceWork::forms() const {
    std::vector<FormId> all;
    all.reserve(rivals.size());
    for (const Spread& s : rivals) all.push_back(s.form);
    return all;
}

std::array<Interval, 2> PieceWork::gradient(const Spread& a, const Spread& b) const {
    const auto over =
        normals ? normals->gradient(a.support, b.support) : std::array{a.gx - b.gx, a.gy - b.gy};
    if (const Twins* t = find_twins(a.form, b.form))
        return refined_gradient({narrowed(over[0], t->over.x), narrowed(over[1], t->over.y)},
                                {t->middle.x, t->middle.y}, {t->over.xx, t->over.xy, t->over.yy},
                                Interval(piece.box[0], piece.box[1]) - Interval(middle().x()),
                                Interval(piece.box[2], piece.box[3]) - Interval(middle().y()));
    return a.bend && b.bend ? bent_gradient(over, a, b) : over;
}

const PieceWork::Twins* PieceWork::find_twins(FormId f, FormId g) const {
    for (const Twins& t : twins)
        if (t.f == f && t.g == g) return &t;
    if (!heights.are_twins(f, g)) return nullptr;
    const Interval X(piece.box[0], piece.box[1]), Y(piece.box[2], piece.box[3]);
    twins.push_back(
        {f, g, *heights.twin_difference(f, g, X.mid(), Y.mid()), *heights.twin_difference(f, g, X, Y)});
    return &twins.back();
}

Vector2d PieceWork::least(const Gradient& g) {
    const auto least = [](const Interval& i) {
        return i.lower() > 0 ? i.lower() : i.upper() < 0 ? i.upper() : 0;
    };
    return {least(g[0]), least(g[1])};
}

bool PieceWork::grow_together(std::span<const Gradient> gradients) {
    Vector2d middle(0, 0), end(0, 0);
    for (const Gradient& g : gradients) {
        if (least(g).isZero(0)) return false;
        middle += Vector2d(g[0].mid(), g[1].mid()).normalized();
        end += least(g).normalized();
    }
    const auto all_grow = [&](const Vector2d& d) {
        return std::ranges::all_of(gradients, [&](const Gradient& g) { return grows(g, d); });
    };
    return all_grow(middle) || all_grow(end);
}

HeightDifference PieceWork::difference(const Spread& a, const Spread& b) const {
    const auto &p = *a.bend, &q = *b.bend;
    if (const Twins* t = find_twins(a.form, b.form))
        return {t->middle, {t->over.xx, t->over.xy, t->over.yy}, p.dx, p.dy};
    return {p.middle, q.middle, p.curvature - q.curvature, p.dx, p.dy};
}

std::optional<Vector2d> PieceWork::direction(const Spread& a, const Spread& b) const {
    for (const Direction& known : directions) {
        if (known.a == a.form && known.b == b.form) return known.d;
        if (known.a == b.form && known.b == a.form)
            return known.d ? std::optional<Vector2d>(-*known.d) : known.d;
    }
    auto d = find_direction(a, b);
    if (d && rule.shows_greater(a.form, b.form)) *d = -*d;
    directions.push_back({a.form, b.form, d});
    return directions.back().d;
}

std::optional<Vector2d> PieceWork::find_direction(const Spread& a, const Spread& b) const {
    // Beside a tip pieces are as narrow along the axis as they are near to it: where they are squares, so
    // to speak.
    const auto& box = piece.box;
    const bool has_tips = heights.family().tips.any();
    const double aspect = has_tips ? (box[3] - box[2]) / (box[1] - box[0]) : 1;
    const auto along = [&](const Gradient& g) {
        return Vector2d(g[0].mid(), aspect * aspect * g[1].mid()).normalized();
    };
    const Gradient g = gradient(a, b);
    const Vector2d d = along(g), end(least(g).x(), aspect * aspect * least(g).y());
    if (grows(g, d)) return d;
    if (grows(g, end)) return end.normalized();
    if (a.bend && b.bend) {
        const HeightDifference bent = difference(a, b);
        for (const Vector2d& e : {d, across_ends(a.form, b.form).value_or(d)})
            if (e.allFinite() && bent.slope_along(e).lower() > 0) return e;
    }
    if (has_tips) {
        const Gradient plain = plain_gradient(a, b);
        if (grows(plain, along(plain))) return along(plain);
    }
    if (!supports || rivals.size() > most_divided) return std::nullopt;
    const Vector2d across = across_ends(a.form, b.form).value_or(d);
    if (!across.allFinite() || falls_on_rim(a.form, b.form, across)) return std::nullopt;
    if (!divided().grows_along(place(a), place(b), across)) return std::nullopt;
    return across;
}

bool PieceWork::falls_on_rim(FormId a, FormId b, const Vector2d& direction) const {
    return std::ranges::any_of(changes, [&](const RimChange& c) {
        if (!(c.before == a && c.after == b) && !(c.before == b && c.after == a)) return false;
        const PointNormal n(piece.vertices[c.vertex].point.x(), piece.vertices[c.vertex].point.y());
        const auto f = supports->jet(a, n), g = supports->jet(b, n);
        return direction.x() * (f[1] - g[1]) + direction.y() * (f[2] - g[2]) < 0;
    });
}

const DividedBox& PieceWork::divided() const {
    if (!is_divided) {
        parted = forms();
        if (parts)
            parts->start(piece.box, parted);
        else
            parts.emplace(*supports, piece.box, parted);
        is_divided = true;
    }
    return *parts;
}

std::optional<Sign> PieceWork::turn(const Spread& a, const Spread& b, const Spread& c) const {
    const auto reversed = [](std::optional<Sign> s) { return s ? std::optional(-*s) : s; };
    if (b.form < a.form) return reversed(turn(b, a, c));
    if (c.form < b.form) return reversed(turn(a, c, b));
    const auto [p, q, r] = told_apart(a, b, c);
    return turn_from(*p, *q, *r);
}

std::array<const Spread*, 3> PieceWork::told_apart(const Spread& a, const Spread& b, const Spread& c) const {
    if (heights.are_twins(b.form, c.form)) return {&b, &c, &a};
    if (normals) return {&a, &b, &c};
    constexpr double much_steeper = 0x1p10;
    const auto steepness = [](const Spread& s, const Spread& t) {
        return std::hypot(s.gx.mid() - t.gx.mid(), s.gy.mid() - t.gy.mid());
    };
    if (much_steeper * steepness(b, c) < std::min(steepness(a, b), steepness(a, c))) return {&b, &c, &a};
    return {&a, &b, &c};
}

std::optional<Sign> PieceWork::turn_from(const Spread& a, const Spread& b, const Spread& c) const {
    const auto orientation = [](const std::array<Interval, 2>& p, const std::array<Interval, 2>& q) {
        const auto sign = (p[0] * q[1] - p[1] * q[0]).sign();
        return sign == Sign::Zero ? std::nullopt : sign;
    };
    if (const auto sign = orientation(gradient(b, a), gradient(c, a))) return sign;
    if (are_apart(a, b, c)) return Sign::Zero;
    if (a.bend && b.bend && c.bend) {
        const HeightDifference p = difference(b, a), q = difference(c, a);
        const auto where = common_zeros(p, q);
        if (!where) return Sign::Zero;
        const auto& [x, y] = *where;
        if (const auto sign = orientation(p.gradient(x, y), q.gradient(x, y))) return sign;
    }
    if (heights.family().tips.any()) return orientation(plain_gradient(b, a), plain_gradient(c, a));
    if (!supports || rivals.size() > most_divided) return std::nullopt;
    const auto sign = divided().turn(place(a), place(b), place(c));
    return sign == Sign::Zero ? std::nullopt : sign;
}

bool PieceWork::is_hidden(const Spread& a, const Spread& b, const Spread& c) const {
    if (supports || rivals.size() < 4 || !rule.spares(forms())) return false;
    if (!a.bend || !b.bend || !c.bend) return false;
    const auto [p, q, r] = told_apart(a, b, c);
    const auto where = common_zeros(difference(*q, *p), difference(*r, *p));
    return !where || std::ranges::any_of(rivals, [&](const Spread& s) {
        return &s != p && &s != q && &s != r && s.bend &&
               difference(s, *p).value((*where)[0], (*where)[1]).upper() < 0;
    });
}

bool PieceWork::are_apart(const Spread& a, const Spread& b, const Spread& c) const {
    struct Difference {
        Interval v, gx, gy;
        HeightCurvature<Interval> curvature{};

        double dot(const Difference& o) const { return gx.mid() * o.gx.mid() + gy.mid() * o.gy.mid(); }
    };
    const bool bends = a.bend && b.bend && c.bend;
    if (normals && !bends) return false;
    const auto from_a = [&](const Spread& s) -> Difference {
        if (!bends) return {s.v - a.v, s.gx - a.gx, s.gy - a.gy};
        const HeightDifference d = difference(s, a);
        return {d.v, d.gx, d.gy, d.curvature};
    };
    Difference p = from_a(b), q = from_a(c);
    if (p.dot(p) < q.dot(q)) std::swap(p, q);
    const Interval k(p.dot(q) / p.dot(p));
    const Vector2d m = middle();
    const Interval dx = Interval(piece.box[0], piece.box[1]) - Interval(m.x()),
                   dy = Interval(piece.box[2], piece.box[3]) - Interval(m.y());
    Interval rest = q.v - k * p.v + (q.gx - k * p.gx) * dx + (q.gy - k * p.gy) * dy;
    if (bends)
        rest = rest + 0.5 * ((q.curvature.xx - k * p.curvature.xx) * square(dx) +
                             2.0 * ((q.curvature.xy - k * p.curvature.xy) * dx * dy) +
                             (q.curvature.yy - k * p.curvature.yy) * square(dy));
    return rest.lower() > 0 || rest.upper() < 0;
}

bool PieceWork::is_apart(const Spread& a, const Spread& b, const Spread& c) const {
    if (!a.bend || !is_small || rivals.size() > most_divided ||
        !heights.family().compared_over().is_cylinder())
        return false;
    if (known_apart({a.form, b.form, c.form})) return true;
    const auto meet_nowhere_of = [&](const Spread& h, const Spread& f, const Spread& g) {
        return meet_nowhere(heights, h.form, f.form, g.form, piece.box, decisions);
    };
    if (!meet_nowhere_of(a, b, c) && !meet_nowhere_of(b, a, c) && !meet_nowhere_of(c, a, b)) return false;
    apart.push_back({a.form, b.form, c.form});
    return true;
}

std::uint32_t PieceWork::add_arc(std::uint32_t from, std::uint32_t to, FormId left, FormId right) {
    const Vector2d chord = piece.vertices[to].point - piece.vertices[from].point;
    Vector2d across = Vector2d(chord.y(), -chord.x()).normalized();  // left - right grows to the right
    const Spread *a = find(left), *b = find(right);
    if (a && b)
        if (const auto d = direction(*a, *b)) across = *d;
    piece.arcs.push_back({from, to, left, right, across, {}});
    return static_cast<std::uint32_t>(2 * (piece.arcs.size() - 1));
}

void PieceWork::join_all_to(const MixedPiece::Vertex& center) {
    const auto v = static_cast<std::uint32_t>(piece.vertices.size());
    piece.vertices.push_back(center);
    piece.leaving.emplace_back();
    for (const RimChange& c : changes) {
        const std::uint32_t h = add_arc(c.vertex, v, c.before, c.after);
        piece.leaving[c.vertex].push_back(h);
        piece.leaving[v].push_back(h + 1);
    }
}

}  // namespace vcell
