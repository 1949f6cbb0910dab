/// Polynomials in Bernstein form in one or two variables on [0, 1], in doubles, each with one bound on the
/// errors of all its coefficients.
///
/// Coefficients are stored times their binomials, so that products are convolutions [Farin02, 6.5]:
/// p(s, t) = sum c_ij s^i (1 - s)^(m - i) t^j (1 - t)^(n - j). A polynomial lies between the least and the
/// greatest of its Bernstein coefficients. Those of a product are means of products of coefficients: the
/// largest magnitudes multiply, and bounds on errors with them.
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <span>

#include "../../core/numbers/interval.hpp"
#include "../../core/small_vector.hpp"
#include "midrad.hpp"

namespace vcell::check {

/// Pre: n <= kMaxBinomial.
inline constexpr int kMaxBinomial = 255;
double binomial(int n, int k);

class Form {
public:
    Form() = default;
    /// Zero.
    Form(int m, int n) : m_(m), n_(n), norm_(0) { c_.resize(static_cast<std::size_t>((m + 1) * (n + 1))); }

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
    friend Form operator+(const Form& a, const Form& b) { return combination<2>({{{1.0, &a}, {1.0, &b}}}); }
    friend Form operator-(const Form& a, const Form& b) { return combination<2>({{{1.0, &a}, {-1.0, &b}}}); }
    friend Form operator*(const MidRad& s, const Form& a) { return combination<1>({{{s, &a}}}); }
    friend Form operator*(const Form& a, const Form& b) {
        Form r(a.m_ + b.m_, a.n_ + b.n_);
        r.add_product(1, a, b);
        return r;
    }
    friend Form square(const Form& a) { return a * a; }

    struct Term {
        MidRad factor;
        const Form* form;
    };
    /// The sum of all terms. Pre: one at least, of the same degrees.
    template <std::size_t N>
    static Form combination(const std::array<Term, N>& terms);
    /// Adds a product, or takes it away where `sign` is -1. Pre: degrees add up.
    void add_product(double sign, const Form& a, const Form& b);
    /// Adds the product's coefficients where the degrees are among those that the compiler knows.
    bool add_usual_product(double sign, const Form& a, const Form& b);

    /// What the polynomial's values lie in.
    Interval range() const;
    /// An upper bound of the Bernstein coefficients' magnitudes, without their errors.
    double norm() const;

private:
    void add_error(double error);

    int m_ = 0, n_ = 0;
    double error_ = 0;          // of the Bernstein coefficients
    mutable double norm_ = -1;  // less than 0: not known
    SmallVector<double, 25> c_;
};

template <std::size_t N>
Form Form::combination(const std::array<Term, N>& terms) {
    const Form& first = *terms[0].form;
    Form r;
    r.m_ = first.m_;
    r.n_ = first.n_;
    r.c_ = first.c_;
    const std::size_t count = r.c_.size();
    const double leading = terms[0].factor.mid();
    if (leading != 1)
        for (std::size_t i = 0; i < count; ++i) r.c_[i] *= leading;
    for (std::size_t k = 1; k < N; ++k) {
        assert(terms[k].form->m_ == r.m_ && terms[k].form->n_ == r.n_);
        const double factor = terms[k].factor.mid();
        const double* c = terms[k].form->c_.data();
        for (std::size_t i = 0; i < count; ++i) r.c_[i] += factor * c[i];
    }
    // Each term is rounded once as a product, and with each sum that it is in.
    double error = 0;
    for (const Term& t : terms) {
        const double size = t.form->norm();
        error += t.factor.magnitude() * t.form->error_ + t.factor.radius() * size +
                 0x1p-53 * static_cast<double>(N) * std::abs(t.factor.mid()) * size;
    }
    r.add_error(error);
    return r;
}

}  // namespace vcell::check
