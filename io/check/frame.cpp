#include "frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "triads.hpp"

namespace vcell::check {

Frame::Frame(const Scene& scene) {
    int exponent = 0;
    std::frexp(scene.box.diagonal(), &exponent);
    unit_ = std::ldexp(1.0, exponent);
    Vec3 up = Vec3::UnitZ();
    if (const auto* plane = std::get_if<Plane>(&scene.base)) {
        origin_ = plane->point;
        up = plane->normal;
    } else if (const auto* sphere = std::get_if<Sphere>(&scene.base)) {
        origin_ = sphere->center;
        radius_ = length(sphere->radius);
    } else {
        const auto& cylinder = std::get<Cylinder>(scene.base);
        origin_ = cylinder.point;
        up = cylinder.axis;
        radius_ = length(cylinder.radius);
    }
    if (up.x() == 0 && up.y() == 0 && up.z() > 0) return;
    const double size = up.cwiseAbs().maxCoeff();
    const Triad<Interval> n = normalized(
        Triad<Interval>{Interval(up.x()) / size, Interval(up.y()) / size, Interval(up.z()) / size});
    int least = 0;
    up.cwiseAbs().minCoeff(&least);
    Triad<Interval> aside{};
    aside[static_cast<std::size_t>(least)] = 1.0;
    const Triad<Interval> first = normalized(cross(aside, n));
    rows_ = {first, cross(n, first), n};
}

// A quotient by a power of two is exact, but where it is subnormal.
Interval Frame::length(double x) const {
    const double y = x / unit_;
    return x == 0 || std::abs(y) >= std::numeric_limits<double>::min() ? Interval(y) : Interval(x) / unit_;
}

Triad<Interval> Frame::turned(const Triad<Interval>& d) const {
    if (!rows_) return d;
    return {dot((*rows_)[0], d), dot((*rows_)[1], d), dot((*rows_)[2], d)};
}

Triad<Interval> Frame::point(const Vec3& p) const {
    Triad<Interval> d;
    for (int i = 0; i < 3; ++i) {
        // A difference of doubles is exact more often than not, and an enclosure that knows stays a number.
        const double difference = p[i] - origin_[i];
        const bool is_exact = difference + origin_[i] == p[i] && p[i] - difference == origin_[i];
        d[static_cast<std::size_t>(i)] = is_exact ? length(difference) : length(p[i]) - length(origin_[i]);
    }
    return turned(d);
}

Triad<Interval> Frame::point(const Triad<Interval>& p) const {
    Triad<Interval> d;
    for (std::size_t i = 0; i < 3; ++i)
        d[i] = (p[i] - Interval(origin_[static_cast<Eigen::Index>(i)])) / Interval(unit_);
    return turned(d);
}

Triad<double> Frame::about(const Vec3& p) const {
    const Vec3 d = (p - origin_) / unit_;
    if (!rows_) return {d[0], d[1], d[2]};
    Triad<double> q;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& row = (*rows_)[i];
        q[i] = row[0].mid() * d[0] + row[1].mid() * d[1] + row[2].mid() * d[2];
    }
    return q;
}

Triad<MidRad> Frame::way(const Vec3& from, const Vec3& to) const {
    Triad<MidRad> d;
    for (int i = 0; i < 3; ++i) d[static_cast<std::size_t>(i)] = MidRad(length(to[i])) - length(from[i]);
    if (!rows_) return d;
    Triad<MidRad> way;
    for (std::size_t i = 0; i < 3; ++i) way[i] = dot(near((*rows_)[i]), d);
    return way;
}

Triad<Interval> Frame::direction(const Vec3& d) const { return turned({Interval(d.x()), d.y(), d.z()}); }

namespace {

/// Taylor coefficients of a line or a conic about its middle.
void set_middle(const SmallVector<std::array<MidRad, 4>, 5>& p, SmallVector<std::array<MidRad, 4>, 4>& c) {
    const std::size_t last = p.size() - 1;
    for (std::size_t i = 0; i < 4; ++i) {
        const MidRad sum = p[0][i] + p[last][i];
        c[1][i] = 0.5 * (p[last][i] - p[0][i]);
        if (last == 2) {
            const MidRad twice = 2.0 * p[1][i];
            c[0][i] = 0.25 * (sum + twice);
            c[2][i] = 0.25 * (sum - twice);
        } else {
            c[0][i] = 0.5 * sum;
        }
    }
}

}  // namespace

std::vector<Span> spans(const RationalCurve3& curve, const Frame& frame) {
    const auto difference = [](const Triad<Interval>& p, const Triad<Interval>& place) {
        Triad<MidRad> d;
        for (std::size_t i = 0; i < 3; ++i) d[i] = MidRad(p[i]) - place[i].mid();
        return d;
    };
    using Homogeneous = std::array<MidRad, 4>;
    const std::size_t d = static_cast<std::size_t>(curve.degree);
    SmallVector<Homogeneous, 5> points;
    const auto between = [](const Homogeneous& a, const Homogeneous& b, const MidRad& s) {
        Homogeneous h;
        for (std::size_t i = 0; i < 4; ++i) h[i] = a[i] + s * (b[i] - a[i]);
        return h;
    };
    std::vector<Span> result;
    SmallVector<Homogeneous, 5> piece, level, differences;
    points.resize(d + 1);
    piece.resize(d + 1);
    level.resize(d + 1);
    for (std::size_t k = d; k + d + 1 < curve.knots.size(); ++k) {
        const double a = curve.knots[k], b = curve.knots[k + 1];
        if (!(a < b)) continue;
        const bool is_full = curve.knots[k - d + 1] == a && curve.knots[k + d] == b;
        // Splines of many spans are taken about points of their own: what a short span's points lose about
        // one far away, its derivatives lose many times over. Ends stay the points that other curves end in,
        // as the frame has them, and so do all joints of conics: next to an axis a gap that rounding makes
        // would be a turn about it.
        const std::size_t middle = curve.points.size() / 2;
        const std::size_t about = d <= 2 ? middle : k == d ? 0 : k + 1 == curve.points.size() ? k : k - d / 2;
        const Vec3 origin = curve.points[about].head<3>();
        const Triad<Interval> place = frame.point(origin);
        for (std::size_t i = 0; i <= d; ++i) {
            const auto& p = curve.points[k - d + i];
            const Triad<MidRad> x =
                d <= 2 ? difference(frame.point(p.head<3>()), place) : frame.way(origin, p.head<3>());
            points[i] = {p[3] * x[0], p[3] * x[1], p[3] * x[2], p[3]};
        }
        for (std::size_t j = 0; j <= d; ++j) {
            if (is_full) {
                piece[j] = points[j];
                continue;
            }
            // The blossom at a, ..., a, b, ..., b, j times b.
            level = points;
            for (std::size_t r = 1; r <= d; ++r) {
                const double t = r <= j ? b : a;
                for (std::size_t i = d; i >= r; --i) {
                    const double first = curve.knots[k - d + i], last = curve.knots[k + i + 1 - r];
                    level[i] = between(level[i - 1], level[i], (MidRad(t) - first) / (MidRad(last) - first));
                }
            }
            piece[j] = level[d];
        }
        // The k-th Taylor coefficient in s = 2 t - 1 is binomial(d, k) / 2^k times the k-th difference of the
        // de Casteljau points of level d - k at the middle.
        Span span;
        span.coefficients.resize(d + 1);
        for (std::size_t i = 0; i < 3; ++i) span.origin[i] = place[i].mid();
        if (d <= 2) {
            set_middle(piece, span.coefficients);
            result.push_back(std::move(span));
            continue;
        }
        level = piece;
        double binomial = 1, half_power = std::ldexp(1.0, -curve.degree);
        for (std::size_t order = d + 1; order-- > 0;) {
            differences.assign(level.begin(), level.begin() + static_cast<long>(order) + 1);
            for (std::size_t r = 0; r < order; ++r)
                for (std::size_t i = 0; i + r < order; ++i)
                    for (std::size_t c = 0; c < 4; ++c)
                        differences[i][c] = differences[i + 1][c] - differences[i][c];
            for (std::size_t c = 0; c < 4; ++c)
                span.coefficients[order][c] = (binomial * half_power) * differences[0][c];
            for (std::size_t i = 0; i < order; ++i)
                for (std::size_t c = 0; c < 4; ++c) level[i][c] = 0.5 * (level[i][c] + level[i + 1][c]);
            binomial = binomial * static_cast<double>(order) / static_cast<double>(d - order + 1);
            half_power *= 2;
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const MidRad off = MidRad(place[i]) - span.origin[i];
            for (auto& c : span.coefficients) c[i] += off * c[3];
        }
        result.push_back(std::move(span));
    }
    return result;
}

}  // namespace vcell::check
