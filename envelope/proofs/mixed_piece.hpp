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
/// slopes and bends often tell that it is so nowhere inside (mixed_culling.cpp). Over a sphere, where forms
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
/// there forms that tie but for a scene's rounding (`noise_exponent`) are taken to tie, and listed. A saddle
/// whose value is not zero keeps two curves apart. Along the region's sides the same holds in one dimension.
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
#include "../../primitives/forms/heights.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../sphere/sphere_supports.hpp"
#include "floor_rule.hpp"
#include "tie_fan.hpp"

namespace vcell {

/// A line a x + b y + c = 0 of a piece's boundary, positive inside: one of the region's sides, or a seam.
struct PieceSide {
    double a, b, c;
    std::uint32_t id;  ///< index of the region's side, or a seam's id
};

using IntervalPoint = std::array<Interval, 2>;

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

class MixedAnalysis {
public:
    /// Narrower than this part of extent_at() a piece that is not plain counts as a point. Heights of
    /// competitors in it differ by about its square, beyond the digits of a double.
    static constexpr double floor_width = 0x1p-34;
    /// Pieces narrower than this may be taken for a fan around a point in which all competitors tie.
    static constexpr double tie_width = 0x1p-8;
    /// Two trisectors that avoid each other are told apart in pieces of this width or less: there an arc's
    /// direction is only that across its chord.
    static constexpr double node_width = 0x1p-22;
    /// Nearer than this to a point where gradients agree rounding hides how a trisector runs; so it is not
    /// divided further.
    static constexpr double chord_width = 0x1p-26;
    /// Wider pieces of a sphere are compared by supports: their errors are multiples of the heights', not of
    /// differences.
    static constexpr double supports_width = 0x1p-19;
    /// As floor_width, along a side, where no more than one direction has to be told apart.
    static constexpr double side_floor_width = 0x1p-44;

    MixedAnalysis(const FormFamily& family, double extent, const EnvelopeOptions& options = {});

    /// What widths about a place are parts of: the region's extent. Over a sphere, whose chart reaches the
    /// farther the nearer a vertex is to its pole, not that but the place's distance from the pole in the
    /// chart's unit there.
    double extent_at(const Interval& x, const Interval& y) const {
        if (!supports_) return extent_;
        const auto least = [](const Interval& i) { return std::max({0.0, i.lower(), -i.upper()}); };
        return std::min(extent_, 2 * (1 + least(x) * least(x) + least(y) * least(y)));
    }

    /// What tie_width is a part of: the same, but over a cylinder no more than its circumference. Otherwise
    /// all pieces of a long one would count as small, and be asked for ties that are not there.
    double tie_extent_at(const Interval& x, const Interval& y) const {
        const double extent = extent_at(x, y);
        return std::min(extent, heights_.family().chart.circumference());
    }

    const Heights& heights() const { return heights_; }
    Decisions& decisions() { return decisions_; }
    std::vector<Assumption>& assumptions() { return assumptions_; }
    /// The tie that the last seam was given up for.
    const std::optional<Assumption>& obstacle() const { return obstacle_; }

    /// The candidates that may be lowest, with a floor show, somewhere in the rectangle.
    std::vector<FormId> cull(const std::array<double, 4>& box, std::span<const FormId> candidates);

    /// How many times more the differences of what the last cull() left, about a box of these sides, change
    /// along x than along y. None where their gradients are not bounded.
    std::optional<double> steepness_across(double along_x, double along_y) const;
    /// Are they few, and do they change many times as much along x as along y, or the other way round? None
    /// if not. Pre: the base is a cylinder.
    std::optional<bool> asks_for_strips(const std::array<double, 4>& box) const;

    /// All forms that attain the minimum of the candidates where s and t meet.
    std::vector<FormId> lowest_at(const PieceSide& s, const PieceSide& t, std::span<const FormId> candidates);

    /// The labels along a side between two corners, from `first` to `last`. Seams must be crossed cleanly:
    /// none if forms tie on one otherwise than by crossing at a slope. Throws TieError if they tie along
    /// another side.
    std::optional<SideLabels> label_side(const PieceSide& side, const IntervalPoint& from,
                                         const IntervalPoint& to, FormId first, FormId last,
                                         std::vector<FormId> candidates, bool is_seam);
    /// The label right after the corner `from`, where several forms tie. Throws TieError if they do all
    /// along.
    FormId label_beside(const PieceSide& side, const IntervalPoint& from, const IntervalPoint& to,
                        std::span<const FormId> candidates);

    /// Were sides divided, or heights asked for with many digits, so often that forms all but coincide along
    /// a curve or an area?
    bool is_spent() const;

    /// The diagram of the forms that the last cull() left over the piece, if it is plain. Pre: that was about
    /// its box, and not asked before.
    std::optional<MixedPiece> resolve(const PieceBoundary& boundary);
    /// Those of them that may be lowest somewhere inside the piece, as resolve() came to know where it found
    /// no diagram.
    const std::vector<FormId>& remaining() const { return remaining_; }

private:
    static constexpr std::size_t usual_rivals = 8;

    struct Spread {  // over a box: a support, or value at the middle, gradient and values all over it
        FormId form;
        Support support;
        Interval v, gx, gy, range;
        /// Gradient at the middle, second derivatives all over the box, and the box less its middle.
        struct Bend {
            HeightJet<Interval> middle;
            HeightCurvature<Interval> curvature;
            Interval dx, dy;
        };
        std::optional<Bend> bend;
    };
    struct Line;

    // Over a sphere, unless the box is so small that rounding counts.
    bool compare_by_supports(double width, double extent) const {
        return supports_ && width > supports_width * extent;
    }
    void bend(const std::array<double, 4>& box, std::vector<Spread>& rivals) const;
    static std::array<Interval, 2> bent_gradient(const std::array<Interval, 2>& over, const Spread& a,
                                                 const Spread& b);
    bool is_above_twin(FormId f, FormId g, const Interval& X, const Interval& Y) const;
    std::vector<Spread> lowest_spreads(const std::array<double, 4>& box,
                                       std::span<const FormId> candidates) const;
    struct Rival {
        FormId form;
        Support support;
    };
    SmallVector<Rival, usual_rivals> lowest_supports(const NormalBox& box,
                                                     std::span<const FormId> candidates) const;
    bool have_twins(const SmallVector<Rival, usual_rivals>& rivals) const;
    std::vector<FormId> not_hidden(std::span<const FormId> candidates, const Interval& y) const;
    std::optional<FormId> certainly_lowest(const IntervalPoint& p, std::span<const FormId> candidates) const;
    struct Rivals {
        SmallVector<FormId, usual_rivals> forms;
        double least_slope;
    };
    Rivals rivals_along(const Line& line, double s0, double s1, std::span<const FormId> candidates);
    bool descend(const Line& line, double s0, FormId l0, double s1, FormId l1,
                 std::span<const FormId> candidates, bool is_seam, std::vector<RimTransition>& out);
    using Lowest = SmallVector<FormId, usual_rivals>;
    Lowest lowest_at(const Line& line, double s, std::span<const FormId> candidates);
    template <class Exactly>  // of the point, as a RationalPoint
    Lowest lowest_at(const IntervalPoint& p, std::span<const FormId> candidates, Exactly&& exactly);
    RimTransition locate(const Line& line, double s0, double s1, FormId before, FormId after,
                         double least_slope);
    RimTransition locate_rise(const Line& line, double s0, double s1, FormId before, FormId after,
                              double least_slope);
    struct Guess {
        double s, slope;
    };
    Guess approximate_root(const Line& line, double s0, double s1, FormId before, FormId after) const;
    std::optional<std::vector<RimTransition>> order_crossings(const Line& line, double s0, FormId l0,
                                                              double s1, FormId l1,
                                                              std::span<const FormId> forms);
    std::optional<RimTransition> find_tie(const Line& line, double s0, FormId l0, double s1, FormId l1,
                                          std::span<const FormId> forms);
    enum class Inside { No, Yes, Unknown };
    struct Change;
    struct Drawing;
    struct Work;
    void cull_by_curvature(Work& work);
    bool stays_above(const Work& work, const Spread& g, const Spread& f) const;
    void cull_from_rim(Work& work);
    void cull_sharply(Work& work);
    bool is_plain(const Work& work) const;
    bool join_changes(Work& work);
    struct Knot;
    static std::optional<Knot> forms_around_knot(const Work& work, std::uint32_t v);
    struct Apex;
    std::optional<Apex> find_apex(const Work& work);
    static std::optional<std::array<FormId, 3>> triple_in_one_point(const Work& work);
    std::optional<Apex> find_apex_in_line(const Work& work, Apex apex);
    void find_between(const Work& work, Apex& apex, int exponent);
    std::optional<double> ties_in_noise(const MixedPiece::Vertex& v, const std::array<FormId, 3>& forms,
                                        FormId other);
    std::optional<std::array<Wide, 2>> sharp_critical_point(FormId f, FormId g,
                                                            const Eigen::Vector2d& start) const;
    bool is_tie_in_space(const Work& work, const Apex& apex,
                         std::span<const std::array<std::size_t, 2>> touching) const;
    bool is_tie_of_planes(const Work& work, const Apex& apex) const;
    bool join_at_tie(Work& work);
    bool divide_arm(const Work& work, MixedPiece::Arc& arc, const Apex& apex, const FanArm& arm) const;
    bool join_at_saddle(Work& work);
    bool join_at_pinch(Work& work);
    bool join_without_touching(Work& work);
    bool join_all(Work& work, std::span<const Knot> knots);
    bool join_pair(Work& work, const Eigen::Vector2d& direction, FormId f, FormId g,
                   std::vector<Change>& ends);
    void join_at_center(Work& work);
    bool is_well_known(const Eigen::Vector2d& p, double error, std::span<const FormId> forms,
                       double extent) const;
    bool locate_vertex(const Work& work, const std::array<FormId, 3>& forms, MixedPiece::Vertex& v);
    static bool leave_one_end(const Work& work, const std::array<FormId, 3>& forms);
    Inside find_vertex(const Work& work, std::array<FormId, 3> forms, MixedPiece::Vertex& out);
    std::optional<std::array<Wide, 2>> sharp_vertex(const MixedPiece::Vertex& v,
                                                    const std::array<FormId, 3>& forms, int exponent = -240);
    bool settle_sharply(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms);
    std::optional<RationalPoint> exact_tie(std::span<const FormId> forms, const Wide& x, const Wide& y);
    bool settle_tie(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms);
    bool is_met(FormId f, const Interval& x, const Interval& y) const;
    std::optional<IntervalPoint> exact_touch(std::span<const FormId> touching, std::span<const FormId> ties,
                                             const std::array<Wide, 2>& at, const std::array<double, 4>& box);
    bool touch_in_vertex(Work& work, std::uint32_t vertex, std::span<const FormId> touching,
                         const std::array<Wide, 2>& at);
    std::optional<bool> shows_beside_floor(const Work& work, const MixedPiece::Vertex& v,
                                           const std::array<FormId, 3>& three);
    std::optional<Sign> sign_at_vertex(const MixedPiece::Vertex& v, std::array<FormId, 3> forms,
                                       FormId other);
    void assume(const Eigen::Vector2d& place, double width, std::vector<FormId> forms);

    Heights heights_;
    FloorRule rule_;
    std::optional<SphereSupports> supports_;  // over a sphere
    double extent_;
    Decisions decisions_;
    std::vector<Assumption> assumptions_;
    std::optional<Assumption> obstacle_;
    std::size_t stretches_ = 0;         // that sides were divided into
    std::size_t wide_before_side_ = 0;  // evaluations with many digits before the side in work
    std::vector<Spread> spreads_;       // of the forms that the last cull() left
    std::vector<FormId> remaining_;     // of these, after resolve()
    std::optional<DividedBox> parts_;   // of the last piece that was divided
    std::optional<NormalBox> normals_;  // over its box, if that is how they compare
};

}  // namespace vcell
