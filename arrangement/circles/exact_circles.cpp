#include "exact_circles.hpp"

#include <cassert>

namespace vcell {

Exact discriminant(const ExactCurve& c, const ExactCurve& d) {
    const Exact D = c.A * d.B - c.B * d.A;
    const Exact k = d.K * c.C - c.K * d.C;
    const Exact dot = c.A * d.A + c.B * d.B;
    const Exact Z = k * k + c.C * (c.K * (d.A * d.A + d.B * d.B) - d.K * dot) +
                    d.C * (d.K * (c.A * c.A + c.B * c.B) - c.K * dot);
    return D * D - Exact(4.0) * Z;
}

std::optional<ExactCirclePoint> intersection(const ExactCurve& c, const ExactCurve& d, Sign orientation) {
    const Exact D = c.A * d.B - c.B * d.A;
    if (c.is_line() && d.is_line()) {
        if (D.sign() == Sign::Zero || D.sign() != orientation) return std::nullopt;
        const Exact s(orientation == Sign::Positive ? 1.0 : -1.0);
        return ExactCirclePoint{
            s * (c.B * d.C - d.B * c.C), Exact(), s * (c.C * d.A - d.C * c.A), Exact(), Exact(), s * D};
    }
    const Exact mx = d.K * c.A - c.K * d.A, my = d.K * c.B - c.K * d.B;
    const Exact m2 = mx * mx + my * my;
    if (m2.sign() == Sign::Zero) return std::nullopt;  // concentric circles
    const Exact delta = discriminant(c, d);
    if (delta.sign() == Sign::Negative || (delta.sign() == Sign::Zero) != (orientation == Sign::Zero))
        return std::nullopt;
    const Exact two_c = Exact(2.0) * (d.K * c.C - c.K * d.C);
    const Exact s(static_cast<double>(orientation));
    return ExactCirclePoint{D * my - two_c * mx, -(s * my), -(two_c * my) - D * mx, s * mx, delta,
                            Exact(2.0) * m2};
}

ExactCirclePoint ExactCurve::own_point(Sign which) const {
    assert(!is_line());
    const Exact s(static_cast<double>(K.sign()));
    return {-(s * A),          Exact(static_cast<double>(which)), -(s * B), Exact(), squared_diameter(),
            s * Exact(2.0) * K};
}

OneRoot ExactCurve::value(ExactCirclePoint& p) const {
    // K |p|^2 + A x + B y + C, times w^2.
    const OneRoot x = p.x(), y = p.y();
    if (!p.squares) p.squares = {x * x + y * y, p.w * p.w};
    return K * p.squares->of_point + p.w * (A * x + B * y) + C * p.squares->of_w;
}

std::array<OneRoot, 2> ExactCurve::gradient(const ExactCirclePoint& p) const {
    const OneRoot x = p.x(), y = p.y();
    const Exact two_K = Exact(2.0) * K;
    return {two_K * x + A * p.w, two_K * y + B * p.w};
}

}  // namespace vcell
