#include "check_patches.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace vcell::check {

namespace {

/// How far (u, v) moves at most per length on the surface.
double parameters_per_length(const SurfacePoint& s) {
    return (s.pu.norm() + s.pv.norm()) / s.pu.cross(s.pv).norm();
}

/// Damped: patches that reach far out turn fast in some part of their rectangle.
std::optional<Vec2> newton(const Patch& patch, const Ray& ray, const SceneGeometry& geometry, Vec2 uv) {
    const Vec2 extent = patch.hi - patch.lo;
    auto aside = geometry.aside(ray, lift(patch, uv));
    for (int k = 0; aside && k < 50; ++k) {
        const Vec2 step = aside->derivative.inverse() * aside->value;
        if (!step.allFinite()) return std::nullopt;
        if (step.norm() <= kNearEdge * 1e-2 * extent.norm()) return uv - step;
        constexpr double kLeast = 1e-3;
        double damping = 1;
        for (; damping > kLeast; damping *= 0.5) {
            const Vec2 next = uv - damping * step;
            if ((next - patch.lo).minCoeff() < -extent.norm() ||
                (patch.hi - next).minCoeff() < -extent.norm())
                continue;
            const auto there = geometry.aside(ray, lift(patch, next));
            if (!there || !(there->value.norm() < aside->value.norm())) continue;
            uv = next;
            aside = there;
            break;
        }
        // Not even a short step gets nearer: there is no such point, or only rounding left.
        if (damping <= kLeast) {
            const double noise = parameters_per_length(lift(patch, uv)) * geometry.rounding();
            return step.norm() <= kNearEdge * extent.norm() + noise ? std::optional(uv) : std::nullopt;
        }
    }
    return std::nullopt;
}

}  // namespace

std::optional<bool> inside(const Patch& patch, const Vec2& uv, double rounding) {
    if ((uv.array() < patch.lo.array()).any() || (uv.array() > patch.hi.array()).any()) return false;
    const double nearest = kNearEdge * (patch.hi - patch.lo).maxCoeff();
    const double rate = parameters_per_length(lift(patch, uv));
    double total = 0;
    for (const auto& loop : patch.loops)
        for (const Trim& trim : loop) {
            const double near = nearest + rate * (trim.error + rounding);
            for (const auto& piece : trim.pieces) {
                const auto angle = swept(piece, uv, near);
                if (!angle) return std::nullopt;
                total += *angle;
            }
        }
    return std::lround(total / (2 * std::numbers::pi)) == 1;
}

std::optional<Vec2> parameters(const Patch& patch, const Ray& ray, const SceneGeometry& geometry) {
    std::vector<std::pair<double, Vec2>> starts;
    for (const auto* points : {&patch.grid, &patch.boundary})
        for (const auto& point : *points)
            if (const auto aside = geometry.aside(ray, point.surface))
                starts.push_back({aside->value.norm(), point.uv});
    constexpr std::size_t kStarts = 4;
    const std::size_t count = std::min(kStarts, starts.size());
    std::partial_sort(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(count), starts.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < count; ++i)
        if (const auto uv = newton(patch, ray, geometry, starts[i].second)) return uv;
    return std::nullopt;
}

}  // namespace vcell::check
