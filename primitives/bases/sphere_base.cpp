#include "sphere_base.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <variant>

#include "../../core/octree_path.hpp"
#include "../charts/sphere_chart.hpp"
#include "../objects/decided_scene.hpp"
#include "../objects/message.hpp"
#include "radial_objects.hpp"
#include "solids.hpp"
#include "sphere_forms.hpp"

namespace vcell {

namespace {

using namespace sphere_forms;
using Kind = InputError::Kind;

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

template <class Tube>
Vec3& place(Tube& tube) {
    return tube.point;
}
Vec3& place(HollowCone& cone) { return cone.apex; }

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
    std::vector<ExactForm> planes;  // and vessels
    IdVector<FormId, Source> forms;
    double grid = 0;  // multiples of its reciprocal are the integers below; a power of two

    ExactForm exact(FormId f) const {
        const Source& source = forms[f];
        if (source.kind == Kind::Plane) return planes[source.index];
        return frame.form(source.kind == Kind::Ball ? frame.height(balls[source.index])
                                                    : frame.height(WorldSide(box, source.index)));
    }

    // GrowingSphereProblem::tie_sign(). Where the bisector is a plane n.x = w / 2 the form is -2 n.u / w.
    // Three of these meet in a point x, seen along u or against it, and there a fourth form is -q (w - 2 n.x)
    // / w above them, q = 1 / t, of which
    //
    //     D (w - 2 n.x) = w n1.(n2 x n3) - w1 n.(n2 x n3) - w2 n.(n3 x n1) - w3 n.(n1 x n2),
    //
    // D = n1.(n2 x n3), is exact: coordinates are at most 2^24, so |n| < 2^24.8, w < 2^49.6, and each of the
    // four terms is less than 2^124.
    std::optional<Sign> tie_sign(FormId form, const std::array<FormId, 3>& tied, Sign value) const;
    // GrowingSphereProblem::tie_along(). Such forms tie where (n1 / w1 - n2 / w2).u = 0: all three do where
    // the points n / w lie on one line,
    //
    //     w1 (n2 x n3) + w2 (n3 x n1) + w3 (n1 x n2) = 0,
    //
    // of which each term is less than 2^99.
    std::optional<bool> tie_along(const std::array<FormId, 3>& forms) const;

private:
    struct FlatBisector {
        std::int64_t x, y, z, w;
    };
    // None where it is no plane, or digits are too many.
    std::optional<FlatBisector> flat_bisector(FormId f) const;
};

#if defined(__SIZEOF_INT128__)
__extension__ using WideInteger = __int128;

std::optional<FormSources::FlatBisector> FormSources::flat_bisector(FormId f) const {
    constexpr double most = 0x1p24;
    const auto is_integer = [](double x) { return std::abs(x) <= most && x == std::nearbyint(x); };
    // None where a - b is rounded: what is lost is a double, and these tell it.
    const auto difference = [](double a, double b) -> std::optional<double> {
        const double d = a - b, part = a - d;
        return (a - (d + part)) + (part - b) == 0 ? std::optional(d) : std::nullopt;
    };
    const Source& source = forms[f];
    if (grid == 0 || source.kind == Kind::Plane) return std::nullopt;
    if (source.kind == Kind::Side) {
        const WorldSide side(box, source.index);
        const auto distance = difference(side.sign * side.bound, side.sign * frame.center[side.axis]);
        if (!distance || !is_integer(grid * *distance)) return std::nullopt;
        FlatBisector flat{0, 0, 0, static_cast<std::int64_t>(2 * grid * *distance)};
        (side.axis == 0 ? flat.x : side.axis == 1 ? flat.y : flat.z) = side.sign > 0 ? 1 : -1;
        return flat;
    }
    const Ball& ball = balls[source.index];
    if (ball.rho != frame.radius) return std::nullopt;
    std::array<std::int64_t, 3> n;
    const std::array<double, 3> place{ball.cx, ball.cy, ball.cz};
    for (int k = 0; k < 3; ++k) {
        const auto along = difference(place[k], frame.center[k]);
        if (!along || !is_integer(grid * *along)) return std::nullopt;
        n[k] = static_cast<std::int64_t>(grid * *along);
    }
    return FlatBisector{n[0], n[1], n[2], n[0] * n[0] + n[1] * n[1] + n[2] * n[2]};
}

std::optional<Sign> FormSources::tie_sign(FormId form, const std::array<FormId, 3>& tied, Sign value) const {
    const auto d = flat_bisector(form), a = d ? flat_bisector(tied[0]) : std::nullopt,
               b = a ? flat_bisector(tied[1]) : std::nullopt, c = b ? flat_bisector(tied[2]) : std::nullopt;
    if (!c) return std::nullopt;
    const auto triple = [](const FlatBisector& p, const FlatBisector& q, const FlatBisector& r) {
        return p.x * (static_cast<WideInteger>(q.y) * r.z - static_cast<WideInteger>(q.z) * r.y) +
               p.y * (static_cast<WideInteger>(q.z) * r.x - static_cast<WideInteger>(q.x) * r.z) +
               p.z * (static_cast<WideInteger>(q.x) * r.y - static_cast<WideInteger>(q.y) * r.x);
    };
    const WideInteger volume = triple(*a, *b, *c);
    if (volume == 0) return std::nullopt;
    const WideInteger beyond =
        d->w * volume - a->w * triple(*d, *b, *c) - b->w * triple(*d, *c, *a) - c->w * triple(*d, *a, *b);
    return sign_of(beyond) * sign_of(volume) * -value;
}

std::optional<bool> FormSources::tie_along(const std::array<FormId, 3>& forms) const {
    const auto a = flat_bisector(forms[0]), b = a ? flat_bisector(forms[1]) : std::nullopt,
               c = b ? flat_bisector(forms[2]) : std::nullopt;
    if (!c) return std::nullopt;
    const auto is_zero = [&](auto x, auto y) {
        const auto minor = [&](const FlatBisector& p, const FlatBisector& q) {
            return static_cast<WideInteger>(p.*x) * (q.*y) - static_cast<WideInteger>(p.*y) * (q.*x);
        };
        return a->w * minor(*b, *c) + b->w * minor(*c, *a) + c->w * minor(*a, *b) == 0;
    };
    return is_zero(&FlatBisector::y, &FlatBisector::z) && is_zero(&FlatBisector::z, &FlatBisector::x) &&
           is_zero(&FlatBisector::x, &FlatBisector::y);
}
#else
std::optional<FormSources::FlatBisector> FormSources::flat_bisector(FormId) const { return std::nullopt; }
std::optional<bool> FormSources::tie_along(const std::array<FormId, 3>&) const { return std::nullopt; }
std::optional<Sign> FormSources::tie_sign(FormId, const std::array<FormId, 3>&, Sign) const {
    return std::nullopt;
}
#endif

class SphereProblem {
public:
    SphereProblem(const Scene& scene, const Sphere& base, double unit)
        : scene_(scene), unit_(unit), frame_{base.center, base.radius, {}}, objects_(scene) {}

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
    /// Those of the problem that was built, which may grow.
    const std::shared_ptr<FormSources>& sources() const { return sources_; }

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
        const CylinderForm form = world_form(cylinder);
        // Independent of the chart, which is still the identity.
        const Sign room = frame_.form(form).c[0].sign();
        if (room == Sign::Zero || (room == Sign::Negative && cylinder.radius >= frame_.radius))
            objects_.fail(
                Kind::TouchesBase, i,
                cylinder.radius >= frame_.radius
                    ? "contains the base"
                    : "runs through the base and touches it from within: along a ray from the base's centre "
                      "it is as far as the base");
        objects_.cylinders.add(form, i);
    }

    // Beyond the wall, with all of it, the base would have no bisector.
    void add(std::uint32_t i, const HollowSphere& vessel) {
        if (height_of(i).w.sign() != Sign::Positive) fail_beyond_wall(i);
        objects_.hollow_balls.add(vessel, i);
    }

    void add(std::uint32_t i, const HollowCylinder& vessel) {
        const CylinderForm form = world_form(vessel);
        if (frame_.hollow_form(form).c[0].sign() != Sign::Positive) fail_beyond_wall(i);
        objects_.hollow_cylinders.add(form, i);
    }

    void add(std::uint32_t i, const HollowCone& vessel) {
        const ConeForm form(vessel);
        if (!form.room(ExactVector(frame_.center), frame_.radius).is_more()) fail_beyond_wall(i);
        objects_.hollow_cones.add(form, i);
    }

    [[noreturn]] void fail_beyond_wall(std::uint32_t i) const {
        objects_.fail(Kind::TouchesBase, i, "has all of the base beyond its wall");
    }
    // Of a hollow sphere; the cap's is not that of its rounded radius.
    LinearHeight height_of(std::uint32_t i) const {
        if (is_cap(scene_, i)) return frame_.cap(*scene_.probe);
        return frame_.height(std::get<HollowSphere>(scene_.objects[i]));
    }

    // A ball of the base's radius, mirrored to it by a side of the box, has that side as its bisector.
    void merge_mirrored_balls() {
        for (std::size_t i = 0; i < objects_.balls.size(); ++i) {
            const Ball& ball = objects_.balls.items[i];
            if (!may_be_mirrored(ball, frame_) || !objects_.is_kept(objects_.balls.objects[i])) continue;
            const Vec3 c(ball.cx, ball.cy, ball.cz);
            for (std::uint32_t s = 0; s < 6; ++s) {
                const WorldSide side(scene_.box, s);
                Vec3 beside = c;
                beside[side.axis] = frame_.center[side.axis];
                if (beside != frame_.center) continue;
                // A sum that is a double is not rounded.
                if (c[side.axis] + frame_.center[side.axis] != 2 * side.bound) continue;
                if (Exact(c[side.axis]) + frame_.center[side.axis] == 2.0 * Exact(side.bound))
                    side_twin_[s] = objects_.balls.objects[i];
            }
        }
    }

    // A side of the box is as far as the base's image across it. A tube that has that in it, and a vessel
    // with that beyond its wall, are nowhere farther; and as near along a whole curve where such a tube is as
    // wide as the base and its axis runs through the image's centre.
    bool is_hidden(const WorldSide& side) const {
        if (objects_.cylinders.size() + objects_.hollow_cylinders.size() + objects_.hollow_cones.size() == 0)
            return false;
        Vec3 center = frame_.center;
        center[side.axis] = 2 * side.bound - frame_.center[side.axis];
        if (Exact(center[side.axis]) + frame_.center[side.axis] != 2.0 * Exact(side.bound)) return false;
        const Ball image{center.x(), center.y(), center.z(), frame_.radius};
        bool is_hidden = false;
        objects_.for_kept(objects_.cylinders, [&](const CylinderForm& tube, std::uint32_t) {
            is_hidden = is_hidden || contains(tube, image.cx, image.cy, image.cz, image.rho);
        });
        objects_.for_kept(objects_.hollow_cylinders, [&](const CylinderForm& vessel, std::uint32_t) {
            is_hidden = is_hidden || is_beside(vessel, image.cx, image.cy, image.cz, image.rho);
        });
        objects_.for_kept(objects_.hollow_cones, [&](const ConeForm& vessel, std::uint32_t) {
            is_hidden = is_hidden || is_beside(vessel, image);
        });
        return is_hidden;
    }

    // A huge ball can have the very height of a plane whose |n| has been rounded down: a plane's C is
    // proportional to |n| - rounded |n|.
    void merge_planelike_balls() {
        if (objects_.planes.size() == 0) return;
        for (std::size_t i = 0; i < objects_.balls.size(); ++i) {
            const Ball& ball = objects_.balls.items[i];
            // No other ball can: this leaves all that may be equal to the exact comparison.
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
        objects_.for_kept(objects_.planes, [&](const HalfSpace& h, std::uint32_t) {
            const double scale = 1 / nearest(frame_.height(h).w);
            nearness.linear.push_back({-scale * h.n, scale * nearest(h.length)});
        });
        for (std::uint32_t s = 0; s < 6; ++s) {
            if (side_twin_[s] != RadialObjects::none) continue;
            const WorldSide side(scene_.box, s);
            nearness.linear.push_back({Vec3::Unit(side.axis) / (side.bound - center[side.axis]), 0});
        }
        objects_.for_kept(objects_.hollow_balls, [&](const HollowSphere& vessel, std::uint32_t) {
            const double scale = 1 / nearest(frame_.height(vessel).w);
            nearness.linear.push_back({scale * (center - vessel.center), scale * (vessel.radius + radius)});
        });
        objects_.for_kept(objects_.hollow_cylinders, [&](const CylinderForm& f, std::uint32_t) {
            const Vec3 way = center - Vec3(f.px, f.py, f.pz), axis = Vec3(f.ax, f.ay, f.az).normalized();
            const double length2 = f.ax * f.ax + f.ay * f.ay + f.az * f.az;
            nearness.cylindrical.push_back({way - axis * axis.dot(way), axis, f.rho + radius,
                                            nearest(frame_.hollow_form(f).c[0]) / length2, true});
        });
        objects_.for_kept(objects_.hollow_cones, [&](const ConeForm& f, std::uint32_t) {
            nearness.cylindrical.push_back(nearness_in(f));
        });
        objects_.for_kept(objects_.cylinders, [&](const CylinderForm& f, std::uint32_t) {
            const Vec3 p = Vec3(f.px, f.py, f.pz) - center, axis = Vec3(f.ax, f.ay, f.az).normalized();
            const double length2 = f.ax * f.ax + f.ay * f.ay + f.az * f.az;
            nearness.cylindrical.push_back(
                {p - axis * axis.dot(p), axis, f.rho - radius, nearest(frame_.form(f).c[0]) / length2});
        });
        const auto rotation = chart_rotation(nearness);
        if (!rotation)
            throw UndecidedError(
                "no direction from the base sphere (base.sphere) has one object nearest in it by a margin "
                "that "
                "doubles can see");
        frame_.rotation = *rotation;
    }
    Nearness::Cylindrical nearness_in(const ConeForm& cone) const {
        const ExactVector D = ExactVector(frame_.center) - cone.apex;
        const ConeForm::Room room = cone.room(ExactVector(frame_.center), frame_.radius);
        const double N = nearest(cone.N), g = nearest(cone.g), sine = std::sqrt(N) / g,
                     P = nearest(room.P) / g;
        const Vec3 w = Vec3(nearest(cone.a.x), nearest(cone.a.y), nearest(cone.a.z)) / std::sqrt(N),
                   way(nearest(D.x), nearest(D.y), nearest(D.z));
        return {(1 - sine) * (1 + sine) * (way - way.dot(w) * w) - P * sine * w,
                w,
                P,
                nearest(room.C) / (N * g * g),
                true,
                sine};
    }

    // Objects that compete, with their places among the balls, if they are some: as the scene has them. Many
    // come on a path around the base, as what is computed of a form is asked for together with its
    // neighbours'.
    struct Ordered {
        std::uint32_t place_on_path, object, ball;
    };
    std::vector<Ordered> in_order_of_forms() const {
        const bool are_many = scene_.objects.size() > 4096;
        std::vector<Ordered> order;
        order.reserve(scene_.objects.size());
        std::uint32_t ball = 0;
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
            if (!scene_.competes(i)) continue;
            const auto* sphere = std::get_if<Sphere>(&scene_.objects[i]);
            std::uint32_t place = 0;
            if (sphere != nullptr && are_many)
                place = octree_path((sphere->center - frame_.center).stableNormalized());
            order.push_back({place, i, sphere != nullptr ? ball++ : 0});
        }
        if (are_many) std::ranges::stable_sort(order, {}, &Ordered::place_on_path);
        return order;
    }

    RadialBaseProblem make_problem() {
        const std::size_t n = scene_.objects.size();
        FoundForms found(scene_);
        const auto sources = std::make_shared<FormSources>(FormSources{frame_, scene_.box, {}, {}, {}});
        sources_ = sources;
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
        for (const auto& [place_on_path, i, k] : in_order_of_forms()) {
            if (!objects_.is_kept(i)) continue;
            const Site site = objects_.site(i);
            if (const auto* sphere = std::get_if<Sphere>(&scene_.objects[i])) {
                add(site, Sphere{sphere->center - frame_.center, sphere->radius},
                    rounded_form(objects_.balls.items[k], powers_[k], frame_), {Kind::Ball, k});
            } else if (const auto* plane = std::get_if<Plane>(&scene_.objects[i])) {
                const auto place = static_cast<std::uint32_t>(sources->planes.size());
                sources->planes.push_back(frame_.form(frame_.height(objects_.planes.of(i))));
                add(site, Plane{plane->point - frame_.center, plane->normal}, rounded(sources->planes.back()),
                    {Kind::Plane, place});
            } else if (const auto* vessel = std::get_if<HollowSphere>(&scene_.objects[i])) {
                const auto place = static_cast<std::uint32_t>(sources->planes.size());
                sources->planes.push_back(frame_.form(height_of(i)));
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
            if (is_hidden(side)) problem.family.hide(FormId{static_cast<std::uint32_t>(forms.size())});
            const Vec3 foot = (side.bound - frame_.center[side.axis]) * Vec3::Unit(side.axis);
            add(site, Plane{foot, side.normal()}, rounded_form(side, frame_), {Kind::Side, s});
        }
        // Four times as far there is room for others.
        double far = 0;
        for (const Ball& b : objects_.balls.items)
            far = std::max(far, (Vec3(b.cx, b.cy, b.cz) - frame_.center).cwiseAbs().maxCoeff());
        constexpr int digits = 21;
        if (far > 0) sources->grid = std::ldexp(1.0, digits - std::ilogb(far));
        sources->balls = std::move(objects_.balls.items);

        const auto add_tubes = [&]<class Tube>(const auto& tubes, std::type_identity<Tube>, auto form) {
            objects_.for_kept(tubes, [&](const auto& item, std::uint32_t i) {
                Tube tube = std::get<Tube>(scene_.objects[i]);
                place(tube) -= frame_.center;
                found.add(objects_.site(i), tube);
                problem.family.radial.push_back(form(item));
            });
        };
        add_tubes(objects_.cylinders, std::type_identity<Cylinder>{},
                  [&](const auto& tube) { return frame_.form(tube); });
        add_tubes(objects_.hollow_cylinders, std::type_identity<HollowCylinder>{},
                  [&](const auto& tube) { return frame_.hollow_form(tube); });
        add_tubes(objects_.hollow_cones, std::type_identity<HollowCone>{},
                  [&](const auto& cone) { return frame_.hollow_form(cone); });
        found.add_twins(objects_);
        problem.frame.origin = frame_.center;
        problem.unit = unit_;
        problem.moves.all = problem.moves.apart = moved_by_lengths(scene_);
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
    SphereFrame frame_;
    RadialObjects objects_;
    std::vector<BallPower> powers_;  // of objects_.balls
    std::shared_ptr<FormSources> sources_;
    std::array<std::uint32_t, 6> side_twin_{RadialObjects::none, RadialObjects::none, RadialObjects::none,
                                            RadialObjects::none, RadialObjects::none, RadialObjects::none};
};

}  // namespace

RadialBaseProblem sphere_base_problem(const Scene& scene, const Sphere& base, double unit) {
    return SphereProblem(scene, base, unit).build();
}

struct GrowingSphereProblem::Growth {
    std::shared_ptr<FormSources> sources;
};

GrowingSphereProblem::GrowingSphereProblem(const Scene& scene, double unit) {
    SphereProblem problem(scene, std::get<Sphere>(scene.base), unit);
    problem_ = problem.build();
    growth_ = std::make_shared<Growth>(Growth{problem.sources()});
}

std::optional<Sign> GrowingSphereProblem::tie_sign(FormId form, const std::array<FormId, 3>& tied,
                                                   Sign value) const {
    return growth_->sources->tie_sign(form, tied, value);
}

std::optional<bool> GrowingSphereProblem::tie_along(const std::array<FormId, 3>& forms) const {
    return growth_->sources->tie_along(forms);
}

bool GrowingSphereProblem::add(const Sphere& sphere, Site site) {
    FormSources& sources = *growth_->sources;
    const SphereFrame& frame = sources.frame;
    const Ball ball{sphere.center.x(), sphere.center.y(), sphere.center.z(), sphere.radius};
    const BallPower C = ball_power(ball, frame);
    if (!(C.value() > 0) || may_be_mirrored(ball, frame)) return false;
    const CircularForm f = rounded_form(ball, C, frame);
    if (!(is_in_range(f.a) && is_in_range(f.b) && is_in_range(f.e) && is_in_range(f.w))) return false;
    problem_.family.forms.push_back(f);
    problem_.sites.add(site);
    problem_.objects.push_back(Sphere{sphere.center - frame.center, sphere.radius});
    sources.forms.push_back({FormSources::Kind::Ball, static_cast<std::uint32_t>(sources.balls.size())});
    sources.balls.push_back(ball);
    return true;
}

}  // namespace vcell
