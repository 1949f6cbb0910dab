// Volumes and areas of cells of spheres and cylinders: cells that tile a box, solids of revolution,
// polyhedra, sampling.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "../../core/quadrature/quadrature.hpp"
#include "../../envelope/measures/radial_integrals.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../test_support.hpp"
#include "cell_checks.hpp"

namespace vcell::radial_measures_test {
using namespace vcell::testing;

namespace {

constexpr double pi = std::numbers::pi;

double box_volume(const Box& box) { return (box.max - box.min).prod(); }
double box_surface(const Box& box) {
    const Vec3 d = box.max - box.min;
    return 2 * (d.x() * d.y() + d.y() * d.z() + d.z() * d.x());
}

Scene over(const Object& base, std::vector<Object> objects, const Box& box) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    scene.box = box;
    return scene;
}

Box cube(double half) { return {Vec3::Constant(-half), Vec3::Constant(half)}; }

// The same scene for each of its spheres and cylinders in turn.
std::vector<Cell> all_cells(const std::vector<Object>& objects, const Box& box) {
    std::vector<Cell> cells;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        std::vector<Object> others = objects;
        others.erase(others.begin() + i);
        cells.push_back(voronoi_cell(over(objects[i], others, box)));
    }
    return cells;
}

// Volumes sum up to the box's; each bisector has the same area from both sides.
void check_tiling(const std::vector<Object>& objects, const Box& box, double accuracy) {
    const std::vector<Cell> cells = all_cells(objects, box);
    double volume = 0, error = 0, surface = 0;
    std::map<std::array<std::size_t, 2>, double> areas;
    std::map<std::array<std::size_t, 2>, double> area_errors;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const Measures& m = cells[i].measures;
        volume += m.volume;
        error += m.volume_error;
        surface += m.box_area;
        double area = 0;
        for (const CellFace& face : cells[i].faces) {
            if (!face.site.is_object()) continue;
            area += face.area;
            areas[{i, face.site.index + (face.site.index >= i ? 1u : 0u)}] += face.area;
        }
        CHECK(area == doctest::Approx(m.area).epsilon(1e-14));
        CHECK(m.area_error <= accuracy * box_surface(box) * 1e5);
    }
    CHECK(std::abs(volume - box_volume(box)) <= error);
    CHECK(error <= accuracy * box_volume(box));
    for (const auto& [pair, area] : areas) {
        CAPTURE(pair[0]);
        CAPTURE(pair[1]);
        const double other = areas[{pair[1], pair[0]}];
        const double slack = cells[pair[0]].measures.area_error + cells[pair[1]].measures.area_error;
        CHECK(std::abs(area - other) <= slack);
    }
    CHECK(surface <= box_surface(box) * (1 + 1e-6));
}

struct Maker {
    std::mt19937_64& rng;

    double number(double from, double to) { return std::uniform_real_distribution(from, to)(rng); }
    Vec3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
    Vec3 direction() {
        std::normal_distribution<double> normal;
        return Vec3(normal(rng), normal(rng), normal(rng)).normalized();
    }
    // Balls in a cube of half size 1 that do not hide each other.
    std::vector<Object> balls(int count, double largest) {
        std::vector<Sphere> balls;
        while (static_cast<int>(balls.size()) < count) {
            const Sphere ball{vector(0.8), number(0, largest)};
            const bool apart = std::ranges::all_of(balls, [&](const Sphere& b) {
                return (b.center - ball.center).norm() > std::abs(b.radius - ball.radius) + 0.05;
            });
            if (apart && ball.radius < 0.19) balls.push_back(ball);
        }
        return {balls.begin(), balls.end()};
    }
};

// Volume and areas by sampling rays evenly: along each the nearest site, and the angle at which the ray
// leaves.
Measures sampled(const Scene& scene, const RadialBaseProblem& problem, int rays) {
    const double far = 2 * scene.box.diagonal();
    Measures sum;
    sum.volume = sum.area = sum.box_area = 0;
    const auto add = [&](const Vec3& from, const Vec3& direction, double weight) {
        double t = far;
        Site owner;
        const auto meet = [&](Site site) {
            // How much nearer the base is falls along the ray.
            const auto room = [&](double x) {
                return distance_to(scene, site, from + x * direction) -
                       (site.is_object() ? x - problem.chart.radius : 0);
            };
            double low = 0, high = t;
            if (room(high) > 0) return;
            for (int k = 0; k < 50; ++k) (room(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
            t = low;
            owner = site;
        };
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) meet(Site::object(i));
        for (std::uint32_t side = 0; side < 6; ++side) meet(Site::box_side(side));
        // The gradient of a distance by differences.
        const double step = 1e-6 * far;
        Vec3 towards;
        for (int k = 0; k < 3; ++k) {
            const Vec3 e = step * Vec3::Unit(k), p = from + t * direction;
            towards[k] = (distance_to(scene, owner, p + e) - distance_to(scene, owner, p - e)) / (2 * step);
        }
        const Vec3 normal = ((owner.is_object() ? direction : Vec3(0, 0, 0)) - towards).normalized();
        const double power = problem.chart.is_sphere() ? t * t : t,
                     area = weight * power / normal.dot(direction);
        (owner.is_object() ? sum.area : sum.box_area) += area;
        sum.volume += weight * power * t / (problem.chart.is_sphere() ? 3 : 2);
    };
    if (problem.chart.is_sphere()) {
        // Fibonacci's sphere.
        for (int i = 0; i < rays; ++i) {
            const double z = 1 - (2 * i + 1.0) / rays, r = std::sqrt(1 - z * z),
                         angle = i * pi * (3 - std::sqrt(5.0));
            add(problem.frame.to_world(Vec3::Zero()), {r * std::cos(angle), r * std::sin(angle), z},
                4 * pi / rays);
        }
    } else {
        const int n = static_cast<int>(std::sqrt(rays));
        const double length = problem.stretch[1] - problem.stretch[0];
        for (int i = 0; i < n; ++i)
            for (int k = 0; k < n; ++k) {
                const double y = problem.stretch[0] + length * (i + 0.5) / n,
                             angle = 2 * pi * (k + 0.5 * (i % 2)) / n;
                const Vec3 foot = problem.frame.to_world({0, y, 0});
                const Vec3 tip = problem.frame.to_world({std::sin(angle), y, std::cos(angle)});
                add(foot, tip - foot, 2 * pi * length / (n * n));
            }
    }
    return sum;
}

void check_by_sampling(const Scene& scene) {
    const Cell cell = voronoi_cell(scene);
    const RadialBaseProblem problem = radial_base_problem(scene);
    const Measures& m = cell.measures;
    const Measures expected = sampled(scene, problem, 40'000);
    CHECK(m.volume == doctest::Approx(expected.volume).epsilon(2e-3));
    CHECK(m.area == doctest::Approx(expected.area).epsilon(5e-3));
    if (problem.chart.is_sphere())
        CHECK(m.box_area == doctest::Approx(expected.box_area).epsilon(5e-3));
    else
        CHECK(m.box_area > expected.box_area * (1 - 5e-3));  // the ends are not sampled
    CHECK(m.volume_error <= 1e-10 * m.volume);
    CHECK(m.area_error <= 1e-5 * (m.area + m.box_area));
    CHECK(m.body_volume < m.volume);
    // Largest first.
    std::vector<double> areas(scene.objects.size(), 0);
    for (const CellFace& face : cell.faces)
        if (face.site.is_object()) areas[face.site.index] += face.area;
    CHECK(std::ranges::is_sorted(cell.neighbors, std::greater(), [&](std::uint32_t i) { return areas[i]; }));
}

}  // namespace

TEST_CASE("quadrature: the nested rules are exact up to their degrees") {
    constexpr quadrature::NestedRule rule;
    for (int degree = 0; degree <= 23; ++degree) {
        std::array<double, 3> sum{};
        const auto add = [&](const quadrature::NestedRule::Node& node, double x) {
            const double power = std::pow(x, degree);
            sum[0] += node.weight * power;
            sum[1] += node.seven * power;
            sum[2] += node.gauss * power;
        };
        add(rule.center, 0);
        for (const double sign : {-1.0, 1.0}) {
            for (const auto& node : rule.first) add(node, sign * node.x);
            for (const auto& node : rule.rest) add(node, sign * node.x);
        }
        const double integral = degree % 2 == 0 ? 2.0 / (degree + 1) : 0;
        const auto is_exact = [&](int i) { return std::abs(sum[i] - integral) < 1e-15; };
        CAPTURE(degree);
        CHECK(is_exact(0));
        CHECK(is_exact(1) == (degree <= 11 || degree % 2 != 0));
        CHECK(is_exact(2) == (degree <= 5 || degree % 2 != 0));
    }
}

// 1 / (x^2 + b^2) along a line, whose poles are as near as b; what it is computed from is larger by a factor.
TEST_CASE("quadrature: estimates follow from how an integrand varies, not from what its terms are") {
    struct Integrand {
        double b, factor;

        std::array<double, 1> operator()(const span_integrals::SpanPoint<double>& p,
                                         std::array<double, 1>* sizes) const {
            const double f = p.x1 / (p.x * p.x + b * b);
            if (sizes != nullptr) *sizes = {factor * std::abs(f)};
            return {f};
        }
    };
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 1000; ++i) {
        const double b = std::pow(10, 1 - 2 * uniform(rng)), factor = std::pow(10, 4 * uniform(rng));
        const double from = -uniform(rng), to = uniform(rng);
        const std::array points{Eigen::Vector4d(from, 0, 0, 1), Eigen::Vector4d(to, 0, 0, 1)};
        std::array<Integral, 1> sum{};
        span_integrals::integrate_estimated(span_integrals::PowerSpan(points), Integrand{b, factor}, 1e-13,
                                            sum);
        CAPTURE(b);
        CAPTURE(factor);
        CHECK(std::abs(sum[0].value - (std::atan(to / b) - std::atan(from / b)) / b) <= sum[0].error);
        CHECK(sum[0].error <= 1e-12 * factor * sum[0].value);
    }
}

TEST_CASE("quadrature: derivatives are as exact as the span is small, however far away") {
    struct Chord {
        std::array<double, 2> operator()(const span_integrals::SpanPoint<double>& p) const {
            return {p.x1, p.y1};
        }
        std::array<ComplexBall, 2> operator()(const span_integrals::SpanPoint<ComplexBall>& p) const {
            return {p.x1, p.y1};
        }
        static std::array<double, 2> sizes(const span_integrals::SpanPoint<double>& p) {
            return {std::abs(p.x1), std::abs(p.y1)};
        }
    };
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int i = 0; i < 100; ++i) {
        const Eigen::Vector3d far(100 * uniform(rng), 100 * uniform(rng), uniform(rng)),
            step(1e-4 * uniform(rng), 1e-4 * uniform(rng), 0);
        std::array<Eigen::Vector4d, 6> points;
        for (int k = 0; k < 6; ++k) points[k] << far + k / 5.0 * step, 1;
        const span_integrals::PowerSpan span(points, points[0].head<3>());
        std::array<Integral, 2> sum{};
        span_integrals::integrate(span, Chord{}, sum);
        for (int c = 0; c < 2; ++c)
            CHECK(std::abs(sum[c].value - (points[5][c] - points[0][c])) <= 1e-14 * step.norm());
    }
}

TEST_CASE("radial measures: a ball alone fills the box") {
    const Box box{{-1, -2, -3}, {4, 2, 1}};
    for (const double radius : {0.0, 0.7}) {
        const Cell cell = voronoi_cell(over(Sphere{{0.1, 0.2, -0.4}, radius}, {}, box));
        const Measures& m = cell.measures;
        CHECK(m.volume == doctest::Approx(80).epsilon(1e-14));
        CHECK(std::abs(m.volume - 80) <= m.volume_error);
        CHECK(m.volume_error < 80e-12);
        CHECK(m.area == 0);
        CHECK(m.box_area == doctest::Approx(box_surface(box)).epsilon(1e-14));
        CHECK(m.base_area == doctest::Approx(4 * pi * radius * radius).epsilon(1e-14));
        CHECK(m.min_clearance == doctest::Approx(1.1 - radius).epsilon(1e-14));
        CHECK(m.max_clearance == doctest::Approx(Vec3(3.9, -2.2, -2.6).norm() - radius).epsilon(1e-14));
        CHECK(m.touches_box);
        CHECK(cell.neighbors.empty());
    }
}

TEST_CASE("radial measures: cells of balls tile the box") {
    std::mt19937_64 rng(test_seed());
    Maker make{rng};
    for (int i = 0; i < 10; ++i) {
        CAPTURE(i);
        check_tiling(make.balls(3 + 2 * i, i % 3 == 0 ? 0 : 0.19), cube(1), 1e-11);
    }
}

TEST_CASE("radial measures: cells of balls and a cylinder tile the box") {
    std::mt19937_64 rng(test_seed());
    Maker make{rng};
    for (int i = 0; i < 3; ++i) {
        CAPTURE(i);
        std::vector<Object> objects = make.balls(3, 0.19);
        objects.push_back(Cylinder{{1.5, 0.1, 0.3}, Vec3::UnitY(), 0.2});
        check_tiling(objects, {{-1, -1, -1}, {2, 1, 1}}, 1e-9);
    }
}

TEST_CASE("radial measures: cells of skew tubes tile the box") {
    check_tiling({Cylinder{{0, 0, -0.5}, Vec3::UnitX(), 0.2}, Cylinder{{0.1, 0.2, 0.3}, Vec3::UnitY(), 0.3},
                  Sphere{{0.5, -0.4, 0.8}, 0.1}},
                 cube(1), 1e-9);
}

TEST_CASE("radial measures: cells above a plane fill what is above it") {
    const Box box = cube(1);
    const Plane plane{{0, 0, -0.7}, {0, 0, 1}};
    const std::vector<Object> objects{Sphere{{-0.5, 0.1, -0.1}, 0.2}, Sphere{{-0.3, -0.6, 0.4}, 0.3},
                                      Cylinder{{0.5, 0, 0.4}, Vec3::UnitY(), 0.25}};
    const Cell floor = voronoi_cell(over(plane, objects, box));
    double volume = floor.measures.volume, error = floor.measures.volume_error;
    for (std::uint32_t i = 0; i < objects.size(); ++i) {
        std::vector<Object> others = objects;
        others[i] = plane;
        const Cell cell = voronoi_cell(over(objects[i], others, box));
        volume += cell.measures.volume;
        error += cell.measures.volume_error;
        double above = 0, below = 0;
        for (const CellFace& face : cell.faces)
            if (face.site == Site::object(i)) above += face.area;
        for (const CellFace& face : floor.faces)
            if (face.site == Site::object(i)) below += face.area;
        CHECK(above > 0);
        CHECK(std::abs(above - below) <= cell.measures.area_error + floor.measures.area_error);
    }
    CHECK(std::abs(volume - 4 * 1.7) <= error);
    CHECK(error < 1e-8);
}

TEST_CASE("radial measures: sampled scenes") {
    const std::vector<Object> tubes{Cylinder{{0.6, 0.2, 0.1}, {0.3, 1, 0.4}, 0.1},
                                    Cylinder{{-0.5, 0.3, -0.6}, {1, 0.5, -0.2}, 0.3},
                                    Cylinder{{0.1, -0.2, 0.8}, {0, 1, 0}, 0.05}};
    const std::vector<Object> rest{Plane{{0, 0, -0.9}, {0.1, 0.2, 1}}, Sphere{{-0.6, -0.5, 0.3}, 0.2}};
    for (int kind = 0; kind < 4; ++kind) {
        CAPTURE(kind);
        std::vector<Object> objects = kind % 2 ? rest : tubes;
        if (kind % 2) objects.push_back(tubes[0]);
        const Object base = kind < 2 ? Object(Sphere{{0.05, 0, 0.02}, 0.15})
                                     : Object(Cylinder{{0.05, 0, 0.02}, {0.1, 1, 0.2}, 0.15});
        check_by_sampling(over(base, objects, cube(1.2)));
    }
}

TEST_CASE("radial measures: scale with the scene") {
    std::mt19937_64 rng(test_seed());
    const std::vector<Object> balls = Maker{rng}.balls(9, 0.19);
    const Cell cell = voronoi_cell(over(balls[0], {balls.begin() + 1, balls.end()}, cube(1)));
    for (const double scale : {1e-6, 1e6}) {
        std::vector<Object> others;
        for (const Object& o : balls) {
            const auto& ball = std::get<Sphere>(o);
            others.push_back(Sphere{scale * ball.center, scale * ball.radius});
        }
        const Object base = others[0];
        others.erase(others.begin());
        const Measures m = voronoi_cell(over(base, others, cube(scale))).measures, &n = cell.measures;
        CHECK(m.volume == doctest::Approx(n.volume * scale * scale * scale).epsilon(1e-11));
        CHECK(m.area == doctest::Approx(n.area * scale * scale).epsilon(1e-11));
        CHECK(m.box_area == doctest::Approx(n.box_area * scale * scale).epsilon(1e-11));
        CHECK(m.min_clearance == doctest::Approx(n.min_clearance * scale).epsilon(1e-11));
        CHECK(m.max_clearance == doctest::Approx(n.max_clearance * scale).epsilon(1e-11));
    }
}

TEST_CASE("radial measures: the length of a conic around a cylinder is within its proven bound") {
    // A parabola in the end's plane about the base's axis, |p| - r = (x + z + 2) / sqrt 2.
    const double r = 0.5;
    const Cell cell =
        voronoi_cell(over(Cylinder{Vec3::Zero(), {0, 2, 0}, r}, {Plane{{0, -1, -2}, {2, 0, 2}}}, cube(4)));
    int checked = 0;
    for (const CellEdge& e : cell.edges) {
        if (e.kind != CurveKind::Parabola) continue;
        ++checked;
        CHECK_FALSE(e.is_estimated);
        // With s across the axis of the parabola and f its distance from focus to directrix: s^2 / (2 f) +
        // const.
        const double f = std::sqrt(2) + r;
        const auto across = [](const Vec3& p) { return (p.x() - p.z()) / std::sqrt(2); };
        const auto primitive = [f](double s) {
            return 0.5 * (s * std::hypot(1, s / f) + f * std::asinh(s / f));
        };
        const double length = std::abs(primitive(across(e.curve.points.back().head<3>())) -
                                       primitive(across(e.curve.points.front().head<3>())));
        CHECK(std::abs(e.length - length) <= e.length_error + 1e-14 * length);
        CHECK(e.length_error < 1e-10);
    }
    CHECK(checked >= 2);
}

// The area between the axis and a line that all but meets it is what is left of much larger products.
TEST_CASE("radial measures: a line along the ray has the rounding of all of its length") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int i = 0; i < 100; ++i) {
        const double x = uniform(rng), z = uniform(rng), aside = 1e-9 * uniform(rng);
        const std::array points{Eigen::Vector4d(x, 0.5, z, 1),
                                Eigen::Vector4d(3 * x + aside * z, 0.5, 3 * z - aside * x, 1)};
        const RadialFace side = radial_integrals::FlatFace(Plane{{0, 0.5, 0}, {0, 1, 0}}, {0, 0.5, 0});
        RadialIntegrals sum;
        add_span(points, true, BaseShape::Cylinder, side, nullptr, sum);
        const auto wide = [](double a, double b) { return static_cast<long double>(a) * b; };
        const auto twice = wide(z, points[1].x()) - wide(x, points[1].z());
        CAPTURE(aside);
        CHECK(std::abs(sum.end_area.value - static_cast<double>(twice / 2)) <= sum.end_area.error);
        CHECK(sum.end_area.error <= 1e-12);
    }
}

TEST_CASE("radial measures: along steep rays what the budget leaves out is estimated") {
    // Seen from near where the line touches the base the bisector runs away along it.
    Scene scene = over(Cylinder{Vec3::Zero(), Vec3::UnitY(), 0.5},
                       {Cylinder{{0, 0.125, 0.5 * (1 + 1e-9)}, {0.6, 0.8, 0}, 0}}, cube(2));
    const RadialBaseProblem problem = radial_base_problem(scene);
    FormId line;
    for (const FormId f : problem.objects.ids())
        if (std::holds_alternative<Cylinder>(problem.objects[f])) line = f;
    REQUIRE(line.valid());
    const radial_integrals::SkewFace face(problem, line, std::get<Cylinder>(problem.objects[line]),
                                          {{0.1, 0.375, 0.1}, 0.01});
    const quadrature::Rule& rule = quadrature::rule();
    double most = 0;
    for (const double angle : {1e-2, 1e-3, 1e-4, 1e-5}) {
        for (const double side : {-1.0, 1.0}) {
            radial_integrals::Ray ray{{side * std::sin(angle), 0, std::cos(angle)},
                                      {std::cos(angle), 0, -side * std::sin(angle)},
                                      0.25,
                                      1};
            const radial_integrals::Share share = face.share(ray);
            constexpr int parts = 20000;
            const double half = 0.5 * (ray.y - face.start) / parts;
            double volume = 0;
            for (int k = 0; k < parts; ++k)
                for (int i = 0; i < quadrature::points / 2; ++i)
                    for (const double x : {-rule.x[i], rule.x[i]}) {
                        radial_integrals::Ray other = ray;
                        other.y = face.start + half * (2 * k + 1 + x);
                        const double t = face.distance(other);
                        volume -= half * rule.weight[i] * 0.5 * t * t;
                    }
            CAPTURE(angle);
            CHECK(std::abs(share.volume - volume) <= share.volume_rest + 1e-12 * std::abs(volume));
            CHECK(share.volume_rest <= 1e-9 * std::abs(volume));
            most = std::max(most, share.area_rest);
        }
    }
    CHECK(most > 0);
}

TEST_CASE("radial measures: faces as small as rounding are no larger than their boundary allows") {
    // Balls of a cubic lattice, each coordinate up to one unit in the last place off: where eight cells met
    // there are faces of that size. A flat face is no larger than a disk of its perimeter.
    std::mt19937 rng(1);
    std::uniform_int_distribution<int> step(-1, 1);
    int tiny = 0;
    for (int repeat = 0; repeat < 20; ++repeat) {
        std::vector<Object> balls;
        for (const double x : {-1.0, 0.0, 1.0})
            for (const double y : {-1.0, 0.0, 1.0})
                for (const double z : {-1.0, 0.0, 1.0}) {
                    if (x == 0 && y == 0 && z == 0) continue;
                    const auto off = [&](double value) { return value * (1 + 0x1p-52 * step(rng)); };
                    balls.push_back(Sphere{Vec3(off(x), off(y), off(z)), 0.25});
                }
        const Cell cell = voronoi_cell(over(Sphere{Vec3::Zero(), 0.25}, balls, cube(2.5)));
        std::vector<double> perimeters(cell.faces.size());
        for (std::size_t i = 0; i < cell.faces.size(); ++i)
            for (const TrimmedPatch& patch : cell.faces[i].patches)
                for (const auto& loop : patch.loops)
                    for (const TrimCurve& trim : loop)
                        if (trim.edge.has_value()) {
                            const CellEdge& edge = cell.edges[*trim.edge];
                            perimeters[i] += edge.length + edge.length_error;
                        }
        for (std::size_t i = 0; i < cell.faces.size(); ++i) {
            if (!(perimeters[i] < 1e-9)) continue;
            ++tiny;
            CHECK(cell.faces[i].area <= perimeters[i] * perimeters[i] / (4 * pi) + cell.faces[i].area_error);
        }
    }
    CHECK(tiny > 20);
}

TEST_CASE("radial measures: a ball between two big ones is a solid of revolution") {
    // t = k / (delta + c z), z the cosine of the angle from the axis, by Simpson's rule.
    for (const double rho : {1.0, 2.5, 3.4}) {
        for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 2, -2)}) {
            CAPTURE(rho);
            const double radius = 0.5, distance = 4, delta = rho - radius,
                         height = (distance + delta) * (distance - delta) / 2;
            const Vec3 c = distance * axis.normalized();
            const Measures m =
                voronoi_cell(over(Sphere{Vec3::Zero(), radius}, {Sphere{c, rho}, Sphere{-c, rho}}, cube(60)))
                    .measures;
            const double rim = height / delta;  // t at the equator
            const auto t = [&](double z) { return height / (delta + distance * z); };
            double volume = 0, area = 0;
            constexpr int steps = 200'000;
            for (int i = 0; i <= steps; ++i) {
                const double z = static_cast<double>(i) / steps, weight = (i == 0 || i == steps ? 1
                                                                           : i % 2              ? 4
                                                                                                : 2) /
                                                                          (3.0 * steps);
                const double slope = distance * t(z) * t(z) / height;
                volume += weight * t(z) * t(z) * t(z) / 3;
                area += weight * t(z) * std::sqrt(t(z) * t(z) + (1 - z * z) * slope * slope);
            }
            CHECK(m.volume == doctest::Approx(4 * pi * volume).epsilon(1e-12));
            CHECK(m.area == doctest::Approx(4 * pi * area).epsilon(1e-12));
            CHECK(m.min_clearance == doctest::Approx((distance - delta) / 2 - radius).epsilon(1e-13));
            CHECK(m.max_clearance == doctest::Approx(rim - radius).epsilon(1e-13));
            CHECK_FALSE(m.touches_box);
            CHECK(m.box_area == 0);
        }
    }
}

// The tip of the cone's bisector lies under the other tube's face, and where integrals along the base's axis
// start is as near to its height as they can.
TEST_CASE("radial measures: beside a tip volumes are as sharp as they state") {
    std::vector<std::array<double, 2>> volumes;
    for (const double side : {1.0, -1.0})
        for (const double tolerance : {0.0, 1e-10}) {
            Scene scene =
                over(Cylinder{{-side, 0, 0}, {side, 0, 0}, 1},
                     {HollowCone{{0, 0, -3}, {0, 0, 1}, 4, 5}, Cylinder{{-side, 1, 2}, {0, 0, 1}, 1}},
                     {Vec3::Constant(-4), Vec3::Constant(4)});
            if (tolerance > 0) scene.tolerance = tolerance;
            CellOptions options;
            options.complete = true;
            options.patches = false;  // none hold a face on both sides of a tip
            const Measures m = voronoi_cell(scene, options).measures;
            CHECK(m.volume_error < 1e-9);
            volumes.push_back({m.volume - m.volume_error, m.volume + m.volume_error});
        }
    for (const auto& a : volumes)
        for (const auto& b : volumes) CHECK(a[0] <= b[1]);
}

}  // namespace vcell::radial_measures_test
