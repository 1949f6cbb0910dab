/// What it takes the check to tell that no rival is nearer on a patch.
#include <doctest/doctest.h>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "listing.hpp"

using namespace vcell;

// The face between twins reaches through all of the box, and a tube comes as near to it as edges are.
TEST_CASE("check: rivals of a face beside the base's twin are told in few tiles") {
    const Vec3 center(1.9937086354219127, 2.2321099764093413, 1.0555142417744023);
    for (const double apart : {1e-3, 1e-5, 2e-8, 1e-10}) {
        CAPTURE(apart);
        Scene scene;
        scene.base = Sphere{center, 0.18};
        scene.objects = {Cylinder{{0.04, 1, 3}, {-0.3, 0.05, -0.9}, 0.4},
                         Sphere{center + apart * Vec3(0.3, -0.05, -0.95), 0.18}};
        scene.box = {Vec3::Zero(), Vec3::Constant(4)};
        CheckOptions few;
        few.effort = 6;
        const Certificate c = certify(voronoi_cell(scene), few);
        CHECK_MESSAGE(c.holds(), listing(c));
    }
}
