#include "nested_balls.hpp"

#include <algorithm>
#include <array>
#include <cfloat>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace vcell {

namespace {

constexpr std::uint32_t no_ball = UINT32_MAX;
constexpr std::uint32_t leaf_size = 8;

// Squares and their sums of differences of doubles are off by less than 8 u, relatively, and by DBL_MIN where
// they leave the range.
constexpr double tolerance = 8 * DBL_EPSILON;
bool certainly_less(double p, double q) { return p * (1 + tolerance) + DBL_MIN < q; }

// Of two balls: the squares of the distance of their centres and of the difference of their radii.
struct Apart {
    double centres2, radii2;

    Apart(const Ball& p, const Ball& q) {
        const double x = p.cx - q.cx, y = p.cy - q.cy, z = p.cz - q.cz, gap = p.rho - q.rho;
        centres2 = x * x + y * y + z * z;
        radii2 = gap * gap;
    }
    bool is_certainly_nested() const { return certainly_less(centres2, radii2); }
    bool is_certainly_not_nested() const { return certainly_less(radii2, centres2); }
};

bool is_inside(const Ball& inner, const Ball& outer) {
    const Apart apart(inner, outer);
    // Most pairs end here, half of them by either condition: one branch that is well foreseen, not two.
    if (static_cast<int>(outer.rho <= inner.rho) | static_cast<int>(apart.is_certainly_not_nested()))
        return false;
    if (apart.is_certainly_nested()) return true;
    const Exact ex = Exact(inner.cx) - outer.cx, ey = Exact(inner.cy) - outer.cy,
                ez = Exact(inner.cz) - outer.cz;
    const Exact eg = Exact(outer.rho) - inner.rho;
    return (eg * eg - ex * ex - ey * ey - ez * ez).sign() != Sign::Negative;
}

// Of two balls the larger one, of equally large ones the first; either may be no_ball.
std::uint32_t larger(std::span<const Ball> balls, std::uint32_t i, std::uint32_t k) {
    if (i == no_ball || k == no_ball) return std::min(i, k);
    const double difference = balls[i].rho - balls[k].rho;
    return difference > 0 || (difference == 0 && i < k) ? i : k;
}

class BallTree {
public:
    // Of the balls that are the first of their equals.
    BallTree(std::span<const Ball> balls, std::span<const std::uint32_t> first) : balls_(balls) {
        items_.reserve(balls.size());
        for (std::uint32_t i = 0; i < balls.size(); ++i)
            if (first[i] == i) items_.push_back({balls[i], i});
        nodes_.reserve(4 * items_.size() / leaf_size + 1);
        add_node(0, static_cast<std::uint32_t>(items_.size()));
    }

    // Neighbours ask together: one walk through the tree for each leaf.
    std::vector<std::uint32_t> enclosing() const {
        std::vector<std::uint32_t> result(balls_.size(), no_ball);
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
                if (is_inside(items_[i].ball, items_[k].ball)) {
                    std::uint32_t& best = result[items_[i].index];
                    best = larger(balls_, best, items_[k].index);
                }
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

    std::span<const Ball> balls_;
    std::vector<Item> items_;
    std::vector<Node> nodes_;
};

// In slabs across x, so thick that balls in each other are in the same slab or in neighbours. None if that
// leaves so many pairs that the tree is faster.
std::optional<BallNesting> nesting_by_slabs(std::span<const Ball> balls) {
    constexpr std::size_t pairs_per_ball = 32;  // about what the tree costs
    const std::size_t n = balls.size();
    double low = balls[0].cx, high = low, smallest = balls[0].rho, largest = smallest;
    for (const Ball& b : balls) {
        low = std::min(low, b.cx);
        high = std::max(high, b.cx);
        smallest = std::min(smallest, b.rho);
        largest = std::max(largest, b.rho);
    }
    // The slack outweighs the rounding of places of at most 2^32, which are off by a few units of 2^-53 each.
    const double thickness =
        std::max((largest - smallest) * (1 + 0x1p-10), (high - low) / static_cast<double>(n));
    const double per_length = thickness > DBL_MIN ? 1 / thickness : 0;
    const auto slab = [&](double x) { return static_cast<std::uint32_t>((x - low) * per_length); };

    // begin[s] is first the number of balls of slab s, then their end, and at last their begin.
    const std::uint32_t slabs = slab(high) + 1;
    std::vector<std::uint32_t> begin(slabs + 2);
    for (const Ball& b : balls) ++begin[slab(b.cx)];
    std::size_t pairs = 0, before = 0, end = 0;
    for (std::uint32_t& b : begin) {
        pairs += b * (b + 2 * before) / 2;
        before = b;
        b = static_cast<std::uint32_t>(end += before);
    }
    if (pairs > pairs_per_ball * n) return std::nullopt;
    struct Item {
        Ball ball;
        std::uint32_t index;
    };
    std::vector<Item> items(n);
    for (std::uint32_t i = 0; i < n; ++i) items[--begin[slab(balls[i].cx)]] = {balls[i], i};

    BallNesting nesting{std::vector<std::uint32_t>(n), std::vector(n, no_ball)};
    auto& [first, enclosing] = nesting;
    std::iota(first.begin(), first.end(), 0u);
    const auto relate = [&](const Item& p, const Item& q) {
        if (p.ball == q.ball) {
            std::uint32_t& later = first[std::max(p.index, q.index)];
            later = std::min({later, p.index, q.index});
        } else if (is_inside(p.ball, q.ball)) {
            enclosing[p.index] = larger(balls, enclosing[p.index], q.index);
        } else if (is_inside(q.ball, p.ball)) {
            enclosing[q.index] = larger(balls, enclosing[q.index], p.index);
        }
    };
    for (std::uint32_t s = 0; s < slabs; ++s)
        for (std::uint32_t i = begin[s]; i < begin[s + 1]; ++i)
            for (std::uint32_t k = i + 1; k < begin[s + 2]; ++k)
                if (!Apart(items[i].ball, items[k].ball).is_certainly_not_nested())
                    relate(items[i], items[k]);
    return nesting;
}

BallNesting nesting_by_tree(std::span<const Ball> balls) {
    BallNesting nesting{first_equal(balls), {}};
    auto& [first, enclosing] = nesting;
    const auto same = [&](const Ball& b) { return b.rho == balls[0].rho; };
    if (std::ranges::all_of(balls, same)) {
        enclosing.assign(balls.size(), no_ball);
        return nesting;
    }
    enclosing = BallTree(balls, first).enclosing();
    for (std::size_t i = 0; i < balls.size(); ++i) enclosing[i] = enclosing[first[i]];
    return nesting;
}

}  // namespace

BallNesting ball_nesting(std::span<const Ball> balls) {
    if (balls.empty()) return {};
    auto nesting = nesting_by_slabs(balls);
    return nesting ? std::move(*nesting) : nesting_by_tree(balls);
}

}  // namespace vcell
