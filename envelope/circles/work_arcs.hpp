/// A minimization diagram under construction into whose faces the arcs of a challenger's trisectors are
/// inserted, where these run through them: from the roots on a face's boundary, or as an island in it.
#pragma once

#include <vector>

#include "work_signs.hpp"

namespace vcell {

class WorkArcs : public WorkSigns {
protected:
    using WorkSigns::WorkSigns;

    /// Inserts the arcs inside the face, and tells who wins beside its boundary and these. All half-edges
    /// that may have another face then are in touched_, where the face changes. Pre: its boundary is decided.
    void divide_face(Duel& d);

    std::vector<Index> touched_;

private:
    struct Branch {    // {challenger = defender} leaves a vertex into the face, or ends there
        Index corner;  // the boundary half-edge that arrives at the vertex
        Index vertex;
        bool start;  // leaves, when run with the challenger on its left
        Index half_edge = none;
    };
    void find_branches(Index cycle, FormPair rival);
    void insert_arcs(FormPair rival);
    void insert_island(Duel& d, Sign boundary);
    void thread_isolated(Index face, std::size_t first_new);
    /// Who wins beside half-edge h of the duel's face, on its left.
    FormId winner(Index h, const Duel& d) {
        const Sign s = edges_[h >> 1].sign;
        if (s == Sign::Zero) return winner_along(h, d);
        return s == Sign::Negative ? d.challenger : faces_[d.face].site;
    }
    FormId winner_along(Index h, const Duel& d);

    std::vector<Branch> branches_;  // working space
};

}  // namespace vcell
