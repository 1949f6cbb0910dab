// Heights of cylinders over boxes of a plane base against values of their members in 320 bits.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"

namespace vcell::heights_test {
namespace {

class Samples {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    // Of any sign and size, now and then zero.
    double any(double exponents) {
        const double x = std::ldexp(number(-1, 1), static_cast<int>(number(-exponents, exponents)));
        return number(0, 1) < 0.05 ? 0 : x;
    }
    Interval about(double x, double exponents) {
        const double width = std::ldexp(number(0, 1), static_cast<int>(number(-50, exponents)));
        return number(0, 3) < 1 ? Interval(x) : Interval(x, x + width);
    }
    double member(const Interval& x) {
        return std::clamp(x.lower() + number(-0.2, 1.2) * (x.upper() - x.lower()), x.lower(), x.upper());
    }

private:
    std::mt19937_64 rng_{test_seed()};
};

bool holds(const Interval& range, const Wide& value) {
    const Interval v = value.enclosure();
    return range.lower() <= v.upper() && v.lower() <= range.upper();
}

// Sizes of any order, axes along the base and across it, and boxes from points to many radii.
TEST_CASE(
    "heights: those of solid and hollow cylinders over a plane hold their members', and over points are tight") {
    Samples samples;
    int bounded = 0, tight = 0;
    for (const double exponents : {0.0, 10.0, 300.0, 600.0})
        for (int round = 0; round < long_rounds(4000); ++round) {
            CylinderForm f;
            f.px = samples.any(exponents);
            f.py = samples.any(exponents);
            f.pz = samples.any(exponents);
            f.ax = samples.any(0);
            f.ay = samples.any(exponents / 100);
            f.az = samples.any(exponents / 100);
            f.rho = std::abs(samples.any(exponents));
            if (round % 2 == 1) f.rho = -f.rho;  // hollow
            FormFamily family;
            family.cylinders.push_back(f);
            const Heights heights(family);
            const Interval x = samples.about(samples.any(exponents), exponents / 2),
                           y = samples.about(samples.any(exponents), exponents / 2);
            const HeightJet<Interval> over = heights.jet(FormId{0}, x, y);
            if (!std::isfinite(over.v.lower()) || !std::isfinite(over.v.upper())) continue;
            ++bounded;
            CAPTURE(f.px);
            CAPTURE(f.az);
            CAPTURE(x.lower());
            CAPTURE(x.upper());
            for (int k = 0; k < 3; ++k) {
                const HeightJet<Wide> at =
                    heights.jet(FormId{0}, Wide(samples.member(x)), Wide(samples.member(y)));
                CHECK(holds(over.v, at.v));
                CHECK(holds(over.gx, at.gx));
                CHECK(holds(over.gy, at.gy));
            }
            const Interval value = heights.value(FormId{0}, x, y);
            CHECK(value.lower() == over.v.lower());
            CHECK(value.upper() == over.v.upper());
            const bool is_point = x.lower() == x.upper() && y.lower() == y.upper();
            if (exponents > 0 || !is_point || over.v.lower() < 0.1) continue;
            ++tight;
            CHECK(over.v.radius() <= 0x1p-40 * over.v.upper());
        }
    CHECK(bounded > long_rounds(2000));
    CHECK(tight > long_rounds(50));
}

}  // namespace
}  // namespace vcell::heights_test
