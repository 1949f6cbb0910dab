// Cells of all of the box that is nearest to an oblique base tube: against complete_measures(), which gets
// there by other cells, against distances at random points, and as closed surfaces that fill the box
// together.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <sstream>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/pictures/svg.hpp"
#include "../random_tubes.hpp"
#include "../test_support.hpp"
#include "complete_checks.hpp"

using namespace vcell;

namespace {

const Box cube{Vec3::Zero(), Vec3::Constant(10)};

Scene scene_of(const std::vector<Object>& objects, std::size_t base) {
    Scene scene;
    scene.base = objects[base];
    scene.objects = objects;
    scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(base));
    scene.box = cube;
    return scene;
}

void check_tube_cell(const Cell& cell, std::mt19937_64& rng) {
    REQUIRE(cell.is_complete);
    CHECK(cell.measures.volume_error <= 5e-2);
    check_complete_measures(cell, complete_measures(cell.scene), cell.measures.area_error);
    const CellMesh mesh = checked_mesh(cell);
    check_points(cell, mesh, rng);
    // Chords are measured at their middles, and are a little longer elsewhere.
    for (const Vec3& p : mesh.points) {
        CHECK(p.minCoeff() > -1.5 * chord);
        CHECK(p.maxCoeff() < 10 + 1.5 * chord);
    }
}

/// The volume of the complete cells, and their bounds together.
std::array<double, 2> tile(const std::vector<Object>& objects, std::mt19937_64& rng) {
    std::array<double, 2> sum{};
    for (std::size_t i = 0; i < objects.size(); ++i) {
        CAPTURE(i);
        const Cell cell = complete_cell(scene_of(objects, i));
        check_tube_cell(cell, rng);
        sum[0] += cell.measures.volume;
        sum[1] += cell.measures.volume_error;
    }
    return sum;
}

}  // namespace

// Beside three others, not far from where its rays come in through a side, all that shows of them is three
// faces that meet in a vertex: so small that one piece holds them, whose rim tells nothing of them.
TEST_CASE("complete tubes: faces that nothing joins to others are islands of the face around them") {
    std::mt19937_64 rng(test_seed());
    const std::vector<Object> tubes{Cylinder{{9.215956608343024, 2.6051441598083325, 9.743597610384949},
                                             {-0.05593461247449121, -0.9357331707281962, 0.34824524738506474},
                                             0.04},
                                    Cylinder{{8.886746114696109, 0.14856980375721363, 8.008642576555111},
                                             {0.14913127730120931, -0.23931321610921236, -0.9594212040214534},
                                             0.04},
                                    Cylinder{{9.393355068865382, 0.7951648699113067, 9.02820604571657},
                                             {0.6795335394567411, -0.40855003539902435, -0.6093611714975362},
                                             0.04},
                                    Cylinder{{9.071420389970998, 1.8275298021214703, 9.975346310513752},
                                             {-0.23544532605100474, 0.9685393866782248, 0.0806036903231122},
                                             0.04}};
    check_tube_cell(complete_cell(scene_of(tubes, 0)), rng);
}

TEST_CASE("complete tubes: random oblique tubes tile their box") {
    std::mt19937_64 rng(test_seed());
    const int tubes = rounds() > 1 ? 30 : 8;
    for (int i = 0; i < rounds(); ++i) {
        const auto [volume, bound] = tile(random_tubes(rng, tubes, 0.15), rng);
        CHECK(std::abs(volume - 1000) <= bound + 1e-9);
        CHECK(bound <= 1e-2);
    }
}

TEST_CASE("complete tubes: thick ones tile their box, too") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(2); ++i) {
        const auto [volume, bound] = tile(random_tubes(rng, 5, 0.6), rng);
        CHECK(std::abs(volume - 1000) <= bound + 1e-9);
    }
}

TEST_CASE("complete tubes: in small integers they tile their box") {
    std::mt19937_64 rng(test_seed());
    const auto [volume, bound] = tile({Cylinder{{0, 0, 0}, {1, 2, 3}, 1}, Cylinder{{8, 0, 2}, {1, -2, 2}, 1},
                                       Cylinder{{0, 8, 0}, {2, 1, 3}, 0}},
                                      rng);
    CHECK(std::abs(volume - 1000) <= bound + 1e-9);
}

TEST_CASE("complete tubes: among balls and planes, and with the axis beside the box") {
    std::mt19937_64 rng(test_seed());
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{5, 4, 5}, {1, 2, 3}, 0.5};
    scene.objects = {Sphere{{8, 2, 5}, 1}, Sphere{{2, 8, 4}, 0.5}, Cylinder{{1, 1, 0}, {1, -1, 2}, 0.25}};
    check_tube_cell(complete_cell(scene), rng);
    scene.base = Cylinder{{-1, 5, 5}, {0.05, 3, 4}, 0.25};
    check_tube_cell(complete_cell(scene), rng);
}

TEST_CASE("complete tubes: through edges and corners of the box, along its sides and beside it") {
    std::mt19937_64 rng(test_seed());
    const Cylinder other{{6, 5, 3}, {1, -2, 2}, 0.5};
    for (const Cylinder& tube : {
             Cylinder{{10, 0, 0}, {-1, 2, 2}, 0.25},  // through a corner
             Cylinder{{0, 0, 0}, {1, 1, 1}, 0.25},    // through two
             Cylinder{{0, 0, 4}, {1, 2, 3}, 0.25},    // through an edge
             Cylinder{{5, 5, 5}, {1, 1, 0}, 0.25},    // through two
             Cylinder{{5, 5, 5}, {1, 2, 2}, 0},       // through two
             Cylinder{{4, 5, 5}, {3, 4, 0}, 0.5},     // along two sides
             Cylinder{{5, 5, 5}, {1e-9, 3, 4}, 0.5},  // all but along two
             Cylinder{{-1, 5, 5}, {0, 3, 4}, 1},      // touches a side from outside
             Cylinder{{-1, -2, 3}, {1, -2, 2}, 0.5},  // meets the box nowhere
         }) {
        CAPTURE(tube.point.transpose());
        CAPTURE(tube.axis.transpose());
        const auto [volume, bound] = tile({tube, other}, rng);
        CHECK(std::abs(volume - 1000) <= bound + 1e-9);
    }
}

TEST_CASE("complete tubes: where the axis lies on a side of the box they are refused") {
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{0, 5, 5}, {0, 1, 1}, 0.25};
    scene.objects = {Cylinder{{6, 5, 3}, {1, -2, 2}, 0.5}};
    CHECK_THROWS_AS(complete_cell(scene), UndecidedError);
}

TEST_CASE("complete tubes: along an axis of the box they stay as they are") {
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{5, 4, 5}, {0, 0, 1}, 0.5};
    scene.objects = {Sphere{{8, 2, 5}, 1}};
    const Cell cell = complete_cell(scene);
    CHECK_FALSE(cell.is_complete);
    CHECK(cell.measures.volume == voronoi_cell(scene).measures.volume);
}

TEST_CASE("complete tubes: files hold them, pictures show them, and they are left open by the check") {
    std::mt19937_64 rng(test_seed());
    const Cell cell = complete_cell(scene_of(random_tubes(rng, 4, 0.3), 0));
    std::stringstream file;
    write_cell(file, cell);
    const Cell read = parse_cell(file.str());
    CHECK(read.is_complete);
    std::stringstream again;
    write_cell(again, read);
    CHECK(again.str() == file.str());
    const Certificate certificate = certify(cell);
    CHECK(certificate.count(Verdict::refuted) == 0);
    CHECK(std::ranges::any_of(certificate.elements, [](const Element& e) {
        return e.where == "cell" && e.verdict == Verdict::open;
    }));
    std::stringstream picture;
    write_svg(picture, cell);
    CHECK(picture.str().find("class=\"face") != std::string::npos);
}

namespace {

/// Below the box, where the axis comes no nearer, and close above the bottom a row of balls: what is nearest
/// to the tube beyond the row has no contact with what is before it.
Scene tube_below_a_row() {
    Scene scene;
    scene.base = Cylinder{{5, 5, -1}, {1, 0, 0.05}, 0.25};
    scene.box = cube;
    for (int i = 0; i < 16; ++i) scene.objects.push_back(Sphere{{4, 0.7 * i - 0.2, 0.55}, 0.4});
    scene.objects.push_back(Sphere{{8, 5, 4}, 1});
    return scene;
}

}  // namespace

// Half-way between tube and balls is below the box.
TEST_CASE("complete tubes: the least clearance is that of the boundary") {
    const Cell cell = complete_cell(tube_below_a_row());
    double least = HUGE_VAL;
    for (const CellEdge& e : cell.edges) {
        constexpr int steps = 200;
        const double from = e.curve.domain_begin(), to = e.curve.domain_end();
        for (int k = 0; k <= steps; ++k) {
            const Vec3 p = e.curve.evaluate(from + (to - from) * k / steps);
            least = std::min(least, distance_from(cell.scene.base, p, true));
        }
    }
    CHECK(cell.measures.min_clearance == doctest::Approx(least).epsilon(1e-4));
}
