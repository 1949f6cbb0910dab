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
#include <limits>
#include <utility>

#include "../../core/solver/newton/kantorovich.hpp"

namespace vcell {

namespace {

using namespace kernel_bounds;

// Boxes may be generous. Where the gradient keeps six digits and the ends are eight digits closer known than
// they are apart, angles are good to angle_margin (radians) and lengths to length_margin (relative).
constexpr double angle_margin = 1e-7, length_margin = 1e-6;
// Where K keeps five digits, a centre is good to this fraction of the terms it is computed from.
constexpr double least_K = 1e-5, center_margin = 1e-9;
static_assert(center_margin * least_K >= 32 * u);
// Gradients at a smaller angle (radians), one shorter than on its curve counting less, are as good as
// parallel.
constexpr double singular_angle = 1e-6;

double cross(double ax, double ay, double bx, double by) { return ax * by - ay * bx; }

// A function K |p|^2 + ... about a place, without bounds.
struct Plain {
    double v, gx, gy, K;

    double square() const { return gx * gx + gy * gy; }
    // Upper bound of the gradient's square on the curve, which is |grad|^2 - 4 K F.
    double square_on_curve() const { return square() + 4 * std::abs(K * v); }
};

// J is singular in the centre of a circle, where the middle between the ends of a half circle happens to be,
// and wherever the gradients are parallel. From there one gets away along the level line of one function, as
// far as the curve of the other may be: K t^2 + |grad| t = |F|.
Eigen::Vector2d step_from_singular(const Plain& f, const Plain& g) {
    const bool f_fades = f.square() * g.square_on_curve() <= g.square() * f.square_on_curve();
    const Plain &fading = f_fades ? f : g, &steep = f_fades ? g : f;
    if (steep.square() == 0) return {0, 0};  // concentric circles
    const double t =
        2 * std::abs(fading.v) / (std::sqrt(fading.square()) + std::sqrt(fading.square_on_curve()));
    return t / std::sqrt(steep.square()) * Eigen::Vector2d(-steep.gy, steep.gx);
}

// Bound on the error of a gradient's component, taken at a place that is `error` away from the true point.
double gradient_error(const CircleKernel::Jet& j, double error) {
    return (j.eg + 2 * (std::abs(j.K) + j.eK) * error) * slop;
}

// Bound on the error of the cross or dot product of two such gradients: of either one's components, and two
// products and a sum.
double gradient_product_error(const CircleKernel::Jet& a, const CircleKernel::Jet& b, double error) {
    const double ea = gradient_error(a, error), eb = gradient_error(b, error);
    const double a1 = std::abs(a.gx) + std::abs(a.gy), b1 = std::abs(b.gx) + std::abs(b.gy);
    return (ea * b1 + eb * a1 + 2 * ea * eb + 4 * u * a1 * b1) * slop + tiny;
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
    forms_.push_back(make_form(family_->forms[in_family]));
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
    const auto plain = [&](FormId id) {
        const Form& f = forms_[id];
        const double dx = near.x() - f.cx, dy = near.y() - f.cy;
        return Plain{(f.k * (dx * dx + dy * dy) + (f.a * near.x() + f.b * near.y() + f.e)) * f.iw,
                     (2 * f.k * dx + f.a) * f.iw, (2 * f.k * dy + f.b) * f.iw, f.K};
    };
    const auto minus = [](const Plain& p, const Plain& q) {
        return Plain{p.v - q.v, p.gx - q.gx, p.gy - q.gy, p.K - q.K};
    };
    const Plain cf = plain(c.f), cg = plain(c.g), df = plain(d.f);
    const Plain dg = d.g == c.f ? cf : d.g == c.g ? cg : plain(d.g);
    const Plain f = minus(cf, cg), g = minus(df, dg);
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

// --- Order along a curve -------------------------------------------------------------------------------

// From p, with unit tangent t along c: chords to the curve's other points turn monotonically from t to -t.
// A chord shorter than the radius belongs to an arc of less than a right angle, on which the projection
// on t is monotone as well; that decides short and straight arcs without the sign of K. Other arcs have
// a well-defined K, and the turn between two chords decides.
bool CircleKernel::strictly_between(FormPair c, PointId p, PointId q, PointId r) {
    if (r == p || r == q) return false;
    if (p == q) return compare_xy(p, r) != Sign::Zero;
    const KernelPoint &P = points_[p], &Q = points_[q], &R = points_[r];
    const Jet j = difference(c, P.x, P.y);
    const double eg = gradient_error(j, P.error);
    const double g = std::hypot(j.gx, j.gy);
    const double tx = -j.gy, ty = j.gx;
    const double ax = R.x - P.x, ay = R.y - P.y, bx = Q.x - P.x, by = Q.y - P.y;
    const double la = std::hypot(ax, ay), lb = std::hypot(bx, by);
    const double ea = (P.error + R.error + 2 * u * la) * slop, eb = (P.error + Q.error + 2 * u * lb) * slop;
    const double twice_K = 2 * (std::abs(j.K) + j.eK);
    const double ta = tx * ax + ty * ay, tb = tx * bx + ty * by;
    const double eta = (g * ea + 2 * eg * (la + ea) + 8 * u * g * la) * slop + tiny;
    const double etb = (g * eb + 2 * eg * (lb + eb) + 8 * u * g * lb) * slop + tiny;
    const bool short_q = (lb + eb) * twice_K * slop < 0.9 * (g - 2 * eg) && tb > etb;
    if (short_q) {
        const bool short_r = (la + ea) * twice_K * slop < 0.9 * (g - 2 * eg);
        const bool long_r = (la - ea) * 2 * (std::abs(j.K) - j.eK) > 0.95 * (g + 2 * eg) * slop;
        if (long_r || (short_r && ta < -eta)) {
            ++decisions_.by_double;
            return false;
        }
        if (short_r && ta > eta && std::abs(tb - ta) > (eta + etb) * slop) {
            ++decisions_.by_double;
            return ta < tb;
        }
    }
    if (std::abs(j.K) > j.eK && la > ea && lb > eb) {
        const double turn = cross(ax, ay, bx, by);
        const double error = (ea * lb + eb * la + ea * eb + 4 * u * la * lb) * slop * 1.5 + tiny;
        if (std::abs(turn) > error) {
            ++decisions_.by_double;
            return (turn > 0) == (j.K > 0);
        }
    }
    ++decisions_.by_exact;
    return exact_strictly_between(c, p, q, r);
}

bool CircleKernel::precedes_on_line(FormPair c, PointId p, PointId q) {
    const KernelPoint &P = points_[p], &Q = points_[q];
    const Jet j = difference(c, P.x, P.y);
    const double bx = Q.x - P.x, by = Q.y - P.y;
    const double t = -j.gy * bx + j.gx * by;
    const double g = std::abs(j.gx) + std::abs(j.gy), l = std::abs(bx) + std::abs(by);
    const double error = P.error + Q.error + 2 * u * l;
    if (std::abs(t) > (g * error + 2 * j.eg * (l + error) + 8 * u * g * l) * slop + tiny) {
        ++decisions_.by_double;
        return t > 0;
    }
    ++decisions_.by_exact;
    return exact_line_order(exact_curve(c), p, q) == Sign::Negative;
}

// Sign of (place of p) - (place of q) along the direction (-B, A).
Sign CircleKernel::exact_line_order(const ExactCurve& e, PointId p, PointId q) {
    return e.B.sign() != Sign::Zero ? -e.B.sign() * compare_x(p, q) : e.A.sign() * compare_y(p, q);
}

// Counter-clockwise from the leftmost point: the lower half by increasing x, then the upper half by
// decreasing x. A clockwise curve swaps the roles of p and q, a line is ordered along (-B, A).
bool CircleKernel::exact_strictly_between(FormPair c, PointId p, PointId q, PointId r) {
    const Sign K = curvature_sign(c);
    if (K == Sign::Zero) {
        const ExactCurve e = exact_curve(c);
        return exact_line_order(e, p, r) == Sign::Negative && exact_line_order(e, r, q) == Sign::Negative;
    }
    if (K == Sign::Negative) std::swap(p, q);
    const auto order = [&](PointId s, PointId t) {
        const Sign hs = side_of_center(s, c), ht = side_of_center(t, c);
        // On the horizontal diameter the leftmost point comes first and the rightmost ends the lower half.
        const Sign x = compare_x(s, t);
        if (hs == ht) {
            if (hs == Sign::Positive) return -x;
            return x;  // both below, or both on the diameter
        }
        if (hs == Sign::Negative && ht == Sign::Positive) return Sign::Negative;
        if (hs == Sign::Positive && ht == Sign::Negative) return Sign::Positive;
        // Exactly one lies on the diameter. If it is the left end it comes first; the right end is after
        // the lower half and before the upper one. Both ends compare by x against the lower half.
        if (hs == Sign::Zero) {
            if (ht == Sign::Negative) return x;
            return Sign::Negative;
        }
        if (hs == Sign::Negative) return x;
        return Sign::Positive;
    };
    const bool pr = order(p, r) == Sign::Negative, rq = order(r, q) == Sign::Negative;
    if (order(p, q) == Sign::Negative) return pr && rq;
    return pr || rq;
}

Sign CircleKernel::side_of_center(PointId p, FormPair c) {
    const KernelPoint& q = points_[p];
    const Jet j = difference(c, q.x, q.y);
    if (std::abs(j.gy) > gradient_error(j, q.error) + tiny && std::abs(j.K) > j.eK) {
        ++decisions_.by_double;
        return sign_of(j.gy) * sign_of(j.K);
    }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c);
    return sign(exact_gradient(e, exact_point(p))[1]) * e.K.sign();
}

// An arc whose chord makes an angle theta < 90 degrees with the tangent at p stays within the sagitta
// |chord| / 2 tan(theta / 2) of its chord. Longer arcs get their circle's box. A box may be generous: where
// the gradient keeps enough digits in plain arithmetic, a relative margin of 1e-6 covers every rounding.
CircleKernel::ArcBounds CircleKernel::arc_bounds(FormPair c, PointId p, PointId q) const {
    const KernelPoint &P = points_[p], &Q = points_[q];
    const Form &f = forms_[c.f], &h = forms_[c.g];
    const double fx = (2 * f.k * (P.x - f.cx) + f.a) * f.iw, fy = (2 * f.k * (P.y - f.cy) + f.b) * f.iw;
    const double hx = (2 * h.k * (P.x - h.cx) + h.a) * h.iw, hy = (2 * h.k * (P.y - h.cy) + h.b) * h.iw;
    const double gx = fx - hx, gy = fy - hy, bx = Q.x - P.x, by = Q.y - P.y;
    const double g = std::sqrt(gx * gx + gy * gy), l = std::sqrt(bx * bx + by * by);
    const double terms = std::abs(f.K * P.x) + std::abs(f.K * P.y) + std::abs(f.K * f.cx) +
                         std::abs(f.K * f.cy) + std::abs(h.K * P.x) + std::abs(h.K * P.y) +
                         std::abs(h.K * h.cx) + std::abs(h.K * h.cy) + std::abs(fx) + std::abs(fy) +
                         std::abs(hx) + std::abs(hy);
    const double error = P.error + Q.error;
    const double cosine = (gx * by - gy * bx) / (g * l);
    if (cosine > 0.1 && 1e8 * error < l && 1e-6 * terms < g) {
        const double sine = std::abs(gx * bx + gy * by) / (g * l);
        const double margin =
            0.5 * l * ((sine + angle_margin) / (1 + cosine) + angle_margin) * (1 + length_margin);
        return {{std::min(P.x, Q.x) - margin, std::max(P.x, Q.x) + margin, std::min(P.y, Q.y) - margin,
                 std::max(P.y, Q.y) + margin},
                l * (1 + length_margin),
                margin};
    }
    constexpr double inf = std::numeric_limits<double>::infinity();
    return {circle_box(c), inf, inf};
}

// F about the centre of one of the forms: the circle's centre is at -grad / 2K from there.
std::optional<CircleKernel::Circle> CircleKernel::circle(FormPair c) const {
    const Form& f = forms_[c.f].K != 0 ? forms_[c.f] : forms_[c.g];
    const Jet o = difference(c, f.cx, f.cy);
    const Interval K = Interval::ball(o.K, o.eK);
    if (K.contains(0)) return std::nullopt;
    const Interval half = Interval(0.5) / K;
    const Interval gx = Interval::ball(o.gx, o.eg) * half, gy = Interval::ball(o.gy, o.eg) * half;
    return Circle{Interval(f.cx) - gx, Interval(f.cy) - gy,
                  square(gx) + square(gy) - Interval::ball(o.v, o.ev) / K};
}

std::array<double, 4> CircleKernel::circle_box(FormPair c) const {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const auto o = circle(c);
    if (!o) return {-inf, inf, -inf, inf};
    const Interval r = Interval(-1, 1) * sqrt(Interval(0.0, std::max(0.0, o->r2.upper())));
    const Interval x = o->cx + r, y = o->cy + r;
    return {x.lower(), x.upper(), y.lower(), y.upper()};
}

// Plain arithmetic: the centre is -grad / 2K from a form's own, and a relative margin of 1e-9 of all terms
// covers the roundings where K keeps enough digits. A circle in the box has its centre and extremes there.
bool CircleKernel::circle_leaves_box(FormPair c, const std::array<double, 4>& box) const {
    const Form &f = forms_[c.f], &g = forms_[c.g];
    const double K = f.K - g.K;
    if (!(std::abs(K) > least_K * (std::abs(f.K) + std::abs(g.K)))) return false;
    const Form &o = f.K != 0 ? f : g, &p = f.K != 0 ? g : f;
    const double sign = f.K != 0 ? 1 : -1;
    // At o's centre only the other form has a quadratic part and slope, but for linear terms.
    const double dx = o.cx - p.cx, dy = o.cy - p.cy;
    const double ox = o.a * o.iw, oy = o.b * o.iw, px = (2 * p.k * dx + p.a) * p.iw,
                 py = (2 * p.k * dy + p.b) * p.iw;
    const double half = 0.5 / K;
    const double x = o.cx - sign * (ox - px) * half, y = o.cy - sign * (oy - py) * half;
    const double margin =
        center_margin * (std::abs(o.cx) + std::abs(o.cy) + std::abs(p.cx) + std::abs(p.cy) +
                         (std::abs(ox) + std::abs(oy) + std::abs(px) + std::abs(py)) * std::abs(half));
    return x + margin < box[0] || x - margin > box[1] || y + margin < box[2] || y - margin > box[3];
}

// --- Branches around a point ---------------------------------------------------------------------------

// Where grad(c) and grad(d) point the same way: which of the two directed curves bends further left. The
// curvature is 2 K / |grad|; with grad(c) = l grad(d), l = grad(c).grad(d) / |grad(d)|^2 > 0, compare
// K_c |grad d|^2 with K_d grad(c).grad(d).
Sign CircleKernel::curvature_order(PointId p, FormPair c, FormPair d) {
    struct Bend {
        Interval K, gx, gy;
    };
    const KernelPoint& q = points_[p];
    const auto bend = [&](FormPair pair) {
        const Jet j = difference(pair, q.x, q.y);
        const double error = gradient_error(j, q.error);
        return Bend{Interval::ball(j.K, j.eK), Interval::ball(j.gx, error), Interval::ball(j.gy, error)};
    };
    const Bend bc = bend(c), bd = bend(d);
    const Interval order = bc.K * (square(bd.gx) + square(bd.gy)) - bd.K * (bc.gx * bd.gx + bc.gy * bd.gy);
    if (const auto s = order.sign()) {
        ++decisions_.by_interval;
        return *s;
    }
    ++decisions_.by_exact;
    const ExactCurve ec = exact_curve(c), ed = exact_curve(d);
    const auto g = exact_gradient(ec, exact_point(p)), h = exact_gradient(ed, exact_point(p));
    return sign(ec.K * (h[0] * h[0] + h[1] * h[1]) - ed.K * (g[0] * h[0] + g[1] * h[1]));
}

// Where branch x leaves relative to `from`, counter-clockwise: 0 the same branch, 1 same tangent but bending
// left of it, 2 less than half a turn, 3 opposite, 4 more than half, 5 same tangent but bending right.
int CircleKernel::sector_of(PointId p, FormPair from, FormPair x) {
    const Sign turn = turn_at(p, from, x);
    if (turn == Sign::Positive) return 2;
    if (turn == Sign::Negative) return 4;
    if (along_sign(p, from, x) == Sign::Negative) return 3;
    switch (curvature_order(p, x, from)) {
        case Sign::Positive: return 1;
        case Sign::Negative: return 5;
        default: return 0;
    }
}

bool CircleKernel::branch_in_sector(PointId p, FormPair from, FormPair x, FormPair to) {
    const int sx = sector_of(p, from, x);
    if (sx == 0) return false;
    int st = sector_of(p, from, to);
    if (st == 0) return true;  // the sector is the whole turn
    if (sx != st) return sx < st;
    if (sx == 2 || sx == 4) {
        const Sign turn = turn_at(p, x, to);
        if (turn != Sign::Zero) return turn == Sign::Positive;
    }
    return curvature_order(p, x, to) == Sign::Negative;
}

bool CircleKernel::sector_contains_left(PointId p, FormPair from, FormPair to) {
    const Sign turn = turn_at(p, from, to);
    if (turn != Sign::Zero) return turn == Sign::Negative;
    if (along_sign(p, from, to) == Sign::Positive) return curvature_order(p, to, from) != Sign::Positive;
    // One goes straight up, the other straight down: the tangent (-B, A) of `from` decides.
    const KernelPoint& q = points_[p];
    const Jet j = difference(from, q.x, q.y);
    if (std::abs(j.gx) > gradient_error(j, q.error)) {
        ++decisions_.by_double;
        return j.gx > 0;
    }
    ++decisions_.by_exact;
    return sign(exact_gradient(exact_curve(from), exact_point(p))[0]) == Sign::Positive;
}

// --- Exact rung ----------------------------------------------------------------------------------------

const ExactForm& CircleKernel::exact_form(FormId f) {
    std::int32_t& slot = sources_[f].exact;
    if (slot < 0) {
        const Form& g = forms_[f];
        slot = static_cast<std::int32_t>(exact_forms_.size());
        if (sources_[f].in_family.valid())
            exact_forms_.push_back(family_->exact(sources_[f].in_family));
        else
            exact_forms_.push_back({Exact(), Exact(g.a), Exact(g.b), Exact(g.e), Exact(1.0)});
    }
    return exact_forms_[static_cast<std::size_t>(slot)];
}

CircleKernel::ExactCurve CircleKernel::exact_curve(FormPair c) {
    const ExactForm &f = exact_form(c.f), &g = exact_form(c.g);
    return {f.K * g.W - g.K * f.W, f.A * g.W - g.A * f.W, f.B * g.W - g.B * f.W, f.C * g.W - g.C * f.W};
}

Exact CircleKernel::exact_discriminant(const ExactCurve& c, const ExactCurve& d) {
    const Exact D = c.A * d.B - c.B * d.A;
    const Exact k = d.K * c.C - c.K * d.C;
    const Exact dot = c.A * d.A + c.B * d.B;
    const Exact Z = k * k + c.C * (c.K * (d.A * d.A + d.B * d.B) - d.K * dot) +
                    d.C * (d.K * (c.A * c.A + c.B * c.B) - c.K * dot);
    return D * D - Exact(4.0) * Z;
}

std::optional<CircleKernel::ExactPoint> CircleKernel::exact_intersection(const ExactCurve& c,
                                                                         const ExactCurve& d,
                                                                         Sign orientation) {
    const Exact D = c.A * d.B - c.B * d.A;
    if (c.K.sign() == Sign::Zero && d.K.sign() == Sign::Zero) {
        if (D.sign() == Sign::Zero || D.sign() != orientation) return std::nullopt;
        const Exact s(orientation == Sign::Positive ? 1.0 : -1.0);
        return ExactPoint{
            s * (c.B * d.C - d.B * c.C), Exact(), s * (c.C * d.A - d.C * c.A), Exact(), Exact(), s * D};
    }
    const Exact mx = d.K * c.A - c.K * d.A, my = d.K * c.B - c.K * d.B;
    const Exact m2 = mx * mx + my * my;
    if (m2.sign() == Sign::Zero) return std::nullopt;  // concentric circles
    const Exact delta = exact_discriminant(c, d);
    if (delta.sign() == Sign::Negative || (delta.sign() == Sign::Zero) != (orientation == Sign::Zero))
        return std::nullopt;
    const Exact two_c = Exact(2.0) * (d.K * c.C - c.K * d.C);
    const Exact s(static_cast<double>(orientation));
    return ExactPoint{D * my - two_c * mx, -(s * my), -(two_c * my) - D * mx, s * mx, delta, Exact(2.0) * m2};
}

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

// |grad F|^2 - 4 K F is the same everywhere: 4 K^2 r^2. Evaluate it where |grad F| is least, at the centre.
Sign CircleKernel::radius_sign(FormPair c) {
    const Form &f = forms_[c.f], &g = forms_[c.g];
    const double K = f.K - g.K;
    if (std::abs(K) > 4 * K_roundings * (std::abs(f.K) + std::abs(g.K))) {
        // The centre solves grad F = 0; any point near it serves.
        const Jet o = difference(c, f.cx, f.cy);
        const double x = f.cx - o.gx / (2 * K), y = f.cy - o.gy / (2 * K);
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
    }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c);
    return (e.A * e.A + e.B * e.B - Exact(4.0) * e.K * e.C).sign();
}

PointId CircleKernel::add_exact_point(FormPair c, FormPair d, Sign orientation, ExactPoint exact) {
    const Interval x = enclosure(OneRoot{exact.px, exact.rx, exact.d}, exact.w);
    const Interval y = enclosure(OneRoot{exact.py, exact.ry, exact.d}, exact.w);
    const double error = std::hypot(x.radius(), y.radius()) * 1.5 + tiny;
    const PointId p = points_.push_back({x.mid(), y.mid(), error, c, d, orientation});
    exact_point_index_.resize(points_.size(), -1);
    exact_point_index_[p.value] = static_cast<std::int32_t>(exact_points_.size());
    exact_points_.push_back(std::move(exact));
    return p;
}

PointId CircleKernel::touching_point(FormPair c, FormPair d) {
    auto exact = exact_intersection(exact_curve(c), exact_curve(d), Sign::Zero);
    assert(exact);
    return add_exact_point(c, d, Sign::Zero, std::move(*exact));
}

PointId CircleKernel::circle_point(FormPair c, Sign which) {
    const auto o = circle(c);
    if (o && (which == Sign::Zero || o->r2.lower() > 0)) {
        const Interval x = which == Sign::Zero       ? o->cx
                           : which == Sign::Negative ? o->cx - sqrt(o->r2)
                                                     : o->cx + sqrt(o->r2);
        const double error = std::hypot(x.radius(), o->cy.radius()) * slop + tiny;
        if (error < DBL_MAX) return points_.push_back({x.mid(), o->cy.mid(), error, c, c, which});
    }
    return add_exact_point(c, c, which, exact_circle_point(c, which));
}

CircleKernel::ExactPoint CircleKernel::exact_circle_point(FormPair c, Sign which) {
    const ExactCurve e = exact_curve(c);
    assert(e.K.sign() != Sign::Zero);
    const Exact s(static_cast<double>(e.K.sign()));
    return {-(s * e.A),
            Exact(static_cast<double>(which)),
            -(s * e.B),
            Exact(),
            e.A * e.A + e.B * e.B - Exact(4.0) * e.K * e.C,
            s * Exact(2.0) * e.K};
}

const CircleKernel::ExactPoint& CircleKernel::exact_point(PointId p) {
    exact_point_index_.resize(points_.size(), -1);
    std::int32_t& slot = exact_point_index_[p.value];
    if (slot < 0) {
        const KernelPoint& q = points_[p];
        ExactPoint exact =
            q.first == q.second
                ? exact_circle_point(q.first, q.orientation)
                : exact_intersection(exact_curve(q.first), exact_curve(q.second), q.orientation).value();
        slot = static_cast<std::int32_t>(exact_points_.size());
        exact_points_.push_back(std::move(exact));
    }
    return exact_points_[static_cast<std::size_t>(slot)];
}

OneRoot CircleKernel::exact_value(const ExactCurve& c, const ExactPoint& p) {
    // K |p|^2 + A x + B y + C, times w^2.
    const OneRoot x{p.px, p.rx, p.d}, y{p.py, p.ry, p.d};
    return c.K * (x * x + y * y) + p.w * (c.A * x + c.B * y) + c.C * p.w * p.w;
}

std::array<OneRoot, 2> CircleKernel::exact_gradient(const ExactCurve& c, const ExactPoint& p) {
    const OneRoot x{p.px, p.rx, p.d}, y{p.py, p.ry, p.d};
    const Exact two_K = Exact(2.0) * c.K;
    return {two_K * x + c.A * p.w, two_K * y + c.B * p.w};
}

}  // namespace vcell
