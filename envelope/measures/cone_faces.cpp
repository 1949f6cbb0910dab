// Hollow cones over a sphere.
#include <algorithm>
#include <cmath>

#include "radial_terms.hpp"

namespace vcell::radial_integrals {

using std::sqrt;

ConeFace::ConeFace(const RadialBaseProblem& problem, FormId form, const Around& face) {
    const auto& cone = std::get<HollowCone>(problem.objects[form]);
    const RadialForm& f = problem.family.radial_form(form);
    const Exact length2 = f.a[0] * f.a[0] + f.a[1] * f.a[1] + f.a[2] * f.a[2];
    axis = cone.axis.stableNormalized();
    S = cone.sine();
    K = cone.cosine();
    rho = problem.chart.radius;
    const Vec3 way = -cone.apex;
    h0 = axis.dot(way);
    out = way - h0 * axis;
    P = quotient(f.b0, length2);
    C = quotient(f.c[0], length2);
    length = out.norm();
    const Vec3 from_axis = face.near + out - axis.dot(face.near) * axis;
    const double wide = from_axis.norm();
    const double along = K * axis.dot(face.near) + (wide > 0 ? S / wide * from_axis.dot(Vec3(face.near)) : 0);
    first = face.start(along);
}

double ConeFace::least_distance() const { return C / (P + K * length) * 0.5; }

double ConeFace::distance(const Ray& ray) const { return point(ray).t; }

// B errs by the rounding of its terms, and the root by as much over itself.
ConeFace::Point ConeFace::point(const Ray& ray) const {
    const double along = dot(axis, ray.u), A = along - S, B = P * (1 - S * along) + K * K * dot(out, ray.u),
                 root = sqrt(std::max(0.0, B * B - C * A * A));
    return {along, A, root, C / (B + root)};
}

// Where a ray meets the wall's bisector: the direction e from the axis, how far from it, and what depends on
// e alone, with the letters of radial_integrals.hpp.
struct ConeFace::Foot {
    Vector e;
    double wide, nu, gamma, Q2, y;
};
ConeFace::Foot ConeFace::foot(const Ray& ray, const Point& p) const {
    Foot f;
    Vector across;
    for (int i = 0; i < 3; ++i) {
        across[i] = ray.u[i] - p.along * axis[i];
        f.e[i] = out[i] + p.t * across[i];
    }
    f.wide = norm(f.e);
    for (double& x : f.e) x /= f.wide;
    set_level(f);
    f.y = p.t * (K * p.along + S * dot(f.e, across));
    return f;
}
void ConeFace::set_level(Foot& f) const {
    const double towards = dot(out, f.e), aside = dot(axis, cross(f.e, {out.x(), out.y(), out.z()}));
    f.nu = P - K * towards;
    f.gamma = K * h0 + S * towards;
    f.Q2 = f.nu * f.nu + aside * aside;
}

// The antiderivatives in y from 0 on.
Share ConeFace::until(const Foot& f, double y) const {
    const double half = 0.5 / f.nu, y2 = y * y, level = S * f.gamma + K * rho;
    const double volume = half * (S * y2 * (0.25 * y2 + 0.5 * f.Q2) + level * y * (y2 / 3 + f.Q2)) -
                          K * half * half * y * (0.2 * y2 * y2 + f.Q2 * (2 * y2 / 3 + f.Q2));
    const double s2 = y2 + f.Q2, s = sqrt(s2), Q = sqrt(f.Q2);
    const double root = 0.5 * (y * s + f.Q2 * std::asinh(y / Q)),
                 linear = y2 / (s + Q) * (s2 + s * Q + f.Q2) / 3,
                 cube = 0.25 * y * s * s2 + 0.75 * f.Q2 * root;
    return {volume / 3, (S * linear + level * root - K * half * cube) / f.nu};
}

// The tip is at l = K h, h its distance from the apex. Sizes as in size().
Share ConeFace::until_tip(const BisectorTip& tip) const {
    const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
    const double l = K * (h0 + axis.dot(tip.point()));
    const Share sum = sum_around([&](double cosine, double sine) -> Share {
        Foot f;
        for (int i = 0; i < 3; ++i) f.e[i] = cosine * x[i] + sine * y[i];
        set_level(f);
        const double end = l - f.gamma, far = std::max(std::abs(end), std::abs(first));
        const Share after = until(f, end), before = first != 0 ? until(f, first) : Share{0, 0};
        const double s2 = far * far + f.Q2, t = 0.5 * s2 / f.nu,
                     wide = S * (far + std::abs(f.gamma)) + K * (rho + t);
        const double condition = 2 * span_integrals::term_rounding * (1 + 4 * (P + K * length) / f.nu),
                     reach = 2 * far + std::abs(l) + std::abs(f.gamma);
        return {after.volume - before.volume, after.area - before.area, condition * reach * t * wide / 3,
                condition * reach * wide * sqrt(s2) / f.nu};
    });
    const double side = tip.is_far ? 1 : -1;
    return {side * sum.volume, side * sum.area, sum.volume_rest, sum.area_rest};
}

// With the face on its left alpha and y are counter-clockwise, as the base sees the wall from within: the
// boundary integral is that of -G d alpha, G the antiderivative in y.
Share ConeFace::share(const Ray& ray) const {
    const Point p = point(ray);
    const Foot f = foot(ray, p);
    // C q^2 - 2 B q + A^2 = 0, q = 1 / t.
    const double dB = K * K * dot(out, ray.du) - P * S * dot(axis, ray.du),
                 dq = (dB / p.t - p.A * dot(axis, ray.du)) / p.root, stretch = p.t * p.t * dq;
    Vector dp;
    for (int i = 0; i < 3; ++i) dp[i] = p.t * ray.du[i] - stretch * ray.u[i];
    const double angle = dot(axis, cross(f.e, dp)) / f.wide;
    Share sum = until(f, f.y);
    if (first != 0) {
        const Share before = until(f, first);
        sum.volume -= before.volume;
        sum.area -= before.area;
    }
    return {-angle * sum.volume, -angle * sum.area};
}

// Integrands at their greatest times the way from the start and the angle. The angle errs by that of e, which
// the rounding of lengths turns, and by the condition of t; so do nu, and y by lengths.
Share ConeFace::size(const Ray& ray) const {
    const Point p = point(ray);
    const Foot f = foot(ray, p);
    const double far = std::max(std::abs(f.y), std::abs(first)), lengths = std::abs(h0) + length + p.t,
                 rounding = noise * lengths;
    const double dB = K * K * std::abs(dot(out, ray.du)) + P * S * std::abs(dot(axis, ray.du)),
                 stretch = p.t * p.t * (dB / p.t + std::abs(p.A * dot(axis, ray.du))) / p.root;
    const double condition = 1 + 4 * P / p.root, of_foot = 1 + noise * lengths / f.wide,
                 of_nu = 1 + 4 * (P + K * length) / f.nu;
    const double angle = (p.t * ray.rate + stretch) / f.wide,
                 off_angle = angle * (condition + lengths / f.wide) * of_foot * of_nu;
    const double s2 = far * far + f.Q2, t = 0.5 * s2 / f.nu,
                 wide = S * (far + std::abs(f.gamma)) + K * (rho + t);
    const double volume = t * wide / 3, area = wide * sqrt(s2) / f.nu;
    const double way = (first == 0 ? far : std::abs(f.y - first)) + 4 * noise * far;
    const double reach = way * off_angle + rounding * condition * angle;
    return {volume * reach, area * reach};
}

}  // namespace vcell::radial_integrals
