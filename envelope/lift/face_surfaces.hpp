/// The faces over a sphere or a cylinder base as trimmed patches. Whether a patch holds its face is known
/// from the trims, and splines' trims are fitted to the patches: where a patch does not, the face gets
/// another one, and its splines are fitted again.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "based_diagram.hpp"
#include "edge_fits.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"
#include "face_trims.hpp"
#include "radial_curves.hpp"
#include "trim_bounds.hpp"

namespace vcell::radial {

class FaceSurfaces {
public:
    FaceSurfaces(const RadialDiagram& of, FaceLoops& loops, FacePatches& patches, RadialCurves& curves,
                 EdgeFits& fits, unsigned threads);

    /// Fits the curves that depend on patches, and makes all surfaces. Throws UndecidedError, with sites and
    /// place, where a curve is not proved to be the edge or no patches hold a face.
    void make();

    /// The patches that make() has made.
    std::vector<TrimmedPatch>& of(FaceId face) { return surfaces_[face]; }
    /// A bound on how far rounded control points move the patches beside an edge.
    double rounding(EdgeId e) const { return std::max(roundings_[e][0], roundings_[e][1]); }

private:
    // What became of a face in parts.
    struct Cut {
        std::vector<bool> is_too_wide;  // of each part
        int failures = 0;
    };

    TrimmedPatch& whole(FaceId face);
    std::vector<FaceId> made(const std::vector<FaceId>& faces);
    void suit_patches(FaceId face);
    void change_patch(FaceId face);
    [[noreturn]] void throw_undecided(FaceId face) const;
    bool make_whole(FaceId face, std::vector<EdgeId>& bent);
    bool make_cut(FaceId face);
    std::optional<std::vector<CutPart>> cut_parts(FaceId face);
    void match_seams(FaceId face, std::vector<CutPart>& parts, std::uint32_t first_seam) const;
    Rectangle bounds(FaceId face, std::vector<EdgeId>& bent);
    void extend_by_trim(Rectangle& box, const RadialPatch& patch, const TrimCurve& trim,
                        std::vector<EdgeId>& bent) const;
    bool holds_vertices(FaceId face) const;
    bool is_good(FaceId face, const std::optional<RationalPatch>& surface) const;
    bool lacks_digits(FaceId face) const;
    double enough_digits() const { return fits_.tolerance() / 16; }
    void forget_roundings(FaceId face);
    double note_roundings(FaceId face, const RadialPatch& patch, const Rectangle& box,
                          const std::vector<std::vector<TrimCurve>>& loops, double of_patch);
    void halve_for_trims();

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    FaceLoops& loops_;
    FacePatches& patches_;
    RadialCurves& curves_;
    EdgeFits& fits_;
    const unsigned threads_;
    const FaceTrims trims_;
    IdVector<FaceId, std::vector<TrimmedPatch>> surfaces_;
    IdVector<EdgeId, std::array<double, 2>> roundings_;  // of both faces' control points, beside the edge
    std::map<FaceId, Cut> cuts_;                         // of faces whose patches were not kept
    std::vector<EdgeId> bent_;                           // conics that halve_for_trims() halves
    std::uint32_t seams_ = 0;
};

}  // namespace vcell::radial
