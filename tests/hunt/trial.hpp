/// One scene's cell, or its whole diagram, computed and judged in a process of its own: it may hang, run out
/// of memory or crash.
#pragma once

#include <cstdint>
#include <string>

#include "../../envelope/voronoi_diagram.hpp"
#include "../../primitives/objects/scene.hpp"

namespace vcell::hunt {

enum class Outcome : std::uint8_t {
    Proved,     ///< certify() proves all of the cell, nothing is assumed
    Assumed,    ///< such a cell, with coincidences taken for granted and listed
    Open,       ///< certify() refutes nothing, but cannot prove all
    Undecided,  ///< UndecidedError, with the place
    Illegal,    ///< InputError: an object touches the base after all
    Wrong,      ///< certify() refutes an element
    Internal,   ///< InternalError, or any other exception
    TooLong,
    TooLarge,  ///< more memory than granted
    Crash,
};
inline constexpr std::size_t outcome_count = 10;
const char* to_string(Outcome outcome);
/// What is undecided or open is a pity, these are faults.
inline bool is_fault(Outcome o) { return o >= Outcome::Wrong; }

struct Trial {
    Outcome outcome;
    std::string what;  ///< the first finding, or the message
};

struct Limits {
    unsigned seconds = 5;            ///< of processor time for cell and check together
    std::uint64_t megabytes = 1000;  ///< of address space beyond the program's own
};

Trial judge(const Scene& scene, const Limits& limits);
/// All cells, complete ones, as their file has them. What has no cell makes the diagram undecided, or illegal
/// where an object is refused; all the same the others are judged.
Trial judge(const DiagramScene& scene, const Limits& limits);

/// The scene with as few objects, and as short numbers, as still give the same outcome.
Scene minimised(Scene scene, const Trial& trial, const Limits& limits);
DiagramScene minimised(DiagramScene scene, const Trial& trial, const Limits& limits);

}  // namespace vcell::hunt
