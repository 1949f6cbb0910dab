/// Minimization diagrams of linear functions on the sphere, one form after the other, in certified doubles:
/// the fast way for cells of spheres among spheres and planes.
///
/// Over the unit sphere, u = (2x, 2y, 1 - x^2 - y^2) / W in the stereographic chart, a circular form is
/// linear,
///
///     f / W = b.u + e,    b = (a_x, a_y, e_f - k) / (2 w),   e = (e_f + k) / (2 w),
///
/// so two of them tie in a plane, three at two points of a line, and the set where a third one beats both
/// ends of an edge is decided in three dimensions, without a seam or a pole.
#pragma once

#include <optional>

#include "../diagram/minimization_diagram.hpp"

namespace vcell {

/// The lower envelope of circular forms over the sphere, if it and those of the forms inserted on the way are
/// of the common kind: every form has at most one face and all faces are discs;
/// and if double arithmetic with error bounds decides all signs but those of a form at a vertex or along an
/// edge, for which there are exact numbers: any number of forms may tie there. Otherwise nothing, for the
/// general engine to decide. Expected time O(n log n) when forms of about the same height are spread over the
/// sphere. Pre: as lower_envelope_on_sphere(); family.is_all_circular().
std::optional<MinimizationDiagram> disc_diagram_on_sphere(const FormFamily& family,
                                                          const EnvelopeOptions& options);

}  // namespace vcell
