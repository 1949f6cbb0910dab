#include "part_ends.hpp"

#include <algorithm>
#include <variant>

namespace vcell {

std::vector<Plane> part_ends(const Object& object, const Box& box) {
    const auto* tube = std::get_if<Cylinder>(&object);
    if (tube == nullptr) return {};
    const Vec3 axis = tube->axis.stableNormalized();
    std::vector<double> places;
    for (Eigen::Index k = 0; k < 3; ++k)
        if (axis[k] != 0)
            for (const double side : {box.min[k], box.max[k]})
                places.push_back((side - tube->point[k]) / axis[k]);
    if (places.size() == 2) return {};
    std::ranges::sort(places);
    std::vector<Plane> planes;
    for (const double at : places) planes.push_back({tube->point + at * axis, axis});
    return planes;
}

void add_crossings(const RationalCurve3& curve, const Plane& plane, std::vector<double>& parameters) {
    const auto height = [&](double t) { return plane.normal.dot(curve.evaluate(t) - plane.point); };
    const auto is_above = [&](const Eigen::Vector4d& p) {
        return plane.normal.dot(p.head<3>() - plane.point) > 0;
    };
    // A curve is where its control points are.
    if (std::ranges::all_of(curve.points, is_above) || std::ranges::none_of(curve.points, is_above)) return;
    for (std::size_t i = 0; i + 1 < curve.knots.size(); ++i) {
        const double begin = curve.knots[i], end = curve.knots[i + 1];
        if (!(begin < end)) continue;
        constexpr int steps = 8, halvings = 60;
        for (int k = 0; k < steps; ++k) {
            double from = begin + (end - begin) * k / steps, to = begin + (end - begin) * (k + 1) / steps;
            const bool starts_above = height(from) > 0;
            if (starts_above == (height(to) > 0)) continue;
            for (int n = 0; n < halvings; ++n) {
                const double middle = 0.5 * (from + to);
                ((height(middle) > 0) == starts_above ? from : to) = middle;
            }
            if (to > curve.domain_begin() && to < curve.domain_end()) parameters.push_back(to);
        }
    }
}

}  // namespace vcell
