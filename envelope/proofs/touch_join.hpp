// The arcs of a small piece in which a form is lowest nowhere but for touching the trisector of two others in
// a vertex, or in a lens on it (touching.hpp).
#pragma once

#include "piece_argument.hpp"

namespace vcell {

class TouchJoin : PieceArgument {
public:
    TouchJoin(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    bool join();

private:
    bool touch_in_vertex(std::uint32_t vertex, std::span<const FormId> touching,
                         const std::array<Wide, 2>& at);
};

}  // namespace vcell
