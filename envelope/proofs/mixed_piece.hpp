/// Small convex pieces of the region whose minimization diagram is decided by enclosures alone, for forms
/// that are not all circular.
///
/// Let a form compete in a convex piece if no other one is certainly lower all over it. The piece is plain
/// when
///
///   * for every two competitors the derivative of their difference in some direction keeps its sign: their
///     trisector has no closed component here and crosses every line of that direction at most once;
///   * for every three the Jacobian of their two differences is regular all over: by the mean value theorem
///     on a convex set, they are equal in one point at most. Or a combination of the two is nowhere zero:
///     then in none.
///
/// Both are needed only where two forms are equal and lowest, and all over a box around the points where
/// three are. Taylor's formula tells that box (height_difference.hpp); three forms that meet only where
/// another is lower need nothing, nor does a form that is lowest nowhere: if it is so nowhere on the rim,
/// slopes and bends often tell that it is so nowhere inside (piece_culling.hpp). Over a sphere, where forms
/// are compared cheaply (sphere_supports.hpp), the piece is looked at in parts, and most of them are left
/// out. What is said about lines then holds for each visible stretch of the trisector; where there is more
/// than one of them, it is asked of all of it.
///
/// Then the labels along the piece's boundary and the points in which three competitors are lowest determine
/// the diagram inside: on each trisector's graph the ends of its visible stretches alternate. In the common
/// cases (two changes of label, or three between three competitors) no point needs to be located to know it.
/// Other pieces are split. Along a side everything is one-dimensional: the same argument with slopes.
///
/// Forms that all but coincide are compared by the difference of their coefficients
/// (primitives/forms/twins.hpp): heights enclosed one by one are wider than what tells them apart.
///
/// Two heights have equal gradients where the objects touch from inside (equal cylinders with crossing axes):
/// the trisector has a node there and no piece around it is plain. If all competitors of a small piece tie in
/// such a point, or more than three of them in any point, the diagram is a fan around it (tie_fan.hpp),
/// decided once it is known that they tie: exactly where all trisectors split into planes, or in a point in
/// doubles, and else to 2^-200, listed as assumed. Where gradients in it are on one line faces end in cusps;
/// there, and in a node through which two further forms pass, forms that tie but for a scene's rounding
/// (`noise_exponent`) are taken to tie, and listed. A saddle of two forms whose value is not zero keeps two
/// curves apart. Along the region's sides the same holds in one dimension.
///
/// A form that comes down to the trisector of two others from above and ends there (touching.hpp) makes a
/// vertex with them, and no face. If it reaches through, its face is the lens between the two zeros of its
/// height above the trisector; and where it lies between the two from side to side, they meet between the
/// zeros, or nowhere. Located with many digits these zeros are vertices of the diagram however near to each
/// other they are, as long as doubles tell them apart. Where they do not, and the form is lowest over a strip
/// narrower than 2^-40 of the heights, the strip is taken for a point.
///
/// With a floor (EnvelopeOptions::floor) "lowest" reads "showing" in all of this (floor_rule.hpp): three
/// forms that tie have a face each around the vertex, and on a trisector's graph the ends of visible
/// stretches alternate as before. Ties of more forms, touching ones among them, are decided where none is of
/// the floor.
///
/// Coincidences below 2^-200, such strips, and what is left of pieces narrower than `floor_width` of the
/// region, are taken for points, counted in Decisions::assumed, and listed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "../../core/small_vector.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "competition.hpp"

namespace vcell {

/// A line a x + b y + c = 0 of a piece's boundary, positive inside: one of the region's sides, or a seam.
struct PieceSide {
    double a, b, c;
    std::uint32_t id;  ///< index of the region's side, or a seam's id
};

/// Where two sides meet.
IntervalPoint corner_of(const PieceSide& s, const PieceSide& t);

/// A change of label along a side, in the direction in which it is run; or a point where further forms tie.
struct RimTransition {
    FormId before, after;
    Eigen::Vector2d point;
    double error;
    std::vector<FormId> ties;  ///< all forms taken to meet here; empty: `before` and `after` only
};

/// The lowest forms along a side, counter-clockwise around the piece.
struct SideLabels {
    FormId first;
    std::vector<RimTransition> transitions;

    FormId last() const { return transitions.empty() ? first : transitions.back().after; }
    SideLabels reversed() const;
};

/// The labels around a piece: side i starts at corner i. They must outlive this view.
struct PieceBoundary {
    std::span<const PieceSide> sides;
    std::span<const IntervalPoint> corners;
    std::span<const SideLabels> labels;
    /// Forms that tie at corner i; empty where one form is lowest.
    std::span<const std::vector<FormId>> corner_ties;
};

/// The diagram of a plain piece. Vertices 0 .. rim - 1 lie on the boundary, counter-clockwise.
struct MixedPiece {
    struct Vertex {
        Eigen::Vector2d point;
        double error;
        FormId lowest;
        std::vector<FormId> ties;  ///< all that attain the minimum, if the faces around it do not tell
    };
    struct RimEdge {  // from rim vertex i to the next
        std::uint32_t side;
        FormId label;
    };
    struct Arc {
        std::uint32_t from, to;
        FormId left, right;
        Eigen::Vector2d direction;
        /// Stretches from one end to the other, if one direction and the piece's box will not do for all.
        std::vector<MinimizationDiagram::ArcPiece> pieces;
    };
    using HalfEdges = SmallVector<std::uint32_t, 4>;
    std::vector<Vertex> vertices;
    SmallVector<RimEdge, 8> rim;
    std::vector<Arc> arcs;
    /// The arcs' half-edges that leave each vertex (2k: arc k from its start, 2k + 1: from its end),
    /// counter-clockwise; on the rim from its edge to the next vertex on.
    std::vector<HalfEdges> leaving;
    std::array<double, 4> box;
};

}  // namespace vcell
