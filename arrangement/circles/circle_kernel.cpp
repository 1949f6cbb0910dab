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

// Boxes may be generous. Where the gradient keeps six digits and the ends are eight digits closer known than
// they are apart, angles are good to angle_margin (radians) and lengths to length_margin (relative).
constexpr double angle_margin = 1e-7, length_margin = 1e-6;
}  // namespace

void CircleKernel::reset(const CircularFamily* family) {
    CircleCurves::reset(family);
    points_.clear();
    exact_points_.clear();
    exact_point_index_.clear();
}

// --- First rung --------------------------------------------------------------------------------------

// Newton-Kantorovich for F = (F1, F2) at the double point p, whose Jacobian J changes by exactly
// 2 (K1, K2)^T (q - p)^T between p and q: eta >= |J^-1 F(p)| and omega >= 2 |J^-1 (K1, K2)^T|. J is regular
// as far as the root, so the sign of det J there is its sign at p.
bool CircleKernel::certify(KernelPoint& p) const {
    const FormJet f1 = forms_[p.first.f].jet(p.x, p.y), g1 = forms_[p.first.g].jet(p.x, p.y);
    const FormJet f2 = forms_[p.second.f].jet(p.x, p.y);
    const FormJet g2 = p.second.g == p.first.f   ? f1
                       : p.second.g == p.first.g ? g1
                                                 : forms_[p.second.g].jet(p.x, p.y);
    const FormJet a = f1 - g1, b = f2 - g2;
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
        const KernelForm& f = forms_[id];
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
        const FormJet f1 = jet(c, p.x, p.y), g1 = jet(d, p.x, p.y);
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
    auto exact = vcell::intersection(exact_curve(c), exact_curve(d), orientation);
    if (!exact) return std::nullopt;
    return add_exact_point(c, d, orientation, std::move(*exact));
}

std::array<double, 2> CircleKernel::height(FormId f, PointId p) const {
    const KernelPoint& q = points_[p];
    const FormJet j = forms_[f].jet(q.x, q.y);
    const double slope = std::abs(j.gx) + std::abs(j.gy) + 2 * j.eg + (j.K + j.eK) * q.error;
    return {j.v, (j.ev + slope * q.error) * slop + tiny};
}

Sign CircleKernel::sign_at(PointId p, FormId f, FormId g, FormJet& d) {
    const KernelPoint& q = points_[p];
    d = jet({f, g}, q.x, q.y);
    // |F(true) - F(q)| <= |grad F| r + |K| r^2 on the disk of radius r: the difference's own gradient.
    const double slope = std::abs(d.gx) + std::abs(d.gy) + 2 * d.eg + (std::abs(d.K) + d.eK) * q.error;
    const double bound = (d.ev + slope * q.error) * slop + tiny;
    if (std::abs(d.v) > bound) {
        ++decisions_.by_double;
        return sign_of(d.v);
    }
    // The forms' coefficients as intervals, relative to the point: tighter by the constants only, but it
    // is the exact rung's last chance to be spared.
    const auto value = [&](const KernelForm& h) {
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
    return sign(exact_curve({f, g}).value(exact_point(p)));
}

Sign CircleKernel::turn_at(PointId p, FormPair c, FormPair d) {
    const KernelPoint& q = points_[p];
    if (q.first == c && q.second == d && !(c == d)) return q.orientation;
    const FormJet a = jet(c, q.x, q.y), b = jet(d, q.x, q.y);
    const double det = cross(a.gx, a.gy, b.gx, b.gy);
    if (std::abs(det) > gradient_product_error(a, b, q.error)) {
        ++decisions_.by_double;
        return sign_of(det);
    }
    ++decisions_.by_exact;
    const auto g = exact_curve(c).gradient(exact_point(p));
    const auto h = exact_curve(d).gradient(exact_point(p));
    return sign(g[0] * h[1] - g[1] * h[0]);
}

// Does some line through both points have no slope in that variable, so that they share the other coordinate?
// The coefficients of lines are exact, and so is this answer. Piece and region sides along an axis carry many
// points.
bool CircleKernel::share_line(PointId p, PointId q, double KernelForm::*slope) const {
    const KernelPoint &a = points_[p], &b = points_[q];
    const auto is_on = [&](const KernelPoint& point, FormPair c) {
        return point.first == c || point.second == c || point.first == c.reversed() ||
               point.second == c.reversed();
    };
    return std::ranges::any_of(std::array{a.first, a.second}, [&](FormPair c) {
        return is_line(c.f) && is_line(c.g) && forms_[c.f].*slope == forms_[c.g].*slope && is_on(b, c);
    });
}

// A coordinate of points in doubles and exactly, and the coefficient of it in a line.
struct CoordinateX {
    double in_doubles(const KernelPoint& p) const { return p.x; }
    OneRoot exact(const ExactCirclePoint& p) const { return p.x(); }
    double KernelForm::*slope = &KernelForm::b;  // of the other one
};
struct CoordinateY {
    double in_doubles(const KernelPoint& p) const { return p.y; }
    OneRoot exact(const ExactCirclePoint& p) const { return p.y(); }
    double KernelForm::*slope = &KernelForm::a;
};

template <class Coordinate>
Sign CircleKernel::compare(PointId p, PointId q, Coordinate coordinate) {
    if (p == q) return Sign::Zero;
    const KernelPoint &a = points_[p], &b = points_[q];
    const double d = coordinate.in_doubles(a) - coordinate.in_doubles(b);
    if (std::abs(d) > (a.error + b.error + u * std::abs(d)) * slop) {
        ++decisions_.by_double;
        return sign_of(d);
    }
    if (share_line(p, q, coordinate.slope)) {
        ++decisions_.by_double;
        return Sign::Zero;
    }
    ++decisions_.by_exact;
    const ExactCirclePoint &e = exact_point(p), &f = exact_point(q);
    return vcell::compare(coordinate.exact(e), e.w, coordinate.exact(f), f.w);
}

Sign CircleKernel::compare_x(PointId p, PointId q) { return compare(p, q, CoordinateX()); }
Sign CircleKernel::compare_y(PointId p, PointId q) { return compare(p, q, CoordinateY()); }

Sign CircleKernel::compare_xy(PointId p, PointId q) {
    const Sign s = compare_x(p, q);
    return s != Sign::Zero ? s : compare_y(p, q);
}

Sign CircleKernel::side_of_center(PointId p, FormPair c) {
    const KernelPoint& q = points_[p];
    const FormJet j = jet(c, q.x, q.y);
    if (std::abs(j.gy) > gradient_error(j, q.error) + tiny && std::abs(j.K) > j.eK) {
        ++decisions_.by_double;
        return sign_of(j.gy) * sign_of(j.K);
    }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c);
    return sign(e.gradient(exact_point(p))[1]) * e.K.sign();
}

// --- Relations of two curves ---------------------------------------------------------------------------

Sign CircleKernel::intersection_sign(FormPair c, FormPair d, const Eigen::Vector2d& near) {
    if (certified_intersection(c, d, Sign::Positive, near) ||
        certified_intersection(c, d, Sign::Negative, near)) {
        ++decisions_.by_double;
        return Sign::Positive;
    }
    // The discriminant about `near`, where the coefficients are small: D^2 - 4 Z as above, in intervals.
    const FormJet f = jet(c, near.x(), near.y()), g = jet(d, near.x(), near.y());
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
    if (ec.is_line() && ed.is_line())
        return (ec.A * ed.B - ec.B * ed.A).sign() == Sign::Zero ? Sign::Negative : Sign::Positive;
    if ((ed.K * ec.A - ec.K * ed.A).sign() == Sign::Zero && (ed.K * ec.B - ec.K * ed.B).sign() == Sign::Zero)
        return Sign::Negative;
    return discriminant(ec, ed).sign();
}

// --- Points in exact numbers, and boxes of arcs --------------------------------------------------------

PointId CircleKernel::add_exact_point(FormPair c, FormPair d, Sign orientation, ExactCirclePoint exact) {
    const Interval x = enclosure(exact.x(), exact.w);
    const Interval y = enclosure(exact.y(), exact.w);
    const double error = std::hypot(x.radius(), y.radius()) * 1.5 + tiny;
    const PointId p = points_.push_back({x.mid(), y.mid(), error, c, d, orientation});
    exact_point_index_.resize(points_.size(), -1);
    exact_point_index_[p.value] = static_cast<std::int32_t>(exact_points_.size());
    exact_points_.push_back(std::move(exact));
    return p;
}

PointId CircleKernel::touching_point(FormPair c, FormPair d) {
    auto exact = vcell::intersection(exact_curve(c), exact_curve(d), Sign::Zero);
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
    return add_exact_point(c, c, which, exact_curve(c).own_point(which));
}

ExactCirclePoint& CircleKernel::exact_point(PointId p) {
    exact_point_index_.resize(points_.size(), -1);
    std::int32_t& slot = exact_point_index_[p.value];
    if (slot < 0) {
        const KernelPoint& q = points_[p];
        ExactCirclePoint exact =
            q.first == q.second
                ? exact_curve(q.first).own_point(q.orientation)
                : vcell::intersection(exact_curve(q.first), exact_curve(q.second), q.orientation).value();
        slot = static_cast<std::int32_t>(exact_points_.size());
        exact_points_.push_back(std::move(exact));
    }
    return exact_points_[static_cast<std::size_t>(slot)];
}

// An arc whose chord makes an angle theta < 90 degrees with the tangent at p stays within the sagitta
// |chord| / 2 tan(theta / 2) of its chord. Longer arcs get their circle's box. A box may be generous: where
// the gradient keeps enough digits in plain arithmetic, a relative margin of 1e-6 covers every rounding.
CircleKernel::ArcBounds CircleKernel::arc_bounds(FormPair c, PointId p, PointId q) const {
    const KernelPoint &P = points_[p], &Q = points_[q];
    const KernelForm &f = forms_[c.f], &h = forms_[c.g];
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

}  // namespace vcell
