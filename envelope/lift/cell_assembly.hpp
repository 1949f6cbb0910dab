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
#pragma once

#include <algorithm>
#include <utility>

#include "../../core/small_vector.hpp"
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
    explicit CellAssembly(Lift& lift)
        : lift_(lift), of_(lift.of()), problem_(of_.problem), diagram_(of_.diagram) {}

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
    void add_vertices() {
        cell_.vertices.reserve(diagram_.vertices.size());
        for (const VertexId v : diagram_.vertices.ids()) {
            CellVertex& vertex = append_new(cell_.vertices);
            const LiftedVertex lifted = lift_.vertex(v);
            vertex.point = problem_.frame.to_world(lifted.point);
            vertex.radius = lifted.clearance;
            vertex.error = lifted.error;
            for (const FormId f : diagram_.label(v))
                for (const Site site : problem_.sites[f]) vertex.sites.push_back(site);
            lift_.add_rim_sites(v, vertex.sites);
            sort_unique(vertex.sites);
        }
    }

    void add_faces() {
        cell_.faces.reserve(diagram_.face_forms.size());
        for (const FaceId id : diagram_.face_forms.ids()) {
            const FormId form = diagram_.face_forms[id];
            if (!form.valid()) continue;
            CellFace& face = append_new(cell_.faces);
            face.site = of_.main_site(form);
            face.extra_sites.assign(problem_.sites[form].begin() + 1, problem_.sites[form].end());
            face.bisector = lift_.bisector(form);
            lift_.set_patches(id, face.patches);
        }
    }

    void add_edges() {
        cell_.edges.reserve(diagram_.edges.size());
        positions_.reserve(diagram_.edges.size());
        for (const EdgeId e : diagram_.edges.ids()) {
            CellEdge& edge = append_new(cell_.edges);
            edge.sites = of_.sites(e);
            if (of_.is_bare(e)) {
                positions_.push_back(0);
                continue;
            }
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
            positions_.push_back(errors.curve);
            edge.error = errors.edge;
        }
    }

    Lift& lift_;
    const decltype(std::declval<Lift&>().of()) of_;
    const decltype(of_.problem)& problem_;
    const MinimizationDiagram& diagram_;
    Cell cell_;
    IdVector<EdgeId, double> positions_;
};

}  // namespace vcell
