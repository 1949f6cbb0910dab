/// A cell's edges and faces as its neighbours have them: across the joints of its parts.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "../../envelope/cell.hpp"
#include "../solids/joined_parts.hpp"
#include "known_mesh.hpp"

namespace vcell {

/// Edges of a cell that follow each other.
struct WholeEdge {
    struct Piece {
        std::uint32_t edge;
        bool reversed;
    };
    std::vector<Piece> pieces;
    /// Start and end; none where the pieces are all of a closed edge.
    std::optional<std::array<std::uint32_t, 2>> vertices;
};

/// Of a cell whose parts are joined: edges and faces go on beyond joints. Of another cell everything is
/// whole.
class WholeElements {
public:
    explicit WholeElements(const Cell& cell);
    explicit WholeElements(const JoinedParts& joined);

    std::vector<WholeEdge> edges;
    std::vector<std::vector<std::uint32_t>> faces;  ///< of the cell's
    std::vector<bool> is_vertex;                    ///< of the cell's: an end of a whole edge, or alone

    /// Which whole edge has an edge of the cell for a piece, and whether it runs against that: none of
    /// joints, and of what is left over.
    const std::optional<WholeEdge::Piece>& whole_of(std::uint32_t edge) const { return whole_of_[edge]; }
    std::uint32_t whole_face(std::uint32_t face) const { return whole_face_[face]; }

    /// A point of a whole edge, `part` of the way through its pieces, 0 <= part <= 1.
    Vec3 point(const WholeEdge& e, double part) const;
    /// As distance_from_curve().
    double distance(const WholeEdge& e, const Vec3& p, double enough) const;
    /// The greatest of its pieces', and of the vertices that it passes.
    double error(const WholeEdge& e) const;

    /// Makes a polyline of a whole edge, points of the mesh from its start to its end, its pieces' lines, and
    /// draws their ends there: it is divided in the points that are nearest to joints.
    void divide(const WholeEdge& edge, const std::vector<std::uint32_t>& line, KnownMesh& known) const;

private:
    const Cell& cell_;
    std::vector<std::optional<WholeEdge::Piece>> whole_of_;
    std::vector<std::uint32_t> whole_face_;
};

}  // namespace vcell
