#include "sphere_chart.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace vcell {

double nearness_of(const Nearness::Cylindrical& f, const Vec3& u) {
    const double beta = f.foot.dot(u) + f.delta, alpha = f.axis.dot(u) - f.sine;
    if (f.is_hollow) return (beta + std::sqrt(std::max(0.0, beta * beta - f.C * alpha * alpha))) / f.C;
    const double root = std::sqrt(std::max(0.0, beta * beta + f.C * alpha * alpha));
    return beta >= 0 ? (beta + root) / f.C : alpha * alpha / (root - beta);
}

namespace {

// A bound on |grad Q|: beta changes by |foot| at most, the root, a norm of (beta, sqrt(C) alpha), by
// |foot| + sqrt(C). Of a hollow one's root the square is a quadratic form of u that nowhere is negative: the
// root changes by the largest of its coefficients' roots, |foot| + delta, at most. With radial_form.hpp's
// letters a cone's root is K |M y|, y = P u' + (1 - S u.w) m', for a matrix M that makes nothing longer, as
//
//     B^2 - C A^2 = K^2 (|y|^2 - (K / P)^2 |m' x y|^2)   and   K |m'| < P:
//
// it changes by K (P + S |m'|) < P + P at most, while `foot` is K^2 m' - P S w.
double slope(const Nearness::Cylindrical& f) {
    if (f.sine > 0) return (f.foot.norm() + 2 * f.delta) / f.C;
    const bool has_tips = f.is_hollow || f.C < 0;
    return (2 * f.foot.norm() + (has_tips ? std::abs(f.delta) : std::sqrt(f.C))) / std::abs(f.C);
}

// Less room than this is not told from rounding errors.
constexpr double narrow = 0x1p-20;

// The disk about pole u in which its nearest object stays the nearest, by the tangent of half its angular
// radius: all of the diagram's edges lie within 1 / radius of the chart's origin.
class PoleJudge {
public:
    explicit PoleJudge(const Nearness& n) : n_(n) {}

    double radius(const Vec3& u) const {
        double best = -infinity;
        std::size_t linear = n_.linear.size(), cylindrical = n_.cylindrical.size();
        for (std::size_t i = 0; i < n_.linear.size(); ++i)
            if (const double q = n_.linear[i].p.dot(u) + n_.linear[i].s; q > best) {
                best = q;
                linear = i;
            }
        for (std::size_t i = 0; i < n_.cylindrical.size(); ++i)
            if (const double q = nearness_of(n_.cylindrical[i], u); q > best) {
                best = q;
                cylindrical = i;
            }
        double room = infinity;
        if (cylindrical < n_.cylindrical.size()) {
            // The slopes bound how soon another object catches up: tan(phi / 2) >= phi / 2.
            const double own = slope(n_.cylindrical[cylindrical]);
            for (const auto& f : n_.linear)
                room = std::min(room, 0.5 * (best - f.p.dot(u) - f.s) / (own + f.p.norm()));
            for (std::size_t i = 0; i < n_.cylindrical.size(); ++i) {
                if (i == cylindrical) continue;
                double beside = room_beside(best, own, n_.cylindrical[i], u);
                if (beside < narrow)
                    beside =
                        std::max(beside, room_beside_twin(n_.cylindrical[cylindrical], n_.cylindrical[i], u));
                room = std::min(room, beside);
            }
            return room;
        }
        const auto& own = n_.linear[linear];
        for (std::size_t i = 0; i < n_.linear.size(); ++i)
            if (i != linear) room = std::min(room, room_beside(own, n_.linear[i], u, room));
        for (const auto& f : n_.cylindrical) room = std::min(room, room_beside(best, own.p.norm(), f, u));
        return room;
    }

private:
    // With v = p - p', e = s - s' the difference v.u + e at angle phi from u is, in the worst direction,
    // e + (v.u) cos phi - |v x u| sin phi; in r = tan(phi / 2), times 1 + r^2,
    //     (e - v.u) r^2 - 2 |v x u| r + (e + v.u),
    // with discriminant |v|^2 - e^2. The first positive root, which is larger than half of (v.u + e) / |v|.
    static double room_beside(const Nearness::Linear& own, const Nearness::Linear& other, const Vec3& u,
                              double enough) {
        const Vec3 v = own.p - other.p;
        const double e = own.s - other.s, along = v.dot(u), lead = along + e, v2 = v.squaredNorm();
        if (!(lead > 0)) return 0;
        if (lead * lead >= 4 * enough * enough * v2) return enough;
        const double discriminant = v2 - e * e;
        if (discriminant < 0) return infinity;
        return lead / (std::sqrt(std::max(0.0, v2 - along * along)) + std::sqrt(discriminant));
    }

    // Beside a cylinder, where the nearest object's Q is `best` and changes by no more than `own`. What all
    // but touches the base is steep in a few directions, but as Q is the positive root of
    //
    //     C Q^2 - 2 beta Q - alpha^2 = 0
    //
    // it is below `best` where `best` makes this positive, which changes but moderately.
    static double room_beside(double best, double own, const Nearness::Cylindrical& f, const Vec3& u) {
        const double by_slopes = 0.5 * (best - nearness_of(f, u)) / (own + slope(f));
        if (by_slopes >= narrow || f.is_hollow || f.C < 0 || !(best > 0)) return by_slopes;
        const double beta = f.foot.dot(u) + f.delta, alpha = f.axis.dot(u), foot = f.foot.norm(),
                     value = best * (f.C * best - 2 * beta) - alpha * alpha,
                     change = 2 * (foot * best + 1 + (f.C * best + foot + std::abs(f.delta)) * own);
        return std::max(by_slopes, 0.5 * value / change);
    }

    // Where two cylinders or cones all but coincide so do their slopes. Q is larger where the other one's Q'
    // makes its equation above negative, r = dC Q'^2 - 2 dbeta Q' - d(alpha^2), + d(alpha^2) of hollow ones;
    // and r changes by no more than what its differences, Q' and the slope of Q' do.
    static double room_beside_twin(const Nearness::Cylindrical& own, const Nearness::Cylindrical& other,
                                   const Vec3& u) {
        if (own.is_hollow != other.is_hollow || own.C < 0 || other.C < 0) return 0;
        const bool is_turned = own.sine == 0 && own.axis.dot(other.axis) < 0;
        const Vec3 axis = is_turned ? Vec3(-other.axis) : other.axis;
        const Vec3 d_axis = own.axis - axis, d_foot = own.foot - other.foot;
        const double dC = own.C - other.C, d_delta = own.delta - other.delta, d_sine = own.sine - other.sine,
                     q = nearness_of(other, u);
        const double d_square =
            (d_axis.dot(u) - d_sine) * ((own.axis + axis).dot(u) - (own.sine + other.sine));
        const double r =
            dC * q * q - 2 * (d_foot.dot(u) + d_delta) * q + (own.is_hollow ? d_square : -d_square);
        if (!(r < 0)) return 0;
        const double steepness = slope(other), beta = other.foot.norm() + std::abs(other.delta),
                     root = other.is_hollow ? beta : std::sqrt(beta * beta + other.C),
                     most = (beta + root) / other.C;
        const double change = 2 * (std::abs(dC) * most * steepness + d_foot.norm() * most +
                                   (d_foot.norm() + std::abs(d_delta)) * steepness +
                                   (2 + std::max(own.sine, other.sine)) * d_axis.norm() + std::abs(d_sine));
        return -0.5 * r / change;
    }

    const Nearness& n_;
};

// The direction in which some object comes nearest of all. That object, nearest of all there, owns it:
// elsewhere the others are farther still.
Vec3 nearest_direction(const Nearness& n) {
    double best = -infinity;
    Vec3 direction = Vec3::UnitZ();
    for (const auto& f : n.linear) {
        const double length = f.p.norm();
        if (!(length + f.s > best)) continue;
        best = length + f.s;
        direction = length > 0 ? Vec3(f.p / length) : Vec3(Vec3::UnitZ());
    }
    // A cylinder comes nearest where its axis does, at (|foot| - delta) / 2.
    for (const auto& f : n.cylindrical) {
        if (f.sine > 0) {
            // A cone does opposite to the normal of its wall there.
            const Vec3 out = f.foot - f.axis * f.axis.dot(f.foot);
            const double cosine = std::sqrt((1 - f.sine) * (1 + f.sine)), length = out.norm();
            const Vec3 u =
                (length > 0 ? Vec3(out / length) : Vec3(f.axis.unitOrthogonal())) * cosine - f.sine * f.axis;
            // Next to the axis `out` is rounded to any direction.
            if (const double q = nearness_of(f, u); q > best) {
                best = q;
                direction = u.normalized();
            }
            continue;
        }
        // If it pierces the base, in a tip.
        const double length = f.foot.norm(), q = f.C < 0 ? -1 / f.delta : 2 / std::abs(length - f.delta);
        if (!(q > best)) continue;
        best = q;
        if (f.C < 0) {
            direction = (f.foot + std::sqrt(-f.C) * f.axis).normalized();
            continue;
        }
        // From a point of the axis it does so all around.
        direction = length > 0 ? Vec3(f.foot / length) : Vec3(f.axis.unitOrthogonal());
    }
    return direction;
}

// Room enough: edges within 16 of the origin.
constexpr double wide = 1.0 / 16;

struct Pole {
    Vec3 direction;
    double room;
};

// Pattern search: five directions a step away, half the step when none of them is better. Steps that are not
// larger than the room gain little more.
Pole widened(const PoleJudge& judge, const Vec3& start) {
    Pole pole{start, judge.radius(start)};
    int trials = 0;
    // Next to an edge the room tells nothing of how far to look. Any step is right, some are quicker.
    constexpr double telling = 1e-3;  // on the unit sphere
    for (double step = pole.room > telling ? 4 * pole.room : 0.5;
         pole.room < wide && step > pole.room && step > narrow;) {
        Eigen::Index least = 0;
        pole.direction.cwiseAbs().minCoeff(&least);
        const Vec3 e1 = Vec3::Unit(least).cross(pole.direction).normalized(), e2 = pole.direction.cross(e1);
        Pole best = pole;
        for (int k = 0; k < 5; ++k) {
            // Turned a little every time: a symmetrical scene has edges in special directions.
            const double angle = 2 * std::numbers::pi * k / 5 + ++trials;
            const Vec3 trial =
                (pole.direction + step * (std::cos(angle) * e1 + std::sin(angle) * e2)).normalized();
            if (const double room = judge.radius(trial); room > best.room) best = {trial, room};
        }
        if (!(best.room > 1.25 * pole.room)) step /= 2;
        pole = best;
    }
    return pole;
}

Pole widest_pole(const Nearness& nearness) {
    const PoleJudge judge(nearness);
    Pole best = widened(judge, nearest_direction(nearness));
    // Where the nearest objects are all but equal over a whole cap of directions, look elsewhere: on a spiral
    // around the sphere, by the golden angle.
    constexpr int starts = 32;
    for (int k = 0; best.room <= narrow && k < starts; ++k) {
        const double z = (2 * k + 1.0) / starts - 1, r = std::sqrt(1 - z * z);
        const double angle = 2 * std::numbers::pi * std::numbers::phi * k;
        const Pole pole = widened(judge, Vec3(r * std::cos(angle), r * std::sin(angle), z));
        if (pole.room > best.room) best = pole;
    }
    return best;
}

// The rotation of an integer quaternion (w, x, y, z), times its squared norm.
IntegerRotation rotation(const Eigen::Vector4d& q) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    IntegerRotation r;
    r.matrix << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),  //
        2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),          //
        2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
    r.norm = q.squaredNorm();
    return r;
}

IntegerRotation reduced(IntegerRotation r) {
    auto common = static_cast<long long>(r.norm);
    for (const double entry : r.matrix.reshaped()) {
        if (common == 1) return r;
        common = std::gcd(common, static_cast<long long>(entry));
    }
    r.matrix /= static_cast<double>(common);
    r.norm /= static_cast<double>(common);
    return r;
}

}  // namespace

std::optional<IntegerRotation> chart_rotation(const Nearness& nearness) {
    const Pole pole = widest_pole(nearness);
    // The pole is the chart's -z axis: turn e_z to t = -pole, about e_z x t when that is less than a right
    // angle, otherwise about the x axis by a half turn first.
    const Vec3 t = -pole.direction;
    const Eigen::Vector4d turn = t.z() >= 0 ? Eigen::Vector4d(1 + t.z(), -t.y(), t.x(), 0)
                                            : Eigen::Vector4d(-t.y(), 1 - t.z(), 0, t.x());
    // The rounded pole may use a quarter of the room. Integers of 25 bits leave products of two in range.
    for (int bits = 1; bits <= 24; ++bits) {
        const Eigen::Vector4d q =
            (turn * (std::ldexp(1.0, bits) / turn.cwiseAbs().maxCoeff())).array().round();
        const IntegerRotation r = rotation(q);
        if ((r.matrix.col(2) / r.norm - t).norm() <= 0.25 * std::min(pole.room, 1.0)) return reduced(r);
    }
    return std::nullopt;
}

}  // namespace vcell
