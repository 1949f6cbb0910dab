/// Base planes in hollow tubes, and what a floor has in one by hand.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "../../envelope/cell.hpp"
#include "../../primitives/objects/scene.hpp"

namespace vcell {

inline constexpr double half_turn = std::numbers::pi;
inline const Plane ground{{0, 0, 0}, {0, 0, 1}};

inline Scene floor_in(const Plane& base, std::vector<Object> objects) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    scene.box = {{-2, -2, -2}, {2, 2, 2}};
    return scene;
}

// A tube with its axis through a point, and what a floor has in it where nothing else is.
struct Vessel {
    HollowCylinder tube;
    double base_area, volume, area, highest;
    CurveKind rim;
    const char* bisector;
};

// The bisector over the rim of an upright or leaning tube is a cone whose tip is as high as the radius, 1,
// and all generators of it rise to the tip. Over the rim of a level tube along the box it is the arch of a
// parabola, ((1 - h^2) - y^2) / (2 (1 - h)) high where h is the axis' height.
inline std::vector<Vessel> lone_vessels() {
    const double lean = 0.8, height = 0.5, half_width = std::sqrt(1 - height * height);
    // The arch is the parabola y^2 / (2 p) between -w and w.
    const double p = 1 - height, w = half_width,
                 arch = w * std::sqrt(1 + w * w / (p * p)) + p * std::asinh(w / p);
    // The normals of the leaning cone are across its generators, along n - (0, 0, 1) with n from the axis.
    double steepness = 0;
    constexpr int steps = 4096;
    for (int i = 0; i < steps; ++i) {
        // The point of the rim is told by its angle about the axis; the face is over a sector from the tip's
        // foot, which is the ellipse's focus.
        const double turn = 2 * half_turn * (i + 0.5) / steps;
        const Vec3 n(lean * std::cos(turn), std::sin(turn), -0.6 * std::cos(turn));
        const Vec3 rim(std::cos(turn) / lean, std::sin(turn), 0),
            along(-std::sin(turn) / lean, std::cos(turn), 0), foot(0.75, 0, 0);
        const Vec3 normal = -n - Vec3::UnitZ();
        steepness += 0.5 * (rim - foot).cross(along).z() * normal.norm() / std::abs(normal.z()) * 2 *
                     half_turn / steps;
    }
    return {{{{0.25, 0.125, -3}, {0, 0, 2}, 1},
             half_turn,
             half_turn / 3,
             std::sqrt(2) * half_turn,
             1,
             CurveKind::Circle,
             "circular cone"},
            {{{-0.5, 0.25, 0}, {0.75, 0, 1}, 1},
             half_turn / lean,
             half_turn / lean / 3,
             steepness,
             1,
             CurveKind::Ellipse,
             "elliptic cone"},
            {{{0.5, 0.25, height}, {-1, 0, 0}, 1},
             8 * half_width,
             8 * w * w * w / (3 * p),
             4 * arch,
             0.5 * (1 + height),
             CurveKind::Line,
             "parabolic cylinder"}};
}

}  // namespace vcell
