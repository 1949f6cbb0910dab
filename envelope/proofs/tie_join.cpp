#include "tie_join.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "given_tie.hpp"

namespace vcell {

// A convex piece shows the directions around the apex once each, in their order: when its rim has as many
// changes as the fan has arms, each arm ends in one of them.
bool TieJoin::join() {
    if (!rule_.spares(work_.forms())) return false;
    ApexFinder finder(all_, work_);
    const auto apex = finder.find();
    if (!apex) return false;
    // Between given ones in a position that input does not favour: an arm may not be one.
    std::vector<Vector2d> corners;
    constexpr double skew = 0.29;
    if (apex->rim) {
        const auto sides = work_.sides_at(*apex->rim);
        const Vector2d along(sides[1]->b, -sides[1]->a), inward(sides[1]->a, sides[1]->b);
        corners.push_back(along);
        if (sides[0] == sides[1]) corners.emplace_back(inward + skew * along);
        corners.emplace_back(-sides[0]->b, sides[0]->a);
    } else {
        corners = {{1, skew}, {-skew, 1}, {-1, -skew}, {skew, -1}, {1, skew}};
    }
    const std::vector<FormId> forms = work_.forms();
    const auto fan = find_fan(forms, apex->differences, apex->between, corners);
    if (!fan) return false;
    const auto changes = apex->rim ? work_.changes_after(*apex->rim) : work_.changes;
    const std::vector<FanArm>& arms = fan->arms;
    const std::size_t n = arms.size();
    if (changes.size() != n) return false;
    const auto matches = [&](const RimChange& c, const FanArm& arm) {
        const MixedPiece::Vertex& v = work_.piece.vertices[c.vertex];
        const Vector2d d = v.point - apex->point;
        const double doubt = 2 * (v.error + apex->error + apex->noise);
        const auto turn = [](const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
        return c.before == arm.right && c.after == arm.left && turn(arm.from, d) > doubt * arm.from.norm() &&
               turn(d, arm.to) > doubt * arm.to.norm();
    };
    std::size_t shift = 0;
    while (shift < n && !matches(changes[0], arms[shift])) ++shift;
    if (shift == n && n > 0) return false;
    for (std::size_t k = 0; k < n; ++k)
        if (!matches(changes[k], arms[(k + shift) % n])) return false;

    if (apex->rim) {
        if (work_.piece.rim[*apex->rim].label != fan->first) return false;
        work_.join_all_on_rim(*apex->rim);
    } else {
        work_.join_all_to({apex->point, apex->error, forms[0], forms});
    }
    for (std::size_t k = 0; k < n; ++k)
        if (!divide_arm(work_.piece.arcs[k], *apex, arms[(k + shift) % n])) {
            work_.clear_inside();
            return false;
        }
    if (apex->decided || is_tie_of_given(*apex, finder.triple_in_one_point()))
        ++decisions_.by_exact;
    else
        all_.assume(apex->point, std::max(apex->noise, std::ldexp(extent_, assumed_exponent / 2)), forms);
    return true;
}

// Not asked on a rim.
bool TieJoin::is_tie_of_given(const Apex& apex, const std::optional<std::array<FormId, 3>>& three) {
    if (apex.rim) return false;
    NoisyTie tie{apex.point, apex.error + apex.noise, work_.forms()};
    for (std::size_t i = 0; i < tie.forms.size(); ++i)
        for (std::size_t j = i + 1; j < tie.forms.size(); ++j)
            if (apex.differences[i][j].curvature) tie.touching.push_back({tie.forms[i], tie.forms[j]});
    for (const TiedBetween& b : apex.between)
        tie.in_line.push_back({tie.forms[b.middle], tie.forms[b.outer[0]], tie.forms[b.outer[1]]});
    return GivenTie(all_, work_, tie).is_exact(three);
}

// Boxes this wide, relative to their coordinates, still hold a thousand doubles.
constexpr double rounding_width = 0x1p-40;

// No direction is across the arc all over a piece that contains a point in which the gradients agree. Closer
// and closer to the apex the arc is divided into stretches in whose boxes one is.
bool TieJoin::divide_arm(MixedPiece::Arc& arc, const Apex& apex, const FanArm& arm) const {
    const Spread *f = work_.find(arc.left), *g = work_.find(arc.right);
    if (work_.direction(*f, *g)) return true;
    const Vector2d along = arm.to - arm.from;
    const auto turn = [](const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    const auto corner = [&](double t, const Vector2d& d) { return Vector2d(apex.point + t * d); };
    // The part of the sector between two lines across it.
    const auto box_between = [&](double t0, double t1) {
        std::array<double, 4> box{infinity, -infinity, infinity, -infinity};
        for (const Vector2d& p :
             {corner(t0, arm.from), corner(t0, arm.to), corner(t1, arm.from), corner(t1, arm.to)}) {
            const double doubt = apex.error + 4 * std::numeric_limits<double>::epsilon() * p.norm();
            box = {std::min(box[0], p.x() - doubt), std::max(box[1], p.x() + doubt),
                   std::min(box[2], p.y() - doubt), std::max(box[3], p.y() + doubt)};
        }
        return box;
    };
    const MixedPiece::Vertex& start = work_.piece.vertices[arc.from];
    double t = turn(start.point - apex.point, along) / turn(arm.from, along) * (1 + 0x1p-20) + start.error;
    const double scale = std::max(arm.from.norm(), arm.to.norm());
    const double last = std::max(chord_width * work_.extent, rounding_width * apex.point.norm()) / scale;
    std::vector<MinimizationDiagram::ArcPiece> pieces;
    while (t > last) {
        std::optional<MinimizationDiagram::ArcPiece> piece;
        double next = 0;
        for (const double ratio : {0.25, 0.5, 0.75}) {
            next = ratio * t;
            const auto box = box_between(t, next);
            const auto [gx, gy] =
                heights_.gradient_difference(arc.left, arc.right, {box[0], box[1]}, {box[2], box[3]});
            const Vector2d d = Vector2d(gx.mid(), gy.mid()).normalized();
            const Interval across = Interval(along.x()) * gx + Interval(along.y()) * gy;
            if (!d.allFinite() || !((Interval(d.x()) * gx + Interval(d.y()) * gy).lower() > 0) ||
                !(across.lower() > 0))
                continue;
            // The arc's left form is lower where the line starts.
            const auto difference = [&](const Vector2d& p) {
                const Interval x(p.x()), y(p.y());
                return heights_.value_difference(arc.left, arc.right, x, y);
            };
            double lo = 0, hi = 1;
            for (int i = 0; i < 50; ++i) {
                const double s = 0.5 * (lo + hi);
                (difference(corner(next, arm.from + s * along)).mid() < 0 ? lo : hi) = s;
            }
            const Vector2d p = corner(next, arm.from + lo * along);
            const double error =
                (Interval(difference(p).magnitude() * along.norm()) / Interval(across.lower())).upper();
            piece = {p, Interval::up(error + 4 * std::numeric_limits<double>::epsilon() * p.norm()), d, box};
            break;
        }
        if (!piece && t * scale > node_width * work_.extent) return false;
        if (!piece) break;
        pieces.push_back(*piece);
        t = next;
    }
    const auto box = box_between(t, 0);
    pieces.push_back(
        {work_.piece.vertices[arc.to].point, work_.piece.vertices[arc.to].error, arc.direction, box});
    arc.pieces = std::move(pieces);
    return true;
}

}  // namespace vcell
