#include "height_conics.hpp"

#include "quadratic_form.hpp"

namespace vcell {

namespace {

// Coordinates are (x, y, z, 1).
struct Height {
    QuadraticForm form{4};
    Exact scale;  // of x^2 + y^2 + z^2 before z^2 cancels: |a|^2 of a cylinder
};

Height height(const CylinderForm& form) {
    // Lengths are times the exact form's unit s.
    const ExactCylinder f = exact_cylinder(form);
    const auto& [px, py, pz, ax, ay, az, rho] = static_cast<const CylinderNumbers<Exact>&>(f);
    const Exact& s = f.unit;
    const Exact norm = ax * ax + ay * ay + az * az;
    const LinearFunction mx{s, 0.0, 0.0, -px}, my{0.0, s, 0.0, -py}, mz{0.0, 0.0, s, -pz},
        along{s * ax, s * ay, s * az, -(ax * px + ay * py + az * pz)}, reach{0.0, 0.0, s, rho};
    // |a|^2 (|m|^2 - (rho + z)^2) - (m . a)^2
    Height h{QuadraticForm(4), s * s * norm};
    for (const LinearFunction* m : {&mx, &my, &mz}) h.form.add_twice_product(norm, *m, *m);
    h.form.add_twice_product(-norm, reach, reach);
    h.form.add_twice_product(-1.0, along, along);
    return h;
}

Height height(const ExactForm& f) {
    const LinearFunction x{1.0, 0.0, 0.0, 0.0}, y{0.0, 1.0, 0.0, 0.0}, one{0.0, 0.0, 0.0, 1.0},
        rest{f.A, f.B, -f.W, f.C};
    Height h{QuadraticForm(4), f.K};
    h.form.add_twice_product(f.K, x, x);
    h.form.add_twice_product(f.K, y, y);
    h.form.add_twice_product(1.0, rest, one);
    return h;
}

}  // namespace

std::vector<std::array<Exact, 4>> height_planes(const FormFamily& family, FormId i, FormId j) {
    const auto make = [&](FormId f) {
        return family.is_circular(f) ? height(family.exact(f)) : height(family.cylinder(f));
    };
    for (const FormId f : {i, j}) {
        if (!family.is_circular(f)) continue;
        const ExactForm form = family.exact(f);
        if (form.K.sign() == Sign::Zero) return {{form.A, form.B, -form.W, form.C}};
    }
    const Height p = make(i), q = make(j);
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
