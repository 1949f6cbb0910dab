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

template <class Problem>
struct BasedDiagram {
    const Problem& problem;
    const MinimizationDiagram& diagram;

    /// The first of the sites that have the form's height.
    Site main_site(FormId f) const { return problem.sites[f].front(); }
    /// The sites that an edge has on its left and right.
    std::array<Site, 2> sites(EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram.edges[e];
        if (!edge.on_rim() && diagram.has_lower_across(edge.right, edge.left))
            return {main_site(edge.right), main_site(edge.left)};
        return {main_site(edge.left), edge.on_rim() ? problem.region[edge.side].site : main_site(edge.right)};
    }
    /// Is there no face with a form on either side of an edge? So it is beyond what rays of the cell reach.
    bool is_bare(EdgeId e) const {
        return !diagram.face_forms[diagram.face(e, 0)].valid() &&
               !diagram.face_forms[diagram.face(e, 1)].valid();
    }
    /// Adds the sites of the rims where a vertex lies on some.
    void add_rim_sites(VertexId v, SmallVector<Site, 4>& sites) const {
        for (const std::uint32_t side : diagram.sides(v)) sites.push_back(problem.region[side].site);
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
