/// What the tests demand of curves, found without trusting how they were computed.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "../../core/solver/curves/curve.hpp"

namespace vcell::testing {

/// The unknowns of the tube's point with parameter t, to 200 bits, as doubles.
template <int N>
Point<N + 1> true_point(const CurveSystem<N>& f, const Tube<N + 1>& tube, double t) {
    const WideBox<N + 1> p = point_at<N>(f, tube, Wide(t), 200);
    Point<N + 1> x;
    for (int i = 0; i <= N; ++i) x[i] = p[i].approximation();
    return x;
}

template <std::size_t D>
double distance(const std::array<double, D>& a, const std::array<double, D>& b) {
    double d = 0;
    for (std::size_t i = 0; i < D; ++i) d = std::hypot(d, a[i] - b[i]);
    return d;
}

/// Is the point within `tolerance` of a tube's point with the same parameter, or in a cluster?
template <int N>
bool covers(const CurveSystem<N>& f, const CurveSet<N + 1>& set, const Point<N + 1>& x, double tolerance) {
    for (const auto& component : set.components)
        for (const Tube<N + 1>& tube : component.tubes) {
            const Interval range = tube.parameter();
            const double t = std::clamp(x[tube.axis], range.lower(), range.upper());
            if (std::abs(t - x[tube.axis]) <= tolerance &&
                distance(mid(point_at<N>(f, tube, t)), x) <= tolerance)
                return true;
        }
    return std::any_of(set.undecided.begin(), set.undecided.end(), [&](const auto& c) {
        for (int i = 0; i <= N; ++i)
            if (x[i] < c.box[i].lower() - tolerance || x[i] > c.box[i].upper() + tolerance) return false;
        return true;
    });
}

/// The points of all components with x[i] = c, for curves that cross x[i] = c transversally.
template <int N>
std::vector<Point<N + 1>> fibre(const CurveSystem<N>& f, const CurveSet<N + 1>& set, int i, double c) {
    std::vector<Point<N + 1>> points;
    const auto add = [&](const Point<N + 1>& x) {  // tubes overlap in their joints
        for (const auto& p : points)
            if (distance(p, x) < 1e-9) return;
        points.push_back(x);
    };
    for (const auto& component : set.components)
        for (const Tube<N + 1>& tube : component.tubes) {
            if (!tube.enclosure[i].contains(c)) continue;
            const Interval range = tube.parameter();
            if (tube.axis == i) {
                add(mid(point_at<N>(f, tube, c)));
                continue;
            }
            const auto height = [&](double t) { return mid(point_at<N>(f, tube, t))[i] - c; };
            constexpr int samples = 16;
            for (int s = 0; s < samples; ++s) {
                double lo = std::lerp(range.lower(), range.upper(), s / double(samples));
                double hi = std::lerp(range.lower(), range.upper(), (s + 1) / double(samples));
                const bool below = height(lo) < 0;
                if (below == (height(hi) < 0)) continue;
                for (int step = 0; step < 50; ++step) {
                    const double m = std::midpoint(lo, hi);
                    ((height(m) < 0) == below ? lo : hi) = m;
                }
                add(mid(point_at<N>(f, tube, lo)));
            }
        }
    return points;
}

/// The first broken promise of a result for f in the box.
template <int N>
std::optional<std::string> find_defect(const CurveSystem<N>& f, const IntervalBox<N + 1>& box,
                                       const CurveSet<N + 1>& set) {
    constexpr int D = N + 1;
    const auto on_curve = [&](const IntervalBox<D>& x) {
        for (const Interval& value : f(x))
            if (!value.contains(0.0)) return false;
        return true;
    };
    for (std::size_t id = 0; id < set.components.size(); ++id) {
        const auto& c = set.components[id];
        const std::string name = "component " + std::to_string(id) + ": ";
        if (c.tubes.empty() || c.joints.size() != c.tubes.size() + 1)
            return name + "numbers of tubes and joints";
        for (std::size_t i = 0; i < c.tubes.size(); ++i) {
            const Tube<D>& t = c.tubes[i];
            if (!is_subset(t.parameter(), t.neighbourhood[t.axis]))
                return name + "tube beyond its neighbourhood";
            for (int k = 0; k < D; ++k)
                if (k != t.axis && !(t.neighbourhood[k].lower() < t.enclosure[k].lower() &&
                                     t.enclosure[k].upper() < t.neighbourhood[k].upper()))
                    return name + "tube not inside its neighbourhood";
            for (const auto& [joint, parameter] :
                 {std::pair{c.joints[i], t.begin}, {c.joints[i + 1], t.end}}) {
                if (!overlap(joint, t.enclosure)) return name + "joint beside tube";
                if (!joint[t.axis].contains(parameter)) return name + "joint beside the tube's end";
                if (!on_curve(joint)) return name + "joint not on the curve";
            }
            for (const double fraction : {0.25, 0.5, 0.75}) {
                const double at = std::lerp(t.begin, t.end, fraction);
                const IntervalBox<D> p = point_at<N>(f, t, at);
                if (!is_subset(p, t.enclosure) || !on_curve(p)) return name + "no curve in tube";
                if (width(p) > 1e-7 * width(box))
                    return name + "point not unique";  // near nodes: ill conditioned
            }
        }
        if (c.closed) {
            if (!overlap(c.joints.front(), c.joints.back())) return name + "closed but its ends differ";
            continue;
        }
        if (overlap(c.joints.front(), c.joints.back())) return name + "open but its ends meet";
        for (const int end : {0, 1}) {
            const auto& joint = end == 0 ? c.joints.front() : c.joints.back();
            const CurveEnd& e = c.ends[end];
            if (e.kind == CurveEnd::Kind::Face) {
                const Interval& side = box[e.index / 2];
                if (!joint[e.index / 2].contains(e.index % 2 ? side.upper() : side.lower()))
                    return name + "end not on its face";
            } else {
                if (e.index >= set.undecided.size() || !overlap(joint, set.undecided[e.index].box))
                    return name + "end not in its cluster";
                const auto& branches = set.undecided[e.index].branches;
                if (std::find(branches.begin(), branches.end(), std::array{id, std::size_t(end)}) ==
                    branches.end())
                    return name + "unknown to its cluster";
            }
        }
    }
    // No point on two components.
    for (std::size_t a = 0; a < set.components.size(); ++a)
        for (std::size_t b = 0; b < set.components.size(); ++b) {
            if (a == b) continue;
            for (const auto& joint : set.components[a].joints)
                for (const Tube<D>& t : set.components[b].tubes)
                    if (is_subset(joint, t.neighbourhood) && is_subset(joint[t.axis], t.parameter()))
                        return "components " + std::to_string(a) + " and " + std::to_string(b) + " meet";
        }
    return std::nullopt;
}

/// The sign of a plane curve's function on a grid of n x n cells, and what follows for its curves.
class SignGrid {
public:
    template <class G>
    SignGrid(const G& g, const IntervalBox<2>& box, int n) : n_(n), positive_((n + 1) * (n + 1)) {
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j)
                positive_[i * (n + 1) + j] = g(std::lerp(box[0].lower(), box[0].upper(), i / double(n)),
                                               std::lerp(box[1].lower(), box[1].upper(), j / double(n))) > 0;
    }

    /// Connected regions of one sign. Each loop and each arc from side to side adds one.
    int regions() const {
        std::vector<char> seen(positive_.size(), 0);
        int count = 0;
        for (std::size_t start = 0; start < seen.size(); ++start) {
            if (seen[start]) continue;
            ++count;
            std::vector<std::size_t> stack{start};
            seen[start] = 1;
            while (!stack.empty()) {
                const std::size_t at = stack.back();
                stack.pop_back();
                const auto visit = [&](std::size_t to) {
                    if (!seen[to] && positive_[to] == positive_[at]) seen[to] = 1, stack.push_back(to);
                };
                const int i = static_cast<int>(at) / (n_ + 1), j = static_cast<int>(at) % (n_ + 1);
                if (i > 0) visit(at - (n_ + 1));
                if (i < n_) visit(at + (n_ + 1));
                if (j > 0) visit(at - 1);
                if (j < n_) visit(at + 1);
            }
        }
        return count;
    }

    /// Changes of sign around the box: twice the number of arcs from side to side.
    int boundary_changes() const {
        std::vector<char> around;
        for (int i = 0; i < n_; ++i) around.push_back(at(i, 0));
        for (int j = 0; j < n_; ++j) around.push_back(at(n_, j));
        for (int i = n_; i > 0; --i) around.push_back(at(i, n_));
        for (int j = n_; j > 0; --j) around.push_back(at(0, j));
        int changes = 0;
        for (std::size_t k = 0; k < around.size(); ++k)
            changes += around[k] != around[(k + 1) % around.size()];
        return changes;
    }

private:
    char at(int i, int j) const { return positive_[i * (n_ + 1) + j]; }

    int n_;
    std::vector<char> positive_;
};

}  // namespace vcell::testing
