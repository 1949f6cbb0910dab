#include "face_at.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace vcell {

namespace {

// The parameters of the patch's point that is nearest to p, from the nearest one of a grid on.
Vec2 parameters_nearest_to(const RationalPatch& s, const Vec3& p) {
    constexpr int grid = 16, steps = 32;
    const Vec2 low(s.domain_u[0], s.domain_v[0]), high(s.domain_u[1], s.domain_v[1]);
    Vec2 best = low;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= grid; ++i)
        for (int j = 0; j <= grid; ++j) {
            const Vec2 uv = low + (high - low).cwiseProduct(Vec2(i, j)) / grid;
            const double square = (s.evaluate(uv.x(), uv.y()) - p).squaredNorm();
            if (square < least) {
                least = square;
                best = uv;
            }
        }
    for (int k = 0; k < steps; ++k) {
        const auto [du, dv] = s.partials(best.x(), best.y());
        const Vec3 off = p - s.evaluate(best.x(), best.y());
        const double a = du.dot(du), b = du.dot(dv), c = dv.dot(dv), f = du.dot(off), g = dv.dot(off),
                     determinant = a * c - b * b;
        if (!(determinant > 0)) break;
        const Vec2 next =
            (best + Vec2(c * f - b * g, a * g - b * f) / determinant).cwiseMax(low).cwiseMin(high);
        if (next == best) break;
        best = next;
    }
    return best;
}

double distance_from_side(const Vec2& p, const Vec2& a, const Vec2& b) {
    const Vec2 way = b - a;
    const double square = way.squaredNorm(),
                 part = square > 0 ? std::clamp((p - a).dot(way) / square, 0.0, 1.0) : 0.0;
    return (p - a - part * way).norm();
}

// Do the trims, as polygons, run around these parameters once, farther away than the curves from their
// chords?
bool is_within_trims(const TrimmedPatch& patch, const Vec2& at) {
    constexpr int pieces = 64;  // of a span
    const RationalPatch& s = patch.surface;
    const Vec2 size(s.domain_u[1] - s.domain_u[0], s.domain_v[1] - s.domain_v[0]);
    double turned = 0, nearest = std::numeric_limits<double>::infinity(), bent = 0;
    for (const auto& loop : patch.loops)
        for (const TrimCurve& c : loop)
            for (std::size_t k = static_cast<std::size_t>(c.curve.degree); k < c.curve.points.size(); ++k) {
                const double begin = c.curve.knots[k], end = c.curve.knots[k + 1];
                if (!(begin < end)) continue;
                const auto off = [&](double i) -> Vec2 {
                    return (c.curve.evaluate(begin + (end - begin) * i / pieces) - at).cwiseQuotient(size);
                };
                for (int i = 0; i < pieces; ++i) {
                    const Vec2 a = off(i), b = off(i + 1);
                    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
                    nearest = std::min(nearest, distance_from_side(Vec2::Zero(), a, b));
                    bent = std::max(bent, distance_from_side(off(i + 0.5), a, b));
                }
            }
    // A curve is farther from its chord than in the middle by less than twice, where it bends one way.
    constexpr double rounding = 0x1p-40;  // of parameters, a part of the domain
    return std::lround(turned / (2 * std::numbers::pi)) == 1 && nearest > 2 * bent + rounding;
}

}  // namespace

std::optional<std::uint32_t> face_at(const Cell& cell, Site site, const Vec3& p) {
    if (std::ranges::count(cell.faces, site, &CellFace::site) == 1)
        return static_cast<std::uint32_t>(std::ranges::find(cell.faces, site, &CellFace::site) -
                                          cell.faces.begin());
    constexpr double near = 1e-6;  // of the box: patches of one site are of one surface, on which p is
    const double apart = near * cell.scene.box.diagonal();
    std::optional<std::uint32_t> found;
    for (std::uint32_t f = 0; f < cell.faces.size(); ++f) {
        if (cell.faces[f].site != site) continue;
        for (const TrimmedPatch& patch : cell.faces[f].patches) {
            const Vec2 uv = parameters_nearest_to(patch.surface, p);
            if (!((patch.surface.evaluate(uv.x(), uv.y()) - p).norm() <= apart)) continue;
            if (!is_within_trims(patch, uv)) continue;
            if (found && *found != f) return std::nullopt;
            found = f;
        }
    }
    return found;
}

}  // namespace vcell
