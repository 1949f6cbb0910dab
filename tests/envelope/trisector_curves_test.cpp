// Trisectors within a box: what is there is on the trisector, and what is on the trisector is there.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "../../core/errors.hpp"
#include "../../envelope/trisector/trisector_curves.hpp"
#include "test_support.hpp"
#include "trisector_judge.hpp"

namespace vcell::trisector_curves_test {

namespace {

const Box& box = trisector_box;
constexpr double tolerance = trisector_tolerance;

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
    int checked = 0, undecided = 0;
    const int rounds_of_kinds = long_rounds(4);
    for_triples_of_all_kinds(rounds_of_kinds, object, [&](const Triple& t) {
        Curves curves;
        try {
            curves = trisector(t.base, t.a, t.b, box, tolerance);
        } catch (const UndecidedError&) {
            // Tubes that all but cross, or a side of the box that nearly touches.
            ++undecided;
            return;
        }
        check(t, box, curves, rng, all);
        ++checked;
    });
    CHECK(all.found > long_rounds(100));
    CHECK(all.missed == 0);
    CHECK(checked + undecided == 10 * rounds_of_kinds);
    CHECK(undecided <= 1 + checked / 100);
    CHECK(all.coarse <= 2 + checked / 50);
}

TEST_CASE("trisector in a box: special positions") {
    std::mt19937_64 rng(test_seed());
    Coverage all;
    const Cylinder x_rod{{0, 0, 0}, {1, 0, 0}, 0.5}, y_rod{{0, 0, 0}, {0, 1, 0}, 0.5};
    const Plane ground{{0, 0, -2}, {0, 0, 1}};
    SUBCASE("equal balls: a line") {
        const Triple t{Sphere{{-1, 0, 0}, 0.5}, Sphere{{1, 0, 0}, 0.5}, Sphere{{0, 2, 0}, 0.5}};
        check(t, rng, all);
        const auto found = trisector(t.base, t.a, t.b, box, tolerance);
        REQUIRE(found.size() == 1);
        CHECK(found[0].kind == TrisectorKind::Line);
        CHECK(found[0].ends == std::array{4, 5});
    }
    SUBCASE("a ball between two plates: a circle, closed") {
        const Triple t{ground, Plane{{0, 0, 2}, {0, 0, -1}}, Sphere{{0, 0, 0}, 0.5}};
        check(t, rng, all);
        const auto found = trisector(t.base, t.a, t.b, box, tolerance);
        REQUIRE(found.size() == 1);
        CHECK(found[0].kind == TrisectorKind::Circle);
        CHECK(found[0].is_closed);
    }
    SUBCASE("a ball and two equal rods that cross: plane curves, cut where they cross") {
        const Triple t{Sphere{{1, 2, 3}, 0.5}, x_rod, y_rod};
        check(t, rng, all);
        for (const TrisectorCurve& c : trisector(t.base, t.a, t.b, box, tolerance)) {
            CHECK(c.degree == 2);
            CHECK(std::ranges::count(c.ends, -1) >= 1);
        }
    }
    SUBCASE("three rods across each other") {
        check({x_rod, Cylinder{{0, 0, 2}, {0, 1, 0}, 0.5}, Cylinder{{0, 3, 0}, {0, 0, 1}, 0.5}}, rng, all);
    }
    SUBCASE("a box that none of it meets") {
        const auto none = trisector(Sphere{{-1, 0, 0}, 0.5}, Sphere{{1, 0, 0}, 0.5}, Sphere{{0, 2, 0}, 0.5},
                                    {{2, 2, 2}, {3, 3, 3}}, tolerance);
        CHECK(none.empty());
    }
}

namespace {

// The largest distance of the spline's points from the trisector.
double largest_distance(const Triple& t, const RationalCurve3& spline) {
    double largest = 0;
    for (int i = 1; i < 1000; ++i) {
        const Vec3 p = spline.evaluate(std::lerp(spline.domain_begin(), spline.domain_end(), i / 1000.0));
        if (const auto q = point_near(t, box, p)) largest = std::max(largest, (*q - p).norm());
    }
    return largest;
}

}  // namespace

TEST_CASE("trisector in a box: the bound of a spline is one, and no idle one") {
    const Plane ground{{0, 0, -3}, {0.1, 0.2, 1}};
    const Sphere ball{{1, 1, 1}, 0.9}, marble{{-1.2, 0, -0.5}, 0.5};
    const Cylinder across{{0, -1, -0.4}, {1, 0.1, 0.05}, 0.4}, away{{1.2, 0, 1}, {0, 1, 0.2}, 0.3},
        upright{{-1, 1.2, 0}, {0.1, 0.1, 1}, 0.5};
    // [HE, Table 2]: the five that are no conics.
    const std::pair<Triple, int> rows[] = {{{ground, ball, across}, 4},
                                           {{ground, across, away}, 4},
                                           {{marble, ball, across}, 4},
                                           {{ball, across, upright}, 8},
                                           {{upright, across, away}, 8}};
    for (const auto& [t, degree] : rows) {
        std::size_t fewest = 0;
        for (const double wanted : {1e-3, 1e-5, 1e-7, 1e-9}) {
            CAPTURE(wanted);
            const Curves found = trisector(t.base, t.a, t.b, box, wanted);
            REQUIRE_FALSE(found.empty());
            std::size_t spans = 0;
            for (const TrisectorCurve& c : found) {
                REQUIRE(c.kind == TrisectorKind::Spline);
                CHECK(c.degree == degree);
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

TEST_CASE("trisector in a box: what cannot be told is refused") {
    const Sphere ball{{1, 1, 1}, 0.9}, marble{{-1.2, 0, -0.5}, 0.5};
    const Cylinder across{{0, -1, -0.4}, {1, 0.1, 0.05}, 0.4};
    // No digits prove so little.
    CHECK_THROWS_AS(trisector(marble, ball, across, box, 1e-15), UndecidedError);
    // A tolerance that is none.
    CHECK_THROWS_AS(trisector(marble, ball, across, box, 0), InputError);
}

TEST_CASE("trisector in a box: a line along a side of it is in it, and a circle that touches one is not") {
    const Box beside{{0, -2, -3}, {3, 2, 3}};
    const Curves line =
        trisector(Sphere{{-1, 0, 0}, 0.5}, Sphere{{1, 0, 0}, 0.5}, Sphere{{0, 2, 0}, 0.5}, beside, tolerance);
    REQUIRE(line.size() == 1);
    CHECK(line[0].kind == TrisectorKind::Line);
    const std::vector<Vec3> points = points_of(line[0]);
    CHECK((points.front() - points.back()).norm() == doctest::Approx(6));
    const Plane ground{{0, 0, -2}, {0, 0, 1}}, roof{{0, 0, 2}, {0, 0, -1}};
    const Sphere between{{0, 0, 0}, 0.5};
    CHECK(trisector(between, ground, roof, {{2.5, -4, -4}, {4, 4, 4}}, tolerance).empty());
    CHECK(trisector(between, ground, roof, {{2, -4, -4}, {4, 4, 4}}, tolerance).size() == 1);
}

TEST_CASE("trisector in a box: of objects that lie beyond the box, cut at its sides") {
    std::mt19937_64 rng(test_seed());
    Coverage all;
    const Sphere far{{-5, 0.3, 0.2}, 0.6}, near{{2.5, 0.4, 0.1}, 1.2};
    const Cylinder rod{{-1, 3, 0}, {0.3, 0.1, 1}, 0.4}, long_rod{{-2.5, -1, 0.3}, {0.1, 0.2, 1}, 0.3};
    const Plane wall{{-7, 0, 0}, {1, 0.1, 0.05}};
    for (const Box& box : {Box{{-2, -1.5, -1}, {1, 2, 1.5}}, Box{{-1, -1, -1}, {0.5, 1.5, 0.25}}})
        for (const Triple& t : {Triple{far, near, rod}, Triple{far, rod, near}, Triple{wall, near, rod},
                                Triple{wall, long_rod, near}, Triple{long_rod, near, rod}}) {
            const Curves found = trisector(t.base, t.a, t.b, box, tolerance);
            check(t, box, found, rng, all);
        }
    CHECK(all.found > 100);
    CHECK(all.missed == 0);
}

TEST_CASE("trisector in a box: a closed curve that its sides cut goes on beyond its own beginning") {
    // A ball between two plates has a circle; half of it, and a quarter.
    const Plane ground{{0, 0, -2}, {0, 0, 1}}, roof{{0, 0, 2}, {0, 0, -1}};
    const Sphere ball{{0.1, 0.2, 0}, 0.5};
    for (const Vec3& low : {Vec3(-4, -4, -4), Vec3(0.3, -4, -4), Vec3(-4, 0.3, -4), Vec3(0.3, 0.3, -4)}) {
        // The base lies far beyond the box.
        const Box part{low, {4, 4, 4}};
        const Curves found = trisector(ball, ground, roof, part, tolerance);
        REQUIRE(found.size() == 1);
        CHECK(found[0].kind == TrisectorKind::Circle);
        CHECK(found[0].is_closed == (low.x() < 0 && low.y() < 0));
        double length = 0;
        const std::vector<Vec3> points = points_of(found[0]);
        for (std::size_t i = 0; i + 1 < points.size(); ++i) length += (points[i + 1] - points[i]).norm();
        // Radius 1.5 + 0.5 + ..., in the middle plane: at height 0 both plates are 2 away, so |p - c| = 2.5.
        const double radius = 2.5, x = low.x() - 0.1, y = low.y() - 0.2;
        double angle = 2 * std::numbers::pi;
        if (low.x() > 0 && low.y() > 0)
            angle = std::numbers::pi / 2 - std::asin(x / radius) - std::asin(y / radius);
        else if (low.x() > 0 || low.y() > 0)
            angle = 2 * std::acos((low.x() > 0 ? x : y) / radius);
        CHECK(length == doctest::Approx(radius * angle).epsilon(1e-4));
    }
}

TEST_CASE("trisector in a box: arcs that lead into a node are bounded to their end") {
    // Equal rods that cross: the trisector with a plane falls into plane curves, whose planes are irrational.
    const Vec3 center(0.25, 0.5, 0.125);
    const Triple t{Plane{{0, 0, -6}, {0.1, 0.3, 1}}, Cylinder{center, {1, 0.2, 0.3}, 0.4},
                   Cylinder{center, {-0.3, 1, 0.1}, 0.4}};
    REQUIRE(trisector(t.base, t.a, t.b).splits_irrationally);
    const Curves found = trisector(t.base, t.a, t.b, box, tolerance);
    int ends = 0;
    for (const TrisectorCurve& c : found) {
        CHECK(c.error <= 10 * tolerance);
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
        const Curves found = trisector(ground, tube, twin, box, tolerance);
        CHECK(found.size() == 2);
        for (const TrisectorCurve& c : found) {
            CHECK(c.error <= tolerance);
            CHECK(c.arcs[0].points.size() < 5 * 40);
        }
    }
}

}  // namespace vcell::trisector_curves_test
