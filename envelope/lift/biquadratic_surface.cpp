#include "biquadratic_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "joined_spans.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;
using Polynomial = std::array<double, 3>;

// Control points are means by weights: some ten operations each, coefficients within a few u.
constexpr double rounding_each = 16 * std::numeric_limits<double>::epsilon();

}  // namespace

void BiquadraticSurface::add(const Polynomial& f, const Polynomial& g, const Vector4d& h) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) coefficients_[3 * i + j] += f[i] * g[j] * h;
}

namespace {

// Blossoms: x -> (x + x') / 2, x^2 -> x x'.
template <int n>
Polynomial blossom(const std::array<double, 2>& range, int i) {
    const double a = range[n == 1 ? i : i > 1], b = range[n == 1 ? i : i > 0];
    return {1, 0.5 * a + 0.5 * b, a * b};
}

// BiquadraticSurface::for_each_control() of degrees m and n, or of a total degree. Coefficients beyond are
// zero.
template <int m, int n, bool is_total, class Use>
void for_each_control_of(const BiquadraticSurface& from, const std::array<double, 2>& u,
                         const std::array<double, 2>& v, Use& use) {
    std::array<Polynomial, m + 1> f;
    for (int i = 0; i <= m; ++i) f[i] = blossom<m>(u, i);
    for (int j = 0; j <= n; ++j) {
        const Polynomial g = blossom<n>(v, j);
        std::array<Vector4d, m + 1> row, size_of_row;
        for (int k = 0; k <= m; ++k) {
            row[k] = from.coefficient(k, 0);
            size_of_row[k] = row[k].cwiseAbs();
            for (int l = 1; l <= (is_total ? n - k : n); ++l) {
                const Vector4d term = g[l] * from.coefficient(k, l);
                row[k] += term;
                size_of_row[k] += term.cwiseAbs();
            }
        }
        for (int i = 0; i <= m; ++i) {
            Vector4d h = row[0], size = size_of_row[0];
            for (int k = 1; k <= m; ++k) {
                h += f[i][k] * row[k];
                size += std::abs(f[i][k]) * size_of_row[k];
            }
            if (!use(i * (n + 1) + j, h, size)) return;
        }
    }
}

}  // namespace

template <class Use>
void BiquadraticSurface::for_each_control(const std::array<double, 2>& u, const std::array<double, 2>& v,
                                          Use use) const {
    if (degree_[0] == 1)
        return terms_ == Terms::Total ? for_each_control_of<1, 1, true>(*this, u, v, use)
                                      : for_each_control_of<1, 1, false>(*this, u, v, use);
    if (degree_[1] == 1) return for_each_control_of<2, 1, false>(*this, u, v, use);
    if (terms_ == Terms::Total) return for_each_control_of<2, 2, true>(*this, u, v, use);
    for_each_control_of<2, 2, false>(*this, u, v, use);
}

namespace {

// Control points (P, w) with the sums of their terms' absolute values.
struct ControlNet {
    int m, n;
    std::vector<Vector4d> h, size;

    // The net of the same surface with both degrees one more, which may bring its weights above 0.
    ControlNet raised() const {
        ControlNet r{m + 1, n + 1, {}, {}};
        const auto along_v = [this](const std::vector<Vector4d>& c, int i, int j) -> Vector4d {
            const double share = static_cast<double>(j) / (n + 1);
            Vector4d sum = Vector4d::Zero();
            if (j > 0) sum += share * c[i * (n + 1) + j - 1];
            if (j <= n) sum += (1 - share) * c[i * (n + 1) + j];
            return sum;
        };
        for (int i = 0; i <= m + 1; ++i)
            for (int j = 0; j <= n + 1; ++j) {
                const double share = static_cast<double>(i) / (m + 1);
                for (const auto& [from, to] : {std::pair(&h, &r.h), std::pair(&size, &r.size)}) {
                    Vector4d sum = Vector4d::Zero();
                    if (i > 0) sum += share * along_v(*from, i - 1, j);
                    if (i <= m) sum += (1 - share) * along_v(*from, i, j);
                    to->push_back(sum);
                }
            }
        return r;
    }
    // Is each weight above such a part of what its terms come to?
    bool has_weights_above(double part) const {
        for (std::size_t k = 0; k < h.size(); ++k)
            if (!(h[k].w() > part * size[k].w())) return false;
        return true;
    }
};

// A spheroid's weights are positive all over, but those of its control points over a wide rectangle in higher
// degrees only: of degree n they are above that of the middle of 1 + u^2 + v^2 less (u^2 + v^2) / (n - 1).
// Those of bisectors with tubes and cones seen from within are positive all around, and need it where faces
// reach far around. CAD programs read degrees up to 25.
constexpr int most_raised = 24;
// Spheroids' weights that cancel to a smaller part than this lose digits that a higher degree keeps.
constexpr double least_part = 0x1p-6;
// Raising takes four roundings each time, and there are 22 at most.
constexpr double rounding_of_raised = 7 * rounding_each;

}  // namespace

std::optional<RationalPatch> BiquadraticSurface::raised_patch(const std::array<double, 2>& u,
                                                              const std::array<double, 2>& v,
                                                              const BaseFrame& frame,
                                                              double& rounding) const {
    ControlNet net{degree_[0], degree_[1], {}, {}};
    const auto count = static_cast<std::size_t>((degree_[0] + 1) * (degree_[1] + 1));
    net.h.resize(count);
    net.size.resize(count);
    for_each_control(u, v, [&](int k, const Vector4d& h, const Vector4d& size) {
        net.h[k] = h;
        net.size[k] = size;
        return true;
    });
    const double least = extent_ == Extent::Closed ? least_part : 0;
    while (net.m < most_raised && !net.has_weights_above(least)) net = net.raised();
    if (!net.has_weights_above(0)) return std::nullopt;
    std::optional<RationalPatch> surface(RationalPatch{net.m, net.n, u, v, {}});
    double of_points = 0, of_weights = 0, far = 0;
    for (std::size_t k = 0; k < net.h.size(); ++k) {
        const Vector4d &h = net.h[k], &size = net.size[k];
        const Vec3 p = h.head<3>() / h.w(), world = frame.to_world(p);
        surface->points.push_back({world.x(), world.y(), world.z(), h.w() / net.h[0].w()});
        of_points = std::max(of_points, (size[0] + size[1] + size[2]) / h.w());
        of_weights = std::max(of_weights, size[3] / h.w());
        far = std::max(far, p.cwiseAbs().sum());
    }
    rounding = rounding_of_raised * (of_points + far * of_weights + frame.origin.norm());
    return surface;
}

std::optional<RationalPatch> BiquadraticSurface::patch(const std::array<double, 2>& u,
                                                       const std::array<double, 2>& v, const BaseFrame& frame,
                                                       double& rounding) const {
    std::optional<RationalPatch> surface(RationalPatch{degree_[0], degree_[1], u, v, {}});
    surface->points.resize(static_cast<std::size_t>((degree_[0] + 1) * (degree_[1] + 1)));
    // The largest sums of the terms' absolute values over the weight: of a point's coordinates, and of its
    // weight.
    double scale = 1, of_points = 0, of_weights = 0, far = 0;
    const double least = extent_ == Extent::Closed ? least_part : 0;
    bool is_positive = true;
    for_each_control(u, v, [&](int k, const Vector4d& h, const Vector4d& size) {
        is_positive = h.w() > least * size.w();
        if (!is_positive) return false;
        const double over_w = 1 / h.w();
        if (k == 0) scale = over_w;
        const Vec3 p = h.head<3>() / h.w(), world = frame.to_world(p);
        surface->points[k] = {world.x(), world.y(), world.z(), scale * h.w()};
        of_points = std::max(of_points, (size[0] + size[1] + size[2]) * over_w);
        of_weights = std::max(of_weights, size[3] * over_w);
        far = std::max(far, std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
        return true;
    });
    rounding = rounding_each * (of_points + far * of_weights + frame.origin.norm());
    if (!is_positive) surface.reset();
    if (!is_positive && extent_ != Extent::Open) return raised_patch(u, v, frame, rounding);
    return surface;
}

bool BiquadraticSurface::has_positive_net(const std::array<double, 2>& u,
                                          const std::array<double, 2>& v) const {
    bool is_positive = true;
    for_each_control(u, v, [&](int, const Vector4d& h, const Vector4d&) {
        is_positive = h.w() > 0;
        return is_positive;
    });
    return is_positive;
}

// Control points P_ij that are off by a_ij, and weights by r_ij of themselves, turn S = sum B_ij w_ij P_ij /
// sum B_ij w_ij off by no more than sum B_ij w_ij (a_ij + r_ij |P_ij - S|) / sum B_ij w_ij. In terms of h and
// size, with |S| <= sum B_ij |h_ij| / sum B_ij w_ij, these are quotients of functions in Bernstein form with
// coefficients that are not negative: over a part of the rectangle each is no more than the greatest quotient
// of the coefficients there.
double BiquadraticSurface::rounding_along(const RationalCurve2& curve, const std::array<double, 2>& u,
                                          const std::array<double, 2>& v, const BaseFrame& frame,
                                          double enough) const {
    if (extent_ == Extent::Closed || (extent_ == Extent::Around && !has_positive_net(u, v))) {
        double rounding = 0;
        patch(u, v, frame, rounding);
        return rounding;
    }
    // Each control point's sums of terms for points and weights, |h| and w.
    std::array<Vector4d, 9> net;
    for_each_control(u, v, [&](int k, const Vector4d& h, const Vector4d& size) {
        const double length = h.head<3>().cwiseAbs().sum();
        net[k] << size.head<3>().sum() + length / h.w() * size.w(), size.w(), length, h.w();
        return true;
    });
    const auto [m, n] = degree_;
    const std::array domains{u, v};
    using Rectangle = std::array<Range, 2>;  // each side from 0 to 1
    const auto over = [&](const Rectangle& part) {
        // The blossom of the three or two coefficients c(0), ... in one variable.
        const auto blossom = [](int degree, const Range& range, int i, const auto& c) -> Vector4d {
            if (degree == 1) return (1 - range[i]) * c(0) + range[i] * c(1);
            const double a = range[i > 1], b = range[i > 0];
            return (1 - a) * (1 - b) * c(0) + ((1 - a) * b + a * (1 - b)) * c(1) + a * b * c(2);
        };
        double of_points = 0, of_weights = 0, far = 0;
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j) {
                const auto row = [&](int k) {
                    return blossom(n, part[1], j, [&](int l) { return net[k * (n + 1) + l]; });
                };
                const Vector4d sum = blossom(m, part[0], i, row);
                of_points = std::max(of_points, sum[0] / sum[3]);
                of_weights = std::max(of_weights, sum[1] / sum[3]);
                far = std::max(far, sum[2] / sum[3]);
            }
        return rounding_each * (of_points + far * of_weights + frame.origin.norm());
    };
    // Around the first `count` of the control points (u w, v w, w). Those of other weights tell nothing.
    using Piece = std::array<Eigen::Vector3d, 6>;
    const auto part_around = [&](const Piece& piece, int count) {
        Rectangle part{{{0, 1}, {0, 1}}};
        for (int k = 0; k < count; ++k)
            if (!(piece[k].z() > 0)) return part;
        for (int axis = 0; axis < 2; ++axis) {
            const auto [first, last] = domains[axis];
            Range range = empty_range;
            for (int k = 0; k < count; ++k) {
                const double x = (piece[k][axis] / piece[k].z() - first) / (last - first);
                range = {std::min(range[0], x), std::max(range[1], x)};
            }
            const double off = 8 * std::numeric_limits<double>::epsilon() *
                               std::max(std::abs(first), std::abs(last)) / (last - first);
            part[axis] = {std::clamp(range[0] - off, 0.0, 1.0), std::clamp(range[1] + off, 0.0, 1.0)};
        }
        return part;
    };
    constexpr int most_halvings = 20;
    const int degree = curve.degree;
    const auto along = [&](const auto& self, Piece piece, int halvings) -> double {
        const double bound = over(part_around(piece, degree + 1));
        const bool is_worth_while = bound > enough && bound > 2 * over(part_around(piece, 1));
        if (!is_worth_while || halvings == most_halvings) return bound;
        Piece left;
        for (int level = 0; level <= degree; ++level) {
            left[level] = piece[0];
            for (int k = 0; k < degree - level; ++k) piece[k] = 0.5 * (piece[k] + piece[k + 1]);
        }
        return std::max(self(self, left, halvings + 1), self(self, piece, halvings + 1));
    };
    double most = 0;
    for (std::size_t first = 0; first + 1 < curve.points.size(); first += degree) {
        Piece piece;
        for (int k = 0; k <= degree; ++k) {
            const Eigen::Vector3d& p = curve.points[first + k];
            piece[k] << p.head<2>() * p.z(), p.z();
        }
        most = std::max(most, along(along, piece, 0));
    }
    return most;
}

}  // namespace vcell
