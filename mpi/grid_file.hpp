/// The cells' boundaries as one file that ParaView opens: VTKHDF, written by all ranks at once.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "../io/pictures/mesh_formats.hpp"
#include "ordered.hpp"
#include "shared_file.hpp"

namespace vcell::mpi {

/// Was this program built with a parallel HDF5?
bool has_grid_files();

/// The meshes of the cells of a range, one after the other as their objects' numbers are.
struct OrderedMesh {
    LabelledMesh mesh;           ///< points and triangles are numbered within the range
    std::vector<double> volume;  ///< of the cell that each triangle bounds
};

/// `meshes` are those of the own objects' cells, in their order; none where there is none.
OrderedMesh in_order(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered,
                     std::vector<std::optional<LabelledMesh>> meshes);

/// VTKHDF 1.0, an UnstructuredGrid of one piece: triangles with the data cell (the object), neighbor (what is
/// beyond, as LabelledMesh has it) and volume; points with clearance. Throws SharedFailure. Pre:
/// has_grid_files().
void write_grid(Ranks& ranks, const OrderedMesh& ordered, const SharedFile& file);

}  // namespace vcell::mpi
