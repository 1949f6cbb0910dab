#include "chart_loops.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <set>
#include <variant>

#include "../../primitives/bases/plane_base.hpp"

namespace vcell {

namespace {

/// A side of an edge.
struct SideUse {
    std::uint32_t edge;
    bool reversed;

    friend auto operator<=>(const SideUse&, const SideUse&) = default;
};

bool has_own_parameters(const Cell& cell, Site site) {
    if (!site.is_object()) return false;
    const Object& o = cell.scene.objects[site.index];
    return std::holds_alternative<Cylinder>(o) || std::holds_alternative<HollowCylinder>(o) ||
           std::holds_alternative<HollowCone>(o);
}

/// Where a face has several patches seams cut its loops: edges follow each other in vertices. Which of
/// several there follows makes no difference to what lies within.
std::vector<std::vector<SideUse>> loops_along_edges(const Cell& cell, const CellFace& face) {
    std::vector<std::vector<SideUse>> loops;
    if (face.patches.size() == 1) {
        for (const auto& loop : face.patches[0].loops) {
            loops.emplace_back();
            for (const TrimCurve& c : loop) loops.back().push_back({*c.edge, c.reversed});
        }
        return loops;
    }
    std::set<SideUse> left;
    for (const TrimCurve& c : face.trims())
        if (c.edge) left.insert({*c.edge, c.reversed});
    while (!left.empty()) {
        std::vector<SideUse>& loop = loops.emplace_back();
        for (auto next = left.begin(); next != left.end();) {
            loop.push_back(*next);
            left.erase(next);
            const CellEdge& edge = cell.edges[loop.back().edge];
            if (edge.vertices.empty()) break;
            const std::uint32_t end = edge.vertices[loop.back().reversed ? 0 : 1];
            next = std::ranges::find_if(left, [&](const SideUse& use) {
                const auto& ends = cell.edges[use.edge].vertices;
                return !ends.empty() && ends[use.reversed ? 1 : 0] == end;
            });
        }
    }
    return loops;
}

TrimCurve projection(const SideUse& use, const RationalCurve3& space, const BaseFrame& frame) {
    TrimCurve result{use.edge, {}, use.reversed, {space.degree, space.knots, {}}};
    for (const Eigen::Vector4d& p : space.points) {
        const Vec3 canonical = frame.to_canonical(p.head<3>());
        result.curve.points.push_back({canonical.x(), canonical.y(), p.w()});
    }
    if (!use.reversed) return result;
    std::reverse(result.curve.points.begin(), result.curve.points.end());
    std::reverse(result.curve.knots.begin(), result.curve.knots.end());
    for (double& k : result.curve.knots) k = space.domain_begin() + space.domain_end() - k;
    return result;
}

}  // namespace

ChartLoops chart_loops(const Cell& cell) {
    ChartLoops result;
    std::optional<BaseFrame> frame;
    for (const CellFace& face : cell.faces) {
        std::vector<ChartLoop>& loops = result.of_faces.emplace_back();
        if (is_entered(cell, face)) continue;
        if (!has_own_parameters(cell, face.site)) {
            for (const TrimmedPatch& patch : face.patches)
                for (const auto& loop : patch.loops) {
                    loops.emplace_back();
                    for (const TrimCurve& c : loop) loops.back().push_back(&c);
                }
            continue;
        }
        if (!frame) frame = plane_base_problem(cell.scene).frame;
        for (const auto& loop : loops_along_edges(cell, face)) {
            loops.emplace_back();
            for (const SideUse& use : loop) {
                result.projected.push_back(projection(use, cell.edges[use.edge].curve, *frame));
                loops.back().push_back(&result.projected.back());
            }
        }
    }
    return result;
}

}  // namespace vcell
