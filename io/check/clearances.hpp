/// The least and the greatest clearance of a cell, enclosed.
#pragma once

#include "frame.hpp"
#include "room.hpp"

namespace vcell::check {

struct Clearances {
    Interval least, greatest;  ///< in the frame's unit
};

/// Bounds the clearances of that part of the boundary whose edges are as written. The height of a bisector
/// has no greatest value inside a face, and no least one but where base and object are nearest to each other:
/// there it is half their distance.
Clearances clearances(const Subject& subject, const Frame& frame);

}  // namespace vcell::check
