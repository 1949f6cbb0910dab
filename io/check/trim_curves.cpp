#include "trim_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "../pictures/trims.hpp"
#include "lanes.hpp"
#include "nets.hpp"

namespace vcell::check {
namespace {

/// A span of a trimming curve and the part of the edge that it follows, in its direction.
struct Pair {
    BezierPiece<2> trim;
    BezierPiece<3> edge;
};

template <int Dim>
const BezierPiece<Dim>& span_at(const std::vector<BezierPiece<Dim>>& spans, double t) {
    const auto it = std::ranges::find_if(spans, [t](const BezierPiece<Dim>& s) { return t <= s.end; });
    return it == spans.end() ? spans.back() : *it;
}

template <int Dim>
std::array<BezierPiece<Dim>, 2> halves(const BezierPiece<Dim>& span) {
    std::array<BezierPiece<Dim>, 2> h{span, span};
    h[0].end = h[1].begin = std::midpoint(span.begin, span.end);
    const int d = span.degree();
    for (int k = 0; k <= d; ++k) {
        h[0].points[k] = h[1].points[0];
        for (int i = 0; i < d - k; ++i)
            for (std::size_t c = 0; c <= Dim; ++c)
                h[1].points[i][c] = mean(h[1].points[i][c], h[1].points[i + 1][c]);
    }
    return h;
}

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

class TrimJudge {
    /// Trimming curves and edges of higher degree are not looked at by values.
    static constexpr int kMostDegree = 7;
    using Coefficients = std::array<double, kMostDegree + 1>;

public:
    TrimJudge(const Patch& patch, const Net& net, const Trim& trim, const Subject& subject)
        : surface_(*patch.surface),
          lo_(patch.lo),
          hi_(patch.hi),
          trim_(*trim.curve),
          edge_(subject.cell.edges[*trim.curve->edge].curve),
          net_(&net) {}

    /// Where neither curve has knots: the most frequent case.
    std::optional<Pair> only_pair() const {
        const double near = kPlaceRounding * (edge_.domain_end() - edge_.domain_begin());
        if (!(std::abs(trim_.curve.domain_begin() - edge_.domain_begin()) <= near) ||
            !(std::abs(trim_.curve.domain_end() - edge_.domain_end()) <= near))
            return std::nullopt;
        auto trim = only_span<2>(trim_.curve, lo_);
        auto edge = trim ? only_span<3>(edge_, net_->origin()) : std::nullopt;
        if (!edge) return std::nullopt;
        if (trim_.reversed) std::ranges::reverse(edge->points);
        return Pair{std::move(*trim), std::move(*edge)};
    }
    /// Spans between the knots of both curves, which may differ by rounding.
    std::vector<Pair> pairs() const {
        auto trims = spans<2>(trim_.curve, lo_);
        auto edges = spans<3>(edge_, net_->origin());
        const double near = kPlaceRounding * (edge_.domain_end() - edge_.domain_begin());
        std::vector<double> ends;  // of spans, in the edge's parameters
        for (const auto& s : edges) {
            ends.push_back(s.begin);
            ends.push_back(s.end);
        }
        const auto to_edge = [&](double t) {
            const double x = edge_parameter(trim_, edge_, t);
            for (const double k : ends)
                if (std::abs(x - k) <= near) return k;
            return x;
        };
        std::vector<double> cuts;  // in the trim's parameters
        for (const auto& s : trims) cuts.push_back(s.begin);
        cuts.push_back(trims.back().end);
        for (const double k : ends) {
            const double t = edge_parameter(trim_, edge_, k);  // its own inverse
            const bool is_there =
                std::ranges::any_of(cuts, [&](double c) { return std::abs(c - t) <= near; });
            if (!is_there && t > trims.front().begin && t < trims.back().end) cuts.push_back(t);
        }
        std::ranges::sort(cuts);
        std::vector<Pair> result;
        for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
            const double a = cuts[k], b = cuts[k + 1], x = to_edge(a), y = to_edge(b);
            const auto& trim = span_at(trims, std::midpoint(a, b));
            const auto& edge = span_at(edges, std::midpoint(x, y));
            Pair pair{part_of(trim, a, b), part_of(edge, std::min(x, y), std::max(x, y))};
            if (trim_.reversed) std::ranges::reverse(pair.edge.points);
            result.push_back(std::move(pair));
        }
        return result;
    }

    /// Bounds |S(c(t)) - C(t)| by its values at as many places as it has coefficients, or about twice as
    /// many. Infinite where the curve runs far beside the patch, degrees are none of the usual ones, or so
    /// low that many places tell no more.
    ///
    /// With s = a / w, b = w - a and so for t, S's homogeneous coordinates are sums of N_ij times products of
    /// binomials and powers of a, b that are not negative, and add up to w^(m + n). Coefficients of a and b
    /// may be negative, with magnitudes that add up to more: so many roundings are relative to the largest N
    /// times powers of those.
    double gap_at_places(const Pair& pair, bool are_many) const {
        const int m = net_->degree_s(), n = net_->degree_t(), d = pair.trim.degree(), e = pair.edge.degree();
        if (m > 2 || n > 2 || d > kMostDegree || e > kMostDegree) return HUGE_VAL;
        const int degree = (m + n) * d + e;
        if (degree > Places::most_degree || (are_many && degree <= Places::most_with_few)) return HUGE_VAL;
        // The trimming curve's places in the patch.
        std::array<Coefficients, 2> a{}, b{};
        double off = 0, aside = 0, least_weight = HUGE_VAL, most_shares = 0;
        for (const int axis : {0, 1}) {
            const auto k = static_cast<std::size_t>(axis);
            const MidRad scale = scale_to_shares(axis);
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
        const Sizes& of_net = net_->sizes();
        Sizes of_edge;
        for (const auto& p : pair.edge.points) of_edge.meet(p);
        if (!(least_weight > 0) || !(of_net.least_weight > 0) || !(of_edge.least_weight > 0)) return HUGE_VAL;

        const Places& places = are_many ? Places::of<true>(degree) : Places::of<false>(degree);
        using Two = std::integral_constant<int, 2>;
        using Five = std::integral_constant<int, 5>;
        const bool is_usual = m == 2 && n == 2;
        const std::array<Lanes, 3> most =
            is_usual && d == 2 && e == 2   ? largest(places, Two(), Two(), Two(), Two(), a, b, pair.edge)
            : is_usual && d == 5 && e == 5 ? largest(places, Two(), Two(), Five(), Five(), a, b, pair.edge)
                                           : largest(places, m, n, d, e, a, b, pair.edge);
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
        const double relative = rounding((m + n) * of_terms + m + n + 9) + (m + n) * (off / least_weight),
                     relative_of_edge = rounding(4 * e + 4);
        const auto &size = of_net.most, &error = of_net.error, &edge_size = of_edge.most,
                   &edge_error = of_edge.error;
        const double weight_error = (size[3] * relative + error[3]) * power;
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double lifted_error = (size[k] * relative + error[k]) * power,
                         curve_error = edge_size[k] * relative_of_edge + edge_error[k],
                         edge_weight_error = edge_size[3] * relative_of_edge + edge_error[3];
            const double rounded = rounding(3) * power * (size[k] * edge_size[3] + edge_size[k] * size[3]);
            const double own = rounded + lifted_error * edge_size[3] + size[k] * power * edge_weight_error +
                               curve_error * size[3] * power + edge_size[k] * weight_error;
            const double x = places.factor * (most[k].greatest() + 1.01 * own);
            sum += x * x;
        }
        // Beside the patch shares are negative: on its side, as far away as that, the weight is known.
        const double change = (m + n) * (2 * aside / least_weight) * size[3] * power;
        const double scale = (of_net.least_weight * least_power - change - weight_error) *
                             of_edge.least_weight * (1 - 0x1p-40);
        if (!(scale > 0)) return HUGE_VAL;
        return std::sqrt(sum) / scale * (1 + 0x1p-40);
    }

    /// The largest differences at places, of coordinates times both weights. Degrees are known to the
    /// compiler where they are the usual ones.
    template <class M, class N, class D, class E>
    std::array<Lanes, 3> largest(const Places& places, M m, N n, D d, E e,
                                 const std::array<Coefficients, 2>& a, const std::array<Coefficients, 2>& b,
                                 const BezierPiece<3>& edge) const {
        const Net::Point* const net = &net_->at(0, 0);
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
            const auto value = [&](const Coefficients& c) {
                Lanes sum = basis[0] * c[0];
                for (std::size_t i = 1; i <= static_cast<std::size_t>(d); ++i) sum += basis[i] * c[i];
                return sum;
            };
            const std::array<Lanes, 3> along = powers(value(a[0]), value(b[0]), m),
                                       across = powers(value(a[1]), value(b[1]), n);
            std::array<Lanes, 4> lifted{};
            for (int i = 0; i <= m; ++i)
                for (int j = 0; j <= n; ++j) {
                    const Lanes share =
                        along[static_cast<std::size_t>(i)] * across[static_cast<std::size_t>(j)];
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

    /// Bernstein's polynomials of degree d at t, r = 1 - t.
    template <class D>
    static void set_basis(const Lanes& t, const Lanes& r, D d, std::array<Lanes, kMostDegree + 1>& basis) {
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
    static double least_of(const Coefficients& c, int degree) {
        const double last = c[static_cast<std::size_t>(degree)], at_ends = std::min({c[0], last, 0.0});
        if (degree > 2) return std::min(at_ends, *std::min_element(c.begin(), c.begin() + degree));
        if (degree < 2 || c[1] >= std::min(c[0], last)) return at_ends;
        const double u = c[0] - c[1], v = last - c[1];
        const double rounding = 0x1p-50 * std::max({std::abs(c[0]), std::abs(c[1]), std::abs(last)});
        return std::min(at_ends, c[1] + u * v / (u + v) - rounding);
    }

    /// Bounds |S(c(t)) - C(t)|: S's homogeneous coordinates along c are polynomials in t, and so are those of
    /// the difference.
    double gap(const Pair& pair) const {
        const int m = net_->degree_s(), n = net_->degree_t(), d = pair.trim.degree();
        if ((m + n) * d + pair.edge.degree() > kMaxBinomial) return HUGE_VAL;
        const std::array<Form, 4> lifted =
            lift(Powers(pair.trim, 0, scale_to_shares(0), m), Powers(pair.trim, 1, scale_to_shares(1), n));
        const Form edge_weight = pair.edge.form(3);
        const Interval scale = lifted[3].range() * edge_weight.range();
        if (!(scale.lower() > 0)) return HUGE_VAL;
        Interval sum(0.0);
        for (std::size_t k = 0; k < 3; ++k) {
            Form difference = lifted[k] * edge_weight;
            difference.add_product(-1, pair.edge.form(static_cast<int>(k)), lifted[3]);
            sum += square(difference.range() / scale);
        }
        return sqrt(sum).upper();
    }

    /// The same with the patch as it is around the trim, about a point there: weights and places that are
    /// many times as large elsewhere leave no rounding here. `near`: the point in space.
    double gap_near(const Pair& pair, const Vec3& near) const {
        Vec2 least = Vec2::Constant(HUGE_VAL), most = -least;
        for (const auto& p : pair.trim.points)
            for (const int k : {0, 1}) {
                const double x = lo_[k] + p[static_cast<std::size_t>(k)].mid() / p[2].mid();
                least[k] = std::min(least[k], x);
                most[k] = std::max(most[k], x);
            }
        // With a margin; and a trim along one of the parameters is wide only across it.
        constexpr double margin = 0x1p-6;
        const Vec2 wide = Vec2::Constant(margin * (most - least).maxCoeff());
        TrimJudge around = *this;
        around.lo_ = (least - wide).cwiseMax(lo_);
        around.hi_ = (most + wide).cwiseMin(hi_);
        if (!(around.lo_.array() < around.hi_.array()).all()) return HUGE_VAL;
        const Net net = net_over(surface_, around.lo_, around.hi_, near);
        around.net_ = &net;
        const auto moved = [](auto points, const auto& from, const auto& to) {
            for (auto& p : points)
                for (std::size_t k = 0; k + 1 < p.size(); ++k)
                    p[k] = p[k] +
                           (MidRad(from[static_cast<Eigen::Index>(k)]) - to[static_cast<Eigen::Index>(k)]) *
                               p.back();
            return points;
        };
        Pair there = pair;
        there.trim.points = moved(pair.trim.points, lo_, around.lo_);
        there.edge.points = moved(pair.edge.points, net_->origin(), near);
        return around.gap(there);
    }

private:
    /// From places beside the net's corner to shares of its width. A needle may be no wider than that its
    /// trimming curves have one coordinate, the corner's: then all shares are 0 in any scale.
    MidRad scale_to_shares(int axis) const {
        if (lo_[axis] == hi_[axis]) return 1.0;
        return MidRad(1.0) / (MidRad(hi_[axis]) - lo_[axis]);
    }

    /// With s = a / w the place between the patch's sides along a trimming curve and b = w - a: all
    /// a^i b^(degree - i), as coefficients times binomials.
    struct Powers {
        Powers(const BezierPiece<2>& trim, int coordinate, const MidRad& scale, int power)
            : degree(trim.degree() * power), count(power + 1) {
            const int d = trim.degree();
            SmallVector<double, 8> a, b;
            double error = 0;
            for (int k = 0; k <= d; ++k) {
                const MidRad x = scale * trim.points[k][coordinate], y = trim.points[k][2] - x;
                a.push_back(binomial(d, k) * x.mid());
                b.push_back(binomial(d, k) * y.mid());
                size = std::max(size, std::abs(x.mid()) + std::abs(y.mid()));
                error = std::max(error, x.radius() + y.radius());
            }
            const auto times = [](std::span<const double> x, std::span<const double> y,
                                  std::span<double> product) {
                std::ranges::fill(product, 0.0);
                for (std::size_t i = 0; i < x.size(); ++i)
                    for (std::size_t j = 0; j < y.size(); ++j) product[i + j] += x[i] * y[j];
            };
            // Row i: a^i so far, then times b^(power - i).
            coefficients.assign(static_cast<std::size_t>(count * (degree + 1)), 0.0);
            SmallVector<double, 16> left, next;
            left.assign(1, 1.0);
            for (int i = 0; i <= power; ++i) {
                SmallVector<double, 16> row = left;
                for (int k = i; k < power; ++k) {
                    next.resize(row.size() + b.size() - 1);
                    times(row, b, next);
                    row = next;
                }
                std::ranges::copy(row, coefficients.begin() + i * (degree + 1));
                if (i == power) break;
                next.resize(left.size() + a.size() - 1);
                times(left, a, next);
                left = next;
            }
            relative_error = power * (error / size) + rounding(power * (degree + 1 + (d > 56 ? 512 : 1)));
            for (int k = 0; k < power; ++k) whole *= size;
        }
        int degree, count;
        double size = 0;   ///< of |a| + |b|, in Bernstein coefficients
        double whole = 1;  ///< of (|a| + |b|)^power
        /// All rows together, times binomials, are off by no more than that times `whole`.
        double relative_error;
        SmallVector<double, 32> coefficients;
    };

    /// Relative: of n operations, one after the other.
    static double rounding(int n) { return n * 0x1p-53; }

    /// Of powers: how many, less one, and of which degree; known to the compiler where they are the usual
    /// ones.
    struct Degrees {
        int power, degree;
    };
    template <int Power, int Degree>
    struct Fixed {
        static constexpr int power = Power, degree = Degree;
    };
    /// Adds all factor_ij u_i v_j.
    template <class U, class V>
    static void add_products(U of_u, V of_v, const Powers& u, const Powers& v, const double* factors,
                             double* sum) {
        std::array<double, kMaxBinomial + 1> inner;
        for (int i = 0; i <= of_u.power; ++i) {
            for (int l = 0; l <= of_v.degree; ++l) inner[static_cast<std::size_t>(l)] = 0;
            for (int j = 0; j <= of_v.power; ++j) {
                const double* const row = &v.coefficients[static_cast<std::size_t>(j * (of_v.degree + 1))];
                const double factor = factors[i * (of_v.power + 1) + j];
                for (int l = 0; l <= of_v.degree; ++l) inner[static_cast<std::size_t>(l)] += factor * row[l];
            }
            const double* const row = &u.coefficients[static_cast<std::size_t>(i * (of_u.degree + 1))];
            for (int a = 0; a <= of_u.degree; ++a)
                for (int b = 0; b <= of_v.degree; ++b)
                    sum[a + b] += row[a] * inner[static_cast<std::size_t>(b)];
        }
    }

    /// The patch's homogeneous coordinates along a trimming curve.
    ///
    /// Of N_ij u_i v_j, each times its binomials, the magnitudes add up to less than those of N times the
    /// products of (|a| + |b|)^m for either variable, all in the Bernstein basis. What each term goes through
    /// is off by so many roundings: relative to that sum they all count once [Higham02, sec. 3.1].
    std::array<Form, 4> lift(const Powers& u, const Powers& v) const {
        const int m = u.count - 1, n = v.count - 1;
        const std::size_t length = static_cast<std::size_t>(u.degree + v.degree + 1);
        std::array<Form, 4> lifted;
        SmallVector<double, 16> sum;
        SmallVector<double, 9> factors;
        const int operations =
            3 + (n + 2) + (std::min(u.degree, v.degree) + 2) + (m + 1) + (std::max(m, n) > 56 ? 1024 : 0);
        for (std::size_t k = 0; k < 4; ++k) {
            double size = 0, error = 0;
            factors.clear();
            for (int i = 0; i <= m; ++i)
                for (int j = 0; j <= n; ++j) {
                    const MidRad& c = net_->at(i, j)[k];
                    factors.push_back(binomial(m, i) * binomial(n, j) * c.mid());
                    size = std::max(size, std::abs(c.mid()));
                    error = std::max(error, c.radius());
                }
            sum.assign(length, 0.0);
            if (m == 2 && n == 2 && u.degree == 4 && v.degree == 4)
                add_products(Fixed<2, 4>{}, Fixed<2, 4>{}, u, v, factors.data(), sum.data());
            else
                add_products(Degrees{m, u.degree}, Degrees{n, v.degree}, u, v, factors.data(), sum.data());
            const double relative = u.relative_error + v.relative_error + rounding(operations);
            // A hundredth more than first order: relative errors are below that, or say nothing.
            lifted[k] = Form(
                sum, relative < 0x1p-10 ? 1.01 * (size * relative + error) * u.whole * v.whole : HUGE_VAL);
        }
        return lifted;
    }

    const RationalPatch& surface_;
    Vec2 lo_, hi_;  // of the net
    const TrimCurve& trim_;
    const RationalCurve3& edge_;
    const Net* net_;
};

}  // namespace

double certify_trim(const Patch& patch, const Net& net, const TrimPlace& place, const Subject& subject,
                    const CheckOptions& options, Certificate& certificate, double negligible) {
    const Trim& trim = patch.loops[place.loop][place.curve];
    const auto where = [&] {
        return fmt::format("{}[{}]", loop_path(patch.face, patch.index, place.loop), place.curve);
    };
    const std::size_t e = *trim.curve->edge;
    const double error = 2 * subject.full_error(e);
    const TrimJudge judge(patch, net, trim, subject);
    std::vector<Pair> pairs;
    std::optional<Pair> next = judge.only_pair();
    if (!next) pairs = judge.pairs();
    const auto points = [&](double t) {
        const Vec2 uv = evaluate(trim.pieces, t);
        const Vec3 p =
            evaluate(subject.edge_pieces[e], edge_parameter(*trim.curve, subject.cell.edges[e].curve, t));
        const SurfacePoint s = lift(patch, uv);
        return std::pair((s.p - p).norm(), surface_rounding(patch, s, uv));
    };
    // Where as many are not enough it is rounding that counts.
    constexpr std::size_t kFewHalves = 4;
    double most = 0;
    std::size_t count = 0;
    for (; next || !pairs.empty(); next.reset()) {
        if (!next) {
            next.emplace(std::move(pairs.back()));
            pairs.pop_back();
        }
        const Pair& pair = *next;
        double gap = judge.gap_at_places(pair, false);
        if (gap > std::max(most, negligible)) gap = std::min(gap, judge.gap_at_places(pair, true));
        if (!(gap <= error + kRounding * patch.control_size)) gap = judge.gap(pair);
        if (count >= kFewHalves && !(gap <= error + kRounding * patch.control_size)) {
            const Vec2 uv = evaluate(trim.pieces, std::midpoint(pair.trim.begin, pair.trim.end));
            gap = std::min(gap, judge.gap_near(pair, lift(patch, uv).p));
        }
        // What rounding of (u, v) makes on the surface is looked at where it may matter.
        if (gap <= error + kRounding * patch.control_size ||
            gap <= error + points(std::midpoint(pair.trim.begin, pair.trim.end)).second) {
            most = std::max(most, gap);
            continue;
        }
        for (const double t : {pair.trim.begin, std::midpoint(pair.trim.begin, pair.trim.end), pair.trim.end})
            if (const auto [distance, width] = points(t); distance > error + 2 * width) {
                certificate.refute(
                    where(),
                    fmt::format("lifts to a curve {:.3g} away from edge {} at the same parameter", distance,
                                e),
                    distance);
                return HUGE_VAL;
            }
        if (++count > std::size_t{1} << std::clamp(options.effort, 0, 40)) {
            certificate.leave_open(where(), fmt::format("lifts to a curve within {:.3g} of edge {}", gap, e),
                                   gap);
            return HUGE_VAL;
        }
        auto trims = halves(pair.trim);
        auto edges = halves(pair.edge);
        for (const int k : {0, 1}) pairs.push_back({std::move(trims[k]), std::move(edges[k])});
    }
    return most;
}

}  // namespace vcell::check
