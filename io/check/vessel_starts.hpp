/// Where the integrals of a vessel's face around a ball start.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "frame.hpp"

namespace vcell::check {

/// The bisector with a vessel is closed, and great circles from a start sum up to a face that does not have
/// what is opposite to it. Those from a start whose opposite is far from the face's edges are the tamest.
/// None: no such start is found.
/// `points`: of its edges, in the frame. distance(u): of the bisector from the ball's centre in a direction.
std::optional<Triad<MidRad>> start_in_vessel(const Scene& scene, const Frame& frame, const Site& site,
                                             std::span<const Triad<double>> points,
                                             const std::function<MidRad(const Vec3& u)>& distance);

}  // namespace vcell::check
