#include "mesh_shape.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "trims.hpp"

namespace vcell {

static double distance_from_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 way = b - a;
    const double square = way.squaredNorm(),
                 part = square > 0 ? std::clamp((p - a).dot(way) / square, 0.0, 1.0) : 0.0;
    return (p - a - part * way).norm();
}

double deviation(const RationalCurve3& curve, double from, double to) {
    const Vec3 a = curve.evaluate(from), b = curve.evaluate(to), way = b - a;
    const auto at = [&](double s) { return curve.evaluate((1 - s) * from + s * to); };
    const Vec3 middle = at(0.5);
    double most = distance_from_segment(middle, a, b);
    const double along = (middle - a).dot(way) - 0.5 * way.squaredNorm();
    if (!(std::abs(along) <= 0.25 * way.squaredNorm()))
        for (const double s : {0.25, 0.75}) most = std::max(most, distance_from_segment(at(s), a, b));
    return most;
}

double deviation(const RationalPatch& s, const Vec2& a, const Vec2& b) {
    const Vec3 from = s.evaluate(a.x(), a.y()), to = s.evaluate(b.x(), b.y()), way = to - from;
    const auto height = [&](double t, Vec3& p) {
        const Vec2 uv = (1 - t) * a + t * b;
        p = s.evaluate(uv.x(), uv.y());
        const auto [du, dv] = s.partials(uv.x(), uv.y());
        const Vec3 normal = du.cross(dv).stableNormalized();
        const double square = way.squaredNorm(),
                     part = square > 0 ? std::clamp((p - from).dot(way) / square, 0.0, 1.0) : 0.0;
        const Vec3 off = p - from - part * way;
        return normal.isZero(0) ? off.norm() : std::abs(normal.dot(off));
    };
    Vec3 p;
    double most = height(0.5, p);
    if (!((p - 0.5 * (from + to)).squaredNorm() <= 0.0625 * way.squaredNorm()))
        for (const double t : {0.25, 0.75}) most = std::max(most, height(t, p));
    return most;
}

// Does a curve from at(0) to at(1) leave its chord as strays() asks? Three places tell.
template <class At>
static bool strays(const At& at, double chord) {
    const Vec3 from = at(0.0), to = at(1.0);
    constexpr double of_length = 0.125;
    const double allowed = std::max(chord, of_length * (to - from).norm());
    const auto is_off = [&](double t) { return distance_from_segment(at(t), from, to) > allowed; };
    return is_off(0.5) || is_off(0.25) || is_off(0.75);
}

bool strays(const RationalPatch& s, const Vec2& a, const Vec2& b, double chord) {
    return strays(
        [&](double t) {
            const Vec2 uv = (1 - t) * a + t * b;
            return s.evaluate(uv.x(), uv.y());
        },
        chord);
}

bool strays(const RationalPatch& s, const RationalCurve2& curve, double from, double to, double chord) {
    return strays(
        [&](double t) {
            const Vec2 uv = curve.evaluate((1 - t) * from + t * to);
            return s.evaluate(uv.x(), uv.y());
        },
        chord);
}

bool leaves_strip(const RationalPatch& s, const RationalCurve2& seam, double from, double to) {
    const int across = is_at_one(seam, 0) ? 0 : 1;
    if (!is_at_one(seam, across)) return false;
    const auto place = [&](const Vec2& uv) { return s.evaluate(uv.x(), uv.y()); };
    const Vec3 begin = place(seam.evaluate(from)), end = place(seam.evaluate(to));
    const auto leaves = [&](double t) {
        const Vec2 uv = seam.evaluate((1 - t) * from + t * to);
        Vec2 beyond = uv;
        const auto& [low, high] = across == 0 ? s.domain_u : s.domain_v;
        beyond[across] = uv[across] < 0.5 * (low + high) ? high : low;
        const Vec3 p = place(uv);
        return distance_from_segment(p, begin, end) > 0.5 * (place(beyond) - p).norm();
    };
    return leaves(0.5) || leaves(0.25) || leaves(0.75);
}

Eigen::Matrix2d rounding_map(const RationalPatch& s, const std::vector<std::vector<Vec2>>& loops) {
    Eigen::Matrix2d mean = Eigen::Matrix2d::Zero();
    for (const auto& loop : loops)
        for (const Vec2& p : loop) {
            const auto [du, dv] = s.partials(p.x(), p.y());
            Eigen::Matrix2d metric;
            metric << du.dot(du), du.dot(dv), du.dot(dv), dv.dot(dv);
            const double determinant = metric.determinant();
            if (determinant > 0x1p-40 * metric.squaredNorm()) mean += metric / std::sqrt(determinant);
        }
    constexpr double least = 1.5;  // of lengths
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> squares;
    squares.computeDirect(mean);  // in closed form, which takes a sixth of the time to compile
    const Vec2 values = squares.eigenvalues();
    if (!(values[0] > 0 && values[1] > least * least * values[0])) return Eigen::Matrix2d::Identity();
    const Vec2 stretches(1, std::sqrt(values[1] / values[0]));
    return squares.eigenvectors() * stretches.asDiagonal() * squares.eigenvectors().transpose();
}

}  // namespace vcell
