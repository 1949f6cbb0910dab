/// The trims of faces over a sphere or a cylinder base: the edges' curves in the parameters of patches.
#pragma once

#include <cstddef>
#include <vector>

#include "based_diagram.hpp"
#include "face_cut.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"
#include "radial_curves.hpp"

namespace vcell::radial {

class FaceTrims {
public:
    FaceTrims(const FaceLoops& loops, const FacePatches& patches, const RadialCurves& curves)
        : loops_(loops), patches_(patches), curves_(curves) {}

    /// The trims of a face that is not cut, in the order of its loops.
    std::vector<std::vector<TrimCurve>> loops(FaceId face) const;
    /// The loops of a face that is cut, as runs of spans within one part.
    std::vector<std::vector<BoundaryRun>> runs(FaceId face) const;
    /// With what the face has beside its tips: lines of the sectors' parameters that are one point of space
    /// each, along no edge and no seam.
    std::vector<std::vector<BoundaryRun>> all_runs(FaceId face) const;
    /// Makes the trim of an edge on a patch, in the direction of its loop.
    void set(const RadialPatch& patch, EdgeId e, bool reversed, RationalCurve2& curve) const;

private:
    std::uint32_t part_of(FaceId face, EdgeId e, bool reversed, std::size_t span) const;

    const FaceLoops& loops_;
    const FacePatches& patches_;
    const RadialCurves& curves_;
};

}  // namespace vcell::radial
