/// Integrands of faces: along conics, multiplied out, against the same point by point; of tubes and of sides
/// of the box against sums over their faces.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/conics.hpp"
#include "../test_support.hpp"
#include "random_scenes.hpp"

namespace vcell::check {
namespace {

Triad<double> middle_of(const Triad<Interval>& p) { return {p[0].mid(), p[1].mid(), p[2].mid()}; }

/// The polygon's sides as curves, counter-clockwise.
std::vector<RationalCurve3> sides(const std::vector<Vec3>& polygon) {
    std::vector<RationalCurve3> result;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        RationalCurve3 side;
        side.degree = 1;
        side.knots = {0, 0, 1, 1};
        for (const Vec3& p : {polygon[i], polygon[(i + 1) % polygon.size()]})
            side.points.push_back({p.x(), p.y(), p.z(), 1});
        result.push_back(std::move(side));
    }
    return result;
}

/// Volume, area and shadow of a face with that boundary, in the frame's unit.
std::array<Interval, 3> integrals(const Shadow& shadow, const std::vector<RationalCurve3>& boundary,
                                  const Frame& frame) {
    std::array<Interval, 3> sum{};
    for (const RationalCurve3& curve : boundary)
        for (const Span& span : spans(curve, frame)) {
            Effort effort{1000};
            const bool is_complete = integrate<3>(
                [&]<class T>(const T& s) {
                    const Densities<T> d = densities(shadow, span.at(s));
                    return std::array<T, 3>{d.volume, d.area, d.shadow};
                },
                -1, 1, {1e-14, 1e-14, 1e-14}, sum, effort);
            CHECK(is_complete);
        }
    return sum;
}

/// The height at which a tube is as far as the plane z = 0 below it.
double height_of_tube(const Cylinder& tube, double x, double y) {
    const Vec3 d = tube.axis.normalized();
    // The excess of the tube's distance falls with z and is convex: Newton's steps from below stay below.
    double z = 0;
    for (int k = 0; k < 80; ++k) {
        const Vec3 away = (Vec3(x, y, z) - tube.point).cross(d);
        const double distance = away.norm(), excess = distance - tube.radius - z,
                     slope = away.dot(Vec3::UnitZ().cross(d)) / distance - 1, next = z - excess / slope;
        if (!(next > z)) break;
        z = next;
    }
    return z;
}

/// Sums over the cells of a grid on a parallelogram, of heights, of the bisector's area and of the plane's.
std::array<double, 3> sums_over(const Cylinder& tube, const Vec2& corner, const Vec2& first,
                                const Vec2& second) {
    constexpr int n = 96;
    constexpr double step = 1e-5;
    const double share = std::abs(first.x() * second.y() - first.y() * second.x()) / (n * n);
    std::array<double, 3> sum{};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Vec2 q = corner + (i + 0.5) / n * first + (j + 0.5) / n * second;
            const auto z = [&](double dx, double dy) { return height_of_tube(tube, q.x() + dx, q.y() + dy); };
            const double gx = (z(step, 0) - z(-step, 0)) / (2 * step),
                         gy = (z(0, step) - z(0, -step)) / (2 * step);
            sum[0] += share * z(0, 0);
            sum[1] += share * std::sqrt(1 + gx * gx + gy * gy);
            sum[2] += share;
        }
    return sum;
}

/// Volume, area and shadow of a face by rules in two variables, from a corner.
std::array<Interval, 3> in_two_variables(const Fan& fan, const std::vector<RationalCurve3>& sides,
                                         const Frame& frame) {
    std::array<Interval, 3> sum{};
    for (const RationalCurve3& side : sides)
        for (const Span& span : spans(side, frame)) {
            Effort effort{1000};
            estimate<3>(
                [&](const Approximate& s) {
                    return [section = FanSection<Approximate>(fan, span.at(s))](const Approximate& sigma) {
                        const Densities<Approximate> d = section.at(sigma);
                        return std::array<Approximate, 3>{d.volume, d.area, d.shadow};
                    };
                },
                {-1, 0}, {1, 1}, {1e-15, 1e-15, 1e-15}, sum, effort);
        }
    return sum;
}

}  // namespace

TEST_CASE("quadrature: an estimate covers what its rules leave out, however near poles are") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(-1.2, 1.2), logarithm(-6, 2);
    for (int k = 0; k < 2000; ++k) {
        // Poles at p -+ i r along either axis.
        const double p = place(rng), q = place(rng), r = std::exp2(logarithm(rng)),
                     w = std::exp2(logarithm(rng));
        CAPTURE(p);
        CAPTURE(r);
        CAPTURE(q);
        CAPTURE(w);
        const auto primitive = [](double x, double about, double away) {
            return std::atan((x - about) / away) / away;
        };
        const double along = primitive(1, p, r) - primitive(-1, p, r),
                     across = primitive(1, q, w) - primitive(0, q, w);
        const auto density = [&](const Approximate& s) {
            const Approximate x = s - p, x2 = x * x + r * r;
            return [&, x2](const Approximate& t) {
                const Approximate y = t - q;
                return std::array<Approximate, 1>{1.0 / (x2 * (y * y + w * w))};
            };
        };
        for (const double enough : {1e-3, 1e-6, 1e-12}) {
            CAPTURE(enough);
            std::array<Interval, 1> sum{};
            Effort effort{100'000};
            REQUIRE(estimate<1>(density, {-1, 0}, {1, 1}, {enough}, sum, effort));
            // The rules' values and the arctangents are rounded.
            const double rounding = 0x1p-46 * (std::abs(primitive(1, p, r)) + std::abs(primitive(-1, p, r))) *
                                    (std::abs(primitive(1, q, w)) + std::abs(primitive(0, q, w)));
            CHECK(std::abs(sum[0].mid() - along * across) <= sum[0].radius() + rounding);
        }
    }
}

TEST_CASE("conics: integrands multiplied out are those of their points") {
    std::mt19937_64 rng(test_seed());
    int compared = 0, plain = 0;
    for (int k = 0; k < 16; ++k) {
        const bool about_sphere = k % 2;
        const Cell cell =
            voronoi_cell(about_sphere ? scene_about_ball(rng, 8, 3) : scene_over_plane(rng, 8, 3));
        const Frame frame(cell.scene);
        for (const CellEdge& edge : cell.edges) {
            if (edge.curve.degree > 2) continue;
            std::vector<Triad<double>> corners;
            for (const auto& p : edge.curve.points) corners.push_back(middle_of(frame.point(p.head<3>())));
            for (const Site& site : edge.sites) {
                const auto face =
                    shadow(cell.scene, frame, site, {{corners.front(), corners.back()}, corners});
                if (!face) continue;
                for (const Span& span : spans(edge.curve, frame)) {
                    const Conic conic(span, about_sphere);
                    const auto integrand = conic.integrand(*face);
                    if (!integrand) continue;
                    const Traced all(Disc(0, 1), 0);
                    const auto traced = densities(*integrand, all, conic.at(all));
                    for (int i = -8; i <= 8; ++i) {
                        const double s = i / 8.0;
                        const auto own = densities(*integrand, MidRad(s), conic.at(MidRad(s)));
                        const Densities<MidRad> truth = densities(*face, span.at(MidRad(s)));
                        const auto numbers = densities(*integrand, Approximate(s), conic.at(Approximate(s)));
                        const std::array<MidRad, 3> expected{truth.volume, truth.area, truth.shadow};
                        for (std::size_t c = 0; c < 3; ++c) {
                            if (!(expected[c].radius() < 1e-9) || !(own[c].radius() < 1e-9)) continue;
                            ++compared;
                            CHECK(std::abs(own[c].mid() - expected[c].mid()) <=
                                  own[c].radius() + expected[c].radius());
                            if (!(traced[c].error() < HUGE_VAL)) continue;
                            ++plain;
                            CHECK(std::abs(numbers[c][0] - expected[c].mid()) <=
                                  traced[c].error() + expected[c].radius());
                            CHECK(expected[c].mid() <= traced[c].magnitude() + expected[c].radius());
                        }
                    }
                }
            }
        }
    }
    CHECK(compared > 5000);
    CHECK(plain > 1000);
}

TEST_CASE(
    "integrands of tubes over a plane: are sums over the face, upright, leaning, level and all but so") {
    int ruled = 0, cones = 0;
    for (const Vec3& axis : {Vec3(1, 0.25, 0), Vec3(-0.5, 1, 0x1p-40), Vec3(1, 1, 1e-3), Vec3(0.25, 1, -0.04),
                             Vec3(1, 0.5, 0.3), Vec3(-1, 0.5, -0.7), Vec3(0.25, -0.125, 1), Vec3(0, 0, 1)})
        for (const double radius : {0.0, 0.25}) {
            CAPTURE(axis.transpose());
            CAPTURE(radius);
            // Steep ones stand beside the face.
            const bool is_steep = std::abs(axis.z()) > axis.head<2>().norm();
            const Cylinder tube{Vec3(is_steep ? 1.75 : 0.25, -0.5, 1), axis, radius};
            Scene scene;
            scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
            scene.objects = {tube};
            scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
            const Frame frame(scene);
            const Vec2 corner(-0.5, -0.75), first(1.25, 0.25), second(-0.25, 1);
            std::vector<Vec3> polygon;
            std::vector<Triad<double>> corners;
            for (const Vec2& q :
                 {corner, Vec2(corner + first), Vec2(corner + first + second), Vec2(corner + second)}) {
                polygon.emplace_back(q.x(), q.y(), height_of_tube(tube, q.x(), q.y()));
                corners.push_back(middle_of(frame.point(polygon.back())));
            }
            const auto face = shadow(scene, frame, Site::object(0), {corners, corners});
            REQUIRE(face);
            ruled += std::holds_alternative<RuledHeight>(*face);
            cones += std::holds_alternative<ConeHeight>(*face);
            const auto found = integrals(*face, sides(polygon), frame);
            const auto expected = sums_over(tube, corner, first, second);
            const double u = frame.unit();
            const std::array units{u * u * u, u * u, u * u};
            for (std::size_t c = 0; c < 3; ++c) {
                CAPTURE(c);
                CHECK(found[c].mid() * units[c] == doctest::Approx(expected[c]).epsilon(2e-4));
                CHECK(found[c].radius() < 1e-12);
            }
            // The same in two variables, from a corner.
            if (const auto* height = std::get_if<RuledHeight>(&*face)) {
                const Fan fan{Fan::Base::plane, height->equation, {corners[0][0], corners[0][1], 0.0}};
                const auto sum = in_two_variables(fan, sides(polygon), frame);
                for (std::size_t c = 0; c < 3; ++c)
                    CHECK(std::abs(found[c].mid() - sum[c].mid()) <= found[c].radius() + 1e-13);
            }
        }
    CHECK(ruled >= 8);
    CHECK(cones >= 2);
}

TEST_CASE("integrands of planes about a tube: are those in two variables") {
    int compared = 0;
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 2, 2), Vec3(-1, 0.25, 3)})
        for (const double radius : {0.0, 0.25})
            for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(-2, 1, 0.5), Vec3(1, -1, -1)}) {
                CAPTURE(axis.transpose());
                CAPTURE(radius);
                CAPTURE(normal.transpose());
                Scene scene;
                scene.base = Cylinder{Vec3(0.25, 0.125, -0.25), axis, radius};
                scene.objects = {Plane{Vec3(0.25, 0.125, -0.25) + 1.75 * normal.normalized(), normal}};
                scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
                const Frame frame(scene);
                // On the left as the normal shows it, near where the plane is nearest.
                const Vec3 n = normal.normalized(), side = n.cross(Vec3(0.5, -0.25, 0.75)).normalized();
                const Vec3 up = n.cross(side);
                const Vec3 middle = Vec3(0.25, 0.125, -0.25) + n;
                std::vector<Vec3> polygon;
                std::vector<Triad<double>> corners;
                for (const auto& [a, b] :
                     {std::pair(-0.5, -0.25), std::pair(0.5, -0.375), std::pair(0.25, 0.5)}) {
                    polygon.push_back(middle + a * side + b * up);
                    corners.push_back(middle_of(frame.point(polygon.back())));
                }
                const auto face = shadow(scene, frame, Site::object(0), {corners, corners});
                REQUIRE(face);
                const auto* tapered = std::get_if<Tapered>(&*face);
                REQUIRE(tapered);
                const auto found = integrals(*face, sides(polygon), frame);
                const Fan fan{Fan::Base::cylinder, tapered->equation, {0.0, 0.0, tapered->start}};
                const auto sum = in_two_variables(fan, sides(polygon), frame);
                for (std::size_t c = 0; c < 3; ++c) {
                    ++compared;
                    CHECK(found[c].lower() > 0);
                    CHECK(std::abs(found[c].mid() - sum[c].mid()) <= found[c].radius() + 1e-12);
                }
            }
    CHECK(compared == 54);
}

TEST_CASE("integrands of sides of the box about a tube: are those of polygons, around the axis or aside") {
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 2, 2), Vec3(-1, 0.25, 3), Vec3(2, 1, 0)}) {
        CAPTURE(axis.transpose());
        Scene scene;
        const Cylinder base{Vec3(0.25, 0.125, -0.25), axis, 0.125};
        scene.base = base;
        scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
        const Frame frame(scene);
        const double u = frame.unit();
        const Vec3 d = axis.normalized(), normal = Vec3::UnitX();
        // Counter-clockwise as seen from outside.
        const auto rectangle = [](double y, double z, double width, double height) {
            return std::vector<Vec3>{
                {2, y, z}, {2, y + width, z}, {2, y + width, z + height}, {2, y, z + height}};
        };
        for (const auto& polygon :
             {rectangle(-1, -0.5, 1.5, 2), rectangle(0.5, -1.75, 1, 0.75), rectangle(1, 1, 0.5, 0.25)}) {
            std::vector<Triad<double>> corners;
            Vec3 center = Vec3::Zero();
            for (const Vec3& p : polygon) {
                corners.push_back(middle_of(frame.point(p)));
                center += 0.25 * p;
            }
            const auto face = shadow(scene, frame, Site::box_side(1), {corners, corners});
            REQUIRE(face);
            const auto* flat = std::get_if<Flat>(&*face);
            REQUIRE(flat);
            // Half the way from the axis, through the side: linear, so that its mean is that at the center.
            const double area = (polygon[1] - polygon[0]).norm() * (polygon[3] - polygon[0]).norm();
            const Vec3 across = (center - base.point) - d.dot(center - base.point) * d;
            const double flux = area * 0.5 * across.dot(normal);
            const auto found = integrals(*face, sides(polygon), frame);
            CHECK(std::abs(found[0].mid() * u * u * u - flux) < 1e-13);
            CHECK(std::abs(found[1].mid() * u * u - area) < 1e-13);
            // Its shadow: n across / |across|^2 over the side, where the axis is not close to it.
            constexpr int n = 128;
            double turn = 0, nearest = HUGE_VAL;
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    const Vec3 p = polygon[0] + (i + 0.5) / n * (polygon[1] - polygon[0]) +
                                   (j + 0.5) / n * (polygon[3] - polygon[0]);
                    const Vec3 way = (p - base.point) - d.dot(p - base.point) * d;
                    turn += area / (n * n) * way.dot(normal) / way.squaredNorm();
                    nearest = std::min(nearest, way.norm());
                }
            if (nearest > 0.25) CHECK(found[2].mid() * u == doctest::Approx(turn).epsilon(1e-3));
            // A boundary that floats above the side by a little stands on a wall: the volume grows as that of
            // its foot and the wall around it.
            std::vector<Vec3> raised = polygon;
            constexpr double above = 0x1p-8;
            for (Vec3& p : raised) p.x() += above;
            double wall = 0;
            for (std::size_t i = 0; i < 4; ++i) {
                const Vec3 side = polygon[(i + 1) % 4] - polygon[i],
                           middle = 0.5 * (polygon[(i + 1) % 4] + polygon[i]);
                const Vec3 at = middle + 0.5 * above * normal;
                const Vec3 way = (at - base.point) - d.dot(at - base.point) * d;
                wall += above * 0.5 * way.dot(normal.cross(side));
            }
            const auto moved = integrals(*face, sides(raised), frame);
            CHECK(std::abs(moved[0].mid() * u * u * u - (flux + wall)) < 1e-13);
            CHECK(std::abs(moved[1].mid() * u * u - area) < 1e-13);
        }
    }
}

}  // namespace vcell::check
