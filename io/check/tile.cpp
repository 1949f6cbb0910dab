#include "tile.hpp"

#include <array>
#include <cstddef>

namespace vcell::check {

namespace {

/// Unless false, may be met: pieces of less than `least_size` are not told apart from the tile.
bool meets(const Bezier<2>& piece, const Tile& tile, const Vec2& least_size) {
    const Vec2 &lo = tile.lo, &hi = tile.hi;
    Vec2 least = piece.control(0), most = least;
    for (std::size_t i = 1; i < piece.points.size(); ++i) {
        least = least.cwiseMin(piece.control(i));
        most = most.cwiseMax(piece.control(i));
    }
    if ((least.array() > hi.array()).any() || (most.array() < lo.array()).any()) return false;
    // Its ends are on the curve.
    for (const std::size_t i : {std::size_t{0}, piece.points.size() - 1}) {
        const Vec2 end = piece.control(i);
        if ((end.array() >= lo.array()).all() && (end.array() <= hi.array()).all()) return true;
    }
    if (((most - least).array() < 0.25 * (hi - lo).array()).all()) return true;
    if (!((most - least).array() > least_size.array()).any()) return true;
    for (const auto& half : piece.halves())
        if (meets(half, tile, least_size)) return true;
    return false;
}

}  // namespace

bool is_outside(const Patch& patch, Tile& tile) {
    if (tile.is_inside) return false;
    // A patch may be no wider than its numbers' rounding, below which halves of a piece do not shrink.
    const Vec2 least_size = patch.parameter_rounding();
    const auto is_beside = [&](const Vec2& lo, const Vec2& hi) {
        return (lo.array() > tile.hi.array()).any() || (hi.array() < tile.lo.array()).any();
    };
    for (const auto& loop : patch.loops)
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Trim& trim = loop[i];
            const Vec2 end = trim.last_point(), start = loop[(i + 1) % loop.size()].first_point();
            if (!is_beside(end.cwiseMin(start), end.cwiseMax(start))) return false;
            if (is_beside(trim.lo, trim.hi)) continue;
            for (const auto& piece : trim.pieces)
                if (meets(piece, tile, least_size)) return false;
        }
    tile.is_inside = is_wound_around(patch, 0.5 * (tile.lo + tile.hi)).value_or(true);
    return !tile.is_inside;
}

}  // namespace vcell::check
