// Faces cut into parts about an axis: what seams make of loops of straight runs, against areas by hand, and
// the sector that a point is in, against a look at all of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "../../envelope/lift/face_cut.hpp"
#include "../../envelope/lift/joined_spans.hpp"
#include "../../envelope/lift/sectors_around.hpp"
#include "../test_support.hpp"

namespace vcell::face_cut_test {
namespace {

BoundaryRun run(std::uint32_t within, const std::vector<Vec2>& points) {
    BoundaryRun r{{}, within};
    begin_joined(r.trim.curve, 1, points.size() - 1);
    for (const Vec2& p : points) r.trim.curve.points.push_back({p.x(), p.y(), 1});
    return r;
}

double area(const std::vector<TrimCurve>& loop) {
    double twice = 0;
    for (const TrimCurve& trim : loop)
        for (std::size_t i = 0; i + 1 < trim.curve.points.size(); ++i) {
            const auto &p = trim.curve.points[i], &q = trim.curve.points[i + 1];
            twice += p.x() * q.y() - p.y() * q.x();
        }
    return 0.5 * twice;
}

}  // namespace

TEST_CASE("face cut: a loop of one run with many corners is a part, and one the other way round its hole") {
    const std::vector<Vec2> outer{{-0.5, 0}, {0.5, 0}, {0.5, 2}, {0, 1.5}, {-0.5, 2}, {-0.5, 0}},
        hole{{-0.1, 0.5}, {0, 1}, {0.1, 0.5}, {-0.1, 0.5}};
    std::uint32_t seams = 0;
    const std::vector<CutSector> sectors{{1, 0}, {1, 1}};
    const auto parts = cut_face({{run(1, outer)}, {run(1, hole)}}, sectors, seams);
    REQUIRE(parts);
    REQUIRE(parts->size() == 1);
    CHECK(seams == 0);
    CHECK(parts->front().within == 1);
    REQUIRE(parts->front().loops.size() == 2);
    CHECK(std::abs(area(parts->front().loops[0]) - 1.75) < 1e-15);
    CHECK(std::abs(area(parts->front().loops[1]) + 0.05) < 1e-15);
    // A hole that no part holds.
    const std::vector<Vec2> beyond{{-0.1, 1.8}, {0, 2.3}, {0.1, 1.8}, {-0.1, 1.8}};
    CHECK_FALSE(cut_face({{run(1, outer)}, {run(1, beyond)}}, sectors, seams));
}

TEST_CASE("face cut: a seam divides a loop with many corners") {
    // From u = -0.5 in sector 0 over its end at u = 1 to u = 0.5 beyond the start of sector 1 at u = -1.
    const std::vector<Vec2> first{{1, 3}, {0.2, 2.5}, {-0.5, 3}, {-0.5, 1}, {0.3, 1.25}, {1, 1}},
        second{{-1, 1}, {-0.2, 0.5}, {0.5, 1}, {0.5, 3}, {-1, 3}};
    std::uint32_t seams = 0;
    const std::vector<CutSector> sectors{{1, 0}, {1, 1}, {1, 2}};
    const auto parts = cut_face({{run(0, first), run(1, second)}}, sectors, seams);
    REQUIRE(parts);
    REQUIRE(parts->size() == 2);
    CHECK(seams == 1);
    double sum = 0;
    for (const CutPart& part : *parts) {
        REQUIRE(part.loops.size() == 1);
        CHECK(part.loops.front().size() == 2);
        sum += area(part.loops.front());
    }
    CHECK(std::abs(sum - (3 - 0.375 - 0.1875 + 3 + 0.375)) < 1e-14);
}

// A face with two arms into the same angles, each with heights of its own there, from the sector before or
// from the one beyond: heights along the seam are those of that.
TEST_CASE("face cut: two sectors at one place have a part of the face each") {
    const std::vector<CutSector> sectors{{1, 0}, {1, 1}, {1, 2}, {1, 1}};
    for (const bool is_before : {true, false}) {
        const std::uint32_t body = is_before ? 0 : 2;
        std::vector<BoundaryRun> loop{run(body, {{1, 5}, {-0.5, 5}, {-0.5, 0}, {1, 0}}),
                                      run(1, {{-1, 7}, {0.5, 7}, {0.5, 8}, {-1, 8}}),
                                      run(body, {{1, 1}, {0.5, 1}, {0.5, 4}, {1, 4}}),
                                      run(3, {{-1, 0.2}, {0.5, 0.2}, {0.5, 0.4}, {-1, 0.4}})};
        if (!is_before) {
            std::ranges::reverse(loop);
            for (BoundaryRun& r : loop) {
                std::ranges::reverse(r.trim.curve.points);
                for (auto& p : r.trim.curve.points) p.x() = -p.x();
            }
        }
        std::uint32_t seams = 0;
        const auto parts = cut_face({loop}, sectors, seams);
        REQUIRE(parts);
        REQUIRE(parts->size() == 3);
        CHECK(seams == 2);
        for (const CutPart& part : *parts) {
            REQUIRE(part.loops.size() == 1);
            const double expected = part.within == body ? 6 : part.within == 1 ? 1.5 : 0.3;
            CHECK(std::abs(area(part.loops.front()) - expected) < 1e-15);
        }
    }
}

TEST_CASE("sectors around: the one found is the one a point is least outside of, of all") {
    using std::numbers::pi;
    std::mt19937_64 random(test_seed());
    std::uniform_real_distribution<double> angle(-pi, pi);
    for (const std::size_t count : {2u, 3u, 40u, 500u}) {
        const double start = angle(random);
        std::vector<double> starts{start};
        for (std::size_t i = 1; i < count; ++i)
            starts.push_back(start + pi + (count == 2 ? 0.3 : 1) * angle(random));
        std::ranges::sort(starts);
        const auto end = [&](std::size_t i) { return i + 1 < count ? starts[i + 1] : start + 2 * pi; };
        std::size_t found_in_last = 0;
        for (int k = 0; k < 1000; ++k) {
            // Every second one is on a side but for rounding.
            const double p = k % 2 == 0 ? angle(random) : starts[static_cast<std::size_t>(k) % count];
            const auto half_from = [&](std::size_t i) {
                return 0.5 * std::remainder(p - 0.5 * (starts[i] + end(i)), 2 * pi);
            };
            const auto outside = [&](std::size_t i) {
                return std::abs(std::tan(half_from(i)) + 0x1p-32) - std::tan(0.25 * (end(i) - starts[i]));
            };
            double least = outside(0);
            for (std::size_t i = 1; i < count; ++i) least = std::min(least, outside(i));
            const std::uint32_t found = sector_around(starts, half_from(0), outside);
            REQUIRE(outside(found) == least);
            found_in_last += found + 1 == count;
        }
        CHECK(found_in_last > 0);
    }
}

}  // namespace vcell::face_cut_test
