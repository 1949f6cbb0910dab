#include "cell_marks.hpp"

#include <algorithm>
#include <cmath>

namespace vcell::whole {

namespace {

// More than the rounding of a handful of lengths in doubles, and of sums of products in floats, as parts of
// their terms.
constexpr double rounding = 0x1p-44;
constexpr float coarseness = 0x1p-19F;
// In units of a cell; squares of squares of lengths up to this are numbers.
constexpr double farthest = 0x1p30;

}  // namespace

CellMarks::CellMarks(const Sphere& base, const SphereMarks& marks, const Eigen::Matrix3d& turn, double unit)
    : base_(base) {
    // The greatest t: forms are highest where faces end, and there between places.
    double top = -HUGE_VAL, bottom = 0;
    for (const SphereMarks::Mark& m : marks.places) {
        top = std::max(top, m.level);
        bottom = std::min(bottom, m.level);
    }
    are_bounds_ = marks.are_all && top < 0 && bottom / top < farthest;
    if (!are_bounds_) return;
    const double most = -1 / top;  // in `unit`
    unit_ = most * unit;
    steepest_ = marks.steepest * most;
    // A ball that is as near to a point at t as the base is no farther than 2 (t - R0) from its surface.
    from_ = -HUGE_VAL;
    reach_ = to_ = 2 * unit_ - base.radius + rounding * (unit_ + base.radius + base.center.cwiseAbs().sum());
    places_.resize((marks.places.size() + 3) / 4);
    gradients_.resize((marks.gradients.size() + 3) / 4);
    // Rows are filled up with the last marks.
    for (std::size_t i = 0; i < 4 * places_.size(); ++i) {
        const SphereMarks::Mark& m = marks.places[std::min(i, marks.places.size() - 1)];
        add(places_, i, turn * m.p, -m.level * most);
    }
    for (std::size_t i = 0; i < 4 * gradients_.size(); ++i) {
        const SphereMarks::Mark& m = marks.gradients[std::min(i, marks.gradients.size() - 1)];
        are_bounds_ = are_bounds_ && m.level > 0;
        add(gradients_, i, turn * -m.p, m.level * most);
    }
}

void CellMarks::add(std::vector<Row>& rows, std::size_t i, const Vec3& p, double level) {
    Row& row = rows[i / 4];
    const auto k = static_cast<Eigen::Index>(i % 4);
    const Vec3 at = p / level;
    row.x[k] = static_cast<float>(2 * p.x());
    row.y[k] = static_cast<float>(2 * p.y());
    row.z[k] = static_cast<float>(2 * p.z());
    row.level[k] = static_cast<float>(level);
    row.at_x[k] = static_cast<float>(at.x());
    row.at_y[k] = static_cast<float>(at.y());
    row.at_z[k] = static_cast<float>(at.z());
    row.offset[k] = static_cast<float>(p.dot(at));
}

bool CellMarks::may_touch(const Sphere& ball) const {
    const double away = distance(ball);
    if (!(away > from_) || away > to_) return false;
    const double over = 1 / unit_;
    const Vec3 c = over * (ball.center - base_.center);
    const double delta = over * (ball.radius - base_.radius), square = c.squaredNorm(),
                 length = std::sqrt(square),
                 // What is lost where coordinates are subtracted.
        lost = rounding * over *
               (ball.center.cwiseAbs().sum() + base_.center.cwiseAbs().sum() + ball.radius + base_.radius);
    const double C = square - delta * delta,
                 size = square + delta * delta + lost * (length + std::abs(delta));
    if (!(size < farthest && 2 * length * (1 + rounding) + lost < steepest_ * (C - rounding * size) &&
          lost < coarseness * (length + std::abs(delta))))
        return true;
    const auto x = static_cast<float>(c.x()), y = static_cast<float>(c.y()), z = static_cast<float>(c.z());
    const auto less = static_cast<float>(C - coarseness * size);
    const auto linear = static_cast<float>(coarseness * (4 * length + 2 * std::abs(delta)));
    const float of_delta = static_cast<float>(2 * delta) + linear;
    for (const Row& row : places_)
        if (!(row.level * less - (row.x * x + row.y * y + row.z * z) > of_delta).all()) return true;
    for (const Row& row : gradients_)
        if (!(row.level * less - (row.x * x + row.y * y + row.z * z) > linear).all()) return true;
    return false;
}

bool CellMarks::may_touch(const Box& centers, double radius) const {
    const double over = 1 / unit_;
    const Vec3 middle = over * (0.5 * (centers.min + centers.max) - base_.center),
               half = over * 0.5 * (centers.max - centers.min);
    const double most = over * (radius - base_.radius), least = -over * base_.radius;  // delta
    // Nearer than all else of the cell.
    const Vec3 beside = (middle.cwiseAbs() - half).cwiseMax(0);
    const double near = beside.norm(), lost = rounding * over *
                                              (centers.min.cwiseAbs().sum() + centers.max.cwiseAbs().sum() +
                                               base_.center.cwiseAbs().sum() + radius + base_.radius);
    const double far = (middle.cwiseAbs() + half).norm();
    if (near - over * radius > over * to_ + lost || far < over * from_ - lost) return false;
    const double length = middle.norm() + half.norm(), wide = std::max(std::abs(most), std::abs(least)),
                 size = length * length + wide * wide;
    if (!(size < farthest && lost < coarseness * (length + wide))) return true;
    const auto x = static_cast<float>(middle.x()), y = static_cast<float>(middle.y()),
               z = static_cast<float>(middle.z());
    const auto wx = static_cast<float>(half.x()), wy = static_cast<float>(half.y()),
               wz = static_cast<float>(half.z());
    const auto away = [](const Four& at, float from, float extent) {
        return ((at - from).abs() - extent).max(0.0F).square();
    };
    // What is taken of L for squares of delta, and where delta is linear; both are least at the ends.
    const auto least_of = [&](const Four& level) {
        const auto at = [&](double delta) {
            const auto d = static_cast<float>(delta);
            return (-level * (d * d) - 2 * d).eval();
        };
        return at(most).min(at(least)).eval();
    };
    const auto doubt = static_cast<float>(coarseness * 4 * size),
               linear = static_cast<float>(coarseness * (8 * length + 4 * wide)),
               square = static_cast<float>(wide * wide);
    for (const Row& row : places_) {
        const Four distance = away(row.at_x, x, wx) + away(row.at_y, y, wy) + away(row.at_z, z, wz);
        const Four value =
            row.level * (distance - doubt) - row.offset * (1 + coarseness) + least_of(row.level);
        if (!(value > linear).all()) return true;
    }
    for (const Row& row : gradients_) {
        const Four distance = away(row.at_x, x, wx) + away(row.at_y, y, wy) + away(row.at_z, z, wz);
        const Four value = row.level * (distance - doubt - square) - row.offset * (1 + coarseness);
        if (!(value > linear).all()) return true;
    }
    return false;
}

}  // namespace vcell::whole
