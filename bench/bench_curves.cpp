// The time to trace, prove and fit a trisector, one thread, over random triples of the base plane with
//
//   psc   a sphere and a cylinder
//   pcc   two cylinders
//
// in the chart: g(x, y) = difference of the heights over the square [-10, 10]^2, its curves solved and the
// curves (x, y, height) fitted at 1e-4 and at 1e-7 of the diagonal of a scene box of height 20.
//
// Usage: bench_curves [triples, default 300]
//
// One CSV row per family and tolerance: medians over the triples that have a trisector. Times are CPU time,
// the best of three runs of each triple. Every result is checked: nothing undecided, the certified error
// within the tolerance, and sampled points of the splines on both heights to within it. A failure is the exit
// status 1.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <vector>

#include "../core/solver/fit/curve_fit.hpp"
#include "../core/solver/systems/scaled.hpp"
#include "../primitives/forms/cylinder_form.hpp"
#include "median.hpp"

namespace vcell::bench {
namespace {

constexpr double side = 10;
const double diagonal = std::sqrt(3.0) * 2 * side;

bool negative(double x) { return x < 0; }
bool negative(const Interval& x) { return x.upper() < 0; }
bool negative(const Wide& x) { return x.upper() < 0; }
bool negative(const Series& x) { return x[0].upper() < 0; }
template <class T, int N>
bool negative(const Jet<T, N>& x) {
    return negative(x.value);
}

// The polynomials C, beta and A of primitives/forms/cylinder_form.hpp in the monomials of x and y.
class CylinderHeight {
public:
    explicit CylinderHeight(const CylinderForm& f) {
        const Wide ax(f.ax), ay(f.ay), az(f.az), px(f.px), py(f.py), pz(f.pz), rho(f.rho), two(2.0);
        const Wide norm = ax * ax + ay * ay + az * az, k = -(ax * px + ay * py + az * pz);
        xx_ = norm - ax * ax;
        xy_ = -(two * ax * ay);
        yy_ = norm - ay * ay;
        x_ = -(two * (norm * px + ax * k));
        y_ = -(two * (norm * py + ay * k));
        c_ = norm * (px * px + py * py + pz * pz - rho * rho) - k * k;
        beta_x_ = ax * az;
        beta_y_ = ay * az;
        beta_ = norm * (rho + pz) + k * az;
        A_ = az * az;
    }
    template <class T>
    T operator()(const T& x, const T& y) const {
        using std::sqrt;
        const T C = x * (scaled(xx_, x) + scaled(xy_, y) + constant<T>(x_)) +
                    y * (scaled(yy_, y) + constant<T>(y_)) + constant<T>(c_);
        const T beta = scaled(beta_x_, x) + scaled(beta_y_, y) + constant<T>(beta_);
        const T root = sqrt(square(beta) + scaled(A_, C));
        return negative(beta) ? (root - beta) / constant<T>(A_) : C / (root + beta);
    }

private:
    Coefficient xx_{0.0}, xy_{0.0}, yy_{0.0}, x_{0.0}, y_{0.0}, c_{0.0}, beta_x_{0.0}, beta_y_{0.0},
        beta_{0.0}, A_{0.0};
};

class SphereHeight {
public:
    SphereHeight(double x, double y, double z, double rho)
        : x_(x),
          y_(y),
          offset_(Wide(z) * Wide(z) - Wide(rho) * Wide(rho)),
          factor_(Wide(0.5) / (Wide(z) + Wide(rho))) {}
    template <class T>
    T operator()(const T& x, const T& y) const {
        return scaled(factor_, square(x - T(x_)) + square(y - T(y_)) + constant<T>(offset_));
    }

private:
    double x_, y_;
    Coefficient offset_, factor_;
};

class Triples {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    // Of any direction, as long as it stays clear of the base within the region.
    CylinderForm cylinder() {
        for (;;) {
            const CylinderForm f{number(-8, 8), number(-8, 8), number(3, 12), number(-1, 1),
                                 number(-1, 1), number(-1, 1), number(0.3, 2)};
            bool clear = true;
            for (int i = 0; clear && i <= 40; ++i)
                for (int j = 0; clear && j <= 40; ++j)
                    clear = cylinder_terms(f, side * (i / 20.0 - 1), side * (j / 20.0 - 1))[0] > 0.1;
            if (clear) return f;
        }
    }
    SphereHeight sphere() { return {number(-8, 8), number(-8, 8), number(2.5, 12), number(0.3, 2)}; }

private:
    std::mt19937_64 rng_{20090217};
};

double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

struct Row {
    std::vector<double> time, solve, parts, tubes, spans;
};

// Measures one triple into the rows of both tolerances; false: a wrong result. No trisector: no entry.
template <class First, class Second>
bool measure(const First& first, const Second& second, const std::vector<double>& tolerances,
             std::vector<Row>& rows) {
    const IntervalBox<2> region{Interval(-side, side), Interval(-side, side)};
    const CurveSystem<1> f([=](const auto& p) { return std::array{first(p[0], p[1]) - second(p[0], p[1])}; });
    const SmoothMap<2, 4> lifted([=](const auto& p) {
        const auto z = first(p[0], p[1]);
        return std::array{z - second(p[0], p[1]), p[0], p[1], z};
    });
    for (std::size_t i = 0; i < tolerances.size(); ++i) {
        double solve = HUGE_VAL, time = HUGE_VAL;
        CurveSet<2> set;
        std::vector<FittedCurve<3>> fits;
        for (int repetition = 0; repetition < 3; ++repetition) {
            const double start = seconds();
            set = solve_curves<1>(f, region);
            solve = std::min(solve, seconds() - start);
            fits.clear();
            for (const auto& component : set.components)
                fits.push_back(fit_curve<1, 3>(lifted, component, tolerances[i] * diagonal));
            time = std::min(time, seconds() - start);
        }
        if (!set.complete()) return false;
        if (set.components.empty()) return true;
        std::size_t tubes = 0, spans = 0;
        for (const auto& component : set.components) tubes += component.tubes.size();
        for (const auto& fit : fits) {
            spans += fit.curve.points.size() / 3;
            if (!(fit.error <= tolerances[i] * diagonal)) return false;
            for (int s = 0; s <= 100; ++s) {
                const Eigen::Vector3d p = fit.curve.evaluate(
                    std::lerp(fit.curve.domain_begin(), fit.curve.domain_end(), s / 100.0));
                // Heights of such forms over the region grow by less than 10 per unit.
                const double allowed = 11 * tolerances[i] * diagonal;
                if (std::abs(first(p.x(), p.y()) - p.z()) > allowed) return false;
                if (std::abs(second(p.x(), p.y()) - p.z()) > allowed) return false;
            }
        }
        rows[i].time.push_back(time);
        rows[i].solve.push_back(solve);
        rows[i].parts.push_back(double(set.parts));
        rows[i].tubes.push_back(double(tubes));
        rows[i].spans.push_back(double(spans));
    }
    return true;
}

int run(std::size_t triples) {
    const std::vector<double> tolerances{1e-4, 1e-7};
    Triples random;
    int status = 0;
    std::printf("family,triples,tolerance_of_diagonal,seconds,seconds_solve,parts,tubes,spans\n");
    for (const bool two_cylinders : {false, true}) {
        std::vector<Row> rows(tolerances.size());
        while (rows[0].time.size() < triples) {
            const CylinderHeight a(random.cylinder()), b(random.cylinder());
            const SphereHeight s = random.sphere();
            const bool right =
                two_cylinders ? measure(a, b, tolerances, rows) : measure(s, a, tolerances, rows);
            if (!right) {
                std::fprintf(stderr, "wrong result after %zu triples\n", rows[0].time.size());
                status = 1;
            }
        }
        for (std::size_t i = 0; i < rows.size(); ++i)
            std::printf("%s,%zu,%g,%.3g,%.3g,%g,%g,%g\n", two_cylinders ? "pcc" : "psc", rows[i].time.size(),
                        tolerances[i], median(rows[i].time), median(rows[i].solve), median(rows[i].parts),
                        median(rows[i].tubes), median(rows[i].spans));
    }
    return status;
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    return vcell::bench::run(argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 300);
}
