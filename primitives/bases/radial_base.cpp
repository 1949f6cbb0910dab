#include "radial_base.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <variant>

#include "../../core/errors.hpp"
#include "../bisectors/bisector.hpp"
#include "../forms/crossing.hpp"
#include "cylinder_base.hpp"
#include "cylinder_forms.hpp"
#include "sphere_base.hpp"

namespace vcell {

RadialBaseProblem radial_base_problem(const Scene& scene, double unit) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.base))
        return sphere_base_problem(scene, *sphere, unit);
    return cylinder_base_problem(scene, std::get<Cylinder>(scene.base), unit);
}

std::array<double, 4> RadialBaseProblem::chart_box() const {
    constexpr double reach = 0x1p10;
    if (chart.is_sphere()) return {-reach, reach, -reach, reach};
    return {-1, 3, stretch[0], stretch[1]};
}

bool RadialBaseProblem::cross_equally(FormId f, FormId g) const {
    const auto* first = std::get_if<Cylinder>(&objects[f]);
    const auto* second = std::get_if<Cylinder>(&objects[g]);
    if (first == nullptr || second == nullptr) return false;
    // Doubles see at once that axes pass each other by more than this part of the terms, far above their
    // rounding.
    constexpr double certainly_apart = 0x1p-30;
    const Vec3 between = second->point - first->point, normal = first->axis.cross(second->axis);
    const double size =
        first->axis.norm() * second->axis.norm() * (first->point.norm() + second->point.norm());
    if (!(std::abs(between.dot(normal)) <= certainly_apart * size)) return false;
    return equal_crossing(family, f, g).has_value();
}

double ball_power(const RadialBaseProblem& problem, FormId form) {
    // Its coefficients are those of 2 c across the pole, and of c along it -+ delta: over a scale that |c|
    // tells.
    const CircularForm& f = problem.family.forms[form];
    if (const auto* vessel = std::get_if<HollowSphere>(&problem.objects[form]))
        return 4 * f.w * (vessel->radius + problem.chart.radius) / std::abs(f.k + f.e);
    const double length = std::get<Sphere>(problem.objects[form]).center.norm();
    return 4 * f.w * length / std::hypot(f.a, f.b, f.k - f.e);
}

std::optional<double> power_of_ball(const RadialBaseProblem& problem, FormId form) {
    if (!problem.chart.is_sphere() || !std::holds_alternative<Sphere>(problem.objects[form]))
        return std::nullopt;
    return ball_power(problem, form);
}

bool is_flat(const RadialBaseProblem& problem, FormId form) {
    if (is_wall(problem, form)) return true;
    const BaseChart& chart = problem.chart;
    const Object& object = problem.objects[form];
    if (const auto* sphere = std::get_if<Sphere>(&object))
        return chart.is_sphere() && sphere->radius == chart.radius;
    const auto* cylinder = std::get_if<Cylinder>(&object);
    if (cylinder == nullptr || chart.is_sphere() || cylinder->radius != chart.radius) return false;
    return cylinder->axis.x() == 0 && cylinder->axis.z() == 0;
}

bool pierces_base(const RadialBaseProblem& problem, FormId form) {
    if (problem.family.is_circular(form) || !std::holds_alternative<Cylinder>(problem.objects[form]))
        return false;
    const RadialForm& f = problem.family.radial_form(form);
    if (problem.chart.is_sphere()) return f.c[0].sign() == Sign::Negative;
    return f.has_root() && !CylinderForms::is_positive(f.c, problem.stretch);
}

bool may_have_tips(const RadialBaseProblem& problem) {
    for (const FormId f : problem.objects.ids())
        if (is_vessel(problem.objects[f]) || pierces_base(problem, f)) return true;
    return false;
}

std::string_view bisector_name(const RadialBaseProblem& problem, FormId form) {
    if (problem.sites[form].front().kind == Site::Kind::BoxSide) return "box";
    const Object& object = problem.objects[form];
    const double radius = problem.chart.radius;
    if (!problem.chart.is_sphere()) {
        if (is_flat(problem, form)) return to_string(BisectorKind::Plane);
        return to_string(bisector_kind(problem.given_base, problem.given[form]));
    }
    if (const auto* vessel = std::get_if<HollowSphere>(&object))
        return to_string(vessel->center.isZero(0) ? BisectorKind::Sphere : BisectorKind::Ellipsoid);
    if (std::holds_alternative<HollowCylinder>(object) || std::holds_alternative<HollowCone>(object))
        return to_string(BisectorKind::Quartic);
    // Of bisectors over a sphere base only what keeps the object outside.
    if (object.index() == 0) return to_string(BisectorKind::Paraboloid);
    if (const auto* sphere = std::get_if<Sphere>(&object))
        return to_string(sphere->radius == radius ? BisectorKind::Plane : BisectorKind::Hyperboloid);
    return to_string(std::get<Cylinder>(object).radius == radius ? BisectorKind::ParabolicCylinder
                                                                 : BisectorKind::Quartic);
}

}  // namespace vcell
