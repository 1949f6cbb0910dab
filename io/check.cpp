#include "check.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <utility>

#include "../core/exact.hpp"
#include "check_curves.hpp"
#include "check_patches.hpp"
#include "check_scene.hpp"
#include "trims.hpp"

namespace vcell {
namespace {

using namespace check;

/// Relative; what a quadrature of the cell's author may have left in a length, which states no error.
constexpr double kLengthError = 1e-10;
/// Relative to an edge's parameters: trimming curves that share a place of it were rounded on their way
/// there.
constexpr double kPlaceRounding = 1e-12;

std::string vertex_path(std::size_t i) { return fmt::format("vertices[{}]", i); }
std::string edge_path(std::size_t i) { return fmt::format("edges[{}]", i); }
std::string face_path(std::size_t i) { return fmt::format("faces[{}]", i); }
std::string patch_path(std::size_t f, std::size_t p) { return fmt::format("faces[{}].patches[{}]", f, p); }
std::string loop_path(std::size_t f, std::size_t p, std::size_t l) {
    return fmt::format("faces[{}].patches[{}].loops[{}]", f, p, l);
}

std::string title(const Site& s) { return s.is_object() ? "object " + to_string(s) : to_string(s); }

bool contains(std::span<const Site> sites, const Site& s) {
    return std::ranges::find(sites, s) != sites.end();
}

class Judge {
public:
    Judge(const Cell& cell, const CheckOptions& options)
        : cell_(cell), scene_(cell.scene), options_(options), geometry_(cell.scene) {}

    std::vector<Finding> run() {
        check_vertex_structure();
        check_edge_structure();
        check_face_structure();
        if (!findings_.empty()) return std::move(findings_);  // what follows evaluates all of it
        prepare();
        check_uses();
        check_labels();
        check_loops();
        check_seams();
        check_euler();
        check_vertices();
        check_edges();
        check_faces();
        check_samples();
        check_integrals();
        check_clearances();
        check_neighbors();
        check_report();
        return std::move(findings_);
    }

private:
    void note(std::string where, std::string what) {
        findings_.push_back({std::move(where), std::move(what)});
    }

    double rounding() const { return geometry_.rounding(); }
    double height(const Vec3& p) const { return geometry_.height(p); }

    /// What contradicts that p, stated with an error, bounds the cell by the given sites; nothing if fine.
    std::optional<std::string> contradiction(const Vec3& p, double error, std::span<const Site> sites) const {
        const double r = height(p);
        for (const Site& s : sites) {
            const double e = geometry_.excess(s, p, r);
            // Moving p by `error` changes both distances by that much.
            if (std::abs(e) > 2 * error + geometry_.site_rounding(s))
                return fmt::format("{} is {:.3g} {} than the base", title(s), std::abs(e),
                                   e > 0 ? "farther" : "nearer");
        }
        if (r < geometry_.least_height() - error - rounding())
            return fmt::format("lies {:.3g} below the base", -r);
        if (const double out = -geometry_.inside_box(p); out > error + rounding())
            return fmt::format("lies {:.3g} outside the box", out);
        if (const auto i = geometry_.nearer(p, r - 2 * error))
            return fmt::format("object {} is {:.3g} nearer than the base", *i,
                               r - geometry_.distance_to(*i, p));
        return std::nullopt;
    }

    double edge_error(const TrimCurve& trim) const {
        return trim.edge ? cell_.edges[*trim.edge].error : scene_tolerance();
    }
    double scene_tolerance() const { return scene_.tolerance.value_or(1e-7 * scene_.box.diagonal()); }

    // --- Structure ----------------------------------------------------------------------------------

    void check_sites_exist(const std::string& where, std::span<const Site> sites) {
        for (const Site& s : sites)
            if (!geometry_.exists(s))
                note(where, fmt::format("names {}, which is no object, side of the box or end of the stretch",
                                        to_string(s)));
    }
    void check_amount(const std::string& where, double v) {
        if (!(v >= 0) || std::isinf(v)) note(where, fmt::format("is {}, must be finite and not negative", v));
    }

    template <int Dim>
    void check_curve(const std::string& where, const RationalCurve<Dim>& c) {
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
    template <int Dim>
    void check_control_points(const std::string& where,
                              std::span<const Eigen::Matrix<double, Dim + 1, 1>> points) {
        for (const auto& p : points) {
            if (!p.allFinite()) return note(where, "a control point is not finite");
            if (!(p[Dim] > 0)) return note(where, fmt::format("weight {}, must be positive", p[Dim]));
        }
    }

    void check_vertex_structure() {
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i) {
            const CellVertex& v = cell_.vertices[i];
            if (!v.point.allFinite()) note(vertex_path(i) + ".point", "is not finite");
            if (!std::isfinite(v.radius)) note(vertex_path(i) + ".radius", "is not finite");
            check_amount(vertex_path(i) + ".error", v.error);
            check_sites_exist(vertex_path(i) + ".sites", v.sites);
            if (std::ranges::adjacent_find(v.sites, std::greater_equal()) != v.sites.end())
                note(vertex_path(i) + ".sites", "are not ascending, each once");
        }
    }

    void check_edge_structure() {
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) {
            const CellEdge& e = cell_.edges[i];
            check_sites_exist(edge_path(i) + ".sites", e.sites);
            check_sites_exist(edge_path(i) + ".extra_sites", e.extra_sites);
            if (e.vertices.size() != 0 && e.vertices.size() != 2)
                note(edge_path(i) + ".vertices",
                     fmt::format("are {}, must be two or none", e.vertices.size()));
            for (const std::uint32_t v : e.vertices)
                if (v >= cell_.vertices.size())
                    note(edge_path(i) + ".vertices", fmt::format("no vertex {}", v));
            check_amount(edge_path(i) + ".error", e.error);
            check_amount(edge_path(i) + ".length", e.length);
            check_curve<3>(edge_path(i) + ".curve", e.curve);
        }
    }

    void check_face_structure() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const CellFace& face = cell_.faces[f];
            check_sites_exist(face_path(f) + ".site", std::span(&face.site, 1));
            check_sites_exist(face_path(f) + ".extra_sites", face.extra_sites);
            check_amount(face_path(f) + ".area", face.area);
            if (face.patches.empty()) note(face_path(f) + ".patches", "are none");
            for (std::size_t p = 0; p < face.patches.size(); ++p) check_patch_structure(f, p);
        }
    }

    void check_patch_structure(std::size_t f, std::size_t p) {
        const std::string where = patch_path(f, p);
        const TrimmedPatch& patch = cell_.faces[f].patches[p];
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
        if (patch.loops.empty()) note(where + ".loops", "are none");
        for (std::size_t l = 0; l < patch.loops.size(); ++l) {
            if (patch.loops[l].empty()) note(loop_path(f, p, l), "is empty");
            for (std::size_t t = 0; t < patch.loops[l].size(); ++t) {
                const TrimCurve& trim = patch.loops[l][t];
                const std::string at = fmt::format("{}[{}]", loop_path(f, p, l), t);
                if (trim.edge.has_value() == trim.seam.has_value()) note(at, "must name an edge or a seam");
                if (trim.edge && *trim.edge >= cell_.edges.size())
                    note(at, fmt::format("no edge {}", *trim.edge));
                check_curve<2>(at + ".curve", trim.curve);
            }
        }
    }

    // --- Preparation: pieces of all curves, uses of all edges ------------------------------------------

    /// One side of an edge: the face there, which may take several patches to run all along it.
    struct Use {
        std::size_t face;
        bool reversed;
        double begin, end;  // of the edge's parameters
    };

    void prepare() {
        for (const CellEdge& e : cell_.edges) edge_pieces_.push_back(pieces(e.curve));
        uses_.resize(cell_.edges.size());
        rim_.resize(cell_.edges.size());
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            for (std::size_t p = 0; p < cell_.faces[f].patches.size(); ++p) prepare_patch(f, p);
        for (std::size_t e = 0; e < uses_.size(); ++e) join_uses(e);
    }

    void prepare_patch(std::size_t f, std::size_t p) {
        const TrimmedPatch& trimmed = cell_.faces[f].patches[p];
        const Vec2 infinite = Vec2::Constant(HUGE_VAL);
        Patch patch{f,  p, &trimmed.surface, geometry_.scale(), {}, infinite, -infinite, infinite, -infinite,
                    {}, {}};
        for (const auto& c : trimmed.surface.points)
            patch.control_size = std::max(patch.control_size, c.head<3>().cwiseAbs().maxCoeff());
        for (const auto& loop : trimmed.loops) {
            auto& trims = patch.loops.emplace_back();
            for (const TrimCurve& trim : loop) {
                trims.push_back({&trim, edge_error(trim), pieces(trim.curve)});
                for (const auto& piece : trims.back().pieces)
                    for (std::size_t i = 0; i < piece.points.size(); ++i) {
                        patch.lo = patch.lo.cwiseMin(piece.control(i));
                        patch.hi = patch.hi.cwiseMax(piece.control(i));
                    }
                if (!trim.edge) {  // a seam may bulge anywhere: no bounds
                    patch.foot_lo = -infinite;
                    patch.foot_hi = infinite;
                    continue;
                }
                uses_[*trim.edge].push_back(use(f, trim));
                if (!geometry_.is_plane()) continue;
                for (const auto& piece : edge_pieces_[*trim.edge])
                    for (std::size_t i = 0; i < piece.points.size(); ++i) {
                        const Vec2 q = geometry_.chart(piece.control(i));
                        patch.foot_lo = patch.foot_lo.cwiseMin(q);
                        patch.foot_hi = patch.foot_hi.cwiseMax(q);
                    }
            }
        }
        // Control points may lie far beyond the domain, the curves do not.
        const Vec2 domain_lo(trimmed.surface.domain_u[0], trimmed.surface.domain_v[0]),
            domain_hi(trimmed.surface.domain_u[1], trimmed.surface.domain_v[1]);
        patch.lo = patch.lo.cwiseMax(domain_lo);
        patch.hi = patch.hi.cwiseMin(domain_hi);
        if ((patch.lo.array() > patch.hi.array()).any()) {
            note(patch_path(f, p) + ".loops", "lie outside the patch's domain");
            patch.lo = domain_lo;
            patch.hi = domain_hi;
        }
        for (int i = 0; i <= kGrid; ++i)
            for (int j = 0; j <= kGrid; ++j) {
                const Vec2 s(i / double(kGrid), j / double(kGrid));
                const Vec2 uv = patch.lo + s.cwiseProduct(patch.hi - patch.lo);
                patch.grid.push_back({uv, lift(patch, uv)});
            }
        patch.part = part_of(trimmed.surface, patch.lo, patch.hi);
        patches_.push_back(std::move(patch));
    }

    Use use(std::size_t face, const TrimCurve& trim) const {
        const RationalCurve3& curve = cell_.edges[*trim.edge].curve;
        const double a = edge_parameter(trim, curve, trim.curve.domain_begin());
        const double b = edge_parameter(trim, curve, trim.curve.domain_end());
        return {face, trim.reversed, std::min(a, b), std::max(a, b)};
    }

    /// Uses that follow each other on one side and in one face become one.
    void join_uses(std::size_t e) {
        std::vector<Use>& uses = uses_[e];
        const RationalCurve3& curve = cell_.edges[e].curve;
        const double near = kPlaceRounding * (curve.domain_end() - curve.domain_begin());
        std::ranges::sort(uses, {}, [](const Use& use) { return std::pair(use.reversed, use.begin); });
        std::vector<Use> joined;
        for (const Use& use : uses) {
            const bool goes_on = !joined.empty() && joined.back().reversed == use.reversed &&
                                 joined.back().face == use.face &&
                                 std::abs(joined.back().end - use.begin) <= near;
            if (goes_on)
                joined.back().end = use.end;
            else
                joined.push_back(use);
        }
        uses = std::move(joined);
        for (const Use& use : uses)
            if (use.begin > curve.domain_begin() + near || use.end < curve.domain_end() - near)
                note(edge_path(e),
                     fmt::format("face {} uses it from {} to {} only", use.face, use.begin, use.end));
    }

    // --- Topology -----------------------------------------------------------------------------------

    void check_uses() {
        for (std::size_t e = 0; e < uses_.size(); ++e) {
            const auto& uses = uses_[e];
            const auto& sites = cell_.edges[e].sites;
            if (uses.empty()) note(edge_path(e), "no face uses it");
            if (uses.size() > 2) note(edge_path(e), fmt::format("used {} times", uses.size()));
            if (uses.size() == 2 && uses[0].reversed == uses[1].reversed)
                note(edge_path(e), fmt::format("used twice in the same sense, by faces {} and {}",
                                               uses[0].face, uses[1].face));
            if (uses.size() != 1) continue;
            const Site& outer = sites[!uses[0].reversed];
            if (over_rim(e, outer))
                rim_[e] = outer;
            else
                note(edge_path(e),
                     fmt::format("used by face {} only, and not over the rim of the base region",
                                 uses[0].face));
        }
        check_sides();
    }

    /// Faces carry the sites that their edges name. Of an edge and a face that disagree, the one is to
    /// blame that disagrees with its other neighbours as well.
    void check_sides() {
        const auto differs = [&](std::size_t e, const Use& use) {
            return cell_.faces[use.face].site != cell_.edges[e].sites[use.reversed];
        };
        std::vector<int> wrong(cell_.faces.size()), all(cell_.faces.size());
        for (std::size_t e = 0; e < uses_.size(); ++e)
            for (const Use& use : uses_[e]) {
                ++all[use.face];
                wrong[use.face] += differs(e, use);
            }
        for (std::size_t e = 0; e < uses_.size(); ++e)
            for (const Use& use : uses_[e]) {
                if (!differs(e, use)) continue;
                const bool both = uses_[e].size() == 2 && differs(e, uses_[e][0]) && differs(e, uses_[e][1]);
                const Site &face = cell_.faces[use.face].site, &edge = cell_.edges[e].sites[use.reversed];
                if (!both && 2 * wrong[use.face] > all[use.face])
                    note(face_path(use.face) + ".site",
                         fmt::format("is {}, on that side of edge {} is {}", title(face), e, title(edge)));
                else
                    note(edge_path(e) + ".sites",
                         fmt::format("{} is {}, face {} there belongs to {}", use.reversed ? "right" : "left",
                                     title(edge), use.face, title(face)));
            }
    }

    bool over_rim(std::size_t e, const Site& site) const {
        return std::ranges::all_of(edge_pieces_[e], [&](const auto& piece) {
            for (const double s : {0.0, 0.25, 0.5, 0.75, 1.0}) {
                const Vec3 p = piece.evaluate(piece.begin + s * (piece.end - piece.begin))[0];
                if (geometry_.distance_from_rim(site, p) > full_error(e) + rounding()) return false;
            }
            return true;
        });
    }

    /// The labels of a vertex contain those of its edges; vertices are there for a reason.
    void check_labels() {
        std::vector<std::vector<std::size_t>> around(cell_.vertices.size());
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            const CellEdge& edge = cell_.edges[e];
            for (const std::uint32_t v : edge.vertices) {
                around[v].push_back(e);
                for (const std::span<const Site> sites :
                     {std::span<const Site>(edge.sites), std::span<const Site>(edge.extra_sites)})
                    for (const Site& s : sites)
                        if (!contains(cell_.vertices[v].sites, s))
                            note(vertex_path(v) + ".sites", fmt::format("lack {} of edge {}", title(s), e));
            }
        }
        for (std::size_t v = 0; v < around.size(); ++v) {
            if (cell_.vertices[v].sites.size() < 2) note(vertex_path(v) + ".sites", "are fewer than two");
            if (around[v].size() != 2 || around[v][0] == around[v][1]) continue;
            if (label(around[v][0]) == label(around[v][1]) &&
                label(around[v][0]).size() == cell_.vertices[v].sites.size())
                note(vertex_path(v),
                     fmt::format("splits edges {} and {}, which are one", around[v][0], around[v][1]));
        }
    }
    std::vector<Site> label(std::size_t e) const {
        std::vector<Site> sites = cell_.edges[e].extra_sites;
        sites.insert(sites.end(), cell_.edges[e].sites.begin(), cell_.edges[e].sites.end());
        std::ranges::sort(sites);
        sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
        return sites;
    }

    void check_loops() {
        for (const Patch& patch : patches_)
            for (std::size_t l = 0; l < patch.loops.size(); ++l) {
                const std::string where = loop_path(patch.face, patch.index, l);
                check_head_to_tail(patch, patch.loops[l], where);
                double area = 0;
                for (const Trim& trim : patch.loops[l])
                    for (const auto& piece : trim.pieces)
                        area += integrate(
                                    [&](double t) {
                                        const auto [q, d] = piece.evaluate(t);
                                        const Vec2 r = q - patch.lo;
                                        return Scalar(0.5 * (r.x() * d.y() - r.y() * d.x()));
                                    },
                                    piece.begin, piece.end, Scalar(kRounding * (patch.hi - patch.lo).prod()))
                                    .value[0];
                if (is_as_small_as_rounding(patch)) continue;
                if (l == 0 && !(area > 0)) note(where, "the outer loop does not run counter-clockwise");
                if (l > 0 && !(area < 0)) note(where, "a hole does not run clockwise");
            }
    }

    // Of faces between objects that all but meet: which way their loops run is not in the numbers.
    static bool is_as_small_as_rounding(const Patch& patch) {
        const Eigen::Array2d place = patch.lo.cwiseAbs().cwiseMax(patch.hi.cwiseAbs());
        return ((patch.hi - patch.lo).array() <= kPlaceRounding * place).any();
    }

    std::optional<std::uint32_t> end_vertex(const Trim& trim, bool at_end) const {
        if (!trim.curve->edge) return std::nullopt;
        const CellEdge& edge = cell_.edges[*trim.curve->edge];
        if (edge.vertices.empty()) return std::nullopt;
        const double t = edge_parameter(*trim.curve, edge.curve, at_end ? trim.end() : trim.begin());
        const double near = kPlaceRounding * (edge.curve.domain_end() - edge.curve.domain_begin());
        if (std::abs(t - edge.curve.domain_begin()) <= near) return edge.vertices[0];
        if (std::abs(t - edge.curve.domain_end()) <= near) return edge.vertices[1];
        return std::nullopt;
    }

    void check_head_to_tail(const Patch& patch, const std::vector<Trim>& loop, const std::string& where) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Trim &trim = loop[i], &next = loop[(i + 1) % loop.size()];
            const auto head = end_vertex(trim, true), tail = end_vertex(next, false);
            if (trim.curve->edge && next.curve->edge && head != tail)
                return note(where,
                            fmt::format("curve {} does not end at the vertex where the next one starts", i));
            const Vec2 a = evaluate(trim.pieces, trim.end()), b = evaluate(next.pieces, next.begin());
            const SurfacePoint s = lift(patch, a);
            const double gap = (lift(patch, b).p - s.p).norm();
            const double errors = trim.error + next.error + (head ? 2 * cell_.vertices[*head].error : 0);
            if (gap > errors + surface_rounding(patch, s, a))
                return note(where, fmt::format("gap of {:.3g} after curve {}", gap, i));
        }
    }

    void check_seams() {
        struct End {
            const Patch* patch;
            const Trim* trim;
            std::string where;
        };
        std::map<std::uint32_t, std::vector<End>> seams;
        for (const Patch& patch : patches_)
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t t = 0; t < patch.loops[l].size(); ++t)
                    if (const Trim& trim = patch.loops[l][t]; trim.curve->seam)
                        seams[*trim.curve->seam].push_back(
                            {&patch, &trim, fmt::format("{}[{}]", loop_path(patch.face, patch.index, l), t)});
        for (const auto& [number, ends] : seams) {
            if (ends.size() != 2) {
                note(ends[0].where, fmt::format("seam {} occurs {} times", number, ends.size()));
                continue;
            }
            const auto at = [](const End& e, double s) {
                return lift(*e.patch,
                            evaluate(e.trim->pieces, e.trim->begin() + s * (e.trim->end() - e.trim->begin())))
                    .p;
            };
            for (const double s : {0.0, 0.5, 1.0})
                if ((at(ends[0], s) - at(ends[1], 1 - s)).norm() > scene_tolerance()) {
                    note(ends[0].where,
                         fmt::format("seam {} does not run back on {}", number, ends[1].where));
                    break;
                }
        }
    }

    /// V - E + F = 1 + C over the base region's subdivision, with one vertex granted to each closed edge, and
    /// what lies beyond a rim as a face (one of a plane, two of a cylinder, none of a sphere); and as many
    /// boundary loops as components.
    void check_euler() {
        std::vector<std::size_t> parent(cell_.vertices.size());
        std::iota(parent.begin(), parent.end(), std::size_t{0});
        const auto root = [&](std::size_t v) {
            while (parent[v] != v) v = parent[v] = parent[parent[v]];
            return v;
        };
        std::vector<bool> has_edges(parent.size());
        long closed = 0;
        for (const CellEdge& e : cell_.edges) {
            if (e.vertices.empty()) {
                ++closed;
                continue;
            }
            parent[root(e.vertices[0])] = root(e.vertices[1]);
            has_edges[e.vertices[0]] = has_edges[e.vertices[1]] = true;
        }
        long components = closed, isolated = 0, holes = 0;
        for (std::size_t v = 0; v < parent.size(); ++v) {
            components += parent[v] == v;
            isolated += !has_edges[v];
        }
        const long v = static_cast<long>(parent.size()) + closed, e = static_cast<long>(cell_.edges.size());
        const long outside = geometry_.is_plane() ? 1 : geometry_.is_cylinder() ? 2 : 0;
        const long f = static_cast<long>(cell_.faces.size()) + outside;
        if (v - e + f != 1 + components)
            note("faces",
                 fmt::format(
                     "Euler's relation: V {} - E {} + F {} (with what is outside, and a vertex for each of "
                     "{} closed edges) is {}, C = {} components ask for {}",
                     v, e, f, closed, v - e + f, components, 1 + components));
        if (std::ranges::any_of(cell_.faces, [](const CellFace& face) { return face.patches.size() > 1; }))
            return;
        for (const Patch& patch : patches_) holes += static_cast<long>(patch.loops.size()) - 1;
        if (holes != components - isolated - 1)
            note("faces", fmt::format("{} holes, {} components of edges ask for {}", holes,
                                      components - isolated, components - isolated - 1));
    }

    // --- Geometry -----------------------------------------------------------------------------------

    void check_vertices() {
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i) {
            const CellVertex& v = cell_.vertices[i];
            if (std::abs(height(v.point) - v.radius) > v.error + rounding())
                note(vertex_path(i) + ".radius",
                     fmt::format("is {}, the base is {} away", v.radius, height(v.point)));
            std::vector<Site> attained;
            for (const Site& s : v.sites)
                if (geometry_.distance_from_rim(s, v.point) > v.error + rounding()) attained.push_back(s);
            if (const auto what = contradiction(v.point, v.error, attained)) note(vertex_path(i), *what);
        }
    }

    void check_edges() {
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) {
            check_edge_ends(i);
            check_edge_points(i);
            check_kind(i);
            check_length(i);
        }
    }

    void check_edge_ends(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        const auto& curve = edge_pieces_[i];
        const std::array ends{curve.front().evaluate(curve.front().begin)[0],
                              curve.back().evaluate(curve.back().end)[0]};
        if (e.vertices.empty()) {
            if (const double gap = (ends[0] - ends[1]).norm(); gap > 2 * e.error + rounding())
                note(edge_path(i) + ".curve", fmt::format("is closed, but its ends are {:.3g} apart", gap));
            return;
        }
        for (int k = 0; k < 2; ++k) {
            const CellVertex& v = cell_.vertices[e.vertices[k]];
            if (const double gap = (ends[k] - v.point).norm(); gap > e.error + v.error + rounding())
                note(edge_path(i) + ".vertices", fmt::format("the curve {} {:.3g} away from vertex {}",
                                                             k ? "ends" : "starts", gap, e.vertices[k]));
        }
    }

    /// Of an edge, that of its end vertices included: the curve runs through them.
    double full_error(std::size_t i) const {
        double at_ends = 0;
        for (const std::uint32_t v : cell_.edges[i].vertices)
            at_ends = std::max(at_ends, cell_.vertices[v].error);
        return cell_.edges[i].error + at_ends;
    }

    void check_edge_points(std::size_t i) {
        const double error = full_error(i);
        std::vector<Site> attained = label(i);
        if (rim_[i]) std::erase(attained, *rim_[i]);
        constexpr int kSteps = 8;  // per piece
        for (const auto& piece : edge_pieces_[i])
            for (int k = 0; k < kSteps; ++k) {
                const Vec3 p =
                    piece.evaluate(piece.begin + (k + 0.5) / kSteps * (piece.end - piece.begin))[0];
                if (const auto what = contradiction(p, error, attained))
                    return note(edge_path(i) + ".curve", *what);
            }
    }

    /// The kind must be one that the two sites can have, and fit the control points. Between a kind and its
    /// limit (a flat ellipse and a parabola) rounding leaves the control points undecided.
    void check_kind(std::size_t i) {
        const CurveKind kind = cell_.edges[i].kind;
        const std::string where = edge_path(i) + ".kind";
        if (const auto kinds = possible_kinds(i);
            !kinds.empty() && std::ranges::find(kinds, kind) == kinds.end())
            return note(where, fmt::format("is {}, the sites meet in another kind ({})", to_string(kind),
                                           to_string(kinds[0])));
        for (const auto& piece : edge_pieces_[i])
            if (!fits(kind, piece, full_error(i)))
                return note(where, fmt::format("is {}, the control points disagree", to_string(kind)));
    }

    bool is_linear(const Site& s) const {
        return !s.is_object() || std::holds_alternative<Plane>(scene_.objects[s.index]);
    }
    const Sphere* as_sphere(const Site& s) const {
        return s.is_object() ? std::get_if<Sphere>(&scene_.objects[s.index]) : nullptr;
    }

    /// Empty: no opinion. Where only exact arithmetic on the canonical scene could tell a kind from its
    /// limit, both.
    std::vector<CurveKind> possible_kinds(std::size_t i) const {
        if (geometry_.is_plane()) return kinds_over_plane(i);
        if (geometry_.is_sphere()) return kinds_over_sphere(cell_.edges[i].sites);
        const auto is_flat = [](const Site& s) { return !s.is_object(); };
        using enum CurveKind;
        if (std::ranges::all_of(cell_.edges[i].sites, is_flat)) return {Line};
        // Nearly a pair of lines, it may be a spline.
        if (std::ranges::all_of(cell_.edges[i].sites, [&](const Site& s) { return is_linear(s); }))
            return {Ellipse, Hyperbola, Parabola, Circle, Line, Spline};
        return {};
    }

    /// [HE, Lemmas 1-3] Planes and box sides have linear heights, spheres paraboloids about the base's
    /// normal.
    std::vector<CurveKind> kinds_over_plane(std::size_t i) const {
        using enum CurveKind;
        const auto& sites = cell_.edges[i].sites;
        if (rim_[i]) {
            const Site& owner = sites[uses_[i][0].reversed];
            return is_linear(owner)   ? std::vector{Line}
                   : as_sphere(owner) ? std::vector{Parabola}
                                      : std::vector<CurveKind>{};
        }
        if (is_linear(sites[0]) && is_linear(sites[1])) return {Line};
        const Sphere *a = as_sphere(sites[0]), *b = as_sphere(sites[1]);
        if ((!a && !is_linear(sites[0])) || (!b && !is_linear(sites[1]))) return {};
        const auto& base = std::get<Plane>(scene_.base);
        int axis = 0;
        base.normal.cwiseAbs().maxCoeff(&axis);
        const int x = (axis + 1) % 3, y = (axis + 2) % 3;
        const bool aligned = base.normal[x] == 0 && base.normal[y] == 0;
        if (!a || !b) {
            if (!aligned) return {Ellipse, Circle};
            const Site& linear = a ? sites[1] : sites[0];
            const bool horizontal = linear.is_object()
                                        ? std::get<Plane>(scene_.objects[linear.index]).normal[x] == 0 &&
                                              std::get<Plane>(scene_.objects[linear.index]).normal[y] == 0
                                        : static_cast<int>(linear.index / 2) == axis;
            return {horizontal ? Circle : Ellipse};
        }
        // Equal sums of height and radius: the paraboloids are congruent and meet over a line.
        const double za = a->center[axis] - base.point[axis], zb = b->center[axis] - base.point[axis];
        if (!aligned || Exact(a->center[axis]) - Exact(base.point[axis]) != Exact(za) ||
            Exact(b->center[axis]) - Exact(base.point[axis]) != Exact(zb))
            return {Parabola, Ellipse, Circle};
        const Exact up(base.normal[axis] > 0 ? 1.0 : -1.0);
        if (up * Exact(za) + Exact(a->radius) == up * Exact(zb) + Exact(b->radius)) return {Parabola};
        return {a->center[x] == b->center[x] && a->center[y] == b->center[y] ? Circle : Ellipse};
    }

    /// Bisectors with planes and spheres are planes, or surfaces of revolution with the base's centre as
    /// focus: two of them meet in a plane, in a circle if they share the axis.
    std::vector<CurveKind> kinds_over_sphere(const std::array<Site, 2>& sites) const {
        using enum CurveKind;
        const auto& base = std::get<Sphere>(scene_.base);
        const auto is_flat = [&](const Site& s) {
            return !s.is_object() || (as_sphere(s) && as_sphere(s)->radius == base.radius);
        };
        const auto axis = [&](const Site& s) -> Vec3 {
            if (!s.is_object()) return Vec3::Unit(static_cast<int>(s.index / 2));
            if (const Sphere* sphere = as_sphere(s)) return (sphere->center - base.center).normalized();
            return std::get<Plane>(scene_.objects[s.index]).normal.normalized();
        };
        if (is_flat(sites[0]) && is_flat(sites[1])) return {Line};
        for (const Site& s : sites)
            if (!is_linear(s) && !as_sphere(s)) return {};
        if (axis(sites[0]).cross(axis(sites[1])).norm() > kRounding) return {Ellipse, Parabola, Hyperbola};
        return {Circle, Ellipse};
    }

    /// Can a piece with these control points be of that kind, up to rounding? [Farin02, 12.4]: w1^2 / (w0 w2)
    /// is below, at or above 1 for an ellipse, a parabola, a hyperbola; for a circle the legs are equal and
    /// its root is the cosine of their angle with the chord.
    bool fits(CurveKind kind, const Bezier<3>& piece, double error) const {
        const Vec3 a = piece.control(0), b = piece.control(piece.points.size() - 1), m = piece.control(1);
        if (kind == CurveKind::Spline) return true;
        if (kind == CurveKind::Line) {
            const Vec3 chord = b - a;
            for (std::size_t k = 1; k + 1 < piece.points.size(); ++k)
                if ((piece.control(k) - a).cross(chord).norm() > (rounding() + error) * chord.norm())
                    return false;
            return true;
        }
        if (piece.degree() != 2) return false;
        const double k = piece.weight(1) * piece.weight(1) / (piece.weight(0) * piece.weight(2));
        const double left = (m - a).norm(), right = (b - m).norm(), cosine = 0.5 * (b - a).norm() / left;
        // A small one's points have few digits.
        const double tolerance = kPlaceRounding * (1 + geometry_.scale() / left);
        switch (kind) {
            case CurveKind::Parabola:
                return std::abs(k - 1) < tolerance;
            case CurveKind::Hyperbola:
                return k > 1 - tolerance;
            case CurveKind::Circle:
                return std::abs(left - right) <= rounding() && std::abs(k - cosine * cosine) <= tolerance;
            default:
                return k < 1 + tolerance;
        }
    }

    void check_length(std::size_t i) {
        double length = 0, error = 0;
        for (const auto& piece : edge_pieces_[i]) {
            const auto part = integrate([&](double t) { return Scalar(piece.evaluate(t)[1].norm()); },
                                        piece.begin, piece.end, Scalar(rounding()));
            length += part.value[0];
            error += part.error[0];
        }
        const double stated = cell_.edges[i].length;
        if (std::abs(stated - length) > error + kLengthError * length + 2 * full_error(i) + rounding())
            note(edge_path(i) + ".length", fmt::format("is {}, the curve is {} long", stated, length));
    }

    void check_faces() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const CellFace& face = cell_.faces[f];
            const auto names = geometry_.bisector_names(face.site);
            if (std::ranges::find(names, face.bisector) == names.end())
                note(face_path(f) + ".bisector", fmt::format("is \"{}\", of the base and {} it is \"{}\"",
                                                             face.bisector, title(face.site), names[0]));
        }
        for (const Patch& patch : patches_) {
            check_patch_points(patch);
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t t = 0; t < patch.loops[l].size(); ++t)
                    if (patch.loops[l][t].curve->edge)
                        check_trim(patch, patch.loops[l][t],
                                   fmt::format("{}[{}]", loop_path(patch.face, patch.index, l), t));
        }
    }

    void check_patch_points(const Patch& patch) {
        const std::string where = patch_path(patch.face, patch.index);
        constexpr int kTries = 64, kEnough = 12;
        int found = 0;
        for (int k = 1; k <= kTries && found < kEnough; ++k) {
            // Points of the additive recurrence with the golden ratio's plane analogue: even coverage.
            const Vec2 s(std::fmod(0.7548776662466927 * k, 1.0), std::fmod(0.5698402909980532 * k, 1.0));
            const Vec2 uv = patch.lo + s.cwiseProduct(patch.hi - patch.lo);
            if (!inside(patch, uv, rounding()).value_or(false)) continue;
            ++found;
            const SurfacePoint x = lift(patch, uv);
            if (geometry_.up(x.p).dot(x.pu.cross(x.pv)) <= 0)
                return note(where, "du x dv points towards the base");
            const Site& site = cell_.faces[patch.face].site;
            std::vector<Site> sites = cell_.faces[patch.face].extra_sites;
            sites.insert(sites.begin(), site);
            if (const auto what = contradiction(x.p, surface_rounding(patch, x, uv), sites))
                return note(where, *what);
        }
    }

    void check_trim(const Patch& patch, const Trim& trim, const std::string& where) {
        const std::size_t e = *trim.curve->edge;
        const auto& curve = edge_pieces_[e];
        constexpr int kSteps = 12;
        for (int k = 0; k <= kSteps; ++k) {
            const double s = static_cast<double>(k) / kSteps;
            const double t = trim.begin() + s * (trim.end() - trim.begin());
            const Vec2 uv = evaluate(trim.pieces, t);
            const SurfacePoint x = lift(patch, uv);
            const Vec3 p = evaluate(curve, edge_parameter(*trim.curve, cell_.edges[e].curve, t));
            if (const double gap = (x.p - p).norm(); gap > 2 * full_error(e) + surface_rounding(patch, x, uv))
                return note(
                    where,
                    fmt::format("lifts to a curve {:.3g} away from edge {} at the same parameter", gap, e));
        }
    }

    // --- Completeness -------------------------------------------------------------------------------

    void check_samples() {
        std::mt19937_64 rng(options_.seed);
        for (std::uint32_t k = 0; k < options_.samples; ++k) {
            const auto ray = geometry_.random_ray(rng, kNearEdge * scene_.box.diagonal());
            if (!ray) return note("scene.box", "holds none of the base");
            if (!check_sample(*ray)) return;
        }
    }

    /// False after a finding that would only repeat itself.
    bool check_sample(const Ray& ray) {
        std::vector<const Patch*> found;
        SurfacePoint surface{};
        Vec2 uv;
        const Vec2 q = geometry_.chart(ray.foot);
        for (const Patch& patch : patches_) {
            if (geometry_.is_plane() &&
                ((q.array() < patch.foot_lo.array()).any() || (q.array() > patch.foot_hi.array()).any()))
                continue;
            const auto places = parameters(patch, ray, geometry_);
            if (!places) return true;
            for (const Vec2& place : *places) {
                const auto in = inside(patch, place, rounding());
                if (!in) return true;
                if (!*in) continue;
                found.push_back(&patch);
                uv = place;
                surface = lift(patch, uv);
            }
        }
        const double t = geometry_.brute_height(ray);
        const Vec3 top = ray.at(t), &f = ray.foot;
        const std::string point = fmt::format("base point ({}, {}, {})", f.x(), f.y(), f.z());
        if (found.empty()) {
            note("faces",
                 fmt::format("{}, owned by {}, lies under no face", point, title(geometry_.owner(ray, t))));
            return false;
        }
        if (found.size() > 1) {
            note(face_path(found[1]->face), fmt::format("{} lies under face {} too", point, found[0]->face));
            return false;
        }
        const Site& site = cell_.faces[found[0]->face].site;
        const double slack = surface_rounding(*found[0], surface, uv);
        if (std::abs(geometry_.excess(site, top, t)) > slack + geometry_.site_rounding(site)) {
            note(face_path(found[0]->face), fmt::format("{} belongs to {}, not to {}", point,
                                                        title(geometry_.owner(ray, t)), title(site)));
            return true;
        }
        if (const auto what = contradiction(surface.p, slack, std::span(&site, 1)))
            note(patch_path(found[0]->face, found[0]->index), *what);
        return true;
    }

    // --- Measures -----------------------------------------------------------------------------------

    /// The integral of SceneGeometry::densities() over a trimmed patch. Green's theorem: the integral over
    /// the region is that of I(u, v) dv along the loops, I the integral of the density from a fixed u; or
    /// that of -I du, from a fixed v.
    Integral<Triple> integrate_patch(const Patch& patch) const {
        const auto density = [&](const Vec2& uv) { return geometry_.densities(lift(patch, uv)); };
        const auto [across, start] = start_line(patch);
        const int along = 1 - across;
        const double sign = across == 0 ? 1 : -1;
        // Parameters are rounded at their size, which for a thin patch far out is more than rounding of the
        // integral; control points at that of their coordinates, which turns the partial derivatives.
        const Vec2 extent = patch.hi - patch.lo, size = patch.lo.cwiseAbs().cwiseMax(patch.hi.cwiseAbs());
        const SurfacePoint middle = lift(patch, 0.5 * (patch.lo + patch.hi));
        const double turn = kRounding * patch.control_size *
                            (1 / (middle.pu.norm() * extent.x()) + 1 / (middle.pv.norm() * extent.y()));
        Triple most = Triple::Zero();
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop)
                for (const auto& piece : trim.pieces)
                    most = most.max(density(piece.evaluate(std::midpoint(piece.begin, piece.end))[0]).abs());
        const Triple inner_floor = (kRounding * size[across] + turn * extent[across]) * most;
        const Triple floor =
            (kRounding * (size.x() * extent.y() + size.y() * extent.x()) + turn * extent.prod()) * most;
        Integral<Triple> total{Triple::Zero(), Triple::Zero()};
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop)
                for (const auto& piece : trim.pieces) {
                    Triple inner_error = Triple::Zero();
                    const auto part = integrate(
                        [&](double t) -> Triple {
                            const auto [q, d] = piece.evaluate(t);
                            if (d[along] == 0) return Triple::Zero();
                            const auto inner = integrate(
                                [&](double x) {
                                    Vec2 uv = q;
                                    uv[across] = x;
                                    return density(uv);
                                },
                                start, q[across], inner_floor);
                            inner_error = inner_error.max(inner.error * std::abs(d[along]));
                            return sign * inner.value * d[along];
                        },
                        piece.begin, piece.end, floor);
                    total.value += part.value;
                    total.error += part.error + floor + inner_error * (piece.end - piece.begin);
                }
        return total;
    }

    /// Where integrals across u (0) or v (1) start: on the line of the rectangle that has the least volume
    /// above it. A corner of it may be all but at infinity.
    struct StartLine {
        int across;
        double start;
    };
    StartLine start_line(const Patch& patch) const {
        StartLine best{};
        double least = HUGE_VAL;
        for (const int across : {0, 1})
            for (const double s : {0.5, 0.0, 1.0}) {
                const double start = std::lerp(patch.lo[across], patch.hi[across], s);
                double volume = 0;
                for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
                    Vec2 uv = patch.lo + t * (patch.hi - patch.lo);
                    uv[across] = start;
                    volume = std::max(volume, std::abs(geometry_.densities(lift(patch, uv))[0]));
                }
                if (volume < least) {
                    least = volume;
                    best = {across, start};
                }
            }
        return best;
    }

    void compare(const std::string& where, double stated, double found, double tolerance) {
        if (!(std::abs(stated - found) <= tolerance))
            note(where,
                 fmt::format("is {}, integration gives {} (tolerance {:.3g})", stated, found, tolerance));
    }

    /// The cell's side along a piece of a rim edge.
    double side_area(const Bezier<3>& piece) const {
        const auto density = [&](double t) {
            const auto [p, d] = piece.evaluate(t);
            return Scalar(geometry_.side_area_density(p, d));
        };
        const Scalar floor(rounding() * scene_.box.diagonal());
        return integrate(density, piece.begin, piece.end, floor).value[0];
    }

    void check_integrals() {
        const Measures& m = cell_.measures;
        check_amount("measures.volume_error", m.volume_error);
        check_amount("measures.area_error", m.area_error);
        double volume = 0, area = 0, box_area = -geometry_.body_end_area(), shadow = 0;
        double edge_errors = 0;  // area between the stated and the true edges
        for (std::size_t e = 0; e < cell_.edges.size(); ++e)
            edge_errors += cell_.edges[e].length * full_error(e);
        Triple error = Triple::Zero();
        std::vector<double> face_areas(cell_.faces.size()), face_errors(cell_.faces.size());
        for (const Patch& patch : patches_) {
            const auto part = integrate_patch(patch);
            volume += part.value[0];
            shadow += part.value[2];
            face_areas[patch.face] += part.value[1];
            face_errors[patch.face] += part.error[1];
            (cell_.faces[patch.face].site.is_object() ? area : box_area) += part.value[1];
            error += part.error;
        }
        const double length_rounding = rounding(), area_rounding = length_rounding * scene_.box.diagonal();
        const double slack = m.area_error + area_rounding + 2 * edge_errors;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            compare(face_path(f) + ".area", cell_.faces[f].area, face_areas[f], slack + face_errors[f]);
        compare("measures.area", m.area, area, slack + error[1]);
        // Over the rim of a plane the cell has walls; at those of a cylinder it ends in rings around the
        // body.
        bool touches =
            std::ranges::any_of(cell_.faces, [](const CellFace& f) { return !f.site.is_object(); });
        for (std::size_t e = 0; e < edge_pieces_.size(); ++e) {
            if (!rim_[e]) continue;
            touches = true;
            for (const auto& piece : edge_pieces_[e]) box_area += side_area(piece);
        }
        compare("measures.box_area", m.box_area, box_area, slack + error[1] + kLengthError * box_area);
        if (m.touches_box != touches)
            note("measures.touches_box", fmt::format("is {}, must be {}", m.touches_box, touches));
        compare("measures.volume", m.volume, volume,
                m.volume_error + error[0] + (area_rounding + 2 * edge_errors) * scene_.box.diagonal());

        const double base_area = geometry_.base_area();
        compare("measures.base_area", m.base_area, base_area, area_rounding);
        double lowest = HUGE_VAL;
        for (const Patch& patch : patches_)
            for (const auto& point : patch.grid) lowest = std::min(lowest, height(point.surface.p));
        const double whole = geometry_.shadow();
        if (std::abs(shadow - whole) > geometry_.shadow(area_rounding + 2 * edge_errors, lowest) + error[2])
            note("faces", fmt::format("stand over an area of {}, the base has {}{}", shadow, whole,
                                      geometry_.is_plane() ? "" : " where its radius is 1"));
        compare("measures.body_volume", m.body_volume, geometry_.body_volume(),
                area_rounding * scene_.box.diagonal());
    }

    /// Least and greatest height on the vertices, along the edges, and at a stationary point within a face.
    /// No bisector's height has a greatest value inside.
    void check_clearances() {
        double least = HUGE_VAL, greatest = -HUGE_VAL, error = rounding();
        const auto meet = [&](double h) {
            least = std::min(least, h);
            greatest = std::max(greatest, h);
        };
        for (const CellVertex& v : cell_.vertices) {
            meet(height(v.point));
            error = std::max(error, rounding() + v.error);
        }
        for (std::size_t e = 0; e < edge_pieces_.size(); ++e) {
            error = std::max(error, rounding() + full_error(e));
            for (const auto& piece : edge_pieces_[e]) {
                const auto height_at = [&](double t) { return height(piece.evaluate(t)[0]); };
                for (const double sign : {-1.0, 1.0})
                    meet(sign *
                         lowest(piece.begin, piece.end, [&](double t) { return sign * height_at(t); }));
            }
        }
        for (const Patch& patch : patches_) {
            if (const auto h = stationary_height(patch)) meet(*h);
            for (const auto& loop : patch.loops)
                for (const Trim& trim : loop)
                    if (trim.curve->seam)
                        meet(lowest(trim.begin(), trim.end(), [&](double t) {
                            return height(lift(patch, evaluate(trim.pieces, t)).p);
                        }));
        }
        const Measures& m = cell_.measures;
        if (!(std::abs(m.min_clearance - least) <= error))
            note("measures.min_clearance",
                 fmt::format("is {}, the least found is {}", m.min_clearance, least));
        if (!(std::abs(m.max_clearance - greatest) <= error))
            note("measures.max_clearance",
                 fmt::format("is {}, the greatest found is {}", m.max_clearance, greatest));
    }

    /// Minimum of a function over an interval: the best of a few samples, refined by golden section.
    template <class F>
    static double lowest(double begin, double end, F function) {
        constexpr int kSteps = 16;
        const auto value = [&](double s) { return function(std::lerp(begin, end, s)); };
        int best = 0;
        for (int k = 1; k <= kSteps; ++k)
            if (value(k / double(kSteps)) < value(best / double(kSteps))) best = k;
        double lo = std::max(0, best - 1) / double(kSteps), hi = std::min(kSteps, best + 1) / double(kSteps);
        double lowest = value(best / double(kSteps));
        constexpr double kGolden = 1 / std::numbers::phi;
        // Mostly half the digits of the place give all of the value. But a distance from what is passed closely
        // has a corner.
        while (hi - lo > 1e-14) {
            const double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo);
            const double fa = value(a), fb = value(b);
            lowest = std::min({lowest, fa, fb});
            (fa < fb ? hi : lo) = fa < fb ? b : a;
        }
        return lowest;
    }

    /// The height where it is stationary, if inside the loops. A bisector has one such place, a minimum (or
    /// several of one height, which reach the boundary): descent from the lowest point of the grid that is
    /// inside, by Newton's method with the Hessian's eigenvalues made positive, within the rectangle.
    std::optional<double> stationary_height(const Patch& patch) const {
        const Vec2 extent = patch.hi - patch.lo;
        const auto height_at = [&](const Vec2& uv) { return height(lift(patch, uv).p); };
        const auto gradient = [&](const Vec2& uv) {  // per extent
            const SurfacePoint s = lift(patch, uv);
            const Vec3 up = geometry_.up(s.p);
            return Vec2(up.dot(s.pu) * extent.x(), up.dot(s.pv) * extent.y());
        };
        Vec2 uv = 0.5 * (patch.lo + patch.hi);
        double lowest = HUGE_VAL;
        for (const auto& point : patch.grid)
            if (const double h = height(point.surface.p);
                h < lowest && inside(patch, point.uv, rounding()).value_or(false)) {
                lowest = h;
                uv = point.uv;
            }
        lowest = height_at(uv);
        constexpr int kSteps = 100, kHalvings = 40;
        for (int k = 0; k < kSteps; ++k) {
            constexpr double kStep = 1e-4;  // of the extent: errors of its square against rounding
            Eigen::Matrix2d hessian;
            for (int i = 0; i < 2; ++i) {
                const Vec2 h = Vec2::Unit(i) * (kStep * extent[i]);
                hessian.col(i) = (gradient(uv + h) - gradient(uv - h)) / (2 * kStep);
            }
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 *
                                                                        (hessian + hessian.transpose()));
            const Eigen::Array2d sizes = solver.eigenvalues().array().abs();
            const Eigen::Array2d curvatures = sizes.max(kRounding * sizes.maxCoeff());
            const Eigen::Matrix2d axes = solver.eigenvectors();
            const Vec2 step = axes * ((axes.transpose() * gradient(uv)).array() / curvatures).matrix();
            bool has_moved = false;
            double part = 1;
            for (int halving = 0; halving < kHalvings && !has_moved; ++halving, part *= 0.5) {
                const Vec2 next =
                    (uv - part * extent.cwiseProduct(step)).cwiseMax(patch.lo).cwiseMin(patch.hi);
                if (const double h = height_at(next); h < lowest) {
                    lowest = h;
                    uv = next;
                    has_moved = true;
                }
            }
            if (!has_moved) break;
        }
        // On the boundary itself edges and seams tell.
        if (!inside(patch, uv, rounding()).value_or(false)) return std::nullopt;
        return lowest;
    }

    void check_neighbors() {
        std::map<std::uint32_t, double> owned;
        for (const CellFace& f : cell_.faces)
            if (f.site.is_object()) owned[f.site.index] += f.area;
        std::map<std::uint32_t, int> listed;
        for (std::size_t i = 0; i < cell_.neighbors.size(); ++i) {
            const std::uint32_t object = cell_.neighbors[i];
            const std::string where = fmt::format("neighbors[{}]", i);
            if (!owned.contains(object))
                note(where, fmt::format("object {} owns no face", object));
            else if (listed[object]++)
                note(where, fmt::format("object {} is listed twice", object));
            else if (i > 0 && owned.contains(cell_.neighbors[i - 1]) &&
                     owned[cell_.neighbors[i - 1]] <
                         owned[object] - 2 * cell_.measures.area_error - kRounding * owned[object])
                note(where, fmt::format("object {} owns more area than the one before it", object));
        }
        for (const auto& [object, area] : owned)
            if (!listed.contains(object))
                note("neighbors", fmt::format("lack object {}, which owns a face", object));
    }

    void check_report() {
        check_amount("report.seconds.bisectors", cell_.report.seconds_bisectors);
        check_amount("report.seconds.envelope", cell_.report.seconds_envelope);
        check_amount("report.seconds.patches", cell_.report.seconds_patches);
    }

    static constexpr int kGrid = 8;

    const Cell& cell_;
    const Scene& scene_;
    CheckOptions options_;
    SceneGeometry geometry_;
    std::vector<std::vector<Bezier<3>>> edge_pieces_;
    std::vector<std::vector<Use>> uses_;    // by edge
    std::vector<std::optional<Site>> rim_;  // by edge: what it runs over the rim towards
    std::vector<Patch> patches_;
    std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_cell(const Cell& cell, const CheckOptions& options) {
    return Judge(cell, options).run();
}

}  // namespace vcell
