#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "../../primitives/bases/nested_cylinders.hpp"
#include "../../primitives/bases/solids.hpp"
#include "test_support.hpp"

namespace vcell::nested_cylinders_test {

namespace {

// Tubes in few directions, of either sense and any length, many in each other, touching from within or equal.
std::vector<CylinderForm> nested_tubes(std::mt19937_64& rng, int n, double away) {
    const double axes[][3] = {{0, 0, 1}, {1, 2, 2}, {0.25, 1, 0}, {1, -3, 0.5}};
    std::uniform_int_distribution<int> step(-6, 6), axis(0, 3), radius(0, 4), sense(0, 3);
    std::vector<CylinderForm> tubes;
    for (int i = 0; i < n; ++i) {
        CylinderForm f;
        f.px = away + step(rng);
        f.py = step(rng) - away;
        f.pz = 0.5 * step(rng);
        const double* a = axes[axis(rng)];
        const double length = std::ldexp(sense(rng) % 2 == 0 ? 1 : -1, 40 * (sense(rng) - 2));
        f.ax = length * a[0];
        f.ay = length * a[1];
        f.az = length * a[2];
        f.rho = radius(rng);
        tubes.push_back(f);
        // The same again, farther along its axis.
        if (sense(rng) == 0) {
            f.px += 3 * a[0];
            f.py += 3 * a[1];
            f.pz += 3 * a[2];
            tubes.push_back(f);
        }
    }
    return tubes;
}

}  // namespace

TEST_CASE("nested cylinders: all that contain one are found, ascending, near the origin and far from it") {
    std::mt19937_64 rng(test_seed());
    for (const double away : {0.0, 0x1p30, 0x1p45}) {
        const std::vector<CylinderForm> tubes = nested_tubes(rng, 120, away);
        const auto containers = possible_containers(tubes);
        REQUIRE(containers.size() == tubes.size());
        std::size_t contained = 0;
        for (std::uint32_t i = 0; i < tubes.size(); ++i) {
            CHECK(std::ranges::is_sorted(containers[i]));
            for (std::uint32_t k = 0; k < tubes.size(); ++k) {
                if (k == i || !contains(tubes[k], tubes[i])) continue;
                ++contained;
                CAPTURE(i);
                CAPTURE(k);
                CHECK(std::ranges::binary_search(containers[i], k));
            }
        }
        CHECK(contained > 100);
    }
}

TEST_CASE("nested cylinders: of many tubes side by side few pairs are asked") {
    std::vector<CylinderForm> tubes;
    for (int i = 0; i < 2000; ++i) {
        CylinderForm f;
        f.px = std::cos(i);
        f.py = std::sin(i);
        f.az = 1 + i % 3;
        f.rho = 1e-3;
        tubes.push_back(f);
    }
    std::size_t pairs = 0;
    for (const auto& c : possible_containers(tubes)) pairs += c.size();
    CHECK(pairs < 20);
}

}  // namespace vcell::nested_cylinders_test
