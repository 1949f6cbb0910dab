#include "region_area.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "quadrature.hpp"

namespace vcell::check {

namespace {

/// The area, per ds, of the wedge between a place of the plane and a span.
template <class T>
T wedge(const Place<T>& p, const std::array<double, 2>& from) {
    const MidRad along_x = MidRad(p.origin[0]) - from[0], along_y = MidRad(p.origin[1]) - from[1];
    const T x = p.n[0] + along_x * p.w, y = p.n[1] + along_y * p.w, dx = p.dn[0] + along_x * p.dw,
            dy = p.dn[1] + along_y * p.dw;
    return 0.5 * (x * dy - y * dx) / square(p.w);
}

}  // namespace

RegionArea region_area(const Cell& cell, const Frame& frame, const std::vector<std::vector<EdgeUse>>& uses,
                       const std::vector<EdgeBand>& bands, double enough) {
    std::vector<std::size_t> rim;
    for (std::size_t e = 0; e < uses.size(); ++e)
        if (uses[e].size() == 1) rim.push_back(e);
    if (rim.empty()) return {};
    const Triad<double> start = frame.about(cell.edges[rim[0]].curve.points[0].head<3>());
    const std::array<double, 2> from{start[0], start[1]};
    RegionArea result;
    for (const std::size_t e : rim) {
        const std::vector<Span> all = spans(cell.edges[e].curve, frame);
        Interval sum = 0.0;
        double length = 0, reach = 0;  // about
        for (const Span& span : all) {
            // About all of a wide conic's span rounding is told to be many times what it is.
            constexpr int pieces = 16, parts = 1024;
            const double share = enough / static_cast<double>(rim.size() * all.size());
            const auto density = [&]<class T>(const T& s) {
                return std::array<T, 1>{wedge(span.at(s), from)};
            };
            std::array<Interval, 1> along{};
            Effort effort{parts};
            for (int k = 0; k < pieces; ++k)
                integrate<1>(density, 2.0 * k / pieces - 1, 2.0 * (k + 1) / pieces - 1, {share}, along,
                             effort);
            sum += along[0];
        }
        result.area = uses[e][0].reversed ? result.area - sum : result.area + sum;
        // A curve lies among its control points, and is no longer than the way along them.
        const auto& points = cell.edges[e].curve.points;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Triad<double> p = frame.about(points[k].head<3>());
            reach = std::max(reach, std::hypot(p[0] - from[0], p[1] - from[1]));
            if (k > 0) length += (points[k] - points[k - 1]).head<3>().norm() / frame.unit();
        }
        // In a band beside it the true edge may run, and at either end there may be a gap to the next one.
        result.slack += 2 * bands[e].error * (length + reach);
    }
    return result;
}

}  // namespace vcell::check
