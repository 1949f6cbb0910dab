/// Balls in a tree of boxes, for searches by their distance from a point.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "../../primitives/objects/objects.hpp"

namespace vcell {

class BallTree {
public:
    struct Entry {
        Sphere ball;
        std::uint32_t number;  ///< the caller's
    };

    BallTree() = default;
    /// O(n log n).
    explicit BallTree(std::vector<Entry> balls);

    /// Calls visit(entry) for balls whose surfaces are less than `reach` from the point, distances being
    /// negative inside: for all of them, and for those that are not by a rounding.
    template <class Visit>
    void within(const Vec3& point, double reach, Visit&& visit) const {
        if (!nodes_.empty()) within(0, point, reach, visit);
    }

    /// Calls visit(entry) for balls that a question does not leave out: may_hold(box, radius) is asked about
    /// balls of at most that radius with centres in a box, visit decides about each.
    template <class MayHold, class Visit>
    void search(MayHold&& may_hold, Visit&& visit) const {
        if (!nodes_.empty()) search(0, may_hold, visit);
    }

    /// Appends the `count` balls whose surfaces are nearest to the point, as pairs of that distance, as
    /// doubles have it, and the ball's place in entries(), in no order. Of equally near ones those of lower
    /// numbers: which ones is no matter of what else the tree holds. Fewer only where there are no more.
    void nearest(const Vec3& point, std::size_t count,
                 std::vector<std::pair<double, std::uint32_t>>& out) const;

    std::span<const Entry> entries() const { return balls_; }
    /// Balls that lie together, some at a time.
    struct Leaf {
        std::span<const Entry> balls;
        Box box;  ///< of their centres
        double
            spacing;  ///< cube root of the room that a ball has thereabouts, zero where they lie in a plane
    };
    std::vector<Leaf> leaves() const;
    double largest_radius() const { return nodes_.empty() ? 0 : nodes_.front().largest; }
    /// Holds all centres. Pre: there is a ball.
    const Box& centers() const { return nodes_.front().box; }

private:
    struct Node {
        Box box;         // of the centres
        double largest;  // radius
        std::uint32_t begin, end;
        std::uint32_t second = 0;  // the first child comes next; 0: a leaf
    };
    // Distances of doubles are off by less than this part of the coordinates in them.
    static constexpr double rounding = 0x1p-48;

    static double distance(const Entry& e, const Vec3& p) {
        return (e.ball.center - p).norm() - e.ball.radius;
    }
    static double slack(const Vec3& p, const Vec3& q, double radius) {
        return rounding * (p.cwiseAbs().sum() + q.cwiseAbs().sum() + radius);
    }
    // Twice the slack of balls: no ball is found in one tree and left out by the boxes of another.
    static double least_distance(const Node& node, const Vec3& p) {
        const Vec3 nearest = p.cwiseMax(node.box.min).cwiseMin(node.box.max);
        return (p - nearest).norm() - node.largest - 2 * slack(p, nearest, node.largest);
    }

    void build(std::uint32_t begin, std::uint32_t end);
    void add_leaves(std::uint32_t at, double spacing, std::vector<Leaf>& leaves) const;

    template <class Visit>
    void within(std::uint32_t at, const Vec3& point, double reach, Visit&& visit) const {
        const Node& node = nodes_[at];
        if (!(least_distance(node, point) < reach)) return;
        if (node.second != 0) {
            within(at + 1, point, reach, visit);
            within(node.second, point, reach, visit);
            return;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            const Entry& e = balls_[i];
            if (distance(e, point) - slack(point, e.ball.center, e.ball.radius) < reach) visit(e);
        }
    }

    template <class MayHold, class Visit>
    void search(std::uint32_t at, MayHold&& may_hold, Visit&& visit) const {
        const Node& node = nodes_[at];
        if (!may_hold(node.box, node.largest)) return;
        if (node.second != 0) {
            search(at + 1, may_hold, visit);
            search(node.second, may_hold, visit);
            return;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) visit(balls_[i]);
    }

    std::vector<Entry> balls_;
    std::vector<Node> nodes_;
};

}  // namespace vcell
