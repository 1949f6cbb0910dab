/// What becomes of a scene's objects before they have forms over a base: which are merged or left out, and
/// whose form each one has. Exact about the scene's own doubles.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../forms/cylinder_form.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"
#include "cone_form.hpp"

namespace vcell {

/// n.p + d > 0 on the base's side.
struct HalfSpace {
    Vec3 n;
    Exact d, length;  ///< |n| as length_of() has it

    /// One of the plane's two.
    HalfSpace(const Vec3& point, const Vec3& normal);
    HalfSpace operator-() const {
        HalfSpace other = *this;
        other.n = -n;
        other.d = -d;
        return other;
    }
    Exact operator()(const ExactVector& p) const { return dot(ExactVector(n), p) + d; }
};

/// A tube as it lies in the world, its axis scaled.
template <class Tube>
CylinderForm world_form(const Tube& tube) {
    const Vec3 a = scaled_axis(tube.axis), &p = tube.point;
    return {p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), tube.radius};
}

/// A side of the box, x[axis] <= bound or >= bound.
struct WorldSide {
    int axis;
    double sign, bound;

    WorldSide(const Box& box, std::uint32_t side)
        : axis(static_cast<int>(side / 2)),
          sign(side % 2 == 0 ? -1 : 1),
          bound(side % 2 == 0 ? box.min[axis] : box.max[axis]) {}

    /// Outward.
    Vec3 normal() const {
        Vec3 n = Vec3::Zero();
        n[axis] = sign;
        return n;
    }
    /// From a point within to the side.
    Exact distance(const Vec3& p) const { return sign * (Exact(bound) - p[axis]); }
};

/// The objects in world coordinates, by kinds.
class WorldObjects {
public:
    static constexpr std::uint32_t none = UINT32_MAX;

    explicit WorldObjects(const Scene& scene);

    template <class T>
    struct Listed {
        std::vector<T> items;
        std::vector<std::uint32_t> objects;  ///< ascending

        void reserve(std::size_t n) {
            items.reserve(n);
            objects.reserve(n);
        }
        void add(const T& item, std::uint32_t object) {
            items.push_back(item);
            objects.push_back(object);
        }
        std::size_t size() const { return items.size(); }
        /// Pre: the object is listed.
        const T& of(std::uint32_t object) const {
            return items[std::ranges::lower_bound(objects, object) - objects.begin()];
        }
    };
    Listed<Ball> balls;
    Listed<HalfSpace> planes;
    Listed<CylinderForm> cylinders;
    Listed<CylinderForm> hollow_cylinders;
    Listed<ConeForm> hollow_cones;

    [[noreturn]] void fail(InputError::Kind kind, std::uint32_t object, const std::string& what) const;

    /// Whose height object i has: its own, that of an equal object before it, or none.
    std::uint32_t owner(std::uint32_t i) const {
        while (i != none && owner_[i] != i) i = owner_[i];
        return i;
    }
    bool is_kept(std::uint32_t i) const { return owner_[i] == i; }
    /// Calls use(item, object) for those of one kind that are kept.
    template <class T, class Use>
    void for_kept(const Listed<T>& listed, Use&& use) const {
        for (std::size_t i = 0; i < listed.size(); ++i)
            if (is_kept(listed.objects[i])) use(listed.items[i], listed.objects[i]);
    }
    Site site(std::uint32_t i) const { return Site::object(scene_.number(i)); }
    void merge(std::uint32_t i, std::uint32_t j) {
        owner_[std::max(i, j)] = std::min(i, j);
        has_merged_ = true;
    }
    bool has_merged() const { return has_merged_; }
    /// It is never nearest to any point of the cell, whatever else there is.
    void leave_out_unmet(std::uint32_t i);

    /// (n, d) of each plane.
    std::vector<std::array<Exact, 4>> half_spaces() const;
    /// Leaves out cylinders that lie beyond a wall n.p + d = 0, beyond an image of the base in a side of the
    /// box, or in another cylinder, and balls in cylinders or images. The first one of equal cylinders stands
    /// for all.
    void drop_hidden_by_cylinders(std::span<const std::array<Exact, 4>> walls, std::span<const Site> of_walls,
                                  std::span<const std::pair<CylinderForm, Site>> mirrored);

    /// Leaves out hollow cylinders that have another one within, which is nearer, and such cones. The first
    /// one of equal ones stands for all.
    void drop_wider_tubes_and_cones();

    /// Leaves out what lies beyond the wall of a hollow cylinder or cone: where something of the vessel's
    /// inside is on the way to it, the wall is nearer, at best as near. Such ties may run along whole curves
    /// of the base.
    void drop_beyond_tubes_and_cones();
    /// Is the plane n.p + d = 0, given as (nx, ny, nz, d), with the base on its positive side beyond such a
    /// wall?
    bool has_beyond_wall(const std::array<Exact, 4>& plane) const;

    /// `unmet`: where objects are that were left out as unmet.
    void warn(const FormSites& sites, const char* unmet, std::vector<std::string>& warnings) const;

protected:
    /// Leaves an object out that another competitor hides. What is out of a probe's reach is no matter of
    /// concern.
    void hide(std::uint32_t object, const char* how, Site by);
    void hide_beyond_wall(std::uint32_t object, std::uint32_t vessel) {
        hide(object, " beyond the wall of ", site(vessel));
    }
    /// Leaves out all balls, planes and cylinders that are beyond it.
    template <class IsBeyond>
    void drop_beyond_wall(std::uint32_t vessel, IsBeyond&& is_beyond_it) {
        if (!is_kept(vessel)) return;
        const auto look = [&](const auto& listed) {
            for (std::size_t i = 0; i < listed.size(); ++i)
                if (!is_left_out(listed.objects[i]) && is_beyond_it(listed.items[i]))
                    hide_beyond_wall(listed.objects[i], vessel);
        };
        look(balls);
        look(planes);
        look(cylinders);
    }
    /// Leaves out the wider one of two vessels, or the later one of equal ones, given whether the first one
    /// holds the other one and is held by it.
    void drop_wider(std::uint32_t i, std::uint32_t j, bool holds, bool is_held);
    bool is_left_out(std::uint32_t i) const { return owner_[i] == none; }

    const Scene& scene_;

private:
    std::vector<std::uint32_t> owner_;
    bool has_merged_ = false;
    std::vector<std::uint32_t> unmet_;
    std::vector<std::pair<std::uint32_t, std::string>> hidden_;  // object, where it hides
};

}  // namespace vcell
