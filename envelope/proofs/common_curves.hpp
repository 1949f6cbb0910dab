/// Three forms that tie all along a curve.
///
/// Let the differences of three forms grow along a direction d all over a convex set: f - h, h - g, and so f
/// - g. On a line along d each two are equal once at most. If all three are equal somewhere on it, then f < h
/// < g before that place and g < h < f after it: h shows nowhere but there.
///
/// Two of the three tie somewhere on every line along d through a box if their difference there is no more
/// than it grows by in the box's surroundings. So does the third if its equation in space is a combination of
/// theirs (space_tie.hpp), whose one root t > 0 the height is; or if it is so on one of two planes in which
/// the two tie, and they are off the other one. So it is where the bisectors with two objects meet in an edge
/// of the box, or in a curve of a third one: balls in a row beside a tube or a plane, parallel tubes that
/// touch one circle, tubes that mirror each other in a plane that halves two sides.
///
/// Beside a floor the one of three forms that does not show on either side is left out, or both that do not.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "../../primitives/forms/heights.hpp"
#include "floor_rule.hpp"
#include "space_tie.hpp"

namespace vcell {

/// A height as a linear function, in doubles.
struct PlaneJet {
    double v;
    Eigen::Vector2d g;
};

class CommonCurves {
public:
    /// In ascending order.
    using Triple = std::array<FormId, 3>;

    CommonCurves(const Heights& heights, const FloorRule& rule) : heights_(heights), rule_(rule) {}

    /// Those of few forms that show nowhere in a box but along curves on which they tie with two others.
    /// Exact about curves, by intervals about which of the forms show beside them.
    std::vector<FormId> hidden(std::span<const FormId> forms, const Interval& x, const Interval& y);
    /// Do these tie with each other wherever two of them do in the box?
    bool is_common(const Triple& forms, const Interval& x, const Interval& y) {
        return order(forms, x, y).has_value();
    }
    /// Do three forms tie along some curve that seems to come next to the box?
    bool may_tie(Triple forms, const Interval& x, const Interval& y);
    /// Those that were found to have a curve in common, ascending.
    std::vector<Triple> found() const;

private:
    // From the one that grows most along d to the one that grows least: which is how they follow each other
    // before the curve.
    using Order = std::array<FormId, 3>;
    // Returns those that show on neither side of the curve.
    std::vector<FormId> shown_nowhere(const Order& three) const;
    std::optional<Order> order(const Triple& forms, const Interval& x, const Interval& y);
    HeightJet<Interval> jet(FormId f, const Interval& x, const Interval& y) const;
    // Heights come times one factor for all forms.
    PlaneJet near(FormId f, const Eigen::Vector2d& p) const;
    bool is_near(const Triple& forms, const Interval& x, const Interval& y) const;
    std::optional<Interval> in_one_half(const Interval& x, double margin) const;
    // This tells for each of three whether it ties where the other two do.
    using Implied = std::array<std::optional<SpaceTie::Implied>, 3>;
    const Implied& implied(const Triple& forms);
    bool is_off(const space_quadrics::Linear& linear, const Interval& x, const Interval& y,
                const Interval& height) const;

    const Heights& heights_;
    const FloorRule& rule_;
    std::map<Triple, Implied> implied_;
};

}  // namespace vcell
