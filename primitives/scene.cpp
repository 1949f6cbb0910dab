#include "scene.hpp"

#include <cmath>

#include "../core/errors.hpp"
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
    static constexpr const char* names[] = {"plane", "sphere", "cylinder"};
    return names[object.index()];
}

// Checks the numbers of one object (or the base, with no_object) under its path.
class Checker {
public:
    Checker(std::uint32_t object, std::string path) : object_(object), path_(std::move(path)) {}

    void number(const std::string& field, double x) const {
        if (std::abs(x) <= largest_magnitude) return;
        if (!std::isfinite(x)) fail(Kind::NotFinite, field, "must be finite, is " + to_text(x));
        fail(Kind::OutOfRange, field,
             "must not exceed " + to_text(largest_magnitude) + " in magnitude, is " + to_text(x));
    }
    void point(const std::string& field, const Vec3& p) const {
        if (p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= largest_magnitude) return;
        for (int i = 0; i < 3; ++i) number(field + "[" + std::to_string(i) + "]", p[i]);
    }
    void direction(const std::string& field, const Vec3& d) const {
        point(field, d);
        const double size = d.cwiseAbs().maxCoeff();
        if (size == 0) fail(Kind::ZeroAxis, field, "must not be zero");
        if (size < smallest_extent)
            fail(Kind::OutOfRange, field,
                 "must have a component of at least " + to_text(smallest_extent) + ", the largest is " +
                     to_text(size));
    }
    void radius(const std::string& field, double r) const {
        number(field, r);
        if (r < 0) fail(Kind::NegativeRadius, field, "must be >= 0, is " + to_text(r));
    }
    [[noreturn]] void fail(Kind kind, const std::string& field, const std::string& what) const {
        throw InputError(kind, object_, path_.empty() ? field : path_ + "." + field, what);
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
    std::uint32_t object_;
    std::string path_;
};

}  // namespace

void validate(const Scene& scene) {
    std::visit(Checker(InputError::no_object, std::string("base.") + type_name(scene.base)), scene.base);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        // The path is only needed when something is wrong, and scenes may hold a million objects.
        try {
            std::visit(Checker(static_cast<std::uint32_t>(i), {}), scene.objects[i]);
        } catch (const InputError&) {
            std::visit(Checker(static_cast<std::uint32_t>(i), object_path(scene, i)), scene.objects[i]);
        }
    }
    Checker(InputError::no_object, "box")(scene.box);
    if (scene.tolerance) {
        const Checker top(InputError::no_object, {});
        top.number("tolerance", *scene.tolerance);
        if (!(*scene.tolerance > 0))
            top.fail(Kind::OutOfRange, "tolerance", "must be > 0, is " + to_text(*scene.tolerance));
    }
}

std::string object_path(const Scene& scene, std::size_t object, const std::string& field) {
    std::string path = "objects[" + std::to_string(object) + "]." + type_name(scene.objects[object]);
    if (!field.empty()) path += "." + field;
    return path;
}

std::string object_title(const Scene& scene, std::size_t object) {
    std::string title = "object " + std::to_string(object);
    if (object < scene.names.size() && !scene.names[object].empty())
        title += " (" + scene.names[object] + ")";
    return title;
}

}  // namespace vcell
