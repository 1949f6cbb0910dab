// CircleKernel where points and curves are put in order: which point of a curve comes first, what bounds its
// arcs, and which of the curves through a point leaves it in a given sector.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "circle_bounds.hpp"
#include "circle_kernel.hpp"

namespace vcell {

namespace {

using namespace kernel_bounds;

// Boxes may be generous. Where the gradient keeps six digits and the ends are eight digits closer known than
// they are apart, angles are good to angle_margin (radians) and lengths to length_margin (relative).
constexpr double angle_margin = 1e-7, length_margin = 1e-6;
// Where K keeps five digits, a centre is good to this fraction of the terms it is computed from.
constexpr double least_K = 1e-5, center_margin = 1e-9;
static_assert(center_margin * least_K >= 32 * u);

}  // namespace

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
    const double error = P.error + Q.error;
    if (f.k == 0 && h.k == 0) {  // sides of a region or of its pieces: as below for tangents along the chord
        const double dx = Q.x - P.x, dy = Q.y - P.y, length = std::sqrt(dx * dx + dy * dy);
        if (1e8 * error < length) {
            const double margin = angle_margin * length;
            return {{std::min(P.x, Q.x) - margin, std::max(P.x, Q.x) + margin, std::min(P.y, Q.y) - margin,
                     std::max(P.y, Q.y) + margin},
                    length * (1 + length_margin),
                    margin};
        }
    }
    const double fx = (2 * f.k * (P.x - f.cx) + f.a) * f.iw, fy = (2 * f.k * (P.y - f.cy) + f.b) * f.iw;
    const double hx = (2 * h.k * (P.x - h.cx) + h.a) * h.iw, hy = (2 * h.k * (P.y - h.cy) + h.b) * h.iw;
    const double gx = fx - hx, gy = fy - hy, bx = Q.x - P.x, by = Q.y - P.y;
    const double g = std::sqrt(gx * gx + gy * gy), l = std::sqrt(bx * bx + by * by);
    const double terms = std::abs(f.K * P.x) + std::abs(f.K * P.y) + std::abs(f.K * f.cx) +
                         std::abs(f.K * f.cy) + std::abs(h.K * P.x) + std::abs(h.K * P.y) +
                         std::abs(h.K * h.cx) + std::abs(h.K * h.cy) + std::abs(fx) + std::abs(fy) +
                         std::abs(hx) + std::abs(hy);
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

}  // namespace vcell
