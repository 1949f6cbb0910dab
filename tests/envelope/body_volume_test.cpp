// What objects themselves take of their cells: against closed forms of balls and tubes in a box and of pairs
// that overlap, and against sampled points of the union.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "../../envelope/object_distance.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"

namespace vcell::body_volume_test {
namespace {

using State = DiagramCell::State;
constexpr double pi = std::numbers::pi;

VoronoiDiagram with_bodies(const DiagramScene& scene) {
    DiagramOptions options;
    options.bodies = true;
    options.threads = 1;
    return voronoi_diagram(scene, options);
}

DiagramScene scene_in(double edge, std::vector<Object> objects) {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(edge)};
    scene.objects = std::move(objects);
    return scene;
}

void check_body(double value, double error, double expected, double most_error) {
    CAPTURE(value);
    CAPTURE(expected);
    CAPTURE(error);
    CHECK(std::abs(value - expected) <= error + 1e-14 * expected);
    CHECK(error <= most_error);
}
void check_body(const DiagramCell& cell, double expected, double most_error) {
    REQUIRE(cell.state == State::Computed);
    check_body(cell.body_volume, cell.body_error, expected, most_error);
}

double ball_volume(double r) { return 4 * pi / 3 * r * r * r; }
// Of a ball, what is beyond a plane at distance r - h from its centre.
double cap_volume(double r, double h) { return pi * h * h * (3 * r - h) / 3; }

/// The integral over [a, b] of what may have roots at its ends: midpoints in x = sin.
template <class F>
double integral_between(double a, double b, F f) {
    constexpr int points = 4000;
    double sum = 0;
    for (int i = 0; i < points; ++i) {
        const double t = -0.5 * pi + pi * (i + 0.5) / points;
        sum += f(0.5 * (a + b) + 0.5 * (b - a) * std::sin(t)) * std::cos(t);
    }
    return sum * 0.5 * (b - a) * pi / points;
}

/// The volume of a tube in a box: the lines along its axis in it, by the midpoints of rings and angles.
double tube_by_lines(const Cylinder& tube, const Box& box) {
    const Vec3 a = tube.axis.normalized(), x = a.unitOrthogonal(), y = a.cross(x);
    constexpr int rings = 600, angles = 1200;
    double sum = 0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < angles; ++j) {
            const double r = tube.radius * (i + 0.5) / rings, w = 2 * pi * (j + 0.5) / angles;
            const Vec3 p = tube.point + r * (std::cos(w) * x + std::sin(w) * y);
            double in = -1e9, out = 1e9;
            for (int k = 0; k < 3; ++k) {
                const double s = (box.min[k] - p[k]) / a[k], t = (box.max[k] - p[k]) / a[k];
                in = std::max(in, std::min(s, t));
                out = std::min(out, std::max(s, t));
            }
            sum += r * std::max(0.0, out - in);
        }
    return sum * (tube.radius / rings) * (2 * pi / angles);
}

/// The share of sampled points of the box that are nearest to each object and in it.
std::vector<double> sampled_bodies(const DiagramScene& scene, std::mt19937_64& rng, int samples) {
    std::vector<double> count(scene.objects.size(), 0);
    std::uniform_real_distribution<double> unit(0, 1);
    const Vec3 size = scene.box.max - scene.box.min;
    for (int s = 0; s < samples; ++s) {
        const Vec3 p = scene.box.min + size.cwiseProduct(Vec3(unit(rng), unit(rng), unit(rng)));
        std::size_t nearest = 0;
        for (std::size_t i = 1; i < scene.objects.size(); ++i)
            if (distance_from(scene.objects[i], p) < distance_from(scene.objects[nearest], p)) nearest = i;
        if (distance_from(scene.objects[nearest], p) < 0) count[nearest] += 1;
    }
    for (double& c : count) c *= size.prod() / samples;
    return count;
}

void check_against_samples(const DiagramScene& scene, std::mt19937_64& rng, double most_error) {
    constexpr int samples = 100'000;
    const VoronoiDiagram diagram = with_bodies(scene);
    const std::vector<double> sampled = sampled_bodies(scene, rng, samples);
    const double box = (scene.box.max - scene.box.min).prod();
    for (std::size_t i = 0; i < sampled.size(); ++i) {
        CAPTURE(i);
        const DiagramCell& cell = diagram.cells[i];
        if (cell.state == State::Empty || cell.state == State::Wall) continue;
        REQUIRE(cell.state == State::Computed);
        const double part = cell.body_volume / box, deviation = box * std::sqrt(part * (1 - part) / samples);
        CHECK(std::abs(cell.body_volume - sampled[i]) <= cell.body_error + 6 * deviation + 1e-12 * box);
        CHECK(cell.body_error <= most_error);
        CHECK(cell.body_volume <= cell.volume + cell.volume_error + cell.body_error);
    }
}

TEST_CASE("bodies: balls in a box, beyond its sides and against them") {
    const VoronoiDiagram diagram =
        with_bodies(scene_in(10, {Sphere{{1, 1, 1}, 1}, Sphere{{5, 5, 9.5}, 1}, Sphere{{0.25, 5, 0.5}, 0.125},
                                  Sphere{{5, 10.5, 5}, 0.75}, Sphere{{3, 1, 1}, 1}, Sphere{{8, 8, 8}, 0},
                                  Sphere{{10, 0, 10}, 0.5}}));
    check_body(diagram.cells[0], ball_volume(1), 1e-12);  // touches three sides and a ball
    check_body(diagram.cells[1], ball_volume(1) - cap_volume(1, 0.5), 1e-9);
    check_body(diagram.cells[2], ball_volume(0.125), 1e-12);
    check_body(diagram.cells[3], cap_volume(0.75, 0.25), 1e-6);  // centred outside
    check_body(diagram.cells[4], ball_volume(1), 1e-12);
    CHECK(diagram.cells[5].body_volume == 0);
    check_body(diagram.cells[6], ball_volume(0.5) / 8, 1e-6);  // about a corner
    for (const DiagramCell& cell : diagram.cells) CHECK(cell.body_volume <= cell.volume + cell.volume_error);
}

TEST_CASE("bodies: balls that overlap share what they have in common by their cells") {
    const double R = 1, d = 1.25;
    for (const double r : {1.0, 0.75}) {
        CAPTURE(r);
        const DiagramScene scene = scene_in(6, {Sphere{{2, 3, 3}, R}, Sphere{{2 + d, 3, 3}, r}});
        const VoronoiDiagram diagram = with_bodies(scene);
        const double x = (d * d + R * R - r * r) / (2 * d),
                     lens = cap_volume(R, R - x) + cap_volume(r, r - (d - x));
        const FilledVolume sum = body_volume(scene, diagram);
        check_body(sum.volume, sum.error, ball_volume(R) + ball_volume(r) - lens, 1e-9);
        CHECK(!sum.is_estimated);
        if (r == R)
            for (const DiagramCell& cell : diagram.cells)
                check_body(cell, ball_volume(R) - cap_volume(R, R - x), 1e-9);
    }
}

TEST_CASE("bodies: balls in a box that repeats") {
    DiagramScene scene = scene_in(2, {Sphere{{0.5, 0.5, 0.5}, 1.1}});
    scene.periodic = {true, true, true};
    check_body(with_bodies(scene).cells[0], ball_volume(1.1) - 6 * cap_volume(1.1, 0.1), 1e-9);
    scene.objects = {Sphere{{0, 0, 0}, 1}};  // images touch
    const VoronoiDiagram touching = with_bodies(scene);
    check_body(touching.cells[0], ball_volume(1), 1e-12);
    CHECK(body_volume(scene, touching).box == 8);
}

TEST_CASE("bodies: a tube in a box, along an axis, beyond a side, oblique, through edges and corners") {
    const double edge = 4;
    const auto body = [&](const Cylinder& tube) {
        const VoronoiDiagram diagram = with_bodies(scene_in(edge, {tube}));
        REQUIRE(diagram.cells[0].state == State::Computed);
        CHECK(!diagram.cells[0].body_estimated);
        CHECK(diagram.cells[0].body_error <= 1e-11);
        return diagram.cells[0].body_volume;
    };
    CHECK(body({{1, 2, 0}, {0, 0, 1}, 0.5}) == doctest::Approx(pi * 0.25 * edge).epsilon(1e-13));
    // Two thirds of a radius of it are beyond a side: a segment is missing.
    const double r = 0.75, h = 0.25, angle = 2 * std::acos(h / r);
    CHECK(body({{1, h, 7}, {0, 0, -3}, r}) ==
          doctest::Approx(edge * (pi * r * r - 0.5 * r * r * (angle - std::sin(angle)))).epsilon(1e-12));
    // From side to opposite side: as long as its axis.
    const Vec3 lean(0.2, 0.1, 1);
    CHECK(body({{2, 2, 1}, lean, 0.25}) == doctest::Approx(pi * 0.0625 * edge * lean.norm()).epsilon(1e-12));
    for (const Cylinder& tube :
         {Cylinder{{2, 2, 2}, {1, 1, 1}, 0.5}, Cylinder{{0.3, 3.8, 2}, {1, -2, 3}, 0.7},
          Cylinder{{2, 2, 0.2}, {3, 1, 0.01}, 0.5}, Cylinder{{2, 2, 2}, {0.4, 1, -0.7}, 1.6}}) {
        CAPTURE(tube.axis.transpose());
        CHECK(body(tube) ==
              doctest::Approx(tube_by_lines(tube, {Vec3::Zero(), Vec3::Constant(edge)})).epsilon(2e-5));
    }
}

TEST_CASE("bodies: tubes and balls that overlap tubes") {
    // Across each other, at height y a rectangle: 4 sqrt(r^2 - y^2) sqrt(s^2 - (y - d)^2).
    const double r = 0.5, s = 0.375, d = 0.6, edge = 4;
    const DiagramScene crossing =
        scene_in(edge, {Cylinder{{0, 2, 2}, {1, 0, 0}, r}, Cylinder{{2, 2 + d, 0}, {0, 0, 1}, s}});
    const FilledVolume sum = body_volume(crossing, with_bodies(crossing));
    const double common = integral_between(d - s, r, [&](double y) {
        return 4 * std::sqrt(std::max(0.0, r * r - y * y)) *
               std::sqrt(std::max(0.0, s * s - (y - d) * (y - d)));
    });
    check_body(sum.volume, sum.error, pi * (r * r + s * s) * edge - common, 1e-4);
    CHECK(sum.is_estimated);
    // At height z the ball is a disc of radius q, of which the tube has what is farther than h from its
    // centre.
    const double q0 = 0.7, from = 0.8;
    const DiagramScene beside =
        scene_in(edge, {Cylinder{{0, 2, 2}, {1, 0, 0}, r}, Sphere{{2, 2 + from, 2}, q0}});
    const FilledVolume both = body_volume(beside, with_bodies(beside));
    const double w = (from * from + r * r - q0 * q0) / (2 * from), top = std::sqrt(r * r - w * w);
    const double shared = integral_between(-top, top, [&](double z) {
        const double q = std::sqrt(q0 * q0 - z * z), h = std::min(q, from - std::sqrt(r * r - z * z));
        return q * q * std::acos(h / q) - h * std::sqrt(q * q - h * h);
    });
    check_body(both.volume, both.error, pi * r * r * edge + ball_volume(q0) - shared, 1e-4);
}

TEST_CASE("bodies: tubes that are in each other, or cut each other so deep that they have no cells") {
    const double r = 0.5, s = 0.3, edge = 4;
    const auto sum_of = [&](std::vector<Object> objects, double most_error) {
        const DiagramScene scene = scene_in(edge, std::move(objects));
        const FilledVolume sum = body_volume(scene, with_bodies(scene));
        CHECK(sum.error <= most_error);
        return std::pair(sum.volume, sum.error);
    };
    // Axes that meet: at height y a square, 4 sqrt(r^2 - y^2) sqrt(s^2 - y^2).
    const double common = integral_between(-s, s, [&](double y) {
        return 4 * std::sqrt(r * r - y * y) * std::sqrt(std::max(0.0, s * s - y * y));
    });
    const auto [crossing, doubt] =
        sum_of({Cylinder{{0, 2, 2}, {1, 0, 0}, r}, Cylinder{{2, 2, 0}, {0, 0, 1}, s}}, 1e-4);
    CHECK(std::abs(crossing - (pi * (r * r + s * s) * edge - common)) <= doubt);
    // Of one radius: 16/3 r^3 in common.
    const auto [equal, doubt_of_equal] =
        sum_of({Cylinder{{0, 2, 2}, {1, 0, 0}, r}, Cylinder{{2, 2, 0}, {0, 0, 1}, r}}, 1e-4);
    CHECK(std::abs(equal - (2 * pi * r * r * edge - 16.0 / 3 * r * r * r)) <= doubt_of_equal);
    // One in another one, the same twice, and a ball in a tube.
    const auto [inner, doubt_of_inner] =
        sum_of({Cylinder{{0, 2, 2}, {1, 0, 0}, r}, Cylinder{{0, 2, 2.1}, {2, 0, 0}, s},
                Cylinder{{1, 2, 2}, {-1, 0, 0}, r}, Sphere{{2, 2, 2.1}, 0.2}},
               1e-4);
    CHECK(std::abs(inner - pi * r * r * edge) <= doubt_of_inner);
}

TEST_CASE("bodies: balls that reach beyond the wall of a hollow sphere, in any direction") {
    // Where |x| + |x - c| < R + r the ball is nearer: from c, with the angle's cosine to the way out, up to
    // t = ((R + r)^2 - d^2) / (2 (R + r + d cos)).
    const double R = 3.5, r = 0.75;
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1), distance(R - 0.6, R + 0.5);
    for (int round = 0; round < long_rounds(8); ++round) {
        const double d = distance(rng), A = 0.5 * ((R + r) * (R + r) - d * d), B = R + r,
                     c = std::clamp((A / r - B) / d, -1.0, 1.0);
        const double expected =
            2 * pi *
            (r * r * r / 3 * (c + 1) +
             A * A * A / (6 * d) * (1 / ((B + d * c) * (B + d * c)) - 1 / ((B + d) * (B + d))));
        // What is nearer to the ball reaches no farther than (R + r + d) / 2 < 5 from the middle.
        const Vec3 middle(5, 5, 5), way = Vec3(unit(rng), unit(rng), unit(rng)).normalized();
        CAPTURE(d);
        const VoronoiDiagram diagram =
            with_bodies(scene_in(10, {HollowSphere{middle, R}, Sphere{middle + d * way, r}}));
        check_body(diagram.cells[1], expected, 1e-5);
    }
}

TEST_CASE("bodies: balls and tubes that overlap the wall of a hollow cone") {
    std::mt19937_64 rng(test_seed());
    const HollowCone wall{{2, 2, 0.5}, {0, 0, 1}, 3, 5};
    const Sphere ball{{2, 2, 1.5}, 0.8};
    // In a direction from the ball's centre, c the cosine of its angle with the axis, up to where the wall is
    // as near.
    const double expected = 2 * pi * integral_between(-1, 1, [&](double c) {
                                const Vec3 u(std::sqrt(1 - c * c), 0, c);
                                double in = 0, out = ball.radius;
                                for (int k = 0; k < 60; ++k) {
                                    const double t = 0.5 * (in + out);
                                    const bool is_nearer =
                                        t - ball.radius <= distance_from(wall, ball.center + t * u);
                                    (is_nearer ? in : out) = t;
                                }
                                return in * in * in / 3;
                            });
    CHECK(expected < 0.95 * ball_volume(ball.radius));
    check_body(with_bodies(scene_in(4, {ball, wall})).cells[0], expected, 1e-3);
    check_against_samples(
        scene_in(4, {Sphere{{1.4, 2, 1.25}, 0.6}, Sphere{{2.3, 2.5, 2.5}, 0.5}, Sphere{{2, 2, 0.25}, 0.5},
                     Cylinder{{2.5, 1.5, 0}, {0.25, 0.125, 1}, 0.25}, wall}),
        rng, 1e-3);
}

TEST_CASE("bodies: random scenes against sampled points") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(0.2, 3.8), size(0.2, 0.9), any(-1, 1);
    std::vector<Object> balls;
    for (int i = 0; i < 14; ++i) balls.push_back(Sphere{{place(rng), place(rng), place(rng)}, size(rng)});
    check_against_samples(scene_in(4, balls), rng, 1e-6);
    DiagramScene periodic = scene_in(4, balls);
    periodic.periodic = {true, false, true};
    const VoronoiDiagram diagram = with_bodies(periodic);
    double bodies = 0;
    for (const DiagramCell& cell : diagram.cells)
        if (cell.state == State::Computed) bodies += cell.body_volume;
    periodic.probe = 1e-12;  // next to no probe: cells are the balls themselves
    CHECK(bodies == doctest::Approx(filled_volume(periodic, voronoi_diagram(periodic)).volume).epsilon(1e-9));

    std::vector<Object> mixed(balls.begin(), balls.begin() + 3);
    mixed.push_back(Cylinder{{2, 0.4, 2}, {1, 0.2, 0.1}, 0.3});
    mixed.push_back(Cylinder{{1.8, 0.6, 2.4}, {any(rng), any(rng), 1}, 0.25});
    mixed.push_back(Cylinder{{2, 3.4, 1}, {0.1, 0.1, 1}, 0.4});
    const DiagramScene of_tubes = scene_in(4, {mixed[3], mixed[5], Sphere{{2, 1, 2.2}, 0.5}});
    check_against_samples(of_tubes, rng, 1e-4);
}

TEST_CASE("bodies: nothing is told of them where they were not asked for, and any threads tell the same") {
    const DiagramScene scene = scene_in(
        4, {Sphere{{1, 1, 1}, 0.8}, Sphere{{1.5, 2, 2}, 0.7}, Cylinder{{2, 3.5, 0}, {0, 0, 1}, 0.25}});
    for (const DiagramCell& cell : voronoi_diagram(scene).cells) CHECK(std::isnan(cell.body_volume));
    DiagramOptions options;
    options.bodies = true;
    options.threads = 3;
    const VoronoiDiagram one = with_bodies(scene), three = voronoi_diagram(scene, options);
    for (std::size_t i = 0; i < one.cells.size(); ++i) {
        CHECK(one.cells[i].body_volume == three.cells[i].body_volume);
        CHECK(one.cells[i].body_error == three.cells[i].body_error);
    }
    // Moved by a power of two that doubles hold, and to another scale: as much of the cells.
    DiagramScene large = scene;
    for (Object& o : large.objects)
        std::visit(
            [](auto& object) {
                if constexpr (requires { object.center; }) object.center *= 8;
                if constexpr (requires { object.point; }) object.point *= 8;
                if constexpr (requires { object.radius; }) object.radius *= 8;
            },
            o);
    large.box.max *= 8;
    const VoronoiDiagram scaled = with_bodies(large);
    for (std::size_t i = 0; i < one.cells.size(); ++i)
        CHECK(scaled.cells[i].body_volume == doctest::Approx(512 * one.cells[i].body_volume).epsilon(1e-6));
}

}  // namespace
}  // namespace vcell::body_volume_test
