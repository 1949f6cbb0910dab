/// Cells that sides of the box, and what lies beyond walls, touch all along a line or in a point, and of
/// which they have nothing.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "listing.hpp"

namespace vcell {
namespace {

void check_certified(const Cell& cell) {
    const Certificate c = certify(cell);
    INFO(listing(c));
    CHECK(c.holds());
}

// A box of which that side is elsewhere leaves the cell as it is, as the side touches it and no more.
void check_hidden(const Scene& scene, std::uint32_t side, double elsewhere) {
    const Cell cell = voronoi_cell(scene);
    CHECK(cell.report.decisions.assumed == 0);
    CHECK(
        std::ranges::none_of(cell.faces, [&](const CellFace& f) { return f.site == Site::box_side(side); }));
    check_certified(cell);
    Scene wider = scene;
    (side % 2 == 0 ? wider.box.min : wider.box.max)[side / 2] = elsewhere;
    const Measures &m = cell.measures, w = voronoi_cell(wider).measures;
    CHECK(std::abs(m.volume - w.volume) <= m.volume_error + w.volume_error);
}

const std::vector<Vec3> directions{{0, 1, 0}, {3, 4, 0}, {1, 1, 0}, {1, 0.3, 0}};

}  // namespace

TEST_CASE("hidden sides: half-way from a ball to a tube of its radius") {
    for (const Vec3& axis : directions)
        for (const bool is_wide : {false, true}) {
            CAPTURE(axis);
            Scene scene;
            scene.base = Sphere{{1, 0.5, 0.25}, 0.5};
            scene.objects = {Cylinder{{1, 0.5, -1.75}, axis, 0.5}, Sphere{{2, 2, 1}, 0.25}};
            scene.box = {{-2, -2.5, -0.75}, {4, 3.5, 3.25}};
            if (is_wide) {  // the image touches it from within, in a point
                scene.objects[0] = Cylinder{{1, 0.5, -2.25}, axis, 1};
                scene.objects[1] = Sphere{{2, 2, 1}, 0.5};
            }
            check_hidden(scene, 4, -3);
        }
}

TEST_CASE("hidden sides: half-way from a plane to the wall of a hollow tube, and what is beyond that") {
    for (const Vec3& axis : directions)
        for (const double bottom : {0.0, -1.0}) {
            CAPTURE(axis);
            CAPTURE(bottom);
            Scene scene;
            scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
            scene.objects = {HollowCylinder{{0, 0, -3}, axis, 5}};
            scene.box = {{-3, -3, bottom}, {3, 3, 1}};
            check_hidden(scene, 5, 2);
            // Others touch the wall from beyond, along a line and in a point.
            const double volume = voronoi_cell(scene).measures.volume;
            scene.box.max.z() = 2.5;
            scene.objects.push_back(Plane{{0, 0, 2}, {0, 0, 1}});
            scene.objects.push_back(Cylinder{{0, 0, 2.5}, axis, 0.5});
            scene.objects.push_back(Sphere{{0, 0, 2.25}, 0.25});
            const Cell among = voronoi_cell(scene);
            CHECK(among.report.decisions.assumed == 0);
            CHECK(among.measures.volume == doctest::Approx(volume).epsilon(1e-12));
            check_certified(among);
        }
}

TEST_CASE("hidden sides: about a tube that they touch, where a ball touches its wall") {
    for (const bool is_cone : {false, true}) {
        Scene scene;
        scene.base = Sphere{{2.5, 0, 0.5}, 0.5};
        scene.objects = {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 3}, Sphere{{-1, 0.5, 0}, 1}};
        if (is_cone) scene.objects.push_back(HollowCone{{0, 0, -4}, {0, 0, 1}, 4, 5});
        scene.box = {{-3, -3, -2}, {3, 3, 3}};
        check_hidden(scene, 1, 4);
    }
}

}  // namespace vcell
