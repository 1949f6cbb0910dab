// Ties of forms in one pencil, against all triples of functions of small integers.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/forms/pencil_ties.hpp"
#include "../test_support.hpp"

namespace vcell::pencil_ties_test {

using Numbers = std::array<int, 5>;  // K, A, B, C and the denominator

FormFamily family_of(const std::vector<Numbers>& numbers) {
    FormFamily family;
    for (const auto& [K, A, B, C, W] : numbers)
        family.forms.push_back(
            {.k = double(K), .a = double(A), .b = double(B), .e = double(C), .w = double(W)});
    family.exact = [=](FormId f) {
        const auto& [K, A, B, C, W] = numbers[f.value];
        return ExactForm{Exact(K), Exact(A), Exact(B), Exact(C), Exact(W)};
    };
    return family;
}

// Is c = (1 - m) f + m g with 0 < m < 1? By the numbers over all three denominators.
bool is_between(const Numbers& c, const Numbers& f, const Numbers& g) {
    const auto over = [&](const Numbers& h, int k) { return h[k] * (c[4] * f[4] * g[4] / h[4]); };
    int numerator = 0, denominator = 0;
    for (int k = 0; k < 4; ++k) {
        const int part = over(c, k) - over(f, k), all = over(g, k) - over(f, k);
        if (all != 0 && denominator == 0) numerator = part, denominator = all;
    }
    if (denominator < 0) numerator = -numerator, denominator = -denominator;
    if (!(0 < numerator && numerator < denominator)) return false;
    for (int k = 0; k < 4; ++k)
        if ((over(c, k) - over(f, k)) * denominator != (over(g, k) - over(f, k)) * numerator) return false;
    return true;
}

TEST_CASE("pencil ties: are all forms that lie between two others") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> whole(-2, 2), positive(1, 2);
    std::size_t found = 0;
    for (int i = 0; i < 200 * rounds(); ++i) {
        CAPTURE(i);
        std::vector<Numbers> numbers;
        while (numbers.size() < 24) {
            const Numbers n{whole(rng) / 2, whole(rng), whole(rng), whole(rng), positive(rng)};
            const auto is_one = [&](const Numbers& m) {
                for (int k = 0; k < 4; ++k)
                    if (m[k] * n[4] != n[k] * m[4]) return false;
                return true;
            };
            if (std::ranges::none_of(numbers, is_one)) numbers.push_back(n);
        }
        std::set<std::array<std::uint32_t, 3>> expected, ties;
        for (std::uint32_t c = 0; c < numbers.size(); ++c)
            for (std::uint32_t f = 0; f < numbers.size(); ++f)
                for (std::uint32_t g = f + 1; g < numbers.size(); ++g)
                    if (c != f && c != g && is_between(numbers[c], numbers[f], numbers[g]))
                        expected.insert({c, f, g});
        for (const PencilTie& tie : find_pencil_ties(family_of(numbers)))
            ties.insert({tie.form.value, tie.between[0].value, tie.between[1].value});
        CHECK(ties == expected);
        found += ties.size();
    }
    CHECK(found > 100u * static_cast<std::size_t>(rounds()));
}

// A ball about the origin, one beside it, and a tube with its mirror image in the plane between the two.
TEST_CASE("pencil ties: a tube's mirror image between two balls is left out") {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.5};
    scene.box = {Vec3::Constant(-8), Vec3::Constant(8)};
    double ahead = 3;  // of the image: twice the mirror's place less the tube's
    bool is_tie = true;
    double radius = 0.25;
    SUBCASE("as it is") {}
    SUBCASE("not where it would be nearer") {
        ahead = 2.75;
        is_tie = false;
    }
    SUBCASE("not of another radius") {
        radius = 0.125;
        is_tie = false;
    }
    scene.objects = {Sphere{{4, 0, 0}, 0.5}, Cylinder{{1, 2, 0}, {0, 1, 2}, 0.25},
                     Cylinder{{ahead, 2, 0}, {0, 1, 2}, radius}};
    const RadialBaseProblem problem = radial_base_problem(scene, 1);
    std::size_t found = 0;
    for (const PencilTie& tie : find_pencil_ties(problem.family)) {
        const auto object = [&](FormId f) {
            const Site site = problem.sites[f].front();
            return site.is_object() ? site.index : 9;
        };
        if (problem.family.is_circular(tie.form)) continue;
        ++found;
        CHECK(object(tie.form) == 2);
        CHECK(object(tie.between[0]) + object(tie.between[1]) == 1);
    }
    CHECK(found == (is_tie ? 1 : 0));
}

// Two tubes of a ball's radius, opposite each other, and a plane through the line in which its bisectors with
// both meet.
TEST_CASE("pencil ties: a plane in which two tubes' bisectors meet is left out, and ties where it is met") {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.25};
    scene.box = {Vec3::Constant(-16), Vec3::Constant(16)};
    std::size_t expected = 2;
    double radius = 0.25;
    Vec3 axis(0, 5, 0), place(0, 10, 0);
    SUBCASE("between balls") {}
    SUBCASE("along a diagonal") { axis = {0, 3, 4}, place = {0, 6, 8}; }
    SUBCASE("only that which is there") {
        place.y() = 9.75;
        expected = 1;
    }
    SUBCASE("not of tubes of another radius") {
        radius = 0.125;
        expected = 0;
    }
    const Vec3 opposite = -2 * axis;
    scene.objects = {Cylinder{{5, 0, 0}, axis, radius}, Cylinder{{-5, 0, 0}, axis, radius},
                     Sphere{opposite, 0.25}, Sphere{place, 0.25}};
    const RadialBaseProblem problem = radial_base_problem(scene, 1);
    std::size_t found = 0;
    for (const PencilTie& tie : find_pencil_ties(problem.family)) {
        if (!tie.is_factor) continue;
        ++found;
        CHECK(problem.family.is_circular(tie.form));
        for (const FormId f : tie.between) CHECK(!problem.family.is_circular(f));
    }
    CHECK(found == expected);
}

}  // namespace vcell::pencil_ties_test
