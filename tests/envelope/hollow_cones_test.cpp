/// Balls in hollow cones: cells against closed forms and against distances as they are, whole diagrams of
/// them.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "../../core/errors.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../test_support.hpp"
#include "vessel_oracle.hpp"

namespace vcell::hollow_cones_test {
namespace {

using namespace vessel_oracle;
using Kind = InputError::Kind;

// ---- Closed forms ---------------------------------------------------------------------------------------

// A ball on the axis, which is z, of a cone with its apex in 0. Across the axis its cell is a disc: from
// |p - m| - R0 = S z - K r follows S^2 r = sqrt(L^2 - S^2 (z - h)^2) - K L, L = S z + R0.
struct OnAxis {
    double S, K, R0, h;

    double radius(double z) const {
        const double L = S * z + R0;
        return (std::sqrt(L * L - S * S * (z - h) * (z - h)) - K * L) / (S * S);
    }
    Scene scene(double low, double high, double side) const {
        Scene scene;
        scene.base = Sphere{{0, 0, h}, R0};
        scene.objects = {HollowCone{{0, 0, 0}, {0, 0, 2}, 3, 5}};
        scene.box = {{-side, -side, low}, {side, side, high}};
        return scene;
    }
};

template <class F>
double simpson(double from, double to, F f) {
    constexpr int parts = 400;
    double sum = 0;
    for (int i = 0; i <= parts; ++i)
        sum += f(std::lerp(from, to, static_cast<double>(i) / parts)) * (i == 0 || i == parts ? 1
                                                                         : i % 2 == 1         ? 4
                                                                                              : 2);
    return sum * (to - from) / parts / 3;
}

TEST_CASE("hollow cones: the bisector of a ball that reaches behind the apex has a tip there, too") {
    for (const double h : {0.25, 0.0, -0.25, -0.75}) {
        const OnAxis ball{0.6, 0.8, 0.5, h};
        // With theta the angle from the axis the wall is as near at P / (1 - S cos theta + K sin theta).
        const auto along = [&](double theta) {
            return (ball.S * h + ball.R0) / (1 - ball.S * std::cos(theta) + ball.K * std::sin(theta));
        };
        const double volume = simpson(
            0, pi, [&](double theta) { return 2 * pi / 3 * std::pow(along(theta), 3) * std::sin(theta); });
        const double area = simpson(0, pi, [&](double theta) {
            const double rise =
                (ball.S * std::sin(theta) + ball.K * std::cos(theta)) * along(theta) / (ball.S * h + ball.R0);
            return 2 * pi * std::pow(along(theta), 2) * std::sin(theta) * std::hypot(1, rise);
        });
        for (const bool patches : {false, true}) {
            CAPTURE(h);
            CAPTURE(patches);
            CellOptions options;
            options.patches = patches;
            const Cell cell = voronoi_cell(ball.scene(-4, 4, 4), options);
            CHECK(cell.faces.size() == 1);
            CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error + 1e-6 * volume);
            CHECK(std::abs(cell.measures.area - area) <= cell.measures.area_error + 1e-6 * area);
        }
    }
}

TEST_CASE("hollow cones: all around a ball on the axis, between sides of the box") {
    const OnAxis ball{0.6, 0.8, 0.5, 2};
    const double low = 1.375, high = 3;
    CellOptions options;
    options.patches = false;
    const Cell cell = voronoi_cell(ball.scene(low, high, 4), options);
    const double volume = simpson(low, high, [&](double z) { return pi * ball.radius(z) * ball.radius(z); });
    const double area = simpson(low, high, [&](double z) {
        const double step = 1e-5, slope = (ball.radius(z + step) - ball.radius(z - step)) / (2 * step);
        return 2 * pi * ball.radius(z) * std::sqrt(1 + slope * slope);
    });
    CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error + 1e-9);
    CHECK(cell.measures.volume_error < 1e-6);
    CHECK(std::abs(cell.measures.area - area) <= cell.measures.area_error + 1e-8);
    CHECK(cell.measures.min_clearance == doctest::Approx(2 - low - 0.5).epsilon(1e-13));
    CHECK(cell.measures.max_clearance ==
          doctest::Approx(std::hypot(ball.radius(high), high - 2) - 0.5).epsilon(1e-6));
}

TEST_CASE("hollow cones: beside the axis sides of the box cut the discs") {
    const OnAxis ball{0.6, 0.8, 0.5, 2};
    const double low = 1.375, high = 3, b = 0.25, c = 0.5;
    Scene scene = ball.scene(low, high, 4);
    scene.box.min.x() = -b;
    scene.box.min.y() = -c;
    const Cell cell = voronoi_cell(scene);
    check_volume(scene, cell);
    check_vertices(cell);
    const double volume = simpson(low, high, [&](double z) {
        const double r = ball.radius(z);
        const auto strip = [&](double x) {  // of the half disc, between 0 and x
            return 0.5 * (x * std::sqrt(r * r - x * x) + r * r * std::asin(x / r));
        };
        return 0.25 * pi * r * r + strip(b) + strip(c) + b * c;
    });
    CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error + 1e-9);
    CHECK(cell.measures.volume_error < 1e-6);
    for (const CellFace& face : cell.faces)
        if (face.site == Site::object(0)) CHECK(face.bisector == "quartic");
}

// ---- Distances alone ------------------------------------------------------------------------------------

// The faces' areas by sites: with n the unit direction from what is nearest, u that of the ray, the face is
// steeper than the sphere at its distance by sqrt(2 / (1 - u.n)).
double sampled_area(const Scene& scene, std::uint32_t site, int rows) {
    const auto& base = std::get<Sphere>(scene.base);
    double sum = 0;
    for (int i = 0; i < rows; ++i) {
        const double z = -1 + 2 * (i + 0.5) / rows, r = std::sqrt(1 - z * z);
        for (int k = 0; k < 2 * rows; ++k) {
            const double phi = pi * (k + 0.5) / rows;
            const Vec3 u(r * std::cos(phi), r * std::sin(phi), z);
            const double t = reach_along(scene, u);
            const Vec3 p = base.center + t * u;
            if (std::abs(away(scene.objects[site], p) - (t - base.radius)) > 1e-9) continue;
            Vec3 n;
            for (int j = 0; j < 3; ++j) {
                const Vec3 step = 1e-6 * Vec3::Unit(j);
                n[j] = (away(scene.objects[site], p + step) - away(scene.objects[site], p - step)) / 2e-6;
            }
            sum += t * t * std::sqrt(2 / (1 - u.dot(n)));
        }
    }
    return sum * 2 * pi / rows / rows;
}

// Upright, leaning, narrow and wide ones, around the box that balls are packed in.
std::vector<HollowCone> some_cones() {
    return {{{0, 0, -2}, {0, 0, 1}, 3, 5},
            {{0.125, -0.25, -2.5}, {0.25, -0.125, 1}, 1, 2.5},
            {{0.5, 0, 4}, {-0.125, 0, -2}, 0.25, 1},
            {{0, 0, -1.5}, {0, 0.0625, 1}, 0.75, 0.8125}};
}
const Box packing{{-1.25, -1.25, -0.75}, {1.25, 1.25, 0.75}};

// The base is the ball that is nearest to the wall.
Scene at_wall(std::mt19937_64& rng, const HollowCone& vessel) {
    Scene scene = packed(rng, vessel, 40, packing);
    const auto nearest = std::ranges::min_element(scene.objects, {}, [&](const Object& o) {
        const auto* ball = std::get_if<Sphere>(&o);
        return ball != nullptr ? away(vessel, ball->center) - ball->radius : 1;
    });
    std::swap(scene.base, *nearest);
    return scene;
}

// Faces may reach far around the axis, and no patch would hold them.
CellOptions without_patches() {
    CellOptions options;
    options.patches = false;
    return options;
}

TEST_CASE("hollow cones: random balls, against distances alone") {
    std::mt19937_64 rng(test_seed());
    int vertices = 0;
    for (int round = 0; round < rounds(); ++round)
        for (const HollowCone& vessel : some_cones()) {
            CAPTURE(vessel.apex.z());
            const Scene scene = at_wall(rng, vessel);
            const Cell cell = voronoi_cell(scene, without_patches());
            check_volume(scene, cell);
            check_vertices(cell);
            check_queries(scene, rng, 60);
            const auto wall = static_cast<std::uint32_t>(scene.objects.size() - 1);
            double area = 0;
            for (const CellFace& face : cell.faces)
                if (face.site == Site::object(wall)) area += face.area;
            CHECK(area == doctest::Approx(sampled_area(scene, wall, 60)).epsilon(0.03));
            for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
                const auto& sites = cell.vertices[i].sites;
                if (std::ranges::find(sites, Site::object(wall)) == sites.end()) continue;
                CHECK(refine(cell, i, 200).has_value());
                ++vertices;
            }
        }
    CHECK(vertices > 10);
}

TEST_CASE("hollow cones: patches lie on the bisector, and hold what the cell without them has") {
    std::mt19937_64 rng(test_seed());
    int patches = 0;
    for (const HollowCone& vessel : some_cones()) {
        const Scene scene = at_wall(rng, vessel);
        const auto wall = static_cast<std::uint32_t>(scene.objects.size() - 1);
        const auto& base = std::get<Sphere>(scene.base);
        const Cell bare = voronoi_cell(scene, without_patches());
        const Cell cell = voronoi_cell(scene);
        CHECK(std::abs(cell.measures.volume - bare.measures.volume) <=
              cell.measures.volume_error + bare.measures.volume_error + 1e-12);
        for (const CellFace& face : cell.faces) {
            if (face.site != Site::object(wall)) continue;
            for (const TrimmedPatch& patch : face.patches) {
                const RationalPatch& s = patch.surface;
                for (int i = 0; i <= 4; ++i)
                    for (int k = 0; k <= 4; ++k) {
                        const Vec3 p = s.evaluate(std::lerp(s.domain_u[0], s.domain_u[1], i / 4.0),
                                                  std::lerp(s.domain_v[0], s.domain_v[1], k / 4.0));
                        CHECK(std::abs((p - base.center).norm() - base.radius - away(vessel, p)) < 1e-9);
                    }
                ++patches;
            }
        }
    }
    CHECK(patches > 0);
}

TEST_CASE("hollow cones: cells of the same balls in another order and turned are the same") {
    std::mt19937_64 rng(test_seed());
    for (const HollowCone& vessel : some_cones()) {
        const Scene scene = at_wall(rng, vessel);
        const Cell cell = voronoi_cell(scene, without_patches());
        std::vector<std::uint32_t> order(scene.objects.size());
        for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
        std::ranges::shuffle(order, rng);
        // A quarter turn about z, exact but for the last digits of coordinates, and the radius and the slant
        // times three.
        const auto turned = [](const Vec3& p) { return Vec3(4 - p.y(), p.x() - 2, 8 + p.z()); };
        const auto moved = [&](const Object& o) -> Object {
            if (const auto* ball = std::get_if<Sphere>(&o)) return Sphere{turned(ball->center), ball->radius};
            const auto& cone = std::get<HollowCone>(o);
            return HollowCone{turned(cone.apex), turned(cone.axis) - turned(Vec3::Zero()), 3 * cone.radius,
                              3 * cone.slant};
        };
        Scene other;
        other.base = moved(scene.base);
        for (const std::uint32_t i : order) other.objects.push_back(moved(scene.objects[i]));
        const Vec3 a = turned(scene.box.min), b = turned(scene.box.max);
        other.box = {a.cwiseMin(b), a.cwiseMax(b)};
        const Cell same = voronoi_cell(other, without_patches());
        CHECK(same.vertices.size() == cell.vertices.size());
        CHECK(same.edges.size() == cell.edges.size());
        CHECK(same.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-9));
        CHECK(std::abs(same.measures.area - cell.measures.area) <=
              same.measures.area_error + cell.measures.area_error + 1e-9);
        std::set<std::uint32_t> neighbors;
        for (const std::uint32_t n : same.neighbors) neighbors.insert(order[n]);
        CHECK(neighbors == owners(cell));
    }
}

// ---- Ties -----------------------------------------------------------------------------------------------

TEST_CASE("hollow cones: ties of small integers are decided") {
    // The wall is 13 away from (3, 4, 12), as 0 is: 4/5 of the 20 from the apex less 3/5 of 5 from the axis.
    // Beneath, the box's edges are nearer until the wall crosses them far below.
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0};
    scene.objects = {HollowCone{{0, 0, -8}, {0, 0, 3}, 4, 5}};
    scene.box = {{-3, -4, -0.125}, {3, 4, 12}};
    const Cell cell = voronoi_cell(scene);
    int four = 0;
    for (const CellVertex& v : cell.vertices) {
        if (v.point.z() < 11) continue;
        CHECK(v.radius == doctest::Approx(13).epsilon(1e-14));
        four += v.sites.size() == 4;
        const auto refined = refine(cell, static_cast<std::size_t>(&v - cell.vertices.data()), 200);
        REQUIRE(refined);
        CHECK(refined->tie_width < 1e-50);
    }
    CHECK(four == 4);
    CHECK(cell.report.decisions.assumed == 0);
    CHECK(cell.report.moved == 0);
    check_volume(scene, cell);
    check_vertices(cell);

    // The same cone by other numbers is one with it; one around it, which shares a generator with it, is
    // hidden, and so is what touches its wall from behind.
    Scene more = scene;
    more.objects.push_back(HollowCone{{0, 0, -8}, {0, 0, 0.5}, 8, 10});
    more.objects.push_back(HollowCone{{3, 0, -8 - 2.25}, {0, 0, 1}, 4, 5});
    CHECK(voronoi_cell(more).faces.size() == cell.faces.size());
    more.objects.push_back(HollowCone{{-3, 0, -8 - 2.25}, {0, 0, 1}, 4, 5});
    more.objects.push_back(Sphere{{4 + 3, 0, -8 + 3 - 4}, 5});
    more.objects.push_back(Plane{{0, 0, -8}, {3, 0, 4}});
    const Cell same = voronoi_cell(more);
    CHECK(same.vertices.size() == cell.vertices.size());
    CHECK(same.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-13));
    CHECK_FALSE(same.report.warnings.empty());
    CHECK(same.report.decisions.assumed == 0);

    // Balls that touch the wall and the base, all around it.
    Scene touching;
    touching.base = Sphere{{0, 0, 5}, 1};
    touching.objects = {HollowCone{{0, 0, 0}, {0, 0, 1}, 3, 5}};
    for (const Vec3& p : {Vec3(2, 0, 5), Vec3(-2, 0, 5), Vec3(0, 2, 5), Vec3(0, -2, 5)})
        touching.objects.push_back(Sphere{p, 1});
    touching.box = {{-4, -4, 4}, {4, 4, 6}};
    const Cell touched = voronoi_cell(touching);
    CHECK(touched.report.decisions.assumed == 0);
    check_volume(touching, touched);
    check_vertices(touched);
}

// ---- What is refused ------------------------------------------------------------------------------------

TEST_CASE("hollow cones: balls that overlap the wall have cells, those beyond it have none") {
    // The wall runs through (4, 0, 3) along (4, 0, 3); its normal is (-3, 0, 4) / 5.
    const auto cell_at = [](double beyond) {
        Scene scene;
        scene.base = Sphere{{4 + 0.6 * beyond, 0, 3 - 0.8 * beyond}, 0.5};
        scene.objects = {HollowCone{{0, 0, 0}, {0, 0, 1}, 4, 5}};
        scene.box = {{3, -1, 2}, {5.5, 1, 5}};
        return voronoi_cell(scene);
    };
    const Cell cell = cell_at(0.25);
    CHECK(cell.measures.min_clearance == doctest::Approx(0.5 * (-0.25 - 0.5)).epsilon(1e-13));
    CHECK_NOTHROW(cell_at(0.4375));
    for (const double beyond : {0.5 + 1e-12, 0.75}) {
        CAPTURE(beyond);
        try {
            cell_at(beyond);
            FAIL("has a cell");
        } catch (const InputError& e) {
            CHECK(e.kind == Kind::TouchesBase);
            CHECK(e.path == "objects[0].hollow_cone");
        }
    }
}

TEST_CASE("hollow cones: what is not supported is refused by name") {
    Scene scene = OnAxis{0.6, 0.8, 0.5, 2}.scene(1.375, 3, 4);
    CellOptions options;
    options.patches = false;
    CHECK(complaint(scene, options) == "none");
    const auto with = [&](const HollowCone& cone) {
        Scene other = scene;
        other.objects[0] = cone;
        return complaint(other, options);
    };
    CHECK(with({{0, 0, 0}, {0, 0, 0}, 3, 5}) == "objects[0].hollow_cone.axis" + kind(Kind::ZeroAxis));
    CHECK(with({{0, 0, 0}, {0, 0, 1}, 0, 5}) == "objects[0].hollow_cone.radius" + kind(Kind::NegativeRadius));
    CHECK(with({{0, 0, 0}, {0, 0, 1}, 5, 5}) == "objects[0].hollow_cone.slant" + kind(Kind::OutOfRange));
    CHECK(with({{0, 0, 0}, {0, 0, 1}, 3, NAN}) == "objects[0].hollow_cone.slant" + kind(Kind::NotFinite));
    Scene base = scene;
    base.base = HollowCone{};
    CHECK(complaint(base) == "base.hollow_cone" + kind(Kind::Unsupported));
    CHECK(complaint(scene) == "none");
}

// ---- Whole diagrams -------------------------------------------------------------------------------------

TEST_CASE("hollow cones: a hopper's diagram fills what is nearer to balls than to walls") {
    std::mt19937_64 rng(test_seed());
    // A tube on top of a cone that it meets at z = 0, where both are 1 wide, and an outlet with a plane.
    const HollowCone hopper{{0, 0, -0.75}, {0, 0, 1}, 4, 5};
    const HollowCylinder bin{{0, 0, 0}, {0, 0, 1}, 1};
    const double outlet = -0.5;
    std::uniform_real_distribution<double> unit(0, 1);
    DiagramScene silo;
    for (int tries = 0; silo.objects.size() < 70 && tries < 100'000; ++tries) {
        const Sphere ball{
            {2.5 * unit(rng) - 1.25, 2.5 * unit(rng) - 1.25, std::lerp(outlet, 0.75, unit(rng))},
            0.08 + 0.1 * unit(rng)};
        if (std::min({away(hopper, ball.center), away(bin, ball.center), ball.center.z() - outlet,
                      0.75 - ball.center.z()}) < ball.radius)
            continue;
        if (std::ranges::all_of(silo.objects,
                                [&](const Object& o) { return away(o, ball.center) >= ball.radius; }))
            silo.objects.push_back(ball);
    }
    REQUIRE(silo.objects.size() == 70);
    silo.objects.push_back(hopper);
    silo.objects.push_back(bin);
    silo.objects.push_back(Plane{{0, 0, outlet}, {0, 0, 1}});
    silo.objects.push_back(Sphere{{0.75, 0, -0.5}, 0.125});  // behind the hopper's wall
    silo.box = {{-1.25, -1.25, -0.625}, {1.25, 1.25, 0.75}};
    const VoronoiDiagram diagram = voronoi_diagram(silo);
    double sum = 0, error = 0;
    for (std::size_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        CAPTURE(i);
        CAPTURE(cell.reason);
        if (i + 1 == diagram.cells.size()) {
            CHECK(cell.state == DiagramCell::State::Empty);
            CHECK(cell.reason == "lies beyond the wall of object 70");
            continue;
        }
        const bool is_ball = std::holds_alternative<Sphere>(silo.objects[i]);
        const bool is_wall = is_vessel(silo.objects[i]);
        CHECK(cell.state == (is_wall ? DiagramCell::State::Wall : DiagramCell::State::Computed));
        sum += is_ball ? cell.volume : 0;
        error += is_ball ? cell.volume_error : 0;
    }
    const ContactTable table = contacts(diagram);
    CHECK(table.faults.empty());
    for (const std::uint32_t wall : {70u, 71u, 72u})
        CHECK(std::ranges::count_if(table.contacts, [&](const Contact& c) {
                  return c.first == wall || c.second == Site::object(wall);
              }) > 2);
    check_share_of_balls(silo.objects, silo.box, sum, error, rng);
}

}  // namespace
}  // namespace vcell::hollow_cones_test
