#include "circular_recursion.hpp"

#include <array>
#include <optional>
#include <utility>

#include "piece_merger.hpp"

namespace vcell {

namespace {

// Splitting on although the candidates hardly get fewer: this often in a row, then the piece is taken as it
// is.
constexpr int most_stalled_splits = 8;

// Fewer forms are not worth a patchwork of their own; more are some hundredths of a second.
constexpr std::size_t forms_of_block = 2048;

bool hardly_fewer(std::size_t kept, std::size_t inherited) { return 8 * kept > 7 * inherited; }

struct Halves {
    RegionPiece first, second;
    std::uint32_t seam;
};

std::optional<Halves> split(const RegionPiece& piece, const PieceCutter& cutter, Patchwork& patchwork) {
    for (const double shift : {0.0, 0.03, -0.03, 0.07, -0.07}) {
        const auto cut = cutter.cut_at(piece, shift);
        if (!cut) continue;
        const std::uint32_t seam = patchwork.new_seam();
        auto [first, second] = PieceCutter::halves(piece, *cut, seam);
        // The first piece is to lie left of the upright seam; a level one is turned by a right angle.
        if (!cut->upright) std::swap(first, second);
        return Halves{std::move(first), std::move(second), seam};
    }
    return std::nullopt;
}

constexpr std::array share_of_half{split_ratio, 1 - split_ratio};

}  // namespace

// The recursion on one thread, into one patchwork.
class CircularRecursion::Solver {
public:
    Solver(const CircularRecursion& all, Patchwork& patchwork)
        : all_(all), patchwork_(patchwork), merger_(all.family_, all.options_, all.culling_) {}

    const PieceMerger& merger() const { return merger_; }

    Patchwork::Index solve(const RegionPiece& piece, std::span<const FormId> inherited, double share,
                           int stalled) {
        std::vector<FormId> candidates;
        merger_.cull(piece.rect, inherited, [&](std::size_t i) { candidates.push_back(inherited[i]); });
        stalled = hardly_fewer(candidates.size(), inherited.size()) ? stalled + 1 : 0;
        return solve_culled(piece, candidates, share, stalled);
    }

    Patchwork::Index solve_culled(const RegionPiece& piece, std::vector<FormId>& candidates, double share,
                                  int stalled) {
        if (candidates.size() > all_.sizes_.most && stalled <= most_stalled_splits) {
            if (const auto halves = split(piece, all_.cutter_, patchwork_)) {
                const Patchwork::Index a =
                    solve(halves->first, candidates, share * share_of_half[0], stalled);
                const Patchwork::Index b =
                    solve(halves->second, candidates, share * share_of_half[1], stalled);
                return patchwork_.glue(a, b, halves->seam);
            }
        }
        const Patchwork::Index handle =
            patchwork_.add(merger_.merge(piece, candidates, all_.sizes_.quartering), piece.sides);
        all_.progress_.add(share);
        return handle;
    }

private:
    const CircularRecursion& all_;
    Patchwork& patchwork_;
    PieceMerger merger_;
};

// A block's own patchwork.
struct CircularRecursion::Solved {
    Patchwork patchwork;
    Patchwork::Index handle;
    Decisions decisions;
    EnvelopeWork effort;
};

CircularRecursion::CircularRecursion(const FormFamily& family, const EnvelopeOptions& options,
                                     PieceSizes sizes, SharedProgress& progress, Patchwork& patchwork)
    : family_(family),
      options_(options),
      sizes_(sizes),
      progress_(progress),
      patchwork_(patchwork),
      culling_(family),
      cutter_(family),
      here_(std::make_unique<Solver>(*this, patchwork)) {}
CircularRecursion::~CircularRecursion() = default;

Decisions CircularRecursion::decisions() const {
    Decisions sum = decisions_;
    sum += here_->merger().decisions();
    return sum;
}

EnvelopeWork CircularRecursion::effort() const {
    EnvelopeWork sum = effort_;
    sum += here_->merger().effort();
    return sum;
}

Patchwork::Index CircularRecursion::solve(const RegionPiece& piece, std::span<const FormId> candidates,
                                          double share) {
    if (candidates.size() <= forms_of_block) return here_->solve(piece, candidates, share, 0);
    std::vector<Node> nodes = halved(piece, candidates, share);
    std::vector<Block> blocks;
    collect(nodes, 0, blocks);

    const auto solve_block = [&](std::size_t i) {
        Node& node = nodes[blocks[i].node];
        std::vector<FormId> own = std::move(node.candidates);
        Solved solved{Patchwork(family_, own.size()), Patchwork::none, {}, {}};
        solved.patchwork.leave_seams_to(patchwork_);
        Solver solver(*this, solved.patchwork);
        solved.handle = solver.solve_culled(node.piece, own, node.share, node.stalled);
        solved.decisions = solver.merger().decisions();
        solved.effort = solver.merger().effort();
        return solved;
    };
    std::vector<Patchwork::Index> handles;  // of what is not glued yet
    const auto take_block = [&](std::size_t i, Solved solved) {
        handles.push_back(patchwork_.take(std::move(solved.patchwork), solved.handle));
        for (const std::uint32_t seam : blocks[i].seams) {
            const Patchwork::Index second = handles.back();
            handles.pop_back();
            handles.back() = patchwork_.glue(handles.back(), second, seam);
        }
        decisions_ += solved.decisions;
        effort_ += solved.effort;
        progress_.add(0);  // other threads' blocks, too, are told of
    };
    progress_.cancellable(
        [&] { in_order(blocks.size(), thread_count(options_.threads), solve_block, take_block); });
    return handles.back();
}

// One generation after the other: the pieces of one are culled side by side.
std::vector<CircularRecursion::Node> CircularRecursion::halved(const RegionPiece& piece,
                                                               std::span<const FormId> candidates,
                                                               double share) {
    const unsigned threads = thread_count(options_.threads);
    std::vector<Node> nodes{{piece, share}};
    for (std::size_t begin = 0; begin < nodes.size();) {
        const std::size_t end = nodes.size();
        progress_.cancellable([&] {
            for_all(end - begin, threads, [&](std::size_t i) {
                Node& node = nodes[begin + i];
                const std::span<const FormId> inherited =
                    node.parent == none ? candidates : nodes[node.parent].candidates;
                CircularCulling cull = culling_;
                cull(node.piece.rect, inherited,
                     [&](std::size_t k) { node.candidates.push_back(inherited[k]); });
                if (hardly_fewer(node.candidates.size(), inherited.size()))
                    ++node.stalled;
                else
                    node.stalled = 0;
                progress_.add(0);
            });
        });
        // What their parents kept has been culled for both halves.
        for (std::size_t i = begin; i < end; ++i)
            if (nodes[i].parent != none) nodes[nodes[i].parent].candidates = {};
        for (std::size_t i = begin; i < end; ++i) {
            if (nodes[i].candidates.size() <= forms_of_block || nodes[i].stalled > most_stalled_splits)
                continue;
            auto halves = split(nodes[i].piece, cutter_, patchwork_);
            if (!halves) continue;
            nodes[i].first = static_cast<std::uint32_t>(nodes.size());
            nodes[i].seam = halves->seam;
            const auto parent = static_cast<std::uint32_t>(i);
            nodes.push_back(
                {std::move(halves->first), nodes[i].share * share_of_half[0], nodes[i].stalled, parent});
            nodes.push_back(
                {std::move(halves->second), nodes[i].share * share_of_half[1], nodes[i].stalled, parent});
        }
        begin = end;
    }
    return nodes;
}

void CircularRecursion::collect(const std::vector<Node>& nodes, std::uint32_t node,
                                std::vector<Block>& blocks) {
    if (nodes[node].first == none) {
        blocks.push_back({node});
        return;
    }
    collect(nodes, nodes[node].first, blocks);
    collect(nodes, nodes[node].first + 1, blocks);
    blocks.back().seams.push_back(nodes[node].seam);
}

}  // namespace vcell
