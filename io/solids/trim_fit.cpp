#include "trim_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "../../core/curves/quintic_nodes.hpp"
#include "../../core/curves/reversed_curve.hpp"
#include "../pictures/trims.hpp"

namespace vcell {

namespace {

// Moves a curve's domain: knots that were its ends are the new ones.
void over_domain(RationalCurve2& curve, double begin, double end) {
    const double from = curve.domain_begin(), to = curve.domain_end();
    for (double& knot : curve.knots)
        knot = knot == from ? begin : knot == to ? end : begin + (knot - from) / (to - from) * (end - begin);
}

/// Spans of a curve in parameters, joined.
struct QuinticFit {
    static constexpr int degree = 5, deepest = 6;
    RationalCurve2& curve;  // has its first knot once, and no points
    std::function<Vec2(double)> at;
    std::function<bool(double, const Vec2&)> is_near;

    void add(double from, double to, int halvings) {
        const QuinticNodes& nodes = QuinticNodes::get();
        const auto place = [&](double s) { return (1 - s) * from + s * to; };
        Eigen::Matrix<double, 2, degree + 1> values;
        for (int k = 0; k <= degree; ++k) {
            double node = 0;  // as parameters are the Bernstein polynomials' own middles
            for (int i = 0; i <= degree; ++i) node += nodes.values(i, k) * i / degree;
            values.col(k) = at(place(node));
        }
        const Eigen::Matrix<double, 2, degree + 1> controls = values * nodes.coefficients;
        RationalCurve2 span;
        span.degree = degree;
        span.knots.assign(degree + 1, from);
        span.knots.insert(span.knots.end(), degree + 1, to);
        for (int i = 0; i <= degree; ++i) span.points.push_back({controls(0, i), controls(1, i), 1});
        constexpr int steps = 12;
        for (int k = 1; k < steps && halvings > 0; ++k) {
            const double t = place(static_cast<double>(k) / steps);
            if (is_near(t, span.evaluate(t))) continue;
            const double middle = place(0.5);
            add(from, middle, halvings - 1);
            add(middle, to, halvings - 1);
            return;
        }
        curve.knots.insert(curve.knots.end(), degree, from);
        if (!curve.points.empty()) span.points.erase(span.points.begin());
        curve.points.insert(curve.points.end(), span.points.begin(), span.points.end());
    }
};

// The parameters of the patch's point that is nearest to p, near uv.
Vec2 foot(const RationalPatch& surface, const Vec3& p, Vec2 uv) {
    constexpr int most_steps = 12;
    for (int k = 0; k < most_steps; ++k) {
        const Vec3 off = p - surface.evaluate(uv.x(), uv.y());
        const auto [du, dv] = surface.partials(uv.x(), uv.y());
        const double uu = du.squaredNorm(), uw = du.dot(dv), ww = dv.squaredNorm(),
                     determinant = uu * ww - uw * uw;
        if (!(determinant > 0)) break;
        const double u = du.dot(off), w = dv.dot(off);
        const Vec2 step = Vec2(ww * u - uw * w, uu * w - uw * u) / determinant;
        uv += step;
        if (!(step.norm() > 0x1p-50 * uv.norm())) break;
    }
    return uv;
}

}  // namespace

TrimCurve over_range(TrimCurve trim, const RationalCurve3& edge, double from, double to) {
    const double sum = edge.domain_begin() + edge.domain_end();
    trim.reversed = from > to;
    over_domain(trim.curve, trim.reversed ? sum - from : from, trim.reversed ? sum - to : to);
    return trim;
}

TrimCurve fitted_trim(const TrimCurve& near, const RationalPatch& patch, const RationalCurve3& edge,
                      double from, double to, double enough) {
    constexpr int samples = 64;
    std::vector<std::pair<Vec3, Vec2>> known;
    for (int k = 0; k <= samples; ++k) {
        const double s = static_cast<double>(k) / samples;
        const Vec2 uv =
            near.curve.evaluate((1 - s) * near.curve.domain_begin() + s * near.curve.domain_end());
        known.emplace_back(patch.evaluate(uv.x(), uv.y()), uv);
    }
    const auto uv_at = [&](double t) {
        const Vec3 p = edge.evaluate(t);
        const auto start = std::ranges::min_element(
            known, {}, [&](const auto& sample) { return (sample.first - p).squaredNorm(); });
        return foot(patch, p, start->second);
    };
    const double low = std::min(from, to), high = std::max(from, to);
    TrimCurve result = near;
    if (!(low < high)) return over_range(std::move(result), edge, from, to);
    result.curve.degree = QuinticFit::degree;
    result.curve.knots.assign(1, low);
    result.curve.points.clear();
    QuinticFit fit{result.curve, uv_at, [&](double t, const Vec2& uv) {
                       return (patch.evaluate(uv.x(), uv.y()) - edge.evaluate(t)).norm() <= enough;
                   }};
    std::vector<double> ends{low};
    for (const double knot : edge.knots)
        if (knot > ends.back() && knot < high) ends.push_back(knot);
    ends.push_back(high);
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) fit.add(ends[i], ends[i + 1], QuinticFit::deepest);
    result.curve.knots.insert(result.curve.knots.end(), QuinticFit::degree + 1, high);
    if (from > to) result.curve = reversed(std::move(result.curve));
    return over_range(std::move(result), edge, from, to);
}

bool runs_beside(const TrimCurve& trim, const TrimCurve& other) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector3d& p : other.curve.points) box.extend(Vec2(p.head<2>()));
    const Vec2 room = Vec2::Constant(0.0625 * box.diagonal().norm()), low = box.min() - room,
               high = box.max() + room;
    const Eigen::AlignedBox2d about(low, high);
    return std::ranges::all_of(trim.curve.points,
                               [&](const Eigen::Vector3d& p) { return about.contains(Vec2(p.head<2>())); });
}

double distance_along(const RationalCurve3& curve, const TrimCurve& c, const RationalPatch& surface) {
    constexpr int steps = 64;
    double off = 0;
    for (int k = 0; k <= steps; ++k) {
        const double s = static_cast<double>(k) / steps,
                     t = (1 - s) * c.curve.domain_begin() + s * c.curve.domain_end();
        const Vec2 uv = c.curve.evaluate(t);
        off = std::max(
            off, (surface.evaluate(uv.x(), uv.y()) - curve.evaluate(edge_parameter(c, curve, t))).norm());
    }
    return off;
}

double nearest_on(const RationalCurve3& curve, const Vec3& p) {
    constexpr int samples = 256, most_steps = 12;
    const double begin = curve.domain_begin(), step = (curve.domain_end() - begin) / samples;
    double best = begin, least = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= samples; ++k) {
        const double square = (curve.evaluate(begin + k * step) - p).squaredNorm();
        if (!(square < least)) continue;
        least = square;
        best = begin + k * step;
    }
    const double low = std::max(best - step, begin), high = std::min(best + step, curve.domain_end());
    for (int k = 0; k < most_steps; ++k) {
        const auto [q, way] = curve.evaluate_with_derivative(best);
        if (!(way.squaredNorm() > 0)) break;
        best = std::clamp(best + (p - q).dot(way) / way.squaredNorm(), low, high);
    }
    return best;
}

}  // namespace vcell
