/// How far lifted trimming curves are said to be from their edges, against points of both.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/trim_curves.hpp"
#include "../../io/trims.hpp"
#include "../test_support.hpp"
#include "random_scenes.hpp"

namespace vcell::check {

TEST_CASE("trimming curves: the bound of their gaps is none too small, and not much too large") {
    std::mt19937_64 rng(test_seed());
    std::normal_distribution<double> normal;
    int known = 0, tight = 0, bulging = 0;
    for (int k = 0; k < 16; ++k) {
        Cell cell = voronoi_cell(k % 2 ? scene_over_plane(rng, 10, 2) : scene_about_ball(rng, 10, 2));
        for (CellEdge& e : cell.edges) e.error = 1e-3;
        // Off by nothing, by little or by more, but not so that their ends leave the patch.
        const double off = std::array{0.0, 1e-9, 1e-5}[static_cast<std::size_t>(k % 3)];
        for (CellFace& face : cell.faces)
            for (TrimmedPatch& patch : face.patches)
                for (auto& loop : patch.loops)
                    for (TrimCurve& trim : loop)
                        for (std::size_t i = 1; i + 1 < trim.curve.points.size(); ++i)
                            trim.curve.points[i].head<2>() += off * Vec2(normal(rng), normal(rng));
        const SceneGeometry geometry(cell.scene);
        Certificate certificate;
        const Subject subject(cell, geometry, certificate);
        for (const Patch& patch : subject.patches) {
            const Net net = net_over(*patch.surface, patch.lo, patch.hi, lift(patch, patch.lo).p);
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t c = 0; c < patch.loops[l].size(); ++c) {
                    const Trim& trim = patch.loops[l][c];
                    if (!trim.curve->edge) continue;
                    const double gap = certify_trim(patch, net, {l, c}, subject, {}, certificate);
                    double most = 0;
                    constexpr int samples = 64;
                    for (int i = 0; i <= samples; ++i) {
                        const double t = trim.begin() + (trim.end() - trim.begin()) * i / samples;
                        const std::size_t e = *trim.curve->edge;
                        const Vec3 p = evaluate(subject.edge_pieces[e],
                                                edge_parameter(*trim.curve, cell.edges[e].curve, t));
                        most = std::max(most, (lift(patch, evaluate(trim.pieces, t)).p - p).norm());
                    }
                    if (!(gap < HUGE_VAL)) continue;
                    ++known;
                    CHECK(gap >= most - 1e-14);
                    tight += gap <= 8 * most + 1e-11;
                    // Control points beside the patch, where curves are not.
                    const auto& domain = *patch.surface;
                    bulging += std::ranges::any_of(trim.pieces, [&](const auto& piece) {
                        for (std::size_t i = 0; i < piece.points.size(); ++i) {
                            const Vec2 uv = piece.control(i);
                            if (uv.x() < domain.domain_u[0] || uv.x() > domain.domain_u[1] ||
                                uv.y() < domain.domain_v[0] || uv.y() > domain.domain_v[1])
                                return true;
                        }
                        return false;
                    });
                }
        }
    }
    CHECK(known > 400);
    CHECK(10 * tight > 9 * known);
    CHECK(bulging > 10);
}

}  // namespace vcell::check
