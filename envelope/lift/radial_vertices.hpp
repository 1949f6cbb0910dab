/// A diagram's vertices in space, over a sphere or a cylinder base.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "based_diagram.hpp"
#include "edge_equations.hpp"
#include "space_arc.hpp"

namespace vcell::radial {

/// The wall at an end of a cylinder's stretch.
SpaceSite end_wall(const RadialBaseProblem& problem, std::uint32_t side);

class RadialVertices {
public:
    RadialVertices(const RadialDiagram& of, const EdgeEquations& equations, unsigned threads = 1);

    /// (p, t), canonical.
    const Eigen::Vector4d& operator[](VertexId v) const { return points_[v]; }
    const IdVector<VertexId, Eigen::Vector4d>& points() const { return points_; }
    Vec3 point(VertexId v) const { return points_[v].head<3>(); }
    /// A bound on the distance from the true vertex.
    double error(VertexId v) const { return errors_[v]; }
    /// What a fit is told of an edge's end: none where the edge is closed.
    std::optional<SpaceEnd> end(VertexId v) const {
        if (!v.valid()) return std::nullopt;
        return SpaceEnd{point(v), error(v)};
    }
    /// The greatest t.
    double reach() const;

private:
    struct Vertex {
        Eigen::Vector4d point;
        double error;
    };

    Vertex lifted(VertexId v, const EdgeEquations& equations) const;
    double chart_error(const MinimizationDiagram::Vertex& v, double t) const;
    std::optional<SpaceEnd> settled(VertexId v, const SpaceEnd& near) const;

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    double origin_;  // how far the frame's is from the world's
    IdVector<VertexId, Eigen::Vector4d> points_;
    IdVector<VertexId, double> errors_;
};

}  // namespace vcell::radial
