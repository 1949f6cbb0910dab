/// A minimization diagram with the problem whose heights it is of: what every part of a lift asks about its
/// elements, over any base.
#pragma once

#include <array>
#include <string>

#include "../../core/errors.hpp"
#include "../../core/small_vector.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/objects/message.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

/// What bounds the base at a side of its region: the side of the box that cuts it there, or an end of a
/// cylinder's stretch (its chart's rims are sides 0 and 2).
inline Site rim_site(const PlaneBaseProblem& problem, std::uint32_t side) {
    return problem.region[side].site;
}
inline Site rim_site(const RadialBaseProblem&, std::uint32_t side) { return Site::end(side == 0 ? 0 : 1); }

/// Adds the sites of a rim where a vertex lies on it: over a plane, at a corner of the region, all sides of
/// the box that run through it.
inline void add_rim_sites(const PlaneBaseProblem& problem, std::span<const std::uint32_t> sides,
                          SmallVector<Site, 4>& sites) {
    for (const std::uint32_t side : sides) sites.push_back(rim_site(problem, side));
    if (sides.size() < 2) return;
    const std::size_t n = problem.region.size();
    const std::size_t corner = sides[1] == (sides[0] + 1) % n ? sides[1] : sides[0];
    const auto& through = problem.corner_sites[corner];
    sites.insert(sites.end(), through.begin(), through.end());
}
inline void add_rim_sites(const RadialBaseProblem& problem, std::span<const std::uint32_t> sides,
                          SmallVector<Site, 4>& sites) {
    for (const std::uint32_t side : sides) sites.push_back(rim_site(problem, side));
}

template <class Problem>
struct BasedDiagram {
    const Problem& problem;
    const MinimizationDiagram& diagram;

    /// The first of the sites that have the form's height.
    Site main_site(FormId f) const { return problem.sites[f].front(); }
    /// The sites that an edge has on its left and right.
    std::array<Site, 2> sites(EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram.edges[e];
        return {main_site(edge.left), edge.on_rim() ? rim_site(problem, edge.side) : main_site(edge.right)};
    }
    /// "objects 1, 2: <what> around (x, y, z)". place: in the scene as decided.
    UndecidedError unproved(EdgeId e, const char* what, const Vec3& place) const {
        const auto [left, right] = sites(e);
        return UndecidedError("objects " + to_string(left) + ", " + to_string(right) + ": " + what +
                              " around " + to_text(Vec3(problem.unit * place)));
    }
};

using PlaneDiagram = BasedDiagram<PlaneBaseProblem>;
using RadialDiagram = BasedDiagram<RadialBaseProblem>;

}  // namespace vcell
