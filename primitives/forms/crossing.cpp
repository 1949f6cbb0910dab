#include "crossing.hpp"

#include <algorithm>
#include <cmath>

namespace vcell {

namespace {

// A form's cylinder. With its axis a and the axis' point m nearest to the centre (over a cylinder: to 0)
// radial forms hold |a|^2 m and |a|^2 delta. None but cylinders' have an axis.
struct Tube {
    ExactVector axis, moment;
    Exact length2, delta;  // length2: by which moment and delta are multiplied

    Tube(const FormFamily& family, FormId f) {
        if (family.radial.empty()) {
            set(family.cylinder(f));
            return;
        }
        const auto of_wall =
            std::ranges::lower_bound(family.tubes_of_walls, f, {}, &FormFamily::TubeOfWall::wall);
        const bool is_wall = of_wall != family.tubes_of_walls.end() && of_wall->wall == f;
        const RadialForm& h = is_wall ? of_wall->tube : family.radial_form(f);
        const long unit = is_wall ? 0 : std::ilogb(family.axial_unit);
        axis = {h.a[0], h.a[1] + h.slope.scaled(-unit), h.a[2]};
        moment = {h.b[0], h.b[1] - h.c[1].scaled(-unit - 1), h.b[2]};
        length2 = dot(axis, axis);
        delta = h.b0;
    }

private:
    void set(const CylinderForm& f) {
        if (f.is_hollow()) return;
        const ExactCylinder tube = exact_cylinder(f);
        const ExactVector point(tube.px, tube.py, tube.pz);
        axis = {tube.ax, tube.ay, tube.az};
        const Exact square = dot(axis, axis);
        moment = square * point - dot(point, axis) * axis;
        length2 = square * tube.unit;
        delta = square * tube.rho;
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
