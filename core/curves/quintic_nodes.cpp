#include "quintic_nodes.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace vcell {

QuinticNodes::QuinticNodes() {
    const double stretch = 2 * std::cos(std::numbers::pi / 12);
    std::array<double, 6> node;
    for (int k = 0; k < 6; ++k) node[k] = 0.5 - std::cos((2 * k + 1) * std::numbers::pi / 12) / stretch;
    const auto factor = [&](int k) {  // s - node[k]
        Bernstein<1> f;
        f.scaled = {-node[k], 1 - node[k]};
        return f;
    };
    const double leading = 32 * std::pow(stretch, 6);  // T_6 = 32 x^6 - ...
    sextic = leading * (factor(0) * factor(1) * factor(2) * factor(3) * factor(4) * factor(5));
    for (int k = 0; k < 6; ++k) {
        double power = 1;
        for (int i = 0; i < 6; ++i, power *= node[k])
            values(i, k) = detail::binomials<5>()[i] * power * std::pow(1 - node[k], 5 - i);
    }
    for (int k = 0; k < 6; ++k) {  // Lagrange's polynomials, one at node[k] and zero at the others
        const auto other = [&](int i) { return factor((k + i) % 6); };
        double there = 1;
        for (int i = 1; i < 6; ++i) there *= node[k] - node[(k + i) % 6];
        const Bernstein<5> product = other(1) * other(2) * other(3) * other(4) * other(5);
        for (int i = 0; i < 6; ++i) coefficients(k, i) = product.coefficient(i) / there;
    }
}

}  // namespace vcell
