#include "structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "paths.hpp"

namespace vcell::check {
namespace {

class Structure {
public:
    Structure(const Cell& cell, const SceneGeometry& geometry, Certificate& certificate)
        : cell_(cell), geometry_(geometry), certificate_(certificate) {}

    void run() {
        check_elements(
            {"", cell_.vertices, cell_.edges, cell_.faces, cell_.vertices.size(), cell_.edges.size(), false});
        if (!cell_.closing) return;
        const auto& [vertices, edges, faces] = *cell_.closing;
        check_elements({"closing.", vertices, edges, faces, cell_.vertices.size() + vertices.size(),
                        cell_.edges.size() + edges.size(), true});
    }

private:
    /// The cell's own elements, or those that close it, and how many vertices and edges these may name.
    struct Elements {
        const char* prefix;  // of paths
        const std::vector<CellVertex>& vertices;
        const std::vector<CellEdge>& edges;
        const std::vector<CellFace>& faces;
        std::size_t known_vertices, known_edges;
        bool close;  // without lengths, areas and seams; certify_closing() knows which sites they may have
    };

    void check_elements(const Elements& all) {
        check_vertex_structure(all);
        check_edge_structure(all);
        check_face_structure(all);
    }

    // Paths are functions that compose them: most are never read.
    template <class Where>
    void note(const Where& where, std::string what) {
        certificate_.refute(where(), std::move(what));
    }

    template <class Where>
    void check_sites_exist(const Where& where, std::span<const Site> sites) {
        for (const Site& s : sites)
            if (!geometry_.exists(s))
                note(where, fmt::format("names {}, which is no object, side of the box or end of the stretch",
                                        to_string(s)));
    }
    template <class Where>
    void check_amount(const Where& where, double v) {
        if (!(v >= 0) || std::isinf(v)) note(where, fmt::format("is {}, must be finite and not negative", v));
    }

    template <int Dim, class Where>
    void check_curve(const Where& where, const RationalCurve<Dim>& c) {
        if (c.degree < 1 || c.degree > kMaxDegree) return note(where, fmt::format("degree {}", c.degree));
        const std::size_t d = c.degree, n = c.points.size();
        if (n < d + 1) return note(where, fmt::format("{} control points for degree {}", n, d));
        if (c.knots.size() != n + d + 1)
            return note(where,
                        fmt::format("{} knots for {} control points of degree {}", c.knots.size(), n, d));
        for (const double k : c.knots)
            if (!std::isfinite(k)) return note(where, "a knot is not finite");
        if (!std::ranges::is_sorted(c.knots)) return note(where, "knots decrease");
        if (c.knots[0] != c.knots[d] || c.knots[n] != c.knots[n + d] || !(c.knots[d] < c.knots[n]))
            return note(where, "knot vector is not clamped");
        for (std::size_t i = 1; i < n; ++i)
            if (c.knots[i] == c.knots[i + d])
                return note(where, "an inner knot occurs more often than the degree");
        check_control_points<Dim>(where, c.points);
    }
    template <int Dim, class Where>
    void check_control_points(const Where& where, std::span<const Eigen::Matrix<double, Dim + 1, 1>> points) {
        for (const auto& p : points) {
            if (!p.allFinite()) return note(where, "a control point is not finite");
            if (!(p[Dim] > 0)) return note(where, fmt::format("weight {}, must be positive", p[Dim]));
        }
    }

    void check_vertex_structure(const Elements& all) {
        for (std::size_t i = 0; i < all.vertices.size(); ++i) {
            const CellVertex& v = all.vertices[i];
            const auto at = [&all, i](const char* key) {
                return [&all, i, key] { return all.prefix + vertex_path(i) + key; };
            };
            if (!v.point.allFinite()) note(at(".point"), "is not finite");
            if (!std::isfinite(v.radius)) note(at(".radius"), "is not finite");
            check_amount(at(".error"), v.error);
            check_sites_exist(at(".sites"), v.sites);
            if (std::ranges::adjacent_find(v.sites, std::greater_equal()) != v.sites.end())
                note(at(".sites"), "are not ascending, each once");
        }
    }

    void check_edge_structure(const Elements& all) {
        for (std::size_t i = 0; i < all.edges.size(); ++i) {
            const CellEdge& e = all.edges[i];
            const auto at = [&all, i](const char* key) {
                return [&all, i, key] { return all.prefix + edge_path(i) + key; };
            };
            if (!all.close) {
                check_sites_exist(at(".sites"), e.sites);
                check_sites_exist(at(".extra_sites"), e.extra_sites);
                check_amount(at(".length"), e.length);
            }
            if (e.vertices.size() != 0 && e.vertices.size() != 2)
                note(at(".vertices"), fmt::format("are {}, must be two or none", e.vertices.size()));
            for (const std::uint32_t v : e.vertices)
                if (v >= all.known_vertices) note(at(".vertices"), fmt::format("no vertex {}", v));
            check_amount(at(".error"), e.error);
            check_curve<3>(at(".curve"), e.curve);
        }
    }

    void check_face_structure(const Elements& all) {
        for (std::size_t f = 0; f < all.faces.size(); ++f) {
            const CellFace& face = all.faces[f];
            const auto at = [&all, f](const char* key) {
                return [&all, f, key] { return all.prefix + face_path(f) + key; };
            };
            if (!all.close) {
                check_sites_exist(at(".site"), std::span(&face.site, 1));
                check_sites_exist(at(".extra_sites"), face.extra_sites);
                check_amount(at(".area"), face.area);
            }
            if (face.patches.empty()) note(at(".patches"), "are none");
            for (std::size_t p = 0; p < face.patches.size(); ++p) check_patch_structure(all, f, p);
        }
    }

    void check_patch_structure(const Elements& all, std::size_t f, std::size_t p) {
        const auto where = [&] { return all.prefix + patch_path(f, p); };
        const TrimmedPatch& patch = all.faces[f].patches[p];
        const RationalPatch& s = patch.surface;
        for (const int degree : {s.degree_u, s.degree_v})
            if (degree < 1 || degree > kMaxDegree) return note(where, fmt::format("degree {}", degree));
        if (s.points.size() != static_cast<std::size_t>((s.degree_u + 1) * (s.degree_v + 1)))
            return note(where, fmt::format("{} control points for degrees {} and {}", s.points.size(),
                                           s.degree_u, s.degree_v));
        for (const auto& domain : {s.domain_u, s.domain_v})
            if (!(domain[0] < domain[1]) || !std::isfinite(domain[1] - domain[0]))
                note(where, "empty domain");
        check_control_points<3>(where, s.points);
        if (patch.loops.empty()) note([&] { return where() + ".loops"; }, "are none");
        for (std::size_t l = 0; l < patch.loops.size(); ++l) {
            if (patch.loops[l].empty()) note([&] { return all.prefix + loop_path(f, p, l); }, "is empty");
            for (std::size_t t = 0; t < patch.loops[l].size(); ++t) {
                const TrimCurve& trim = patch.loops[l][t];
                const auto at = [&] { return fmt::format("{}{}[{}]", all.prefix, loop_path(f, p, l), t); };
                if (all.close ? !trim.edge || trim.seam : trim.edge && trim.seam)
                    note(at, all.close ? "must name an edge" : "must name an edge or a seam, not both");
                if (trim.edge && *trim.edge >= all.known_edges)
                    note(at, fmt::format("no edge {}", *trim.edge));
                check_curve<2>([&] { return at() + ".curve"; }, trim.curve);
            }
        }
    }

    const Cell& cell_;
    const SceneGeometry& geometry_;
    Certificate& certificate_;
};

}  // namespace

void certify_structure(const Cell& cell, const SceneGeometry& geometry, Certificate& certificate) {
    Structure(cell, geometry, certificate).run();
}

}  // namespace vcell::check
