/// The common point of three conditions, enclosed.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "space.hpp"

namespace vcell::check {

inline double lower_bound(const Interval& x) { return x.lower(); }
inline double upper_bound(const Interval& x) { return x.upper(); }
inline double lower_bound(const Wide& x) { return x.enclosure().lower(); }
inline double upper_bound(const Wide& x) { return x.enclosure().upper(); }

/// Three of the conditions whose gradients at p are farthest from dependent: the longest one, then each that
/// adds most to those before. Fewer where no third one adds anything.
std::vector<Condition> independent(const Space<Interval>& space, std::span<const Condition> conditions,
                                   const Vec3& p);

/// A box with exactly one point where all three excesses are zero, or nothing if there is no proof of one
/// within about `reach` of the start. Krawczyk's operator K(X) = m - Y f(m) + (I - Y J(X)) (X - m): K(X) in
/// the interior of X proves that X holds one zero, and K(X) holds it, too [Neumaier90, Theorem 5.1.8].
template <class T>
std::optional<Vector<T>> enclose(const Space<T>& space, const std::array<Condition, 3>& conditions,
                                 const Vec3& start, double reach, int rounds) {
    Vector<T> m = to_vector<T>(start);
    Eigen::Matrix3d j;
    const auto slope = [&](const Vector<T>& x, int row) { return space.gradient(conditions[row], x); };
    const auto number = [](const T& x) {
        if constexpr (std::is_same_v<T, Interval>)
            return x.mid();
        else
            return x.approximation();
    };
    for (int r = 0; r < 3; ++r) {
        const Vector<T> g = slope(m, r);
        for (int k = 0; k < 3; ++k) j(r, k) = number(g[k]);
    }
    const Eigen::Matrix3d y = j.inverse();
    if (!y.allFinite()) return std::nullopt;
    std::optional<Vector<T>> found;
    for (int round = 0; round < rounds; ++round) {
        Vector<T> f;
        for (int r = 0; r < 3; ++r) f[r] = space.excess(conditions[r], m);
        Vector<T> newton;  // m - Y f(m)
        double step = 0;
        for (int r = 0; r < 3; ++r) {
            const T move = T(y(r, 0)) * f[0] + T(y(r, 1)) * f[1] + T(y(r, 2)) * f[2];
            newton[r] = m[r] - move;
            step = std::max(step, upper_bound(magnitude(move)));
        }
        // After a proof only the part of K(X) beside m matters: X shrinks to the last box.
        const double half = 4 * step + 0x1p-52 * start.cwiseAbs().maxCoeff();
        if (!found && !(half <= reach)) return std::nullopt;
        Vector<T> x;
        for (int r = 0; r < 3; ++r) x[r] = found ? (*found)[r] : m[r] + T(-half, half);
        std::array<Vector<T>, 3> jacobian;
        for (int r = 0; r < 3; ++r) jacobian[r] = slope(x, r);
        Vector<T> k;
        bool inside = true;
        for (int r = 0; r < 3; ++r) {
            T sum = newton[r];
            for (int c = 0; c < 3; ++c) {
                const T product = T(y(r, 0)) * jacobian[0][c] + T(y(r, 1)) * jacobian[1][c] + T(y(r, 2)) * jacobian[2][c];
                sum += (T(r == c ? 1.0 : 0.0) - product) * (x[c] - m[c]);
            }
            k[r] = sum;
            inside = inside && k[r].lower() > x[r].lower() && k[r].upper() < x[r].upper();
        }
        if (found) {  // a point of the box stays one of K(X): their intersection
            for (int r = 0; r < 3; ++r)
                k[r] = {std::max(k[r].lower(), (*found)[r].lower()), std::min(k[r].upper(), (*found)[r].upper())};
        } else if (!inside) {
            // A better start, before a proof is tried again.
            for (int r = 0; r < 3; ++r) m[r] = newton[r].mid();
            continue;
        }
        found = k;
        for (int r = 0; r < 3; ++r) m[r] = k[r].mid();
    }
    return found;
}

}  // namespace vcell::check
