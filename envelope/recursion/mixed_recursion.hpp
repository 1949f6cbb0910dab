/// The recursion where others than circular forms compete. The region is split until pieces are plain
/// (../proofs/mixed_piece.hpp); what is lowest along a side is found once, when the side is made, so that the
/// pieces beside a seam cannot disagree. Pieces in which circular forms compete alone are left to exact
/// merging.
///
/// Down to blocks the pieces of one generation are split side by side, and blocks are solved on any thread.
/// They leave what the patchwork is to take and to glue, in the order in which one thread would have done so.
/// Which blocks there are depends on the forms alone, and none knows of another but for what all of them may
/// cost: a block that would have been given up, had it known what those before it cost, is solved again. So
/// the diagram is the same for any number of threads, and so is what is thrown.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "../../core/threads.hpp"
#include "../../core/worker_pool.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../diagram/patchwork.hpp"
#include "../proofs/competition.hpp"
#include "../proofs/side_labelling.hpp"
#include "circular_recursion.hpp"
#include "pieces.hpp"

namespace vcell {

class MixedRecursion {
public:
    /// Everything must outlive this object. Pieces with more than `most_competitors` are not plain: looking
    /// closer is a waste. Pre: `root` is the region.
    MixedRecursion(const FormFamily& family, const EnvelopeOptions& options, const Rectangle& root,
                   std::size_t most_competitors, SharedProgress& progress, CircularRecursion& circular,
                   Patchwork& patchwork);
    MixedRecursion(const MixedRecursion&) = delete;
    MixedRecursion& operator=(const MixedRecursion&) = delete;
    ~MixedRecursion();

    /// Finds what is lowest along the sides of a piece of the region. Throws TieError.
    LabelledPiece label(const RegionPiece& piece);
    /// Adds the diagram of all forms over a piece to the patchwork; returns its handle there. Of all the work
    /// this is `share`. Throws TieError.
    Patchwork::Index solve(LabelledPiece piece, double share);

    const Heights& heights();
    /// So far.
    Decisions decisions() const;
    std::vector<Assumption>& assumptions() { return assumptions_; }
    std::size_t pieces() const { return pieces_; }
    /// Triples of forms that were found to tie all along a curve.
    std::vector<CommonCurves::Triple> common_curves() const;

private:
    struct Effort {
        std::size_t splits = 0, small_pieces = 0;
        SideEffort sides{};

        Effort operator+(const Effort& o) const {
            return {splits + o.splits, small_pieces + o.small_pieces, sides + o.sides};
        }
        bool is_too_much(std::size_t forms) const;
        friend bool operator==(const Effort&, const Effort&) = default;
    };
    struct Circular;
    struct Seam;
    struct Steps;
    struct Node;
    struct Block;
    struct Solved;
    class Solver;

    std::deque<Node> split(LabelledPiece piece, double share);
    static void collect(std::deque<Node>& nodes, std::uint32_t node, std::vector<Block>& blocks);
    Solved solved(const Node& node, const Effort& before);
    Steps settled(const Node& node, Solved solved);
    void take(Steps steps, std::vector<Patchwork::Index>& handles);
    void assume(std::vector<Assumption> assumptions);

    const FormFamily& family_;
    const EnvelopeOptions& options_;
    const Rectangle root_;
    const std::size_t most_competitors_;
    SharedProgress& progress_;
    CircularRecursion& circular_;
    Patchwork& patchwork_;
    const PieceCutter cutter_;
    WorkerPool<Solver> solvers_;
    std::vector<Assumption> assumptions_;
    Effort spent_;
    std::size_t pieces_ = 0;
};

}  // namespace vcell
