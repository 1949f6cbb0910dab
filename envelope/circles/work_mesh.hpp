/// The elements of a minimization diagram under construction, small and changed in place: what its vertices,
/// edges and faces are and stand for. Elements that have gone leave their numbers to new ones.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../../arrangement/dcel/half_edge_mesh.hpp"
#include "face_boxes.hpp"

namespace vcell {

struct WorkHalfEdge {
    std::uint32_t next, prev, origin, face;
    FormId label;  ///< the lowest form on its left; none outside the polygon
};

class WorkMesh : public HalfEdgeMesh<WorkHalfEdge> {
public:
    using HalfEdge = WorkHalfEdge;
    struct Vertex {
        PointId point;
        Index out = none;          ///< some half-edge that leaves it; none: isolated
        Index isolated_in = none;  ///< the face of an isolated vertex
        Index ties = none;  ///< index into ties_: all forms that attain the minimum, if not just the faces'
        Index challenger_ties = none;  ///< the same in the challenging diagram, while two are merged
        Index stamp = 0;
        Sign sign = Sign::Zero;  ///< of challenger - defender, while stamp is current
        bool alive = true;
        bool is_corner = false;       ///< of the polygon
        double x, y, error;           ///< as the kernel's point has them
        double height, height_error;  ///< encloses the minimum at the vertex
        // While stamp is current: the challenger's slope, and a lower bound of |challenger - defender|.
        double slope_x, slope_y, margin;
    };
    /// Half-edges 2e and 2e + 1; curve directs 2e. Rim curves are {zero_form, line}, inside on their left.
    struct Edge {
        FormPair curve;
        CircleKernel::ArcBounds bounds;
        Index ties = none, challenger_ties = none;
        Index stamp = 0;
        Index cut = none;  ///< while a form is inserted that crosses the edge: its vertex there
        Sign sign = Sign::Zero;
        bool rim = false;
        bool is_shorter = false;  ///< than when the bounds were found
        bool alive = true;
    };
    struct Face {
        FormId site;
        std::array<double, 4> box;
        Index outer = none;        ///< a half-edge of the outer boundary component
        std::vector<Index> inner;  ///< a half-edge of each inner boundary component
        std::vector<Index> isolated;
        Index stamp = 0;          ///< current: it has been walked through
        bool challenged = false;  ///< while stamp is current: is it one of those that the challenger reaches?
        Index cuts = 0;           ///< parts that have gone since the box was the face's own
        bool alive = true;
    };

    CircleKernel& kernel() const { return kernel_; }
    const std::vector<Vertex>& vertices() const { return vertices_; }
    const std::vector<Edge>& edges() const { return edges_; }
    const std::vector<Face>& faces() const { return faces_; }
    const std::vector<std::vector<FormId>>& ties() const { return ties_; }
    static constexpr Index outside = 0;  ///< the face around the polygon

    /// The curve along which half-edge h runs.
    FormPair directed(Index h) const {
        const FormPair c = edges_[h >> 1].curve;
        return h & 1u ? c.reversed() : c;
    }
    template <class Visit>
    void for_boundary(const Face& f, Visit&& visit) const {
        if (f.outer != none) for_cycle(f.outer, visit);
        for (const Index h : f.inner) for_cycle(h, visit);
    }

protected:
    explicit WorkMesh(CircleKernel& kernel) : kernel_(kernel) {}

    void clear();
    /// One face labelled `site` in the convex polygon of these lines. Pre: clear().
    void start(std::span<const FormId> lines, FormId site);

    Index add_vertex(PointId p, FormId lowest);
    void set_height(Vertex& v, FormId lowest) const;
    Index add_edge(FormPair curve, Index from, Index to, bool rim);
    Index add_face(FormId site);
    static void grow(std::array<double, 4>& box, const std::array<double, 4>& by) {
        box = {std::min(box[0], by[0]), std::max(box[1], by[1]), std::min(box[2], by[2]),
               std::max(box[3], by[3])};
    }
    void set_bounds(Index e);
    Index split_edge(Index e, PointId p, FormId lowest);
    void join_with_next(Index h);
    void remove_vertex(Index v);
    /// Leaves its number to another one; where it hangs is told elsewhere.
    void remove_edge(Index e);
    void remove_face(Index f);
    void add_ties(Index& list, std::initializer_list<FormId> present, FormId tied);
    Index copy_ties(Index list);

    // Centre and half sides of a box, the sides rounded up.
    static std::array<double, 4> box_middle(const std::array<double, 4>& box) {
        const double x = 0.5 * box[0] + 0.5 * box[1], y = 0.5 * box[2] + 0.5 * box[3];
        return {x, y, Interval::up(std::max(box[1] - x, x - box[0])),
                Interval::up(std::max(box[3] - y, y - box[2]))};
    }
    void set_box(Index face);
    void renew_boxes();
    double slope_bound(Index face, const KernelForm& form) const;

    long component_count() const { return (live_vertices_ - live_edges_ + live_cycles_) / 2; }
    void require_soundness(std::size_t changes = 0) const;

    CircleKernel& kernel_;
    std::vector<Vertex> vertices_;
    std::vector<Edge> edges_;
    std::vector<Face> faces_;
    FaceBoxes boxes_;  // of the faces, unless some have changed since
    bool are_boxes_current_ = true;
    std::array<double, 4> box_;  // of the polygon
    std::vector<std::vector<FormId>> ties_;
    // A closed edge without vertices counts as one vertex and one edge; isolated vertices do not count.
    long live_vertices_ = 0, live_edges_ = 0, live_cycles_ = 0;

private:
    std::vector<Index> free_vertices_, free_edges_, free_faces_;
};

}  // namespace vcell
