/// A base as the fit in space (space_spline.hpp) sees it: its equation, its chart's foot points and normals,
/// and those of the sites that are met along them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/fit/arc_equations.hpp"
#include "space_arc.hpp"

namespace vcell::space_fit {

using Vector3i = std::array<Interval, 3>;

class SpaceChart {
public:
    /// The chart of the base plane z = 0 is the plane itself.
    SpaceChart() = default;
    explicit SpaceChart(const RadialBaseProblem& problem)
        : kind_(problem.is_sphere ? Kind::Sphere : Kind::Cylinder), problem_(&problem) {}

    /// The foot point of canonical points: in the base plane, in the centre or on the axis.
    Vec3 foot_below(const Vec3& p) const { return foot(p.head<2>()); }
    /// (p, t) for a point of the arc.
    Vector4d with_distance(const Vec3& p) const;

    /// Pre: `foot` is a foot point near the curve.
    Equation base_equation(const Vec3& foot) const;
    Equation equation(const SpaceSite& site, const Vec3& foot) const;

    // ---- Over chart points q ----
    Vec3 foot(const Vec2& q) const { return {is_plane() ? q.x() : 0, kind_ == Kind::Sphere ? 0 : q.y(), 0}; }
    Vec3 normal(const Vec2& q) const { return is_plane() ? Vec3::UnitZ() : problem_->normal(q); }
    /// Their derivatives in a direction d.
    Vec3 foot_derivative(const Vec2& d) const { return foot(d); }
    Vec3 normal_derivative(const Vec2& q, const Vec2& d) const;
    /// The chart point below (p, t).
    Vec2 chart_point(const Vector4d& X) const {
        if (is_plane()) return X.head<2>();
        return problem_->chart_point((X.head<3>() - foot_below(X.head<3>())) / X[3], X.y());
    }
    /// How far chart_point() of a point within `slack` of X may be from q, that of X.
    double chart_error(const Vector4d& X, const Vec2& q, double slack) const {
        if (is_plane()) return slack + rounding * q.norm();
        return (slack / std::min(X[3], 1.0) + rounding) * (1 + q.squaredNorm());
    }
    /// Names a place of the chart, which may close up, by the coordinates nearest to a box {x0, x1, y0, y1}:
    /// pieces are continued beyond the chart's own range.
    Vec2 continued(Vec2 q, const std::array<double, 4>& box) const;

    // ---- Over boxes of the chart, coordinates in Interval or Jets of them ----
    /// A box {x0, x1, y0, y1} over which foot and normal are smooth: around a cylinder in one half.
    struct Part {
        std::array<double, 4> box;
        bool is_back = false;  ///< in the second half
    };
    /// Calls f with parts that make up the box.
    template <class F>
    void for_parts(const std::array<double, 4>& box, F&& f) const {
        const auto& [x0, x1, y0, y1] = box;
        if (kind_ != Kind::Cylinder || x1 <= 1) return f(Part{box});
        if (x0 < 1) f(Part{{x0, 1, y0, y1}});
        f(Part{{std::max(x0, 1.0), x1, y0, y1}, true});
    }
    template <class T>
    std::array<T, 3> foot(const T& x, const T& y) const {
        return {is_plane() ? x : T(0.0), kind_ == Kind::Sphere ? T(0.0) : y, T(0.0)};
    }
    template <class T>
    std::array<T, 3> normal(const T& x, const T& y, bool is_back) const {
        if (is_plane()) return {T(0.0), T(0.0), T(1.0)};
        const T a = is_back ? x - T(2.0) : x, one(1.0), two(2.0);
        const bool is_sphere = kind_ == Kind::Sphere;
        const T squares = is_sphere ? square(a) + square(y) : square(a), W = one + squares;
        const std::array<T, 3> n{two * a / W, is_sphere ? two * y / W : T(0.0), (one - squares) / W};
        std::array<T, 3> u;
        for (int i = 0; i < 3; ++i) {
            const T sum = dot<T>(problem_->chart.row(i), n);
            u[i] = T(Interval::ball(0, rounding)) + (is_back ? -sum : sum);
        }
        return u;
    }

private:
    enum class Kind { Plane, Sphere, Cylinder };

    bool is_plane() const { return kind_ == Kind::Plane; }
    double radius() const { return is_plane() ? 0 : problem_->radius; }

    Kind kind_ = Kind::Plane;
    const RadialBaseProblem* problem_ = nullptr;
};

}  // namespace vcell::space_fit
