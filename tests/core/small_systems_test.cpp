#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "../../core/numbers/small_systems.hpp"
#include "../test_support.hpp"

namespace vcell::small_systems_test {

namespace {

double between(std::mt19937_64& rng, double size) { return std::uniform_real_distribution(-size, size)(rng); }

}  // namespace

TEST_CASE("solution: small integers are found exactly, others to rounding") {
    CHECK(solution(Eigen::Matrix2d{{0, 2}, {4, 8}}, {6, 20}) == Eigen::Vector2d(-1, 3));
    CHECK(solution(Eigen::Matrix2d{{4, 8}, {0, 2}}, {20, 6}) == Eigen::Vector2d(-1, 3));
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 10'000; ++i) {
        const double size = std::exp2(std::uniform_int_distribution(-60, 60)(rng));
        Eigen::Matrix2d M;
        for (int row = 0; row < 2; ++row) M.row(row) << between(rng, size), between(rng, size);
        const Eigen::Vector2d k(between(rng, 1), between(rng, 1)), x = solution(M, k);
        CAPTURE(i);
        CHECK((M * x - k).norm() <= 0x1p-50 * M.norm() * x.norm());
    }
}

TEST_CASE("solution: rows that are parallel give nothing finite") {
    CHECK(!solution(Eigen::Matrix2d{{1, 2}, {2, 4}}, {1, 1}).allFinite());
    CHECK(!solution(Eigen::Matrix2d::Zero(), {1, 1}).allFinite());
}

TEST_CASE("nearest_solution: what is left is at right angles to both columns") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 10'000; ++i) {
        Eigen::Matrix<double, 3, 2> M;
        Eigen::Vector3d k;
        for (int row = 0; row < 3; ++row) {
            M.row(row) << between(rng, 1), between(rng, 1e6);
            k[row] = between(rng, 1);
        }
        const Eigen::Vector3d a = M.col(0).normalized(), b = M.col(1).normalized();
        if (a.cross(b).norm() < 0.01) continue;
        const Eigen::Vector3d left = k - M * nearest_solution(M, k);
        CAPTURE(i);
        CHECK(std::abs(a.dot(left)) < 1e-12);
        CHECK(std::abs(b.dot(left)) < 1e-12);
    }
    CHECK(!nearest_solution(Eigen::Matrix<double, 3, 2>{{1, 2}, {0, 0}, {0, 0}}, {1, 1, 1}).allFinite());
}

}  // namespace vcell::small_systems_test
