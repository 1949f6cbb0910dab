// How much faster cells come on several threads: the scenes of bench_growth, by the clock.
//
// Usage: bench_threads [threads, default all cores] [objects, default 1000] [only=TEXT]
//
// One CSV row for each base and family of objects: the seconds of voronoi_cell() on one thread and on that
// many, the least of five calls in turn, and their quotient; empty where the scene is not decided. Bases and
// families whose "base/family" does not contain TEXT are left out.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "../core/errors.hpp"
#include "../core/threads.hpp"
#include "../envelope/voronoi_cell.hpp"
#include "growth_scene.hpp"

namespace vcell::bench {
namespace {

double seconds_on(unsigned threads, const Scene& scene) {
    CellOptions options;
    options.threads = threads;
    const auto start = std::chrono::steady_clock::now();
    const Cell cell = voronoi_cell(scene, options);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void measure(const Scene& scene, unsigned threads) {
    constexpr int calls = 5;
    double alone = HUGE_VAL, together = HUGE_VAL;
    try {
        for (int i = 0; i < calls; ++i) {
            alone = std::min(alone, seconds_on(1, scene));
            together = std::min(together, seconds_on(threads, scene));
        }
    } catch (const UndecidedError&) {
        std::puts(",,");
        return;
    } catch (const InputError&) {
        std::puts(",,");
        return;
    }
    std::printf("%.4g,%.4g,%.2f\n", alone, together, alone / together);
    std::fflush(stdout);
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    using namespace vcell::bench;
    constexpr char only[] = "only=";
    unsigned numbers[] = {0, 1000};
    std::string text;
    std::size_t given = 0;
    for (int i = 1; i < argc; ++i)
        if (std::strncmp(argv[i], only, std::strlen(only)) == 0) {
            text = argv[i] + std::strlen(only);
        } else if (given < std::size(numbers)) {
            numbers[given++] = static_cast<unsigned>(std::strtoul(argv[i], nullptr, 10));
        } else {
            std::fprintf(stderr, "usage: %s [threads] [objects] [only=TEXT]\n", argv[0]);
            return 1;
        }
    const unsigned threads = vcell::thread_count(numbers[0]), n = std::max(10u, numbers[1]);
    std::printf("base,family,n,one thread,%u threads,ratio\n", threads);
    for (const GrowthBase base : growth_bases)
        for (const Mix mix : mixes)
            if ((name_of(base) + "/" + name_of(mix)).find(text) != std::string::npos) {
                std::printf("%s,%s,%u,", name_of(base).c_str(), name_of(mix).c_str(), n);
                measure(growth_scene(base, mix, n, 1), threads);
            }
}
