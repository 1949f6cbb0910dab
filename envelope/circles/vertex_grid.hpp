/// Vertices of a diagram that grows, by place: where to set out for another place.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "../../core/platform.hpp"

namespace vcell {

/// Grids of squares over a rectangle, each twice as fine as the one before; a cell has the last vertex that
/// was put there.
class VertexGrid {
public:
    using Index = std::uint32_t;
    static constexpr Index none = UINT32_MAX;

    /// Empties it; the finest grid gets about as many cells as there are to be vertices.
    void start(double x0, double x1, double y0, double y1, std::size_t vertices) {
        levels_ = 1;
        while ((std::size_t{1} << (2 * levels_)) < vertices && levels_ < most_levels) ++levels_;
        x0_ = x0;
        y0_ = y0;
        const double cells = side();
        scale_x_ = cells / (x1 - x0);
        scale_y_ = cells / (y1 - y0);
        cells_.assign(first(levels_ + 1), none);
    }

    void put(double x, double y, Index v) {
        std::uint32_t i = column(x), j = row(y);
        for (unsigned level = levels_; level > 0; --level, i >>= 1, j >>= 1) cell(level, i, j) = v;
    }
    /// A vertex in the smallest cell about the place that has one for which is_there(v).
    template <class IsThere>
    Index find(double x, double y, IsThere&& is_there) const {
        std::uint32_t i = column(x), j = row(y);
        for (unsigned level = levels_; level > 0; --level, i >>= 1, j >>= 1)
            if (const Index v = cells_[first(level) + (std::size_t{j} << level) + i];
                v != none && is_there(v))
                return v;
        return none;
    }

private:
    static constexpr unsigned most_levels = 12;

    std::uint32_t side() const { return 1u << levels_; }
    // Where the cells of a level begin, which has 2^level columns: after all coarser ones.
    static std::size_t first(unsigned level) { return ((std::size_t{1} << (2 * level)) - 4) / 3; }
    Index& cell(unsigned level, std::uint32_t i, std::uint32_t j) {
        return cells_[first(level) + (std::size_t{j} << level) + i];
    }
    // In a rectangle of next to no width t may be no number.
    std::uint32_t clamped(double t) const {
        return t > 0 ? static_cast<std::uint32_t>(std::min(t, static_cast<double>(side() - 1))) : 0;
    }
    std::uint32_t column(double x) const { return clamped((x - x0_) * scale_x_); }
    std::uint32_t row(double y) const { return clamped((y - y0_) * scale_y_); }

    unsigned levels_ = 1;
    double x0_ = 0, y0_ = 0, scale_x_ = 0, scale_y_ = 0;
    std::vector<Index> cells_;
};

}  // namespace vcell
