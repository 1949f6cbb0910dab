// Patches of the bisectors with vessels.
#include <vector>

#include "../../primitives/bases/axial_terms.hpp"
#include "radial_patch.hpp"
#include "radial_patch_terms.hpp"

namespace vcell {

using namespace radial_patch_terms;

// S = power n / (2 (delta W - c.n)), and of any pole n and W are quadratic.
void RadialPatch::set_in_sphere(const Vec3& c, double delta, double power, const Vec3& middle) {
    set_degree(2, 2, Terms::Total);
    set_extent(Extent::Closed);
    const Vec3 z = middle.normalized(), x = z.unitOrthogonal();
    set_axes(Kind::Stereographic, x, z.cross(x), Vec3::Zero());
    const double along = c.dot(z);
    add(0, 0, (delta - along) * weight);
    add(2, 0, (delta + along) * weight);
    add(0, 2, (delta + along) * weight);
    add(1, 0, -2 * c.dot(axes_[0]) * weight);
    add(0, 1, -2 * c.dot(axes_[1]) * weight);
    add_direction(power, z);
}

void RadialPatch::set_in_cone(const HollowCone& vessel, double radius, const Vec3& middle) {
    set_degree(2, 2, Terms::Product);
    set_extent(Extent::Around);
    const Vec3 axis = vessel.axis.stableNormalized(), &apex = vessel.apex, D = -apex;
    const double S = vessel.sine(), K = vessel.cosine(), h0 = D.dot(axis), P = S * h0 + radius;
    const Vec3 out = D - h0 * axis;
    const Vec3 x = across(axis, middle);
    set_axes(Kind::AboutObject, x, axis.cross(x), apex);
    along_ = K * axis;
    along_start_ = -along_.dot(apex);
    along_across_ = S;
    coordinates_ = {PatchCoordinate::hollow_half_angle(apex, x, axes_[1], radius, axis, S, K),
                    PatchCoordinate::along_cone(vessel, axis, radius)};
    const double dx = out.dot(axes_[0]), dy = out.dot(axes_[1]);
    const Polynomial w{P - K * dx, -2 * K * dy, P + K * dx},
        half{0.5 * (D.norm() - radius) * (D.norm() + radius), 0, 0.5};
    const double rise = radius * S + h0;
    add(w, one, vector(apex) + weight);
    add(angle_weight, half, vector(S * axis));
    add(angle_cos, half, vector(-K * axes_[0]));
    add(angle_sin, half, vector(-K * axes_[1]));
    add(angle_weight, linear, vector(radius * K * axis));
    add(angle_cos, linear, vector(rise * axes_[0] - dx * axis));
    add(angle_sin, linear, vector(rise * axes_[1] - dy * axis));
}

// Which m? On the lines through a tip y changes by -A / m for each length of t, the one way for one m and the
// other way for the other. The larger m it is but for a face that lies, along the axis, where its line to a
// tip runs: that is for the half of the base away from this tip, and the other m for the half on its side, as
// the line that is singular then to another tip is away from it.
void RadialPatch::set_in_vessel(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y) {
    const AxialTerms f(problem, form, y);
    if (!f.has_root) return set_about_base(middle, 2 * f.b, 2 * f.b0, f.c, y);
    set_degree(2, 2, Terms::Product);
    const Vec3 x = across(Vec3::UnitY(), middle);
    set_axes(Kind::AboutBase, x, Vec3::UnitY().cross(x), Vec3::Zero());
    const double rise = -f.slope;
    double k = rise < 0 ? -f.spread() : f.spread(), m = rise + k;
    const std::vector<BisectorTip> tips = bisector_tips(problem, form);
    for (const BisectorTip& tip : tips) {
        const bool falls = (f.a.dot(tip.u) + f.a0) * m > 0, is_below = tip.y < y;
        if (falls != is_below) continue;
        Vec3 toward = tip.u;
        for (const BisectorTip& other : tips)
            if (&other != &tip) toward -= other.u;
        if (toward.isZero(0)) toward = tip.u;
        toward.normalize();
        const bool is_here = toward.dot(middle) > 0;
        half_ = is_here ? toward : Vec3(-toward);
        if (is_here) {
            k = -k;
            m = f.c[2] / m;  // k^2 = w_y^2 - c2
        }
        break;
    }
    along_ = Vec3::UnitY() + f.a / m;
    along_start_ = -y;
    along_across_ = f.a0 / m;
    set_coordinates(PatchCoordinate::half_angle(origin_, x, axes_[1], 0));
    const auto normal_times = [&](const Vec3& p, double p0) -> Polynomial {
        const double along_x = p.dot(axes_[0]);
        return {p0 + along_x, 2 * p.dot(axes_[1]), p0 - along_x};
    };
    const Polynomial B = normal_times(f.b, f.b0), A = normal_times(f.a, f.a0),
                     half_C{0.5 * f.c[0], 0.5 * f.c[1], 0.5 * f.c[2]};
    const double turn = 0.5 * f.c[1] / m;
    const Vector4d y_axis = vector(Vec3::UnitY());
    add(B, one, weight);
    add(A, {turn, -k, 0}, weight);
    add(B, {y, 1, 0}, y_axis);
    add(A, {turn * y, turn - k * y, -k}, y_axis);
    add(A, half_C, -y_axis / m);
    add(angle_cos, half_C, vector(axes_[0]));
    add(angle_sin, half_C, vector(axes_[1]));
}

}  // namespace vcell
