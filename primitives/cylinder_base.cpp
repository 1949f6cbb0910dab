#include "cylinder_base.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "message.hpp"
#include "radial_objects.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

// Rows x, y, z with y along the axis.
BaseFrame canonical_frame(const Cylinder& base, const Box& box) {
    BaseFrame frame;
    frame.rotation.setZero();
    Vec3 axis = base.axis;
    Eigen::Index k = 0;
    const double size = axis.cwiseAbs().maxCoeff(&k);
    for (double& component : axis)
        if (std::abs(component) < frame_rounding * size) component = 0;
    const Vec3 center = 0.5 * box.min + 0.5 * box.max;
    const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;
    if (axis[i] == 0 && axis[j] == 0) {
        // Rows (e_j, e_k, e_i) are a cyclic shift; with -e_k the other two change places.
        const bool up = axis[k] > 0;
        frame.rotation(0, up ? j : i) = 1;
        frame.rotation(1, k) = up ? 1 : -1;
        frame.rotation(2, up ? i : j) = 1;
        frame.origin = base.point;
        frame.origin[k] = center[k];
        return frame;
    }
    const Vec3 unit = (axis / size).normalized();
    // The coordinate axis farthest from the base's gives the best conditioned cross product. It becomes the
    // last row: that has two zeros in signed permutations only.
    Eigen::Index least = 0;
    unit.cwiseAbs().minCoeff(&least);
    const Vec3 e3 = Vec3::Unit(least).cross(unit).normalized();
    frame.rotation.row(0) = unit.cross(e3);
    frame.rotation.row(1) = unit;
    frame.rotation.row(2) = e3;
    frame.origin = base.point + unit * unit.dot(center - base.point);
    return frame;
}

class CylinderProblem {
public:
    CylinderProblem(const Scene& scene, const Cylinder& base)
        : scene_(scene),
          frame_(canonical_frame(base, scene.box)),
          radius_(base.radius),
          box_(canonical_box(scene.box, frame_)),
          stretch_(stretch()),
          objects_(scene) {}

    RadialBaseProblem build() {
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            std::visit([&](const auto& object) { add(i, object); }, scene_.objects[i]);
        // In an oblique frame images are not exact, and neither are ties with them.
        std::vector<std::pair<CylinderForm, Site>> mirrored;
        if (frame_.is_axis_parallel())
            for (const BoxSide& side : box_)
                if (side.m.y() == 0)
                    mirrored.push_back(
                        {{2 * side.k * side.m.x(), 0, 2 * side.k * side.m.z(), 0, 1, 0, radius_},
                         Site::box_side(side.index)});
        objects_.drop_hidden_and_equal(mirrored);
        return make_problem();
    }

private:
    // In box diagonals. A line that runs into a side obliquely has no clearance there: distances just before are all
    // but 0 on one side of it only.
    static constexpr double least_end_radius = 0x1p-34;

    // m.y y + R |(m.x, m.z)| <= k for all sides, R = R0 or the least radius of such a circle.
    std::array<double, 2> stretch() const {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        const double radius = std::max(radius_, least_end_radius * scene_.box.diagonal());
        std::array<double, 2> range{-infinity, infinity};
        for (const BoxSide& side : box_) {
            const Exact x = side.m.x(), z = side.m.z(), r = side.m.y() == 0 ? radius_ : radius;
            const Exact across2 = r * r * (x * x + z * z);
            if (side.m.y() == 0) {
                const Sign beyond = (across2 - Exact(side.k) * side.k).sign();
                const bool on_side = side.k == 0 && radius_ == 0;
                if (side.k < 0 || beyond == Sign::Positive || on_side)
                    fail_empty("contains no circle of the base cylinder (base.cylinder): it " +
                               std::string(on_side ? "lies on side " : "reaches beyond side ") +
                               to_string(Site::box_side(side.index)));
                continue;
            }
            // Axis-parallel, the stretch ends on the side itself.
            const bool is_end = across2.sign() == Sign::Zero && std::abs(side.m.y()) == 1;
            const Interval end = is_end
                                     ? Interval(side.k / side.m.y())
                                     : (Interval(side.k) - sqrt(across2.enclosure())) / Interval(side.m.y());
            if (side.m.y() > 0)
                range[1] = std::min(range[1], end.lower());
            else
                range[0] = std::max(range[0], end.upper());
        }
        if (!(range[0] < range[1])) fail_empty("contains no stretch of the base cylinder (base.cylinder)");
        return range;
    }

    void add(std::uint32_t i, const Sphere& sphere) {
        const Vec3 c = frame_.to_canonical(sphere.center);
        const Ball ball{c.x(), c.y(), c.z(), sphere.radius};
        const RadialForm f = form(ball);
        if (!is_positive(f.c))
            objects_.fail(Kind::TouchesBase, i,
                          ball.rho >= radius_ ? "contains a cross section of the base" : "lies in the base");
        // B / W is largest in the ball's direction: the distance of its centre from the axis, plus delta.
        const Exact across2 = f.b[0] * f.b[0] + f.b[2] * f.b[2];
        if (f.b0.sign() != Sign::Positive && (across2 - f.b0 * f.b0).sign() != Sign::Positive)
            objects_.leave_out_unmet(i);
        else
            objects_.balls.add(ball, i);
    }

    // Clear of the solid cylinder over the stretch: of the circles at both ends, on one side.
    void add(std::uint32_t i, const Plane& plane) {
        const Vec3 p = frame_.to_canonical(plane.point), n = frame_.rotation * plane.normal;
        HalfSpace h(p, n);
        if (h({Exact(), stretch_[0], Exact()}).sign() == Sign::Negative) h = -h;
        const Exact x = h.n.x(), z = h.n.z(), r = radius_;
        const Exact across2 = r * r * (x * x + z * z);
        for (const double y : stretch_) {
            const Exact value = h({Exact(), y, Exact()});
            const Sign clearance =
                value.sign() == Sign::Negative ? Sign::Negative : (value * value - across2).sign();
            if (clearance == Sign::Positive) continue;
            const double across = std::hypot(h.n.x(), h.n.z());
            const Vec3 toward =
                across > 0 ? Vec3(-radius_ / across * Vec3(h.n.x(), 0, h.n.z())) : Vec3::Zero();
            objects_.fail(Kind::TouchesBase, i,
                          std::string(cuts_or_touches(clearance)) + " the base at " +
                              to_text(frame_.to_world(Vec3(0, y, 0) + toward)));
        }
        objects_.planes.add(h, i);
    }

    void add(std::uint32_t i, const Cylinder& cylinder) {
        const Vec3 p = frame_.to_canonical(cylinder.point);
        Vec3 a = frame_.rotation * scaled_axis(cylinder.axis);
        if (!frame_.is_axis_parallel())
            for (double& component : a)
                if (std::abs(component) < frame_rounding) component = 0;
        const CylinderForm cylinder_form{p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), cylinder.radius};
        if (!is_positive(form(cylinder_form).c))
            objects_.fail(
                Kind::TouchesBase, i,
                cylinder.radius >= radius_
                    ? "contains a cross section of the base"
                    : "lies in the base, or runs through it so near to its axis that base and cylinder "
                      "have no bisector all around");
        objects_.cylinders.add(cylinder_form, i);
    }

    // Is c0 + c1 y + c2 y^2, convex, positive all over the stretch?
    bool is_positive(const std::array<Exact, 3>& c) const {
        for (const double y : stretch_)
            if ((c[0] + y * (c[1] + y * c[2])).sign() != Sign::Positive) return false;
        const Exact slope0 = c[1] + 2.0 * Exact(stretch_[0]) * c[2],
                    slope1 = c[1] + 2.0 * Exact(stretch_[1]) * c[2];
        if (slope0.sign() != Sign::Negative || slope1.sign() != Sign::Positive) return true;
        return (4.0 * c[0] * c[2] - c[1] * c[1]).sign() == Sign::Positive;
    }

    RadialForm form(const Ball& ball) const {
        const Exact x = ball.cx, y = ball.cy, z = ball.cz, delta = Exact(ball.rho) - radius_;
        return {{x * x + y * y + z * z - delta * delta, -2.0 * y, 1.0}, delta, Exact(), {x, Exact(), z}, {}};
    }
    // Twice B and C of the header.
    RadialForm form(const HalfSpace& h) const {
        return {{2.0 * (h.d + Exact(radius_) * h.length), 2.0 * h.n.y(), Exact()},
                h.length,
                Exact(),
                {-h.n.x(), Exact(), -h.n.z()},
                {}};
    }
    RadialForm form(const BoxSide& side) const {
        return {{2.0 * side.k, -2.0 * side.m.y(), Exact()},
                Exact(),
                Exact(),
                {side.m.x(), Exact(), side.m.z()},
                {}};
    }
    RadialForm form(const CylinderForm& f) const {
        const ExactVector p(Vec3(f.px, f.py, f.pz)), a(Vec3(f.ax, f.ay, f.az));
        const Exact length2 = dot(a, a), along = dot(p, a), delta = Exact(f.rho) - radius_;
        const ExactVector b = length2 * p - along * a;
        return {{length2 * (dot(p, p) - delta * delta) - along * along, 2.0 * (along * a.y - length2 * p.y),
                 length2 - a.y * a.y},
                length2 * delta,
                a.y,
                {b.x, Exact(), b.z},
                {a.x, Exact(), a.z}};
    }

    // The chart is turned about the axis, u = chart n / W, by an angle that no input favours: a symmetric scene's
    // trisectors would run along the seams of the chart. Its half angle has the tangent turn_sine / turn_cosine.
    static constexpr double turn_sine = 773, turn_cosine = 2048;
    static constexpr double turn_norm = turn_cosine * turn_cosine + turn_sine * turn_sine;

    // turn_norm times the rotation.
    static Eigen::Matrix3d chart() {
        const double c = turn_cosine * turn_cosine - turn_sine * turn_sine, s = 2 * turn_cosine * turn_sine;
        Eigen::Matrix3d m;
        m << c, 0, s, 0, turn_norm, 0, -s, 0, c;
        return m;
    }

    // The form in the turned chart, its equation times turn_norm^2 to be free of denominators.
    static RadialForm turned(const RadialForm& f) {
        const Eigen::Matrix3d m = chart();
        const Exact norm = turn_norm;
        const auto turn = [&](const std::array<Exact, 3>& v) {
            return std::array<Exact, 3>{m(0, 0) * v[0] + m(2, 0) * v[2], Exact(), m(0, 2) * v[0] + m(2, 2) * v[2]};
        };
        RadialForm out{f.c, norm * norm * f.b0, norm * f.slope, turn(f.b), turn(f.a)};
        for (Exact& c : out.c) c = norm * norm * c;
        for (Exact& b : out.b) b = norm * b;
        return out;
    }

    RadialBaseProblem make_problem() {
        RadialBaseProblem problem;
        const std::size_t n = scene_.objects.size();
        FoundForms found(n);
        std::vector<std::array<Exact, 6>> rays;  // of rational heights, and whose they are
        std::vector<FormId> ray_forms;
        const auto add = [&](Site site, const Object& canonical, RadialForm f) {
            // With balls C is quadratic in y and no other rational height's is.
            if (!f.has_root() && !std::holds_alternative<Sphere>(canonical)) {
                const std::array<Exact, 6> ray{f.c[0], f.c[1], f.c[2], f.b0, f.b[0], f.b[2]};
                for (std::size_t k = 0; k < rays.size(); ++k) {
                    if (compare_rays(ray, rays[k]) != 0) continue;
                    found.join(site, ray_forms[k]);
                    return;
                }
                rays.push_back(ray);
                ray_forms.push_back(FormId{static_cast<std::uint32_t>(found.sites.size())});
            }
            found.add(site, canonical);
            problem.family.radial.push_back(turned(f));
        };
        for (std::uint32_t i = 0; i < n; ++i) {
            if (!objects_.is_kept(i)) continue;
            const Site site = Site::object(i);
            if (std::holds_alternative<Sphere>(scene_.objects[i])) {
                const Ball& b = objects_.balls.of(i);
                add(site, Sphere{{b.cx, b.cy, b.cz}, b.rho}, form(b));
            } else if (const auto* plane = std::get_if<Plane>(&scene_.objects[i])) {
                add(site, Plane{frame_.to_canonical(plane->point), frame_.rotation * plane->normal},
                    form(objects_.planes.of(i)));
            } else {
                const CylinderForm& f = objects_.cylinders.of(i);
                add(site, Cylinder{{f.px, f.py, f.pz}, {f.ax, f.ay, f.az}, f.rho}, form(f));
            }
        }
        for (const BoxSide& side : box_)
            if (side.m.x() != 0 || side.m.z() != 0)
                add(Site::box_side(side.index), Plane{side.k * side.m, side.m}, form(side));
        found.add_twins(objects_);
        problem.frame = frame_;
        problem.is_sphere = false;
        problem.radius = radius_;
        problem.stretch = stretch_;
        problem.family.chart = RadialChart::HalfAngle;
        problem.chart = chart() / turn_norm;
        objects_.warn(found.sites, problem.warnings);
        problem.sites = std::move(found.sites);
        problem.objects = std::move(found.objects);
        return problem;
    }

    const Scene& scene_;
    const BaseFrame frame_;
    const double radius_;
    const std::array<BoxSide, 6> box_;
    const std::array<double, 2> stretch_;
    RadialObjects objects_;
};

}  // namespace

RadialBaseProblem cylinder_base_problem(const Scene& scene, const Cylinder& base) {
    return CylinderProblem(scene, base).build();
}

}  // namespace vcell
