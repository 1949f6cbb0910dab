#include "mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "../core/errors.hpp"

namespace vcell {

namespace {

constexpr std::uint32_t none = UINT32_MAX;

/// A cell edge as a polyline: parameters of its space curve, ends included, and mesh points.
struct SampledEdge {
    std::vector<double> parameters;
    std::vector<std::uint32_t> points;
};

/// One point of a face's polygon.
struct LoopPoint {
    std::uint32_t point;  // of the mesh
    Vec2 uv;
    std::uint32_t edge;  // the cell edge that starts or goes on here
};

bool proper_crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
    const auto turn = [](const Vec2& p, const Vec2& q, const Vec2& r) {
        return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
    };
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

/// How far the middle of the side from a to b, straight in space, stays away from the patch.
double deviation(const RationalPatch& s, const Vec2& a, const Vec2& b) {
    const Vec2 m = 0.5 * (a + b);
    const Vec3 chord_middle = 0.5 * (s.evaluate(a.x(), a.y()) + s.evaluate(b.x(), b.y()));
    return (s.evaluate(m.x(), m.y()) - chord_middle).norm();
}

/// The point of a trimming curve at the edge's parameter t: they share it, or run against each other.
Vec2 at_edge_parameter(const TrimCurve& c, double t) {
    return c.curve.evaluate(c.reversed ? c.curve.domain_begin() + c.curve.domain_end() - t : t);
}

class Tessellator {
public:
    Tessellator(const Cell& cell, const MeshOptions& options)
        : cell_(cell),
          chord_(options.chord.value_or(1e-3 * cell.scene.box.diagonal())),
          pieces_(cell.edges.size()),
          uses_(cell.edges.size()) {
        for_each_curve([&](const TrimCurve& c, const RationalPatch& s) {
            if (!c.edge) throw InternalError("tessellate: a chart seam over a plane base");
            uses_[*c.edge].push_back({&c, &s});
        });
    }

    CellMesh mesh(bool closed) {
        for (std::size_t e = 0; e < pieces_.size(); ++e) pieces_[e] = first_pieces(cell_.edges[e]);
        // Chords of a coarse polyline may cross those of its neighbour where the true arcs do not.
        constexpr int rounds = 8;
        sample_edges();
        for (int i = 0; i < rounds && refine_crossing_edges(); ++i) sample_edges();

        for (std::uint32_t f = 0; f < cell_.faces.size(); ++f) {
            const std::size_t begin = mesh_.triangles.size();
            for (const TrimmedPatch& patch : cell_.faces[f].patches) add_patch(patch);
            mesh_.groups.push_back({CellMesh::Group::Kind::Face, f, begin, mesh_.triangles.size()});
        }
        if (closed) add_walls_and_base();
        for (const SampledEdge& e : edges_) mesh_.edge_lines.push_back(e.points);
        return std::move(mesh_);
    }

private:
    /// A trimming curve on an edge, and its patch.
    struct Use {
        const TrimCurve* curve;
        const RationalPatch* patch;
    };

    template <class F>
    void for_each_curve(F f) const {
        for (const CellFace& face : cell_.faces)
            for (const TrimmedPatch& patch : face.patches)
                for (const auto& loop : patch.loops)
                    for (const TrimCurve& c : loop) f(c, patch.surface);
    }

    // Pieces that an edge has at least: enough for a loop to be a polygon, and for a curved edge to have
    // points of its own beside its ends, whatever the chord.
    static std::size_t first_pieces(const CellEdge& e) {
        if (e.vertices.empty()) return 8;
        return e.kind == CurveKind::Line ? 1 : 2;
    }

    // Whether the stretch [from, to] of an edge needs a point between: for the curve itself, and for the
    // patches on both sides, whose inner sides could not be shorter than those on the boundary.
    bool too_coarse(std::size_t edge, double from, double to) const {
        const RationalCurve3& curve = cell_.edges[edge].curve;
        const Vec3 chord_middle = 0.5 * (curve.evaluate(from) + curve.evaluate(to));
        if ((curve.evaluate(0.5 * (from + to)) - chord_middle).norm() > chord_) return true;
        for (const Use& use : uses_[edge])
            if (deviation(*use.patch, at_edge_parameter(*use.curve, from),
                          at_edge_parameter(*use.curve, to)) > chord_)
                return true;
        return false;
    }

    // Parameters of an edge: pieces of equal length in the parameter, halved while they are too coarse.
    std::vector<double> parameters(std::size_t edge, std::size_t pieces) const {
        const RationalCurve3& curve = cell_.edges[edge].curve;
        const double begin = curve.domain_begin(), end = curve.domain_end();
        std::vector<double> result{begin};
        const auto add = [&](auto& self, double from, double to, int depth) -> void {
            constexpr int deepest = 12;
            if (depth < deepest && too_coarse(edge, from, to)) {
                const double middle = 0.5 * (from + to);
                self(self, from, middle, depth + 1);
                self(self, middle, to, depth + 1);
            } else {
                result.push_back(to);
            }
        };
        for (std::size_t i = 0; i < pieces; ++i) {
            const auto at = [&](std::size_t k) {
                return k == pieces
                           ? end
                           : begin + (end - begin) * static_cast<double>(k) / static_cast<double>(pieces);
            };
            add(add, at(i), at(i + 1), 0);
        }
        return result;
    }

    // Mesh points: the cell's vertices, then the inner points of each edge.
    void sample_edges() {
        mesh_.points.clear();
        for (const CellVertex& v : cell_.vertices) mesh_.points.push_back(v.point);
        edges_.assign(cell_.edges.size(), {});
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            const CellEdge& e = cell_.edges[i];
            SampledEdge& s = edges_[i];
            s.parameters = parameters(i, pieces_[i]);
            for (const double t : s.parameters) {
                const bool at_begin = t == s.parameters.front(), at_end = t == s.parameters.back();
                if (at_begin && !e.vertices.empty())
                    s.points.push_back(e.vertices[0]);
                else if (at_end)
                    s.points.push_back(e.vertices.empty() ? s.points.front() : e.vertices[1]);
                else
                    s.points.push_back(add_point(e.curve.evaluate(t)));
            }
        }
    }

    std::uint32_t add_point(const Vec3& p) {
        mesh_.points.push_back(p);
        return static_cast<std::uint32_t>(mesh_.points.size() - 1);
    }

    // A trimming loop as a polygon.
    std::vector<LoopPoint> polygon(const std::vector<TrimCurve>& loop) const {
        std::vector<LoopPoint> result;
        for (const TrimCurve& c : loop) {
            const SampledEdge& e = edges_[*c.edge];
            const std::size_t n = e.points.size();
            for (std::size_t i = 0; i + 1 < n; ++i) {
                const std::size_t k = c.reversed ? n - 1 - i : i;
                result.push_back({e.points[k], at_edge_parameter(c, e.parameters[k]), *c.edge});
            }
        }
        return result;
    }

    std::vector<std::vector<LoopPoint>> polygons(const TrimmedPatch& patch) const {
        std::vector<std::vector<LoopPoint>> result;
        for (const auto& loop : patch.loops) {
            result.push_back(polygon(loop));
            // Two straight edges between the same ends enclose nothing.
            if (result.back().size() < 3) result.pop_back();
        }
        return result;
    }

    // Doubles the pieces of edges whose polylines cross in some face. True if there were any.
    bool refine_crossing_edges() {
        std::vector<bool> coarse(edges_.size(), false);
        for (const CellFace& face : cell_.faces)
            for (const TrimmedPatch& patch : face.patches) find_crossings(patch, coarse);
        bool any = false;
        for (std::size_t e = 0; e < coarse.size(); ++e)
            if (coarse[e]) {
                pieces_[e] = std::max(2 * pieces_[e], edges_[e].points.size());
                any = true;
            }
        return any;
    }

    void find_crossings(const TrimmedPatch& patch, std::vector<bool>& coarse) const {
        struct Segment {
            Vec2 a, b;
            std::uint32_t edge;
            double low() const { return std::min(a.x(), b.x()); }
            double high() const { return std::max(a.x(), b.x()); }
        };
        std::vector<Segment> segments;
        for (const auto& loop : polygons(patch))
            for (std::size_t i = 0; i < loop.size(); ++i)
                segments.push_back({loop[i].uv, loop[(i + 1) % loop.size()].uv, loop[i].edge});
        std::sort(segments.begin(), segments.end(),
                  [](const auto& s, const auto& t) { return s.low() < t.low(); });
        for (std::size_t i = 0; i < segments.size(); ++i)
            for (std::size_t j = i + 1; j < segments.size() && segments[j].low() <= segments[i].high(); ++j)
                if (proper_crossing(segments[i].a, segments[i].b, segments[j].a, segments[j].b))
                    coarse[segments[i].edge] = coarse[segments[j].edge] = true;
    }

    void add_patch(const TrimmedPatch& patch) {
        const RationalPatch& s = patch.surface;
        const std::vector<std::vector<LoopPoint>> loops = polygons(patch);
        if (loops.empty()) return;
        const auto split = [&](const Vec2& a, const Vec2& b) { return deviation(s, a, b) > chord_; };
        add_triangles(
            loops, split, [&](const Vec2& uv) { return s.evaluate(uv.x(), uv.y()); },
            [&](const Vec2& uv) {
                const auto [du, dv] = s.partials(uv.x(), uv.y());
                return Vec3(du.cross(dv).stableNormalized());
            });
    }

    void add_triangles(const std::vector<std::vector<LoopPoint>>& loops, const auto& split,
                       const auto& position, const auto& normal) {
        std::vector<std::vector<Vec2>> uv;
        std::vector<std::uint32_t> point;
        for (const auto& loop : loops) {
            uv.emplace_back();
            for (const LoopPoint& p : loop) {
                uv.back().push_back(p.uv);
                point.push_back(p.point);
            }
        }
        const Triangulation t = triangulate(uv, split);
        const auto first_normal = static_cast<std::uint32_t>(mesh_.normals.size());
        for (std::size_t i = 0; i < t.points.size(); ++i) {
            if (i >= point.size()) point.push_back(add_point(position(t.points[i])));
            mesh_.normals.push_back(normal(t.points[i]));
        }
        for (const Triangle& v : t.triangles) {
            mesh_.triangles.push_back({point[v[0]], point[v[1]], point[v[2]]});
            mesh_.corner_normals.push_back({first_normal + v[0], first_normal + v[1], first_normal + v[2]});
        }
    }

    // Over a plane base the rim stands on its own foot: walls of two triangles for each piece of the rim,
    // and the polygon of the feet as floor.
    void add_walls_and_base() {
        const auto* base = std::get_if<Plane>(&cell_.scene.base);
        if (!base) throw InternalError("tessellate: walls and base of a base that is no plane");
        const Vec3 up = base->normal.stableNormalized();
        const std::vector<LoopPoint> rim = rim_polygon();
        // Patches need not have the chart's coordinates for u and v: the floor has its own in the base.
        const Vec3 x = up.unitOrthogonal(), y = up.cross(x);
        std::vector<LoopPoint> floor;
        for (const LoopPoint& p : rim) {
            const Vec3 top = mesh_.points[p.point], from_base = top - base->point;
            floor.push_back(
                {add_point(top - up.dot(from_base) * up), {x.dot(from_base), y.dot(from_base)}, p.edge});
        }

        const std::size_t walls_begin = mesh_.triangles.size();
        for (std::size_t i = 0; i < rim.size(); ++i) {
            const std::size_t j = (i + 1) % rim.size();
            const std::uint32_t a = rim[i].point, b = rim[j].point, fa = floor[i].point, fb = floor[j].point;
            // The rim has the cell on its left: what is to the right of it is outside.
            const Vec3 along = mesh_.points[fb] - mesh_.points[fa];
            mesh_.normals.push_back(along.cross(up).stableNormalized());
            const auto n = static_cast<std::uint32_t>(mesh_.normals.size() - 1);
            mesh_.triangles.push_back({b, a, fa});
            mesh_.triangles.push_back({b, fa, fb});
            mesh_.corner_normals.insert(mesh_.corner_normals.end(), 2, Triangle{n, n, n});
        }
        mesh_.groups.push_back({CellMesh::Group::Kind::Walls, none, walls_begin, mesh_.triangles.size()});

        const std::size_t base_begin = mesh_.triangles.size();
        add_triangles(
            {floor}, [](const Vec2&, const Vec2&) { return false; }, [](const Vec2&) { return Vec3(); },
            [&](const Vec2&) { return Vec3(-up); });
        for (std::size_t t = base_begin; t < mesh_.triangles.size(); ++t) {
            std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);  // seen from below
            std::swap(mesh_.corner_normals[t][1], mesh_.corner_normals[t][2]);
        }
        mesh_.groups.push_back({CellMesh::Group::Kind::Base, none, base_begin, mesh_.triangles.size()});
    }

    // The trimming curves of edges with one face only, chained.
    std::vector<LoopPoint> rim_polygon() const {
        std::unordered_map<std::uint32_t, std::vector<LoopPoint>> pieces;  // by first point
        std::uint32_t start = none;
        std::size_t count = 0;
        for_each_curve([&](const TrimCurve& c, const RationalPatch&) {
            if (uses_[*c.edge].size() != 1) return;
            std::vector<LoopPoint> piece = polygon({c});
            start = piece.front().point;
            count += pieces.emplace(start, std::move(piece)).second;
        });
        std::vector<LoopPoint> rim;
        std::uint32_t at = start;
        for (std::size_t i = 0; i < count; ++i) {
            const auto piece = pieces.find(at);
            if (piece == pieces.end()) throw InternalError("tessellate: the rim of the cell does not close");
            rim.insert(rim.end(), piece->second.begin(), piece->second.end());
            const SampledEdge& e = edges_[piece->second.front().edge];
            at = e.points.front() == at ? e.points.back() : e.points.front();
            pieces.erase(piece);
        }
        if (rim.empty() || at != start) throw InternalError("tessellate: the rim of the cell does not close");
        return rim;
    }

    const Cell& cell_;
    double chord_;
    std::vector<std::size_t> pieces_;  // per edge, before halving
    std::vector<std::vector<Use>> uses_;
    std::vector<SampledEdge> edges_;
    CellMesh mesh_;
};

}  // namespace

CellMesh tessellate(const Cell& cell, const MeshOptions& options) {
    return Tessellator(cell, options).mesh(options.closed);
}

}  // namespace vcell
