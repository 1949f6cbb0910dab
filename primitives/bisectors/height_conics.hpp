/// Where two heights over a plane base agree along plane curves of space.
///
/// A height z = h(x, y) is a quadric of space: C - 2 beta z - A z^2 = 0. Two of them share a curve of degree
/// four in general; over a plane base it is made of conics when one form is a plane, and in special positions
/// of others (cylinders of equal radius whose axes cross or are parallel, a ball centred on a cylinder's axis
/// across the base, ...).
#pragma once

#include <array>
#include <vector>

#include "../forms/form_family.hpp"

namespace vcell {

/// Planes a x + b y + c z + d = 0 of canonical space as {a, b, c, d}, exact, one or two, that contain
/// together every point (x, y, z) with z = height of i = height of j. So where c != 0 the clearance along the
/// curve is z = -(a x + b y + d) / c and the edge's space curve is a conic in the plane; where c = 0 its
/// projection is on a line. Empty where the algebra finds no such planes with rational coefficients. Pre: i
/// != j, and not both circular (these have circles and lines as projections anyway).
std::vector<std::array<Exact, 4>> height_planes(const FormFamily& family, FormId i, FormId j);

}  // namespace vcell
