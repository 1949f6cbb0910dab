/// Where an object must come to touch a tube's cell.
///
/// Let q be a point of the cell whose foot on the axis is within h of f, a point of the axis, and r the
/// tube's radius. From the ball about f of radius r + h it is no farther than from the tube, and no nearer
/// than by h:
///
///     |q - f| - r - h  <=  d(q, tube)  <=  |q - f| - r
///
/// So that part of the cell lies in the cell of this ball, which others bound (CellBound), and what touches
/// it, grown by h, may touch the bound of the ball's. Balls along the axis tell of all of the cell.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "cell_bound.hpp"

namespace vcell::whole {

class TubeBound {
public:
    /// Bounds what has its feet between these: it ends at the box, among `others`, and at a probe.
    TubeBound(const Cylinder& tube, const std::array<Vec3, 2>& feet, const Box& box,
              std::span<const Object> others, std::optional<double> probe);

    bool may_touch(const Object& object) const;
    /// None of its points is farther from the axis.
    double farthest() const;

private:
    struct Piece {
        CellBound of_ball;
        double half;  // h
        double last;  // how far the last of those is that bound it
    };
    Piece piece(const Vec3& begin, const Vec3& end) const;
    void add(const Vec3& begin, const Vec3& end, int divisions);

    const Cylinder& tube_;
    const Box& box_;
    std::span<const Object> others_;
    std::optional<double> probe_;
    std::vector<Piece> pieces_;
};

}  // namespace vcell::whole
