// The time of scenes with cylinders over a plane base, one thread:
//
//   scene      voronoi_cell() of Fig. 5 and Fig. 6 of [HE], of its Table 3 (planes and balls alone) and of
//   the
//              piles in examples/scenes, patches and measures included, at the tolerance 1e-7 of the diagonal
//   pile       the same for random piles of 50 ... 2000 balls and rods at constant density, with the fit to
//              c n log n
//   trisector  the trisector of the base, a cylinder and a sphere (psc) or a second cylinder (pcc), proved
//              and fitted: lower_envelope() of their heights and MixedArcs at 1e-4 and 1e-7 of the diagonal
//              of the cube [-1, 1]^2 x [0, 2], 200 random pairs each
//
// Usage: bench_mixed [--max_n=N] [Google Benchmark's options]
//
// Piles above N (default 2000) are left out. Counters of cells: n objects; V, E, F; the signs that each rung
// of the ladder decided, `assumed` ones by none of them; warnings; the seconds of the last call's stages,
// wall clock; the paper's own time, where it has one. Counters of trisectors: pairs; median_us, p90_us,
// mean_us and max_us, over the pairs, of each pair's least CPU time; spans (mean); the signs, summed up over
// the pairs.
//
// Cells are checked by certify(), trisectors at points of their splines; a wrong one is an error and the
// exit status 1.
#include <algorithm>
#include <ctime>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "../envelope/lift/mixed_arc.hpp"
#include "../envelope/voronoi_cell.hpp"
#include "../io/files/scene_file.hpp"
#include "../primitives/fit/arc_equations.hpp"
#include "bench_main.hpp"
#include "cell_check.hpp"
#include "mixed_scene.hpp"

namespace vcell::bench {
namespace {

void count(benchmark::State& state, const char* name, double value) {
    state.counters[name] = benchmark::Counter(value);
}

void count(benchmark::State& state, const Decisions& d) {
    count(state, "double", static_cast<double>(d.by_double));
    count(state, "interval", static_cast<double>(d.by_interval));
    count(state, "exact", static_cast<double>(d.by_exact));
    count(state, "multiprecision", static_cast<double>(d.by_multiprecision));
    count(state, "assumed", static_cast<double>(d.assumed));
}

/// A scene, made when it is first measured, and checked once through all calls that its measurement takes.
struct CellCase {
    std::function<Scene()> make;
    double paper_seconds = 0;  ///< [HE, sec. 6], on an Intel Q6600; 0: not in the paper
    std::optional<Scene> scene = {};
    bool checked = false;
};

void measure_cell(benchmark::State& state, CellCase& at) {
    if (!at.scene) at.scene = at.make();
    std::optional<Cell> cell;
    for (auto _ : state) {
        if (cell) {  // its destruction is not the call's
            state.PauseTiming();
            cell.reset();
            state.ResumeTiming();
        }
        cell = voronoi_cell(*at.scene);
    }
    if (!at.checked) {
        const std::string fault = find_refuted(*cell, 200);
        if (!fault.empty()) return fail(state, fault);
        at.checked = true;
    }
    const std::size_t n = at.scene->objects.size();
    state.SetComplexityN(static_cast<std::int64_t>(n));
    count(state, "n", static_cast<double>(n));
    count(state, "V", static_cast<double>(cell->vertices.size()));
    count(state, "E", static_cast<double>(cell->edges.size()));
    count(state, "F", static_cast<double>(cell->faces.size()));
    count(state, cell->report.decisions);
    count(state, "warnings", static_cast<double>(cell->report.warnings.size()));
    count(state, "seconds_bisectors", cell->report.seconds_bisectors);
    count(state, "seconds_envelope", cell->report.seconds_envelope);
    count(state, "seconds_patches", cell->report.seconds_patches);
    count(state, "paper_seconds", at.paper_seconds);
}

/// A pair of objects whose trisector with the base crosses the region.
struct PairCase {
    Scene scene;
    PlaneBaseProblem problem;
    ConvexRegion region;

    explicit PairCase(Scene s) : scene(std::move(s)), problem(plane_base_problem(scene)) {
        for (const RegionSide& side : problem.region) region.sides.push_back({side.a, side.b, side.c});
    }
    bool is_trisector(const MinimizationDiagram& diagram, EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram.edges[e];
        return !edge.on_rim() && problem.sites[edge.left][0].is_object() &&
               problem.sites[edge.right][0].is_object();
    }
    bool has_trisector(const MinimizationDiagram& diagram) const {
        for (const EdgeId e : diagram.edges.ids())
            if (is_trisector(diagram, e)) return true;
        return false;
    }
};

std::vector<PairCase> random_pairs(bool with_sphere) {
    constexpr std::size_t pairs = 200;
    RandomLengths random(20090217);
    std::vector<PairCase> cases;
    while (cases.size() < pairs) {
        PairCase c(random_pair(random, with_sphere));
        const MinimizationDiagram diagram = lower_envelope(c.problem.family, c.region);
        if (c.has_trisector(diagram)) cases.push_back(std::move(c));
    }
    return cases;
}

/// Points of the splines are equally far from the base and both objects, to twice the stated error.
std::string find_fault(const PairCase& c, const MinimizationDiagram& diagram, const MixedArcs& arcs,
                       double tolerance) {
    for (const EdgeId e : diagram.edges.ids()) {
        if (!c.is_trisector(diagram, e)) continue;
        const double error = arcs.error(e).edge;
        if (!(error <= tolerance)) return to_string(e) + " is not fitted to the tolerance";
        for (const SpaceSpan& span : arcs.curves().splines(e))
            for (int i = 0; i <= 16; ++i) {
                const Vec3 p = c.problem.frame.to_world(space_fit::point(span.points, i / 16.0).head<3>());
                for (const Object& object : c.scene.objects) {
                    const double d = std::holds_alternative<Sphere>(object)
                                         ? distance(std::get<Sphere>(object), p)
                                         : distance(std::get<Cylinder>(object), p);
                    constexpr double rounding = 1e-12;
                    if (std::abs(d - p.z()) > 2 * error + rounding)
                        return to_string(e) + " leaves a bisector by " + std::to_string(d - p.z());
                }
            }
    }
    return {};
}

void measure_trisectors(benchmark::State& state, bool with_sphere, double relative_tolerance) {
    const std::vector<PairCase> cases = random_pairs(with_sphere);
    const double tolerance = relative_tolerance * std::sqrt(12.0);
    std::vector<double> least(cases.size(), std::numeric_limits<double>::infinity());
    Decisions decisions;
    std::size_t spans = 0;
    std::string fault;
    for (auto _ : state) {
        decisions = {};
        spans = 0;
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const std::clock_t start = std::clock();
            const MinimizationDiagram diagram = lower_envelope(cases[i].problem.family, cases[i].region);
            const FaceLoops loops(diagram, true);
            const MixedArcs arcs(cases[i].problem, diagram, loops, tolerance, 1);
            least[i] = std::min(least[i], 1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
            state.PauseTiming();
            decisions += diagram.decisions;
            for (const EdgeId e : diagram.edges.ids())
                if (cases[i].is_trisector(diagram, e)) spans += arcs.curves().size(e);
            if (fault.empty()) {
                fault = find_fault(cases[i], diagram, arcs, tolerance);
                if (!fault.empty()) fault = "pair " + std::to_string(i) + ": " + fault;
            }
            state.ResumeTiming();
        }
    }
    if (!fault.empty()) return fail(state, fault);
    std::ranges::sort(least);
    const double n = static_cast<double>(cases.size());
    double sum = 0;
    for (const double t : least) sum += t;
    count(state, "pairs", n);
    count(state, "median_us", least[least.size() / 2]);
    count(state, "p90_us", least[least.size() * 9 / 10]);
    count(state, "mean_us", sum / n);
    count(state, "max_us", least.back());
    count(state, "spans", static_cast<double>(spans) / n);
    count(state, decisions);
}

void register_all(std::uint32_t max_n) {
    const auto file = [](const std::string& name) {
        return [name] { return read_scene(VCELL_SCENES "/" + name + ".json"); };
    };
    static std::vector<std::pair<std::string, CellCase>> files{{"figure5", {file("figure5"), 0.76}},
                                                               {"figure6", {file("figure6"), 14.8}},
                                                               {"pile_50", {file("pile_50")}},
                                                               {"pile_500", {file("pile_500")}}};
    // [HE, Table 3]
    constexpr std::pair<const char*, double> table3[] = {
        {"table3_04", 0.13}, {"table3_06", 0.24}, {"table3_08", 0.38}, {"table3_10", 0.53},
        {"table3_12", 0.71}, {"table3_16", 1.05}, {"table3_18", 1.16}, {"table3_20", 1.36},
        {"table3_22", 1.56}, {"table3_24", 1.72}};
    for (const auto& [name, seconds] : table3) files.push_back({name, {file(name), seconds}});
    for (auto& [name, cell_case] : files)
        benchmark::RegisterBenchmark(("scene/" + name).c_str(), measure_cell, std::ref(cell_case))
            ->Unit(benchmark::kMillisecond);

    static std::vector<std::pair<std::uint32_t, CellCase>> piles;
    for (const std::uint32_t n : {50, 100, 200, 500, 1000, 2000})
        if (n <= max_n) piles.push_back({n, {[n] { return mixed_pile(n); }}});
    auto* bench = benchmark::RegisterBenchmark("pile", [](benchmark::State& state) {
        for (auto& [n, cell_case] : piles)
            if (n == state.range(0)) measure_cell(state, cell_case);
    });
    bench->Unit(benchmark::kMillisecond)->Complexity(benchmark::oNLogN);
    for (const auto& [n, cell_case] : piles) bench->Arg(n);

    for (const bool with_sphere : {true, false})
        for (const double tolerance : {1e-4, 1e-7})
            benchmark::RegisterBenchmark((std::string("trisector/") + (with_sphere ? "psc/" : "pcc/") +
                                          (tolerance == 1e-4 ? "1e-4" : "1e-7"))
                                             .c_str(),
                                         measure_trisectors, with_sphere, tolerance)
                ->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    const auto max_n = vcell::bench::take_max_n(argc, argv, 2000, 50);
    if (!max_n) return 1;
    vcell::bench::register_all(*max_n);
    return vcell::bench::run_benchmarks(argc, argv);
}
