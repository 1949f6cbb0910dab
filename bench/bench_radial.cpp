// The time of cells of spheres and cylinders, one thread:
//
//   atom/<name>  the complete cell of a ball in a molecule, FOLDER/<name>.xyzr (x y z r on each line), over
//   all of
//                its balls: among the 30 others that are nearest, and where its largest clearance says that
//                more may matter, once more among all that do. Finding the nearest is not in the time. The
//                volumes must fill the molecule's box
//   around/n     n small balls on a thin shell around one ball
//   tubes        20 skew cylinders around a cylinder
//   scene/<name> scenes of examples/scenes: Figs. 7 to 10 of [HE], and others of balls and tubes
//   pair/<base>/<objects>  20 random scenes of two objects over the base, of every combination, planes as
//   bases too
//
// Usage: bench_radial [--max_n=N] [--molecules=FOLDER] [Google Benchmark's options]
//
// Each is the time of voronoi_cell(), patches and measures included. Sizes above N (default 100,000) are left
// out, and atoms without FOLDER. Counters: n objects (mean); cells; median_us and p90_us, over the cells, of
// each one's least CPU time; first_us, the median of each one's first call in this process, which meets cold
// caches and fresh memory; of the least call bisectors_us, envelope_us and patches_us, wall clock, medians;
// unmeasured_us as median_us, without measures (CellOptions::measure); V, E, F (means); the signs that each
// rung of the ladder decided, summed up, `assumed` ones by none of them; warnings; the paper's own time,
// where it has one.
//
// Cells of up to 2000 objects are checked by certify(), of larger ones a hundred vertices against all
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
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "../envelope/voronoi_cell.hpp"
#include "../io/files/scene_file.hpp"
#include "bench_main.hpp"
#include "cell_check.hpp"
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

double distance(const HollowSphere& vessel, const Vec3& p) {
    return vessel.radius - (p - vessel.center).norm();
}
double distance(const HollowCone& vessel, const Vec3& p) {
    const Vec3 axis = vessel.axis.normalized(), way = p - vessel.apex;
    return vessel.sine() * axis.dot(way) - vessel.cosine() * axis.cross(way).norm();
}
double distance(const HollowCylinder& vessel, const Vec3& p) {
    return -distance(Cylinder{vessel.point, vessel.axis, vessel.radius}, p);
}

double distance(const Object& object, const Vec3& p) {
    return std::visit([&](const auto& o) { return distance(o, p); }, object);
}

std::string find_fault(const Cell& cell) {
    const Scene& scene = cell.scene;
    if (scene.objects.size() <= 2000) return find_refuted(cell, 50);
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
    double cell = HUGE_VAL, first = 0, bisectors = 0, envelope = 0, patches = 0, unmeasured = HUGE_VAL;
};

double cpu_seconds() {
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// A cell to be computed, again and again.
using CellCase = std::function<Cell(const CellOptions&)>;

double seconds_unmeasured(const CellCase& at) {
    CellOptions options;
    options.measure = false;
    const double start = cpu_seconds();
    const Cell cell = at(options);
    return cpu_seconds() - start;
}

/// Cells of a kind, measured together.
struct Family {
    std::string name;
    std::function<std::vector<CellCase>()> make;
    double paper_seconds = 0;  ///< [HE, sec. 6], on an Intel Q6600; 0: not in the paper
    bool fills_box = false;    ///< the volumes of the cells add up to their box
    std::shared_ptr<std::vector<double>> first =
        std::make_shared<std::vector<double>>();  ///< seconds, once known
};

std::vector<CellCase> cells_of(std::vector<Scene> scenes) {
    std::vector<CellCase> cells;
    for (Scene& scene : scenes)
        cells.push_back(
            [scene = std::move(scene)](const CellOptions& options) { return voronoi_cell(scene, options); });
    return cells;
}

void measure(benchmark::State& state, const Family& family) {
    const std::vector<CellCase> cases = family.make();
    std::vector<Times> best(cases.size());
    Decisions decisions;
    std::size_t warnings = 0, objects = 0;
    std::array<double, 3> sizes{};
    double volume = 0, volume_error = 0, box_volume = 0;
    std::string fault;
    bool first = true;
    for (auto _ : state) {
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const double start = cpu_seconds();
            const Cell cell = cases[i]({});
            const double seconds = cpu_seconds() - start;
            state.PauseTiming();
            const Report& report = cell.report;
            if (family.first->size() == i) family.first->push_back(seconds);
            if (seconds < best[i].cell)
                best[i] = {seconds,
                           family.first->at(i),
                           report.seconds_bisectors,
                           report.seconds_envelope,
                           report.seconds_patches,
                           best[i].unmeasured};
            if (first) {
                objects += cell.scene.objects.size();
                volume += cell.measures.volume;
                volume_error += cell.measures.volume_error;
                box_volume = (cell.scene.box.max - cell.scene.box.min).prod();
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
        for (std::size_t k = 0; k < cases.size(); ++k)
            best[k].unmeasured = std::min(best[k].unmeasured, seconds_unmeasured(cases[k]));
        state.ResumeTiming();
        first = false;
    }
    // Sums round too.
    if (family.fills_box && std::abs(volume - box_volume) > volume_error + 1e-12 * box_volume)
        fault =
            "the volumes add up to " + std::to_string(volume) + ", the box has " + std::to_string(box_volume);
    if (!fault.empty()) return fail(state, fault);
    const auto times = [&](double Times::*part) {
        std::vector<double> us;
        for (const Times& t : best) us.push_back(1e6 * t.*part);
        std::ranges::sort(us);
        return us;
    };
    const std::vector<double> total = times(&Times::cell);
    const double cells = static_cast<double>(cases.size());
    count(state, "n", static_cast<double>(objects) / cells);
    count(state, "cells", cells);
    count(state, "median_us", median(total));
    count(state, "p90_us", total[total.size() * 9 / 10]);
    count(state, "first_us", median(times(&Times::first)));
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

/// The balls of a molecule; for each the others by the distance of their surface from its own.
struct Molecule {
    struct Neighbor {
        double gap;
        std::uint32_t ball;
        friend auto operator<=>(const Neighbor&, const Neighbor&) = default;
    };
    std::vector<Sphere> balls;
    std::vector<std::vector<Neighbor>> nearest;
    Box box;
};

Molecule read_molecule(const std::string& file) {
    Molecule m;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        std::istringstream numbers(line);
        Sphere b;
        if (numbers >> b.center[0] >> b.center[1] >> b.center[2] >> b.radius) m.balls.push_back(b);
    }
    m.box = {m.balls.at(0).center, m.balls.at(0).center};
    for (const Sphere& b : m.balls) {
        m.box.min = m.box.min.cwiseMin(b.center - Vec3::Constant(b.radius));
        m.box.max = m.box.max.cwiseMax(b.center + Vec3::Constant(b.radius));
    }
    const Vec3 margin = Vec3::Constant(5);  // angstroms: the outermost atoms have room, but not for ever
    m.box = {m.box.min - margin, m.box.max + margin};
    for (std::uint32_t i = 0; i < m.balls.size(); ++i) {
        m.nearest.emplace_back();
        for (std::uint32_t j = 0; j < m.balls.size(); ++j)
            if (j != i)
                m.nearest[i].push_back({distance(m.balls[j], m.balls[i].center) - m.balls[i].radius, j});
        std::ranges::sort(m.nearest[i]);
    }
    return m;
}

/// A point of the cell is at most its largest clearance away from the ball, and from no other ball less than
/// from that one: a ball further away than twice the clearance comes into no cell. More balls only lower it.
Cell complete_cell(const Molecule& m, std::uint32_t ball, const CellOptions& options) {
    constexpr std::size_t at_first = 30;
    const auto& nearest = m.nearest[ball];
    Scene scene;
    scene.base = m.balls[ball];
    scene.box = m.box;
    std::size_t count = std::min(at_first, nearest.size());
    while (true) {
        for (std::size_t k = scene.objects.size(); k < count; ++k)
            scene.objects.push_back(m.balls[nearest[k].ball]);
        Cell cell = voronoi_cell(scene, options);
        // Without measures the vertices speak for it, though an ellipse may reach further between them: such
        // cells are timed and not used.
        double clearance = 0;
        for (const CellVertex& v : cell.vertices) clearance = std::max(clearance, v.radius + v.error);
        if (options.measure) clearance = std::max(clearance, cell.measures.max_clearance);
        const auto beyond = std::ranges::upper_bound(nearest, 2 * clearance, {}, &Molecule::Neighbor::gap);
        const auto needed = static_cast<std::size_t>(beyond - nearest.begin());
        if (needed <= count) return cell;
        count = needed;
    }
}

std::vector<CellCase> atoms(const std::string& file) {
    const auto molecule = std::make_shared<const Molecule>(read_molecule(file));
    std::vector<CellCase> cells;
    for (std::uint32_t i = 0; i < molecule->balls.size(); ++i)
        cells.push_back(
            [molecule, i](const CellOptions& options) { return complete_cell(*molecule, i, options); });
    return cells;
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
            add({"atom/" + name, [=] { return atoms(molecules + "/" + name + ".xyzr"); }, 0, true});
    for (const std::uint32_t n : {100, 1000, 10000, 100000})
        if (n <= max_n) add({"around/" + std::to_string(n), [n] { return cells_of(balls_around(n)); }});
    add({"tubes", [] { return cells_of(tubes()); }});
    for (const auto& [name, seconds] : {std::pair<std::string, double>{"figure7", 0},
                                        {"figure8", 2.9},
                                        {"figure9", 0.65},
                                        {"figure10", 4.1},
                                        {"four_balls_two_planes", 0},
                                        {"ball_tube_plane", 0},
                                        {"tube_three_balls_plane", 0}}) {
        const std::string file = VCELL_SCENES "/" + name + ".json";
        if (std::filesystem::exists(file))
            add({"scene/" + name, [file] { return cells_of({read_scene(file)}); }, seconds});
    }
    constexpr std::array kinds{Kind::Plane, Kind::Sphere, Kind::Cylinder};
    const auto name = [](Kind k) { return std::string(kind_names[static_cast<std::size_t>(k)]); };
    for (const Kind base : kinds)
        for (const Kind a : kinds)
            for (const Kind b : kinds)
                if (a <= b)
                    add({"pair/" + name(base) + "/" + name(a) + "-" + name(b),
                         [=] { return cells_of(pairs(base, a, b)); }});
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
