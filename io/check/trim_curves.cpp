#include "trim_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "../trims.hpp"
#include "nets.hpp"

namespace vcell::check {
namespace {

/// A span of a trimming curve and the part of the edge that it follows, in its direction.
struct Pair {
    Span<2> trim;
    Span<3> edge;
};

template <int Dim>
const Span<Dim>& span_at(const std::vector<Span<Dim>>& spans, double t) {
    const auto it = std::ranges::find_if(spans, [t](const Span<Dim>& s) { return t <= s.end; });
    return it == spans.end() ? spans.back() : *it;
}

template <int Dim>
std::array<Span<Dim>, 2> halves(const Span<Dim>& span) {
    std::array<Span<Dim>, 2> h{span, span};
    h[0].end = h[1].begin = std::midpoint(span.begin, span.end);
    const int d = span.degree();
    for (int k = 0; k <= d; ++k) {
        h[0].points[k] = h[1].points[0];
        for (int i = 0; i < d - k; ++i)
            for (std::size_t c = 0; c <= Dim; ++c)
                h[1].points[i][c] = 0.5 * (h[1].points[i][c] + h[1].points[i + 1][c]);
    }
    return h;
}

class TrimJudge {
public:
    TrimJudge(const Patch& patch, const Trim& trim, const Subject& subject)
        : patch_(patch),
          trim_(*trim.curve),
          edge_(subject.cell.edges[*trim.curve->edge].curve),
          origin_(edge_.points.front().head<3>()),
          net_(net_over(*patch.surface, patch.lo, patch.hi, origin_)) {}

    /// Spans between the knots of both curves, which may differ by rounding.
    std::vector<Pair> pairs() const {
        const auto trims = spans<2>(trim_.curve, Vec2(Vec2::Zero()));
        const auto edges = spans<3>(edge_, origin_);
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
            const bool is_there = std::ranges::any_of(cuts, [&](double c) { return std::abs(c - t) <= near; });
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

    /// Bounds |S(c(t)) - C(t)|: S's homogeneous coordinates along c are polynomials in t, and so are those of
    /// the difference.
    double gap(const Pair& pair) const {
        const Form w = pair.trim.form(2);
        // s (1 - s) becomes a b / w^2 with a and b homogeneous of the trim's degree.
        const auto powers = [&](int coordinate, int degree) {
            const Form x = pair.trim.form(coordinate);
            const double lo = patch_.lo[coordinate], hi = patch_.hi[coordinate];
            const Interval scale = Interval(1.0) / (Interval(hi) - lo);
            const Form a = scale * (x - Interval(lo) * w), b = scale * (Interval(hi) * w - x);
            std::vector<Form> of_a{one()}, of_b{one()}, result;
            for (int k = 0; k < degree; ++k) {
                of_a.push_back(of_a.back() * a);
                of_b.push_back(of_b.back() * b);
            }
            for (int k = 0; k <= degree; ++k) result.push_back(of_a[k] * of_b[degree - k]);
            return result;
        };
        const int m = net_.degree_s(), n = net_.degree_t();
        const std::vector<Form> u = powers(0, m), v = powers(1, n);
        std::array<Form, 4> lifted;
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j) {
                const Form weight = (Interval(binomial(m, i)) * Interval(binomial(n, j))) * (u[i] * v[j]);
                for (std::size_t k = 0; k < 4; ++k) {
                    const Form part = net_.at(i, j)[k] * weight;
                    lifted[k] = i + j == 0 ? part : lifted[k] + part;
                }
            }
        const Form edge_weight = pair.edge.form(3);
        const Interval scale = lifted[3].range() * edge_weight.range();
        Interval sum(0.0);
        for (int k = 0; k < 3; ++k)
            sum += square((lifted[k] * edge_weight - pair.edge.form(k) * lifted[3]).range() / scale);
        return sqrt(sum).upper();
    }

private:
    static Form one() {
        Form f(0, 0);
        f.at(0, 0) = 1.0;
        return f;
    }

    const Patch& patch_;
    const TrimCurve& trim_;
    const RationalCurve3& edge_;
    Vec3 origin_;
    Net net_;
};

}  // namespace

double certify_trim(const Patch& patch, const TrimPlace& place, const Subject& subject,
                    const CheckOptions& options, Certificate& certificate) {
    const Trim& trim = patch.loops[place.loop][place.curve];
    const auto where = [&] {
        return fmt::format("{}[{}]", loop_path(patch.face, patch.index, place.loop), place.curve);
    };
    const std::size_t e = *trim.curve->edge;
    const double error = 2 * subject.full_error(e);
    const TrimJudge judge(patch, trim, subject);
    std::vector<Pair> pairs = judge.pairs();
    const auto points = [&](double t) {
        const Vec2 uv = evaluate(trim.pieces, t);
        const Vec3 p = evaluate(subject.edge_pieces[e],
                                edge_parameter(*trim.curve, subject.cell.edges[e].curve, t));
        const SurfacePoint s = lift(patch, uv);
        return std::pair((s.p - p).norm(), surface_rounding(patch, s, uv));
    };
    double most = 0;
    std::size_t count = 0;
    while (!pairs.empty()) {
        const Pair pair = std::move(pairs.back());
        pairs.pop_back();
        const double gap = judge.gap(pair);
        // What rounding of (u, v) makes on the surface is looked at where it may matter.
        if (gap <= error + kRounding * patch.control_size ||
            gap <= error + points(std::midpoint(pair.trim.begin, pair.trim.end)).second) {
            most = std::max(most, gap);
            continue;
        }
        for (const double t : {pair.trim.begin, std::midpoint(pair.trim.begin, pair.trim.end), pair.trim.end})
            if (const auto [distance, width] = points(t); distance > error + 2 * width) {
                certificate.refute(where(),
                                   fmt::format("lifts to a curve {:.3g} away from edge {} at the same parameter",
                                               distance, e),
                                   distance);
                return HUGE_VAL;
            }
        if (++count > std::size_t{1} << std::clamp(options.effort, 0, 40)) {
            certificate.leave_open(where(), fmt::format("lifts to a curve within {:.3g} of edge {}", gap, e), gap);
            return HUGE_VAL;
        }
        auto trims = halves(pair.trim);
        auto edges = halves(pair.edge);
        for (const int k : {0, 1}) pairs.push_back({std::move(trims[k]), std::move(edges[k])});
    }
    return most;
}

}  // namespace vcell::check
