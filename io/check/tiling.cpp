#include "tiling.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "loops.hpp"
#include "tips.hpp"

namespace vcell::check {
namespace {

/// Is all of a trim the tip?
bool runs_in(const Tip& tip, const Patch& patch, const Trim& trim, double tolerance) {
    const double error = tolerance + radius(tip.p);
    return std::ranges::all_of(std::array{0.0, 0.25, 0.5, 0.75, 1.0}, [&](double s) {
        const Vec2 uv = evaluate(trim.pieces, trim.begin() + s * (trim.end() - trim.begin()));
        return (lift(patch, uv).p - middle(tip.p)).norm() <= error;
    });
}

class Tiling : public Room {
public:
    using Room::Room;

    void run() {
        const std::size_t before = certificate_.count(Verdict::refuted);
        check_uses();
        check_labels();
        certify_loops(subject_, options_, certificate_);
        check_seams();
        check_tips();
        check_euler();
        if (certificate_.count(Verdict::refuted) == before) certificate_.prove(subject_.path("tiling"));
    }

    void check_samples() {
        // Where all rays come into the box through sides none starts on the base.
        if (subject_.part && subject_.part->has_floor()) return;
        std::mt19937_64 rng(options_.seed);
        constexpr std::size_t most_tests = 4'000'000;
        const std::size_t samples = std::min<std::size_t>(
            options_.samples, most_tests / (scene_.objects.size() + patches_.size() + 1));
        for (std::size_t k = 0; k < samples; ++k) {
            const auto ray = geometry_.random_ray(rng, kNearEdge * scene_.box.diagonal());
            // A region narrower than the margins has nothing to sample.
            if (!ray && (subject_.part || geometry_.shadow().upper() > 0)) return;
            if (!ray) return note("scene.box", "holds none of the base");
            if (!check_sample(*ray)) return;
        }
    }

private:
    /// An edge may be written as one point, as its ends are nearer to each other than doubles: other sites
    /// tie in each of them, which a proved vertex lists, or the same three do twice, which nothing here tells
    /// from once.
    void check_length(std::size_t e) {
        const auto& points = cell_.edges[e].curve.points;
        const auto& ends = cell_.edges[e].vertices;
        const auto is_first = [&](const auto& p) {
            return p.template head<3>() == points.front().template head<3>();
        };
        if (!std::ranges::all_of(points, is_first)) return;
        const std::string where = edge_path(e) + ".curve";
        if (ends.empty() || ends[0] == ends[1]) return note(where, "is a single point");
        const CellVertex &a = cell_.vertices[ends[0]], &b = cell_.vertices[ends[1]];
        if (std::ranges::equal(a.sites, b.sites))
            certificate_.leave_open(where, "is a single point, as the same sites tie at both ends",
                                    std::max(a.error, b.error));
    }

    void check_uses() {
        for (const std::uint32_t e : subject_.edges) {
            const auto& uses = uses_[e];
            if (uses.empty()) note(edge_path(e), "no face uses it");
            const auto& [left, right] = cell_.edges[e].sites;
            // A side of the box that leans over its own rim is met there by the region's rim: a site of both
            // sides.
            if (left == right && !rim_[e])
                note(edge_path(e) + ".sites", fmt::format("are {} on both sides", title(left)));
            check_length(e);
            if (uses.size() > 2) note(edge_path(e), fmt::format("used {} times", uses.size()));
            if (uses.size() == 2 && uses[0].reversed == uses[1].reversed)
                note(edge_path(e), fmt::format("used twice in the same sense, by faces {} and {}",
                                               uses[0].face, uses[1].face));
            if (uses.size() != 1) continue;
            if (!rim_[e])
                note(edge_path(e),
                     fmt::format("used by face {} only, and not over the rim of the base region",
                                 uses[0].face));
        }
        check_sides();
    }

    /// Faces carry the sites that their edges name. Of an edge and a face that disagree, the one is to
    /// blame that disagrees with its other neighbours as well.
    void check_sides() {
        const auto differs = [&](std::size_t e, const Subject::Use& use) {
            return cell_.faces[use.face].site != cell_.edges[e].sites[use.reversed];
        };
        std::vector<int> wrong(cell_.faces.size()), all(cell_.faces.size());
        for (const std::uint32_t e : subject_.edges)
            for (const Subject::Use& use : uses_[e]) {
                ++all[use.face];
                wrong[use.face] += differs(e, use);
            }
        for (const std::uint32_t e : subject_.edges)
            for (const Subject::Use& use : uses_[e]) {
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

    void check_labels() {
        std::vector<std::vector<std::size_t>> around(cell_.vertices.size());
        for (const std::uint32_t e : subject_.edges) {
            const CellEdge& edge = cell_.edges[e];
            for (const std::uint32_t v : edge.vertices) {
                if (around[v].empty()) around[v].reserve(3);
                around[v].push_back(e);
                for (const std::span<const Site> sites :
                     {std::span<const Site>(edge.sites), std::span<const Site>(edge.extra_sites)})
                    for (const Site& s : sites)
                        if (!contains(cell_.vertices[v].sites, s))
                            note(vertex_path(v) + ".sites", fmt::format("lack {} of edge {}", title(s), e));
            }
        }
        for (const std::uint32_t v : subject_.vertices) {
            if (cell_.vertices[v].sites.size() < 2) note(vertex_path(v) + ".sites", "are fewer than two");
            if (around[v].empty()) note(vertex_path(v), "no edge ends there");
            if (around[v].size() != 2 || around[v][0] == around[v][1]) continue;
            if (label(around[v][0]) == label(around[v][1]) &&
                label(around[v][0]).size() == cell_.vertices[v].sites.size())
                note(vertex_path(v),
                     fmt::format("splits edges {} and {}, which are one", around[v][0], around[v][1]));
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

    /// Along nothing a patch is one point, and its bisector has a tip there.
    void check_tips() {
        for (const Patch& patch : patches_)
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t t = 0; t < patch.loops[l].size(); ++t) {
                    const Trim& trim = patch.loops[l][t];
                    if (!trim.curve->is_tip()) continue;
                    const Site& site = cell_.faces[patch.face].site;
                    const auto tips = site.is_object() ? tips_of(subject_.space, scene_.objects[site.index])
                                                       : std::vector<Tip>();
                    const auto is_there = [&](const Tip& tip) {
                        return runs_in(tip, patch, trim, scene_tolerance());
                    };
                    if (std::ranges::none_of(tips, is_there))
                        note(fmt::format("{}[{}]", loop_path(patch.face, patch.index, l), t),
                             "runs along no edge, no seam and no tip of the bisector");
                }
    }

    /// V - E + F = 1 + C over the base region's subdivision, with one vertex granted to each closed edge, and
    /// what lies beyond a rim as a face (one of a plane, two of a cylinder, none of a sphere); and as many
    /// boundary loops as components.
    void check_euler() {
        // A complete cell has as many handles as objects reach through its floor.
        if (cell_.is_complete) return;
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

    // --- Completeness -------------------------------------------------------------------------------

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
};

}  // namespace

void certify_tiling(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Tiling(subject, options, certificate).run();
}

void sample(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Tiling(subject, options, certificate).check_samples();
}

}  // namespace vcell::check
