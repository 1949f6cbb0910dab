/// The trisector of three objects within a region of space, as curves [HE, Table 2]: all points outside of
/// all three that are equally far from them, at a distance above 0, and where such curves end.
///
/// Balls and tubes are solid, so points in one of them are none; planes are as far from both of their sides.
/// A point that is equally far lies over its foot on any one of the three, taken for a base, where the
/// heights of the other two are equal, and seen from there nothing else is nearer: the trisector is what the
/// two faces of the base's cell among them have in common. Its curves are that cell's edges, isolated, proved
/// and fitted by what computes cells, in a box that holds the region and the feet of all of its points. Where
/// they cross the region's sides are all roots of a vertex's equations with that side (core/solver/roots),
/// and where they come to an end between objects that overlap, those at distance 0.
///
/// The base is the first of the three that may be one of a scene; a plane is, from both of its sides, and
/// then the other two lie wholly on these. Where objects cut, contain or touch one another so that none may,
/// it is the thinnest round one (primitives/bases/solid_bases.hpp), once for each choice of the planes'
/// sides, a half space being a solid like the others. Lines between three planes need no base.
#pragma once

#include <array>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/bisectors/trisector.hpp"

namespace vcell {

/// A connected part of a trisector within a region, cut at nodes.
struct TrisectorCurve {
    TrisectorKind kind = TrisectorKind::Spline;
    int degree = 1;  ///< algebraic, of the component it lies on, counting virtual branches
    /// One after the other, each beginning where the one before ends: lines and conics as rational curves of
    /// degree 1 and 2, splines of degree 5.
    std::vector<RationalCurve3> arcs;
    /// Certified: no point of the arcs is farther from this part of the trisector, none of it from the arcs.
    /// It exceeds the tolerance where rounding blurs the curve, or near nodes.
    double error = 0;
    bool is_closed = false;
    /// Where an open part starts and ends: the side of the region, in the order -x, +x, -y, +y, -z, +z; or
    /// -1: in a node, in which several parts meet, or at distance 0, in a point of all three surfaces.
    std::array<int, 2> ends{-1, -1};
};

/// All connected parts of the trisector within the region, splines fitted to the tolerance (a length). The
/// same curves come for any order of the objects, up to their errors; how they run and what comes first may
/// differ. There are none where one of the objects lies in another one.
///
/// Throws UndecidedError where digits do not tell: where a curve touches a side of the region or runs through
/// an edge of it, where all three surfaces touch in a point or along a curve; where two of the objects are
/// one, or one touches another one from within along a line, so that surfaces are equally far; and where
/// tubes of one radius have axes that cross, the third object overlaps one of them, and is neither thinner
/// than they are nor a ball or plane that may be a scene's base. InputError for what validate() refuses, and
/// for vessels. Pre: tolerance > 0.
std::vector<TrisectorCurve> trisector(const Object& base, const Object& a, const Object& b, const Box& region,
                                      double tolerance);

}  // namespace vcell
