// envelope_of_file FILE [--reps R]: computes the envelope of the spheres in FILE (read_scene() in
// sphere_scene.hpp tells the format) R times, checks it, and prints one line of names and values: sizes, the
// median and the least CPU time of lower_envelope() in milliseconds, the median wall time, and the signs
// that each rung decided. Exit status 1: bad usage or input, or a wrong diagram.
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "diagram_check.hpp"
#include "median.hpp"

namespace {

using namespace vcell;
using namespace vcell::bench;

double cpu_milliseconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

void run(const std::string& path, int reps) {
    std::ifstream in(path);
    if (!in) throw std::runtime_error("cannot open the file");
    const SphereScene scene = read_scene(in);
    const FormFamily family = clearances(scene);
    const ConvexRegion region = scene.region();

    std::vector<double> cpu, wall;
    for (int r = 0; r < reps; ++r) {
        const auto wall_start = std::chrono::steady_clock::now();
        const double cpu_start = cpu_milliseconds();
        const MinimizationDiagram diagram = lower_envelope(family, region);
        cpu.push_back(cpu_milliseconds() - cpu_start);
        wall.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall_start).count());
        if (r + 1 < reps) continue;

        const std::string fault = find_fault(scene, diagram, 300);
        if (!fault.empty()) throw std::runtime_error(fault);
        const DiagramCounts counts(diagram);
        const Decisions& d = diagram.decisions;
        std::printf(
            "n %zu V %zu E %zu F %zu spheres %zu closed %zu wall_ms %.4f cpu_ms %.4f cpu_min %.4f "
            "double %llu interval %llu exact %llu multiprecision %llu assumed %llu\n",
            scene.spheres.size(), counts.vertices, counts.edges, counts.faces, counts.owners,
            counts.closed_edges, median(wall), median(cpu), *std::ranges::min_element(cpu),
            static_cast<unsigned long long>(d.by_double), static_cast<unsigned long long>(d.by_interval),
            static_cast<unsigned long long>(d.by_exact), static_cast<unsigned long long>(d.by_multiprecision),
            static_cast<unsigned long long>(d.assumed));
    }
}

}  // namespace

int main(int argc, char** argv) {
    const bool has_reps = argc == 4 && std::string(argv[2]) == "--reps";
    const int reps = has_reps ? std::atoi(argv[3]) : 1;
    if ((argc != 2 && !has_reps) || reps < 1) {
        std::fprintf(stderr, "usage: envelope_of_file FILE [--reps R]\n");
        return 1;
    }
    try {
        run(argv[1], reps);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", argv[1], error.what());
        return 1;
    }
}
