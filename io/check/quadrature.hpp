/// Integrals, enclosed: Gauss's rules in arithmetic by midpoint and radius, with a proved bound of what they
/// leave out.
///
/// Let f be analytic and |f| <= M within the ellipse with foci -1 and 1 whose semi-axes add up to rho. Some
/// polynomial of degree 2n - 1 is within 2 M rho^(1 - 2n) / (rho - 1) of it on [-1, 1] [Trefethen13,
/// Thm. 8.2]; Gauss's rule with n nodes is exact for that polynomial, its weights are positive and add up to
/// 2, so it misses the integral of f by at most four times as much. M is a bound over discs of complex
/// numbers (disc.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "disc.hpp"
#include "traced.hpp"

namespace vcell::check {

/// A plain number: for estimates, and where Traced tells of its rounding.
class Approximate {
public:
    constexpr Approximate() = default;
    constexpr Approximate(double value) : value_(value) {}             // NOLINT: a number
    Approximate(const MidRad& enclosure) : value_(enclosure.mid()) {}  // NOLINT: what it encloses, about

    double value() const { return value_; }

    friend Approximate operator-(Approximate a) { return -a.value_; }
    friend Approximate operator+(Approximate a, Approximate b) { return a.value_ + b.value_; }
    friend Approximate operator-(Approximate a, Approximate b) { return a.value_ - b.value_; }
    friend Approximate operator*(Approximate a, Approximate b) { return a.value_ * b.value_; }
    friend Approximate operator/(Approximate a, Approximate b) { return a.value_ / b.value_; }
    friend Approximate square(Approximate a) { return a.value_ * a.value_; }
    friend Approximate sqrt(Approximate a) { return std::sqrt(a.value_); }

private:
    double value_ = 0;
};

/// Gauss's nodes on [-1, 1] with their weights, each within a unit or two of its last place.
struct GaussRule {
    struct Node {
        MidRad at, weight;
    };
    std::array<Node, 30> nodes;
    std::size_t count = 0;
};

/// An ellipse and the rule that goes with it: where f is bounded far away few nodes do.
struct Attempt {
    double rho;
    unsigned nodes;
};
inline constexpr std::array<Attempt, 5> attempts{{{24, 7}, {8, 10}, {4, 15}, {2.75, 20}, {2, 30}}};
/// Bounds cost more than nodes in one variable, where the first attempts seldom do; the last one's nodes are
/// too many in two.
inline constexpr std::size_t first_in_one = 2, last_in_two = 3;

namespace detail {

template <unsigned N>
GaussRule gauss_rule() {
    using Gauss = boost::math::quadrature::gauss<double, N>;
    const auto about = [](double x) { return MidRad::ball(x, 0x1p-52 * std::abs(x)); };
    GaussRule rule;
    for (std::size_t i = 0; i < Gauss::abscissa().size(); ++i) {
        const MidRad x = about(Gauss::abscissa()[i]), w = about(Gauss::weights()[i]);
        rule.nodes[rule.count++] = {x, w};
        if (Gauss::abscissa()[i] != 0) rule.nodes[rule.count++] = {-x, w};
    }
    return rule;
}

}  // namespace detail

inline const GaussRule& gauss(std::size_t attempt) {
    static const std::array<GaussRule, attempts.size()> rules{
        detail::gauss_rule<attempts[0].nodes>(), detail::gauss_rule<attempts[1].nodes>(),
        detail::gauss_rule<attempts[2].nodes>(), detail::gauss_rule<attempts[3].nodes>(),
        detail::gauss_rule<attempts[4].nodes>()};
    return rules[attempt];
}

/// What Gauss's rule leaves out at most, for each unit of M: 8 rho^(1 - 2n) / (rho - 1).
inline double remainder_factor(std::size_t attempt) {
    static const std::array<double, attempts.size()> factors = [] {
        std::array<double, attempts.size()> result{};
        for (std::size_t k = 0; k < attempts.size(); ++k) {
            const auto [rho, n] = attempts[k];
            Interval power = 8.0;
            for (unsigned i = 0; i + 1 < 2 * n; ++i) power = power / Interval(rho);
            result[k] = (power / (Interval(rho) - 1.0)).upper();
        }
        return result;
    }();
    return factors[attempt];
}

/// A disc around the ellipse of an attempt about middle -+ half: its major axis is hardly longer than the other.
inline Disc around(std::size_t attempt, double middle, double half) {
    const double rho = attempts[attempt].rho;
    return {middle, half * (0.5 * (rho + 1 / rho)) * (1 + 0x1p-48) + std::abs(middle) * 0x1p-52};
}

/// How far integrals are pursued.
struct Effort {
    int parts;  ///< into which an interval or a rectangle is cut at most
    int parts_used = 0;
};

/// A finite bound of an expression in quotients and roots proves that it is analytic where it holds.
template <class Value, std::size_t N>
bool is_below(const Value& value, const std::array<double, N>& most) {
    for (std::size_t i = 0; i < N; ++i)
        if (!(value[i].magnitude() <= most[i])) return false;
    return true;
}

/// Is |f(z, x)| at most `most` for all x of a real interval? It is halved until that tells, into `left` parts at
/// most.
template <std::size_t N, class F>
bool is_bounded(const F& f, const Disc& z, const Interval& x, const std::array<double, N>& most, int& left) {
    if (--left < 0) return false;
    if (is_below(f(z, Disc(MidRad(x))), most)) return true;
    const double m = x.mid();
    return is_bounded(f, z, Interval(x.lower(), m), most, left) && is_bounded(f, z, Interval(m, x.upper()), most, left);
}

namespace detail {

/// Relative to the values of an integrand: what a rule leaves out need not be smaller than their own rounding.
constexpr double value_rounding = 0x1p-48;
/// Into how many parts the one of two intervals is cut for a bound about the other.
constexpr int parts_of_product = 15;

template <std::size_t N>
std::array<double, N> allowed(const std::array<double, N>& missing, double factor) {
    std::array<double, N> most;
    for (std::size_t i = 0; i < N; ++i) most[i] = missing[i] / factor;
    return most;
}

}  // namespace detail

namespace detail {

/// Adds what a rule says of the integrals about middle -+ half_width, -+ what it may be missing for each unit
/// of width. In plain doubles, if a look at all of the interval shows that their rounding is not too much
/// more than that.
template <std::size_t N, class F>
void add_rule(const F& f, double middle, const MidRad& half_width, std::size_t attempt,
              const std::array<double, N>& missing, std::array<Interval, N>& sum) {
    constexpr double poor = 1024;
    const GaussRule& rule = gauss(attempt);
    const double half = half_width.mid(), size = std::abs(middle) + half;
    // Over a wide range too little is known: parts of it may tell.
    constexpr int most_parts = 4;
    bool is_enough = false;
    std::array<double, N> rounding{};
    for (int parts = 1; parts <= most_parts && !is_enough; parts *= 2) {
        is_enough = true;
        rounding.fill(0);
        for (int k = 0; k < parts && is_enough; ++k) {
            const double center = middle + half * ((2 * k + 1 - parts) / static_cast<double>(parts));
            // Nodes are known to 2^-52, and computed with two roundings.
            const Traced range(MidRad::ball(center, half / parts + 0x1p-50 * size), 0x1p-50 * size);
            const auto traced = f(range);
            for (std::size_t i = 0; i < N; ++i) {
                rounding[i] = std::max(rounding[i], traced[i].error());
                is_enough = is_enough && traced[i].error() <= poor * missing[i];
            }
        }
    }
    std::array<MidRad, N> part{};
    if (is_enough) {
        std::array<double, N> total{}, sizes{};
        for (std::size_t n = 0; n < rule.count; ++n) {
            const auto value = f(Approximate(middle + half * rule.nodes[n].at.mid()));
            const double weight = rule.nodes[n].weight.mid();
            for (std::size_t i = 0; i < N; ++i) {
                const double term = weight * value[i].value();
                total[i] += term;
                sizes[i] += std::abs(term);
            }
        }
        // Weights add up to 2. Their own rounding and that of the sum are relative to its terms.
        for (std::size_t i = 0; i < N; ++i)
            part[i] = MidRad::ball(total[i], (2 * rounding[i] + 0x1p-46 * sizes[i]) * (1 + 0x1p-40));
    } else {
        for (std::size_t n = 0; n < rule.count; ++n) {
            const auto value = f(MidRad(middle) + half_width * rule.nodes[n].at);
            for (std::size_t i = 0; i < N; ++i) part[i] += rule.nodes[n].weight * value[i];
        }
    }
    for (std::size_t i = 0; i < N; ++i)
        sum[i] += (half_width * (part[i] + MidRad::ball(0, missing[i]))).enclosure();
}

}  // namespace detail

/// The integrals over [a, b] of the components of f, which takes any of these numbers and returns an
/// array of as many. Of each, the mean over [a, b] may be missed by `enough`, or by what rounds its values.
/// False: the effort is spent, and the enclosures are as wide as interval arithmetic makes them there,
/// perhaps infinite.
template <std::size_t N, class F>
bool integrate(const F& f, double a, double b, const std::array<double, N>& enough, std::array<Interval, N>& sum,
               Effort& effort) {
    const double middle = 0.5 * (a + b), half = Interval::up(0.5 * (b - a));
    const MidRad half_width = 0.5 * (MidRad(b) - a);
    ++effort.parts_used;
    std::array<double, N> missing = enough;
    const auto value = f(Approximate(middle));
    for (std::size_t i = 0; i < N; ++i)
        missing[i] = std::max(missing[i], detail::value_rounding * std::abs(value[i].value()));
    for (std::size_t k = first_in_one; k < attempts.size(); ++k) {
        if (!is_below(f(around(k, middle, half)), detail::allowed(missing, remainder_factor(k)))) continue;
        detail::add_rule(f, middle, half_width, k, missing, sum);
        return true;
    }
    if (effort.parts_used < effort.parts && a < middle && middle < b) {
        const bool left = integrate(f, a, middle, enough, sum, effort);
        const bool right = integrate(f, middle, b, enough, sum, effort);
        return left && right;
    }
    const auto all = f(MidRad(Interval(a, b)));
    for (std::size_t i = 0; i < N; ++i) sum[i] += (2.0 * (half_width * all[i])).enclosure();
    return false;
}

/// The same over rectangles: f(s, t) for s in [a0, b0], t in [a1, b1]. What the product of two rules leaves out
/// is what one leaves out along s for the worst t, and the other along t for the worst s.
template <std::size_t N, class F>
bool integrate(const F& f, std::array<double, 2> a, std::array<double, 2> b, const std::array<double, N>& enough,
               std::array<Interval, N>& sum, Effort& effort) {
    const std::array middle{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
    const std::array half{Interval::up(0.5 * (b[0] - a[0])), Interval::up(0.5 * (b[1] - a[1]))};
    const std::array width{MidRad(b[0]) - a[0], MidRad(b[1]) - a[1]};
    ++effort.parts_used;
    std::array<double, N> missing = enough;
    const auto value = f(MidRad(middle[0]), MidRad(middle[1]));
    for (std::size_t i = 0; i < N; ++i)
        missing[i] = std::max(missing[i], detail::value_rounding * value[i].magnitude());
    std::array<std::size_t, 2> chosen{attempts.size(), attempts.size()};
    for (const std::size_t axis : {0, 1})
        for (std::size_t k = 0; k <= last_in_two && chosen[axis] == attempts.size(); ++k) {
            int left = detail::parts_of_product;
            const auto along = [&](const Disc& z, const Disc& x) {
                return axis == 0 ? f(z, x) : f(x, z);
            };
            if (is_bounded(along, around(k, middle[axis], half[axis]), Interval(a[1 - axis], b[1 - axis]),
                           detail::allowed(missing, 4 * remainder_factor(k)), left))
                chosen[axis] = k;
        }
    if (chosen[0] < attempts.size() && chosen[1] < attempts.size()) {
        std::array<MidRad, N> part{};
        for (std::size_t m = 0; m < gauss(chosen[0]).count; ++m) {
            const auto& outer = gauss(chosen[0]).nodes[m];
            const MidRad s = MidRad(middle[0]) + 0.5 * (width[0] * outer.at);
            for (std::size_t n = 0; n < gauss(chosen[1]).count; ++n) {
                const auto& inner = gauss(chosen[1]).nodes[n];
                const auto at_node = f(s, MidRad(middle[1]) + 0.5 * (width[1] * inner.at));
                const MidRad weight = outer.weight * inner.weight;
                for (std::size_t i = 0; i < N; ++i) part[i] += weight * at_node[i];
            }
        }
        const MidRad share = 0.25 * (width[0] * width[1]);
        for (std::size_t i = 0; i < N; ++i)
            sum[i] += (share * (part[i] + MidRad::ball(0, missing[i]))).enclosure();
        return true;
    }
    // Halves along the direction in which no rule was enough, or the wider one of two.
    const bool only_first = chosen[1] < attempts.size(), only_second = chosen[0] < attempts.size();
    const std::size_t axis = only_first ? 0 : only_second ? 1 : half[1] > half[0] ? 1 : 0;
    if (effort.parts_used < effort.parts && a[axis] < middle[axis] && middle[axis] < b[axis]) {
        auto low = b, high = a;
        low[axis] = high[axis] = middle[axis];
        const bool first = integrate(f, a, low, enough, sum, effort);
        const bool second = integrate(f, high, b, enough, sum, effort);
        return first && second;
    }
    const auto all = f(MidRad(Interval(a[0], b[0])), MidRad(Interval(a[1], b[1])));
    for (std::size_t i = 0; i < N; ++i) sum[i] += (width[0] * width[1] * all[i]).enclosure();
    return false;
}

/// The same integral where a proof would take too long: enclosures are of the product of rules with ten nodes -+ its
/// difference from rules with seven, which are far less exact. An estimate, if a generous one. False: the effort is
/// spent, and it is a poor one.
template <std::size_t N, class F>
bool estimate(const F& f, std::array<double, 2> a, std::array<double, 2> b, const std::array<double, N>& enough,
              std::array<Interval, N>& sum, Effort& effort) {
    constexpr double rounding = 0x1p-46;
    ++effort.parts_used;
    const std::array middle{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])}, half{0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1])};
    const auto product = [&](std::size_t outer, std::size_t inner, std::array<double, N>& size) {
        std::array<double, N> total{};
        size = {};
        for (std::size_t m = 0; m < gauss(outer).count; ++m)
            for (std::size_t n = 0; n < gauss(inner).count; ++n) {
                const auto &s = gauss(outer).nodes[m], &t = gauss(inner).nodes[n];
                const auto value = f(Approximate(middle[0] + half[0] * s.at.mid()),
                                     Approximate(middle[1] + half[1] * t.at.mid()));
                const double weight = s.weight.mid() * t.weight.mid() * half[0] * half[1];
                for (std::size_t i = 0; i < N; ++i) {
                    total[i] += weight * value[i].value();
                    size[i] += weight * std::abs(value[i].value());
                }
            }
        return total;
    };
    std::array<double, N> size, unused;
    const auto fine = product(1, 1, size), first = product(0, 1, unused), second = product(1, 0, unused);
    bool is_enough = true;
    std::array<double, 2> worst{};
    std::array<double, N> error;
    for (std::size_t i = 0; i < N; ++i) {
        const double along = std::abs(fine[i] - first[i]), across = std::abs(fine[i] - second[i]);
        error[i] = along + across + 0x1p-50 * size[i];
        const double allowed = std::max(enough[i] * half[0] * half[1], rounding * size[i]);
        is_enough = is_enough && along + across <= allowed;
        worst[0] = std::max(worst[0], along / allowed);
        worst[1] = std::max(worst[1], across / allowed);
    }
    const std::size_t axis = worst[1] > worst[0] ? 1 : 0;
    if (!is_enough && effort.parts_used < effort.parts && a[axis] < middle[axis] && middle[axis] < b[axis]) {
        auto low = b, high = a;
        low[axis] = high[axis] = middle[axis];
        const bool lower = estimate(f, a, low, enough, sum, effort);
        const bool upper = estimate(f, high, b, enough, sum, effort);
        return lower && upper;
    }
    for (std::size_t i = 0; i < N; ++i) sum[i] += Interval::ball(fine[i], error[i]);
    return is_enough;
}

}  // namespace vcell::check
