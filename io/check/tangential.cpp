#include "tangential.hpp"

#include <algorithm>

namespace vcell::check {

namespace {

struct Number {
    double value, error;
};

/// D of two, where t + rho is the distance from either up to `off`: of balls the difference of those is rho -
/// rho' up to twice that. Of a plane and a ball, at distance d' of the plane, D = 2 (s - t + d').
Number tangential(const Oriented& a, const Oriented& b, double off) {
    if (a.is_plane && b.is_plane) return {(a.place - b.place).squaredNorm(), kFew * 8};
    if (a.is_plane || b.is_plane) {
        const Oriented &plane = a.is_plane ? a : b, &ball = a.is_plane ? b : a;
        const Vec3 way = ball.place - plane.point;
        return {2 * (ball.radius + plane.place.dot(way)),
                kFew * 2 * (ball.radius + sum_of_magnitudes(way)) + 4 * off};
    }
    const Vec3 way = a.place - b.place;
    const double delta = a.radius - b.radius, twice = 2 * off;
    return {way.squaredNorm() - delta * delta,
            kFew * (way.squaredNorm() + delta * delta) + twice * (2 * std::abs(delta) + twice)};
}

/// The slopes are told apart in so many parts of the clearances.
constexpr int kParts = 4;
Interval part_of(double low, double high, int k) {
    const auto end = [&](int i) {
        return i == kParts ? high : low + (high - low) * (i / static_cast<double>(kParts));
    };
    return {end(k), end(k + 1)};
}

}  // namespace

std::optional<double> growth_between(const Oriented& base, const Oriented& own, const Interval& clearance,
                                     double size, double margin) {
    const double off = (size + 2 * margin) * kAbove;
    const Number d = tangential(base, own, off);
    const auto reach = [&](const Oriented& e) {
        return e.is_plane ? 1 : (clearance.upper() + e.radius + margin + off) * kAbove;
    };
    const double squared = (d.value - d.error) / (reach(base) * reach(own)) * kBelow;
    return squared > 0 ? std::optional(0.5 * squared) : std::nullopt;
}

// With g and h the gradients: |g|^2 = D_0a / (s_0 s_a), |h|^2 = D_0b / (s_0 s_b), |g - h|^2 = D_ab / (s_a
// s_b), and |g x h|^2 is four times the square of the area of the triangle with these sides. By Heron it is
//     (2 (X Y + Y Z + Z X) - X^2 - Y^2 - Z^2) / (2 s_0 s_a s_b)^2,  X = D_0a s_b, Y = D_0b s_a, Z = D_ab s_0,
// where s are linear in t. |g x h|^2 is the product of the squared singular values, of which the greater is
// below |g|^2 + |h|^2 = (X + Y) / (s_0 s_a s_b).
std::optional<Slopes> slopes_between(const Oriented& o, const Oriented& a, const Oriented& b,
                                     const Interval& clearance, double size, double margin) {
    const double off = (size + 2 * margin) * kAbove;
    const Number oa = tangential(o, a, off), ob = tangential(o, b, off), ab = tangential(a, b, off);
    const double slack = (margin + off) * kAbove, low = clearance.lower() - slack,
                 high = clearance.upper() + slack;
    const auto s = [](const Oriented& e, double t) { return e.is_plane ? 1.0 : t + e.radius; };
    if (!(s(o, low) > 0) || !(s(a, low) > 0) || !(s(b, low) > 0)) return std::nullopt;
    const auto sides = [&](double t) {
        return Vec3(oa.value * s(b, t), ob.value * s(a, t), ab.value * s(o, t));
    };
    const auto polar = [](const Vec3& p, const Vec3& q) { return p.sum() * q.sum() - 2 * p.dot(q); };
    // Distances of both sites may be off on their own.
    const double longest = std::max({s(o, high), s(a, high), s(b, high)});
    const double error = (longest * std::max({oa.error, ob.error, ab.error}) +
                          slack * std::max({std::abs(oa.value), std::abs(ob.value), std::abs(ab.value)})) *
                         kAbove;
    // The denominator is taken at the end of each part, where it is greatest.
    double least = HUGE_VAL;
    for (int k = 0; k < kParts; ++k) {
        const Interval part = part_of(low, high, k);
        const double from = part.lower(), to = part.upper();
        const Vec3 first_sides = sides(from), last_sides = sides(to);
        // Bernstein coefficients of a quadratic.
        const double lowest = std::min(
            {polar(first_sides, first_sides), polar(first_sides, last_sides), polar(last_sides, last_sides)});
        const double sum = std::max(first_sides.cwiseAbs().sum(), last_sides.cwiseAbs().sum());
        const double numerator =
            lowest - (6 * sum * error + 15 * error * error + 0x1p-46 * sum * sum) * kAbove;
        const double denominator =
            4 * s(o, to) * s(a, to) * s(b, to) * (last_sides.x() + last_sides.y() + 2 * error) * kAbove;
        if (!(numerator > 0)) return std::nullopt;
        least = std::min(least, numerator / denominator);
    }
    const double x = (oa.value - oa.error) / (s(o, high) * s(a, high)),
                 y = (ob.value - ob.error) / (s(o, high) * s(b, high));
    const double growth = 0.5 * std::min(x, y) * kBelow;
    if (!(growth > 0)) return std::nullopt;
    return Slopes{std::sqrt(least) * kBelow, growth};
}

// With the gradient g = n_a - n_0 of the object's excess and the unit normal m of the side, |g|^2 = D / (s_0
// s_a). At the height e over the side a ball's direction has m n = (e - h) / s, h the height of its center,
// and a plane's the same everywhere, h with s = 1. So |g x m|^2 = |g|^2 - (g m)^2 is
//     (D s_0 s_a - q^2) / (s_0 s_a)^2,  q = k_a s_0 - k_0 s_a,  k = e - h,
// a quadratic in t over one. It is the product of the squared singular values, of which the greater is below
// |g|^2 + 1.
std::optional<Slopes> slopes_beside(const Oriented& o, const Oriented& a, const Inwards& side,
                                    const Interval& clearance, double size, double margin) {
    const double off = (size + 2 * margin) * kAbove;
    const Number oa = tangential(o, a, off);
    const double slack = (margin + off) * kAbove, low = clearance.lower() - slack,
                 high = clearance.upper() + slack;
    const auto s = [](const Oriented& x, double t) { return x.is_plane ? 1.0 : t + x.radius; };
    if (!(s(o, low) > 0) || !(s(a, low) > 0) || !(oa.value > oa.error)) return std::nullopt;
    // k, and what it is off by at most.
    const auto cosine = [&](const Oriented& x) {
        const double place = x.place[side.axis];
        if (x.is_plane) return Number{side.sign * place, kFew};
        return Number{side.sign * (side.place - place),
                      off + kFew * (std::abs(side.place) + std::abs(place))};
    };
    const Number of_base = cosine(o), own = cosine(a);
    const auto q = [&](double t) { return own.value * s(o, t) - of_base.value * s(a, t); };
    const double longest = std::max(s(o, high), s(a, high)) * kAbove;
    const double most_q = longest * (std::abs(own.value) + std::abs(of_base.value));
    const double q_error = (longest * (own.error + of_base.error) +
                            slack * (std::abs(own.value) + std::abs(of_base.value)) + kFew * most_q) *
                           kAbove;
    const double error = (longest * longest * (oa.error + kFew * oa.value) +
                          oa.value * slack * (2 * longest + slack) + q_error * (2 * most_q + q_error)) *
                         kAbove;
    double least = HUGE_VAL;
    for (int k = 0; k < kParts; ++k) {
        const Interval part = part_of(low, high, k);
        const double from = part.lower(), to = part.upper();
        // Bernstein coefficients of a quadratic.
        const double lowest =
            std::min({oa.value * s(o, from) * s(a, from) - q(from) * q(from),
                      0.5 * oa.value * (s(o, from) * s(a, to) + s(o, to) * s(a, from)) - q(from) * q(to),
                      oa.value * s(o, to) * s(a, to) - q(to) * q(to)});
        const double numerator = lowest - error, product = (s(o, to) + slack) * (s(a, to) + slack);
        if (!(numerator > 0)) return std::nullopt;
        least = std::min(least, numerator / (product * (oa.value + oa.error + product) * kAbove));
    }
    const double growth =
        0.5 * std::min((oa.value - oa.error) / ((s(o, high) + slack) * (s(a, high) + slack)), 1.0);
    return Slopes{std::sqrt(least) * kBelow, growth * kBelow};
}

}  // namespace vcell::check
