/// A minimization diagram under construction that is compared with a challenger, a form that is not in it:
/// the comparison of two surfaces over an overlay face of [HE, section 2.1]. Known are then the signs of
/// challenger - defender at the vertices and along the edges of the faces that are asked about; where the
/// sign changes along an edge, that is cut.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "work_mesh.hpp"

namespace vcell {

class WorkSigns : public WorkMesh {
public:
    /// Forms of the kernel from `first` on are a floor (EnvelopeOptions::floor): they are inserted where they
    /// are greater than what is there. `is_below`: the diagram's edges between a floor and other forms have
    /// the lesser of the two on either side. Stays until it is set again; none: there is no floor.
    void set_floor(FormId first, bool is_below) {
        first_floor_ = first;
        is_below_floor_ = is_below;
    }
    /// What walks and comparisons have taken, in half-edges passed, about.
    std::size_t visit_count() const { return visits_; }

protected:
    using WorkMesh::WorkMesh;

    /// A face and who challenges it.
    struct Duel {
        Index face;
        FormId challenger;
        double slope = HUGE_VAL;  // upper bound of |challenger - defender|'s slope on the boundary, if known
        bool met = false;         // the challenger wins or ties somewhere on the boundary
        bool changed = false;     // and takes over a part of the face
    };
    struct Cut {
        PointId point;
        bool touching;
    };

    void clear();
    /// Forgets the signs that are known.
    void begin() {
        ++stamp_;
        reached_.clear();
    }
    void decide_boundary(Duel& d);
    // A floor's form takes over where it is greater: then `challenger - defender` of what follows is that of
    // the two in turn, so that it is negative where the challenger wins here, too.
    bool is_floor(FormId f) const { return first_floor_.valid() && f >= first_floor_; }
    FormPair rivals(FormId challenger, FormId defender) const {
        return inserts_greater_ ? FormPair{defender, challenger} : FormPair{challenger, defender};
    }
    FormId challenger_of(FormPair rival) const { return inserts_greater_ ? rival.g : rival.f; }
    FormId defender_of(FormPair rival) const { return inserts_greater_ ? rival.f : rival.g; }
    // The curve between two labels, the lesser form on its left.
    FormPair between(FormId left, FormId right) const {
        const bool l = is_floor(left), r = is_floor(right);
        return (l && r) || (!is_below_floor_ && (l || r)) ? FormPair{right, left} : FormPair{left, right};
    }

    Sign vertex_sign(Index v, FormPair rival) {
        return vertices_[v].stamp == stamp_ ? vertices_[v].sign : find_vertex_sign(v, rival);
    }
    double steepening(FormPair rival) const;
    bool steadily_keeps_sign(const Edge& edge, const Vertex& v, const Vertex& w, const Duel& d,
                             double K) const;
    bool surely_keeps_sign(Index e, FormPair rival, Sign common);
    std::optional<Cut> first_root(Index e, FormPair rival, Sign common);
    Cut change_of_sign(Index e, FormPair rival, Sign turn);

    Index stamp_ = 0;               // of what is known of the challenger
    bool inserts_greater_ = false;  // the challenger takes over where it is greater
    bool merging_ = false;          // two diagrams are compared: every face has a challenger
    std::size_t visits_ = 0;
    std::size_t walks_ = 0;  // forms inserted by walking
    std::vector<Index>
        reached_;  // since the first of these: faces beyond edges on which a challenger wins or ties

private:
    bool keeps_sign(Index e, FormPair rival, Sign common) const;
    Sign find_vertex_sign(Index v, FormPair rival);
    bool decide_edge(Index e, FormPair rival);
    bool cut_edge(Index e, FormPair rival, std::span<const Cut> cuts, Sign before);
    Eigen::Vector2d chord_middle(Index e) const {
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        return {0.5 * (p.x + q.x), 0.5 * (p.y + q.y)};
    }

    FormId first_floor_;
    bool is_below_floor_ = false;
};

}  // namespace vcell
