#include "exact_space.hpp"

namespace vcell {

double rounded_sqrt(const Exact& value) {
    const Interval root = value.sqrt_bounds(128).first.enclosure();
    // The root lies beyond the midpoint exactly when its square does.
    const Exact sum = Exact(root.lower()) + root.upper();
    return sum * sum < value * 4.0 ? root.upper() : root.lower();
}

}  // namespace vcell
