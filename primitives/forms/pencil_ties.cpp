#include "pencil_ties.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "../objects/exact_space.hpp"

namespace vcell {

namespace {

constexpr std::size_t most_compared = 32;

// These stand for E times a positive number: `weight` for C, `at` for the coefficients of t and t^2 as E has
// them, their signs included.
constexpr std::size_t dimension = 10;
template <class T>
struct Numbers {
    T weight;
    std::array<T, dimension> at;
};
template <class T>
Numbers<T> numbers(const T& K, const T& A, const T& B, const T& C, const T& W) {
    const T zero(0.0);
    return {W + W, {A, B, C - K, C + K, zero, zero, zero, zero, zero, zero}};
}
template <class T>
Numbers<T> numbers(const T& C, const T& b0, const std::array<T, 3>& b, const std::array<T, 3>& a) {
    const T two(2.0);
    return {C,
            {-(two * b[0]), -(two * b[1]), -(two * b[2]), -(two * b0), -(a[0] * a[0]), -(a[1] * a[1]),
             -(a[2] * a[2]), -(two * a[0] * a[1]), -(two * a[1] * a[2]), -(two * a[2] * a[0])}};
}

Numbers<Exact> exact_numbers(const FormFamily& family, FormId f) {
    if (!family.is_circular(f)) {
        const RadialForm& r = family.radial_form(f);
        return numbers(r.c[0], r.b0, r.b, r.a);
    }
    const auto [K, A, B, C, W] = family.exact(f);
    return numbers(K, A, B, C, W);
}
Numbers<double> rounded_numbers(const FormFamily& family, FormId f) {
    if (!family.is_circular(f)) {
        const RadialForm& r = family.radial_form(f);
        const auto all = [](const std::array<Exact, 3>& v) {
            return std::array<double, 3>{nearest(v[0]), nearest(v[1]), nearest(v[2])};
        };
        return numbers(nearest(r.c[0]), nearest(r.b0), all(r.b), all(r.a));
    }
    const CircularForm& c = family.forms[f];
    return numbers(c.k, c.a, c.b, c.e, c.w);
}
bool takes_part(const FormFamily& family, FormId f) {
    if (family.is_circular(f)) return true;
    const RadialForm& r = family.radial_form(f);
    return !r.is_hollow && r.a0.sign() == Sign::Zero && r.c[0].sign() == Sign::Positive;
}

using Point = Eigen::Matrix<double, dimension, 1>;

// This is where the form is in that space, but for rounding.
Point point(const FormFamily& family, FormId f) {
    const Numbers<double> n = rounded_numbers(family, f);
    return Eigen::Map<const Point>(n.at.data()) / n.weight;
}

// How low the form comes; a tube's square is left out, as this only chooses what is compared.
double lowest(const Point& p) { return p[3] - p.head<3>().norm(); }

struct Place {
    FormId form;
    Point at;
};

// These are compared, as they come lowest.
std::vector<Place> candidates(const FormFamily& family) {
    std::vector<Place> places;
    places.reserve(family.size());
    for (FormId f{0}; f.value < family.size(); ++f.value)
        if (takes_part(family, f)) places.push_back({f, point(family, f)});
    const auto height = [](const Place& p) { return lowest(p.at); };
    if (places.size() > most_compared) {
        std::ranges::nth_element(places, places.begin() + most_compared, {}, height);
        places.resize(most_compared);
        std::ranges::sort(places, {}, &Place::form);
    }
    return places;
}

// Is c between f and g? Exact.
bool is_between(const FormFamily& family, FormId c, FormId f, FormId g) {
    const Numbers<Exact> C = exact_numbers(family, c), F = exact_numbers(family, f),
                         G = exact_numbers(family, g);
    const auto less = [&F](const Numbers<Exact>& h) {  // times both weights
        std::array<Exact, dimension> way;
        for (std::size_t i = 0; i < dimension; ++i) way[i] = h.at[i] * F.weight - F.at[i] * h.weight;
        return way;
    };
    const std::array<Exact, dimension> u = less(C), v = less(G);
    const auto along = std::ranges::find_if(v, [](const Exact& x) { return x.sign() != Sign::Zero; });
    if (along == v.end()) return false;
    const auto k = static_cast<std::size_t>(along - v.begin());
    for (std::size_t i = 0; i < dimension; ++i)
        if ((u[i] * v[k] - u[k] * v[i]).sign() != Sign::Zero) return false;
    const Sign way = v[k].sign();
    return u[k].sign() == way && (v[k] * C.weight - u[k] * G.weight).sign() == way;
}

// E of f where that of a linear form s is zero, at t = -weight / (at . (u, 1)), times a positive number: a
// polynomial in u, |u| = 1, by its coefficients of degree 2 and 1.
constexpr std::size_t coefficients = 9;
template <class T, class At>
std::array<T, coefficients> on_surface(const T& W, const At& m, const T& w, const At& l) {
    const T two(2.0);
    const auto even = [&](std::size_t i, std::size_t j, std::size_t q) {
        T c = W * l[i] * l[j] - w * m[i] * l[j];
        if (i == j) return c + W * l[3] * l[3] - w * m[3] * l[3] + w * w * m[q];
        return c + W * l[i] * l[j] - w * m[j] * l[i] + w * w * m[q];
    };
    const auto odd = [&](std::size_t i) { return two * W * l[3] * l[i] - w * (m[3] * l[i] + m[i] * l[3]); };
    return {even(0, 0, 4), even(1, 1, 5), even(2, 2, 6), even(0, 1, 7), even(1, 2, 8),
            even(2, 0, 9), odd(0),        odd(1),        odd(2)};
}

// Is the linear form s a factor of a mean of f and g, and the other one of opposite gradient? Exact.
bool is_factor(const FormFamily& family, FormId s, FormId f, FormId g) {
    const Numbers<Exact> S = exact_numbers(family, s), F = exact_numbers(family, f),
                         G = exact_numbers(family, g);
    const std::array<Exact, coefficients> u = on_surface(F.weight, F.at, S.weight, S.at),
                                          v = on_surface(G.weight, G.at, S.weight, S.at);
    const auto some = std::ranges::find_if(u, [](const Exact& x) { return x.sign() != Sign::Zero; });
    if (some == u.end()) return false;
    const auto k = static_cast<std::size_t>(some - u.begin());
    if ((u[k] * v[k]).sign() != Sign::Negative) return false;
    for (std::size_t i = 0; i < coefficients; ++i)
        if ((u[i] * v[k] - u[k] * v[i]).sign() != Sign::Zero) return false;
    // The mean's weights, but for a positive factor. It is W + m t + .. and S is w + l t: the other one is
    // W / w + (m - l W / w) t / w.
    const bool is_positive = u[k].sign() == Sign::Positive;
    const Exact weight_f = is_positive ? -v[k] : v[k], weight_g = is_positive ? u[k] : -u[k],
                weight = weight_f * F.weight + weight_g * G.weight;
    std::array<Exact, 4> other;
    for (std::size_t i = 0; i < other.size(); ++i)
        other[i] = S.weight * (weight_f * F.at[i] + weight_g * G.at[i]) - weight * S.at[i];
    const auto slope = std::ranges::find_if(S.at, [](const Exact& x) { return x.sign() != Sign::Zero; });
    if (slope == S.at.end()) return false;
    const auto n = static_cast<std::size_t>(slope - S.at.begin());
    if ((S.at[n] * other[n]).sign() != Sign::Negative) return false;
    for (std::size_t i = 0; i < other.size(); ++i)
        if ((S.at[i] * other[n] - S.at[n] * other[i]).sign() != Sign::Zero) return false;
    return true;
}

// Linear forms that are factors of means of two others, which are not both linear: those are in pencils.
void find_factor_ties(const FormFamily& family, const std::vector<Place>& places,
                      std::vector<PencilTie>& ties) {
    constexpr double apart = 0x1p-20, alike = 0x1p-28;
    using Coefficients = Eigen::Matrix<double, coefficients, 1>;
    const Coefficients somewhere = Coefficients::LinSpaced(0.3371, 0.6911);
    struct Line {
        Coefficients direction;
        double key;  // of the line, in whichever sense
        FormId form;
    };
    std::vector<Line> lines;
    for (const Place& place : places) {
        if (!family.is_circular(place.form)) continue;
        lines.clear();
        for (const Place& other : places) {
            if (other.form == place.form) continue;
            const std::array<double, coefficients> c = on_surface(1.0, other.at, 1.0, place.at);
            const Coefficients v = Eigen::Map<const Coefficients>(c.data());
            const double size = 1 + place.at.squaredNorm() + other.at.norm() * (1 + place.at.norm());
            const double length = v.norm();
            if (!(length > apart * size)) continue;
            lines.push_back({v / length, std::abs(v.dot(somewhere)) / length, other.form});
        }
        std::ranges::sort(lines, {}, &Line::key);
        for (std::size_t i = 0; i < lines.size(); ++i)
            for (std::size_t j = i + 1; j < lines.size() && lines[j].key - lines[i].key < alike; ++j) {
                if (!((lines[i].direction + lines[j].direction).norm() < alike)) continue;
                if (family.is_circular(lines[i].form) && family.is_circular(lines[j].form)) continue;
                const auto [f, g] = std::minmax(lines[i].form, lines[j].form);
                if (is_factor(family, place.form, f, g)) ties.push_back({place.form, {f, g}, true});
            }
    }
}

}  // namespace

std::vector<PencilTie> find_pencil_ties(const FormFamily& family) {
    // Rounding does less than that to directions between points that are not next to each other.
    constexpr double apart = 0x1p-20, alike = 0x1p-28;
    const Point somewhere = Point::LinSpaced(0.2913, 0.7138);  // tells directions apart that are not alike
    const std::vector<Place> places = candidates(family);
    std::vector<PencilTie> ties;
    find_factor_ties(family, places, ties);
    struct Ray {
        Point direction;
        double length, key;
        FormId to;
    };
    std::vector<Ray> rays;
    for (const Place& from : places) {
        rays.clear();
        for (const Place& to : places) {
            const Point way = to.at - from.at;
            const double length = way.norm();
            if (!(length > apart * (to.at.norm() + from.at.norm()))) continue;
            rays.push_back({way / length, length, way.dot(somewhere) / length, to.form});
        }
        std::ranges::sort(rays, {}, &Ray::key);
        for (std::size_t i = 0; i < rays.size(); ++i)
            for (std::size_t j = i + 1; j < rays.size() && rays[j].key - rays[i].key < alike; ++j) {
                if (!((rays[i].direction - rays[j].direction).norm() < alike)) continue;
                const bool is_first_nearer = rays[i].length < rays[j].length;
                const FormId near = rays[is_first_nearer ? i : j].to, far = rays[is_first_nearer ? j : i].to;
                // Each is found from both of its ends.
                if (from.form < far && is_between(family, near, from.form, far))
                    ties.push_back({near, {from.form, far}});
            }
    }
    return ties;
}

}  // namespace vcell
