/// The base's own frame, and curves in it: a plane is z = 0 seen from above, a sphere's centre is the origin,
/// a cylinder's axis is that of z; the unit of length is a power of two of the box.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "../../envelope/cell.hpp"
#include "disc.hpp"

namespace vcell::check {

template <class T>
using Triad = std::array<T, 3>;

/// World coordinates to the base's frame.
class Frame {
public:
    explicit Frame(const Scene& scene);

    Triad<Interval> point(const Vec3& p) const;
    Triad<Interval> point(const Triad<Interval>& p) const;
    /// About where that is: to a few roundings of the numbers of p and of the frame's origin.
    Triad<double> about(const Vec3& p) const;
    Triad<Interval> direction(const Vec3& d) const;  ///< keeps its length
    Triad<Interval> direction(const Triad<Interval>& d) const { return turned(d); }
    /// From one point to another near by: as exact as it is short.
    Triad<MidRad> way(const Vec3& from, const Vec3& to) const;
    Interval length(double x) const;
    double unit() const { return unit_; }
    Interval radius() const { return radius_; }
    bool is_about_axis() const { return is_about_axis_; }  ///< of a cylinder

private:
    Triad<Interval> turned(const Triad<Interval>& d) const;

    Vec3 origin_;
    std::optional<std::array<Triad<Interval>, 3>> rows_;  // none: the world's directions
    double unit_;                                         // a power of two
    Interval radius_;
    bool is_about_axis_ = false;
};

/// A point of a rational curve in homogeneous coordinates relative to a nearby origin (w (x - origin), w),
/// and their derivatives. Relative: where coordinates are large for the curve, the bounds of w x and of w
/// would not know of each other.
template <class T>
struct Place {
    Triad<T> n, dn;
    T w, dw;
    Triad<double> origin;

    /// Not relative.
    Triad<T> whole() const { return {n[0] + origin[0] * w, n[1] + origin[1] * w, n[2] + origin[2] * w}; }
    Triad<T> whole_derivative() const {
        return {dn[0] + origin[0] * dw, dn[1] + origin[1] * dw, dn[2] + origin[2] * dw};
    }
};

/// A polynomial piece of a space curve in the frame, by its Taylor coefficients about its middle: s in [-1,
/// 1].
struct Span {
    SmallVector<std::array<MidRad, 4>, 4> coefficients;
    Triad<double> origin;

    std::size_t degree() const { return coefficients.size() - 1; }
    template <class T>
    Place<T> at(const T& s) const {
        const std::size_t d = coefficients.size() - 1;
        std::array<T, 4> p, q;
        for (std::size_t i = 0; i < 4; ++i) {
            T value(coefficients[d][i]), slope(coefficients[d][i] * static_cast<double>(d));
            for (std::size_t k = d; k-- > 0;) {
                value = value * s + T(coefficients[k][i]);
                if (k > 0) slope = slope * s + T(coefficients[k][i] * static_cast<double>(k));
            }
            p[i] = value;
            q[i] = slope;
        }
        return {{p[0], p[1], p[2]}, {q[0], q[1], q[2]}, p[3], q[3], origin};
    }

    /// What points have along a direction, not relative, times w: coefficients of their own, as of a piece
    /// that all but lies in a plane across it coordinates would cancel at each s anew.
    SmallVector<MidRad, 6> along(const Triad<MidRad>& direction) const {
        const MidRad at_origin =
            direction[0] * origin[0] + direction[1] * origin[1] + direction[2] * origin[2];
        SmallVector<MidRad, 6> result;
        for (const auto& c : coefficients)
            result.push_back(direction[0] * c[0] + direction[1] * c[1] + direction[2] * c[2] +
                             at_origin * c[3]);
        return result;
    }
};
template <class T>
T polynomial(std::span<const MidRad> coefficients, const T& s) {
    T value(coefficients.back());
    for (std::size_t k = coefficients.size() - 1; k-- > 0;) value = value * s + T(coefficients[k]);
    return value;
}
std::vector<Span> spans(const RationalCurve3& curve, const Frame& frame);

}  // namespace vcell::check
