// Splines in space against arcs traced by bisection in the chart and points polished in 200 bits.
#include "../../envelope/lift/space_spline.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "../../core/curves/quintic_nodes.hpp"
#include "../../core/curves/scaled_bernstein.hpp"
#include "../../envelope/lift/cylinder_patch.hpp"
#include "test_support.hpp"
#include "traced_arcs.hpp"

namespace vcell::space_spline_test {
using namespace vcell::traced_arcs;

TEST_CASE("space splines: lie within the stated bound of the true arc, whole, over every base") {
    std::mt19937_64 rng(test_seed());
    int arcs = 0, trimmed = 0;
    double sharpest = 0;  // of bounds: true distance over bound
    for (int round = 0; round < long_rounds(3); ++round) {
        const double unit = std::array{1.0, 1e-6, 1e6}[round % 3];
        for (const Base base : {Base::Sphere, Base::Cylinder, Base::Plane}) {
            for (const Kind left : kinds) {
                for (const Kind right : kinds) {
                    if (base != Base::Cylinder && left != Kind::Cylinder && right != Kind::Cylinder) continue;
                    Case c = random_case(base, left, right, unit, rng);
                    auto traced = trace(c, unit, rng);
                    if (!traced) continue;
                    make_arc(*traced, c, unit);
                    for (const double relative : {1e-4, 1e-7}) {
                        if (rounds() == 1 && (arcs % 2 == 0) != (relative == 1e-4)) continue;
                        const double tolerance = relative * 10 * unit;
                        CAPTURE(round);
                        CAPTURE(static_cast<int>(base));
                        CAPTURE(static_cast<int>(left));
                        CAPTURE(static_cast<int>(right));
                        CAPTURE(relative);
                        std::vector<SpaceSpan> spans;
                        const SpaceFitError error = fitted(c, traced->arc, tolerance, spans);
                        CHECK(error.curve <= tolerance);
                        CHECK(error.trims <= tolerance);
                        const SpaceFitError truth = measured(c, spans);
                        CHECK(truth.curve <= error.curve);
                        CHECK(truth.trims <= error.trims);
                        sharpest = std::max(sharpest, truth.curve / error.curve);
                        CHECK(gap_between(c, *traced, unit, spans) <= 0.25);
                    }
                    ++arcs;
                    trimmed += !c.sites[0].parts.empty();
                }
            }
        }
    }
    CHECK(sharpest > 0.3);
    CHECK(arcs > 8 * long_rounds(3));
    CHECK(trimmed > 4 * long_rounds(3));
}

TEST_CASE("space splines: between tubes that are all but alike few spans do, over every base") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    int arcs = 0;
    for (int round = 0; round < 6 * rounds(); ++round)
        for (const Base base : {Base::Sphere, Base::Cylinder, Base::Plane}) {
            Case c = random_case(base, Kind::Cylinder, Kind::Cylinder, 1, rng);
            const double apart = round % 2 == 0 ? 1e-3 : 1e-6;
            const auto moved = [&](const Vec3& v) -> Vec3 {
                return v + apart * Vec3(normal(rng), normal(rng), normal(rng));
            };
            const Cylinder& tube = std::get<Cylinder>(c.sites[0].object);
            c.sites[1] = {
                Cylinder{moved(tube.point), moved(tube.axis), tube.radius + apart * normal(rng)}, false, {}};
            if (!(std::get<Cylinder>(c.sites[1].object).radius > 0)) continue;
            auto traced = trace(c, 1, rng);
            if (!traced) continue;
            make_arc(*traced, c, 1);
            CAPTURE(round);
            CAPTURE(static_cast<int>(base));
            std::vector<SpaceSpan> spans;
            constexpr double tolerance = 1e-6;
            const SpaceFitError error = fitted(c, traced->arc, tolerance, spans);
            if (apart == 1e-3) CHECK(error.curve <= tolerance);  // else rounding may be more
            CHECK(spans.size() <= 100);
            if (spans.size() > 100) continue;
            const SpaceFitError truth = measured(c, spans);
            CHECK(truth.curve <= error.curve);
            CHECK(truth.trims <= error.trims);
            CHECK(gap_between(c, *traced, 1, spans) <= 0.25);
            ++arcs;
        }
    CHECK(arcs > 6 * rounds());
}

namespace {

// A ball between a base cylinder and a parallel one: its face is bounded by one closed edge.
struct Island {
    Case c;
    Traced traced;

    explicit Island(std::mt19937_64& rng) {
        c.chart = {BaseShape::Cylinder, 0.5};
        c.sites = {SpaceSite{Sphere{{0, 0, 2}, 0.3}, false, {}},
                   SpaceSite{Cylinder{{0, 0, 3}, Vec3::UnitY(), 0.5}, false, {}}};
        for (int i = 0; i < 100 && !traced.closed; ++i)
            if (const auto found = trace(c, 1, rng)) traced = *found;
        REQUIRE(traced.closed);
        make_arc(traced, c, 1);
        for (int side = 0; side < 2; ++side) c.sites[side].parts = {{coordinates(c, side, Vec3::UnitZ())}};
        traced.arc.sites = c.sites;
    }
    SpaceEnd end_of(std::size_t piece) const {
        const Vec2& q = traced.pieces[piece].end;
        Eigen::Vector4d X;
        const double t = height(c, 0, q, 1);
        X << foot_of(c, q) + t * normal_of(c, q), t;
        const Vec3 tangent = normal_of(c, q).cross(Vec3(0.3, 0.5, 0.7));
        Eigen::Vector4d slice;
        slice << tangent.normalized(), 0;
        const Vec3 p = polished(c, X, slice).head<3>().cast<double>();
        return {p, 1e-15};
    }
};

using traced_arcs::fitted;

// With effort that is enough for the edge itself.
SpaceFitError fitted(const Case& c, const SpaceArc& arc, double tolerance) {
    std::vector<SpaceSpan> spans;
    return fitted(c.chart, arc, tolerance, spans, {.spans = 200, .cells = 20'000});
}

}  // namespace

TEST_CASE("space splines: an arc that is not the edge is not proved") {
    std::mt19937_64 rng(test_seed());
    constexpr double tolerance = 1e-5;
    Island island(rng);
    SpaceArc arc = island.traced.arc;
    CHECK(fitted(island.c, arc, tolerance).curve <= tolerance);

    SUBCASE("sides exchanged") {
        std::swap(arc.sites[0], arc.sites[1]);
        CHECK(fitted(island.c, arc, tolerance).curve > tolerance);
    }
    SUBCASE("ends exchanged, away from the arc, or passed once before") {
        const std::size_t last = arc.pieces.size() / 3;
        auto pieces = island.traced.pieces;
        arc.start = island.end_of(pieces.size() - 1);
        arc.end = island.end_of(last);
        arc.pieces = std::span(pieces).first(last + 1);
        CHECK(fitted(island.c, arc, tolerance).curve <= tolerance);

        SpaceArc exchanged = arc;
        std::swap(exchanged.start, exchanged.end);
        CHECK(fitted(island.c, exchanged, tolerance).curve > tolerance);

        SpaceArc away = arc;
        away.end->point += 1e-3 * Vec3(1, -1, 1);
        CHECK(fitted(island.c, away, tolerance).curve > tolerance);

        auto twice = pieces;
        twice.insert(twice.end(), pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(last) + 1);
        SpaceArc passed = arc;
        passed.pieces = twice;
        CHECK(fitted(island.c, passed, tolerance).curve > tolerance);
    }
}

TEST_CASE("space splines: the comparison with the true arc sees a span that is off") {
    std::mt19937_64 rng(test_seed());
    const Island island(rng);
    std::vector<SpaceSpan> spans;
    const SpaceFitError error = fitted(island.c.chart, island.traced.arc, 1e-5, spans);
    for (const int row : {0, 1, 2, 3, 4, 7}) {
        std::vector<SpaceSpan> off = spans;
        off[off.size() / 2].points(row, 3) += 20 * std::max(error.curve, error.trims);
        const SpaceFitError truth = measured(island.c, off);
        CAPTURE(row);
        CHECK((truth.curve > error.curve || truth.trims > error.trims));
    }
}

TEST_CASE("space splines: rims, open and closed, and faces in several parts") {
    Case c;
    c.chart = {BaseShape::Cylinder, 0.5};
    constexpr double tolerance = 1e-6;
    // On the axis beyond the end: seen all around.
    const Sphere ball{{0.1, 3, 0.2}, 2};
    for (const double end : {1.0, -1.0}) {
        const double y = 0.6;
        const Sphere mirrored{{ball.center.x(), end * ball.center.y(), ball.center.z()}, ball.radius};
        c.sites = {SpaceSite{mirrored, false, {}}, SpaceSite{Plane{{0, end * y, 0}, {0, end, 0}}, true, {}}};
        for (const double angle : {0.3, 2.4, 4.5}) {
            const Vec3 zero(std::sin(angle), 0, std::cos(angle));
            const auto across = PatchCoordinate::half_angle(Vec3::Zero(), zero, Vec3::UnitY().cross(zero), 0);
            c.sites[0].parts.push_back({{across, PatchCoordinate::linear(Vec3::UnitY(), Vec3::Zero())},
                                        across,
                                        {-std::tan(0.525), std::tan(0.525)}});
        }
        SpaceArc arc;
        arc.sites = c.sites;
        std::vector<SpaceSpan> spans;
        const SpaceFitError error = fitted(c.chart, arc, tolerance, spans);
        CHECK(error.curve <= tolerance);
        CHECK(error.trims <= tolerance);
        const SpaceFitError truth = measured(c, spans);
        CHECK(truth.curve <= error.curve);
        CHECK(truth.trims <= error.trims);
        // The region on the left: with growing angle at the lower end.
        const auto angle_of = [](const Eigen::Vector4d& X) { return std::atan2(X[0], X[2]); };
        double turn = 0;
        std::array<bool, 3> used{};
        for (const SpaceSpan& span : spans) {
            turn += std::remainder(angle_of(at(span, 1)) - angle_of(at(span, 0)), 2 * pi);
            CHECK(span.points.row(4).cwiseAbs().maxCoeff() <= std::tan(0.525) + 1e-12);
            used[span.part[0]] = true;
        }
        CHECK(turn == doctest::Approx(-end * 2 * pi));
        CHECK((used[0] && used[1] && used[2]));

        // A third of it, ends given.
        std::vector<SpaceSpan> third;
        arc.start = SpaceEnd{spans.front().points.col(0).head<3>(), 1e-15};
        arc.end = SpaceEnd{spans[spans.size() / 3].points.col(5).head<3>(), 1e-15};
        CHECK(fitted(c.chart, arc, tolerance, third).curve <= tolerance);
        CHECK(third.back().points.col(5).head<3>() == arc.end->point);
        CHECK(third.size() < spans.size());
        // Ends known worse than the tolerance: no reason to halve.
        arc.start->error = arc.end->error = 100 * tolerance;
        std::vector<SpaceSpan> rough;
        CHECK(fitted(c.chart, arc, tolerance, rough).curve <= 600 * tolerance);
        CHECK(rough.size() <= third.size());
    }
}

TEST_CASE("space splines: an arc that ends where its sites touch") {
    // Crossing cylinders of one radius: the trisector is two curves that cross at (0, 0, 1.5).
    Case c;
    c.chart = {BaseShape::Sphere, 0.5};
    c.sites = {SpaceSite{Cylinder{{0, 0, 3}, {0, 1, 0}, 0.5}, false, {}},
               SpaceSite{Cylinder{{0, 0, 3}, {1, 0, 0}, 0.5}, false, {}}};
    std::vector<MinimizationDiagram::ArcPiece> pieces;
    double before = 0;
    for (const double x : {1e-5, 0.05, 0.15, 0.25}) {
        pieces.push_back({{x, x}, 1e-16, Vec2(1, -1).normalized(), {before, x, before, x}});
        before = x;
    }
    const auto lifted = [&](double x) -> Vec3 { return height(c, 0, {x, x}, 1) * normal_of(c, {x, x}); };
    SpaceArc arc;
    arc.sites = c.sites;
    arc.pieces = pieces;
    arc.start = SpaceEnd{lifted(0), 1e-15};
    arc.end = SpaceEnd{lifted(0.25), 1e-15};
    const auto check = [&](const std::vector<SpaceSpan>& spans, const SpaceFitError& error,
                           double tolerance) {
        CHECK(error.curve <= tolerance);
        CHECK(at(spans.back(), 1).head<3>() == arc.end->point);
        for (const SpaceSpan& span : spans)
            for (const double s : {0.2, 0.5, 0.8}) {
                const Eigen::Vector4d X = at(span, s);
                CHECK(std::abs(X[0] - X[1]) <= error.curve);
                CHECK(std::abs(excess<double>(c, 0, X.head<3>())) <= 2 * error.curve);
            }
    };
    for (const double tolerance : {1e-3, 1e-4}) {
        std::vector<SpaceSpan> spans;
        const SpaceFitError error = fitted(c.chart, arc, tolerance, spans);
        check(spans, error, tolerance);
    }
    // In their plane the crossing is a point like any other.
    arc.sites_cross = true;
    const std::vector<MinimizationDiagram::ArcPiece> whole{
        {{0.25, 0.25}, 1e-16, pieces[0].direction, {0, 0.25, 0, 0.25}}};
    for (const auto& part : {pieces, whole})
        for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
            arc.pieces = part;
            std::vector<SpaceSpan> spans;
            const SpaceFitError error = fitted(c.chart, arc, tolerance, spans);
            check(spans, error, tolerance);
            CHECK(spans.size() <= 16);
        }
}

namespace {

// Fits all edges of a diagram that have pieces or lie on a rim; the number of them.
int fit_diagram(const RadialBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance) {
    int fitted_edges = 0;
    for (const EdgeId e : diagram.edges.ids()) {
        const MinimizationDiagram::Edge& edge = diagram.edges[e];
        const auto pieces = diagram.pieces(e);
        if (pieces.empty() && !edge.on_rim()) continue;
        Case c;
        c.chart = problem.chart;
        const auto site = [&](FormId f) -> SpaceSite {
            return {problem.objects[f], problem.sites[f].front().kind == Site::Kind::BoxSide, {}};
        };
        c.sites[0] = site(edge.left);
        if (edge.on_rim()) {
            const double sign = edge.side == 0 ? -1 : 1;
            c.sites[1] = {Plane{{0, problem.stretch[edge.side == 0 ? 0 : 1], 0}, {0, sign, 0}}, true, {}};
        } else {
            c.sites[1] = site(edge.right);
        }
        const auto end = [&](VertexId v) -> std::optional<SpaceEnd> {
            if (!v.valid()) return std::nullopt;
            const auto& vertex = diagram.vertices[v];
            const double t = problem.chart.distance_of(vertex.point, vertex.height);
            return SpaceEnd{problem.chart.point(vertex.point, t), 1e-10};
        };
        const HalfEdgeId h{2 * e.value};
        SpaceArc arc{c.sites, end(diagram.dcel.origin(h)), end(diagram.dcel.target(h)), pieces};
        std::vector<SpaceSpan> spans;
        const SpaceFitError error = fitted(problem.chart, arc, tolerance, spans);
        CAPTURE(e.value);
        CAPTURE(edge.on_rim());
        CHECK(error.curve <= tolerance);
        if (error.curve <= tolerance) CHECK(measured(c, spans).curve <= error.curve);
        ++fitted_edges;
    }
    return fitted_edges;
}

}  // namespace

TEST_CASE("space splines: all edges of cells of cylinders and spheres among skew cylinders") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> size(0.1, 0.5), gap(0.3, 1.5), along(-3, 3);
    for (const bool sphere_base : {true, false}) {
        Scene scene;
        scene.box = {{-6, -6, -6}, {6, 6, 6}};
        if (sphere_base)
            scene.base = Sphere{{0, 0, 0}, 0.5};
        else
            scene.base = Cylinder{{0, 0, 0}, {0, 1, 0}, 0.5};
        for (int i = 0; i < 10; ++i) {
            Vec3 out = random_unit(rng);
            if (!sphere_base) out = Vec3(out.x(), 0, out.z()).normalized();
            const double rho = size(rng);
            const Vec3 foot = (0.5 + rho + gap(rng)) * out + (sphere_base ? 0 : along(rng)) * Vec3::UnitY();
            if (i % 3 == 2)
                scene.objects.push_back(Sphere{foot, rho});
            else
                scene.objects.push_back(Cylinder{foot, random_unit(rng).cross(out), rho});
        }
        const RadialBaseProblem problem = radial_base_problem(scene);
        const MinimizationDiagram diagram =
            sphere_base ? lower_envelope_on_sphere(problem.family)
                        : lower_envelope_on_cylinder(problem.family, problem.stretch[0], problem.stretch[1]);
        for (const double tolerance : {1e-3, 1e-6}) CHECK(fit_diagram(problem, diagram, tolerance) > 10);
    }
}

TEST_CASE("patch coordinates: over a plane those of a cone and of a parabolic cylinder are its patch's") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> side(-1, 1), size(0.1, 1);
    for (int i = 0; i < 1000; ++i) {
        Vec3 a = random_unit(rng);
        a.z() *= i % 4 == 0 ? 0 : 0.4;
        const double rho = size(rng);
        const CylinderForm form{0, 0, 3 + rho, a.x(), a.y(), a.z(), rho};
        const Vec2 p0(0.2 * side(rng), 0.2 * side(rng));
        const CylinderFrame frame(form, p0);
        const PatchCoordinates coordinates = frame.coordinates();
        const Vec2 p = p0 + 0.2 * Vec2(side(rng), side(rng)), uv = frame.parameters(p);
        Eigen::Vector4d X;
        X << p, Vec2::Constant(frame.height()(p).value);
        CAPTURE(i);
        CHECK(std::abs(coordinates[0](X) - uv.x()) < 1e-11);
        CHECK(std::abs(coordinates[1](X) - uv.y()) < 1e-11);
    }
}

TEST_CASE("patch coordinates: tangents of half angles, and lengths") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> angle(-3, 3), size(0.1, 3);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 axis = random_unit(rng), zero = axis.unitOrthogonal(), quarter = axis.cross(zero);
        const Vec3 point = size(rng) * random_unit(rng);
        const double phi = angle(rng), distance = size(rng), t = size(rng), length = angle(rng);
        Eigen::Vector4d X;
        X << point + distance * (std::cos(phi) * zero + std::sin(phi) * quarter) + length * axis, t;
        const double tangent = std::tan(phi / 2);
        CHECK(PatchCoordinate::half_angle(point, zero, quarter, distance - t)(X) ==
              doctest::Approx(tangent).epsilon(1e-9));
        CHECK(PatchCoordinate::linear(axis, point)(X) == doctest::Approx(length).epsilon(1e-12));
    }
}

namespace {

template <int N>
Bernstein<N> random_polynomial(std::mt19937_64& rng, double size) {
    std::uniform_real_distribution<double> coefficient(-size, size);
    return Bernstein<N>::from([&](int) { return coefficient(rng); });
}

template <int N>
double largest_sample(const Bernstein<N>& p) {
    double most = 0;
    for (double s = 0; s <= 1; s += 0x1p-7) {
        double value = 0;
        for (int k = 0; k <= N; ++k) value += p.scaled[k] * std::pow(s, k) * std::pow(1 - s, N - k);
        most = std::max(most, std::abs(value));
    }
    return most;
}

}  // namespace

TEST_CASE("bernstein: squares are products, and coefficients bound a polynomial") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 200; ++round) {
        const auto p = random_polynomial<5>(rng, 1);
        const Bernstein<10> squared = square(p), product = p * p;
        for (int k = 0; k <= 10; ++k)
            CHECK(squared.coefficient(k) == doctest::Approx(product.coefficient(k)).epsilon(1e-14));
        CHECK(largest_sample(p) <= p.largest() + 1e-15);
    }
}

TEST_CASE("quintic nodes: polynomials are bounded, closely if they all but vanish there") {
    std::mt19937_64 rng(test_seed());
    const QuinticNodes& nodes = QuinticNodes::get();
    CHECK(largest_sample(nodes.sextic) == doctest::Approx(1).epsilon(1e-3));
    for (int round = 0; round < 200; ++round) {
        const Bernstein<4> steady = random_polynomial<4>(rng, 0.1) + 1;
        const Bernstein<10> vanishing = nodes.sextic * steady + random_polynomial<10>(rng, 1e-4);
        const double sampled = largest_sample(vanishing);
        CHECK(nodes.largest(vanishing) >= sampled);
        CHECK(nodes.largest(vanishing) <= 1.2 * sampled);
        const auto other = random_polynomial<10>(rng, 1);
        CHECK(nodes.largest(other) >= largest_sample(other));
    }
}

}  // namespace vcell::space_spline_test
