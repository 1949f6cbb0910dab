#include "known_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace vcell {

namespace {

/// Points of a curve at even parameters, to begin with.
struct Steps {
    Steps(const RationalCurve3& of, std::size_t count) : curve(of), points(count + 1) {
        for (std::size_t i = 0; i <= count; ++i) points[i] = curve.evaluate(at(static_cast<double>(i)));
    }

    double at(double step) const {
        const double s = step / static_cast<double>(points.size() - 1);
        return (1 - s) * curve.domain_begin() + s * curve.domain_end();
    }
    double square(std::size_t i, const Vec3& p) const { return (points[i] - p).squaredNorm(); }

    /// The parameter of the point nearest to p, near that of point i, to about the square of `near`, a part
    /// of the domain, where p is on the curve.
    double nearest(std::size_t i, const Vec3& p, double near) const {
        const double before = at(i == 0 ? 0.0 : static_cast<double>(i - 1)),
                     after = at(static_cast<double>(std::min(i + 1, points.size() - 1)));
        double t = at(static_cast<double>(i));
        constexpr int most_steps = 12;
        for (int k = 0; k < most_steps; ++k) {
            const auto [q, along] = curve.evaluate_with_derivative(t);
            const double square = along.squaredNorm();
            if (!(square > 0)) break;
            const double next = std::clamp(t + (p - q).dot(along) / square, before, after);
            const bool is_there = std::abs(next - t) <= near * (curve.domain_end() - curve.domain_begin());
            t = next;
            if (is_there) break;
        }
        return t;
    }

    const RationalCurve3& curve;
    std::vector<Vec3> points;
};

}  // namespace

std::vector<double> parameters_along(const RationalCurve3& curve, const std::vector<Vec3>& points) {
    const std::size_t n = points.size() - 1;
    const double begin = curve.domain_begin(), end = curve.domain_end();
    std::vector<double> result{begin};
    if (n > 1) {
        const Steps steps(curve, n + 3);
        std::size_t at = 0;
        for (std::size_t k = 1; k < n; ++k) {
            while (at + 1 < steps.points.size() &&
                   steps.square(at + 1, points[k]) < steps.square(at, points[k]))
                ++at;
            constexpr double near = 0x1p-20;  // for the shapes of triangles
            result.push_back(steps.nearest(at, points[k], near));
        }
    }
    result.push_back(end);
    // Points that do not follow each other along this curve do by their own distances.
    constexpr double least_step = 1e-9;  // of the domain
    const bool ascends = std::ranges::adjacent_find(result, [&](double a, double b) {
                             return !(b - a > least_step * (end - begin));
                         }) == result.end();
    if (ascends) return result;
    std::vector<double> way{0};
    for (std::size_t k = 1; k <= n; ++k) way.push_back(way.back() + (points[k] - points[k - 1]).norm());
    for (std::size_t k = 1; k < n; ++k) {
        const double s = way.back() > 0 ? way[k] / way.back() : 0,
                     even = static_cast<double>(k) / static_cast<double>(n);
        // Half of it even, so that no two are the same.
        result[k] = begin + (end - begin) * (0.5 * s + 0.5 * even);
    }
    return result;
}

double nearest_parameter(const RationalCurve3& curve, const Vec3& p) {
    constexpr double near = 0x1p-20;
    const Steps steps(curve, 32);
    std::size_t at = 0;
    for (std::size_t i = 1; i < steps.points.size(); ++i)
        if (steps.square(i, p) < steps.square(at, p)) at = i;
    return steps.nearest(at, p, near);
}

double distance_from_curve(const RationalCurve3& curve, const Vec3& p, double enough) {
    // Where a curve is run through unevenly its middle stays away from p for longer than parameters show.
    constexpr double exact = 0x1p-44;
    const Steps few(curve, 2);
    const double quick = (curve.evaluate(few.nearest(1, p, exact)) - p).norm();
    if (quick <= enough) return quick;
    // A long spline may bend back in any of its spans.
    constexpr std::size_t least_steps = 32, of_span = 4;
    const std::size_t spans = (curve.points.size() - 1) / static_cast<std::size_t>(curve.degree);
    const Steps steps(curve, std::max(least_steps, of_span * spans));
    double least = std::numeric_limits<double>::infinity();
    const auto is_nearest_beside = [&](std::size_t i) {
        const double square = steps.square(i, p);
        return (i == 0 || square <= steps.square(i - 1, p)) &&
               (i + 1 == steps.points.size() || square <= steps.square(i + 1, p));
    };
    for (std::size_t i = 0; i < steps.points.size(); ++i)
        if (is_nearest_beside(i))
            least = std::min(least, (curve.evaluate(steps.nearest(i, p, exact)) - p).norm());
    return least;
}

}  // namespace vcell
