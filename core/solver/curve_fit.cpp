#include "curve_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "curve_newton.hpp"

namespace vcell {

namespace {

using namespace curve;

double up_sum(double a, double b) { return Interval::up(a + b); }
double up_product(double a, double b) { return Interval::up(a * b); }

template <int N, int M>
class Fitter {
    static constexpr int D = N + 1;
    using Vector = Eigen::Matrix<double, D, 1>;
    using Image = Eigen::Matrix<double, M, 1>;
    using Lift = SmoothMap<D, M>;

    // A point of the spline in the chart, next to the curve, with all that its two spans ask of it.
    struct Knot {
        Point<D> x;
        Vector tangent;  // unit, in the direction of travel
        double offset = 0;  // of the point from the certified one it stands for
        Jets<Interval, N> f;
        std::array<Jet<Interval, D>, M> lift;
        Image image;
        Image image_tangent;
    };
    struct Span {
        std::array<Point<D>, 4> chart;
        std::array<Image, 4> image;
        double length;
        double error;
    };
    // The curve within one tube.
    struct Neighbourhood {
        IntervalBox<D> box;  // encloses the arc; the span's control points must lie in it
        Preconditioned<N, Interval> system;
        std::array<double, D> unit;
        std::array<Jet<Interval, D>, M> lift;
    };

public:
    Fitter(const CurveSystem<N>& f, const Lift* lift, const CurveComponent<D>& component, double tolerance)
        : f_(f), lift_(lift), component_(component), tolerance_(tolerance) {}

    FittedCurve<M> fit() {
        double step = 0;
        for (const Tube<D>& tube : component_.tubes) step = std::max(step, std::abs(tube.end - tube.begin));
        Knot from = knot_at_joint(0);
        const Knot first = from;
        for (std::size_t i = 0; i < component_.tubes.size(); ++i) {
            const bool last = i + 1 == component_.tubes.size();
            const Knot to = last && component_.closed ? first : knot_at_joint(i + 1);
            cover(i, from, to, step);
            from = to;
        }
        return assemble();
    }

private:
    Knot knot(const Point<D>& x, double offset) const {
        Knot k;
        k.x = x;
        k.offset = offset;
        k.f = f_.differentiate(converted<Interval>(x));
        const auto t = tangent<N>(k.f);
        for (int i = 0; i < D; ++i) k.tangent(i) = t[i];
        k.tangent.normalize();
        if (lift_) {
            k.lift = lift_->differentiate(converted<Interval>(x));
            k.image_tangent.setZero();
            for (int m = 0; m < M; ++m) {
                k.image(m) = k.lift[m].value.mid();
                for (int i = 0; i < D; ++i) k.image_tangent(m) += k.lift[m].gradient[i].mid() * k.tangent(i);
            }
        } else {
            for (int m = 0; m < M; ++m) k.image(m) = x[m], k.image_tangent(m) = k.tangent(m);
        }
        return k;
    }

    Knot knot_at_joint(std::size_t i) const {
        const IntervalBox<D>& joint = component_.joints[i];
        double offset = 0;
        const auto add = [&](const Interval& side) { offset = up_sum(offset, 2 * side.radius()); };
        if (lift_)
            for (const Interval& side : (*lift_)(joint)) add(side);
        else
            for (int m = 0; m < M; ++m) add(joint[m]);
        return knot(mid(joint), offset);
    }

    // Spans from a to b, the ends of the tube. step: the length of spans that suits the tolerance.
    void cover(std::size_t index, const Knot& a, const Knot& b, double& step) {
        const Tube<D>& tube = component_.tubes[index];
        const Neighbourhood near = neighbourhood(tube);
        // A span this short has met rounding errors.
        const double shortest = 0x1p-16 * std::abs(tube.end - tube.begin);
        Knot from = a;
        for (;;) {
            const double rest = std::abs(b.x[tube.axis] - from.x[tube.axis]);
            const double speed = std::max(std::abs(from.tangent(tube.axis)), 0.25);
            const double spans = std::ceil(rest / (step * speed) - 1e-3);
            const bool final = spans <= 1;
            const Knot to = final ? b : advance(tube, from, b.x[tube.axis], rest / spans, near);
            const Span span = hermite(from, to, tube, near);
            const double ratio = std::pow(tolerance_ / std::max(span.error, 1e-300), 0.25);
            const bool hopeless = rest / std::max(spans, 1.0) <= shortest;
            if (span.error <= tolerance_ || hopeless) {
                spans_.push_back(span);
                error_ = std::max(error_, span.error);
                if (!final || ratio < 1) step = (final ? std::min(step, span.length) : span.length) * std::clamp(0.9 * ratio, 0.3, 2.0);
                else step = std::max(step, span.length * std::clamp(0.9 * ratio, 0.3, 2.0));
                if (final) return;
                from = to;
            } else {
                step = std::min(step, rest / std::max(spans, 1.0) / speed) * (std::isfinite(ratio) ? std::clamp(0.9 * ratio, 0.1, 0.7) : 0.5);
            }
        }
    }

    Neighbourhood neighbourhood(const Tube<D>& tube) const {
        std::array<double, D> unit;
        for (int i = 0; i < D; ++i) unit[i] = tube.neighbourhood[i].upper() - tube.neighbourhood[i].lower();
        // Newton once more: enclosures of proofs are wide.
        IntervalBox<D> box = tube.enclosure;
        Point<D> m = middle_at(box, tube.axis, box[tube.axis].mid());
        settle<N>(f_, m, tube.axis, 0.0, 2);
        clamp_into(m, box);
        const IntervalBox<D> c = converted<Interval>(m);
        const Preconditioned<N, Interval> wide(f_.differentiate(box), tube.axis);
        box = intersection(wide.newton(box, c, wide.apply(f_(c))), box).value_or(box);
        // Control points lie beside the curve's hull.
        for (int i = 0; i < D; ++i) {
            constexpr double room = 0.25;
            const double r = room * (i == tube.axis ? 0.0 : box[i].upper() - box[i].lower());
            box[i] = *intersection(Interval(box[i].lower() - r, box[i].upper() + r), tube.neighbourhood[i]);
        }
        Neighbourhood result{box, Preconditioned<N, Interval>(f_.differentiate(box), tube.axis), unit, {}};
        if (lift_) result.lift = lift_->differentiate(box);
        return result;
    }

    // The knot whose axis coordinate is `distance` nearer to `end`.
    Knot advance(const Tube<D>& tube, const Knot& from, double end, double distance, const Neighbourhood& near) const {
        const double along = std::copysign(distance, end - from.x[tube.axis]);
        Point<D> x;
        for (int i = 0; i < D; ++i) x[i] = from.x[i] + from.tangent(i) / from.tangent(tube.axis) * along;
        x[tube.axis] = from.x[tube.axis] + along;
        clamp_into(x, near.box);
        settle<N>(f_, x, tube.axis, 1e-12 * distance, 6);
        clamp_into(x, near.box);
        return knot(x, 0);
    }

    Span hermite(const Knot& a, const Knot& b, const Tube<D>& tube, const Neighbourhood& near) const {
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
        if (!lift_)  // the same doubles, so that the image is the chart's curve itself
            for (int p = 1; p < 3; ++p)
                for (int m = 0; m < M; ++m) span.image[p](m) = span.chart[p][m];
        span.error = bound(span, a, b, tube, near);
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

    // Bounds |g(s)|, 0 <= s <= 1, by values and derivatives at the ends and the fourth Taylor coefficient between:
    // the Hermite basis functions of the values sum to 1, those of the derivatives stay below 4/27, and the
    // remainder is s^2 (1 - s)^2 <= 1/16 times the coefficient.
    static double hermite_bound(const Interval& g0, const Interval& g1, const Interval& d0, const Interval& d1,
                                const Interval& fourth) {
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

    double bound(const Span& span, const Knot& a, const Knot& b, const Tube<D>& tube,
                 const Neighbourhood& near) const {
        constexpr double unproved = std::numeric_limits<double>::infinity();
        const auto& c = span.chart;
        for (int p = 0; p < 3; ++p) {
            const double along = c[p + 1][tube.axis] - c[p][tube.axis];
            if (!((tube.end > tube.begin ? along : -along) > 0)) return unproved;
        }
        std::array<Series, D> chart;
        for (int i = 0; i < D; ++i) {
            chart[i] = cubic({c[0][i], c[1][i], c[2][i], c[3][i]});
            if (!is_subset(chart[i][0], near.box[i])) return unproved;
        }
        if (!near.system.regular(near.unit)) return unproved;

        // The distance in the chart, coordinate by coordinate, at equal coordinates along the axis.
        std::array<Interval, N> f0, f1, d0, d1, fourth;
        const auto along = f_.along(chart);
        for (int e = 0; e < N; ++e) {
            f0[e] = a.f[e].value;
            f1[e] = b.f[e].value;
            d0[e] = derivative(a.f[e].gradient, c[0], c[1]);
            d1[e] = derivative(b.f[e].gradient, c[2], c[3]);
            fourth[e] = along[e][4];
        }
        f0 = near.system.apply(f0), f1 = near.system.apply(f1);
        d0 = near.system.apply(d0), d1 = near.system.apply(d1);
        fourth = near.system.apply(fourth);
        std::array<double, N> residual;
        double scale = 0;
        for (int i = 0; i < N; ++i) {
            residual[i] = hermite_bound(f0[i], f1[i], d0[i], d1[i], fourth[i]);
            scale = std::max(scale, Interval::up(residual[i] / near.system.dominance(i, near.unit)));
        }
        std::array<double, D> distance{};
        for (int i = 0; i < N; ++i) {
            double sum = residual[i];
            for (int l = 0; l < N; ++l)
                if (l != i) {
                    const int column = near.system.column(l);
                    sum = up_sum(sum, up_product(near.system.row(i)[column].magnitude(),
                                                 up_product(scale, near.unit[column])));
                }
            const int column = near.system.column(i);
            distance[column] = Interval::up(sum / mignitude(near.system.row(i)[column]));
        }

        double squares = 0;
        const auto image = lift_ ? lift_->along(chart) : std::array<Series, M>{};
        for (int m = 0; m < M; ++m) {
            double component = 0;
            if (lift_) {
                const auto data = [&](const Knot& k) { return k.lift[m].value - Interval(k.image(m)); };
                const auto slope = [&](const Knot& k, int p) {
                    return derivative(k.lift[m].gradient, c[p], c[p + 1]) -
                           Interval(3.0) * (Interval(span.image[p + 1](m)) - Interval(span.image[p](m)));
                };
                component = hermite_bound(data(a), data(b), slope(a, 0), slope(b, 2), image[m][4]);
                for (int i = 0; i < D; ++i)
                    if (i != tube.axis)
                        component = up_sum(component, up_product(near.lift[m].gradient[i].magnitude(), distance[i]));
            } else {
                component = distance[m];
            }
            squares = up_sum(squares, up_product(component, component));
        }
        const double joints = std::max(a.offset, b.offset);
        const double error = up_sum(Interval::up(std::sqrt(squares)), joints);
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

    const CurveSystem<N>& f_;
    const Lift* lift_;
    const CurveComponent<D>& component_;
    const double tolerance_;
    std::vector<Span> spans_;
    double error_ = 0;
};

}  // namespace

template <int N, int M>
FittedCurve<M> fit_curve(const CurveSystem<N>& f, const CurveComponent<N + 1>& component,
                         const SmoothMap<N + 1, M>& lift, double tolerance) {
    return Fitter<N, M>(f, &lift, component, tolerance).fit();
}

template <int N, int M>
FittedCurve<M> fit_curve(const CurveSystem<N>& f, const CurveComponent<N + 1>& component, double tolerance) {
    static_assert(M <= N + 1);
    return Fitter<N, M>(f, nullptr, component, tolerance).fit();
}

#define VCELL_FIT_LIFTED(N, M)                                                                               \
    template FittedCurve<M> fit_curve<N, M>(const CurveSystem<N>&, const CurveComponent<N + 1>&,              \
                                            const SmoothMap<N + 1, M>&, double);
#define VCELL_FIT(N, M) \
    template FittedCurve<M> fit_curve<N, M>(const CurveSystem<N>&, const CurveComponent<N + 1>&, double);
VCELL_FIT(1, 2)
VCELL_FIT(2, 3)
VCELL_FIT(3, 3)
VCELL_FIT_LIFTED(1, 3)
#undef VCELL_FIT
#undef VCELL_FIT_LIFTED

}  // namespace vcell
