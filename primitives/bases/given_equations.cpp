#include "given_equations.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include "../forms/space_quadrics.hpp"

namespace vcell {

namespace {

using space_quadrics::add_product;
using space_quadrics::Linear;
using space_quadrics::Quadric;
using space_quadrics::unknowns;

Quadric zero() { return Quadric(space_quadrics::terms(unknowns)); }

// p less a point, and t + r.
std::array<Linear, 3> way_from(const Vec3& point) {
    std::array<Linear, 3> way;
    for (int k = 0; k < 3; ++k) {
        way[k][k] = 1.0;
        way[k][4] = -Exact(point[k]);
    }
    return way;
}
Linear reach(double radius) {
    Linear l;
    l[3] = 1.0;
    l[4] = radius;
    return l;
}

Quadric ball_equation(const Sphere& ball) {
    Quadric q = zero();
    for (const Linear& l : way_from(ball.center)) add_product(q, 1.0, l, l);
    const Linear r = reach(ball.radius);
    add_product(q, -1.0, r, r);
    return q;
}

// |a|^2 |m|^2 - (a.m)^2 - |a|^2 (t + r)^2.
Quadric tube_equation(const Cylinder& tube) {
    Quadric q = zero();
    const std::array<Linear, 3> way = way_from(tube.point);
    Exact norm;
    Linear along;
    for (int k = 0; k < 3; ++k) {
        const Exact a = tube.axis[k];
        norm += a * a;
        for (std::size_t i = 0; i < unknowns; ++i) along[i] += a * way[k][i];
    }
    for (const Linear& l : way) add_product(q, norm, l, l);
    add_product(q, -1.0, along, along);
    const Linear r = reach(tube.radius);
    add_product(q, -norm, r, r);
    return q;
}

Quadric side_equation(const WorldSide& side) {
    Quadric q = zero();
    Linear l, one;
    one[4] = 1.0;
    l[static_cast<std::size_t>(side.axis)] = 1.0;
    l[4] = -Exact(side.bound);
    add_product(q, 1.0, l, one);
    return q;
}

std::optional<Quadric> equation_of(const GivenForm& form) {
    if (const auto* side = std::get_if<WorldSide>(&form)) return side_equation(*side);
    const auto* object = std::get_if<Object>(&form);
    if (object == nullptr) return std::nullopt;
    if (const auto* ball = std::get_if<Sphere>(object)) return ball_equation(*ball);
    if (const auto* tube = std::get_if<Cylinder>(object)) return tube_equation(*tube);
    return std::nullopt;
}

}  // namespace

FormFamily::GivenEquations given_equations(const Cylinder& base, const BaseFrame& frame,
                                           std::vector<GivenForm> forms) {
    const auto place = [frame, radius = base.radius](const std::array<Interval, 3>& p, const Interval& t) {
        constexpr double rounding = 0x1p-40;  // far more than that of the frame, and what the base turned by
        std::array<Interval, 5> X;
        double size = frame.origin.cwiseAbs().maxCoeff();
        for (const Interval& x : p) size += x.magnitude();
        const Interval around(-rounding * size, rounding * size);
        for (int k = 0; k < 3; ++k) {
            X[k] = Interval(frame.origin[k]) + around;
            for (int i = 0; i < 3; ++i) X[k] = X[k] + frame.rotation(i, k) * p[static_cast<std::size_t>(i)];
        }
        X[3] = t - Interval(radius) + around;
        X[4] = Interval(1.0);
        return X;
    };
    return {tube_equation(base), [forms = std::move(forms)](FormId f) { return equation_of(forms[f.value]); },
            place};
}

}  // namespace vcell
