/// Insertion of one more form into a diagram of discs: which faces it reaches, and how its own is cut in.
///
/// A form is inserted as the paper compares two surfaces [HE, section 2.1], but against the faces of the
/// diagram so far that it may conflict with. What it takes away is known from signs at vertices and along
/// edges (disc_comparison.hpp), as long as no face is cut in more than two: circles meet in two points at
/// most.
///
/// The points of space where the new form c is the lowest are a convex polyhedron P, and it wins where P
/// meets the sphere. A part of P on the sphere that holds no vertex is the only one. It passes from face to
/// face across edges without running in circles, as faces are discs; so it has a last face f, next to g.
/// There it is all of c < f and c < g that lies in f, as three circles through two points leave nothing else,
/// and what is left without f has one face less. With one face it is a whole cap, and P lies in the
/// half-space of that. So, if c wins at any vertex, then in each part at one at least, and from those the
/// faces that it reaches are found across edges. A small diagram is looked through for vertices, a large one
/// has a tree of them.
///
/// Where the form ties with a vertex it counts as the higher one. That is the diagram of forms of which each
/// is raised by an infinitesimal that is beyond all multiples of those before: vertices have three edges
/// still, and those in which more forms tie are several, joined by edges without length. Of these it is known
/// exactly that both their ends are one point. In the end they are contracted, and the vertices have all
/// their forms. Where the form ties along an edge it is higher there, too: it belongs to the edge's label. If
/// it is lower on one side of the edge, the face there keeps a sliver of two edges on one circle. In the end
/// slivers are contracted to edges, whose labels they join. A face that meets itself in such a point, and an
/// edge that is closed there, are left to the general engine; so are forms that touch edges in a point, or
/// tie inside faces.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "disc_comparison.hpp"

namespace vcell::discs {

class DiscInsertion : protected DiscComparison {
protected:
    using DiscComparison::DiscComparison;

    /// Later: no common case as the diagram is, which is as it was; when others have cut its faces it may be
    /// one. Failed: neither then, and the diagram is broken.
    enum class Insertion { Done, Later, Failed };
    /// Merges in one more form.
    Insertion insert(Index challenger) {
        ++stamp_;
        rivals_.clear();
        cuts_.clear();
        swallowed_.clear();
        new_edges_.clear();
        middles_.clear();
        has_new_ties_ = false;
        bool is_beaten = false;
        const Linear& form = forms_[challenger];
        if (!(vertex_tree_ ? find_rivals_in_trees(form) : find_rivals(form, is_beaten)))
            return Insertion::Failed;
        if (is_beaten) return Insertion::Done;
        for (std::size_t i = 0; i < rivals_.size(); ++i)  // may add some
            if (!challenge(form, rivals_[i])) return put_off();
        if (cuts_.empty()) {
            // All boundaries are kept or all lost, and this cannot be.
            for (const Index face : rivals_)
                if (!is_within(form, face)) return put_off();
            return swallowed_.empty() ? Insertion::Done : Insertion::Failed;
        }
        for (const Index face : swallowed_)
            if (!is_within(form, face)) return put_off();
        return cut_in(challenger) ? Insertion::Done : Insertion::Failed;
    }

    /// Forms are to come that are steeper than all others. False where that is no common case.
    bool set_steepest(double steepest) {
        if (vertex_tree_) return false;
        steepest_ = steepest;
        top_ = HUGE_VAL;
        is_top_known_ = false;
        const auto renew = [&](Mark& mark, MarkRows& rows, Index i) {
            if (mark.is_gone() || mark.doubt == HUGE_VAL) return;
            mark.set_level(steepest);
            rows.set(i, mark);
        };
        for (Index v = 0; v < vertices_.size(); ++v) renew(vertices_[v], vertex_rows_, v);
        for (Index e = 0; e < edges_.size(); ++e) renew(edges_[e].apex, apex_rows_, e);
        return true;
    }

    SomeIndices alive_faces_;  // as long as there is no tree

private:
    static constexpr std::size_t largest_small = 96;  // faces of a diagram without a tree

    void add_rival(Index face) {
        if (std::exchange(faces_[face].stamp, stamp_) != stamp_) rivals_.push_back(face);
    }
    // The faces about vertices where the challenger wins; if there are none, all, unless it is beaten.
    bool find_rivals(const Linear& form, bool& is_beaten) {
        is_beaten = form.e - form.slope - form.error > top_;
        if (is_beaten) return true;
        const bool is_decided = vertex_rows_.search(form, [&](Index i) {
            Vertex& v = vertices_[i];
            if (v.is_below(form)) return true;
            if (!decide(v, form)) return false;
            for (const Index f : v.forms) add_rival(f);
            return true;
        });
        if (!is_decided) return false;
        if (!rivals_.empty()) return true;
        is_beaten = is_beaten_on_edges(form);
        for (const Index f : is_beaten&& is_flatter(form) ? wide_faces_ : alive_faces_)
            if (!(is_beaten && is_beaten_in(form, f))) add_rival(f);
        is_beaten = rivals_.empty();
        if (is_beaten && !is_top_known_) set_top();
        return true;
    }
    // Does the form grow towards the pole of each face that lies in its hemisphere, even with |b| |rival.b|
    // in place of grows_to_pole()'s product? Slopes are rounded up, squares down.
    bool is_flatter(const Linear& form) {
        if (!is_flattest_known_) {
            is_flattest_known_ = true;
            flattest_ = HUGE_VAL;
            wide_faces_.clear();
            for (const Index f : alive_faces_) {
                const Linear& rival = forms_[f];
                if (is_in_hemisphere(f))
                    flattest_ = std::min(flattest_, rival.square / rival.slope - rival.error);
                else
                    wide_faces_.push_back(f);
            }
        }
        return (form.slope + form.error) * (1 + slack) < flattest_;
    }
    bool is_beaten_on_edges(const Linear& form) {
        return apex_rows_.search(form, [&](Index e) {
            const Edge& edge = edges_[e];
            return edge.is_point || is_beside(edge, false, form) ||
                   look_between(e, false, form) == Middle::Same;
        });
    }
    // A bound on the diagram from above: forms are highest where faces end, or opposite to where they are
    // lowest.
    void set_top() {
        is_top_known_ = true;
        for (const Index f : alive_faces_)
            if (!is_in_hemisphere(f)) return;
        double top = -HUGE_VAL;
        for (const Vertex& v : vertices_) top = std::max(top, v.level);
        for (const Edge& edge : edges_) top = std::max(top, edge.apex.level);
        top_ = top;
    }
    bool find_rivals_in_trees(const Linear& form) {
        const bool is_decided = vertex_tree_->search(form, vertices_, [&](Index v) {
            if (!decide(vertices_[v], form)) return false;
            for (const Index f : vertices_[v].forms) add_rival(f);
            return true;
        });
        if (!is_decided) return false;
        if (!rivals_.empty()) return true;
        for (const Index f : new_faces_) {
            if (faces_[f].start == none) continue;
            set_ball(f);
            face_tree_->add(f, faces_[f].ball, faces_[f].top);
        }
        new_faces_.clear();
        face_tree_->search(
            form, [&](Index f) { return faces_[f].start == none ? nullptr : &faces_[f].ball; },
            [&](Index f) { return faces_[f].top; },
            [&](Index f) {
                if (faces_[f].start == none) return;
                if (!faces_[f].is_ball_known) set_ball(f);
                if (may_conflict(form, f)) add_rival(f);
            });
        return true;
    }
    // May the form be lower than the face's somewhere in the face?
    bool may_conflict(const Linear& form, Index face) const {
        const Face& f = faces_[face];
        const Linear& rival = forms_[face];
        const Vector3d gradient = form.b - rival.b;
        return f.cap.least(gradient, gradient.norm() * (1 + slack)) + form.e - rival.e <=
               form.error + rival.error;
    }

    // Leaves the diagram as it was, but for ties: those count for forms that came before.
    Insertion put_off() {
        if (has_new_ties_) return Insertion::Failed;
        while (!middles_.empty()) {
            remove_middle(middles_.back().first);
            middles_.pop_back();
        }
        return Insertion::Later;
    }

    struct Cut {
        Index face;
        Index leaving, returning;  // the half-edges of the face where the challenger starts and ceases to win
    };
    // Compares challenger and face along the face's boundary; false where that is no common case. Adds the
    // neighbours that the challenger reaches from here.
    bool challenge(const Linear& form, Index face) {
        Cut c{face, none, none};
        int crossings = 0;
        Index h = faces_[face].start;
        if (!is_decided(vertices_[half_edges_[h].origin], form)) return false;
        do {
            Vertex& to = vertices_[target(h)];
            if (!is_decided(to, form)) return false;
            const bool is_from_taken = is_taken(vertices_[half_edges_[h].origin]);
            bool is_crossed = is_from_taken != is_taken(to);
            Edge& edge = edges_[h >> 1];
            if (!is_crossed && !edge.is_point && !is_beside(edge, is_from_taken, form) &&
                edge.stamp != stamp_) {
                edge.stamp = stamp_;
                Middle middle = look_between(h >> 1, is_from_taken, form);
                if (middle == Middle::Unknown && !is_from_taken && ties_along(h >> 1, form))
                    middle = Middle::Same;
                if (middle == Middle::Unknown) return false;
                is_crossed = middle == Middle::Differs;
                if (is_crossed) put_middle(h);
            }
            if (is_crossed) {
                ++crossings;
                (is_from_taken ? c.returning : c.leaving) = h;
            }
            if (is_crossed || is_from_taken) add_rival(right(h));
            h = half_edges_[h].next;
        } while (h != faces_[face].start);
        if (crossings > 2) return false;
        if (crossings == 2)
            cuts_.push_back(c);
        else if (is_taken(vertices_[half_edges_[h].origin]))
            swallowed_.push_back(face);
        return true;
    }
    // --- Cuts

    bool cut_in(Index challenger) {
        for (const Cut& c : cuts_)
            if (!add_vertex(challenger, c)) return false;
        for (const Index face : swallowed_) {
            remove(faces_[face].start, faces_[face].start);
            faces_[face].start = none;
        }
        for (const Cut& c : cuts_) {
            if (half_edges_[c.leaving].next != c.returning) remove(half_edges_[c.leaving].next, c.returning);
            remove_vertex(half_edges_[c.returning].origin);
        }
        for (const Cut& c : cuts_) cut(challenger, c);
        for (const SplitEdge& m : middles_)
            if (!m.is_taken) remove_middle(m.first);
        if (!vertex_tree_) {
            if (!swallowed_.empty()) erase_if(alive_faces_, [&](Index f) { return faces_[f].start == none; });
            alive_faces_.push_back(challenger);
            top_ = HUGE_VAL;
            is_top_known_ = is_flattest_known_ = false;
        }
        return close(challenger);
    }
    // By put_middle(): the half-edge that ends in the middle, and whether the challenger wins there.
    struct SplitEdge {
        Index first;
        bool is_taken;
    };
    // Puts a vertex at middle_ on the edge of h, until the challenger is inserted. h stays the first part.
    void put_middle(Index h) {
        const Index from = half_edges_[h].origin;
        Vertex middle;
        middle.p = middle_;
        middle.stamp = stamp_;
        middle.taken = is_taken(vertices_[from]) ? 0 : stamp_;
        const Index v = add(vertices_, free_vertices_, middle);
        const Index e = add_edge(edges_[h >> 1]);
        // Both parts lie on the old curve in the old direction.
        split(h, v, 2 * e + (h & 1u));
        middles_.push_back({h, is_taken(vertices_[v])});
    }
    // Undoes that where the middle is left.
    void remove_middle(Index h) {
        const Index second = next(h);
        remove_vertex(half_edges_[second].origin);
        join(h);
        remove_edge(second >> 1);
    }
    // Where a half-edge of the face passes from the face to the challenger: there face, face on the right and
    // challenger follow each other counter-clockwise.
    bool add_vertex(Index challenger, const Cut& c) {
        const auto vertex = meet(c.face, right(c.leaving), challenger);
        if (!vertex) return false;
        ++decisions_.by_double;
        const Index v = add(vertices_, free_vertices_, *vertex);
        if (!vertex_tree_) vertex_rows_.set(v, *vertex);
        edges_[c.leaving >> 1].cut = v;
        return true;
    }
    // The challenger's half-edge along the cut waits at the point where the boundary returns to the face.
    void cut(Index challenger, const Cut& c) {
        const Index from = edges_[c.leaving >> 1].cut, to = edges_[c.returning >> 1].cut;
        const Index e = add_edge({});
        half_edges_[2 * e] = {c.returning, c.leaving, from, c.face};
        half_edges_[2 * e + 1] = {none, none, to, challenger};
        half_edges_[twin(c.leaving)].origin = from;
        half_edges_[c.returning].origin = to;
        half_edges_[c.leaving].next = half_edges_[c.returning].prev = 2 * e;
        vertices_[to].out = 2 * e + 1;
        faces_[c.face].start = 2 * e;
        set_curve(e);
        new_edges_.push_back(e);
    }
    // Is what the challenger has won one disc?
    bool close(Index challenger) {
        for (const Index e : new_edges_) link(2 * e + 1, vertices_[half_edges_[2 * e].origin].out);
        const Index start = 2 * new_edges_.front() + 1;
        std::size_t length = 0;
        Index h = start;
        do {
            ++length;
            h = half_edges_[h].next;
        } while (h != start);
        if (length != new_edges_.size()) return false;
        faces_[challenger].start = start;
        for (const Index e : new_edges_) set_arc(e);
        for (const Cut& c : cuts_) {
            // Of the parts of an edge that was crossed twice one is no more.
            if (!edges_[c.leaving >> 1].apex.is_gone()) set_arc(c.leaving >> 1);
            faces_[c.face].is_hemisphere_known = faces_[c.face].is_in_hemisphere;
            faces_[c.face].is_ball_known = false;
        }
        if (vertex_tree_) {
            for (const Index e : new_edges_) vertex_tree_->add(half_edges_[2 * e].origin, vertices_);
            new_faces_.push_back(challenger);
        } else if (alive_faces_.size() > largest_small) {
            plant_trees();
        }
        return true;
    }
    void plant_trees() {
        vertex_tree_.emplace();
        face_tree_.emplace();
        for (Index v = 0; v < vertices_.size(); ++v)
            if (!vertices_[v].is_gone()) vertex_tree_->add(v, vertices_);
        new_faces_ = alive_faces_;
    }

    double top_ = HUGE_VAL;  // the diagram is nowhere higher
    bool is_top_known_ = false;
    double flattest_ = 0;  // forms of less slope grow towards the poles of all faces but these
    SomeIndices wide_faces_;
    bool is_flattest_known_ = false;
    SomeIndices new_faces_;  // not in the tree yet
    // Working space of insert().
    SomeIndices rivals_, swallowed_, new_edges_;
    SmallVector<SplitEdge, 32> middles_;
    SmallVector<Cut, 32> cuts_;
};

}  // namespace vcell::discs
