/// The nodes in [0, 1] at which quintic spans interpolate: both ends and four in between, where the sextic
/// that vanishes at all of them stays smallest (Chebyshev's, stretched). What is interpolated errs by a
/// multiple of that sextic and so by a 25th of what Hermite's data at the ends leave.
#pragma once

#include <Eigen/Core>

#include "scaled_bernstein.hpp"

namespace vcell {

struct QuinticNodes {
    Eigen::Matrix<double, 6, 6> values;        ///< of the Bernstein polynomials (rows) at the nodes
    Eigen::Matrix<double, 6, 6> coefficients;  ///< the inverse
    Bernstein<6> sextic;                       ///< between -1 and 1

    static const QuinticNodes& get() {
        static const QuinticNodes value;
        return value;
    }

    /// Bounds |p|, closely if p all but vanishes at the nodes: p = sextic q + r, where q, of degree 4, varies
    /// little and r is next to nothing. Whatever q is, r is what is left; the ends of q are taken from p's.
    double largest(const Bernstein<10>& p) const {
        const auto& a = p.scaled;
        const auto& w = sextic.scaled;
        Bernstein<4> q;
        auto& b = q.scaled;
        b[0] = a[1] / w[1];
        b[1] = (a[2] - w[2] * b[0]) / w[1];
        b[4] = a[9] / w[5];
        b[3] = (a[8] - w[4] * b[4]) / w[5];
        b[2] = (a[5] - w[5] * b[0] - w[4] * b[1] - w[2] * b[3] - w[1] * b[4]) / w[3];
        constexpr double outwards = 1 + 0x1p-34;  // terms some 4000 times as large as q cancel in r
        return outwards * (q.largest() + (p - sextic * q).largest());
    }

private:
    QuinticNodes();
};

}  // namespace vcell
