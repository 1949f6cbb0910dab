/// Puts a cell together from a diagram and what a lift over its base makes of the elements. What is the same
/// over all bases is here: which sites an element has, how elements are numbered, what the report counts.
///
/// A Lift knows the mathematics of its base:
///
///     of()                             the diagram with its problem
///     vertex(v)                        LiftedVertex
///     add_rim_sites(v, sites)          those of the rims that the vertex lies on
///     bisector(form)                   its name
///     set_patches(face, patches)       the face's trimmed patches
///     kind(e)                          of the edge's curve
///     set_curve(e, ends, curve)        the curve, in world coordinates; LiftedEdgeErrors. ends: the greatest
///                                      error of the edge's vertices. Faces come before edges
///     finish(cell)                     what else belongs to vertices and edges
///     measure(positions, cell)         measures, from the edges' `curve` errors
///     decisions()                      the signs that it has taken
///
/// and, if vertex(), set_patches(), kind() and set_curve() may be called for different elements at a time,
/// those of a task (core/threads.hpp) by one thread, `static constexpr bool is_shareable = true`.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../core/small_vector.hpp"
#include "../../core/threads.hpp"
#include "../measures/measures.hpp"
#include "based_diagram.hpp"
#include "joined_spans.hpp"
#include "lift.hpp"

namespace vcell {

struct LiftedVertex {
    Vec3 point;  ///< canonical
    double clearance;
    double error;  ///< bound on the distance from the true vertex
};

struct LiftedEdgeErrors {
    double curve;  ///< bound on the distance of the curve from the true edge
    double edge;   ///< the same with its trims on both sides
};

template <class Lift>
class CellAssembly {
public:
    explicit CellAssembly(Lift& lift, unsigned threads = 1)
        : lift_(lift),
          of_(lift.of()),
          problem_(of_.problem),
          diagram_(of_.diagram),
          threads_(is_shareable ? threads : 1) {}

    LiftedCell operator()(bool with_measures) {
        add_vertices();
        add_faces();
        add_edges();
        lift_.finish(cell_);
        if (with_measures)
            lift_.measure(positions_, cell_);
        else
            rank_neighbors(cell_);
        cell_.report.decisions = diagram_.decisions;
        cell_.report.decisions += lift_.decisions();
        return {std::move(cell_), std::move(positions_)};
    }

private:
    static constexpr bool is_shareable = requires { Lift::is_shareable; };

    // set(i, element) for elements 0, 1, ... of a list.
    template <class Element, class Set>
    void fill(std::vector<Element>& list, std::size_t size, const Set& set) const {
        list.reserve(size);
        touch_room(list);
        for (std::size_t i = 0; i < size; ++i) append_new(list);
        for_ranges(size, threads_, [&](std::size_t begin, std::size_t end) {
            for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) set(i, list[i]);
        });
    }

    // A system hands out memory where it is first written, which takes longer than the elements do: all
    // threads write a byte of each page.
    template <class Element>
    void touch_room(std::vector<Element>& list) const {
        constexpr std::size_t page = 4096;
        auto* const bytes = reinterpret_cast<volatile std::byte*>(list.data());
        if (threads_ == 1) return;
        for_ranges(list.capacity() * sizeof(Element) / page, threads_,
                   [&](std::size_t begin, std::size_t end) {
                       for (std::size_t i = begin; i < end; ++i) bytes[i * page] = std::byte{0};
                   });
    }

    void add_vertices() {
        fill(cell_.vertices, diagram_.vertices.size(),
             [this](std::uint32_t v, CellVertex& vertex) { set_vertex(VertexId{v}, vertex); });
    }

    void set_vertex(VertexId v, CellVertex& vertex) const {
        const LiftedVertex lifted = lift_.vertex(v);
        vertex.point = problem_.frame.to_world(lifted.point);
        vertex.radius = lifted.clearance;
        vertex.error = lifted.error;
        for (const FormId f : diagram_.label(v))
            for (const Site site : problem_.sites[f]) vertex.sites.push_back(site);
        lift_.add_rim_sites(v, vertex.sites);
        sort_unique(vertex.sites);
    }

    void add_faces() {
        std::vector<FaceId> faces;
        faces.reserve(diagram_.face_forms.size());
        for (const FaceId id : diagram_.face_forms.ids())
            if (diagram_.face_forms[id].valid()) faces.push_back(id);
        fill(cell_.faces, faces.size(), [&](std::uint32_t i, CellFace& face) { set_face(faces[i], face); });
    }

    void set_face(FaceId id, CellFace& face) {
        const FormId form = diagram_.face_forms[id];
        face.site = of_.main_site(form);
        face.extra_sites.assign(problem_.sites[form].begin() + 1, problem_.sites[form].end());
        face.bisector = lift_.bisector(form);
        lift_.set_patches(id, face.patches);
    }

    void add_edges() {
        positions_.resize(diagram_.edges.size());
        fill(cell_.edges, diagram_.edges.size(),
             [this](std::uint32_t e, CellEdge& edge) { set_edge(EdgeId{e}, edge); });
    }

    void set_edge(EdgeId e, CellEdge& edge) {
        edge.sites = of_.sites(e);
        if (of_.is_bare(e)) return;
        for (const FormId f : diagram_.label(e))
            for (const Site site : problem_.sites[f])
                if (site != edge.sites[0] && site != edge.sites[1]) edge.extra_sites.push_back(site);
        sort_unique(edge.extra_sites);
        double ends = 0;
        if (const VertexId start = diagram_.start(e); start.valid()) {
            edge.vertices = {start.value, diagram_.end(e).value};
            for (const std::uint32_t v : edge.vertices) ends = std::max(ends, cell_.vertices[v].error);
        }
        edge.kind = lift_.kind(e);
        const LiftedEdgeErrors errors = lift_.set_curve(e, ends, edge.curve);
        positions_[e] = errors.curve;
        edge.error = errors.edge;
    }

    Lift& lift_;
    const decltype(std::declval<Lift&>().of()) of_;
    const decltype(of_.problem)& problem_;
    const MinimizationDiagram& diagram_;
    const unsigned threads_;
    Cell cell_;
    IdVector<EdgeId, double> positions_;
};

}  // namespace vcell
