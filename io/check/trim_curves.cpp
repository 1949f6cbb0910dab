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
    TrimJudge(const Patch& patch, const Net& net, const Trim& trim, const Subject& subject)
        : patch_(patch), trim_(*trim.curve), edge_(subject.cell.edges[*trim.curve->edge].curve), net_(net) {}

    /// Spans between the knots of both curves, which may differ by rounding.
    std::vector<Pair> pairs() const {
        const auto trims = spans<2>(trim_.curve, Vec2(Vec2::Zero()));
        const auto edges = spans<3>(edge_, net_.origin());
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

    /// Bounds |S(c(t)) - C(t)|: S's homogeneous coordinates along c are polynomials in t, and so are those of
    /// the difference. Doubles with their magnitudes tell first, if the degrees are small.
    double gap(const Pair& pair, double enough) const {
        if (net_.degree_s() + net_.degree_t() <= 4 && pair.trim.degree() <= 2 && pair.edge.degree() <= 2)
            if (const double rough = gap_in<Rounded>(pair); rough <= enough) return rough;
        return gap_in<Interval>(pair);
    }

private:
    /// A number that is off by at most n 2^-53 size after n operations, one after the other, which are no
    /// more than kOperations here: with four degrees of the patch and two of the curves, 3 for (u, v), 6 for
    /// each of four factors of degree 2 and 5 for each of their sums of products, 9 sums over control points,
    /// 6 for the edge's weight; and as much as 16 for what a control point has gone through.
    struct Rounded {
        static constexpr double kOperations = 128;
        double value = 0, size = 0;

        Rounded() = default;
        explicit Rounded(double v) : value(v), size(std::abs(v)) {}
        explicit Rounded(const Interval& i)
            : value(i.mid()), size(std::max(std::abs(value), 0x1p49 * i.radius())) {}
        friend Rounded operator+(const Rounded& a, const Rounded& b) {
            return of(a.value + b.value, a.size + b.size);
        }
        friend Rounded operator-(const Rounded& a, const Rounded& b) {
            return of(a.value - b.value, a.size + b.size);
        }
        friend Rounded operator*(const Rounded& a, const Rounded& b) {
            return of(a.value * b.value, a.size * b.size);
        }
        static Rounded of(double value, double size) {
            Rounded r;
            r.value = value;
            r.size = size;
            return r;
        }
        Interval enclosure() const {
            return Interval::ball(value, (1 + 0x1p-40) * kOperations * 0x1p-53 * size + 0x1p-1000);
        }
    };
    static Interval enclosure(const Rounded& x) { return x.enclosure(); }
    static Interval enclosure(const Interval& x) { return x; }

    /// A polynomial in t, coefficients times binomials.
    template <class T>
    struct Line {
        SmallVector<T, 12> c;

        Line() = default;
        explicit Line(int degree) { c.assign(static_cast<std::size_t>(degree + 1), T(0.0)); }
        explicit Line(const Form& form) : Line(form.degree_s()) {
            for (int i = 0; i <= degree(); ++i) c[i] = T(form.at(i, 0));
        }
        int degree() const { return static_cast<int>(c.size()) - 1; }

        friend Line operator*(const T& s, const Line& a) {
            Line r = a;
            for (T& x : r.c) x = s * x;
            return r;
        }
        friend Line operator*(const Line& a, const Line& b) {
            Line r(a.degree() + b.degree());
            for (int i = 0; i <= a.degree(); ++i)
                for (int j = 0; j <= b.degree(); ++j) r.c[i + j] = r.c[i + j] + a.c[i] * b.c[j];
            return r;
        }
        friend Line operator-(const Line& a, const Line& b) {
            Line r = a;
            for (int i = 0; i <= a.degree(); ++i) r.c[i] = a.c[i] - b.c[i];
            return r;
        }
        void add(const T& s, const Line& a) {
            for (int i = 0; i <= a.degree(); ++i) c[i] = c[i] + s * a.c[i];
        }
        Interval range() const {
            Interval r = enclosure(c[0]);
            for (int i = 1; i <= degree(); ++i) {
                const double b = binomial(degree(), i);
                // Beyond 2^53 binomials are rounded.
                r = hull(r, enclosure(c[i]) / (b < 0x1p53 ? Interval(b) : Interval::ball(b, 0x1p-44 * b)));
            }
            return r;
        }
    };

    template <class T>
    double gap_in(const Pair& pair) const {
        using Poly = Line<T>;
        const int m = net_.degree_s(), n = net_.degree_t(), d = pair.trim.degree();
        if ((m + n) * d + pair.edge.degree() > kMaxBinomial) return HUGE_VAL;
        const Poly w(pair.trim.form(2));
        // s (1 - s) becomes a b / w^2 with a and b homogeneous of the trim's degree.
        const auto powers = [&](int coordinate, int degree) {
            const Poly x(pair.trim.form(coordinate));
            const double lo = patch_.lo[coordinate], hi = patch_.hi[coordinate];
            const T scale(Interval(1.0) / (Interval(hi) - lo));
            const Poly a = scale * (x - T(lo) * w), b = scale * (T(hi) * w - x);
            Poly one(0);
            one.c[0] = T(1.0);
            std::vector<Poly> of_a{one}, of_b{one};
            for (int k = 0; k < degree; ++k) {
                of_a.push_back(of_a[k] * a);
                of_b.push_back(of_b[k] * b);
            }
            for (int k = 0; k <= degree; ++k) of_a[k] = of_a[k] * of_b[degree - k];
            return of_a;
        };
        const std::vector<Poly> u = powers(0, m), v = powers(1, n);
        std::array<Poly, 4> lifted;
        lifted.fill(Poly((m + n) * d));
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j) {
                const T count(binomial(m, i) * binomial(n, j));
                const Poly weight = u[i] * v[j];
                for (std::size_t k = 0; k < 4; ++k) lifted[k].add(count * T(net_.at(i, j)[k]), weight);
            }
        const Poly edge_weight(pair.edge.form(3));
        const Interval scale = lifted[3].range() * edge_weight.range();
        if (!(scale.lower() > 0)) return HUGE_VAL;
        Interval sum(0.0);
        for (int k = 0; k < 3; ++k)
            sum += square((lifted[k] * edge_weight - Poly(pair.edge.form(k)) * lifted[3]).range() / scale);
        return sqrt(sum).upper();
    }

    const Patch& patch_;
    const TrimCurve& trim_;
    const RationalCurve3& edge_;
    const Net& net_;
};

}  // namespace

double certify_trim(const Patch& patch, const Net& net, const TrimPlace& place, const Subject& subject,
                    const CheckOptions& options, Certificate& certificate) {
    const Trim& trim = patch.loops[place.loop][place.curve];
    const auto where = [&] {
        return fmt::format("{}[{}]", loop_path(patch.face, patch.index, place.loop), place.curve);
    };
    const std::size_t e = *trim.curve->edge;
    const double error = 2 * subject.full_error(e);
    const TrimJudge judge(patch, net, trim, subject);
    std::vector<Pair> pairs = judge.pairs();
    const auto points = [&](double t) {
        const Vec2 uv = evaluate(trim.pieces, t);
        const Vec3 p =
            evaluate(subject.edge_pieces[e], edge_parameter(*trim.curve, subject.cell.edges[e].curve, t));
        const SurfacePoint s = lift(patch, uv);
        return std::pair((s.p - p).norm(), surface_rounding(patch, s, uv));
    };
    double most = 0;
    std::size_t count = 0;
    while (!pairs.empty()) {
        const Pair pair = std::move(pairs.back());
        pairs.pop_back();
        const double gap = judge.gap(pair, error + kRounding * patch.control_size);
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
