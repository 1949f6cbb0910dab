// CircleKernel in exact numbers: the coefficients of curves, and points in the quadratic extension of Q in
// which they live. The algebra is that of circle_kernel.cpp.
#include <cassert>
#include <cfloat>
#include <cmath>
#include <utility>

#include "circle_kernel.hpp"

namespace vcell {

using namespace kernel_bounds;

const ExactForm& CircleKernel::exact_form(FormId f) {
    std::int32_t& slot = sources_[f].exact;
    if (slot < 0) {
        const Form& g = forms_[f];
        slot = static_cast<std::int32_t>(exact_forms_.size());
        if (sources_[f].in_family.valid())
            exact_forms_.push_back(family_->exact(sources_[f].in_family));
        else
            exact_forms_.push_back({Exact(), Exact(g.a), Exact(g.b), Exact(g.e), Exact(1.0)});
    }
    return exact_forms_[static_cast<std::size_t>(slot)];
}

CircleKernel::ExactCurve CircleKernel::exact_curve(FormPair c) {
    const ExactForm &f = exact_form(c.f), &g = exact_form(c.g);
    return {f.K * g.W - g.K * f.W, f.A * g.W - g.A * f.W, f.B * g.W - g.B * f.W, f.C * g.W - g.C * f.W};
}

Exact CircleKernel::exact_discriminant(const ExactCurve& c, const ExactCurve& d) {
    const Exact D = c.A * d.B - c.B * d.A;
    const Exact k = d.K * c.C - c.K * d.C;
    const Exact dot = c.A * d.A + c.B * d.B;
    const Exact Z = k * k + c.C * (c.K * (d.A * d.A + d.B * d.B) - d.K * dot) +
                    d.C * (d.K * (c.A * c.A + c.B * c.B) - c.K * dot);
    return D * D - Exact(4.0) * Z;
}

std::optional<CircleKernel::ExactPoint> CircleKernel::exact_intersection(const ExactCurve& c,
                                                                         const ExactCurve& d,
                                                                         Sign orientation) {
    const Exact D = c.A * d.B - c.B * d.A;
    if (c.K.sign() == Sign::Zero && d.K.sign() == Sign::Zero) {
        if (D.sign() == Sign::Zero || D.sign() != orientation) return std::nullopt;
        const Exact s(orientation == Sign::Positive ? 1.0 : -1.0);
        return ExactPoint{
            s * (c.B * d.C - d.B * c.C), Exact(), s * (c.C * d.A - d.C * c.A), Exact(), Exact(), s * D};
    }
    const Exact mx = d.K * c.A - c.K * d.A, my = d.K * c.B - c.K * d.B;
    const Exact m2 = mx * mx + my * my;
    if (m2.sign() == Sign::Zero) return std::nullopt;  // concentric circles
    const Exact delta = exact_discriminant(c, d);
    if (delta.sign() == Sign::Negative || (delta.sign() == Sign::Zero) != (orientation == Sign::Zero))
        return std::nullopt;
    const Exact two_c = Exact(2.0) * (d.K * c.C - c.K * d.C);
    const Exact s(static_cast<double>(orientation));
    return ExactPoint{D * my - two_c * mx, -(s * my), -(two_c * my) - D * mx, s * mx, delta, Exact(2.0) * m2};
}

PointId CircleKernel::add_exact_point(FormPair c, FormPair d, Sign orientation, ExactPoint exact) {
    const Interval x = enclosure(OneRoot{exact.px, exact.rx, exact.d}, exact.w);
    const Interval y = enclosure(OneRoot{exact.py, exact.ry, exact.d}, exact.w);
    const double error = std::hypot(x.radius(), y.radius()) * 1.5 + tiny;
    const PointId p = points_.push_back({x.mid(), y.mid(), error, c, d, orientation});
    exact_point_index_.resize(points_.size(), -1);
    exact_point_index_[p.value] = static_cast<std::int32_t>(exact_points_.size());
    exact_points_.push_back(std::move(exact));
    return p;
}

PointId CircleKernel::touching_point(FormPair c, FormPair d) {
    auto exact = exact_intersection(exact_curve(c), exact_curve(d), Sign::Zero);
    assert(exact);
    return add_exact_point(c, d, Sign::Zero, std::move(*exact));
}

PointId CircleKernel::circle_point(FormPair c, Sign which) {
    const auto o = circle(c);
    if (o && (which == Sign::Zero || o->r2.lower() > 0)) {
        const Interval x = which == Sign::Zero       ? o->cx
                           : which == Sign::Negative ? o->cx - sqrt(o->r2)
                                                     : o->cx + sqrt(o->r2);
        const double error = std::hypot(x.radius(), o->cy.radius()) * slop + tiny;
        if (error < DBL_MAX) return points_.push_back({x.mid(), o->cy.mid(), error, c, c, which});
    }
    return add_exact_point(c, c, which, exact_circle_point(c, which));
}

CircleKernel::ExactPoint CircleKernel::exact_circle_point(FormPair c, Sign which) {
    const ExactCurve e = exact_curve(c);
    assert(e.K.sign() != Sign::Zero);
    const Exact s(static_cast<double>(e.K.sign()));
    return {-(s * e.A),
            Exact(static_cast<double>(which)),
            -(s * e.B),
            Exact(),
            e.A * e.A + e.B * e.B - Exact(4.0) * e.K * e.C,
            s * Exact(2.0) * e.K};
}

CircleKernel::ExactPoint& CircleKernel::exact_point(PointId p) {
    exact_point_index_.resize(points_.size(), -1);
    std::int32_t& slot = exact_point_index_[p.value];
    if (slot < 0) {
        const KernelPoint& q = points_[p];
        ExactPoint exact =
            q.first == q.second
                ? exact_circle_point(q.first, q.orientation)
                : exact_intersection(exact_curve(q.first), exact_curve(q.second), q.orientation).value();
        slot = static_cast<std::int32_t>(exact_points_.size());
        exact_points_.push_back(std::move(exact));
    }
    return exact_points_[static_cast<std::size_t>(slot)];
}

OneRoot CircleKernel::exact_value(const ExactCurve& c, ExactPoint& p) {
    // K |p|^2 + A x + B y + C, times w^2.
    const OneRoot x{p.px, p.rx, p.d}, y{p.py, p.ry, p.d};
    if (!p.squares) p.squares = {x * x + y * y, p.w * p.w};
    return c.K * p.squares->of_point + p.w * (c.A * x + c.B * y) + c.C * p.squares->of_w;
}

std::array<OneRoot, 2> CircleKernel::exact_gradient(const ExactCurve& c, const ExactPoint& p) {
    const OneRoot x{p.px, p.rx, p.d}, y{p.py, p.ry, p.d};
    const Exact two_K = Exact(2.0) * c.K;
    return {two_K * x + c.A * p.w, two_K * y + c.B * p.w};
}

}  // namespace vcell
