/// How points of a chart name points of a base, over every base: (x, y) has a foot f and a unit normal u, and
/// what is met at distance t from the foot is f + t u. In coordinates of the chart's own
///
///     plane      f = (x, y, 0)   u = (0, 0, 1)    the base plane is z = 0
///     sphere     f = 0           u = n / W,  n = (2x, 2y, 1 - x^2 - y^2),  W = 1 + x^2 + y^2
///     cylinder   f = (0, y, 0)   u = n / W,  n = (2x, 0, 1 - x^2),         W = 1 + x^2
///
/// The chart of a sphere is stereographic, without u = (0, 0, -1). Over a cylinder x in [-1, 1] is the
/// tangent of half the angle about (0, 0, 1), and [1, 3] that about (0, 0, -1) plus 2: once around.
///
/// The kind of base is asked for here, and where forms are made and evaluated (primitives/bases and forms);
/// everybody else asks for what follows from it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "../../core/numbers/sign.hpp"
#include "../objects/objects.hpp"

namespace vcell {

enum class BaseShape : std::uint8_t { Plane, Sphere, Cylinder };

/// Lengths along one coordinate in the base's metric: over a sphere dx / (1 + x^2 + y^2) for one y.
struct ChartLength {
    double a = 0;  ///< sqrt(1 + y^2); 0: x itself

    double at(double x) const { return a > 0 ? std::atan(x / a) / a : x; }
    double inverse(double length) const { return a > 0 ? a * std::tan(a * length) : length; }
};

class Chart {
public:
    constexpr Chart(BaseShape kind = BaseShape::Plane) : kind_(kind) {}

    bool is_plane() const { return kind_ == BaseShape::Plane; }
    bool is_sphere() const { return kind_ == BaseShape::Sphere; }
    bool is_cylinder() const { return kind_ == BaseShape::Cylinder; }

    template <class T>
    std::array<T, 3> foot(const T& x, const T& y) const {
        return {is_plane() ? x : T(0.0), is_sphere() ? T(0.0) : y, T(0.0)};
    }
    Vec3 foot(const Vec2& q) const { return {is_plane() ? q.x() : 0, is_sphere() ? 0 : q.y(), 0}; }
    /// The foot below a point, whose y is the foot's own as far as it has one.
    Vec3 foot_below(const Vec3& p) const { return foot(p.head<2>()); }
    /// What of y counts as distance from the foot around a curved base, and the foot's own y.
    double across(double y) const { return is_sphere() ? y : 0.0; }
    double along(double y) const { return is_sphere() ? 0.0 : y; }
    /// How far a point is from its foot.
    double distance(const Vec3& p) const {
        return is_plane() ? p.z() : is_sphere() ? p.norm() : std::hypot(p.x(), p.z());
    }
    template <class T>
    T distance(const std::array<T, 3>& p) const {
        if (is_plane()) return p[2];
        return is_sphere() ? sqrt(square(p[0]) + square(p[1]) + square(p[2]))
                           : sqrt(square(p[0]) + square(p[2]));
    }

    /// Is x in the second half of a chart that goes around?
    bool is_back(double x) const { return is_cylinder() && x > seam; }
    /// W over a place in the first half or in the second.
    template <class T>
    T weight(const T& x, const T& y, bool is_back) const {
        if (is_plane()) return T(1.0);
        if (is_sphere()) return T(1.0) + square(x) + square(y);
        return T(1.0) + square(is_back ? x - T(2.0) : x);
    }
    /// u, likewise.
    template <class T>
    std::array<T, 3> normal(const T& x, const T& y, bool is_back) const {
        const T zero(0.0), one(1.0), two(2.0);
        if (is_plane()) return {zero, zero, one};
        const T a = is_back ? x - two : x;
        const T squares = is_sphere() ? square(a) + square(y) : square(a), W = one + squares;
        const std::array<T, 3> n{two * a / W, is_sphere() ? two * y / W : zero, (one - squares) / W};
        return is_back ? std::array<T, 3>{-n[0], -n[1], -n[2]} : n;
    }
    /// The chart point below p, without cancellation; y counts in `unit` where it is a length of its own.
    template <class T>
    std::array<T, 2> chart_point(const std::array<T, 3>& p, double unit) const {
        if (is_plane()) return {p[0], p[1]};
        const T r = distance(p);
        const bool is_ahead = p[2].mid() >= 0;
        if (is_sphere()) {
            if (is_ahead) return {p[0] / (r + p[2]), p[1] / (r + p[2])};
            const T scale = (r - p[2]) / (square(p[0]) + square(p[1]));
            return {p[0] * scale, p[1] * scale};
        }
        const T y = p[1] / T(unit);
        if (is_ahead) return {p[0] / (r + p[2]), y};
        return {T(2.0) - p[0] / (r - p[2]), y};
    }

    /// The sign of the heights at which something is met: clearances over a plane, elsewhere -W / t.
    Sign sign_of_met() const { return is_plane() ? Sign::Positive : Sign::Negative; }
    /// The unit that the chart's coordinates are in, where lengths are in this one.
    double unit_of_coordinates(double unit) const { return is_plane() ? unit : 1; }
    /// The tangent of half the angle between the normal and that in the middle of its half; W = 1 + its
    /// square.
    double half_tangent(const Vec2& p) const {
        return is_plane() ? 0 : is_sphere() ? p.norm() : std::abs(is_back(p.x()) ? p.x() - 2 : p.x());
    }

    /// How long the chart is once around; infinite where it does not close up.
    double circumference() const { return is_cylinder() ? around : std::numeric_limits<double>::infinity(); }
    /// Where two halves meet over each of which foot and normal are smooth.
    std::optional<double> smooth_seam() const { return is_cylinder() ? std::optional(seam) : std::nullopt; }
    /// Names a place by the coordinates nearest to a box, which may reach beyond the chart's range.
    Vec2 continued(Vec2 q, const std::array<double, 4>& box) const {
        if (!is_cylinder()) return q;
        const double middle = 0.5 * (box[0] + box[1]);
        if (q.x() - middle > around / 2) q.x() -= around;
        if (middle - q.x() > around / 2) q.x() += around;
        return q;
    }
    /// A box over which foot and normal are smooth.
    struct Part {
        std::array<double, 4> box;
        bool is_back = false;
    };
    /// Calls f with parts that make up the box.
    template <class F>
    void for_parts(const std::array<double, 4>& box, F&& f) const {
        const auto& [x0, x1, y0, y1] = box;
        if (!is_back(x1)) return f(Part{box});
        if (x0 < seam) f(Part{{x0, seam, y0, y1}});
        f(Part{{std::max(x0, seam), x1, y0, y1}, true});
    }

    /// Lengths along one coordinate where the other is between these.
    ChartLength lengths(double from, double to) const {
        if (!is_sphere()) return {};
        const double other = std::max({0.0, from, -to});
        return {std::sqrt(1 + other * other)};
    }

private:
    static constexpr double seam = 1, around = 4;

    BaseShape kind_;
};

/// The chart of a base in canonical position: the base's radius, and how the chart is turned about the base.
struct BaseChart : Chart {
    using Chart::chart_point;

    double radius = 0;  ///< R0; 0 of a plane
    /// Coordinates of the chart's own to canonical ones. A rational rotation (of a cylinder about its axis),
    /// exact in the forms, rounded here.
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();

    /// The unit normal at a chart point. On a cylinder x may be any number of [-1, 3].
    Vec3 normal(const Vec2& p) const;
    /// Its derivative in a direction d.
    Vec3 normal_derivative(const Vec2& p, const Vec2& d) const;
    /// The same over a part of the chart, in a number type that has a ball; `slack` bounds its rounding.
    template <class T>
    std::array<T, 3> normal(const T& x, const T& y, bool is_back, const T& slack) const {
        if (is_plane()) return Chart::normal(x, y, is_back);
        const std::array<T, 3> n = Chart::normal(x, y, is_back);
        std::array<T, 3> u;
        for (int i = 0; i < 3; ++i)
            u[i] = slack + (turn(i, 0) * n[0] + turn(i, 1) * n[1] + turn(i, 2) * n[2]);
        return u;
    }
    /// The chart point of a unit normal (sphere; not the pole), or of a normal and a height (cylinder).
    Vec2 chart_point(const Vec3& normal, double y) const;
    /// A point with its distance from its foot, and the chart point below it.
    Eigen::Vector4d with_distance(const Vec3& p) const { return {p.x(), p.y(), p.z(), distance(p)}; }
    Vec2 chart_point(const Eigen::Vector4d& X) const {
        if (is_plane()) return X.head<2>();
        return chart_point((X.head<3>() - foot_below(X.head<3>())) / X[3], X.y());
    }
    /// How far the chart point of what is within `slack` of X may be from q, that of X as rounded.
    double chart_error(const Eigen::Vector4d& X, const Vec2& q, double slack, double rounding) const {
        if (is_plane()) return slack + rounding * q.norm();
        return (slack / std::min(X[3], 1.0) + rounding) * (1 + q.squaredNorm());
    }
    /// W / -f: the distance from the foot at which a form of value f < 0 is met. Over a plane f itself.
    double distance_of(const Vec2& p, double f) const;
    /// The canonical point over a chart point at distance t from its foot, and that of the base.
    Vec3 point(const Vec2& p, double t) const { return t * normal(p) + foot(p); }
    Vec3 base_point(const Vec2& p) const { return point(p, radius); }
};

}  // namespace vcell
