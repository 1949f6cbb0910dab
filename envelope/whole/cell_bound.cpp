#include "cell_bound.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace vcell::whole {

namespace {

// No sum or product below is off by more than this part of the terms in it.
constexpr double rounding = 0x1p-46;
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

CellBound::Level::Level(int count) {
    // Sectors of equal angles, seen from the centre of the cube.
    const auto tangent = [&](double place) {
        return std::tan(0.25 * std::numbers::pi * (2 * place / count - 1));
    };
    double least = 1;
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
        x.push_back(axis.x());
        y.push_back(axis.y());
        z.push_back(axis.z());
        // Its corners are the farthest points of a convex sector.
        for (const double s : {0.0, 1.0})
            for (const double t : {0.0, 1.0}) least = std::min(least, axis.dot(at(s, t)));
    }
    cosine = least - rounding;
    sine = std::sqrt(1 - cosine * cosine) + rounding;
    chord = std::sqrt(2 * (1 - cosine)) + rounding;
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
    const double lost = rounding * (ball.center.cwiseAbs().sum() + ball.radius + size_);
    const double C = std::max(0.0, square - delta * delta) + rounding * (square + delta * delta) +
                     2 * lost * (size + std::abs(delta)) + lost * lost;
    competitors_.push_back({c, square, size, delta - 2 * lost - rounding * (size + std::abs(delta)), C});
}

void CellBound::add(const Box& box) {
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            const double bound = sign < 0 ? box.min[axis] : box.max[axis];
            const double far = std::abs(bound - base_.center[axis]) +
                               rounding * (std::abs(bound) + std::abs(base_.center[axis]));
            // A side is met as a mirrored base would be, which has the base's radius and twice the distance.
            const double size = 2 * far, square = size * size;
            competitors_.push_back(
                {sign * size * Vec3::Unit(axis), square, size, -rounding * size, square * (1 + rounding)});
        }
}

// T of sectors that follow each other: the least of its bounds, as the greatest of their reciprocals, which
// are negative where there is none.
template <int count>
Eigen::Array<double, count, 1> CellBound::farthest(const Level& level, std::size_t first) const {
    using Sectors = Eigen::Array<double, count, 1>;
    const Eigen::Map<const Sectors> x(level.x.data() + first), y(level.y.data() + first),
        z(level.z.data() + first);
    Sectors nearest = Sectors::Zero();
    for (const Competitor& o : competitors_) {
        // In a sector with the direction from c in it the angle from c to its farthest direction is no longer
        // greater than all others, and the cosine's bound none. Of all balls but those that nearly hold the
        // base it is negative there.
        if (o.delta > level.cosine * o.size) continue;
        const Sectors m = o.c.x() * x + o.c.y() * y + o.c.z() * z;
        const Sectors across = ((o.square - m.square()).max(0.0) + rounding * o.square).sqrt();
        nearest = nearest.max((level.cosine * m - level.sine * across + o.delta) * (2 / o.C));
    }
    return (1 + rounding) / nearest;
}

CellBound::Part CellBound::part(const Level& level, std::size_t k, double t) const {
    const Vec3 center = base_.center + t * Vec3(level.x[k], level.y[k], level.z[k]);
    return {center, t - base_.radius + t * level.chord + rounding * (t + size_)};
}

void CellBound::settle(double width) {
    const Level& level = table().front();
    parts_.clear();
    const Eigen::Array<double, sector_count, 1> t = farthest<sector_count>(level, 0);
    for (std::size_t k = 0; k < sector_count; ++k) {
        const Part whole = part(level, k, t[k]);
        sectors_.x[k] = whole.center.x();
        sectors_.y[k] = whole.center.y();
        sectors_.z[k] = whole.center.z();
        sectors_.radius[k] = whole.radius;
        begin_[k] = static_cast<std::uint32_t>(parts_.size());
        if (t[k] * level.chord > width) divide(1, k, width);
    }
    begin_[sector_count] = static_cast<std::uint32_t>(parts_.size());
    set_faces();
    const double most = t.maxCoeff();
    reach_ = 2 * (most - base_.radius) + rounding * (most + size_);
}

void CellBound::divide(int at, std::size_t sector, double width) {
    const Level& level = table()[at];
    const Eigen::Array4d t = farthest<4>(level, 4 * sector);
    for (std::size_t k = 0; k < 4; ++k) {
        if (at + 1 < levels && t[k] * level.chord > width)
            divide(at + 1, 4 * sector + k, width);
        else
            parts_.push_back(part(level, 4 * sector + k, t[k]));
    }
}

bool CellBound::touches_part(int k, const Vec3& center, double radius) const {
    if (begin_[k] == begin_[k + 1]) return true;
    for (std::uint32_t i = begin_[k]; i < begin_[k + 1]; ++i) {
        const double reach = parts_[i].radius + radius;
        if (reach > 0 && (parts_[i].center - center).squaredNorm() < reach * reach) return true;
    }
    return false;
}

void CellBound::set_faces() {
    for (int f = 0; f < 6; ++f) {
        const auto x = sectors_.x.segment<of_face>(of_face * f), y = sectors_.y.segment<of_face>(of_face * f),
                   z = sectors_.z.segment<of_face>(of_face * f),
                   radius = sectors_.radius.segment<of_face>(of_face * f);
        faces_.x[f] = x.mean();
        faces_.y[f] = y.mean();
        faces_.z[f] = z.mean();
        const double most =
            (((x - faces_.x[f]).square() + (y - faces_.y[f]).square() + (z - faces_.z[f]).square()).sqrt() +
             radius.max(0.0))
                .maxCoeff();
        faces_.radius[f] = most * (1 + rounding) + rounding * size_;
    }
}

template <class Apart, class Visit>
bool CellBound::any_face(Apart&& apart, Visit&& visit) const {
    const Eigen::Array<double, 6, 1> of_faces = apart(faces_.x, faces_.y, faces_.z, faces_.radius);
    for (int f = 0; f < 6; ++f) {
        if (!(of_faces[f] < 0)) continue;
        const Eigen::Array<double, of_face, 1> values =
            apart(sectors_.x.segment<of_face>(of_face * f), sectors_.y.segment<of_face>(of_face * f),
                  sectors_.z.segment<of_face>(of_face * f), sectors_.radius.segment<of_face>(of_face * f));
        if (values.minCoeff() < 0 && visit(f, values)) return true;
    }
    return false;
}

bool CellBound::may_touch(const Sphere& ball) const {
    const Vec3& c = ball.center;
    const double radius = ball.radius + rounding * (c.cwiseAbs().sum() + ball.radius + size_);
    const auto apart = [&](const auto& x, const auto& y, const auto& z, const auto& reach) {
        return ((x - c.x()).square() + (y - c.y()).square() + (z - c.z()).square() -
                (reach + radius).max(0.0).square())
            .eval();
    };
    return any_face(apart, [&](int face, const Eigen::Array<double, of_face, 1>& values) {
        for (int k = 0; k < of_face; ++k)
            if (values[k] < 0 && touches_part(of_face * face + k, c, radius)) return true;
        return false;
    });
}

bool CellBound::may_touch(const Box& centers, double radius) const {
    const Vec3 c = 0.5 * (centers.min + centers.max), half = centers.max - c;
    const double grown = radius + rounding * (c.cwiseAbs().sum() + half.sum() + radius + size_);
    const auto squared = [](const auto& at, double middle, double wide) {
        return ((at - middle).abs() - wide).max(0.0).square();
    };
    const auto apart = [&](const auto& x, const auto& y, const auto& z, const auto& reach) {
        return (squared(x, c.x(), half.x()) + squared(y, c.y(), half.y()) + squared(z, c.z(), half.z()) -
                (reach + grown).max(0.0).square())
            .eval();
    };
    return any_face(apart, [](int, const auto&) { return true; });
}

}  // namespace vcell::whole
