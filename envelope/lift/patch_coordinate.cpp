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

}  // namespace vcell
