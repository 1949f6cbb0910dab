// How the time of cells grows with the number n of objects, one thread: every mix of objects over every base
// (growth_scene.hpp), n = 10, 30, 100, ..., and several scenes of each n.
//
// Usage: bench_growth [--min_n=N] [--max_n=N] [--seeds=K] [--only=TEXT]
//
// One CSV row for each scene: family ("ball/balls_rod"), n, seed, the CPU time of voronoi_cell(), V, E, F, and the
// signs that each rung of the ladder decided. Families whose name does not contain TEXT, and sizes outside
// the bounds (default 10 and 10,000), are left out; K seeds (default 3). What could not be decided is named in the last column, its
// counts are empty; any other error ends the program with exit status 1.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "../core/errors.hpp"
#include "../envelope/voronoi_cell.hpp"
#include "growth_scene.hpp"

namespace vcell::bench {
namespace {

double cpu_seconds() {
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void measure(const std::string& family, const Scene& scene, unsigned seed) {
    std::printf("%s,%zu,%u,", family.c_str(), scene.objects.size(), seed);
    const double start = cpu_seconds();
    try {
        const Cell cell = voronoi_cell(scene);
        const double seconds = cpu_seconds() - start;
        const Decisions& d = cell.report.decisions;
        std::printf("%.4g,%zu,%zu,%zu,%llu,%llu,%llu,%llu,%llu,\n", seconds, cell.vertices.size(), cell.edges.size(),
                    cell.faces.size(), static_cast<unsigned long long>(d.by_double),
                    static_cast<unsigned long long>(d.by_interval), static_cast<unsigned long long>(d.by_exact),
                    static_cast<unsigned long long>(d.by_multiprecision), static_cast<unsigned long long>(d.assumed));
    } catch (const UndecidedError& e) {
        std::printf("%.4g,,,,,,,,,\"%s\"\n", cpu_seconds() - start, e.what());
    }
    std::fflush(stdout);
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    using namespace vcell::bench;
    unsigned min_n = 10, max_n = 10'000, seeds = 3;
    std::string only;
    for (int i = 1; i < argc; ++i) {
        const auto value = [&](const char* option) -> const char* {
            const std::size_t length = std::strlen(option);
            return std::strncmp(argv[i], option, length) == 0 ? argv[i] + length : nullptr;
        };
        if (const char* v = value("--min_n="))
            min_n = static_cast<unsigned>(std::strtoul(v, nullptr, 10));
        else if (const char* v = value("--max_n="))
            max_n = static_cast<unsigned>(std::strtoul(v, nullptr, 10));
        else if (const char* v = value("--seeds="))
            seeds = static_cast<unsigned>(std::strtoul(v, nullptr, 10));
        else if (const char* v = value("--only="))
            only = v;
        else {
            std::fprintf(stderr, "usage: %s [--min_n=N] [--max_n=N] [--seeds=K] [--only=TEXT]\n", argv[0]);
            return 1;
        }
    }
#ifdef __GLIBC__
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
#endif
    std::puts("family,n,seed,seconds,V,E,F,double,interval,exact,multiprecision,assumed,undecided");
    for (const GrowthBase base : growth_bases)
        for (const Mix mix : mixes) {
            const std::string family = name_of(base) + "/" + name_of(mix);
            if (family.find(only) == std::string::npos) continue;
            for (const unsigned n : {10u, 30u, 100u, 300u, 1000u, 3000u, 10'000u, 100'000u, 1'000'000u})
                for (unsigned seed = 1; n >= min_n && n <= max_n && seed <= seeds; ++seed)
                    measure(family, growth_scene(base, mix, n, seed), seed);
        }
}
