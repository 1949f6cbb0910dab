#include "twins.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace vcell {

namespace {

using Jet = FunctionJet<Interval>;

// Numbers of twins differ by less than this part of the largest one among them.
constexpr double alike = 0x1p-10;

// K (x^2 + y^2) + A x + B y + C over W.
template <class T>
PlaneTerms<T> terms_of_circle(const T& K, const T& A, const T& B, const T& C, const T& W) {
    const T zero(0.0);
    return {-(W + W), {C, A, B, K, zero, K}, {zero, zero, zero, zero, zero, zero}};
}

// In the cylinder's unit lengths are multiplied by u: the equation is that of primitives/forms/exact_heights,
// of a hollow one with all signs changed, so that R is positive.
template <class T>
PlaneTerms<T> terms_of_cylinder(const CylinderNumbers<T>& f, const T& u, bool is_hollow) {
    const T side(is_hollow ? -1.0 : 1.0),
        uu = side * u * u, su = side * u, norm = f.ax * f.ax + f.ay * f.ay + f.az * f.az,
        M = norm - f.sine * f.sine, k = f.px * f.ax + f.py * f.ay + f.pz * f.az, two_u = su + su,
        squares = M * (f.px * f.px + f.py * f.py + f.pz * f.pz) - norm * f.rho * f.rho, zero(0.0);
    return {-(uu * f.steep * f.steep),
            {-(su * (norm * f.rho + M * f.pz - k * f.steep)), -(uu * f.ax * f.steep), -(uu * f.ay * f.steep),
             zero, zero, zero},
            {side * (squares - k * k), two_u * (f.ax * k - M * f.px), two_u * (f.ay * k - M * f.py),
             uu * (M - f.ax * f.ax), -((uu + uu) * f.ax * f.ay), uu * (M - f.ay * f.ay)}};
}

template <class T>
AffineTerm<T> operator*(const T& factor, const AffineTerm<T>& a) {
    return {factor * a.v0, {factor * a.v[0], factor * a.v[1], factor * a.v[2]}};
}

template <class T, class Convert>
RadialTerms<T> terms_of_radial(const RadialForm& f, Convert&& to) {
    const auto all = [&](const std::array<Exact, 3>& v) {
        return std::array<T, 3>{to(v[0]), to(v[1]), to(v[2])};
    };
    const AffineTerm<T> a{to(f.a0), all(f.a)};
    return {all(f.c), {to(f.b0), all(f.b)}, to(f.slope) * a, a, T(f.is_hollow ? -1.0 : 1.0) * a};
}

// A circular form over a sphere (RadialHeight), times 4.
template <class T>
RadialTerms<T> terms_on_sphere(const T& K, const T& A, const T& B, const T& C, const T& W) {
    const T zero(0.0);
    const AffineTerm<T> none{zero, {zero, zero, zero}};
    return {{T(4.0) * W, zero, zero}, {-(K + C), {-A, -B, K - C}}, none, none, none};
}

struct FormTerms {
    EitherTerms<Exact> of;
    bool has_root;
};

FormTerms terms(const FormFamily& family, FormId f) {
    if (family.is_circular(f)) {
        const auto [K, A, B, C, W] = family.exact(f);
        if (family.radial.empty()) return {terms_of_circle(K, A, B, C, W), false};
        return {terms_on_sphere(K, A, B, C, W), false};
    }
    if (family.radial.empty()) {
        const CylinderForm& c = family.cylinder(f);
        const ExactCylinder exact = exact_cylinder(c);
        return {terms_of_cylinder<Exact>(exact, exact.unit, c.is_hollow()), true};
    }
    const RadialForm& r = family.radial_form(f);
    return {terms_of_radial<Exact>(r, [](const Exact& e) { return e; }), r.has_root()};
}

// The same in doubles: to compare forms at a glance.
EitherTerms<double> rough_terms(const FormFamily& family, FormId f) {
    if (family.is_circular(f)) {
        const CircularForm& c = family.forms[f];
        const double A = c.a - 2 * c.k * c.cx, B = c.b - 2 * c.k * c.cy,
                     C = c.e + c.k * (c.cx * c.cx + c.cy * c.cy);
        if (family.radial.empty()) return terms_of_circle(c.k, A, B, C, c.w);
        return terms_on_sphere(c.k, A, B, C, c.w);
    }
    if (family.radial.empty()) {
        const CylinderForm& c = family.cylinder(f);
        return terms_of_cylinder(numbers_of<double>(c), 1.0, c.is_hollow());
    }
    return terms_of_radial<double>(family.radial_form(f), [](const Exact& e) { return e.enclosure().mid(); });
}

template <class T, std::size_t n, class Function>
auto each(const std::array<T, n>& a, Function&& f) {
    std::array<decltype(f(a[0])), n> out;
    std::ranges::transform(a, out.begin(), f);
    return out;
}

template <class Function>
auto each(const PlaneTerms<Exact>& t, Function&& f) {
    return PlaneTerms<decltype(f(t.a))>{f(t.a), each(t.b, f), each(t.c, f)};
}
template <class Function>
auto each(const AffineTerm<Exact>& t, Function&& f) {
    return AffineTerm<decltype(f(t.v0))>{f(t.v0), each(t.v, f)};
}
template <class Function>
auto each(const RadialTerms<Exact>& t, Function&& f) {
    return RadialTerms<decltype(f(t.b.v0))>{each(t.c, f), each(t.b, f), each(t.s, f), each(t.p, f),
                                            each(t.q, f)};
}

template <std::size_t n>
std::array<Exact, n> less(const std::array<Exact, n>& a, const Exact& factor, const std::array<Exact, n>& b) {
    std::array<Exact, n> out;
    for (std::size_t i = 0; i < n; ++i) out[i] = a[i] - factor * b[i];
    return out;
}

AffineTerm<Exact> less(const AffineTerm<Exact>& a, const Exact& factor, const AffineTerm<Exact>& b) {
    return {a.v0 - factor * b.v0, less(a.v, factor, b.v)};
}

// The terms of f less lambda times those of g; p q of theirs is (p_f - mu p_g) (q_f + mu q_g), lambda = mu^2.
PlaneTerms<Exact> less(const PlaneTerms<Exact>& f, const Exact& mu, const PlaneTerms<Exact>& g) {
    const Exact lambda = mu * mu;
    return {f.a - lambda * g.a, less(f.b, lambda, g.b), less(f.c, lambda, g.c)};
}
RadialTerms<Exact> less(const RadialTerms<Exact>& f, const Exact& mu, const RadialTerms<Exact>& g) {
    const Exact lambda = mu * mu;
    return {less(f.c, lambda, g.c), less(f.b, lambda, g.b), less(f.s, lambda, g.s), less(f.p, mu, g.p),
            less(f.q, -mu, g.q)};
}

struct TermJets {
    Jet a, b, c;
};

TermJets terms_over(const PlaneTerms<Interval>& t, const std::array<Interval, 2>& place) {
    const auto& [x, y] = place;
    // About the middle of the box.
    const Interval mx(x.mid()), my(y.mid()), dx = x - mx, dy = y - my;
    const auto polynomial = [&](const std::array<Interval, 6>& k) -> Jet {
        const Interval kx = k[1] + 2.0 * (k[3] * mx) + k[4] * my, ky = k[2] + k[4] * mx + 2.0 * (k[5] * my),
                       at = k[0] + mx * (k[1] + k[3] * mx + k[4] * my) + my * (k[2] + k[5] * my);
        return {at + kx * dx + ky * dy + k[3] * square(dx) + k[4] * (dx * dy) + k[5] * square(dy),
                kx + 2.0 * (k[3] * dx) + k[4] * dy,
                ky + k[4] * dx + 2.0 * (k[5] * dy),
                2.0 * k[3],
                k[4],
                2.0 * k[5]};
    };
    return {Jet::constant(t.a), polynomial(t.b), polynomial(t.c)};
}

TermJets terms_over(const RadialTerms<Interval>& t, const RadialNormals<Interval>& n) {
    const Interval &y = n.y(), &m = n.middle_y(), dy = y - m;
    const auto affine = [&](const AffineTerm<Interval>& a) { return Jet::constant(a.v0) + n.along<2>(a.v); };
    const Jet c = -(affine(t.p) * affine(t.q));
    if (n.around() == nullptr) return {Jet::constant(t.c[0]), affine(t.b), c};
    const Interval slope = t.c[1] + 2.0 * (t.c[2] * m), at = t.c[0] + m * (t.c[1] + t.c[2] * m), zero(0.0);
    const Jet a{
        at + slope * dy + t.c[2] * square(dy), zero, slope + 2.0 * (t.c[2] * dy), zero, zero, 2.0 * t.c[2]},
        along{dy, zero, Interval(1.0), zero, zero, zero};
    // What is linear in y is taken together at the middle.
    AffineTerm<Interval> middle{t.b.v0 + m * t.s.v0, {}};
    for (std::size_t i = 0; i < 3; ++i) middle.v[i] = t.b.v[i] + m * t.s.v[i];
    return {a, affine(middle) + along * affine(t.s), c};
}

// R, which is b where there is no root, also where no ray meets the object as b < 0.
template <class Terms, class Place>
Jet root_over(const Terms& t, bool has_root, const Place& place) {
    const TermJets j = terms_over(t, place);
    return has_root ? sqrt(square(j.b) + -(j.a * j.c)) : j.b;
}

}  // namespace

FormSignature::FormSignature(const FormFamily& family, FormId f) {
    is_circular = family.is_circular(f);
    if (!is_circular) {
        const bool is_radial = !family.radial.empty();
        has_root = !is_radial || family.radial_form(f).has_root();
        is_hollow = has_root && is_radial && family.radial_form(f).is_hollow;
    }
    std::size_t n = 0;
    const auto put = [&](const auto& all) {
        for (const double number : all) numbers[n++] = number;
        return n;
    };
    const EitherTerms<double> rough = rough_terms(family, f);
    double square_of_scale;
    if (const auto* plane = std::get_if<PlaneTerms<double>>(&rough)) {
        ends = {put(std::array{plane->a}), put(plane->b), put(plane->c)};
        square_of_scale = has_root ? std::abs(numbers[10] + numbers[12]) : -numbers[0];
    } else {
        const auto& radial = *std::get_if<RadialTerms<double>>(&rough);
        const auto put_affine = [&](const AffineTerm<double>& a) {
            put(std::array{a.v0});
            return put(a.v);
        };
        ends[0] = put(radial.c);
        put_affine(radial.b);
        ends[1] = put_affine(radial.s);
        ends[2] = put_affine(radial.p);
        const auto& v = numbers;
        square_of_scale =
            is_circular ? std::max({std::abs(v[0]), std::abs(v[1]), v[2]}) : largest(ends[0], ends[1]);
        c_is_square = true;
    }
    scale = std::sqrt(square_of_scale);
}

double FormSignature::largest(std::size_t from, std::size_t to) const {
    double most = 0;
    for (std::size_t i = from; i < to; ++i) most = std::max(most, std::abs(numbers[i]));
    return most;
}

std::optional<double> FormSignature::factor(const FormSignature& o) const {
    const double mu = scale / o.scale;
    if (is_circular != o.is_circular || (has_root && o.has_root && is_hollow != o.is_hollow) || !(mu > 0) ||
        !std::isfinite(mu))
        return std::nullopt;
    // A group agrees whose numbers differ by little beside its largest one, or beside a number that is
    // larger.
    const auto agree = [&](std::size_t from, std::size_t to, double k, double beside = 0) {
        double apart = 0;
        for (std::size_t i = from; i < to; ++i)
            apart = std::max(apart, std::abs(numbers[i] - k * o.numbers[i]));
        return apart <= alike * std::max(beside, largest(from, to));
    };
    const double lambda = mu * mu, b = largest(ends[0], ends[1]);
    if (!agree(ends[0], ends[1], lambda)) return std::nullopt;
    // What lies along the base but for little has next to no a over a plane, or next to no p about an axis.
    // In the scene's unit heights are no more than some units, and terms no more than some times their
    // numbers.
    if (!c_is_square)
        return agree(0, ends[0], lambda, b) && agree(ends[1], ends[2], lambda) ? std::optional(mu)
                                                                               : std::nullopt;
    if (!agree(0, ends[0], lambda)) return std::nullopt;
    for (const double signed_mu : {mu, -mu})
        if (agree(ends[1], ends[2], signed_mu, std::sqrt(b))) return signed_mu;
    return std::nullopt;
}

std::vector<bool> which_have_twins(std::span<const FormSignature> forms) {
    // A number that twins have nearly in common, and few others do: a sum of all with weights.
    struct Key {
        double number, size;
        std::size_t form;
    };
    std::vector<Key> keys;
    keys.reserve(forms.size());
    for (std::size_t f = 0; f < forms.size(); ++f) {
        const FormSignature& form = forms[f];
        Key key{0, 0, f};
        for (std::size_t i = 0; i < form.ends[form.c_is_square ? 1 : 2]; ++i) {
            const double term = form.numbers[i] / (form.scale * form.scale) / static_cast<double>(i + 1);
            key.number += term;
            key.size = std::max(key.size, std::abs(term));
        }
        if (std::isfinite(key.number)) keys.push_back(key);
    }
    std::ranges::sort(keys, {}, &Key::number);
    std::vector<bool> have(forms.size(), false);
    // The nearer twins are, the nearer are their keys.
    constexpr std::size_t most_compared = 64;
    constexpr auto most_terms = static_cast<double>(std::tuple_size_v<decltype(FormSignature::numbers)>);
    for (std::size_t i = 0; i < keys.size(); ++i)
        for (std::size_t j = i + 1; j < std::min(keys.size(), i + most_compared); ++j) {
            if (keys[j].number - keys[i].number > most_terms * 2 * alike * keys[i].size) break;
            const std::size_t f = keys[i].form, g = keys[j].form;
            if (have[f] && have[g]) continue;
            if (forms[f].factor(forms[g])) have[f] = have[g] = true;
        }
    return have;
}

TwinDifference::TwinDifference(const FormFamily& family, FormId f, FormId g, double mu)
    : lambda_((Exact(mu) * Exact(mu)).enclosure()) {
    const FormTerms p = terms(family, f), q = terms(family, g);
    have_roots_ = {p.has_root, q.has_root};
    const auto enclose = [](const Exact& e) { return e.enclosure(); };
    const auto take = [&]<class Terms>(const Terms& of_f) {
        const Terms& of_g = *std::get_if<Terms>(&q.of);
        f_ = each(of_f, enclose);
        g_ = each(of_g, enclose);
        less_ = each(less(of_f, Exact(mu), of_g), enclose);
    };
    std::visit(take, p.of);
}

template <class Terms, class Place>
FunctionJet<Interval> TwinDifference::difference(const FunctionJet<Interval>& f, const Place& place) const {
    const auto of = [](const EitherTerms<Interval>& t) -> const Terms& { return *std::get_if<Terms>(&t); };
    const TermJets d = terms_over(of(less_), place);
    const Jet slope = d.a * f + d.b;
    const auto& [f_has, g_has] = have_roots_;
    if (!f_has && !g_has) return -((slope + d.b) / (lambda_ * terms_over(of(g_), place).a));
    return (slope * f + d.b * f + d.c) /
           (root_over(of(f_), f_has, place) + lambda_ * root_over(of(g_), g_has, place) + slope);
}

FunctionJet<Interval> TwinDifference::over(const FunctionJet<Interval>& f, const Interval& x,
                                           const Interval& y) const {
    return difference<PlaneTerms<Interval>>(f, std::array{x, y});
}

FunctionJet<Interval> TwinDifference::over(const FunctionJet<Interval>& f,
                                           const RadialNormals<Interval>& normals) const {
    return difference<RadialTerms<Interval>>(f, normals);
}

}  // namespace vcell
