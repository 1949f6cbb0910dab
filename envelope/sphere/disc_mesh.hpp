/// A subdivision of the sphere into discs, the faces of linear forms: vertices of three edges each,
/// half-edges, edges with what is known of their arcs, and faces. Numbers of what was removed are given to
/// what comes next.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "../../arrangement/dcel/half_edge_mesh.hpp"
#include "../../core/errors.hpp"
#include "../../core/small_vector.hpp"
#include "sphere_trees.hpp"

namespace vcell::discs {

struct DiscHalfEdge {
    Index next, prev, origin, face;
};

class DiscMesh : protected HalfEdgeMesh<DiscHalfEdge> {
protected:
    struct Vertex : Mark {
        std::array<Index, 3> forms{};
        Index out = none;   // while a form is inserted: the edge of its face that leaves here
        Index stamp = 0;    // current: compared with the challenger
        Index taken = 0;    // current: the challenger is lower
        Index ties = none;  // the list of forms that tie here and came later
    };
    // normal.p = offset on the circle; half-edge 2e runs counter-clockwise about the normal.
    struct Edge {
        Vector3d normal = Vector3d::Zero();
        double offset = 0, square = 0, length = 0;  // square and length: of the normal
        double error = 0;                           // as Linear's, of normal and offset
        double apex_blur = 0;                       // what that changes about the apex
        // Where the tangents in the ends of a short arc meet: with those ends a triangle about the arc. Of a
        // long arc there is infinite doubt.
        Mark apex;
        Index stamp = 0;
        Index cut = none;       // while a form is inserted that crosses the edge: its vertex there
        Index ties = none;      // the list of forms that tie along the circle and came later
        bool is_point = false;  // certainly: both ends are the same point, and all of the edge
    };
    struct Face {            // of the form of the same number
        Index start = none;  // none: the form has no face
        Index stamp = 0;     // current: may conflict with the challenger
        bool is_in_hemisphere = false, is_hemisphere_known = false;
        // For the tree:
        bool is_ball_known = false;  // since the face was cut
        BoundingBall ball;           // both hold the face
        Cap cap;
        double top = HUGE_VAL;  // upper bound of the form over the face
    };

    using SomeIndices = SmallVector<Index, 32>;

    Index left(Index h) const { return half_edges_[h].face; }
    Index right(Index h) const { return half_edges_[twin(h)].face; }
    template <class Visit>
    void for_boundary(Index face, Visit&& visit) const {
        for_cycle(faces_[face].start, visit);
    }

    template <class T>
    static Index add(std::vector<T>& all, SomeIndices& free, const T& element) {
        if (free.empty()) {
            all.push_back(element);
            return static_cast<Index>(all.size() - 1);
        }
        const Index i = free.back();
        free.pop_back();
        all[i] = element;
        return i;
    }
    Index add_edge(const Edge& edge) {
        const Index e = add(edges_, free_edges_, edge);
        if (half_edges_.size() < 2 * edges_.size()) half_edges_.resize(2 * edges_.size());
        return e;
    }
    // Half-edges from `first` up to `last`, which stays, and the vertices they leave.
    void remove(Index first, Index last) {
        Index h = first;
        do {
            remove_edge(h >> 1);
            remove_vertex(half_edges_[h].origin);
            h = half_edges_[h].next;
        } while (h != last);
    }
    void remove_vertex(Index v) {
        if (vertices_[v].is_gone()) return;
        vertices_[v].remove();
        if (vertex_tree_)
            vertex_tree_->remove(v);
        else
            vertex_rows_.remove(v);
        free_vertices_.push_back(v);
    }
    void remove_edge(Index e) {
        if (edges_[e].apex.is_gone()) return;
        edges_[e].apex.remove();
        if (!vertex_tree_) apex_rows_.remove(e);
        free_edges_.push_back(e);
    }

    // In builds with asserts: between insertions.
    void require_soundness() const {
#ifndef NDEBUG
        if (const auto defect = find_defect([&](Index e) { return !edges_[e].apex.is_gone(); }))
            throw InternalError("a diagram of discs: " + *defect);
#endif
    }

    std::vector<Vertex> vertices_;
    std::vector<Edge> edges_;
    std::vector<Face> faces_;
    SomeIndices free_vertices_, free_edges_;
    // Of small diagrams: what of the vertices and of the edges' apexes most forms are compared with.
    MarkRows vertex_rows_, apex_rows_;
    // Of large diagrams. The vertices tell where most forms win; faces are looked at when they do not.
    std::optional<VertexTree> vertex_tree_;
    std::optional<FaceTree> face_tree_;
};

}  // namespace vcell::discs
