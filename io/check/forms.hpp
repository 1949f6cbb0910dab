/// Polynomials in Bernstein form in one or two variables on [0, 1], in doubles, each with one bound on the errors of
/// all its coefficients.
///
/// Coefficients are stored times their binomials, so that products are convolutions [Farin02, 6.5]:
/// p(s, t) = sum c_ij s^i (1 - s)^(m - i) t^j (1 - t)^(n - j). A polynomial lies between the least and the
/// greatest of its Bernstein coefficients. Those of a product are means of products of coefficients: the largest
/// magnitudes multiply, and bounds on errors with them.
#pragma once

#include <cstddef>
#include <span>

#include "../../core/interval.hpp"
#include "../../core/small_vector.hpp"
#include "midrad.hpp"

namespace vcell::check {

/// Pre: n <= kMaxBinomial.
inline constexpr int kMaxBinomial = 127;
double binomial(int n, int k);

class Form {
public:
    Form() = default;
    /// Zero.
    Form(int m, int n) : m_(m), n_(n) { c_.resize(static_cast<std::size_t>((m + 1) * (n + 1))); }

    /// In one variable: Bernstein coefficients times their binomials, and a bound on the former's errors.
    Form(std::span<const double> scaled, double error)
        : m_(static_cast<int>(scaled.size()) - 1), n_(0), error_(error), c_(scaled.begin(), scaled.end()) {}

    int degree_s() const { return m_; }
    int degree_t() const { return n_; }
    /// A Bernstein coefficient.
    void set(int i, int j, const MidRad& coefficient);
    /// A Bernstein coefficient times its binomials, without its error.
    double at(int i, int j) const { return c_[static_cast<std::size_t>(i * (n_ + 1) + j)]; }

    /// Pre: the same degrees.
    friend Form operator+(const Form& a, const Form& b);
    friend Form operator-(const Form& a, const Form& b);
    friend Form operator*(const Form& a, const Form& b);
    friend Form operator*(const MidRad& s, const Form& a);
    friend Form square(const Form& a) { return a * a; }

    /// What the polynomial's values lie in.
    Interval range() const;
    /// An upper bound of the Bernstein coefficients' magnitudes, without their errors.
    double norm() const;

private:
    void add_error(double error);

    int m_ = 0, n_ = 0;
    double error_ = 0;  // of the Bernstein coefficients
    SmallVector<double, 25> c_;
};

}  // namespace vcell::check
