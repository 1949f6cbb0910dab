#include "excess.hpp"

#include <algorithm>

namespace vcell::check {

namespace {

using Kind = Surface<Interval>::Kind;

Interval intersection(const Interval& a, const Interval& b) {
    const double lo = std::max(a.lower(), b.lower()), hi = std::min(a.upper(), b.upper());
    return lo <= hi ? Interval(lo, hi) : a;
}

// A difference of Intervals is no number, even of equal ones.
bool are_equal(const Interval& a, const Interval& b) {
    return a.lower() == b.upper() && a.upper() == b.lower();
}

/// linear - twice, where the product of that and of linear + twice is known, too.
template <class Product>
Interval sharpened(const Interval& linear, const Interval& twice, const Product& product) {
    const Interval difference = linear - twice, sum = linear + twice;
    return sum.contains(0) ? difference : intersection(difference, product() / sum);
}

/// a b + s w.
Form inner(const Vector<Interval>& a, const Vector<Form>& b, const MidRad& s, const Form& w) {
    return Form::combination<4>({{{a[0], &b[0]}, {a[1], &b[1]}, {a[2], &b[2]}, {s, &w}}});
}

Form difference(const MidRad& s, const Form& a, const MidRad& t, const Form& b) {
    return Form::combination<2>({{{s, &a}, {-t, &b}}});
}

Form sum_of_squares(const Vector<Form>& a) {
    Form sum = square(a[0]);
    sum.add_product(1, a[1], a[1]);
    sum.add_product(1, a[2], a[2]);
    return sum;
}

}  // namespace

ExcessAlong::ExcessAlong(const Space<Interval>& space, const Net& net)
    : space_(space), net_(net), position_{net.form(0), net.form(1), net.form(2)}, weight_(net.form(3)) {
    w_ = weight_.range();
    const Surface& base = space.base();
    base_ = base.kind == Kind::plane ? signed_distance(base) : squared_distance(base);
    clearance_ = base.kind == Kind::plane ? base_.range() / w_ : sqrt(base_.range()) / w_ - base.radius;
}

/// From the surface's point to the net's origin.
Vector<MidRad> ExcessAlong::way(const Surface& s) const {
    Vector<MidRad> way;
    for (std::size_t k = 0; k < 3; ++k)
        way[k] = MidRad(net_.origin()[static_cast<Eigen::Index>(k)]) - MidRad(s.point[k]);
    return way;
}

Form ExcessAlong::signed_distance(const Surface& plane) const {
    const Vector<MidRad> q = way(plane);
    const MidRad at_origin = MidRad(plane.direction[0]) * q[0] + MidRad(plane.direction[1]) * q[1] +
                             MidRad(plane.direction[2]) * q[2];
    return inner(plane.direction, position_, at_origin, weight_);
}

Form ExcessAlong::squared_distance(const Surface& round) const {
    const Vector<MidRad> from = way(round);
    Vector<Form> q;
    for (std::size_t k = 0; k < 3; ++k)
        q[k] = Form::combination<2>({{{1.0, &position_[k]}, {from[k], &weight_}}});
    if (round.kind == Kind::sphere) return sum_of_squares(q);
    const Vector<Interval>& d = round.direction;
    return sum_of_squares({difference(d[2], q[1], d[1], q[2]), difference(d[0], q[2], d[2], q[0]),
                           difference(d[1], q[0], d[0], q[1])});
}

Interval ExcessAlong::excess(const Condition& c) const {
    if (c.is_of_object()) {
        const Interval plain = object_excess(space_.object(c.site.index));
        const auto apart = space_.is_twin_of_base(c.site.index) ? excess_of_twin(c.site.index) : std::nullopt;
        return apart ? intersection(plain, *apart) : plain;
    }
    // Linear: its value at the origin, and its gradient.
    const Vector<Interval> origin = to_vector<Interval>(net_.origin());
    return inner(space_.gradient(c, origin), position_, space_.excess(c, origin), weight_).range() / w_;
}

std::optional<Interval> ExcessAlong::excess_difference(const Condition& c, const Condition& d) const {
    if (!space_.are_alike(c, d)) return std::nullopt;
    const Surface& object = space_.object(c.site.index);
    if (object.kind == Kind::plane) return difference_of_planes(c, d);
    return object.is_cone ? difference_of_cones(c, d) : difference_of_round(c, d);
}

/// With unit normals m and n, points a and b of the planes: (m - n) (p - a) + n (b - a).
std::optional<Interval> ExcessAlong::difference_of_planes(const Condition& c, const Condition& d) const {
    const Vector<Interval> box = net_.box();
    if (!space_.near_normals(c, d, box)) return std::nullopt;
    const Vector<Interval>&a = space_.object(c.site.index).point, &b = space_.object(d.site.index).point;
    const Vector<Interval> turn = space_.gradient_difference(c, d, box),
                           n = space_.object_gradient(d.site.index, box),
                           origin = to_vector<Interval>(net_.origin());
    const Interval at_origin = dot(turn, origin - a) + dot(n, b - a);
    return inner(turn, position_, at_origin, weight_).range() / w_;
}

/// A - B of squared distances A / w^2 and B / w^2, where nothing cancels but in differences of points a, b
/// and of axes e, f. With x = p - a: |x|^2 - |p - b|^2 = (b - a) (2 p - a - b), and of what is along the axes
/// the difference of squares is ((e - f) x + f (b - a)) ((e + f) x - f (b - a)).
Form ExcessAlong::squared_difference(const Surface& first, const Surface& second,
                                     const std::optional<std::array<Vector<Interval>, 2>>& axes) const {
    const Vector<Interval> origin = to_vector<Interval>(net_.origin()), x = origin - first.point,
                           way = second.point - first.point;
    Form result =
        inner(Interval(2.0) * way, position_, dot(way, x + (origin - second.point)), weight_) * weight_;
    if (!axes) return result;
    const auto& [turn, f] = *axes;
    const Vector<Interval> both = turn + Interval(2.0) * f;
    const Interval shift = dot(f, way);
    result.add_product(-1, inner(turn, position_, dot(turn, x) + shift, weight_),
                       inner(both, position_, dot(both, x) - shift, weight_));
    return result;
}

/// Squared distances A / w^2 = s^2 and B / w^2 = t^2, D the difference of the radii, e the second's excess: s
/// - t - D times (s + t + D) is (A - B) / w^2 - 2 D t - D^2, t = radius + r + e, or radius - r - e in a
/// hollow one. Over a base plane r is polynomial.
std::optional<Interval> ExcessAlong::difference_of_round(const Condition& c, const Condition& d) const {
    const Surface &first = space_.object(c.site.index), &second = space_.object(d.site.index);
    const bool is_grown = !are_equal(first.radius, second.radius);
    const Interval grown = is_grown ? first.radius - second.radius : Interval(0.0);
    if (is_grown && space_.base().kind != Kind::plane) return std::nullopt;
    std::optional<std::array<Vector<Interval>, 2>> axes;
    if (first.kind == Kind::cylinder) {
        axes = space_.near_axes(c, d);
        if (!axes) return std::nullopt;
    }
    Form g = squared_difference(first, second, axes);
    const Interval distances = sqrt(squared_distance(first).range()) + sqrt(squared_distance(second).range()),
                   sum = distances / w_ + grown;
    if (!(sum.lower() > 0)) return std::nullopt;
    Interval rest(0.0);
    const double outwards = first.is_hollow ? -1 : 1;
    if (is_grown) {
        const Form reach = Form::combination<2>({{{outwards, &base_}, {second.radius, &weight_}}});
        g = g - (2 * grown) * (reach * weight_) - square(grown) * square(weight_);
        rest = 2 * outwards * (grown * object_excess(second));
    }
    return outwards * ((g.range() / square(w_) - rest) / sum);
}

/// Cones of one angle, S and K its sine and cosine, with heights g and h over their apexes, distances s and t
/// from their axes and excesses S g - K s - r and S h - K t - r: the difference of these times K (s + t) = S
/// (g + h) - 2 r, less both excesses, is (P - 2 H r) / w^2, less H / w times both. H / w is S (g - h), and
/// P / w^2 is S^2 (g^2 - h^2) - K^2 (s^2 - t^2).
std::optional<Interval> ExcessAlong::difference_of_cones(const Condition& c, const Condition& d) const {
    const Surface &first = space_.object(c.site.index), &second = space_.object(d.site.index),
                  &base = space_.base();
    const auto axes = space_.near_axes(c, d);
    if (!axes) return std::nullopt;
    const auto& [turn, f] = *axes;
    const Vector<Interval> origin = to_vector<Interval>(net_.origin()), x = origin - first.point,
                           y = origin - second.point, both = turn + Interval(2.0) * f;
    const Interval &S = first.sine, &K = first.cosine;
    const Form H = inner(S * turn, position_, S * (dot(turn, x) + dot(f, second.point - first.point)),
                         weight_),
               sum = inner(S * both, position_,
                           S * (dot(turn + f, x) + dot(f, y)) + Interval(2.0) * base.radius, weight_);
    const Form P = H * sum - square(K) * squared_difference(first, second, axes);
    const Interval distances =
        K * (sqrt(squared_distance(first).range()) + sqrt(squared_distance(second).range())) / w_;
    if (!(distances.lower() > 0)) return std::nullopt;
    const Interval apart = H.range() / w_, rest = apart * (object_excess(first) + object_excess(second));
    if (base.kind == Kind::plane)
        return ((P - MidRad(2.0) * (H * base_)).range() / square(w_) - rest) / distances;
    const Interval q = clearance_ + base.radius;
    const Interval difference = sharpened(P.range() / square(w_), 2 * (apart * q), [&] {
        return (square(P) - MidRad(4.0) * (square(H) * base_)).range() / square(square(w_));
    });
    return (difference - rest) / distances;
}

/// Squared distances A / w^2 = s^2 and B / w^2 = t^2 from what a body and a base like it are about: s - t is
/// (A - B) / w^2 over s + t, and the difference of the radii is taken away.
std::optional<Interval> ExcessAlong::excess_of_twin(std::uint32_t object) const {
    const Surface &first = space_.object(object), &base = space_.base();
    const auto squares = squares_of(object);
    const Interval sum = (sqrt(squared_distance(first).range()) + sqrt(base_.range())) / w_;
    if (!squares || !(sum.lower() > 0)) return std::nullopt;
    return *squares / sum - (first.radius - base.radius);
}

std::optional<Interval> ExcessAlong::squares_of_twin(std::uint32_t object) const {
    const Surface& twin = space_.object(object);
    return space_.is_twin_of_base(object) && are_equal(twin.radius, space_.base().radius) ? squares_of(object)
                                                                                          : std::nullopt;
}

std::optional<Interval> ExcessAlong::squares_of(std::uint32_t object) const {
    const Surface& base = space_.base();
    std::optional<std::array<Vector<Interval>, 2>> axes;
    if (base.kind == Kind::cylinder) {
        axes = space_.axes_of_twin(object);
        if (!axes) return std::nullopt;
    }
    return squared_difference(space_.object(object), base, axes).range() / square(w_);
}

Interval ExcessAlong::in_vessel(const Surface& object) const {
    const Surface& base = space_.base();
    const Form a = squared_distance(object);
    const Interval d = object.radius + base.radius;
    const Interval distance = sqrt(a.range()) / w_,
                   clearance = intersection(clearance_, space_.clearance(net_.box())),
                   q = clearance + base.radius;
    const Interval plain = object.radius - distance - clearance, sum = d - q + distance;
    if (!(sum.lower() > 0)) return plain;
    const Form w2 = square(weight_);
    const Form l = a - base_ - square(d) * w2;
    const Interval linear = l.range() / square(w_), twice = 2 * (d * q);
    const Interval difference = sharpened(linear, -twice, [&] {
        return (square(l) - (4 * square(d)) * (base_ * w2)).range() / square(square(w_));
    });
    return intersection(-difference / sum, plain);
}

/// With L / w the height over the apex times the sine, and the base's radius, the base's squared distance q^2
/// = B / w^2 and the axis' A / w^2, the excess times (L / w - q + cos sqrt A / w) is G / w^2 - 2 L q / w with
/// G = L^2 + B - cos^2 A, and that times (G / w^2 + 2 L q / w) is (G^2 - 4 L^2 B) / w^4.
Interval ExcessAlong::in_cone(const Surface& object) const {
    const Surface& base = space_.base();
    const Form a = squared_distance(object), along = signed_distance(object);
    const Form l = Form::combination<2>({{{object.sine, &along}, {base.radius, &weight_}}});
    const Vector<Interval> box = net_.box();
    const Interval distance = object.cosine * sqrt(a.range()) / w_,
                   q = intersection(clearance_, space_.clearance(box)) + base.radius,
                   height = intersection(
                       l.range() / w_, object.sine * dot(object.direction, box - object.point) + base.radius);
    const Interval plain = height - distance - q, sum = height - q + distance;
    if (!(sum.lower() > 0)) return plain;
    const Form l2 = square(l), g = l2 + base_ - square(object.cosine) * a;
    const Interval linear = g.range() / square(w_), twice = 2 * (height * q);
    const Interval difference = sharpened(
        linear, twice, [&] { return (square(g) - MidRad(4.0) * (l2 * base_)).range() / square(square(w_)); });
    return intersection(difference / sum, plain);
}

Interval ExcessAlong::object_excess(const Surface& object) const {
    if (space_.base().kind == Kind::plane) return above_plane(object);
    return object.kind == Kind::plane ? of_plane(object) : of_round(object);
}

/// Over a base plane, r = b / w. A plane's distance is linear, too. For balls and tubes with the squared
/// distance A / w^2 the excess times (sqrt A / w + r + radius) is (A - (b + radius w)^2) / w^2, and in a
/// hollow one, times (radius - r + sqrt A / w), ((radius w - b)^2 - A) / w^2; in a cone the height over the
/// apex times the sine takes the place of the radius, and cos^2 A that of A.
Interval ExcessAlong::above_plane(const Surface& object) const {
    if (object.kind == Kind::plane) {
        const Form d = signed_distance(object);
        const Interval side = d.range();
        if (side.lower() > 0) return (d - base_).range() / w_;
        if (side.upper() < 0) return (d + base_).range() / -w_;
        return magnitude(side) / w_ - clearance_;
    }
    Form a = squared_distance(object);
    if (object.is_cone) a = square(object.cosine) * a;
    const Interval distance = sqrt(a.range()) / w_;
    if (object.is_hollow) {
        // Towards a tip both vanish, and the weight may not blur either by more than its own share.
        const Form along = object.is_cone ? signed_distance(object) : weight_;
        const Form room_form =
            Form::combination<2>({{{-1.0, &base_}, {object.is_cone ? object.sine : object.radius, &along}}});
        const Interval room = room_form.range() / w_, plain = room - distance, sum = room + distance;
        if (!(sum.lower() > 0)) return plain;
        return intersection((square(room_form) - a).range() / square(w_) / sum, plain);
    }
    const Interval reach = clearance_ + object.radius, plain = distance - reach, sum = distance + reach;
    if (!(sum.lower() > 0)) return plain;
    const Form reach_form = Form::combination<2>({{{1.0, &base_}, {object.radius, &weight_}}});
    Form g = a;
    g.add_product(-1, reach_form, reach_form);
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
///
/// In a vessel, with D the sum of the radii: the excess times (D - q + sqrt A / w) is -(L / w^2 + 2 D q), and
/// that times (L / w^2 - 2 D q) is the same. That sum vanishes at the bisector's tips: next to them the box
/// knows better than quotients how far it is from the base.
Interval ExcessAlong::of_round(const Surface& object) const {
    const Surface& base = space_.base();
    if (object.is_cone) return in_cone(object);
    if (object.is_hollow) return in_vessel(object);
    const Form a = squared_distance(object);
    const Interval d = object.radius - base.radius;
    const Interval distance = sqrt(a.range()) / w_;
    Interval q = clearance_ + base.radius, sum = distance + q + d;
    if (!(sum.lower() > 0) && d.upper() < 0) {  // next to a tip
        q = intersection(clearance_, space_.clearance(net_.box())) + base.radius;
        sum = distance + q + d;
    }
    const Interval plain = distance - q - d;
    if (!(sum.lower() > 0)) return plain;
    const Form w2 = square(weight_);
    const Form l = a - base_ - square(d) * w2;
    const Interval linear = l.range() / square(w_), twice = 2 * (d * q);
    const Interval difference = sharpened(linear, twice, [&] {
        return (square(l) - (4 * square(d)) * (base_ * w2)).range() / square(square(w_));
    });
    return intersection(difference / sum, plain);
}

}  // namespace vcell::check
