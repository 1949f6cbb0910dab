#include "wall_ties.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "../objects/exact_space.hpp"
#include "axial_ties.hpp"

namespace vcell {

namespace {

using Coefficients = std::array<Exact, 4>;

Coefficients coefficients(const RadialForm& f) { return {f.c[0], f.c[1], f.b[0], f.b[2]}; }

using Numbers = std::array<double, 4>;

Numbers enclosed(const Coefficients& f) {
    Numbers result;
    std::ranges::transform(f, result.begin(), [](const Exact& x) { return x.enclosure().mid(); });
    return result;
}

// How far the points of a wall's plane go within `reach` as its numbers change by these.
double moved(const Numbers& change, const Numbers& wall, double reach) {
    return (std::abs(change[0]) + reach * (std::abs(change[1]) + 2 * std::hypot(change[2], change[3]))) /
           std::hypot(wall[1], 2 * wall[2], 2 * wall[3]);
}

double sine_between(const Numbers& f, const Numbers& g) {
    const Vec3 a(f[1], 2 * f[2], 2 * f[3]), b(g[1], 2 * g[2], 2 * g[3]);
    return a.cross(b).norm() / (a.norm() * b.norm());
}

// With unit normals m = a n_1 + b n_2, a the sine between m and n_2 over that between n_1 and n_2: behind m,
// which gives way by `move`, and before both others nothing is farther from the first of these than move / a.
// None if their lines are farther apart than places are to be known, as where two of them are twins.
std::optional<double> off_both(double move, const Numbers& middle, const Numbers& first,
                               const Numbers& second, double reach) {
    if (move == 0) return 0;
    const double sine = sine_between(first, second),
                 least = std::min(sine_between(middle, first), sine_between(middle, second)),
                 off = move * std::max(1.0, sine / least);
    return off <= narrow_place * reach * sine ? std::optional(off) : std::nullopt;
}

// None where three walls have no line in common, or all are needed beside it.
std::optional<WallTie> tie_of(const std::vector<Coefficients>& walls, std::uint32_t first,
                              std::uint32_t second, std::uint32_t third, double reach, double most) {
    const Coefficients &s = walls[first], &t = walls[second], &w = walls[third];
    std::array<std::size_t, 2> at{0, 1};
    double largest = -1;
    const Numbers x = enclosed(s), y = enclosed(t);
    for (std::size_t i = 0; i < w.size(); ++i)
        for (std::size_t k = i + 1; k < w.size(); ++k)
            if (const double minor = std::abs(x[i] * y[k] - x[k] * y[i]); minor > largest) {
                largest = minor;
                at = {i, k};
            }
    const auto [i, k] = at;
    const Exact divisor = s[i] * t[k] - s[k] * t[i];
    if (divisor.sign() == Sign::Zero) return std::nullopt;
    // divisor w = a s + b t + rest
    const Exact a = w[i] * t[k] - w[k] * t[i], b = s[i] * w[k] - s[k] * w[i];
    Numbers rest;
    for (std::size_t j = 0; j < w.size(); ++j)
        rest[j] = nearest(divisor * w[j] - (a * s[j] + b * t[j])) / nearest(divisor);
    const Numbers z = enclosed(w);
    const double move = moved(rest, z, reach);
    if (!(move <= most) || a.sign() == Sign::Zero || b.sign() == Sign::Zero) return std::nullopt;
    const bool has_first = a.sign() == divisor.sign(), has_second = b.sign() == divisor.sign();
    const auto tie = [&](std::uint32_t middle, const Numbers& m, std::uint32_t one, const Numbers& f,
                         std::uint32_t other, const Numbers& g, double by) -> std::optional<WallTie> {
        const auto off = by <= most ? off_both(by, m, f, g, reach) : std::nullopt;
        return off ? std::optional(WallTie{middle, one, other, *off}) : std::nullopt;
    };
    if (has_first && has_second) return tie(third, z, first, x, second, y, move);
    // What one of them is less the other one: by as much as that has of the third.
    const auto part_of = [&](const Exact& share, const Numbers& middle) {
        Numbers part = rest;
        for (double& r : part) r *= std::abs(nearest(divisor) / nearest(share));
        return moved(part, middle, reach);
    };
    if (has_first) return tie(first, x, second, y, third, z, part_of(a, x));
    if (has_second) return tie(second, y, first, x, third, z, part_of(b, y));
    return std::nullopt;  // nothing is inwards from all three
}

// A number that tells the line that two walls have in common from most others: a linear function of the unit
// vector of the minors of their coefficients, but for its sign. NaN of equal ones.
double key_of(const Numbers& f, const Numbers& g) {
    constexpr std::array<double, 6> unlike{0.61, -0.37, 0.53, 0.29, -0.83, 0.71};
    double key = 0, square = 0;
    for (std::size_t i = 0, n = 0; i < 4; ++i)
        for (std::size_t k = i + 1; k < 4; ++k, ++n) {
            const double minor = f[i] * g[k] - f[k] * g[i];
            key += unlike[n] * minor;
            square += minor * minor;
        }
    return std::abs(key) / std::sqrt(square);
}

Numbers scaled(Numbers f) {
    const double size = std::abs(std::ranges::max(f, {}, [](double x) { return std::abs(x); }));
    for (double& x : f) x /= size;
    return f;
}

}  // namespace

std::vector<WallTie> find_wall_ties(std::span<const RadialForm> walls, double reach, double most) {
    constexpr double same = 0x1p-30;  // far more than rounding
    std::vector<Coefficients> exact;
    std::vector<Numbers> numbers;
    for (const RadialForm& wall : walls) {
        exact.push_back(coefficients(wall));
        numbers.push_back(scaled(enclosed(exact.back())));
    }
    struct Other {
        double key;
        std::uint32_t wall;
    };
    std::vector<WallTie> ties;
    std::vector<Other> others;
    for (std::uint32_t i = 0; i < walls.size(); ++i) {
        others.clear();
        for (std::uint32_t j = i + 1; j < walls.size(); ++j)
            if (const double key = key_of(numbers[i], numbers[j]); std::isfinite(key))
                others.push_back({key, j});
        std::ranges::sort(others, {}, &Other::key);
        for (std::size_t p = 0; p < others.size(); ++p)
            for (std::size_t q = p + 1; q < others.size() && others[q].key - others[p].key < same; ++q)
                if (const auto tie = tie_of(exact, i, others[p].wall, others[q].wall, reach, most))
                    ties.push_back(*tie);
    }
    return ties;
}

}  // namespace vcell
