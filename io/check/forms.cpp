#include "forms.hpp"

#include <array>
#include <cassert>

namespace vcell::check {

namespace {

constexpr int kRows = kMaxBinomial + 1;

/// Pascal's triangle. Numbers beyond 2^53 are rounded, each row a little more: below 2^-45 in all, which the
/// ranges below allow for.
const std::array<std::array<double, kRows>, kRows>& triangle() {
    static const auto rows = [] {
        std::array<std::array<double, kRows>, kRows> t{};
        for (int n = 0; n < kRows; ++n) {
            t[n][0] = 1;
            for (int k = 1; k <= n; ++k) t[n][k] = t[n - 1][k - 1] + (k < n ? t[n - 1][k] : 0);
        }
        return t;
    }();
    return rows;
}

}  // namespace

double binomial(int n, int k) {
    assert(n < kRows);
    return triangle()[n][k];
}

Form operator+(const Form& a, const Form& b) {
    assert(a.m_ == b.m_ && a.n_ == b.n_);
    Form r(a.m_, a.n_);
    for (std::size_t i = 0; i < r.c_.size(); ++i) r.c_[i] = a.c_[i] + b.c_[i];
    return r;
}

Form operator-(const Form& a, const Form& b) {
    assert(a.m_ == b.m_ && a.n_ == b.n_);
    Form r(a.m_, a.n_);
    for (std::size_t i = 0; i < r.c_.size(); ++i) r.c_[i] = a.c_[i] - b.c_[i];
    return r;
}

Form operator*(const Interval& s, const Form& a) {
    Form r(a.m_, a.n_);
    for (std::size_t i = 0; i < r.c_.size(); ++i) r.c_[i] = s * a.c_[i];
    return r;
}

Form operator*(const Form& a, const Form& b) {
    Form r(a.m_ + b.m_, a.n_ + b.n_);
    for (int i = 0; i <= a.m_; ++i)
        for (int k = 0; k <= b.m_; ++k)
            for (int j = 0; j <= a.n_; ++j)
                for (int l = 0; l <= b.n_; ++l) r.at(i + k, j + l) += a.at(i, j) * b.at(k, l);
    return r;
}

// Each product of two different coefficients once, doubled exactly.
Form square(const Form& a) {
    Form r(2 * a.m_, 2 * a.n_);
    const int columns = a.n_ + 1, count = (a.m_ + 1) * columns;
    for (int p = 0; p < count; ++p)
        for (int q = p; q < count; ++q) {
            const Interval product = p == q ? square(a.c_[p]) : 2 * (a.c_[p] * a.c_[q]);
            r.at(p / columns + q / columns, p % columns + q % columns) += product;
        }
    return r;
}

Interval Form::range() const {
    Interval whole;
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            const double b = binomial(m_, i) * binomial(n_, j);
            const Interval factor = b < 0x1p53 ? Interval(b) : Interval::ball(b, 0x1p-44 * b);
            const Interval c = at(i, j) / factor;
            whole = i + j == 0 ? c : hull(whole, c);
        }
    return whole;
}

}  // namespace vcell::check
