// WorkDiagram where faces are divided: the arcs that a challenger's trisector has inside a face, the edges
// that go with it, and the faces that the boundaries then bound, islands in them included.
#include <algorithm>
#include <cmath>
#include <utility>

#include "../../arrangement/circles/curve_order.hpp"
#include "../../arrangement/circles/point_star.hpp"
#include "../../core/errors.hpp"
#include "work_diagram.hpp"

namespace vcell {

// --- Arcs inside a face -------------------------------------------------------------------------------

void WorkDiagram::divide_face(Duel& d) {
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
FormId WorkDiagram::winner_along(Index h, const Duel& d) {
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
void WorkDiagram::find_branches(Index cycle, FormPair rival) {
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
void WorkDiagram::insert_arcs(FormPair rival) {
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
void WorkDiagram::insert_island(Duel& d, Sign boundary) {
    const Face& f = faces_[d.face];
    const FormPair rival = rivals(d.challenger, f.site);
    if (kernel_.curvature_sign(rival) != boundary || kernel_.circle_leaves_box(rival, f.box)) return;
    const Sign radius = kernel_.radius_sign(rival);
    if (radius == Sign::Negative) return;
    if (radius == Sign::Zero &&
        std::ranges::any_of(f.isolated, [&](Index v) { return vertices_[v].sign == Sign::Zero; }))
        return;  // the point is known already
    const PointId p = radius == Sign::Zero ? kernel_.center_point(rival) : kernel_.leftmost_point(rival);
    if (!face_contains(f, p)) return;
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
void WorkDiagram::thread_isolated(Index face, std::size_t first_new) {
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

void WorkDiagram::remove_inner_edges() {
    for (const Index h : touched_) {
        const Index e = h >> 1;
        if (edges_[e].alive && half_edges_[2 * e].label == half_edges_[2 * e + 1].label) kill_edge(e);
    }
    if (merging_) {
        for (Index v = 0; v < vertices_.size(); ++v) smooth(v);
        return;
    }
    // On the rim, where no edge goes, vertices between equal labels do.
    for (const Index h : touched_) {
        const Index e = h >> 1;
        if (!edges_[e].alive || !edges_[e].rim || edges_[e].stamp != stamp_) continue;
        if (edges_[e].sign == Sign::Negative) edges_[e].ties = none;
        while (vertices_[target(h)].sign == Sign::Negative) {
            if (edges_[half_edges_[h].next >> 1].curve == edges_[e].curve) {
                join_with_next(h);
                continue;
            }
            Vertex& corner = vertices_[target(h)];
            corner.ties = none;
            set_height(corner, half_edges_[h].label);
            break;
        }
    }
}

// Collects the new boundary components of all changed faces into cycles_.
void WorkDiagram::rebuild_faces() {
    cycles_.clear();
    for (const Index h : touched_) {
        if (!edges_[h >> 1].alive) continue;
        half_edges_[h].face = none;
        Edge& edge = edges_[h >> 1];
        // The edge may separate others than before, tied all along it.
        if (!edge.rim) edge.curve = between(half_edges_[h & ~1u].label, half_edges_[h | 1u].label);
    }
    for (const Index h : touched_) {
        if (!edges_[h >> 1].alive || half_edges_[h].face != none) continue;
        cycles_.push_back(h);
        for_cycle(h, [&](Index g) { half_edges_[g].face = outside; });
    }
    live_cycles_ += static_cast<long>(cycles_.size());
}

// --- Islands ---------------------------------------------------------------------------------------------

// Finds which of the new components bound faces from outside, and in which face each of the others, and
// each isolated vertex, lies.
void WorkDiagram::nest_cycles() {
    std::vector<Index> outer, inner;
    for (const Index c : cycles_) (is_outer_cycle(c) ? outer : inner).push_back(c);
    for (const Index c : outer) {
        const Index f = add_face(half_edges_[c].label);
        faces_[f].outer = c;
        for_cycle(c, [&](Index h) {
            half_edges_[h].face = f;
            grow(faces_[f].box, edges_[h >> 1].bounds.box);
        });
        set_box(f);
    }
    const auto face_around = [&](PointId p, FormId label) {
        // Faces inside an island may pass through p as well: they carry another label, or touch at p only.
        const auto candidate = [&](Index c) {
            if (label.valid() && half_edges_[c].label != label) return false;
            bool through = false;
            for_cycle(c, [&](Index h) {
                through =
                    through || (half_edges_[h].origin != none && vertices_[half_edges_[h].origin].point == p);
            });
            return !through && cycle_contains(c, p);
        };
        Index best = none;
        for (const Index c : outer)
            if (candidate(c) && (best == none || cycle_contains(best, point_on(c)))) best = c;
        if (best == none) throw InternalError("an island lies in no face");
        return half_edges_[best].face;
    };
    for (const Index c : inner) {
        const Index f = face_around(point_on(c), half_edges_[c].label);
        faces_[f].inner.push_back(c);
        for_cycle(c, [&](Index h) { half_edges_[h].face = f; });
    }
    for (const Index v : isolated_) {
        Vertex& vertex = vertices_[v];
        const Index f = face_around(vertex.point, {});
        vertex.isolated_in = f;
        faces_[f].isolated.push_back(v);
    }
}

PointId WorkDiagram::point_on(Index cycle) {
    const Index v = half_edges_[cycle].origin;
    return v != none ? vertices_[v].point : kernel_.leftmost_point(directed(cycle));
}

// The face lies right of the cycle's leftmost point if the cycle bounds it from outside, left of it if it
// is an island in it.
bool WorkDiagram::is_outer_cycle(Index cycle) {
    if (half_edges_[cycle].origin == none) return kernel_.curvature_sign(directed(cycle)) == Sign::Positive;
    PointId leftmost;
    bool on_arc = false, outer = false;
    double right_of_some = HUGE_VAL;  // some point of the cycle lies left of here
    for_cycle(cycle, [&](Index h) {
        const KernelPoint& p = at(half_edges_[h].origin);
        right_of_some = std::min(right_of_some, Interval::up(p.x + p.error));
    });
    for_cycle(cycle, [&](Index h) {
        if (edges_[h >> 1].bounds.box[0] > right_of_some) return;
        const Index v = half_edges_[h].origin, w = target(h);
        const PointId p = vertices_[v].point;
        if (!leftmost.valid() || (p != leftmost && kernel_.compare_xy(p, leftmost) == Sign::Negative)) {
            leftmost = p;
            on_arc = false;
        }
        const FormPair c = directed(h);
        const Sign K = kernel_.curvature_sign(c);
        if (K == Sign::Zero) return;
        const PointId extreme = kernel_.leftmost_point(c);
        if (!CurveOrder(kernel_, c).strictly_between(p, vertices_[w].point, extreme)) return;
        if (kernel_.compare_xy(extreme, leftmost) == Sign::Negative) {
            leftmost = extreme;
            on_arc = true;
            outer = K == Sign::Positive;
        }
    });
    if (on_arc) return outer;
    // At a vertex: inner if a corner's sector contains the direction to the left. All edges leave to the
    // right (or straight up), so a sector does unless it turns left from its first edge to its last.
    bool inner = false;
    for_cycle(cycle, [&](Index h) {
        if (vertices_[target(h)].point != leftmost) return;
        inner = inner || PointStar(kernel_, leftmost)
                             .sector_contains_left(directed(half_edges_[h].next), directed(twin(h)));
    });
    return !inner;
}

bool WorkDiagram::cycle_contains(Index cycle, PointId p) {
    int crossings = 0;
    for_cycle(cycle, [&](Index h) { crossings += crossings_above(h >> 1, p); });
    return crossings % 2 == 1;
}

bool WorkDiagram::face_contains(const Face& f, PointId p) {
    int crossings = 0;
    for_boundary(f, [&](Index h) { crossings += crossings_above(h >> 1, p); });
    return crossings % 2 == 1;
}

// How often the open vertical ray upwards from p crosses the edge; p does not lie on it. An x-monotone
// piece counts its left end and not its right one.
int WorkDiagram::crossings_above(Index e, PointId p) {
    const KernelPoint& at_p = kernel_.point(p);
    const std::array<double, 4>& box = edges_[e].bounds.box;
    if (box[1] < at_p.x - at_p.error || box[0] > at_p.x + at_p.error || box[3] < at_p.y - at_p.error)
        return 0;
    const FormPair c = edges_[e].curve;
    const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;
    const auto left_of_or_at = [&](PointId q) { return kernel_.compare_x(q, p) != Sign::Positive; };
    const Sign K = kernel_.curvature_sign(c);
    if (K == Sign::Zero) {
        const PointId a = vertices_[from].point, b = vertices_[to].point;
        if (left_of_or_at(a) == left_of_or_at(b)) return 0;
        // Above the line {F = 0}, F = A x + B y + C, F has the sign of B; B has that of -dx along it.
        const Sign B = left_of_or_at(a) ? Sign::Negative : Sign::Positive;
        return kernel_.sign_at(p, c.f, c.g) == -B ? 1 : 0;
    }
    const Sign side = kernel_.side_of_center(p, c), distance = K * kernel_.sign_at(p, c.f, c.g);
    // Is p below the lower half (below the upper half) of the circle, where they have p's x?
    const bool below_lower = distance == Sign::Positive && side == Sign::Negative;
    const bool below_upper = distance == Sign::Negative || side == Sign::Negative ||
                             (distance == Sign::Zero && side != Sign::Positive);
    const PointId left = kernel_.leftmost_point(c), right = kernel_.rightmost_point(c);
    int count = 0;
    const auto piece = [&](PointId a, PointId b, bool upper) {
        if (left_of_or_at(a) != left_of_or_at(b) && (upper ? below_upper : below_lower)) ++count;
    };
    if (from == none) {
        piece(left, right, false);
        piece(right, left, true);
        return count;
    }
    // Counter-clockwise from a to b.
    PointId a = vertices_[from].point, b = vertices_[to].point;
    FormPair ccw = c;
    if (K == Sign::Negative) {
        std::swap(a, b);
        ccw = c.reversed();
    }
    const bool has_left = CurveOrder(kernel_, ccw).strictly_between(a, b, left),
               has_right = CurveOrder(kernel_, ccw).strictly_between(a, b, right);
    if (has_left && has_right) {
        const bool left_first = CurveOrder(kernel_, ccw).strictly_between(a, right, left);
        if (left_first) {
            piece(a, left, true);
            piece(left, right, false);
            piece(right, b, true);
        } else {
            piece(a, right, false);
            piece(right, left, true);
            piece(left, b, false);
        }
    } else if (has_left) {
        piece(a, left, true);
        piece(left, b, false);
    } else if (has_right) {
        piece(a, right, false);
        piece(right, b, true);
    } else {
        // Within one half: the lower one is run to the right, the upper one to the left.
        piece(a, b, kernel_.compare_x(a, b) == Sign::Positive);
    }
    return count;
}

}  // namespace vcell
