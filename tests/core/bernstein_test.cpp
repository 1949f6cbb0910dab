#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "test_support.hpp"
#include "vcell/core/curves/bernstein.hpp"

namespace vcell::bernstein_test {

TEST_CASE("bernstein: changes of sign are isolated, exact roots and multiplicities included") {
    // Coefficients of t - r and 1 - t over [0, 1].
    const auto factor = [](double r) { return std::vector<Exact>{Exact(-r), Exact(1.0) - Exact(r)}; };
    const auto product = [&](const std::vector<double>& roots) {
        std::vector<Exact> p = factor(roots[0]);
        for (std::size_t i = 1; i < roots.size(); ++i) p = bernstein_scaled_product(p, factor(roots[i]));
        return p;
    };
    CHECK(bernstein_sign_changes(product({0.25, 0.25}), 60).empty());
    CHECK(bernstein_sign_changes(product({-1, 2}), 60).empty());
    const auto half = bernstein_sign_changes(product({0.5, 0.3, 0.3}), 60);
    REQUIRE(half.size() == 1);
    CHECK(half[0].after == Sign::Positive);

    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 50; ++round) {
        std::vector<double> roots;
        for (int i = 0; i < 5; ++i) roots.push_back(std::uniform_real_distribution(0.0, 1.0)(rng));
        std::sort(roots.begin(), roots.end());
        const auto changes = bernstein_sign_changes(product(roots), 200);
        REQUIRE(changes.size() == roots.size());
        for (std::size_t i = 0; i < roots.size(); ++i) {
            CHECK(changes[i].isolated);
            CHECK(changes[i].lower <= Exact(roots[i]));
            CHECK(changes[i].upper >= Exact(roots[i]));
            CHECK(changes[i].after == (i % 2 == 0 ? Sign::Positive : Sign::Negative));
        }
    }
}

}  // namespace vcell::bernstein_test
