#include "radial_objects.hpp"

#include <algorithm>
#include <numeric>
#include <type_traits>

#include "../objects/decided_scene.hpp"
#include "../objects/message.hpp"
#include "nested_balls.hpp"
#include "nested_cylinders.hpp"
#include "solids.hpp"

namespace vcell {

HalfSpace::HalfSpace(const Vec3& point, const Vec3& normal)
    : n(normal), d(-dot(ExactVector(normal), ExactVector(point))) {
    length = length_of(ExactVector(n));
}

const char* cuts_or_touches(Sign clearance) { return clearance == Sign::Zero ? "touches" : "cuts"; }

RadialObjects::RadialObjects(const Scene& scene) : scene_(scene), owner_(scene.objects.size()) {
    std::iota(owner_.begin(), owner_.end(), 0u);
    if (scene.base_object) owner_[*scene.base_object] = none;
}

void RadialObjects::fail(InputError::Kind kind, std::uint32_t object, const std::string& what) const {
    throw InputError(kind, scene_.number(object), object_path(scene_, object), what);
}

void RadialObjects::leave_out_unmet(std::uint32_t i) {
    owner_[i] = none;
    unmet_.push_back(object_title(scene_, i));
}

void RadialObjects::drop_hidden_and_equal(const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
    const BallNesting nesting = ball_nesting(balls.items);
    for (std::size_t i = 0; i < balls.size(); ++i) {
        if (const std::uint32_t first = nesting.first_equal[i]; first < i)
            merge(balls.objects[i], balls.objects[first]);
        if (const std::uint32_t k = nesting.enclosing[i]; k != none)
            hide(balls.objects[i], " in ", object_title(scene_, balls.objects[k]));
    }
    std::vector<std::array<Exact, 4>> rays;
    for (const HalfSpace& h : planes.items) rays.push_back({h.n.x(), h.n.y(), h.n.z(), h.d});
    // Planes that are multiples of each other are one plane, though their |n| may be told differently.
    const std::vector<std::uint32_t> first_plane = first_equal(rays);
    for (std::size_t i = 0; i < planes.size(); ++i)
        if (first_plane[i] < i) merge(planes.objects[i], planes.objects[first_plane[i]]);
    const auto containers = possible_containers(cylinders.items);
    for (std::size_t i = 0; i < cylinders.size(); ++i) drop_if_hidden(i, containers[i], rays, mirrored);
    if (cylinders.size() + mirrored.size() > 0)
        for (std::size_t i = 0; i < balls.size(); ++i) drop_if_in_cylinder(i, mirrored);
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
    for (std::size_t k = 0; k < hollow_cylinders.size(); ++k) {
        const CylinderForm& vessel = hollow_cylinders.items[k];
        drop_beyond_wall(hollow_cylinders.objects[k], [&](const auto& solid) {
            using Solid = std::decay_t<decltype(solid)>;
            if constexpr (std::is_same_v<Solid, Ball>)
                return is_beside(vessel, solid.cx, solid.cy, solid.cz, solid.rho);
            else if constexpr (std::is_same_v<Solid, HalfSpace>)
                return is_beyond({solid.n.x(), solid.n.y(), solid.n.z(), solid.d}, vessel) ||
                       is_beyond({-solid.n.x(), -solid.n.y(), -solid.n.z(), -solid.d}, vessel);
            else
                return is_beside(vessel, solid);
        });
    }
    for (std::size_t k = 0; k < hollow_cones.size(); ++k) {
        const ConeForm& vessel = hollow_cones.items[k];
        drop_beyond_wall(hollow_cones.objects[k], [&](const auto& solid) {
            using Solid = std::decay_t<decltype(solid)>;
            if constexpr (std::is_same_v<Solid, HalfSpace>)
                return is_beyond(ExactVector(solid.n), solid.d, vessel);
            else
                return is_beside(vessel, solid);
        });
    }
}

// A vessel that has another one within is never nearer than that; the first of equal ones is taken.
void RadialObjects::drop_wider_vessels() {
    const auto compare = [&](std::uint32_t i, std::uint32_t j, bool holds, bool is_held) {
        if (!is_kept(i) || !is_kept(j)) return;
        if (holds && is_held)
            merge(i, j);
        else if (holds)
            hide_beyond_wall(i, j);
        else if (is_held)
            hide_beyond_wall(j, i);
    };
    const auto holds = [](const HollowSphere& outer, const HollowSphere& inner) {
        const Exact room = Exact(outer.radius) - inner.radius;
        const ExactVector way = ExactVector(outer.center) - ExactVector(inner.center);
        return room.sign() != Sign::Negative && (room * room - dot(way, way)).sign() != Sign::Negative;
    };
    for (std::size_t i = 0; i < hollow_balls.size(); ++i) {
        const HollowSphere& ball = hollow_balls.items[i];
        for (std::size_t j = 0; j < i; ++j) {
            const HollowSphere& other = hollow_balls.items[j];
            compare(hollow_balls.objects[i], hollow_balls.objects[j], holds(ball, other), holds(other, ball));
        }
        for (std::size_t j = 0; j < hollow_cylinders.size(); ++j)
            compare(hollow_cylinders.objects[j], hollow_balls.objects[i],
                    contains(hollow_cylinders.items[j], ball.center.x(), ball.center.y(), ball.center.z(),
                             ball.radius),
                    false);
    }
    for (std::size_t i = 0; i < hollow_cylinders.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const CylinderForm &tube = hollow_cylinders.items[i], &other = hollow_cylinders.items[j];
            compare(hollow_cylinders.objects[i], hollow_cylinders.objects[j], contains(tube, other),
                    contains(other, tube));
        }
    for (std::size_t i = 0; i < hollow_cones.size(); ++i) {
        const ConeForm& cone = hollow_cones.items[i];
        for (std::size_t j = 0; j < i; ++j) {
            const ConeForm& other = hollow_cones.items[j];
            compare(hollow_cones.objects[i], hollow_cones.objects[j], contains(cone, other),
                    contains(other, cone));
        }
        for (std::size_t j = 0; j < hollow_balls.size(); ++j) {
            const HollowSphere& ball = hollow_balls.items[j];
            compare(hollow_cones.objects[i], hollow_balls.objects[j],
                    contains(cone, ball.center, ball.radius), false);
        }
    }
}

template <class IsBeyond>
void RadialObjects::drop_beyond_wall(std::uint32_t vessel, IsBeyond&& is_beyond_it) {
    if (!is_kept(vessel)) return;
    const auto look = [&](const auto& listed) {
        for (std::size_t i = 0; i < listed.size(); ++i)
            if (owner_[listed.objects[i]] != none && is_beyond_it(listed.items[i]))
                hide_beyond_wall(listed.objects[i], vessel);
    };
    look(balls);
    look(planes);
    look(cylinders);
}

void RadialObjects::warn(const FormSites& sites, std::vector<std::string>& warnings) const {
    if (!unmet_.empty())
        warnings.push_back(listed(unmet_) +
                           ": out of sight of the base, never nearest to any point of its cell");
    if (!hidden_.empty()) {
        auto sorted = hidden_;
        std::ranges::sort(sorted);
        std::vector<std::string> texts;
        for (auto& [object, text] : sorted) texts.push_back(std::move(text));
        warnings.push_back(listed(texts) + ": hidden, never nearest to any point of the cell");
    }
    if (!sites.has_shared_forms()) return;
    for (const FormId f : sites.ids()) {
        const std::span<const Site> group = sites[f];
        if (group.size() < 2) continue;
        std::string text;
        for (const Site site : group) text += (text.empty() ? "" : " and ") + competitor_title(scene_, site);
        warnings.push_back(text + ": the same distance from the base everywhere, merged");
    }
}

// What is out of a probe's reach is no matter of concern.
void RadialObjects::hide_beyond_wall(std::uint32_t object, std::uint32_t vessel) {
    if (is_cap(scene_, vessel))
        owner_[object] = none;
    else
        hide(object, " beyond the wall of ", object_title(scene_, vessel));
}

void RadialObjects::hide(std::uint32_t object, const char* how, const std::string& where) {
    owner_[object] = none;
    hidden_.emplace_back(object, object_title(scene_, object) + how + where);
}

void RadialObjects::drop_if_hidden(std::size_t i, std::span<const std::uint32_t> possible_containers,
                                   const std::vector<std::array<Exact, 4>>& half_spaces,
                                   const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
    const CylinderForm& cylinder = cylinders.items[i];
    const std::uint32_t object = cylinders.objects[i];
    for (std::size_t k = 0; k < planes.size(); ++k)
        if (is_beyond(half_spaces[k], cylinder))
            return hide(object, " beyond ", object_title(scene_, planes.objects[k]));
    for (const auto& [image, side] : mirrored)
        if (contains(image, cylinder) && !contains(cylinder, image))
            return hide(object, " beyond ", "side " + to_string(side));
    std::size_t first = i;
    for (const std::uint32_t k : possible_containers) {
        if (!contains(cylinders.items[k], cylinder)) continue;
        if (!contains(cylinder, cylinders.items[k]))
            return hide(object, " in ", object_title(scene_, cylinders.objects[k]));
        first = std::min<std::size_t>(first, k);
    }
    if (first < i) merge(object, cylinders.objects[first]);
}

void RadialObjects::drop_if_in_cylinder(std::size_t i,
                                        const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
    const Ball& ball = balls.items[i];
    const std::uint32_t object = balls.objects[i];
    if (owner_[object] == none) return;
    for (std::size_t k = 0; k < cylinders.size(); ++k)
        if (contains(cylinders.items[k], ball.cx, ball.cy, ball.cz, ball.rho))
            return hide(object, " in ", object_title(scene_, cylinders.objects[k]));
    for (const auto& [image, side] : mirrored)
        if (contains(image, ball.cx, ball.cy, ball.cz, ball.rho))
            return hide(object, " beyond ", "side " + to_string(side));
}

void FoundForms::add_twins(const RadialObjects& all) {
    for (std::uint32_t i = 0; all.has_merged() && i < of_object.size(); ++i) {
        const std::uint32_t owner = all.owner(i);
        if (owner != RadialObjects::none && owner != i && of_object[owner].valid())
            sites.join(of_object[owner], all.site(i));
    }
    sites.settle();
}

void fail_empty(const std::string& what) {
    throw InputError(InputError::Kind::EmptyBox, InputError::no_object, "box", what);
}

}  // namespace vcell
