// Trisectors within a box: what is there is on the trisector, and what is on the trisector is there.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "../../primitives/bisectors/trisector.hpp"
#include "reference.hpp"
#include "test_support.hpp"

using namespace vcell;

namespace {

struct Triple {
    Object base, a, b;
};

const Box box{{-4, -4, -4}, {4, 4, 4}};
constexpr double tolerance = 1e-5;

std::vector<Vec3> points_of(const TrisectorCurve& curve) {
    std::vector<Vec3> points;
    for (const RationalCurve3& arc : curve.arcs)
        for (std::size_t k = 0; k + 1 < arc.knots.size(); ++k) {
            const int n = arc.knots[k] < arc.knots[k + 1] ? 50 : 0;
            for (int i = 0; i < n; ++i)
                points.push_back(arc.evaluate(std::lerp(arc.knots[k], arc.knots[k + 1], i / double(n - 1))));
        }
    return points;
}

// Over a base plane what counts is its one side.
double base_distance(const Object& base, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&base))
        return plane->normal.normalized().dot(p - plane->point);
    return distance(base, p);
}
std::array<double, 2> differences(const Triple& t, const Vec3& p) {
    const double r = base_distance(t.base, p);
    return {distance(t.a, p) - r, distance(t.b, p) - r};
}

// A point as far from all three, by Gauss-Newton steps with difference quotients.
std::optional<Vec3> point_near(const Triple& t, Vec3 p) {
    for (int step = 0; step < 40; ++step) {
        const auto d = differences(t, p);
        if (std::hypot(d[0], d[1]) < 1e-12) {
            // Behind a base plane, where a solid overlaps it, is no cell.
            if (std::holds_alternative<Plane>(t.base) && base_distance(t.base, p) < 1e-6) return std::nullopt;
            const bool inside = (p - box.min).minCoeff() > 1e-6 && (box.max - p).minCoeff() > 1e-6;
            return inside ? std::optional(p) : std::nullopt;
        }
        Eigen::Matrix<double, 2, 3> J;
        for (int k = 0; k < 3; ++k) {
            const double h = 1e-6;
            const auto e = differences(t, p + h * Vec3::Unit(k)), f = differences(t, p - h * Vec3::Unit(k));
            for (int i : {0, 1}) J(i, k) = (e[i] - f[i]) / (2 * h);
        }
        const Eigen::Matrix2d gram = J * J.transpose();
        if (!(gram.determinant() > 1e-9)) return std::nullopt;
        p -= J.transpose() * (gram.inverse() * Eigen::Vector2d(d[0], d[1]));
        if (!(p.norm() < 20)) return std::nullopt;
    }
    return std::nullopt;
}

double distance_to_polyline(const std::vector<Vec3>& points, const Vec3& p) {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 d = points[i + 1] - points[i];
        const double s = std::clamp(d.dot(p - points[i]) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
        least = std::min(least, (points[i] + s * d - p).norm());
    }
    return least;
}

// Is one solid within another? Then it counts from within, unlike distance().
bool are_nested(const Object& inner, const Object& outer) {
    const auto* s = std::get_if<Sphere>(&inner);
    const bool is_solid = !std::holds_alternative<Plane>(outer);
    return s && is_solid && &inner != &outer && distance(outer, s->center) <= -s->radius;
}

// How many of the points found from random starts lie on none of the curves, and how many are found.
struct Coverage {
    int found = 0, missed = 0;
};
Coverage coverage(const Triple& t, const TrisectorCurves& curves, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> coordinate(-4, 4);
    Coverage result;
    std::vector<std::vector<Vec3>> polylines;
    for (const TrisectorCurve& c : curves.curves) polylines.push_back(points_of(c));
    for (int i = 0; i < 150; ++i) {
        const auto p = point_near(t, {coordinate(rng), coordinate(rng), coordinate(rng)});
        if (!p) continue;
        ++result.found;
        double least = HUGE_VAL;
        for (const auto& points : polylines) least = std::min(least, distance_to_polyline(points, *p));
        for (const Box& b : curves.undecided)
            if ((*p - b.min).minCoeff() > -1e-6 && (b.max - *p).minCoeff() > -1e-6) least = 0;
        result.missed += least > 2e-3;
    }
    return result;
}

void check(const Triple& t, std::mt19937_64& rng, Coverage& all) {
    const TrisectorCurves curves = trisector(t.base, t.a, t.b, box, tolerance);
    for (const TrisectorCurve& c : curves.curves) {
        CAPTURE(to_string(c.kind));
        REQUIRE_FALSE(c.arcs.empty());
        CHECK(c.error <= tolerance);
        const double enough = c.kind == TrisectorKind::Spline ? 2 * c.error + 1e-12 : 1e-10;
        const std::vector<Vec3> points = points_of(c);
        double worst = 0;
        for (const Vec3& p : points)
            for (const double d : differences(t, p)) worst = std::max(worst, std::abs(d));
        CHECK(worst <= enough);
        for (std::size_t i = 0; i + 1 < c.arcs.size(); ++i)
            CHECK((c.arcs[i].evaluate(c.arcs[i].knots.back()) -
                   c.arcs[i + 1].evaluate(c.arcs[i + 1].knots.front()))
                      .norm() <= enough);
        if (c.is_closed) {
            CHECK((points.front() - points.back()).norm() <= enough);
            continue;
        }
        for (const int end : {0, 1}) {
            const Vec3& p = end == 0 ? points.front() : points.back();
            const int side = c.ends[end];
            if (side >= 0 && side < 6)
                CHECK(std::abs(p[side / 2] - (side % 2 ? box.max : box.min)[side / 2]) <= enough + 1e-9);
        }
    }
    const Coverage c = coverage(t, curves, rng);
    CHECK(c.missed == 0);
    all.found += c.found;
    // The judge misses a curve that is left out.
    if (curves.curves.size() == 1 && c.found > 20) {
        TrisectorCurves without = curves;
        without.curves.clear();
        all.missed += coverage(t, without, rng).missed > 0 ? 0 : 1;
    }
}

}  // namespace

TEST_CASE(
    "trisector in a box: all of it, of every three objects, conics as such, splines within their bound") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    const auto object = [&](int kind) -> Object {
        if (kind == 0) return Plane{3 * vector() - Vec3(0, 0, 2), vector()};
        if (kind == 1) return Sphere{2 * vector(), 0.3 + 0.2 * unit(rng)};
        return Cylinder{2.5 * vector(), vector(), 0.3 + 0.2 * unit(rng)};
    };
    Coverage all;
    int checked = 0;
    for (int round = 0; round < rounds(); ++round)
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                for (int k = j; k < 3; ++k) {
                    CAPTURE(i);
                    CAPTURE(j);
                    CAPTURE(k);
                    CAPTURE(round);
                    const Triple t{object(i), object(j), object(k)};
                    const auto within = [&](const Object& o) {
                        return are_nested(o, t.base) || are_nested(o, t.a) || are_nested(o, t.b);
                    };
                    if (within(t.base) || within(t.a) || within(t.b)) continue;
                    check(t, rng, all);
                    ++checked;
                }
    CHECK(all.found > 100 * rounds());
    CHECK(all.missed == 0);
    CHECK(checked >= 9 * rounds());
}

TEST_CASE("trisector in a box: special positions") {
    std::mt19937_64 rng(test_seed());
    Coverage all;
    const Cylinder x_rod{{0, 0, 0}, {1, 0, 0}, 0.5}, y_rod{{0, 0, 0}, {0, 1, 0}, 0.5},
        z_rod{{0, 0, 0}, {0, 0, 1}, 0.5};
    const Plane ground{{0, 0, -2}, {0, 0, 1}};
    SUBCASE("equal balls: a line") {
        const Triple t{Sphere{{-1, 0, 0}, 0.5}, Sphere{{1, 0, 0}, 0.5}, Sphere{{0, 2, 0}, 0.5}};
        check(t, rng, all);
        const auto found = trisector(t.base, t.a, t.b, box, tolerance);
        REQUIRE(found.curves.size() == 1);
        CHECK(found.curves[0].kind == TrisectorKind::Line);
        CHECK(found.curves[0].ends == std::array{4, 5});
    }
    SUBCASE("a ball between two plates: a circle, closed") {
        const Triple t{ground, Plane{{0, 0, 2}, {0, 0, -1}}, Sphere{{0, 0, 0}, 0.5}};
        check(t, rng, all);
        const auto found = trisector(t.base, t.a, t.b, box, tolerance);
        REQUIRE(found.curves.size() == 1);
        CHECK(found.curves[0].kind == TrisectorKind::Circle);
        CHECK(found.curves[0].is_closed);
    }
    SUBCASE("a ball and two equal rods that cross: plane curves, and where they cross nothing is claimed") {
        const Triple t{Sphere{{1, 2, 3}, 0.5}, x_rod, y_rod};
        check(t, rng, all);
    }
    SUBCASE("three rods across each other") {
        check({x_rod, Cylinder{{0, 0, 2}, {0, 1, 0}, 0.5}, z_rod}, rng, all);
    }
    SUBCASE("a box that none of it meets") {
        const auto none = trisector(Sphere{{-1, 0, 0}, 0.5}, Sphere{{1, 0, 0}, 0.5}, Sphere{{0, 2, 0}, 0.5},
                                    {{2, 2, 2}, {3, 3, 3}}, tolerance);
        CHECK(none.curves.empty());
        CHECK(none.undecided.empty());
    }
}

namespace {

// The largest distance of the spline's points from the trisector.
double largest_distance(const Triple& t, const RationalCurve3& spline) {
    double largest = 0;
    for (int i = 1; i < 1000; ++i) {
        const Vec3 p = spline.evaluate(std::lerp(spline.domain_begin(), spline.domain_end(), i / 1000.0));
        if (const auto q = point_near(t, p)) largest = std::max(largest, (*q - p).norm());
    }
    return largest;
}

// Seen from within and from without alike.
double from_either_side(const Object& object, const Vec3& p) { return std::abs(distance(object, p)); }

}  // namespace

TEST_CASE("trisector in a box: the bound of a spline is one, and no idle one") {
    const Plane ground{{0, 0, -3}, {0.1, 0.2, 1}};
    const Sphere ball{{1, 1, 1}, 0.9}, marble{{-1.2, 0, -0.5}, 0.5};
    const Cylinder across{{0, -1, -0.4}, {1, 0.1, 0.05}, 0.4}, away{{1.2, 0, 1}, {0, 1, 0.2}, 0.3},
        upright{{-1, 1.2, 0}, {0.1, 0.1, 1}, 0.5};
    for (const Triple& t :
         {Triple{ground, ball, across}, Triple{ground, across, away}, Triple{marble, ball, across},
          Triple{ball, across, upright}, Triple{upright, across, away}}) {
        std::size_t fewest = 0;
        for (const double wanted : {1e-3, 1e-5, 1e-7, 1e-9}) {
            CAPTURE(wanted);
            const TrisectorCurves found = trisector(t.base, t.a, t.b, box, wanted);
            REQUIRE(found.undecided.empty());
            REQUIRE_FALSE(found.curves.empty());
            std::size_t spans = 0;
            for (const TrisectorCurve& c : found.curves) {
                REQUIRE(c.kind == TrisectorKind::Spline);
                REQUIRE(c.arcs.size() == 1);
                CHECK(c.arcs[0].degree == 5);
                CHECK(c.error <= wanted);
                const double worst = largest_distance(t, c.arcs[0]);
                CHECK(worst <= c.error);
                if (wanted > 1e-8) CHECK(worst > c.error / 1000);  // the judge's own rounding is less
                // The judge sees a spline that is off.
                RationalCurve3 off = c.arcs[0];
                for (auto& point : off.points) point.head<3>() += 3 * c.error * Vec3(0.36, 0.48, 0.8);
                CHECK(largest_distance(t, off) > c.error);
                spans += c.arcs[0].points.size() / 5;
            }
            CHECK(spans > fewest);
            fewest = spans;
        }
    }
}

TEST_CASE("trisector in a box: a tolerance below rounding is missed by a finite, stated error") {
    const Triple t{Sphere{{-1.2, 0, -0.5}, 0.5}, Sphere{{1, 1, 1}, 0.9},
                   Cylinder{{0, -1, -0.4}, {1, 0.1, 0.05}, 0.4}};
    const TrisectorCurves found = trisector(t.base, t.a, t.b, box, 1e-15);
    REQUIRE(found.curves.size() == 1);
    CHECK(found.curves[0].error > 1e-15);
    CHECK(found.curves[0].error < 1e-9);
}

TEST_CASE("trisector in a box: from within a ball and a tube, and of what lies within the base") {
    const Sphere shell{{0.2, 0.1, 0}, 3}, small{{-0.6, 0.3, 0.4}, 0.4};
    const Cylinder pipe{{0.1, -0.2, 0.3}, {0.2, 1, 0.1}, 2.5}, rod{{0.8, 0.3, -0.5}, {1, 0.3, -0.2}, 0.3};
    for (const Triple& t : {Triple{small, shell, pipe}, Triple{small, pipe, rod}, Triple{pipe, small, rod}}) {
        const TrisectorCurves found = trisector(t.base, t.a, t.b, box, tolerance);
        REQUIRE_FALSE(found.curves.empty());
        for (const TrisectorCurve& c : found.curves) {
            REQUIRE(c.kind == TrisectorKind::Spline);
            CHECK(c.error <= tolerance);
            for (const Vec3& p : points_of(c))
                for (const Object& o : {t.a, t.b})
                    CHECK(std::abs(from_either_side(o, p) - from_either_side(t.base, p)) <= 2 * c.error);
        }
    }
}

TEST_CASE("trisector in a box: arcs that lead into a node are bounded to their end") {
    // Equal rods that cross: the trisector with a plane falls into plane curves, whose planes are irrational.
    const Vec3 center(0.25, 0.5, 0.125);
    const Triple t{Plane{{0, 0, -2}, {0.1, 0.3, 1}}, Cylinder{center, {1, 0.2, 0.3}, 0.4},
                   Cylinder{center, {-0.3, 1, 0.1}, 0.4}};
    REQUIRE(trisector(t.base, t.a, t.b).splits_irrationally);
    const TrisectorCurves found = trisector(t.base, t.a, t.b, box, tolerance);
    CHECK(found.undecided.size() >= 1);
    int ends = 0;
    for (const TrisectorCurve& c : found.curves) {
        CHECK(c.error <= tolerance);
        for (const Vec3& p : points_of(c))
            for (const double d : differences(t, p)) CHECK(std::abs(d) <= 2 * c.error);
        ends += (c.ends[0] == -1) + (c.ends[1] == -1);
    }
    CHECK(ends >= 4);
}

TEST_CASE("trisector in a box: between tubes that are all but alike few spans do") {
    const Cylinder tube{{0.3, 0.2, 1}, {1, 0.3, 0.2}, 0.4};
    const Plane ground{{0, 0, -2}, {0.1, 0, 1}};
    for (const double apart : {0.1, 0.03, 0.01}) {
        CAPTURE(apart);
        const Cylinder twin{tube.point + apart * Vec3(0.2, 0.6, -0.5), tube.axis + apart * Vec3(0.3, -1, 0.4),
                            tube.radius};
        const TrisectorCurves found = trisector(ground, tube, twin, box, tolerance);
        REQUIRE(found.undecided.empty());
        CHECK(found.curves.size() == 2);
        for (const TrisectorCurve& c : found.curves) {
            CHECK(c.error <= tolerance);
            CHECK(c.arcs[0].points.size() < 5 * 20);
        }
    }
}
