/// Faces of hollow tubes and cones that reach around the vessel's axis, in patches about it.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "radial_cell_checks.hpp"
#include "vessel_oracle.hpp"

namespace vcell::vessel_faces_test {
namespace {

using vessel_oracle::away;
using vessel_oracle::pi;

// ---- Closed forms ---------------------------------------------------------------------------------------

// Looks at all of a patch's rectangle.
double area_of(const RationalPatch& s) {
    constexpr int parts = 400;
    double sum = 0;
    for (int i = 0; i < parts; ++i)
        for (int k = 0; k < parts; ++k) {
            const auto [du, dv] = s.partials(std::lerp(s.domain_u[0], s.domain_u[1], (i + 0.5) / parts),
                                             std::lerp(s.domain_v[0], s.domain_v[1], (k + 0.5) / parts));
            sum += du.cross(dv).norm();
        }
    return sum * (s.domain_u[1] - s.domain_u[0]) * (s.domain_v[1] - s.domain_v[0]) / (parts * parts);
}

const CellFace& face_of(const Cell& cell, Site site) {
    const auto face = std::ranges::find(cell.faces, site, &CellFace::site);
    REQUIRE(face != cell.faces.end());
    return *face;
}

TEST_CASE("vessel faces: about a ball on the axis of a tube three patches are all around") {
    const double D = 2.5, h = 1.5;
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.5};
    scene.objects = {HollowCylinder{{0, 0, 7}, {0, 0, 2}, 2}};
    scene.box = {{-4, -4, -h}, {4, 4, h}};
    const Cell cell = voronoi_cell(scene);
    radial_cells::check_cell(cell);
    const CellFace& face = face_of(cell, Site::object(0));
    REQUIRE(face.patches.size() == 3);
    // At z the face is r = (D^2 - z^2) / (2 D) away from the axis, and r' = -z / D: by Simpson's rule.
    double area = 0, of_patches = 0;
    constexpr int parts = 400;
    for (int i = 0; i <= parts; ++i) {
        const double z = -h + 2 * h * i / parts, r = (D * D - z * z) / (2 * D);
        area += 2 * pi * r * std::hypot(1, z / D) * (i == 0 || i == parts ? 1 : i % 2 == 1 ? 4 : 2);
    }
    area *= 2 * h / parts / 3;
    for (const TrimmedPatch& patch : face.patches) {
        CHECK(patch.loops.size() == 1);
        CHECK(patch.surface.degree_u == 2);
        of_patches += area_of(patch.surface);
    }
    CHECK(of_patches == doctest::Approx(area).epsilon(1e-5));
    CHECK(face.area == doctest::Approx(area).epsilon(1e-9));
}

// ---- Random ones ----------------------------------------------------------------------------------------

// Angles about a vessel's axis, and lengths along its wall.
struct VesselChart {
    Vec3 point, w, x, y;
    double sine = 0, cosine = 1;

    explicit VesselChart(const Object& vessel) {
        if (const auto* tube = std::get_if<HollowCylinder>(&vessel)) {
            point = tube->point;
            w = tube->axis.normalized();
        } else {
            const auto& cone = std::get<HollowCone>(vessel);
            point = cone.apex;
            w = cone.axis.normalized();
            sine = cone.radius / cone.slant;
            cosine = std::sqrt(1 - sine * sine);
        }
        x = w.unitOrthogonal();
        y = w.cross(x);
    }
    double angle(const Vec3& p) const { return std::atan2(y.dot(p - point), x.dot(p - point)); }
    double along(const Vec3& p) const { return cosine * w.dot(p - point) + sine * w.cross(p - point).norm(); }
};

// How many patches of a site's faces hold a point of the bisector: by the crossings of their loops with the
// half plane from the axis through the point, above the point.
int patches_at(const Cell& cell, Site site, const VesselChart& chart, const Vec3& p) {
    constexpr int steps = 64;
    constexpr double widest = 2.2;  // of a sector, and more
    int count = 0;
    for (const CellFace& face : cell.faces) {
        if (face.site != site) continue;
        const bool is_cut = face.patches.size() > 1;
        for (const TrimmedPatch& patch : face.patches) {
            int crossings = 0;
            bool is_aside = false;
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop) {
                    double last = 0, last_along = 0;
                    for (int k = 0; k <= steps; ++k) {
                        const double t =
                            std::lerp(trim.curve.domain_begin(), trim.curve.domain_end(), double(k) / steps);
                        const Vec2 uv = trim.curve.evaluate(t);
                        const Vec3 q = patch.surface.evaluate(uv.x(), uv.y());
                        const double off = std::remainder(chart.angle(q) - chart.angle(p), 2 * pi),
                                     along = chart.along(q);
                        is_aside = is_aside || (is_cut && std::abs(off) > widest);
                        if (k > 0 && (last > 0) != (off > 0) && std::abs(last - off) < pi &&
                            last_along + (along - last_along) * last / (last - off) > chart.along(p))
                            ++crossings;
                        last = off;
                        last_along = along;
                    }
                }
            if (!is_aside) count += crossings % 2;
        }
    }
    return count;
}

// Points of the wall's bisector are in one patch where it shows, and in none elsewhere. Returns how many
// showed.
int check_patches_by_rays(const Cell& cell, Site wall, std::mt19937_64& rng, int rays) {
    const Scene& scene = cell.scene;
    const auto& base = std::get<Sphere>(scene.base);
    const Object& vessel = scene.objects[wall.index];
    const VesselChart chart(vessel);
    std::normal_distribution<double> normal;
    int shown = 0;
    for (int i = 0; i < rays; ++i) {
        const Vec3 u = Vec3(normal(rng), normal(rng), normal(rng)).normalized();
        double low = base.radius, high = 1e3;
        for (int k = 0; k < 60; ++k) {
            const double t = 0.5 * (low + high);
            (away(vessel, base.center + t * u) > t - base.radius ? low : high) = t;
        }
        const Vec3 p = base.center + low * u;
        double room = vessel_oracle::inside_box(scene.box, p);
        for (const Object& o : scene.objects)
            if (&o != &vessel) room = std::min(room, away(o, p) - (low - base.radius));
        if (std::abs(room) < 0.02) continue;
        CHECK(patches_at(cell, wall, chart, p) == (room > 0 ? 1 : 0));
        shown += room > 0;
    }
    return shown;
}

// The cell of the first ball among the others, in a vessel.
Scene scene_of(const std::vector<Sphere>& balls, const Object& wall) {
    Scene scene;
    scene.base = balls[0];
    scene.objects.assign(balls.begin() + 1, balls.end());
    scene.objects.push_back(wall);
    scene.box = {Vec3::Zero(), Vec3::Constant(8)};
    return scene;
}

// A few balls that do not overlap in a tube or cone about the middle of the box, with numbers of a sort.
struct FewBalls {
    std::mt19937_64& rng;
    bool in_integers;

    double number(int from, int to) {
        if (in_integers) return std::uniform_int_distribution(from, to)(rng);
        return std::uniform_real_distribution<double>(from, to)(rng);
    }
    Vec3 vector(int from, int to) {
        const double x = number(from, to), y = number(from, to), z = number(from, to);
        return {x, y, z};
    }
    Object vessel(bool is_cone) {
        const Vec3 axis(number(-1, 1), number(-1, 1), 2), point = vector(3, 5);
        if (is_cone) return HollowCone{point - 3 * axis, axis, 3, 5};
        return HollowCylinder{point, axis, number(2, 4)};
    }
    std::optional<Scene> scene(bool is_cone) {
        const Object wall = vessel(is_cone);
        std::vector<Sphere> balls;
        for (int tries = 0; balls.size() < 5 && tries < 400; ++tries) {
            const Sphere ball{vector(1, 7), 0.25 * number(1, 3)};
            if (away(wall, ball.center) < 1.01 * ball.radius) continue;
            if (std::ranges::all_of(
                    balls, [&](const Sphere& o) { return away(o, ball.center) > 1.01 * ball.radius; }))
                balls.push_back(ball);
        }
        if (balls.size() < 3) return std::nullopt;
        return scene_of(balls, wall);
    }
};

// None: its cell has a tip, or small integers tie along a curve.
std::optional<Cell> cell_if_any(const Scene& scene) {
    try {
        return voronoi_cell(scene);
    } catch (const InputError& e) {
        CHECK(e.kind == InputError::Kind::Unsupported);
    } catch (const UndecidedError& e) {
        CHECK(std::string(e.what()).find("equally near along a curve") != std::string::npos);
    }
    return std::nullopt;
}

TEST_CASE("vessel faces: around the axis of a tube or a cone one patch holds each point") {
    std::mt19937_64 rng(test_seed());
    int around = 0, shown = 0;
    for (int round = 0; round < 40 * rounds(); ++round) {
        CAPTURE(round);
        const auto scene = FewBalls{rng, round % 2 == 0}.scene(round % 4 >= 2);
        if (!scene) continue;
        const auto cell = cell_if_any(*scene);
        if (!cell) continue;
        radial_cells::check_cell(*cell);
        const Site wall = Site::object(static_cast<std::uint32_t>(scene->objects.size() - 1));
        for (const CellFace& face : cell->faces) around += face.site == wall && face.patches.size() > 1;
        shown += check_patches_by_rays(*cell, wall, rng, 40);
        vessel_oracle::check_vertices(*cell);
    }
    CHECK(around > 2);
    CHECK(shown > 40);
}

// From any direction that such a face leaves to others it reaches far around: weights of control points are
// positive in a high degree.
TEST_CASE("vessel faces: of a sphere that few balls share one patch reaches far around") {
    for (const Scene& scene :
         {scene_of({{{5, 2, 5}, 1}, {{6, 6, 3}, 0.25}, {{2, 3, 1}, 0.5}, {{6, 1, 5}, 0.25}},
                   HollowSphere{{3, 3, 5}, 6}),
          scene_of({{{4, 4, 3}, 1}, {{4, 5, 7}, 0.25}, {{2, 3, 5}, 0.5}, {{1, 4, 2}, 0.25}},
                   HollowSphere{{4, 5, 4}, 4})}) {
        const Cell cell = voronoi_cell(scene);
        vessel_oracle::check_volume(scene, cell);
        vessel_oracle::check_vertices(cell);
        std::vector<std::array<double, 2>> uses(cell.edges.size(), {0, 0});
        std::map<std::uint32_t, std::vector<std::array<Vec3, 3>>> seams;
        for (const CellFace& of_cell : cell.faces)
            for (const TrimmedPatch& patch : of_cell.patches)
                radial_cells::check_patch(cell, patch, uses, seams);
        for (const auto& [left, right] : uses) {
            CHECK(left == doctest::Approx(1));
            CHECK(right == doctest::Approx(1));
        }
        // Control points of little weight are rounded more than others.
        for (const CellEdge& edge : cell.edges) CHECK(edge.error < 1e-6);
        const CellFace& face = face_of(cell, Site::object(3));
        REQUIRE(face.patches.size() == 1);
        const RationalPatch& s = face.patches[0].surface;
        CHECK(s.degree_u > 10);
        const auto& base = std::get<Sphere>(scene.base);
        double furthest = 0;
        for (int i = 0; i <= 16; ++i)
            for (int k = 0; k <= 16; ++k) {
                const Vec3 p = s.evaluate(std::lerp(s.domain_u[0], s.domain_u[1], i / 16.0),
                                          std::lerp(s.domain_v[0], s.domain_v[1], k / 16.0));
                const double off = (p - base.center).norm() - base.radius - away(scene.objects.back(), p);
                furthest = std::max(furthest, std::abs(off));
            }
        CHECK(furthest < 1e-11);
    }
}

// Turns by quarters are exact.
TEST_CASE("vessel faces: cells of turned scenes have as large faces in as many patches") {
    std::mt19937_64 rng(test_seed() + 1);
    int around = 0;
    for (int round = 0; round < 40 && around < 3 * rounds(); ++round) {
        CAPTURE(round);
        const auto scene = FewBalls{rng, round % 2 == 0}.scene(round % 4 >= 2);
        if (!scene) continue;
        const auto turned = [](const Vec3& p) { return Vec3(p.y(), p.z(), p.x()); };
        Scene other = *scene;
        const auto turn = [&](Object& o) {
            if (auto* ball = std::get_if<Sphere>(&o)) ball->center = turned(ball->center);
            if (auto* tube = std::get_if<HollowCylinder>(&o))
                tube->point = turned(tube->point), tube->axis = turned(tube->axis);
            if (auto* cone = std::get_if<HollowCone>(&o))
                cone->apex = turned(cone->apex), cone->axis = turned(cone->axis);
        };
        for (Object& o : other.objects) turn(o);
        std::get<Sphere>(other.base).center = turned(std::get<Sphere>(other.base).center);
        std::ranges::reverse(other.objects);
        const auto first = cell_if_any(*scene), second = cell_if_any(other);
        REQUIRE(first.has_value() == second.has_value());
        if (!first) continue;
        const auto last = static_cast<std::uint32_t>(scene->objects.size() - 1);
        const auto of_wall = [](const Cell& cell, Site wall) {
            std::vector<std::pair<double, bool>> faces;
            for (const CellFace& face : cell.faces)
                if (face.site == wall) faces.emplace_back(face.area, face.patches.size() > 1);
            std::ranges::sort(faces);
            return faces;
        };
        const auto a = of_wall(*first, Site::object(last)), b = of_wall(*second, Site::object(0));
        REQUIRE(a.size() == b.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            CHECK(a[i].first == doctest::Approx(b[i].first).epsilon(1e-6));
            CHECK(a[i].second == b[i].second);
            around += a[i].second;
        }
    }
    CHECK(around > 0);
}

TEST_CASE("vessel faces: a loop that is not where the wall shows is found") {
    std::mt19937_64 rng(test_seed());
    Scene scene;
    scene.base = Sphere{{0.25, 0, 0}, 0.5};
    scene.objects = {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 2}};
    scene.box = {{-4, -4, -1.5}, {4, 4, 1.5}};
    Cell cell = voronoi_cell(scene);
    const Site wall = Site::object(0);
    CHECK(check_patches_by_rays(cell, wall, rng, 200) > 50);
    const VesselChart chart(scene.objects[0]);
    const double u = 2.0;  // any direction from the axis
    const Vec3 n(std::cos(u), std::sin(u), 0), c(-0.25, 0, 0);
    const double D = 2.5, r = (D * D - c.squaredNorm()) / (2 * (D + c.dot(n)));
    REQUIRE(patches_at(cell, wall, chart, r * n) == 1);
    auto& patches = std::ranges::find(cell.faces, wall, &CellFace::site)->patches;
    REQUIRE(patches.size() == 3);
    int without = 0;
    for (int k = 0; k < 3; ++k) {
        std::ranges::rotate(patches, patches.begin() + 1);
        const TrimmedPatch kept = patches.back();
        patches.pop_back();
        without += patches_at(cell, wall, chart, r * n);
        patches.push_back(kept);
    }
    CHECK(without == 2);
}

}  // namespace
}  // namespace vcell::vessel_faces_test
