/// Spheres and cylinders alike: surfaces at a distance rho from a point or a line.
#pragma once

#include "../bisectors/polynomial3.hpp"

namespace vcell {

/// The squared distance of p from the centre (from the axis) is squared()(p) / norm.
struct RoundSurface {
    ExactVector point;  ///< the centre, or a point of the axis
    ExactVector axis;   ///< zero for a sphere
    Exact norm = 1.0;   ///< |axis|^2; 1 for a sphere
    Exact rho;

    explicit RoundSurface(const Sphere& s) : point(s.center), rho(s.radius) {}
    explicit RoundSurface(const Cylinder& c)
        : point(c.point), axis(c.axis), norm(dot(axis, axis)), rho(c.radius) {}

    bool is_cylinder() const { return !axis.is_zero(); }

    Polynomial3 squared() const {
        Polynomial3 sum;
        for (const auto& [direction, value] : {std::pair<ExactVector, Exact>{{1.0, 0.0, 0.0}, point.x},
                                               {{0.0, 1.0, 0.0}, point.y},
                                               {{0.0, 0.0, 1.0}, point.z}}) {
            const Polynomial3 m = Polynomial3::linear(direction, -value);
            sum = sum + norm * (m * m);
        }
        if (!is_cylinder()) return sum;
        const Polynomial3 along = Polynomial3::linear(axis, -dot(axis, point));
        return sum - along * along;
    }
    Exact squared_at(const ExactVector& p) const {
        const ExactVector m = p - point;
        const Exact along = dot(m, axis);
        return norm * dot(m, m) - along * along;
    }
    /// Is the other's solid part of this one's? Both ways: the same surface.
    bool contains(const RoundSurface& inner) const {
        if (inner.is_cylinder() && (!is_cylinder() || !cross(axis, inner.axis).is_zero())) return false;
        const Exact room = rho - inner.rho;
        return room.sign() != Sign::Negative && squared_at(inner.point) <= norm * room * room;
    }
};

}  // namespace vcell
