/// Coefficients in the arithmetic of a callable's argument: numbers and jets of them.
#pragma once

#include "../../numbers/jet.hpp"
#include "polynomial.hpp"

namespace vcell {

/// The number type of T's coefficients.
template <class T>
struct ScalarOf {
    using type = T;
};
template <class T, int N>
struct ScalarOf<Jet<T, N>> {
    using type = T;
};

template <class T>
T constant(const Coefficient& c) {
    return T(c.in<typename ScalarOf<T>::type>());
}

/// c x; a jet's derivatives are not multiplied by those of c, which are zero.
template <class T>
T scaled(const Coefficient& c, const T& x) {
    return constant<T>(c) * x;
}
template <class T, int N>
Jet<T, N> scaled(const Coefficient& c, const Jet<T, N>& x) {
    Jet<T, N> r;
    r.value = c.in<T>() * x.value;
    for (int i = 0; i < N; ++i) r.gradient[i] = c.in<T>() * x.gradient[i];
    return r;
}

}  // namespace vcell
