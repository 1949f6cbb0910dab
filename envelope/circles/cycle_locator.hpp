/// Which cycles of a diagram bound a face from outside, and which points lie within them: asked where parts
/// of a boundary may be islands.
#pragma once

#include "work_mesh.hpp"

namespace vcell {

class CycleLocator {
public:
    using Index = WorkMesh::Index;

    explicit CycleLocator(const WorkMesh& mesh) : mesh_(mesh), kernel_(mesh.kernel()) {}

    /// Does the cycle of this half-edge bound the face on its left from outside? Otherwise it is an island.
    bool is_outer_cycle(Index cycle);
    /// A point that lies on it.
    PointId point_on(Index cycle);
    /// Does the cycle, or the face, surround p? Pre: p does not lie on what bounds it.
    bool cycle_contains(Index cycle, PointId p);
    bool face_contains(const WorkMesh::Face& f, PointId p);

private:
    int crossings_above(Index e, PointId p);

    const WorkMesh& mesh_;
    CircleKernel& kernel_;
};

}  // namespace vcell
