#include "sweep_status.hpp"

namespace vcell {

SweepStatus::Node SweepStatus::insert_above(Node below, std::uint32_t value) {
    random_ ^= random_ << 13;
    random_ ^= random_ >> 17;
    random_ ^= random_ << 5;
    const Node above = below == none ? first_ : nodes_[below].above;
    const Data data{none, none, none, below, above, random_, value};
    Node n;
    if (free_.empty()) {
        n = static_cast<Node>(nodes_.size());
        nodes_.push_back(data);
    } else {
        n = free_.back();
        free_.pop_back();
        nodes_[n] = data;
    }
    (below == none ? first_ : nodes_[below].above) = n;
    if (above != none) nodes_[above].below = n;

    // Of two neighbours in the order, one has a free place towards the other.
    if (below != none && nodes_[below].right == none) {
        nodes_[below].right = n;
        nodes_[n].parent = below;
    } else if (above != none) {
        nodes_[above].left = n;
        nodes_[n].parent = above;
    } else {
        root_ = n;
    }
    while (nodes_[n].parent != none && nodes_[nodes_[n].parent].priority < nodes_[n].priority) rotate_up(n);
    return n;
}

void SweepStatus::erase(Node n) {
    const auto& [parent, left, right, below, above, priority, value] = nodes_[n];
    while (left != none && right != none) {
        rotate_up(nodes_[left].priority > nodes_[right].priority ? left : right);
    }
    const Node child = left != none ? left : right;
    link_to(n) = child;
    if (child != none) nodes_[child].parent = parent;
    (below == none ? first_ : nodes_[below].above) = above;
    if (above != none) nodes_[above].below = below;
    free_.push_back(n);
}

void SweepStatus::rotate_up(Node n) {
    const Node p = nodes_[n].parent;
    link_to(p) = n;
    nodes_[n].parent = nodes_[p].parent;
    nodes_[p].parent = n;
    Node& inner = nodes_[p].left == n ? nodes_[n].right : nodes_[n].left;
    (nodes_[p].left == n ? nodes_[p].left : nodes_[p].right) = inner;
    if (inner != none) nodes_[inner].parent = p;
    inner = p;
}

}  // namespace vcell
