#include "skew_axes.hpp"

#include <cmath>
#include <variant>

#include "radial_patch_terms.hpp"

namespace vcell {

using radial_patch_terms::across_y;

std::optional<SkewAxes> SkewAxes::of(const RadialBaseProblem& problem, FormId form, double y) {
    const auto* cylinder = std::get_if<Cylinder>(&problem.objects[form]);
    if (cylinder == nullptr || cylinder->radius != problem.chart.radius) return std::nullopt;
    Vec3 d = cylinder->axis.normalized();
    const double sine = across_y(d).norm();
    if (sine == 0) return std::nullopt;
    const Vec3 a = cylinder->point + d * d.dot(Vec3(0, y, 0) - cylinder->point), near = across_y(a),
               d_across = across_y(d) / sine;
    const double side = near.dot(Vec3::UnitY().cross(d_across)), apart = std::abs(side);
    if (apart == 0) return std::nullopt;
    const double crossing = a.y() - near.dot(d_across) / sine * d.y();
    if (side < 0) d = -d;  // z points to the cylinder
    // The shorter one of d + d0 and d - d0 has all its digits so, too.
    const double sum_y = d.y() > 0 ? 1 + d.y() : sine * sine / (1 - d.y()),
                 difference_y = d.y() > 0 ? -sine * sine / (1 + d.y()) : d.y() - 1;
    const Vec3 along_x = Vec3(d.x(), sum_y, d.z()).normalized(),
               along_y = Vec3(d.x(), difference_y, d.z()).normalized();
    const double from_crossing = y - crossing;
    return SkewAxes{
        along_x,      along_y, Vec3(0, y, 0), from_crossing * along_x.y(), from_crossing * along_y.y(),
        sine / apart, apart};
}

}  // namespace vcell
