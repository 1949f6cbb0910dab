/// Signs and the count of which rung of the ladder decided them.
///
/// Every topological question ends in a sign. It is asked of the cheapest arithmetic first: double
/// with a proven error bound, then double intervals, then exact numbers (or, where a scene's curves
/// leave the quadratic extensions of Q, multiprecision intervals). No sign is ever taken from a bare
/// floating-point difference.
#pragma once

#include "../platform.hpp"

#include <cstdint>

namespace vcell {

enum class Sign : signed char { Negative = -1, Zero = 0, Positive = 1 };

constexpr Sign operator-(Sign s) { return static_cast<Sign>(-static_cast<int>(s)); }
constexpr Sign operator*(Sign a, Sign b) {
    return static_cast<Sign>(static_cast<int>(a) * static_cast<int>(b));
}

/// Sign of an exact value: one compared against T(0), or a double taken at its word.
template <class T>
constexpr Sign sign_of(const T& v) {
    return v > T(0) ? Sign::Positive : v < T(0) ? Sign::Negative : Sign::Zero;
}

/// How many signs each rung decided.
struct Decisions {
    std::uint64_t by_double = 0;
    std::uint64_t by_interval = 0;
    std::uint64_t by_exact = 0;
    std::uint64_t by_multiprecision = 0;
    std::uint64_t assumed = 0;  ///< coincidences taken for granted below a stated width

    std::uint64_t total() const { return by_double + by_interval + by_exact + by_multiprecision + assumed; }
    Decisions& operator+=(const Decisions& o) {
        by_double += o.by_double;
        by_interval += o.by_interval;
        by_exact += o.by_exact;
        by_multiprecision += o.by_multiprecision;
        assumed += o.assumed;
        return *this;
    }
    friend bool operator==(const Decisions&, const Decisions&) = default;
};

}  // namespace vcell
