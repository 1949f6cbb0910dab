#include "edge_equations.hpp"

#include <algorithm>
#include <vector>

#include "../../core/threads.hpp"
#include "radial_patch.hpp"

namespace vcell::radial {

EdgeEquations::EdgeEquations(const RadialDiagram& of, unsigned threads)
    : problem_(of.problem),
      diagram_(of.diagram),
      hyperplanes_(of, threads),
      kinds_(of.diagram.edges.size(), CurveKind::Spline) {
    std::vector<Decisions> decisions(range_count(kinds_.size()));
    for_ranges(kinds_.size(), threads, [&](std::size_t begin, std::size_t end, std::size_t task) {
        SphereConicKind conic_kind(problem_, decisions[task]);
        for (auto e = EdgeId{static_cast<std::uint32_t>(begin)}; e.value < end; ++e.value)
            if (!of.is_bare(e)) kinds_[e] = find_kind(e, conic_kind);
    });
    for (const Decisions& of_task : decisions) decisions_ += of_task;
}

CurveKind EdgeEquations::find_kind(EdgeId e, SphereConicKind& conic_kind) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    if (diagram_.is_circular(edge.left) && !edge.on_rim() && diagram_.is_circular(edge.right))
        return conic_kind(edge.left, edge.right, hyperplanes_[edge.left].functional(),
                          hyperplanes_[edge.right].functional());
    return problem_.chart.is_sphere() ? CurveKind::Spline : kind_over_cylinder(e);
}

CurveKind EdgeEquations::kind_over_cylinder(EdgeId e) const {
    if (is_line_over_cylinder(e)) return CurveKind::Line;
    const auto equations = axial(e);
    if (!equations) return CurveKind::Spline;
    const auto& [f, g] = *equations;
    return kind_of(f, g);
}

std::optional<std::array<AxialEquation, 2>> EdgeEquations::axial(EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const auto of_form = [&](FormId f) {
        auto equation = axial_equation(problem_.family.radial_form(f));
        if (equation)
            equation->has_plane = !is_wall(problem_, f) && std::holds_alternative<Plane>(problem_.objects[f]);
        return equation;
    };
    const auto left = of_form(edge.left);
    const auto right = edge.on_rim() ? axial_equation(problem_.stretch[edge.side != 0]) : of_form(edge.right);
    if (!left || !right) return std::nullopt;
    return std::array{*left, *right};
}

AxialConic EdgeEquations::axial_conic(EdgeId e) const {
    const auto equations = axial(e);
    return AxialConic(problem_, (*equations)[0], (*equations)[1]);
}

std::array<DistancePlane, 2> EdgeEquations::planes(EdgeId e) const {
    if (!diagram_.is_circular(diagram_.edges[e].left)) return axial_conic(e).planes();
    const auto [left, right] = hyperplanes(e);
    return {left->plane(), right->plane()};
}

// Edges of two planes, of bisectors that are parallel to the axis, and of such as have a point of it in
// common.
bool EdgeEquations::is_line_over_cylinder(EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    if (edge.on_rim()) return is_flat(problem_, edge.left);
    if ((is_flat(problem_, edge.left) && is_flat(problem_, edge.right)) ||
        (is_along_axis(edge.left) && is_along_axis(edge.right)))
        return true;
    const auto equations = axial(e);
    const double size = std::max(-problem_.stretch[0], problem_.stretch[1]);
    return equations && is_pair_of_lines((*equations)[0], (*equations)[1], size);
}

bool EdgeEquations::is_along_axis(FormId f) const {
    const RadialForm& form = problem_.family.radial_form(f);
    return form.c[1].sign() == Sign::Zero && form.c[2].sign() == Sign::Zero && !form.has_root();
}

}  // namespace vcell::radial
