/// What tells twins (twins.hpp) apart in space, in doubles: for edges between them.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "form_family.hpp"

namespace vcell {

/// X.M X + l.X + k of X = (p, t) as space_quadrics.hpp has it: p in the chart's own axes (BaseChart::turn), t
/// the distance from the foot; over a plane p_z does not enter, but t. M is symmetric.
struct SpaceQuadric {
    Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
    Eigen::Vector4d l = Eigen::Vector4d::Zero();
    double k = 0;

    SpaceQuadric times(double factor) const { return {factor * M, factor * l, factor * k}; }
    /// Of points that are turned.
    SpaceQuadric turned(const Eigen::Matrix3d& turn) const;
};

/// The equation of f less lambda times that of g, as twins.hpp has lambda; none unless the two are twins.
/// Positive where g is nearer, and zero on their trisector with the base. Each number errs by 2^-52 of
/// itself.
std::optional<SpaceQuadric> twin_quadric(const FormFamily& family, FormId f, FormId g);

}  // namespace vcell
