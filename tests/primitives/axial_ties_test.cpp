// Ties along generators of a cylinder, against functions of small integers compared all around.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "../../primitives/forms/axial_ties.hpp"
#include "../../primitives/forms/wall_ties.hpp"
#include "../test_support.hpp"

namespace vcell::axial_ties_test {

// F(u) = x u_x + z u_z + w, of C = 2 for the sake of whole numbers.
RadialForm form(const std::array<int, 3>& f) {
    RadialForm r{};
    r.c[0] = 2.0;
    r.b = {Exact(f[0]), Exact(), Exact(f[1])};
    r.b0 = f[2];
    return r;
}

double at(const std::array<int, 3>& f, double angle) {
    return f[0] * std::sin(angle) + f[1] * std::cos(angle) + f[2];
}

TEST_CASE("axial ties: a side half-way between two planes as far from the axis gives way to them") {
    // The planes are across u_x, the side is met at u_z.
    const auto ties = find_axial_ties(std::vector{form({1, 0, 1}), form({-1, 0, 1}), form({0, 1, 0})});
    REQUIRE(ties.size() == 1);
    CHECK(ties[0].middle == 2);
    CHECK(ties[0].move == 0);
    // A tube that comes nearer between them is nearest about there.
    CHECK(find_axial_ties(std::vector{form({1, 0, 1}), form({-1, 0, 1}), form({0, 0, 2})}).empty());
    CHECK(find_axial_ties(std::vector{form({1, 0, 1}), form({-1, 0, 1}), form({0, 2, 0})}).empty());
}

// Where b ties with a the cosine is 2^-20 times the sine, and F_j - F_b is (cos - 2^-20 sin + off) / 2^30: as
// good as nothing, but over an angle `off`.
TEST_CASE("axial ties: what is nearer by next to nothing is left out over a narrow strip only") {
    const RadialForm a = form({0, 1 << 20, 0}), b = form({1, 0, 0});
    RadialForm j = b;
    j.b[0] = 1 - 0x1p-50;
    j.b[2] = 0x1p-30;
    j.b0 = 0x1p-30 * 0x1p-12;
    CHECK(find_axial_ties(std::vector{a, b, j}).empty());
    j.b0 = 0x1p-30 * 0x1p-36;
    const auto ties = find_axial_ties(std::vector{a, b, j});
    REQUIRE(!ties.empty());
    for (const AxialTie& tie : ties) {
        CHECK(tie.middle == 2);
        CHECK(tie.move > 0);
    }
}

TEST_CASE("axial ties: what is left out is nowhere nearest, and ties over the generator") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> whole(-3, 3);
    int touching = 0;
    for (int i = 0; i < 20'000 * rounds(); ++i) {
        std::array<std::array<int, 3>, 3> f;
        for (auto& g : f)
            for (int& x : g) x = whole(rng);
        CAPTURE(f);
        for (const AxialTie& tie : find_axial_ties(std::vector{form(f[0]), form(f[1]), form(f[2])})) {
            const auto &j = f[tie.middle], &a = f[tie.before], &b = f[tie.after];
            double least = 100;
            constexpr int places = 360;
            for (int k = 0; k < places; ++k) {
                const double angle = 2 * std::numbers::pi * k / places;
                const double above = std::max(at(a, angle), at(b, angle)) - at(j, angle);
                CHECK(above > -1e-12);
                least = std::min(least, above);
            }
            CHECK(least < 0.1);
            // None of the three is a mean of the others.
            const int det = j[0] * (a[1] * b[2] - a[2] * b[1]) - j[1] * (a[0] * b[2] - a[2] * b[0]) +
                            j[2] * (a[0] * b[1] - a[1] * b[0]);
            touching += det != 0;
        }
    }
    CHECK(touching > 20);
}

// x of the chart of a cylinder, from -1 on.
double angle_of(double x) { return x <= 1 ? 2 * std::atan(x) : 2 * std::atan(x - 2) + std::numbers::pi; }

TEST_CASE(
    "axial ties: what passes between two others is no nearer in its ranges, and ties over the generator") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> whole(-3, 3);
    std::array<int, 4> found{};  // with so many ranges; 3: hidden all around
    for (int i = 0; i < 20'000 * rounds(); ++i) {
        std::array<std::array<int, 3>, 4> f;
        std::vector<RadialForm> forms;
        for (auto& g : f) {
            for (int& x : g) x = whole(rng);
            forms.push_back(form(g));
        }
        CAPTURE(f);
        for (const PassingTie& tie : find_passing_ties(forms)) {
            const auto above = [&](double x) {
                const double angle = angle_of(x);
                return std::max(at(f[tie.before], angle), at(f[tie.after], angle)) - at(f[tie.form], angle);
            };
            double least = 100;
            constexpr int places = 400;
            const auto is_in = [&](double x) {
                return std::ranges::any_of(tie.ranges, [&](const auto& r) { return r[0] <= x && x <= r[1]; });
            };
            for (int k = 0; k <= places; ++k) {
                const double x = -1 + 4.0 * k / places;
                if (!is_in(x)) continue;
                CHECK(above(x) > -1e-12);
                least = std::min(least, above(x));
            }
            CHECK(least < 0.2);
            // Beyond the ranges the form comes nearer than one of the others, at once.
            bool is_open = false;
            for (const auto& r : tie.ranges)
                for (const double end : {r[0] - 1e-6, r[1] + 1e-6})
                    if (std::isfinite(end)) {
                        is_open = true;
                        const double angle = angle_of(end < -1 ? end + 4 : end > 3 ? end - 4 : end);
                        CHECK(std::min(at(f[tie.before], angle), at(f[tie.after], angle)) <
                              at(f[tie.form], angle));
                    }
            ++found[is_open ? tie.ranges.size() : 3];
        }
    }
    CHECK(found[1] > 20);
    CHECK(found[2] > 5);
    CHECK(found[3] > 5);
}

// C - 2 t B of a wall, C = c0 + c1 y.
TEST_CASE("wall ties: of three planes through a line that is left out which no point is beyond alone") {
    std::mt19937_64 rng(test_seed());
    const auto number = [&] { return std::uniform_int_distribution(-4, 4)(rng); };
    using Wall = std::array<int, 4>;  // c0, c1, b_x, b_z
    const auto form_of = [](const Wall& w) {
        RadialForm r{};
        r.c = {Exact(w[0]), Exact(w[1]), Exact()};
        r.b = {Exact(w[2]), Exact(), Exact(w[3])};
        return r;
    };
    const auto inwards = [](const Wall& w, const Wall& point) {
        return w[0] * point[0] + w[1] * point[1] - 2 * (w[2] * point[2] + w[3] * point[3]);
    };
    int ties = 0, others = 0;
    for (int round = 0; round < long_rounds(400); ++round) {
        const Wall first{number(), number(), number(), number()},
            second{number(), number(), number(), number()};
        const int a = number(), b = number();
        Wall third;
        for (int k = 0; k < 4; ++k) third[k] = a * first[k] + b * second[k];
        if (round % 4 == 0) ++third[number() & 3];
        const std::array<Wall, 3> walls{first, second, third};
        const std::vector found =
            find_wall_ties(std::vector{form_of(first), form_of(second), form_of(third)}, 1, 0);
        CHECK(found.size() <= 1);
        for (const WallTie& tie : found) {
            CHECK(tie.off == 0);
            CHECK(tie.middle + tie.first + tie.second == 3);
            for (int k = 0; k < 100; ++k) {
                // Homogeneous points (1 : y : t u), of any sizes.
                const Wall point{1 + std::abs(number()), number(), number(), number()};
                const int m = inwards(walls[tie.middle], point), f = inwards(walls[tie.first], point),
                          g = inwards(walls[tie.second], point);
                CHECK((m >= 0 || f < 0 || g < 0));
                CHECK((m != 0 || f < 0 || g < 0 || (f == 0 && g == 0)));
            }
        }
        (found.empty() ? others : ties) += 1;
    }
    CHECK(ties > long_rounds(400) / 4);
    CHECK(others > long_rounds(400) / 4);
    // Sides x <= 2 and z <= 2 and a wall through their edge, which holds more than either or less.
    const RadialForm x = form_of({4, 0, 1, 0}), z = form_of({4, 0, 0, 1});
    CHECK(find_wall_ties(std::vector{x, z, form_of({8, 0, 1, 1})}, 1, 0) == std::vector{WallTie{2, 0, 1, 0}});
    CHECK(find_wall_ties(std::vector{x, z, form_of({4, 0, 2, -1})}, 1, 0) ==
          std::vector{WallTie{0, 1, 2, 0}});
    CHECK(find_wall_ties(std::vector{x, z, form_of({7, 0, 1, 1})}, 1, 0).empty());
    // Places up to 4 from the origin, where that wall is 2^-40 beside the edge.
    RadialForm beside = form_of({8, 0, 1, 1});
    beside.c[0] = 8.0 + 0x1p-38;
    CHECK(find_wall_ties(std::vector{x, z, beside}, 4, 0x1p-42).empty());
    const auto near = find_wall_ties(std::vector{x, z, beside}, 4, 0x1p-38);
    REQUIRE(near.size() == 1);
    CHECK(near[0].middle == 2);
    CHECK(near[0].off == doctest::Approx(0x1p-39));
    // A twin of x that is beside the edge by so little meets x far away from it.
    RadialForm twin = form_of({4, 0, 1, 0});
    twin.b[2] = 0x1p-30;
    twin.c[0] = 4.0 + 0x1p-28;
    CHECK(find_wall_ties(std::vector{x, z, twin}, 4, 0x1p-38).size() == 1);
    twin.c[0] = 4.0 + 0x1p-28 + 0x1p-39;
    CHECK(find_wall_ties(std::vector{x, z, twin}, 4, 0x1p-38).empty());
}

}  // namespace vcell::axial_ties_test
