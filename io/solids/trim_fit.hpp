/// Trims along another edge than they were made for, that runs where theirs does but for little.
#pragma once

#include "../../envelope/cell.hpp"

namespace vcell {

/// The trim over another domain: from one parameter of the edge's curve to another, which may be less.
TrimCurve over_range(TrimCurve trim, const RationalCurve3& edge, double from, double to);

/// A trim from one parameter of the edge's curve to another, in between quintics over each of its spans or
/// parts of these, through points of the patch that are nearest to the edge's. `near` is a trim of the patch
/// beside it, the same way round. As far as halving spans six times brings it, it is within `enough`, a
/// length, of the edge. Over no range it is `near`.
TrimCurve fitted_trim(const TrimCurve& near, const RationalPatch& patch, const RationalCurve3& edge,
                      double from, double to, double enough);

/// Is a trim's curve about where the other one is, in parameters? Near an apex all of them are one place.
bool runs_beside(const TrimCurve& trim, const TrimCurve& other);

/// How far a trim is from its edge at the same parameter, at 65 places.
double distance_along(const RationalCurve3& edge, const TrimCurve& trim, const RationalPatch& patch);

/// The parameter of the curve's point that is nearest to p.
double nearest_on(const RationalCurve3& curve, const Vec3& p);

}  // namespace vcell
