/// Combinatorial diagrams in a normal form, for comparison.
#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"

namespace vcell::oracle {

/// Renames the parts of a diagram, for comparison with that of a transformed scene.
struct Renaming {
    std::vector<std::uint32_t> form;  ///< new number of each form
    std::vector<std::uint32_t> side;  ///< new number of each side of the region
    bool mirrored = false;            ///< left becomes right
};

/// The combinatorial diagram in a normal form: equal strings exactly for equal diagrams with equal labels.
/// Lists vertices (label, sides, faces in cyclic order), edges (label, sides' forms, end labels) and faces
/// (form, boundary components as cycles of neighbours, isolated vertices), each sorted.
inline std::vector<std::string> canonical(const MinimizationDiagram& d, const Renaming& r) {
    const Dcel& dcel = d.dcel;
    const auto form = [&](FormId f) {
        return f.valid() ? std::to_string(r.form[f.value]) : std::string("-");
    };
    const auto forms = [&](std::span<const FormId> label) {
        std::set<std::uint32_t> sorted;
        for (const FormId f : label) sorted.insert(r.form[f.value]);
        std::string s = "{";
        for (const std::uint32_t f : sorted) s += std::to_string(f) + " ";
        return s + "}";
    };
    const auto vertex = [&](VertexId v) {
        if (!v.valid()) return std::string("closed");
        std::set<std::uint32_t> sides;
        for (const std::uint32_t s : d.sides(v)) sides.insert(r.side[s]);
        std::string s = forms(d.label(v)) + "[";
        for (const std::uint32_t i : sides) s += std::to_string(i) + " ";
        return s + "]";
    };
    const auto cycle = [&](std::vector<std::string> parts) {
        if (r.mirrored) std::ranges::reverse(parts);
        std::string best;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            std::ranges::rotate(parts, parts.begin() + 1);
            std::string s;
            for (const auto& p : parts) s += p + ",";
            if (best.empty() || s < best) best = s;
        }
        return "(" + best + ")";
    };
    const auto component = [&](CcbId c) {
        std::vector<std::string> parts;
        HalfEdgeId h = dcel.start(c);
        do {
            parts.push_back(form(d.face_forms[dcel.face(Dcel::twin(h))]));
            h = dcel.next(h);
        } while (h != dcel.start(c));
        return cycle(parts);
    };
    std::vector<std::string> result;
    for (const VertexId v : d.vertices.ids()) {
        std::vector<std::string> around;
        if (const HalfEdgeId first = dcel.outgoing(v); first.valid()) {
            HalfEdgeId h = first;
            do {
                around.push_back(form(d.face_forms[dcel.face(h)]));
                h = dcel.next_around_origin(h);
            } while (h != first);
        }
        result.push_back("vertex " + vertex(v) + cycle(around));
    }
    for (const EdgeId e : d.edges.ids()) {
        const auto& edge = d.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        // Seen from its smaller side; turned round, or mirrored, an edge starts where it ended. Without
        // labels, a rim edge keeps the region on its left in the mirror too.
        std::array<std::string, 2> sides{form(edge.left), form(edge.right)};
        std::array<std::string, 2> ends{vertex(dcel.origin(h)), vertex(dcel.target(h))};
        if (r.mirrored) std::swap(sides[0], sides[1]);
        if (sides[1] < sides[0] || (r.mirrored && sides[0] == sides[1])) {
            std::swap(sides[0], sides[1]);
            std::swap(ends[0], ends[1]);
        }
        result.push_back("edge " + forms(d.label(e)) + sides[0] + "|" + sides[1] + " " + ends[0] + "->" +
                         ends[1] + (edge.on_rim() ? " side " + std::to_string(r.side[edge.side]) : ""));
    }
    for (const FaceId f : d.face_forms.ids()) {
        std::vector<std::string> parts;
        for (const CcbId c : dcel.inner_ccbs(f)) parts.push_back("hole" + component(c));
        for (const VertexId v : dcel.isolated_vertices(f)) parts.push_back("isolated" + vertex(v));
        std::ranges::sort(parts);
        std::string s = "face " + form(d.face_forms[f]);
        if (dcel.outer_ccb(f).valid()) s += component(dcel.outer_ccb(f));
        for (const auto& p : parts) s += " " + p;
        result.push_back(s);
    }
    std::ranges::sort(result);
    return result;
}

}  // namespace vcell::oracle
