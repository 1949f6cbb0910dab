#include "mixed_recursion.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "../../core/errors.hpp"
#include "../../core/sort_unique.hpp"
#include "../proofs/mixed_analysis.hpp"

namespace vcell {

namespace {

// More that tie in a point are seen to where pieces are so small that nothing else is left in them.
constexpr std::size_t most_tied = 8;
// A tube's circumference is cut into such parts of it as long as there are more competitors than this.
constexpr std::size_t most_around = 8;
constexpr double part_around = 0.15;
// Where differences of three competitors or more change so much more along one axis pieces are cut across
// that, unless they are too slender.
constexpr double much_steeper = 4, most_slender = 0x1p16;
// Nor are they cut lengthwise when they are no more than so many of the least stretches of a side wide: what
// meets a shorter seam across them could not be told apart by halving it.
constexpr double least_stretches = 64;
// A vertex needs some hundred pieces below this part of the region at worst, and a form has two vertices on
// average. Many more of them in all, or within one piece of that size, follow a curve along which forms tie
// without crossing: no number of pieces decides that.
constexpr double small_part = 0x1p-16;
constexpr std::size_t most_small_pieces_in_place = 5000, small_pieces_of_form = 200;
// Pieces of any size are split fewer than 50 times to a form usually, 200 times where few forms have much to
// do with each other, 80,000 times in all along a line that hardly leaves a plane; forms that all but
// coincide want it as often as the square of the region's size over their distance.
constexpr std::size_t most_splits = 80000, splits_of_form = 250;
// A piece that is not plain after so many halvings of the region is a block. Threads look at larger ones
// where so many are there at a time.
constexpr unsigned generations = 5;
constexpr std::size_t worth_threads = 4;

struct LabelledHalves {
    LabelledPiece first, second;
};

std::vector<FormId> all_forms(const FormFamily& family) {
    std::vector<FormId> all(family.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = FormId{i};
    return all;
}

Assumption all_of(const Rectangle& r, std::vector<FormId> forms) {
    std::ranges::sort(forms);
    return {{0.5 * r.x0 + 0.5 * r.x1, 0.5 * r.y0 + 0.5 * r.y1}, extent(r), std::move(forms)};
}

}  // namespace

// ---- What the patchwork is to do ---------------------------------------------------------------------

// A piece in which these compete alone.
struct MixedRecursion::Circular {
    RegionPiece piece;
    std::vector<FormId> forms;
    double share;
};
// Between the last two pieces that were taken or glued.
struct MixedRecursion::Seam {
    std::uint32_t id;
};
struct MixedRecursion::Steps {
    std::deque<std::variant<MixedPiece, Circular, Seam>> all{};
    std::vector<Assumption> assumptions{};
};

// ---- One thread --------------------------------------------------------------------------------------

class MixedRecursion::Solver {
public:
    explicit Solver(const MixedRecursion& all)
        : all_(all), competition_(all.family_, extent(all.root_), all.options_) {}

    const Competition& competition() const { return competition_; }
    Decisions decisions() const { return competition_.decisions(); }

    LabelledPiece label(const RegionPiece& piece, const Effort& before, Steps& steps) {
        begin(before);
        const Rectangle& r = piece.rect;
        const std::vector<FormId> candidates =
            analysis_->rivals().cull({r.x0, r.x1, r.y0, r.y1}, all_forms(all_.family_));
        const std::size_t n = piece.sides.size();
        LabelledPiece out{piece, {}, {}};
        std::vector<FormId> first(n), last(n);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t previous = (i + n - 1) % n;
            std::vector<FormId> ties =
                analysis_->sides().lowest_at(piece.sides[previous], piece.sides[i], candidates);
            first[i] = last[previous] = ties.front();
            if (ties.size() == 1) {
                ties.clear();
            } else {
                first[i] = analysis_->sides().label_beside(piece.sides[i], piece.corners[i],
                                                           piece.corners[(i + 1) % n], ties);
                last[previous] = analysis_->sides().label_beside(piece.sides[previous], piece.corners[i],
                                                                 piece.corners[previous], ties);
            }
            out.corner_ties.push_back(std::move(ties));
        }
        for (std::size_t i = 0; i < n; ++i) {
            auto labels = analysis_->sides().label_side(piece.sides[i], piece.corners[i],
                                                        piece.corners[(i + 1) % n], first[i], last[i],
                                                        candidates, Patchwork::is_seam(piece.sides[i].id));
            if (!labels) throw TieError(analysis_->sides().obstacle().value_or(all_of(r, candidates)));
            out.labels.push_back(*std::move(labels));
        }
        end(steps);
        return out;
    }

    // Looks at one piece: halves, or the only step. The candidates, which may be lowest in it, get fewer.
    std::optional<LabelledHalves> look_at(const LabelledPiece& part, std::vector<FormId>& candidates,
                                          unsigned depth, double share, const Effort& before, Steps& steps) {
        begin(before);
        auto halves = halves_of(part, candidates, depth, share, steps);
        end(steps);
        return halves;
    }
    void solve(const LabelledPiece& part, std::vector<FormId> candidates, unsigned depth, double share,
               const Effort& before, Steps& steps) {
        begin(before);
        solve_all(part, std::move(candidates), depth, share, steps);
        end(steps);
    }

    // On the last of these.
    Effort effort() { return {splits_, small_pieces_, analysis_->sides().effort()}; }

private:
    // What is found in a part of the region is a matter of this part alone. `before` it so much was spent.
    void begin(const Effort& before) {
        analysis_.emplace(competition_, before.sides);
        competition_.assumptions().clear();
        before_ = before;
        splits_ = small_pieces_ = small_pieces_in_place_ = 0;
    }
    void end(Steps& steps) { steps.assumptions = std::exchange(competition_.assumptions(), {}); }

    std::vector<FormId> without_floor(std::vector<FormId> forms) const {
        const std::vector<FormId>& floor = all_.options_.floor;
        std::erase_if(forms, [&](FormId f) { return std::ranges::find(floor, f) != floor.end(); });
        return forms;
    }

    void solve_all(const LabelledPiece& part, std::vector<FormId> candidates, unsigned depth, double share,
                   Steps& steps) {
        const auto halves = halves_of(part, candidates, depth, share, steps);
        if (!halves) return;
        solve_all(halves->first, candidates, depth + 1, 0.5 * share, steps);
        solve_all(halves->second, std::move(candidates), depth + 1, 0.5 * share, steps);
        steps.all.emplace_back(Seam{Patchwork::seam_at(depth)});
    }

    std::optional<LabelledHalves> halves_of(const LabelledPiece& part, std::vector<FormId>& candidates,
                                            unsigned depth, double share, Steps& steps) {
        const FormFamily& family = all_.family_;
        const Rectangle& r = part.piece.rect;
        candidates = analysis_->rivals().cull({r.x0, r.x1, r.y0, r.y1}, candidates);
        if (std::ranges::all_of(candidates, [&](FormId f) { return family.is_circular(f); }))
            // The floor alone has nothing to merge: a piece of it stays one of those that follow.
            if (std::vector<FormId> others = without_floor(candidates); !others.empty()) {
                steps.all.emplace_back(Circular{part.piece, std::move(others), share});
                return std::nullopt;
            }
        const double size = extent(r) / competition_.extent_at({r.x0, r.x1}, {r.y0, r.y1});
        const bool at_floor = size <= floor_width,
                   is_small = extent(r) <= tie_width * competition_.tie_extent_at({r.x0, r.x1}, {r.y0, r.y1});
        if (candidates.size() <= all_.most_competitors_ || (is_small && candidates.size() <= most_tied) ||
            size <= node_width) {
            if (auto resolved = analysis_->resolve(
                    {part.piece.sides, part.piece.corners, part.labels, part.corner_ties})) {
                all_.progress_.add(share);
                steps.all.emplace_back(*std::move(resolved));
                return std::nullopt;
            }
            candidates = analysis_->remaining();
        }
        if (size >= small_part) {
            small_pieces_in_place_ = 0;  // those of the places before are done
        } else {
            ++small_pieces_;
            ++small_pieces_in_place_;
        }
        splits_ += competition_.heights().cost();
        if (at_floor || (before_ + effort()).is_too_much(family.size()) ||
            small_pieces_in_place_ > most_small_pieces_in_place)
            throw TieError(all_of(r, candidates));
        auto halves = split(part, candidates, Patchwork::seam_at(depth));
        if (!halves) throw TieError(analysis_->sides().obstacle().value_or(all_of(r, candidates)));
        return halves;
    }

    // Which way to cut other than across the longer side. Beside a tip no one metric suits all differences,
    // and where they change along one axis only, as between tubes along a tube, pieces are to be as long as
    // these. Seen from half of a tube's circumference no object is nearest all around: none is culled.
    std::optional<bool> cut_upright(const Rectangle& r, std::size_t candidates) const {
        if (candidates > most_around && r.x1 - r.x0 > part_around * all_.family_.chart.circumference())
            return true;
        // No one metric suits tubes that are all but parallel to the base.
        constexpr double strip_part = 0x1p-4;
        if (all_.family_.chart.is_cylinder() && extent(r) < strip_part * extent(all_.root_))
            if (const auto upright = analysis_->rivals().asks_for_strips({r.x0, r.x1, r.y0, r.y1}))
                return upright;
        const auto steepness = analysis_->rivals().steepness_across(r.x1 - r.x0, r.y1 - r.y0);
        if (!steepness) return std::nullopt;
        if (all_.family_.tips.any()) return *steepness >= 1;
        const double x = r.x1 - r.x0, y = r.y1 - r.y0;
        if (candidates < 3 || std::max(x, y) > most_slender * std::min(x, y)) return std::nullopt;
        if (std::min(x, y) <=
            least_stretches * side_floor_width * competition_.extent_at({r.x0, r.x1}, {r.y0, r.y1}))
            return std::nullopt;
        if (*steepness >= much_steeper) return true;
        if (*steepness * much_steeper <= 1) return false;
        return std::nullopt;
    }

    std::optional<LabelledHalves> split(const LabelledPiece& part, const std::vector<FormId>& candidates,
                                        std::uint32_t seam) {
        const auto upright = cut_upright(part.piece.rect, candidates.size());
        for (const double shift : {0.0, 0.03, -0.03, 0.07, -0.07, 0.11, -0.11, 0.17, -0.17}) {
            const auto cut = all_.cutter_.cut_at(part.piece, shift, upright);
            if (!cut) continue;
            auto halves = PieceCutter::labelled_halves(part, *cut);
            if (!halves) continue;
            auto& [first, second, in_first, in_second, at_leaving, at_returning] = *halves;
            first.piece.sides[in_first].id = second.piece.sides[in_second].id = seam;
            auto labels = analysis_->sides().label_side(
                first.piece.sides[in_first], first.piece.corners[in_first],
                first.piece.corners[(in_first + 1) % first.piece.corners.size()], at_leaving, at_returning,
                candidates, true);
            if (!labels) continue;
            second.labels[in_second] = labels->reversed();
            first.labels[in_first] = *std::move(labels);
            // The first piece is to lie left of the upright seam; a level one is turned by a right angle.
            if (!cut->upright) std::swap(first, second);
            return LabelledHalves{std::move(first), std::move(second)};
        }
        return std::nullopt;
    }

    const MixedRecursion& all_;
    Competition competition_;
    std::optional<MixedAnalysis> analysis_;
    Effort before_;
    std::size_t splits_ = 0, small_pieces_ = 0, small_pieces_in_place_ = 0;
};

// ---- All threads -------------------------------------------------------------------------------------

// A piece of the region in the tree of those that have been halved.
struct MixedRecursion::Node {
    LabelledPiece piece;
    std::vector<FormId> candidates;  // once they are culled; before, of its parent
    double share;
    unsigned depth = 0;
    bool is_open = true;  // neither solved nor halved
    Steps steps{};
    Effort effort{};
    std::optional<LabelledHalves> halves{};
    std::uint32_t first = none;  // of its halves; the other one follows

    static constexpr std::uint32_t none = UINT32_MAX;
};
// A piece that is solved as a whole, or is; then the seams that end with it are glued, inner ones first.
struct MixedRecursion::Block {
    Node* node;
    std::vector<std::uint32_t> seams = {};
};

// What a block has left, or the tie for which it was given up.
struct MixedRecursion::Solved {
    Steps steps;
    Effort before{}, effort{};  // what others had cost by then, and the block itself
    std::optional<Assumption> tie{};
};

bool MixedRecursion::Effort::is_too_much(std::size_t forms) const {
    return splits > most_splits + splits_of_form * forms || small_pieces > small_pieces_of_form * forms ||
           sides.is_too_much(forms);
}

MixedRecursion::MixedRecursion(const FormFamily& family, const EnvelopeOptions& options,
                               const Rectangle& root, std::size_t most_competitors, SharedProgress& progress,
                               CircularRecursion& circular, Patchwork& patchwork)
    : family_(family),
      options_(options),
      root_(root),
      most_competitors_(most_competitors),
      progress_(progress),
      circular_(circular),
      patchwork_(patchwork),
      cutter_(family),
      solvers_([this] { return std::make_unique<Solver>(*this); }) {}
MixedRecursion::~MixedRecursion() = default;

const Heights& MixedRecursion::heights() {
    return solvers_.with_one([](Solver& s) -> const Heights& { return s.competition().heights(); });
}

Decisions MixedRecursion::decisions() const {
    Decisions sum;
    solvers_.for_each([&](const Solver& solver) { sum += solver.decisions(); });
    sum.assumed = assumptions_.size();
    return sum;
}

std::vector<CommonCurves::Triple> MixedRecursion::common_curves() const {
    std::vector<CommonCurves::Triple> all;
    solvers_.for_each([&](const Solver& solver) {
        for (const CommonCurves::Triple& three : solver.competition().common_curves().found())
            all.push_back(three);
    });
    sort_unique(all);
    return all;
}

LabelledPiece MixedRecursion::label(const RegionPiece& piece) {
    LabelledPiece labelled;
    Steps steps;
    solvers_.with_one([&](Solver& solver) {
        labelled = solver.label(piece, spent_, steps);
        spent_ = spent_ + solver.effort();
    });
    assume(std::move(steps.assumptions));
    return labelled;
}

Patchwork::Index MixedRecursion::solve(LabelledPiece piece, double share) {
    std::deque<Node> nodes = split(std::move(piece), share);
    for (Node& node : nodes) assume(std::move(node.steps.assumptions));
    std::vector<Block> blocks;
    collect(nodes, 0, blocks);

    const auto open = std::ranges::count_if(blocks, [](const Block& b) { return b.node->is_open; });
    const unsigned threads =
        static_cast<std::size_t>(open) >= worth_threads ? thread_count(options_.threads) : 1;
    const Effort before_all = spent_;
    const auto solve_block = [&](std::size_t i) {
        Node& node = *blocks[i].node;
        if (node.is_open) return solved(node, threads > 1 ? before_all : spent_);
        return Solved{std::move(node.steps)};
    };
    std::vector<Patchwork::Index> handles;  // of what is not glued yet
    const auto take_block = [&](std::size_t i, Solved block) {
        take(settled(*blocks[i].node, std::move(block)), handles);
        for (const std::uint32_t seam : blocks[i].seams) take({{{Seam{seam}}}}, handles);
        progress_.add(0);  // other threads' blocks, too, are told of
    };
    progress_.cancellable([&] { in_order(blocks.size(), threads, solve_block, take_block); });
    return handles.back();
}

MixedRecursion::Solved MixedRecursion::solved(const Node& node, const Effort& before) {
    Solved result{{}, before};
    solvers_.with_one([&](Solver& solver) {
        try {
            solver.solve(node.piece, node.candidates, node.depth, node.share, before, result.steps);
        } catch (const TieError& e) {
            result.tie = e.tie;
        }
        result.effort = solver.effort();
    });
    return result;
}

// What counts is what a block has come to after those before it.
MixedRecursion::Steps MixedRecursion::settled(const Node& node, Solved block) {
    if (block.before != spent_ && (spent_ + block.effort).is_too_much(family_.size()))
        block = solved(node, spent_);
    if (block.tie) throw TieError(*std::move(block.tie));
    spent_ = spent_ + block.effort;
    return std::move(block.steps);
}

// One generation after the other.
std::deque<MixedRecursion::Node> MixedRecursion::split(LabelledPiece piece, double share) {
    std::deque<Node> nodes;
    nodes.push_back({std::move(piece), all_forms(family_), share});
    for (std::size_t begin = 0; begin < nodes.size();) {
        const std::size_t end = nodes.size();
        if (nodes[begin].depth == generations) break;
        const bool are_many = end - begin >= worth_threads;
        progress_.cancellable([&] {
            for_all(end - begin, are_many ? thread_count(options_.threads) : 1, [&](std::size_t i) {
                Node& node = nodes[begin + i];
                solvers_.with_one([&](Solver& solver) {
                    node.halves = solver.look_at(node.piece, node.candidates, node.depth, node.share, spent_,
                                                 node.steps);
                    node.effort = solver.effort();
                });
                node.is_open = false;
            });
        });
        for (std::size_t i = begin; i < end; ++i) {
            spent_ = spent_ + nodes[i].effort;
            if (!nodes[i].halves) continue;
            auto [first, second] = *std::exchange(nodes[i].halves, {});
            nodes[i].first = static_cast<std::uint32_t>(nodes.size());
            const double half = 0.5 * nodes[i].share;
            const unsigned depth = nodes[i].depth + 1;
            nodes.push_back({std::move(first), nodes[i].candidates, half, depth});
            nodes.push_back({std::move(second), std::move(nodes[i].candidates), half, depth});
        }
        begin = end;
    }
    return nodes;
}

void MixedRecursion::collect(std::deque<Node>& nodes, std::uint32_t node, std::vector<Block>& blocks) {
    if (nodes[node].first == Node::none) {
        blocks.push_back({&nodes[node]});
        return;
    }
    collect(nodes, nodes[node].first, blocks);
    collect(nodes, nodes[node].first + 1, blocks);
    blocks.back().seams.push_back(Patchwork::seam_at(nodes[node].depth));
}

void MixedRecursion::take(Steps steps, std::vector<Patchwork::Index>& handles) {
    assume(std::move(steps.assumptions));
    for (const auto& step : steps.all) {
        if (const auto* piece = std::get_if<MixedPiece>(&step)) {
            handles.push_back(patchwork_.add(*piece));
            ++pieces_;
        } else if (const auto* circular = std::get_if<Circular>(&step)) {
            handles.push_back(circular_.solve(circular->piece, circular->forms, circular->share));
        } else {
            const Patchwork::Index second = handles.back();
            handles.pop_back();
            handles.back() = patchwork_.glue(handles.back(), second, std::get<Seam>(step).id);
        }
    }
}

void MixedRecursion::assume(std::vector<Assumption> assumptions) {
    for (Assumption& a : assumptions) add_assumption(std::move(a), assumptions_);
}

}  // namespace vcell
