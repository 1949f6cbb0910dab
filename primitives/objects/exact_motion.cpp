#include "exact_motion.hpp"

#include <cmath>

namespace vcell {

namespace {

const Exact& component(const ExactVector& p, Eigen::Index i) { return i == 0 ? p.x : i == 1 ? p.y : p.z; }

}  // namespace

// Let k be the direction's largest component. It goes to y by a cyclic shift; with -e_k the other two change
// places. The rest is done by the quaternion w + x i + z k about axes across y, w = |d| + |d_k|: it turns
// half-way from the direction beyond e_k. Another cyclic shift makes y the target.
ExactRotation::ExactRotation(const Vec3& direction, Eigen::Index target) {
    Eigen::Index k = 0;
    direction.cwiseAbs().maxCoeff(&k);
    const bool up = direction[k] > 0;
    const Eigen::Index i = (k + (up ? 2 : 1)) % 3, j = (k + (up ? 1 : 2)) % 3;
    double w = 1, x = 0, z = 0;
    if (direction[i] != 0 || direction[j] != 0) {
        const ExactVector d(direction);
        w = rounded_sqrt(dot(d, d)) + std::abs(direction[k]);
        x = -direction[j];
        z = direction[i];
    }
    const Exact ww = Exact(w) * w, xx = Exact(x) * x, zz = Exact(z) * z;
    const Exact wx = 2.0 * Exact(w) * x, wz = 2.0 * Exact(w) * z, xz = 2.0 * Exact(x) * z;
    norm = ww + xx + zz;
    const auto row = [&](const Exact& at_i, const Exact& at_k, const Exact& at_j) {
        std::array<Exact, 3> e;
        e[i] = at_i;
        e[k] = up ? at_k : -at_k;
        e[j] = at_j;
        return ExactVector(e[0], e[1], e[2]);
    };
    rows[(target + 2) % 3] = row(ww + xx - zz, -wz, xz);
    rows[target] = row(wz, ww - xx - zz, -wx);
    rows[(target + 1) % 3] = row(xz, wx, ww - xx + zz);
}

Eigen::Matrix3d ExactRotation::rounded() const {
    Eigen::Matrix3d m;
    for (int r = 0; r < 3; ++r) m.row(r) = rounded(rows[r]);
    return m;
}

double ExactRotation::turn(const Vec3& direction, Eigen::Index target) const {
    const ExactVector image = (*this)(ExactVector(direction));
    const Exact &along = component(image, target), &p = component(image, (target + 1) % 3),
                &q = component(image, (target + 2) % 3);
    if (p.sign() == Sign::Zero && q.sign() == Sign::Zero) return 0;
    const Interval size = sqrt((p * p + q * q).enclosure());
    return (size / along.enclosure()).upper();
}

}  // namespace vcell
