/// What must hold in a diagram whatever its geometry: the dcel's invariants, sizes, labels in order and
/// included in each other, edges as long as they can be.
#pragma once

#include <algorithm>
#include <string>

#include "brute_force.hpp"

namespace vcell::oracle {

class StructureOracle : protected BruteForce {
public:
    using BruteForce::BruteForce;

protected:
    template <class Ids>
    static bool ascending(const Ids& ids) {
        return std::ranges::adjacent_find(ids, [](auto a, auto b) { return !(a < b); }) == ids.end();
    }

    void check_structure() {
        if (const auto defect = dcel_.find_defect()) return complain("dcel: " + defect->what);
        if (d_.vertices.size() != dcel_.vertex_count() || d_.edges.size() != dcel_.edge_count() ||
            d_.face_forms.size() != dcel_.face_count() || d_.forms.size() != family_.forms.size())
            return complain("sizes: the diagram's arrays do not match its dcel");
        if (d_.vertex_offsets_.size() != d_.vertices.size() + 1 ||
            d_.side_offsets_.size() != d_.vertices.size() + 1 ||
            d_.edge_offsets_.size() != d_.edges.size() + 1)
            return complain("sizes: label offsets do not match");
        if (d_.face_forms[Dcel::unbounded_face()].valid()) complain("f0: the unbounded face has a label");
        for (const FaceId f : d_.face_forms.ids()) {
            if (f == Dcel::unbounded_face()) continue;
            const FormId form = d_.face_forms[f];
            if (form.valid() ? form.value >= forms_.size() : !forms_.empty())
                complain(to_string(f) + ": label " + to_string(form));
        }
        for (const VertexId v : d_.vertices.ids()) {
            if (!ascending(d_.label(v))) complain(to_string(v) + ": label not ascending");
            for (const FormId f : d_.label(v))
                if (f.value >= forms_.size()) complain(to_string(v) + ": label out of range");
            for (const std::uint32_t s : d_.sides(v))
                if (s >= sides_.size()) complain(to_string(v) + ": side out of range");
            const FaceId around = dcel_.isolated_in(v);
            if (around.valid()) check_label_part(to_string(v), d_.label(v), d_.label(around));
        }
        for (const EdgeId e : d_.edges.ids()) check_edge_structure(e);
        if (complaints_.empty())
            for (const VertexId v : d_.vertices.ids()) check_maximal(v);
    }

    template <class Label, class Part>
    void check_label_part(const std::string& where, const Label& label, const Part& part) {
        for (const auto& id : part)
            if (std::ranges::find(label, id) == label.end())
                complain(where + ": label " + name(label) + " lacks its neighbour's " + to_string(id));
    }

    void check_edge_structure(EdgeId e) {
        const auto& edge = d_.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        const FaceId left = dcel_.face(h), right = dcel_.face(Dcel::twin(h));
        const std::string where = to_string(e);
        if (!ascending(d_.label(e))) complain(where + ": label not ascending");
        if (edge.left != d_.face_forms[left]) complain(where + ": left is not the form of the left face");
        if (edge.on_rim()) {
            if (edge.side >= sides_.size()) complain(where + ": side out of range");
            if (edge.right.valid()) complain(where + ": on the rim with a form on the right");
            if (right != Dcel::unbounded_face()) complain(where + ": on the rim, but not of the region");
        } else {
            if (edge.right != d_.face_forms[right])
                complain(where + ": right is not the form of the right face");
            if (edge.left == edge.right) complain(where + ": the same form on both sides");
            if (left == Dcel::unbounded_face() || right == Dcel::unbounded_face())
                complain(where + ": borders the unbounded face, but is not on the rim");
        }
        check_label_part(where, d_.label(e), d_.label(left));
        check_label_part(where, d_.label(e), d_.label(right));
        for (const VertexId v : {dcel_.origin(h), dcel_.target(h)}) {
            if (!v.valid()) continue;
            check_label_part(to_string(v), d_.label(v), d_.label(e));
            if (edge.on_rim() && std::ranges::find(d_.sides(v), edge.side) == d_.sides(v).end())
                complain(to_string(v) + ": ends a rim edge of side " + std::to_string(edge.side) +
                         " without lying on it");
        }
    }

    /// A vertex of degree two between like edges has no business there.
    void check_maximal(VertexId v) {
        const HalfEdgeId h = dcel_.outgoing(v);
        if (!h.valid()) {
            if (d_.label(v).size() < 2) complain(to_string(v) + ": isolated without a tie");
            return;
        }
        const HalfEdgeId g = dcel_.next_around_origin(h);
        if (g == h || dcel_.next_around_origin(g) != h) return;
        const auto &a = d_.edges[Dcel::edge(h)], &b = d_.edges[Dcel::edge(g)];
        const auto la = d_.label(Dcel::edge(h)), lv = d_.label(v);
        const bool alike = a.side == b.side && std::minmax(a.left, a.right) == std::minmax(b.left, b.right) &&
                           std::ranges::equal(la, d_.label(Dcel::edge(g)));
        if (alike && std::ranges::equal(la, lv) && Dcel::edge(h) != Dcel::edge(g))
            complain(to_string(v) + ": joins two edges that are one");
    }
};

}  // namespace vcell::oracle
