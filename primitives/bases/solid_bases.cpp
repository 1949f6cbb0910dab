#include "solid_bases.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "../../core/errors.hpp"
#include "../../core/numbers/interval.hpp"
#include "../objects/exact_space.hpp"
#include "../objects/message.hpp"
#include "canonical.hpp"
#include "cylinder_base.hpp"
#include "solids.hpp"
#include "sphere_base.hpp"
#include "world_objects.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

using Triple = std::array<Interval, 3>;

Triple operator+(const Triple& a, const Triple& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Triple operator-(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Triple operator*(Interval s, const Triple& a) { return {s * a[0], s * a[1], s * a[2]}; }
Interval inner(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Interval square_norm(const Triple& a) { return square(a[0]) + square(a[1]) + square(a[2]); }
Triple triple(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Triple unit_triple(const Vec3& v) {
    const Triple t = triple(v);
    const Interval length = sqrt(square_norm(t));
    return {t[0] / length, t[1] / length, t[2] / length};
}

double radius_of(const Object& object) {
    if (const auto* sphere = std::get_if<Sphere>(&object)) return sphere->radius;
    if (const auto* tube = std::get_if<Cylinder>(&object)) return tube->radius;
    return HUGE_VAL;
}

// ---- Drawn in ---------------------------------------------------------------------------------------

// The largest length of 45 bits that is no more than the base's radius, in units that all radii have.
double length_to_draw_in(const Scene& scene) {
    double largest = radius_of(scene.base);
    for (const Object& o : scene.objects)
        if (std::isfinite(radius_of(o))) largest = std::max(largest, radius_of(o));
    if (!(largest > 0)) return 0;
    const double step = std::ldexp(1.0, std::ilogb(largest) - 44);
    return std::floor(radius_of(scene.base) / step) * step;
}

// Returns a bound on what rounding moves.
double draw_in(Object& object, double length) {
    if (auto* sphere = std::get_if<Sphere>(&object)) {
        sphere->radius -= length;
    } else if (auto* tube = std::get_if<Cylinder>(&object)) {
        tube->radius -= length;
    } else if (auto* plane = std::get_if<Plane>(&object); plane != nullptr && length > 0) {
        constexpr double rounding = 0x1p-50;
        plane->point -= length * plane->normal.stableNormalized();
        return rounding * (plane->point.norm() + length);
    }
    return 0;
}

// ---- Parts of an axis -------------------------------------------------------------------------------

// C, B / W at least, and e = d(f) + R0 over a part of the axis.
struct Terms {
    Interval C, least_b, e;
};

// A solid beside the axis, f(y) = f + y a: the vector v of the ball's centre or across the tube from f, and
// what of it is across the axis; or the distance from a half space.
struct BesideAxis {
    bool is_round = false;
    Triple v{}, v_along{}, across{}, across_along{};
    Interval delta;
    Interval e, e_along, least_b;

    BesideAxis(const Object& object, const Triple& f, const Triple& a, double R0) {
        const auto without = [](const Triple& w, const Triple& d) { return w - inner(w, d) * d; };
        if (const auto* plane = std::get_if<Plane>(&object)) {
            const Triple n = unit_triple(plane->normal);
            e = inner(n, f - triple(plane->point)) + R0;
            e_along = inner(n, a);
            const Interval sine2 = Interval(1.0) - square(e_along);
            least_b = 0.5 * (Interval(1.0) - (sine2.upper() > 0 ? sqrt(sine2) : Interval(0.0)));
            return;
        }
        is_round = true;
        delta = Interval(radius_of(object)) - R0;
        if (const auto* sphere = std::get_if<Sphere>(&object)) {
            v = f - triple(sphere->center);
            v_along = a;
            across = without(v, a);
            return;
        }
        const auto& tube = std::get<Cylinder>(object);
        const Triple d = unit_triple(tube.axis);
        v = without(f - triple(tube.point), d);
        v_along = without(a, d);
        across = without(v, a);
        across_along = without(v_along, a);
    }

    Terms terms(Interval y) const {
        if (!is_round) {
            const Interval at = e + y * e_along;
            return {at, least_b, at};
        }
        const Interval squared = square_norm(v + y * v_along);
        return {squared - square(delta), delta - sqrt(square_norm(across + y * across_along)),
                sqrt(squared) - delta};
    }

    // Where C <= 0, rounded.
    std::optional<std::array<double, 2>> inside() const {
        constexpr double infinity = std::numeric_limits<double>::infinity(), parallel = 0x1p-40;
        if (!is_round) {
            const double slope = e_along.mid(), at = e.mid();
            if (std::abs(slope) < parallel)
                return at < 0 ? std::optional(std::array{-infinity, infinity}) : std::nullopt;
            return slope > 0 ? std::array{-infinity, -at / slope} : std::array{-at / slope, infinity};
        }
        const double A = square_norm(v_along).mid(), B = inner(v, v_along).mid(),
                     C = square_norm(v).mid() - square(delta).mid();
        if (A < parallel * parallel)
            return C < 0 ? std::optional(std::array{-infinity, infinity}) : std::nullopt;
        const double root2 = B * B - A * C;
        if (!(root2 > 0)) return std::nullopt;
        return std::array{(-B - std::sqrt(root2)) / A, (-B + std::sqrt(root2)) / A};
    }
};

class AxisOfSolids {
public:
    // `least`: R0 before all was drawn in.
    AxisOfSolids(const Scene& scene, const RadialBaseProblem& bare, double least)
        : least_(least), stretch_(bare.stretch) {
        constexpr double rounding = 0x1p-50;
        const Vec3 along = bare.frame.rotation.row(1), &origin = bare.frame.origin;
        Triple a;
        for (int k = 0; k < 3; ++k) a[k] = Interval::ball(along[k], rounding);
        const double R0 = radius_of(scene.base);
        for (const Object& o : scene.objects) others_.emplace_back(o, triple(origin), a, R0);
    }

    // What is not left out.
    std::vector<std::array<double, 2>> parts() const {
        std::vector<std::array<double, 2>> out;
        for (const BesideAxis& other : others_)
            if (const auto inside = other.inside()) add_surroundings(*inside, out);
        std::ranges::sort(out);
        std::vector<std::array<double, 2>> left;
        double from = stretch_[0];
        for (const auto& [low, high] : out) {
            if (low > from) left.push_back({from, low});
            from = std::max(from, high);
        }
        if (from < stretch_[1]) left.push_back({from, stretch_[1]});
        return left;
    }

    // Is a half space certainly clear of what is left of the base?
    bool is_clear(const std::array<double, 2>& part, double R0) const {
        return std::ranges::all_of(others_, [&](const BesideAxis& other) {
            return other.is_round ||
                   (other.terms(part[0]).e.lower() > 2 * R0 && other.terms(part[1]).e.lower() > 2 * R0);
        });
    }

private:
    double length() const { return stretch_[1] - stretch_[0]; }

    // What of the stretch is in a solid, and as much on both sides as has nothing.
    void add_surroundings(const std::array<double, 2>& inside,
                          std::vector<std::array<double, 2>>& out) const {
        // Parts of the stretch. A solid may miss it by so much for its rounding; and ways that are shorter
        // are not told from none. What comes of either is proved below.
        constexpr double near = 0x1p-10, shortest = 0x1p-45;
        std::array<double, 2> part = inside;
        if (part[1] < stretch_[0] - near * length() || part[0] > stretch_[1] + near * length()) return;
        for (const int end : {0, 1}) {
            const double sign = end == 0 ? -1 : 1, from = std::clamp(inside[end], stretch_[0], stretch_[1]);
            for (double way = length(); way > shortest * length(); way *= 0.5) {
                const double to = std::clamp(inside[end] + sign * way, stretch_[0], stretch_[1]);
                if (sign * (to - from) < 0 || !has_nothing(std::min(from, to), std::max(from, to), shallow))
                    continue;
                part[end] = to;
                break;
            }
        }
        part = {std::max(part[0], stretch_[0]), std::min(part[1], stretch_[1])};
        if (!(part[0] < part[1])) return;
        if (!has_nothing(part[0], part[1], deep))
            throw UndecidedError(
                "solids touch from within, or equal tubes cross: there is no telling which points beside the "
                "thinnest one are nearest to it");
        out.push_back(part);
    }

    static constexpr int shallow = 8, deep = 60;

    bool has_nothing(double low, double high, int halvings) const {
        if (has_nothing(Interval(low, high))) return true;
        const double middle = std::midpoint(low, high);
        return halvings > 0 && low < middle && middle < high && has_nothing(low, middle, halvings - 1) &&
               has_nothing(middle, high, halvings - 1);
    }
    // No ray over y is nearest to the base and as far from the two others.
    bool has_nothing(Interval y) const {
        constexpr double room = 0x1p-40;  // for the rounding of heights along the axis
        y = Interval::ball(y.mid(), y.radius() + room * length());
        for (std::size_t i = 0; i < others_.size(); ++i) {
            const Terms own = others_[i].terms(y);
            if (own.e.upper() < 0) return true;
            if (!(own.least_b.lower() > 0)) continue;
            double least = least_;
            for (std::size_t j = 0; j < others_.size(); ++j)
                if (j != i) least = std::max(least, 0.5 * others_[j].terms(y).e.lower());
            // t <= C / 2 B
            if (own.C.upper() < own.least_b.lower() * least) return true;
        }
        return false;
    }

    const double least_;
    const std::array<double, 2> stretch_;
    std::vector<BesideAxis> others_;
};

// ---- Problems ---------------------------------------------------------------------------------------

// Does the half space hold all of the ball? Exact.
bool holds(const Plane& plane, const Sphere& ball) {
    const ExactVector n(plane.normal);
    const Exact value = dot(n, ExactVector(ball.center) - ExactVector(plane.point)),
                square = Exact(ball.radius) * ball.radius * dot(n, n);
    return value.sign() != Sign::Positive && (value * value - square).sign() != Sign::Negative;
}

// Does the one lie in the other? False of balls as the other: nothing that lies there is asked for.
bool lies_in(const Object& object, const Object& other) {
    const auto* ball = std::get_if<Sphere>(&object);
    const auto* tube = std::get_if<Cylinder>(&object);
    if (const auto* plane = std::get_if<Plane>(&other)) {
        if (ball != nullptr) return holds(*plane, *ball);
        const ExactVector n(plane->normal);
        if (tube != nullptr)
            return is_beyond({n.x, n.y, n.z, -dot(n, ExactVector(plane->point))}, world_form(*tube));
        const Plane& half = std::get<Plane>(object);
        const ExactVector m(half.normal);
        return cross(m, n).is_zero() && dot(m, n).sign() == Sign::Positive &&
               dot(n, ExactVector(half.point) - ExactVector(plane->point)).sign() != Sign::Positive;
    }
    const auto* around = std::get_if<Cylinder>(&other);
    if (around == nullptr) return false;
    if (ball != nullptr)
        return contains(world_form(*around), ball->center.x(), ball->center.y(), ball->center.z(),
                        ball->radius);
    return tube != nullptr && contains(world_form(*around), world_form(*tube));
}

// Pre: the tube lies in the other one.
bool touches_from_within(const Cylinder& tube, const Object& other) {
    const ExactVector q(tube.point), a(tube.axis);
    if (const auto* plane = std::get_if<Plane>(&other)) {
        const ExactVector n(plane->normal);
        const Exact value = dot(n, q - ExactVector(plane->point));
        return is_zero(value * value - Exact(tube.radius) * tube.radius * dot(n, n));
    }
    const Cylinder& around = std::get<Cylinder>(other);
    const ExactVector across = cross(a, q - ExactVector(around.point));
    const Exact room = Exact(around.radius) - tube.radius;
    return is_zero(dot(across, across) - room * room * dot(a, a));
}

// A ball that has one of the others around it has nothing: it may touch that from within, in a point.
// `drawn`: the scene drawn in.
std::vector<RadialBaseProblem> around_ball(const Scene& scene, const Scene& drawn, double unit) {
    const Sphere& base = std::get<Sphere>(drawn.base);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const auto* plane = std::get_if<Plane>(&scene.objects[i]);
        if (plane == nullptr) continue;
        if (holds(*plane, std::get<Sphere>(scene.base))) return {};
        const Plane& moved = std::get<Plane>(drawn.objects[i]);
        const Interval e = inner(unit_triple(moved.normal), triple(base.center) - triple(moved.point));
        if (!(e.lower() > base.radius))
            throw UndecidedError("a plane all but touches the ball about " + to_text(unit * base.center));
    }
    try {
        return {sphere_base_problem(drawn, base, unit)};
    } catch (const InputError& e) {
        if (e.kind != Kind::TouchesBase) throw;
        return {};
    }
}

std::vector<RadialBaseProblem> around_tube(const Scene& scene, const Cylinder& base, double unit,
                                           double least) {
    const AxisOfSolids axis(scene, cylinder_base_problem(base_alone(scene), base, unit), least);
    std::vector<RadialBaseProblem> problems;
    for (const std::array<double, 2>& stretch : axis.parts()) {
        if (!axis.is_clear(stretch, base.radius))
            throw UndecidedError("a plane touches the axis of the tube through " +
                                 to_text(unit * base.point));
        const CylinderPart part{scene.box, stretch, {}};
        problems.push_back(cylinder_base_problem(scene, base, unit, &part));
    }
    return problems;
}

// ---- Two surfaces -----------------------------------------------------------------------------------

bool are_parallel(const Vec3& a, const Vec3& b) { return cross(ExactVector(a), ExactVector(b)).is_zero(); }

// The squared distance between a point or a line and another one, from below.
double distance_between(const Object& a, const Object& b) {
    const auto* p = std::get_if<Sphere>(&a);
    const auto* q = std::get_if<Sphere>(&b);
    if (p != nullptr && q != nullptr) return sqrt(square_norm(triple(p->center) - triple(q->center))).lower();
    if (p == nullptr && q != nullptr) return distance_between(b, a);
    const Cylinder& tube = std::get<Cylinder>(b);
    const Triple d = unit_triple(tube.axis);
    const auto from_axis = [&](const Vec3& point) {
        const Triple m = triple(point) - triple(tube.point);
        return sqrt(square_norm(m - inner(m, d) * d)).lower();
    };
    if (p != nullptr) return from_axis(p->center);
    const Cylinder& other = std::get<Cylinder>(a);
    if (are_parallel(other.axis, tube.axis)) return from_axis(other.point);
    const Triple c = unit_triple(other.axis), m = triple(other.point) - triple(tube.point);
    const Triple normal{c[1] * d[2] - c[2] * d[1], c[2] * d[0] - c[0] * d[2], c[0] * d[1] - c[1] * d[0]};
    const Interval along = inner(m, normal) / sqrt(square_norm(normal));
    return std::max({0.0, along.lower(), -along.upper()});
}

}  // namespace

bool is_same_surface(const Object& a, const Object& b) {
    if (a.index() != b.index()) return false;
    const auto is_on = [](const Vec3& p, const Vec3& q) { return ExactVector(p) - ExactVector(q); };
    if (const auto* plane = std::get_if<Plane>(&a)) {
        const Plane& other = std::get<Plane>(b);
        return are_parallel(plane->normal, other.normal) &&
               is_zero(dot(ExactVector(plane->normal), is_on(other.point, plane->point)));
    }
    if (const auto* tube = std::get_if<Cylinder>(&a)) {
        const Cylinder& other = std::get<Cylinder>(b);
        return tube->radius == other.radius && are_parallel(tube->axis, other.axis) &&
               cross(ExactVector(tube->axis), is_on(other.point, tube->point)).is_zero();
    }
    return a == b;
}

bool touch_along_line(const std::array<Object, 3>& solids) {
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const auto* tube = std::get_if<Cylinder>(&solids[i]);
            if (i == j || tube == nullptr || !lies_in(*tube, solids[j])) continue;
            if (touches_from_within(*tube, solids[j]) && !lies_in(solids[3 - i - j], solids[j])) return true;
        }
    return false;
}

bool are_certainly_apart(const Object& a, const Object& b) {
    const Interval reach = Interval(radius_of(a)) + radius_of(b);
    return std::isfinite(reach.upper()) && distance_between(a, b) > reach.upper();
}

std::optional<std::size_t> thinnest(std::span<const Object> objects) {
    const auto is_thinner = [](const Object& a, const Object& b) {
        return std::pair(radius_of(a), !std::holds_alternative<Sphere>(a)) <
               std::pair(radius_of(b), !std::holds_alternative<Sphere>(b));
    };
    const auto first = std::ranges::min_element(objects, is_thinner);
    if (!std::isfinite(radius_of(*first))) return std::nullopt;
    return first - objects.begin();
}

SolidProblems solid_problems(const Scene& scene, double unit) {
    SolidProblems result{scene, 0, {}};
    const double least = radius_of(scene.base);
    const bool has_plane =
        std::ranges::any_of(scene.objects, [](const Object& o) { return std::holds_alternative<Plane>(o); });
    if (has_plane) {
        const double length = length_to_draw_in(scene);
        draw_in(result.scene.base, length);
        for (Object& o : result.scene.objects) result.moved = std::max(result.moved, draw_in(o, length));
    }
    result.parts = std::holds_alternative<Sphere>(scene.base)
                       ? around_ball(scene, result.scene, unit)
                       : around_tube(result.scene, std::get<Cylinder>(result.scene.base), unit, least);
    return result;
}

}  // namespace vcell
