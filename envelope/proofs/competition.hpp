/// The forms that compete in one envelope: their heights, the floor among them, and what has been decided and
/// assumed of them. All proofs about pieces share one.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "../../core/small_vector.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "../sphere/sphere_supports.hpp"
#include "common_curves.hpp"
#include "floor_rule.hpp"

namespace vcell {

/// Narrower than this part of Competition::extent_at() a piece that is not plain counts as a point. Heights
/// of competitors in it differ by about its square, beyond the digits of a double.
inline constexpr double floor_width = 0x1p-34;
/// Pieces narrower than this may be taken for a fan around a point in which all competitors tie.
inline constexpr double tie_width = 0x1p-8;
/// Two trisectors that avoid each other are told apart in pieces of this width or less: there an arc's
/// direction is only that across its chord.
inline constexpr double node_width = 0x1p-22;
/// Nearer than this to a point where gradients agree rounding hides how a trisector runs; so it is not
/// divided further.
inline constexpr double chord_width = 0x1p-26;
/// Wider pieces of a sphere are compared by supports: their errors are multiples of the heights', not of
/// differences.
inline constexpr double supports_width = 0x1p-19;
/// Sides have this for a floor_width: no more than one direction has to be told apart along them.
inline constexpr double side_floor_width = 0x1p-44;

/// Pieces with more rivals are rarely plain, and their parts take longer than halves of them.
inline constexpr std::size_t most_divided = 4;
inline constexpr std::size_t usual_rivals = 8;

using IntervalPoint = std::array<Interval, 2>;

/// A form of a sphere's base over a box.
struct SupportRival {
    FormId form;
    Support support;
};
using SupportRivals = SmallVector<SupportRival, usual_rivals>;

/// Lists a coincidence that is taken for granted, once: false where it is known.
bool add_assumption(Assumption assumption, std::vector<Assumption>& known);

class Competition {
public:
    Competition(const FormFamily& family, double extent, const EnvelopeOptions& options = {});
    Competition(const Competition&) = delete;

    const Heights& heights() const { return heights_; }
    const FloorRule& rule() const { return rule_; }
    CommonCurves& common_curves() { return common_curves_; }
    const CommonCurves& common_curves() const { return common_curves_; }
    /// Over a sphere; else null.
    const SphereSupports* supports() const { return supports_ ? &*supports_ : nullptr; }
    Decisions& decisions() { return decisions_; }
    const Decisions& decisions() const { return decisions_; }
    std::vector<Assumption>& assumptions() { return assumptions_; }
    double extent() const { return extent_; }

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

    /// Are supports what compares: over a sphere, unless the box is so small that rounding counts?
    bool compare_by_supports(double width, double extent) const {
        return supports_ && width > supports_width * extent;
    }

    /// Counts a coincidence that is taken for granted about a place, and lists it.
    void assume(const Eigen::Vector2d& place, double width, std::vector<FormId> forms);

    /// The candidates without those that are known to be nowhere lowest over a rectangle, but where they tie
    /// with others; none if the family has no such forms.
    std::vector<FormId> not_hidden(std::span<const FormId> candidates, const Interval& x,
                                   const Interval& y) const;
    /// Over a sphere the lowest one at a point in doubles, if these tell.
    std::optional<FormId> certainly_lowest(const IntervalPoint& p, std::span<const FormId> candidates) const;
    /// Over a sphere those that may be lowest somewhere in a box. Supports are compared with errors that are
    /// parts of the heights: they do not tell twins apart.
    SupportRivals lowest_supports(const NormalBox& box, std::span<const FormId> candidates) const;
    bool have_twins(const SupportRivals& rivals) const;
    /// Is a form's height certainly one that its equation has, and below the tips of hollow cylinders over a
    /// plane, whose equations have other roots beyond?
    bool is_met(FormId f, const Interval& x, const Interval& y) const;
    /// Is an error of a place next to nothing, also where the place is lifted, which takes it times the
    /// steepest slope?
    bool is_well_known(const Eigen::Vector2d& p, double error, std::span<const FormId> forms,
                       double extent) const;

private:
    Heights heights_;
    FloorRule rule_;
    CommonCurves common_curves_{heights_, rule_};
    std::optional<SphereSupports> supports_;
    double extent_;
    Decisions decisions_;
    std::vector<Assumption> assumptions_;
};

/// What arguments about the forms that compete have at hand.
class CompetitionArgument {
protected:
    explicit CompetitionArgument(Competition& all)
        : all_(all),
          heights_(all.heights()),
          rule_(all.rule()),
          supports_(all.supports()),
          decisions_(all.decisions()),
          extent_(all.extent()) {}

    Competition& all_;
    const Heights& heights_;
    const FloorRule& rule_;
    const SphereSupports* supports_;  // over a sphere; else null
    Decisions& decisions_;
    double extent_;
};

}  // namespace vcell
