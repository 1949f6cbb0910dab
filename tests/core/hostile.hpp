/// Doubles chosen to break floating-point code, for the tests of intervals and exact numbers.
#pragma once

#include <bit>
#include <cmath>
#include <limits>
#include <random>

namespace vcell {

/// Finite: subnormals, both zeros, numbers next to overflow, powers of two and their neighbours, short
/// integers, and any bit pattern at all.
inline double hostile_double(std::mt19937_64& rng) {
    const auto any = [&] { return std::bit_cast<double>(rng()); };
    const double sign = rng() % 2 ? 1 : -1;
    switch (rng() % 8) {
        case 0: return sign * static_cast<double>(rng() % 4) * std::numeric_limits<double>::denorm_min();
        case 1:
            return sign * static_cast<double>(rng() % (1ull << 52)) *
                   std::numeric_limits<double>::denorm_min();
        case 2: {
            double big = std::numeric_limits<double>::max();
            for (auto i = rng() % 3; i > 0; --i) big = std::nextafter(big, 0.0);
            return sign * big;
        }
        case 3: {
            const double power = std::ldexp(1.0, static_cast<int>(rng() % 2098) - 1074);
            const double towards = rng() % 3 ? (rng() % 2 ? 0.0 : 2 * power) : power;
            return sign * (std::isinf(towards) ? power : std::nextafter(power, towards));
        }
        case 4: return sign * static_cast<double>(rng() % 64);
        case 5:
            return sign * std::ldexp(1 + std::ldexp(static_cast<double>(rng() % 8), -52),
                                     static_cast<int>(rng() % 5) - 2);
        case 6: return sign * std::ldexp(static_cast<double>(rng() >> 11), -53);
        default: break;
    }
    double value = any();
    while (!std::isfinite(value)) value = any();
    return value;
}

/// A random double of magnitude 2^-range to 2^range.
inline double random_double(std::mt19937_64& rng, int range) {
    const double fraction = std::uniform_real_distribution(0.5, 1.0)(rng);
    const int exponent = std::uniform_int_distribution(-range, range)(rng);
    return std::ldexp(rng() % 2 ? fraction : -fraction, exponent);
}

}  // namespace vcell
