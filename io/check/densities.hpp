/// What faces are integrated by, along their edges (shadows.hpp).
#pragma once

namespace vcell::check {

/// Per ds along an edge that a face lies on the left of.
template <class T>
struct Densities {
    T volume, area, shadow;
    T steepness;  ///< area of the face for that of the base at its distance
};

}  // namespace vcell::check
