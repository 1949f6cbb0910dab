// Cells of cylinders where faces end in cusps.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "../../envelope/proofs/tie_fan.hpp"
#include "radial_cell_checks.hpp"

namespace vcell::cylinder_ties_test {
using namespace vcell::radial_cells;

TEST_CASE("cylinder cell: faces that end in cusps where four balls tie") {
    const Scene scene = about_tube({{0, 0, 0}, {0, 1, 0}, 0.25}, 2.5,
                                   {Sphere{{0.5, 1.5, -0.5}, 0}, Sphere{{0.5, 1.5, 0.5}, 0},
                                    Sphere{{1, 1, 0}, 0}, Sphere{{1.5, 1.5, 0.5}, 0}});
    const Cell cell = checked(scene);
    CHECK(cell.report.decisions.assumed == 0);
    // In any order.
    std::vector<std::size_t> order{0, 1, 2, 3};
    while (std::ranges::next_permutation(order).found) {
        Scene other = scene;
        for (std::size_t i = 0; i < 4; ++i) other.objects[i] = scene.objects[order[i]];
        const Cell same = cell_of(other);
        CHECK(same.vertices.size() == cell.vertices.size());
        CHECK(same.edges.size() == cell.edges.size());
        CHECK(same.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-12));
    }
}

TEST_CASE("fan: between two functions a third one has a cusp, or nothing") {
    // x, -x and y all over a square, and between the first two s y^2, s = -1 or 1.
    const std::array<FormId, 4> forms{FormId{0}, FormId{1}, FormId{2}, FormId{3}};
    const auto gradient = [](double x, double y) { return TiedDifference{{Interval(x), Interval(y)}, {}}; };
    for (const double s : {1.0, -1.0}) {
        const Interval bend = s * Interval(-0.25, 0.25);  // its slope along y
        std::vector<std::vector<TiedDifference>> differences(4, std::vector<TiedDifference>(4));
        differences[0][1] = gradient(2, 0);
        differences[0][2] = gradient(1, -1);
        differences[1][2] = gradient(-1, -1);
        differences[0][3] = {{Interval(1), bend}, {}};
        differences[1][3] = {{Interval(-1), bend}, {}};
        differences[2][3] = {{Interval(0), 1.0 + bend}, {}};
        const std::array<TiedBetween, 1> between{{{3, {0, 1}, s > 0}}};
        const std::array<Eigen::Vector2d, 5> corners{
            {{1, 0.29}, {-0.29, 1}, {-1, -0.29}, {0.29, -1}, {1, 0.29}}};
        CHECK_FALSE(find_fan(forms, differences, {}, corners));
        const auto fan = find_fan(forms, differences, between, corners);
        REQUIRE(fan);
        CHECK(fan->first == FormId{1});
        std::vector<std::array<std::uint32_t, 2>> arms;
        for (const FanArm& arm : fan->arms) arms.push_back({arm.right.value, arm.left.value});
        const std::vector<std::array<std::uint32_t, 2>> cusp{{1, 3}, {3, 0}, {0, 2}, {2, 1}},
            none{{1, 0}, {0, 2}, {2, 1}};
        CHECK(arms == (s > 0 ? cusp : none));
    }
}

}  // namespace vcell::cylinder_ties_test
