/// Which balls may touch a cell that is known among some: those that its marks do not show to be beaten.
///
/// A ball of centre c, relative to the base's, and radius R0 + delta is met in the direction u where 1 / t =
/// 2 (c.u + delta) / C, C = |c|^2 - delta^2. At a mark of the diagram it is certainly beyond the cell where
///
///     L C - 2 p.c - 2 delta > 0        at a place p of the level -L (SphereMarks),
///     L C - 2 n.c > 0                  for a face whose gradient is L (-n).
///
/// With the point P = p / L these are L |c - P|^2 - |p|^2 / L less what delta has: least of all balls with
/// centres in a box where that is nearest to P. As L |P| >= 1 at places,
///
///     |c - P| > |P| + |delta|
///
/// will do for both, so that marks that lie together say no together. All of it is computed in floats, four
/// marks at a time, and less than a part of 2^-19 of the terms proves nothing.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "../../primitives/objects/objects.hpp"
#include "../sphere/sphere_diagram.hpp"

namespace vcell::whole {

/// The marks of the diagram of a scene in a unit of so many of its own, and what turns them from their
/// coordinates to those of the scene.
struct PlacedMarks {
    SphereMarks marks;
    Eigen::Matrix3d turn;
    double unit;
};

class CellMarks {
public:
    /// As PlacedMarks has them.
    CellMarks(const Sphere& base, const SphereMarks& marks, const Eigen::Matrix3d& turn, double unit);
    CellMarks(const Sphere& base, const PlacedMarks& placed)
        : CellMarks(base, placed.marks, placed.turn, placed.unit) {}

    /// Do the marks bound the cell at all?
    bool are_bounds() const { return are_bounds_; }
    const Sphere& base() const { return base_; }
    /// No object touches the cell whose surface is this far from the base's centre, or farther.
    double reach() const { return reach_; }
    /// The reach as ImageTree asks for it of any bound: marks do not widen it for large balls.
    double extent(double) const { return to_; }
    /// Balls whose distance() is not in (from, to] are not asked about from now on: they are known, or come
    /// later.
    void look_between(double from, double to) {
        from_ = from;
        to_ = to;
    }
    /// Of the ball's surface from the base's centre, but for rounding.
    double distance(const Sphere& ball) const { return (ball.center - base_.center).norm() - ball.radius; }

    /// Pre: are_bounds(). False of what is not asked about.
    bool may_touch(const Sphere& ball) const;
    /// May a ball of no more than this radius with its centre in the box? Where the answer is no, that about
    /// each of these balls is no, too: what a search in a tree finds is a matter of each ball alone.
    bool may_touch(const Box& centers, double radius) const;

private:
    using Four = Eigen::Array4f;
    // Four marks that lie together: 2 p, L, and for boxes p / L and |p|^2 / L; `with_delta` is 1 of places
    // and 0 of gradients.
    struct Row {
        Four x, y, z, level, with_delta;
        Four at_x, at_y, at_z, offset;
    };
    // Spheres about what four rows can tell of, but for |delta|: centres and radii.
    struct Head {
        Four x, y, z, radius;
    };

    void add(std::size_t i, const Vec3& p, double level, bool is_place);
    void set_heads();
    /// Do all rows say no whose heads do not? is_far(head) names heads that say no, says_no(row) is asked of
    /// the others' rows.
    template <class IsFar, class SaysNo>
    bool all_say_no(const IsFar& is_far, const SaysNo& says_no) const;

    Sphere base_;
    double unit_ = 1;  // of the rows
    double steepest_;  // forms that are steeper are not compared
    double reach_ = 0, from_ = 0, to_ = 0;
    bool are_bounds_ = false;
    std::vector<Row> rows_;
    std::vector<Head> heads_;
};

}  // namespace vcell::whole
