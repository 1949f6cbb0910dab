/// Forms over a region by brute force: rational arithmetic for ties, 100 digits for points. It shares no code
/// with lower_envelope() but the types.
///
/// All work is done in local coordinates, relative to the middle of the region: a shifted scene is judged
/// as sharply as a centred one.
#pragma once

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"
#include "complaints.hpp"

namespace vcell::oracle {

using Rational = boost::multiprecision::cpp_rational;
using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;

// Newton's method for 1 / sqrt(a) from a double, with a last step for the root itself: to all 100 digits, in
// a third of the time that the library takes for them one by one.
inline Real root(const Real& a) {
    if (!(a > 0)) return sqrt(a);
    int exponent = 0;
    Real m = frexp(a, &exponent);
    if (exponent % 2 != 0) {
        m *= 2;
        --exponent;
    }
    Real over = 1 / std::sqrt(m.convert_to<double>());
    for (int i = 0; i < 3; ++i) over *= (3 - m * over * over) / 2;
    const Real x = m * over;
    return ldexp(Real(x + over * (m - x * x) / 2), exponent / 2);
}
template <std::floating_point T>
T root(T a) {
    return std::sqrt(a);
}

inline Rational to_rational(Exact v) {
    Rational sum = 0;
    while (v.sign() != Sign::Zero) {  // each step takes the leading 53 bits away
        const double head = v.enclosure().lower();
        if (head == 0) throw std::range_error("oracle: coefficient below the double range");
        sum += Rational(head);
        v -= Exact(head);
    }
    return sum;
}
inline Real to_real(const Rational& q) { return Real(numerator(q)) / Real(denominator(q)); }
template <class T>
T to(const Rational& q) {
    if constexpr (std::is_same_v<T, Rational>)
        return q;
    else if constexpr (std::is_same_v<T, Real>)
        return to_real(q);
    else
        return to_real(q).template convert_to<T>();
}

template <class T>
struct Point {
    T x, y;
};

/// K (x^2 + y^2) + A x + B y + C: a circle or a line, and the numerator of a form.
template <class T>
struct Quadric {
    T K, A, B, C;

    T operator()(const Point<T>& p) const { return K * (p.x * p.x + p.y * p.y) + A * p.x + B * p.y + C; }
    Point<T> gradient(const Point<T>& p) const { return {2 * K * p.x + A, 2 * K * p.y + B}; }
    Quadric operator-() const { return {-K, -A, -B, -C}; }
    template <class S>
    Quadric<S> as() const {
        return {to<S>(K), to<S>(A), to<S>(B), to<S>(C)};
    }
};

/// A form: quadric over W > 0.
template <class T>
struct Form {
    Quadric<T> n;
    T W;

    T operator()(const Point<T>& p) const { return n(p) / W; }
};

/// The zero set of f - g, negative where f is lower.
inline Quadric<Rational> difference(const Form<Rational>& f, const Form<Rational>& g) {
    return {f.n.K * g.W - g.n.K * f.W, f.n.A * g.W - g.n.A * f.W, f.n.B * g.W - g.n.B * f.W,
            f.n.C * g.W - g.n.C * f.W};
}

/// The points common to two curves: none when they are disjoint, concentric or the same.
inline std::vector<Point<Real>> intersect(const Quadric<Rational>& g, const Quadric<Rational>& h) {
    const Quadric<Rational>& circle = g.K != 0 ? g : h;
    // The member of their pencil without a square term, exact: a common line.
    const Quadric<Rational> line{0, h.K * g.A - g.K * h.A, h.K * g.B - g.K * h.B, h.K * g.C - g.K * h.C};
    if (circle.K == 0) {
        const Rational det = g.A * h.B - g.B * h.A;
        if (det == 0) return {};
        return {{to_real((g.B * h.C - h.B * g.C) / det), to_real((h.A * g.C - g.A * h.C) / det)}};
    }
    if (line.A == 0 && line.B == 0) return {};
    // Foot of the centre on the line, plus and minus the half chord along it; all but the root rational.
    const Rational cx = -circle.A / (2 * circle.K), cy = -circle.B / (2 * circle.K);
    const Rational nn = line.A * line.A + line.B * line.B;
    const Rational s = (line.A * cx + line.B * cy + line.C) / nn;
    const Rational fx = cx - s * line.A, fy = cy - s * line.B;
    const Rational half2 = (cx * cx + cy * cy - circle.C / circle.K - s * s * nn) / nn;
    if (half2 < 0) return {};
    const Real x = to_real(fx), y = to_real(fy), a = to_real(line.A), b = to_real(line.B);
    if (half2 == 0) return {{x, y}};
    const Real t = root(to_real(half2));
    return {{x - t * b, y + t * a}, {x + t * b, y - t * a}};
}

/// The only point of a circle of radius 0.
inline std::optional<Point<Real>> point_circle(const Quadric<Rational>& g) {
    if (g.K == 0 || g.A * g.A + g.B * g.B != 4 * g.K * g.C) return std::nullopt;
    return Point<Real>{to_real(-g.A / (2 * g.K)), to_real(-g.B / (2 * g.K))};
}

/// The diagram's forms, and what they are at a point.
class BruteForce : protected Complaints {
public:
    BruteForce(const MinimizationDiagram& diagram, const FormFamily& family)
        : d_(diagram), family_(family), dcel_(diagram.dcel) {
        find_origin();
        for (const FormId f : family.forms.ids()) {
            const ExactForm e = family.exact(f);
            const Form<Rational> q{
                localise({to_rational(e.K), to_rational(e.A), to_rational(e.B), to_rational(e.C)}),
                to_rational(e.W)};
            forms_.push_back(q);
            real_forms_.push_back({q.n.as<Real>(), to_real(q.W)});
            fast_forms_.push_back({q.n.as<long double>(), to<long double>(q.W)});
        }
    }

protected:
    using Fast = long double;

    // Values closer than this, relative to their size, are equal: 100 digits resolve 1e-95, and distinct
    // algebraic numbers of these degrees over doubles of moderate range stay well apart of 1e-60.
    static inline const Real kTie{"1e-60"};
    // Sampled points this close to an edge, relative to the region's size, are not asked about.
    static constexpr Fast kSkip = 1e-9L;

    void find_origin() {
        const std::size_t n = d_.region.sides.size();
        if (n < 3) throw std::invalid_argument("oracle: a region has at least three sides");
        struct {
            Fast x0 = HUGE_VALL, y0 = HUGE_VALL, x1 = -HUGE_VALL, y1 = -HUGE_VALL;
        } box;
        for (std::size_t i = 0; i < n; ++i) {
            const auto& s = d_.region.sides[i];
            const auto& t = d_.region.sides[(i + 1) % n];
            const Fast det = Fast(s.a) * t.b - Fast(s.b) * t.a;
            const Fast x = (Fast(s.b) * t.c - Fast(t.b) * s.c) / det;
            const Fast y = (Fast(t.a) * s.c - Fast(s.a) * t.c) / det;
            box.x0 = std::min(box.x0, x), box.x1 = std::max(box.x1, x);
            box.y0 = std::min(box.y0, y), box.y1 = std::max(box.y1, y);
        }
        origin_ = {static_cast<double>((box.x0 + box.x1) / 2), static_cast<double>((box.y0 + box.y1) / 2)};
        half_ = {(box.x1 - box.x0) / 2, (box.y1 - box.y0) / 2};
        size_ = std::max(half_.x, half_.y);
        for (const auto& s : d_.region.sides)
            sides_.push_back(localise({0, Rational(s.a), Rational(s.b), Rational(s.c)}));
    }

    Quadric<Rational> localise(const Quadric<Rational>& g) const {
        const Rational x(origin_.x), y(origin_.y);
        return {g.K, g.A + 2 * g.K * x, g.B + 2 * g.K * y, g.C + g.A * x + g.B * y + g.K * (x * x + y * y)};
    }

    /// All forms that attain the minimum at p, ascending. T is Real or Rational; exact for the latter.
    template <class T>
    std::vector<FormId> minimal(const Point<T>& p, const std::vector<Form<T>>& forms) const {
        Point<Fast> q;
        if constexpr (std::is_same_v<T, Rational>)
            q = {to<Fast>(p.x), to<Fast>(p.y)};
        else
            q = {p.x.template convert_to<Fast>(), p.y.template convert_to<Fast>()};
        // long double rules out all that is higher by more than its rounding.
        std::vector<Fast> low(forms.size());
        Fast lowest_upper = HUGE_VALL;
        for (std::size_t i = 0; i < forms.size(); ++i) {
            const Form<Fast>& f = fast_forms_[i];
            const Fast size = std::abs(f.n.K) * (q.x * q.x + q.y * q.y) + std::abs(f.n.A * q.x) +
                              std::abs(f.n.B * q.y) + std::abs(f.n.C);
            const Fast value = f(q);
            Fast error = 16 * std::numeric_limits<Fast>::epsilon() * size / f.W;
            // Next to the origin all terms of a form may be as small as the error of a refined p.
            if constexpr (std::is_same_v<T, Real>)
                error += kTie.template convert_to<Fast>() * (1 + std::abs(value));
            low[i] = value - error;
            lowest_upper = std::min(lowest_upper, value + error);
        }
        std::vector<FormId> result;
        std::optional<T> best;
        for (std::size_t i = 0; i < forms.size(); ++i) {
            if (low[i] > lowest_upper) continue;
            const T value = forms[i](p);
            T slack = 0;
            if constexpr (std::is_same_v<T, Real>) slack = kTie * (1 + abs(value));
            if (best && value > *best + slack) continue;
            if (best && value < *best - slack) result.clear();
            if (!best || value < *best) best = value;
            result.push_back({static_cast<std::uint32_t>(i)});
        }
        return result;
    }

    bool inside(const Point<Real>& p) const {
        return std::ranges::all_of(sides_, [&](const auto& s) {
            const Quadric<Real> g = s.template as<Real>();
            return g(p) >= -kTie * (abs(g.A) + abs(g.B)) * size_;
        });
    }

    bool on_side(const Point<Real>& p, std::size_t side) const {
        const Quadric<Real> g = sides_[side].as<Real>();
        return abs(g(p)) <= kTie * (abs(g.A) + abs(g.B)) * size_;
    }

    const MinimizationDiagram& d_;
    const FormFamily& family_;
    const Dcel& dcel_;
    Point<double> origin_{};
    Point<Fast> half_{};
    Fast size_ = 0;
    std::vector<Quadric<Rational>> sides_;
    std::vector<Form<Rational>> forms_;
    std::vector<Form<Real>> real_forms_;
    std::vector<Form<Fast>> fast_forms_;
};

}  // namespace vcell::oracle
