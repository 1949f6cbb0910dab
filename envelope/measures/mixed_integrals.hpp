/// Measures along the arcs beside cylinders: shares of a face's volume and areas, lengths, walls.
///
/// Over a face of a cylinder, in the coordinates (u, v) of its patch, area elements of the chart and of the
/// surface and the height are polynomials in u, or polynomials times functions of v alone:
///
///     dx dy = mu (1 + eps^2 v^2 / 4) du dv,   f = f0 + rise u + mu W(v),   dA = mu |D(v)| du dv,
///     mu = 1 + eps u.
///
/// Their antiderivatives in u turn the integrals into boundary integrals dv (Green), for span_integrals.hpp.
/// Near the cone's tip, where mu = 0, directions about it take the place of (u, v).
#pragma once

#include <Eigen/Core>
#include <span>

#include "../lift/cylinder_patch.hpp"
#include "span_integrals.hpp"

namespace vcell {

/// Control points (x, y, height, w) of a rational Bezier span, w divided out, canonical.
using ControlPoints = std::span<const Eigen::Vector4d>;

/// The share of a boundary span, in its own direction, with the face on its left.
struct FaceIntegrals {
    Integral volume, chart_area, area;
};

/// Over a circular form, about a point `origin` near the face; area of the surface.
FaceIntegrals face_integrals(const CircularForm& f, const Eigen::Vector2d& origin, ControlPoints span);
/// Over a cylinder. `extent`: within which all the face's boundary is of the frame's origin. Where the cone's
/// tip is as near, the integrals are taken from the tip.
FaceIntegrals face_integrals(const CylinderFrame& frame, double extent, ControlPoints span);

Integral space_length(ControlPoints span);
/// The area between a span over a side of the region and its foot.
Integral wall_area(ControlPoints span);

}  // namespace vcell
