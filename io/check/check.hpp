/// vcell check: proves that a cell is what it says, from the scene in it alone.
///
/// Nothing that computed the cell takes part. All elements together, proved, establish the statement: the
/// boundary as written lies everywhere within Certificate::distance of the true one.
///   - structure: indices, knots, weights (structure.hpp); only where it holds is anything else judged;
///   - vertices, edges and faces lie where they must, and no other site is nearer (vertices.hpp, edges.hpp,
///     faces.hpp);
///   - faces tile the base region: each base point lies under one of them (tiling.hpp);
///   - measures enclosed by integrals of its own (measures.hpp).
/// A complete cell has nothing else that comes in through sides of the box (entries.hpp); around a tube it
/// comes in parts: each is judged by all of that, and what lies between them is said to be left out
/// (parts.hpp). Bounds are rounded outwards (core/numbers/interval.hpp).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "../../envelope/cell.hpp"
#include "certificate.hpp"

namespace vcell {

struct CheckOptions {
    std::uint32_t samples = 500;  ///< base points whose owner is compared where something is not proved
    std::uint64_t seed = 1;       ///< of the sampled points
    /// How far a curve or a patch is subdivided before what it says is left open: each step allows twice as
    /// many parts.
    int effort = 10;
};

/// Geometry is judged only where the structure allows. What is not_measured (CellOptions::measure) is
/// refuted. Of a cell that is one of a whole diagram's objects are named by their places in its scene.
Certificate certify(const Cell& cell, const CheckOptions& options = {});

/// What is refuted or open.
struct Finding {
    std::string where;
    std::string what;
};

/// All that certify() refutes or leaves open; empty: the certificate holds.
std::vector<Finding> check_cell(const Cell& cell, const CheckOptions& options = {});

}  // namespace vcell
