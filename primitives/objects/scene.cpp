#include "scene.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "../../core/errors.hpp"
#include "message.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

// Lengths and directions live in [1e-60, 1e60]: then fourth powers of coordinates over a height's
// denominator, the largest products that output needs, stay finite (1e240 / 1e-60). Predicates fall
// back to exact numbers long before.
constexpr double largest_magnitude = 1e60;
constexpr double smallest_extent = 1e-60;

const char* type_name(const Object& object) {
    static constexpr const char* names[] = {"plane",         "sphere",          "cylinder",
                                            "hollow_sphere", "hollow_cylinder", "hollow_cone"};
    return names[object.index()];
}

// Checks the numbers of an object, or (no_object) of what is at `path`. An object's path is only composed
// when something is wrong: scenes may hold a million objects.
class Checker {
public:
    Checker(const Scene& scene, std::uint32_t object, const char* path)
        : scene_(scene), object_(object), path_(path) {}

    void number(const char* field, double x) const {
        if (!is_within_range(x)) fail_number(field, x);
    }
    void point(const char* field, const Vec3& p) const {
        if (is_within_range(p.x()) && is_within_range(p.y()) && is_within_range(p.z())) return;
        for (int i = 0; i < 3; ++i)
            if (!is_within_range(p[i])) fail_number(field + ("[" + std::to_string(i) + "]"), p[i]);
    }
    void direction(const char* field, const Vec3& d) const {
        point(field, d);
        const double size = d.cwiseAbs().maxCoeff();
        if (size == 0) fail(Kind::ZeroAxis, field, "must not be zero");
        if (size < smallest_extent)
            fail(Kind::OutOfRange, field,
                 "must have a component of at least " + to_text(smallest_extent) + ", the largest is " +
                     to_text(size));
    }
    void radius(const char* field, double r) const {
        number(field, r);
        if (r < 0) fail(Kind::NegativeRadius, field, "must be >= 0, is " + to_text(r));
    }
    [[noreturn]] void fail(Kind kind, const std::string& field, const std::string& what) const {
        const bool is_object = object_ != InputError::no_object;
        const std::string path = is_object ? object_path(scene_, object_) : path_;
        const std::uint32_t number = is_object ? scene_.number(object_) : object_;
        throw InputError(kind, number,
                         path.empty()    ? field
                         : field.empty() ? path
                                         : path + "." + field,
                         what);
    }

    void operator()(const Plane& plane) const {
        point("point", plane.point);
        direction("normal", plane.normal);
    }
    void operator()(const Sphere& sphere) const {
        point("center", sphere.center);
        radius("radius", sphere.radius);
    }
    void operator()(const Cylinder& cylinder) const {
        point("point", cylinder.point);
        direction("axis", cylinder.axis);
        radius("radius", cylinder.radius);
    }
    // What is as wide as nothing has no inside.
    void hollow_radius(double r) const {
        number("radius", r);
        if (!(r > 0)) fail(Kind::NegativeRadius, "radius", "must be > 0, is " + to_text(r));
    }
    void operator()(const HollowSphere& vessel) const {
        point("center", vessel.center);
        hollow_radius(vessel.radius);
    }
    void operator()(const HollowCylinder& vessel) const {
        point("point", vessel.point);
        direction("axis", vessel.axis);
        hollow_radius(vessel.radius);
    }
    void operator()(const HollowCone& vessel) const {
        point("apex", vessel.apex);
        direction("axis", vessel.axis);
        hollow_radius(vessel.radius);
        number("slant", vessel.slant);
        if (!(vessel.slant > vessel.radius))
            fail(Kind::OutOfRange, "slant",
                 "must be > radius = " + to_text(vessel.radius) + ", is " + to_text(vessel.slant));
    }
    void operator()(const Box& box) const {
        point("min", box.min);
        point("max", box.max);
        for (int i = 0; i < 3; ++i) {
            const std::string field = "min[" + std::to_string(i) + "]";
            if (!(box.min[i] < box.max[i]))
                fail(Kind::EmptyBox, field,
                     "must be < box.max[" + std::to_string(i) + "] = " + to_text(box.max[i]) + ", is " +
                         to_text(box.min[i]));
            if (box.max[i] - box.min[i] < smallest_extent)
                fail(Kind::OutOfRange, field,
                     "must be below box.max[" + std::to_string(i) + "] by at least " +
                         to_text(smallest_extent));
        }
    }

private:
    // False for a NaN.
    static bool is_within_range(double x) { return std::abs(x) <= largest_magnitude; }

    [[noreturn]] void fail_number(const std::string& field, double x) const {
        if (!std::isfinite(x)) fail(Kind::NotFinite, field, "must be finite, is " + to_text(x));
        fail(Kind::OutOfRange, field,
             "must not exceed " + to_text(largest_magnitude) + " in magnitude, is " + to_text(x));
    }

    const Scene& scene_;
    std::uint32_t object_;
    const char* path_;
};

}  // namespace

Scene base_alone(const Scene& scene) {
    Scene alone;
    alone.base = scene.base;
    alone.box = scene.box;
    return alone;
}

std::size_t Scene::place(std::uint32_t number) const {
    if (numbers.empty()) return number;
    return static_cast<std::size_t>(std::ranges::lower_bound(numbers, number) - numbers.begin());
}

std::string to_string(const ObjectImage& object) {
    const auto& [x, y, z] = object.image;
    std::string text = std::to_string(object.number);
    if (x != 0 || y != 0 || z != 0)
        text += '(' + std::to_string(x) + ',' + std::to_string(y) + ',' + std::to_string(z) + ')';
    return text;
}

void validate(const Scene& scene) {
    const std::string base_path = std::string("base.") + type_name(scene.base);
    std::visit(Checker(scene, InputError::no_object, base_path.c_str()), scene.base);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        std::visit(Checker(scene, static_cast<std::uint32_t>(i), ""), scene.objects[i]);
    if (is_vessel(scene.base))
        Checker(scene, InputError::no_object, base_path.c_str())
            .fail(Kind::Unsupported, "", "is a vessel, which is no base: objects lie in it");
    Checker(scene, InputError::no_object, "box")(scene.box);
    if (scene.base_object) {
        const std::uint32_t i = *scene.base_object;
        const Checker top(scene, InputError::no_object, "");
        if (i >= scene.objects.size())
            top.fail(Kind::OutOfRange, "base_object",
                     "must be less than the number of objects, " + std::to_string(scene.objects.size()) +
                         ", is " + std::to_string(i));
        if (scene.objects[i] != scene.base)
            top.fail(Kind::OutOfRange, "base_object", "objects[" + std::to_string(i) + "] is not the base");
    }
    const auto require_positive = [&](const char* field, const std::optional<double>& length) {
        if (!length) return;
        const Checker top(scene, InputError::no_object, "");
        top.number(field, *length);
        if (!(*length > 0)) top.fail(Kind::OutOfRange, field, "must be > 0, is " + to_text(*length));
    };
    require_positive("tolerance", scene.tolerance);
    require_positive("probe", scene.probe);
}

Site side_at_end(const Scene& scene, Site site) {
    const auto* tube = std::get_if<Cylinder>(&scene.base);
    if (tube == nullptr || site.kind != Site::Kind::End) return site;
    for (std::uint32_t k = 0; k < 3; ++k) {
        if (tube->axis[(k + 1) % 3] != 0 || tube->axis[(k + 2) % 3] != 0) continue;
        return Site::box_side(2 * k + (tube->axis[k] > 0 ? site.index : 1 - site.index));
    }
    return site;
}

std::string object_path(const Scene& scene, std::size_t object, const std::string& field) {
    const std::uint32_t number =
        object < scene.images.size() ? scene.images[object].number : scene.number(object);
    std::string path = "objects[" + std::to_string(number) + "]." + type_name(scene.objects[object]);
    if (!field.empty()) path += "." + field;
    return path;
}

std::string object_title(const Scene& scene, std::size_t object) {
    if (scene.number(object) == Site::number_of_cap) return "the cap";
    std::string title = "object " + (object < scene.images.size() ? to_string(scene.images[object])
                                                                  : std::to_string(scene.number(object)));
    if (object < scene.names.size() && !scene.names[object].empty())
        title += " (" + scene.names[object] + ")";
    return title;
}

std::string competitor_title(const Scene& scene, Site site) {
    return site.is_object() ? object_title(scene, scene.place(site.index)) : "side " + to_string(site);
}

}  // namespace vcell
