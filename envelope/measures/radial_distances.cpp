#include "radial_distances.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "../room_at.hpp"

namespace vcell {

namespace {

using roundoff::u;

// Where rays from a base's centre or axis and from a vessel's wall meet head on. Over a generator of a tube
// along the base, or all around it, they are many, or edges have them, too. Pre: over a ball, a hollow
// sphere.
std::vector<Vec3> places_head_on(const Object& vessel, const BaseChart& chart) {
    const double R0 = chart.radius;
    if (const auto* ball = std::get_if<HollowSphere>(&vessel)) {
        const Vec3 foot = chart.foot_below(ball->center), away = ball->center - foot;
        const double off = away.norm(), t = 0.5 * (ball->radius + R0 + off);
        const Vec3 u = off > 0 ? Vec3(away / off) : Vec3::UnitX().eval();
        return {foot + t * u};
    }
    const auto* cone = std::get_if<HollowCone>(&vessel);
    const auto* tube = std::get_if<HollowCylinder>(&vessel);
    const Vec3 w = (cone != nullptr ? cone->axis : tube->axis).stableNormalized(),
               point = cone != nullptr ? cone->apex : tube->point;
    const double S = cone != nullptr ? cone->sine() : 0, K = cone != nullptr ? cone->cosine() : 1,
                 across = std::hypot(w.x(), w.z()), cosine = across > 0 ? S * w.y() / (K * across) : 2;
    if (!(std::abs(cosine) < 1)) return {};
    // The wall's generator beside the place is along w and e from the axis; the plane that touches there
    // is along the base.
    std::vector<Vec3> places;
    const Vec3 toward = (Vec3::UnitY() - w.y() * w) / across, aside = w.cross(toward);
    for (const double side : {-1.0, 1.0}) {
        const Vec3 e = cosine * toward + side * std::sqrt(1 - cosine * cosine) * aside, out = K * e - S * w,
                   beside = w.cross(e);
        const Vec3 direction = Vec3(out.x(), 0, out.z()).normalized();
        const double y = point.dot(beside) / beside.y();
        const Vec3 from(0, y, 0);
        const double own = tube != nullptr ? tube->radius : 0, t = 0.5 * (own - out.dot(from - point) + R0);
        const Vec3 p = from + t * direction;
        if (std::isfinite(y) && (p - point).dot(e) > 0) places.push_back(p);
    }
    return places;
}

// Where the bisector with a ball, or a tube that is not along the base's axis, is nearest to that, at the
// distance `least`: towards the ball's centre, or the tube's axis.
Vec3 nearest_place(const Object& object, double least) {
    Vec3 q = Vec3::Zero();
    if (const auto* ball = std::get_if<Sphere>(&object)) {
        q = ball->center;
    } else {
        const auto& tube = std::get<Cylinder>(object);
        const Vec3 d = tube.axis.normalized();
        q = tube.point - (tube.point.x() * d.x() + tube.point.z() * d.z()) / (1 - d.y() * d.y()) * d;
    }
    const double away = std::hypot(q.x(), q.z());
    return {q.x() / away * least, q.y(), q.z() / away * least};
}

// Over a generator of a tube along the base, or all around it, they are many, or edges have them, too. At
// a tip the bisector has no tangent plane; around a ball only those are far from it in a tube or cone.
std::vector<Vec3> farthest_places(const RadialBaseProblem& problem, FormId form) {
    const Object& vessel = problem.objects[form];
    std::vector<Vec3> places;
    if (problem.family.forms.empty() || std::holds_alternative<HollowSphere>(vessel))
        places = places_head_on(vessel, problem.chart);
    for (const BisectorTip& tip : bisector_tips(problem, form)) places.push_back(tip.point());
    return places;
}

// How far away the point is that an axis or a plane runs through: projections of it are rounded. A ball's
// power is not.
double distance_of_point(const Object& object) {
    if (const auto* plane = std::get_if<Plane>(&object)) return plane->point.norm();
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) return vessel->point.norm();
    if (const auto* vessel = std::get_if<HollowCone>(&object)) return vessel->apex.norm();
    const auto* cylinder = std::get_if<Cylinder>(&object);
    return cylinder != nullptr ? cylinder->point.norm() : 0;
}

}  // namespace

void RadialDistances::add(double low, double high, double error) {
    if (!std::isfinite(low)) return;
    known_ = {std::min(known_[0], low), std::max(known_[1], high)};
    least_ = {std::min(least_[0], low - error), std::min(least_[1], low + error)};
    greatest_ = {std::max(greatest_[0], high - error), std::max(greatest_[1], high + error)};
}

void RadialDistances::add(const RadialDistances& other) {
    known_ = {std::min(known_[0], other.known_[0]), std::max(known_[1], other.known_[1])};
    for (const int i : {0, 1}) {
        least_[i] = std::min(least_[i], other.least_[i]);
        greatest_[i] = std::max(greatest_[i], other.greatest_[i]);
    }
}

void RadialDistances::add_bisector(const RadialBaseProblem& problem, FormId form, double least) {
    if (is_vessel(problem.objects[form])) add_farthest(problem, form);
    add_nearest(problem, form, least);
}

// The least of all forms' least distances is that of one which is nearest there. Elsewhere the smallest
// distance is on an edge.
void RadialDistances::add_nearest(const RadialBaseProblem& problem, FormId form, double least) {
    const double error = 8 * u * (least + problem.chart.radius + distance_of_point(problem.objects[form]));
    if (problem.floor.empty() || !std::isfinite(least)) return add(least, least, error);
    // But over a floor it counts only where the cell is there.
    const Vec3 place = nearest_place(problem.objects[form], least);
    const double room = room_at(problem, form, place, least - problem.chart.radius),
                 unsure = 64 * (error + u * place.norm());
    if (room > unsure)
        add(least, least, error);
    else if (room >= -unsure)
        least_[0] = std::min(least_[0], least - error);
}

// How far before such a place, as a part of its distance, a bound that shows is looked for: what is stated is
// off by no more, or by all that edges leave open.
constexpr double farthest_before = 0x1p-16;

// The bisector with a vessel is farthest from the base's centre or axis where the rays from that and from the
// wall meet head on: nothing later on has the place unless an edge runs through it. Excesses fall on the way
// there: what ties in the place is farther a little before it.
void RadialDistances::add_farthest(const RadialBaseProblem& problem, FormId form) {
    const double R0 = problem.chart.radius;
    for (const Vec3& p : farthest_places(problem, form)) {
        const Vec3 foot = problem.chart.foot_below(p);
        const double t = problem.chart.distance(p),
                     error = 16 * u * (t + p.norm() + distance_of_point(problem.objects[form])),
                     height = problem.chart.along(p.y()),
                     room = height < problem.stretch[0] || height > problem.stretch[1]
                                ? -infinity
                                : room_at(problem, form, p, t - R0);
        if (room > 4 * error) {
            add(t, t, error);
        } else if (room >= -4 * error) {
            greatest_[1] = std::max(greatest_[1], t + error);
            for (double before = 16 * error; before < farthest_before * t; before *= 4) {
                const double s = t - before;
                if (!(room_at(problem, form, foot + s / t * (p - foot), s - R0) > 4 * error)) continue;
                known_[1] = std::max(known_[1], s);
                greatest_[0] = std::max(greatest_[0], s - error);
                break;
            }
        }
    }
}

void RadialDistances::add_tip(const BisectorTip& tip, const Object& object) {
    add(tip.reach, tip.reach, 32 * u * (tip.reach + distance_of_point(object)));
}

void RadialDistances::set_clearances(double radius, Measures& measures) const {
    measures.min_clearance = known_[0] - radius;
    measures.max_clearance = known_[1] - radius;
    measures.min_clearance_error = std::max(least_[1] - known_[0], known_[0] - least_[0]);
    measures.max_clearance_error = std::max(greatest_[1] - known_[1], known_[1] - greatest_[0]);
}

}  // namespace vcell
