/// The certificate of a span: steps 1, 2 and 3 of spline_fit.hpp, and of step 4 what one span tells.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "../../core/solver/newton/root_distance.hpp"
#include "arc_equations.hpp"

namespace vcell::space_fit {

// Step 2, as gradients are rounded.
struct Solver : RootDistance<4> {
    // `variations`: of the rows.
    Solver(const Matrix4d& M, const std::array<double, 4>& variations)
        : RootDistance(M, variations, rounding) {}
};

// What the certificate finds.
struct Tube {
    double curve = 0, trims = 0;  // errors
    double start = 0, end = 0;    // distances of the ends from the curve
    double link = 0;              // points of the curve so close to an end are on the same arc
    double q = 0;                 // the largest of step 2
    double blur = 0;              // of the trims' error, what bounds rounding
    double curve_blur = 0;        // of the curve's

    // Parts would be no better where rounding is what counts.
    bool is_within(double tolerance) const {
        return curve <= std::max(tolerance, 2 * curve_blur) && trims <= std::max(tolerance, 4 * blur);
    }
    double error() const { return std::max(curve, trims); }
    bool is_proved() const { return error() < infinity; }
    // Will the next span join, if it is about as good?
    bool is_joint() const { return 4 * end <= link; }
    static Tube failed(double q = 0) { return {infinity, infinity, infinity, infinity, 0, q}; }
};

inline bool joins(const Tube& a, const Tube& b) { return a.end <= b.link || b.start <= a.link; }

// D: what is within `room` of the hull of a span's points, and so within `radius` of its middle.
struct Neighbourhood {
    Vector4d center;
    double radius, room;

    // The room is what a bound of the distance may come to before it is too much; q grows with it.
    Neighbourhood(const Points& points, double slack, double tolerance) {
        const auto X = points.topRows<4>();
        center = 0.5 * (X.rowwise().minCoeff() + X.rowwise().maxCoeff());
        const double half = std::sqrt((X.colwise() - center).colwise().squaredNorm().maxCoeff());
        room = std::min(0.25 * half, std::max(4 * tolerance, 0.03 * half)) + 16 * slack +
               rounding * center.norm();
        radius = half + room;
    }
    void set_room(double wider) {
        radius += wider - room;
        room = wider;
    }
};

// Step 1: of the three equations.
struct Residuals {
    std::array<double, 3> curve;
    double right;  // of the right site's equation, where another one is in its place
};

// What the equations are over D, and may do there.
struct LocalEquations {
    Neighbourhood D;
    Frame frame;
    std::array<double, 3> reach;
    std::array<double, 4> variations{};
};

// Which ends of a span are ends of the arc.
struct Terminals {
    bool from, to;
};

// A room of so many times what rounding changes about the place of an arc lets spans be linked.
constexpr double room_of_rounding = 32;

// Does rounding blur the arc so much at X that no span of this length, or a shorter one, can be proved?
bool is_blurred(const ArcEquations& equations, const Vector4d& X, double length);

// What rounding changes about the three equations at X.
std::array<double, 4> blurs(const ArcEquations& equations, const Vector4d& X);

class TubeProof {
public:
    // slack: of the arc's ends. end: the arc's.
    TubeProof(const ArcEquations& equations, double tolerance, double slack, const Vector4d& end)
        : equations_(equations), tolerance_(tolerance), slack_(slack), end_(end) {}

    double tolerance() const { return tolerance_; }
    const ArcEquations& equations() const { return equations_; }

    Residuals residuals(const SpanPolynomials& span) const {
        return {{equations_[0].residual(span), equations_[1].residual(span), equations_[2].residual(span)},
                equations_.is_replaced ? equations_.bisectors[1].residual(span) : 0};
    }
    LocalEquations local(const Points& points, const Neighbourhood& D) const;
    LocalEquations local(const Points& points) const {
        return local(points, Neighbourhood(points, slack_, tolerance_));
    }

    // In parts where one D does not prove it, or not an error of `most` though quarters should: q falls like
    // the size of D, if it is finite, and with it 1 / (1 - q). trims_error(points, local, tube) bounds the
    // error of what follows the curve, and adds to q and blur of the tube.
    template <class TrimsError>
    Tube certify(const Points& points, const Residuals& residuals, double most, Terminals terminals,
                 int halvings, const TrimsError& trims_error) const {
        LocalEquations here = local(points);
        Tube whole = curve_tube(points, residuals, terminals, here);
        if (const auto room = room_for_rounding(whole, here)) {
            const LocalEquations wider = local(points, *room);
            if (const Tube other = curve_tube(points, residuals, terminals, wider); other.is_proved()) {
                whole = other;
                here = wider;
            }
        }
        if (whole.is_proved()) whole.trims = trims_error(points, here, whole);
        if (halvings == 0 || is_final(whole, most, halvings)) return whole;
        const std::array<Points, 2> halves = halved(points);
        const Tube a =
            certify(halves[0], residuals, most, {terminals.from, false}, halvings - 1, trims_error);
        if (!a.is_proved() || !a.is_within(most)) return whole;
        const Tube b = certify(halves[1], residuals, most, {false, terminals.to}, halvings - 1, trims_error);
        if (!b.is_proved() || !joins(a, b)) return whole;
        return {std::max(a.curve, b.curve),
                std::max(a.trims, b.trims),
                a.start,
                b.end,
                std::min(a.link, b.link),
                std::max(a.q, b.q),
                std::max(a.blur, b.blur),
                std::max(a.curve_blur, b.curve_blur)};
    }

private:
    // A D in which what rounding makes of the distance can be linked, where that is what is in the way.
    std::optional<Neighbourhood> room_for_rounding(const Tube& tube, const LocalEquations& here) const;
    // Steps 2 to 4 in one D.
    Tube curve_tube(const Points& points, const Residuals& residuals, Terminals terminals,
                    const LocalEquations& here) const;
    // Are parts not worth trying?
    static bool is_final(const Tube& whole, double most, int halvings);
    static std::array<Points, 2> halved(const Points& points);
    std::array<double, 4> residuals_at(const Vector4d& X) const;

    const ArcEquations& equations_;
    double tolerance_, slack_;
    Vector4d end_;
};

}  // namespace vcell::space_fit
