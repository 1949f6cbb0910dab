// Judges the curves of a trisector in a box by points found without them.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "../../envelope/trisector/trisector_curves.hpp"
#include "../primitives/reference.hpp"

namespace vcell {

struct Triple {
    Object base, a, b;
};
using Curves = std::vector<TrisectorCurve>;

const Box trisector_box{{-4, -4, -4}, {4, 4, 4}};
constexpr double trisector_tolerance = 1e-5;

inline std::vector<Vec3> points_of(const TrisectorCurve& curve) {
    std::vector<Vec3> points;
    for (const RationalCurve3& arc : curve.arcs)
        for (std::size_t k = 0; k + 1 < arc.knots.size(); ++k) {
            const int n = arc.knots[k] < arc.knots[k + 1] ? (arc.degree == 2 ? 400 : 50) : 0;
            for (int i = 0; i < n; ++i)
                points.push_back(arc.evaluate(std::lerp(arc.knots[k], arc.knots[k + 1], i / double(n - 1))));
        }
    return points;
}

inline std::array<double, 2> differences(const Triple& t, const Vec3& p) {
    const double r = distance(t.base, p);
    return {distance(t.a, p) - r, distance(t.b, p) - r};
}

// A point as far from all three, by Gauss-Newton steps with difference quotients.
inline std::optional<Vec3> point_near(const Triple& t, const Box& box, Vec3 p) {
    for (int step = 0; step < 40; ++step) {
        const auto d = differences(t, p);
        if (std::hypot(d[0], d[1]) < 1e-12) {
            for (const Object* o : {&t.base, &t.a, &t.b})
                if (distance(*o, p) < 1e-6) return std::nullopt;
            const bool inside = (p - box.min).minCoeff() > 1e-6 && (box.max - p).minCoeff() > 1e-6;
            return inside ? std::optional(p) : std::nullopt;
        }
        Eigen::Matrix<double, 2, 3> J;
        for (int k = 0; k < 3; ++k) {
            const double h = 1e-6;
            const auto e = differences(t, p + h * Vec3::Unit(k)), f = differences(t, p - h * Vec3::Unit(k));
            for (int i : {0, 1}) J(i, k) = (e[i] - f[i]) / (2 * h);
        }
        const Eigen::Matrix2d gram = J * J.transpose();
        if (!(gram.determinant() > 1e-9)) return std::nullopt;
        p -= J.transpose() * (gram.inverse() * Eigen::Vector2d(d[0], d[1]));
        if (!(p.norm() < 20)) return std::nullopt;
    }
    return std::nullopt;
}

inline double distance_to_polyline(const std::vector<Vec3>& points, const Vec3& p) {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 d = points[i + 1] - points[i];
        const double s = std::clamp(d.dot(p - points[i]) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
        least = std::min(least, (points[i] + s * d - p).norm());
    }
    return least;
}

// How many of the points found from random starts lie on none of the curves, and how many are found; of how
// many curves more is stated than the tolerance.
struct Coverage {
    int found = 0, missed = 0, coarse = 0;
};
inline Coverage coverage(const Triple& t, const Box& box, const Curves& curves, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> unit(0, 1);
    Coverage result;
    std::vector<std::vector<Vec3>> polylines;
    for (const TrisectorCurve& c : curves) polylines.push_back(points_of(c));
    for (int i = 0; i < 150; ++i) {
        const Vec3 share(unit(rng), unit(rng), unit(rng));
        const auto p = point_near(t, box, box.min + share.cwiseProduct(box.max - box.min));
        if (!p) continue;
        ++result.found;
        double least = HUGE_VAL;
        for (const auto& points : polylines) least = std::min(least, distance_to_polyline(points, *p));
        result.missed += least > 2e-3;
    }
    return result;
}

inline void check(const Triple& t, const Box& box, const Curves& curves, std::mt19937_64& rng,
                  Coverage& all) {
    for (const TrisectorCurve& c : curves) {
        CAPTURE(to_string(c.kind));
        REQUIRE_FALSE(c.arcs.empty());
        all.coarse += c.error > trisector_tolerance;
        CHECK(c.error <= 16 * trisector_tolerance);
        const double enough = 2 * c.error + 1e-12;
        const std::vector<Vec3> points = points_of(c);
        double worst = 0;
        for (const Vec3& p : points) {
            CHECK((p - box.min).minCoeff() >= -c.error);
            CHECK((box.max - p).minCoeff() >= -c.error);
        }
        for (const Vec3& p : points) {
            for (const double d : differences(t, p)) worst = std::max(worst, std::abs(d));
            for (const Object* o : {&t.base, &t.a, &t.b}) worst = std::max(worst, -distance(*o, p));
        }
        CHECK(worst <= enough);
        for (std::size_t i = 0; i + 1 < c.arcs.size(); ++i)
            CHECK((c.arcs[i].evaluate(c.arcs[i].knots.back()) -
                   c.arcs[i + 1].evaluate(c.arcs[i + 1].knots.front()))
                      .norm() <= enough);
        if (c.is_closed) {
            CHECK((points.front() - points.back()).norm() <= enough);
            continue;
        }
        for (const int end : {0, 1}) {
            const Vec3& p = end == 0 ? points.front() : points.back();
            const int side = c.ends[end];
            if (side >= 0 && side < 6)
                CHECK(std::abs(p[side / 2] - (side % 2 ? box.max : box.min)[side / 2]) <= enough + 1e-9);
            // Otherwise it is within the box, and a node, or where all three meet.
            if (side == -1) CHECK((p - box.min).minCoeff() >= -enough);
            if (side == -1) CHECK((box.max - p).minCoeff() >= -enough);
        }
    }
    const Coverage c = coverage(t, box, curves, rng);
    CHECK(c.missed == 0);
    all.found += c.found;
    // The judge misses a curve that is left out.
    if (curves.size() == 1 && c.found > 20) all.missed += coverage(t, box, {}, rng).missed > 0 ? 0 : 1;
}
inline void check(const Triple& t, std::mt19937_64& rng, Coverage& all) {
    check(t, trisector_box, trisector(t.base, t.a, t.b, trisector_box, trisector_tolerance), rng, all);
}

/// visit(triple) for the triples of every three kinds (0: planes, 1: balls, 2: tubes), `times` of each;
/// object(kind) makes one.
template <class MakeObject, class Visit>
void for_triples_of_all_kinds(int times, MakeObject&& object, Visit&& visit) {
    for (int round = 0; round < times; ++round)
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                for (int k = j; k < 3; ++k) {
                    CAPTURE(i);
                    CAPTURE(j);
                    CAPTURE(k);
                    CAPTURE(round);
                    visit(Triple{object(i), object(j), object(k)});
                }
}

}  // namespace vcell
