/// Roots by Newton's method, each proved by the step of krawczyk.hpp; of a model as that takes it, T =
/// Interval or Wide.
#pragma once

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <limits>
#include <optional>

#include "../../errors.hpp"
#include "box.hpp"
#include "krawczyk.hpp"

namespace vcell {

template <class T>
double approximate_width(const T& side) {
    return approximate(T(side.upper(), side.upper()) - T(side.lower(), side.lower()));
}

/// A point near a root, and the system there.
template <class T, int N>
struct Approach {
    std::array<T, N> point;
    LocalModel<T, N> local;
};

/// -J^-1 f of a model at a point, approximately; nothing where J is singular.
template <class T, int N>
std::optional<std::array<T, N>> newton_move(const LocalModel<T, N>& local) {
    std::array<std::array<double, N>, N> jacobian;
    std::array<double, N> ones, size{};  // of rows: pivots are chosen whatever the equations' scale
    ones.fill(1);
    for (int k = 0; k < N; ++k)
        for (int i = 0; i < N; ++i) {
            jacobian[k][i] = approximate(local.jacobian[k][i]);
            size[k] += std::abs(jacobian[k][i]);
        }
    const detail::Preconditioner<N> b = detail::precondition<N>(jacobian, ones, size, 0);
    std::array<T, N> move{};
    for (int i = 0; i < N; ++i) {
        if (!b.solved[i]) return std::nullopt;
        for (int k = 0; k < N; ++k) move[i] -= T(b.row[i][k]) * local.value[k];
    }
    return move;
}

/// Newton's method from x: the point from which the next move is at most `small` in every unknown, rounding
/// included. Nothing where J is singular on the way, points leave `cube` or `most_steps` do not suffice.
/// Proves nothing; of J approximations will do.
template <class T, int N, class Model>
std::optional<Approach<T, N>> approach(const Model& model, std::array<T, N> x, const IntervalBox<N>& cube,
                                       double small, int most_steps) {
    for (int step = 0;; ++step) {
        const LocalModel<T, N> local = model.at(x, Offsets<T, N>(x));
        const auto move = newton_move(local);
        if (!move) return std::nullopt;
        const auto is_small = [&](const T& m) { return Offsets<T, N>::magnitude(m) <= small; };
        if (std::all_of(move->begin(), move->end(), is_small)) return Approach<T, N>{x, local};
        if (step == most_steps) return std::nullopt;
        for (int i = 0; i < N; ++i) x[i] = T((x[i] + (*move)[i]).mid());
        if (!overlap(converted<Interval>(x), cube)) return std::nullopt;
    }
}

/// A box with exactly one root, which doubles can name: Newton's method from x, then proofs in growing boxes
/// about its result. Nothing when Newton's method leaves `cube` or no such box is as narrow as that.
template <class T, int N, class Model>
std::optional<IntervalBox<N>> prove_near(const Model& model, std::array<T, N> x, const IntervalBox<N>& cube) {
    std::array<double, N> last;
    last.fill(std::numeric_limits<double>::infinity());
    double least = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < 30; ++iteration) {
        const std::optional<std::array<T, N>> move = newton_move(model.at(x, Offsets<T, N>(x)));
        if (!move) return std::nullopt;
        double size = 0;
        for (int i = 0; i < N; ++i) {
            // Where values cancel, moves may be far smaller than the values' rounding allows for.
            last[i] = Offsets<T, N>::magnitude((*move)[i]);
            size = std::max(size, std::abs(approximate((*move)[i])));
            x[i] = T((x[i] + (*move)[i]).mid());
        }
        const IntervalBox<N> at = converted<Interval>(x);
        if (!overlap(at, cube)) return std::nullopt;
        // Quadratic convergence, until rounding stops it.
        if (size == 0 || (iteration > 3 && !(size < 0.5 * least))) break;
        least = std::min(least, size);
    }
    // A coordinate of 0, about which nothing is rounded, takes a little of what the others are wide.
    const IntervalBox<N> middle = converted<Interval>(x);
    double others = 0;
    for (int i = 0; i < N; ++i) others = std::max(others, middle[i].magnitude() + last[i]);
    for (double factor = 4; factor < 0x1p60; factor *= 16) {
        IntervalBox<N> box = middle;
        double widest = 0;
        for (int i = 0; i < N; ++i) {
            const double radius =
                factor * (last[i] + 0x1p-53 * box[i].magnitude() + 0x1p-96 * others) + 0x1p-1000;
            widest = std::max(widest, radius);
            box[i] = box[i] + Interval(-radius, radius);
        }
        if (!(widest <= cube[0].width())) break;
        const Step<T, N> s = krawczyk_step<T, N>(model, converted<T>(box), Preconditioning::Inverse);
        if (s.empty) break;
        if (!s.unique()) continue;
        const IntervalBox<N> tight = converted<Interval>(s.image);
        // The image may stick out of the box by the rounding to double.
        const auto proved = intersection(tight, box);
        return proved && overlap(*proved, cube) ? proved : std::nullopt;
    }
    return std::nullopt;
}

/// What repeated steps leave of a box.
template <class T, int N>
struct Contraction {
    std::array<T, N> box{};  ///< contains all roots of the box
    bool empty = false;      ///< there are none
    bool unique = false;     ///< there is exactly one
};

/// Steps until they shrink a box no more by two fifths.
template <class T, int N, class Model>
Contraction<T, N> contract(const Model& model, const std::array<T, N>& box) {
    constexpr int most_steps = 20;
    const auto widest = [](const std::array<T, N>& b) {
        double w = 0;
        for (const T& side : b) w = std::max(w, approximate_width(side));
        return w;
    };
    Contraction<T, N> result{box};
    for (int i = 0; i < most_steps; ++i) {
        const Step<T, N> s = krawczyk_step<T, N>(model, result.box, Preconditioning::Inverse);
        const auto kept = s.empty ? std::nullopt : intersection(result.box, s.image);
        if (!kept) {
            result.empty = true;
            return result;
        }
        result.unique = result.unique || s.unique();
        const bool stalled = widest(*kept) > 0.6 * widest(result.box);
        result.box = *kept;
        if (stalled) break;
    }
    return result;
}

}  // namespace vcell
