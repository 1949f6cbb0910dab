#include "forms.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace vcell::check {

namespace {

constexpr int kRows = kMaxBinomial + 1;
using Triangle = std::array<std::array<double, kRows>, kRows>;

/// Pascal's triangle. Numbers beyond 2^53 are rounded, each row a little more: no more than 2^-45 in all.
constexpr Triangle triangle = [] {
    Triangle t{};
    for (int n = 0; n < kRows; ++n) {
        t[n][0] = 1;
        for (int k = 1; k <= n; ++k) t[n][k] = t[n - 1][k - 1] + (k < n ? t[n - 1][k] : 0);
    }
    return t;
}();

constexpr Triangle inverses = [] {
    Triangle t{};
    for (int n = 0; n < kRows; ++n)
        for (int k = 0; k <= n; ++k) t[n][k] = 1 / triangle[n][k];
    return t;
}();

/// Relative: what two binomials, or their inverses, and products with them may be off by. Up to 56 over k
/// they are exact, and their inverses rounded once.
double rounding_of_binomials(int m, int n) { return std::max(m, n) <= 56 ? 0x1p-50 : 0x1p-43; }

/// Convolution of polynomials of degrees (M, N) and (P, Q). What is known to the compiler stays in registers.
template <int M, int N, int P, int Q>
void add_convolution(double sign, const double* a, const double* b, double* r) {
    constexpr int width = N + Q + 1;
    std::array<double, static_cast<std::size_t>((M + P + 1) * width)> sum{};
    for (int i = 0; i <= M; ++i)
        for (int k = 0; k <= P; ++k)
            for (int j = 0; j <= N; ++j) {
                const double x = a[i * (N + 1) + j];
                double* const row = &sum[static_cast<std::size_t>((i + k) * width + j)];
                for (int l = 0; l <= Q; ++l) row[l] += x * b[k * (Q + 1) + l];
            }
    for (double& x : sum) *r++ += sign * x;
}

}  // namespace

double binomial(int n, int k) {
    assert(n < kRows);
    return triangle[n][k];
}

void Form::set(int i, int j, const MidRad& coefficient) {
    c_[static_cast<std::size_t>(i * (n_ + 1) + j)] = coefficient.mid() * (binomial(m_, i) * binomial(n_, j));
    const double error = coefficient.radius() +
                         rounding_of_binomials(m_, n_) * (std::abs(coefficient.mid()) + coefficient.radius());
    if (!(error <= error_)) error_ = error;
    norm_ = -1;
}

double Form::norm() const {
    if (norm_ >= 0) return norm_;
    const auto &rows = inverses[m_], &columns = inverses[n_];
    double most = 0;
    const double* c = c_.data();
    for (int i = 0; i <= m_; ++i) {
        double row = 0;  // what is not a number is found by range()
        for (int j = 0; j <= n_; ++j) row = std::max(row, std::abs(*c++) * columns[j]);
        most = std::max(most, row * rows[i]);
    }
    norm_ = most * (1 + rounding_of_binomials(m_, n_));
    return norm_;
}

// Not a number stays none, and is taken for no bound by range(). What is added for subnormal numbers is far
// above what products lose to them.
void Form::add_error(double error) {
    error_ = (error_ + error) * (1 + 0x1p-40) + std::numeric_limits<double>::min();
}

bool Form::add_usual_product(double sign, const Form& a, const Form& b) {
    const auto adds = [&]<int M, int N, int P, int Q>(std::integer_sequence<int, M, N, P, Q>) {
        if (a.m_ != M || a.n_ != N || b.m_ != P || b.n_ != Q) return false;
        // In one variable rows are told apart no more than columns.
        constexpr bool is_column = N == 0 && Q == 0;
        add_convolution<is_column ? 0 : M, is_column ? M : N, is_column ? 0 : P, is_column ? P : Q>(
            sign, a.c_.data(), b.c_.data(), c_.data());
        return true;
    };
    const auto any = [&]<class... Degrees>(Degrees... degrees) { return (adds(degrees) || ...); };
    using std::integer_sequence;
    return any(integer_sequence<int, 2, 2, 2, 2>(), integer_sequence<int, 4, 4, 4, 4>(),
               integer_sequence<int, 2, 0, 2, 0>(), integer_sequence<int, 5, 0, 5, 0>(),
               integer_sequence<int, 10, 0, 10, 0>(), integer_sequence<int, 8, 0, 2, 0>());
}

// A sum of n products is off by at most n 2^-53 / (1 - n 2^-53) times the sum of their magnitudes [Higham02,
// sec. 3.1], which in the Bernstein basis is a mean of products of magnitudes. What was there before is
// rounded with each of them.
void Form::add_product(double sign, const Form& a, const Form& b) {
    assert(m_ == a.m_ + b.m_ && n_ == a.n_ + b.n_);
    const double terms = (std::min(a.m_, b.m_) + 1) * (std::min(a.n_, b.n_) + 1);
    const double size = a.norm(), other = &a == &b ? size : b.norm(), before = norm();
    if (!add_usual_product(sign, a, b) && !add_usual_product(sign, b, a))
        for (int i = 0; i <= a.m_; ++i)
            for (int k = 0; k <= b.m_; ++k) {
                double* const row = c_.data() + (i + k) * (n_ + 1);
                for (int j = 0; j <= a.n_; ++j) {
                    const double factor = sign * a.at(i, j);
                    for (int l = 0; l <= b.n_; ++l) row[j + l] += factor * b.at(k, l);
                }
            }
    norm_ = (before + size * other) * (1 + 0x1p-40);
    add_error(terms * 0x1p-53 * (size * other + before) + a.error_ * other + b.error_ * (size + a.error_));
}

Interval Form::range() const {
    const auto &rows = inverses[m_], &columns = inverses[n_];
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    const double* c = c_.data();
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            const double x = *c++ * (rows[i] * columns[j]);
            if (x != x) return Interval::whole();
            lo = std::min(lo, x);
            hi = std::max(hi, x);
        }
    const double error = error_ + rounding_of_binomials(m_, n_) * std::max(std::abs(lo), std::abs(hi));
    if (!(error * (1 + 0x1p-40) < HUGE_VAL)) return Interval::whole();
    return {Interval::down(lo - error * (1 + 0x1p-40)), Interval::up(hi + error * (1 + 0x1p-40))};
}

}  // namespace vcell::check
