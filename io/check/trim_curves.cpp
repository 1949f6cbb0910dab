#include "trim_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "../pictures/trims.hpp"
#include "trim_pair.hpp"

namespace vcell::check {
namespace {

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

class TrimJudge {
public:
    TrimJudge(const Patch& patch, const Net& net, const Trim& trim, const Subject& subject)
        : surface_(*patch.surface),
          over_{&net, patch.lo, patch.hi},
          trim_(*trim.curve),
          edge_(subject.cell.edges[*trim.curve->edge].curve) {}

    const NetOver& over() const { return over_; }

    /// Where neither curve has knots: the most frequent case.
    std::optional<TrimPair> only_pair() const {
        const double near = kPlaceRounding * (edge_.domain_end() - edge_.domain_begin());
        if (!(std::abs(trim_.curve.domain_begin() - edge_.domain_begin()) <= near) ||
            !(std::abs(trim_.curve.domain_end() - edge_.domain_end()) <= near))
            return std::nullopt;
        auto trim = only_span<2>(trim_.curve, over_.lo);
        auto edge = trim ? only_span<3>(edge_, over_.net->origin()) : std::nullopt;
        if (!edge) return std::nullopt;
        if (trim_.reversed) std::ranges::reverse(edge->points);
        return TrimPair{std::move(*trim), std::move(*edge)};
    }
    /// Spans between the knots of both curves, which may differ by rounding.
    std::vector<TrimPair> pairs() const {
        auto trims = spans<2>(trim_.curve, over_.lo);
        auto edges = spans<3>(edge_, over_.net->origin());
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
        std::vector<TrimPair> result;
        for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
            const double a = cuts[k], b = cuts[k + 1], x = to_edge(a), y = to_edge(b);
            const auto& trim = span_at(trims, std::midpoint(a, b));
            const auto& edge = span_at(edges, std::midpoint(x, y));
            TrimPair pair{part_of(trim, a, b), part_of(edge, std::min(x, y), std::max(x, y))};
            if (trim_.reversed) std::ranges::reverse(pair.edge.points);
            result.push_back(std::move(pair));
        }
        return result;
    }

    /// Bounds |S(c(t)) - C(t)|: S's homogeneous coordinates along c are polynomials in t, and so are those of
    /// the difference.
    double gap(const TrimPair& pair) const {
        const int m = over_.net->degree_s(), n = over_.net->degree_t(), d = pair.trim.degree();
        if ((m + n) * d + pair.edge.degree() > kMaxBinomial) return HUGE_VAL;
        const std::array<Form, 4> lifted = lift(Powers(pair.trim, 0, over_.scale_to_shares(0), m),
                                                Powers(pair.trim, 1, over_.scale_to_shares(1), n));
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
    double gap_near(const TrimPair& pair, const Vec3& near) const {
        Vec2 least = Vec2::Constant(HUGE_VAL), most = -least;
        for (const auto& p : pair.trim.points)
            for (const int k : {0, 1}) {
                const double x = over_.lo[k] + p[static_cast<std::size_t>(k)].mid() / p[2].mid();
                least[k] = std::min(least[k], x);
                most[k] = std::max(most[k], x);
            }
        // With a margin; and a trim along one of the parameters is wide only across it.
        constexpr double margin = 0x1p-6;
        const Vec2 wide = Vec2::Constant(margin * (most - least).maxCoeff());
        TrimJudge around = *this;
        around.over_.lo = (least - wide).cwiseMax(over_.lo);
        around.over_.hi = (most + wide).cwiseMin(over_.hi);
        if (!(around.over_.lo.array() < around.over_.hi.array()).all()) return HUGE_VAL;
        const Net net = net_over(surface_, around.over_.lo, around.over_.hi, near);
        around.over_.net = &net;
        const auto moved = [](auto points, const auto& from, const auto& to) {
            for (auto& p : points)
                for (std::size_t k = 0; k + 1 < p.size(); ++k)
                    p[k] = p[k] +
                           (MidRad(from[static_cast<Eigen::Index>(k)]) - to[static_cast<Eigen::Index>(k)]) *
                               p.back();
            return points;
        };
        TrimPair there = pair;
        there.trim.points = moved(pair.trim.points, over_.lo, around.over_.lo);
        there.edge.points = moved(pair.edge.points, over_.net->origin(), near);
        return around.gap(there);
    }

private:
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
            relative_error = power * (error / size) + rounding_of(power * (degree + 1 + (d > 56 ? 512 : 1)));
            for (int k = 0; k < power; ++k) whole *= size;
        }
        int degree, count;
        double size = 0;   ///< of |a| + |b|, in Bernstein coefficients
        double whole = 1;  ///< of (|a| + |b|)^power
        /// All rows together, times binomials, are off by no more than that times `whole`.
        double relative_error;
        SmallVector<double, 32> coefficients;
    };

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
                    const MidRad& c = over_.net->at(i, j)[k];
                    factors.push_back(binomial(m, i) * binomial(n, j) * c.mid());
                    size = std::max(size, std::abs(c.mid()));
                    error = std::max(error, c.radius());
                }
            sum.assign(length, 0.0);
            if (m == 2 && n == 2 && u.degree == 4 && v.degree == 4)
                add_products(Fixed<2, 4>{}, Fixed<2, 4>{}, u, v, factors.data(), sum.data());
            else
                add_products(Degrees{m, u.degree}, Degrees{n, v.degree}, u, v, factors.data(), sum.data());
            const double relative = u.relative_error + v.relative_error + rounding_of(operations);
            // A hundredth more than first order: relative errors are below that, or say nothing.
            lifted[k] = Form(
                sum, relative < 0x1p-10 ? 1.01 * (size * relative + error) * u.whole * v.whole : HUGE_VAL);
        }
        return lifted;
    }

    const RationalPatch& surface_;
    NetOver over_;
    const TrimCurve& trim_;
    const RationalCurve3& edge_;
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
    std::vector<TrimPair> pairs;
    std::optional<TrimPair> next = judge.only_pair();
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
        const TrimPair& pair = *next;
        double gap = gap_at_places(judge.over(), pair, false);
        if (gap > std::max(most, negligible)) gap = std::min(gap, gap_at_places(judge.over(), pair, true));
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
