#include "bisector_names.hpp"

#include <array>
#include <cmath>
#include <variant>

#include "../../core/numbers/exact.hpp"
#include "scene.hpp"

namespace vcell::check {
namespace {

// Both ask directions as they are written, exactly.
bool are_orthogonal(const Vec3& a, const Vec3& b) {
    return (Exact(a.x()) * b.x() + Exact(a.y()) * b.y() + Exact(a.z()) * b.z()).sign() == Sign::Zero;
}
bool are_parallel(const Vec3& a, const Vec3& b) {
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if ((Exact(a[i]) * b[j] - Exact(a[j]) * b[i]).sign() != Sign::Zero) return false;
    }
    return true;
}

// The points whose distance from a line equals that from the plane shifted by the radius.
const char* name_of_plane_and_tube(const Vec3& normal, const Vec3& axis) {
    return are_orthogonal(axis, normal) ? "parabolic cylinder"
           : are_parallel(axis, normal) ? "circular cone"
                                        : "elliptic cone";
}

// A line of the wall is parallel to the plane where the axis leans from it as much as the wall does.
std::vector<std::string> names_of_plane_and_cone(const Vec3& normal, const HollowCone& cone) {
    if (are_parallel(cone.axis, normal)) return {"circular cone"};
    const double lean = normal.normalized().dot(cone.axis.normalized()) - cone.sine();
    if (std::abs(lean) <= kRounding) return {"parabolic cylinder", "elliptic cone"};
    return {"elliptic cone"};
}

std::vector<std::string> names_about(const Plane& base, const Object& o) {
    if (std::holds_alternative<Plane>(o)) return {"plane"};
    if (std::holds_alternative<Sphere>(o) || std::holds_alternative<HollowSphere>(o)) return {"paraboloid"};
    if (const auto* vessel = std::get_if<HollowCylinder>(&o))
        return {name_of_plane_and_tube(base.normal, vessel->axis)};
    if (const auto* vessel = std::get_if<HollowCone>(&o))
        return names_of_plane_and_cone(base.normal, *vessel);
    return {name_of_plane_and_tube(base.normal, std::get<Cylinder>(o).axis)};
}

std::vector<std::string> names_about(const Sphere& base, const Object& o) {
    if (std::holds_alternative<Plane>(o)) return {"paraboloid"};
    if (const auto* sphere = std::get_if<Sphere>(&o))
        return {sphere->radius == base.radius ? "plane" : "hyperboloid"};
    if (const auto* vessel = std::get_if<HollowSphere>(&o))
        return {vessel->center == base.center ? "sphere" : "ellipsoid"};
    if (std::holds_alternative<HollowCylinder>(o) || std::holds_alternative<HollowCone>(o))
        return {"quartic"};
    return {std::get<Cylinder>(o).radius == base.radius ? "parabolic cylinder" : "quartic"};
}

std::vector<std::string> names_about(const Cylinder& base, const Object& o, double scale) {
    const Vec3 along = base.axis.normalized();
    if (const auto* plane = std::get_if<Plane>(&o)) {
        std::vector<std::string> names{name_of_plane_and_tube(plane->normal, base.axis)};
        // The base's axis may have turned by its rounding.
        const Vec3 normal = plane->normal.normalized();
        if (std::abs(normal.dot(along)) <= kRounding)
            names.insert(names.end(), {"parabolic cylinder", "elliptic cone"});
        if (normal.cross(along).norm() <= kRounding)
            names.insert(names.end(), {"circular cone", "elliptic cone"});
        return names;
    }
    if (const auto* sphere = std::get_if<Sphere>(&o))
        return {sphere->radius == base.radius ? "parabolic cylinder" : "quartic"};
    if (std::holds_alternative<HollowSphere>(o)) return {"quartic"};
    // Does the base's axis run through the point?
    const auto is_on_axis = [&](const Vec3& point) {
        std::array<Exact, 3> way;
        for (int i = 0; i < 3; ++i) way[static_cast<std::size_t>(i)] = Exact(point[i]) - Exact(base.point[i]);
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            const auto &a = base.axis[static_cast<int>(i)], &b = base.axis[static_cast<int>(j)];
            if ((way[i] * b - way[j] * a).sign() != Sign::Zero) return false;
        }
        return true;
    };
    if (const auto* vessel = std::get_if<HollowCylinder>(&o)) {
        std::vector<std::string> names;
        if (along.cross(vessel->axis.normalized()).norm() <= kRounding)
            names.push_back(is_on_axis(vessel->point) ? "circular cylinder" : "elliptic cylinder");
        if (!are_parallel(base.axis, vessel->axis)) names.emplace_back("quartic");
        return names;
    }
    if (const auto* cone = std::get_if<HollowCone>(&o))
        return {are_parallel(base.axis, cone->axis) && is_on_axis(cone->apex) ? "circular cone" : "quartic"};
    const auto& cylinder = std::get<Cylinder>(o);
    const bool equal = cylinder.radius == base.radius;
    const Vec3 turn = along.cross(cylinder.axis.normalized());
    std::vector<std::string> names;
    if (turn.norm() <= kRounding) names.push_back(equal ? "plane" : "hyperbolic cylinder");
    if (are_parallel(base.axis, cylinder.axis)) return names;
    if (!equal) {
        names.push_back("quartic");
        return names;
    }
    names.push_back("hyperbolic paraboloid");
    if (std::abs(turn.normalized().dot(cylinder.point - base.point)) <= kRounding * scale)
        names.push_back("plane");  // one of a pair on each side
    return names;
}

}  // namespace

std::vector<std::string> bisector_names(const Scene& scene, const Site& s, double scale) {
    if (!s.is_object()) return {"box"};
    const Object& o = scene.objects[s.index];
    if (const auto* plane = std::get_if<Plane>(&scene.base)) return names_about(*plane, o);
    if (const auto* sphere = std::get_if<Sphere>(&scene.base)) return names_about(*sphere, o);
    return names_about(std::get<Cylinder>(scene.base), o, scale);
}

}  // namespace vcell::check
