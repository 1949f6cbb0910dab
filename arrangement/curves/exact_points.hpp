/// Exact points of lines and circles, with one square root each: which side of a curve they lie on, and in
/// which two curves meet.
///
/// A curve is K (x^2 + y^2) + A x + B y + C = 0; a circle has two halves, which are graphs, named by the sign
/// of y about its center. A line has one, named Zero.
#pragma once

#include <vector>

#include "../../core/curves/circular_form.hpp"
#include "../../core/numbers/enclosure.hpp"
#include "../../core/numbers/exact.hpp"

namespace vcell {

/// x / denominator, y / denominator. denominator > 0.
struct OneRootPoint {
    OneRoot x, y;
    Exact denominator;
};

/// A coordinate in any type of intervals.
template <class T>
T coordinate_of(const OneRoot& v, const Exact& denominator) {
    return (enclosure_of<T>(v.a) + enclosure_of<T>(v.b) * sqrt(enclosure_of<T>(v.c))) /
           enclosure_of<T>(denominator);
}

ExactForm exact_form(const CircularForm& f);
bool are_same_curve(const ExactForm& f, const ExactForm& g);

/// Where x is least (Negative), or greatest (Positive). Pre: a circle.
OneRootPoint x_extreme(const ExactForm& circle, Sign side);
/// A point of a line where y is 0. Pre: the line is vertical.
OneRootPoint foot_of_vertical(const ExactForm& line);

/// Is p above a half of the curve, on it, or below it? Pre: it is within its range of x; no line is vertical.
Sign exact_side_of(const OneRootPoint& p, const ExactForm& curve, Sign half);

/// Does a point of the curve lie on this half?
bool is_on_half(const OneRootPoint& p, const ExactForm& curve, Sign half);

/// Where two different curves meet: no point, one or two.
std::vector<OneRootPoint> common_points(const ExactForm& f, const ExactForm& g);

}  // namespace vcell
