/// Splines for arcs that are no conics: quintic spans with a certified distance from the true arc.
///
/// Both ends of a span lie on the arc f = g. Over its chord the arc is a graph h(x); value, slope and second
/// derivative of h at both ends follow from the gradients and Hessians of the two heights, and make a
/// quintic that errs by the sixth power of the span. The height along the arc and the parameters (u, v) of
/// the patches on both sides are interpolated to second order too, in the same parameter. A span that is not
/// good enough is halved at a point of the arc, found by Newton's method.
///
/// *The certificate.* Let (p, z)(t) be the fitted span.
///
/// 1. Heights. The implicit equation of a bisector (C - 2 beta z - d_z^2 z^2 = 0, or
///    k |p - c|^2 + a.p + e = w z) along the span is a polynomial of degree 10 in t, and no larger than its
///    largest Bernstein coefficient. Divided by its derivative in z it bounds |z - f(p)| <= e_f; likewise
///    for g.
/// 2. Place. So |f - g| <= e_f + e_g along p(t). In a disk around the span grad (f - g) stays close to its
///    value in the middle, by the curvature bounds (1/s of cylinder_patch.hpp, 2k/w). If a lower bound
///    `slope` of the derivative in the direction of that value is positive, f = g within
///    x = (e_f + e_g) / slope of every p(t).
/// 3. Which arc. Within the disk f = g is one graph across that direction. Let d be the direction of the
///    diagram's piece. The cell of the piece and the disk are convex and both contain the chord between two
///    points of the arc in the cell; a line along d that meets the chord meets their union in a segment. If
///    the derivative along d is positive in the disk too, then f = g once on that segment: the graph is the
///    arc. A halving point is on the arc for the same reason. A span over several pieces takes a disk that
///    contains their cells, so the arc.
/// 4. Trims. The patch's chart point at (u, v)(t), a polynomial of degree 15, is compared with p(t)
///    coefficient by coefficient.
///
/// All of it in double: residuals carry bounds of their rounding.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <variant>
#include <vector>

#include "../diagram/minimization_diagram.hpp"
#include "cylinder_patch.hpp"

namespace vcell {

/// A Bezier span of an edge with a cylinder on a side, in canonical coordinates: rational, all curves in one
/// parameter.
struct MixedSpan {
    static constexpr int largest_degree = 5;
    struct Trim {
        int degree = 0;  ///< 0: no cylinder on this side, its trim is the chart curve
        std::array<Eigen::Vector3d, largest_degree + 1> points;  ///< (u, v, w)

        Trim() { points.fill(Eigen::Vector3d::Zero()); }
    };

    int degree = 1;
    std::array<Eigen::Vector4d, largest_degree + 1> points;  ///< (x, y, height, w), w divided out
    std::array<Trim, 2> trims;                               ///< on the left and right

    MixedSpan() { points.fill(Eigen::Vector4d::Zero()); }
};

/// A height on one side of an arc: exactly one is set.
struct ArcSide {
    const CircularForm* circular = nullptr;
    const CylinderFrame* cylinder = nullptr;
};

struct ArcEnd {
    Eigen::Vector2d point;
    double height;
};

struct FitError {
    double chart = 0;  ///< distance of the chart curve from the arc's projection
    double space = 0;  ///< of the space curve from the arc, and of the lifted trims from the space curve
};

/// Appends the spans of an arc whose pieces are given. No start: the arc is closed. tolerance: length. The
/// result exceeds it only where the pieces are narrower than digits can tell, and says so: no span is then
/// divided further than to the error of the worst one, and there is a budget of divisions.
FitError fit_spline(const std::array<ArcSide, 2>& sides, const ArcEnd* start, const ArcEnd* end,
                    std::span<const MinimizationDiagram::ArcPiece> pieces, double tolerance,
                    std::vector<MixedSpan>& spans);

/// The line a x + b y + c = 0 of the chart over which a wall stands.
struct WallLine {
    double a, b, c;
};

/// The plane that a section lies in: over a line of the chart, or the graph of a linear height.
using SectionSurface = std::variant<WallLine, CircularForm>;

/// The errors of rational quadratic (or linear) spans in a plane and of their trims, by steps 1, 2 and 4 for
/// rational curves, of the plane and the first cylinder's height. No height on the right: a rim. Where parts
/// cannot be proved, the arc goes on between those that are: four times their size.
FitError conic_error(const std::array<ArcSide, 2>& sides, const SectionSurface& plane,
                     std::span<const MixedSpan> spans);

}  // namespace vcell
