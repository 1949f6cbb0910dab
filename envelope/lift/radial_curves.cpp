#include "radial_curves.hpp"

#include <algorithm>

#include "joined_spans.hpp"

namespace vcell::radial {

double RadialCurves::reach() const {
    double reach = 0;
    for (const ConicSpan& s : conics_) reach = std::max(reach, s.from.w());
    for (const std::vector<SpaceSpan>& spans : splines_)
        for (const SpaceSpan& s : spans) reach = std::max(reach, s.points.row(3).maxCoeff());
    return reach;
}

void RadialCurves::to_world(EdgeId e, const BaseFrame& frame, RationalCurve3& curve) const {
    begin_joined(curve, is_line(e) ? 1 : is_spline(e) ? 5 : 2, size(e));
    const auto add = [&](const Vec3& p, double w) {
        const Vec3 world = frame.to_world(p);
        curve.points.push_back({world.x(), world.y(), world.z(), w});
    };
    if (is_line(e)) {
        add(from(e).head<3>(), 1);
        add(to(e).head<3>(), 1);
    } else if (is_spline(e)) {
        for (const SpaceSpan& span : splines_[e])
            for (int k = curve.points.empty() ? 0 : 1; k < 6; ++k) add(span.points.col(k).head<3>(), 1);
    } else {
        add(conics(e).front().from.head<3>(), 1);
        for (const ConicSpan& span : conics(e)) {
            add(span.middle.head<3>() / span.weight, span.weight);
            add(span.to.head<3>(), 1);
        }
    }
}

}  // namespace vcell::radial
