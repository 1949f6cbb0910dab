/// Faces cut into parts with a patch each.
///
/// *About an axis*: around a cylinder base along its generators, or around a vessel's axis over a sphere in
/// half planes from that. These divide the face into sectors; sector i has its own angle parameter u, zero in
/// its middle and increasing towards sector i + 1, so that its sides are u = -reach() and u = reach(). The
/// second parameter v grows along all such sides and between them. Boundary curves come in runs within one
/// sector each; where one run ends in a sector's side and the next one starts in the sector beyond, the face
/// continues along the side: such crossings come in pairs, with a seam piece between them that closes the
/// loops of both sectors. So do lines v = const once around, where all sectors come together in a tip. Two
/// sectors may share their place, if no part of the face that lies there belongs to both: then those beside
/// them are alone in theirs.
///
/// *Across an axis*: a circle about it divides the face in two, each half within a circle about (0, 0).
/// Likewise crossings of the circle come in pairs, and all of it is a seam where nothing of the boundary
/// crosses it but leaves the face on both sides.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "../cell.hpp"

namespace vcell {

/// A piece of a face's boundary in (u, v) of its sector or half.
struct BoundaryRun {
    TrimCurve trim;
    std::uint32_t within;
};

/// A connected part of a face within a sector or half.
struct CutPart {
    std::uint32_t within;
    std::vector<std::vector<TrimCurve>> loops;  ///< outer first, then holes
};

struct CutSector {
    double reach;         ///< u on its last side, and -u on its first one
    std::uint32_t place;  ///< once around, from 0 on
};

/// The parts of a face with the given boundary loops, each a cycle of runs with the face on their left, in
/// sectors at two places at least. `seams` counts the seam pieces given out so far. None where the runs do
/// not enclose parts: a curve runs along a seam as far as its fit tells.
std::optional<std::vector<CutPart>> cut_face(const std::vector<std::vector<BoundaryRun>>& loops,
                                             std::span<const CutSector> sectors, std::uint32_t& seams);
/// The parts in two halves: at(angle, half) is the circle's point at an angle of the first half's parameters,
/// in those of either. None where crossings are so near to each other that doubles may not tell their order.
using CirclePoint = std::function<Vec2(double angle, std::uint32_t half)>;
std::optional<std::vector<CutPart>> halve_face(const std::vector<std::vector<BoundaryRun>>& loops,
                                               const CirclePoint& at, std::uint32_t& seams);

/// The parameters' ranges along a curve that consists of Bezier pieces of degree 1, 2 or 3, or with equal
/// weights.
std::array<std::array<double, 2>, 2> curve_bounds(const RationalCurve2& curve);

}  // namespace vcell
