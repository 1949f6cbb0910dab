/// The trisector of three objects within a region of space, as curves [HE, Table 2].
///
/// A point of it is as far from the base as from a and from b. So it lies over its foot on the base where the
/// heights of a and b are equal, and seen from there nothing else is nearer: the trisector is what the two
/// faces of the base's cell among a and b have in common. Its curves are that cell's edges, isolated, proved
/// and fitted by what computes cells, in a box that holds the region and the feet of all of its points. Where
/// they cross the region's sides are all roots of a vertex's equations with that side (core/solver/roots).
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
    /// -1: in a node, in which several parts meet, or where the three touch.
    std::array<int, 2> ends{-1, -1};
};

/// All connected parts of the trisector within the region, splines fitted to the tolerance (a length). The
/// objects are seen as those of scenes: the base by its cell's side, a plane by the
/// base's; balls and tubes may overlap.
///
/// Throws as voronoi_cell() does: InputError (TouchesBase) where the base, as far as feet of the region's
/// points reach, is cut or touched by a plane, cuts one, or lies in another object or around it;
/// UndecidedError where digits do not tell, as where a curve touches a side of the region or runs through an
/// edge of it.
/// Pre: those of trisector() without a region; tolerance > 0.
std::vector<TrisectorCurve> trisector(const Object& base, const Object& a, const Object& b, const Box& region,
                                      double tolerance);

}  // namespace vcell
