/// Cells made by hand, so that the files and pictures of cells are tested without computing one.
#pragma once

#include <string>

#include "../../envelope/cell.hpp"

namespace vcell {

/// The plane z = 0 under the sphere ((0, 0, 1), 1/4) in the box [-1, 1]^2 x [0, height]: one face on the
/// paraboloid z = (x^2 + y^2 + 15/16) / (5/2) when height is above 1.175 and named "O1 <&>"; for a
/// height in (0.375, 0.775) a disk of it (its edge is closed and has no vertex) in a hole of the box's
/// ceiling.
Cell one_sphere_cell(double height);
inline Cell paraboloid_cell() { return one_sphere_cell(2); }
inline Cell island_cell() { return one_sphere_cell(0.6); }
/// A ball alone in a hollow sphere: an ellipsoid without an edge, with the centres for foci. Its half-axes
/// are 3 and twice the root of 9 - 6.
Cell ellipsoid_cell();

/// The text of write_cell.
std::string cell_text(const Cell& cell);

/// What vcell::InputError says about the text of a scene (a cell); "accepted" if nothing.
std::string scene_complaint(const std::string& text);
std::string cell_complaint(const std::string& text);

}  // namespace vcell
