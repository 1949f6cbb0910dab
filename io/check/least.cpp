#include "least.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "nets.hpp"

namespace vcell::check {

namespace {

Vector<MidRad> scaled(const MidRad& s, const Vector<MidRad>& a) { return s * a; }

Vector<MidRad> unit(const Vec3& v) {
    const Vector<MidRad> w = to_vector<MidRad>(v);
    return scaled(MidRad(1.0) / sqrt(square(w)), w);
}

/// A ball about a box that holds the point. Its radius is infinite where nothing is known.
Spot spot(const Vector<MidRad>& p) {
    return {{p[0].mid(), p[1].mid(), p[2].mid()}, 1.0625 * (p[0].radius() + p[1].radius() + p[2].radius())};
}

/// Where the one is a unit vector along an axis no rounding blurs the product.
MidRad inner(const Vector<MidRad>& m, const Vector<MidRad>& v) {
    for (std::size_t i = 0; i < 3; ++i)
        if (is_exactly(m[(i + 1) % 3], 0) && is_exactly(m[(i + 2) % 3], 0) && std::abs(m[i].mid()) == 1)
            return m[i].mid() < 0 ? -v[i] : v[i];
    return dot(m, v);
}

}  // namespace

LeastPlaces::LeastPlaces(const Object& base, const Sphere& own, double farthest)
    : own_(to_vector<MidRad>(own.center)), own_radius_(own.radius), farthest_(farthest) {
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
    if (kind_ == Kind::plane) return reach(height_ + own_radius_, one - dot(direction_, ray.way));
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
    if (kind_ == Kind::sphere) return reach(rest, -2.0 * b);
    const MidRad root = sqrt(square(b) + square(slope) * rest);
    return b.mid() < 0 ? rest / (root - b) : reach(b + root, square(slope));
}

/// The quotient, or a negative number where that is negative, none or too far: a ray that is all but one way
/// with the base's normal comes to its bisector nowhere, or far outside of the box.
MidRad LeastPlaces::reach(const MidRad& numerator, const MidRad& denominator) const {
    const double most = denominator.upper();
    if (numerator.lower() > 0 && (most <= 0 || numerator.lower() > most * farthest_ * (1 + 0x1p-40)))
        return -1.0;
    return numerator / denominator;
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

std::optional<Spots> LeastPlaces::of(const Sphere& rival) const {
    const V center = to_vector<MidRad>(rival.center);
    const Ray from_own = ray(own_, center), from_base = ray_from_base(center);
    // Behind the own ball the rival's excess is not negative.
    if (!((from_own.length + own_radius_ - MidRad(rival.radius)).lower() >= 0)) return std::nullopt;
    Spots spots;
    // False where nothing is known.
    const auto add = [&](const Ray& ray, const MidRad& s) {
        if (!(s.radius() < HUGE_VAL)) return false;
        if (s.upper() < ray.length.lower()) return true;
        spots.push_back(spot(ray.start + scaled(s, ray.way)));
        return spots.back().radius < HUGE_VAL;
    };
    // The own ball's excess at the rival's centre.
    const MidRad side = from_own.length - own_radius_ - (from_base.length - base_radius_);
    if (!(side.lower() > 0) && !add(from_own, along_from_own(from_own))) return std::nullopt;
    if (!(side.upper() < 0) && !add(from_base, along_from_base(from_base))) return std::nullopt;
    return spots;
}

bool LeastPlaces::do_rays_miss(const Sphere& base, const Sphere& own, const Sphere& rival, const Vec3& center,
                               double radius) {
    const double from_own = (rival.center - own.center).norm(),
                 from_base = (rival.center - base.center).norm();
    // Where the rival holds the own ball of() knows nothing.
    if (!(from_own + own.radius >= rival.radius * (1 + 0x1p-40))) return false;
    const auto misses = [&](const Vec3& focus) {
        const Vec3 way = rival.center - focus, to_ball = center - focus;
        const double size = way.squaredNorm(), reach = to_ball.norm();
        // The product is off by a few roundings of both lengths, and so are these.
        const double least = radius * (1 + 0x1p-40) + 0x1p-45 * (reach + focus.cwiseAbs().maxCoeff());
        return to_ball.cross(way).squaredNorm() > least * least * size;
    };
    const double side = (from_own - own.radius) - (from_base - base.radius),
                 rounding = 0x1p-48 * (from_own + own.radius + from_base + base.radius);
    return (side > rounding || misses(own.center)) && (side < -rounding || misses(base.center));
}

MidRad LeastPlacesOfSites::Focus::distance(const V& p) const {
    return is_plane ? inner(place, p) - radius : sqrt(square(p - place)) - radius;
}

LeastPlacesOfSites::Focus LeastPlacesOfSites::focus(const Sphere& ball) {
    return {false, to_vector<MidRad>(ball.center), ball.radius};
}
LeastPlacesOfSites::Focus LeastPlacesOfSites::focus(const Plane& plane) {
    const V n = unit(plane.normal);
    return {true, n, inner(n, to_vector<MidRad>(plane.point))};
}

LeastPlacesOfSites::LeastPlacesOfSites(const Scene& scene, const Site& own) : scene_(scene) {
    const auto* sphere = std::get_if<Sphere>(&scene.base);
    const auto* plane = std::get_if<Plane>(&scene.base);
    if (sphere) base_ = focus(*sphere);
    if (plane) base_ = focus(*plane);
    if (own.kind == Site::Kind::BoxSide) {
        const int axis = static_cast<int>(own.index / 2);
        const bool is_upper = own.index % 2;
        side_ = focus(
            Plane{is_upper ? scene.box.max : scene.box.min, (is_upper ? -1.0 : 1.0) * Vec3::Unit(axis)});
    }
    if (!own.is_object()) return;
    const Object& object = scene.objects[own.index];
    // Whatever is in the box is no farther than that.
    const auto farthest = [&](const Sphere& ball) {
        return (scene.box.diagonal() + (ball.center - scene.box.min).norm()) * (1 + 0x1p-40);
    };
    if (const auto* ball = std::get_if<Sphere>(&object)) {
        of_balls_.emplace(scene.base, *ball, farthest(*ball));
        if (base_) own_ = focus(*ball);
    } else if (const auto* other = std::get_if<Plane>(&object); other && sphere) {
        // The face is on the side of a base ball that does not reach the plane.
        Plane towards = *other;
        if (focus(towards).distance(base_->place).mid() < 0) towards.normal = -towards.normal;
        const Focus f = focus(towards);
        if (!((f.distance(base_->place) - base_->radius).lower() > 0)) return;
        own_ = f;
        of_balls_.emplace(towards, *sphere, farthest(*sphere));
    }
}

std::optional<Spots> LeastPlacesOfSites::of(const Site& rival, double apart) const {
    const Object* object = rival.is_object() ? &scene_.objects[rival.index] : nullptr;
    const Sphere* ball = object ? std::get_if<Sphere>(object) : nullptr;
    const Plane* plane = object ? std::get_if<Plane>(object) : nullptr;
    if (side_) {
        if (rival.kind == Site::Kind::BoxSide) return Spots();  // linear
        if (!base_ || base_->is_plane) return std::nullopt;
        if (plane) return Spots();
        return ball ? of_ball_on_side(*ball) : std::nullopt;
    }
    if (ball) return of_balls_ ? of_balls_->of(*ball) : std::nullopt;
    if (!base_ || !own_) return std::nullopt;
    if (plane) return of_plane(*plane, apart);
    if (rival.kind != Site::Kind::BoxSide) return std::nullopt;
    const int axis = static_cast<int>(rival.index / 2);
    return stationary_place(to_vector<MidRad>(Vec3::Unit(axis)));
}

/// Where on the bisector a linear function of gradient m is stationary, m of length one.
///
/// With n_o = v + a m and u = v - a m, v across m: of balls at distances s and d from their centres, s - d =
/// delta the difference of the radii, the way between these is u d - n_o s = -delta v - (s + d) a m. That
/// tells v, and a up to its sign, which is such that s + d is positive. Of a plane n_o is its normal, and of
/// the two sites the other one is a ball: its distance d = (l + r) / (1 - u n_o), with l from its centre to
/// the plane, and 1 - u n_o = 2 (m n_o)^2.
std::optional<Spots> LeastPlacesOfSites::stationary_place(const V& m) const {
    if (base_->is_plane && own_->is_plane) return Spots();  // linear
    V start, way;
    MidRad d;
    if (base_->is_plane || own_->is_plane) {
        const Focus &plane = base_->is_plane ? *base_ : *own_, &ball = base_->is_plane ? *own_ : *base_;
        const MidRad along = inner(m, plane.place);
        if (is_exactly(along, 0)) return Spots();
        start = ball.place;
        way = plane.place - scaled(2.0 * along, m);
        const MidRad reach = plane.distance(start) + ball.radius, squared = 2.0 * square(along);
        d = reach / squared;
        // Where the plane is all but along m the place is far outside of the box, in which the face is.
        const double farthest =
            scene_.box.diagonal() + sqrt(square(start - to_vector<MidRad>(scene_.box.min))).upper();
        if (reach.lower() > (squared.magnitude() * 2) * farthest) return Spots();
    } else {
        const V between = own_->place - base_->place;
        const MidRad delta = own_->radius - base_->radius, along = inner(m, between);
        const V across = between - scaled(along, m);
        const MidRad rest = square(delta) - square(across);
        if (rest.upper() <= 0) return Spots();
        if (!(rest.lower() > 0)) return std::nullopt;
        const MidRad a = sqrt(rest / square(delta));
        const bool is_ahead = along.mid() > 0;
        start = base_->place;
        way = (is_ahead ? a : -a) * m - scaled(MidRad(1.0) / delta, across);
        d = 0.5 * ((is_ahead ? along : -along) / a - delta);
        if (!(along.lower() > 0) && !(along.upper() < 0)) return std::nullopt;
    }
    if (d.upper() < 0) return Spots();
    const Spot place = spot(start + scaled(d, way));
    if (!(place.radius < HUGE_VAL)) return std::nullopt;
    return Spots{place};
}

std::optional<Spots> LeastPlacesOfSites::of_plane(const Plane& rival, double apart) const {
    if (base_->is_plane) return std::nullopt;
    Plane towards = rival;
    if (focus(towards).distance(base_->place).mid() < 0) towards.normal = -towards.normal;
    const Focus f = focus(towards);
    if (!((f.distance(base_->place) - base_->radius).lower() > apart)) return std::nullopt;
    if (!own_->is_plane && !((f.distance(own_->place) + own_->radius).lower() >= 0)) return std::nullopt;
    const auto lowest = stationary_place(f.place);
    if (!lowest) return std::nullopt;
    Spots beyond;
    for (const Spot& s : *lowest)
        if (!((f.distance(to_vector<MidRad>(s.center)) - s.radius).lower() > 0)) beyond.push_back(s);
    return beyond;
}

std::optional<Spots> LeastPlacesOfSites::of_ball_on_side(const Sphere& rival) const {
    const V &o = base_->place, c = to_vector<MidRad>(rival.center);
    const MidRad above = side_->distance(o), rise = side_->distance(c);
    if (!(above.lower() > 0)) return std::nullopt;
    if (!(rise.lower() >= 0) && !(rise.upper() <= 0)) return std::nullopt;
    const bool is_behind = rise.mid() < 0;
    const MidRad height = is_behind ? -rise : rise;
    // Of two centres on one side coordinates tell which one is nearer, exactly.
    int axis = 0;
    while (is_exactly(side_->place[static_cast<std::size_t>(axis)], 0)) ++axis;
    const Vec3 &center = rival.center, &from = std::get<Sphere>(scene_.base).center;
    const bool is_upward = side_->place[static_cast<std::size_t>(axis)].mid() > 0;
    const bool is_farther = is_behind   ? height.lower() >= above.upper()
                            : is_upward ? center[axis] >= from[axis]
                                        : center[axis] <= from[axis];
    if (is_farther) return Spots();
    const V way = (is_behind ? c - scaled(2.0 * rise, side_->place) : c) - o;
    if ((base_->radius - MidRad(rival.radius) - sqrt(square(way))).lower() >= 0) return Spots();
    const Spot place = spot(o + scaled(above / (above - height), way));
    if (!(place.radius < HUGE_VAL)) return std::nullopt;
    return Spots{place};
}

}  // namespace vcell::check
