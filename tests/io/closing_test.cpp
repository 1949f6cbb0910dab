// What closes cells in their files: it is there, it goes round, the check proves it, and refutes what is
// damaged.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/solids/shell.hpp"
#include "damages.hpp"
#include "listing.hpp"
#include "sample_cells.hpp"

namespace vcell {

using namespace damages;

namespace {

Cell read_back(const Cell& cell) { return parse_cell(cell_text(cell)); }

Cell complete(Scene scene) {
    CellOptions options;
    options.complete = true;
    return voronoi_cell(std::move(scene), options);
}

/// Between two balls, in a box that ends above one of its edges.
Scene leaning_base() {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0.5, 0.25, 1}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Sphere{{0.5, 0, 1.25}, 0.25}, Sphere{{-0.75, -0.5, 1.5}, 0.125}};
    return scene;
}

const Cell& closed(const std::string& name) {
    static std::map<std::string, Cell> cells;
    if (!cells.contains(name)) {
        if (name == "complete")
            cells[name] = read_back(complete(leaning_base()));
        else if (name == "leaning base")
            cells[name] = read_back(voronoi_cell(leaning_base()));
        else
            cells[name] = read_back(good(name));
    }
    return cells[name];
}

std::size_t count(const Closing& closing, const std::string& bisector) {
    return static_cast<std::size_t>(
        std::ranges::count_if(closing.faces, [&](const CellFace& f) { return f.bisector == bisector; }));
}

std::uint32_t face_of(const Cell& c, const std::string& bisector) {
    return first(c.closing->faces, [&](const CellFace& f) { return f.bisector == bisector; });
}
TrimmedPatch& patch_of(Cell& c, const std::string& bisector) {
    return c.closing->faces[face_of(c, bisector)].patches[0];
}

/// Refuted at that place, or a part of it.
void expect_refuted(const std::string& name, const std::string& what, const std::string& where,
                    const std::function<void(Cell&)>& damage) {
    CAPTURE(name);
    CAPTURE(what);
    Cell bad = closed(name);
    damage(bad);
    const Certificate certificate = certify(bad);
    const bool refuted = std::ranges::any_of(certificate.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && e.where.starts_with(where);
    });
    CHECK_MESSAGE(refuted, "expected ", where, ", found\n", listing(certificate));
}

}  // namespace

TEST_CASE(
    "closing: over a plane walls and the base's region, around a tube two ends, around a ball nothing") {
    const Cell& over_plane = closed("balls");
    REQUIRE(over_plane.closing);
    CHECK(count(*over_plane.closing, "wall") == 4);
    CHECK(count(*over_plane.closing, "base") == 1);
    CHECK(over_plane.closing->faces.size() == 5);
    CHECK(over_plane.closing->vertices.size() == 4);
    CHECK(over_plane.closing->edges.size() == 8);
    for (const CellVertex& foot : over_plane.closing->vertices) {
        CHECK(foot.point.cwiseAbs() == Vec3(2, 2, 0));
        CHECK(foot.error < 1e-12);
    }
    const Cell& around_tube = closed("tubes around a tube");
    REQUIRE(around_tube.closing);
    CHECK(count(*around_tube.closing, "end") == 2);
    CHECK(around_tube.closing->faces.size() == 2);
    CHECK(around_tube.closing->vertices.empty());
    CHECK_FALSE(closed("atom").closing);
    CHECK(cell_text(closed("atom")).find("closing") == std::string::npos);
}

TEST_CASE("closing: a file with it reads back to the same text") {
    for (const char* name : {"balls", "tubes over a plane", "tubes around a tube", "complete"}) {
        CAPTURE(name);
        const std::string text = cell_text(closed(name));
        CHECK(cell_text(parse_cell(text)) == text);
    }
    // What a file has is written again, and not made anew.
    Cell cell = closed("balls");
    cell.closing->faces.pop_back();
    CHECK(read_back(cell).closing->faces.size() == 4);
}

TEST_CASE("closing: is proved, each of its elements and the whole") {
    for (const char* name :
         {"balls", "lattice", "needle", "twin planes", "tube lattice", "hexagonal tubes",
          "tubes over a plane", "tubes around a tube", "around a cylinder", "leaning base", "complete"}) {
        CAPTURE(name);
        const Cell& cell = closed(name);
        REQUIRE(cell.closing);
        const Certificate certificate = certify(cell);
        CHECK_MESSAGE(certificate.holds(), listing(certificate));
        std::size_t elements = 0;
        double most = 0;
        for (const Element& e : certificate.elements)
            if (e.where.starts_with("closing")) {
                ++elements;
                most = std::max(most, e.amount);
            }
        CHECK(elements ==
              cell.closing->vertices.size() + cell.closing->edges.size() + cell.closing->faces.size() + 1);
        CHECK(most <= 1e-6 * cell.scene.box.diagonal());
    }
    // Without objects, and in units that are no one's.
    for (const double unit : {1e-40, 1.0, 0x1p100}) {
        Scene scene = over_the_plane({Sphere{{0, 0, unit}, 0.25 * unit}}, 2 * unit, 2 * unit);
        const Certificate certificate = certify(read_back(voronoi_cell(scene)));
        CHECK_MESSAGE(certificate.holds(), listing(certificate));
        scene.objects.clear();
        CHECK(certify(read_back(voronoi_cell(scene))).holds());
    }
    const Certificate island = certify(read_back(voronoi_cell(example("island"))));
    CHECK_MESSAGE(island.holds(), listing(island));
}

TEST_CASE("closing: where an edge of the box lies on the base there is no wall") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {1, 0, 1}};
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    scene.objects = {Sphere{{3, -3, 3}, 0.25}, Sphere{{0, 1, 2}, 0}};
    const Cell cell = read_back(voronoi_cell(scene));
    REQUIRE(cell.closing);
    CHECK(count(*cell.closing, "wall") == 2);
    CHECK(count(*cell.closing, "base") == 1);
    const Certificate certificate = certify(cell);
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
}

TEST_CASE("closing: a face that is missing, twice there, or not closed") {
    for (const char* name : {"balls", "tubes over a plane", "leaning base"}) {
        expect_refuted(name, "no walls, no floor", "edges[", [](Cell& c) { c.closing->faces.clear(); });
        expect_refuted(name, "nothing at all", "edges[", [](Cell& c) { c.closing.emplace(); });
        expect_refuted(name, "a wall missing", "edges[", [](Cell& c) {
            c.closing->faces.erase(c.closing->faces.begin() + face_of(c, "wall"));
        });
        expect_refuted(name, "a wall missing", "closing.edges[", [](Cell& c) {
            c.closing->faces.erase(c.closing->faces.begin() + face_of(c, "wall"));
        });
        expect_refuted(name, "no floor", "closing.edges[", [](Cell& c) {
            c.closing->faces.erase(c.closing->faces.begin() + face_of(c, "base"));
        });
        expect_refuted(name, "a wall twice", "closing.edges[",
                       [](Cell& c) { c.closing->faces.push_back(c.closing->faces[face_of(c, "wall")]); });
        expect_refuted(name, "a loop that does not close", "closing.faces[0].patches[0].loops[0]",
                       [](Cell& c) { c.closing->faces[0].patches[0].loops[0].pop_back(); });
        expect_refuted(name, "an edge turned in its loop", "closing.faces[0].patches[0].loops[0]",
                       [](Cell& c) {
                           bool& reversed = c.closing->faces[0].patches[0].loops[0][0].reversed;
                           reversed = !reversed;
                       });
        expect_refuted(name, "an edge turned", "closing.edges[0]", [](Cell& c) {
            std::swap(c.closing->edges[0].vertices[0], c.closing->edges[0].vertices[1]);
        });
        expect_refuted(name, "an edge turned, its curve too", "closing.faces[", [](Cell& c) {
            CellEdge& e = c.closing->edges[0];
            std::swap(e.vertices[0], e.vertices[1]);
            std::swap(e.curve.points[0], e.curve.points[1]);
        });
        expect_refuted(name, "a loop the other way round", "closing.faces[0].patches[0].loops[0]",
                       [](Cell& c) { std::ranges::reverse(c.closing->faces[0].patches[0].loops[0]); });
    }
    expect_refuted("tubes around a tube", "an end missing", "edges[",
                   [](Cell& c) { c.closing->faces.pop_back(); });
    expect_refuted("around a cylinder", "an end twice", "edges[",
                   [](Cell& c) { c.closing->faces.push_back(c.closing->faces[0]); });
    expect_refuted("complete", "no floor", "edges[", [](Cell& c) { c.closing->faces.pop_back(); });
    expect_refuted("atom", "a floor under a ball", "closing.faces[0].site", [](Cell& c) {
        c.closing.emplace();
        c.closing->faces.push_back(closed("balls").closing->faces[face_of(closed("balls"), "base")]);
        for (TrimCurve& trim : c.closing->faces[0].patches[0].loops[0]) trim.edge = 0;
    });
}

TEST_CASE("closing: faces, lines and feet that are not where they belong") {
    const auto shift = [](const char* bisector, const Vec3& by) {
        return [bisector, by](Cell& c) {
            for (auto& p : patch_of(c, bisector).surface.points) p.head<3>() += by;
        };
    };
    for (const double by : {1e-6, 1e-2}) {
        CAPTURE(by);
        for (const char* name : {"balls", "leaning base"}) {
            const Vec3 up = by * std::get<Plane>(closed(name).scene.base).normal.normalized();
            expect_refuted(name, "a wall shifted", "closing.faces[0].patches[0]",
                           shift("wall", by * Vec3(1, 1, 0)));
            expect_refuted(name, "a wall shifted along itself", "closing.faces[0].patches[0].loops[0]",
                           shift("wall", up));
            const std::string floor = "closing.faces[" + std::to_string(face_of(closed(name), "base")) + "]";
            expect_refuted(name, "a floor shifted", floor + ".patches[0]", shift("base", up));
            expect_refuted(name, "a foot raised", "closing.vertices[0].point",
                           [&](Cell& c) { c.closing->vertices[0].point += up; });
            expect_refuted(name, "a foot moved, and the more error", "closing.vertices[0]", [&](Cell& c) {
                c.closing->vertices[0].point.x() += by;
                c.closing->vertices[0].error = 1;
            });
            expect_refuted(name, "a line bent", "closing.edges[0].curve", [&](Cell& c) {
                RationalCurve3& curve = c.closing->edges[0].curve;
                const Eigen::Vector4d a = curve.points[0], b = curve.points[1];
                curve.degree = 2;
                curve.knots = {0, 0, 0, 1, 1, 1};
                curve.points = {a, 0.5 * (a + b) + by * Eigen::Vector4d::UnitX(), b};
            });
        }
        expect_refuted("around a cylinder", "an end shifted", "closing.faces[0].patches[0]",
                       shift("end", by * Vec3::UnitZ()));
    }
    // The wall, its lines and its feet moved together: they fit each other, and are not on the box's side.
    expect_refuted("balls", "a wall moved with all of its own", "closing.vertices[", [](Cell& c) {
        const Vec3 by(1e-3, 0, 0);
        for (CellVertex& v : c.closing->vertices) v.point += by;
        for (CellEdge& e : c.closing->edges)
            for (auto& p : e.curve.points) p.head<3>() += by;
        for (CellFace& f : c.closing->faces)
            for (auto& p : f.patches[0].surface.points) p.head<3>() += by;
    });
    expect_refuted("balls", "a wall seen from inside", "closing.faces[0].patches[0]", [](Cell& c) {
        TrimmedPatch& patch = patch_of(c, "wall");
        std::swap(patch.surface.points[1], patch.surface.points[2]);
        std::swap(patch.surface.domain_u, patch.surface.domain_v);
        for (TrimCurve& trim : patch.loops[0])
            for (auto& p : trim.curve.points) std::swap(p[0], p[1]);
    });
    expect_refuted("balls", "a wall of another site", "closing.faces[0]",
                   [](Cell& c) { c.closing->faces[0].site = Site::box_side(5); });
    expect_refuted("balls", "an object's wall", "closing.faces[0].site",
                   [](Cell& c) { c.closing->faces[0].site = Site::object(0); });
    expect_refuted("balls", "a wall by another name", "closing.faces[0].bisector",
                   [](Cell& c) { c.closing->faces[0].bisector = "box"; });
    expect_refuted("balls", "errors that promise nothing", "closing.vertices[0].error",
                   [](Cell& c) { c.closing->vertices[0].error = 1e6; });
    expect_refuted("balls", "errors that promise nothing", "closing.edges[0].error",
                   [](Cell& c) { c.closing->edges[0].error = 1e6; });
    expect_refuted("balls", "an edge that is not there", "closing.faces[0].patches[0].loops[0][0]",
                   [](Cell& c) { c.closing->faces[0].patches[0].loops[0][0].edge = 10'000; });
    expect_refuted("balls", "a vertex that is not there", "closing.edges[0].vertices",
                   [](Cell& c) { c.closing->edges[0].vertices[0] = 10'000; });
    expect_refuted("balls", "not a number", "closing.vertices[0].point",
                   [](Cell& c) { c.closing->vertices[0].point.x() = not_measured; });
}

}  // namespace vcell
