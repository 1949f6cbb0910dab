/// What an object itself takes of its cell.
#pragma once

#include <cstdint>

#include "cell_finder.hpp"

namespace vcell::whole {

struct BodyVolume {
    double volume = 0, error = 0;
    bool is_estimated = false;  ///< the error, otherwise a proven bound
};

/// The volume of the points of an object's cell that lie in the object: of the box, that of the ball or tube
/// where no other one is nearer. Over all cells it adds up to the union of all balls and tubes in the box.
///
/// A ball among balls is the cell that ends at clearance 0 (complete_body_measures(); proven). A tube in the
/// box has a closed form (tube_in_box(); proven, rounding to first order, doubled), and what overlaps it, or
/// a ball that tubes or the wall of a vessel overlap, takes away what a quadrature along the rays from the
/// axis or the centre finds: its error is estimated from the difference of two rules, doubled. Planes, points
/// and lines have none. Of a tube that others cut so deep that it has no cell the body is told all the same.
/// Pre: the object is not left out as lying in another one; all objects are known that overlap it.
BodyVolume body_volume(const DecidedDiagram& decided, std::uint32_t object);

/// The volume of a tube in a box. Error: rounding to first order, doubled. An axis that leans by less than
/// 2^-30 towards a side counts as along it, and what that changes is in the error.
BodyVolume tube_in_box(const Cylinder& tube, const Box& box);

}  // namespace vcell::whole
