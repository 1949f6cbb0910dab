#include "kinds.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../../core/numbers/exact.hpp"
#include "bisector_names.hpp"

namespace vcell::check {
namespace {

class Kinds : public Room {
public:
    using Room::Room;

    void run() {
        for (const std::uint32_t i : subject_.edges) check_kind(i);
    }

private:
    /// The kind must be one that the two sites can have, and fit the control points. Between a kind and its
    /// limit (a flat ellipse and a parabola) rounding leaves the control points undecided.
    void check_kind(std::size_t i) {
        const CurveKind kind = cell_.edges[i].kind;
        const auto where = [i] { return edge_path(i) + ".kind"; };
        if (const auto kinds = possible_kinds(i);
            !kinds.empty() && std::ranges::find(kinds, kind) == kinds.end())
            return note(where(), fmt::format("is {}, the sites meet in another kind ({})", to_string(kind),
                                             to_string(kinds[0])));
        for (const auto& piece : edge_pieces_[i])
            if (!fits(kind, piece, full_error(i)))
                return note(where(), fmt::format("is {}, the control points disagree", to_string(kind)));
    }

    bool is_linear(const Site& s) const {
        return !s.is_object() || std::holds_alternative<Plane>(scene_.objects[s.index]);
    }
    const Sphere* as_sphere(const Site& s) const {
        return s.is_object() ? std::get_if<Sphere>(&scene_.objects[s.index]) : nullptr;
    }
    /// Over a plane a hollow sphere's height is that of a ball whose radius is less than 0, upside down.
    std::optional<Sphere> as_signed_sphere(const Site& s) const {
        if (!s.is_object()) return std::nullopt;
        if (const Sphere* ball = as_sphere(s)) return *ball;
        const auto* vessel = std::get_if<HollowSphere>(&scene_.objects[s.index]);
        return vessel ? std::optional(Sphere{vessel->center, -vessel->radius}) : std::nullopt;
    }

    /// Empty: no opinion. Where only exact arithmetic on the canonical scene could tell a kind from its
    /// limit, both.
    std::vector<CurveKind> possible_kinds(std::size_t i) const {
        if (geometry_.is_plane()) return kinds_over_plane(i);
        if (geometry_.is_sphere()) return kinds_over_sphere(cell_.edges[i].sites);
        const auto is_flat = [](const Site& s) { return !s.is_object(); };
        using enum CurveKind;
        if (std::ranges::all_of(cell_.edges[i].sites, is_flat)) return {Line};
        // Nearly a pair of lines, it may be a spline.
        if (std::ranges::all_of(cell_.edges[i].sites, [&](const Site& s) { return is_linear(s); }))
            return {Ellipse, Hyperbola, Parabola, Circle, Line, Spline};
        return {};
    }

    /// In what a vessel's wall meets a base plane. A tube's rim may be written as what it is or as a spline;
    /// where only exact arithmetic on the canonical scene knows that a tube is upright or level, it may be an
    /// ellipse.
    std::vector<CurveKind> kinds_on_base(const Site& wall) const {
        using enum CurveKind;
        const Object& vessel = scene_.objects[wall.index];
        if (std::holds_alternative<HollowSphere>(vessel)) return {Circle};
        if (const auto* cone = std::get_if<HollowCone>(&vessel)) return kinds_on_base(*cone);
        const std::string name = bisector_names(scene_, wall, geometry_.scale())[0];
        if (name == "elliptic cone") return {Ellipse, Spline};
        return {name == "circular cone" ? Circle : Line, Ellipse, Spline};
    }

    /// The base cuts a cone in an ellipse where its normal leans less from the axis than it would from a line
    /// of the wall, and in a hyperbola where it leans more, or in lines through the apex.
    std::vector<CurveKind> kinds_on_base(const HollowCone& cone) const {
        using enum CurveKind;
        const Vec3 normal = std::get<Plane>(scene_.base).normal.normalized(), axis = cone.axis.normalized();
        const double lean = std::abs(normal.dot(axis)) - cone.sine();
        if (std::abs(lean) <= kRounding) return {Ellipse, Parabola, Hyperbola, Spline};
        if (lean < 0 && std::abs(geometry_.height(cone.apex)) <= geometry_.rounding())
            return {Line, Hyperbola, Spline};
        if (lean < 0) return {Hyperbola, Spline};
        if (normal.cross(axis).norm() <= kRounding) return {Circle, Ellipse, Spline};
        return {Ellipse, Spline};
    }

    /// [HE, Lemmas 1-3] Planes and box sides have linear heights, spheres paraboloids about the base's
    /// normal.
    std::vector<CurveKind> kinds_over_plane(std::size_t i) const {
        using enum CurveKind;
        const auto& sites = cell_.edges[i].sites;
        if (rim_[i]) {
            const Site& owner = sites[uses_[i][0].reversed];
            if (rim_[i]->is_object()) return kinds_on_base(*rim_[i]);
            return is_linear(owner)          ? std::vector{Line}
                   : as_signed_sphere(owner) ? std::vector{Parabola}
                                             : std::vector<CurveKind>{};
        }
        if (is_linear(sites[0]) && is_linear(sites[1])) return {Line};
        const std::optional<Sphere> a = as_signed_sphere(sites[0]), b = as_signed_sphere(sites[1]);
        if ((!a && !is_linear(sites[0])) || (!b && !is_linear(sites[1]))) return {};
        const auto& base = std::get<Plane>(scene_.base);
        int axis = 0;
        base.normal.cwiseAbs().maxCoeff(&axis);
        const int x = (axis + 1) % 3, y = (axis + 2) % 3;
        const bool aligned = base.normal[x] == 0 && base.normal[y] == 0;
        if (!a || !b) {
            if (!aligned) return {Ellipse, Circle};
            const Site& linear = a ? sites[1] : sites[0];
            const bool horizontal = linear.is_object()
                                        ? std::get<Plane>(scene_.objects[linear.index]).normal[x] == 0 &&
                                              std::get<Plane>(scene_.objects[linear.index]).normal[y] == 0
                                        : static_cast<int>(linear.index / 2) == axis;
            return {horizontal ? Circle : Ellipse};
        }
        // Equal sums of height and radius: the paraboloids are congruent and meet over a line.
        const double za = a->center[axis] - base.point[axis], zb = b->center[axis] - base.point[axis];
        if (!aligned || Exact(a->center[axis]) - Exact(base.point[axis]) != Exact(za) ||
            Exact(b->center[axis]) - Exact(base.point[axis]) != Exact(zb))
            return {Parabola, Ellipse, Circle};
        const Exact up(base.normal[axis] > 0 ? 1.0 : -1.0);
        if (up * Exact(za) + Exact(a->radius) == up * Exact(zb) + Exact(b->radius)) return {Parabola};
        return {a->center[x] == b->center[x] && a->center[y] == b->center[y] ? Circle : Ellipse};
    }

    /// From a sphere's centre on, points at the distance t from it are as far from a sphere or a plane where
    /// a.p + d t = k: a sphere's centre and the difference of the radii, or a plane's normal, away from the
    /// base, and its length; a side of the box is the plane of its normal, with d = 0.
    struct Bisector {
        std::array<Exact, 3> a;
        Exact d;  // of a plane, its square
        bool has_root = false;
    };

    std::optional<Bisector> bisector(const Site& s) const {
        const auto& base = std::get<Sphere>(scene_.base);
        if (!s.is_object()) {
            const Vec3 n = Vec3::Unit(static_cast<int>(s.index / 2));
            return Bisector{{n[0], n[1], n[2]}, 0.0};
        }
        Bisector b;
        const auto from_centre = [&](const Vec3& p, int i) { return Exact(p[i]) - Exact(base.center[i]); };
        if (const Sphere* sphere = as_sphere(s)) {
            for (int i = 0; i < 3; ++i) b.a[static_cast<std::size_t>(i)] = from_centre(sphere->center, i);
            b.d = Exact(sphere->radius) - Exact(base.radius);
            return b;
        }
        // |p - c| = R + R0 - t of a vessel.
        if (const auto* vessel = std::get_if<HollowSphere>(&scene_.objects[s.index])) {
            for (int i = 0; i < 3; ++i) b.a[static_cast<std::size_t>(i)] = -from_centre(vessel->center, i);
            b.d = Exact(vessel->radius) + Exact(base.radius);
            return b;
        }
        const auto* plane = std::get_if<Plane>(&scene_.objects[s.index]);
        if (!plane) return std::nullopt;
        Exact offset;
        for (int i = 0; i < 3; ++i) {
            const Exact n(plane->normal[i]);
            b.a[static_cast<std::size_t>(i)] = n;
            offset += n * from_centre(plane->point, i);
            b.d += n * n;
        }
        if (offset.sign() == Sign::Negative)
            for (Exact& n : b.a) n = -n;
        b.has_root = true;
        return b;
    }

    /// The same in intervals, of balls and sides of the box, which are most: what decides most kinds.
    struct RoughBisector {
        Vector<Interval> a;
        Interval d;  // 0 where it is
    };
    std::optional<RoughBisector> rough_bisector(const Site& s) const {
        const auto& base = std::get<Sphere>(scene_.base);
        if (!s.is_object())
            return RoughBisector{to_vector<Interval>(Vec3::Unit(static_cast<int>(s.index / 2))), 0.0};
        const Sphere* sphere = as_sphere(s);
        if (!sphere) return std::nullopt;
        return RoughBisector{
            to_vector<Interval>(sphere->center) - to_vector<Interval>(base.center),
            sphere->radius == base.radius ? Interval(0.0) : Interval(sphere->radius) - base.radius};
    }
    /// None: it takes exact numbers to tell.
    std::optional<CurveKind> rough_kind(const std::array<Site, 2>& sites) const {
        const auto p = rough_bisector(sites[0]), q = rough_bisector(sites[1]);
        if (!p || !q) return std::nullopt;
        if (p->d.magnitude() == 0 && q->d.magnitude() == 0) return CurveKind::Line;
        const Interval across = square(cross(p->a, q->a));
        if (!(across.lower() > 0)) return std::nullopt;
        const Interval steep = across - square(p->d * q->a - q->d * p->a);
        if (steep.upper() < 0) return CurveKind::Ellipse;
        if (steep.lower() > 0) return CurveKind::Hyperbola;
        return std::nullopt;
    }

    static Exact dot(const std::array<Exact, 3>& p, const std::array<Exact, 3>& q) {
        return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    }

    /// Two bisectors a.p + d t = k, b.p + e t = l meet in the plane of normal n = e a - d b. In it t is
    /// linear, of slope |a x b| / |n|: below 1 for an ellipse, 0 for a circle. Exact, but for the kinds next
    /// to a parabola where a plane's length has a root.
    std::vector<CurveKind> kinds_over_sphere(const std::array<Site, 2>& sites) const {
        using enum CurveKind;
        if (const auto kind = rough_kind(sites)) return {*kind};
        const auto p = bisector(sites[0]), q = bisector(sites[1]);
        if (!p || !q) return {};
        const auto is_flat = [](const Bisector& b) { return b.d.sign() == Sign::Zero; };
        if (is_flat(*p) && is_flat(*q)) return {Line};
        const Exact aa = dot(p->a, p->a), bb = dot(q->a, q->a), ab = dot(p->a, q->a);
        const Exact across = aa * bb - ab * ab;
        if (across.sign() == Sign::Zero) return {Circle};
        // |n|^2 = e^2 |a|^2 - 2 d e a.b + d^2 |b|^2
        Sign steep;
        if (p->has_root && q->has_root) {
            steep = Sign::Negative;  // sin^2 < 2 - 2 cos of the angle between the normals
        } else {
            const Bisector &plane = p->has_root ? *p : *q, &other = p->has_root ? *q : *p;
            const Exact &n2 = p->has_root ? aa : bb, &c2 = p->has_root ? bb : aa;
            const Exact d2 = plane.has_root ? plane.d : plane.d * plane.d, e = other.d;
            const Exact rational = across - e * e * n2 - d2 * c2, root = (e * ab).scaled(1);
            steep =
                plane.has_root ? sign(OneRoot{rational, root, plane.d}) : (rational + root * plane.d).sign();
            // The cell's plane has a length in doubles.
            if (plane.has_root && steep != Sign::Zero) {
                const Interval gap = rational.enclosure() + root.enclosure() * sqrt(plane.d.enclosure());
                const Interval scale = (across + e * e * n2 + d2 * c2).enclosure();
                if (!(gap.magnitude() > kRounding * scale.upper())) return {Ellipse, Parabola, Hyperbola};
            }
        }
        return {steep == Sign::Negative ? Ellipse : steep == Sign::Zero ? Parabola : Hyperbola};
    }

    /// Can a piece with these control points be of that kind, up to rounding? [Farin02, 12.4]: w1^2 / (w0 w2)
    /// is below, at or above 1 for an ellipse, a parabola, a hyperbola; for a circle the legs are equal and
    /// its root is the cosine of their angle with the chord.
    bool fits(CurveKind kind, const Bezier<3>& piece, double error) const {
        const Vec3 a = piece.control(0), b = piece.control(piece.points.size() - 1), m = piece.control(1);
        if (kind == CurveKind::Spline) return true;
        if (kind == CurveKind::Line) {
            const Vec3 chord = b - a;
            for (std::size_t k = 1; k + 1 < piece.points.size(); ++k)
                if ((piece.control(k) - a).cross(chord).norm() > (rounding() + error) * chord.norm())
                    return false;
            return true;
        }
        if (piece.degree() != 2) return false;
        const double k = piece.weight(1) * piece.weight(1) / (piece.weight(0) * piece.weight(2));
        const double left = (m - a).norm(), right = (b - m).norm(), cosine = 0.5 * (b - a).norm() / left;
        if (left == 0 && right == 0) return true;  // what is written as one point has no shape
        // A small one's points have few digits.
        const double tolerance = kPlaceRounding * (1 + geometry_.scale() / left);
        switch (kind) {
            case CurveKind::Parabola: return std::abs(k - 1) < tolerance;
            case CurveKind::Hyperbola: return k > 1 - tolerance;
            case CurveKind::Circle:
                return std::abs(left - right) <= rounding() && std::abs(k - cosine * cosine) <= tolerance;
            default: return k < 1 + tolerance;
        }
    }
};

}  // namespace

void certify_kinds(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Kinds(subject, options, certificate).run();
}

}  // namespace vcell::check
