#include "../../io/pictures/mesh.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <sstream>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../io/pictures/obj.hpp"
#include "closed_meshes.hpp"
#include "sample_cells.hpp"
#include "test_support.hpp"

using namespace vcell;

namespace {

const auto never = [](const Vec2&, const Vec2&) { return false; };

/// Directed sides of the triangles and how often each occurs.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides(const std::vector<Triangle>& triangles) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> result;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) ++result[{t[k], t[(k + 1) % 3]}];
    return result;
}

struct Topology {
    bool manifold = true;  // no directed side occurs twice
    std::size_t rim = 0;   // sides without a twin
    long euler = 0;        // V - E + F
};
Topology topology(const std::vector<Triangle>& triangles) {
    Topology result;
    std::set<std::uint32_t> vertices;
    std::size_t paired = 0;
    const auto all = sides(triangles);
    for (const auto& [side, count] : all) {
        vertices.insert(side.first);
        result.manifold = result.manifold && count == 1 && side.first != side.second;
        if (all.contains({side.second, side.first}))
            ++paired;
        else
            ++result.rim;
    }
    result.euler = static_cast<long>(vertices.size()) - static_cast<long>(paired / 2 + result.rim) +
                   static_cast<long>(triangles.size());
    return result;
}

double area(const Triangulation& t) {
    double twice = 0;
    for (const Triangle& v : t.triangles) {
        const Vec2 a = t.points[v[1]] - t.points[v[0]], b = t.points[v[2]] - t.points[v[0]];
        twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * twice;
}
bool all_turn_left(const Triangulation& t) {
    for (const Triangle& v : t.triangles) {
        const Vec2 a = t.points[v[1]] - t.points[v[0]], b = t.points[v[2]] - t.points[v[0]];
        if (!(a.x() * b.y() - a.y() * b.x() > 0)) return false;
    }
    return true;
}

std::vector<Vec2> ring(Vec2 center, double radius, int n, bool clockwise, double phase = 0) {
    std::vector<Vec2> result;
    for (int i = 0; i < n; ++i) {
        const double a = phase + 2 * std::numbers::pi * (clockwise ? -i : i) / n;
        result.push_back(center + radius * Vec2(std::cos(a), std::sin(a)));
    }
    return result;
}
/// The unit square, n points on each side.
std::vector<Vec2> square(int n) {
    const Vec2 corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    std::vector<Vec2> result;
    for (int i = 0; i < 4 * n; ++i) {
        const double s = static_cast<double>(i % n) / n;
        result.push_back((1 - s) * corners[i / n] + s * corners[(i / n + 1) % 4]);
    }
    return result;
}
double polygon_area(const std::vector<std::vector<Vec2>>& loops) {
    double twice = 0;
    for (const auto& loop : loops)
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
            twice += a.x() * b.y() - a.y() * b.x();
        }
    return 0.5 * twice;
}

}  // namespace

TEST_CASE("triangulate: star-shaped polygons with random spikes") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> radius(0.05, 1);
    for (int round = 0; round < 300; ++round) {
        const int n = 3 + static_cast<int>(rng() % 60);
        std::vector<Vec2> loop = ring({0, 0}, 1, n, false, 0.1 * round);
        for (Vec2& p : loop) p *= radius(rng);
        const Triangulation t = triangulate({loop}, never);
        CAPTURE(round);
        REQUIRE(t.triangles.size() == static_cast<std::size_t>(n) - 2);
        CHECK(area(t) == doctest::Approx(polygon_area({loop})));
        CHECK(all_turn_left(t));
        CHECK(topology(t.triangles).manifold);
        CHECK(topology(t.triangles).rim == static_cast<std::size_t>(n));
    }
}

TEST_CASE("triangulate: many holes") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> radius(0.05, 0.49);
    std::vector<std::vector<Vec2>> loops{{{0, 0}, {6, 0}, {6, 6}, {0, 6}}};
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
            loops.push_back(ring({i + 0.5, j + 0.5}, radius(rng), 5 + i + j, true, radius(rng)));
    const Triangulation t = triangulate(loops, never);
    CHECK(area(t) == doctest::Approx(polygon_area(loops)));
    CHECK(all_turn_left(t));
    const Topology top = topology(t.triangles);
    CHECK(top.manifold);
    CHECK(top.euler == 1 - 36);
}

TEST_CASE("triangulate: holes that touch the outside or each other in a point") {
    const std::vector<std::vector<Vec2>> loops{
        {{0, 0}, {2, 0}, {4, 0}, {4, 4}, {0, 4}}, {{2, 0}, {1, 1}, {2, 2}, {3, 1}}, {{2, 2}, {1, 3}, {3, 3}}};
    const Triangulation t = triangulate(loops, never);
    CHECK(area(t) == doctest::Approx(polygon_area(loops)));
    CHECK(topology(t.triangles).manifold);
}

TEST_CASE("triangulate: points on straight sides, and polygons that are none") {
    const Triangulation t = triangulate({square(10)}, never);
    CHECK(area(t) == doctest::Approx(1));
    CHECK(all_turn_left(t));
    // Whatever the coordinates, the topology holds.
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> any(-1, 1);
    for (int round = 0; round < 200; ++round) {
        std::vector<Vec2> scribble(3 + rng() % 30);
        for (Vec2& p : scribble)
            p = round % 3 == 0 ? Vec2(0, 0) : Vec2(any(rng), round % 3 == 1 ? 0 : any(rng));
        const Triangulation s = triangulate({scribble}, never);
        REQUIRE(s.triangles.size() == scribble.size() - 2);
        CHECK(topology(s.triangles).rim == scribble.size());
    }
    CHECK(triangulate({}, never).triangles.empty());
    CHECK(triangulate({{{0, 0}, {1, 0}}}, never).triangles.empty());
}

TEST_CASE("triangulate: refinement reaches its goal and leaves the polygon's sides alone") {
    const std::vector<std::vector<Vec2>> loops{square(10), ring({0.5, 0.5}, 0.2, 16, true)};
    const auto longer = [](const Vec2& a, const Vec2& b) { return (a - b).norm() > 0.11; };
    const Triangulation t = triangulate(loops, longer);
    CHECK(area(t) == doctest::Approx(polygon_area(loops)));
    CHECK(all_turn_left(t));
    const Topology top = topology(t.triangles);
    CHECK(top.manifold);
    CHECK(top.rim == 56);
    const auto all = sides(t.triangles);
    for (const auto& [side, count] : all)
        if (all.contains({side.second, side.first}))
            CHECK_FALSE(longer(t.points[side.first], t.points[side.second]));
}

TEST_CASE("triangulate: refinement ends even where the polygon's own sides are too long") {
    const auto longer = [](const Vec2& a, const Vec2& b) { return (a - b).norm() > 0.01; };
    const Triangulation t = triangulate({square(1)}, longer);
    CHECK(area(t) == doctest::Approx(1));
    CHECK(topology(t.triangles).manifold);
    CHECK(topology(t.triangles).rim == 4);
    CHECK(t.points.size() <= 1020);
}

TEST_CASE("mesh: a surface that is all of the cell, without an edge, is closed along its seam") {
    const Cell cell = ellipsoid_cell();
    REQUIRE(cell.edges.empty());
    const double exact = 4.0 / 3 * std::numbers::pi * 3 * 3;
    double previous = exact;
    for (const double chord : {0.1, 0.01, 0.001}) {
        const CellMesh mesh = tessellate(cell, {chord, true});
        const Topology t = topology(mesh.triangles);
        CHECK(t.manifold);
        CHECK(t.rim == 0);
        CHECK(t.euler == 2);
        const double error = std::abs(volume(mesh) - exact);
        CHECK(error < cell.measures.area * chord);
        CHECK(error < previous);
        previous = error;
    }
}

TEST_CASE("mesh: open and closed, whole and with an island") {
    // Volumes under min(z(x, y), height) over [-1, 1]^2: for the paraboloid 4 (2/3 + 15/16) / (5/2); with
    // a ceiling at 0.6 above the disk of radius 3/4, 4 * 0.6 less the cap pi r^2 (0.6 - 0.375) / 2.
    const std::pair<Cell, double> cases[] = {
        {paraboloid_cell(), 4 * (2.0 / 3 + 15.0 / 16) / 2.5},
        {island_cell(), 4 * 0.6 - std::numbers::pi * 0.5625 * 0.225 / 2}};
    for (const auto& [cell, exact] : cases) {
        double previous = 1;
        for (const double chord : {3e-2, 3e-3, 3e-4}) {
            const CellMesh closed = tessellate(cell, {chord, true});
            const Topology whole = topology(closed.triangles);
            CHECK(whole.manifold);
            CHECK(whole.rim == 0);
            CHECK(whole.euler == 2);
            // Chords cut off no more than their distance times the base region's area.
            const double error = std::abs(volume(closed) - exact);
            CHECK(error < 4 * chord);
            CHECK(error < previous);
            previous = error;

            const CellMesh open = tessellate(cell, {chord, false});
            const Topology top = topology(open.triangles);
            CHECK(top.manifold);
            CHECK(top.euler == 1);
            CHECK(top.rim >= 4);
        }
    }
}

TEST_CASE("mesh: points lie on the cell, normals point out of it") {
    const CellMesh mesh = tessellate(island_cell(), {0.01, true});
    for (const Vec3& p : mesh.points) {
        const double z = std::min(0.6, (p.x() * p.x() + p.y() * p.y() + 15.0 / 16) / 2.5);
        CHECK((std::abs(p.z() - z) < 1e-12 || p.z() == 0));
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle &v = mesh.triangles[t], &n = mesh.corner_normals[t];
        const Vec3 a = mesh.points[v[1]] - mesh.points[v[0]], b = mesh.points[v[2]] - mesh.points[v[0]];
        for (const std::uint32_t k : n) {
            CHECK(mesh.normals[k].norm() == doctest::Approx(1));
            CHECK(mesh.normals[k].dot(a.cross(b)) > 0);
        }
    }
}

TEST_CASE("mesh: a narrow crescent between two arcs does not fold") {
    // Two arcs from (-1, 0) to (1, 0) whose chords would cross at any coarse sampling: bulges 0.5 and 0.501.
    Cell cell;
    cell.scene.base = Plane{};
    cell.scene.box = {{-2, -2, 0}, {2, 2, 1}};
    const auto arc = [](double bulge) {
        RationalCurve3 c{2, {0, 0, 0, 1, 1, 1}, {{-1, 0, 1, 1}, {0, bulge, 1, 1}, {1, 0, 1, 1}}};
        return c;
    };
    const auto flat = [](const RationalCurve3& c, bool reversed) {
        RationalCurve2 f{2, c.knots, {}};
        for (const auto& p : c.points) f.points.push_back({p.x(), p.y(), p.w()});
        if (reversed) std::reverse(f.points.begin(), f.points.end());
        return f;
    };
    for (const double x : {-1.0, 1.0}) cell.vertices.push_back({{x, 0, 1}, 1, {}, 0});
    for (const double bulge : {1.0, 1.002}) {
        CellEdge e;
        e.vertices = {0, 1};
        e.kind = CurveKind::Parabola;
        e.curve = arc(bulge);
        cell.edges.push_back(e);
    }
    CellFace face;
    face.site = Site::box_side(5);
    TrimmedPatch patch;
    patch.surface.domain_u = patch.surface.domain_v = {-2, 2};
    for (const double x : {-2.0, 2.0})
        for (const double y : {-2.0, 2.0}) patch.surface.points.push_back({x, y, 1, 1});
    patch.loops = {{{0u, std::nullopt, false, flat(cell.edges[0].curve, false)},
                    {1u, std::nullopt, true, flat(cell.edges[1].curve, true)}}};
    face.patches = {patch};
    cell.faces = {face};
    const CellMesh mesh = tessellate(cell, {0.2, false});
    double area = 0;
    for (const Triangle& t : mesh.triangles)
        area +=
            0.5 * (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).z();
    CHECK(area > 0);
    CHECK(topology(mesh.triangles).manifold);
}

TEST_CASE("mesh: patches with parameters of their own fit together with all others") {
    Scene scene;
    scene.base = Plane{{0, 0, 0.1}, {0.1, -0.05, 1}};
    scene.objects = {Cylinder{{0, 0, 0.8}, {1, 0.3, 0.2}, 0.1}, Cylinder{{-0.5, 0.5, 0.9}, {0.2, 1, 0}, 0.15},
                     Cylinder{{2.6, 0.3, 0}, {0.3, 0.1, 1}, 0.2}, Sphere{{0.4, -0.4, 0.7}, 0.25}};
    scene.box = {{-1, -1, 0}, {1, 1, 1.5}};
    const Cell cell = voronoi_cell(scene);
    const CellMesh mesh = tessellate(cell, {.chord = 1e-4, .closed = true});
    const Topology t = topology(mesh.triangles);
    CHECK(t.manifold);
    CHECK(t.rim == 0);
    CHECK(t.euler == 2);
    CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(1e-3));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& [a, b, c] = mesh.triangles[i];
        const Vec3 across = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
        if (across.norm() < 1e-7) continue;  // slivers have no direction
        CHECK(across.dot(mesh.normals[mesh.corner_normals[i][0]]) > 0);
    }
}

// A flat square whose parameters run unevenly and slantwise over it.
TEST_CASE("mesh: how parameters run over a surface makes no triangles") {
    Cell cell;
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)})
        cell.vertices.push_back({p, 0, {}, 0});
    CellFace face;
    TrimmedPatch patch;
    patch.surface.degree_u = patch.surface.degree_v = 1;
    patch.surface.domain_u = patch.surface.domain_v = {0, 1};
    // Weights of 1 and 100: half-way between parameters is a hundredth of the way.
    patch.surface.points = {{0, 0, 0, 100}, {0, 1, 0, 100}, {1, 0, 0, 1}, {1, 1, 0, 1}};
    patch.loops.emplace_back();
    const std::array<Vec2, 4> corners{Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
    for (std::uint32_t e = 0; e < 4; ++e) {
        const Vec2 from = corners[e], to = corners[(e + 1) % 4];
        const auto weight = [](const Vec2& p) { return p.x() == 0 ? 100.0 : 1.0; };
        CellEdge edge;
        edge.vertices = {e, (e + 1) % 4};
        edge.curve = {
            1, {0, 0, 1, 1}, {{from.x(), from.y(), 0, weight(from)}, {to.x(), to.y(), 0, weight(to)}}};
        cell.edges.push_back(edge);
        patch.loops[0].push_back(
            {e, std::nullopt, false, {1, {0, 0, 1, 1}, {{from.x(), from.y(), 1}, {to.x(), to.y(), 1}}}});
    }
    face.patches = {patch};
    cell.faces = {face};
    CHECK(tessellate(cell, {1e-3, false}).triangles.size() == 2);
}

// The saddle z = x y, whose parameters are a hundred times as long one way as the other: as many triangles as
// where they are as long both ways, about.
TEST_CASE("mesh: triangles are about as round in space as they can be, whatever parameters are") {
    const auto saddle = [](double stretch) {
        Cell cell;
        CellFace face;
        TrimmedPatch patch;
        patch.surface.degree_u = patch.surface.degree_v = 1;
        patch.surface.domain_u = {-stretch, stretch};
        patch.surface.domain_v = {-1, 1};
        patch.loops.emplace_back();
        const std::array<Vec2, 4> corners{Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)};
        for (const double x : {-1.0, 1.0})
            for (const double y : {-1.0, 1.0}) patch.surface.points.push_back({x, y, x * y, 1});
        for (std::uint32_t e = 0; e < 4; ++e) {
            const Vec2 a = corners[e], b = corners[(e + 1) % 4];
            cell.vertices.push_back({{a.x(), a.y(), a.x() * a.y()}, 0, {}, 0});
            CellEdge edge;
            edge.vertices = {e, (e + 1) % 4};
            edge.curve = {
                1, {0, 0, 1, 1}, {{a.x(), a.y(), a.x() * a.y(), 1}, {b.x(), b.y(), b.x() * b.y(), 1}}};
            cell.edges.push_back(edge);
            patch.loops[0].push_back(
                {e,
                 std::nullopt,
                 false,
                 {1, {0, 0, 1, 1}, {{stretch * a.x(), a.y(), 1}, {stretch * b.x(), b.y(), 1}}}});
        }
        face.patches = {patch};
        cell.faces = {face};
        return tessellate(cell, {1e-3, false});
    };
    const CellMesh even = saddle(1), long_one = saddle(100);
    CHECK(even.triangles.size() > 100);
    CHECK(static_cast<double>(long_one.triangles.size()) < 1.5 * static_cast<double>(even.triangles.size()));
    CHECK(topology(long_one.triangles).manifold);
    for (const Vec3& p : long_one.points) CHECK(std::abs(p.z() - p.x() * p.y()) < 1e-12);
}

TEST_CASE("mesh: a face in two patches is joined along their seam") {
    // The paraboloid cut along x = -1/4: two of its edges have a part in each patch, one of them reversed.
    Cell cell = paraboloid_cell();
    std::reverse(cell.edges[2].curve.points.begin(), cell.edges[2].curve.points.end());
    std::swap(cell.edges[2].vertices[0], cell.edges[2].vertices[1]);
    const auto trim = [](std::uint32_t edge, bool reversed, double begin, double end, Vec2 from, Vec2 to) {
        return TrimCurve{edge,
                         std::nullopt,
                         reversed,
                         {1, {begin, begin, end, end}, {{from.x(), from.y(), 1}, {to.x(), to.y(), 1}}}};
    };
    const auto seam = [](double from, double to) {
        return TrimCurve{std::nullopt, 7u, false, {1, {0, 0, 1, 1}, {{-0.25, from, 1}, {-0.25, to, 1}}}};
    };
    constexpr double at = 0.375;  // of edge 0, where x = -1/4
    const TrimmedPatch whole = cell.faces[0].patches[0];
    const auto& sides = whole.loops[0];
    TrimmedPatch left = whole, right = whole;
    left.loops = {{trim(0, false, 0, at, {-1, -1}, {-0.25, -1}), seam(-1, 1),
                   trim(2, true, 1 - at, 1, {-0.25, 1}, {-1, 1}), sides[3]}};
    right.loops = {{trim(0, false, at, 1, {-0.25, -1}, {1, -1}), sides[1],
                    trim(2, true, 0, 1 - at, {1, 1}, {-0.25, 1}), seam(1, -1)}};
    cell.faces[0].patches = {left, right};
    for (const double chord : {0.1, 1e-3}) {
        const CellMesh mesh = tessellate(cell, {chord, true});
        const Topology t = topology(mesh.triangles);
        CHECK(t.manifold);
        CHECK(t.rim == 0);
        CHECK(t.euler == 2);
        CHECK(std::abs(volume(mesh) - 4 * (2.0 / 3 + 15.0 / 16) / 2.5) < 4 * chord);
        CHECK(mesh.groups.size() == 3);
    }
}

TEST_CASE("mesh: a seam that comes back to next to where it began goes all around") {
    // One side of the box cuts a little off the cap, across its patches' seam. As a chord of a hundredth lets
    // the seam be the segment between its ends, the mesh had next to no volume.
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.5};
    scene.probe = 1.5;
    for (const Vec3& high : {Vec3(1.98, 3, 1.7), Vec3(3, 1.7, 1.95), Vec3(1.95, 1.9, 3)}) {
        scene.box = {Vec3::Constant(-3), high};
        const Cell cell = voronoi_cell(scene);
        for (const double part : {0.001, 0.01, 0.03}) {
            CAPTURE(high.transpose());
            CAPTURE(part);
            const CellMesh mesh = tessellate(cell, {part * cell_diagonal(cell), true});
            const Topology t = topology(mesh.triangles);
            CHECK(t.manifold);
            CHECK(t.rim == 0);
            CHECK(t.euler == 2);
            constexpr double most_area = 4 * std::numbers::pi * 2 * 2;
            CHECK(std::abs(volume(mesh) - cell.measures.volume) < most_area * mesh.chord);
        }
    }
}

// Two edges beside each other, in many trimming curves: with a number of pieces that counted all of them the
// mesh had millions.
TEST_CASE("mesh: chords that cross those beside them are halved, and no more often") {
    const Cell cell = voronoi_cell(read_scene(test_data("chords_that_cross.json")));
    for (const double chord : {0.1, 0.05, 0.02}) {
        CAPTURE(chord);
        const CellMesh mesh = tessellate(cell, {chord, true});
        CHECK(is_closed(mesh));
        CHECK(mesh.chord == chord);
        CHECK(mesh.triangles.size() < 60000);
        CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(chord));
    }
}

TEST_CASE("mesh: triangles in needles and slits are not turned over") {
    // Seen along the normals in all of their corners, which agree.
    const auto folded_area = [](const CellMesh& mesh) {
        double area = 0;
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
            const Triangle &t = mesh.triangles[i], &n = mesh.corner_normals[i];
            const Vec3 across =
                (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]);
            bool is_over = true;
            for (std::size_t k = 0; k < 3; ++k)
                is_over = is_over && across.dot(mesh.normals[n[k]]) < -1e-3 * across.norm() &&
                          mesh.normals[n[k]].dot(mesh.normals[n[(k + 1) % 3]]) > 0.5;
            if (is_over) area += 0.5 * across.norm();
        }
        return area;
    };
    const auto mesh_of = [](const std::string& name, double chord) {
        const Cell cell = voronoi_cell(read_scene(test_data("hostile/" + name + ".json")));
        MeshOptions options;
        options.chord = chord * cell_diagonal(cell);
        options.closed = true;
        return std::pair(tessellate(cell, options), cell.measures.area + cell.measures.box_area);
    };
    for (const char* name : {"far_corners", "tip_beside_side", "needle_beside_plane", "needle_in_tube",
                             "line_touches_tube", "hole_below_errors"})
        for (const double chord : {1e-2, 1e-3}) {
            CAPTURE(name);
            CAPTURE(chord);
            const auto [mesh, area] = mesh_of(name, chord);
            CHECK(is_closed(mesh));
            // Where a needle is far thinner than the chord some triangles along its rim stand across it.
            CHECK(folded_area(mesh) <= 1e-10 * area);
        }
    // Half of the slit was twofold.
    const auto [slit, area] = mesh_of("slit_beside_ball", 1e-2);
    CHECK(folded_area(slit) <= 1e-3 * area);
    // Half a percent of the patches that bend around the line was.
    const auto [bend, bend_area] = mesh_of("line_near_tube", 1e-2);
    CHECK(is_closed(bend));
    CHECK(folded_area(bend) <= 3e-4 * bend_area);
}

TEST_CASE("mesh: normals are unit where a patch is as wide as the spacing of doubles") {
    const Cell cell = voronoi_cell(read_scene(test_data("hostile/needle_of_no_width.json")));
    for (const Vec3& n : tessellate(cell).normals) CHECK(std::abs(n.norm() - 1) < 1e-12);
}

TEST_CASE("mesh: a rim that does not close is told") {
    Cell cell = paraboloid_cell();
    cell.faces[0].patches[0].loops[0].pop_back();
    CHECK_THROWS_AS(tessellate(cell, {0.1, true}), InternalError);
}

TEST_CASE("obj: groups, materials, and indices in range") {
    const Cell cell = island_cell();
    const CellMesh mesh = tessellate(cell, {std::nullopt, true});
    std::ostringstream obj, mtl;
    write_obj(obj, cell, mesh, "cell.mtl");
    write_mtl(mtl, cell);
    std::istringstream lines(obj.str());
    std::size_t vertices = 0, normals = 0, faces = 0;
    std::set<std::string> groups, materials;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string word, name;
        words >> word;
        if (word == "v") ++vertices;
        if (word == "vn") ++normals;
        if (word == "g" && words >> name) groups.insert(name);
        if (word == "usemtl" && words >> name) materials.insert(name);
        if (word != "f") continue;
        ++faces;
        for (std::string corner; words >> corner;) {
            std::size_t v = 0, n = 0;
            REQUIRE(std::sscanf(corner.c_str(), "%zu//%zu", &v, &n) == 2);
            CHECK((v >= 1 && v <= vertices && n >= 1 && n <= normals));
        }
    }
    CHECK(faces == mesh.triangles.size());
    CHECK(vertices == mesh.points.size());
    CHECK(groups == std::set<std::string>{"face_0_object_0", "face_1_box_+z", "walls", "base", "edges"});
    for (const std::string& m : materials) CHECK(mtl.str().find("newmtl " + m + "\n") != std::string::npos);
    std::ostringstream plain;
    write_obj(plain, cell, mesh, "");
    CHECK(plain.str().find("mtl") == std::string::npos);
}
