/// Heights at points with rational coordinates, exact: where forms tie and whether they have equal gradients
/// there.
///
/// Every height r is a root of c - 2 b r - a r^2 = 0 whose coefficients are polynomials in the point's
/// coordinates: over a plane C, beta and A of plane_base.hpp and cylinder_form.hpp; over curved bases, where
/// r = -Q, -A^2, -B and -C of radial_form.hpp. Differentiated, r_x = (c_x - 2 b_x r - a_x r^2) / (2 (b + a
/// r)). All of that lies in the field of r; forms that tie share it.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "../../core/numbers/enclosure.hpp"
#include "form_family.hpp"

namespace vcell {

/// The point (x / w, y / w), w > 0.
struct RationalPoint {
    Exact x, y, w = 1.0;
};

struct Fraction {
    Exact numerator, denominator;
};

/// The number with a denominator of no more than some 2^100 that one of some size, known to 2^-200, is taken
/// to stand for; nothing is proved about it. None if there is no such number.
std::optional<Fraction> simplest_near(Wide v);

/// The point with denominators of no more than some 2^100 that two coordinates, known to 2^-200 of `extent`,
/// are taken to stand for; nothing is proved about it. None if there is no such point.
std::optional<RationalPoint> rational_near(const Wide& x, const Wide& y, double extent);

/// Intervals around its coordinates; points where these are doubles.
std::array<Interval, 2> enclosure(const RationalPoint& p);

bool is_on_line(const RationalPoint& p, double a, double b, double c);

/// The equation above at a point, times a positive number.
struct HeightEquation {
    Exact c, b, a;
};
HeightEquation height_equation(const FormFamily& family, FormId f, const RationalPoint& p);

/// Sign of f - g. Pre, here and below: the point lies outside the trace of every cylinder that is not hollow.
Sign compare_exactly(const FormFamily& family, FormId f, FormId g, const RationalPoint& p);

/// Do all of them have one height?
bool all_tie(const FormFamily& family, std::span<const FormId> forms, const RationalPoint& p);

/// Do all of them have gradients on one line? Pre: there are two or three, and they tie.
bool have_gradients_in_line(const FormFamily& family, std::span<const FormId> forms, const RationalPoint& p);

/// Do the two change alike along the line a x + b y + c = 0? Pre: they tie.
bool have_equal_slopes(const FormFamily& family, FormId f, FormId g, const RationalPoint& p, double a,
                       double b);

/// Are their gradients equal? Pre: they tie.
bool have_equal_gradients(const FormFamily& family, FormId f, FormId g, const RationalPoint& p);

}  // namespace vcell
