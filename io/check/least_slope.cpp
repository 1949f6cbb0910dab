#include "least_slope.hpp"

#include <algorithm>

namespace vcell::check {

namespace {

using Body = Surface<Interval>;

// The square of the distance of the feet on two axes. Where p moves by a length their difference moves by no
// more.
Interval feet_apart(const Body& a, const Body& b, const Net& net, double margin) {
    const auto between = [&](const Vector<Interval>& p) {
        const auto foot = [&](const Body& tube) {
            return tube.point + dot(tube.direction, p - tube.point) * tube.direction;
        };
        return foot(a) - foot(b);
    };
    Vector<Interval> all = between(net.control(0, 0));
    for (int i = 0; i <= net.degree_s(); ++i)
        for (int j = 0; j <= net.degree_t(); ++j) all = hull(all, between(net.control(i, j)));
    return square(box_about(all, margin));
}

// The square of the distance of the points that both ways come from.
Interval apart(const Body& a, const Body& b, const Net& net, double margin, const Vector<Interval>& box) {
    const bool is_tube = a.kind == Body::Kind::cylinder, is_other = b.kind == Body::Kind::cylinder;
    if (is_tube && is_other) return feet_apart(a, b, net, margin);
    if (!is_tube && !is_other) return square(b.point - a.point);
    const Body &tube = is_tube ? a : b, &ball = is_tube ? b : a;
    return square(cross(tube.point - ball.point, tube.direction)) +
           square(dot(tube.direction, box - ball.point));
}

}  // namespace

double least_slope(const Space<Interval>& space, std::uint32_t object, const Net& net, double margin,
                   double size) {
    const Vector<Interval> box = box_about(net.box(), margin);
    const Body &base = space.base(), own = space.object(object);
    const bool is_base_plane = base.kind == Body::Kind::plane, is_plane = own.kind == Body::Kind::plane;
    // Along its axis distances from a tube do not change, and those from a cone's wall evenly, but the base's
    // do.
    const bool tells_along_axis = own.kind == Body::Kind::cylinder && (own.is_hollow || !is_base_plane);
    const double along_axis =
        tells_along_axis ? magnitude(own.sine - dot(own.direction, space.up(box))).lower() : 0;
    if (own.is_hollow) return along_axis;
    if (is_plane && (is_base_plane || !own.is_sided)) return 0;
    const Interval excess(-size, size);
    const auto way = [&](const Body& body) { return body.distance(box) + body.radius; };
    Interval squared;
    if (is_plane || is_base_plane) {
        const Body &plane = is_plane ? own : base, &body = is_plane ? base : own;
        Interval rise(0.0);
        if (body.kind == Body::Kind::cylinder)
            rise = dot(body.direction, box - body.point) * dot(body.direction, plane.direction);
        const Interval height = plane.distance(body.point) + body.radius + rise;
        squared = 2.0 * (is_plane ? height - excess : height + excess) / way(body);
    } else {
        squared = (apart(base, own, net, margin, box) - square(own.radius - base.radius + excess)) /
                  (way(base) * way(own));
    }
    return squared.lower() > 0 ? std::max(along_axis, sqrt(Interval(squared.lower())).lower()) : along_axis;
}

}  // namespace vcell::check
