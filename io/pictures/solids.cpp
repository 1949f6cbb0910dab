#include "solids.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <variant>

namespace vcell {

namespace {

using Polygon = std::vector<Corner>;

Polygon clipped(const Polygon& polygon, const Plane& plane) {
    Polygon inside;
    const auto height = [&](const Corner& c) { return plane.normal.dot(c.point - plane.point); };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Corner &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double v = height(p), w = height(q);
        if (v >= 0) inside.push_back(p);
        if ((v < 0) == (w < 0)) continue;
        const double t = v / (v - w);
        inside.push_back({p.point + t * (q.point - p.point), p.normal + t * (q.normal - p.normal)});
    }
    return inside;
}

constexpr std::size_t around = 48;  // corners of a circle

// Triangles between corner(i, j) of rows 0 to `rows` and columns 0 to `columns`.
template <class F>
std::vector<CornerTriangle> grid(std::size_t rows, std::size_t columns, F corner) {
    std::vector<CornerTriangle> triangles;
    for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < columns; ++j) {
            const Corner a = corner(i, j), b = corner(i, j + 1), c = corner(i + 1, j),
                         d = corner(i + 1, j + 1);
            triangles.push_back({a, c, b});
            triangles.push_back({b, c, d});
        }
    return triangles;
}

double angle(std::size_t step) {
    return 2 * std::numbers::pi * static_cast<double>(step) / static_cast<double>(around);
}

std::vector<CornerTriangle> sphere(const Vec3& center, double radius) {
    return grid(around / 2, around, [&](std::size_t i, std::size_t j) {
        const Vec3 n(std::sin(angle(i)) * std::cos(angle(j)), std::sin(angle(i)) * std::sin(angle(j)),
                     std::cos(angle(i)));
        return Corner{center + radius * n, n};
    });
}

// As far as the box may reach from the axis's point that is nearest to its middle.
std::vector<CornerTriangle> tube(const Vec3& point, const Vec3& direction, double radius, const Box& box) {
    const Vec3 axis = direction.stableNormalized(), x = axis.unitOrthogonal(), y = axis.cross(x);
    const Vec3 middle = 0.5 * (box.min + box.max), foot = point + axis.dot(middle - point) * axis;
    return grid(1, around, [&](std::size_t i, std::size_t j) {
        const Vec3 n = std::cos(angle(j)) * x + std::sin(angle(j)) * y;
        return Corner{foot + (i == 0 ? -1 : 1) * box.diagonal() * axis + radius * n, n};
    });
}

// As far as the box may reach from the apex.
std::vector<CornerTriangle> cone(const HollowCone& o, const Box& box) {
    const Vec3 axis = o.axis.stableNormalized(), x = axis.unitOrthogonal(), y = axis.cross(x);
    const double far = (0.5 * (box.min + box.max) - o.apex).norm() + box.diagonal();
    return grid(1, around, [&](std::size_t i, std::size_t j) {
        const Vec3 out = std::cos(angle(j)) * x + std::sin(angle(j)) * y;
        return Corner{o.apex + (i == 0 ? 0 : far) * (axis + o.sine() / o.cosine() * out),
                      o.cosine() * out - o.sine() * axis};
    });
}

std::vector<CornerTriangle> plane(const Plane& plane, const Box& box) {
    const Vec3 normal = plane.normal.stableNormalized(), x = normal.unitOrthogonal(), y = normal.cross(x);
    const Vec3 middle = 0.5 * (box.min + box.max), foot = middle - normal.dot(middle - plane.point) * normal;
    return grid(1, 1, [&](std::size_t i, std::size_t j) {
        const double reach = box.diagonal();
        return Corner{foot + (i == 0 ? -reach : reach) * x + (j == 0 ? -reach : reach) * y, normal};
    });
}

}  // namespace

std::vector<CornerTriangle> clipped(std::span<const CornerTriangle> triangles,
                                    std::span<const Plane> planes) {
    std::vector<CornerTriangle> result;
    for (const CornerTriangle& triangle : triangles) {
        Polygon polygon(triangle.begin(), triangle.end());
        for (const Plane& plane : planes) polygon = clipped(polygon, plane);
        for (std::size_t i = 2; i < polygon.size(); ++i)
            result.push_back({polygon[0], polygon[i - 1], polygon[i]});
    }
    return result;
}

std::array<Plane, 6> sides_of(const Box& box) {
    std::array<Plane, 6> sides;
    for (int k = 0; k < 3; ++k) {
        sides[static_cast<std::size_t>(2 * k)] = {box.min, Vec3::Unit(k)};
        sides[static_cast<std::size_t>(2 * k + 1)] = {box.max, -Vec3::Unit(k)};
    }
    return sides;
}

std::vector<CornerTriangle> surface_of(const Object& object, const Box& box) {
    struct Visitor {
        const Box& box;
        std::vector<CornerTriangle> operator()(const Plane& p) const { return in_box(plane(p, box)); }
        std::vector<CornerTriangle> operator()(const Sphere& s) const { return sphere(s.center, s.radius); }
        std::vector<CornerTriangle> operator()(const Cylinder& c) const {
            return in_box(tube(c.point, c.axis, c.radius, box));
        }
        std::vector<CornerTriangle> operator()(const HollowSphere& s) const {
            return in_box(sphere(s.center, s.radius));
        }
        std::vector<CornerTriangle> operator()(const HollowCylinder& c) const {
            return in_box(tube(c.point, c.axis, c.radius, box));
        }
        std::vector<CornerTriangle> operator()(const HollowCone& c) const { return in_box(cone(c, box)); }
        std::vector<CornerTriangle> in_box(const std::vector<CornerTriangle>& triangles) const {
            return clipped(triangles, sides_of(box));
        }
    };
    return std::visit(Visitor{box}, object);
}

}  // namespace vcell
