/// The vertical order of the arcs that the sweep line meets.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "../../core/numbers/sign.hpp"

namespace vcell {

/// An ordered sequence of nodes with O(1) neighbours and O(log n) insertion, removal and search: a treap
/// [SA96] whose nodes also form a list. Positions are given by neighbours, never by comparisons: only
/// find() asks any. Nodes live in one array and are reused, so nothing is allocated per event.
class SweepStatus {
public:
    using Node = std::uint32_t;
    static constexpr Node none = UINT32_MAX;

    Node first() const { return first_; }
    Node above(Node n) const { return nodes_[n].above; }
    Node below(Node n) const { return nodes_[n].below; }
    /// The caller's datum, free for writing.
    std::uint32_t& value(Node n) { return nodes_[n].value; }

    /// A new node directly above `n`; at the very bottom when n is none.
    Node insert_above(Node n, std::uint32_t value);
    void erase(Node n);

    /// The lowest position of something that `side_of(value)` compares with the nodes: Positive when it lies
    /// above the node. Returns the node for which the answer is Zero, if met, and else the node directly
    /// below.
    template <class SideOf>
    std::pair<Node, bool> find(SideOf&& side_of) const {
        Node below = none;
        for (Node n = root_; n != none;) {
            const Sign s = side_of(nodes_[n].value);
            if (s == Sign::Zero) return {n, true};
            if (s == Sign::Positive) below = n;
            n = s == Sign::Positive ? nodes_[n].right : nodes_[n].left;
        }
        return {below, false};
    }

private:
    struct Data {
        Node parent, left, right;
        Node below, above;
        std::uint32_t priority;
        std::uint32_t value;
    };

    void rotate_up(Node n);
    Node& link_to(Node n) {
        const Node p = nodes_[n].parent;
        if (p == none) return root_;
        return nodes_[p].left == n ? nodes_[p].left : nodes_[p].right;
    }

    std::vector<Data> nodes_;
    std::vector<Node> free_;
    Node root_ = none;
    Node first_ = none;
    std::uint32_t random_ = 2463534242u;  // xorshift state [Marsaglia03]; any non-zero seed
};

}  // namespace vcell
