#include "patch_coordinate.hpp"

namespace vcell {

PatchCoordinate PatchCoordinate::linear(const Vec3& direction, const Vec3& origin) {
    PatchCoordinate c;
    c.numerator << direction, 0, -direction.dot(origin);
    return c;
}

PatchCoordinate PatchCoordinate::half_angle(const Vec3& point, const Vec3& zero, const Vec3& quarter,
                                            double delta) {
    PatchCoordinate c;
    c.numerator << quarter, 0, -quarter.dot(point);
    c.divisor << zero, 1, delta - zero.dot(point);
    return c;
}

PatchCoordinate PatchCoordinate::hollow_half_angle(const Vec3& point, const Vec3& zero, const Vec3& quarter,
                                                   double reach, const Vec3& axis, double sine,
                                                   double cosine) {
    const Vec3 across = cosine * quarter, to_divisor = cosine * zero + sine * axis;
    PatchCoordinate c;
    c.numerator << across, 0, -across.dot(point);
    c.divisor << to_divisor, -1, reach - to_divisor.dot(point);
    return c;
}

PatchCoordinate PatchCoordinate::along_cone(const HollowCone& cone, const Vec3& axis, double radius) {
    const double S = cone.sine(), K = cone.cosine();
    PatchCoordinate c;
    c.numerator << axis / K, -S / K, (S * radius - axis.dot(cone.apex)) / K;
    return c;
}

}  // namespace vcell
