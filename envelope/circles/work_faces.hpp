/// A minimization diagram under construction whose faces are divided between their sites and challengers:
/// once arcs are inserted, edges between equal labels go, and the boundaries that are left tell which faces
/// there are.
#pragma once

#include <vector>

#include "work_arcs.hpp"

namespace vcell {

class WorkFaces : public WorkArcs {
public:
    /// Merges in one more form. All faces are compared with it: a diagram that consists of one face needs no
    /// overlay, so forms can be merged in one at a time without ever computing the crossing of two unrelated
    /// trisectors.
    void insert(FormId challenger);

protected:
    using WorkArcs::WorkArcs;

    /// Divides the faces of duels_. Pre: their boundaries are decided.
    void divide_faces();

    std::vector<Duel> duels_;

private:
    void remove_inner_edges();
    void kill_edge(Index e);
    void smooth(Index v);
    void rebuild_faces();
    void nest_cycles();
    void add_bounded_face(Index outer);

    // Working space of one division, kept for its memory.
    std::vector<Index> cycles_;    // a half-edge of each new boundary component
    std::vector<Index> isolated_;  // isolated vertices that need a face
};

}  // namespace vcell
