/// Where to put the pole of a sphere's stereographic chart.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "../objects/objects.hpp"

namespace vcell {

/// How near the objects come along the unit normal u of a sphere base: Q(u) = 1 / t, in double. The largest
/// wins.
struct Nearness {
    /// Q = p.u + s
    struct Linear {
        Vec3 p;
        double s;
    };
    /// Q = (beta + sqrt(beta^2 + C alpha^2)) / C,  beta = foot.u + delta, alpha = axis.u, C = |foot|^2 -
    /// delta^2; C < 0: it pierces the base.
    /// Hollow: - C alpha^2, C = delta^2 - |foot|^2, `foot` being away from the axis and delta > 0. Hollow
    /// cones likewise, with alpha = axis.u - sine and what the equation of radial_form.hpp has for the
    /// others.
    struct Cylindrical {
        Vec3 foot, axis;  ///< the axis' point nearest to the centre; its unit direction
        double delta, C;
        bool is_hollow = false;
        double sine = 0;
    };
    std::vector<Linear> linear;
    std::vector<Cylindrical> cylindrical;
};

/// Q of one in the direction u, in double.
double nearness_of(const Nearness::Cylindrical& f, const Vec3& u);

/// The rotation `matrix / norm`; matrix and norm hold integers below 2^51.
struct IntegerRotation {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    double norm = 1;
};

/// A rotation whose last column points away from a pole about which one object is nearest, with as few
/// bits as the room around the pole allows. None when there is no such room that doubles can see.
/// Linear in the number of objects. Pre: there are objects.
std::optional<IntegerRotation> chart_rotation(const Nearness& nearness);

}  // namespace vcell
