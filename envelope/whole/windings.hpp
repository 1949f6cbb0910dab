/// What winds through a box that repeats.
#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "image_tree.hpp"

namespace vcell::whole {

/// By how many edges of the box a way leads from a place to an image of another one.
using Offset = std::array<std::int64_t, 3>;

inline Offset operator+(const Offset& a, const Offset& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Offset operator-(const Offset& a, const Offset& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Offset offset(const Image& image) { return {image[0], image[1], image[2]}; }
inline bool winds(const Offset& way) { return way != Offset{0, 0, 0}; }

/// Sets of places that ways join, each place with the image of it that they lead to from the place that
/// stands for its set (union-find with offsets).
class Windings {
public:
    explicit Windings(std::size_t places) : parent_(places), offset_(places, Offset{0, 0, 0}) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    /// Whoever stands for i's set, and i's image seen from there.
    std::pair<std::uint32_t, Offset> find(std::uint32_t i) {
        std::uint32_t root = i;
        Offset sum{0, 0, 0};
        for (; parent_[root] != root; root = parent_[root]) sum = sum + offset_[root];
        // All on the way are told their root.
        for (Offset rest = sum; parent_[i] != i;) {
            const Offset step = std::exchange(offset_[i], rest);
            i = std::exchange(parent_[i], root);
            rest = rest - step;
        }
        return {root, sum};
    }
    /// Joins two places by a way. The winding that it closes where both are in one set already.
    Offset join(std::uint32_t from, std::uint32_t to, const Offset& way) {
        const auto [a, at_a] = find(from);
        const auto [b, at_b] = find(to);
        const Offset closed = at_a + way - at_b;
        if (a == b) return closed;
        parent_[b] = a;
        offset_[b] = closed;
        return {0, 0, 0};
    }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<Offset> offset_;  // from the parent
};

}  // namespace vcell::whole
