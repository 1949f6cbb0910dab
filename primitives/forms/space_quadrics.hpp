/// Forms as equations of degree two in space: with p the point at distance t from the foot, or over a plane
/// at height t over (p_x, p_y), in the coordinates of a chart (primitives/charts/chart.hpp), each is one in X
/// = (p, t, 1), solved by one t > 0 over every base point (circular_form.hpp, cylinder_form.hpp,
/// radial_form.hpp):
///
///     plane      K (x^2 + y^2) + A x + B y + C - W t = 0,  or  C(x, y) - 2 beta(x, y) t - A t^2 = 0
///     sphere     (C - K) p_z + A p_x + B p_y + (C + K) t + 2 W = 0, as 1 + x^2 + y^2 = 2 t / (t + p_z),
///                or c0 - 2 (b.p + b0 t) - (a.p)^2 = 0
///     cylinder   c0 + c1 y + c2 y^2 - 2 (b.p + b0 t + y slope a.p) - (a.p)^2 = 0
///
/// and so is the base: p_z = 0 (p holds no height there), |p|^2 = t^2, or p_x^2 + p_z^2 = t^2. A line of the
/// chart is an equation of degree one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/wide.hpp"
#include "form_family.hpp"

namespace vcell::space_quadrics {

constexpr std::size_t unknowns = 5;

using Linear = std::array<Exact, unknowns>;
/// Of y_i y_j, i <= j, in n variables: those without the last variable first, then those with it, its square
/// last. Row i of what comes first begins after those of all smaller i.
using Quadric = std::vector<Exact>;

constexpr std::size_t terms(std::size_t n) { return n * (n + 1) / 2; }
std::size_t term(std::size_t n, std::size_t i, std::size_t j);
/// Adds factor f g, of n variables.
void add_product(Quadric& q, const Exact& factor, std::span<const Exact> f, std::span<const Exact> g);

Quadric base_equation(const FormFamily& family);
Quadric equation(const FormFamily& family, FormId f);
/// Encloses X where heights over a box of the chart are in a range, t > 0; of what was given, where forms are
/// beside that.
std::array<Interval, unknowns> places(const FormFamily& family, const Interval& x, const Interval& y,
                                      const Interval& height);
/// (p, t) over a chart point with many digits, where a height is met; none over a plane, where it lies there.
std::optional<std::array<Wide, 4>> point_over(const FormFamily& family, const Wide& x, const Wide& y,
                                              const Wide& height);
/// The line a x + b y + c = 0 of the chart. None of those that run along the axis of a cylinder or obliquely
/// to it.
std::optional<Linear> line_equation(const FormFamily& family, double a, double b, double c);

/// Would X be the other root of the equation of a hollow cylinder or cone over a plane, which has beta + A t
/// above 0? No point of the envelope is.
template <class Coordinate>
bool is_behind_tip(const FormFamily& family, const std::array<Coordinate, unknowns>& p) {
    return std::ranges::any_of(family.cylinders, [&](const CylinderForm& f) {
        if (!f.is_hollow()) return false;
        const ExactCylinder c = exact_cylinder(f);
        const Exact norm = c.ax * c.ax + c.ay * c.ay + c.az * c.az, M = norm - c.sine * c.sine,
                    at_point = c.ax * c.px + c.ay * c.py + c.az * c.pz;
        const Exact by_x = c.unit * c.steep * c.ax, by_y = c.unit * c.steep * c.ay,
                    by_t = c.unit * c.steep * c.steep, rest = norm * c.rho + M * c.pz - c.steep * at_point;
        return sign(by_x * p[0] + by_y * p[1] + by_t * p[3] + rest * p[4]) == Sign::Positive;
    });
}

/// The chart point of X by quotients of coordinates. None where it is the pole, or t is not positive, or
/// beyond a tip.
template <class Number, class Coordinate, class Quotient>
std::optional<std::array<Number, 2>> chart_point(const FormFamily& family,
                                                 const std::array<Coordinate, unknowns>& p,
                                                 Quotient&& quotient) {
    using Point = std::array<Number, 2>;
    if (sign(p[4]) != Sign::Positive || sign(p[3]) != Sign::Positive) return std::nullopt;
    if (is_behind_tip(family, p)) return std::nullopt;
    const Chart chart = family.compared_over();
    if (chart.is_plane()) return Point{quotient(p[0], p[4]), quotient(p[1], p[4])};
    const Coordinate ahead = p[3] + p[2], behind = p[3] - p[2];
    if (chart.is_sphere()) {
        if (sign(ahead) != Sign::Positive) return std::nullopt;
        return Point{quotient(p[0], ahead), quotient(p[1], ahead)};
    }
    const Number y = quotient(p[1], p[4]);
    if (sign(p[2]) != Sign::Negative) return Point{quotient(p[0], ahead), y};
    return Point{Number(2.0) - quotient(p[0], behind), y};
}

}  // namespace vcell::space_quadrics
