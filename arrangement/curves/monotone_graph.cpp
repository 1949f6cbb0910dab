#include "monotone_graph.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>

#include "../../core/solver/newton/one_unknown.hpp"

namespace vcell {

namespace {

template <class T>
T signed_by(Sign s, const T& t) {
    return s == Sign::Negative ? -t : t;
}

template <class T>
T lower_end(const T& t) {
    return T(t.lower(), t.lower());
}
template <class T>
T upper_end(const T& t) {
    return T(t.upper(), t.upper());
}
template <class T>
bool is_point(const T& t) {
    return t.lower() == t.upper();
}
/// The members that are not negative. Pre: there are some, up to rounding.
template <class T>
T non_negative(const T& t) {
    if (t.lower() >= 0) return t;
    return t.upper() > 0 ? hull(T(0.0), upper_end(t)) : T(0.0);
}

template <class T>
T hull_of(const std::vector<T>& values) {
    T all = values.front();
    for (const T& v : values) all = hull(all, v);
    return all;
}

template <class T>
std::vector<T> convert(const std::vector<Exact>& values) {
    std::vector<T> converted;
    for (const Exact& e : values) converted.push_back(enclosure_of<T>(e));
    return converted;
}

}  // namespace

// --- Circles and lines. --------------------------------------------------------------------------------

namespace {

// k v^2 + b v + (k u^2 + a u + e') = 0 with (u, v) = p - c and e' = e + a cx + b cy.
template <class T>
T root_of_discriminant(const CircularForm& f, const T& u) {
    const T k(f.k), a(f.a), b(f.b);
    const T constant = T(f.e) + a * T(f.cx) + b * T(f.cy);
    const T discriminant = square(b) - T(4.0) * k * (k * square(u) + a * u + constant);
    return discriminant.upper() < 0 ? T(0.0) : sqrt(discriminant);
}

}  // namespace

template <class T>
T CircularGraph::y(const T& x) const {
    const CircularForm& f = form;
    if (half == Sign::Zero) return -(T(f.a) * x + T(f.e)) / T(f.b);
    const T root = root_of_discriminant(f, T(x - T(f.cx)));
    return T(f.cy) + (signed_by(half, root) - T(f.b)) / (T(2.0) * T(f.k));
}

template <class T>
Direction<T> CircularGraph::direction(const T& x) const {
    const CircularForm& f = form;
    if (half == Sign::Zero) return f.b > 0 ? Direction<T>{T(f.b), T(-f.a)} : Direction<T>{T(-f.b), T(f.a)};
    const T u = x - T(f.cx);
    return {root_of_discriminant(f, u), signed_by(-half, T(T(2.0) * T(f.k) * u + T(f.a)))};
}

// --- Rational Bezier curves. ---------------------------------------------------------------------------

namespace {

template <class T>
T enclose_root(const std::vector<Exact>& polynomial, const SignChange& where) {
    const std::vector<T> c = convert<T>(polynomial);
    std::vector<T> derivative;
    for (std::size_t i = 0; i + 1 < c.size(); ++i) derivative.push_back(c[i + 1] - c[i]);
    const T bracket = hull(enclosure_of<T>(where.lower), enclosure_of<T>(where.upper));
    return enclose_zero(
        bracket, [&](const T& t) { return signed_by(where.after, bernstein_value<T>(c, t)); },
        [&](const T& t) {
            const T slope = hull_of(bernstein_restricted<T>(derivative, lower_end(t), upper_end(t)));
            return signed_by(where.after, T(T(static_cast<double>(derivative.size())) * slope));
        });
}

}  // namespace

BernsteinRoot::BernsteinRoot(std::shared_ptr<const std::vector<Exact>> polynomial, SignChange where)
    : polynomial_(std::move(polynomial)),
      where_(std::move(where)),
      rough_(enclose_root<Interval>(*polynomial_, where_)) {}

template <class T>
T BernsteinRoot::enclosure() const {
    if constexpr (std::is_same_v<T, Interval>) {
        return rough_;
    } else {
        if (!fine_) fine_ = enclose_root<T>(*polynomial_, where_);
        return *fine_;
    }
}

RationalBezier::RationalBezier(std::vector<Eigen::Vector3d> points) : points_(std::move(points)) {
    assert(points_.size() >= 2);
    std::array<std::vector<Exact>, 3> c;  // x, y, w
    for (const auto& p : points_) {
        const Exact w(p[2]);
        c[0].push_back(w * Exact(p[0]));
        c[1].push_back(w * Exact(p[1]));
        c[2].push_back(w);
    }
    // (X / W)' = (X' W - X W') / W^2.
    std::array<std::shared_ptr<const std::vector<Exact>>, 2> d;
    const std::vector<Exact> dw = bernstein_derivative(c[2]);
    for (int i = 0; i < 2; ++i) {
        std::vector<Exact> numerator = bernstein_scaled_product(bernstein_derivative(c[i]), c[2]);
        const std::vector<Exact> second = bernstein_scaled_product(c[i], dw);
        for (std::size_t k = 0; k < numerator.size(); ++k) numerator[k] -= second[k];
        d[i] = std::make_shared<const std::vector<Exact>>(std::move(numerator));
    }
    rough_ = {convert<Interval>(c[0]), convert<Interval>(c[1]), convert<Interval>(c[2]),
              convert<Interval>(*d[0]), convert<Interval>(*d[1])};
    fine_ = {convert<Wide>(c[0]), convert<Wide>(c[1]), convert<Wide>(c[2]), convert<Wide>(*d[0]),
             convert<Wide>(*d[1])};
    // Turns closer than 2^-200 of the domain are a coincidence like any other below that width.
    constexpr int depth = 200;
    for (const SignChange& change : bernstein_sign_changes(*d[0], depth)) turns_.emplace_back(d[0], change);
    for (const Exact& e : *d[0]) {
        if (e.sign() == Sign::Zero) continue;
        starts_rightward_ = e.sign() == Sign::Positive;
        break;
    }
}

template <class T>
const RationalBezier::Coefficients<T>& RationalBezier::coefficients() const {
    if constexpr (std::is_same_v<T, Interval>) {
        return rough_;
    } else {
        return fine_;
    }
}

template <class T>
std::pair<T, T> RationalBezier::at(const T& t) const {
    // The curve lies in the hull of its control points over t: weights stay positive.
    const auto& c = coefficients<T>();
    const T from = lower_end(t), to = upper_end(t);
    std::vector<T> x, y;
    for (std::size_t k = 0; k < points_.size(); ++k) {
        const T w = bernstein_blossom<T>(c.w, from, to, k);
        x.push_back(bernstein_blossom<T>(c.x, from, to, k) / w);
        y.push_back(bernstein_blossom<T>(c.y, from, to, k) / w);
    }
    return {hull_of(x), hull_of(y)};
}

template <class T>
T BezierGraph::parameter(const T& x) const {
    if (!is_point(x)) return hull(parameter(lower_end(x)), parameter(upper_end(x)));
    const Sign rising = rightward ? Sign::Positive : Sign::Negative;
    const auto& c = curve->coefficients<T>();
    std::vector<T> f, derivative;  // of W(t) (x(t) - x), and its derivative up to the degree
    for (std::size_t i = 0; i < c.x.size(); ++i) f.push_back(signed_by(rising, T(c.x[i] - x * c.w[i])));
    for (std::size_t i = 0; i + 1 < f.size(); ++i) derivative.push_back(f[i + 1] - f[i]);
    const T from = first.enclosure<T>(), to = last.enclosure<T>();
    return enclose_zero(
        hull(from, to),
        [&](const T& t) {
            if (t.lower() < from.upper() || t.upper() > to.lower()) return T::whole();
            return bernstein_value<T>(f, t);
        },
        [&](const T& t) {
            return T(static_cast<double>(derivative.size())) *
                   hull_of(bernstein_restricted<T>(derivative, lower_end(t), upper_end(t)));
        });
}

template <class T>
T BezierGraph::y(const T& x) const {
    return curve->at(parameter(x)).second;
}

template <class T>
Direction<T> BezierGraph::direction(const T& x) const {
    const T t = parameter(x);
    const auto& c = curve->coefficients<T>();
    const Sign sign = rightward ? Sign::Positive : Sign::Negative;
    const T from = lower_end(t), to = upper_end(t);
    return {non_negative(signed_by(sign, hull_of(bernstein_restricted<T>(c.dx, from, to)))),
            signed_by(sign, hull_of(bernstein_restricted<T>(c.dy, from, to)))};
}

#define VCELL_INSTANTIATE(T)                                        \
    template T BernsteinRoot::enclosure() const;                    \
    template T CircularGraph::y(const T&) const;                    \
    template Direction<T> CircularGraph::direction(const T&) const; \
    template std::pair<T, T> RationalBezier::at(const T&) const;    \
    template T BezierGraph::y(const T&) const;                      \
    template Direction<T> BezierGraph::direction(const T&) const;
VCELL_INSTANTIATE(Interval)
VCELL_INSTANTIATE(Wide)
#undef VCELL_INSTANTIATE

}  // namespace vcell
