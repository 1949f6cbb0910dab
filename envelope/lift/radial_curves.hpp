/// The curves of edges over a sphere or a cylinder base, with what tells them: the edges' equations and
/// vertices.
#pragma once

#include "based_diagram.hpp"
#include "edge_curves.hpp"
#include "edge_equations.hpp"
#include "radial_vertices.hpp"

namespace vcell::radial {

class RadialCurves : public EdgeCurves {
public:
    RadialCurves(const RadialDiagram& of, const RadialVertices& vertices, const EdgeEquations& equations)
        : EdgeCurves(of.diagram, equations.kinds(), vertices.points(), !of.problem.family.is_all_circular()),
          diagram_(of.diagram),
          vertices_(vertices),
          equations_(equations) {}

    const EdgeEquations& equations() const { return equations_; }
    const RadialVertices& vertices() const { return vertices_; }
    /// A conic over a cylinder base: there no form is circular.
    bool is_axial_conic(EdgeId e) const {
        return !is_line(e) && !is_spline(e) && !diagram_.is_circular(diagram_.edges[e].left);
    }

private:
    const MinimizationDiagram& diagram_;
    const RadialVertices& vertices_;
    const EdgeEquations& equations_;
};

}  // namespace vcell::radial
