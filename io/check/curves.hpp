/// Curves, patches and quadrature of the check: evaluation by code that computes no cell.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../core/small_vector.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell::check {

/// Higher degrees than this are no curve or patch of a cell, and would make evaluation unstable.
inline constexpr int kMaxDegree = 31;

/// One polynomial piece of a rational curve, homogeneous: points are (w x, w).
template <int Dim>
struct Bezier {
    using Point = Eigen::Matrix<double, Dim, 1>;
    using Homogeneous = Eigen::Matrix<double, Dim + 1, 1>;

    double begin = 0, end = 1;
    SmallVector<Homogeneous, 5> points;

    int degree() const { return static_cast<int>(points.size()) - 1; }
    Point control(std::size_t i) const { return points[i].template head<Dim>() / points[i][Dim]; }
    double weight(std::size_t i) const { return points[i][Dim]; }

    /// Position and derivative with respect to the curve's parameter at t.
    std::array<Point, 2> evaluate(double t) const {
        std::array<Homogeneous, kMaxDegree + 1> b;
        std::ranges::copy(points, b.begin());
        const double s = (t - begin) / (end - begin);
        for (int level = degree(); level > 1; --level)
            for (int i = 0; i < level; ++i) b[i] = (1 - s) * b[i] + s * b[i + 1];
        const Homogeneous h = (1 - s) * b[0] + s * b[1];
        const Homogeneous dh = (b[1] - b[0]) * (degree() / (end - begin));
        const Point p = h.template head<Dim>() / h[Dim];
        return {p, (dh.template head<Dim>() - dh[Dim] * p) / h[Dim]};
    }

    std::array<Bezier, 2> halves() const {
        std::array<Bezier, 2> h{*this, *this};
        h[0].end = h[1].begin = 0.5 * (begin + end);
        SmallVector<Homogeneous, 5> b = points;
        for (int i = 0; i <= degree(); ++i) {
            h[0].points[i] = b[0];
            h[1].points[degree() - i] = b[degree() - i];
            for (int j = 0; j < degree() - i; ++j) b[j] = 0.5 * (b[j] + b[j + 1]);
        }
        return h;
    }
};

/// Are the control points of the piece between knots k and k + 1 the curve's own?
template <int Dim>
bool is_bezier(const RationalCurve<Dim>& c, int k) {
    return c.knots[k - c.degree + 1] == c.knots[k] && c.knots[k + c.degree] == c.knots[k + 1];
}

/// The pieces of a curve between its distinct knots: control point j of the piece on [a, b] is the blossom
/// at (a, ..., a, b, ..., b) with j times b. control(i): the curve's i-th control point in the piece's
/// numbers; blend(p, q, t, from, to): between p at `from` and q at `to`.
template <class Piece, int Dim, class Control, class Blend>
std::vector<Piece> pieces_of(const RationalCurve<Dim>& c, const Control& control, const Blend& blend) {
    const int d = c.degree;
    std::vector<Piece> result;
    for (int k = d; k + d + 1 < static_cast<int>(c.knots.size()); ++k) {
        const double a = c.knots[k], b = c.knots[k + 1];
        if (!(a < b)) continue;
        Piece piece{a, b, {}};
        for (int j = 0; j <= d; ++j) {
            if (is_bezier(c, k)) {
                piece.points.push_back(control(k - d + j));
                continue;
            }
            decltype(piece.points) level;
            for (int i = k - d; i <= k; ++i) level.push_back(control(i));
            for (int r = 1; r <= d; ++r)
                for (int i = d; i >= r; --i) {
                    const int knot = k - d + i;
                    level[i] = blend(level[i - 1], level[i], r <= j ? b : a, c.knots[knot],
                                     c.knots[knot + d - r + 1]);
                }
            piece.points.push_back(level[d]);
        }
        result.push_back(std::move(piece));
    }
    return result;
}

template <int Dim>
std::vector<Bezier<Dim>> pieces(const RationalCurve<Dim>& c) {
    using Homogeneous = typename Bezier<Dim>::Homogeneous;
    return pieces_of<Bezier<Dim>>(
        c,
        [&](int i) {
            Homogeneous h = c.points[i];
            h.template head<Dim>() *= h[Dim];
            return h;
        },
        [](const Homogeneous& p, const Homogeneous& q, double t, double from, double to) {
            const double s = (t - from) / (to - from);
            return Homogeneous((1 - s) * p + s * q);
        });
}

template <int Dim>
typename Bezier<Dim>::Point evaluate(const std::vector<Bezier<Dim>>& curve, double t) {
    for (const auto& piece : curve)
        if (t <= piece.end) return piece.evaluate(t)[0];
    return curve.back().evaluate(t)[0];
}

struct SurfacePoint {
    Vec3 p, pu, pv;
};

/// Bernstein polynomials of degree d, up to kMaxDegree, at s and their derivatives.
struct Bernstein {
    Bernstein(int d, double s);

    std::array<double, kMaxDegree + 1> value, slope;
};

/// Pre: degrees up to kMaxDegree.
SurfacePoint evaluate(const RationalPatch& s, double u, double v);

/// Angle that the curve sweeps as seen from q; none when q is about as close to it as `near`, in either
/// coordinate. Pre: near > 0.
std::optional<double> swept(const Bezier<2>& c, const Vec2& q, const Vec2& near);

template <class V>
struct Integral {
    V value, error;
};

/// Adaptive Gauss-Kronrod (7, 15); parts are halved until the two rules agree to 1e-10, or to `floor`,
/// below which there is only rounding. The error is their difference, which overestimates.
template <class F, class V = std::invoke_result_t<F, double>>
Integral<V> integrate(const F& f, double a, double b, const V& floor, int depth = 12) {
    using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
    using Gauss = boost::math::quadrature::gauss<double, 7>;
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    const V centre = f(middle);
    V fine = Kronrod::weights()[0] * centre, coarse = Gauss::weights()[0] * centre;
    V size = Kronrod::weights()[0] * centre.abs();
    for (std::size_t i = 1; i < Kronrod::abscissa().size(); ++i) {
        const double x = half * Kronrod::abscissa()[i];
        const V left = f(middle - x), right = f(middle + x);
        fine += Kronrod::weights()[i] * (left + right);
        size += Kronrod::weights()[i] * (left.abs() + right.abs());
        if (i % 2 == 0) coarse += Gauss::weights()[i / 2] * (left + right);
    }
    const V error = (fine - coarse).abs();
    if (depth == 0 || (error <= 1e-10 * size || std::abs(half) * error <= floor).all())
        return {half * fine, std::abs(half) * error};
    const auto l = integrate(f, a, middle, floor, depth - 1), r = integrate(f, middle, b, floor, depth - 1);
    return {l.value + r.value, l.error + r.error};
}

}  // namespace vcell::check
