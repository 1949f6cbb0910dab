/// Branch and bound behind solve(): splits boxes until each is empty, holds one proved root or is beyond
/// the arithmetic's reach. Written once for both rungs, T = Interval and T = Wide.
#pragma once

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "../../errors.hpp"
#include "../newton/box.hpp"
#include "../newton/krawczyk.hpp"
#include "../newton/newton.hpp"
#include "../newton/quadratic_kernel.hpp"

namespace vcell::detail {

/// A root in `box`, the only one in `region`.
template <class T, int N>
struct Found {
    std::array<T, N> box;
    std::array<T, N> region;
};

/// The tightest enclosure that repeated steps give, or the first one with all sides narrower than
/// 2^-bits max(1, |x_i|). Pre: `found` holds exactly one root.
template <class T, int N, class Steps>
std::array<T, N> tightened(const Steps& steps, std::array<T, N> found, int bits = INT_MAX) {
    const auto excess = [bits](const std::array<T, N>& box) {
        double sum = 0;
        bool done = true;
        for (const T& side : box) {
            const double width = approximate_width(side);
            done = done && width < std::ldexp(std::max(1.0, std::abs(approximate(side))), -bits);
            sum += width;
        }
        return done ? 0 : sum;
    };
    for (double before = excess(found), after = 0; before > 0; before = after) {
        const auto tighter = intersection(found, steps.step(found).image);
        if (!tighter) throw InternalError("solver: a proved root has vanished");
        found = *tighter;
        after = excess(found);
        if (!(after < 0.9 * before)) break;
    }
    return found;
}

/// The steps of a model in interval arithmetic.
template <class T, int N, class Model>
class IntervalSteps {
public:
    explicit IntervalSteps(Model model) : model_(std::move(model)) {}
    Step<T, N> step(const std::array<T, N>& box) const {
        return krawczyk_step<T, N>(model_, box, Preconditioning::Inverse);
    }
    Step<T, N> careful_step(const std::array<T, N>& box) const {
        return krawczyk_step<T, N>(model_, box, Preconditioning::RankRevealing);
    }
    std::array<T, N> tightened(const std::array<T, N>& found) const {
        return detail::tightened<T, N>(*this, found);
    }
    const Model& model() const { return model_; }

private:
    Model model_;
};

/// The steps of a quadratic system in double.
template <int N>
class QuadraticSteps {
public:
    QuadraticSteps(const QuadraticForms<N, Interval>& forms, const IntervalBox<N>& domain)
        : kernel_(forms, domain), model_(forms) {}
    Step<Interval, N> step(const IntervalBox<N>& box) const { return kernel_.step(box); }
    Step<Interval, N> careful_step(const IntervalBox<N>& box) const {
        return krawczyk_step<Interval, N>(model_, box, Preconditioning::RankRevealing);
    }
    // One proof about Newton's result replaces the steps that would lead there.
    IntervalBox<N> tightened(const IntervalBox<N>& found) const {
        const Step<Interval, N> s = kernel_.step(kernel_.approximate_root(mid(found)));
        if (s.unique() && is_subset(s.image, found)) return s.image;
        return detail::tightened<Interval, N>(*this, found);
    }

private:
    QuadraticKernel<N> kernel_;
    QuadraticModel<Interval, N> model_;
};

template <class T, int N, class Steps>
class Search {
public:
    using Box = std::array<T, N>;
    struct Limits {
        std::size_t max_boxes;
        double min_width;  ///< a box whose sides are all narrower is not split
    };

    Search(const Steps& steps, const Box& domain, Limits limits) : steps_(steps), limits_(limits) {
        for (int i = 0; i < N; ++i) domain_width_[i] = approximate_width(domain[i]);
        level_.reserve(16);
        next_.reserve(16);
        level_.push_back(domain);
        // Breadth first: when the budget runs out, what is left is as small everywhere.
        while (!level_.empty()) {
            for (const Box& box : level_) {
                if (boxes_ < limits_.max_boxes)
                    examine(box);
                else
                    left_over.push_back(box);
            }
            level_.swap(next_);
            next_.clear();
        }
    }

    std::vector<Found<T, N>> roots;
    std::vector<Box> unresolved;  ///< too narrow, or rounding hides what is in them
    std::vector<Box> left_over;   ///< when the budget ran out
    std::size_t boxes() const { return boxes_; }

private:
    void examine(Box box) {
        while (true) {
            ++boxes_;
            Step<T, N> s = steps_.step(box);
            if (s.empty) return;
            if (s.injective && (s.exists || narrows(box, s.image)) && settle(box, s)) return;
            std::optional<Box> kept = intersection(box, s.image);
            if (!kept) return;
            if (shrinks(box, *kept)) {
                box = *kept;
                continue;
            }
            if (!is_large(*kept)) {
                if (s.injective && settle(box, s)) return;
                box = *kept;
                ++boxes_;
                s = steps_.careful_step(box);
                if (s.empty || (s.injective && settle(box, s))) return;
                kept = intersection(box, s.image);
                if (!kept) return;
                if (shrinks(box, *kept)) {
                    box = *kept;
                    continue;
                }
            }
            if (s.stalled || !split(*kept, s.split)) unresolved.push_back(*kept);
            return;
        }
    }

    /// With one root at most in the box: is it proved that there is one, or none?
    bool settle(const Box& box, const Step<T, N>& s) {
        if (s.exists) return record({steps_.tightened(s.image), box});
        // A root on a face of the box is proved in a region that reaches across. The region covers all
        // of the box that may hold roots, so its root is the box's only candidate.
        Box region;
        for (int i = 0; i < N; ++i) {
            const T m = s.image[i].mid();
            region[i] = m + T(1.25) * (s.image[i] - m);
        }
        const Step<T, N> r = steps_.step(region);
        if (r.empty) return true;
        if (!r.unique()) return false;
        const Found<T, N> found{steps_.tightened(r.image), region};
        return !overlap(found.box, box) || record(found);
    }

    // Neighbouring boxes find the root on their common face each. Two enclosures are of one root if one
    // lies in the other's region; if that stays open, the boxes are split further.
    bool record(const Found<T, N>& found) {
        for (const Found<T, N>& known : roots) {
            if (is_subset(found.box, known.region) || is_subset(known.box, found.region)) return true;
            if (overlap(found.box, known.box)) return false;
        }
        roots.push_back(found);
        return true;
    }

    bool shrinks(const Box& before, const Box& after) const {
        for (int i = 0; i < N; ++i)
            if (approximate_width(after[i]) < 0.7 * approximate_width(before[i])) return true;
        return false;
    }
    bool narrows(const Box& before, const Box& after) const {
        for (int i = 0; i < N; ++i)
            if (!(approximate_width(after[i]) < 0.75 * approximate_width(before[i]))) return false;
        return true;
    }
    bool is_large(const Box& box) const {
        // A matter of speed: larger boxes are halved rather than looked at a second time.
        constexpr double large_part = 0x1p-8;
        for (int i = 0; i < N; ++i)
            if (approximate_width(box[i]) > large_part * domain_width_[i]) return true;
        return false;
    }

    bool split(const Box& box, int unknown) {
        double widest = 0;
        int widest_side = 0;
        for (int i = 0; i < N; ++i)
            if (approximate_width(box[i]) > widest) widest = approximate_width(box[i]), widest_side = i;
        if (!(widest > limits_.min_width)) return false;
        return split_side(box, unknown) || split_side(box, widest_side);
    }
    // Off the middle: symmetric systems like their roots there.
    bool split_side(const Box& box, int i) {
        const T m = box[i].mid();
        const T at = T(m + T(0.015625) * (T(box[i].upper(), box[i].upper()) - m)).mid();
        if (!(box[i].lower() < at.lower() && at.upper() < box[i].upper())) return false;
        Box low = box, high = box;
        low[i] = T(box[i].lower(), at.lower());
        high[i] = T(at.lower(), box[i].upper());
        next_.push_back(low);
        next_.push_back(high);
        return true;
    }

    const Steps& steps_;
    Limits limits_;
    std::array<double, N> domain_width_;
    std::vector<Box> level_, next_;
    std::size_t boxes_ = 0;
};

}  // namespace vcell::detail
