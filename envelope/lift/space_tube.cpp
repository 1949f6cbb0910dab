#include "space_tube.hpp"

namespace vcell::space_fit {

namespace {

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

Tube TubeProof::certify(const Points& points, const Patches& patches, const Residuals& residuals, double most,
                        Terminals terminals, int halvings) const {
    const Tube whole = tube(points, patches, residuals, terminals);
    const double error = whole.error();
    const bool hopeless = whole.is_proved()
                              ? whole.is_within(most) || error * (1 - whole.q) > most * (1 - 0.25 * whole.q)
                              : std::isfinite(whole.q) && whole.q > std::ldexp(1, halvings);
    if (halvings == 0 || hopeless) return whole;
    // De Casteljau at 1/2.
    Points first, second, work = points;
    for (int k = 0; k <= 5; ++k) {
        first.col(k) = work.col(0);
        second.col(5 - k) = work.col(5 - k);
        for (int i = 0; i < 5 - k; ++i) work.col(i) = 0.5 * (work.col(i) + work.col(i + 1));
    }
    const Tube a = certify(first, patches, residuals, most, {terminals.from, false}, halvings - 1);
    if (!a.is_proved() || !a.is_within(most)) return whole;
    const Tube b = certify(second, patches, residuals, most, {false, terminals.to}, halvings - 1);
    if (!b.is_proved() || !joins(a, b)) return whole;
    return {std::max(a.curve, b.curve), std::max(a.trims, b.trims), a.start, b.end, std::min(a.link, b.link),
            std::max(a.q, b.q),         std::max(a.blur, b.blur)};
}

// Steps 2 to 5 in one D.
Tube TubeProof::tube(const Points& points, const Patches& patches, const Residuals& residuals,
                     Terminals terminals) const {
    const Neighbourhood D(points, slack_, tolerance_);
    const Frame f = equations_.frame(D.center);
    const Range r = range(points, D);
    const Solver solver(f.matrix(), r.variations);
    if (!solver.is_regular()) return Tube::failed(solver.q);
    for (int k = 0; k < 5; ++k)
        if (!(f.T.dot(points.col(k + 1).head<4>() - points.col(k).head<4>()) > 0)) return Tube::failed();
    const auto& e = residuals.curve;
    const double distance = solver.distance({e[0], e[1], e[2], 0});
    if (!(distance <= D.room)) return Tube::failed();
    const Vector4d start = points.col(0).head<4>(), end = points.col(5).head<4>();
    const double slack = slack_ + rounding * D.center.norm();
    const bool holds_end = (D.center - end_).norm() <= D.radius + slack && f.T.dot(end_ - start) >= -slack &&
                           f.T.dot(end_ - end) <= slack;
    if (holds_end && !terminals.from && !terminals.to) return Tube::failed();
    // The slice through an end's point meets the curve next to it; the edge may end that much earlier.
    const double beyond = solver.distance({0, 0, 0, slack_});
    Tube tube{
        distance + beyond, 0, solver.distance(residuals_at(start)), solver.distance(residuals_at(end)), 0,
        solver.q};
    // Step 4: a third of the room each for a, the value at the end and the curvature.
    if (std::max(tube.start, tube.end) <= D.room / 3) {
        std::array<double, 4> curvatures{};
        for (int i = 0; i < 3; ++i) curvatures[i] = equations_[i].curvature_bound(D.center, r.reach[i]) / 8;
        tube.link = std::min(D.room / 3, std::sqrt(D.room / 3 / solver.distance(curvatures)));
    }
    tube.trims = trims_error(points, patches, D, f, r, residuals, tube);
    return tube;
}

TubeProof::Range TubeProof::range(const Points& points, const Neighbourhood& D) const {
    Range r;
    for (int i = 0; i < 3; ++i) {
        r.reach[i] = equations_[i].reach(D.center, points, D.room);
        r.variations[i] = equations_[i].variation(D.center, r.reach[i]);
    }
    return r;
}

std::array<double, 4> TubeProof::residuals_at(const Vector4d& X) const {
    std::array<double, 4> e{};
    for (int i = 0; i < 3; ++i) e[i] = equations_[i].residual(X);
    return e;
}

void TubeProof::add_trims(const Points& points, const Patches& patches, const SpanPolynomials& span,
                          Residuals& residuals) {
    for (int side = 0; side < 2; ++side) {
        if (!patches[side]) continue;
        for (int i = 0; i < 2; ++i) {
            const PatchCoordinate& c = patches[side]->patch[i];
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
            residuals.trims[side].residual[i] =
                residual + rounding * (span.size(c.numerator) + divisor_size * v.largest());
            residuals.trims[side].divisor[i] = least - rounding * divisor_size;
        }
    }
}

double TubeProof::trims_error(const Points& points, const Patches& patches, const Neighbourhood& D,
                              const Frame& frame, const Range& over, const Residuals& residuals,
                              Tube& tube) const {
    double most = 0;
    for (int side = 0; side < 2 && most < infinity; ++side) {
        if (!patches[side]) continue;
        double error = trim_error(side, points, patches[side]->patch, D, frame, over, residuals, tube.q);
        if (tube.curve <= tolerance_ && !(error <= tolerance_) && patches[side]->surface)
            error = std::min(error, distance_on(*patches[side]->surface, points, side, tube.blur));
        most = std::max(most, error);
    }
    return most;
}

double TubeProof::trim_error(int side, const Points& points, const PatchCoordinates& coordinates,
                             const Neighbourhood& D, const Frame& frame, const Range& over,
                             const Residuals& residuals, double& largest_q) const {
    const Residuals::Trim& trim = residuals.trims[side];
    Matrix4d M;
    M.row(0) = frame.gradients[0];
    M.row(1) = frame.gradients[side + 1];
    std::array<double, 4> variations{over.variations[0], over.variations[side + 1]},
        e{residuals.curve[0], residuals.curve[side + 1]};
    if (side == 1 && equations_.is_replaced()) {
        const Equation& right = equations_[equations_.right];
        M.row(1) = right.gradient(D.center);
        variations[1] = right.variation(D.center, right.reach(D.center, points, D.room));
        e[1] = residuals.right;
    }
    // A graph over the base plane: the patch's point is above or below the curve's, and may be so where the
    // graph is so steep that nothing else tells.
    const Equation& site = equations_[side == 1 ? equations_.right : 1];
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
    largest_q = std::max(largest_q, solver.q);
    if (!solver.is_regular()) return infinity;
    const double distance = solver.distance(e);
    return distance <= D.room ? distance : infinity;
}

}  // namespace vcell::space_fit
