#include "crossing_tie.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "../../primitives/forms/crossing.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Point = std::array<Interval, 3>;
using ChartPoint = std::array<Interval, 2>;

Point enclosure(const ExactVector& v) { return {v.x.enclosure(), v.y.enclosure(), v.z.enclosure()}; }
Vector3d middle(const Point& p) { return {p[0].mid(), p[1].mid(), p[2].mid()}; }

// The line center + s normal across the cylinders, in coordinates in which u = n / W.
class CommonLine {
public:
    CommonLine(const FormFamily& family, const Crossing& crossing)
        : is_sphere_(family.chart == RadialChart::Stereographic),
          unit_(family.axial_unit),
          center_(enclosure(crossing.center)),
          normal_(enclosure(crossing.normal)),
          delta_(crossing.delta.enclosure() / crossing.divisor.enclosure()),
          length_(norm(normal_)) {
        for (Interval& x : center_) x = x / crossing.divisor.enclosure();
        const ExactVector &c = crossing.center, &n = crossing.normal;
        is_upright_ = is_sphere_ ? cross(c, n).is_zero()
                                 : n.y.sign() == Sign::Zero && (c.x * n.z - c.z * n.x).sign() == Sign::Zero;
    }

    // Does it run along a normal of the base? Then over these points of the chart.
    bool is_upright() const { return is_upright_; }
    std::array<ChartPoint, 2> feet() const {
        const Interval y = is_sphere_ ? normal_[1] : Interval(0);
        const auto foot = [&](double side) {
            const Interval s(side);
            return chart_point({s * normal_[0], is_sphere_ ? s * y : center_[1], s * normal_[2]});
        };
        return {foot(1), foot(-1)};
    }

    Point at(const Interval& s) const {
        Point p;
        for (int i = 0; i < 3; ++i) p[i] = center_[i] + s * normal_[i];
        return p;
    }
    // Distance from the base less that from the cylinders.
    Interval excess(double s) const {
        const Point p = at(Interval(s));
        return from_base(p) + delta_ - Interval(std::abs(s)) * length_;
    }

    ChartPoint chart_point(const Point& p) const {
        const Interval r = from_base(p);
        if (is_sphere_) {
            if (p[2].mid() >= 0) return {p[0] / (r + p[2]), p[1] / (r + p[2])};
            const Interval scale = (r - p[2]) / (square(p[0]) + square(p[1]));
            return {p[0] * scale, p[1] * scale};
        }
        const Interval y = p[1] / Interval(unit_);
        if (p[2].mid() >= 0) return {p[0] / (r + p[2]), y};
        return {Interval(2) - p[0] / (r - p[2]), y};
    }

    // s where the line comes next to the ray over a chart point.
    double beside(const Vector2d& q) const {
        const bool back = !is_sphere_ && q.x() > 1;
        const double x = back ? q.x() - 2 : q.x(), y = is_sphere_ ? q.y() : 0, sign = back ? -1 : 1;
        const Vector3d ray = Vector3d(2 * x, 2 * y, 1 - x * x - y * y) * (sign / (1 + x * x + y * y));
        const Vector3d n = middle(normal_),
                       m = middle(center_) - Vector3d(0, is_sphere_ ? 0 : unit_ * q.y(), 0);
        const Vector3d across = n - n.dot(ray) * ray;
        return -m.dot(across) / across.squaredNorm();
    }
    // A step of s that moves the chart's point by about `width`.
    double step(double s, double width) const {
        return width * from_base(at(Interval(s))).mid() / length_.mid();
    }

private:
    static Interval norm(const Point& p) { return sqrt(square(p[0]) + square(p[1]) + square(p[2])); }
    Interval from_base(const Point& p) const {
        return is_sphere_ ? norm(p) : sqrt(square(p[0]) + square(p[2]));
    }

    bool is_sphere_, is_upright_ = false;
    double unit_;
    Point center_, normal_;
    Interval delta_, length_;
};

}  // namespace

bool is_tie_over_crossing(const FormFamily& family, std::span<const FormId> forms,
                          const std::function<bool(const Interval& x, const Interval& y)>& inside,
                          const Vector2d& near, double width) {
    const auto crossing = equal_crossing(family, forms[0], forms[1]);
    if (!crossing) return false;
    for (const FormId f : forms.subspan(2))
        if (!equal_crossing(family, forms[0], f) || !runs_through(family, f, *crossing)) return false;
    const CommonLine line(family, *crossing);
    if (line.is_upright())
        return std::ranges::any_of(line.feet(), [&](const ChartPoint& p) { return inside(p[0], p[1]); });
    const double s = line.beside(near);
    constexpr int halvings = 10;
    double step = line.step(s, 0.5 * width);
    for (int k = 0; k < halvings; ++k, step *= 0.5) {
        if (!(step < std::abs(s))) continue;  // on the axes there is no gradient
        const auto [x, y] = line.chart_point(line.at(Interval(s - step, s + step)));
        if (!inside(x, y)) continue;
        const auto before = line.excess(s - step).sign(), after = line.excess(s + step).sign();
        return before && after && *before == -*after && *before != Sign::Zero;
    }
    return false;
}

}  // namespace vcell
