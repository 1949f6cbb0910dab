/// The frame of a cylinder base and the forms over it: exact, but for the turn of the base's axis.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "../objects/exact_motion.hpp"
#include "radial_objects.hpp"

namespace vcell::cylinder_forms {

// Where the axis of the base comes nearest to that of a tube, as both are given: base.point + along / square
// d.
struct AxesCrossing {
    ExactVector d, e;  // directions: of the base, of the tube
    ExactVector across, way;
    Exact square, along;

    AxesCrossing(const Cylinder& base, const Cylinder& tube)
        : d(scaled_axis(base.axis)),
          e(scaled_axis(tube.axis)),
          across(cross(d, e)),
          way(ExactVector(tube.point) - ExactVector(base.point)),
          square(dot(across, across)),
          along(dot(cross(way, e), across)) {}
    // Do they meet there, and nowhere else?
    bool is_one() const { return !across.is_zero() && dot(way, across).sign() == Sign::Zero; }
};

// canonical = rotation . (world - origin) / norm. What objects are to each other stays exact; the base's axis
// turns by a few 2^-53 to become the y axis, or not at all where its length is a double.
struct CylinderFrame {
    Vec3 along;  // scaled: what becomes the y axis, but for rounding
    Vec3 axis;   // the same, noise rounded to zero
    Vec3 origin;
    ExactRotation rotation;
    const Exact& norm;
    double turn;  // of the base's axis

    CylinderFrame(const Scene& scene, const Cylinder& base)
        : along(direction(scene, base)),
          axis(without_noise(along)),
          origin(base.point),
          rotation(axis, 1),
          norm(rotation.norm),
          turn(rotation.turn(scaled_axis(base.axis), 1)) {
        const Box& box = scene.box;
        const Vec3 center = 0.5 * box.min + 0.5 * box.max;
        Eigen::Index k = 0;
        axis.cwiseAbs().maxCoeff(&k);
        if ((axis.array() != 0).count() == 1) {
            origin[k] = center[k];
        } else {
            // In the base's point no rounding leaves the axis.
            const Vec3 unit = axis.normalized();
            const double away = unit.dot(center - base.point);
            if (std::abs(away) > box.diagonal()) origin += away * unit;
        }
    }
    CylinderFrame(const CylinderFrame&) = delete;
    CylinderFrame& operator=(const CylinderFrame&) = delete;

    // A rotation in doubles, from a quaternion that is nearly a half turn, say.
    static constexpr double bundle_rounding = 0x1p-48;
    // The tubes of a bundle about the base that was turned in doubles have one direction and lean towards the
    // base by its rounding: where three of them tie along a line, strips would be as narrow. As the base
    // turns anyhow it turns to the first direction that three of these have in common, unless there are tubes
    // along it. Fewer lean as they do.
    static Vec3 direction(const Scene& scene, const Cylinder& base) {
        const Vec3 own = scaled_axis(base.axis), axis = without_noise(own);
        if (ExactRotation(axis, 1).turn(own, 1) == 0) return own;
        constexpr int fewest = 3;
        std::vector<std::pair<Vec3, int>> leaning;  // directions, and how many tubes have them
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            const auto* tube = std::get_if<Cylinder>(&scene.objects[i]);
            if (tube == nullptr || !scene.competes(i)) continue;
            const ExactVector d(scaled_axis(tube->axis)), across = cross(d, ExactVector(own));
            if (across.is_zero()) return own;
            const double sine = Vec3(nearest(across.x), nearest(across.y), nearest(across.z)).norm() /
                                (scaled_axis(tube->axis).norm() * own.norm());
            if (!(sine < bundle_rounding)) continue;
            const auto same = std::ranges::find_if(
                leaning, [&](const auto& known) { return cross(d, ExactVector(known.first)).is_zero(); });
            if (same == leaning.end())
                leaning.emplace_back(scaled_axis(tube->axis), 1);
            else
                ++same->second;
        }
        const auto bundle =
            std::ranges::find_if(leaning, [](const auto& known) { return known.second >= fewest; });
        if (bundle == leaning.end()) return own;
        // A tube's axis points to either side, that of the base to end:+.
        return bundle->first.dot(own) < 0 ? Vec3(-bundle->first) : bundle->first;
    }
    // A cosine of pi/2 in a direction that was turned in doubles is no lean: the base would end on sides of
    // the box that it runs along. The base turns with its frame anyhow, by about as much, and `turn` counts
    // it.
    static Vec3 without_noise(Vec3 axis) {
        const double size = axis.cwiseAbs().maxCoeff();
        for (double& component : axis)
            if (std::abs(component) < frame_rounding * size) component = 0;
        return axis;
    }

    // Doubles see of most tubes that they have another radius than the base, or an axis that does not cross
    // the base's.
    static bool may_cross_equally(const Cylinder& base, const Cylinder& tube) {
        constexpr double certain = 0x1p-40;  // far more than rounding
        if (tube.radius != base.radius) return false;
        const Vec3 across = scaled_axis(base.axis).cross(scaled_axis(tube.axis));
        return !across.isZero(0) && std::abs((tube.point - base.point).dot(across)) <=
                                        certain * (tube.point.norm() + base.point.norm());
    }
    // Where its axis crosses the base's as it is given: a height over the base, rounded.
    std::optional<double> crossing(const Cylinder& base, const Cylinder& tube) const {
        if (!may_cross_equally(base, tube)) return std::nullopt;
        const AxesCrossing at(base, tube);
        if (!at.is_one()) return std::nullopt;
        return nearest(height(base, at)) / nearest(at.square * norm);
    }
    // That height is multiplied by at.square and norm.
    Exact height(const Cylinder& base, const AxesCrossing& at) const {
        return at.square * turned(from_origin(base.point)).y + at.along * turned(at.d).y;
    }

    // norm times the rotation of p.
    ExactVector turned(const ExactVector& p) const { return rotation(p); }
    ExactVector from_origin(const Vec3& p) const { return ExactVector(p) - ExactVector(origin); }

    // Takes what turned() returns to doubles, divided by norm.
    Vec3 rounded(const ExactVector& p) const { return rotation.rounded(p); }
    BaseFrame rounded() const {
        BaseFrame frame;
        frame.rotation = rotation.rounded();
        frame.origin = origin;
        return frame;
    }
};

// A side of the box from the origin of the frame: normal.p <= norm distance.
struct Side {
    Site site;
    ExactVector normal;  // turned
    Exact distance;

    Exact across2() const { return normal.x * normal.x + normal.z * normal.z; }
    bool is_along_axis() const { return normal.y.sign() == Sign::Zero; }
    Side operator-() const { return {site, {-normal.x, -normal.y, -normal.z}, -distance}; }
    bool is_across_axis() const { return normal.x.sign() == Sign::Zero && normal.z.sign() == Sign::Zero; }
};

struct CylinderForms {
    const CylinderFrame& frame;
    double radius;  // of the base

    // The forms of the header, by powers of `norm` free of denominators. Of balls times norm:
    RadialForm form(const Ball& ball) const { return form(ball, Exact(ball.rho) - radius); }
    RadialForm form(const Ball& ball, const Exact& delta) const {
        const ExactVector c = frame.from_origin({ball.cx, ball.cy, ball.cz}), p = frame.turned(c);
        return {{frame.norm * (dot(c, c) - delta * delta), -2.0 * p.y, frame.norm},
                frame.norm * delta,
                Exact(),
                {p.x, Exact(), p.z},
                {}};
    }
    // Times 2 norm:
    RadialForm form(const HalfSpace& h) const {
        const ExactVector n = frame.turned(ExactVector(h.n));
        const Exact value = h(ExactVector(frame.origin)) + Exact(radius) * h.length;
        return {{2.0 * frame.norm * value, 2.0 * n.y, Exact()},
                frame.norm * h.length,
                Exact(),
                {-n.x, Exact(), -n.z},
                {}};
    }
    RadialForm form(const Side& side) const {
        const ExactVector& n = side.normal;
        return {{2.0 * frame.norm * side.distance, -2.0 * n.y, Exact()},
                Exact(),
                Exact(),
                {n.x, Exact(), n.z},
                {}};
    }
    // That of a ball with the radius -R, with all signs turned.
    RadialForm form(const HollowSphere& vessel) const {
        const Vec3& c = vessel.center;
        RadialForm f = turned_signs(form(Ball{c.x(), c.y(), c.z(), 0}, -(Exact(vessel.radius) + radius)));
        f.is_hollow = true;
        return f;
    }
    // Times norm^2, as A is times norm.
    RadialForm form(const CylinderForm& f) const { return form(f, Exact(f.rho) - radius); }
    // A vessel is the tube with the radius -rho; C and B are negative then, and turned.
    RadialForm hollow_form(const CylinderForm& f) const {
        RadialForm hollow = turned_signs(form(f, -(Exact(f.rho) + radius)));
        hollow.is_hollow = true;
        return hollow;
    }
    /// Is C positive all over a stretch?
    static bool is_positive(const std::array<Exact, 3>& c, const std::array<double, 2>& stretch) {
        for (const double y : stretch)
            if ((c[0] + y * (c[1] + y * c[2])).sign() != Sign::Positive) return false;
        const Exact slope0 = c[1] + 2.0 * Exact(stretch[0]) * c[2],
                    slope1 = c[1] + 2.0 * Exact(stretch[1]) * c[2];
        if (slope0.sign() != Sign::Negative || slope1.sign() != Sign::Positive) return true;
        return (4.0 * c[0] * c[2] - c[1] * c[1]).sign() == Sign::Positive;
    }
    /// Does a tube that is thinner than the base pierce that, its axis nearer to the base's than radii
    /// differ? C is less than 0 between two places then, and the bisector has tips.
    static bool has_two_roots(const std::array<Exact, 3>& c) {
        return c[2].sign() == Sign::Positive && (4.0 * c[0] * c[2] - c[1] * c[1]).sign() == Sign::Negative;
    }
    static RadialForm turned_signs(RadialForm f) {
        for (Exact& c : f.c) c = -c;
        for (Exact& b : f.b) b = -b;
        f.b0 = -f.b0;
        f.slope = -f.slope;
        return f;
    }
    // radial_form.hpp's equation of a cone, times g^4 sin^2 norm^2, as sphere_forms.hpp has it, with the way
    // from the apex to the axis point over y in the place of that to the centre.
    RadialForm hollow_form(const ConeForm& f) const {
        if (is_along_base(f.axis)) return hollow_along_base(f);
        const ExactVector D = ExactVector(frame.origin) - f.apex, way = frame.turned(D),
                          axis = frame.turned(f.a);
        const Exact &n = frame.norm, &g = f.g, &N = f.N, n2 = n * n, rest = N * (g * g - N),
                    along = dot(D, f.a), rho(radius), lean = g * along + N * rho, rise = g * axis.y;
        const ExactVector b = n * (rest * way - (g * lean) * axis);
        RadialForm hollow{{n2 * (lean * lean - rest * (dot(D, D) - rho * rho)),
                           2.0 * n * (lean * rise - rest * way.y), rise * rise - n2 * rest},
                          n2 * N * g * (along + g * rho),
                          -rise,
                          {b.x, Exact(), b.z},
                          {g * axis.x, Exact(), g * axis.z}};
        hollow.is_hollow = true;
        hollow.a0 = -(n * N);
        return hollow;
    }
    // The cone's axis turns with that of the base to (0, +-rim, 0), |axis| being 1 then, in lengths that are
    // times T.
    RadialForm hollow_along_base(const ConeForm& f) const {
        const ExactVector D = ExactVector(frame.origin) - f.apex;
        const Exact length2 = dot(f.axis, f.axis), T = frame.norm * length2, &g = f.slant, N = f.rim * f.rim;
        const ExactVector near = frame.turned(length2 * D - dot(D, f.axis) * f.axis);
        const Exact y = length2 * frame.turned(D).y, rise = points_along(f.axis) ? g * f.rim : -(g * f.rim),
                    rho = T * radius, rest = N * (g * g - N), lean = rise * y + N * rho;
        RadialForm hollow{{lean * lean - rest * (near.x * near.x + near.z * near.z + y * y - rho * rho),
                           2.0 * T * (lean * rise - rest * y), T * T * (rise * rise - rest)},
                          T * N * (rise * y + g * g * rho),
                          -(T * rise),
                          {T * rest * near.x, Exact(), T * rest * near.z},
                          {}};
        hollow.is_hollow = true;
        hollow.a0 = -(T * N);
        return hollow;
    }
    RadialForm form(const CylinderForm& f, const Exact& delta) const {
        const ExactVector p = frame.from_origin({f.px, f.py, f.pz}), a = direction(f);
        const Exact length2 = dot(a, a), along = dot(p, a);
        const ExactVector axis = frame.turned(a), near = frame.turned(length2 * p - along * a);
        if (is_along_base(f)) return along_base(near, frame.norm * length2, delta);
        const Exact &n = frame.norm, n2 = n * n;
        const ExactVector b = n * near;
        return {{n2 * (length2 * (dot(p, p) - delta * delta) - along * along), -2.0 * b.y,
                 n2 * length2 - axis.y * axis.y},
                n2 * length2 * delta,
                axis.y,
                {b.x, Exact(), b.z},
                {axis.x, Exact(), axis.z}};
    }
    // Two tubes of one radius whose axes cross are equally near in two planes through there, across that of
    // the axes and half way between their directions. They are walls, with normals that point away from the
    // base's axis above the crossing, or below it: as they are given, whatever the base's axis turns by, and
    // lengths of directions told by two doubles.
    std::array<Side, 2> walls_of_crossing(Site site, const Cylinder& base, const Cylinder& tube,
                                          bool is_above) const {
        const AxesCrossing at(base, tube);
        const Exact sense(is_above ? 1.0 : -1.0);
        const ExactVector from = frame.from_origin(base.point), e = length_of(at.d) * at.e,
                          d = sense * length_of(at.e) * at.d;
        const auto wall = [&](const ExactVector& n) {
            return Side{site, frame.turned(at.square * n),
                        at.square * dot(n, from) + at.along * dot(n, at.d)};
        };
        return {wall(e - d), wall(Exact(-1.0) * e - d)};
    }
    // About the line through near / scale along y, as with an axis (0, scale, 0).
    static RadialForm along_base(const ExactVector& near, const Exact& scale, const Exact& delta) {
        const Exact square = scale * scale;
        return {{near.x * near.x + near.z * near.z - square * delta * delta, Exact(), Exact()},
                square * delta,
                scale,
                {scale * near.x, Exact(), scale * near.z},
                {}};
    }
    // This form leaves out how the axis turned, which all but keeps lengths: so F of find_axial_ties() is a
    // linear image of what it is in the world. Pre: along the base.
    RadialForm linear_image(const CylinderForm& f, const Exact& delta) const {
        const ExactVector p = frame.from_origin({f.px, f.py, f.pz}), a = direction(f);
        const Exact length2 = dot(a, a), along = dot(p, a);
        const ExactVector b = frame.turned(length2 * p - along * a);
        const Exact& n = frame.norm;
        return {{n * (length2 * (dot(p, p) - delta * delta) - along * along), Exact(), Exact()},
                n * length2 * delta,
                Exact(),
                {b.x, Exact(), b.z},
                {}};
    }
    // What has no root has no A either, and nothing but C changes along the axis.
    static bool is_same_along_axis(const RadialForm& f) {
        return !f.has_root() && f.c[1].sign() == Sign::Zero && f.c[2].sign() == Sign::Zero;
    }
    // Is f nowhere nearer than g, and not equally near everywhere? Pre: both are the same all along the axis.
    // Q = 2 B / C of g is more than that of f by (D W + V.n) times 2 / (C C'), which is no less than D - |V|
    // times 2 W / (C C').
    static bool is_nowhere_nearer(const RadialForm& f, const RadialForm& g) {
        const Exact D = g.b0 * f.c[0] - f.b0 * g.c[0], x = g.b[0] * f.c[0] - f.b[0] * g.c[0],
                    z = g.b[2] * f.c[0] - f.b[2] * g.c[0];
        return D.sign() == Sign::Positive && (D * D - x * x - z * z).sign() != Sign::Negative;
    }
    static ExactVector direction(const CylinderForm& f) { return ExactVector(Vec3(f.ax, f.ay, f.az)); }

    // Parallel to what the base's axis turns to, before or after rounding.
    bool is_along_base(const CylinderForm& f) const { return is_along_base(direction(f)); }
    bool is_along_base(const ExactVector& a) const {
        const ExactVector image = frame.turned(a);
        return (image.x.sign() == Sign::Zero && image.z.sign() == Sign::Zero) ||
               cross(a, ExactVector(frame.along)).is_zero();
    }

    // The one way, or the other way? Pre: along the base.
    bool points_along(const ExactVector& a) const {
        return dot(a, ExactVector(frame.along)).sign() == Sign::Positive;
    }

    // The chart is turned about the axis, u = chart n / W, by an angle that no input favours: a symmetric
    // scene's trisectors would run along the seams of the chart. Its half angle has the tangent turn_sine /
    // turn_cosine.
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
            return std::array<Exact, 3>{m(0, 0) * v[0] + m(2, 0) * v[2], Exact(),
                                        m(0, 2) * v[0] + m(2, 2) * v[2]};
        };
        RadialForm out{f.c,       norm * norm * f.b0, norm * f.slope, turn(f.b),
                       turn(f.a), f.is_hollow,        norm * f.a0};
        for (Exact& c : out.c) c = norm * norm * c;
        for (Exact& b : out.b) b = norm * b;
        return out;
    }
};

}  // namespace vcell::cylinder_forms
