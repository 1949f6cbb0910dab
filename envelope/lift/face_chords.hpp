/// What is known of a face's boundary around a cylinder before its curves are fitted to its patches:
/// vertices, the points where pieces of the diagram's arcs end, and rims; or points of curves that were
/// fitted to other patches. Trims pass through these, so that patches which do not hold them hold no face.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "../../primitives/fit/arc_equations.hpp"
#include "based_diagram.hpp"
#include "face_cut.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"

namespace vcell::radial {

class FaceChords {
public:
    /// Everything must outlive this object. Pre: the base is a cylinder.
    FaceChords(const RadialDiagram& of, const FaceLoops& loops, const FacePatches& patches,
               const RadialCurves& curves, FaceId face);

    /// Which of the face's parts have a patch with a weight that is not positive where these points lie; one
    /// flag if it is not cut. Where points are too far from each other to tell how seams divide the face,
    /// and in narrow sectors, nothing is said: the trims will tell.
    std::vector<bool> too_wide() const;

    /// The points around each loop, in space.
    const std::vector<std::vector<Vec3>>& points() const { return points_; }

private:
    using Runs = std::vector<std::vector<BoundaryRun>>;

    void add_edge(EdgeId e, bool reversed, const RadialCurves& curves, std::vector<Vec3>& loop) const;
    /// Above a point of the chart, or next to the axis at this height in the direction of a unit normal.
    Vec3 lifted(const Vec3& foot, const Vec3& normal) const;
    std::optional<Runs> runs() const;
    bool holds(const RadialPatch& patch, const std::vector<TrimCurve>& loop) const;

    const RadialDiagram of_;
    const FacePatches& patches_;
    const FaceId face_;
    const space_fit::Equation site_;  // of the face's form
    std::vector<std::vector<Vec3>> points_;
};

}  // namespace vcell::radial
