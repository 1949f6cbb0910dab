#include "curve.hpp"

#include <algorithm>
#include <climits>
#include <cmath>

#include "../newton/curve_newton.hpp"
#include "curve_connection.hpp"
#include "curve_parts.hpp"
#include "curve_slices.hpp"
#include "curve_work.hpp"

namespace vcell {

using namespace curve;

template <int N>
CurveSet<N + 1> solve_curves(const CurveSystem<N>& f, const IntervalBox<N + 1>& box,
                             const CurveOptions& options) {
    return in_ieee_arithmetic("solve_curves()", [&] {
        CurveWork<N> work(f, box, options);
        Subdivision<N>(work).run();
        Slicer<N> slicer(work);
        for (std::size_t leaf = 0; leaf < work.leaves.size(); ++leaf) slicer.slice(leaf);
        return Connection<N>(work).run();
    });
}

template <int N>
IntervalBox<N + 1> point_at(const CurveSystem<N>& f, const Tube<N + 1>& tube, double t) {
    return narrowed<N>(f, tube.enclosure, tube.axis, Interval(t));
}

template <int N>
WideBox<N + 1> point_at(const CurveSystem<N>& f, const Tube<N + 1>& tube, const Wide& t, int bits) {
    constexpr int D = N + 1;
    WideBox<D> y = converted<Wide>(narrowed<N>(f, tube.enclosure, tube.axis, t.enclosure()));
    y[tube.axis] = t;
    double size = 0;
    for (int i = 0; i < D; ++i)
        if (i != tube.axis) size = std::max(size, length(tube.neighbourhood[i]));
    const int enough = std::ilogb(size) - bits - 1;
    int last = INT_MAX;
    // Newton doubles the digits: 53 bits to those of Wide takes a few steps.
    for (int step = 0; step < 16; ++step) {
        int widest = INT_MIN;
        for (int i = 0; i < D; ++i)
            if (i != tube.axis) widest = std::max(widest, y[i].radius_exponent());
        if (widest <= enough || widest >= last) break;
        last = widest;
        const WideBox<D> at = centre(y);
        const Preconditioned<N, Wide> p(f.differentiate(y), tube.axis);
        const auto kept = intersection(p.newton(y, at, p.apply(f(at))), y);
        if (!kept) break;
        y = *kept;
    }
    return y;
}

#define VCELL_CURVES(N)                                                                         \
    template CurveSet<N + 1> solve_curves<N>(const CurveSystem<N>&, const IntervalBox<N + 1>&,  \
                                             const CurveOptions&);                              \
    template IntervalBox<N + 1> point_at<N>(const CurveSystem<N>&, const Tube<N + 1>&, double); \
    template WideBox<N + 1> point_at<N>(const CurveSystem<N>&, const Tube<N + 1>&, const Wide&, int);
VCELL_CURVES(1)
VCELL_CURVES(2)
VCELL_CURVES(3)
#undef VCELL_CURVES

}  // namespace vcell
