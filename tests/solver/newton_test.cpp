// Newton's method with its proofs: contract(), approach(), prove_near() on systems with a known root, and the
// radius of Newton-Kantorovich against roots that are known.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "../../core/solver/newton/kantorovich.hpp"
#include "../../core/solver/newton/newton.hpp"
#include "../../core/solver/newton/one_unknown.hpp"
#include "../../core/solver/newton/root_distance.hpp"
#include "../test_support.hpp"

namespace vcell::newton_test {

namespace {

// x^2 + y^2 = c^2 + d^2 and x y = c d: the roots are (c, d), (d, c) and their opposites.
template <class T>
LocalModel<T, 2> circle_and_hyperbola(const std::array<T, 2>& p, double c, double d) {
    const T two(2.0);
    return {{square(p[0]) + square(p[1]) - (T(c) * T(c) + T(d) * T(d)), p[0] * p[1] - T(c) * T(d)},
            {{{two * p[0], two * p[1]}, {p[1], p[0]}}}};
}

template <class T>
auto model(double c, double d) {
    const auto linearise = [c, d](const std::array<T, 2>& p) { return circle_and_hyperbola<T>(p, c, d); };
    return LinearisedModel<T, 2, decltype(linearise)>(linearise);
}

}  // namespace

TEST_CASE("newton: a box contracts to its root, or is empty") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> coordinate(1.5, 2), off(-0.05, 0.05);
    int unique = 0;
    for (int n = 0; n < 200; ++n) {
        const double c = coordinate(rng), d = 1 - coordinate(rng);
        const IntervalBox<2> box{Interval(c - 0.1, c + 0.1) + Interval(off(rng)),
                                 Interval(d - 0.1, d + 0.1) + Interval(off(rng))};
        const auto found = contract<Interval, 2>(model<Interval>(c, d), box);
        REQUIRE_FALSE(found.empty);
        CHECK(found.box[0].contains(c));
        CHECK(found.box[1].contains(d));
        if (found.unique) CHECK(width(found.box) < 1e-13);
        unique += found.unique;
        const auto none = contract<Interval, 2>(model<Interval>(c, d), {box[0] + Interval(0.5), box[1]});
        CHECK(none.empty);
    }
    CHECK(unique == 200);
}

TEST_CASE("newton: what is near a root is proved, at a double root it is not") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> coordinate(1.5, 2), off(-0.05, 0.05);
    const IntervalBox<2> everywhere{Interval::whole(), Interval::whole()};
    for (int n = 0; n < 200; ++n) {
        const double c = coordinate(rng), d = 1 - coordinate(rng);
        const auto box = prove_near<Interval, 2>(
            model<Interval>(c, d), {Interval(c + off(rng)), Interval(d + off(rng))}, everywhere);
        REQUIRE(box.has_value());
        CHECK((*box)[0].contains(c));
        CHECK((*box)[1].contains(d));
        CHECK(width(*box) < 1e-13);
        // (c, c) is where two roots meet.
        CHECK_FALSE(prove_near<Interval, 2>(model<Interval>(c, c), {Interval(c), Interval(c)}, everywhere));
    }
}

TEST_CASE("newton: a root of which one coordinate is 0 is proved from any start") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> off(-0.01, 0.01);
    const IntervalBox<2> everywhere{Interval::whole(), Interval::whole()};
    // x (3 + y) + 2 (y - d) and x - 3 (y - d), d a power of two.
    const double d = -0.125;
    const auto linearise = [&](const IntervalBox<2>& p) -> LocalModel<Interval, 2> {
        const Interval y = p[1] - Interval(d);
        return {{p[0] * (p[1] + 3.0) + 2.0 * y, p[0] - 3.0 * y},
                {{{p[1] + 3.0, p[0] + 2.0}, {Interval(1.0), Interval(-3.0)}}}};
    };
    const LinearisedModel<Interval, 2, decltype(linearise)> model(linearise);
    for (int n = 0; n < 200; ++n) {
        const auto box =
            prove_near<Interval, 2>(model, {Interval(off(rng)), Interval(d + off(rng))}, everywhere);
        REQUIRE(box.has_value());
        CHECK((*box)[0].contains(0));
        CHECK((*box)[1].contains(d));
        CHECK(width(*box) < 1e-13);
    }
}

TEST_CASE("newton: with many digits a root is approached to them, and not beyond the cube") {
    const double c = 1.25, d = -0.75, small = 0x1p-280;
    const IntervalBox<2> everywhere{Interval::whole(), Interval::whole()};
    const auto near = approach<Wide, 2>(model<Wide>(c, d), {Wide(1.3), Wide(-0.7)}, everywhere, small, 20);
    REQUIRE(near.has_value());
    CHECK((near->point[0] - Wide(c)).enclosure().magnitude() < 2 * small);
    CHECK((near->point[1] - Wide(d)).enclosure().magnitude() < 2 * small);
    const IntervalBox<2> beside{Interval(1.29, 1.31), Interval(-0.71, -0.69)};
    CHECK_FALSE(approach<Wide, 2>(model<Wide>(c, d), {Wide(1.3), Wide(-0.7)}, beside, small, 20));
    CHECK_FALSE(approach<Wide, 2>(model<Wide>(c, d), {Wide(1.3), Wide(-0.7)}, everywhere, small, 2));
}

TEST_CASE("newton: Kantorovich's radius holds the root and nothing more is claimed") {
    // f = a x^2 + x - e at 0: eta = |e|, omega = 2 |a|, a root at -2 e / (1 + sqrt(1 + 4 a e)).
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> part(0, 1);
    for (int n = 0; n < 2000; ++n) {
        const double a = std::ldexp(part(rng), static_cast<int>(rng() % 20)) * (n % 2 ? 1 : -1);
        const double e = 0.25 * part(rng) / (2 * std::abs(a));
        const auto radius = kantorovich_radius(e, 2 * std::abs(a));
        REQUIRE(radius.has_value());
        const double root = 2 * e / (1 + std::sqrt(1 + 4 * a * e));
        CHECK(root <= *radius);
        CHECK(*radius <= 1.25 * e * (1 + 1e-12));
        CHECK_FALSE(kantorovich_radius(1.01 * 0.25 / (2 * std::abs(a)), 2 * std::abs(a)));
    }
    CHECK_FALSE(kantorovich_radius(HUGE_VAL, 0));
    CHECK_FALSE(kantorovich_radius(std::nan(""), 0));
}

TEST_CASE("newton: a root is no farther than residuals tell where the Jacobian is near a matrix") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    using Vector = Eigen::Vector3d;
    int regular = 0, singular = 0;
    for (int i = 0; i < 1000; ++i) {
        const auto vector = [&] { return Vector(unit(rng), unit(rng), unit(rng)); };
        Eigen::Matrix3d M;
        M << vector(), vector(), vector();
        // F(x) = M (x - r) + v (sin x - sin r): a row of its Jacobian is within v of M's.
        const Vector r = vector(), P = vector();
        const double v = 0.2 * std::abs(unit(rng));
        const Vector F = M * (P - r) + v * (P.array().sin() - r.array().sin()).matrix();
        const RootDistance<3> bound(M, {v, v, v}, 1e-15);
        if (!bound.is_regular()) {
            ++singular;
            continue;
        }
        ++regular;
        const double distance = bound.distance({std::abs(F[0]), std::abs(F[1]), std::abs(F[2])});
        CHECK((P - r).norm() <= distance);
        // And no idle bound: where F is linear it is that but for the condition.
        if (v < 0.001)
            CHECK(distance <= 1.5 * std::sqrt(3.0) * M.norm() * M.inverse().norm() * (P - r).norm());
    }
    CHECK(regular > 100);
    CHECK(singular > 10);
}

TEST_CASE("newton: a bracket shrinks to the zero of an increasing function") {
    for (const double root : {0.25, 1e-30, -0.7, 0.0}) {
        const auto value = [&](const Interval& x) {
            return x * x * x - Interval(root) * square(Interval(root));
        };
        const auto slope = [](const Interval& x) { return 3.0 * square(x); };
        const Interval found = enclose_zero(Interval(-1, 2), value, slope);
        CHECK(found.contains(root));
        CHECK(found.width() < 1e-7);
    }
}

}  // namespace vcell::newton_test
