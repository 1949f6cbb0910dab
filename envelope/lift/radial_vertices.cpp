#include "radial_vertices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "../../core/threads.hpp"
#include "space_spline.hpp"

namespace vcell::radial {

using Eigen::Vector4d;

namespace {

using roundoff::u;

}  // namespace

SpaceSite end_wall(const RadialBaseProblem& problem, std::uint32_t side) {
    const bool is_upper = side != 0;
    return {Plane{{0, problem.stretch[is_upper], 0}, {0, is_upper ? 1.0 : -1.0, 0}}, true, {}};
}

RadialVertices::RadialVertices(const RadialDiagram& of, const EdgeEquations& equations, unsigned threads)
    : problem_(of.problem),
      diagram_(of.diagram),
      origin_(of.problem.frame.origin.norm()),
      points_(diagram_.vertices.size(), Vector4d::Zero()),
      errors_(diagram_.vertices.size(), 0) {
    std::vector<bool> is_asked(diagram_.vertices.size(), problem_.floor.empty());
    if (!problem_.floor.empty())
        for (const EdgeId e : diagram_.edges.ids())
            if (const VertexId start = diagram_.start(e); start.valid() && !of.is_bare(e))
                is_asked[start.value] = is_asked[diagram_.end(e).value] = true;
    for_ranges(points_.size(), threads, [&](std::size_t begin, std::size_t end) {
        for (auto v = VertexId{static_cast<std::uint32_t>(begin)}; v.value < end; ++v.value) {
            if (!is_asked[v.value]) continue;
            const auto [point, error] = lifted(v, equations);
            points_[v] = point;
            errors_[v] = error;
        }
    });
}

RadialVertices::Vertex RadialVertices::lifted(VertexId v, const EdgeEquations& equations) const {
    const MinimizationDiagram::Vertex& from = diagram_.vertices[v];
    const double t = problem_.chart.distance_of(from.point, from.height);
    const Vec3 p = problem_.chart.point(from.point, t);
    const Vector4d x(p.x(), p.y(), p.z(), t);
    const double error = chart_error(from, t);
    if (error <= 64 * u * (t + origin_)) return {x, error};
    const std::span<const FormId> forms = diagram_.label(v);
    const auto is_circular = [&](FormId f) { return diagram_.is_circular(f); };
    if (forms.size() < 3 || !std::ranges::all_of(forms.first(3), is_circular)) {
        const auto end = settled(v, {p, error});
        if (!end) return {x, error};
        const Vec3& q = end->point;
        return {problem_.chart.with_distance(q), end->error + 16 * u * (t + std::abs(p.y()) + origin_)};
    }
    const Vector4d moved = moved_to_meet(x, {&equations.hyperplane(forms[0]), &equations.hyperplane(forms[1]),
                                             &equations.hyperplane(forms[2])});
    const double move = (moved - x).norm();
    if (!(move <= error)) return {x, error};
    return {moved, error + move};
}

// At a chart distance of e from p, W = 1 + |p|^2 (half angles: 1 + x^2) differs by at most dW = (2 |p| +
// e) e, the unit normal by 2 e / sqrt(W W') [the stereographic chord], and t = W / -f by the factors of W
// and of f.
double RadialVertices::chart_error(const MinimizationDiagram::Vertex& v, double t) const {
    const double e = v.error, reach = problem_.chart.half_tangent(v.point);
    const double W = 1 + reach * reach, dW = (2 * reach + e) * e;
    const double turn = 2 * e / std::sqrt(W * std::max(1.0, W - dW)), along = problem_.chart.along(e);
    const double room = -v.height - v.height_error;
    const double stretch =
        room > 0 ? (dW / W * -v.height + v.height_error) / room : std::numeric_limits<double>::infinity();
    // Normal, point, motion back: a handful of roundings each.
    return t * (turn + stretch) + along + 16 * u * (t + std::abs(v.point.y()) + origin_);
}

// Where the first three of the vertex's ends and sites are met.
std::optional<SpaceEnd> RadialVertices::settled(VertexId v, const SpaceEnd& near) const {
    std::array<SpaceSite, 3> sites;
    std::size_t count = 0;
    for (const std::uint32_t side : diagram_.sides(v)) sites[count++] = end_wall(problem_, side);
    for (const FormId f : diagram_.label(v))
        if (count < sites.size()) sites[count++] = {problem_.objects[f], is_wall(problem_, f), {}};
    return count == sites.size() ? settle_point(problem_.chart, sites, near) : std::nullopt;
}

double RadialVertices::reach() const {
    double reach = 0;
    for (const Vector4d& p : points_) reach = std::max(reach, p.w());
    return reach;
}

}  // namespace vcell::radial
