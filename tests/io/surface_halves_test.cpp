/// Cells with faces in two halves: their files, meshes and solids, and what certify() says of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/solids/moments.hpp"
#include "closed_meshes.hpp"
#include "listing.hpp"

namespace vcell::surface_halves_io_test {
namespace {

// Two discs and a hole with corners in a sphere about a ball off its middle; a cap between two discs; a tube
// and a ball before a cap.
std::vector<Scene> scenes() {
    std::vector<Scene> all(3);
    all[0].base = Sphere{{1, 0.5, 0}, 0.5};
    all[0].objects = {Sphere{{-3, 0.5, 0.5}, 0.5}, Sphere{{2, 4, 1}, 0.25}, Sphere{{2, 4, -1}, 0.5},
                      Sphere{{1, -3, -2}, 1}, HollowSphere{{0.25, 0, 0}, 4}};
    all[1].base = Sphere{{0, 0, 0}, 0.25};
    all[1].objects = {Sphere{{1, 0, 0}, 0.25}, Sphere{{-1, 0.125, 0}, 0.25}};
    all[1].probe = 0.3125;
    all[2].base = Sphere{{0, 0, 0}, 0.5};
    all[2].objects = {Sphere{{2, 0.5, 0.25}, 0.5}, Cylinder{{0, 2, 0}, {1, 0.25, 0.5}, 0.25}};
    all[2].probe = 1;
    for (Scene& scene : all) scene.box = {Vec3::Constant(-8), Vec3::Constant(8)};
    return all;
}

std::size_t face_in_halves(const Cell& cell) {
    const auto face =
        std::ranges::find_if(cell.faces, [](const CellFace& f) { return f.patches.size() == 2; });
    REQUIRE(face != cell.faces.end());
    return static_cast<std::size_t>(face - cell.faces.begin());
}

TEST_CASE("surface halves: cells are certified, meshed, made solid, and survive their files") {
    for (const Scene& scene : scenes()) {
        CAPTURE(scene.objects.size());
        const Cell cell = voronoi_cell(scene);
        const Certificate c = certify(cell);
        CHECK_MESSAGE(c.holds(), listing(c));
        // Its integrals take one variable, and are no estimates.
        const std::string area = "faces[" + std::to_string(face_in_halves(cell)) + "].area";
        const auto judged = std::ranges::find(c.elements, area, &Element::where);
        REQUIRE(judged != c.elements.end());
        CHECK(judged->what.empty());
        std::stringstream file;
        write_cell(file, cell);
        CHECK(certify(parse_cell(file.str())).holds());

        check_mesh_and_solid(cell, 5e-3);
        const Moments moments = moments_of(cell);
        CHECK(moments.centroid_error < 1e-4);
        CHECK(std::isfinite(moments.centroid.norm()));
    }
}

TEST_CASE("surface halves: what is damaged is refuted") {
    for (const Scene& scene : scenes()) {
        CAPTURE(scene.objects.size());
        const Cell cell = voronoi_cell(scene);
        const std::size_t at = face_in_halves(cell);
        const auto expect = [&](const char* what, const std::function<void(CellFace&)>& damage) {
            Cell bad = cell;
            damage(bad.faces[at]);
            const Certificate c = certify(bad);
            CHECK_MESSAGE(c.count(Verdict::refuted) > 0, what, ", found\n", listing(c));
        };
        expect("a half is missing", [](CellFace& f) { f.patches.pop_back(); });
        expect("halves have changed places",
               [](CellFace& f) { std::swap(f.patches[0].loops, f.patches[1].loops); });
        expect("one is there twice", [](CellFace& f) { f.patches[1] = f.patches[0]; });
        expect("a point has moved", [](CellFace& f) {
            auto& points = f.patches[1].surface.points;
            points[points.size() / 2].x() += 1e-3;
        });
        expect("the area", [](CellFace& f) { f.area *= 1 + 1e-4; });
        const auto for_seams = [](TrimmedPatch& patch, const auto& change) {
            for (auto& loop : patch.loops)
                for (TrimCurve& trim : loop)
                    if (trim.seam) change(trim);
        };
        expect("seams have two numbers",
               [&](CellFace& f) { for_seams(f.patches[0], [](TrimCurve& t) { *t.seam += 10; }); });
        // The two halves no longer meet.
        expect("a seam is beside the other one", [&](CellFace& f) {
            for_seams(f.patches[0], [](TrimCurve& t) {
                for (auto& p : t.curve.points) p.head<2>() *= 1.001;
            });
        });
    }
}

// A mesh of the size of the base, which is a point, was looked for.
TEST_CASE("surface halves: a cell without edges about a point is as large as its seam") {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0};
    scene.objects = {HollowSphere{{4, -4, 0}, 7}};
    scene.box = {Vec3::Constant(-12), Vec3::Constant(12)};
    const Cell cell = voronoi_cell(scene);
    // Semiaxes of 3.5 along the way to the centre, and across it.
    const double across = 0.5 * std::sqrt(49 - 32.0);
    CHECK(cell_diagonal(cell) > 2 * across);
    CHECK(cell_diagonal(cell) < 2 * 3.5 * std::sqrt(3));
    const CellMesh mesh = tessellate(cell);
    CHECK(is_closed(mesh));
    CHECK(volume(mesh) == doctest::Approx(4 * std::numbers::pi / 3 * 3.5 * across * across).epsilon(5e-3));
}

}  // namespace
}  // namespace vcell::surface_halves_io_test
