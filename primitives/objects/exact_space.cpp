#include "exact_space.hpp"

#include <cmath>
#include <limits>

namespace vcell {

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

}  // namespace vcell
