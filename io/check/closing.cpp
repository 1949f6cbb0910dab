#include "closing.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace vcell::check {
namespace {

std::string closing_path(const std::string& path) { return "closing." + path; }

class Closings : public Room {
public:
    Closings(std::span<const Subject> subjects, std::span<const EdgeBound> edges, const CheckOptions& options,
             Certificate& certificate)
        : Room(subjects.front(), options, certificate),
          subjects_(subjects),
          closing_(*cell_.closing),
          space_(&subjects.front().space) {
        for (const CellVertex& v : cell_.vertices) {
            vertex_bounds_.push_back(v.error);
            most_stated_ = std::max(most_stated_, v.error);  // what is more is refuted there
        }
        for (const EdgeBound& bound : edges) edge_bounds_.push_back(bound.distance);
        vertex_bounds_.resize(cell_.vertices.size() + closing_.vertices.size(), HUGE_VAL);
        edge_bounds_.resize(cell_.edges.size() + closing_.edges.size(), HUGE_VAL);
        used_.assign(edge_bounds_.size(), {0, 0});
    }

    void run() {
        const auto faults = [&] {
            return certificate_.count(Verdict::refuted) + certificate_.count(Verdict::open);
        };
        const std::size_t before = faults();
        for (std::size_t i = 0; i < closing_.vertices.size(); ++i) judge_vertex(i);
        for (std::size_t i = 0; i < closing_.edges.size(); ++i) judge_edge(i);
        for (std::size_t i = 0; i < closing_.faces.size(); ++i) judge_face(i);
        judge_uses();
        if (faults() == before) certificate_.prove("closing");
    }

private:
    const Space<Interval>& space() const { return *space_; }
    /// Ends are those of the part that has the edges.
    void set_space(const CellFace& face) {
        if (subjects_.size() == 1) return;
        const auto e = *face.patches[0].loops[0][0].edge;
        for (const Subject& subject : subjects_)
            if (std::ranges::binary_search(subject.edges, e)) space_ = &subject.space;
    }
    const CellVertex& vertex(std::size_t v) const {
        const std::size_t own = cell_.vertices.size();
        return v < own ? cell_.vertices[v] : closing_.vertices[v - own];
    }
    const CellEdge& edge(std::size_t e) const {
        const std::size_t own = cell_.edges.size();
        return e < own ? cell_.edges[e] : closing_.edges[e - own];
    }
    double error_of(std::size_t e) const {
        double at_ends = 0;
        for (const std::uint32_t v : edge(e).vertices) at_ends = std::max(at_ends, vertex(v).error);
        return edge(e).error + at_ends;
    }

    // --- Planes ------------------------------------------------------------------------------------------

    bool has_plane(const Site& s) const {
        switch (s.kind) {
            case Site::Kind::BoxSide: return geometry_.is_plane() && s.index < 6;
            case Site::Kind::End: return geometry_.is_cylinder() && s.index < 2;
            default: return geometry_.is_plane() && s == Site::base();
        }
    }
    /// How far inside a site's plane: of the base, above it; of a side of the box, the base point's distance
    /// from it. Pre: it has one.
    Interval inside(const Site& s, const Vec3& p) const {
        const Vector<Interval> at = to_vector<Interval>(p);
        return s == Site::base() ? space().clearance(at) : space().excess({s, true}, at);
    }
    /// What that grows by per length.
    Vector<Interval> inwards(const Site& s) const {
        const Vector<Interval> anywhere = to_vector<Interval>(scene_.box.min);
        return s == Site::base() ? space().up(anywhere) : space().gradient({s, true}, anywhere);
    }
    double off(const Site& s, const Vec3& p) const { return magnitude(inside(s, p)).upper(); }
    double distance(const Site& s, const Vec3& p) const {
        return (magnitude(inside(s, p)) / sqrt(square(inwards(s)))).upper();
    }

    // --- Feet and lines ----------------------------------------------------------------------------------

    void judge_vertex(std::size_t i) {
        const CellVertex& v = closing_.vertices[i];
        const std::string where = closing_path(vertex_path(i));
        const auto is_side = [&](const Site& s) { return s.kind == Site::Kind::BoxSide && has_plane(s); };
        if (v.sites.size() != 2 || !std::ranges::all_of(v.sites, is_side))
            return note(where + ".sites", "are not two sides of the box over a base plane");
        const double allowed = v.error + rounding();
        for (const Site& s : {Site::base(), v.sites[0], v.sites[1]})
            if (const double away = off(s, v.point); !(away <= allowed))
                return certificate_.refute(where + ".point",
                                           fmt::format("is {:.3g} away from {}", away, title(s)), away);
        if (!(std::abs(v.radius) <= allowed)) return note(where + ".radius", "is not 0 on the base");
        // Both sides' planes stand on the base.
        const Vector<Interval> a = inwards(v.sites[0]), b = inwards(v.sites[1]);
        const Vector<Interval> way = inside(v.sites[0], v.point) * b - inside(v.sites[1], v.point) * a;
        const Interval sine = square(cross(a, b));
        if (!(sine.lower() > 0)) return note(where + ".sites", "are parallel");
        const double bound = sqrt(square(inside(Site::base(), v.point)) + square(way) / sine).upper();
        if (v.error > most_stated_)
            return certificate_.refute(
                where + ".error",
                fmt::format("is {:.3g}, the point is within {:.3g} of the true one", v.error, bound),
                v.error);
        vertex_bounds_[cell_.vertices.size() + i] = bound;
        prove(where, bound);
    }

    void judge_edge(std::size_t i) {
        const CellEdge& e = closing_.edges[i];
        const std::string where = closing_path(edge_path(i));
        const auto can_be = [&](const Site& s) { return s.kind != Site::Kind::End && has_plane(s); };
        if (e.sites[0] == e.sites[1] || !std::ranges::all_of(e.sites, can_be))
            return note(where + ".sites", "are not two of the base plane and the sides of the box");
        if (e.vertices.size() != 2) return note(where + ".vertices", "are none");
        const auto& points = e.curve.points;
        if (points.size() != 2 || points[0][3] != points[1][3])
            return note(where + ".curve", "is no straight line from end to end");
        double bound = 0;
        for (const std::size_t k : {0, 1}) {
            const std::uint32_t v = e.vertices[k];
            const Vec3 p = points[k].head<3>();
            const double gap = (p - vertex(v).point).norm();
            if (!(gap <= e.error + vertex(v).error + rounding()))
                return certificate_.refute(where + ".vertices",
                                           fmt::format("the curve {} {:.3g} away from vertex {}",
                                                       k == 0 ? "starts" : "ends", gap, v),
                                           gap);
            for (const Site& s : e.sites) {
                if (s != Site::base() && !contains(vertex(v).sites, s))
                    return note(where + ".sites", fmt::format("vertex {} lacks {}", v, title(s)));
                if (const double away = off(s, p); !(away <= error_of(cell_.edges.size() + i) + rounding()))
                    return certificate_.refute(where + ".curve",
                                               fmt::format("is {:.3g} away from {}", away, title(s)), away);
            }
            bound = std::max(bound, gap + vertex_bounds_[v]);
        }
        if (e.error > most_stated_)
            return certificate_.refute(
                where + ".error",
                fmt::format("is {:.3g}, the curve is within {:.3g} of the true line", e.error, bound),
                e.error);
        edge_bounds_[cell_.edges.size() + i] = bound;
        if (bound < HUGE_VAL) prove(where, bound);
    }

    // --- Faces -------------------------------------------------------------------------------------------

    /// A patch as an affine map, up to `twist`.
    struct Flat {
        Vec3 origin, along_u, along_v;  // per unit of u and of v
        Vec2 from, to;                  // its domain
        double twist;

        Vec3 at(const Vec2& uv) const {
            const Vec2 by = uv - from;
            return origin + by.x() * along_u + by.y() * along_v;
        }
    };
    static std::optional<Flat> flat(const RationalPatch& s) {
        if (s.degree_u != 1 || s.degree_v != 1) return std::nullopt;
        std::array<Vec3, 4> p;
        for (std::size_t k = 0; k < 4; ++k) {
            if (s.points[k][3] != s.points[0][3]) return std::nullopt;
            p[k] = s.points[k].head<3>();
        }
        const double u = s.domain_u[1] - s.domain_u[0], v = s.domain_v[1] - s.domain_v[0];
        return Flat{p[0],
                    (p[2] - p[0]) / u,
                    (p[1] - p[0]) / v,
                    {s.domain_u[0], s.domain_v[0]},
                    {s.domain_u[1], s.domain_v[1]},
                    (p[0] - p[1] - p[2] + p[3]).norm()};
    }

    void judge_face(std::size_t f) {
        const CellFace& face = closing_.faces[f];
        const std::string where = closing_path(face_path(f));
        if (!has_plane(face.site))
            return note(where + ".site",
                        fmt::format("is {}, where nothing closes this cell", title(face.site)));
        const char* const name = face.site == Site::base()           ? "base"
                                 : face.site.kind == Site::Kind::End ? "end"
                                                                     : "wall";
        if (face.bisector != name)
            return note(where + ".bisector", fmt::format("is {}, must be {}", face.bisector, name));
        const auto plane = face.patches.size() == 1 ? flat(face.patches[0].surface) : std::nullopt;
        if (!plane) return note(where + ".patches", "are not one flat patch");

        set_space(face);
        double bound = 0, stated = 0;
        const auto& loops = face.patches[0].loops;
        for (std::size_t l = 0; l < loops.size(); ++l) {
            const std::string path = closing_path(loop_path(f, 0, l));
            for (std::size_t t = 0; t < loops[l].size(); ++t) {
                const auto of_trim =
                    judge_trim(fmt::format("{}[{}]", path, t), *plane, face.site, loops[l][t]);
                if (!of_trim) return;
                bound = std::max(bound, *of_trim);
                stated = std::max(stated, error_of(*loops[l][t].edge));
            }
            if (!judge_loop(path, loops, l)) return;
        }
        stated = std::min(stated, most_stated(0));  // what is more is refuted at the edge
        double away = 0;
        for (const auto& p : face.patches[0].surface.points) {
            if (const double x = off(face.site, p.head<3>()); !(x <= stated + rounding()))
                return certificate_.refute(where + ".patches[0]",
                                           fmt::format("lies {:.3g} away from {}", x, title(face.site)), x);
            away = std::max(away, distance(face.site, p.head<3>()));
        }
        const Vector<Interval> in = inwards(face.site);
        if (!(plane->along_u.cross(plane->along_v).dot(middle(in)) < 0))
            return note(where + ".patches[0]", "faces the cell's inside");
        if (bound < HUGE_VAL) prove(where, away + bound);
    }

    /// How far what a trim lifts to is from the true edge at most, infinite where that is not known of its
    /// edge. None: something is wrong, or open.
    ///
    /// In the basis of the edge's curve both are determined by their control points, and differ by no more
    /// than these do.
    std::optional<double> judge_trim(const std::string& where, const Flat& plane, const Site& site,
                                     const TrimCurve& trim) {
        const std::size_t e = *trim.edge;
        const RationalCurve3& curve = edge(e).curve;
        ++used_[e][trim.reversed ? 1 : 0];
        const auto& sites = edge(e).sites;
        // Where the box ends on the base the region goes as far as the rim itself.
        const bool ends_on_base =
            site == Site::base() && std::ranges::all_of(curve.points, [&](const auto& p) {
                return off(site, p.template head<3>()) <= error_of(e) + rounding();
            });
        if (!ends_on_base && sites[trim.reversed ? 1 : 0] != site) {
            note(where, fmt::format("{} of edge {} is {}", trim.reversed ? "right" : "left", e,
                                    title(sites[trim.reversed ? 1 : 0])));
            return std::nullopt;
        }
        const std::size_t count = curve.points.size(), knots = curve.knots.size();
        const auto opposite = [&](std::size_t i, std::size_t size) {
            return trim.reversed ? size - 1 - i : i;
        };
        const double sum = curve.domain_begin() + curve.domain_end(),
                     near = kPlaceRounding * (curve.domain_end() - curve.domain_begin());
        bool is_alike = trim.curve.degree == curve.degree && trim.curve.points.size() == count;
        for (std::size_t i = 0; is_alike && i < knots; ++i) {
            const double knot = curve.knots[opposite(i, knots)];
            is_alike = std::abs(trim.curve.knots[i] - (trim.reversed ? sum - knot : knot)) <= near;
        }
        const Vec2 margin = kPlaceRounding * (plane.to - plane.from);
        double gap = 0, size = 0;
        for (std::size_t i = 0; is_alike && i < count; ++i) {
            const auto& p = curve.points[opposite(i, count)];
            const Vec2 uv = trim.curve.points[i].head<2>();
            is_alike = trim.curve.points[i][2] == p[3];
            if ((uv.array() < (plane.from - margin).array()).any() ||
                (uv.array() > (plane.to + margin).array()).any()) {
                note(where, "leaves the patch's domain");
                return std::nullopt;
            }
            gap = std::max(gap, (plane.at(uv) - p.head<3>()).norm() + plane.twist);
            size = std::max(size, p.head<3>().cwiseAbs().maxCoeff());
        }
        if (!is_alike) {
            certificate_.leave_open(
                where, fmt::format("has not the degree, the knots and the weights of edge {}", e), HUGE_VAL);
            return std::nullopt;
        }
        if (!(gap <= 2 * error_of(e) + rounding() + kRounding * size)) {
            certificate_.refute(
                where, fmt::format("lifts to a curve {:.3g} away from edge {} at the same parameter", gap, e),
                gap);
            return std::nullopt;
        }
        return gap + edge_bounds_[e];
    }

    /// Each edge goes on where the one before ends, and the loop runs the right way round.
    bool judge_loop(const std::string& where, const std::vector<std::vector<TrimCurve>>& loops,
                    std::size_t l) {
        const std::vector<TrimCurve>& loop = loops[l];
        for (std::size_t t = 0; t < loop.size(); ++t) {
            const TrimCurve &trim = loop[t], &next = loop[(t + 1) % loop.size()];
            const auto &here = edge(*trim.edge).vertices, &there = edge(*next.edge).vertices;
            const bool goes_on =
                here.empty() ? loop.size() == 1
                             : !there.empty() && here[trim.reversed ? 0 : 1] == there[next.reversed ? 1 : 0];
            if (goes_on) continue;
            note(where, fmt::format("curve {} does not end at the vertex where the next one starts", t));
            return false;
        }
        const std::vector<Vec2> polygon = points_of(loop);
        Vec2 lo = polygon[0], hi = lo;
        double twice_area = 0;
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Vec2 p = polygon[k] - polygon[0], q = polygon[(k + 1) % polygon.size()] - polygon[0];
            twice_area += p.x() * q.y() - p.y() * q.x();
            lo = lo.cwiseMin(polygon[k]);
            hi = hi.cwiseMax(polygon[k]);
        }
        // Edges tell which way their loops run; this finds a patch whose parameters are the other way round.
        constexpr double clearly = 1e-6;
        if ((l == 0 ? -twice_area : twice_area) > clearly * (hi - lo).prod()) {
            note(where,
                 l == 0 ? "the outer loop does not run counter-clockwise" : "a hole does not run clockwise");
            return false;
        }
        if (l > 0 && !is_around(loops[0], polygon[0])) {
            note(where, "a hole outside the outer loop");
            return false;
        }
        return true;
    }

    static std::vector<Vec2> points_of(const std::vector<TrimCurve>& loop) {
        std::vector<Vec2> points;
        for (const TrimCurve& trim : loop) {
            constexpr int steps = 16;
            const auto parts = pieces(trim.curve);
            for (const auto& piece : parts)
                for (int k = 0; k < steps; ++k)
                    points.push_back(piece.evaluate(piece.begin + (piece.end - piece.begin) * k / steps)[0]);
        }
        return points;
    }
    static bool is_around(const std::vector<TrimCurve>& loop, const Vec2& q) {
        double turn = 0;
        for (const TrimCurve& trim : loop)
            for (const auto& piece : pieces(trim.curve)) {
                const auto angle = swept(piece, q, Vec2::Constant(1e-300));
                if (!angle) return true;  // where loops touch, edges are judged
                turn += *angle;
            }
        return turn > std::numbers::pi;
    }

    void judge_uses() {
        for (const Subject& subject : subjects_)
            for (const std::uint32_t e : subject.edges)
                for (const Subject::Use& use : subject.uses[e]) ++used_[e][use.reversed ? 1 : 0];
        for (std::size_t e = 0; e < used_.size(); ++e) {
            const auto [forwards, backwards] = used_[e];
            if (forwards == 1 && backwards == 1) continue;
            const std::size_t own = cell_.edges.size();
            note(e < own ? edge_path(e) : closing_path(edge_path(e - own)),
                 forwards + backwards == 1
                     ? std::string("the boundary is not closed: one face has this edge")
                     : fmt::format(
                           "the boundary is not closed: faces use this edge {} times along its curve and {} "
                           "times against it",
                           forwards, backwards));
        }
    }

    std::span<const Subject> subjects_;
    const Closing& closing_;
    const Space<Interval>* space_;         // of the part under judgement
    double most_stated_ = most_stated(0);  // or the largest error of the vertices, which feet take over
    std::vector<double> vertex_bounds_, edge_bounds_;  // the cell's own first
    std::vector<std::array<int, 2>> used_;             // each edge, along and against its curve
};

}  // namespace

void certify_closing(std::span<const Subject> subjects, std::span<const EdgeBound> edges,
                     const CheckOptions& options, Certificate& certificate) {
    if (subjects.front().cell.closing) Closings(subjects, edges, options, certificate).run();
}

}  // namespace vcell::check
