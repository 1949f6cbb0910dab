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
    const ExactForm f = problem.family.exact(owner);
    const Exact above = f.K * (x * x + y * y) + f.A * x + f.B * y + f.C - f.W * z;
    return PointAnswer{problem.sites[owner].front(), problem.family.forms[owner](p.x(), p.y()),
                       z.sign() != Sign::Negative && above.sign() != Sign::Negative};
}

}  // namespace vcell
