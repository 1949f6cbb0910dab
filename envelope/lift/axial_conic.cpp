#include "axial_conic.hpp"

#include <cmath>

#include "../../core/numbers/small_systems.hpp"
#include "../../primitives/bases/canonical.hpp"

namespace vcell {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector4d;

// The equation of g, or where it is nearly that of f what it adds to it.
AxialEquation told_from(const AxialEquation& f, const AxialEquation& g) {
    constexpr double nearly_alike = 1 - 0x1p-20;
    const auto normal = [](const AxialEquation& e) {
        return Vector4d(nearest(e.b[0]), nearest(e.b[1]), nearest(e.b[2]), nearest(e.b0));
    };
    const Vector4d m = normal(f), n = normal(g);
    const double along = m.dot(n) / (m.norm() * n.norm());
    if (!(std::abs(along) > nearly_alike)) return g;
    const Exact factor = std::copysign(n.norm() / m.norm(), along);
    AxialEquation rest{{}, g.b0 - factor * f.b0, g.k - factor * f.k};
    for (std::size_t i = 0; i < 3; ++i) rest.b[i] = g.b[i] - factor * f.b[i];
    return rest;
}

// Of its part along the axis.
double magnitude(const AxialEquation& f, double size) {
    return std::hypot(size * nearest(f.b[1]), nearest(f.k));
}

}  // namespace

std::optional<AxialEquation> axial_equation(const RadialForm& form) {
    if (form.has_root() || !is_zero(form.c[2])) return std::nullopt;
    return AxialEquation{{form.b[0], -form.c[1].scaled(-1), form.b[2]}, form.b0, form.c[0].scaled(-1)};
}

AxialEquation axial_equation(double y) { return {{Exact(), 1.0, Exact()}, Exact(), y}; }

CurveKind kind_of(const AxialEquation& f, const AxialEquation& g) {
    const auto eliminated = [&](const Exact& of_f, const Exact& of_g) {
        return g.b[1] * of_f - f.b[1] * of_g;
    };
    if (is_zero(eliminated(f.k, g.k))) return CurveKind::Line;
    const Exact x = eliminated(f.b[0], g.b[0]), z = eliminated(f.b[2], g.b[2]), t = eliminated(f.b0, g.b0);
    const Exact across2 = x * x + z * z;
    // t is constant, and y too if that is what one of the equations says.
    const AxialEquation& steeper = is_zero(f.b[1]) ? g : f;
    if (is_zero(across2) && is_zero(steeper.b[0]) && is_zero(steeper.b[2])) return CurveKind::Circle;
    // m_x^2 + m_z^2 - m_t^2 is g_y^2 (f_x^2 + f_z^2 - f_t^2) + f_y^2 (...) - 2 f_y g_y (f_x g_x + f_z g_z -
    // f_t g_t), where the brackets of planes are -f_y^2 and -g_y^2, and f.g < f_t g_t. An end has g = (0, 1,
    // 0, 0).
    const auto is_end = [](const AxialEquation& e) {
        return is_zero(e.b[0]) && is_zero(e.b[2]) && is_zero(e.b0);
    };
    const Sign fy = f.b[1].sign(), gy = g.b[1].sign();
    const Sign sign = f.has_plane && g.has_plane ? fy * gy
                      : (f.has_plane && is_end(g)) || (g.has_plane && is_end(f))
                          ? (fy == Sign::Zero || gy == Sign::Zero ? Sign::Zero : Sign::Negative)
                          : (across2 - t * t).sign();
    return sign == Sign::Positive   ? CurveKind::Hyperbola
           : sign == Sign::Negative ? CurveKind::Ellipse
                                    : CurveKind::Parabola;
}

AxialConic::AxialConic(const RadialBaseProblem& problem, const AxialEquation& f, const AxialEquation& g) {
    const auto rounded = [&](const AxialEquation& e) {
        const Vec3 b = problem.chart.turn * Vec3(nearest(e.b[0]), nearest(e.b[1]), nearest(e.b[2]));
        const double b0 = nearest(e.b0), scale = 1 / std::hypot(b.norm(), b0);
        return Equation{scale * b, scale * b0, scale * nearest(e.k)};
    };
    equations_ = {rounded(f), rounded(g)};
    apart_ = {equations_[0], rounded(told_from(f, g))};
}

bool is_pair_of_lines(const AxialEquation& f, const AxialEquation& g, double size) {
    const AxialEquation h = told_from(f, g);
    const double c = size * nearest(f.b[1] * h.k - h.b[1] * f.k);
    constexpr double known =
        0x1p-48;  // output accuracy: how well a turned base's planes know where they meet it
    return std::abs(c) <= known * magnitude(f, size) * magnitude(h, size);
}

std::array<DistancePlane, 2> AxialConic::planes(const Equations& equations) {
    std::array<DistancePlane, 2> result;
    for (int i = 0; i < 2; ++i) {
        const Equation& e = equations[i];
        const double length = e.b.norm();
        result[i] = {{e.b.x(), e.b.y(), e.b.z(), e.b0}, e.k, (length - e.b0) * (length + e.b0)};
    }
    return result;
}

Vector4d AxialConic::at(const Vec3& normal) const {
    Matrix2d rows;
    Vector2d k;
    for (int i = 0; i < 2; ++i) {
        const Equation& e = apart_[i];
        rows.row(i) << e.b.dot(normal) + e.b0, e.b.y();
        k[i] = e.k;
    }
    const Vector2d ty = solution(rows, k);
    return {ty[0] * normal.x(), ty[1], ty[0] * normal.z(), ty[0]};
}

ConicSpan AxialConic::between(const Vector4d& from, const Vector4d& to) const {
    const Vec3 chord(from.x() / from.w() + to.x() / to.w(), 0, from.z() / from.w() + to.z() / to.w());
    const double cosine = 0.5 * chord.norm(), t = std::sqrt(from.w() * to.w());
    const Vec3 p = t / (2 * cosine) * chord;
    Matrix2d rows;
    Vector2d rest;
    for (int i = 0; i < 2; ++i) {
        const Equation& e = apart_[i];
        rows.row(i) << e.b.y(), -e.k;
        rest[i] = -(e.b.dot(p) + e.b0 * t * cosine);
    }
    const Vector2d yw = solution(rows, rest);
    return {from, {p.x(), yw[0], p.z(), t * cosine}, to, yw[1]};
}

}  // namespace vcell
