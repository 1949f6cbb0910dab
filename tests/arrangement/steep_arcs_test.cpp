#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "check_arrangement.hpp"
#include "test_support.hpp"
#include "vcell/arrangement/curves/curve_arcs.hpp"
#include "vcell/core/errors.hpp"

using namespace vcell;
using Arc = CurveArcs::Arc;

namespace {

using Function = std::shared_ptr<const DefiningFunction>;

Sign sign_at(const Function& g, double x, double y) {
    if (const auto s = g->value(Interval(x), Interval(y)).sign()) return *s;
    return g->value(Wide(x), Wide(y)).sign().value();
}

/// h(v) = c0 + c1 v + c2 v^2 + c3 v^3.
struct Cubic {
    std::array<double, 4> c{};
    template <class T>
    T operator()(const T& v) const {
        return T(c[0]) + v * (T(c[1]) + v * (T(c[2]) + v * T(c[3])));
    }
    Cubic derivative() const { return {{c[1], 2 * c[2], 3 * c[3], 0}}; }
};

/// The curve u = h(v) for v in [-reach, reach] where (u, v) is (x, y) turned by an angle.
struct TurnedCurve {
    Cubic h;
    double angle = 0, reach = 1.25;

    /// (u - h(v)) (x y + 5): what else is zero is far away.
    Function function() const {
        return defining_function(
            [h = h, c = std::cos(angle), s = std::sin(angle)]<class T>(const T& x, const T& y) -> T {
                return (T(c) * x + T(s) * y - h(T(c) * y - T(s) * x)) * (x * y + T(5.0));
            });
    }
    template <class T>
    std::pair<T, T> at(const T& v) const {
        const T c(std::cos(angle)), s(std::sin(angle)), u = h(v), norm = square(c) + square(s);
        return {(c * u - s * v) / norm, (s * u + c * v) / norm};
    }
    TracedCurve traced(double band = 1e-9) const {
        constexpr int parts = 64;
        TracedCurve curve{{.degree = 1, .knots = {0}, .points = {}}, band, function()};
        for (int i = 0; i <= parts; ++i) {
            const auto [x, y] = at(Interval(reach * (2.0 * i / parts - 1)));
            curve.spline.points.push_back({x.mid(), y.mid(), 1});
            curve.spline.knots.push_back(i);
        }
        curve.spline.knots.push_back(parts);
        return curve;
    }
};

/// How often f(v) changes its sign over [-reach, reach] where counts(v), by its signs at many places.
template <class F, class Counts>
std::size_t sign_changes(double reach, const F& f, const Counts& counts) {
    constexpr int parts = 4000;
    std::size_t changes = 0;
    Sign last = Sign::Zero;
    for (int i = 0; i <= parts; ++i) {
        const double v = reach * (2.0 * i / parts - 1);
        const auto rough = f(Interval(v)).sign();
        const Sign now = rough ? *rough : f(Wide(v)).sign().value_or(Sign::Zero);
        if (now == Sign::Zero) continue;
        changes += last != Sign::Zero && now != last && counts(v);
        last = now;
    }
    return changes;
}
std::size_t crossings(const TurnedCurve& a, const Function& g, double reach_of_g, double angle_of_g) {
    return sign_changes(
        a.reach,
        [&]<class T>(const T& v) {
            const auto [x, y] = a.at(v);
            return g->value(x, y);
        },
        [&](double v) {
            const auto [x, y] = a.at(Interval(v));
            return std::abs(std::cos(angle_of_g) * y.mid() - std::sin(angle_of_g) * x.mid()) < reach_of_g;
        });
}
std::size_t crossings(const TurnedCurve& a, const TurnedCurve& b) {
    return crossings(a, b.function(), b.reach, b.angle);
}
std::size_t turns(const TurnedCurve& a) {
    const double c = std::cos(a.angle), s = std::sin(a.angle);
    return sign_changes(
        a.reach, [&]<class T>(const T& v) { return T(c) * a.h.derivative()(v) - T(s); },
        [](double) { return true; });
}

/// Arranges curves, lines x = const and y = +-0.75, all within a square of half width 3, and checks counts
/// against sampled signs and faces against the signs of the functions at the places.
void check_turned_curves(const std::vector<TurnedCurve>& curves, const std::vector<double>& lines,
                         const std::vector<Eigen::Vector2d>& places) {
    CurveArcs g;
    std::vector<Arc> arcs;
    std::vector<Function> functions;
    std::size_t vertices = 0, edges = 0, met = 0;
    for (const TurnedCurve& c : curves) {
        for (const TurnedCurve& other : curves) {
            if (&other < &c) met += crossings(c, other);
        }
        functions.push_back(c.function());
        std::vector<Arc> own;
        g.cut(g.add_traced(c.traced()), own);
        CHECK(own.size() == turns(c) + 1);
        arcs.insert(arcs.end(), own.begin(), own.end());
        vertices += own.size() + 1;
        edges += own.size();
    }
    const auto add_line = [&](double a, double b, double e) {
        const Function f = defining_function(
            [=]<class T>(const T& x, const T& y) -> T { return T(a) * x + T(b) * y + T(e); });
        for (const TurnedCurve& c : curves) met += crossings(c, f, 3, a == 0 ? std::numbers::pi / 2 : 0);
        functions.push_back(f);
        const double x = 3 * b - a * e, y = 3 * a - b * e;
        arcs.push_back(g.segment(g.add_line(a, b, e), g.point(x - 6 * b, y - 6 * a), g.point(x, y)));
        vertices += 2;
        ++edges;
    };
    for (const double x : lines) add_line(1, 0, -x);
    for (const double y : {-0.75, 0.75}) add_line(0, 1, -y);
    met += 2 * lines.size();
    const auto a = arrange<CurveArcs>(g, arcs);
    CHECK(arrangement_defect(g, a) == "");
    CHECK(a.dcel.vertex_count() == vertices + met);
    CHECK(a.dcel.edge_count() == edges + 2 * met);
    CHECK(g.decisions().assumed == 0);

    const PointLocator<CurveArcs> locator(g, a);
    std::map<std::uint32_t, std::vector<Sign>> signs_of_face;
    for (const Eigen::Vector2d& p : places) {
        const Feature found = locator.locate(g.point(p.x(), p.y()));
        REQUIRE(std::holds_alternative<FaceId>(found));
        const FaceId face = std::get<FaceId>(found);
        if (face == Dcel::unbounded_face()) continue;
        std::vector<Sign> signs;
        for (const Function& f : functions) signs.push_back(sign_at(f, p.x(), p.y()));
        const auto [at, is_new] = signs_of_face.try_emplace(face.value, signs);
        CHECK(at->second == signs);
    }
    CHECK(signs_of_face.size() > 8);
}

}  // namespace

TEST_CASE("steep arcs: curves vertical up to 1e-12 over their length cross each other and vertical lines") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> coefficient(-1, 1);
    for (int round = 0; round < 4; ++round) {
        CAPTURE(round);
        const double eps = 1e-12, x0 = 0.3;
        std::vector<TurnedCurve> curves;
        for (int i = 0; i < 5; ++i) {
            TurnedCurve c{{{0, coefficient(rng), coefficient(rng), coefficient(rng)}}};
            for (double& k : c.h.c) k *= eps;
            c.h.c[0] = x0 + 0.3 * eps * coefficient(rng);
            curves.push_back(c);
        }
        const std::vector<double> lines{x0 - 0.25 * eps, x0 + 0.125 * eps, x0 + eps};
        std::vector<Eigen::Vector2d> places;
        for (int i = 0; i < 200; ++i)
            places.emplace_back(x0 + eps * coefficient(rng), 0.8 * coefficient(rng));
        check_turned_curves(curves, lines, places);
    }
}

TEST_CASE("steep arcs: curves turned by random angles, nearly vertical ones among them") {
    std::mt19937_64 rng(test_seed() + 1);
    std::uniform_real_distribution<double> coefficient(-1, 1), exponent(-14, -0.5);
    for (int round = 0; round < 6; ++round) {
        CAPTURE(round);
        std::vector<TurnedCurve> curves;
        for (int i = 0; i < 5; ++i) {
            TurnedCurve c;
            const double amplitude = std::pow(10, exponent(rng));
            for (int k = 1; k < 4; ++k) c.h.c[k] = amplitude * coefficient(rng);
            c.h.c[0] = 0.3 * coefficient(rng);
            // Every second one is off the vertical by no more than it bends.
            c.angle = i % 2 == 0 ? amplitude * coefficient(rng) : std::numbers::pi * coefficient(rng);
            curves.push_back(c);
        }
        std::vector<double> lines{-0.75, 0.75};
        for (int i = 0; i < 2; ++i) lines.push_back(0.3 * coefficient(rng));
        for (const int i : {0, 2}) lines.push_back(curves[i].at(Interval(coefficient(rng))).first.mid());
        std::vector<Eigen::Vector2d> places;
        for (int i = 0; i < 400; ++i) places.emplace_back(0.8 * coefficient(rng), 0.8 * coefficient(rng));
        check_turned_curves(curves, lines, places);
    }
}

TEST_CASE("steep arcs: vertical inflections, as near as they are to turning") {
    // x = y^3 - e y turns twice where e > 0.
    for (const auto& [e, arc_count] :
         {std::pair(1e-3, 3u), {1e-12, 3u}, {1e-40, 3u}, {-1e-40, 1u}, {-1e-12, 1u}, {-1e-3, 1u}}) {
        CAPTURE(e);
        CurveArcs g;
        std::vector<Arc> arcs;
        g.cut(g.add_traced(TurnedCurve{{{0.125, -e, 0, 1}}}.traced()), arcs);
        CHECK(arcs.size() == arc_count);
        CHECK(g.decisions().assumed == 0);
        // Through the inflection, between the turns.
        arcs.push_back(g.segment(g.add_line(1, 0, -0.125), g.point(0.125, -1), g.point(0.125, 1)));
        const std::size_t met = e > 0 ? 3 : 1;
        const auto a = arrange<CurveArcs>(g, arcs);
        CHECK(arrangement_defect(g, a) == "");
        CHECK(a.dcel.vertex_count() == arc_count + 3 + met);
    }
    // The inflection itself is vertical as far as can be told, and so are turns of third order.
    CurveArcs g;
    std::vector<Arc> arcs;
    g.cut(g.add_traced(TurnedCurve{{{0.125, 0, 0, 1}}}.traced()), arcs);
    CHECK(arcs.size() == 1);
    REQUIRE(g.assumed_at().size() == 1);
    CHECK((g.assumed_at()[0] - Eigen::Vector2d(0.125, 0)).norm() < 1e-12);
}

namespace {

/// (x / a)^8 + ((y - c) / b)^8 = 1, flat and vertical over most of its length.
Function cushion(double a, double b, double c) {
    return defining_function([=]<class T>(const T& x, const T& y) -> T {
        return square(square(square(x / T(a)))) + square(square(square((y - T(c)) / T(b)))) - T(1.0);
    });
}
/// A cushion and a jagged polygon within half the band of it.
TracedCurve jagged_cushion(double a, double b, double c, double band, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> off(-0.35 * band, 0.35 * band);
    constexpr int parts = 400;
    TracedCurve curve{{.degree = 1, .knots = {0}, .points = {}}, band, cushion(a, b, c)};
    for (int i = 0; i <= parts; ++i) {
        const double t = 2 * std::numbers::pi * i / parts;
        const double r = std::pow(std::pow(std::cos(t) / a, 8) + std::pow(std::sin(t) / b, 8), -0.125);
        curve.spline.points.push_back({r * std::cos(t) + off(rng), c + r * std::sin(t) + off(rng), 1});
        curve.spline.knots.push_back(i);
    }
    curve.spline.points.back() = curve.spline.points.front();
    curve.spline.knots.push_back(parts);
    return curve;
}

}  // namespace

TEST_CASE("steep arcs: jagged splines in wide bands about curves with vertical stretches") {
    std::mt19937_64 rng(test_seed() + 2);
    for (const double band : {1e-6, 0.01, 0.1, 0.4}) {
        CAPTURE(band);
        CurveArcs g;
        std::vector<Arc> arcs;
        g.cut(g.add_traced(jagged_cushion(1, 1.5, 0, band, rng)), arcs);
        g.cut(g.add_traced(jagged_cushion(1.25, 1, 0.01, band, rng)), arcs);
        g.cut(g.add_traced(jagged_cushion(1.125, 0.75, -0.02, band, rng)), arcs);
        CHECK(arcs.size() == 6);
        // The first crosses each of the others four times; the last is inside the second.
        const auto all = arrange<CurveArcs>(g, arcs);
        CHECK(arrangement_defect(g, all) == "");
        CHECK(all.dcel.vertex_count() == 6 + 8);
        CHECK(all.dcel.edge_count() == 6 + 16);
        CHECK(all.dcel.face_count() == 10);
        // The turns are of eighth order.
        CHECK(g.assumed_at().size() == 6);
        for (const auto& p : g.assumed_at()) CHECK(std::abs(p.y()) < 0.03);
    }
}

TEST_CASE("steep arcs: labelled curves of a triple, all nearly vertical, meet without assumptions") {
    // f0 = 0, f1 = x - e p(y), f2 = 2 x - e q(y).
    const double e = 0x1p-40;
    const Cubic p{{0, e, 0, -2 * e}}, q{{0.25 * e, 0, -3 * e, e}};
    const TurnedCurve c01{p}, c02{{{q.c[0] / 2, 0, q.c[2] / 2, q.c[3] / 2}}};
    const TurnedCurve c12{{{q.c[0], -p.c[1], q.c[2], q.c[3] - p.c[3]}}};
    const std::size_t met = crossings(c01, c02);
    CHECK(met > 0);
    CHECK(crossings(c01, c12) == met);
    for (const bool labelled : {true, false}) {
        CurveArcs g;
        std::vector<Arc> arcs;
        const auto add = [&](const TurnedCurve& c, std::uint32_t i, std::uint32_t j) {
            g.cut(g.add_traced(c.traced(), labelled ? std::optional(CurveArcs::Label{i, j}) : std::nullopt),
                  arcs);
        };
        add(c01, 0, 1);
        add(c02, 0, 2);
        add(c12, 1, 2);
        const auto a = arrange<CurveArcs>(g, arcs);
        CHECK(arrangement_defect(g, a) == "");
        CHECK(a.dcel.vertex_count() == arcs.size() + 3 + met);
        CHECK(a.dcel.edge_count() == arcs.size() + 3 * met);
        CHECK((g.decisions().assumed == 0) == labelled);
    }
}

TEST_CASE("steep arcs: singular points, lines x = const and ends in bends are refused") {
    CurveArcs g;
    CHECK_THROWS_AS(g.add_traced(TurnedCurve{{{0.3, 0, 0, 0}}}.traced()), InputError);
    // Two lines cross.
    TracedCurve cross = TurnedCurve{{{0, 0.5, 0, 0}}}.traced();
    cross.g = defining_function(
        []<class T>(const T& x, const T& y) -> T { return square(x) - T(0.25) * square(y); });
    CHECK_THROWS_AS(g.add_traced(cross), InputError);
    // The arc ends at x = 1/4, where it is as steep as flat, on a bend not wider than the band.
    TracedCurve bend = TurnedCurve{{{0, 0, 1, 0}}, 0, 0.5}.traced(0.25);
    CHECK_THROWS_AS(g.add_traced(bend), InputError);
    bend.band = 0.03;
    CHECK_NOTHROW(g.add_traced(bend));
}
