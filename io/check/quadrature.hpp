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
#include <queue>
#include <utility>

#include "disc.hpp"
#include "lanes.hpp"
#include "traced.hpp"

namespace vcell::check {

/// Plain numbers: for estimates, and where Traced tells of their rounding.
using Approximate = Lanes;

/// Gauss's nodes on [-1, 1] with their weights, each within a unit or two of its last place.
struct GaussRule {
    static constexpr std::size_t most = 32;

    struct Node {
        MidRad at, weight;
    };
    std::array<Node, most> nodes;
    std::size_t count = 0;
    /// Nodes and weights as plain numbers; lanes beyond the count weigh nothing.
    std::array<Approximate, most / Approximate::lanes> places, weights;
    std::size_t packs = 0;
};

/// How many nodes rules have, and sums of the semi-axes of ellipses: where f is bounded far away few nodes
/// do.
inline constexpr std::array<unsigned, 5> node_counts{7, 10, 15, 20, 30};
inline constexpr std::array<double, 5> ellipses{24, 8, 4, 2.75, 2};
/// In two variables each ellipse goes with one rule; the last one's nodes are too many there.
inline constexpr std::size_t last_in_two = 3;

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
    constexpr std::size_t lanes = Approximate::lanes;
    rule.packs = (rule.count + lanes - 1) / lanes;
    for (std::size_t k = 0; k < rule.packs; ++k) {
        rule.places[k] = Approximate::of([&](std::size_t i) { return rule.nodes[k * lanes + i].at.mid(); });
        rule.weights[k] =
            Approximate::of([&](std::size_t i) { return rule.nodes[k * lanes + i].weight.mid(); });
    }
    return rule;
}

}  // namespace detail

inline const GaussRule& gauss(std::size_t rule) {
    static const std::array<GaussRule, node_counts.size()> rules{
        detail::gauss_rule<node_counts[0]>(), detail::gauss_rule<node_counts[1]>(),
        detail::gauss_rule<node_counts[2]>(), detail::gauss_rule<node_counts[3]>(),
        detail::gauss_rule<node_counts[4]>()};
    return rules[rule];
}

/// What rules with n nodes leave out at most, for each unit of M on an ellipse: 8 rho^(1 - 2n) / (rho - 1).
/// Known to the compiler. 2n divisions, each off by 2^-53 of its quotient at most, are off by less than 2^-46
/// in all.
inline const std::array<double, node_counts.size()>& remainder_factors(std::size_t ellipse) {
    using Table = std::array<std::array<double, node_counts.size()>, ellipses.size()>;
    static_assert(2 * node_counts.back() <= 64);
    static constexpr Table factors = [] {
        Table result{};
        for (std::size_t k = 0; k < ellipses.size(); ++k) {
            double power = 8;
            unsigned n = 1;
            for (std::size_t r = 0; r < node_counts.size(); ++r) {
                for (; n < 2 * node_counts[r]; ++n) power /= ellipses[k];
                result[k][r] = power / (ellipses[k] - 1) * (1 + 0x1p-46);
            }
        }
        return result;
    }();
    return factors[ellipse];
}

/// A disc around an ellipse about middle -+ half: its major axis is hardly longer than the other.
inline Disc around(std::size_t ellipse, double middle, double half) {
    const double rho = ellipses[ellipse];
    return {middle, half * (0.5 * (rho + 1 / rho)) * (1 + 0x1p-48) + std::abs(middle) * 0x1p-52};
}

/// The first ellipse seldom holds no pole, and bounds cost as much as several nodes.
inline constexpr std::size_t first_ellipse = 1;

/// How far integrals are pursued.
struct Effort {
    int parts;  ///< into which an interval or a rectangle is cut at most
    int parts_used = 0;
    /// Looked at first, in one variable: the one that was enough last, for neighbours are much alike.
    std::size_t ellipse = first_ellipse;
};

/// A finite bound of an expression in quotients and roots proves that it is analytic where it holds.
template <class Value, std::size_t N>
bool is_below(const Value& value, const std::array<double, N>& most) {
    for (std::size_t i = 0; i < N; ++i)
        if (!(value[i].magnitude() <= most[i])) return false;
    return true;
}

namespace detail {

/// Is |f(x)| at most `most` for all x of a real interval? It is halved until that tells, into `left` parts at
/// most.
template <std::size_t N, class F>
bool is_bounded_in_parts(const F& f, const Interval& x, const std::array<double, N>& most, int& left) {
    if (--left < 0) return false;
    if (is_below(f(Disc(MidRad(x))), most)) return true;
    const double m = x.mid();
    return is_bounded_in_parts(f, Interval(x.lower(), m), most, left) &&
           is_bounded_in_parts(f, Interval(m, x.upper()), most, left);
}

}  // namespace detail

/// Tells so, and soon says no where a single place shows that no parts would do.
template <std::size_t N, class F>
bool is_bounded(const F& f, const Interval& x, const std::array<double, N>& most, int parts) {
    if (is_below(f(Disc(MidRad(x))), most)) return true;
    for (const double place : {x.lower(), x.upper(), x.mid()})
        if (!is_below(f(Disc(MidRad(place))), most)) return false;
    return detail::is_bounded_in_parts(f, x, most, parts);
}

namespace detail {

/// Relative to the values of an integrand: what a rule leaves out need not be smaller than their own
/// rounding.
constexpr double value_rounding = 0x1p-48;
/// Into how many parts the one of two intervals is cut for a bound about the other.
constexpr int parts_of_product = 15;
/// Rounding may be so many times larger than what a rule leaves out. In two variables discs tell less of it
/// than enclosures at the nodes do.
constexpr double poor = 1024, poor_in_two = 16;

/// The largest factor that leaves each value times it within `missing`; 0 where some value is not known.
template <class Value, std::size_t N>
double largest_factor(const Value& value, const std::array<double, N>& missing) {
    double factor = HUGE_VAL;
    for (std::size_t i = 0; i < N; ++i) {
        const double size = value[i].magnitude();
        if (size == 0) continue;
        const double own = missing[i] / size * (1 - 0x1p-50);
        factor = std::min(factor, own >= 0 ? own : 0.0);
    }
    return factor;
}

template <std::size_t N>
std::array<double, N> allowed(const std::array<double, N>& missing, double factor) {
    std::array<double, N> most;
    for (std::size_t i = 0; i < N; ++i) most[i] = missing[i] / factor;
    return most;
}

}  // namespace detail

namespace detail {

/// How far a node may be from where plain doubles find it: it is known to 2^-52, and computed with two
/// roundings.
inline double node_error(double middle, double half) { return 0x1p-50 * (std::abs(middle) + half); }

/// How far rounding may take values in plain doubles from true ones, where look(parts, note) notes what is
/// traced of them in as many parts, as long as note() returns true. Is it no more than `most`? A bound it is
/// either way.
template <std::size_t N, class Look>
bool is_rounding_below(const std::array<double, N>& most, std::array<double, N>& rounding, const Look& look) {
    constexpr int most_parts = 4;
    for (int parts = 1; parts <= most_parts; parts *= 2) {
        bool is_enough = true;
        rounding.fill(0);
        look(parts, [&](const auto& traced) {
            for (std::size_t i = 0; i < N; ++i) {
                rounding[i] = std::max(rounding[i], traced[i].error());
                is_enough = is_enough && traced[i].error() <= most[i];
            }
            return is_enough || parts == most_parts;
        });
        if (is_enough) return true;
    }
    return false;
}

/// The k-th part of a disc's real part, in which rules have places.
inline Traced traced_part(double middle, double half, int k, int parts) {
    const double at_nodes = node_error(middle, half);
    return Traced(
        Disc(middle + half * ((2 * k + 1 - parts) / static_cast<double>(parts)), half / parts + at_nodes),
        at_nodes);
}

/// Of f within a disc's real part.
template <std::size_t N, class F>
bool is_rounding_below(const F& f, double middle, double half, const std::array<double, N>& most,
                       std::array<double, N>& rounding) {
    return is_rounding_below(most, rounding, [&](int parts, const auto& note) {
        for (int k = 0; k < parts; ++k)
            if (!note(f(traced_part(middle, half, k, parts)))) return;
    });
}

/// Of f in a rectangle, in as many parts along either variable; f(s) returns a function of t.
template <std::size_t N, class F>
bool is_rounding_below(const F& f, const std::array<double, 2>& middle, const std::array<double, 2>& half,
                       const std::array<double, N>& most, std::array<double, N>& rounding) {
    return is_rounding_below(most, rounding, [&](int parts, const auto& note) {
        for (int k = 0; k < parts; ++k) {
            const auto section = f(traced_part(middle[0], half[0], k, parts));
            for (int l = 0; l < parts; ++l)
                if (!note(section(traced_part(middle[1], half[1], l, parts)))) return;
        }
    });
}

/// A rule's sum about middle -+ half_width; values in plain doubles are off by `rounding`. `first`: those at
/// the first places, where they are known.
template <std::size_t N, class F>
std::array<MidRad, N> plain_sum(const F& f, double middle, const MidRad& half_width, const GaussRule& rule,
                                const std::array<Approximate, N>* first,
                                const std::array<double, N>& rounding) {
    std::array<Approximate, N> totals{}, sizes{};
    const auto add_pack = [&](std::size_t k, const std::array<Approximate, N>& value) {
        for (std::size_t i = 0; i < N; ++i) {
            const Approximate term = rule.weights[k] * value[i];
            totals[i] += term;
            sizes[i] += abs(term);
        }
    };
    if (first) add_pack(0, *first);
    for (std::size_t k = first ? 1 : 0; k < rule.packs; ++k)
        add_pack(k, f(Approximate(middle) + half_width.mid() * rule.places[k]));
    // Weights add up to 2. Their own rounding and that of the sum are relative to its terms.
    std::array<MidRad, N> sum;
    for (std::size_t i = 0; i < N; ++i)
        sum[i] = MidRad::ball(totals[i].sum(), (2 * rounding[i] + 0x1p-46 * sizes[i].sum()) * (1 + 0x1p-40));
    return sum;
}

/// Narrows what rounding could not be told of well by the sum in midpoints and radii.
template <std::size_t N, class F>
void narrow(const F& f, double middle, const MidRad& half_width, const GaussRule& rule,
            std::array<MidRad, N>& sum) {
    std::array<MidRad, N> enclosed{};
    for (std::size_t n = 0; n < rule.count; ++n) {
        const auto value = f(MidRad(middle) + half_width * rule.nodes[n].at);
        for (std::size_t i = 0; i < N; ++i) enclosed[i] += rule.nodes[n].weight * value[i];
    }
    for (std::size_t i = 0; i < N; ++i)
        if (!(sum[i].radius() <= enclosed[i].radius())) sum[i] = enclosed[i];
}

/// The sum of the product of two rules in plain doubles, of which weights add up to 4; `rounding` of values.
template <std::size_t N, class F>
std::array<MidRad, N> plain_product(const F& f, const std::array<double, 2>& middle,
                                    const std::array<double, 2>& half, const GaussRule& outer,
                                    const GaussRule& inner, const std::array<double, N>& rounding) {
    std::array<Approximate, N> totals{}, sizes{};
    for (std::size_t m = 0; m < outer.packs; ++m) {
        const auto section = f(Approximate(middle[0]) + half[0] * outer.places[m]);
        std::array<Approximate, N> along{}, size_along{};
        for (std::size_t n = 0; n < inner.count; ++n) {
            const auto value = section(Approximate(middle[1] + half[1] * inner.nodes[n].at.mid()));
            for (std::size_t i = 0; i < N; ++i) {
                const Approximate term = inner.nodes[n].weight.mid() * value[i];
                along[i] += term;
                size_along[i] += abs(term);
            }
        }
        for (std::size_t i = 0; i < N; ++i) {
            totals[i] += outer.weights[m] * along[i];
            sizes[i] += outer.weights[m] * size_along[i];
        }
    }
    std::array<MidRad, N> sum;
    static_assert(2 * GaussRule::most <= 0x1p7);  // terms one after the other, each of which rounds by 2^-53
    for (std::size_t i = 0; i < N; ++i)
        sum[i] = MidRad::ball(totals[i].sum(), (4 * rounding[i] + 0x1p-45 * sizes[i].sum()) * (1 + 0x1p-40));
    return sum;
}

/// Sums by midpoint and radius at each node what rounding could not be told of otherwise.
template <std::size_t N, class F>
std::array<MidRad, N> enclosed_product(const F& f, const std::array<double, 2>& middle,
                                       const std::array<MidRad, 2>& width, const GaussRule& outer,
                                       const GaussRule& inner) {
    std::array<MidRad, N> sum{};
    for (std::size_t m = 0; m < outer.count; ++m) {
        const auto section = f(MidRad(middle[0]) + 0.5 * (width[0] * outer.nodes[m].at));
        for (std::size_t n = 0; n < inner.count; ++n) {
            const auto at_node = section(MidRad(middle[1]) + 0.5 * (width[1] * inner.nodes[n].at));
            const MidRad weight = outer.nodes[m].weight * inner.nodes[n].weight;
            for (std::size_t i = 0; i < N; ++i) sum[i] += weight * at_node[i];
        }
    }
    return sum;
}

}  // namespace detail

/// The integrals over [a, b] of the components of f, which takes any of these numbers and returns an
/// array of as many. Of each, the mean over [a, b] may be missed by `enough`, or by what rounds its values.
/// False: the effort is spent, and the enclosures are as wide as interval arithmetic makes them there,
/// perhaps infinite.
///
/// One look at f all about [a, b], in discs that know of rounding, bounds what a rule leaves out and how far
/// plain doubles are off at its nodes. Where f.is_singular(disc) tells at little cost that f would not be
/// bounded in a disc, that look is saved.
template <std::size_t N, class F>
bool integrate(const F& f, double a, double b, const std::array<double, N>& enough,
               std::array<Interval, N>& sum, Effort& effort) {
    constexpr std::size_t first_rule = 1, frequent_rule = 2;
    const double middle = 0.5 * (a + b), half = Interval::up(0.5 * (b - a));
    const MidRad half_width = 0.5 * (MidRad(b) - a);
    ++effort.parts_used;
    std::size_t first = std::exchange(effort.ellipse, first_ellipse);
    if constexpr (requires { f.is_singular(Disc()); })
        while (first < ellipses.size() && f.is_singular(around(first, middle, half))) ++first;
    std::array<double, N> missing, most, rounding;
    std::array<Approximate, N> places;  // values at the first places of the rule that is taken most
    if (first < ellipses.size()) {
        // Of plain values: centers of discs may be far larger. The first place of an odd number is the
        // middle.
        static_assert(node_counts[frequent_rule] % 2 == 1);
        places = f(Approximate(middle) + half_width.mid() * gauss(frequent_rule).places[0]);
        for (std::size_t i = 0; i < N; ++i) {
            missing[i] = std::max(enough[i], detail::value_rounding * std::abs(places[i][0]));
            most[i] = detail::poor * missing[i];
        }
    }
    for (std::size_t k = first; k < ellipses.size(); ++k) {
        const auto all = f(Traced(around(k, middle, half), detail::node_error(middle, half)));
        for (std::size_t i = 0; i < N; ++i) rounding[i] = all[i].error();
        const double factor = detail::largest_factor(all, missing);
        const auto& factors = remainder_factors(k);
        std::size_t r = first_rule;
        while (r < node_counts.size() && !(factors[r] <= factor)) ++r;
        if (r == node_counts.size()) continue;
        // With few nodes a larger one may be enough.
        effort.ellipse = r <= frequent_rule && k > first_ellipse ? k - 1 : k;
        bool is_plain = true;
        for (std::size_t i = 0; i < N; ++i) is_plain = is_plain && rounding[i] <= most[i];
        const bool is_told = is_plain || detail::is_rounding_below(f, middle, half, most, rounding);
        auto part = detail::plain_sum(f, middle, half_width, gauss(r), r == frequent_rule ? &places : nullptr,
                                      rounding);
        if (!is_told) detail::narrow(f, middle, half_width, gauss(r), part);
        // What the rule may be missing counts for each unit of width.
        for (std::size_t i = 0; i < N; ++i)
            sum[i] += (half_width * (part[i] + MidRad::ball(0, missing[i]))).enclosure();
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

/// Integrates over rectangles: f(s) returns a function of t, for s in [a0, b0], t in [a1, b1]. What the
/// product of two rules leaves out is what one leaves out along s for the worst t, and the other along t for
/// the worst s.
template <std::size_t N, class F>
bool integrate(const F& f, std::array<double, 2> a, std::array<double, 2> b,
               const std::array<double, N>& enough, std::array<Interval, N>& sum, Effort& effort) {
    const std::array middle{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
    const std::array half{Interval::up(0.5 * (b[0] - a[0])), Interval::up(0.5 * (b[1] - a[1]))};
    const std::array width{MidRad(b[0]) - a[0], MidRad(b[1]) - a[1]};
    ++effort.parts_used;
    std::array<double, N> missing, most, rounding;
    const auto value = f(MidRad(middle[0]))(MidRad(middle[1]));
    for (std::size_t i = 0; i < N; ++i) {
        missing[i] = std::max(enough[i], detail::value_rounding * value[i].magnitude());
        most[i] = detail::poor_in_two * missing[i];
    }
    constexpr std::size_t none = node_counts.size();
    std::array<std::size_t, 2> chosen{none, none};
    for (const std::size_t axis : {0, 1})
        for (std::size_t k = first_ellipse; k <= last_in_two && chosen[axis] == none; ++k) {
            const Disc z = around(k, middle[axis], half[axis]);
            const Interval other(a[1 - axis], b[1 - axis]);
            const auto allowed = detail::allowed(missing, 4 * remainder_factors(k)[k]);
            const bool is_enough = axis == 0 ? is_bounded(f(z), other, allowed, detail::parts_of_product)
                                             : is_bounded([&](const Disc& s) { return f(s)(z); }, other,
                                                          allowed, detail::parts_of_product);
            if (is_enough) chosen[axis] = k;
        }
    if (chosen[0] < none && chosen[1] < none) {
        const GaussRule &outer = gauss(chosen[0]), &inner = gauss(chosen[1]);
        const auto part = detail::is_rounding_below(f, middle, half, most, rounding)
                              ? detail::plain_product(f, middle, half, outer, inner, rounding)
                              : detail::enclosed_product<N>(f, middle, width, outer, inner);
        const MidRad share = 0.25 * (width[0] * width[1]);
        for (std::size_t i = 0; i < N; ++i)
            sum[i] += (share * (part[i] + MidRad::ball(0, missing[i]))).enclosure();
        return true;
    }
    // Halves along the direction in which no rule was enough, or the wider one of two.
    const bool only_first = chosen[1] < none, only_second = chosen[0] < none;
    const std::size_t axis = only_first ? 0 : only_second ? 1 : half[1] > half[0] ? 1 : 0;
    if (effort.parts_used < effort.parts && a[axis] < middle[axis] && middle[axis] < b[axis]) {
        auto low = b, high = a;
        low[axis] = high[axis] = middle[axis];
        const bool first = integrate(f, a, low, enough, sum, effort);
        const bool second = integrate(f, high, b, enough, sum, effort);
        return first && second;
    }
    const auto all = f(MidRad(Interval(a[0], b[0])))(MidRad(Interval(a[1], b[1])));
    for (std::size_t i = 0; i < N; ++i) sum[i] += (width[0] * width[1] * all[i]).enclosure();
    return false;
}

namespace detail {

/// A rule that estimates of itself what it leaves out.
struct EstimatingRule {
    explicit EstimatingRule(const GaussRule& gauss) : rule(gauss) {
        for (const std::size_t k : {0, 1}) {
            const unsigned degree = static_cast<unsigned>(rule.count - 2 + k);
            for (std::size_t i = 0; i < rule.count; ++i)
                of_nodes[k][i] = (degree + 0.5) * rule.nodes[i].weight.mid() *
                                 std::legendre(degree, rule.nodes[i].at.mid());
            for (std::size_t p = 0; p < rule.packs; ++p)
                of_packs[k][p] =
                    Approximate::of([&](std::size_t i) { return of_nodes[k][p * Approximate::lanes + i]; });
        }
    }

    const GaussRule rule;
    /// What takes values at the nodes to the coefficients of Legendre's polynomials of the two highest
    /// degrees that the nodes tell apart.
    std::array<std::array<double, GaussRule::most>, 2> of_nodes{};
    std::array<std::array<Approximate, GaussRule::most / Approximate::lanes>, 2> of_packs{};
};
/// Along an edge's span, of which there are many, and across it.
inline constexpr std::size_t nodes_along = 8, nodes_across = 20;
inline const EstimatingRule& rule_along() {
    static const EstimatingRule rule(gauss_rule<nodes_along>());
    return rule;
}
inline const EstimatingRule& rule_across() {
    static const EstimatingRule rule(gauss_rule<nodes_across>());
    return rule;
}

}  // namespace detail

namespace detail {

/// What the product of two rules has over a rectangle, and leaves out.
template <std::size_t N>
struct Estimate {
    std::array<double, 2> a, b;
    std::array<Interval, N> sum;
    bool is_enough = true;
    double left_out = 0;   ///< at most, in units of what need not be known better
    std::size_t axis = 0;  ///< along which more is left out

    bool operator<(const Estimate& other) const { return left_out < other.left_out; }
};

template <std::size_t N, class F>
Estimate<N> estimate_part(const F& f, const std::array<double, 2>& a, const std::array<double, 2>& b,
                          const std::array<double, N>& enough) {
    constexpr double rounding = 0x1p-46, falling = 0x1p-8;
    constexpr std::size_t inner_nodes = nodes_across;
    const std::array middle{0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])},
        half{0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1])};
    const double quarter = half[0] * half[1];
    const EstimatingRule &outer = rule_along(), &inner = rule_across();
    // The two last coefficients along the one variable, at each node of the other.
    std::array<std::array<std::array<Approximate, inner_nodes>, N>, 2> first{};
    std::array<Approximate, N> totals{}, sizes{}, tails{};
    for (std::size_t m = 0; m < outer.rule.packs; ++m) {
        const auto section = f(Approximate(middle[0]) + half[0] * outer.rule.places[m]);
        std::array<std::array<Approximate, N>, inner_nodes> values;
        for (std::size_t n = 0; n < inner_nodes; ++n)
            values[n] = section(Approximate(middle[1] + half[1] * inner.rule.nodes[n].at.mid()));
        for (std::size_t i = 0; i < N; ++i) {
            Approximate terms, sizes_of_terms;
            std::array<Approximate, 2> second;
            for (std::size_t n = 0; n < inner_nodes; ++n) {
                const Approximate& value = values[n][i];
                const Approximate term = inner.rule.nodes[n].weight.mid() * value;
                terms += term;
                sizes_of_terms += abs(term);
                for (const std::size_t k : {0, 1}) {
                    first[k][i][n] += outer.of_packs[k][m] * value;
                    second[k] += inner.of_nodes[k][n] * value;
                }
            }
            totals[i] += outer.rule.weights[m] * terms;
            sizes[i] += outer.rule.weights[m] * sizes_of_terms;
            tails[i] += outer.rule.weights[m] * max(abs(second[0]), abs(second[1]));
        }
    }
    std::array<double, N> total, size;
    std::array<std::array<double, N>, 2> tail{};  // along both axes
    for (std::size_t i = 0; i < N; ++i) {
        total[i] = totals[i].sum();
        size[i] = sizes[i].sum();
        tail[1][i] = 2 * tails[i].sum();
        for (std::size_t n = 0; n < inner_nodes; ++n)
            tail[0][i] += 2 * inner.rule.nodes[n].weight.mid() *
                          std::max(std::abs(first[0][i][n].sum()), std::abs(first[1][i][n].sum()));
    }
    Estimate<N> part{a, b, {}};
    std::array<double, 2> worst{};
    for (std::size_t i = 0; i < N; ++i) {
        const double allowed = std::max(enough[i] * quarter, rounding * size[i] * quarter);
        double left_out = 0;
        for (const std::size_t axis : {0, 1}) {
            const double share = tail[axis][i] / size[i];
            const double along =
                (share < falling ? tail[axis][i] * std::sqrt(share) : tail[axis][i]) * quarter;
            left_out += along;
            worst[axis] = std::max(worst[axis], along / allowed);
        }
        part.is_enough = part.is_enough && left_out <= allowed;
        part.left_out = std::max(part.left_out, std::isfinite(left_out) ? left_out / enough[i] : HUGE_VAL);
        part.sum[i] = Interval::ball(quarter * total[i], 0x1p-50 * size[i] * quarter + left_out);
    }
    part.axis = worst[1] > worst[0] ? 1 : 0;
    return part;
}

}  // namespace detail

/// estimate() takes the product of two rules where a proof of the integral would take too long. It is an
/// estimate, if a generous one: coefficients of Legendre's polynomials fall like powers q^n, so that with
/// those of degrees n - 2 and n - 1 at p of the integrand's size a rule with n nodes, which knows all up to 2
/// n - 1, leaves out about p^2 [Trefethen13, Thms. 8.1, 19.3]; it is taken to be p^(3/2), and as long as they
/// do not fall p. (Next to where axes all but cross p^(7/4) is too little, a hundred times.) f takes several
/// s at once and returns a function of t. Parts in which most is left out are halved first. False: the effort
/// is spent, and it is a poor one.
template <std::size_t N, class F>
bool estimate(const F& f, std::array<double, 2> a, std::array<double, 2> b,
              const std::array<double, N>& enough, std::array<Interval, N>& sum, Effort& effort) {
    const auto add = [&](const detail::Estimate<N>& part) {
        for (std::size_t i = 0; i < N; ++i) sum[i] += part.sum[i];
    };
    std::priority_queue<detail::Estimate<N>> poor;
    const auto look_at = [&](const std::array<double, 2>& from, const std::array<double, 2>& to) {
        ++effort.parts_used;
        if (auto part = detail::estimate_part(f, from, to, enough); part.is_enough)
            add(part);
        else
            poor.push(std::move(part));
    };
    look_at(a, b);
    const double allowed = 0.25 * (b[0] - a[0]) * (b[1] - a[1]);
    while (!poor.empty() && !(poor.top().left_out * static_cast<double>(poor.size()) <= allowed)) {
        const detail::Estimate<N> part = poor.top();
        const double from = part.a[part.axis], to = part.b[part.axis], middle = 0.5 * (from + to);
        if (effort.parts_used >= effort.parts || !(from < middle && middle < to)) break;
        poor.pop();
        auto low = part.b, high = part.a;
        low[part.axis] = high[part.axis] = middle;
        look_at(part.a, low);
        look_at(high, part.b);
    }
    const bool is_complete = poor.empty() || effort.parts_used < effort.parts;
    for (; !poor.empty(); poor.pop()) add(poor.top());
    return is_complete;
}

}  // namespace vcell::check
