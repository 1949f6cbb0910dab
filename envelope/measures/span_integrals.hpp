/// Integrals along rational Bezier spans, with proven bounds of the truncation.
///
/// Gauss-Legendre quadrature with the bound of quadrature.hpp, its M from the integrand's value on the disk
/// |t| <= 2.4 around the span [-1, 1], which contains the ellipse. Spans whose bound is infinite or poor are
/// halved.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "../../core/quadrature/complex_ball.hpp"
#include "../../core/quadrature/quadrature.hpp"

namespace vcell {

/// A value and a bound of its error: truncation and rounding.
struct Integral {
    double value = 0, error = 0;

    Integral& operator+=(const Integral& o) {
        value += o.value;
        error += o.error;
        return *this;
    }
};

namespace span_integrals {

/// Rounding of one value of an integrand, as a part of what enters it: some sixty operations, doubled.
inline constexpr double term_rounding = 64 * std::numeric_limits<double>::epsilon();

/// Position and derivative on a span.
template <class T>
struct SpanPoint {
    T x, y, z, x1, y1, z1;
};

/// A Bezier span over [-1, 1] in powers of its parameter, homogeneous.
class PowerSpan {
public:
    static constexpr int largest_degree = 5;

    /// Control points (x, y, z, w), w divided out. Powers are those about `origin`: near the span derivatives
    /// are known to roundings of its size, however far away it is.
    explicit PowerSpan(std::span<const Eigen::Vector4d> points,
                       const Eigen::Vector3d& origin = Eigen::Vector3d::Zero())
        : degree_(static_cast<int>(points.size()) - 1), origin_(origin) {
        std::array<Eigen::Vector4d, largest_degree + 1> b;
        for (int k = 0; k <= degree_; ++k) {
            const Eigen::Vector4d& p = points[k];
            b[k] << p.w() * (p.head<3>() - origin), p.w();
        }
        // De Casteljau at the middle leaves the right half's points, whose k-th differences times a binomial
        // are the coefficients.
        for (int level = 1; level <= degree_; ++level)
            for (int k = 0; k + level <= degree_; ++k) b[k] = 0.5 * (b[k] + b[k + 1]);
        double binomial = 1;
        for (int k = 0; k <= degree_; ++k) {
            a_[k] = binomial * b[0];
            for (int i = 0; i + k < degree_; ++i) b[i] = b[i + 1] - b[i];
            binomial *= static_cast<double>(degree_ - k) / (k + 1);
        }
    }

    /// One half, over [-1, 1] again: t -> (t -+ 1) / 2.
    PowerSpan half(int side) const {
        PowerSpan result = *this;
        const double shift = side == 0 ? -1 : 1;
        for (int k = 0; k < degree_; ++k)  // Taylor shift by Horner's scheme
            for (int i = degree_ - 1; i >= k; --i) result.a_[i] += 0.5 * shift * result.a_[i + 1];
        double scale = 1;
        for (int k = 0; k <= degree_; ++k, scale *= 0.5) result.a_[k] *= scale;
        return result;
    }

    int degree() const { return degree_; }

    /// Homogeneous, about the origin: (w x, w y, w z, w), the first degree() + 1.
    std::array<Eigen::Vector4d, largest_degree + 1> control_points() const {
        // Powers about t = -1, whose differences are those of the control points but for a binomial.
        std::array<Eigen::Vector4d, largest_degree + 1> b = a_;
        for (int k = 0; k < degree_; ++k)
            for (int i = degree_ - 1; i >= k; --i) b[i] -= b[i + 1];
        double scale = 1, binomial = 1;
        for (int k = 0; k <= degree_; ++k) {
            b[k] *= scale / binomial;
            scale *= 2;
            binomial *= static_cast<double>(degree_ - k) / (k + 1);
        }
        for (int level = 0; level < degree_; ++level)
            for (int k = degree_; k > level; --k) b[k] += b[k - 1];
        return b;
    }

    /// The range of the curve's length: from its chord's to its control polygon's, which crosses no plane
    /// less often than the curve does [Cauchy-Crofton]. Pre: positive weights, otherwise the upper end is
    /// infinite.
    std::array<double, 2> length_range() const {
        auto b = control_points();
        double polygon = 0;
        for (int k = 0; k <= degree_; ++k) {
            if (!(b[k].w() > 0)) return {0, std::numeric_limits<double>::infinity()};
            b[k] /= b[k].w();
            if (k > 0) polygon += (b[k] - b[k - 1]).norm();
        }
        return {(b[degree_] - b[0]).norm(), polygon};
    }

    template <class T>
    SpanPoint<T> at(const T& t) const {
        // From the span's middle on: of disks a quotient's numerator and weight would otherwise part as far
        // as the curve is from the origin.
        constexpr bool is_disk = !std::is_same_v<T, double>;
        Eigen::Vector3d middle, from = origin_;
        if constexpr (is_disk) {
            middle = a_[0].head<3>() / a_[0].w();
            from += middle;
        }
        const auto coefficient = [&](int k, int i) {
            if constexpr (is_disk)
                if (i < 3) return a_[k][i] - middle[i] * a_[k].w();
            return a_[k][i];
        };
        std::array<T, 4> p, d;
        for (int i = 0; i < 4; ++i) {
            p[i] = T(coefficient(degree_, i));
            d[i] = T(0.0);
        }
        for (int k = degree_ - 1; k >= 0; --k)
            for (int i = 0; i < 4; ++i) {
                d[i] = d[i] * t + p[i];
                p[i] = p[i] * t + T(coefficient(k, i));
            }
        const T w = T(1.0) / p[3];
        const T x = p[0] * w, y = p[1] * w, z = p[2] * w;
        const T x1 = (d[0] - x * d[3]) * w, y1 = (d[1] - y * d[3]) * w, z1 = (d[2] - z * d[3]) * w;
        return {T(from.x()) + x, T(from.y()) + y, T(from.z()) + z, x1, y1, z1};
    }

private:
    int degree_;
    Eigen::Vector3d origin_;
    std::array<Eigen::Vector4d, largest_degree + 1> a_;
};

/// Adds an integrand's integrals along a span. It offers N values at a SpanPoint of any number type, and at
/// one of doubles their sizes: the sums of the absolute values of their terms.
template <std::size_t N, class Integrand>
void integrate(const PowerSpan& span, const Integrand& integrand, std::array<Integral, N>& sum, int halvings,
               int& budget) {
    // The bound may exceed the integrand's size by this factor: 4e-21 of it is next to nothing.
    constexpr double largest_growth = 1e4, ellipse = 2.4;
    const auto bounds = integrand(span.at(ComplexBall(0.0, ellipse)));
    bool good =
        std::ranges::all_of(bounds, [](const ComplexBall& b) { return std::isfinite(b.magnitude()); });
    const bool may_halve = halvings > 0 && budget > 0;
    const auto integrate_halves = [&] {
        --budget;
        for (const int side : {0, 1}) integrate(span.half(side), integrand, sum, halvings - 1, budget);
    };
    if (!good && may_halve) return integrate_halves();
    std::array<double, N> value{}, size{};
    const quadrature::Rule& rule = quadrature::rule();
    for (int i = 0; i < quadrature::points / 2; ++i) {
        for (const double t : {-rule.x[i], rule.x[i]}) {
            const SpanPoint<double> p = span.at(t);
            const std::array<double, N> f = integrand(p), s = integrand.sizes(p);
            for (std::size_t k = 0; k < N; ++k) {
                value[k] += rule.weight[i] * f[k];
                size[k] += rule.weight[i] * s[k];
            }
        }
    }
    for (std::size_t k = 0; k < N; ++k)
        good = good && bounds[k].magnitude() <= largest_growth * size[k] + std::numeric_limits<double>::min();
    if (!good && may_halve) return integrate_halves();
    for (std::size_t k = 0; k < N; ++k) {
        double truncation = 2 * quadrature::truncation * bounds[k].magnitude();
        // Where halving ended without a bound, what is known of the whole part.
        if (!good) {
            truncation = 2 * size[k];
            if constexpr (requires { integrand.range(span); }) {
                const std::array<double, 2> range = integrand.range(span);
                truncation = std::max({0.0, value[k] - range[0], range[1] - value[k]});
            }
        }
        sum[k] += {value[k], truncation + term_rounding * size[k]};
    }
}

template <std::size_t N, class Integrand>
void integrate(const PowerSpan& span, const Integrand& integrand, std::array<Integral, N>& sum) {
    int budget = quadrature::most_halvings;
    integrate(span, integrand, sum, 40, budget);
}

struct LengthIntegrand {
    template <class T>
    std::array<T, 1> operator()(const SpanPoint<T>& p) const {
        return {sqrt(p.x1 * p.x1 + p.y1 * p.y1 + p.z1 * p.z1)};
    }
    std::array<double, 1> sizes(const SpanPoint<double>& p) const { return (*this)(p); }
    static std::array<double, 2> range(const PowerSpan& span) { return span.length_range(); }
};

/// The length of a span, with its proven bound.
inline Integral length(const PowerSpan& span) {
    std::array<Integral, 1> sum{};
    integrate(span, LengthIntegrand{}, sum);
    return sum[0];
}

/// What integrate() adds, for integrands that are dear or cannot be bounded: with seven points, and their
/// difference from three of them, at which sizes are taken, too; or with fifteen, and their difference from
/// the seven. Error: not proven. As the rules converge geometrically, and each has about twice the degree of
/// the one before, ten times the square of the difference, as parts of the integrand's absolute value: sizes
/// grow with the condition and tell nothing of how fast rules converge. The difference is that of the first
/// coefficient of even degree that the coarser rule misses. Where poles lie aside of the middle coefficients
/// go up and down, so that it may be next to nothing: then the fifth one counts, and of fifteen points what
/// seven were estimated to leave out. Halved until the estimate is at most `largest_rest` of the size.
/// integrand(p, sizes) gives the values at p, and puts down their sizes where it is given room for them.
/// Where integrand.is_rough(span) says that it may not be analytic, no rule converges geometrically: the
/// estimate is ten times the difference itself.
template <std::size_t N, class Integrand>
void integrate_estimated(const PowerSpan& span, const Integrand& integrand, double largest_rest,
                         std::array<Integral, N>& sum, int halvings, int& budget) {
    using Node = quadrature::NestedRule::Node;
    constexpr quadrature::NestedRule rule;
    std::array<double, N> fine{}, coarse{}, all{}, size{}, absolute{}, fifth{}, rest{};
    const auto add_first = [&](double t, const Node& node) {
        std::array<double, N> s;
        const std::array<double, N> f = integrand(span.at(t), node.gauss != 0 ? &s : nullptr);
        const double of_fifth = t < 0 ? -node.fifth : node.fifth;
        for (std::size_t k = 0; k < N; ++k) {
            fine[k] += node.seven * f[k];
            absolute[k] += node.seven * std::abs(f[k]);
            fifth[k] += of_fifth * f[k];
            all[k] += node.weight * f[k];
        }
        if (node.gauss == 0) return;
        for (std::size_t k = 0; k < N; ++k) {
            coarse[k] += node.gauss * f[k];
            size[k] += node.gauss * s[k];
        }
    };
    bool is_rough = false;
    if constexpr (requires { integrand.is_rough(span); }) is_rough = integrand.is_rough(span);
    // A difference is a part of the absolute value, and all of it where that vanishes among the smallest
    // numbers.
    const auto part = [&](double a, std::size_t k) {
        return a < absolute[k] && !is_rough ? a / absolute[k] : 1.0;
    };
    const auto is_good = [&] {
        bool is = true;
        for (std::size_t k = 0; k < N; ++k) is = is && 10 * rest[k] <= largest_rest * size[k];
        return is;
    };
    add_first(0, rule.center);
    for (const Node& node : rule.first)
        for (const double t : {-node.x, node.x}) add_first(t, node);
    for (std::size_t k = 0; k < N; ++k) {
        const double difference = std::abs(fine[k] - coarse[k]), c5 = std::abs(fifth[k]);
        rest[k] = difference * part(difference, k);
        if (!(c5 > difference)) continue;
        // Coefficients that fall evenly from the absolute value on have c_6^2 = c_5^2 (c_5 / c_0)^(2/5),
        // which the power 3/8 is above.
        const double root = std::sqrt(std::sqrt(part(c5, k)));
        rest[k] = std::max(rest[k], c5 * part(c5, k) * root * std::sqrt(root));
    }
    bool good = is_good();
    if (!good) {
        for (const Node& node : rule.rest)
            for (const double t : {-node.x, node.x}) {
                const std::array<double, N> f = integrand(span.at(t), nullptr);
                for (std::size_t k = 0; k < N; ++k) all[k] += node.weight * f[k];
            }
        coarse = std::exchange(fine, all);
        for (std::size_t k = 0; k < N; ++k) {
            const double most = std::max(std::abs(fine[k] - coarse[k]), rest[k]);
            rest[k] = most * part(most, k);
        }
        good = is_good();
    }
    if (!good && halvings > 0 && budget > 0) {
        --budget;
        for (const int side : {0, 1})
            integrate_estimated(span.half(side), integrand, largest_rest, sum, halvings - 1, budget);
        return;
    }
    for (std::size_t k = 0; k < N; ++k) {
        const double truncation = good ? 10 * rest[k] : std::max(10 * rest[k], std::abs(fine[k] - coarse[k]));
        sum[k] += {fine[k], truncation + term_rounding * size[k]};
    }
}

template <std::size_t N, class Integrand>
void integrate_estimated(const PowerSpan& span, const Integrand& integrand, double largest_rest,
                         std::array<Integral, N>& sum) {
    // Towards each of a few sharp turns; where a span has no smooth part more are no better.
    int budget = 64;
    integrate_estimated(span, integrand, largest_rest, sum, 12, budget);
}

}  // namespace span_integrals

}  // namespace vcell
