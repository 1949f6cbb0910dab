/// The order of points along a directed curve of a kernel.
#pragma once

#include "circle_kernel.hpp"

namespace vcell {

class CurveOrder {
public:
    CurveOrder(CircleKernel& kernel, FormPair curve) : kernel_(kernel), curve_(curve) {}

    /// Does r lie strictly between p and q, going along the curve's direction? All three are points of it.
    /// For p == q: everything else on a circle does. r equal to p or q does not.
    bool strictly_between(PointId p, PointId q, PointId r);
    /// Does q come after p? Pre: the curve is a line.
    bool precedes(PointId p, PointId q);

private:
    Sign exact_line_order(const ExactCurve& line, PointId p, PointId q);
    bool exact_strictly_between(PointId p, PointId q, PointId r);

    CircleKernel& kernel_;
    FormPair curve_;
};

}  // namespace vcell
