/// Bézier curves and patches as nets of homogeneous control points, each with a bound on its error.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../core/small_vector.hpp"
#include "curves.hpp"
#include "forms.hpp"
#include "space.hpp"

namespace vcell::check {

/// One polynomial piece of a rational curve over [begin, end]; control points are (w (p - origin), w).
template <int Dim>
struct BezierPiece {
    using Point = std::array<MidRad, Dim + 1>;

    double begin = 0, end = 1;
    SmallVector<Point, 6> points;

    int degree() const { return static_cast<int>(points.size()) - 1; }
    Form form(int coordinate) const {
        Form f(degree(), 0);
        for (int i = 0; i <= degree(); ++i) f.set(i, 0, points[i][coordinate]);
        return f;
    }
};

/// Where x is between a and b: exactly 0 or 1 at the ends.
inline MidRad place_between(double x, double a, double b) {
    return x == a ? MidRad(0.0) : x == b ? MidRad(1.0) : (MidRad(x) - a) / (MidRad(b) - a);
}
inline bool is_exactly(const MidRad& x, double value) { return x.mid() == value && x.radius() == 0; }

/// a + s (b - a), exactly where s is 0 or 1.
template <std::size_t N>
std::array<MidRad, N> blend(const std::array<MidRad, N>& a, const std::array<MidRad, N>& b, const MidRad& s) {
    if (is_exactly(s, 0)) return a;
    if (is_exactly(s, 1)) return b;
    std::array<MidRad, N> r;
    const MidRad rest = MidRad(1.0) - s;
    for (std::size_t k = 0; k < N; ++k) r[k] = rest * a[k] + s * b[k];
    return r;
}

/// A curve's control point, homogeneous about an origin.
template <int Dim>
typename BezierPiece<Dim>::Point homogeneous(const RationalCurve<Dim>& c, std::size_t i,
                                             const Eigen::Matrix<double, Dim, 1>& origin) {
    typename BezierPiece<Dim>::Point p;
    const double w = c.points[i][Dim];
    p[Dim] = w;
    for (int k = 0; k < Dim; ++k) p[k] = w * (MidRad(c.points[i][k]) - origin[k]);
    return p;
}
/// Where a curve has no knots inside its domain it is one span.
template <int Dim>
std::optional<BezierPiece<Dim>> only_span(const RationalCurve<Dim>& c,
                                          const Eigen::Matrix<double, Dim, 1>& origin) {
    if (c.points.size() != static_cast<std::size_t>(c.degree) + 1) return std::nullopt;
    if (c.knots[0] != c.knots[c.degree] || c.knots[c.degree + 1] != c.knots[2 * c.degree + 1])
        return std::nullopt;
    BezierPiece<Dim> span{c.domain_begin(), c.domain_end(), {}};
    for (std::size_t i = 0; i < c.points.size(); ++i) span.points.push_back(homogeneous(c, i, origin));
    return span;
}

template <int Dim>
std::vector<BezierPiece<Dim>> spans(const RationalCurve<Dim>& c,
                                    const Eigen::Matrix<double, Dim, 1>& origin) {
    using Point = typename BezierPiece<Dim>::Point;
    return pieces_of<BezierPiece<Dim>>(
        c, [&](int i) { return homogeneous(c, static_cast<std::size_t>(i), origin); },
        [](const Point& p, const Point& q, double t, double from, double to) {
            return blend(p, q, place_between(t, from, to));
        });
}

/// The part of a span over [begin, end] of its domain.
template <int Dim>
BezierPiece<Dim> part_of(const BezierPiece<Dim>& span, double begin, double end) {
    if (begin == span.begin && end == span.end) return span;
    const MidRad a = place_between(begin, span.begin, span.end), b = place_between(end, span.begin, span.end);
    const int d = span.degree();
    BezierPiece<Dim> result{begin, end, {}};
    for (int j = 0; j <= d; ++j) {
        auto level = span.points;
        for (int r = 1; r <= d; ++r)
            for (int i = 0; i + r <= d; ++i) level[i] = blend(level[i], level[i + 1], r <= j ? b : a);
        result.points.push_back(level[0]);
    }
    return result;
}

/// What is known of homogeneous control points: the largest magnitudes and errors of each coordinate, and the
/// least weight.
struct Sizes {
    std::array<double, 4> most{}, error{};
    double least_weight = HUGE_VAL;

    void meet(const std::array<MidRad, 4>& p) {
        for (std::size_t k = 0; k < 4; ++k) {
            most[k] = std::max(most[k], std::abs(p[k].mid()));
            error[k] = std::max(error[k], p[k].radius());
        }
        least_weight = std::min(least_weight, p[3].mid() - p[3].radius());
    }
};

/// A curve (of degree 0 in t) or a patch in space. Points are about an origin near by, so that they have few
/// digits to lose.
class Net {
public:
    using Point = std::array<MidRad, 4>;

    Net(int m, int n, const Vec3& origin) : m_(m), n_(n), origin_(origin) {
        points_.resize(static_cast<std::size_t>((m + 1) * (n + 1)));
    }
    Net(const BezierPiece<3>& span, const Vec3& origin) : Net(span.degree(), 0, origin) {
        for (int i = 0; i <= m_; ++i) at(i, 0) = span.points[i];
    }
    Net(const RationalPatch& patch, const Vec3& origin);

    int degree_s() const { return m_; }
    int degree_t() const { return n_; }
    const Vec3& origin() const { return origin_; }
    Point& at(int i, int j) {
        has_box_ = has_sizes_ = false;
        return points_[static_cast<std::size_t>(i * (n_ + 1) + j)];
    }
    const Point& at(int i, int j) const { return points_[static_cast<std::size_t>(i * (n_ + 1) + j)]; }

    /// One homogeneous coordinate as a polynomial.
    Form form(int coordinate) const;
    /// The whole lies in the hull of its control points. Pre: weights are positive.
    const Vector<Interval>& box() const;
    /// Of all control points.
    const Sizes& sizes() const;
    /// The ends in s and t: 0 is the begin, 1 the end.
    Vector<Interval> corner(int i, int j) const { return position(at(i * m_, j * n_)); }
    /// A control point's place. Pre: its weight is positive.
    Vector<Interval> control(int i, int j) const { return position(at(i, j)); }
    /// About where they are, from the origin.
    Vec3 about(int i, int j) const {
        const Point& p = at(i * m_, j * n_);
        return Vec3(p[0].mid(), p[1].mid(), p[2].mid()) / p[3].mid();
    }
    /// Derivative with respect to s (axis 0) or t (axis 1), as it runs over [0, 1].
    Vector<Interval> derivative(int axis) const;
    std::array<Net, 2> halves(int axis) const;
    /// The part over s or t in [a, b], with rounded ends.
    Net part(int axis, const MidRad& a, const MidRad& b) const;

private:
    Vector<Interval> position(const Point& p) const;

    int m_, n_;
    Vec3 origin_;
    SmallVector<Point, 9> points_;
    mutable bool has_box_ = false;  // box_ is that of the points
    mutable Vector<Interval> box_;
    mutable bool has_sizes_ = false;
    mutable Sizes sizes_;
};

/// The part of a patch over the rectangle lo, hi of its parameters, where the corners of its domain do not
/// matter.
Net net_over(const RationalPatch& patch, const Vec2& lo, const Vec2& hi, const Vec3& origin);

}  // namespace vcell::check
