/// A bound from above on the lower envelope of many forms over a rectangle, constant in each of many cells:
/// what a form is compared with before it is inserted.
#pragma once

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "pieces.hpp"

namespace vcell {

/// Cells are quartered from one level to the next; a cell's bound is the largest of those in it.
class Ceiling {
public:
    using Form = KernelForm;

    /// No bound yet. The finest cells hold about two of so many forms.
    void start(const Rectangle& r, std::size_t forms) {
        levels_ = 0;
        while ((std::size_t{2} << (2 * levels_)) < forms && levels_ < most_levels) ++levels_;
        x0_ = r.x0;
        y0_ = r.y0;
        x1_ = r.x1;
        y1_ = r.y1;
        bounds_.assign(first(levels_ + 1), HUGE_VAL);
        for (unsigned level = 0; level <= levels_; ++level) {
            constexpr double margin = 0x1p-46;
            const double size = std::ldexp(1.0, -static_cast<int>(level)), width = size * (r.x1 - r.x0),
                         height = size * (r.y1 - r.y0);
            sizes_[level] = {width, height, 0.5 * width + margin * (std::abs(r.x0) + std::abs(r.x1)),
                             0.5 * height + margin * (std::abs(r.y0) + std::abs(r.y1))};
        }
    }
    /// Takes notice of a form, which is low near (x, y) of the rectangle.
    void add(const Form& f, double x, double y) {
        const std::int32_t side = 1 << levels_;
        auto [i, j] = finest(x, y);
        for (std::int32_t q = std::max(j - 1, 0); q <= std::min(j + 1, side - 1); ++q)
            for (std::int32_t p = std::max(i - 1, 0); p <= std::min(i + 1, side - 1); ++p)
                lower(f, levels_, p, q);
        for (unsigned level = levels_; level-- > 0;) lower(f, level, i >>= 1, j >>= 1);
    }
    /// All forms have been added.
    void finish() {
        for (unsigned level = 0; level < levels_; ++level)
            for_cells(level, [&](std::int32_t i, std::int32_t j) {
                for (std::int32_t k = 0; k < 4; ++k) {
                    double& part = bound(level + 1, 2 * i + k % 2, 2 * j + k / 2);
                    part = std::min(part, bound(level, i, j));
                }
            });
        for (unsigned level = levels_; level-- > 0;)
            for_cells(level, [&](std::int32_t i, std::int32_t j) {
                double& all = bound(level, i, j) = -HUGE_VAL;
                for (std::int32_t k = 0; k < 4; ++k)
                    all = std::max(all, bound(level + 1, 2 * i + k % 2, 2 * j + k / 2));
            });
    }
    /// Is the form certainly nowhere the lowest in the rectangle? Pre: finish().
    bool hides(const Form& f) const { return hides(f, 0, 0, 0); }
    /// Is it so because it is higher than all bounds where it is least, at (x, y)? Rounding may have moved
    /// that place by some units in the last place.
    bool is_over_all(const Form& f, double x, double y) const {
        const BoxForm b = f.over_box(x, y, 0, 0);
        return b.v - 64 * DBL_EPSILON * b.scale > bounds_.front();
    }
    /// Is it not certainly higher than the bound near (x, y)? Forms that are least there hardly ever are, and
    /// then nothing else need be asked.
    bool is_open(const Form& f, double x, double y) const {
        const auto [i, j] = finest(x, y);
        return !is_above(f, levels_, i, j);
    }

private:
    static constexpr unsigned most_levels = 12;

    // The cells of a level have it; half sides reach a little farther, so that rounding leaves no gap.
    struct Size {
        double width, height, rx, ry;
    };
    std::array<std::int32_t, 2> finest(double x, double y) const {
        const std::int32_t side = 1 << levels_;
        // In a rectangle of next to no width t may be no number.
        const auto index = [&](double t) {
            return t > 0 ? static_cast<std::int32_t>(std::min(t * side, side - 1.0)) : 0;
        };
        return {index((x - x0_) / (x1_ - x0_)), index((y - y0_) / (y1_ - y0_))};
    }
    BoxForm over_cell(const Form& f, unsigned level, std::int32_t i, std::int32_t j) const {
        const Size& size = sizes_[level];
        return f.over_box(x0_ + (i + 0.5) * size.width, y0_ + (j + 0.5) * size.height, size.rx, size.ry);
    }
    static std::size_t first(unsigned level) { return ((std::size_t{1} << (2 * level)) - 1) / 3; }
    std::size_t index(unsigned level, std::int32_t i, std::int32_t j) const {
        return first(level) + (static_cast<std::size_t>(j) << level) + static_cast<std::size_t>(i);
    }
    double& bound(unsigned level, std::int32_t i, std::int32_t j) { return bounds_[index(level, i, j)]; }
    template <class Visit>
    void for_cells(unsigned level, Visit&& visit) {
        for (std::int32_t j = 0; j < 1 << level; ++j)
            for (std::int32_t i = 0; i < 1 << level; ++i) visit(i, j);
    }
    // box_form()'s top is off by fewer roundings of its scale than excess() allows.
    void lower(const Form& f, unsigned level, std::int32_t i, std::int32_t j) {
        const BoxForm b = over_cell(f, level, i, j);
        double& all = bound(level, i, j);
        all = std::min(all, b.top + 64 * DBL_EPSILON * b.scale);
    }
    bool is_above(const Form& f, unsigned level, std::int32_t i, std::int32_t j) const {
        const double all = bounds_[index(level, i, j)];
        return BoxForm::certainly_above(over_cell(f, level, i, j), {all, 0, 0, 0, all, std::abs(all)},
                                        sizes_[level].rx, sizes_[level].ry);
    }
    bool hides(const Form& f, unsigned level, std::int32_t i, std::int32_t j) const {
        if (is_above(f, level, i, j)) return true;
        if (level == levels_) return false;
        for (std::int32_t k = 0; k < 4; ++k)
            if (!hides(f, level + 1, 2 * i + k % 2, 2 * j + k / 2)) return false;
        return true;
    }

    unsigned levels_ = 0;
    double x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;
    std::array<Size, most_levels + 1> sizes_;
    std::vector<double> bounds_;
};

}  // namespace vcell
