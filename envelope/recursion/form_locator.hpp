/// Point location among forms: which one is lowest at a point of the chart.
///
/// A tree of rectangles, each with the forms that may be lowest somewhere in it. A rectangle is halved, and
/// its forms are culled for both halves as the envelope's recursion culls them, when a point in it is asked
/// about for the first time; so few questions cost little, and many one descent each: O(log n) where forms
/// are spread over the region.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/sign.hpp"
#include "../../primitives/forms/form_family.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../proofs/box_rivals.hpp"
#include "competing_forms.hpp"

namespace vcell {

class FormLocator {
public:
    /// Most points asked about lie in x0 <= x <= x1, y0 <= y <= y1, box = {x0, x1, y0, y1}, in the chart's
    /// coordinates; for others all forms are compared. On a sphere rectangles are halved as angles from the
    /// chart's middle are. The family must outlive the locator.
    /// Only `forms`, ascending and not empty, are looked at: hidden ones of the family own no point.
    FormLocator(const FormFamily& family, std::vector<FormId> forms, const std::array<double, 4>& box);
    FormLocator(const FormLocator&) = delete;

    /// The form that is lowest at a point given in doubles, exact; the first of those that tie. Pre: the
    /// point lies outside the trace of every cylinder.
    FormId lowest(double x, double y);

    const Heights& heights() const { return competition_.heights(); }
    const Decisions& decisions() const { return decisions_; }

private:
    struct Node {
        std::array<double, 4> box;
        std::vector<FormId> forms;   // ascending
        std::uint32_t first = leaf;  // the half with the lower coordinates; the other one follows
        bool upright = false;        // halves lie side by side
        double at = 0;
        int stalled = 0;  // halvings in a row that hardly left out any form
    };
    static constexpr std::uint32_t leaf = 0;  // the root is nobody's half

    void halve(std::uint32_t node, bool upright, double at);
    void halve(std::uint32_t node);
    std::vector<FormId> cull(const std::array<double, 4>& box, std::span<const FormId> forms);
    FormId lowest_of(std::span<const FormId> forms, double x, double y);

    const FormFamily& family_;
    Competition competition_;
    BoxRivals rivals_;
    // Where all forms are circular:
    IdVector<FormId, KernelForm> circular_;
    FormCulling culling_;

    std::vector<Interval> values_;  // of a leaf's forms, for lowest_of()
    std::vector<Node> nodes_;
    Decisions decisions_;
};

}  // namespace vcell
