// What deciding one piece works on: the piece as it is drawn, and its rivals.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "box_rivals.hpp"
#include "height_difference.hpp"
#include "mixed_drawing.hpp"
#include "touching.hpp"

namespace vcell {

// Below this exponent a third form lowest by less between two others counts as touching their trisector.
inline constexpr int narrow_exponent = -40;
// Below this one more than three forms, of which some touch, count as meeting in one point.
inline constexpr int noise_exponent = -46;

// How rivals compare all over the piece: what is known of them lasts until some are left out.
struct PieceWork : PieceDrawing {
    const NormalBox* normals;  // these two are null unless rivals compare by supports
    const SphereSupports* supports;
    const Heights& heights;
    const FloorRule& rule;
    Decisions& decisions;
    std::optional<DividedBox>& parts;  // an earlier piece's until this one is divided
    std::vector<Spread>& rivals;       // as the last cull() left them, fewer as more is known

    double width = 0, extent = 0;
    bool is_small = false;                         // in one direction at least
    std::vector<std::array<FormId, 3>> triples{};  // of the inner vertices
    mutable bool is_divided = false;
    mutable std::vector<FormId> parted{};  // their forms
    struct Direction {
        FormId a, b;
        std::optional<Vector2d> d;
    };
    mutable SmallVector<Direction, 6> directions{};      // as found for the rivals as they are
    mutable std::vector<std::array<FormId, 3>> apart{};  // known to tie nowhere, in the order of the rivals
    // The difference of twins among the rivals, at the middle of the box and all over it.
    struct Twins {
        FormId f, g;
        FunctionJet<Interval> middle, over;
    };
    mutable std::vector<Twins> twins{};

    std::vector<FormId> forms() const {
        std::vector<FormId> all;
        all.reserve(rivals.size());
        for (const Spread& s : rivals) all.push_back(s.form);
        return all;
    }
    const Spread* find(FormId f) const {
        const auto it = std::ranges::find(rivals, f, &Spread::form);
        return it == rivals.end() ? nullptr : &*it;
    }
    // The gradient of a - b all over the piece. Where the two are nearly the same function its mean value
    // form is by far the sharper one.
    std::array<Interval, 2> gradient(const Spread& a, const Spread& b) const {
        const auto over =
            normals ? normals->gradient(a.support, b.support) : std::array{a.gx - b.gx, a.gy - b.gy};
        if (const Twins* t = find_twins(a.form, b.form))
            return refined_gradient({narrowed(over[0], t->over.x), narrowed(over[1], t->over.y)},
                                    {t->middle.x, t->middle.y}, {t->over.xx, t->over.xy, t->over.yy},
                                    Interval(piece.box[0], piece.box[1]) - Interval(middle().x()),
                                    Interval(piece.box[2], piece.box[3]) - Interval(middle().y()));
        return a.bend && b.bend ? bent_gradient(over, a, b) : over;
    }
    // Null unless the two are twins.
    const Twins* find_twins(FormId f, FormId g) const {
        for (const Twins& t : twins)
            if (t.f == f && t.g == g) return &t;
        if (!heights.are_twins(f, g)) return nullptr;
        const Interval X(piece.box[0], piece.box[1]), Y(piece.box[2], piece.box[3]);
        twins.push_back(
            {f, g, *heights.twin_difference(f, g, X.mid(), Y.mid()), *heights.twin_difference(f, g, X, Y)});
        return &twins.back();
    }
    // The same of heights that are not multiplied by the distances from tips: near one the product of those
    // that do not grow there is nearly zero, and changes little but with the distance.
    std::array<Interval, 2> plain_gradient(const Spread& a, const Spread& b) const {
        const auto& box = piece.box;
        return heights.plain_gradient_difference(a.form, b.form, {box[0], box[1]}, {box[2], box[3]});
    }
    using Gradient = std::array<Interval, 2>;
    // Of a gradient the least one: in its direction all of them grow. Zero if it may vanish.
    static Vector2d least(const Gradient& g) {
        const auto least = [](const Interval& i) {
            return i.lower() > 0 ? i.lower() : i.upper() < 0 ? i.upper() : 0;
        };
        return {least(g[0]), least(g[1])};
    }
    static bool grows(const Gradient& g, const Vector2d& d) {
        return d.allFinite() && (Interval(d.x()) * g[0] + Interval(d.y()) * g[1]).lower() > 0;
    }
    // Do all of these grow in one direction, as far as directions near their middles or ends tell?
    static bool grow_together(std::span<const Gradient> gradients) {
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
    // Pre: both are bent.
    HeightDifference difference(const Spread& a, const Spread& b) const {
        const auto &p = *a.bend, &q = *b.bend;
        if (const Twins* t = find_twins(a.form, b.form))
            return {t->middle, {t->over.xx, t->over.xy, t->over.yy}, p.dx, p.dy};
        return {p.middle, q.middle, p.curvature - q.curvature, p.dx, p.dy};
    }
    // A unit vector in which a - b certainly grows all over the piece, or falls if the greater one of the two
    // shows; over a sphere at least wherever a = b are lowest.
    std::optional<Vector2d> direction(const Spread& a, const Spread& b) const {
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
    std::optional<Vector2d> find_direction(const Spread& a, const Spread& b) const {
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
    // Does every line in this direction of theirs meet a = b at most once?
    bool crosses_once(const Spread& a, const Spread& b, const Vector2d& direction) const {
        return !is_divided || rivals.size() == 2 || parts->grows_throughout(place(a), place(b), direction);
    }
    // Does a - b seem to fall where the two change on the rim? A cheap no to what would have to be proved.
    bool falls_on_rim(FormId a, FormId b, const Vector2d& direction) const {
        return std::ranges::any_of(changes, [&](const RimChange& c) {
            if (!(c.before == a && c.after == b) && !(c.before == b && c.after == a)) return false;
            const PointNormal n(piece.vertices[c.vertex].point.x(), piece.vertices[c.vertex].point.y());
            const auto f = supports->jet(a, n), g = supports->jet(b, n);
            return direction.x() * (f[1] - g[1]) + direction.y() * (f[2] - g[2]) < 0;
        });
    }
    std::size_t place(const Spread& s) const { return static_cast<std::size_t>(&s - rivals.data()); }
    const DividedBox& divided() const {
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
    // The turn from grad a over grad b to grad c, over a sphere at least in a box that holds all points where
    // a = b = c are lowest; Zero if there are no such points. The three in one order always, as another one
    // need not tell.
    std::optional<Sign> turn(const Spread& a, const Spread& b, const Spread& c) const {
        const auto reversed = [](std::optional<Sign> s) { return s ? std::optional(-*s) : s; };
        if (b.form < a.form) return reversed(turn(b, a, c));
        if (c.form < b.form) return reversed(turn(a, c, b));
        // A difference of twins is to be one of the two that are compared.
        return heights.are_twins(b.form, c.form) ? turn_from(b, c, a) : turn_from(a, b, c);
    }
    std::optional<Sign> turn_from(const Spread& a, const Spread& b, const Spread& c) const {
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
    // Wherever the three are equal, is another rival certainly lower? Not asked beside a floor.
    bool is_hidden(const Spread& a, const Spread& b, const Spread& c) const {
        if (supports || rivals.size() < 4 || !rule.spares(forms())) return false;
        if (!a.bend || !b.bend || !c.bend) return false;
        const auto where = heights.are_twins(b.form, c.form)
                               ? common_zeros(difference(c, b), difference(a, b))
                               : common_zeros(difference(b, a), difference(c, a));
        return !where || std::ranges::any_of(rivals, [&](const Spread& s) {
            return &s != &a && &s != &b && &s != &c && s.bend &&
                   difference(s, a).value((*where)[0], (*where)[1]).upper() < 0;
        });
    }
    // Of forms in a point where all are equal: the one after `p` on the convex hull of their gradients,
    // counter-clockwise. None if p is not on it.
    template <class Spreads>
    const Spread* next_on_hull(const Spreads& tied, const Spread& p) const {
        const auto follows = [&](const Spread* q) {
            return q != &p && std::ranges::all_of(tied, [&](const Spread* o) {
                       return o == &p || o == q || turn(p, *q, *o) == Sign::Positive;
                   });
        };
        const auto next = std::ranges::find_if(tied, follows);
        return next == tied.end() ? nullptr : *next;
    }
    // Is a combination of b - a and c - a nowhere zero? Then the three are nowhere equal. Of all combinations
    // the one that changes least about the middle: nearly nothing to first order where trisectors run beside
    // each other.
    bool are_apart(const Spread& a, const Spread& b, const Spread& c) const {
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
    // Do the three certainly tie nowhere in the piece? Where gradients are on one line all along a trisector,
    // as of tubes that are nearly parallel over a tube, their turn never tells. Asked of few and in a small
    // piece, when the other questions have failed.
    bool is_apart(const Spread& a, const Spread& b, const Spread& c) const {
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
    bool known_apart(const std::array<FormId, 3>& forms) const {
        return std::ranges::find(apart, forms) != apart.end();
    }
    // Returns the arc's half-edge at its start; its twin's number is one more.
    std::uint32_t add_arc(std::uint32_t from, std::uint32_t to, FormId left, FormId right) {
        const Vector2d chord = piece.vertices[to].point - piece.vertices[from].point;
        Vector2d across = Vector2d(chord.y(), -chord.x()).normalized();  // left - right grows to the right
        const Spread *a = find(left), *b = find(right);
        if (a && b)
            if (const auto d = direction(*a, *b)) across = *d;
        piece.arcs.push_back({from, to, left, right, across, {}});
        return static_cast<std::uint32_t>(2 * (piece.arcs.size() - 1));
    }
    // Between two places on the rim.
    void join(const RimChange& from, const RimChange& to) {
        const std::uint32_t h = add_arc(from.vertex, to.vertex, from.before, from.after);
        piece.leaving[from.vertex].push_back(h);
        piece.leaving[to.vertex].push_back(h + 1);
    }
    // Do all rivals meet in a vertex of the rim?
    bool all_tie_in(std::uint32_t v) const {
        const std::vector<FormId>& ties = piece.vertices[v].ties;
        return std::ranges::all_of(
            rivals, [&](const Spread& s) { return std::ranges::find(ties, s.form) != ties.end(); });
    }
    // From all other changes to a vertex of the rim.
    void join_all_on_rim(std::uint32_t v) {
        for (const RimChange& c : changes_after(v)) join(c, {v, c.after, c.before});
    }
    // From every change to one inner vertex.
    void join_all_to(const MixedPiece::Vertex& center) {
        const auto v = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back(center);
        piece.leaving.emplace_back();
        for (const RimChange& c : changes) {
            const std::uint32_t h = add_arc(c.vertex, v, c.before, c.after);
            piece.leaving[c.vertex].push_back(h);
            piece.leaving[v].push_back(h + 1);
        }
    }
};

}  // namespace vcell
