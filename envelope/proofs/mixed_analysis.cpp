#include "mixed_analysis.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/errors.hpp"
#include "piece_culling.hpp"
#include "plain_join.hpp"
#include "saddle_join.hpp"
#include "tie_join.hpp"
#include "touch_join.hpp"

namespace vcell {

std::optional<MixedPiece> MixedAnalysis::resolve(const PieceBoundary& boundary) {
    PieceWork work{{boundary},     rivals_.normals(), rivals_.normals() ? all_.supports() : nullptr,
                   all_.heights(), all_.rule(),       all_.decisions(),
                   parts_,         rivals_.spreads()};
    double x0 = infinity, x1 = -infinity, y0 = infinity, y1 = -infinity;
    for (const IntervalPoint& c : boundary.corners) {
        x0 = std::min(x0, c[0].lower());
        x1 = std::max(x1, c[0].upper());
        y0 = std::min(y0, c[1].lower());
        y1 = std::max(y1, c[1].upper());
    }
    work.piece.box = {x0, x1, y0, y1};
    work.width = std::max(x1 - x0, y1 - y0);
    work.extent = all_.extent_at({x0, x1}, {y0, y1});
    work.is_small = std::min(x1 - x0, y1 - y0) <= tie_width * work.extent;

    set_rim(work);

    const bool at_floor = work.width <= floor_width * work.extent;
    bool plain = is_plain(work);
    const bool is_small = work.width <= tie_width * all_.tie_extent_at({x0, x1}, {y0, y1});
    if (!plain && is_small && leave_out_between(work)) plain = PlainJoin(all_, work).is_plain();
    remaining_ = work.forms();
    const bool near_tie = !plain && work.rivals.size() > 1 && is_small;
    if (!plain && !near_tie && !at_floor) return std::nullopt;
    ++all_.decisions().by_interval;

    std::vector<Assumption>& assumptions = all_.assumptions();
    const std::size_t assumed_before = assumptions.size();
    const bool joined = (plain && PlainJoin(all_, work).join()) || (near_tie && join_small(work));
    if (!joined) {
        // What was assumed on the way will be asked again.
        all_.decisions().assumed -= assumptions.size() - assumed_before;
        assumptions.erase(assumptions.begin() + static_cast<std::ptrdiff_t>(assumed_before),
                          assumptions.end());
        if (!at_floor) return std::nullopt;
        join_at_center(work);
    }
    return std::move(work.piece);
}

// The rim of the piece, with the changes of label along it.
void MixedAnalysis::set_rim(PieceWork& work) {
    MixedPiece& piece = work.piece;
    const std::size_t sides = work.boundary.sides.size();
    std::size_t rim = sides;
    for (const SideLabels& l : work.boundary.labels) rim += l.transitions.size();
    piece.vertices.reserve(rim + 1);
    piece.leaving.reserve(rim + 1);
    piece.rim.reserve(rim);
    work.changes.reserve(rim);
    const auto add_rim = [&](const Vector2d& p, double error, FormId before, FormId after,
                             std::span<const FormId> ties) {
        const auto v = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back({p, error, after, {ties.begin(), ties.end()}});
        if (ties.size() > (before == after ? 1 : 2)) work.knots.push_back(v);
        if (before != after) work.changes.push_back({v, before, after});
    };
    for (std::size_t i = 0; i < sides; ++i) {
        const SideLabels& labels = work.boundary.labels[i];
        const IntervalPoint& c = work.boundary.corners[i];
        const FormId before = work.boundary.labels[(i + sides - 1) % sides].last();
        if (before != labels.first && work.boundary.corner_ties[i].size() < 2)
            throw InternalError("labels differ around a corner of a piece");
        add_rim({c[0].mid(), c[1].mid()}, reach(c[0], c[1]), before, labels.first,
                work.boundary.corner_ties[i]);
        piece.rim.push_back({work.boundary.sides[i].id, labels.first});
        for (const RimTransition& t : labels.transitions) {
            add_rim(t.point, t.error, t.before, t.after, t.ties);
            piece.rim.push_back({work.boundary.sides[i].id, t.after});
        }
    }
    piece.leaving.resize(piece.vertices.size());
}

// Leaves those that show nowhere in the piece out, by what is cheap first.
bool MixedAnalysis::is_plain(PieceWork& work) {
    PieceCulling culling(all_, work);
    const PlainJoin join(all_, work);
    culling.from_rim();
    // Most triples of more than three meet where others are lower: that takes second derivatives to know.
    const bool is_crowded = !work.normals && work.rivals.size() > 3;
    bool plain = !is_crowded && join.is_plain();
    if (!plain) {
        // The difference of a circular form and one other is in mean value form already.
        const auto has_root = [&](const Spread& s) { return !all_.heights().family().is_circular(s.form); };
        const bool bends = !work.normals || std::ranges::count_if(work.rivals, has_root) > 1;
        if (bends) {
            rivals_.bend(work.piece.box);
            work.directions.clear();
            culling.by_curvature();
            culling.from_rim();
        }
        if (work.width < sharp_width * work.extent) culling.sharply();
        plain = bends && join.is_plain();
    }
    return plain;
}

// This leaves out what shows nowhere in the piece but where it ties with two others. What ties on the rim is
// left for that vertex.
bool MixedAnalysis::leave_out_between(PieceWork& work) {
    const std::size_t before = work.rivals.size();
    if (before < 3 || !work.knots.empty()) return false;
    const auto& box = work.piece.box;
    const std::vector<FormId> forms = work.forms(),
                              hidden = all_.common_curves().hidden(forms, {box[0], box[1]}, {box[2], box[3]});
    std::erase_if(work.rivals, [&](const Spread& s) {
        return !work.is_on_rim(s.form) && std::ranges::find(hidden, s.form) != hidden.end();
    });
    all_.decisions().by_interval += before - work.rivals.size();
    if (work.rivals.size() == before) return false;
    work.directions.clear();
    work.is_divided = false;
    return true;
}

bool MixedAnalysis::join_small(PieceWork& work) {
    SaddleJoin saddle(all_, work);
    return TieJoin(all_, work).join() || saddle.join_at_saddle() || saddle.join_at_pinch() ||
           TouchJoin(all_, work).join();
}

// What is left of a piece counts as a point: a vertex of the rim in which all rivals meet is that point.
// Where it reaches into a cylinder's trace on the base, heights have no bound, and nothing speaks for that.
void MixedAnalysis::join_at_center(PieceWork& work) {
    const auto& [x0, x1, y0, y1] = work.piece.box;
    for (const Spread& s : work.rivals)
        if (!std::isfinite(all_.heights().value(s.form, Interval(x0, x1), Interval(y0, y1)).width()))
            throw TieError({work.middle(), work.width, work.forms()});
    work.clear_inside();
    all_.assume(work.middle(), work.width, work.forms());
    if (work.changes.empty()) return;
    const auto knot = std::ranges::find_if(work.knots, [&](std::uint32_t v) { return work.all_tie_in(v); });
    if (knot != work.knots.end())
        work.join_all_on_rim(*knot);
    else if (work.matched_pair() && work.rivals.size() == 2)
        work.join(work.changes[0], work.changes[1]);
    else
        work.join_all_to({work.middle(), Interval::up(std::hypot(work.width, work.width)),
                          work.changes[0].before, work.forms()});
}

}  // namespace vcell
