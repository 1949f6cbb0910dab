#include "bspline.hpp"

#include <algorithm>
#include <cassert>

namespace vcell {

namespace {

// The point itself and the derivative of a homogeneous curve A(t) = (w x, w): x' = (A' - w' x) / w.
template <int Dim>
std::array<Eigen::Matrix<double, Dim, 1>, 2> dehomogenize(const Eigen::Matrix<double, Dim + 1, 1>& a,
                                                          const Eigen::Matrix<double, Dim + 1, 1>& da) {
    const Eigen::Matrix<double, Dim, 1> point = a.template head<Dim>() / a(Dim);
    return {point, (da.template head<Dim>() - da(Dim) * point) / a(Dim)};
}

template <class ControlPoint>
ControlPoint homogeneous(ControlPoint p) {
    const auto dim = p.size() - 1;
    p.head(dim) *= p(dim);
    return p;
}

// Bernstein's polynomials of one degree at t, with their derivatives.
struct BernsteinAt {
    SmallVector<double, 5> values, derivatives;

    BernsteinAt(int degree, double t) {
        values.push_back(1);
        for (int level = 1; level <= degree; ++level) {
            if (level == degree) set_derivatives(degree);
            values.push_back(t * values[level - 1]);
            for (int i = level - 1; i > 0; --i) values[i] = (1 - t) * values[i] + t * values[i - 1];
            values[0] *= 1 - t;
        }
    }

private:
    // From the values of one degree less.
    void set_derivatives(int degree) {
        for (int i = 0; i <= degree; ++i)
            derivatives.push_back(degree * ((i > 0 ? values[i - 1] : 0) - (i < degree ? values[i] : 0)));
    }
};

Eigen::Vector4d homogeneous_sum(const RationalPatch& patch, const SmallVector<double, 5>& along_u,
                                const SmallVector<double, 5>& along_v) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int i = 0; i <= patch.degree_u; ++i)
        for (int j = 0; j <= patch.degree_v; ++j) {
            const Eigen::Vector4d& p = patch.point(i, j);
            const double share = along_u[i] * along_v[j] * p.w();
            sum.head<3>() += share * p.head<3>();
            sum.w() += share;
        }
    return sum;
}

// De Boor's triangle on homogeneous points, and the derivative where it is asked for. t is clamped to the
// domain.
template <int Dim>
Eigen::Matrix<double, Dim + 1, 1> homogeneous_at(const RationalCurve<Dim>& curve, double t,
                                                 Eigen::Matrix<double, Dim + 1, 1>* derivative) {
    const auto& [degree, knots, points] = curve;
    assert(degree >= 1 && knots.size() == points.size() + degree + 1);
    t = std::clamp(t, curve.domain_begin(), curve.domain_end());
    // The span [knots[k], knots[k+1]) that holds t; the last non-empty one for the end of the domain.
    const auto last = knots.end() - degree - 1;
    auto it = std::upper_bound(knots.begin() + degree, last, t);
    const std::size_t k = static_cast<std::size_t>(it - knots.begin()) - 1;
    SmallVector<Eigen::Matrix<double, Dim + 1, 1>, 6> d;
    for (int i = 0; i <= degree; ++i) d.push_back(homogeneous(points[k - degree + i]));
    for (int level = 1; level <= degree; ++level) {
        if (level == degree && derivative)
            *derivative = (d[degree] - d[degree - 1]) * (degree / (knots[k + 1] - knots[k]));
        for (int i = degree; i >= level; --i) {
            const double left = knots[k - degree + i], right = knots[k + 1 + i - level];
            const double s = (t - left) / (right - left);
            d[i] = (1 - s) * d[i - 1] + s * d[i];
        }
    }
    return d[degree];
}

double to_unit(double x, const std::array<double, 2>& domain) {
    return (x - domain[0]) / (domain[1] - domain[0]);
}

}  // namespace

template <int Dim>
auto RationalCurve<Dim>::evaluate(double t) const -> Point {
    const ControlPoint a = homogeneous_at<Dim>(*this, t, nullptr);
    return a.template head<Dim>() / a(Dim);
}

template <int Dim>
auto RationalCurve<Dim>::evaluate_with_derivative(double t) const -> std::array<Point, 2> {
    ControlPoint derivative = ControlPoint::Zero();
    const ControlPoint a = homogeneous_at<Dim>(*this, t, &derivative);
    return dehomogenize<Dim>(a, derivative);
}

template struct RationalCurve<2>;
template struct RationalCurve<3>;

Eigen::Vector3d RationalPatch::evaluate(double u, double v) const {
    const Eigen::Vector4d p = homogeneous_sum(*this, BernsteinAt(degree_u, to_unit(u, domain_u)).values,
                                              BernsteinAt(degree_v, to_unit(v, domain_v)).values);
    return p.head<3>() / p.w();
}

std::array<Eigen::Vector3d, 2> RationalPatch::partials(double u, double v) const {
    const BernsteinAt along_u(degree_u, to_unit(u, domain_u)), along_v(degree_v, to_unit(v, domain_v));
    const Eigen::Vector4d p = homogeneous_sum(*this, along_u.values, along_v.values);
    const Eigen::Vector4d du = homogeneous_sum(*this, along_u.derivatives, along_v.values);
    const Eigen::Vector4d dv = homogeneous_sum(*this, along_u.values, along_v.derivatives);
    return {dehomogenize<3>(p, du)[1] / (domain_u[1] - domain_u[0]),
            dehomogenize<3>(p, dv)[1] / (domain_v[1] - domain_v[0])};
}

}  // namespace vcell
