// Ranges over boxes of the chart against values of their members in 320 bits.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "../../core/numbers/wide.hpp"
#include "../../primitives/forms/radial_height.hpp"
#include "../test_support.hpp"

namespace vcell::radial_height_test {
namespace {

class Samples {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    bool coin() { return number(0, 1) < 0.5; }
    // Of any sign and size, now and then zero.
    double any(double exponents) {
        const double x = std::ldexp(number(-1, 1), static_cast<int>(number(-exponents, exponents)));
        return number(0, 1) < 0.03 ? 0 : x;
    }
    double size(double exponents) { return std::abs(any(exponents)); }
    Interval from(double a, double b) { return {std::min(a, b), std::max(a, b)}; }
    // One in three is a number.
    Interval about(double x) {
        const double width = std::ldexp(std::abs(x), static_cast<int>(number(-60, 1)));
        return number(0, 3) < 1 ? Interval(x) : from(x, coin() ? x + width : x - width);
    }
    double member(const Interval& x) {
        const double t = number(-0.2, 1.2);
        return std::clamp(x.lower() + t * (x.upper() - x.lower()), x.lower(), x.upper());
    }

private:
    std::mt19937_64 rng_{test_seed()};
};

bool holds(const Interval& range, const Wide& value) {
    const Interval v = value.enclosure();
    return range.lower() <= v.upper() && v.lower() <= range.upper();
}

TEST_CASE(
    "radial heights: ranges of roots and shares hold those of their members, and of numbers are tight") {
    Samples samples;
    for (const double exponents : {3.0, 60.0, 400.0, 520.0})
        for (int round = 0; round < long_rounds(5000); ++round) {
            const Interval B = samples.about(samples.any(exponents));
            Interval A2 = samples.about(samples.size(exponents)), C = samples.about(samples.size(exponents));
            A2 = {std::max(0.0, A2.lower()), A2.upper()};
            if (!(C.lower() > 0)) continue;
            CAPTURE(B.lower());
            CAPTURE(A2.lower());
            CAPTURE(C.lower());
            const Interval q = root_range(B, A2, C), s = share(B, A2);
            for (int k = 0; k < 4; ++k) {
                const Wide b(samples.member(B)), a2(samples.member(A2)), c(samples.member(C));
                CHECK(holds(q, larger_root(b, a2, c)));
                CHECK(holds(s, share(b, a2)));
            }
            if (B.lower() != B.upper() || A2.lower() != A2.upper() || C.lower() != C.upper()) continue;
            if (exponents > 60 || B.lower() == 0 || A2.lower() == 0) continue;
            CHECK(q.radius() <= 0x1p-49 * q.upper());
            CHECK(s.radius() <= 0x1p-49);
        }
}

TEST_CASE("radial heights: linear functions of normals around a cylinder hold those of their members") {
    Samples samples;
    for (int round = 0; round < 5000; ++round) {
        const double x0 = samples.number(-1, 3), width = std::pow(10, samples.number(-17, 0.7));
        const Interval x = round % 8 == 0 ? Interval(x0) : Interval(x0, std::min(3.0, x0 + width));
        std::array<Interval, 3> v{samples.number(-2, 2), 0.0, samples.number(-2, 2)};
        const double m = samples.member(x);
        const RadialNormals<Wide> at(BaseShape::Cylinder, Wide(m), Wide(0.0));
        if (round % 3 == 0) {
            // An extremum in the box.
            const Interval s = at.along<0>({Wide(1.0), Wide(0.0), Wide(0.0)}).v.enclosure(),
                           c = at.along<0>({Wide(0.0), Wide(0.0), Wide(1.0)}).v.enclosure();
            v = {s.mid(), 0.0, c.mid()};
        }
        CAPTURE(x.lower());
        CAPTURE(x.upper());
        CAPTURE(m);
        const FunctionJet<Interval> over =
            RadialNormals<Interval>(BaseShape::Cylinder, x, Interval(0.0)).along<2>(v);
        const FunctionJet<Wide> jet = at.along<2>({Wide(v[0].lower()), Wide(0.0), Wide(v[2].lower())});
        CHECK(holds(over.v, jet.v));
        CHECK(holds(over.x, jet.x));
        CHECK(holds(over.xx, jet.xx));
        // v.u changes by no more than 2 |v| for each unit of x, its derivative by no more than twice that.
        const double most = 16 * (x.radius() + 0x1p-50);
        CHECK(over.v.radius() <= most);
        CHECK(over.x.radius() <= most);
    }
}

// Of numbers of any size, also where they overflow or all but vanish.
TEST_CASE("radial heights: what is computed in doubles with one bound holds its members, and is tight") {
    Samples samples;
    for (const double exponents : {0.0, 20.0, 500.0, 1000.0})
        for (int round = 0; round < 3000; ++round) {
            const auto vector = [&] {
                return std::array{samples.about(samples.any(exponents)), Interval(0.0),
                                  samples.about(samples.any(exponents))};
            };
            const std::array<Interval, 3> v = vector(), a = vector();
            const Interval s = samples.about(samples.any(exponents));
            const double y = samples.any(std::min(exponents, 20.0)), x = samples.number(-1, 3);
            const TurnedEnd<Interval> end{Interval(x)};
            const TurnedEnd<Wide> wide_end{Wide(x)};
            const LinearOfNormals<Interval> sum =
                LinearOfNormals<Interval>(v).plus(NumberBall<Interval>(s), y, LinearOfNormals<Interval>(a));
            const auto over = sum.at(end);
            const auto number = [&](const Interval& i) { return Wide(samples.member(i)); };
            const auto numbers = [&](const std::array<Interval, 3>& i) {
                return LinearOfNormals<Wide>(std::array{number(i[0]), Wide(0.0), number(i[2])});
            };
            CAPTURE(v[0].lower());
            CAPTURE(v[2].lower());
            CAPTURE(y);
            const LinearOfNormals<Wide> member =
                numbers(v).plus(NumberBall<Wide>(number(s)), Wide(y), numbers(a));
            const auto at = member.at(wide_end);
            CHECK(holds(over[0], at[0]));
            CHECK(holds(over[1], at[1]));
            CHECK(sum.size().upper() >= member.size().enclosure().lower());
            if (exponents == 0 && v[0].lower() == v[0].upper() && v[2].lower() == v[2].upper())
                CHECK(LinearOfNormals<Interval>(v).at(end)[0].radius() <=
                      0x1p-49 * (v[0].magnitude() + v[2].magnitude()) + 0x1p-1000);

            std::array<Interval, 3> c{samples.about(samples.any(exponents)),
                                      samples.about(samples.any(exponents)),
                                      samples.about(samples.size(exponents))};
            if (c[2].lower() < 0) c[2] = 0.0;
            const Interval place = samples.about(y);
            const auto range = QuadraticOf<Interval>(c).over(place);
            const QuadraticOf<Wide> one(std::array{number(c[0]), number(c[1]), number(c[2])});
            const auto value = one.over(number(place));
            CHECK(holds(range.value, value.value));
            CHECK(holds(range.slope, value.slope));
        }
}

}  // namespace
}  // namespace vcell::radial_height_test
