#include "point_star.hpp"

#include <cmath>

#include "circle_bounds.hpp"

namespace vcell {

using namespace kernel_bounds;

// Asked of parallel gradients: then doubles tell unless one of them all but vanishes.
Sign PointStar::along_sign(FormPair c, FormPair d) {
    const KernelPoint& q = kernel_.point(point_);
    const FormJet a = kernel_.jet(c, q.x, q.y), b = kernel_.jet(d, q.x, q.y);
    const double dot = a.gx * b.gx + a.gy * b.gy;
    if (std::abs(dot) > gradient_product_error(a, b, q.error)) {
        ++kernel_.decisions().by_double;
        return sign_of(dot);
    }
    ++kernel_.decisions().by_exact;
    const auto g = kernel_.exact_curve(c).gradient(kernel_.exact_point(point_));
    const auto h = kernel_.exact_curve(d).gradient(kernel_.exact_point(point_));
    return sign(g[0] * h[0] + g[1] * h[1]);
}

// Where grad(c) and grad(d) point the same way: which of the two directed curves bends further left. The
// curvature is 2 K / |grad|; with grad(c) = l grad(d), l = grad(c).grad(d) / |grad(d)|^2 > 0, compare
// K_c |grad d|^2 with K_d grad(c).grad(d).
Sign PointStar::curvature_order(FormPair c, FormPair d) {
    struct Bend {
        Interval K, gx, gy;
    };
    const KernelPoint& q = kernel_.point(point_);
    const auto bend = [&](FormPair pair) {
        const FormJet j = kernel_.jet(pair, q.x, q.y);
        const double error = gradient_error(j, q.error);
        return Bend{Interval::ball(j.K, j.eK), Interval::ball(j.gx, error), Interval::ball(j.gy, error)};
    };
    const Bend bc = bend(c), bd = bend(d);
    const Interval order = bc.K * (square(bd.gx) + square(bd.gy)) - bd.K * (bc.gx * bd.gx + bc.gy * bd.gy);
    if (const auto s = order.sign()) {
        ++kernel_.decisions().by_interval;
        return *s;
    }
    ++kernel_.decisions().by_exact;
    const ExactCurve ec = kernel_.exact_curve(c), ed = kernel_.exact_curve(d);
    const auto g = ec.gradient(kernel_.exact_point(point_)), h = ed.gradient(kernel_.exact_point(point_));
    return sign(ec.K * (h[0] * h[0] + h[1] * h[1]) - ed.K * (g[0] * h[0] + g[1] * h[1]));
}

// Where branch x leaves relative to `from`, counter-clockwise: 0 the same branch, 1 same tangent but bending
// left of it, 2 less than half a turn, 3 opposite, 4 more than half, 5 same tangent but bending right.
int PointStar::sector_of(FormPair from, FormPair x) {
    const Sign turn = kernel_.turn_at(point_, from, x);
    if (turn == Sign::Positive) return 2;
    if (turn == Sign::Negative) return 4;
    if (along_sign(from, x) == Sign::Negative) return 3;
    switch (curvature_order(x, from)) {
        case Sign::Positive: return 1;
        case Sign::Negative: return 5;
        default: return 0;
    }
}

bool PointStar::branch_in_sector(FormPair from, FormPair x, FormPair to) {
    const int sx = sector_of(from, x);
    if (sx == 0) return false;
    int st = sector_of(from, to);
    if (st == 0) return true;  // the sector is the whole turn
    if (sx != st) return sx < st;
    if (sx == 2 || sx == 4) {
        const Sign turn = kernel_.turn_at(point_, x, to);
        if (turn != Sign::Zero) return turn == Sign::Positive;
    }
    return curvature_order(x, to) == Sign::Negative;
}

bool PointStar::sector_contains_left(FormPair from, FormPair to) {
    const Sign turn = kernel_.turn_at(point_, from, to);
    if (turn != Sign::Zero) return turn == Sign::Negative;
    if (along_sign(from, to) == Sign::Positive) return curvature_order(to, from) != Sign::Positive;
    // One goes straight up, the other straight down: the tangent (-B, A) of `from` decides.
    const KernelPoint& q = kernel_.point(point_);
    const FormJet j = kernel_.jet(from, q.x, q.y);
    if (std::abs(j.gx) > gradient_error(j, q.error)) {
        ++kernel_.decisions().by_double;
        return j.gx > 0;
    }
    ++kernel_.decisions().by_exact;
    return sign(kernel_.exact_curve(from).gradient(kernel_.exact_point(point_))[0]) == Sign::Positive;
}

}  // namespace vcell
