#include "shadows.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <type_traits>

#include "face_terms.hpp"
#include "space.hpp"
#include "triads.hpp"
#include "vessel_starts.hpp"

namespace vcell::check {

namespace {

template <class T>
struct Height {
    T t, steepness;
};

/// sqrt(beta^2 + alpha^2 C) of a tube, or that of a cone without its factor K, as one of a sum of squares, of
/// which little is lost next to the bisector's tips, where it vanishes. With a = d u, `leans` = a - S, L =
/// -delta and S = 0, K = 1 of a tube, m = way - (L / (1 - S a)) u', and K^2 |u'|^2 = (1 - S a)^2 - (a - S)^2:
///
///     beta^2 - (a - S)^2 C = K^2 (K^2 (way u')^2 + (a - S)^2 |way|^2).
template <class T>
T root_by_tip(const std::array<T, 2>& way, const std::array<T, 2>& across, const T& cosine, const T& leans) {
    return sqrt(square(cosine * (way[0] * across[0] + way[1] * across[1])) +
                square(leans) * (square(way[0]) + square(way[1])));
}

/// The distance at which the ray from the foot f along u meets the bisector.
template <class T>
Height<T> height(const Equation& equation, const Triad<T>& f, const Triad<T>& u) {
    switch (equation.kind) {
        case Equation::Kind::plane: {
            const T C = equation.sign * (dot(equation.c, f) + T(equation.offset)) + T(equation.radius);
            const T beta = 0.5 * (T(1.0) - equation.sign * dot(equation.c, u));
            return {C / (2.0 * beta), T(1.0) / sqrt(beta)};
        }
        case Equation::Kind::side: {
            const T speed = dot(equation.c, u);
            return {(T(equation.offset) - dot(equation.c, f)) / speed, T(1.0) / speed};
        }
        case Equation::Kind::ball: {
            const Triad<T> m{f[0] - T(equation.c[0]), f[1] - T(equation.c[1]), f[2] - T(equation.c[2])};
            const T beta = T(equation.delta) - dot(u, m);
            const T t = (squared_norm(m) - T(square(equation.delta))) / (2.0 * beta);
            return {t, sqrt(2.0 * (t + T(equation.delta)) / beta)};
        }
        case Equation::Kind::cone: {
            const std::array<T, 2> m{dot(equation.across[0], f) - T(equation.across_c[0]),
                                     dot(equation.across[1], f) - T(equation.across_c[1])};
            const T along = dot(equation.d, u), K2(square(equation.cosine));
            const T L = equation.sine * (dot(equation.d, f) - T(dot(equation.d, equation.c))) +
                        T(equation.radius),
                    turned = T(1.0) - equation.sine * along;
            const std::array<T, 2> across{dot(equation.across[0], u), dot(equation.across[1], u)};
            const T C = square(L) - K2 * (square(m[0]) + square(m[1]));
            const T beta = L * turned + K2 * (across[0] * m[0] + across[1] * m[1]);
            const T share = L / turned;
            const T root =
                equation.cosine * root_by_tip<T>({m[0] + share * across[0], m[1] + share * across[1]}, across,
                                                 T(equation.cosine), along - T(equation.sine));
            const T t = C / (beta + root);
            return {t, sqrt(2.0 * (L - t * turned) / root)};
        }
        default: {
            // In the plane across the axis, where lengths along it do not blur the bounds.
            const std::array<T, 2> m{dot(equation.across[0], f) - T(equation.across_c[0]),
                                     dot(equation.across[1], f) - T(equation.across_c[1])};
            const T alpha = dot(equation.d, u);
            const std::array<T, 2> across{dot(equation.across[0], u), dot(equation.across[1], u)};
            const T C = square(m[0]) + square(m[1]) - T(square(equation.delta));
            const T beta = T(equation.delta) - across[0] * m[0] - across[1] * m[1];
            const T root =
                root_by_tip<T>({m[0] - equation.delta * across[0], m[1] - equation.delta * across[1]}, across,
                               T(1.0), alpha);
            if (equation.is_hollow) {
                const T t = C / (beta - root);
                return {t, sqrt(-2.0 * (t + T(equation.delta)) / root)};
            }
            const T t = axial_root(C, beta, alpha, root);
            return {t, sqrt(2.0 * (t + T(equation.delta)) / root)};
        }
    }
}

template <class T>
struct Relative {
    T x, y, dx, dy;
};
/// A plane's coordinates about a point of it, times w.
template <class T>
Relative<T> relative(const Place<T>& p, const std::array<MidRad, 2>& about) {
    const MidRad x = about[0] - MidRad(p.origin[0]), y = about[1] - MidRad(p.origin[1]);
    return {p.n[0] - x * p.w, p.n[1] - y * p.w, p.dn[0] - x * p.dw, p.dn[1] - y * p.dw};
}

template <class T>
Densities<T> along(const LinearHeight& h, const Place<T>& p) {
    const auto [x, y, dx, dy] = relative(p, h.apex);
    const T turn = (x * dy - y * dx) / square(p.w);
    const T above = (h.gradient[0] * x + h.gradient[1] * y) / p.w;
    const T shadow = 0.5 * turn;
    // The part that grows in proportion to q - a is a third of its boundary's.
    return {(above * T(third) + T(h.half_at_apex)) * turn, shadow * T(h.steepness), shadow, T(h.steepness)};
}

template <class T>
Densities<T> along(const Paraboloid& h, const Place<T>& p) {
    const auto [x, y, dx, dy] = relative(p, h.axis);
    const T squared_weight = square(p.w);
    const T turn = (x * dy - y * dx) / squared_weight, s2 = (square(x) + square(y)) / squared_weight;
    return below_paraboloid(h, turn, s2);
}

}  // namespace

template <class T>
T solid_angle(const Triad<MidRad>& from, const Place<T>& p) {
    const Triad<T> n = p.whole(), dn = p.whole_derivative();
    const T size = sqrt(squared_norm(n));
    return determinant(from, n, dn) / (size * (size + dot(from, n)));
}

namespace {

// About the axis by phi: an integral over z times dphi, dphi = det(axis, p, dp) / (|p|^2 (1 - z^2)).
template <class T>
Densities<T> along(const Revolved& r, const Place<T>& p, const T& along_axis) {
    const Triad<T> n = p.whole(), dn = p.whole_derivative();
    const T norm2 = squared_norm(n), z = along_axis / sqrt(norm2);
    const T b = r.A * z + T(r.B), b1(r.b1);
    const T turn = determinant(r.axis, n, dn) / (norm2 * (T(1.0) + z));
    const T volume = T(r.volume) * (b1 + b) / square(b) * turn;
    const T steepness = sqrt(T(r.E) + 2.0 * (r.B * b)) / b;
    const T shadow = r.start ? solid_angle(*r.start, p) : turn;
    return {volume, T(r.K2) * revolved_area(r, b) * turn, shadow, steepness};
}
template <class T>
Densities<T> along(const Revolved& r, const Place<T>& p) {
    return along(r, p, dot(r.axis, p.whole()));
}

template <class T>
Densities<T> along(const ConeHeight& h, const Place<T>& p) {
    const auto [x, y, dx, dy] = relative(p, h.apex);
    const T turn = (x * dy - y * dx) / square(p.w);
    const auto [t, steepness] =
        height<T>(h.equation, {p.n[0] / p.w + T(p.origin[0]), p.n[1] / p.w + T(p.origin[1]), T(0.0)},
                  {T(0.0), T(0.0), T(1.0)});
    const T shadow = 0.5 * turn;
    return {((t - T(h.at_apex)) * T(third) + T(0.5 * h.at_apex)) * turn, shadow * steepness, shadow,
            steepness};
}

template <class T>
Densities<T> along(const RuledHeight& h, const Place<T>& p) {
    const auto [x, y, dx, dy] = relative(p, h.start);
    const T w2 = square(p.w);
    const T v = (h.along[0] * x + h.along[1] * y) / p.w, lambda = T(1.0) / (T(1.0) + h.kappa * v);
    const T velocity_x = p.dn[0] * p.w - p.n[0] * p.dw, velocity_y = p.dn[1] * p.w - p.n[1] * p.dw;
    const T turn =
        v * lambda * (h.kappa * (x * dy - y * dx) + (h.m[0] * velocity_y - h.m[1] * velocity_x)) / w2;
    const auto [t, steepness] =
        height<T>(h.equation, {p.n[0] / p.w + T(p.origin[0]), p.n[1] / p.w + T(p.origin[1]), T(0.0)},
                  {T(0.0), T(0.0), T(1.0)});
    const T sum = T(1.0) + lambda, shadow = 0.5 * (sum * turn);
    // From the apex at height h it would be ((t - h) (1 + lambda + lambda^2) / 3 + h (1 + lambda) / 2) turn.
    const T of_apex = T(0.5 * third) * (v * lambda * (T(1.0) + 2.0 * lambda)) * T(h.fall);
    const T volume = (t * (sum + square(lambda)) * T(third) + of_apex) * turn;
    return {volume, shadow * steepness, shadow, steepness};
}

// The face is a polygon or the like in its side: that of the edge's foot there, the wall between both, whose
// volume towards the axis counts, and what lies straight towards the axis from it, which has none.
template <class T>
Densities<T> along(const Flat& f, const Place<T>& p) {
    Triad<T> q, dq;
    for (const std::size_t i : {0, 1, 2}) {
        const MidRad from_corner = f.corner[i] - MidRad(p.origin[i]);
        q[i] = p.n[i] - from_corner * p.w;
        dq[i] = p.dn[i] - from_corner * p.dw;
    }
    const Triad<T> moment = cross(q, dq);
    const T w2 = square(p.w), area = 0.5 * dot(f.normal, moment) / w2;
    // Linear: over a triangle its mean is that of the corners.
    const T flux = T(f.flux_at_corner) + T(2.0 * third) * (dot(f.flux, q) / p.w);
    // Above the side by the edge's own rounding.
    const T above = dot(f.normal, q) / p.w + T(f.corner_above);
    const T x = q[0] / p.w + T(f.corner[0]), y = q[1] / p.w + T(f.corner[1]);
    const Triad<T> velocity{p.dn[0] * p.w - p.n[0] * p.dw, p.dn[1] * p.w - p.n[1] * p.dw,
                            p.dn[2] * p.w - p.n[2] * p.dw};
    const Triad<T> across = cross(f.normal, velocity);
    const T middle_x = x - 0.5 * (f.normal[0] * above), middle_y = y - 0.5 * (f.normal[1] * above);
    const T wall = 0.5 * above * (middle_x * across[0] + middle_y * across[1]) / w2;
    const T rise = q[2] / p.w;
    const T turn = rise * (y * velocity[0] - x * velocity[1]) / (w2 * (square(x) + square(y)));
    return {area * flux + wall, area, turn, T(1.0)};
}

// t = C / (2 beta), where C is linear in the height and beta depends on the direction alone.
template <class T>
Densities<T> along(const Tapered& h, const Place<T>& p) {
    const Equation& e = h.equation;
    const Triad<T> n = p.whole(), dn = p.whole_derivative();
    const T s2 = square(n[0]) + square(n[1]), s = sqrt(s2);
    const T rise = p.n[2] / p.w + T(MidRad(p.origin[2]) - h.start);
    const T turn = rise * (n[1] * dn[0] - n[0] * dn[1]) / s2;
    const T beta = 0.5 * (T(1.0) - e.sign * ((e.c[0] * n[0] + e.c[1] * n[1]) / s));
    const MidRad at_start = e.sign * (e.c[2] * h.start + e.offset) + e.radius;
    const T first(at_start), last = first + e.sign * (e.c[2] * rise);
    const T steepness = T(1.0) / sqrt(beta), inverse = T(1.0) / beta;
    return {turn * (square(first) + first * last + square(last)) * square(inverse) * T(third) * T(0.125),
            turn * (first + last) * inverse * T(0.25) * steepness, turn, steepness};
}

template <class T>
Densities<T> along(const Fan& fan, const Place<T>& p) {
    return {T(0.0), T(0.0), FanSection<T>(fan, p).shadow(), T(0.0)};
}

template <class T>
T steepness_of(const LinearHeight& h, const Place<T>&) {
    return T(h.steepness);
}
template <class T>
T steepness_of(const Paraboloid& h, const Place<T>& p) {
    const auto [x, y, dx, dy] = relative(p, h.axis);
    return sqrt(T(1.0) + (square(x) + square(y)) / square(p.w) * T(h.one_by_k2));
}
template <class T>
T steepness_of(const Revolved& r, const Place<T>& p) {
    const Triad<T> n = p.whole();
    const T b = r.A * (dot(r.axis, n) / sqrt(squared_norm(n))) + T(r.B);
    return sqrt(T(r.E) + 2.0 * (r.B * b)) / b;
}
template <class Other, class T>
T steepness_of(const Other& other, const Place<T>& p) {
    return along(other, p).steepness;
}

}  // namespace

namespace {

/// None: the apex is as near as the face is large.
std::optional<RuledHeight> ruled_height(const Equation& equation, std::span<const Triad<double>> corners) {
    const MidRad run = sqrt(square(equation.d[0]) + square(equation.d[1]));
    if (!(run.lower() > 0)) return std::nullopt;
    const std::array<MidRad, 2> n{equation.d[0] / run, equation.d[1] / run};
    const Triad<double>& corner = corners.front();
    const MidRad x = corner[0] - equation.c[0], y = corner[1] - equation.c[1];
    const MidRad v = n[0] * x + n[1] * y, across = n[0] * y - n[1] * x;
    // D times the slope.
    const MidRad slope = equation.d[2] - equation.sine,
                 rise = v * slope + (equation.c[2] + equation.delta) * run, kappa = slope / rise,
                 fall = -(equation.delta * slope + equation.sine * equation.c[2]) / rise;
    constexpr double nearest = 0.25;
    for (const Triad<double>& p : corners) {
        const MidRad reach = 1.0 + kappa * (n[0] * (p[0] - corner[0]) + n[1] * (p[1] - corner[1]));
        if (!(reach.lower() >= nearest)) return std::nullopt;
    }
    const MidRad aside = kappa * across;
    return RuledHeight{equation, {corner[0], corner[1]}, n, {n[0] - aside * n[1], n[1] + aside * n[0]}, kappa,
                       fall};
}

Shadow over_plane(const Equation& equation, std::span<const Triad<double>> corners) {
    const Triad<double>& corner = corners.front();
    const auto linear = [&](MidRad gx, MidRad gy, MidRad at_origin) {
        const MidRad x = corner[0], y = corner[1];
        return LinearHeight{
            {gx, gy}, {x, y}, 0.5 * (at_origin + gx * x + gy * y), sqrt(1.0 + square(gx) + square(gy))};
    };
    switch (equation.kind) {
        case Equation::Kind::side:
            return linear(-equation.c[0] / equation.c[2], -equation.c[1] / equation.c[2],
                          equation.offset / equation.c[2]);
        case Equation::Kind::plane: {
            const MidRad s = equation.sign, rise = 1.0 - s * equation.c[2];
            return linear(s * equation.c[0] / rise, s * equation.c[1] / rise, s * equation.offset / rise);
        }
        case Equation::Kind::ball: {
            const MidRad k = equation.c[2] + equation.delta;
            return Paraboloid{{equation.c[0], equation.c[1]},
                              0.5 * ((equation.c[2] - equation.delta) * k),
                              MidRad(0.5) / k,
                              MidRad(1.0) / square(k)};
        }
        default: {
            // Their cone's apex is where the axis comes as far below the plane as the radius, and that of the
            // inside of a tube, or a cone, as far above it, in the midst of the face perhaps: there only what
            // is told from the apex on is smooth.
            if (const auto ruled = ruled_height(equation, corners)) return *ruled;
            const double least_slope = equation.is_hollow ? 0 : 0x1p-5;
            const MidRad slope = equation.d[2] - equation.sine;
            if (slope.lower() > least_slope || slope.upper() < -least_slope) {
                const MidRad run = (-equation.delta - equation.c[2]) / slope;
                return ConeHeight{equation,
                                  {equation.c[0] + run * equation.d[0], equation.c[1] + run * equation.d[1]},
                                  -(equation.delta + equation.sine * equation.c[2] / slope)};
            }
            return Fan{Fan::Base::plane, equation, {corner[0], corner[1], 0.0}};
        }
    }
}

}  // namespace

Revolved::Revolved(const Triad<MidRad>& axis_, const MidRad& K, const MidRad& A_, const MidRad& B_,
                   const MidRad& E_, bool is_paraboloid_)
    : axis(axis_),
      A(A_),
      B(B_),
      E(E_),
      is_paraboloid(is_paraboloid_),
      b1(A + B),
      K2(square(K)),
      volume(K * K2 / (6.0 * square(b1))) {}

namespace {

Shadow revolved_about(const Equation& equation, MidRad radius) {
    switch (equation.kind) {
        case Equation::Kind::side: return Revolved{equation.c, equation.offset, 1.0, 0.0, 1.0, false};
        case Equation::Kind::plane: {
            const MidRad s = equation.sign;
            return Revolved{scaled(-s, equation.c), radius + s * equation.offset, 1.0, 1.0, 0.0, true};
        }
        case Equation::Kind::ball: {
            const MidRad distance = sqrt(squared_norm(equation.c));
            const MidRad E = (distance - equation.delta) * (distance + equation.delta);
            return Revolved{normalized(equation.c), 0.5 * E, distance, equation.delta, E, false};
        }
        default: {
            // The start is where the tube is nearest: a great circle from there to a direction in which the
            // tube is met meets it all along, for alpha has one sign on it, or beta is positive.
            const MidRad along = dot(equation.d, equation.c);
            Triad<MidRad> nearest;
            for (const std::size_t i : {0, 1, 2}) nearest[i] = equation.c[i] - along * equation.d[i];
            return Fan{Fan::Base::sphere, equation, normalized(nearest)};
        }
    }
}

// In a hollow sphere, with D the sum of the radii: t = (D^2 - |c|^2) / (2 (D - c u)). Of the axis' two ends
// that from which edges keep farther away is the one where integrals are singular.
Revolved revolved_around(const Equation& equation, std::span<const Triad<double>> points,
                         const Triad<MidRad>& start) {
    const MidRad D = -equation.delta, distance = sqrt(squared_norm(equation.c)),
                 E = (distance - D) * (distance + D);
    const bool is_centered =
        equation.c[0].magnitude() + equation.c[1].magnitude() + equation.c[2].magnitude() == 0;
    const Triad<MidRad> axis = is_centered ? start : normalized(equation.c);
    double nearest = -1, farthest = 1;
    for (const auto& p : points) {
        const double z = (axis[0].mid() * p[0] + axis[1].mid() * p[1] + axis[2].mid() * p[2]) /
                         std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        nearest = std::max(nearest, z);
        farthest = std::min(farthest, z);
    }
    const bool is_turned = !is_centered && nearest < -farthest;
    Revolved r{is_turned ? scaled(MidRad(-1.0), axis) : axis,
               -0.5 * E,
               is_centered ? MidRad(0.0)
               : is_turned ? distance
                           : -distance,
               D,
               E,
               false};
    r.start = start;
    return r;
}

// Of the foot q = p - (n p - o) n the flux is (n_x q_x + n_y q_y) / 2.
Flat flat(const Equation& side, const Triad<double>& corner) {
    const Triad<MidRad>& n = side.c;
    const Triad<MidRad> c{corner[0], corner[1], corner[2]};
    const MidRad across = square(n[0]) + square(n[1]), along = square(n[2]);
    const Triad<MidRad> flux{0.5 * (along * n[0]), 0.5 * (along * n[1]), -0.5 * (across * n[2])};
    return {n, c, dot(n, c) - side.offset, flux, dot(flux, c) + 0.5 * (across * side.offset)};
}

// The height on a base cylinder's axis at which a tube's integrals start: any is right. Where the axes are
// all but as far apart as the tube's radius is from the base's, distances turn within little of their common
// perpendicular, where rules find that at an end of what they integrate; and along some rays they grow beyond
// all bounds away from there, though the face is near by.
double start_below_tube(const Equation& tube, double least, double most) {
    constexpr double narrow = 0x1p-4;
    const double middle = 0.5 * (least + most), x = tube.c[0].mid(), y = tube.c[1].mid(),
                 dx = tube.d[0].mid(), dy = tube.d[1].mid(), lean = std::hypot(dx, dy),
                 delta = std::abs(tube.delta.mid()), length = most - least;
    if (!(lean > 0)) return middle;
    const double apart = std::abs(x * dy - y * dx) / lean,
                 foot = tube.c[2].mid() - (x * dx + y * dy) / (lean * lean) * tube.d[2].mid();
    const bool is_pinched =
        apart >= delta && std::sqrt(apart * apart - delta * delta) <= narrow * std::max(length, delta);
    return is_pinched && std::abs(foot - middle) <= length ? foot : middle;
}

}  // namespace

std::optional<Shadow> shadow(const Scene& scene, const Frame& frame, const Site& site,
                             const Outline& outline) {
    const std::vector<Triad<double>>& corners = outline.controls;
    if (corners.empty()) return std::nullopt;
    const std::optional<Equation> equation = equation_of(scene, frame, site, outline.points);
    if (!equation) return std::nullopt;
    if (std::holds_alternative<Plane>(scene.base)) return over_plane(*equation, corners);
    const bool about_sphere = std::holds_alternative<Sphere>(scene.base);
    if (equation->is_hollow && about_sphere) {
        const auto start = start_in_vessel(scene, frame, site, outline.points, [&](const Vec3& u) {
            return height<MidRad>(*equation, {0.0, 0.0, 0.0}, {u.x(), u.y(), u.z()}).t;
        });
        if (!start) return std::nullopt;
        if (equation->kind == Equation::Kind::ball) return revolved_around(*equation, outline.points, *start);
        Fan fan{Fan::Base::sphere, *equation, *start};
        double lowest = HUGE_VAL, highest = -HUGE_VAL;
        for (const auto& p : outline.points) {
            const double v = along_wall<MidRad>(*equation, {p[0], p[1], p[2]}).mid();
            lowest = std::min(lowest, v);
            highest = std::max(highest, v);
        }
        fan.along_wall = 0.5 * (lowest + highest);
        return fan;
    }
    if (equation->kind == Equation::Kind::tube && about_sphere) {
        // From the centre no face has anything opposite to a tip, beyond the great circle in which the tube
        // is met nowhere.
        const auto& [x, y, z] = outline.points.front();
        if (const auto pierced = Pierced::beyond(*equation, true, dot(equation->d, {x, y, z}).mid() > 0))
            return Fan{Fan::Base::sphere, *equation, normalized(pierced->point()), std::nullopt, pierced};
    }
    if (about_sphere) return revolved_about(*equation, frame.radius());
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (const auto& p : corners) {
        least = std::min(least, p[2]);
        most = std::max(most, p[2]);
    }
    if (equation->kind == Equation::Kind::side) return flat(*equation, corners.front());
    const double start = 0.5 * (least + most);
    if (equation->kind == Equation::Kind::plane) return Tapered{*equation, start};
    const bool is_tube = equation->kind == Equation::Kind::tube && !equation->is_hollow;
    if (is_tube) {
        if (const auto saddle = Saddle::of(std::get<Cylinder>(scene.base),
                                           std::get<Cylinder>(scene.objects[site.index]), frame, corners))
            return *saddle;
        const auto& [x, y, z] = outline.points.front();
        const bool is_far = (equation->d[0] * x + equation->d[1] * y).mid() > 0;
        const auto pierced = Pierced::beyond(*equation, false, is_far);
        if (pierced && pierced->point()[2].mid() > least && pierced->point()[2].mid() < most)
            return Fan{Fan::Base::cylinder, *equation, {0.0, 0.0, start}, std::nullopt, pierced};
    }
    // A vessel's is within it there, as the face is.
    return Fan{Fan::Base::cylinder,
               *equation,
               {0.0, 0.0, is_tube ? start_below_tube(*equation, least, most) : start}};
}

template <class T>
Densities<T> densities(const Shadow& shadow, const Place<T>& p) {
    return std::visit([&](const auto& s) { return along(s, p); }, shadow);
}

template <class T>
FanSection<T>::FanSection(const Fan& fan, const Place<T>& p) : fan_(fan) {
    if (fan.base == Fan::Base::plane) {
        const auto [x, y, dx, dy] = relative(p, {fan.start[0], fan.start[1]});
        turn_ = (x * dy - y * dx) / square(p.w);
        n_ = {x / p.w, y / p.w, T(0.0)};
        return;
    }
    const Triad<T> n = p.whole(), dn = p.whole_derivative();
    if (fan.base == Fan::Base::sphere) {
        n_ = n;
        q_ = dot(fan.start, n);
        size_ = sqrt(squared_norm(n));
        sum_ = size_ + q_;
        turn_ = determinant(fan.start, n, dn);
        const T h = sqrt(0.5 * (sum_ / size_)), up = T(1.0) + h;
        share_ = T(0.5) / (size_ * (h * up));
        tau2_ = 0.5 * ((size_ - q_) / (size_ * square(up)));
        turn_of_tau_ = 0.5 * (turn_ / (size_ * sum_ * square(up)));
        if (fan.along_wall) {
            const T share = T(1.0) / size_;
            const T t = height<T>(fan.equation, {T(0.0), T(0.0), T(0.0)}, scaled(share, n)).t;
            vessel_.emplace(fan.equation, *fan.along_wall, p, t);
        }
        if (fan.pierced) {
            const T share = T(1.0) / size_;
            const Triad<T> u = scaled(share, n), foot{T(0.0), T(0.0), T(0.0)};
            const T growth = dot(u, dn);
            const Triad<T> du =
                scaled(share, {dn[0] - growth * u[0], dn[1] - growth * u[1], dn[2] - growth * u[2]});
            beyond_tip_.emplace(*fan.pierced, foot, foot, u, du, height<T>(fan.equation, foot, u).t);
        }
        return;
    }
    // Between the start's height and the edge's, at the edge's angle: the face is on the left.
    const T s2 = square(n[0]) + square(n[1]), s = sqrt(s2);
    rise_ = p.n[2] / p.w + T(MidRad(p.origin[2]) - fan.start[2]);
    turn_ = rise_ * (n[1] * dn[0] - n[0] * dn[1]) / s2;
    n_ = {n[0] / s, n[1] / s, T(0.0)};
    if (fan.pierced) {
        const T turn = (n[0] * dn[1] - n[1] * dn[0]) / s2, zero(0.0);
        const Triad<T> foot{zero, zero, p.n[2] / p.w + T(p.origin[2])},
            d_foot{zero, zero, (p.dn[2] - p.n[2] / p.w * p.dw) / p.w},
            du{-(turn * n_[1]), turn * n_[0], zero};
        beyond_tip_.emplace(*fan.pierced, foot, d_foot, n_, du, height<T>(fan.equation, foot, n_).t);
    }
}

template <class T>
T FanSection<T>::shadow() const {
    switch (fan_.base) {
        case Fan::Base::plane: return 0.5 * turn_;
        case Fan::Base::sphere: return turn_ / (size_ * sum_);
        default: return turn_;
    }
}

template <class T>
Densities<T> FanSection<T>::at(const T& sigma) const {
    if (beyond_tip_) {
        const auto [volume, area, steepness] = beyond_tip_->at(sigma);
        return {volume, area, T(0.0), steepness};
    }
    switch (fan_.base) {
        case Fan::Base::plane: {
            const T turn = sigma * turn_;
            const auto [t, steepness] = height<T>(
                fan_.equation, {T(fan_.start[0]) + sigma * n_[0], T(fan_.start[1]) + sigma * n_[1], T(0.0)},
                {T(0.0), T(0.0), T(1.0)});
            return {turn * t, turn * steepness, turn, steepness};
        }
        case Fan::Base::sphere: {
            if (vessel_) {
                const auto [volume, area, steepness] = vessel_->at(sigma);
                return {volume, area, T(0.0), steepness};
            }
            // A way of theta from the start a is 4 arctan(tau), tau = sigma tan(theta / 4) of the edge's: so
            // a face may go on to next to -a. With c = (1 - tau^2) / (1 + tau^2) and s = 2 tau / (1 + tau^2)
            // half the way's cosine and sine, u = (c^2 - s^2) a + 2 s c e, where tan(theta / 4) e is the
            // edge's (p - q a) / (2 |p| h (1 + h)), h its c; and (1 - cos theta) dphi has 16 tau (1 - tau^2)
            // / (1 + tau^2)^3 dtau of it.
            const Triad<MidRad>& a = fan_.start;
            const T tau2 = square(sigma) * tau2_, weight = T(1.0) / (T(1.0) + tau2),
                    c = (T(1.0) - tau2) * weight;
            const T turn = 16.0 * (sigma * (c * square(weight) * turn_of_tau_));
            const T along = 4.0 * (sigma * (c * weight * share_)), up = 2.0 * square(c) - T(1.0) - along * q_;
            const auto [t, steepness] =
                height<T>(fan_.equation, {T(0.0), T(0.0), T(0.0)},
                          {along * n_[0] + a[0] * up, along * n_[1] + a[1] * up, along * n_[2] + a[2] * up});
            const T t2 = square(t);
            return {turn * t * t2 * T(third), turn * t2 * steepness, turn, steepness};
        }
        default: {
            const auto [t, steepness] =
                height<T>(fan_.equation, {T(0.0), T(0.0), T(fan_.start[2]) + sigma * rise_}, n_);
            return {turn_ * square(t) * T(0.5), turn_ * t * steepness, turn_, steepness};
        }
    }
}

MidRad steepness(const Shadow& shadow, const Place<MidRad>& p) {
    if (const auto* fan = std::get_if<Fan>(&shadow)) return FanSection<MidRad>(*fan, p).at(1.0).steepness;
    return std::visit([&](const auto& s) { return steepness_of(s, p); }, shadow);
}

template MidRad solid_angle(const Triad<MidRad>&, const Place<MidRad>&);
template Traced solid_angle(const Triad<MidRad>&, const Place<Traced>&);
template Approximate solid_angle(const Triad<MidRad>&, const Place<Approximate>&);
template <class T>
Densities<T> densities(const Revolved& shadow, const Place<T>& p, const T& along_axis) {
    return along(shadow, p, along_axis);
}

template Densities<MidRad> densities(const Revolved&, const Place<MidRad>&, const MidRad&);
template Densities<Disc> densities(const Revolved&, const Place<Disc>&, const Disc&);
template Densities<Traced> densities(const Revolved&, const Place<Traced>&, const Traced&);
template Densities<Approximate> densities(const Revolved&, const Place<Approximate>&, const Approximate&);
template Densities<MidRad> densities(const Shadow&, const Place<MidRad>&);
template Densities<Disc> densities(const Shadow&, const Place<Disc>&);
template Densities<Traced> densities(const Shadow&, const Place<Traced>&);
template Densities<Approximate> densities(const Shadow&, const Place<Approximate>&);
template class FanSection<MidRad>;
template class FanSection<Disc>;
template class FanSection<Traced>;
template class FanSection<Approximate>;

}  // namespace vcell::check
