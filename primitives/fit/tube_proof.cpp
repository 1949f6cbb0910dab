#include "tube_proof.hpp"

namespace vcell::space_fit {

bool is_blurred(const ArcEquations& equations, const Vector4d& X, double length) {
    // Spans so much longer than the blur have room enough, and so much shorter ones are not worth it.
    constexpr double longest = 64, shortest = 16;
    // Of a room in which spans that are not much shorter can be proved.
    constexpr double small_q = 0.4;
    const Matrix4d M = equations.frame(X).matrix();
    const Solver solver(M, {});
    if (!solver.is_regular()) return true;
    const double blur = solver.distance(blurs(equations, X));
    if (longest * blur <= length) return false;
    if (!(shortest * blur <= length)) return true;
    std::array<double, 4> variations{};
    for (int i = 0; i < 3; ++i) variations[i] = equations[i].variation(X, room_of_rounding * blur);
    return !(Solver(M, variations).q <= small_q);
}

std::array<double, 4> blurs(const ArcEquations& equations, const Vector4d& X) {
    std::array<double, 4> e{};
    for (int i = 0; i < 3; ++i) e[i] = rounding * equations[i].size(X);
    return e;
}

bool TubeProof::is_final(const Tube& whole, double most, int halvings) {
    const double error = whole.error();
    return whole.is_proved() ? whole.is_within(most) || error * (1 - whole.q) > most * (1 - 0.25 * whole.q)
                             : std::isfinite(whole.q) && whole.q > std::ldexp(1, halvings);
}

// De Casteljau at 1/2.
std::array<Points, 2> TubeProof::halved(const Points& points) {
    std::array<Points, 2> halves;
    Points work = points;
    for (int k = 0; k <= 5; ++k) {
        halves[0].col(k) = work.col(0);
        halves[1].col(5 - k) = work.col(5 - k);
        for (int i = 0; i < 5 - k; ++i) work.col(i) = 0.5 * (work.col(i) + work.col(i + 1));
    }
    return halves;
}

LocalEquations TubeProof::local(const Points& points, const Neighbourhood& D) const {
    LocalEquations here{D, equations_.frame(D.center), {}};
    for (int i = 0; i < 3; ++i) {
        here.reach[i] = equations_[i].reach(D.center, points, D.room);
        here.variations[i] = equations_[i].variation(D.center, here.reach[i]);
    }
    return here;
}

std::optional<Neighbourhood> TubeProof::room_for_rounding(const Tube& tube,
                                                          const LocalEquations& here) const {
    if (tube.is_proved() ? tube.is_joint() : !(tube.q < 1)) return std::nullopt;
    const Solver solver(here.frame.matrix(), {});
    if (!solver.is_regular()) return std::nullopt;
    const double room = room_of_rounding * solver.distance(blurs(equations_, here.D.center));
    if (!(room > here.D.room)) return std::nullopt;
    Neighbourhood wider = here.D;
    wider.set_room(room);
    return wider;
}

Tube TubeProof::curve_tube(const Points& points, const Residuals& residuals, Terminals terminals,
                           const LocalEquations& here) const {
    const Neighbourhood& D = here.D;
    const Frame& f = here.frame;
    const Solver solver(f.matrix(), here.variations);
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
    // The slice through an end's point meets the curve next to it; the arc may end that much earlier.
    const double beyond = solver.distance({0, 0, 0, slack_});
    Tube tube{
        distance + beyond, 0, solver.distance(residuals_at(start)), solver.distance(residuals_at(end)), 0,
        solver.q};
    tube.curve_blur = solver.distance(blurs(equations_, D.center));
    // Step 4: a third of the room each for a, the value at the end and the curvature.
    if (std::max(tube.start, tube.end) <= D.room / 3) {
        std::array<double, 4> curvatures{};
        for (int i = 0; i < 3; ++i)
            curvatures[i] = equations_[i].curvature_bound(D.center, here.reach[i]) / 8;
        tube.link = std::min(D.room / 3, std::sqrt(D.room / 3 / solver.distance(curvatures)));
    }
    return tube;
}

std::array<double, 4> TubeProof::residuals_at(const Vector4d& X) const {
    std::array<double, 4> e{};
    for (int i = 0; i < 3; ++i) e[i] = equations_[i].residual(X);
    return e;
}

}  // namespace vcell::space_fit
