/// Exact numbers in interval arithmetic.
#pragma once

#include <type_traits>

#include "exact.hpp"
#include "interval.hpp"
#include "wide.hpp"

namespace vcell {

/// An enclosure of an exact number on either rung.
template <class T>
T enclosure_of(const Exact& e) {
    if constexpr (std::is_same_v<T, Interval>) {
        return e.enclosure();
    } else {
        // Doubles peeled off from the front until they fill the number type.
        T sum(0.0);
        Exact rest = e;
        for (int bits = 0; bits <= T::bits && rest.sign() != Sign::Zero; bits += 53) {
            const double head = rest.enclosure().lower();
            sum += T(head);
            rest -= Exact(head);
        }
        return sum + T(rest.enclosure());
    }
}

}  // namespace vcell
