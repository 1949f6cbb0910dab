// The time of lower_envelope() alone, one thread, over scenes of spheres above a plane:
//
//   random   50 ... 1,000,000 random spheres at constant density, with the fit to c n log n
//   lattice  equal spheres on a lattice, where every vertex is degenerate
//   sphere   points near a sphere that touches the plane: many forms through one neighbourhood
//
// Usage: bench_envelope [--max_n=N] [--largest_piece=M] [Google Benchmark's options]
//
// Sizes above N (default 10,000) are left out: the million takes half a minute and 1.5 GB. Counters, each
// for one call: the diagram's vertices V, edges E (closed: those without vertices), faces F; the signs that
// each rung of the ladder decided; insertions and merges (M: EnvelopeOptions::largest_piece); cheap being the
// share of the first two; per_sphere, CPU time in seconds; peak_MB, the process's largest resident set so
// far. The latter means the size at hand because sizes ascend within a family; run one family a process
// (--benchmark_filter=random) when memory matters.
//
// Every size is checked once, after its measurement; a wrong diagram is an error and the exit status 1.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <optional>
#include <string>

#include "bench_main.hpp"
#include "diagram_check.hpp"

namespace vcell::bench {
namespace {

constexpr int samples = 300;

// From Linux's /proc, 0 elsewhere. getrusage's ru_maxrss would begin with the size of the program that
// started this one.
double peak_megabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (double kilobytes = 0; word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024e-6;
    return 0;
}

// One scene at a time stays in memory, through all calls that its measurement takes.
struct Family {
    SphereScene (*make)(std::uint32_t);
    std::uint32_t size = 0;
    SphereScene scene = {};
    FormFamily forms = {};
    bool checked = false;

    void prepare(std::uint32_t wanted) {
        if (size == wanted) return;
        size = wanted;
        scene = make(wanted);
        forms = clearances(scene);
        checked = false;
    }
};

EnvelopeOptions options;

void measure(benchmark::State& state, Family& family) {
    family.prepare(static_cast<std::uint32_t>(state.range(0)));
    const ConvexRegion region = family.scene.region();
    std::optional<MinimizationDiagram> diagram;
    for (auto _ : state) {
        if (diagram) {  // its destruction is not the call's
            state.PauseTiming();
            diagram.reset();
            state.ResumeTiming();
        }
        diagram = lower_envelope(family.forms, region, options);
    }
    const double peak = peak_megabytes();
    if (!family.checked) {
        const std::string fault = find_fault(family.scene, *diagram, samples);
        if (!fault.empty()) return fail(state, fault);
        family.checked = true;
    }

    const std::size_t n = family.scene.spheres.size();
    state.SetComplexityN(static_cast<std::int64_t>(n));
    const auto count = [&](const char* name, auto value) {
        state.counters[name] = benchmark::Counter(static_cast<double>(value));
    };
    const DiagramCounts counts(*diagram);
    count("n", n);
    count("V", counts.vertices);
    count("E", counts.edges);
    count("F", counts.faces);
    count("closed", counts.closed_edges);
    const Decisions& d = diagram->decisions;
    count("double", d.by_double);
    count("interval", d.by_interval);
    count("exact", d.by_exact);
    count("multiprecision", d.by_multiprecision);
    count("assumed", d.assumed);
    count("cheap", d.total()
                       ? static_cast<double>(d.by_double + d.by_interval) / static_cast<double>(d.total())
                       : 1.0);
    count("insertions", diagram->work.insertions);
    count("merges", diagram->work.merges);
    count("peak_MB", peak);
    state.counters["per_sphere"] = benchmark::Counter(
        static_cast<double>(n), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void register_families(std::uint32_t max_n) {
    static Family random{[](std::uint32_t n) { return random_scene(n); }};
    static Family lattice{lattice_scene}, sphere{points_on_a_sphere};

    auto* bench = benchmark::RegisterBenchmark("random", measure, std::ref(random));
    bench->Unit(benchmark::kMillisecond)->Complexity(benchmark::oNLogN);
    for (const std::uint32_t n :
         {50, 100, 200, 500, 1000, 2000, 5000, 10'000, 20'000, 50'000, 100'000, 200'000, 500'000, 1'000'000})
        if (n <= max_n) bench->Arg(n);

    bench = benchmark::RegisterBenchmark("lattice", measure, std::ref(lattice));
    bench->Unit(benchmark::kMillisecond);
    for (const std::uint32_t side : {10, 30, 100, 300, 1000})
        if (side * side <= max_n) bench->Arg(side);

    bench = benchmark::RegisterBenchmark("sphere", measure, std::ref(sphere));
    bench->Unit(benchmark::kMillisecond);
    for (const std::uint32_t n : {64, 128, 256, 512, 1024})
        if (n <= max_n) bench->Arg(n);
}

// Takes --largest_piece=M out of the arguments.
void take_largest_piece(int& argc, char** argv) {
    constexpr char option[] = "--largest_piece=";
    int kept = 1;
    for (int i = 1; i < argc; ++i) {
        if (std::strncmp(argv[i], option, sizeof(option) - 1) == 0)
            options.largest_piece = std::strtoul(argv[i] + sizeof(option) - 1, nullptr, 10);
        else
            argv[kept++] = argv[i];
    }
    argc = kept;
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    vcell::bench::take_largest_piece(argc, argv);
    const auto max_n = vcell::bench::take_max_n(argc, argv, 10'000, 100);
    if (!max_n) return 1;
    vcell::bench::register_families(*max_n);
    return vcell::bench::run_benchmarks(argc, argv);
}
