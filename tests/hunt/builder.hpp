/// Scenes in the making, for families of them.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <variant>

#include "../../primitives/objects/message.hpp"
#include "../primitives/reference.hpp"
#include "dice.hpp"
#include "families.hpp"

namespace vcell::hunt {

/// A scene in the making: objects that touch the base or contain it are left out.
class Builder : public Dice {
public:
    Builder(std::mt19937_64& rng, BaseKind kind, double half = 2) : Dice(rng), kind_(kind) {
        scene_.box = {Vec3::Constant(-half), Vec3::Constant(half)};
    }

    BaseKind kind() const { return kind_; }
    bool is_plane() const { return kind_ == BaseKind::Plane || kind_ == BaseKind::TiltedPlane; }
    bool is_tilted() const { return kind_ == BaseKind::TiltedPlane || kind_ == BaseKind::TiltedTube; }
    /// About the origin. Directions are integers where the family's coordinates are.
    void put_base(double radius, bool of_integers = false) {
        const Vec3 d = !is_tilted() ? Vec3::UnitZ() : of_integers ? integer_direction(2) : direction();
        if (is_plane())
            scene_.base = Plane{Vec3::Zero(), d};
        else if (kind_ == BaseKind::Ball)
            scene_.base = Sphere{Vec3::Zero(), radius};
        else
            scene_.base = Cylinder{Vec3::Zero(), d, radius};
    }
    /// The base's normal or axis; for balls any direction.
    Vec3 base_direction() {
        if (const auto* p = std::get_if<Plane>(&scene_.base)) return p->normal.normalized();
        if (const auto* c = std::get_if<Cylinder>(&scene_.base)) return c->axis.normalized();
        return direction();
    }

    /// Vessels are looked at together: a plane may have nothing within two of them.
    bool add(const Object& object) {
        Scene alone = scene_;
        std::erase_if(alone.objects, [&](const Object& o) { return !is_vessel(object) || !is_vessel(o); });
        alone.objects.push_back(object);
        if (!is_legal(alone)) return false;
        if (is_plane() && is_vessel(object) && !has_room(alone)) return false;
        scene_.objects.push_back(object);
        return true;
    }
    Object random_ball() { return Sphere{place(), chance(0.2) ? 0 : uniform(0, 0.4)}; }
    Object random_plane() { return Plane{uniform(0.6, 2) * direction(), direction()}; }
    Object random_tube() { return Cylinder{place(), direction(), chance(0.2) ? 0 : uniform(0, 0.3)}; }
    /// The axis of a tube that may hold the base: any, or much that of a base tube, or just that.
    Vec3 vessel_axis() {
        const auto* c = std::get_if<Cylinder>(&scene_.base);
        if (!c || chance(0.1)) return direction();
        return chance(0.3) ? c->axis : (c->axis.normalized() + uniform(0, 0.4) * direction()).eval();
    }
    Object random_vessel() {
        const double off = chance(0.2) ? 0 : uniform(0, 1);
        const Vec3 middle = off * direction(), axis = vessel_axis();
        switch (count(0, 2)) {
            case 0: return HollowSphere{middle, uniform(0.6, 4)};
            case 1: return HollowCylinder{middle, axis, uniform(0.4, 3)};
            default: {
                const double sine = uniform(0.1, 0.95), slant = uniform(0.5, 2);
                return HollowCone{middle - uniform(0.3, 5) * axis.normalized(), axis, sine * slant, slant};
            }
        }
    }
    template <class Make>
    void add_some(int n, Make make) {
        constexpr int tries = 200;
        for (int i = 0, added = 0; i < tries && added < n; ++i) added += add(make());
    }
    void add_mix(int balls, int planes, int tubes) {
        add_some(balls, [&] { return random_ball(); });
        add_some(planes, [&] { return random_plane(); });
        add_some(tubes, [&] { return random_tube(); });
    }

    Scene& scene() { return scene_; }
    Scene done() { return std::move(scene_); }

private:
    /// Is any of some places on the base plane within all vessels? Slivers are left out.
    bool has_room(const Scene& scene) {
        const Vec3 normal = base_direction();
        constexpr int tries = 1000;
        for (int i = 0; i < tries; ++i) {
            Vec3 p = place(scene.box.max.x());
            p -= normal.dot(p) * normal;
            if (p.lpNorm<Eigen::Infinity>() < scene.box.max.x() &&
                std::ranges::all_of(scene.objects, [&](const Object& o) { return distance(o, p) > 0; }))
                return true;
        }
        return false;
    }

    BaseKind kind_;
    Scene scene_;
};

}  // namespace vcell::hunt
