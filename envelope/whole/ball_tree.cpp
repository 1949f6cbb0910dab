#include "ball_tree.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <utility>

namespace vcell {

BallTree::BallTree(std::vector<Entry> balls) : balls_(std::move(balls)) {
    if (!balls_.empty()) build(0, static_cast<std::uint32_t>(balls_.size()));
}

void BallTree::build(std::uint32_t begin, std::uint32_t end) {
    constexpr std::uint32_t leaf = 8;
    const auto at = nodes_.size();
    Node node{{balls_[begin].ball.center, balls_[begin].ball.center}, 0, begin, end};
    for (std::uint32_t i = begin; i < end; ++i) {
        node.box.min = node.box.min.cwiseMin(balls_[i].ball.center);
        node.box.max = node.box.max.cwiseMax(balls_[i].ball.center);
        node.largest = std::max(node.largest, balls_[i].ball.radius);
    }
    nodes_.push_back(node);
    if (end - begin <= leaf) return;
    Eigen::Index axis;
    (node.box.max - node.box.min).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    // Numbers settle ties: the tree is the same wherever it is built.
    std::nth_element(balls_.begin() + begin, balls_.begin() + middle, balls_.begin() + end,
                     [axis](const Entry& a, const Entry& b) {
                         return std::pair(a.ball.center[axis], a.number) <
                                std::pair(b.ball.center[axis], b.number);
                     });
    build(begin, middle);
    nodes_[at].second = static_cast<std::uint32_t>(nodes_.size());
    build(middle, end);
}

std::vector<BallTree::Leaf> BallTree::leaves() const {
    std::vector<Leaf> leaves;
    if (!nodes_.empty()) add_leaves(0, 0, leaves);
    return leaves;
}

void BallTree::add_leaves(std::uint32_t at, double spacing, std::vector<Leaf>& leaves) const {
    // Fewer have a box that is too small for them by what lies beside them.
    constexpr std::uint32_t many = 64;
    const Node& node = nodes_[at];
    const std::uint32_t count = node.end - node.begin;
    if (count >= many || at == 0) spacing = std::cbrt((node.box.max - node.box.min).prod() / count);
    if (node.second == 0) {
        leaves.push_back({entries().subspan(node.begin, count), node.box, spacing});
        return;
    }
    add_leaves(at + 1, spacing, leaves);
    add_leaves(node.second, spacing, leaves);
}

void BallTree::nearest(const Vec3& point, std::size_t count,
                       std::vector<std::pair<double, std::uint32_t>>& out) const {
    if (nodes_.empty() || count == 0) return;
    using Waiting = std::pair<double, std::uint32_t>;  // least distance, node
    std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> nodes;
    using Found = std::tuple<double, std::uint32_t, std::uint32_t>;  // distance, number, place
    std::priority_queue<Found> found;                                // the farthest on top
    nodes.emplace(least_distance(nodes_[0], point), 0u);
    while (!nodes.empty()) {
        const auto [least, at] = nodes.top();
        nodes.pop();
        if (found.size() == count && !(least <= std::get<0>(found.top()))) break;
        const Node& node = nodes_[at];
        if (node.second != 0) {
            for (const std::uint32_t child : {at + 1, node.second})
                nodes.emplace(least_distance(nodes_[child], point), child);
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            found.emplace(distance(balls_[i], point), balls_[i].number, i);
            if (found.size() > count) found.pop();
        }
    }
    for (; !found.empty(); found.pop()) out.emplace_back(std::get<0>(found.top()), std::get<2>(found.top()));
}

}  // namespace vcell
