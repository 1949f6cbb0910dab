#include "curve_points.hpp"

#include <algorithm>

namespace vcell {

void CurvePoints::add_branch(bool is_vertical) {
    points_on_.push_back({});
    is_vertical_.push_back(is_vertical);
}

CurvePointId CurvePoints::add(Data data) {
    const Point p = points_.push_back({std::move(data), {}});
    equal_to_.add();
    equal_x_.add();
    for (const BranchId b : points_[p].data.on) points_on_[b].push_back(p);
    return p;
}

CurvePointId CurvePoints::add(OneRootPoint exact) {
    const auto shared = std::make_shared<const OneRootPoint>(std::move(exact));
    return add({enclosure(shared->x, shared->denominator), enclosure(shared->y, shared->denominator),
                [shared] {
                    return std::pair(coordinate_of<Wide>(shared->x, shared->denominator),
                                     coordinate_of<Wide>(shared->y, shared->denominator));
                },
                shared});
}

CurvePointId CurvePoints::add(double x, double y) {
    const auto [found, is_new] = given_.try_emplace({x, y});
    if (is_new) {
        found->second = add(OneRootPoint{{Exact(x), {}, {}}, {Exact(y), {}, {}}, Exact(1.0)});
        points_[found->second].data.x = x;
        points_[found->second].data.y = y;
    }
    return found->second;
}

std::pair<Wide, Wide> CurvePoints::fine_box(Point p) {
    auto& [data, fine] = points_[p];
    if (!fine) fine = data.refine();
    return *fine;
}

void CurvePoints::unite(Point p, Point q) {
    p = representative(p);
    q = representative(q);
    if (p == q) return;
    // An exact one stands for both.
    if (!points_[p].data.exact && points_[q].data.exact) std::swap(p, q);
    equal_to_.merge(q.value, p.value);
    equal_x_.merge(q.value, p.value);
    for (const BranchId b : std::vector(points_[q].data.on)) note_on(p, b);
}

void CurvePoints::note_on(Point p, BranchId b) {
    p = representative(p);
    auto& on = points_[p].data.on;
    if (std::find(on.begin(), on.end(), b) != on.end()) return;
    on.push_back(b);
    points_on_[b].push_back(p);
}

void CurvePoints::assume(const Interval& x, const Interval& y) {
    ++decisions_.assumed;
    assumed_at_.push_back({x.mid(), y.mid()});
}

bool CurvePoints::is_known_on(Point p, BranchId b) const {
    const std::vector<BranchId>& on = points_[representative(p)].data.on;
    return std::find(on.begin(), on.end(), b) != on.end();
}

CurvePoints::Comparison CurvePoints::compare_coordinate(Point p, Point q, int axis) {
    p = representative(p);
    q = representative(q);
    if (p == q) return {Sign::Zero};
    const Data &a = points_[p].data, &b = points_[q].data;
    const auto on_vertical_of_a = [&](BranchId on) {
        return is_vertical_[on] && std::find(a.on.begin(), a.on.end(), on) != a.on.end();
    };
    if (axis == 0 && (equal_x_.find(p.value) == equal_x_.find(q.value) ||
                      std::any_of(b.on.begin(), b.on.end(), on_vertical_of_a)))
        return {Sign::Zero};
    if (const auto s = axis == 0 ? compare_intervals(a.x, b.x) : compare_intervals(a.y, b.y)) {
        ++decisions_.by_interval;
        return {*s};
    }
    if (a.exact && b.exact) {
        ++decisions_.by_exact;
        const OneRoot &u = axis == 0 ? a.exact->x : a.exact->y, &v = axis == 0 ? b.exact->x : b.exact->y;
        return {compare(u, a.exact->denominator, v, b.exact->denominator)};
    }
    const auto [ax, ay] = fine_box(p);
    const auto [bx, by] = fine_box(q);
    if (const auto s = axis == 0 ? compare_intervals(ax, bx) : compare_intervals(ay, by)) {
        ++decisions_.by_multiprecision;
        return {*s};
    }
    return {Sign::Zero, true};
}

Sign CurvePoints::compare_x(Point p, Point q) {
    const Comparison c = compare_coordinate(p, q, 0);
    if (c.assumed) assume(points_[p].data.x, points_[p].data.y);
    if (c.sign == Sign::Zero) equal_x_.merge(p.value, q.value);
    return c.sign;
}

Sign CurvePoints::compare_xy(Point p, Point q) {
    if (representative(p) == representative(q)) return Sign::Zero;
    const Comparison by_x = compare_coordinate(p, q, 0);
    if (by_x.sign != Sign::Zero) return by_x.sign;
    equal_x_.merge(p.value, q.value);
    const Comparison by_y = compare_coordinate(p, q, 1);
    if (by_x.assumed || by_y.assumed) assume(points_[p].data.x, points_[p].data.y);
    if (by_y.sign == Sign::Zero) unite(p, q);
    return by_y.sign;
}

}  // namespace vcell
