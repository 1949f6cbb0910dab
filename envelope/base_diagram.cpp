#include "base_diagram.hpp"

#include <cstdio>

#include "../core/errors.hpp"
#include "diagram/settled_vertices.hpp"

namespace vcell {

namespace {

template <class Problem>
std::string message_at(const Vec3& base_point, double width, const Assumption& a, const char* what,
                       const Problem& problem) {
    std::string sites;
    for (const FormId f : a.forms)
        for (const Site site : problem.sites[f]) sites += (sites.empty() ? "" : ", ") + to_string(site);
    const Vec3 p = problem.unit * problem.frame.to_world(base_point);
    char place[128];
    std::snprintf(place, sizeof place, "(%.9g, %.9g, %.9g), not told apart within %.2g", p.x(), p.y(), p.z(),
                  width);
    return "objects " + sites + ": " + what + " " + place;
}

template <class Problem, class Find>
MinimizationDiagram found(const Problem& problem, Find find) {
    try {
        return find();
    } catch (const TieError& e) {
        throw UndecidedError(message(e.tie, "seem to be equally near along a curve around", problem));
    }
}

}  // namespace

// Over a plane the chart's coordinates are lengths.
std::string message(const Assumption& a, const char* what, const PlaneBaseProblem& problem) {
    return message_at({a.place.x(), a.place.y(), 0}, problem.unit * a.width, a, what, problem);
}

std::string message(const Assumption& a, const char* what, const RadialBaseProblem& problem) {
    return message_at(problem.point(a.place, problem.radius), a.width, a, what, problem);
}

MinimizationDiagram diagram_of(const PlaneBaseProblem& problem, const EnvelopeOptions& options) {
    return found(problem, [&] {
        ConvexRegion region;
        for (const RegionSide& side : problem.region) region.sides.push_back({side.a, side.b, side.c});
        MinimizationDiagram diagram = lower_envelope(problem.family, region, options);
        settle_vertices(problem.family, diagram);
        return diagram;
    });
}

MinimizationDiagram diagram_of(const RadialBaseProblem& problem, const EnvelopeOptions& options) {
    return found(problem, [&] {
        if (!problem.is_sphere)
            return lower_envelope_on_cylinder(problem.family, problem.stretch[0], problem.stretch[1],
                                              options);
        MinimizationDiagram diagram = lower_envelope_on_sphere(problem.family, options);
        settle_vertices(problem.family, diagram);
        return diagram;
    });
}

}  // namespace vcell
