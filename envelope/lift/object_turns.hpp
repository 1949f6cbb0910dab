/// Angles about the axis of a hollow tube or cone, or of a tube that pierces the base, along the loops of its
/// face: how far the face reaches around the axis, and where seams may run. And which faces hold a tip, where
/// the bisector comes to the axis.
#pragma once

#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "../../primitives/bases/axial_terms.hpp"
#include "based_diagram.hpp"
#include "face_loops.hpp"

namespace vcell::radial {

/// The axis of a tube or a hollow cone, and from where on angles about it count.
struct ObjectAxis {
    Vec3 point, x,
        y;  ///< x and y unit, across the axis; x.cross(y) points along it, of a solid tube against it

    /// Pre: the object is a Cylinder, a HollowCylinder or a HollowCone.
    explicit ObjectAxis(const Object& vessel);

    /// The unit vector from the axis at an angle; and back, of a point.
    Vec3 direction(double angle) const { return std::cos(angle) * x + std::sin(angle) * y; }
    double angle_of(const Vec3& direction) const { return std::atan2(y.dot(direction), x.dot(direction)); }
    double angle(const Vec3& p) const { return angle_of(p - point); }
};

/// What a face covers, followed along its loops from point to point of the diagram.
class ObjectTurns {
public:
    ObjectTurns(const RadialDiagram& of, const FaceLoops& loops, const ObjectAxis& axis, FaceId face);

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

/// The tips of bisectors that lie inside faces. Throws UndecidedError where another form is as
/// near there but for rounding, and where loops of several faces do not tell which one it is.
class FaceTips {
public:
    FaceTips(const RadialDiagram& of, const FaceLoops& loops);

    /// By where they lie along the object's axis; none of other objects' faces.
    std::span<const BisectorTip> operator[](FaceId face) const {
        const auto found = tips_.find(face);
        return found == tips_.end() ? std::span<const BisectorTip>() : found->second;
    }

private:
    bool holds(const RadialDiagram& of, const FaceLoops& loops, FaceId face, const BisectorTip& tip) const;

    std::map<FaceId, std::vector<BisectorTip>> tips_;
};

}  // namespace vcell::radial
