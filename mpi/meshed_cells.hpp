/// The cells with meshes that fit together, whichever ranks draw them.
///
/// A mesh is that which ConformingMeshes has when it draws all cells in the order of their objects. A cell
/// waits for those of lower objects that it lists in a vertex, an edge or a face, or that list it, and for no
/// other: each rank draws what need not wait, then tells the ranks of the objects around what these cells
/// leave for others (shared::Additions), in rounds, until all are drawn. So meshes are the same for any
/// number of ranks as far as cells that have a vertex in common list each other.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "../io/pictures/mesh_formats.hpp"
#include "surroundings.hpp"

namespace vcell::mpi {

/// Both lists have the own objects in their order.
struct MeshedCells {
    std::vector<DiagramCell> cells;
    std::vector<std::optional<LabelledMesh>> meshes;  ///< none where there is no cell, or it has no faces
    std::uint64_t rounds = 0;
};

/// Cells are found twice, so that none need be kept while it waits. `around` is that of cells that are not
/// only measured; `chord` is ConformingMeshes'.
MeshedCells meshed_cells(Ranks& ranks, const SceneParts& parts, const Surroundings& around, double chord,
                         unsigned threads);

}  // namespace vcell::mpi
