#include "saddle.hpp"

#include <algorithm>
#include <cmath>

#include "../../primitives/objects/exact_space.hpp"
#include "space.hpp"

namespace vcell::check {

namespace {

// The tube's unit direction in the frame, and what it lacks of that of the base's axis (0, 0, 1): of axes
// that are much alike to a part of their difference.
struct Direction {
    Triad<MidRad> d;
    MidRad sum, rest;  // 1 + d_z, 1 - d_z
};
Direction direction_of(const Cylinder& base, const Cylinder& tube, const Frame& frame) {
    const Vec3 axis = base.axis.dot(tube.axis) < 0 ? Vec3(-tube.axis) : tube.axis;
    if (const auto axes = Space<Interval>::near_axes(axis, base.axis, to_vector<Interval>(base.axis))) {
        const auto& turn = (*axes)[0];
        const Triad<MidRad> t = near(frame.direction(Triad<Interval>{turn[0], turn[1], turn[2]}));
        const MidRad rest = 0.5 * squared_norm(t);
        return {{t[0], t[1], MidRad(1.0) - rest}, MidRad(2.0) - rest, rest};
    }
    const Triad<MidRad> d = normalized(near(frame.direction(axis / axis.cwiseAbs().maxCoeff())));
    return {d, MidRad(1.0) + d[2], MidRad(1.0) - d[2]};
}

}  // namespace

std::optional<Saddle> Saddle::of(const Cylinder& base, const Cylinder& tube, const Frame& frame,
                                 std::span<const Triad<double>> corners) {
    if (base.radius != tube.radius || cross(ExactVector(base.axis), ExactVector(tube.axis)).is_zero())
        return std::nullopt;
    auto [d, sum, rest] = direction_of(base, tube, frame);
    const MidRad sine = sqrt(square(d[0]) + square(d[1]));
    if (!(sine.lower() > 0)) return std::nullopt;
    const Triad<MidRad> way = frame.way(base.point, tube.point);
    const MidRad side = (way[1] * d[0] - way[0] * d[1]) / sine;
    if (!(side.lower() > 0) && !(side.upper() < 0)) return std::nullopt;
    // Along the axis, from the base's point.
    const MidRad crossing = way[2] - (way[0] * d[0] + way[1] * d[1]) / square(sine) * d[2];
    if (side.upper() < 0) {
        for (MidRad& e : d) e = -e;
        std::swap(sum, rest);
    }
    const MidRad apart = side.lower() > 0 ? side : -side;
    const MidRad x_length = sqrt(2.0 * sum), y_length = sqrt(2.0 * rest);
    Saddle f;
    f.x = {d[0] / x_length, d[1] / x_length, sum / x_length};
    f.y = {d[0] / y_length, d[1] / y_length, -rest / y_length};
    f.z = {-d[1] / sine, d[0] / sine, 0.0};
    const Triad<double>& corner = f.corner = corners.front();
    f.steep = sine / apart;
    // From the crossing's foot on the base's axis, that is (0, 0, zeta).
    const MidRad up = MidRad(corner[2]) - (MidRad(frame.point(base.point)[2]) + crossing);
    const auto along = [&](const Triad<MidRad>& e) {
        return e[0] * MidRad(corner[0]) + e[1] * MidRad(corner[1]) + e[2] * up;
    };
    const MidRad X = along(f.x), Y = along(f.y), half_apart = 0.5 * apart;
    f.at = {X, Y, along(f.z) - half_apart + f.steep * X * Y};
    // h / 2 - steep x_z y_z (X^2 + Y^2): as in graph_faces.cpp, about the crossing.
    const MidRad k = f.steep * f.x[2] * f.y[2];
    f.half_value = 0.5 * (half_apart - k * (square(X) + square(Y)));
    f.half_slope = {-k * X, -k * Y};
    f.half_square = -0.5 * k;
    // Angles about a crossing that is so many times as far away as the face is large tell too little of it.
    constexpr double far = 0x1p16;
    double along_normal = 0, along_rays = 0, extent = 0;
    for (const Triad<double>& p : corners) {
        double x = X.mid(), y = Y.mid();
        for (const std::size_t i : {0, 1, 2}) {
            x += f.x[i].mid() * (p[i] - corner[i]);
            y += f.y[i].mid() * (p[i] - corner[i]);
        }
        along_normal += half_apart.mid() - k.mid() * (x * x + y * y);
        along_rays += std::hypot(p[0], p[1]);
        extent = std::max(extent, std::hypot(x - X.mid(), y - Y.mid()));
    }
    if (!(along_normal <= along_rays && std::hypot(X.mid(), Y.mid()) <= far * extent)) return std::nullopt;
    return f;
}

}  // namespace vcell::check
