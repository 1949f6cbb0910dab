/// A side of a piece as a line with one unknown along it, and the heights over it: what the questions about
/// sides share.
#pragma once

#include <array>
#include <cmath>

#include "../../core/solver/newton/newton.hpp"
#include "../../core/solver/newton/one_unknown.hpp"
#include "competition.hpp"
#include "mixed_piece.hpp"
#include "mixed_terms.hpp"

namespace vcell {

inline RationalPoint rational(const Exact& x, const Exact& y, const Exact& w) {
    return w.sign() == Sign::Negative ? RationalPoint{-x, -y, -w} : RationalPoint{x, y, w};
}

inline bool axis_parallel(const PieceSide& s) {
    return (s.a == 0 && std::abs(s.b) == 1) || (s.b == 0 && std::abs(s.a) == 1);
}

// A side as the graph of its second coordinate over its first, s: x, or y where the side is steep.
struct SideLine {
    const PieceSide& side;
    bool by_x;
    Interval slope, offset;

    explicit SideLine(const PieceSide& l) : side(l), by_x(std::abs(l.b) >= std::abs(l.a)) {
        const double p = by_x ? l.a : l.b, q = by_x ? l.b : l.a;
        if (axis_parallel(l)) {
            slope = 0;
            offset = -l.c * q;
        } else {
            slope = -Interval(p) / Interval(q);
            offset = -Interval(l.c) / Interval(q);
        }
    }
    Interval coordinate(const IntervalPoint& p) const { return p[by_x ? 0 : 1]; }
    // Does s grow counter-clockwise around the piece?
    bool ascends() const { return by_x ? side.b > 0 : side.a < 0; }
    IntervalPoint at(Interval s) const {
        const Interval other = is_point(slope) && slope.lower() == 0 ? offset : slope * s + offset;
        return by_x ? IntervalPoint{s, other} : IntervalPoint{other, s};
    }
    std::array<Wide, 2> wide_at(const Wide& s) const {
        const double p = by_x ? side.a : side.b, q = by_x ? side.b : side.a;
        const Wide other = -(Wide(p) * s + Wide(side.c)) / Wide(q);
        return by_x ? std::array{s, other} : std::array{other, s};
    }
    RationalPoint exact_at(double s) const {
        const Exact p(by_x ? side.a : side.b), q(by_x ? side.b : side.a), other = -(p * s + side.c);
        return by_x ? rational(s * q, other, q) : rational(other, s * q, q);
    }
    Interval difference(const Heights& heights, FormId f, FormId g, double s) const {
        const IntervalPoint p = at(Interval(s));
        return heights.value_difference(f, g, p[0], p[1]);
    }
    // difference() at one point, with 320 bits: where heights are all but equal doubles cancel.
    Interval sharp_difference(const Heights& heights, FormId f, FormId g, double s) const {
        return (sharp_height(heights, f, s) - sharp_height(heights, g, s)).enclosure();
    }
    // Encloses the difference's derivative over a stretch.
    Interval slope_difference(const Heights& heights, FormId f, FormId g, const Interval& stretch) const {
        const IntervalPoint range = at(stretch);
        const Interval derivative = along(heights.difference(f, g, range[0], range[1]));
        return derivative.sign() ? derivative : mean_slope_difference(heights, f, g, stretch);
    }
    // In mean value form: by far the sharper one where the two are nearly the same function.
    Interval mean_slope_difference(const Heights& heights, FormId f, FormId g,
                                   const Interval& stretch) const {
        const Interval m(stretch.mid());
        const IntervalPoint p = at(m), range = at(stretch);
        return along(heights.difference(f, g, p[0], p[1])) +
               bend(heights.curvature_difference(f, g, range[0], range[1])) * (stretch - m);
    }
    // Does the first of two twins lie above the other all along a stretch?
    bool is_above_twin(const Heights& heights, FormId f, FormId g, const Interval& stretch) const {
        const Interval m(stretch.mid());
        const IntervalPoint range = at(stretch), middle = at(m);
        const auto over = *heights.twin_difference(f, g, range[0], range[1]);
        const Interval slope = along({over.v, over.x, over.y});
        return (heights.value_difference(f, g, middle[0], middle[1]) -
                Interval(slope.magnitude()) * Interval(stretch.radius()))
                   .lower() > 0;
    }
    Wide sharp_height(const Heights& heights, FormId f, double m) const {
        const auto p = wide_at(Wide(m));
        return heights.value(f, p[0], p[1]);
    }
    // A height and its derivative along the side, with many digits.
    std::array<Wide, 2> sharp_jet(const Heights& heights, FormId f, const Wide& s) const {
        const auto p = wide_at(s);
        const HeightJet<Wide> j = heights.jet(f, p[0], p[1]);
        const Wide rise = by_x ? -Wide(side.a) / Wide(side.b) : -Wide(side.b) / Wide(side.a);
        return {j.v, by_x ? j.gx + rise * j.gy : j.gy + rise * j.gx};
    }
    // The derivative of a height along the side with respect to s.
    Interval along(const HeightJet<Interval>& j) const {
        return by_x ? j.gx + slope * j.gy : j.gy + slope * j.gx;
    }
    // And its second derivative.
    Interval bend(const HeightCurvature<Interval>& c) const {
        return (by_x ? c.xx : c.yy) + 2.0 * slope * c.xy + square(slope) * (by_x ? c.yy : c.xx);
    }
};

// A function of the place along a line, with a slope that is not exact.
template <class Value>
auto of_one_unknown(Value value, double slope) {
    const auto linearise = [value, slope](const WideBox<1>& s) {
        return LocalModel<Wide, 1>{{value(s[0])}, {{{Wide(slope)}}}};
    };
    return LinearisedModel<Wide, 1, decltype(linearise)>(linearise);
}

}  // namespace vcell
