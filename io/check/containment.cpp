#include "containment.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "../../core/numbers/exact.hpp"
#include "space.hpp"

namespace vcell::check {

namespace {

Vector<Exact> exact(const Vec3& v) { return to_vector<Exact>(v); }
Vector<Exact> from(const Vec3& a, const Vec3& b) { return exact(b) - exact(a); }
bool are_orthogonal(const Vector<Exact>& a, const Vector<Exact>& b) { return dot(a, b).sign() == Sign::Zero; }
Exact squared_sine(const Vector<Exact>& a, const Vector<Exact>& b) {  // times both squared lengths
    const Exact along = dot(a, b);
    return dot(a, a) * dot(b, b) - along * along;
}

/// What doubles tell: false where exact numbers need not be asked. The part of a squared length, of numbers
/// of the size of the ways' ends, that all their roundings are far below.
constexpr double blur = 0x1p-40;
bool may_fit(const Vec3& way, double size, const Vec3& axis, double room) {
    return way.cross(axis).squaredNorm() <= (room * room + blur * size * size) * axis.squaredNorm();
}
bool may_be_parallel(const Vec3& a, const Vec3& b) { return may_fit(a, a.norm(), b, 0); }
bool may_be_orthogonal(const Vec3& a, const Vec3& b, double size) {
    return std::abs(a.dot(b)) <= blur * a.norm() * size;
}

/// Is squared <= (outer - inner)^2 scale, and inner no more than outer?
bool fits(const Exact& squared, double outer, double inner, const Exact& scale) {
    const Exact room = Exact(outer) - Exact(inner);
    return room.sign() != Sign::Negative && (room * room * scale - squared).sign() != Sign::Negative;
}

bool surrounds(const Sphere& holder, const Sphere& held) {
    const Vector<Exact> way = from(holder.center, held.center);
    return fits(dot(way, way), holder.radius, held.radius, 1.0);
}
bool surrounds(const Cylinder& holder, const Sphere& held) {
    if (!may_fit(held.center - holder.point, held.center.norm() + holder.point.norm(), holder.axis,
                 holder.radius - held.radius))
        return false;
    const Vector<Exact> axis = exact(holder.axis);
    return fits(squared_sine(from(holder.point, held.center), axis), holder.radius, held.radius,
                dot(axis, axis));
}
bool surrounds(const Cylinder& holder, const Cylinder& held) {
    return may_be_parallel(holder.axis, held.axis) && surrounds(holder, Sphere{held.point, held.radius}) &&
           squared_sine(exact(holder.axis), exact(held.axis)).sign() == Sign::Zero;
}
bool surrounds(const Plane& holder, const Sphere& held) {
    return held.radius == 0 &&
           may_be_orthogonal(holder.normal, held.center - holder.point,
                             held.center.norm() + holder.point.norm()) &&
           are_orthogonal(exact(holder.normal), from(holder.point, held.center));
}
bool surrounds(const Plane& holder, const Cylinder& held) {
    return surrounds(holder, Sphere{held.point, held.radius}) &&
           are_orthogonal(exact(holder.normal), exact(held.axis));
}
bool surrounds(const Plane& holder, const Plane& held) {
    return surrounds(holder, Sphere{held.point, 0}) &&
           squared_sine(exact(holder.normal), exact(held.normal)).sign() == Sign::Zero;
}
/// What lies beyond a vessel's wall is within what the wall is made of.
bool reaches(const Exact& squared, double radius, double other, const Exact& scale) {
    const Exact reach = Exact(radius) + Exact(other);
    return (squared - reach * reach * scale).sign() != Sign::Negative;
}
bool surrounds(const HollowSphere& holder, const Sphere& held) {
    const Vector<Exact> way = from(holder.center, held.center);
    return reaches(dot(way, way), holder.radius, held.radius, 1.0);
}
bool surrounds(const HollowCylinder& holder, const Sphere& held) {
    const Vector<Exact> axis = exact(holder.axis);
    return reaches(squared_sine(from(holder.point, held.center), axis), holder.radius, held.radius,
                   dot(axis, axis));
}
bool surrounds(const HollowCylinder& holder, const Cylinder& held) {
    return may_be_parallel(holder.axis, held.axis) && surrounds(holder, Sphere{held.point, held.radius}) &&
           squared_sine(exact(holder.axis), exact(held.axis)).sign() == Sign::Zero;
}
bool surrounds(const HollowSphere& holder, const Cylinder& held) {
    const Vector<Exact> axis = exact(held.axis);
    return reaches(squared_sine(from(held.point, holder.center), axis), holder.radius, held.radius,
                   dot(axis, axis));
}
bool surrounds(const HollowSphere& holder, const Plane& held) {
    const Vector<Exact> normal = exact(held.normal);
    const Exact height = dot(normal, from(held.point, holder.center));
    return reaches(height * height, holder.radius, 0, dot(normal, normal));
}
bool surrounds(const HollowCylinder& holder, const Plane& held) {
    return are_orthogonal(exact(held.normal), exact(holder.axis)) &&
           surrounds(HollowSphere{holder.point, holder.radius}, held);
}
bool surrounds(const HollowSphere& holder, const HollowSphere& held) {
    const Vector<Exact> way = from(holder.center, held.center);
    return fits(dot(way, way), held.radius, holder.radius, 1.0);
}
bool surrounds(const HollowSphere& holder, const HollowCylinder& held) {
    const Vector<Exact> axis = exact(held.axis);
    return fits(squared_sine(from(held.point, holder.center), axis), held.radius, holder.radius,
                dot(axis, axis));
}
bool surrounds(const HollowCylinder& holder, const HollowCylinder& held) {
    return surrounds(Cylinder{held.point, held.axis, held.radius},
                     Cylinder{holder.point, holder.axis, holder.radius});
}
/// With D the way from the apex, b the axis, B = |b|^2 and r / s the sine of half the angle the distance of a
/// point from a cone's wall is -rho or more where r D.b + s rho sqrt B and
///
///     (s D.b + r rho sqrt B)^2 - B (s^2 - r^2) (|D|^2 - rho^2)
///
/// are not negative, and -rho exactly where that is 0. The sign of the distance and rho.
Sign room(const HollowCone& cone, const Vec3& point, const Exact& rho) {
    const Vector<Exact> D = from(cone.apex, point), b = exact(cone.axis);
    const Exact r(cone.radius), s(cone.slant), B = dot(b, b), along = dot(D, b), r_rho = r * rho;
    if (sign(OneRoot{r * along, s * rho, B}) == Sign::Negative) return Sign::Negative;
    return sign(
        OneRoot{s * s * along * along + B * r_rho * r_rho - B * (s * s - r * r) * (dot(D, D) - rho * rho),
                2.0 * s * along * r_rho, B});
}
bool surrounds(const HollowCone& holder, const Sphere& held) {
    return room(holder, held.center, held.radius) != Sign::Positive;
}
bool surrounds(const HollowSphere& holder, const HollowCone& held) {
    return room(held, holder.center, -Exact(holder.radius)) != Sign::Negative;
}
/// The narrower one's apex is within the wider one, and the angle between the axes is no more than the
/// difference of half their angles.
bool surrounds(const HollowCone& holder, const HollowCone& held) {
    const Exact r(held.radius), s(held.slant), p(holder.radius), q(holder.slant);
    if ((r * q - p * s).sign() == Sign::Negative || room(held, holder.apex, Exact()) == Sign::Negative)
        return false;
    const Vector<Exact> a = exact(held.axis), b = exact(holder.axis);
    const Exact lengths = dot(a, a) * dot(b, b), along = s * q * dot(a, b), sines = r * p,
                cosines = (s * s - r * r) * (q * q - p * p);
    return along.sign() != Sign::Negative &&
           sign(OneRoot{along * along - lengths * (sines * sines + cosines), -(2.0 * lengths * sines),
                        cosines}) != Sign::Negative;
}
template <class Holder, class Held>
bool surrounds(const Holder&, const Held&) {
    return false;
}

bool is_behind(const Plane& base, const Sphere& ball) {
    const Vector<Exact> normal = exact(base.normal);
    const Exact height = dot(normal, from(base.point, ball.center)), radius(ball.radius);
    return height.sign() != Sign::Positive &&
           (height * height - radius * radius * dot(normal, normal)).sign() != Sign::Negative;
}
bool is_behind(const Plane& base, const Cylinder& tube) {
    return may_be_orthogonal(base.normal, tube.axis, tube.axis.norm()) &&
           are_orthogonal(exact(base.normal), exact(tube.axis)) &&
           is_behind(base, Sphere{tube.point, tube.radius});
}
bool is_behind(const Plane& base, const Plane& plane) {
    return may_be_parallel(base.normal, plane.normal) &&
           squared_sine(exact(base.normal), exact(plane.normal)).sign() == Sign::Zero &&
           is_behind(base, Sphere{plane.point, 0});
}
template <class Vessel>
bool is_behind(const Plane&, const Vessel&) {
    return false;
}

}  // namespace

bool contains(const Object& holder, const Object& held) {
    return std::visit([](const auto& a, const auto& b) { return surrounds(a, b); }, holder, held);
}

namespace {

/// What mirrors the base in a side of the box: a ball, a tube along the side, or a plane, of which the
/// image's normal leads back. None where a double does not tell it, or a ball's centre or a tube's axis is
/// not inside.
std::optional<Object> mirrored_base(const Scene& scene, std::uint32_t side) {
    const auto axis = static_cast<Eigen::Index>(side / 2);
    const double bound = (side % 2 == 0 ? scene.box.min : scene.box.max)[axis];
    const auto mirror = [&](double& x) {
        const double image = 2 * bound - x;
        const bool is_exact = (Exact(image) + Exact(x) - 2.0 * Exact(bound)).sign() == Sign::Zero;
        x = image;
        return is_exact;
    };
    const auto is_inside = [&](double x) { return side % 2 == 0 ? x > bound : x < bound; };
    Object image = scene.base;
    if (auto* plane = std::get_if<Plane>(&image)) {
        plane->normal[axis] = -plane->normal[axis];
        return mirror(plane->point[axis]) ? std::optional(image) : std::nullopt;
    }
    auto* ball = std::get_if<Sphere>(&image);
    auto* tube = std::get_if<Cylinder>(&image);
    if (tube != nullptr && tube->axis[axis] != 0) return std::nullopt;
    double& x = (ball != nullptr ? ball->center : tube->point)[axis];
    return is_inside(x) && mirror(x) ? std::optional(image) : std::nullopt;
}

}  // namespace

bool contains_mirrored(const Object& holder, const Scene& scene, std::uint32_t side) {
    // A vessel is on one side of a plane's image, and on the base's, if anything of it is there.
    const bool is_plane = std::holds_alternative<Plane>(scene.base);
    if (is_plane && !is_vessel(holder)) return false;
    const std::optional<Object> image = mirrored_base(scene, side);
    if (!image) return false;
    const auto* plane = std::get_if<Plane>(&holder);
    return contains(holder, *image) || (plane != nullptr && is_across(*plane, scene, *image));
}

bool mirrored_contains(const Scene& scene, std::uint32_t side, const Object& held) {
    if (const auto* plane = std::get_if<Plane>(&scene.base)) {
        const double along = plane->normal[static_cast<Eigen::Index>(side / 2)];
        if (!(side % 2 == 0 ? along < 0 : along > 0)) return false;
    }
    const std::optional<Object> image = mirrored_base(scene, side);
    return image && base_contains(*image, held);
}

bool base_contains(const Object& base, const Object& held) {
    if (const auto* plane = std::get_if<Plane>(&base))
        return std::visit([&](const auto& o) { return is_behind(*plane, o); }, held);
    return contains(base, held);
}

namespace {

std::array<Vec3, 8> corners(const Box& box) {
    std::array<Vec3, 8> corners;
    for (std::size_t k = 0; k < corners.size(); ++k)
        for (int axis = 0; axis < 3; ++axis) corners[k][axis] = ((k >> axis) & 1 ? box.max : box.min)[axis];
    return corners;
}

/// The place of the base plane, or of the axis of the base tube, from which a point is seen lies this much on
/// the side of a plane that its normal m points to, times |n|^2 with the base's normal or axis n. With v the
/// way to the point from the plane's point and w from the base's: |n|^2 m v - (n w) (m n), or m (a - p) |n|^2
/// + (n w) (m n).
template <class T>
T side_of_foot(const Plane& plane, const Vec3& base_point, const Vec3& normal, bool is_axis, const Vec3& q) {
    const Vector<T> m = to_vector<T>(plane.normal), n = to_vector<T>(normal), p = to_vector<T>(plane.point),
                    a = to_vector<T>(base_point), x = to_vector<T>(q);
    const T along = dot(n, x - a) * dot(m, n), squared = dot(n, n);
    return is_axis ? dot(m, a - p) * squared + along : dot(m, x - p) * squared - along;
}

/// The side that all places are on: the sign of `side` at each, if they agree and none is within `radius` of
/// the plane.
Sign common_side(const Plane& plane, const Vec3& base_point, const Vec3& normal, bool is_axis, double radius,
                 const Box& box) {
    Sign common = Sign::Zero;
    for (const Vec3& q : corners(box)) {
        const Interval about = side_of_foot<Interval>(plane, base_point, normal, is_axis, q);
        Sign sign = about.lower() > 0 ? Sign::Positive : about.upper() < 0 ? Sign::Negative : Sign::Zero;
        if (sign == Sign::Zero || radius > 0) {
            const Exact side = side_of_foot<Exact>(plane, base_point, normal, is_axis, q);
            const Vector<Exact> n = exact(normal), m = exact(plane.normal);
            const Exact room = Exact(radius) * dot(n, n);
            if ((side * side - room * room * dot(m, m)).sign() != Sign::Positive) return Sign::Zero;
            sign = side.sign();
        }
        if (sign == Sign::Zero || (common != Sign::Zero && sign != common)) return Sign::Zero;
        common = sign;
    }
    return common;
}

// The side of a plane that all of the base is on from which places in this box are seen, or Zero.
Sign side_of_base_in(const Plane& plane, const Object& base, const Box& box) {
    const auto side_of = [&](const Vec3& p) { return dot(exact(plane.normal), from(plane.point, p)).sign(); };
    if (const auto* ball = std::get_if<Sphere>(&base)) return side_of(ball->center);
    if (const auto* tube = std::get_if<Cylinder>(&base)) {
        if (are_orthogonal(exact(plane.normal), exact(tube->axis))) return side_of(tube->point);
        return common_side(plane, tube->point, tube->axis, true, tube->radius, box);
    }
    const auto& front = std::get<Plane>(base);
    if (squared_sine(exact(plane.normal), exact(front.normal)).sign() == Sign::Zero)
        return side_of(front.point);
    return common_side(plane, front.point, front.normal, false, 0, box);
}

}  // namespace

// A point that is seen from the plane's one side and lies on the other is farther from where it is seen from
// than from where that way meets the plane.
Sign side_of_base(const Plane& plane, const Scene& scene) {
    const Vec3 half = 0.5 * (scene.box.max - scene.box.min);
    return side_of_base_in(plane, scene.base, {scene.box.min - half, scene.box.max + half});
}

bool is_across(const Plane& plane, const Scene& scene, const Object& object) {
    const Sign side = side_of_base_in(plane, scene.base, scene.box);
    if (side == Sign::Zero) return false;
    const Plane towards{plane.point, side == Sign::Positive ? plane.normal : Vec3(-plane.normal)};
    return base_contains(towards, object);
}

}  // namespace vcell::check
