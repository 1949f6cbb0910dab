#include "edge_curves.hpp"

#include <algorithm>

#include "joined_spans.hpp"

namespace vcell {

double EdgeCurves::reach() const {
    double reach = 0;
    for (const std::vector<ConicSpan>& spans : conics_)
        for (const ConicSpan& s : spans) reach = std::max(reach, s.from.w());
    for (const std::vector<SpaceSpan>& spans : splines_)
        for (const SpaceSpan& s : spans) reach = std::max(reach, s.points.row(3).maxCoeff());
    return reach;
}

void EdgeCurves::to_world(EdgeId e, const BaseFrame& frame, RationalCurve3& curve) const {
    begin_joined(curve, degree(e), size(e));
    for_controls(e, [&](const Vec3& p, double w) {
        const Vec3 world = frame.to_world(p);
        curve.points.push_back({world.x(), world.y(), world.z(), w});
    });
}

}  // namespace vcell
