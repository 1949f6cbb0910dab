/// Insertion by walking in the order of K against the recursion, and the bound that leaves out hidden forms.
#include <doctest/doctest.h>

#include <numeric>
#include <optional>
#include <random>

#include "../../envelope/diagram/patchwork.hpp"
#include "../../envelope/recursion/ceiling.hpp"
#include "../../envelope/recursion/piece_merger.hpp"
#include "../test_support.hpp"
#include "canonical.hpp"
#include "form_scenes.hpp"

namespace vcell::walking_test {
namespace {

RegionPiece piece_of(const ConvexRegion& region) {
    Sides sides;
    for (std::uint32_t i = 0; i < region.sides.size(); ++i)
        sides.push_back({region.sides[i].a, region.sides[i].b, region.sides[i].c, i});
    return make_piece(sides);
}

/// The diagram of a scene by walking alone, however few forms there are; none where that gives up.
std::optional<MinimizationDiagram> by_walking(const FormScene& s) {
    const FormFamily family = s.family();
    std::vector<FormId> ids;
    std::vector<CompetingForms::Item> candidates;
    for (std::uint32_t i = 0; i < family.size(); ++i) {
        ids.push_back(FormId{i});
        candidates.push_back(i);
    }
    const CompetingForms forms(family, ids);
    const EnvelopeOptions options;
    PieceMerger merger(family, options);
    const RegionPiece piece = piece_of(s.region());
    const WorkDiagram* diagram = merger.merge_by_walking(piece, forms, candidates);
    if (diagram == nullptr) return std::nullopt;
    Patchwork patchwork(family, family.size());
    patchwork.add(*diagram, piece.sides);
    MinimizationDiagram result = patchwork.finish(Heights(family));
    result.region = s.region();
    return result;
}

/// Returns whether the scene is one for walking.
bool same_by_walking(const FormScene& s) {
    CAPTURE(s.name);
    oracle::Renaming unchanged;
    unchanged.form.resize(s.numbers.size());
    std::iota(unchanged.form.begin(), unchanged.form.end(), 0u);
    unchanged.side.resize(s.region().sides.size());
    std::iota(unchanged.side.begin(), unchanged.side.end(), 0u);
    std::optional<MinimizationDiagram> found;
    CHECK_NOTHROW(found = by_walking(s));
    if (!found) return false;
    EnvelopeOptions without;  // it takes no smaller pieces than these
    without.largest_piece = 16;
    const FormFamily family = s.family();
    CHECK(oracle::canonical(*found, unchanged) ==
          oracle::canonical(lower_envelope(family, s.region(), without), unchanged));
    return true;
}

/// Points over [0, size]^2 whose forms have one K, or several that doubles hardly tell apart.
FormScene equal_widths(std::mt19937_64& rng, int n, double size, int widths) {
    std::uniform_real_distribution<double> u(0, 1);
    FormScene s{.name = "equal widths, n = " + std::to_string(n), .numbers = {}, .polygon = {}};
    s.rectangle = {0, 0, size, size};
    for (int i = 0; i < n; ++i)
        s.paraboloid(dyadic(size * u(rng)), dyadic(size * u(rng)), dyadic(0.5 * u(rng)),
                     1 + static_cast<double>(rng() % static_cast<unsigned>(widths)) * 0x1p-52);
    return s;
}

/// A plane and low balls, most of them islands in it.
FormScene islands(std::mt19937_64& rng, int n, double size) {
    FormScene s = random_spheres(rng, n, size);
    s.name = "islands, n = " + std::to_string(n);
    s.plane(0, 0, 0.2);
    return s;
}

}  // namespace

TEST_CASE("walking: gives the diagram of the recursion, coarse numbers") {
    std::mt19937_64 rng(test_seed());
    int walked = 0, scenes = 0;
    for (int i = 0; i < long_rounds(300); ++i) {
        FormScene s = coarse(rng, 3 + i % 40);
        // More flat forms are not for walking.
        std::size_t flat = 0;
        std::erase_if(s.numbers,
                      [&](const FormScene::Numbers& n) { return n.k == 0 && 9 * ++flat > s.numbers.size(); });
        if (!s.numbers.empty()) walked += same_by_walking(s);
        ++scenes;
    }
    CHECK(4 * walked > 3 * scenes);
}

TEST_CASE("walking: gives the diagram of the recursion, degenerate families") {
    int walked = 0;
    for (const FormScene& s : degenerate_scenes())
        if (!s.numbers.empty()) walked += same_by_walking(s);
    CHECK(walked > 0);
    CHECK(same_by_walking(lattice("square lattice", 12, 1, 0, 1, -5.5, -5.5)));
}

TEST_CASE("walking: gives the diagram of the recursion, random scenes") {
    std::mt19937_64 rng(test_seed());
    int walked = 0, scenes = 0;
    const auto compare = [&](const FormScene& s) {
        walked += same_by_walking(s);
        ++scenes;
    };
    for (int i = 0; i < long_rounds(40); ++i) {
        const int n = 2 + 4 * (i % 20);
        compare(random_spheres(rng, n, std::sqrt(n)));
        compare(random_spheres(rng, n, 1));
        compare(heavy_tailed(rng, n));
        compare(in_polygon(spheres_and_planes(rng, n, n / 10)));
        compare(islands(rng, n, std::sqrt(n)));
        compare(equal_widths(rng, n, std::sqrt(n), 1));
        compare(equal_widths(rng, n, std::sqrt(n), 5));
    }
    CHECK(3 * walked > 2 * scenes);
    CHECK(same_by_walking(random_spheres(rng, 400, 20)));
}

TEST_CASE("walking: of many forms, few are inserted more than once, and none are merged by overlay") {
    std::mt19937_64 rng(test_seed());
    const int n = 1000;
    const FormScene s = random_spheres(rng, n, std::sqrt(n));
    const EnvelopeWork work = lower_envelope(s.family(), s.region()).work;
    CHECK(work.insertions < 1.2 * n);
    CHECK(work.merges == 0);
}

TEST_CASE("walking: forms above the ceiling are the lowest nowhere, and those far away are above it") {
    std::mt19937_64 rng(test_seed());
    const int n = 200;
    const double size = std::sqrt(n);
    for (const bool planes : {false, true}) {
        const FormScene s = planes ? spheres_and_planes(rng, n, 20) : random_spheres(rng, n, size);
        const Rectangle r{2, size - 2, 2, size - 2};
        std::vector<KernelForm> forms;
        for (const CircularForm& f : s.family().forms) forms.push_back(KernelForm::of(f));
        Ceiling ceiling;
        ceiling.start(r, forms.size());
        for (const KernelForm& f : forms)
            if (f.k > 0 && f.cx > r.x0 && f.cx < r.x1 && f.cy > r.y0 && f.cy < r.y1)
                ceiling.add(f, f.cx, f.cy);
        ceiling.finish();
        std::vector<char> lowest(forms.size(), false);
        std::uniform_real_distribution<double> u(r.x0, r.x1);
        for (int i = 0; i < 2000; ++i) {
            const double x = u(rng), y = u(rng);
            std::size_t best = 0;
            for (std::size_t f = 1; f < forms.size(); ++f)
                if (forms[f].jet(x, y).v < forms[best].jet(x, y).v) best = f;
            lowest[best] = true;
        }
        int hidden = 0;
        for (std::size_t f = 0; f < forms.size(); ++f) {
            const KernelForm& form = forms[f];
            const bool is_hidden = ceiling.hides(form);
            hidden += is_hidden;
            CHECK_FALSE((is_hidden && lowest[f]));
            if (form.k <= 0) continue;
            const double x = std::clamp(form.cx, r.x0, r.x1), y = std::clamp(form.cy, r.y0, r.y1);
            CHECK_FALSE((ceiling.is_over_all(form, x, y) && lowest[f]));
        }
        CHECK(hidden > 0);
    }
}

}  // namespace vcell::walking_test
