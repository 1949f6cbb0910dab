// Growth with the number of objects, by counts of decisions instead of times: no machine, load or build
// changes them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "../../bench/growth_scene.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "test_support.hpp"

namespace vcell::growth_test {
using namespace vcell::bench;

namespace {

// One in the quick suite: its spread is a matter of the slow one.
unsigned seeds() { return rounds() > 1 ? 3 : 1; }
std::uint32_t more() { return rounds() > 1 ? 4 : 3; }  // times as many objects
constexpr double chance = 1.15;                        // for that of so few scenes
constexpr double most_spread = 5;                      // of the costliest scene, times their median

// The power of n that decisions may grow with.
double most_growth(GrowthBase base, Mix mix) {
    // Faces are lunes from pole to pole, as narrow as there are tubes, and pieces are no lunes.
    return base == GrowthBase::Ball && mix == Mix::ParallelTubes ? 1.5 : 1.25;
}

// The smaller number of objects. Among fewer balls a ball's diagram has no trees, and decides less.
std::uint32_t fewest(GrowthBase base, Mix mix) {
    if (base == GrowthBase::Ball && mix == Mix::Balls) return 400;
    return rounds() > 1 ? 100 : 60;
}

// What deciding cells took, ascending.
std::vector<double> decisions(GrowthBase base, Mix mix, std::uint32_t objects) {
    std::vector<double> counts;
    for (unsigned seed = 1; seed <= seeds(); ++seed) {
        CellOptions options;
        options.measure = false;
        const Decisions d = voronoi_cell(growth_scene(base, mix, objects, seed), options).report.decisions;
        counts.push_back(static_cast<double>(d.total()));
        // Hundreds of digits are for ties, and take some hundred times as long.
        CHECK(static_cast<double>(d.by_multiprecision) <= 0.0125 * counts.back());
    }
    std::ranges::sort(counts);
    return counts;
}

void check_growth(GrowthBase base) {
    for (const Mix mix : mixes) {
        const std::string family = name_of(base) + "/" + name_of(mix);
        CAPTURE(family);
        const std::vector<double> few = decisions(base, mix, fewest(base, mix)),
                                  many = decisions(base, mix, more() * fewest(base, mix));
        const auto median = [](const std::vector<double>& counts) { return counts[seeds() / 2]; };
        CHECK(median(many) <= chance * std::pow(more(), most_growth(base, mix)) * median(few));
        for (const auto& counts : {few, many}) CHECK(counts.back() <= most_spread * median(counts));
    }
}

}  // namespace

TEST_CASE("growth: over a plane decisions grow little faster than the number of objects, in every mix") {
    check_growth(GrowthBase::Plane);
}
TEST_CASE(
    "growth: over a tilted plane decisions grow little faster than the number of objects, in every mix") {
    check_growth(GrowthBase::TiltedPlane);
}
TEST_CASE("growth: around a ball decisions grow little faster than the number of objects, in every mix") {
    check_growth(GrowthBase::Ball);
}
TEST_CASE("growth: around a tube decisions grow little faster than the number of objects, in every mix") {
    check_growth(GrowthBase::Tube);
}

}  // namespace vcell::growth_test
