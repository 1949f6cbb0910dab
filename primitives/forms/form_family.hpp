/// The heights of a base's objects.
///
/// Over a plane base, and over a sphere base in a stereographic chart, the clearance at which a plane, a
/// sphere or a side of the box is met is a circular form: over a plane base sphere-like ones have a = b = 0,
/// linear ones k = cx = cy = 0; over a sphere base k is -1, 0 or 1 and cx = cy = 0. Cylinders over a plane
/// base have forms of their own; over curved bases what is not circular is a radial form (over a sphere those
/// of cylinders, over a cylinder all).
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "../../core/curves/circular_form.hpp"
#include "../../core/numbers/interval.hpp"
#include "../charts/chart.hpp"
#include "cylinder_form.hpp"
#include "radial_form.hpp"

namespace vcell {

/// A set of heights to compare: circular forms and after them, in the same numbering, all others.
struct FormFamily : CircularFamily {
    std::vector<CylinderForm> cylinders;  ///< empty over curved bases
    std::vector<RadialForm> radial;       ///< empty over a plane base
    Chart chart;                          ///< of the base
    double axial_unit = 1;                ///< of y over a cylinder; a power of two
    AxialTips tips;                       ///< over a cylinder, in that unit

    /// A wall may be half of the bisector with a tube whose axis crosses that of a base cylinder. Wherever it
    /// is met, so is the tube, with the same gradient: this is the tube's form, in lengths of `chart`
    /// whatever axial_unit is.
    struct TubeOfWall {
        FormId wall;
        RadialForm tube;
    };
    std::vector<TubeOfWall> tubes_of_walls;  ///< ascending

    /// Where the base was turned forms are a little beside those of what was given. These are the equations
    /// of that as space_quadrics.hpp has them, in coordinates of space and the distance from the base; none
    /// of forms that have none in rational numbers.
    struct GivenEquations {
        std::vector<Exact> base;
        std::function<std::optional<std::vector<Exact>>(FormId)> of;
        /// Encloses the X of what is around p, t in the canonical ones.
        std::function<std::array<Interval, 5>(const std::array<Interval, 3>& p, const Interval& t)> place;
    };
    std::optional<GivenEquations> given;

    /// Where in the chart forms are nowhere lower than all others, those that are there as low included: over
    /// a cylinder, y in that unit, about ties (RingTie, PassingTie); elsewhere sides of the box and, over a
    /// sphere, what ties along circles (CircleTie), which are so everywhere.
    struct Hidden {
        FormId form;
        std::array<double, 2> x, y;
    };
    std::vector<Hidden> hidden;
    /// The form is so everywhere.
    void hide(FormId f) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        hidden.push_back({f, {-infinity, infinity}, {-infinity, infinity}});
    }
    /// Is the form known to be so all over a rectangle?
    bool is_hidden(FormId f, const Interval& x, const Interval& y) const {
        return std::ranges::any_of(hidden, [&](const Hidden& h) {
            return h.form == f && h.x[0] <= x.lower() && x.upper() <= h.x[1] && h.y[0] <= y.lower() &&
                   y.upper() <= h.y[1];
        });
    }

    /// What the heights are compared over: where all forms are circular, a plane also in a sphere's chart.
    Chart compared_over() const { return radial.empty() ? Chart() : chart; }

    /// Are the heights' equations c q^2 - 2 b q - a = 0 over the chart as over a plane, with c of degree two
    /// at most, b of degree one and a constant, or heights themselves of degree two?
    bool are_quadratic() const { return radial.empty(); }

    /// Is a form's height the only root of its equation, all over the rectangle between these y? That of a
    /// vessel, and of a tube that pierces the base, has another one.
    bool has_one_root(FormId f, const Interval& y) const {
        if (is_circular(f)) return true;
        if (radial.empty()) return !cylinder(f).is_hollow();
        const RadialForm& form = radial_form(f);
        const auto& c = form.c;
        return !form.has_root() ||
               (!form.is_hollow && form.a0.sign() == Sign::Zero &&
                (c[0].enclosure() + y * (c[1].enclosure() + y * c[2].enclosure())).sign() == Sign::Positive);
    }

    std::size_t size() const { return forms.size() + cylinders.size() + radial.size(); }
    bool is_circular(FormId f) const { return f.value < forms.size(); }
    bool is_all_circular() const { return cylinders.empty() && radial.empty(); }
    /// Pre: !is_circular(f), plane base.
    const CylinderForm& cylinder(FormId f) const { return cylinders[f.value - forms.size()]; }
    /// Pre: !is_circular(f), curved base.
    const RadialForm& radial_form(FormId f) const { return radial[f.value - forms.size()]; }
};

}  // namespace vcell
