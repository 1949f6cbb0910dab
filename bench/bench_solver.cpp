// The time of solve() on vertex systems, one thread: all points equidistant from four objects, each root
// proved, from the box of the whole scene (which: scene) and from a box around one arc (which: arc).
//
//   four_spheres, plane_three_spheres, three_planes_sphere, plane_two_spheres_cylinder,
//   plane_sphere_two_cylinders, plane_three_cylinders, three_cylinders_sphere, four_cylinders
//
// Each family has 400 random systems of fixed seed, objects of a scene of 20 x 20 x 20. Counters are over
// the systems: median_us, p90_us and mean_us of one solve() with the building of its equations, roots and
// steps (mean), undecided (systems with any; each is an error) and wide (systems that needed
// multiprecision). An arc's box is 1/16 of the scene wide and holds a vertex of its system somewhere.
//
// Every root is checked against the distance functions, and the arc's roots against the scene's; a wrong
// one is an error and the exit status 1.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "../primitives/bisectors/vertex_roots.hpp"
#include "bench_main.hpp"

namespace vcell::bench {
namespace {

constexpr int systems_per_family = 400;

struct Case {
    VertexSystem system;
    IntervalBox<4> box;
};

class Generator {
public:
    explicit Generator(std::uint64_t seed) : rng_(seed) {}

    // The scene's side of a plane is where its middle lies.
    VertexSite plane() { return PlaneSite{direction(), uniform(5, 10)}; }
    VertexSite sphere() { return SphereSite{position(), uniform(0.25, 2)}; }
    VertexSite cylinder() { return CylinderSite{position(), direction(), uniform(0.25, 1.5)}; }
    double uniform(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }

private:
    std::array<double, 3> position() { return {uniform(-8, 8), uniform(-8, 8), uniform(-8, 8)}; }
    std::array<double, 3> direction() {
        while (true) {
            const std::array d{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            const double norm = std::hypot(d[0], d[1], d[2]);
            if (norm > 0.1 && norm < 1) return {d[0] / norm, d[1] / norm, d[2] / norm};
        }
    }
    std::mt19937_64 rng_;
};

double distance(const VertexSite& site, const Point<4>& v) {
    const auto dot = [](const auto& a, const auto& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    if (const auto* plane = std::get_if<PlaneSite>(&site))
        return (dot(plane->normal, v) + plane->offset) / std::sqrt(dot(plane->normal, plane->normal));
    if (const auto* sphere = std::get_if<SphereSite>(&site)) {
        const auto& c = sphere->center;
        return std::hypot(v[0] - c[0], v[1] - c[1], v[2] - c[2]) - sphere->radius;
    }
    const auto& [p, d, rho] = std::get<CylinderSite>(site);
    const std::array w{v[0] - p[0], v[1] - p[1], v[2] - p[2]};
    const std::array cross{w[1] * d[2] - w[2] * d[1], w[2] * d[0] - w[0] * d[2], w[0] * d[1] - w[1] * d[0]};
    return std::sqrt(dot(cross, cross) / dot(d, d)) - rho;
}

bool right(const Case& c, const Solutions<4>& found) {
    if (!found.undecided.empty()) return false;
    for (const Root<4>& root : found.unique)
        for (const VertexSite& site : c.system.sites) {
            const Point<4> v = mid(root.box);
            if (std::abs(distance(site, v) - v[3]) > 1e-7 * (1 + std::abs(v[3]))) return false;
        }
    return true;
}

IntervalBox<4> scene_box(const VertexSystem& system) {
    return {Interval(-10, 10), Interval(-10, 10), Interval(-10, 10),
            Interval(std::max(-20.0, system.least_clearance()), 20)};
}

/// `kinds`: p, s, c for plane, sphere, cylinder.
std::vector<Case> scene_cases(const std::string& kinds) {
    Generator random(20090217);
    std::vector<Case> cases(systems_per_family);
    for (Case& c : cases) {
        for (int k = 0; k < 4; ++k)
            c.system.sites[k] = kinds[k] == 'p'   ? random.plane()
                                : kinds[k] == 's' ? random.sphere()
                                                  : random.cylinder();
        c.box = scene_box(c.system);
    }
    return cases;
}

/// Boxes around a vertex each, as a tracer of arcs meets them.
std::vector<Case> arc_cases(const std::string& kinds) {
    Generator random(20090218);
    std::vector<Case> cases;
    for (const Case& scene : scene_cases(kinds)) {
        const auto found = solve(scene.system, scene.box);
        for (const Root<4>& root : found.unique) {
            Case arc = scene;
            for (int i = 0; i < 4; ++i) {
                const double width = 20.0 / 16, at = random.uniform(0.1, 0.9) * width;
                arc.box[i] = {root.box[i].mid() - at, root.box[i].mid() - at + width};
            }
            cases.push_back(arc);
        }
    }
    return cases;
}

void run(benchmark::State& state, const std::vector<Case>& cases, bool roots_expected) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> least(cases.size(), std::numeric_limits<double>::infinity());
    std::vector<Solutions<4>> found(cases.size());
    for (auto _ : state)
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const auto start = Clock::now();
            found[i] = solve(cases[i].system, cases[i].box);
            least[i] =
                std::min(least[i], std::chrono::duration<double, std::micro>(Clock::now() - start).count());
        }
    double roots = 0, steps = 0, undecided = 0, wide = 0, sum = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        roots += static_cast<double>(found[i].unique.size());
        steps += static_cast<double>(found[i].boxes);
        undecided += !found[i].undecided.empty();
        wide += found[i].wide_boxes > 0;
        sum += least[i];
        if (!right(cases[i], found[i]) || (roots_expected && found[i].unique.empty()))
            return fail(state, "a root is wrong, missing or undecided");
    }
    std::sort(least.begin(), least.end());
    const double n = static_cast<double>(cases.size());
    state.counters["systems"] = n;
    state.counters["median_us"] = least[least.size() / 2];
    state.counters["p90_us"] = least[least.size() * 9 / 10];
    state.counters["mean_us"] = sum / n;
    state.counters["roots"] = roots / n;
    state.counters["steps"] = steps / n;
    state.counters["undecided"] = undecided;
    state.counters["wide"] = wide;
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    using namespace vcell::bench;
    const std::vector<std::pair<std::string, std::string>> families{{"four_spheres", "ssss"},
                                                                    {"plane_three_spheres", "psss"},
                                                                    {"three_planes_sphere", "ppps"},
                                                                    {"plane_two_spheres_cylinder", "pssc"},
                                                                    {"plane_sphere_two_cylinders", "pscc"},
                                                                    {"plane_three_cylinders", "pccc"},
                                                                    {"three_cylinders_sphere", "cccs"},
                                                                    {"four_cylinders", "cccc"}};
    for (const auto& [name, kinds] : families) {
        benchmark::RegisterBenchmark((name + "/scene").c_str(), [kinds = kinds](benchmark::State& state) {
            run(state, scene_cases(kinds), false);
        });
        benchmark::RegisterBenchmark((name + "/arc").c_str(), [kinds = kinds](benchmark::State& state) {
            run(state, arc_cases(kinds), true);
        });
    }
    return run_benchmarks(argc, argv);
}
