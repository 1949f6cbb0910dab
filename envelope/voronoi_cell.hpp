/// The whole way from a scene to its cell.
#pragma once

#include <functional>

#include "../primitives/objects/scene.hpp"
#include "cell.hpp"

namespace vcell {

struct CellOptions {
    /// Called now and then by the calling thread with the stage ("bisectors", "envelope", "patches") and the
    /// fraction of it that is done, in [0, 1]; may throw to cancel.
    std::function<void(const char* stage, double fraction)> progress;
    /// 0: as many as the machine has cores. The cell is the same for any number, its bytes as a file too but
    /// for the seconds of the report. Others help where thousands of balls and planes have faces over a
    /// plane; where tubes compete, around balls and around tubes the calling thread does nearly all.
    unsigned threads = 1;
    /// False: edge lengths, face areas and Cell::measures stay not_measured, and neighbours come by number.
    /// They take a quarter of the time of a ball's cell among balls.
    bool measure = true;
    /// False: around a ball faces, of any shape then, have neither patches nor a bisector's name, and edges
    /// no trims, which their errors then leave out. Around planes, and around tubes where there
    /// is no vessel, they have them anyway.
    bool patches = true;
    /// True: of a base plane the cell is all of the box, on the side of the plane's normal, that is nearest
    /// to it (lift/complete_lift.hpp): where the plane leans, rays from base points outside come into the box
    /// through its sides, which have faces of the cell, too. Of a base tube that runs into sides of the box
    /// obliquely it is all of the box that is nearest to the tube, cut across the axis where that crosses the
    /// plane of a side (complete_tube.hpp). Then objects must stay clear of the base as far as its rays come
    /// into the box, and over a plane a little farther. Cells over other bases stay as they are;
    /// Cell::is_complete says which it is. A tube of which a ball or another tube holds whole cross
    /// sections, or whose axis a tube of its radius crosses, has its complete cell, or none, asked for or
    /// not.
    bool complete = false;
};

/// The Voronoi cell of the scene's base among its objects, inside the box.
/// Throws InputError as validate(), plane_base_problem() and radial_base_problem() do, and EnvironmentError
/// (core/platform.hpp) where this thread does not compute as IEEE 754 has it by default.
Cell voronoi_cell(const Scene& scene, const CellOptions& options = {});

}  // namespace vcell
