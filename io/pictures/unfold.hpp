/// Minimization diagrams over spheres and cylinders, unfolded into the plane [HE, Figs. 8(b), 10(b)].
#pragma once

#include <span>
#include <string>
#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

/// A point p of the cell stands for the base's normal below it. Sphere: normals are projected from the centre
/// onto the cube [-1, 1]^3 in world axes, whose squares lie as a cross: -x, +z, +x, -z from left to right, +y
/// above +z and -y below. Cylinder: onto the sides x = +-1, z = +-1 of a box around it, canonical axes, in
/// the same order; y upwards is the length along the axis, and a side is drawn half as wide as the stretch is
/// long.
struct Unfolding {
    using Polyline = std::vector<Vec2>;

    struct Panel {
        std::string name;  ///< where it points in the world: "+x", or "(0.89, 0, -0.45)"
        Vec2 low, high;
    };
    std::vector<Panel> panels;
    /// By face of the cell: closed polygons, none beyond its panel, to be filled by the even-odd rule.
    std::vector<std::vector<Polyline>> faces;
    /// By edge: cut where panels meet; in both of them along their border.
    std::vector<std::vector<Polyline>> edges;
    std::vector<Vec2> vertices;
    std::vector<std::vector<Polyline>> lines;  ///< by line asked for, as edges
};

/// Curves become polylines within some 1e-5 of the picture's size.
/// Pre: the base is a sphere or a cylinder; the cell is complete.
/// `lines`: further polylines on the cell's boundary.
Unfolding unfold(const Cell& cell, std::span<const std::vector<Vec3>> lines = {});

}  // namespace vcell
