// What sites' equations are, about a base in its own frame.
#include <algorithm>
#include <cmath>

#include "crossing_walls.hpp"
#include "shadows.hpp"
#include "triads.hpp"

namespace vcell::check {

namespace {

void set_tube(Equation& equation, const Scene& scene, const Frame& frame, const Cylinder& tube) {
    equation.kind = Equation::Kind::tube;
    equation.c = near(frame.point(tube.point));
    equation.d = normalized(near(frame.direction(tube.axis / tube.axis.cwiseAbs().maxCoeff())));
    // Over a plane the first runs along it, so that heights lie in the second alone, unless the tube is
    // upright.
    const auto* plane = std::get_if<Plane>(&scene.base);
    const Vec3 axis = tube.axis.normalized();
    constexpr double upright = 0.9;
    Vec3 aside_of_axis = plane ? plane->normal.normalized() : Vec3(Vec3::Zero());
    if (!plane || std::abs(axis.dot(aside_of_axis)) > upright) {
        int least = 0;
        axis.cwiseAbs().minCoeff(&least);
        aside_of_axis = Vec3::Unit(least);
    }
    const Triad<MidRad> aside = near(frame.direction(aside_of_axis));
    equation.across[0] = normalized(cross(aside, equation.d));
    equation.across[1] = cross(equation.d, equation.across[0]);
    for (const std::size_t i : {0, 1}) equation.across_c[i] = dot(equation.across[i], equation.c);
    equation.delta = MidRad(frame.length(tube.radius)) - frame.radius();
    if (plane) equation.delta = frame.length(tube.radius);
}

// On which side of the crossing the points are, and in which of the two walls there, the farthest one tells.
void set_wall(Equation& equation, const Frame& frame, const Cylinder& base, const Cylinder& tube,
              std::span<const Triad<double>> points) {
    equation.kind = Equation::Kind::side;
    double farthest = -1;
    for (const bool is_beyond : {true, false}) {
        const CrossingWalls<Interval> walls(base, tube, is_beyond);
        const Triad<Interval> crossing = frame.point(walls.point);
        const std::array<Triad<MidRad>, 2> normals{near(frame.direction(walls.normals[0])),
                                                   near(frame.direction(walls.normals[1]))};
        for (const Triad<double>& p : points) {
            if ((p[2] > crossing[2].mid()) != is_beyond) continue;
            std::array<double, 2> off{};
            for (const std::size_t wall : {0, 1})
                for (const std::size_t k : {0, 1, 2})
                    off[wall] += normals[wall][k].mid() * (crossing[k].mid() - p[k]);
            const std::size_t wall = std::abs(off[0]) < std::abs(off[1]) ? 0 : 1;
            if (!(std::abs(off[1 - wall]) > farthest)) continue;
            farthest = std::abs(off[1 - wall]);
            equation.c = normals[wall];
            equation.offset = dot(normals[wall], near(crossing));
        }
    }
}

// The plane half-way to a tube like the base, along it: next to that rays hardly meet it.
void set_half_way(Equation& equation, const Triad<MidRad>& way) {
    equation.kind = Equation::Kind::side;
    equation.c = normalized(way);
    equation.offset = 0.5 * dot(equation.c, way);
}

}  // namespace

std::optional<Equation> equation_of(const Scene& scene, const Frame& frame, const Site& site,
                                    std::span<const Triad<double>> points) {
    Equation equation{};
    equation.radius = frame.radius();
    if (site.kind == Site::Kind::BoxSide) {
        const int axis = static_cast<int>(site.index / 2);
        const bool is_upper = site.index % 2;
        equation.kind = Equation::Kind::side;
        equation.c = near(frame.direction(is_upper ? Vec3(Vec3::Unit(axis)) : Vec3(-Vec3::Unit(axis))));
        equation.offset = dot(equation.c, near(frame.point(is_upper ? scene.box.max : scene.box.min)));
        return equation;
    }
    if (!site.is_object()) return std::nullopt;
    const Object& object = scene.objects[site.index];
    if (const auto* ball = std::get_if<Sphere>(&object)) {
        equation.kind = Equation::Kind::ball;
        equation.c = near(frame.point(ball->center));
        const auto* base = std::get_if<Sphere>(&scene.base);
        equation.delta = base && base->radius == ball->radius
                             ? MidRad(0.0)
                             : MidRad(frame.length(ball->radius)) - frame.radius();
        if (std::holds_alternative<Plane>(scene.base)) equation.delta = frame.length(ball->radius);
        return equation;
    }
    if (const auto* tube = std::get_if<Cylinder>(&object)) {
        const auto* base = std::get_if<Cylinder>(&scene.base);
        if (base && !points.empty() && cross_equally(*base, *tube)) {
            set_wall(equation, frame, *base, *tube, points);
            return equation;
        }
        if (base && base->radius == tube->radius &&
            cross(ExactVector(base->axis), ExactVector(tube->axis)).is_zero()) {
            const auto [x, y, along] = frame.way(base->point, tube->point);
            set_half_way(equation, {x, y, 0.0});
            return equation;
        }
        set_tube(equation, scene, frame, *tube);
        return equation;
    }
    if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        equation.kind = Equation::Kind::ball;
        equation.is_hollow = true;
        equation.c = near(frame.point(vessel->center));
        equation.delta = -(MidRad(frame.length(vessel->radius)) + frame.radius());
        return equation;
    }
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) {
        const Cylinder tube{vessel->point, vessel->axis, vessel->radius};
        set_tube(equation, scene, frame, tube);
        equation.is_hollow = true;
        equation.delta = -(MidRad(frame.length(vessel->radius)) + frame.radius());
        equation.radius = -equation.delta;
        equation.cosine = 1.0;
        return equation;
    }
    if (const auto* cone = std::get_if<HollowCone>(&object)) {
        set_tube(equation, scene, frame, Cylinder{cone->apex, cone->axis, 0});
        equation.kind = Equation::Kind::cone;
        equation.is_hollow = true;
        const MidRad wide(cone->radius), slant(cone->slant);
        equation.sine = wide / slant;
        equation.cosine = sqrt((slant - wide) * (slant + wide)) / slant;
        equation.radius = frame.radius();
        return equation;
    }
    const auto& plane = std::get<Plane>(object);
    equation.kind = Equation::Kind::plane;
    equation.c = normalized(near(frame.direction(plane.normal / plane.normal.cwiseAbs().maxCoeff())));
    equation.offset = -dot(equation.c, near(frame.point(plane.point)));
    // The base lies on one side of it; told at the foot that is farthest away. Control points may lie beyond.
    double best = 0;
    for (const auto& p : points) {
        Triad<MidRad> foot{};
        if (std::holds_alternative<Plane>(scene.base)) foot = {p[0], p[1], 0.0};
        if (std::holds_alternative<Cylinder>(scene.base)) foot = {0.0, 0.0, p[2]};
        const MidRad value = dot(equation.c, foot) + equation.offset;
        if (!(std::abs(value.mid()) > value.radius())) continue;
        if (std::abs(value.mid()) > std::abs(best)) best = value.mid();
    }
    if (best == 0) return std::nullopt;
    equation.sign = best > 0 ? 1 : -1;
    return equation;
}

}  // namespace vcell::check
