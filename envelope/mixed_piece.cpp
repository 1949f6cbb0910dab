#include "mixed_piece.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "../core/errors.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Below this exponent, relative to the heights compared, equality is assumed.
constexpr int assumed_exponent = -200;

template <class T>
std::array<T, 2> intersection(const PieceSide& s, const PieceSide& t) {
    const T det = T(s.a) * T(t.b) - T(s.b) * T(t.a);
    return {(T(s.b) * T(t.c) - T(t.b) * T(s.c)) / det, (T(s.c) * T(t.a) - T(t.c) * T(s.a)) / det};
}

bool axis_parallel(const PieceSide& s) { return (s.a == 0 && std::abs(s.b) == 1) || (s.b == 0 && std::abs(s.a) == 1); }

bool is_point(Interval i) { return i.lower() == i.upper(); }

// Removes what is certainly above another one: v at the middle, slopes times half the extent on both sides.
template <class Item, class Above>
void drop_dominated(std::vector<Item>& items, Above&& certainly_above) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
        bool above = false;
        for (std::size_t j = 0; j < items.size() && !above; ++j)
            above = j != i && certainly_above(items[i], items[j]);
        if (!above) std::swap(items[kept++], items[i]);
    }
    items.resize(kept);
}

}  // namespace

IntervalPoint corner_of(const PieceSide& s, const PieceSide& t) {
    if (axis_parallel(s) && axis_parallel(t)) {  // exact
        const PieceSide &upright = s.b == 0 ? s : t, &level = s.b == 0 ? t : s;
        return {Interval(-upright.c * upright.a), Interval(-level.c * level.b)};
    }
    return intersection<Interval>(s, t);
}

SideLabels SideLabels::reversed() const {
    SideLabels out{last(), {}};
    for (auto t = transitions.rbegin(); t != transitions.rend(); ++t) {
        out.transitions.push_back(*t);
        std::swap(out.transitions.back().before, out.transitions.back().after);
    }
    return out;
}

// A side as the graph of its second coordinate over its first, s: x, or y where the side is steep.
struct MixedAnalysis::Line {
    const PieceSide& side;
    bool by_x;
    Interval slope, offset;

    explicit Line(const PieceSide& l) : side(l), by_x(std::abs(l.b) >= std::abs(l.a)) {
        const double p = by_x ? l.a : l.b, q = by_x ? l.b : l.a;
        if (axis_parallel(l)) {
            slope = 0;
            offset = -l.c * q;
        } else {
            slope = -Interval(p) / Interval(q);
            offset = -Interval(l.c) / Interval(q);
        }
    }
    Interval coordinate(const IntervalPoint& p) const { return p[by_x ? 0 : 1]; }
    IntervalPoint at(Interval s) const {
        const Interval other = is_point(slope) && slope.lower() == 0 ? offset : slope * s + offset;
        return by_x ? IntervalPoint{s, other} : IntervalPoint{other, s};
    }
    std::array<Wide, 2> wide_at(double s) const {
        const double p = by_x ? side.a : side.b, q = by_x ? side.b : side.a;
        const Wide other = -(Wide(p) * Wide(s) + Wide(side.c)) / Wide(q);
        return by_x ? std::array{Wide(s), other} : std::array{other, Wide(s)};
    }
    // The derivative of a height along the side with respect to s.
    Interval along(const HeightJet<Interval>& j) const { return by_x ? j.gx + slope * j.gy : j.gy + slope * j.gx; }
};

void MixedAnalysis::assume(const Vector2d& place, double width, std::vector<FormId> forms) {
    ++decisions_.assumed;
    std::ranges::sort(forms);
    assumptions_.push_back({place, width, std::move(forms)});
}

void MixedAnalysis::spreads(const std::array<double, 4>& box, std::span<const FormId> candidates,
                            std::vector<Spread>& out) const {
    const Interval X(box[0], box[1]), Y(box[2], box[3]);
    out.clear();
    for (const FormId f : candidates) {
        const Interval v = heights_.jet(f, Interval(X.mid()), Interval(Y.mid())).v;
        const HeightJet<Interval> all = heights_.jet(f, X, Y);
        out.push_back({f, v, all.gx, all.gy});
    }
}

void MixedAnalysis::cull(const std::array<double, 4>& box, std::vector<FormId>& candidates) {
    const Interval X(box[0], box[1]), Y(box[2], box[3]);
    const double rx = Interval::up(std::max(X.upper() - X.mid(), X.mid() - X.lower())),
                 ry = Interval::up(std::max(Y.upper() - Y.mid(), Y.mid() - Y.lower()));
    std::vector<Spread> all;
    spreads(box, candidates, all);
    std::size_t rival = 0;
    double lowest_top = infinity;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const double top = all[i].v.upper() + all[i].gx.magnitude() * rx + all[i].gy.magnitude() * ry;
        if (top < lowest_top) {
            lowest_top = top;
            rival = i;
        }
    }
    const Spread& r = all[rival];
    std::size_t kept = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Spread& s = all[i];
        const Interval d = s.v - r.v - Interval((s.gx - r.gx).magnitude()) * Interval(rx) -
                           Interval((s.gy - r.gy).magnitude()) * Interval(ry);
        if (i == rival || !(d.lower() > 0)) candidates[kept++] = candidates[i];
    }
    decisions_.by_interval += all.size() - 1;
    candidates.resize(kept);
}

// --- Along a side ------------------------------------------------------------------------------------------

namespace {

// Those of the candidates that may attain the minimum of values enclosed by `value`.
template <class Value>
std::vector<FormId> possibly_lowest(std::span<const FormId> candidates, Value&& value) {
    std::vector<Interval> values;
    double top = infinity;
    for (const FormId f : candidates) {
        values.push_back(value(f));
        top = std::min(top, values.back().upper());
    }
    std::vector<FormId> lowest;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i].lower() <= top) lowest.push_back(candidates[i]);
    return lowest;
}

// The same exactly, at a point in doubles.
std::vector<FormId> exactly_lowest(const Heights& heights, double x, double y, std::span<const FormId> candidates,
                                   Decisions& decisions) {
    std::vector<FormId> lowest;
    for (const FormId f : candidates) {
        const Sign s = lowest.empty() ? Sign::Negative : heights.compare(f, lowest.front(), x, y, decisions);
        if (s == Sign::Negative) lowest.clear();
        if (s != Sign::Positive) lowest.push_back(f);
    }
    return lowest;
}

// And with 320 bits; what they cannot tell apart counts as equal.
std::vector<FormId> lowest_in_many_digits(const Heights& heights, const std::array<Wide, 2>& p,
                                          std::span<const FormId> candidates, Decisions& decisions) {
    std::vector<FormId> lowest;
    std::vector<Wide> values;
    for (const FormId f : candidates) {
        const Wide v = heights.jet(f, p[0], p[1]).v;
        Sign s = Sign::Negative;
        if (!lowest.empty()) {
            s = (v - values.front()).sign().value_or(Sign::Zero);
            ++decisions.by_multiprecision;
        }
        if (s == Sign::Negative) {
            lowest.clear();
            values.clear();
        }
        if (s != Sign::Positive) {
            lowest.push_back(f);
            values.push_back(v);
        }
    }
    return lowest;
}

}  // namespace

std::vector<FormId> MixedAnalysis::lowest_at(const PieceSide& s, const PieceSide& t, std::span<const FormId> candidates) {
    const IntervalPoint p = corner_of(s, t);
    std::vector<FormId> lowest = possibly_lowest(candidates, [&](FormId f) { return heights_.jet(f, p[0], p[1]).v; });
    ++decisions_.by_interval;
    if (lowest.size() == 1) return lowest;
    if (is_point(p[0]) && is_point(p[1])) return exactly_lowest(heights_, p[0].mid(), p[1].mid(), lowest, decisions_);
    lowest = lowest_in_many_digits(heights_, intersection<Wide>(s, t), lowest, decisions_);
    if (lowest.size() > 1) assume({p[0].mid(), p[1].mid()}, std::ldexp(extent_, assumed_exponent), lowest);
    return lowest;
}

std::vector<FormId> MixedAnalysis::lowest_at(const Line& line, double s, std::span<const FormId> candidates) {
    const IntervalPoint p = line.at(Interval(s));
    const std::vector<FormId> lowest =
        possibly_lowest(candidates, [&](FormId f) { return heights_.jet(f, p[0], p[1]).v; });
    ++decisions_.by_interval;
    if (lowest.size() == 1) return lowest;
    if (is_point(p[0]) && is_point(p[1])) return exactly_lowest(heights_, p[0].mid(), p[1].mid(), lowest, decisions_);
    return lowest_in_many_digits(heights_, line.wide_at(s), lowest, decisions_);
}

// The one root of the two forms' difference between s0 and s1, where its slope keeps its sign: interval Newton.
RimTransition MixedAnalysis::locate(const Line& line, double s0, double s1, FormId before, FormId after) {
    double lo = s0, hi = s1;
    for (int i = 0; i < 60; ++i) {
        const double m = Interval(lo, hi).mid();
        const IntervalPoint p = line.at(Interval(m)), range = line.at(Interval(lo, hi));
        const Interval value = heights_.jet(before, p[0], p[1]).v - heights_.jet(after, p[0], p[1]).v;
        const Interval slope =
            line.along(heights_.jet(before, range[0], range[1])) - line.along(heights_.jet(after, range[0], range[1]));
        const Interval next = Interval(m) - value / slope;
        const double l = std::max(lo, next.lower()), h = std::min(hi, next.upper());
        if (!(l <= h)) throw InternalError("no root of a sign change along a side");
        const bool stalled = h - l > 0.5 * (hi - lo);
        lo = l;
        hi = h;
        if (stalled) break;
    }
    ++decisions_.by_interval;
    const IntervalPoint p = line.at(Interval(lo, hi));
    return {before, after, {p[0].mid(), p[1].mid()}, Interval::up(std::hypot(p[0].radius(), p[1].radius())), {}};
}

// From s0 to s1, ascending, the lowest form changes from l0 to l1. Appends all changes.
bool MixedAnalysis::descend(const Line& line, double s0, FormId l0, double s1, FormId l1,
                            std::span<const FormId> candidates, bool is_seam, std::vector<RimTransition>& out) {
    const double m = Interval(s0, s1).mid(), r = Interval::up(std::max(s1 - m, m - s0));
    const IntervalPoint middle = line.at(Interval(m)), range = line.at(Interval(s0, s1));
    struct Item {
        FormId form;
        Interval v, slope;
    };
    std::vector<Item> items;
    for (const FormId f : candidates)
        items.push_back({f, heights_.jet(f, middle[0], middle[1]).v, line.along(heights_.jet(f, range[0], range[1]))});
    drop_dominated(items, [&](const Item& a, const Item& b) {
        return (a.v - b.v - Interval((a.slope - b.slope).magnitude()) * Interval(r)).lower() > 0;
    });
    decisions_.by_interval += candidates.size() - items.size();
    if (items.size() == 1) return true;
    if (items.size() == 2 && (items[0].slope - items[1].slope).sign()) {
        ++decisions_.by_interval;
        if (l0 != l1) out.push_back(locate(line, s0, s1, l0, l1));
        return true;
    }
    std::vector<FormId> left;
    for (const Item& i : items) left.push_back(i.form);
    if (s1 - s0 <= side_floor_width * extent_ || m <= s0 || m >= s1) {
        if (is_seam) return false;
        RimTransition t{l0, l1, {middle[0].mid(), middle[1].mid()}, Interval::up(std::hypot(range[0].radius(), range[1].radius())), left};
        assume(t.point, s1 - s0, left);
        out.push_back(std::move(t));
        return true;
    }
    for (const double ratio : {0.48643, 0.53171, 0.41234}) {
        const double s = s0 + ratio * (s1 - s0);
        const std::vector<FormId> lowest = lowest_at(line, s, left);
        if (lowest.size() != 1 && ratio != 0.41234) continue;
        if (lowest.size() != 1) break;
        return descend(line, s0, l0, s, lowest[0], left, is_seam, out) &&
               descend(line, s, lowest[0], s1, l1, left, is_seam, out);
    }
    return false;
}

std::optional<SideLabels> MixedAnalysis::label_side(const PieceSide& side, const IntervalPoint& from, const IntervalPoint& to,
                                                    FormId first, FormId last, std::vector<FormId> candidates, bool is_seam) {
    const Line line(side);
    const Interval p = line.coordinate(from), q = line.coordinate(to);
    const bool ascending = p.mid() < q.mid();
    const double s0 = std::min(p.lower(), q.lower()), s1 = std::max(p.upper(), q.upper());
    SideLabels labels{ascending ? first : last, {}};
    if (!descend(line, s0, labels.first, s1, ascending ? last : first, candidates, is_seam, labels.transitions))
        return std::nullopt;
    if (is_seam) {
        // Certainly between the corners, and apart from each other.
        double after = ascending ? p.upper() : q.upper();
        const double end = ascending ? q.lower() : p.lower();
        for (const RimTransition& t : labels.transitions) {
            const double s = t.point[line.by_x ? 0 : 1];
            if (s - t.error <= after || s + t.error >= end) return std::nullopt;
            after = s + t.error;
        }
    }
    return ascending ? labels : labels.reversed();
}

FormId MixedAnalysis::label_beside(const PieceSide& side, const IntervalPoint& from, const IntervalPoint& to,
                                   std::span<const FormId> candidates) {
    const Line line(side);
    const double p = line.coordinate(from).mid(), q = line.coordinate(to).mid();
    for (double part = side_floor_width; part < 1; part *= 16) {
        const std::vector<FormId> lowest = lowest_at(line, p + part * (q - p), candidates);
        if (lowest.size() == 1) return lowest[0];
    }
    throw UndecidedError("forms tie all along a side of the base region from (" + std::to_string(from[0].mid()) + ", " +
                         std::to_string(from[1].mid()) + ") on");
}

// --- Inside a piece ----------------------------------------------------------------------------------------

// Newton's method in doubles, then Krawczyk's test around what it found.
std::optional<MixedPiece::Vertex> MixedAnalysis::locate(const std::array<double, 4>& box, std::array<FormId, 3> forms) {
    struct System {
        std::array<Interval, 2> value;
        std::array<std::array<Interval, 2>, 2> jacobian;
    };
    const auto evaluate = [&](Interval x, Interval y) {
        const HeightJet<Interval> a = heights_.jet(forms[0], x, y), b = heights_.jet(forms[1], x, y),
                                  c = heights_.jet(forms[2], x, y);
        return System{{a.v - b.v, a.v - c.v}, {{{a.gx - b.gx, a.gy - b.gy}, {a.gx - c.gx, a.gy - c.gy}}}};
    };
    Vector2d p(Interval(box[0], box[1]).mid(), Interval(box[2], box[3]).mid());
    Eigen::Matrix2d inverse;
    double step = infinity;
    for (int i = 0; i < 20; ++i) {
        const System s = evaluate(p.x(), p.y());
        Eigen::Matrix2d jacobian;
        for (int r = 0; r < 2; ++r)
            for (int c = 0; c < 2; ++c) jacobian(r, c) = s.jacobian[r][c].mid();
        inverse = jacobian.inverse();
        const Vector2d move = inverse * Vector2d(s.value[0].mid(), s.value[1].mid());
        if (!move.allFinite()) return std::nullopt;
        if (!(move.norm() < 0.5 * step)) break;
        p -= move;
        step = move.norm();
    }
    const System at_point = evaluate(p.x(), p.y());
    const Interval y00(inverse(0, 0)), y01(inverse(0, 1)), y10(inverse(1, 0)), y11(inverse(1, 1)), one(1.0);
    const Interval mx = y00 * at_point.value[0] + y01 * at_point.value[1],
                   my = y10 * at_point.value[0] + y11 * at_point.value[1];
    double radius = 2 * std::max(mx.magnitude(), my.magnitude()) + 4 * std::numeric_limits<double>::epsilon() * p.norm();
    for (int i = 0; i < 8; ++i, radius *= 4) {
        const Interval dx(-radius, radius), X = Interval(p.x()) + dx, Y = Interval(p.y()) + dx;
        const auto J = evaluate(X, Y).jacobian;
        const Interval kx = -mx + (one - (y00 * J[0][0] + y01 * J[1][0])) * dx - (y00 * J[0][1] + y01 * J[1][1]) * dx;
        const Interval ky = -my + (one - (y10 * J[0][1] + y11 * J[1][1])) * dx - (y10 * J[0][0] + y11 * J[1][0]) * dx;
        if (kx.magnitude() >= radius || ky.magnitude() >= radius) continue;
        const bool inside = p.x() + kx.upper() >= box[0] && p.x() + kx.lower() <= box[1] && p.y() + ky.upper() >= box[2] &&
                            p.y() + ky.lower() <= box[3];
        if (!inside) return std::nullopt;
        ++decisions_.by_interval;
        return MixedPiece::Vertex{p, Interval::up(std::hypot(kx.magnitude(), ky.magnitude())), forms[0], {}};
    }
    return std::nullopt;
}

std::optional<MixedPiece> MixedAnalysis::resolve(const PieceBoundary& boundary, std::vector<FormId> candidates) {
    MixedPiece piece;
    double x0 = infinity, x1 = -infinity, y0 = infinity, y1 = -infinity;
    for (const IntervalPoint& c : boundary.corners) {
        x0 = std::min(x0, c[0].lower());
        x1 = std::max(x1, c[0].upper());
        y0 = std::min(y0, c[1].lower());
        y1 = std::max(y1, c[1].upper());
    }
    piece.box = {x0, x1, y0, y1};
    const bool at_floor = std::max(x1 - x0, y1 - y0) <= floor_width * extent_;

    std::vector<Spread> rivals;
    spreads(piece.box, candidates, rivals);
    const double mx = Interval(x0, x1).mid(), my = Interval(y0, y1).mid();
    const double rx = Interval::up(std::max(x1 - mx, mx - x0)), ry = Interval::up(std::max(y1 - my, my - y0));
    drop_dominated(rivals, [&](const Spread& a, const Spread& b) {
        return (a.v - b.v - Interval((a.gx - b.gx).magnitude()) * Interval(rx) -
                Interval((a.gy - b.gy).magnitude()) * Interval(ry)).lower() > 0;
    });
    decisions_.by_interval += candidates.size() - rivals.size();

    // Is the piece plain?
    const auto direction = [&](const Spread& a, const Spread& b) -> std::optional<Vector2d> {
        const Interval gx = a.gx - b.gx, gy = a.gy - b.gy;
        const Vector2d d = Vector2d(gx.mid(), gy.mid()).normalized();
        if (!d.allFinite() || !((Interval(d.x()) * gx + Interval(d.y()) * gy).lower() > 0)) return std::nullopt;
        return d;
    };
    const std::size_t n = rivals.size();
    bool plain = n <= 3;
    for (std::size_t i = 0; i < n && plain; ++i)
        for (std::size_t j = i + 1; j < n && plain; ++j) plain = direction(rivals[i], rivals[j]).has_value();
    if (n == 3 && plain) {
        const Spread &a = rivals[0], &b = rivals[1], &c = rivals[2];
        plain = ((a.gx - b.gx) * (a.gy - c.gy) - (a.gy - b.gy) * (a.gx - c.gx)).sign().has_value();
    }
    if (!plain && !at_floor) return std::nullopt;
    ++decisions_.by_interval;

    // The rim, and the changes of label along it.
    struct Change {
        std::uint32_t vertex;
        FormId before, after;
    };
    std::vector<Change> changes;
    std::optional<std::uint32_t> knot;  // a vertex of the rim in which more than two forms meet
    const std::size_t sides = boundary.sides.size();
    const auto add_rim = [&](const Vector2d& p, double error, FormId before, FormId after, std::span<const FormId> ties) {
        const auto v = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back({p, error, after, {ties.begin(), ties.end()}});
        if (before != after) {
            changes.push_back({v, before, after});
            if (ties.size() > 2) knot = static_cast<std::uint32_t>(changes.size() - 1);
        }
    };
    for (std::size_t i = 0; i < sides; ++i) {
        const SideLabels& labels = boundary.labels[i];
        const IntervalPoint& c = boundary.corners[i];
        const FormId before = boundary.labels[(i + sides - 1) % sides].last();
        if (before != labels.first && boundary.corner_ties[i].size() < 2)
            throw InternalError("labels differ around a corner of a piece");
        add_rim({c[0].mid(), c[1].mid()}, Interval::up(std::hypot(c[0].radius(), c[1].radius())), before, labels.first,
                boundary.corner_ties[i]);
        piece.rim.push_back({boundary.sides[i].id, labels.first});
        for (const RimTransition& t : labels.transitions) {
            add_rim(t.point, t.error, t.before, t.after, t.ties);
            piece.rim.push_back({boundary.sides[i].id, t.after});
        }
    }

    const auto find = [&](FormId f) -> const Spread* {
        const auto it = std::ranges::find(rivals, f, &Spread::form);
        return it == rivals.end() ? nullptr : &*it;
    };
    const auto add_arc = [&](std::uint32_t from, std::uint32_t to, FormId left, FormId right) {
        const Vector2d chord = piece.vertices[to].point - piece.vertices[from].point;
        Vector2d across = Vector2d(chord.y(), -chord.x()).normalized();  // left - right grows to the right
        const Spread *a = find(left), *b = find(right);
        if (a && b)
            if (const auto d = direction(*a, *b)) across = *d;
        piece.arcs.push_back({from, to, left, right, across});
    };
    if (changes.empty()) {
        if (!plain) assume({mx, my}, std::max(x1 - x0, y1 - y0), candidates);
        return piece;
    }
    if (knot && plain) {
        const std::uint32_t center = changes[*knot].vertex;
        for (std::size_t k = 1; k < changes.size(); ++k) {
            const Change& c = changes[(*knot + k) % changes.size()];
            add_arc(c.vertex, center, c.before, c.after);
        }
        return piece;
    }
    const bool matched = changes.size() == 2 && changes[0].before == changes[1].after && changes[0].after == changes[1].before;
    if (matched && (plain || n == 2)) {
        if (!plain) assume(piece.vertices[changes[0].vertex].point, std::max(x1 - x0, y1 - y0), candidates);
        add_arc(changes[0].vertex, changes[1].vertex, changes[0].before, changes[0].after);
        return piece;
    }
    std::optional<MixedPiece::Vertex> center;
    if (plain) {
        if (changes.size() != 3) return std::nullopt;
        center = locate(piece.box, {changes[0].before, changes[1].before, changes[2].before});
        if (!center && !at_floor) return std::nullopt;
    }
    if (!center) {
        std::vector<FormId> forms;
        for (const Spread& s : rivals) forms.push_back(s.form);
        center = MixedPiece::Vertex{{mx, my},
                                    Interval::up(std::hypot(x1 - x0, y1 - y0)), changes[0].before, forms};
        assume(center->point, std::max(x1 - x0, y1 - y0), forms);
    }
    piece.vertices.push_back(*center);
    const auto v = static_cast<std::uint32_t>(piece.vertices.size() - 1);
    for (const Change& c : changes) add_arc(c.vertex, v, c.before, c.after);
    return piece;
}

}  // namespace vcell
