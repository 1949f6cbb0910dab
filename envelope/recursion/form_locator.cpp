#include "form_locator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace vcell {

namespace {

// Measured (bench_changes): 3 to 6 take the same time, more take more.
constexpr std::size_t forms_of_leaf = 4;
// Halving on although the forms hardly get fewer: so often in a row. The first halves of a sphere are so
// large that none is left out; beyond that many of them meet in a point. And not below a part of the whole,
// as rectangles end to be larger than the spacing of doubles.
constexpr int most_stalled = 12;
constexpr double least_part = 0x1p-40;

}  // namespace

FormLocator::FormLocator(const FormFamily& family, std::vector<FormId> forms,
                         const std::array<double, 4>& box)
    : family_(family),
      competition_(family, std::max(box[1] - box[0], box[3] - box[2])),
      rivals_(competition_) {
    if (family.is_all_circular())
        for (const CircularForm& f : family.forms) circular_.push_back(KernelForm::of(f));
    Node root;
    root.box = box;
    root.forms = std::move(forms);
    nodes_.push_back(std::move(root));
    // The two halves of a cylinder's chart are smooth, not both together.
    if (const auto seam = family.chart.smooth_seam(); seam && box[0] < *seam && box[1] > *seam)
        halve(0, true, *seam);
}

FormId FormLocator::lowest(double x, double y) {
    const std::array<double, 4>& all = nodes_[0].box;
    if (!(x >= all[0] && x <= all[1] && y >= all[2] && y <= all[3])) return lowest_of(nodes_[0].forms, x, y);
    std::uint32_t i = 0;
    while (true) {
        if (nodes_[i].first == leaf) halve(i);
        const Node& node = nodes_[i];
        if (node.first == leaf) return lowest_of(node.forms, x, y);
        i = node.first + ((node.upright ? x : y) > node.at);
    }
}

void FormLocator::halve(std::uint32_t i) {
    const Node& node = nodes_[i];
    if (node.forms.size() <= forms_of_leaf || node.stalled >= most_stalled) return;
    const std::array<double, 4>&b = node.box, &all = nodes_[0].box;
    // Both sides as parts of the whole: lengths along a cylinder are no angles.
    const double part_x = (b[1] - b[0]) / (all[1] - all[0]), part_y = (b[3] - b[2]) / (all[3] - all[2]);
    const bool upright = part_x >= part_y;
    if (std::max(part_x, part_y) < least_part) return;
    const double lower = b[upright ? 0 : 2], upper = b[upright ? 1 : 3];
    const ChartLength length = family_.chart.lengths(0, 0);
    const double at = length.inverse(0.5 * (length.at(lower) + length.at(upper)));
    if (at > lower && at < upper) halve(i, upright, at);
}

void FormLocator::halve(std::uint32_t i, bool upright, double at) {
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    for (const bool beyond : {false, true}) {
        const Node& node = nodes_[i];
        Node half;
        half.box = node.box;
        half.box[(upright ? 0 : 2) + (beyond ? 0 : 1)] = at;
        half.forms = cull(half.box, node.forms);
        half.stalled = 8 * half.forms.size() > 7 * node.forms.size() ? node.stalled + 1 : 0;
        nodes_.push_back(std::move(half));
    }
    nodes_[i].upright = upright;
    nodes_[i].at = at;
    nodes_[i].first = first;
}

std::vector<FormId> FormLocator::cull(const std::array<double, 4>& box, std::span<const FormId> forms) {
    if (circular_.empty()) return rivals_.cull(box, forms);
    std::vector<FormId> kept;
    culling_(
        {box[0], box[1], box[2], box[3]}, forms, [&](FormId f) -> const KernelForm& { return circular_[f]; },
        [&](std::size_t i) { kept.push_back(forms[i]); });
    return kept;
}

FormId FormLocator::lowest_of(std::span<const FormId> forms, double x, double y) {
    const Interval X(x), Y(y);
    values_.clear();
    double top = HUGE_VAL;
    for (const FormId f : forms) {
        values_.push_back(heights().value(f, X, Y));
        top = std::min(top, values_.back().upper());
    }
    FormId best;
    for (std::size_t i = 0; i < forms.size(); ++i) {
        if (values_[i].lower() > top) continue;
        if (!best.valid() || heights().compare(forms[i], best, x, y, decisions_) == Sign::Negative)
            best = forms[i];
    }
    return best;
}

}  // namespace vcell
