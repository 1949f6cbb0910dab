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
                                                   double reach) {
    PatchCoordinate c;
    c.numerator << quarter, 0, -quarter.dot(point);
    c.divisor << zero, -1, reach - zero.dot(point);
    return c;
}

PatchCoordinate PatchCoordinate::cone_half_angle(const HollowCone& cone, const Vec3& axis, const Vec3& zero,
                                                 const Vec3& quarter, double radius) {
    const double S = cone.sine(), K = cone.cosine();
    const Vec3 to_divisor = K * zero + S * axis;
    PatchCoordinate c;
    c.numerator << K * quarter, 0, -K * quarter.dot(cone.apex);
    c.divisor << to_divisor, -1, radius - to_divisor.dot(cone.apex);
    return c;
}

PatchCoordinate PatchCoordinate::along_cone(const HollowCone& cone, const Vec3& axis, double radius) {
    const double S = cone.sine(), K = cone.cosine();
    PatchCoordinate c;
    c.numerator << axis / K, -S / K, (S * radius - axis.dot(cone.apex)) / K;
    return c;
}

}  // namespace vcell
