/// Curves of points equally far from three solids as cells have them: before a region cuts them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/bisectors/trisector.hpp"
#include "../cell.hpp"

namespace vcell {

/// Balls, tubes, and half spaces with outward normals.
using Solids = std::array<Object, 3>;

/// An edge of a cell between its two objects.
struct UncutCurve {
    RationalCurve3 curve;
    double error = 0;  ///< bounds the distance of either from the other
    TrisectorKind kind = TrisectorKind::Spline;
    bool is_closed = false;
    /// Where it starts and ends: the side of the region that has cut it already; -1: elsewhere.
    std::array<int, 2> ends{-1, -1};
    bool is_as_given = true;  ///< false: of a scene that was drawn in by rounded lengths, as the kind is
};

/// Solids and the curves that belong to them, all of those that come into a region.
struct SolidCurves {
    Solids solids;
    std::vector<UncutCurve> curves;
    std::array<bool, 6> is_cut_already{};  ///< by the sides of the region, which are those of the cell's box
    bool may_go_within = false;            ///< false: no point of them is in all three solids
};

/// Every choice of sides for the planes among objects.
std::vector<Solids> seen_from_all_sides(const Solids& objects);

/// A base's cell among the others has these edges; from both of a plane's sides. Throws as voronoi_cell()
/// does: InputError (TouchesBase) where the base is not as scenes have it.
std::vector<SolidCurves> curves_beside(const Object& base, const Object& a, const Object& b,
                                       const Box& region, double tolerance);

/// The same from the thinnest round object, whatever overlaps it (solid_bases.hpp); planes count from each of
/// their sides in turn. Throws UndecidedError where it cannot be told where it is nearest.
/// Pre: there is a round object.
std::vector<SolidCurves> curves_around_thinnest(const Solids& objects, const Box& region, double tolerance);

/// The message is "the trisector <what> near <p>".
[[noreturn]] void fail_trisector(const std::string& what, const Vec3& p);

}  // namespace vcell
