#include "sphere_net.hpp"

#include <algorithm>
#include <cmath>

namespace vcell::check {

std::optional<SphereNet> SphereNet::of(const Net& net) {
    if (net.degree_s() > kMost || net.degree_t() > kMost) return std::nullopt;
    const SphereNet result(net);
    return result.least_weight_ > 0 ? std::optional(result) : std::nullopt;
}

SphereNet::SphereNet(const Net& net) : m_(net.degree_s()), n_(net.degree_t()), origin_(net.origin()) {
    least_weight_ = HUGE_VAL;
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            const Net::Point& p = net.at(i, j);
            points_.push_back({p[0].mid(), p[1].mid(), p[2].mid(), p[3].mid(), 0});
            position_error_ = std::max({position_error_, p[0].radius(), p[1].radius(), p[2].radius()});
            weight_error_ = std::max(weight_error_, p[3].radius());
            least_weight_ = std::min(least_weight_, p[3].mid());
            most_weight_ = std::max(most_weight_, p[3].mid());
        }
    least_weight_ = (least_weight_ - weight_error_) * kBelow;
    affine_.resize((points_.size() - 1) / Lanes::lanes + 1);
    most_place_ = {divide_by_weights([](const Point& p) { return p.x; }, &Affine::x),
                   divide_by_weights([](const Point& p) { return p.y; }, &Affine::y),
                   divide_by_weights([](const Point& p) { return p.z; }, &Affine::z)};
}

void SphereNet::solve_for_radii(const Linear& f) {
    set_radii(
        [&](const Point& p) { return (f.k * p.w + f.g.x() * p.x + f.g.y() * p.y + f.g.z() * p.z) / -f.h; });
}

bool SphereNet::settle(double error, double sag) {
    clearance_error_ = error;
    sag_ = sag;
    most_clearance_ = divide_by_weights([](const Point& p) { return p.t; }, &Affine::t);
    return range({0, 0, Vec3::Zero(), 1}).magnitude() < HUGE_VAL;
}

/// |p - c|^2 - |p - c'|^2 = (c - c') (c + c' - 2 p), and (t + rho)^2 - (t + rho')^2 = (rho - rho') (rho +
/// rho' + 2 t).
SphereNet::Linear SphereNet::difference(const Sphere& ball, const Vec3& center, double radius) const {
    const Vec3 way = ball.center - center, here = ball.center - origin_, there = center - origin_;
    const double delta = ball.radius - radius;
    return {way.dot(here + there) - delta * (ball.radius + radius),
            kFew * (sum_of_magnitudes(way) * (sum_of_magnitudes(here) + sum_of_magnitudes(there)) +
                    std::abs(delta) * (ball.radius + radius)),
            -2 * way, -2 * delta};
}

/// A quotient of polynomials lies between those of their Bernstein coefficients, which go through a quotient,
/// a product and four sums.
Interval SphereNet::range(const Linear& f) const {
    const double size = std::abs(f.k) + std::abs(f.g.x()) * most_place_.x() +
                        std::abs(f.g.y()) * most_place_.y() + std::abs(f.g.z()) * most_place_.z() +
                        std::abs(f.h) * most_clearance_;
    const double blur = std::abs(f.k) * weight_error_ + sum_of_magnitudes(f.g) * position_error_;
    // The weight's own error counts with the quotient.
    const double off = (size * (2 * kFew + weight_error_ / least_weight_) + f.error + blur / least_weight_ +
                        std::abs(f.h) * clearance_error_) *
                       kAbove;
    if (!(off < HUGE_VAL)) return Interval::whole();
    const auto value = [&](const Affine& p) {
        return ((f.k + f.g.x() * p.x) + (f.g.y() * p.y + f.g.z() * p.z)) + f.h * p.t;
    };
    Lanes lo = value(affine_[0]), hi = lo;
    for (std::size_t i = 1; i < affine_.size(); ++i) {
        const Lanes v = value(affine_[i]);
        lo = min(lo, v);
        hi = max(hi, v);
    }
    const double sag = f.h * sag_;
    return {Interval::down(lo.least() - (off + std::max(sag, 0.0))),
            Interval::up(hi.greatest() + (off - std::min(sag, 0.0)))};
}

/// Returns the largest magnitude, infinite where one is not a number.
template <class Coordinate>
double SphereNet::divide_by_weights(Coordinate coordinate, Lanes Affine::*quotient) {
    const std::size_t last = points_.size() - 1;
    double most = 0;
    for (std::size_t k = 0; k < affine_.size(); ++k)
        affine_[k].*quotient = Lanes::of([&](std::size_t lane) {
            const Point& p = points_[std::min(k * Lanes::lanes + lane, last)];
            const double x = coordinate(p) / p.w, size = std::abs(x);
            if (!(size <= most)) most = size < HUGE_VAL ? size : HUGE_VAL;
            return x;
        });
    return most;
}

std::optional<double> SphereNet::largest_square(const Vec3& center, double radius) const {
    const double bound = largest_numerator(center, radius) / (least_weight_ * least_weight_) * kAbove;
    return bound < HUGE_VAL ? std::optional(bound) : std::nullopt;
}

/// Bernstein coefficients of a product of polynomials are means of products: the largest magnitudes multiply,
/// and bounds on errors with them (forms.hpp).
double SphereNet::largest_numerator(const Vec3& center, double radius) const {
    constexpr std::size_t most = (kMost + 1) * (kMost + 1),
                          most_of_square = (2 * kMost + 1) * (2 * kMost + 1);
    std::array<double, most> scaled{};
    std::array<double, most_of_square> sum;
    const std::size_t count = points_.size(),
                      count_of_square = static_cast<std::size_t>((2 * m_ + 1) * (2 * n_ + 1));
    std::fill_n(sum.begin(), count_of_square, 0.0);
    const Vec3 from = origin_ - center;
    double size = 0, error = 0;
    const auto m = static_cast<std::size_t>(m_), n = static_cast<std::size_t>(n_);
    const auto& factors = products_of_binomials.of[m][n];
    const auto& divisors = products_of_square.of[2 * m][2 * n];
    const auto add = [&](double sign, auto coordinate, double own_error) {
        double largest = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const double x = coordinate(points_[i]);
            largest = std::max(largest, std::abs(x));
            scaled[i] = x * factors[i];
        }
        size += largest * largest;
        error += own_error * (2 * largest + own_error);
        add_square(m_, n_, sign, scaled.data(), sum.data());
    };
    double most_clearance = 0, most_position = 0;
    for (const Point& p : points_) {
        most_clearance = std::max(most_clearance, std::abs(p.t));
        most_position = std::max({most_position, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    const double reach = from.cwiseAbs().maxCoeff();
    const double position_error =
        position_error_ + reach * weight_error_ + 0x1p-51 * (most_position + 2 * reach * most_weight_);
    add(
        1, [&](const Point& p) { return p.x + from.x() * p.w; }, position_error);
    add(
        1, [&](const Point& p) { return p.y + from.y() * p.w; }, position_error);
    add(
        1, [&](const Point& p) { return p.z + from.z() * p.w; }, position_error);
    add(
        -1, [&](const Point& p) { return p.t + radius * p.w; },
        radius * weight_error_ + 0x1p-52 * (most_clearance + 2 * radius * most_weight_));
    double largest = 0;
    for (std::size_t i = 0; i < count_of_square; ++i) {
        const double x = std::abs(sum[i]) / divisors[i];
        if (!(x <= largest)) largest = x;
    }
    const double rounding = 0x1p-53 * static_cast<double>(4 * count + 16);
    return (largest + error + rounding * size) * kAbove;
}

SphereNet::Sums SphereNet::weighted_sums(double radius) const {
    Coefficients c;
    double largest = 0, most = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const Point& p = points_[i];
        c[i] = p.t + radius * p.w;
        largest = std::max(largest, std::abs(p.t) + radius * p.w);
        most = std::max(most, c[i]);
    }
    constexpr int depth = 4;
    const double error = kFew * largest + radius * weight_error_;
    return {least_value(c, m_, n_, depth) - error, most + error};
}

/// Where t's coefficients tell little of it, as on a patch that is strongly bent, they are far below its
/// values.
SphereNet::LeastSum SphereNet::least_sum(double radius) const {
    double least = HUGE_VAL, largest = 0, at_corners = HUGE_VAL;
    for (std::size_t i = 0; i < points_.size(); ++i) {
        const double t = points_[i].t / points_[i].w;
        least = std::min(least, t + radius - kFew * (std::abs(t) + radius));
        largest = std::max(largest, std::abs(points_[i].t) + radius * points_[i].w);
    }
    const auto corner = [&](int i, int j) {
        const Point& p = points_[static_cast<std::size_t>(i * m_ * (n_ + 1) + j * n_)];
        return p.t / p.w + radius;
    };
    for (const int i : {0, 1})
        for (const int j : {0, 1}) at_corners = std::min(at_corners, corner(i, j));
    constexpr double far_below = 0.25;
    if (n_ == 0 || !(at_corners > 0) || least >= far_below * at_corners) return {least, false};
    Coefficients c;
    for (std::size_t i = 0; i < points_.size(); ++i) c[i] = points_[i].t + radius * points_[i].w;
    constexpr int depth = 4;
    const double of_product = least_value(c, m_, n_, depth) - kFew * largest;
    return {of_product > 0 ? std::max(least, of_product / most_weight_ * kBelow) : least, true};
}

/// Does it grow or fall all along one variable, or are its second derivatives in it negative?
bool SphereNet::is_weight_least_at_loops() const {
    const double error = 4 * (weight_error_ + 0x1p-52 * most_weight_);
    for (const int axis : {0, 1}) {
        const int degree = axis == 0 ? m_ : n_, lines = axis == 0 ? n_ : m_;
        const auto weight = [&](int line, int i) {
            return points_[static_cast<std::size_t>(axis == 0 ? i * (n_ + 1) + line : line * (n_ + 1) + i)].w;
        };
        bool grows = degree > 0, falls = grows, is_concave = degree > 1;
        for (int line = 0; line <= lines; ++line)
            for (int i = 1; i <= degree; ++i) {
                const double step = weight(line, i) - weight(line, i - 1);
                grows = grows && step > error;
                falls = falls && step < -error;
                if (i > 1)
                    is_concave = is_concave && step - (weight(line, i - 1) - weight(line, i - 2)) < -error;
            }
        if (grows || falls || is_concave) return true;
    }
    return false;
}

}  // namespace vcell::check
