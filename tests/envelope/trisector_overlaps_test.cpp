// Trisectors in a box where the objects cut, hold and touch each other: each from every base that may serve.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <tuple>

#include "../../core/errors.hpp"
#include "../../envelope/trisector/trisector_curves.hpp"
#include "test_support.hpp"
#include "trisector_judge.hpp"

namespace vcell::trisector_overlaps_test {

namespace {

const Box& box = trisector_box;
constexpr double tolerance = trisector_tolerance;
// Not symmetrical, so that no curve runs into an edge of it.
const Box odd_box{{-4.1, -3.7, -3.9}, {4.3, 3.6, 4.2}};

Curves curves_of(const Triple& t, const Box& within) {
    return trisector(t.base, t.a, t.b, within, tolerance);
}

// What does not depend on how a curve is described.
std::vector<std::tuple<TrisectorKind, int, bool, std::array<int, 2>>> listed(const Curves& curves) {
    std::vector<std::tuple<TrisectorKind, int, bool, std::array<int, 2>>> list;
    for (const TrisectorCurve& c : curves)
        list.emplace_back(c.kind, c.degree, c.is_closed,
                          std::array{std::min(c.ends[0], c.ends[1]), std::max(c.ends[0], c.ends[1])});
    std::ranges::sort(list);
    return list;
}

double largest_distance(const Curves& from, const Curves& to) {
    constexpr std::size_t asked = 25;  // of each curve
    double largest = 0;
    std::vector<std::vector<Vec3>> polylines;
    for (const TrisectorCurve& c : to) polylines.push_back(points_of(c));
    for (const TrisectorCurve& c : from) {
        const std::vector<Vec3> points = points_of(c);
        for (std::size_t i = 0; i < points.size(); i += points.size() / asked + 1) {
            double least = HUGE_VAL;
            for (const auto& polyline : polylines)
                least = std::min(least, distance_to_polyline(polyline, points[i]));
            largest = std::max(largest, least);
        }
    }
    return largest;
}

// The same curves from every order of the objects, as far as the judge's polylines tell.
void check_orders(const Triple& t, const Box& within, const Curves& found, int& undecided) {
    const Object& p = t.base;
    for (const Triple& other : {Triple{p, t.b, t.a}, Triple{t.a, p, t.b}, Triple{t.a, t.b, p},
                                Triple{t.b, p, t.a}, Triple{t.b, t.a, p}}) {
        Curves again;
        try {
            again = curves_of(other, within);
        } catch (const UndecidedError&) {
            ++undecided;
            continue;
        }
        CHECK(listed(again) == listed(found));
        CHECK(largest_distance(again, found) < 1e-3);
        CHECK(largest_distance(found, again) < 1e-3);
    }
}

void check_all(const Triple& t, const Box& within = odd_box) {
    std::mt19937_64 rng(test_seed());
    Coverage all;
    int undecided = 0;
    const Curves found = curves_of(t, within);
    check(t, within, found, rng, all);
    check_orders(t, within, found, undecided);
    CHECK(undecided == 0);
}

}  // namespace

TEST_CASE("trisector of objects that overlap: all of it, the same for every order of them") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    // Points and lines, too.
    const auto radius = [&] {
        const double r = unit(rng);
        return r < -0.7 ? 0 : r < 0.5 ? 0.3 + 0.2 * r : 1.5 * r;
    };
    const auto object = [&](int kind) -> Object {
        const Vec3 p = 1.5 * vector(), d = vector();
        if (kind == 0) return Plane{p, d};
        if (kind == 1) return Sphere{p, radius()};
        return Cylinder{p, d, radius()};
    };
    Coverage all;
    int checked = 0, undecided = 0, undecided_orders = 0;
    for_triples_of_all_kinds(long_rounds(2), object, [&](const Triple& t) {
        Curves curves;
        try {
            curves = curves_of(t, box);
        } catch (const UndecidedError&) {
            ++undecided;
            return;
        }
        check(t, box, curves, rng, all);
        check_orders(t, box, curves, undecided_orders);
        ++checked;
    });
    CHECK(all.missed == 0);
    CHECK(all.found > long_rounds(100));
    if (rounds() > 1)
        MESSAGE(checked, " answered, ", undecided, " undecided; in other orders ", undecided_orders);
    CHECK(undecided <= 1 + checked / 50);
    CHECK(undecided_orders <= 1 + checked / 20);
}

TEST_CASE("trisector of objects that overlap: closed forms") {
    SUBCASE("three planes: eight half lines from their point") {
        const Triple t{Plane{{0, 0, 0}, {1, 0, 0}}, Plane{{0, 0, 0}, {0, -2, 0}},
                       Plane{{0, 0, 0}, {0, 0, 1}}};
        check_all(t);
        const Curves found = curves_of(t, odd_box);
        CHECK(found.size() == 8);
        for (const TrisectorCurve& c : found) {
            CHECK(c.kind == TrisectorKind::Line);
            CHECK(std::min(c.ends[0], c.ends[1]) == -1);
            const auto points = points_of(c);
            CHECK(std::min(points.front().norm(), points.back().norm()) < 1e-14);
            const Vec3 along = (points.back() - points.front()).normalized().cwiseAbs();
            CHECK((along - Vec3::Constant(1 / std::sqrt(3.0))).norm() < 1e-14);
        }
    }
    SUBCASE("three planes with a line in common have none: it is at distance 0") {
        const Triple t{Plane{{0, 0, 0}, {1, 0, 0}}, Plane{{0, 0, 0}, {0, 1, 0}}, Plane{{0, 0, 3}, {1, 2, 0}}};
        CHECK(curves_of(t, odd_box).empty());
    }
    SUBCASE("three equal balls: the line through both of their points, outside") {
        const double r = 1, side = 1;
        const Triple t{Sphere{{0, 0, 0}, r}, Sphere{{side, 0, 0}, r},
                       Sphere{{0.5 * side, std::sqrt(0.75) * side, 0}, r}};
        check_all(t);
        const Curves found = curves_of(t, odd_box);
        REQUIRE(found.size() == 2);
        for (const TrisectorCurve& c : found) {
            CHECK(c.kind == TrisectorKind::Line);
            const auto points = points_of(c);
            const double least = std::min(std::abs(points.front().z()), std::abs(points.back().z()));
            CHECK(least == doctest::Approx(std::sqrt(r * r - side * side / 3)).epsilon(1e-9));
        }
    }
    SUBCASE("a plane through a ball's middle and a line across it") {
        // z = rho and z = |p| - 1 with rho, the distance from the line, is rho = 1 + sqrt(2): a circle on
        // either side. (Its plane is irrational, so that it is none of the components.)
        const Triple t{Plane{{0, 0, 0}, {0, 0, 1}}, Sphere{{0, 0, 0}, 1}, Cylinder{{0, 0, 0}, {0, 0, 1}, 0}};
        check_all(t);
        const Curves found = curves_of(t, odd_box);
        REQUIRE(found.size() == 2);
        double sum = 0;
        for (const TrisectorCurve& c : found) {
            CHECK(c.is_closed);
            CHECK(c.error <= tolerance);
            for (const Vec3& p : points_of(c)) {
                CHECK(std::abs(p.head<2>().norm() - 1 - std::sqrt(2.0)) <= c.error);
                CHECK(std::abs(std::abs(p.z()) - 1 - std::sqrt(2.0)) <= c.error);
            }
            sum += points_of(c).front().z();
        }
        CHECK(std::abs(sum) < tolerance);
    }
    SUBCASE("a rod through a ball, and a plane through both") {
        check_all({Sphere{{0.1, 0.2, 0.3}, 1}, Cylinder{{0.2, 0.1, 0}, {0.3, 0.2, 1}, 0.4},
                   Plane{{0, 0.3, 0}, {0.2, 1, 0.4}}});
    }
    SUBCASE("three rods of different radii through one another") {
        check_all({Cylinder{{0, 0, 0}, {1, 0, 0}, 0.5}, Cylinder{{0, 0.1, 0.1}, {0, 1, 0.1}, 0.6},
                   Cylinder{{0.1, 0, 0}, {0.1, 0, 1}, 0.75}});
    }
    SUBCASE("two planes that cross in a rod") {
        check_all({Plane{{0, 0, 0.1}, {0, 0, 1}}, Plane{{0, 0.2, 0}, {0.1, 1, 0}},
                   Cylinder{{0, 0, 0}, {1, 0.3, 0.2}, 0.5}});
    }
    SUBCASE("what lies in another one has none") {
        const Sphere large{{1, 1, 1}, 2}, small{{1.2, 1, 1}, 0.5};
        const Plane plane{{0, 0, 0}, {1, 2, 3}};
        const Cylinder tube{{1, 1, 1}, {0.2, 0.3, 1}, 0.8};
        CHECK(curves_of({large, small, plane}, odd_box).empty());
        CHECK(curves_of({plane, tube, small}, odd_box).empty());
        CHECK(curves_of({tube, small, large}, odd_box).empty());
    }
}

TEST_CASE("trisector of objects that overlap: moves with them") {
    // A quarter turn about z and a way of a power of two are exact.
    const Vec3 way(8, -16, 4);
    const auto turned = [](const Vec3& p) { return Vec3(-p.y(), p.x(), p.z()); };
    const auto moved = [&](const Object& object) -> Object {
        if (const auto* plane = std::get_if<Plane>(&object))
            return Plane{turned(plane->point) + way, turned(plane->normal)};
        if (const auto* ball = std::get_if<Sphere>(&object))
            return Sphere{turned(ball->center) + way, ball->radius};
        const Cylinder& tube = std::get<Cylinder>(object);
        return Cylinder{turned(tube.point) + way, turned(tube.axis), tube.radius};
    };
    const Sphere ball{{0.25, 0.5, -0.25}, 1}, marble{{1, 0.5, 0}, 0.5};
    const Cylinder rod{{0.5, 0, 0}, {0.25, 0.5, 1}, 0.375}, pipe{{0, 0.5, 0}, {1, 0.25, 0}, 0.75};
    const Plane wall{{0, 0.25, 0}, {0.5, 1, 0.25}}, roof{{0, 0, 0.5}, {0.25, 0, 1}};
    int filled = 0;
    for (const Triple& t : {Triple{ball, rod, wall}, Triple{ball, marble, pipe}, Triple{rod, pipe, roof},
                            Triple{wall, roof, rod}, Triple{wall, marble, roof}, Triple{ball, pipe, rod}}) {
        const Curves found = curves_of(t, odd_box);
        const Box there{{-odd_box.max.y(), odd_box.min.x(), odd_box.min.z()},
                        {-odd_box.min.y(), odd_box.max.x(), odd_box.max.z()}};
        const Triple far{moved(t.base), moved(t.a), moved(t.b)};
        Curves again = curves_of(far, {there.min + way, there.max + way});
        filled += !found.empty();
        CHECK(again.size() == found.size());
        // Back again.
        for (TrisectorCurve& c : again)
            for (RationalCurve3& arc : c.arcs)
                for (auto& p : arc.points) {
                    const Vec3 q = p.head<3>() - way;
                    p.head<3>() = Vec3(q.y(), -q.x(), q.z());
                }
        CHECK(largest_distance(again, found) < 1e-3);
        CHECK(largest_distance(found, again) < 1e-3);
    }
    CHECK(filled >= 4);
}

TEST_CASE("trisector of objects that overlap: what is not told is refused") {
    const Cylinder x_rod{{0, 0, 0}, {1, 0, 0}, 0.5}, y_rod{{0, 0, 0}, {0, 1, 0}, 0.5};
    const Plane level{{0, 0, 0}, {0, 0, 1}};
    // One of them twice, a plane by its other side and another point, a tube by another point of its axis.
    CHECK_THROWS_AS(curves_of({level, Plane{{3, 1, 0}, {0, 0, -2}}, x_rod}, box), UndecidedError);
    CHECK_THROWS_AS(curves_of({level, x_rod, Cylinder{{2, 0, 0}, {-3, 0, 0}, 0.5}}, box), UndecidedError);
    // Equal rods that cross in a plane.
    CHECK_THROWS_AS(curves_of({level, x_rod, y_rod}, box), UndecidedError);
    // A tube below a plane that it touches: points above are as far from both.
    const Cylinder below{{0, 0, -0.5}, {1, 0, 0}, 0.5};
    CHECK_THROWS_AS(curves_of({level, below, Sphere{{0, 1, 1}, 0.25}}, box), UndecidedError);
    CHECK_THROWS_AS(curves_of({below, Cylinder{{0, 0, -1}, {2, 0, 0}, 1}, Sphere{{0, 1, 1}, 0.25}}, box),
                    UndecidedError);
    CHECK(curves_of({level, below, Sphere{{0, 1, -1}, 0.25}}, box).size() == 1);
    CHECK_THROWS_AS(curves_of({HollowSphere{{0, 0, 0}, 1}, x_rod, y_rod}, box), InputError);
}

TEST_CASE("trisector of objects that overlap: next to special positions they end, answered or refused") {
    // Numbers that are none had patches of a face of the one, and an edge of the other, halved without end.
    const Triple tubes{Cylinder{{1.49999999999996, -1.4999999999999647, -3.3817449683125586e-15},
                                {1.3631591822474731e-14, 1.0000000000000231, 2.241999751564914e-14},
                                1},
                       Cylinder{{-1.4999999999999631, -1.4999999999999789, 1.5000000000000289},
                                {0.99999999999996858, -0.99999999999997646, 6.7299212625769215e-15},
                                1.5},
                       Cylinder{{1.4999999999999536, -1.4999999999999643, -1.4999999999999818},
                                {1.0000000000000222, -2.7506388663430173e-14, -0.99999999999998312},
                                0.5}};
    std::mt19937_64 rng(test_seed());
    Coverage all;
    const Curves found = curves_of(tubes, box);
    CHECK(found.size() == 1);
    check(tubes, box, found, rng, all);
    CHECK_THROWS_AS(
        curves_of({Plane{{1.9999999999899629, -2.0000000000051936, -1.9999999999954221},
                         {1.0000000000035512, 1.8497104033389089e-12, 3.384412561430344e-12}},
                   Plane{{-1.9999999999956501, -1.9999999999951754, 1.9999999999955393},
                         {-3.4295942149025127e-12, -1.0000000000024354, 1.0000000000035711}},
                   Cylinder{{-1.4999999999973743, 1.4999999999934075, 1.4999999999995222},
                            {-2.7459430057664691e-12, 7.6927344944958328e-13, 0.99999999999882416},
                            1}},
                  box),
        UndecidedError);
}

}  // namespace vcell::trisector_overlaps_test
