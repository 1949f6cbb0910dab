#include "uncut_curves.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../core/errors.hpp"
#include "../../primitives/bases/feet.hpp"
#include "../../primitives/bases/solid_bases.hpp"
#include "../../primitives/objects/decided_scene.hpp"
#include "../../primitives/objects/message.hpp"
#include "../base_diagram.hpp"
#include "../lift/lift.hpp"
#include "../lift/scene_motion.hpp"
#include "../voronoi_cell.hpp"

namespace vcell {

namespace {

TrisectorKind kind_of(CurveKind kind) {
    switch (kind) {
        case CurveKind::Line: return TrisectorKind::Line;
        case CurveKind::Circle: return TrisectorKind::Circle;
        case CurveKind::Ellipse: return TrisectorKind::Ellipse;
        case CurveKind::Parabola: return TrisectorKind::Parabola;
        case CurveKind::Hyperbola: return TrisectorKind::Hyperbola;
        case CurveKind::Spline: break;
    }
    return TrisectorKind::Spline;
}

// A side of the box may be as near all along.
bool is_between_objects(const CellEdge& edge) {
    return std::ranges::count_if(edge.sites, &Site::is_object) +
               std::ranges::count_if(edge.extra_sites, &Site::is_object) >=
           2;
}

std::array<bool, 6> shared_sides(const Box& box, const Box& region) {
    std::array<bool, 6> shared;
    for (int side = 0; side < 6; ++side)
        shared[side] = side % 2 == 1 ? box.max[side / 2] == region.max[side / 2]
                                     : box.min[side / 2] == region.min[side / 2];
    return shared;
}

// A vertex lies on a side that region and box share, or in a node.
int end_of(const CellVertex& v, const Box& region, const std::array<bool, 6>& is_shared) {
    if (std::ranges::all_of(v.sites, [](Site s) { return s.is_object(); })) return -1;
    int nearest = -1;
    double least = HUGE_VAL;
    for (int side = 0; side < 6; ++side) {
        const double away = std::abs(v.point[side / 2] - (side % 2 == 1 ? region.max : region.min)[side / 2]);
        if (!is_shared[side] || !(away < least)) continue;
        least = away;
        nearest = side;
    }
    return nearest;
}

void add_edges(const Cell& cell, const Box& region, bool is_as_given, SolidCurves& found) {
    for (const CellFace& face : cell.faces)
        if (face.site.is_object() && std::ranges::any_of(face.extra_sites, &Site::is_object))
            throw UndecidedError("objects 0 and 1 are equally far from the base all over a surface");
    for (const CellEdge& edge : cell.edges) {
        if (!is_between_objects(edge)) continue;
        UncutCurve curve{edge.curve, edge.error, kind_of(edge.kind), edge.vertices.empty(),
                         {-1, -1},   is_as_given};
        double sum = curve.error;
        for (const Eigen::Vector4d& p : edge.curve.points) sum += p.sum();
        if (!std::isfinite(sum))
            fail_trisector("has no curve with a bound on its error", edge.curve.points.front().head<3>());
        for (std::size_t end = 0; end < edge.vertices.size(); ++end)
            curve.ends[end] = end_of(cell.vertices[edge.vertices[end]], region, found.is_cut_already);
        found.curves.push_back(std::move(curve));
    }
}

// What is proved of an edge is the sum of two errors. A cut adds as much again, and both may be there twice.
double tolerance_before(double tolerance, const Box& box, const Box& region) {
    const bool is_cut = box.min != region.min || box.max != region.max;
    return is_cut ? tolerance / 8 : tolerance / 2;
}

Cell lifted_cell(const RadialBaseProblem& problem, const DecidedScene& decided, const SolidProblems& solid) {
    LiftedCell lifted =
        lift_curves_between_objects(problem, diagram_of(problem, {}), *decided.scene.tolerance);
    lifted.cell.scene = solid.scene;
    const double moved = std::max(solid.moved, decided.moved);
    add_scene_motion(lifted, most(problem.moves, {moved, moved, 0}));
    scale(lifted.cell, decided.unit, problem.chart.unit_of_coordinates(decided.unit));
    return std::move(lifted.cell);
}

bool may_be_in_all(const Solids& solids) {
    return !(are_certainly_apart(solids[0], solids[1]) || are_certainly_apart(solids[0], solids[2]) ||
             are_certainly_apart(solids[1], solids[2]));
}

}  // namespace

void fail_trisector(const std::string& what, const Vec3& p) {
    throw UndecidedError("the trisector " + what + " near " + to_text(p));
}

std::vector<Solids> seen_from_all_sides(const Solids& objects) {
    std::vector<Solids> all{objects};
    for (std::size_t k = 0; k < objects.size(); ++k) {
        const Object behind = turned_over(objects[k]);
        if (behind == objects[k]) continue;
        for (std::size_t i = all.size(); i-- > 0;) {
            all.push_back(all[i]);
            all.back()[k] = behind;
        }
    }
    return all;
}

std::vector<SolidCurves> curves_beside(const Object& base, const Object& a, const Object& b,
                                       const Box& region, double tolerance) {
    std::vector<SolidCurves> all;
    CellOptions options;
    options.measure = false;
    for (const Object& side : sides_to_look_from(base, std::array{a, b})) {
        Scene scene;
        scene.base = side;
        scene.objects = {a, b};
        scene.box = box_with_feet(side, region);
        scene.tolerance = tolerance_before(tolerance, scene.box, region);
        const Cell cell = voronoi_cell(scene, options);
        if (!cell.parts.empty())
            throw InputError(InputError::Kind::TouchesBase, InputError::no_object, "base",
                             "has cross sections that another object holds");
        const Vec3 foot = foot_of(side, 0.5 * (region.min + region.max));
        SolidCurves found{
            {side, seen_from(a, foot), seen_from(b, foot)}, {}, shared_sides(scene.box, region), false};
        found.may_go_within = turned_over(side) == side && may_be_in_all(found.solids);
        add_edges(cell, region, true, found);
        all.push_back(std::move(found));
    }
    return all;
}

std::vector<SolidCurves> curves_around_thinnest(const Solids& objects, const Box& region, double tolerance) {
    const std::size_t base = *thinnest(objects);
    std::vector<SolidCurves> all;
    for (const Solids& solids : seen_from_all_sides(objects)) {
        Scene scene;
        scene.base = solids[base];
        scene.objects = {solids[(base + 1) % 3], solids[(base + 2) % 3]};
        scene.box = box_with_feet(scene.base, region);
        scene.tolerance = tolerance_before(tolerance, scene.box, region);
        validate(scene);
        const DecidedScene decided = decide(scene);
        SolidCurves found{solids, {}, shared_sides(scene.box, region), may_be_in_all(solids)};
        try {
            const SolidProblems problems = solid_problems(decided.scene, decided.unit);
            for (const RadialBaseProblem& problem : problems.parts)
                add_edges(lifted_cell(problem, decided, problems), region, false, found);
        } catch (const InputError& e) {
            if (e.kind != InputError::Kind::TouchesBase) throw;
            throw UndecidedError(std::string("the trisector is not told where solids touch: ") + e.what());
        }
        all.push_back(std::move(found));
    }
    return all;
}

}  // namespace vcell
