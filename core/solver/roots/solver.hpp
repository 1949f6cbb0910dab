/// All real roots of N equations in N unknowns, each with a proof.
///
///     struct Circles {                                     // any callable generic in the number type
///         template <class T>
///         std::array<T, 2> operator()(const std::array<T, 2>& p) const {
///             const auto& [x, y] = p;
///             return {square(x) + square(y) - T(4.0), square(x - T(1.0)) + square(y) - T(4.0)};
///         }
///     };
///     const auto s = vcell::solve(Circles{}, vcell::IntervalBox<2>{{{-3, 3}, {-3, 3}}});
///     for (const auto& root : s.unique) ...                // exactly one root in root.box
///     for (const auto& cluster : s.undecided) ...          // unknown: both lists need attention
///
/// Equations come as such a callable, as polynomials (PolynomialSystem) or as quadratic forms
/// (QuadraticSystem), which are solved fastest.
///
/// The method is bisection with the Krawczyk operator (krawczyk.hpp), for quadratic systems centred and
/// exact in the quadratic parts. Doubles with error bounds come first; boxes in which rounding hides the
/// answer are taken up again in multiprecision. No root of the closed box is ever dropped: it is in one
/// box of `unique` or in a box of `undecided`.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "../../partition.hpp"
#include "../../platform.hpp"
#include "../newton/box.hpp"
#include "../newton/krawczyk.hpp"
#include "../newton/quadratic_kernel.hpp"
#include "../systems/polynomial.hpp"
#include "../systems/quadratic_system.hpp"
#include "search.hpp"

namespace vcell {

struct SolverOptions {
    /// Steps in double before the rest is returned as undecided.
    std::size_t max_boxes = 20'000;
    /// Boxes with all sides below this (in the unit of the unknowns) are not split in double.
    double min_width = 0;
    /// Steps in multiprecision per cluster of boxes that doubles leave open; 0: none.
    std::size_t max_wide_boxes = 2'000;
    /// Multiprecision splits boxes down to 2^-wide_resolution of the searched box: closer roots stay
    /// undecided.
    int wide_resolution = 80;
};

template <int N>
struct Root {
    /// Exactly one root of the system lies in it. Boxes of different roots are disjoint, unless both have
    /// a `precise` box: then those are.
    IntervalBox<N> box;
    /// Contains `box`; no other root lies in it.
    IntervalBox<N> region;
    /// Where doubles could not separate or place the root: what is said of `box` holds for this box.
    std::optional<WideBox<N>> precise;
    /// The root lies on the boundary of the searched box, as far as multiprecision can tell; it may be
    /// outside by less than the width of its box.
    bool on_boundary = false;
};

template <int N>
struct Undecided {
    enum class Reason {
        Resolution,  ///< smaller boxes would show nothing: multiple or nearly multiple roots
        Budget,      ///< max_boxes reached: perhaps a curve of roots
    };
    IntervalBox<N> hull;                ///< of the boxes
    std::vector<IntervalBox<N>> boxes;  ///< each touches another one
    Reason reason = Reason::Resolution;
};

template <int N>
struct Solutions {
    std::vector<Root<N>> unique;
    std::vector<Undecided<N>> undecided;
    std::size_t boxes = 0;       ///< steps taken in double
    std::size_t wide_boxes = 0;  ///< and in multiprecision
};

namespace detail {

/// Groups of boxes that touch. Indices into `boxes`.
template <int N>
std::vector<std::vector<std::size_t>> clusters(const std::vector<IntervalBox<N>>& boxes) {
    // Sweep along the longest side of the common hull.
    IntervalBox<N> all = boxes.front();
    for (const auto& box : boxes) all = hull(all, box);
    int axis = 0;
    for (int i = 1; i < N; ++i)
        if (all[i].width() > all[axis].width()) axis = i;
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](auto a, auto b) { return boxes[a][axis].lower() < boxes[b][axis].lower(); });
    Partition touching(boxes.size());
    std::vector<std::uint32_t> open;
    for (const std::uint32_t i : order) {
        std::erase_if(open, [&](std::uint32_t j) { return boxes[j][axis].upper() < boxes[i][axis].lower(); });
        for (const std::uint32_t j : open)
            if (overlap(boxes[i], boxes[j])) touching.merge(j, i);
        open.push_back(i);
    }
    std::vector<std::vector<std::size_t>> groups;
    std::vector<std::size_t> group_of(boxes.size(), boxes.size());
    for (const std::uint32_t i : order) {
        std::size_t& g = group_of[touching.find(i)];
        if (g == boxes.size()) {
            g = groups.size();
            groups.emplace_back();
        }
        groups[g].push_back(i);
    }
    return groups;
}

template <int N, class Steps, class MakeWide>
Solutions<N> solve(const Steps& steps, const MakeWide& make_wide, const IntervalBox<N>& domain,
                   const SolverOptions& options) {
    Solutions<N> result;
    Search<Interval, N, Steps> search(steps, domain, {options.max_boxes, options.min_width});
    result.boxes = search.boxes();
    for (const auto& found : search.roots)
        result.unique.push_back({found.box, found.region, std::nullopt, false});

    using WideSteps = decltype(make_wide());
    std::optional<WideSteps> wide;  // costs more than most systems take to solve
    const auto in_wide = [&]() -> const WideSteps& {
        if (!wide) wide.emplace(make_wide());
        return *wide;
    };

    // Roots on the boundary, or too close to it for doubles.
    const auto place = [&](Root<N>& root) {
        const WideBox<N> wide_domain = converted<Wide>(domain);
        if (!root.precise) root.precise = in_wide().tightened(converted<Wide>(root.box));
        root.on_boundary = !is_subset(*root.precise, wide_domain);
        return overlap(*root.precise, wide_domain);
    };
    std::erase_if(result.unique, [&](Root<N>& root) { return !is_subset(root.box, domain) && !place(root); });

    const std::size_t certain = result.unique.size();
    const auto resolved = [&](const IntervalBox<N>& box) {
        for (std::size_t i = 0; i < certain; ++i)
            if (is_subset(box, result.unique[i].region)) return true;
        return false;
    };
    std::vector<IntervalBox<N>> open;
    for (const auto& box : search.unresolved)
        if (!resolved(box)) open.push_back(box);
    const std::size_t stalled = open.size();
    for (const auto& box : search.left_over)
        if (!resolved(box)) open.push_back(box);
    if (open.empty()) return result;

    double scale = 0;
    for (const Interval& side : domain) scale = std::max(scale, side.width());
    for (const auto& group : clusters<N>(open)) {
        Undecided<N> cluster;
        cluster.hull = open[group.front()];
        for (const std::size_t i : group) {
            cluster.boxes.push_back(open[i]);
            cluster.hull = hull(cluster.hull, open[i]);
            if (i >= stalled) cluster.reason = Undecided<N>::Reason::Budget;
        }
        if (cluster.reason == Undecided<N>::Reason::Budget || options.max_wide_boxes == 0) {
            result.undecided.push_back(std::move(cluster));
            continue;
        }
        Search<Wide, N, WideSteps> closer(
            in_wide(), converted<Wide>(cluster.hull),
            {options.max_wide_boxes, std::ldexp(scale, -options.wide_resolution)});
        result.wide_boxes += closer.boxes();
        for (const auto& found : closer.roots) {
            Root<N> root{converted<Interval>(found.box), converted<Interval>(found.box), found.box, false};
            // The hull may hold roots that are known already.
            bool known = false;
            for (std::size_t i = 0; i < certain; ++i)
                known = known || is_subset(root.box, result.unique[i].region);
            if (!known && (is_subset(root.box, domain) || place(root)))
                result.unique.push_back(std::move(root));
        }
        std::vector<IntervalBox<N>> left;
        for (const auto& box : closer.unresolved) left.push_back(converted<Interval>(box));
        const std::size_t narrow = left.size();
        for (const auto& box : closer.left_over) left.push_back(converted<Interval>(box));
        if (left.empty()) continue;
        for (const auto& rest : clusters<N>(left)) {
            Undecided<N> smaller;
            smaller.hull = left[rest.front()];
            for (const std::size_t i : rest) {
                smaller.boxes.push_back(left[i]);
                smaller.hull = hull(smaller.hull, left[i]);
                if (i >= narrow) smaller.reason = Undecided<N>::Reason::Budget;
            }
            result.undecided.push_back(std::move(smaller));
        }
    }
    return result;
}

template <class T, int N, class System>
auto interval_steps(const System& system) {
    if constexpr (QuadraticSystem<System, N>) {
        using Model = QuadraticModel<T, N>;
        return IntervalSteps<T, N, Model>(Model(system.template forms<T>()));
    } else {
        using Model = CallableModel<T, N, System>;
        return IntervalSteps<T, N, Model>(Model(system));
    }
}

}  // namespace detail

/// All roots of the system in the closed box. Sides of the box are finite; a root on its boundary is
/// found (and marked), one outside is not reported unless it is closer to the box than multiprecision
/// can tell.
/// Throws EnvironmentError (core/platform.hpp), as certify() does.
template <class System, std::size_t N>
Solutions<static_cast<int>(N)> solve(const System& system, const std::array<Interval, N>& box,
                                     const SolverOptions& options = {}) {
    constexpr int n = static_cast<int>(N);
    if constexpr (std::same_as<System, PolynomialSystem<n>>)
        if (system.degree() <= 2) return solve(QuadraticPolynomials<n>{system}, box, options);
    const auto wide = [&] { return detail::interval_steps<Wide, n>(system); };
    return in_ieee_arithmetic("solve()", [&] {
        if constexpr (QuadraticSystem<System, n>)
            return detail::solve<n>(detail::QuadraticSteps<n>(system.template forms<Interval>(), box), wide,
                                    box, options);
        else
            return detail::solve<n>(detail::interval_steps<Interval, n>(system), wide, box, options);
    });
}

/// The root closer than 2^-bits max(1, |x_i|) in every unknown; as close as its condition allows where
/// 320 bits do not suffice. Pre: `box` holds exactly one root (Root::box, or a box from certify()).
template <class System, std::size_t N>
std::array<Wide, N> refine(const System& system, const std::array<Interval, N>& box, int bits) {
    return detail::tightened<Wide, static_cast<int>(N)>(
        detail::interval_steps<Wide, static_cast<int>(N)>(system), converted<Wide>(box), bits);
}
template <class System, int N>
WideBox<N> refine(const System& system, const Root<N>& root, int bits) {
    if (!root.precise) return refine(system, root.box, bits);
    return detail::tightened<Wide, N>(detail::interval_steps<Wide, N>(system), *root.precise, bits);
}

/// A box with exactly one root of the system, found by Newton's method from `start`, proved in double or
/// else in multiprecision; nothing when Newton's method leaves the cube start +- max_radius or the proof
/// fails. The box meets the cube.
template <class System, std::size_t N>
std::optional<std::array<Interval, N>> certify(const System& system, const std::array<double, N>& start,
                                               double max_radius) {
    require_ieee_arithmetic("certify()");
    constexpr int n = static_cast<int>(N);
    IntervalBox<n> cube;
    for (int i = 0; i < n; ++i) cube[i] = Interval::ball(start[i], max_radius);
    std::array<Interval, N> from = converted<Interval>(start);
    if (auto box = prove_near<Interval, n>(detail::interval_steps<Interval, n>(system).model(), from, cube))
        return box;
    std::array<Wide, N> wide_from = converted<Wide>(start);
    return prove_near<Wide, n>(detail::interval_steps<Wide, n>(system).model(), wide_from, cube);
}

}  // namespace vcell
