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

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "../diagram/minimization_diagram.hpp"
#include "disc_arcs.hpp"

namespace vcell {

/// Places by which a further form is seen to be nowhere the lowest, in the coordinates of b above.
///
/// A form c that is above the diagram at its vertices, and where tangents to a short arc of an edge meet, is
/// above it all along the edges. A face in a cap of less than a quarter turn lies in the convex hull of its
/// boundary and the top of the cone that touches the sphere along the cap's rim: there c is above the face's
/// form, too. Where a wider face lies in a hemisphere, and its own form grows towards the other one, c is
/// above in it if it grows less that way (disc_comparison.hpp). In faces that are wider still it is if it is
/// flat enough.
struct SphereMarks {
    struct Mark {
        Eigen::Vector3d p;
        double level;
    };
    /// Up to 2 from the centre: c(p) > level.
    std::vector<Mark> places;
    /// Unit vectors, along the gradients of faces' forms where that will do: b.p < level, for the true b.
    std::vector<Mark> gradients;
    double steepest = 0;  ///< steeper forms are not told of
    bool are_all = true;  ///< otherwise they tell nothing of some edge or face
};

/// Asked when all forms so far are in a diagram, whose marks it may ask for: appends more to the family.
enum class MoreForms { None, Added, GivenUp };
using TakeMoreForms = std::function<MoreForms(const std::function<SphereMarks()>& marks)>;

/// The lower envelope of circular forms over the sphere, if it and those of the forms inserted on the way are
/// of the common kind: every form has at most one face and all faces are discs;
/// and if double arithmetic with error bounds decides all signs but those of a form at a vertex or along an
/// edge, for which there are exact numbers: any number of forms may tie there. Otherwise nothing, for the
/// general engine to decide. Expected time O(n log n) when forms of about the same height are spread over the
/// sphere. Pre: as lower_envelope_on_sphere(); family.is_all_circular().
std::optional<MinimizationDiagram> disc_diagram_on_sphere(const FormFamily& family,
                                                          const EnvelopeOptions& options);

/// What is known of the forms beside their exact coefficients: exact, too, and sooner told. None: those are
/// to be asked for.
struct TiePredicates {
    /// The sign of a form less three others in a point in which these tie, at values of that sign, not Zero.
    std::function<std::optional<Sign>(FormId form, const std::array<FormId, 3>& tied, Sign value)> sign;
    /// Do three forms tie all along a circle?
    std::function<std::optional<bool>(const std::array<FormId, 3>& forms)> along;
};

/// Finds the envelope of disc_diagram_on_sphere() as it lies on the sphere, in the coordinates of b above:
/// measures take no more. False where that function has none.
///
/// `more` is asked until there are no more forms, again in each attempt at another order, until it gives up:
/// then nothing comes of it. The form that is lowest at the pole is to be so by a margin among all of them,
/// or nothing comes of it either.
bool disc_arcs_on_sphere(const FormFamily& family, const TakeMoreForms& more, const TiePredicates& ties,
                         DiscArcs& arcs);

}  // namespace vcell
