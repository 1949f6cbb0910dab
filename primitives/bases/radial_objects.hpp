/// What becomes of a scene's objects over a sphere or a cylinder base before they have forms: which are
/// merged or left out, and whose form each one has. Exact about the scene's own doubles.
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
#include "radial_base.hpp"

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

/// For the message about a plane that is not clear of the base's body.
const char* cuts_or_touches(Sign clearance);

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
class RadialObjects {
public:
    static constexpr std::uint32_t none = UINT32_MAX;

    explicit RadialObjects(const Scene& scene);

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
    Listed<HollowSphere> hollow_balls;
    Listed<CylinderForm> hollow_cylinders;
    Listed<ConeForm> hollow_cones;

    [[noreturn]] void fail(InputError::Kind kind, std::uint32_t object, const std::string& what) const;

    /// Whose height object i has: its own, that of an equal object before it, or none.
    std::uint32_t owner(std::uint32_t i) const {
        while (i != none && owner_[i] != i) i = owner_[i];
        return i;
    }
    bool is_kept(std::uint32_t i) const { return owner_[i] == i; }
    Site site(std::uint32_t i) const { return Site::object(scene_.number(i)); }
    void merge(std::uint32_t i, std::uint32_t j) {
        owner_[std::max(i, j)] = std::min(i, j);
        has_merged_ = true;
    }
    bool has_merged() const { return has_merged_; }
    /// Pre: object i is not listed.
    void leave_out_unmet(std::uint32_t i);

    /// Leaves out what lies in other solids, cylinders beyond planes, and what lies beyond the wall of a
    /// vessel: never nearer than those, they may tie with them along whole curves of the base. `mirrored` are
    /// images of a base cylinder in sides of the box: on the side, base and image are equally far.
    void drop_hidden_and_equal(const std::vector<std::pair<CylinderForm, Site>>& mirrored);

    void warn(const FormSites& sites, std::vector<std::string>& warnings) const;

private:
    void hide(std::uint32_t object, const char* how, const std::string& where);
    void drop_if_hidden(std::size_t i, std::span<const std::uint32_t> possible_containers,
                        const std::vector<std::array<Exact, 4>>& half_spaces,
                        const std::vector<std::pair<CylinderForm, Site>>& mirrored);
    void drop_if_in_cylinder(std::size_t i, const std::vector<std::pair<CylinderForm, Site>>& mirrored);
    void drop_wider_vessels();
    template <class IsBeyond>
    void drop_beyond_wall(std::uint32_t vessel, IsBeyond&& is_beyond_it);
    void hide_beyond_wall(std::uint32_t object, std::uint32_t vessel);

    const Scene& scene_;
    std::vector<std::uint32_t> owner_;
    bool has_merged_ = false;
    std::vector<std::string> unmet_;
    std::vector<std::pair<std::uint32_t, std::string>> hidden_;  // object, where it hides
};

/// The sites of each form, and the first one as an object.
struct FoundForms {
    std::vector<FormId> of_object;
    FormSites sites;
    IdVector<FormId, Object> objects;

    explicit FoundForms(const Scene& scene) : of_object(scene.objects.size()), scene_(scene) {
        sites.reserve(of_object.size() + 6);
        objects.reserve(of_object.size() + 6);
    }
    void add(Site site, const Object& canonical) {
        objects.push_back(canonical);
        note(site, sites.add(site));
    }
    void join(Site site, FormId f) {
        sites.join(f, site);
        note(site, f);
    }
    /// The sites of objects that have another one's form.
    void add_twins(const RadialObjects& all);

private:
    void note(Site site, FormId f) {
        if (site.is_object()) of_object[scene_.place(site.index)] = f;
    }

    const Scene& scene_;
};

[[noreturn]] void fail_empty(const std::string& what);

}  // namespace vcell
