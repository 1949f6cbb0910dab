/// Rational surfaces of degree at most two in either parameter, S(u, v) = P(u, v) / w(u, v), by their
/// coefficients; rectangles of them as Bezier patches, with bounds on what rounding moves these by.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/bases/radial_base.hpp"

namespace vcell {

class BiquadraticSurface {
public:
    std::array<int, 2> degree() const { return degree_; }

    /// (P, w) at (u, v), in any number type.
    template <class T>
    std::array<T, 4> homogeneous(const T& u, const T& v) const;
    Vec3 operator()(const Vec2& uv) const {
        const auto [x, y, z, w] = homogeneous<double>(uv.x(), uv.y());
        return Vec3(x, y, z) / w;
    }
    /// The coefficient of u^i v^j in (P, w).
    const Eigen::Vector4d& coefficient(int i, int j) const { return coefficients_[3 * i + j]; }

    /// The surface over a rectangle as a Bezier patch in world coordinates. None where a weight is not
    /// positive. One whose weights are positive all over has it in as high a degree as they need.
    /// `rounding`: bound on how far it is from that of the coefficients.
    std::optional<RationalPatch> patch(const std::array<double, 2>& u, const std::array<double, 2>& v,
                                       const BaseFrame& frame, double& rounding) const;

    /// Bounds the rounding for points on a curve in the rectangle. A control point of little weight may lie
    /// far away in a corner that no trim reaches, and moves the surface no more than by its share there. The
    /// curve is divided until the bound is below `enough`, or within a factor of two of the best that can be
    /// said.
    double rounding_along(const RationalCurve2& curve, const std::array<double, 2>& u,
                          const std::array<double, 2>& v, const BaseFrame& frame, double enough) const;

protected:
    /// Which terms u^i v^j there are: i <= m and j <= n for the degree (m, n), or i + j <= 2.
    enum class Terms : std::uint8_t { Product, Total };
    /// Where are its weights positive? Somewhere; all over; or all over a closed surface less one point.
    enum class Extent : std::uint8_t { Open, Around, Closed };

    void set_degree(int m, int n, Terms terms) {
        degree_ = {m, n};
        terms_ = terms;
    }
    void set_extent(Extent extent) { extent_ = extent; }
    /// Adds u^i v^j h.
    void add(int i, int j, const Eigen::Vector4d& h) { coefficients_[3 * i + j] += h; }
    /// Adds f(u) g(v) h with polynomials f, g.
    void add(const std::array<double, 3>& f, const std::array<double, 3>& g, const Eigen::Vector4d& h);

private:
    bool has_positive_net(const std::array<double, 2>& u, const std::array<double, 2>& v) const;
    std::optional<RationalPatch> raised_patch(const std::array<double, 2>& u, const std::array<double, 2>& v,
                                              const BaseFrame& frame, double& rounding) const;
    /// Calls use(k, h, size) for the control points h = (P, w), k as in RationalPatch, and the sums of their
    /// terms' absolute values, as long as it returns true.
    template <class Use>
    void for_each_control(const std::array<double, 2>& u, const std::array<double, 2>& v, Use use) const;

    std::array<int, 2> degree_{1, 1};
    Terms terms_ = Terms::Total;
    Extent extent_ = Extent::Open;
    std::array<Eigen::Vector4d, 9> coefficients_ = no_coefficients();

    static std::array<Eigen::Vector4d, 9> no_coefficients() {
        std::array<Eigen::Vector4d, 9> none;
        none.fill(Eigen::Vector4d::Zero());
        return none;
    }
};

template <class T>
std::array<T, 4> BiquadraticSurface::homogeneous(const T& u, const T& v) const {
    std::array<T, 4> sum;
    for (int k = 0; k < 4; ++k) {
        const auto row = [&](int i) {
            return T(coefficient(i, 0)[k]) + v * (T(coefficient(i, 1)[k]) + v * T(coefficient(i, 2)[k]));
        };
        sum[k] = row(0) + u * (row(1) + u * row(2));
    }
    return sum;
}

}  // namespace vcell
