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

// Room for the rows of patches of degree 4 inside.
using Row = SmallVector<Eigen::Vector4d, 5>;

// De Casteljau's triangle, homogeneous, in place: value at t and derivative with respect to t.
std::array<Eigen::Vector4d, 2> de_casteljau(Row& p, double t) {
    const std::size_t degree = p.size() - 1;
    Eigen::Vector4d derivative = Eigen::Vector4d::Zero();
    for (std::size_t level = degree; level > 0; --level) {
        if (level == 1) derivative = static_cast<double>(degree) * (p[1] - p[0]);
        for (std::size_t i = 0; i < level; ++i) p[i] = (1 - t) * p[i] + t * p[i + 1];
    }
    return {p[0], derivative};
}

// For each control point along u, the homogeneous value and derivative of its row along v.
std::array<Row, 2> evaluate_rows(const RationalPatch& patch, double t) {
    std::array<Row, 2> along_u;
    for (int i = 0; i <= patch.degree_u; ++i) {
        Row row;
        for (int j = 0; j <= patch.degree_v; ++j) row.push_back(homogeneous(patch.point(i, j)));
        const auto [value, dv] = de_casteljau(row, t);
        along_u[0].push_back(value);
        along_u[1].push_back(dv);
    }
    return along_u;
}

double to_unit(double x, const std::array<double, 2>& domain) {
    return (x - domain[0]) / (domain[1] - domain[0]);
}

}  // namespace

template <int Dim>
auto RationalCurve<Dim>::evaluate(double t) const -> Point {
    return evaluate_with_derivative(t)[0];
}

template <int Dim>
auto RationalCurve<Dim>::evaluate_with_derivative(double t) const -> std::array<Point, 2> {
    assert(degree >= 1 && knots.size() == points.size() + degree + 1);
    t = std::clamp(t, domain_begin(), domain_end());
    // The span [knots[k], knots[k+1]) that holds t; the last non-empty one for the end of the domain.
    const auto last = knots.end() - degree - 1;
    auto it = std::upper_bound(knots.begin() + degree, last, t);
    const std::size_t k = static_cast<std::size_t>(it - knots.begin()) - 1;
    SmallVector<ControlPoint, 5> d;
    for (int i = 0; i <= degree; ++i) d.push_back(homogeneous(points[k - degree + i]));
    ControlPoint derivative = ControlPoint::Zero();
    for (int level = 1; level <= degree; ++level) {
        if (level == degree) derivative = (d[degree] - d[degree - 1]) * (degree / (knots[k + 1] - knots[k]));
        for (int i = degree; i >= level; --i) {
            const double left = knots[k - degree + i], right = knots[k + 1 + i - level];
            const double s = (t - left) / (right - left);
            d[i] = (1 - s) * d[i - 1] + s * d[i];
        }
    }
    return dehomogenize<Dim>(d[degree], derivative);
}

template struct RationalCurve<2>;
template struct RationalCurve<3>;

Eigen::Vector3d RationalPatch::evaluate(double u, double v) const {
    Row along_u = evaluate_rows(*this, to_unit(v, domain_v))[0];
    const Eigen::Vector4d p = de_casteljau(along_u, to_unit(u, domain_u))[0];
    return p.head<3>() / p(3);
}

std::array<Eigen::Vector3d, 2> RationalPatch::partials(double u, double v) const {
    auto [along_u, along_u_dv] = evaluate_rows(*this, to_unit(v, domain_v));
    const double s = to_unit(u, domain_u);
    const auto [p, du] = de_casteljau(along_u, s);
    const Eigen::Vector4d dv = de_casteljau(along_u_dv, s)[0];
    return {dehomogenize<3>(p, du)[1] / (domain_u[1] - domain_u[0]),
            dehomogenize<3>(p, dv)[1] / (domain_v[1] - domain_v[0])};
}

}  // namespace vcell
