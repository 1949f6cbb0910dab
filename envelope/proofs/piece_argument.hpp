// What the arguments about one piece have at hand: the piece in work, all that compete, and their common
// points.
#pragma once

#include "common_points.hpp"
#include "mixed_work.hpp"

namespace vcell {

class PieceArgument {
protected:
    PieceArgument(Competition& all, PieceWork& work)
        : all_(all),
          points_(all),
          work_(work),
          heights_(all.heights()),
          rule_(all.rule()),
          decisions_(all.decisions()),
          extent_(all.extent()) {}

    Competition& all_;
    CommonPoints points_;
    PieceWork& work_;
    const Heights& heights_;
    const FloorRule& rule_;
    Decisions& decisions_;
    double extent_;
};

}  // namespace vcell
