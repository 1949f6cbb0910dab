// Mesh files, read back byte by byte.
#include "../../io/pictures/mesh_formats.hpp"
#include "../../io/pictures/bezier_vtu.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/files.hpp"
#include "vtu_arrays.hpp"

namespace vcell {
using testing::array_of;
using testing::take;

namespace {

LabelledMesh two_cells() {
    LabelledMesh mesh;
    Scene scene;
    scene.box = {Vec3::Zero(), {2, 1, 1}};
    for (const int i : {0, 1}) {
        scene.base = Sphere{{i == 0 ? 0.5 : 1.5, 0.5, 0.5}, 0.25};
        scene.objects = {Sphere{{i == 0 ? 1.5 : 0.5, 0.5, 0.5}, 0.25}};
        const Cell cell = voronoi_cell(scene);
        mesh.add(i, cell, tessellate(cell));
    }
    return mesh;
}

/// Of triangles as six numbers each, counter-clockwise from outside.
double volume(const std::vector<std::array<Vec3, 3>>& triangles) {
    double sum = 0;
    for (const auto& [a, b, c] : triangles) sum += a.dot(b.cross(c)) / 6;
    return sum;
}

}  // namespace

TEST_CASE("mesh formats: labels say whose cell it is and what is beyond, clearances how far away that is") {
    const LabelledMesh mesh = two_cells();
    CHECK(mesh.cell.size() == mesh.triangles.size());
    CHECK(mesh.clearance.size() == mesh.points.size());
    std::set<std::pair<std::int32_t, std::int32_t>> seen;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        seen.emplace(mesh.cell[t], mesh.neighbor[t]);
        for (const std::uint32_t p : mesh.triangles[t]) {
            const Vec3& at = mesh.points[p];
            if (mesh.neighbor[t] >= 0) CHECK(at.x() == doctest::Approx(1));
            if (mesh.neighbor[t] == -5) CHECK(at.z() == doctest::Approx(0).epsilon(1e-12));  // box:-z
            const Vec3 center(mesh.cell[t] == 0 ? 0.5 : 1.5, 0.5, 0.5);
            CHECK(mesh.clearance[p] == doctest::Approx((at - center).norm() - 0.25));
        }
    }
    // Each has the other one and five sides of the box.
    CHECK(seen.size() == 12);
    CHECK(seen.contains({0, 0}));  // object 0 of its scene
    CHECK(seen.contains({0, -1}));
    CHECK_FALSE(seen.contains({0, -2}));
}

TEST_CASE("mesh formats: STL") {
    std::ostringstream out;
    const LabelledMesh mesh = two_cells();
    write_mesh(out, "stl", mesh);
    const std::string file = out.str();
    std::size_t at = 80;
    const auto count = take<std::uint32_t>(file, at);
    CHECK(count == mesh.triangles.size());
    std::vector<std::array<Vec3, 3>> triangles(count);
    for (auto& triangle : triangles) {
        Vec3 normal;
        for (double& x : normal) x = take<float>(file, at);
        for (Vec3& p : triangle)
            for (double& x : p) x = take<float>(file, at);
        CHECK(take<std::uint16_t>(file, at) == 0);
        CHECK(normal.norm() == doctest::Approx(1));
        CHECK(normal.dot((triangle[1] - triangle[0]).cross(triangle[2] - triangle[0])) > 0);
    }
    CHECK(at == file.size());
    CHECK(volume(triangles) == doctest::Approx(2));
}

TEST_CASE("mesh formats: PLY") {
    std::ostringstream out;
    const LabelledMesh mesh = two_cells();
    write_mesh(out, "ply", mesh);
    const std::string file = out.str();
    CHECK(file.starts_with("ply\nformat binary_little_endian 1.0\n"));
    CHECK(file.find("element vertex " + std::to_string(mesh.points.size()) + "\n") != file.npos);
    CHECK(file.find("element face " + std::to_string(mesh.triangles.size()) + "\n") != file.npos);
    std::size_t at = file.find("end_header\n") + 11;
    std::vector<Vec3> points;
    for (const double clearance : mesh.clearance) {
        Vec3 p;
        for (double& x : p) x = take<double>(file, at);
        points.push_back(p);
        CHECK(take<double>(file, at) == clearance);
    }
    std::vector<std::array<Vec3, 3>> triangles;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        CHECK(take<std::uint8_t>(file, at) == 3);
        auto& triangle = triangles.emplace_back();
        for (Vec3& p : triangle) p = points.at(static_cast<std::size_t>(take<std::int32_t>(file, at)));
        CHECK(take<std::int32_t>(file, at) == mesh.cell[t]);
        CHECK(take<std::int32_t>(file, at) == mesh.neighbor[t]);
    }
    CHECK(at == file.size());
    CHECK(volume(triangles) == doctest::Approx(2));
}

TEST_CASE("mesh formats: VTK's unstructured grid") {
    std::ostringstream out;
    LabelledMesh mesh = two_cells();
    mesh.numbers = {{"porosity", {0.25, 0.75}}};
    write_mesh(out, "vtu", mesh);
    const std::string file = out.str(), points = array_of(file, "Points"),
                      corners = array_of(file, "connectivity"), offsets = array_of(file, "offsets"),
                      types = array_of(file, "types"), cells = array_of(file, "cell"),
                      clearances = array_of(file, "clearance");
    const std::size_t count = mesh.triangles.size();
    CHECK(file.find("NumberOfPoints=\"" + std::to_string(mesh.points.size()) + "\" NumberOfCells=\"" +
                    std::to_string(count) + "\"") != file.npos);
    CHECK(types == std::string(count, '\5'));
    CHECK(clearances.size() == 8 * mesh.points.size());
    CHECK(cells.size() == 4 * count);
    std::vector<std::array<Vec3, 3>> triangles(count);
    std::size_t at = 0, offset = 0;
    for (std::size_t t = 0; t < count; ++t) {
        for (Vec3& p : triangles[t]) {
            std::size_t place = 24 * static_cast<std::size_t>(take<std::int32_t>(corners, at));
            for (double& x : p) x = take<double>(points, place);
        }
        CHECK(take<std::int32_t>(offsets, offset) == static_cast<std::int32_t>(3 * (t + 1)));
    }
    CHECK(at == corners.size());
    CHECK(volume(triangles) == doctest::Approx(2));
    const std::string porosities = array_of(file, "porosity");
    CHECK(porosities.size() == 8 * count);
    at = 0;
    for (std::size_t t = 0; t < count; ++t)
        CHECK(take<double>(porosities, at) == (t < mesh.parts[0].triangles.end ? 0.25 : 0.75));
}

// VTK numbers a quadrilateral's control points corners first, then side by side, then what is inside.
TEST_CASE("mesh formats: exact patches and edges are VTK's Bezier elements") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = {Sphere{{0, 0, 0.75}, 0.25}, Cylinder{{0, 0.5, 0.75}, {1, 0.25, 0.125}, 0.125}};
    scene.box = {{-1, -1, -1}, {1, 1, 1}};
    const Cell cell = voronoi_cell(scene);
    std::ostringstream out;
    write_bezier_vtu(out, cell);
    const std::string file = out.str(), points = array_of(file, "Points"),
                      weights = array_of(file, "RationalWeights"), types = array_of(file, "types"),
                      offsets = array_of(file, "offsets"), degrees = array_of(file, "HigherOrderDegrees");
    std::size_t at = 0, of_weights = 0, element = 0, next_degree = 0, end = 0;
    const auto next_point = [&] {
        Eigen::Vector4d p;
        for (int k = 0; k < 3; ++k) p[k] = take<double>(points, at);
        p[3] = take<double>(weights, of_weights);
        return p;
    };
    const auto ends_at = [&] { return static_cast<std::size_t>(take<std::int64_t>(offsets, end)) * 24; };
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches) {
            const RationalPatch& s = patch.surface;
            CHECK(types[element++] == 77);
            CHECK(take<double>(degrees, next_degree) == s.degree_u);
            CHECK(take<double>(degrees, next_degree) == s.degree_v);
            CHECK(take<double>(degrees, next_degree) == 0);
            const std::size_t begin = at;
            CHECK(next_point() == s.point(0, 0));
            CHECK(next_point() == s.point(s.degree_u, 0));
            CHECK(next_point() == s.point(s.degree_u, s.degree_v));
            CHECK(next_point() == s.point(0, s.degree_v));
            if (s.degree_u == 2) CHECK(next_point() == s.point(1, 0));
            if (s.degree_v == 2) CHECK(next_point() == s.point(s.degree_u, 1));
            if (s.degree_u == 2) CHECK(next_point() == s.point(1, s.degree_v));
            if (s.degree_v == 2) CHECK(next_point() == s.point(0, 1));
            if (s.degree_u == 2 && s.degree_v == 2) CHECK(next_point() == s.point(1, 1));
            CHECK(at - begin == 24 * s.points.size());
            CHECK(at == ends_at());
        }
    // Spans follow each other from the start of an edge to its end.
    for (const CellEdge& edge : cell.edges) {
        Vec3 last = edge.curve.points.front().head<3>();
        double t = edge.curve.domain_begin();
        while (t < edge.curve.domain_end()) {
            CHECK(types[element++] == 75);
            for (const double degree : {edge.curve.degree, 0, 0})
                CHECK(take<double>(degrees, next_degree) == degree);
            CHECK((next_point().head<3>() - last).norm() < 1e-14);
            last = next_point().head<3>();
            for (int k = 1; k < edge.curve.degree; ++k) next_point();
            CHECK(at == ends_at());
            t = *std::ranges::upper_bound(edge.curve.knots, t);
            CHECK((last - edge.curve.evaluate(t)).norm() < 1e-14);
        }
    }
    CHECK(element == types.size());
    CHECK(at == points.size());
    // VTK has no room for more.
    Cell high = cell;
    RationalPatch& s = high.faces[0].patches[0].surface;
    s.degree_u = 11;
    while (s.points.size() < static_cast<std::size_t>(12 * (s.degree_v + 1)))
        s.points.push_back({0, 0, 0, 1});
    CHECK_THROWS_AS(write_bezier_vtu(out, high), WriteError);
}

}  // namespace vcell
