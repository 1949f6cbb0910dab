/// Points and predicates on circles and lines that are given as {f = g} for CircularForms f, g.
///
/// Identity is combinatorial: a point is a pair of curves and an orientation. Where two curves of
/// forms meet there are at most two points, and their gradients turn opposite ways at the two, so
/// (curve, curve, sign of the turn) names one point. The crossing of {i = j} with {i = k} is the
/// crossing with {j = k}; nobody computes it three times and hopes that the results agree.
///
/// Every predicate climbs the ladder: double with a proven bound, interval, exact. The first two work
/// on a certified disk around the point (Newton-Kantorovich, see circle_kernel.cpp), the last in the
/// quadratic extension of Q in which the point lives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "circle_curves.hpp"

namespace vcell {

struct PointTag {
    static constexpr char letter = 'p';
};
using PointId = Id<PointTag>;

/// An exact point in double clothes: the true point lies within `error` of (x, y).
struct KernelPoint {
    double x, y, error;
    FormPair first,
        second;  ///< equal: the circle's leftmost point, centre or rightmost point (by orientation)
    /// Sign of grad(first) x grad(second) at the point, grad being that of f - g; Zero where the two
    /// curves touch.
    Sign orientation;
};

class CircleKernel : public CircleCurves {
public:
    /// Forgets all points, too.
    void reset(const CircularFamily* family);

    const KernelPoint& point(PointId p) const { return points_[p]; }
    std::size_t point_count() const { return points_.size(); }

    /// The point where the curves meet with that orientation, or none if they do not. `near` is a place
    /// near which the arithmetic is best conditioned; any finite one gives a correct answer.
    /// Pre: orientation is not Zero; the curves are not the same.
    std::optional<PointId> intersection(FormPair c, FormPair d, Sign orientation,
                                        const Eigen::Vector2d& near);
    /// The same if the first rung can prove it; none says nothing.
    std::optional<PointId> certain_intersection(FormPair c, FormPair d, Sign orientation,
                                                const Eigen::Vector2d& near) {
        if (const auto p = certified_intersection(c, d, orientation, near)) return points_.push_back(*p);
        return std::nullopt;
    }
    /// Positive: the curves cross in two points (one, if both are lines). Zero: they touch in one
    /// point. Negative: they do not meet. Pre: not the same curve.
    Sign intersection_sign(FormPair c, FormPair d, const Eigen::Vector2d& near);
    /// The point in which the curves touch. Pre: intersection_sign is Zero.
    PointId touching_point(FormPair c, FormPair d);
    /// The centre of a circle. Pre: c is not a line.
    PointId center_point(FormPair c) { return circle_point(c, Sign::Zero); }
    /// Leftmost point of a circle. Pre: radius_sign(c) is Positive and c is not a line.
    PointId leftmost_point(FormPair c) { return circle_point(c, Sign::Negative); }
    PointId rightmost_point(FormPair c) { return circle_point(c, Sign::Positive); }

    /// Sign of f - g at p.
    Sign sign_at(PointId p, FormId f, FormId g) {
        FormJet at_point;
        return sign_at(p, f, g, at_point);
    }
    /// The same, and the jet of f - g at the double coordinates of p.
    Sign sign_at(PointId p, FormId f, FormId g, FormJet& at_point);
    /// Sign of grad(c) x grad(d) at p, a point of both.
    Sign turn_at(PointId p, FormPair c, FormPair d);
    /// Lexicographic order of points.
    Sign compare_xy(PointId p, PointId q);
    Sign compare_x(PointId p, PointId q);
    Sign compare_y(PointId p, PointId q);
    /// Sign of y_p - (centre of c)_y. Pre: c is a circle.
    Sign side_of_center(PointId p, FormPair c);

    /// The point in exact numbers, for where doubles are asked in vain.
    ExactCirclePoint& exact_point(PointId p);

    struct ArcBounds {
        std::array<double, 4> box;  ///< {x0, x1, y0, y1}, contains the arc
        double chord,
            sagitta;  ///< upper bounds on the distance of the ends, and of any point from their segment
    };
    /// The arc of c from p to q (the whole circle for p == q, with an infinite sagitta).
    ArcBounds arc_bounds(FormPair c, PointId p, PointId q) const;
    /// Enclosure of f at the true point p: midpoint and radius.
    std::array<double, 2> height(FormId f, PointId p) const;

private:
    /// `moved`: away from a place where the closed form is singular.
    std::optional<KernelPoint> certified_intersection(FormPair c, FormPair d, Sign orientation,
                                                      const Eigen::Vector2d& near, bool moved = false) const;
    bool certify(KernelPoint& p) const;
    PointId add_exact_point(FormPair c, FormPair d, Sign orientation, ExactCirclePoint exact);
    PointId circle_point(FormPair c, Sign which);
    bool share_line(PointId p, PointId q, double KernelForm::*slope) const;
    template <class Coordinate>
    Sign compare(PointId p, PointId q, Coordinate coordinate);

    IdVector<PointId, KernelPoint> points_;
    std::vector<std::int32_t> exact_point_index_;
    std::deque<ExactCirclePoint> exact_points_;
};

}  // namespace vcell
