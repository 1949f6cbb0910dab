#include "work_mesh.hpp"

#include <bit>
#include <string>

#include "../../core/errors.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

WorkMesh::Index WorkMesh::add_vertex(PointId p, FormId lowest) {
    Index v;
    if (free_vertices_.empty()) {
        v = static_cast<Index>(vertices_.size());
        vertices_.emplace_back();
    } else {
        v = free_vertices_.back();
        free_vertices_.pop_back();
        vertices_[v] = Vertex{};
    }
    Vertex& vertex = vertices_[v];
    vertex.point = p;
    const KernelPoint& at = kernel_.point(p);
    vertex.x = at.x;
    vertex.y = at.y;
    vertex.error = at.error;
    set_height(vertex, lowest);
    ++live_vertices_;
    return v;
}

void WorkMesh::set_height(Vertex& v, FormId lowest) const {
    const auto [height, error] = kernel_.height(lowest, v.point);
    v.height = height;
    v.height_error = error;
}

WorkMesh::Index WorkMesh::add_edge(FormPair curve, Index from, Index to, bool rim) {
    Index e;
    if (free_edges_.empty()) {
        e = static_cast<Index>(edges_.size());
        edges_.emplace_back();
        half_edges_.resize(half_edges_.size() + 2);
    } else {
        e = free_edges_.back();
        free_edges_.pop_back();
        edges_[e] = Edge{};
    }
    edges_[e].curve = curve;
    edges_[e].rim = rim;
    half_edges_[2 * e] = {none, none, from, none, {}};
    half_edges_[2 * e + 1] = {none, none, to, none, {}};
    ++live_edges_;
    return e;
}

WorkMesh::Index WorkMesh::add_face(FormId site) {
    Index f;
    if (free_faces_.empty()) {
        f = static_cast<Index>(faces_.size());
        faces_.emplace_back();
        if (are_boxes_current_) boxes_.add();
    } else {
        f = free_faces_.back();
        free_faces_.pop_back();
        Face& face = faces_[f];
        face.inner.clear();
        face.isolated.clear();
        face.alive = true;
    }
    faces_[f].site = site;
    faces_[f].outer = none;
    faces_[f].cuts = 0;
    faces_[f].box = {infinity, -infinity, infinity, -infinity};
    return f;
}

void WorkMesh::set_bounds(Index e) {
    const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;
    if (from == none)
        edges_[e].bounds = {kernel_.circle_box(edges_[e].curve), infinity, infinity};
    else
        edges_[e].bounds = kernel_.arc_bounds(edges_[e].curve, vertices_[from].point, vertices_[to].point);
    edges_[e].is_shorter = false;
}

// e keeps the part before p, the new edge takes the part after it. A closed edge becomes a loop at p and
// no edge is added. Returns the vertex.
WorkMesh::Index WorkMesh::split_edge(Index e, PointId p, FormId lowest) {
    const Index v = add_vertex(p, lowest);
    if (half_edges_[2 * e].origin == none) {
        --live_vertices_;  // the closed edge's own
        half_edges_[2 * e].origin = half_edges_[2 * e + 1].origin = v;
        vertices_[v].out = 2 * e;
        return v;
    }
    const Index h = 2 * e, t = h + 1, end = half_edges_[t].origin;
    const Index n = 2 * add_edge(edges_[e].curve, v, end, edges_[e].rim);
    split(h, v, n);
    vertices_[v].out = n;
    if (vertices_[end].out == t) vertices_[end].out = n + 1;
    edges_[n >> 1].ties = copy_ties(edges_[e].ties);
    edges_[n >> 1].challenger_ties = edges_[e].challenger_ties;
    edges_[n >> 1].stamp = edges_[e].stamp;
    return v;
}

void WorkMesh::remove_vertex(Index v) {
    vertices_[v].alive = false;
    free_vertices_.push_back(v);
}

void WorkMesh::remove_edge(Index e) {
    edges_[e].alive = false;
    free_edges_.push_back(e);
    --live_edges_;
}

void WorkMesh::remove_face(Index f) {
    faces_[f].alive = false;
    if (are_boxes_current_) boxes_.remove(f);
    free_faces_.push_back(f);
}

// Lets h run on over its successor, and drops the vertex between them.
void WorkMesh::join_with_next(Index h) {
    const Index n = next(h), v = half_edges_[n].origin, end = target(n);
    join(h);
    if (vertices_[end].out == twin(n)) vertices_[end].out = twin(h);
    remove_vertex(v);
    --live_vertices_;
    remove_edge(n >> 1);
    set_bounds(h >> 1);
}

void WorkMesh::add_ties(Index& list, std::initializer_list<FormId> present, FormId tied) {
    if (list == none) {
        list = static_cast<Index>(ties_.size());
        ties_.emplace_back();
    }
    std::vector<FormId>& forms = ties_[list];
    for (const FormId f : present)
        if (f.valid() && std::ranges::find(forms, f) == forms.end()) forms.push_back(f);
    if (std::ranges::find(forms, tied) == forms.end()) forms.push_back(tied);
}

WorkMesh::Index WorkMesh::copy_ties(Index list) {
    if (list == none) return none;
    ties_.push_back(std::vector<FormId>(ties_[list]));
    return static_cast<Index>(ties_.size() - 1);
}

void WorkMesh::clear() {
    vertices_.clear();
    half_edges_.clear();
    edges_.clear();
    faces_.clear();
    boxes_.clear();
    are_boxes_current_ = true;
    ties_.clear();
    free_vertices_.clear();
    free_edges_.clear();
    free_faces_.clear();
    live_vertices_ = live_edges_ = live_cycles_ = 0;
}

void WorkMesh::start(std::span<const FormId> lines, FormId site) {
    live_cycles_ = 2;
    const auto n = static_cast<Index>(lines.size());
    const auto side = [&](Index i) { return FormPair{CircleKernel::zero_form(), lines[i % n]}; };
    for (Index i = 0; i < n; ++i) {
        const auto corner = kernel_.intersection(side(i + n - 1), side(i), Sign::Positive, {0, 0});
        if (!corner)
            throw InternalError("the region's sides " + std::to_string(i) + " and its neighbour do not meet");
        vertices_[add_vertex(*corner, site)].is_corner = true;
    }
    add_face({});
    const Index f = add_face(site);
    for (Index i = 0; i < n; ++i) {
        const Index e = add_edge(side(i), i, (i + 1) % n, true);
        half_edges_[2 * e].label = site;
        half_edges_[2 * e].face = f;
        half_edges_[2 * e + 1].face = outside;
        vertices_[i].out = 2 * e;
        set_bounds(e);
        grow(faces_[f].box, edges_[e].bounds.box);
    }
    for (Index i = 0; i < n; ++i) {
        link(2 * i, 2 * ((i + 1) % n));
        link(2 * ((i + 1) % n) + 1, 2 * i + 1);
    }
    faces_[f].outer = 0;
    faces_[outside].inner.push_back(1);
    box_ = faces_[f].box;
    set_box(f);
    require_soundness();
}

// In builds with asserts: of what every change leaves, where many forms are inserted of some.
void WorkMesh::require_soundness([[maybe_unused]] std::size_t changes) const {
#ifndef NDEBUG
    constexpr std::size_t few = 64;
    if (changes > few && !std::has_single_bit(changes)) return;
    if (const auto defect = find_defect([&](Index e) { return edges_[e].alive; }))
        throw InternalError("a diagram of circular forms: " + *defect);
    for (Index h = 0; h < half_edges_.size(); ++h)
        if (edges_[h >> 1].alive && half_edges_[h].face != outside &&
            half_edges_[h].label != faces_[half_edges_[h].face].site)
            throw InternalError("half-edge h" + std::to_string(h) + " has another label than its face");
#endif
}

// Pre: the boundary of the face is complete.
void WorkMesh::set_box(Index face) {
    if (!are_boxes_current_) return;
    const Face& f = faces_[face];
    const auto [x, y, rx, ry] = box_middle(f.box);
    boxes_.set(face, kernel_.form(f.site), x, y, rx, ry);
}

void WorkMesh::renew_boxes() {
    are_boxes_current_ = true;
    boxes_.clear();
    for (Index f = 0; f < faces_.size(); ++f) {
        boxes_.add();
        if (f != outside && faces_[f].alive) set_box(f);
    }
}

// FaceBoxes has this bound, too, of faces whose boxes are there.
double WorkMesh::slope_bound(Index face, const KernelForm& form) const {
    const Face& f = faces_[face];
    const KernelForm& site = kernel_.form(f.site);
    const auto [x, y, rx, ry] = box_middle(f.box);
    return FaceBoxes::slope_bound(form, site, site.over_box(x, y, rx, ry), x, y, rx, ry);
}

}  // namespace vcell
