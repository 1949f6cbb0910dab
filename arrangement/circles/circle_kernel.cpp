// The algebra. Write a curve {f = g} as F = K |p|^2 + G.p + C with G = (A, B), and two of them as F1,
// F2. Eliminating |p|^2 leaves their radical axis m.p + c = 0, m = K2 G1 - K1 G2, c = K2 C1 - K1 C2,
// whose points are p = (-c m + s d) / |m|^2 with d = (m_y, -m_x). Put into F1 and freed of the common
// factor K1 that gives
//
//     s^2 - D s + Z = 0,   D = G1 x G2,   Z = c^2 + C1 (K1 |G2|^2 - K2 G1.G2) + C2 (K2 |G1|^2 - K1 G1.G2),
//
// symmetric in both curves and valid when one is a line. The turn grad F1 x grad F2 at p is D - 2s:
// the point of orientation sigma is the root s = (D - sigma sqrt(Delta)) / 2, Delta = D^2 - 4 Z. So the
// orientation names the point and no root number is needed.
#include "circle_kernel.hpp"

#include <algorithm>
#include <cassert>
#include <cfloat>
#include <cmath>
#include <utility>

#include "../../core/solver/newton/kantorovich.hpp"
#include "circle_bounds.hpp"

namespace vcell {

namespace {

using namespace kernel_bounds;

// Gradients at a smaller angle (radians), one shorter than on its curve counting less, are as good as
// parallel.
constexpr double singular_angle = 1e-6;

// A function K |p|^2 + ... about a place, without bounds.
struct RoughJet {
    double v, gx, gy, K;

    double square() const { return gx * gx + gy * gy; }
    // Upper bound of the gradient's square on the curve, which is |grad|^2 - 4 K F.
    double square_on_curve() const { return square() + 4 * std::abs(K * v); }
};

// J is singular in the centre of a circle, where the middle between the ends of a half circle happens to be,
// and wherever the gradients are parallel. From there one gets away along the level line of one function, as
// far as the curve of the other may be: K t^2 + |grad| t = |F|.
Eigen::Vector2d step_from_singular(const RoughJet& f, const RoughJet& g) {
    const bool f_fades = f.square() * g.square_on_curve() <= g.square() * f.square_on_curve();
    const RoughJet &fading = f_fades ? f : g, &steep = f_fades ? g : f;
    if (steep.square() == 0) return {0, 0};  // concentric circles
    const double t =
        2 * std::abs(fading.v) / (std::sqrt(fading.square()) + std::sqrt(fading.square_on_curve()));
    return t / std::sqrt(steep.square()) * Eigen::Vector2d(-steep.gy, steep.gx);
}

}  // namespace

void CircleKernel::reset(const CircularFamily* family) {
    family_ = family;
    forms_.clear();
    sources_.clear();
    points_.clear();
    exact_forms_.clear();
    exact_points_.clear();
    exact_point_index_.clear();
    forms_.push_back({0, 0, 0, 0, 0, 0, 1, 0});
    sources_.push_back({});
}

FormId CircleKernel::add_line(double a, double b, double c) {
    forms_.push_back({0, 0, 0, a, b, c, 1, 0});
    return sources_.push_back({});
}

FormId CircleKernel::add_form(FormId in_family) {
    return add_form(in_family, make_form(family_->forms[in_family]));
}

FormId CircleKernel::add_form(FormId in_family, const Form& made) {
    forms_.push_back(made);
    return sources_.push_back({in_family});
}

CircleKernel::Form CircleKernel::make_form(const CircularForm& f) {
    const double iw = 1 / f.w;
    return {f.k, f.cx, f.cy, f.a, f.b, f.e, iw, f.k * iw};
}

// --- First rung --------------------------------------------------------------------------------------

// Newton-Kantorovich for F = (F1, F2) at the double point p, whose Jacobian J changes by exactly
// 2 (K1, K2)^T (q - p)^T between p and q: eta >= |J^-1 F(p)| and omega >= 2 |J^-1 (K1, K2)^T|. J is regular
// as far as the root, so the sign of det J there is its sign at p.
bool CircleKernel::certify(KernelPoint& p) const {
    const Jet f1 = jet(forms_[p.first.f], p.x, p.y), g1 = jet(forms_[p.first.g], p.x, p.y);
    const Jet f2 = jet(forms_[p.second.f], p.x, p.y);
    const Jet g2 = p.second.g == p.first.f   ? f1
                   : p.second.g == p.first.g ? g1
                                             : jet(forms_[p.second.g], p.x, p.y);
    const Jet a = difference(f1, g1), b = difference(f2, g2);
    const double det = cross(a.gx, a.gy, b.gx, b.gy);
    const double a1 = std::abs(a.gx) + std::abs(a.gy), b1 = std::abs(b.gx) + std::abs(b.gy);
    const double det_error = (a.eg * b1 + b.eg * a1 + 2 * a.eg * b.eg + 4 * u * a1 * b1) * slop + tiny;
    const double det_low = std::abs(det) - det_error;
    if (!(det_low > 0) || (det > 0) != (p.orientation == Sign::Positive)) return false;
    const double fa = std::abs(a.v) + a.ev, fb = std::abs(b.v) + b.ev;
    const double Ka = std::abs(a.K) + a.eK, Kb = std::abs(b.K) + b.eK;
    const double agx = std::abs(a.gx) + a.eg, agy = std::abs(a.gy) + a.eg;
    const double bgx = std::abs(b.gx) + b.eg, bgy = std::abs(b.gy) + b.eg;
    const double eta = (bgy * fa + agy * fb + bgx * fa + agx * fb) / det_low * slop;
    const double omega = 2 * (bgy * Ka + agy * Kb + bgx * Ka + agx * Kb) / det_low * slop;
    const auto radius = kantorovich_radius(eta, omega);
    if (!radius) return false;
    p.error = *radius;
    return true;
}

// Closed form about `near`: with J, C, K taken there, F = 0 reads J q = -C - K X, X = |q|^2. So
// q = a + b X with a = -J^-1 C, b = -J^-1 K, and |b|^2 X^2 - h X + |a|^2 = 0, h = 1 - 2 a.b. The smaller
// X has the orientation of J itself, the larger one the opposite. Nothing here needs a bound: certify()
// proves the outcome.
std::optional<KernelPoint> CircleKernel::certified_intersection(FormPair c, FormPair d, Sign orientation,
                                                                const Eigen::Vector2d& near,
                                                                bool moved) const {
    const auto rough = [&](FormId id) {
        const Form& f = forms_[id];
        const double dx = near.x() - f.cx, dy = near.y() - f.cy;
        return RoughJet{(f.k * (dx * dx + dy * dy) + (f.a * near.x() + f.b * near.y() + f.e)) * f.iw,
                        (2 * f.k * dx + f.a) * f.iw, (2 * f.k * dy + f.b) * f.iw, f.K};
    };
    const auto minus = [](const RoughJet& p, const RoughJet& q) {
        return RoughJet{p.v - q.v, p.gx - q.gx, p.gy - q.gy, p.K - q.K};
    };
    const RoughJet cf = rough(c.f), cg = rough(c.g), df = rough(d.f);
    const RoughJet dg = d.g == c.f ? cf : d.g == c.g ? cg : rough(d.g);
    const RoughJet f = minus(cf, cg), g = minus(df, dg);
    const double det = cross(f.gx, f.gy, g.gx, g.gy);
    const double inv = -1 / det;
    const double ax = (g.gy * f.v - f.gy * g.v) * inv, ay = (f.gx * g.v - g.gx * f.v) * inv;
    const double bx = (g.gy * f.K - f.gy * g.K) * inv, by = (f.gx * g.K - g.gx * f.K) * inv;
    const double h = 1 - 2 * (ax * bx + ay * by);
    const double aa = ax * ax + ay * ay, bb = bx * bx + by * by;
    const double discriminant = h * h - 4 * aa * bb;
    const auto elsewhere = [&]() -> std::optional<KernelPoint> {
        const double parallel = singular_angle * singular_angle * (f.square_on_curve() * g.square_on_curve());
        if (moved || det * det > parallel) return std::nullopt;
        return certified_intersection(c, d, orientation, near + step_from_singular(f, g), true);
    };
    if (!(discriminant > 0)) return elsewhere();
    const double root = h + std::sqrt(discriminant);
    const double X = (det > 0) == (orientation == Sign::Positive) ? 2 * aa / root : root / (2 * bb);
    KernelPoint p{near.x() + (ax + bx * X), near.y() + (ay + by * X), 0, c, d, orientation};
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !certify(p)) return elsewhere();
    if (p.error > 1e3 * DBL_EPSILON * (std::abs(p.x) + std::abs(p.y) + std::sqrt(aa))) {
        // The far root loses digits in a + b X; one Newton step gets them back, if they are to be had.
        const Jet f1 = difference(c, p.x, p.y), g1 = difference(d, p.x, p.y);
        const double inv1 = -1 / cross(f1.gx, f1.gy, g1.gx, g1.gy);
        KernelPoint better = p;
        better.x += (g1.gy * f1.v - f1.gy * g1.v) * inv1;
        better.y += (f1.gx * g1.v - g1.gx * f1.v) * inv1;
        if (certify(better) && better.error < p.error) p = better;
    }
    return p;
}

std::optional<PointId> CircleKernel::intersection(FormPair c, FormPair d, Sign orientation,
                                                  const Eigen::Vector2d& near) {
    assert(orientation != Sign::Zero);
    if (const auto p = certified_intersection(c, d, orientation, near)) return points_.push_back(*p);
    ++decisions_.by_exact;
    auto exact = exact_intersection(exact_curve(c), exact_curve(d), orientation);
    if (!exact) return std::nullopt;
    return add_exact_point(c, d, orientation, std::move(*exact));
}

double CircleKernel::lower_bound(FormId f, FormId g, double x0, double x1, double y0, double y1) const {
    const double x = 0.5 * x0 + 0.5 * x1, y = 0.5 * y0 + 0.5 * y1;
    const double rx = std::max(x1 - x, x - x0) * slop, ry = std::max(y1 - y, y - y0) * slop;
    return lower_bound(jet(forms_[f], x, y), jet(forms_[g], x, y), rx, ry);
}

std::array<double, 2> CircleKernel::height(FormId f, double x, double y) const {
    const Jet j = jet(forms_[f], x, y);
    return {j.v, j.ev};
}

std::array<double, 2> CircleKernel::height(FormId f, PointId p) const {
    const KernelPoint& q = points_[p];
    const Jet j = jet(forms_[f], q.x, q.y);
    const double slope = std::abs(j.gx) + std::abs(j.gy) + 2 * j.eg + (j.K + j.eK) * q.error;
    return {j.v, (j.ev + slope * q.error) * slop + tiny};
}

Sign CircleKernel::sign_at(PointId p, FormId f, FormId g, Jet& d) {
    const KernelPoint& q = points_[p];
    d = difference({f, g}, q.x, q.y);
    // |F(true) - F(q)| <= |grad F| r + |K| r^2 on the disk of radius r: the difference's own gradient.
    const double slope = std::abs(d.gx) + std::abs(d.gy) + 2 * d.eg + (std::abs(d.K) + d.eK) * q.error;
    const double bound = (d.ev + slope * q.error) * slop + tiny;
    if (std::abs(d.v) > bound) {
        ++decisions_.by_double;
        return sign_of(d.v);
    }
    // The forms' coefficients as intervals, relative to the point: tighter by the constants only, but it
    // is the exact rung's last chance to be spared.
    const auto value = [&](const Form& h) {
        const Interval e = Interval(h.e) * Interval(1 - 8 * u, 1 + 8 * u);
        const Interval a = Interval(h.a) * Interval(1 - 8 * u, 1 + 8 * u);
        const Interval b = Interval(h.b) * Interval(1 - 8 * u, 1 + 8 * u);
        const Interval iw = Interval(h.iw) * Interval(1 - 16 * u, 1 + 16 * u);
        const Interval dx = Interval(q.x) - Interval(h.cx), dy = Interval(q.y) - Interval(h.cy);
        return (Interval(h.k) * (square(dx) + square(dy)) + (a * Interval(q.x) + b * Interval(q.y) + e)) * iw;
    };
    const Interval v =
        value(forms_[f]) - value(forms_[g]) + Interval(-1, 1) * Interval(slope) * Interval(q.error);
    if (const auto s = v.sign()) {
        ++decisions_.by_interval;
        return *s;
    }
    ++decisions_.by_exact;
    return sign(exact_value(exact_curve({f, g}), exact_point(p)));
}

Sign CircleKernel::turn_at(PointId p, FormPair c, FormPair d) {
    const KernelPoint& q = points_[p];
    if (q.first == c && q.second == d && !(c == d)) return q.orientation;
    const Jet a = difference(c, q.x, q.y), b = difference(d, q.x, q.y);
    const double det = cross(a.gx, a.gy, b.gx, b.gy);
    if (std::abs(det) > gradient_product_error(a, b, q.error)) {
        ++decisions_.by_double;
        return sign_of(det);
    }
    ++decisions_.by_exact;
    const auto g = exact_gradient(exact_curve(c), exact_point(p));
    const auto h = exact_gradient(exact_curve(d), exact_point(p));
    return sign(g[0] * h[1] - g[1] * h[0]);
}

// Asked of parallel gradients: then doubles tell unless one of them all but vanishes.
Sign CircleKernel::along_sign(PointId p, FormPair c, FormPair d) {
    const KernelPoint& q = points_[p];
    const Jet a = difference(c, q.x, q.y), b = difference(d, q.x, q.y);
    const double dot = a.gx * b.gx + a.gy * b.gy;
    if (std::abs(dot) > gradient_product_error(a, b, q.error)) {
        ++decisions_.by_double;
        return sign_of(dot);
    }
    ++decisions_.by_exact;
    const auto g = exact_gradient(exact_curve(c), exact_point(p));
    const auto h = exact_gradient(exact_curve(d), exact_point(p));
    return sign(g[0] * h[0] + g[1] * h[1]);
}

// Does some line through both points have no slope in that variable, so that they share the other coordinate?
// The coefficients of lines are exact, and so is this answer. Piece and region sides along an axis carry many
// points.
bool CircleKernel::share_line(PointId p, PointId q, double Form::*slope) const {
    const KernelPoint &a = points_[p], &b = points_[q];
    const auto is_on = [&](const KernelPoint& point, FormPair c) {
        return point.first == c || point.second == c || point.first == c.reversed() ||
               point.second == c.reversed();
    };
    return std::ranges::any_of(std::array{a.first, a.second}, [&](FormPair c) {
        return !sources_[c.f].in_family.valid() && !sources_[c.g].in_family.valid() &&
               forms_[c.f].*slope == forms_[c.g].*slope && is_on(b, c);
    });
}

Sign CircleKernel::compare_x(PointId p, PointId q) {
    if (p == q) return Sign::Zero;
    const KernelPoint &a = points_[p], &b = points_[q];
    const double d = a.x - b.x;
    if (std::abs(d) > (a.error + b.error + u * std::abs(d)) * slop) {
        ++decisions_.by_double;
        return sign_of(d);
    }
    if (share_line(p, q, &Form::b)) {
        ++decisions_.by_double;
        return Sign::Zero;
    }
    ++decisions_.by_exact;
    const ExactPoint &e = exact_point(p), &f = exact_point(q);
    return compare({e.px, e.rx, e.d}, e.w, {f.px, f.rx, f.d}, f.w);
}

Sign CircleKernel::compare_y(PointId p, PointId q) {
    if (p == q) return Sign::Zero;
    const KernelPoint &a = points_[p], &b = points_[q];
    const double d = a.y - b.y;
    if (std::abs(d) > (a.error + b.error + u * std::abs(d)) * slop) {
        ++decisions_.by_double;
        return sign_of(d);
    }
    if (share_line(p, q, &Form::a)) {
        ++decisions_.by_double;
        return Sign::Zero;
    }
    ++decisions_.by_exact;
    const ExactPoint &e = exact_point(p), &f = exact_point(q);
    return compare({e.py, e.ry, e.d}, e.w, {f.py, f.ry, f.d}, f.w);
}

Sign CircleKernel::compare_xy(PointId p, PointId q) {
    const Sign s = compare_x(p, q);
    return s != Sign::Zero ? s : compare_y(p, q);
}

// --- Relations of two curves ---------------------------------------------------------------------------

Sign CircleKernel::intersection_sign(FormPair c, FormPair d, const Eigen::Vector2d& near) {
    if (certified_intersection(c, d, Sign::Positive, near) ||
        certified_intersection(c, d, Sign::Negative, near)) {
        ++decisions_.by_double;
        return Sign::Positive;
    }
    // The discriminant about `near`, where the coefficients are small: D^2 - 4 Z as above, in intervals.
    const Jet f = difference(c, near.x(), near.y()), g = difference(d, near.x(), near.y());
    const Interval C1 = Interval::ball(f.v, f.ev), A1 = Interval::ball(f.gx, f.eg),
                   B1 = Interval::ball(f.gy, f.eg), K1 = Interval::ball(f.K, f.eK);
    const Interval C2 = Interval::ball(g.v, g.ev), A2 = Interval::ball(g.gx, g.eg),
                   B2 = Interval::ball(g.gy, g.eg), K2 = Interval::ball(g.K, g.eK);
    const Interval dot = A1 * A2 + B1 * B2;
    const Interval Z = square(K2 * C1 - K1 * C2) + C1 * (K1 * (square(A2) + square(B2)) - K2 * dot) +
                       C2 * (K2 * (square(A1) + square(B1)) - K1 * dot);
    const Interval delta = square(A1 * B2 - B1 * A2) - Interval(4) * Z;
    if (delta.upper() < 0) {
        ++decisions_.by_interval;
        return Sign::Negative;
    }
    ++decisions_.by_exact;
    const ExactCurve ec = exact_curve(c), ed = exact_curve(d);
    if (ec.K.sign() == Sign::Zero && ed.K.sign() == Sign::Zero)
        return (ec.A * ed.B - ec.B * ed.A).sign() == Sign::Zero ? Sign::Negative : Sign::Positive;
    if ((ed.K * ec.A - ec.K * ed.A).sign() == Sign::Zero && (ed.K * ec.B - ec.K * ed.B).sign() == Sign::Zero)
        return Sign::Negative;
    return exact_discriminant(ec, ed).sign();
}

// Two curves are the same if (K, A, B, C) of one is a multiple of the other's, about any place: if no minor
// of the two rows is other than zero. The place is one about which a form of c has small coefficients.
bool CircleKernel::same_curve(FormPair c, FormPair d) {
    const Form& place = forms_[c.f].k != 0 ? forms_[c.f] : forms_[c.g];
    const auto row = [&](FormPair pair) {
        const Jet j = difference(pair, place.cx, place.cy);
        return std::array{Interval::ball(j.K, j.eK), Interval::ball(j.gx, j.eg), Interval::ball(j.gy, j.eg),
                          Interval::ball(j.v, j.ev)};
    };
    const auto r = row(c), s = row(d);
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (!(r[i] * s[j] - r[j] * s[i]).contains(0)) {
                ++decisions_.by_interval;
                return false;
            }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c), f = exact_curve(d);
    const auto zero = [](const Exact& a, const Exact& b, const Exact& p, const Exact& q) {
        return (a * q - b * p).sign() == Sign::Zero;
    };
    return zero(e.K, e.A, f.K, f.A) && zero(e.K, e.B, f.K, f.B) && zero(e.K, e.C, f.K, f.C) &&
           zero(e.A, e.B, f.A, f.B) && zero(e.A, e.C, f.A, f.C) && zero(e.B, e.C, f.B, f.C);
}

Sign CircleKernel::curvature_sign(FormPair c) {
    const double kf = forms_[c.f].K, kg = forms_[c.g].K;
    const double K = kf - kg;
    if (std::abs(K) > K_roundings * (std::abs(kf) + std::abs(kg)) * slop || (kf == 0 && kg == 0)) {
        ++decisions_.by_double;
        return sign_of(K);
    }
    ++decisions_.by_exact;
    const ExactForm &f = exact_form(c.f), &g = exact_form(c.g);
    return (f.K * g.W - g.K * f.W).sign();
}

// |grad F|^2 - 4 K F is the same everywhere: 4 K^2 r^2. Evaluate it where |grad F| is least, at the centre;
// of what may be a line, where doubles know none, near a form.
Sign CircleKernel::radius_sign(FormPair c) {
    const Form &f = forms_[c.f], &g = forms_[c.g];
    const double K = f.K - g.K;
    double x = f.cx, y = f.cy;
    if (std::abs(K) > 4 * K_roundings * (std::abs(f.K) + std::abs(g.K))) {
        // The centre solves grad F = 0; any point near it serves.
        const Jet o = difference(c, x, y);
        x -= o.gx / (2 * K);
        y -= o.gy / (2 * K);
    }
    const Jet j = difference(c, x, y);
    const double g2 = j.gx * j.gx + j.gy * j.gy, four_KF = 4 * j.K * j.v;
    const double bound =
        (4 * j.eg * (std::abs(j.gx) + std::abs(j.gy)) + 4 * j.eg * j.eg +
         4 * ((std::abs(j.K) + j.eK) * j.ev + std::abs(j.v) * j.eK) + 8 * u * (g2 + std::abs(four_KF))) *
            slop +
        tiny;
    if (std::abs(g2 - four_KF) > bound) {
        ++decisions_.by_double;
        return sign_of(g2 - four_KF);
    }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c);
    return (e.A * e.A + e.B * e.B - Exact(4.0) * e.K * e.C).sign();
}

}  // namespace vcell
