/// Interval Newton with one coordinate as a parameter: the step of the curve solver.
#pragma once

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numeric>

#include "../systems/curve_system.hpp"

namespace vcell::curve {

template <class T, int N>
using Jets = std::array<Jet<T, N + 1>, N>;

inline double midpoint(double x) { return x; }
inline double midpoint(const Interval& x) { return x.mid(); }
inline double midpoint(const Wide& x) { return x.approximation(); }

/// Lower bound of the magnitudes.
inline double mignitude(const Interval& x) {
    return x.lower() > 0 ? x.lower() : x.upper() < 0 ? -x.upper() : 0.0;
}

template <class T, std::size_t D>
std::array<T, D> centre(const std::array<T, D>& box) {
    std::array<T, D> c;
    for (std::size_t i = 0; i < D; ++i) c[i] = T(box[i].mid());
    return c;
}

/// The kernel of the Jacobian's midpoint: component k is (-1)^k times the minor without column k.
/// Points along the curve's orientation.
template <int N, class T>
std::array<double, N + 1> tangent(const Jets<T, N>& j) {
    std::array<double, N + 1> t;
    for (int k = 0; k <= N; ++k) {
        Eigen::Matrix<double, N, N> minor;
        for (int row = 0; row < N; ++row)
            for (int c = 0; c < N; ++c) minor(row, c) = midpoint(j[row].gradient[c < k ? c : c + 1]);
        t[k] = (k % 2 == 0 ? 1 : -1) * minor.determinant();
    }
    return t;
}

/// The system solved for the coordinates other than the axis, linearized over a box: B f with B near the
/// inverse of the Jacobian's minor, so that row i belongs to coordinate column(i).
template <int N, class T>
class Preconditioned {
public:
    static constexpr int D = N + 1;

    Preconditioned(const Jets<T, N>& j, int axis) : axis_(axis) {
        if constexpr (N == 1) {
            jacobian_[0] = j[0].gradient;  // division by the entry itself needs no preconditioner
        } else {
            Eigen::Matrix<double, N, N> minor;
            for (int row = 0; row < N; ++row)
                for (int i = 0; i < N; ++i) minor(row, i) = midpoint(j[row].gradient[column(i)]);
            inverse_ = minor.inverse();
            if (!inverse_.allFinite()) inverse_.setZero();  // proves nothing
            for (int i = 0; i < N; ++i)
                for (int c = 0; c < D; ++c) {
                    T sum(0.0);
                    for (int row = 0; row < N; ++row) sum += T(inverse_(i, row)) * j[row].gradient[c];
                    jacobian_[i][c] = sum;
                }
        }
    }

    int axis() const { return axis_; }
    int column(int i) const { return i < axis_ ? i : i + 1; }
    /// Row i of B J.
    const std::array<T, D>& row(int i) const { return jacobian_[i]; }
    /// B v.
    template <class V>
    std::array<V, N> apply(const std::array<V, N>& v) const {
        if constexpr (N == 1) {
            return v;
        } else {
            std::array<V, N> result;
            for (int i = 0; i < N; ++i) {
                V sum = V(inverse_(i, 0)) * v[0];
                for (int row = 1; row < N; ++row) sum += V(inverse_(i, row)) * v[row];
                result[i] = sum;
            }
            return result;
        }
    }

    /// What is left of the diagonal of row i after the other columns, with coordinates in the given units.
    /// Positive in all rows: every choice of a matrix from the interval matrix is regular (an H-matrix).
    double dominance(int i, const std::array<double, D>& unit) const requires(std::same_as<T, Interval>) {
        double others = 0;
        for (int l = 0; l < N; ++l)
            if (l != i)
                others = Interval::up(others + Interval::up(entry(i, l).magnitude() * unit[column(l)]));
        return Interval::down(Interval::down(mignitude(entry(i, i)) * unit[column(i)]) - others);
    }
    bool regular(const std::array<double, D>& unit) const {
        for (int i = 0; i < N; ++i)
            if (!(dominance(i, unit) > 0)) return false;
        return true;
    }

    /// Hansen-Sengupta over the box y, whose side along the axis is the parameter's range: encloses all
    /// solutions in y. When all sides but the axis lie strictly within y's, one solution exists for every
    /// parameter. at: a point of y; value: B f there. [Neumaier90, sec. 5.1]
    std::array<T, D> newton(const std::array<T, D>& y, const std::array<T, D>& at,
                            const std::array<T, N>& value) const {
        std::array<T, D> result = y;
        for (int i = 0; i < N; ++i) {
            T sum = value[i] + jacobian_[i][axis_] * (y[axis_] - at[axis_]);
            for (int l = 0; l < N; ++l)
                if (l != i) sum += entry(i, l) * (y[column(l)] - at[column(l)]);
            result[column(i)] = at[column(i)] - sum / entry(i, i);
        }
        return result;
    }

    /// Encloses dx / dx[axis] along the curve, for every coordinate. Pre: regular(unit).
    IntervalBox<D> slopes(const std::array<double, D>& unit) const requires(std::same_as<T, Interval>) {
        // G y = -g: with |y_l| <= s unit_l from the diagonal dominance, then row by row.
        double s = 0;
        for (int i = 0; i < N; ++i)
            s = std::max(s, Interval::up(jacobian_[i][axis_].magnitude() / dominance(i, unit)));
        IntervalBox<D> result;
        result[axis_] = Interval(1.0);
        for (int i = 0; i < N; ++i) {
            Interval sum = jacobian_[i][axis_];
            for (int l = 0; l < N; ++l)
                if (l != i) sum += entry(i, l) * Interval::ball(0.0, Interval::up(s * unit[column(l)]));
            result[column(i)] = -(sum / entry(i, i));
        }
        return result;
    }

private:
    const T& entry(int i, int l) const { return jacobian_[i][column(l)]; }

    int axis_;
    Eigen::Matrix<double, N, N> inverse_ = Eigen::Matrix<double, N, N>::Identity();
    std::array<std::array<T, D>, N> jacobian_;
};

/// Newton in double towards the curve f_0 = ... = f_{N-1} = 0 with x[axis] fixed; false when it does not
/// settle.
template <int N>
bool settle(const CurveSystem<N>& f, Point<N + 1>& x, int axis, double tolerance, int steps) {
    for (int step = 0; step < steps; ++step) {
        const auto j = f.differentiate(x);
        double largest = 0;
        if constexpr (N == 1) {
            const double d = -j[0].value / j[0].gradient[1 - axis];
            if (!std::isfinite(d)) return false;
            x[1 - axis] += d;
            largest = std::abs(d);
        } else {
            Eigen::Matrix<double, N, N> minor;
            Eigen::Matrix<double, N, 1> value;
            for (int row = 0; row < N; ++row) {
                value(row) = j[row].value;
                for (int i = 0; i < N; ++i) minor(row, i) = j[row].gradient[i < axis ? i : i + 1];
            }
            const Eigen::Matrix<double, N, 1> d = -(minor.inverse() * value);
            if (!d.allFinite()) return false;
            for (int i = 0; i < N; ++i) x[i < axis ? i : i + 1] += d(i);
            largest = d.template lpNorm<Eigen::Infinity>();
        }
        if (largest <= tolerance) return true;
    }
    return false;
}

/// The box's middle with x[axis] = t.
template <std::size_t D>
Point<static_cast<int>(D)> middle_at(const std::array<Interval, D>& box, int axis, double t) {
    Point<static_cast<int>(D)> m = mid(box);
    m[axis] = t;
    return m;
}

/// Moves x into the box.
template <std::size_t D>
void clamp_into(std::array<double, D>& x, const std::array<Interval, D>& box) {
    for (std::size_t i = 0; i < D; ++i) x[i] = std::clamp(x[i], box[i].lower(), box[i].upper());
}

/// Strictly inside in all coordinates but the axis?
template <class T, std::size_t D>
bool strictly_inside(const std::array<T, D>& inner, const std::array<T, D>& outer, int axis) {
    for (int i = 0; i < static_cast<int>(D); ++i)
        if (i != axis && !(outer[i].lower() < inner[i].lower() && inner[i].upper() < outer[i].upper()))
            return false;
    return true;
}

/// Narrows a box that holds the curve's only points for the parameters t, as far as double intervals can.
template <int N>
IntervalBox<N + 1> narrowed(const CurveSystem<N>& f, IntervalBox<N + 1> y, int axis, const Interval& t) {
    constexpr int D = N + 1;
    y[axis] = t;
    Point<D> m = middle_at(y, axis, t.mid());
    if (settle<N>(f, m, axis, 0x1p-26 * width(y), 6) && contains(y, m)) {
        // Newton about an approximation as good as this proves a solution in a tiny box: the one in y.
        IntervalBox<D> tiny = y;
        for (int i = 0; i < D; ++i)
            if (i != axis) {
                const double r = 0x1p-30 * (y[i].upper() - y[i].lower()) + 0x1p-46 * std::abs(m[i]) +
                                 8 * (t.upper() - t.lower());
                tiny[i] = *intersection(Interval(m[i] - r, m[i] + r), y[i]);
            }
        const Preconditioned<N, Interval> p(f.differentiate(tiny), axis);
        const IntervalBox<D> at = converted<Interval>(m);
        const IntervalBox<D> image = p.newton(tiny, at, p.apply(f(at)));
        if (strictly_inside(image, tiny, axis)) return image;
    }
    for (int step = 0; step < 40; ++step) {
        clamp_into(m, y);
        const Preconditioned<N, Interval> p(f.differentiate(y), axis);
        const IntervalBox<D> at = converted<Interval>(m);
        const auto kept = intersection(p.newton(y, at, p.apply(f(at))), y);
        if (!kept) break;  // cannot be when the box holds a solution
        double before = 0, after = 0;
        for (int i = 0; i < D; ++i)
            if (i != axis)
                before += y[i].upper() - y[i].lower(), after += (*kept)[i].upper() - (*kept)[i].lower();
        y = *kept;
        m = middle_at(y, axis, t.mid());
        if (!(after < 0.9 * before)) break;
    }
    return y;
}

}  // namespace vcell::curve
