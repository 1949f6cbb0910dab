/// Where the cell of a tube lies in a box that repeats.
///
/// A tube that closes on itself has a cell without end; it is the same after every period of the tube, so
/// that one period of it is all of it, and the pieces of a scene's tubes fill the box as the cells of balls
/// do. It is cut by two planes across an axis of the box along which the tube has some way, apart by that
/// way: these planes are the only sides, among those along which the box repeats, that the cell comes to.
///
/// In the other directions the tube's own images end it. Two moves by edges make a lattice of images in the
/// plane across the axis. If v is one of these as seen there, and w what the other one has across v, every
/// point of the plane is within (|v|^2 + |w|^2)^(1/2) / 2 of an image. Where moves do not span the plane the
/// box has sides that do not repeat, which end the cell.
#pragma once

#include <array>
#include <span>

#include "image_tree.hpp"

namespace vcell::whole {

/// Cuts are so far behind a tube's point, as a part of its period, and behind the box's lower sides of cells
/// of planes: where scenes of small integers have no corners, and with few digits.
constexpr double part_before_cut = 49.0 / 128;

struct TubeRoom {
    /// Holds the cell, or one period of it. The cell may come to the sides that do not repeat, and to those
    /// of the cut; the others are out of sight.
    Box box;
    std::array<Vec3, 2> axis;  ///< the tube's, in the planes of the cut: a period, where it closes
    std::array<Vec3, 2> feet;  ///< between which those of the cell's points are on the axis
    double clearance;          ///< no point of the cell in that box is farther from the tube's surface
};

/// `box` is the one that repeats. Pre: own_periods() of the tube are these, and it is aligned to them; its
/// point is on the grid; the box repeats; no point of the cell is farther from the axis than `farthest`,
/// which may be infinite.
TubeRoom tube_room(const Lattice& lattice, const Box& box, const Cylinder& tube,
                   std::span<const Image> periods, double farthest);

}  // namespace vcell::whole
