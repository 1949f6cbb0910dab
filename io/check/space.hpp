/// The scene in interval arithmetic: how far a point, or a box of points, is from the base and from every
/// site, and in which direction those distances grow. T is Interval, or Wide where that is too coarse.
///
/// Where a site bounds the cell, its *excess* is zero: of an object, its distance less the clearance; of a
/// side of the box or an end of the stretch, the distance from it inwards; of the rim of a base plane's
/// region, that of the base point below. Gradients of distances are unit vectors, so an excess changes by at
/// most twice the way.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/wide.hpp"
#include "../../primitives/objects/scene.hpp"
#include "../../primitives/objects/site.hpp"
#include "containment.hpp"
#include "crossing_walls.hpp"
#include "tube_part.hpp"
#include "vectors.hpp"

namespace vcell::check {

/// An object's surface with a direction of length one.
template <class T>
struct Surface {
    enum class Kind : std::uint8_t { plane, sphere, cylinder };

    explicit Surface(const Object& object) {
        const auto unit = [](const Vec3& v) {
            const Vector<T> w = to_vector<T>(v);
            return check::direction(w, sqrt(square(w)));
        };
        if (const auto* p = std::get_if<Plane>(&object)) {
            kind = Kind::plane;
            point = to_vector<T>(p->point);
            direction = unit(p->normal);
        } else if (const auto* s = std::get_if<Sphere>(&object)) {
            kind = Kind::sphere;
            point = to_vector<T>(s->center);
            radius = s->radius;
        } else if (const auto* c = std::get_if<Cylinder>(&object)) {
            kind = Kind::cylinder;
            point = to_vector<T>(c->point);
            direction = unit(c->axis);
            radius = c->radius;
        } else if (const auto* ball = std::get_if<HollowSphere>(&object)) {
            kind = Kind::sphere;
            is_hollow = true;
            point = to_vector<T>(ball->center);
            radius = ball->radius;
        } else if (const auto* cone = std::get_if<HollowCone>(&object)) {
            kind = Kind::cylinder;
            is_hollow = is_cone = true;
            point = to_vector<T>(cone->apex);
            direction = unit(cone->axis);
            const T wide(cone->radius), slant(cone->slant);
            sine = wide / slant;
            cosine = sqrt((slant - wide) * (slant + wide)) / slant;
        } else {
            const auto& tube = std::get<HollowCylinder>(object);
            kind = Kind::cylinder;
            is_hollow = true;
            point = to_vector<T>(tube.point);
            direction = unit(tube.axis);
            radius = tube.radius;
        }
    }

    /// Turns a plane that has the base on one side to it, so that its distance is signed. What is as far from
    /// both is on that side, too; beyond the plane the signed distance is less than the true one, and both
    /// are less than that from the base.
    void turn_to(Sign side) {
        is_sided = side != Sign::Zero;
        if (side == Sign::Negative) direction = {-direction[0], -direction[1], -direction[2]};
    }

    /// Of a plane, signed.
    T distance(const Vector<T>& p) const {
        const Vector<T> q = p - point;
        if (kind == Kind::plane) return dot(direction, q);
        if (is_cone) return sine * dot(direction, q) - cosine * length(q);
        return is_hollow ? radius - length(q) : length(q) - radius;
    }
    /// Where that distance grows.
    Vector<T> gradient(const Vector<T>& p) const {
        if (kind == Kind::plane) return direction;
        const Vector<T> out = outwards(p);
        if (is_cone) return sine * direction - cosine * out;
        return is_hollow ? Vector<T>{-out[0], -out[1], -out[2]} : out;
    }

    Kind kind;
    bool is_hollow = false;  ///< a vessel: seen from within
    bool is_sided = false;   ///< a plane whose normal points to the base: the distance is signed
    bool is_cone = false;    ///< a hollow one: the axis from its apex into it, and half its angle
    T sine{0.0}, cosine{1.0};
    Vector<T> point;      ///< of a plane; the centre, or a point of the axis
    Vector<T> direction;  ///< a plane's normal, a cylinder's axis
    T radius{0.0};

private:
    /// From the centre or the axis.
    Vector<T> outwards(const Vector<T>& p) const {
        const Vector<T> q = p - point;
        const T l = length(q);
        if (kind == Kind::sphere) return check::direction(q, l);
        return check::direction(q - dot(direction, q) * direction, l);
    }
    T length(const Vector<T>& q) const {
        return sqrt(kind == Kind::sphere ? square(q) : square(cross(q, direction)));
    }
};

/// A site as a condition on a point: that its excess is zero. The base's is the clearance: over a plane it
/// asks for a point of the base, where a vessel's wall is its region's rim.
struct Condition {
    Site site;
    /// A side of the box that bounds the region of a base plane: asked of the base point.
    bool at_rim = false;
    /// A tube that has CrossingWalls is met at one of these: the distance from that inwards is asked for, as
    /// that tube's excess all but vanishes next to the crossing.
    std::optional<std::uint8_t> wall = std::nullopt;

    /// Is the excess an object's distance less the clearance? Otherwise it is linear.
    bool is_of_object() const { return site.is_object() && !wall; }
};

template <class T>
class Space {
public:
    /// Keeps a reference to the scene. `part`: of a complete cell around the base tube.
    explicit Space(const Scene& scene, const TubePart* part = nullptr) : scene_(scene), base_(scene.base) {
        if constexpr (std::is_same_v<T, Interval>) {
            surfaces_.reserve(scene.objects.size());
            for (const Object& o : scene.objects) surfaces_.push_back(surface_of(o));
        }
        if (base_.kind == Surface<T>::Kind::cylinder) part ? find_stretch(*part) : find_stretch();
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
            if (is_beside(scene.objects[i], scene.base)) twins_of_base_.push_back(i);
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) find_walls(i);
    }

    const Scene& scene() const { return scene_; }
    const Surface<T>& base() const { return base_; }
    Surface<T> object(std::uint32_t i) const {
        if constexpr (std::is_same_v<T, Interval>)
            return surfaces_[i];
        else
            return surface_of(scene_.objects[i]);
    }

    /// Is it a plane that has the base on one side, so that its distance is signed?
    bool is_sided(std::uint32_t i) const {
        return with(i, [](const Surface<T>& s) { return s.is_sided; });
    }

    T clearance(const Vector<T>& p) const { return base_.distance(p); }
    Vector<T> up(const Vector<T>& p) const { return base_.gradient(p); }

    /// Calls use(condition) with what a site asks of points: of a tube whose axis crosses the base's it is
    /// two walls.
    template <class Use>
    void for_conditions(const Site& site, Use&& use) const {
        if (site.is_object() && walls_of(site.index)) {
            for (const std::uint8_t wall : {0, 1}) use(Condition{site, false, wall});
        } else {
            use(Condition{site});
        }
    }
    /// What it asks of a boundary's points about p.
    Condition condition_at(const Site& site, const Vec3& p) const {
        std::optional<Condition> nearest;
        double least = HUGE_VAL;
        for_conditions(site, [&](const Condition& c) {
            const double off = c.wall ? upper_bound(magnitude(excess(c, to_vector<T>(p)))) : 0;
            if (nearest && !(off < least)) return;
            nearest = c;
            least = off;
        });
        return *nearest;
    }

    T excess(const Condition& c, const Vector<T>& p) const {
        if (c.wall) return walls_of(c.site.index)->inside(*c.wall, p);
        if (c.site.is_object()) {
            const T plain = object_excess(c.site.index, p, clearance(p));
            const auto apart = is_twin_of_base(c.site.index) ? excess_of_twin(c.site.index, p) : std::nullopt;
            return apart ? intersection(plain, *apart) : plain;
        }
        if (c.site.kind == Site::Kind::End) return inside_end(c.site.index, p);
        if (c.site == Site::base()) return clearance(p);
        return inside_side(c.site.index, c.at_rim ? p - base_.distance(p) * base_.direction : p);
    }
    T object_excess(std::uint32_t i, const Vector<T>& p, const T& clearance) const {
        return with(i, [&](const Surface<T>& s) {
            const T d = s.distance(p);
            return (s.kind == Surface<T>::Kind::plane && !s.is_sided ? magnitude(d) : d) - clearance;
        });
    }

    /// Is a ball's distance from p surely greater than reach? False if the object is none.
    bool is_beyond(std::uint32_t i, const Vec3& p, double reach) const {
        const auto* s = std::get_if<Sphere>(&scene_.objects[i]);
        if (!s) return false;
        constexpr double kAbove = 1 + 0x1p-40;  // more than a few roundings
        const double limit = kAbove * (std::max(reach, 0.0) + s->radius);
        return (p - s->center).squaredNorm() > kAbove * limit * limit;
    }

    Vector<T> gradient(const Condition& c, const Vector<T>& p) const {
        if (c.wall) return negative(walls_of(c.site.index)->normals[*c.wall]);
        if (c.site.is_object()) {
            const Vector<T> plain = object_gradient(c.site.index, p) - up(p);
            const auto ways = is_twin_of_base(c.site.index) ? ways_of_twin(c.site.index, p) : std::nullopt;
            return ways ? intersection(plain, difference(ways->to, ways->from, ways->apart)) : plain;
        }
        if (c.site.kind == Site::Kind::End)
            return c.site.index == 0 ? base_.direction : negative(base_.direction);
        if (c.site == Site::base()) return up(p);
        const Vector<T> m = inwards(c.site.index);
        return c.at_rim ? m - dot(m, base_.direction) * base_.direction : m;
    }
    /// The gradient of c's excess less that of d's. Of two objects of one kind that are much alike it is as
    /// small as they are apart, also over a box of points: their unit vectors are subtracted as difference()
    /// does.
    Vector<T> gradient_difference(const Condition& c, const Condition& d, const Vector<T>& p) const {
        const Vector<T> plain = gradient(c, p) - gradient(d, p);
        const auto apart = unit_difference(c, d, p);
        return apart ? intersection(plain, *apart) : plain;
    }
    /// Are they two balls, or two planes, tubes or cones that are next to each other, both seen from without,
    /// or both from within? Only what is gained depends on the answer, and what that costs.
    bool are_alike(const Condition& c, const Condition& d) const {
        if (!c.is_of_object() || !d.is_of_object()) return false;
        const Object &a = scene_.objects[c.site.index], &b = scene_.objects[d.site.index];
        if (a.index() != b.index()) return false;
        if (std::holds_alternative<Sphere>(a) || std::holds_alternative<HollowSphere>(a)) return true;
        const double far = much * scene_.box.diagonal();
        if (const auto* plane = std::get_if<Plane>(&a)) {
            const auto& other = std::get<Plane>(b);
            const Vec3 n = plane->normal.stableNormalized();
            return n.cross(other.normal.stableNormalized()).norm() < much &&
                   std::abs(n.dot(other.point - plane->point)) < far;
        }
        const auto axis = axis_of(a), other = axis_of(b);
        if (const auto* cone = std::get_if<HollowCone>(&a), *other_cone = std::get_if<HollowCone>(&b);
            cone && !(cone->radius == other_cone->radius && cone->slant == other_cone->slant &&
                      axis.along.dot(other.along) > 0 && (other.point - axis.point).norm() < far))
            return false;
        return are_beside(axis, other);
    }
    /// Is it a ball next to a base ball, or a tube next to a base tube? What their distances and gradients
    /// differ by is known to a part of that.
    bool is_twin_of_base(std::uint32_t i) const {
        return !twins_of_base_.empty() && std::ranges::binary_search(twins_of_base_, i);
    }
    /// What the ways to p from the centre or the axis of such an object and from the base's differ by: half
    /// of the gradient of the difference of their squares. None where axes are not much alike.
    std::optional<Vector<T>> apart_from_twin(std::uint32_t i, const Vector<T>& p) const {
        const auto ways = ways_of_twin(i, p);
        return ways ? std::optional(ways->apart) : std::nullopt;
    }
    /// What the first of two planes' unit normals differs by from the second's, both towards the side that p
    /// is on, where they are much alike.
    std::optional<Vector<T>> near_normals(const Condition& c, const Condition& d, const Vector<T>& p) const {
        std::array<Vec3, 2> normals;
        for (std::size_t k = 0; k < 2; ++k) {
            const Condition& e = k == 0 ? c : d;
            const auto* plane =
                e.site.is_object() ? std::get_if<Plane>(&scene_.objects[e.site.index]) : nullptr;
            if (!plane) return std::nullopt;
            // Towards the base from those that have it on one side, whatever the box reaches across.
            const T towards = with(e.site.index, [&](const Surface<T>& s) {
                return s.is_sided ? dot(s.direction, to_vector<T>(plane->normal)) : s.distance(p);
            });
            if (!(towards.lower() > 0) && !(towards.upper() < 0)) return std::nullopt;
            normals[k] = towards.lower() > 0 ? plane->normal : Vec3(-plane->normal);
        }
        return near_difference(normals[0], normals[1]);
    }
    /// Two tubes or cones have axes that are much alike: this is how the first's differs from the second's,
    /// and the second's, both in the first's direction.
    std::optional<std::array<Vector<T>, 2>> near_axes(const Condition& c, const Condition& d) const {
        const auto axis = [&](const Condition& e) -> Vec3 {
            return axis_of(scene_.objects[e.site.index]).along;
        };
        return near_axes(axis(c), axis(d), object(d.site.index).direction);
    }
    /// `unit`: the second's of length one.
    static std::optional<std::array<Vector<T>, 2>> near_axes(const Vec3& own, const Vec3& other,
                                                             const Vector<T>& unit) {
        const bool is_opposite = own.dot(other) < 0;
        const auto turn = near_difference(own, is_opposite ? Vec3(-other) : other);
        if (!turn) return std::nullopt;
        return std::array{*turn, is_opposite ? negative(unit) : unit};
    }
    /// Of an object's distance.
    Vector<T> object_gradient(std::uint32_t i, const Vector<T>& p) const {
        return with(i, [&](const Surface<T>& s) {
            const Vector<T> n = s.gradient(p);
            if (s.kind != Surface<T>::Kind::plane || s.is_sided) return n;
            const T d = s.distance(p);
            if (d.lower() > 0) return n;
            return d.upper() < 0 ? negative(n) : hull(n, negative(n));
        });
    }

    /// How far inside the box's side, and inwards.
    T inside_side(std::uint32_t side, const Vector<T>& p) const {
        const int axis = static_cast<int>(side / 2);
        return side % 2 ? T(scene_.box.max[axis]) - p[axis] : p[axis] - T(scene_.box.min[axis]);
    }
    static Vector<T> inwards(std::uint32_t side) {
        Vector<T> m{T(0.0), T(0.0), T(0.0)};
        m[side / 2] = T(side % 2 ? -1.0 : 1.0);
        return m;
    }
    T inside_end(std::uint32_t end, const Vector<T>& p) const {
        const T y = dot(base_.direction, p - base_.point);
        return end == 0 ? y - stretch_[0] : stretch_[1] - y;
    }
    /// A base cylinder's, along its axis from its point.
    const std::array<T, 2>& stretch() const { return stretch_; }

    /// A tube next to a base tube has them with that.
    std::optional<std::array<Vector<T>, 2>> axes_of_twin(std::uint32_t i) const {
        return near_axes(std::get<Cylinder>(scene_.objects[i]).axis, std::get<Cylinder>(scene_.base).axis,
                         base_.direction);
    }

private:
    static constexpr double much = 0x1p-6;  // of what objects next to each other differ by

    /// Tubes and cones have one, of any length.
    struct Axis {
        Vec3 point, along;
    };
    static Axis axis_of(const Object& object) {
        if (const auto* tube = std::get_if<Cylinder>(&object)) return {tube->point, tube->axis};
        if (const auto* tube = std::get_if<HollowCylinder>(&object)) return {tube->point, tube->axis};
        const auto& cone = std::get<HollowCone>(object);
        return {cone.apex, cone.axis};
    }
    bool are_beside(const Axis& a, const Axis& b) const {
        const Vec3 along = a.along.stableNormalized();
        return along.cross(b.along.stableNormalized()).norm() < much &&
               along.cross(b.point - a.point).norm() < much * scene_.box.diagonal();
    }
    bool is_beside(const Object& a, const Object& b) const {
        if (const auto* ball = std::get_if<Sphere>(&a), *other = std::get_if<Sphere>(&b); ball && other)
            return (other->center - ball->center).norm() < much * scene_.box.diagonal();
        return std::holds_alternative<Cylinder>(a) && std::holds_alternative<Cylinder>(b) &&
               are_beside(axis_of(a), axis_of(b));
    }

    /// The ways to p from the centre or the axis of a body, and of one like it, and what they differ by.
    struct Ways {
        Vector<T> to, from, apart;
    };
    static Ways ways_between(const Surface<T>& first, const Surface<T>& second, const Vector<T>& p,
                             const std::optional<std::array<Vector<T>, 2>>& axes) {
        const Vector<T> way = second.point - first.point, from = p - first.point, to = p - second.point;
        if (!axes) return {from, to, way};
        const auto& [turn, f] = *axes;
        const T along = dot(first.direction, from);
        return {from - along * first.direction, to - dot(f, to) * f,
                way - along * turn - (dot(from, turn) + dot(way, f)) * f};
    }
    std::optional<Ways> ways_of_twin(std::uint32_t i, const Vector<T>& p) const {
        if (base_.kind == Surface<T>::Kind::sphere) return ways_between(object(i), base_, p, {});
        const auto axes = axes_of_twin(i);
        return axes ? std::optional(ways_between(object(i), base_, p, axes)) : std::nullopt;
    }
    /// |a| - |b| = (a - b) (a + b) / (|a| + |b|).
    std::optional<T> excess_of_twin(std::uint32_t i, const Vector<T>& p) const {
        const auto ways = ways_of_twin(i, p);
        if (!ways) return std::nullopt;
        const T sum = sqrt(square(ways->to)) + sqrt(square(ways->from));
        if (!(sum.lower() > 0)) return std::nullopt;
        return dot(ways->apart, ways->to + ways->from) / sum - (object(i).radius - base_.radius);
    }

    const CrossingWalls<T>* walls_of(std::uint32_t i) const {
        const auto known = std::ranges::lower_bound(walls_, i, {}, [](const auto& w) { return w.first; });
        return known != walls_.end() && known->first == i ? &known->second : nullptr;
    }
    /// A tube that crosses the stretch itself has none: that is a part's, on one side of all crossings.
    void find_walls(std::uint32_t i) {
        const auto *tube = std::get_if<Cylinder>(&scene_.objects[i]),
                   *base = std::get_if<Cylinder>(&scene_.base);
        if (!tube || !base || !cross_equally(*base, *tube)) return;
        for (const bool is_beyond : {true, false}) {
            const CrossingWalls<T> walls(*base, *tube, is_beyond);
            const T y = dot(base_.direction, walls.point - base_.point);
            if (is_beyond ? y.upper() < stretch_[0].lower() : y.lower() > stretch_[1].upper())
                walls_.emplace_back(i, walls);
        }
    }

    template <class F>
    auto with(std::uint32_t i, F f) const {
        if constexpr (std::is_same_v<T, Interval>) {
            return f(surfaces_[i]);
        } else {
            // Directions of many digits take time, and few objects are asked for.
            for (const auto& [object, surface] : known_)
                if (object == i) return f(surface);
            known_.emplace_back(i, surface_of(scene_.objects[i]));
            return f(known_.back().second);
        }
    }
    Surface<T> surface_of(const Object& object) const {
        Surface<T> surface(object);
        if (const auto* plane = std::get_if<Plane>(&object)) surface.turn_to(side_of_base(*plane, scene_));
        return surface;
    }
    static Vector<T> negative(const Vector<T>& v) { return {-v[0], -v[1], -v[2]}; }
    static T intersection(const T& a, const T& b) {
        return T(std::max(a.lower(), b.lower()), std::min(a.upper(), b.upper()));
    }
    static Vector<T> intersection(const Vector<T>& a, const Vector<T>& b) {
        return {intersection(a[0], b[0]), intersection(a[1], b[1]), intersection(a[2], b[2])};
    }
    /// a / |a| - b / |b| of vectors in much the same direction. Where their lengths differ much b is taken as
    /// long as a, and two doubles have what that makes of it: nothing rounds a - b.
    static std::optional<Vector<T>> near_difference(const Vec3& a, const Vec3& b) {
        constexpr double least_exact = 0x1p-900;
        double ratio = a.stableNorm() / b.stableNorm();
        if (std::abs(ratio - 1) < much) ratio = 1;
        Vector<T> e, f, way;
        for (std::size_t k = 0; k < 3; ++k) {
            const double own = a[static_cast<Eigen::Index>(k)], other = b[static_cast<Eigen::Index>(k)],
                         high = ratio * other, low = std::fma(ratio, other, -high);
            const bool is_exact = ratio == 1 || std::abs(high) > least_exact;
            e[k] = T(own);
            f[k] = T(ratio) * T(other);
            way[k] = is_exact ? (T(own) - T(high)) - T(low) : e[k] - f[k];
        }
        if (!((square(way) - T(much) * square(e)).upper() < 0)) return std::nullopt;
        return difference(e, f, way);
    }
    /// a / |a| - b / |b| = (a - b - ((s - t) / t) b) / s with the lengths s and t, s - t = (a - b) (a + b) /
    /// (s + t). `way`: a - b.
    static Vector<T> difference(const Vector<T>& a, const Vector<T>& b, const Vector<T>& way) {
        const T s = sqrt(square(a)), t = sqrt(square(b));
        return T(1.0) / s * (way - dot(way, a + b) / (s + t) * check::direction(b, t));
    }
    /// What gradients of distances differ by. From tubes with points a and b and unit axes e and f the ways v
    /// = p - a - (e (p - a)) e differ by b - a - (e (p - a)) (e - f) - ((p - a) (e - f) + (b - a) f) f.
    std::optional<Vector<T>> unit_difference(const Condition& c, const Condition& d,
                                             const Vector<T>& p) const {
        if (!are_alike(c, d)) return std::nullopt;
        if (const auto turn = near_normals(c, d, p)) return turn;
        const Surface<T> first = object(c.site.index), second = object(d.site.index);
        if (first.kind == Surface<T>::Kind::plane) return std::nullopt;
        std::optional<std::array<Vector<T>, 2>> axes;
        if (first.kind == Surface<T>::Kind::cylinder) {
            axes = near_axes(c, d);
            if (!axes) return std::nullopt;
        }
        const Ways ways = ways_between(first, second, p, axes);
        const Vector<T> outwards = difference(ways.to, ways.from, ways.apart);
        if (first.is_cone) return first.sine * (*axes)[0] - first.cosine * outwards;
        return first.is_hollow ? negative(outwards) : outwards;
    }

    /// A circle about the axis reaches as far towards a side as its radius times the sine of their angle.
    /// Very small radii count as larger (docs/files.md).
    void find_stretch() {
        const double radius =
            std::max(std::get<Cylinder>(scene_.base).radius, 0x1p-26 * scene_.box.diagonal());
        stretch_ = {T(-HUGE_VAL), T(HUGE_VAL)};
        for (std::uint32_t s = 0; s < 6; ++s) {
            const T along = -dot(inwards(s), base_.direction);
            const T sine =
                sqrt(square(cross(inwards(s), base_.direction)));  // exactly 0 for axis-parallel ones
            const T room = inside_side(s, base_.point) - T(radius) * sine;
            if (!(along.lower() > 0) && !(along.upper() < 0)) continue;
            const T end = room / along;
            if (along.lower() > 0)
                stretch_[1] = {std::min(stretch_[1].lower(), end.lower()),
                               std::min(stretch_[1].upper(), end.upper())};
            else
                stretch_[0] = {std::max(stretch_[0].lower(), end.lower()),
                               std::max(stretch_[0].upper(), end.upper())};
        }
    }

    /// Ends are where they are stated to be, to the rounding of their numbers.
    void find_stretch(const TubePart& part) {
        constexpr double roundings = 0x1p-50;
        for (std::size_t k = 0; k < 2; ++k) {
            const double r = roundings * (part.ends[k].cwiseAbs() + base_middle()).sum();
            stretch_[k] = dot(base_.direction, to_vector<T>(part.ends[k]) - base_.point) + T(-r, r);
        }
    }
    Vec3 base_middle() const { return std::get<Cylinder>(scene_.base).point.cwiseAbs(); }

    const Scene& scene_;
    Surface<T> base_;
    std::vector<Surface<T>> surfaces_;                                 // of all objects, where T is Interval
    std::vector<std::uint32_t> twins_of_base_;                         // ascending
    mutable std::vector<std::pair<std::uint32_t, Surface<T>>> known_;  // of those asked for, elsewhere
    std::vector<std::pair<std::uint32_t, CrossingWalls<T>>> walls_;    // by objects, ascending
    std::array<T, 2> stretch_;
};

// space.cpp compiles them, once.
extern template struct Surface<Interval>;
extern template struct Surface<Wide>;
extern template class Space<Interval>;
extern template class Space<Wide>;

}  // namespace vcell::check
