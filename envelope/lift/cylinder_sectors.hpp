/// How faces of cylinders over a plane base are divided for their patches.
///
/// The base region is seen from A, the projection of the bisector's tip, under less than a half turn if the
/// cylinder is solid (cylinder_patch.hpp): one patch is enough. The face of a hollow one may have A inside,
/// or run around it. Then rays from A divide the region into sectors, each with a patch about the ray in its
/// middle; face_cut.hpp has what its boundary does there.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "based_diagram.hpp"
#include "cylinder_patch.hpp"
#include "face_loops.hpp"

namespace vcell {

/// What lies between two angles about A.
struct CylinderSector {
    double from, to;
    CylinderFrame frame;

    double middle() const { return 0.5 * (from + to); }
    /// The angle's coordinate v at its end, and -v at its start.
    double reach() const { return 2 / frame.eps() * std::tan(0.25 * (to - from)); }
};

class CylinderSectors {
public:
    /// Throws UndecidedError where the edge of a face may run through A.
    CylinderSectors(const PlaneDiagram& of, const FaceLoops& loops);

    /// The frame of the face's patch, or of the first one of several. Pre, here and below: the face's form is
    /// a cylinder's.
    const CylinderFrame& frame(FaceId face) const { return frames_[face]; }
    bool is_cut(FaceId face) const { return !sectors_.empty() && !sectors_[face].empty(); }
    bool holds_tip(FaceId face) const { return holds_tip_[face]; }
    /// Those of a face that is cut, once around; of others none.
    std::span<const CylinderSector> operator[](FaceId face) const {
        return sectors_.empty() ? std::span<const CylinderSector>() : sectors_[face];
    }
    /// The sector in which a part of a face's boundary lies between two points, within one, with the face on
    /// its left. Pre: is_cut(face).
    std::uint32_t between(FaceId face, const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
    /// The frame there; of a face that is not cut its one.
    const CylinderFrame& frame_between(FaceId face, const Eigen::Vector2d& from,
                                       const Eigen::Vector2d& to) const {
        return is_cut(face) ? sectors_[face][between(face, from, to)].frame : frames_[face];
    }

    /// The angle about a point A over an edge's start, and by how much it changes along the edge. Pre: the
    /// edge's pieces keep clear of A.
    std::array<double, 2> along(EdgeId e, const Eigen::Vector2d& A) const;

private:
    void add_face(const PlaneDiagram& of, const FaceLoops& loops, FaceId face);
    void refuse_edges_through_tip(const PlaneDiagram& of, const FaceLoops& loops, FaceId face,
                                  const CylinderHeight& height) const;

    const MinimizationDiagram& diagram_;
    IdVector<FaceId, CylinderFrame> frames_;
    IdVector<FaceId, std::vector<CylinderSector>> sectors_;  // empty unless there are hollow cylinders
    IdVector<FaceId, bool> holds_tip_;
};

}  // namespace vcell
