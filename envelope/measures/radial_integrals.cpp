#include "radial_integrals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "../lift/joined_spans.hpp"
#include "../lift/radial_patch.hpp"
#include "radial_terms.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;
using span_integrals::integrate_estimated;
using span_integrals::PowerSpan;
using span_integrals::SpanPoint;
using span_integrals::term_rounding;
using namespace radial_integrals;
using std::sqrt;

Ray ray_to(const SpanPoint<double>& p, Chart chart) {
    const double y = chart.across(p.y), y1 = chart.across(p.y1);
    const double reciprocal = 1.0 / sqrt(p.x * p.x + y * y + p.z * p.z);
    const Vector d{p.x1, y1, p.z1};
    Ray ray{{p.x * reciprocal, y * reciprocal, p.z * reciprocal}, {}, chart.along(p.y), norm(d) * reciprocal};
    const double along = dot(ray.u, d);
    for (int i = 0; i < 3; ++i) ray.du[i] = (d[i] - ray.u[i] * along) * reciprocal;
    return ray;
}

}  // namespace

RadialIntegrals& RadialIntegrals::operator+=(const RadialIntegrals& o) {
    for (int i : {0, 1}) {
        sides[i].volume += o.sides[i].volume;
        sides[i].area += o.sides[i].area;
    }
    length += o.length;
    end_area += o.end_area;
    distance = {std::min(distance[0], o.distance[0]), std::max(distance[1], o.distance[1])};
    gap = {std::max(gap.from_curve, o.gap.from_curve), std::max(gap.apart, o.gap.apart)};
    return *this;
}

namespace {

// t^2 / 2 at a point of a span, and its derivative.
std::array<double, 2> half_square(const SpanPoint<double>& p, Chart chart) {
    const double y = chart.across(p.y);
    return {0.5 * (p.x * p.x + y * y + p.z * p.z), p.x * p.x1 + y * p.y1 + p.z * p.z1};
}

// At most as many extremes as that has t along a span, inside: t^2 = p.p / w^2, of which the derivative is a
// positive factor times p.(p' w - p w'). In the Bernstein basis a polynomial has no more zeros in [0, 1] than
// its coefficients have changes of sign [Farin02, sec. 5.3, Descartes].
int most_extremes(const PowerSpan& span, Chart chart) {
    constexpr int most = PowerSpan::largest_degree;
    const int d = span.degree();
    const auto points = span.control_points();
    // Times binomials, so that products are convolutions.
    std::array<Vector4d, most + 1> p;
    std::array<Vector4d, most> slope;
    double binomial = 1;
    for (int k = 0; k <= d; ++k) {
        p[k] = binomial * points[k];
        p[k].y() = chart.across(p[k].y());
        binomial *= static_cast<double>(d - k) / (k + 1);
    }
    for (int k = 0; k < d; ++k) slope[k] = (k + 1) * p[k + 1] - (d - k) * p[k];
    std::array<Vec3, 2 * most> turn;
    turn.fill(Vec3::Zero());
    for (int i = 0; i <= d; ++i)
        for (int k = 0; k < d; ++k)
            turn[i + k] += p[i].w() * slope[k].head<3>() - slope[k].w() * p[i].head<3>();
    std::array<double, 3 * most> sum{};
    double size = 0, steepest = 0;
    for (int i = 0; i <= d; ++i) {
        size = std::max(size, p[i].squaredNorm());
        for (int k = 0; k < 2 * d; ++k) sum[i + k] += p[i].head<3>().dot(turn[k]);
    }
    for (int k = 0; k < d; ++k) steepest = std::max(steepest, slope[k].norm());
    // Coefficients below that are what rounding leaves, by which t hardly turns.
    const double rounding = 16 * std::numeric_limits<double>::epsilon() * size * steepest;
    int changes = 0;
    double last = 0;
    for (int k = 0; k < 3 * d; ++k) {
        if (std::abs(sum[k]) <= rounding) continue;
        changes += sum[k] * last < 0;
        last = sum[k];
    }
    return changes;
}

// The range of t along a span that has one extreme inside at most.
void extend_by_extreme(Range& range, const PowerSpan& span, Chart chart) {
    const auto at = [&](double s) { return half_square(span.at(s), chart); };
    const auto extend_by = [&](double square) {
        range = {std::min(range[0], sqrt(2 * square)), std::max(range[1], sqrt(2 * square))};
    };
    double low = -1, high = 1;
    std::array<double, 2> first = at(low), last = at(high);
    extend_by(first[0]);
    extend_by(last[0]);
    if ((first[1] > 0) == (last[1] > 0)) return;
    // Regula falsi, the end that stays weighted down ("Illinois"). Near an extreme half of the digits of s
    // are enough.
    constexpr int most_steps = 30;
    constexpr double enough = 0x1p-30;
    int moved_end = 0;  // the last one: -1 low, 1 high
    for (int i = 0; i < most_steps; ++i) {
        const double s = high - last[1] * (high - low) / (last[1] - first[1]);
        const std::array<double, 2> next = at(s);
        const bool is_first = (next[1] > 0) == (first[1] > 0);
        const double moved = is_first ? s - low : high - s;
        if (is_first) {
            low = s;
            first = next;
            if (moved_end == -1) last[1] *= 0.5;
            moved_end = -1;
        } else {
            high = s;
            last = next;
            if (moved_end == 1) first[1] *= 0.5;
            moved_end = 1;
        }
        if (next[1] == 0 || std::min(moved, high - low) <= enough) break;
    }
    extend_by(first[0]);
    extend_by(last[0]);
}

// The range of t along a span.
void extend_by_extremes(Range& range, const PowerSpan& span, Chart chart, int halvings = 12) {
    if (halvings == 0 || most_extremes(span, chart) <= 1) return extend_by_extreme(range, span, chart);
    for (const int side : {0, 1}) extend_by_extremes(range, span.half(side), chart, halvings - 1);
}

// What a face takes of a point of its boundary.
template <class Face>
const Ray& place_for(const Face&, const SpanPoint<double>&, const Ray& ray) {
    return ray;
}
const SpanPoint<double>& place_for(const radial_integrals::FlatFace&, const SpanPoint<double>& p,
                                   const Ray&) {
    return p;
}

radial_integrals::GraphFace::Place place_for(const radial_integrals::GraphFace&, const SpanPoint<double>& p,
                                             const Ray& ray) {
    return {p, ray};
}

// How far a point of the boundary is from the face's surface, along its ray if that tells anything.
template <class Face>
double gap_to(const Face& f, const SpanPoint<double>&, const Ray& ray, double t) {
    return f.distance(ray) - t;
}
double gap_to(const radial_integrals::FlatFace& f, const SpanPoint<double>& p, const Ray&, double) {
    return f.offset - f.normal.dot(Vec3(p.x, p.y, p.z));
}

double gap_to(const radial_integrals::GraphFace& f, const SpanPoint<double>& p, const Ray& ray, double t) {
    return f.gap(p, ray, t);
}

// Where splines err most (space_spline.cpp): between the nodes of their interpolation.
void extend_by_gaps(RadialGap& most, const PowerSpan& span, Chart chart, const RadialFace& left,
                    const RadialFace* right) {
    for (const double s : {-0.5, 0.0, 0.5}) {
        const SpanPoint<double> p = span.at(s);
        const Ray ray = ray_to(p, chart);
        const double t = sqrt(2 * half_square(p, chart)[0]);
        const auto off = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return gap_to(f, p, ray, t); }, face);
        };
        const double l = off(left), r = right != nullptr ? off(*right) : 0;
        most.from_curve = std::max({most.from_curve, std::abs(l), std::abs(r)});
        most.apart = std::max(most.apart, std::abs(l - r));
    }
}

// Parts of the size. A spline is off its arc by more than the integrals of its spans could be.
double estimated_part(bool is_conic) { return is_conic ? 1e-17 : 1e-12; }

// The geodesics from a direction to all points of a curve sweep from.(u x du) / (1 + from.u).
struct SweptAngle {
    Chart chart;
    Vec3 from;

    std::array<double, 1> operator()(const SpanPoint<double>& p, std::array<double, 1>* sizes) const {
        const Ray ray = ray_to(p, chart);
        const double room = 1 + dot(from, ray.u);
        if (sizes != nullptr) *sizes = {ray.rate / room * (1 + 1 / room)};
        return {dot(from, cross(ray.u, ray.du)) / room};
    }
};

struct SpanIntegrand {
    Chart chart;
    const RadialFace& left;
    const RadialFace* right;

    std::array<double, 6> operator()(const SpanPoint<double>& p, std::array<double, 6>* sizes) const {
        const Ray ray = ray_to(p, chart);
        const auto share = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return f.share(place_for(f, p, ray)); }, face);
        };
        const Share l = share(left), r = right != nullptr ? share(*right) : Share{0, 0};
        const double speed = sqrt(p.x1 * p.x1 + p.y1 * p.y1 + p.z1 * p.z1);
        const double end = right == nullptr ? 0.5 * (p.x * p.x + p.z * p.z) : 0;
        if (sizes != nullptr) {
            set_sizes(p, ray, speed, end * ray.rate, *sizes);
            // Errors are sizes times the rounding of a term: what shares are off by counts in full.
            const std::array<double, 4> rests{l.volume_rest, l.area_rest, r.volume_rest, r.area_rest};
            for (int k = 0; k < 4; ++k) (*sizes)[k] += rests[k] / term_rounding;
        }
        return {l.volume, l.area, r.volume, r.area, speed, end * turn(ray)};
    }

    bool is_rough(const PowerSpan& span) const {
        const auto passes_tip = [&](const RadialFace& face) {
            const auto* skew = std::get_if<SkewFace>(&face);
            return skew != nullptr && skew->may_pass_tip(span);
        };
        return passes_tip(left) || (right != nullptr && passes_tip(*right));
    }

private:
    void set_sizes(const SpanPoint<double>& p, const Ray& ray, double speed, double end,
                   std::array<double, 6>& sizes) const {
        const auto size = [&](const RadialFace& face) {
            return std::visit([&](const auto& f) { return f.size(place_for(f, p, ray)); }, face);
        };
        const Share l = size(left), r = right != nullptr ? size(*right) : Share{0, 0};
        sizes = {l.volume, l.area, r.volume, r.area, speed, end};
    }
};

}  // namespace

Integral angle_above_chord(std::span<const Vector4d> points, bool is_conic, Chart chart) {
    std::array<Integral, 1> angle{};
    integrate_estimated(PowerSpan(points), SweptAngle{chart, points.front().head<3>().normalized()},
                        estimated_part(is_conic), angle);
    return angle[0];
}

void add_span(std::span<const Vector4d> points, bool is_conic, Chart chart, const RadialFace& left,
              const RadialFace* right, RadialIntegrals& sum) {
    const PowerSpan span(points);
    std::array<Integral, 6> parts{};
    integrate_estimated(span, SpanIntegrand{chart, left, right}, estimated_part(is_conic), parts);
    sum.sides[0].volume += parts[0];
    sum.sides[0].area += parts[1];
    sum.sides[1].volume += parts[2];
    sum.sides[1].area += parts[3];
    if (points.size() == 2) {
        const double length = (points[1] - points[0]).head<3>().norm();
        parts[4] = {length, term_rounding * length};
    } else if (is_conic) {
        parts[4] = span_integrals::length(span);
    }
    sum.length += parts[4];
    sum.end_area += parts[5];
    extend_by_extremes(sum.distance, span, chart);
    extend_by_gaps(sum.gap, span, chart, left, right);
}

}  // namespace vcell
