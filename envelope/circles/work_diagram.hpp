/// A minimization diagram under construction, small and changed in place.
///
/// Its faces are compared with a challenger (the paper's comparison of two surfaces over an overlay face,
/// [HE, section 2.1]): where the challenger wins, its arcs are inserted, the face relabelled and edges
/// between equal labels removed. A diagram that consists of one face needs no overlay, so sites can be merged
/// in one at a time without ever computing the crossing of two unrelated trisectors: all faces are compared,
/// or, where sites come in the order of K, those that a walk leads to (work_walk.cpp). The general merge
/// takes the overlay of two diagrams and a challenger for each of its faces.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../arrangement/circles/circle_arcs.hpp"
#include "../../arrangement/circles/circle_kernel.hpp"
#include "../../arrangement/dcel/half_edge_mesh.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "face_boxes.hpp"

namespace vcell {

struct WorkHalfEdge {
    std::uint32_t next, prev, origin, face;
    FormId label;  ///< the lowest form on its left; none outside the polygon
};

class WorkDiagram : public HalfEdgeMesh<WorkHalfEdge> {
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

    explicit WorkDiagram(CircleKernel& kernel) : kernel_(kernel) {}

    /// One face labelled `site` in the convex polygon of these lines (counter-clockwise, positive inside).
    /// Pre: the lines are forms of the kernel; consecutive ones meet in the polygon's corners.
    void start(std::span<const FormId> lines, FormId site);

    /// Merges in one more form.
    void insert(FormId challenger);

    /// insert(), but by walking there from a vertex: that takes what changes and the way, not all there is.
    /// Returns a vertex near the form's face, or where the way ended. Pre: no form of the diagram has a
    /// greater K than the challenger, exactly; there is no floor; is_on_way(from).
    Index insert_most_curved(FormId challenger, Index from);
    /// May one set out from here? Vertices that are no more are asked about, too.
    bool is_on_way(Index v) const {
        return v < vertices_.size() && vertices_[v].alive && vertices_[v].out != none;
    }
    /// A vertex from which one may. Pre: start().
    Index any_on_way() const {
        Index v = 0;
        while (!is_on_way(v)) ++v;
        return v;
    }
    /// What walks and comparisons have taken since start(), in half-edges passed, about.
    std::size_t visit_count() const { return visits_; }
    /// Since then: has a form been compared with a face of many holes, all of which are looked at each time?
    bool is_holey() const { return is_holey_; }

    /// Forms of the kernel from `first` on are a floor (EnvelopeOptions::floor): they are inserted where they
    /// are greater than what is there. `is_below`: the diagram's edges between a floor and other forms have
    /// the lesser of the two on either side. Stays until it is set again; none: there is no floor.
    void set_floor(FormId first, bool is_below) {
        first_floor_ = first;
        is_below_floor_ = is_below;
    }

    /// Becomes the diagram of the forms of both, by overlay. Pre: neither is this one; both have this
    /// one's kernel, the same polygon, and no form in common.
    void merge(const WorkDiagram& defender, const WorkDiagram& challenger);

    CircleKernel& kernel() const { return kernel_; }
    const std::vector<Vertex>& vertices() const { return vertices_; }
    const std::vector<Edge>& edges() const { return edges_; }
    const std::vector<Face>& faces() const { return faces_; }
    const std::vector<std::vector<FormId>>& ties() const { return ties_; }
    static constexpr Index outside = 0;  ///< the face around the polygon

private:
    // A floor's form takes over where it is greater: then `challenger - defender` of what follows is that of
    // the two in turn, so that it is negative where the challenger wins here, too.
    bool is_floor(FormId f) const { return first_floor_.valid() && f >= first_floor_; }
    FormPair rivals(FormId challenger, FormId defender) const {
        return inserts_greater_ ? FormPair{defender, challenger} : FormPair{challenger, defender};
    }
    FormId challenger_of(FormPair rival) const { return inserts_greater_ ? rival.g : rival.f; }
    FormId defender_of(FormPair rival) const { return inserts_greater_ ? rival.f : rival.g; }
    // The curve between two labels, the lesser form on its left.
    FormPair between(FormId left, FormId right) const {
        const bool l = is_floor(left), r = is_floor(right);
        return (l && r) || (!is_below_floor_ && (l || r)) ? FormPair{right, left} : FormPair{left, right};
    }

    struct Duel {  // a face and who challenges it
        Index face;
        FormId challenger;
        double slope = HUGE_VAL;  // upper bound of |challenger - defender|'s slope on the boundary, if known
        bool met = false;         // the challenger wins or ties somewhere on the boundary
        bool changed = false;     // and takes over a part of the face
    };
    // A face of which a part goes: from the first of these half-edges of its boundary to the second.
    struct Bite {
        Index face, leaving, returning;     // none: all of it
        std::size_t first_corner, corners;  // outside: those of the polygon that the part reaches around
    };
    struct Corner {
        Index vertex;
        FormPair after;  // the curve of the rim from there on, seen from outside
    };
    struct Branch {    // {challenger = defender} leaves a vertex into the face, or ends there
        Index corner;  // the boundary half-edge that arrives at the vertex
        Index vertex;
        bool start;  // leaves, when run with the challenger on its left
        Index half_edge = none;
    };
    struct Cut {
        PointId point;
        bool touching;
    };

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

    struct Layer;  // a diagram as an input of overlay()

    void clear();
    Index add_vertex(PointId p, FormId lowest);
    void set_height(Vertex& v, FormId lowest) const;
    Index add_edge(FormPair curve, Index from, Index to, bool rim);
    Index add_face(FormId site);
    static void grow(std::array<double, 4>& box, const std::array<double, 4>& by) {
        box = {std::min(box[0], by[0]), std::max(box[1], by[1]), std::min(box[2], by[2]),
               std::max(box[3], by[3])};
    }
    void set_bounds(Index e);
    void kill_edge(Index e);
    Index split_edge(Index e, PointId p, FormId lowest);
    const KernelPoint& at(Index v) const { return kernel_.point(vertices_[v].point); }
    void add_ties(Index& list, std::initializer_list<FormId> present, FormId tied);
    Index copy_ties(Index list);

    void resolve();
    void divide_faces();
    // Centre and half sides of a box, the sides rounded up.
    static std::array<double, 4> box_middle(const std::array<double, 4>& box) {
        const double x = 0.5 * box[0] + 0.5 * box[1], y = 0.5 * box[2] + 0.5 * box[3];
        return {x, y, Interval::up(std::max(box[1] - x, x - box[0])),
                Interval::up(std::max(box[3] - y, y - box[2]))};
    }
    double slope_bound(Index face, const KernelForm& form) const;
    void renew_boxes();
    Index walk(FormId challenger, Index from);
    bool cut_in(FormId challenger, Index v);
    bool find_bites(FormId challenger, Index v);
    double steepening(FormPair rival) const;
    bool surely_keeps_sign(Index e, FormPair rival, Sign common);
    std::optional<Cut> first_root(Index e, FormPair rival, Sign common);
    Cut change_of_sign(Index e, FormPair rival, Sign turn);
    Eigen::Vector2d chord_middle(Index e) const {
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        return {0.5 * (p.x + q.x), 0.5 * (p.y + q.y)};
    }
    void challenge_from(FormId challenger, Index v);
    bool is_above_diagram(FormId challenger, Index v) const;
    Layer make_layer(CircleArcs& geometry) const;
    void unite_ties();
    void smooth(Index v);
    void decide_boundary(Duel& d);
    void set_box(Index face);
    bool steadily_keeps_sign(const Edge& edge, const Vertex& v, const Vertex& w, const Duel& d,
                             double K) const;
    bool keeps_sign(Index e, FormPair rival, Sign common) const;
    Sign vertex_sign(Index v, FormPair rival) {
        return vertices_[v].stamp == stamp_ ? vertices_[v].sign : find_vertex_sign(v, rival);
    }
    Sign find_vertex_sign(Index v, FormPair rival);
    bool decide_edge(Index e, FormPair rival);
    bool cut_edge(Index e, FormPair rival, std::span<const Cut> cuts, Sign before);
    void divide_face(Duel& d);
    void find_branches(Index cycle, FormPair rival);
    void insert_arcs(FormPair rival);
    void insert_island(Duel& d, Sign boundary);
    void thread_isolated(Index face, std::size_t first_new);
    /// Who wins beside half-edge h of the duel's face, on its left.
    FormId winner(Index h, const Duel& d) {
        const Sign s = edges_[h >> 1].sign;
        if (s == Sign::Zero) return winner_along(h, d);
        return s == Sign::Negative ? d.challenger : faces_[d.face].site;
    }
    FormId winner_along(Index h, const Duel& d);
    void remove_inner_edges();
    void join_with_next(Index h);
    void remove_vertex(Index v);
    void require_soundness() const;
    void rebuild_faces();
    void nest_cycles();

    bool cycle_contains(Index cycle, PointId p);
    bool face_contains(const Face& f, PointId p);
    int crossings_above(Index e, PointId p);
    bool is_outer_cycle(Index cycle);
    PointId point_on(Index cycle);
    long component_count() const { return (live_vertices_ - live_edges_ + live_cycles_) / 2; }

    CircleKernel& kernel_;
    std::vector<Vertex> vertices_;
    std::vector<Edge> edges_;
    std::vector<Face> faces_;
    FaceBoxes boxes_;  // of the faces, unless forms have been inserted by walking since
    bool are_boxes_current_ = true;
    // Since start(): half-edges passed; forms inserted by walking, and those sought in all faces in the end.
    std::size_t visits_ = 0, walks_ = 0, scans_ = 0;
    bool is_holey_ = false;
    std::array<double, 4> box_;  // of the polygon
    std::vector<std::vector<FormId>> ties_;
    std::vector<Index> free_vertices_, free_edges_, free_faces_;
    Index stamp_ = 0;
    FormId first_floor_;
    bool is_below_floor_ = false;
    bool inserts_greater_ = false;  // the challenger of this resolve() takes over where it is greater
    bool merging_ =
        false;  // resolve() compares two diagrams: every face has a challenger, and all are made anew
    // A closed edge without vertices counts as one vertex and one edge; isolated vertices do not count.
    long live_vertices_ = 0, live_edges_ = 0, live_cycles_ = 0;

    // Working space of one resolve(), kept for its memory.
    std::vector<Duel> duels_;
    std::vector<Bite> bites_;
    std::vector<Corner> corners_;
    std::vector<Index> new_edges_;
    std::vector<Index> reached_;  // faces beyond edges on which a duel's challenger wins or ties
    std::vector<Branch> branches_;
    std::vector<Index> touched_;   // half-edges of changed faces
    std::vector<Index> cycles_;    // a half-edge of each new boundary component
    std::vector<Index> isolated_;  // isolated vertices that need a face
};

}  // namespace vcell
