#include "height_conics.hpp"

#include <array>

#include "quadratic_form.hpp"

namespace vcell {

namespace {

struct Height {
    QuadraticForm form;  // of (x, y, z, 1)
    Exact scale;         // of x^2 + y^2 + z^2 before z^2 cancels: M of a cylinder
};

// Over a plane z is t, and the equation has no p_z.
Height height(const FormFamily& family, FormId f) {
    using space_quadrics::term, space_quadrics::unknowns;
    const space_quadrics::Quadric q = space_quadrics::equation(family, f);
    const auto square = [&](std::size_t i) -> const Exact& { return q[term(unknowns, i, i)]; };
    constexpr std::array<std::size_t, 4> used{0, 1, 3, 4};
    if (family.is_circular(f)) return {QuadraticForm::twice(q, unknowns, used), square(0)};
    const ExactCylinder c = exact_cylinder(family.cylinder(f));
    const Exact M = c.ax * c.ax + c.ay * c.ay + c.az * c.az - c.sine * c.sine;
    return {QuadraticForm::twice(q, unknowns, used), c.unit * c.unit * M};
}

}  // namespace

std::vector<std::array<Exact, 4>> height_planes(const FormFamily& family, FormId i, FormId j) {
    for (const FormId f : {i, j}) {
        if (!family.is_circular(f)) continue;
        const ExactForm form = family.exact(f);
        if (form.K.sign() == Sign::Zero) return {{form.A, form.B, -form.W, form.C}};
    }
    const Height p = height(family, i), q = height(family, j);
    const Factors split = split_pencil(q.scale * p.form, p.scale * q.form).factors;
    if (split.kind != Factors::Kind::Rational) return {};
    std::vector<std::array<Exact, 4>> planes;
    for (const LinearFunction& f : split.linear) {
        const bool at_infinity =
            f[0].sign() == Sign::Zero && f[1].sign() == Sign::Zero && f[2].sign() == Sign::Zero;
        if (!at_infinity) planes.push_back({f[0], f[1], f[2], f[3]});
    }
    return planes;
}

}  // namespace vcell
