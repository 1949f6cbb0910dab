#include "kinds.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../../core/exact.hpp"

namespace vcell::check {
namespace {

class Kinds : public Room {
public:
    using Room::Room;

    void run() {
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) check_kind(i);
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

    /// [HE, Lemmas 1-3] Planes and box sides have linear heights, spheres paraboloids about the base's
    /// normal.
    std::vector<CurveKind> kinds_over_plane(std::size_t i) const {
        using enum CurveKind;
        const auto& sites = cell_.edges[i].sites;
        if (rim_[i]) {
            const Site& owner = sites[uses_[i][0].reversed];
            return is_linear(owner)   ? std::vector{Line}
                   : as_sphere(owner) ? std::vector{Parabola}
                                      : std::vector<CurveKind>{};
        }
        if (is_linear(sites[0]) && is_linear(sites[1])) return {Line};
        const Sphere *a = as_sphere(sites[0]), *b = as_sphere(sites[1]);
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

    /// Bisectors with planes and spheres are planes, or surfaces of revolution with the base's centre as
    /// focus: two of them meet in a plane, in a circle if they share the axis.
    std::vector<CurveKind> kinds_over_sphere(const std::array<Site, 2>& sites) const {
        using enum CurveKind;
        const auto& base = std::get<Sphere>(scene_.base);
        const auto is_flat = [&](const Site& s) {
            return !s.is_object() || (as_sphere(s) && as_sphere(s)->radius == base.radius);
        };
        const auto axis = [&](const Site& s) -> Vec3 {
            if (!s.is_object()) return Vec3::Unit(static_cast<int>(s.index / 2));
            if (const Sphere* sphere = as_sphere(s)) return (sphere->center - base.center).normalized();
            return std::get<Plane>(scene_.objects[s.index]).normal.normalized();
        };
        if (is_flat(sites[0]) && is_flat(sites[1])) return {Line};
        for (const Site& s : sites)
            if (!is_linear(s) && !as_sphere(s)) return {};
        if (axis(sites[0]).cross(axis(sites[1])).norm() > kRounding) return {Ellipse, Parabola, Hyperbola};
        return {Circle, Ellipse};
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
        // A small one's points have few digits.
        const double tolerance = kPlaceRounding * (1 + geometry_.scale() / left);
        switch (kind) {
            case CurveKind::Parabola:
                return std::abs(k - 1) < tolerance;
            case CurveKind::Hyperbola:
                return k > 1 - tolerance;
            case CurveKind::Circle:
                return std::abs(left - right) <= rounding() && std::abs(k - cosine * cosine) <= tolerance;
            default:
                return k < 1 + tolerance;
        }
    }
};

}  // namespace

void certify_kinds(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Kinds(subject, options, certificate).run();
}

}  // namespace vcell::check
