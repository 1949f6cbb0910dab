/// What a labelled mesh comes to once it is complete: a Dcel with boundary components and labels.
#pragma once

#include "../../primitives/forms/heights.hpp"
#include "form_mesh.hpp"
#include "minimization_diagram.hpp"

namespace vcell {

/// What lies outside a mesh's region.
struct MeshOutside {
    std::uint32_t upper_rim;    ///< the side beyond which there is another outside than elsewhere
    FormMesh::Index pole_face;  ///< the face that is unbounded in the chart; none: there is no such face
};

/// Collects faces and boundary components; the region is left for the caller to fill in.
/// Pre: every face hangs together.
MinimizationDiagram frozen(const FormMesh& mesh, const MeshOutside& outside, const Heights& heights);

}  // namespace vcell
