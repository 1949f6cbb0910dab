/// vcell check: proves that a diagram is what its file says, from the objects in it alone.
///
/// Each cell is judged as a cell by certify(): that of a plane or a tube among all objects, that of a ball
/// among those that can be as near to anything of it as the ball, no farther from the ball's surface than
/// twice the cell's largest clearance, which certify() proves, too. Where the box repeats these are images
/// (near_balls.hpp, near_others.hpp), and none of the cell's faces may lie on a side that repeats, but where
/// that cuts a tube's cell to one period. Then
///   - a ball without a cell lies in another object, or beyond a vessel's wall, or equals a ball of a lower
///     number, or a probe that ends cells does not get from it to the box; of another one beyond the box, or
///     that the file says it lacks, nothing is said;
///   - pairs: two cells have as many faces between them, one area within both bounds, and the same vertices,
///     by all objects among their sites and within both errors, those in which bisectors touch by their
///     objects alone: what cell i has with the image s of ball j, cell j has with the image -s of ball i,
///     moved by s (diagram_pairs.hpp). Cells of tubes that come in parts (parts.hpp) cut faces and edges:
///     with these pairs have the same vertices where neither cell leaves anything out;
///   - the volumes' enclosures add up to one of the box's volume; where there are objects without a cell
///     here, or a probe ends cells, to no more.
/// Nothing that computed the diagram takes part, but the rule by which one number stands for images that are
/// one (whole::representative()).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "check.hpp"

namespace vcell {

/// The cells of a diagram's objects as its file has them.
struct StoredDiagram {
    DiagramScene scene;
    /// A bound on the distance that coordinates had been moved by when they were written, to a grid on which
    /// images are exact (VoronoiDiagram::moved). Nothing is proved about it.
    double moved = 0;
    /// By object, ascending; of a plane first that on the side of its normal, if it has both. Sites of
    /// elements are places in `images` of the cells' scenes, which have nothing else but the object as
    /// `base`, a plane turned to the side of its cell, the probe, and the box: of tubes and planes in one
    /// that repeats what their cells are computed in, and otherwise the diagram's.
    std::vector<std::pair<std::uint32_t, Cell>> cells;
    /// Objects whose cells the file has not, or of planes not on both sides, and why; ascending.
    struct Lacking {
        std::uint32_t object;
        std::string reason;
    };
    std::vector<Lacking> lacking;
};

/// Elements are named "cells[7].vertices[3]", by the object's number, of a plane with its side, "cells[8-]",
/// "pairs[7, 9(0,-1,0)]" and "volume". The bytes are the same for any number of threads. Pre: the scene is
/// valid, and the cells are of its balls, planes and tubes.
Certificate certify(const StoredDiagram& diagram, const CheckOptions& options = {}, unsigned threads = 1);

}  // namespace vcell
