/// A scene whose objects lie with the ranks, each ball with one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ranks.hpp"

namespace vcell::mpi {

/// An object whose cell this rank computes.
struct OwnObject {
    std::uint32_t number;  ///< in the whole scene
    Object object;         ///< on the grid, where the box repeats
    Object given;          ///< as the file has it
    std::string name, group;
};

/// An object that this rank knows.
struct KnownObject {
    std::uint32_t number;
    Object object;
    std::string name;
};

struct SceneParts {
    DiagramScene frame;               ///< without objects, on the grid
    DiagramScene given_frame;         ///< as the file has it
    std::uint32_t count = 0;          ///< of all objects
    double moved = 0;                 ///< whole::snap_to_grid()
    bool has_names = false;           ///< some object has
    std::vector<OwnObject> own;       ///< ascending
    std::vector<KnownObject> others;  ///< all objects that are no balls; ascending
};

/// Balls go where k-d blocks say; objects that are no balls are known everywhere, and their cells go round.
/// The scene is the first rank's alone. Throws SharedFailure where it is none (whole::validate_diagram()),
/// which names the file of that path.
SceneParts spread(Ranks& ranks, std::optional<DiagramScene> scene, const std::string& path);

/// The rank that the cell of parts.others[place] goes to.
inline int rank_of_other(std::size_t place, int ranks) {
    return static_cast<int>(place % static_cast<std::size_t>(ranks));
}

/// Numbers are cut into ranges for what is written in their order: rank r has those from range_begin(r, ...)
/// to range_begin(r + 1, ...).
std::uint32_t range_begin(int rank, int ranks, std::uint32_t count);
int range_of(std::uint32_t number, int ranks, std::uint32_t count);

}  // namespace vcell::mpi
