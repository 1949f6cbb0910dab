/// A scene as the check sees it: plain distance functions in world coordinates, rays along the base's
/// normals.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/objects/scene.hpp"
#include "../../primitives/objects/site.hpp"
#include "curves.hpp"
#include "tube_part.hpp"

namespace vcell::check {

/// Relative to the size of the coordinates: a few hundred operations, each rounding once, lie between the
/// scene and any number of the cell.
inline constexpr double kRounding = 512 * 0x1p-53;

/// A base point's normal. The point at clearance t is foot + t direction, from t = start (less than 0 where
/// the base has a body: the ray comes from its centre or axis).
struct Ray {
    Vec3 foot, direction;
    std::array<Vec3, 2> across;  ///< with the direction an orthonormal, right-handed frame
    double start;

    Vec3 at(double t) const { return foot + t * direction; }
};

class SceneGeometry {
public:
    /// Pre: validate(scene) would pass. Keeps references. `part`: of a complete cell around the base tube.
    explicit SceneGeometry(const Scene& scene, const TubePart* part = nullptr);

    // ---- The base ----

    bool is_plane() const { return plane_ != nullptr; }
    bool is_sphere() const { return sphere_ != nullptr; }
    bool is_cylinder() const { return cylinder_ != nullptr; }

    /// Clearance of the ray through p there: the distance from the base's surface, negative inside its body.
    double height(const Vec3& p) const;
    /// The least possible one.
    double least_height() const { return -radius_; }
    /// The base's normal at the foot of p.
    Vec3 up(const Vec3& p) const;
    Ray ray(const Vec3& p) const;
    /// No base point's ray where the cell has no rays (a base that the box misses), or all that are tried
    /// have their feet within `margin` of the rim.
    std::optional<Ray> random_ray(std::mt19937_64& rng, double margin) const;

    double base_area() const;
    /// What the faces' shadows on the base add up to, between bounds: the base region's area, of spheres and
    /// cylinders at radius 1. Walls of vessels leave a part of a plane's region, of which no more is known.
    Interval shadow() const;
    /// Do walls of vessels leave a part of a plane's region, or touch its rim as far as rounding tells?
    bool has_curved_rim() const { return !walls_.empty(); }
    /// How far the base point below p is from the part of the rim that a site names; infinite if it names
    /// none.
    double distance_from_rim(const Site& s, const Vec3& p) const;
    /// Over a base plane: is it a side of the box along the normals, as far as rounding tells?
    bool is_upright(const Site& s) const;
    /// Likewise: do rays come into the box through it, and not out? So they do in a part of a tube whose axis
    /// is beyond it.
    bool lets_in(const Site& s) const;

    /// Plane: p's place in it.
    Vec2 chart(const Vec3& p) const { return {across_[0].dot(p - origin_), across_[1].dot(p - origin_)}; }

    /// How far p is from the ray's start on the side to which the ray runs. A plane's rays are lines.
    double ahead(const Ray& ray, const Vec3& p) const {
        return is_plane() ? std::numeric_limits<double>::infinity()
                          : ray.direction.dot(p - ray.at(ray.start));
    }

    // ---- Sites ----

    double scale() const { return scale_; }
    double rounding() const { return kRounding * scale_; }
    double site_rounding(const Site& s) const {
        return s.is_object() ? object_rounding_[s.index] : rounding();
    }
    bool exists(const Site& s) const;
    /// Is a side of the box across a base cylinder's axis, an end of its stretch?
    bool is_end(std::uint32_t side) const {
        return cylinder_ && cylinder_->axis[(side / 2 + 1) % 3] == 0 &&
               cylinder_->axis[(side / 2 + 2) % 3] == 0;
    }

    /// How far p lies inside the box.
    double inside_box(const Vec3& p) const;
    double distance_to(std::uint32_t object, const Vec3& p) const;
    /// How much farther than r the site is from p: 0 where it bounds the cell at clearance r.
    double excess(const Site& s, const Vec3& p, double r) const;
    /// Some object closer to p than reach, by more than rounding.
    std::optional<std::uint32_t> nearer(const Vec3& p, double reach) const;
    /// Clearance of the cell along a ray, by brute force. Objects count where they are nearer by more than
    /// rounding.
    double brute_height(const Ray& ray) const;
    /// Who bounds the cell at clearance r.
    Site owner(const Ray& ray, double r) const;

private:
    double inside_side(std::uint32_t side, const Vec3& p) const;
    double inside_end(std::uint32_t end, const Vec3& p) const;
    Vec3 from_axis(const Vec3& p) const;  // sphere: from the centre
    void find_region();
    void find_walls();
    /// A plane's places that a vessel's wall holds: a linear map takes them to a disk about 0. In a tube it
    /// looks along the axis, so that the disk is one across it, and that of a level tube is all on a line; in
    /// a cone likewise, where the radius grows along the axis.
    struct WallDisk {
        Eigen::Matrix2d linear;
        Vec2 of_origin;
        double radius_at_origin;
        Vec2 growth = Vec2::Zero();

        Vec2 operator()(const Vec2& q) const { return linear * q + of_origin; }
        double radius(const Vec2& q) const { return radius_at_origin + growth.dot(q); }
    };
    WallDisk disk_of_wall(std::uint32_t wall) const;
    std::vector<Vec2> region_in_walls(bool is_outer) const;
    void find_stretch();
    double speed(std::uint32_t side, const Vec3& direction) const;
    bool is_nearer(std::uint32_t i, const Vec3& p, double reach) const;

    const Scene& scene_;
    const TubePart* part_;
    const Plane* plane_;
    const Sphere* sphere_;
    const Cylinder* cylinder_;
    Vec3 origin_, normal_;  // of the base: a point or its centre; the plane's normal, the cylinder's axis
    std::array<Vec3, 2> across_;           // with normal_ an orthonormal, right-handed frame
    double radius_ = 0;                    // of the base
    std::vector<Vec2> region_;             // plane: a convex polygon, counter-clockwise
    std::vector<std::uint32_t> walls_;     // plane: vessels that do not hold all of it
    std::vector<Vec2> about_region_;       // plane: a polygon about what they leave of it, like that
    std::array<double, 2> stretch_{0, 0};  // cylinder: along the axis, from origin_
    double scale_ = 0;
    std::vector<double> object_rounding_;
    struct Spheres {
        std::vector<double> x, y, z, reduced_radius;  // the radius less rounding
        std::vector<std::uint32_t> object;
    } spheres_;
    std::vector<std::uint32_t> others_;  // objects that are no spheres
};

}  // namespace vcell::check
