/// Objects that have no cell in a diagram, as others are as near or nearer all over: by exact signs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "../voronoi_diagram.hpp"
#include "image_tree.hpp"

namespace vcell::whole {

/// A ball that holds another one, touching it from within included, has this or less between its surface and
/// the other one's centre.
double depth_in_holder(const Sphere& ball);
/// For each object why it has no cell, empty where it has one: what lies in a ball, in a tube, in a plane or
/// beyond a vessel's wall is nowhere nearer than these; nor is one of several equal objects, which go to the
/// first. Messages have `numbers` in place of places where there are any. Pre: the balls are those of the
/// scene by their places, and on its grid; an object whose holders are not all among them is wrongly said to
/// have a cell.
std::vector<std::string> find_hidden(const DiagramScene& scene, const std::vector<std::uint32_t>& numbers,
                                     const ImageTree& balls);
/// Says why objects that are no balls have no cell, where it is not said yet: balls hide none of them. Pre:
/// the lattice is the scene's.
void hide_others(const DiagramScene& scene, const Lattice& lattice, const std::vector<std::uint32_t>& numbers,
                 std::vector<std::string>& hidden);

}  // namespace vcell::whole
