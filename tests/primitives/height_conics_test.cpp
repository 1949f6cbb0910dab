#include "../../primitives/bisectors/height_conics.hpp"

#include <doctest/doctest.h>

#include <random>

#include "reference.hpp"
#include "test_support.hpp"

namespace vcell::height_conics_test {

namespace {

struct Ball {
    double x, y, z, rho;
};

ExactForm exact_form(const Ball& b) {
    return {1.0, -2.0 * Exact(b.x), -2.0 * Exact(b.y),
            Exact(b.x) * b.x + Exact(b.y) * b.y + (Exact(b.z) - b.rho) * (Exact(b.z) + b.rho),
            2.0 * (Exact(b.z) + b.rho)};
}

FormFamily family_of(const std::vector<Ball>& balls, const std::vector<ExactForm>& planes,
                     std::vector<CylinderForm> cylinders) {
    std::vector<ExactForm> exact;
    for (const Ball& b : balls) exact.push_back(exact_form(b));
    exact.insert(exact.end(), planes.begin(), planes.end());
    FormFamily family;
    family.forms.resize(exact.size());
    family.exact = [exact](FormId f) { return exact[f.value]; };
    family.cylinders = std::move(cylinders);
    return family;
}

Real height(const FormFamily& family, FormId f, const Real& x, const Real& y) {
    if (!family.is_circular(f)) return cylinder_height(family.cylinder(f), x, y);
    const ExactForm e = family.exact(f);
    return (real(e.K) * (x * x + y * y) + real(e.A) * x + real(e.B) * y + real(e.C)) / real(e.W);
}

// Points of {height 0 = height 1} on random segments lie in the planes; the number of points found.
int check_planes(const FormFamily& family, const std::vector<std::array<Exact, 4>>& planes,
                 std::mt19937_64& rng) {
    std::uniform_real_distribution<double> wide(-6, 6);
    int found = 0;
    for (int round = 0; round < 40; ++round) {
        const Real x0 = wide(rng), y0 = wide(rng), x1 = wide(rng), y1 = wide(rng);
        const auto difference = [&](const Real& t) {
            const Real x = x0 + t * (x1 - x0), y = y0 + t * (y1 - y0);
            return Real(height(family, {0}, x, y) - height(family, {1}, x, y));
        };
        Real a = 0, b = 1;
        if (difference(a) * difference(b) >= 0) continue;
        const bool rising = difference(b) > 0;
        for (int i = 0; i < 250; ++i) {
            const Real m = (a + b) / 2;
            ((difference(m) > 0) == rising ? b : a) = m;
        }
        const Real x = x0 + a * (x1 - x0), y = y0 + a * (y1 - y0), z = height(family, {0}, x, y);
        Real least = 1;
        for (const auto& p : planes) {
            const Real norm = abs(real(p[0])) + abs(real(p[1])) + abs(real(p[2])) + abs(real(p[3]));
            const Real value = real(p[0]) * x + real(p[1]) * y + real(p[2]) * z + real(p[3]);
            const Real residual = abs(value) / norm;
            if (residual < least) least = residual;
        }
        CHECK(least < Real(1e-60));
        ++found;
    }
    return found;
}

}  // namespace

TEST_CASE("height planes: special positions of cylinders and balls split, one ulp off they do not") {
    std::mt19937_64 rng(test_seed());
    struct Case {
        const char* name;
        FormFamily family;
        FormFamily near;
        std::size_t planes;
    };
    const auto up = [](double v) { return std::nextafter(v, 100.0); };
    const std::vector<Case> cases = {
        {"equal radii, crossing axes of equal length",
         family_of({}, {}, {{1, 2, 3, 3, 4, 0, 0.5}, {1, 2, 3, 0, 5, 0, 0.5}}),
         family_of({}, {}, {{1, 2, 3, 3, 4, 0, 0.5}, {1, 2, 3, 0, 5, 0, up(0.5)}}), 2},
        {"equal radii, crossing axes of lengths 3 and 7, tilted",
         family_of({}, {}, {{1, 2, 30, 2, 2, 1, 0.5}, {1, 2, 30, 6, 3, -2, 0.5}}),
         family_of({}, {}, {{1, 2, 30, 2, 2, 1, 0.5}, {1, up(2), 30, 6, 3, -2, 0.5}}), 2},
        {"parallel axes along the base, any radii",
         family_of({}, {}, {{1, 2, 3, 1, 0.5, 0, 0.5}, {0, 1, 2, -2, -1, 0, 0.25}}),
         family_of({}, {}, {{1, 2, 3, 1, 0.5, 0, 0.5}, {0, 1, 2, -2, up(-1), 0, 0.25}}), 1},
        {"parallel tilted axes, any radii",
         family_of({}, {}, {{1, 20, 3, 1, 0.5, 2, 0.5}, {20, 1, 2, -2, -1, -4, 0.25}}),
         family_of({}, {}, {{1, 20, 3, 1, 0.5, 2, 0.5}, {20, 1, 2, -2, up(-1), -4, 0.25}}), 1},
        {"a ball centred on an upright cylinder's axis",
         family_of({{7, 2, 3, 1}}, {}, {{7, 2, 0, 0, 0, 1, 0.5}}),
         family_of({{7, 2, 3, 1}}, {}, {{up(7), 2, 0, 0, 0, 1, 0.5}}), 2},
    };
    for (const Case& c : cases) {
        CAPTURE(c.name);
        const auto planes = height_planes(c.family, {0}, {1});
        CHECK(planes.size() == c.planes);
        CHECK(check_planes(c.family, planes, rng) >= (c.family.forms.empty() ? 3 : 0));
        CHECK(height_planes(c.near, {0}, {1}).empty());
        CHECK(height_planes(c.family, {1}, {0}).size() == c.planes);
    }
}

TEST_CASE("height planes: a plane's height is its bisecting plane") {
    std::mt19937_64 rng(test_seed());
    const FormFamily family = family_of({}, {{0.0, 0.25, -0.5, 3.0, 2.0}}, {{0, 0, 4, 1, 2, 0.25, 0.5}});
    const auto planes = height_planes(family, {0}, {1});
    REQUIRE(planes.size() == 1);
    CHECK(check_planes(family, planes, rng) > 3);
}

TEST_CASE("height planes: axes of incommensurable lengths have irrational bisecting planes") {
    const FormFamily family = family_of({}, {}, {{1, 2, 3, 1, 1, 0, 0.5}, {1, 2, 3, 1, 0, 0, 0.5}});
    CHECK(height_planes(family, {0}, {1}).empty());
}

TEST_CASE("height planes: random cylinders and balls share no plane curve") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 50; ++round) {
        const auto cylinder = [&] {
            return CylinderForm{unit(rng), unit(rng), 3 + unit(rng), unit(rng), unit(rng), unit(rng), 0.5};
        };
        CHECK(height_planes(family_of({}, {}, {cylinder(), cylinder()}), {0}, {1}).empty());
        CHECK(height_planes(family_of({{unit(rng), unit(rng), 2, 0.5}}, {}, {cylinder()}), {0}, {1}).empty());
    }
}

}  // namespace vcell::height_conics_test
