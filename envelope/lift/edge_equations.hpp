/// What an edge's two sites say about it over a curved base: its kind, and the hyperplanes of (p, t) that a
/// conic lies in (sphere_conic.hpp, axial_conic.hpp).
#pragma once

#include <array>
#include <optional>

#include "axial_conic.hpp"
#include "based_diagram.hpp"
#include "sphere_conic.hpp"

namespace vcell::radial {

class EdgeEquations {
public:
    explicit EdgeEquations(const RadialDiagram& of, unsigned threads = 1);

    /// Decided exactly.
    CurveKind kind(EdgeId e) const { return kinds_[e]; }
    const IdVector<EdgeId, CurveKind>& kinds() const { return kinds_; }
    bool is_line(EdgeId e) const { return kinds_[e] == CurveKind::Line; }
    bool is_spline(EdgeId e) const { return kinds_[e] == CurveKind::Spline; }

    /// Forms have hyperplanes if they are circular, over a sphere.
    const Hyperplane& hyperplane(FormId f) const { return hyperplanes_[f]; }
    std::array<const Hyperplane*, 2> hyperplanes(EdgeId e) const {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        return {&hyperplanes_[edge.left], &hyperplanes_[edge.right]};
    }
    /// The equations of an edge's sites over a cylinder; none where a site has no such equation.
    std::optional<std::array<AxialEquation, 2>> axial(EdgeId e) const;
    /// Pre: a conic over a cylinder.
    AxialConic axial_conic(EdgeId e) const;

    /// The hyperplanes, left and right, of an edge that is a conic.
    std::array<DistancePlane, 2> planes(EdgeId e) const;

    /// The signs taken for the kinds.
    const Decisions& decisions() const { return decisions_; }

private:
    CurveKind find_kind(EdgeId e, SphereConicKind& conic_kind) const;
    CurveKind kind_over_cylinder(EdgeId e) const;
    bool is_line_over_cylinder(EdgeId e) const;
    bool is_along_axis(FormId f) const;

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const Hyperplanes hyperplanes_;
    IdVector<EdgeId, CurveKind> kinds_;
    Decisions decisions_;
};

}  // namespace vcell::radial
