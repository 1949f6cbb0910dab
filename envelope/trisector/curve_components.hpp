/// Which component of a trisector a curve beside it lies on, and conics through its points.
#pragma once

#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/bisectors/trisector.hpp"

namespace vcell {

/// The components that a curve within `error` of the trisector may lie on.
class CurveComponents {
public:
    explicit CurveComponents(Trisector all) : all_(std::move(all)) {}

    /// That of a curve. Regular as it is between nodes, it lies on one of them: a conic that one of its
    /// points is certainly off is another one. Throws UndecidedError where several are left.
    const TrisectorComponent& of(const RationalCurve3& curve, double error) const;

    /// Arcs of a conic or line along a curve beside it.
    static std::vector<RationalCurve3> along(const TrisectorComponent& conic, const RationalCurve3& curve,
                                             bool is_closed);

private:
    Trisector all_;
};

}  // namespace vcell
