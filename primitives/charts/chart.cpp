#include "chart.hpp"

namespace vcell {

Vec3 BaseChart::normal(const Vec2& p) const {
    if (is_plane()) return Vec3::UnitZ();
    if (is_sphere()) {
        const double r2 = p.squaredNorm();
        if (r2 <= 1) return turn * Vec3(2 * p.x(), 2 * p.y(), 1 - r2) / (1 + r2);
        const Vec2 q = p / r2;
        const double s2 = q.squaredNorm();
        return turn * Vec3(2 * q.x(), 2 * q.y(), s2 - 1) / (1 + s2);
    }
    const bool back = is_back(p.x());
    const double x = back ? p.x() - 2 : p.x(), w = back ? -(1 + x * x) : 1 + x * x;
    return turn * Vec3(2 * x / w, 0, (1 - x * x) / w);
}

Vec3 BaseChart::normal_derivative(const Vec2& p, const Vec2& d) const {
    if (is_plane()) return Vec3::Zero();
    if (is_cylinder()) {
        const bool back = is_back(p.x());
        const double a = back ? p.x() - 2 : p.x(), W = 1 + a * a;
        return (back ? -2 : 2) * d.x() / (W * W) * (turn * Vec3(1 - a * a, 0, -2 * a));
    }
    const double W = 1 + p.squaredNorm(), dW = 2 * p.dot(d);
    const Vec3 n(2 * p.x(), 2 * p.y(), 1 - p.squaredNorm());
    return turn * (Vec3(2 * d.x(), 2 * d.y(), -dW) / W - n * (dW / (W * W)));
}

Vec2 BaseChart::chart_point(const Vec3& normal, double y) const {
    const Vec3 v = turn.transpose() * normal;
    if (is_sphere()) {
        if (v.z() >= 0) return v.head<2>() / (1 + v.z());
        return v.head<2>() * (1 - v.z()) / v.head<2>().squaredNorm();
    }
    // The tangent of half the angle about (0, 0, 1) or (0, 0, -1) of the chart; (-1, 0, 0) is x = -1, not 3.
    const double s = v.x(), c = v.z();
    const double x = c >= 0 ? s / (1 + c) : 2 - s / (1 - c);
    return {x < 3 ? x : -1, y};
}

double BaseChart::distance_of(const Vec2& p, double f) const {
    if (is_plane()) return f;
    const double x = is_back(p.x()) ? p.x() - 2 : p.x();
    return (1 + x * x + (is_sphere() ? p.y() * p.y() : 0.0)) / -f;
}

}  // namespace vcell
