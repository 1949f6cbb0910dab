/// Vertices of circular forms to the last digits: where forms are much alike, their differences lose in
/// doubles what tells where three of them meet.
#pragma once

#include <optional>

#include "minimization_diagram.hpp"

namespace vcell {

/// Finds vertices again that are known by far fewer digits than doubles have, from exact residuals. A vertex
/// at which no three curves are told apart, or that is not of circular forms alone, stays where it is. A
/// height that is known by few digits is found again on the circular form that is flattest there.
/// Vertices do not depend on each other, and so nothing does on the number of threads.
void settle_vertices(const FormFamily& family, MinimizationDiagram& diagram, unsigned threads);

/// (A, B) of f - g = K |p|^2 + A x + B y + ... about p, to rounding, times a positive factor.
Eigen::Vector2d settled_gradient(const FormFamily& family, FormId f, FormId g, const Eigen::Vector2d& p);

}  // namespace vcell
