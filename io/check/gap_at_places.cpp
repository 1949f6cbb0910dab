#include "trim_pair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "lanes.hpp"

namespace vcell::check {
namespace {

/// Trimming curves and edges of higher degree are not looked at by values.
constexpr int kMostDegree = 7;
using TrimForm = std::array<double, kMostDegree + 1>;

/// Chebyshev's places between 0 and 1 for polynomials of one degree. A polynomial is nowhere larger than the
/// largest value there times Lebesgue's constant where they are one more than its degree [Trefethen13,
/// Thm. 15.2]. That grows: where there are N, twice as many as the degree, it is no larger than the
/// largest value there by cos(degree pi / (2 N)) [EhlichZeller64].
struct Places {
    static constexpr int most_degree = 31, most_with_few = 12;
    static constexpr std::size_t most_packs = (2 * most_degree + Lanes::lanes - 1) / Lanes::lanes;

    Places(int degree, bool are_many) {
        const std::size_t last = static_cast<std::size_t>(are_many ? 2 * std::max(degree, 1) - 1 : degree);
        packs = last / Lanes::lanes + 1;
        for (std::size_t k = 0; k < packs; ++k) {
            at[k] = Lanes::of([&](std::size_t lane) {
                const double n = static_cast<double>(std::min(k * Lanes::lanes + lane, last));
                return 0.5 -
                       0.5 * std::cos((2 * n + 1) * std::numbers::pi / (2.0 * static_cast<double>(last) + 2));
            });
            rest[k] = 1.0 - at[k];
        }
        factor = 1.01 * (are_many ? 1 / std::cos(std::numbers::pi / 4)
                                  : 2 / std::numbers::pi * std::log(degree + 1.0) + 1);
    }

    /// Few degrees occur in a cell, and cosines take time.
    template <bool AreMany>
    static const Places& of(int degree) {
        using Known = const Places& (*)();
        static constexpr auto known = []<int... N>(std::integer_sequence<int, N...>) {
            return std::array<Known, sizeof...(N)>{known_of<N, AreMany>...};
        }
        (std::make_integer_sequence<int, most_degree + 1>());
        return known[static_cast<std::size_t>(degree)]();
    }

    std::array<Lanes, most_packs> at, rest;
    std::size_t packs;
    double factor;

private:
    template <int Degree, bool AreMany>
    static const Places& known_of() {
        static const Places places(Degree, AreMany);
        return places;
    }
};

/// Bernstein's polynomials of degree d at t, r = 1 - t.
template <class D>
void set_basis(const Lanes& t, const Lanes& r, D d, std::array<Lanes, kMostDegree + 1>& basis) {
    const std::size_t last = static_cast<std::size_t>(d);
    Lanes power = r;
    basis[last] = t;
    for (std::size_t i = 1; i < last; ++i) {
        basis[last - i] = power;
        power = power * r;
    }
    basis[0] = power;
    power = t;
    for (std::size_t i = 1; i < last; ++i) {
        basis[i] = binomial(d, static_cast<int>(i)) * (basis[i] * power);
        power = power * t;
    }
    if (last > 1) basis[last] = power;
}
/// A lower bound of 0 and of a polynomial in Bernstein form. With u and v what the middle coefficient of
/// three is below the others, its least value is u v / (u + v) above that.
double least_of(const TrimForm& c, int degree) {
    const double last = c[static_cast<std::size_t>(degree)], at_ends = std::min({c[0], last, 0.0});
    if (degree > 2) return std::min(at_ends, *std::min_element(c.begin(), c.begin() + degree));
    if (degree < 2 || c[1] >= std::min(c[0], last)) return at_ends;
    const double u = c[0] - c[1], v = last - c[1];
    const double rounding = 0x1p-50 * std::max({std::abs(c[0]), std::abs(c[1]), std::abs(last)});
    return std::min(at_ends, c[1] + u * v / (u + v) - rounding);
}

/// The largest differences at places, of coordinates times both weights. Degrees are known to the
/// compiler where they are the usual ones.
template <class M, class N, class D, class E>
std::array<Lanes, 3> largest_differences(const Places& places, M m, N n, D d, E e,
                                         const std::array<TrimForm, 2>& a, const std::array<TrimForm, 2>& b,
                                         const BezierPiece<3>& edge, const Net& of_patch) {
    const Net::Point* const net = &of_patch.at(0, 0);
    const auto* const curve = &edge.points[0];
    std::array<Lanes, 3> most{};
    for (std::size_t pack = 0; pack < places.packs; ++pack) {
        const Lanes &t = places.at[pack], &r = places.rest[pack];
        const auto powers = [](const Lanes& x, const Lanes& y, auto power) {
            return power == 2 ? std::array<Lanes, 3>{y * y, 2.0 * (x * y), x * x}
                              : std::array<Lanes, 3>{y, x, 0.0};
        };
        std::array<Lanes, kMostDegree + 1> basis;
        set_basis(t, r, d, basis);
        const auto value = [&](const TrimForm& c) {
            Lanes sum = basis[0] * c[0];
            for (std::size_t i = 1; i <= static_cast<std::size_t>(d); ++i) sum += basis[i] * c[i];
            return sum;
        };
        const std::array<Lanes, 3> along = powers(value(a[0]), value(b[0]), m),
                                   across = powers(value(a[1]), value(b[1]), n);
        std::array<Lanes, 4> lifted{};
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j) {
                const Lanes share = along[static_cast<std::size_t>(i)] * across[static_cast<std::size_t>(j)];
                const Net::Point& p = net[i * (n + 1) + j];
                for (std::size_t k = 0; k < 4; ++k) lifted[k] += share * p[k].mid();
            }
        std::array<Lanes, 4> on_edge{};
        for (std::size_t k = 0; k < 4; ++k) {
            if (e == d) {
                on_edge[k] = basis[0] * curve[0][k].mid();
                for (std::size_t i = 1; i <= static_cast<std::size_t>(d); ++i)
                    on_edge[k] += basis[i] * curve[i][k].mid();
                continue;
            }
            // By Horner's rule in t, with powers of r.
            Lanes sum = curve[e][k].mid(), power = 1.0;
            for (int i = e - 1; i >= 0; --i) {
                power = power * r;
                sum = sum * t + (binomial(e, i) * curve[i][k].mid()) * power;
            }
            on_edge[k] = sum;
        }
        for (std::size_t k = 0; k < 3; ++k)
            most[k] = max(most[k], abs(lifted[k] * on_edge[3] - on_edge[k] * lifted[3]));
    }
    return most;
}

}  // namespace

// With s = a / w, b = w - a and so for t, S's homogeneous coordinates are sums of N_ij times products of
// binomials and powers of a, b that are not negative, and add up to w^(m + n). Coefficients of a and b
// may be negative, with magnitudes that add up to more: so many roundings are relative to the largest N
// times powers of those.
double gap_at_places(const NetOver& over, const TrimPair& pair, bool are_many) {
    const int m = over.net->degree_s(), n = over.net->degree_t(), d = pair.trim.degree(),
              e = pair.edge.degree();
    if (m > 2 || n > 2 || d > kMostDegree || e > kMostDegree) return HUGE_VAL;
    const int degree = (m + n) * d + e;
    if (degree > Places::most_degree || (are_many && degree <= Places::most_with_few)) return HUGE_VAL;
    // The trimming curve's places in the patch.
    std::array<TrimForm, 2> a{}, b{};
    double off = 0, aside = 0, least_weight = HUGE_VAL, most_shares = 0;
    for (const int axis : {0, 1}) {
        const auto k = static_cast<std::size_t>(axis);
        const MidRad scale = over.scale_to_shares(axis);
        for (std::size_t i = 0; i <= static_cast<std::size_t>(d); ++i) {
            const auto& point = pair.trim.points[i];
            const MidRad x = scale * point[k], y = point[2] - x;
            a[k][i] = x.mid();
            b[k][i] = y.mid();
            off = std::max(off, x.radius() + y.radius());
            least_weight = std::min(least_weight, point[2].mid() - point[2].radius());
            most_shares =
                std::max(most_shares, std::abs(x.mid()) + std::abs(y.mid()) + x.radius() + y.radius());
        }
        aside = std::max(aside, -std::min(least_of(a[k], d), least_of(b[k], d)));
    }
    const Sizes& of_net = over.net->sizes();
    Sizes of_edge;
    for (const auto& p : pair.edge.points) of_edge.meet(p);
    if (!(least_weight > 0) || !(of_net.least_weight > 0) || !(of_edge.least_weight > 0)) return HUGE_VAL;

    const Places& places = are_many ? Places::of<true>(degree) : Places::of<false>(degree);
    using Two = std::integral_constant<int, 2>;
    using Five = std::integral_constant<int, 5>;
    const bool is_usual = m == 2 && n == 2;
    const std::array<Lanes, 3> most =
        is_usual && d == 2 && e == 2
            ? largest_differences(places, Two(), Two(), Two(), Two(), a, b, pair.edge, *over.net)
        : is_usual && d == 5 && e == 5
            ? largest_differences(places, Two(), Two(), Five(), Five(), a, b, pair.edge, *over.net)
            : largest_differences(places, m, n, d, e, a, b, pair.edge, *over.net);
    // w^(m + n), with what a and b may be off by.
    double power = 1, least_power = 1;
    for (int i = 0; i < m + n; ++i) {
        power *= most_shares + off;
        least_power *= least_weight;
    }
    // Terms of a sum of d + 1 go through d + 1 roundings of their binomials and powers, d of 1 - t, one
    // with their coefficients and d in the sum, or where d is two through two less, for powers are
    // squares; their products of m + n factors through m + n times as many and as many more, sums of them
    // through eight.
    const int of_terms = d <= 2 ? 4 + d : 3 * d + 2;
    const double relative = rounding_of((m + n) * of_terms + m + n + 9) + (m + n) * (off / least_weight),
                 relative_of_edge = rounding_of(4 * e + 4);
    const auto &size = of_net.most, &error = of_net.error, &edge_size = of_edge.most,
               &edge_error = of_edge.error;
    const double weight_error = (size[3] * relative + error[3]) * power;
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double lifted_error = (size[k] * relative + error[k]) * power,
                     curve_error = edge_size[k] * relative_of_edge + edge_error[k],
                     edge_weight_error = edge_size[3] * relative_of_edge + edge_error[3];
        const double rounded = rounding_of(3) * power * (size[k] * edge_size[3] + edge_size[k] * size[3]);
        const double own = rounded + lifted_error * edge_size[3] + size[k] * power * edge_weight_error +
                           curve_error * size[3] * power + edge_size[k] * weight_error;
        const double x = places.factor * (most[k].greatest() + 1.01 * own);
        sum += x * x;
    }
    // Beside the patch shares are negative: on its side, as far away as that, the weight is known.
    const double change = (m + n) * (2 * aside / least_weight) * size[3] * power;
    const double scale =
        (of_net.least_weight * least_power - change - weight_error) * of_edge.least_weight * (1 - 0x1p-40);
    if (!(scale > 0)) return HUGE_VAL;
    return std::sqrt(sum) / scale * (1 + 0x1p-40);
}

}  // namespace vcell::check
