/// A diagram over a curved base beside its scene: structure, labels, and whether all that a label names ties.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "complaints.hpp"
#include "surroundings.hpp"

namespace vcell::radial {

class StructureOracle : protected Complaints {
public:
    StructureOracle(const Scene& scene, const RadialBaseProblem& problem, const MinimizationDiagram& diagram)
        : problem_(problem), around_(scene, problem), d_(diagram), dcel_(diagram.dcel) {}

    const Surroundings& surroundings() const { return around_; }

protected:
    static std::string text(Fast v) { return std::to_string(static_cast<double>(v)); }
    static std::string place(Fast x, Fast y) { return "(" + text(x) + ", " + text(y) + ")"; }
    bool is_over_sphere() const { return problem_.chart.is_sphere(); }
    bool has_face(FormId f) const { return f.valid() && f.value < problem_.sites.size(); }

    FaceId outer_face(std::uint32_t rim) const { return {rim == 0 ? 0u : 1u}; }

    // --- Structure and labels

    void check_structure() {
        if (const auto defect = dcel_.find_defect()) return complain("dcel: " + defect->what);
        const std::size_t forms = d_.forms.size() + d_.radial.size();
        if (d_.vertices.size() != dcel_.vertex_count() || d_.edges.size() != dcel_.edge_count() ||
            d_.face_forms.size() != dcel_.face_count() || forms != problem_.sites.size() ||
            d_.vertex_offsets_.size() != d_.vertices.size() + 1 ||
            d_.edge_offsets_.size() != d_.edges.size() + 1)
            return complain("sizes: the diagram's arrays do not match");
        for (const FaceId f : d_.face_forms.ids()) {
            const bool outside = !is_over_sphere() && f.value < 2;
            if (has_face(d_.face_forms[f]) == outside)
                complain(to_string(f) + ": label " + to_string(d_.face_forms[f]));
        }
        if (!complaints_.empty()) return;
        for (const VertexId v : d_.vertices.ids()) check_label(to_string(v), d_.label(v));
        for (const EdgeId e : d_.edges.ids()) check_edge_structure(e);
    }

    void check_label(const std::string& where, std::span<const FormId> label) {
        for (std::size_t i = 0; i < label.size(); ++i)
            if (!has_face(label[i]) || (i > 0 && !(label[i - 1] < label[i])))
                complain(where + ": label " + name(label));
    }

    static bool includes(std::span<const FormId> label, FormId f) {
        return !f.valid() || std::ranges::find(label, f) != label.end();
    }

    void check_edge_structure(EdgeId e) {
        const auto& edge = d_.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        const std::string where = to_string(e);
        check_label(where, d_.label(e));
        const FormId left = d_.face_forms[dcel_.face(h)], right = d_.face_forms[dcel_.face(Dcel::twin(h))];
        if (edge.left != left || edge.right != right || !left.valid())
            complain(where + ": sides are not its faces'");
        if (edge.on_rim() == right.valid() || (edge.on_rim() && is_over_sphere()))
            complain(where + ": wrong about being on the rim");
        if (edge.on_rim() && dcel_.face(Dcel::twin(h)) != outer_face(edge.side))
            complain(where + ": on the wrong rim");
        if (!edge.on_rim() && left == right) complain(where + ": the same form on both sides");
        if (!includes(d_.label(e), left) || !includes(d_.label(e), right))
            complain(where + ": label " + name(d_.label(e)) + " lacks a face's");
        for (const VertexId v : {dcel_.origin(h), dcel_.target(h)})
            if (v.valid())
                for (const FormId f : d_.label(e))
                    if (!includes(d_.label(v), f)) complain(to_string(v) + ": label lacks that of " + where);
    }

    // --- Ties

    // How much a distance may change where a point moves by `error` in the chart: by differences.
    Fast slack(std::size_t item, Fast x, Fast y, Fast error) const {
        const Fast at = around_.distance(item, x, y);
        Fast most = 0;
        for (const auto& [dx, dy] : {std::pair<Fast, Fast>{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
            const Fast moved = around_.distance(item, x + dx * error, y + dy * error);
            if (std::isfinite(moved)) most = std::max(most, std::abs(moved - at));
        }
        return 2 * most;
    }

    /// Exactly the label's forms are nearest at a point that is `error` from where they tie.
    void check_ties(const std::string& where, std::span<const FormId> label, Fast x, Fast y, Fast error) {
        const Surroundings::Nearest best = around_.nearest(x, y);
        const Fast rounding = around_.tolerance() * (1 + best.distance / around_.scene_size());
        for (const FormId f : label) {
            const std::size_t item = around_.item(f);
            const Fast t = around_.distance(item, x, y);
            if (!(t - best.distance <= rounding + slack(item, x, y, error) + slack(best.item, x, y, error)))
                complain(where + " " + place(x, y) + ": " + to_string(f) + " is not nearest, by " +
                         std::to_string(static_cast<double>((t - best.distance) / around_.scene_size())) +
                         " of the box");
        }
        for (std::size_t i = 0; i < around_.size(); ++i) {
            const FormId f = around_.form(i);
            if (!f.valid() || includes(label, f)) continue;
            const Fast t = around_.distance(i, x, y);
            if (std::isinf(t)) continue;
            if (!(t - best.distance > rounding + slack(i, x, y, error) + slack(best.item, x, y, error)))
                complain(where + " " + place(x, y) + ": label " + name(label) + " lacks " + to_string(f));
        }
    }

    void check_vertex(VertexId v) {
        const auto& vertex = d_.vertices[v];
        const Fast x = vertex.point.x(), y = vertex.point.y();
        if (!(vertex.error < 1e-6 * (1 + std::hypot(x, y)))) return complain(to_string(v) + ": no place");
        check_ties(to_string(v), d_.label(v), x, y, vertex.error);
        if (!d_.sides(v).empty())
            for (const std::uint32_t side : d_.sides(v))
                if (std::abs(y - problem_.stretch[side == 0 ? 0 : 1]) >
                    2 * vertex.error + around_.tolerance())
                    complain(to_string(v) + ": is not on the rim");
        const HalfEdgeId h = dcel_.outgoing(v);
        if (!h.valid()) return;
        const HalfEdgeId g = dcel_.next_around_origin(h);
        if (g != h && dcel_.next_around_origin(g) == h && Dcel::edge(g) != Dcel::edge(h) &&
            std::ranges::equal(d_.label(v), d_.label(Dcel::edge(h))) && d_.sides(v).empty())
            complain(to_string(v) + ": divides an arc");
    }

    const RadialBaseProblem& problem_;
    Surroundings around_;
    const MinimizationDiagram& d_;
    const Dcel& dcel_;
};

}  // namespace vcell::radial
