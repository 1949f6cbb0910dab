// Scenes in other places and of other sizes: what is stated, checked and written goes with them.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
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

}  // namespace vcell::scales_test
