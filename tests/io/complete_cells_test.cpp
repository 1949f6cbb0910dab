// Cells of all of the box that is nearest to a base plane: against complete_measures(), which gets there by
// other cells, against distances at random points, and as closed surfaces.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/cell_changes.hpp"
#include "../../envelope/complete_measures.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/pictures/svg.hpp"
#include "../test_support.hpp"
#include "complete_checks.hpp"

using namespace vcell;

namespace {

Vec3 random_direction(std::mt19937_64& rng) {
    std::normal_distribution<double> normal;
    const double x = normal(rng), y = normal(rng), z = normal(rng);
    return Vec3(x, y, z).normalized();
}

/// A plane through a box, and before it balls and up to two planes that lean against it by little. `lean` is
/// what the plane's normal has of the normal of one of the sides, if it is given: of 0 the plane is upright
/// on it.
Scene random_scene(std::mt19937_64& rng, std::size_t balls, std::optional<double> lean) {
    std::uniform_real_distribution<double> unit(0, 1);
    Scene scene;
    scene.box = {Vec3::Zero(), Vec3(8, 9, 10)};
    Vec3 n = random_direction(rng);
    if (lean) n[static_cast<Eigen::Index>(rng() % 3)] = *lean;
    n.normalize();
    const Vec3 size = scene.box.max - scene.box.min,
               p = scene.box.min + size.cwiseProduct(Vec3(0.3 + 0.4 * unit(rng), 0.3 + 0.4 * unit(rng),
                                                          0.3 + 0.4 * unit(rng)));
    scene.base = Plane{p, n};
    for (std::size_t tries = 0; scene.objects.size() < balls && tries < 1000; ++tries) {
        const double radius = 0.05 + 0.6 * unit(rng);
        const Vec3 c(size.x() * (1.4 * unit(rng) - 0.2), size.y() * (1.4 * unit(rng) - 0.2),
                     size.z() * (1.4 * unit(rng) - 0.2));
        if (n.dot(c - p) > radius + 0.1) scene.objects.push_back(Sphere{c, radius});
    }
    const auto planes = rng() % 3;
    for (std::size_t i = 0; i < planes; ++i)
        scene.objects.push_back(Plane{p + (5 + 3 * unit(rng)) * n, 0.1 * random_direction(rng) - n});
    return scene;
}

/// The same with tubes that run along the plane, or lean against it by little.
Scene random_scene_with_tubes(std::mt19937_64& rng, std::size_t tubes, std::optional<double> lean = {}) {
    Scene scene = random_scene(rng, rng() % 4, lean);
    const auto& base = std::get<Plane>(scene.base);
    std::uniform_real_distribution<double> unit(0, 1);
    const std::size_t all = scene.objects.size() + tubes;
    for (int tries = 0; scene.objects.size() < all && tries < 1000; ++tries) {
        const double radius = 0.05 + 0.4 * unit(rng), height = radius + 1 + 2 * unit(rng);
        const Vec3 along = base.normal.cross(random_direction(rng)).normalized(),
                   across = base.normal.cross(along), axis = along + 0.04 * (unit(rng) - 0.5) * base.normal;
        const Vec3 point = base.point + 8 * (unit(rng) - 0.5) * across + height * base.normal;
        scene.objects.push_back(Cylinder{point, axis, radius});
    }
    return scene;
}

void check_measures(const Cell& cell) {
    const CompleteMeasures m = complete_measures(cell.scene);
    CHECK(cell.measures.volume_error <= 1e-6 * (1 + m.volume));
    check_complete_measures(cell, m);
}

void check_certificate(const Cell& cell) {
    const Certificate certificate = certify(cell);
    for (const Element& e : certificate.elements)
        if (e.verdict != Verdict::proved)
            FAIL_CHECK(e.where << ": " << to_string(e.verdict) << " " << e.what);
    CHECK(std::ranges::any_of(certificate.elements, [](const Element& e) { return e.where == "entries"; }));
}

/// All of it; does the cell have a floor?
bool check_cell(const Cell& cell, std::mt19937_64& rng) {
    REQUIRE(cell.is_complete);
    check_measures(cell);
    check_points(cell, checked_mesh(cell), rng);
    check_certificate(cell);
    return std::ranges::any_of(cell.faces, [&](const CellFace& f) { return is_entered(cell, f); });
}

}  // namespace

TEST_CASE("complete cells: measures and points, closed meshes and proofs of random scenes") {
    std::mt19937_64 rng(test_seed());
    int with_floor = 0;
    for (int round = 0; round < 12 * rounds(); ++round) {
        const Scene scene =
            random_scene(rng, 1 + rng() % 20, round % 3 == 0 ? std::optional(0.0) : std::nullopt);
        CAPTURE(round);
        with_floor += check_cell(complete_cell(scene), rng);
    }
    CHECK(with_floor > 6 * rounds());
}

TEST_CASE("complete cells: measures and points, closed meshes and proofs of planes among tubes") {
    std::mt19937_64 rng(test_seed());
    int with_floor = 0;
    for (int round = 0; round < 6 * rounds(); ++round) {
        const Scene scene = random_scene_with_tubes(rng, 1 + rng() % 4);
        CAPTURE(round);
        with_floor += check_cell(complete_cell(scene), rng);
    }
    CHECK(with_floor > 3 * rounds());
}

// Heights of the side along which the rays nearly run are steep: what vertices beside tubes are off by over
// the base is that much more in the box.
TEST_CASE("complete cells: bounds are tight where a plane among tubes is nearly upright on a side") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 8 * rounds(); ++round) {
        const Cell cell = complete_cell(random_scene_with_tubes(rng, 1 + rng() % 4, 0x1p-14));
        CAPTURE(round);
        check_certificate(cell);
    }
}

namespace {

/// A plane under a box but for a strip, and close above the box's bottom, through which its rays come in, a
/// row of balls: what is nearest to the plane beyond the row has no contact with what is before it.
Scene row_of_balls() {
    Scene scene;
    scene.base = Plane{{1, 0, 0}, {0.1, 0, 1}};
    scene.box = {Vec3::Zero(), Vec3::Constant(10)};
    for (int i = 0; i < 16; ++i) scene.objects.push_back(Sphere{{4, 0.7 * i - 0.2, 0.55}, 0.4});
    scene.objects.push_back(Sphere{{8, 5, 4}, 1});
    return scene;
}

/// Which faces hang together with an edge on the base, and which do not.
std::vector<bool> are_on_base(const Cell& cell) {
    const std::vector<std::uint32_t> part = components(cell);
    std::vector<bool> is_root(part.size(), false), result;
    for (std::size_t f = 0; f < part.size(); ++f)
        for (const TrimmedPatch& patch : cell.faces[f].patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop)
                    if (cell.edges[*trim.edge].sites[0] == cell.edges[*trim.edge].sites[1])
                        is_root[part[f]] = true;
    for (const std::uint32_t root : part) result.push_back(is_root[root]);
    return result;
}

}  // namespace

TEST_CASE("complete cells: a part that nothing joins to the others is there, and missed if it is not") {
    const Cell cell = complete_cell(row_of_balls());
    check_measures(cell);
    check_certificate(cell);
    std::vector<int> without, twice;
    for (const bool is_on_base : are_on_base(cell)) {
        without.push_back(is_on_base ? 1 : 0);
        twice.push_back(is_on_base ? 1 : 2);
    }
    const Cell rest = with_faces(cell, without), more = with_faces(cell, twice);
    REQUIRE(rest.faces.size() < cell.faces.size());
    REQUIRE(!rest.faces.empty());
    CHECK_FALSE(is_proved(certify(rest), "entries"));
    REQUIRE(more.edges.size() > cell.edges.size());
    CHECK(is_refuted(certify(more), "entries"));
    CHECK(certify(with_faces(cell, std::vector(cell.faces.size(), 1))).holds());
}

TEST_CASE("complete cells: an edge of the box may lie on the base") {
    // Two sides of the box and the base meet along it: what is above and what is below the base's region have
    // different pairs of them there.
    Scene scene;
    scene.base = Plane{{6, 7, 7}, {0, -2, -1}};
    scene.objects = {Plane{{3, 8, 2}, {0, 0, 1}}};
    scene.box = {{-1, 2, 3}, {2, 9, 10}};
    const Cell cell = complete_cell(scene);
    check_measures(cell);
    check_certificate(cell);
    checked_mesh(cell);
}

TEST_CASE("complete cells: a cell over the base's region alone is not taken for one") {
    Cell cell = voronoi_cell(row_of_balls());
    CHECK(certify(cell).holds());
    cell.is_complete = true;
    CHECK_FALSE(certify(cell).holds());
}

TEST_CASE("complete cells: two sides of planes and the balls between them fill the box") {
    std::mt19937_64 rng(test_seed());
    int filled = 0;
    for (int attempt = 0; filled < 2 * rounds() && attempt < 40 * rounds(); ++attempt) {
        const Scene scene = random_scene(rng, 8, std::nullopt);
        std::vector<Object> all = scene.objects;
        all.push_back(scene.base);
        double volume = 0, bound = 0;
        bool is_whole = true;
        const auto add = [&](double v, double e) {
            volume += v;
            bound += e;
        };
        for (std::size_t i = 0; i < all.size(); ++i) {
            Scene part = scene;
            part.objects = all;
            part.objects.erase(part.objects.begin() + static_cast<std::ptrdiff_t>(i));
            part.base = all[i];
            try {
                if (const auto* plane = std::get_if<Plane>(&all[i])) {
                    for (const double sense : {1.0, -1.0}) {
                        part.base = Plane{plane->point, sense * plane->normal};
                        const Measures m = complete_cell(part).measures;
                        add(m.volume, m.volume_error);
                    }
                } else {
                    const CompleteMeasures m = complete_measures(part);
                    add(m.volume, m.volume_error);
                }
            } catch (const InputError&) {
                // A plane beside the box may own nothing of it, or what its margin holds may be cut.
                is_whole = false;
            }
        }
        if (!is_whole) continue;
        ++filled;
        const Vec3 size = scene.box.max - scene.box.min;
        CHECK(std::abs(volume - size.prod()) <= bound + 1e-9);
    }
    CHECK(filled == 2 * rounds());
}

TEST_CASE("complete cells: files, pictures, refined vertices and changed scenes") {
    std::mt19937_64 rng(test_seed());
    const Scene scene = random_scene(rng, 12, std::nullopt);
    const Cell cell = complete_cell(scene);
    std::stringstream file, picture;
    write_cell(file, cell);
    const Cell read = parse_cell(file.str());
    CHECK(read.is_complete);
    std::stringstream again;
    write_cell(again, read);
    CHECK(again.str() == file.str());
    write_svg(picture, cell);
    CHECK(picture.str().find("class=\"face") != std::string::npos);
    for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
        CAPTURE(v);
        CHECK(refine(cell, v, 100).has_value());
    }

    Scene smaller = scene;
    smaller.objects.erase(smaller.objects.begin());
    const Cell removed = remove(cell, 0);
    CHECK(removed.is_complete);
    CHECK(removed.faces.size() == complete_cell(smaller).faces.size());
    const Cell inserted = insert(removed, scene.objects[0]);
    CHECK(inserted.is_complete);
    CHECK(inserted.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-12));
}

TEST_CASE("complete cells: where rays come in nowhere cells stay as they are") {
    Scene level;
    level.base = Plane{{0, 0, 1}, {0, 0, 1}};
    level.box = {Vec3::Zero(), Vec3::Constant(10)};
    level.objects = {Sphere{{5, 5, 5}, 1}};
    Cell cell = complete_cell(level);
    CHECK(cell.is_complete);
    CHECK(cell.measures.volume == voronoi_cell(level).measures.volume);
    CHECK(certify(cell).holds());

    Scene ball;
    ball.base = Sphere{{5, 5, 5}, 1};
    ball.box = level.box;
    ball.objects = {Cylinder{{5, 5, 10}, {1, 0, -0.2}, 0.5}};
    cell = complete_cell(ball);
    CHECK_FALSE(cell.is_complete);
    CHECK(cell.measures.volume == voronoi_cell(ball).measures.volume);
}

TEST_CASE("complete cells: a plane among tubes in small integers") {
    // The tube and the ball in a plane of symmetry, upright on the plane and on two sides of the box.
    Scene scene;
    scene.base = Plane{{0, 0, 5}, {0, 3, 4}};
    scene.box = {Vec3::Constant(-10), Vec3::Constant(10)};
    for (const Object& tube :
         {Object(Cylinder{{0, 0, 15}, {1, 0, 0}, 1}), Object(Cylinder{{0, 0, 20}, {0, 4, -3}, 2}),
          Object(Cylinder{{0, 8, 9}, {1, 0, 0}, 1})}) {
        scene.objects = {tube, Sphere{{0, -5, 15}, 1}};
        const Cell cell = complete_cell(scene);
        CHECK(cell.is_complete);
        check_measures(cell);
        check_certificate(cell);
    }
}

// The plane runs through a corner of the box but for the rounding of its normal: what comes in there is a
// triangle of that size.
TEST_CASE("complete cells: no point need be found inside faces as thin as rounding") {
    Scene scene;
    scene.base = Plane{{0, 0, -2.5}, {0.25, 0.125, 1}};
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    scene.objects = {Sphere{{2.5, 0.5, 0.25}, 0.75}, Cylinder{{-2, 0, 0.5}, {0.25, 1, 0.125}, 0.5},
                     Sphere{{0, 0, 0}, 1}};
    const Cell cell = complete_cell(scene);
    CHECK(std::ranges::any_of(cell.faces, [](const CellFace& f) { return f.area < 1e-20; }));
    const Certificate certificate = certify(cell);
    CHECK(is_proved(certificate, "entries"));
    CHECK(certificate.count(Verdict::refuted) == 0);
}
