/// Where a curved base sees points from, canonical: a sphere from its centre, a cylinder from their feet
/// (0, y, 0) on its axis.
#pragma once

#include <cmath>

#include "../objects/objects.hpp"

namespace vcell {

class RadialFoot {
public:
    explicit constexpr RadialFoot(bool is_sphere) : is_sphere_(is_sphere) {}

    /// What of y counts as distance from the foot, and the foot's own y.
    double across(double y) const { return is_sphere_ ? y : 0.0; }
    double along(double y) const { return is_sphere_ ? 0.0 : y; }
    double distance(const Vec3& p) const { return is_sphere_ ? p.norm() : std::hypot(p.x(), p.z()); }

private:
    bool is_sphere_;
};

}  // namespace vcell
