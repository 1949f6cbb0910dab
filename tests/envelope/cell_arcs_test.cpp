// Arcs of the chart: nearly straight, nearly closed, with end points that doubles hardly tell apart.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "../../envelope/diagram/chart_arc.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "test_support.hpp"

namespace vcell::cell_arcs_test {
using Eigen::Vector2d;
using std::numbers::pi;

namespace {

PlaneBaseProblem problem_of(std::vector<Object> objects) {
    Scene scene;
    scene.objects = std::move(objects);
    scene.box = {{-10, -10, 0}, {10, 10, 100}};
    return plane_base_problem(scene);
}

// A diagram of vertices and edges only: all that arcs ask for. Labels: `third` joins at every vertex.
struct EdgesOnly {
    MinimizationDiagram diagram;

    explicit EdgesOnly(const PlaneBaseProblem& problem) {
        diagram.forms = problem.family.forms;
        diagram.vertex_offsets_ = diagram.edge_offsets_ = diagram.side_offsets_ = {0};
    }
    VertexId add_vertex(double x, double y, double error, std::vector<FormId> label) {
        diagram.dcel.add_vertex();
        diagram.vertex_labels_.insert(diagram.vertex_labels_.end(), label.begin(), label.end());
        diagram.vertex_offsets_.push_back(static_cast<std::uint32_t>(diagram.vertex_labels_.size()));
        diagram.side_offsets_.push_back(0);
        return diagram.vertices.push_back({{x, y}, error, 0, 0});
    }
    void add_edge(VertexId from, VertexId to, FormId left, FormId right) {
        diagram.dcel.add_edge(from, to);
        diagram.edges.push_back({left, right});
        diagram.edge_labels_.push_back(std::min(left, right));
        diagram.edge_labels_.push_back(std::max(left, right));
        diagram.edge_offsets_.push_back(static_cast<std::uint32_t>(diagram.edge_labels_.size()));
    }
};

double turn_of(std::span<const ArcSpan> spans) {
    double turn = 0;
    for (const ArcSpan& span : spans) turn += 2 * span.half_angle;
    return turn;
}

// Bezier evaluation, independent of half_way().
Vector2d point_at(const ArcSpan& span, double t) {
    const double a = (1 - t) * (1 - t), b = 2 * t * (1 - t) * span.weight(), c = t * t;
    return (a * span.from + b * span.middle() + c * span.to) / (a + b + c);
}

}  // namespace

TEST_CASE("arcs: stay on the curve from tight circles to all but straight lines") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 2000; ++round) {
        // Equal widths but for a difference that shrinks to an ulp: radii up to 1e16.
        const double difference = std::ldexp(unit(rng), -static_cast<int>(rng() % 53));
        const double r = 0.3, z = 2 + 0.5 * unit(rng), shift = 0.1 * unit(rng);
        const PlaneBaseProblem problem = problem_of(
            {Sphere{{-1, unit(rng), z}, r}, Sphere{{1, unit(rng), z + shift}, r - shift + difference}});
        const CircularForm &f = problem.family.forms[FormId{0}], &g = problem.family.forms[FormId{1}];
        // The curve crosses y = const once between the centres, found by bisection in long double.
        const auto difference_at = [&](long double x, long double y) {
            const auto value = [&](const CircularForm& h) {
                return ((x - h.cx) * (x - h.cx) + (y - h.cy) * (y - h.cy) + h.e) / h.w;
            };
            return value(f) - value(g);
        };
        const auto solve = [&](double y) -> std::optional<double> {
            long double lo = -3, hi = 3;
            if (!(difference_at(lo, y) < 0 && difference_at(hi, y) > 0)) return std::nullopt;
            for (int i = 0; i < 80; ++i) {
                const long double mid = (lo + hi) / 2;
                (difference_at(mid, y) < 0 ? lo : hi) = mid;
            }
            return static_cast<double>(lo);
        };
        const double y0 = -0.5 + 0.3 * unit(rng), y1 = y0 + std::ldexp(1.0, -static_cast<int>(rng() % 30));
        const auto x0 = solve(y0), x1 = solve(y1);
        if (!x0 || !x1) continue;
        EdgesOnly arcs(problem);
        const VertexId p = arcs.add_vertex(*x0, y0, 1e-15, {}), q = arcs.add_vertex(*x1, y1, 1e-15, {});
        arcs.add_edge(p, q, FormId{0}, FormId{1});
        arcs.add_edge(q, p, FormId{1}, FormId{0});
        const ChartArcs chart(problem.family, arcs.diagram);
        CAPTURE(difference);
        CAPTURE(round);
        for (const EdgeId e : {EdgeId{0}, EdgeId{1}}) {
            const auto spans = chart.spans(e);
            CHECK(spans.front().from == arcs.diagram.vertices[e.value == 0 ? p : q].point);
            CHECK(spans.back().to == arcs.diagram.vertices[e.value == 0 ? q : p].point);
            CHECK(std::abs(turn_of(spans)) < pi);
            for (const ArcSpan& span : spans) {
                for (const double t : {0.2, 0.5, 0.7}) {
                    const Vector2d m = point_at(span, t);
                    const double slope =
                        (difference_at(m.x() + 1e-6, m.y()) - difference_at(m.x() - 1e-6, m.y())) / 2e-6;
                    CHECK(std::abs(difference_at(m.x(), m.y())) <= std::abs(slope) * chart.error(e));
                }
            }
            CHECK(chart.error(e) < 2e-14);
        }
        CHECK(turn_of(chart.spans(EdgeId{0})) == doctest::Approx(-turn_of(chart.spans(EdgeId{1}))));
    }
}

TEST_CASE("arcs: the two parts of a circle that a side all but touches are told apart exactly") {
    // Two spheres over (0, -1) whose heights agree on the unit circle about it, the first being lower inside.
    // A side at y = -2^-bits cuts off its top: down to a chord that doubles cannot resolve.
    const PlaneBaseProblem problem = problem_of({Sphere{{0, -1, 2}, 0}, Sphere{{0, -1, 3.125}, 0.875}});
    const FormId inner{0}, outer{1};
    for (int bits = 1; bits <= 130; ++bits) {
        const double depth = std::ldexp(1.0, -bits), x = std::sqrt(depth * (2 - depth));
        for (const bool major : {true, false}) {
            for (const bool counter_clockwise : {true, false}) {
                EdgesOnly arcs(problem);
                MinimizationDiagram& d = arcs.diagram;
                d.region.sides = {major ? ConvexRegion::Side{0, -1, -depth}
                                        : ConvexRegion::Side{0, 1, depth}};
                const VertexId left = arcs.add_vertex(-x, -depth, 1e-15, {inner, outer});
                const VertexId right = arcs.add_vertex(x, -depth, 1e-15, {inner, outer});
                d.vertex_sides_ = {0, 0};
                d.side_offsets_ = {0, 1, 2};
                const bool from_left = major == counter_clockwise;
                arcs.add_edge(from_left ? left : right, from_left ? right : left,
                              counter_clockwise ? inner : outer, counter_clockwise ? outer : inner);
                const ChartArcs chart(problem.family, d);
                const double minor_turn = 2 * std::asin(x);
                const double expected =
                    (counter_clockwise ? 1 : -1) * (major ? 2 * pi - minor_turn : minor_turn);
                CAPTURE(bits);
                CAPTURE(major);
                CAPTURE(counter_clockwise);
                CHECK(std::abs(turn_of(chart.spans(EdgeId{0})) - expected) < 1e-6);
                // Only chords near the size of the vertices' errors needed the exact rung.
                CHECK((chart.decisions().total() > 1) == (2 * x < 2e-14));
            }
        }
    }
}

}  // namespace vcell::cell_arcs_test
