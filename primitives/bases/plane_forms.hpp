// The heights of balls, planes, sides of the box and tubes over a plane base, as plane_base.hpp has them.
#pragma once

#include <array>
#include <memory>
#include <variant>

#include "../../core/curves/circular_form.hpp"
#include "../../core/numbers/exact.hpp"
#include "../forms/cylinder_form.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"
#include "cone_form.hpp"
#include "plane_frame.hpp"
#include "world_objects.hpp"

namespace vcell {

// A ball in canonical coordinates, all of it times d.
struct ExactBall {
    ExactVector c;
    Exact rho, d;

    Exact behind() const { return c.z - rho; }  // height of the lowest point
    Exact width() const { return c.z + rho; }   // beta
};

// Each of the four operations below is one rounding of exact operands or two of rounded ones: e has a
// relative error of 3u, w of u.
inline CircularForm ball_form(const Ball& s) {
    CircularForm f;
    f.k = 1;
    f.cx = s.cx;
    f.cy = s.cy;
    f.e = (s.cz - s.rho) * (s.cz + s.rho);
    f.w = 2 * (s.cz + s.rho);
    return f;
}

inline ExactForm exact_ball_form(const ExactBall& s) {
    const Exact twice_d = 2.0 * s.d;
    return {s.d * s.d, -(twice_d * s.c.x), -(twice_d * s.c.y),
            s.c.x * s.c.x + s.c.y * s.c.y + s.behind() * s.width(), twice_d * s.width()};
}

// About a centre in doubles, what it is off by in the linear terms: |p - c|^2 = |p - c~|^2 + 2 (c~ - c).p +
// |c|^2 - |c~|^2. Coefficients are quotients of correctly rounded numbers: relative errors of 3u.
inline CircularForm ball_form(const ExactBall& s) {
    const double d = nearest(s.d), d2 = nearest(s.d * s.d);
    CircularForm f;
    f.k = 1;
    f.cx = nearest(s.c.x) / d;
    f.cy = nearest(s.c.y) / d;
    const Exact cx = s.d * Exact(f.cx), cy = s.d * Exact(f.cy);
    f.a = 2 * nearest(cx - s.c.x) / d;
    f.b = 2 * nearest(cy - s.c.y) / d;
    f.e = nearest(s.c.x * s.c.x + s.c.y * s.c.y - cx * cx - cy * cy + s.behind() * s.width()) / d2;
    f.w = 2 * nearest(s.width()) / d;
    return f;
}

// (A x + B y + C) / W, of a plane or a box side.
using LinearForm = std::array<Exact, 4>;

// n.p + d with the region on the positive side.
struct HalfSpaceOverBase {
    ExactVector n;
    Exact d, length;  // |n| as length_of() has it
};

// Height of the plane n.p + d = 0 seen from its positive side: C = nx x + ny y + d, 2 beta = |n| - nz,
// both multiplied by |n| + nz where the difference would cancel.
inline LinearForm plane_form(const HalfSpaceOverBase& h) {
    const ExactVector& n = h.n;
    if (n.z.sign() != Sign::Positive) return {n.x, n.y, h.d, h.length - n.z};
    const Exact factor = h.length + n.z;
    return {factor * n.x, factor * n.y, factor * h.d, n.x * n.x + n.y * n.y};
}

// In canonical coordinates; the radius is below 0 of a hollow one.
inline CylinderForm placed_cylinder(const PlaneFrame& frame, const Cylinder& cylinder) {
    const Vec3 axis = scaled_axis(cylinder.axis), p = frame.to_canonical(cylinder.point);
    const ExactVector a = frame.turned(axis);
    const double d = nearest(frame.norm());
    CylinderForm form{p.x(),          p.y(), p.z(), nearest(a.x) / d, nearest(a.y) / d, nearest(a.z) / d,
                      cylinder.radius};
    if (!frame.keeps(cylinder.point)) {
        const ExactVector q = frame.place(cylinder.point);
        form.px = nearest(q.x) / d;
        form.py = nearest(q.y) / d;
        form.pz = nearest(q.z) / d;
        form.exact = std::make_shared<const ExactCylinder>(ExactCylinder{
            {q.x, q.y, q.z, a.x, a.y, a.z, frame.norm() * cylinder.radius, Exact(), a.z}, frame.norm()});
    }
    return form;
}

// |a| times the sine is told exactly if the axis is the cone's rim times its slant's length: with a and g of
// ConeForm it is g a, and S is |a|^2.
inline CylinderForm placed_cone(const PlaneFrame& frame, const HollowCone& cone) {
    const ConeForm world(cone);
    const ExactVector p = frame.place(cone.apex),
                      a = world.g * world.rim * frame.turned(scaled_axis(cone.axis));
    const Exact &unit = frame.norm(), S = unit * world.N;
    const double d = nearest(unit);
    return {nearest(p.x) / d,
            nearest(p.y) / d,
            nearest(p.z) / d,
            nearest(a.x) / d,
            nearest(a.y) / d,
            nearest(a.z) / d,
            0,
            nearest(S) / d,
            nearest(a.z - S) / d,
            std::make_shared<const ExactCylinder>(
                ExactCylinder{{p.x, p.y, p.z, a.x, a.y, a.z, Exact(), S, a.z - S}, unit})};
}

// A side of the box hides what lies beyond a plane, where the base and its mirror image across that side are
// equally far: with x' = 2 bound - x for its coordinate, n.(p' - point) > 0 on the base's side if the base
// leans that way.
inline LinearForm half_way_to_image(const Plane& base, const WorldSide& side) {
    Vec3 mirrored = base.normal;
    mirrored[side.axis] = -mirrored[side.axis];
    const Exact d = 2.0 * Exact(side.bound) * base.normal[side.axis] -
                    dot(ExactVector(base.normal), ExactVector(base.point));
    return {mirrored.x(), mirrored.y(), mirrored.z(), d};
}

// The form of a tube, of a radius below 0 if it is hollow, or of a hollow cone.
inline CylinderForm placed_form(const PlaneFrame& frame, const Object& object) {
    if (const auto* cone = std::get_if<HollowCone>(&object)) return placed_cone(frame, *cone);
    const auto* hollow = std::get_if<HollowCylinder>(&object);
    return placed_cylinder(frame, hollow != nullptr ? Cylinder{hollow->point, hollow->axis, -hollow->radius}
                                                    : std::get<Cylinder>(object));
}

}  // namespace vcell
