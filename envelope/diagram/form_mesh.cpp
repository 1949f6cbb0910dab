#include "form_mesh.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "../../core/errors.hpp"
#include "../../core/sort_unique.hpp"

namespace vcell {

void FormMesh::reserve(std::size_t forms) {
    const std::size_t n = forms + 16;
    vertices_.reserve(4 * n);
    edges_.reserve(6 * n);
    half_edges_.reserve(12 * n);
    face_sites_.reserve(2 * n);
    united_faces_.reserve(2 * n);
}

FormMesh::Index FormMesh::add_ties(std::vector<FormId> forms) {
    sort_unique(forms);
    ties_.push_back(std::move(forms));
    return static_cast<Index>(ties_.size() - 1);
}

// The links of `edge` become those of both edges, `other` before or after it.
void FormMesh::join_links(Index edge, Index other, bool other_first, bool reverse_other) {
    if (edges_[edge].links == none) return;
    std::vector<Link>&mine = links_[edges_[edge].links], &theirs = links_[edges_[other].links];
    if (reverse_other) {
        std::ranges::reverse(theirs);
        for (Link& l : theirs) l = l.reversed();
    }
    if (other_first) mine.swap(theirs);
    mine.insert(mine.end(), theirs.begin(), theirs.end());
    theirs = {};
}

void FormMesh::merge_faces(Index f, Index g) {
    if (face_sites_[f] != face_sites_[g])
        throw InternalError("labels differ across a seam at face f" + std::to_string(f));
    f = united_faces_.find(f);
    g = united_faces_.find(g);
    united_faces_.merge(std::max(f, g), std::min(f, g));
}

// What is alive keeps its order, and a face's smallest number stands for it: elements are numbered as if
// they had always been here.
FormMesh::Index FormMesh::take(FormMesh&& part, Index half_edge) {
    std::vector<Index> faces, points, edges;
    faces.assign(part.face_sites_.size(), none);
    for (Index f = 0; f < faces.size(); ++f)
        if (part.united_faces_.find(f) == f) faces[f] = add_face(part.face_sites_[f]);
    const auto face_of = [&](Index f) { return f == none ? none : faces[part.united_faces_.find(f)]; };
    points.assign(part.vertices_.size(), none);
    auto vertex = static_cast<Index>(vertices_.size());
    for (Index v = 0; v < points.size(); ++v)
        if (part.vertices_[v].alive) points[v] = vertex++;
    edges.assign(part.edges_.size(), none);
    auto edge = static_cast<Index>(edges_.size());
    for (Index e = 0; e < edges.size(); ++e)
        if (part.edges_[e].alive) edges[e] = edge++;
    const auto moved = [&](Index h) { return h == none ? none : 2 * edges[h >> 1] | (h & 1u); };
    const auto take_ties = [&](Index list) {
        if (list == none) return none;
        ties_.push_back(std::move(part.ties_[list]));
        return static_cast<Index>(ties_.size() - 1);
    };
    for (const Vertex& from : part.vertices_) {
        if (!from.alive) continue;
        Vertex& to = vertices_.emplace_back(from);
        to.out = moved(from.out);
        to.isolated_in = face_of(from.isolated_in);
        to.ties = take_ties(from.ties);
    }
    for (Index e = 0; e < part.edges_.size(); ++e) {
        const Edge& from = part.edges_[e];
        if (!from.alive) continue;
        edges_.emplace_back(from).ties = take_ties(from.ties);
        for (const Index h : {2 * e, 2 * e + 1}) {
            const FormHalfEdge& half = part.half_edges_[h];
            half_edges_.push_back({moved(half.next), moved(half.prev),
                                   half.origin == none ? none : points[half.origin], face_of(half.face)});
        }
    }
    for (const Index v : part.isolated_)
        if (part.vertices_[v].alive) isolated_.push_back(points[v]);
    return moved(half_edge);
}

std::vector<FormId> FormMesh::label_of_edge(Index e) const {
    std::vector<FormId> forms;
    if (edges_[e].ties != none) forms = ties_[edges_[e].ties];
    for (const FormId f : {edges_[e].left, edges_[e].right})
        if (f.valid()) forms.push_back(f);
    sort_unique(forms);
    return forms;
}

void FormMesh::smooth(Index v) {
    if (!vertices_[v].alive || vertices_[v].out == none) return;
    const Index h = vertices_[v].out, g = next_around_origin(h);
    if (g == h || next_around_origin(g) != h) return;
    const Index e = h >> 1, f = g >> 1;
    if (edges_[e].side != edges_[f].side || left_of(h) != left_of(twin(g)) || left_of(twin(h)) != left_of(g))
        return;
    if (vertices_[v].ties != none || edges_[e].ties != none || edges_[f].ties != none) {
        const std::vector<FormId> label = label_of_edge(e);
        if (label != label_of_edge(f)) return;
        if (vertices_[v].ties != none && !std::ranges::includes(label, ties_[vertices_[v].ties])) return;
    }
    vertices_[v].alive = false;
    if (e == f) {  // the last vertex of a closed curve
        half_edges_[h].origin = half_edges_[g].origin = none;
        return;
    }
    const Index start = target(g);
    // The joined edge runs along h from `start`: half-edge 2e is h, or h's twin.
    join_links(e, f, (h & 1u) == 0, (h & 1u) == (g & 1u));
    join(twin(h));
    if (vertices_[start].out == twin(g)) vertices_[start].out = h;
    edges_[f].alive = false;
}

std::vector<FormId> FormMesh::label_of_origin(Index h) const {
    std::vector<FormId> forms;
    const Index ties = vertices_[half_edges_[h].origin].ties;
    if (ties != none) forms = ties_[ties];
    for_leaving(h, [&](Index g) {
        const std::vector<FormId> along = label_of_edge(g >> 1);
        forms.insert(forms.end(), along.begin(), along.end());
    });
    sort_unique(forms);
    return forms;
}

// Adds to the label of what lies in boxes(). False if it is not told of some of the ties.
template <class BoxesOf>
bool FormMesh::add_hidden(std::span<const HiddenTie> ties, std::vector<FormId>& label, BoxesOf&& boxes) {
    const auto has = [&](FormId f) { return std::ranges::find(label, f) != label.end(); };
    const auto is_told_tie = [&](const HiddenTie& tie) -> std::optional<bool> {
        if (!tie.is_tie) return true;
        for (const ChartBox& box : boxes())
            if (const auto is_tie = tie.is_tie(box)) return is_tie;
        return std::nullopt;
    };
    bool is_told = true;
    for (std::size_t before = 0; before != label.size();) {
        before = label.size();
        for (const HiddenTie& tie : ties) {
            if (!has(tie.between[0]) || !has(tie.between[1]) || has(tie.form)) continue;
            const auto is_tie = is_told_tie(tie);
            if (!is_tie) is_told = false;
            if (is_tie == true) label.push_back(tie.form);
        }
    }
    sort_unique(label);
    return is_told;
}

bool FormMesh::tie_hidden(std::span<const HiddenTie> ties) {
    if (ties.empty()) return true;
    const auto around = [](const Eigen::Vector2d& p, double error) {
        return ChartBox{Interval::ball(p.x(), error), Interval::ball(p.y(), error)};
    };
    bool is_told = true;
    for (Index e = 0; e < edges_.size(); ++e) {
        if (!edges_[e].alive) continue;
        std::vector<FormId> label = label_of_edge(e);
        const std::size_t known = label.size();
        const auto boxes = [&] {
            std::vector<ChartBox> all;
            for (const Link& link : links(e)) all.push_back(around(link.to, link.to_error));
            for (const Index v : {half_edges_[2 * e].origin, target(2 * e)})
                if (v != none) all.push_back(around({vertices_[v].x, vertices_[v].y}, vertices_[v].error));
            return all;
        };
        is_told = add_hidden(ties, label, boxes) && is_told;
        if (label.size() > known) edges_[e].ties = add_ties(std::move(label));
    }
    // What does so along an edge does in its ends.
    const auto ties_along = [&](Index v) {
        bool is_any = false;
        if (vertices_[v].out != none)
            for_leaving(vertices_[v].out, [&](Index h) { is_any = is_any || edges_[h >> 1].ties != none; });
        return is_any;
    };
    for (Index v = 0; v < vertices_.size(); ++v) {
        if (!vertices_[v].alive) continue;
        std::vector<FormId> label;
        if (vertices_[v].out != none)
            label = label_of_origin(vertices_[v].out);
        else if (vertices_[v].ties != none)
            label = ties_[vertices_[v].ties];
        const std::size_t known = label.size();
        const Vertex& at = vertices_[v];
        const auto boxes = [&] { return std::array{around({at.x, at.y}, at.error)}; };
        is_told = add_hidden(ties, label, boxes) && is_told;
        if (label.size() > known || ties_along(v)) vertices_[v].ties = add_ties(std::move(label));
    }
    for (Index v = 0; v < vertices_.size(); ++v) smooth(v);
    return is_told;
}

// Pieces and their union are judged alike: their faces are known by what stands for them.
void FormMesh::require_soundness() {
#ifndef NDEBUG
    std::vector<FormHalfEdge> as_glued = half_edges_;
    for (FormHalfEdge& h : half_edges_)
        if (h.face != none) h.face = united_faces_.find(h.face);
    if (const auto defect = find_defect([&](Index e) { return edges_[e].alive; }))
        throw InternalError("glued pieces: " + *defect);
    half_edges_.swap(as_glued);
#endif
}

}  // namespace vcell
