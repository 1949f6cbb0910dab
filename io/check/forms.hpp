/// Polynomials in Bernstein form with interval coefficients, in one or two variables on [0, 1].
///
/// Coefficients are stored times their binomials, so that products are convolutions [Farin02, 6.5]:
/// p(s, t) = sum c_ij s^i (1 - s)^(m - i) t^j (1 - t)^(n - j). A polynomial lies between the least and the
/// greatest of its Bernstein coefficients.
#pragma once

#include <cstddef>

#include "../../core/interval.hpp"
#include "../../core/small_vector.hpp"

namespace vcell::check {

/// Pre: n <= kMaxBinomial.
inline constexpr int kMaxBinomial = 127;
double binomial(int n, int k);

class Form {
public:
    Form() = default;
    Form(int m, int n) : m_(m), n_(n) { c_.resize(static_cast<std::size_t>((m + 1) * (n + 1))); }

    int degree_s() const { return m_; }
    int degree_t() const { return n_; }
    Interval& at(int i, int j) { return c_[static_cast<std::size_t>(i * (n_ + 1) + j)]; }
    const Interval& at(int i, int j) const { return c_[static_cast<std::size_t>(i * (n_ + 1) + j)]; }

    /// Pre: the same degrees.
    friend Form operator+(const Form& a, const Form& b);
    friend Form operator-(const Form& a, const Form& b);
    friend Form operator*(const Form& a, const Form& b);
    friend Form operator*(const Interval& s, const Form& a);
    friend Form square(const Form& a);

    /// What the polynomial's values lie in.
    Interval range() const;

private:
    int m_ = 0, n_ = 0;
    SmallVector<Interval, 25> c_;
};

}  // namespace vcell::check
