/// The curves of edges in space, over any base, canonical: lines between their vertices, conics through (p,
/// t), splines.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "../cell.hpp"
#include "../diagram/minimization_diagram.hpp"
#include "conic_span.hpp"
#include "space_spline.hpp"

namespace vcell {

class EdgeCurves {
public:
    /// Knows the lines only; conics and splines are set later, and kinds and the vertices' (p, t) are looked
    /// up when they are asked for. has_splines: may there be any?
    EdgeCurves(const MinimizationDiagram& diagram, const IdVector<EdgeId, CurveKind>& kinds,
               const IdVector<VertexId, Eigen::Vector4d>& points, bool has_splines)
        : diagram_(diagram), kinds_(kinds), points_(points) {
        const std::size_t edges = diagram_.edges.size();
        conics_.reserve(2 * edges);
        slices_.resize(edges);
        if (!has_splines) return;
        splines_.resize(edges);
        errors_.resize(edges);
    }

    bool is_line(EdgeId e) const { return kinds_[e] == CurveKind::Line; }
    bool is_spline(EdgeId e) const { return kinds_[e] == CurveKind::Spline; }
    /// Between two vertices, or closed?
    bool has_ends(EdgeId e) const { return diagram_.start(e).valid(); }
    /// Pre: has_ends().
    const Eigen::Vector4d& from(EdgeId e) const { return points_[diagram_.start(e)]; }
    const Eigen::Vector4d& to(EdgeId e) const { return points_[diagram_.end(e)]; }

    /// A conic's spans in the direction of half-edge 2e.
    std::span<const ConicSpan> conics(EdgeId e) const {
        return {conics_.data() + slices_[e].first, conics_.data() + slices_[e].last};
    }
    /// A spline's spans, likewise.
    const std::vector<SpaceSpan>& splines(EdgeId e) const { return splines_[e]; }
    const SpaceFitError& fit_error(EdgeId e) const { return errors_[e]; }
    /// The number of spans, and their degree.
    std::size_t size(EdgeId e) const {
        return is_line(e) ? 1 : is_spline(e) ? splines_[e].size() : conics(e).size();
    }
    int degree(EdgeId e) const { return is_line(e) ? 1 : is_spline(e) ? 5 : 2; }
    /// The greatest t that curves tell of: of conics where spans begin, of splines in their control points.
    double reach() const;

    /// add(spans) appends an edge's conics.
    template <class Add>
    void set_conics(EdgeId e, Add&& add) {
        const auto first = static_cast<std::uint32_t>(conics_.size());
        add(conics_);
        slices_[e] = {first, static_cast<std::uint32_t>(conics_.size())};
    }
    /// fit(spans) appends an edge's spline and says how good it is.
    template <class Fit>
    void set_spline(EdgeId e, Fit&& fit) {
        splines_[e].clear();
        errors_[e] = fit(splines_[e]);
    }

    /// Calls add(p, w) with the control points of all spans, joined: the last one of each is the next one's
    /// first.
    template <class Add>
    void for_controls(EdgeId e, Add&& add) const {
        if (is_line(e)) {
            add(Vec3(from(e).head<3>()), 1.0);
            add(Vec3(to(e).head<3>()), 1.0);
        } else if (is_spline(e)) {
            bool is_first = true;
            for (const SpaceSpan& span : splines_[e]) {
                for (int k = is_first ? 0 : 1; k < 6; ++k) add(Vec3(span.points.col(k).head<3>()), 1.0);
                is_first = false;
            }
        } else {
            add(Vec3(conics(e).front().from.head<3>()), 1.0);
            for (const ConicSpan& span : conics(e)) {
                add(Vec3(span.middle.head<3>() / span.weight), span.weight);
                add(Vec3(span.to.head<3>()), 1.0);
            }
        }
    }
    /// Makes the edge's curve in world coordinates, on [0, 1] with uniform knots.
    void to_world(EdgeId e, const BaseFrame& frame, RationalCurve3& curve) const;

private:
    struct Slice {
        std::uint32_t first = 0, last = 0;
    };

    const MinimizationDiagram& diagram_;
    const IdVector<EdgeId, CurveKind>& kinds_;
    const IdVector<VertexId, Eigen::Vector4d>& points_;
    std::vector<ConicSpan> conics_;
    IdVector<EdgeId, Slice> slices_;  // of conics_
    IdVector<EdgeId, std::vector<SpaceSpan>> splines_;
    IdVector<EdgeId, SpaceFitError> errors_;
};

}  // namespace vcell
