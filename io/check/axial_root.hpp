/// The distance of a tube along a ray, in the check's kinds of numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "disc.hpp"
#include "quadrature.hpp"
#include "traced.hpp"

namespace vcell::check {

inline double middle(const MidRad& x) { return x.mid(); }
inline double middle(const Disc& x) { return x.center(); }
inline double middle(const Traced& x) { return x.range().center(); }

/// The t of C - 2 B t - A^2 t^2 = 0 that is (root - B) / A^2, where root^2 = B^2 + A^2 C: in the form in
/// which it does not cancel.
template <class T>
T axial_root(const T& C, const T& B, const T& A, const T& root) {
    const auto first = [&] { return C / (B + root); };
    const auto second = [&] { return (root - B) / square(A); };
    if constexpr (std::is_same_v<T, Approximate>) {
        const T a = first(), b = second();
        return T::of([&](std::size_t k) { return B[k] >= 0 ? a[k] : b[k]; });
    } else {
        if constexpr (std::is_same_v<T, Traced>)  // values may have taken either form
            if (std::abs(B.range().center()) <= B.range().radius() + B.error()) {
                const T a = first(), b = second();
                return T(a.range(), std::max(a.error(), b.error()));
            }
        return middle(B) >= 0 ? first() : second();
    }
}

}  // namespace vcell::check
