/// The curves of edges over a sphere or a cylinder base, canonical: lines between their vertices, conics
/// through (p, t), splines.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "based_diagram.hpp"
#include "conic_span.hpp"
#include "edge_equations.hpp"
#include "radial_vertices.hpp"
#include "space_spline.hpp"

namespace vcell::radial {

class RadialCurves {
public:
    /// Knows the lines only; conics and splines are set later.
    RadialCurves(const RadialDiagram& of, const RadialVertices& vertices, const EdgeEquations& equations)
        : diagram_(of.diagram), vertices_(vertices), equations_(equations) {
        const std::size_t edges = diagram_.edges.size();
        conics_.reserve(2 * edges);
        slices_.resize(edges);
        if (of.problem.family.is_all_circular()) return;
        splines_.resize(edges);
        errors_.resize(edges);
    }

    const EdgeEquations& equations() const { return equations_; }
    const RadialVertices& vertices() const { return vertices_; }
    bool is_line(EdgeId e) const { return equations_.is_line(e); }
    bool is_spline(EdgeId e) const { return equations_.is_spline(e); }
    /// A conic over a cylinder base: there no form is circular.
    bool is_axial_conic(EdgeId e) const {
        return !is_line(e) && !is_spline(e) && !diagram_.is_circular(diagram_.edges[e].left);
    }
    /// Between two vertices, or closed?
    bool has_ends(EdgeId e) const { return diagram_.start(e).valid(); }
    /// Pre: has_ends().
    const Eigen::Vector4d& from(EdgeId e) const { return vertices_[diagram_.start(e)]; }
    const Eigen::Vector4d& to(EdgeId e) const { return vertices_[diagram_.end(e)]; }

    /// A conic's spans in the direction of half-edge 2e.
    std::span<const ConicSpan> conics(EdgeId e) const {
        return {conics_.data() + slices_[e].first, conics_.data() + slices_[e].last};
    }
    /// A spline's spans, likewise.
    const std::vector<SpaceSpan>& splines(EdgeId e) const { return splines_[e]; }
    const SpaceFitError& fit_error(EdgeId e) const { return errors_[e]; }
    /// The number of spans.
    std::size_t size(EdgeId e) const {
        return is_line(e) ? 1 : is_spline(e) ? splines_[e].size() : conics(e).size();
    }
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

    /// Makes the edge's curve in world coordinates, on [0, 1] with uniform knots.
    void to_world(EdgeId e, const BaseFrame& frame, RationalCurve3& curve) const;

private:
    struct Slice {
        std::uint32_t first = 0, last = 0;
    };

    const MinimizationDiagram& diagram_;
    const RadialVertices& vertices_;
    const EdgeEquations& equations_;
    std::vector<ConicSpan> conics_;
    IdVector<EdgeId, Slice> slices_;  // of conics_
    IdVector<EdgeId, std::vector<SpaceSpan>> splines_;
    IdVector<EdgeId, SpaceFitError> errors_;
};

}  // namespace vcell::radial
