// How the time of cells grows with the number n of objects, one thread: every mix of objects over every base
// (growth_scene.hpp), n = 10, 100, 1000, ..., and several scenes of each n.
//
// Usage: bench_growth [--max_n=N] [--seeds=K] [--most_seconds=S] [--only=TEXT]
//
// One CSV row for each scene: base, family of objects, n, seed, the CPU time of voronoi_cell(), its stages'
// by the clock, V, E, F, and the signs that each rung of the ladder decided. What is illegal or could not be
// decided is named in the last column, and has no time. Bases and families whose "base/family" does not
// contain TEXT are left out, as are sizes beyond N (default 10,000). Of a size there are K scenes (default
// 20), or as many as S seconds (default 120) suffice for if times grow with n^1.25 from the size before;
// where that is not three, larger ones are skipped, and a line on stderr says so. An error of vcell's own
// ends the program with exit status 1.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "../core/errors.hpp"
#include "../envelope/voronoi_cell.hpp"
#include "growth_scene.hpp"
#include "median.hpp"

namespace vcell::bench {
namespace {

double cpu_seconds() {
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// The first scene of a family would pay for the program's pages.
void warm_up(const Scene& scene) {
    try {
        voronoi_cell(scene);
    } catch (const UndecidedError&) {
    } catch (const InputError&) {
    }
}

// The seconds, if there is a cell.
std::optional<double> measure(const Scene& scene) {
    const double start = cpu_seconds();
    const auto refuse = [](const char* kind, const std::exception& e) {
        std::printf(",,,,,,,,,,,,\"%s: %s\"\n", kind, e.what());
        return std::nullopt;
    };
    try {
        const Cell cell = voronoi_cell(scene);
        const double seconds = cpu_seconds() - start;
        const Report& r = cell.report;
        const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
        std::printf("%.4g,%.4g,%.4g,%.4g,%zu,%zu,%zu,%llu,%llu,%llu,%llu,%llu,\n", seconds,
                    r.seconds_bisectors, r.seconds_envelope, r.seconds_patches, cell.vertices.size(),
                    cell.edges.size(), cell.faces.size(), count(r.decisions.by_double),
                    count(r.decisions.by_interval), count(r.decisions.by_exact),
                    count(r.decisions.by_multiprecision), count(r.decisions.assumed));
        return seconds;
    } catch (const UndecidedError& e) {
        return refuse("undecided", e);
    } catch (const InputError& e) {
        return refuse("illegal", e);
    }
}

struct Limits {
    unsigned max_n = 10'000, seeds = 20;
    double seconds = 120;
};

void measure_family(GrowthBase base, Mix mix, const Limits& limits) {
    constexpr double expected_growth = 17.8;  // 10^1.25
    constexpr unsigned fewest_seeds = 3;
    const std::string name = name_of(base) + "," + name_of(mix);
    warm_up(growth_scene(base, mix, 10, 1));
    std::vector<double> times;
    for (unsigned n = 10; n <= limits.max_n; n *= 10) {
        const double expected = times.empty() ? 0 : expected_growth * median(times);
        if (fewest_seeds * expected > limits.seconds) {
            std::fprintf(stderr, "%s: n = %u and more are skipped, a scene would take %.0f s\n", name.c_str(),
                         n, expected);
            return;
        }
        const double seeds =
            expected > 0 ? std::min<double>(limits.seeds, limits.seconds / expected) : limits.seeds;
        times.clear();
        for (unsigned seed = 1; seed <= seeds; ++seed) {
            std::printf("%s,%u,%u,", name.c_str(), n, seed);
            if (const auto seconds = measure(growth_scene(base, mix, n, seed))) times.push_back(*seconds);
            std::fflush(stdout);
        }
    }
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    using namespace vcell::bench;
    Limits limits;
    std::string only;
    for (int i = 1; i < argc; ++i) {
        const auto value = [&](const char* option) -> const char* {
            const std::size_t length = std::strlen(option);
            return std::strncmp(argv[i], option, length) == 0 ? argv[i] + length : nullptr;
        };
        if (const char* max_n = value("--max_n="))
            limits.max_n = static_cast<unsigned>(std::strtoul(max_n, nullptr, 10));
        else if (const char* seeds = value("--seeds="))
            limits.seeds = static_cast<unsigned>(std::strtoul(seeds, nullptr, 10));
        else if (const char* seconds = value("--most_seconds="))
            limits.seconds = std::strtod(seconds, nullptr);
        else if (const char* text = value("--only="))
            only = text;
        else {
            std::fprintf(stderr, "usage: %s [--max_n=N] [--seeds=K] [--most_seconds=S] [--only=TEXT]\n",
                         argv[0]);
            return 1;
        }
    }
#ifdef __GLIBC__
    // The first scene is not to pay for pages that the second one finds.
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
#endif
    try {
        std::puts(
            "base,family,n,seed,seconds,bisectors,envelope,patches,V,E,F,double,interval,exact,multiprecision,"
            "assumed,refused");
        for (const GrowthBase base : growth_bases)
            for (const Mix mix : mixes)
                if ((name_of(base) + "/" + name_of(mix)).find(only) != std::string::npos)
                    measure_family(base, mix, limits);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "bench_growth: %s\n", e.what());
        return 1;
    }
}
