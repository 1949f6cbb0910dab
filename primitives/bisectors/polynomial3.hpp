/// Polynomials in x, y, z with exact coefficients: implicit equations of bisectors.
#pragma once

#include <algorithm>
#include <array>
#include <map>

#include "../objects/exact_space.hpp"

namespace vcell {

class Polynomial3 {
public:
    using Exponents = std::array<int, 3>;  ///< of x, y and z

    Polynomial3() = default;
    Polynomial3(const Exact& constant) { add({0, 0, 0}, constant); }  // NOLINT: a number is a polynomial
    /// n . p + d.
    static Polynomial3 linear(const ExactVector& n, const Exact& d) {
        Polynomial3 r(d);
        r.add({1, 0, 0}, n.x);
        r.add({0, 1, 0}, n.y);
        r.add({0, 0, 1}, n.z);
        return r;
    }

    /// The terms with non-zero coefficients.
    const std::map<Exponents, Exact>& terms() const { return terms_; }
    bool is_zero() const { return terms_.empty(); }
    /// Total degree; 0 for the zero polynomial.
    int degree() const {
        int d = 0;
        for (const auto& term : terms_) d = std::max(d, term.first[0] + term.first[1] + term.first[2]);
        return d;
    }
    Exact operator()(const ExactVector& p) const {
        Exact sum;
        for (const auto& [e, c] : terms_) {
            Exact product = c;
            for (int i = 0; i < e[0]; ++i) product *= p.x;
            for (int i = 0; i < e[1]; ++i) product *= p.y;
            for (int i = 0; i < e[2]; ++i) product *= p.z;
            sum += product;
        }
        return sum;
    }

    friend Polynomial3 operator+(Polynomial3 p, const Polynomial3& q) {
        for (const auto& [e, c] : q.terms_) p.add(e, c);
        return p;
    }
    friend Polynomial3 operator-(Polynomial3 p, const Polynomial3& q) {
        for (const auto& [e, c] : q.terms_) p.add(e, -c);
        return p;
    }
    friend Polynomial3 operator*(const Polynomial3& p, const Polynomial3& q) {
        Polynomial3 r;
        for (const auto& [e, c] : p.terms_)
            for (const auto& [f, d] : q.terms_) r.add({e[0] + f[0], e[1] + f[1], e[2] + f[2]}, c * d);
        return r;
    }

private:
    void add(const Exponents& e, const Exact& c) {
        Exact& sum = terms_[e];
        sum += c;
        if (sum.sign() == Sign::Zero) terms_.erase(e);
    }

    std::map<Exponents, Exact> terms_;
};

}  // namespace vcell
