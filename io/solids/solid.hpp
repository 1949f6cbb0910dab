/// The boundary of the solid that a cell is, as CAD programs have it: one surface for each face, and edges
/// that are nothing but a face's on either side.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shell.hpp"

namespace vcell {

struct Solid {
    /// A part of an edge of the shell between seams, or a seam. A closed one starts and ends in one vertex.
    /// Seams come together in a tip of the surface, and at caps on it (with_tip_caps()). At a tip that has
    /// none patches have a side that is one point: loops have a gap there in the parameters, and no edge.
    struct Edge {
        std::array<std::uint32_t, 2> vertices;  ///< start and end of the curve
        RationalCurve3 curve;
    };
    struct Use {
        std::uint32_t edge;
        bool reversed;         ///< against the edge's sense
        RationalCurve2 curve;  ///< in the edge's sense, and with its parameter
    };
    struct Face {
        std::uint32_t of;  ///< the shell's face, of which this is one patch, or a cap of one
        RationalPatch surface;
        bool is_flat;  ///< closes the shell: origin + u x + v y
        std::vector<std::vector<Use>> loops;
    };

    std::vector<Vec3> vertices;
    std::vector<Edge> edges;
    std::vector<Face> faces;
    std::vector<std::vector<std::uint32_t>> parts;  ///< faces that edges join: one closed shell each
    /// How far, at most, curves are from their surfaces at the same parameter, and from their vertices: what
    /// the shell states, with ends and seams as they are (seams at 17 places of each).
    double off = 0;
};

/// `cell_faces` is how many of the shell's faces are the cell's own. Edges
/// within `shortest`, a length, or within what the solid is off otherwise, of where they start are left out:
/// their ends are one vertex. Throws InternalError where an edge is not used once each way.
Solid solid_of(const Shell& shell, std::size_t cell_faces, double shortest = 0);

}  // namespace vcell
