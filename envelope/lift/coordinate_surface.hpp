/// Rational surfaces whose parameters are functions in space: what a bisector's patch is inverted by.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "biquadratic_surface.hpp"
#include "patch_coordinate.hpp"

namespace vcell {

class CoordinateSurface : public BiquadraticSurface {
public:
    /// As radial_patch.hpp has them.
    enum class Kind : std::uint8_t { Planar, Graph, Stereographic, Confocal, AboutObject, AboutBase };

    Kind kind() const { return kind_; }
    /// parameters() from axes and origin: with q = p - origin() and its components (x, y, z) along the axes,
    /// (u, v) is (x, y) on Planar and Graph, (x, y) / (|q| + z) on Stereographic, (|q| + z, y) on Confocal;
    /// on AboutObject and AboutBase u = y / (|(x, y)| + x), and v is linear in p and, of vessels, in |(x,
    /// y)|.
    const std::array<Vec3, 3>& axes() const { return axes_; }
    const Vec3& origin() const { return origin_; }
    /// What v is per length, on AboutObject and AboutBase.
    const Vec3& along() const { return along_; }

    /// The parameters of a point of the bisector, in any number type with sqrt(); on
    /// Stereographic a function of the point's direction from the centre alone.
    /// u of AboutObject and AboutBase is singular at the pole, half a turn away from 0.
    template <class T>
    std::array<T, 2> parameters(const std::array<T, 3>& p) const;
    Vec2 parameters(const Vec3& p) const {
        const auto [u, v] = parameters<double>({p.x(), p.y(), p.z()});
        return {u, v};
    }

    /// The parameters in space. But on AboutObject and AboutBase both have one divisor, and along rational
    /// curves (p, t) degree and weights of these.
    const PatchCoordinates& coordinates() const { return coordinates_; }
    /// (u w, v w, w) there, of a point times its weight; some w > 0.
    Eigen::Vector3d projected(const Eigen::Vector4d& x, double weight) const {
        const auto& [u, v] = coordinates_;
        return {PatchCoordinate::value(u.numerator, x, weight),
                PatchCoordinate::value(v.numerator, x, weight), PatchCoordinate::value(u.divisor, x, weight)};
    }

protected:
    void set_axes(Kind kind, const Vec3& x, const Vec3& y, const Vec3& origin);
    /// v is linear as along_, along_start_ and along_across_ have it.
    void set_coordinates(const PatchCoordinate& u);

    Kind kind_ = Kind::Planar;
    // The inverse has axes and where they start; v = along_.p + along_start_ where it is a length along an
    // axis, and along_across_ of the distance from it more along or in a cone.
    std::array<Vec3, 3> axes_{};
    Vec3 origin_ = Vec3::Zero(), along_ = Vec3::Zero();
    double along_start_ = 0, along_across_ = 0;
    PatchCoordinates coordinates_;
};

template <class T>
std::array<T, 2> CoordinateSurface::parameters(const std::array<T, 3>& p) const {
    using std::sqrt;
    const auto along = [](const Vec3& axis, const T& x, const T& y, const T& z) {
        return T(axis.x()) * x + T(axis.y()) * y + T(axis.z()) * z;
    };
    const T qx = p[0] - T(origin_.x()), qy = p[1] - T(origin_.y()), qz = p[2] - T(origin_.z());
    const T x = along(axes_[0], qx, qy, qz), y = along(axes_[1], qx, qy, qz);
    if (kind_ == Kind::Planar || kind_ == Kind::Graph) return {x, y};
    if (kind_ == Kind::Stereographic) {
        const T reach = sqrt(qx * qx + qy * qy + qz * qz) + along(axes_[2], qx, qy, qz);
        return {x / reach, y / reach};
    }
    if (kind_ == Kind::Confocal) {
        // Towards the focal direction the sum cancels.
        const T z = along(axes_[2], qx, qy, qz), length = sqrt(qx * qx + qy * qy + qz * qz);
        if (z > T(0.0)) return {length + z, y};
        return {(x * x + y * y) / (length - z), y};
    }
    const T wide = sqrt(x * x + y * y);
    return {y / (wide + x), along(along_, p[0], p[1], p[2]) + T(along_start_) + T(along_across_) * wide};
}

}  // namespace vcell
