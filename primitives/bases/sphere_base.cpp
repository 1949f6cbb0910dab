#include "sphere_base.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <variant>

#include "../../core/numbers/compensated.hpp"
#include "../charts/sphere_chart.hpp"
#include "../objects/message.hpp"
#include "radial_objects.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

// ---- Heights that are linear in u -------------------------------------------------------------------

// f = -(p.u + s) / w
struct LinearHeight {
    ExactVector p;
    Exact s, w;
};

// The base sphere and its chart; u = rotation n / W.
struct SphereFrame {
    Vec3 center;
    double radius;
    IntegerRotation rotation;

    // rotation.matrix^T p
    ExactVector turned(const ExactVector& p) const {
        const auto column = [&](int j) {
            return p.x * rotation.matrix(0, j) + p.y * rotation.matrix(1, j) + p.z * rotation.matrix(2, j);
        };
        return {column(0), column(1), column(2)};
    }

    LinearHeight height(const Ball& ball) const {
        const ExactVector c = ExactVector(Vec3(ball.cx, ball.cy, ball.cz)) - ExactVector(center);
        const Exact delta = Exact(ball.rho) - radius;
        return {c, delta, (dot(c, c) - delta * delta).scaled(-1)};
    }
    LinearHeight height(const HalfSpace& h) const {
        return {ExactVector(Vec3(-h.n)), h.length, h(ExactVector(center)) + Exact(radius) * h.length};
    }
    LinearHeight height(const WorldSide& side) const {
        return {ExactVector(side.normal()), Exact(), side.distance(center)};
    }
    // That of the ball with the radius -R, with all signs turned.
    LinearHeight height(const HollowSphere& vessel) const {
        const ExactVector way = ExactVector(center) - ExactVector(vessel.center);
        const Exact reach = Exact(vessel.radius) + radius;
        return {way, reach, (reach * reach - dot(way, way)).scaled(-1)};
    }
    LinearHeight cap(double probe) const { return {ExactVector(), 1.0, Exact(radius) + probe}; }

    // With P = matrix^T p and N = norm, p.u = (2 P0 x + 2 P1 y + P2 (1 - x^2 - y^2)) / (N W).
    ExactForm form(const LinearHeight& h) const {
        const ExactVector P = turned(h.p);
        const Exact s = rotation.norm * h.s;
        return {P.z - s, -2.0 * P.x, -2.0 * P.y, -(P.z + s), rotation.norm * h.w};
    }

    // C = |c|^2 - delta^2 of cylinder_form.hpp's cylinder, times N^2 to be free of denominators.
    RadialForm form(const CylinderForm& f) const { return form(f, Exact(f.rho) - radius, 1.0); }
    // A vessel is the tube with the radius -rho; C and B are negative then, and turned.
    RadialForm hollow_form(const CylinderForm& f) const {
        RadialForm hollow = form(f, -(Exact(f.rho) + radius), -1.0);
        hollow.is_hollow = true;
        return hollow;
    }

private:
    RadialForm form(const CylinderForm& f, const Exact& delta, const Exact& side) const {
        const ExactVector p = ExactVector(Vec3(f.px, f.py, f.pz)) - ExactVector(center),
                          a(Vec3(f.ax, f.ay, f.az));
        const Exact length2 = dot(a, a), along = dot(p, a);
        const Exact n = rotation.norm, n2 = n * n;
        const ExactVector b = side * n * turned(length2 * p - along * a), turned_a = turned(a);
        return {{side * n2 * (length2 * (dot(p, p) - delta * delta) - along * along), Exact(), Exact()},
                side * n2 * length2 * delta,
                Exact(),
                {b.x, b.y, b.z},
                {turned_a.x, turned_a.y, turned_a.z}};
    }
};

// The coefficients divided by |K|, if that is not zero. Of coefficients within 1.45 u the quotients are
// within 4 u.
CircularForm scaled_form(double K, double A, double B, double C, double W) {
    const double scale = K == 0 ? 1 : std::abs(K);
    CircularForm f;
    const Eigen::Array4d quotients = Eigen::Array4d(A, B, C, W) / scale;
    f.k = K / scale;
    f.a = quotients[0];
    f.b = quotients[1];
    f.e = quotients[2];
    f.w = quotients[3];
    return f;
}

CircularForm rounded(const ExactForm& f) {
    // What underflows must not look like zero.
    const auto round = [](const Exact& x) {
        const double y = nearest(x);
        return y != 0 ? y : static_cast<int>(x.sign()) * std::numeric_limits<double>::denorm_min();
    };
    return scaled_form(round(f.K), round(f.A), round(f.B), round(f.C), round(f.W));
}

// c - center and rho - R0, each a high part plus a low one. The high parts are multiples of one unit, at most
// 2^25 of it: of such numbers, four products with each other or with integers up to 2^26 have an exact sum
// [Rump, Ogita, Oishi, Accurate floating-point summation I, section 3]. The low ones are at most 2^-24 of
// `size`, rounded once.
struct SplitBall {
    Eigen::Array4d high, low;
    double size;  // the largest of the four

    SplitBall(const Ball& ball, const Vec3& center, double radius) {
        const Eigen::Array4d x(ball.cx, ball.cy, ball.cz, ball.rho),
            y(center.x(), center.y(), center.z(), radius);
        const Eigen::Array4d d = x - y, z = d - x;
        size = d.abs().maxCoeff();
        const double shift = 0x1p28 * size;
        high = (d + shift) - shift;
        low = ((x - (d - z)) - (y + z)) + (d - high);
    }
    // Neither overflows nor underflows matter.
    bool is_moderate() const { return size >= 0x1p-300 && size <= 0x1p300; }
};
struct BallDifferences {
    std::array<Difference, 3> c;
    Difference delta;

    BallDifferences(const Ball& ball, const Vec3& center, double radius)
        : c{Difference(ball.cx, center.x()), Difference(ball.cy, center.y()),
            Difference(ball.cz, center.z())},
          delta(ball.rho, radius) {}

    CompensatedSum<> power() const {
        CompensatedSum<> C;
        for (const Difference& x : c) C.add_square(1, x);
        C.add_square(-1, delta);
        return C;
    }
};

// C of a ball. If it is certain, the high part has at most 52 bits and the sum is within u / 8, otherwise
// within 1.01 u.
struct BallPower {
    double high, low;
    bool is_certain;

    double value() const { return high + low; }
};

BallPower ball_power(const Ball& ball, const SphereFrame& frame) {
    const SplitBall d(ball, frame.center, frame.radius);
    const Eigen::Array4d squares = d.high * d.high, rest = (2 * d.high + d.low) * d.low;
    const BallPower C{squares.head<3>().sum() - squares[3], rest.head<3>().sum() - rest[3], true};
    // Rounding leaves less than 2^-18 u of the size in the low part.
    if (d.is_moderate() && std::abs(C.value()) >= 0x1p-15 * d.size * d.size) return C;
    const auto c = BallDifferences(ball, frame.center, frame.radius).power().value();
    return {c ? *c : 2 * nearest(frame.height(ball).w), 0, false};
}

// SphereFrame::form() of balls and sides of the box in sums, where they suffice: first of split balls, with
// the ball's power C found before.

std::optional<CircularForm> split_form(const Ball& ball, const BallPower& C, const SphereFrame& frame) {
    const SplitBall d(ball, frame.center, frame.radius);
    const Eigen::Matrix3d& m = frame.rotation.matrix;
    const double norm = frame.rotation.norm;
    if (!(norm <= 0x1p26)) return std::nullopt;
    const Vec3 high = m.transpose() * d.high.head<3>().matrix(),
               low = m.transpose() * d.low.head<3>().matrix();
    const double P0 = high[0] + low[0], P1 = high[1] + low[1];
    const double K = (high[2] - norm * d.high[3]) + (low[2] - norm * d.low[3]);
    const double minus_C = (high[2] + norm * d.high[3]) + (low[2] + norm * d.low[3]);
    // Each is within u, and 2^-19 u of this for the rounding of the low parts.
    const double size = norm * d.size;
    if (!(std::min({std::abs(P0), std::abs(P1), std::abs(K), std::abs(minus_C)}) >= 0x1p-16 * size))
        return std::nullopt;
    const Halves<> halves(C.high);
    const double W = norm * halves.high + (norm * halves.low + norm * C.low);
    return scaled_form(K, -2 * P0, -2 * P1, -minus_C, 0.5 * W);
}

std::optional<CircularForm> compensated_form(const Ball& ball, const SphereFrame& frame) {
    using Four = Eigen::Array4d;
    const BallDifferences d(ball, frame.center, frame.radius);
    const double norm = frame.rotation.norm;
    // P0, P1, K and -C side by side.
    CompensatedSum<Four> sums;
    for (int k = 0; k < 3; ++k) {
        const auto row = frame.rotation.matrix.row(k);
        sums.add(Halves<Four>(Four(row[0], row[1], row[2], row[2])), d.c[k]);
    }
    sums.add(Halves<Four>(Four(0, 0, -norm, norm)), d.delta);
    const auto f = sums.value();
    const auto w = d.power().times(norm).value();
    if (!f || !w) return std::nullopt;
    return scaled_form((*f)[2], -2 * (*f)[0], -2 * (*f)[1], -(*f)[3], 0.5 * *w);
}

CircularForm rounded_form(const Ball& ball, const BallPower& C, const SphereFrame& frame) {
    if (C.is_certain)
        if (const auto f = split_form(ball, C, frame)) return *f;
    if (const auto f = compensated_form(ball, frame)) return *f;
    return rounded(frame.form(frame.height(ball)));
}

CircularForm rounded_form(const WorldSide& side, const SphereFrame& frame) {
    CompensatedSum<> distance;
    distance.add(Halves<>(frame.rotation.norm), Difference(side.bound, frame.center[side.axis]));
    const auto w = distance.value();
    if (!w) return rounded(frame.form(frame.height(side)));
    const Vec3 P = side.sign * frame.rotation.matrix.row(side.axis).transpose();
    return scaled_form(P.z(), -2 * P.x(), -2 * P.y(), -P.z(), side.sign * *w);
}

// A coefficient of a form is zero only if it is exactly zero.
bool is_in_range(double coefficient) {
    const double size = std::abs(coefficient);
    return (size >= smallest_coefficient && size <= 1 / smallest_coefficient) || size == 0;
}

[[noreturn]] void fail_range(Site site, const Scene& scene) {
    const std::string what =
        "is so close to the base, or so nearly opposite to its chart's pole, that its height leaves the "
        "range of "
        "doubles";
    if (site.is_object())
        throw InputError(Kind::OutOfRange, site.index, object_path(scene, scene.place(site.index)), what);
    throw InputError(Kind::OutOfRange, InputError::no_object, "box", "side " + to_string(site) + " " + what);
}

// ---- The problem ------------------------------------------------------------------------------------

// What the forms are made of, for those who ask for their exact coefficients.
struct FormSources {
    enum class Kind : std::uint8_t { Ball, Plane, Side, Cap };
    struct Source {
        Kind kind;
        std::uint32_t index;  // of `balls` or `planes`, or as in Site::box_side()
    };
    SphereFrame frame;
    Box box;
    std::vector<Ball> balls;
    std::vector<ExactForm> planes;  // and vessels
    std::optional<double> probe;
    IdVector<FormId, Source> forms;

    ExactForm exact(FormId f) const {
        const Source& source = forms[f];
        if (source.kind == Kind::Plane) return planes[source.index];
        if (source.kind == Kind::Cap) return frame.form(frame.cap(*probe));
        return frame.form(source.kind == Kind::Ball ? frame.height(balls[source.index])
                                                    : frame.height(WorldSide(box, source.index)));
    }
};

class SphereProblem {
public:
    SphereProblem(const Scene& scene, const Sphere& base, double unit, std::optional<double> probe)
        : scene_(scene), unit_(unit), probe_(probe), frame_{base.center, base.radius, {}}, objects_(scene) {}

    RadialBaseProblem build() {
        check_box();
        objects_.balls.reserve(scene_.objects.size());
        powers_.reserve(scene_.objects.size());
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            if (scene_.competes(i))
                std::visit([&](const auto& object) { add(i, object); }, scene_.objects[i]);
        objects_.drop_hidden_and_equal({});
        merge_mirrored_balls();
        merge_planelike_balls();
        choose_chart();
        return make_problem();
    }

private:
    // Rays start in the centre.
    void check_box() const {
        for (std::uint32_t s = 0; s < 6; ++s) {
            const WorldSide side(scene_.box, s);
            // Exact numbers cost more than all else here, and are asked for next to a side only.
            const auto by_interval = (side.sign * (Interval(side.bound) - frame_.center[side.axis])).sign();
            const Sign room = by_interval ? *by_interval : side.distance(frame_.center).sign();
            if (room == Sign::Positive) continue;
            fail_empty("does not contain the base sphere's centre (base.sphere): it lies " +
                       std::string(room == Sign::Zero ? "on" : "beyond") + " side " +
                       to_string(Site::box_side(s)));
        }
    }

    void add(std::uint32_t i, const Sphere& sphere) {
        const Ball ball{sphere.center.x(), sphere.center.y(), sphere.center.z(), sphere.radius};
        const BallPower C = ball_power(ball, frame_);
        if (!(C.value() > 0)) {
            const bool same = ball.rho == frame_.radius && sphere.center == frame_.center;
            objects_.fail(Kind::TouchesBase, i,
                          same                        ? "is the base itself"
                          : ball.rho >= frame_.radius ? "contains the base"
                                                      : "lies in the base");
        }
        objects_.balls.add(ball, i);
        powers_.push_back(C);
    }

    void add(std::uint32_t i, const Plane& plane) {
        const ExactVector center(frame_.center);
        HalfSpace h(plane.point, plane.normal);
        if (h(center).sign() == Sign::Negative) h = -h;
        const ExactVector n(h.n);
        const Exact value = h(center), reach = Exact(frame_.radius) * frame_.radius * dot(n, n);
        const Sign clearance = (value * value - reach).sign();
        if (clearance != Sign::Positive) {
            const Vec3 place = frame_.center - h.n * (nearest(value) / nearest(h.length) / nearest(h.length));
            objects_.fail(Kind::TouchesBase, i,
                          std::string(cuts_or_touches(clearance)) + " the base at " + to_text(unit_ * place));
        }
        objects_.planes.add(h, i);
    }

    void add(std::uint32_t i, const Cylinder& cylinder) {
        const Vec3 a = scaled_axis(cylinder.axis), &p = cylinder.point;
        const CylinderForm form{p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), cylinder.radius};
        // Independent of the chart, which is still the identity.
        if (frame_.form(form).c[0].sign() != Sign::Positive)
            objects_.fail(Kind::TouchesBase, i,
                          cylinder.radius >= frame_.radius
                              ? "contains the base"
                              : "runs through the base so near to its centre that base and cylinder have no "
                                "bisector all around");
        objects_.cylinders.add(form, i);
    }

    // Beyond the wall, with all of it, the base would have no bisector.
    void add(std::uint32_t i, const HollowSphere& vessel) {
        refuse_probe(i);
        if (frame_.height(vessel).w.sign() != Sign::Positive) fail_beyond_wall(i);
        objects_.hollow_balls.add(vessel, i);
    }

    void add(std::uint32_t i, const HollowCylinder& vessel) {
        refuse_probe(i);
        const Vec3 a = scaled_axis(vessel.axis), &p = vessel.point;
        const CylinderForm form{p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), vessel.radius};
        if (frame_.hollow_form(form).c[0].sign() != Sign::Positive) fail_beyond_wall(i);
        objects_.hollow_cylinders.add(form, i);
    }

    [[noreturn]] void fail_beyond_wall(std::uint32_t i) const {
        objects_.fail(Kind::TouchesBase, i, "has all of the base beyond its wall");
    }
    void refuse_probe(std::uint32_t i) const {
        if (probe_) objects_.fail(Kind::Unsupported, i, "is a vessel, and with a probe there is none");
    }

    // A ball of the base's radius, mirrored to it by a side of the box, has that side as its bisector.
    void merge_mirrored_balls() {
        for (std::size_t i = 0; i < objects_.balls.size(); ++i) {
            const Ball& ball = objects_.balls.items[i];
            if (ball.rho != frame_.radius || !objects_.is_kept(objects_.balls.objects[i])) continue;
            const Vec3 c(ball.cx, ball.cy, ball.cz);
            if ((c.array() == frame_.center.array()).count() < 2) continue;
            for (std::uint32_t s = 0; s < 6; ++s) {
                const WorldSide side(scene_.box, s);
                Vec3 beside = c;
                beside[side.axis] = frame_.center[side.axis];
                if (beside != frame_.center) continue;
                if (Exact(c[side.axis]) + frame_.center[side.axis] == 2.0 * Exact(side.bound))
                    side_twin_[s] = objects_.balls.objects[i];
            }
        }
    }

    // A huge ball can have the very height of a plane whose |n| has been rounded down: a plane's C is
    // proportional to |n| - rounded |n|.
    void merge_planelike_balls() {
        if (objects_.planes.size() == 0) return;
        for (std::size_t i = 0; i < objects_.balls.size(); ++i) {
            const Ball& ball = objects_.balls.items[i];
            const double size = ball.rho - frame_.radius;
            if (powers_[i].value() > 0x1p-40 * size * size || !objects_.is_kept(objects_.balls.objects[i]))
                continue;
            const std::array<Exact, 5> of_ball = ray(frame_.height(ball));
            for (std::size_t k = 0; k < objects_.planes.size(); ++k)
                if (objects_.is_kept(objects_.planes.objects[k]) &&
                    compare_rays(of_ball, ray(frame_.height(objects_.planes.items[k]))) == 0)
                    objects_.merge(objects_.balls.objects[i], objects_.planes.objects[k]);
        }
    }
    static std::array<Exact, 5> ray(const LinearHeight& h) { return {h.p.x, h.p.y, h.p.z, h.s, h.w}; }

    void choose_chart() {
        Nearness nearness;
        nearness.linear.reserve(objects_.balls.size() + objects_.planes.size() + 6);
        const Vec3& center = frame_.center;
        const double radius = frame_.radius;
        for (std::size_t i = 0; i < objects_.balls.size(); ++i) {
            if (!objects_.is_kept(objects_.balls.objects[i])) continue;
            const Ball& b = objects_.balls.items[i];
            const double scale = 2 / powers_[i].value();
            const Vec3 p(scale * (b.cx - center.x()), scale * (b.cy - center.y()),
                         scale * (b.cz - center.z()));
            nearness.linear.push_back({p, scale * (b.rho - radius)});
        }
        for (std::size_t i = 0; i < objects_.planes.size(); ++i) {
            if (!objects_.is_kept(objects_.planes.objects[i])) continue;
            const HalfSpace& h = objects_.planes.items[i];
            const double scale = 1 / nearest(frame_.height(h).w);
            nearness.linear.push_back({-scale * h.n, scale * nearest(h.length)});
        }
        for (std::uint32_t s = 0; s < 6; ++s) {
            if (side_twin_[s] != RadialObjects::none) continue;
            const WorldSide side(scene_.box, s);
            nearness.linear.push_back({Vec3::Unit(side.axis) / (side.bound - center[side.axis]), 0});
        }
        if (probe_) nearness.linear.push_back({Vec3::Zero(), 1 / (radius + *probe_)});
        for (std::size_t i = 0; i < objects_.hollow_balls.size(); ++i) {
            if (!objects_.is_kept(objects_.hollow_balls.objects[i])) continue;
            const HollowSphere& vessel = objects_.hollow_balls.items[i];
            const double scale = 1 / nearest(frame_.height(vessel).w);
            nearness.linear.push_back({scale * (center - vessel.center), scale * (vessel.radius + radius)});
        }
        for (std::size_t i = 0; i < objects_.hollow_cylinders.size(); ++i) {
            if (!objects_.is_kept(objects_.hollow_cylinders.objects[i])) continue;
            const CylinderForm& f = objects_.hollow_cylinders.items[i];
            const Vec3 way = center - Vec3(f.px, f.py, f.pz), axis = Vec3(f.ax, f.ay, f.az).normalized();
            const double length2 = f.ax * f.ax + f.ay * f.ay + f.az * f.az;
            nearness.cylindrical.push_back({way - axis * axis.dot(way), axis, f.rho + radius,
                                            nearest(frame_.hollow_form(f).c[0]) / length2, true});
        }
        for (std::size_t i = 0; i < objects_.cylinders.size(); ++i) {
            if (!objects_.is_kept(objects_.cylinders.objects[i])) continue;
            const CylinderForm& f = objects_.cylinders.items[i];
            const Vec3 p = Vec3(f.px, f.py, f.pz) - center, axis = Vec3(f.ax, f.ay, f.az).normalized();
            const double length2 = f.ax * f.ax + f.ay * f.ay + f.az * f.az;
            nearness.cylindrical.push_back(
                {p - axis * axis.dot(p), axis, f.rho - radius, nearest(frame_.form(f).c[0]) / length2});
        }
        const auto rotation = chart_rotation(nearness);
        if (!rotation)
            throw UndecidedError(
                "no direction from the base sphere (base.sphere) has one object nearest in it by a margin "
                "that "
                "doubles can see");
        frame_.rotation = *rotation;
        for (std::size_t i = 0; i < objects_.hollow_cylinders.size(); ++i)
            if (objects_.is_kept(objects_.hollow_cylinders.objects[i]))
                refuse_tips(objects_.hollow_cylinders.objects[i], nearness);
    }

    // Where the bisector with a hollow cylinder comes to its axis it has a tip. Nothing later on is made for
    // one that shows.
    void refuse_tips(std::uint32_t i, const Nearness& nearness) const {
        constexpr double margin = 1 + 0x1p-20;  // far more than rounding
        const CylinderForm& f = objects_.hollow_cylinders.of(i);
        const Vec3 axis = Vec3(f.ax, f.ay, f.az).normalized(), p = Vec3(f.px, f.py, f.pz) - frame_.center,
                   foot = p - axis * axis.dot(p);
        const double reach = f.rho + frame_.radius,
                     along = std::sqrt((reach - foot.norm()) * (reach + foot.norm()));
        for (const double side : {-1.0, 1.0}) {
            const Vec3 u = (foot + side * along * axis) / reach;
            bool is_hidden = false;
            for (const auto& h : nearness.linear)
                is_hidden = is_hidden || (h.p.dot(u) + h.s) * reach > margin;
            for (const auto& h : nearness.cylindrical)
                is_hidden = is_hidden || nearness_of(h, u) * reach > margin;
            if (!is_hidden)
                objects_.fail(
                    Kind::Unsupported, i,
                    "is as near to the base as to its own axis, where no object nor side of the box "
                    "is nearer: the cell would have a tip at " +
                        to_text(unit_ * Vec3(frame_.center + reach * u)));
        }
    }

    RadialBaseProblem make_problem() {
        const std::size_t n = scene_.objects.size();
        FoundForms found(scene_);
        const auto sources =
            std::make_shared<FormSources>(FormSources{frame_, scene_.box, {}, {}, probe_, {}});
        RadialBaseProblem problem;
        IdVector<FormId, CircularForm>& forms = problem.family.forms;
        sources->forms.reserve(n + 6);
        forms.reserve(n + 6);
        const auto add = [&](Site site, const Object& canonical, const CircularForm& f,
                             FormSources::Source source) {
            if (!(is_in_range(f.a) && is_in_range(f.b) && is_in_range(f.e) && is_in_range(f.w)))
                fail_range(site, scene_);
            found.add(site, canonical);
            forms.push_back(f);
            sources->forms.push_back(source);
        };
        using Kind = FormSources::Kind;
        std::uint32_t next_ball = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            if (!scene_.competes(i)) continue;
            const auto* sphere = std::get_if<Sphere>(&scene_.objects[i]);
            const std::uint32_t k = sphere != nullptr ? next_ball++ : 0;
            if (!objects_.is_kept(i)) continue;
            const Site site = objects_.site(i);
            if (sphere != nullptr) {
                add(site, Sphere{sphere->center - frame_.center, sphere->radius},
                    rounded_form(objects_.balls.items[k], powers_[k], frame_), {Kind::Ball, k});
            } else if (const auto* plane = std::get_if<Plane>(&scene_.objects[i])) {
                const auto place = static_cast<std::uint32_t>(sources->planes.size());
                sources->planes.push_back(frame_.form(frame_.height(objects_.planes.of(i))));
                add(site, Plane{plane->point - frame_.center, plane->normal}, rounded(sources->planes.back()),
                    {Kind::Plane, place});
            } else if (const auto* vessel = std::get_if<HollowSphere>(&scene_.objects[i])) {
                const auto place = static_cast<std::uint32_t>(sources->planes.size());
                sources->planes.push_back(frame_.form(frame_.height(*vessel)));
                add(site, HollowSphere{vessel->center - frame_.center, vessel->radius},
                    rounded(sources->planes.back()), {Kind::Plane, place});
            }
        }
        for (std::uint32_t s = 0; s < 6; ++s) {
            const Site site = Site::box_side(s);
            if (side_twin_[s] != RadialObjects::none) {
                found.join(site, found.of_object[objects_.owner(side_twin_[s])]);
                continue;
            }
            const WorldSide side(scene_.box, s);
            const Vec3 foot = (side.bound - frame_.center[side.axis]) * Vec3::Unit(side.axis);
            add(site, Plane{foot, side.normal()}, rounded_form(side, frame_), {Kind::Side, s});
        }
        if (probe_)
            add(Site::cap(), Sphere{Vec3::Zero(), frame_.radius + *probe_},
                rounded(frame_.form(frame_.cap(*probe_))), {Kind::Cap, 0});
        sources->balls = std::move(objects_.balls.items);

        const auto add_tubes = [&]<class Tube>(const auto& tubes, std::type_identity<Tube>, auto form) {
            for (std::size_t k = 0; k < tubes.size(); ++k) {
                const std::uint32_t i = tubes.objects[k];
                if (!objects_.is_kept(i)) continue;
                const auto& tube = std::get<Tube>(scene_.objects[i]);
                found.add(objects_.site(i), Tube{tube.point - frame_.center, tube.axis, tube.radius});
                problem.family.radial.push_back(form(tubes.items[k]));
            }
        };
        add_tubes(objects_.cylinders, std::type_identity<Cylinder>{},
                  [&](const auto& tube) { return frame_.form(tube); });
        add_tubes(objects_.hollow_cylinders, std::type_identity<HollowCylinder>{},
                  [&](const auto& tube) { return frame_.hollow_form(tube); });
        found.add_twins(objects_);
        problem.frame.origin = frame_.center;
        problem.unit = unit_;
        problem.moved = problem.moved_apart = moved_by_lengths(scene_);
        problem.chart = {BaseShape::Sphere, frame_.radius, frame_.rotation.matrix / frame_.rotation.norm};
        problem.family.chart = problem.chart;
        problem.family.exact = [sources](FormId f) { return sources->exact(f); };
        objects_.warn(found.sites, problem.warnings);
        problem.sites = std::move(found.sites);
        problem.objects = std::move(found.objects);
        return problem;
    }

    const Scene& scene_;
    const double unit_;
    const std::optional<double> probe_;
    SphereFrame frame_;
    RadialObjects objects_;
    std::vector<BallPower> powers_;  // of objects_.balls
    std::array<std::uint32_t, 6> side_twin_{RadialObjects::none, RadialObjects::none, RadialObjects::none,
                                            RadialObjects::none, RadialObjects::none, RadialObjects::none};
};

}  // namespace

RadialBaseProblem sphere_base_problem(const Scene& scene, const Sphere& base, double unit,
                                      std::optional<double> probe) {
    return SphereProblem(scene, base, unit, probe).build();
}

}  // namespace vcell
