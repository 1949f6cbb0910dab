#include "radial_patch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "../../primitives/bases/axial_terms.hpp"
#include "radial_patch_terms.hpp"

namespace vcell {

namespace {

using namespace radial_patch_terms;

// Of a cylinder over a cylinder base: v is taken to be nearly constant on lines of the surface where
// the axes' distance squared, less delta^2, is less than this part of the squared distance of the axis beside
// the face. There S_v is 1 / singular times as long as elsewhere at most.
constexpr double singular = 1.0 / 64;
// And out of reach of a face beyond this many times the distance of the axis beside it.
constexpr double far = 64;

}  // namespace

RadialPatch::RadialPatch(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y,
                         bool wide) {
    const Object& object = problem.objects[form];
    if (is_vessel(object) && !problem.chart.is_sphere()) {
        set_in_vessel(problem, form, middle, y);
        return;
    }
    if (const auto* plane = std::get_if<Plane>(&object)) {
        // Away from the base.
        Vec3 normal = plane->normal.normalized();
        if (normal.dot(plane->point - Vec3(0, y, 0)) < 0) normal = -normal;
        const double offset = normal.dot(plane->point);
        if (is_wall(problem, form))
            set_plane(plane->point, normal);
        else if (problem.chart.is_sphere())
            set_paraboloid(offset, normal, problem.chart.radius);
        else
            set_about_base(middle, across_y(normal), 1, {offset + problem.chart.radius, -normal.y(), 0});
    } else if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const Vec3& c = sphere->center;
        const double delta = sphere->radius - problem.chart.radius, near = across_y(c).norm();
        if (!problem.chart.is_sphere())
            set_about_base(middle, 2 * across_y(c), 2 * delta,
                           {(near - delta) * (near + delta) + c.y() * c.y(), -2 * c.y(), 1});
        else if (delta == 0)
            set_plane(0.5 * c, c.normalized());
        else
            set_stereographic(c, delta, ball_power(problem, form), middle, wide);
    } else if (const auto* ball = std::get_if<HollowSphere>(&object)) {
        set_in_sphere(ball->center, ball->radius + problem.chart.radius, ball_power(problem, form), middle);
    } else if (const auto* tube = std::get_if<HollowCylinder>(&object)) {
        set_about_object(tube->axis, tube->point, tube->radius + problem.chart.radius, -1, &middle);
    } else if (const auto* cone = std::get_if<HollowCone>(&object)) {
        set_in_cone(*cone, problem.chart.radius, middle);
    } else {
        const auto& cylinder = std::get<Cylinder>(object);
        if (problem.chart.is_sphere())
            set_about_object(cylinder.axis, cylinder.point, cylinder.radius - problem.chart.radius, 1,
                             pierces_base(problem, form) ? &middle : nullptr);
        else
            set_about_axes(problem, form, middle, y, wide);
    }
}

RadialPatch::RadialPatch(const SkewAxes& axes) {
    set_degree(1, 1, Terms::Product);
    set_axes(Kind::Graph, axes.x, axes.y, axes.origin);
    const Vector4d fall = -axes.steep * vector(axes_[2]);
    add(0, 0, vector(origin_) + weight + 0.5 * axes.apart * vector(axes_[2]));
    add({axes.x0, 1, 0}, {axes.y0, 1, 0}, fall);
    add(1, 0, vector(axes.x));
    add(0, 1, vector(axes.y));
}

void RadialPatch::add_direction(double power, const Vec3& z) {
    const Vector4d pole = 0.5 * power * vector(z);
    add(1, 0, power * vector(axes_[0]));
    add(0, 1, power * vector(axes_[1]));
    add(0, 0, pole);
    add(2, 0, -pole);
    add(0, 2, -pole);
}

void RadialPatch::set_plane(const Vec3& point, const Vec3& normal) {
    const Vec3 x = normal.unitOrthogonal(), origin = point.dot(normal) * normal;
    set_axes(Kind::Planar, x, normal.cross(x), origin);
    add(0, 0, vector(origin) + weight);
    add(1, 0, vector(axes_[0]));
    add(0, 1, vector(axes_[1]));
}

// With h the distance from the plane: |S| = R0 + h and |S|^2 = (d - h)^2 + u^2 + v^2.
void RadialPatch::set_paraboloid(double distance, const Vec3& normal, double radius) {
    set_plane(distance * normal, normal);
    set_degree(2, 2, Terms::Total);
    const double before = 0.5 / (radius + distance);
    const Vector4d back = -vector(normal);
    add(0, 0, 0.5 * (distance - radius) * back);
    add(2, 0, before * back);
    add(0, 2, before * back);
}

void RadialPatch::set_stereographic(const Vec3& c, double delta, double power, const Vec3& middle,
                                    bool wide) {
    set_degree(2, 2, Terms::Total);
    const double length = c.norm();
    const Vec3 z = c / length;
    if (wide) return set_confocal(z, length, delta, power, middle);
    const Vec3 x = across(z, middle);
    set_axes(Kind::Stereographic, x, z.cross(x), Vec3::Zero());
    const double sum = delta < 0 ? power / (length - delta) : length + delta, difference = power / sum;
    add(0, 0, sum * weight);
    add(2, 0, -difference * weight);
    add(0, 2, -difference * weight);
    add_direction(power, axes_[2]);
}

// The directions at infinity make the angle acos(-delta / |c|) with c; that on the other side of `middle` is
// -axes_[2]. (u, v) is (|p| + axes_[2].p, axes_[1].p), which is counter-clockwise with axes_[1] = axes_[0] x
// axes_[2].
void RadialPatch::set_confocal(const Vec3& z, double length, double delta, double power, const Vec3& middle) {
    const Vec3 x = across(z, middle);
    const double cosine = -delta / length, sine = std::sqrt(power) / length;
    const Vec3 opposite = sine * x - cosine * z, across_it = sine * z + cosine * x;
    kind_ = Kind::Confocal;
    axes_ = {across_it, across_it.cross(opposite), opposite};
    origin_ = Vec3::Zero();
    coordinates_[0].numerator << opposite, 1, 0;
    coordinates_[1] = PatchCoordinate::linear(axes_[1], origin_);
    const double a = 0.5 * std::sqrt(power), b = 0.5 * delta / a;
    add(1, 0, a * vector(axes_[0]));
    add(2, 0, -b * vector(axes_[0]));
    add(1, 1, vector(axes_[1]));
    add(0, 0, -0.5 * a * a * vector(opposite));
    add(1, 0, a * b * vector(opposite));
    add(2, 0, 0.5 * (1 - b) * (1 + b) * vector(opposite));
    add(0, 2, -0.5 * vector(opposite));
    add(1, 0, weight);
}

// S = c + v d + r n / W with |S| = r - delta, or with |S| = delta - r from within a vessel: then all of it is
// negated, and the base lies on the other side.
void RadialPatch::set_about_object(const Vec3& axis, const Vec3& point, double delta, double side,
                                   const Vec3* middle) {
    set_degree(2, 2, Terms::Product);
    if (side < 0) set_extent(Extent::Around);
    const Vec3 d = axis.normalized(), c = point - point.dot(d) * d,
               x = middle != nullptr ? across(d, *middle) : Vec3(-c.normalized());
    // d leaves the cell's inside on the left, or on the right.
    set_axes(Kind::AboutObject, x, -side * d.cross(x), c);
    along_ = d;
    set_coordinates(side < 0 ? PatchCoordinate::hollow_half_angle(c, x, axes_[1], delta)
                             : PatchCoordinate::half_angle(c, x, axes_[1], delta));
    const double length = c.norm(), squared = side * (length - delta) * (length + delta);
    const double cx = middle != nullptr ? c.dot(x) : -length, cy = middle != nullptr ? c.dot(axes_[1]) : 0;
    const Polynomial w{-side * (cx + delta), -side * 2 * cy, side * (cx - delta)},
        half{0.5 * squared, 0, side * 0.5};
    add(w, one, vector(c) + weight);
    add(w, linear, vector(d));
    add(angle_cos, half, vector(axes_[0]));
    add(angle_sin, half, vector(axes_[1]));
}

// t = C(y) W / w with w = b.n + b0 W, y counted from `start`.
void RadialPatch::set_about_base(const Vec3& middle, const Vec3& b, double b0, const Polynomial& C,
                                 double start) {
    set_degree(2, C[2] == 0 ? 1 : 2, Terms::Product);
    const Vec3 x = across(Vec3::UnitY(), middle);
    set_axes(Kind::AboutBase, x, Vec3::UnitY().cross(x), Vec3::Zero());
    along_ = Vec3::UnitY();
    along_start_ = -start;
    set_coordinates(PatchCoordinate::half_angle(origin_, x, axes_[1], 0));
    const Polynomial w{b0 + b.dot(axes_[0]), 2 * b.dot(axes_[1]), b0 - b.dot(axes_[0])};
    add(w, one, weight);
    add(w, {start, 1, 0}, vector(Vec3::UnitY()));
    add(angle_cos, C, vector(axes_[0]));
    add(angle_sin, C, vector(axes_[1]));
}

void RadialPatch::set_about_axes(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y,
                                 bool wide) {
    const auto& cylinder = std::get<Cylinder>(problem.objects[form]);
    const double delta = cylinder.radius - problem.chart.radius;
    Vec3 d = cylinder.axis.normalized();
    const Vec3 a = cylinder.point + d * d.dot(Vec3(0, y, 0) - cylinder.point), near = across_y(a);
    const double sine = across_y(d).norm();
    if (sine == 0) {
        if (delta == 0) return set_plane(0.5 * near, near.normalized());
        return set_about_base(middle, 2 * near, 2 * delta, {near.squaredNorm() - delta * delta, 0, 0});
    }
    // Which sign of d? Where the lines v = const lie on the surface, or nearly, it has to be right for this
    // half of the base. Otherwise the one in which 1 + d_y is larger.
    const Vec3 d_across = across_y(d) / sine;
    const double apart = near.cross(d_across).norm();
    const double crossing = a.y() - near.dot(d_across) / sine * d.y();
    double side = y < crossing ? -1 : 1;
    // These lines end in tips, if there are any.
    for (const BisectorTip& tip : bisector_tips(problem, form))
        if (tip.u.dot(middle) > 0 && pierces_base(problem, form)) side = y < tip.y ? -1 : 1;
    const double beyond = sine * (y - crossing);
    const bool is_near = (apart - delta) * (apart + delta) < singular * beyond * beyond;
    // With 1 + |d_y| the lines leave the base's axis by that much over sine for each length along it, from
    // where C vanishes. Next to parallel axes they are out of reach; and the other sign of d would leave
    // little of the digits of v.
    const double nearest = std::clamp(crossing, problem.stretch[0], problem.stretch[1]),
                 zero = std::sqrt(std::max(0.0, (delta - apart) * (delta + apart))) / sine;
    const bool is_far =
        (std::abs(nearest - crossing) - zero) * (1 + std::abs(d.y())) > far * sine * std::abs(beyond);
    const bool is_singular = (wide || is_near) && !is_far;
    if (is_singular ? side * d.dot(middle) < 0 : d.y() < 0) d = -d;
    if (is_singular) half_ = side * across_y(d);

    set_degree(2, 2, Terms::Product);
    const Vec3 x = across(Vec3::UnitY(), middle);
    set_axes(Kind::AboutBase, x, Vec3::UnitY().cross(x), Vec3::Zero());
    const double scale = d.y() > 0 ? 1 / (1 + d.y()) : (1 - d.y()) / (sine * sine);
    along_ = scale * (d + Vec3::UnitY());
    along_start_ = -along_.dot(a);
    set_coordinates(PatchCoordinate::half_angle(origin_, x, axes_[1], 0));
    // w = q.n + delta W, t = C W / (2 w) and y w = (start + v) w - C n.d' / (2 (1 + d_y)).
    const double start = a.y() + scale * a.dot(across_y(d));
    const Polynomial half_C{0.5 * (near.norm() - delta) * (near.norm() + delta), near.dot(d),
                            0.5 * sine * sine};
    const auto normal_times = [&](const Vec3& p) -> Polynomial {
        const double along_x = p.dot(axes_[0]);
        return {along_x, 2 * p.dot(axes_[1]), -along_x};
    };
    Polynomial w = normal_times(near);
    w[0] += delta;
    w[2] += delta;
    const Polynomial turn = normal_times(d);
    const Vector4d y_axis = vector(Vec3::UnitY());
    add(w, one, weight);
    add(turn, linear, weight);
    add(w, {start, 1, 0}, y_axis);
    add(turn, {0, start, 1}, y_axis);
    add(turn, half_C, -scale * y_axis);
    add(angle_cos, half_C, vector(axes_[0]));
    add(angle_sin, half_C, vector(axes_[1]));
}

}  // namespace vcell
