/// Functions of the plane whose pairwise comparisons are circles and lines.
///
/// Over a plane base (and over a sphere base in a stereographic chart) the clearance at which a plane,
/// a sphere or a side of the box is met is
///
///     f(x, y) = (k |p - c|^2 + a x + b y + e) / w,      w > 0.
///
/// Two of them are equal on a circle, a line, a point or nowhere: f - g is again of the form
/// K (x^2 + y^2) + A x + B y + C, and three of them at the two points that two such curves share.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "cylinder_form.hpp"
#include "exact.hpp"
#include "ids.hpp"
#include "radial_form.hpp"

namespace vcell {

struct FormTag { static constexpr char letter = 'q'; };
using FormId = Id<FormTag>;

/// f in double. cx, cy and k are exact; a, b, e and w are within 4 u (u = 2^-53) of their exact
/// values, relatively. Over a plane base sphere-like forms have a = b = 0, linear ones k = cx = cy = 0; over a sphere
/// base k is -1, 0 or 1 and cx = cy = 0.
struct CircularForm {
    double k = 0;
    double cx = 0, cy = 0;
    double a = 0, b = 0, e = 0;
    double w = 1;

    /// f(x, y), plain double arithmetic: for output and heuristics only.
    double operator()(double x, double y) const {
        const double dx = x - cx, dy = y - cy;
        return (k * (dx * dx + dy * dy) + a * x + b * y + e) / w;
    }
};

/// The same function in the monomial basis over one denominator:
/// f = (K (x^2 + y^2) + A x + B y + C) / W, exact, W > 0.
struct ExactForm {
    Exact K, A, B, C, W;
};

/// A set of heights to compare: circular forms, with the exact coefficients behind them (computed when asked
/// for), and after them, in the same numbering, all others: over a plane base the heights of cylinders, over a curved
/// base radial forms (over a sphere those of cylinders, over a cylinder all).
struct FormFamily {
    IdVector<FormId, CircularForm> forms;
    std::function<ExactForm(FormId)> exact;
    std::vector<CylinderForm> cylinders;  ///< empty over curved bases
    std::vector<RadialForm> radial;       ///< empty over a plane base
    RadialChart chart = RadialChart::Stereographic;
    double axial_unit = 1;  ///< of y over a cylinder; a power of two
    AxialTips tips;         ///< over a cylinder, in that unit

    std::size_t size() const { return forms.size() + cylinders.size() + radial.size(); }
    bool is_circular(FormId f) const { return f.value < forms.size(); }
    bool is_all_circular() const { return cylinders.empty() && radial.empty(); }
    /// Pre: !is_circular(f), plane base.
    const CylinderForm& cylinder(FormId f) const { return cylinders[f.value - forms.size()]; }
    /// Pre: !is_circular(f), curved base.
    const RadialForm& radial_form(FormId f) const { return radial[f.value - forms.size()]; }
};

}  // namespace vcell
