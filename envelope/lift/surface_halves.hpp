/// A face of the bisector with a hollow sphere, over a sphere, that leaves others too little for one patch:
/// the bisector is an ellipsoid about the axis through both centres, and a plane across that divides it in
/// two, with a stereographic patch about each end of the axis. Seen from the base's centre the plane's
/// section is a circle about the axis.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "based_diagram.hpp"
#include "conic_span.hpp"
#include "face_loops.hpp"
#include "patch_coordinate.hpp"
#include "radial_curves.hpp"
#include "radial_patch.hpp"
#include "space_arc.hpp"

namespace vcell::radial {

/// The semiaxis along which an ellipsoid with a focus in 0 is one of revolution, by its middle and direction;
/// all three have one where it is a sphere, and this is any of them.
struct LongAxis {
    Vec3 center, pole;  ///< pole: a unit vector, away from the other focus
    double length;      ///< of the semiaxis
    /// The radius that the section through the middle has in the stereographic parameters about the pole.
    double reach;

    /// Pre: the form's object is a HollowSphere, the base a sphere.
    LongAxis(const RadialBaseProblem& problem, FormId form);

    /// How far before the middle a point is, as a part of the semiaxis: 1 at the pole.
    double height(const Vec3& p) const { return pole.dot(p - center) / length; }
    double height_towards(const Vec3& u) const;  ///< of the point that is met in the direction u from 0
};

class SurfaceHalves {
public:
    /// The plane keeps clear of the face's vertices, and of where edges turn back along the axis. attempt: so
    /// many planes are not wanted. Pre: is_there().
    SurfaceHalves(const RadialDiagram& of, const FaceLoops& loops, const RadialCurves& curves, FaceId face,
                  std::size_t attempt);

    /// The patch about the pole (0), and that about the opposite one.
    const RadialPatch& patch(std::uint32_t half) const { return patches_[half]; }
    /// Each with what is on its side of the plane.
    SpacePart part(std::uint32_t half) const;
    std::uint32_t half_of(const Vec3& p) const { return axis_.height(p) < height_ ? 1 : 0; }
    /// Appends a conic's span, divided where it crosses the plane.
    void add_divided(const ConicSpan& span, std::vector<ConicSpan>& spans) const;

    /// The section's radius in a half's parameters.
    double radius(std::uint32_t half) const {
        const double first = axis_.reach * std::sqrt((1 - height_) / (1 + height_));
        return half == 0 ? first : 1 / first;
    }
    /// Its point at an angle of the first half's parameters, in those of either.
    Vec2 at(double angle, std::uint32_t half) const;

private:
    std::optional<double> crossing(const ConicSpan& span) const;

    LongAxis axis_;
    double height_;
    std::array<RadialPatch, 2> patches_;
};

}  // namespace vcell::radial
