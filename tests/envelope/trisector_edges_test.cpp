// A cell's spline edges against trisector(): parts of the same curves, in another box and without what else
// competes.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "../../core/errors.hpp"
#include "../../envelope/trisector/trisector_curves.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../test_support.hpp"

namespace vcell::trisector_edges_test {

namespace {

struct Nearest {
    double distance, t;
};

// The point of a curve nearest to p: the best of samples, refined between its neighbours; where that is an
// end, the curve may close there and go on at the other one.
Nearest nearest(const RationalCurve3& curve, const Vec3& p) {
    const int samples = 24 * static_cast<int>(curve.points.size() / static_cast<std::size_t>(curve.degree));
    const auto at = [&](double i) {
        return std::lerp(curve.domain_begin(), curve.domain_end(), std::clamp(i / samples, 0.0, 1.0));
    };
    const auto distance = [&](double t) { return (curve.evaluate(t) - p).norm(); };
    const auto refined = [&](int best) -> Nearest {  // by golden sections
        constexpr double part = 1 / std::numbers::phi;
        double low = at(best - 1), high = at(best + 1);
        double a = std::lerp(high, low, part), b = std::lerp(low, high, part);
        double at_a = distance(a), at_b = distance(b);
        for (int step = 0; step < 64; ++step)
            if (at_a < at_b) {
                high = std::exchange(b, a);
                at_b = std::exchange(at_a, distance(a = std::lerp(high, low, part)));
            } else {
                low = std::exchange(a, b);
                at_a = std::exchange(at_b, distance(b = std::lerp(low, high, part)));
            }
        const double t = std::midpoint(low, high);
        return {distance(t), t};
    };
    int best = 0;
    double least = distance(at(0));
    for (int i = 1; i <= samples; ++i)
        if (const double here = distance(at(i)); here < least) {
            least = here;
            best = i;
        }
    const Nearest found = refined(best);
    if (best != 0 && best != samples) return found;
    const Nearest other = refined(samples - best);
    return other.distance < found.distance ? other : found;
}

Vec3 at_fraction(const RationalCurve3& curve, double s) {
    return curve.evaluate(std::lerp(curve.domain_begin(), curve.domain_end(), s));
}

// By how much more than their errors allow the edge and the trisector are apart, in the edge's length.
// Negative: by nothing.
double excess(const RationalCurve3& edge, double edge_error, bool closed,
              const std::vector<TrisectorCurve>& all) {
    constexpr double rounding = 1e-12;
    double least = HUGE_VAL;
    for (const TrisectorCurve& curve : all) {
        const RationalCurve3& arc = curve.arcs.front();
        const double allowed = edge_error + curve.error + rounding;
        double most = -HUGE_VAL;
        for (int i = 0; i <= 40; ++i)
            most = std::max(most, nearest(arc, at_fraction(edge, i / 40.0)).distance - allowed);
        // The other way round, between the edge's ends.
        double from = arc.domain_begin(), to = arc.domain_end();
        if (!closed) {
            from = nearest(arc, at_fraction(edge, 0)).t;
            to = nearest(arc, at_fraction(edge, 1)).t;
            if (from > to) std::swap(from, to);
        }
        const double middle = nearest(arc, at_fraction(edge, 0.5)).t;
        const bool is_between =
            from <= middle && middle <= to;  // otherwise over the place where the arc closes
        for (int i = 1; i < 40 && most < least; ++i) {
            double t = std::lerp(from, to, i / 40.0);
            if (!is_between) {
                const double period = arc.domain_end() - arc.domain_begin();
                t = std::lerp(to, from + period, i / 40.0);
                if (t > arc.domain_end()) t -= period;
            }
            most = std::max(most, nearest(edge, arc.evaluate(t)).distance - allowed);
        }
        least = std::min(least, most);
    }
    return least;
}

struct Compared {
    int edges = 0, over[3] = {0, 0, 0};
};

void compare(const Scene& scene, Compared& done) {
    const Cell cell = voronoi_cell(scene);
    // The edges end within the box of the scene, the trisectors beyond.
    const Vec3 margin = Vec3::Constant(0.1 * scene.box.diagonal());
    const Box box{scene.box.min - margin, scene.box.max + margin};
    for (const CellEdge& edge : cell.edges) {
        if (edge.kind != CurveKind::Spline || !edge.sites[0].is_object() || !edge.sites[1].is_object())
            continue;
        CAPTURE(edge.sites[0].index);
        CAPTURE(edge.sites[1].index);
        const std::vector<TrisectorCurve> all =
            trisector(scene.base, scene.objects[edge.sites[0].index], scene.objects[edge.sites[1].index], box,
                      *scene.tolerance);
        CHECK(edge.error <= 2 * *scene.tolerance);
        for (const TrisectorCurve& curve : all) CHECK(curve.error <= 2 * *scene.tolerance);
        const bool closed = edge.vertices.empty();
        CHECK(excess(edge.curve, edge.error, closed, all) <= 0);
        // Off by far more than the errors it is seen to be off.
        double errors = edge.error;
        for (const TrisectorCurve& curve : all) errors = std::max(errors, edge.error + curve.error);
        RationalCurve3 off = edge.curve;
        const Vec3 along = at_fraction(edge.curve, 0.55) - at_fraction(edge.curve, 0.45);
        for (auto& p : off.points) p.head<3>() += 64 * errors * along.unitOrthogonal();
        CHECK(excess(off, edge.error, closed, all) > 0);
        ++done.edges;
        ++done.over[scene.base.index()];
    }
}

}  // namespace

TEST_CASE("spline edges: those of cells are the curves of trisector(), over every base") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    const auto radius = [&] { return 0.2 + 0.1 * unit(rng); };
    Compared done;
    for (int round = 0; round < long_rounds(4); ++round)
        for (const int base : {0, 1, 2}) {
            CAPTURE(round);
            CAPTURE(base);
            Scene scene;
            scene.box = {{-3, -3, -3}, {3, 3, 3}};
            scene.tolerance = round % 2 == 0 ? 1e-5 : 1e-7;
            // Beside the base, in a direction across the axis of a tube.
            const auto beside = [&](const Vec3& axis, const Vec3& direction) -> Vec3 {
                const Vec3 out = (direction - direction.dot(axis) * axis).normalized();
                return 1.6 * out + unit(rng) * axis;
            };
            const Vec3 axis = base == 2 ? Vec3(0, 0, 1) : Vec3(0, 0, 0);
            if (base == 0) scene.base = Plane{{0, 0, -1}, {0, 0, 1}};
            if (base == 1) scene.base = Sphere{{0.1, 0.2, -0.1}, 0.5};
            if (base == 2) scene.base = Cylinder{{0, 0, 0}, {0, 0, 1}, 0.5};
            const auto place = [&] {
                return base == 0 ? Vec3(unit(rng), unit(rng), 0.7 + 0.3 * unit(rng)) : beside(axis, vector());
            };
            scene.objects.push_back(Sphere{place(), radius()});
            for (int i = 0; i < 2; ++i) {
                const Vec3 p = place();
                const Vec3 along =
                    base == 0 ? Vec3(unit(rng), unit(rng), 0.1 * unit(rng)) : Vec3(p.cross(vector()));
                scene.objects.push_back(Cylinder{p, along, radius()});
            }
            try {
                compare(scene, done);
            } catch (const InputError& e) {
                // At random a tube runs through the base, in the larger box at least.
                CHECK(e.kind == InputError::Kind::TouchesBase);
            }
        }
    CAPTURE(done.edges);
    for (const int over : done.over) CHECK(over >= long_rounds(6));
}

}  // namespace vcell::trisector_edges_test
