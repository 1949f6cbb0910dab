#include "conic_trim.hpp"

#include <algorithm>
#include <cmath>

namespace vcell {

ConicTrim conic_trim(const RadialPatch& patch, const ConicSpan& span) {
    if (patch.kind() == RadialPatch::Kind::AboutBase) return cubic_trim(patch.coordinates(), 0, span);
    const radial::TrimSpan trim(patch, span);
    return {2, {trim.from, trim.middle, trim.to}};
}

std::array<Vec2, 2> line_trim(const RadialPatch& patch, const Eigen::Vector4d& from,
                              const Eigen::Vector4d& to) {
    std::array ends{patch.parameters(Vec3(from.head<3>())), patch.parameters(Vec3(to.head<3>()))};
    // The line lies over one generator, whose direction a point near the axis tells badly.
    if (patch.kind() == RadialPatch::Kind::AboutBase) {
        const bool ends_farther = to.w() > from.w();
        ends[ends_farther ? 0 : 1].x() = ends[ends_farther ? 1 : 0].x();
    }
    return ends;
}

namespace radial {

using Eigen::Vector2d;
using Eigen::Vector4d;

// The weight is t + z with z along the patch's third axis, which cancels near the pole. But a curve on
// the cone x^2 + y^2 + z^2 = t^2 has x0^2 + y0^2 = (t0 + z0) (t0 - z0) at its ends, and the middle
// control point on the tangents there: x0 x1 + y0 y1 = ((t0 + z0) (t1 - z1) + (t0 - z0) (t1 + z1)) / 2.
void TrimSpan::settle_weights(const Vec3& axis, const ConicSpan& s) {
    const auto other = [&](const Vector4d& x) { return x.w() - axis.dot(x.head<3>()); };
    const double from_other = other(s.from), to_other = other(s.to);
    if (from.z() >= from_other && to.z() >= to_other) return;
    if (from.z() < from_other) from.z() = from.head<2>().squaredNorm() / from_other;
    if (to.z() < to_other) to.z() = to.head<2>().squaredNorm() / to_other;
    const bool at_start = from_other > to_other;
    const Eigen::Vector3d& end = at_start ? from : to;
    middle.z() = (2 * end.head<2>().dot(middle.head<2>()) - end.z() * other(s.middle)) /
                 (at_start ? from_other : to_other);
}

// u = t + z is the numerator of a weight here, and cancels as the difference above does.
void TrimSpan::settle_parameters(const RadialPatch& patch, const ConicSpan& s) {
    const auto& [x, y, z] = patch.axes();
    const auto across = [&](const Vector4d& p) { return Vector2d(x.dot(p.head<3>()), y.dot(p.head<3>())); };
    const auto other = [&](const Vector4d& p) { return p.w() - z.dot(p.head<3>()); };
    const double from_other = other(s.from), to_other = other(s.to);
    if (from.x() >= from_other && to.x() >= to_other) return;
    if (from.x() < from_other) from.x() = across(s.from).squaredNorm() / from_other;
    if (to.x() < to_other) to.x() = across(s.to).squaredNorm() / to_other;
    const bool at_start = from_other > to_other;
    const Vector4d& end = at_start ? s.from : s.to;
    middle.x() = (2 * across(end).dot(across(s.middle)) - (at_start ? from : to).x() * other(s.middle)) /
                 (at_start ? from_other : to_other);
}

void add_halves(const ConicSpan& span, std::span<const RadialPatch* const> patches,
                std::vector<ConicSpan>& spans, int halvings) {
    const auto is_small = [&](const RadialPatch* patch) {
        return TrimSpan(*patch, span).weight() < least_weight;
    };
    if (halvings > 0 && (span.weight < least_weight || std::ranges::any_of(patches, is_small))) {
        for (const ConicSpan& half : span.halves()) add_halves(half, patches, spans, halvings - 1);
        return;
    }
    spans.push_back(span);
}

void add_even(const ConicSpan& span, std::vector<ConicSpan>& spans, int halvings) {
    constexpr double greatest_weight = 4, most_unequal = 16;
    const auto leg = [&](const Vector4d& end) { return (span.middle / span.weight - end).head<3>().norm(); };
    const double from = leg(span.from), to = leg(span.to);
    const bool is_uneven = (span.weight > greatest_weight && std::isfinite(span.weight)) ||
                           std::max(from, to) > most_unequal * std::min(from, to);
    if (!is_uneven || halvings == 0) return add_halves(span, {}, spans);
    for (const ConicSpan& half : span.halves()) add_even(half, spans, halvings - 1);
}

// Halved until the weights are large enough.
void extend_by_span(Rectangle& box, const RadialPatch& patch, const ConicSpan& span, int halvings) {
    const TrimSpan trim(patch, span);
    const double weight = trim.weight();
    if (weight < least_weight && halvings > 0) {
        for (const ConicSpan& half : span.halves()) extend_by_span(box, patch, half, halvings - 1);
        return;
    }
    for (int i = 0; i < 2; ++i)
        extend(box[i], trim.from[i] / trim.from.z(), trim.middle[i] / trim.middle.z(),
               trim.to[i] / trim.to.z(), weight);
}

}  // namespace radial

}  // namespace vcell
