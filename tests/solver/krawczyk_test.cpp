// The two implementations of the step, against each other and against roots that are known.
#include <doctest/doctest.h>

#include <random>

#include "../../core/solver/roots/solver.hpp"
#include "../test_support.hpp"

namespace vcell::krawczyk_test {

namespace {

/// Quadratic forms with small dyadic coefficients and the root `root`, which is exact in double.
template <int N>
struct Planted {
    PolynomialSystem<N> polynomials;
    Point<N> root;

    explicit Planted(std::mt19937_64& rng) {
        const auto number = [&](int range) {
            return static_cast<double>(std::uniform_int_distribution(-range, range)(rng)) / 16;
        };
        for (double& x : root) x = number(40);
        for (auto& p : polynomials.equations) {
            double at_root = 0;  // a sum of multiples of 2^-12 below 2^12: exact
            for (int i = 0; i < N; ++i) {
                for (int j = i; j < N; ++j) {
                    const double q = rng() % 3 == 0 ? 0 : number(64);
                    typename Polynomial<N>::Term term{q, {}};
                    ++term.exponents[i];
                    ++term.exponents[j];
                    p.terms.push_back(term);
                    at_root += q * root[i] * root[j];
                }
                const double l = number(64);
                typename Polynomial<N>::Term term{l, {}};
                ++term.exponents[i];
                p.terms.push_back(term);
                at_root += l * root[i];
            }
            p.terms.push_back({-at_root, {}});
        }
    }
    template <class T>
    QuadraticForms<N, T> forms() const {
        return QuadraticPolynomials<N>{polynomials}.template forms<T>();
    }
};

template <int N>
IntervalBox<N> box_about(std::mt19937_64& rng, const Point<N>& p, double radius) {
    IntervalBox<N> box;
    std::uniform_real_distribution<double> reach(0, radius);
    for (int i = 0; i < N; ++i) box[i] = {p[i] - reach(rng), p[i] + reach(rng)};
    return box;
}

template <int N>
void check_planted(std::mt19937_64& rng, int systems) {
    int proved = 0;
    for (int n = 0; n < systems; ++n) {
        const Planted<N> s(rng);
        const QuadraticKernel<N> kernel(s.template forms<Interval>(), box_about<N>(rng, s.root, 8.0));
        const QuadraticModel<Interval, N> interval(s.template forms<Interval>());
        const QuadraticModel<Wide, N> wide(s.template forms<Wide>());
        for (const double radius : {4.0, 0.5, 0x1p-6, 0x1p-12, 0x1p-30, 0x1p-44}) {
            const IntervalBox<N> box = box_about<N>(rng, s.root, radius);
            CAPTURE(radius);
            const auto fast = kernel.step(box);
            const auto check = [&](const auto& step) {
                CHECK_FALSE(step.empty);
                CHECK(overlap(converted<Wide>(step.image), converted<Wide>(s.root)));
            };
            check(fast);
            check(krawczyk_step<Interval, N>(interval, box, Preconditioning::Inverse));
            check(krawczyk_step<Interval, N>(interval, box, Preconditioning::RankRevealing));
            check(krawczyk_step<Wide, N>(wide, converted<Wide>(box), Preconditioning::RankRevealing));
            if (!fast.unique()) continue;
            ++proved;
            // A proof in double holds for the arithmetic without rounding.
            const auto precise = krawczyk_step<Wide, N>(wide, converted<Wide>(box), Preconditioning::Inverse);
            CHECK(precise.unique());
            CHECK(is_subset(fast.image, box));
        }
    }
    CHECK(proved > systems);
}

}  // namespace

TEST_CASE("krawczyk step: no step loses a planted root, proofs in double are proofs") {
    std::mt19937_64 rng(test_seed());
    check_planted<1>(rng, 100);
    check_planted<2>(rng, 100);
    check_planted<3>(rng, 60);
    check_planted<4>(rng, 60);
    check_planted<6>(rng, 20);
}

TEST_CASE("krawczyk step: a box without roots is never proved to have one") {
    std::mt19937_64 rng(test_seed());
    int empty = 0;
    for (int n = 0; n < 200; ++n) {
        Planted<2> s(rng);
        // Raise the first equation until it has no zero in the box: all of its terms are below 64.
        const IntervalBox<2> box = box_about<2>(rng, s.root, 0.5);
        s.polynomials.equations[0].terms.push_back({512.0, {}});
        const QuadraticKernel<2> kernel(s.forms<Interval>(), box);
        const auto step = kernel.step(box);
        CHECK_FALSE(step.exists);
        const auto precise = krawczyk_step<Interval, 2>(QuadraticModel<Interval, 2>(s.forms<Interval>()), box,
                                                        Preconditioning::RankRevealing);
        CHECK_FALSE(precise.exists);
        empty += step.empty;
    }
    CHECK(empty > 100);
}

TEST_CASE("krawczyk step: boxes beyond the domain and unbounded ones claim nothing") {
    std::mt19937_64 rng(test_seed());
    const Planted<2> s(rng);
    const QuadraticKernel<2> kernel(s.forms<Interval>(), box_about<2>(rng, s.root, 1.0));
    for (const IntervalBox<2>& box : {IntervalBox<2>{Interval(-1e3, 1e3), Interval(-1e3, 1e3)},
                                      IntervalBox<2>{Interval::whole(), Interval::whole()}}) {
        const auto step = kernel.step(box);
        CHECK_FALSE(step.empty);
        CHECK_FALSE(step.exists);
        CHECK_FALSE(step.injective);
        CHECK(step.image[0].lower() == box[0].lower());
    }
}

TEST_CASE("solver: no planted root is dropped from the whole box") {
    std::mt19937_64 rng(test_seed());
    for (int n = 0; n < 100; ++n) {
        const Planted<3> s(rng);
        const IntervalBox<3> box{Interval(-3, 3), Interval(-3, 3), Interval(-3, 3)};
        const auto found = solve(s.polynomials, box);
        int holders = 0;
        for (const auto& root : found.unique) holders += contains(root.box, s.root);
        bool undecided = false;
        for (const auto& cluster : found.undecided)
            for (const auto& rest : cluster.boxes) undecided = undecided || contains(rest, s.root);
        CHECK((holders == 1 || undecided));
        for (const auto& root : found.unique)
            CHECK(overlap(refine(s.polynomials, root, 100), converted<Wide>(root.box)));
    }
}

}  // namespace vcell::krawczyk_test
