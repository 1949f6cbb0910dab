/// What certify() proves of cells next to two vessels or tubes that all but coincide, 1e-13 to 1e-3 apart.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"
#include "listing.hpp"

namespace vcell::near_twins_test {
namespace {

class NearTwins {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    Vec3 direction() { return Vec3(number(-1, 1), number(-1, 1), number(-1, 1)).normalized(); }

    // Base and twins are of each kind by turns, axes of different lengths. What is like the base keeps its
    // cell from the vessels' axes, next to which bisectors have tips: an edge between two tips bends as
    // sharply as these are near.
    Scene scene(int round, double apart) {
        const int base = round % 3, kind = round / 3 % 4;
        const Vec3 out = direction(), axis = out.cross(direction()).normalized(), at = 1.2 * out;
        Scene s;
        s.box = {at - Vec3::Constant(0.7), at + Vec3::Constant(0.7)};
        if (base == 0) {
            s.base = Plane{at, out};
        } else if (base == 1) {
            s.base = Sphere{at, 0.3};
            s.objects.emplace_back(Sphere{0.3 * out, 0.3});
        } else {
            s.base = Cylinder{at, axis, 0.2};
            s.objects.emplace_back(Cylinder{0.3 * out, axis, 0.2});
        }
        s.objects.emplace_back(Sphere{at + 0.5 * axis + 0.55 * out, 0.05});
        const Vec3 p = number(0, 0.1) * direction(), moved = p + apart * direction(),
                   turned = 0.7 * (axis + apart * direction());
        const auto add = [&](const Object& first, const Object& second) {
            s.objects.push_back(first);
            s.objects.push_back(second);
        };
        if (kind == 0) add(HollowSphere{p, 2}, HollowSphere{moved, 2});
        if (kind == 1) add(HollowCylinder{p, axis, 2}, HollowCylinder{moved, turned, 2});
        if (kind == 2) add(HollowCone{p - 4 * axis, axis, 3, 6}, HollowCone{moved - 4 * axis, turned, 3, 6});
        const Vec3 wall = 1.9 * out;
        if (kind == 3) add(Cylinder{p + wall, axis, 0.1}, Cylinder{moved + wall, turned, 0.1});
        return s;
    }

private:
    std::mt19937_64 rng_{test_seed()};
};

TEST_CASE("check: cells next to vessels or tubes that all but coincide") {
    NearTwins twins;
    for (int round = 0; round < 36 * rounds(); ++round) {
        const double apart = std::pow(10.0, twins.number(-13, -3));
        CAPTURE(round);
        CAPTURE(apart);
        const Certificate c = certify(voronoi_cell(twins.scene(round, apart)));
        CHECK_MESSAGE(c.holds(), listing(c));
    }
}

TEST_CASE("check: hostile cell of a tube that a twin leans on") {
    const Cell cell = voronoi_cell(read_scene(test_data("hostile/twin_leans_on_tube.json")));
    const Certificate c = certify(cell);
    CHECK_MESSAGE(c.holds(), listing(c));
    CHECK(cell.measures.volume_error < 1e-2);
}

}  // namespace
}  // namespace vcell::near_twins_test
