#include "voronoi_cell.hpp"

#include <chrono>
#include <cstdio>
#include <string>
#include <utility>

#include "../primitives/plane_base.hpp"
#include "lift.hpp"
#include "minimization_diagram.hpp"

namespace vcell {

namespace {

class Stopwatch {
public:
    /// Seconds since the last call, or since construction.
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// "objects 1, 2, 5: <what> (x, y, z), not told apart within w".
std::string message(const Assumption& a, const char* what, const PlaneBaseProblem& problem) {
    std::string sites;
    for (const FormId f : a.forms)
        for (const Site site : problem.sites[f]) sites += (sites.empty() ? "" : ", ") + to_string(site);
    const Vec3 p = problem.frame.to_world({a.place.x(), a.place.y(), 0});
    char place[128];
    std::snprintf(place, sizeof place, "(%.9g, %.9g, %.9g), not told apart within %.2g", p.x(), p.y(), p.z(), a.width);
    return "objects " + sites + ": " + what + " " + place;
}

}  // namespace

Cell voronoi_cell(const Scene& scene, const CellOptions& options) {
    const auto report = [&](const char* stage, double fraction) {
        if (options.progress) options.progress(stage, fraction);
    };
    Stopwatch watch;
    report("bisectors", 0);
    validate(scene);
    PlaneBaseProblem problem = plane_base_problem(scene);
    report("bisectors", 1);
    const double seconds_bisectors = watch.lap();

    ConvexRegion region;
    for (const RegionSide& side : problem.region) region.sides.push_back({side.a, side.b, side.c});
    EnvelopeOptions envelope_options;
    if (options.progress) envelope_options.progress = [&](double fraction) { report("envelope", fraction); };
    const MinimizationDiagram diagram = [&] {
        try {
            return lower_envelope(problem.family, region, envelope_options);
        } catch (const TieError& e) {
            throw UndecidedError(message(e.tie, "seem to be equally near along a curve around", problem));
        }
    }();
    const double seconds_envelope = watch.lap();

    report("patches", 0);
    Cell cell = lift(problem, diagram, scene.tolerance.value_or(1e-7 * scene.box.diagonal()));
    report("patches", 1);
    cell.scene = scene;
    cell.report.seconds_bisectors = seconds_bisectors;
    cell.report.seconds_envelope = seconds_envelope;
    cell.report.seconds_patches = watch.lap();
    for (const Assumption& a : diagram.assumptions)
        problem.warnings.push_back(message(a, "taken to meet in one point over", problem));
    cell.report.warnings = std::move(problem.warnings);
    return cell;
}

}  // namespace vcell
