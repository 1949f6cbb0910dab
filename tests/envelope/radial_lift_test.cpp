// Cells of spheres and cylinders, from scenes to patches: curves, loops, names, and the faces against brute
// force.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "../../envelope/lift/radial_lift.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../test_support.hpp"
#include "cell_checks.hpp"

using namespace vcell;
using namespace vcell::testing;

namespace {

const Sphere& base_sphere(const Scene& scene) { return std::get<Sphere>(scene.base); }

double height(const Scene& scene, const Vec3& p) { return distance_to(scene.base, p); }

// From the base's centre or axis to p.
Vec3 outwards(const Scene& scene, const Vec3& p) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.base)) return p - sphere->center;
    const auto& [point, axis, radius] = std::get<Cylinder>(scene.base);
    const Vec3 d = axis.normalized(), m = p - point;
    return m - m.dot(d) * d;
}

Cell cell_of(const Scene& scene) {
    const RadialBaseProblem problem = radial_base_problem(scene);
    const MinimizationDiagram diagram =
        problem.is_sphere
            ? lower_envelope_on_sphere(problem.family)
            : lower_envelope_on_cylinder(problem.family, problem.stretch[0], problem.stretch[1]);
    REQUIRE_FALSE(diagram.dcel.find_defect());
    Cell cell = lift(problem, diagram, 1e-7 * scene.box.diagonal()).cell;
    cell.scene = scene;
    return cell;
}

// The distance from the bisector of base and site; from the box side itself. Where a stretch ends no one
// says.
double residual(const Scene& scene, Site site, const Vec3& p) {
    if (site.kind == Site::Kind::End) return 0;
    return std::abs(distance_to(scene, site, p) - (site.is_object() ? height(scene, p) : 0));
}

double slack(const Cell& cell, const CellEdge& edge) {
    double error = 1e-12 * cell.scene.box.diagonal();
    for (const std::uint32_t v : edge.vertices) error += 4 * cell.vertices[v].error;
    return error + 2 * edge.error;
}

// Distance of two points of the surface whose parameters are rounded.
double parameter_rounding(const RationalPatch& surface, const Vec2& p) {
    const auto [du, dv] = surface.partials(p.x(), p.y());
    return 256 * 0x1p-53 * (du.norm() * std::abs(p.x()) + dv.norm() * std::abs(p.y()));
}

// Trims under their edges; loops closed, the outer one counter-clockwise and the others clockwise, seen from
// outside. Adds up how much of every edge is used in either direction, and both sides of every seam at three
// points.
void check_patch(const Cell& cell, const TrimmedPatch& patch, std::vector<std::array<double, 2>>& uses,
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

// Vertices and edges equally far from base and sites, with nothing nearer; trims under their edges; loops
// closed, the outer one counter-clockwise and the others clockwise; every edge once in each direction.
void check_cell(const Cell& cell) {
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
        if (edge.kind != CurveKind::Spline) CHECK(edge.error <= 1e-9 * length);
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

// Of the sites along the ray in a direction: the nearest, and how much further the next one is (relative).
struct Nearest {
    Site site;
    double gap;
};

Nearest nearest(const Scene& scene, const Vec3& direction) {
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

// By how often a face's boundary goes round the ray in that direction, less how often round the opposite one:
// seen from there, in stereographic projection.
int turns_around(const Cell& cell, const CellFace& face, const Vec3& direction) {
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

void check_faces_by_rays(const Cell& cell, std::mt19937_64& rng, int rays) {
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

Scene centred(double radius, double extent, std::vector<Object> objects) {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), radius};
    scene.objects = std::move(objects);
    scene.box = {Vec3::Constant(-extent), Vec3::Constant(extent)};
    return scene;
}

std::vector<CurveKind> kinds_between(const Cell& cell, Site a, Site b) {
    std::vector<CurveKind> kinds;
    for (const CellEdge& edge : cell.edges)
        if (edge.sites == std::array{a, b} || edge.sites == std::array{b, a}) kinds.push_back(edge.kind);
    return kinds;
}

}  // namespace

TEST_CASE("sphere cell: curves, trims and loops fit together in random scenes") {
    std::mt19937_64 rng(test_seed());
    SceneMaker make{rng};
    for (int i = 0; i < 60; ++i) {
        const Scene scene = make.scene(1 + i % 15, i % 3 == 0 ? 4 : i % 3 == 1 ? 20 : 100, 0.15, i % 4 == 0);
        CAPTURE(i);
        const Cell cell = cell_of(scene);
        check_cell(cell);
        check_faces_by_rays(cell, rng, 3);
    }
}

TEST_CASE("sphere cell: with cylinders") {
    std::mt19937_64 rng(test_seed());
    SceneMaker make{rng};
    for (int i = 0; i < 6; ++i) {
        Scene scene = make.scene(4, 12, 0.2, false);
        const auto& [center, radius] = base_sphere(scene);
        for (int k = 0; k < 2; ++k) {
            const Vec3 direction = make.vector(1).normalized();
            const double rho = make.number(0.1, 1);
            scene.objects.push_back(Cylinder{center + direction * (radius + rho + make.number(0.2, 1)),
                                             direction.unitOrthogonal(), rho});
        }
        CAPTURE(i);
        const Cell cell = cell_of(scene);
        check_cell(cell);
        check_faces_by_rays(cell, rng, 3);
    }
}

TEST_CASE("sphere cell: points on a cube's faces give the cube") {
    std::vector<Object> points;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-2.0, 2.0}) points.push_back(Sphere{side * Vec3::Unit(axis), 0});
    const Cell cell = cell_of(centred(0, 5, points));
    check_cell(cell);
    CHECK(cell.vertices.size() == 8);
    REQUIRE(cell.edges.size() == 12);
    for (const CellEdge& edge : cell.edges) {
        CHECK(edge.kind == CurveKind::Line);
        CHECK((edge.curve.evaluate(0) - edge.curve.evaluate(1)).norm() == doctest::Approx(2).epsilon(1e-14));
    }
    for (const CellFace& face : cell.faces) {
        CHECK(face.bisector == "plane");
        CHECK(face.patches[0].surface.degree_u == 1);
    }
}

TEST_CASE("sphere cell: a small ball between two big ones has an edge without vertices") {
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(1, 2, -2)}) {
        const Vec3 c = 4 * axis / axis.norm();
        const Cell cell = cell_of(centred(0.5, 40, {Sphere{c, 3.4}, Sphere{-c, 3.4}}));
        check_cell(cell);
        const auto between = kinds_between(cell, Site::object(0), Site::object(1));
        REQUIRE(between.size() == 1);
        CHECK(between[0] == CurveKind::Circle);
        REQUIRE(cell.edges.size() == 1);
        CHECK(cell.edges[0].vertices.empty());
        REQUIRE(cell.faces.size() == 2);
    }
}

TEST_CASE("sphere cell: an island makes a hole") {
    // A small ball before a plane: its face is an island in the plane's.
    const Cell cell = cell_of(centred(1, 6, {Plane{{0, 0, 3}, {0, 0, 1}}, Sphere{{0.1, 0, 1.6}, 0.2}}));
    check_cell(cell);
    const auto plane = std::ranges::find(cell.faces, Site::object(0), &CellFace::site);
    REQUIRE(plane != cell.faces.end());
    CHECK(plane->bisector == "paraboloid");
    CHECK(plane->patches[0].loops.size() == 2);
    const auto ball = std::ranges::find(cell.faces, Site::object(1), &CellFace::site);
    REQUIRE(ball != cell.faces.end());
    CHECK(ball->bisector == "hyperboloid");
}

TEST_CASE("sphere cell: conics by their names") {
    const auto kind = [](std::vector<Object> objects, Site a, Site b) {
        const Cell cell = cell_of(centred(1, 8, std::move(objects)));
        check_cell(cell);
        const auto kinds = kinds_between(cell, a, b);
        REQUIRE_FALSE(kinds.empty());
        for (const CurveKind k : kinds) CHECK(k == kinds.front());
        return kinds.front();
    };
    const Site first = Site::object(0), second = Site::object(1);
    const Site left = Site::box_side(0), front = Site::box_side(2), back = Site::box_side(3);
    // A paraboloid cut by the box: along its axis, across it, and in between.
    CHECK(kind({Plane{{3, 0, 0}, {1, 0, 0}}}, first, back) == CurveKind::Parabola);
    CHECK(kind({Plane{{2, 0, 0}, {1, 0, 0}}}, first, left) == CurveKind::Circle);
    CHECK(kind({Plane{{2, 0, 0}, {1, 1, 0}}}, first, front) == CurveKind::Ellipse);
    // A hyperboloid cut along its axis.
    CHECK(kind({Sphere{{3, 0, 0}, 0.5}}, first, back) == CurveKind::Hyperbola);
    // Two hyperboloids: |c|^2 is more than, equal to, less than twice delta^2.
    CHECK(kind({Sphere{{5, 5, 0}, 5.5}, Sphere{{5, -5, 0}, 5.5}}, first, second) == CurveKind::Hyperbola);
    CHECK(kind({Sphere{{5, 5, 0}, 6}, Sphere{{5, -5, 0}, 6}}, first, second) == CurveKind::Parabola);
    CHECK(kind({Sphere{{5, 5, 0}, 6.5}, Sphere{{5, -5, 0}, 6.5}}, first, second) == CurveKind::Ellipse);
    // Bisectors of equal balls are planes.
    CHECK(kind({Sphere{{3, 0, 0}, 1}, Sphere{{0, 3, 0}, 1}}, first, second) == CurveKind::Line);
    CHECK(kind({Sphere{{3, 0, 0}, 1}, Sphere{{0, 3, 0}, 0.5}}, first, second) == CurveKind::Hyperbola);
}

TEST_CASE("sphere cell: faces that reach far have one patch") {
    // The balls' faces turn almost a half sphere each before the box cuts them.
    for (const double extent : {10.0, 30.0, 100.0}) {
        const Cell cell =
            cell_of(centred(1, extent, {Sphere{{2, 0.3, 0}, 0.4}, Sphere{{-1.5, 0.1, 0.2}, 1.2}}));
        check_cell(cell);
        std::mt19937_64 rng(test_seed());
        check_faces_by_rays(cell, rng, 20);
    }
}

namespace {

// Where the generator through a base point crosses the boundary of faces of one site, above that point: odd
// within.
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

int crossings_above(const Cell& cell, const CylinderChart& chart, Site site, double angle, double height) {
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

void check_cylinder_faces(const Cell& cell, std::mt19937_64& rng, int points) {
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

Scene about_tube(const Cylinder& tube, double extent, std::vector<Object> objects) {
    Scene scene;
    scene.base = tube;
    scene.objects = std::move(objects);
    scene.box = {tube.point - Vec3::Constant(extent), tube.point + Vec3::Constant(extent)};
    return scene;
}

Cell checked(const Scene& scene, std::uint64_t salt = 0) {
    std::mt19937_64 rng(test_seed() + salt);
    const Cell cell = cell_of(scene);
    check_cell(cell);
    check_cylinder_faces(cell, rng, 12);
    return cell;
}

}  // namespace

TEST_CASE("cylinder cell: a tube alone in its box") {
    const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitZ(), 1}, 4, {}));
    CHECK(cell.faces.size() == 4);
    for (const CellEdge& edge : cell.edges) CHECK(edge.kind == CurveKind::Line);
    checked(about_tube({Vec3(1, 2, 3), Vec3(1, 2, 2), 0.5}, 6, {}));
}

TEST_CASE("cylinder cell: objects of each kind") {
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 1};
    checked(about_tube(tube, 5, {Sphere{{3, 0, 1}, 0.5}}));
    checked(about_tube(tube, 5, {Sphere{{3, 0, 1}, 1}, Sphere{{0, -3, -1}, 1.5}}));
    checked(about_tube(tube, 5, {Plane{{3, 0, 0}, {1, 0, 0}}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 0, 1}, 0.7}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 0, 1}, 1}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 1, 0.3}, 0.7}}));
    checked(about_tube(tube, 5, {Cylinder{{3, 0, 0}, {0, 1, 0.3}, 1}}));
}

TEST_CASE("cylinder cell: faces that go all around are cut along generators") {
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 0.5};
    // A plane across the axis beyond the upper end.
    const auto wraps = [](const Cell& cell, Site site) {
        const auto face = std::ranges::find(cell.faces, site, &CellFace::site);
        REQUIRE(face != cell.faces.end());
        CHECK(face->patches.size() >= 2);
        return *face;
    };
    CHECK(wraps(checked(about_tube(tube, 4, {Plane{{0, 0, 4.5}, {0.1, 0, 1}}})), Site::object(0)).bisector ==
          "elliptic cone");
    CHECK(wraps(checked(about_tube(tube, 4, {Plane{{0, 0, 4.5}, {0, 0, 1}}})), Site::object(0)).bisector ==
          "circular cone");
    CHECK(wraps(checked(about_tube(tube, 4, {Sphere{{0.1, 0, 8}, 3.7}})), Site::object(0)).bisector ==
          "quartic");
    // Axes that meet beyond the end, radii different: the singular lines of either sign of d lie on one half
    // each.
    CHECK(wraps(checked(about_tube(tube, 4, {Cylinder{{0, 0, 6}, {1, 0, 0}, 1.5}})), Site::object(0))
              .bisector == "quartic");
    CHECK(wraps(checked(about_tube(tube, 4, {Cylinder{{0, 0.2, 6}, {1, 0, 0.5}, 1.5}})), Site::object(0))
              .bisector == "quartic");
}

TEST_CASE("cylinder cell: tubes along it meet in lines") {
    for (const Vec3& axis : {Vec3(0, 1, 0), Vec3(3, 4, 0), Vec3(1, 1, 0), Vec3(-1, 0.3, 2)}) {
        CAPTURE(axis.transpose());
        const Vec3 u = axis.unitOrthogonal(), v = axis.normalized().cross(u);
        const Cell cell =
            checked(about_tube({Vec3::Zero(), axis, 0.5}, 4,
                               {Cylinder{2 * u, axis, 0.25}, Cylinder{2 * v - u, -2 * axis, 0.5},
                                Cylinder{-u - 2 * v, axis, 0.75}}));
        int lines = 0;
        for (const CellEdge& edge : cell.edges) {
            if (!edge.sites[0].is_object() || !edge.sites[1].is_object()) continue;
            CHECK(edge.kind == CurveKind::Line);
            ++lines;
        }
        CHECK(lines == 3);
        for (const CellFace& face : cell.faces)
            if (face.site.is_object())
                CHECK(face.bisector == (face.site == Site::object(1) ? "plane" : "hyperbolic cylinder"));
    }
}

TEST_CASE(
    "ball cell: a tube that reaches through the edge of two others has a face as thin as doubles hold") {
    // Around the ball the three corners of a square touch in (-1/2, -1/2, 0). The middle one, nearer by a in
    // x and y, is nearest where |z| < sqrt(2 a (1 - a) / (1 - 2 a)) on the edge of the others, (-c, -c, z), c
    // = (1 - z^2) / 2.
    for (const double radius : {0.0, 0.2})
        for (const int digits : {4, 8, 12, 20, 28, 36, 44, 60}) {
            CAPTURE(radius);
            CAPTURE(digits);
            const double a = std::ldexp(1.0, -digits);
            for (const double side : {1.0, -1.0}) {
                const auto tube = [&](double x, double y) {
                    return Cylinder{{x, y, 0}, Vec3::UnitZ(), radius};
                };
                const double corner = side * a - 1;
                if (side * a != corner + 1) continue;
                const Scene s =
                    centred(radius, 2, {tube(corner, corner), tube(-1, 0), tube(0, -1), tube(1, 1)});
                const Cell cell = cell_of(s);
                check_cell(cell);
                CHECK(cell.report.decisions.assumed == 0);
                const Site middle = Site::object(0);
                CHECK(std::ranges::count(cell.faces, middle, &CellFace::site) == (side > 0));
                int ends = 0, edges = 0;
                const double z = std::sqrt(2 * a * (1 - a) / (1 - 2 * a)), c = 0.5 * (1 - z * z);
                for (const CellVertex& v : cell.vertices) {
                    if (std::ranges::find(v.sites, middle) == v.sites.end()) continue;
                    ++ends;
                    CHECK((v.point - Vec3(-c, -c, std::copysign(z, v.point.z()))).norm() <= v.error + 1e-14);
                    CHECK(v.error < 1e-9);
                }
                for (const CellEdge& e : cell.edges) edges += e.sites[0] == middle || e.sites[1] == middle;
                CHECK(ends == 2 * (side > 0));
                CHECK(edges == 2 * (side > 0));
            }
        }
}

TEST_CASE(
    "cylinder cell: a tube that leans towards the edge of two others along it has a face as narrow as it "
    "leans") {
    // Three corners of a square meet in a line, but the middle one leans by little: it is nearest where z >
    // 0.
    for (const double radius : {0.0, 0.2})
        for (const int digits : {10, 20, 30, 38, 42}) {
            CAPTURE(radius);
            CAPTURE(digits);
            const double lean = std::ldexp(1.0, -digits);
            const auto along = [&](double x, double y) { return Cylinder{{x, y, 0}, Vec3::UnitZ(), radius}; };
            const Cell cell = cell_of(about_tube(
                {Vec3::Zero(), Vec3::UnitZ(), radius}, 2,
                {Cylinder{{-1, -1, 0}, {lean, lean, 1}, radius}, along(-1, 0), along(0, -1), along(1, 0.5)}));
            check_cell(cell);
            CHECK(cell.report.decisions.assumed == 0);
            const Site middle = Site::object(0);
            CHECK(std::ranges::count(cell.faces, middle, &CellFace::site) == 1);
            int inner = 0, on_rim = 0;
            for (const CellVertex& v : cell.vertices) {
                if (std::ranges::find(v.sites, middle) == v.sites.end()) continue;
                const bool is_end = std::abs(v.point.z()) > 1;
                (is_end ? on_rim : inner)++;
                CHECK((v.point - Vec3(-0.5, -0.5, is_end ? 2 : 0)).norm() <= v.error + 8 * lean);
            }
            CHECK(inner == 1);
            CHECK(on_rim == 2);
        }
}

TEST_CASE(
    "cylinder cell: a face all but pinched off between two others is divided where they meet, however "
    "little") {
    // Three corners of a square of balls around a tube as thick touch in (-1/2, 1/2, 0). Farther away by a in
    // x and y the middle one leaves the others the arc |z| <= sqrt(2 a (1 + a) / (1 + 2 a)) of their edge,
    // (-c, c, z), c = (1 + z^2) / 2.
    for (const double radius : {0.0, 0.25})
        for (const int digits : {4, 10, 20, 30, 36, 44}) {
            CAPTURE(radius);
            CAPTURE(digits);
            const double a = std::ldexp(1.0, -digits);
            for (const double side : {1.0, -1.0}) {
                CAPTURE(side);
                const double corner = 1 + side * a;
                const auto ball = [&](double x, double y) { return Sphere{{x, y, 0}, radius}; };
                const Cell cell =
                    cell_of(about_tube({Vec3::Zero(), Vec3::UnitZ(), radius}, 2,
                                       {ball(-corner, corner), ball(-1, 0), ball(0, 1), ball(1, -1)}));
                check_cell(cell);
                CHECK(cell.report.decisions.assumed == 0);
                const auto meet = [](const auto& sites, std::initializer_list<std::uint32_t> objects) {
                    return std::ranges::all_of(objects, [&](std::uint32_t i) {
                        return std::ranges::find(sites, Site::object(i)) != sites.end();
                    });
                };
                const double z = std::sqrt(2 * a * (1 + a) / (1 + 2 * a)), c = 0.5 * (1 + z * z);
                int ends = 0;
                for (const CellVertex& v : cell.vertices) {
                    if (!meet(v.sites, {0, 1, 2})) continue;
                    ++ends;
                    CHECK((v.point - Vec3(-c, c, std::copysign(z, v.point.z()))).norm() <= v.error + 1e-14);
                }
                CHECK(ends == 2 * (side > 0));
                CHECK(std::ranges::count_if(cell.edges, [](const CellEdge& e) {
                          return e.sites == std::array{Site::object(1), Site::object(2)} ||
                                 e.sites == std::array{Site::object(2), Site::object(1)};
                      }) == (side > 0));
            }
        }
}

TEST_CASE("cylinder cell: in lattices of tubes along it four meet in a line") {
    const std::array<std::array<Vec3, 3>, 5> lattices{
        {{Vec3(0, 0, 1), Vec3(2, 0, 0), Vec3(0, 2, 0)},
         {Vec3(0, -3, 0), Vec3(0, 0, 2), Vec3(1.5, 0, 0)},
         {Vec3(1, 1, 0), Vec3(1.5, -1.5, 0), Vec3(0, 0, 2)},
         {Vec3(1, 1, 0), Vec3(1.5, -1.5, 1.5), Vec3(1.5, -1.5, -3)},
         {Vec3(2, 3, 6), Vec3(3, -6, 2), Vec3(6, 2, -3)}}};
    for (const auto& [axis, u, v] : lattices)
        for (const double radius : {0.0, 0.5}) {
            CAPTURE(axis.transpose());
            CAPTURE(radius);
            std::vector<Object> tubes;
            for (const int i : {-1, 0, 1})
                for (const int j : {-1, 0, 1})
                    if (i != 0 || j != 0) tubes.push_back(Cylinder{i * u + j * v, axis, radius});
            const auto check_lattice = [&](const Scene& scene) {
                const Cell cell = checked(scene);
                CHECK(cell.report.decisions.assumed == 0);
                std::set<Site> extra;
                for (const CellEdge& edge : cell.edges)
                    if (!edge.extra_sites.empty()) {
                        CHECK(edge.kind == CurveKind::Line);
                        REQUIRE(edge.extra_sites.size() == 1);
                        extra.insert(edge.extra_sites.front());
                        for (const std::uint32_t w : edge.vertices)
                            CHECK(std::ranges::find(cell.vertices[w].sites, edge.extra_sites.front()) !=
                                  cell.vertices[w].sites.end());
                    }
                // The corners.
                CHECK(extra == std::set{Site::object(0), Site::object(2), Site::object(5), Site::object(7)});
            };
            check_lattice(about_tube({Vec3::Zero(), axis, radius}, 9, tubes));
            tubes.push_back(Sphere{0.625 * u + 0.125 * v, 0.25});
            check_lattice(about_tube({Vec3::Zero(), axis, radius}, 9, tubes));
        }
}

TEST_CASE("cylinder cell: in lattices with holes and rounded coordinates more tubes meet in a line") {
    const double h = 0.5 * std::numbers::sqrt3;
    const Vec3 u(0, 1, 0), v(0, 0.5, h);
    // Around u + v, the two thirds of a hexagon's corners that are left.
    for (const double radius : {0.0, 0.1}) {
        CAPTURE(radius);
        std::vector<Object> tubes;
        for (const int i : {-2, -1, 0, 1, 2})
            for (const int j : {-2, -1, 0, 1, 2})
                if ((i != 0 || j != 0) && (i != 1 || j != 0))
                    tubes.push_back(Cylinder{i * u + j * v, Vec3::UnitX(), radius});
        const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitX(), radius}, 4, tubes));
        std::size_t most = 0;
        for (const CellEdge& edge : cell.edges) most = std::max(most, edge.extra_sites.size());
        CHECK(most == 3);  // five tubes and the base on a circle about the hole
        CHECK(cell.report.decisions.assumed == 1);
        REQUIRE(cell.report.warnings.size() == 1);
        CHECK(cell.report.warnings[0].find("taken to meet in one line through") != std::string::npos);
    }
    // The directions in which four tubes of a square lattice tie with the hole at one of them.
    std::vector<Object> square;
    for (const int i : {-2, -1, 0, 1, 2})
        for (const int j : {-2, -1, 0, 1, 2})
            if ((i != 0 || j != 0) && (i != 1 || j != 0) && (i != 0 || j != 1))
                square.push_back(Cylinder{{double(i), 0, double(j)}, Vec3::UnitY(), 0.25});
    const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitY(), 0.25}, 4, square));
    CHECK(cell.report.decisions.assumed == 0);
}

TEST_CASE("cylinder cell: a line into corners, edges and sides of the box, and planes through its ends") {
    const auto wall = [](int k, double at) { return Plane{at * Vec3::Unit(k), Vec3::Unit(k)}; };
    for (const Vec3& axis :
         {Vec3(1, 1, 1), Vec3(-1, 1, 1), Vec3(1, 2, 2), Vec3(3, 1, 3), Vec3(1, 1, 0), Vec3(1, 2, 3)})
        for (const double radius : {0.0, 1e-12, 1e-6, 1e-3}) {
            CAPTURE(axis.transpose());
            CAPTURE(radius);
            const Cell cell = checked(about_tube({Vec3::Zero(), axis, radius}, 1, {}));
            CHECK(cell.faces.size() == 6);
            CHECK(cell.report.decisions.assumed == 0);
            for (const CellEdge& edge : cell.edges) CHECK(edge.kind == CurveKind::Line);
            // The sides where it ends, as planes too. (In (1, 1, 0) a side touches the edge between them.)
            if (radius > 0 || axis.z() == 0) continue;
            int k = 0;
            axis.cwiseAbs().maxCoeff(&k);
            const Cell walled = checked(about_tube({Vec3::Zero(), axis, 0}, 1, {wall(k, 1), wall(k, -1)}));
            CHECK(std::ranges::count_if(walled.faces, [](const CellFace& f) { return f.site.is_object(); }) ==
                  2);
            for (const CellEdge& edge : walled.edges) {
                CHECK(edge.kind != CurveKind::Spline);
                CHECK(edge.error <= 1e-11);
            }
        }
    // Past a corner by little, with a plane through it: cones whose tips all but agree meet in hyperbolas.
    for (const double past : {1e-3, 1e-6, 1e-9, 1e-12}) {
        CAPTURE(past);
        const Cell cell = checked(about_tube({Vec3::Zero(), {1, 1 - past, 1 + past / 3}, 0}, 1,
                                             {Plane{{1, 1, 1}, {1, 0.3, 0}}, wall(2, -1)}));
        CHECK(cell.report.decisions.assumed == 0);
        for (const CellEdge& edge : cell.edges) CHECK(edge.kind != CurveKind::Spline);
    }
    // In a corner of planes the cones about the line meet in lines through it.
    const Cell corner =
        checked(about_tube({Vec3::Zero(), {1, 1, 1}, 0}, 1, {wall(0, 1), wall(1, 1), wall(2, 1)}));
    int lines = 0;
    for (const CellEdge& edge : corner.edges) {
        CHECK(edge.kind != CurveKind::Spline);
        if (edge.sites[0].is_object() && edge.sites[1].is_object()) lines += edge.kind == CurveKind::Line;
    }
    CHECK(lines == 3);
    checked(about_tube({Vec3::Zero(), {1, 1, 1}, 0}, 1,
                       {Sphere{{0.5, 0, 0}, 0.1}, Cylinder{{0, 0.5, -0.5}, {1, 0, 0}, 0.05},
                        Plane{{1, 1, 1}, {1, -1, 0.5}}}));
}

TEST_CASE("cylinder cell: planes, sides of the box and tubes along it meet in conics, exactly") {
    const auto kind = [](const Cell& cell, Site f, Site g) {
        std::optional<CurveKind> found;
        for (const CellEdge& edge : cell.edges) {
            CHECK(edge.kind != CurveKind::Spline);
            CHECK(edge.error <= 1e-11);
            if ((edge.sites[0] == f && edge.sites[1] == g) || (edge.sites[0] == g && edge.sites[1] == f))
                found = edge.kind;
        }
        REQUIRE(found);
        return *found;
    };
    const Site first = Site::object(0), second = Site::object(1), top = Site::end(1);
    const Cylinder tube{Vec3::Zero(), {0, 0, 1}, 0.5};
    const auto plane = [](double x, double y, double rise) {
        return Plane{{2 * x, 2 * y, 0}, {-x, -y, rise}};
    };
    Cell cell = checked(about_tube(tube, 3, {plane(1, 0, 0.125), plane(0, 1, -0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Ellipse);
    cell = checked(about_tube(tube, 3, {plane(1, 0, 0.125), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Hyperbola);
    CHECK(kind(cell, first, top) == CurveKind::Ellipse);
    CHECK(kind(cell, first, Site::box_side(2)) == CurveKind::Hyperbola);
    // Cones with one apex; planes along the axis; a plane across it, all around and beside a tube.
    cell = checked(about_tube(tube, 3, {plane(1, 0, 0.25), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Line);
    cell = checked(about_tube(tube, 3, {plane(1, 0, 0), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, top) == CurveKind::Parabola);
    // The length of a normal need not be a double for a parabola to be one.
    cell = checked(about_tube(tube, 3, {plane(1, 1, 0), plane(-1, 0, 0.25)}));
    CHECK(kind(cell, first, top) == CurveKind::Parabola);
    cell = checked(about_tube(tube, 3, {plane(1, 1, 0), plane(0, 1, 0.25)}));
    CHECK(kind(cell, first, second) == CurveKind::Parabola);
    cell = checked(about_tube(tube, 3, {Plane{{0, 0, 4}, {0, 0, 1}}}));
    CHECK(kind(cell, first, top) == CurveKind::Circle);
    cell = checked(about_tube(tube, 3, {Plane{{0, 0, 4}, {0, 0, 1}}, Cylinder{{2, 0, 0}, {0, 0, 1}, 0.25}}));
    CHECK(kind(cell, first, second) == CurveKind::Hyperbola);
    CHECK(kind(cell, second, top) == CurveKind::Hyperbola);
    // All around in sectors, tilted, around a line.
    for (const Vec3& axis : {Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(-1, 0.3, 2)})
        for (const double radius : {0.0, 0.5}) {
            CAPTURE(axis.transpose());
            const Vec3 u = axis.unitOrthogonal(), v = axis.normalized().cross(u), w = axis.normalized();
            kind(checked(about_tube({Vec3::Zero(), axis, radius}, 4,
                                    {Plane{2 * u, u + 0.25 * w}, Cylinder{-2 * u - v, axis, 0.5},
                                     Plane{1.5 * v, v - 0.125 * w}})),
                 first, second);
        }
}

TEST_CASE("cylinder cell: crossing axes of equal radius have planes for bisectors") {
    const Cell cell =
        checked(about_tube({Vec3::Zero(), Vec3::UnitZ(), 0.5}, 4, {Cylinder{{0, 0, 6}, {1, 0, 1}, 0.5}}));
    for (const CellFace& face : cell.faces)
        if (face.site.is_object()) CHECK(face.bisector == "plane");
}

TEST_CASE("cells: among tubes of one radius that cross") {
    const Vec3 crossing(0, 2, -2);
    const Cylinder along_x{crossing, {1, 0, 0}, 0.25}, oblique{crossing, {0, 1, 1}, 0.25},
        third{crossing, {1, 1, 1}, 0.25};
    const auto has_node = [](const Cell& cell, std::size_t tubes) {
        const auto is_node = [&](const CellVertex& v) { return v.sites.size() == tubes; };
        CHECK(std::ranges::any_of(cell.vertices, is_node));
        for (const CellEdge& edge : cell.edges) CHECK(edge.error <= 4e-6);
        CHECK(cell.report.decisions.assumed == 0);
    };
    std::mt19937_64 rng(test_seed());
    // Once the line across the axes runs through the base's centre, or along a normal of its axis.
    Scene ball = centred(0.5, 4, {along_x, oblique});
    Cell cell = cell_of(ball);
    check_cell(cell);
    check_faces_by_rays(cell, rng, 3);
    has_node(cell, 2);
    std::get<Sphere>(ball.base).center.x() = 0.1;
    ball.objects.push_back(third);
    cell = cell_of(ball);
    check_cell(cell);
    check_faces_by_rays(cell, rng, 3);
    has_node(cell, 3);
    for (const Cylinder& tube :
         {Cylinder{Vec3::Zero(), {1, 0, 0}, 0.5}, Cylinder{Vec3::Zero(), {1, 2, 2}, 0.5},
          Cylinder{Vec3::Zero(), {-2, 1, 3}, 0.5}, Cylinder{{0.1, 0.2, 0.3}, {1, 3, 1}, 0.25}})
        has_node(checked(about_tube(tube, 4, {along_x, oblique})), 2);
    // Two pairs that cross, tilted.
    has_node(checked(about_tube({Vec3::Zero(), {1, 1, 0}, 0.5}, 3,
                                {Cylinder{{2, 0, 3}, {0, 0, -1}, 0.25}, Cylinder{{2, 1, 2}, {-1, 1, 1}, 0.25},
                                 Cylinder{{3, 0, 1}, {-1, 0, -1}, 0.25}})),
             2);
    // One of them along a tilted base.
    has_node(checked(about_tube(
                 {Vec3::Zero(), {1, 1, 0}, 0.25}, 7,
                 {Cylinder{{3, -3, 1.5}, {-2, -2, 0}, 0.25}, Cylinder{{1, 1, 1.5}, {-2, 1, 0}, 0.25}})),
             2);
    // Lines along the axis and across it.
    has_node(checked(about_tube({Vec3::Zero(), {1, 0, 0}, 0.5}, 3,
                                {Cylinder{{-2, 1, -1}, {-1, 0, 0}, 0}, Cylinder{{0, 1, -1}, {0, 1, 0}, 0}})),
             2);
}

TEST_CASE("cells: among tubes of one radius that cross but for rounding") {
    // Edges turn from one plane between the axes to the other within 1e-8; doubles lose them within 1e-6.
    const Eigen::Matrix3d turn = Eigen::Quaterniond(0.8, 0.3, -0.4, 0.33).normalized().toRotationMatrix();
    const std::vector<Object> tubes{Cylinder{turn * Vec3(-2, 1, -1), turn * Vec3(-1, 0, 0), 0.25},
                                    Cylinder{turn * Vec3(0, 1, -1), turn * Vec3(0, 1, 0), 0.25}};
    const Cell of_tube = checked(about_tube({Vec3::Zero(), turn * Vec3(1, 0, 0), 0.5}, 4, tubes));
    const Cell of_ball = cell_of(centred(0.5, 4, tubes));
    check_cell(of_ball);
    for (const Cell* cell : {&of_tube, &of_ball})
        for (const CellEdge& edge : cell->edges) CHECK(edge.error <= 1e-3);
}

TEST_CASE("cells: what touches an edge of two others is a vertex of it") {
    const Cylinder left{{-1, 0, 1}, {0, 1, 0}, 0}, right{{1, 0, 1}, {0, 1, 0}, 0};
    const auto scene = [&](const Object& base, double z) {
        Scene s = std::holds_alternative<Sphere>(base)
                      ? centred(0, 4, {left, right})
                      : about_tube(std::get<Cylinder>(base), 4, {left, right});
        s.base = base;
        s.objects.push_back(Sphere{{0, 0.25, z}, 0});
        return s;
    };
    std::mt19937_64 rng(test_seed());
    const auto checked_cell = [&](const Scene& s) {
        const Cell cell = cell_of(s);
        check_cell(cell);
        if (std::holds_alternative<Sphere>(s.base))
            check_faces_by_rays(cell, rng, 3);
        else
            check_cylinder_faces(cell, rng, 12);
        return cell;
    };
    const Site third = Site::object(2);
    for (const Object& base :
         {Object(Cylinder{Vec3::Zero(), {0, 1, 0}, 0}), Object(Sphere{{0, 0.25, 0}, 0})}) {
        CAPTURE(base.index());
        for (const double lift : {-1e-3, 0.0, 1e-3}) {
            CAPTURE(lift);
            const Cell cell = checked_cell(scene(base, 2 + lift));
            CHECK(std::ranges::count(cell.faces, third, &CellFace::site) == (lift < 0));
            const auto meets = std::ranges::count_if(cell.vertices, [&](const CellVertex& v) {
                return std::ranges::find(v.sites, third) != v.sites.end();
            });
            CHECK((lift < 0 ? meets >= 2 : meets == (lift == 0)));
            CHECK(cell.report.decisions.assumed == 0);
            if (lift != 0) continue;
            const auto vertex = std::ranges::find_if(cell.vertices, [&](const CellVertex& v) {
                return std::ranges::find(v.sites, third) != v.sites.end();
            });
            CHECK(vertex->sites.size() == 3);
            CHECK((vertex->point - Vec3(0, 0.25, 1)).norm() <= vertex->error + 1e-15);
            CHECK(vertex->error <= 1e-7);
        }
    }
}

TEST_CASE("cylinder cell: axes that are all but parallel") {
    const Cylinder tube{Vec3::Zero(), Vec3::UnitZ(), 0.5};
    for (const double slope : {1e-3, 1e-6, 1e-9}) {
        CAPTURE(slope);
        // Axes that pass nearer to each other than |delta|, far beyond the ends.
        checked(about_tube(tube, 4, {Cylinder{{1.5, 0, 0}, {slope, 0.01 * slope, -1}, 0.7}}));
        checked(about_tube(
            tube, 4,
            {Cylinder{{1.5, 0, 0}, {slope, 0, 1}, 0.5}, Cylinder{{0, -2, 0}, {slope, -slope, 1}, 0.3}}));
    }
}

TEST_CASE("cylinder cell: vertices are known to rounding at every scale") {
    for (const double scale : {1e-6, 1.0, 1e6}) {
        CAPTURE(scale);
        const Cell cell = checked(about_tube({Vec3::Zero(), Vec3::UnitZ(), 0.5 * scale}, 4 * scale,
                                             {Cylinder{scale * Vec3(1.5, 0, 0), {1, 2, 3}, 0.3 * scale},
                                              Cylinder{scale * Vec3(-1, 1, 0.5), {1, 1, 0.5}, 0.25 * scale},
                                              Sphere{scale * Vec3(0.5, -2, 1), scale}}));
        for (const CellVertex& v : cell.vertices) CHECK(v.error <= 4e-12 * scale);
    }
}

TEST_CASE("cylinder cell: arcs that turn beside a seam, and vertices on one") {
    Scene turning;
    turning.base = Cylinder{{-0.05, 0.63, 0.92}, {-0.4591667997360513, 0.5912304283554172, 0.663}, 0.3};
    turning.objects = {Cylinder{{0.27, 0.76, -0.12}, {-0.8, 0.23518019618049804, 0.4835843489437807}, 0},
                       Sphere{{0.6, 0.8, 0.4}, 0.1}, Plane{{1, -0.2, 2.3}, {0.53, -0.4, 0.7}}};
    turning.box = {{-3, -2.5, -2.3}, {3.1, 3.9, 4}};
    checked(turning);
    Scene meeting;
    meeting.base = Cylinder{{-0.7, 0.1, -0.48}, {0, 1, 0}, 0.48};
    meeting.objects = {Cylinder{{-0.8, 0.6, -1.3}, {0.84, -0.3, -0.464}, 0.1}};
    meeting.box = {{-3.662, -3, -3.7}, {2.4, 3.4, 2.6}};
    checked(meeting);
}

// The default tolerance is 7e-7 here, which is not far below the cells' size.
TEST_CASE("cells: curves are fine as the cell, however large its box") {
    constexpr double size = 1e-6;
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0};
    scene.box = {{-2, -2, -2}, {2, 2, 2}};
    for (const auto& [place, axis] :
         std::initializer_list<std::pair<Vec3, Vec3>>{{{1, 0.2, 0.1}, {0.1, 1, 0.3}},
                                                      {{-1, 0.3, -0.2}, {0.2, -0.4, 1}},
                                                      {{0.1, 1, 0.3}, {1, 0.1, 0.7}},
                                                      {{0.2, -1, -0.1}, {0.5, 0.2, 1}},
                                                      {{-0.2, 0.1, 1}, {1, 1, 0.2}},
                                                      {{0.3, -0.1, -1}, {1, -0.8, 0.1}}})
        scene.objects.push_back(Cylinder{size * place, axis, 0});
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.edges.size() == 12);
    for (const CellEdge& e : cell.edges) CHECK(e.error < 1e-3 * size);
}

TEST_CASE("cylinder cell: random scenes") {
    std::mt19937_64 rng(test_seed());
    SceneMaker make{rng};
    for (int i = 0; i < 6; ++i) {
        CAPTURE(i);
        const Cylinder tube{make.vector(2), make.vector(1), make.number(0.3, 1)};
        std::vector<Object> objects;
        const Vec3 axis = tube.axis.normalized();
        for (int k = 0; k < 5; ++k) {
            Vec3 side = make.vector(1);
            side = (side - side.dot(axis) * axis).normalized();
            const double rho = make.number(0.1, 1.2);
            const Vec3 at =
                tube.point + axis * make.number(-3, 3) + side * (tube.radius + rho + make.number(0.2, 2));
            if (k % 2 == 0)
                objects.push_back(Cylinder{at, side.cross(make.vector(1)), rho});
            else
                objects.push_back(Sphere{at, rho});
        }
        checked(about_tube(tube, 6, objects), i);
    }
}
