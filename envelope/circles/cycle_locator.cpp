#include "cycle_locator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../arrangement/circles/curve_order.hpp"
#include "../../arrangement/circles/point_star.hpp"

namespace vcell {

PointId CycleLocator::point_on(Index cycle) {
    const Index v = mesh_.half_edges()[cycle].origin;
    return v != WorkMesh::none ? mesh_.vertices()[v].point : kernel_.leftmost_point(mesh_.directed(cycle));
}

// The face lies right of the cycle's leftmost point if the cycle bounds it from outside, left of it if it
// is an island in it.
bool CycleLocator::is_outer_cycle(Index cycle) {
    if (mesh_.half_edges()[cycle].origin == WorkMesh::none)
        return kernel_.curvature_sign(mesh_.directed(cycle)) == Sign::Positive;
    PointId leftmost;
    bool on_arc = false, outer = false;
    double right_of_some = HUGE_VAL;  // some point of the cycle lies left of here
    mesh_.for_cycle(cycle, [&](Index h) {
        const KernelPoint& p = kernel_.point(mesh_.vertices()[mesh_.half_edges()[h].origin].point);
        right_of_some = std::min(right_of_some, Interval::up(p.x + p.error));
    });
    mesh_.for_cycle(cycle, [&](Index h) {
        if (mesh_.edges()[h >> 1].bounds.box[0] > right_of_some) return;
        const Index v = mesh_.half_edges()[h].origin, w = mesh_.target(h);
        const PointId p = mesh_.vertices()[v].point;
        if (!leftmost.valid() || (p != leftmost && kernel_.compare_xy(p, leftmost) == Sign::Negative)) {
            leftmost = p;
            on_arc = false;
        }
        const FormPair c = mesh_.directed(h);
        const Sign K = kernel_.curvature_sign(c);
        if (K == Sign::Zero) return;
        const PointId extreme = kernel_.leftmost_point(c);
        if (!CurveOrder(kernel_, c).strictly_between(p, mesh_.vertices()[w].point, extreme)) return;
        if (kernel_.compare_xy(extreme, leftmost) == Sign::Negative) {
            leftmost = extreme;
            on_arc = true;
            outer = K == Sign::Positive;
        }
    });
    if (on_arc) return outer;
    // At a vertex: inner if a corner's sector contains the direction to the left. All edges leave to the
    // right (or straight up), so a sector does unless it turns left from its first edge to its last.
    bool inner = false;
    mesh_.for_cycle(cycle, [&](Index h) {
        if (mesh_.vertices()[mesh_.target(h)].point != leftmost) return;
        inner = inner || PointStar(kernel_, leftmost)
                             .sector_contains_left(mesh_.directed(mesh_.half_edges()[h].next),
                                                   mesh_.directed(WorkMesh::twin(h)));
    });
    return !inner;
}

bool CycleLocator::cycle_contains(Index cycle, PointId p) {
    int crossings = 0;
    mesh_.for_cycle(cycle, [&](Index h) { crossings += crossings_above(h >> 1, p); });
    return crossings % 2 == 1;
}

bool CycleLocator::face_contains(const WorkMesh::Face& f, PointId p) {
    int crossings = 0;
    mesh_.for_boundary(f, [&](Index h) { crossings += crossings_above(h >> 1, p); });
    return crossings % 2 == 1;
}

// How often the open vertical ray upwards from p crosses the edge; p does not lie on it. An x-monotone
// piece counts its left end and not its right one.
int CycleLocator::crossings_above(Index e, PointId p) {
    const KernelPoint& at_p = kernel_.point(p);
    const std::array<double, 4>& box = mesh_.edges()[e].bounds.box;
    if (box[1] < at_p.x - at_p.error || box[0] > at_p.x + at_p.error || box[3] < at_p.y - at_p.error)
        return 0;
    const FormPair c = mesh_.edges()[e].curve;
    const Index from = mesh_.half_edges()[2 * e].origin, to = mesh_.half_edges()[2 * e + 1].origin;
    const auto left_of_or_at = [&](PointId q) { return kernel_.compare_x(q, p) != Sign::Positive; };
    const Sign K = kernel_.curvature_sign(c);
    if (K == Sign::Zero) {
        const PointId a = mesh_.vertices()[from].point, b = mesh_.vertices()[to].point;
        if (left_of_or_at(a) == left_of_or_at(b)) return 0;
        // Above the line {F = 0}, F = A x + B y + C, F has the sign of B; B has that of -dx along it.
        const Sign B = left_of_or_at(a) ? Sign::Negative : Sign::Positive;
        return kernel_.sign_at(p, c.f, c.g) == -B ? 1 : 0;
    }
    const Sign side = kernel_.side_of_center(p, c), distance = K * kernel_.sign_at(p, c.f, c.g);
    // Is p below the lower half (below the upper half) of the circle, where they have p's x?
    const bool below_lower = distance == Sign::Positive && side == Sign::Negative;
    const bool below_upper = distance == Sign::Negative || side == Sign::Negative ||
                             (distance == Sign::Zero && side != Sign::Positive);
    const PointId left = kernel_.leftmost_point(c), right = kernel_.rightmost_point(c);
    int count = 0;
    const auto piece = [&](PointId a, PointId b, bool upper) {
        if (left_of_or_at(a) != left_of_or_at(b) && (upper ? below_upper : below_lower)) ++count;
    };
    if (from == WorkMesh::none) {
        piece(left, right, false);
        piece(right, left, true);
        return count;
    }
    // Counter-clockwise from a to b.
    PointId a = mesh_.vertices()[from].point, b = mesh_.vertices()[to].point;
    FormPair ccw = c;
    if (K == Sign::Negative) {
        std::swap(a, b);
        ccw = c.reversed();
    }
    const bool has_left = CurveOrder(kernel_, ccw).strictly_between(a, b, left),
               has_right = CurveOrder(kernel_, ccw).strictly_between(a, b, right);
    if (has_left && has_right) {
        const bool left_first = CurveOrder(kernel_, ccw).strictly_between(a, right, left);
        if (left_first) {
            piece(a, left, true);
            piece(left, right, false);
            piece(right, b, true);
        } else {
            piece(a, right, false);
            piece(right, left, true);
            piece(left, b, false);
        }
    } else if (has_left) {
        piece(a, left, true);
        piece(left, b, false);
    } else if (has_right) {
        piece(a, right, false);
        piece(right, b, true);
    } else {
        // Within one half: the lower one is run to the right, the upper one to the left.
        piece(a, b, kernel_.compare_x(a, b) == Sign::Positive);
    }
    return count;
}

}  // namespace vcell
