/// The merge by overlay against the merge of one form at a time.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "../test_support.hpp"
#include "canonical.hpp"
#include "form_scenes.hpp"
#include "oracle.hpp"

namespace vcell::merge_test {
namespace {

oracle::Renaming unchanged(const FormScene& s) {
    oracle::Renaming r;
    r.form.resize(s.numbers.size());
    std::iota(r.form.begin(), r.form.end(), 0u);
    r.side.resize(s.region().sides.size());
    std::iota(r.side.begin(), r.side.end(), 0u);
    return r;
}

void same_by_overlay(const FormScene& s) {
    CAPTURE(s.name);
    const FormFamily family = s.family();
    const oracle::Renaming r = unchanged(s);
    const std::vector<std::string> expected = oracle::canonical(lower_envelope(family, s.region()), r);
    for (const std::size_t largest_piece : {1, 4}) {
        CAPTURE(largest_piece);
        EnvelopeOptions options;
        options.largest_piece = largest_piece;
        std::vector<std::string> found;
        CHECK_NOTHROW(found = oracle::canonical(lower_envelope(family, s.region(), options), r));
        CHECK(found == expected);
    }
}

/// n forms that are all equal above the origin, each lowest in a sector there.
FormScene hub(int n, bool equal) {
    FormScene s{.name = "hub, n = " + std::to_string(n), .numbers = {}, .polygon = {}};
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        const double x = dyadic(std::cos(angle)), y = dyadic(std::sin(angle)),
                     w = equal ? 2 : 2 + i % 3 * 0x1p-16;
        s.paraboloid(x, y, 2 * w - (x * x + y * y), w);
    }
    return s;
}

}  // namespace

TEST_CASE("lower_envelope: merging by overlay gives the diagram of merging one by one, coarse numbers") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 300; ++i) same_by_overlay(coarse(rng, 3 + i % 20));
}

TEST_CASE("lower_envelope: merging by overlay gives the diagram of merging one by one, divided regions") {
    std::mt19937_64 rng(test_seed());
    same_by_overlay(random_spheres(rng, 400, 20));
    same_by_overlay(heavy_tailed(rng, 400));
    same_by_overlay(in_polygon(spheres_and_planes(rng, 300, 20)));
    FormScene square = lattice("square lattice, divided", 16, 1, 0, 1, -8, -8);
    square.rectangle = {-8, -8, 7, 7};
    same_by_overlay(square);
}

TEST_CASE("lower_envelope: merging by overlay gives the diagram of merging one by one, degenerate families") {
    for (const FormScene& s : degenerate_scenes()) same_by_overlay(s);
}

TEST_CASE("lower_envelope: merging by overlay gives the diagram of merging one by one, random scenes") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 40; ++i) {
        same_by_overlay(random_spheres(rng, 2 + i, std::sqrt(2.0 + i)));
        same_by_overlay(random_spheres(rng, 2 + i, 1));
        same_by_overlay(heavy_tailed(rng, 2 + i));
        same_by_overlay(spheres_and_planes(rng, 1 + i, 1 + i % 4));
        same_by_overlay(in_polygon(spheres_and_planes(rng, 1 + i, 1 + i % 4)));
    }
}

TEST_CASE("lower_envelope: a hole that the challenger covers, and its surroundings within a larger face") {
    FormScene s{.name = "a shallow disk under a deep one", .numbers = {}, .polygon = {}};
    s.plane(0, 0, 1);
    s.paraboloid(1, 0, 128 - 0.0625, 128);  // the disk of radius 1/4, in the plane's face
    s.paraboloid(1, 0, 1 - 0.25, 1);        // of radius 1/2, lower all over the first
    const FormFamily family = s.family();
    for (const std::size_t largest_piece : {1, 256}) {
        EnvelopeOptions options;
        options.largest_piece = largest_piece;
        std::mt19937_64 rng(test_seed());
        const auto complaints =
            oracle::check_diagram(lower_envelope(family, s.region(), options), family, rng);
        CHECK(complaints.empty());
    }
}

TEST_CASE("lower_envelope: a circle runs through a point where another form touches the same face") {
    FormScene s{.name = "touching point on a later circle", .numbers = {}, .polygon = {}};
    s.plane(0, 0, 1);
    s.paraboloid(1.5, 1, 1.5, 1.5);  // touches the plane at (1.5, 1)
    s.paraboloid(2, 1, 0.25, 0.5);   // meets it in the circle of radius 1/2, leftmost there
    s.rectangle = {-2, -2, 3, 3};
    const FormFamily family = s.family();
    for (const std::size_t largest_piece : {1, 256}) {
        EnvelopeOptions options;
        options.largest_piece = largest_piece;
        std::mt19937_64 rng(test_seed());
        CHECK(oracle::check_diagram(lower_envelope(family, s.region(), options), family, rng).empty());
    }
}

TEST_CASE("lower_envelope: four hundred forms that meet in one vertex") {
    for (const bool equal : {true, false}) {
        const FormScene s = hub(400, equal);
        const FormFamily family = s.family();
        const MinimizationDiagram d = lower_envelope(family, s.region());
        EnvelopeOptions one_by_one;
        one_by_one.largest_piece = s.numbers.size();
        CHECK(oracle::canonical(d, unchanged(s)) ==
              oracle::canonical(lower_envelope(family, s.region(), one_by_one), unchanged(s)));
        std::size_t largest = 0;
        for (const VertexId v : d.vertices.ids()) largest = std::max(largest, d.label(v).size());
        CHECK(largest == 400);
        CHECK((!equal || d.dcel.face_count() == 401));
    }
}

}  // namespace vcell::merge_test
