#include "bisector.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../bases/cone_form.hpp"
#include "../forms/round_surface.hpp"

namespace vcell {

namespace {

// ---- Implicit equations and kinds -----------------------------------------------------------------------

struct ExactPlane {
    ExactVector n;
    Exact d, square, length;  // n.p + d = 0; |n|^2 and its root, rounded once

    explicit ExactPlane(const Plane& plane)
        : n(plane.normal),
          d(-dot(n, ExactVector(plane.point))),
          square(dot(n, n)),
          length(rounded_sqrt(square)) {}
    Exact at(const ExactVector& p) const { return dot(n, p) + d; }
};

Bisector of_planes(const ExactPlane& p, const ExactPlane& q) {
    const Polynomial3 f = Polynomial3::linear(p.n, p.d), g = Polynomial3::linear(q.n, q.d);
    if (!cross(p.n, q.n).is_zero()) {
        // |n1|^2 and |n2|^2 are rational: no length is needed.
        return {BisectorKind::PairOfPlanes, q.square * (f * f) - p.square * (g * g), {1, 1}};
    }
    // n2 = c n1; the plane half-way, with c = |n2|^2 / (n1 . n2).
    const Exact inner = dot(p.n, q.n);
    const Polynomial3 same = q.square * f - inner * g;
    if (same.is_zero()) return {};
    return {BisectorKind::Plane, q.square * f + inner * g, {1, 1}};
}

// Pre: o is no plane.
RoundSurface round_surface(const Object& o) {
    const auto* sphere = std::get_if<Sphere>(&o);
    return sphere != nullptr ? RoundSurface(*sphere) : RoundSurface(std::get<Cylinder>(o));
}

// The plane's side of the base plane's normal, or of the point of a round base.
Bisector of_plane_and_round(const ExactPlane& plane, bool plane_is_base, const RoundSurface& round) {
    const Exact height = plane.at(round.point);
    const Exact side = !plane_is_base && height.sign() == Sign::Negative ? -1.0 : 1.0;
    const Polynomial3 from_plane = Polynomial3::linear(side * plane.n, side * plane.d);
    // (l + |n| rho)^2 |a|^2 = |n|^2 |a|^2 dist^2
    const Polynomial3 reach = from_plane + Polynomial3(plane.length * round.rho);
    Bisector b{
        BisectorKind::Paraboloid, round.norm * (reach * reach) - plane.square * round.squared(), {2, 2}};
    const Exact slope = dot(plane.n, round.axis);
    if (round.is_cylinder() && slope.sign() != Sign::Zero) {
        b.kind =
            cross(plane.n, round.axis).is_zero() ? BisectorKind::CircularCone : BisectorKind::EllipticCone;
        b.patch_degree = {2, 1};
        return b;
    }
    // Sign of height / |n| + rho: is any of it in front of the plane?
    const Exact h = side * height;
    const Sign in_front = h.sign() != Sign::Negative ? (h + round.rho).sign()
                                                     : (round.rho * round.rho * plane.square - h * h).sign();
    if (in_front == Sign::Negative) return {BisectorKind::Nowhere, {}, {0, 0}};
    if (round.is_cylinder()) {
        if (in_front == Sign::Positive) return {BisectorKind::ParabolicCylinder, b.polynomial, {2, 1}};
        // A line in the plane: the plane across it. (Tangent from behind: its half in front.)
        return {
            BisectorKind::Plane,
            Polynomial3::linear(cross(plane.n, round.axis), -dot(cross(plane.n, round.axis), round.point)),
            {1, 1}};
    }
    if (in_front == Sign::Zero) return {BisectorKind::Line, {}, {0, 0}};
    return b;
}

struct RoundPair {
    int side = 1;      // -1: one contains the other, or is hollow
    Exact difference;  // rho1 - side rho2
    bool is_same = false;

    RoundPair(const RoundSurface& p, const RoundSurface& q, bool is_hollow = false) {
        const bool in_p = p.contains(q), in_q = q.contains(p);
        is_same = in_p && in_q && !is_hollow;
        side = in_p || in_q || is_hollow ? -1 : 1;
        difference = p.rho - Exact(static_cast<double>(side)) * q.rho;
    }
};

// Equal distances: sqrt(A) - side sqrt(B) = difference, where A and B are the squared distances from
// centres or axes. Squared twice, with a common norm: (A - B + difference^2)^2 = 4 difference^2 A.
Polynomial3 equation_of_rounds(const RoundSurface& p, const RoundSurface& q, const Exact& difference) {
    const Exact norm = p.norm * q.norm, square = difference * difference;
    const Polynomial3 A = q.norm * p.squared(), B = p.norm * q.squared();
    if (square.sign() == Sign::Zero) return A - B;
    const Polynomial3 lifted = A - B + Polynomial3(norm * square);
    return lifted * lifted - Exact(4.0) * norm * square * A;
}

// What kind it is takes a small part of what its equation takes.
enum class AskedFor : bool { Kind, Equation };

Bisector of_rounds(const RoundSurface& p, const RoundSurface& q, bool is_hollow = false,
                   AskedFor what = AskedFor::Equation) {
    const RoundPair pair(p, q, is_hollow);
    if (pair.is_same) return {};
    const Exact square = pair.difference * pair.difference;
    const bool equal = square.sign() == Sign::Zero;
    const Polynomial3 f =
        what == AskedFor::Equation ? equation_of_rounds(p, q, pair.difference) : Polynomial3();
    const bool parallel = p.is_cylinder() == q.is_cylinder() && cross(p.axis, q.axis).is_zero();

    if (parallel) {
        // Points of the plane across the axes, or of space: distances from two centres.
        const bool flat = p.is_cylinder();
        const std::array<int, 2> degree{2, flat ? 1 : 2};
        if (equal) return {BisectorKind::Plane, f, {1, 1}};
        const Exact apart = p.squared_at(q.point);
        const Sign nested = (p.norm * square - apart).sign();
        if (nested == Sign::Negative)
            return {flat ? BisectorKind::HyperbolicCylinder : BisectorKind::Hyperboloid, f, degree};
        if (nested == Sign::Positive) {
            if (apart.sign() == Sign::Zero)
                return {flat ? BisectorKind::CircularCylinder : BisectorKind::Sphere, f, degree};
            return {flat ? BisectorKind::EllipticCylinder : BisectorKind::Ellipsoid, f, degree};
        }
        // A point on a sphere, a line on a cylinder: the normal, the plane through the axes.
        if (!flat) return {BisectorKind::Line, {}, {0, 0}};
        const ExactVector n = cross(p.axis, q.point - p.point);
        return {BisectorKind::Plane, Polynomial3::linear(n, -dot(n, p.point)), {1, 1}};
    }
    if (p.is_cylinder() && q.is_cylinder()) {
        if (!equal) return {BisectorKind::Quartic, f, {2, 2}};
        const bool crossing = dot(cross(p.axis, q.axis), q.point - p.point).sign() == Sign::Zero;
        if (crossing) return {BisectorKind::PairOfPlanes, f, {1, 1}};
        return {BisectorKind::HyperbolicParaboloid, f, {2, 2}};
    }
    if (!equal) return {BisectorKind::Quartic, f, {2, 2}};
    const RoundSurface &cylinder = p.is_cylinder() ? p : q, &sphere = p.is_cylinder() ? q : p;
    // A - B is a square when a point lies on a line.
    if (cylinder.squared_at(sphere.point).sign() == Sign::Zero)
        return {BisectorKind::Plane,
                Polynomial3::linear(cylinder.axis, -dot(cylinder.axis, sphere.point)),
                {1, 1}};
    return {BisectorKind::ParabolicCylinder, f, {2, 2}};
}

// ---- Patches --------------------------------------------------------------------------------------------

// A frame with the third direction along `axis`, the first one as near to `towards` as possible.
struct Frame {
    Vec3 x, y, z;

    explicit Frame(const Vec3& axis, const Vec3& towards = Vec3::Zero()) : z(axis.normalized()) {
        x = towards - z * z.dot(towards);
        // Any direction across the axis will do: this one must only have digits left after the subtraction.
        constexpr double least_part = 0x1p-40;
        if (x.norm() <= least_part * towards.norm() || x.isZero(0)) x = z.unitOrthogonal();
        x.normalize();
        y = z.cross(x);
    }
    // Homogeneous normal at the tangent t of half the angle, and its weight.
    Vec3 normal(double t) const { return (1 - t * t) * x + 2 * t * y; }
};

double weight(double t) { return 1 + t * t; }

Eigen::Vector4d homogeneous(const Vec3& p, double w) { return {p.x(), p.y(), p.z(), w}; }

// The Bezier form of a homogeneous polynomial map of degree <= 2 in each parameter, from its values at the
// ends and the middle: b1 = 2 f(1/2) - (f(0) + f(1)) / 2.
template <class Map>
std::optional<RationalPatch> bezier(const Map& map, std::array<int, 2> degree, const std::array<double, 2>& u,
                                    const std::array<double, 2>& v) {
    const auto node = [](const std::array<double, 2>& range, int i, int n) {
        return i == 0 ? range[0] : i == n ? range[1] : 0.5 * range[0] + 0.5 * range[1];
    };
    RationalPatch patch{degree[0], degree[1], u, v, {}};
    for (int i = 0; i <= degree[0]; ++i)
        for (int j = 0; j <= degree[1]; ++j)
            patch.points.push_back(map(node(u, i, degree[0]), node(v, j, degree[1])));
    const int row = degree[1] + 1;
    const auto lift_middle = [&](int first, int step) {
        Eigen::Vector4d& middle = patch.points[first + step];
        middle = 2 * middle - 0.5 * (patch.points[first] + patch.points[first + 2 * step]);
    };
    if (degree[1] == 2)
        for (int i = 0; i <= degree[0]; ++i) lift_middle(i * row, 1);
    if (degree[0] == 2)
        for (int j = 0; j <= degree[1]; ++j) lift_middle(j, row);
    const double sign = patch.points[0](3) < 0 ? -1 : 1;
    for (Eigen::Vector4d& p : patch.points) {
        p *= sign;
        if (!(p(3) > 0)) return std::nullopt;
        p.head<3>() /= p(3);
    }
    return patch;
}

// What a plane base, centre or axis is in doubles.
struct Shape {
    Vec3 point;
    Vec3 direction;  // unit; normal or axis
    double rho;
};

class PatchMaker {
public:
    PatchMaker(const Bisector& bisector, const std::array<double, 2>& u, const std::array<double, 2>& v)
        : degree_(bisector.patch_degree), u_(u), v_(v) {}

    std::optional<RationalPatch> plane(const Vec3& origin, const Vec3& normal) const {
        const Frame f(normal);
        return bezier([&](double u, double v) { return homogeneous(origin + u * f.x + v * f.y, 1); }, degree_,
                      u_, v_);
    }

    // l(p) = |p - c| - rho with l >= 0 in front: over a foot (u, v) the height is
    // (u^2 + v^2 + h^2 - rho^2) / (2 (h + rho)).
    std::optional<RationalPatch> plane_sphere(const Vec3& normal, double h, const Shape& s) const {
        const Frame f(normal);
        const Vec3 foot = s.point - h * f.z;
        return bezier(
            [&](double u, double v) {
                const double height = (u * u + v * v + (h - s.rho) * (h + s.rho)) / (2 * (h + s.rho));
                return homogeneous(foot + u * f.x + v * f.y + height * f.z, 1);
            },
            degree_, u_, v_);
    }

    // On the ray c + v d + q n from the axis: l(c) + v l.d + q l.n = q - rho.
    std::optional<RationalPatch> plane_cylinder(const Vec3& normal, double h, const Shape& c) const {
        const Frame f(c.direction, -normal);
        return bezier(
            [&](double u, double v) {
                const Vec3 n = f.normal(u);
                const double w = weight(u) - normal.dot(n);
                const double q = c.rho + h + v * normal.dot(c.direction);
                return homogeneous(w * (c.point + v * c.direction) + q * n, w);
            },
            degree_, u_, v_);
    }

    // |c1 + t n - c2| = side (t - difference): t = (|e|^2 - difference^2) / (2 (n . e - difference)).
    std::optional<RationalPatch> sphere_sphere(const Shape& p, const Shape& q, double difference) const {
        const Vec3 e = q.point - p.point;
        const Frame f(e.isZero(0) ? Vec3::UnitZ() : e);
        const double numerator = (e.norm() - difference) * (e.norm() + difference);
        return bezier(
            [&](double u, double v) {
                const Vec3 n = 2 * u * f.x + 2 * v * f.y + (1 - u * u - v * v) * f.z;
                const double w = 2 * (n.dot(e) - difference * (1 + u * u + v * v));
                return homogeneous(w * p.point + numerator * n, w);
            },
            degree_, u_, v_);
    }

    // The same across parallel axes.
    std::optional<RationalPatch> parallel_cylinders(const Shape& p, const Shape& q, double difference) const {
        const Vec3& d = p.direction;
        Vec3 e = q.point - p.point;
        e -= d * d.dot(e);
        const Frame f(d, e);
        const double numerator = (e.norm() - difference) * (e.norm() + difference);
        return bezier(
            [&](double u, double v) {
                const Vec3 n = f.normal(u);
                const double w = 2 * (n.dot(e) - difference * weight(u));
                return homogeneous(w * (p.point + v * d) + numerator * n, w);
            },
            degree_, u_, v_);
    }

    // With q the distance from the axis, |m + q n| = side (q + k), m from the sphere's centre to the axis
    // point, k = side rho_sphere - rho_cylinder: q = (m^2 - k^2) / (2 (k - m . n)).
    std::optional<RationalPatch> sphere_cylinder(const Shape& sphere, const Shape& c, int side) const {
        const Vec3& d = c.direction;
        const double k = side * sphere.rho - c.rho;
        // The foot of the centre is where v = 0.
        const Vec3 foot = c.point + d * d.dot(sphere.point - c.point), m = foot - sphere.point;
        const Frame f(d, -m);
        return bezier(
            [&](double u, double v) {
                const Vec3 n = f.normal(u);
                const double w = 2 * (k * weight(u) - m.dot(n));
                const double numerator = m.squaredNorm() + v * v - k * k;
                return homogeneous(w * (foot + v * d) + numerator * n, w);
            },
            degree_, u_, v_);
    }

    // p = c1 + s1 d1 + q1 n1 = c2 + s2 d2 + q2 n2 with q2 = q1 - difference. Along k = d1 x d2:
    // q1 (k.n1 - k.n2) = k.e - difference k.n2 with e = c2 - c1. Across d2, with f(x) = (x x d2).k / k^2,
    // f(d1) = 1: s1 = f(e) - difference f(n2) - q1 (f(n1) - f(n2)); over the common denominator the weight of
    // n2 divides out.
    std::optional<RationalPatch> crossing_cylinders(const Shape& p, const Shape& q, double difference) const {
        const Vec3 e = q.point - p.point, cross = p.direction.cross(q.direction);
        const Vec3 k = cross.dot(e) < 0 ? Vec3(-cross) : cross;
        const Frame f1(p.direction, k), f2(q.direction, -k);
        const Vec3 across = q.direction.cross(cross) / cross.squaredNorm();  // f(x) = across . x
        return bezier(
            [&](double u, double v) {
                const Vec3 n1 = f1.normal(u), n2 = f2.normal(v);
                const double w1 = weight(u), w2 = weight(v);
                const double w = k.dot(n1) * w2 - k.dot(n2) * w1;
                const double distance = k.dot(e) * w2 - difference * k.dot(n2);
                const double along = difference * (k.dot(n2) * across.dot(n1) - across.dot(n2) * k.dot(n1)) -
                                     k.dot(e) * (across.dot(n1) * w2 - across.dot(n2) * w1);
                return homogeneous(w * p.point + (across.dot(e) * w + along) * p.direction + distance * n1,
                                   w);
            },
            degree_, u_, v_);
    }

private:
    std::array<int, 2> degree_;
    std::array<double, 2> u_, v_;
};

Shape shape(const Plane& p) { return {p.point, p.normal.normalized(), 0}; }
Shape shape(const Sphere& s) { return {s.center, Vec3::Zero(), s.radius}; }
Shape shape(const Cylinder& c) { return {c.point, c.axis.normalized(), c.radius}; }
// Those have no patches.
Shape shape(const HollowSphere& s) { return {s.center, Vec3::Zero(), s.radius}; }
Shape shape(const HollowCylinder& c) { return {c.point, c.axis.normalized(), c.radius}; }
Shape shape(const HollowCone& c) { return {c.apex, c.axis.normalized(), 0}; }

// Unit normal and offset of the plane a polynomial of degree one describes.
std::pair<Vec3, double> plane_of(const Polynomial3& f) {
    Eigen::Vector4d c = Eigen::Vector4d::Zero();
    long largest = 0;
    bool first = true;
    for (const auto& term : f.terms()) {
        if (first || term.second.exponent() > largest) largest = term.second.exponent();
        first = false;
    }
    for (const auto& [e, value] : f.terms()) {
        const int slot = e[0] == 1 ? 0 : e[1] == 1 ? 1 : e[2] == 1 ? 2 : 3;
        c(slot) = value.scaled(-largest).enclosure().mid();
    }
    const double norm = c.head<3>().norm();
    return {c.head<3>() / norm, c(3) / norm};
}

}  // namespace

std::string_view to_string(BisectorKind kind) {
    switch (kind) {
        case BisectorKind::Plane: return "plane";
        case BisectorKind::PairOfPlanes: return "pair of planes";
        case BisectorKind::Paraboloid: return "paraboloid";
        case BisectorKind::CircularCone: return "circular cone";
        case BisectorKind::EllipticCone: return "elliptic cone";
        case BisectorKind::ParabolicCylinder: return "parabolic cylinder";
        case BisectorKind::HyperbolicCylinder: return "hyperbolic cylinder";
        case BisectorKind::EllipticCylinder: return "elliptic cylinder";
        case BisectorKind::CircularCylinder: return "circular cylinder";
        case BisectorKind::HyperbolicParaboloid: return "hyperbolic paraboloid";
        case BisectorKind::Hyperboloid: return "hyperboloid";
        case BisectorKind::Ellipsoid: return "ellipsoid";
        case BisectorKind::Sphere: return "sphere";
        case BisectorKind::Quartic: return "quartic";
        case BisectorKind::Line: return "line";
        case BisectorKind::Nowhere: return "nowhere";
        case BisectorKind::Everywhere: break;
    }
    return "everywhere";
}

// With l = g (D.v + rho), v along the axis and as long as the sine |a| / g, and |a|^2 = N, the centre or axis
// of a ball or cylinder is l / g - cos |D across a| away. Squared twice, with A / n the squared distance from
// it:
//
//     (g^2 N A + n (N l^2 - k))^2 = 4 g^2 N^2 n A l^2,   k = (g^2 - N) (N |D|^2 - (D.a)^2).
static Bisector of_round_in_cone(const RoundSurface& round, const HollowCone& vessel) {
    const ConeForm cone(vessel);
    const Exact &g = cone.g, &N = cone.N, &n = round.norm, g2 = g * g;
    const Polynomial3 along = Polynomial3::linear(cone.a, -dot(cone.a, cone.apex)),
                      l = along + Polynomial3(g * round.rho), A = round.squared(),
                      k = (g2 - N) * (N * RoundSurface(Sphere{vessel.apex, 0}).squared() - along * along),
                      sum = g2 * N * A + n * (N * (l * l) - k);
    const bool is_on_axis = round.is_cylinder() && cross(round.axis, cone.a).is_zero() &&
                            round.squared_at(cone.apex).sign() == Sign::Zero;
    return {is_on_axis ? BisectorKind::CircularCone : BisectorKind::Quartic,
            sum * sum - 4.0 * g2 * N * N * n * (A * (l * l)),
            {0, 0}};
}

// The distances from the centre or axis and from the vessel's have the sum of the radii as their sum, as
// where the one contains the other.
static Bisector of_round_in_vessel(const Object& base, const Object& a) {
    const bool is_base = is_vessel(base);
    const Object &vessel = is_base ? base : a, &other = is_base ? a : base;
    if (!std::holds_alternative<Sphere>(other) && !std::holds_alternative<Cylinder>(other))
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "",
                         "a vessel has bisectors with balls and cylinders alone");
    const RoundSurface round = round_surface(other);
    if (const auto* cone = std::get_if<HollowCone>(&vessel)) return of_round_in_cone(round, *cone);
    const auto* hollow = std::get_if<HollowSphere>(&vessel);
    const RoundSurface wall = hollow != nullptr
                                  ? RoundSurface(Sphere{hollow->center, hollow->radius})
                                  : RoundSurface(Cylinder{std::get<HollowCylinder>(vessel).point,
                                                          std::get<HollowCylinder>(vessel).axis,
                                                          std::get<HollowCylinder>(vessel).radius});
    Bisector b = of_rounds(round, wall, true);
    b.patch_degree = {0, 0};
    return b;
}

Bisector bisector(const Object& base, const Object& a) {
    if (is_vessel(base) || is_vessel(a)) return of_round_in_vessel(base, a);
    const auto *p = std::get_if<Plane>(&base), *q = std::get_if<Plane>(&a);
    if (p != nullptr && q != nullptr) return of_planes(ExactPlane(*p), ExactPlane(*q));
    if (p != nullptr) return of_plane_and_round(ExactPlane(*p), true, round_surface(a));
    if (q != nullptr) return of_plane_and_round(ExactPlane(*q), false, round_surface(base));
    return of_rounds(round_surface(base), round_surface(a));
}

BisectorKind bisector_kind(const Object& base, const Object& a) {
    const auto is_round = [](const Object& o) { return !is_vessel(o) && !std::holds_alternative<Plane>(o); };
    if (!is_round(base) || !is_round(a)) return bisector(base, a).kind;
    return of_rounds(round_surface(base), round_surface(a), false, AskedFor::Kind).kind;
}

std::optional<RationalPatch> bisector_patch(const Object& base, const Object& a,
                                            const std::array<double, 2>& domain_u,
                                            const std::array<double, 2>& domain_v, int sheet) {
    const Bisector b = bisector(base, a);
    if (b.patch_degree[0] == 0) return std::nullopt;
    const PatchMaker make(b, domain_u, domain_v);
    // A point of each object, to have the planes' parameters start near them.
    const Shape s = std::visit([](const auto& o) { return shape(o); }, base);
    const Shape t = std::visit([](const auto& o) { return shape(o); }, a);
    if (b.kind == BisectorKind::Plane) {
        const auto [normal, offset] = plane_of(b.polynomial);
        const Vec3 middle = 0.5 * (s.point + t.point);
        return make.plane(middle - normal * (normal.dot(middle) + offset), normal);
    }
    const bool planes = base.index() == 0 && a.index() == 0;
    if (b.kind == BisectorKind::PairOfPlanes) {
        // Both pass through the line where the planes meet, or the point where the axes do; both are
        // perpendicular to the sum or the difference of the unit directions.
        const Vec3 cross = s.direction.cross(t.direction);
        const Vec3 e = t.point - s.point;
        const Vec3 common =
            planes ? Vec3(s.point + e.dot(t.direction) / cross.squaredNorm() * cross.cross(s.direction))
                   : Vec3(s.point + e.cross(t.direction).dot(cross) / cross.squaredNorm() * s.direction);
        return make.plane(common,
                          sheet == 0 ? Vec3(s.direction - t.direction) : Vec3(s.direction + t.direction));
    }
    if (base.index() == 0 || a.index() == 0) {
        const bool plane_is_base = base.index() == 0;
        const Shape &plane = plane_is_base ? s : t, &round = plane_is_base ? t : s;
        const double h = plane.direction.dot(round.point - plane.point);
        const double side = !plane_is_base && h < 0 ? -1 : 1;
        const bool cylinder = (plane_is_base ? a : base).index() == 2;
        return cylinder ? make.plane_cylinder(side * plane.direction, side * h, round)
                        : make.plane_sphere(side * plane.direction, side * h, round);
    }
    const RoundPair pair(round_surface(base), round_surface(a));
    const double difference = pair.difference.enclosure().mid();
    if (base.index() != a.index())
        return base.index() == 1 ? make.sphere_cylinder(s, t, pair.side)
                                 : make.sphere_cylinder(t, s, pair.side);
    if (base.index() == 1) return make.sphere_sphere(s, t, difference);
    const bool parallel =
        cross(ExactVector(std::get<Cylinder>(base).axis), ExactVector(std::get<Cylinder>(a).axis)).is_zero();
    return parallel ? make.parallel_cylinders(s, t, difference) : make.crossing_cylinders(s, t, difference);
}

}  // namespace vcell
