/// A minimization diagram under construction into which forms are inserted by walking, where they come in the
/// order of K: that takes what changes and the way there, not all there is.
#pragma once

#include <vector>

#include "work_faces.hpp"

namespace vcell {

class WorkWalk : public WorkFaces {
public:
    /// insert(), but by walking there from a vertex: that takes what changes and the way, not all there is.
    /// Returns a vertex near the form's face, or where the way ended. Pre: no form of the diagram has a
    /// greater K than the challenger, exactly; there is no floor; is_on_way(from).
    Index insert_most_curved(FormId challenger, Index from);
    /// May one set out from here? Vertices that are no more are asked about, too.
    bool is_on_way(Index v) const {
        return v < vertices_.size() && vertices_[v].alive && vertices_[v].out != none;
    }
    /// A vertex from which one may. Pre: start().
    Index any_on_way() const {
        Index v = 0;
        while (!is_on_way(v)) ++v;
        return v;
    }
    /// Has a form been compared with a face of many holes, all of which are looked at each time?
    bool is_holey() const { return is_holey_; }

protected:
    using WorkFaces::WorkFaces;

    void clear();

private:
    // A face of which a part goes: from the first of these half-edges of its boundary to the second.
    struct Bite {
        Index face, leaving, returning;     // none: all of it
        std::size_t first_corner, corners;  // outside: those of the polygon that the part reaches around
    };
    struct Corner {
        Index vertex;
        FormPair after;  // the curve of the rim from there on, seen from outside
    };
    Index walk(FormId challenger, Index from);
    void challenge_from(FormId challenger, Index v);
    bool find_bites(FormId challenger, Index v);
    bool cut_in(FormId challenger, Index v);
    void take_out(const Bite& b);
    void add_sides(const Bite& b, FormId challenger, Index own);
    bool is_above_diagram(FormId challenger, Index v) const;

    std::size_t scans_ = 0;  // forms that were sought in all faces in the end
    bool is_holey_ = false;
    std::vector<Bite> bites_;  // working space, as below
    std::vector<Corner> corners_;
    std::vector<Index> new_edges_;
};

}  // namespace vcell
