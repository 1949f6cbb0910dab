// Tangential, multiple, nearly multiple, missing and boundary roots.
#include <doctest/doctest.h>

#include <cmath>

#include "../../core/solver/roots/solver.hpp"

namespace vcell::multiple_roots_test {

namespace {

template <class F>
struct System2 {
    F f;
    template <class T>
    std::array<T, 2> operator()(const std::array<T, 2>& p) const {
        return f(p[0], p[1]);
    }
};
template <class F>
System2(F) -> System2<F>;

const IntervalBox<2> square_box{Interval(-2, 2), Interval(-2, 2)};

/// No proof, and one small undecided cluster around each of the points.
template <class System>
void check_multiple(const System& system, const std::vector<Point<2>>& points, double size) {
    const auto found = solve(system, square_box);
    CHECK(found.unique.empty());
    CHECK(found.undecided.size() == points.size());
    for (const auto& cluster : found.undecided) CHECK(width(cluster.hull) < size);
    for (const auto& p : points) {
        int around = 0;
        for (const auto& cluster : found.undecided)
            for (const auto& box : cluster.boxes)
                if (contains(box, p)) {
                    ++around;
                    break;
                }
        CHECK(around == 1);
    }
}

/// The circle of radius 1 and the line y = height.
PolynomialSystem<2> circle_and_line(double height) {
    return {{Polynomial<2>{{{1.0, {2, 0}}, {1.0, {0, 2}}, {-1.0, {0, 0}}}},
             Polynomial<2>{{{1.0, {0, 1}}, {-height, {0, 0}}}}}};
}

}  // namespace

TEST_CASE("solver: a tangent line's double root is undecided, whatever form the equations have") {
    check_multiple(circle_and_line(1.0), {{0, 1}}, 1e-10);
    check_multiple(System2{[](const auto& x, const auto& y) {
                       using T = std::decay_t<decltype(x)>;
                       return std::array<T, 2>{square(x) + square(y) - T(1.0), y - T(1.0)};
                   }},
                   {{0, 1}}, 1e-6);
}

TEST_CASE("solver: a double root in general position is undecided") {
    // x + y = 2 touches x^2 + y^2 = 2 at (1, 1), and -2 at (-1, -1): (x + y)^2 = 4.
    check_multiple(
        PolynomialSystem<2>{{Polynomial<2>{{{1.0, {2, 0}}, {1.0, {0, 2}}, {-2.0, {0, 0}}}},
                             Polynomial<2>{{{1.0, {2, 0}}, {2.0, {1, 1}}, {1.0, {0, 2}}, {-4.0, {0, 0}}}}}},
        {{1, 1}, {-1, -1}}, 1e-6);
}

TEST_CASE("solver: triple and fourfold roots are undecided") {
    check_multiple(System2{[](const auto& x, const auto& y) {
                       using T = std::decay_t<decltype(x)>;
                       return std::array<T, 2>{power(x, 3), y - x};
                   }},
                   {{0, 0}}, 1e-6);
    check_multiple(
        PolynomialSystem<2>{{Polynomial<2>{{{1.0, {2, 0}}, {-1.0, {0, 2}}}}, Polynomial<2>{{{1.0, {1, 1}}}}}},
        {{0, 0}}, 1e-6);
}

TEST_CASE("solver: two roots apart by down to 2^-26 are proved, near misses refuted") {
    for (int k = 4; k <= 52; k += 4) {
        CAPTURE(k);
        // y = 1 -+ 2^-k: x^2 = +-2^(1-k) - 2^(-2k).
        const double shift = std::ldexp(1.0, -k);
        const auto two = solve(circle_and_line(1 - shift), square_box);
        CHECK(two.undecided.empty());
        REQUIRE(two.unique.size() == 2);
        const Wide x = sqrt(Wide(2 * shift) - square(Wide(shift)));
        for (const auto& root : two.unique) {
            const auto refined = refine(circle_and_line(1 - shift), root, 150);
            CHECK((refined[0].contains(x) || refined[0].contains(-x) ||
                   (square(refined[0]) - square(x)).contains(0.0)));
            CHECK(refined[0].sign().has_value());
        }
        CHECK_FALSE(overlap(two.unique[0].box, two.unique[1].box));

        const auto none = solve(circle_and_line(1 + shift), square_box);
        CHECK(none.unique.empty());
        CHECK(none.undecided.empty());
    }
}

TEST_CASE("solver: without multiprecision, nearly double roots stay undecided, none is lost") {
    SolverOptions options;
    options.max_wide_boxes = 0;
    const auto found = solve(circle_and_line(1 - 0x1p-52), square_box, options);
    CHECK(found.unique.empty());
    REQUIRE(found.undecided.size() == 1);
    CHECK(contains(found.undecided[0].hull, Point<2>{std::sqrt(0x1p-51), 1 - 0x1p-52}));
    CHECK(contains(found.undecided[0].hull, Point<2>{-std::sqrt(0x1p-51), 1 - 0x1p-52}));
}

TEST_CASE("solver: empty systems have neither roots nor undecided boxes") {
    const PolynomialSystem<2> above{{Polynomial<2>{{{1.0, {2, 0}}, {1.0, {0, 2}}, {1.0, {0, 0}}}},
                                     Polynomial<2>{{{1.0, {1, 0}}, {-1.0, {0, 1}}}}}};
    const System2 parallel{[](const auto& x, const auto& y) {
        using T = std::decay_t<decltype(x)>;
        return std::array<T, 2>{x + y, x + y - T(0.5)};
    }};
    for (const auto& found :
         {solve(above, square_box), solve(parallel, square_box), solve(circle_and_line(1.5), square_box)}) {
        CHECK(found.unique.empty());
        CHECK(found.undecided.empty());
    }
}

TEST_CASE("solver: roots on faces and corners belong to the closed box, and are marked") {
    // (+-1, +-1).
    const PolynomialSystem<2> corners{
        {Polynomial<2>{{{1.0, {2, 0}}, {-1.0, {0, 0}}}}, Polynomial<2>{{{1.0, {0, 2}}, {-1.0, {0, 0}}}}}};
    const auto count = [&](double x_lo, double x_hi, double y_lo, double y_hi) {
        const auto found = solve(corners, IntervalBox<2>{Interval(x_lo, x_hi), Interval(y_lo, y_hi)});
        CHECK(found.undecided.empty());
        const auto marked = std::count_if(found.unique.begin(), found.unique.end(),
                                          [](const auto& root) { return root.on_boundary; });
        return std::pair(found.unique.size(), static_cast<std::size_t>(marked));
    };
    using Counts = std::pair<std::size_t, std::size_t>;
    CHECK(count(-1, 1, -1, 1) == Counts(4, 4));
    CHECK(count(-1, 2, -2, 2) == Counts(4, 2));
    CHECK(count(-2, 2, -2, 2) == Counts(4, 0));
    CHECK(count(0, 1, 0, 1) == Counts(1, 1));
    // One ulp decides.
    CHECK(count(-2, 1 - 0x1p-53, -2, 2) == Counts(2, 0));
    CHECK(count(-2, 1 + 0x1p-52, -2, 2) == Counts(4, 0));
    CHECK(count(-1 + 0x1p-53, 1 - 0x1p-53, -2, 2) == Counts(0, 0));
}

TEST_CASE("solver: dependent equations are covered by undecided boxes") {
    const System2 dependent{[](const auto& x, const auto& y) {
        using T = std::decay_t<decltype(x)>;
        return std::array<T, 2>{x * x + y - T(1.0), T(2.0) * x * x + T(2.0) * y - T(2.0)};
    }};
    SolverOptions options;
    options.max_boxes = 2'000;
    options.max_wide_boxes = 100;
    const auto found = solve(dependent, square_box, options);
    CHECK(found.unique.empty());
    for (double x = -1.5; x <= 1.5; x += 0.125) {
        bool covered = false;
        for (const auto& cluster : found.undecided)
            for (const auto& box : cluster.boxes) covered = covered || contains(box, Point<2>{x, 1 - x * x});
        CHECK(covered);
    }
}

TEST_CASE("solver: coefficients that are no doubles are solved to the last digit that they have") {
    // x^2 = sqrt(3), y = sqrt(3) x.
    const Wide root3 = sqrt(Wide(3.0));
    const auto system = [](const Coefficient& minus_root3) {
        return PolynomialSystem<2>{{Polynomial<2>{{{1.0, {2, 0}}, {minus_root3, {0, 0}}}},
                                    Polynomial<2>{{{1.0, {0, 1}}, {minus_root3, {1, 0}}}}}};
    };
    const IntervalBox<2> box{Interval(0, 4), Interval(0, 4)};
    const auto precise = solve(system(-root3), box);
    REQUIRE(precise.unique.size() == 1);
    const auto refined = refine(system(-root3), precise.unique[0], 280);
    CHECK((refined[0] - sqrt(root3)).contains(0.0));
    CHECK(refined[0].radius_exponent() < -280);
    // An enclosure in double: one root for each of its members.
    const auto enclosed = solve(system((-root3).enclosure()), box);
    REQUIRE(enclosed.unique.size() == 1);
    CHECK(is_subset(sqrt(root3), Wide(enclosed.unique[0].box[0])));
}

TEST_CASE("certify: finds and proves the root near a point, and only there") {
    const auto system = circle_and_line(0.6);
    const System2 callable{[](const auto& x, const auto& y) {
        using T = std::decay_t<decltype(x)>;
        using std::sqrt;
        return std::array<T, 2>{sqrt(square(x) + square(y)) - T(1.0), y - T(0.6)};
    }};
    const auto check = [](const auto& box) {
        REQUIRE(box);
        CHECK((*box)[0].contains(0.8));
        CHECK((*box)[1].contains(0.6));
        CHECK(width(*box) < 1e-13);
    };
    check(certify(callable, Point<2>{0.75, 0.55}, 0.25));
    check(certify(QuadraticPolynomials<2>{system}, Point<2>{0.75, 0.55}, 0.25));
    CHECK_FALSE(certify(callable, Point<2>{0.3, 0.55}, 0.25));
    CHECK_FALSE(certify(circle_and_line(1.0), Point<2>{0.125, 1}, 0.25));
    CHECK_FALSE(certify(circle_and_line(1.5), Point<2>{0.1, 1}, 1.0));
}

TEST_CASE("certify: multiprecision proves what doubles cannot") {
    const double height = 1 - 0x1p-50;
    const Wide x = sqrt(Wide(0x1p-49) - Wide(0x1p-100));
    for (const double side : {-1.0, 1.0}) {
        const auto box = certify(circle_and_line(height), Point<2>{side * 5e-8, 1}, 1e-7);
        REQUIRE(box);
        CHECK(is_subset(Wide(side) * x, Wide((*box)[0])));
        CHECK(width(*box) < 1e-7);
    }
}

}  // namespace vcell::multiple_roots_test
