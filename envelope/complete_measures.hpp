/// What is nearest to the base in all of the box.
///
/// A cell's faces stand over the base's region in the box. Where the base leaves the box its normals may
/// still come into it: a plane that leans, a tube that runs into a side obliquely, or a ball beyond the box
/// owns points of the box over base points outside. Measures of all of it need no face there. Let a ray start
/// beyond a side; what of it lies in the box is what lies in the box extended beyond that side, without what
/// lies in the extension alone:
///
///     box  =  (before + box)  -  before,       box  =  sum over S of (-1)^|S| room(S)
///
/// over the sets S of sides that the ray starts beyond, room(S) being what lies beyond the sides in S, on
/// both planes of the others of these, and inside all other sides: a box again, in which the ray starts. So
/// every term is the measure of an ordinary cell, decided and integrated as any other, and its bound counts
/// in full.
///
///   * A plane's rays are parallel, and over an axis along which they come in what lies before the box is
///   over
///     base points before it: eight cells at most, of the whole plane.
///   * A tube's rays start on its axis. Between the planes of the sides that it crosses S is the same for all
///     of them: fourteen cells at most towards either end. The rays keep a 2^-32th of the box's diagonal
///     clear of those planes, where distances vanish, and what that leaves out is part of the bound.
///   * A ball's rays start in its centre: eight cells at most.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "../primitives/objects/scene.hpp"

namespace vcell {

/// In the scene's unit of length.
struct CompleteMeasures {
    /// The region of the box that is nearer to the base than to any object has this volume, the base's own
    /// body included (over a plane: on the side of its normal).
    double volume = 0, volume_error = 0;
    /// That region's boundary without the sides of the box has this area.
    double area = 0, area_error = 0;
    /// The cap has this area, where the scene has a probe.
    double exposed_area = 0, exposed_error = 0;

    struct Neighbor {
        std::uint32_t object;
        double area, area_error;
    };
    /// Objects that share some of that boundary, by decreasing area.
    std::vector<Neighbor> neighbors;
    bool is_estimated = false;  ///< the errors, otherwise proven bounds; as in Measures
    /// Coincidences that were taken for granted (Decisions::assumed), in all terms together.
    std::uint64_t assumed = 0;
};

/// Throws as voronoi_cell() does; but the box need not contain any of the base. Objects must stay clear of
/// the base where it is outside the box, too, as far as its rays come into the box: where an object cuts it
/// there, InputError says so.
///
CompleteMeasures complete_measures(const Scene& scene);
/// These measure a ball's own body, where that is nearer to the ball than to any object: the region ends at
/// clearance 0.
/// Pre: the base is a sphere, not a point; no probe.
CompleteMeasures complete_body_measures(Scene scene);

}  // namespace vcell
