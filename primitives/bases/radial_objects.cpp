#include "radial_objects.hpp"

#include <type_traits>

#include "../objects/decided_scene.hpp"
#include "nested_balls.hpp"
#include "solids.hpp"

namespace vcell {

const char* cuts_or_touches(Sign clearance) { return clearance == Sign::Zero ? "touches" : "cuts"; }

void RadialObjects::drop_hidden_and_equal(const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
    const BallNesting nesting = ball_nesting(balls.items);
    for (std::size_t i = 0; i < balls.size(); ++i) {
        if (const std::uint32_t first = nesting.first_equal[i]; first < i)
            merge(balls.objects[i], balls.objects[first]);
        if (const std::uint32_t k = nesting.enclosing[i]; k != none)
            hide(balls.objects[i], " in ", site(balls.objects[k]));
    }
    const std::vector<std::array<Exact, 4>> walls = half_spaces();
    // Planes that are multiples of each other are one plane, though their |n| may be told differently.
    const std::vector<std::uint32_t> first_plane = first_equal(walls);
    std::vector<Site> of_walls;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        if (first_plane[i] < i) merge(planes.objects[i], planes.objects[first_plane[i]]);
        of_walls.push_back(site(planes.objects[i]));
    }
    drop_hidden_by_cylinders(walls, of_walls, mirrored);
    if (hollow_balls.size() + hollow_cylinders.size() + hollow_cones.size() == 0) return;
    drop_wider_vessels();
    const auto is_within = [](const Exact& square, const Exact& reach, const Exact& scale) {
        return (reach * reach * scale - square).sign() == Sign::Positive;
    };
    for (std::size_t k = 0; k < hollow_balls.size(); ++k) {
        const HollowSphere& vessel = hollow_balls.items[k];
        const ExactVector center(vessel.center);
        // The cap's radius is rounded.
        const Exact R = is_cap(scene_, hollow_balls.objects[k])
                            ? Exact(std::get<Sphere>(scene_.base).radius) + 2.0 * Exact(*scene_.probe)
                            : Exact(vessel.radius);
        drop_beyond_wall(hollow_balls.objects[k], [&](const auto& solid) {
            using Solid = std::decay_t<decltype(solid)>;
            if constexpr (std::is_same_v<Solid, Ball>) {
                // Doubles, a few roundings off, see that most are well within.
                constexpr double well_within = 1 - 0x1p-40;
                const double away = (Vec3(solid.cx, solid.cy, solid.cz) - vessel.center).norm();
                if (away < well_within * (vessel.radius + solid.rho)) return false;
                const ExactVector way = ExactVector(Vec3(solid.cx, solid.cy, solid.cz)) - center;
                return !is_within(dot(way, way), R + solid.rho, 1.0);
            } else if constexpr (std::is_same_v<Solid, HalfSpace>) {
                const Exact value = solid(center);
                return !is_within(value * value, R, dot(ExactVector(solid.n), ExactVector(solid.n)));
            } else {
                return is_beside(solid, vessel.center.x(), vessel.center.y(), vessel.center.z(),
                                 vessel.radius);
            }
        });
    }
    drop_beyond_tubes_and_cones();
}

// A vessel that has another one within is never nearer than that; the first of equal ones is taken.
void RadialObjects::drop_wider_vessels() {
    const auto holds = [](const HollowSphere& outer, const HollowSphere& inner) {
        const Exact room = Exact(outer.radius) - inner.radius;
        const ExactVector way = ExactVector(outer.center) - ExactVector(inner.center);
        return room.sign() != Sign::Negative && (room * room - dot(way, way)).sign() != Sign::Negative;
    };
    for (std::size_t i = 0; i < hollow_balls.size(); ++i) {
        const HollowSphere& ball = hollow_balls.items[i];
        for (std::size_t j = 0; j < i; ++j) {
            const HollowSphere& other = hollow_balls.items[j];
            drop_wider(hollow_balls.objects[i], hollow_balls.objects[j], holds(ball, other),
                       holds(other, ball));
        }
        for (std::size_t j = 0; j < hollow_cylinders.size(); ++j)
            drop_wider(hollow_cylinders.objects[j], hollow_balls.objects[i],
                       contains(hollow_cylinders.items[j], ball.center.x(), ball.center.y(), ball.center.z(),
                                ball.radius),
                       false);
    }
    drop_wider_tubes_and_cones();
    for (std::size_t i = 0; i < hollow_cones.size(); ++i) {
        const ConeForm& cone = hollow_cones.items[i];
        for (std::size_t j = 0; j < hollow_balls.size(); ++j) {
            const HollowSphere& ball = hollow_balls.items[j];
            drop_wider(hollow_cones.objects[i], hollow_balls.objects[j],
                       contains(cone, ball.center, ball.radius), false);
        }
    }
}

void FoundForms::add_twins(const RadialObjects& all) {
    for (std::uint32_t i = 0; all.has_merged() && i < of_object.size(); ++i) {
        const std::uint32_t owner = all.owner(i);
        if (owner != RadialObjects::none && owner != i && of_object[owner].valid())
            sites.join(of_object[owner], all.site(i));
    }
    sites.settle();
}

}  // namespace vcell
