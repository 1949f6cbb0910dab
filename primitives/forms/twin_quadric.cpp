#include "twin_quadric.hpp"

#include "space_quadrics.hpp"
#include "twins.hpp"

namespace vcell {

SpaceQuadric SpaceQuadric::turned(const Eigen::Matrix3d& turn) const {
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    T.topLeftCorner<3, 3>() = turn;
    return {T * M * T.transpose(), T * l, k};
}

std::optional<SpaceQuadric> twin_quadric(const FormFamily& family, FormId f, FormId g) {
    using space_quadrics::term, space_quadrics::unknowns;
    const auto mu = FormSignature(family, f).factor(FormSignature(family, g));
    if (!mu) return std::nullopt;
    const auto p = space_quadrics::equation(family, f), q = space_quadrics::equation(family, g);
    const Exact lambda = square(Exact(*mu));
    // A wall's equation over a plane is negative where the wall is farther than the plane.
    const bool is_wall = family.radial.empty() && !family.is_circular(f) && family.cylinder(f).is_hollow();
    const auto coefficient = [&](std::size_t i, std::size_t j) {
        const std::size_t at = term(unknowns, i, j);
        return (p[at] - lambda * q[at]).enclosure().mid();
    };
    SpaceQuadric d;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) d.M(i, j) = (i == j ? 1 : 0.5) * coefficient(i, j);
        d.l[i] = coefficient(i, 4);
    }
    d.k = coefficient(4, 4);
    return is_wall ? d.times(-1) : d;
}

}  // namespace vcell
