// Faces of hollow spheres and caps about balls that leave others little of all around: two patches about the
// ends of the bisector's axis, against distances, and against closed forms of spheres that meet.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../test_support.hpp"
#include "radial_cell_checks.hpp"
#include "vessel_oracle.hpp"

namespace vcell::surface_halves_test {
namespace {

constexpr double pi = std::numbers::pi;

// The loops of a patch as seen from the base's centre, in a plane: stereographic about the end of the axis
// that the patch is about.
struct Outline {
    Vec3 pole, x, y;
    std::vector<std::vector<Vec2>> trims;

    Outline(const TrimmedPatch& patch, const Vec3& center) {
        constexpr int steps = 128;
        const auto direction = [&](const Vec2& uv) {
            return Vec3((patch.surface.evaluate(uv.x(), uv.y()) - center).normalized());
        };
        pole = direction(Vec2::Zero());
        x = pole.unitOrthogonal();
        y = pole.cross(x);
        for (const auto& loop : patch.loops)
            for (const TrimCurve& trim : loop) {
                trims.emplace_back();
                const auto pieces = steps * static_cast<int>(trim.curve.points.size());
                for (int k = 0; k <= pieces; ++k)
                    trims.back().push_back(in_plane(direction(trim.curve.evaluate(
                        std::lerp(trim.curve.domain_begin(), trim.curve.domain_end(), double(k) / pieces)))));
            }
    }
    Vec2 in_plane(const Vec3& d) const { return Vec2(d.dot(x), d.dot(y)) / (1 + d.dot(pole)); }
    // How often the loops wind around a direction.
    int times_around(const Vec3& u) const {
        const Vec2 place = in_plane(u);
        double turn = 0;
        for (const auto& trim : trims)
            for (std::size_t k = 1; k < trim.size(); ++k) {
                const Vec2 from = trim[k - 1] - place, to = trim[k] - place;
                turn += std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
            }
        return static_cast<int>(std::lround(turn / (2 * pi)));
    }
};

double room_of_others(const Scene& scene, Site own, const Vec3& p, double clearance) {
    double room = vessel_oracle::inside_box(scene.box, p);
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (Site::object(i) != own && scene.competes(i))
            room = std::min(room, vessel_oracle::away(scene.objects[i], p) - clearance);
    return room;
}

// Where the wall or cap shows one patch holds each point, and none elsewhere. Returns how many showed.
int check_by_rays(const Cell& cell, Site site, const HollowSphere& wall, std::mt19937_64& rng, int rays) {
    const auto& base = std::get<Sphere>(cell.scene.base);
    const double sum = wall.radius + base.radius;
    const Vec3 way = wall.center - base.center;
    std::vector<Outline> outlines;
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches)
            if (face.site == site) outlines.emplace_back(patch, base.center);
    std::normal_distribution<double> normal;
    int shown = 0;
    for (int i = 0; i < rays; ++i) {
        const Vec3 u = Vec3(normal(rng), normal(rng), normal(rng)).normalized();
        const double t = (sum * sum - way.squaredNorm()) / (2 * (sum - way.dot(u)));
        const double room = room_of_others(cell.scene, site, base.center + t * u, t - base.radius);
        if (std::abs(room) < 0.02) continue;
        int held = 0;
        for (const Outline& outline : outlines) {
            const int times = outline.times_around(u);
            CHECK((times == 0 || times == 1));
            held += times;
        }
        CHECK(held == (room > 0 ? 1 : 0));
        shown += room > 0;
    }
    return shown;
}

// A ball among others that leave much of all around to a sphere about it, in small integers.
Scene scattered(std::mt19937_64& rng, bool has_cap) {
    const auto number = [&](int from, int to) { return std::uniform_int_distribution(from, to)(rng); };
    const auto vector = [&](int reach) {
        const double x = number(-reach, reach), y = number(-reach, reach), z = number(-reach, reach);
        return Vec3(x, y, z);
    };
    Scene scene;
    const double radius = number(0, 2);
    scene.base = Sphere{Vec3::Zero(), radius};
    for (int left = number(1, 6); left > 0;) {
        const Vec3 c = vector(7);
        const double own = number(0, 2);
        if (!(c.norm() > own + radius)) continue;
        --left;
        const Vec3 axis = vector(2);
        if (number(0, 5) == 0 && c.cross(axis).norm() > (0.5 * own + radius) * axis.norm())
            scene.objects.push_back(Cylinder{c, axis, 0.5 * own});
        else
            scene.objects.push_back(Sphere{c, own});
    }
    if (has_cap) {  // as a probe of half a whole number leaves it
        scene.objects.push_back(HollowSphere{Vec3::Zero(), radius + number(1, 5)});
    } else {
        const double wide = number(6, 12);
        Vec3 center = vector(6);
        while (!(center.norm() + radius < wide)) center = vector(6);
        scene.objects.push_back(HollowSphere{center, wide});
    }
    scene.box = {Vec3::Constant(-30), Vec3::Constant(30)};
    return scene;
}

TEST_CASE("surface halves: a cap between two small discs has two patches, whose measures are closed forms") {
    for (const Vec3& way : {Vec3(2, 0, 0), Vec3(1, 2, 2), Vec3(-2, 1, -0.5)})
        for (const double part : {0.9, 0.99, 0.9999}) {
            CAPTURE(part);
            const double reach = 0.5 * way.norm() / part;  // of the cap: that much of it is before a disc
            Scene scene;
            scene.base = Sphere{{1, 1, 1}, 0.25};
            for (const double side : {-1.0, 1.0})
                scene.objects.push_back(Sphere{Vec3::Ones() + side * way, 0.25});
            scene.objects.push_back(HollowSphere{Vec3::Ones(), 2 * reach - 0.25});
            scene.box = {Vec3::Constant(-8), Vec3::Constant(8)};
            const Cell cell = voronoi_cell(scene);
            radial_cells::check_cell(cell);
            const CellFace& cap = *std::ranges::find(cell.faces, Site::object(2), &CellFace::site);
            REQUIRE(cap.patches.size() == 2);
            for (const TrimmedPatch& patch : cap.patches) {
                CHECK(patch.surface.degree_u <= 6);
                CHECK(patch.surface.degree_v <= 6);
            }
            const double height = reach * (1 - part);
            CHECK(cap.area == doctest::Approx(4 * pi * reach * (reach - height)).epsilon(1e-12));
            CHECK(cell.measures.volume == doctest::Approx(4 * pi / 3 * reach * reach * reach -
                                                          2 * pi / 3 * height * height * (3 * reach - height))
                                              .epsilon(1e-12));
            for (const CellEdge& edge : cell.edges) CHECK(edge.error < 1e-9);
        }
}

TEST_CASE(
    "surface halves: nothing is undecided where walls and caps show almost all around, and one patch holds each point") {
    std::mt19937_64 rng(test_seed());
    int halved = 0, crossed = 0, shown = 0;
    for (int round = 0; round < 60 * rounds(); ++round) {
        CAPTURE(round);
        const Scene scene = scattered(rng, round % 2 == 0);
        std::optional<Cell> cell;
        try {
            cell = voronoi_cell(scene);
        } catch (const UndecidedError& e) {
            const std::string what = e.what();
            CHECK_MESSAGE(what.find("equally near along a curve") != std::string::npos, what);
        } catch (const InputError&) {  // tubes that cut the base
        }
        if (!cell) continue;
        radial_cells::check_cell(*cell, 1e-8);
        const Site site = Site::object(static_cast<std::uint32_t>(scene.objects.size() - 1));
        const auto face = std::ranges::find(cell->faces, site, &CellFace::site);
        if (face == cell->faces.end() || face->patches.size() < 2) continue;
        ++halved;
        // Where an edge crosses the plane between both halves each has a part of it.
        crossed += std::ranges::any_of(face->patches, [](const TrimmedPatch& p) {
            return std::ranges::any_of(p.loops, [](const auto& loop) {
                return loop.size() > 1 &&
                       std::ranges::any_of(loop, [](const TrimCurve& c) { return c.seam.has_value(); });
            });
        });
        shown += check_by_rays(*cell, site, std::get<HollowSphere>(scene.objects.back()), rng, 20);
    }
    CHECK(halved > 5);
    CHECK(crossed > 0);
    CHECK(shown > 100);
}

// Edges that touch the plane through the middle all along, or in a point, and others that leave no gap there.
TEST_CASE("surface halves: planes keep clear of edges across the axis, and of small holes all around") {
    Scene ring;
    ring.base = Sphere{Vec3::Zero(), 1};
    // Sixteen small discs about the middle, and a plane across the axis.
    for (int k = 0; k < 16; ++k) {
        const double angle = 2 * pi * k / 16;
        ring.objects.push_back(Sphere{6.16 * Vec3(std::cos(angle), std::sin(angle), 0), 1});
    }
    ring.objects.push_back(Plane{{0, 0, 5}, {0, 0, 1}});
    ring.objects.push_back(HollowSphere{Vec3::Zero(), 5.25});
    ring.box = {Vec3::Constant(-8), Vec3::Constant(8)};
    Scene off = ring;
    std::get<HollowSphere>(off.objects.back()).center = Vec3(0, 0, 0.25);
    Scene across;
    across.base = Sphere{{0, 0, 0}, 0.5};
    across.objects = {Sphere{{0, 0, 5.25}, 0.5}, Sphere{{0, 0, -4.5}, 0.5}, HollowSphere{{0, 0, 0.25}, 5}};
    across.box = ring.box;
    std::mt19937_64 rng(test_seed());
    for (const Scene& scene : {ring, off, across}) {
        const Cell cell = voronoi_cell(scene);
        radial_cells::check_cell(cell, 1e-8);
        const auto number = static_cast<std::uint32_t>(scene.objects.size() - 1);
        const auto face = std::ranges::find(cell.faces, Site::object(number), &CellFace::site);
        REQUIRE(face != cell.faces.end());
        CHECK(face->patches.size() >= 2);
        CHECK(check_by_rays(cell, Site::object(number), std::get<HollowSphere>(scene.objects.back()), rng,
                            100) > 50);
    }
}

}  // namespace
}  // namespace vcell::surface_halves_test
