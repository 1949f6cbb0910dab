#include "clearances.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

#include "forms.hpp"
#include "tips.hpp"

namespace vcell::check {

namespace {

using Control = Eigen::Vector4d;

/// A part of an edge by its homogeneous control points, in the frame.
struct EdgeStretch {
    SmallVector<Control, 6> points;
    std::array<double, 2> range;  ///< of the heights along it
    double bound;                 ///< of the heights, from the side that is asked for

    friend bool operator<(const EdgeStretch& a, const EdgeStretch& b) { return a.bound < b.bound; }
};

/// How the clearances of points, and of parts, are told over a base.
class Heights {
public:
    Heights(const Scene& scene, const Frame& frame)
        : is_plane_(std::holds_alternative<Plane>(scene.base)),
          is_sphere_(std::holds_alternative<Sphere>(scene.base)),
          radius_(frame.radius().mid()) {}

    double at(const Vec3& p) const {
        return is_plane_ ? p.z() : (is_sphere_ ? p.norm() : p.head<2>().norm()) - radius_;
    }
    /// A height over a plane, or a squared distance, is a quotient of polynomials of which the denominator's
    /// Bernstein coefficients are positive: it lies between the least and the greatest quotient of
    /// coefficients. On a circle about the centre or the axis they are all the same.
    std::array<double, 2> range(const EdgeStretch& part) const {
        std::array<double, 2> bounds{HUGE_VAL, -HUGE_VAL};
        const auto meet = [&](double h) { bounds = {std::min(bounds[0], h), std::max(bounds[1], h)}; };
        if (is_plane_) {
            for (const Control& c : part.points) meet(c[2] / c[3]);
            return bounds;
        }
        // Binomials of the squares' degree are the same above and below.
        const std::size_t d = part.points.size() - 1;
        SmallVector<Control, 6> scaled = part.points;
        for (std::size_t i = 1; i < d; ++i) scaled[i] *= binomial(static_cast<int>(d), static_cast<int>(i));
        for (std::size_t k = 0; k <= 2 * d; ++k) {
            double square = 0, weight = 0;
            for (std::size_t i = k > d ? k - d : 0; 2 * i <= k; ++i) {
                const Control &a = scaled[i], &b = scaled[k - i];
                const double times = 2 * i == k ? 1 : 2;
                square += times * (a.x() * b.x() + a.y() * b.y() + (is_sphere_ ? a.z() * b.z() : 0));
                weight += times * (a[3] * b[3]);
            }
            meet(square / weight);
        }
        return {std::sqrt(std::max(0.0, bounds[0])) - radius_, std::sqrt(std::max(0.0, bounds[1])) - radius_};
    }

private:
    bool is_plane_, is_sphere_;
    double radius_;
};

Control at(const EdgeStretch& part, double t) {
    SmallVector<Control, 6> level = part.points;
    for (std::size_t d = level.size() - 1; d > 0; --d)
        for (std::size_t j = 0; j < d; ++j) level[j] = (1 - t) * level[j] + t * level[j + 1];
    return level[0];
}

/// Cut where the parabola through three heights is highest or lowest: beside the true place quotients of
/// coefficients are monotonic, and the bound is attained.
std::array<EdgeStretch, 2> cut(const EdgeStretch& part, const Heights& heights) {
    const auto height = [&](const Control& c) { return heights.at(c.head<3>() / c[3]); };
    const double first = height(part.points.front()), middle = height(at(part, 0.5)),
                 last = height(part.points.back());
    const double bend = first - 2 * middle + last, place = 0.5 + 0.25 * (first - last) / bend;
    const double t = place > 0x1p-4 && place < 1 - 0x1p-4 ? place : 0.5;
    std::array<EdgeStretch, 2> result{part, part};
    SmallVector<Control, 6> level = part.points;
    const std::size_t d = level.size() - 1;
    for (std::size_t i = 0; i <= d; ++i) {
        result[0].points[i] = level[0];
        result[1].points[d - i] = level[d - i];
        for (std::size_t j = 0; j < d - i; ++j) level[j] = (1 - t) * level[j] + t * level[j + 1];
    }
    return result;
}

/// The greatest of sign times the height along all parts, up to `enough`. Pre: their ranges are known.
Interval greatest(std::vector<EdgeStretch> parts, const Heights& heights, double sign, double enough) {
    const auto bound = [&](EdgeStretch& part) { part.bound = sign > 0 ? part.range[1] : -part.range[0]; };
    double attained = -HUGE_VAL;
    const auto meet = [&](const EdgeStretch& part) {
        for (const Control& c : {part.points.front(), part.points.back()})
            attained = std::max(attained, sign * heights.at(c.head<3>() / c[3]));
    };
    for (EdgeStretch& part : parts) {
        bound(part);
        meet(part);
    }
    std::erase_if(parts, [&](const EdgeStretch& part) { return part.bound <= attained + enough; });
    std::priority_queue<EdgeStretch> queue(std::less<EdgeStretch>(), std::move(parts));
    double left = attained + enough;
    for (int k = 0; !queue.empty() && queue.top().bound > attained + enough; ++k) {
        const EdgeStretch part = queue.top();
        queue.pop();
        constexpr int most_parts = 100'000;
        if (k == most_parts) {
            left = std::max(left, part.bound);
            break;
        }
        for (EdgeStretch& half : cut(part, heights)) {
            half.range = heights.range(half);
            bound(half);
            meet(half);
            queue.push(std::move(half));
        }
    }
    return {attained, std::max(left, attained + enough)};
}

/// Half the distance between the base and an object, and whether the base's point nearest to it is one of the
/// region: surely, perhaps (none), or not. A bisector that is lowest all along a line or an arc is so on
/// edges too.
struct Nearest {
    Interval half_distance;
    std::optional<bool> is_inside;
    bool is_in_tip = false;  ///< of a tube that pierces the base: then the cell is known to be there, too
};

std::optional<bool> lies_within(Interval x, Interval low, Interval high) {
    const Interval below = x - low, above = high - x;
    if (below.lower() >= 0 && above.lower() >= 0) return true;
    if (below.upper() < 0 || above.upper() < 0) return false;
    return std::nullopt;
}

/// The base ball's centre, seen from the vessel's centre or axis, in the frame; in a cone both are such that
/// their difference is what it is away from the wall.
struct FromVessel {
    Interval distance, radius;
};
FromVessel from_vessel(const Object& object, const Frame& frame) {
    if (const auto* ball = std::get_if<HollowSphere>(&object)) {
        const Triad<Interval> c = frame.point(ball->center);
        return {sqrt(square(c[0]) + square(c[1]) + square(c[2])), frame.length(ball->radius)};
    }
    const auto axial = [&](const Vec3& point, const Vec3& axis) {
        const Triad<Interval> d = frame.direction(axis / axis.cwiseAbs().maxCoeff()), c = frame.point(point);
        const Interval x = c[1] * d[2] - c[2] * d[1], y = c[2] * d[0] - c[0] * d[2],
                       z = c[0] * d[1] - c[1] * d[0], length2 = square(d[0]) + square(d[1]) + square(d[2]);
        return std::array{sqrt((square(x) + square(y) + square(z)) / length2),
                          -(c[0] * d[0] + c[1] * d[1] + c[2] * d[2]) / sqrt(length2)};
    };
    if (const auto* cone = std::get_if<HollowCone>(&object)) {
        const auto [across, along] = axial(cone->apex, cone->axis);
        const Interval r(cone->radius), s(cone->slant);
        return {sqrt((s - r) * (s + r)) / s * across, r / s * along};
    }
    const auto& tube = std::get<HollowCylinder>(object);
    return {axial(tube.point, tube.axis)[0], frame.length(tube.radius)};
}
Nearest nearest_in_vessel(const Scene& scene, const Site& site, const Frame& frame) {
    const auto [distance, radius] = from_vessel(scene.objects[site.index], frame);
    return {0.5 * (radius - distance - frame.radius()), true};
}

/// Is a point of an object's bisector over the region, in the box, and nothing else nearer to it? None: it
/// may be.
std::optional<bool> is_bounded(const Subject& subject, const Site& site, const Vector<Interval>& p) {
    const Scene& scene = subject.cell.scene;
    std::optional<bool> result = true;
    const auto meet = [&](const Interval& excess) {
        if (excess.upper() < 0) result = false;
        if (!(excess.lower() > 0) && result == true) result = std::nullopt;
    };
    // The ways off a base plane start in the box, unless the cell is a complete one.
    const bool starts_in_box = std::holds_alternative<Plane>(scene.base) && !subject.cell.is_complete;
    for (std::uint32_t s = 0; s < 6; ++s) {
        meet(subject.space.inside_side(s, p));
        if (starts_in_box) meet(subject.space.excess({Site::box_side(s), true}, p));
    }
    for (std::uint32_t end = 0; std::holds_alternative<Cylinder>(scene.base) && end < 2; ++end)
        meet(subject.space.inside_end(end, p));
    const Interval clearance = subject.space.clearance(p);
    // Equal objects are as far everywhere.
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.competes(i) && !(site.is_object() && scene.objects[i] == scene.objects[site.index]))
            meet(subject.space.object_excess(i, p, clearance));
    return result;
}

/// Is one of a bisector's tips over the region and, where rays come in through sides of the box, bounded
/// there?
std::optional<bool> is_tip_inside(const Subject& subject, const Site& site) {
    std::optional<bool> result = false;
    for (const Tip& tip : tips_of(subject.space, subject.cell.scene.objects[site.index])) {
        std::optional<bool> is_inside = true;
        for (std::uint32_t end = 0; std::holds_alternative<Cylinder>(subject.cell.scene.base) && end < 2;
             ++end) {
            const Interval room = subject.space.inside_end(end, tip.p);
            if (room.upper() < 0) is_inside = false;
            if (!(room.lower() >= 0) && is_inside == true) is_inside = std::nullopt;
        }
        if (is_inside != false && subject.part && subject.part->has_floor())
            is_inside = is_bounded(subject, site, tip.p);
        if (is_inside != false && result != true) result = is_inside;
    }
    return result;
}

/// Where a ball or another tube is nearest to a base tube, half-way between them.
std::optional<Vector<Interval>> nearest_beside_tube(const Space<Interval>& space, const Object& object) {
    const Surface<Interval>& base = space.base();
    Vector<Interval> q;  // the centre, or the place of the axis
    Interval radius;
    if (const auto* ball = std::get_if<Sphere>(&object)) {
        q = to_vector<Interval>(ball->center);
        radius = ball->radius;
    } else if (std::holds_alternative<Cylinder>(object)) {
        const Surface<Interval> tube(object);
        radius = tube.radius;
        // With b = a d of the axes a and d, the way w from the base's point and the place s on the tube:
        // s (1 - b^2) = b w a - w d.
        const Vector<Interval> w = tube.point - base.point;
        const Interval b = dot(base.direction, tube.direction),
                       rest = square(cross(base.direction, tube.direction));
        if (!(rest.lower() > 0)) return std::nullopt;
        q = tube.point + (b * dot(w, base.direction) - dot(w, tube.direction)) / rest * tube.direction;
    } else {
        return std::nullopt;
    }
    const Interval away = space.clearance(q);
    if (!(away.lower() > 0)) return std::nullopt;
    return q - 0.5 * (away + radius) * space.up(q);
}

/// How high a bisector is at a place where it may be highest, and whether no other site is nearer there.
/// Where that is not told, as of objects that coincide or all but do, the cell reaches so far `below` it at
/// least.
struct Farthest {
    Interval height;
    std::optional<bool> is_there;
    double below = HUGE_VAL;

    double attained() const { return is_there == true ? height.lower() : height.lower() - below; }
};
/// At a point of the bisector, unless another site is nearer there. Excesses fall on the way from the base:
/// those that are 0 in the point are told from less a little before it.
std::optional<Farthest> farthest_at(const Subject& subject, const Site& site, const Interval& height,
                                    const Vector<Interval>& p, const Frame& frame) {
    Farthest result{height, is_bounded(subject, site, p)};
    if (result.is_there == false) return std::nullopt;
    if (result.is_there) return result;
    const double size = subject.geometry.scale();
    // Parts of the scene: from what rounding leaves to the coarsest bound that is worth having.
    constexpr double first = 0x1p-48, last = 0x1p-16;
    for (double part = first; part < last; part *= 4) {
        const double below = part * size;
        if (is_bounded(subject, site, p - Interval(below) * subject.space.up(p)) != true) continue;
        result.below = below / frame.unit() * (1 + 0x1p-50);
        break;
    }
    return result;
}
/// The bisector with a hollow sphere is farthest from the base's centre towards the vessel's and beyond.
std::optional<Farthest> farthest_about_ball(const Subject& subject, const Site& site, const Frame& frame) {
    const Scene& scene = subject.cell.scene;
    const auto* base = std::get_if<Sphere>(&scene.base);
    const auto* ball = site.is_object() ? std::get_if<HollowSphere>(&scene.objects[site.index]) : nullptr;
    if (!base || !ball) return std::nullopt;
    const auto [distance, radius] = from_vessel(scene.objects[site.index], frame);
    const Vector<Interval> from = to_vector<Interval>(base->center),
                           way = to_vector<Interval>(ball->center) - from;
    const Interval length = sqrt(square(way));
    // All directions are alike where a vessel is about the base's centre: any that shows will do, and edges
    // tell.
    if (!(length.lower() > 0)) return std::nullopt;
    const Vector<Interval> p =
        from + (Interval(0.5) * (Interval(ball->radius) + base->radius + length) / length) * way;
    return farthest_at(subject, site, 0.5 * (radius + distance - frame.radius()), p, frame);
}

/// Over a plane it is highest above the hollow sphere's centre, half-way between the plane and the wall.
std::optional<Farthest> farthest_over_plane(const Subject& subject, const Site& site, const Frame& frame) {
    const auto* ball = std::get_if<HollowSphere>(&subject.cell.scene.objects[site.index]);
    if (!ball) return std::nullopt;
    const Vector<Interval> c = to_vector<Interval>(ball->center);
    const Interval above = subject.space.clearance(c), height = 0.5 * (above + Interval(ball->radius));
    return farthest_at(subject, site, height / Interval(frame.unit()),
                       c + (height - above) * subject.space.up(c), frame);
}

/// Around a tube a bisector with a vessel is farthest where the ways from the base's axis and from the wall
/// meet head on: beyond a hollow sphere's centre, as seen from the axis; in a tube or a cone the wall's
/// tangent plane is along the base there. Whether the place is on the bisector and shows.
struct HeadOn {
    Vector<Interval> p;
    Interval reach;
    std::optional<bool> is_met;
};
std::vector<HeadOn> places_head_on(const Space<Interval>& space, const Object& object) {
    const Surface<Interval>&base = space.base(), vessel(object);
    const Vector<Interval>& d = base.direction;
    const Interval half(0.5), one(1.0);
    if (vessel.kind == Surface<Interval>::Kind::sphere) {
        const Vector<Interval> way = vessel.point - base.point, from = base.point + dot(way, d) * d,
                               out = vessel.point - from;
        const Interval length = sqrt(square(out)), reach = half * (vessel.radius + base.radius + length);
        Vector<Interval> unit = check::direction(out, length);
        if (!(length.lower() > 0)) {
            // All directions are alike, or nearly: any that shows will do.
            const Vec3 aside = middle(d).unitOrthogonal();
            const Vector<Interval> e = to_vector<Interval>(aside), across = e - dot(e, d) * d;
            unit = check::direction(across, sqrt(square(across)));
        }
        return {{from + reach * unit, reach, true}};
    }
    const Vector<Interval>& w = vessel.direction;
    const Interval rise = dot(w, d), across = sqrt(square(cross(w, d)));
    if (!(across.lower() > 0)) return {};
    const Interval cosine = vessel.sine * rise / (vessel.cosine * across), rest = one - square(cosine);
    if (!(rest.upper() > 0)) return {};
    const Interval sine = sqrt(Interval(std::max(0.0, rest.lower()), rest.upper()));
    const Vector<Interval> toward = Interval(one / across) * (d - rise * w), aside = cross(w, toward);
    std::vector<HeadOn> places;
    for (const double side : {-1.0, 1.0}) {
        // As d = rise w + across toward, d.beside is known however little the axes lean.
        const Vector<Interval> e = cosine * toward + Interval(side) * sine * aside,
                               out = vessel.cosine * e - vessel.sine * w, beside = cross(w, e);
        const Vector<Interval> from =
            base.point + dot(vessel.point - base.point, beside) / (Interval(-side) * sine * across) * d;
        const Interval reach = half * (vessel.radius + base.radius - dot(out, from - vessel.point));
        const Vector<Interval> p = from + reach * out;
        const Interval along = dot(p - vessel.point, e);
        if (along.upper() < 0) continue;
        places.push_back(
            {p, reach, along.lower() > 0 && rest.lower() > 0 ? std::optional(true) : std::nullopt});
    }
    return places;
}

std::vector<Farthest> farthest_in_vessel(const Subject& subject, const Site& site, const Frame& frame) {
    std::vector<Farthest> found;
    const Scene& scene = subject.cell.scene;
    if (!site.is_object() || !is_vessel(scene.objects[site.index])) return found;
    // At a tip the bisector has no tangent plane.
    for (const Tip& tip : tips_of(subject.space, scene.objects[site.index])) {
        const Interval height = (tip.reach - subject.space.base().radius) / Interval(frame.unit());
        if (const auto farthest = farthest_at(subject, site, height, tip.p, frame))
            found.push_back(*farthest);
    }
    if (std::holds_alternative<Sphere>(scene.base)) {
        if (const auto farthest = farthest_about_ball(subject, site, frame)) found.push_back(*farthest);
        return found;
    }
    if (std::holds_alternative<Plane>(scene.base)) {
        if (const auto farthest = farthest_over_plane(subject, site, frame)) found.push_back(*farthest);
        return found;
    }
    for (const HeadOn& place : places_head_on(subject.space, scene.objects[site.index])) {
        const Interval height = (place.reach - subject.space.base().radius) / Interval(frame.unit());
        const auto farthest = farthest_at(subject, site, height, place.p, frame);
        if (farthest) found.push_back(place.is_met ? *farthest : Farthest{height, std::nullopt});
    }
    return found;
}

}  // namespace

Clearances clearances(const Subject& subject, const Frame& frame) {
    const Cell& cell = subject.cell;
    const Scene& scene = cell.scene;
    const Heights heights(scene, frame);
    constexpr double rounding = kRounding;  // of coordinates, in the frame's unit
    std::vector<EdgeStretch> parts;
    for (const auto& pieces : subject.edge_pieces)
        for (const auto& piece : pieces) {
            EdgeStretch part{{}, {}, 0};
            for (std::size_t i = 0; i < piece.points.size(); ++i) {
                const Triad<double> p = frame.about(piece.control(i));
                const double w = piece.weight(i);
                part.points.push_back({w * p[0], w * p[1], w * p[2], w});
            }
            part.range = heights.range(part);
            parts.push_back(std::move(part));
        }
    Interval least{HUGE_VAL}, most{-HUGE_VAL};
    if (!parts.empty()) {
        least = -greatest(parts, heights, -1, rounding);
        most = greatest(std::move(parts), heights, 1, rounding);
    }

    const double size = subject.geometry.scale() / frame.unit();
    Interval low, high;
    if (std::holds_alternative<Cylinder>(scene.base)) {
        const auto end = [&](const Interval& y) {
            return hull(frame.length(y.lower()), frame.length(y.upper())) +
                   Interval(-rounding, rounding) * size;
        };
        low = end(subject.space.stretch()[0]);
        high = end(subject.space.stretch()[1]);
    }
    std::set<Site> owners;
    for (const std::uint32_t f : subject.faces) owners.insert(cell.faces[f].site);
    for (const Site& site : owners) {
        auto nearest = [&]() -> std::optional<Nearest> {
            const bool over_plane = std::holds_alternative<Plane>(scene.base);
            const bool about_sphere = std::holds_alternative<Sphere>(scene.base);
            const Interval radius = frame.radius();
            if (site.kind == Site::Kind::BoxSide) {
                if (!about_sphere) return std::nullopt;  // lowest along lines, or at the rim
                const int axis = static_cast<int>(site.index / 2);
                const Triad<Interval> corner = frame.point(site.index % 2 ? scene.box.max : scene.box.min);
                const Interval k = corner[static_cast<std::size_t>(axis)];
                return Nearest{(site.index % 2 ? k : -k) - radius, true};
            }
            if (!site.is_object()) return std::nullopt;
            const Object& object = scene.objects[site.index];
            if (const auto* ball = std::get_if<Sphere>(&object)) {
                const Triad<Interval> c = frame.point(ball->center);
                const Interval r = frame.length(ball->radius);
                if (over_plane) {
                    const Plane& base = std::get<Plane>(scene.base);
                    const Vec3& n = base.normal;
                    const Vec3 foot = ball->center - n * (n.dot(ball->center - base.point) / n.squaredNorm());
                    // A side that the base plane runs along does not bound its region.
                    double inside = HUGE_VAL;
                    for (int axis = 0; axis < 3; ++axis)
                        if (n[(axis + 1) % 3] != 0 || n[(axis + 2) % 3] != 0)
                            inside = std::min(
                                {inside, foot[axis] - scene.box.min[axis], scene.box.max[axis] - foot[axis]});
                    inside /= frame.unit();
                    Nearest result{0.5 * (c[2] - r), std::nullopt};
                    if (std::abs(inside) > rounding * size) result.is_inside = inside > 0;
                    return result;
                }
                if (about_sphere)
                    return Nearest{0.5 * (sqrt(square(c[0]) + square(c[1]) + square(c[2])) - r - radius),
                                   true};
                return Nearest{0.5 * (sqrt(square(c[0]) + square(c[1])) - r - radius),
                               lies_within(c[2], low, high)};
            }
            if (const auto* plane = std::get_if<Plane>(&object)) {
                if (!about_sphere) return std::nullopt;
                const double scale = plane->normal.cwiseAbs().maxCoeff();
                const Triad<Interval> n = frame.direction(plane->normal / scale),
                                      p = frame.point(plane->point);
                const Interval d = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
                const Interval length = sqrt(square(n[0]) + square(n[1]) + square(n[2]));
                return Nearest{0.5 * ((d.mid() < 0 ? -d : d) / length - radius), true};
            }
            if (is_vessel(object) && about_sphere) return nearest_in_vessel(scene, site, frame);
            if (is_vessel(object)) return std::nullopt;
            const auto& tube = std::get<Cylinder>(object);
            if (over_plane) return std::nullopt;
            // Its walls come to the axis where that ends or is cut.
            if (const auto* base = std::get_if<Cylinder>(&scene.base); base && cross_equally(*base, tube))
                return std::nullopt;
            const Triad<Interval> d = frame.direction(tube.axis / tube.axis.cwiseAbs().maxCoeff()),
                                  c = frame.point(tube.point);
            const Interval r = frame.length(tube.radius);
            // So far apart are axes, or the ball's centre and the axis.
            const auto beside = [&](const Interval& distance, std::optional<bool> is_inside) -> Nearest {
                const Interval outside = 0.5 * (distance - r - radius), reach = radius - r;
                if (!(reach.lower() > 0) || distance.lower() > reach.upper()) return {outside, is_inside};
                if (distance.upper() < reach.lower()) return {-r, is_tip_inside(subject, site), true};
                return {hull(outside, -r), std::nullopt, true};
            };
            if (about_sphere) {
                const Interval x = c[1] * d[2] - c[2] * d[1], y = c[2] * d[0] - c[0] * d[2],
                               z = c[0] * d[1] - c[1] * d[0];
                const Interval distance =
                    sqrt((square(x) + square(y) + square(z)) / (square(d[0]) + square(d[1]) + square(d[2])));
                return beside(distance, true);
            }
            // The common perpendicular of two axes, the base's that of z.
            const Interval across = square(d[0]) + square(d[1]);
            if (!(across.lower() > 0)) return std::nullopt;
            const Interval cross = c[0] * d[1] - c[1] * d[0];
            const Interval distance = (cross.mid() < 0 ? -cross : cross) / sqrt(across);
            const Interval z = c[2] - (c[0] * d[0] + c[1] * d[1]) / across * d[2];
            return beside(distance, lies_within(z, low, high));
        }();
        const auto meet_farthest = [&] {
            for (const Farthest& farthest : farthest_in_vessel(subject, site, frame))
                most = Interval(std::max(most.lower(), farthest.attained()),
                                std::max(most.upper(), farthest.height.upper()));
        };
        // Around a tube, and over a plane, there is always an edge.
        if (!std::holds_alternative<Sphere>(scene.base)) meet_farthest();
        if (!nearest || nearest->is_inside == false) continue;
        if (subject.part && subject.part->has_floor() && !nearest->is_in_tip) {
            // Not all rays come into the box where they would meet the bisector.
            const auto p = nearest_beside_tube(subject.space, scene.objects[site.index]);
            nearest->is_inside = p ? is_bounded(subject, site, *p) : std::nullopt;
            if (nearest->is_inside == false) continue;
        }
        least = Interval(
            std::min(least.lower(), nearest->half_distance.lower()),
            nearest->is_inside ? std::min(least.upper(), nearest->half_distance.upper()) : least.upper());
        // A cell of one face without an edge is as high as low.
        if (most.upper() == -HUGE_VAL) most = nearest->half_distance;
        if (std::holds_alternative<Sphere>(scene.base)) meet_farthest();
    }
    const Interval blur(-rounding * size, rounding * size);
    return {least + blur, most + blur};
}

}  // namespace vcell::check
