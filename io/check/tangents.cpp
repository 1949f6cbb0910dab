#include "tangents.hpp"

#include <algorithm>
#include <cmath>

namespace vcell::check {

namespace {

/// The least of a function at the control points.
template <class F>
double least_at_controls(const Net& net, F f) {
    double least = HUGE_VAL;
    for (int i = 0; i <= net.degree_s(); ++i)
        for (int j = 0; j <= net.degree_t(); ++j) least = std::min(least, f(net.control(i, j)).lower());
    return least;
}

double least_by_tangent(const Space<Interval>& space, std::uint32_t object, const Net& net, const Vec3& c) {
    const Vector<Interval> place = to_vector<Interval>(c), slope = space.object_gradient(object, place);
    const Interval distance = space.object_excess(object, place, Interval(0.0));
    return least_at_controls(net, [&](const Vector<Interval>& p) {
        return distance + dot(slope, p - place) - space.clearance(p);
    });
}

/// From c along the plane across `normal` to where a round object's distance less the clearance is least
/// there: at once over a base plane.
Vec3 lowest(const Space<Interval>& space, std::uint32_t object, const Vec3& c, const Vec3& normal) {
    const Vector<Interval> place = to_vector<Interval>(c);
    const Vec3 slope = check::middle(space.object_gradient(object, place)) - check::middle(space.up(place));
    const double reach =
        (space.object_excess(object, place, Interval(0.0)) + space.object(object).radius).mid();
    return c - reach * (slope - slope.dot(normal) * normal);
}

/// Across which a net lies, about; 0 for a curve that is straight.
Vec3 normal_of(const Net& net) {
    const Vec3 first = net.about(1, 0) - net.about(0, 0), second = net.about(0, 1) - net.about(0, 0);
    return first.cross(second).stableNormalized();
}

}  // namespace

double least_by_tangents(const Space<Interval>& space, const Condition& condition, const Net& net) {
    if (!(net.sizes().least_weight > 0)) return -HUGE_VAL;
    if (!condition.site.is_object())
        return least_at_controls(net, [&](const Vector<Interval>& p) { return space.excess(condition, p); });
    const std::uint32_t object = condition.site.index;
    const Surface<Interval> surface = space.object(object);
    if (surface.is_hollow) return -HUGE_VAL;
    const Vector<Interval>& box = net.box();
    Vec3 c = check::middle(box);
    double least = least_by_tangent(space, object, net, c);
    if (surface.kind == Surface<Interval>::Kind::plane) return least;
    const Vec3 normal = normal_of(net);
    // The way to an axis is across it: steps that do not run along it need a second one.
    constexpr int steps = 2;
    for (int i = 0; i < steps && least < 0; ++i) {
        c = lowest(space, object, c, normal);
        for (int k = 0; k < 3; ++k)
            c[k] = std::clamp(c[k], box[static_cast<std::size_t>(k)].lower(),
                              box[static_cast<std::size_t>(k)].upper());
        if (!c.allFinite()) return least;
        least = std::max(least, least_by_tangent(space, object, net, c));
    }
    return least;
}

}  // namespace vcell::check
