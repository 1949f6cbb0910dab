/// What must hold in every cell, checked against distances and brute force, not against the code's formulas.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "../../envelope/cell.hpp"
#include "../../primitives/bases/plane_base.hpp"

namespace vcell::testing {

inline double distance_to(const Object& object, const Vec3& p) {
    if (const auto* sphere = std::get_if<Sphere>(&object))
        return (p - sphere->center).norm() - sphere->radius;
    if (const auto* cylinder = std::get_if<Cylinder>(&object)) {
        const Vec3 axis = cylinder->axis.normalized(), m = p - cylinder->point;
        return (m - m.dot(axis) * axis).norm() - cylinder->radius;
    }
    if (const auto* ball = std::get_if<HollowSphere>(&object))
        return ball->radius - (p - ball->center).norm();
    if (const auto* tube = std::get_if<HollowCylinder>(&object))
        return tube->radius - tube->axis.normalized().cross(p - tube->point).norm();
    if (const auto* cone = std::get_if<HollowCone>(&object)) {
        const Vec3 axis = cone->axis.normalized(), m = p - cone->apex;
        const double sine = cone->radius / cone->slant;
        return sine * axis.dot(m) - std::sqrt(1 - sine * sine) * axis.cross(m).norm();
    }
    const auto& plane = std::get<Plane>(object);
    return std::abs((p - plane.point).dot(plane.normal)) / plane.normal.norm();
}

/// Signed distance of p from a site; for a box side zero on the side's plane.
inline double distance_to(const Scene& scene, Site site, const Vec3& p) {
    if (site.is_object()) return distance_to(scene.objects[site.index], p);
    const Eigen::Index axis = site.index / 2;
    return site.index % 2 ? scene.box.max[axis] - p[axis] : p[axis] - scene.box.min[axis];
}

inline double clearance(const Scene& scene, const Vec3& p) {
    const auto& base = std::get<Plane>(scene.base);
    return (p - base.point).dot(base.normal) / base.normal.norm();
}

/// How far p is from lying on the bisector of base and site (on the box side itself).
inline double bisector_residual(const Scene& scene, Site site, const Vec3& p) {
    return std::abs(distance_to(scene, site, p) - (site.is_object() ? clearance(scene, p) : 0));
}

/// The same for a site that may be the wall over the region's rim: along the base's normal down to the base.
inline double boundary_residual(const Scene& scene, Site site, const Vec3& p) {
    const double residual = bisector_residual(scene, site, p);
    if (site.is_object()) return residual;
    const Vec3 up = std::get<Plane>(scene.base).normal.normalized();
    return std::min(residual, std::abs(distance_to(scene, site, p - clearance(scene, p) * up)));
}

/// Curves on patches, end points on vertices, loops closed and oriented, edges used as often as they must be.
inline void check_geometry(const Cell& cell) {
    const double tolerance = 1e-13 * (cell.scene.box.diagonal() + cell.scene.box.min.norm());
    const Scene& scene = cell.scene;
    for (const CellVertex& vertex : cell.vertices) {
        for (const Site site : vertex.sites)
            CHECK(boundary_residual(scene, site, vertex.point) <= tolerance + 4 * vertex.error);
        CHECK(std::abs(clearance(scene, vertex.point) - vertex.radius) <= tolerance + vertex.error);
        CHECK(std::is_sorted(vertex.sites.begin(), vertex.sites.end()));
        CHECK(vertex.error < 1000 * tolerance);  // a near tangency costs digits
    }
    std::vector<std::array<int, 2>> uses(cell.edges.size(), {0, 0});
    for (std::size_t i = 0; i < cell.edges.size(); ++i) {
        const CellEdge& edge = cell.edges[i];
        CAPTURE(i);
        REQUIRE(edge.curve.knots.size() == edge.curve.points.size() + edge.curve.degree + 1);
        // The curve ends at its vertices, so it is as good as they are.
        double slack = tolerance;
        for (const std::uint32_t v : edge.vertices)
            slack = std::max(slack, tolerance + 4 * cell.vertices[v].error);
        const double slack_of_ends = slack;
        slack += 2 * edge.error;  // a distance function and the base's have the slope 1
        CHECK(edge.error > 0);
        if (edge.kind != CurveKind::Spline) CHECK(edge.error <= 1e4 * slack_of_ends);
        double polyline = 0;
        Vec3 last = edge.curve.evaluate(0);
        for (int k = 0; k <= 512; ++k) {
            const Vec3 p = edge.curve.evaluate(k / 512.0);
            polyline += (p - last).norm();
            last = p;
            if (k % 32) continue;
            for (const Site site : edge.sites) CHECK(boundary_residual(scene, site, p) <= slack);
            for (const Site site : edge.extra_sites) CHECK(bisector_residual(scene, site, p) <= slack);
        }
        CHECK(edge.length == doctest::Approx(polyline).epsilon(1e-4));
        CHECK(edge.length >= polyline - slack);
        if (edge.vertices.empty()) {
            CHECK((edge.curve.evaluate(0) - edge.curve.evaluate(1)).norm() <= tolerance);
        } else {
            REQUIRE(edge.vertices.size() == 2);
            CHECK(edge.curve.points.front().head<3>() == cell.vertices[edge.vertices[0]].point);
            CHECK(edge.curve.points.back().head<3>() == cell.vertices[edge.vertices[1]].point);
        }
        for (const auto& control : edge.curve.points) CHECK(control(3) > 0);
    }
    for (std::size_t i = 0; i < cell.faces.size(); ++i) {
        const CellFace& face = cell.faces[i];
        CAPTURE(i);
        REQUIRE(face.patches.size() == 1);
        const RationalPatch& surface = face.patches[0].surface;
        // A steep patch reaches far beyond the box over its bounding rectangle.
        double extent = 0;
        for (const Eigen::Vector4d& p : surface.points) extent = std::max(extent, p.head<3>().norm());
        for (int a = 0; a <= 6; ++a) {
            for (int b = 0; b <= 6; ++b) {
                const double u = surface.domain_u[0] + a / 6.0 * (surface.domain_u[1] - surface.domain_u[0]);
                const double v = surface.domain_v[0] + b / 6.0 * (surface.domain_v[1] - surface.domain_v[0]);
                const Vec3 p = surface.evaluate(u, v);
                // Behind the base the bisector is that of another side of the object.
                if (clearance(scene, p) < 0) continue;
                // Beyond the box heights may grow: the residual does with them.
                CHECK(bisector_residual(scene, face.site, p) <=
                      tolerance + 1e-14 * (p - scene.box.min).norm());
            }
        }
        bool outer = true;
        for (const std::vector<TrimCurve>& loop : face.patches[0].loops) {
            double area = 0;
            for (std::size_t k = 0; k < loop.size(); ++k) {
                const TrimCurve& trim = loop[k];
                REQUIRE(trim.edge);
                const CellEdge& edge = cell.edges[*trim.edge];
                // A half-edge has its face on the left: the sites tell which one runs forward.
                ++uses[*trim.edge][trim.reversed];
                CHECK(edge.sites[trim.reversed] == face.site);
                // Both in one parameter: spans begin and end together.
                if (trim.curve.degree == edge.curve.degree) CHECK(trim.curve.knots == edge.curve.knots);
                CHECK((trim.curve.points.size() - 1) / trim.curve.degree ==
                      (edge.curve.points.size() - 1) / edge.curve.degree);
                const RationalCurve2& next = loop[(k + 1) % loop.size()].curve;
                const double gap = (trim.curve.points.back() - next.points.front()).head<2>().norm();
                if (edge.vertices.empty())
                    CHECK(gap <= tolerance);
                else
                    CHECK(gap == 0);
                double slack = tolerance + 1e-14 * extent;
                for (const std::uint32_t v : edge.vertices)
                    slack = std::max(slack, tolerance + 4 * cell.vertices[v].error);
                slack += edge.error;
                Eigen::Vector2d last = trim.curve.evaluate(0);
                for (int s = 0; s <= 64; ++s) {
                    const double t = s / 64.0;
                    const Eigen::Vector2d uv = trim.curve.evaluate(t);
                    area += 0.5 * (last.x() * uv.y() - last.y() * uv.x());
                    last = uv;
                    const Vec3 on_edge = edge.curve.evaluate(trim.reversed ? 1 - t : t);
                    CHECK((surface.evaluate(uv.x(), uv.y()) - on_edge).norm() <= slack);
                    CHECK(uv.x() >= surface.domain_u[0] - tolerance);
                    CHECK(uv.x() <= surface.domain_u[1] + tolerance);
                    CHECK(uv.y() >= surface.domain_v[0] - tolerance);
                    CHECK(uv.y() <= surface.domain_v[1] + tolerance);
                }
            }
            // Faces thinner than the spacing of doubles have no orientation left.
            const double sliver = tolerance * cell.scene.box.diagonal();
            CHECK((outer ? area > -sliver : area < sliver));
            outer = false;
        }
    }
    for (std::size_t i = 0; i < uses.size(); ++i) {
        const bool rim = cell.edges[i].sites[1].kind == Site::Kind::BoxSide && uses[i][1] == 0;
        CHECK(uses[i][0] == 1);
        CHECK(uses[i][1] == (rim ? 0 : 1));
    }
}

/// How much larger a piece of the bisector at p is than its projection.
inline double stretch(const FormFamily& family, FormId form, const Vec3& p) {
    if (family.is_circular(form)) {
        const CircularForm& f = family.forms[form];
        const double gx = (2 * f.k * (p.x() - f.cx) + f.a) / f.w, gy = (2 * f.k * (p.y() - f.cy) + f.b) / f.w;
        return std::sqrt(1 + gx * gx + gy * gy);
    }
    // Across the bisector runs the difference of the directions away from the cylinder's axis and from the
    // base.
    const CylinderForm& f = family.cylinder(form);
    const Vec3 axis = Vec3(f.ax, f.ay, f.az).normalized(), m = p - Vec3(f.px, f.py, f.pz);
    const Vec3 across = (m - m.dot(axis) * axis).normalized() - Vec3::UnitZ();
    return across.norm() / std::abs(across.z());
}

/// Measures by the midpoint rule on an n x n grid over the region's bounding rectangle, heights and slopes by
/// brute force over all forms.
struct SampledMeasures {
    double volume = 0, area = 0, min_clearance = std::numeric_limits<double>::infinity();
    double max_clearance = 0;
    double min_within = 0;  ///< by how much it may be less than min_clearance within half a sample's diagonal
};
inline SampledMeasures sample_measures(const PlaneBaseProblem& problem, int n) {
    Eigen::Vector2d low = problem.corners[0], high = low;
    for (const Eigen::Vector2d& c : problem.corners) {
        low = low.cwiseMin(c);
        high = high.cwiseMax(c);
    }
    const Eigen::Vector2d step = (high - low) / n;
    const double cell_area = step.x() * step.y();
    SampledMeasures m;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const double x = low.x() + (i + 0.5) * step.x(), y = low.y() + (j + 0.5) * step.y();
            bool inside = true;
            for (const RegionSide& side : problem.region)
                inside = inside && side.a * x + side.b * y + side.c >= 0;
            if (!inside) continue;
            FormId best{0};
            double height = std::numeric_limits<double>::infinity();
            for (std::uint32_t k = 0; k < problem.family.size(); ++k) {
                const FormId f{k};
                const double h = problem.family.is_circular(f)
                                     ? problem.family.forms[f](x, y)
                                     : cylinder_height(problem.family.cylinder(f), x, y);
                if (h < height) {
                    height = h;
                    best = f;
                }
            }
            const double stretched = stretch(problem.family, best, {x, y, height});
            m.volume += cell_area * height;
            if (problem.sites[best].front().is_object()) m.area += cell_area * stretched;
            if (height < m.min_clearance) {
                m.min_clearance = height;
                m.min_within = 0.5 * step.norm() * std::sqrt(stretched * stretched - 1);
            }
            m.max_clearance = std::max(m.max_clearance, height);
        }
    }
    return m;
}

/// The area of the sides of the box in which rays along the base's normal leave the cell, by the midpoint
/// rule on an n x n grid of each: however steeply a side leans over the base, nothing is missed.
inline double sample_box_face_area(const Scene& scene, int n) {
    const Vec3 up = std::get<Plane>(scene.base).normal.normalized(), size = scene.box.max - scene.box.min;
    const auto in_box = [&](const Vec3& p) {
        return (p.array() >= scene.box.min.array()).all() && (p.array() <= scene.box.max.array()).all();
    };
    double area = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (up[axis] == 0) continue;
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        Vec3 p = up[axis] > 0 ? scene.box.max : scene.box.min;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                p[a] = scene.box.min[a] + (i + 0.5) / n * size[a];
                p[b] = scene.box.min[b] + (j + 0.5) / n * size[b];
                const double height = clearance(scene, p);
                if (height < 0 || !in_box(p - height * up)) continue;
                if (std::ranges::all_of(scene.objects,
                                        [&](const Object& o) { return distance_to(o, p) >= height; }))
                    area += size[a] / n * size[b] / n;
            }
    }
    return area;
}

}  // namespace vcell::testing
