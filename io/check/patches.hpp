/// Trimmed patches as the check sees them: which of their points lie inside the loops, and which are on a
/// ray.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "../../envelope/cell.hpp"
#include "curves.hpp"
#include "scene.hpp"

namespace vcell::check {

/// Relative to a face's extent in (u, v): points this close to its boundary, beside its errors, are not asked
/// about.
inline constexpr double kNearEdge = 1e-9;

struct Trim {
    Trim(const TrimCurve* c, double e, std::vector<Bezier<2>> all)
        : curve(c), error(e), pieces(std::move(all)) {
        for (const auto& piece : pieces)
            for (std::size_t i = 0; i < piece.points.size(); ++i) {
                const Vec2 point = piece.control(i);
                lo = lo.cwiseMin(point);
                hi = hi.cwiseMax(point);
            }
    }

    const TrimCurve* curve;
    double error;  ///< how far its edge or seam may be from the true one
    std::vector<Bezier<2>> pieces;
    Vec2 lo = Vec2::Constant(HUGE_VAL), hi = -lo;  ///< of all control points

    Vec2 first_point() const { return pieces.front().control(0); }
    Vec2 last_point() const { return pieces.back().control(pieces.back().points.size() - 1); }
    double begin() const { return pieces.front().begin; }
    double end() const { return pieces.back().end; }
};

struct Patch {
    std::size_t face, index;
    const RationalPatch* surface;
    double control_size;  ///< largest coordinate of a control point, or of the scene
    std::vector<std::vector<Trim>> loops;
    Vec2 lo, hi;            ///< of the trimmed region, in (u, v)
    Vec2 foot_lo, foot_hi;  ///< plane base: of its feet, in the chart
    mutable std::optional<RationalPatch> known_part = std::nullopt;

    /// Parts of coordinates (u, v) that rounding may change.
    Vec2 parameter_rounding() const { return 0x1p-48 * lo.cwiseAbs().cwiseMax(hi.cwiseAbs()); }
    /// The surface over the rectangle lo, hi; made when first asked for.
    const RationalPatch& part() const;
};

/// The same surface over lo, hi of its domain.
RationalPatch part_of(const RationalPatch& surface, const Vec2& lo, const Vec2& hi);

inline SurfacePoint lift(const Patch& patch, const Vec2& uv) {
    return evaluate(*patch.surface, uv.x(), uv.y());
}

/// Rounding of a surface point: that of its control points, and of (u, v) times the slopes.
inline double surface_rounding(const Patch& patch, const SurfacePoint& s, const Vec2& uv) {
    return kRounding * (patch.control_size + s.pu.norm() * std::abs(uv.x()) + s.pv.norm() * std::abs(uv.y()));
}

/// How far u and v move at most per length on the surface; infinite where that is a point or a curve there,
/// as patches are that are as small as the spacing of doubles.
inline Vec2 parameters_per_length(const SurfacePoint& s) {
    const double area = s.pu.cross(s.pv).norm();
    return area > 0 ? Vec2(Vec2(s.pv.norm(), s.pu.norm()) / area) : Vec2::Constant(HUGE_VAL);
}

/// Is uv inside the loops? None: too near to them, where the edges' own errors decide. `rounding`: a length.
std::optional<bool> inside(const Patch& patch, const Vec2& uv, double rounding);

/// Do the loops wind around uv as they are written, whatever their errors? A hole may be narrower than these.
/// None: uv is on a trim, or between two that should join, as far as doubles tell.
std::optional<bool> is_wound_around(const Patch& patch, const Vec2& uv);

/// All (u, v) of the rectangle of the patch's loops whose surface points are on a ray, and perhaps some
/// beside the rectangle. None: the ray touches the surface, runs along it, or starts on it, as far as doubles
/// tell.
std::optional<std::vector<Vec2>> parameters(const Patch& patch, const Ray& ray,
                                            const SceneGeometry& geometry);

}  // namespace vcell::check
