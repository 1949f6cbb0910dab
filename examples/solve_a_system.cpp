// All common points of two ellipses, proved; the nearly tangent case to the last digit.
#include <cstdio>
#include <vcell/core/solver/roots/solver.hpp>

// x^2 + 4 y^2 = 4 and 4 x^2 + (y - h)^2 = 4, in any number type.
struct Ellipses {
    double h;

    template <class T>
    std::array<T, 2> operator()(const std::array<T, 2>& p) const {
        const auto& [x, y] = p;
        return {square(x) + T(4.0) * square(y) - T(4.0), T(4.0) * square(x) + square(y - T(h)) - T(4.0)};
    }
};

int main() {
    const vcell::IntervalBox<2> box{vcell::Interval(-3, 3), vcell::Interval(-3, 3)};
    for (const double h : {0.0, 3 - 0x1p-40, 3.0, 3 + 0x1p-40}) {
        const auto found = vcell::solve(Ellipses{h}, box);
        std::printf("h = 3 %+.1e: %zu roots, %zu undecided\n", h - 3, found.unique.size(),
                    found.undecided.size());
        for (const vcell::Root<2>& root : found.unique) {
            const auto exact = vcell::refine(Ellipses{h}, root, 200);
            std::printf("  x = %+.17f  y = %+.17f  proved within 2^%d\n", exact[0].approximation(),
                        exact[1].approximation(), exact[0].radius_exponent());
        }
        for (const auto& cluster : found.undecided)
            std::printf("  perhaps at x = %+.6f  y = %+.6f\n", cluster.hull[0].mid(), cluster.hull[1].mid());
    }
}
