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
        is_about_axis_ = true;
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

using Homogeneous = std::array<MidRad, 4>;
using Controls = SmallVector<Homogeneous, 5>;

/// Taylor coefficients of a line or a conic about its middle.
void set_middle(const Controls& p, SmallVector<Homogeneous, 4>& c) {
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

/// In s = 2 t - 1, about `origin`: the k-th coefficient is binomial(d, k) / 2^k times the k-th difference of
/// the de Casteljau points of level d - k at the middle.
Span taylor(const Controls& piece, const Triad<double>& origin) {
    const std::size_t d = piece.size() - 1;
    Span span;
    span.coefficients.resize(d + 1);
    span.origin = origin;
    if (d <= 2) {
        set_middle(piece, span.coefficients);
        return span;
    }
    Controls level = piece, differences;
    double binomial = 1, half_power = std::ldexp(1.0, -static_cast<int>(d));
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
    return span;
}

/// The first or the second half.
Controls halved(Controls level, bool is_second) {
    const std::size_t d = level.size() - 1;
    Controls half = level;
    for (std::size_t r = 1; r <= d; ++r) {
        for (std::size_t i = 0; i + r <= d; ++i)
            for (std::size_t c = 0; c < 4; ++c) level[i][c] = 0.5 * (level[i][c] + level[i + 1][c]);
        half[is_second ? d - r : r] = level[is_second ? d - r : 0];
    }
    return half;
}

Triad<double> mid(const Triad<Interval>& p) { return {p[0].mid(), p[1].mid(), p[2].mid()}; }

/// Where a curve's control points are if both ends are where the frame has them, and the way between two of
/// them is known as well as it can be: points next to an end are as far from it as their way says. What the
/// way between both ends is off by, which is a rounding of their distance from the frame's origin, is shared
/// out along the curve. So spans join without gaps but for roundings of their distance from an end, and all
/// of the curve is where it was written but for a rounding of its coordinates, which the errors of edges
/// count.
class BetweenEnds {
public:
    /// Keeps references.
    BetweenEnds(const RationalCurve3& curve, const Frame& frame)
        : curve_(curve), frame_(frame), last_(curve.points.size() - 1) {
        ends_ = {mid(frame.point(at(0))), mid(frame.point(at(last_)))};
        const Triad<MidRad> way = frame.way(at(0), at(last_));
        for (std::size_t i = 0; i < 3; ++i) off_[i] = ends_[1][i] - (ends_[0][i] + way[i].mid());
    }

    /// Which end is nearer to the frame's z axis.
    std::size_t nearer_to_axis() const {
        const auto across = [](const Triad<double>& p) { return std::hypot(p[0], p[1]); };
        return across(ends_[1]) < across(ends_[0]) ? last_ : 0;
    }
    Triad<double> place(std::size_t k) const {
        const bool is_late = 2 * k > last_;
        const std::size_t end = is_late ? last_ : 0;
        const Triad<MidRad> from_end = way(end, k);
        Triad<double> p = ends_[is_late ? 1 : 0];
        for (std::size_t i = 0; i < 3; ++i) p[i] += from_end[i].mid();
        return p;
    }
    Triad<MidRad> way(std::size_t from, std::size_t to) const {
        Triad<MidRad> way = frame_.way(at(from), at(to));
        const double share =
            (static_cast<double>(to) - static_cast<double>(from)) / static_cast<double>(last_);
        for (std::size_t i = 0; i < 3; ++i) way[i] = way[i] + share * off_[i];
        return way;
    }

private:
    Vec3 at(std::size_t k) const { return curve_.points[k].head<3>(); }

    const RationalCurve3& curve_;
    const Frame& frame_;
    const std::size_t last_;
    std::array<Triad<double>, 2> ends_;
    Triad<double> off_;
};

}  // namespace

std::vector<Span> spans(const RationalCurve3& curve, const Frame& frame) {
    const std::size_t d = static_cast<std::size_t>(curve.degree);
    SmallVector<Homogeneous, 5> points;
    const auto between = [](const Homogeneous& a, const Homogeneous& b, const MidRad& s) {
        Homogeneous h;
        for (std::size_t i = 0; i < 4; ++i) h[i] = a[i] + s * (b[i] - a[i]);
        return h;
    };
    std::vector<Span> result;
    SmallVector<Homogeneous, 5> piece, level;
    points.resize(d + 1);
    piece.resize(d + 1);
    level.resize(d + 1);
    const BetweenEnds between_ends(curve, frame);
    for (std::size_t k = d; k + d + 1 < curve.knots.size(); ++k) {
        const double a = curve.knots[k], b = curve.knots[k + 1];
        if (!(a < b)) continue;
        const bool is_full = curve.knots[k - d + 1] == a && curve.knots[k + d] == b;
        // Curves of many spans are taken about points of their own: what a short span's points lose about one
        // far away, its derivatives lose many times over. Ends stay the points that other curves end in, as
        // the frame has them: next to an axis a gap that rounding makes would be a turn about it.
        const bool is_first = k == d, is_last = k + 1 == curve.points.size();
        const std::size_t about = is_first && is_last ? between_ends.nearer_to_axis()
                                  : is_first          ? 0
                                  : is_last           ? k
                                                      : k - d / 2;
        for (std::size_t i = 0; i <= d; ++i) {
            const Triad<MidRad> x = between_ends.way(about, k - d + i);
            const double weight = curve.points[k - d + i][3];
            points[i] = {weight * x[0], weight * x[1], weight * x[2], weight};
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
        const Triad<double> place = between_ends.place(about);
        // From next to the axis on, a span is halved until what is next to it is not much longer than it is
        // away: sums about the middle of a longer one would not tell where that is.
        constexpr double much = 64;
        if (frame.is_about_axis() && (is_first || is_last)) {
            const bool from_first = about + d == k;
            const double away = much * std::hypot(place[0], place[1]);
            const auto reach = [&] {
                const Homogeneous& far = from_first ? piece[d] : piece[0];
                return std::hypot(far[0].mid(), far[1].mid(), far[2].mid()) / far[3].mid();
            };
            while (reach() > away && away > 0) {
                std::array halves{halved(piece, false), halved(piece, true)};
                result.push_back(taylor(halves[from_first ? 1 : 0], place));
                piece = halves[from_first ? 0 : 1];
            }
        }
        result.push_back(taylor(piece, place));
    }
    return result;
}

}  // namespace vcell::check
