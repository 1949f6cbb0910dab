#include "ring_sites.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "../../core/sort_unique.hpp"
#include "../proofs/space_tie.hpp"

namespace vcell::radial {

namespace {

bool meet(const Interval& a, const Interval& b) { return a.lower() <= b.upper() && b.lower() <= a.upper(); }

// Is what lies on one of the two rings, known to be at y up to an error, on the first?
std::optional<bool> is_on_ring(const RingTie& tie, double y, double error) {
    const Interval place = Interval::ball(y, error);
    if (!meet(place, tie.y)) return false;
    if (tie.elsewhere && meet(place, *tie.elsewhere)) return std::nullopt;
    return true;
}

class RingSites {
public:
    RingSites(const RadialDiagram& of, const RadialCurves& curves, Cell& cell)
        : of_(of), diagram_(of.diagram), curves_(curves), cell_(cell) {}

    void add(const RingTie& tie) {
        if (tie.end)
            add_along_rim(tie, *tie.end == AxialEnd::Low ? 0 : 2);
        else {
            if (tie.before != tie.after) add_along_ring(tie);
            add_in_vertices(tie);
        }
    }

private:
    // The site ties along edges that `before` and `after` have on the ring.
    void add_along_ring(const RingTie& tie) {
        const FormId before{tie.before}, after{tie.after};
        for (const EdgeId e : diagram_.edges.ids()) {
            const MinimizationDiagram::Edge& edge = diagram_.edges[e];
            if (edge.on_rim() || std::minmax(edge.left, edge.right) != std::minmax(before, after)) continue;
            std::optional<double> y;
            curves_.for_controls(e, [&](const Vec3& p, double) { y = y.value_or(p.y()); });
            const auto is_on = is_on_ring(tie, *y, cell_.edges[e.value].error);
            if (!is_on)
                throw of_.unproved(e, "the rings along which they tie are too near to each other",
                                   Vec3(0, *y, 0));
            if (!*is_on) continue;
            add_to(e, tie);
            if (!curves_.has_ends(e)) continue;
            add_to(diagram_.start(e), tie);
            add_to(diagram_.end(e), tie);
        }
    }
    // Where the nearest ones tie with others on the ring the site ties, too, which exact signs tell.
    void add_in_vertices(const RingTie& tie) {
        const FormId form{tie.form};
        for (const VertexId v : diagram_.vertices.ids()) {
            const auto label = diagram_.label(v);
            const auto has = [&](std::uint32_t f) {
                return std::ranges::find(label, FormId{f}) != label.end();
            };
            if (!(has(tie.before) || has(tie.after)) || label.size() < 3) continue;
            const MinimizationDiagram::Vertex& vertex = diagram_.vertices[v];
            const Interval x = Interval::ball(vertex.point.x(), vertex.error),
                           y = Interval::ball(vertex.point.y(), vertex.error);
            if (!meet(y, tie.y)) continue;
            const SpaceTie meeting(of_.problem.family, label);
            // The site is to pass through all points that may be this vertex.
            bool is_there = false, is_elsewhere = false;
            for (const SpacePoint& p : meeting.points()) {
                const auto at = chart_point(of_.problem.family, p);
                if (!at || !meet((*at)[0], x) || !meet((*at)[1], y)) continue;
                (passes_through(of_.problem.family, form, p) ? is_there : is_elsewhere) = true;
            }
            if (meeting.implies(form) || (is_there && !is_elsewhere)) add_to(v, tie);
        }
    }
    // At an end of the region the site ties along the nearest one's rim, and in its vertices there.
    void add_along_rim(const RingTie& tie, std::uint32_t side) {
        const FormId lowest{tie.before};
        for (const EdgeId e : diagram_.edges.ids()) {
            const MinimizationDiagram::Edge& edge = diagram_.edges[e];
            if (edge.on_rim() && edge.side == side && edge.left == lowest) add_to(e, tie);
        }
        for (const VertexId v : diagram_.vertices.ids()) {
            const auto sides = diagram_.sides(v);
            const auto label = diagram_.label(v);
            if (std::ranges::find(sides, side) != sides.end() &&
                std::ranges::find(label, lowest) != label.end())
                add_to(v, tie);
        }
    }
    void add_to(EdgeId e, const RingTie& tie) {
        auto& sites = cell_.edges[e.value].extra_sites;
        for (const Site site : of_.problem.sites[FormId{tie.form}]) sites.push_back(site);
        sort_unique(sites);
    }
    void add_to(VertexId v, const RingTie& tie) {
        auto& sites = cell_.vertices[v.value].sites;
        for (const Site site : of_.problem.sites[FormId{tie.form}]) sites.push_back(site);
        sort_unique(sites);
    }

    const RadialDiagram& of_;
    const MinimizationDiagram& diagram_;
    const RadialCurves& curves_;
    Cell& cell_;
};

}  // namespace

void add_ring_sites(const RadialDiagram& of, const RadialCurves& curves, Cell& cell) {
    RingSites sites(of, curves, cell);
    for (const RingTie& tie : of.diagram.ring_ties) sites.add(tie);
}

}  // namespace vcell::radial
