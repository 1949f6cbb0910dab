#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "check_arrangement.hpp"
#include "test_support.hpp"
#include "vcell/arrangement/curves/curve_arcs.hpp"
#include "vcell/arrangement/sweep/overlay.hpp"

using namespace vcell;
using Arc = CurveArcs::Arc;

namespace {

using Function = std::shared_ptr<const DefiningFunction>;

double value(const Function& g, const Eigen::Vector2d& p) {
    return g->value(Interval(p.x()), Interval(p.y())).mid();
}
Eigen::Vector2d gradient(const Function& g, const Eigen::Vector2d& p) {
    const auto d = g->jet(Interval(p.x()), Interval(p.y())).gradient;
    return {d[0].mid(), d[1].mid()};
}
/// Newton's method along the gradient.
Eigen::Vector2d onto_curve(const Function& g, Eigen::Vector2d p) {
    for (int i = 0; i < 20; ++i) {
        const Eigen::Vector2d d = gradient(g, p), step = value(g, p) / d.squaredNorm() * d;
        p -= step;
        if (step.norm() < 1e-15) break;
    }
    return p;
}

/// A square about the origin.
bool inside(const Eigen::Vector2d& p, double half_width) { return p.cwiseAbs().maxCoeff() <= half_width; }

/// Polygons along the components of {g = 0} in a square, with vertices every `step`: the spline of degree 1
/// is within 1.5 times the largest of the arcs' heights over their chords.
std::vector<TracedCurve> trace(const Function& g, double half_width, double step) {
    std::vector<std::vector<Eigen::Vector2d>> found;
    const auto known = [&](const Eigen::Vector2d& p) {
        for (const auto& curve : found) {
            for (const auto& q : curve) {
                if ((p - q).norm() < step) return true;
            }
        }
        return false;
    };
    const auto follow = [&](const Eigen::Vector2d& seed, double direction) {
        std::vector<Eigen::Vector2d> points{seed};
        for (int i = 0; i < 10'000; ++i) {
            const Eigen::Vector2d d = gradient(g, points.back()).normalized();
            const Eigen::Vector2d next =
                onto_curve(g, points.back() + direction * step * Eigen::Vector2d(-d.y(), d.x()));
            if (!inside(next, half_width)) break;
            if (i > 2 && (next - seed).norm() < 0.9 * step) {
                points.push_back(seed);
                break;
            }
            points.push_back(next);
        }
        return points;
    };
    constexpr int grid = 40;
    for (int i = 0; i < grid; ++i) {
        for (int j = 0; j < grid; ++j) {
            const Eigen::Vector2d p(half_width * ((2 * i + 1.0) / grid - 1),
                                    half_width * ((2 * j + 1.0) / grid - 1));
            if (gradient(g, p).norm() * 4 * half_width / grid < std::abs(value(g, p))) continue;
            const Eigen::Vector2d seed = onto_curve(g, p);
            if (!inside(seed, half_width - step) || std::abs(value(g, seed)) > 1e-9 || known(seed)) continue;
            auto curve = follow(seed, 1);
            if (curve.back() != seed) {
                std::reverse(curve.begin(), curve.end());
                const auto rest = follow(seed, -1);
                curve.insert(curve.end(), rest.begin() + 1, rest.end());
            }
            if (curve.size() > 3) found.push_back(curve);
        }
    }
    std::vector<TracedCurve> result;
    for (const auto& points : found) {
        TracedCurve curve{{.degree = 1, .knots = {0}, .points = {}}, 1e-12, g};
        for (std::size_t i = 0; i < points.size(); ++i) {
            curve.spline.points.push_back({points[i].x(), points[i].y(), 1});
            curve.spline.knots.push_back(static_cast<double>(i));
            if (i == 0) continue;
            const Eigen::Vector2d middle = 0.5 * (points[i - 1] + points[i]);
            curve.band = std::max(curve.band, 1.5 * (onto_curve(g, middle) - middle).norm());
        }
        curve.spline.knots.push_back(curve.spline.knots.back());
        result.push_back(curve);
    }
    return result;
}

/// The curve with every control point moved by up to `by`, and the band widened as much.
TracedCurve blurred(TracedCurve curve, double by, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi), length(0.5 * by, by);
    for (auto& p : curve.spline.points) {
        const double a = angle(rng), r = length(rng);
        p[0] += r * std::cos(a);
        p[1] += r * std::sin(a);
    }
    // A closed spline stays closed.
    curve.spline.points.back() = curve.spline.points.front();
    curve.band += by;
    return curve;
}

/// u^4 + u^2 + v^4 + v^2 = 2 with u = (x - cx) / a, v = (y - cy) / b: a quartic oval with half axes a and b.
Function oval(double cx, double cy, double a, double b) {
    return defining_function([=]<class T>(const T& x, const T& y) -> T {
        const T u = square((x - T(cx)) / T(a)), v = square((y - T(cy)) / T(b));
        return square(u) + u + square(v) + v - T(2.0);
    });
}

/// sqrt(k (x - a)^2 + l (y - b)^2 + m) + n, like the heights over a plane.
struct Height {
    double a, b, k, l, m, n;
    template <class T>
    T operator()(const T& x, const T& y) const {
        return sqrt(T(k) * square(x - T(a)) + T(l) * square(y - T(b)) + T(m)) + T(n);
    }
};
Function difference(const Height& f, const Height& g) {
    return defining_function([=]<class T>(const T& x, const T& y) -> T { return f(x, y) - g(x, y); });
}

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

TEST_CASE("mixed arcs: a circle, a line, a Bezier curve and a quartic oval") {
    CurveArcs g;
    const auto circle = g.add_circle(0, 0, 1);
    const auto line = g.add_line(1, -1, 0);
    const auto bezier = g.add_bezier({{-2, 0.6, 1}, {0.1, -1, 1.5}, {2.2, 0.5, 1}});
    const auto traced = trace(oval(0.1, 0.05, 1.5, 0.5), 3, 0.05);
    REQUIRE(traced.size() == 1);
    const auto quartic = g.add_traced(traced[0]);
    auto arcs = all_arcs(g, {circle, bezier, quartic});
    CHECK(arcs.size() == 5);
    arcs.push_back(g.segment(line, g.point(-3, -3), g.point(3, 3)));
    // Ends: 2 each. Crossings: line-circle 2, line-oval 2, line-Bezier 1, circle-oval 4, circle-Bezier 2,
    // Bezier-oval 2.
    check_counts(g, arcs, 8 + 13, 6 + 2 * 13, 13);
    CHECK(g.decisions().assumed == 0);
    CHECK(g.decisions().by_double > 0);
    CHECK(g.decisions().by_interval > 0);
}

TEST_CASE("mixed arcs: with a band too wide for the spline to tell, the defining function decides") {
    std::mt19937_64 rng(test_seed());
    const auto traced = trace(oval(0, 0, 1, 1), 2, 0.02);
    REQUIRE(traced.size() == 1);
    for (int round = 0; round < 3; ++round) {
        const TracedCurve coarse = blurred(traced[0], 0.02, rng);
        // The oval's radius is between 1 and 1.1118; nothing is symmetric.
        for (const double radius : {0.99, 1.1, 1.12}) {
            CAPTURE(radius);
            CurveArcs g;
            const auto arcs =
                all_arcs(g, {g.add_circle(0.002, 0.001, radius * radius), g.add_traced(coarse)});
            CHECK(arcs.size() == 4);
            std::size_t crossings = 0, last = 2;
            for (const auto& p : coarse.spline.points) {
                const std::size_t outside = (p.head<2>() - Eigen::Vector2d(0.002, 0.001)).norm() > radius;
                crossings += last != 2 && last != outside;
                last = outside;
            }
            const std::size_t expected = radius == 1.1 ? 8 : 0;
            CHECK(crossings > expected);  // that is what the spline says
            check_counts(g, arcs, 4 + expected, 4 + 2 * expected, expected == 0 ? 3 : 2 + expected);
            CHECK(g.decisions().assumed == 0);
        }
    }
}

TEST_CASE("mixed arcs: cutting finds every turn of a traced curve, with proof") {
    const double turn = 0.7, cos = std::cos(turn), sin = std::sin(turn);
    const auto ellipse = defining_function([=]<class T>(const T& x, const T& y) -> T {
        return square((T(cos) * x + T(sin) * y) / T(1.5)) + square((T(cos) * y - T(sin) * x) / T(0.25)) -
               T(1.0);
    });
    const double width = std::hypot(1.5 * cos, 0.25 * sin) / (cos * cos + sin * sin);
    for (const TracedCurve& curve : trace(ellipse, 2, 0.005)) {
        CurveArcs g;
        const auto arcs = all_arcs(g, {g.add_traced(curve)});
        REQUIRE(arcs.size() == 2);
        CHECK(arcs[0].left == arcs[1].left);
        CHECK(arcs[0].right == arcs[1].right);
        CHECK(g.box(arcs[0].right)[0].mid() == doctest::Approx(width).epsilon(1e-14));
        CHECK(g.box(arcs[0].left)[0].mid() == doctest::Approx(-width).epsilon(1e-14));
        CHECK(g.box(arcs[0].left)[0].radius() < 1e-14);
        CHECK(g.fine_box(arcs[0].left).first.radius_exponent() < -280);
        check_counts(g, arcs, 2, 2, 2);
    }

    const auto star = defining_function([]<class T>(const T& x, const T& y) -> T {
        const T u = square(x), v = square(y);
        return u + v - T(1.0) + T(0.14) * x * (square(u) - T(10.0) * u * v + T(5.0) * square(v));
    });
    const auto curves = trace(star, 1.15, 0.002);
    REQUIRE(curves.size() == 1);
    const auto& points = curves[0].spline.points;
    std::size_t turns = 0;
    const std::size_t n = points.size() - 1;
    for (std::size_t i = 0; i < n; ++i) {
        const double before = points[(i + 1) % n].x() - points[i].x();
        turns += before * (points[(i + 2) % n].x() - points[(i + 1) % n].x()) < 0;
    }
    CHECK(turns > 2);
    CurveArcs g;
    const auto arcs = all_arcs(g, {g.add_traced(curves[0])});
    CHECK(arcs.size() == turns);
    check_counts(g, arcs, turns, turns, 2);
    // Turns that mirror each other in the x axis have equal x, and nothing proves it.
    for (const auto& p : g.assumed_at()) CHECK(std::abs(p.y()) > 0.1);
}

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

TEST_CASE("mixed arcs: an oval that touches a circle at its turns and at its top") {
    const auto traced = trace(oval(0, 0, 1, 1), 2, 0.05);
    REQUIRE(traced.size() == 1);
    CurveArcs g;
    auto arcs = all_arcs(g, {g.add_circle(0, 0, 1), g.add_traced(traced[0])});
    check_counts(g, arcs, 4, 8, 6);
    CHECK(g.decisions().assumed >= 4);
    for (const auto& p : g.assumed_at()) CHECK(std::abs(p.norm() - 1) < 1e-12);
    // A vertical tangent, and a vertical line through the touching points.
    arcs.push_back(g.segment(g.add_line(1, 0, -1), g.point(1, -1), g.point(1, 1)));
    arcs.push_back(g.segment(g.add_line(1, 0, 0), g.point(0, -2), g.point(0, 2)));
    check_counts(g, arcs, 8, 8 + 2 + 3, 7);
}

TEST_CASE("mixed arcs: coinciding curves of different kinds become one") {
    const auto unit = defining_function(
        []<class T>(const T& x, const T& y) -> T { return square(x) + square(y) - T(1.0); });
    const auto traced = trace(unit, 2, 0.05);
    REQUIRE(traced.size() == 1);
    CurveArcs g;
    auto arcs = all_arcs(g, {g.add_circle(0, 0, 1), g.add_traced(traced[0])});
    CHECK(arcs.size() == 4);
    check_counts(g, arcs, 2, 2, 2);
    CHECK(g.decisions().assumed > 0);
    // A cubic that is a segment, on a line.
    arcs = all_arcs(g, {g.add_bezier({{-1, -2, 1}, {0, -1, 1}, {1, 0, 1}, {2, 1, 1}})});
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

TEST_CASE("mixed arcs: the three curves of a triple meet in one point") {
    const std::array heights{Height{0, 0, 1, 0.5, 0.3, 0}, Height{1, 0.2, 0.8, 1.1, 0.2, 0.05},
                             Height{0.3, 1, 0.6, 1.3, 0.4, -0.1}};
    std::array<std::size_t, 3> counts{};
    for (const bool labelled : {true, false}) {
        CurveArcs g;
        std::vector<CurveId> curves;
        for (const auto& [i, j] : {std::pair(0u, 1u), {0u, 2u}, {1u, 2u}}) {
            for (const TracedCurve& c : trace(difference(heights[i], heights[j]), 3, 0.03)) {
                curves.push_back(
                    g.add_traced(c, labelled ? std::optional(CurveArcs::Label{i, j}) : std::nullopt));
            }
        }
        const auto a = arrange<CurveArcs>(g, all_arcs(g, curves));
        CHECK(arrangement_defect(g, a) == "");
        std::size_t triple_points = 0;
        for (std::uint32_t v = 0; v < a.dcel.vertex_count(); ++v) {
            const HalfEdgeId first = a.dcel.outgoing(VertexId{v});
            int degree = 0;
            HalfEdgeId h = first;
            do {
                ++degree;
                h = a.dcel.next_around_origin(h);
            } while (h != first);
            triple_points += degree == 6;
            CHECK((degree == 6 || degree <= 2));  // the curves cross nowhere else
        }
        CHECK(triple_points > 0);
        CHECK((g.decisions().assumed == 0) == labelled);
        const std::array now{a.dcel.vertex_count(), a.dcel.edge_count(), a.dcel.face_count()};
        if (labelled) counts = now;
        CHECK(now == counts);
    }
}

namespace {

/// A mix of curves in general position, moved by (dx, dy).
struct RandomMix {
    std::vector<std::array<double, 3>> circles;  // squared radius last
    std::vector<std::array<double, 4>> segments, ovals;
    std::vector<std::vector<Eigen::Vector3d>> beziers;

    explicit RandomMix(std::mt19937_64& rng) {
        // Multiples of 1/1024: sums and the coefficients of lines are exact.
        const auto number = [&](double lo, double hi) {
            return std::floor(1024 * std::uniform_real_distribution(lo, hi)(rng)) / 1024;
        };
        for (int i = 0; i < 3; ++i) circles.push_back({number(-1, 1), number(-1, 1), number(0.1, 1)});
        for (int i = 0; i < 2; ++i)
            segments.push_back({number(-2, -1), number(-1, 1), number(1, 2), number(-1, 1)});
        segments.push_back({segments[0][0], -1.5, segments[0][0], 1.5});
        for (int i = 0; i < 2; ++i)
            ovals.push_back({number(-1, 1), number(-1, 1), number(0.4, 1), number(0.4, 1)});
        for (int i = 0; i < 2; ++i) {
            std::vector<Eigen::Vector3d> points;
            for (int k = 0; k < 4 + i; ++k) points.push_back({number(-2, 2), number(-2, 2), number(0.5, 2)});
            beziers.push_back(points);
        }
    }
    std::vector<Arc> arcs(CurveArcs& g, double dx = 0, double dy = 0) const {
        std::vector<CurveId> curves;
        for (const auto& [x, y, r] : circles) curves.push_back(g.add_circle(x + dx, y + dy, r));
        for (const auto& [x, y, a, b] : ovals) {
            TracedCurve curve = trace(oval(x, y, a, b), 4, 0.03).at(0);
            for (auto& p : curve.spline.points) p += Eigen::Vector3d(dx, dy, 0);
            curve.g = oval(x + dx, y + dy, a, b);
            curve.band += 1e-15 * (std::abs(dx) + std::abs(dy));
            curves.push_back(g.add_traced(curve));
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

TEST_CASE("mixed arcs: faces are where the signs of the defining functions say") {
    std::mt19937_64 rng(test_seed() + 1);
    std::uniform_real_distribution<double> place(-1.5, 1.5), factor(0.4, 1.6), offset(-0.3, 0.3);
    for (int round = 0; round < 2; ++round) {
        CAPTURE(round);
        std::vector<Height> heights;
        for (int i = 0; i < 4; ++i)
            heights.push_back(
                {place(rng), place(rng), factor(rng), factor(rng), factor(rng) / 4, offset(rng)});
        CurveArcs g;
        std::vector<Function> functions;
        std::vector<CurveId> curves;
        for (std::uint32_t i = 0; i < heights.size(); ++i) {
            for (std::uint32_t j = 0; j < i; ++j) {
                functions.push_back(difference(heights[i], heights[j]));
                for (const TracedCurve& c : trace(functions.back(), 2.5, 0.02))
                    curves.push_back(g.add_traced(c, CurveArcs::Label{i, j}));
            }
        }
        curves.push_back(g.add_circle(0.25, 0, 1));
        functions.push_back(defining_function(
            []<class T>(const T& x, const T& y) -> T { return square(x - T(0.25)) + square(y) - T(1.0); }));
        auto arcs = all_arcs(g, curves);
        // Curves may end outside the square only.
        for (const double s : {-2.0, 2.0}) {
            arcs.push_back(g.segment(g.add_line(1, 0, -s), g.point(s, -2), g.point(s, 2)));
            arcs.push_back(g.segment(g.add_line(0, 1, -s), g.point(-2, s), g.point(2, s)));
        }
        const auto a = arrange<CurveArcs>(g, arcs);
        REQUIRE(arrangement_defect(g, a) == "");
        CHECK(g.decisions().assumed == 0);

        const PointLocator<CurveArcs> locator(g, a);
        std::map<std::uint32_t, std::vector<Sign>> signs_of_face;
        constexpr int grid = 40;
        for (int i = 1; i < grid; ++i) {
            for (int j = 1; j < grid; ++j) {
                const double x = 4.0 * i / grid - 2, y = 4.0 * j / grid - 2;
                const Feature found = locator.locate(g.point(x, y));
                REQUIRE(std::holds_alternative<FaceId>(found));
                std::vector<Sign> signs;
                for (const Function& f : functions)
                    signs.push_back(f->value(Wide(x), Wide(y)).sign().value());
                const auto [at, is_new] = signs_of_face.try_emplace(std::get<FaceId>(found).value, signs);
                CHECK(at->second == signs);
            }
        }
        std::vector<CurveArcs::Point> some;
        for (int i = 0; i < 60; ++i) some.push_back(g.point(place(rng), place(rng)));
        check_location(g, a, some);
        CHECK(signs_of_face.size() > 8);
    }
}
