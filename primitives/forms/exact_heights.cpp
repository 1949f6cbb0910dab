#include "exact_heights.hpp"

#include <array>
#include <cmath>

#include "../objects/exact_space.hpp"

namespace vcell {

// The first convergent of the continued fraction [Knuth98, section 4.5.3] after which what remains is no more
// than noise.
std::optional<Fraction> simplest_near(Wide v) {
    constexpr int noise = -60, most_bits = 100;
    constexpr double largest_quotient = 0x1p64;  // of a remainder that is no noise
    Fraction before{0.0, 1.0}, convergent{1.0, 0.0};
    while (true) {
        const double quotient = std::round(v.approximation());
        if (!(std::abs(quotient) < largest_quotient)) return std::nullopt;
        const Exact a(quotient);
        const Fraction next{a * convergent.numerator + before.numerator,
                            a * convergent.denominator + before.denominator};
        before = convergent;
        convergent = next;
        if (convergent.denominator.sign() != Sign::Zero && convergent.denominator.exponent() > most_bits)
            return std::nullopt;
        v -= Wide(quotient);
        if (v.magnitude_exponent() < noise) break;
        v = Wide(1.0) / v;
    }
    if (convergent.denominator.sign() == Sign::Negative)
        convergent = {-convergent.numerator, -convergent.denominator};
    return convergent;
}

namespace {

// c - 2 b r - a r^2 = 0 and its partial derivatives, all times one positive number.
struct Equation {
    HeightEquation at, x, y;
    bool has_root = false;         // c may differ from 0 where a does
    bool is_smaller_root = false;  // of what is hollow
};

Equation circular_equation(const ExactForm& f, const RationalPoint& p) {
    const auto& [x, y, w] = p;
    const Exact two(2.0), two_w = two * w;
    return {{two * (f.K * (x * x + y * y) + (f.A * x + f.B * y + f.C * w) * w), w * w * f.W, Exact()},
            {two_w * (two * f.K * x + f.A * w), Exact(), Exact()},
            {two_w * (two * f.K * y + f.B * w), Exact(), Exact()}};
}

// Lengths times s, of the point, the axis and the radius; the height is left as it is.
Equation cylinder_equation(const ExactCylinder& f, const RationalPoint& p) {
    const Exact &w = p.w, s = f.unit * w;
    const ExactVector a(f.ax, f.ay, f.az), m(f.unit * p.x - w * f.px, f.unit * p.y - w * f.py, -(w * f.pz));
    const Exact rho = w * f.rho, norm = dot(a, a), M = norm - f.sine * f.sine, along = dot(m, a),
                twice_s = 2.0 * s, ss = s * s;
    return {{M * dot(m, m) - norm * rho * rho - along * along, s * (norm * rho - M * m.z + along * f.steep),
             ss * f.steep * f.steep},
            {twice_s * (M * m.x - along * a.x), ss * a.x * f.steep, Exact()},
            {twice_s * (M * m.y - along * a.y), ss * a.y * f.steep, Exact()},
            f.steep.sign() != Sign::Zero,
            rho.sign() == Sign::Negative || f.sine.sign() == Sign::Positive};
}

// n, W and their derivatives are those of radial_form.hpp times w^2, and all of the equation is times w^4.
Equation radial_equation(const RadialForm& f, Chart chart, const RationalPoint& p) {
    const Exact &w = p.w, &y = p.y, zero, two(2.0), ww = w * w, two_w = two * w, two_ww = two * ww;
    const bool is_back = chart.is_cylinder() && p.x > w;
    const Exact x = is_back ? p.x - two_w : p.x, side = is_back ? -1.0 : 1.0,
                across = chart.is_sphere() ? y : zero, W = ww + x * x + across * across, Wx = two_w * x,
                Wy = two_w * across;
    const std::array<Exact, 3> n{side * Wx, Wy, side * (two_ww - W)}, nx{side * two_ww, zero, -(side * Wx)},
        ny{zero, chart.is_sphere() ? two_ww : zero, -Wy};
    const auto dot = [](const std::array<Exact, 3>& u, const std::array<Exact, 3>& v) {
        return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    };
    const Exact slope = w * y * f.slope, A = f.a0 * W + dot(f.a, n), Ax = f.a0 * Wx + dot(f.a, nx),
                Ay = f.a0 * Wy + dot(f.a, ny);
    const Exact of_square(f.is_hollow ? -1.0 : 1.0), signed_A = of_square * A;
    return {{-(signed_A * A), -(ww * (f.b0 * W + dot(f.b, n)) + slope * A),
             -(ww * (ww * f.c[0] + y * (w * f.c[1] + y * f.c[2])))},
            {-(two * signed_A * Ax), -(ww * (f.b0 * Wx + dot(f.b, nx)) + slope * Ax), Exact()},
            {-(two * signed_A * Ay), -(ww * (f.b0 * Wy + dot(f.b, ny) + f.slope * A) + slope * Ay),
             -(ww * w * (w * f.c[1] + two * y * f.c[2]))},
            f.has_root()};
}

Equation equation(const FormFamily& family, FormId f, const RationalPoint& p) {
    if (family.is_circular(f)) return circular_equation(family.exact(f), p);
    if (!family.radial.empty()) return radial_equation(family.radial_form(f), family.chart, p);
    return cylinder_equation(exact_cylinder(family.cylinder(f)), p);
}

// A height as (a + b sqrt(c)) / den, den > 0.
struct ExactHeight {
    OneRoot value;
    Exact den;
};

// (-b +- sqrt(b^2 + a c)) / a, or the solution of what is linear but for r = 0.
ExactHeight height(const Equation& e) {
    const auto& [c, b, a] = e.at;
    const auto over = [](const OneRoot& value, const Exact& den) {
        if (den.sign() == Sign::Negative) return ExactHeight{{-value.a, -value.b, value.c}, -den};
        return ExactHeight{value, den};
    };
    if (e.has_root && a.sign() != Sign::Zero)
        return over({-b, e.is_smaller_root ? -1.0 : 1.0, b * b + a * c}, a);
    return a.sign() == Sign::Zero ? over({c, Exact(), Exact()}, b + b)
                                  : over({-(b + b), Exact(), Exact()}, a);
}

// r_x, r_y and 1 times a common factor, where the height is r.
struct Gradient {
    OneRoot x, y, unit;
};

Gradient gradient(const Equation& e, const ExactHeight& r) {
    const OneRoot& v = r.value;
    const auto number = [&](const Exact& n) { return OneRoot{n, Exact(), v.c}; };
    const OneRoot v2 = v * v;
    const Exact den2 = r.den * r.den, two_den = 2.0 * r.den;
    const auto along = [&](const HeightEquation& d) {
        return number(d.c * den2) - two_den * d.b * v - d.a * v2;
    };
    return {along(e.x), along(e.y), two_den * (number(e.at.b * r.den) + e.at.a * v)};
}

std::vector<Gradient> gradients(const FormFamily& family, std::span<const FormId> forms,
                                const RationalPoint& p) {
    const ExactHeight r = height(equation(family, forms[0], p));
    std::vector<Gradient> all;
    for (const FormId f : forms) all.push_back(gradient(equation(family, f, p), r));
    return all;
}

}  // namespace

HeightEquation height_equation(const FormFamily& family, FormId f, const RationalPoint& p) {
    return equation(family, f, p).at;
}

std::optional<RationalPoint> rational_near(const Wide& x, const Wide& y, double extent) {
    const int exponent = std::ilogb(extent);
    const Wide scale(std::ldexp(1.0, -exponent));
    const auto p = simplest_near(scale * x), q = simplest_near(scale * y);
    if (!p || !q) return std::nullopt;
    RationalPoint point{(p->numerator * q->denominator).scaled(exponent),
                        (q->numerator * p->denominator).scaled(exponent), p->denominator * q->denominator};
    // Dyadic numbers need no denominator.
    const Interval w = point.w.enclosure();
    int power = 0;
    if (w.lower() == w.upper() && std::frexp(w.lower(), &power) == 0.5)
        point = {point.x.scaled(1 - power), point.y.scaled(1 - power), 1.0};
    return point;
}

std::array<Interval, 2> enclosure(const RationalPoint& p) {
    if (p.w == Exact(1.0)) return {p.x.enclosure(), p.y.enclosure()};
    const Interval w = p.w.enclosure();
    return {p.x.enclosure() / w, p.y.enclosure() / w};
}

bool is_on_line(const RationalPoint& p, double a, double b, double c) {
    return (a * p.x + b * p.y + c * p.w).sign() == Sign::Zero;
}

Sign compare_exactly(const FormFamily& family, FormId f, FormId g, const RationalPoint& p) {
    const ExactHeight a = height(equation(family, f, p)), b = height(equation(family, g, p));
    return compare(a.value, a.den, b.value, b.den);
}

bool all_tie(const FormFamily& family, std::span<const FormId> forms, const RationalPoint& p) {
    for (const FormId f : forms.subspan(1))
        if (compare_exactly(family, forms[0], f, p) != Sign::Zero) return false;
    return true;
}

bool have_gradients_in_line(const FormFamily& family, std::span<const FormId> forms, const RationalPoint& p) {
    if (forms.size() < 3) return true;
    const auto g = gradients(family, forms, p);
    return is_zero(g[0].x * (g[1].y * g[2].unit - g[2].y * g[1].unit) -
                   g[0].y * (g[1].x * g[2].unit - g[2].x * g[1].unit) +
                   g[0].unit * (g[1].x * g[2].y - g[2].x * g[1].y));
}

bool have_equal_slopes(const FormFamily& family, FormId f, FormId g, const RationalPoint& p, double a,
                       double b) {
    const auto d = gradients(family, std::array{f, g}, p);
    const auto slope = [&](const Gradient& of) { return Exact(b) * of.x - Exact(a) * of.y; };
    return is_zero(slope(d[0]) * d[1].unit - slope(d[1]) * d[0].unit);
}

bool have_equal_gradients(const FormFamily& family, FormId f, FormId g, const RationalPoint& p) {
    return have_equal_slopes(family, f, g, p, 1, 0) && have_equal_slopes(family, f, g, p, 0, 1);
}

}  // namespace vcell
