/// Sums that know how far off they may be.
#pragma once

#include "../platform.hpp"

#include <cmath>
#include <limits>

namespace vcell {

/// A sum with Neumaier's compensation, so that a million faces cost no digits, and a bound on the error of
/// what was added.
struct BoundedSum {
    double sum = 0, compensation = 0, error = 0;

    void add(double term, double term_error = 0) {
        const double t = sum + term;
        compensation += std::abs(sum) >= std::abs(term) ? (sum - t) + term : (term - t) + sum;
        sum = t;
        error += term_error;
    }
    void add(const BoundedSum& other) {
        add(other.sum, other.error);
        add(other.compensation);
    }
    double value() const { return sum + compensation; }
    double bound() const { return error + 2 * std::numeric_limits<double>::epsilon() * std::abs(value()); }
};

}  // namespace vcell
