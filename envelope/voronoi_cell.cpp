#include "voronoi_cell.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "../core/errors.hpp"
#include "../core/platform.hpp"
#include "../core/threads.hpp"
#include "../primitives/bases/plane_base.hpp"
#include "../primitives/bases/radial_base.hpp"
#include "../primitives/objects/decided_scene.hpp"
#include "base_diagram.hpp"
#include "complete_tube.hpp"
#include "lift/complete_lift.hpp"
#include "lift/lift.hpp"
#include "lift/scene_motion.hpp"
#include "proofs/competition.hpp"

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

// Where an element's numbers or bounds are none, digits or a budget were not enough.
void require_numbers(const Cell& cell, bool is_measured, unsigned threads) {
    const auto require = [](bool is_known, const char* element, const auto& sites, const Vec3& p) {
        if (is_known) return;
        std::string names;
        for (const Site site : sites) names += (names.empty() ? "" : ", ") + to_string(site);
        char place[96];
        std::snprintf(place, sizeof place, "(%.9g, %.9g, %.9g)", p.x(), p.y(), p.z());
        throw UndecidedError("objects " + names + ": no bound on the error of their " + element + " near " +
                             place);
    };
    for_each(cell.vertices, threads, [&](const CellVertex& v) {
        require(std::isfinite(v.point.sum() + v.radius + v.error), "vertex", v.sites, v.point);
    });
    for_each(cell.edges, threads, [&](const CellEdge& e) {
        double sum = is_measured ? e.error + e.length + e.length_error : e.error;
        for (const Eigen::Vector4d& p : e.curve.points) sum += p.sum();
        require(std::isfinite(sum), "edge", e.sites, e.curve.points.front().head<3>());
    });
    if (!is_measured) return;
    for_each(cell.faces, threads, [&](const CellFace& f) {
        const bool has_point = !f.patches.empty() && !f.patches.front().surface.points.empty();
        require(std::isfinite(f.area + f.area_error), "face", std::array{f.site},
                has_point ? Vec3(f.patches.front().surface.points.front().head<3>()) : Vec3::Zero().eval());
    });
    const Measures& m = cell.measures;
    if (!std::isfinite(m.volume + m.volume_error + m.min_clearance + m.min_clearance_error + m.max_clearance +
                       m.max_clearance_error))
        throw UndecidedError("the cell's measures: no bound on their error");
}

// Where a bisector touches the boundary from above in the middle of a face, the diagram has a vertex, which
// divides nothing: the boundary has none.
void drop_isolated_vertices(Cell& cell) {
    std::vector<std::uint32_t> number(cell.vertices.size(), 0);
    for (const CellEdge& e : cell.edges)
        for (const std::uint32_t v : e.vertices) number[v] = 1;
    if (std::ranges::find(number, 0u) == number.end()) return;
    std::uint32_t kept = 0;
    for (std::uint32_t v = 0; v < number.size(); ++v) {
        if (number[v] == 0) continue;
        if (kept != v) cell.vertices[kept] = std::move(cell.vertices[v]);
        number[v] = kept++;
    }
    cell.vertices.resize(kept);
    for (CellEdge& e : cell.edges)
        for (std::uint32_t& v : e.vertices) v = number[v];
}

PlaneBaseProblem plane_problem(const Scene& scene, double unit, const CellOptions& options) {
    if (options.complete)
        if (auto problem = complete_plane_base_problem(scene, unit)) return *std::move(problem);
    return plane_base_problem(scene, unit);
}
RadialBaseProblem radial_problem(const Scene& scene, double unit, const CellOptions&) {
    return radial_base_problem(scene, unit);
}

// A problem's diagram; below its floor, if it has one, another.
struct Diagrams {
    MinimizationDiagram all;
    std::optional<MinimizationDiagram> below;

    EnvelopeWork work() const {
        EnvelopeWork sum = all.work;
        if (below) sum += below->work;
        return sum;
    }
    // Each once: what both meet both may have assumed.
    std::vector<Assumption> assumptions() const {
        std::vector<Assumption> sum = all.assumptions;
        if (below)
            for (const Assumption& a : below->assumptions) add_assumption(a, sum);
        return sum;
    }
    std::size_t assumed_twice() const {
        return below ? all.assumptions.size() + below->assumptions.size() - assumptions().size() : 0;
    }
};
Diagrams with_floor(const PlaneBaseProblem& problem, EnvelopeOptions options) {
    if (problem.floor.empty()) return {diagram_of(problem, options), std::nullopt};
    options.floor = problem.floor;
    MinimizationDiagram above = diagram_of(problem, options);
    options.is_below_floor = true;
    MinimizationDiagram below = diagram_of(problem, options);
    const FormId base = problem.floor.front();
    if (problem.has_curved_rim && std::ranges::find(below.face_forms, base) == below.face_forms.end())
        throw InputError(InputError::Kind::EmptyBox, InputError::no_object, "box",
                         "holds none of the base plane within the walls of all vessels");
    return {std::move(above), std::move(below)};
}
Diagrams without_floor(const RadialBaseProblem& problem, EnvelopeOptions options) {
    return {diagram_of(problem, options), std::nullopt};
}

LiftedCell lift_from_floor(const PlaneBaseProblem& problem, const Diagrams& diagrams, double tolerance,
                           const CellOptions& options) {
    const unsigned threads = thread_count(options.threads);
    if (!diagrams.below) return lift_over_region(problem, diagrams.all, tolerance, options.measure, threads);
    return lift_complete(problem, diagrams.all, *diagrams.below, tolerance, options.measure, threads);
}
LiftedCell lift_from_body(const RadialBaseProblem& problem, const Diagrams& diagrams, double tolerance,
                          const CellOptions& options) {
    const auto lift = options.patches ? lift_all_around : lift_without_patches;
    return lift(problem, diagrams.all, tolerance, options.measure, thread_count(options.threads));
}

// What a cell takes over one kind of base.
template <class Problem>
struct Steps {
    Problem (*problem)(const Scene&, double unit, const CellOptions&);
    Diagrams (*diagrams)(const Problem&, EnvelopeOptions);
    LiftedCell (*lift)(const Problem&, const Diagrams&, double tolerance, const CellOptions&);
};

// How far things have moved, in the decided scene's unit, and what parameters are multiplied by.
struct MotionBack {
    SceneMoves moves;
    double of_parameters;
};

// The cell in the user's unit, with what moving the scene has done to it.
Cell moved_back(LiftedCell lifted, DecidedScene decided, const Scene& scene, const MotionBack& motion,
                const CellOptions& options) {
    Cell& cell = lifted.cell;
    drop_isolated_vertices(cell);
    const SceneMoves moves = most(motion.moves, {decided.moved, decided.moved, 0});
    cell.report.moved = moves.all + moves.ties;
    const std::optional<Site> cap = scene.probe ? std::optional(decided.cap()) : std::nullopt;
    cell.scene = std::move(decided.scene);
    add_scene_motion(lifted, moves);
    if (cap) name_cap(cell, *cap, *cell.scene.probe);
    scale(cell, decided.unit, motion.of_parameters, thread_count(options.threads));
    cell.scene = scene;
    require_numbers(cell, options.measure, thread_count(options.threads));
    return std::move(cell);
}

void set(Report& report, const EnvelopeWork& work) {
    report.insertions = work.insertions;
    report.merges = work.merges;
    report.pieces = work.pieces;
}

// The base may be an oblique tube, or one that others hold; none if it is neither.
std::optional<Cell> complete_tube_cell(const Scene& scene, const CellOptions& options) {
    Stopwatch watch;
    validate(scene);
    DecidedScene decided = decide(scene);
    std::optional<CompleteTube> tube = lift_complete_tube(decided, options.measure, options.complete);
    if (!tube) return std::nullopt;
    Cell cell = moved_back(std::move(tube->lifted), std::move(decided), scene,
                           {tube->moves, tube->unit_of_parameters}, options);
    cell.is_complete = true;
    set(cell.report, tube->work);
    cell.report.seconds_envelope = watch.lap();
    cell.report.warnings.insert(cell.report.warnings.begin(), tube->warnings.begin(), tube->warnings.end());
    return cell;
}

// From the scene's heights to its cell.
template <class Problem>
Cell cell_over(const Scene& scene, const CellOptions& options, const Steps<Problem>& steps) {
    const auto report = [&](const char* stage, double fraction) {
        if (options.progress) options.progress(stage, fraction);
    };
    Stopwatch watch;
    report("bisectors", 0);
    validate(scene);
    DecidedScene decided = decide(scene);
    const Problem problem = steps.problem(decided.scene, decided.unit, options);
    report("bisectors", 1);
    const double seconds_bisectors = watch.lap();

    EnvelopeOptions envelope_options;
    envelope_options.threads = options.threads;
    if (options.progress) envelope_options.progress = [&](double fraction) { report("envelope", fraction); };
    const Diagrams diagrams = steps.diagrams(problem, envelope_options);
    const double seconds_envelope = watch.lap();

    report("patches", 0);
    LiftedCell lifted = steps.lift(problem, diagrams, decided.scene.fit_tolerance(), options);
    lifted.cell.is_complete = options.complete && may_be_completed(decided.scene);
    const MotionBack motion{problem.moves, problem.chart.unit_of_coordinates(decided.unit)};
    Cell cell = moved_back(std::move(lifted), std::move(decided), scene, motion, options);
    report("patches", 1);
    set(cell.report, diagrams.work());
    cell.report.seconds_bisectors = seconds_bisectors;
    cell.report.seconds_envelope = seconds_envelope;
    cell.report.seconds_patches = watch.lap();
    std::vector<std::string>& warnings = cell.report.warnings;
    cell.report.decisions.assumed -= diagrams.assumed_twice();
    for (const Assumption& a : diagrams.assumptions())
        warnings.push_back(message(a, "taken to meet in one point over", problem));
    warnings.insert(warnings.begin(), problem.warnings.begin(), problem.warnings.end());
    return cell;
}

}  // namespace

Cell voronoi_cell(const Scene& scene, const CellOptions& options) {
    return in_ieee_arithmetic("voronoi_cell()", [&] {
        if (options.complete)
            if (auto cell = complete_tube_cell(scene, options)) return *std::move(cell);
        if (std::holds_alternative<Plane>(scene.base))
            return cell_over<PlaneBaseProblem>(scene, options, {plane_problem, with_floor, lift_from_floor});
        try {
            return cell_over<RadialBaseProblem>(scene, options,
                                                {radial_problem, without_floor, lift_from_body});
        } catch (const InputError& e) {
            if (options.complete || e.kind != InputError::Kind::TouchesBase) throw;
            if (auto held = complete_tube_cell(scene, options)) return *std::move(held);
            throw;
        }
    });
}

}  // namespace vcell
