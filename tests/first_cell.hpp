/// Cells of random scenes, whatever the seed.
#pragma once

#include "../core/errors.hpp"
#include "../envelope/voronoi_cell.hpp"

namespace vcell {

/// The cell of the first scene that make() returns in which no object cuts the base.
template <class Make>
Cell first_cell(const Make& make) {
    constexpr int most_tries = 100;
    for (int tries = 0;; ++tries) {
        try {
            return voronoi_cell(make());
        } catch (const InputError& error) {
            if (error.kind != InputError::Kind::TouchesBase || tries == most_tries) throw;
        }
    }
}

}  // namespace vcell
