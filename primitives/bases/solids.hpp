/// How cylinders lie among other solids, all given by doubles in one frame, by exact signs.
///
/// An object that lies in another one's solid is never nearer than that one, at best as near. Such ties may
/// run along whole curves of the base (a ball that fills a stretch of a cylinder, a cylinder that
/// touches another from within along a line): the base's problem leaves these objects out.
#pragma once

#include <array>

#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/sign.hpp"
#include "../forms/cylinder_form.hpp"

namespace vcell {

/// Is the closed ball (c, rho) part of the solid cylinder?
bool contains(const CylinderForm& cylinder, double cx, double cy, double cz, double rho);

/// Is the solid cylinder `inner` part of `outer`? Both ways: the same cylinder, whatever points and axes
/// describe it.
bool contains(const CylinderForm& outer, const CylinderForm& inner);

/// Is the closed ball (c, rho) clear of what is within the cylinder, or does it touch that from outside?
bool is_beside(const CylinderForm& cylinder, double cx, double cy, double cz, double rho);
/// Is a solid cylinder beside another one that is parallel? No others are.
bool is_beside(const CylinderForm& cylinder, const CylinderForm& other);

/// Does the solid cylinder lie in the closed half-space n.p + d <= 0, given as (nx, ny, nz, d)?
bool is_beyond(const std::array<Exact, 4>& plane, const CylinderForm& cylinder);

/// C of cylinder_form.hpp as a polynomial: xx x^2 + 2 xy x y + yy y^2 + 2 x1 x + 2 y1 y + c, times the fourth
/// power of an exact form's unit. A tube's is convex: |a|^2 times (the squared distance of (x, y, 0) from the
/// axis - rho^2). A cone's is below 0 within its wall, where m.a, of which ahead has the coefficients of x, y
/// and 1, is positive, and beyond the apex, where that is negative.
struct CylinderTrace {
    Exact xx, xy, yy, x1, y1, c;
    std::array<Exact, 3> ahead;
};
CylinderTrace trace_on_base(const CylinderForm& cylinder);

}  // namespace vcell
