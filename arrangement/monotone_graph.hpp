/// x-monotone pieces of curves as functions y(x), evaluated over intervals on both rungs of the ladder.
///
/// All decisions on curves of mixed kinds rest on these evaluations: whatever a curve is given by
/// (coefficients, control points, a defining function), an enclosure of y and of the direction of travel over
/// any interval of x is all that the arrangement asks of it. Fitted splines appear as filters only:
/// rough_y().
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "../core/bernstein.hpp"
#include "../core/bspline.hpp"
#include "../core/circular_form.hpp"
#include "defining_function.hpp"

namespace vcell {

/// The direction in which a graph runs to the right: a positive multiple of (1, y'), dx >= 0; dx = 0 where
/// the tangent is vertical.
template <class T>
struct Direction {
    T dx, dy;
};

/// Part of the circle or line k |p - c|^2 + a x + b y + e = 0 (w is ignored). The coefficients are exact.
/// Pre: a circle has k > 0, a line k = 0 and b != 0.
struct CircularGraph {
    CircularForm form;
    Sign half = Sign::Zero;  ///< of a circle: Positive for the upper half, Negative for the lower one

    template <class T>
    T y(const T& x) const;
    template <class T>
    Direction<T> direction(const T& x) const;
};

/// A parameter at which a polynomial changes its sign. Refined once, when asked for.
class BernsteinRoot {
public:
    BernsteinRoot(std::shared_ptr<const std::vector<Exact>> polynomial, SignChange where);
    /// An exact parameter.
    explicit BernsteinRoot(double t) : rough_(t), fine_(Wide(t)) {}
    template <class T>
    T enclosure() const;

private:
    std::shared_ptr<const std::vector<Exact>> polynomial_;
    SignChange where_{};
    Interval rough_;
    mutable std::optional<Wide> fine_;
};

/// A rational Bezier curve over [0, 1]: control points (x, y, w), all exact.
class RationalBezier {
public:
    /// Pre: degree >= 1, weights positive; x is not constant.
    explicit RationalBezier(std::vector<Eigen::Vector3d> points);

    const std::vector<Eigen::Vector3d>& points() const { return points_; }
    /// The parameters strictly inside (0, 1) where the curve turns back in x.
    const std::vector<BernsteinRoot>& turns() const { return turns_; }
    /// Does x increase right behind parameter 0? Else it decreases.
    bool starts_rightward() const { return starts_rightward_; }

    /// All coefficients in Bernstein form: wx, wy, w and, up to a positive factor, the derivatives of x and
    /// y.
    template <class T>
    struct Coefficients {
        std::vector<T> x, y, w, dx, dy;
    };
    template <class T>
    const Coefficients<T>& coefficients() const;
    /// x and y over an interval of parameters.
    template <class T>
    std::pair<T, T> at(const T& t) const;

private:
    std::vector<Eigen::Vector3d> points_;
    Coefficients<Interval> rough_;
    Coefficients<Wide> fine_;
    std::vector<BernsteinRoot> turns_;
    bool starts_rightward_ = true;
};

/// The part of a Bezier curve between two neighbouring ones of 0, its turns and 1.
struct BezierGraph {
    std::shared_ptr<const RationalBezier> curve;
    BernsteinRoot first, last;  ///< ascending parameters
    bool rightward = true;      ///< does x increase with the parameter?

    template <class T>
    T y(const T& x) const;
    template <class T>
    Direction<T> direction(const T& x) const;

private:
    template <class T>
    T parameter(const T& x) const;
};

/// The place of a traced curve with x = h(y) where it turns back in x, or where it meets y = const.
/// Refined once, when asked for.
class TracedTurn {
public:
    /// Within the box, g_x has no zero, and g_y has one along the curve, where it changes its sign.
    TracedTurn(std::shared_ptr<const DefiningFunction> g, Interval box_x, Interval box_y);
    /// The place where the curve meets y.
    TracedTurn(std::shared_ptr<const DefiningFunction> g, Interval box_x, double y);
    template <class T>
    std::pair<T, T> enclosure() const;

private:
    template <class T>
    std::pair<T, T> compute() const;

    std::shared_ptr<const DefiningFunction> g_;
    Interval box_x_, box_y_;  // box_y_ is a point where the curve is cut at y
    std::pair<Interval, Interval> rough_;
    mutable std::optional<std::pair<Wide, Wide>> fine_;
};

/// A curve {g = 0} that has been traced: a fitted spline and the radius of a band about it.
///
/// Of {g = 0} the band holds exactly one simple arc, which runs along the spline from end to end (a closed
/// spline, whose ends are equal: one simple closed curve). g is smooth with non-zero gradient on it. The
/// spline says only where to look: every piece of the curve is proved anew from g.
struct TracedCurve {
    RationalCurve2 spline;
    double band = 0;  ///< chart units
    std::shared_ptr<const DefiningFunction> g;
};

/// Part of a traced curve: a row of cells from left to right.
struct TracedGraph {
    /// Over x in [x0, x1] the graph lies within `y`, and there the sign of g is -above below and `above`
    /// above it.
    struct Cell {
        double x0, x1;
        Interval y;
        Sign above;
        std::shared_ptr<const TracedTurn> lower_end,
            upper_end;  ///< where one of the ends of y is that of a turn
        // The band: y is within `band` of y0 + slope (x - x0).
        double y0 = 0, slope = 0, band = 0;
    };
    std::shared_ptr<const DefiningFunction> g;
    std::vector<Cell> cells;

    template <class T>
    T y(const T& x) const;
    template <class T>
    Direction<T> direction(const T& x) const;
    /// By the bands alone, without g.
    Interval rough_y(const Interval& x) const;
    /// Is every point of {g = 0} in the box x * y sure to be one of the graph?
    bool holds_alone(const Interval& x, const Interval& y) const;

private:
    template <class T>
    T y_in(const Cell& cell, const T& x) const;
};

/// An end of a piece of a traced curve: where it meets that x, or that turn.
using TracedEnd = std::variant<double, std::shared_ptr<const TracedTurn>>;

/// Part of a traced curve from one turn or end to the next, and its ends; equal pointers: the same place.
struct TracedPiece {
    TracedGraph graph;
    TracedEnd left, right;
};

/// The x-monotone pieces of a traced curve, in its direction. Turns are found with proof: within a box where
/// g_x has no zero, the derivative of g_y along the curve has none either, and g_y changes its sign. Throws
/// InputError (Unsupported) where the band is too wide to tell how the curve runs in it, and where the curve
/// has a vertical inflection.
std::vector<TracedPiece> cut_traced_curve(const TracedCurve& curve);

/// Any of them.
class MonotoneGraph {
public:
    using Shape = std::variant<CircularGraph, BezierGraph, TracedGraph>;
    explicit MonotoneGraph(Shape shape) : shape_(std::move(shape)) {}

    /// y over the part of x that lies in the graph's range (there must be one).
    template <class T>
    T y(const T& x) const {
        return std::visit([&](const auto& s) { return s.template y<T>(x); }, shape_);
    }
    /// The directions over the part of x that lies in the graph's range.
    template <class T>
    Direction<T> direction(const T& x) const {
        return std::visit([&](const auto& s) { return s.template direction<T>(x); }, shape_);
    }
    const Shape& shape() const { return shape_; }

private:
    Shape shape_;
};

}  // namespace vcell
