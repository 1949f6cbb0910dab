/// How far the conics in which planes cut cylinders' bisectors over a plane base, as written, may be from the
/// true ones.
///
/// Let (p, z)(t) be a span, f the height over the first cylinder and g that of the plane.
///
/// 1. Heights. The implicit equation of a bisector (C - 2 beta z - d_z^2 z^2 = 0, or k |p - c|^2 + a.p + e =
///    w z) along the span is a polynomial over the square of the weight, and no larger than its largest
///    Bernstein coefficient. Divided by its derivative in z it bounds |z - f(p)| <= e_f; likewise for g.
/// 2. Place. So |f - g| <= e_f + e_g along p(t). Within a room around the span's hull grad (f - g) stays
/// close
///    to its value in the middle. If a lower bound `slope` of the derivative in the direction of that value
///    is positive, f = g within (e_f + e_g) / slope of every p(t). A plane that stands upright is a line of
///    the chart, whose distance is known.
/// 3. Trims. The patch's chart point at (u, v)(t) is compared with p(t) coefficient by coefficient.
///
/// All of it in double: residuals carry bounds of their rounding.
#pragma once

#include <span>
#include <variant>

#include "cylinder_patch.hpp"
#include "mixed_span.hpp"

namespace vcell {

/// A height on one side of an arc: exactly one is set.
struct ArcSide {
    const CircularForm* circular = nullptr;
    const CylinderFrame* cylinder = nullptr;
};

/// The line a x + b y + c = 0 of the chart over which a wall stands.
struct WallLine {
    double a, b, c;
};

/// The plane that a section lies in: over a line of the chart, or the graph of a linear height.
using SectionSurface = std::variant<WallLine, CircularForm>;

/// The errors of rational quadratic (or linear) spans in a plane and of their trims. No height on the right:
/// a rim. Where parts cannot be proved, the arc goes on between those that are: four times their size.
FitError conic_error(const std::array<ArcSide, 2>& sides, const SectionSurface& plane,
                     std::span<const MixedSpan> spans);

}  // namespace vcell
