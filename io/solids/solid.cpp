#include "solid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/curves/reversed_curve.hpp"
#include "../../core/errors.hpp"
#include "../pictures/trims.hpp"

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

using Homogeneous = Eigen::Vector4d;

// The polar form of a Bezier curve over `domain` at as many parameters as its degree.
Homogeneous polar(std::vector<Homogeneous> points, const std::array<double, 2>& domain,
                  const std::vector<double>& at) {
    for (const double t : at) {
        const double s = (t - domain[0]) / (domain[1] - domain[0]);
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
            points[i] = (1 - s) * points[i] + s * points[i + 1];
        points.pop_back();
    }
    return points[0];
}

double choose(int n, int k) { return k == 0 ? 1 : choose(n - 1, k - 1) * n / k; }

// The image of a straight line in a patch's parameters, with the line's parameter: a Bezier curve of degree
// m + n. Its control point k has all products of m values of u and n of v, k of them from the line's end.
RationalCurve3 image(const RationalPatch& s, const RationalCurve2& line) {
    const int m = s.degree_u, n = s.degree_v;
    const Eigen::Vector3d a = line.points[0], b = line.points[1];
    const auto mixed = [](double from, double to, int degree, int ends) {
        std::vector<double> at(static_cast<std::size_t>(degree), from);
        std::fill_n(at.begin(), ends, to);
        return at;
    };
    RationalCurve3 curve;
    curve.degree = m + n;
    curve.knots.assign(static_cast<std::size_t>(m + n + 1), line.domain_begin());
    for (int k = 0; k <= m + n; ++k) curve.knots.push_back(line.domain_end());
    for (int k = 0; k <= m + n; ++k) {
        Homogeneous sum = Homogeneous::Zero();
        for (int i = std::max(0, k - n); i <= std::min(m, k); ++i) {
            std::vector<Homogeneous> along_v;
            for (int l = 0; l <= n; ++l) {
                std::vector<Homogeneous> along_u;
                for (int j = 0; j <= m; ++j) {
                    const Eigen::Vector4d& p = s.point(j, l);
                    along_u.push_back({p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3]});
                }
                along_v.push_back(polar(std::move(along_u), s.domain_u, mixed(a[0], b[0], m, i)));
            }
            sum += choose(m, i) * choose(n, k - i) / choose(m + n, k) *
                   polar(std::move(along_v), s.domain_v, mixed(a[1], b[1], n, k - i));
        }
        sum *= std::pow(a[2], m + n - k) * std::pow(b[2], k);
        curve.points.push_back({sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3], sum[3]});
    }
    return curve;
}

class Builder {
public:
    Builder(const Shell& shell, std::size_t cell_faces)
        : shell_(shell), cell_faces_(cell_faces), cuts_(shell.edges.size()) {
        solid_.off = shell.off_plane;
    }

    Solid build() {
        for (const CellVertex& v : shell_.vertices) solid_.vertices.push_back(v.point);
        find_cuts();
        for (std::size_t e = 0; e < cuts_.size(); ++e) cut(e);
        for (std::uint32_t f = 0; f < shell_.faces.size(); ++f)
            for (const TrimmedPatch& patch : shell_.faces[f].patches) add_face(f, patch);
        check_uses();
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
        for (const CellFace& face : shell_.faces)
            for (const TrimmedPatch& patch : face.patches)
                for (const auto& loop : patch.loops)
                    for (const TrimCurve& c : loop)
                        if (c.edge)
                            for (const double t : {c.curve.domain_begin(), c.curve.domain_end()})
                                cuts_[*c.edge].at.push_back(
                                    edge_parameter(c, shell_.edges[*c.edge].curve, t));
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
        Solid::Face face{f, &patch.surface, f >= cell_faces_, {}};
        for (const auto& loop : patch.loops) {
            face.loops.emplace_back();
            for (std::size_t i = 0; i < loop.size(); ++i)
                if (loop[i].edge)
                    add_parts(loop[i], face.loops.back());
                else
                    face.loops.back().push_back(along_seam(loop, i, patch.surface));
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
    Solid::Use along_seam(const std::vector<TrimCurve>& loop, std::size_t i, const RationalPatch& surface) {
        const TrimCurve& c = loop[i];
        const auto known = seams_.find(c.seam.value());
        if (known != seams_.end()) {
            const Solid::Edge& seam = solid_.edges[known->second];
            RationalCurve2 trim =
                over_domain(reversed(c.curve), seam.curve.domain_begin(), seam.curve.domain_end());
            note_along(seam.curve, trim, surface);
            return {known->second, true, std::move(trim)};
        }
        const TrimCurve &before = loop[(i + loop.size() - 1) % loop.size()],
                        &after = loop[(i + 1) % loop.size()];
        if (!before.edge || !after.edge || c.curve.degree != 1 || c.curve.points.size() != 2)
            throw InternalError("solid_of: a seam that is not straight from edge to edge");
        const auto e = static_cast<std::uint32_t>(solid_.edges.size());
        solid_.edges.push_back({{cuts_[*before.edge].vertices[place(before)[before.reversed ? 0 : 1]],
                                 cuts_[*after.edge].vertices[place(after)[after.reversed ? 1 : 0]]},
                                image(surface, c.curve)});
        const Solid::Edge& seam = solid_.edges.back();
        note(solid_.vertices[seam.vertices[0]], seam.curve.evaluate(seam.curve.domain_begin()));
        note(solid_.vertices[seam.vertices[1]], seam.curve.evaluate(seam.curve.domain_end()));
        note_along(seam.curve, c.curve, surface);
        seams_[*c.seam] = e;
        return {e, false, c.curve};
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
    std::size_t cell_faces_;
    std::vector<Cuts> cuts_;
    std::unordered_map<std::uint32_t, std::uint32_t> seams_;  // number -> edge
    Solid solid_;
};

}  // namespace

Solid solid_of(const Shell& shell, std::size_t cell_faces) { return Builder(shell, cell_faces).build(); }

}  // namespace vcell
