/// Tubes in tubes, spheres and cones: cells against closed forms and against distances as they are.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/cell_changes.hpp"
#include "../../envelope/complete_measures.hpp"
#include "../../envelope/point_query.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"
#include "vessel_oracle.hpp"

namespace vcell::tubes_in_vessels_test {
namespace {

using namespace vessel_oracle;

Scene scene_of(const Cylinder& base, const std::vector<Object>& objects, const Box& box) {
    Scene scene;
    scene.base = base;
    scene.objects = objects;
    scene.box = box;
    return scene;
}

Vec3 axis_of(const Scene& scene) { return std::get<Cylinder>(scene.base).axis.normalized(); }

// The longest stretch of the axis all of whose circles lie inside the sides that it runs into.
std::array<double, 2> stretch_of(const Scene& scene) {
    const auto& base = std::get<Cylinder>(scene.base);
    const Vec3 d = axis_of(scene);
    std::array<double, 2> range{-1e9, 1e9};
    for (int k = 0; k < 3; ++k)
        for (const double sign : {-1.0, 1.0}) {
            const double along = sign * d[k], bound = sign * (sign < 0 ? scene.box.min[k] : scene.box.max[k]),
                         room = bound - sign * base.point[k] - base.radius * std::sqrt(1 - along * along);
            if (along > 0) range[1] = std::min(range[1], room / along);
            if (along < 0) range[0] = std::max(range[0], room / along);
        }
    return range;
}

// How far the cell reaches from a point of the axis.
double reach_across(const Scene& scene, const Vec3& from, const Vec3& u) {
    const auto& base = std::get<Cylinder>(scene.base);
    double low = 0, high = scene.box.diagonal();
    for (int i = 0; i < 60; ++i) {
        const double t = 0.5 * (low + high);
        const Vec3 p = from + t * u;
        bool is_in = inside_box(scene.box, p) >= 0;
        for (std::size_t k = 0; k < scene.objects.size(); ++k)
            is_in = is_in && (!scene.competes(k) || away(scene.objects[k], p) >= t - base.radius);
        (is_in ? low : high) = t;
    }
    return low;
}

double sampled_cell(const Scene& scene, int rows) {
    const auto& base = std::get<Cylinder>(scene.base);
    const Vec3 d = axis_of(scene), x = d.unitOrthogonal(), z = x.cross(d);
    const auto [first, last] = stretch_of(scene);
    double sum = 0;
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < 4 * rows; ++k) {
            const double y = std::lerp(first, last, (i + 0.5) / rows), phi = 0.5 * pi * (k + 0.5) / rows;
            const double t = reach_across(scene, base.point + y * d, std::cos(phi) * x + std::sin(phi) * z);
            sum += t * t / 2;
        }
    return sum * (last - first) / rows * pi / (2 * rows);
}

void check_against_distances(const Scene& scene, const Cell& cell, std::mt19937_64& rng) {
    const auto& base = std::get<Cylinder>(scene.base);
    CHECK(cell.measures.volume == doctest::Approx(sampled_cell(scene, 40)).epsilon(6e-3));
    for (const CellVertex& v : cell.vertices) {
        const double slop = 4 * v.error + 1e-13 * scene.box.diagonal();
        CHECK(std::abs(away(base, v.point) - v.radius) <= slop);
        for (const Site& s : v.sites)
            if (s.is_object()) CHECK(std::abs(away(scene.objects[s.index], v.point) - v.radius) <= slop);
        for (std::size_t k = 0; k < scene.objects.size(); ++k)
            if (scene.competes(k)) CHECK(away(scene.objects[k], v.point) >= v.radius - slop);
    }
    PointQuery query(scene);
    std::uniform_real_distribution<double> unit(0, 1);
    const Vec3 d = axis_of(scene), x = d.unitOrthogonal(), z = x.cross(d);
    const auto [first, last] = stretch_of(scene);
    for (int i = 0; i < 50; ++i) {
        const double phi = 2 * pi * unit(rng);
        const Vec3 u = std::cos(phi) * x + std::sin(phi) * z,
                   from = base.point + std::lerp(first, last, unit(rng)) * d;
        const double t = reach_across(scene, from, u);
        const auto answer = query(from + 0.5 * t * u);
        REQUIRE(answer);
        CHECK(answer->clearance == doctest::Approx(t - base.radius).epsilon(1e-9).scale(base.radius));
        CHECK(t - base.radius >= cell.measures.min_clearance - 1e-6);
        CHECK(t - base.radius <= cell.measures.max_clearance + 1e-6);
    }
}

// Balls and tubes that keep clear of each other, of the base and of the wall.
Scene packed_about(const Cylinder& base, const Object& vessel, std::size_t balls, std::size_t tubes,
                   const Box& box, std::mt19937_64& rng) {
    Scene scene = scene_of(base, {}, box);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto [first, last] = stretch_of(scene);
    std::vector<Sphere> found;
    for (int tries = 0; found.size() < balls && tries < 100'000; ++tries) {
        Sphere ball;
        for (int k = 0; k < 3; ++k) ball.center[k] = std::lerp(box.min[k], box.max[k], unit(rng));
        ball.radius = 0.05 + 0.1 * unit(rng);
        if (away(vessel, ball.center) < 0.5 * ball.radius || away(base, ball.center) < 1.05 * ball.radius)
            continue;
        if (std::ranges::all_of(found, [&](const Sphere& o) { return away(o, ball.center) >= ball.radius; }))
            found.push_back(ball);
    }
    REQUIRE(found.size() == balls);
    scene.objects.assign(found.begin(), found.end());
    const Vec3 d = axis_of(scene), x = d.unitOrthogonal(), z = x.cross(d);
    for (std::size_t k = 0; k < tubes; ++k) {
        const double phi = 2 * pi * unit(rng), away_from_axis = base.radius + 0.35 + 0.2 * unit(rng);
        const Vec3 u = std::cos(phi) * x + std::sin(phi) * z;
        scene.objects.push_back(
            Cylinder{base.point + std::lerp(first, last, unit(rng)) * d + away_from_axis * u,
                     k % 2 == 0 ? d : Vec3(d + 0.3 * (unit(rng) - 0.5) * x), 0.05});
    }
    scene.objects.push_back(vessel);
    return scene;
}

// ---- Closed forms ---------------------------------------------------------------------------------------

TEST_CASE("tubes in vessels: about a tube on the axis of a tube the cell is half of what is between") {
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(0, 0, -3)}) {
        const Scene scene = scene_of({{1, 2, 3}, axis, 0.5}, {HollowCylinder{{1, 2, 7}, {0, 0, 2}, 2.5}},
                                     {{-2, -1, 0}, {4, 5, 2}});
        const Cell cell = voronoi_cell(scene);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.vertices.empty());
        CHECK(cell.edges.size() == 2);
        CHECK(cell.faces[0].bisector == "circular cylinder");
        const Measures& m = cell.measures;
        const double t = 1.5, h = 2;
        CHECK(m.volume == doctest::Approx(pi * t * t * h).epsilon(1e-12));
        CHECK(m.area == doctest::Approx(2 * pi * t * h).epsilon(1e-12));
        CHECK(m.min_clearance == doctest::Approx(1).epsilon(1e-13));
        CHECK(m.max_clearance == doctest::Approx(1).epsilon(1e-13));
    }
}

// t + |t u - c| = P is an ellipse with its foci on both axes.
TEST_CASE("tubes in vessels: off the axis of a tube along it the cell is an elliptic cylinder") {
    for (const double off : {1e-6, 0.25, 1.0, 1.4375, 1.5}) {
        CAPTURE(off);
        const Scene scene = scene_of({{off, 0, 0}, {0, 0, 1}, 0.5}, {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 2}},
                                     {{-3, -3, 0}, {3, 3, 2}});
        const Cell cell = voronoi_cell(scene);
        REQUIRE(cell.faces.size() == 1);
        CHECK(cell.faces[0].bisector == "elliptic cylinder");
        const double a = 1.25, b = std::sqrt(a * a - 0.25 * off * off);
        CHECK(cell.measures.volume == doctest::Approx(2 * pi * a * b).epsilon(1e-11));
        CHECK(cell.measures.min_clearance == doctest::Approx(0.5 * (1.5 - off)).epsilon(1e-12).scale(1e-3));
        CHECK(cell.measures.max_clearance == doctest::Approx(0.5 * (1.5 + off)).epsilon(1e-12));
    }
}

TEST_CASE("tubes in vessels: about a tube through the middle of a sphere") {
    const double R = 2, R0 = 0.25, P = R + R0, h = 1.5;
    const Scene scene =
        scene_of({{0, 0, 0}, {0, 0, 1}, R0}, {HollowSphere{{0, 0, 0}, R}}, {{-3, -3, -h}, {3, 3, h}});
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 1);
    // t = (P^2 - y^2) / (2 P)
    const double volume =
        2 * pi / (4 * P * P) * (std::pow(P, 4) * h - 2 * P * P * h * h * h / 3 + std::pow(h, 5) / 5);
    double area = 0;
    constexpr int steps = 100'000;
    for (int i = 0; i < steps; ++i) {
        const double y = -h + 2 * h * (i + 0.5) / steps;
        area += 2 * pi * (P * P - y * y) / (2 * P) * std::hypot(1, y / P) * 2 * h / steps;
    }
    CHECK(cell.measures.volume == doctest::Approx(volume).epsilon(1e-12));
    CHECK(cell.measures.area == doctest::Approx(area).epsilon(1e-8));
    CHECK(cell.measures.max_clearance == doctest::Approx(P / 2 - R0).epsilon(1e-12));
    CHECK(cell.measures.min_clearance == doctest::Approx((P * P - h * h) / (2 * P) - R0).epsilon(1e-6));
}

TEST_CASE("tubes in vessels: about a tube on the axis of a cone the cell is a cone's frustum") {
    const double R0 = 0.125;
    const Scene scene = scene_of({{0, 0, 0}, {0, 0, 1}, R0}, {HollowCone{{0, 0, -1}, {0, 0, 1}, 3, 5}},
                                 {{-3, -3, 0}, {3, 3, 2}});
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 1);
    CHECK(cell.faces[0].bisector == "circular cone");
    // 0.8 t = 0.6 h - (t - R0)
    const double low = (0.6 + R0) / 1.8, high = (1.8 + R0) / 1.8;
    CHECK(cell.measures.volume ==
          doctest::Approx(pi * 2 / 3 * (low * low + low * high + high * high)).epsilon(1e-12));
    CHECK(cell.measures.area ==
          doctest::Approx(pi * (low + high) * std::hypot(2, high - low)).epsilon(1e-12));
}

// The bisectors with two of the tubes meet along (3, 4), 5 from the axis, as far as that with a wall of
// radius 9.
TEST_CASE("tubes in vessels: a wall has faces where it comes nearer than where two tubes meet") {
    const auto with_wall = [](double R) {
        return scene_of({{0, 0, 0}, {0, 0, 1}, 1},
                        {Cylinder{{6, 0, 0}, {0, 0, 1}, 1}, Cylinder{{0, 8, 0}, {0, 0, 1}, 1},
                         Cylinder{{-6, 0, 0}, {0, 0, 1}, 1}, Cylinder{{0, -8, 0}, {0, 0, 1}, 1},
                         HollowCylinder{{0, 0, 0}, {0, 0, 1}, R}},
                        {{-20, -20, 0}, {20, 20, 1}});
    };
    for (const double R : {9 + 0x1p-40, 10.0}) {
        const Cell cell = voronoi_cell(with_wall(R));
        CHECK(cell.faces.size() == 4);
        CHECK(cell.measures.volume == doctest::Approx(48).epsilon(1e-12));
    }
    for (const double R : {9 - 0x1p-40, 8.5}) {
        const Cell cell = voronoi_cell(with_wall(R));
        CHECK(cell.faces.size() == 8);
        CHECK(owners(cell) == std::set<std::uint32_t>{0, 1, 2, 3, 4});
    }
}

// ---- Against distances ----------------------------------------------------------------------------------

TEST_CASE("tubes in vessels: random scenes, against distances alone") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const std::vector<Object> vessels{
        HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1}, HollowCylinder{{0.1, 0, 0}, {0.1, -0.05, 1}, 1},
        HollowSphere{{0, 0, 0.0625}, 1.25}, HollowCone{{0.1, 0, -1.5}, {0.1, 0, 1}, 3, 5}};
    for (int round = 0; round < 4 * rounds(); ++round) {
        const Object& vessel = vessels[static_cast<std::size_t>(round) % 4];
        CAPTURE(round);
        const bool is_along = round % 3 == 0;
        const Cylinder base{{0.3 * unit(rng), 0.3 * unit(rng), 0},
                            {is_along ? 0 : 0.25 * unit(rng), is_along ? 0 : 0.25 * unit(rng), 1},
                            0.05 + 0.05 * (1 + unit(rng))};
        const Scene scene = packed_about(base, vessel, 4 + static_cast<std::size_t>(round) % 9, 1,
                                         {{-1.5, -1.5, -0.5}, {1.5, 1.5, 0.5}}, rng);
        CellOptions options;
        options.patches = round % 2 == 0;
        check_against_distances(scene, voronoi_cell(scene, options), rng);
    }
}

TEST_CASE("tubes in vessels: turned, moved and in another order the cell is the same") {
    std::mt19937_64 rng(test_seed());
    for (const Object& vessel : {Object(HollowCylinder{{0, 0, 0}, {0.125, 0, 1}, 1}),
                                 Object(HollowCone{{0, 0, -1.5}, {0.125, 0, 1}, 3, 5})}) {
        const Scene scene = packed_about({{0.125, 0, 0}, {0, 0, 1}, 0.125}, vessel, 8, 2,
                                         {{-1.5, -1.5, -0.5}, {1.5, 1.5, 0.5}}, rng);
        const Cell cell = voronoi_cell(scene);
        Scene other = scene;
        // Axes and sides of the box go around, exactly.
        const auto turned = [](const Vec3& p) { return Vec3(p.z(), p.x(), p.y()); };
        const auto moved = [&](const Vec3& p) { return Vec3(turned(p) + Vec3(4, -2, 8)); };
        const auto change = [&](Object o) {
            if (auto* x = std::get_if<Sphere>(&o)) x->center = moved(x->center);
            if (auto* x = std::get_if<HollowCylinder>(&o)) *x = {moved(x->point), turned(x->axis), x->radius};
            if (auto* x = std::get_if<Cylinder>(&o)) *x = {moved(x->point), turned(x->axis), x->radius};
            if (auto* x = std::get_if<HollowCone>(&o)) {
                x->apex = moved(x->apex);
                x->axis = turned(x->axis);
            }
            return o;
        };
        std::vector<std::uint32_t> order(scene.objects.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
        std::ranges::shuffle(order, rng);
        other.base = change(scene.base);
        for (std::size_t i = 0; i < order.size(); ++i) other.objects[i] = change(scene.objects[order[i]]);
        other.box = {moved(scene.box.min), moved(scene.box.max)};
        const Cell same = voronoi_cell(other);
        CHECK(same.vertices.size() == cell.vertices.size());
        CHECK(same.edges.size() == cell.edges.size());
        CHECK(same.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-9));
        CHECK(same.measures.area == doctest::Approx(cell.measures.area).epsilon(1e-7));
        std::set<std::uint32_t> neighbors;
        for (const std::uint32_t n : same.neighbors) neighbors.insert(order[n]);
        CHECK(neighbors == owners(cell));
    }
}

TEST_CASE("tubes in vessels: vertices are told to more digits") {
    std::mt19937_64 rng(test_seed());
    const Scene scene =
        packed_about({{0.125, 0, 0}, {0.125, 0, 1}, 0.125}, HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1}, 6, 0,
                     {{-1.5, -1.5, -0.5}, {1.5, 1.5, 0.5}}, rng);
    const Cell cell = voronoi_cell(scene);
    int at_wall = 0;
    for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
        const auto& sites = cell.vertices[v].sites;
        const bool is_free = std::ranges::all_of(sites, [](const Site& s) { return s.is_object(); });
        if (!is_free || std::ranges::find(sites, Site::object(6)) == sites.end()) continue;
        ++at_wall;
        const auto refined = refine(cell, v, 200);
        REQUIRE(refined);
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = refined->box[static_cast<std::size_t>(k)].approximation();
        CHECK((p - cell.vertices[v].point).norm() <= cell.vertices[v].error + 1e-15);
    }
    CHECK(at_wall > 0);
}

TEST_CASE("tubes in vessels: what goes and comes again, the wall too, leaves the cell of all") {
    std::mt19937_64 rng(test_seed());
    const Scene scene =
        packed_about({{0.125, 0, 0}, {0.125, 0, 1}, 0.125}, HollowCone{{0, 0, -1.5}, {0, 0, 1}, 3, 5}, 8, 1,
                     {{-1.5, -1.5, -0.5}, {1.5, 1.5, 0.5}}, rng);
    const Cell cell = voronoi_cell(scene);
    for (const std::uint32_t i : {0u, 8u, 9u}) {
        CAPTURE(i);
        const Cell without = remove(cell, i), again = insert(without, scene.objects[i]);
        Scene fewer = scene;
        fewer.objects.erase(fewer.objects.begin() + i);
        CHECK(without.measures.volume == doctest::Approx(voronoi_cell(fewer).measures.volume).epsilon(1e-9));
        CHECK(again.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-9));
        CHECK(again.vertices.size() == cell.vertices.size());
    }
}

// ---- Whole diagrams -------------------------------------------------------------------------------------

// Is the volume of all cells the share of random points that are nearer to a body than to the wall?
void check_share_of_bodies(const DiagramScene& scene, std::mt19937_64& rng) {
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    double volume = 0, error = 0;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        CAPTURE(diagram.cells[i].reason);
        CHECK(diagram.cells[i].state ==
              (is_vessel(scene.objects[i]) ? DiagramCell::State::Wall : DiagramCell::State::Computed));
        volume += diagram.cells[i].volume;
        error += diagram.cells[i].volume_error;
    }
    std::uniform_real_distribution<double> unit(0, 1);
    constexpr int count = 100'000;
    int hits = 0;
    for (int i = 0; i < count; ++i) {
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = std::lerp(scene.box.min[k], scene.box.max[k], unit(rng));
        double body = 1e9, wall = 1e9;
        for (const Object& o : scene.objects) {
            double& least = is_vessel(o) ? wall : body;
            least = std::min(least, away(o, p));
        }
        hits += body < wall;
    }
    const double all = (scene.box.max - scene.box.min).prod(), share = static_cast<double>(hits) / count;
    CHECK(std::abs(volume - all * share) < 5 * all * std::sqrt(share * (1 - share) / count) + error);
}

TEST_CASE("tubes in vessels: cells of a diagram fill what is nearer to bodies than to walls") {
    std::mt19937_64 rng(test_seed());
    for (const Object& vessel :
         {Object(HollowCylinder{{0, 0, 0}, {0.0625, 0, 1}, 1}), Object(HollowSphere{{0, 0, 0.0625}, 1.25}),
          Object(HollowCone{{0.125, 0, -1.5}, {0, 0, 1}, 3, 5})}) {
        CAPTURE(vessel.index());
        DiagramScene scene;
        scene.objects = {Cylinder{{0.5, 0, 0}, {0, 0, 1}, 0.125},
                         Cylinder{{-0.25, 0.375, 0}, {0.125, 0, 1}, 0.0625},
                         Cylinder{{-0.25, -0.375, 0}, {0, 0.125, 1}, 0},
                         Sphere{{0.125, 0.125, 0.25}, 0.125},
                         Sphere{{0, -0.125, -0.25}, 0.1875},
                         vessel};
        scene.box = {{-1.25, -1.25, -0.5}, {1.25, 1.25, 0.5}};
        check_share_of_bodies(scene, rng);
    }
}

// ---- What is refused ------------------------------------------------------------------------------------

TEST_CASE(
    "tubes in vessels: a tube that comes out of its vessel, and one that is beyond the wall, are refused") {
    const Box box{{-3, -3, -1}, {3, 3, 1}};
    const std::string touches = kind(InputError::Kind::TouchesBase);
    const HollowCylinder tube{{0, 0, 0}, {0, 0, 1}, 1};
    const auto with = [&](const Cylinder& base, const Object& vessel, const Box& in) {
        return complaint(scene_of(base, {vessel}, in));
    };
    const std::string of_tube = "objects[0].hollow_cylinder" + touches;
    // Just in, touching by what is left of it beyond the wall, and out.
    CHECK(with({{1.0625, 0, 0}, {0, 0, 1}, 0.125}, tube, box) == "none");
    CHECK(with({{1.125, 0, 0}, {0, 0, 1}, 0.125}, tube, box) == of_tube);
    CHECK(with({{2, 0, 0}, {0, 0, 1}, 0.125}, tube, box) == of_tube);
    // Across, where a box in the vessel cuts it off, and where none does.
    CHECK(with({{0, 0.5, 0}, {1, 0, 0}, 0.125}, tube, {{-0.5, -1, -0.5}, {0.5, 1, 0.5}}) == "none");
    CHECK(with({{0, 0.5, 0}, {1, 0, 0}, 0.125}, tube, box) == of_tube);
    CHECK(with({{0, 0, 0}, {0, 0, 1}, 0.125}, HollowSphere{{0, 0, 0}, 0.75}, box) ==
          "objects[0].hollow_sphere" + touches);
    CHECK(with({{0, 0, 0}, {0, 0, 1}, 0.125}, HollowCone{{0, 0, -0.5}, {0, 0, 1}, 3, 5}, box) ==
          "objects[0].hollow_cone" + touches);
    // The other half of a cone counts for nothing.
    CHECK(with({{0, 0, 0}, {0, 0, 1}, 0.125}, HollowCone{{0, 0, 3}, {0, 0, 1}, 3, 5}, box) ==
          "objects[0].hollow_cone" + touches);
}

TEST_CASE("tubes in vessels: in a diagram what is beyond the wall is empty, and all else has its share") {
    using State = DiagramCell::State;
    std::mt19937_64 rng(test_seed());
    DiagramScene scene;
    scene.box = {{-1.5, -1.5, -1}, {1.5, 1.5, 1}};
    const auto with = [&](const Object& vessel, const Cylinder& tube) {
        scene.objects = {Sphere{{0.25, 0, 0}, 0.25}, tube, vessel, Cylinder{{-0.25, 0, 0}, {0, 0, 1}, 0.125}};
    };
    const auto expect_beyond = [&](const Object& vessel, const Cylinder& tube) {
        with(vessel, tube);
        const VoronoiDiagram diagram = voronoi_diagram(scene);
        CHECK(diagram.cells[0].state == State::Computed);
        CHECK(diagram.cells[1].state == State::Empty);
        CHECK(diagram.cells[1].reason == "lies beyond the wall of object 2");
        CHECK(diagram.cells[2].state == State::Wall);
        CHECK(diagram.cells[3].state == State::Computed);
    };
    const HollowCylinder tube{{0, 0, 0}, {0, 0, 1}, 1};
    const HollowSphere ball{{0, 0, 0}, 1.25};
    expect_beyond(tube, {{1.125, 0, 0}, {0, 0, 2}, 0.125});
    expect_beyond(tube, {{1.25, 1, 0}, {0, 0, -1}, 0});
    expect_beyond(ball, {{1.5, 0, 0}, {0, 1, 0}, 0.25});
    expect_beyond(HollowCone{{0, 0, -2}, {0, 0, 1}, 3, 5}, {{0, 0, -2.5}, {1, 0, 0}, 0.25});
    // They come out through the wall, in the box or beyond it.
    for (const auto& [vessel, across] :
         {std::pair<Object, Cylinder>{tube, {{1.125, 0, 0}, {0.125, 0, 1}, 0.125}},
          {tube, {{0, 0.75, 0}, {1, 0, 0.25}, 0.125}},
          {tube, {{0, -0.625, 0}, {1, 0.125, 0}, 0.0625}},
          {ball, {{0, 0.75, 0}, {1, 0, 0.25}, 0.125}},
          {ball, {{0, -0.625, 0}, {1, 0, 0}, 0.0625}}}) {
        with(vessel, across);
        check_share_of_bodies(scene, rng);
    }
}

// t = (P^2 - y^2) / (2 P) as above, between where that is 0.
TEST_CASE("tubes in vessels: a tube that comes out of a sphere has all of its cell") {
    const double R = 2, R0 = 0.25, P = R + R0;
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 1, 1), Vec3(0.25, -0.5, 1)}) {
        const Scene scene =
            scene_of({{0, 0, 0}, axis, R0}, {HollowSphere{{0, 0, 0}, R}}, {{-3, -3, -3}, {3, 3, 3}});
        const CompleteMeasures m = complete_measures(scene);
        CHECK(m.volume == doctest::Approx(4 * pi * P * P * P / 15).epsilon(1e-12));
        CHECK(m.volume_error < 1e-5);
        CHECK(m.volume_error > 0);
    }
}

// Across a hollow tube along z, with D the sum of the radii, a ray from (x, 0, 0) at the angle phi is met at
// t with sqrt(x^2 + t^2 cos^2 phi) = D - t: at x = 0 and upright, in a tip, as at no other place t has no
// derivative.
TEST_CASE("tubes in vessels: tips of the bisector across a tube are measured") {
    const double R = 1, R0 = 0.125, D = R + R0;
    for (const double half : {0.5, 0.875}) {
        CAPTURE(half);
        double volume = 0;
        constexpr int parts = 500;
        for (int i = 0; i < parts; ++i)
            for (int k = 0; k < parts; ++k) {
                const double x = half * (i + 0.5) / parts, sine = std::sin(0.5 * pi * (k + 0.5) / parts),
                             square = D * D - x * x;
                const double t = square / (D + std::sqrt(D * D - sine * sine * square));
                volume += 0.5 * t * t;
            }
        volume *= 8 * half * 0.5 * pi / parts / parts;
        const Scene scene = scene_of({{0, 0, 0}, {1, 0, 0}, R0}, {HollowCylinder{{0, 0, 0}, {0, 0, 1}, R}},
                                     {{-half, -2, -1.5}, {half, 2, 1.5}});
        const Cell cell = voronoi_cell(scene);
        const Measures& m = cell.measures;
        CHECK(m.volume == doctest::Approx(volume).epsilon(1e-5));
        CHECK(std::abs(m.volume - volume) <= m.volume_error + 1e-5 * volume);
        CHECK(m.volume_error < 1e-4);
        CHECK(m.max_clearance == doctest::Approx(R).epsilon(1e-12));
    }
}

TEST_CASE("tubes in vessels: random tubes across a cone or a tube, with tips, against distances") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> part(-1, 1);
    int decided = 0;
    for (int round = 0; round < 4 * rounds(); ++round) {
        CAPTURE(round);
        const Vec3 lean(0.25 * part(rng), 0.25 * part(rng), 1);
        const Object vessel = round % 2 == 0 ? Object(HollowCone{{0, 0, -2}, lean, 3, 5})
                                             : Object(HollowCylinder{{0.25 * part(rng), 0, 0}, lean, 1});
        const Cylinder base{{0, 0.25 * part(rng), 0.25 * part(rng)}, {1, 0.5 * part(rng), 0}, 0.125};
        const Scene scene =
            scene_of(base, {Sphere{{0.25, 0.75, 0.25}, 0.125}, vessel}, {{-0.5, -4, -1.75}, {0.5, 4, 4}});
        // An edge may come too near to a tip.
        std::optional<Cell> cell;
        try {
            cell = voronoi_cell(scene);
        } catch (const UndecidedError& e) {
            CHECK(std::string(e.what()).find("equally near along a curve") != std::string::npos);
            continue;
        }
        check_against_distances(scene, *cell, rng);
        ++decided;
    }
    CHECK(2 * decided > 4 * rounds());
}

TEST_CASE("tubes in vessels: a face about a hidden tip is measured") {
    const Scene scene =
        scene_of({{0, 0.0625, 0}, {1, 0.125, 0}, 0.125}, {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1}},
                 {{-0.75, -2, -0.5}, {0.75, 2, 0.5}});
    const Cell cell = voronoi_cell(scene);
    CHECK(cell.measures.volume == doctest::Approx(sampled_cell(scene, 40)).epsilon(6e-3));
}

TEST_CASE("tubes in vessels: a side of the box that touches the cell all along a line has no face") {
    const Box box{Vec3::Constant(-3), Vec3::Constant(3)};
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(0, 3, 4), Vec3(0, 1, 2)})
        for (const double radius : {0.0, 0.5})
            for (const bool is_cap : {false, true}) {
                CAPTURE(axis.transpose());
                CAPTURE(radius);
                CAPTURE(is_cap);
                // What is as near to the wall touches the side +x. A box that is wider there has the same
                // cell, but for where a line's ends.
                const double reach = 2;
                const Cylinder base{{1, 0, 0}, axis, radius};
                Scene scene = scene_of(base, {}, box);
                if (is_cap)
                    scene.probe = reach - radius;
                else
                    scene.objects = {HollowCylinder{{1, 0, 0}, -2 * axis, 2 * reach - radius}};
                const Cell cell = voronoi_cell(scene);
                CHECK(std::ranges::count(cell.faces, Site::box_side(1), &CellFace::site) == 0);
                Scene wide = scene;
                wide.box.max.x() = 4;
                CHECK(cell.measures.volume ==
                      doctest::Approx(voronoi_cell(wide).measures.volume).epsilon(1e-6));
                CHECK(complete_measures(scene).volume ==
                      doctest::Approx(complete_measures(wide).volume).epsilon(1e-6));
                // Where the wall is a little farther the side has a face.
                (is_cap ? *scene.probe : std::get<HollowCylinder>(scene.objects[0]).radius) += 1e-3;
                CHECK(std::ranges::count(voronoi_cell(scene).faces, Site::box_side(1), &CellFace::site) > 0);
            }
}

TEST_CASE("tubes in vessels: bisectors are named by what objects are to each other, however the tube leans") {
    const std::vector<std::pair<Vec3, double>> axes{// and how many of them the apex is away
                                                    {{0, 0, 2}, 4},
                                                    {{3, 4, 0}, 1.5},
                                                    {{1, 1, 0}, 5},
                                                    {{1, 2, 3}, 2}};
    for (const auto& [axis, away] : axes) {
        CAPTURE(axis.transpose());
        const Vec3 point(0.5, -0.25, 0.125),
            across = axis.x() == 0 ? Vec3(Vec3::UnitX()) : Vec3(axis.y(), -axis.x(), 0);
        const std::vector<std::pair<Object, std::string>> all{
            {HollowCylinder{point + 3 * axis, -axis, 3}, "circular cylinder"},
            {HollowCylinder{point + 3 * axis + 0.0625 * across, axis, 3}, "elliptic cylinder"},
            {HollowCone{point - away * axis, 2 * axis, 5, 13}, "circular cone"},
            {HollowCone{point - away * axis + 0.0625 * across, axis, 5, 13}, "quartic"},
            {Plane{point + 1.5 * across.normalized(), across}, "parabolic cylinder"}};
        for (const auto& [object, name] : all) {
            CAPTURE(name);
            const Cell cell =
                voronoi_cell(scene_of({point, axis, 0.5}, {object}, {Vec3::Constant(-3), Vec3::Constant(3)}));
            std::size_t faces = 0;
            for (const CellFace& f : cell.faces) {
                if (!f.site.is_object()) continue;
                ++faces;
                CHECK(f.bisector == name);
            }
            CHECK(faces > 0);
            // A cone along the tube has t = h tan - (t - R0) / cos at the height h over the apex.
            const auto* cone = std::get_if<HollowCone>(&object);
            if (cone == nullptr || name == "quartic") continue;
            const double sine = cone->sine(), cosine = cone->cosine();
            for (const CellVertex& v : cell.vertices) {
                if (std::ranges::none_of(v.sites, [](const Site& s) { return s.is_object(); })) continue;
                const double h = axis.normalized().dot(v.point - cone->apex);
                CHECK(v.radius == doctest::Approx((sine * h + 0.5) / (1 + cosine) - 0.5).epsilon(1e-9));
            }
        }
    }
}

}  // namespace
}  // namespace vcell::tubes_in_vessels_test
