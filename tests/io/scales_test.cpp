// Scenes in other places and of other sizes: what is stated, checked and written goes with them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "listing.hpp"

namespace vcell::scales_test {
namespace {

Scene scene_named(const std::string& name) { return read_scene(VCELL_EXAMPLE_SCENES "/" + name + ".json"); }

/// A scene's lengths times `unit`, then all of it moved; what is rounded stays as it is rounded.
Scene placed(Scene s, double unit, const Vec3& shift) {
    const auto place = [&](Vec3& p) { p = unit * p + shift; };
    const auto move = [&](Object& o) {
        std::visit(
            [&](auto& object) {
                if constexpr (requires { object.center; })
                    place(object.center);
                else if constexpr (requires { object.apex; })
                    place(object.apex);
                else
                    place(object.point);
                if constexpr (requires { object.radius; }) {
                    if constexpr (!requires { object.slant; }) object.radius *= unit;
                }
            },
            o);
    };
    move(s.base);
    for (Object& o : s.objects) move(o);
    place(s.box.min);
    place(s.box.max);
    if (s.tolerance) *s.tolerance *= unit;
    return s;
}

}  // namespace

TEST_CASE("scales: errors that rounding of coordinates leaves are believed, and none that are larger") {
    // In figure 7 roundings of the vertices' coordinates cancel: they lie where they should to 30 digits.
    const double moved = 1e6;
    for (const std::string name : {"figure7", "table3_04"}) {
        CAPTURE(name);
        const Cell good = voronoi_cell(placed(scene_named(name), 1e-4, Vec3::Constant(moved)));
        const Certificate c = certify(good);
        CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
        for (const bool of_edge : {true, false}) {
            Cell bad = good;
            (of_edge ? bad.edges[0].error : bad.vertices[0].error) = 0x1p-34 * moved;
            const Certificate found = certify(bad);
            CHECK_MESSAGE(found.count(Verdict::refuted) > 0, listing(found));
        }
    }
}

TEST_CASE(
    "scales: edges that come from the sides of the box to between balls of a millionth state rounding") {
    // Three balls of a millionth of the box: the edge between the others' faces is a hyperbola that comes
    // from far to next to the base and goes back. Its parameters are told to 2^-53 where a millionth is an
    // end of the patch: that is some 1e-9 of the box far away.
    Scene scene;
    const double unit = 1e-6;
    scene.base = Sphere{unit * Vec3(-1.587, -0.416, -1.38), 0.5 * unit};
    scene.objects = {Sphere{unit * Vec3(0.198, -0.842, 1.96), 0.5 * unit},
                     Sphere{unit * Vec3(-0.893, -1.309, -1.575), 0.207 * unit}};
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.25, 0.125, 0.5)}) {
        Scene there = placed(scene, 1, shift);
        there.box = {shift - Vec3::Ones(), shift + Vec3::Ones()};
        const Cell cell = voronoi_cell(there);
        double most = 0;
        int hyperbolas = 0;
        for (const CellEdge& e : cell.edges) {
            most = std::max(most, e.error);
            if (e.kind == CurveKind::Hyperbola) ++hyperbolas;
        }
        CHECK(hyperbolas > 0);
        CHECK(most < 1e-6);
        const Certificate c = certify(cell);
        CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
    }
}

TEST_CASE("scales: of a scene in another unit meshes have the same triangles") {
    for (const std::string name : {"figure7", "figure8", "figure10", "crossing", "table3_04"}) {
        CAPTURE(name);
        const CellMesh mesh = tessellate(voronoi_cell(scene_named(name)));
        for (const double unit : {0x1p-20, 0x1p20}) {
            CAPTURE(unit);
            const CellMesh other = tessellate(voronoi_cell(placed(scene_named(name), unit, Vec3::Zero())));
            CHECK(other.triangles == mesh.triangles);
            CHECK(other.chord == unit * mesh.chord);
            REQUIRE(other.points.size() == mesh.points.size());
            bool are_same = true;
            for (std::size_t i = 0; i < mesh.points.size(); ++i)
                are_same = are_same && (other.points[i] - unit * mesh.points[i]).norm() <=
                                           0x1p-40 * unit * (1 + mesh.points[i].norm());
            CHECK(are_same);
        }
    }
}

}  // namespace vcell::scales_test
