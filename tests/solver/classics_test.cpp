// Systems on which solvers have been compared for decades, with the numbers of real roots that the
// literature gives. PHCpack's database of test systems [Verschelde99] lists all complex roots of most.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>

#include "../../core/solver/roots/solver.hpp"

namespace vcell::classics_test {

namespace {

template <int N>
IntervalBox<N> cube(double lo, double hi) {
    IntervalBox<N> box;
    box.fill(Interval(lo, hi));
    return box;
}

/// Adds coefficient * product of the unknowns to equation k.
template <int N>
void add(PolynomialSystem<N>& s, int k, double coefficient, std::initializer_list<int> unknowns) {
    typename Polynomial<N>::Term term{coefficient, {}};
    for (const int i : unknowns) ++term.exponents[i];
    s.equations[k].terms.push_back(term);
}

template <class System, std::size_t N>
auto check_count(const System& system, const std::array<Interval, N>& box, std::size_t count) {
    SolverOptions options;
    options.max_boxes = 400'000;
    auto found = solve(system, box, options);
    CHECK(found.undecided.empty());
    CHECK(found.unique.size() == count);
    for (std::size_t i = 0; i < found.unique.size(); ++i) {
        CHECK(width(found.unique[i].box) < 1e-9);
        for (std::size_t j = 0; j < i; ++j) CHECK_FALSE(overlap(found.unique[i].box, found.unique[j].box));
    }
    return found;
}

struct Caprasse {
    template <class T>
    std::array<T, 4> operator()(const std::array<T, 4>& v) const {
        const auto& [x, y, z, t] = v;
        const auto half = [](const T& a, const T& b, const T& c, const T& d) {
            return -power(a, 3) * c + T(4.0) * a * square(b) * c + T(4.0) * square(a) * b * d +
                   T(2.0) * power(b, 3) * d + T(4.0) * square(a) - T(10.0) * square(b) + T(4.0) * a * c -
                   T(10.0) * b * d + T(2.0);
        };
        return {square(y) * z + T(2.0) * x * y * t - T(2.0) * x - z, half(x, y, z, t),
                T(2.0) * y * z * t + x * square(t) - x - T(2.0) * z, half(z, t, x, y)};
    }
};

struct Noonburg {
    template <class T>
    std::array<T, 3> operator()(const std::array<T, 3>& x) const {
        std::array<T, 3> f;
        for (int i = 0; i < 3; ++i)
            f[i] = x[i] * (square(x[(i + 1) % 3]) + square(x[(i + 2) % 3]) - T(1.1)) + T(1.0);
        return f;
    }
};

template <int N>
struct BroydenBanded {
    template <class T>
    std::array<T, N> operator()(const std::array<T, N>& x) const {
        std::array<T, N> f;
        for (int i = 0; i < N; ++i) {
            f[i] = x[i] * (T(2.0) + T(5.0) * square(x[i])) + T(1.0);
            for (int j = std::max(0, i - 5); j <= std::min(N - 1, i + 1); ++j)
                if (j != i) f[i] -= x[j] * (T(1.0) + x[j]);
        }
        return f;
    }
};

template <int N>
struct BrownAlmostLinear {
    template <class T>
    std::array<T, N> operator()(const std::array<T, N>& x) const {
        std::array<T, N> f;
        T sum(-(N + 1.0)), product(1.0);
        for (const T& v : x) {
            sum += v;
            product *= v;
        }
        for (int i = 0; i < N - 1; ++i) f[i] = x[i] + sum;
        f[N - 1] = product - T(1.0);
        return f;
    }
};

struct Cyclic5 {
    template <class T>
    std::array<T, 5> operator()(const std::array<T, 5>& x) const {
        std::array<T, 5> f;
        for (int length = 1; length <= 5; ++length) {
            T sum(length < 5 ? 0.0 : -1.0);
            for (int i = 0; i < (length < 5 ? 5 : 1); ++i) {
                T product = x[i];
                for (int k = 1; k < length; ++k) product *= x[(i + k) % 5];
                sum += product;
            }
            f[length - 1] = sum;
        }
        return f;
    }
};

}  // namespace

TEST_CASE("solver: Wright's system has 32 real roots [Wright85]") {
    PolynomialSystem<5> s;
    for (int k = 0; k < 5; ++k) {
        add(s, k, 1, {k, k});
        for (int i = 0; i < 5; ++i) add(s, k, i == k ? -1 : 1, {i});
        add(s, k, -10, {});
    }
    const auto found = check_count(s, cube<5>(-10, 10), 32);
    // Among them the two on the diagonal, 2 and -5.
    for (const double v : {2.0, -5.0}) {
        Point<5> p;
        p.fill(v);
        CHECK(std::count_if(found.unique.begin(), found.unique.end(),
                            [&](const auto& root) { return contains(root.box, p); }) == 1);
    }
}

TEST_CASE("solver: the PUMA robot's hand has 16 positions [MS87]") {
    PolynomialSystem<8> s;
    for (int k = 0; k < 4; ++k) {
        add(s, k, 1, {2 * k, 2 * k});
        add(s, k, 1, {2 * k + 1, 2 * k + 1});
        add(s, k, -1, {});
    }
    add(s, 4, 0.004731, {0, 2});
    add(s, 4, -0.3578, {1, 2});
    add(s, 4, -0.1238, {0});
    add(s, 4, -0.001637, {1});
    add(s, 4, -0.9338, {3});
    add(s, 4, 1, {6});
    add(s, 4, -0.3571, {});
    add(s, 5, 0.2238, {0, 2});
    add(s, 5, 0.7623, {1, 2});
    add(s, 5, 0.2638, {0});
    add(s, 5, -0.07745, {1});
    add(s, 5, -0.6734, {3});
    add(s, 5, -0.6022, {});
    add(s, 6, 1, {5, 7});
    add(s, 6, 0.3578, {0});
    add(s, 6, 0.004731, {1});
    add(s, 7, -0.7623, {0});
    add(s, 7, 0.2238, {1});
    add(s, 7, 0.3461, {});
    check_count(s, cube<8>(-1, 1), 16);
}

TEST_CASE("solver: katsura5 as PHCpack lists it has 12 real roots of 32 [Verschelde99]") {
    // Unknowns x y z t u v. The second equation is that of the list: x y and y z are not doubled.
    PolynomialSystem<6> s;
    for (int i = 0; i < 5; ++i) add(s, 0, 2, {i, i});
    add(s, 0, 1, {5, 5});
    add(s, 0, -1, {5});
    add(s, 1, 1, {0, 1});
    add(s, 1, 1, {1, 2});
    add(s, 1, 2, {2, 3});
    add(s, 1, 2, {3, 4});
    add(s, 1, 2, {4, 5});
    add(s, 1, -1, {4});
    add(s, 2, 2, {0, 2});
    add(s, 2, 2, {1, 3});
    add(s, 2, 2, {2, 4});
    add(s, 2, 1, {4, 4});
    add(s, 2, 2, {3, 5});
    add(s, 2, -1, {3});
    add(s, 3, 2, {0, 3});
    add(s, 3, 2, {1, 4});
    add(s, 3, 2, {3, 4});
    add(s, 3, 2, {2, 5});
    add(s, 3, -1, {2});
    add(s, 4, 1, {3, 3});
    add(s, 4, 2, {0, 5});
    add(s, 4, 2, {1, 5});
    add(s, 4, 2, {2, 5});
    add(s, 4, -1, {1});
    for (int i = 0; i < 5; ++i) add(s, 5, 2, {i});
    add(s, 5, 1, {5});
    add(s, 5, -1, {});
    check_count(s, cube<6>(-1, 1), 12);
}

TEST_CASE("solver: Caprasse's system has 18 real roots [HMK97]") {
    const auto found = check_count(Caprasse{}, cube<4>(-10, 10), 18);
    for (const Point<4> p : {Point<4>{2, 1, -2, 1}, Point<4>{-2, 1, 2, 1}, Point<4>{2, -1, -2, -1}})
        CHECK(std::count_if(found.unique.begin(), found.unique.end(),
                            [&](const auto& root) { return contains(root.box, p); }) == 1);
}

TEST_CASE("solver: Noonburg's neural network, n = 3, c = 1.1, has 7 real roots of 21 [Verschelde99]") {
    check_count(Noonburg{}, cube<3>(-10, 10), 7);
}

TEST_CASE("solver: the banded function of Broyden has one root in [-1, 1]^n [HMK97]") {
    check_count(BroydenBanded<5>{}, cube<5>(-1, 1), 1);
    check_count(BroydenBanded<8>{}, cube<8>(-1, 1), 1);
}

TEST_CASE("solver: Brown's almost linear function, n = 5, has 3 real roots [MGH81]") {
    const auto found = check_count(BrownAlmostLinear<5>{}, cube<5>(-20, 20), 3);
    // All but the last unknown are equal to a, the last is 6 - 5a, and a^4 (6 - 5a) = 1: a = 1 is one.
    for (const auto& root : found.unique) {
        const Interval a = root.box[0];
        CHECK((square(square(a)) * (Interval(6.0) - Interval(5.0) * a)).contains(1.0));
    }
}

TEST_CASE("solver: the cyclic 5-roots are real in 10 cases of 70 [BF91]") {
    const auto found = check_count(Cyclic5{}, cube<5>(-3, 3), 10);
    // All are rotations of (1, 1, 1, a, 1/a), a = (-3 +- sqrt 5) / 2.
    for (const auto& root : found.unique)
        CHECK(std::count_if(root.box.begin(), root.box.end(),
                            [](const Interval& x) { return x.contains(1.0); }) == 3);
}

}  // namespace vcell::classics_test
