#include "patches.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace vcell::check {

namespace {

/// Two polynomials in Bernstein form over a rectangle, which is a part of the unit square. The coefficients
/// are rows along v.
struct Map {
    Vec2 lo, size;
    std::array<int, 2> degrees;
    std::vector<Vec2> points;

    int stride(int axis) const { return axis == 0 ? degrees[1] + 1 : 1; }

    /// Value and derivative at s, in coordinates that are 0 to 1 on the rectangle.
    std::pair<Vec2, Eigen::Matrix2d> evaluate(const Vec2& s) const {
        const Bernstein u(degrees[0], s.x()), v(degrees[1], s.y());
        Vec2 value = Vec2::Zero();
        Eigen::Matrix2d derivative = Eigen::Matrix2d::Zero();
        for (int i = 0; i <= degrees[0]; ++i)
            for (int j = 0; j <= degrees[1]; ++j) {
                const Vec2& c = points[i * (degrees[1] + 1) + j];
                value += u.value[i] * v.value[j] * c;
                derivative.col(0) += u.slope[i] * v.value[j] * c;
                derivative.col(1) += u.value[i] * v.slope[j] * c;
            }
        return {value, derivative};
    }

    /// Both halves across an axis. They share their coefficients on the line between them bit by bit.
    std::array<Map, 2> halves(int axis) const {
        std::array<Map, 2> h{*this, *this};
        h[0].size[axis] = h[1].size[axis] = 0.5 * size[axis];
        h[1].lo[axis] += h[1].size[axis];
        const int n = degrees[axis], step = stride(axis), across = stride(1 - axis);
        for (int line = 0; line <= degrees[1 - axis]; ++line) {
            Vec2 *left = &h[0].points[line * across], *right = &h[1].points[line * across];
            for (int k = 0; k <= n; ++k) {
                left[k * step] = right[0];
                for (int i = 0; i < n - k; ++i)
                    right[i * step] = 0.5 * (right[i * step] + right[(i + 1) * step]);
            }
        }
        return h;
    }

    /// Has one of the polynomials no zero, being everywhere farther than `margin` from it?
    bool misses(double margin) const {
        Vec2 least = points[0], most = points[0];
        for (const Vec2& c : points) {
            least = least.cwiseMin(c);
            most = most.cwiseMax(c);
        }
        return (least.array() > margin).any() || (most.array() < -margin).any();
    }

    /// How far the derivative is from the identity at most anywhere in the rectangle, in the maximum norm.
    double deviation() const {
        Vec2 sum = Vec2::Zero();
        for (const int axis : {0, 1}) {
            const int n = degrees[axis], step = stride(axis), across = stride(1 - axis);
            Vec2 most = Vec2::Zero();
            for (int line = 0; line <= degrees[1 - axis]; ++line)
                for (int i = 0; i < n; ++i) {
                    const Vec2* c = &points[line * across + i * step];
                    most = most.cwiseMax((n * (c[step] - c[0]) - Vec2::Unit(axis)).cwiseAbs());
                }
            sum += most;
        }
        return sum.maxCoeff();
    }
};

/// The zero of a map whose derivative is near the identity, by Newton's method.
Vec2 zero(const Map& map) {
    constexpr int kSteps = 16;  // twice as many digits with each: rounding ends them
    constexpr double kLeast = 1e-14;
    Vec2 s = Vec2::Constant(0.5);
    for (int k = 0; k < kSteps; ++k) {
        const auto [value, derivative] = map.evaluate(s);
        const Vec2 step = derivative.inverse() * value;
        s -= step;
        if (step.norm() <= kLeast) break;
    }
    return s;
}

/// All zeros in the unit square, and perhaps some beside it. Rectangles are halved until their control points
/// leave no zero in them, or the map, multiplied by the inverse of its derivative at the centre, is a
/// contraction away from the identity, which has at most one zero there. None: that has taken too long.
std::optional<std::vector<Vec2>> zeros(Map whole) {
    constexpr std::size_t kMost = 4096;  // rectangles; where the map is regular it takes about five
    // A zero this far outside a rectangle, per size, belongs to the neighbour: sought nearer by, accepted
    // farther off, so that rounding loses none between the two.
    constexpr double kMargin = 1.0 / 16;
    std::vector<Vec2> result;
    std::vector<Map> stack{std::move(whole)};
    for (std::size_t count = 0; !stack.empty(); ++count) {
        if (count == kMost) return std::nullopt;
        const Map map = std::move(stack.back());
        stack.pop_back();
        const Eigen::Matrix2d inverse = map.evaluate(Vec2::Constant(0.5)).second.inverse();
        if (inverse.allFinite()) {
            Map steady = map;
            for (Vec2& c : steady.points) c = inverse * c;
            if (steady.misses(kMargin)) continue;
            if (steady.deviation() <= 0.5) {
                const Vec2 s = zero(steady);
                if ((s.array() < -2 * kMargin).any() || (s.array() > 1 + 2 * kMargin).any()) continue;
                const Vec2 place = map.lo + s.cwiseProduct(map.size);
                const auto is_same = [&](const Vec2& other) {
                    return (other - place).lpNorm<Eigen::Infinity>() <= kNearEdge;
                };
                if (std::ranges::none_of(result, is_same)) result.push_back(place);
                continue;
            }
        }
        for (Map& half : map.halves(map.size.x() >= map.size.y() ? 0 : 1))
            if (!half.misses(0)) stack.push_back(std::move(half));
    }
    return result;
}

/// The polynomial curve of the given control points from s = begin to s = end: point j is the blossom at
/// (begin, ..., begin, end, ..., end) with j times end.
std::vector<Eigen::Vector4d> part_of(const std::vector<Eigen::Vector4d>& points, double begin, double end) {
    const std::size_t n = points.size() - 1;
    std::vector<Eigen::Vector4d> result;
    for (std::size_t j = 0; j <= n; ++j) {
        std::vector<Eigen::Vector4d> level = points;
        for (std::size_t r = 1; r <= n; ++r) {
            const double s = r <= j ? end : begin;
            for (std::size_t i = 0; i + r <= n; ++i) level[i] = (1 - s) * level[i] + s * level[i + 1];
        }
        result.push_back(level[0]);
    }
    return result;
}

}  // namespace

// The angle at a place between two others.
static double turn(const Vec2& from, const Vec2& to, const Vec2& uv) {
    const Vec2 a = from - uv, b = to - uv;
    return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
}

static bool is_beside(const Vec2& lo, const Vec2& hi, const Vec2& uv, const Vec2& near) {
    return (uv.array() < (lo - near).array()).any() || (uv.array() > (hi + near).array()).any();
}

// Outside of the box of all its control points a trim turns as its chord does.
static std::optional<double> swept(const Trim& trim, const Vec2& uv, const Vec2& near) {
    if (is_beside(trim.lo, trim.hi, uv, near)) return turn(trim.first_point(), trim.last_point(), uv);
    double total = 0;
    for (const auto& piece : trim.pieces) {
        const auto angle = swept(piece, uv, near);
        if (!angle) return std::nullopt;
        total += *angle;
    }
    return total;
}

static bool is_once_around(double turned) { return std::lround(turned / (2 * std::numbers::pi)) == 1; }

std::optional<bool> inside(const Patch& patch, const Vec2& uv, double rounding) {
    const Vec2 within = uv.cwiseMax(patch.lo).cwiseMin(patch.hi);
    const Vec2 rate = parameters_per_length(lift(patch, within));
    double total = 0;
    for (const auto& loop : patch.loops)
        for (const Trim& trim : loop) {
            const Vec2 near = kNearEdge * (patch.hi - patch.lo) + (trim.error + rounding) * rate;
            const auto angle = swept(trim, uv, near);
            if (!angle) return std::nullopt;
            total += *angle;
        }
    return is_once_around(total);
}

// What joins two trims counts as the straight line between their ends.
std::optional<bool> is_wound_around(const Patch& patch, const Vec2& uv) {
    const Vec2 near = patch.parameter_rounding();
    double total = 0;
    for (const auto& loop : patch.loops)
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2 end = loop[i].last_point(), start = loop[(i + 1) % loop.size()].first_point();
            if (!is_beside(end.cwiseMin(start), end.cwiseMax(start), uv, near)) return std::nullopt;
            const auto angle = swept(loop[i], uv, near);
            if (!angle) return std::nullopt;
            total += *angle + turn(end, start, uv);
        }
    return is_once_around(total);
}

const RationalPatch& Patch::part() const {
    if (!known_part) known_part = part_of(*surface, lo, hi);
    return *known_part;
}

RationalPatch part_of(const RationalPatch& surface, const Vec2& lo, const Vec2& hi) {
    RationalPatch part = surface;
    part.domain_u = {lo.x(), hi.x()};
    part.domain_v = {lo.y(), hi.y()};
    for (auto& c : part.points) c.head<3>() *= c[3];
    const std::array domains{surface.domain_u, surface.domain_v};
    const std::array degrees{surface.degree_u, surface.degree_v}, strides{surface.degree_v + 1, 1};
    for (const int axis : {0, 1}) {
        const auto& [first, last] = domains[axis];
        for (int line = 0; line <= degrees[1 - axis]; ++line) {
            std::vector<Eigen::Vector4d> points;
            const auto at = [&](int i) -> Eigen::Vector4d& {
                return part.points[line * strides[1 - axis] + i * strides[axis]];
            };
            for (int i = 0; i <= degrees[axis]; ++i) points.push_back(at(i));
            points =
                part_of(points, (lo[axis] - first) / (last - first), (hi[axis] - first) / (last - first));
            for (int i = 0; i <= degrees[axis]; ++i) at(i) = points[i];
        }
    }
    for (auto& c : part.points) c.head<3>() /= c[3];
    return part;
}

// The ray's line is the intersection of two planes. Beside them the surface's homogeneous coordinates give
// two polynomials, with the signs of its control points.
std::optional<std::vector<Vec2>> parameters(const Patch& patch, const Ray& ray,
                                            const SceneGeometry& geometry) {
    const Vec3 start = ray.at(ray.start);
    const auto aside = [&](const Vec3& p) {
        return Vec2(ray.across[0].dot(p - start), ray.across[1].dot(p - start));
    };
    const Vec2 infinite = Vec2::Constant(HUGE_VAL);
    Vec2 least = infinite, most = -infinite;
    bool is_ahead = false;
    const double noise = kRounding * patch.control_size;
    const RationalPatch& part = patch.part();
    for (const auto& c : part.points) {
        const Vec3 p = c.head<3>();
        least = least.cwiseMin(aside(p));
        most = most.cwiseMax(aside(p));
        is_ahead |= geometry.ahead(ray, p) > -noise;
    }
    std::vector<Vec2> result;
    if (!is_ahead || (least.array() > noise).any() || (most.array() < -noise).any()) return result;

    Map map{Vec2::Zero(), Vec2::Ones(), {part.degree_u, part.degree_v}, {}};
    for (const auto& c : part.points) map.points.push_back(c[3] * aside(c.head<3>()));
    const auto places = zeros(std::move(map));
    if (!places) return std::nullopt;
    for (const Vec2& s : *places) {
        const Vec2 uv = patch.lo + s.cwiseProduct(patch.hi - patch.lo);
        const SurfacePoint on_line = lift(patch, uv);
        // Next to the ray's start the surface may as well be behind it, or meet another ray.
        const double ahead = geometry.ahead(ray, on_line.p);
        if (std::abs(ahead) <= surface_rounding(patch, on_line, uv)) return std::nullopt;
        if (ahead > 0) result.push_back(uv);
    }
    return result;
}

}  // namespace vcell::check
