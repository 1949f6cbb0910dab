/// The heights of a family over points and boxes of the chart, enclosed: what the certified subdivision
/// evaluates where forms are no circular forms, and comparisons at points by the whole ladder.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "../core/circular_form.hpp"
#include "../core/interval.hpp"
#include "../core/sign.hpp"
#include "../core/wide_interval.hpp"

namespace vcell {

/// A height and its partial derivatives.
template <class T>
struct HeightJet {
    T v, gx, gy;
};

class Heights {
public:
    /// The family must outlive this object.
    explicit Heights(const FormFamily& family);

    const FormFamily& family() const { return family_; }

    /// Encloses height and gradient of f over the box x times y. Where the box reaches into a cylinder's trace
    /// on the base: the whole line.
    HeightJet<Interval> jet(FormId f, Interval x, Interval y) const;
    /// The same with more digits, for boxes so small that doubles cannot tell.
    HeightJet<Wide> jet(FormId f, const Wide& x, const Wide& y) const;

    /// Sign of f - g at a point in doubles, exact: heights of cylinders are numbers a + b sqrt(c).
    /// Pre: the point lies outside the trace of every cylinder.
    Sign compare(FormId f, FormId g, double x, double y, Decisions& decisions) const;

private:
    // f of circular forms in intervals; of cylinders N = |a|^2 and A = a_z^2.
    struct Prepared {
        Interval a, b, e, inverse_w;
        Interval norm, A;
    };

    const FormFamily& family_;
    std::vector<Prepared> prepared_;
};

}  // namespace vcell
