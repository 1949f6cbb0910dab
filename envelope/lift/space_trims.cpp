#include "space_trims.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/curves/quintic_nodes.hpp"
#include "sectors_around.hpp"

namespace vcell::space_fit {

namespace {

double magnitude(const Points& points, const Linear& f) {
    return f.head<4>().cwiseAbs().dot(points.topRows<4>().cwiseAbs().rowwise().maxCoeff()) + std::abs(f[4]);
}

// Ends so near to a seam count as on it: spans that are cut off closer to a node could not be proved.
double seam_width(const Points& points, const Linear& f, double tolerance) {
    return std::min(0x1p-32 * magnitude(points, f), 0.25 * tolerance);
}

// How far the surface is moved at most, along a span, where `across` moves by one.
double stretch(const SpacePart& part, const Points& points) {
    if (!part.surface || part.surface->kind() != RadialPatch::Kind::Graph) return 1;
    double v = 0;
    for (int k = 0; k < 6; ++k) v = std::max(v, std::abs(part.patch[1](points.col(k).head<4>())));
    return part.surface->coefficient(1, 0).head<3>().norm() +
           v * part.surface->coefficient(1, 1).head<3>().norm();
}

// A linear function of X that vanishes on a seam, in lengths on the surface, if the span crosses that.
std::optional<Linear> crossed_seam(const SpacePart& part, const Points& points, double tolerance) {
    for (int k = 0; k < 2; ++k) {
        if (!std::isfinite(part.range[k])) continue;
        const Linear f =
            stretch(part, points) * (part.across.numerator - part.range[k] * part.across.divisor);
        const auto values = (f.head<4>().transpose() * points.topRows<4>()).array() + f[4];
        const double outermost = k == 0 ? values.minCoeff() : -values.maxCoeff();
        if (outermost < -seam_width(points, f, tolerance)) return f;
    }
    return std::nullopt;
}

// Bounds the distance of the patch's points at the trim from the curve's; `largest_blur` grows to
// rounding's part.
double distance_on(const RadialPatch& patch, const Points& points, int side, double& largest_blur) {
    const Bernstein<5> u = row(points, 4 + 2 * side), v = row(points, 5 + 2 * side);
    const Bernstein<10> uu = square(u), vv = square(v);
    const double largest_u = u.largest(), largest_v = v.largest();
    const auto polynomial = [&](int k) {
        const auto in_v = [&](int i) {
            const auto c = [&](int j) { return patch.coefficient(i, j)[k]; };
            return raised<10>(c(1) * v + c(0)) + c(2) * vv;
        };
        return raised<20>(in_v(0)) + raised<20>(u * in_v(1)) + uu * in_v(2);
    };
    // Bounds the terms.
    const auto size = [&](int k) {
        double sum = 0;
        for (int i = 2; i >= 0; --i) {
            double in_v = 0;
            for (int j = 2; j >= 0; --j) in_v = in_v * largest_v + std::abs(patch.coefficient(i, j)[k]);
            sum = sum * largest_u + in_v;
        }
        return sum;
    };
    constexpr double blur = 2 * rounding;  // more terms than elsewhere
    const Bernstein<20> w = polynomial(3);
    const double least = w.smallest_coefficient() - blur * size(3);
    if (!(least > 0)) return infinity;
    double squared = 0, blurred = 0;
    for (int k = 0; k < 3; ++k) {
        const Bernstein<5> p = row(points, k);
        const double rounded = blur * (size(k) + p.largest() * size(3));
        squared += square((raised<25>(polynomial(k)) - p * w).largest() + rounded);
        blurred += square(rounded);
    }
    largest_blur = std::max(largest_blur, std::sqrt(blurred) / least);
    return std::sqrt(squared) / least;
}

// Are the coordinates those of the point's projection onto a base plane?
bool is_projection(const PatchCoordinates& c) {
    return c[0].numerator == Linear::Unit(0) && c[1].numerator == Linear::Unit(1);
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
        // Along a seam from an axis, of which v is one and the same increasing function in all parts.
        const PatchCoordinate& v = parts.front().patch[1];
        const bool rises = (v(point(points, 0)) < v(point(points, 1))) == (side == 0);
        const auto outside = [&](const SpacePart& part) {
            const PatchCoordinate& c = part.across;
            if (!(at(c.divisor, X) > 0)) return infinity;
            const double x = c(X) + (rises ? -seam_inwards : seam_inwards);
            return std::max(part.range[0] - x, x - part.range[1]);
        };
        auto best = parts.begin();
        if (const std::vector<double>& starts = arc.sites[side].starts; !starts.empty()) {
            const PatchCoordinate& c = best->across;
            const bool are_strips = c.divisor.head<4>().isZero(0);
            const double half = are_strips ? 0.5 * c(X) : std::atan2(at(c.numerator, X), at(c.divisor, X));
            best += sector_around(starts, half, [&](std::size_t i) { return outside(parts[i]); });
            if (!best->holds(X.head<3>())) best = parts.begin() + best->other;
        } else {
            best = std::ranges::min_element(parts, {}, outside);
        }
        trims.seam = crossed_seam(*best, points, tolerance);
        if (trims.seam && outside(*best) > -2 * seam_inwards) {
            // Just beside a seam the part may not be the one that the span leaves the seam for.
            const auto holds = [&](const SpacePart& part) {
                return outside(part) <= 2 * seam_inwards && part.holds(X.head<3>()) &&
                       !crossed_seam(part, points, tolerance);
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

TrimProof::TrimProof(const TubeProof& proof, const Patches& patches, const Points& points,
                     const SpanPolynomials& span, const Residuals& residuals)
    : proof_(proof), patches_(patches), residuals_(residuals) {
    for (int side = 0; side < 2; ++side) {
        if (!patches_[side]) continue;
        for (int i = 0; i < 2; ++i) {
            const PatchCoordinate& c = patches_[side]->patch[i];
            const Bernstein<5> v = row(points, 4 + 2 * side + i), numerator = span(c.numerator);
            const double divisor_size = span.size(c.divisor);
            double residual = 0, least = 0;
            if (c.divisor.head<4>().isZero()) {
                residual = (numerator - c.divisor[4] * v).largest();
                least = c.divisor[4];
            } else {
                const Bernstein<5> divisor = span(c.divisor);
                residual = QuinticNodes::get().largest(raised<10>(numerator) - v * divisor);
                least = divisor.smallest_coefficient();
            }
            trims_[side].residual[i] =
                residual + rounding * (span.size(c.numerator) + divisor_size * v.largest());
            trims_[side].divisor[i] = least - rounding * divisor_size;
        }
    }
}

double TrimProof::operator()(const Points& points, const LocalEquations& local, Tube& tube) const {
    const double tolerance = proof_.tolerance();
    double most = 0;
    for (int side = 0; side < 2 && most < infinity; ++side) {
        if (!patches_[side]) continue;
        double q = 0, error = trim_error(side, points, local, q);
        if (tube.curve <= tolerance && !(error <= tolerance) && patches_[side]->surface)
            if (const double other = distance_on(*patches_[side]->surface, points, side, tube.blur);
                other < error) {
                error = other;
                q = 0;
            }
        most = std::max(most, error);
        tube.q = std::max(tube.q, q);
    }
    return most;
}

double TrimProof::trim_error(int side, const Points& points, const LocalEquations& local, double& q) const {
    const ArcEquations& equations = proof_.equations();
    const PatchCoordinates& coordinates = patches_[side]->patch;
    const Neighbourhood& D = local.D;
    const Trim& trim = trims_[side];
    Matrix4d M;
    M.row(0) = local.frame.gradients[0];
    M.row(1) = local.frame.gradients[side + 1];
    std::array<double, 4> variations{local.variations[0], local.variations[side + 1]},
        e{residuals_.curve[0], residuals_.curve[side + 1]};
    if (side == 1 && equations.is_replaced) {
        const Equation& right = equations.bisectors[1];
        M.row(1) = right.gradient(D.center);
        variations[1] = right.variation(D.center, right.reach(D.center, points, D.room));
        e[1] = residuals_.right;
    }
    // A graph over the base plane: the patch's point is above or below the curve's, and may be so where the
    // graph is so steep that nothing else tells.
    const Equation& site = equations.sites[side];
    if (is_projection(coordinates) && site.fall() > 0) return e[0] + e[1] / site.fall();
    for (int i = 0; i < 2; ++i) {
        const PatchCoordinate& c = coordinates[i];
        const auto value = points.row(4 + 2 * side + i);
        const double low = value.minCoeff(), high = value.maxCoeff(), middle = 0.5 * (low + high);
        const Vector4d n = c.numerator.head<4>(), d = c.divisor.head<4>(), gradient = n - middle * d;
        const double scale = gradient.norm(), across = d.norm();
        if (!(trim.divisor[i] > D.room * across)) return infinity;
        M.row(2 + i) = gradient / scale;
        variations[2 + i] = 0.5 * (high - low) * across / scale;
        e[2 + i] = trim.residual[i] / scale;
    }
    const Solver solver(M, variations);
    q = solver.q;
    if (!solver.is_regular()) return infinity;
    const double distance = solver.distance(e);
    return distance <= D.room ? distance : infinity;
}

}  // namespace vcell::space_fit
