/// Sphere and cylinder bases: canonical position, charts, height functions.
///
/// Canonical position and heights are those of primitives/forms/radial_form.hpp; with delta = rho - R0 (R0
/// the base's radius), the base point's axis point f = (0, y, 0) (y = 0 on a sphere), N = |a|^2 and m = f - p
/// for a cylinder through p along a:
///
///     sphere (c, rho)                 C = |f - c|^2 - delta^2,                   B = c.n + delta W
///     plane n'.p + D, s its sign      C = s (n'.f + D) + R0 |n'|,                B = (|n'| W - s n'.n) / 2
///     box side m'.p <= k              C = k - m'.f,                              B = m'.n / 2
///     cap t <= T (sphere base)        C = T,                                     B = W / 2
///     inside of a sphere (c, R)       C = (R + R0)^2 - |f - c|^2,                B = (R + R0) W - c.n
///     cylinder (p, a, rho)            C = N (|m|^2 - delta^2) - (m.a)^2,         B = N (p.n + delta W) +
///     (m.a)(a.n),  A = a.n
///     inside of a cylinder            the same with rho = -R, C and B with their signs turned, and + A^2 in
///                                     the equation; of a cone as radial_form.hpp has it
///
/// |n'| is told by two doubles. C > 0 all over the base, but for a tube that *pierces* it: thinner than the
/// base, with an axis nearer to the base's centre or axis than radii differ. Then C < 0, over a cylinder
/// between two places. Objects may overlap the base's body (clearance is then negative somewhere), but
/// neither contain it nor lie in it; planes stay clear of it.
///
/// Over a sphere everything but a cylinder is a CircularForm in the stereographic chart; its pole is put
/// where one object is nearest all around, so that no edge of the diagram comes near it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../objects/objects.hpp"
#include "../objects/scene.hpp"
#include "base_problem.hpp"

namespace vcell {

/// A scene over a sphere or a cylinder base, brought to canonical position and checked.
///
/// Sphere: the frame's R is the identity, its origin the centre. Cylinder: the axis becomes the y axis, the
/// origin is its foot of the box's centre, or in general the base's point where that is within a diagonal of
/// the box; the axis turns by a few 2^-53, unless its length is a double, and tubes and cones along it turn
/// with it.
struct RadialBaseProblem : BaseProblem {
    /// Cylinder: the base points' range of y, canonical. Over a box in world axes it is the longest stretch
    /// all of whose circles lie inside the sides of the box that the axis runs into; rounded inwards. At ends
    /// on oblique sides of the box a circle of less than 2^-26 box diagonals counts as one of that radius.
    std::array<double, 2> stretch{-std::numeric_limits<double>::infinity(),
                                  std::numeric_limits<double>::infinity()};
    /// The first site of each form in canonical coordinates; a side of the box is a Plane with outward
    /// normal, and so are what is_wall() tells of besides; the cap itself a Sphere about the base's centre.
    IdVector<FormId, Object> objects;
    /// Over a cylinder: the base and the objects of forms as the decided scene has them, in no motion's
    /// rounding. Of sides of the box as above.
    Cylinder given_base;
    IdVector<FormId, Object> given;
    /// A site along a cylinder base that is as near as two forms over one generator, and no nearer than the
    /// nearer of them about it (axial_ties.hpp): the fourth tube around a line of a square lattice. It has no
    /// form, or is nearest elsewhere.
    struct GeneratorTie {
        Site site;
        FormId before, after;  ///< the nearer ones on both sides, as the angle about the y axis grows
        bool is_decided;       ///< exact, or in the scene as it was moved; otherwise up to narrow_tie
    };
    std::vector<GeneratorTie> generator_ties;
    /// A site that is as near as two forms wherever both are as near as the base, and nowhere nearer than
    /// both of them (wall_ties.hpp, mirror_ties.hpp). It has no form.
    struct CommonTie {
        Site site;
        FormId first, second;
    };
    std::vector<CommonTie> common_ties;
    /// Of a part of a cylinder (CylinderPart): the sides of the box through which rays come in, forms as
    /// those of sides of what is beyond them (EnvelopeOptions::floor).
    std::vector<FormId> floor;

    /// As PlaneBaseProblem::shows().
    bool shows(FormId f, bool is_below_floor) const {
        return floor.empty() || (std::ranges::find(floor, f) != floor.end()) == is_below_floor;
    }

    /// Holds all chart points {x0, x1, y0, y1}, but for a millionth of a sphere.
    std::array<double, 4> chart_box() const;
    /// Are both cylinders, of one radius, with axes that cross in a point? Exact, about the forms.
    bool cross_equally(FormId f, FormId g) const;
};

/// A scene with a probe has its cap, as decide() makes it; over a sphere that is T = R0 + probe exactly.
/// Throws InputError as plane_base_problem() does, by exact signs:
///   TouchesBase  a plane that cuts or touches the base's body (of a cylinder: the part over its stretch); a
///   ball or
///                cylinder that contains the base's body (of a cylinder: one of its circles), lies in it, or
///                touches it from within: C > 0 does not hold, and it does not pierce the base; a vessel that
///                has all of the base, or of one of its circles, beyond its wall, or all but a point;
///   EmptyBox     the base sphere's centre is not inside the box, a base cylinder's axis not inside the
///                sides along it (the base may reach beyond them: clearance is negative there), or no
///                stretch of the base cylinder is in the box;
///   OutOfRange   a height's coefficients leave the double range.
/// Throws UndecidedError when no pole for the chart can be seen in doubles: all around the sphere the nearest
/// objects are all but equal.
/// Left out with a warning: balls and cylinders that lie in another one's solid or, cylinders, beyond a
/// plane; what lies beyond a vessel's wall; over a cylinder balls out of sight beyond the ends of the
/// stretch. Pre: validate(scene) has passed; the base is a sphere or a cylinder.
RadialBaseProblem radial_base_problem(const Scene& scene, double unit = 1);

/// |c|^2 - (rho - R0)^2 of a ball over a sphere base, or (R + R0)^2 - |c|^2 of a hollow sphere, to some
/// roundings: of the scene's coordinates, as the form has them. (Near contact the canonical centre's rounding
/// would change it.)
double ball_power(const RadialBaseProblem& problem, FormId form);
/// ball_power() of a ball around a ball, none of others.
std::optional<double> power_of_ball(const RadialBaseProblem& problem, FormId form);

/// Is it a side of the box, or one of the planes between a cylinder base and a tube of its radius whose axis
/// crosses its own? A Plane with outward normal then, which bounds the cell.
inline bool is_wall(const RadialBaseProblem& problem, FormId f) {
    return problem.sites[f].front().kind == Site::Kind::BoxSide ||
           (!problem.chart.is_sphere() && std::holds_alternative<Plane>(problem.objects[f]) &&
            std::holds_alternative<Cylinder>(problem.given[f]));
}

/// Is the bisector a plane (a side of the box included)? Exact.
bool is_flat(const RadialBaseProblem& problem, FormId form);

/// Is it a tube that pierces the base: thinner than that, with an axis nearer to the base's centre or axis
/// than radii differ, over a cylinder somewhere in the stretch? C is less than 0 there, and the bisector has
/// tips. Exact.
bool pierces_base(const RadialBaseProblem& problem, FormId form);
/// Is there such a tube, or a vessel?
bool may_have_tips(const RadialBaseProblem& problem);

/// The bisector's name for cell files, decided exactly: "box", "plane", "paraboloid", "hyperboloid",
/// ... or "quartic" (primitives/bisectors/bisector.hpp).
std::string_view bisector_name(const RadialBaseProblem& problem, FormId form);

}  // namespace vcell
