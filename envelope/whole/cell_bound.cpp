#include "cell_bound.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace vcell::whole {

namespace {

// No sum or product of doubles below is off by more than this part of the terms in it, and none of floats by
// more than the coarse one.
constexpr double bound_rounding = 0x1p-46;
constexpr float coarse = 0x1p-18F;
constexpr float infinity = std::numeric_limits<float>::infinity();

}  // namespace

CellBound::Level::Level(int count) {
    // Sectors of equal angles, seen from the centre of the cube.
    const auto tangent = [&](double place) {
        return std::tan(0.25 * std::numbers::pi * (2 * place / count - 1));
    };
    double least = 1;  // cosine
    const int halvings = std::countr_zero(static_cast<unsigned>(count / along));
    for (int k = 0; k < 6 * count * count; ++k) {
        const int whole = k >> (2 * halvings), face = whole / (along * along);
        int i = whole / along % along, j = whole % along;
        for (int h = halvings - 1; h >= 0; --h) {
            i = 2 * i + (k >> (2 * h + 1) & 1);
            j = 2 * j + (k >> (2 * h) & 1);
        }
        const auto at = [&](double s, double t) {
            Vec3 p;
            p[face / 2] = face % 2 == 0 ? -1 : 1;
            p[(face / 2 + 1) % 3] = tangent(i + s);
            p[(face / 2 + 2) % 3] = tangent(j + t);
            return Vec3(p.normalized());
        };
        const Vec3 axis = at(0.5, 0.5);
        x.push_back(static_cast<float>(axis.x()));
        y.push_back(static_cast<float>(axis.y()));
        z.push_back(static_cast<float>(axis.z()));
        // Its corners are the farthest points of a convex sector.
        for (const double s : {0.0, 1.0})
            for (const double t : {0.0, 1.0}) least = std::min(least, axis.dot(at(s, t)));
    }
    least -= bound_rounding;
    cosine = static_cast<float>(least);
    sine = static_cast<float>(std::sqrt(1 - least * least) + bound_rounding);
    chord = std::sqrt(2 * (1 - least)) + bound_rounding;
}

const std::array<CellBound::Level, CellBound::levels>& CellBound::table() {
    static const std::array table{Level(along), Level(2 * along), Level(4 * along), Level(8 * along)};
    return table;
}

CellBound::CellBound(const Sphere& base) : base_(base), size_(base.center.cwiseAbs().sum() + base.radius) {}

void CellBound::add(const Sphere& ball) {
    const Vec3 c = ball.center - base_.center;
    const double delta = ball.radius - base_.radius, square = c.squaredNorm(), size = std::sqrt(square);
    // What is lost where coordinates are subtracted counts, too.
    const double lost = bound_rounding * (ball.center.cwiseAbs().sum() + ball.radius + size_);
    const double C = std::max(0.0, square - delta * delta) + bound_rounding * (square + delta * delta) +
                     2 * lost * (size + std::abs(delta)) + lost * lost;
    competitors_.push_back({c, size, delta - 2 * lost - bound_rounding * (size + std::abs(delta)), C});
}

void CellBound::add(const Box& box) {
    // A side that is nearer than that, or that the centre lies on or beyond, would give a float no bound; so
    // it is taken to be as far away. Beyond it there is nothing of the cell to be bounded.
    constexpr double least = 0x1p-20;  // of the box's edge
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            const double bound = sign < 0 ? box.min[axis] : box.max[axis];
            const double far =
                std::max(sign * (bound - base_.center[axis]), least * (box.max[axis] - box.min[axis])) +
                bound_rounding * (std::abs(bound) + std::abs(base_.center[axis]));
            // A side is met as a mirrored base would be, which has the base's radius and twice the distance.
            const double size = 2 * far, square = size * size;
            competitors_.push_back({sign * size * Vec3::Unit(axis), size, -bound_rounding * size,
                                    square * (1 + bound_rounding)});
        }
}

void CellBound::add_cap(double clearance) {
    least_reciprocal_ = (1 - bound_rounding) / (base_.radius + clearance);
}

void CellBound::set_bounds() {
    // The size of the largest competitor: none is so far that its square would overflow.
    unit_ = base_.radius;
    for (const Competitor& o : competitors_) unit_ = std::max(unit_, o.size);
    if (least_reciprocal_ > 0) unit_ = std::max(unit_, 1 / least_reciprocal_);
    bounds_.clear();
    for (const Competitor& o : competitors_) {
        const double size = o.size / unit_, delta = o.delta / unit_, C = o.C / (unit_ * unit_);
        // Of what is nearer than that a float's quotient would be none; without it the bound is weaker.
        constexpr double least_C = 0x1p-100;
        if (!(C > least_C)) continue;
        const Vec3 c = o.c / unit_;
        bounds_.push_back({static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()),
                           static_cast<float>(size * size), static_cast<float>(size),
                           static_cast<float>(delta - coarse * (size + std::abs(delta))),
                           static_cast<float>(2 / C * (1 - coarse))});
    }
}

// T of sectors that follow each other: the least of its bounds, as the greatest of their reciprocals, which
// are negative where there is none.
template <int count>
CellBound::Row<count> CellBound::farthest(const Level& level, std::size_t first) const {
    using Sectors = Row<count>;
    const Eigen::Map<const Sectors> x(level.x.data() + first), y(level.y.data() + first),
        z(level.z.data() + first);
    Sectors nearest = Sectors::Constant(static_cast<float>(least_reciprocal_ * unit_ * (1 - coarse)));
    for (const Bound& o : bounds_) {
        // In a sector with the direction from c in it the angle from c to its farthest direction is no longer
        // greater than all others, and the cosine's bound none. Of all balls but those that nearly hold the
        // base it is negative there.
        if (o.delta > level.cosine * o.size) continue;
        const Sectors m = o.x * x + o.y * y + o.z * z;
        const Sectors across = ((o.square - m.square()).max(0.0F) + coarse * o.square).sqrt();
        nearest = nearest.max((level.cosine * m - level.sine * across + o.delta) * o.factor);
    }
    return (1 + coarse) / nearest;
}

// More than a length in floats that were computed of terms of that size.
double CellBound::rounded_up(double length, double terms) const {
    return length / unit_ + coarse * (terms / unit_) + bound_rounding * (size_ / unit_);
}

Eigen::Vector4f CellBound::ball(const Level& level, std::size_t k, double t) const {
    if (!std::isfinite(t)) return {0, 0, 0, infinity};
    const double radius = rounded_up(unit_ * t * (1 + level.chord) - base_.radius, unit_ * t + base_.radius);
    return {static_cast<float>(t * level.x[k]), static_cast<float>(t * level.y[k]),
            static_cast<float>(t * level.z[k]), static_cast<float>(radius)};
}

void CellBound::settle(double width) {
    set_bounds();
    const Level& level = table().front();
    parts_.clear();
    const Row<sector_count> t = farthest<sector_count>(level, 0);
    for (int k = 0; k < sector_count; ++k) {
        sectors_.set(k, ball(level, k, t[k]));
        begin_[k] = static_cast<std::uint32_t>(parts_.size());
        last_four_ = 4;
        if (t[k] * level.chord > width / unit_) divide(1, k, width / unit_);
    }
    begin_[sector_count] = static_cast<std::uint32_t>(parts_.size());
    set_faces();
    const double most = unit_ * t.maxCoeff();
    reach_ = 2 * (most - base_.radius) + bound_rounding * (most + size_);
}

void CellBound::divide(int at, std::size_t sector, double width) {
    const Level& level = table()[at];
    const Row<4> t = farthest<4>(level, 4 * sector);
    for (int k = 0; k < 4; ++k) {
        const std::size_t part = 4 * sector + k;
        if (at + 1 < levels && t[k] * level.chord > width) {
            divide(at + 1, part, width);
            continue;
        }
        if (last_four_ == 4) {
            // What is not set is out of reach.
            parts_.push_back(
                {Row<4>::Constant(infinity), Row<4>::Zero(), Row<4>::Zero(), Row<4>::Constant(-infinity)});
            last_four_ = 0;
        }
        parts_.back().set(last_four_++, ball(level, part, t[k]));
    }
}

template <class Apart>
bool CellBound::any_part(int k, Apart&& apart) const {
    if (begin_[k] == begin_[k + 1]) return true;
    for (std::uint32_t i = begin_[k]; i < begin_[k + 1]; ++i) {
        const Balls<4>& four = parts_[i];
        if (apart(four.x, four.y, four.z, four.radius).minCoeff() <= 0) return true;
    }
    return false;
}

void CellBound::set_faces() {
    for (int f = 0; f < 6; ++f) {
        const auto x = sectors_.x.segment<of_face>(of_face * f), y = sectors_.y.segment<of_face>(of_face * f),
                   z = sectors_.z.segment<of_face>(of_face * f),
                   radius = sectors_.radius.segment<of_face>(of_face * f);
        const Eigen::Array3f middle(x.mean(), y.mean(), z.mean());
        const float most =
            (((x - middle.x()).square() + (y - middle.y()).square() + (z - middle.z()).square()).sqrt() +
             radius.max(0.0F))
                .maxCoeff();
        faces_.set(f,
                   {middle.x(), middle.y(), middle.z(), most * (1 + coarse) + coarse * middle.abs().sum()});
    }
}

double CellBound::extent(double radius) const {
    const auto most =
        ((faces_.x.square() + faces_.y.square() + faces_.z.square()).sqrt() + faces_.radius).maxCoeff();
    // A ball's place gives way by `coarse` of its distance along three axes, and of its radius.
    return unit_ * most * (1 + 8 * coarse) + 8 * coarse * radius + 8 * bound_rounding * size_;
}

CellBound::Place CellBound::place(const Vec3& center, double radius, double extent) const {
    const Vec3 c = (center - base_.center) / unit_;
    const double terms = unit_ * c.cwiseAbs().sum() + radius + extent;
    return {c.array().cast<float>(),
            static_cast<float>(rounded_up(radius + bound_rounding * center.cwiseAbs().sum(), terms))};
}

template <class Apart>
bool CellBound::any(Apart&& apart) const {
    const Row<6> of_faces = apart(faces_.x, faces_.y, faces_.z, faces_.radius);
    for (int f = 0; f < 6; ++f) {
        if (!(of_faces[f] <= 0)) continue;
        const int first = of_face * f;
        const Row<of_face> values =
            apart(sectors_.x.segment<of_face>(first), sectors_.y.segment<of_face>(first),
                  sectors_.z.segment<of_face>(first), sectors_.radius.segment<of_face>(first));
        if (!(values.minCoeff() <= 0)) continue;
        for (int k = 0; k < of_face; ++k)
            if (values[k] <= 0 && any_part(first + k, apart)) return true;
    }
    return false;
}

bool CellBound::may_touch(const Sphere& ball) const {
    const Place at = place(ball.center, ball.radius, 0);
    if (!at.is_near()) return true;
    return any([&](const auto& x, const auto& y, const auto& z, const auto& reach) {
        return ((x - at.center.x()).square() + (y - at.center.y()).square() + (z - at.center.z()).square() -
                (reach + at.radius).max(0.0F).square())
            .eval();
    });
}

bool CellBound::may_touch(const Box& centers, double radius) const {
    const Vec3 middle = 0.5 * (centers.min + centers.max), half = centers.max - middle;
    // Twice the roundings that a ball in the box is granted, and the box's own.
    Place at = place(middle, radius, half.sum());
    at.radius = static_cast<float>(
        rounded_up(unit_ * at.radius, 2 * (middle - base_.center).cwiseAbs().sum() + radius + half.sum()));
    const Eigen::Array3f wide = (half / unit_).array().cast<float>();
    if (!at.is_near(wide.sum())) return true;
    const auto squared = [](const auto& x, float center, float extent) {
        return ((x - center).abs() - extent).max(0.0F).square();
    };
    return any([&](const auto& x, const auto& y, const auto& z, const auto& reach) {
        return (squared(x, at.center.x(), wide.x()) + squared(y, at.center.y(), wide.y()) +
                squared(z, at.center.z(), wide.z()) - (reach + at.radius).max(0.0F).square())
            .eval();
    });
}

}  // namespace vcell::whole
