/// Circular forms and the curves {f = g} between them, each given by doubles and, where these cannot tell, by
/// exact numbers.
///
/// Every predicate climbs the ladder: double with a proven bound, interval, exact.
#pragma once

#include <array>
#include <deque>
#include <optional>

#include "circle_forms.hpp"
#include "exact_circles.hpp"

namespace vcell {

class CircleCurves {
public:
    /// Starts empty: no forms but the zero form.
    CircleCurves() { reset(nullptr); }

    /// Forgets all forms (keeps memory and counts). `family` serves exact coefficients of forms added by
    /// add_form; it must outlive their use.
    void reset(const CircularFamily* family);

    /// The function 0: {line = zero} makes a line a curve.
    static constexpr FormId zero_form() { return {0}; }
    FormId add_line(double a, double b, double c);  ///< a x + b y + c, coefficients exact
    FormId add_form(FormId in_family) {
        return add_form(in_family, KernelForm::of(family_->forms[in_family]));
    }
    /// add_form() of what KernelForm::of() has made of it.
    FormId add_form(FormId in_family, const KernelForm& made);

    /// What the family calls this form; none for lines and zero.
    FormId family_id(FormId f) const { return sources_[f].in_family; }
    const KernelForm& form(FormId f) const { return forms_[f]; }
    /// f - g at a place.
    FormJet jet(FormPair c, double x, double y) const {
        return forms_[c.f].jet(x, y) - forms_[c.g].jet(x, y);
    }
    ExactCurve exact_curve(FormPair c) { return ExactCurve::between(exact_form(c.f), exact_form(c.g)); }

    /// Do the two forms of c define the same curve as those of d? (Pencils: one curve for many pairs.)
    bool same_curve(FormPair c, FormPair d);
    /// Sign of K in f - g = K |p|^2 + ...: positive for circles run counter-clockwise, zero for lines.
    Sign curvature_sign(FormPair c);
    /// Positive: a circle; Zero: a single point; Negative: empty. For lines: Positive, or Negative if f - g
    /// is constant.
    Sign radius_sign(FormPair c);

    struct Circle {
        Interval cx, cy, r2;
    };
    /// Centre and squared radius; none where doubles cannot tell the curve from a line.
    std::optional<Circle> circle(FormPair c) const;
    /// A rectangle that contains the circle c; the whole plane where doubles cannot tell.
    std::array<double, 4> circle_box(FormPair c) const;
    /// Does the double rung prove that c's circle does not lie in the rectangle?
    bool circle_leaves_box(FormPair c, const std::array<double, 4>& box) const;

    /// Lower bound of f - g over the axis-parallel rectangle [x0,x1] x [y0,y1] (double rung only).
    double lower_bound(FormId f, FormId g, double x0, double x1, double y0, double y1) const;

    Decisions& decisions() { return decisions_; }
    const Decisions& decisions() const { return decisions_; }

protected:
    /// Are its coefficients exact, as they stand in form()?
    bool is_line(FormId f) const { return !sources_[f].in_family.valid(); }

    IdVector<FormId, KernelForm> forms_;
    Decisions decisions_;

private:
    struct Source {
        FormId in_family;  // none: a line, its coefficients are exact in KernelForm
        std::int32_t exact = -1;
    };
    const ExactForm& exact_form(FormId f);

    const CircularFamily* family_ = nullptr;
    IdVector<FormId, Source> sources_;
    std::deque<ExactForm> exact_forms_;
};

}  // namespace vcell
