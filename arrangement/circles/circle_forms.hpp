/// Circular forms in doubles: values and gradients with bounds on their errors, and quick comparisons all
/// over a rectangle. Asked of every pair of a form and a place, hence inline.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "../../core/curves/circular_form.hpp"
#include "../../core/ids.hpp"
#include "../../core/numbers/interval.hpp"

namespace vcell {

/// The curve {f = g}, directed so that f < g on its left.
struct FormPair {
    FormId f, g;

    FormPair reversed() const { return {g, f}; }
    friend bool operator==(FormPair, FormPair) = default;
};

// Rounding bounds of the first rung.
namespace kernel_bounds {

using roundoff::u;
constexpr double tiny = DBL_MIN;  // covers underflow in any bound below

// A form's value is computed with at most 13 relative roundings of the sum of absolute values of its
// terms (4 in a coefficient or in w, 5 in 1/w and the product with it, 4 in the terms and their sum), its
// gradient with at most 12, K with 6. The bounds themselves are computed with a handful of roundings.
constexpr double value_roundings = 16 * u;
constexpr double gradient_roundings = 16 * u;
constexpr double K_roundings = 8 * u;
static_assert(value_roundings >= (13 + 2) * u);
static_assert(gradient_roundings >= (12 + 2) * u);

// Bounds are sums and products of at most some twenty roundings; this covers them all.
constexpr double slop = 1 + 64 * u;

}  // namespace kernel_bounds

/// A form's value, gradient and quadratic coefficient at a place, with bounds on their errors.
struct FormJet {
    double v, gx, gy, K;
    double ev, eg, eK;

    /// Lower bound over |dx| <= rx, |dy| <= ry about the place.
    double lower_bound(double rx, double ry) const;
};
FormJet operator-(const FormJet& p, const FormJet& q);

/// A form about the middle of a rectangle of half sides rx, ry: for quick comparisons over the whole of it.
struct BoxForm {
    double v, gx, gy, K;
    double top;    ///< about the highest value in the rectangle
    double scale;  ///< bound on the sum of the absolute values of all terms anywhere in it

    /// Positive if f is certainly above g all over the rectangle. Plain arithmetic with one margin.
    static double excess(const BoxForm& f, const BoxForm& g, double rx, double ry);
    static bool certainly_above(const BoxForm& f, const BoxForm& g, double rx, double ry) {
        return excess(f, g, rx, ry) > 0;
    }
};

/// f with 1/w multiplied out: what the first rung evaluates.
struct KernelForm {
    double k, cx, cy, a, b, e, iw, K;

    static KernelForm of(const CircularForm& f) {
        const double iw = 1 / f.w;
        return {f.k, f.cx, f.cy, f.a, f.b, f.e, iw, f.k * iw};
    }
    FormJet jet(double x, double y) const;
    BoxForm over_box(double x, double y, double rx, double ry) const;
};

inline FormJet KernelForm::jet(double x, double y) const {
    const KernelForm& f = *this;
    using namespace kernel_bounds;
    const double dx = x - f.cx, dy = y - f.cy;
    const double r2 = f.k * (dx * dx + dy * dy), ax = f.a * x, by = f.b * y;
    const double kx = 2 * f.k * dx, ky = 2 * f.k * dy;
    FormJet j;
    j.v = (r2 + (ax + by + f.e)) * f.iw;
    j.gx = (kx + f.a) * f.iw;
    j.gy = (ky + f.b) * f.iw;
    j.K = f.K;
    j.ev = value_roundings * ((std::abs(r2) + std::abs(ax) + std::abs(by) + std::abs(f.e)) * f.iw) + tiny;
    j.eg = gradient_roundings *
               ((std::max(std::abs(kx), std::abs(ky)) + std::max(std::abs(f.a), std::abs(f.b))) * f.iw) +
           tiny;
    j.eK = K_roundings * std::abs(f.K);
    return j;
}

inline FormJet operator-(const FormJet& p, const FormJet& q) {
    using namespace kernel_bounds;
    FormJet d{p.v - q.v, p.gx - q.gx, p.gy - q.gy, p.K - q.K, 0, 0, 0};
    d.ev = (p.ev + q.ev + u * std::abs(d.v)) * slop;
    d.eg = (p.eg + q.eg + u * std::max(std::abs(d.gx), std::abs(d.gy))) * slop;
    d.eK = (p.eK + q.eK + u * std::abs(d.K)) * slop;
    return d;
}

inline double FormJet::lower_bound(double rx, double ry) const {
    const FormJet& d = *this;
    using namespace kernel_bounds;
    const double least_K = d.K - d.eK;
    // Per coordinate: min over |t| <= r of K t^2 + G t, from below.
    const auto term = [&](double G, double r) {
        G = std::abs(G) + d.eg;
        if (G < 2 * least_K * r) return -G * G / (4 * least_K) * slop - tiny;
        const double t = (least_K * r - G) * r;
        return t - 8 * u * (std::abs(least_K) * r + G) * r - tiny;
    };
    const double low = d.v - d.ev + (term(d.gx, rx) + term(d.gy, ry));
    return low - 4 * u * (std::abs(d.v) + std::abs(low)) - tiny;
}

inline BoxForm KernelForm::over_box(double x, double y, double rx, double ry) const {
    const KernelForm& f = *this;
    const double dx = x - f.cx, dy = y - f.cy;
    const double quadratic = f.k * (dx * dx + dy * dy), ax = f.a * x, by = f.b * y;
    BoxForm p;
    p.v = (quadratic + ax + by + f.e) * f.iw;
    p.gx = (2 * f.k * dx + f.a) * f.iw;
    p.gy = (2 * f.k * dy + f.b) * f.iw;
    p.K = f.K;
    const double change = std::abs(p.gx) * rx + std::abs(p.gy) * ry + std::abs(f.K) * (rx * rx + ry * ry);
    p.top = p.v + change;
    p.scale = (std::abs(quadratic) + std::abs(ax) + std::abs(by) + std::abs(f.e)) * f.iw + change;
    return p;
}

// Per coordinate K t^2 + G t >= -|G| r + (K r^2, where the minimum is at an end). Every quantity here is a
// sum of terms that `scale` bounds, with fewer than 40 roundings each.
inline double BoxForm::excess(const BoxForm& f, const BoxForm& g, double rx, double ry) {
    const double K = f.K - g.K, Gx = std::abs(f.gx - g.gx), Gy = std::abs(f.gy - g.gy);
    const double curved = (Gx > 2 * K * rx ? K * rx * rx : 0) + (Gy > 2 * K * ry ? K * ry * ry : 0);
    return f.v - g.v - (Gx * rx + Gy * ry) + curved - 64 * DBL_EPSILON * (f.scale + g.scale);
}

}  // namespace vcell
