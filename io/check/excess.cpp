#include "excess.hpp"

#include <algorithm>

namespace vcell::check {

namespace {

using Kind = Surface<Interval>::Kind;

Interval intersection(const Interval& a, const Interval& b) {
    const double lo = std::max(a.lower(), b.lower()), hi = std::min(a.upper(), b.upper());
    return lo <= hi ? Interval(lo, hi) : a;
}

Form inner(const Vector<Interval>& a, const Vector<Form>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace

ExcessAlong::ExcessAlong(const Space<Interval>& space, const Net& net)
    : space_(space), net_(net), position_{net.form(0), net.form(1), net.form(2)}, weight_(net.form(3)) {
    w_ = weight_.range();
    const Surface& base = space.base();
    base_ = base.kind == Kind::plane ? signed_distance(base) : squared_distance(base);
    clearance_ = base.kind == Kind::plane ? base_.range() / w_ : sqrt(base_.range()) / w_ - base.radius;
}

/// The way from the surface's point, times the weight.
Vector<Form> ExcessAlong::from(const Surface& s) const {
    Vector<Form> way;
    for (std::size_t k = 0; k < 3; ++k)
        way[k] = position_[k] - (MidRad(s.point[k]) - net_.origin()[static_cast<Eigen::Index>(k)]) * weight_;
    return way;
}

Form ExcessAlong::signed_distance(const Surface& plane) const { return inner(plane.direction, from(plane)); }

Form ExcessAlong::squared_distance(const Surface& round) const {
    const Vector<Form> q = from(round);
    if (round.kind == Kind::sphere) return square(q[0]) + square(q[1]) + square(q[2]);
    const Vector<Interval>& d = round.direction;
    return square(d[2] * q[1] - d[1] * q[2]) + square(d[0] * q[2] - d[2] * q[0]) +
           square(d[1] * q[0] - d[0] * q[1]);
}

Interval ExcessAlong::excess(const Condition& c) const {
    if (c.site.is_object()) return object_excess(space_.object(c.site.index));
    // Linear: its value at the origin, and its gradient.
    const Vector<Interval> origin = to_vector<Interval>(net_.origin());
    const Form at_origin = space_.excess(c, origin) * weight_;
    return (at_origin + inner(space_.gradient(c, origin), position_)).range() / w_;
}

Interval ExcessAlong::object_excess(const Surface& object) const {
    if (space_.base().kind == Kind::plane) return above_plane(object);
    return object.kind == Kind::plane ? of_plane(object) : of_round(object);
}

/// Over a base plane, r = b / w. A plane's distance is linear, too. For balls and tubes with the squared
/// distance A / w^2 the excess times (sqrt A / w + r + radius) is (A - (b + radius w)^2) / w^2.
Interval ExcessAlong::above_plane(const Surface& object) const {
    if (object.kind == Kind::plane) {
        const Form d = signed_distance(object);
        const Interval side = d.range();
        if (side.lower() > 0) return (d - base_).range() / w_;
        if (side.upper() < 0) return (d + base_).range() / -w_;
        return magnitude(side) / w_ - clearance_;
    }
    const Form a = squared_distance(object);
    const Interval distance = sqrt(a.range()) / w_, reach = clearance_ + object.radius;
    const Interval plain = distance - reach, sum = distance + reach;
    if (!(sum.lower() > 0)) return plain;
    const Form g = a - square(base_ + object.radius * weight_);
    return intersection(g.range() / square(w_) / sum, plain);
}

/// A plane's distance l / w and the base's squared distance q^2 = B / w^2: the excess times (l / w + R + q)
/// is
/// ((l + R w)^2 - B) / w^2.
Interval ExcessAlong::of_plane(const Surface& object) const {
    Form l = signed_distance(object);
    const Interval side = l.range();
    const Interval plain = magnitude(side) / w_ - clearance_;
    if (side.upper() < 0)
        l = MidRad(-1.0) * l;
    else if (!(side.lower() > 0))
        return plain;
    const Interval& radius = space_.base().radius;
    const Form reach = l + radius * weight_;
    const Interval sum = reach.range() / w_ + clearance_ + radius;
    if (!(sum.lower() > 0)) return plain;
    return intersection((square(reach) - base_).range() / square(w_) / sum, plain);
}

/// Squared distances A / w^2 of the object and B / w^2 = q^2 of the base, and the difference D of their
/// radii: the excess times (sqrt A / w + q + D) is L / w^2 - 2 D q with L = A - B - D^2 w^2. Where D is not
/// zero that times (L / w^2 + 2 D q) is (L^2 - 4 D^2 B w^2) / w^4.
Interval ExcessAlong::of_round(const Surface& object) const {
    const Surface& base = space_.base();
    const Form a = squared_distance(object);
    const Interval d = object.radius - base.radius;
    const Interval distance = sqrt(a.range()) / w_, q = clearance_ + base.radius;
    const Interval plain = distance - object.radius - clearance_, sum = distance + q + d;
    if (!(sum.lower() > 0)) return plain;
    const Form w2 = square(weight_);
    const Form l = a - base_ - square(d) * w2;
    const Interval linear = l.range() / square(w_), twice = 2 * (d * q);
    Interval difference = linear - twice;
    const Interval with = linear + twice;
    if (!with.contains(0))
        difference = intersection(
            difference, (square(l) - (4 * square(d)) * (base_ * w2)).range() / square(square(w_)) / with);
    return intersection(difference / sum, plain);
}

}  // namespace vcell::check
