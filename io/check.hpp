/// vcell check: judges a cell by its own data.
///
/// Nothing that computed the cell takes part: owners of rays are found by brute force over all objects
/// with plain distance functions and bisection, curves and patches are evaluated and integrated by code
/// of this module alone. Verified are
///   - structure: indices, knots, weights, labels, each edge used once from either side, loops closed and
///     turning the right way, seams in pairs, Euler's relation (on the disk, the sphere or the annulus);
///   - geometry: vertices, edges and patches equally far from the base and from their sites, nothing
///     nearer, inside the box; trimming curves lie on the edges; kinds and names;
///   - completeness: sampled base points lie in exactly one face, that of the nearest site;
///   - measures, re-integrated; neighbours; clearances.
/// A deviation counts when it exceeds the errors that the cell states plus rounding at the scene's scale.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "../envelope/cell.hpp"

namespace vcell {

/// One thing wrong: the place as the cell file names it ("vertices[3]", "faces[2].patches[0].loops[1]",
/// "measures.volume"), and what is wrong there.
struct Finding {
    std::string where;
    std::string what;
};

struct CheckOptions {
    std::uint32_t samples = 500;  ///< base points whose owner is compared
    std::uint64_t seed = 1;       ///< of the sampled points
};

/// All that is wrong with the cell; empty: nothing found. Geometry is judged only where the structure
/// allows. What is not_measured (CellOptions::measure) is wrong.
std::vector<Finding> check_cell(const Cell& cell, const CheckOptions& options = {});

}  // namespace vcell
