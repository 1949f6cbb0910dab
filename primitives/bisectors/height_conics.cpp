#include "height_conics.hpp"

#include <array>

#include "quadratic_form.hpp"

namespace vcell {

namespace {

struct Height {
    QuadraticForm form;  // of (x, y, z, 1)
    Exact scale;         // of x^2 + y^2 + z^2 before z^2 cancels: |a|^2 of a cylinder
};

// Over a plane z is t, and the equation has no p_z. A cylinder's has |a|^2 (|p|^2 - t^2) - (a.p)^2: its trace
// is |a|^2.
Height height(const FormFamily& family, FormId f) {
    using space_quadrics::term, space_quadrics::unknowns;
    const space_quadrics::Quadric q = space_quadrics::equation(family, f);
    const auto square = [&](std::size_t i) -> const Exact& { return q[term(unknowns, i, i)]; };
    constexpr std::array<std::size_t, 4> used{0, 1, 3, 4};
    return {QuadraticForm::twice(q, unknowns, used),
            family.is_circular(f) ? square(0) : square(0) + square(1) + square(3)};
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
