/// Rotations that scenes are turned by.
#pragma once

#include <Eigen/Geometry>

namespace vcell {

/// Takes the z axis to `direction`, of any length but not -z, about what is normal to both. Eigen's
/// FromTwoVectors has an SVD for -z, which takes four seconds to compile.
inline Eigen::Quaterniond rotation_from_z(const Eigen::Vector3d& direction) {
    const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(direction);
    return Eigen::Quaterniond(direction.norm() + direction.z(), across.x(), across.y(), across.z())
        .normalized();
}

}  // namespace vcell
