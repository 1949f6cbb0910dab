#include "shell.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "../../core/curves/reversed_curve.hpp"
#include "../../core/errors.hpp"
#include "../pictures/polygons.hpp"

namespace vcell {

namespace {

/// An edge in one of its senses.
struct Use {
    std::uint32_t edge;
    bool reversed;

    Use back() const { return {edge, !reversed}; }
};
using Loop = std::vector<Use>;

/// Consecutive edges of a rim, with the cell on their left, and what is on their right: a wall or an end, or
/// the base where there is none.
struct RimPart {
    Site beside;
    Loop edges;
};

[[noreturn]] void fail_rim() { throw InternalError("closing_of: the rim of the cell does not close"); }

struct Closed {
    Closing closing;
    double off_plane = 0;
};

class Closer {
public:
    explicit Closer(const Cell& cell) : cell_(cell), diagonal_(cell.scene.box.diagonal()) {}

    Closed close() {
        for (const Loop& rim : rims()) close_rim(parts(rim));
        // The base comes last, whatever its place among sites.
        const auto floor = loops_.extract(Site::base());
        for (const auto& [site, loops] : loops_) add_faces(site, loops);
        if (floor) add_faces(Site::base(), floor.mapped());
        return std::move(closed_);
    }

private:
    const CellVertex& vertex(std::uint32_t v) const {
        const std::size_t own = cell_.vertices.size();
        return v < own ? cell_.vertices[v] : closed_.closing.vertices[v - own];
    }
    const CellEdge& edge(const Use& use) const {
        const std::size_t own = cell_.edges.size();
        return use.edge < own ? cell_.edges[use.edge] : closed_.closing.edges[use.edge - own];
    }

    // Edges with a face on one side only, chained.
    std::vector<Loop> rims() const {
        std::vector<std::array<bool, 2>> used(cell_.edges.size(), {false, false});
        for (const CellFace& face : cell_.faces)
            for (const TrimCurve& c : face.trims())
                if (c.edge) used[*c.edge][c.reversed ? 1 : 0] = true;
        std::vector<Loop> rims;
        std::vector<Use> on_rim;
        std::unordered_map<std::uint32_t, Use> by_start;
        for (std::uint32_t e = 0; e < used.size(); ++e) {
            if (used[e][0] == used[e][1]) continue;
            const Use use{e, used[e][1]};
            if (cell_.edges[e].vertices.empty()) {
                rims.push_back({use});
                continue;
            }
            on_rim.push_back(use);
            if (!by_start.emplace(start(use), use).second) fail_rim();
        }
        for (const Use& first : on_rim) {
            if (!by_start.contains(start(first))) continue;
            Loop& rim = rims.emplace_back();
            for (std::uint32_t at = start(first); rim.empty() || at != start(first);) {
                const auto next = by_start.extract(at);
                if (!next) fail_rim();
                rim.push_back(next.mapped());
                at = end(next.mapped());
            }
        }
        return rims;
    }

    std::uint32_t start(const Use& use) const { return edge(use).vertices[use.reversed ? 1 : 0]; }
    std::uint32_t end(const Use& use) const { return start(use.back()); }

    // The first part begins where the last one ends for another site's sake, if there are several.
    std::vector<RimPart> parts(Loop rim) const {
        const auto beside = [&](const Use& use) {
            const auto& sites = cell_.edges[use.edge].sites;
            return sites[0] == sites[1] ? Site::base() : sites[use.reversed ? 0 : 1];
        };
        const auto change = std::ranges::adjacent_find(
            rim, [&](const Use& a, const Use& b) { return beside(a) != beside(b); });
        if (change != rim.end()) std::ranges::rotate(rim, change + 1);
        std::vector<RimPart> result;
        for (const Use& use : rim) {
            if (result.empty() || result.back().beside != beside(use)) result.push_back({beside(use), {}});
            result.back().edges.push_back(use);
        }
        return result;
    }

    // What is on the right of the rim has it as its boundary, the other way round. Walls meet the base in a
    // line each, and one another in a line from the base upwards.
    void close_rim(const std::vector<RimPart>& rim) {
        const auto run_back = [](const Loop& edges) {
            Loop result;
            for (auto use = edges.rbegin(); use != edges.rend(); ++use) result.push_back(use->back());
            return result;
        };
        if (rim.size() == 1) {
            loops_[rim[0].beside].push_back(run_back(rim[0].edges));
            return;
        }
        const auto is_wall = [&](const RimPart& part) {
            return part.beside != Site::base() && !is_on_base(part.edges);
        };
        std::vector<Foot> feet;
        for (std::size_t i = 0; i < rim.size(); ++i) {
            const RimPart& before = rim[(i + rim.size() - 1) % rim.size()];
            const std::uint32_t corner = start(rim[i].edges.front());
            feet.push_back(is_wall(before) && is_wall(rim[i]) ? add_foot(corner, before.beside, rim[i].beside)
                                                              : Foot{corner, std::nullopt});
        }
        Loop floor;
        for (std::size_t i = rim.size(); i-- > 0;) {
            Loop back = run_back(rim[i].edges);
            if (is_wall(rim[i])) {
                const Foot &from = feet[i], &to = feet[(i + 1) % rim.size()];
                const Use line{add_line(from.vertex, to.vertex, {rim[i].beside, Site::base()}), false};
                if (from.upwards) back.push_back({*from.upwards, true});
                back.push_back(line);
                if (to.upwards) back.push_back({*to.upwards, false});
                loops_[rim[i].beside].push_back(std::move(back));
                back = {line.back()};
            }
            floor.insert(floor.end(), back.begin(), back.end());
        }
        loops_[Site::base()].push_back(std::move(floor));
    }

    // Where an edge of the box lies on a base plane there is no height for a wall.
    bool is_on_base(const Loop& edges) const {
        return std::ranges::all_of(edges, [&](const Use& use) {
            const CellVertex& corner = vertex(start(use));
            const CellEdge& e = edge(use);
            constexpr double rounding = 0x1p-44;  // of the box's diagonal
            const double allowed = corner.error + e.error + rounding * diagonal_;
            return std::ranges::all_of(e.curve.points, [&](const Eigen::Vector4d& p) {
                return std::abs(corner.radius - outwards(Site::base()).dot(p.head<3>() - corner.point)) <=
                       allowed;
            });
        });
    }

    /// A vertex on the base, and the line from it to the corner above.
    struct Foot {
        std::uint32_t vertex;
        std::optional<std::uint32_t> upwards;
    };

    Foot add_foot(std::uint32_t corner, Site before, Site after) {
        const CellVertex& top = cell_.vertices[corner];
        if (top.radius <= top.error) return {corner, std::nullopt};
        CellVertex foot;
        foot.point = top.point + top.radius * outwards(Site::base());
        foot.sites = {std::min(before, after), std::max(before, after)};
        foot.error = top.error;
        std::vector<CellVertex>& added = closed_.closing.vertices;
        const auto number = static_cast<std::uint32_t>(cell_.vertices.size() + added.size());
        added.push_back(std::move(foot));
        return {number, add_line(number, corner, {before, after})};
    }

    std::uint32_t add_line(std::uint32_t from, std::uint32_t to, const std::array<Site, 2>& sites) {
        CellEdge line;
        line.sites = sites;
        line.vertices = {from, to};
        line.curve.knots = {0, 0, 1, 1};
        for (const std::uint32_t v : {from, to}) {
            const CellVertex& at = vertex(v);
            line.curve.points.push_back(at.point.homogeneous());
            line.error = std::max(line.error, at.error);
        }
        std::vector<CellEdge>& added = closed_.closing.edges;
        added.push_back(std::move(line));
        return static_cast<std::uint32_t>(cell_.edges.size() + added.size() - 1);
    }

    // The normal, out of the solid, of what closes it at a site.
    Vec3 outwards(Site site) const {
        if (const auto* plane = std::get_if<Plane>(&cell_.scene.base)) {
            const Vec3 up = plane->normal.stableNormalized();
            if (site == Site::base()) return -up;
            const Vec3 side =
                (site.index % 2 == 0 ? -1 : 1) * Vec3::Unit(static_cast<Eigen::Index>(site.index / 2));
            return (side - side.dot(up) * up).stableNormalized();
        }
        if (const auto* cylinder = std::get_if<Cylinder>(&cell_.scene.base);
            cylinder && site.kind == Site::Kind::End)
            return (site.index == 0 ? -1 : 1) * cylinder->axis.stableNormalized();
        fail_rim();
    }

    // Several where a complete cell has several parts: ends at several places of the axis, and walls that
    // are apart.
    void add_faces(Site site, std::vector<Loop> loops) {
        const Vec3 out = outwards(site);
        const auto height = [&](const Loop& loop) {
            const RationalCurve3& curve = edge(loop.front()).curve;
            return out.dot(curve.evaluate(curve.domain_begin()));
        };
        constexpr double one_plane = 1e-12;  // of the box's diagonal: what is in one plane but for rounding
        while (!loops.empty()) {
            const double at = height(loops.front());
            const auto others = std::stable_partition(loops.begin(), loops.end(), [&](const Loop& loop) {
                return std::abs(height(loop) - at) <= one_plane * diagonal_;
            });
            std::vector<Loop> here(loops.begin(), others);
            loops.erase(loops.begin(), others);
            for (const std::vector<Loop>& part : divided(here, out)) add_face(site, out, part);
        }
    }

    // Each outer loop with its holes.
    std::vector<std::vector<Loop>> divided(const std::vector<Loop>& loops, const Vec3& out) const {
        if (loops.size() == 1) return {loops};
        const Vec3 x = out.unitOrthogonal(), y = out.cross(x);
        std::vector<std::vector<LoopPoint>> polygons;
        for (std::uint32_t i = 0; i < loops.size(); ++i) {
            polygons.emplace_back();
            for (const Use& use : loops[i]) {
                constexpr int steps = 64;
                const RationalCurve3& curve = edge(use).curve;
                for (int k = 0; k < steps; ++k) {
                    const double s = static_cast<double>(use.reversed ? steps - k : k) / steps;
                    const Vec3 p = curve.evaluate((1 - s) * curve.domain_begin() + s * curve.domain_end());
                    polygons.back().push_back({0, {x.dot(p), y.dot(p)}, i, 0});
                }
            }
        }
        std::vector<std::vector<Loop>> parts;
        for (const auto& part : with_holes(std::move(polygons))) {
            parts.emplace_back();
            for (const auto& polygon : part) parts.back().push_back(loops[polygon.front().line]);
        }
        return parts;
    }

    void add_face(Site site, const Vec3& out, const std::vector<Loop>& loops) {
        const Vec3 x = out.unitOrthogonal(), y = out.cross(x),
                   origin = edge(loops[0][0]).curve.points[0].head<3>();
        TrimmedPatch patch;
        Eigen::AlignedBox2d domain;
        for (const Loop& loop : loops) {
            patch.loops.emplace_back();
            for (const Use& use : loop) {
                const RationalCurve3& curve = edge(use).curve;
                RationalCurve2 trim;
                trim.degree = curve.degree;
                trim.knots = curve.knots;
                for (const Eigen::Vector4d& p : curve.points) {
                    const Vec3 q = p.head<3>() - origin;
                    trim.points.push_back({x.dot(q), y.dot(q), p[3]});
                    domain.extend(trim.points.back().head<2>());
                    closed_.off_plane = std::max(closed_.off_plane, std::abs(out.dot(q)));
                }
                patch.loops.back().push_back({use.edge, std::nullopt, use.reversed,
                                              use.reversed ? reversed(std::move(trim)) : std::move(trim)});
            }
        }
        patch.surface.domain_u = {domain.min().x(), domain.max().x()};
        patch.surface.domain_v = {domain.min().y(), domain.max().y()};
        for (const double u : patch.surface.domain_u)
            for (const double v : patch.surface.domain_v)
                patch.surface.points.push_back((origin + u * x + v * y).homogeneous());
        CellFace face;
        face.site = site;
        face.bisector = site == Site::base() ? "base" : site.kind == Site::Kind::End ? "end" : "wall";
        face.patches.push_back(std::move(patch));
        closed_.closing.faces.push_back(std::move(face));
    }

    const Cell& cell_;
    Closed closed_;
    double diagonal_;
    std::map<Site, std::vector<Loop>> loops_;  // of what closes the solid
};

}  // namespace

Closing closing_of(const Cell& cell) { return Closer(cell).close().closing; }

Shell closed_shell(const Cell& cell) {
    Closed closed = Closer(cell).close();
    Shell shell{cell.vertices, cell.edges, cell.faces, closed.off_plane};
    const auto append = [](auto& all, auto& more) {
        all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    };
    append(shell.vertices, closed.closing.vertices);
    append(shell.edges, closed.closing.edges);
    append(shell.faces, closed.closing.faces);
    return shell;
}

}  // namespace vcell
