// Cells that end at a probe's distance, against closed forms of spheres that meet, and against sampled points
// of the balls grown by the probe: the cells together are their union, the caps its surface.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/cell_changes.hpp"
#include "../../envelope/complete_measures.hpp"
#include "../../envelope/measures/solid_angle.hpp"
#include "../../envelope/object_distance.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../../primitives/objects/decided_scene.hpp"
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
    // Circles so small that rounding does not tell which side of them the face is on, but for a place in it.
    for (const double radius : {1e-7, 1e-9}) {
        const Vec3 n = Vec3(1, 2, 3).normalized(), x = n.unitOrthogonal();
        const double h = std::sqrt(1 - radius * radius);
        const Vec3 a = h * n + radius * x, b = h * n + radius * n.cross(x), c = h * n - radius * x,
                   d = h * n - radius * n.cross(x);
        SolidAngle face;
        const std::array corners{a, b, c, d};
        for (std::size_t k = 0; k < 4; ++k) face.add(corners[k], corners[(k + 1) % 4], n, h, 1);
        CHECK(face.value().error > 6);
        check_value(face.value({{-n, false}}).angle, face.value({{-n, false}}).error, pi * radius * radius);
        check_value(face.value({{-n, true}}).angle, face.value({{-n, true}}).error, 4 * pi);
        CHECK(face.value({{n, true}}).error > 6);  // too near
    }
    // Arcs so short that they do not tell their circles, which all might run through the place.
    for (const double length : {1e-9, 1e-16, 0.0}) {
        const Vec3 place = -Vec3::UnitZ(), a(0, -0.8, -0.6),
                   b = (a + length * Vec3(0.6, 0.48, -0.64)).normalized(), c = a + 0.5 * (b - a);
        SolidAngle face;
        face.add(a, b, a.cross(place).normalized(), 0, 1);
        face.add(b, c, b.cross(place).normalized(), 0, 1);
        face.add(c, a, Vec3::Zero(), 0, 1);
        CAPTURE(length);
        check_value(face.value({{place, false}}).angle, face.value({{place, false}}).error, 0);
        check_value(face.value({{place, true}}).angle, face.value({{place, true}}).error, 4 * pi);
        CHECK(face.value({{place, true}}).error < 1e-10);
    }
}

TEST_CASE("bodies: of balls that overlap next to nothing next to nothing is lost") {
    const double ball = 4 * pi / 3;
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int k = 8; k <= 15; ++k)
        for (int round = 0; round < 4; ++round) {
            const Vec3 way = Vec3(unit(rng), unit(rng), unit(rng)).normalized();
            Scene scene;
            scene.base = Sphere{Vec3::Zero(), 1};
            scene.objects = {Sphere{(2 - std::pow(10.0, -k)) * way, 1}};
            scene.box = {Vec3::Constant(-8), Vec3::Constant(8)};
            const CompleteMeasures m = complete_body_measures(scene);
            CAPTURE(k);
            check_value(m.volume, m.volume_error, ball);
            CHECK(m.volume_error < 1e-10 * ball);
        }
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

// Around a base (alone in a box about the origin, of half the width) the cell that ends at the probe.
Cell alone(const Object& base, double probe, double half) {
    Scene scene;
    scene.base = base;
    scene.probe = probe;
    scene.box = {Vec3::Constant(-half), Vec3::Constant(half)};
    return voronoi_cell(scene);
}

TEST_CASE("probe: about a ball, a tube and a plane alone the cap is one, too") {
    const double probe = 0.75, half = 4;
    for (const double radius : {0.0, 0.5, 1.25}) {
        CAPTURE(radius);
        const double R = radius + probe;
        const Cell ball = alone(Sphere{{0.5, 0, 0.25}, radius}, probe, half);
        REQUIRE(ball.faces.size() == 1);
        CHECK(ball.faces[0].site == Site::cap());
        check_value(ball.faces[0].area, ball.faces[0].area_error, 4 * pi * R * R);
        check_value(ball.measures.volume, ball.measures.volume_error, 4 * pi / 3 * R * R * R);
        const Cell tube = alone(Cylinder{{0.5, 0.25, 0}, {0, 0, 3}, radius}, probe, half);
        REQUIRE(tube.faces.size() == 1);
        CHECK(tube.faces[0].site == Site::cap());
        check_value(tube.faces[0].area, tube.faces[0].area_error, 2 * pi * R * 2 * half);
        check_value(tube.measures.volume, tube.measures.volume_error, pi * R * R * 2 * half);
        for (const Cell& cell : {ball, tube}) {
            CHECK(cell.measures.area == 0);
            CHECK(cell.neighbors.empty());
            CHECK(cell.report.warnings.empty());
            CHECK(cell.scene.objects.empty());
        }
    }
    const Cell plane = alone(Plane{{0, 0, 1}, {0, 0, 2}}, probe, half);
    REQUIRE(plane.faces.size() == 1);
    CHECK(plane.faces[0].site == Site::cap());
    check_value(plane.faces[0].area, plane.faces[0].area_error, 4 * half * half);
    check_value(plane.measures.volume, plane.measures.volume_error, 4 * half * half * probe);
}

// Balls, a tube, planes and a vessel about a base.
Scene mixed_around(const Object& base) {
    Scene scene;
    scene.base = base;
    scene.objects = {Sphere{{2, 0.5, 0.25}, 0.5}, Cylinder{{0, 2, 0}, {1, 0.25, 0.5}, 0.25},
                     Plane{{0, 0, 3.5}, {0.25, 0, 1}}, Sphere{{-1, -1.5, 1}, 0.25}};
    if (!std::holds_alternative<Plane>(base)) {
        scene.objects.push_back(Plane{{-2, 0, 0}, {1, 0, 0.125}});
        scene.objects.push_back(HollowSphere{{0.25, 0, 0}, 3.5});
    }
    scene.box = {Vec3::Constant(-2.25), Vec3::Constant(2.25)};
    return scene;
}

TEST_CASE("probe: among balls, tubes, planes and vessels the cap competes as a vessel of its own") {
    for (const Object& base : {Object(Sphere{{0, 0, 0}, 0.5}), Object(Cylinder{{0, 0, 0}, {0.25, 0, 1}, 0.5}),
                               Object(Plane{{0, 0, -2}, {0, 0, 1}})})
        for (const double probe : {0.25, 0.75, 1.25}) {
            CAPTURE(base.index());
            CAPTURE(probe);
            Scene scene = mixed_around(base), among = scene;
            scene.probe = probe;
            among.objects.push_back(cap_of(base, probe));
            const Cell cell = voronoi_cell(scene), other = voronoi_cell(among);
            REQUIRE(cell.faces.size() == other.faces.size());
            CHECK(cell.vertices.size() == other.vertices.size());
            CHECK(cell.edges.size() == other.edges.size());
            CHECK(cell.scene.objects == scene.objects);
            double exposed = 0;
            for (std::size_t f = 0; f < cell.faces.size(); ++f) {
                const Site site = other.faces[f].site;
                const bool is_cap = site == Site::object(static_cast<std::uint32_t>(scene.objects.size()));
                CHECK(cell.faces[f].site == (is_cap ? Site::cap() : site));
                CHECK(cell.faces[f].area == doctest::Approx(other.faces[f].area).epsilon(1e-9));
                CHECK_FALSE(cell.faces[f].patches.empty());
                if (is_cap) exposed += cell.faces[f].area;
            }
            CHECK(exposed > 0);
            CHECK(cell.measures.volume == doctest::Approx(other.measures.volume).epsilon(1e-9));
            CHECK(cell.measures.area == doctest::Approx(other.measures.area - exposed));
            CHECK(cell.measures.max_clearance <= probe);
            CHECK(cell.measures.max_clearance > probe - 1e-6);
            // What is out of reach is left out without a word.
            for (const std::string& warning : cell.report.warnings) FAIL_CHECK(warning);
            for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
                CHECK(cell.vertices[v].radius <= probe * (1 + 1e-12));
                if (std::ranges::count(cell.vertices[v].sites, Site::cap()) > 0)
                    CHECK(refine(cell, v, 100).has_value());
            }
        }
}

TEST_CASE("probe: cells that others join or leave end where they did") {
    Scene scene = mixed_around(Sphere{{0, 0, 0}, 0.5});
    scene.probe = 1.25;
    const Cell whole = voronoi_cell(scene);
    const Object last = scene.objects.front();
    const Cell without = remove(whole, 0);
    CHECK(without.scene.probe == scene.probe);
    CHECK(without.measures.volume > whole.measures.volume);
    scene.objects.erase(scene.objects.begin());
    CHECK(without.measures.volume == doctest::Approx(voronoi_cell(scene).measures.volume).epsilon(1e-12));
    const Cell again = insert(without, last);
    CHECK(again.measures.volume == doctest::Approx(whole.measures.volume).epsilon(1e-12));
    Cell other = without;
    other.scene.probe = 1;
    CHECK_THROWS_AS(merge(without, other), InputError);
}

TEST_CASE("probe: cells in a room with rods fill what is within reach of balls") {
    DiagramScene scene;
    scene.box = {Vec3::Constant(-3), Vec3::Constant(3)};
    scene.objects = {Sphere{{0, 0, 0}, 0.5},
                     Sphere{{1.5, 0.5, 0}, 0.25},
                     Sphere{{-1, 1, 1}, 0.75},
                     Sphere{{1, -1, -1}, 0.5},
                     Cylinder{{0, -1.5, 0}, {1, 0, 0.25}, 0.25},
                     Plane{{0, 0, 2.25}, {0, 0.25, 1}},
                     HollowSphere{{0, 0, 0}, 3.25}};
    scene.probe = 0.5;
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    for (const std::string& fault : contacts(diagram).faults) FAIL_CHECK(fault);
    double sum = 0, error = 0;
    for (const DiagramCell& cell : diagram.cells) {
        if (cell.state == State::Wall) continue;
        CAPTURE(cell.reason);
        REQUIRE(cell.state == State::Computed);
        CHECK(cell.exposed_area > 0);
        sum += cell.volume;
        error += cell.volume_error;
    }
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(-3, 3);
    constexpr int samples = 200'000;
    int within = 0;
    for (int s = 0; s < samples; ++s) {
        const Vec3 p(place(rng), place(rng), place(rng));
        double own = std::numeric_limits<double>::infinity(), wall = own;
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            double& least = diagram.cells[i].state == State::Wall ? wall : own;
            least = std::min(least, distance_from(scene.objects[i], p));
        }
        within += own < wall && own < *scene.probe;
    }
    const double box = 216, part = static_cast<double>(within) / samples;
    CHECK(std::abs(sum - box * part) <= 6 * box * std::sqrt(part * (1 - part) / samples) + error);
    CHECK(error < 1e-5);
}

TEST_CASE("probe: one that is no length is refused") {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 1};
    scene.objects = {Sphere{{3, 0, 0}, 1}};
    scene.box = {Vec3::Constant(-5), Vec3::Constant(5)};
    scene.probe = 1;
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 2);
    CHECK(cell.edges.size() == 1);
    CHECK(cell.edges[0].kind == CurveKind::Circle);
    CHECK(cell.measures.max_clearance == doctest::Approx(1));
    for (const double probe : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
        scene.probe = probe;
        try {
            voronoi_cell(scene);
            FAIL("has a cell");
        } catch (const InputError& e) {
            CHECK(e.path == "probe");
        }
    }
    DiagramScene all = scene_of({{{0, 0, 0}, 1}, {{5, 0, 0}, 1}}, 1, 3);
    all.box.max.x() = 2.5;  // the second ball is centred outside, and out of reach
    CHECK(voronoi_diagram(all).cells[1].state == State::Empty);
    all.box.max.x() = 4;
    const DiagramCell part = voronoi_diagram(all).cells[1];  // a segment of a ball
    REQUIRE(part.state == State::Computed);
    check_value(part.volume, part.volume_error, 5 * pi / 3);
    check_value(part.exposed_area, part.exposed_error, 4 * pi);
    all.probe = -1;
    CHECK_THROWS_AS(voronoi_diagram(all), InputError);
}

}  // namespace vcell::probe_test
