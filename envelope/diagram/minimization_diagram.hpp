/// The minimization diagram: the plane region of a chart, divided by which function is lowest.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../../arrangement/dcel/dcel.hpp"
#include "../../core/errors.hpp"
#include "../../core/numbers/sign.hpp"
#include "../../primitives/forms/form_family.hpp"
#include "../../primitives/forms/ring_ties.hpp"

namespace vcell {

/// A convex polygon with at least three sides, counter-clockwise: side i is the line
/// a x + b y + c = 0 from corner i to corner i + 1, positive inside; coefficients are taken as exact.
struct ConvexRegion {
    struct Side {
        double a, b, c;
    };
    std::vector<Side> sides;

    static ConvexRegion rectangle(double x0, double y0, double x1, double y1) {
        return {{{0, 1, -y0}, {-1, 0, x1}, {0, -1, y1}, {1, 0, -x0}}};
    }
};

/// Forms that were taken to be equal in one point because no digits at hand told them apart.
struct Assumption {
    Eigen::Vector2d place;      ///< chart coordinates
    double width;               ///< what was not resolved is no wider than this
    std::vector<FormId> forms;  ///< those that may meet there
};

/// Forms that seem to tie along a curve, which no number of pieces decides.
struct TieError : UndecidedError {
    explicit TieError(Assumption tie)
        : UndecidedError("forms seem to tie along a curve around (" + std::to_string(tie.place.x()) + ", " +
                         std::to_string(tie.place.y()) + ") of the chart"),
          tie(std::move(tie)) {}

    Assumption tie;  ///< what was met where it was given up
};

/// How a diagram came about.
struct EnvelopeWork {
    std::uint64_t insertions = 0;  ///< forms inserted into a diagram, of a piece of the region or of discs
    std::uint64_t merges = 0;      ///< pairs of diagrams overlaid and merged
    std::uint64_t pieces = 0;      ///< pieces of the region that certified subdivision came down to

    friend bool operator==(const EnvelopeWork&, const EnvelopeWork&) = default;
    EnvelopeWork& operator+=(const EnvelopeWork& other) {
        insertions += other.insertions;
        merges += other.merges;
        pieces += other.pieces;
        return *this;
    }
};

/// Every vertex, edge and face carries as label all functions that attain the minimum there.
///
/// The unbounded face (Dcel::unbounded_face()) lies outside the region and has no label. Edges are
/// maximal: between two vertices, or closed without vertices. A vertex on the region's rim is a corner
/// or a point where the label changes.
///
/// Over a sphere base the chart's unbounded face is the one around the pole: it has a label, and there is no
/// rim. Over a cylinder base, unrolled to x in [-1, 3], x = -1 and x = 3 are the same line and nothing shows
/// there: points have x in [-1, 3), an arc may pass from one side to the other between two of its pieces. The
/// rims are sides 0 (lower y) and 2; outside them lie faces 0 and 1, without label. Which of the boundaries
/// of a face is called its outer one has no meaning over curved bases.
struct MinimizationDiagram {
    struct Vertex {
        Eigen::Vector2d point;  ///< chart coordinates
        double error;           ///< bound on the distance of `point` from the true vertex
        double height;          ///< the minimum at `point`
        double height_error;    ///< bound on its distance from the minimum at the true vertex
    };
    /// The arc of half-edge 2e. Inner edges lie on {left = right}, left being lower on the left side; where
    /// has_lower_across() says so, left is the form of the face on the right.
    /// Rim edges have the region on their left: right is none and `side` is the region's side.
    struct Edge {
        FormId left, right;
        std::uint32_t side = UINT32_MAX;

        bool on_rim() const { return side != UINT32_MAX; }
    };

    /// A piece of an arc whose forms are not both circular. It ends at `end` (the last piece of an edge at
    /// the edge's target, of a closed edge where the first piece starts), and lies in a convex cell around
    /// it. All along it the derivative of left - right, or of its product with a positive function, in
    /// `direction` (a unit vector) is positive, so each line in that direction meets it at most once. Over a
    /// plane and a cylinder the derivative is positive all over the cell, which holds nothing else of the
    /// curve left = right; over a sphere parts of that may cross the cell on which a third form is lower.
    struct ArcPiece {
        Eigen::Vector2d end;
        double error;  ///< bound on the distance of `end` from the curve
        Eigen::Vector2d direction;
        std::array<double, 4> box;  ///< {x0, x1, y0, y1} contains the cell
    };

    Dcel dcel;
    ConvexRegion region;
    IdVector<FormId, CircularForm> forms;
    std::vector<CylinderForm> cylinders;  ///< the forms after those, as in FormFamily
    std::vector<RadialForm> radial;       ///< likewise
    IdVector<VertexId, Vertex> vertices;
    IdVector<EdgeId, Edge> edges;
    IdVector<FaceId, FormId> face_forms;
    Decisions decisions;
    EnvelopeWork work;
    std::vector<Assumption> assumptions;
    /// Over a cylinder: forms that tie along edges y = const, and have no face there. No label has them.
    std::vector<RingTie> ring_ties;

    /// The functions that attain the minimum at v (on e), ascending.
    std::span<const FormId> label(VertexId v) const {
        return slice(vertex_labels_, vertex_offsets_, v.value);
    }
    std::span<const FormId> label(EdgeId e) const { return slice(edge_labels_, edge_offsets_, e.value); }
    /// The one function of a face; empty for the unbounded face. (Identical functions are one FormId.)
    std::span<const FormId> label(FaceId f) const {
        return face_forms[f].valid() ? std::span(&face_forms[f], 1) : std::span<const FormId>();
    }
    /// The pieces of an edge in the direction of half-edge 2e; none where both forms are circular, and on the
    /// rim.
    std::span<const ArcPiece> pieces(EdgeId e) const {
        if (piece_offsets_.empty()) return {};
        return {pieces_.data() + piece_offsets_[e.value], pieces_.data() + piece_offsets_[e.value + 1]};
    }
    bool is_circular(FormId f) const { return f.value < forms.size(); }
    bool is_of_floor(FormId f) const { return std::ranges::find(floor, f) != floor.end(); }
    /// Is the lower form of these two on the other one's side of an edge between them? So it is where the
    /// diagram is of the greater one.
    bool has_lower_across(FormId left, FormId right) const {
        if (floor.empty()) return false;
        const bool l = is_of_floor(left), r = is_of_floor(right);
        return (l && r) || (!is_below_floor && (l || r));
    }
    /// On which side of an edge the face of its left (0) or right form lies; and the other way round.
    unsigned side_of(EdgeId e, unsigned form) const {
        return !edges[e].on_rim() && has_lower_across(edges[e].left, edges[e].right) ? 1 - form : form;
    }
    /// The form of the face on the left (side 0) or right of an edge.
    FormId form_beside(EdgeId e, unsigned side) const {
        return side_of(e, side) == 0 ? edges[e].left : edges[e].right;
    }
    /// Where half-edge 2e begins and ends; none where the edge is closed.
    VertexId start(EdgeId e) const { return dcel.origin(Dcel::half_edge(e)); }
    VertexId end(EdgeId e) const { return dcel.target(Dcel::half_edge(e)); }
    /// On the left (side 0) or right of an edge.
    FaceId face(EdgeId e, unsigned side) const { return dcel.face(Dcel::half_edge(e, side)); }
    /// The sides of the region on which vertex v lies (none, one, or two at a corner).
    std::span<const std::uint32_t> sides(VertexId v) const {
        return {vertex_sides_.data() + side_offsets_[v.value],
                vertex_sides_.data() + side_offsets_[v.value + 1]};
    }

    /// Forgets all forms; the subdivision stays.
    void clear_labels() {
        forms.clear();
        cylinders.clear();
        radial.clear();
        for (Edge& e : edges) e.left = e.right = {};
        for (FormId& f : face_forms) f = {};
        vertex_labels_.clear();
        edge_labels_.clear();
        std::ranges::fill(vertex_offsets_, 0u);
        std::ranges::fill(edge_offsets_, 0u);
    }

    std::vector<FormId> vertex_labels_, edge_labels_;
    std::vector<ArcPiece> pieces_;
    std::vector<std::uint32_t> piece_offsets_;  // empty: no edge has pieces
    std::vector<std::uint32_t> vertex_offsets_, edge_offsets_, vertex_sides_, side_offsets_;
    std::vector<FormId> floor;    ///< as EnvelopeOptions::floor
    bool is_below_floor = false;  ///< likewise

private:
    static std::span<const FormId> slice(const std::vector<FormId>& flat,
                                         const std::vector<std::uint32_t>& offsets, std::uint32_t i) {
        return {flat.data() + offsets[i], flat.data() + offsets[i + 1]};
    }
};

struct EnvelopeOptions {
    /// Called now and then with the fraction done, in [0, 1]; may throw to cancel.
    std::function<void(double)> progress;
    unsigned threads = 1;  ///< 0: as many as the machine has cores. The diagram is the same for any number
    /// Where more functions than this compete in a piece of the region that is not divided further, the
    /// diagrams of two halves of them are merged by overlay; if it is less than 64, nothing larger than such
    /// a piece is solved as a whole. Changes the time taken only, not the diagram.
    std::size_t largest_piece = 64;
    /// Over a sphere without cylinders: first by insertion of one form after the other (sphere_diagram.hpp).
    /// Changes the time taken only.
    bool incremental = true;
    /// Forms that are sides of the box. The axis of a cylinder may all but lie on one of these, which then
    /// tells nothing of the cell's size in other directions. Changes the time taken only.
    std::vector<FormId> box_sides;
    /// Forms that do not compete: their upper envelope is a floor. The diagram is that of the
    /// greater one of it and of the lower envelope of the others, or of the lesser one if it
    /// `is_below_floor`: where the floor is the greater one rays that begin there have been met before. Not
    /// over a sphere; over a plane circular forms.
    std::vector<FormId> floor;
    bool is_below_floor = false;
};

/// The lower envelope of the forms over the region, exact.
/// Pre: no two forms are the same function (merge duplicates first); the region is not empty.
/// Throws TieError where forms tie along a curve without crossing.
/// Without forms: one face without label.
MinimizationDiagram lower_envelope(const FormFamily& family, const ConvexRegion& region,
                                   const EnvelopeOptions& options = {});

/// The lower envelope of radial and circular forms in a stereographic chart over the whole sphere.
/// Pre: near the pole one form is certainly lowest (radial_base_problem() sees to that).
MinimizationDiagram lower_envelope_on_sphere(const FormFamily& family, const EnvelopeOptions& options = {});

/// The lower envelope of radial forms over a cylinder, y0 <= y <= y1, all around.
MinimizationDiagram lower_envelope_on_cylinder(const FormFamily& family, double y0, double y1,
                                               const EnvelopeOptions& options = {});

/// The form that is lowest at a point given in doubles, exact; the first of those that tie.
FormId lowest_form(const FormFamily& family, double x, double y);

}  // namespace vcell
