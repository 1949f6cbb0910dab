/// Disjoint sets, merged and asked for (union-find, with paths halved).
#pragma once

#include "platform.hpp"

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace vcell {

class Partition {
public:
    /// Sets of one element each, 0 ... n - 1.
    explicit Partition(std::size_t n = 0) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }

    std::size_t size() const { return parent_.size(); }
    void reserve(std::size_t n) { parent_.reserve(n); }
    /// One more element, in a set of its own.
    std::uint32_t add() {
        parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
        return parent_.back();
    }
    /// The element that stands for i's set.
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    /// What stands for j's set stands for both.
    void merge(std::uint32_t i, std::uint32_t j) { parent_[find(i)] = find(j); }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace vcell
