#include "touching_spheres.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace vcell::check {

namespace {

const Sphere* as_ball(const Scene& scene, const Site& site) {
    return site.is_object() ? std::get_if<Sphere>(&scene.objects[site.index]) : nullptr;
}

}  // namespace

std::optional<TouchingSpheres> TouchingSpheres::along(const Net& curve, const Space<Interval>& space) {
    const auto net = curve.degree_t() == 0 ? SphereNet::of(curve) : std::nullopt;
    if (!net) return std::nullopt;
    TouchingSpheres result(*net, space);
    const Object& base = space.scene().base;
    bool is_known = false;
    if (std::holds_alternative<Plane>(base))
        is_known = result.set_height();
    else if (std::holds_alternative<Sphere>(base) && curve.degree_s() == 2)
        is_known = result.set_distance_at_three_places();
    else if (std::holds_alternative<Sphere>(base) && curve.degree_s() == 1)
        is_known = result.set_distance_along_line();
    return is_known ? std::optional(result) : std::nullopt;
}

// On the bisector with a ball, or a plane, F less that of the base is 0 where t is linear in p.
std::optional<TouchingSpheres> TouchingSpheres::on(const Net& patch, const Site& own,
                                                   const Space<Interval>& space) {
    const auto net = SphereNet::of(patch);
    if (!net) return std::nullopt;
    TouchingSpheres result(*net, space);
    const Object& base = space.scene().base;
    if (std::holds_alternative<Plane>(base))
        return result.set_height() ? std::optional(result) : std::nullopt;
    const auto* sphere = std::get_if<Sphere>(&base);
    if (!sphere || !own.is_object()) return std::nullopt;
    std::optional<Linear> f;
    if (const Sphere* ball = as_ball(space.scene(), own))
        f = net->difference(*ball, sphere->center, sphere->radius);
    else
        f = result.plane_excess(own);
    if (!f) return std::nullopt;
    // Between equal balls it is a plane that knows nothing of t.
    if (f->h == 0)
        return result.set_distance_within(space.clearance(patch.box())) ? std::optional(result)
                                                                        : std::nullopt;
    result.net_.solve_for_radii(*f);
    return result.set_distance_by_square() ? std::optional(result) : std::nullopt;
}

// With X = w (p - o), T = w t and D = T + R w, F of the base is G / w^2 with G = |X|^2 - D^2, and |p - o| -
// (t + R), which is F by |p - o| + t + R, no more than |G| / (w D); likewise for the own ball. On the loops
// D^2 <= (w reach)^2 + |G|, and where w grows, falls or is concave all along one variable it is least on
// them.
std::optional<TouchingSpheres::Inside> TouchingSpheres::inside(const Net& patch, const Site& own,
                                                               const Space<Interval>& space, double reach) {
    const auto* base = std::get_if<Sphere>(&space.scene().base);
    const Sphere* ball = as_ball(space.scene(), own);
    if (!base || !ball || ball->radius == base->radius || !(reach < HUGE_VAL)) return std::nullopt;
    auto net = SphereNet::of(patch);
    if (!net || !net->is_weight_least_at_loops()) return std::nullopt;
    net->solve_for_radii(net->difference(*ball, base->center, base->radius));
    const double own_least = net->weighted_sums(ball->radius).least;
    const auto [least, most] = net->weighted_sums(base->radius);
    if (!(least > 0) || !(own_least > 0)) return std::nullopt;
    const double numerator = net->largest_numerator(base->center, base->radius),
                 own_numerator = net->largest_numerator(ball->center, ball->radius);
    const double squared = least * least * kBelow - numerator;
    if (!(squared > 0)) return std::nullopt;
    const double least_weight = std::sqrt(squared) / reach * kBelow;
    TouchingSpheres result(*net, space);
    result.clearance_ = {-base->radius, most / least_weight * kAbove - base->radius * kBelow};
    const double excess = (numerator / least + own_numerator / own_least) / least_weight * kAbove;
    return excess < HUGE_VAL ? std::optional(Inside{result, excess}) : std::nullopt;
}

bool TouchingSpheres::set_height() {
    const Vector<Interval>& direction = space_->base().direction;
    const Vec3 n = middle(direction), from = net_.origin() - std::get<Plane>(space_->scene().base).point;
    const double k = n.dot(from), size = from.cwiseAbs().dot(n.cwiseAbs());
    double most = 0;
    net_.set_radii([&](const SphereNet::Point& p) {
        const double x = n.x() * p.x, y = n.y() * p.y, z = n.z() * p.z;
        most = std::max(most, std::abs(x) + std::abs(y) + std::abs(z) + size * p.w);
        return k * p.w + (x + y + z);
    });
    const double error =
        kAbove * (kFew * most + sum_of_magnitudes(n) * net_.position_error() + size * net_.weight_error()) /
        net_.least_weight();
    return net_.settle(error) && finish(net_.least_sum(0));
}

bool TouchingSpheres::set_distance_at_three_places() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const Vec3 from = net_.origin() - sphere.center;
    const auto points = net_.points();
    const auto distance = [&](double a, double b, double c) {
        Vec3 sum = Vec3::Zero();
        const std::array shares{a, b, c};
        for (std::size_t i = 0; i < 3; ++i) {
            const SphereNet::Point& p = points[i];
            sum += shares[i] * (Vec3(p.x, p.y, p.z) + p.w * from);
        }
        return sum.norm();
    };
    const double first = distance(1, 0, 0), last = distance(0, 0, 1);
    const std::array coefficients{first, 2 * distance(0.25, 0.5, 0.25) - 0.5 * (first + last), last};
    std::size_t k = 0;
    net_.set_radii([&](const SphereNet::Point& p) { return coefficients[k++] - sphere.radius * p.w; });
    return set_distance_by_square();
}

/// The unit vector from the center to the segment, or beside it, that makes the angle of this sine with
/// `across`.
Vec3 TouchingSpheres::Line::direction(double sine) const {
    const double s = std::min(std::max(sine, sines[0]), sines[1]);
    return s * way + std::sqrt(std::max(0.0, 1 - s * s)) * across;
}

// A distance is convex: it is below what is linear between the ends, by no more than length^2 / 8 by the
// least distance, and above its share in any direction. That of the line's nearest point tells the least one.
bool TouchingSpheres::set_distance_along_line() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const Vec3 from = net_.origin() - sphere.center;
    std::array<double, 2> distance;
    std::array<Vec3, 2> ends;
    std::size_t k = 0;
    net_.set_radii([&](const SphereNet::Point& p) {
        ends[k] = Vec3(p.x, p.y, p.z) / p.w + from;
        distance[k] = ends[k].norm();
        return (distance[k++] - sphere.radius) * p.w;
    });
    Vec3 way = ends[1] - ends[0];
    const double length = way.norm(), most = std::max(distance[0], distance[1]);
    if (!(length > 0) || !(distance[0] > 0) || !(distance[1] > 0)) return false;
    way /= length;
    const double along = ends[0].dot(way);
    Vec3 across = ends[0] - along * way;
    const double aside = across.norm();
    across = aside > 0 ? Vec3(across / aside) : Vec3(Vec3::Zero());
    line_ = {way, across, {along / distance[0], ends[1].dot(way) / distance[1]}};
    const Vec3 toward = along >= 0              ? Vec3(ends[0] / distance[0])
                        : ends[1].dot(way) <= 0 ? Vec3(ends[1] / distance[1])
                                                : across;
    const std::array share{ends[0].dot(toward), ends[1].dot(toward)};
    const double reach = from.cwiseAbs().maxCoeff();
    const double off = net_.position_error() + (most + reach) * net_.weight_error();
    const double rounding =
        (kFew * 4 * (most + reach + sphere.radius) + 4 * off / net_.least_weight()) * kAbove;
    const double least = std::max({std::min(share[0], share[1]), most - length, 0.0}) - rounding;
    double sag = std::max(distance[0] - share[0], distance[1] - share[1]);
    if (least > 0) sag = std::min(sag, length * length / (8 * least));
    refer_to_base();
    if (!net_.settle(rounding, (sag + 2 * rounding) * kAbove)) return false;
    clearance_ = net_.range({0, 0, Vec3::Zero(), 1});
    clearance_ = {std::max(clearance_.lower(), Interval::down(least - sphere.radius)), clearance_.upper()};
    return true;
}

/// Where t is known as an interval only.
bool TouchingSpheres::set_distance_within(const Interval& clearance) {
    if (!(clearance.magnitude() < HUGE_VAL)) return false;
    net_.set_radii([&](const SphereNet::Point& p) { return clearance.mid() * p.w; });
    refer_to_base();
    return net_.settle((clearance.radius() + kFew * clearance.magnitude()) * kAbove) &&
           finish(net_.least_sum(base().radius));
}

void TouchingSpheres::refer_to_base() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    reference_center_ = sphere.center;
    reference_radius_ = sphere.radius;
    has_reference_ = true;
}

// Whatever t is: |p - c| - (t + R) is F of the base by |p - c| + t + R.
bool TouchingSpheres::set_distance_by_square() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const auto square = net_.largest_square(sphere.center, sphere.radius);
    const SphereNet::LeastSum sum = net_.least_sum(sphere.radius);
    if (!square || !(sum.value > 0)) return false;
    const double once = *square / sum.value * kAbove;
    if (!(once < sum.value)) return false;
    refer_to_base();
    return net_.settle(*square / (2 * sum.value - once) * kAbove) && finish(sum);
}

/// Clearances, once radii are settled: on a patch the sum of t and the base's radius may tell more of them.
bool TouchingSpheres::finish(SphereNet::LeastSum sum) {
    clearance_ = net_.range({0, 0, Vec3::Zero(), 1});
    is_bent_ = sum.is_bent;
    if (!net_.is_patch()) return true;
    const double radius = base().radius;
    const double off = net_.most_clearance() * (4 * kFew + net_.weight_error() / net_.least_weight()) +
                       4 * kFew * radius + net_.clearance_error();
    const double lower = sum.value - radius - off * kAbove;
    if (lower > clearance_.lower()) clearance_ = {lower, clearance_.upper()};
    return true;
}

/// Of a plane that the whole curve is on one side of.
std::optional<SphereNet::Linear> TouchingSpheres::plane_excess(const Site& site) const {
    const auto e = element(site);
    if (!e) return std::nullopt;
    const Vec3 from = net_.origin() - std::get<Plane>(space_->scene().objects[site.index]).point;
    const double k = e->place.dot(from);
    return Linear{k, kFew * sum_of_magnitudes(from), e->place, -1};
}

/// A plane's normal points to where the curve is; none if it is on both sides.
std::optional<Oriented> TouchingSpheres::element(const Site& site) const {
    if (!site.is_object()) return std::nullopt;
    const Object& object = space_->scene().objects[site.index];
    if (const auto* ball = std::get_if<Sphere>(&object))
        return Oriented{false, ball->center, ball->radius, Vec3::Zero()};
    const auto* plane = std::get_if<Plane>(&object);
    if (!plane) return std::nullopt;
    const Vec3 n = middle(space_->object(site.index).direction), from = net_.origin() - plane->point;
    const Interval side = net_.range({n.dot(from), kFew * sum_of_magnitudes(from), n, 0});
    if (!(side.lower() > 0) && !(side.upper() < 0)) return std::nullopt;
    return Oriented{true, side.lower() > 0 ? n : Vec3(-n), 0, plane->point};
}

Oriented TouchingSpheres::base() const {
    if (const auto* sphere = std::get_if<Sphere>(&space_->scene().base))
        return {false, sphere->center, sphere->radius, Vec3::Zero()};
    return {true, middle(space_->base().direction), 0, std::get<Plane>(space_->scene().base).point};
}

/// A lower bound of f. Along a line where t counts as positive, t + R is at least the share of p - c in any
/// direction: in that of the place where f is least the bound is f there.
double TouchingSpheres::least_of(const Linear& f) const {
    if (!line_ || !(net_.sag() > 0) || !(f.h > 0)) return net_.range(f).lower();
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const Vec3 u = line_->direction(-f.g.dot(line_->way) / f.h) * (1 - kFew);
    if (!(u.squaredNorm() <= 1 - kFew)) return net_.range(f).lower();
    const Vec3 from = net_.origin() - sphere.center;
    // The sums of both terms are off by what either is, where they cancel too.
    const Vec3& most = net_.most_place();
    const double error = f.error + f.h * net_.clearance_error() +
                         kFew * (std::abs(f.k) + f.g.cwiseAbs().dot(most) +
                                 f.h * (sum_of_magnitudes(from) + most.sum() + sphere.radius));
    return net_.range({f.k + f.h * (u.dot(from) - sphere.radius), error * kAbove, f.g + f.h * u, 0}).lower();
}

bool TouchingSpheres::refer_to(const Site& site) {
    if (has_reference_) return true;
    const Sphere* ball = as_ball(space_->scene(), site);
    if (!ball) return false;
    const auto square = net_.largest_square(ball->center, ball->radius);
    if (!square) return false;
    reference_center_ = ball->center;
    reference_radius_ = ball->radius;
    // (t + rho)^2 is off with t.
    const double most = clearance_.magnitude() + ball->radius;
    reference_error_ = (*square + net_.clearance_error() * (2 * most + net_.clearance_error())) * kAbove;
    has_reference_ = true;
    return true;
}

std::optional<Interval> TouchingSpheres::excess(const Condition& c) const {
    if (!c.site.is_object()) {
        const Vector<Interval> origin = to_vector<Interval>(net_.origin());
        const Interval value = space_->excess(c, origin);
        const Vector<Interval> g = space_->gradient(c, origin);
        const double error = value.radius() + kFew * value.magnitude();
        return net_.range({value.mid(), error, middle(g), 0});
    }
    const Sphere* ball = as_ball(space_->scene(), c.site);
    if (!ball) {
        const auto f = plane_excess(c.site);
        return f ? std::optional(net_.range(*f)) : std::nullopt;
    }
    if (!has_reference_) return std::nullopt;
    const Linear f = net_.difference(*ball, reference_center_, reference_radius_);
    const Interval all =
        Interval(least_of(f), net_.range(f).upper()) + Interval(-reference_error_, reference_error_);
    // e is F by s + t + rho, where s = t + rho + e is not negative. About a base ball s + t + rho is the sum
    // of two sides of a triangle, and of the difference of the radii.
    const double reach = (clearance_.lower() + ball->radius) * kBelow;
    double least_sum = 0;
    if (const auto* base = std::get_if<Sphere>(&space_->scene().base))
        least_sum = ((ball->center - base->center).norm() * kBelow + (ball->radius - base->radius)) * kBelow;
    if (!(reach > 0) && !(least_sum > 0)) return std::nullopt;
    double low = 0, high = 0;
    if (all.upper() > 0) high = all.upper() / std::max(2 * reach, least_sum) * kAbove;
    if (all.lower() < 0) {
        low = least_sum > 0 ? all.lower() / least_sum * kAbove : -HUGE_VAL;
        if (reach > 0) {
            const double once = -all.lower() / reach * kAbove, sum = (2 * reach - once) * kBelow;
            low = std::max({low, all.lower() / std::max(sum, reach) * kAbove, -once});
        }
    }
    return Interval(low, high);
}

std::optional<double> TouchingSpheres::least(const Site& object) const {
    const Sphere* ball = as_ball(space_->scene(), object);
    if (!ball) {
        const auto f = plane_excess(object);
        return f ? std::optional(net_.range(*f).lower()) : std::nullopt;
    }
    if (!has_reference_) return std::nullopt;
    return Interval::down(least_of(net_.difference(*ball, reference_center_, reference_radius_)) -
                          reference_error_);
}

// Where e is less than 2 margin F is less than that times s + t + rho = 2 (t + rho) + e; excesses change by
// at most twice the way.
bool TouchingSpheres::is_farther(const Site& object, double margin) const {
    const auto least_known = least(object);
    if (!least_known) return false;
    const Sphere* ball = as_ball(space_->scene(), object);
    const double twice = 2 * margin * kAbove;
    const double sum = ball ? 2 * (clearance_.upper() + ball->radius) + twice : 1;
    return *least_known >= twice * sum * kAbove;
}

bool TouchingSpheres::may_be_least(const Sphere& own, const Sphere& rival, double margin) const {
    const double apart = (rival.center - own.center).norm() * kBelow;
    if (!(apart + own.radius >= rival.radius * kAbove)) return true;
    const double most = clearance_.upper() + 2 * margin;
    if (apart < (most + own.radius) * kAbove) return true;
    if (const auto* base = std::get_if<Sphere>(&space_->scene().base))
        return (rival.center - base->center).norm() * kBelow < (most + base->radius) * kAbove;
    const auto& base = std::get<Plane>(space_->scene().base);
    const Vec3 way = rival.center - base.point;
    const double height = middle(space_->base().direction).dot(way) - kFew * sum_of_magnitudes(way);
    return height < most * kAbove;
}

std::optional<double> TouchingSpheres::growth(const Site& site, double size, double margin) const {
    const auto own = element(site);
    return own ? growth_between(base(), *own, clearance_, size, margin) : std::nullopt;
}

std::optional<Slopes> TouchingSpheres::slopes(const Site& first, const Site& second, double size,
                                              double margin) const {
    const auto a = element(first), b = element(second);
    if (a && b) return slopes_between(base(), *a, *b, clearance_, size, margin);
    const auto inwards = [&](const Site& site) -> std::optional<Inwards> {
        if (site.kind != Site::Kind::BoxSide) return std::nullopt;
        const int axis = static_cast<int>(site.index / 2);
        const Box& box = space_->scene().box;
        return site.index % 2 ? Inwards{axis, -1, box.max[axis]} : Inwards{axis, 1, box.min[axis]};
    };
    if (a)
        if (const auto side = inwards(second))
            return slopes_beside(base(), *a, *side, clearance_, size, margin);
    if (b)
        if (const auto side = inwards(first))
            return slopes_beside(base(), *b, *side, clearance_, size, margin);
    return std::nullopt;
}

}  // namespace vcell::check
