#include "nets.hpp"

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

const Vector<Interval>& Net::box() const {
    if (has_box_) return box_;
    box_ = position(points_[0]);
    for (std::size_t i = 1; i < points_.size(); ++i) box_ = hull(box_, position(points_[i]));
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
    const int degree = axis == 0 ? m_ : n_;
    const Vector<Interval>& whole = box();
    const Vec3 center = middle(whole) - origin_;
    const auto about = [&](const Point& p) {
        return Point{p[0] - center[0] * p[3], p[1] - center[1] * p[3], p[2] - center[2] * p[3], p[3]};
    };
    std::array<Interval, 4> slope;
    Interval weight = at(0, 0)[3].enclosure();
    bool first = true;
    for (int i = 0; i <= m_; ++i)
        for (int j = 0; j <= n_; ++j) {
            weight = hull(weight, at(i, j)[3].enclosure());
            if ((axis == 0 ? i : j) == 0) continue;
            const Point to = about(at(i, j)), from = about(axis == 0 ? at(i - 1, j) : at(i, j - 1));
            for (std::size_t k = 0; k < 4; ++k) {
                const Interval d = (static_cast<double>(degree) * (to[k] - from[k])).enclosure();
                slope[k] = first ? d : hull(slope[k], d);
            }
            first = false;
        }
    Vector<Interval> result;
    for (std::size_t k = 0; k < 3; ++k) {
        const Interval x = whole[k] - origin_[k] - center[k];
        result[k] = (slope[k] - slope[3] * x) / weight;
    }
    return result;
}

std::array<Net, 2> Net::halves(int axis) const {
    std::array<Net, 2> h{*this, *this};
    const int n = axis == 0 ? m_ : n_, lines = axis == 0 ? n_ : m_;
    const auto point = [axis](Net& net, int line, int i) -> Point& {
        return axis == 0 ? net.at(i, line) : net.at(line, i);
    };
    for (int line = 0; line <= lines; ++line)
        for (int k = 0; k <= n; ++k) {
            point(h[0], line, k) = point(h[1], line, 0);
            for (int i = 0; i < n - k; ++i) {
                Point& p = point(h[1], line, i);
                const Point& q = point(h[1], line, i + 1);
                for (std::size_t c = 0; c < 4; ++c) p[c] = 0.5 * (p[c] + q[c]);
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
