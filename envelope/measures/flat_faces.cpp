// Measures of faces in planes over a cylinder.
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

std::optional<FlatFace> FlatFace::to_twin(const RadialBaseProblem& problem, FormId form, const Around& face) {
    constexpr double narrow = 0x1p-10;  // a matter of digits: both integrals are right
    const auto* twin = std::get_if<Cylinder>(&problem.objects[form]);
    if (twin == nullptr || twin->radius != problem.chart.radius) return std::nullopt;
    const Vec3 way(twin->point.x(), 0, twin->point.z());
    return way.norm() < narrow * face.extent ? std::optional(FlatFace({0.5 * way, way}, face.near))
                                             : std::nullopt;
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

}  // namespace vcell::radial_integrals
