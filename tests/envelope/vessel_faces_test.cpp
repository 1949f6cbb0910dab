/// Faces of hollow tubes and cones that reach around the vessel's axis, or to it, in patches about it.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <set>
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

// ---- Tips -----------------------------------------------------------------------------------------------

int count_tips(const Cell& cell) {
    std::set<std::pair<Site, bool>> tips;
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop)
                    if (trim.is_tip())
                        tips.insert({face.site, trim.curve.points[0].x() < trim.curve.points[1].x()});
    return static_cast<int>(tips.size());
}

// Half planes from the axis of a tube meet the bisector in parabolas: with D the sum of the radii, m the way
// from the axis to the ball and L^2 = D^2 - m^2, r = (L^2 - z^2) / (2 (D + m cos phi)), of which the tips are
// at z = -L and L. Over once around 1 / (D + m cos phi)^2 adds up to 2 pi D / L^3.
struct InTube {
    double D, m;

    double L() const { return std::sqrt(D * D - m * m); }
    // Of what is between the first tip and z.
    double volume(double z) const {
        const auto sum = [&](double x) {
            const double l2 = L() * L(), x2 = x * x;
            return x * (l2 * l2 + x2 * (x2 / 5 - 2 * l2 / 3));
        };
        return pi * D / (4 * L() * L() * L()) * (sum(z) - sum(-L()));
    }
    // dS^2 = r^2 + r_phi^2 + r^2 r_z^2, by the rule of midpoints.
    double area(double z) const {
        constexpr int parts = 600;
        double sum = 0;
        for (int i = 0; i < parts; ++i)
            for (int k = 0; k < 60; ++k) {
                const double phi = 2 * pi * k / 60, at = -L() + (z + L()) * (i + 0.5) / parts,
                             q = D + m * std::cos(phi), r = (L() * L() - at * at) / (2 * q),
                             r_phi = r * m * std::sin(phi) / q, r_z = -at / q;
                sum += std::sqrt(r * r + r_phi * r_phi + r * r * r_z * r_z);
            }
        return sum * 2 * pi / 60 * (z + L()) / parts;
    }
};

TEST_CASE("vessel faces: alone in a tube a ball's cell has two tips, as closed forms have it") {
    const Vec3 axis = Vec3(2, 3, 6) / 7, aside = Vec3(6, 2, -3) / 7;
    for (const double m : {0.0, 0.375, 1.25})
        for (const bool leans : {false, true})
            for (const double radius : {0.5, 0.0}) {
                CAPTURE(m);
                CAPTURE(leans);
                CAPTURE(radius);
                const Vec3 d = leans ? axis : Vec3(Vec3::UnitZ()), x = leans ? aside : Vec3(Vec3::UnitX());
                const InTube form{2 + radius, m};
                Scene scene;
                scene.base = Sphere{Vec3(0.5, 0.25, -1), radius};
                scene.objects = {HollowCylinder{Vec3(0.5, 0.25, -1) - m * x + 3 * d, 7 * d, 2}};
                scene.box = {Vec3::Constant(-6), Vec3::Constant(6)};
                for (const bool patches : {false, true}) {
                    CellOptions options;
                    options.patches = patches;
                    const Cell cell = voronoi_cell(scene, options);
                    REQUIRE(cell.faces.size() == 1);
                    CHECK(cell.edges.empty());
                    const Measures& got = cell.measures;
                    CHECK(std::abs(got.volume - form.volume(form.L())) <= got.volume_error + 1e-13);
                    CHECK(got.volume_error < 1e-9);
                    CHECK(got.area == doctest::Approx(form.area(form.L())).epsilon(1e-5));
                    CHECK(got.area_error < 1e-9);
                    CHECK(got.is_estimated);
                    CHECK(std::abs(got.max_clearance - 2) <= got.max_clearance_error);
                    CHECK(got.min_clearance == doctest::Approx(0.5 * (2 - m - radius)).epsilon(1e-13));
                    CHECK_FALSE(got.touches_box);
                    if (!patches) continue;
                    CHECK(count_tips(cell) == 2);
                    CHECK(cell.faces[0].patches.size() == 3);
                    radial_cells::check_cell(cell);
                    if (m != 0.375 || radius == 0) continue;
                    double of_patches = 0;
                    for (const TrimmedPatch& patch : cell.faces[0].patches)
                        of_patches += area_of(patch.surface);
                    CHECK(of_patches == doctest::Approx(got.area).epsilon(1e-4));
                }
            }
}

TEST_CASE("vessel faces: a side across the tube leaves one tip, of either end") {
    const double m = 0.5, R = 2, radius = 0.25;
    const InTube form{R + radius, m};
    for (const double h : {0.125, 1.0, 2.0})
        for (const double end : {-1.0, 1.0}) {
            CAPTURE(h);
            CAPTURE(end);
            Scene scene;
            scene.base = Sphere{{m, 0, 0}, radius};
            scene.objects = {HollowCylinder{{0, 0, 1}, {0, 0, end}, R}};
            scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
            (end > 0 ? scene.box.max : scene.box.min).z() = end * h;
            const Cell cell = voronoi_cell(scene);
            CHECK(cell.faces.size() == 2);
            CHECK(count_tips(cell) == 1);
            radial_cells::check_cell(cell);
            const Measures& got = cell.measures;
            CHECK(std::abs(got.volume - form.volume(h)) <= got.volume_error);
            CHECK(got.volume_error < 1e-4);
            CHECK(got.area == doctest::Approx(form.area(h)).epsilon(2e-5));
            CHECK(std::abs(got.max_clearance - R) <= got.max_clearance_error);
        }
}

TEST_CASE("vessel faces: a tip on a side of the box is undecided, a little before or beyond it is not") {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.5};
    scene.objects = {HollowCylinder{{0, 0, 0}, {0, 0, 1}, 2}};
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    scene.box.max.z() = 2.5;
    CHECK_THROWS_AS(voronoi_cell(scene), UndecidedError);
    for (const double off : {0x1p-10, -0x1p-6}) {
        CAPTURE(off);
        scene.box.max.z() = 2.5 + off;
        const Cell cell = voronoi_cell(scene);
        CHECK(cell.faces.size() == (off > 0 ? 1 : 2));
        CHECK(count_tips(cell) == (off > 0 ? 2 : 1));
        radial_cells::check_cell(cell);
        CHECK(cell.measures.volume ==
              doctest::Approx(InTube{2.5, 0}.volume(std::min(2.5, 2.5 + off))).epsilon(1e-9));
    }
}

// About a ball on the axis of a cone, h from the apex: discs of the radius r with |(r, z - h)| = R0 + S z - K
// r.
TEST_CASE("vessel faces: alone in a cone a ball's cell has two tips, as discs add up") {
    const double S = 0.6, K = 0.8, h = 3, R0 = 0.5;
    const double low = (h - R0) / (1 + S), high = (h + R0) / (1 - S);
    const auto r = [&](double z) {
        const double b = R0 + S * z, rise = z - h;
        // S^2 r^2 + 2 K b r + (z - h)^2 - b^2 = 0.
        const double rest = b * b - rise * rise;
        return rest / (K * b + std::sqrt(K * K * b * b + S * S * rest));
    };
    double volume = 0, area = 0;
    constexpr int parts = 20'000;
    for (int i = 0; i < parts; ++i) {
        const double step = (high - low) / parts, z = low + step * (i + 0.5), at = r(z),
                     slope = (r(z + 0.25 * step) - r(z - 0.25 * step)) / (0.5 * step);
        volume += pi * at * at * step;
        area += 2 * pi * at * std::hypot(1, slope) * step;
    }
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(-2, 6, 3)}) {
        const Vec3 w = axis.normalized();
        Scene scene;
        scene.base = Sphere{{0.25, 0, 0.5}, R0};
        scene.objects = {HollowCone{Vec3(0.25, 0, 0.5) - h * w, axis, 3, 5}};
        scene.box = {Vec3::Constant(-12), Vec3::Constant(12)};
        const Cell cell = voronoi_cell(scene);
        CHECK(cell.faces.size() == 1);
        CHECK(count_tips(cell) == 2);
        radial_cells::check_cell(cell);
        const Measures& got = cell.measures;
        CHECK(got.volume == doctest::Approx(volume).epsilon(1e-7));
        CHECK(got.area == doctest::Approx(area).epsilon(1e-6));
        CHECK(got.volume_error < 1e-9 * volume);
        CHECK(got.max_clearance == doctest::Approx(S * high).epsilon(1e-12));
    }
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
    double wide(const Vec3& p) const { return w.cross(p - point).norm(); }
    double along(const Vec3& p) const { return cosine * w.dot(p - point) + sine * wide(p); }
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
                        Vec3 q = patch.surface.evaluate(uv.x(), uv.y());
                        // A tip has no angle about the axis, and seams have their own: next to it.
                        if (chart.wide(q) < 1e-9) {
                            const auto& [v0, v1] = patch.surface.domain_v;
                            q = patch.surface.evaluate(uv.x(), std::lerp(uv.y(), 0.5 * (v0 + v1), 1e-6));
                        }
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

// None: small integers tie along a curve, or in a tip.
std::optional<Cell> cell_if_any(const Scene& scene) {
    try {
        return voronoi_cell(scene);
    } catch (const UndecidedError& e) {
        const std::string what = e.what();
        CHECK_MESSAGE((what.find("equally near along a curve") != std::string::npos ||
                       what.find("may run through the tip") != std::string::npos),
                      what);
    }
    return std::nullopt;
}

TEST_CASE("vessel faces: around the axis of a tube or a cone one patch holds each point") {
    std::mt19937_64 rng(test_seed());
    int around = 0, shown = 0, tips = 0;
    for (int round = 0; round < 40 * rounds(); ++round) {
        CAPTURE(round);
        const auto scene = FewBalls{rng, round % 2 == 0}.scene(round % 4 >= 2);
        if (!scene) continue;
        const auto cell = cell_if_any(*scene);
        if (!cell) continue;
        radial_cells::check_cell(*cell, 1e-8);  // few balls have wide faces
        const Site wall = Site::object(static_cast<std::uint32_t>(scene->objects.size() - 1));
        for (const CellFace& face : cell->faces) around += face.site == wall && face.patches.size() > 1;
        shown += check_patches_by_rays(*cell, wall, rng, 40);
        vessel_oracle::check_vertices(*cell);
        if (count_tips(*cell) == 0) continue;
        ++tips;
        vessel_oracle::check_volume(*scene, *cell);
        vessel_oracle::check_queries(*scene, rng, 20);
    }
    CHECK(around > 2);
    CHECK(shown > 40);
    CHECK(tips > 0);
}

// From any direction that such a face leaves to others it reaches far around: two patches hold it.
TEST_CASE("vessel faces: of a sphere that few balls share patches reach far around, and keep their digits") {
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
        for (const CellEdge& edge : cell.edges) CHECK(edge.error < 1e-9);
        const CellFace& face = face_of(cell, Site::object(3));
        REQUIRE(face.patches.size() == 2);
        const auto& base = std::get<Sphere>(scene.base);
        double furthest = 0;
        for (const TrimmedPatch& patch : face.patches) {
            const RationalPatch& s = patch.surface;
            CHECK(s.degree_u <= 6);
            for (int i = 0; i <= 16; ++i)
                for (int k = 0; k <= 16; ++k) {
                    const Vec3 p = s.evaluate(std::lerp(s.domain_u[0], s.domain_u[1], i / 16.0),
                                              std::lerp(s.domain_v[0], s.domain_v[1], k / 16.0));
                    const double off = (p - base.center).norm() - base.radius - away(scene.objects.back(), p);
                    furthest = std::max(furthest, std::abs(off));
                }
        }
        CHECK(furthest < 1e-12);
    }
}

// Turns by quarters are exact. The middle of a face, about which its patch is, is that of pieces of the
// chart, which a turn changes: one patch of a higher degree may hold what two hold after it.
TEST_CASE("vessel faces: cells of turned scenes have as large faces, in one patch or in two") {
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
            around += a[i].second || b[i].second;
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
