#include "query.hpp"

#include "../core/exact.hpp"
#include "../envelope/minimization_diagram.hpp"

namespace vcell {

std::optional<PointAnswer> query_point(const PlaneBaseProblem& problem, const Vec3& world) {
    const Vec3 p = problem.frame.to_canonical(world);
    const Exact x = p.x(), y = p.y(), z = p.z();
    for (const RegionSide& side : problem.region)
        if ((side.a * x + side.b * y + Exact(side.c)).sign() == Sign::Negative) return std::nullopt;
    const FormId owner = lowest_form(problem.family, p.x(), p.y());
    PointAnswer answer;
    answer.site = problem.sites[owner].front();
    Exact above;  // has the sign of height - z, for z >= 0
    if (problem.family.is_circular(owner)) {
        const ExactForm f = problem.family.exact(owner);
        answer.clearance = problem.family.forms[owner](p.x(), p.y());
        above = f.K * (x * x + y * y) + f.A * x + f.B * y + f.C - f.W * z;
    } else {
        const CylinderForm& f = problem.family.cylinder(owner);
        const auto [C, beta] = cylinder_terms(f, x, y);
        answer.clearance = cylinder_height(f, p.x(), p.y());
        above = C - (beta + beta) * z - Exact(f.az) * Exact(f.az) * z * z;
    }
    answer.inside = z.sign() != Sign::Negative && above.sign() != Sign::Negative;
    return answer;
}

}  // namespace vcell
