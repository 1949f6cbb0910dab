/// What the bench programs share: the option --max_n, the run of Google Benchmark, the exit status.
#pragma once

#include <benchmark/benchmark.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <optional>
#include <string>

namespace vcell::bench {

/// Did a measurement yield a wrong result?
inline bool failed = false;

/// Marks the measurement as an error and the program as failed.
inline void fail(benchmark::State& state, const std::string& what) {
    failed = true;
    state.SkipWithError(what.c_str());
}

/// Takes --max_n=N out of the arguments; `otherwise` without it. None, after a message, if N < least.
inline std::optional<std::uint32_t> take_max_n(int& argc, char** argv, std::uint32_t otherwise,
                                               std::uint32_t least) {
    std::uint32_t max_n = otherwise;
    constexpr char option[] = "--max_n=";
    int kept = 1;
    for (int i = 1; i < argc; ++i) {
        if (std::strncmp(argv[i], option, sizeof(option) - 1) == 0)
            max_n = static_cast<std::uint32_t>(std::strtoul(argv[i] + sizeof(option) - 1, nullptr, 10));
        else
            argv[kept++] = argv[i];
    }
    argc = kept;
    if (max_n >= least) return max_n;
    std::cerr << argv[0] << ": --max_n must be a number from " << least << " up\n";
    return std::nullopt;
}

/// Runs what has been registered; the exit status: 1 for bad arguments and wrong results.
///
/// Freed memory stays with the program, as in any that computes one cell after the other and says so to its
/// allocator: of a cell with thousands of faces a fifth of the time is the kernel's, which hands out pages
/// anew.
inline int run_benchmarks(int argc, char** argv) {
#ifdef __GLIBC__
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
#endif
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
#ifdef __clang__
    benchmark::AddCustomContext("compiler", __VERSION__);
#else
    benchmark::AddCustomContext("compiler", "GCC " __VERSION__);
#endif
#ifndef NDEBUG
    benchmark::AddCustomContext("asserts", "on: times mean nothing");
#endif
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return failed ? 1 : 0;
}

}  // namespace vcell::bench
