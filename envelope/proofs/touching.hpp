/// A form that comes down to the trisector of two others from above, and touches it, or is lowest in a lens
/// around it; or one between two others that is all but pinched off.
///
/// Let F = f - g, f - h and h - g all grow along a direction d over a convex set. On every line along d then
/// h is nowhere below both f and g if it is not where these two are equal. There their trisector is a graph
/// over the coordinate s along e, across d, with
///
///     n' = -F_e / F_n,    n'' = -(F_ee + 2 F_en n' + F_nn n'^2) / F_n        (n along d)
///
/// and so h is higher by phi(s) = D, D = h - g - l F with any number l, and
///
///     phi' = D_e + D_n n',    phi'' = D_ee + 2 D_en n' + D_nn n'^2 + D_n n''.
///
/// If phi'' is positive, phi is nowhere below its value where phi' = 0, or at the end from which it rises.
/// And it has no more than one zero on either side: where it has both, h is lowest in a lens between them,
/// however thin. If phi'' is negative the roles change: f and g meet between the zeros of phi, and elsewhere
/// h lies between them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "../../primitives/forms/heights.hpp"

namespace vcell {

struct Touching {
    std::array<Wide, 2> at;  ///< on the trisector
    Eigen::Vector2d place;   ///< the same, rounded
    Wide gap;                ///< h less the others there
    Wide height;             ///< theirs
    double width;  ///< bounds the distance from `place` of all that is on the trisector and not below h
    Eigen::Vector2d across;  ///< f - g, f - h and h - g grow in this direction, all over the box
    /// Where phi has a zero on both sides of `place`, h is lowest between the two points, in a face that ends
    /// in them, and nowhere else.
    struct Lens {
        std::array<Eigen::Vector2d, 2> ends;  ///< nearly; along the trisector with f on its left
        double thickness;                     ///< no point of the face is farther from the trisector
    };
    std::optional<Lens> lens;
};

/// Where h is least above f and g, as far as all of that is seen by intervals over the box and its
/// surroundings as wide again. If the gap is not negative, h is lowest nowhere in the box but for a tie in
/// that place.
std::optional<Touching> find_touching(const Heights& heights, FormId h, FormId f, FormId g,
                                      const std::array<double, 4>& box);

/// Where a concave phi is greatest h is all but pinched off between f and g, or quite. `gap` is its greatest
/// value: if it is positive f and g meet in the arc between the lens's ends, no point of which is farther
/// from `place` than `width`, and if it is negative nowhere. None if the greatest value is at an end.
std::optional<Touching> find_pinch(const Heights& heights, FormId h, FormId f, FormId g,
                                   const std::array<double, 4>& box);

/// Do three forms certainly tie nowhere in the box? Where F = f - g grows along one coordinate the trisector
/// is a graph over the other, s, and phi = h - g along it changes by no more than |D_s + D_n n'| for each
/// unit of s. Pre: the base is curved. Counts the answer, whatever it is.
bool meet_nowhere(const Heights& heights, FormId h, FormId f, FormId g, const std::array<double, 4>& box,
                  Decisions& decisions);

}  // namespace vcell
