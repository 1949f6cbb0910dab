/// Centroids and second moments of cells.
#pragma once

#include "../../envelope/cell.hpp"

namespace vcell {

/// Those of all that the cell's faces and what closes them (closing_of()) enclose: the base's body included,
/// and over a plane all from the plane up.
///
/// Every patch is integrated along its trims: with q the place from about the cell's middle, the integrals of
/// q_i and q_i q_j over the volume are those of q_i q.n / 4 and q_i q_j q.n / 5 over its boundary (divergence
/// theorem), which in the patch's parameters are integrals of rational functions, and these integrals dv of
/// antiderivatives in u (Green). Both quadratures are Gauss's, with proven truncation (span_integrals.hpp).
/// Errors hold truncation, rounding (first order, doubled), and strips along the edges as wide as trims may
/// be off the true arcs. The volume is the cell's where it is measured.
///
/// Pre: the cell has patches; their degrees are 8 at most, and those of trims 5, as in cells that are
/// computed. Otherwise, and as closing_of() does, throws InternalError.
Moments moments_of(const Cell& cell);

}  // namespace vcell
