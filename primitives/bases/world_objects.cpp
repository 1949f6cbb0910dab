#include "world_objects.hpp"

#include <numeric>
#include <type_traits>

#include "../objects/decided_scene.hpp"
#include "nested_cylinders.hpp"
#include "solids.hpp"

namespace vcell {

HalfSpace::HalfSpace(const Vec3& point, const Vec3& normal)
    : n(normal), d(-dot(ExactVector(normal), ExactVector(point))) {
    length = length_of(ExactVector(n));
}

WorldObjects::WorldObjects(const Scene& scene) : scene_(scene), owner_(scene.objects.size()) {
    std::iota(owner_.begin(), owner_.end(), 0u);
    if (scene.base_object) owner_[*scene.base_object] = none;
}

void WorldObjects::fail(InputError::Kind kind, std::uint32_t object, const std::string& what) const {
    throw InputError(kind, scene_.number(object), object_path(scene_, object), what);
}

void WorldObjects::leave_out_unmet(std::uint32_t i) {
    owner_[i] = none;
    unmet_.push_back(i);
}

void WorldObjects::hide(std::uint32_t object, const char* how, Site by) {
    owner_[object] = none;
    if (by.is_object() && is_cap(scene_, scene_.place(by.index))) return;
    hidden_.emplace_back(object, object_title(scene_, object) + how + competitor_title(scene_, by));
}

std::vector<std::array<Exact, 4>> WorldObjects::half_spaces() const {
    std::vector<std::array<Exact, 4>> rays;
    for (const HalfSpace& h : planes.items) rays.push_back({h.n.x(), h.n.y(), h.n.z(), h.d});
    return rays;
}

void WorldObjects::drop_hidden_by_cylinders(std::span<const std::array<Exact, 4>> walls,
                                            std::span<const Site> of_walls,
                                            std::span<const std::pair<CylinderForm, Site>> mirrored) {
    const auto containers = possible_containers(cylinders.items);
    const auto drop = [&](std::size_t i) {
        const CylinderForm& cylinder = cylinders.items[i];
        const std::uint32_t object = cylinders.objects[i];
        for (std::size_t k = 0; k < walls.size(); ++k)
            if (is_beyond(walls[k], cylinder)) return hide(object, " beyond ", of_walls[k]);
        for (const auto& [image, side] : mirrored)
            if (contains(image, cylinder) && !contains(cylinder, image))
                return hide(object, " beyond ", side);
        std::size_t first = i;
        for (const std::uint32_t k : containers[i]) {
            if (!contains(cylinders.items[k], cylinder)) continue;
            if (!contains(cylinder, cylinders.items[k]))
                return hide(object, " in ", site(cylinders.objects[k]));
            first = std::min<std::size_t>(first, k);
        }
        if (first < i) merge(object, cylinders.objects[first]);
    };
    for (std::size_t i = 0; i < cylinders.size(); ++i) drop(i);
    if (cylinders.size() + mirrored.size() == 0) return;
    const auto drop_ball = [&](const Ball& ball, std::uint32_t object) {
        const auto is_in = [&](const CylinderForm& c) {
            return contains(c, ball.cx, ball.cy, ball.cz, ball.rho);
        };
        for (std::size_t k = 0; k < cylinders.size(); ++k)
            if (is_in(cylinders.items[k])) return hide(object, " in ", site(cylinders.objects[k]));
        for (const auto& [image, side] : mirrored)
            if (is_in(image)) return hide(object, " beyond ", side);
    };
    for (std::size_t i = 0; i < balls.size(); ++i)
        if (!is_left_out(balls.objects[i])) drop_ball(balls.items[i], balls.objects[i]);
}

void WorldObjects::drop_wider(std::uint32_t i, std::uint32_t j, bool holds, bool is_held) {
    if (!is_kept(i) || !is_kept(j)) return;
    if (holds && is_held)
        merge(i, j);
    else if (holds)
        hide_beyond_wall(i, j);
    else if (is_held)
        hide_beyond_wall(j, i);
}

void WorldObjects::drop_wider_tubes_and_cones() {
    const auto among = [&](const auto& vessels) {
        for (std::size_t i = 0; i < vessels.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                drop_wider(vessels.objects[i], vessels.objects[j],
                           contains(vessels.items[i], vessels.items[j]),
                           contains(vessels.items[j], vessels.items[i]));
    };
    among(hollow_cylinders);
    among(hollow_cones);
}

void WorldObjects::drop_beyond_tubes_and_cones() {
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

bool WorldObjects::has_beyond_wall(const std::array<Exact, 4>& plane) const {
    const auto& [x, y, z, d] = plane;
    bool has = false;
    for_kept(hollow_cylinders, [&](const CylinderForm& vessel, std::uint32_t) {
        has = has || is_beyond({-x, -y, -z, -d}, vessel);
    });
    for_kept(hollow_cones, [&](const ConeForm& vessel, std::uint32_t) {
        has = has || is_beyond(ExactVector{x, y, z}, d, vessel);
    });
    return has;
}

void WorldObjects::warn(const FormSites& sites, const char* unmet, std::vector<std::string>& warnings) const {
    if (!unmet_.empty()) {
        auto sorted = unmet_;
        std::ranges::sort(sorted);
        std::vector<std::string> titles;
        for (const std::uint32_t i : sorted) titles.push_back(object_title(scene_, i));
        warnings.push_back(listed(titles) + ": " + unmet + ", never nearest to any point of its cell");
    }
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

}  // namespace vcell
