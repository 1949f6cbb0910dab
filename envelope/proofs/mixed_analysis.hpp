/// Decides pieces by enclosures (mixed_piece.hpp): which forms compete in one, the labels along its sides,
/// and the diagram of these where the piece is plain.
#pragma once

#include "box_rivals.hpp"
#include "side_labelling.hpp"

namespace vcell {

struct PieceWork;

class MixedAnalysis {
public:
    /// `before`: what sides labelled by others have cost.
    explicit MixedAnalysis(Competition& all, const SideEffort& before = {})
        : all_(all), rivals_(all), sides_(all, before) {}
    MixedAnalysis(const MixedAnalysis&) = delete;

    BoxRivals& rivals() { return rivals_; }
    const BoxRivals& rivals() const { return rivals_; }
    SideLabelling& sides() { return sides_; }

    /// The diagram of the forms that the last cull of rivals() left over the piece, if it is plain. Pre: that
    /// was about its box, and not asked before.
    std::optional<MixedPiece> resolve(const PieceBoundary& boundary);
    /// Those of them that may be lowest somewhere inside the piece, as resolve() came to know where it found
    /// no diagram.
    const std::vector<FormId>& remaining() const { return remaining_; }

private:
    static void set_rim(PieceWork& work);
    bool is_plain(PieceWork& work);
    bool leave_out_between(PieceWork& work);
    bool join_small(PieceWork& work);
    void join_at_center(PieceWork& work);

    Competition& all_;
    BoxRivals rivals_;
    SideLabelling sides_;
    std::vector<FormId> remaining_;
    std::optional<DividedBox> parts_;  // of the last piece that was divided
};

}  // namespace vcell
