/// Heights over a sphere base that are linear in the direction u, and their forms in its chart: exact, and in
/// sums of doubles where these suffice.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "../../core/numbers/compensated.hpp"
#include "../charts/sphere_chart.hpp"
#include "radial_objects.hpp"

namespace vcell::sphere_forms {

// f = -(p.u + s) / w
struct LinearHeight {
    ExactVector p;
    Exact s, w;
};

// The base sphere and its chart; u = rotation n / W.
struct SphereFrame {
    Vec3 center;
    double radius;
    IntegerRotation rotation;

    // rotation.matrix^T p
    ExactVector turned(const ExactVector& p) const {
        const auto column = [&](int j) {
            return p.x * rotation.matrix(0, j) + p.y * rotation.matrix(1, j) + p.z * rotation.matrix(2, j);
        };
        return {column(0), column(1), column(2)};
    }

    LinearHeight height(const Ball& ball) const {
        const ExactVector c = ExactVector(Vec3(ball.cx, ball.cy, ball.cz)) - ExactVector(center);
        const Exact delta = Exact(ball.rho) - radius;
        return {c, delta, (dot(c, c) - delta * delta).scaled(-1)};
    }
    LinearHeight height(const HalfSpace& h) const {
        return {ExactVector(Vec3(-h.n)), h.length, h(ExactVector(center)) + Exact(radius) * h.length};
    }
    LinearHeight height(const WorldSide& side) const {
        return {ExactVector(side.normal()), Exact(), side.distance(center)};
    }
    // That of the ball with the radius -R, with all signs turned.
    LinearHeight height(const HollowSphere& vessel) const {
        const ExactVector way = ExactVector(center) - ExactVector(vessel.center);
        const Exact reach = Exact(vessel.radius) + radius;
        return {way, reach, (reach * reach - dot(way, way)).scaled(-1)};
    }
    LinearHeight cap(double probe) const { return {ExactVector(), 1.0, Exact(radius) + probe}; }

    // With P = matrix^T p and N = norm, p.u = (2 P0 x + 2 P1 y + P2 (1 - x^2 - y^2)) / (N W).
    ExactForm form(const LinearHeight& h) const {
        const ExactVector P = turned(h.p);
        const Exact s = rotation.norm * h.s;
        return {P.z - s, -2.0 * P.x, -2.0 * P.y, -(P.z + s), rotation.norm * h.w};
    }

    // C = |c|^2 - delta^2 of cylinder_form.hpp's cylinder, times N^2 to be free of denominators.
    RadialForm form(const CylinderForm& f) const { return form(f, Exact(f.rho) - radius, 1.0); }
    // A vessel is the tube with the radius -rho; C and B are negative then, and turned.
    RadialForm hollow_form(const CylinderForm& f) const {
        RadialForm hollow = form(f, -(Exact(f.rho) + radius), -1.0);
        hollow.is_hollow = true;
        return hollow;
    }

    // radial_form.hpp's equation of a cone, times g^4 N^2 with N of the rotation.
    RadialForm hollow_form(const ConeForm& f) const {
        const ExactVector D = ExactVector(center) - f.apex;
        const ConeForm::Room room = f.room(ExactVector(center), radius);
        const Exact n = rotation.norm, rest = f.g * f.g - f.N, lean = f.g * dot(D, f.a) + f.N * radius;
        const ExactVector b = n * turned(f.N * rest * D - f.g * lean * f.a), a = turned(f.g * f.a);
        RadialForm hollow{{n * n * room.C, Exact(), Exact()},
                          n * n * f.N * f.g * room.P,
                          Exact(),
                          {b.x, b.y, b.z},
                          {a.x, a.y, a.z}};
        hollow.is_hollow = true;
        hollow.a0 = -(n * f.N);
        return hollow;
    }

private:
    RadialForm form(const CylinderForm& f, const Exact& delta, const Exact& side) const {
        const ExactVector p = ExactVector(Vec3(f.px, f.py, f.pz)) - ExactVector(center),
                          a(Vec3(f.ax, f.ay, f.az));
        const Exact length2 = dot(a, a), along = dot(p, a);
        const Exact n = rotation.norm, n2 = n * n;
        const ExactVector b = side * n * turned(length2 * p - along * a), turned_a = turned(a);
        return {{side * n2 * (length2 * (dot(p, p) - delta * delta) - along * along), Exact(), Exact()},
                side * n2 * length2 * delta,
                Exact(),
                {b.x, b.y, b.z},
                {turned_a.x, turned_a.y, turned_a.z}};
    }
};

// The coefficients divided by |K|, if that is not zero. Of coefficients within 1.45 u the quotients are
// within 4 u.
inline CircularForm scaled_form(double K, double A, double B, double C, double W) {
    const double scale = K == 0 ? 1 : std::abs(K);
    CircularForm f;
    const Eigen::Array4d quotients = Eigen::Array4d(A, B, C, W) / scale;
    f.k = K / scale;
    f.a = quotients[0];
    f.b = quotients[1];
    f.e = quotients[2];
    f.w = quotients[3];
    return f;
}

inline CircularForm rounded(const ExactForm& f) {
    // What underflows must not look like zero.
    const auto round = [](const Exact& x) {
        const double y = nearest(x);
        return y != 0 ? y : static_cast<int>(x.sign()) * std::numeric_limits<double>::denorm_min();
    };
    return scaled_form(round(f.K), round(f.A), round(f.B), round(f.C), round(f.W));
}

// c - center and rho - R0, each a high part plus a low one. The high parts are multiples of one unit, at most
// 2^25 of it: of such numbers, four products with each other or with integers up to 2^26 have an exact sum
// [Rump, Ogita, Oishi, Accurate floating-point summation I, section 3]. The low ones are at most 2^-24 of
// `size`, rounded once.
struct SplitBall {
    Eigen::Array4d high, low;
    double size;  // the largest of the four

    SplitBall(const Ball& ball, const Vec3& center, double radius) {
        const Eigen::Array4d x(ball.cx, ball.cy, ball.cz, ball.rho),
            y(center.x(), center.y(), center.z(), radius);
        const Eigen::Array4d d = x - y, z = d - x;
        size = d.abs().maxCoeff();
        const double shift = 0x1p28 * size;
        high = (d + shift) - shift;
        low = ((x - (d - z)) - (y + z)) + (d - high);
    }
    // Neither overflows nor underflows matter.
    bool is_moderate() const { return size >= 0x1p-300 && size <= 0x1p300; }
};
struct BallDifferences {
    std::array<Difference, 3> c;
    Difference delta;

    BallDifferences(const Ball& ball, const Vec3& center, double radius)
        : c{Difference(ball.cx, center.x()), Difference(ball.cy, center.y()),
            Difference(ball.cz, center.z())},
          delta(ball.rho, radius) {}

    CompensatedSum<> power() const {
        CompensatedSum<> C;
        for (const Difference& x : c) C.add_square(1, x);
        C.add_square(-1, delta);
        return C;
    }
};

// C of a ball. If it is certain, the high part has at most 52 bits and the sum is within u / 8, otherwise
// within 1.01 u.
struct BallPower {
    double high, low;
    bool is_certain;

    double value() const { return high + low; }
};

inline BallPower ball_power(const Ball& ball, const SphereFrame& frame) {
    const SplitBall d(ball, frame.center, frame.radius);
    const Eigen::Array4d squares = d.high * d.high, rest = (2 * d.high + d.low) * d.low;
    const BallPower C{squares.head<3>().sum() - squares[3], rest.head<3>().sum() - rest[3], true};
    // Rounding leaves less than 2^-18 u of the size in the low part.
    if (d.is_moderate() && std::abs(C.value()) >= 0x1p-15 * d.size * d.size) return C;
    const auto c = BallDifferences(ball, frame.center, frame.radius).power().value();
    return {c ? *c : 2 * nearest(frame.height(ball).w), 0, false};
}

// SphereFrame::form() of balls and sides of the box in sums, where they suffice: first of split balls, with
// the ball's power C found before.

inline std::optional<CircularForm> split_form(const Ball& ball, const BallPower& C,
                                              const SphereFrame& frame) {
    const SplitBall d(ball, frame.center, frame.radius);
    const Eigen::Matrix3d& m = frame.rotation.matrix;
    const double norm = frame.rotation.norm;
    if (!(norm <= 0x1p26)) return std::nullopt;
    const Vec3 high = m.transpose() * d.high.head<3>().matrix(),
               low = m.transpose() * d.low.head<3>().matrix();
    const double P0 = high[0] + low[0], P1 = high[1] + low[1];
    const double K = (high[2] - norm * d.high[3]) + (low[2] - norm * d.low[3]);
    const double minus_C = (high[2] + norm * d.high[3]) + (low[2] + norm * d.low[3]);
    // Each is within u, and 2^-19 u of this for the rounding of the low parts.
    const double size = norm * d.size;
    if (!(std::min({std::abs(P0), std::abs(P1), std::abs(K), std::abs(minus_C)}) >= 0x1p-16 * size))
        return std::nullopt;
    const Halves<> halves(C.high);
    const double W = norm * halves.high + (norm * halves.low + norm * C.low);
    return scaled_form(K, -2 * P0, -2 * P1, -minus_C, 0.5 * W);
}

inline std::optional<CircularForm> compensated_form(const Ball& ball, const SphereFrame& frame) {
    using Four = Eigen::Array4d;
    const BallDifferences d(ball, frame.center, frame.radius);
    const double norm = frame.rotation.norm;
    // P0, P1, K and -C side by side.
    CompensatedSum<Four> sums;
    for (int k = 0; k < 3; ++k) {
        const auto row = frame.rotation.matrix.row(k);
        sums.add(Halves<Four>(Four(row[0], row[1], row[2], row[2])), d.c[k]);
    }
    sums.add(Halves<Four>(Four(0, 0, -norm, norm)), d.delta);
    const auto f = sums.value();
    const auto w = d.power().times(norm).value();
    if (!f || !w) return std::nullopt;
    return scaled_form((*f)[2], -2 * (*f)[0], -2 * (*f)[1], -(*f)[3], 0.5 * *w);
}

inline CircularForm rounded_form(const Ball& ball, const BallPower& C, const SphereFrame& frame) {
    if (C.is_certain)
        if (const auto f = split_form(ball, C, frame)) return *f;
    if (const auto f = compensated_form(ball, frame)) return *f;
    return rounded(frame.form(frame.height(ball)));
}

inline CircularForm rounded_form(const WorldSide& side, const SphereFrame& frame) {
    CompensatedSum<> distance;
    distance.add(Halves<>(frame.rotation.norm), Difference(side.bound, frame.center[side.axis]));
    const auto w = distance.value();
    if (!w) return rounded(frame.form(frame.height(side)));
    const Vec3 P = side.sign * frame.rotation.matrix.row(side.axis).transpose();
    return scaled_form(P.z(), -2 * P.x(), -2 * P.y(), -P.z(), side.sign * *w);
}

// May the ball have a side of the box as its bisector? That is asked of its centre alone.
inline bool may_be_mirrored(const Ball& ball, const SphereFrame& frame) {
    const Vec3 c(ball.cx, ball.cy, ball.cz);
    return ball.rho == frame.radius && (c.array() == frame.center.array()).count() >= 2;
}

}  // namespace vcell::sphere_forms
