/// Space cut into blocks, one for each rank, with about as many balls in each.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "../envelope/whole/image_tree.hpp"
#include "ranks.hpp"

namespace vcell::mpi {

/// A k-d tree whose leaves are the ranks. Which rank has a ball is a matter of speed alone: no result
/// depends on it.
class KdBlocks {
public:
    /// From a sample of all ranks' points, the same on all of them. `count` of them are held by all ranks
    /// together.
    KdBlocks(Ranks& ranks, const std::vector<Vec3>& points, std::uint64_t count);

    int rank_of(const Vec3& point) const;

private:
    // A point and, for points that share coordinates, the order of the other axes.
    using Key = std::array<double, 3>;
    static Key key(const Vec3& p, int axis) { return {p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

    struct Node {
        int axis = 0, rank = -1;  // of a leaf
        Key from{};               // the second child's points have this key or a greater one
        std::size_t second = 0;   // the first child comes next
    };
    void build(std::vector<Vec3>::iterator begin, std::vector<Vec3>::iterator end, int first, int last);

    std::vector<Node> nodes_;
};

/// What every rank knows of all blocks: where their balls' centres are, and how large balls are.
class BlockMap {
public:
    struct Block {
        Box centers;
        double largest = -1;  // radius; negative: there is no ball
    };

    BlockMap() = default;
    /// `mine` is this rank's.
    BlockMap(Ranks& ranks, const whole::Lattice& lattice, const Block& mine);

    /// Calls visit(rank) for other ranks that may have balls, images included, whose surfaces are `reach`
    /// from the point, or less.
    template <class Visit>
    void near(const Vec3& point, double reach, Visit&& visit) const {
        search(
            point, reach, [](const Box&, double, const Vec3&) { return true; }, visit);
    }
    /// Calls visit for balls, images included, that may touch a cell: the bound is a CellBound, or CellMarks.
    template <class Bound, class Visit>
    void touching(const Bound& bound, Visit&& visit) const {
        if (tree_.entries().empty()) return;
        search(
            bound.base().center, bound.extent(tree_.largest_radius()),
            [&](const Box& box, double largest, const Vec3& by) {
                return bound.may_touch(Box{box.min + by, box.max + by}, largest);
            },
            visit);
    }

private:
    // may_hold(box, radius, shift) is about a block's balls, of no more than that radius and with centres in
    // the box moved. Of balls that hold blocks it would tell nothing: marks need not tell of what a ball
    // holds what they tell of the ball.
    template <class MayHold, class Visit>
    void search(const Vec3& point, double reach, MayHold&& may_hold, Visit&& visit) const {
        const auto is_near = [&](const Box& box, double largest, const Vec3& by) {
            const Vec3 p = point - by, nearest = p.cwiseMax(box.min).cwiseMin(box.max);
            constexpr double rounding = 0x1p-44;
            const double size = point.cwiseAbs().sum() + by.cwiseAbs().sum() + nearest.cwiseAbs().sum();
            return (p - nearest).norm() - largest - rounding * (size + largest) <= reach;
        };
        if (tree_.entries().empty()) return;
        std::vector<std::uint32_t> seen;  // images of a block are one rank
        lattice_.for_images(
            tree_.centers(), tree_.largest_radius(), point, reach, [&](const whole::Image&, const Vec3& by) {
                tree_.search([&](const Box& box, double radius) { return is_near(box, radius, by); },
                             [&](const BallTree::Entry& e) {
                                 const Block& block = blocks_[e.number];
                                 if (std::ranges::find(seen, e.number) != seen.end() ||
                                     !is_near(block.centers, block.largest, by) ||
                                     !may_hold(block.centers, block.largest, by))
                                     return;
                                 seen.push_back(e.number);
                                 visit(static_cast<int>(e.number));
                             });
            });
    }

    whole::Lattice lattice_;
    std::vector<Block> blocks_;
    BallTree tree_;  // of balls that hold those of other ranks, numbered by rank
};

}  // namespace vcell::mpi
