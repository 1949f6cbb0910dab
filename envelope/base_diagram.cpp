#include "base_diagram.hpp"

#include <cstdint>
#include <cstdio>

#include "../core/errors.hpp"
#include "../core/threads.hpp"
#include "diagram/settled_vertices.hpp"

namespace vcell {

MinimizationDiagram envelope_over(const FormFamily& family, std::span<const RegionSide> region,
                                  const EnvelopeOptions& options) {
    if (family.chart.is_cylinder())
        return lower_envelope_on_cylinder(family, -region[0].c, region[2].c, options);
    ConvexRegion polygon;
    for (const RegionSide& side : region) polygon.sides.push_back({side.a, side.b, side.c});
    MinimizationDiagram diagram = family.chart.is_sphere() ? lower_envelope_on_sphere(family, options)
                                                           : lower_envelope(family, polygon, options);
    settle_vertices(family, diagram, thread_count(options.threads));
    return diagram;
}

std::string message(const Assumption& a, const char* what, const BaseProblem& problem) {
    std::string sites;
    for (const FormId f : a.forms)
        for (const Site site : problem.sites[f]) sites += (sites.empty() ? "" : ", ") + to_string(site);
    const Vec3 p = problem.unit * problem.frame.to_world(problem.chart.base_point(a.place));
    char place[128];
    std::snprintf(place, sizeof place, "(%.9g, %.9g, %.9g), not told apart within %.2g", p.x(), p.y(), p.z(),
                  problem.chart.unit_of_coordinates(problem.unit) * a.width);
    return "objects " + sites + ": " + what + " " + place;
}

MinimizationDiagram diagram_of(const BaseProblem& problem, const EnvelopeOptions& options) {
    EnvelopeOptions told = options;
    for (const FormId f : problem.sites.ids())
        if (problem.sites[f].front().kind == Site::Kind::BoxSide) told.box_sides.push_back(f);
    try {
        return envelope_over(problem.family, problem.region, told);
    } catch (const TieError& e) {
        throw UndecidedError(message(e.tie, "seem to be equally near along a curve around", problem));
    }
}

}  // namespace vcell
