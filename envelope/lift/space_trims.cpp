#include "space_trims.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/curves/quintic_nodes.hpp"

namespace vcell::space_fit {

namespace {

double magnitude(const Points& points, const Linear& f) {
    return f.head<4>().cwiseAbs().dot(points.topRows<4>().cwiseAbs().rowwise().maxCoeff()) + std::abs(f[4]);
}

// Ends so near to a seam count as on it: spans that are cut off closer to a node could not be proved.
double seam_width(const Points& points, const Linear& f, double tolerance) {
    return std::min(0x1p-32 * magnitude(points, f), 0.25 * tolerance);
}

// The linear function of X that vanishes where u is at an end of its range, if the span crosses that.
std::optional<Linear> crossed_seam(const SpacePart& part, const Points& points, double tolerance) {
    for (int k = 0; k < 2; ++k) {
        if (!std::isfinite(part.u[k])) continue;
        const Linear f = part.patch[0].numerator - part.u[k] * part.patch[0].divisor;
        const auto values = (f.head<4>().transpose() * points.topRows<4>()).array() + f[4];
        const double outermost = k == 0 ? values.minCoeff() : -values.maxCoeff();
        if (outermost < -seam_width(points, f, tolerance)) return f;
    }
    return std::nullopt;
}

}  // namespace

Trims place_trims(const SpaceArc& arc, double tolerance, Points& points) {
    Trims trims;
    const Vector4d X = point(points, 0.5);
    const QuinticNodes& nodes = QuinticNodes::get();
    const Eigen::Matrix<double, 4, 6> at_nodes = points.topRows<4>() * nodes.values;
    for (int side = 0; side < 2; ++side) {
        const std::vector<SpacePart>& parts = arc.sites[side].parts;
        if (parts.empty()) continue;
        const bool rises = (points(1, 0) < points(1, 5)) == (side == 0);
        const auto outside = [&](const SpacePart& part) {
            const PatchCoordinate& c = part.patch[0];
            if (!(at(c.divisor, X) > 0)) return infinity;
            const double u = c(X) + (rises ? -seam_inwards : seam_inwards);
            return std::max(part.u[0] - u, u - part.u[1]);
        };
        auto best = std::ranges::min_element(parts, {}, outside);
        trims.seam = crossed_seam(*best, points, tolerance);
        if (trims.seam && outside(*best) > -2 * seam_inwards) {
            // Just beside a seam the part may not be the one that the span leaves the seam for.
            const auto holds = [&](const SpacePart& part) {
                return outside(part) <= 2 * seam_inwards && !crossed_seam(part, points, tolerance);
            };
            if (const auto other = std::ranges::find_if(parts, holds); other != parts.end()) {
                best = other;
                trims.seam.reset();
            }
        }
        trims.part[side] = static_cast<std::uint32_t>(best - parts.begin());
        trims.patches[side] = &*best;
        if (trims.seam) return trims;
        // The sum of a needle's distances that is its first coordinate cancels.
        const bool is_needle = best->surface && best->surface->kind() == RadialPatch::Kind::Confocal;
        Eigen::Matrix<double, 2, 6> at;
        for (int k = 0; k < 6; ++k)
            at.col(k) = is_needle ? best->surface->parameters(Vec3(at_nodes.col(k).head<3>()))
                                  : Vec2(best->patch[0](at_nodes.col(k)), best->patch[1](at_nodes.col(k)));
        auto rows = points.middleRows<2>(4 + 2 * side);
        rows = at * nodes.coefficients;
        rows.col(0) = at.col(0);
        rows.col(5) = at.col(5);
    }
    return trims;
}

std::optional<Vector4d> sign_change(const Points& points, const Linear& f, double tolerance) {
    constexpr int parts = 8, halvings = 20;  // Newton's method does the rest
    const double near = seam_width(points, f, tolerance);
    for (int i = 0; i < parts; ++i) {
        double low = static_cast<double>(i) / parts, high = static_cast<double>(i + 1) / parts;
        const double a = at(f, point(points, low)), b = at(f, point(points, high));
        if (!(std::min(a, b) < -near && std::max(a, b) > near)) continue;
        for (int k = 0; k < halvings; ++k) {
            const double half = 0.5 * (low + high);
            ((at(f, point(points, half)) > 0) == (a > 0) ? low : high) = half;
        }
        return point(points, low);
    }
    return std::nullopt;
}

}  // namespace vcell::space_fit
