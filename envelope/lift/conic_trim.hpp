/// Trims of conics: a span's image in the parameters of a patch, and how finely a conic is divided for it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "conic_span.hpp"
#include "edge_trims.hpp"
#include "radial_patch.hpp"
#include "trim_bounds.hpp"

namespace vcell {

/// What edge_trims.hpp asks of a patch.
ConicTrim conic_trim(const RadialPatch& patch, const ConicSpan& span);
std::array<Vec2, 2> line_trim(const RadialPatch& patch, const Eigen::Vector4d& from,
                              const Eigen::Vector4d& to);

namespace radial {

/// Middle weights of conics, in space and in both faces' parameters, against the geometric mean of those at
/// the ends: from here on control points stay close to their curves. An arc of a circle of 145 degrees has
/// it.
constexpr double least_weight = 0.3;

/// Control points (u w, v w, w) of a span's image on a patch of total degree two, whose parameters are
/// quotients of linear functions of (p, t).
struct TrimSpan {
    Eigen::Vector3d from, middle, to;

    TrimSpan(const RadialPatch& patch, const ConicSpan& s) {
        from = patch.projected(s.from, 1);
        middle = patch.projected(s.middle, s.weight);
        to = patch.projected(s.to, 1);
        if (patch.kind() == RadialPatch::Kind::Stereographic) settle_weights(patch.axes()[2], s);
        if (patch.kind() == RadialPatch::Kind::Confocal) settle_parameters(patch, s);
    }
    double weight() const { return middle.z() / std::sqrt(from.z() * to.z()); }

private:
    void settle_weights(const Vec3& axis, const ConicSpan& s);
    void settle_parameters(const RadialPatch& patch, const ConicSpan& s);
};

/// Appends a span, halved until its weights in space and in the given parameters are large enough. Numbers
/// that are none are not halved.
void add_halves(const ConicSpan& span, std::span<const RadialPatch* const> patches,
                std::vector<ConicSpan>& spans, int halvings = 40);
/// Appends a span whose points may lie at distances of all sizes from the axis, halved until neither a large
/// weight nor unequal legs crowd them. Numbers that are none are not halved.
void add_even(const ConicSpan& span, std::vector<ConicSpan>& spans, int halvings = 40);

/// Extends a rectangle of parameters by a span's trim.
void extend_by_span(Rectangle& box, const RadialPatch& patch, const ConicSpan& span, int halvings = 40);

}  // namespace radial

}  // namespace vcell
