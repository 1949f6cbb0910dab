#include "curve_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../newton/curve_newton.hpp"

namespace vcell {

namespace {

using namespace curve;

double up_sum(double a, double b) { return Interval::up(a + b); }
double up_product(double a, double b) { return Interval::up(a * b); }

// K maps: the N equations, and the M coordinates of the image unless these are the first unknowns (K = N).
template <int N, int M, int K>
class Fitter {
    static constexpr int D = N + 1;
    static constexpr bool mapped = K > N;
    using Vector = Eigen::Matrix<double, D, 1>;
    using Image = Eigen::Matrix<double, M, 1>;
    using Gradients = std::array<Jet<Interval, D>, K>;

    // A point of the spline next to the curve, with all that its two spans ask of it.
    struct Knot {
        Point<D> x;
        Vector tangent;     // unit, in the direction of travel
        double offset = 0;  // of the image from that of the certified point it stands for
        Gradients maps;
        Image image;
        Image image_tangent;
    };
    struct Span {
        std::array<Point<D>, 4> chart;
        std::array<Image, 4> image;
        double length;
        double error;
    };
    // Tubes in a row that share axis and neighbourhood.
    struct Stretch {
        int axis;
        bool upwards;
        const IntervalBox<D>& neighbourhood;
    };

public:
    Fitter(const SmoothMap<D, K>& maps, const CurveComponent<D>& component, double tolerance)
        : maps_(maps), component_(component), tolerance_(tolerance) {}

    FittedCurve<M> fit() {
        const auto& tubes = component_.tubes;
        Knot from = knot_at_joint(0);
        const Knot first = from;
        for (std::size_t i = 0, end; i < tubes.size(); i = end) {
            const Stretch stretch{tubes[i].axis, tubes[i].begin < tubes[i].end, tubes[i].neighbourhood};
            for (end = i + 1; end < tubes.size() && continues(tubes[end - 1], tubes[end]); ++end) continue;
            const Knot to = end == tubes.size() && component_.closed ? first : knot_at_joint(end);
            cover(stretch, from, to);
            from = to;
        }
        return assemble();
    }

private:
    static bool continues(const Tube<D>& a, const Tube<D>& b) {
        return a.axis == b.axis && a.end == b.begin && is_subset(a.neighbourhood, b.neighbourhood) &&
               is_subset(b.neighbourhood, a.neighbourhood);
    }

    static Jets<Interval, N> equations(const Gradients& g) {
        Jets<Interval, N> f;
        std::copy_n(g.begin(), N, f.begin());
        return f;
    }

    Knot knot(const Point<D>& x, double offset) const {
        Knot k;
        k.x = x;
        k.offset = offset;
        k.maps = maps_.differentiate(converted<Interval>(x));
        const auto t = tangent<N>(equations(k.maps));
        for (int i = 0; i < D; ++i) k.tangent(i) = t[i];
        k.tangent.normalize();
        for (int m = 0; m < M; ++m) {
            if constexpr (mapped) {
                k.image(m) = k.maps[N + m].value.mid();
                k.image_tangent(m) = 0;
                for (int i = 0; i < D; ++i)
                    k.image_tangent(m) += k.maps[N + m].gradient[i].mid() * k.tangent(i);
            } else {
                k.image(m) = x[m];
                k.image_tangent(m) = k.tangent(m);
            }
        }
        return k;
    }

    Knot knot_at_joint(std::size_t i) const {
        const IntervalBox<D>& joint = component_.joints[i];
        double offset = 0;
        if constexpr (mapped) {
            const auto image = maps_(joint);
            for (int m = 0; m < M; ++m) offset = up_sum(offset, image[N + m].width());
        } else {
            for (int m = 0; m < M; ++m) offset = up_sum(offset, joint[m].width());
        }
        return knot(mid(joint), offset);
    }

    // Appends spans from a to b, the ends of the stretch, equal in length as far as one can tell.
    void cover(const Stretch& stretch, const Knot& a, const Knot& b) {
        const int k = stretch.axis;
        // Nothing is gained by shorter spans where nothing can be proved about this one, or where half the
        // length does not halve the error: rounding prevails.
        const double shortest = 0x1p-20 * std::abs(b.x[k] - a.x[k]);
        constexpr double unproved = std::numeric_limits<double>::infinity();
        double rejected = unproved, rejected_length = 0;
        Knot from = a;
        for (;;) {
            const double rest = std::abs(b.x[k] - from.x[k]);
            const double speed = std::max(std::abs(from.tangent(k)), 0.25);
            constexpr double almost = 1.05;  // so much longer a last span may become
            const double spans = step_ == 0 ? 1.0 : std::ceil(rest / (almost * step_ * speed));
            const bool last = spans <= 1;
            const double advance = last ? rest : rest / spans;
            const Knot to = last ? b : knot_at(stretch, from, b.x[k], advance);
            const Span span = hermite(from, to, stretch);
            // The error grows with the fourth power of the length.
            constexpr double caution = 0.9;
            constexpr double no_error = std::numeric_limits<double>::min();  // no division by zero
            const double ratio = caution * std::pow(tolerance_ / std::max(span.error, no_error), 0.25);
            if (span.error == unproved && advance <= shortest) {
                spans_.push_back(last ? span : hermite(from, b, stretch));
                error_ = unproved;
                return;
            }
            const bool futile = advance <= 0.5 * rejected_length && span.error > 0.5 * rejected;
            if (span.error <= tolerance_ || futile) {
                spans_.push_back(span);
                error_ = std::max(error_, span.error);
                const double suggested = span.length * std::clamp(ratio, 0.5, 2.0);
                step_ = last ? std::max(step_, suggested) : suggested;
                if (last) return;
                from = to;
                rejected = unproved;
            } else {
                if (rejected == unproved || advance <= 0.5 * rejected_length) {
                    rejected = span.error;
                    rejected_length = advance;
                }
                step_ = advance / speed * std::clamp(ratio, 0.1, 0.7);
            }
        }
    }

    // The knot whose coordinate along the axis is nearer to `end` by `distance`.
    Knot knot_at(const Stretch& stretch, const Knot& from, double end, double distance) const {
        const int k = stretch.axis;
        const double along = std::copysign(distance, end - from.x[k]);
        Point<D> x;
        for (int i = 0; i < D; ++i) x[i] = from.x[i] + from.tangent(i) / from.tangent(k) * along;
        x[k] = from.x[k] + along;
        clamp_into(x, stretch.neighbourhood);
        settle<N>(maps_, x, k, 1e-9 * distance, 8);
        clamp_into(x, stretch.neighbourhood);
        return knot(x, 0);
    }

    Span hermite(const Knot& a, const Knot& b, const Stretch& stretch) const {
        Span span;
        double chord = 0;
        for (int i = 0; i < D; ++i) chord = std::hypot(chord, b.x[i] - a.x[i]);
        // The length of the end derivatives that fits circles best: 4 tan(turn / 4) radius.
        const double turn = std::acos(std::clamp(a.tangent.dot(b.tangent), -1.0, 1.0));
        span.length = 2 * chord / (1 + std::cos(0.5 * turn));
        const double third = span.length / 3;
        span.chart[0] = a.x;
        span.chart[3] = b.x;
        for (int i = 0; i < D; ++i) {
            span.chart[1][i] = a.x[i] + third * a.tangent(i);
            span.chart[2][i] = b.x[i] - third * b.tangent(i);
        }
        span.image = {a.image, a.image + third * a.image_tangent, b.image - third * b.image_tangent, b.image};
        if constexpr (!mapped)  // the same doubles: the image is the chart's cubic itself
            for (int p = 1; p < 3; ++p)
                for (int m = 0; m < M; ++m) span.image[p](m) = span.chart[p][m];
        span.error = bound(span, a, b, stretch);
        return span;
    }

    // The Taylor coefficients of the Bezier cubic p_0 ... p_3 at all s in [0, 1].
    static Series cubic(const std::array<double, 4>& p) {
        const auto across = [](const Interval& a, const Interval& b) { return b - a; };
        const std::array d{across(p[0], p[1]), across(p[1], p[2]), across(p[2], p[3])};
        const std::array e{across(d[0], d[1]), across(d[1], d[2])};
        const auto [lo, hi] = std::minmax_element(p.begin(), p.end());
        const Interval three(3.0);
        return Series({Interval(*lo, *hi), three * hull(hull(d[0], d[1]), d[2]), three * hull(e[0], e[1]),
                       across(e[0], e[1]), Interval(0.0)},
                      3);
    }

    // Bounds |g(s)|, 0 <= s <= 1, by values and derivatives at the ends and the fourth Taylor coefficient
    // between: the Hermite basis functions of the values sum to 1, those of the derivatives stay below 4/27,
    // and the remainder is s^2 (1 - s)^2 <= 1/16 times the coefficient.
    static double hermite_bound(const Interval& g0, const Interval& g1, const Interval& d0,
                                const Interval& d1, const Interval& fourth) {
        constexpr double basis = 0.1482;
        static_assert(basis * 27 > 4);
        const double ends = up_sum(std::max(g0.magnitude(), g1.magnitude()),
                                   up_product(basis, up_sum(d0.magnitude(), d1.magnitude())));
        return up_sum(ends, fourth.magnitude() / 16);
    }

    // Derivatives of a map's component along the span, from its gradient at an end: 3 grad . (q - p).
    static Interval derivative(const IntervalBox<D>& gradient, const Point<D>& p, const Point<D>& q) {
        Interval sum(0.0);
        for (int i = 0; i < D; ++i) sum += gradient[i] * (Interval(q[i]) - Interval(p[i]));
        return Interval(3.0) * sum;
    }

    double bound(const Span& span, const Knot& a, const Knot& b, const Stretch& stretch) const {
        constexpr double unproved = std::numeric_limits<double>::infinity();
        const auto& c = span.chart;
        for (int p = 0; p < 3; ++p)
            if (!(c[p][stretch.axis] != c[p + 1][stretch.axis] &&
                  (c[p][stretch.axis] < c[p + 1][stretch.axis]) == stretch.upwards))
                return unproved;
        std::array<Series, D> chart;
        for (int i = 0; i < D; ++i) chart[i] = cubic({c[0][i], c[1][i], c[2][i], c[3][i]});

        // The Jacobian over a box around the span. When the box has room for the distance that follows,
        // Newton about c(s) proves that the curve's point lies within that distance.
        const double room = std::min(4 * tolerance_, 0.125 * span.length);
        IntervalBox<D> around;
        for (int i = 0; i < D; ++i) {
            const Interval& hull = chart[i][0];
            if (!is_subset(hull, stretch.neighbourhood[i])) return unproved;
            around[i] = i == stretch.axis ? hull
                                          : *intersection(Interval(hull.lower() - room, hull.upper() + room),
                                                          stretch.neighbourhood[i]);
        }
        const Gradients maps = maps_.differentiate(around);
        const Preconditioned<N, Interval> system(equations(maps), stretch.axis);
        std::array<double, D> unit;
        unit.fill(1.0);
        if (!system.regular(unit)) return unproved;

        // The distance from the curve, coordinate by coordinate.
        const std::array<Series, K> along = maps_.along(chart);
        std::array<Interval, N> f0, f1, d0, d1, fourth;
        for (int e = 0; e < N; ++e) {
            f0[e] = a.maps[e].value;
            f1[e] = b.maps[e].value;
            d0[e] = derivative(a.maps[e].gradient, c[0], c[1]);
            d1[e] = derivative(b.maps[e].gradient, c[2], c[3]);
            fourth[e] = along[e][4];
        }
        f0 = system.apply(f0), f1 = system.apply(f1);
        d0 = system.apply(d0), d1 = system.apply(d1);
        fourth = system.apply(fourth);
        std::array<double, N> residual;
        double largest = 0;
        for (int i = 0; i < N; ++i) {
            residual[i] = hermite_bound(f0[i], f1[i], d0[i], d1[i], fourth[i]);
            largest = std::max(largest, Interval::up(residual[i] / system.dominance(i, unit)));
        }
        std::array<double, D> distance{};
        for (int i = 0; i < N; ++i) {
            const int column = system.column(i);
            double sum = residual[i];
            for (int l = 0; l < N; ++l)
                if (l != i)
                    sum = up_sum(sum, up_product(system.row(i)[system.column(l)].magnitude(), largest));
            distance[column] = Interval::up(sum / mignitude(system.row(i)[column]));
            const Interval& hull = chart[column][0];
            if (!(Interval::down(hull.lower() - largest) >= around[column].lower() &&
                  Interval::up(hull.upper() + largest) <= around[column].upper()))
                return unproved;
        }

        double squares = 0;
        for (int m = 0; m < M; ++m) {
            double component = 0;
            if constexpr (mapped) {
                const auto value = [&](const Knot& k) { return k.maps[N + m].value - Interval(k.image(m)); };
                const auto slope = [&](const Knot& k, int p) {
                    return derivative(k.maps[N + m].gradient, c[p], c[p + 1]) -
                           Interval(3.0) * (Interval(span.image[p + 1](m)) - Interval(span.image[p](m)));
                };
                component = hermite_bound(value(a), value(b), slope(a, 0), slope(b, 2), along[N + m][4]);
                for (int i = 0; i < D; ++i)
                    component =
                        up_sum(component, up_product(maps[N + m].gradient[i].magnitude(), distance[i]));
            } else {
                component = distance[m];
            }
            squares = up_sum(squares, up_product(component, component));
        }
        const double error = up_sum(Interval::up(std::sqrt(squares)), std::max(a.offset, b.offset));
        return error == error ? error : unproved;
    }

    FittedCurve<M> assemble() const {
        FittedCurve<M> result;
        result.error = error_;
        RationalCurve<M>& curve = result.curve;
        curve.degree = 3;
        const auto control = [](const Image& p) {
            typename RationalCurve<M>::ControlPoint q;
            q << p, 1.0;
            return q;
        };
        double t = 0;
        curve.knots.assign(4, t);
        curve.points.push_back(control(spans_.front().image[0]));
        for (const Span& span : spans_) {
            for (int p = 1; p < 4; ++p) curve.points.push_back(control(span.image[p]));
            t += span.length;
            curve.knots.insert(curve.knots.end(), 3, t);
        }
        curve.knots.push_back(t);
        return result;
    }

    const SmoothMap<D, K>& maps_;
    const CurveComponent<D>& component_;
    const double tolerance_;
    double step_ = 0;  // the length of spans that suits the tolerance; 0: not known yet
    std::vector<Span> spans_;
    double error_ = 0;
};

}  // namespace

template <int N, int M>
FittedCurve<M> fit_curve(const SmoothMap<N + 1, N + M>& f_and_image, const CurveComponent<N + 1>& component,
                         double tolerance) {
    return Fitter<N, M, N + M>(f_and_image, component, tolerance).fit();
}

template <int N, int M>
FittedCurve<M> fit_curve(const CurveSystem<N>& f, const CurveComponent<N + 1>& component, double tolerance) {
    static_assert(M <= N + 1);
    return Fitter<N, M, N>(f, component, tolerance).fit();
}

template FittedCurve<2> fit_curve<1, 2>(const CurveSystem<1>&, const CurveComponent<2>&, double);
template FittedCurve<3> fit_curve<2, 3>(const CurveSystem<2>&, const CurveComponent<3>&, double);
template FittedCurve<3> fit_curve<3, 3>(const CurveSystem<3>&, const CurveComponent<4>&, double);
template FittedCurve<3> fit_curve<1, 3>(const SmoothMap<2, 4>&, const CurveComponent<2>&, double);

}  // namespace vcell
