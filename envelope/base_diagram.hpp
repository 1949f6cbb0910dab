/// The minimization diagram of a problem, over any base.
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <string>

#include "../core/errors.hpp"
#include "../primitives/bases/radial_base.hpp"
#include "diagram/minimization_diagram.hpp"

namespace vcell {

/// The lower envelope of a family over the base of its chart, over a plane and a cylinder within these sides.
/// Vertices over planes and spheres are settled.
MinimizationDiagram envelope_over(const FormFamily& family, std::span<const RegionSide> region,
                                  const EnvelopeOptions& options);

/// "objects 1, 2, 5: <what> (x, y, z), not told apart within w".
template <class Problem>
std::string message(const Assumption& a, const char* what, const Problem& problem) {
    std::string sites;
    for (const FormId f : a.forms)
        for (const Site site : problem.sites[f]) sites += (sites.empty() ? "" : ", ") + to_string(site);
    const Vec3 p = problem.unit * problem.frame.to_world(problem.chart.base_point(a.place));
    char place[128];
    std::snprintf(place, sizeof place, "(%.9g, %.9g, %.9g), not told apart within %.2g", p.x(), p.y(), p.z(),
                  problem.chart.unit_of_coordinates(problem.unit) * a.width);
    return "objects " + sites + ": " + what + " " + place;
}

/// Throws UndecidedError, which names the objects, where forms tie along a curve.
template <class Problem>
MinimizationDiagram diagram_of(const Problem& problem, const EnvelopeOptions& options) {
    EnvelopeOptions told = options;
    for (std::uint32_t f = 0; f < problem.family.size(); ++f)
        if (!problem.sites[FormId{f}].front().is_object()) told.box_sides.push_back(FormId{f});
    try {
        return envelope_over(problem.family, problem.region, told);
    } catch (const TieError& e) {
        throw UndecidedError(message(e.tie, "seem to be equally near along a curve around", problem));
    }
}

}  // namespace vcell
