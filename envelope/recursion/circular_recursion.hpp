/// The recursion where circular forms compete alone. Up to some thousands of forms are inserted by walking,
/// where that does; otherwise the region is split until few compete in a piece. Pieces' diagrams are found by
/// a PieceMerger and glued along the seams again.
///
/// Where many compete the splitting goes on side by side, piece by piece of the same generation, down to
/// blocks of a few thousand forms. Each block is solved in a patchwork of its own, on any thread, and taken
/// over in order. Which blocks there are depends on the forms alone, and taken over they leave what one
/// patchwork would hold that had everything, so the diagram is the same for any number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "../../core/threads.hpp"
#include "../../core/worker_pool.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../diagram/patchwork.hpp"
#include "competing_forms.hpp"
#include "pieces.hpp"

namespace vcell {

/// How many forms pieces have, measured on random scenes (bench_envelope): smaller ones spend more on seams,
/// larger ones more on comparing faces with forms that lose there.
struct PieceSizes {
    std::size_t most;        ///< candidates that are merged without splitting further
    std::size_t quartering;  ///< more of them are culled in quarters before
};

class PieceMerger;

class CircularRecursion {
public:
    /// Everything must outlive this object. What pieces the patchwork gets come out of solve() alone.
    CircularRecursion(const FormFamily& family, const EnvelopeOptions& options, PieceSizes sizes,
                      SharedProgress& progress, Patchwork& patchwork);
    CircularRecursion(const CircularRecursion&) = delete;
    CircularRecursion& operator=(const CircularRecursion&) = delete;
    ~CircularRecursion();

    /// Adds the diagram of the candidates over a piece to the patchwork; returns its handle there. Of all the
    /// work this is `share`.
    Patchwork::Index solve(const RegionPiece& piece, std::span<const FormId> candidates, double share);

    /// So far. Of the effort insertions and merges.
    Decisions decisions() const;
    EnvelopeWork effort() const;

private:
    using Item = CompetingForms::Item;
    // A piece of the region in the tree of those that have been halved, and the forms that are not culled.
    struct Node {
        RegionPiece piece;
        double share;
        int stalled = 0;  // halvings in a row that hardly left out any form
        std::uint32_t parent = none;
        std::vector<Item> items = {};
        std::size_t count = 0;       // of forms in them
        std::uint32_t first = none;  // of its halves; the other one follows
        std::uint32_t seam = none;   // between them
    };
    static constexpr std::uint32_t none = UINT32_MAX;
    // A piece that is solved as a whole; then the seams that end with it are glued, inner ones first.
    struct Block {
        std::uint32_t node;
        std::vector<std::uint32_t> seams = {};
    };
    struct Solved;
    class Solver;

    // Which of the items, or parts of them, may be lowest in a piece. Returns how often in a row, this time
    // included, that hardly left out any form.
    int cull_items(CompetingForms::Culling& cull, const Rectangle& rect, std::span<const Item> inherited,
                   int stalled, std::vector<Item>& items) const;
    std::vector<Node> halved(const RegionPiece& piece, const CompetingForms& forms, std::span<const Item> all,
                             double share);
    static void collect(const std::vector<Node>& nodes, std::uint32_t node, std::vector<Block>& blocks);

    const FormFamily& family_;
    const EnvelopeOptions& options_;
    const PieceSizes sizes_;
    SharedProgress& progress_;
    Patchwork& patchwork_;
    const PieceCutter cutter_;
    WorkerPool<PieceMerger> mergers_;
};

}  // namespace vcell
