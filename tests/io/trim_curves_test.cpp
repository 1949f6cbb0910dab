/// How far lifted trimming curves are said to be from their edges, against points of both.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/nets.hpp"
#include "../../io/check/trim_curves.hpp"
#include "../../io/pictures/trims.hpp"
#include "../test_support.hpp"
#include "random_scenes.hpp"

namespace vcell::check {

TEST_CASE("nets: boxes and derivatives hold points and slopes, of halves too") {
    std::mt19937_64 rng(test_seed());
    const auto number = [&](double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng); };
    for (int round = 0; round < 200; ++round) {
        const Vec3 origin(number(-9, 9), number(-9, 9), number(-9, 9));
        Net net(2, round % 2 == 0 ? 2 : 0, origin);
        for (int i = 0; i <= net.degree_s(); ++i)
            for (int j = 0; j <= net.degree_t(); ++j)
                net.at(i, j) = {number(-1, 1), number(-1, 1), number(-1, 1), number(0.5, 2)};
        const std::array halves = net.halves(0);
        const long double s = number(0, 1), t = number(0, 1);
        // Of the whole, and in the half that s lies in.
        const Net& half = halves[s < 0.5L ? 0 : 1];
        std::array<long double, 4> n{}, dn{};
        for (int i = 0; i <= net.degree_s(); ++i)
            for (int j = 0; j <= net.degree_t(); ++j) {
                const auto basis = [](int d, int k, long double x) -> std::array<long double, 2> {
                    if (d == 0) return {1, 0};
                    if (k == 0) return {(1 - x) * (1 - x), -2 * (1 - x)};
                    if (k == 1) return {2 * x * (1 - x), 2 - 4 * x};
                    return {x * x, 2 * x};
                };
                const auto u = basis(2, i, s), v = basis(net.degree_t(), j, t);
                for (std::size_t k = 0; k < 4; ++k) {
                    n[k] += u[0] * v[0] * net.at(i, j)[k].mid();
                    dn[k] += u[1] * v[0] * net.at(i, j)[k].mid();
                }
            }
        for (std::size_t k = 0; k < 3; ++k) {
            const long double x = n[k] / n[3] + origin[static_cast<Eigen::Index>(k)],
                              dx = (dn[k] - dn[3] * n[k] / n[3]) / n[3];
            CAPTURE(round);
            CHECK((net.box()[k].lower() <= x && x <= net.box()[k].upper()));
            CHECK((half.box()[k].lower() <= x && x <= half.box()[k].upper()));
            CHECK((net.derivative(0)[k].lower() <= dx && dx <= net.derivative(0)[k].upper()));
            CHECK((half.derivative(0)[k].lower() <= dx / 2 && dx / 2 <= half.derivative(0)[k].upper()));
        }
    }
}

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
