#include "../../primitives/objects/scene.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <limits>

#include "../../core/errors.hpp"
#include "../../primitives/objects/site.hpp"

namespace vcell::scene_test {
using Kind = InputError::Kind;

namespace {

Scene good_scene() {
    Scene scene;
    scene.base = Plane{};
    scene.objects = {Sphere{{0, 0, 1}, 0.25}, Plane{{0, 0, 2}, {0, 0, -1}},
                     Cylinder{{0, 0, 3}, {1, 0, 0}, 0.5}, Sphere{{1, 0, 1}, 0}};
    scene.names = {"", "lid", "", ""};
    scene.box = {{-2, -2, 0}, {2, 2, 4}};
    return scene;
}

InputError error_of(const std::function<void(Scene&)>& spoil) {
    Scene scene = good_scene();
    spoil(scene);
    try {
        validate(scene);
    } catch (const InputError& error) {
        return error;
    }
    FAIL("the scene was accepted");
    std::abort();
}

}  // namespace

TEST_CASE("validate: accepts a proper scene, zero radii included") { CHECK_NOTHROW(validate(good_scene())); }

TEST_CASE("validate: the message names path, demand and value") {
    const InputError error = error_of([](Scene& s) { std::get<Sphere>(s.objects[3]).radius = -1; });
    CHECK(error.kind == Kind::NegativeRadius);
    CHECK(error.object == 3);
    CHECK(error.path == "objects[3].sphere.radius");
    CHECK(std::string(error.what()) == "objects[3].sphere.radius: must be >= 0, is -1");
}

TEST_CASE("validate: every kind of bad number is refused under its own path") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    struct Case {
        std::function<void(Scene&)> spoil;
        Kind kind;
        std::string path;
        std::uint32_t object;
    };
    const std::uint32_t none = InputError::no_object;
    const std::vector<Case> cases = {
        {[](Scene& s) { std::get<Plane>(s.base).normal.setZero(); }, Kind::ZeroAxis, "base.plane.normal",
         none},
        {[=](Scene& s) { std::get<Plane>(s.base).point.y() = nan; }, Kind::NotFinite, "base.plane.point[1]",
         none},
        {[](Scene& s) {
             s.base = Sphere{{0, 0, 0}, -2};
         },
         Kind::NegativeRadius, "base.sphere.radius", none},
        {[=](Scene& s) { std::get<Sphere>(s.objects[0]).center.z() = infinity; }, Kind::NotFinite,
         "objects[0].sphere.center[2]", 0},
        {[](Scene& s) { std::get<Plane>(s.objects[1]).normal.setZero(); }, Kind::ZeroAxis,
         "objects[1].plane.normal", 1},
        {[](Scene& s) {
             std::get<Plane>(s.objects[1]).normal = {0, 1e-70, 0};
         },
         Kind::OutOfRange, "objects[1].plane.normal", 1},
        {[](Scene& s) { std::get<Cylinder>(s.objects[2]).axis.setZero(); }, Kind::ZeroAxis,
         "objects[2].cylinder.axis", 2},
        {[](Scene& s) { std::get<Cylinder>(s.objects[2]).radius = -0.5; }, Kind::NegativeRadius,
         "objects[2].cylinder.radius", 2},
        {[](Scene& s) { std::get<Sphere>(s.objects[0]).center.x() = -1e80; }, Kind::OutOfRange,
         "objects[0].sphere.center[0]", 0},
        {[](Scene& s) { s.box.min.y() = 2; }, Kind::EmptyBox, "box.min[1]", none},
        {[](Scene& s) {
             s.box.min = {0, 0, 0}, s.box.max = {1e-70, 1, 1};
         },
         Kind::OutOfRange, "box.min[0]", none},
        {[=](Scene& s) { s.box.max.z() = nan; }, Kind::NotFinite, "box.max[2]", none},
        {[](Scene& s) { s.tolerance = 0; }, Kind::OutOfRange, "tolerance", none},
        {[=](Scene& s) { s.tolerance = nan; }, Kind::NotFinite, "tolerance", none},
    };
    for (const Case& c : cases) {
        CAPTURE(c.path);
        const InputError error = error_of(c.spoil);
        CHECK(error.kind == c.kind);
        CHECK(error.path == c.path);
        CHECK(error.object == c.object);
    }
}

TEST_CASE("object_path, object_title: name objects as the scene does") {
    const Scene scene = good_scene();
    CHECK(object_path(scene, 2) == "objects[2].cylinder");
    CHECK(object_path(scene, 1, "normal") == "objects[1].plane.normal");
    CHECK(object_title(scene, 1) == "object 1 (lid)");
    CHECK(object_title(scene, 0) == "object 0");
}

TEST_CASE("to_string(Site): the words of cell files") {
    CHECK(to_string(Site::object(12)) == "12");
    CHECK(to_string(Site::base()) == "base");
    CHECK(to_string(Site::box_side(0)) == "box:-x");
    CHECK(to_string(Site::box_side(5)) == "box:+z");
    CHECK(to_string(Site::end(0)) == "end:-");
    CHECK(to_string(Site::end(1)) == "end:+");
}

}  // namespace vcell::scene_test
