/// Pieces of the region over which the envelope is found, and how they are cut in two: along a line parallel
/// to an axis, half-way in the metric of the base, clear of all corners. What is lowest along a piece's sides
/// is cut with it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "../../core/small_vector.hpp"
#include "../../primitives/forms/form_family.hpp"
#include "../proofs/mixed_piece.hpp"

namespace vcell {

/// Off the middle, by no fraction that input favours: a seam through a lattice's vertices would be legal but
/// slow.
inline constexpr double split_ratio = 0.48643;

struct Rectangle {
    double x0, x1, y0, y1;
};

inline constexpr std::size_t usual_sides = 6;
using Sides = SmallVector<PieceSide, usual_sides>;

// A convex piece of the region and the rectangle around it.
struct RegionPiece {
    Sides sides;
    SmallVector<IntervalPoint, usual_sides> corners;  // corner i: start of side i
    Rectangle rect;
};

// A piece in which cylinders compete: what is lowest along its sides is known.
struct LabelledPiece {
    RegionPiece piece;
    std::vector<SideLabels> labels;
    std::vector<std::vector<FormId>> corner_ties;
};

inline RegionPiece make_piece(Sides sides) {
    RegionPiece p;
    p.corners.reserve(sides.size());
    constexpr double inf = std::numeric_limits<double>::infinity();
    p.rect = {inf, -inf, inf, -inf};
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const auto c = corner_of(sides[(i + sides.size() - 1) % sides.size()], sides[i]);
        p.corners.push_back(c);
        p.rect.x0 = std::min(p.rect.x0, c[0].lower());
        p.rect.x1 = std::max(p.rect.x1, c[0].upper());
        p.rect.y0 = std::min(p.rect.y0, c[1].lower());
        p.rect.y1 = std::max(p.rect.y1, c[1].upper());
    }
    p.sides = std::move(sides);
    return p;
}

inline double extent(const Rectangle& r) { return std::max(r.x1 - r.x0, r.y1 - r.y0); }

/// A line across a piece: x = at (upright) or y = at. `beyond` tells on which side each corner lies.
struct PieceCut {
    bool upright;
    double at;
    SmallVector<bool, usual_sides> beyond;

    PieceSide side() const { return {upright ? 1.0 : 0.0, upright ? 0.0 : 1.0, -at, UINT32_MAX}; }
    PieceSide opposite() const { return {upright ? -1.0 : -0.0, upright ? -0.0 : -1.0, at, UINT32_MAX}; }
};

/// Cuts pieces of one region.
class PieceCutter {
public:
    /// Halves are such in the metric of the family's chart.
    explicit PieceCutter(const FormFamily& family) : chart_(family.chart), tips_(family.tips) {}

    /// Across the longer side or, where `upright` says so, the one given; certainly clear of all corners.
    std::optional<PieceCut> cut_at(const RegionPiece& piece, double shift,
                                   std::optional<bool> upright = {}) const;

    /// The piece before the line and beyond it.
    static std::pair<RegionPiece, RegionPiece> halves(const RegionPiece& piece, const PieceCut& cut,
                                                      std::uint32_t seam);

    /// Likewise, with what is lowest along the sides. Along the seam, which has no number yet, that is not
    /// known but at its ends. None if forms change on a side too near to the cut.
    struct LabelledHalves {
        LabelledPiece first, second;
        std::size_t seam_in_first, seam_in_second;  ///< the seam among the sides
        FormId at_leaving,
            at_returning;  ///< where the first piece's boundary comes to the seam and leaves it
    };
    static std::optional<LabelledHalves> labelled_halves(const LabelledPiece& part, const PieceCut& cut);

private:
    struct AxialLengths;

    const Chart chart_;
    const AxialTips& tips_;
};

}  // namespace vcell
