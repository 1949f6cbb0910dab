#include "scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <variant>

namespace vcell::check {

namespace {

double distance(const Plane& o, const Vec3& p) {
    return std::abs(o.normal.dot(p - o.point)) / o.normal.norm();
}
double distance(const Sphere& o, const Vec3& p) { return (p - o.center).norm() - o.radius; }
double distance(const Cylinder& o, const Vec3& p) {
    return o.axis.cross(p - o.point).norm() / o.axis.norm() - o.radius;
}
double distance(const HollowSphere& o, const Vec3& p) { return o.radius - (p - o.center).norm(); }
double distance(const HollowCylinder& o, const Vec3& p) {
    return o.radius - o.axis.cross(p - o.point).norm() / o.axis.norm();
}
double distance(const HollowCone& o, const Vec3& p) {
    const double sine = o.radius / o.slant, length = o.axis.norm();
    return (sine * o.axis.dot(p - o.apex) -
            std::sqrt((o.slant - o.radius) / o.slant * (1 + sine)) * o.axis.cross(p - o.apex).norm()) /
           length;
}
double distance(const Object& o, const Vec3& p) {
    return std::visit([&](const auto& x) { return distance(x, p); }, o);
}

/// Size of the numbers that enter the distance, for its rounding.
double extent(const Plane& o) { return o.point.norm(); }
double extent(const Sphere& o) { return o.center.norm() + o.radius; }
double extent(const Cylinder& o) { return o.point.norm() + o.radius; }
double extent(const HollowSphere& o) { return o.center.norm() + o.radius; }
double extent(const HollowCylinder& o) { return o.point.norm() + o.radius; }
double extent(const HollowCone& o) { return o.apex.norm(); }

double area(const std::vector<Vec2>& polygon) {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 p = polygon[i] - polygon[0], q = polygon[(i + 1) % polygon.size()] - polygon[0];
        sum += 0.5 * (p.x() * q.y() - p.y() * q.x());
    }
    return sum;
}

/// Uniform in a convex polygon, which may be a sliver. Pre: it has three corners.
Vec2 random_point(std::mt19937_64& rng, const std::vector<Vec2>& polygon) {
    std::uniform_real_distribution<double> unit(0, 1);
    const Vec2& corner = polygon[0];
    double left = area(polygon) * unit(rng), a = unit(rng), b = unit(rng);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    for (std::size_t i = 1;; ++i) {
        const Vec2 p = polygon[i] - corner, q = polygon[i + 1] - corner;
        left -= 0.5 * (p.x() * q.y() - p.y() * q.x());
        if (left < 0 || i + 2 == polygon.size()) return corner + a * p + b * q;
    }
}

/// The part of a convex polygon where a linear function is not negative.
template <class Linear>
std::vector<Vec2> cut(const std::vector<Vec2>& polygon, const Linear& inside) {
    std::vector<Vec2> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double dp = inside(p), dq = inside(q);
        if (dp >= 0) kept.push_back(p);
        if ((dp >= 0) != (dq >= 0)) kept.push_back(p + dp / (dp - dq) * (q - p));
    }
    return kept;
}

/// Is q inside a convex counter-clockwise polygon, at least `margin` from each side?
bool within(const std::vector<Vec2>& polygon, const Vec2& q, double margin) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2 d = polygon[(i + 1) % polygon.size()] - polygon[i], r = q - polygon[i];
        if (d.x() * r.y() - d.y() * r.x() < margin * d.norm()) return false;
    }
    return true;
}

}  // namespace

SceneGeometry::SceneGeometry(const Scene& scene, const TubePart* part)
    : scene_(scene),
      part_(part),
      plane_(std::get_if<Plane>(&scene.base)),
      sphere_(std::get_if<Sphere>(&scene.base)),
      cylinder_(std::get_if<Cylinder>(&scene.base)) {
    normal_ = Vec3::UnitZ();
    if (plane_) {
        origin_ = plane_->point;
        normal_ = plane_->normal.normalized();
    } else if (sphere_) {
        origin_ = sphere_->center;
        radius_ = sphere_->radius;
    } else {
        origin_ = cylinder_->point;
        normal_ = cylinder_->axis.normalized();
        radius_ = cylinder_->radius;
    }
    across_[0] = normal_.unitOrthogonal();
    across_[1] = normal_.cross(across_[0]);
    scale_ = std::max({scene.box.min.norm(), scene.box.max.norm(), origin_.norm() + radius_}) +
             scene.box.diagonal();
    if (plane_) find_region();
    if (cylinder_) find_stretch();
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        const Object& o = scene.objects[i];
        const double size = std::visit([](const auto& x) { return extent(x); }, o);
        object_rounding_.push_back(kRounding * (scale_ + size));
        if (!scene.competes(i)) continue;
        if (const auto* s = std::get_if<Sphere>(&o)) {
            spheres_.x.push_back(s->center.x());
            spheres_.y.push_back(s->center.y());
            spheres_.z.push_back(s->center.z());
            spheres_.reduced_radius.push_back(s->radius - object_rounding_.back());
            spheres_.object.push_back(i);
        } else {
            others_.push_back(i);
        }
    }
    if (plane_) find_walls();
}

// --- The base ------------------------------------------------------------------------------------------

Vec3 SceneGeometry::from_axis(const Vec3& p) const {
    const Vec3 q = p - origin_;
    return sphere_ ? q : Vec3(q - normal_.dot(q) * normal_);
}

double SceneGeometry::height(const Vec3& p) const {
    return plane_ ? normal_.dot(p - origin_) : from_axis(p).norm() - radius_;
}

Vec3 SceneGeometry::up(const Vec3& p) const { return plane_ ? normal_ : from_axis(p).normalized(); }

Ray SceneGeometry::ray(const Vec3& p) const {
    const Vec3 direction = up(p), foot = p - height(p) * direction;
    const Vec3 side = cylinder_ ? normal_ : direction.unitOrthogonal();
    return {foot, direction, {side, direction.cross(side)}, plane_ ? 0 : -radius_};
}

std::optional<Ray> SceneGeometry::random_ray(std::mt19937_64& rng, double margin) const {
    std::uniform_real_distribution<double> unit(0, 1);
    const double turn = 2 * std::numbers::pi * unit(rng);
    // As far away as the box is large, in whatever unit.
    const double reach = scene_.box.diagonal();
    const Vec3 around = std::cos(turn) * across_[0] + std::sin(turn) * across_[1];
    if (sphere_) {
        // Archimedes: a uniform height on the axis gives a uniform point of the sphere.
        const double z = 2 * unit(rng) - 1;
        return ray(origin_ + reach * (z * normal_ + std::sqrt(1 - z * z) * around));
    }
    if (cylinder_) {
        const double length = stretch_[1] - stretch_[0];
        if (!(length > 2 * margin)) return std::nullopt;
        return ray(origin_ + (stretch_[0] + margin + unit(rng) * (length - 2 * margin)) * normal_ +
                   reach * around);
    }
    const std::vector<Vec2>& region = about_region_;
    if (region.size() < 3) return std::nullopt;
    for (int tries = 0; tries < 100; ++tries) {  // walls may leave little of the polygon
        const Vec2 q = random_point(rng, region);
        const Vec3 p = origin_ + q.x() * across_[0] + q.y() * across_[1];
        const auto is_within = [&](std::uint32_t wall) { return distance_to(wall, p) >= margin; };
        // Walls tell by themselves: a side of the polygon about them may be a rounding, of any direction.
        if (within(region_, q, margin) && std::ranges::all_of(walls_, is_within)) return ray(p);
    }
    return std::nullopt;
}

double SceneGeometry::base_area() const {
    constexpr double pi = std::numbers::pi;
    if (sphere_) return 4 * pi * radius_ * radius_;
    if (cylinder_) return 2 * pi * radius_ * (stretch_[1] - stretch_[0]);
    return area(region_);
}

Interval SceneGeometry::shadow() const {
    constexpr double pi = std::numbers::pi;
    if (plane_) return {area(region_in_walls(false)), area(about_region_)};
    return sphere_ ? 4 * pi : 2 * pi * (stretch_[1] - stretch_[0]);
}

SceneGeometry::WallDisk SceneGeometry::disk_of_wall(std::uint32_t wall) const {
    const Object& vessel = scene_.objects[wall];
    if (const auto* ball = std::get_if<HollowSphere>(&vessel)) {
        const double h = height(ball->center);
        return {Eigen::Matrix2d::Identity(), -chart(ball->center),
                std::sqrt(std::max(0.0, (ball->radius - h) * (ball->radius + h)))};
    }
    const auto* cone = std::get_if<HollowCone>(&vessel);
    const auto* tube = std::get_if<HollowCylinder>(&vessel);
    const Vec3 axis = (cone ? cone->axis : tube->axis).normalized(), first = axis.unitOrthogonal(),
               way = origin_ - (cone ? cone->apex : tube->point);
    Eigen::Matrix<double, 2, 3> across;
    across << first.transpose(), axis.cross(first).transpose();
    Eigen::Matrix2d linear;
    linear << across * across_[0], across * across_[1];
    if (!cone) return {linear, across * way, tube->radius};
    const double tangent = cone->sine() / cone->cosine();
    return {linear, across * way, tangent * axis.dot(way),
            tangent * Vec2(axis.dot(across_[0]), axis.dot(across_[1]))};
}

/// Regular polygons in the disk that a wall leaves and about it take its place.
std::vector<Vec2> SceneGeometry::region_in_walls(bool is_outer) const {
    constexpr int sides = 256;
    std::vector<Vec2> region = region_;
    for (const std::uint32_t wall : walls_) {
        const WallDisk disk = disk_of_wall(wall);
        const double part = is_outer ? 1 : std::cos(std::numbers::pi / sides);
        for (int k = 0; k < sides && !region.empty(); ++k) {
            const double turn = 2 * std::numbers::pi * k / sides;
            const Vec2 u(std::cos(turn), std::sin(turn));
            region = cut(region, [&](const Vec2& q) { return part * disk.radius(q) - u.dot(disk(q)); });
        }
    }
    return region;
}

double SceneGeometry::distance_from_rim(const Site& s, const Vec3& p) const {
    if (plane_ && s.kind == Site::Kind::BoxSide)
        return std::abs(inside_side(s.index, p - height(p) * normal_));
    if (plane_ && s.is_object() && is_vessel(scene_.objects[s.index]))
        return std::abs(distance_to(s.index, p - height(p) * normal_));
    if (cylinder_ && s.kind == Site::Kind::End) return std::abs(inside_end(s.index, p));
    return HUGE_VAL;
}

bool SceneGeometry::is_upright(const Site& s) const {
    constexpr double rounding = 0x1p-50;
    return plane_ && s.kind == Site::Kind::BoxSide && std::abs(normal_[s.index / 2]) <= rounding;
}

bool SceneGeometry::lets_in(const Site& s) const {
    if (part_) return s.kind == Site::Kind::BoxSide && part_->is_beyond[s.index];
    return plane_ && s.kind == Site::Kind::BoxSide && !is_upright(s) && speed(s.index, normal_) < 0;
}

/// A large square about the box's shadow, cut by the six sides.
void SceneGeometry::find_region() {
    const Vec2 c = chart(0.5 * (scene_.box.min + scene_.box.max));
    const double m = scene_.box.diagonal();
    region_ = {c + Vec2(-m, -m), c + Vec2(m, -m), c + Vec2(m, m), c + Vec2(-m, m)};
    for (std::uint32_t s = 0; s < 6; ++s) {
        const auto inside = [&](const Vec2& q) {
            return inside_side(s, origin_ + q.x() * across_[0] + q.y() * across_[1]);
        };
        region_ = cut(region_, inside);
    }
}

void SceneGeometry::find_walls() {
    for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
        const Object& o = scene_.objects[i];
        if (!scene_.competes(i) || !is_vessel(o)) continue;
        const auto is_within = [&](const Vec2& q) {
            return distance_to(i, origin_ + q.x() * across_[0] + q.y() * across_[1]) > object_rounding_[i];
        };
        if (!std::ranges::all_of(region_, is_within)) walls_.push_back(i);
    }
    about_region_ = region_in_walls(true);
}

/// A circle about the axis reaches as far towards a side as its radius times the sine of their angle. Very
/// small ones count as larger (docs/files.md).
void SceneGeometry::find_stretch() {
    if (part_) {
        for (std::size_t k = 0; k < 2; ++k) stretch_[k] = normal_.dot(part_->ends[k] - origin_);
        return;
    }
    const double radius = std::max(radius_, 0x1p-26 * scene_.box.diagonal());
    stretch_ = {-HUGE_VAL, HUGE_VAL};
    for (std::uint32_t s = 0; s < 6; ++s) {
        const double along = speed(s, normal_);
        const double room = inside_side(s, origin_) - radius * std::sqrt(std::max(0.0, 1 - along * along));
        if (along > 0) stretch_[1] = std::min(stretch_[1], room / along);
        if (along < 0) stretch_[0] = std::max(stretch_[0], room / along);
    }
}

// --- Sites ---------------------------------------------------------------------------------------------

double SceneGeometry::inside_side(std::uint32_t side, const Vec3& p) const {
    const int axis = static_cast<int>(side / 2);
    return side % 2 ? scene_.box.max[axis] - p[axis] : p[axis] - scene_.box.min[axis];
}

double SceneGeometry::speed(std::uint32_t side, const Vec3& direction) const {
    return side % 2 ? direction[side / 2] : -direction[side / 2];
}

double SceneGeometry::inside_end(std::uint32_t end, const Vec3& p) const {
    const double y = normal_.dot(p - origin_);
    return end == 0 ? y - stretch_[0] : stretch_[1] - y;
}

double SceneGeometry::inside_box(const Vec3& p) const {
    double d = inside_side(0, p);
    for (std::uint32_t s = 1; s < 6; ++s) d = std::min(d, inside_side(s, p));
    return d;
}

bool SceneGeometry::exists(const Site& s) const {
    switch (s.kind) {
        case Site::Kind::Object: return s.index < scene_.objects.size() && scene_.competes(s.index);
        case Site::Kind::BoxSide: return s.index < 6;
        case Site::Kind::End: return is_cylinder() && s.index < 2;
        default: return false;
    }
}

double SceneGeometry::distance_to(std::uint32_t object, const Vec3& p) const {
    return distance(scene_.objects[object], p);
}

double SceneGeometry::excess(const Site& s, const Vec3& p, double r) const {
    if (s.is_object()) return distance_to(s.index, p) - r;
    return s.kind == Site::Kind::End ? inside_end(s.index, p) : inside_side(s.index, p);
}

// The one loop over all objects for every point that is judged: blocks of spheres by squared distances first,
// which vectorise.
std::optional<std::uint32_t> SceneGeometry::nearer(const Vec3& p, double reach) const {
    constexpr std::size_t kBlock = 256;
    for (std::size_t begin = 0; begin < spheres_.object.size(); begin += kBlock) {
        const std::size_t end = std::min(begin + kBlock, spheres_.object.size());
        int hits = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const double dx = p.x() - spheres_.x[i], dy = p.y() - spheres_.y[i], dz = p.z() - spheres_.z[i];
            const double limit = std::max(0.0, reach + spheres_.reduced_radius[i]);
            hits += dx * dx + dy * dy + dz * dz < limit * limit;
        }
        for (std::size_t i = begin; hits > 0 && i < end; ++i)
            if (is_nearer(spheres_.object[i], p, reach)) return spheres_.object[i];
    }
    for (const std::uint32_t i : others_)
        if (is_nearer(i, p, reach)) return i;
    return std::nullopt;
}

bool SceneGeometry::is_nearer(std::uint32_t i, const Vec3& p, double reach) const {
    return distance_to(i, p) < reach - object_rounding_[i];
}

// Where the ray leaves the box, shortened by bisection at each object met before. d_i - t never grows along
// the ray, so its sign decides.
double SceneGeometry::brute_height(const Ray& ray) const {
    double t = HUGE_VAL;
    for (std::uint32_t s = 0; s < 6; ++s)
        if (const double v = speed(s, ray.direction); v > 0)
            // A body may reach beyond a side: there the ray has left the box before the base's surface.
            t = std::min(t,
                         (plane_ ? std::max(0.0, inside_side(s, ray.foot)) : inside_side(s, ray.foot)) / v);
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
        const Object& o = scene_.objects[i];
        if (!scene_.competes(i)) continue;
        // What rounding makes as near there may be met nowhere at all.
        if (distance(o, ray.at(t)) >= t - site_rounding(Site::object(static_cast<std::uint32_t>(i))))
            continue;
        double lo = ray.start, hi = t;
        for (double m = 0.5 * (lo + hi); lo < m && m < hi; m = 0.5 * (lo + hi))
            (distance(o, ray.at(m)) < m ? hi : lo) = m;
        t = hi;
    }
    return t;
}

Site SceneGeometry::owner(const Ray& ray, double r) const {
    const Vec3 p = ray.at(r);
    Site best = Site::box_side(0);
    double least = HUGE_VAL;
    for (std::uint32_t s = 0; s < 6; ++s)
        if (inside_side(s, p) < least && speed(s, ray.direction) > 0) {
            best = Site::box_side(s);
            least = inside_side(s, p);
        }
    for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
        if (const double e = distance_to(i, p) - r; e < least && scene_.competes(i)) {
            best = Site::object(i);
            least = e;
        }
    return best;
}

}  // namespace vcell::check
