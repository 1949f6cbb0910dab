/// Puts the minimization diagrams of adjacent pieces of a region together into one.
///
/// The region is split by lines (seams) into convex pieces, and each piece has its own diagram. Both
/// sides of a seam were decided exactly, so along it they show the same vertices and labels in the same
/// order: gluing is a walk along both, without a single comparison of coordinates. Seam edges vanish (both
/// their sides carry one label), and so do the vertices they leave between two arcs of one curve.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "../circles/work_diagram.hpp"
#include "../proofs/mixed_piece.hpp"
#include "form_mesh.hpp"
#include "minimization_diagram.hpp"

namespace vcell {

class Patchwork : private FormMesh {
public:
    using FormMesh::Index;
    using FormMesh::none;
    using FormMesh::tie_hidden;

    /// Room for what this many forms usually leave.
    Patchwork(const FormFamily& family, std::size_t forms);

    /// The id of a new seam.
    std::uint32_t new_seam() { return seam_bit | seams_++; }
    /// The id of seams at a depth of a recursion in which both pieces beside one are glued before others at
    /// that depth are added: never those of two seams at a time.
    static std::uint32_t seam_at(unsigned depth) { return seam_bit | depth_bit | depth; }
    static bool is_seam(std::uint32_t side) { return (side & seam_bit) != 0; }
    /// Seams of its own have other ids than those that `other` has given.
    void leave_seams_to(const Patchwork& other) { seams_ = other.seams_; }

    /// Takes over a finished piece. `line_sides[i]` is the side that the kernel's form 1 + i stands for.
    /// Returns a half-edge on its outer side, the piece's handle.
    Index add(const WorkDiagram& piece, std::span<const PieceSide> line_sides);

    /// Takes over a piece that was decided by enclosures.
    Index add(const MixedPiece& piece);

    /// Takes over what another patchwork has made of a part of the region: the same as if the pieces had been
    /// added and glued here, but for what gluing has removed, which is left behind. Returns the new handle of
    /// the part that has this one there. Pre: circular forms alone; all seams of its own have been glued.
    Index take(Patchwork&& part, Index handle) { return FormMesh::take(std::move(part), handle); }

    /// Joins two pieces along a seam that is a whole side of both; returns the handle of their union.
    Index glue(Index piece, Index other, std::uint32_t seam);

    /// Joins a piece with itself: its side `right`, at an x larger by `circumference`, is its side `left`.
    /// The two rims that remain become the region's outside, that of the side `upper` apart from the other's.
    void close(Index piece, std::uint32_t right, std::uint32_t left, double circumference,
               std::uint32_t upper);

    /// Takes away the rim, beyond which the form along it is lowest everywhere. Pre: one form is lowest all
    /// along it.
    void drop_rim(Index outer);

    /// Are two forms one function along a part of the region's side, from one point to another?
    using AreOne = std::function<bool(std::uint32_t side, const Eigen::Vector2d& from,
                                      const Eigen::Vector2d& to, FormId f, FormId g)>;
    /// Names what ties along the rim. Pieces that were decided by enclosures have the lowest forms along it
    /// alone, those of circular forms all that tie, so that their rims do not go on in each other. What ties
    /// all along an edge does in its ends.
    void tie_along_rim(const AreOne& are_one);

    /// Collects faces and boundary components; the region is left for the caller to fill in.
    /// Pre: all pieces have been glued into one.
    MinimizationDiagram finish(const Heights& heights);

private:
    static constexpr std::uint32_t seam_bit = 0x80000000u, depth_bit = 0x40000000u;

    /// Joins an island of the piece that was added last, whose first edge that is, to the face that it lies
    /// in.
    void join_island(Index first_edge);
    static constexpr std::size_t usual_chain = 8;
    using Chain = SmallVector<Index, usual_chain>;
    Chain side_chain(Index outer, std::uint32_t seam) const;
    void unite_vertices(Index kept, Index other, Index outgoing, Index face);
    Index join_chains(const Chain& down, const Chain& up);

    const FormFamily& family_;
    std::vector<Index> face_map_, vertex_map_, edge_map_, around_;  // working space of add()
    std::uint32_t seams_ = 0;
    std::uint32_t upper_rim_ = UINT32_MAX;
    Index pole_face_ = none;
};

}  // namespace vcell
