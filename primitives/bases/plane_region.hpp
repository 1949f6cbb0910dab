// The part of a base plane that lies in the box, by exact arithmetic.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../objects/exact_motion.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"
#include "plane_base.hpp"
#include "solids.hpp"

namespace vcell {

/// A point (x / d, y / d), d > 0.
struct ExactPoint {
    Exact x, y, d;

    Eigen::Vector2d rounded() const {
        const Interval w = d.enclosure();
        return {(x.enclosure() / w).mid(), (y.enclosure() / w).mid()};
    }
};

/// The point of the base on two sides of the box, times a positive factor: exact in world coordinates.
struct WorldPoint {
    ExactVector p;
    Exact factor;
};

/// Of the sides' normals: positive where j is counter-clockwise from i.
Exact turn(const RegionSide& i, const RegionSide& j);
/// Value of a side at p, times p.d.
Exact value_at(const RegionSide& side, const ExactPoint& p);
/// Throws EmptyBox unless the base has a region of positive area in the box, or a face of the box is in it
/// and the box in front. Exact in world coordinates: a plane across the box has corners on both sides.
void check_base_cuts_box(const Plane& base, const Box& box);
/// The part of the canonical plane z = 0 in the box, its sides counter-clockwise: those that the base cuts in
/// a stretch, which is decided exactly in world coordinates. A plane that only grazes the box may lose its
/// last sliver when an oblique frame is rounded: that is EmptyBox, too.
std::vector<RegionSide> base_region(const Plane& base, const Box& world, const std::array<BoxSide, 6>& box);
/// A part of the canonical plane that holds the feet of all points in front of it in the box, and a margin,
/// but for sides of the box upright on it: these bound it exactly. Its other sides are none of the box.
std::vector<RegionSide> ray_region(const Plane& base, const Box& world, const std::array<BoxSide, 6>& box,
                                   const BaseFrame& frame);
/// The region with the sides that lean out over it moved out by so much, and none of the box any more: there
/// the base is as near as the side of the box, which bounds a cell above the base from there on.
std::vector<RegionSide> widened(const std::vector<RegionSide>& region, const std::array<BoxSide, 6>& box,
                                double margin);
/// Do rays come into the box from base points outside it? Exact, but for sides that are rounded to upright
/// ones: where the box has corners in front of the base on a side that leans over it.
bool has_rays_from_outside(const Plane& base, const Box& box, const std::array<BoxSide, 6>& sides);
/// Corner i is where side i begins.
std::vector<ExactPoint> region_corners(const std::vector<RegionSide>& region);
/// The sides of the box through the point of the base on two of them, exact in world coordinates: the
/// region's own sides are rounded, and where three run through one point no two of them tell of the third.
std::vector<Site> sides_through(const Plane& base, const Box& box, Site first, Site second);
/// The point of the base on two sides of the box, exact in world coordinates.
WorldPoint world_corner(const Plane& base, const Box& box, Site first, Site second);
/// On which side of the plane is the corner? Exact.
Sign side_of(const Plane& plane, const WorldPoint& corner);
/// Sign of the least of |a x (p - q)|^2 - (rho |a|)^2 over the base's region, q on the cylinder's axis. Exact
/// in world coordinates.
Sign lowest_in_world(const Cylinder& cylinder, const Plane& base, const Box& box,
                     std::span<const WorldPoint> corners);

/// The closed region of a plane base, and how objects lie to it, by exact signs. `sides` must outlive it.
class BaseRegion {
public:
    explicit BaseRegion(const std::vector<RegionSide>& sides)
        : sides_(sides), corners_(region_corners(sides)) {}

    const std::vector<ExactPoint>& corners() const { return corners_; }

    // Sign of r2 / p.d^2 - (squared distance of p from the closed region).
    Sign reach(const ExactPoint& p, const Exact& r2) const {
        bool inside = true;
        std::optional<Sign> best;
        const auto consider = [&](const Exact& excess) {
            const Sign s = excess.sign();
            if (!best || s > *best) best = s;
        };
        for (std::size_t i = 0; i < sides_.size(); ++i) {
            const RegionSide& side = sides_[i];
            const ExactPoint &from = corners_[i], &to = corners_[(i + 1) % sides_.size()];
            const Exact dx = p.x * from.d - from.x * p.d, dy = p.y * from.d - from.y * p.d;
            consider(r2 * from.d * from.d - dx * dx - dy * dy);
            const Exact value = value_at(side, p);
            if (value.sign() != Sign::Negative) continue;
            inside = false;
            // The foot on the line lies on the side when p is beyond `from` and short of `to`.
            const Exact ex = to.x * p.d - p.x * to.d, ey = to.y * p.d - p.y * to.d;
            if ((dx * side.b - dy * side.a).sign() == Sign::Positive &&
                (ex * side.b - ey * side.a).sign() == Sign::Positive)
                consider(r2 * (Exact(side.a) * side.a + Exact(side.b) * side.b) - value * value);
        }
        return inside ? r2.sign() : *best;
    }

    // Is the region inside the disk about p of squared radius r2 / p.d^2? It is convex, and corners tell.
    bool lies_in_disk(const ExactPoint& p, const Exact& r2) const {
        return std::ranges::all_of(corners_, [&](const ExactPoint& q) {
            const Exact dx = q.x * p.d - p.x * q.d, dy = q.y * p.d - p.y * q.d;
            return (r2 * q.d * q.d - dx * dx - dy * dy).sign() == Sign::Positive;
        });
    }

    // Is the region inside a cylinder's trace? Likewise, and so for a cone's, which is convex, too.
    bool lies_within(const CylinderTrace& trace) const {
        return std::ranges::all_of(
            corners_, [&](const ExactPoint& q) { return polar(trace, q, q).sign() == Sign::Negative; });
    }
    bool lies_in_cone(const CylinderTrace& trace) const {
        return std::ranges::all_of(corners_, [&](const ExactPoint& q) { return is_in_cone(trace, q); });
    }

    // Is a point of the region within a cone? The trace comes in through a side, between two places where it
    // is 0, or it is an ellipse inside, with its centre, unless a corner is within. From a corner beyond the
    // apex no line comes into the cone and out again.
    bool meets_cone(const CylinderTrace& trace) const {
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            const ExactPoint &p = corners_[i], &q = corners_[(i + 1) % corners_.size()];
            if (is_in_cone(trace, p)) return true;
            const Exact pp = polar(trace, p, p), pq = polar(trace, p, q), qq = polar(trace, q, q);
            if (pp.sign() == Sign::Negative || qq.sign() == Sign::Negative || pq.sign() != Sign::Negative)
                continue;
            const Exact of_p = qq - pq, of_q = pp - pq;
            if (is_in_cone(trace,
                           {of_p * p.x + of_q * q.x, of_p * p.y + of_q * q.y, of_p * p.d + of_q * q.d}))
                return true;
        }
        const auto bottom = bottom_inside(trace);
        return bottom && is_in_cone(trace, *bottom);
    }

    // Sign of the smallest value of trace - level over the closed region. The trace is convex: the minimum is
    // at the bottom of the paraboloid when that lies inside, else on a side.
    Sign lowest(CylinderTrace trace, const Exact& level) const {
        trace.c -= level;
        Sign best = Sign::Positive;
        const auto consider = [&](const Exact& value) { best = std::min(best, value.sign()); };
        if (const auto bottom = bottom_inside(trace)) consider(polar(trace, *bottom, *bottom));
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            // From corner p to corner q with s, t >= 0: the value at (s p + t q) times a positive factor
            // is pp s^2 + 2 pq s t + qq t^2, below the corners' values only where pq < 0.
            const ExactPoint &p = corners_[i], &q = corners_[(i + 1) % corners_.size()];
            const Exact pp = polar(trace, p, p), pq = polar(trace, p, q);
            consider(pp);
            if (pq.sign() == Sign::Negative) consider(pp * polar(trace, q, q) - pq * pq);
        }
        return best;
    }

    // Where a cylinder's trace is lowest over the region, rounded: for messages.
    Eigen::Vector2d lowest_point(const CylinderTrace& trace) const {
        if (const auto bottom = bottom_inside(trace)) return bottom->rounded();
        std::optional<Eigen::Vector2d> best;
        double least = 0;
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            const Eigen::Vector2d from = corners_[i].rounded();
            const Eigen::Vector2d along = corners_[(i + 1) % corners_.size()].rounded() - from;
            const Eigen::Matrix2d m{{nearest(trace.xx), nearest(trace.xy)},
                                    {nearest(trace.xy), nearest(trace.yy)}};
            const Eigen::Vector2d b(nearest(trace.x1), nearest(trace.y1));
            const double curvature = along.dot(m * along), slope = along.dot(m * from + b);
            const double t = slope >= 0 ? 0 : -slope >= curvature ? 1 : -slope / curvature;
            const Eigen::Vector2d q = from + t * along;
            const double value = q.dot(m * q + 2 * b);
            if (!best || value < least) {
                best = q;
                least = value;
            }
        }
        return *best;
    }

    // The point of the region nearest to p, rounded: for messages.
    Eigen::Vector2d nearest_point(const Eigen::Vector2d& p) const {
        std::optional<Eigen::Vector2d> best;
        bool inside = true;
        for (std::size_t i = 0; i < sides_.size(); ++i) {
            if (sides_[i].a * p.x() + sides_[i].b * p.y() + sides_[i].c < 0) inside = false;
            const Eigen::Vector2d from = corners_[i].rounded();
            const Eigen::Vector2d along = corners_[(i + 1) % sides_.size()].rounded() - from;
            const double t = std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
            const Eigen::Vector2d q = from + t * along;
            if (!best || (q - p).squaredNorm() < (*best - p).squaredNorm()) best = q;
        }
        return inside ? p : *best;
    }

private:
    // The symmetric bilinear form of a trace, on homogeneous points.
    static Exact polar(const CylinderTrace& f, const ExactPoint& p, const ExactPoint& q) {
        return f.xx * p.x * q.x + f.xy * (p.x * q.y + p.y * q.x) + f.yy * p.y * q.y +
               f.x1 * (p.x * q.d + p.d * q.x) + f.y1 * (p.y * q.d + p.d * q.y) + f.c * p.d * q.d;
    }

    static bool is_in_cone(const CylinderTrace& f, const ExactPoint& p) {
        return polar(f, p, p).sign() == Sign::Negative &&
               (f.ahead[0] * p.x + f.ahead[1] * p.y + f.ahead[2] * p.d).sign() == Sign::Positive;
    }

    // The centre of an ellipse, if that is in the region. Of a tube whose axis is parallel to the base the
    // trace is lowest along a line, which reaches the region's sides if it meets the region: none.
    std::optional<ExactPoint> bottom_inside(const CylinderTrace& f) const {
        const ExactPoint p{f.xy * f.y1 - f.yy * f.x1, f.xy * f.x1 - f.xx * f.y1, f.xx * f.yy - f.xy * f.xy};
        if (p.d.sign() != Sign::Positive) return std::nullopt;
        for (const RegionSide& side : sides_)
            if (value_at(side, p).sign() == Sign::Negative) return std::nullopt;
        return p;
    }

    const std::vector<RegionSide>& sides_;
    std::vector<ExactPoint> corners_;
};

}  // namespace vcell
