// The time of cells of spheres and cylinders, one thread:
//
//   atom/<name>  a ball among the 60 others of a molecule that are nearest to it: radial_base_problem(),
//                lower_envelope_on_sphere() and lift(), over all atoms of FOLDER/<name>.xyzr (x y z r on each
//                line)
//   around/n     n small balls on a thin shell around one ball
//   tubes        20 skew cylinders around a cylinder
//   scene/<name> Figs. 7 to 10 of [HE], as far as examples/scenes has them
//   pair/<base>/<objects>  20 random scenes of two objects over the base, of every combination, planes as
//   bases too
//
// Usage: bench_radial [--max_n=N] [--molecules=FOLDER] [Google Benchmark's options]
//
// Each is the time of voronoi_cell(), patches and measures included. Sizes above N (default 100,000) are left
// out, and atoms without FOLDER. Counters: n objects; cells; median_us and p90_us, over the cells, of each
// one's least CPU time; of that call bisectors_us, envelope_us and patches_us, wall clock, medians;
// unmeasured_us as median_us, without measures (CellOptions::measure); V, E, F (means); the signs that each rung of the ladder decided, summed up, `assumed` ones by none of them;
// warnings; the paper's own time, where it has one.
//
// Cells of up to 2000 objects are checked by check_cell(), of larger ones a hundred vertices against all
// objects; a wrong one is an error and the exit status 1.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "../envelope/voronoi_cell.hpp"
#include "../io/check/check.hpp"
#include "../io/scene_file.hpp"
#include "bench_main.hpp"
#include "median.hpp"
#include "mixed_scene.hpp"

namespace vcell::bench {
namespace {

void count(benchmark::State& state, const char* name, double value) {
    state.counters[name] = benchmark::Counter(value);
}

using bench::distance;

double distance(const Plane& plane, const Vec3& p) {
    return std::abs(plane.normal.normalized().dot(p - plane.point));
}

double distance(const Object& object, const Vec3& p) {
    return std::visit([&](const auto& o) { return distance(o, p); }, object);
}

std::string find_fault(const Cell& cell) {
    const Scene& scene = cell.scene;
    if (scene.objects.size() <= 2000) {
        CheckOptions options;
        options.samples = 50;
        const std::vector<Finding> findings = check_cell(cell, options);
        return findings.empty() ? "" : findings[0].where + ": " + findings[0].what;
    }
    const std::size_t step = std::max<std::size_t>(1, cell.vertices.size() / 100);
    for (std::size_t v = 0; v < cell.vertices.size(); v += step) {
        const CellVertex& vertex = cell.vertices[v];
        const double rounding = 1e-10 * scene.box.diagonal() + vertex.error, r = vertex.radius;
        bool fine = std::abs(distance(scene.base, vertex.point) - r) < rounding;
        for (const Site s : vertex.sites)
            fine = fine && (!s.is_object() ||
                            std::abs(distance(scene.objects[s.index], vertex.point) - r) < rounding);
        for (const Object& o : scene.objects) fine = fine && distance(o, vertex.point) > r - rounding;
        if (!fine) return "vertices[" + std::to_string(v) + "] is not equally far from its sites";
    }
    return {};
}

/// Seconds of a cell and of its stages, and of the cell without measures.
struct Times {
    double cell = HUGE_VAL, bisectors = 0, envelope = 0, patches = 0, unmeasured = HUGE_VAL;
};

double cpu_seconds() {
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double seconds_unmeasured(const Scene& scene) {
    CellOptions options;
    options.measure = false;
    const double start = cpu_seconds();
    const Cell cell = voronoi_cell(scene, options);
    return cpu_seconds() - start;
}

/// Scenes of a kind, measured together.
struct Family {
    std::string name;
    std::function<std::vector<Scene>()> make;
    double paper_seconds = 0;  ///< [HE, sec. 6], on an Intel Q6600; 0: not in the paper
};

void measure(benchmark::State& state, const Family& family) {
    const std::vector<Scene> scenes = family.make();
    std::vector<Times> best(scenes.size());
    Decisions decisions;
    std::size_t warnings = 0;
    std::array<double, 3> sizes{};
    std::string fault;
    bool first = true;
    for (auto _ : state) {
        for (std::size_t i = 0; i < scenes.size(); ++i) {
            const double start = cpu_seconds();
            const Cell cell = voronoi_cell(scenes[i]);
            const double seconds = cpu_seconds() - start;
            state.PauseTiming();
            const Report& report = cell.report;
            if (seconds < best[i].cell)
                best[i] = {seconds, report.seconds_bisectors, report.seconds_envelope,
                           report.seconds_patches, best[i].unmeasured};
            if (first) {
                decisions += report.decisions;
                warnings += report.warnings.size();
                sizes[0] += static_cast<double>(cell.vertices.size());
                sizes[1] += static_cast<double>(cell.edges.size());
                sizes[2] += static_cast<double>(cell.faces.size());
                if (fault.empty()) fault = find_fault(cell);
            }
            state.ResumeTiming();
        }
        // In turns of their own: caches are as warm or cold as for the others.
        state.PauseTiming();
        for (std::size_t k = 0; k < scenes.size(); ++k)
            best[k].unmeasured = std::min(best[k].unmeasured, seconds_unmeasured(scenes[k]));
        state.ResumeTiming();
        first = false;
    }
    if (!fault.empty()) return fail(state, fault);
    const auto times = [&](double Times::*part) {
        std::vector<double> us;
        for (const Times& t : best) us.push_back(1e6 * t.*part);
        std::ranges::sort(us);
        return us;
    };
    const std::vector<double> total = times(&Times::cell);
    const double cells = static_cast<double>(scenes.size());
    count(state, "n", static_cast<double>(scenes[0].objects.size()));
    count(state, "cells", cells);
    count(state, "median_us", median(total));
    count(state, "p90_us", total[total.size() * 9 / 10]);
    count(state, "unmeasured_us", median(times(&Times::unmeasured)));
    count(state, "bisectors_us", median(times(&Times::bisectors)));
    count(state, "envelope_us", median(times(&Times::envelope)));
    count(state, "patches_us", median(times(&Times::patches)));
    count(state, "V", sizes[0] / cells);
    count(state, "E", sizes[1] / cells);
    count(state, "F", sizes[2] / cells);
    count(state, "double", static_cast<double>(decisions.by_double));
    count(state, "interval", static_cast<double>(decisions.by_interval));
    count(state, "exact", static_cast<double>(decisions.by_exact));
    count(state, "multiprecision", static_cast<double>(decisions.by_multiprecision));
    count(state, "assumed", static_cast<double>(decisions.assumed));
    count(state, "warnings", static_cast<double>(warnings));
    count(state, "paper_seconds", family.paper_seconds);
}

// --- Scenes ------------------------------------------------------------------------------------------------

std::vector<Scene> atoms(const std::string& file) {
    constexpr std::size_t candidates = 60;
    std::ifstream in(file);
    std::vector<Sphere> balls;
    for (std::string line; std::getline(in, line);) {
        std::istringstream numbers(line);
        Sphere b;
        if (numbers >> b.center[0] >> b.center[1] >> b.center[2] >> b.radius) balls.push_back(b);
    }
    Box box{balls.at(0).center, balls.at(0).center};
    for (const Sphere& b : balls) {
        box.min = box.min.cwiseMin(b.center);
        box.max = box.max.cwiseMax(b.center);
    }
    const Vec3 margin = Vec3::Constant(box.diagonal() / 2);
    std::vector<Scene> scenes;
    for (std::size_t i = 0; i < balls.size(); ++i) {
        std::vector<std::pair<double, std::size_t>> order;
        for (std::size_t j = 0; j < balls.size(); ++j)
            if (j != i) order.emplace_back(distance(balls[j], balls[i].center), j);
        std::ranges::sort(order);
        order.resize(std::min(order.size(), candidates));
        Scene scene;
        scene.base = balls[i];
        for (const auto& [d, j] : order) scene.objects.push_back(balls[j]);
        scene.box = {box.min - margin, box.max + margin};
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

Vec3 direction(RandomLengths& random) {
    const double z = random.uniform(-1, 1), angle = random.uniform(0, 2 * std::numbers::pi),
                 r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Small balls scattered over a shell so thin that a good part of them is seen, whatever their number.
std::vector<Scene> balls_around(std::uint32_t n) {
    RandomLengths random(n);
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 1};
    while (scene.objects.size() < n)
        scene.objects.push_back(
            Sphere{random.uniform(2, 2 + 10.0 / n) * direction(random), random.uniform(0, 4.0 / n)});
    scene.box = {Vec3::Constant(-8), Vec3::Constant(8)};
    return {scene};
}

std::vector<Scene> tubes() {
    RandomLengths random(20090217);
    std::vector<Scene> scenes;
    for (int i = 0; i < 5; ++i) {
        Scene scene;
        scene.base = Cylinder{Vec3::Zero(), Vec3::UnitZ(), 0.3};
        while (scene.objects.size() < 20) {
            const Vec3 axis = direction(random),
                       place(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
            const double radius = random.uniform(0.05, 0.3), sine = axis.cross(Vec3::UnitZ()).norm();
            if (sine > 0.1 && std::abs(place.dot(axis.cross(Vec3::UnitZ()))) / sine > radius + 0.4)
                scene.objects.push_back(Cylinder{place, axis, radius});
        }
        scene.box = {Vec3::Constant(-2.5), Vec3::Constant(2.5)};
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

enum class Kind { Plane, Sphere, Cylinder };
constexpr std::array<const char*, 3> kind_names{"plane", "sphere", "cylinder"};

/// A base of radius 0.3 at the origin, or the plane z = 0; cylinders are along z.
Object base_of(Kind kind) {
    if (kind == Kind::Plane) return Plane{Vec3::Zero(), Vec3::UnitZ()};
    if (kind == Kind::Sphere) return Sphere{Vec3::Zero(), 0.3};
    return Cylinder{Vec3::Zero(), Vec3::UnitZ(), 0.3};
}

/// An object clear of that base in the box |x|, |y|, |z| <= 2.5.
Object clear_object(RandomLengths& random, Kind kind, Kind base) {
    while (true) {
        const Vec3 u = direction(random),
                   place(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
        const double radius = random.uniform(0.05, 0.4);
        if (kind == Kind::Plane) {
            if (base == Kind::Plane)
                return Plane{Vec3(0, 0, random.uniform(1, 2)), Vec3(0.1 * u.x(), 0.1 * u.y(), 1)};
            const Vec3 normal = base == Kind::Cylinder ? Vec3(u.x(), u.y(), 0.1 * u.z()).normalized() : u;
            const double distance = random.uniform(1, 2);
            // Clear of the whole stretch.
            if (base == Kind::Cylinder && distance - 2.5 * std::abs(normal.z()) < 0.4) continue;
            return Plane{distance * normal, normal};
        }
        const Vec3 across = u.cross(Vec3::UnitZ());
        if (kind == Kind::Sphere) {
            const double base_distance = base == Kind::Plane      ? place.z()
                                         : base == Kind::Cylinder ? place.head<2>().norm()
                                                                  : place.norm();
            if (base_distance > radius + 0.4) return Sphere{place, radius};
            continue;
        }
        if (across.norm() < 0.1) continue;
        if (base == Kind::Plane) {
            // The axis sinks by less than 0.1 a unit of its way across the square.
            const Vec3 axis(u.x() / across.norm(), u.y() / across.norm(), 0.1 * u.z());
            if (place.z() > radius + 0.6) return Cylinder{place, axis, radius};
            continue;
        }
        const double axis_distance =
            base == Kind::Cylinder ? std::abs(place.dot(across)) / across.norm() : place.cross(u).norm();
        if (axis_distance > radius + 0.4) return Cylinder{place, u, radius};
    }
}

std::vector<Scene> pairs(Kind base, Kind a, Kind b) {
    RandomLengths random(1);
    std::vector<Scene> scenes;
    for (int i = 0; i < 20; ++i) {
        Scene scene;
        scene.base = base_of(base);
        scene.objects = {clear_object(random, a, base), clear_object(random, b, base)};
        scene.box = {Vec3::Constant(-2.5), Vec3::Constant(2.5)};
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

// --- Benches -----------------------------------------------------------------------------------------------

std::string take_molecules(int& argc, char** argv) {
    constexpr char option[] = "--molecules=";
    std::string folder;
    int kept = 1;
    for (int i = 1; i < argc; ++i) {
        if (std::strncmp(argv[i], option, sizeof(option) - 1) == 0)
            folder = argv[i] + sizeof(option) - 1;
        else
            argv[kept++] = argv[i];
    }
    argc = kept;
    return folder;
}

void register_all(std::uint32_t max_n, const std::string& molecules) {
    const auto add = [](const Family& family) {
        return benchmark::RegisterBenchmark(family.name.c_str(), measure, family)
            ->Unit(benchmark::kMillisecond);
    };
    if (!molecules.empty())
        for (const std::string name : {"1CRN", "1AKI"})
            add({"atom/" + name, [=] { return atoms(molecules + "/" + name + ".xyzr"); }});
    for (const std::uint32_t n : {100, 1000, 10000, 100000})
        if (n <= max_n) add({"around/" + std::to_string(n), [n] { return balls_around(n); }});
    add({"tubes", tubes});
    for (const auto& [name, seconds] : {std::pair<std::string, double>{"figure7", 0},
                                        {"figure8", 2.9},
                                        {"figure9", 0.65},
                                        {"figure10", 4.1}}) {
        const std::string file = VCELL_SCENES "/" + name + ".json";
        if (std::filesystem::exists(file))
            add({"scene/" + name, [file] { return std::vector{read_scene(file)}; }, seconds});
    }
    constexpr std::array kinds{Kind::Plane, Kind::Sphere, Kind::Cylinder};
    const auto name = [](Kind k) { return std::string(kind_names[static_cast<std::size_t>(k)]); };
    for (const Kind base : kinds)
        for (const Kind a : kinds)
            for (const Kind b : kinds)
                if (a <= b)
                    add({"pair/" + name(base) + "/" + name(a) + "-" + name(b),
                         [=] { return pairs(base, a, b); }});
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    const std::string molecules = vcell::bench::take_molecules(argc, argv);
    const auto max_n = vcell::bench::take_max_n(argc, argv, 100000, 100);
    if (!max_n) return 1;
    vcell::bench::register_all(*max_n, molecules);
    return vcell::bench::run_benchmarks(argc, argv);
}
