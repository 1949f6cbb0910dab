/// Angles about the axis of a hollow tube or cone, along the loops of its face over a sphere: how far the
/// face reaches around the axis, and where seams may run.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "based_diagram.hpp"
#include "face_loops.hpp"

namespace vcell::radial {

/// The axis of a hollow tube or cone, and from where on angles about it count.
struct VesselAxis {
    Vec3 point, x, y;  ///< x and y unit, across the axis, along which x.cross(y) points

    /// Pre: the object is a HollowCylinder or a HollowCone.
    explicit VesselAxis(const Object& vessel);

    /// The unit vector from the axis at an angle; and back, of a point.
    Vec3 direction(double angle) const { return std::cos(angle) * x + std::sin(angle) * y; }
    double angle(const Vec3& p) const { return std::atan2(y.dot(p - point), x.dot(p - point)); }
};

/// What a face covers, followed along its loops from point to point of the diagram.
class VesselTurns {
public:
    VesselTurns(const RadialDiagram& of, const FaceLoops& loops, const VesselAxis& axis, FaceId face);

    /// Does a loop run around the axis?
    bool is_closed() const { return is_closed_; }
    /// Angles of the widest loop, continuously.
    double middle() const { return 0.5 * (from_ + to_); }
    double width() const { return to_ - from_; }
    /// Angles of the face's vertices, in no order.
    const std::vector<double>& of_vertices() const { return of_vertices_; }

private:
    double from_ = 0, to_ = 0;
    bool is_closed_ = false;
    std::vector<double> of_vertices_;
};

}  // namespace vcell::radial
