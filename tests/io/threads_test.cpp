// Cells that several threads compute and write are those of one, byte for byte.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/cell_file.hpp"
#include "../test_support.hpp"

using namespace vcell;

namespace {

// Enough of them that the region comes in several blocks, and elements in several tasks.
constexpr int many = 4000;

Scene over_plane(double side, const Vec3& normal = {0, 0, 1}) {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, normal};
    scene.box = {{-side, -side, -side}, {side, side, side}};
    return scene;
}

Scene random_balls(std::mt19937_64& rng, const Vec3& normal = {0, 0, 1}) {
    const double side = 0.5 * std::sqrt(many);
    Scene scene = over_plane(side, normal);
    std::uniform_real_distribution<double> at(-side, side), up(0.5, 2), radius(0, 0.25);
    for (int i = 0; i < many; ++i) {
        Vec3 c(at(rng), at(rng), 0);
        c.z() = -(normal.x() * c.x() + normal.y() * c.y()) / normal.z();
        scene.objects.push_back(Sphere{c + up(rng) * normal.normalized(), radius(rng)});
    }
    return scene;
}

// Every inner vertex is equally far from four balls.
Scene lattice() {
    constexpr int n = 50;
    Scene scene = over_plane(n);
    scene.box = {{0, 0, 0}, {n, n, 4}};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) scene.objects.push_back(Sphere{{i + 0.5, j + 0.5, 0.75}, 0.25});
    return scene;
}

Scene balls_around_one(std::mt19937_64& rng) {
    constexpr int count = 1800;
    Scene scene;
    const Vec3 center(0.1, 0.2, -0.3);
    scene.base = Sphere{center, 1};
    scene.box = {{-8, -8, -8}, {8, 8, 8}};
    std::normal_distribution<double> direction;
    std::uniform_real_distribution<double> away(2, 2.001), radius(0, 0.0004);
    for (int i = 0; i < count; ++i) {
        const Vec3 d(direction(rng), direction(rng), direction(rng));
        scene.objects.push_back(Sphere{center + away(rng) * d.normalized(), radius(rng)});
    }
    return scene;
}

Cell cell_on(unsigned threads, const Scene& scene, CellOptions options = {}) {
    options.threads = threads;
    Cell cell = voronoi_cell(scene, options);
    Report& r = cell.report;
    r.seconds_bisectors = r.seconds_envelope = r.seconds_patches = 0;
    return cell;
}

std::string text_on(unsigned threads, const Cell& cell) {
    std::ostringstream out;
    write_cell(out, cell, threads);
    return out.str();
}

// So many faces come in several tasks; where tubes compete few faces do.
void check_threads(const Scene& scene, const CellOptions& options = {}, std::size_t least_faces = 1600) {
    const Cell alone = cell_on(1, scene, options);
    const std::string text = text_on(1, alone);
    REQUIRE(alone.faces.size() > least_faces);
    const std::vector<unsigned> counts = rounds() > 1 ? std::vector{2u, 3u, 8u} : std::vector{3u};
    for (const unsigned threads : counts) {
        CAPTURE(threads);
        const bool is_same = text_on(threads, cell_on(threads, scene, options)) == text;
        CHECK(is_same);
    }
}

// Balls, and level tubes and lines, that keep clear of a base about the origin or the z axis, or in z = 0.
Scene rods_and_balls(std::mt19937_64& rng, const Object& base) {
    constexpr double clear = 0.5;
    Scene scene;
    scene.base = base;
    scene.box = {{-3, -3, -3}, {3, 3, 3}};
    std::uniform_real_distribution<double> at(-3, 3), angle(0, 7), radius(0, 0.1);
    while (scene.objects.size() < 24) {
        const Vec3 p(at(rng), at(rng), at(rng));
        const double a = angle(rng), r = scene.objects.size() % 4 == 0 ? 0 : radius(rng);
        const bool is_tube = scene.objects.size() % 3 != 0;
        const double beside =
            is_tube ? std::abs(p.x() * std::sin(a) - p.y() * std::cos(a)) : std::hypot(p.x(), p.y());
        if (beside < clear || std::abs(p.z()) < clear) continue;
        if (is_tube)
            scene.objects.push_back(Cylinder{p, {std::cos(a), std::sin(a), 0}, r});
        else
            scene.objects.push_back(Sphere{p, r});
    }
    return scene;
}

struct Cancel {};

}  // namespace

TEST_CASE("threads: a cell's bytes are the same for any number of them") {
    std::mt19937_64 rng(test_seed());
    SUBCASE("random balls") { check_threads(random_balls(rng)); }
    SUBCASE("a lattice of equal balls") { check_threads(lattice()); }
    SUBCASE("a tilted plane's complete cell, with planes and a rod") {
        Scene scene = random_balls(rng, {0.1, -0.2, 1});
        scene.objects.push_back(Plane{{0, 0, 30}, {0.05, 0, -1}});
        CellOptions options;
        options.complete = true;
        check_threads(scene, options);
        scene.objects.push_back(Cylinder{{0, 0, 12}, {1, 0.2, 0}, 0.5});
        check_threads(scene);
    }
    SUBCASE("balls around one, without patches, with a cap, with a rod") {
        Scene scene = balls_around_one(rng);
        check_threads(scene);
        CellOptions bare;
        bare.patches = false;
        check_threads(scene, bare);
        scene.probe = 0.505;
        check_threads(scene);
        scene.probe.reset();
        scene.objects.push_back(Cylinder{{0, 0, 1.9}, {1, 0.2, 0}, 0.05});
        check_threads(scene);
    }
}

TEST_CASE("threads: cells among tubes have the same bytes for any number of them") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round) {
        check_threads(rods_and_balls(rng, Plane{{0, 0, 0}, {0, 0, 1}}), {}, 4);
        check_threads(rods_and_balls(rng, Sphere{{0, 0, 0}, 0.2}), {}, 4);
        check_threads(rods_and_balls(rng, Cylinder{{0, 0, 0}, {0, 0, 1}, 0.1}), {}, 4);
    }
}

TEST_CASE("threads: what is refused is refused with the same words for any number of them") {
    // The point is so near to the line that pieces of the box's size tell nothing.
    Scene scene;
    scene.base = Cylinder{{0, 0, 0}, {0, 0, 1}, 0};
    scene.objects = {Sphere{{-4e-9, -3e-9, -0.7}, 0}, Cylinder{{0, 1, 0}, {1, 0, 0}, 0.1}};
    scene.box = {{-2, -2, -2}, {2, 2, 2}};
    const auto outcome = [&](unsigned threads) {
        try {
            return text_on(1, cell_on(threads, scene));
        } catch (const UndecidedError& e) {
            return std::string(e.what());
        }
    };
    const std::string alone = outcome(1);
    for (const unsigned threads : {2u, 3u, 8u}) CHECK(outcome(threads) == alone);
}

TEST_CASE("threads: who cancels gets the own exception back, whatever other threads do") {
    std::mt19937_64 rng(test_seed());
    const Scene scene = random_balls(rng);
    const std::thread::id caller = std::this_thread::get_id();
    for (const unsigned threads : {1u, 2u, 3u, 8u})
        for (const double until : {0.0, 0.3, 0.9}) {
            CAPTURE(threads);
            CAPTURE(until);
            bool is_caller = true;
            double last = 0;
            CellOptions options;
            options.progress = [&](const char* stage, double fraction) {
                is_caller = is_caller && std::this_thread::get_id() == caller;
                if (std::string(stage) != "envelope") return;
                CHECK(fraction >= last);
                last = fraction;
                if (fraction >= until) throw Cancel{};
            };
            CHECK_THROWS_AS(cell_on(threads, scene, options), Cancel);
            CHECK(is_caller);
        }
}

TEST_CASE("threads: what cannot be written is the same error for any number of them") {
    std::mt19937_64 rng(test_seed());
    CellOptions options;
    options.measure = false;
    const Cell cell = cell_on(2, random_balls(rng), options);
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        CAPTURE(threads);
        CHECK_THROWS_WITH_AS(text_on(threads, cell), "a number to be written is not finite", InternalError);
    }
}
