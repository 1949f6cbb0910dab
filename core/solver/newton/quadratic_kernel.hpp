/// The step of krawczyk.hpp for quadratic systems, in plain doubles with a-priori error bounds.
///
/// Nothing is rounded outwards on the way. Instead every sum of absolute values that bounds a range is
/// also what bounds its rounding errors: gamma times it, gamma = n u / (1 - n u), for a path of n
/// operations, u = 2^-53 [Higham02, sec. 3.1]. With computed value F and Jacobian J at the middle,
///
///     e_k = |F_k - f_k(m)| + gamma (|F_k| + sum |J_ki| u_i + sum |Q^k_ij| u_i u_j) + (error of J) u
///
/// is what equation k contributes to the error of -B F, I - B J and B Q applied to the box, so row r of
/// the image is off by sum_k |B_rk| e_k at most, whatever B is. The errors of F and J and the widths of
/// the coefficients are bounded once, over the whole domain.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "../systems/quadratic_system.hpp"
#include "box.hpp"
#include "krawczyk.hpp"

namespace vcell {

template <int N>
class QuadraticKernel {
public:
    /// For boxes in `domain` and a little beyond.
    QuadraticKernel(const QuadraticForms<N, Interval>& forms, const IntervalBox<N>& domain);

    /// As krawczyk_step(.., Preconditioning::Inverse). Never stalls.
    Step<Interval, N> step(const IntervalBox<N>& box) const;

    /// Newton's method from x; a small box around its result, likely to hold the root that it found.
    IntervalBox<N> approximate_root(Point<N> x) const;

private:
    static constexpr int pairs = QuadraticForms<N, Interval>::pairs;
    static constexpr double u = 0x1p-53;
    static constexpr double margin = 1.125;  // for regions that reach across the domain's faces
    // Values and Jacobians: products of two unknowns and a coefficient, a sum over at most 2 N + 2 terms.
    static constexpr double gamma_value = (2 * N + 6) * u;
    // The longest path: a combination of N equations (N products and sums), its range over the box (a
    // product of three factors and a sum over N + pairs terms). Doubled, for the rounding of the bound.
    static constexpr double gamma = 2 * (2 * N + N + pairs + 8) * u;
    static constexpr double underflow = std::numeric_limits<double>::min();

    using Vector = std::array<double, N>;  // over the equations, or over the rows of B
    using Matrix = std::array<Vector, N>;  // [unknown][equation]; for B [equation][row]

    void evaluate(const Vector& m, Vector& value, Matrix& jacobian) const;
    static bool invert(const Matrix& jacobian, Matrix& inverse);

    std::array<Vector, pairs> q_;
    std::array<Vector, pairs> abs_q_;
    Matrix l_;
    Vector c_;
    IntervalBox<N> domain_;
    Vector value_error_;  // of evaluate() and of the coefficients, anywhere in the domain
    Matrix jacobian_error_;
};

template <int N>
QuadraticKernel<N>::QuadraticKernel(const QuadraticForms<N, Interval>& forms, const IntervalBox<N>& domain) {
    Vector reach;
    for (int i = 0; i < N; ++i) {
        domain_[i] = Interval::ball(
            domain[i].mid(), margin * domain[i].radius() + (margin - 1) * domain[i].magnitude() * 0x1p-20);
        reach[i] = domain_[i].magnitude();
    }
    // Most coefficients are exact. Twice the radius covers the rounding of the middle.
    const auto radius = [](const Interval& c) { return c.lower() == c.upper() ? 0.0 : c.radius(); };
    const auto middle = [](const Interval& c) { return 0.5 * c.lower() + 0.5 * c.upper(); };
    for (int k = 0; k < N; ++k) {
        c_[k] = middle(forms.constant[k]);
        value_error_[k] = gamma_value * std::abs(c_[k]) + 2 * radius(forms.constant[k]) + underflow;
        for (int i = 0; i < N; ++i) {
            l_[i][k] = middle(forms.linear[i][k]);
            jacobian_error_[i][k] =
                gamma_value * std::abs(l_[i][k]) + 2 * radius(forms.linear[i][k]) + underflow;
            value_error_[k] += jacobian_error_[i][k] * reach[i];
        }
        for (int i = 0, ij = 0; i < N; ++i)
            for (int j = i; j < N; ++j, ++ij) {
                const Interval& q = forms.quadratic[ij][k];
                q_[ij][k] = middle(q);
                abs_q_[ij][k] = std::abs(q_[ij][k]);
                const double error = gamma_value * abs_q_[ij][k] + 2 * radius(q);
                jacobian_error_[i][k] += error * reach[j];
                jacobian_error_[j][k] += error * reach[i];
                value_error_[k] += error * reach[i] * reach[j];
            }
    }
}

template <int N>
inline void QuadraticKernel<N>::evaluate(const Vector& m, Vector& value, Matrix& jacobian) const {
    // f = c + sum m_i (l_i + upper_i), df/dx_i = l_i + upper_i + lower_i with upper_i = sum_{j >= i} q_ij m_j
    // and lower_i = sum_{j <= i} q_ji m_j.
    value = c_;
    Matrix lower{};
    jacobian = l_;
    for (int i = 0, ij = 0; i < N; ++i) {
        for (int j = i; j < N; ++j, ++ij)
            for (int k = 0; k < N; ++k) {
                jacobian[i][k] += q_[ij][k] * m[j];
                lower[j][k] += q_[ij][k] * m[i];
            }
        for (int k = 0; k < N; ++k) value[k] += jacobian[i][k] * m[i];
    }
    for (int i = 0; i < N; ++i)
        for (int k = 0; k < N; ++k) jacobian[i][k] += lower[i][k];
}

// Gauss-Jordan elimination of the columns of J (the unknowns), pivoting among equations. No error bound:
// any B is valid.
template <int N>
inline bool QuadraticKernel<N>::invert(const Matrix& jacobian, Matrix& inverse) {
    Matrix a = jacobian;  // a[i] is the column of unknown i
    Matrix b{};           // b[k][r]: what equation k contributes to row r
    for (int k = 0; k < N; ++k) b[k][k] = 1;
    std::array<int, N> equation;
    for (int k = 0; k < N; ++k) equation[k] = k;
    // Column operations on equations: equation e of (a, b) is a[.][e], b[.][e].
    for (int i = 0; i < N; ++i) {
        int p = i;
        for (int e = i + 1; e < N; ++e)
            if (std::abs(a[i][e]) > std::abs(a[i][p])) p = e;
        if (!(std::abs(a[i][p]) > underflow)) return false;
        if (p != i) {
            for (int j = i; j < N; ++j) std::swap(a[j][i], a[j][p]);
            for (int k = 0; k < N; ++k) std::swap(b[k][i], b[k][p]);
        }
        const double scale = 1 / a[i][i];
        for (int j = i + 1; j < N; ++j) a[j][i] *= scale;
        for (int k = 0; k < N; ++k) b[k][i] *= scale;
        Vector factor = a[i];
        factor[i] = 0;
        for (int j = i + 1; j < N; ++j) {
            const double t = a[j][i];
            for (int e = 0; e < N; ++e) a[j][e] -= factor[e] * t;
        }
        for (int k = 0; k < N; ++k) {
            const double t = b[k][i];
            for (int e = 0; e < N; ++e) b[k][e] -= factor[e] * t;
        }
    }
    inverse = b;
    return true;
}

template <int N>
inline Step<Interval, N> QuadraticKernel<N>::step(const IntervalBox<N>& box) const {
    Step<Interval, N> result;
    result.image = box;
    if (!is_subset(box, domain_)) return result;

    Vector m, w;
    for (int i = 0; i < N; ++i) {
        m[i] = box[i].mid();
        w[i] = Interval::up(std::max(m[i] - box[i].lower(), box[i].upper() - m[i]));
    }
    Vector value;
    Matrix jacobian;
    evaluate(m, value, jacobian);

    // Each equation alone: its range over the box.
    Vector linear{}, crossed{}, above{}, below{}, hidden{};
    for (int i = 0; i < N; ++i)
        for (int k = 0; k < N; ++k) {
            linear[k] += std::abs(jacobian[i][k]) * w[i];
            hidden[k] += jacobian_error_[i][k] * w[i];
        }
    for (int i = 0, ij = 0; i < N; ++i) {
        const double square = w[i] * w[i];
        for (int k = 0; k < N; ++k) {
            above[k] += std::max(q_[ij][k], 0.0) * square;
            below[k] += std::max(-q_[ij][k], 0.0) * square;
        }
        ++ij;
        for (int j = i + 1; j < N; ++j, ++ij)
            for (int k = 0; k < N; ++k) crossed[k] += abs_q_[ij][k] * (w[i] * w[j]);
    }
    Vector error, slope_error;  // the latter of derivatives, times w
    for (int k = 0; k < N; ++k) {
        const double range = linear[k] + crossed[k] + above[k] + below[k];
        slope_error[k] = hidden[k] + 2 * gamma * range;
        error[k] = value_error_[k] + hidden[k] + gamma * (std::abs(value[k]) + range);
        if (value[k] + (linear[k] + crossed[k] + above[k]) + error[k] < 0 ||
            value[k] - (linear[k] + crossed[k] + below[k]) - error[k] > 0) {
            result.empty = true;
            return result;
        }
    }

    Matrix b;
    if (!invert(jacobian, b)) {
        for (int i = 1; i < N; ++i)
            if (w[i] > w[result.split]) result.split = i;
        return result;
    }
    // Rows of B: r runs fastest everywhere.
    Vector shift{}, up_by{}, slope{}, down_by, slope_row{};
    for (int k = 0; k < N; ++k)
        for (int r = 0; r < N; ++r) {
            shift[r] += b[k][r] * value[k];
            up_by[r] += std::abs(b[k][r]) * error[k];
            slope_row[r] += std::abs(b[k][r]) * slope_error[k];
        }
    Matrix residual{};  // |I - B J|, [unknown][row]
    for (int i = 0; i < N; ++i) {
        residual[i][i] = 1;
        for (int k = 0; k < N; ++k)
            for (int r = 0; r < N; ++r) residual[i][r] -= b[k][r] * jacobian[i][k];
        for (int r = 0; r < N; ++r) {
            residual[i][r] = std::abs(residual[i][r]);
            slope[r] += residual[i][r] * w[i];
        }
    }
    for (int r = 0; r < N; ++r) up_by[r] += slope[r];
    down_by = up_by;
    std::array<Vector, pairs> combined;  // |B Q| w w
    Vector bent{};
    for (int i = 0, ij = 0; i < N; ++i)
        for (int j = i; j < N; ++j, ++ij) {
            Vector p{};
            for (int k = 0; k < N; ++k)
                for (int r = 0; r < N; ++r) p[r] += b[k][r] * q_[ij][k];
            const double ww = w[i] * w[j];
            for (int r = 0; r < N; ++r) {
                p[r] *= ww;
                combined[ij][r] = std::abs(p[r]);
                bent[r] += combined[ij][r];
            }
            if (i == j) {
                // -p h^2 with h^2 in [0, w^2].
                for (int r = 0; r < N; ++r) {
                    up_by[r] += std::max(-p[r], 0.0);
                    down_by[r] += std::max(p[r], 0.0);
                }
            } else {
                for (int r = 0; r < N; ++r) {
                    up_by[r] += combined[ij][r];
                    down_by[r] += combined[ij][r];
                }
            }
        }

    result.exists = result.injective = true;
    for (int r = 0; r < N; ++r) {
        const double down_to = down_by[r] * (1 + gamma) + underflow,
                     up_to = up_by[r] * (1 + gamma) + underflow;
        const double lower = Interval::down(m[r] + Interval::down(-shift[r] - down_to));
        const double upper = Interval::up(m[r] + Interval::up(-shift[r] + up_to));
        result.exists = result.exists && box[r].lower() <= lower && upper <= box[r].upper();
        result.injective =
            result.injective && (slope[r] + 2 * bent[r] + slope_row[r]) * (1 + gamma) + underflow < w[r];
        if (lower <= upper) result.image[r] = Interval(lower, upper);  // else not a number: nothing is known
        if (lower > box[r].upper() || upper < box[r].lower()) result.empty = true;
    }
    if (result.empty || result.injective) return result;

    Vector per, score{};
    for (int r = 0; r < N; ++r) per[r] = 1 / w[r];
    for (int i = 0, ij = 0; i < N; ++i) {
        for (int r = 0; r < N; ++r) score[i] += residual[i][r] * w[i] * per[r];
        for (int j = i; j < N; ++j, ++ij) {
            double share = 0;
            for (int r = 0; r < N; ++r) share += combined[ij][r] * per[r];
            score[i] += share;
            score[j] += share;
        }
    }
    result.split = static_cast<int>(std::max_element(score.begin(), score.end()) - score.begin());
    return result;
}

template <int N>
IntervalBox<N> QuadraticKernel<N>::approximate_root(Point<N> x) const {
    Vector value, move;
    Matrix jacobian, b;
    double last = std::numeric_limits<double>::infinity();
    IntervalBox<N> result;
    for (int i = 0; i < N; ++i) result[i] = Interval(x[i]);
    // Quadratic convergence: once a move is below half the digits, the image of a box of that size is as
    // tight as the rounding allows.
    for (int iteration = 0; iteration < 12; ++iteration) {
        evaluate(x, value, jacobian);
        if (!invert(jacobian, b)) break;
        double size = 0, enough = 0;
        move = Vector{};
        Vector error{};
        for (int k = 0; k < N; ++k)
            for (int r = 0; r < N; ++r) {
                move[r] -= b[k][r] * value[k];
                error[r] += std::abs(b[k][r]) * value_error_[k];
            }
        for (int r = 0; r < N; ++r) {
            x[r] += move[r];
            size = std::max(size, std::abs(move[r]));
            enough = std::max({enough, error[r], 0x1p-26 * std::abs(x[r])});
            result[r] =
                Interval::ball(x[r], 2 * error[r] + std::abs(move[r]) * 0x1p-10 + 4 * u * std::abs(x[r]));
        }
        if (!(size > enough && size < 0.5 * last)) break;
        last = size;
    }
    return result;
}

}  // namespace vcell
