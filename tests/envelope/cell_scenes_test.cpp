// Whole cells of scenes, against distances, sampled measures and symmetry.
#include <doctest/doctest.h>

#include <numbers>
#include <random>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "cell_checks.hpp"
#include "test_support.hpp"

namespace vcell::cell_scenes_test {

namespace {

// n spheres of mixed radii over the unit square's plane, and a few planes around and above.
Scene random_scene(std::mt19937_64& rng, int n, int planes) {
    std::uniform_real_distribution<double> unit(-1, 1);
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = {{-1, -1, 0}, {1, 1, 1.2}};
    for (int i = 0; i < n; ++i) {
        const double z = 0.7 + 0.4 * unit(rng);
        scene.objects.push_back(Sphere{{1.2 * unit(rng), 1.2 * unit(rng), z}, 0.2 * (1 + unit(rng)) * z});
    }
    for (int i = 0; i < planes; ++i) {
        if (i % 2)
            scene.objects.push_back(
                Plane{{0, 0, 1.2}, {0.2 * unit(rng), 0.2 * unit(rng), unit(rng) > 0 ? 1.0 : -3.0}});
        else
            scene.objects.push_back(Plane{{2, 0.5 * unit(rng), 0}, {1, 0.3 * unit(rng), 0.3 * unit(rng)}});
    }
    return scene;
}

// Sampled measures agree to the sampling's accuracy; where they agree that well, the error bounds are honest
// claims about the rest.
void check_measures(const Cell& cell) {
    const PlaneBaseProblem problem = plane_base_problem(cell.scene);
    const testing::SampledMeasures sampled = testing::sample_measures(problem, 300);
    const Measures& m = cell.measures;
    CHECK(m.volume == doctest::Approx(sampled.volume).epsilon(2e-3));
    CHECK(m.area == doctest::Approx(sampled.area).epsilon(5e-3));
    CHECK(m.volume_error < 1e-9 * m.volume);
    CHECK(m.area_error < 1e-9 * (m.area + 1e-3));
    CHECK(m.min_clearance <= sampled.min_clearance + 1e-15);
    // A side of the box that leans over the base comes down to it, steeply where no sample is.
    if ((std::get<Plane>(cell.scene.base).normal.array() != 0).count() == 1)
        CHECK(m.min_clearance == doctest::Approx(sampled.min_clearance).epsilon(1e-2));
    CHECK(m.max_clearance >= sampled.max_clearance - 1e-15);
    CHECK(m.max_clearance == doctest::Approx(sampled.max_clearance).epsilon(3e-2));
    double object_area = 0, box_face_area = 0, flat = 0;
    for (const CellFace& face : cell.faces) {
        CHECK(face.area > 0);
        (face.site.is_object() ? object_area : box_face_area) += face.area;
    }
    for (const CellEdge& edge : cell.edges) {
        const bool rim = edge.sites[1].kind == Site::Kind::BoxSide && edge.sites[0] != edge.sites[1];
        if (rim) flat += edge.length;
    }
    CHECK(flat > 0);
    CHECK(m.area == doctest::Approx(object_area).epsilon(1e-13));
    CHECK(m.box_area >= box_face_area);
    CHECK(box_face_area ==
          doctest::Approx(testing::sample_box_face_area(cell.scene, 300)).epsilon(1e-2).scale(m.base_area));
    CHECK(m.body_volume == 0);
}

Vec3 cycled(const Vec3& p) { return {p.z(), p.x(), p.y()}; }

// The scene turned by (x, y, z) -> (z, x, y), scaled and moved.
Scene moved(const Scene& scene, double scale, const Vec3& shift) {
    const auto point = [&](const Vec3& p) -> Vec3 { return scale * cycled(p) + shift; };
    const auto object = [&](const Object& o) -> Object {
        if (const auto* sphere = std::get_if<Sphere>(&o))
            return Sphere{point(sphere->center), scale * sphere->radius};
        const auto& plane = std::get<Plane>(o);
        return Plane{point(plane.point), cycled(plane.normal)};
    };
    Scene result = scene;
    result.base = object(scene.base);
    for (Object& o : result.objects) o = object(o);
    result.box = {point(scene.box.min), point(scene.box.max)};
    return result;
}

}  // namespace

TEST_CASE("cell: random spheres and planes over a plane") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 12; ++round) {
        CAPTURE(round);
        const Cell cell = voronoi_cell(random_scene(rng, 3 * round, round % 4));
        testing::check_geometry(cell);
        check_measures(cell);
        for (std::size_t i = 1; i < cell.neighbors.size(); ++i) {
            const auto area = [&](std::uint32_t object) {
                double sum = 0;
                for (const CellFace& face : cell.faces)
                    if (face.site == Site::object(object)) sum += face.area;
                return sum;
            };
            CHECK(area(cell.neighbors[i - 1]) >= area(cell.neighbors[i]));
        }
    }
}

TEST_CASE("cell: tilted bases, their regions cut obliquely out of the box") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    int cells = 0;
    for (int round = 0; round < 60 && cells < 12; ++round) {
        Scene scene = random_scene(rng, 12, 2);
        scene.base = Plane{{0, 0, -0.5}, {0.5 * normal(rng), 0.5 * normal(rng), 1}};
        scene.box.min.z() = -1.5;
        Cell cell;
        try {
            cell = voronoi_cell(scene);
        } catch (const InputError& error) {
            REQUIRE(error.kind == InputError::Kind::TouchesBase);
            continue;
        }
        ++cells;
        CAPTURE(round);
        testing::check_geometry(cell);
        check_measures(cell);
    }
    CHECK(cells == 12);
}

TEST_CASE("cell: a lattice of equal spheres has degenerate vertices with all their sites") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) scene.objects.push_back(Sphere{{i + 0.5, j + 0.5, 1}, 0.25});
    scene.box = {{0, 0, 0}, {4, 4, 3}};
    const Cell cell = voronoi_cell(scene);
    testing::check_geometry(cell);
    CHECK(cell.faces.size() == 16);
    CHECK(cell.vertices.size() == 25);
    CHECK(cell.edges.size() == 40);
    int inner = 0;
    for (const CellVertex& v : cell.vertices) {
        if (std::any_of(v.sites.begin(), v.sites.end(), [](Site s) { return !s.is_object(); })) continue;
        ++inner;
        CHECK(v.sites.size() == 4);
        // Height (1/2 + 1 - 1/16) / (2 * 5/4) in the middle of four.
        CHECK(v.radius == doctest::Approx((0.5 + 0.9375) / 2.5).epsilon(1e-15));
    }
    CHECK(inner == 9);
    for (const CellEdge& e : cell.edges) CHECK(e.kind == CurveKind::Parabola);
    for (const CellFace& f : cell.faces) CHECK(f.area == doctest::Approx(cell.faces[0].area).epsilon(1e-14));
    // Each unit square: integral of (|q|^2 + 15/16) / (5/2).
    CHECK(std::abs(cell.measures.volume - 16 * (1.0 / 6 + 0.9375) / 2.5) <= cell.measures.volume_error);
    CHECK(cell.report.decisions.assumed == 0);
}

TEST_CASE("cell: turning, scaling and moving a scene moves its cell") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 5; ++round) {
        const Scene scene = random_scene(rng, 15, 3);
        const Cell cell = voronoi_cell(scene);
        const double scale = 7;
        const Cell other = voronoi_cell(moved(scene, scale, {11, -3, 5}));
        const Measures &a = cell.measures, &b = other.measures;
        CHECK(other.faces.size() == cell.faces.size());
        CHECK(other.edges.size() == cell.edges.size());
        CHECK(other.vertices.size() == cell.vertices.size());
        CHECK(other.neighbors == cell.neighbors);
        CHECK(b.volume == doctest::Approx(a.volume * scale * scale * scale).epsilon(1e-12));
        CHECK(b.area == doctest::Approx(a.area * scale * scale).epsilon(1e-12));
        CHECK(b.box_area == doctest::Approx(a.box_area * scale * scale).epsilon(1e-12));
        CHECK(b.base_area == doctest::Approx(a.base_area * scale * scale).epsilon(1e-13));
        CHECK(b.min_clearance == doctest::Approx(a.min_clearance * scale).epsilon(1e-12));
        // Attained at a vertex, whose error may be larger.
        double error = 0;
        for (const CellVertex& v : other.vertices) error = std::max(error, v.error);
        CHECK(std::abs(b.max_clearance - a.max_clearance * scale) <= 4 * error + 1e-12);
    }
}

TEST_CASE("cell: oblique frames of one scene, its axes exchanged, agree") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    for (int round = 0; round < 5; ++round) {
        Scene scene = random_scene(rng, 15, 0);
        scene.base = Plane{{0, 0, -0.6}, {0.1 * normal(rng), 0.1 * normal(rng), 1}};
        scene.box.min.z() = -1.5;
        const Cell cell = voronoi_cell(scene), other = voronoi_cell(moved(scene, 1, {0, 0, 0}));
        CHECK(other.faces.size() == cell.faces.size());
        CHECK(other.vertices.size() == cell.vertices.size());
        CHECK(other.neighbors == cell.neighbors);
        CHECK(other.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-13));
        CHECK(other.measures.area == doctest::Approx(cell.measures.area).epsilon(1e-12));
        CHECK(other.measures.box_area == doctest::Approx(cell.measures.box_area).epsilon(1e-12));
        CHECK(other.measures.max_clearance == doctest::Approx(cell.measures.max_clearance).epsilon(1e-12));
    }
}

TEST_CASE("cell: rounding noise in the base's normal does not lean the box over the base") {
    std::mt19937_64 rng(test_seed());
    Scene scene = random_scene(rng, 15, 3);
    const Cell straight = voronoi_cell(scene);
    scene.base = Plane{{0, 0, 0}, {std::sin(std::numbers::pi), -1e-17, 1}};
    const Cell noisy = voronoi_cell(scene);
    CHECK(noisy.faces.size() == straight.faces.size());
    CHECK(noisy.vertices.size() == straight.vertices.size());
    CHECK(noisy.measures.volume == doctest::Approx(straight.measures.volume).epsilon(1e-14));
    CHECK(noisy.measures.box_area == doctest::Approx(straight.measures.box_area).epsilon(1e-14));
    CHECK(straight.report.moved <= 0x1p-48);
    CHECK(noisy.report.moved > straight.report.moved);
}

TEST_CASE("cell: duplicates stay in the labels, the first one owns the face") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = {Sphere{{0.5, 0, 1}, 0.5}, Sphere{{-0.5, 0, 1}, 0.5}, Sphere{{0.5, 0, 1}, 0.5},
                     Plane{{0, 0, 1.0}, {0, 0, 1}}};
    scene.box = {{-2, -2, 0}, {2, 2, 0.5}};
    const Cell cell = voronoi_cell(scene);
    testing::check_geometry(cell);
    REQUIRE(cell.report.warnings.size() == 2);
    bool seen_sphere = false, seen_plane = false;
    for (const CellFace& face : cell.faces) {
        if (face.site == Site::object(0)) {
            seen_sphere = true;
            CHECK(face.extra_sites == std::vector{Site::object(2)});
        }
        if (face.site == Site::object(3)) {
            // Its bisector lies in the lid; an object is preferred as owner.
            seen_plane = true;
            CHECK(face.bisector == "plane");
            CHECK(face.extra_sites == std::vector{Site::box_side(5)});
        }
    }
    CHECK(seen_sphere);
    CHECK(seen_plane);
    for (const CellEdge& edge : cell.edges)
        if (edge.sites == std::array{Site::object(0), Site::object(1)})
            CHECK(edge.extra_sites == std::vector{Site::object(2)});
}

TEST_CASE("cell: progress names its stages in order and may cancel") {
    std::vector<std::string> stages;
    CellOptions options;
    options.progress = [&](const char* stage, double fraction) {
        CHECK(fraction >= 0);
        CHECK(fraction <= 1);
        if (stages.empty() || stages.back() != stage) stages.push_back(stage);
    };
    std::mt19937_64 rng(test_seed());
    voronoi_cell(random_scene(rng, 10, 0), options);
    CHECK(stages.front() == "bisectors");
    CHECK(stages.back() == "patches");
    options.progress = [](const char* stage, double) {
        if (std::string(stage) == "patches") throw std::runtime_error("cancelled");
    };
    CHECK_THROWS_WITH(voronoi_cell(random_scene(rng, 10, 0), options), "cancelled");
}

TEST_CASE("cell: bad scenes are refused before anything is computed") {
    std::mt19937_64 rng(test_seed());
    Scene scene = random_scene(rng, 3, 0);
    std::get<Sphere>(scene.objects[1]).radius = -1;
    CHECK_THROWS_AS(voronoi_cell(scene), InputError);
}

}  // namespace vcell::cell_scenes_test
