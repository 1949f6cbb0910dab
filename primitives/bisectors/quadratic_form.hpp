/// Quadratic forms over the dyadic numbers, and pencils of them that hold a pair of planes.
///
/// Where two quadrics P = Q = 0 meet in plane curves, some member P + t Q of their pencil is a pair of
/// planes: a form of rank two. All its 3 x 3 minors vanish then, and these are cubics in t, so t is a root of
/// their greatest common divisor; the planes are rational when t is and when one number is a square.
/// Everything is exact.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../forms/space_quadrics.hpp"

namespace vcell {

using LinearFunction = std::vector<Exact>;  ///< sum of f[i] X[i] over homogeneous coordinates X

/// X^T M X with a symmetric matrix of any size.
class QuadraticForm {
public:
    explicit QuadraticForm(std::size_t size) : size_(size), entries_(size * size) {}
    /// Twice the value of a quadric of space_quadrics.hpp, as a form in those of its variables that `used`
    /// names.
    static QuadraticForm twice(const space_quadrics::Quadric& quadric, std::size_t variables,
                               std::span<const std::size_t> used);

    std::size_t size() const { return size_; }
    const Exact& operator()(std::size_t i, std::size_t j) const { return entries_[i * size_ + j]; }
    /// Adds c f g, symmetrised and doubled: 2 c f(X) g(X) is added to the form's value.
    void add_twice_product(const Exact& c, const LinearFunction& f, const LinearFunction& g);
    /// X^T M Y.
    Exact polar(const LinearFunction& x, const LinearFunction& y) const;
    bool is_zero() const;

    friend QuadraticForm operator+(const QuadraticForm& p, const QuadraticForm& q);
    friend QuadraticForm operator*(const Exact& c, const QuadraticForm& q);

    /// The form on the span of the vectors `basis`, in coordinates of that basis.
    QuadraticForm restricted(const std::vector<LinearFunction>& basis) const;

private:
    std::size_t size_;
    std::vector<Exact> entries_;
};

/// Pre: the size is 3. F adj(F) = det(F).
QuadraticForm adjugate(const QuadraticForm& form);

/// A basis of { X : f(X) = 0 }. Pre: f is not zero.
std::vector<LinearFunction> kernel(const LinearFunction& f);

/// What a form of rank at most two is, up to a factor.
struct Factors {
    enum class Kind {
        None,        ///< the rank is above two
        Rational,    ///< linear[0] linear[1], or the square of linear[0] alone
        Irrational,  ///< real factors whose coefficients take a square root; linear: rounded, relative 2^-200
        Complex,     ///< definite on two coordinates: zero where both of `linear` are
    };
    Kind kind = Kind::None;
    std::vector<LinearFunction> linear;
};

/// Exact; of the zero form: Rational without factors.
Factors factors(const QuadraticForm& form);

/// A member of rank at most two in the pencil of p and q: the one that splits rationally if there is one,
/// else a complex one (the quadrics' real common points are then at most those of a smaller space), else an
/// irrational one.
struct PencilSplit {
    Factors factors;
    bool is_first = false;  ///< the member is p itself: q is the condition that remains, otherwise p
};

/// Looks at p - q, p, q and at every member whose parameter is rational. Of a pencil with three different
/// members of rank two (quadrics with a common vertex) parameters beside those of p - q, p and q are
/// found only when p - q is among them.
PencilSplit split_pencil(const QuadraticForm& p, const QuadraticForm& q);

}  // namespace vcell
