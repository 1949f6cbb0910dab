// The arcs of a small piece in which all rivals tie: a fan around that point (tie_fan.hpp).
#pragma once

#include "apex.hpp"
#include "piece_argument.hpp"

namespace vcell {

class TieJoin : PieceArgument {
public:
    TieJoin(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    bool join();

private:
    bool is_tie_of_given(const Apex& apex, const std::optional<std::array<FormId, 3>>& three);
    bool divide_arm(MixedPiece::Arc& arc, const Apex& apex, const FanArm& arm) const;
};

}  // namespace vcell
