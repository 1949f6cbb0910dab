// The time of changes and questions, one thread:
//
//   insert/<base>/n  one object more in the cell of n spheres
//   remove/<base>/n  a neighbour less
//   merge/tubes/n    the cells of a tube among n skew tubes each
//   query/<base>/n   one of 1,000,000 points about a scene of n spheres; the first ones are in the time, and
//                    setting up is counted as `setup_ms`
//
// Usage: bench_changes [Google Benchmark's options]
//
// Bases: a ball whose cell has some 20 of the spheres for neighbours, in a cube full of them; a plane under a
// layer of them. Counters: V, F of the cell; scratch_us, the same cell by voronoi_cell() (one run). Results
// are compared with those: volumes within their errors, points with comparing all.
#include <chrono>
#include <cmath>
#include <string>

#include "../envelope/cell_changes.hpp"
#include "../envelope/point_query.hpp"
#include "bench_main.hpp"
#include "growth_scene.hpp"

namespace vcell::bench {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// n balls of radii 0.1 to 0.4 in a cube with one to each unit of volume, around a ball in the middle.
Scene cube_of_balls(std::uint32_t n) {
    RandomLengths random(3);
    const double half = 0.5 * std::cbrt(n);
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.3};
    scene.box = {Vec3::Constant(-half), Vec3::Constant(half)};
    while (scene.objects.size() < n) {
        const Vec3 c(random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half));
        const double radius = random.uniform(0.1, 0.4);
        if (c.norm() > radius + 0.5) scene.objects.emplace_back(Sphere{c, radius});
    }
    return scene;
}

Scene balls_over_plane(std::uint32_t n) { return growth_scene(GrowthBase::Plane, Mix::Balls, n, 1); }

void judge(benchmark::State& state, const Cell& cell, const Scene& scene) {
    const auto start = std::chrono::steady_clock::now();
    const Cell scratch = voronoi_cell(scene);
    state.counters["scratch_us"] = 1e6 * seconds_since(start);
    state.counters["V"] = static_cast<double>(cell.vertices.size());
    state.counters["F"] = static_cast<double>(cell.faces.size());
    const Measures &a = cell.measures, &b = scratch.measures;
    if (cell.vertices.size() != scratch.vertices.size() || cell.faces.size() != scratch.faces.size() ||
        !(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error))
        fail(state, "not the cell from scratch");
}

// The changed cell; copying what it is made from is not in the time.
template <class Change>
Cell measure_change(benchmark::State& state, const Cell& before, Change&& change) {
    Cell after;
    for (auto _ : state) {
        state.PauseTiming();
        Cell cell = before;
        state.ResumeTiming();
        after = change(std::move(cell));
    }
    return after;
}

void insert_one(benchmark::State& state, Scene scene) {
    const Object last = scene.objects.back();
    Scene fewer = scene;
    fewer.objects.pop_back();
    const Cell before = voronoi_cell(fewer);
    const Cell after =
        measure_change(state, before, [&](Cell cell) { return insert(std::move(cell), last); });
    judge(state, after, scene);
}

void remove_one(benchmark::State& state, Scene scene) {
    const Cell before = voronoi_cell(scene);
    const std::uint32_t neighbor = before.neighbors.front();
    const Cell after =
        measure_change(state, before, [&](Cell cell) { return remove(std::move(cell), neighbor); });
    scene.objects.erase(scene.objects.begin() + neighbor);
    judge(state, after, scene);
}

void merge_two(benchmark::State& state, std::uint32_t n) {
    const Scene both = growth_scene(GrowthBase::Tube, Mix::SkewTubes, 2 * n, 1);
    Scene first = both, second = both;
    first.objects.resize(n);
    second.objects.erase(second.objects.begin(), second.objects.begin() + n);
    const Cell a = voronoi_cell(first), b = voronoi_cell(second);
    Cell merged;
    for (auto _ : state) merged = merge(a, b);
    judge(state, merged, both);
}

void query_points(benchmark::State& state, const Scene& scene) {
    constexpr int points = 1'000'000;
    const auto start = std::chrono::steady_clock::now();
    PointQuery query(scene);
    state.counters["setup_ms"] = 1e3 * seconds_since(start);
    RandomLengths random(5);
    const auto coordinate = [&](int i) { return random.uniform(scene.box.min[i], scene.box.max[i]); };
    std::vector<Vec3> all;
    for (int i = 0; i < points; ++i) all.emplace_back(coordinate(0), coordinate(1), coordinate(2));
    for (auto _ : state)
        for (const Vec3& p : all) benchmark::DoNotOptimize(query(p));
    state.SetItemsProcessed(state.iterations() * points);
    for (int i = 0; i < 100; ++i) {
        PointQuery fresh(scene);
        const auto a = query(all[i]), b = fresh(all[i]);
        if (a.has_value() != b.has_value() || (a && (a->site != b->site || a->inside != b->inside)))
            fail(state, "answers differ");
    }
}

void register_all() {
    for (const std::uint32_t n : {100u, 1'000u, 10'000u}) {
        const std::string size = std::to_string(n);
        const auto add = [](const std::string& name, auto&& run) {
            benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMicrosecond);
        };
        add("insert/ball/" + size, [n](benchmark::State& s) { insert_one(s, cube_of_balls(n)); });
        add("insert/plane/" + size, [n](benchmark::State& s) { insert_one(s, balls_over_plane(n)); });
        add("remove/ball/" + size, [n](benchmark::State& s) { remove_one(s, cube_of_balls(n)); });
        add("remove/plane/" + size, [n](benchmark::State& s) { remove_one(s, balls_over_plane(n)); });
        benchmark::RegisterBenchmark(("query/ball/" + size).c_str(), [n](benchmark::State& s) {
            query_points(s, cube_of_balls(n));
        })->Unit(benchmark::kMillisecond);
        benchmark::RegisterBenchmark(("query/plane/" + size).c_str(), [n](benchmark::State& s) {
            query_points(s, balls_over_plane(n));
        })->Unit(benchmark::kMillisecond);
    }
    for (const std::uint32_t n : {10u, 50u})
        benchmark::RegisterBenchmark(("merge/tubes/" + std::to_string(n)).c_str(), [n](benchmark::State& s) {
            merge_two(s, n);
        })->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    vcell::bench::register_all();
    return vcell::bench::run_benchmarks(argc, argv);
}
