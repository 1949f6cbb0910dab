#include "space_quadrics.hpp"

#include <utility>

namespace vcell::space_quadrics {

namespace {

Quadric zero_quadric() { return Quadric(terms(unknowns)); }

Linear unit(std::size_t i) {
    Linear l;
    l[i] = 1.0;
    return l;
}

Quadric circular_equation(const ExactForm& f, bool over_plane) {
    Quadric q = zero_quadric();
    const Linear one = unit(4);
    if (over_plane) {
        add_product(q, f.K, unit(0), unit(0));
        add_product(q, f.K, unit(1), unit(1));
        add_product(q, 1.0, Linear{f.A, f.B, Exact(), -f.W, f.C}, one);
    } else {
        add_product(q, 1.0, Linear{f.A, f.B, f.C - f.K, f.C + f.K, 2.0 * f.W}, one);
    }
    return q;
}

// Lengths times the cylinder's unit.
Quadric cylinder_equation(const ExactCylinder& f) {
    Quadric q = zero_quadric();
    const Exact norm = f.ax * f.ax + f.ay * f.ay + f.az * f.az, M = norm - f.sine * f.sine;
    const Exact zero;
    const std::array<Linear, 3> m{Linear{f.unit, zero, zero, zero, -f.px},
                                  Linear{zero, f.unit, zero, zero, -f.py},
                                  Linear{zero, zero, zero, zero, -f.pz}};
    Linear along;
    for (std::size_t k = 0; k < unknowns; ++k) along[k] = f.ax * m[0][k] + f.ay * m[1][k] + f.az * m[2][k];
    for (const Linear& l : m) add_product(q, M, l, l);
    const Linear one = unit(4), t = unit(3);
    add_product(q, -(norm * f.rho * f.rho), one, one);
    add_product(q, -1.0, along, along);
    add_product(q, -2.0 * f.unit * (norm * f.rho + M * f.pz), t, one);
    add_product(q, -2.0 * f.unit * f.steep, t, along);
    add_product(q, -(f.unit * f.unit * f.steep * f.steep), t, t);
    return q;
}

Quadric radial_equation(const RadialForm& f, Chart chart) {
    Quadric q = zero_quadric();
    const Linear one = unit(4), y = unit(1);
    const bool is_cylinder = chart.is_cylinder();
    const Linear a{f.a[0], is_cylinder ? Exact() : f.a[1], f.a[2], f.a0, Exact()};
    add_product(q, f.c[2], y, y);
    add_product(q, -2.0 * f.slope, y, a);
    add_product(q, f.is_hollow ? 1.0 : -1.0, a, a);
    add_product(
        q, 1.0,
        Linear{-2.0 * f.b[0], is_cylinder ? f.c[1] : -2.0 * f.b[1], -2.0 * f.b[2], -2.0 * f.b0, f.c[0]}, one);
    return q;
}

}  // namespace

std::size_t term(std::size_t n, std::size_t i, std::size_t j) {
    if (i > j) std::swap(i, j);
    if (j + 1 == n) return terms(n - 1) + i;
    return i * (n - 1) - i * (i + 1) / 2 + j;
}

void add_product(Quadric& q, const Exact& factor, std::span<const Exact> f, std::span<const Exact> g) {
    if (is_zero(factor)) return;
    const std::size_t n = f.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (is_zero(f[i])) continue;
        const Exact scaled = factor * f[i];
        for (std::size_t j = 0; j < n; ++j)
            if (!is_zero(g[j])) q[term(n, i, j)] += scaled * g[j];
    }
}

Quadric base_equation(const FormFamily& family) {
    const Chart chart = family.compared_over();
    Quadric q = zero_quadric();
    if (chart.is_plane()) {
        add_product(q, 1.0, unit(2), unit(4));
        return q;
    }
    add_product(q, 1.0, unit(0), unit(0));
    if (chart.is_sphere()) add_product(q, 1.0, unit(1), unit(1));
    add_product(q, 1.0, unit(2), unit(2));
    add_product(q, -1.0, unit(3), unit(3));
    return q;
}

Quadric equation(const FormFamily& family, FormId f) {
    const Chart chart = family.compared_over();
    if (family.is_circular(f)) return circular_equation(family.exact(f), chart.is_plane());
    return chart.is_plane() ? cylinder_equation(exact_cylinder(family.cylinder(f)))
                            : radial_equation(family.radial_form(f), chart);
}

namespace {

template <class T>
struct PointAt {
    std::array<T, 3> p;
    T t;
};

// A sphere's or a cylinder's ray over a chart point meets (p, t) where heights are -1 / t.
template <class T>
PointAt<T> point_at(const Chart& chart, const T& x, const T& y, const T& height, bool is_back) {
    const T t = T(-1.0) / height;
    std::array<T, 3> p = chart.normal(x, y, is_back);
    for (T& part : p) part = t * part;
    if (chart.is_cylinder()) p[1] = y;
    return {p, t};
}

}  // namespace

std::array<Interval, unknowns> places(const FormFamily& family, const Interval& x, const Interval& y,
                                      const Interval& height) {
    const Chart chart = family.compared_over();
    const Interval one(1.0);
    if (chart.is_plane()) return {x, y, Interval(0.0), height, one};
    const auto [p, t] = point_at(chart, x, y, height, chart.is_back(x.upper()));
    if (!family.given) return {p[0], p[1], p[2], t, one};
    return family.given->place({p[0], chart.is_cylinder() ? family.axial_unit * y : p[1], p[2]}, t);
}

std::optional<std::array<Wide, 4>> point_over(const FormFamily& family, const Wide& x, const Wide& y,
                                              const Wide& height) {
    const Chart chart = family.compared_over();
    if (chart.is_plane()) return std::nullopt;
    const auto [p, t] = point_at(chart, x, y, height, chart.is_back(x.approximation()));
    return std::array<Wide, 4>{p[0], p[1], p[2], t};
}

std::optional<Linear> line_equation(const FormFamily& family, double a, double b, double c) {
    const Chart chart = family.compared_over();
    const Exact zero;
    if (chart.is_plane()) return Linear{a, b, zero, zero, c};
    if (chart.is_sphere()) return Linear{a, b, c, c, zero};
    if (a != 0) return std::nullopt;
    return Linear{zero, b, zero, zero, c};  // across the axis
}

}  // namespace vcell::space_quadrics
