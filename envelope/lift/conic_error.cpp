#include "conic_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "../../core/curves/scaled_bernstein.hpp"
#include "longest_first.hpp"

namespace vcell {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

using roundoff::u;

// Of a residual, in the magnitudes that enter it: some ten operations.
constexpr double conic_rounding = 32 * u;
// Of a product of four vectors, and of one with what a plane carries.
constexpr double of_product = 5 * u, of_plane = 12 * u;

constexpr int deepest = 40, most_halvings = 200;  // of a span, and of an edge's spans, for their proof

// A bound over a span holds the largest of what enters it against the least weight or distance. Where these
// are of very different sizes along it (a hyperbola comes from far to next to the base) that is by as much
// too large: parts are bounded one by one then. Halving takes the square root of what sizes differ by, so
// that few do.
constexpr double even = 16;
constexpr int most_evenings = 8;
// What halving a span once rounds, of sizes in the whole of it.
constexpr double of_halving = 8 * u;

struct Controls {
    std::array<Vector4d, 3> X;  // times the weights
    std::array<double, 3> w;

    explicit Controls(const ConicSpan& s) : X{s.from, s.middle, s.to}, w{1, s.weight, 1} {}
    Bernstein<2> row(int i) const {
        return Bernstein<2>::from([&](int k) { return X[k][i]; });
    }
    Bernstein<2> weight() const {
        return Bernstein<2>::from([&](int k) { return w[k]; });
    }
};

double product(Chart chart, const Vector4d& a, const Vector4d& b) {
    return a.x() * b.x() + chart.across(a.y() * b.y()) + a.z() * b.z() - a.w() * b.w();
}

struct SpanBound {
    double distance;  // infinite where it is not proved
    bool is_even;
};

// How near to the conic all of a span is proved to be.
SpanBound span_distance(Chart chart, const ConicSpan& span, const std::array<DistancePlane, 2>& planes,
                        double inner, double sine2, double blur) {
    const std::array<const Vector4d*, 3> X{&span.from, &span.middle, &span.to};
    const double w = span.weight, over_w = 1 / w;
    const std::array<double, 3> weights{1, w, 1}, over{1, over_w, 1};
    std::array<double, 3> length;
    double far = 0, near = infinity, farthest = 0;
    for (int i = 0; i < 3; ++i) {
        length[i] = X[i]->norm();
        far = std::max(far, length[i] * over[i]);
        near = std::min(near, X[i]->w() * over[i]);
        farthest = std::max(farthest, X[i]->w() * over[i]);
    }
    std::array<double, 2> r{0, 0};
    for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 3; ++i)
            r[j] = std::max(r[j], std::abs(planes[j].normal.dot(*X[i]) - weights[i] * planes[j].k) * over[i]);
        r[j] += of_plane * (far + std::abs(planes[j].k)) + blur;
    }
    // NaN where the planes do not tell A: nothing is proved then.
    const double e = std::sqrt((r[0] * r[0] + 2 * std::abs(inner) * r[0] * r[1] + r[1] * r[1]) / sine2);
    // The cone's residual times w^2, whose coefficients are 1, w, (1 + 2 w^2) / 3, w, 1.
    const double w2 = 1 + 2 * w * w;
    // What is along an axis takes no part: small where the cone's tip is near.
    for (int i = 0; i < 3; ++i)
        length[i] = Vector4d(X[i]->x(), chart.across(X[i]->y()), X[i]->z(), X[i]->w()).norm();
    const auto q = [&](int i, int k) { return product(chart, *X[i], *X[k]); };
    const double largest = std::max({std::abs(q(0, 0)) + of_product * length[0] * length[0],
                                     (std::abs(q(0, 1)) + of_product * length[0] * length[1]) * over_w,
                                     (std::abs(q(0, 2) + 2 * q(1, 1)) +
                                      of_product * (length[0] * length[2] + 2 * length[1] * length[1])) /
                                         w2,
                                     (std::abs(q(1, 2)) + of_product * length[1] * length[2]) * over_w,
                                     std::abs(q(2, 2)) + of_product * length[2] * length[2]});
    // | |p| - t | = | |p|^2 - t^2 | / (|p| + t).
    const double cone = largest < 0.1 * near * near ? largest / (1.9 * near) : infinity,
                 phi = cone + 1.5 * (e + blur);
    double m2 = infinity;
    for (int i = 0; i < 3; ++i) {
        const double over_t = 1 / X[i]->w();
        std::array<double, 2> s, g;
        for (int j = 0; j < 2; ++j) {
            const DistancePlane& p = planes[j];
            s[j] = (weights[i] * p.k - p.normal.y() * chart.along(X[i]->y())) * over_t;
            g[j] = s[j] - 2 * p.normal.w();
        }
        const int n = std::abs(g[0]) > std::abs(g[1]) ? 0 : 1;
        const double turn = g[n] < 0 ? -1 : 1, product = turn * inner, other = g[1 - n];
        const double a = 2 * planes[n].power + 4 * planes[n].normal.w() * s[n] - s[n] * s[n];
        const double a_size = 2 * std::abs(planes[n].power) + 4 * std::abs(s[n]) + s[n] * s[n];
        const double share = 1 - 2 * product * other / (turn * g[n] + std::numbers::sqrt2);
        const double across = std::abs(std::numbers::sqrt2 * product - other) + conic_rounding;
        m2 = std::min(m2, a * share - across * across - conic_rounding * a_size * (1 + std::abs(share)));
    }
    m2 /= sine2;
    const double over_near = phi / near;
    m2 -= 8 * over_near * (std::sqrt(std::max(m2, 0.0)) + over_near);
    return {near > 0 && m2 > 0 && 2.5 * phi <= near * m2 ? e + 2 * phi / std::sqrt(m2) : infinity,
            farthest <= even * near};
}

double even_distance(Chart chart, const ConicSpan& span, const std::array<DistancePlane, 2>& planes,
                     double inner, double sine2, double blur, int evenings = 0) {
    const SpanBound whole = span_distance(chart, span, planes, inner, sine2, blur);
    if (whole.is_even || !(whole.distance < infinity) || evenings == most_evenings) return whole.distance;
    const double size = std::max({span.from.norm(), span.middle.norm() / span.weight, span.to.norm()});
    double most = 0;
    for (const ConicSpan& half : span.halves())
        most = std::max(most, even_distance(chart, half, planes, inner, sine2, blur, evenings + 1));
    return std::min(whole.distance, most + of_halving * size);
}

// A span with its trim, of degree N.
template <int N>
struct Trimmed {
    using Trim = std::array<Vector3d, N + 1>;

    Controls curve;
    Trim trim;
    int halvings = 0;
    // Absolute values of the controls, halved as these: with those of a part halving has rounded it.
    Controls curve_size;
    Trim trim_size;

    Trimmed(const ConicSpan& span, const ConicTrim& of) : curve(span), curve_size(span) {
        std::copy_n(of.points.begin(), N + 1, trim.begin());
        for (Vector4d& x : curve_size.X) x = x.cwiseAbs();
        std::ranges::transform(trim, trim_size.begin(), [](const Vector3d& p) { return p.cwiseAbs(); });
    }
    // In these sizes.
    double rounding() const { return conic_rounding + halvings * of_halving; }
    // How far halving has moved the curve at most.
    double moved() const {
        if (halvings == 0) return 0;
        const Vector3d size(curve_size.row(0).largest(), curve_size.row(1).largest(),
                            curve_size.row(2).largest());
        return halvings * of_halving * size.norm() / curve.weight().smallest_coefficient();
    }
    double size_in_patch(int i) const {
        return Bernstein<N>::from([&](int k) { return trim_size[k][i]; }).largest();
    }

    std::array<Trimmed, 2> halves() const {
        std::array<Trimmed, 2> half{*this, *this};
        for (Trimmed& h : half) ++h.halvings;
        divide(curve.X, half[0].curve.X, half[1].curve.X);
        divide(curve.w, half[0].curve.w, half[1].curve.w);
        divide(trim, half[0].trim, half[1].trim);
        divide(curve_size.X, half[0].curve_size.X, half[1].curve_size.X);
        divide(trim_size, half[0].trim_size, half[1].trim_size);
        return half;
    }

private:
    // De Casteljau at 1/2.
    template <class Points>
    static void divide(const Points& points, Points& first, Points& second) {
        Points work = points;
        const std::size_t n = points.size() - 1;
        for (std::size_t k = 0; k <= n; ++k) {
            first[k] = work[0];
            second[n - k] = work[n - k];
            for (std::size_t i = 0; i < n - k; ++i) work[i] = (work[i] + work[i + 1]) / 2;
        }
    }
};

// How far a patch's points S / S[3] at a trim are from the curve's X / W; the magnitudes that enter S bound
// its rounding. Infinite where a weight is not known to be positive.
template <int N, int M>
SpanBound off_curve(const std::array<Bernstein<N>, 4>& S, const std::array<double, 4>& size,
                    const std::array<Bernstein<2>, 3>& X, const Bernstein<2>& W, const Trimmed<M>& part) {
    const double rounding = part.rounding(), weight = S[3].smallest_coefficient() - rounding * size[3],
                 least = W.smallest_coefficient();
    if (!(weight > 0 && least > 0)) return {infinity, false};
    double squared = 0;
    for (int i = 0; i < 3; ++i) {
        const double off = (S[i] * W - S[3] * X[i]).largest() +
                           rounding * (size[i] * W.largest() + size[3] * X[i].largest());
        squared += off * off;
    }
    return {std::sqrt(squared) / (weight * least), S[3].largest() * W.largest() <= even * weight * least};
}

SpanBound trim_distance_of_part(const RadialPatch& patch, const Trimmed<2>& part) {
    const auto trim_row = [&](int i) { return Bernstein<2>::from([&](int k) { return part.trim[k][i]; }); };
    const Bernstein<2> U = trim_row(0), V = trim_row(1), D = trim_row(2);
    const std::array<Bernstein<4>, 6> monomials{square(D), U * D, V * D, square(U), U * V, square(V)};
    constexpr std::array<std::array<int, 2>, 6> powers{{{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};
    std::array<double, 6> largest;
    for (int k = 0; k < 6; ++k) largest[k] = monomials[k].largest();
    if (part.halvings > 0) {
        const double u = part.size_in_patch(0), v = part.size_in_patch(1), d = part.size_in_patch(2);
        largest = {d * d, u * d, v * d, u * u, u * v, v * v};
    }
    std::array<Bernstein<4>, 4> S;
    std::array<double, 4> size{};
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 6; ++k) {
            const double c = patch.coefficient(powers[k][0], powers[k][1])[i];
            S[i] = S[i] + c * monomials[k];
            size[i] += std::abs(c) * largest[k];
        }
    return off_curve(S, size, {part.curve.row(0), part.curve.row(1), part.curve.row(2)}, part.curve.weight(),
                     part);
}

// A patch about the base's axis is of degree two in each parameter, and its trims are cubics.
SpanBound trim_distance_of_part(const RadialPatch& patch, const Trimmed<3>& part) {
    const auto trim_row = [&](int i) { return Bernstein<3>::from([&](int k) { return part.trim[k][i]; }); };
    const Bernstein<3> U = trim_row(0), V = trim_row(1), D = trim_row(2);
    const std::array<Bernstein<6>, 3> in_u{square(D), U * D, square(U)}, in_v{square(D), V * D, square(V)};
    const double u = part.size_in_patch(0), v = part.size_in_patch(1), d = part.size_in_patch(2);
    const std::array size_in_u{d * d, u * d, u * u}, size_in_v{d * d, v * d, v * v};
    std::array<Bernstein<12>, 4> S;
    std::array<double, 4> size{};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const Vector4d& c = patch.coefficient(i, j);
            if (c.isZero(0)) continue;
            const Bernstein<12> monomial = in_u[i] * in_v[j];
            for (int k = 0; k < 4; ++k) {
                S[k] = S[k] + c[k] * monomial;
                size[k] += std::abs(c[k]) * size_in_u[i] * size_in_v[j];
            }
        }
    return off_curve(S, size, {part.curve.row(0), part.curve.row(1), part.curve.row(2)}, part.curve.weight(),
                     part);
}

// With T = mu v D^2 for a trim (U, V) / D, in the frame's own directions about its origin
// (cylinder_patch.hpp).
SpanBound trim_distance_of_part(const CylinderFrame& f, const Trimmed<3>& part) {
    const auto trim_row = [&](int i) { return Bernstein<3>::from([&](int k) { return part.trim[k][i]; }); };
    const Bernstein<3> U = trim_row(0), V = trim_row(1), D = trim_row(2);
    const double eps = f.eps(), rise = f.rise();
    const Bernstein<6> T = (eps * U + D) * V, D2 = square(D);
    const Bernstein<9> D3 = D2 * D, TV = T * V, TD = T * D, UD2 = U * D2;
    const double u = part.size_in_patch(0), v = part.size_in_patch(1), d = part.size_in_patch(2),
                 t = (eps * u + d) * v;
    const std::array<Bernstein<9>, 4> S{UD2 - 0.25 * eps * TV, TD,
                                        f.f0() * D3 + rise * UD2 + f.z1() * TD + f.z2() * TV, D3};
    const std::array size{u * d * d + 0.25 * eps * t * v, t * d,
                          std::abs(f.f0()) * d * d * d + std::abs(rise) * u * d * d +
                              std::abs(f.z1()) * t * d + std::abs(f.z2()) * t * v,
                          d * d * d};
    const Eigen::Vector2d ex = f.turned({1, 0}), ey = f.turned({0, 1}), o = f.turned(f.origin());
    const Bernstein<2> X = part.curve.row(0), Y = part.curve.row(1), W = part.curve.weight();
    const double moved = conic_rounding * (X.largest() + Y.largest() + W.largest() * f.origin().norm()) /
                         W.smallest_coefficient();
    SpanBound bound = off_curve(S, size,
                                {ex.x() * X + ey.x() * Y - o.x() * W, ex.y() * X + ey.y() * Y - o.y() * W,
                                 f.height().side() * part.curve.row(2)},
                                W, part);
    bound.distance += moved;
    return bound;
}

constexpr int trim_halvings = 10;

template <class Patch, int N>
double trim_distance(const Patch& patch, const Trimmed<N>& part) {
    SpanBound whole = trim_distance_of_part(patch, part);
    whole.distance += part.moved();
    const bool is_proved = whole.distance < infinity;
    if (whole.is_even || part.halvings >= (is_proved ? most_evenings : trim_halvings)) return whole.distance;
    double most = 0;
    for (const Trimmed<N>& half : part.halves()) {
        most = std::max(most, trim_distance(patch, half));
        if (!(most < whole.distance)) break;
    }
    return std::min(whole.distance, most);
}

}  // namespace

double conic_distance(std::span<const ConicSpan> spans, const std::array<DistancePlane, 2>& planes,
                      Chart chart, double blur) {
    const Vector4d &a = planes[0].normal, &b = planes[1].normal;
    const double product = (a - b).squaredNorm() * (a + b).squaredNorm();
    const double sine2 = 0.25 * product - conic_rounding * std::sqrt(product);
    const double inner = a.dot(b);
    double distance = 0;
    const double rest = unproved_length(std::vector<ConicSpan>(spans.begin(), spans.end()), deepest,
                                        most_halvings, [&](const ConicSpan& span) {
                                            const double of_span =
                                                even_distance(chart, span, planes, inner, sine2, blur);
                                            if (!(of_span < infinity)) return false;
                                            distance = std::max(distance, of_span);
                                            return true;
                                        });
    return distance + 4 * rest;
}

// No more is known over a sphere of what n has across the ray than that it is at most 1. Over a cylinder the
// bound with a is taken where it is the less: quotients of two polynomials are asked for, of which t is
// positive, and lengths of such, which along a span are no more, or no less, than in the control points.
// Patches reach 2 to each side at most, so that 1 + 2 h < 5.
double ray_gain(std::span<const ConicSpan> spans, const DistancePlane& plane, Chart chart, double off) {
    double most = 0, along_needle = 0;
    if (chart.is_sphere()) {
        for (const ConicSpan& span : spans)
            most = std::max({most, span.from.w(), span.middle.w() / span.weight, span.to.w()});
        const double least = std::abs(plane.k) * (1 - conic_rounding);
        return least > 0 ? 1 + most / least : infinity;
    }
    constexpr double of_direction = 5;
    const double x = plane.normal.x(), axial = plane.normal.y(), z = plane.normal.z();
    for (const ConicSpan& span : spans) {
        double slope = infinity, across = 0, near = infinity;
        bool is_turned = false;  // at the first point
        for (const Vector4d* X : {&span.from, &span.middle, &span.to}) {
            const double weight = X == &span.middle ? span.weight : 1, t = X->w();
            const double reach = axial * X->y(), at_axis = weight * plane.k, k = at_axis - reach,
                         least = std::abs(k) - conic_rounding * (std::abs(at_axis) + std::abs(reach));
            if (X == &span.from) is_turned = !(k > 0);
            if (!(least > 0 && (k > 0) != is_turned)) return infinity;
            most = std::max(most, t / least);
            slope = std::min(slope, least / t);
            across = std::max(across, (std::abs(x * X->z() - z * X->x()) +
                                       conic_rounding * (std::abs(X->x()) + std::abs(X->z()))) /
                                          t);
            near = std::min(near, t / weight);
        }
        const double turn = of_direction * off / near, most_across = across + 0.5 * turn,
                     least_slope = slope - most_across * turn;
        along_needle =
            std::max(along_needle, least_slope > 0 && near > 0
                                       ? std::hypot(axial, of_direction * most_across) / least_slope
                                       : infinity);
    }
    return std::min(1 + most, of_direction + along_needle);
}

double trim_distance(const RadialPatch& patch, const ConicSpan& span, const ConicTrim& trim) {
    return trim.degree == 3 ? trim_distance(patch, Trimmed<3>(span, trim))
                            : trim_distance(patch, Trimmed<2>(span, trim));
}

double trim_distance(const CylinderFrame& patch, const ConicSpan& span, const ConicTrim& trim) {
    return trim_distance(patch, Trimmed<3>(span, trim));
}

}  // namespace vcell
