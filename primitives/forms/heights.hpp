/// The heights of a family over points and boxes of the chart, enclosed: what the certified subdivision
/// evaluates where forms are no circular forms, and comparisons at points by the whole ladder. Over curved
/// bases what is enclosed is the form's value divided by W, and over a cylinder with tips times the distances
/// from them (radial_height.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/sign.hpp"
#include "../../core/numbers/wide.hpp"
#include "exact_heights.hpp"
#include "form_family.hpp"
#include "radial_height.hpp"
#include "twins.hpp"

namespace vcell {

/// Of two enclosures of one number.
inline Interval narrowed(Interval a, Interval b) {
    return {std::max(a.lower(), b.lower()), std::min(a.upper(), b.upper())};
}

/// A height and its partial derivatives.
template <class T>
struct HeightJet {
    T v, gx, gy;
};

/// A height's second derivatives.
template <class T>
struct HeightCurvature {
    T xx, xy, yy;

    friend HeightCurvature operator-(const HeightCurvature& a, const HeightCurvature& b) {
        return {a.xx - b.xx, a.xy - b.xy, a.yy - b.yy};
    }
};

/// A gradient over a box, as enclosed there and by the mean value theorem from that at its middle, c its
/// derivatives over the box, which is the middle plus (dx, dy).
inline std::array<Interval, 2> refined_gradient(const std::array<Interval, 2>& over,
                                                const std::array<Interval, 2>& middle,
                                                const HeightCurvature<Interval>& c, Interval dx,
                                                Interval dy) {
    return {narrowed(over[0], middle[0] + c.xx * dx + c.xy * dy),
            narrowed(over[1], middle[1] + c.xy * dx + c.yy * dy)};
}

/// A cylinder's height over a plane base (primitives/forms/cylinder_form.hpp) takes these numbers at every
/// place: A, M, far = |a|^2 rho^2, lift, the part of beta that does not depend on the place, products of
/// p_z, for V of hollow ones rho + p_z, S^2 of cones, and across = a_z^2 - S^2. They are computed once.
template <class T>
struct CylinderConstants {
    T A, M, far, lift, ax_pz, ay_pz, tip, sine2, across;

    CylinderConstants() = default;
    explicit CylinderConstants(const CylinderNumbers<T>& f) {
        const T level = square(f.ax) + square(f.ay), norm = level + square(f.az);
        A = square(f.steep);
        M = norm;
        tip = f.rho + f.pz;
        far = norm * square(f.rho);
        lift = norm * f.rho + level * f.pz;
        ax_pz = f.ax * f.pz;
        ay_pz = f.ay * f.pz;
        across = square(f.az);
        if (f.sine.sign() != Sign::Positive) return;
        sine2 = square(f.sine);
        M -= sine2;
        across -= sine2;
        lift += f.sine * f.steep * f.pz;
    }
};

class Heights {
public:
    /// The family must outlive this object.
    explicit Heights(const FormFamily& family);

    const FormFamily& family() const { return family_; }
    /// What a piece costs in those over a plane, by the heights asked for.
    std::size_t cost() const { return is_radial() ? 4 : 1; }

    /// The forms' value over what is enclosed here: 1 over a plane. Pre: y lies between the tips.
    Interval scale(Interval x, Interval y) const;

    /// Encloses height and gradient of f over the box x times y. Where the box reaches into a cylinder's
    /// trace on the base: the whole line; so are derivatives of a hollow one's where it may hold the tip.
    HeightJet<Interval> jet(FormId f, Interval x, Interval y) const;
    Interval value(FormId f, Interval x, Interval y) const;
    /// About the height at a point and the derivatives of its differences to those that agree with it, as
    /// double arithmetic tells them. Pre: the base is no sphere.
    std::array<double, 3> near(FormId f, double x, double y) const;
    /// The same with more digits, for boxes so small that doubles cannot tell.
    HeightJet<Wide> jet(FormId f, const Wide& x, const Wide& y) const;
    Wide value(FormId f, const Wide& x, const Wide& y) const;

    /// How often heights were asked for with more digits so far: what costs most where forms all but
    /// coincide.
    std::size_t wide_evaluations() const { return wide_evaluations_; }

    /// Encloses beta + A t of a cylinder's equation over the box (cylinder_form.hpp): where t is its height
    /// that is the root, below 0 of what is hollow. Pre: a plane base, and f is no circular form.
    Interval root_at(FormId f, Interval x, Interval y, Interval t) const;

    /// Encloses the second derivatives of f over the box, likewise.
    HeightCurvature<Interval> curvature(FormId f, Interval x, Interval y) const;

    /// f - g over the box with all derivatives, as the difference of their coefficients tells it (twins.hpp):
    /// none unless they are twins.
    std::optional<FunctionJet<Interval>> twin_difference(FormId f, FormId g, Interval x, Interval y) const;
    /// Are the two twins?
    bool are_twins(FormId f, FormId g) const { return twin_factor(f, g).has_value(); }
    /// Enclose f - g and its derivatives over the box: heights less each other, of twins as they tell.
    Interval value_difference(FormId f, FormId g, Interval x, Interval y) const;
    HeightJet<Interval> difference(FormId f, FormId g, Interval x, Interval y) const;
    HeightJet<Wide> difference(FormId f, FormId g, const Wide& x, const Wide& y) const;
    HeightCurvature<Interval> curvature_difference(FormId f, FormId g, Interval x, Interval y) const;

    /// Encloses the gradient of f - g over the box, in natural and in mean value form.
    std::array<Interval, 2> gradient_difference(FormId f, FormId g, Interval x, Interval y) const;
    /// Of heights without the distances from tips. Pre: the base is curved.
    HeightJet<Interval> plain_jet(FormId f, Interval x, Interval y) const;
    Wide plain_value(FormId f, const Wide& x, const Wide& y) const;
    std::array<Interval, 2> plain_gradient_difference(FormId f, FormId g, Interval x, Interval y) const {
        return difference(plain_gradient(f, x, y), plain_gradient(g, x, y), x, y);
    }
    /// The gradient of a height without the distances from tips, as differences need it: many are made of
    /// one.
    struct PlainGradient {
        std::array<Interval, 2> over, middle;
        HeightCurvature<Interval> curvature;
    };
    PlainGradient plain_gradient(FormId f, Interval x, Interval y) const;
    /// As plain_gradient_difference(), of both heights over the same box.
    static std::array<Interval, 2> difference(const PlainGradient& f, const PlainGradient& g, Interval x,
                                              Interval y);

    /// Sign of f - g at a point in doubles, exact: heights are numbers a + b sqrt(c).
    /// Pre: the point lies outside the trace of every cylinder that is not hollow.
    Sign compare(FormId f, FormId g, double x, double y, Decisions& decisions) const;
    /// Compares by the exact rung alone.
    Sign compare(FormId f, FormId g, const RationalPoint& p, Decisions& decisions) const;

private:
    // f of circular forms in intervals, or what of a cylinder's does not depend on the place.
    struct Prepared {
        Interval a, b, e, inverse_w;
        CylinderConstants<Interval> cylinder;
    };

    // K, A, B, C of circular forms over their common denominator; of cylinders what does not depend on the
    // place, and of those that doubles do not give exactly their numbers.
    struct WidePrepared {
        std::array<Wide, 4> coefficients;
        CylinderConstants<Wide> constants;
        std::optional<CylinderNumbers<Wide>> cylinder;
    };
    const WidePrepared& wide(FormId f) const;
    // The cylinder's numbers, if doubles do not give them exactly.
    const CylinderNumbers<Interval>* turned(FormId f) const {
        return turned_.empty() ? nullptr : turned_[f.value].get();
    }
    CylinderNumbers<Interval> cylinder(FormId f) const {
        const CylinderNumbers<Interval>* t = turned(f);
        return t != nullptr ? *t : numbers_of<Interval>(family_.cylinder(f));
    }
    bool is_radial() const { return !radial_.empty(); }
    template <int order>
    FunctionJet<Interval> radial_jet(FormId f, Interval x, Interval y) const;
    template <int order>
    FunctionJet<Wide> radial_jet(FormId f, const Wide& x, const Wide& y) const;

    const FormFamily& family_;
    std::vector<Prepared> prepared_;
    std::vector<std::unique_ptr<CylinderNumbers<Interval>>> turned_;  // of all forms, or none
    mutable std::vector<std::unique_ptr<WidePrepared>> wide_;         // made when asked for
    std::vector<RadialHeight<Interval>> radial_;                      // of all forms over curved bases
    mutable std::vector<std::unique_ptr<RadialHeight<Wide>>> wide_radial_;
    // Those of the last two boxes: forms are asked one after the other about a box and its middle.
    struct BoxNormals {
        Interval x, y;
        RadialNormals<Interval> normals;
    };
    mutable std::array<BoxNormals, 2> box_normals_;
    mutable std::size_t newer_ = 0;
    mutable std::size_t wide_evaluations_ = 0;
    const RadialNormals<Interval>& normals(Interval x, Interval y) const;
    // Made when asked for.
    mutable std::vector<FormSignature> signatures_;
    mutable std::vector<bool> have_twins_;
    mutable bool are_any_twins_ = false;
    mutable std::map<std::array<FormId, 2>, TwinDifference> twins_;
    void find_twins() const;
    std::optional<double> twin_factor(FormId f, FormId g) const {
        if (signatures_.empty()) find_twins();
        if (!are_any_twins_ || !have_twins_[f.value] || !have_twins_[g.value] || f == g) return std::nullopt;
        return signatures_[f.value].factor(signatures_[g.value]);
    }
};

}  // namespace vcell
