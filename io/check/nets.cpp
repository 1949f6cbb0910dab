#include "nets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vcell::check {

Net::Net(const RationalPatch& patch, const Vec3& origin) : Net(patch.degree_u, patch.degree_v, origin) {
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            const Eigen::Vector4d& c = patch.point(i, j);
            Point& p = at(i, j);
            for (int k = 0; k < 3; ++k) p[k] = c[3] * (MidRad(c[k]) - origin[k]);
            p[3] = c[3];
        }
}

Form Net::form(int coordinate) const {
    Form f(m_, n_);
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) f.set(i, j, at(i, j)[coordinate]);
    return f;
}

Vector<Interval> Net::position(const Point& p) const {
    Vector<Interval> x;
    const bool is_whole = is_exactly(p[3], 1);
    const MidRad share = is_whole ? MidRad(1.0) : MidRad(1.0) / p[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const MidRad from_origin = is_whole ? p[k] : share * p[k];
        x[k] = (from_origin + origin_[static_cast<Eigen::Index>(k)]).enclosure();
    }
    return x;
}

namespace {

/// The least interval that holds some by midpoint and radius, rounded outward once: rounding keeps their
/// order.
class Hull {
public:
    void meet(double mid, double radius) {
        if (!(radius < HUGE_VAL)) {
            lo_ = -HUGE_VAL;
            hi_ = HUGE_VAL;
            return;
        }
        lo_ = std::min(lo_, mid - radius);
        hi_ = std::max(hi_, mid + radius);
    }
    void meet(const MidRad& x) { meet(x.mid(), x.radius()); }
    Interval enclosure() const { return {Interval::down(lo_), Interval::up(hi_)}; }

private:
    double lo_ = HUGE_VAL, hi_ = -HUGE_VAL;
};

}  // namespace

// Where p is within r of its midpoint p0 and w within v of w0, p / w - p0 / w0 = ((p - p0) - (p0 / w0) (w -
// w0)) / w. The quotient's midpoint goes through two roundings, and the sum with the origin through one.
const Vector<Interval>& Net::box() const {
    if (has_box_) return box_;
    std::array<Hull, 3> all;
    for (const Point& p : points_) {
        const double w = p[3].mid(), rest = w - p[3].radius(), share = 1 / w;
        const double per_rest = rest > 0 ? (1 + 0x1p-40) / rest : HUGE_VAL, quotient = w == 1 ? 0 : 0x1p-51;
        for (std::size_t k = 0; k < 3; ++k) {
            const double q = share * p[k].mid(), x = q + origin_[static_cast<Eigen::Index>(k)];
            const double radius = (p[k].radius() + std::abs(q) * p[3].radius()) * per_rest +
                                  quotient * std::abs(q) + 0x1p-52 * std::abs(x) +
                                  std::numeric_limits<double>::min();
            all[k].meet(x, radius);
        }
    }
    for (std::size_t k = 0; k < 3; ++k) box_[k] = all[k].enclosure();
    has_box_ = true;
    return box_;
}

const Sizes& Net::sizes() const {
    if (has_sizes_) return sizes_;
    sizes_ = {};
    for (const Point& p : points_) sizes_.meet(p);
    has_sizes_ = true;
    return sizes_;
}

// x' = (N' - w' x) / w, with x about the middle of the net, where it is smallest.
Vector<Interval> Net::derivative(int axis) const {
    const int degree = axis == 0 ? m_ : n_, step = axis == 0 ? n_ + 1 : 1;
    if (degree == 0) return {};
    const Vector<Interval>& whole = box();
    const Vec3 center = middle(whole) - origin_;
    std::array<Hull, 4> slopes;
    Hull weights;
    const Point* to = points_.data();
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j, ++to) {
            weights.meet((*to)[3]);
            if ((axis == 0 ? i : j) == 0) continue;
            const Point& from = *(to - step);
            const MidRad weight = (*to)[3] - from[3];
            for (std::size_t k = 0; k < 3; ++k)
                slopes[k].meet((*to)[k] - from[k] - center[static_cast<Eigen::Index>(k)] * weight);
            slopes[3].meet(weight);
        }
    const auto slope = [&](std::size_t k) { return static_cast<double>(degree) * slopes[k].enclosure(); };
    const Interval weight = weights.enclosure(), of_weight = slope(3);
    Vector<Interval> result;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        result[k] = (slope(k) - of_weight * (whole[k] - origin_[at] - center[at])) / weight;
    }
    return result;
}

std::array<Net, 2> Net::halves(int axis) const {
    std::array<Net, 2> h{*this, *this};
    const int n = axis == 0 ? m_ : n_, lines = axis == 0 ? n_ : m_;
    const int step = axis == 0 ? n_ + 1 : 1, next_line = axis == 0 ? 1 : n_ + 1;
    Point *first = &h[0].at(0, 0), *second = &h[1].at(0, 0);
    for (int line = 0; line <= lines; ++line, first += next_line, second += next_line)
        for (int k = 0; k <= n; ++k) {
            first[k * step] = second[0];
            for (int i = 0; i < n - k; ++i) {
                Point& p = second[i * step];
                const Point& q = second[(i + 1) * step];
                for (std::size_t c = 0; c < 4; ++c) p[c] = mean(p[c], q[c]);
            }
        }
    return h;
}

Net Net::part(int axis, const MidRad& a, const MidRad& b) const {
    if (is_exactly(a, 0) && is_exactly(b, 1)) return *this;
    Net result = *this;
    const int n = axis == 0 ? m_ : n_, lines = axis == 0 ? n_ : m_;
    SmallVector<Point, 8> level;
    for (int line = 0; line <= lines; ++line)
        for (int j = 0; j <= n; ++j) {
            level.clear();
            for (int i = 0; i <= n; ++i) level.push_back(axis == 0 ? at(i, line) : at(line, i));
            for (int r = 1; r <= n; ++r)
                for (int i = 0; i + r <= n; ++i) level[i] = blend(level[i], level[i + 1], r <= j ? b : a);
            (axis == 0 ? result.at(j, line) : result.at(line, j)) = level[0];
        }
    return result;
}

Net net_over(const RationalPatch& patch, const Vec2& lo, const Vec2& hi, const Vec3& origin) {
    const auto place = [](double x, const std::array<double, 2>& domain) {
        return place_between(x, domain[0], domain[1]);
    };
    return Net(patch, origin)
        .part(0, place(lo.x(), patch.domain_u), place(hi.x(), patch.domain_u))
        .part(1, place(lo.y(), patch.domain_v), place(hi.y(), patch.domain_v));
}

}  // namespace vcell::check
