#include "nested_balls.hpp"

#include <array>
#include <cfloat>
#include <limits>

namespace vcell {

namespace {

constexpr std::uint32_t none = UINT32_MAX;
constexpr std::uint32_t leaf_size = 8;

// Squares and their sums of differences of doubles are off by less than 8 u, relatively, and by DBL_MIN where
// they leave the range.
constexpr double tolerance = 8 * DBL_EPSILON;
bool certainly_less(double p, double q) { return p * (1 + tolerance) + DBL_MIN < q; }

bool is_inside(const Ball& inner, const Ball& outer) {
    const double gap = outer.rho - inner.rho;
    const double x = inner.cx - outer.cx, y = inner.cy - outer.cy, z = inner.cz - outer.cz;
    const double apart2 = x * x + y * y + z * z, gap2 = gap * gap;
    // Most pairs end here, half of them by either condition: one branch that is well foreseen, not two.
    if (static_cast<int>(gap <= 0) | static_cast<int>(certainly_less(gap2, apart2))) return false;
    if (certainly_less(apart2, gap2)) return true;
    const Exact ex = Exact(inner.cx) - outer.cx, ey = Exact(inner.cy) - outer.cy,
                ez = Exact(inner.cz) - outer.cz;
    const Exact eg = Exact(outer.rho) - inner.rho;
    return (eg * eg - ex * ex - ey * ey - ez * ez).sign() != Sign::Negative;
}

class BallTree {
public:
    explicit BallTree(std::span<const Ball> balls) {
        items_.reserve(balls.size());
        for (std::uint32_t i = 0; i < balls.size(); ++i) items_.push_back({balls[i], i});
        nodes_.reserve(4 * balls.size() / leaf_size + 1);
        add_node(0, static_cast<std::uint32_t>(balls.size()));
    }

    // Neighbours ask together: one walk through the tree for each leaf.
    std::vector<std::uint32_t> enclosing() const {
        std::vector<std::uint32_t> result(items_.size(), none);
        for (const Node& leaf : nodes_) {
            if (!is_leaf(leaf)) continue;
            for (std::uint32_t n = 0; n < nodes_.size();) {
                const Node& node = nodes_[n];
                const bool met = may_enclose(node, leaf);
                if (met && is_leaf(node)) compare(leaf, node, result);
                n = met ? n + 1 : node.skip;
            }
        }
        return result;
    }

private:
    struct Item {
        Ball ball;
        std::uint32_t index;
    };
    // In preorder: what follows the subtree of a node is at `skip`.
    struct Node {
        std::array<double, 3> low, high;
        double smallest, largest;  // radii
        std::uint32_t begin, end, skip;
    };
    static bool is_leaf(const Node& node) { return node.end - node.begin <= leaf_size; }

    static double coordinate(const Ball& b, int k) { return k == 0 ? b.cx : k == 1 ? b.cy : b.cz; }

    static bool may_enclose(const Node& outer, const Node& inner) {
        const double gap = outer.largest - inner.smallest;
        if (!(gap > 0)) return false;
        double apart2 = 0;
        for (int k = 0; k < 3; ++k) {
            const double d = std::max({outer.low[k] - inner.high[k], inner.low[k] - outer.high[k], 0.0});
            apart2 += d * d;
        }
        return !certainly_less(gap * gap, apart2);
    }

    void compare(const Node& inner, const Node& outer, std::vector<std::uint32_t>& result) const {
        for (std::uint32_t i = inner.begin; i < inner.end; ++i)
            for (std::uint32_t k = outer.begin; k < outer.end; ++k)
                if (is_inside(items_[i].ball, items_[k].ball)) result[items_[i].index] = items_[k].index;
    }

    void add_node(std::uint32_t begin, std::uint32_t end) {
        Node node{{}, {}, std::numeric_limits<double>::infinity(), 0, begin, end, 0};
        node.low.fill(std::numeric_limits<double>::infinity());
        node.high.fill(-std::numeric_limits<double>::infinity());
        for (std::uint32_t i = begin; i < end; ++i) {
            const Ball& b = items_[i].ball;
            for (int k = 0; k < 3; ++k) {
                node.low[k] = std::min(node.low[k], coordinate(b, k));
                node.high[k] = std::max(node.high[k], coordinate(b, k));
            }
            node.smallest = std::min(node.smallest, b.rho);
            node.largest = std::max(node.largest, b.rho);
        }
        const std::size_t place = nodes_.size();
        nodes_.push_back(node);
        if (end - begin > leaf_size) {
            int widest = 0;
            for (int k = 1; k < 3; ++k)
                if (node.high[k] - node.low[k] > node.high[widest] - node.low[widest]) widest = k;
            const std::uint32_t middle = begin + (end - begin) / 2;
            std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                             [&](const Item& i, const Item& j) {
                                 return coordinate(i.ball, widest) < coordinate(j.ball, widest);
                             });
            add_node(begin, middle);
            add_node(middle, end);
        }
        nodes_[place].skip = static_cast<std::uint32_t>(nodes_.size());
    }

    std::vector<Item> items_;
    std::vector<Node> nodes_;
};

// Of a few balls the tree costs more than pairs do whose centres are near each other along x.
std::vector<std::uint32_t> enclosing_by_sweep(std::span<const Ball> balls, double largest_gap) {
    std::vector<std::uint32_t> result(balls.size(), none), order(balls.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t i) { return balls[i].cx; });
    const double reach = largest_gap * (1 + tolerance);
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t k = i + 1; k < order.size(); ++k) {
            const Ball &p = balls[order[i]], &q = balls[order[k]];
            if (q.cx - p.cx > reach) break;
            if (is_inside(p, q)) result[order[i]] = order[k];
            if (is_inside(q, p)) result[order[k]] = order[i];
        }
    return result;
}

}  // namespace

std::vector<std::uint32_t> enclosing_balls(std::span<const Ball> balls) {
    constexpr std::size_t few = 128;
    const auto [smallest, largest] = std::ranges::minmax_element(balls, {}, &Ball::rho);
    if (balls.empty() || smallest->rho == largest->rho) return std::vector(balls.size(), none);
    if (balls.size() <= few) return enclosing_by_sweep(balls, largest->rho - smallest->rho);
    return BallTree(balls).enclosing();
}

}  // namespace vcell
