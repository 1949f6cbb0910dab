#include "solid_angle.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace vcell {

namespace {

using roundoff::u;
using std::numbers::pi;

// tan(phi / 2) is at most 1 for arcs that are no longer, and what h is off by counts twice in S.
constexpr double longest = 0.5 * pi;

// E + S of an arc, which is cut until its parts are short. Cuts change nothing but rounding.
double share(const Vec3& b, const Vec3& from, const Vec3& to, const Vec3& n, double h) {
    const Vec3 p = from - h * n, q = to - h * n;
    const double phi = std::atan2(n.dot(p.cross(q)), p.dot(q));
    if (std::abs(phi) > longest) {
        const Vec3 half_way =
            (h * n + std::cos(0.5 * phi) * p + std::sin(0.5 * phi) * n.cross(p)).normalized();
        return share(b, from, half_way, n, h) + share(b, half_way, to, n, h);
    }
    const double triangle = 2 * std::atan2(b.dot(from.cross(to)), 1 + b.dot(from) + from.dot(to) + to.dot(b));
    return triangle + 2 * std::atan(h * std::tan(0.5 * phi)) - h * phi;
}

}  // namespace

// The distance on the sphere is no less than the straight one, and that no less than the one along n from the
// circle's plane. A short arc tells its plane badly, its direction by no more than some roundings over the
// chord's square; but all of an arc shorter than half a turn is in the ball that has the chord for a
// diameter.
double SolidAngle::distance_from(const Vec3& direction) const {
    double least = has_segments_ ? 0 : pi;
    constexpr double rounding = 64 * u;
    for (const Arc& arc : arcs_) {
        const double chord = (arc.to - arc.from).norm(),
                     from_plane =
                         std::abs(arc.n.dot(direction) - arc.h) - rounding * (1 + 1 / (chord * chord)),
                     from_ball = (direction - 0.5 * (arc.from + arc.to)).norm() - 0.5 * chord - rounding;
        least = std::min(least, std::max(from_plane, from_ball));
    }
    return std::max(0.0, least);
}

SolidAngle::Value SolidAngle::value(const std::optional<Place>& place) const {
    if (arcs_.empty()) return {4 * pi, 8 * u * pi};
    // A triangle is told the worse, the nearer its corners come to -b.
    Vec3 b = Vec3::UnitX();
    double room = -1;
    for (int k = 0; k < 27; ++k) {
        const Vec3 direction(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (direction.isZero(0)) continue;
        const Vec3 unit = direction.normalized();
        double least = 2;
        for (const Arc& arc : arcs_) least = std::min(least, 1 + unit.dot(arc.from));
        if (least > room) {
            room = least;
            b = unit;
        }
    }
    BoundedSum sum = segments_;
    // The square of the triangle's two terms is 2 (1 + b.from) (1 + from.to) (1 + to.b), at least twice the
    // square of the room, and each carries some ten roundings; all else is of the size of 1.
    const double rounding = 2 * (2 * 16 * u / room + 64 * u);
    for (const Arc& arc : arcs_) sum.add(arc.sign * share(b, arc.from, arc.to, arc.n, arc.h), rounding);
    const double error = sum.bound() + 16 * u * pi;
    double angle = std::remainder(sum.value(), 4 * pi);
    if (!(std::abs(angle) > error)) {
        // The face, or what is outside of it, has the cap of this size about the place, of an angle
        // 4 pi sin^2(size / 2) >= 4 size^2 / pi; what might be nothing has an angle of two errors at most.
        const double size = place ? distance_from(place->direction) : 0;
        if (!(4 * size * size / pi > 2 * error)) return {2 * pi, 2 * pi * (1 + 8 * u)};
        return {place->is_inside ? std::min(4 * pi, 4 * pi + angle) : std::max(0.0, angle), error};
    }
    if (angle < 0) angle += 4 * pi;
    return {angle, error};
}

}  // namespace vcell
