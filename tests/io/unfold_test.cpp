#include "../../io/pictures/unfold.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "test_support.hpp"

using namespace vcell;

namespace {

/// Even-odd.
bool holds(const std::vector<Unfolding::Polyline>& polygons, const Vec2& p) {
    bool result = false;
    for (const auto& polygon : polygons)
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
            if ((a.y() > p.y()) == (b.y() > p.y())) continue;
            if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) result = !result;
        }
    return result;
}

/// The direction that a point of a cube's square stands for, by the cross's layout.
Vec3 direction(const std::string& side, const Vec2& p) {
    if (side == "+x") return {1, p.y(), -p.x()};
    if (side == "-x") return {-1, p.y(), p.x()};
    if (side == "+z") return {p.x(), p.y(), 1};
    if (side == "-z") return {-p.x(), p.y(), -1};
    return side == "+y" ? Vec3(p.x(), 1, -p.y()) : Vec3(p.x(), -1, p.y());
}

double clearance(const Scene& scene, const Object& object, const Vec3& foot, const Vec3& normal,
                 double start) {
    const auto excess = [&](double t) {
        const Vec3 p = foot + t * normal;
        if (const auto* s = std::get_if<Sphere>(&object)) return (p - s->center).norm() - s->radius - t;
        if (const auto* c = std::get_if<Cylinder>(&object))
            return (p - c->point).cross(c->axis.normalized()).norm() - c->radius - t;
        const auto& plane = std::get<Plane>(object);
        return std::abs(plane.normal.normalized().dot(p - plane.point)) - t;
    };
    double lo = start, hi = scene.box.diagonal();
    if (excess(hi) > 0) return hi;
    for (int k = 0; k < 60; ++k) (excess(0.5 * (lo + hi)) > 0 ? lo : hi) = 0.5 * (lo + hi);
    return hi;
}

double exit_of_box(const Box& box, const Vec3& p, const Vec3& d) {
    double t = HUGE_VAL;
    for (int k = 0; k < 3; ++k)
        if (d[k] != 0) t = std::min(t, ((d[k] > 0 ? box.max : box.min)[k] - p[k]) / d[k]);
    return t;
}

}  // namespace

TEST_CASE("unfold: points of the cube's squares lie in the face of the nearest site, and in no other") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const std::string name :
         {"figure7", "figure8", "octahedron", "cube", "between", "two_balls_plane"}) {
        CAPTURE(name);
        const Scene scene = read_scene(VCELL_EXAMPLE_SCENES "/" + name + ".json");
        const Cell cell = voronoi_cell(scene);
        const Unfolding picture = unfold(cell);
        REQUIRE(picture.panels.size() == 6);
        REQUIRE(picture.faces.size() == cell.faces.size());
        const auto& base = std::get<Sphere>(scene.base);
        for (const auto& panel : picture.panels)
            for (int k = 0; k < 100; ++k) {
                const Vec2 q(unit(rng), unit(rng));
                const Vec3 u = direction(panel.name, q).normalized(), foot = base.center + base.radius * u;
                double least = exit_of_box(scene.box, foot, u), second = HUGE_VAL;
                std::optional<std::uint32_t> owner;
                for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
                    const double t = clearance(scene, scene.objects[i], foot, u, -base.radius);
                    second = std::min(second, std::max(t, least));
                    if (t < least) owner = i, least = t;
                }
                if (second - least < 1e-3) continue;  // too near to an edge for polylines
                const Vec2 p = 0.5 * (panel.low + panel.high) + q;
                int count = 0;
                for (std::size_t f = 0; f < cell.faces.size(); ++f) {
                    if (!holds(picture.faces[f], p)) continue;
                    ++count;
                    const Site site = cell.faces[f].site;
                    CHECK(site.is_object() == owner.has_value());
                    if (owner) CHECK(site.index == *owner);
                }
                CHECK(count == 1);
            }
    }
}

TEST_CASE("unfold: faces fill the cube's squares, and edges end in their vertices") {
    for (const std::string name : {"four_balls_two_planes", "octahedron", "icosahedron", "flat"}) {
        CAPTURE(name);
        const Cell cell = voronoi_cell(read_scene(VCELL_EXAMPLE_SCENES "/" + name + ".json"));
        const Unfolding picture = unfold(cell);
        for (const auto& polygons : picture.faces)
            for (const auto& polygon : polygons)
                for (const Vec2& p : polygon)
                    CHECK(std::ranges::any_of(picture.panels, [&](const Unfolding::Panel& panel) {
                        return (p - panel.low).minCoeff() > -1e-12 && (panel.high - p).minCoeff() > -1e-12;
                    }));
        REQUIRE(picture.edges.size() == cell.edges.size());
        REQUIRE(picture.vertices.size() == cell.vertices.size());
        for (std::size_t e = 0; e < cell.edges.size(); ++e) {
            CHECK(!picture.edges[e].empty());
            for (const std::uint32_t v : cell.edges[e].vertices) {
                const Vec2& p = picture.vertices[v];
                double nearest = HUGE_VAL;
                for (const auto& line : picture.edges[e])
                    nearest = std::min({nearest, (line.front() - p).norm(), (line.back() - p).norm()});
                // A vertex where squares meet is drawn in one of them, edges may end in others.
                const bool on_border =
                    std::ranges::any_of(picture.panels, [&](const Unfolding::Panel& panel) {
                        return (p - panel.low).cwiseAbs().minCoeff() < 1e-9 ||
                               (panel.high - p).cwiseAbs().minCoeff() < 1e-9;
                    });
                CHECK((on_border || nearest < 1e-9));
            }
        }
    }
}

TEST_CASE(
    "unfold: points of the strips around a cylinder lie in the face of the nearest site, and in no other") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Scene> scenes;
    for (const std::string name : {"figure10", "tube_three_balls_plane", "three_tubes", "bundle"})
        scenes.push_back(read_scene(VCELL_EXAMPLE_SCENES "/" + name + ".json"));
    // Planes, whose edges are straight in space and not in the picture.
    Scene& net = scenes.emplace_back();
    net.base = Cylinder{Vec3::Zero(), {0, 0, 1}, 0.25};
    net.objects = {Cylinder{Vec3::Zero(), {4, 2, 1}, 0.25}, Cylinder{{0, 0, 2}, {1, 4, 0}, 0.25}};
    net.box = {Vec3::Constant(-3), Vec3::Constant(3)};
    for (const Scene& scene : scenes) {
        const Cell cell = voronoi_cell(scene);
        const Unfolding picture = unfold(cell);
        REQUIRE(picture.panels.size() == 4);
        const BaseFrame frame = radial_base_problem(base_alone(scene)).frame;
        const double radius = std::get<Cylinder>(scene.base).radius;
        const std::array<std::string, 4> sides{"-x", "+z", "+x", "-z"};  // canonical axes
        for (std::size_t s = 0; s < sides.size(); ++s) {
            const Unfolding::Panel& panel = picture.panels[s];
            // Panels are named after where they point in the world.
            const Vec3 out = frame.rotation.transpose() * direction(sides[s], Vec2::Zero());
            const bool is_axis = panel.name[0] != '(';
            CHECK((is_axis || !frame.is_axis_parallel()));
            if (is_axis) CHECK((direction(panel.name, Vec2::Zero()) - out).norm() < 0.1);
            for (int k = 0; k < 100; ++k) {
                const Vec2 middle = 0.5 * (panel.low + panel.high), half = 0.5 * (panel.high - panel.low);
                const Vec2 q(unit(rng), unit(rng)), p = middle + q.cwiseProduct(half);
                Vec3 across = direction(sides[s], {q.x(), 0});
                across.normalize();
                const Vec3 u = frame.rotation.transpose() * across;
                const Vec3 foot = frame.to_world(Vec3(0, p.y(), 0) + radius * across);
                double least = exit_of_box(scene.box, foot, u), second = HUGE_VAL;
                std::optional<std::uint32_t> owner;
                for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
                    const double t = clearance(scene, scene.objects[i], foot, u, -radius);
                    second = std::min(second, std::max(t, least));
                    if (t < least) owner = i, least = t;
                }
                if (second - least < 1e-3) continue;  // too near to an edge for polylines
                int count = 0;
                for (std::size_t f = 0; f < cell.faces.size(); ++f) {
                    if (!holds(picture.faces[f], p)) continue;
                    ++count;
                    const Site site = cell.faces[f].site;
                    CHECK(site.is_object() == owner.has_value());
                    if (owner) CHECK(site.index == *owner);
                }
                CHECK(count == 1);
            }
        }
    }
}
