// Measures of faces in planes over a cylinder: sides of the box, and bisectors of tubes whose axes cross.
#include <Eigen/Geometry>
#include <cmath>

#include "radial_integrals.hpp"
#include "radial_terms.hpp"

namespace vcell::radial_integrals {

// The face's edges meet but for rounding. As seen from a point near by the gaps between them are next to
// nothing.
FlatFace::FlatFace(const Plane& side, const Vec3& near)
    : normal(side.normal.normalized()), offset(normal.dot(side.point)) {
    point = near + (offset - normal.dot(near)) * normal;
}

// Boundaries run clockwise as seen from the base, counter-clockwise from outside.
Share FlatFace::share(const SpanPoint<double>& p) const {
    const Vec3 q = Vec3(p.x, p.y, p.z) - point;
    const double turn = normal.dot(q.cross(Vec3(p.x1, p.y1, p.z1)));
    const double at_point = offset - normal.y() * point.y(), change = -normal.y() * q.y();
    return {0.5 * (0.5 * at_point + change / 3) * turn, 0.5 * turn};
}

Share FlatFace::size(const SpanPoint<double>& p) const {
    const Vec3 q = Vec3(p.x, p.y, p.z) - point;
    const double turn = (q.norm() + noise * Vec3(p.x, p.y, p.z).norm()) * Vec3(p.x1, p.y1, p.z1).norm();
    return {(std::abs(offset - normal.y() * point.y()) + std::abs(q.y())) * turn, turn};
}

// Tubes of one radius whose axes cross, but for rounding, have two planes for their bisector, at right angles
// to each other and across the axes' plane. Over the base next to their common line heights are beyond all
// bounds.
std::optional<FlatFace> FlatFace::between_crossing(const RadialBaseProblem& problem, const Cylinder& cylinder,
                                                   const Vec3& near) {
    // Output accuracy, in parts of how far apart the axes are beside the face: the planes are off by less.
    constexpr double rounding = 0x1p-48;
    if (cylinder.radius != problem.chart.radius) return std::nullopt;
    const Vec3 axis = cylinder.axis.normalized();
    const auto [foot, apart, square] = AxesApart(cylinder.point, axis);
    const double along = near.y() - foot;
    if (!(apart <= rounding * sqrt(square) * std::abs(along))) return std::nullopt;
    // Between the two axes as they go from the crossing to the face's side, away from the base's.
    const double across = near.x() * axis.x() + near.z() * axis.z();
    const Vec3 crossing(0, foot, 0),
        normal = std::copysign(1, across) * axis - std::copysign(1, along) * Vec3::UnitY();
    return FlatFace(Plane{crossing, normal}, near);
}

}  // namespace vcell::radial_integrals
