#include "quadratic_form.hpp"

#include <array>
#include <cassert>
#include <optional>

namespace vcell {

namespace {

// ---- Polynomials in one variable: coefficients by ascending power, no leading zeros ----------------------

using Univariate = std::vector<Exact>;

void trim(Univariate& p) {
    while (!p.empty() && is_zero(p.back())) p.pop_back();
}

Univariate sum(const Univariate& p, const Univariate& q, const Exact& factor) {
    Univariate r(std::max(p.size(), q.size()));
    for (std::size_t i = 0; i < p.size(); ++i) r[i] += p[i];
    for (std::size_t i = 0; i < q.size(); ++i) r[i] += factor * q[i];
    trim(r);
    return r;
}

Univariate product(const Univariate& p, const Univariate& q) {
    if (p.empty() || q.empty()) return {};
    Univariate r(p.size() + q.size() - 1);
    for (std::size_t i = 0; i < p.size(); ++i)
        for (std::size_t j = 0; j < q.size(); ++j) r[i + j] += p[i] * q[j];
    return r;
}

// Quotient and remainder of a multiple of p. Pre: d is not zero.
std::pair<Univariate, Univariate> divided(Univariate p, const Univariate& d) {
    Univariate quotient;
    while (p.size() >= d.size()) {
        const std::size_t shift = p.size() - d.size();
        const Exact leading = p.back();
        for (Exact& c : quotient) c *= d.back();
        quotient.resize(std::max(quotient.size(), shift + 1));
        quotient[shift] += leading;
        for (Exact& c : p) c *= d.back();
        for (std::size_t i = 0; i < d.size(); ++i) p[shift + i] -= leading * d[i];
        trim(p);
    }
    return {quotient, p};
}

Univariate common_divisor(Univariate p, Univariate q) {
    while (!q.empty()) {
        Univariate rest = divided(p, q).second;
        p = std::move(q);
        q = std::move(rest);
    }
    return p;
}

// The square root of a dyadic number, if that is one.
std::optional<Exact> exact_sqrt(const Exact& v) {
    if (v.sign() == Sign::Negative) return std::nullopt;
    const auto [lower, upper] = v.sqrt_bounds(0);
    if (!is_zero(lower - upper)) return std::nullopt;
    return lower;
}

// The rational roots of p of degree at most two as (numerator, denominator).
std::vector<std::pair<Exact, Exact>> small_rational_roots(const Univariate& p) {
    if (p.size() == 2) return {{-p[0], p[1]}};
    if (p.size() != 3) return {};
    const auto root = exact_sqrt(p[1] * p[1] - 4.0 * p[0] * p[2]);
    if (!root) return {};
    return {{*root - p[1], 2.0 * p[2]}, {-*root - p[1], 2.0 * p[2]}};
}

std::vector<std::pair<Exact, Exact>> rational_roots(Univariate p) {
    Univariate derivative;
    for (std::size_t i = 1; i < p.size(); ++i) derivative.push_back(Exact(static_cast<double>(i)) * p[i]);
    const Univariate repeated = common_divisor(p, derivative);
    if (repeated.size() > 1) p = divided(p, repeated).first;
    // The parameter of p - q is tried on its own.
    const Univariate minus_one{1.0, 1.0};
    if (p.size() == 4) {
        auto [quotient, rest] = divided(p, minus_one);
        if (rest.empty()) p = std::move(quotient);
    }
    return small_rational_roots(p);
}

// The divisor of all 3 x 3 minors of P + t Q.
Univariate minors_divisor(const QuadraticForm& p, const QuadraticForm& q) {
    const std::size_t n = p.size();
    const auto entry = [&](std::size_t i, std::size_t j) {
        Univariate e{p(i, j), q(i, j)};
        trim(e);
        return e;
    };
    using Triple = std::array<std::size_t, 3>;
    std::vector<Triple> triples;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k) triples.push_back({i, j, k});
    const auto minor = [&](const Triple& row, const Triple& column) {
        Univariate sum_of_products;
        for (int k = 0; k < 3; ++k) {
            const std::size_t a = column[k], b = column[(k + 1) % 3], c = column[(k + 2) % 3];
            const Univariate two = sum(product(entry(row[1], b), entry(row[2], c)),
                                       product(entry(row[1], c), entry(row[2], b)), -1.0);
            sum_of_products = sum(sum_of_products, product(entry(row[0], a), two), 1.0);
        }
        return sum_of_products;
    };
    Univariate divisor;
    for (std::size_t i = 0; i < triples.size(); ++i)
        for (std::size_t j = i; j < triples.size(); ++j) {
            divisor = common_divisor(std::move(divisor), minor(triples[i], triples[j]));
            if (divisor.size() == 1) return divisor;
        }
    return divisor;
}

// ---- The first rung: intervals ---------------------------------------------------------------------------

using Cubic = std::array<Interval, 4>;

// Entries in doubles after a common scaling, which changes no question about ranks.
std::vector<Interval> enclosures(const QuadraticForm& form) {
    std::optional<long> largest;
    for (std::size_t i = 0; i < form.size(); ++i)
        for (std::size_t j = i; j < form.size(); ++j)
            if (!is_zero(form(i, j)))
                largest = std::max(largest.value_or(form(i, j).exponent()), form(i, j).exponent());
    std::vector<Interval> result(form.size() * form.size());
    for (std::size_t i = 0; i < form.size(); ++i)
        for (std::size_t j = i; j < form.size(); ++j)
            result[i * form.size() + j] = result[j * form.size() + i] =
                form(i, j).scaled(-largest.value_or(0)).enclosure();
    return result;
}

// det of the 3 x 3 block (rows, columns) of P + t Q: each column is taken from P or from Q.
Cubic minor_cubic(const std::vector<Interval>& p, const std::vector<Interval>& q, std::size_t size,
                  const std::array<std::size_t, 3>& rows, const std::array<std::size_t, 3>& columns) {
    Cubic cubic{};
    for (unsigned choice = 0; choice < 8; ++choice) {
        std::array<std::array<Interval, 3>, 3> m;
        int power = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const bool from_q = (choice >> j & 1u) != 0;
            power += from_q;
            for (std::size_t i = 0; i < 3; ++i) m[i][j] = (from_q ? q : p)[rows[i] * size + columns[j]];
        }
        cubic[power] += m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                        m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                        m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    }
    return cubic;
}

// Bezout's determinant: not zero when f and g, as forms of degree three, have no common root, none at
// infinity either.
Interval resultant(const Cubic& f, const Cubic& g) {
    const auto b = [&](int i, int j) { return f[i] * g[j] - f[j] * g[i]; };
    const Interval b03 = b(0, 3), middle = b03 + b(1, 2), b02 = b(0, 2), b13 = b(1, 3);
    return b(0, 1) * (middle * b(2, 3) - b13 * b13) - b02 * (b02 * b(2, 3) - b13 * b03) +
           b03 * (b02 * b13 - middle * b03);
}

// Is it certain that no member of the pencil, p and q included, has rank two or less? A few minors tell for
// forms in general position. They use the last coordinate, the constant terms: without it differences of
// cylinders have rank two.
bool surely_has_no_pair_of_planes(const QuadraticForm& p, const QuadraticForm& q) {
    if (p.size() < 4) return false;
    using Rows = std::array<std::size_t, 3>;
    const std::size_t last = p.size() - 1;
    const Rows xy{0, 1, last}, yz{1, 2, last}, xz{0, 2, last};
    const std::vector<Interval> a = enclosures(p), b = enclosures(q);
    std::vector<Cubic> minors;
    for (const auto& [rows, columns] : {std::pair<Rows, Rows>{xy, xy}, {yz, yz}, {xz, xz}, {xy, xz}}) {
        const Cubic minor = minor_cubic(a, b, p.size(), rows, columns);
        for (const Cubic& other : minors) {
            const std::optional<Sign> s = resultant(minor, other).sign();
            if (s && *s != Sign::Zero) return true;
        }
        minors.push_back(minor);
    }
    return false;
}

// Enough for a plane's coefficients to round to doubles once and for signs to be read off.
constexpr int root_bits = 200;

LinearFunction combination(const Exact& a, const LinearFunction& f, const Exact& b, const LinearFunction& g) {
    LinearFunction h(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) h[i] = a * f[i] + b * g[i];
    return h;
}

}  // namespace

QuadraticForm QuadraticForm::twice(const space_quadrics::Quadric& quadric, std::size_t variables,
                                   std::span<const std::size_t> used) {
    const std::size_t n = used.size();
    QuadraticForm form(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) {
            const Exact& c = quadric[space_quadrics::term(variables, used[i], used[j])];
            form.entries_[i * n + j] = i == j ? c + c : c;
        }
    return form;
}

void QuadraticForm::add_twice_product(const Exact& c, const LinearFunction& f, const LinearFunction& g) {
    // Most functions of a scene lack most coordinates: products with zero are not made.
    for (std::size_t i = 0; i < size_; ++i)
        for (std::size_t j = i; j < size_; ++j) {
            const bool has_ij = !vcell::is_zero(f[i]) && !vcell::is_zero(g[j]),
                       has_ji = !vcell::is_zero(f[j]) && !vcell::is_zero(g[i]);
            if (!has_ij && !has_ji) continue;
            Exact& entry = entries_[i * size_ + j];
            if (has_ij && has_ji)
                entry += c * (f[i] * g[j] + f[j] * g[i]);
            else
                entry += c * (has_ij ? f[i] * g[j] : f[j] * g[i]);
            if (i != j) entries_[j * size_ + i] = entry;
        }
}

Exact QuadraticForm::polar(const LinearFunction& x, const LinearFunction& y) const {
    Exact value;
    for (std::size_t i = 0; i < size_; ++i) {
        if (vcell::is_zero(x[i])) continue;
        for (std::size_t j = 0; j < size_; ++j) value += x[i] * (*this)(i, j) * y[j];
    }
    return value;
}

bool QuadraticForm::is_zero() const {
    for (const Exact& e : entries_)
        if (!vcell::is_zero(e)) return false;
    return true;
}

QuadraticForm operator+(const QuadraticForm& p, const QuadraticForm& q) {
    QuadraticForm r = p;
    for (std::size_t i = 0; i < r.entries_.size(); ++i) r.entries_[i] += q.entries_[i];
    return r;
}

QuadraticForm operator*(const Exact& c, const QuadraticForm& q) {
    QuadraticForm r = q;
    for (Exact& e : r.entries_) e *= c;
    return r;
}

QuadraticForm QuadraticForm::restricted(const std::vector<LinearFunction>& basis) const {
    QuadraticForm r(basis.size());
    for (std::size_t i = 0; i < basis.size(); ++i)
        for (std::size_t j = i; j < basis.size(); ++j)
            r.entries_[i * r.size_ + j] = r.entries_[j * r.size_ + i] = polar(basis[i], basis[j]);
    return r;
}

QuadraticForm adjugate(const QuadraticForm& f) {
    QuadraticForm result(3);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) {
            const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            LinearFunction ei(3), ej(3);
            ei[i] = ej[j] = 1.0;
            const Exact cofactor = f(a, c) * f(b, d) - f(a, d) * f(b, c);
            result.add_twice_product((i == j ? 0.5 : 1.0) * cofactor, ei, ej);
        }
    return result;
}

std::vector<LinearFunction> kernel(const LinearFunction& f) {
    std::size_t pivot = 0;
    while (is_zero(f[pivot])) ++pivot;
    std::vector<LinearFunction> basis;
    for (std::size_t j = 0; j < f.size(); ++j) {
        if (j == pivot) continue;
        LinearFunction v(f.size());
        v[j] = is_zero(f[j]) ? Exact(1.0) : f[pivot];
        v[pivot] = -f[j];
        basis.push_back(v);
    }
    return basis;
}

Factors factors(const QuadraticForm& m) {
    using Kind = Factors::Kind;
    const std::size_t n = m.size();
    const auto row = [&](std::size_t i) {
        LinearFunction f(n);
        for (std::size_t k = 0; k < n; ++k) f[k] = m(i, k);
        return f;
    };
    std::size_t i = 0;
    while (i < n && is_zero(m(i, i))) ++i;
    if (i == n) {
        // Without squares: M_ij M = f g^T + g f^T with the rows f, g of i and j, if the rank is two.
        for (i = 0; i < n; ++i)
            for (std::size_t j = i + 1; j < n; ++j) {
                if (is_zero(m(i, j))) continue;
                const LinearFunction f = row(i), g = row(j);
                for (std::size_t k = 0; k < n; ++k)
                    for (std::size_t l = k; l < n; ++l)
                        if (!is_zero(m(i, j) * m(k, l) - f[k] * g[l] - f[l] * g[k])) return {};
                return {Kind::Rational, {f, g}};
            }
        return {Kind::Rational, {}};
    }
    // M_ii M = f f^T - N with row f of i; the rank is two if N's is one: N_jj N = g g^T with row g of j.
    const LinearFunction f = row(i);
    QuadraticForm rest(n);
    rest.add_twice_product(0.5, f, f);
    rest = rest + (-m(i, i)) * m;
    if (rest.is_zero()) return {Kind::Rational, {f}};
    std::size_t j = 0;
    while (j < n && is_zero(rest(j, j))) ++j;
    if (j == n) return {};
    LinearFunction g(n);
    for (std::size_t k = 0; k < n; ++k) g[k] = rest(j, k);
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t l = k; l < n; ++l)
            if (!is_zero(rest(j, j) * rest(k, l) - g[k] * g[l])) return {};
    // M_ii N_jj M = N_jj f f^T - g g^T.
    if (rest(j, j).sign() == Sign::Negative) return {Kind::Complex, {f, g}};
    const auto root = exact_sqrt(rest(j, j));
    const Exact t = root ? *root : rest(j, j).sqrt_bounds(root_bits).first;
    return {root ? Kind::Rational : Kind::Irrational,
            {combination(t, f, 1.0, g), combination(t, f, -1.0, g)}};
}

PencilSplit split_pencil(const QuadraticForm& p, const QuadraticForm& q) {
    using Kind = Factors::Kind;
    PencilSplit best;
    if (surely_has_no_pair_of_planes(p, q)) return best;
    const auto rank = [](Kind k) {
        return k == Kind::Rational ? 3 : k == Kind::Complex ? 2 : k == Kind::Irrational;
    };
    const auto found_with = [&](const QuadraticForm& member, bool is_first) {
        PencilSplit split{factors(member), is_first};
        if (rank(split.factors.kind) > rank(best.factors.kind)) best = std::move(split);
        return best.factors.kind == Kind::Rational;
    };
    if (found_with(p + Exact(-1.0) * q, false) || found_with(p, true) || found_with(q, false)) return best;
    for (const auto& [numerator, denominator] : rational_roots(minors_divisor(p, q)))
        if (found_with(denominator * p + numerator * q, false)) break;
    return best;
}

}  // namespace vcell
