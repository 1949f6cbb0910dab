#include "least.hpp"

namespace vcell::check {

namespace {

Vector<MidRad> scaled(const MidRad& s, const Vector<MidRad>& a) { return s * a; }

Vector<MidRad> unit(const Vec3& v) {
    const Vector<MidRad> w = to_vector<MidRad>(v);
    return scaled(MidRad(1.0) / sqrt(square(w)), w);
}

}  // namespace

LeastPlaces::LeastPlaces(const Object& base, const Sphere& own)
    : own_(to_vector<MidRad>(own.center)), own_radius_(own.radius) {
    base_radius_ = 0.0;
    if (const auto* plane = std::get_if<Plane>(&base)) {
        kind_ = Kind::plane;
        base_ = to_vector<MidRad>(plane->point);
        direction_ = unit(plane->normal);
    } else if (const auto* sphere = std::get_if<Sphere>(&base)) {
        kind_ = Kind::sphere;
        base_ = to_vector<MidRad>(sphere->center);
        base_radius_ = sphere->radius;
    } else {
        const auto& cylinder = std::get<Cylinder>(base);
        kind_ = Kind::cylinder;
        base_ = to_vector<MidRad>(cylinder.point);
        direction_ = unit(cylinder.axis);
        base_radius_ = cylinder.radius;
    }
    from_base_ = own_ - base_;
    difference_ = own_radius_ - base_radius_;
    if (kind_ == Kind::plane) height_ = dot(direction_, from_base_);
}

LeastPlaces::Ray LeastPlaces::ray(const V& start, const V& through) {
    const V way = through - start;
    const MidRad length = sqrt(square(way));
    return {start, scaled(MidRad(1.0) / length, way), length};
}

/// How far along a ray from the own centre its bisector with the base is. Negative: nowhere.
///
/// At s the own ball is s - rho away. Over a plane the clearance is h + s (n w): s = (h + rho) / (1 - n w).
/// With q the way from the base's centre, or across its axis, and delta = rho - R: |q + s w| = s - delta,
/// that is
///   (1 - w^2) s^2 - 2 (w q + delta) s = q^2 - delta^2,
/// w^2 = 1 about a centre. The right-hand side is positive where neither body holds the other.
MidRad LeastPlaces::along_from_own(const Ray& ray) const {
    const MidRad one = 1.0;
    if (kind_ == Kind::plane) return (height_ + own_radius_) / (one - dot(direction_, ray.way));
    V q = from_base_, w = ray.way;
    MidRad slope = 0.0;
    if (kind_ == Kind::cylinder) {
        slope = dot(direction_, w);
        q = q - scaled(dot(direction_, q), direction_);
        w = w - scaled(slope, direction_);
    }
    const MidRad rest = square(q) - square(difference_);
    if (!(rest.lower() > 0)) return MidRad::whole();
    const MidRad b = dot(w, q) + difference_;
    if (kind_ == Kind::sphere) return rest / (-2.0 * b);
    const MidRad root = sqrt(square(b) + square(slope) * rest);
    return b.mid() < 0 ? rest / (root - b) : (b + root) / square(slope);
}

/// From the foot on a plane along its normal, from a centre, or across an axis.
LeastPlaces::Ray LeastPlaces::ray_from_base(const V& through) const {
    const V way = through - base_;
    if (kind_ == Kind::sphere) return ray(base_, through);
    const MidRad along = dot(direction_, way);
    if (kind_ == Kind::plane) return {through - scaled(along, direction_), direction_, along};
    return ray(base_ + scaled(along, direction_), through);
}

/// How far along such a ray the bisector is. With q the way from the own centre to its start the own ball is
/// |q + s w| - rho away. Over a plane, where the clearance is s and w q = -h: s = (q^2 - rho^2) / (2 (h +
/// rho)). Elsewhere it is s - R: s = (q^2 - delta^2) / (2 (delta - w q)). Where that denominator is negative
/// the bisector is nowhere on the ray.
MidRad LeastPlaces::along_from_base(const Ray& ray) const {
    const V q = ray.start - own_;
    if (kind_ == Kind::plane) return (square(q) - square(own_radius_)) / (2.0 * (height_ + own_radius_));
    const MidRad rest = square(q) - square(difference_);
    if (!(rest.lower() > 0)) return MidRad::whole();
    return rest / (2.0 * (difference_ - dot(ray.way, q)));
}

std::optional<SmallVector<Spot, 2>> LeastPlaces::of(const Sphere& rival) const {
    const V center = to_vector<MidRad>(rival.center);
    const Ray from_own = ray(own_, center), from_base = ray_from_base(center);
    // Behind the own ball the rival's excess is not negative.
    if (!((from_own.length + own_radius_ - MidRad(rival.radius)).lower() >= 0)) return std::nullopt;
    SmallVector<Spot, 2> spots;
    // False where nothing is known.
    const auto add = [&](const Ray& ray, const MidRad& s) {
        if (!(s.radius() < HUGE_VAL)) return false;
        if (s.upper() < ray.length.lower()) return true;
        const V p = ray.start + scaled(s, ray.way);
        const double radius = 1.0625 * (p[0].radius() + p[1].radius() + p[2].radius());
        spots.push_back({{p[0].mid(), p[1].mid(), p[2].mid()}, radius});
        return radius < HUGE_VAL;
    };
    // The own ball's excess at the rival's centre.
    const MidRad side = from_own.length - own_radius_ - (from_base.length - base_radius_);
    if (!(side.lower() > 0) && !add(from_own, along_from_own(from_own))) return std::nullopt;
    if (!(side.upper() < 0) && !add(from_base, along_from_base(from_base))) return std::nullopt;
    return spots;
}

}  // namespace vcell::check
