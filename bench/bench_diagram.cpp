// The time of whole diagrams, search, proofs of completeness, areas and volumes included:
//
//   molecule/<name>  all atoms of FOLDER/<name>.xyzr in a box with 5 of room on every side
//   packing/n        n disjoint balls of radii up to 5:1 in a box that repeats
//   random/n         n points in a cube
//   tubes/n          n disjoint tubes that run through a cube in all directions
//   lattice/<kind>   cubic, bcc, fcc: equal balls in a box that repeats, where every vertex is degenerate;
//   and jittered/<kind>  the same, each moved a little
//
// Usage: bench_diagram [--max_n=N] [--threads=T] [--molecules=FOLDER] [Google Benchmark's options]
//
// Sizes above N (default 10,000) are left out, and molecules without FOLDER. T: default 1. Counters: n
// objects; us_per_object; contacts; candidates, the mean number of objects that a cell was computed among;
// volume_error, the bound on the sum of all volumes as a part of the box's.
//
// Every diagram must fill its box and its cells agree about their faces; otherwise it is an error and the
// exit status 1.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include "../envelope/voronoi_diagram.hpp"
#include "bench_main.hpp"
#include "growth_scene.hpp"

namespace vcell::bench {
namespace {

using Maker = std::function<DiagramScene()>;

unsigned threads = 1;

void measure(benchmark::State& state, const Maker& make) {
    const DiagramScene scene = make();
    DiagramOptions options;
    options.threads = threads;
    VoronoiDiagram diagram;
    for (auto _ : state) diagram = voronoi_diagram(scene, options);
    const ContactTable table = contacts(diagram);
    const FilledVolume sum = filled_volume(scene, diagram);
    double candidates = 0;
    for (const DiagramCell& cell : diagram.cells) {
        candidates += cell.candidates;
        if (cell.state == DiagramCell::State::Undecided) return fail(state, cell.reason);
    }
    if (!table.faults.empty()) return fail(state, table.faults.front());
    if (!sum.fills()) return fail(state, "the cells do not fill the box");
    const auto n = static_cast<double>(scene.objects.size());
    state.counters["n"] = n;
    state.counters["us_per_object"] = benchmark::Counter(
        1e-6 * n, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["contacts"] = static_cast<double>(table.contacts.size());
    state.counters["candidates"] = candidates / n;
    state.counters["volume_error"] = sum.error / sum.box;
}

void add(const std::string& name, const Maker& make) {
    benchmark::RegisterBenchmark(name.c_str(), [make](benchmark::State& state) { measure(state, make); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

DiagramScene molecule(const std::filesystem::path& file) {
    DiagramScene scene;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        Sphere ball;
        if (words >> ball.center[0] >> ball.center[1] >> ball.center[2] >> ball.radius)
            scene.objects.push_back(ball);
    }
    const Vec3 first = std::get<Sphere>(scene.objects.front()).center;
    scene.box = {first, first};
    for (const Object& o : scene.objects) {
        const Vec3& c = std::get<Sphere>(o).center;
        scene.box.min = scene.box.min.cwiseMin(c - Vec3::Constant(5));
        scene.box.max = scene.box.max.cwiseMax(c + Vec3::Constant(5));
    }
    return scene;
}

DiagramScene points(std::uint32_t n) {
    RandomLengths random(1);
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    for (std::uint32_t i = 0; i < n; ++i)
        scene.objects.push_back(
            Sphere{{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)}, 0});
    return scene;
}

// Balls on a lattice of unit cells, each shrunk to a fifth of its room and moved within it: disjoint.
DiagramScene packing(std::uint32_t n) {
    RandomLengths random(2);
    const auto side = static_cast<std::uint32_t>(std::ceil(std::cbrt(n)));
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(side)};
    scene.periodic = {true, true, true};
    for (std::uint32_t i = 0; i < n; ++i) {
        const double radius = random.uniform(0.1, 0.5), room = 0.5 - radius;
        const Vec3 cell(i % side, (i / side) % side, i / side / side);
        scene.objects.push_back(Sphere{
            cell + Vec3::Constant(0.5) +
                Vec3(random.uniform(-room, room), random.uniform(-room, room), random.uniform(-room, room)),
            radius});
    }
    return scene;
}

DiagramScene lattice(const std::vector<Vec3>& places, double jitter) {
    constexpr int cells = 10;
    RandomLengths random(3);
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(2 * cells)};
    scene.periodic = {true, true, true};
    for (int i = 0; i < cells * cells * cells; ++i)
        for (const Vec3& p : places) {
            const Vec3 moved(random.uniform(-jitter, jitter), random.uniform(-jitter, jitter),
                             random.uniform(-jitter, jitter));
            scene.objects.push_back(
                Sphere{2.0 * Vec3(i % cells, i / cells % cells, i / cells / cells) + p + moved, 0.25});
        }
    return scene;
}

// As many to a square of the cube's sides whatever their number.
DiagramScene tubes(std::uint32_t n) {
    constexpr double radius = 0.12, gap = 1e-3;
    RandomLengths random(5);
    const double side = std::sqrt(n);
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(side)};
    const auto is_clear = [&](const Cylinder& tube) {
        return std::ranges::all_of(scene.objects, [&](const Object& o) {
            const auto& other = std::get<Cylinder>(o);
            const Vec3 across = tube.axis.cross(other.axis).stableNormalized();
            return std::abs(across.dot(tube.point - other.point)) > 2 * radius + gap;
        });
    };
    while (scene.objects.size() < n) {
        const Vec3 point(random.uniform(0, side), random.uniform(0, side), random.uniform(0, side)),
            axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const Cylinder tube{point, axis, radius};
        if (axis.norm() < 1 && is_clear(tube)) scene.objects.push_back(tube);
    }
    return scene;
}

// Takes an option's value out of the arguments.
std::string take(int& argc, char** argv, const char* option) {
    std::string value;
    int kept = 1;
    for (int i = 1; i < argc; ++i) {
        if (std::strncmp(argv[i], option, std::strlen(option)) == 0)
            value = argv[i] + std::strlen(option);
        else
            argv[kept++] = argv[i];
    }
    argc = kept;
    return value;
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    using namespace vcell::bench;
    using vcell::Vec3;
    const auto max_n = take_max_n(argc, argv, 10'000, 100);
    if (!max_n) return 1;
    if (const std::string value = take(argc, argv, "--threads="); !value.empty())
        threads = static_cast<unsigned>(std::strtoul(value.c_str(), nullptr, 10));
    if (const std::string folder = take(argc, argv, "--molecules="); !folder.empty())
        for (const char* name : {"1CRN", "1AKI", "4HHB", "4YVS"}) {
            const std::filesystem::path file = std::filesystem::path(folder) / (std::string(name) + ".xyzr");
            add(std::string("molecule/") + name, [file] { return molecule(file); });
        }
    for (const std::uint32_t n : {100u, 1'000u, 10'000u, 100'000u, 1'000'000u}) {
        if (n > *max_n) continue;
        add("packing/" + std::to_string(n), [n] { return packing(n); });
        add("random/" + std::to_string(n), [n] { return points(n); });
    }
    for (const std::uint32_t n : {20u, 100u})
        if (n <= *max_n) add("tubes/" + std::to_string(n), [n] { return tubes(n); });
    const std::vector<std::pair<const char*, std::vector<Vec3>>> lattices{
        {"cubic", {{0, 0, 0}}},
        {"bcc", {{0, 0, 0}, {1, 1, 1}}},
        {"fcc", {{0, 0, 0}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}}}};
    for (const auto& [name, places] : lattices) {
        add(std::string("lattice/") + name, [places = places] { return lattice(places, 0); });
        add(std::string("jittered/") + name, [places = places] { return lattice(places, 0x1p-5); });
    }
    return run_benchmarks(argc, argv);
}
