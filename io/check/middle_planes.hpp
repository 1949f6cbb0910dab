/// Planes in which two tubes of one radius whose axes cross are equally near.
///
/// With axes a and b of length one through c the squares of the distances from both axes differ by
/// (b (p - c))^2 - (a (p - c))^2 = ((b + a) (p - c)) ((b - a) (p - c)). Next to where both planes meet, over
/// the crossing, the bisectors of a base and the tubes are nearly one; the one plane tells them apart.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "../../core/numbers/exact.hpp"
#include "nets.hpp"
#include "space.hpp"

namespace vcell::check {

struct MiddlePlane {
    Vector<Interval> center, normal;  ///< of any length

    /// normal (p - center) all over a net. Pre: weights are positive.
    Interval over(const Net& net) const {
        std::optional<Interval> all;
        for (int i = 0; i <= net.degree_s(); ++i)
            for (int j = 0; j <= net.degree_t(); ++j) {
                const Interval here = dot(normal, net.control(i, j) - center);
                all = all ? hull(*all, here) : here;
            }
        return *all;
    }
};

/// None unless both are tubes of one radius whose axes cross, exactly.
inline std::optional<std::array<MiddlePlane, 2>> middle_planes(const Object& first, const Object& second) {
    const auto *f = std::get_if<Cylinder>(&first), *g = std::get_if<Cylinder>(&second);
    if (!f || !g || f->radius != g->radius) return std::nullopt;
    const Vec3 rough = f->axis.cross(g->axis), between = g->point - f->point;
    // Exact numbers need not be asked where doubles tell.
    constexpr double blur = 0x1p-40;
    if (!(std::abs(rough.dot(between)) <=
          blur * f->axis.norm() * g->axis.norm() * (f->point.norm() + g->point.norm())))
        return std::nullopt;
    const auto exact = [](const Vec3& v) { return to_vector<Exact>(v); };
    const Vector<Exact> across = cross(exact(f->axis), exact(g->axis));
    if (dot(across, exact(g->point) - exact(f->point)).sign() != Sign::Zero ||
        dot(across, across).sign() == Sign::Zero)
        return std::nullopt;
    const Vector<Interval> a = to_vector<Interval>(f->axis), b = to_vector<Interval>(g->axis),
                           p = to_vector<Interval>(f->point), normal = cross(a, b);
    const Interval along = dot(cross(to_vector<Interval>(g->point) - p, b), normal) / square(normal);
    const Vector<Interval> center = p + along * a, u = direction(a, sqrt(square(a))),
                           v = direction(b, sqrt(square(b)));
    return std::array{MiddlePlane{center, v + u}, MiddlePlane{center, v - u}};
}

}  // namespace vcell::check
