// Whole diagrams in files: what each format has of every cell.
#include "../../io/pictures/diagram_output.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../io/files/files.hpp"
#include "temporary_directory.hpp"
#include "vtu_arrays.hpp"

namespace vcell {

using testing::array_of;
using testing::take;
using testing::TemporaryDirectory;

namespace {

/// Balls, one of them with a name that is not ASCII, over a plane and beside a tube.
DiagramScene mixed_scene() {
    DiagramScene scene;
    scene.box = {{0, 0, 0}, {4, 4, 4}};
    scene.objects = {Sphere{{1, 1, 2}, 0.5}, Sphere{{3, 1, 2}, 0.25}, Plane{{0, 0, 0.5}, {0, 0, 1}},
                     Cylinder{{2, 3, 2.5}, {1, 0, 0}, 0.25}};
    scene.names = {"B'\u00e9\\", "", "floor", "rod"};
    return scene;
}

std::size_t times_in(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += what.size()) ++n;
    return n;
}

std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
    const std::regex wanted(pattern);
    std::vector<std::string> all;
    for (std::sregex_iterator m(text.begin(), text.end(), wanted); m != std::sregex_iterator(); ++m)
        all.push_back((*m)[1]);
    return all;
}

}  // namespace

TEST_CASE("diagram files: exact formats have every cell") {
    const TemporaryDirectory folder;
    const DiagramScene scene = mixed_scene();
    DiagramFiles files({folder.file("all.step"), folder.file("all.itd"), folder.file("all.bezier.vtu")});
    std::map<std::uint32_t, int> cells;
    std::size_t patches = 0, edges = 0;
    DiagramOptions options;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        ++cells[object];
        edges += cell.edges.size();
        for (const CellFace& face : cell.faces) patches += face.patches.size();
    };
    const VoronoiDiagram diagram = files.compute(scene, options);
    CHECK(filled_volume(scene, diagram).fills());
    CHECK(files.without_faces().empty());
    CHECK(folder.count() == 0);
    files.commit();
    // The plane has a cell on either side.
    CHECK(cells == std::map<std::uint32_t, int>{{0, 1}, {1, 1}, {2, 2}, {3, 1}});

    const std::string step = read_file(folder.file("all.step"));
    CHECK(matches(step, R"(MANIFOLD_SOLID_BREP\('(.*)',#\d+\);)") ==
          std::vector<std::string>{R"(cell 0 (B''\X2\00E9\X0\\\))", "cell 1", "cell 2 (floor)",
                                   "cell 2 (floor)", "cell 3 (rod)"});
    CHECK(times_in(step, "STYLED_ITEM(") == 5);
    CHECK(times_in(step, "PRODUCT(") == 1);
    std::map<std::string, int> balance;
    for (const std::string& edge : matches(step, R"(ORIENTED_EDGE\('',\*,\*,#(\d+,\.[TF]\.)\))"))
        balance[edge.substr(0, edge.find(','))] += edge.ends_with(".T.") ? 1 : -1;
    CHECK(balance.size() == times_in(step, "EDGE_CURVE("));
    CHECK(std::ranges::all_of(balance, [](const auto& b) { return b.second == 0; }));

    const std::string itd = read_file(folder.file("all.itd"));
    const std::vector<std::string> names = matches(itd, R"((CELL\d+B?_[A-Z]+\d+(?:_\d+)?)\s)");
    CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
    CHECK(times_in(itd, "[TRIMSRF") == patches);
    CHECK(times_in(itd, "_EDGE") == edges);
    CHECK(times_in(itd, " CELL2B_FACE") > 0);

    const std::string elements = read_file(folder.file("all.bezier.vtu"));
    const std::string types = array_of(elements, "types"), numbers = array_of(elements, "cell");
    CHECK(std::ranges::count(types, char(77)) == static_cast<std::ptrdiff_t>(patches));
    std::set<std::int32_t> told;
    for (std::size_t at = 0; at < numbers.size();) told.insert(take<std::int32_t>(numbers, at));
    CHECK(told == std::set<std::int32_t>{0, 1, 2, 3});
}

TEST_CASE("diagram files: images are named by their objects") {
    const TemporaryDirectory folder;
    DiagramScene scene;
    scene.box = {{0, 0, 0}, {2, 2, 2}};
    scene.periodic = {true, true, true};
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.25}};
    DiagramFiles files({folder.file("all.stp"), folder.file("all.itd"), folder.file("all.bezier.vtu")});
    files.compute(scene);
    files.commit();
    const std::set<std::string> images{"0(-1,0,0)", "0(0,-1,0)", "0(0,0,-1)",
                                       "0(0,0,1)",  "0(0,1,0)",  "0(1,0,0)"};
    const auto faces = matches(read_file(folder.file("all.stp")), R"(ADVANCED_FACE\('([^']*)')");
    CHECK(std::set<std::string>(faces.begin(), faces.end()) == images);
    const auto beyond = matches(read_file(folder.file("all.itd")), R"lim(\[neighbor "([^"]*)"\])lim");
    CHECK(std::set<std::string>(beyond.begin(), beyond.end()) == images);
    const std::string neighbors = array_of(read_file(folder.file("all.bezier.vtu")), "neighbor");
    for (std::size_t at = 0; at < neighbors.size();) CHECK(take<std::int32_t>(neighbors, at) == 0);
}

TEST_CASE("diagram files: cells that have measures alone are named") {
    const TemporaryDirectory folder;
    DiagramScene scene;
    scene.box = {{-2, -2, -2}, {2, 2, 2}};
    scene.objects = {Cylinder{{0, 0, 0}, {1, 0, 0}, 0.25}, HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1.5},
                     Sphere{{0, 0, 1.5}, 0.25}};
    DiagramFiles files({folder.file("all.step")});
    const VoronoiDiagram diagram = files.compute(scene);
    files.commit();
    CHECK(diagram.cells[0].state == DiagramCell::State::Computed);
    CHECK(files.without_faces() == std::vector<std::uint32_t>{0});
    CHECK(times_in(read_file(folder.file("all.step")), "MANIFOLD_SOLID_BREP(") == 1);
}

TEST_CASE("diagram files: meshes of all cells have no more triangles than asked for") {
    const TemporaryDirectory folder;
    const DiagramScene scene = mixed_scene();
    const auto size = [&](double chord, std::optional<std::size_t> most) {
        DiagramFiles files({folder.file("all.vtu"), folder.file("all.json")},
                           {.chord = chord, .cut = std::nullopt, .most_triangles = most});
        std::size_t seen = 0;
        double done = 0;
        DiagramOptions options;
        options.visit = [&](std::uint32_t, const Cell&) { ++seen; };
        options.progress = [&](double fraction) {
            CHECK(fraction >= done);
            done = fraction;
        };
        files.compute(scene, options);
        files.commit();
        CHECK(seen == 5);
        REQUIRE(files.mesh_size());
        const std::string numbers = array_of(read_file(folder.file("all.vtu")), "cell");
        CHECK(files.mesh_size()->triangles == numbers.size() / sizeof(std::int32_t));
        return *files.mesh_size();
    };
    const auto plain = size(0.002, std::nullopt);
    CHECK(plain.chord == 0.002);
    const std::string unbounded = read_file(folder.file("all.vtu"));
    const auto same = size(0.002, plain.triangles);
    CHECK(same.chord == 0.002);
    CHECK(same.triangles == plain.triangles);
    CHECK(read_file(folder.file("all.vtu")) == unbounded);
    // The chord grows by the same factor until all fits, and no farther.
    const auto coarser = size(0.002, plain.triangles - 1);
    CHECK(coarser.chord == chord_step * 0.002);
    CHECK(coarser.triangles < plain.triangles);
    CHECK(size(coarser.chord, std::nullopt).triangles == coarser.triangles);
    CHECK(size(1e-9, plain.triangles).triangles <= plain.triangles);
    const std::size_t least = size(1, std::nullopt).triangles;
    CHECK(size(0.002, least).triangles <= least);
    DiagramFiles refused({folder.file("none.vtu")}, {.chord = 0.002, .cut = {}, .most_triangles = least - 1});
    CHECK_THROWS_AS(refused.compute(scene), TooManyTriangles);
    DiagramFiles exact({folder.file("all.step")}, {.chord = 0.002, .cut = {}, .most_triangles = 1});
    exact.compute(scene);
    CHECK(!exact.mesh_size());
}

TEST_CASE("diagram files: wrong ones are told before anything is computed") {
    const TemporaryDirectory folder;
    const auto complaint = [&](const std::vector<std::string>& paths,
                               const DiagramFileOptions& options = {}) {
        try {
            DiagramFiles files(paths, options);
        } catch (const std::invalid_argument& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    CHECK(complaint({folder.file("all.xyz")}).find("must end in") != std::string::npos);
    CHECK(complaint({folder.file("all.svg")}).find("takes a plane") != std::string::npos);
    CHECK(complaint({folder.file("all.svg")},
                    {.chord = 0.01, .cut = DiagramFileOptions::Cut{2, 0}, .most_triangles = {}})
              .empty());
    CHECK(complaint({folder.file("all.obj"), folder.file("all.stl")}).empty());
    CHECK(complaint({folder.file("a.stl"), folder.file("a.stl")}).find("given twice") != std::string::npos);
    CHECK_THROWS_AS(DiagramFiles({folder.file("absent/all.stl")}), WriteError);
    CHECK(folder.count() == 0);
}

}  // namespace vcell
