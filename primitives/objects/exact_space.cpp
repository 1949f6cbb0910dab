#include "exact_space.hpp"

#include <cmath>
#include <limits>

namespace vcell {

double nearest(const Exact& value) {
    const Interval around = value.enclosure();
    if (around.lower() == around.upper()) return around.lower();
    return value + value < Exact(around.lower()) + around.upper() ? around.lower() : around.upper();
}

double rounded_sqrt(const Exact& value) {
    const Interval square = value.enclosure();
    const bool is_in_range = square.lower() > 0x1p-1000 && square.upper() < 0x1p1000;
    const Interval root = is_in_range ? sqrt(square) : value.sqrt_bounds(128).first.enclosure();
    const Exact four_times = value * 4.0;
    // The root lies beyond a midpoint exactly when its square does.
    double x = root.lower();
    while (x < root.upper()) {
        const double next = std::nextafter(x, std::numeric_limits<double>::infinity());
        const Exact sum = Exact(x) + next;
        if (!(sum * sum < four_times)) break;
        x = next;
    }
    return x;
}

// sqrt(h^2 + r) = h + r / (2 h) - r^2 / (8 h^3) ..., of which the third term is below 2^-107 h, and r / (2 h)
// is rounded twice.
Exact length_of(const ExactVector& n) {
    const Exact value = dot(n, n);
    const long half = value.exponent() >> 1;  // of a root, which may be beyond the doubles' range
    const Exact square = value.scaled(-2 * half);
    const double high = rounded_sqrt(square), low = nearest(square - Exact(high) * high) / (2 * high);
    return (Exact(high) + low).scaled(half);
}

}  // namespace vcell
