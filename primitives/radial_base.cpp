#include "radial_base.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <variant>

#include "../core/compensated.hpp"
#include "../core/errors.hpp"
#include "base_problem.hpp"
#include "exact_space.hpp"
#include "message.hpp"
#include "nested_balls.hpp"
#include "solids.hpp"
#include "sphere_chart.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;
constexpr std::uint32_t none = UINT32_MAX;

[[noreturn]] void fail_empty(const std::string& what) {
    throw InputError(Kind::EmptyBox, InputError::no_object, "box", what);
}

// ---- The objects of a scene -------------------------------------------------------------------------

// n.p + d > 0 on the base's side. `length` is |n|, rounded correctly.
struct HalfSpace {
    Vec3 n;
    Exact d;
    double length;
};

Exact value_at(const HalfSpace& h, const ExactVector& p) { return dot(ExactVector(h.n), p) + h.d; }

// The objects in the frame of doubles that exact statements are about (world coordinates over a sphere,
// canonical ones over a cylinder), and what becomes of each.
class Objects {
public:
    explicit Objects(const Scene& scene) : scene_(scene), owner_(scene.objects.size()) {
        std::iota(owner_.begin(), owner_.end(), 0u);
    }

    template <class T>
    struct Listed {
        std::vector<T> items;
        std::vector<std::uint32_t> objects;  // ascending

        void reserve(std::size_t n) {
            items.reserve(n);
            objects.reserve(n);
        }
        void add(const T& item, std::uint32_t object) {
            items.push_back(item);
            objects.push_back(object);
        }
        std::size_t size() const { return items.size(); }
        // Pre: the object is listed.
        const T& of(std::uint32_t object) const {
            return items[std::ranges::lower_bound(objects, object) - objects.begin()];
        }
    };
    Listed<Ball> balls;
    Listed<HalfSpace> planes;
    Listed<CylinderForm> cylinders;

    [[noreturn]] void fail(Kind kind, std::uint32_t object, const std::string& what) const {
        throw InputError(kind, object, object_path(scene_, object), what);
    }

    // Whose height object i has: its own, that of an equal object before it, or none.
    std::uint32_t owner(std::uint32_t i) const {
        while (i != none && owner_[i] != i) i = owner_[i];
        return i;
    }
    bool is_kept(std::uint32_t i) const { return owner_[i] == i; }
    void merge(std::uint32_t i, std::uint32_t j) {
        owner_[std::max(i, j)] = std::min(i, j);
        has_merged_ = true;
    }
    bool has_merged() const { return has_merged_; }
    // Pre: object i is not listed.
    void leave_out_unmet(std::uint32_t i) {
        owner_[i] = none;
        unmet_.push_back(object_title(scene_, i));
    }

    // Leaves out what lies in other solids, and cylinders beyond planes: never nearer than those, they may
    // tie with them along whole curves of the base. `mirrored` are images of a base cylinder in sides of the
    // box: on the side, base and image are equally far.
    void drop_hidden_and_equal(const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
        const BallNesting nesting = ball_nesting(balls.items);
        for (std::size_t i = 0; i < balls.size(); ++i) {
            if (const std::uint32_t first = nesting.first_equal[i]; first < i)
                merge(balls.objects[i], balls.objects[first]);
            if (const std::uint32_t k = nesting.enclosing[i]; k != none)
                hide(balls.objects[i], " in ", object_title(scene_, balls.objects[k]));
        }
        std::vector<std::array<Exact, 4>> rays;
        for (const HalfSpace& h : planes.items) rays.push_back({h.n.x(), h.n.y(), h.n.z(), h.d});
        // Planes that are multiples of each other are one plane, though |n| may round differently.
        const std::vector<std::uint32_t> first_plane = first_equal(rays);
        for (std::size_t i = 0; i < planes.size(); ++i)
            if (first_plane[i] < i) merge(planes.objects[i], planes.objects[first_plane[i]]);
        for (std::size_t i = 0; i < cylinders.size(); ++i) drop_if_hidden(i, rays, mirrored);
        if (cylinders.size() + mirrored.size() == 0) return;
        for (std::size_t i = 0; i < balls.size(); ++i) drop_if_in_cylinder(i, mirrored);
    }

    void warn(const FormSites& sites, std::vector<std::string>& warnings) const {
        if (!unmet_.empty())
            warnings.push_back(listed(unmet_) +
                               ": out of sight of the base, never nearest to any point of its cell");
        if (!hidden_.empty()) {
            auto sorted = hidden_;
            std::ranges::sort(sorted);
            std::vector<std::string> texts;
            for (auto& [object, text] : sorted) texts.push_back(std::move(text));
            warnings.push_back(listed(texts) + ": hidden, never nearest to any point of the cell");
        }
        if (!sites.has_shared_forms()) return;
        for (const FormId f : sites.ids()) {
            const std::span<const Site> group = sites[f];
            if (group.size() < 2) continue;
            std::string text;
            for (const Site site : group)
                text += (text.empty() ? "" : " and ") +
                        (site.is_object() ? object_title(scene_, site.index) : "side " + to_string(site));
            warnings.push_back(text + ": the same distance from the base everywhere, merged");
        }
    }

private:
    void hide(std::uint32_t object, const char* how, const std::string& where) {
        owner_[object] = none;
        hidden_.emplace_back(object, object_title(scene_, object) + how + where);
    }

    void drop_if_hidden(std::size_t i, const std::vector<std::array<Exact, 4>>& half_spaces,
                        const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
        const CylinderForm& cylinder = cylinders.items[i];
        const std::uint32_t object = cylinders.objects[i];
        for (std::size_t k = 0; k < planes.size(); ++k)
            if (is_beyond(half_spaces[k], cylinder))
                return hide(object, " beyond ", object_title(scene_, planes.objects[k]));
        for (const auto& [image, side] : mirrored)
            if (contains(image, cylinder) && !contains(cylinder, image))
                return hide(object, " beyond ", "side " + to_string(side));
        std::size_t first = i;
        for (std::size_t k = 0; k < cylinders.size(); ++k) {
            if (k == i || !contains(cylinders.items[k], cylinder)) continue;
            if (!contains(cylinder, cylinders.items[k]))
                return hide(object, " in ", object_title(scene_, cylinders.objects[k]));
            first = std::min(first, k);
        }
        if (first < i) merge(object, cylinders.objects[first]);
    }

    void drop_if_in_cylinder(std::size_t i, const std::vector<std::pair<CylinderForm, Site>>& mirrored) {
        const Ball& ball = balls.items[i];
        const std::uint32_t object = balls.objects[i];
        if (owner_[object] == none) return;
        for (std::size_t k = 0; k < cylinders.size(); ++k)
            if (contains(cylinders.items[k], ball.cx, ball.cy, ball.cz, ball.rho))
                return hide(object, " in ", object_title(scene_, cylinders.objects[k]));
        for (const auto& [image, side] : mirrored)
            if (contains(image, ball.cx, ball.cy, ball.cz, ball.rho))
                return hide(object, " beyond ", "side " + to_string(side));
    }

    const Scene& scene_;
    std::vector<std::uint32_t> owner_;
    bool has_merged_ = false;
    std::vector<std::string> unmet_;
    std::vector<std::pair<std::uint32_t, std::string>> hidden_;  // object, where it hides
};

HalfSpace half_space(const Vec3& point, const Vec3& normal, const ExactVector& inner) {
    HalfSpace h{normal, -dot(ExactVector(normal), ExactVector(point)), 0};
    if (value_at(h, inner).sign() == Sign::Negative) {
        h.n = -h.n;
        h.d = -h.d;
    }
    const ExactVector n(h.n);
    h.length = rounded_sqrt(dot(n, n));
    return h;
}

// How a plane lies to a convex body whose points inner +- reach (in length) see it nearest.
const char* cuts_or_touches(Sign clearance) { return clearance == Sign::Zero ? "touches" : "cuts"; }

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
        throw InputError(Kind::OutOfRange, site.index, object_path(scene, site.index), what);
    throw InputError(Kind::OutOfRange, InputError::no_object, "box", "side " + to_string(site) + " " + what);
}

// The sites of each form, and the first one as an object.
struct FoundForms {
    std::vector<FormId> of_object;
    FormSites sites;
    IdVector<FormId, Object> objects;

    explicit FoundForms(std::size_t object_count) : of_object(object_count) {
        sites.reserve(object_count + 6);
        objects.reserve(object_count + 6);
    }
    void add(Site site, const Object& canonical) {
        objects.push_back(canonical);
        note(site, sites.add(site));
    }
    void join(Site site, FormId f) {
        sites.join(f, site);
        note(site, f);
    }
    // The sites of objects that have another one's form.
    void add_twins(const Objects& all) {
        for (std::uint32_t i = 0; all.has_merged() && i < of_object.size(); ++i) {
            const std::uint32_t owner = all.owner(i);
            if (owner != none && owner != i) sites.join(of_object[owner], Site::object(i));
        }
        sites.settle();
    }

private:
    void note(Site site, FormId f) {
        if (site.is_object()) of_object[site.index] = f;
    }
};

// ---- Sphere base: heights that are linear in u ------------------------------------------------------

// f = -(p.u + s) / w
struct LinearHeight {
    ExactVector p;
    Exact s, w;
};

// A side of the box, x[axis] <= bound or >= bound.
struct WorldSide {
    int axis;
    double sign, bound;

    WorldSide(const Box& box, std::uint32_t side)
        : axis(static_cast<int>(side / 2)),
          sign(side % 2 == 0 ? -1 : 1),
          bound(side % 2 == 0 ? box.min[axis] : box.max[axis]) {}
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
        return {ExactVector(Vec3(-h.n)), h.length,
                value_at(h, ExactVector(center)) + Exact(radius) * h.length};
    }
    LinearHeight height(const WorldSide& side) const {
        Vec3 m = Vec3::Zero();
        m[side.axis] = side.sign;
        return {ExactVector(m), Exact(), side.sign * (Exact(side.bound) - center[side.axis])};
    }

    // With P = matrix^T p and N = norm, p.u = (2 P0 x + 2 P1 y + P2 (1 - x^2 - y^2)) / (N W).
    ExactForm form(const LinearHeight& h) const {
        const ExactVector P = turned(h.p);
        const Exact s = rotation.norm * h.s;
        return {P.z - s, -2.0 * P.x, -2.0 * P.y, -(P.z + s), rotation.norm * h.w};
    }

    // C = |c|^2 - delta^2 of cylinder_form.hpp's cylinder, times N^2 to be free of denominators.
    RadialForm form(const CylinderForm& f) const {
        const ExactVector p = ExactVector(Vec3(f.px, f.py, f.pz)) - ExactVector(center),
                          a(Vec3(f.ax, f.ay, f.az));
        const Exact length2 = dot(a, a), along = dot(p, a), delta = Exact(f.rho) - radius;
        const Exact n = rotation.norm, n2 = n * n;
        const ExactVector b = n * turned(length2 * p - along * a), turned_a = turned(a);
        return {{n2 * (length2 * (dot(p, p) - delta * delta) - along * along), Exact(), Exact()},
                n2 * length2 * delta,
                Exact(),
                {b.x, b.y, b.z},
                {turned_a.x, turned_a.y, turned_a.z}};
    }
};

// The coefficients divided by |K|, if that is not zero. Of coefficients within 1.45 u the quotients are within
// 4 u.
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

// c - center and rho - R0, each a high part plus a low one. The high parts are multiples of one unit, at most 2^25 of
// it: of such numbers, four products with each other or with integers up to 2^26 have an exact sum [Rump, Ogita, Oishi,
// Accurate floating-point summation I, section 3]. The low ones are at most 2^-24 of `size`, rounded once.
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

// ---- Sphere base: the problem -----------------------------------------------------------------------

// What the forms are made of, for those who ask for their exact coefficients.
struct FormSources {
    enum class Kind : std::uint8_t { Ball, Plane, Side };
    struct Source {
        Kind kind;
        std::uint32_t index;  // of `balls` or `planes`, or as in Site::box_side()
    };
    SphereFrame frame;
    Box box;
    std::vector<Ball> balls;
    std::vector<ExactForm> planes;
    IdVector<FormId, Source> forms;

    ExactForm exact(FormId f) const {
        const Source& source = forms[f];
        if (source.kind == Kind::Plane) return planes[source.index];
        return frame.form(source.kind == Kind::Ball ? frame.height(balls[source.index])
                                                    : frame.height(WorldSide(box, source.index)));
    }
};

class SphereProblem {
public:
    SphereProblem(const Scene& scene, const Sphere& base)
        : scene_(scene), frame_{base.center, base.radius, {}}, objects_(scene) {}

    RadialBaseProblem build() {
        check_box();
        objects_.balls.reserve(scene_.objects.size());
        powers_.reserve(scene_.objects.size());
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            std::visit([&](const auto& object) { add(i, object); }, scene_.objects[i]);
        objects_.drop_hidden_and_equal({});
        merge_mirrored_balls();
        merge_planelike_balls();
        choose_chart();
        return make_problem();
    }

private:
    void check_box() const {
        for (std::uint32_t s = 0; s < 6; ++s) {
            const WorldSide side(scene_.box, s);
            const double center = frame_.center[side.axis], radius = frame_.radius;
            const auto by_interval = (side.sign * (Interval(side.bound) - center) - radius).sign();
            const Sign room =
                by_interval ? *by_interval : (side.sign * (Exact(side.bound) - center) - radius).sign();
            if (room == Sign::Negative)
                fail_empty("does not contain the base sphere (base.sphere): it reaches beyond side " +
                           to_string(Site::box_side(s)));
            if (room == Sign::Zero && radius == 0)
                fail_empty("has the base point (base.sphere) on its side " + to_string(Site::box_side(s)));
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
        const HalfSpace h = half_space(plane.point, plane.normal, center);
        const ExactVector n(h.n);
        const Exact value = value_at(h, center), reach = Exact(frame_.radius) * frame_.radius * dot(n, n);
        const Sign clearance = (value * value - reach).sign();
        if (clearance != Sign::Positive) {
            const Vec3 place = frame_.center - h.n * (nearest(value) / h.length / h.length);
            objects_.fail(Kind::TouchesBase, i,
                          std::string(cuts_or_touches(clearance)) + " the base at " + to_text(place));
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
            nearness.linear.push_back({-scale * h.n, scale * h.length});
        }
        for (std::uint32_t s = 0; s < 6; ++s) {
            if (side_twin_[s] != none) continue;
            const WorldSide side(scene_.box, s);
            Vec3 p = Vec3::Zero();
            p[side.axis] = 1 / (side.bound - center[side.axis]);
            nearness.linear.push_back({p, 0});
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
    }

    RadialBaseProblem make_problem() {
        const std::size_t n = scene_.objects.size();
        FoundForms found(n);
        const auto sources = std::make_shared<FormSources>(FormSources{frame_, scene_.box, {}, {}, {}});
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
            const auto* sphere = std::get_if<Sphere>(&scene_.objects[i]);
            const std::uint32_t k = sphere != nullptr ? next_ball++ : 0;
            if (!objects_.is_kept(i)) continue;
            const Site site = Site::object(i);
            if (sphere != nullptr) {
                add(site, Sphere{sphere->center - frame_.center, sphere->radius},
                    rounded_form(objects_.balls.items[k], powers_[k], frame_), {Kind::Ball, k});
            } else if (const auto* plane = std::get_if<Plane>(&scene_.objects[i])) {
                const auto place = static_cast<std::uint32_t>(sources->planes.size());
                sources->planes.push_back(frame_.form(frame_.height(objects_.planes.of(i))));
                add(site, Plane{plane->point - frame_.center, plane->normal}, rounded(sources->planes.back()),
                    {Kind::Plane, place});
            }
        }
        for (std::uint32_t s = 0; s < 6; ++s) {
            const Site site = Site::box_side(s);
            if (side_twin_[s] != none) {
                found.join(site, found.of_object[objects_.owner(side_twin_[s])]);
                continue;
            }
            const WorldSide side(scene_.box, s);
            Plane canonical{Vec3::Zero(), Vec3::Zero()};
            canonical.point[side.axis] = side.bound - frame_.center[side.axis];
            canonical.normal[side.axis] = side.sign;
            add(site, canonical, rounded_form(side, frame_), {Kind::Side, s});
        }
        sources->balls = std::move(objects_.balls.items);

        for (std::size_t k = 0; k < objects_.cylinders.size(); ++k) {
            const std::uint32_t i = objects_.cylinders.objects[k];
            if (!objects_.is_kept(i)) continue;
            const auto& cylinder = std::get<Cylinder>(scene_.objects[i]);
            found.add(Site::object(i),
                      Cylinder{cylinder.point - frame_.center, cylinder.axis, cylinder.radius});
            problem.family.radial.push_back(frame_.form(objects_.cylinders.items[k]));
        }
        found.add_twins(objects_);
        problem.frame.origin = frame_.center;
        problem.is_sphere = true;
        problem.radius = frame_.radius;
        problem.chart = frame_.rotation.matrix / frame_.rotation.norm;
        problem.family.chart = RadialChart::Stereographic;
        problem.family.exact = [sources](FormId f) { return sources->exact(f); };
        objects_.warn(found.sites, problem.warnings);
        problem.sites = std::move(found.sites);
        problem.objects = std::move(found.objects);
        return problem;
    }

    const Scene& scene_;
    SphereFrame frame_;
    Objects objects_;
    std::vector<BallPower> powers_;  // of objects_.balls
    std::array<std::uint32_t, 6> side_twin_{none, none, none, none, none, none};
};

// ---- Cylinder base ----------------------------------------------------------------------------------

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
        const HalfSpace h = half_space(p, n, {Exact(), stretch_[0], Exact()});
        const Exact x = h.n.x(), z = h.n.z(), r = radius_;
        const Exact across2 = r * r * (x * x + z * z);
        for (const double y : stretch_) {
            const Exact value = value_at(h, {Exact(), y, Exact()});
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
    Objects objects_;
};

}  // namespace

void FormSites::settle() {
    if (joined_.empty()) return;
    for (const FormId f : ids())
        for (const Site site : (*this)[f]) joined_.emplace_back(f, site);
    std::ranges::sort(joined_);
    sites_.clear();
    begins_.assign(begins_.size(), 0);
    for (const auto& [form, site] : joined_) {
        sites_.push_back(site);
        ++begins_[form.value + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    joined_.clear();
}

RadialBaseProblem radial_base_problem(const Scene& scene) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.base)) return SphereProblem(scene, *sphere).build();
    return CylinderProblem(scene, std::get<Cylinder>(scene.base)).build();
}

Vec3 RadialBaseProblem::normal(const Vec2& p) const {
    if (is_sphere) {
        const double r2 = p.squaredNorm();
        if (r2 <= 1) return chart * Vec3(2 * p.x(), 2 * p.y(), 1 - r2) / (1 + r2);
        const Vec2 q = p / r2;
        const double s2 = q.squaredNorm();
        return chart * Vec3(2 * q.x(), 2 * q.y(), s2 - 1) / (1 + s2);
    }
    const bool front = p.x() <= 1;
    const double x = front ? p.x() : p.x() - 2, w = front ? 1 + x * x : -(1 + x * x);
    return chart * Vec3(2 * x / w, 0, (1 - x * x) / w);
}

Vec2 RadialBaseProblem::chart_point(const Vec3& normal, double y) const {
    if (is_sphere) {
        const Vec3 v = chart.transpose() * normal;
        if (v.z() >= 0) return v.head<2>() / (1 + v.z());
        return v.head<2>() * (1 - v.z()) / v.head<2>().squaredNorm();
    }
    // The tangent of half the angle about (0, 0, 1) or (0, 0, -1) of the chart; (-1, 0, 0) is x = -1, not 3.
    const Vec3 v = chart.transpose() * normal;
    const double s = v.x(), c = v.z();
    const double x = c >= 0 ? s / (1 + c) : 2 - s / (1 - c);
    return {x < 3 ? x : -1, y};
}

// With the axis a and its point m nearest to the centre (over a cylinder: to 0) forms hold |a|^2 m and |a|^2
// delta.
bool RadialBaseProblem::cross_equally(FormId f, FormId g) const {
    const auto* first = std::get_if<Cylinder>(&objects[f]);
    const auto* second = std::get_if<Cylinder>(&objects[g]);
    if (first == nullptr || second == nullptr) return false;
    // What doubles see at once, as rounding is far below this part of the terms.
    const Vec3 between = second->point - first->point, normal = first->axis.cross(second->axis);
    const double size =
        first->axis.norm() * second->axis.norm() * (first->point.norm() + second->point.norm());
    if (!(std::abs(between.dot(normal)) <= 0x1p-30 * size)) return false;
    const RadialForm &F = family.radial_form(f), &G = family.radial_form(g);
    const auto axis = [](const RadialForm& h) { return ExactVector(h.a[0], h.a[1] + h.slope, h.a[2]); };
    const auto moment = [](const RadialForm& h) {
        return ExactVector(h.b[0], h.b[1] - 0.5 * h.c[1], h.b[2]);
    };
    const ExactVector a = axis(F), b = axis(G), across = cross(a, b);
    const Exact a2 = dot(a, a), b2 = dot(b, b);
    return !across.is_zero() && (F.b0 * b2 - G.b0 * a2).sign() == Sign::Zero &&
           dot(a2 * moment(G) - b2 * moment(F), across).sign() == Sign::Zero;
}

double RadialBaseProblem::distance(const Vec2& p, double f) const {
    const double x = is_sphere || p.x() <= 1 ? p.x() : p.x() - 2;
    return (1 + x * x + (is_sphere ? p.y() * p.y() : 0.0)) / -f;
}

}  // namespace vcell
