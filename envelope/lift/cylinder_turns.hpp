/// Angles around a cylinder base, along a diagram's edges and loops: how far faces reach around it, and where
/// seams may run.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "based_diagram.hpp"
#include "face_loops.hpp"

namespace vcell::radial {

/// Where symmetric input has no points in which an edge touches a generator: a seam there would run along the
/// edge as far as doubles tell.
constexpr double off_middle = 0.48643;

/// The angle about the y axis over a point of the chart.
inline double chart_angle(double x) {
    return x > 1 ? std::numbers::pi + 2 * std::atan(x - 2) : 2 * std::atan(x);
}

/// How far a way that turns by `turn` from an angle on has turned when it comes to another one first.
inline double turned_until(double angle, double from, double turn) {
    constexpr double whole = 2 * std::numbers::pi;
    const double part = std::fmod(turn < 0 ? from - angle : angle - from, whole);
    return part < 0 ? part + whole : part;
}

/// Where the sides of `count` sectors once around keep furthest from all of these angles.
double clear_angle(std::vector<double> angles, std::size_t count);

class CylinderTurns {
public:
    CylinderTurns(const RadialDiagram& of, const FaceLoops& loops)
        : problem_(of.problem), diagram_(of.diagram), loops_(loops) {}

    /// The base's normal, canonical, at an angle of the chart; and back.
    Vec3 direction(double angle) const {
        return problem_.chart.turn * Vec3(std::sin(angle), 0, std::cos(angle));
    }
    double angle(const Vec3& direction) const {
        const Vec3 in_chart = problem_.chart.turn.transpose() * direction;
        return std::atan2(in_chart.x(), in_chart.z());
    }

    /// What a face covers: angles in the chart, continuously; heights of its boundary's points, and their
    /// mean.
    struct Extent {
        double from = 0, to = 0, y = 0;
        double lowest = std::numeric_limits<double>::infinity(),
               highest = -std::numeric_limits<double>::infinity();
        bool is_closed = false;  ///< all around

        double middle() const { return 0.5 * (from + to); }
        double width() const { return to - from; }
    };
    Extent extent(FaceId face) const;
    /// The mean y of a face's boundary points between two angles; of all its points where none lie there.
    double mean_height(FaceId face, double from, double to) const;
    /// Angles of the face's vertices, in no order.
    std::vector<double> of_vertices(FaceId face) const;

    /// The angle over an edge's start, and by how much it changes.
    std::array<double, 2> along(EdgeId e) const;

private:
    double rim_turn(VertexId from, VertexId to, double sign) const;

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const FaceLoops& loops_;
};

}  // namespace vcell::radial
