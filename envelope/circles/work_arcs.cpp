#include "work_arcs.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "../../arrangement/circles/curve_order.hpp"
#include "../../arrangement/circles/point_star.hpp"
#include "../../core/errors.hpp"
#include "cycle_locator.hpp"

namespace vcell {

void WorkArcs::divide_face(Duel& d) {
    if (!d.met && !merging_) {
        insert_island(d, Sign::Positive);
        return;
    }
    const Face& f = faces_[d.face];
    const FormPair rival = rivals(d.challenger, f.site);
    bool positive = false, negative = false, root = false;
    const std::size_t first_touched = touched_.size();
    for_boundary(f, [&](Index h) {
        touched_.push_back(h);
        const Sign s = edges_[h >> 1].sign;
        positive = positive || s == Sign::Positive;
        negative = negative || s == Sign::Negative;
        const Index v = half_edges_[h].origin;
        root = root || s == Sign::Zero || (v != none && vertices_[v].sign == Sign::Zero);
    });
    const std::size_t boundary_end = touched_.size();
    branches_.clear();
    if (root) {
        find_branches(f.outer, rival);
        for (const Index h : f.inner) find_branches(h, rival);
    }
    d.changed = negative || !branches_.empty();
    if (!positive && !negative)  // bounded by the trisector alone
        d.changed = winner(f.outer, d) == d.challenger;
    d.changed = d.changed || merging_;
    if (!d.changed) {
        touched_.resize(first_touched);
        return;
    }
    for (std::size_t i = first_touched; i < boundary_end; ++i)
        half_edges_[touched_[i]].label = winner(touched_[i], d);
    if (root) {
        insert_arcs(rival);
        thread_isolated(d.face, boundary_end);
    } else {
        insert_island(d, edges_[f.outer >> 1].sign);
    }
}

// Where the half-edge runs along the trisector.
FormId WorkArcs::winner_along(Index h, const Duel& d) {
    const FormId site = faces_[d.face].site;
    const FormPair c = directed(h), rival = rivals(d.challenger, site);
    const Index v = half_edges_[h].origin;
    const bool along = v == none ? kernel_.curvature_sign(c) == kernel_.curvature_sign(rival)
                                 : PointStar(kernel_, vertices_[v].point).same_direction(c, rival);
    return along ? d.challenger : site;
}

// At a root vertex the boundary arrives by h and leaves by next(h); the face fills the sector that runs
// counter-clockwise from the leaving half-edge back to the arriving one. If the signs on the two differ,
// exactly one of the trisector's two branches lies in the sector, and the sign left of it is that of h.
// Otherwise none or both do, or an edge itself is one: ask for each branch.
void WorkArcs::find_branches(Index cycle, FormPair rival) {
    for_cycle(cycle, [&](Index h) {
        const Index v = target(h);
        if (v == none || vertices_[v].sign != Sign::Zero) return;
        const Index n = half_edges_[h].next;
        const Sign in = edges_[h >> 1].sign, out = edges_[n >> 1].sign;
        if (in != Sign::Zero && out != Sign::Zero && in != out) {
            branches_.push_back({h, v, in == Sign::Negative});
            return;
        }
        // A trisector that is a single point has no branches.
        if (kernel_.radius_sign(rival) == Sign::Zero) return;
        const PointId p = vertices_[v].point;
        const FormPair from = directed(n), to = directed(twin(h));
        const bool leaves = PointStar(kernel_, p).branch_in_sector(from, rival, to);
        const bool arrives = PointStar(kernel_, p).branch_in_sector(from, rival.reversed(), to);
        // Counter-clockwise from n: beside a winning edge the challenger's region ends first.
        const bool start_first = out == Sign::Positive;
        if (leaves && start_first) branches_.push_back({h, v, true});
        if (arrives) branches_.push_back({h, v, false});
        if (leaves && !start_first) branches_.push_back({h, v, true});
    });
}

// Each start is joined with the first end that the trisector meets from there.
void WorkArcs::insert_arcs(FormPair rival) {
    if (branches_.empty()) return;
    const auto starts = std::ranges::count_if(branches_, &Branch::start);
    if (2 * starts != static_cast<std::ptrdiff_t>(branches_.size()))
        throw InternalError("a trisector enters a face " + std::to_string(starts) + " times and leaves it " +
                            std::to_string(static_cast<std::ptrdiff_t>(branches_.size()) - starts) +
                            " times");
    const bool several = starts > 1;
    const bool line = several && kernel_.curvature_sign(rival) == Sign::Zero;
    for (Branch& s : branches_) {
        if (!s.start) continue;
        const PointId p = vertices_[s.vertex].point;
        Branch* first = nullptr;
        for (Branch& t : branches_) {
            if (t.start) continue;
            const PointId q = vertices_[t.vertex].point;
            if (line && !CurveOrder(kernel_, rival).precedes(p, q)) continue;
            if (!first || CurveOrder(kernel_, rival).strictly_between(p, vertices_[first->vertex].point, q))
                first = &t;
        }
        if (!first || first->half_edge != none) throw InternalError("a trisector's arc has no end");
        const Index e = add_edge(rival, s.vertex, first->vertex, false);
        edges_[e].stamp = stamp_;
        half_edges_[2 * e].label = challenger_of(rival);
        half_edges_[2 * e + 1].label = defender_of(rival);
        s.half_edge = 2 * e;
        first->half_edge = 2 * e + 1;
        set_bounds(e);
        touched_.push_back(2 * e);
        touched_.push_back(2 * e + 1);
    }
    // Branches of one corner follow each other counter-clockwise from the leaving boundary edge: arriving
    // along one turns into the one before.
    for (std::size_t i = 0; i < branches_.size();) {
        const Index corner = branches_[i].corner;
        Index leaving = half_edges_[corner].next;
        for (; i < branches_.size() && branches_[i].corner == corner; ++i) {
            link(twin(branches_[i].half_edge), leaving);
            leaving = branches_[i].half_edge;
        }
        link(corner, leaving);
    }
}

// The trisector does not meet the face's boundary. It may still be a circle inside, around some of the holes
// or none: then the loser of the outer boundary wins inside the circle, or touches in a single point.
void WorkArcs::insert_island(Duel& d, Sign boundary) {
    const Face& f = faces_[d.face];
    const FormPair rival = rivals(d.challenger, f.site);
    if (kernel_.curvature_sign(rival) != boundary || kernel_.circle_leaves_box(rival, f.box)) return;
    const Sign radius = kernel_.radius_sign(rival);
    if (radius == Sign::Negative) return;
    if (radius == Sign::Zero &&
        std::ranges::any_of(f.isolated, [&](Index v) { return vertices_[v].sign == Sign::Zero; }))
        return;  // the point is known already
    const PointId p = radius == Sign::Zero ? kernel_.center_point(rival) : kernel_.leftmost_point(rival);
    if (!CycleLocator(*this).face_contains(f, p)) return;
    if (radius == Sign::Zero) {
        const Index v = add_vertex(p, f.site);
        --live_vertices_;
        add_ties(vertices_[v].ties, {f.site}, d.challenger);
        vertices_[v].stamp = stamp_;
        vertices_[v].isolated_in = d.face;
        faces_[d.face].isolated.push_back(v);
        return;
    }
    const Index e = add_edge(rival, none, none, false);
    ++live_vertices_;
    link(2 * e, 2 * e);
    link(2 * e + 1, 2 * e + 1);
    half_edges_[2 * e].label = challenger_of(rival);
    half_edges_[2 * e + 1].label = defender_of(rival);
    set_bounds(e);
    if (!d.met && !merging_ && f.inner.empty() && f.isolated.empty()) {
        // The common case at once: a new face in a hole of the old one.
        live_cycles_ += 2;
        const Index inside = add_face(d.challenger);
        faces_[inside].outer = 2 * e;
        faces_[inside].box = edges_[e].bounds.box;
        set_box(inside);
        half_edges_[2 * e].face = inside;
        half_edges_[2 * e + 1].face = d.face;
        faces_[d.face].inner.push_back(2 * e + 1);
        return;
    }
    if (!d.changed) {
        d.changed = true;
        for_boundary(f, [&](Index h) { touched_.push_back(h); });
    }
    const std::size_t first_new = touched_.size();
    touched_.push_back(2 * e);
    touched_.push_back(2 * e + 1);
    thread_isolated(d.face, first_new);
}

// Isolated vertices of the face through which the trisector runs become vertices of its new edges, those of
// touched_ from first_new on.
void WorkArcs::thread_isolated(Index face, std::size_t first_new) {
    std::erase_if(faces_[face].isolated, [&](Index v) {
        if (vertices_[v].stamp != stamp_ || vertices_[v].sign != Sign::Zero) return false;
        const PointId p = vertices_[v].point;
        for (std::size_t i = first_new; i < touched_.size(); i += 2) {
            const Index e = touched_[i] >> 1, from = half_edges_[2 * e].origin,
                        to = half_edges_[2 * e + 1].origin;
            if (from != none && !CurveOrder(kernel_, edges_[e].curve)
                                     .strictly_between(vertices_[from].point, vertices_[to].point, p))
                continue;
            const Index w = split_edge(e, p, half_edges_[2 * e].label), n = vertices_[w].out >> 1;
            vertices_[w].ties = vertices_[v].ties;
            vertices_[w].stamp = stamp_;
            set_bounds(e);
            if (n != e) {
                set_bounds(n);
                touched_.push_back(2 * n);
                touched_.push_back(2 * n + 1);
            }
            remove_vertex(v);
            return true;
        }
        return false;
    });
}

}  // namespace vcell
