/// The common point of three conditions, enclosed.
#pragma once

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "space.hpp"

namespace vcell::check {

/// Three of the conditions that tell best where their common point near p is: the one with the longest
/// gradient for what its excess is known to, then each that adds most to those before. Fewer where no third
/// one adds anything.
std::vector<Condition> independent(const Space<Interval>& space, std::span<const Condition> conditions,
                                   const Vec3& p);

/// Where a common zero is: in center + offset. The offset's digits are not lost in those of the center.
template <class T>
struct Enclosure {
    Vector<T> center, offset;

    Vector<T> box() const { return center + offset; }
    T distance(const Vec3& p) const { return sqrt(square((center - to_vector<T>(p)) + offset)); }
};

/// Equations with gradients that are all but equal: one less another has the same zeros, and a gradient that
/// doubles hold. What they are in doubles themselves has no inverse.
struct AllButEqualRows {
    std::array<int, 3> less{0, 1, 2};  ///< of which row is subtracted; its own: of none

    template <class T>
    void choose(const std::array<Vector<T>, 3>& gradients) {
        constexpr double near = 0x1p-40;
        for (int r = 1; r < 3; ++r) {
            less[r] = r;
            for (int k = 0; k < r && less[r] == r; ++k)
                if (upper_bound(square(gradients[r] - gradients[k])) <
                    near * lower_bound(square(gradients[r])))
                    less[r] = k;
        }
    }
    template <class V>
    void subtract(std::array<V, 3>& rows) const {
        for (int r = 2; r > 0; --r)
            if (less[r] != r) rows[r] = rows[r] - rows[less[r]];
    }
};

/// A box with exactly one point where all three excesses are zero, or nothing if there is no proof of one
/// within about `reach` of the start. Krawczyk's operator K(D) = -Y f(m) + (I - Y J(m + D)) D: K(D) in the
/// interior of D proves that m + D holds one zero, and m + K(D) holds it, too [Neumaier90, Theorem 5.1.8].
template <class T>
std::optional<Enclosure<T>> enclose(const Space<T>& space, const std::array<Condition, 3>& conditions,
                                    const Vec3& start, double reach, int rounds) {
    const auto number = [](const T& x) {
        if constexpr (std::is_same_v<T, Interval>)
            return x.mid();
        else
            return x.approximation();
    };
    Vector<T> m = to_vector<T>(start);
    Eigen::Matrix3d inverse;
    const auto y = [&](int r, const Vector<T>& f) {
        return T(inverse(r, 0)) * f[0] + T(inverse(r, 1)) * f[1] + T(inverse(r, 2)) * f[2];
    };
    const double size = start.cwiseAbs().maxCoeff(), least = 0x1p-80 * size;
    double last = HUGE_VAL;  // width
    std::optional<Enclosure<T>> found;
    AllButEqualRows rows;
    for (int round = 0; round < rounds; ++round) {
        // Any matrix serves as Y. That of the present m, or of a small box around it, keeps the contraction
        // quadratic up to a double's digits.
        Vector<T> d;
        std::array<Vector<T>, 3> jacobian;
        if (found) d = found->offset;
        for (int r = 0; r < 3; ++r) jacobian[r] = space.gradient(conditions[r], found ? m + d : m);
        rows.choose(jacobian);
        rows.subtract(jacobian);
        Eigen::Matrix3d j;
        for (int r = 0; r < 3; ++r)
            for (int k = 0; k < 3; ++k) j(r, k) = number(jacobian[r][k]);
        inverse = j.inverse();
        if (!inverse.allFinite()) return found;
        Vector<T> f, newton;
        double step = 0;
        for (int r = 0; r < 3; ++r) f[r] = space.excess(conditions[r], m);
        rows.subtract(f);
        for (int r = 0; r < 3; ++r) {
            newton[r] = -y(r, f);
            step = std::max(step, upper_bound(magnitude(newton[r])));
        }
        const double half = 4 * step + least;
        if (!found) {
            if (!(half <= reach)) return std::nullopt;
            d.fill(T(-half, half));
            for (int r = 0; r < 3; ++r) jacobian[r] = space.gradient(conditions[r], m + d);
            rows.subtract(jacobian);
        }
        Vector<T> k;
        bool inside = true;
        for (int r = 0; r < 3; ++r) {
            k[r] = newton[r];
            for (int c = 0; c < 3; ++c) {
                const T product = y(r, {jacobian[0][c], jacobian[1][c], jacobian[2][c]});
                k[r] += (T(r == c ? 1.0 : 0.0) - product) * d[c];
            }
            inside = inside && k[r].lower() > d[r].lower() && k[r].upper() < d[r].upper();
        }
        if (!found && !inside) {  // a better start, before a proof is tried again
            for (int r = 0; r < 3; ++r) m[r] = (m[r] + newton[r]).mid();
            continue;
        }
        if (found)  // the zero stays in the intersection
            for (int r = 0; r < 3; ++r)
                k[r] = T(std::max(k[r].lower(), d[r].lower()), std::min(k[r].upper(), d[r].upper()));
        found = Enclosure<T>{m, k};
        double width = 0;
        for (const T& x : k) width = std::max(width, upper_bound(x - x.mid()));
        // In doubles the center's rounding is the limit. Rounds that gain nothing are the last.
        constexpr double kEnough = std::is_same_v<T, Interval> ? 0x1p28 : 0x1p-100;
        if (width <= kEnough * least || width > 0.5 * last) return found;
        last = width;
        for (int r = 0; r < 3; ++r) {
            const T shift = k[r].mid();
            m[r] = (m[r] + shift).mid();
            // m is not the exact sum: the offset takes what rounding has left.
            k[r] = k[r] + (found->center[r] - m[r]);
        }
        found = Enclosure<T>{m, k};
    }
    return found;
}

/// As enclose(), by one step of Krawczyk's from a point that is all but the true one: of the Jacobian over
/// the box only how far its rows may turn is asked. None: it takes more than that, or the base is a cylinder.
std::optional<Enclosure<Interval>> enclose_nearby(const Scene& scene, const Space<Interval>& space,
                                                  std::span<const Condition> three, const Vec3& p);

}  // namespace vcell::check
