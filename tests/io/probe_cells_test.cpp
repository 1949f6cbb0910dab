/// Cells that end at a probe's distance: their files, meshes and queries, and what certify() says of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/object_distance.hpp"
#include "../../envelope/point_query.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../test_support.hpp"
#include "closed_meshes.hpp"
#include "listing.hpp"

namespace vcell::probe_cells_test {
namespace {

Scene among(const Object& base) {
    Scene scene;
    scene.base = base;
    scene.objects = {Sphere{{2, 0.5, 0.25}, 0.5}, Cylinder{{0, 2, 0}, {1, 0.25, 0.5}, 0.25},
                     Sphere{{-1, -1.5, 1}, 0.25}, Sphere{{1, -1, -1.25}, 0.25}};
    scene.box = {Vec3::Constant(-2.25), Vec3::Constant(2.25)};
    scene.probe = 1;
    return scene;
}

std::vector<Scene> scenes() {
    return {among(Sphere{{0, 0, 0}, 0.5}), among(Cylinder{{0, 0, 0}, {0, 0, 1}, 0.5}),
            among(Cylinder{{0, 0, 0}, {0.25, 0, 1}, 0.25}), among(Plane{{0, 0, -2}, {0.125, 0, 1}})};
}

bool is_refuted(const Certificate& c, const std::string& where) {
    return std::ranges::any_of(c.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && e.where.starts_with(where);
    });
}

TEST_CASE("probe cells: over every base they are certified, and refuted where they are damaged") {
    for (const Scene& scene : scenes()) {
        CAPTURE(scene.base.index());
        const Cell cell = voronoi_cell(scene);
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));
        const auto cap = static_cast<std::size_t>(
            std::ranges::find(cell.faces, Site::cap(), &CellFace::site) - cell.faces.begin());
        REQUIRE(cap < cell.faces.size());
        const auto expect = [&](const std::string& where, const std::function<void(Cell&)>& damage) {
            Cell bad = cell;
            damage(bad);
            const Certificate c = certify(bad);
            CHECK_MESSAGE(is_refuted(c, where), "expected ", where, ", found\n", listing(c));
        };
        expect("faces[" + std::to_string(cap) + "].area", [&](Cell& c) { c.faces[cap].area *= 1 + 1e-4; });
        expect("measures.volume", [](Cell& c) { c.measures.volume *= 1 + 1e-4; });
        expect("", [](Cell& c) { *c.scene.probe *= 1 + 1e-4; });
        expect("", [&](Cell& c) { c.faces[cap].site = c.faces[cap == 0 ? 1 : 0].site; });
    }
}

TEST_CASE(
    "probe cells: an object that is the cap is merged with it, and one that touches it nowhere nearer") {
    const Cylinder tube{{1, 0, 0}, {0, 0, 1}, 0.5};
    std::vector<Scene> merged(3), touching(3);
    merged[0].base = Sphere{{0, 0, 0}, 0.5};
    merged[0].objects = {HollowSphere{{0, 0, 0}, 2}};
    merged[1].base = tube;
    merged[1].objects = {HollowCylinder{{1, 0, 3}, {0, 0, -2}, 2}};
    merged[2].base = Plane{{0, 0, -1.5}, {0, 0, 1}};
    merged[2].objects = {Plane{{0, 0, 0}, {0, 0, -1}}};
    // A plane that the bisector of a tube touches along a line, a tube and a plane beyond a sphere.
    touching[0].base = touching[1].base = tube;
    touching[0].objects = {Plane{{3, 0, 0}, {1, 0, 0}}};
    touching[1].objects = {Cylinder{{3.5, 0, 0}, {0, 0, 1}, 0.5}};
    touching[2].base = merged[0].base;
    touching[2].objects = {Plane{{2, 0, 0}, {1, 0, 0}}, Cylinder{{0, 3, 0}, {0, 0, 1}, 1}};
    for (const bool is_merged : {true, false})
        for (Scene& scene : is_merged ? merged : touching) {
            CAPTURE(is_merged);
            CAPTURE(scene.base.index());
            scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
            scene.probe = 0.75;
            const Cell cell = voronoi_cell(scene);
            const Certificate c = certify(cell);
            CHECK_MESSAGE(c.holds(), listing(c));
            CHECK(cell.neighbors ==
                  (is_merged ? std::vector<std::uint32_t>{0} : std::vector<std::uint32_t>{}));
            if (!is_merged) continue;
            CHECK(cell.report.warnings ==
                  std::vector<std::string>{
                      "object 0 and the cap: the same distance from the base everywhere, merged"});
            CHECK(std::ranges::any_of(cell.faces, [](const CellFace& f) {
                return f.site == Site::object(0) && f.extra_sites == std::vector<Site>{Site::cap()};
            }));
        }
}

TEST_CASE("probe cells: files, meshes and queries know the cap") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(-2.25, 2.25);
    for (const Scene& scene : scenes()) {
        CAPTURE(scene.base.index());
        const Cell cell = voronoi_cell(scene);
        std::ostringstream file, again;
        write_cell(file, cell);
        const Cell read = parse_cell(file.str());
        CHECK(read.scene.probe == scene.probe);
        write_cell(again, read);
        CHECK(again.str() == file.str());
        CHECK(certify(read).holds());

        MeshOptions options;
        options.closed = true;
        const CellMesh mesh = tessellate(cell, options);
        CHECK(is_closed(mesh));
        CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(4e-3));

        PointQuery query(scene);
        int capped = 0;
        for (int k = 0; k < 300; ++k) {
            const Vec3 p(place(rng), place(rng), place(rng));
            const auto answer = query(p);
            if (!answer || !answer->site) continue;
            CHECK(answer->clearance <= *scene.probe * (1 + 1e-12));
            capped += answer->site == Site::cap();
            CHECK((answer->site == Site::cap()) == (std::abs(answer->clearance - *scene.probe) <= 1e-12));
            const double own = signed_distance_from(scene.base, p);
            const bool is_inside =
                own >= 0 && own < *scene.probe && std::ranges::all_of(scene.objects, [&](const Object& o) {
                    return own < distance_from(o, p);
                });
            if (own >= 0) CHECK(answer->inside == is_inside);
        }
        CHECK(capped > 20);
    }
}

}  // namespace
}  // namespace vcell::probe_cells_test
