/// Curves {f = g} of circular forms and the points in which they meet, in exact numbers: the kernel's last
/// rung. A point lives in a quadratic extension of Q. The algebra is told in circle_kernel.cpp.
#pragma once

#include <array>
#include <optional>

#include "../../core/curves/circular_form.hpp"
#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/sign.hpp"

namespace vcell {

/// (px + rx sqrt(d), py + ry sqrt(d)) / w, w > 0
struct ExactCirclePoint {
    Exact px, rx, py, ry, d, w;
    /// w^2 times the square of its distance from the origin, and w^2, once a value was asked for.
    struct Squares {
        OneRoot of_point;
        Exact of_w;
    };
    std::optional<Squares> squares{};

    OneRoot x() const { return {px, rx, d}; }
    OneRoot y() const { return {py, ry, d}; }
};

/// K |p|^2 + A x + B y + C: a positive multiple of f - g.
struct ExactCurve {
    Exact K, A, B, C;

    static ExactCurve between(const ExactForm& f, const ExactForm& g) {
        return {f.K * g.W - g.K * f.W, f.A * g.W - g.A * f.W, f.B * g.W - g.B * f.W, f.C * g.W - g.C * f.W};
    }
    bool is_line() const { return K.sign() == Sign::Zero; }
    /// Positive multiples of the value and the gradient at p.
    OneRoot value(ExactCirclePoint& p) const;
    std::array<OneRoot, 2> gradient(const ExactCirclePoint& p) const;
    /// 4 K^2 r^2 of a circle of radius r.
    Exact squared_diameter() const { return A * A + B * B - Exact(4.0) * K * C; }
    /// The leftmost point, the centre or the rightmost point. Pre: this is no line.
    ExactCirclePoint own_point(Sign which) const;
};

/// The sign of this tells whether two curves meet twice, touch, or do not meet. Pre: not both are lines.
Exact discriminant(const ExactCurve& c, const ExactCurve& d);

/// The point where grad c turns that way to grad d; Zero: where they touch.
std::optional<ExactCirclePoint> intersection(const ExactCurve& c, const ExactCurve& d, Sign orientation);

}  // namespace vcell
