#include "forms.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace vcell::check {

namespace {

constexpr int kRows = kMaxBinomial + 1;
using Triangle = std::array<std::array<double, kRows>, kRows>;

/// Pascal's triangle. Numbers beyond 2^53 are rounded, each row a little more: below 2^-45 in all.
const Triangle& triangle() {
    static const Triangle rows = [] {
        Triangle t{};
        for (int n = 0; n < kRows; ++n) {
            t[n][0] = 1;
            for (int k = 1; k <= n; ++k) t[n][k] = t[n - 1][k - 1] + (k < n ? t[n - 1][k] : 0);
        }
        return t;
    }();
    return rows;
}

const Triangle& inverses() {
    static const Triangle rows = [] {
        Triangle t{};
        for (int n = 0; n < kRows; ++n)
            for (int k = 0; k <= n; ++k) t[n][k] = 1 / triangle()[n][k];
        return t;
    }();
    return rows;
}

/// Relative: what two binomials, or their inverses, and products with them may be off by. Up to 56 over k they are
/// exact, and their inverses rounded once.
double rounding_of_binomials(int m, int n) { return std::max(m, n) <= 56 ? 0x1p-50 : 0x1p-43; }

constexpr double kUnit = 0x1p-53;

/// Convolution in both variables, of polynomials of degrees (M, N) and (P, Q).
template <int M, int N, int P, int Q>
void convolve(const double* a, const double* b, double* r) {
    for (int i = 0; i <= M; ++i)
        for (int k = 0; k <= P; ++k)
            for (int j = 0; j <= N; ++j)
                for (int l = 0; l <= Q; ++l)
                    r[(i + k) * (N + Q + 1) + j + l] += a[i * (N + 1) + j] * b[k * (Q + 1) + l];
}

}  // namespace

double binomial(int n, int k) {
    assert(n < kRows);
    return triangle()[n][k];
}

void Form::set(int i, int j, const MidRad& coefficient) {
    c_[static_cast<std::size_t>(i * (n_ + 1) + j)] = coefficient.mid() * (binomial(m_, i) * binomial(n_, j));
    const double error =
        coefficient.radius() + rounding_of_binomials(m_, n_) * (std::abs(coefficient.mid()) + coefficient.radius());
    if (!(error <= error_)) error_ = error;
}

double Form::norm() const {
    const auto &rows = inverses()[m_], &columns = inverses()[n_];
    double most = 0;
    const double* c = c_.data();
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            const double size = std::abs(*c++) * (rows[i] * columns[j]);
            if (!(size <= most)) most = size;
        }
    return most * (1 + rounding_of_binomials(m_, n_));
}

// Not a number stays none, and is taken for no bound by range(). What is added for subnormal numbers is far above what
// products lose to them.
void Form::add_error(double error) {
    error_ = (error_ + error) * (1 + 0x1p-40) + std::numeric_limits<double>::min();
}

Form operator+(const Form& a, const Form& b) {
    assert(a.m_ == b.m_ && a.n_ == b.n_);
    Form r = a;
    for (std::size_t i = 0; i < r.c_.size(); ++i) r.c_[i] += b.c_[i];
    r.add_error(b.error_ + kUnit * r.norm());
    return r;
}

Form operator-(const Form& a, const Form& b) {
    assert(a.m_ == b.m_ && a.n_ == b.n_);
    Form r = a;
    for (std::size_t i = 0; i < r.c_.size(); ++i) r.c_[i] -= b.c_[i];
    r.add_error(b.error_ + kUnit * r.norm());
    return r;
}

Form operator*(const MidRad& s, const Form& a) {
    Form r = a;
    for (double& c : r.c_) c *= s.mid();
    r.error_ = std::abs(s.mid()) * a.error_;
    r.add_error(s.radius() * (a.norm() + a.error_) + kUnit * r.norm());
    return r;
}

// A sum of n products is off by at most n 2^-53 / (1 - n 2^-53) times the sum of their magnitudes [Higham02, sec. 3.1],
// which in the Bernstein basis is a mean of products of magnitudes.
Form operator*(const Form& a, const Form& b) {
    Form r(a.m_ + b.m_, a.n_ + b.n_);
    const auto all = [&](int m, int n) { return a.m_ == m && b.m_ == m && a.n_ == n && b.n_ == n; };
    if (all(2, 2))
        convolve<2, 2, 2, 2>(a.c_.data(), b.c_.data(), r.c_.data());
    else if (all(2, 0))
        convolve<2, 0, 2, 0>(a.c_.data(), b.c_.data(), r.c_.data());
    else
        for (int i = 0; i <= a.m_; ++i)
            for (int k = 0; k <= b.m_; ++k) {
                double* const row = r.c_.data() + (i + k) * (r.n_ + 1);
                for (int j = 0; j <= a.n_; ++j) {
                    const double x = a.at(i, j);
                    for (int l = 0; l <= b.n_; ++l) row[j + l] += x * b.at(k, l);
                }
            }
    const double terms = (std::min(a.m_, b.m_) + 1) * (std::min(a.n_, b.n_) + 1);
    const double size = a.norm(), other = &a == &b ? size : b.norm();
    r.add_error(terms * kUnit * size * other + a.error_ * other + b.error_ * (size + a.error_));
    return r;
}

Interval Form::range() const {
    const auto &rows = inverses()[m_], &columns = inverses()[n_];
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
