// Cells of tubes among the balls of a lattice that many of are equally near to in a point, as the check
// judges them: where a tube is turned, its forms tie but for a rounding, and what was given exactly
// (envelope/proofs/given_tie.hpp).
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"

using namespace vcell;

namespace {

enum class Lattice { cubic, body_centred, face_centred };

Scene around(const Cylinder& base, Lattice lattice) {
    Scene scene;
    scene.base = base;
    scene.box = {Vec3::Constant(-2.5), Vec3::Constant(2.5)};
    const auto is_site = [&](int x, int y, int z) {
        const int odd = (x & 1) + (y & 1) + (z & 1);
        return lattice == Lattice::cubic          ? odd == 0
               : lattice == Lattice::body_centred ? odd % 3 == 0
                                                  : odd % 2 == 0;
    };
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 3; ++z) {
                const Vec3 center = 0.5 * Vec3(x, y, z);
                const double away = (center - base.point).cross(base.axis.normalized()).norm();
                if (is_site(x, y, z) && center.norm() < 1.8 && away > base.radius + 0.25)
                    scene.objects.push_back(Sphere{center, 0.25});
            }
    return scene;
}

}  // namespace

TEST_CASE("check of lattices: balls that tie around a tube along a diagonal are decided") {
    std::mt19937_64 rng(test_seed());
    std::vector<Vec3> axes{{0, -1, 1}, {1, 1, 1}, {2, 1, 1}, {1, 0, 2}, {3, 1, 0}, {1, -1, 3}};
    std::ranges::shuffle(axes, rng);
    axes.resize(std::min<std::size_t>(axes.size(), rounds() == 1 ? 2 : axes.size()));
    std::size_t tied = 0;
    for (const Vec3& axis : axes)
        for (const Lattice lattice : {Lattice::cubic, Lattice::body_centred, Lattice::face_centred}) {
            CAPTURE(axis.transpose());
            CAPTURE(static_cast<int>(lattice));
            const Cell cell = voronoi_cell(around({Vec3::Zero(), axis, 0.25}, lattice));
            CHECK(cell.report.decisions.assumed == 0);
            const Certificate c = certify(cell);
            CHECK(c.holds());
            for (const CellVertex& v : cell.vertices) tied += v.sites.size() > 3;
        }
    CHECK(tied > 10);
}

TEST_CASE("check of ties: around a ball with a twin vertices of other twins are told") {
    const Cell cell = voronoi_cell(read_scene(test_data("hostile/twin_of_ball_among_twins.json")));
    CHECK(cell.report.decisions.assumed == 0);
    CHECK(certify(cell).holds());
}
