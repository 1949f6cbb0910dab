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
constexpr std::size_t forms_of_block = 4096;
// So many are looked at one by one: what is left of groups' forms is many times fewer where their widths
// differ.
constexpr std::size_t most_one_by_one = 2 * forms_of_block;

// Candidates that are not for walking are asked about again where they are so many times fewer.
constexpr std::size_t walks_again = 4;

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
    Solver(const CircularRecursion& all, PieceMerger& merger, Patchwork& patchwork)
        : all_(all), patchwork_(patchwork), merger_(merger) {}

    // The items, candidates or groups of them, are those that may be lowest in the piece.
    Patchwork::Index solve(const RegionPiece& piece, CompetingForms::Culling& cull,
                           std::span<const Item> items, double share, int stalled,
                           std::size_t most_walked = SIZE_MAX) {
        const CompetingForms& forms = cull.forms();
        const std::size_t count = forms.count(items);
        std::vector<Item> candidates;
        const auto collect_candidates = [&] {
            for (const Item item : items)
                forms.for_forms(item, [&](Item form) { candidates.push_back(form); });
        };
        const auto add = [&](const WorkDiagram& diagram) {
            const Patchwork::Index handle = patchwork_.add(diagram, piece.sides);
            all_.progress_.add(share);
            return handle;
        };
        if (count > all_.sizes_.most && count <= most_walked &&
            all_.options_.largest_piece >= all_.sizes_.most) {
            collect_candidates();
            if (const auto* diagram = merger_.merge_by_walking(piece, forms, candidates))
                return add(*diagram);
            candidates.clear();
            most_walked = count / walks_again;
        }
        if (count > all_.sizes_.most && stalled <= most_stalled_splits) {
            if (const auto halves = split(piece, all_.cutter_, patchwork_)) {
                const Patchwork::Index a =
                    solve_culled(halves->first, cull, items, share * share_of_half[0], stalled, most_walked);
                const Patchwork::Index b =
                    solve_culled(halves->second, cull, items, share * share_of_half[1], stalled, most_walked);
                return patchwork_.glue(a, b, halves->seam);
            }
        }
        collect_candidates();
        return add(merger_.merge(piece, cull, candidates, all_.sizes_.quartering));
    }

    Patchwork::Index solve_culled(const RegionPiece& piece, CompetingForms::Culling& cull,
                                  std::span<const Item> inherited, double share, int stalled,
                                  std::size_t most_walked = SIZE_MAX) {
        std::vector<Item> items;
        stalled = all_.cull_items(cull, piece.rect, inherited, stalled, items);
        return solve(piece, cull, items, share, stalled, most_walked);
    }

private:
    const CircularRecursion& all_;
    Patchwork& patchwork_;
    PieceMerger& merger_;
};

// A block's own patchwork.
struct CircularRecursion::Solved {
    Patchwork patchwork;
    Patchwork::Index handle;
};

CircularRecursion::CircularRecursion(const FormFamily& family, const EnvelopeOptions& options,
                                     PieceSizes sizes, SharedProgress& progress, Patchwork& patchwork)
    : family_(family),
      options_(options),
      sizes_(sizes),
      progress_(progress),
      patchwork_(patchwork),
      cutter_(family),
      mergers_([this] { return std::make_unique<PieceMerger>(family_, options_); }) {}
CircularRecursion::~CircularRecursion() = default;

Decisions CircularRecursion::decisions() const {
    Decisions sum;
    mergers_.for_each([&](const PieceMerger& m) { sum += m.decisions(); });
    return sum;
}

EnvelopeWork CircularRecursion::effort() const {
    EnvelopeWork sum;
    mergers_.for_each([&](const PieceMerger& m) { sum += m.effort(); });
    return sum;
}

Patchwork::Index CircularRecursion::solve(const RegionPiece& piece, std::span<const FormId> candidates,
                                          double share) {
    const CompetingForms forms(family_, candidates);
    const std::vector<Item>& all = forms.all();
    if (candidates.size() <= forms_of_block) {
        return mergers_.with_one([&](PieceMerger& merger) {
            CompetingForms::Culling cull(forms);
            return Solver(*this, merger, patchwork_).solve_culled(piece, cull, all, share, 0);
        });
    }
    std::vector<Node> nodes = halved(piece, forms, all, share);
    std::vector<Block> blocks;
    collect(nodes, 0, blocks);

    const auto solve_block = [&](std::size_t i) {
        Node& node = nodes[blocks[i].node];
        const std::vector<Item> own = std::move(node.items);
        return mergers_.with_one([&](PieceMerger& merger) {
            Solved solved{Patchwork(family_, forms.count(own)), Patchwork::none};
            solved.patchwork.leave_seams_to(patchwork_);
            CompetingForms::Culling cull(forms);
            solved.handle = Solver(*this, merger, solved.patchwork)
                                .solve(node.piece, cull, own, node.share, node.stalled);
            return solved;
        });
    };
    std::vector<Patchwork::Index> handles;  // of what is not glued yet
    const auto take_block = [&](std::size_t i, Solved solved) {
        handles.push_back(patchwork_.take(std::move(solved.patchwork), solved.handle));
        for (const std::uint32_t seam : blocks[i].seams) {
            const Patchwork::Index second = handles.back();
            handles.pop_back();
            handles.back() = patchwork_.glue(handles.back(), second, seam);
        }
        progress_.add(0);  // other threads' blocks, too, are told of
    };
    progress_.cancellable(
        [&] { in_order(blocks.size(), thread_count(options_.threads), solve_block, take_block); });
    return handles.back();
}

int CircularRecursion::cull_items(CompetingForms::Culling& cull, const Rectangle& rect,
                                  std::span<const Item> inherited, int stalled,
                                  std::vector<Item>& items) const {
    const CompetingForms& forms = cull.forms();
    cull(rect, inherited, most_one_by_one, items);
    return hardly_fewer(forms.count(items), forms.count(inherited)) ? stalled + 1 : 0;
}

// One generation after the other: the pieces of one are culled side by side.
std::vector<CircularRecursion::Node> CircularRecursion::halved(const RegionPiece& piece,
                                                               const CompetingForms& forms,
                                                               std::span<const Item> all, double share) {
    const unsigned threads = thread_count(options_.threads);
    std::vector<Node> nodes{{piece, share}};
    for (std::size_t begin = 0; begin < nodes.size();) {
        const std::size_t end = nodes.size();
        progress_.cancellable([&] {
            for_all(end - begin, threads, [&](std::size_t i) {
                Node& node = nodes[begin + i];
                const std::span<const Item> inherited =
                    node.parent == none ? all : std::span<const Item>(nodes[node.parent].items);
                CompetingForms::Culling cull(forms);
                node.stalled = cull_items(cull, node.piece.rect, inherited, node.stalled, node.items);
                node.count = forms.count(node.items);
                progress_.add(0);
            });
        });
        // What their parents kept has been culled for both halves.
        for (std::size_t i = begin; i < end; ++i)
            if (nodes[i].parent != none) nodes[nodes[i].parent].items = {};
        for (std::size_t i = begin; i < end; ++i) {
            if (nodes[i].count <= forms_of_block || nodes[i].stalled > most_stalled_splits) continue;
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
