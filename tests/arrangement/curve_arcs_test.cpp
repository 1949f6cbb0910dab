#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "check_arrangement.hpp"
#include "test_support.hpp"
#include "vcell/arrangement/curves/curve_arcs.hpp"
#include "vcell/arrangement/sweep/overlay.hpp"

namespace vcell::curve_arcs_test {
using Arc = CurveArcs::Arc;

namespace {

std::vector<Arc> all_arcs(const CurveArcs& g, const std::vector<CurveId>& curves) {
    std::vector<Arc> arcs;
    for (const CurveId c : curves) g.cut(c, arcs);
    return arcs;
}

void check_counts(CurveArcs& g, const std::vector<Arc>& arcs, std::size_t vertices, std::size_t edges,
                  std::size_t faces) {
    const auto a = arrange<CurveArcs>(g, arcs);
    CHECK(arrangement_defect(g, a) == "");
    CHECK(a.dcel.vertex_count() == vertices);
    CHECK(a.dcel.edge_count() == edges);
    CHECK(a.dcel.face_count() == faces);
}

}  // namespace

TEST_CASE("mixed arcs: a Bezier curve meets itself and its turns") {
    CurveArcs g;
    const auto loop = g.add_bezier({{0, 0, 1}, {2.5, 2, 1}, {-1.5, 2, 1}, {1, 0, 1}});
    auto arcs = all_arcs(g, {loop});
    CHECK(arcs.size() == 3);
    check_counts(g, arcs, 5, 5, 2);
    // Symmetric about x = 1/2: the vertical line there passes the double point and the top.
    arcs.push_back(g.segment(g.add_line(2, 0, -1), g.point(0.5, -1), g.point(0.5, 3)));
    check_counts(g, arcs, 8, 5 + 1 + 3, 3);
    // What has the line's x: the turn of the loop in y, the double point.
    CHECK(g.decisions().assumed > 0);
    for (const auto& p : g.assumed_at()) CHECK(p.x() == doctest::Approx(0.5).epsilon(1e-14));
}

TEST_CASE("mixed arcs: contacts of circles and a parabola") {
    CurveArcs g;
    // y = x^2 over [-1, 1]. The circle has it as a chord at its leftmost and rightmost points and touches it
    // below.
    const auto parabola = g.add_bezier({{-1, 1, 1}, {0, -1, 1}, {1, 1, 1}});
    CHECK(parabola == g.add_bezier({{1, 1, 1}, {0, -1, 1}, {-1, 1, 1}}));
    const auto circle = g.add_circle(0, 1, 1);
    CHECK(circle == g.add_circular({.k = -2, .cx = 0, .cy = 1, .e = 2}));
    const auto arcs = all_arcs(g, {parabola, circle});
    check_counts(g, arcs, 3, 5, 4);
    CHECK(g.decisions().assumed == 1);
    REQUIRE(g.assumed_at().size() == 1);
    CHECK(g.assumed_at()[0].norm() < 1e-14);
    CHECK(g.decisions().by_exact > 0);

    SUBCASE("lines 1e-12 off the tangent are decided") {
        for (const double height : {-1e-12, 1e-12, -1e-30, 1e-30}) {
            CAPTURE(height);
            CurveArcs h;
            auto two = all_arcs(h, {h.add_bezier({{-1, 1, 1}, {0, -1, 1}, {1, 1, 1}})});
            two.push_back(h.segment(h.add_line(0, 1, -height), h.point(-2, height), h.point(2, height)));
            const std::size_t crossings = height > 0 ? 2 : 0;
            check_counts(h, two, 4 + crossings, 2 + 2 * crossings, crossings == 0 ? 1 : 2);
            CHECK(h.decisions().assumed == 0);
        }
    }
}

TEST_CASE("mixed arcs: coinciding curves of different kinds become one") {
    // A cubic that is a segment, on a line.
    CurveArcs g;
    auto arcs = all_arcs(g, {g.add_bezier({{-1, -2, 1}, {0, -1, 1}, {1, 0, 1}, {2, 1, 1}})});
    arcs.push_back(g.segment(g.add_line(1, -1, -1), g.point(0, -1), g.point(3, 2)));
    check_counts(g, arcs, 4, 3, 1);
}

TEST_CASE("mixed arcs: lines and circles are exact in any degeneracy") {
    CurveArcs g;
    // Four circles through the origin, the axes, and both diagonals.
    std::vector<CurveId> circles;
    for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}})
        circles.push_back(g.add_circle(x, y, 1));
    auto arcs = all_arcs(g, circles);
    for (const auto& [x, y] : {std::pair(2, 0), {0, 2}, {2, 2}, {2, -2}})
        arcs.push_back(g.segment(g.add_line(y, -x, 0), g.point(-x, -y), g.point(x, y)));
    // The origin, (+-1, +-1), the outermost points of the circles on the axes, and the diagonals' ends.
    check_counts(g, arcs, 1 + 4 + 4 + 4, 16 + 4 * 2 + 4, 17);
    CHECK(g.decisions().assumed == 0);
    CHECK(g.decisions().by_multiprecision == 0);
    CHECK(g.decisions().by_exact > 0);
}

namespace {

/// A mix of curves in general position, moved by (dx, dy).
struct RandomMix {
    std::vector<std::array<double, 3>> circles;  // squared radius last
    std::vector<std::array<double, 4>> segments;
    std::vector<std::vector<Eigen::Vector3d>> beziers;
    std::vector<RationalCurve2> splines;

    explicit RandomMix(std::mt19937_64& rng) {
        // Multiples of 1/1024: sums and the coefficients of lines are exact.
        const auto number = [&](double lo, double hi) {
            return std::floor(1024 * std::uniform_real_distribution(lo, hi)(rng)) / 1024;
        };
        for (int i = 0; i < 3; ++i) circles.push_back({number(-1, 1), number(-1, 1), number(0.1, 1)});
        for (int i = 0; i < 2; ++i)
            segments.push_back({number(-2, -1), number(-1, 1), number(1, 2), number(-1, 1)});
        segments.push_back({segments[0][0], -1.5, segments[0][0], 1.5});
        for (int i = 0; i < 2; ++i) {
            RationalCurve2 spline{3, {0, 0, 0, 0, 1, 2, 2, 4, 4, 4, 4}, {}};
            for (int k = 0; k < 7; ++k)
                spline.points.push_back({number(-2, 2), number(-2, 2), number(0.5, 2)});
            splines.push_back(spline);
        }
        for (int i = 0; i < 2; ++i) {
            std::vector<Eigen::Vector3d> points;
            for (int k = 0; k < 4 + i; ++k) points.push_back({number(-2, 2), number(-2, 2), number(0.5, 2)});
            beziers.push_back(points);
        }
    }
    std::vector<Arc> arcs(CurveArcs& g, double dx = 0, double dy = 0) const {
        std::vector<CurveId> curves;
        for (const auto& [x, y, r] : circles) curves.push_back(g.add_circle(x + dx, y + dy, r));
        for (RationalCurve2 spline : splines) {
            for (auto& p : spline.points) p += Eigen::Vector3d(dx, dy, 0);
            const auto spans = g.add_spline(spline);
            curves.insert(curves.end(), spans.begin(), spans.end());
        }
        for (auto points : beziers) {
            for (auto& p : points) p += Eigen::Vector3d(dx, dy, 0);
            curves.push_back(g.add_bezier(points));
        }
        auto result = all_arcs(g, curves);
        for (const auto& [x0, y0, x1, y1] : segments) {
            const double a = y1 - y0, b = x0 - x1;
            const auto line = g.add_line(a, b, -a * (x0 + dx) - b * (y0 + dy));
            result.push_back(g.segment(line, g.point(x0 + dx, y0 + dy), g.point(x1 + dx, y1 + dy)));
        }
        return result;
    }
};

std::array<std::size_t, 3> counts(const Dcel& d) {
    return {d.vertex_count(), d.edge_count(), d.face_count()};
}

}  // namespace

TEST_CASE("mixed arcs: overlay is the arrangement of the union, in any order and anywhere") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 4; ++round) {
        CAPTURE(round);
        const RandomMix mix(rng);
        CurveArcs g;
        auto arcs = mix.arcs(g);
        const auto all = arrange<CurveArcs>(g, arcs);
        REQUIRE(arrangement_defect(g, all) == "");
        std::shuffle(arcs.begin(), arcs.end(), rng);
        CHECK(same_topology(arrange<CurveArcs>(g, arcs).dcel, all.dcel));
        const auto half = static_cast<std::ptrdiff_t>(arcs.size() / 2);
        const auto a = arrange<CurveArcs>(g, std::vector<Arc>(arcs.begin(), arcs.begin() + half));
        const auto b = arrange<CurveArcs>(g, std::vector<Arc>(arcs.begin() + half, arcs.end()));
        CHECK(same_topology(overlay(g, a, b).dcel, all.dcel));
        CHECK(same_topology(overlay(g, b, a).dcel, all.dcel));
        // The vertical segment starts at the end of another one: exact. Nothing else coincides.
        CHECK(g.decisions().assumed == 0);

        CurveArcs moved;
        CHECK(counts(arrange<CurveArcs>(moved, mix.arcs(moved, 21.25, -7.5)).dcel) == counts(all.dcel));
        CHECK(moved.decisions().assumed == 0);
    }
}

TEST_CASE("mixed arcs: a spline is its spans, joined") {
    // Two periods of something like a wave, with a knot as often as the degree in the middle.
    RationalCurve2 wave{3, {0, 0, 0, 0, 1, 2, 2, 2, 3, 4, 4, 4, 4}, {}};
    for (const double y : {0.0, 3.0, -3.0, 2.0, 0.0, -2.0, 3.0, -3.0, 0.0})
        wave.points.push_back({static_cast<double>(wave.points.size()), y, 1});
    CurveArcs g;
    auto arcs = all_arcs(g, g.add_spline(wave));
    CHECK(arcs.size() == 4);
    for (std::size_t i = 0; i + 1 < arcs.size(); ++i) CHECK(arcs[i].right == arcs[i + 1].left);
    check_counts(g, arcs, 5, 4, 1);
    // Between its ends the axis crosses it where it changes its sign, and once where it is 0 in a knot.
    int changes = 0;
    constexpr int steps = 4001;
    for (int i = 1; i < steps; ++i) {
        const auto at = [&](int k) { return wave.evaluate(4.0 * k / steps).y(); };
        changes += i > 1 && at(i - 1) * at(i) < 0;
    }
    arcs.push_back(g.segment(g.add_line(0, 1, 0), g.point(0, 0), g.point(8, 0)));
    const auto a = arrange<CurveArcs>(g, arcs);
    CHECK(arrangement_defect(g, a) == "");
    // Joints: the three inner ones, of which the middle one is on the axis. Each crossing is a vertex.
    CHECK(a.dcel.face_count() == static_cast<std::size_t>(1 + changes + 1));
    CHECK(g.decisions().assumed == 0);
}

TEST_CASE("mixed arcs: points are found in the face, on the edge and in the vertex where they are") {
    std::mt19937_64 rng(test_seed() + 1);
    std::uniform_real_distribution<double> place(-1.5, 1.5);
    for (int round = 0; round < 2; ++round) {
        CurveArcs g;
        const RandomMix mix(rng);
        const auto a = arrange<CurveArcs>(g, mix.arcs(g));
        std::vector<CurveArcs::Point> some;
        for (int i = 0; i < 60; ++i) some.push_back(g.point(place(rng), place(rng)));
        check_location(g, a, some);
    }
}

}  // namespace vcell::curve_arcs_test
