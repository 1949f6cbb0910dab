/// Cells of planes in hollow spheres: their files, what certify() says of them, their solids.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/measures/clearance_places.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/solids/moments.hpp"
#include "../../io/solids/shell.hpp"
#include "closed_meshes.hpp"
#include "listing.hpp"
#include "stored_diagrams.hpp"

namespace vcell {
namespace {

Scene over(const Plane& base, std::vector<Object> objects) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    scene.box = {{-2, -2, -2}, {2, 2, 2}};
    return scene;
}

const Plane level{{0, 0, 0.125}, {0, 0, 1}};

std::vector<Scene> floors() {
    std::vector<Scene> scenes{
        over(level, {HollowSphere{{0.25, 0, 0.5}, 1.25}}),
        over(level, {HollowSphere{{0.25, 0, 0.5}, 1.25}, Sphere{{0.5, 0.25, 0.5}, 0.25},
                     Sphere{{-0.5, 0.125, 0.5}, 0.25}}),
        over(level, {HollowSphere{{0.5, 0, 0}, 1.25}, HollowSphere{{-0.5, 0.25, 0.5}, 1.5},
                     Plane{{0, 0, 1}, {0.25, 0, 1}}}),
        over({{0, 0, 0.125}, {0.125, 0.25, 1}},
             {HollowSphere{{0.25, 0, 0.5}, 1.25}, Sphere{{0.5, 0.25, 0.875}, 0.25}}),
        over(level, {HollowSphere{{0.25, 0, 0.5}, 1.75}, Sphere{{0.5, 0.25, 0.5}, 0.25}}),
        over(level, {HollowSphere{{0.25, 0, 0.5}, 1.25}, Cylinder{{0, 0, 0.75}, {1, 0.5, 0.125}, 0.125}}),
    };
    scenes[4].box.max.x() = 1;
    return scenes;
}

bool has_refuted(const Certificate& c, const std::string& where) {
    return std::ranges::any_of(c.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && e.where.starts_with(where);
    });
}

}  // namespace

TEST_CASE("planes in vessels: cells survive their files, are certified and closed") {
    const std::vector<Scene> scenes = floors();
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        CAPTURE(i);
        Cell cell = voronoi_cell(scenes[i]);
        cell.clearance_places = clearance_places(cell);
        cell.moments = moments_of(cell);
        std::stringstream file;
        write_cell(file, cell);
        const Certificate good = certify(parse_cell(file.str()));
        CHECK_MESSAGE(good.holds(), listing(good));
        const CellMesh mesh = tessellate(cell, {std::nullopt, true});
        CHECK(is_closed(mesh));
        CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(0.02));
        const Solid solid = solid_of(closed_shell(cell), cell.faces.size());
        CHECK(solid.parts.size() == 1);
        CHECK(solid.off < 1e-5);
    }
}

// A top in the box was taken for the cell's, though the way to it begins beyond a side.
TEST_CASE("planes in vessels: where the top's foot is beyond the box the cell is less high") {
    Scene scene = over({{0, 0, 0}, {-0.75, 0, 1}}, {HollowSphere{{0.25, 0, 0.5}, 1.25}});
    for (const double side : {0.3, 0.5}) {
        CAPTURE(side);
        scene.box.max.x() = side;
        const Cell cell = voronoi_cell(scene);
        CHECK((cell.measures.max_clearance < 0.749) == (side == 0.3));
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));
        CellOptions options;
        options.complete = true;
        const Certificate complete = certify(voronoi_cell(scene, options));
        CHECK_MESSAGE(complete.holds(), listing(complete));
    }
}

TEST_CASE("planes in vessels: complete cells of planes that lean are certified") {
    CellOptions options;
    options.complete = true;
    Scene scene = floors()[3];
    scene.box.min.z() = -0.25;
    const Cell cell = voronoi_cell(scene, options);
    CHECK(cell.is_complete);
    const Certificate good = certify(cell);
    CHECK_MESSAGE(good.holds(), listing(good));
}

TEST_CASE("planes in vessels: damage is refuted") {
    const Cell cell = voronoi_cell(floors()[1]);
    const auto expect = [&](const std::string& where, const std::function<void(Cell&)>& damage) {
        Cell bad = cell;
        damage(bad);
        const Certificate c = certify(bad, {50, 1, 4});
        CHECK_MESSAGE(has_refuted(c, where), "expected ", where, ", found\n", listing(c));
    };
    const auto rim = static_cast<std::size_t>(
        std::ranges::find_if(cell.edges, [](const CellEdge& e) { return e.sites[0] == e.sites[1]; }) -
        cell.edges.begin());
    REQUIRE(rim < cell.edges.size());
    const std::string at_rim = "edges[" + std::to_string(rim);
    expect(at_rim, [&](Cell& bad) {
        for (Eigen::Vector4d& p : bad.edges[rim].curve.points) p.x() = 0.25 + 0.999 * (p.x() - 0.25);
    });
    expect(at_rim, [&](Cell& bad) {
        for (Eigen::Vector4d& p : bad.edges[rim].curve.points) p.z() += 1e-6;
    });
    expect(at_rim, [&](Cell& bad) { bad.edges[rim].kind = CurveKind::Ellipse; });
    // All of the wall is elsewhere than where the faces end.
    expect(at_rim, [](Cell& bad) { std::get<HollowSphere>(bad.scene.objects[0]).radius += 1e-6; });
    expect("measures.base_area", [](Cell& bad) { bad.measures.base_area *= 1 + 1e-6; });
    expect("measures.volume", [](Cell& bad) { bad.measures.volume *= 1 + 1e-6; });
    expect("measures.max_clearance", [](Cell& bad) { bad.measures.max_clearance *= 0.999; });
    expect("measures.touches_box", [](Cell& bad) { bad.measures.touches_box = true; });
    expect("faces", [](Cell& bad) {
        bad.faces.pop_back();
        bad.neighbors.pop_back();
    });
    expect("faces[0]", [](Cell& bad) { bad.faces[0].bisector = "plane"; });
}

TEST_CASE("planes in vessels: a diagram of balls over a floor in a hollow sphere is proved") {
    DiagramScene scene;
    scene.objects = {Plane{{0, 0, -0.5}, {0.25, 0, 1}}, HollowSphere{{0, 0, 0}, 1.5},
                     Sphere{{0.25, 0, 0.5}, 0.375}, Sphere{{-0.5, 0.25, 0.25}, 0.25}};
    scene.box = {Vec3::Constant(-1.75), Vec3::Constant(1.75)};
    const StoredDiagram diagram = stored(scene, true);
    CHECK(std::ranges::count_if(diagram.cells, [](const auto& c) { return c.first == 0; }) == 2);
    check_proved(certify(diagram));
}

}  // namespace vcell
