/// What cells around spheres and cylinders are checked for: curves, loops and trims that fit together,
/// vertices with nothing nearer, and faces against the nearest objects along rays and generators.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "../../envelope/lift/lift.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../test_support.hpp"
#include "cell_checks.hpp"

namespace vcell::radial_cells {

using namespace vcell::testing;

inline const Sphere& base_sphere(const Scene& scene) { return std::get<Sphere>(scene.base); }

inline double height(const Scene& scene, const Vec3& p) { return distance_to(scene.base, p); }

/// From the base's centre or axis to p.
inline Vec3 outwards(const Scene& scene, const Vec3& p) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.base)) return p - sphere->center;
    const auto& [point, axis, radius] = std::get<Cylinder>(scene.base);
    const Vec3 d = axis.normalized(), m = p - point;
    return m - m.dot(d) * d;
}

inline Cell cell_of(const Scene& scene) {
    const RadialBaseProblem problem = radial_base_problem(scene);
    const MinimizationDiagram diagram =
        problem.chart.is_sphere()
            ? lower_envelope_on_sphere(problem.family)
            : lower_envelope_on_cylinder(problem.family, problem.stretch[0], problem.stretch[1]);
    REQUIRE_FALSE(diagram.dcel.find_defect());
    Cell cell = lift_all_around(problem, diagram, 1e-7 * scene.box.diagonal(), true).cell;
    cell.scene = scene;
    return cell;
}

/// The distance from the bisector of base and site; from the box side itself. Where a stretch ends no one
/// says.
inline double residual(const Scene& scene, Site site, const Vec3& p) {
    if (site.kind == Site::Kind::End) return 0;
    return std::abs(distance_to(scene, site, p) - (site.is_object() ? height(scene, p) : 0));
}

inline double slack(const Cell& cell, const CellEdge& edge) {
    double error = 1e-12 * cell.scene.box.diagonal();
    for (const std::uint32_t v : edge.vertices) error += 4 * cell.vertices[v].error;
    return error + 2 * edge.error;
}

/// Distance of two points of the surface whose parameters are rounded.
inline double parameter_rounding(const RationalPatch& surface, const Vec2& p) {
    const auto [du, dv] = surface.partials(p.x(), p.y());
    return 256 * 0x1p-53 * (du.norm() * std::abs(p.x()) + dv.norm() * std::abs(p.y()));
}

/// Trims under their edges, or in one point; loops closed, the outer one counter-clockwise and the others
/// clockwise, seen from outside. Adds up how much of every edge is used in either direction, and both sides
/// of every seam at three points.
inline void check_patch(const Cell& cell, const TrimmedPatch& patch, std::vector<std::array<double, 2>>& uses,
                        std::map<std::uint32_t, std::vector<std::array<Vec3, 3>>>& seams) {
    const auto surface = [&](const Vec2& p) { return patch.surface.evaluate(p.x(), p.y()); };
    for (const auto& point : patch.surface.points) CHECK(point.w() > 0);
    for (const auto& loop : patch.loops) {
        double area = 0;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const TrimCurve& trim = loop[i];
            const double begin = trim.curve.domain_begin(), end = trim.curve.domain_end();
            const RationalCurve2& following = loop[(i + 1) % loop.size()].curve;
            const Vec2 next = following.evaluate(following.domain_begin());
            CHECK((trim.curve.evaluate(end) - next).norm() <= 1e-6 * (1 + next.norm()));
            Vec2 last = trim.curve.evaluate(begin);
            for (int k = 0; k <= 16; ++k) {
                const double t = std::lerp(begin, end, k / 16.0);
                const Vec2 p = trim.curve.evaluate(t);
                area += 0.5 * (last.x() * p.y() - last.y() * p.x());
                last = p;
                if (!trim.edge) continue;
                const CellEdge& edge = cell.edges[*trim.edge];
                const double gap = (surface(p) - edge.curve.evaluate(trim.reversed ? 1 - t : t)).norm();
                CHECK(gap <= slack(cell, edge) + parameter_rounding(patch.surface, p));
            }
            if (trim.is_tip()) {
                const Vec3 tip = surface(trim.curve.evaluate(begin));
                for (const double t : {0.25, 0.5, 1.0})
                    CHECK((surface(trim.curve.evaluate(std::lerp(begin, end, t))) - tip).norm() <=
                          1e-12 * cell.scene.box.diagonal());
                continue;
            }
            CHECK(trim.edge.has_value() != trim.seam.has_value());
            if (trim.edge) {
                // A conic may be a cubic on a patch around a cylinder.
                const CellEdge& edge = cell.edges[*trim.edge];
                const bool is_raised = edge.curve.degree == 2 && patch.surface.degree_u == 2 &&
                                       std::holds_alternative<Cylinder>(cell.scene.base);
                CHECK(trim.curve.degree == (is_raised ? 3 : edge.curve.degree));
                uses[*trim.edge][trim.reversed] += end - begin;
            } else {
                seams[*trim.seam].push_back({surface(trim.curve.evaluate(begin)),
                                             surface(trim.curve.evaluate(0.5 * (begin + end))),
                                             surface(trim.curve.evaluate(end))});
            }
        }
        CHECK((area > 0) == (&loop == &patch.loops.front()));
    }
    const auto& [u0, u1] = patch.surface.domain_u;
    const auto& [v0, v1] = patch.surface.domain_v;
    const double u = 0.5 * (u0 + u1), v = 0.5 * (v0 + v1);
    const auto [du, dv] = patch.surface.partials(u, v);
    CHECK(du.cross(dv).dot(outwards(cell.scene, surface({u, v}))) > 0);
}

/// Vertices and edges equally far from base and sites, with nothing nearer; trims under their edges; loops
/// closed, the outer one counter-clockwise and the others clockwise; every edge once in each direction.
/// `exact`: what conics may be off by, as a part of the box's diagonal, with what rounding leaves of patches.
inline void check_cell(const Cell& cell, double exact = 1e-9) {
    const Scene& scene = cell.scene;
    const double length = scene.box.diagonal();
    for (const CellVertex& v : cell.vertices) {
        // Two meet where tubes of one radius cross, or at an end of a tube.
        const bool is_round = std::ranges::any_of(v.sites, [&](Site s) {
            return s.is_object() && std::holds_alternative<Cylinder>(scene.objects[s.index]);
        });
        CHECK(v.sites.size() >= (std::holds_alternative<Sphere>(scene.base) && !is_round ? 3 : 2));
        CHECK(v.error < 1e-9 * length);
        CHECK(std::abs(height(scene, v.point) - v.radius) <= 1e-13 * length);
        for (const Site site : v.sites) CHECK(residual(scene, site, v.point) <= 1e-13 * length + 2 * v.error);
        for (const Object& object : scene.objects)
            CHECK(distance_to(object, v.point) >= v.radius - 1e-13 * length - 2 * v.error);
    }
    for (const CellEdge& edge : cell.edges) {
        const double tolerance = slack(cell, edge);
        CHECK(edge.error > 0);
        if (edge.kind != CurveKind::Spline) CHECK(edge.error <= exact * length);
        for (int k = 0; k <= 16; ++k) {
            const Vec3 p = edge.curve.evaluate(k / 16.0);
            for (const Site site : edge.sites) CHECK(residual(scene, site, p) <= tolerance);
            for (const Site site : edge.extra_sites) CHECK(residual(scene, site, p) <= tolerance);
        }
        for (const auto& point : edge.curve.points) CHECK(point.w() > 0);
        if (edge.vertices.empty()) {
            CHECK((edge.curve.evaluate(0) - edge.curve.evaluate(1)).norm() <= tolerance);
        } else {
            CHECK((edge.curve.evaluate(0) - cell.vertices[edge.vertices[0]].point).norm() <= tolerance);
            CHECK((edge.curve.evaluate(1) - cell.vertices[edge.vertices[1]].point).norm() <= tolerance);
        }
        // Of a rational quadratic with 1 at both ends the middle weight tells; of a small one, with few
        // digits.
        if (edge.curve.degree == 2) {
            for (std::size_t i = 1; i < edge.curve.points.size(); i += 2) {
                const auto& points = edge.curve.points;
                const double w = points[i].w();
                const double leg = std::min((points[i] - points[i - 1]).head<3>().norm(),
                                            (points[i + 1] - points[i]).head<3>().norm());
                const double rounding = 1e-12 * (1 + length / leg);
                CHECK(w >= 0.3);
                if (edge.kind == CurveKind::Hyperbola) CHECK(w > 1 - rounding);
                if (edge.kind == CurveKind::Parabola) CHECK(std::abs(w - 1) <= rounding);
                if (edge.kind == CurveKind::Ellipse || edge.kind == CurveKind::Circle)
                    CHECK(w < 1 + rounding);
            }
        }
        CHECK((edge.curve.degree == 1) == (edge.kind == CurveKind::Line));
    }
    std::vector<std::array<double, 2>> uses(cell.edges.size(), {0, 0});
    std::map<std::uint32_t, std::vector<std::array<Vec3, 3>>> seams;
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches) check_patch(cell, patch, uses, seams);
    for (std::size_t i = 0; i < uses.size(); ++i) {
        const bool is_rim = cell.edges[i].sites[1].kind == Site::Kind::End;
        CHECK(uses[i][0] == doctest::Approx(1));
        CHECK(uses[i][1] == doctest::Approx(is_rim ? 0 : 1));
    }
    for (const auto& [number, sides] : seams) {
        REQUIRE(sides.size() == 2);
        for (int k = 0; k < 3; ++k) CHECK((sides[0][k] - sides[1][2 - k]).norm() <= 1e-6 * length);
    }
}

/// The nearest site along the ray in a direction, and how much further the next one is (relative).
struct Nearest {
    Site site;
    double gap;
};

inline Nearest nearest(const Scene& scene, const Vec3& direction) {
    const auto& [center, radius] = base_sphere(scene);
    const double far = 2 * scene.box.diagonal();
    double best = far, second = far;
    Site owner;
    const auto meet = [&](Site site) {
        // How much nearer the base is falls along the ray: bisection.
        const auto room = [&](double t) {
            const Vec3 p = center + t * direction;
            return distance_to(scene, site, p) - (site.is_object() ? t - radius : 0);
        };
        double low = 0, high = far;
        if (room(high) > 0) return;
        for (int k = 0; k < 60; ++k) (room(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
        if (low < best) {
            second = std::exchange(best, low);
            owner = site;
        } else {
            second = std::min(second, low);
        }
    };
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) meet(Site::object(i));
    for (std::uint32_t side = 0; side < 6; ++side) meet(Site::box_side(side));
    return {owner, second / best - 1};
}

/// By how often a face's boundary goes round the ray in that direction, less how often round the opposite
/// one: seen from there, in stereographic projection.
inline int turns_around(const Cell& cell, const CellFace& face, const Vec3& direction) {
    const Vec3 x = direction.unitOrthogonal(), y = direction.cross(x),
               center = base_sphere(cell.scene).center;
    double angle = 0;
    for (const auto& loop : face.patches.front().loops)
        for (const TrimCurve& trim : loop) {
            constexpr int steps = 200;
            Vec2 last;
            for (int k = 0; k <= steps; ++k) {
                const double t = static_cast<double>(trim.reversed ? steps - k : k) / steps;
                const Vec3 p = cell.edges[*trim.edge].curve.evaluate(t) - center;
                const Vec2 q(x.dot(p), y.dot(p));
                if (k > 0) angle += std::atan2(last.x() * q.y() - last.y() * q.x(), last.dot(q));
                last = q;
            }
        }
    return static_cast<int>(std::lround(angle / (2 * std::numbers::pi)));
}

inline void check_faces_by_rays(const Cell& cell, std::mt19937_64& rng, int rays) {
    std::normal_distribution<double> normal;
    for (int i = 0; i < rays; ++i) {
        const Vec3 direction = Vec3(normal(rng), normal(rng), normal(rng)).normalized();
        const Nearest ahead = nearest(cell.scene, direction), behind = nearest(cell.scene, -direction);
        if (ahead.gap < 1e-2 || behind.gap < 1e-2) continue;
        for (const CellFace& face : cell.faces) {
            int turns = 0;
            for (const CellFace& other : cell.faces)
                if (other.site == face.site) turns += turns_around(cell, other, direction);
            CHECK(turns == (face.site == ahead.site) - (face.site == behind.site));
        }
    }
}

struct SceneMaker {
    std::mt19937_64& rng;

    double number(double from, double to) { return std::uniform_real_distribution(from, to)(rng); }
    Vec3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }

    // Balls and planes about a base ball; `extent`: half the box. Neither holds the base.
    Scene scene(int count, double extent, double plane_share, bool equal_radii) {
        Scene scene;
        const Vec3 center = vector(3);
        const double radius = number(0, 1) < 0.2 ? 0 : number(0.3, 1.5);
        scene.base = Sphere{center, radius};
        for (int i = 0; i < count; ++i) {
            const Vec3 direction = vector(1).normalized();
            if (number(0, 1) < plane_share) {
                scene.objects.push_back(
                    Plane{center + direction * (radius + number(0.1, 4)), direction + vector(0.3)});
            } else {
                const double rho = equal_radii ? radius : number(0.1, 1.7);
                const double nearest = std::abs(rho - radius) + 0.2;
                scene.objects.push_back(Sphere{center + direction * number(nearest, rho + radius + 2), rho});
            }
        }
        scene.box = {center - extent * Vec3(1, number(0.5, 1), 1),
                     center + extent * Vec3(1, 1, number(0.5, 1))};
        return scene;
    }
};

inline Scene centred(double radius, double extent, std::vector<Object> objects) {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), radius};
    scene.objects = std::move(objects);
    scene.box = {Vec3::Constant(-extent), Vec3::Constant(extent)};
    return scene;
}

inline std::vector<CurveKind> kinds_between(const Cell& cell, Site a, Site b) {
    std::vector<CurveKind> kinds;
    for (const CellEdge& edge : cell.edges)
        if (edge.sites == std::array{a, b} || edge.sites == std::array{b, a}) kinds.push_back(edge.kind);
    return kinds;
}

// --- Around cylinders

/// Where the generator through a base point crosses the boundary of faces of one site, above that point: odd
/// within.
struct CylinderChart {
    Vec3 origin, x, y, z;

    explicit CylinderChart(const Cylinder& base)
        : origin(base.point), x(base.axis.unitOrthogonal()), y(base.axis.normalized()), z(x.cross(y)) {}
    Vec3 point(double angle, double height, double t) const {
        return origin + height * y + t * (std::sin(angle) * x + std::cos(angle) * z);
    }
    double height(const Vec3& p) const { return y.dot(p - origin); }
    double angle(const Vec3& p) const { return std::atan2(x.dot(p - origin), z.dot(p - origin)); }
};

inline int crossings_above(const Cell& cell, const CylinderChart& chart, Site site, double angle,
                           double height) {
    int count = 0;
    for (const CellFace& face : cell.faces) {
        if (face.site != site) continue;
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop) {
                    if (!trim.edge) continue;  // along a generator
                    constexpr int steps = 100;
                    double last = 0, last_height = 0;
                    for (int k = 0; k <= steps; ++k) {
                        const double t = std::lerp(trim.curve.domain_begin(), trim.curve.domain_end(),
                                                   static_cast<double>(k) / steps);
                        const Vec3 p = cell.edges[*trim.edge].curve.evaluate(trim.reversed ? 1 - t : t);
                        const double off = std::remainder(chart.angle(p) - angle, 2 * std::numbers::pi);
                        const double h = chart.height(p);
                        if (k > 0 && (last > 0) != (off > 0) && std::abs(last - off) < std::numbers::pi &&
                            last_height + (h - last_height) * last / (last - off) > height)
                            ++count;
                        last = off;
                        last_height = h;
                    }
                }
    }
    return count;
}

inline void check_cylinder_faces(const Cell& cell, std::mt19937_64& rng, int points) {
    const Scene& scene = cell.scene;
    const auto& base = std::get<Cylinder>(scene.base);
    const CylinderChart chart(base);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const CellEdge& edge : cell.edges)
        if (edge.sites[1].kind == Site::Kind::End)
            (edge.sites[1].index == 0 ? low : high) = chart.height(edge.curve.evaluate(0));
    REQUIRE(low < high);
    for (int i = 0; i < points; ++i) {
        const double angle = std::uniform_real_distribution(-std::numbers::pi, std::numbers::pi)(rng);
        const double y = std::uniform_real_distribution(low, high)(rng);
        const double far = 2 * scene.box.diagonal();
        double best = far, second = far;
        Site owner;
        const auto meet = [&](Site site) {
            const auto room = [&](double t) {
                return distance_to(scene, site, chart.point(angle, y, t)) -
                       (site.is_object() ? t - base.radius : 0);
            };
            double from = 0, to = far;
            if (room(to) > 0) return;
            for (int k = 0; k < 60; ++k) (room(0.5 * (from + to)) > 0 ? from : to) = 0.5 * (from + to);
            if (from < best) {
                second = std::exchange(best, from);
                owner = site;
            } else {
                second = std::min(second, from);
            }
        };
        for (std::uint32_t k = 0; k < scene.objects.size(); ++k) meet(Site::object(k));
        for (std::uint32_t side = 0; side < 6; ++side) meet(Site::box_side(side));
        if (second < 1.01 * best) continue;
        std::vector<Site> sites;
        for (const CellFace& face : cell.faces) sites.push_back(face.site);
        std::ranges::sort(sites);
        sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
        for (const Site site : sites) {
            CAPTURE(to_string(site));
            CAPTURE(to_string(owner));
            CHECK(crossings_above(cell, chart, site, angle, y) % 2 == (site == owner));
        }
    }
}

inline Scene about_tube(const Cylinder& tube, double extent, std::vector<Object> objects) {
    Scene scene;
    scene.base = tube;
    scene.objects = std::move(objects);
    scene.box = {tube.point - Vec3::Constant(extent), tube.point + Vec3::Constant(extent)};
    return scene;
}

inline Cell checked(const Scene& scene, std::uint64_t salt = 0) {
    std::mt19937_64 rng(test_seed() + salt);
    const Cell cell = cell_of(scene);
    check_cell(cell);
    check_cylinder_faces(cell, rng, 12);
    return cell;
}

}  // namespace vcell::radial_cells
