// Cells that end at a probe's distance, against closed forms of spheres that meet, and against sampled points
// of the balls grown by the probe: the cells together are their union, the caps its surface.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/measures/solid_angle.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"
#include "molecule.hpp"

namespace vcell::probe_test {
namespace {

using State = DiagramCell::State;
constexpr double pi = std::numbers::pi;

DiagramScene scene_of(std::vector<Sphere> balls, double probe, double room) {
    DiagramScene scene;
    scene.box = {balls[0].center, balls[0].center};
    for (const Sphere& b : balls) {
        scene.box.min = scene.box.min.cwiseMin(b.center - Vec3::Constant(room));
        scene.box.max = scene.box.max.cwiseMax(b.center + Vec3::Constant(room));
    }
    scene.objects.assign(balls.begin(), balls.end());
    scene.probe = probe;
    return scene;
}

void check_value(double value, double error, double expected) {
    CAPTURE(value);
    CAPTURE(expected);
    CAPTURE(error);
    CHECK(std::abs(value - expected) <= error + 1e-13 * expected);
    CHECK(error <= 1e-9 * (1 + std::abs(expected)));
}

/// Of the union of two spheres: how much of its surface is the first one's, and its volume.
struct Lens {
    double first_surface, volume;

    Lens(double R, double r, double d) {
        const double x = (d * d + R * R - r * r) / (2 * d), h = R - x, k = r - (d - x);
        first_surface = 4 * pi * R * R - 2 * pi * R * h;
        volume = 4 * pi / 3 * (R * R * R + r * r * r) - pi * h * h * (3 * R - h) / 3 -
                 pi * k * k * (3 * r - k) / 3;
    }
};

/// Of all balls grown by the probe: the volume of the union, and of each the surface that is in no other one,
/// by sampled points; with six standard deviations.
struct Sampled {
    double volume, volume_doubt;
    std::vector<double> surface, surface_doubt;

    Sampled(const std::vector<Sphere>& balls, double probe, std::mt19937_64& rng, int samples) {
        std::normal_distribution<double> normal;
        std::uniform_real_distribution<double> unit(0, 1);
        const auto direction = [&] { return Vec3(normal(rng), normal(rng), normal(rng)).normalized(); };
        const auto covered = [&](const Vec3& p, std::size_t but) {
            int count = 0;
            for (std::size_t i = 0; i < balls.size(); ++i)
                if (i != but) count += (p - balls[i].center).norm() < balls[i].radius + probe;
            return count;
        };
        // Of a point in k balls each counts 1 / k.
        volume = volume_doubt = 0;
        for (std::size_t i = 0; i < balls.size(); ++i) {
            const double R = balls[i].radius + probe, whole = 4 * pi / 3 * R * R * R;
            double sum = 0, squares = 0;
            int free = 0;
            for (int s = 0; s < samples; ++s) {
                const Vec3 d = direction();
                const double share = 1.0 / (1 + covered(balls[i].center + R * std::cbrt(unit(rng)) * d, i));
                sum += share;
                squares += share * share;
                free += covered(balls[i].center + R * d, i) == 0;
            }
            const double mean = sum / samples, part = static_cast<double>(free) / samples;
            volume += whole * mean;
            volume_doubt += whole * whole * std::max(0.0, squares / samples - mean * mean) / samples;
            surface.push_back(4 * pi * R * R * part);
            surface_doubt.push_back(4 * pi * R * R *
                                    (6 * std::sqrt(part * (1 - part) / samples) + 6.0 / samples));
        }
        volume_doubt = 6 * std::sqrt(volume_doubt) + 1e-9;
    }
};

void check_against(const DiagramScene& scene, const Sampled& sampled) {
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    const ContactTable table = contacts(diagram);
    for (const std::string& fault : table.faults) FAIL_CHECK(fault);
    for (std::size_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        CAPTURE(i);
        CAPTURE(cell.reason);
        REQUIRE((cell.state == State::Computed || cell.state == State::Empty));
        CHECK(std::abs(cell.exposed_area - sampled.surface[i]) <= sampled.surface_doubt[i]);
        if (cell.state == State::Empty) continue;
        CHECK(cell.exposed_error < 1e-6);
        CHECK(cell.max_clearance <= *scene.probe * (1 + 1e-12));
    }
    const FilledVolume sum = filled_volume(scene, diagram);
    CAPTURE(sum.volume);
    CAPTURE(sampled.volume);
    CHECK(std::abs(sum.volume - sampled.volume) <= sampled.volume_doubt);
    CHECK(sum.error < 1e-6);
    CHECK_FALSE(sum.is_estimated);
}

std::vector<Sphere> random_balls(std::mt19937_64& rng, std::size_t n, double least, double most) {
    std::uniform_real_distribution<double> place(0, 1), radius(least, most);
    std::vector<Sphere> balls;
    for (std::size_t i = 0; i < n; ++i) balls.push_back({{place(rng), place(rng), place(rng)}, radius(rng)});
    return balls;
}

}  // namespace

TEST_CASE("cap angle: circles about any axis, seen from both sides, and faces between them") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto add_circle = [](SolidAngle& face, const Vec3& n, double h, double sign, int parts) {
        const Vec3 x = n.unitOrthogonal(), y = n.cross(x);
        const auto at = [&](int k) {
            const double angle = 2 * pi * k / parts;
            return Vec3(h * n + std::sqrt(1 - h * h) * (std::cos(angle) * x + std::sin(angle) * y));
        };
        for (int k = 0; k < parts; ++k) face.add(at(k), at(k + 1), n, h, sign);
    };
    for (int round = 0; round < 20 * rounds(); ++round) {
        const Vec3 n = Vec3(unit(rng), unit(rng), unit(rng)).normalized();
        const double h = unit(rng);
        for (const int parts : {3, 4, 17}) {
            CAPTURE(h);
            SolidAngle inside, outside, ring;
            add_circle(inside, n, h, 1, parts);
            add_circle(outside, n, h, -1, parts);
            check_value(inside.value().angle, inside.value().error, 2 * pi * (1 - h));
            check_value(outside.value().angle, outside.value().error, 2 * pi * (1 + h));
            const double low = -std::abs(h) - 0.5 * (1 - std::abs(h));
            add_circle(ring, n, h, -1, parts);
            add_circle(ring, n, low, 1, parts);
            check_value(ring.value().angle, ring.value().error, 2 * pi * (h - low));
        }
    }
    CHECK(SolidAngle().value().angle == doctest::Approx(4 * pi));
}

TEST_CASE("probe: a ball alone is a ball that is larger by the probe") {
    for (const double radius : {0.0, 0.25, 3.0}) {
        const VoronoiDiagram diagram = voronoi_diagram(scene_of({{{1, 2, 3}, radius}}, 1.5, 8));
        const double R = radius + 1.5;
        const DiagramCell& cell = diagram.cells[0];
        CAPTURE(cell.reason);
        REQUIRE(cell.state == State::Computed);
        check_value(cell.volume, cell.volume_error, 4 * pi / 3 * R * R * R);
        check_value(cell.exposed_area, cell.exposed_error, 4 * pi * R * R);
        CHECK(cell.contacts.empty());
        CHECK_FALSE(cell.touches_box);
        CHECK(cell.max_clearance == doctest::Approx(1.5));
    }
}

TEST_CASE(
    "probe: two balls share a disc, or a piece of a hyperboloid, within the spheres that the probe makes") {
    for (const double second : {1.0, 0.75, 0.0, 1.875})
        for (const double distance : {2.25, 2.75, 3.5}) {
            CAPTURE(second);
            CAPTURE(distance);
            const double probe = 1;
            if (distance <= std::abs(second - 1)) continue;
            const VoronoiDiagram diagram = voronoi_diagram(
                scene_of({{{0, 0, 0}, 1}, {distance * Vec3(2, -1, 2) / 3, second}}, probe, 8));
            const bool meet = distance < 2 + second + probe;
            const Lens first(2, second + probe, distance), other(second + probe, 2, distance);
            CHECK(diagram.cells[0].contacts.size() == (meet ? 1 : 0));
            if (!meet) continue;
            check_value(diagram.cells[0].exposed_area, diagram.cells[0].exposed_error, first.first_surface);
            check_value(diagram.cells[1].exposed_area, diagram.cells[1].exposed_error, other.first_surface);
            check_value(diagram.cells[0].volume + diagram.cells[1].volume,
                        diagram.cells[0].volume_error + diagram.cells[1].volume_error, first.volume);
            if (second == 1)
                check_value(diagram.cells[0].contacts[0].area, diagram.cells[0].contacts[0].area_error,
                            pi * (4 - 0.25 * distance * distance));
        }
}

TEST_CASE("probe: around a lattice's ball faces are discs, then touch, then leave corners, then nothing") {
    // The ball's neighbours are 2 away: the cell is a cube of edge 2, its sphere of radius T.
    for (const double T : {0.75, 1.0, 1.25, 1.5, 1.75}) {
        CAPTURE(T);
        DiagramScene scene;
        scene.box = {Vec3::Zero(), Vec3::Constant(2)};
        scene.periodic = {true, true, true};
        scene.objects = {Sphere{{1, 1, 1}, 0.25}};
        scene.probe = T - 0.25;
        const VoronoiDiagram diagram = voronoi_diagram(scene);
        const DiagramCell& cell = diagram.cells[0];
        CAPTURE(cell.reason);
        REQUIRE(cell.state == State::Computed);
        const bool has_corners = T * T < 3;
        CHECK((cell.exposed_area > 0) == has_corners);
        if (T <= 1) check_value(cell.exposed_area, cell.exposed_error, 4 * pi * T * T);
        if (T > 1 && T * T < 2) {
            check_value(cell.exposed_area, cell.exposed_error, 4 * pi * T * T - 12 * pi * T * (T - 1));
            check_value(cell.area, cell.area_error, 6 * pi * (T * T - 1));
            check_value(cell.volume, cell.volume_error,
                        4 * pi / 3 * T * T * T - 6 * pi * (T - 1) * (T - 1) * (2 * T + 1) / 3);
        }
        if (!has_corners) {
            check_value(cell.volume, cell.volume_error, 8);
            check_value(cell.area, cell.area_error, 24);
        }
        if (T > 1) CHECK(cell.contacts.size() == 6);
    }
}

TEST_CASE("probe: the cells of random balls are the union of the balls grown by it, the caps its surface") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round)
        for (const double probe : {0.02, 0.1, 0.3}) {
            CAPTURE(probe);
            CAPTURE(round);
            const std::vector<Sphere> balls = random_balls(rng, 40, 0.0, 0.15);
            check_against(scene_of(balls, probe, 2), Sampled(balls, probe, rng, 4000));
        }
}

TEST_CASE("probe: small integers, where caps touch, meet in points and pass through vertices") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> place(0, 3), radius(0, 1);
    for (int round = 0; round < 6 * rounds(); ++round)
        for (const double probe : {0.5, 1.0, 2.0}) {
            std::vector<Sphere> balls;
            for (int i = 0; i < 7; ++i) {
                const Sphere ball{Vec3(place(rng), place(rng), place(rng)), 0.5 * radius(rng)};
                const bool is_apart = std::ranges::all_of(balls, [&](const Sphere& o) {
                    return (o.center - ball.center).norm() > std::abs(o.radius - ball.radius);
                });
                if (is_apart) balls.push_back(ball);
            }
            CAPTURE(probe);
            CAPTURE(round);
            for (const Sphere& b : balls) {
                CAPTURE(b.center.transpose());
                CAPTURE(b.radius);
            }
            check_against(scene_of(balls, probe, 6), Sampled(balls, probe, rng, 1500));
        }
}

TEST_CASE("probe: crambin's accessible surface") {
    const std::vector<Sphere> balls = molecule("1CRN.xyzr");
    std::mt19937_64 rng(test_seed());
    check_against(scene_of(balls, 1.4, 5), Sampled(balls, 1.4, rng, 400));
}

TEST_CASE("probe: the volume of an atom that is all but buried, by counting points") {
    // Voronota has 6.180.
    constexpr std::size_t atom = 153;
    const std::vector<Sphere> balls = molecule("1CRN.xyzr");
    const VoronoiDiagram diagram = voronoi_diagram(scene_of(balls, 1.4, 5));
    const DiagramCell& cell = diagram.cells[atom];
    REQUIRE(cell.state == State::Computed);
    CHECK(cell.volume_error < 1e-9);
    const Sphere& self = balls[atom];
    const double R = self.radius + 1.4;
    std::vector<Sphere> near;
    for (const Sphere& b : balls)
        if (b != self && (b.center - self.center).norm() < 2 * 1.4 + self.radius + b.radius)
            near.push_back(b);
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    constexpr int samples = 1'000'000;
    int own = 0;
    for (int s = 0; s < samples; ++s) {
        const Vec3 p = R * Vec3(unit(rng), unit(rng), unit(rng));
        if (!(p.norm() < R)) continue;
        const double own_distance = p.norm() - self.radius;
        own += std::ranges::none_of(near, [&](const Sphere& b) {
            return (self.center + p - b.center).norm() - b.radius < own_distance;
        });
    }
    const double cube = 8 * R * R * R, part = static_cast<double>(own) / samples;
    CHECK(std::abs(cell.volume - cube * part) <= 6 * cube * std::sqrt(part * (1 - part) / samples));
    CHECK(cell.volume == doctest::Approx(6.405).epsilon(1e-4));
}

TEST_CASE("probe: a side of the box cuts cap and cell") {
    DiagramScene scene = scene_of({{{0, 0, 0}, 1}}, 1, 8);
    scene.box.min.z() = -0.5;
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    const DiagramCell& cell = diagram.cells[0];
    REQUIRE(cell.state == State::Computed);
    check_value(cell.exposed_area, cell.exposed_error, 2 * pi * 2 * 2.5);
    CHECK(cell.touches_box);
    REQUIRE(cell.contacts.size() == 1);
    CHECK(cell.contacts[0].site == Site::box_side(4));
    check_value(cell.contacts[0].area, cell.contacts[0].area_error, pi * (4 - 0.25));
}

TEST_CASE("probe: what it is not for is refused") {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 1};
    scene.objects = {Sphere{{3, 0, 0}, 1}};
    scene.box = {Vec3::Constant(-5), Vec3::Constant(5)};
    CellOptions options;
    options.probe = 1;
    CHECK_THROWS_AS(voronoi_cell(scene, options), InputError);  // patches
    options.patches = false;
    const Cell cell = voronoi_cell(scene, options);
    REQUIRE(cell.faces.size() == 2);
    CHECK(cell.edges.size() == 1);
    CHECK(cell.edges[0].kind == CurveKind::Circle);
    CHECK(cell.measures.max_clearance == doctest::Approx(1));
    options.probe = 0;
    CHECK_THROWS_AS(voronoi_cell(scene, options), InputError);
    options.probe = 1;
    scene.objects.push_back(Cylinder{{0, 3, 0}, {0, 0, 1}, 0.5});
    CHECK_THROWS_AS(voronoi_cell(scene, options), InputError);
    scene.objects.pop_back();
    scene.base = Plane{{0, 0, -3}, {0, 0, 1}};
    CHECK_THROWS_AS(voronoi_cell(scene, options), InputError);

    DiagramScene all = scene_of({{{0, 0, 0}, 1}, {{5, 0, 0}, 1}}, 1, 3);
    all.box.max.x() = 2.5;  // the second ball is centred outside, and out of reach
    CHECK(voronoi_diagram(all).cells[1].state == State::Empty);
    all.box.max.x() = 4;
    CHECK(voronoi_diagram(all).cells[1].state == State::Refused);
    all.objects.push_back(Plane{{0, 0, -4}, {0, 0, 1}});
    CHECK_THROWS_AS(voronoi_diagram(all), InputError);
    all.objects.pop_back();
    all.probe = -1;
    CHECK_THROWS_AS(voronoi_diagram(all), InputError);
}

}  // namespace vcell::probe_test
