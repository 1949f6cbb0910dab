/// A diagram of discs as it lies on the unit sphere: its faces' forms and the arcs between them, which is all
/// that measures of a ball's cell need of it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "../../core/ids.hpp"
#include "sphere_trees.hpp"

namespace vcell {

struct DiscArcs {
    struct Vertex {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        double error = 0;  ///< bounds the distance from the true vertex
    };
    /// Runs counter-clockwise about `normal`, seen from outside, with the face of `left` on its left.
    struct Arc {
        FormId left, right;
        std::uint32_t from, to;  ///< of `vertices`
        /// normal.p = offset on its circle. What errors of both change about normal.p - offset is no more
        /// than `error` anywhere on the sphere, and less than 2^-20 of the normal's length.
        Eigen::Vector3d normal;
        double offset, square, length, error;  ///< square and length: of the normal
        /// Certainly less than half a turn. Otherwise it is more than 2^-10 of a turn, and so is the rest of
        /// its circle.
        bool is_short;
        /// All points of a short arc are within this distance from each other, where that is next to nothing;
        /// otherwise infinite.
        double extent;
    };

    /// 1 / t = -form(u) where the direction u meets a form's bisector.
    std::vector<discs::Linear> forms;
    std::vector<Vertex> vertices;
    /// Those that are not certainly points. Several forms that tie in a vertex may have it in more than one
    /// place, each within its error.
    std::vector<Arc> arcs;
    std::vector<FormId> faces;  ///< that have any area
};

}  // namespace vcell
