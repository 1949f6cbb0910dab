/// check_cell() on cells built here by hand, on computed ones, and on damaged ones.
#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
#include "../first_cell.hpp"
#include "../test_support.hpp"
#include "hand_built_cells.hpp"
#include "listing.hpp"

namespace vcell {

using namespace hand_built;

namespace {

// --- Computed cells -----------------------------------------------------------------------------------

Scene random_scene(std::mt19937_64& rng, int spheres, int planes, bool tilted) {
    std::uniform_real_distribution<double> u(-1, 1);
    Scene s;
    s.box = {{-2, -1.5, -1}, {2, 1.5, 2}};
    Plane base{{0.1, -0.2, tilted ? 0 : -1.0}, {0, 0, 1}};
    if (tilted) base.normal = {0.3 * u(rng), 0.3 * u(rng), 1.5};
    s.base = base;
    const Vec3 n = base.normal.normalized();
    for (int i = 0; i < spheres; ++i) {
        const double radius = 0.15 * (1 + u(rng));
        const Vec3 foot =
            base.point + 2 * u(rng) * n.unitOrthogonal() + 2 * u(rng) * n.cross(n.unitOrthogonal());
        s.objects.push_back(Sphere{foot + (radius + 0.3 + 0.25 * u(rng)) * n, radius});
    }
    for (int i = 0; i < planes; ++i)
        s.objects.push_back(
            Plane{base.point + (1.2 + 0.3 * u(rng)) * n, -n + 0.15 * Vec3(u(rng), u(rng), u(rng))});
    return s;
}

/// Objects around a base of about its size in the middle of the box; none cuts or holds it.
Scene scene_around(std::mt19937_64& rng, const Object& base, int spheres, int planes, int cylinders) {
    std::uniform_real_distribution<double> u(-1, 1);
    Scene s;
    s.base = base;
    s.box = {{-2, -2, -2}, {2, 2, 2}};
    const auto direction = [&] { return Vec3(u(rng), u(rng), u(rng)).normalized(); };
    for (int i = 0; i < spheres; ++i) {
        const double radius = 0.2 * (1.2 + u(rng));
        s.objects.push_back(Sphere{(1.3 + radius + 0.4 * u(rng)) * direction(), radius});
    }
    for (int i = 0; i < planes; ++i) {
        const Vec3 n = direction();
        s.objects.push_back(Plane{1.4 * n, -n});
    }
    for (int i = 0; i < cylinders; ++i) {
        const Vec3 n = direction();
        s.objects.push_back(Cylinder{1.5 * n, n.cross(direction()), 0.2});
    }
    return s;
}

std::string listing(const std::vector<Finding>& findings) {
    std::string s;
    for (const Finding& f : findings) s += f.where + ": " + f.what + "\n";
    return s;
}

void expect_clean(const Cell& cell) {
    const auto findings = check_cell(cell);
    CHECK_MESSAGE(findings.empty(), listing(findings));
}

/// Nothing is refuted, and at most so many elements are left open.
void expect_not_accused(const Cell& cell, std::size_t most_open) {
    const Certificate certificate = certify(cell);
    CHECK_MESSAGE(certificate.count(Verdict::refuted) == 0, listing(check_cell(cell)));
    CHECK_MESSAGE(certificate.count(Verdict::open) <= most_open, listing(check_cell(cell)));
}

struct Damage {
    std::string what;
    std::string where;  ///< a finding must name this place, or a part of it
    std::function<void(Cell&)> make;
};

void expect_named(const Cell& good, const Damage& damage) {
    CAPTURE(damage.what);
    Cell bad = good;
    damage.make(bad);
    const auto findings = check_cell(bad);
    const bool named = std::ranges::any_of(findings, [&](const Finding& f) {
        if (!f.where.starts_with(damage.where)) return false;
        const char after = f.where.size() > damage.where.size() ? f.where[damage.where.size()] : '.';
        return after == '.' || after == '[';
    });
    CHECK_MESSAGE(named, "expected ", damage.where, ", found\n", listing(findings));
}

}  // namespace

TEST_CASE("check_cell: finds nothing wrong with cells built by hand") {
    expect_clean(two_spheres());
    expect_clean(two_patches());
    expect_clean(island());
}

TEST_CASE("check_cell: finds nothing wrong with computed cells of spheres") {
    std::mt19937_64 rng(test_seed());
    for (const auto& [spheres, planes, cylinders] :
         {std::array{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {12, 1, 0}, {4, 1, 2}}) {
        CAPTURE(spheres);
        CAPTURE(planes);
        CAPTURE(cylinders);
        expect_clean(first_cell([&] {
            return scene_around(rng, Sphere{{0.3, -0.2, 0.1}, 0.5}, spheres, planes, cylinders);
        }));
    }
}

TEST_CASE("check_cell: finds nothing wrong with computed cells") {
    std::mt19937_64 rng(test_seed());
    for (const bool tilted : {false, true})
        for (const auto& [spheres, planes] : {std::pair{0, 0}, {1, 0}, {0, 1}, {3, 1}, {12, 0}, {60, 2}}) {
            CAPTURE(spheres);
            CAPTURE(planes);
            CAPTURE(tilted);
            expect_clean(voronoi_cell(random_scene(rng, spheres, planes, tilted)));
        }
}

TEST_CASE("check_cell: finds nothing wrong with scenes whose islands were once lost") {
    for (const int i : {1, 2, 3, 4, 5}) {
        const std::string name = "lost_island_" + std::to_string(i) + ".json";
        CAPTURE(name);
        expect_clean(voronoi_cell(read_scene(test_data(name))));
    }
}

TEST_CASE("check_cell: finds base points under the one face where a search by Newton's method erred") {
    for (const std::string name : {"missed_patch_1.json", "missed_patch_2.json", "doubled_patch.json"}) {
        CAPTURE(name);
        expect_clean(voronoi_cell(read_scene(test_data(name))));
    }
}

TEST_CASE("check_cell: names each damage to two faces that meet in a parabola") {
    const std::vector<Damage> damages{
        {"a vertex moved", "vertices[1]", [](Cell& c) { c.vertices[1].point.z() += 1e-6; }},
        {"a vertex moved along the rim", "vertices[1]", [](Cell& c) { c.vertices[1].point.x() += 1e-6; }},
        {"a vertex with a wrong clearance", "vertices[2].radius",
         [](Cell& c) { c.vertices[2].radius += 1e-6; }},
        {"a vertex lacks a site", "vertices[4].sites",
         [](Cell& c) { c.vertices[4].sites.erase(c.vertices[4].sites.begin()); }},
        {"a vertex lists a site that is farther", "vertices[0]",
         [](Cell& c) { c.vertices[0].sites.insert(c.vertices[0].sites.begin() + 1, Site::object(1)); }},
        {"a site that does not exist", "vertices[3].sites",
         [](Cell& c) { c.vertices[3].sites[0] = Site::object(7); }},
        {"an edge's sites exchanged", "edges[6].sites",
         [](Cell& c) { std::swap(c.edges[6].sites[0], c.edges[6].sites[1]); }},
        {"an edge joins the wrong vertex", "edges[6].vertices", [](Cell& c) { c.edges[6].vertices[1] = 3; }},
        {"a control point moved", "edges[6].curve", [](Cell& c) { c.edges[6].curve.points[1].z() += 1e-6; }},
        {"a weight changed", "edges[6].curve", [](Cell& c) { c.edges[6].curve.points[1].w() += 1e-6; }},
        {"a negative weight", "edges[6].curve", [](Cell& c) { c.edges[6].curve.points[1].w() = -1; }},
        {"a knot vector not clamped", "edges[0].curve", [](Cell& c) { c.edges[0].curve.knots[0] = -1; }},
        {"a wrong kind", "edges[6].kind", [](Cell& c) { c.edges[6].kind = CurveKind::Ellipse; }},
        {"a wrong length", "edges[2].length", [](Cell& c) { c.edges[2].length *= 1 + 1e-6; }},
        {"an edge twice", "edges[7]", [](Cell& c) { c.edges.push_back(c.edges[6]); }},
        {"a face dropped", "edges[1]", [](Cell& c) { c.faces.pop_back(); }},
        {"a face dropped, seen by its absence", "faces", [](Cell& c) { c.faces.pop_back(); }},
        {"a face twice", "faces[2]", [](Cell& c) { c.faces.push_back(c.faces[1]); }},
        {"a face of the wrong owner", "faces[1].site", [](Cell& c) { c.faces[1].site = Site::object(0); }},
        {"a face of the wrong name", "faces[1].bisector", [](Cell& c) { c.faces[1].bisector = "plane"; }},
        {"a wrong face area", "faces[1].area", [](Cell& c) { c.faces[1].area += 1e-6; }},
        {"a patch control point moved", "faces[0].patches[0]",
         [](Cell& c) { c.faces[0].patches[0].surface.points[4].z() += 1e-6; }},
        {"a loop reversed", "faces[0].patches[0].loops[0]",
         [](Cell& c) {
             auto& loop = c.faces[0].patches[0].loops[0];
             std::ranges::reverse(loop);
             for (TrimCurve& t : loop) {
                 t.reversed = !t.reversed;
                 t.curve = reversed(t.curve);
             }
         }},
        {"loop curves out of order", "faces[0].patches[0].loops[0]",
         [](Cell& c) { std::swap(c.faces[0].patches[0].loops[0][1], c.faces[0].patches[0].loops[0][2]); }},
        {"a trimming curve moved", "faces[0].patches[0].loops[0][1]",
         [](Cell& c) { c.faces[0].patches[0].loops[0][1].curve.points[1].x() += 1e-6; }},
        {"a trimming curve of no edge", "faces[0].patches[0].loops[0][1]",
         [](Cell& c) { c.faces[0].patches[0].loops[0][1].edge.reset(); }},
        {"a neighbour forgotten", "neighbors", [](Cell& c) { c.neighbors.pop_back(); }},
        {"a neighbour twice", "neighbors[2]", [](Cell& c) { c.neighbors.push_back(0); }},
        {"an object removed", "faces[1].site", [](Cell& c) { c.scene.objects.pop_back(); }},
        {"an object moved closer", "faces[1].patches[0]",
         [](Cell& c) { std::get<Sphere>(c.scene.objects[1]).center.z() -= 1e-6; }},
        {"an object added", "faces[0]",
         [](Cell& c) {
             c.scene.objects.push_back(Sphere{{-0.75, 0.25, 0.5}, 0.125});
         }},
        {"a wrong volume", "measures.volume", [](Cell& c) { c.measures.volume += 1e-6; }},
        {"a wrong area", "measures.area", [](Cell& c) { c.measures.area -= 1e-6; }},
        {"a wrong box area", "measures.box_area", [](Cell& c) { c.measures.box_area = 0; }},
        {"a wrong base area", "measures.base_area", [](Cell& c) { c.measures.base_area = 3; }},
        {"a wrong least clearance", "measures.min_clearance",
         [](Cell& c) { c.measures.min_clearance += 1e-6; }},
        {"a wrong greatest clearance", "measures.max_clearance",
         [](Cell& c) { c.measures.max_clearance -= 1e-6; }},
        {"a cell that does not touch its box", "measures.touches_box",
         [](Cell& c) { c.measures.touches_box = false; }},
        {"time that runs backwards", "report.seconds.envelope",
         [](Cell& c) { c.report.seconds_envelope = -1; }},
    };
    const Cell good = two_spheres();
    for (const Damage& d : damages) expect_named(good, d);
}

TEST_CASE("check_cell: names each damage to an island") {
    const std::vector<Damage> damages{
        {"neighbours in the wrong order", "neighbors[1]",
         [](Cell& c) { std::swap(c.neighbors[0], c.neighbors[1]); }},
        {"a hole forgotten", "edges[4]", [](Cell& c) { c.faces[0].patches[0].loops.pop_back(); }},
        {"a hole counter-clockwise", "faces[0].patches[0].loops[1]",
         [](Cell& c) { c.faces[0].patches[0].loops[1][0].curve = circle(0.5); }},
        {"the island forgotten", "faces", [](Cell& c) { c.faces.pop_back(); }},
        {"a circle that is larger", "edges[4].curve",
         [](Cell& c) {
             for (auto& p : c.edges[4].curve.points) p.head<2>() *= 1 + 1e-6;
         }},
        {"a circle called an ellipse", "edges[4].kind",
         [](Cell& c) { c.edges[4].kind = CurveKind::Ellipse; }},
        {"a circle called a parabola", "edges[4].kind",
         [](Cell& c) { c.edges[4].kind = CurveKind::Parabola; }},
        {"a line called a circle", "edges[0].kind", [](Cell& c) { c.edges[0].kind = CurveKind::Circle; }},
        {"an open closed curve", "edges[4].curve",
         [](Cell& c) { c.edges[4].curve.points.back().x() += 1e-6; }},
        {"a closed edge exchanged", "edges[4].sites",
         [](Cell& c) { std::swap(c.edges[4].sites[0], c.edges[4].sites[1]); }},
        {"a vertex splits an edge", "vertices[4]",
         [](Cell& c) {
             // The rim edge 0 in two halves, consistently, with a vertex where nothing changes.
             const Vec2 p(-1, -1), m(0, -1), q(1, -1);
             const Height lid{0, 0, 0.475, 1};
             c.vertices.push_back({lid.over(m), 0.475, {Site::object(1), Site::box_side(2)}, 1e-15});
             c.edges[0].vertices[1] = 4;
             c.edges[0].curve = lifted(segment(p, m), lid);
             c.edges[0].length = 1;
             add_edge(c, Site::object(1), Site::box_side(2), {4, 1}, CurveKind::Line, segment(m, q), lid);
             auto& loop = c.faces[0].patches[0].loops[0];
             loop[0].curve = segment(p, m);
             loop.insert(loop.begin() + 1, {5, {}, false, segment(m, q)});
         }},
    };
    const Cell good = island();
    for (const Damage& d : damages) expect_named(good, d);
}

TEST_CASE("check_cell: names damage to a computed cell of many faces") {
    std::mt19937_64 rng(test_seed());
    const Cell good = voronoi_cell(random_scene(rng, 20, 1, true));
    std::uint32_t v = 0;  // an inner vertex
    while (!std::ranges::all_of(good.vertices[v].sites, &Site::is_object)) ++v;
    std::uint32_t e = 0;  // an inner edge
    while (!good.edges[e].sites[0].is_object() || !good.edges[e].sites[1].is_object()) ++e;
    const std::string vertex = "vertices[" + std::to_string(v) + "]",
                      edge = "edges[" + std::to_string(e) + "]";
    const std::vector<Damage> damages{
        {"a vertex moved up", vertex, [&](Cell& c) { c.vertices[v].point.z() += 1e-6; }},
        {"a vertex moved aside", vertex, [&](Cell& c) { c.vertices[v].point.x() += 1e-6; }},
        {"a vertex lacks a site", vertex + ".sites", [&](Cell& c) { c.vertices[v].sites.pop_back(); }},
        {"an edge's curve moved", edge + ".curve", [&](Cell& c) { c.edges[e].curve.points[1].x() += 1e-5; }},
        {"an edge's sites exchanged", edge + ".sites",
         [&](Cell& c) { std::swap(c.edges[e].sites[0], c.edges[e].sites[1]); }},
        {"a face forgotten", "faces", [](Cell& c) { c.faces.erase(c.faces.begin() + c.faces.size() / 2); }},
        {"the objects renumbered", "faces[0].patches[0]",
         [](Cell& c) {
             const std::uint32_t i = c.faces[0].site.index;
             std::swap(c.scene.objects[i], c.scene.objects[(i + 1) % c.scene.objects.size()]);
         }},
    };
    REQUIRE(good.faces[0].site.is_object());
    for (const Damage& d : damages) expect_named(good, d);
}

TEST_CASE("check_cell: names each damage to a face in two patches") {
    const auto trim = [](Cell& c, int patch, int i) -> TrimCurve& {
        return c.faces[0].patches[static_cast<std::size_t>(patch)].loops[0][static_cast<std::size_t>(i)];
    };
    const std::vector<Damage> damages{
        {"a seam of one side", "faces[0].patches[0].loops[0][1]", [&](Cell& c) { trim(c, 0, 1).seam = 4; }},
        {"a seam that bends on one side", "faces[0].patches[0].loops[0][1]",
         [&](Cell& c) { trim(c, 0, 1).curve.points[1].x() += 1e-3; }},
        {"an edge with a gap between patches", "edges[0]",
         [&](Cell& c) { trim(c, 1, 0).curve.knots = {0.75, 0.75, 0.75, 1, 1, 1}; }},
        {"an edge at other parameters", "faces[0].patches[0].loops[0][2]",
         [&](Cell& c) { trim(c, 0, 2).curve.knots = {0, 0, 0, 0.5, 0.5, 0.5}; }},
        {"a patch forgotten", "edges[0]", [](Cell& c) { c.faces[0].patches.pop_back(); }},
    };
    const Cell good = two_patches();
    for (const Damage& d : damages) expect_named(good, d);
}

TEST_CASE("check_cell: names damage to a computed cell of a sphere") {
    std::mt19937_64 rng(test_seed());
    const Cell good = first_cell([&] { return scene_around(rng, Sphere{{0.3, -0.2, 0.1}, 0.5}, 14, 1, 0); });
    const auto is_owned = [](const Site& s) { return s.is_object(); };
    const auto found = [&](const auto& items) {
        return static_cast<std::size_t>(
            std::ranges::find_if(items,
                                 [&](const auto& x) { return std::ranges::all_of(x.sites, is_owned); }) -
            items.begin());
    };
    const std::size_t v = found(good.vertices), e = found(good.edges);
    REQUIRE(v < good.vertices.size());
    REQUIRE(e < good.edges.size());
    const std::size_t f = static_cast<std::size_t>(
        std::ranges::find_if(good.faces, is_owned, &CellFace::site) - good.faces.begin());
    const std::string vertex = "vertices[" + std::to_string(v) + "]",
                      edge = "edges[" + std::to_string(e) + "]", face = "faces[" + std::to_string(f) + "]";
    const auto owner = [f](Cell& c) -> Object& { return c.scene.objects[c.faces[f].site.index]; };
    const std::vector<Damage> damages{
        {"a vertex moved", vertex, [&](Cell& c) { c.vertices[v].point.x() += 1e-6; }},
        {"a wrong clearance", vertex + ".radius", [&](Cell& c) { c.vertices[v].radius += 1e-6; }},
        {"a vertex lacks a site", vertex + ".sites", [&](Cell& c) { c.vertices[v].sites.pop_back(); }},
        {"an end that a sphere does not have", vertex + ".sites",
         [&](Cell& c) { c.vertices[v].sites.push_back(Site::end(0)); }},
        {"a control point moved", edge + ".curve", [&](Cell& c) { c.edges[e].curve.points[1].x() += 1e-5; }},
        {"an edge's sites exchanged", edge + ".sites",
         [&](Cell& c) { std::swap(c.edges[e].sites[0], c.edges[e].sites[1]); }},
        {"an edge of the wrong kind", edge + ".kind", [&](Cell& c) { c.edges[e].kind = CurveKind::Line; }},
        {"a wrong length", edge + ".length", [&](Cell& c) { c.edges[e].length *= 1 + 1e-6; }},
        {"a patch control point moved", face + ".patches[0]",
         [&](Cell& c) { c.faces[f].patches[0].surface.points[4].head<3>() *= 1 + 1e-5; }},
        {"a trimming curve moved", face + ".patches[0].loops[0]",
         [&](Cell& c) { c.faces[f].patches[0].loops[0][0].curve.points[1].x() += 1e-4; }},
        {"a face of the wrong name", face + ".bisector",
         [&](Cell& c) { c.faces[f].bisector = "paraboloid?"; }},
        {"a face forgotten", "faces",
         [&](Cell& c) { c.faces.erase(c.faces.begin() + static_cast<long>(f)); }},
        {"an object moved closer", face + ".patches[0]",
         [&](Cell& c) {
             if (auto* s = std::get_if<Sphere>(&owner(c))) s->radius += 1e-6;
             if (auto* p = std::get_if<Plane>(&owner(c))) p->point += 1e-6 * p->normal.normalized();
         }},
        {"another base", "vertices[0]", [](Cell& c) { std::get<Sphere>(c.scene.base).radius += 1e-6; }},
        {"a wrong volume", "measures.volume", [](Cell& c) { c.measures.volume += 1e-6; }},
        {"a wrong area", "measures.area", [](Cell& c) { c.measures.area -= 1e-6; }},
        {"a wrong base area", "measures.base_area", [](Cell& c) { c.measures.base_area += 1e-6; }},
        {"a wrong body", "measures.body_volume", [](Cell& c) { c.measures.body_volume = 0; }},
        {"a wrong least clearance", "measures.min_clearance",
         [](Cell& c) { c.measures.min_clearance += 1e-6; }},
        {"a wrong greatest clearance", "measures.max_clearance",
         [](Cell& c) { c.measures.max_clearance -= 1e-6; }},
    };
    for (const Damage& d : damages) expect_named(good, d);
}

TEST_CASE("check_cell: finds nothing wrong with computed cells of cylinders") {
    std::mt19937_64 rng(test_seed());
    for (const auto& [spheres, planes, cylinders] :
         {std::array{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {6, 1, 0}, {2, 1, 3}}) {
        CAPTURE(spheres);
        CAPTURE(planes);
        CAPTURE(cylinders);
        const Cylinder base{{0.1, 0.2, 0}, {0.1, -0.2, 1}, 0.25};
        expect_clean(first_cell([&] {
            Scene scene = scene_around(rng, base, spheres, 0, cylinders);
            // A plane beside the stretch, whatever the seed.
            if (planes > 0) scene.objects.push_back(Plane{{1.6, 0, 0}, {1, 0.1, 0.1}});
            std::erase_if(scene.objects, [&](const Object& o) {
                const auto* c = std::get_if<Cylinder>(&o);
                return c && std::abs(base.axis.cross(c->axis).normalized().dot(c->point - base.point)) < 0.6;
            });
            return scene;
        }));
    }
}

TEST_CASE("check_cell: finds nothing wrong far from the origin and where edges are fitted loosely") {
    for (const double far : {0.0, 1e6}) {
        const Vec3 c = far * Vec3(1, -1, 0.5);
        Scene scene;
        scene.base = Cylinder{c, {0, 0, 1}, 0.5};
        scene.objects = {Sphere{c + Vec3(1.5, 0.25, 0.5), 0.5},
                         Cylinder{c + Vec3(-1.25, 0.5, 0), {0.25, 0.5, 1}, 0.25},
                         Cylinder{c + Vec3(0, -1.5, -0.5), {1, 0.125, 0.125}, 0.5}};
        scene.box = {c - Vec3(3, 3, 2), c + Vec3(3, 3, 2)};
        for (const double tolerance : {1e-6, 1e-2}) {
            scene.tolerance = tolerance;
            CAPTURE(far);
            CAPTURE(tolerance);
            expect_clean(voronoi_cell(scene));
        }
    }
}

TEST_CASE("check_cell: finds the least clearance on a seam") {
    Scene scene;
    scene.base = Cylinder{{0.146, -0.714, -0.153}, {0, 1, 0}, 0.125};
    scene.objects = {Cylinder{{-1.213, 0.499, 0.078}, {-0.572, 0.568, -0.592}, 0.125},
                     Plane{{1.788, -0.668, 1.725}, {0.658, 0.019, 0.753}}};
    scene.box = {{-2.854, -3.814, -3.353}, {3.246, 2.586, 2.897}};
    expect_clean(voronoi_cell(scene));
}

TEST_CASE("check_cell: finds nothing wrong with computed cells of lines that meet the box obliquely") {
    std::mt19937_64 rng(test_seed());
    for (const double radius : {0.0, 1e-12, 1e-6}) {
        CAPTURE(radius);
        const Cylinder base{{0.1, 0.2, 0}, {0.3, -0.2, 1}, radius};
        // Faces of tubes have integrands with poles beside a line: their measures may stay open, the rest may
        // not.
        const Cell cell = first_cell([&] { return scene_around(rng, base, 2, 0, 2); });
        expect_not_accused(cell, cell.faces.size() + 4);
    }
}

TEST_CASE("check_cell: names damage to a computed cell of a cylinder") {
    Scene scene;
    scene.base = Cylinder{{0, 0, 0}, {0, 0, 1}, 0.5};
    scene.objects = {Sphere{{1.5, 0.25, 0.5}, 0.5}, Cylinder{{-1.25, 0.5, 0}, {0.25, 0.5, 1}, 0.25},
                     Cylinder{{0, -1.5, -0.5}, {1, 0.125, 0.125}, 0.5}};
    scene.box = {{-3, -3, -2}, {3, 3, 2}};
    const Cell good = voronoi_cell(scene);
    const auto is_rim = [](const CellEdge& e) {
        return e.sites[0].kind == Site::Kind::End || e.sites[1].kind == Site::Kind::End;
    };
    const auto e = static_cast<std::size_t>(std::ranges::find_if(good.edges, is_rim) - good.edges.begin());
    REQUIRE(e < good.edges.size());
    const std::string edge = "edges[" + std::to_string(e) + "]";
    const auto cut = static_cast<std::size_t>(
        std::ranges::find_if(good.faces, [](const CellFace& f) { return f.patches.size() > 1; }) -
        good.faces.begin());
    REQUIRE(cut < good.faces.size());
    const auto seam_of = [cut](Cell& c) -> TrimCurve& {
        for (TrimmedPatch& patch : c.faces[cut].patches)
            for (auto& loop : patch.loops)
                for (TrimCurve& trim : loop)
                    if (trim.seam) return trim;
        throw std::logic_error("a cut face without a seam");
    };
    const std::vector<Damage> damages{
        {"a rim at the other end", edge,
         [&](Cell& c) {
             for (Site& s : c.edges[e].sites)
                 if (s.kind == Site::Kind::End) s.index = 1 - s.index;
         }},
        {"a rim moved along the axis", edge,
         [&](Cell& c) {
             for (auto& p : c.edges[e].curve.points) p.z() += 1e-5;
         }},
        {"a seam moved", "faces[" + std::to_string(cut) + "].patches",
         [&](Cell& c) { seam_of(c).curve.points[0].y() += 1e-3; }},
        {"a longer stretch", "measures.base_area", [](Cell& c) { c.scene.box.max.z() += 1e-3; }},
        {"ends not counted", "measures.box_area", [](Cell& c) { c.measures.box_area -= 1e-3; }},
        {"a face forgotten", "faces", [](Cell& c) { c.faces.pop_back(); }},
        {"a wrong volume", "measures.volume", [](Cell& c) { c.measures.volume += 1e-2; }},
    };
    for (const Damage& d : damages) expect_named(good, d);
}

TEST_CASE("certify: samples of a region that is a strip across its bounds") {
    const Scene scene = read_scene(test_data("hostile/leaning_strip.json"));
    const Certificate c = certify(voronoi_cell(scene));
    CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
}

}  // namespace vcell
