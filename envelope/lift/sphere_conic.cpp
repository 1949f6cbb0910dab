#include "sphere_conic.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "../../core/threads.hpp"
#include "../../primitives/objects/exact_space.hpp"
#include "radial_patch.hpp"

namespace vcell::radial {

namespace {

using Eigen::Vector4d;

using roundoff::u;

// Away from the base.
Plane facing(const Plane& plane) {
    return {plane.point, plane.normal.dot(plane.point) < 0 ? Vec3(-plane.normal) : plane.normal};
}

Functional functional(const RadialBaseProblem& problem, FormId f) {
    if (const auto* sphere = std::get_if<Sphere>(&problem.objects[f])) {
        const double square = ball_power(problem, f);
        return {sphere->center, sphere->radius - problem.chart.radius, square, 0.5 * square};
    }
    if (const auto* vessel = std::get_if<HollowSphere>(&problem.objects[f])) {
        const double square = ball_power(problem, f);
        return {-vessel->center, vessel->radius + problem.chart.radius, -square, 0.5 * square};
    }
    const Plane plane = facing(std::get<Plane>(problem.objects[f]));
    const double k = plane.normal.dot(plane.point), length = plane.normal.norm();
    if (is_wall(problem, f)) return {plane.normal, 0, length * length, k};
    return {plane.normal, length, 0, k + problem.chart.radius * length};
}

// This is a positive multiple of the functional, in the chart's frame, but for k. It is made of the form's
// exact coefficients: where places are rounded, objects that all but coincide are one.
struct ExactFunctional {
    ExactVector b;
    Exact b0, square;
};
ExactFunctional exact_functional(const RadialBaseProblem& problem, FormId f) {
    const auto [K, A, B, C, W] = problem.family.exact(f);
    const ExactVector b{-A, -B, K - C};
    const Exact b0 = -(K + C);
    const bool is_null = std::holds_alternative<Plane>(problem.objects[f]) && !is_wall(problem, f);
    return {b, b0, is_null ? Exact() : dot(b, b) - b0 * b0};
}

}  // namespace

// ---- Kinds ------------------------------------------------------------------------------------------

// The plane in which a sphere's and a plane's or two such heights agree cuts a conic from either bisector.
CurveKind SphereConicKind::operator()(FormId f, FormId g, const Approximate& p, const Approximate& q) {
    // b0 = 0: the bisector is a plane.
    if (is_flat(problem_, f) && is_flat(problem_, g)) return CurveKind::Line;
    // The plane lies across the axis of both bisectors, which are surfaces of revolution (a sphere about any
    // axis).
    if (are_parallel(f, g, p.b, q.b)) return CurveKind::Circle;
    const Sign sign = gram_sign(f, g, p, q);
    return sign == Sign::Positive   ? CurveKind::Hyperbola
           : sign == Sign::Negative ? CurveKind::Ellipse
                                    : CurveKind::Parabola;
}

bool SphereConicKind::are_parallel(FormId f, FormId g, const Vec3& p, const Vec3& q) {
    if (p.isZero(0) || q.isZero(0)) return true;
    if (p.cross(q).cwiseAbs().maxCoeff() > 4 * u * p.norm() * q.norm()) {
        ++decisions_.by_double;
        return false;
    }
    ++decisions_.by_exact;
    return cross(exact_functional(problem_, f).b, exact_functional(problem_, g).b).is_zero();
}

Sign SphereConicKind::gram_sign(FormId f, FormId g, const Approximate& p, const Approximate& q) {
    const double inner = p.b.dot(q.b) - p.b0 * q.b0;
    const double determinant = p.square * q.square - inner * inner;
    // No term of `inner` or of a square exceeds the product of these lengths; each carries four roundings
    // or fewer, as does its sum, and the determinant as many again.
    const double scale = (p.b.squaredNorm() + p.b0 * p.b0) * (q.b.squaredNorm() + q.b0 * q.b0);
    if (std::abs(determinant) > 64 * u * scale) {
        ++decisions_.by_double;
        return sign_of(determinant);
    }
    ++decisions_.by_exact;
    const auto P = exact_functional(problem_, f), R = exact_functional(problem_, g);
    const Exact exact_inner = dot(P.b, R.b) - P.b0 * R.b0;
    return (P.square * R.square - exact_inner * exact_inner).sign();
}

// ---- Points on bisectors ----------------------------------------------------------------------------

Hyperplane::Hyperplane(const RadialBaseProblem& problem, FormId f)
    : functional_(radial::functional(problem, f)) {
    const auto& [b, b0, square, k] = functional_;
    const double scale = 1 / std::sqrt(b.squaredNorm() + b0 * b0);
    plane_.normal << scale * b, scale * b0;
    plane_.k = scale * k;
    plane_.power = scale * scale * square;
}

Hyperplanes::Hyperplanes(const RadialDiagram& of, unsigned threads)
    : planes_(of.problem.family.forms.size()) {
    if (planes_.empty()) return;
    IdVector<FormId, std::uint8_t> is_named(planes_.size(), 0);
    const auto name = [&](std::span<const FormId> label) {
        for (const FormId f : label)
            if (f.value < planes_.size()) is_named[f] = 1;
    };
    for (const EdgeId e : of.diagram.edges.ids()) name(of.diagram.label(e));
    for (const VertexId v : of.diagram.vertices.ids()) name(of.diagram.label(v));
    for_ranges(planes_.size(), threads, [&](std::size_t begin, std::size_t end) {
        for (auto f = FormId{static_cast<std::uint32_t>(begin)}; f.value < end; ++f.value)
            if (is_named[f] != 0) planes_[f].emplace(of.problem, f);
    });
}

Vector4d moved(const Vector4d& x, double weight, const std::array<const Hyperplane*, 2>& planes) {
    const auto& [p, q] = planes;
    const double a = p->residual(x, weight), b = q->residual(x, weight), inner = p->normal().dot(q->normal());
    // The step only brings a control point nearer, its error is bounded afterwards: of planes within 2^-15
    // (of a radian) of each other the second would move it along both by rounding.
    constexpr double least_sine2 = 0x1p-30;
    const double determinant = 1 - inner * inner;
    if (determinant < least_sine2) return x - a * p->normal();
    return x - ((a - inner * b) * p->normal() + (b - inner * a) * q->normal()) / determinant;
}

Vector4d moved_on_cone(const Vector4d& x, const std::array<const Hyperplane*, 2>& planes) {
    const Vector4d y = moved(x, 1, planes);
    // Then it goes along the line in both hyperplanes that changes |p| - t most.
    const double length = y.head<3>().norm();
    const Vector4d slope(y.x() / length, y.y() / length, y.z() / length, -1);
    const Vector4d along = moved(slope, 0, planes);
    const double change = slope.dot(along);
    // Output accuracy: of a smaller change (a squared sine) of |p| - t the step would be rounding, divided by
    // it.
    constexpr double least_change = 0x1p-30;
    return change > least_change ? Vector4d(y - (length - y.w()) / change * along) : y;
}

Vector4d moved_to_meet(const Vector4d& x, const std::array<const Hyperplane*, 3>& planes) {
    Eigen::Matrix4d rows;
    Vector4d residual;
    for (int i = 0; i < 3; ++i) {
        rows.row(i) = planes[i]->normal();
        residual[i] = planes[i]->residual(x, 1);
    }
    const double length = x.head<3>().norm();
    rows.row(3) << x.head<3>().transpose() / length, -1;
    residual[3] = length - x.w();
    return x - rows.inverse() * residual;
}

// In the chart -1 / t is (K (1 - z) + A x + B y + C (1 + z)) / 2 W at the unit normal (x, y, z). So
// A x + B y + (C - K) z + (C + K) t = -2 W at the points (p, t), and two of these leave a plane through
// 0.
DistancePlane difference_plane(const RadialBaseProblem& problem, FormId f, FormId g) {
    const ExactForm F = problem.family.exact(f), G = problem.family.exact(g);
    const Exact A = F.A * G.W - G.A * F.W, B = F.B * G.W - G.B * F.W, C = F.C * G.W - G.C * F.W,
                K = F.K * G.W - G.K * F.W;
    const std::array n{A, B, C - K, C + K};
    long size = std::numeric_limits<long>::min();
    for (const Exact& x : n)
        if (x.sign() != Sign::Zero) size = std::max(size, x.exponent());
    const auto scaled = [size](const Exact& x, long power) {
        return x.scaled(-power * size).enclosure().mid();
    };
    Vector4d normal(scaled(n[0], 1), scaled(n[1], 1), scaled(n[2], 1), scaled(n[3], 1));
    const double length = normal.norm();
    normal.head<3>() = (problem.chart.turn * normal.head<3>()).eval();
    return {normal / length, 0, scaled(A * A + B * B - Exact(4.0) * C * K, 2) / (length * length)};
}

}  // namespace vcell::radial
