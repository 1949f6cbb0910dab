/// Twins: two forms whose coefficients all but agree, as those of objects a millionth apart.
///
/// Heights enclosed one by one and then subtracted leave a difference as wide as they are, and twins differ
/// by much less than that. Every height f is a root of
///
///     a f^2 + 2 b f + c = 0,   a f + b = -R,   R = sqrt(b^2 - a c),
///
/// over a plane with -A, -beta, C of cylinder_form.hpp, over curved bases with C, B, -A^2 of
/// radial_form.hpp; circular forms and those without a root are a f + 2 b = 0. Let da be a_f - lambda a_g,
/// likewise db and dc, for a number lambda > 0 that makes them small, as equations may be multiplied by any.
/// The equation of f less lambda times that of g is then
///
///     f - g = (da f^2 + 2 db f + dc) / (R_f + lambda R_g + da f + db),      without roots
///     f - g = -(da f + 2 db) / (lambda a_g).
///
/// Around a cylinder one of two twins may be along it exactly, without a root; R is b then.
///
/// The numerators are as small as the difference is; da, db and dc are computed exactly and rounded once. So
/// errors are a part of the difference, not of the heights.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "form_family.hpp"
#include "function_jet.hpp"
#include "radial_height.hpp"

namespace vcell {

/// a, b and c over a plane: a is a number, b and c are polynomials 1, x, y, x^2, xy, y^2.
template <class T>
struct PlaneTerms {
    T a;
    std::array<T, 6> b, c;
};

/// A number and what is linear in a unit vector: v0 + v.u.
template <class T>
struct AffineTerm {
    T v0;
    std::array<T, 3> v;
};

/// a = c0 + c1 y + c2 y^2, b = b(u) + y s(u), c = -p(u) q(u) over curved bases. But in differences q = p, or
/// -p where the object is seen from within.
template <class T>
struct RadialTerms {
    std::array<T, 3> c;
    AffineTerm<T> b, s, p, q;
};

template <class T>
using EitherTerms = std::variant<PlaneTerms<T>, RadialTerms<T>>;

/// The numbers of a form in doubles, about: those of a, of b and of c.
struct FormSignature {
    std::array<double, 15> numbers{};
    std::array<std::size_t, 3> ends{};  ///< of a's, b's and c's
    double scale = 0;                   ///< about the square root of what the equation may be divided by
    bool is_circular = false, has_root = false;
    bool c_is_square = false;  ///< its numbers are those of p
    bool is_hollow = false;    ///< c is that square, and not its negative

    FormSignature() = default;
    FormSignature(const FormFamily& family, FormId f);
    /// The number whose square is lambda for this form as f and the other as g, if the two are twins:
    /// coefficients differ by less than a 2^-10 of the largest ones. It is negative where p_f and p_g have
    /// opposite directions.
    std::optional<double> factor(const FormSignature& o) const;

private:
    double largest(std::size_t from, std::size_t to) const;
};

/// Which of the forms are twins of another one; among very many that are much alike not all may be found,
/// which are compared as other forms are then.
std::vector<bool> which_have_twins(std::span<const FormSignature> forms);

class TwinDifference {
public:
    /// Pre: mu is the factor of the two.
    TwinDifference(const FormFamily& family, FormId f, FormId g, double mu);

    /// Encloses f - g over a box of the chart, where f, not multiplied by distances from tips, is `f` there.
    /// What it does not tell is the whole line.
    FunctionJet<Interval> over(const FunctionJet<Interval>& f, const Interval& x, const Interval& y) const;
    FunctionJet<Interval> over(const FunctionJet<Interval>& f, const RadialNormals<Interval>& normals) const;

private:
    template <class Terms, class Place>
    FunctionJet<Interval> difference(const FunctionJet<Interval>& f, const Place& place) const;

    EitherTerms<Interval> f_, g_, less_;
    Interval lambda_;
    std::array<bool, 2> have_roots_{};
};

}  // namespace vcell
