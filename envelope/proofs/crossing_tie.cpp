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
        : chart_{family.chart},
          unit_(family.axial_unit),
          center_(enclosure(crossing.center)),
          normal_(enclosure(crossing.normal)),
          delta_(crossing.delta.enclosure() / crossing.divisor.enclosure()),
          length_(norm(normal_)) {
        for (Interval& x : center_) x = x / crossing.divisor.enclosure();
        const auto foot_of = [&](const ExactVector& p) {
            const auto [x, y, z] = chart_.foot<Exact>(p.x, p.y);
            return ExactVector(x, y, z);
        };
        const ExactVector &c = crossing.center, &n = crossing.normal;
        is_upright_ = foot_of(n).is_zero() && cross(c - foot_of(c), n).is_zero();
    }

    // Does it run along a normal of the base? Then over these points of the chart.
    bool is_upright() const { return is_upright_; }
    std::array<ChartPoint, 2> feet() const {
        const auto over = [&](double side) {
            Point p = chart_.foot<Interval>(center_[0], center_[1]);
            for (int i = 0; i < 3; ++i) p[i] = p[i] + side * normal_[i];
            return chart_point(p);
        };
        return {over(1), over(-1)};
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

    ChartPoint chart_point(const Point& p) const { return chart_.chart_point<Interval>(p, unit_); }

    // s where the line comes next to the ray over a chart point.
    double beside(const Vector2d& q) const {
        const Vector3d ray = chart_.normal(q), n = middle(normal_),
                       m = middle(center_) - chart_.foot(Vector2d(q.x(), unit_ * q.y()));
        const Vector3d across = n - n.dot(ray) * ray;
        return -m.dot(across) / across.squaredNorm();
    }
    // A step of s that moves the chart's point by about `width`.
    double step(double s, double width) const {
        return width * from_base(at(Interval(s))).mid() / length_.mid();
    }

private:
    static Interval norm(const Point& p) { return sqrt(square(p[0]) + square(p[1]) + square(p[2])); }
    Interval from_base(const Point& p) const { return chart_.distance<Interval>(p); }

    BaseChart chart_;  // as the forms have it: not turned
    bool is_upright_ = false;
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
