/// The equations of an arc of a trisector in space, and its spans as polynomials, for the fit and the
/// certificate of spline_fit.hpp.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>

#include "../../core/curves/quintic_nodes.hpp"
#include "../../core/curves/scaled_bernstein.hpp"
#include "../../core/numbers/interval.hpp"
#include "../charts/chart.hpp"
#include "../forms/twin_quadric.hpp"
#include "../objects/objects.hpp"

namespace vcell::space_fit {

using Eigen::Matrix4d;
using Eigen::Vector4d;
using std::numbers::sqrt2;

using Linear = Eigen::Matrix<double, 5, 1>;  // a function of (x, y, z, t, 1)

// Of a Bezier span of degree 5, polynomial: point k of the curve (x, y, z, t) and below it of what follows it
// in the same parameter, a trim (u, v) on the left and one on the right, is column k.
using Points = Eigen::Matrix<double, 8, 6>;

using roundoff::u;

// Rounding of a residual or gradient, in units of u times the magnitudes that enter it: some thirty
// operations, and coefficients within a few u.
constexpr double rounding = 64 * u;

inline double square(double a) { return a * a; }

inline Bernstein<5> row(const Points& points, int i, double origin = 0) {
    return Bernstein<5>::from([&](int k) { return points(i, k) - origin; });
}

inline double at(const Linear& f, const Vector4d& X) { return f.head<4>().dot(X) + f[4]; }

// The point of a span's curve (p, t) at a parameter.
inline Vector4d point(const Points& p, double s) {
    Eigen::Matrix<double, 4, 6> q = p.topRows<4>();
    for (int n = 5; n > 0; --n)
        for (int k = 0; k < n; ++k) q.col(k) += s * (q.col(k + 1) - q.col(k));
    return q.col(0);
}

template <class T>
T dot(const Vec3& a, const std::array<T, 3>& b) {
    return a.x() * b[0] + a.y() * b[1] + a.z() * b[2];
}

// A span's coordinates (p - foot, t) as polynomials, and |p - foot|^2 - t^2, which all round objects share.
struct SpanPolynomials {
    Vec3 foot;
    std::array<Bernstein<5>, 4> X;
    Bernstein<10> square;
    std::array<double, 4> largest;

    SpanPolynomials(const Points& points, const Vec3& origin)
        : foot(origin),
          X{row(points, 0, foot.x()), row(points, 1, foot.y()), row(points, 2, foot.z()), row(points, 3)},
          square(vcell::square(X[0]) + vcell::square(X[1]) + vcell::square(X[2]) - vcell::square(X[3])) {
        for (int i = 0; i < 4; ++i) largest[i] = X[i].largest();
    }

    // f.(p - foot, t) + c
    Bernstein<5> linear(const Vec3& f, double along_t, double c) const {
        return f.x() * X[0] + f.y() * X[1] + f.z() * X[2] + along_t * X[3] + c;
    }
    Bernstein<5> operator()(const Linear& f) const {
        return linear(f.head<3>(), f[3], f[4] + f.head<3>().dot(foot));
    }
    // Bounds the terms of a linear function.
    double size(const Linear& f) const {
        double sum = std::abs(f[4]) + std::abs(f[3]) * largest[3];
        for (int i = 0; i < 3; ++i) sum += std::abs(f[i]) * (largest[i] + std::abs(foot[i]));
        return sum;
    }
    double size() const { return largest[0] + largest[1] + largest[2] + largest[3]; }
};

// A quadric without mixed terms in axes of its own, the rows, about a center, along a span, whose coordinates
// are no larger than `sizes` there.
Bernstein<10> along_span(const SpaceQuadric& quadric, const Eigen::Matrix3d& axes, const Vec3& center,
                         const SpanPolynomials& span, Vector4d& sizes);

// G(X) and its derivatives: of a round object (the base too), of something plane, or any quadric.
class Equation {
public:
    // The distance from a point or an axis is rho + kappa r, r = t - R0: kappa = -1 where one of the object
    // and the base lies within the other. `near`: a point of an axis near it is taken.
    static Equation round(const Vec3& point, const Vec3& axis, double rho, double base_radius,
                          const Vec3& near, double kappa = 1) {
        Equation e;
        e.is_round_ = true;
        e.kappa_ = kappa;
        e.delta_ = rho - kappa * base_radius;
        e.point_ = point;
        e.reach_ = point.norm() + (near - point).norm() + rho + base_radius;
        if (axis != Vec3::Zero()) {
            e.axis_ = axis.normalized();
            e.point_ += e.axis_.dot(near - point) * e.axis_;
            e.reach_ += e.point_.norm();
        }
        return e;
    }
    // A hollow cone, S and K the sine and cosine of half its angle: K times the distance from its axis is
    // S w.(p - apex) - r.
    static Equation in_cone(const HollowCone& cone, double base_radius, const Vec3& near) {
        Equation e;
        e.is_round_ = true;
        e.kappa_ = e.sense_ = -1;
        e.delta_ = base_radius;
        e.point_ = cone.apex;
        e.axis_ = cone.axis.normalized();
        e.spread_ = cone.cosine();
        e.sine_ = cone.sine();
        e.lean_ = e.sine_ * e.axis_;
        e.reach_ = 2 * cone.apex.norm() + (near - cone.apex).norm() + base_radius;
        return e;
    }
    // G with the other sign, as a vessel's distance falls from its centre or axis on.
    Equation turned() const {
        Equation e = *this;
        e.sense_ = -sense_;
        return e;
    }
    // One of the planes where two lines that cross in `center` are equally near. blur: bound on what rounding
    // changed about `normal`, and about the center in lengths of what enters G.
    static Equation between(const Vec3& center, const Vec3& normal, double blur) {
        Equation e = plane(center, normal, 0, 0);
        e.blur_ = blur;
        return e;
    }
    // The distance along `gradient` (unit) from a point, less kappa (t - R0): 0 of a wall, -1 where the base
    // is seen from within.
    static Equation plane(const Vec3& point, const Vec3& gradient, double base_radius, double kappa = 1) {
        Equation e;
        e.point_ = point;
        e.axis_ = gradient;
        e.kappa_ = kappa;
        e.delta_ = -e.kappa_ * base_radius;
        e.reach_ = point.norm() + base_radius;
        return e;
    }

    // A quadric of (p - center, t) that the arc lies on, over the length of its gradient at `near`.
    static Equation quadric(const SpaceQuadric& quadric, const Vector4d& near,
                            const Vec3& center = Vec3::Zero()) {
        Equation e;
        e.set_quadric(quadric, near, center);
        return e;
    }
    // A ball over a base plane, with z = t: |(x, y) - c|^2 + (c_z - rho) (c_z + rho) = 2 (c_z + rho) t.
    // Unlike distances it tells a ball next to the base from the base.
    static Equation paraboloid(const Vec3& center, double rho, const Vec3& near) {
        const double width = center.z() + rho;
        SpaceQuadric q;
        q.M(0, 0) = q.M(1, 1) = 1;
        q.l[3] = -2 * width;
        q.k = width * (center.z() - rho);
        return quadric(q, {near.x(), near.y(), 0, 0}, {center.x(), center.y(), 0});
    }
    // Tells two round objects apart that are all but the same: with G S = Q, S = d + kappa t + delta, what Q
    // of the right one is less than that of the left one hardly turns. Its numbers are differences of points,
    // axes and radii, and known as these are.
    static Equation difference(const Equation& left, const Equation& right, const Vector4d& near);
    // Are both balls, or tubes, so alike at X that their difference turns much less than either?
    static bool are_alike(const Equation& a, const Equation& b, const Vector4d& X) {
        constexpr double share = 0.125;  // only how fast proofs go depends on this
        if (!a.is_round_ || !b.is_round_ || a.kappa_ != b.kappa_ || a.sine_ + b.sine_ > 0) return false;
        if ((a.axis_ == Vec3::Zero()) != (b.axis_ == Vec3::Zero())) return false;
        const double da = a.from_axis(X).norm(), db = b.from_axis(X).norm();
        return turn(a, b, X) < share * (1 / da + 1 / db);
    }

    // The needle (arc_equations.cpp) between the two, if there is one and X sees both in one direction.
    static std::optional<Equation> needle(const Equation& base, const Equation& site, const Vector4d& X);
    bool is_needle() const { return is_needle_; }
    // |c|^2 - delta^2 of a ball around a ball, where it is better known than its centre.
    void set_power(double power) { power_ = power; }

    // What tells, beside the base's equation, where the site is as far as the base. Equations of what is all
    // but alike at X depend on each other so nearly that each alone would be told from the other on the
    // shortest of spans only: their difference takes the site's place, or their needle.
    static Equation beside(const Equation& base, const Equation& site, const Vector4d& X) {
        if (are_alike(base, site, X)) return difference(base, site, X);
        return needle(base, site, X).value_or(site);
    }

    double operator()(const Vector4d& X) const {
        if (quadric_) {
            const Vector4d Y = from_center(X);
            return scale_ * (Y.dot(quadric_->M * Y + quadric_->l) + quadric_->k);
        }
        const Vec3 m = X.head<3>() - point_;
        const double distance = is_round_ ? spread_ * across(m).norm() - lean_.dot(m) : axis_.dot(m);
        return sense_ * (distance - (kappa_ * X[3] + delta_));
    }
    // The lengths that enter G at X.
    double size(const Vector4d& X) const {
        if (quadric_) return terms(from_center(X).cwiseAbs());
        return X.head<3>().norm() + std::abs(X[3]) + reach_;
    }

    // (g, -kappa)
    Vector4d gradient(const Vector4d& X) const {
        Vector4d result;
        if (quadric_) {
            result = scale_ * (2 * (quadric_->M * from_center(X)) + quadric_->l);
            if (is_needle_) result.head<3>() = turn_.transpose() * result.head<3>();
            return result;
        }
        const Vec3 g = is_round_ ? Vec3(spread_ * across(X.head<3>() - point_).normalized() - lean_) : axis_;
        result << g, -kappa_;
        return sense_ * result;
    }
    // How fast G falls along the normal of a base plane where it is linear in z or in t, and in that alone;
    // else 0.
    double fall() const {
        if (quadric_) return quadric_->M.bottomRows<2>().isZero() ? -scale_ * quadric_->l[3] : 0;
        return is_round_ || kappa_ != 0 ? 0 : -axis_.z();
    }
    // How far what is within `room` of the hull of the points is from X, across the axis, if there is one;
    // where a quadric bends, as far as it bends.
    double reach(const Vector4d& X, const Points& points, double room) const {
        if (quadric_ ? bend_ == 0 : !is_round_) return 0;
        double squared = 0;
        for (int k = 0; k < points.cols(); ++k) {
            const Vector4d way = points.col(k).head<4>() - X;
            squared =
                std::max(squared, quadric_ ? (quadric_->M * in_own_axes(way)).squaredNorm() / (bend_ * bend_)
                                           : across(way.head<3>()).squaredNorm());
        }
        return std::sqrt(squared) + room;
    }
    // How far the gradient may be from its computed value at X, within a reach.
    double variation(const Vector4d& X, double reach) const {
        if (quadric_) {
            const double far = from_center(X).norm() + reach_, numbers = is_rounded_ ? 2 * far : 0;
            return scale_ *
                   (2 * bend_ * (reach + rounding * far) + rounding * (quadric_->l.norm() + numbers));
        }
        if (!is_round_) return rounding + blur_;
        const double d = across(X.head<3>() - point_).norm(), s = reach / d;
        if (!(s < 1)) return infinity;
        return sqrt2 * s / std::sqrt(1 + std::sqrt(1 - s * s)) + rounding * (1 + size(X) / d);
    }
    // Bounds |Hess G| within a reach that is less than what makes variation() infinite.
    double curvature_bound(const Vector4d& X, double reach) const {
        if (quadric_) return 2 * scale_ * bend_;
        return is_round_ ? 1 / (across(X.head<3>() - point_).norm() - reach) : 0;
    }
    // The second derivative in the direction T.
    double second(const Vector4d& X, const Vector4d& T) const {
        if (quadric_) return 2 * scale_ * in_own_axes(T).dot(quadric_->M * in_own_axes(T));
        if (!is_round_) return 0;
        const Vec3 m = across(X.head<3>() - point_), v = across(T.head<3>());
        const double d = m.norm();
        return sense_ * spread_ * (v.squaredNorm() - square(m.dot(v) / d)) / d;
    }

    // Bound of |G|.
    double residual(const Vector4d& X) const { return std::abs((*this)(X)) + (rounding + blur_) * size(X); }
    // Step 1 of the certificate: |G| along a span; infinite if it cannot tell. With m = point - foot
    //     d^2 - (kappa t + delta)^2 = square - 2 m.(p - foot) - 2 kappa delta t + |m|^2 - delta^2
    //                                 (- (axis.(p - point))^2),
    // and in a cone spread^2 d^2 - (lean.(p - point) + kappa t + delta)^2.
    double residual(const SpanPolynomials& span) const {
        if (quadric_) return quadric_residual(span);
        const Vec3 m = point_ - span.foot;
        if (!is_round_)
            return span.linear(axis_, -kappa_, -(axis_.dot(m) + delta_)).largest() +
                   (rounding + blur_) * (span.size() + reach_ + span.foot.norm());
        const double bound = quadric_bound(span);
        return bound / least_sum(span, bound);
    }

    // t where the ray from a foot point f along the unit normal w meets G = 0, by the quadratic of
    // primitives/forms/radial_form.hpp; whatever it yields where the ray does not. Pre: kappa is -1 of a
    // vessel only, and a quadric is a paraboloid.
    template <class T>
    T distance_along(const std::array<T, 3>& f, const std::array<T, 3>& w) const {
        const std::array<T, 3> m = from_point(f);
        if (quadric_) return (square(m[0]) + square(m[1]) + T(quadric_->k)) / T(-quadric_->l[3]);
        if (!is_round_) return (dot(axis_, m) - T(delta_)) / (T(kappa_) - dot(axis_, w));
        const Quadratic<T> q = quadratic(m, w);
        return q.C / (q.beta + q.root());
    }

    double distance_along(const Vec3& f, const Vec3& w) const {
        return distance_along<double>({f.x(), f.y(), f.z()}, {w.x(), w.y(), w.z()});
    }

    // How far the true site's t may be from distance_along(): by what rounding changes about G, over the
    // slope of G along the ray. That is sqrt(beta^2 + alpha^2 C) / (t + delta) of round objects.
    Interval doubt_along(const std::array<Interval, 3>& f, const std::array<Interval, 3>& w,
                         const Interval& t) const {
        const std::array<Interval, 3> m = from_point(f);
        if (quadric_)
            return Interval::ball(0,
                                  rounding * terms({m[0].magnitude(), m[1].magnitude(), 0, t.magnitude()})) /
                   Interval(fall());
        double size = 2 * t.magnitude() + reach_;
        for (const Interval& x : f) size += x.magnitude();
        const Interval change = Interval::ball(0, (rounding + blur_) * size);
        if (!is_round_) return change / (Interval(kappa_) - dot(axis_, w));
        const Interval along_axis =
            kappa_ < 0 ? dot(lean_, m) + Interval(delta_) - t * (Interval(1.0) - dot(lean_, w))
                       : t + Interval(delta_);
        return change * along_axis / quadratic(m, w).root();
    }

private:
    // How fast the difference of the unit vectors of two balls or two tubes turns at X, per length, at most.
    // As in scene_motion.cpp: a unit vector's derivative is the projection across it, or on what is across it
    // and the axis, over the distance. Half of the lesser distance away from X both are h off; the ways from
    // centres or axes differ there by b = apart + tilt h at most, the projections by tilt + b / h, and the
    // distances' reciprocals by b / h^2.
    static double turn(const Equation& left, const Equation& right, const Vector4d& X) {
        const Vec3 a = left.from_axis(X), b = right.from_axis(X);
        const double h = 0.5 * std::min(a.norm(), b.norm());
        const double tilt = std::min((left.axis_ - right.axis_).norm(), (left.axis_ + right.axis_).norm()) +
                            rounding,
                     apart = (b - a).norm() + rounding * (left.size(X) + right.size(X));
        return (tilt + 2 * (apart + tilt * h) / h) / h;
    }

    void set_quadric(const SpaceQuadric& quadric, const Vector4d& near, const Vec3& center) {
        quadric_ = std::make_shared<const SpaceQuadric>(quadric);
        point_ = center;
        reach_ = center.norm();
        bend_ = std::min(quadric.M.norm(), quadric.M.cwiseAbs().rowwise().sum().maxCoeff());
        scale_ = 1;
        scale_ = 1 / gradient(near).norm();
    }
    Vector4d from_center(const Vector4d& X) const {
        return in_own_axes({X[0] - point_.x(), X[1] - point_.y(), X[2] - point_.z(), X[3]});
    }
    Vector4d in_own_axes(const Vector4d& way) const {
        if (!is_needle_) return way;
        Vector4d turned;
        turned << turn_ * way.head<3>(), way[3];
        return turned;
    }
    // The sum of the absolute values of a quadric's terms, where those of (p - center, t) are these or less,
    // and what rounding of the center adds. Where the numbers are rounded it is what they are of two objects
    // at the distance t + delta: what moves these counts twice that distance.
    double terms(const Vector4d& sizes) const {
        const Vector4d slopes = quadric_->M.cwiseAbs() * sizes;
        const double moved = is_rounded_ ? 2 * (sizes[3] + delta_) * (sizes.sum() + reach_)
                                         : (2 * slopes.sum() + bend_ * rounding * reach_) * reach_;
        return scale_ * (sizes.dot(slopes + quadric_->l.cwiseAbs()) + std::abs(quadric_->k) + moved);
    }
    double quadric_residual(const SpanPolynomials& span) const {
        if (is_needle_) {
            Vector4d sizes;
            const Bernstein<10> Q = along_span(*quadric_, turn_, point_, span, sizes);
            return scale_ * QuinticNodes::get().largest(Q) + rounding * terms(sizes);
        }
        const Matrix4d& M = quadric_->M;
        Vector4d foot = Vector4d::Zero(), sizes;
        foot.head<3>() = span.foot - point_;
        const Vector4d slope = 2 * (M * foot) + quadric_->l;
        Bernstein<10> Q = raised<10>(
            span.linear(slope.head<3>(), slope[3], foot.dot(M * foot + quadric_->l) + quadric_->k));
        for (int i = 0; i < 4; ++i) {
            sizes[i] = span.largest[i] + std::abs(foot[i]);
            Q = Q + M(i, i) * vcell::square(span.X[i]);
            for (int j = 0; j < i; ++j) Q = Q + 2 * M(i, j) * (span.X[i] * span.X[j]);
        }
        return scale_ * QuinticNodes::get().largest(Q) + rounding * terms(sizes);
    }

    // Bounds |d^2 - (kappa t + delta)^2| along a span. What rounding has changed about the object, in its
    // reach, counts times the distance from it, which may be far less, as all terms are about the span's
    // foot.
    double quadric_bound(const SpanPolynomials& span) const {
        const Vec3 m = point_ - span.foot;
        const double size = span.size() + m.norm() + std::abs(delta_);
        if (sine_ > 0) {
            const Bernstein<10> squared = vcell::square(span.X[0]) + vcell::square(span.X[1]) +
                                          vcell::square(span.X[2]) +
                                          raised<10>(span.linear(-2 * m, 0, m.squaredNorm()));
            const Bernstein<10> Q =
                square(spread_) * (squared - vcell::square(span.linear(axis_, 0, -axis_.dot(m)))) -
                vcell::square(span.linear(lean_, kappa_, delta_ - lean_.dot(m)));
            return QuinticNodes::get().largest(Q) + rounding * size * std::max(size, reach_);
        }
        Bernstein<10> Q = span.square + raised<10>(span.linear(-2 * m, -2 * kappa_ * delta_,
                                                               m.squaredNorm() - square(delta_)));
        if (axis_ != Vec3::Zero()) Q = Q - vcell::square(span.linear(axis_, 0, -axis_.dot(m)));
        return QuinticNodes::get().largest(Q) + rounding * size * std::max(size, reach_);
    }
    // Bounds d + kappa t + delta from below where d^2 is within `bound` of (kappa t + delta)^2; 0 if it
    // cannot tell.
    double least_sum(const SpanPolynomials& span, double bound) const {
        const double least = sine_ > 0
                                 ? span.linear(lean_, kappa_, delta_ - lean_.dot(point_ - span.foot))
                                       .smallest_coefficient()
                                 : (kappa_ > 0 ? span.X[3].smallest_coefficient() : -span.X[3].largest()) +
                                       delta_,
                     below = least * least - bound;
        return least > 0 && below > 0 ? least + std::sqrt(below) : 0;
    }
    Vec3 from_axis(const Vector4d& X) const { return across(X.head<3>() - point_); }

    // C q^2 - 2 beta q - alpha2 = 0, q = 1 / t; alpha2 is less than 0 in a vessel.
    template <class T>
    struct Quadratic {
        T C, beta, alpha2;

        T root() const {
            using std::sqrt;
            return sqrt(square(beta) + alpha2 * C);
        }
    };
    template <class T>
    Quadratic<T> quadratic(const std::array<T, 3>& m, const std::array<T, 3>& w) const {
        const T along = dot(axis_, m), alpha = dot(axis_, w), delta(delta_);
        // From the axis, which may be far nearer than its point.
        const T x = m[0] - axis_[0] * along, y = m[1] - axis_[1] * along, z = m[2] - axis_[2] * along,
                squared = square(x) + square(y) + square(z), turned = x * w[0] + y * w[1] + z * w[2];
        if (kappa_ < 0) {  // a tube's wall is a cone's with no sine
            const T P = dot(lean_, m) + delta, part = T(square(spread_)), off = alpha - T(sine_);
            return {square(P) - part * squared, P * (T(1.0) - dot(lean_, w)) + part * turned, -square(off)};
        }
        return {squared - square(delta), delta - turned, square(alpha)};
    }
    template <class T>
    std::array<T, 3> from_point(const std::array<T, 3>& f) const {
        return {f[0] - T(point_.x()), f[1] - T(point_.y()), f[2] - T(point_.z())};
    }
    Vec3 across(const Vec3& m) const { return m - axis_.dot(m) * axis_; }

    bool is_round_ = false, is_rounded_ = false, is_needle_ = false;  // is_rounded_: a quadric's numbers are
    double kappa_ = 1, sense_ = 1;
    double delta_ = 0;
    double reach_ = 0;
    double blur_ = 0;
    std::optional<double> power_;
    double spread_ = 1, sine_ = 0;                     // of cones
    Vec3 lean_ = Vec3::Zero();                         // likewise
    double scale_ = 0, bend_ = 0;                      // of a quadric; at least |M|
    Eigen::Matrix3d turn_ = Eigen::Matrix3d::Zero();   // its own axes, of a needle
    Vec3 point_ = Vec3::Zero(), axis_ = Vec3::Zero();  // plane: axis_ is g
    std::shared_ptr<const SpaceQuadric> quadric_;      // which has a center, a reach and a scale only
};

// The gradients of an arc's equations at a point, and its direction there.
struct Frame {
    std::array<Vector4d, 3> gradients;
    Vector4d T;  // null vector in the edge's direction; |T| = 1

    Matrix4d matrix() const {
        Matrix4d M;
        M << gradients[0].transpose(), gradients[1].transpose(), gradients[2].transpose(), T.transpose();
        return M;
    }
};

// A point of the arc with derivatives along it, by the length of the curve (p, t).
struct Node {
    Vector4d X, T, second;
    bool is_terminal = false;  // the end of the arc
    bool ends_piece = false;   // of its guide, or all but does
};

// The equations of the base, of the left and of the right site.
struct ArcEquations {
    std::array<Equation, 3>
        equations;                  // of the base and of both bisectors; or what takes the right one's place
    std::array<Equation, 2> sites;  // their own, which tell distances along rays
    std::array<Equation, 2> bisectors;  // what tells each of them beside the base's
    // Does a plane through the arc, or the difference of the sites, stand for the right one's?
    bool is_replaced = false;
    bool has_difference = false;
    bool has_needle = false;

    const Equation& operator[](int i) const { return equations[i]; }

    void set(const Equation& base, const Equation& left, const Equation& right) {
        sites = bisectors = {left, right};
        equations = {base, left, right};
    }
    void replace_right(const Equation& by) {
        is_replaced = true;
        equations[2] = by;
    }

    void tell_from_base(const Vector4d& X) {
        for (int i = 0; i < 2; ++i) bisectors[i] = Equation::beside(equations[0], sites[i], X);
        has_needle = bisectors[0].is_needle() || bisectors[1].is_needle();
        equations[1] = bisectors[0];
        if (!is_replaced) equations[2] = bisectors[1];
    }
    // The difference of sites that are all but alike takes the right one's place.
    void tell_apart(const Vector4d& X) {
        if (is_replaced || !Equation::are_alike(sites[0], sites[1], X)) return;
        replace_right(Equation::difference(sites[0], sites[1], X));
        has_difference = true;
    }
    // Twins' quadric tells them apart to a part of their difference.
    void tell_apart(const SpaceQuadric& twins, const Vector4d& X) {
        replace_right(Equation::quadric(twins, X));
        has_difference = true;
    }

    Frame frame(const Vector4d& X) const {
        Frame f;
        for (int i = 0; i < 3; ++i) f.gradients[i] = equations[i].gradient(X);
        const Vec3 g = f.gradients[0].head<3>();
        const auto relative = [&](const Vector4d& a) -> Vec3 { return a.head<3>() + a[3] * g; };
        const Vec3 p = relative(f.gradients[1]).cross(relative(f.gradients[2]));
        f.T << p, g.dot(p);
        f.T.normalize();
        return f;
    }

    Node node(const Vector4d& X) const {
        const Frame f = frame(X);
        Vector4d bend = Vector4d::Zero();
        for (int i = 0; i < 3; ++i) bend[i] = -equations[i].second(X, f.T);
        return {X, f.T, f.matrix().inverse() * bend};
    }

    // Newton's method across the curve (or for its point where `seam` vanishes), to the level of rounding.
    std::optional<Node> find(Vector4d X, const Linear* seam = nullptr) const {
        constexpr int enough = 12;
        for (int i = 0; i < enough; ++i) {
            Vector4d G = Vector4d::Zero();
            double size = 0;
            for (int k = 0; k < 3; ++k) {
                G[k] = equations[k](X);
                size = std::max(size, equations[k].size(X));
            }
            Matrix4d M = frame(X).matrix();
            if (seam) {
                M.row(3) = seam->head<4>().normalized();
                G[3] = at(*seam, X) / seam->head<4>().norm();
            }
            const Matrix4d inverse = M.inverse();
            const Vector4d step = inverse * G;
            X -= step;
            if (step.norm() <= 16 * u * size * (1 + inverse.leftCols<3>().norm())) return node(X);
        }
        return std::nullopt;
    }
};

/// The base's. Pre: `foot` is a foot point near the curve.
Equation base_equation(const BaseChart& chart, const Vec3& foot);
/// Of an object, or of a wall: a Plane with outward normal that bounds the cell.
Equation site_equation(const BaseChart& chart, const Object& site, bool is_wall, const Vec3& foot);

}  // namespace vcell::space_fit
