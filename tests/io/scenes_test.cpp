#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <boost/property_tree/xml_parser.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/io.hpp"
#include "../test_support.hpp"
#include "sample_cells.hpp"

using namespace vcell;
namespace fs = std::filesystem;

namespace {

std::vector<std::string> example_scenes() {
    std::vector<std::string> paths;
    for (const auto& entry : fs::directory_iterator(VCELL_EXAMPLE_SCENES))
        if (entry.path().extension() == ".json") paths.push_back(entry.path().string());
    std::sort(paths.begin(), paths.end());
    return paths;
}

}  // namespace

TEST_CASE("example scenes: cells survive the file and pass the check") {
    CHECK(example_scenes().size() >= 16);
    for (const std::string& path : example_scenes()) {
        CAPTURE(path);
        const Cell cell = voronoi_cell(read_scene(path));
        const std::string text = cell_text(cell);
        const Cell read = parse_cell(text);
        CHECK(cell_text(read) == text);
        for (const Finding& f : check_cell(read)) FAIL_CHECK(f.where << ": " << f.what);
    }
}

TEST_CASE("example scenes: figures hold the objects and the curves that the paper says") {
    struct Figure {
        const char* name;
        std::size_t base, planes, spheres, cylinders;  // base: of Object's alternatives
    };
    for (const auto& [name, base, planes, spheres, cylinders] : {Figure{"figure1", 0, 0, 2, 0},
                                                                 {"figure2", 0, 0, 3, 0},
                                                                 {"figure7", 1, 0, 3, 0},
                                                                 {"figure8", 1, 0, 6, 0},
                                                                 {"figure9", 1, 2, 2, 0},
                                                                 {"figure10", 2, 2, 1, 0}}) {
        CAPTURE(name);
        const Scene scene = read_scene(VCELL_EXAMPLE_SCENES "/" + std::string(name) + ".json");
        std::array<std::size_t, 3> count{};
        for (const Object& o : scene.objects) ++count[o.index()];
        CHECK(scene.base.index() == base);
        CHECK(count == std::array{planes, spheres, cylinders});
        const Cell cell = voronoi_cell(scene);
        CHECK(cell.neighbors.size() == scene.objects.size());
        std::map<CurveKind, std::size_t> all, between_objects;
        for (const CellEdge& e : cell.edges) {
            ++all[e.kind];
            if (e.sites[0].is_object() && e.sites[1].is_object()) ++between_objects[e.kind];
        }
        if (name == std::string("figure10")) {
            CHECK(between_objects ==
                  std::map<CurveKind, std::size_t>{{CurveKind::Ellipse, 1}, {CurveKind::Spline, 2}});
        } else {
            CHECK_FALSE(all.contains(CurveKind::Spline));
            CHECK_FALSE(between_objects.empty());
        }
    }
}

TEST_CASE("example scenes: cells without measures differ in nothing else") {
    CellOptions options;
    options.measure = false;
    for (const char* name :
         {"figure6", "four_balls_two_planes", "ball_tube_plane", "tube_three_balls_plane"}) {
        CAPTURE(name);
        const Scene scene = read_scene(VCELL_EXAMPLE_SCENES "/" + std::string(name) + ".json");
        const Cell measured = voronoi_cell(scene);
        Cell cell = voronoi_cell(scene, options);
        CHECK(std::isnan(cell.measures.volume));
        CHECK(std::isnan(cell.measures.body_volume));
        CHECK(std::isnan(cell.measures.max_clearance));
        CHECK(std::ranges::is_sorted(cell.neighbors));
        CHECK(std::ranges::is_permutation(cell.neighbors, measured.neighbors));
        REQUIRE(cell.edges.size() == measured.edges.size());
        REQUIRE(cell.faces.size() == measured.faces.size());
        for (std::size_t e = 0; e < cell.edges.size(); ++e) {
            CHECK(std::isnan(cell.edges[e].length));
            cell.edges[e].length = measured.edges[e].length;
            cell.edges[e].length_error = measured.edges[e].length_error;
            cell.edges[e].is_estimated = measured.edges[e].is_estimated;  // says what length_error is
        }
        for (std::size_t f = 0; f < cell.faces.size(); ++f) {
            CHECK(std::isnan(cell.faces[f].area));
            cell.faces[f].area = measured.faces[f].area;
            cell.faces[f].area_error = measured.faces[f].area_error;
            cell.faces[f].is_estimated = measured.faces[f].is_estimated;
        }
        cell.measures = measured.measures;
        cell.neighbors = measured.neighbors;
        cell.report = measured.report;
        CHECK(cell_text(cell) == cell_text(measured));
    }
}

TEST_CASE("example scenes: the closed mesh is a sphere's and holds the cell's volume") {
    for (const std::string& path : example_scenes()) {
        CAPTURE(path);
        const Cell cell = voronoi_cell(read_scene(path));
        const double chord = (rounds() > 1 ? 1e-4 : 1e-3) * cell.scene.box.diagonal();
        const CellMesh mesh = tessellate(cell, {chord, true});
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
        std::set<std::uint32_t> vertices;
        double six_volumes = 0;
        for (const Triangle& t : mesh.triangles) {
            for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}], vertices.insert(t[k]);
            const Vec3 a = mesh.points[t[0]], b = mesh.points[t[1]], c = mesh.points[t[2]];
            six_volumes += (Eigen::Matrix3d() << a, b, c).finished().determinant();
        }
        bool manifold = true;
        for (const auto& [side, count] : sides)
            manifold = manifold && count == 1 && sides.contains({side.second, side.first});
        CHECK(manifold);
        CHECK(vertices.size() + mesh.triangles.size() == sides.size() / 2 + 2);
        // Every triangle stays within a small multiple of the chord of the surface.
        CHECK(std::abs(six_volumes / 6 - cell.measures.volume) < 2 * chord * cell.measures.area);
    }
}

TEST_CASE("example scenes: the picture shows every face, edge and vertex") {
    for (const std::string& path : example_scenes()) {
        CAPTURE(path);
        const Cell cell = voronoi_cell(read_scene(path));
        std::stringstream svg;
        write_svg(svg, cell);
        boost::property_tree::ptree document;
        boost::property_tree::read_xml(svg, document);
        std::map<std::string, std::size_t> count;
        for (const auto& [name, element] : document.get_child("svg.g")) {
            const auto css = element.get<std::string>("<xmlattr>.class", "");
            ++count[css.substr(0, css.find(' '))];
        }
        CHECK(count["face"] == cell.faces.size());
        CHECK(count["edge"] == cell.edges.size());
        CHECK(count["vertex"] == cell.vertices.size());
    }
}
