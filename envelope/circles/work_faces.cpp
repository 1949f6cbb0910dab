#include "work_faces.hpp"

#include <algorithm>

#include "../../core/errors.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "cycle_locator.hpp"

namespace vcell {

void WorkFaces::insert(FormId challenger) {
    duels_.clear();
    const KernelForm form = kernel_.form(challenger);
    inserts_greater_ = is_floor(challenger);
    if (!are_boxes_current_) renew_boxes();
    const auto add = [&](Index f) {
        duels_.push_back({f, challenger, boxes_.slope_bound(f, form, kernel_.form(faces_[f].site))});
    };
    if (inserts_greater_) {
        for (Index f = 1; f < faces_.size(); ++f)
            if (faces_[f].alive) add(f);
    } else {
        boxes_.challenge(form, add);
    }
    if (!duels_.empty()) {
        begin();
        for (Duel& d : duels_) decide_boundary(d);
        divide_faces();
    }
    inserts_greater_ = false;
}

// Signs are those of challenger - defender: negative where the challenger wins. Boundaries have been cut
// where the sign changes; arcs are inserted face by face; then labels decide which edges stay.
void WorkFaces::divide_faces() {
    touched_.clear();
    isolated_.clear();
    const long components_before = component_count();
    bool plain = true;  // no changed face has holes or isolated vertices
    for (Duel& d : duels_) {
        divide_face(d);
        if (!d.changed) continue;
        const Face& f = faces_[d.face];
        live_cycles_ -= 1 + static_cast<long>(f.inner.size());
        plain = plain && f.inner.empty() && f.isolated.empty();
    }
    if (touched_.empty()) return;
    remove_inner_edges();

    for (const Duel& d : duels_) {
        if (!d.changed) continue;
        Face& f = faces_[d.face];
        for (const Index v : f.isolated) {
            Vertex& vertex = vertices_[v];
            const bool stays = merging_ ? vertex.ties != none && ties_[vertex.ties].size() > 1
                                        : vertex.stamp != stamp_ || vertex.sign != Sign::Negative;
            if (stays) {
                isolated_.push_back(v);
            } else {
                remove_vertex(v);
            }
        }
        f.isolated.clear();
        remove_face(d.face);
    }
    rebuild_faces();
    const long components = component_count();
    if (isolated_.empty() && (components == 1 || (plain && components == components_before))) {
        for (const Index c : cycles_) add_bounded_face(c);
    } else {
        nest_cycles();
    }
    require_soundness(walks_);
}

void WorkFaces::remove_inner_edges() {
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
void WorkFaces::rebuild_faces() {
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

// Takes the edge out of the rotations at its ends; a vertex that keeps no edge goes with it.
void WorkFaces::kill_edge(Index e) {
    const Index h = 2 * e, t = h + 1;
    if (half_edges_[h].origin == none) {
        --live_vertices_;
    } else {
        for (const Index g : {h, t}) {
            const Index v = half_edges_[g].origin, after = detach(g);
            if (after == none && merging_ && vertices_[v].ties != none &&
                ties_[vertices_[v].ties].size() > 1) {
                // An isolated point of one diagram that lay on an edge of the other.
                vertices_[v].out = none;
                isolated_.push_back(v);
                --live_vertices_;
            } else if (after == none) {
                remove_vertex(v);
                --live_vertices_;
            } else {
                vertices_[v].out = after;
            }
        }
    }
    remove_edge(e);
}

// Removes v if it only continues one arc: two edges of one curve and one label, and nothing else that
// attains the minimum at v.
void WorkFaces::smooth(Index v) {
    const Index h = vertices_[v].out;
    if (!vertices_[v].alive || h == none) return;
    const Index g = next_around_origin(h), e = h >> 1, f = g >> 1;
    if (g == h || next_around_origin(g) != h) return;
    if (half_edges_[h].label != half_edges_[twin(g)].label ||
        half_edges_[twin(h)].label != half_edges_[g].label)
        return;
    if (edges_[e].rim && edges_[e].curve != edges_[f].curve) return;
    const auto label = [&](Index edge) {
        std::vector<FormId> forms;
        if (edges_[edge].ties != none) forms = ties_[edges_[edge].ties];
        for (const Index half : {2 * edge, 2 * edge + 1})
            if (half_edges_[half].label.valid()) forms.push_back(half_edges_[half].label);
        std::ranges::sort(forms);
        forms.erase(std::ranges::unique(forms).begin(), forms.end());
        return forms;
    };
    if (vertices_[v].ties != none || edges_[e].ties != none || edges_[f].ties != none) {
        const std::vector<FormId> forms = label(e);
        if (forms != label(f)) return;
        if (vertices_[v].ties != none && std::ranges::any_of(ties_[vertices_[v].ties], [&](FormId form) {
                return !std::ranges::binary_search(forms, form);
            }))
            return;
    }
    if (e != f) {
        join_with_next(twin(h));
        return;
    }
    // The last vertex of a closed curve, which counts as one vertex and one edge still.
    remove_vertex(v);
    half_edges_[h].origin = half_edges_[g].origin = none;
    set_bounds(e);
}

// The face that this component bounds from outside.
void WorkFaces::add_bounded_face(Index outer) {
    const Index f = add_face(half_edges_[outer].label);
    Face& face = faces_[f];
    face.outer = outer;
    for_cycle(outer, [&](Index h) {
        half_edges_[h].face = f;
        grow(face.box, edges_[h >> 1].bounds.box);
    });
    set_box(f);
}

// Finds which of the new components bound faces from outside, and in which face each of the others, and
// each isolated vertex, lies.
void WorkFaces::nest_cycles() {
    CycleLocator locator(*this);
    std::vector<Index> outer, inner;
    for (const Index c : cycles_) (locator.is_outer_cycle(c) ? outer : inner).push_back(c);
    for (const Index c : outer) add_bounded_face(c);
    const auto face_around = [&](PointId p, FormId label) {
        // Faces inside an island may pass through p as well: they carry another label, or touch at p only.
        const auto candidate = [&](Index c) {
            if (label.valid() && half_edges_[c].label != label) return false;
            bool through = false;
            for_cycle(c, [&](Index h) {
                through =
                    through || (half_edges_[h].origin != none && vertices_[half_edges_[h].origin].point == p);
            });
            return !through && locator.cycle_contains(c, p);
        };
        Index best = none;
        for (const Index c : outer)
            if (candidate(c) && (best == none || locator.cycle_contains(best, locator.point_on(c)))) best = c;
        if (best == none) throw InternalError("an island lies in no face");
        return half_edges_[best].face;
    };
    for (const Index c : inner) {
        const Index f = face_around(locator.point_on(c), half_edges_[c].label);
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

}  // namespace vcell
