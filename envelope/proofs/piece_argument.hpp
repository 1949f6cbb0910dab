// What the arguments about one piece have at hand: the piece in work, all that compete, and their common
// points.
#pragma once

#include "common_points.hpp"
#include "mixed_work.hpp"

namespace vcell {

class PieceArgument : protected CompetitionArgument {
protected:
    PieceArgument(Competition& all, PieceWork& work) : CompetitionArgument(all), points_(all), work_(work) {}

    CommonPoints points_;
    PieceWork& work_;
};

}  // namespace vcell
