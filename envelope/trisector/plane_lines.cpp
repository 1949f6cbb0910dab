#include "plane_lines.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "../../core/numbers/interval.hpp"

namespace vcell {

namespace {

using Row = std::array<Interval, 3>;

Interval row_length(const Row& r) { return sqrt(square(r[0]) + square(r[1]) + square(r[2])); }

// n.(p - point) / |n|, with its gradient.
struct SignedDistance {
    Row gradient;
    Vec3 point;

    explicit SignedDistance(const Plane& plane) : point(plane.point) {
        const Row n{plane.normal.x(), plane.normal.y(), plane.normal.z()};
        for (int k = 0; k < 3; ++k) gradient[k] = n[k] / row_length(n);
    }
    Interval at(const Vec3& p) const {
        Interval sum(0.0);
        for (int k = 0; k < 3; ++k) sum += gradient[k] * (Interval(p[k]) - point[k]);
        return sum;
    }
};

class PlaneLines {
public:
    PlaneLines(const Solids& planes, const Box& region, double most_error)
        : distances_{SignedDistance(std::get<Plane>(planes[0])), SignedDistance(std::get<Plane>(planes[1])),
                     SignedDistance(std::get<Plane>(planes[2]))},
          region_(region),
          most_error_(most_error) {}

    std::optional<TrisectorCurve> within(const TrisectorComponent& line) const {
        const Vec3 middle = 0.5 * (region_.min + region_.max), &d = line.direction;
        const double reach = region_.diagonal();
        const Vec3 foot = line.point + d.dot(middle - line.point) * d;
        // The region lies within half its diagonal of its middle: lines that pass farther away miss it, with
        // room for their rounding.
        if (!((foot - middle).norm() < 0.75 * reach)) return std::nullopt;
        const std::array<Vec3, 2> ends{foot - reach * d, foot + reach * d};
        const double off = std::max(distance_from_line(ends[0]), distance_from_line(ends[1]));
        if (!std::isfinite(off)) fail_trisector("is a line that doubles do not tell", foot);

        std::array<Stop, 2> stops{Stop{0, -1, 0}, Stop{1, -1, 0}};
        for (int side = 0; side < 7; ++side) {
            const std::array<Interval, 2> value{inwards(side, ends[0]), inwards(side, ends[1])};
            std::array<int, 2> sign{};
            for (int i : {0, 1}) sign[i] = value[i].lower() > off ? 1 : value[i].upper() < -off ? -1 : 0;
            if (sign[0] == 0 || sign[1] == 0)
                fail_trisector("is a line along a side of its region, or in one of the planes,", foot);
            if (sign[0] < 0 && sign[1] < 0) return std::nullopt;
            if (sign[0] > 0 && sign[1] > 0) continue;
            // The true line is where this has its value up to `off`, and so much farther away is the end.
            const double from = value[0].mid(), to = value[1].mid(), t = from / (from - to),
                         slope = std::abs(to - from) / (2 * reach),
                         room = off + value[0].radius() + value[1].radius() + 0x1p-50 * reach;
            const Stop stop{t, side < 6 ? side : -1, 2 * room / slope};
            Stop& end = stops[sign[0] < 0 ? 0 : 1];
            if (sign[0] < 0 ? stop.at > end.at : stop.at < end.at) end = stop;
        }
        const double length = 2 * reach * (stops[1].at - stops[0].at),
                     doubt = 2 * (stops[0].off + stops[1].off + off);
        if (length < -doubt) return std::nullopt;
        if (!(length > doubt))
            fail_trisector("touches an edge of its region", ends[0] + stops[0].at * (ends[1] - ends[0]));
        TrisectorCurve curve;
        curve.kind = TrisectorKind::Line;
        curve.degree = 1;
        curve.error = off + std::max(stops[0].off, stops[1].off);
        if (!(curve.error <= most_error_)) fail_trisector("is a line that doubles do not tell", foot);
        curve.ends = {stops[0].side, stops[1].side};
        std::array<Eigen::Vector4d, 2> points;
        for (int i : {0, 1}) points[i] = Vec3(ends[0] + stops[i].at * (ends[1] - ends[0])).homogeneous();
        curve.arcs.push_back({1, {0, 0, 1, 1}, {points[0], points[1]}});
        return curve;
    }

private:
    // Part of the way from one end to the other; `off` bounds how far it is from the true end.
    struct Stop {
        double at;
        int side;
        double off;
    };

    // The line solves two linear equations with gradients g and h. Where they are off by a and b it is
    // |a h - b g| / |g x h| away.
    double distance_from_line(const Vec3& p) const {
        Row g, h, across;
        for (int k = 0; k < 3; ++k) {
            g[k] = distances_[1].gradient[k] - distances_[0].gradient[k];
            h[k] = distances_[2].gradient[k] - distances_[0].gradient[k];
        }
        for (int k = 0; k < 3; ++k)
            across[k] = g[(k + 1) % 3] * h[(k + 2) % 3] - g[(k + 2) % 3] * h[(k + 1) % 3];
        const Interval own = distances_[0].at(p);
        const double a = (distances_[1].at(p) - own).magnitude(), b = (distances_[2].at(p) - own).magnitude();
        return ((a * row_length(h) + b * row_length(g)) / row_length(across)).upper();
    }

    // Within the sides of the region, and, as the last one, the distance from the planes.
    Interval inwards(int side, const Vec3& p) const {
        if (side == 6) return distances_[0].at(p);
        const int axis = side / 2;
        return side % 2 == 1 ? Interval(region_.max[axis]) - p[axis] : Interval(p[axis]) - region_.min[axis];
    }

    std::array<SignedDistance, 3> distances_;
    Box region_;
    double most_error_;
};

}  // namespace

std::vector<TrisectorCurve> lines_between_planes(const Solids& planes, const Box& region, double tolerance) {
    constexpr double most_error = 256;  // in tolerances, as of edges of cells
    std::vector<TrisectorCurve> curves;
    const PlaneLines lines(planes, region, most_error * tolerance);
    for (const TrisectorComponent& line : trisector_of_solids(planes[0], planes[1], planes[2]).components) {
        // In all three planes.
        if (line.clearance && line.clearance->isZero(0)) continue;
        if (auto curve = lines.within(line)) curves.push_back(*std::move(curve));
    }
    return curves;
}

}  // namespace vcell
