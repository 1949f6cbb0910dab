#include "touching_spheres.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "coefficients.hpp"

namespace vcell::check {

namespace {

const Sphere* as_ball(const Scene& scene, const Site& site) {
    return site.is_object() ? std::get_if<Sphere>(&scene.objects[site.index]) : nullptr;
}

}  // namespace

TouchingSpheres::TouchingSpheres(const Net& net, const Space<Interval>& space)
    : space_(&space), m_(net.degree_s()), n_(net.degree_t()), origin_(net.origin()) {
    least_weight_ = HUGE_VAL;
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            const Net::Point& p = net.at(i, j);
            points_.push_back({p[0].mid(), p[1].mid(), p[2].mid(), p[3].mid(), 0});
            position_error_ = std::max({position_error_, p[0].radius(), p[1].radius(), p[2].radius()});
            weight_error_ = std::max(weight_error_, p[3].radius());
            least_weight_ = std::min(least_weight_, p[3].mid());
            most_weight_ = std::max(most_weight_, p[3].mid());
        }
    least_weight_ = (least_weight_ - weight_error_) * kBelow;
    affine_.resize((points_.size() - 1) / Lanes::lanes + 1);
    most_place_ = {divide_by_weights([](const Point& p) { return p.x; }, &Affine::x),
                   divide_by_weights([](const Point& p) { return p.y; }, &Affine::y),
                   divide_by_weights([](const Point& p) { return p.z; }, &Affine::z)};
}

std::optional<TouchingSpheres> TouchingSpheres::along(const Net& curve, const Space<Interval>& space) {
    if (curve.degree_s() > kMost || curve.degree_t() > 0) return std::nullopt;
    TouchingSpheres result(curve, space);
    if (!(result.least_weight_ > 0)) return std::nullopt;
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
    if (patch.degree_s() > kMost || patch.degree_t() > kMost) return std::nullopt;
    TouchingSpheres result(patch, space);
    if (!(result.least_weight_ > 0)) return std::nullopt;
    const Object& base = space.scene().base;
    if (std::holds_alternative<Plane>(base))
        return result.set_height() ? std::optional(result) : std::nullopt;
    const auto* sphere = std::get_if<Sphere>(&base);
    if (!sphere || !own.is_object()) return std::nullopt;
    std::optional<Linear> f;
    if (const Sphere* ball = as_ball(space.scene(), own))
        f = result.difference(*ball, sphere->center, sphere->radius);
    else
        f = result.plane_excess(own);
    if (!f) return std::nullopt;
    // Between equal balls it is a plane that knows nothing of t.
    if (f->h == 0)
        return result.set_distance_within(space.clearance(patch.box())) ? std::optional(result)
                                                                        : std::nullopt;
    for (Point& p : result.points_)
        p.t = (f->k * p.w + f->g.x() * p.x + f->g.y() * p.y + f->g.z() * p.z) / -f->h;
    return result.finish_about_sphere() ? std::optional(result) : std::nullopt;
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
    if (patch.degree_s() > kMost || patch.degree_t() > kMost) return std::nullopt;
    TouchingSpheres result(patch, space);
    if (!(result.least_weight_ > 0) || !result.is_weight_least_at_loops()) return std::nullopt;
    const Linear f = result.difference(*ball, base->center, base->radius);
    for (Point& p : result.points_) p.t = (f.k * p.w + f.g.x() * p.x + f.g.y() * p.y + f.g.z() * p.z) / -f.h;
    double most = 0;  // of D
    const auto least_of = [&](double radius) {
        Coefficients c;
        double largest = 0;
        for (std::size_t i = 0; i < result.points_.size(); ++i) {
            const Point& p = result.points_[i];
            c[i] = p.t + radius * p.w;
            largest = std::max(largest, std::abs(p.t) + radius * p.w);
            most = std::max(most, c[i]);
        }
        most = most + kFew * largest + radius * result.weight_error_;
        constexpr int depth = 4;
        return least_value(c, result.m_, result.n_, depth) - kFew * largest - radius * result.weight_error_;
    };
    const double own_least = least_of(ball->radius), least = least_of(base->radius);
    if (!(least > 0) || !(own_least > 0)) return std::nullopt;
    const double numerator = result.largest_numerator(base->center, base->radius),
                 own_numerator = result.largest_numerator(ball->center, ball->radius);
    const double squared = least * least * kBelow - numerator;
    if (!(squared > 0)) return std::nullopt;
    const double least_weight = std::sqrt(squared) / reach * kBelow;
    result.clearance_ = {-base->radius, most / least_weight * kAbove - base->radius * kBelow};
    const double excess = (numerator / least + own_numerator / own_least) / least_weight * kAbove;
    return excess < HUGE_VAL ? std::optional(Inside{result, excess}) : std::nullopt;
}

/// Does it grow or fall all along one variable, or are its second derivatives in it negative?
bool TouchingSpheres::is_weight_least_at_loops() const {
    const double error = 4 * (weight_error_ + 0x1p-52 * most_weight_);
    for (const int axis : {0, 1}) {
        const int degree = axis == 0 ? m_ : n_, lines = axis == 0 ? n_ : m_;
        const auto weight = [&](int line, int i) {
            return points_[static_cast<std::size_t>(axis == 0 ? i * (n_ + 1) + line : line * (n_ + 1) + i)].w;
        };
        bool grows = degree > 0, falls = grows, is_concave = degree > 1;
        for (int line = 0; line <= lines; ++line)
            for (int i = 1; i <= degree; ++i) {
                const double step = weight(line, i) - weight(line, i - 1);
                grows = grows && step > error;
                falls = falls && step < -error;
                if (i > 1)
                    is_concave = is_concave && step - (weight(line, i - 1) - weight(line, i - 2)) < -error;
            }
        if (grows || falls || is_concave) return true;
    }
    return false;
}

bool TouchingSpheres::set_height() {
    const Vector<Interval>& direction = space_->base().direction;
    const Vec3 n = middle(direction), from = origin_ - std::get<Plane>(space_->scene().base).point;
    const double k = n.dot(from), size = from.cwiseAbs().dot(n.cwiseAbs());
    double most = 0;
    for (Point& p : points_) {
        const double x = n.x() * p.x, y = n.y() * p.y, z = n.z() * p.z;
        p.t = k * p.w + (x + y + z);
        most = std::max(most, std::abs(x) + std::abs(y) + std::abs(z) + size * p.w);
    }
    clearance_error_ = kAbove *
                       (kFew * most + sum_of_magnitudes(n) * position_error_ + size * weight_error_) /
                       least_weight_;
    return finish();
}

bool TouchingSpheres::set_distance_at_three_places() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const Vec3 from = origin_ - sphere.center;
    const auto distance = [&](double a, double b, double c) {
        Vec3 sum = Vec3::Zero();
        const std::array shares{a, b, c};
        for (std::size_t i = 0; i < 3; ++i) {
            const Point& p = points_[i];
            sum += shares[i] * (Vec3(p.x, p.y, p.z) + p.w * from);
        }
        return sum.norm();
    };
    const double first = distance(1, 0, 0), last = distance(0, 0, 1),
                 middle = 2 * distance(0.25, 0.5, 0.25) - 0.5 * (first + last);
    points_[0].t = first - sphere.radius * points_[0].w;
    points_[1].t = middle - sphere.radius * points_[1].w;
    points_[2].t = last - sphere.radius * points_[2].w;
    return finish_about_sphere();
}

// A distance is convex: it is below what is linear between the ends, by no more than length^2 / 8 by the
// least distance, and above its share in any direction. That of the line's nearest point tells the least one.
bool TouchingSpheres::set_distance_along_line() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const Vec3 from = origin_ - sphere.center;
    std::array<double, 2> distance;
    std::array<Vec3, 2> ends;
    for (std::size_t k = 0; k < 2; ++k) {
        Point& p = points_[k];
        ends[k] = Vec3(p.x, p.y, p.z) / p.w + from;
        distance[k] = ends[k].norm();
        p.t = (distance[k] - sphere.radius) * p.w;
    }
    way_ = ends[1] - ends[0];
    const double length = way_.norm(), most = std::max(distance[0], distance[1]);
    if (!(length > 0) || !(distance[0] > 0) || !(distance[1] > 0)) return false;
    way_ /= length;
    const double along = ends[0].dot(way_);
    across_ = ends[0] - along * way_;
    const double aside = across_.norm();
    across_ = aside > 0 ? Vec3(across_ / aside) : Vec3(Vec3::Zero());
    sines_ = {along / distance[0], ends[1].dot(way_) / distance[1]};
    const Vec3 toward = along >= 0               ? Vec3(ends[0] / distance[0])
                        : ends[1].dot(way_) <= 0 ? Vec3(ends[1] / distance[1])
                                                 : across_;
    const std::array share{ends[0].dot(toward), ends[1].dot(toward)};
    const double reach = from.cwiseAbs().maxCoeff();
    const double rounding = (kFew * 4 * (most + reach + sphere.radius) +
                             4 * (position_error_ + (most + reach) * weight_error_) / least_weight_) *
                            kAbove;
    const double least = std::max({std::min(share[0], share[1]), most - length, 0.0}) - rounding;
    clearance_error_ = rounding;
    sag_ = std::max(distance[0] - share[0], distance[1] - share[1]);
    if (least > 0) sag_ = std::min(sag_, length * length / (8 * least));
    sag_ = (sag_ + 2 * rounding) * kAbove;
    refer_to_base();
    if (!finish()) return false;
    clearance_ = {std::max(clearance_.lower(), Interval::down(least - sphere.radius)), clearance_.upper()};
    return true;
}

/// Where t is known as an interval only.
bool TouchingSpheres::set_distance_within(const Interval& clearance) {
    if (!(clearance.magnitude() < HUGE_VAL)) return false;
    for (Point& p : points_) p.t = clearance.mid() * p.w;
    clearance_error_ = (clearance.radius() + kFew * clearance.magnitude()) * kAbove;
    refer_to_base();
    return finish();
}

void TouchingSpheres::refer_to_base() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    reference_center_ = sphere.center;
    reference_radius_ = sphere.radius;
    has_reference_ = true;
}

// Whatever t is: |p - c| - (t + R) is F of the base by |p - c| + t + R.
bool TouchingSpheres::finish_about_sphere() {
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const auto square = largest_square(sphere.center, sphere.radius);
    const double least = least_sum_ = least_sum(sphere.radius);
    if (!square || !(least > 0)) return false;
    const double once = *square / least * kAbove;
    if (!(once < least)) return false;
    clearance_error_ = *square / (2 * least - once) * kAbove;
    refer_to_base();
    return finish();
}

/// A lower bound of t + radius, as t's coefficients have it, where these tell little of it: on a patch that
/// is strongly bent they are far below its values.
double TouchingSpheres::least_sum(double radius) {
    double least = HUGE_VAL, largest = 0, at_corners = HUGE_VAL;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const double t = points_[i].t / points_[i].w;
        least = std::min(least, t + radius - kFew * (std::abs(t) + radius));
        largest = std::max(largest, std::abs(points_[i].t) + radius * points_[i].w);
    }
    const auto corner = [&](int i, int j) {
        const Point& p = points_[static_cast<std::size_t>(i * m_ * (n_ + 1) + j * n_)];
        return p.t / p.w + radius;
    };
    for (const int i : {0, 1})
        for (const int j : {0, 1}) at_corners = std::min(at_corners, corner(i, j));
    constexpr double far_below = 0.25;
    if (n_ == 0 || !(at_corners > 0) || least >= far_below * at_corners) return least;
    Coefficients c;
    for (std::size_t i = 0; i < points_.size(); ++i) c[i] = points_[i].t + radius * points_[i].w;
    is_bent_ = true;
    constexpr int depth = 4;
    const double of_product = least_value(c, m_, n_, depth) - kFew * largest;
    return of_product > 0 ? std::max(least, of_product / most_weight_ * kBelow) : least;
}

bool TouchingSpheres::finish() {
    most_clearance_ = divide_by_weights([](const Point& p) { return p.t; }, &Affine::t);
    clearance_ = range({0, 0, Vec3::Zero(), 1});
    if (!(clearance_.magnitude() < HUGE_VAL)) return false;
    if (n_ == 0) return true;
    const double radius = base().radius;
    if (!(least_sum_ > 0)) least_sum_ = least_sum(radius);
    const double off =
        most_clearance_ * (4 * kFew + weight_error_ / least_weight_) + 4 * kFew * radius + clearance_error_;
    const double lower = least_sum_ - radius - off * kAbove;
    if (lower > clearance_.lower()) clearance_ = {lower, clearance_.upper()};
    return true;
}

/// F of the ball about a center, less the reference's F.
///
/// |p - c|^2 - |p - c'|^2 = (c - c') (c + c' - 2 p), and (t + rho)^2 - (t + rho')^2 = (rho - rho') (rho +
/// rho' + 2 t).
TouchingSpheres::Linear TouchingSpheres::difference(const Sphere& ball, const Vec3& center,
                                                    double radius) const {
    const Vec3 way = ball.center - center, here = ball.center - origin_, there = center - origin_;
    const double delta = ball.radius - radius;
    return {way.dot(here + there) - delta * (ball.radius + radius),
            kFew * (sum_of_magnitudes(way) * (sum_of_magnitudes(here) + sum_of_magnitudes(there)) +
                    std::abs(delta) * (ball.radius + radius)),
            -2 * way, -2 * delta};
}

/// Of a plane that the whole curve is on one side of.
std::optional<TouchingSpheres::Linear> TouchingSpheres::plane_excess(const Site& site) const {
    const auto e = element(site);
    if (!e) return std::nullopt;
    const Vec3 from = origin_ - std::get<Plane>(space_->scene().objects[site.index]).point;
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
    const Vec3 n = middle(space_->object(site.index).direction), from = origin_ - plane->point;
    const Interval side = range({n.dot(from), kFew * sum_of_magnitudes(from), n, 0});
    if (!(side.lower() > 0) && !(side.upper() < 0)) return std::nullopt;
    return Oriented{true, side.lower() > 0 ? n : Vec3(-n), 0, plane->point};
}

Oriented TouchingSpheres::base() const {
    if (const auto* sphere = std::get_if<Sphere>(&space_->scene().base))
        return {false, sphere->center, sphere->radius, Vec3::Zero()};
    return {true, middle(space_->base().direction), 0, std::get<Plane>(space_->scene().base).point};
}

/// A quotient of polynomials lies between those of their Bernstein coefficients, which go through a quotient,
/// a product and four sums.
Interval TouchingSpheres::range(const Linear& f) const {
    const double size = std::abs(f.k) + std::abs(f.g.x()) * most_place_.x() +
                        std::abs(f.g.y()) * most_place_.y() + std::abs(f.g.z()) * most_place_.z() +
                        std::abs(f.h) * most_clearance_;
    const double blur = std::abs(f.k) * weight_error_ + sum_of_magnitudes(f.g) * position_error_;
    // The weight's own error counts with the quotient.
    const double off = (size * (2 * kFew + weight_error_ / least_weight_) + f.error + blur / least_weight_ +
                        std::abs(f.h) * clearance_error_) *
                       kAbove;
    if (!(off < HUGE_VAL)) return Interval::whole();
    const auto value = [&](const Affine& p) {
        return ((f.k + f.g.x() * p.x) + (f.g.y() * p.y + f.g.z() * p.z)) + f.h * p.t;
    };
    Lanes lo = value(affine_[0]), hi = lo;
    for (std::size_t i = 1; i < affine_.size(); ++i) {
        const Lanes v = value(affine_[i]);
        lo = min(lo, v);
        hi = max(hi, v);
    }
    const double sag = f.h * sag_;
    return {Interval::down(lo.least() - (off + std::max(sag, 0.0))),
            Interval::up(hi.greatest() + (off - std::min(sag, 0.0)))};
}

/// A lower bound of f. Along a line where t counts as positive, t + R is at least the share of p - c in any
/// direction: in that of the place where f is least the bound is f there.
double TouchingSpheres::least_of(const Linear& f) const {
    if (!(sag_ > 0) || !(f.h > 0)) return range(f).lower();
    const auto& sphere = std::get<Sphere>(space_->scene().base);
    const double sine = std::min(std::max(-f.g.dot(way_) / f.h, sines_[0]), sines_[1]);
    Vec3 u = sine * way_ + std::sqrt(std::max(0.0, 1 - sine * sine)) * across_;
    u *= 1 - kFew;
    if (!(u.squaredNorm() <= 1 - kFew)) return range(f).lower();
    const Vec3 from = origin_ - sphere.center;
    // The sums of both terms are off by what either is, where they cancel too.
    const double error = f.error + f.h * clearance_error_ +
                         kFew * (std::abs(f.k) + f.g.cwiseAbs().dot(most_place_) +
                                 f.h * (sum_of_magnitudes(from) + most_place_.sum() + sphere.radius));
    return range({f.k + f.h * (u.dot(from) - sphere.radius), error * kAbove, f.g + f.h * u, 0}).lower();
}

/// Returns the largest magnitude, infinite where one is not a number.
template <class Coordinate>
double TouchingSpheres::divide_by_weights(Coordinate coordinate, Lanes Affine::*quotient) {
    const std::size_t last = points_.size() - 1;
    double most = 0;
    for (std::size_t k = 0; k < affine_.size(); ++k)
        affine_[k].*quotient = Lanes::of([&](std::size_t lane) {
            const Point& p = points_[std::min(k * Lanes::lanes + lane, last)];
            const double x = coordinate(p) / p.w, size = std::abs(x);
            if (!(size <= most)) most = size < HUGE_VAL ? size : HUGE_VAL;
            return x;
        });
    return most;
}

/// Of |p - c|^2 - (t + rho)^2, all over the curve.
std::optional<double> TouchingSpheres::largest_square(const Vec3& center, double radius) const {
    const double bound = largest_numerator(center, radius) / (least_weight_ * least_weight_) * kAbove;
    return bound < HUGE_VAL ? std::optional(bound) : std::nullopt;
}

/// The same times the squared weight.
///
/// Of a product of polynomials Bernstein coefficients are means of products: the largest magnitudes multiply,
/// and bounds on errors with them (forms.hpp).
double TouchingSpheres::largest_numerator(const Vec3& center, double radius) const {
    constexpr std::size_t most = (kMost + 1) * (kMost + 1),
                          most_of_square = (2 * kMost + 1) * (2 * kMost + 1);
    std::array<double, most> scaled{};
    std::array<double, most_of_square> sum;
    const std::size_t count = points_.size(),
                      count_of_square = static_cast<std::size_t>((2 * m_ + 1) * (2 * n_ + 1));
    std::fill_n(sum.begin(), count_of_square, 0.0);
    const Vec3 from = origin_ - center;
    double size = 0, error = 0;
    const auto m = static_cast<std::size_t>(m_), n = static_cast<std::size_t>(n_);
    const auto& factors = products_of_binomials.of[m][n];
    const auto& divisors = products_of_square.of[2 * m][2 * n];
    const auto add = [&](double sign, auto coordinate, double own_error) {
        double largest = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const double x = coordinate(points_[i]);
            largest = std::max(largest, std::abs(x));
            scaled[i] = x * factors[i];
        }
        size += largest * largest;
        error += own_error * (2 * largest + own_error);
        add_square(m_, n_, sign, scaled.data(), sum.data());
    };
    double most_clearance = 0, most_position = 0;
    for (const Point& p : points_) {
        most_clearance = std::max(most_clearance, std::abs(p.t));
        most_position = std::max({most_position, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    const double reach = from.cwiseAbs().maxCoeff();
    const double position_error =
        position_error_ + reach * weight_error_ + 0x1p-51 * (most_position + 2 * reach * most_weight_);
    add(
        1, [&](const Point& p) { return p.x + from.x() * p.w; }, position_error);
    add(
        1, [&](const Point& p) { return p.y + from.y() * p.w; }, position_error);
    add(
        1, [&](const Point& p) { return p.z + from.z() * p.w; }, position_error);
    add(
        -1, [&](const Point& p) { return p.t + radius * p.w; },
        radius * weight_error_ + 0x1p-52 * (most_clearance + 2 * radius * most_weight_));
    double largest = 0;
    for (std::size_t i = 0; i < count_of_square; ++i) {
        const double x = std::abs(sum[i]) / divisors[i];
        if (!(x <= largest)) largest = x;
    }
    const double rounding = 0x1p-53 * static_cast<double>(4 * count + 16);
    return (largest + error + rounding * size) * kAbove;
}

bool TouchingSpheres::refer_to(const Site& site) {
    if (has_reference_) return true;
    const Sphere* ball = as_ball(space_->scene(), site);
    if (!ball) return false;
    const auto square = largest_square(ball->center, ball->radius);
    if (!square) return false;
    reference_center_ = ball->center;
    reference_radius_ = ball->radius;
    // (t + rho)^2 is off with t.
    const double most = clearance_.magnitude() + ball->radius;
    reference_error_ = (*square + clearance_error_ * (2 * most + clearance_error_)) * kAbove;
    has_reference_ = true;
    return true;
}

std::optional<Interval> TouchingSpheres::excess(const Condition& c) const {
    if (!c.site.is_object()) {
        const Vector<Interval> origin = to_vector<Interval>(origin_);
        const Interval value = space_->excess(c, origin);
        const Vector<Interval> g = space_->gradient(c, origin);
        const double error = value.radius() + kFew * value.magnitude();
        return range({value.mid(), error, middle(g), 0});
    }
    const Sphere* ball = as_ball(space_->scene(), c.site);
    if (!ball) {
        const auto f = plane_excess(c.site);
        return f ? std::optional(range(*f)) : std::nullopt;
    }
    if (!has_reference_) return std::nullopt;
    const Linear f = difference(*ball, reference_center_, reference_radius_);
    const Interval all =
        Interval(least_of(f), range(f).upper()) + Interval(-reference_error_, reference_error_);
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
        return f ? std::optional(range(*f).lower()) : std::nullopt;
    }
    if (!has_reference_) return std::nullopt;
    return Interval::down(least_of(difference(*ball, reference_center_, reference_radius_)) -
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
