#include "subject.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "../pictures/trims.hpp"
#include "paths.hpp"

namespace vcell::check {

namespace {

std::vector<std::uint32_t> all_numbers(std::size_t count) {
    std::vector<std::uint32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0u);
    return numbers;
}

}  // namespace

Subject::Subject(const Cell& c, const SceneGeometry& g, Certificate& certificate, const TubePart* p)
    : cell(c),
      geometry(g),
      part(p),
      vertices(p ? p->vertices : all_numbers(c.vertices.size())),
      edges(p ? p->edges : all_numbers(c.edges.size())),
      faces(p ? p->faces : all_numbers(c.faces.size())),
      space(c.scene, p),
      tree(c.scene) {
    edge_pieces.resize(cell.edges.size());
    uses.resize(cell.edges.size());
    rim.resize(cell.edges.size());
    for (const std::uint32_t e : edges) edge_pieces[e] = pieces(cell.edges[e].curve);
    for (const std::uint32_t f : faces)
        for (std::size_t i = 0; i < cell.faces[f].patches.size(); ++i) prepare_patch(f, i, certificate);
    for (const std::uint32_t e : edges) join_uses(e, certificate);
    for (const std::uint32_t e : edges) {
        if (uses[e].size() != 1) continue;
        const Site& outer = cell.edges[e].sites[!uses[e][0].reversed];
        // All of a complete cell's boundary has faces but the base, sides along its normals, and ends of
        // parts. A vessel's wall is the rim where it meets a base plane.
        if (over_rim(e, outer) && ((!cell.is_complete && !outer.is_object()) || geometry.is_upright(outer) ||
                                   outer.kind == Site::Kind::End || is_on_base(e)))
            rim[e] = outer;
    }
}

std::string Subject::path(const char* what) const {
    return part ? fmt::format("parts[{}].{}", part->number, what) : what;
}

void Subject::prepare_patch(std::size_t f, std::size_t p, Certificate& certificate) {
    const TrimmedPatch& trimmed = cell.faces[f].patches[p];
    const Vec2 infinite = Vec2::Constant(HUGE_VAL);
    Patch patch{f, p, &trimmed.surface, geometry.scale(), {}, infinite, -infinite, infinite, -infinite};
    for (const auto& c : trimmed.surface.points)
        patch.control_size = std::max(patch.control_size, c.head<3>().cwiseAbs().maxCoeff());
    patch.loops.reserve(trimmed.loops.size());
    for (const auto& loop : trimmed.loops) {
        auto& trims = patch.loops.emplace_back();
        trims.reserve(loop.size());
        for (const TrimCurve& trim : loop) {
            trims.push_back(
                {&trim, trim.edge ? cell.edges[*trim.edge].error : tolerance(), pieces(trim.curve)});
            patch.lo = patch.lo.cwiseMin(trims.back().lo);
            patch.hi = patch.hi.cwiseMax(trims.back().hi);
            if (!trim.edge) {  // a seam may bulge anywhere: no bounds
                patch.foot_lo = -infinite;
                patch.foot_hi = infinite;
                continue;
            }
            if (uses[*trim.edge].empty()) uses[*trim.edge].reserve(2);
            uses[*trim.edge].push_back(use(f, trim));
            if (!geometry.is_plane()) continue;
            for (const auto& piece : edge_pieces[*trim.edge])
                for (std::size_t i = 0; i < piece.points.size(); ++i) {
                    const Vec2 q = geometry.chart(piece.control(i));
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
        certificate.refute(patch_path(f, p) + ".loops", "lie outside the patch's domain");
        patch.lo = domain_lo;
        patch.hi = domain_hi;
    }
    patches.push_back(std::move(patch));
}

Subject::Use Subject::use(std::size_t face, const TrimCurve& trim) const {
    const RationalCurve3& curve = cell.edges[*trim.edge].curve;
    const double a = edge_parameter(trim, curve, trim.curve.domain_begin());
    const double b = edge_parameter(trim, curve, trim.curve.domain_end());
    return {face, trim.reversed, std::min(a, b), std::max(a, b)};
}

/// Uses that follow each other on one side and in one face become one.
void Subject::join_uses(std::size_t e, Certificate& certificate) {
    std::vector<Use>& sides = uses[e];
    const RationalCurve3& curve = cell.edges[e].curve;
    const double near = kPlaceRounding * (curve.domain_end() - curve.domain_begin());
    std::ranges::sort(sides, {}, [](const Use& use) { return std::pair(use.reversed, use.begin); });
    std::size_t joined = 0;
    for (const Use& use : sides) {
        Use* const before = joined > 0 ? &sides[joined - 1] : nullptr;
        const bool goes_on = before && before->reversed == use.reversed && before->face == use.face &&
                             std::abs(before->end - use.begin) <= near;
        if (goes_on)
            before->end = use.end;
        else
            sides[joined++] = use;
    }
    sides.resize(joined);
    for (const Use& use : sides)
        if (use.begin > curve.domain_begin() + near || use.end < curve.domain_end() - near)
            certificate.refute(edge_path(e), fmt::format("face {} sides it from {} to {} only", use.face,
                                                         use.begin, use.end));
}

bool Subject::over_rim(std::size_t e, const Site& site) const {
    return std::ranges::all_of(edge_pieces[e], [&](const auto& piece) {
        for (const double s : {0.0, 0.25, 0.5, 0.75, 1.0}) {
            const Vec3 p = piece.evaluate(piece.begin + s * (piece.end - piece.begin))[0];
            if (geometry.distance_from_rim(site, p) > full_error(e) + geometry.rounding()) return false;
        }
        return true;
    });
}

bool Subject::is_on_base(std::size_t e) const {
    return std::ranges::all_of(edge_pieces[e], [&](const auto& piece) {
        for (std::size_t i = 0; i < piece.points.size(); ++i)
            if (std::abs(geometry.height(piece.control(i))) > full_error(e) + geometry.rounding())
                return false;
        return true;
    });
}

double Subject::full_error(std::size_t i) const {
    double at_ends = 0;
    for (const std::uint32_t v : cell.edges[i].vertices) at_ends = std::max(at_ends, cell.vertices[v].error);
    return cell.edges[i].error + at_ends;
}

std::vector<Site> Subject::label(std::size_t e) const {
    std::vector<Site> sites = cell.edges[e].extra_sites;
    sites.insert(sites.end(), cell.edges[e].sites.begin(), cell.edges[e].sites.end());
    std::ranges::sort(sites);
    sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
    return sites;
}

double Subject::tolerance() const {
    return std::max(cell.scene.tolerance.value_or(1e-7 * cell.scene.box.diagonal()), geometry.rounding());
}

}  // namespace vcell::check
