#include "space_tie.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "../../primitives/bisectors/quadratic_form.hpp"
#include "../../primitives/objects/exact_space.hpp"

namespace vcell {

namespace {

using namespace space_quadrics;
using Row = Quadric;

std::optional<Linear> equation_of(const FormFamily& family, const SpaceTie::ChartLine& line) {
    return line_equation(family, line.a, line.b, line.c);
}

// The value of a quadric in n variables.
OneRoot value(const Row& q, std::span<const OneRoot> x) {
    const std::size_t n = x.size();
    OneRoot sum{{}, {}, x[0].c};
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i; j < n; ++j)
            if (const Exact& c = q[term(n, i, j)]; !is_zero(c)) sum = sum + c * (x[i] * x[j]);
    return sum;
}

QuadraticForm conic(const Row& q) {
    constexpr std::array<std::size_t, 3> all{0, 1, 2};
    return QuadraticForm::twice(q, 3, all);
}

// Trace of a product of symmetric matrices.
Exact trace(const QuadraticForm& a, const QuadraticForm& b) {
    Exact sum;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) sum += a(i, j) * b(i, j);
    return sum;
}

// A root x : y of the cubic c[3] x^3 + c[2] x^2 y + c[1] x y^2 + c[0] y^3 that is not simple, if there is
// one. Where the discriminant is zero the Hessian is the square of the root's factor, or zero where the root
// is triple.
std::optional<std::array<Exact, 2>> multiple_root(const std::array<Exact, 4>& c) {
    const Exact h2 = 3.0 * c[3] * c[1] - c[2] * c[2], h1 = 9.0 * c[3] * c[0] - c[2] * c[1],
                h0 = 3.0 * c[2] * c[0] - c[1] * c[1];
    if (h1 * h1 != 4.0 * h2 * h0) return std::nullopt;
    if (!is_zero(h2)) return std::array{-h1, 2.0 * h2};
    if (!is_zero(h0)) return std::array{Exact(1.0), Exact()};
    if (!is_zero(c[3])) return std::array{-c[2], 3.0 * c[3]};
    if (!is_zero(c[0])) return std::array{Exact(1.0), Exact()};
    return std::nullopt;
}

std::vector<Row> equations_of(const FormFamily& family, std::span<const FormId> forms) {
    std::vector<Row> all{base_equation(family)};
    for (const FormId f : forms) all.push_back(equation(family, f));
    return all;
}

}  // namespace

SpaceTie::SpaceTie(const FormFamily& family, std::span<const FormId> forms,
                   const std::optional<ChartLine>& line)
    : SpaceTie(family, equations_of(family, forms), line) {}

SpaceTie::SpaceTie(const FormFamily& family, std::vector<Quadric> equations,
                   const std::optional<ChartLine>& line)
    : family_(family), quadrics_(std::move(equations)) {
    for (std::size_t i = 0; i < unknowns; ++i) {
        flat_[i].resize(unknowns);
        flat_[i][i] = 1.0;
    }
    for (Row& q : quadrics_) divide_by_common_factor(q);
    if (line) {
        const Linear l = *equation_of(family, *line);
        is_empty_ = !impose(Row(l.begin(), l.end()));
    }
    reduce();
}

// A quadric in X as one in y.
SpaceTie::Row SpaceTie::restricted(const Row& quadric) const {
    Row q(terms(dimension_ + 1));
    for (std::size_t i = 0; i < unknowns; ++i)
        for (std::size_t j = i; j < unknowns; ++j)
            add_product(q, quadric[term(unknowns, i, j)], flat_[i], flat_[j]);
    divide_by_common_factor(q);
    return q;
}

// The first of y_0 .. y_{d-1} that a linear form has, if it has one.
std::optional<std::size_t> SpaceTie::pivot_of(const Row& l) {
    const auto at = std::find_if(l.begin(), l.end() - 1, [](const Exact& c) { return !is_zero(c); });
    return at == l.end() - 1 ? std::nullopt : std::optional(static_cast<std::size_t>(at - l.begin()));
}

// In the flat where also sum of l_k y_k = 0, k = 0 .. d: with all others times l_p, y_p is minus the sum of
// the others times their l.
SpaceTie::Row SpaceTie::substituted(const Row& linear, const Row& l, std::size_t p) {
    Row out;
    for (std::size_t k = 0; k < l.size(); ++k)
        if (k != p) out.push_back(l[p] * linear[k] - l[k] * linear[p]);
    return out;
}
SpaceTie::Row SpaceTie::within(const Row& quadric, const Row& l, std::size_t p) {
    const std::size_t n = l.size();
    std::vector<Row> images;  // of each y
    for (std::size_t k = 0; k < n; ++k) {
        Row one(n);
        one[k] = 1.0;
        images.push_back(substituted(one, l, p));
    }
    Row image(terms(n - 1));
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i; j < n; ++j) add_product(image, quadric[term(n, i, j)], images[i], images[j]);
    return image;
}

// Writes everything in that flat; no if it is at infinity.
bool SpaceTie::impose(const Row& l) {
    const auto p = pivot_of(l);
    if (!p) return false;
    for (Row& q : quadrics_) {
        q = within(q, l, *p);
        divide_by_common_factor(q);
    }
    const std::size_t d = dimension_;
    Row all;
    for (Row& row : flat_) {
        row = substituted(row, l, *p);
        all.insert(all.end(), row.begin(), row.end());
    }
    divide_by_common_factor(all);
    for (std::size_t i = 0; i < unknowns; ++i)
        std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(i * d), d, flat_[i].begin());
    --dimension_;
    return true;
}

// Elimination of the terms of degree two, as long as combinations without such terms are left.
void SpaceTie::reduce() {
    while (!is_empty_) {
        const std::size_t squares = terms(dimension_);
        std::vector<Row> echelon, rest = std::move(quadrics_);
        for (std::size_t k = 0; k < squares; ++k) {
            const auto pivot = std::ranges::find_if(rest, [&](const Row& q) { return !is_zero(q[k]); });
            if (pivot == rest.end()) continue;
            Row row = std::move(*pivot);
            rest.erase(pivot);
            for (Row& q : rest) {
                if (is_zero(q[k])) continue;
                const Exact factor = q[k];
                for (std::size_t i = 0; i < q.size(); ++i) q[i] = row[k] * q[i] - factor * row[i];
                divide_by_common_factor(q);
            }
            echelon.push_back(std::move(row));
        }
        quadrics_ = std::move(echelon);
        std::erase_if(rest, [](const Row& q) {
            return std::ranges::all_of(q, [](const Exact& c) { return is_zero(c); });
        });
        if (rest.empty()) return;
        const Row linear(rest.front().begin() + static_cast<std::ptrdiff_t>(squares), rest.front().end());
        rest.erase(rest.begin());
        quadrics_.insert(quadrics_.end(), rest.begin(), rest.end());
        is_empty_ = !impose(linear);
    }
}

// What is left of a quadric, in y, without multiples of the others. Pre: !is_empty_.
SpaceTie::Row SpaceTie::remainder(const Row& quadric) const {
    Row q = restricted(quadric);
    for (const Row& row : quadrics_) {
        const auto k = static_cast<std::size_t>(
            std::ranges::find_if(row, [](const Exact& c) { return !is_zero(c); }) - row.begin());
        if (is_zero(q[k])) continue;
        const Exact factor = q[k];
        for (std::size_t i = 0; i < q.size(); ++i) q[i] = row[k] * q[i] - factor * row[i];
    }
    return q;
}

bool SpaceTie::implies(FormId form) const {
    const auto found = implied(equation(family_, form));
    return found && !found->beside;
}

// Where a linear form is left, and a combination of the others is the product of it and another one.
std::optional<SpaceTie::Implied> SpaceTie::implied(const Quadric& equation) const {
    if (is_empty_) return std::nullopt;
    const Row q = remainder(equation);
    const auto begin = q.begin() + static_cast<std::ptrdiff_t>(terms(dimension_));
    const auto is_none = [](const Exact& c) { return is_zero(c); };
    if (!std::all_of(q.begin(), begin, is_none)) return std::nullopt;
    if (std::all_of(begin, q.end(), is_none)) return Implied{};
    const Row linear(begin, q.end());
    const auto product = multiple_of(linear);
    if (!product) return std::nullopt;
    const auto other = other_factor(*product, linear);
    return other ? std::optional(Implied{other}) : std::nullopt;
}

// A combination of the quadrics that is zero wherever a linear form is, by elimination of what they are
// there.
std::optional<SpaceTie::Row> SpaceTie::multiple_of(const Row& linear) const {
    const auto p = pivot_of(linear);
    if (!p) return std::nullopt;
    struct Combination {
        Row there, here;
    };
    std::vector<Combination> rest;
    for (const Row& q : quadrics_) rest.push_back({within(q, linear, *p), q});
    while (!rest.empty()) {
        const Combination first = std::move(rest.back());
        rest.pop_back();
        const auto pivot = std::ranges::find_if(first.there, [](const Exact& c) { return !is_zero(c); });
        if (pivot == first.there.end()) return first.here;
        const auto k = static_cast<std::size_t>(pivot - first.there.begin());
        for (Combination& c : rest) {
            const Exact factor = c.there[k];
            if (is_zero(factor)) continue;
            for (std::size_t i = 0; i < c.there.size(); ++i)
                c.there[i] = *pivot * c.there[i] - factor * first.there[i];
            for (std::size_t i = 0; i < c.here.size(); ++i)
                c.here[i] = *pivot * c.here[i] - factor * first.here[i];
        }
    }
    return std::nullopt;
}

// Divides a quadric l l' by l; returns l', in X. With l_j other than 0, j < d, it is, times l_j^2, q_ij l_j -
// l_i q_jj.
std::optional<Linear> SpaceTie::other_factor(const Row& q, const Row& l) const {
    const std::size_t n = dimension_ + 1, j = *pivot_of(l);
    Row factor(n);
    for (std::size_t i = 0; i < n; ++i)
        factor[i] = i == j ? q[term(n, j, j)] * l[j] : q[term(n, i, j)] * l[j] - l[i] * q[term(n, j, j)];
    Row product(terms(n));
    add_product(product, 1.0, l, factor);
    for (std::size_t i = 0; i < product.size(); ++i)
        if (product[i] != l[j] * l[j] * q[i]) return std::nullopt;
    // Those y that were not eliminated are coordinates X, all times one number.
    Linear in_space;
    for (std::size_t k = 0; k < n; ++k) {
        if (is_zero(factor[k])) continue;
        const auto i = std::ranges::find_if(flat_, [&](const Row& row) {
            for (std::size_t m = 0; m < n; ++m)
                if (is_zero(row[m]) != (m != k)) return false;
            return true;
        });
        if (i == flat_.end()) return std::nullopt;
        in_space[static_cast<std::size_t>(i - flat_.begin())] = factor[k];
    }
    return in_space;
}

SpacePoint SpaceTie::to_space(const std::vector<OneRoot>& y) const {
    SpacePoint p;
    for (std::size_t i = 0; i < unknowns; ++i) {
        p[i] = {{}, {}, y[0].c};
        for (std::size_t k = 0; k <= dimension_; ++k) p[i] = p[i] + flat_[i][k] * y[k];
    }
    if (sign(p[4]) == Sign::Negative)
        for (OneRoot& x : p) x = Exact(-1.0) * x;
    return p;
}

// The points of a quadric on a line; where asked for, only a double root, in which the line touches it.
std::vector<SpacePoint> SpaceTie::roots(const Row& q, bool is_double) const {
    const Exact &a = q[term(2, 0, 0)], &b = q[term(2, 0, 1)], &c = q[term(2, 1, 1)];
    const Exact discriminant = b * b - 4.0 * a * c;
    const Sign s = discriminant.sign();
    if (is_zero(a) || s == Sign::Negative || (is_double && s != Sign::Zero)) return {};
    const OneRoot below{2.0 * a, {}, discriminant};
    std::vector<SpacePoint> all{to_space({{-b, 1.0, discriminant}, below})};
    if (s != Sign::Zero) all.push_back(to_space({{-b, -1.0, discriminant}, below}));
    return all;
}

std::vector<SpacePoint> SpaceTie::points() const {
    if (is_empty_) return {};
    if (dimension_ == 0) return {to_space({{1.0, {}, {}}})};
    if (dimension_ == 1 && quadrics_.size() == 1) return roots(quadrics_[0], false);
    return {};
}

std::vector<SpacePoint> SpaceTie::tangencies() const {
    if (is_empty_) return {};
    if (dimension_ == 1 && quadrics_.size() == 1) return roots(quadrics_[0], true);
    if (dimension_ != 2 || quadrics_.size() != 2) return {};
    const QuadraticForm A = conic(quadrics_[0]), B = conic(quadrics_[1]), adj_A = adjugate(A),
                        adj_B = adjugate(B);
    // det (x A + y B), times 3.
    const auto root =
        multiple_root({trace(adj_B, B), 3.0 * trace(adj_B, A), 3.0 * trace(adj_A, B), trace(adj_A, A)});
    if (!root) return {};
    Row member(terms(3));
    for (std::size_t i = 0; i < member.size(); ++i)
        member[i] = (*root)[0] * quadrics_[0][i] + (*root)[1] * quadrics_[1][i];
    divide_by_common_factor(member);
    const QuadraticForm M = conic(member);
    const auto row_of = [](const QuadraticForm& form) -> std::optional<Row> {  // the first that is not zero
        for (std::size_t i = 0; i < 3; ++i) {
            Row row{form(i, 0), form(i, 1), form(i, 2)};
            if (std::ranges::any_of(row, [](const Exact& c) { return !is_zero(c); })) return row;
        }
        return std::nullopt;
    };
    if (const auto kernel = row_of(adjugate(M))) {
        std::vector<OneRoot> y;
        for (const Exact& c : *kernel) y.push_back({c, {}, {}});
        for (const Row& q : quadrics_)
            if (!is_zero(value(q, y))) return {};
        if (is_zero(y[2])) return {};
        return {to_space(y)};
    }
    const auto line = row_of(M);
    if (!line) return {};
    SpaceTie on_line = *this;
    if (!on_line.impose(*line)) return {};
    // The member is zero on the line now, so the two are multiples of each other.
    const auto other = std::ranges::find_if(on_line.quadrics_, [](const Row& q) {
        return std::ranges::any_of(q, [](const Exact& c) { return !is_zero(c); });
    });
    return other == on_line.quadrics_.end() ? std::vector<SpacePoint>() : on_line.roots(*other, false);
}

namespace {

// Both times the power of two that brings q near 1: after elimination numbers may lie far outside the range
// of doubles.
std::array<OneRoot, 2> near_one(const OneRoot& p, const OneRoot& q) {
    const auto exponent = [](const OneRoot& v) {
        const bool is_rational = is_zero(v.b) || is_zero(v.c);
        const long root = is_rational ? 0 : v.b.exponent() + v.c.exponent() / 2;
        return is_zero(v.a) ? root : is_rational ? v.a.exponent() : std::max(root, v.a.exponent());
    };
    const auto scaled = [power = -exponent(q)](const OneRoot& v) {
        return OneRoot{v.a.scaled(power), v.b.scaled(power), v.c};
    };
    return {scaled(p), scaled(q)};
}

// Pre: q > 0.
Interval quotient(const OneRoot& p, const OneRoot& q) {
    if (is_zero(q.b)) return enclosure(p, q.a);
    const Exact one(1.0);
    const auto [a, b] = near_one(p, q);
    return enclosure(a, one) / enclosure(b, one);
}

Wide wide_quotient(const OneRoot& p, const OneRoot& q) {
    const auto wide = [](const OneRoot& v) {
        if (is_zero(v.b) || is_zero(v.c)) return enclosure_of<Wide>(v.a);
        const long half = v.c.exponent() / 2;
        return enclosure_of<Wide>(v.a) +
               enclosure_of<Wide>(v.b.scaled(half)) * sqrt(enclosure_of<Wide>(v.c.scaled(-2 * half)));
    };
    const auto [a, b] = near_one(p, q);
    return wide(a) / wide(b);
}

}  // namespace

std::optional<std::array<Interval, 2>> chart_point(const FormFamily& family, const SpacePoint& p) {
    return space_quadrics::chart_point<Interval>(family, p, quotient);
}

std::optional<std::array<Wide, 2>> wide_chart_point(const FormFamily& family, const SpacePoint& p) {
    return space_quadrics::chart_point<Wide>(family, p, wide_quotient);
}

std::array<Interval, 5> enclosure(const SpacePoint& p) {
    std::array<Interval, 5> X;
    for (std::size_t i = 0; i < X.size(); ++i) X[i] = quotient(p[i], p[4]);
    return X;
}

bool passes_through(const FormFamily& family, FormId f, const SpacePoint& p) {
    return is_zero(value(equation(family, f), p));
}

bool is_tie_at(const FormFamily& family, std::span<const FormId> forms, const SpacePoint& p) {
    return is_zero(value(base_equation(family), p)) &&
           std::ranges::all_of(forms, [&](FormId f) { return passes_through(family, f, p); });
}

std::optional<SpacePoint> space_point_near(const std::array<Wide, 4>& X, double extent) {
    const int exponent = std::ilogb(extent);
    const Wide scale(std::ldexp(1.0, -exponent)), t = scale * X[3];
    std::array<Fraction, 3> place;
    Exact denominator(1.0);
    for (std::size_t i = 0; i < place.size(); ++i) {
        const auto x = simplest_near(scale * X[i]);
        if (!x) return std::nullopt;
        place[i] = *x;
        denominator = denominator * x->denominator;
    }
    const auto distance = simplest_near(t);
    const auto squared = distance ? distance : simplest_near(t * t);
    if (!squared) return std::nullopt;
    // t = n / d, or sqrt(n / d) = sqrt(n d) / d.
    const auto& [n, d] = *squared;
    const Exact c = distance ? Exact() : n * d, all = denominator * d;
    SpacePoint p;
    for (std::size_t i = 0; i < place.size(); ++i) {
        Exact x = place[i].numerator * d;
        for (std::size_t k = 0; k < place.size(); ++k)
            if (k != i) x = x * place[k].denominator;
        p[i] = {x.scaled(exponent), {}, c};
    }
    const Exact over = denominator.scaled(exponent);
    p[3] = distance ? OneRoot{n * over, {}, c} : OneRoot{{}, over, c};
    p[4] = {all, {}, c};
    return p;
}

bool is_on_line(const FormFamily& family, const SpacePoint& p, const SpaceTie::ChartLine& line) {
    const auto l = equation_of(family, line);
    if (!l) return false;
    OneRoot sum{{}, {}, p[0].c};
    for (std::size_t i = 0; i < unknowns; ++i) sum = sum + (*l)[i] * p[i];
    return is_zero(sum);
}

namespace {

using Gradient = std::array<OneRoot, 4>;

// An equation's derivatives by p and t.
Gradient gradient(const Row& q, const SpacePoint& p) {
    Gradient d;
    for (std::size_t i = 0; i < 4; ++i) {
        d[i] = {{}, {}, p[0].c};
        for (std::size_t j = 0; j < unknowns; ++j)
            d[i] = d[i] + (i == j ? 2.0 : 1.0) * q[term(unknowns, i, j)] * p[j];
    }
    return d;
}

OneRoot minor(const Gradient& a, const Gradient& b, const Gradient& c, std::size_t skipped) {
    const std::size_t i = skipped > 0 ? 0 : 1, j = skipped > 1 ? 1 : 2, k = skipped > 2 ? 2 : 3;
    return a[i] * (b[j] * c[k] - b[k] * c[j]) - a[j] * (b[i] * c[k] - b[k] * c[i]) +
           a[k] * (b[i] * c[j] - b[j] * c[i]);
}

}  // namespace

// Heights have equal gradients where the equations' gradients and that of the base are dependent: of those on
// the base's tangent space, no multiple of each other's unless it is by the derivatives with respect to t,
// which are not 0.
bool have_equal_gradients(const std::array<Quadric, 3>& equations, const SpacePoint& p) {
    const Gradient a = gradient(equations[0], p), b = gradient(equations[1], p),
                   c = gradient(equations[2], p);
    for (std::size_t skipped = 0; skipped < 4; ++skipped)
        if (!is_zero(minor(a, b, c, skipped))) return false;
    return true;
}
bool have_equal_gradients(const FormFamily& family, FormId f, FormId g, const SpacePoint& p) {
    return have_equal_gradients({base_equation(family), equation(family, f), equation(family, g)}, p);
}

// Likewise: they are on one line where all four gradients are dependent.
bool have_gradients_in_line(const std::array<Quadric, 4>& equations, const SpacePoint& p) {
    const Gradient a = gradient(equations[0], p), b = gradient(equations[1], p),
                   c = gradient(equations[2], p), d = gradient(equations[3], p);
    OneRoot determinant{{}, {}, p[0].c};
    for (std::size_t i = 0; i < 4; ++i)
        determinant = determinant + Exact(i % 2 == 0 ? 1.0 : -1.0) * (d[i] * minor(a, b, c, i));
    return is_zero(determinant);
}

bool have_gradients_in_line(const FormFamily& family, std::span<const FormId> forms, const SpacePoint& p) {
    return forms.size() < 3 ||
           have_gradients_in_line({base_equation(family), equation(family, forms[0]),
                                   equation(family, forms[1]), equation(family, forms[2])},
                                  p);
}

// Likewise, on what is tangent to the base and to the line.
bool have_equal_slopes(const FormFamily& family, FormId f, FormId g, const SpacePoint& p,
                       const SpaceTie::ChartLine& line) {
    const Gradient a = gradient(base_equation(family), p), b = gradient(equation(family, f), p),
                   c = gradient(equation(family, g), p);
    const Linear l = *equation_of(family, line);
    OneRoot determinant{{}, {}, p[0].c};
    for (std::size_t i = 0; i < 4; ++i)
        determinant = determinant + (i % 2 == 0 ? l[i] : -l[i]) * minor(a, b, c, i);
    return is_zero(determinant);
}

}  // namespace vcell
