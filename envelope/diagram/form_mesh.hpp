/// A subdivision under construction that knows what its elements stand for: the form of each face, the forms
/// on both sides of each edge, what else ties along edges and in vertices, and in which boxes arcs of
/// cylinders run.
///
/// Faces may be united, and then have one form; edges and vertices that are no more stay as dead rows.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "../../arrangement/dcel/half_edge_mesh.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/partition.hpp"
#include "../../primitives/forms/form_family.hpp"

namespace vcell {

struct FormHalfEdge {
    std::uint32_t next, prev, origin, face;
};

class FormMesh : public HalfEdgeMesh<FormHalfEdge> {
public:
    struct Vertex {
        double x, y, error, height, height_error;
        FormId lowest;  ///< whose height is to be enclosed, if the vertex stays: most of them lie on seams
        bool alive = true;
        Index out = none;
        Index isolated_in = none;
        Index ties = none;
    };
    /// A piece of an arc with a cylinder (MinimizationDiagram::ArcPiece) that knows both its ends.
    struct Link {
        Eigen::Vector2d from, to;
        double from_error, to_error;
        Eigen::Vector2d direction;
        std::array<double, 4> box;

        Link reversed() const { return {to, from, to_error, from_error, -direction, box}; }
    };
    struct Edge {
        FormId left, right;  ///< of half-edge 2e; rim: left only
        std::uint32_t side = UINT32_MAX;
        Index ties = none;
        Index links = none;  ///< in the direction of half-edge 2e
        bool alive = true;
    };

    const std::vector<Vertex>& vertices() const { return vertices_; }
    const std::vector<Edge>& edges() const { return edges_; }
    /// Vertices without edges, of which some may be no more.
    const std::vector<Index>& isolated() const { return isolated_; }
    const std::vector<FormId>& ties(Index list) const { return ties_[list]; }
    std::span<const Link> links(Index e) const {
        if (edges_[e].links == none) return {};
        return links_[edges_[e].links];
    }
    /// Faces from 0 on, with those that have been united with others.
    std::size_t face_count() const { return face_sites_.size(); }
    FormId site(Index face) const { return face_sites_[face]; }
    /// The face that stands for all that have been united with it: the first one of them.
    Index united(Index face) const { return united_faces_.find(face); }

    FormId left_of(Index h) const { return h & 1u ? edges_[h >> 1].right : edges_[h >> 1].left; }
    std::vector<FormId> label_of_edge(Index e) const;

    struct ChartBox {
        Interval x, y;
    };
    /// What shows nowhere but where it ties with two others.
    struct HiddenTie {
        FormId form;
        /// The form may tie wherever these two do.
        std::array<FormId, 2> between;
        /// Does it, where they do in the box? None if that is not told. Empty: it does everywhere.
        std::function<std::optional<bool>(const ChartBox&)> is_tie;
    };
    /// Names what ties along edges and in vertices without a face beside them. What is so in one place of an
    /// edge is to be so all along it: one box in which it is told is enough. False if there is none for some
    /// edge or vertex.
    bool tie_hidden(std::span<const HiddenTie> ties);

protected:
    /// Seams included: growing by copies costs more than address space.
    void reserve(std::size_t forms);

    Index add_face(FormId site) {
        face_sites_.push_back(site);
        return united_faces_.add();
    }
    Index add_ties(std::vector<FormId> forms);
    /// All forms that are known to attain the minimum in the origin of a half-edge.
    std::vector<FormId> label_of_origin(Index h) const;
    void merge_faces(Index f, Index g);
    /// Removes v if it only continues one arc: two edges of one curve and one label, and nothing else that
    /// attains the minimum at v.
    void smooth(Index v);
    /// Takes over what is alive of another one, in its order; `moved` is told what its half-edge becomes.
    Index take(FormMesh&& part, Index half_edge);
    /// Throws, in builds with asserts, if the mesh has a defect; faces count as united.
    void require_soundness();

    std::vector<Vertex> vertices_;
    std::vector<Edge> edges_;
    std::vector<std::vector<FormId>> ties_;
    std::vector<std::vector<Link>> links_;
    std::vector<Index> isolated_;

private:
    template <class BoxesOf>
    static bool add_hidden(std::span<const HiddenTie> ties, std::vector<FormId>& label, BoxesOf&& boxes);
    void join_links(Index edge, Index other, bool other_first, bool reverse_other);

    std::vector<FormId> face_sites_;
    mutable Partition united_faces_;
};

}  // namespace vcell
