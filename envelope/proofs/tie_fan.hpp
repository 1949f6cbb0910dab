/// The lower envelope around a point in which all of its functions tie.
///
/// Let functions agree at an apex c, and let D be the difference of two of them on a convex set around c. By
/// the mean value theorem, with gradients and Hessians averaged over the set,
///
///     D(c + t u) = t grad D . u,            or  t^2 u^T (Hess D) u / 2  where the gradients agree at c too,
///     grad D(c + t u) . v                       t v^T (Hess D) u.
///
/// So an enclosure of grad D, or of Hess D, over the set gives the sign of D for all t at once in every
/// direction in which it is definite; and where instead the derivative across the direction is, D vanishes
/// once at every t: its zero set is one arm that starts at c and crosses the sector. When the directions can
/// be divided into sectors in which one function is lowest and sectors crossed by one arm of two functions,
/// all others being higher there, then the envelope is a fan: faces and arms that meet at c and nowhere else.
///
/// Functions whose gradients at c are on one line leave no such sectors about the direction in which they
/// change alike. Of every three of them let the middle one be lower than the others, or higher, wherever
/// these two are equal and not at c. In a sector that is crossed by one arm of every two, those have a face
/// that are lower wherever two others are equal that are lowest before and after them: cusps, whose arms
/// touch at c.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "../../primitives/forms/heights.hpp"

namespace vcell {

/// The difference of two functions that agree at the apex, enclosed all over a convex set around it.
struct TiedDifference {
    std::array<Interval, 2> gradient;
    /// Given where the gradients agree at the apex.
    std::optional<HeightCurvature<Interval>> curvature;
};

/// Of three functions, by their places in the list, the middle one is lower (`shows`) or higher than the
/// others all over the set where these are equal, but for the apex, where all are.
struct TiedBetween {
    std::size_t middle;
    std::array<std::size_t, 2> outer;
    bool shows;
};

/// Where the label changes around the apex: in a sector less than half a turn wide, from one direction
/// counter-clockwise to another. At every t the line c + t from + s (to - from) crosses the arm once. The two
/// arms of a cusp are in one sector.
struct FanArm {
    Eigen::Vector2d from, to;
    FormId right, left;  ///< lowest on the clockwise and on the counter-clockwise side
};

struct Fan {
    FormId first;  ///< lowest in the first direction
    std::vector<FanArm> arms;
};

/// The fan of forms in the directions between the first and the last of `corners`, each less than half a turn
/// counter-clockwise from the one before. differences[i][j]: of form i less form j, i < j. None where the
/// enclosures do not tell.
std::optional<Fan> find_fan(std::span<const FormId> forms,
                            const std::vector<std::vector<TiedDifference>>& differences,
                            std::span<const TiedBetween> between, std::span<const Eigen::Vector2d> corners);

}  // namespace vcell
