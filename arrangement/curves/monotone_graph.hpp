/// x-monotone pieces of curves as functions y(x), evaluated over intervals on both rungs of the ladder.
///
/// All decisions on curves of mixed kinds rest on these evaluations: whatever a curve is given by
/// (coefficients, control points), an enclosure of y and of the direction of travel over any interval of x is
/// all that the arrangement asks of it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "../../core/curves/bernstein.hpp"
#include "../../core/curves/circular_form.hpp"
#include "../../core/numbers/enclosure.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/wide.hpp"

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

/// Any of them.
class MonotoneGraph {
public:
    using Shape = std::variant<CircularGraph, BezierGraph>;
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
