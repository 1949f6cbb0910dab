#include "plane_region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "../../core/errors.hpp"
#include "../objects/message.hpp"

namespace vcell {

Exact turn(const RegionSide& i, const RegionSide& j) { return Exact(i.a) * j.b - Exact(i.b) * j.a; }

Exact value_at(const RegionSide& side, const ExactPoint& p) {
    return side.a * p.x + side.b * p.y + side.c * p.d;
}

namespace {

using Kind = InputError::Kind;

// The crossing of two lines, by Cramer's rule. Pre: they are not parallel.
ExactPoint crossing(const RegionSide& i, const RegionSide& j) {
    ExactPoint p{Exact(i.b) * j.c - Exact(i.c) * j.b, Exact(i.c) * j.a - Exact(i.a) * j.c, turn(i, j)};
    if (p.d.sign() == Sign::Negative) p = {-p.x, -p.y, -p.d};
    return p;
}

// Does a stretch of line i, of positive length, bound the intersection of all half-planes?
// Along i's direction (b_i, -a_i), half-plane j begins (turn < 0) or ends (turn > 0) at the crossing with
// line j; the stretch exists when every beginning comes strictly before every end, that is, lies
// strictly inside the half-plane that ends there.
bool contributes(const std::vector<RegionSide>& lines, std::size_t i) {
    std::vector<std::size_t> begins, ends;
    for (std::size_t j = 0; j < lines.size(); ++j) {
        if (j == i) continue;
        const Sign t = turn(lines[i], lines[j]).sign();
        if (t == Sign::Negative) begins.push_back(j);
        if (t == Sign::Positive) ends.push_back(j);
        if (t != Sign::Zero) continue;
        // n_j = lambda n_i: on line i, half-plane j has the value c_j - lambda c_i.
        const bool use_a = lines[i].a != 0;
        const double ni = use_a ? lines[i].a : lines[i].b, nj = use_a ? lines[j].a : lines[j].b;
        const Sign value = (Exact(lines[j].c) * ni - Exact(lines[i].c) * nj).sign() * sign_of(ni);
        const bool same_direction = (ni > 0) == (nj > 0);
        // Of lines that coincide the first one stands for all.
        const bool inside = value == Sign::Positive || (value == Sign::Zero && same_direction && i < j);
        if (!inside) return false;
    }
    for (const std::size_t j : begins) {
        const ExactPoint p = crossing(lines[i], lines[j]);
        for (const std::size_t k : ends)
            if (value_at(lines[k], p).sign() != Sign::Positive) return false;
    }
    return !begins.empty() && !ends.empty();
}

// Order of the sides' directions (b, -a) by angle in [0, 2 pi), exact.
bool before_by_angle(const RegionSide& i, const RegionSide& j) {
    const auto lower_half = [](const RegionSide& s) { return -s.a < 0 || (s.a == 0 && s.b < 0); };
    if (lower_half(i) != lower_half(j)) return lower_half(j);
    return turn(i, j).sign() == Sign::Positive;
}

std::vector<RegionSide> bounded_by(const std::vector<RegionSide>& lines) {
    std::vector<RegionSide> region;
    for (std::size_t i = 0; i < lines.size(); ++i)
        if (contributes(lines, i)) region.push_back(lines[i]);
    if (region.empty()) fail_empty("meets the base plane (base.plane) in a region too small for doubles");
    std::sort(region.begin(), region.end(), before_by_angle);
    return region;
}

// Times the normal's length.
Exact height_of_corner(const Plane& base, const Box& box, unsigned corner) {
    Exact height;
    for (unsigned i = 0; i < 3; ++i)
        height += base.normal[i] * (Exact((corner >> i & 1u) != 0 ? box.max[i] : box.min[i]) - base.point[i]);
    return height;
}

// Signs of the corners on a side of the box, and which corners those are.
struct SideCorners {
    std::array<unsigned, 4> corners;
    std::array<Sign, 4> signs;

    SideCorners(const Plane& base, const Box& box, unsigned side) {
        std::size_t next = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            if ((corner >> (side / 2) & 1u) != side % 2) continue;
            corners[next] = corner;
            signs[next++] = height_of_corner(base, box, corner).sign();
        }
    }
    auto count(Sign sign) const { return std::ranges::count(signs, sign); }
};

// Does the base cut the side of the box in a stretch? One that it touches in a corner bounds nothing, and of
// two that meet in an edge of the box on the base the first one stands for both: sides that are rounded would
// have stretches of the length of their rounding there.
bool bounds_region(const Plane& base, const Box& box, unsigned side) {
    const SideCorners here(base, box, side);
    if (here.count(Sign::Positive) > 0 && here.count(Sign::Negative) > 0) return true;
    if (here.count(Sign::Zero) != 2) return false;
    unsigned all = 7, any = 0;  // bits that both corners on the base have, and that one of them has
    for (std::size_t k = 0; k < 4; ++k)
        if (here.signs[k] == Sign::Zero) {
            all &= here.corners[k];
            any |= here.corners[k];
        }
    const unsigned along = any & ~all;
    for (unsigned axis = 0; axis < 3; ++axis) {
        if (axis == side / 2 || (along >> axis & 1u) != 0) continue;
        const unsigned beside = 2 * axis + (all >> axis & 1u);
        // A side on the base is no line over it.
        if (SideCorners(base, box, beside).count(Sign::Zero) != 4) return side < beside;
    }
    return true;
}

double place_of(const Box& box, Site side) {
    return (side.index % 2 == 0 ? box.min : box.max)[side.index / 2];
}

}  // namespace

void check_base_cuts_box(const Plane& base, const Box& box) {
    int in_front = 0, behind = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const Sign height = height_of_corner(base, box, corner).sign();
        if (height == Sign::Positive) ++in_front;
        if (height == Sign::Negative) ++behind;
    }
    if (in_front > 0 && behind > 0) return;
    const int on_plane = 8 - in_front - behind;
    if (on_plane == 4 && in_front == 4) return;
    if (on_plane == 4) fail_empty("lies behind the base plane (base.plane), which it only touches");
    if (on_plane > 0) fail_empty("meets the base plane (base.plane) in no more than a point or an edge");
    fail_empty("does not meet the base plane (base.plane)");
}

std::vector<RegionSide> base_region(const Plane& base, const Box& world, const std::array<BoxSide, 6>& box) {
    // Where the lean of a side was taken for noise, the scene's corners do not tell where the sides are.
    const bool is_noisy =
        (base.normal.array() != 0).count() > 1 &&
        std::ranges::any_of(box, [](const BoxSide& side) { return side.m.x() == 0 && side.m.y() == 0; });
    std::vector<RegionSide> lines;
    bool empty = false;
    for (const BoxSide& side : box) {
        if (side.m.x() != 0 || side.m.y() != 0) {
            if (!is_noisy && !bounds_region(base, world, side.index)) continue;
            lines.push_back({-side.m.x(), -side.m.y(), side.k, Site::box_side(side.index)});
        } else if (side.k < 0 || (side.k == 0 && side.m.z() > 0))
            empty = true;
    }
    if (empty) lines.clear();
    return bounded_by(lines);
}

std::vector<RegionSide> widened(const std::vector<RegionSide>& region, const std::array<BoxSide, 6>& box,
                                double margin) {
    std::vector<RegionSide> lines = region;
    for (RegionSide& side : lines) {
        if (!(box[side.site.index].m.z() > 0)) continue;
        side.c += margin * std::hypot(side.a, side.b);
        side.site = Site::base();
    }
    return bounded_by(lines);
}

bool has_rays_from_outside(const Plane& base, const Box& box, const std::array<BoxSide, 6>& sides) {
    for (const BoxSide& side : sides) {
        if (!(side.m.z() < 0) || (side.m.x() == 0 && side.m.y() == 0)) continue;
        for (unsigned corner = 0; corner < 8; ++corner) {
            if ((corner >> (side.index / 2) & 1u) != side.index % 2) continue;
            if (height_of_corner(base, box, corner).sign() == Sign::Positive) return true;
        }
    }
    return false;
}

std::vector<RegionSide> ray_region(const Plane& base, const Box& world, const std::array<BoxSide, 6>& box,
                                   const BaseFrame& frame) {
    using Eigen::Vector2d;
    // Where edges of the box meet the base, and the feet of corners before it.
    const double diagonal = world.diagonal(), margin = 0x1p-10 * diagonal;
    std::vector<Vector2d> points;
    for (const ExactPoint& corner : region_corners(base_region(base, world, box)))
        points.push_back(corner.rounded());
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (unsigned axis = 0; axis < 3; ++axis)
            p[axis] = ((corner >> axis & 1u) != 0 ? world.max : world.min)[axis];
        p = frame.to_canonical(p);
        if (p.z() > 0) points.push_back(p.head<2>());
    }
    std::vector<RegionSide> lines;
    for (const BoxSide& side : box)
        if (side.m.z() == 0) lines.push_back({-side.m.x(), -side.m.y(), side.k, Site::box_side(side.index)});
    // Of a hull any lines do that are far enough out: those through two points with all others on one side.
    for (const Vector2d& p : points)
        for (const Vector2d& q : points) {
            const Vector2d along = q - p;
            if (!(along.norm() > margin)) continue;
            const Vector2d inwards = Vector2d(-along.y(), along.x()).normalized();
            double least = 0;
            for (const Vector2d& r : points) least = std::min(least, inwards.dot(r - p));
            // Points on one line tell it several times.
            constexpr double parallel = 0x1p-20;
            const auto is_known = [&](const RegionSide& side) {
                const Vector2d other(side.a, side.b);
                return side.site == Site::base() && (other - inwards).norm() < parallel;
            };
            if (least > -0.5 * margin && std::ranges::none_of(lines, is_known))
                lines.push_back({inwards.x(), inwards.y(), margin - inwards.dot(p), Site::base()});
        }
    return bounded_by(lines);
}

std::vector<ExactPoint> region_corners(const std::vector<RegionSide>& region) {
    std::vector<ExactPoint> corners;
    for (std::size_t i = 0; i < region.size(); ++i)
        corners.push_back(crossing(region[(i + region.size() - 1) % region.size()], region[i]));
    return corners;
}

std::vector<Site> sides_through(const Plane& base, const Box& box, Site first, Site second) {
    const std::uint32_t i = first.index / 2, j = second.index / 2, k = 3 - i - j;
    std::vector<Site> sides{first, second};
    if (base.normal[i] == 0 && base.normal[j] == 0) return sides;  // the third one is along the base
    const Exact across = base.normal[i] * (Exact(place_of(box, first)) - base.point[i]) +
                         base.normal[j] * (Exact(place_of(box, second)) - base.point[j]);
    for (const std::uint32_t index : {2 * k, 2 * k + 1}) {
        const Site third = Site::box_side(index);
        const Exact height = across + base.normal[k] * (Exact(place_of(box, third)) - base.point[k]);
        if (height.sign() == Sign::Zero) sides.push_back(third);
    }
    return sides;
}

WorldPoint world_corner(const Plane& base, const Box& box, Site first, Site second) {
    const std::uint32_t i = first.index / 2, j = second.index / 2, k = 3 - i - j;
    const Exact turn(base.normal[k] < 0 ? -1.0 : 1.0), n = turn * base.normal[k];
    std::array<Exact, 3> p;
    p[k] = n * Exact(base.point[k]);
    for (const Site side : {first, second}) {
        const std::uint32_t axis = side.index / 2;
        const Exact place(place_of(box, side));
        p[axis] = n * place;
        p[k] -= turn * base.normal[axis] * (place - base.point[axis]);
    }
    return {{p[0], p[1], p[2]}, n};
}

Sign side_of(const Plane& plane, const WorldPoint& corner) {
    const ExactVector n(plane.normal);
    return (dot(n, corner.p) - corner.factor * dot(n, ExactVector(plane.point))).sign();
}

// It is convex: least where the axis meets the base, if that is inside, or else on a side.
Sign lowest_in_world(const Cylinder& cylinder, const Plane& base, const Box& box,
                     std::span<const WorldPoint> corners) {
    const ExactVector a(cylinder.axis), q(cylinder.point), n(base.normal), b(base.point);
    const Exact square = Exact(cylinder.radius) * cylinder.radius * dot(a, a);
    Sign best = Sign::Positive;
    const auto consider = [&](const Exact& value) { best = std::min(best, value.sign()); };
    if (const Exact slope = dot(n, a); slope.sign() != Sign::Zero) {
        // q + t a with t = n.(b - q) / n.a.
        const Exact along = dot(n, b - q);
        const Exact turn(slope.sign() == Sign::Negative ? -1.0 : 1.0);
        const ExactVector from_q = along * a;
        const std::array<Exact, 3> at{from_q.x, from_q.y, from_q.z};
        bool is_inside = true;
        for (int axis = 0; axis < 3; ++axis)
            for (const double bound : {box.min[axis], box.max[axis]}) {
                const Exact beyond = turn * (at[axis] - slope * (Exact(bound) - cylinder.point[axis]));
                is_inside = is_inside && (bound == box.min[axis] ? beyond : -beyond).sign() != Sign::Negative;
            }
        if (is_inside) consider(-square);
    }
    const auto polar = [&](const WorldPoint& p, const WorldPoint& r) {
        return dot(cross(a, p.p - p.factor * q), cross(a, r.p - r.factor * q)) - square * p.factor * r.factor;
    };
    for (std::size_t i = 0; i < corners.size(); ++i) {
        // As in BaseRegion::lowest().
        const WorldPoint &p = corners[i], &r = corners[(i + 1) % corners.size()];
        const Exact pp = polar(p, p), pr = polar(p, r);
        consider(pp);
        if (pr.sign() == Sign::Negative) consider(pp * polar(r, r) - pr * pr);
    }
    return best;
}

}  // namespace vcell
