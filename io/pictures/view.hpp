/// Pictures of a cell in space.
#pragma once

#include <cstddef>
#include <vector>

#include "mesh.hpp"
#include "raster.hpp"

namespace vcell {

struct ViewOptions {
    /// Where the viewer is, in degrees: from the x axis towards y, and from there upwards to z.
    double azimuth = -60, elevation = 25;
    std::size_t size = 480;   ///< of both sides, pixels
    bool has_objects = true;  ///< with base and objects
    /// Of the cell only what lies on the sides that these normals point to.
    std::vector<Plane> clips;
};

/// The cell in the colours of its faces, translucent, its edges as lines, the base and the objects as solids,
/// on white in parallel projection; z is upwards, seen from above or below y is. Planes, cylinders and
/// vessels end at the box. Pre: the mesh is that of the cell.
Image draw_view(const Cell& cell, const CellMesh& mesh, const ViewOptions& options = {});

}  // namespace vcell
