#include "curve_order.hpp"

#include <cmath>
#include <utility>

#include "circle_bounds.hpp"

namespace vcell {

using namespace kernel_bounds;

// From p, with unit tangent t along c: chords to the curve's other points turn monotonically from t to -t.
// A chord shorter than the radius belongs to an arc of less than a right angle, on which the projection
// on t is monotone as well; that decides short and straight arcs without the sign of K. Other arcs have
// a well-defined K, and the turn between two chords decides.
bool CurveOrder::strictly_between(PointId p, PointId q, PointId r) {
    if (r == p || r == q) return false;
    if (p == q) return kernel_.compare_xy(p, r) != Sign::Zero;
    const KernelPoint &P = kernel_.point(p), &Q = kernel_.point(q), &R = kernel_.point(r);
    const FormJet j = kernel_.jet(curve_, P.x, P.y);
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
            ++kernel_.decisions().by_double;
            return false;
        }
        if (short_r && ta > eta && std::abs(tb - ta) > (eta + etb) * slop) {
            ++kernel_.decisions().by_double;
            return ta < tb;
        }
    }
    if (std::abs(j.K) > j.eK && la > ea && lb > eb) {
        const double turn = cross(ax, ay, bx, by);
        const double error = (ea * lb + eb * la + ea * eb + 4 * u * la * lb) * slop * 1.5 + tiny;
        if (std::abs(turn) > error) {
            ++kernel_.decisions().by_double;
            return (turn > 0) == (j.K > 0);
        }
    }
    ++kernel_.decisions().by_exact;
    return exact_strictly_between(p, q, r);
}

bool CurveOrder::precedes(PointId p, PointId q) {
    const KernelPoint &P = kernel_.point(p), &Q = kernel_.point(q);
    const FormJet j = kernel_.jet(curve_, P.x, P.y);
    const double bx = Q.x - P.x, by = Q.y - P.y;
    const double t = -j.gy * bx + j.gx * by;
    const double g = std::abs(j.gx) + std::abs(j.gy), l = std::abs(bx) + std::abs(by);
    const double error = P.error + Q.error + 2 * u * l;
    if (std::abs(t) > (g * error + 2 * j.eg * (l + error) + 8 * u * g * l) * slop + tiny) {
        ++kernel_.decisions().by_double;
        return t > 0;
    }
    ++kernel_.decisions().by_exact;
    return exact_line_order(kernel_.exact_curve(curve_), p, q) == Sign::Negative;
}

// Sign of (place of p) - (place of q) along the direction (-B, A).
Sign CurveOrder::exact_line_order(const ExactCurve& e, PointId p, PointId q) {
    return e.B.sign() != Sign::Zero ? -e.B.sign() * kernel_.compare_x(p, q)
                                    : e.A.sign() * kernel_.compare_y(p, q);
}

// Counter-clockwise from the leftmost point: the lower half by increasing x, then the upper half by
// decreasing x. A clockwise curve swaps the roles of p and q, a line is ordered along (-B, A).
bool CurveOrder::exact_strictly_between(PointId p, PointId q, PointId r) {
    const Sign K = kernel_.curvature_sign(curve_);
    if (K == Sign::Zero) {
        const ExactCurve e = kernel_.exact_curve(curve_);
        return exact_line_order(e, p, r) == Sign::Negative && exact_line_order(e, r, q) == Sign::Negative;
    }
    if (K == Sign::Negative) std::swap(p, q);
    const auto order = [&](PointId s, PointId t) {
        const Sign hs = kernel_.side_of_center(s, curve_), ht = kernel_.side_of_center(t, curve_);
        // On the horizontal diameter the leftmost point comes first and the rightmost ends the lower half.
        const Sign x = kernel_.compare_x(s, t);
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

}  // namespace vcell
