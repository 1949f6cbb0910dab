#include "cell_marks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace vcell::whole {

namespace {

// More than the rounding of a handful of lengths in doubles, and of sums of products in floats, as parts of
// their terms.
constexpr double rounding = 0x1p-44;
constexpr float coarseness = 0x1p-19F;
// The same of squares of distances, and of what subtracting coordinates loses there.
constexpr float head_coarseness = 0x1p-15F;
// In units of a cell; squares of squares of lengths up to this are numbers.
constexpr double farthest = 0x1p30;

// Which of four values are: a bit for each. One that is no number is not.
unsigned positive(const Eigen::Array4f& values) {
#if defined(__SSE2__)
    return static_cast<unsigned>(
        _mm_movemask_ps(_mm_cmpgt_ps(_mm_loadu_ps(values.data()), _mm_setzero_ps())));
#else
    unsigned bits = 0;
    for (int i = 0; i < 4; ++i)
        if (values[i] > 0) bits |= 1u << i;
    return bits;
#endif
}

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
    // Octant by octant, for rows to lie together.
    constexpr std::size_t octants = 8;
    const auto octant = [](const Vec3& p) {
        return static_cast<std::size_t>((p.x() > 0) + 2 * (p.y() > 0) + 4 * (p.z() > 0));
    };
    std::array<std::uint32_t, octants + 1> begin{};
    for (const SphereMarks::Mark& m : marks.places) ++begin[octant(m.p) + 1];
    for (const SphereMarks::Mark& m : marks.gradients) ++begin[octant(-m.p) + 1];
    for (std::size_t k = 0; k < octants; ++k) begin[k + 1] += begin[k];
    const std::size_t count = marks.places.size() + marks.gradients.size();
    rows_.resize((count + 3) / 4);
    for (const SphereMarks::Mark& m : marks.places)
        add(begin[octant(m.p)]++, turn * m.p, -most * m.level, true);
    for (const SphereMarks::Mark& m : marks.gradients) {
        are_bounds_ = are_bounds_ && m.level > 0;
        add(begin[octant(-m.p)]++, turn * -m.p, most * m.level, false);
    }
    // The last row is filled up with any mark.
    const SphereMarks::Mark& m = marks.places.front();
    for (std::size_t i = count; i < 4 * rows_.size(); ++i) add(i, turn * m.p, -most * m.level, true);
    set_heads();
}

void CellMarks::add(std::size_t i, const Vec3& p, double level, bool is_place) {
    Row& row = rows_[i / 4];
    const auto k = static_cast<Eigen::Index>(i % 4);
    const Vec3 at = (1 / level) * p;
    row.x[k] = static_cast<float>(2 * p.x());
    row.y[k] = static_cast<float>(2 * p.y());
    row.z[k] = static_cast<float>(2 * p.z());
    row.level[k] = static_cast<float>(level);
    row.with_delta[k] = is_place ? 1 : 0;
    row.at_x[k] = static_cast<float>(at.x());
    row.at_y[k] = static_cast<float>(at.y());
    row.at_z[k] = static_cast<float>(at.z());
    row.offset[k] = static_cast<float>(p.dot(at));
}

void CellMarks::set_heads() {
    heads_.resize((rows_.size() + 3) / 4);
    for (std::size_t i = 0; i < 4 * heads_.size(); ++i) {
        const Row& row = rows_[std::min(i, rows_.size() - 1)];
        const float x = row.at_x.mean(), y = row.at_y.mean(), z = row.at_z.mean();
        const Four away =
                       ((row.at_x - x).square() + (row.at_y - y).square() + (row.at_z - z).square()).sqrt(),
                   far = (row.at_x.square() + row.at_y.square() + row.at_z.square()).sqrt();
        Head& head = heads_[i / 4];
        const auto k = static_cast<Eigen::Index>(i % 4);
        head.x[k] = x;
        head.y[k] = y;
        head.z[k] = z;
        head.radius[k] = (away + far).maxCoeff();
    }
}

template <class IsFar, class SaysNo>
bool CellMarks::all_say_no(const IsFar& is_far, const SaysNo& says_no) const {
    for (std::size_t i = 0; i < heads_.size(); ++i) {
        unsigned near = ~is_far(heads_[i]) & 15u;
        for (std::size_t k = 4 * i; near != 0 && k < rows_.size(); ++k, near >>= 1)
            if ((near & 1u) != 0 && says_no(rows_[k]) != 15u) return false;
    }
    return true;
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
    const float twice_delta = static_cast<float>(2 * delta);
    const float apart = static_cast<float>(std::abs(delta)),
                doubt = static_cast<float>(square) * head_coarseness;
    return !all_say_no(
        [&](const Head& head) {
            const Four reach = head.radius + apart;
            return positive((head.x - x).square() + (head.y - y).square() + (head.z - z).square() -
                            reach.square() * (1 + head_coarseness) - doubt);
        },
        [&](const Row& row) {
            return positive(row.level * less - (row.x * x + row.y * y + row.z * z) -
                            row.with_delta * twice_delta - linear);
        });
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
    // No ball of these is one that may_touch(ball) does not compare. Of the others that asks for a fourth of
    // the doubts below.
    constexpr double more = 0x1p-10;
    if (!(size * (1 + more) < farthest && lost < 0.5 * coarseness * near &&
          2 * length * (1 + more) < steepest_ * (near * near - wide * wide - more * size)))
        return true;
    const auto x = static_cast<float>(middle.x()), y = static_cast<float>(middle.y()),
               z = static_cast<float>(middle.z());
    const auto wx = static_cast<float>(half.x()), wy = static_cast<float>(half.y()),
               wz = static_cast<float>(half.z());
    const auto away = [](const Four& at, float from, float extent) {
        return ((at - from).abs() - extent).max(0.0F).square().eval();
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
    const float apart = static_cast<float>(wide), far_doubt = static_cast<float>(size) * head_coarseness;
    return !all_say_no(
        [&](const Head& head) {
            const Four reach = head.radius + apart;
            return positive(away(head.x, x, wx) + away(head.y, y, wy) + away(head.z, z, wz) -
                            reach.square() * (1 + head_coarseness) - far_doubt);
        },
        [&](const Row& row) {
            const Four distance = away(row.at_x, x, wx) + away(row.at_y, y, wy) + away(row.at_z, z, wz);
            const Four delta =
                row.with_delta * least_of(row.level) - (1 - row.with_delta) * row.level * square;
            return positive(row.level * (distance - doubt) - row.offset * (1 + coarseness) + delta - linear);
        });
}

}  // namespace vcell::whole
