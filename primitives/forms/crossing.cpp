#include "crossing.hpp"

#include <cmath>

namespace vcell {

namespace {

// A radial form's cylinder: with its axis a and the axis' point m nearest to the centre (over a cylinder: to
// 0) forms hold |a|^2 m and |a|^2 delta. No cylinder's form has a = 0.
struct Tube {
    ExactVector axis, moment;
    Exact length2, delta;

    Tube(const FormFamily& family, FormId f) {
        const RadialForm& h = family.radial_form(f);
        const long unit = std::ilogb(family.axial_unit);
        axis = {h.a[0], h.a[1] + h.slope.scaled(-unit), h.a[2]};
        moment = {h.b[0], h.b[1] - h.c[1].scaled(-unit - 1), h.b[2]};
        length2 = dot(axis, axis);
        delta = h.b0;
    }
};

}  // namespace

std::optional<Crossing> equal_crossing(const FormFamily& family, FormId f, FormId g) {
    const Tube p(family, f), q(family, g);
    Crossing c;
    c.normal = cross(p.axis, q.axis);
    if (c.normal.is_zero() || p.delta * q.length2 != q.delta * p.length2) return std::nullopt;
    const ExactVector between = p.length2 * q.moment - q.length2 * p.moment;
    if (dot(between, c.normal).sign() != Sign::Zero) return std::nullopt;
    const Exact normal2 = dot(c.normal, c.normal);
    c.divisor = p.length2 * q.length2 * normal2;
    c.delta = q.length2 * normal2 * p.delta;
    c.center = (q.length2 * normal2) * p.moment + dot(cross(between, q.axis), c.normal) * p.axis;
    return c;
}

bool runs_through(const FormFamily& family, FormId h, const Crossing& crossing) {
    const Tube p(family, h);
    return dot(p.axis, crossing.normal).sign() == Sign::Zero &&
           cross(p.length2 * crossing.center - crossing.divisor * p.moment, p.axis).is_zero();
}

}  // namespace vcell
