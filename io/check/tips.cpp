#include "tips.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace vcell::check {

namespace {

// Any point of a tube's axis will do, and one near the base leaves most digits.
Vector<Interval> near_base(const Surface<Interval>& base, const Surface<Interval>& vessel) {
    const Vector<Interval>& w = vessel.direction;
    return vessel.is_cone ? vessel.point : vessel.point + dot(base.point - vessel.point, w) * w;
}

// A point k along the axis w from its point or apex is at the height h + k n w over the plane, which is to be
// S k + R.
std::vector<Tip> tip_over_plane(const Surface<Interval>& base, const Surface<Interval>& vessel) {
    const Vector<Interval>& w = vessel.direction;
    const Vector<Interval> point = near_base(base, vessel);
    const Interval rise = dot(base.direction, w) - vessel.sine;
    if (rise.contains(0)) return {};
    const Interval k = (vessel.radius - base.distance(point)) / rise, reach = vessel.sine * k + vessel.radius;
    if (reach.upper() < 0) return {};
    return {{point + k * w, reach}};
}

}  // namespace

// A point k along the axis w from its point or apex is q + k a from the base's centre, or across the base's
// axis, and is to be S k + rho away from there, rho the sum of the radii or, of a solid tube, what the base's
// is more: (a^2 - S^2) k^2 + 2 (q a - S rho) k
// + q^2 - rho^2 = 0.
std::vector<Tip> tips_of(const Space<Interval>& space, const Object& object) {
    const Surface<Interval>&base = space.base(), vessel(object);
    const bool is_vessel =
        std::holds_alternative<HollowCylinder>(object) || std::holds_alternative<HollowCone>(object);
    if (base.kind == Surface<Interval>::Kind::plane)
        return is_vessel ? tip_over_plane(base, vessel) : std::vector<Tip>();
    const Interval zero(0.0), rho = is_vessel ? vessel.radius + base.radius : base.radius - vessel.radius;
    if (!is_vessel && !(std::holds_alternative<Cylinder>(object) && rho.lower() > 0)) return {};
    const auto across = [&](const Vector<Interval>& v) {
        if (base.kind == Surface<Interval>::Kind::sphere) return v;
        return v - dot(v, base.direction) * base.direction;
    };
    const Vector<Interval>& w = vessel.direction;
    const Vector<Interval> point = near_base(base, vessel);
    const Vector<Interval> q = across(point - base.point), a = across(w);
    const Interval squared = square(a) - square(vessel.sine), half = dot(q, a) - vessel.sine * rho,
                   rest = square(q) - square(rho), discriminant = square(half) - squared * rest;
    if (discriminant.upper() < 0) return {};
    const Interval root = sqrt(Interval(std::max(0.0, discriminant.lower()), discriminant.upper()));
    // One of both is without cancellation; the other one is what both make together over that.
    const Interval sum = half.mid() < 0 ? root - half : -(root + half);
    std::vector<Interval> places;
    if (squared.lower() > 0 || squared.upper() < 0) places.push_back(sum / squared);
    if (sum.lower() > 0 || sum.upper() < 0) places.push_back(rest / sum);
    std::ranges::sort(places, {}, [](const Interval& k) { return k.mid(); });
    std::vector<Tip> tips;
    for (const Interval& k : places) {
        const Interval reach = vessel.sine * k + rho;
        // Behind a cone's apex one in the base's centre or axis is none: these are beyond the wall there.
        if (reach.upper() < 0 || (vessel.is_cone && k.upper() < 0 && !(reach.lower() > 0))) continue;
        tips.push_back({point + k * w, reach});
    }
    return tips;
}

double farthest_from(std::span<const Tip> tips, const Vector<Interval>& box) {
    double least = HUGE_VAL;
    for (const Tip& tip : tips) least = std::min(least, sqrt(square(box - tip.p)).upper());
    return least;
}

}  // namespace vcell::check
