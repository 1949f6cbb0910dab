#include "solid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/curves/reversed_curve.hpp"
#include "../../core/errors.hpp"
#include "../pictures/trims.hpp"
#include "tip_caps.hpp"

namespace vcell {

namespace {

// Of a domain's length: what is one parameter but for rounding.
constexpr double one_parameter = 1e-12;

template <int Dim>
double domain_length(const RationalCurve<Dim>& curve) {
    return curve.domain_end() - curve.domain_begin();
}

// restricted(), but knots that are `from` or `to` but for rounding are that.
template <int Dim>
RationalCurve<Dim> part_between(RationalCurve<Dim> curve, double from, double to) {
    const double apart = one_parameter * domain_length(curve);
    for (double& knot : curve.knots)
        for (const double t : {from, to})
            if (std::abs(knot - t) <= apart) knot = t;
    return restricted(curve, from, to);
}

// The same curve over another domain, increasing.
template <int Dim>
RationalCurve<Dim> over_domain(RationalCurve<Dim> curve, double begin, double end) {
    const double from = curve.domain_begin(), to = curve.domain_end();
    for (double& knot : curve.knots)
        knot = knot == from ? begin : knot == to ? end : begin + (knot - from) / (to - from) * (end - begin);
    return curve;
}

double choose(int n, int k) { return k == 0 ? 1 : choose(n - 1, k - 1) * n / k; }

/// A polynomial over [0, 1] by its Bernstein coefficients.
using BernsteinForm = std::vector<double>;

BernsteinForm product(const BernsteinForm& a, const BernsteinForm& b) {
    const int m = static_cast<int>(a.size()) - 1, n = static_cast<int>(b.size()) - 1;
    BernsteinForm result(static_cast<std::size_t>(m + n + 1), 0);
    for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j)
            result[static_cast<std::size_t>(i + j)] += choose(m, i) * choose(n, j) / choose(m + n, i + j) *
                                                       a[static_cast<std::size_t>(i)] *
                                                       b[static_cast<std::size_t>(j)];
    return result;
}

// The patch's Bernstein polynomials in one parameter along a span of a curve, times the weight's power.
// Where the parameter is one all along it they are numbers. Elsewhere part k along the curve has the
// coefficients a - from w and to w - a over the domain's length, a the parameter times the weight.
std::vector<BernsteinForm> basis_along(const std::array<double, 2>& domain, int degree,
                                       const RationalCurve2& span, int coordinate, bool is_one) {
    BernsteinForm up, down;
    for (const Eigen::Vector3d& p : span.points) {
        const double weight = is_one ? 1 : p[2];
        up.push_back(weight * (p[coordinate] - domain[0]) / (domain[1] - domain[0]));
        down.push_back(weight * (domain[1] - p[coordinate]) / (domain[1] - domain[0]));
        if (is_one) break;
    }
    std::vector<BernsteinForm> result;
    for (int k = 0; k <= degree; ++k) {
        BernsteinForm term{choose(degree, k)};
        for (int i = 0; i < degree; ++i) term = product(term, i < k ? up : down);
        result.push_back(std::move(term));
    }
    return result;
}

// The image of one span of a curve in a patch's parameters, as homogeneous control points: whether a
// parameter is one all along the curve is told by all of it.
std::vector<Eigen::Vector4d> image_of_span(const RationalPatch& s, const RationalCurve2& span,
                                           const std::array<bool, 2>& is_one) {
    const std::vector<BernsteinForm> along_u = basis_along(s.domain_u, s.degree_u, span, 0, is_one[0]),
                                     along_v = basis_along(s.domain_v, s.degree_v, span, 1, is_one[1]);
    std::vector<Eigen::Vector4d> points(along_u[0].size() + along_v[0].size() - 1, Eigen::Vector4d::Zero());
    for (int i = 0; i <= s.degree_u; ++i)
        for (int j = 0; j <= s.degree_v; ++j) {
            const Eigen::Vector4d& p = s.point(i, j);
            const BernsteinForm factor =
                product(along_u[static_cast<std::size_t>(i)], along_v[static_cast<std::size_t>(j)]);
            for (std::size_t k = 0; k < points.size(); ++k)
                points[k] += factor[k] * p[3] * Eigen::Vector4d(p[0], p[1], p[2], 1);
        }
    return points;
}

// The image of a curve in a patch's parameters, with the curve's parameter: of as many times its degree as
// the patch has in the parameters that change along it, span by span.
RationalCurve3 image(const RationalPatch& s, const RationalCurve2& c) {
    std::vector<double> ends(c.knots.begin(), c.knots.end());
    ends.erase(std::ranges::unique(ends).begin(), ends.end());
    RationalCurve3 curve;
    const std::array<bool, 2> is_one{is_at_one(c, 0), is_at_one(c, 1)};
    curve.degree = c.degree * ((is_one[0] ? 0 : s.degree_u) + (is_one[1] ? 0 : s.degree_v));
    const auto times = static_cast<std::size_t>(curve.degree);
    curve.knots.push_back(ends.front());
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
        const auto span = image_of_span(s, restricted(c, ends[i], ends[i + 1]), is_one);
        for (std::size_t k = i == 0 ? 0 : 1; k < span.size(); ++k)
            curve.points.push_back(
                {span[k][0] / span[k][3], span[k][1] / span[k][3], span[k][2] / span[k][3], span[k][3]});
        curve.knots.insert(curve.knots.end(), times, ends[i]);
    }
    curve.knots.insert(curve.knots.end(), times + 1, ends.back());
    return curve;
}

class Builder {
public:
    Builder(const Shell& shell, std::size_t cell_faces, double shortest)
        : shell_(shell),
          capped_(with_tip_caps(shell.faces)),
          cell_faces_(cell_faces),
          shortest_(shortest),
          cuts_(shell.edges.size()),
          is_used_(shell.edges.size(), false) {
        solid_.off = shell.off_plane;
    }

    Solid build() {
        for (const CellVertex& v : shell_.vertices) solid_.vertices.push_back(v.point);
        solid_.vertices.insert(solid_.vertices.end(), capped_.places.begin(), capped_.places.end());
        find_cuts();
        for (std::size_t e = 0; e < cuts_.size(); ++e)
            if (is_used_[e]) cut(e);
        for (std::uint32_t f = 0; f < capped_.faces.size(); ++f)
            for (const TrimmedPatch& patch : capped_.faces[f].patches) add_face(f, patch);
        check_uses();
        drop_short_edges();
        find_parts();
        return std::move(solid_);
    }

private:
    /// Where an edge of the shell is cut: parameters, ends included, the vertices there, and the first of the
    /// solid's edges between them.
    struct Cuts {
        std::vector<double> at;
        std::vector<std::uint32_t> vertices;
        std::uint32_t first = 0;
    };

    void find_cuts() {
        for (std::size_t e = 0; e < cuts_.size(); ++e) {
            const RationalCurve3& curve = shell_.edges[e].curve;
            cuts_[e].at = {curve.domain_begin(), curve.domain_end()};
        }
        for (const CellFace& face : capped_.faces)
            for (const TrimCurve& c : face.trims())
                if (c.edge) {
                    is_used_[*c.edge] = true;
                    for (const double t : {c.curve.domain_begin(), c.curve.domain_end()})
                        cuts_[*c.edge].at.push_back(edge_parameter(c, shell_.edges[*c.edge].curve, t));
                }
        for (std::size_t e = 0; e < cuts_.size(); ++e) {
            const RationalCurve3& curve = shell_.edges[e].curve;
            std::vector<double>& at = cuts_[e].at;
            std::ranges::sort(at);
            const double apart = one_parameter * domain_length(curve);
            const auto same = std::ranges::unique(at, [&](double s, double t) { return t - s <= apart; });
            at.erase(same.begin(), same.end());
            at.front() = curve.domain_begin();
            at.back() = curve.domain_end();
        }
    }

    void cut(std::size_t e) {
        const CellEdge& edge = shell_.edges[e];
        auto& [at, vertices, first] = cuts_[e];
        solid_.off = std::max(solid_.off, edge.error);
        for (const double t : at) {
            const bool begins = t == at.front(), ends = t == at.back();
            if (begins || ends ? !edge.vertices.empty() : false)
                vertices.push_back(edge.vertices[begins ? 0 : 1]);
            else
                vertices.push_back(ends ? vertices.front() : add_vertex(edge.curve.evaluate(t)));
            note(solid_.vertices[vertices.back()], edge.curve.evaluate(t));
        }
        first = static_cast<std::uint32_t>(solid_.edges.size());
        for (std::size_t i = 0; i + 1 < at.size(); ++i)
            solid_.edges.push_back(
                {{vertices[i], vertices[i + 1]},
                 at.size() == 2 ? edge.curve : part_between(edge.curve, at[i], at[i + 1])});
    }

    std::uint32_t add_vertex(const Vec3& p) {
        solid_.vertices.push_back(p);
        return static_cast<std::uint32_t>(solid_.vertices.size() - 1);
    }

    void note(const Vec3& p, const Vec3& q) { solid_.off = std::max(solid_.off, (p - q).norm()); }

    void add_face(std::uint32_t f, const TrimmedPatch& patch) {
        Solid::Face face{f, patch.surface, f >= cell_faces_, {}};
        for (const auto& loop : patch.loops) {
            face.loops.emplace_back();
            for (std::size_t i = 0; i < loop.size(); ++i)
                if (loop[i].edge)
                    add_parts(loop[i], face.loops.back());
                else if (loop[i].seam)
                    face.loops.back().push_back(along_seam(f, loop, i, patch.surface));
        }
        solid_.faces.push_back(std::move(face));
    }

    // The places of a trim's ends among the cuts of its edge, in the edge's sense.
    std::array<std::size_t, 2> place(const TrimCurve& c) const {
        const std::vector<double>& at = cuts_[*c.edge].at;
        const RationalCurve3& curve = shell_.edges[*c.edge].curve;
        std::array<double, 2> ends{edge_parameter(c, curve, c.curve.domain_begin()),
                                   edge_parameter(c, curve, c.curve.domain_end())};
        if (c.reversed) std::swap(ends[0], ends[1]);
        std::array<std::size_t, 2> places{};
        for (const std::size_t k : {0u, 1u})
            places[k] = static_cast<std::size_t>(
                std::ranges::min_element(at, {}, [&](double t) { return std::abs(t - ends[k]); }) -
                at.begin());
        return places;
    }

    void add_parts(const TrimCurve& c, std::vector<Solid::Use>& loop) const {
        const auto& [at, vertices, first] = cuts_[*c.edge];
        const auto [from, to] = place(c);
        const RationalCurve2 along = over_domain(c.reversed ? reversed(c.curve) : c.curve, at[from], at[to]);
        std::vector<Solid::Use> parts;
        for (std::size_t i = from; i < to; ++i)
            parts.push_back({first + static_cast<std::uint32_t>(i), c.reversed,
                             to == from + 1 ? along : part_between(along, at[i], at[i + 1])});
        if (c.reversed) std::ranges::reverse(parts);
        loop.insert(loop.end(), parts.begin(), parts.end());
    }

    // A seam's curve in space is that of the first patch along it.
    Solid::Use along_seam(std::uint32_t f, const std::vector<TrimCurve>& loop, std::size_t i,
                          const RationalPatch& surface) {
        const TrimCurve& c = loop[i];
        const auto known = seams_.find(c.seam.value());
        if (known != seams_.end()) {
            const Solid::Edge& seam = solid_.edges[known->second];
            RationalCurve2 trim =
                over_domain(reversed(c.curve), seam.curve.domain_begin(), seam.curve.domain_end());
            note_along(seam.curve, trim, surface);
            return {known->second, true, std::move(trim)};
        }
        const auto e = static_cast<std::uint32_t>(solid_.edges.size());
        RationalCurve3 curve = image(surface, c.curve);
        solid_.edges.push_back({seam_ends(f, loop, i, curve), std::move(curve)});
        const Solid::Edge& seam = solid_.edges.back();
        note(solid_.vertices[seam.vertices[0]], seam.curve.evaluate(seam.curve.domain_begin()));
        note(solid_.vertices[seam.vertices[1]], seam.curve.evaluate(seam.curve.domain_end()));
        note_along(seam.curve, c.curve, surface);
        seams_[*c.seam] = e;
        return {e, false, c.curve};
    }

    // A seam runs from edge to edge, or from or to a cap or a tip, or alone around a face that has no edge
    // there.
    std::array<std::uint32_t, 2> seam_ends(std::uint32_t f, const std::vector<TrimCurve>& loop, std::size_t i,
                                           const RationalCurve3& curve) {
        if (loop.size() == 1) {
            const std::uint32_t v = add_vertex(curve.evaluate(curve.domain_begin()));
            return {v, v};
        }
        const auto at_caps = capped_.ends.find(*loop[i].seam);
        std::array<std::uint32_t, 2> ends{};
        for (const std::size_t k : {0u, 1u}) {
            const TrimCurve& next = loop[(i + (k == 0 ? loop.size() - 1 : 1)) % loop.size()];
            const double t = k == 0 ? curve.domain_begin() : curve.domain_end();
            if (at_caps != capped_.ends.end() && at_caps->second[k])
                ends[k] = static_cast<std::uint32_t>(shell_.vertices.size()) + *at_caps->second[k];
            else if (next.edge)
                ends[k] = cuts_[*next.edge].vertices[place(next)[next.reversed == (k == 0) ? 0 : 1]];
            else if (next.is_tip())
                ends[k] = tip(f, next, curve.evaluate(t));
            else
                throw InternalError("solid_of: seams that meet");
        }
        return ends;
    }

    // A face has two at most: one that it lies above in its patches' parameters, and one that it lies below.
    std::uint32_t tip(std::uint32_t f, const TrimCurve& c, const Vec3& p) {
        const bool is_below =
            c.curve.evaluate(c.curve.domain_begin()).x() < c.curve.evaluate(c.curve.domain_end()).x();
        const auto [at, is_new] = tips_.try_emplace({f, is_below}, 0);
        if (is_new) at->second = add_vertex(p);
        return at->second;
    }

    void note_along(const RationalCurve3& curve, const RationalCurve2& trim, const RationalPatch& surface) {
        constexpr int steps = 16;
        for (int k = 0; k <= steps; ++k) {
            const double s = static_cast<double>(k) / steps,
                         t = (1 - s) * curve.domain_begin() + s * curve.domain_end();
            const Vec2 uv = trim.evaluate(t);
            note(curve.evaluate(t), surface.evaluate(uv.x(), uv.y()));
        }
    }

    template <class F>
    void for_each_use(F f) const {
        for (std::uint32_t k = 0; k < solid_.faces.size(); ++k)
            for (const auto& loop : solid_.faces[k].loops)
                for (const Solid::Use& use : loop) f(k, use);
    }

    void check_uses() const {
        std::vector<std::array<int, 2>> uses(solid_.edges.size(), {0, 0});
        for_each_use([&](std::uint32_t, const Solid::Use& use) { ++uses[use.edge][use.reversed ? 1 : 0]; });
        if (std::ranges::any_of(uses, [](const auto& n) { return n[0] != 1 || n[1] != 1; }))
            throw InternalError("solid_of: an edge that is not used once each way");
    }

    // Where three sides of the box run through a point of the base, or a curve through a corner, rounding may
    // leave an edge of no length between: other programs have no curve there.
    void drop_short_edges() {
        const double most = std::max(shortest_, solid_.off);
        std::vector<std::uint32_t> leader(solid_.vertices.size()), number(solid_.edges.size(), UINT32_MAX);
        std::iota(leader.begin(), leader.end(), 0u);
        const auto find = [&](std::uint32_t v) {
            while (leader[v] != v) v = leader[v];
            return v;
        };
        std::vector<Solid::Edge> kept;
        for (std::size_t e = 0; e < solid_.edges.size(); ++e) {
            const auto& [ends, curve] = solid_.edges[e];
            const Vec3& start = solid_.vertices[ends[0]];
            const bool is_short =
                ends[0] != ends[1] && std::ranges::all_of(curve.points, [&](const Eigen::Vector4d& p) {
                    return (p.head<3>() - start).norm() <= most;
                });
            if (is_short) {
                const std::uint32_t a = find(ends[0]), b = find(ends[1]);
                leader[std::max(a, b)] = std::min(a, b);
                continue;
            }
            number[e] = static_cast<std::uint32_t>(kept.size());
            kept.push_back(solid_.edges[e]);
        }
        if (kept.size() == solid_.edges.size()) return;
        solid_.edges = std::move(kept);
        for (Solid::Edge& edge : solid_.edges) {
            for (std::uint32_t& v : edge.vertices) v = find(v);
            note(solid_.vertices[edge.vertices[0]], edge.curve.evaluate(edge.curve.domain_begin()));
            note(solid_.vertices[edge.vertices[1]], edge.curve.evaluate(edge.curve.domain_end()));
        }
        for (Solid::Face& face : solid_.faces) {
            for (auto& loop : face.loops) {
                std::erase_if(loop, [&](const Solid::Use& use) { return number[use.edge] == UINT32_MAX; });
                for (Solid::Use& use : loop) use.edge = number[use.edge];
            }
            // What had short edges alone for its boundary has no extent.
            if (face.loops.front().empty())
                face.loops.clear();
            else
                std::erase_if(face.loops, [](const auto& loop) { return loop.empty(); });
        }
        std::erase_if(solid_.faces, [](const Solid::Face& face) { return face.loops.empty(); });
        drop_lone_vertices();
    }

    void drop_lone_vertices() {
        std::vector<std::uint32_t> number(solid_.vertices.size(), UINT32_MAX);
        std::vector<Vec3> kept;
        for (Solid::Edge& edge : solid_.edges)
            for (std::uint32_t& v : edge.vertices) {
                if (number[v] == UINT32_MAX) {
                    number[v] = static_cast<std::uint32_t>(kept.size());
                    kept.push_back(solid_.vertices[v]);
                }
                v = number[v];
            }
        solid_.vertices = std::move(kept);
    }

    void find_parts() {
        std::vector<std::uint32_t> leader(solid_.faces.size());
        std::iota(leader.begin(), leader.end(), 0u);
        const auto find = [&](std::uint32_t f) {
            while (leader[f] != f) f = leader[f] = leader[leader[f]];
            return f;
        };
        std::vector<std::uint32_t> one_side(solid_.edges.size(), UINT32_MAX);
        for_each_use([&](std::uint32_t face, const Solid::Use& use) {
            std::uint32_t& other = one_side[use.edge];
            if (other == UINT32_MAX)
                other = face;
            else
                leader[find(face)] = find(other);
        });
        std::unordered_map<std::uint32_t, std::size_t> part_of;
        for (std::uint32_t f = 0; f < solid_.faces.size(); ++f) {
            const auto [at, is_new] = part_of.try_emplace(find(f), solid_.parts.size());
            if (is_new) solid_.parts.emplace_back();
            solid_.parts[at->second].push_back(f);
        }
    }

    const Shell& shell_;
    const CappedFaces capped_;
    std::size_t cell_faces_;
    double shortest_;
    std::vector<Cuts> cuts_;
    std::vector<bool> is_used_;  // what parts that are joined have left over is not
    std::unordered_map<std::uint32_t, std::uint32_t> seams_;        // number -> edge
    std::map<std::pair<std::uint32_t, bool>, std::uint32_t> tips_;  // face, and the side of the tip -> vertex
    Solid solid_;
};

}  // namespace

Solid solid_of(const Shell& shell, std::size_t cell_faces, double shortest) {
    return Builder(shell, cell_faces, shortest).build();
}

}  // namespace vcell
