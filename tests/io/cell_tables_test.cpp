// Tables of a cell: what they list is the cell's, dihedral angles are those of the patches as written, and of
// polyhedra that are known.
#include "../../io/files/cell_tables.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../first_cell.hpp"
#include "../test_support.hpp"

using namespace vcell;

namespace {

using Row = std::vector<std::string>;

std::vector<Row> rows(const std::string& text) {
    std::vector<Row> all;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        Row& row = all.emplace_back();
        std::istringstream words(line);
        for (std::string word; std::getline(words, word, '\t');) row.push_back(word);
    }
    return all;
}

template <class Write>
std::vector<Row> table(Write write, const Cell& cell, std::size_t columns) {
    std::ostringstream out;
    write(out, cell);
    std::vector<Row> all = rows(out.str());
    for (const Row& row : all) REQUIRE(row.size() == columns);
    all.erase(all.begin());
    return all;
}

/// Out of the cell, of each face beside the edge, in the middle of its curve, from the patches.
std::vector<Vec3> normals_beside(const Cell& cell, std::size_t edge) {
    std::vector<Vec3> normals;
    const RationalCurve3& curve = cell.edges[edge].curve;
    const double middle = 0.5 * (curve.domain_begin() + curve.domain_end());
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop) {
                    if (trim.edge != edge) continue;
                    const double begin = trim.curve.domain_begin(), end = trim.curve.domain_end(),
                                 t = trim.reversed ? begin + end - middle : middle;
                    if (t < begin || t > end) continue;
                    const Eigen::Vector2d uv = trim.curve.evaluate(t);
                    const auto [du, dv] = patch.surface.partials(uv.x(), uv.y());
                    normals.push_back(du.cross(dv).normalized());
                }
    return normals;
}

int compare_with_patches(const Cell& cell) {
    const std::vector<Row> edges = table(write_edges, cell, 11);
    REQUIRE(edges.size() == cell.edges.size());
    int compared = 0;
    for (std::size_t e = 0; e < edges.size(); ++e) {
        CAPTURE(e);
        CHECK(edges[e][1] == to_string(cell.edges[e].sites[0]));
        CHECK(edges[e][5] == to_string(cell.edges[e].kind));
        CHECK(std::stod(edges[e][6]) == cell.edges[e].length);
        const std::vector<Vec3> normals = normals_beside(cell, e);
        if (edges[e][9] == "-" || normals.size() != 2) continue;
        const double turn = std::atan2(normals[0].cross(normals[1]).norm(), normals[0].dot(normals[1])),
                     inside = 180 - turn * 180 / std::numbers::pi, error = std::stod(edges[e][10]);
        CHECK(error < 0.01);
        CHECK(std::abs(std::stod(edges[e][9]) - inside) < error + 1e-5);
        ++compared;
    }
    return compared;
}

Scene around_ball(const std::vector<Vec3>& directions) {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.25};
    for (const Vec3& d : directions) scene.objects.push_back(Sphere{d, 0.25});
    scene.box = {Vec3::Constant(-3), Vec3::Constant(3)};
    return scene;
}

}  // namespace

TEST_CASE("cell tables: a cube's faces meet at 90 degrees, a rhombic dodecahedron's at 120") {
    std::vector<Vec3> cube, dodecahedron;
    for (int axis = 0; axis < 3; ++axis)
        for (const int sign : {-1, 1}) cube.push_back(sign * Vec3::Unit(axis));
    for (const int x : {-1, 0, 1})
        for (const int y : {-1, 0, 1})
            for (const int z : {-1, 0, 1})
                if (x * x + y * y + z * z == 2) dodecahedron.emplace_back(x, y, z);
    for (const auto& [directions, angle, edges] :
         {std::tuple{cube, 90.0, 12}, std::tuple{dodecahedron, 120.0, 24}}) {
        Scene scene = around_ball(directions);
        scene.names = {"first"};
        const Cell cell = voronoi_cell(scene);
        const std::vector<Row> rows = table(write_edges, cell, 11);
        CHECK(rows.size() == static_cast<std::size_t>(edges));
        for (const Row& row : rows) {
            CHECK(std::abs(std::stod(row[9]) - angle) <= std::stod(row[10]));
            CHECK(std::stod(row[10]) < 1e-6);
        }
        const std::vector<Row> faces = table(write_faces, cell, 7), vertices = table(write_vertices, cell, 9);
        CHECK(faces.size() == directions.size());
        CHECK(vertices.size() == cell.vertices.size());
        int named = 0;
        for (const Row& row : faces) named += row[1] == "0" && row[2] == "first";
        CHECK(named == 1);
        for (const Row& row : vertices) CHECK(row[7].find(' ') != std::string::npos);
    }
}

TEST_CASE("cell tables: dihedral angles are those of the patches") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    int compared = 0;
    for (int round = 0; round < 4; ++round) {
        CAPTURE(round);
        compared += compare_with_patches(first_cell([&] {
            Scene scene = around_ball({});
            if (round == 1) scene.base = Plane{{0, 0, -2}, {0.1, 0.05, 1}};
            if (round == 2) scene.base = Cylinder{Vec3::Zero(), Vec3::UnitY(), 0.25};
            for (int i = 0; i < 14; ++i) {
                const Vec3 d = Vec3(unit(rng), unit(rng), unit(rng)).normalized();
                scene.objects.push_back(Sphere{(1.6 + 0.3 * unit(rng)) * d, 0.3 + 0.2 * unit(rng)});
            }
            if (round == 3) scene.objects.push_back(Cylinder{{0, 0, 1.5}, {1, 0.3, 0.1}, 0.2});
            return scene;
        }));
    }
    CHECK(compared > 60);
}
