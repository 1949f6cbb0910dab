/// Heights around spheres and cylinders from their definition, in 100 digits, and scenes to ask for them.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <limits>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "problem_sites.hpp"
#include "reference.hpp"
#include "test_support.hpp"

namespace vcell::radial_base {

using vcell::Real;
using vcell::real;

inline constexpr double u = std::numeric_limits<double>::epsilon() / 2;

using RealVector = std::array<Real, 3>;

inline RealVector real(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
inline Real dot(const RealVector& p, const RealVector& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }
inline RealVector along(const RealVector& p, const Real& t, const RealVector& d) {
    return {p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]};
}

/// Signed for balls and cylinders (negative inside), as the additively weighted diagram wants it.
inline Real distance(const Object& object, const RealVector& p) {
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const RealVector m = along(p, -1, real(sphere->center));
        return sqrt(dot(m, m)) - sphere->radius;
    }
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const RealVector n = real(plane->normal);
        return abs(dot(n, along(p, -1, real(plane->point)))) / sqrt(dot(n, n));
    }
    const auto& cylinder = std::get<Cylinder>(object);
    const RealVector a = real(cylinder.axis), m = along(p, -1, real(cylinder.point));
    const Real s = dot(m, a);
    return sqrt(abs(dot(m, m) - s * s / dot(a, a))) - cylinder.radius;
}

inline Scene scene_of(const Object& base, std::vector<Object> objects, double half = 10) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    Vec3 middle = Vec3::Zero();
    if (const auto* sphere = std::get_if<Sphere>(&base)) middle = sphere->center;
    if (const auto* cylinder = std::get_if<Cylinder>(&base)) middle = cylinder->point;
    scene.box = {middle - Vec3::Constant(half), middle + Vec3::Constant(half)};
    return scene;
}

inline RadialBaseProblem problem_of(const Scene& scene) {
    validate(scene);
    return radial_base_problem(scene);
}

inline InputError error_of(const Scene& scene) {
    try {
        problem_of(scene);
    } catch (const InputError& error) {
        return error;
    }
    FAIL("the scene was accepted");
    std::abort();
}

/// 1 / distance by the exact coefficients at a chart point, and by the doubles of circular forms.
inline Real nearness(const FormFamily& family, FormId f, const Vec2& p) {
    const bool stereographic = family.chart.is_sphere();
    const bool front = stereographic || p.x() <= 1;
    const Real x = front ? p.x() : p.x() - 2, y = p.y();
    const Real r2 = x * x + (stereographic ? Real(y * y) : Real(0)), W = 1 + r2;
    if (family.is_circular(f)) {
        const ExactForm e = family.exact(f);
        return -(real(e.K) * r2 + real(e.A) * x + real(e.B) * y + real(e.C)) / real(e.W) / W;
    }
    const Real sign = front ? 1 : -1;
    const RealVector n{sign * 2 * x, stereographic ? Real(2 * y) : Real(0), sign * (1 - r2)};
    const RadialForm& q = family.radial_form(f);
    const Real A = dot({real(q.a[0]), real(q.a[1]), real(q.a[2])}, n);
    Real B = real(q.b0) * W + dot({real(q.b[0]), real(q.b[1]), real(q.b[2])}, n);
    Real C = real(q.c[0]);
    if (!stereographic) {
        B += y * real(q.slope) * A;
        C += y * (real(q.c[1]) + y * real(q.c[2]));
    }
    // A tube that pierces the base has C less than 0, and B as well there.
    const Real square = B * B + A * A * C;
    REQUIRE((C > 0 || (B < 0 && square >= 0)));
    return B < 0 ? A * A / (sqrt(square) - B) / W : (B + sqrt(square)) / C / W;
}

/// The form whose sites include this one.
inline FormId form_of(const RadialBaseProblem& problem, Site site) {
    for (const FormId f : problem.sites.ids())
        if (std::ranges::find(problem.sites[f], site) != problem.sites[f].end()) return f;
    return {};
}

/// The signed distance to the object falls behind t - R0 exactly where the form says, on the ray along
/// `normal` from `origin`.
inline void check_height(const RealVector& origin, const RealVector& normal, double radius,
                         const Object& object, const Real& q, double scale, double tolerance) {
    const auto ahead = [&](const Real& t) {
        return Real(distance(object, along(origin, t, normal)) - (t - radius));
    };
    const Real far = 1e9 * scale;
    if (q * far < 1) {
        CHECK(ahead(far * (1 - Real(tolerance))) > -tolerance * far);
        return;
    }
    // A far point moves by t^2 / scale times what its direction does.
    const Real t = 1 / q, slack = tolerance * (scale + t + t * t / scale);
    const Real noise = tolerance * (scale + t);
    CHECK(ahead(t - slack) >= -noise);
    CHECK(ahead(t + slack) <= noise);
}

struct Random {
    std::mt19937_64 rng{test_seed()};
    double unit() { return std::uniform_real_distribution(-1.0, 1.0)(rng); }
    Vec3 vector() { return {unit(), unit(), unit()}; }
    Vec3 direction() {
        for (;;)
            if (const Vec3 v = vector(); v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
    double pick(std::initializer_list<double> values) { return values.begin()[rng() % values.size()]; }
};

/// A ball, a plane or a cylinder that stays clear of |p - center| < reach, or overlaps it a little.
inline Object random_object(Random& r, const Vec3& center, double reach, int kind) {
    const Vec3 d = r.direction();
    const double far = reach * (1.2 + std::abs(r.unit()));
    if (kind == 0) return Sphere{center + far * d, 0.5 * reach * std::abs(r.unit())};
    if (kind == 1) return Plane{center + far * d, r.pick({-3, 0.01, 1}) * d};
    return Cylinder{center + far * d, 7 * d.cross(r.direction()), 0.5 * reach * std::abs(r.unit())};
}

/// A ball, or a tube for odd kinds, whose centre or axis passes another tube's axis by 0.8 to 1.8.
inline Object random_round_beside(Random& r, const Cylinder& tube, int kind) {
    const Vec3 out = tube.axis.cross(r.direction()).normalized(),
               point = tube.point + (0.8 + std::abs(r.unit())) * out + r.unit() * tube.axis.normalized();
    const double radius = 0.3 * std::abs(r.unit());
    if (kind % 2 == 0) return Sphere{point, radius};
    return Cylinder{point, out.cross(r.direction()), radius};
}

}  // namespace vcell::radial_base
