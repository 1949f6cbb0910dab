#include "exact_points.hpp"

#include <array>
#include <cassert>

namespace vcell {

namespace {

Exact doubled(const Exact& e) { return e.scaled(1); }

}  // namespace

ExactForm exact_form(const CircularForm& f) {
    const Exact k(f.k), cx(f.cx), cy(f.cy), a(f.a), b(f.b), e(f.e);
    return {k, a - doubled(k * cx), b - doubled(k * cy), k * (cx * cx + cy * cy) + e, Exact(1.0)};
}

bool are_same_curve(const ExactForm& f, const ExactForm& g) {
    const auto coefficients = [](const ExactForm& c) { return std::array{&c.K, &c.A, &c.B, &c.C}; };
    const auto p = coefficients(f), q = coefficients(g);
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
            if (!(*p[i] * *q[j] == *p[j] * *q[i])) return false;
    return true;
}

OneRootPoint x_extreme(const ExactForm& f, Sign side) {
    const Exact discriminant = f.A * f.A + f.B * f.B - (f.K * f.C).scaled(2);
    assert(discriminant.sign() == Sign::Positive);
    const Exact s(static_cast<double>(f.K.sign()));
    return {{-(s * f.A), Exact(static_cast<double>(side)), discriminant},
            {-(s * f.B), {}, discriminant},
            doubled(s * f.K)};
}

OneRootPoint foot_of_vertical(const ExactForm& f) {
    const Exact s(static_cast<double>(f.A.sign()));
    return {{-(s * f.C), {}, {}}, {}, s * f.A};
}

// The sign of the curve's equation tells the side of a line, and inside from outside of a circle.
Sign exact_side_of(const OneRootPoint& p, const ExactForm& f, Sign half) {
    const Exact& d = p.denominator;
    const OneRoot value = f.K * (p.x * p.x + p.y * p.y) + (d * f.A) * p.x + (d * f.B) * p.y + d * d * f.C;
    const Sign s = sign(value);
    if (half == Sign::Zero) return s * f.B.sign();
    if (s == Sign::Negative) return -half;
    // On the circle or, within its x-range, above or below all of it.
    const Sign level = sign(doubled(f.K) * p.y + d * f.B);
    if (s == Sign::Zero && level != -half) return Sign::Zero;
    return level;
}

bool is_on_half(const OneRootPoint& p, const ExactForm& f, Sign half) {
    return half == Sign::Zero || sign(doubled(f.K) * p.y + p.denominator * f.B) != -half;
}

// Two circles meet on their radical line K2 f1 - K1 f2, a line a x + b y + c. With n = a^2 + b^2 its points
// are
// (-a c, -b c) / n + s (-b, a), and those on K (x^2 + y^2) + A x + B y + C satisfy
//     K n s^2 + m s + q / n = 0,   m = B a - A b,   q = K c^2 - c (A a + B b) + C n,
// hence s = (-m -+ sqrt(m^2 - 4 K q)) / (2 K n).
std::vector<OneRootPoint> common_points(const ExactForm& f, const ExactForm& g) {
    const auto is_line = [](const ExactForm& c) { return c.K.sign() == Sign::Zero; };
    const auto make = [](OneRoot x, OneRoot y, Exact denominator) {
        const Exact s(denominator.sign() == Sign::Positive ? 1.0 : -1.0);
        return OneRootPoint{s * x, s * y, s * denominator};
    };
    if (is_line(f) && is_line(g)) {
        const Exact determinant = f.A * g.B - g.A * f.B;
        if (determinant.sign() == Sign::Zero) return {};
        return {make({f.B * g.C - g.B * f.C, {}, {}}, {f.C * g.A - g.C * f.A, {}, {}}, determinant)};
    }
    const ExactForm& circle = is_line(f) ? g : f;
    const Exact a = g.K * f.A - f.K * g.A, b = g.K * f.B - f.K * g.B, e = g.K * f.C - f.K * g.C;
    const Exact n = a * a + b * b;
    if (n.sign() == Sign::Zero) return {};
    const auto& [K, A, B, C, W] = circle;
    const Exact m = B * a - A * b, q = K * e * e - e * (A * a + B * b) + C * n;
    const Exact discriminant = m * m - (K * q).scaled(2);
    const Exact x0 = b * m - doubled(K * a * e), y0 = -(a * m) - doubled(K * b * e),
                denominator = doubled(K * n);
    if (discriminant.sign() == Sign::Negative) return {};
    if (discriminant.sign() == Sign::Zero) return {make({x0, {}, {}}, {y0, {}, {}}, denominator)};
    return {make({x0, -b, discriminant}, {y0, a, discriminant}, denominator),
            make({x0, b, discriminant}, {y0, -a, discriminant}, denominator)};
}

}  // namespace vcell
