/// The labels along the sides of pieces, where everything is one-dimensional.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "competition.hpp"
#include "mixed_piece.hpp"
#include "side_crossings.hpp"
#include "side_roots.hpp"

namespace vcell {

/// What labelling sides has cost.
struct SideEffort {
    std::size_t stretches = 0;  ///< that sides were divided into
    std::size_t wide = 0;       ///< evaluations of heights with many digits

    SideEffort operator+(const SideEffort& o) const { return {stretches + o.stretches, wide + o.wide}; }
    friend bool operator==(const SideEffort&, const SideEffort&) = default;
    /// Is it so much that forms all but coincide along a curve or an area?
    bool is_too_much(std::size_t forms) const;
};

/// Are two forms over a plane one function along a side, between these places? Exact.
bool are_one_along(const FormFamily& family, const PieceSide& side, const Eigen::Vector2d& from,
                   const Eigen::Vector2d& to, FormId f, FormId g, Decisions& decisions);

class SideLabelling : CompetitionArgument {
public:
    /// `before`: by others, to which what is spent here comes on top.
    explicit SideLabelling(Competition& all, const SideEffort& before = {})
        : CompetitionArgument(all),
          crossings_(all),
          roots_(all),
          before_(before),
          wide_at_start_(all.heights().wide_evaluations()) {}

    /// All forms that attain the minimum of the candidates where s and t meet.
    std::vector<FormId> lowest_at(const PieceSide& s, const PieceSide& t, std::span<const FormId> candidates);

    /// The labels along a side between two corners, from `first` to `last`. Seams must be crossed cleanly:
    /// none if forms tie on one otherwise than by crossing at a slope. Of forms that are one function along
    /// another side the label is the one that is lowest next to it inside, if that is the same one all along.
    /// Throws TieError if they tie along it otherwise.
    std::optional<SideLabels> label_side(const PieceSide& side, const IntervalPoint& from,
                                         const IntervalPoint& to, FormId first, FormId last,
                                         std::vector<FormId> candidates, bool is_seam);
    /// The label right after the corner `from`, where several forms tie. Throws TieError if they do all
    /// along.
    FormId label_beside(const PieceSide& side, const IntervalPoint& from, const IntervalPoint& to,
                        std::span<const FormId> candidates);

    /// The tie that the last seam was given up for.
    const std::optional<Assumption>& obstacle() const { return obstacle_; }
    SideEffort effort() const { return {stretches_, heights_.wide_evaluations() - wide_at_start_}; }
    bool is_spent() const { return (before_ + effort()).is_too_much(heights_.family().size()); }

private:
    struct Rivals {
        SmallVector<FormId, usual_rivals> forms;
        double least_slope;
    };
    Rivals rivals_along(const SideLine& line, double s0, double s1, std::span<const FormId> candidates);
    bool descend(const SideLine& line, double s0, FormId l0, double s1, FormId l1,
                 std::span<const FormId> candidates, bool is_seam, std::vector<RimTransition>& out);
    bool are_one_along(const SideLine& line, double s0, double s1, FormId f, FormId g);
    void add_if_one(const SideLine& line, double s0, double s1, FormId f, RimTransition& t);
    template <class Forms>
    bool leave_lowest_inside(const SideLine& line, double s0, double s1, double t0, double t1, Forms& forms);
    void leave_out_between(const IntervalPoint& range, FormId l0, FormId l1,
                           SmallVector<FormId, usual_rivals>& forms);
    using Lowest = SmallVector<FormId, usual_rivals>;
    Lowest lowest_at(const SideLine& line, double s, std::span<const FormId> candidates);
    template <class Exactly>  // of the point, as a RationalPoint
    Lowest lowest_at(const IntervalPoint& p, std::span<const FormId> candidates, Exactly&& exactly);

    SideCrossings crossings_;
    SideRoots roots_;
    std::optional<Assumption> obstacle_;
    const SideEffort before_;
    std::size_t stretches_ = 0;
    const std::size_t wide_at_start_;   // evaluations with many digits by then
    std::size_t wide_before_side_ = 0;  // before the side in work
};

}  // namespace vcell
