/// What the edges of a cell enclose, by integrals along them: volumes, areas and shadows of faces, lengths.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "../../envelope/cell.hpp"
#include "shadows.hpp"

namespace vcell::check {

struct FaceIntegrals {
    Interval volume, area;  ///< volume: from the plane, the centre or the axis on; less than 0 where entered
    Interval shadow;  ///< likewise: area over a plane, solid angle about a sphere, angle times length on a
                      ///< cylinder
    bool is_known = true;   ///< false: its side of a plane, or a start, could not be told
    bool is_proved = true;  ///< false: what some rule leaves out of volume or area is estimated
};

/// What of a cell's volume and area need not be known better.
struct Precision {
    double volume, area;
};

/// A face or an edge lies as far from the true one as its edges' errors allow: what that may change.
struct Slack {
    double volume = 0, area = 0, shadow = 0;
};

struct Integrals {
    std::vector<FaceIntegrals> faces;
    std::vector<Slack> slack;       ///< by face
    std::vector<Interval> lengths;  ///< by edge
    Slack total;
    /// Of the cell's sides over the rim: walls under a plane's rim, discs and rings where a cylinder's
    /// stretch ends (from the axis on).
    Interval sides = 0.0;
    bool are_shadows_proved = true;  ///< false: what some rule leaves out of shadows is estimated
};

/// One side of an edge.
struct EdgeUse {
    std::size_t face;
    bool reversed;
    bool is_entered = false;  ///< the face is seen against the base's normals' sense
};

/// What is known of an edge.
struct EdgeBand {
    double error;  ///< how far it may be from the true one, in the frame's unit
    double
        steepness;  ///< at most, of objects' faces beside it (shadows.hpp); infinite where nothing is known
};

/// In the frame's unit. `bands`: by edge. `enough`:
/// volume, area and length that need not be known better, of the whole cell. Faces that need integrals in two
/// variables (of tubes, and on cylinders) are proved where `proofs`, by face, say how exactly, which takes
/// many times as long as to estimate them. Pre: the structure holds.
Integrals integrate_faces(const Cell& cell, const Frame& frame, const std::vector<std::vector<EdgeUse>>& uses,
                          const std::vector<EdgeBand>& bands, const std::array<double, 3>& enough, int effort,
                          std::span<const std::optional<Precision>> proofs);

}  // namespace vcell::check
