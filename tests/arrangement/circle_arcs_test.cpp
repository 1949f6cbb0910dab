#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "check_arrangement.hpp"
#include "test_support.hpp"
#include "vcell/arrangement/circles/circle_arcs.hpp"

namespace vcell::circle_arcs_test {
using Arc = CircleArcs::Arc;

namespace {

/// With integer data, so that the oracle below can decide contacts exactly.
struct Circle {
    int x, y, r;
};
struct Segment {
    int x0, y0, x1, y1;
};

/// Circles as forms (p - c)^2 - r^2 against zero: inside is where f < 0, counter-clockwise.
class Scene {
public:
    Scene() : arcs(kernel) {}
    explicit Scene(const std::vector<Circle>& circles, const std::vector<Segment>& segments = {}) : Scene() {
        for (const Circle& c : circles) add_form(c.x, c.y, c.r);
        reset();
        for (std::uint32_t i = 0; i < circles.size(); ++i) arcs.cut_circle(circle(i), pieces);
        for (const Segment& s : segments) add(s);
    }
    void add_form(double x, double y, double r) {
        family.forms.push_back({.k = 1, .cx = x, .cy = y, .e = -r * r});
    }
    void reset() {
        family.exact = [this](FormId id) {
            const CircularForm& f = family.forms[id];
            const Exact x(f.cx), y(f.cy);
            return ExactForm{Exact(1.0), Exact(-2.0) * x, Exact(-2.0) * y, x * x + y * y + Exact(f.e),
                             Exact(f.w)};
        };
        kernel.reset(&family);
        for (const FormId f : family.forms.ids()) forms.push_back(kernel.add_form(f));
    }
    FormPair circle(std::uint32_t i) const { return {forms[i], CircleKernel::zero_form()}; }
    FormPair line(double a, double b, double c) {
        return {kernel.add_line(a, b, c), CircleKernel::zero_form()};
    }
    PointId point(double x, double y) {
        return arcs.crossing(line(1, 0, -x), line(0, 1, -y), Sign::Positive, {x, y}).value();
    }
    /// The line f < 0 left of the way from one end to the other.
    void add(const Segment& s) {
        const double dx = s.x1 - s.x0, dy = s.y1 - s.y0;
        const FormPair l = line(dy, -dx, dx * s.y0 - dy * s.x0);
        const auto end = [&](double x, double y) {
            const FormPair across = line(dx, dy, -dx * x - dy * y);
            return arcs.crossing(l, across, Sign::Positive, {x, y}).value();
        };
        const PointId from = end(s.x0, s.y0);
        arcs.cut_arc(l, from, end(s.x1, s.y1), pieces);
    }

    CircularFamily family;
    std::vector<FormId> forms;
    CircleKernel kernel;
    CircleArcs arcs;
    std::vector<Arc> pieces;
};

/// Counts by all pairs in floating point. Contacts are decided on integers; different points of curves with
/// small integer data are further apart than the tolerance. Pre: circles differ; segments do not overlap.
Counts brute_force(const std::vector<Circle>& circles, const std::vector<Segment>& segments) {
    constexpr double tolerance = 1e-7;
    std::vector<std::array<double, 2>> points;
    const auto add = [&](double x, double y) {
        for (const auto& p : points) {
            if (std::hypot(p[0] - x, p[1] - y) < tolerance) return;
        }
        points.push_back({x, y});
    };
    for (const Circle& a : circles) {
        add(a.x - a.r, a.y);
        add(a.x + a.r, a.y);
        for (const Circle& b : circles) {
            const int dx = b.x - a.x, dy = b.y - a.y, d2 = dx * dx + dy * dy;
            if (d2 == 0 || d2 > (a.r + b.r) * (a.r + b.r) || d2 < (a.r - b.r) * (a.r - b.r)) continue;
            const double along = (d2 + a.r * a.r - b.r * b.r) / (2.0 * d2);
            const double off = std::sqrt(std::max(0.0, double(a.r * a.r) / d2 - along * along));
            const bool touch = d2 == (a.r + b.r) * (a.r + b.r) || d2 == (a.r - b.r) * (a.r - b.r);
            for (const int side : {-1, 1}) {
                const double h = touch ? 0 : side * off;
                add(a.x + along * dx - h * dy, a.y + along * dy + h * dx);
            }
        }
        for (const Segment& s : segments) {
            const int dx = s.x1 - s.x0, dy = s.y1 - s.y0, fx = s.x0 - a.x, fy = s.y0 - a.y;
            const double A = dx * dx + dy * dy, B = dx * fx + dy * fy, C = fx * fx + fy * fy - a.r * a.r;
            const double discriminant = B * B - A * C;  // exact
            if (discriminant < 0) continue;
            for (const int side : {-1, 1}) {
                const double t = (-B + side * std::sqrt(discriminant)) / A;
                if (t > -tolerance && t < 1 + tolerance) add(s.x0 + t * dx, s.y0 + t * dy);
            }
        }
    }
    for (const Segment& s : segments) {
        add(s.x0, s.y0);
        add(s.x1, s.y1);
        for (const Segment& t : segments) {
            const double ux = s.x1 - s.x0, uy = s.y1 - s.y0, vx = t.x1 - t.x0, vy = t.y1 - t.y0;
            const double det = ux * vy - uy * vx;
            if (det == 0) continue;
            const double a = ((t.x0 - s.x0) * vy - (t.y0 - s.y0) * vx) / det;
            const double b = ((t.x0 - s.x0) * uy - (t.y0 - s.y0) * ux) / det;
            if (std::min(a, b) > -tolerance && std::max(a, b) < 1 + tolerance)
                add(s.x0 + a * ux, s.y0 + a * uy);
        }
    }
    std::vector<std::uint32_t> part(points.size());
    std::iota(part.begin(), part.end(), 0u);
    const auto root = [&](std::uint32_t i) {
        while (part[i] != i) i = part[i];
        return i;
    };
    Counts counts{points.size(), 0, static_cast<long>(points.size())};
    const auto join = [&](const std::vector<std::uint32_t>& on_curve) {
        for (const std::uint32_t i : on_curve) {
            if (root(i) == root(on_curve[0])) continue;
            part[root(i)] = root(on_curve[0]);
            --counts.components;
        }
    };
    for (const Circle& a : circles) {
        std::vector<std::uint32_t> on;
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            if (std::abs(std::hypot(points[i][0] - a.x, points[i][1] - a.y) - a.r) < tolerance)
                on.push_back(i);
        }
        counts.edges += on.size();
        join(on);
    }
    for (const Segment& s : segments) {
        std::vector<std::uint32_t> on;
        const double dx = s.x1 - s.x0, dy = s.y1 - s.y0, l = std::hypot(dx, dy);
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            const double x = points[i][0] - s.x0, y = points[i][1] - s.y0;
            const double t = (x * dx + y * dy) / l;
            if (std::abs(x * dy - y * dx) / l < tolerance && t > -tolerance && t < l + tolerance)
                on.push_back(i);
        }
        counts.edges += on.size() - 1;
        join(on);
    }
    return counts;
}

void check(const std::vector<Circle>& circles, const std::vector<Segment>& segments = {}) {
    Scene scene(circles, segments);
    const auto a = arrange<CircleArcs>(scene.arcs, scene.pieces);
    REQUIRE(arrangement_defect(scene.arcs, a) == "");
    REQUIRE(Counts{a.dcel.vertex_count(), a.dcel.edge_count(), component_count(a.dcel)} ==
            brute_force(circles, segments));

    // Locations: the vertices, points on a half-integer grid. A face lies inside or outside of each circle.
    double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
    for (const Circle& c : circles) {
        x0 = std::min<double>(x0, c.x - c.r);
        x1 = std::max<double>(x1, c.x + c.r);
        y0 = std::min<double>(y0, c.y - c.r);
        y1 = std::max<double>(y1, c.y + c.r);
    }
    std::mt19937_64 rng(test_seed());
    const auto coordinate = [&](double from, double to) {
        return std::round(2 * std::uniform_real_distribution(from - 1, to + 1)(rng)) / 2;
    };
    std::vector<PointId> queries(a.points.begin(), a.points.end());
    std::map<FaceId, std::vector<Sign>> sides;
    for (int i = 0; i < 40; ++i) {
        const PointId p = scene.point(coordinate(x0, x1), coordinate(y0, y1));
        queries.push_back(p);
        const Feature at = locate_by_walk(scene.arcs, a, p);
        const FaceId* f = std::get_if<FaceId>(&at);
        if (!f) continue;
        std::vector<Sign> side;
        for (const Circle& c : circles) {
            const auto& q = scene.kernel.point(p);
            side.push_back(sign_of((q.x - c.x) * (q.x - c.x) + (q.y - c.y) * (q.y - c.y) - c.r * c.r));
        }
        REQUIRE(sides.try_emplace(*f, side).first->second == side);
    }
    check_location(scene.arcs, a, queries);
}

}  // namespace

TEST_CASE("circle arcs: degenerate families agree with brute force") {
    SUBCASE("one circle") { check({{0, 0, 5}}); }
    SUBCASE("concentric circles") { check({{1, 2, 1}, {1, 2, 3}, {1, 2, 7}}); }
    SUBCASE("circles that touch from outside and inside, left, right, above and below") {
        check({{0, 0, 4},
               {-7, 0, 3},
               {6, 0, 2},
               {0, 9, 5},
               {0, -5, 1},
               {-2, 0, 2},
               {3, 0, 1},
               {0, 2, 2},
               {0, -3, 1}});
    }
    SUBCASE("circles that touch in rational points off the axes") {
        check({{0, 0, 5}, {6, 8, 5}, {-3, -4, 10}, {3, 4, 10}, {-6, -8, 5}});
    }
    SUBCASE("all through one point, crossing there, at extremes and at the top") {
        check({{5, 0, 5},
               {-5, 0, 5},
               {0, 5, 5},
               {0, -5, 5},
               {3, 4, 5},
               {4, 3, 5},
               {-3, 4, 5},
               {10, 0, 10},
               {6, 8, 10}},
              {{-9, 0, 9, 0}, {0, -9, 0, 9}, {0, 0, 7, 7}, {-4, 3, 4, -3}});
    }
    SUBCASE("a pencil through two points") {
        std::vector<Circle> pencil;  // centres (0, k) with k^2 + 9 or k^2 + 144 a square
        for (const auto& [k, r] : {std::pair{5, 13}, {9, 15}, {16, 20}, {35, 37}, {0, 12}}) {
            pencil.push_back({0, k, r});
            if (k) pencil.push_back({0, -k, r});
        }
        check(pencil, {{-20, 0, 20, 0}, {12, -5, 12, 5}, {-12, 0, 0, 30}});
    }
    SUBCASE("a lattice of equal circles") {
        for (const int r : {1, 2, 3, 5}) {
            std::vector<Circle> lattice;
            for (int i = 0; i < 4; ++i) {
                for (int j = 0; j < 3; ++j) lattice.push_back({2 * i, 2 * j, r});
            }
            check(lattice);
        }
    }
    SUBCASE("vertical lines through extremes and centres, and tangent lines") {
        check({{0, 0, 5}, {5, 0, 5}, {10, 0, 5}}, {{0, -8, 0, 8},
                                                   {5, -8, 5, 8},
                                                   {-5, -1, -5, 1},
                                                   {15, 0, 15, 4},
                                                   {-9, 5, 19, 5},
                                                   {-9, -5, 19, -5},
                                                   {10, 0, 10, 5}});
    }
    SUBCASE("islands: circles inside circles, side by side") {
        check({{0, 0, 20}, {-8, 0, 5}, {8, 0, 5}, {-8, 0, 2}, {8, 3, 1}, {8, -3, 1}, {40, 0, 3}});
    }
}

TEST_CASE("circle arcs: random integer circles and segments agree with brute force") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 60; ++round) {
        CAPTURE(round);
        const int size = round % 2 ? 5 : 20;
        std::uniform_int_distribution coordinate(-size, size), radius(1, size);
        std::set<std::tuple<int, int, int>> different;
        for (int i = 0; i < 7; ++i) different.emplace(coordinate(rng), coordinate(rng), radius(rng));
        std::vector<Circle> circles;
        for (const auto& [x, y, r] : different) circles.push_back({x, y, r});
        std::vector<Segment> segments;
        for (int i = 0; i < 4; ++i) {  // through different parallels or with different slopes: no overlaps
            const int x = coordinate(rng), y = coordinate(rng);
            if (i < 2) segments.push_back(i ? Segment{-size, y, size, y} : Segment{x, -size, x, size});
            if (i >= 2) segments.push_back({x, y, x + 1 + radius(rng), y + (i == 2 ? -1 : 1) * radius(rng)});
        }
        check(circles, segments);
    }
}

TEST_CASE("circle arcs: a directed arc is cut at the extreme points it passes") {
    Scene scene;
    scene.add_form(1, 2, 5);
    scene.reset();
    const FormPair circle = scene.circle(0);
    // The points with integer coordinates, the extreme ones among them, by angle.
    std::vector<std::pair<double, PointId>> points;
    for (const auto& [x, y] :
         {std::pair{5, 0}, {4, 3}, {3, 4}, {0, 5}, {-3, 4}, {-5, 0}, {-4, -3}, {0, -5}, {3, -4}}) {
        const FormPair radial = scene.line(y, -x, -y * 1 + x * 2);
        // Along (x, y) from the centre, the circle's gradient turns to the line's by the same sign
        // everywhere.
        const PointId p = scene.arcs.crossing(circle, radial, Sign::Negative, {1.0 + x, 2.0 + y}).value();
        REQUIRE(scene.kernel.point(p).x == doctest::Approx(1 + x));
        points.emplace_back(std::atan2(y, x), p);
    }
    const double turn = 2 * std::numbers::pi;
    for (const bool reversed : {false, true}) {
        for (const auto& [alpha, p] : points) {
            for (const auto& [beta, q] : points) {
                if (p == q) continue;
                std::vector<Arc> arcs;
                scene.arcs.cut_arc(reversed ? circle.reversed() : circle, p, q, arcs);
                double expected = reversed ? alpha - beta : beta - alpha;
                if (expected < 0) expected += turn;
                double covered = 0;
                PointId at = p;
                for (const Arc& a : arcs) {
                    const bool lower = a.shape == Arc::Shape::Lower;
                    const bool rightward = lower != reversed;
                    REQUIRE(scene.arcs.compare_xy(a.left, a.right) == Sign::Negative);
                    REQUIRE(a.curve == (lower ? circle : circle.reversed()));
                    REQUIRE(scene.arcs.compare_xy(rightward ? a.left : a.right, at) == Sign::Zero);
                    at = rightward ? a.right : a.left;
                    const auto &l = scene.kernel.point(a.left), &r = scene.kernel.point(a.right);
                    covered += std::abs(std::acos(std::clamp((l.x - 1) / 5, -1.0, 1.0)) -
                                        std::acos(std::clamp((r.x - 1) / 5, -1.0, 1.0)));
                    CHECK(a.box[0] <= l.x);
                    CHECK(a.box[1] >= r.x);
                }
                REQUIRE(scene.arcs.compare_xy(at, q) == Sign::Zero);
                REQUIRE(covered == doctest::Approx(expected));
                REQUIRE(arcs.size() <= 3);
            }
        }
    }
}

TEST_CASE("circle arcs: the three curves of a triple share their points") {
    // Circles of Apollonius: the distances from three places are as 1 : sqrt(1.25) : sqrt(1.5).
    Scene scene;
    scene.family.forms = {{.k = 1, .cx = 0, .cy = 0, .w = 1},
                          {.k = 1, .cx = 6, .cy = 0, .w = 1.25},
                          {.k = 1, .cx = 2, .cy = 5, .w = 1.5}};
    scene.reset();
    const FormId a = scene.forms[0], b = scene.forms[1], c = scene.forms[2];
    for (const Sign s : {Sign::Negative, Sign::Positive}) {
        const Eigen::Vector2d near(3, 2);
        const auto p = scene.arcs.crossing({a, b}, {a, c}, s, near);
        REQUIRE(p.has_value());
        const std::vector<std::tuple<FormPair, FormPair, Sign>> names{
            {{b, c}, {b, a}, s}, {{a, c}, {a, b}, -s}, {{c, a}, {b, c}, -s}, {{a, c}, {b, c}, s}};
        for (const auto& [c1, c2, orientation] : names) {
            CHECK(scene.arcs.crossing(c1, c2, orientation, near) == p);
            // The kernel, asked afresh, finds the same place.
            const auto q = scene.kernel.intersection(c1, c2, orientation, near);
            REQUIRE(q.has_value());
            CHECK(scene.kernel.compare_xy(*p, *q) == Sign::Zero);
        }
    }
}

TEST_CASE("circle arcs: one curve under several names overlaps with itself") {
    // f - g, g - h and f - h are multiples of each other: one circle from three pairs.
    Scene scene;
    scene.family.forms = {{.k = 3, .e = -72}, {.k = 2, .e = -47}, {.k = 1, .e = -22}};
    scene.family.exact = [&](FormId id) {
        const CircularForm& f = scene.family.forms[id];
        return ExactForm{Exact(f.k), Exact(0.0), Exact(0.0), Exact(f.e), Exact(1.0)};
    };
    scene.kernel.reset(&scene.family);
    for (const FormId f : scene.family.forms.ids()) scene.forms.push_back(scene.kernel.add_form(f));
    const auto f = scene.forms[0], g = scene.forms[1], h = scene.forms[2];
    std::vector<Arc> arcs;
    for (const FormPair c : {FormPair{f, g}, FormPair{h, g}, FormPair{f, h}}) scene.arcs.cut_circle(c, arcs);
    REQUIRE(arcs.size() == 6);

    SweepInput<CircleArcs> input;
    for (const Arc& arc : arcs) input.add_arc(scene.arcs, arc);
    const auto swept = sweep(scene.arcs, input);
    CHECK(arrangement_defect(scene.arcs, swept.arrangement) == "");
    CHECK(swept.arrangement.dcel.vertex_count() == 2);
    REQUIRE(swept.arrangement.dcel.edge_count() == 2);
    CHECK(swept.edge_arcs[0].size() == 3);
    CHECK(swept.edge_arcs[1].size() == 3);

    // Part of one against the whole of another: cut where the part begins and ends.
    std::vector<Arc> part;
    const FormPair axis = scene.line(1, 0, -3);
    const auto p = scene.arcs.crossing({f, g}, axis, Sign::Negative, {3, 4}).value();
    const auto q = scene.arcs.crossing({f, g}, axis, Sign::Positive, {3, -4}).value();
    scene.arcs.cut_arc({f, g}, p, q, part);
    scene.arcs.cut_circle({f, h}, part);
    REQUIRE(part.size() == 4);
    for (const Arc& piece : {part[0], part[1]}) {
        for (const Arc& half : {part[2], part[3]}) {
            ArcIntersections<PointId, Arc> common;
            scene.arcs.intersect(piece, half, common);
            REQUIRE(common.overlaps.size() == (piece.shape == half.shape ? 1 : 0));
            CHECK(common.points.size() == (piece.shape == half.shape ? 0 : 1));
            if (common.overlaps.empty()) continue;
            CHECK(scene.arcs.compare_xy(common.overlaps[0].left, piece.left) == Sign::Zero);
            CHECK(scene.arcs.compare_xy(common.overlaps[0].right, piece.right) == Sign::Zero);
        }
    }
    const auto both = arrange<CircleArcs>(scene.arcs, part);
    CHECK(arrangement_defect(scene.arcs, both) == "");
    CHECK(both.dcel.vertex_count() == 4);
    CHECK(both.dcel.edge_count() == 4);
}

TEST_CASE("circle arcs: overlay of circle arrangements is the arrangement of all circles") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution coordinate(-6, 6), radius(1, 6);
    for (int round = 0; round < 20; ++round) {
        std::vector<Circle> circles;
        for (int i = 0; i < 8; ++i) circles.push_back({coordinate(rng), coordinate(rng), radius(rng)});
        Scene scene(circles);
        const auto half = static_cast<std::ptrdiff_t>(scene.pieces.size() / 2);
        const std::vector<Arc> first(scene.pieces.begin(), scene.pieces.begin() + half),
            second(scene.pieces.begin() + half, scene.pieces.end());
        const auto a = arrange<CircleArcs>(scene.arcs, first), b = arrange<CircleArcs>(scene.arcs, second);
        const auto both = overlay(scene.arcs, a, b);
        REQUIRE(arrangement_defect(scene.arcs, both) == "");
        REQUIRE(same_topology(both.dcel, arrange<CircleArcs>(scene.arcs, scene.pieces).dcel));
        REQUIRE(same_topology(both.dcel, overlay(scene.arcs, b, a).dcel));
    }
}

}  // namespace vcell::circle_arcs_test
