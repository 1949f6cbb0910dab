/// A minimization diagram with the problem whose heights it is of: what all rooms of a lift ask about its
/// elements.
#pragma once

#include "../../primitives/bases/radial_base.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

/// The rims of a cylinder's chart, sides 0 and 2, are its ends.
inline Site rim_site(const RadialBaseProblem&, std::uint32_t side) { return Site::end(side == 0 ? 0 : 1); }

template <class Problem>
struct BasedDiagram {
    const Problem& problem;
    const MinimizationDiagram& diagram;

    /// Of several sites with one height the first.
    Site main_site(FormId f) const { return problem.sites[f].front(); }
    /// On an edge's left and right.
    std::array<Site, 2> sites(EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram.edges[e];
        return {main_site(edge.left), edge.on_rim() ? rim_site(problem, edge.side) : main_site(edge.right)};
    }
};

using RadialDiagram = BasedDiagram<RadialBaseProblem>;

}  // namespace vcell
