/// A disc diagram as a minimization diagram in the stereographic chart: edges that are points and faces
/// without width are contracted, and labels get all forms that tie.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "../../core/octree_path.hpp"
#include "../../core/partition.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "disc_arcs.hpp"
#include "disc_marks.hpp"

namespace vcell::discs {

class DiscResult : protected DiscMarks {
protected:
    using DiscMarks::DiscMarks;

    // Forms follow each other along a path by the directions in which they are lowest.
    static double place_on_path(const Linear& form) {
        return form.b.isZero(0) ? 0 : octree_path(-form.b / form.slope);
    }

    // Faces after the pole's on the path, edges and vertices as they are met around faces: what comes after
    // then finds neighbours near each other in memory.
    std::optional<MinimizationDiagram> diagram(Index pole_face) {
        if (!unite_vertices() || !unite_edges()) return std::nullopt;
        std::vector<std::pair<double, Index>> faces;
        faces.reserve(vertices_.size() / 2 + 2);  // Euler: V - E + F = 2, 2 E = 3 V
        for (Index f = 0; f < family_.size(); ++f)
            if (faces_[f].start != none && !is_point(f) && !is_sliver(f))
                faces.emplace_back(f == pole_face ? -1 : place_on_path(forms_[f]), f);
        std::ranges::sort(faces);

        MinimizationDiagram out;
        out.forms = family_.forms;
        const std::size_t edge_count = edges_.size() - free_edges_.size(),
                          vertex_count = vertices_.size() - free_vertices_.size();
        out.dcel.reserve(vertex_count, edge_count, faces.size());
        out.vertices.reserve(vertex_count);
        out.edges.reserve(edge_count);
        out.edge_labels_.reserve(2 * edge_count);
        out.edge_offsets_.reserve(edge_count + 1);
        out.vertex_labels_.reserve(3 * vertex_count);
        out.vertex_offsets_.reserve(vertex_count + 1);
        out.face_forms.reserve(faces.size());
        std::vector<Index> vertex_map(vertices_.size(), none), edge_map(edges_.size(), none);
        for (const auto& [place, f] : faces) {
            Index h = faces_[f].start;
            do {
                if (edge_map[h >> 1] == none && !is_within_point(h) &&
                    !add_edge(out, h, vertex_map, edge_map))
                    return std::nullopt;
                h = half_edges_[h].next;
            } while (h != faces_[f].start);
        }
        out.edge_offsets_.push_back(static_cast<std::uint32_t>(out.edge_labels_.size()));
        out.vertex_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_labels_.size()));
        out.side_offsets_.assign(out.vertices.size() + 1, 0);

        const auto half_edge = [&](Index h) { return HalfEdgeId{edge_map[h >> 1] ^ (h & 1u)}; };
        for (const auto& [place, f] : faces) {
            for_boundary(f, [&](Index h) {
                if (is_within_point(h)) return;
                Index next = half_edges_[h].next;
                while (is_within_point(next)) next = half_edges_[next].next;
                out.dcel.link(half_edge(h), half_edge(next));
            });
            Index start = faces_[f].start;
            while (is_within_point(start)) start = half_edges_[start].next;
            if (f == pole_face)
                out.dcel.add_inner_ccb(Dcel::unbounded_face(), half_edge(start));
            else
                out.dcel.add_outer_ccb(out.dcel.add_face(), half_edge(start));
            out.face_forms.push_back(FormId{f});
        }
        if (!slivers_.empty() && has_bends(out)) return std::nullopt;
        out.decisions = decisions_;
        out.decisions += kernel_.decisions();
        return out;
    }

    // The diagram as it lies on the sphere, which is all that is left of it. Arcs that are as good as points,
    // but are not known to be, stay. False where that is no common case.
    bool set_arcs(DiscArcs& out) {
        if (!unite_vertices() || !unite_edges()) return false;
        out.faces.clear();
        out.faces.reserve(vertices_.size() / 2 + 2);
        for (Index f = 0; f < family_.size(); ++f)
            if (faces_[f].start != none && !is_point(f) && !is_sliver(f)) out.faces.push_back(FormId{f});
        out.vertices.resize(vertices_.size());
        for (Index v = 0; v < vertices_.size(); ++v) out.vertices[v] = {vertices_[v].p, vertices_[v].error};
        out.arcs.clear();
        out.arcs.reserve(edges_.size());
        for (Index e = 0; e < edges_.size(); ++e) {
            const Edge& edge = edges_[e];
            if (edge.apex.is_gone() || edge.is_point) continue;
            const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;
            const bool is_short = edge.apex.doubt < HUGE_VAL;
            if (!is_short && !is_long(e)) return false;
            constexpr double near = 0x1p-19;
            const double chord = (vertices_[from].p - vertices_[to].p).norm();
            out.arcs.push_back({FormId{left(2 * e)}, FormId{right(2 * e)}, from, to, edge.normal, edge.offset,
                                edge.square, edge.length, edge.error, is_short,
                                is_short && chord < near ? edge.apex.error + chord : HUGE_VAL});
        }
        out.forms = std::move(forms_);
        return true;
    }

private:
    // Chart point and height of a vertex. Towards the pole 1 + z is found without cancellation; moving by d
    // on the sphere moves the chart point by d W / 2.
    std::optional<MinimizationDiagram::Vertex> chart_vertex(const Vertex& v) const {
        const Vector3d& p = v.p;
        const double across = p.x() * p.x() + p.y() * p.y();
        const double scale = p.z() < 0 ? (1 - p.z()) / across : 1 / (1 + p.z());
        MinimizationDiagram::Vertex out;
        out.point = scale * p.head<2>();
        const double reach2 = out.point.squaredNorm(), reach = std::sqrt(reach2), W = 1 + reach2;
        constexpr double most_error = 0x1p-10;  // for which second orders are within the factors below
        if (!(W * v.error < most_error)) return std::nullopt;
        out.error = W * v.error + 8 * u * reach;
        out.height = W * v.height;
        out.height_error =
            1.01 * W * (v.doubt + 2 * reach * std::abs(v.height) * v.error) + 16 * u * W * std::abs(v.height);
        return out;
    }
    // Are there vertices in which fewer than three edges end?
    static bool has_bends(const MinimizationDiagram& diagram) {
        IdVector<VertexId, int> degree(diagram.vertices.size(), 0);
        for (const EdgeId e : diagram.edges.ids())
            for (const HalfEdgeId h : {HalfEdgeId{2 * e.value}, HalfEdgeId{2 * e.value + 1}})
                ++degree[diagram.dcel.origin(h)];
        return std::ranges::any_of(degree, [](int edges) { return edges < 3; });
    }
    // Edges are looked at only where any of them is a point.
    bool is_within_point(Index h) const { return has_points_ && edges_[h >> 1].is_point; }
    bool is_point(Index face) const {
        bool is = has_points_;
        if (is) for_boundary(face, [&](Index h) { is = is && is_within_point(h); });
        return is;
    }
    // The one of the vertices in a vertex's place that stands for all of them.
    Index place(Index v) { return places_.size() == 0 ? v : places_.find(v); }
    // Finds the vertices that are one point, and all forms that tie there. False where an edge is closed in
    // one, or a face meets itself, and where that is not known.
    bool unite_vertices() {
        const auto is_alive = [&](Index e) { return !edges_[e].apex.is_gone(); };
        if (ties_.empty()) return true;
        for (Index e = 0; e < edges_.size(); ++e) {
            if (!is_alive(e) || edges_[e].is_point) continue;
            if (are_one_point(vertices_[half_edges_[2 * e].origin],
                              vertices_[half_edges_[2 * e + 1].origin]) != false)
                return false;
        }
        places_ = Partition(vertices_.size());
        const auto ends = [&](Index e) {
            return std::array{place(half_edges_[2 * e].origin), place(half_edges_[2 * e + 1].origin)};
        };
        for (Index e = 0; e < edges_.size(); ++e) {
            if (!is_alive(e) || !edges_[e].is_point) continue;
            const auto [p, q] = ends(e);
            places_.merge(p, q);
        }
        for (Index e = 0; e < edges_.size(); ++e) {
            if (!is_alive(e) || edges_[e].is_point) continue;
            const auto [p, q] = ends(e);
            if (p == q) return false;
        }
        for (const Face& f : faces_) {
            if (f.start == none) continue;
            met_.clear();
            for_boundary(static_cast<Index>(&f - faces_.data()), [&](Index h) {
                if (!edges_[h >> 1].is_point) met_.push_back(place(half_edges_[h].origin));
            });
            std::ranges::sort(met_);
            if (std::ranges::adjacent_find(met_) != met_.end()) return false;
        }
        for (Index v = 0; v < vertices_.size(); ++v)
            if (!vertices_[v].is_gone() && (place(v) != v || vertices_[v].ties != none)) tied_[place(v)];
        for (Index v = 0; v < vertices_.size() && !tied_.empty(); ++v) {
            if (vertices_[v].is_gone()) continue;
            const auto here = tied_.find(place(v));
            if (here == tied_.end()) continue;
            std::vector<Index>& forms = here->second;
            forms.insert(forms.end(), vertices_[v].forms.begin(), vertices_[v].forms.end());
            if (const Index ties = vertices_[v].ties; ties != none)
                forms.insert(forms.end(), ties_[ties].forms.begin(), ties_[ties].forms.end());
        }
        for (auto& [v, forms] : tied_) sort_once(forms);
        return true;
    }
    static void sort_once(std::vector<Index>& forms) {
        std::ranges::sort(forms);
        forms.erase(std::ranges::unique(forms).begin(), forms.end());
    }
    // Finds the faces without width, and all forms that tie along edges, which tie in their ends, too: also
    // along edges that others have cut down to a point. False where that is not known.
    bool unite_edges() {
        if (ties_.empty()) return true;
        for (Index f = 0; f < family_.size(); ++f) {
            if (faces_[f].start == none) continue;
            std::array<Index, 2> sides{none, none};
            std::size_t count = 0;
            for_boundary(f, [&](Index h) {
                if (edges_[h >> 1].is_point) return;
                if (count < 2) sides[count] = h;
                ++count;
            });
            if (count != 2) continue;
            const Edge &first = edges_[sides[0] >> 1], &second = edges_[sides[1] >> 1];
            // Both sides take the same of the two ways from end to end.
            const bool is_same_way =
                (first.normal.dot(second.normal) < 0) == ((sides[0] & 1u) == (sides[1] & 1u));
            const auto is_one_circle = are_on_one_circle(f, right(sides[0]), right(sides[1]));
            if (!is_one_circle) return false;
            if (!*is_one_circle) continue;
            if (!is_same_way) return false;
            slivers_[f] = sides;
        }
        for (Index e = 0; e < edges_.size(); ++e) {
            if (edges_[e].apex.is_gone() || edges_[e].ties == none) continue;
            for (const Index h : {2 * e, 2 * e + 1}) {
                const Index v = place(half_edges_[h].origin);
                std::vector<Index>& forms = tied_[v];
                const auto& here = vertices_[v].forms;
                forms.insert(forms.end(), here.begin(), here.end());
                const std::vector<Index>& ties = ties_[edges_[e].ties].forms;
                forms.insert(forms.end(), ties.begin(), ties.end());
                sort_once(forms);
            }
        }
        return true;
    }
    bool is_sliver(Index face) const { return !slivers_.empty() && slivers_.contains(face); }
    // The half-edge of a sliver on the other side of it. Pre: a sliver is on the right.
    Index beyond(Index h) const {
        const auto& sides = slivers_.find(right(h))->second;
        return sides[0] == twin(h) ? sides[1] : sides[0];
    }
    // The half-edge on the other side of this one and of all slivers beside it.
    Index across(Index h) const {
        while (is_sliver(right(h))) h = beyond(h);
        return twin(h);
    }
    // Adds the edge of which h is the half-edge of a face that is no sliver.
    bool add_edge(MinimizationDiagram& out, Index h, std::vector<Index>& vertex_map,
                  std::vector<Index>& edge_map) {
        const Index opposite = across(h);
        const bool is_even = (h & 1u) == 0;
        const Index first = is_even ? h : opposite, second = is_even ? opposite : h;
        std::array<VertexId, 2> ends;
        for (const Index side : {0u, 1u}) {
            const Index v = place(half_edges_[side == 0 ? first : second].origin);
            if (vertex_map[v] == none) {
                if (!add_vertex(out, v)) return false;
                vertex_map[v] = out.dcel.add_vertex().value;
            }
            ends[side] = {vertex_map[v]};
        }
        const Index e = out.dcel.add_edge(ends[0], ends[1]).value;
        edge_map[first >> 1] = 2 * e ^ (first & 1u);
        edge_map[second >> 1] = (2 * e + 1) ^ (second & 1u);
        out.edges.push_back({FormId{left(first)}, FormId{left(second)}});
        out.edge_offsets_.push_back(static_cast<std::uint32_t>(out.edge_labels_.size()));
        if (opposite == twin(h) && edges_[h >> 1].ties == none) {
            out.edge_labels_.push_back(std::min(FormId{left(first)}, FormId{left(second)}));
            out.edge_labels_.push_back(std::max(FormId{left(first)}, FormId{left(second)}));
        } else {
            for (const Index f : forms_along(h)) out.edge_labels_.push_back(FormId{f});
        }
        return true;
    }
    // All forms that tie along the edges of the slivers beside h, and along that of h.
    std::vector<Index> forms_along(Index h) const {
        std::vector<Index> forms{left(h)};
        while (true) {
            forms.push_back(right(h));
            if (const Index ties = edges_[h >> 1].ties; ties != none)
                forms.insert(forms.end(), ties_[ties].forms.begin(), ties_[ties].forms.end());
            if (!is_sliver(right(h))) break;
            h = beyond(h);
        }
        sort_once(forms);
        return forms;
    }
    bool add_vertex(MinimizationDiagram& out, Index v) const {
        const auto vertex = chart_vertex(vertices_[v]);
        if (!vertex) return false;
        out.vertices.push_back(*vertex);
        out.vertex_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_labels_.size()));
        const auto add_labels = [&](auto forms) {
            std::ranges::sort(forms);
            for (const Index f : forms) out.vertex_labels_.push_back(FormId{f});
        };
        if (const auto tied = tied_.find(v); tied != tied_.end())
            add_labels(tied->second);
        else
            add_labels(vertices_[v].forms);
        return true;
    }

    // The result has for each vertex one in the same place (none if all are apart), and the forms where they
    // are more than three.
    Partition places_;
    std::vector<Index> met_;
    std::map<Index, std::vector<Index>> tied_;
    std::map<Index, std::array<Index, 2>> slivers_;  // faces without width, and their sides
};

}  // namespace vcell::discs
