#include "circle_curves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vcell {

namespace {

using namespace kernel_bounds;

// Where K keeps five digits, a centre is good to this fraction of the terms it is computed from.
constexpr double least_K = 1e-5, center_margin = 1e-9;
static_assert(center_margin * least_K >= 32 * u);

}  // namespace

void CircleCurves::reset(const CircularFamily* family) {
    family_ = family;
    forms_.clear();
    sources_.clear();
    exact_forms_.clear();
    forms_.push_back({0, 0, 0, 0, 0, 0, 1, 0});
    sources_.push_back({});
}

FormId CircleCurves::add_line(double a, double b, double c) {
    forms_.push_back({0, 0, 0, a, b, c, 1, 0});
    return sources_.push_back({});
}

FormId CircleCurves::add_form(FormId in_family, const KernelForm& made) {
    forms_.push_back(made);
    return sources_.push_back({in_family});
}

const ExactForm& CircleCurves::exact_form(FormId f) {
    std::int32_t& slot = sources_[f].exact;
    if (slot < 0) {
        const KernelForm& g = forms_[f];
        slot = static_cast<std::int32_t>(exact_forms_.size());
        if (sources_[f].in_family.valid())
            exact_forms_.push_back(family_->exact(sources_[f].in_family));
        else
            exact_forms_.push_back({Exact(), Exact(g.a), Exact(g.b), Exact(g.e), Exact(1.0)});
    }
    return exact_forms_[static_cast<std::size_t>(slot)];
}

double CircleCurves::lower_bound(FormId f, FormId g, double x0, double x1, double y0, double y1) const {
    const double x = 0.5 * x0 + 0.5 * x1, y = 0.5 * y0 + 0.5 * y1;
    const double rx = std::max(x1 - x, x - x0) * slop, ry = std::max(y1 - y, y - y0) * slop;
    return jet({f, g}, x, y).lower_bound(rx, ry);
}

// Two curves are the same if (K, A, B, C) of one is a multiple of the other's, about any place: if no minor
// of the two rows is other than zero. The place is one about which a form of c has small coefficients.
bool CircleCurves::same_curve(FormPair c, FormPair d) {
    const KernelForm& place = forms_[c.f].k != 0 ? forms_[c.f] : forms_[c.g];
    const auto row = [&](FormPair pair) {
        const FormJet j = jet(pair, place.cx, place.cy);
        return std::array{Interval::ball(j.K, j.eK), Interval::ball(j.gx, j.eg), Interval::ball(j.gy, j.eg),
                          Interval::ball(j.v, j.ev)};
    };
    const auto r = row(c), s = row(d);
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (!(r[i] * s[j] - r[j] * s[i]).contains(0)) {
                ++decisions_.by_interval;
                return false;
            }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c), f = exact_curve(d);
    const auto zero = [](const Exact& a, const Exact& b, const Exact& p, const Exact& q) {
        return (a * q - b * p).sign() == Sign::Zero;
    };
    return zero(e.K, e.A, f.K, f.A) && zero(e.K, e.B, f.K, f.B) && zero(e.K, e.C, f.K, f.C) &&
           zero(e.A, e.B, f.A, f.B) && zero(e.A, e.C, f.A, f.C) && zero(e.B, e.C, f.B, f.C);
}

Sign CircleCurves::curvature_sign(FormPair c) {
    const double kf = forms_[c.f].K, kg = forms_[c.g].K;
    const double K = kf - kg;
    if (std::abs(K) > K_roundings * (std::abs(kf) + std::abs(kg)) * slop || (kf == 0 && kg == 0)) {
        ++decisions_.by_double;
        return sign_of(K);
    }
    ++decisions_.by_exact;
    const ExactForm &f = exact_form(c.f), &g = exact_form(c.g);
    return (f.K * g.W - g.K * f.W).sign();
}

// |grad F|^2 - 4 K F is the same everywhere: 4 K^2 r^2. Evaluate it where |grad F| is least, at the centre;
// of what may be a line, where doubles know none, near a form.
Sign CircleCurves::radius_sign(FormPair c) {
    const KernelForm &f = forms_[c.f], &g = forms_[c.g];
    const double K = f.K - g.K;
    double x = f.cx, y = f.cy;
    if (std::abs(K) > 4 * K_roundings * (std::abs(f.K) + std::abs(g.K))) {
        // The centre solves grad F = 0; any point near it serves.
        const FormJet o = jet(c, x, y);
        x -= o.gx / (2 * K);
        y -= o.gy / (2 * K);
    }
    const FormJet j = jet(c, x, y);
    const double g2 = j.gx * j.gx + j.gy * j.gy, four_KF = 4 * j.K * j.v;
    const double bound =
        (4 * j.eg * (std::abs(j.gx) + std::abs(j.gy)) + 4 * j.eg * j.eg +
         4 * ((std::abs(j.K) + j.eK) * j.ev + std::abs(j.v) * j.eK) + 8 * u * (g2 + std::abs(four_KF))) *
            slop +
        tiny;
    if (std::abs(g2 - four_KF) > bound) {
        ++decisions_.by_double;
        return sign_of(g2 - four_KF);
    }
    ++decisions_.by_exact;
    const ExactCurve e = exact_curve(c);
    return e.squared_diameter().sign();
}

// F about the centre of one of the forms: the circle's centre is at -grad / 2K from there.
std::optional<CircleCurves::Circle> CircleCurves::circle(FormPair c) const {
    const KernelForm& f = forms_[c.f].K != 0 ? forms_[c.f] : forms_[c.g];
    const FormJet o = jet(c, f.cx, f.cy);
    const Interval K = Interval::ball(o.K, o.eK);
    if (K.contains(0)) return std::nullopt;
    const Interval half = Interval(0.5) / K;
    const Interval gx = Interval::ball(o.gx, o.eg) * half, gy = Interval::ball(o.gy, o.eg) * half;
    return Circle{Interval(f.cx) - gx, Interval(f.cy) - gy,
                  square(gx) + square(gy) - Interval::ball(o.v, o.ev) / K};
}

std::array<double, 4> CircleCurves::circle_box(FormPair c) const {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const auto o = circle(c);
    if (!o) return {-inf, inf, -inf, inf};
    const Interval r = Interval(-1, 1) * sqrt(Interval(0.0, std::max(0.0, o->r2.upper())));
    const Interval x = o->cx + r, y = o->cy + r;
    return {x.lower(), x.upper(), y.lower(), y.upper()};
}

// Plain arithmetic: the centre is -grad / 2K from a form's own, and a relative margin of 1e-9 of all terms
// covers the roundings where K keeps enough digits. A circle in the box has its centre and extremes there.
bool CircleCurves::circle_leaves_box(FormPair c, const std::array<double, 4>& box) const {
    const KernelForm &f = forms_[c.f], &g = forms_[c.g];
    const double K = f.K - g.K;
    if (!(std::abs(K) > least_K * (std::abs(f.K) + std::abs(g.K)))) return false;
    const KernelForm &o = f.K != 0 ? f : g, &p = f.K != 0 ? g : f;
    const double sign = f.K != 0 ? 1 : -1;
    // At o's centre only the other form has a quadratic part and slope, but for linear terms.
    const double dx = o.cx - p.cx, dy = o.cy - p.cy;
    const double ox = o.a * o.iw, oy = o.b * o.iw, px = (2 * p.k * dx + p.a) * p.iw,
                 py = (2 * p.k * dy + p.b) * p.iw;
    const double half = 0.5 / K;
    const double x = o.cx - sign * (ox - px) * half, y = o.cy - sign * (oy - py) * half;
    const double margin =
        center_margin * (std::abs(o.cx) + std::abs(o.cy) + std::abs(p.cx) + std::abs(p.cy) +
                         (std::abs(ox) + std::abs(oy) + std::abs(px) + std::abs(py)) * std::abs(half));
    return x + margin < box[0] || x - margin > box[1] || y + margin < box[2] || y - margin > box[3];
}

}  // namespace vcell
