/// The curves of edges in space, over any base, canonical: lines between their vertices, conics through (p,
/// t), splines.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "../../core/threads.hpp"
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
        const auto& [task, first, last] = slices_[e];
        return {conics_[task].data() + first, conics_[task].data() + last};
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

    /// add(e, spans) appends the conics of every edge, or none; it is called for those of a task
    /// (core/threads.hpp) by one thread.
    template <class Add>
    void set_all_conics(unsigned threads, const Add& add) {
        const std::size_t edges = slices_.size();
        conics_.resize(range_count(edges) + 1);
        for_ranges(edges, threads, [&](std::size_t begin, std::size_t end, std::size_t task) {
            conics_[task].reserve(2 * (end - begin));
            for (auto e = EdgeId{static_cast<std::uint32_t>(begin)}; e.value < end; ++e.value)
                append(e, task, [&](std::vector<ConicSpan>& spans) { add(e, spans); });
        });
    }
    /// add(spans) appends an edge's conics, and those it had are gone.
    template <class Add>
    void set_conics(EdgeId e, Add&& add) {
        append(e, conics_.size() - 1, add);
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
    // Which of a task's conics are an edge's.
    struct Slice {
        std::uint32_t task = 0, first = 0, last = 0;
    };

    template <class Add>
    void append(EdgeId e, std::size_t task, Add&& add) {
        std::vector<ConicSpan>& spans = conics_[task];
        const auto first = static_cast<std::uint32_t>(spans.size());
        add(spans);
        slices_[e] = {static_cast<std::uint32_t>(task), first, static_cast<std::uint32_t>(spans.size())};
    }

    const MinimizationDiagram& diagram_;
    const IdVector<EdgeId, CurveKind>& kinds_;
    const IdVector<VertexId, Eigen::Vector4d>& points_;
    std::vector<std::vector<ConicSpan>> conics_{1};  // of each task, and last what is set later
    IdVector<EdgeId, Slice> slices_;
    IdVector<EdgeId, std::vector<SpaceSpan>> splines_;
    IdVector<EdgeId, SpaceFitError> errors_;
};

}  // namespace vcell
