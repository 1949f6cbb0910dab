#include "spline_surface.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/quadrature/quadrature.hpp"

namespace vcell {

namespace {

// By Gauss and Legendre's rule of four points.
template <class F>
double integral(const F& f, double a, double b) {
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    double sum = 0;
    const quadrature::RuleOf<4>& rule = quadrature::rule<4>();
    for (std::size_t k = 0; k < rule.x.size(); ++k)
        sum += rule.weight[k] * (f(middle - half * rule.x[k]) + f(middle + half * rule.x[k]));
    return half * sum;
}

// Inner knots of [a, b] for functions along several lines, in order.
template <class F>
void halve(const std::vector<F>& functions, double a, double b, double accuracy, int times,
           std::vector<double>& knots) {
    const double middle = 0.5 * (a + b);
    bool suffices = times == 0;
    if (!suffices) {
        double change = 0;
        for (const F& f : functions)
            change = std::max(change,
                              std::abs(integral(f, a, middle) + integral(f, middle, b) - integral(f, a, b)));
        suffices = change <= accuracy;
    }
    if (suffices) return;
    halve(functions, a, middle, accuracy, times - 1, knots);
    knots.push_back(middle);
    halve(functions, middle, b, accuracy, times - 1, knots);
}

RationalCurve<3> bezier(int degree, const std::array<double, 2>& domain) {
    RationalCurve<3> curve;
    curve.degree = degree;
    for (const double end : domain)
        curve.knots.insert(curve.knots.end(), static_cast<std::size_t>(degree + 1), end);
    return curve;
}

}  // namespace

SplineSurface with_knots(const RationalPatch& patch, double accuracy) {
    const auto& [u0, u1] = patch.domain_u;
    const auto& [v0, v1] = patch.domain_v;
    const auto under = [&](double u, double v) {
        const auto [du, dv] = patch.partials(u, v);
        return patch.evaluate(u, v).dot(du.cross(dv)) / 3;
    };
    constexpr int lines = 9, most_halvings = 6;
    const auto inner_knots = [&](double a, double b, double c, double d, const auto& f) {
        const auto along = [&](double s) { return [=, &f](double t) { return f(t, s); }; };
        std::vector<decltype(along(0))> functions;
        for (int k = 0; k < lines; ++k) functions.push_back(along(c + (d - c) * k / (lines - 1)));
        std::vector<double> knots;
        halve(functions, a, b, accuracy / (d - c), most_halvings, knots);
        return knots;
    };
    const std::vector<double> in_u = inner_knots(u0, u1, v0, v1, under),
                              in_v = inner_knots(v0, v1, u0, u1,
                                                 [&](double v, double u) { return under(u, v); });

    // Rows along u get their knots, then what they become along v.
    SplineSurface result;
    result.degree_u = patch.degree_u;
    result.degree_v = patch.degree_v;
    std::vector<RationalCurve<3>> along_u;
    for (int j = 0; j <= patch.degree_v; ++j) {
        RationalCurve<3> row = bezier(patch.degree_u, patch.domain_u);
        for (int i = 0; i <= patch.degree_u; ++i) row.points.push_back(patch.point(i, j));
        for (const double t : in_u) row = with_knot(row, t);
        along_u.push_back(std::move(row));
    }
    result.knots_u.assign(along_u[0].knots.begin(), along_u[0].knots.end());
    for (std::size_t i = 0; i < along_u[0].points.size(); ++i) {
        RationalCurve<3> row = bezier(patch.degree_v, patch.domain_v);
        for (const auto& across : along_u) row.points.push_back(across.points[i]);
        for (const double t : in_v) row = with_knot(row, t);
        result.knots_v.assign(row.knots.begin(), row.knots.end());
        result.points.emplace_back(row.points.begin(), row.points.end());
    }
    return result;
}

}  // namespace vcell
