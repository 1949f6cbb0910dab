/// The certificate of a span: steps 1, 2, 3 and 5 of space_spline.hpp, and of step 4 what one span tells.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "space_equation.hpp"

namespace vcell::space_fit {

// Step 2: the distance of a solution from a point with residuals e, as far as the ball allows.
struct Solver {
    Matrix4d inverse;
    std::array<double, 4> columns;
    double q;

    // `variations`: of the rows.
    Solver(const Matrix4d& M, const std::array<double, 4>& variations) : inverse(M.inverse()) {
        q = (Matrix4d::Identity() - inverse * M).norm();
        for (int i = 0; i < 4; ++i) {
            columns[i] = inverse.col(i).norm();
            q += columns[i] * (variations[i] + rounding);
        }
    }
    bool is_regular() const { return q < 1; }
    double distance(const std::array<double, 4>& e) const {
        double sum = 0;
        for (int i = 0; i < 4; ++i) sum += columns[i] * e[i];
        return sum / (1 - q);
    }
};

// What the certificate finds.
struct Tube {
    double curve = 0, trims = 0;  // errors
    double start = 0, end = 0;    // distances of the ends from the curve
    double link = 0;              // points of the curve so close to an end are on the same arc
    double q = 0;                 // the largest of step 2
    double blur = 0;              // of the trims' error, what bounds rounding

    // Parts would be no better where rounding is what counts.
    bool is_within(double tolerance) const {
        return curve <= tolerance && trims <= std::max(tolerance, 4 * blur);
    }
    double error() const { return std::max(curve, trims); }
    bool is_proved() const { return error() < infinity; }
    // Will the next span join, if it is about as good?
    bool is_joint() const { return 4 * end <= link; }
    static Tube failed(double q = 0) { return {infinity, infinity, infinity, infinity, 0, q}; }
};

inline bool joins(const Tube& a, const Tube& b) { return a.end <= b.link || b.start <= a.link; }

// The parts of the patches that a span's trims are for; null: none on this side.
using Patches = std::array<const SpacePart*, 2>;

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
    void widen(double factor) {
        radius += (factor - 1) * room;
        room *= factor;
    }
};

// Step 1: of the three equations, and of the trims in those of step 5, n - u d, with the divisors' least
// values.
struct Residuals {
    std::array<double, 3> curve;
    double right;  // of the right site's equation, where a plane's is in its place
    struct Trim {
        std::array<double, 2> residual, divisor;
    };
    std::array<Trim, 2> trims;
};

// Which ends of a span are ends of the edge.
struct Terminals {
    bool from, to;
};

class TubeProof {
public:
    // slack: of the vertices. end: of the edge.
    TubeProof(const ArcEquations& equations, double tolerance, double slack, const Vector4d& end)
        : equations_(equations), tolerance_(tolerance), slack_(slack), end_(end) {}

    Residuals curve_residuals(const SpanPolynomials& span) const {
        return {{equations_[0].residual(span), equations_[1].residual(span), equations_[2].residual(span)},
                equations_.is_replaced() ? equations_[equations_.right].residual(span) : 0,
                {}};
    }
    static void add_trims(const Points& points, const Patches& patches, const SpanPolynomials& span,
                          Residuals& residuals);

    // In parts where one D does not prove it, or not an error of `most` though quarters should: q falls like
    // the size of D, if it is finite, and with it 1 / (1 - q).
    Tube certify(const Points& points, const Patches& patches, const Residuals& residuals, double most,
                 Terminals terminals, int halvings) const;

    // Step 5 alone, of all the span in one D. Adds to q and blur of the tube.
    double trims_error(const Points& points, const Patches& patches, const Neighbourhood& D,
                       const Residuals& residuals, Tube& tube) const {
        return trims_error(points, patches, D, equations_.frame(D.center), range(points, D), residuals, tube);
    }

private:
    // What the three equations may do over D.
    struct Range {
        std::array<double, 3> reach;
        std::array<double, 4> variations{};
    };

    Tube tube(const Points& points, const Patches& patches, const Residuals& residuals,
              Terminals terminals) const;
    Range range(const Points& points, const Neighbourhood& D) const;
    std::array<double, 4> residuals_at(const Vector4d& X) const;
    double trims_error(const Points& points, const Patches& patches, const Neighbourhood& D,
                       const Frame& frame, const Range& over, const Residuals& residuals, Tube& tube) const;
    double trim_error(int side, const Points& points, const PatchCoordinates& coordinates,
                      const Neighbourhood& D, const Frame& frame, const Range& over,
                      const Residuals& residuals, double& largest_q) const;

    const ArcEquations& equations_;
    double tolerance_, slack_;
    Vector4d end_;
};

}  // namespace vcell::space_fit
