/// Over a sphere: which balls, planes and tubes tie with two others all along a curve, and are nowhere nearer
/// than both.
///
/// What is left of a ray's way at p = t u, before it is as near to an object as to the base,
///
///     E(p, t) = C - 2 t (b0 + b.u) - t^2 (a.u)^2,   C > 0,
///
/// with the coefficients of radial_form.hpp, a = 0 for balls and planes, has one root t > 0 at most: the
/// place is nearer to the base as long as E > 0. Divided by C these are points of a space of ten dimensions.
/// Three of them whose bisectors with the base meet in one curve are mostly of one pencil, on a line there,
/// and the one between the others is their mean with positive weights: it is positive wherever both of them
/// are, and zero there only where both are. So it is with two sides of the box and a ball whose bisector runs
/// through the edge between them; with the centres of four balls of one radius, the base among them, at the
/// corners of a rectangle; and with a ball or tube, its mirror image in the plane between the base and a ball
/// of its radius, and that ball.
///
/// Where a mean of two falls into two linear factors, E and E', of opposite gradients, the form whose E that
/// is is never nearer than both, either: as long as both are positive their mean is, and so is each factor.
/// In any direction one of the factors has a root, and that form ties wherever both are lowest. So a ball has
/// the plane between it and its image, and two tubes of its radius in there, mirrored by it: what is between
/// the ball and a tube is a parabolic cylinder, and both of these meet in two parallel planes.
#pragma once

#include <array>
#include <vector>

#include "form_family.hpp"

namespace vcell {

struct PencilTie {
    FormId form;
    /// `form` is a mean of these, with weights greater than zero, or a factor of one. It ties wherever both
    /// are lowest, a factor only where it is less than zero.
    std::array<FormId, 2> between;
    bool is_factor = false;
};

/// Ties of these kinds among the 32 forms that come lowest, exact; hollow tubes, cones and tubes that pierce
/// the base take no part. A form may have several. Where coefficients agree in all but their last digits some
/// may be left out. Pre: the family is a sphere's.
std::vector<PencilTie> find_pencil_ties(const FormFamily& family);

}  // namespace vcell
