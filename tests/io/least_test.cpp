/// Where another site's excess may be least on a face, against a search on a grid.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "../../io/check/least.hpp"
#include "../test_support.hpp"

namespace vcell::check {
namespace {

/// A part of a base, by two parameters in [0, 1]: where the ray starts, and its direction.
struct Region {
    Object base;
    double radius;

    std::array<Vec3, 2> ray(double s, double t) const {
        if (std::holds_alternative<Plane>(base)) return {Vec3(4 * s - 2, 4 * t - 2, 0), Vec3::UnitZ()};
        const double angle = 1.5 * (s - 0.5);
        if (std::holds_alternative<Cylinder>(base))
            return {Vec3(0, 0, 3 * (t - 0.5)), Vec3(std::cos(angle), std::sin(angle), 0)};
        const double lift = 1.5 * (t - 0.5);
        return {Vec3::Zero(),
                Vec3(std::cos(angle) * std::cos(lift), std::sin(angle) * std::cos(lift), std::sin(lift))};
    }
    double first() const { return std::holds_alternative<Plane>(base) ? 0 : radius; }

    /// The point where the ray is as far from the ball as from the base; none within a long way.
    std::optional<Vec3> meet(const Sphere& ball, double s, double t) const {
        const auto [start, way] = ray(s, t);
        const auto excess = [&](double x) {
            return (start + x * way - ball.center).norm() - ball.radius - (x - first());
        };
        double lo = 0, hi = 64;
        if (excess(lo) <= 0 || excess(hi) >= 0) return std::nullopt;
        for (int k = 0; k < 60; ++k) (excess(0.5 * (lo + hi)) > 0 ? lo : hi) = 0.5 * (lo + hi);
        return start + lo * way;
    }
};

}  // namespace

TEST_CASE("least places: a rival's excess has no negative least value on a bisector elsewhere") {
    std::mt19937_64 rng(test_seed());
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng); };
    constexpr int n = 60;
    const std::array<Region, 3> regions{Region{Plane{Vec3::Zero(), Vec3(0, 0, 2)}, 0},
                                        Region{Sphere{Vec3::Zero(), 0.5}, 0.5},
                                        Region{Cylinder{Vec3(0, 0, 1), Vec3(0, 0, 3), 0.5}, 0.5}};
    int found = 0, told = 0;
    for (const Region& region : regions)
        for (int k = 0; k < long_rounds(60); ++k) {
            const auto ball = [&] {
                const auto [start, way] = region.ray(uniform(0.2, 0.8), uniform(0.2, 0.8));
                return Sphere{start + (region.first() + uniform(0.35, 1.5)) * way, uniform(0, 0.3)};
            };
            const Sphere own = ball(), rival = ball();
            const auto spots = LeastPlaces(region.base, own).of(rival);
            if (!spots) continue;
            ++told;
            std::vector<std::optional<Vec3>> points;
            std::vector<double> excess;
            for (int i = 0; i <= n; ++i)
                for (int j = 0; j <= n; ++j) {
                    const double s = i / double(n), t = j / double(n);
                    points.push_back(region.meet(own, s, t));
                    const auto& p = points.back();
                    // On the bisector the clearance is the own ball's distance.
                    excess.push_back(p ? (*p - rival.center).norm() - rival.radius -
                                             (*p - own.center).norm() + own.radius
                                       : -HUGE_VAL);
                }
            for (int i = 1; i < n; ++i)
                for (int j = 1; j < n; ++j) {
                    const std::size_t at = static_cast<std::size_t>(i * (n + 1) + j);
                    if (!(excess[at] < 0) || !points[at]) continue;
                    double around = HUGE_VAL, spacing = 0;
                    for (int a = -1; a <= 1; ++a)
                        for (int b = -1; b <= 1; ++b) {
                            const std::size_t other = at + static_cast<std::size_t>(a * (n + 1) + b);
                            if (other == at) continue;
                            around = std::min(around, excess[other]);
                            if (points[other])
                                spacing = std::max(spacing, (*points[other] - *points[at]).norm());
                        }
                    if (around < excess[at]) continue;
                    ++found;
                    CAPTURE(k);
                    CAPTURE(points[at]->transpose());
                    CHECK(std::ranges::any_of(*spots, [&](const Spot& spot) {
                        return (spot.center - *points[at]).norm() <= 3 * spacing + spot.radius;
                    }));
                }
        }
    CHECK(told > long_rounds(100));
    CHECK(found > long_rounds(20));
}

TEST_CASE(
    "least places of sites: excesses have no negative least value elsewhere, between balls, planes and sides") {
    std::mt19937_64 rng(test_seed());
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng); };
    const auto direction = [&] { return Vec3(1, uniform(-0.5, 0.5), uniform(-0.5, 0.5)).normalized(); };
    constexpr int n = 60;
    std::array<int, 9> told{};
    int found = 0;
    for (int k = 0; k < long_rounds(120); ++k) {
        Scene scene;
        const Sphere base{Vec3::Zero(), 0.5};
        scene.base = base;
        scene.box = {{-4, -4, -4}, {uniform(1, 3), 4, uniform(0.8, 2)}};
        const auto object = [&](int kind) -> Object {
            if (kind == 0) return Sphere{uniform(0.9, 2.5) * direction(), uniform(0, 1)};
            return Plane{uniform(0.8, 2.5) * direction(), (k % 2 ? 1 : -1) * direction()};
        };
        const int own_kind = k % 3, rival_kind = k / 3 % 3;
        scene.objects = {object(own_kind), object(rival_kind)};
        const Site own = own_kind == 2 ? Site::box_side(1) : Site::object(0),
                   rival = rival_kind == 2 ? Site::box_side(k % 2 ? 5 : 3) : Site::object(1);
        const auto spots = LeastPlacesOfSites(scene, own).of(rival, 1e-3);
        if (!spots) continue;
        ++told[static_cast<std::size_t>(3 * own_kind + rival_kind)];
        const Space<Interval> space(scene);
        const auto excess_at = [&](const Site& site, const Vec3& p) {
            return space.excess({site}, to_vector<Interval>(p)).mid();
        };
        // Along rays from the base's centre; what is beyond a plane is for the edges to tell.
        std::vector<std::optional<Vec3>> points;
        std::vector<double> excess;
        const auto* plane = rival_kind == 1 ? &std::get<Plane>(scene.objects[1]) : nullptr;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n; ++j) {
                const double angle = 2.4 * (i / double(n) - 0.5), lift = 2.4 * (j / double(n) - 0.5);
                const Vec3 way(std::cos(angle) * std::cos(lift), std::sin(angle) * std::cos(lift),
                               std::sin(lift));
                double lo = 0.5, hi = 30;
                const bool is_met = excess_at(own, lo * way) > 0 && excess_at(own, hi * way) < 0;
                for (int b = 0; b < 60; ++b)
                    (excess_at(own, 0.5 * (lo + hi) * way) > 0 ? lo : hi) = 0.5 * (lo + hi);
                const Vec3 p = lo * way;
                const bool is_beyond =
                    plane && plane->normal.dot(p - plane->point) * plane->normal.dot(-plane->point) < 0;
                points.push_back(is_met && !is_beyond ? std::optional(p) : std::nullopt);
                excess.push_back(points.back() ? excess_at(rival, p) : -HUGE_VAL);
            }
        for (int i = 1; i < n; ++i)
            for (int j = 1; j < n; ++j) {
                const std::size_t at = static_cast<std::size_t>(i * (n + 1) + j);
                if (!(excess[at] < -1e-9) || !points[at]) continue;
                double around = HUGE_VAL, spacing = 0;
                for (int a = -1; a <= 1; ++a)
                    for (int b = -1; b <= 1; ++b) {
                        const std::size_t other = at + static_cast<std::size_t>(a * (n + 1) + b);
                        if (other == at) continue;
                        around = std::min(around, excess[other]);
                        if (points[other]) spacing = std::max(spacing, (*points[other] - *points[at]).norm());
                    }
                if (around < excess[at]) continue;
                ++found;
                CAPTURE(k);
                CAPTURE(points[at]->transpose());
                CHECK(std::ranges::any_of(*spots, [&](const Spot& spot) {
                    return (spot.center - *points[at]).norm() <= 3 * spacing + spot.radius;
                }));
            }
    }
    CHECK(std::ranges::all_of(told, [](int count) { return count > rounds(); }));
    CHECK(found > long_rounds(6));
}

TEST_CASE(
    "least places of sites: enclosed to rounding on the bisector, where its normal is that of the side") {
    Scene scene;
    scene.base = Sphere{Vec3(0.1, 0.2, 0.3), 1};
    scene.box = {{-9, -9, -9}, {9, 9, 9}};
    scene.objects = {Sphere{Vec3(0.2, 0.3, 4), 2.5}, Plane{Vec3(0, 0, 3), Vec3(0.5, 0.25, 2)}};
    const Space<Interval> space(scene);
    for (const std::uint32_t own : {0u, 1u}) {
        const auto spots = LeastPlacesOfSites(scene, Site::object(own)).of(Site::box_side(5), 0);
        REQUIRE(spots);
        REQUIRE(spots->size() == 1);
        const auto& [p, radius] = spots->front();
        CHECK(radius < 1e-12);
        CHECK(space.excess({Site::object(own)}, to_vector<Interval>(p)).magnitude() < 1e-12);
        const Vec3 normal = middle(space.gradient({Site::object(own)}, to_vector<Interval>(p)));
        CHECK(normal.norm() > 0.1);
        CHECK(normal.cross(Vec3::UnitZ()).norm() < 1e-12);
    }
    // Between balls of one radius it is a plane.
    scene.objects[0] = Sphere{Vec3(0.2, 0.3, 4), 1};
    CHECK(LeastPlacesOfSites(scene, Site::object(0)).of(Site::box_side(5), 0)->empty());
}

TEST_CASE(
    "least places: where one ball holds the other, or both share a centre, nothing is claimed to be known") {
    const Object base = Plane{Vec3::Zero(), Vec3::UnitZ()};
    const Sphere own{Vec3(0, 0, 2), 0.25};
    const LeastPlaces places(base, own);
    CHECK_FALSE(places.of({Vec3(0, 0.125, 2), 0.5}).has_value());
    CHECK_FALSE(places.of({own.center, 0.125}).has_value());
    CHECK(places.of({Vec3(0, 1, 2), 0.5}).has_value());
}

TEST_CASE("least places: straight above the own ball a plane's bisector has none within any box") {
    const Object base = Plane{Vec3::Zero(), Vec3::UnitZ()};
    const Sphere own{Vec3(0.75, 0.5, 0.1875), 0.03125}, above{Vec3(0.75, 0.5, 0.5), 0.125};
    CHECK_FALSE(LeastPlaces(base, own).of(above).has_value());
    const auto spots = LeastPlaces(base, own, 10).of(above);
    REQUIRE(spots.has_value());
    CHECK(spots->empty());
    // A little aside it is far away, and within reach of a box as large.
    const Sphere aside{Vec3(0.875, 0.5, 0.5), 0.125};
    REQUIRE(LeastPlaces(base, own, 10).of(aside).has_value());
    CHECK_FALSE(LeastPlaces(base, own, 10).of(aside)->empty());
}

TEST_CASE("least places: enclosed to rounding, on the bisector, behind the rival as seen from a focus") {
    const Sphere base{Vec3(0.1, 0.2, 0.3), 1}, own{Vec3(0, 0, 4), 0.5};
    for (const Sphere& rival : {Sphere{Vec3(0.2, 0, 2), 0.125}, Sphere{Vec3(0.4, 0, 3), 0.25}}) {
        const auto spots = LeastPlaces(base, own).of(rival);
        REQUIRE(spots);
        REQUIRE(spots->size() == 1);
        const auto& [p, radius] = spots->front();
        CHECK(radius < 1e-12);
        CHECK((p - own.center).norm() - own.radius ==
              doctest::Approx((p - base.center).norm() - base.radius));
        const Vec3 focus = rival.radius == 0.125 ? base.center : own.center;
        CHECK((p - focus).normalized().cross((p - rival.center).normalized()).norm() < 1e-12);
        CHECK((p - focus).dot(p - rival.center) > 0);
    }
}

}  // namespace vcell::check
