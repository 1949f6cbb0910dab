#include "radial_base.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <variant>

#include "../forms/crossing.hpp"
#include "cylinder_base.hpp"
#include "sphere_base.hpp"

namespace vcell {

void FormSites::settle() {
    if (joined_.empty()) return;
    for (const FormId f : ids())
        for (const Site site : (*this)[f]) joined_.emplace_back(f, site);
    std::ranges::sort(joined_);
    sites_.clear();
    begins_.assign(begins_.size(), 0);
    for (const auto& [form, site] : joined_) {
        sites_.push_back(site);
        ++begins_[form.value + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    joined_.clear();
}

RadialBaseProblem radial_base_problem(const Scene& scene, double unit) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.base))
        return sphere_base_problem(scene, *sphere, unit);
    return cylinder_base_problem(scene, std::get<Cylinder>(scene.base), unit);
}

Vec3 RadialBaseProblem::normal(const Vec2& p) const {
    if (is_sphere) {
        const double r2 = p.squaredNorm();
        if (r2 <= 1) return chart * Vec3(2 * p.x(), 2 * p.y(), 1 - r2) / (1 + r2);
        const Vec2 q = p / r2;
        const double s2 = q.squaredNorm();
        return chart * Vec3(2 * q.x(), 2 * q.y(), s2 - 1) / (1 + s2);
    }
    const bool front = p.x() <= 1;
    const double x = front ? p.x() : p.x() - 2, w = front ? 1 + x * x : -(1 + x * x);
    return chart * Vec3(2 * x / w, 0, (1 - x * x) / w);
}

Vec2 RadialBaseProblem::chart_point(const Vec3& normal, double y) const {
    if (is_sphere) {
        const Vec3 v = chart.transpose() * normal;
        if (v.z() >= 0) return v.head<2>() / (1 + v.z());
        return v.head<2>() * (1 - v.z()) / v.head<2>().squaredNorm();
    }
    // The tangent of half the angle about (0, 0, 1) or (0, 0, -1) of the chart; (-1, 0, 0) is x = -1, not 3.
    const Vec3 v = chart.transpose() * normal;
    const double s = v.x(), c = v.z();
    const double x = c >= 0 ? s / (1 + c) : 2 - s / (1 - c);
    return {x < 3 ? x : -1, y};
}

bool RadialBaseProblem::cross_equally(FormId f, FormId g) const {
    const auto* first = std::get_if<Cylinder>(&objects[f]);
    const auto* second = std::get_if<Cylinder>(&objects[g]);
    if (first == nullptr || second == nullptr) return false;
    // Doubles see at once that axes pass each other by more than this part of the terms, far above their
    // rounding.
    constexpr double certainly_apart = 0x1p-30;
    const Vec3 between = second->point - first->point, normal = first->axis.cross(second->axis);
    const double size =
        first->axis.norm() * second->axis.norm() * (first->point.norm() + second->point.norm());
    if (!(std::abs(between.dot(normal)) <= certainly_apart * size)) return false;
    return equal_crossing(family, f, g).has_value();
}

double RadialBaseProblem::distance(const Vec2& p, double f) const {
    const double x = is_sphere || p.x() <= 1 ? p.x() : p.x() - 2;
    return (1 + x * x + (is_sphere ? p.y() * p.y() : 0.0)) / -f;
}

}  // namespace vcell
