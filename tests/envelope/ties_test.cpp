// Corners and exact ties: what is known about them is not asked of intervals, and nothing of it is assumed.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <random>
#include <set>

#include "../../envelope/proofs/space_tie.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/forms/exact_heights.hpp"
#include "cell_checks.hpp"
#include "rotations.hpp"
#include "test_support.hpp"

namespace vcell::ties_test {

namespace {

Scene scene_around(const Object& base, double half, std::vector<Object> objects) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    scene.box = {Vec3::Constant(-half), Vec3::Constant(half)};
    return scene;
}

Scene scene_over(const Plane& base, std::vector<Object> objects) {
    Scene scene = scene_around(base, 1, std::move(objects));
    scene.tolerance = 1e-3;  // these tests are about what meets where
    return scene;
}

// Nothing is assumed, and vertices lie where they say, as far from their sites as from the base.
Cell check_decided(const Scene& scene) {
    Cell cell = voronoi_cell(scene);
    CHECK(cell.report.decisions.assumed == 0);
    CHECK(cell.vertices.size() >= 4);
    for (const CellVertex& v : cell.vertices) {
        CHECK(v.radius == doctest::Approx(testing::clearance(scene, v.point)).epsilon(1e-10));
        for (const Site site : v.sites)
            CHECK(std::abs(testing::boundary_residual(scene, site, v.point)) < 1e-10);
    }
    return cell;
}

// Nothing is assumed; vertices are as far from their objects as from the base, and from no other one less.
Cell check_decided_around(const Scene& scene) {
    Cell cell = voronoi_cell(scene);
    CHECK(cell.report.decisions.assumed == 0);
    CHECK(cell.vertices.size() >= 4);
    for (const CellVertex& v : cell.vertices) {
        const double r = testing::distance_to(scene.base, v.point);
        CHECK(std::abs(r - v.radius) <= v.error + 1e-13);
        for (const Site site : v.sites)
            if (site.is_object())
                CHECK(std::abs(testing::distance_to(scene.objects[site.index], v.point) - r) <=
                      2 * v.error + 1e-13);
        for (const Object& o : scene.objects)
            CHECK(testing::distance_to(o, v.point) >= r - 2 * v.error - 1e-13);
    }
    return cell;
}

// Vertices in which at least so many sites meet.
std::ptrdiff_t crowded_vertices(const Cell& cell, std::size_t sites) {
    return std::ranges::count_if(cell.vertices, [&](const CellVertex& v) { return v.sites.size() >= sites; });
}

std::vector<Object> square_bundle(const Eigen::Matrix3d& frame, double radius) {
    std::vector<Object> tubes;
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            if (i != 0 || j != 0)
                tubes.push_back(Cylinder{frame * Vec3(i, j, 0), frame * Vec3::UnitZ(), radius});
    return tubes;
}

}  // namespace

TEST_CASE("ties: two sides of the box meet in a corner of an oblique base region") {
    testing::check_geometry(
        check_decided(scene_over({{0, 0, 0}, {1, 2, -0.7}}, {Cylinder{{0.5, 1, -0.3}, {1, 0, 1.4}, 0.1}})));
}

TEST_CASE("ties: what ties along the rim is named along all of a side, and parts nothing there") {
    // A plane before the base is as near as the one beside the box all along the rim between them. Far lines
    // and tubes make the region be divided: on its parts the tie was named or not, with a vertex between.
    Scene scene;
    scene.base = Plane{{-1, -1, 1}, {0, 0, 1}};
    scene.objects = {Plane{{-6, 0, 4}, {-1, 0, 0}}, Plane{{-3, 0, 3}, {0, 0, -1}},
                     Cylinder{{-4, -1, 5}, {-1, -1, -1}, 0}};
    scene.box = {{-5, -5, -1}, {3, 2, 5}};
    const auto sites_of_ties = [](const Cell& cell) {
        std::vector<std::vector<Site>> all;
        for (const CellEdge& e : cell.edges)
            if (!e.extra_sites.empty()) {
                all.emplace_back(e.sites.begin(), e.sites.end());
                all.back().insert(all.back().end(), e.extra_sites.begin(), e.extra_sites.end());
                std::ranges::sort(all.back());
            }
        return all;
    };
    const Cell before_plane = voronoi_cell(scene);
    CHECK(before_plane.vertices.size() == 4);
    CHECK(sites_of_ties(before_plane) ==
          std::vector<std::vector<Site>>{{Site::object(0), Site::object(1), Site::box_side(0)}});

    // So is a tube, 2.5 from there in the direction (-3, 4) / 5.
    scene.objects.emplace_back(Cylinder{{-6.5, 0, 4}, {0, 1, 0}, 1.5});
    const Cell below_tube = voronoi_cell(scene);
    CHECK(below_tube.vertices.size() == 4);
    CHECK(sites_of_ties(below_tube) == std::vector<std::vector<Site>>{{Site::object(0), Site::object(1),
                                                                       Site::object(3), Site::box_side(0)}});

    // And of a cap.
    scene.base = Plane{{-1, -1, 0}, {0, 0, 1}};
    scene.objects = {Plane{{1, 4, -1}, {0, 1, 0}}, Cylinder{{-5, -7, 5}, {-2, 0, -2}, 2}};
    scene.box = {{-4, -6, -4}, {2, 3, 4}};
    scene.probe = 1;
    CHECK(sites_of_ties(voronoi_cell(scene)) ==
          std::vector<std::vector<Site>>{{Site::object(0), Site::box_side(3), Site::cap()}});
}

TEST_CASE("ties: tubes over tilted planes leave nothing undecided") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 12; ++i) {
        CAPTURE(i);
        const Vec3 n = Vec3(unit(rng), unit(rng), unit(rng)).normalized();
        const Vec3 e1 = n.unitOrthogonal(), e2 = n.cross(e1);
        const Plane base{{0.1, -0.2, 0.05}, n};
        std::vector<Object> objects;
        for (int k = 0; k < 3; ++k) {
            const double height = 0.6 + 0.3 * unit(rng);
            const Vec3 p = base.point + unit(rng) * e1 + unit(rng) * e2 + height * n;
            if (k == 0 || unit(rng) > 0)
                objects.push_back(Cylinder{p, unit(rng) * e1 + unit(rng) * e2, 0.2});
            else
                objects.push_back(Sphere{p, 0.5 * height});
        }
        check_decided(scene_over(base, std::move(objects)));
    }
}

TEST_CASE("ties: lines that cross over a corner or within the region tie with equal gradients, exactly") {
    const Plane base{{0, 0, 0}, {0, 0, 1}};
    Scene scene = scene_over(base, {Cylinder{{1, -2, 1}, {2, 0, 0}, 0}, Cylinder{{2, 1, 1}, {0, 1, 0}, 0}});
    scene.box = {{-2, -2, -2}, {2, 2, 4}};
    check_decided(scene);
    // Over a point of a side: a point, a line and a tube.
    scene.objects = {Sphere{{-1, 0, 2}, 0}, Cylinder{{-2, 1, 4}, {-1, -1, 0}, 0},
                     Cylinder{{0, 0, 4}, {-2, 1, 0}, 0}, Cylinder{{2, 1, 2}, {0, -2, 0}, 1},
                     Cylinder{{2, -1, 4}, {1, 0, 0}, 0}};
    check_decided(scene);
    // Over a point with thirds for coordinates.
    scene.objects = {Cylinder{{1.0 / 4, 0, 1}, {1, 4, 0}, 0}, Cylinder{{0, 1.0 / 4, 1}, {4, 1, 0}, 0}};
    check_decided(scene);
}

TEST_CASE("rational_near: finds quotients, and none near a root") {
    const Wide third = Wide(1.0) / Wide(3.0), x = Wide(22.0) / Wide(7.0), root = sqrt(Wide(2.0));
    for (const double extent : {1.0, 0x1p100, 0x1p-100}) {
        CAPTURE(extent);
        const auto p = rational_near(Wide(extent) * x, -(Wide(extent) * third), extent);
        REQUIRE(p);
        CHECK(Exact(7.0) * p->x == Exact(22 * extent) * p->w);
        CHECK(Exact(-3.0) * p->y == Exact(extent) * p->w);
        CHECK_FALSE(rational_near(Wide(extent) * root, Wide(0.0), extent));
    }
    const auto dyadic = rational_near(Wide(0.1), Wide(-0.75), 1);
    REQUIRE(dyadic);
    CHECK(dyadic->w == Exact(1.0));
    CHECK(dyadic->x == Exact(0.1));
}

TEST_CASE(
    "have_equal_gradients: of lines that cross over the point, not of those that pass each other's heights") {
    const Plane base{{0, 0, 0}, {0, 0, 1}};
    const auto problem = plane_base_problem(
        scene_over(base, {Cylinder{{0, 0, 0.5}, {1, 2, 0}, 0}, Cylinder{{0, 0, 0.5}, {2, -1, 0}, 0},
                          Sphere{{0.5, 0.5, 0.5}, 0}}));
    const FormFamily& family = problem.family;
    const auto form = [&](std::uint32_t object) {
        for (const FormId f : problem.sites.ids())
            if (problem.sites[f].front() == Site::object(object)) return f;
        FAIL("no form");
        return FormId();
    };
    const std::array lines{form(0), form(1)};
    const RationalPoint crossing{0.0, 0.0}, beside{3.0, 1.0, 10.0};
    CHECK(all_tie(family, lines, crossing));
    CHECK(have_equal_gradients(family, lines[0], lines[1], crossing));
    // Half-way between the lines (1, 2) and (2, -1): along (3, 1) and (-1, 3).
    CHECK(all_tie(family, lines, beside));
    CHECK_FALSE(have_equal_gradients(family, lines[0], lines[1], beside));
    CHECK(compare_exactly(family, lines[0], form(2), crossing) == Sign::Negative);
    CHECK(have_equal_slopes(family, lines[0], lines[1], beside, 1, -3));
}

TEST_CASE("ties: around a tube of a square bundle that was turned in doubles four meet in a line") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    for (int i = 0; i < 12; ++i) {
        CAPTURE(i);
        const Vec3 axis = Vec3(normal(rng), normal(rng), normal(rng)).normalized();
        const Eigen::Matrix3d frame = rotation_from_z(axis).toRotationMatrix();
        const double radius = i % 2 == 0 ? 0.2 : 0;
        const Vec3 own = i % 3 == 0 ? Vec3(-axis) : axis;  // the base may point against its bundle
        const Cell cell = check_decided_around(
            scene_around(Cylinder{Vec3::Zero(), own, radius}, 2, square_bundle(frame, radius)));
        for (const CellVertex& v : cell.vertices)
            for (const Site site : v.sites)
                if (site.kind == Site::Kind::End) CHECK((own.dot(v.point) > 0) == (site.index == 1));
        CHECK(cell.report.moved > 0);
        CHECK(cell.report.moved < 1e-13);
        std::set<Site> extra;
        for (const CellEdge& edge : cell.edges)
            extra.insert(edge.extra_sites.begin(), edge.extra_sites.end());
        CHECK(extra == std::set{Site::object(0), Site::object(2), Site::object(5), Site::object(7)});
    }
}

TEST_CASE("ties: parallel tubes touch the edge of two others around a ball in an irrational direction") {
    for (const double radius : {0.0, 0.25}) {
        CAPTURE(radius);
        const Cell cell = check_decided_around(scene_around(
            Sphere{Vec3::Zero(), radius}, 2, square_bundle(Eigen::Matrix3d::Identity(), radius)));
        for (const std::uint32_t corner : {0u, 2u, 5u, 7u})
            CHECK(std::ranges::count_if(cell.vertices, [&](const CellVertex& v) {
                      return std::ranges::find(v.sites, Site::object(corner)) != v.sites.end();
                  }) == 1);
    }
}

// What meets where, whatever its order.
auto structure_of(const Cell& cell) {
    std::multiset<std::set<Site>> vertices, edges, faces;
    for (const CellVertex& v : cell.vertices) vertices.insert({v.sites.begin(), v.sites.end()});
    for (const CellEdge& e : cell.edges) {
        std::set<Site> sites(e.sites.begin(), e.sites.end());
        sites.insert(e.extra_sites.begin(), e.extra_sites.end());
        edges.insert(sites);
    }
    for (const CellFace& f : cell.faces) faces.insert({f.site});
    return std::array{vertices, edges, faces};
}

TEST_CASE("ties: around a ball others tie along circles with a tube in the scene as they do without") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> whole(-2, 2);
    int ties = 0;
    for (int i = 0; i < 40 * rounds(); ++i) {
        CAPTURE(i);
        std::vector<Object> balls;
        std::set<std::array<int, 3>> places{{0, 0, 0}};
        while (balls.size() < 9) {
            const std::array<int, 3> p{whole(rng), whole(rng), whole(rng)};
            if (places.insert(p).second) balls.push_back(Sphere{Vec3(p[0], p[1], p[2]), 0.25});
        }
        Scene scene = scene_around(Sphere{Vec3::Zero(), 0.25}, 2, balls);
        const Cell alone = check_decided_around(scene);
        // Out of reach, but the forms are no longer all circular.
        scene.objects.push_back(Cylinder{Vec3(9, 8, 7), Vec3(1, -2, 3), 0.25});
        CHECK(structure_of(check_decided_around(scene)) == structure_of(alone));
        for (const CellEdge& e : alone.edges) ties += !e.extra_sites.empty();
    }
    CHECK(ties > 5 * rounds());
}

TEST_CASE(
    "ties: tubes all but across a tube tie over a point of its axis, where a rectangle of them is centred") {
    const double h = std::sqrt(0.75);
    for (const Vec3& axis : {Vec3(0.98, -0.064, 0.19), Vec3(0.47, 0.84, 0.28)}) {
        std::vector<Object> tubes;
        for (const double x : {-0.5, 0.5})
            for (const double y : {-h, h}) tubes.push_back(Cylinder{{x, y, 0}, Vec3::UnitZ(), 0.2});
        const Cell cell = check_decided_around(scene_around(Cylinder{Vec3::Zero(), axis, 0.2}, 2, tubes));
        CHECK(crowded_vertices(cell, 4) == 2);
    }
}

TEST_CASE("ties: four balls of a lattice tie in irrational directions from a tube, and some touch") {
    std::vector<Object> balls;
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y)
            for (int z = -2; z <= 2; ++z)
                if (x * x + y * y > 0 && x * x + y * y + z * z <= 5)
                    balls.push_back(Sphere{0.5 * Vec3(x, y, z), 0.125});
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(0.05, 0.02, 1)}) {
        CAPTURE(axis.transpose());
        check_decided_around(scene_around(Cylinder{Vec3::Zero(), axis, 0.125}, 1.25, balls));
    }
}

TEST_CASE("SpaceTie: tells what ties where two planes of balls meet, and an ulp that it does not") {
    const auto problem_of = [](double off) {
        return radial_base_problem(scene_around(Cylinder{Vec3::Zero(), {1, 2, 3}, 0.25}, 4,
                                                {Sphere{{1, 0, 0}, 0.25}, Sphere{{1, 1, 0}, 0.25},
                                                 Sphere{{1, 0, 1}, 0.25}, Sphere{{1, 1, 1 + off}, 0.25}}));
    };
    for (const double off : {0.0, DBL_EPSILON}) {
        const auto problem = problem_of(off);
        const std::array three{FormId{0}, FormId{1}, FormId{2}};
        CHECK(SpaceTie(problem.family, three).implies(FormId{3}) == (off == 0));
        for (const FormId f : three) CHECK(SpaceTie(problem.family, three).implies(f));
    }
}

TEST_CASE(
    "SpaceTie: tubes touch at the point of their line next to the ball, only if they are on one circle") {
    for (const double off : {0.0, DBL_EPSILON}) {
        const auto problem = radial_base_problem(
            scene_around(Sphere{Vec3::Zero(), 0.25}, 4,
                         {Cylinder{{1, 0, 0}, {0, 0, 1}, 0.25}, Cylinder{{0, 1, 0}, {0, 0, 1}, 0.25},
                          Cylinder{{1 + off, 1, 0}, {0, 0, 1}, 0.25}}));
        const std::array<FormId, 3> tubes = [&] {
            std::array<FormId, 3> found;
            for (const FormId f : problem.sites.ids())
                if (const Site site = problem.sites[f].front(); site.is_object()) found[site.index] = f;
            return found;
        }();
        const auto points = SpaceTie(problem.family, tubes).tangencies();
        int ahead = 0;
        for (const SpacePoint& p : points) {
            const auto place = chart_point(problem.family, p);
            if (!place) continue;
            ++ahead;
            const Vec3 u = problem.chart.normal({(*place)[0].mid(), (*place)[1].mid()});
            CHECK((u - Vec3(1, 1, 0).normalized()).norm() < 1e-14);
            for (const FormId f : tubes) CHECK(passes_through(problem.family, f, p));
            CHECK_FALSE(have_equal_gradients(problem.family, tubes[0], tubes[1], p));
        }
        CHECK(ahead == (off == 0));
    }
}

TEST_CASE("ties: in places that are no doubles in the chart are exact") {
    // A point on a plane, at a distance that is a fraction.
    check_decided_around(scene_around(
        Cylinder{Vec3::Zero(), {0, 0, 1}, 0.25}, 2,
        {Plane{{-1.5, 1, 1.25}, {1, 0, 0}}, Sphere{{-1.5, 1, 1.25}, 0}, Sphere{{-0.5, -1.75, 0.5}, 0.25}}));
    // Two lines and a side of the box are as near as the base in a point at the distance of a root, where
    // gradients are on one line.
    check_decided_around(
        scene_around(Sphere{Vec3::Zero(), 0}, 2,
                     {Sphere{{0, 2, -2}, 0}, Sphere{{-2, -1, 1}, 0}, Sphere{{1, -2, -2}, 0},
                      Cylinder{{0, 2, 0}, {0, 1, -1}, 0}, Cylinder{{1, 2, -1}, {1, -1, 0}, 0}}));
}

}  // namespace vcell::ties_test
