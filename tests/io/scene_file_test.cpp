#include "../../io/files/scene_file.hpp"

#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "../../core/errors.hpp"
#include "../../io/files/files.hpp"
#include "sample_cells.hpp"
#include "test_support.hpp"

using namespace vcell;
using nlohmann::json;

namespace {

const json complete = json::parse(R"({
  "vcell": 1,
  "base": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 2]}, "name": "floor"},
  "objects": [
    {"sphere": {"center": [0.1, 0.2, 0.9], "radius": 0.25}, "name": "O1"},
    {"cylinder": {"point": [0, 0, 1.4], "axis": [1, 0.3, 0], "radius": 0.1}},
    {"plane": {"point": [0, 0, 2], "normal": [0.1, 0, -1]}},
    {"sphere": {"center": [0.5, 0.5, 0.5], "radius": 0}, "name": "p"}
  ],
  "box": {"min": [-1, -1, 0], "max": [1, 1, 2]},
  "units": "m",
  "tolerance": 1e-5
})");

/// The complete scene with one value replaced.
std::string with(const std::string& pointer, const json& value) {
    json scene = complete;
    scene[json::json_pointer(pointer)] = value;
    return scene.dump();
}
std::string without(const std::string& parent, const std::string& key) {
    json scene = complete;
    scene[json::json_pointer(parent)].erase(key);
    return scene.dump();
}

std::string text_complaint(const std::string& text, const TextSceneOptions& options) {
    try {
        parse_scene(text, options);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

}  // namespace

TEST_CASE("scene file: everything arrives") {
    const Scene scene = parse_scene(complete.dump());
    CHECK(std::get<Plane>(scene.base).normal == Vec3(0, 0, 2));
    CHECK(scene.base_name == "floor");
    REQUIRE(scene.objects.size() == 4);
    CHECK(std::get<Sphere>(scene.objects[0]).center == Vec3(0.1, 0.2, 0.9));
    CHECK(std::get<Sphere>(scene.objects[0]).radius == 0.25);
    CHECK(std::get<Cylinder>(scene.objects[1]).point == Vec3(0, 0, 1.4));
    CHECK(std::get<Cylinder>(scene.objects[1]).axis == Vec3(1, 0.3, 0));
    CHECK(std::get<Cylinder>(scene.objects[1]).radius == 0.1);
    CHECK(std::get<Plane>(scene.objects[2]).point == Vec3(0, 0, 2));
    CHECK(scene.names == std::vector<std::string>{"O1", "", "", "p"});
    CHECK(scene.box.min == Vec3(-1, -1, 0));
    CHECK(scene.box.max == Vec3(1, 1, 2));
    CHECK(scene.units == "m");
    CHECK(scene.tolerance == 1e-5);
}

TEST_CASE("scene file: names begin where the first one is") {
    json scene = complete;
    for (auto& o : scene["objects"]) o.erase("name");
    CHECK(parse_scene(scene.dump()).names.empty());
    scene["objects"][2]["name"] = "late";
    CHECK(parse_scene(scene.dump()).names == std::vector<std::string>{"", "", "late", ""});
}

TEST_CASE("scene file: writing and reading give the same scene") {
    std::ostringstream out;
    write_scene(out, parse_scene(complete.dump()));
    CHECK(json::parse(out.str()) == complete);
    std::ostringstream again;
    write_scene(again, parse_scene(out.str()));
    CHECK(again.str() == out.str());
}

TEST_CASE("scene file: defaults") {
    json scene = complete;
    scene.erase("units");
    scene.erase("tolerance");
    scene["objects"] = json::array();
    const Scene read = parse_scene(scene.dump());
    CHECK(read.units == "mm");
    CHECK_FALSE(read.tolerance);
    CHECK(read.objects.empty());
}

TEST_CASE("scene file: each mistake is named with its path") {
    const std::pair<std::string, std::string> cases[] = {
        {with("/vcell", 2), "vcell: must be 1, is 2"},
        {with("/vcell", "1"), "vcell: must be a number, is a string"},
        {without("", "vcell"), "vcell: missing"},
        {without("", "base"), "base: missing"},
        {without("", "objects"), "objects: missing"},
        {without("", "box"), "box: missing"},
        {without("/box", "min"), "box.min: missing"},
        {without("/box", "max"), "box.max: missing"},
        {without("/objects/0/sphere", "radius"), "objects[0].sphere.radius: missing"},
        {without("/objects/0/sphere", "center"), "objects[0].sphere.center: missing"},
        {without("/objects/1/cylinder", "axis"), "objects[1].cylinder.axis: missing"},
        {without("/objects/1/cylinder", "point"), "objects[1].cylinder.point: missing"},
        {without("/objects/1/cylinder", "radius"), "objects[1].cylinder.radius: missing"},
        {without("/objects/2/plane", "normal"), "objects[2].plane.normal: missing"},
        {without("/base/plane", "point"), "base.plane.point: missing"},
        {with("/objcts", 1),
         "objcts: unknown key, known are vcell, base, objects, base_object, box, units, tolerance, probe"},
        {with("/objects/3/sphre", 1),
         "objects[3].sphre: unknown key, known are plane, sphere, cylinder, hollow_sphere, hollow_cylinder, hollow_cone, "
         "name"},
        {with("/objects/0/sphere/radius2", 1),
         "objects[0].sphere.radius2: unknown key, known are center, radius"},
        {with("/objects/1/cylinder/length", 1),
         "objects[1].cylinder.length: unknown key, known are point, axis, radius"},
        {with("/base/plane/offset", 1), "base.plane.offset: unknown key, known are point, normal"},
        {with("/box/center", 1), "box.center: unknown key, known are min, max"},
        {with("/objects/0/sphere/radius", "1"), "objects[0].sphere.radius: must be a number, is a string"},
        {with("/objects/0/sphere/radius", nullptr), "objects[0].sphere.radius: must be a number, is null"},
        {with("/objects/0/sphere/center", 3), "objects[0].sphere.center: must be an array, is a number"},
        {with("/objects/0/sphere/center", {1, 2}), "objects[0].sphere.center: must have 3 elements"},
        {with("/objects/0/sphere/center", {1, 2, 3, 4}), "objects[0].sphere.center: must have 3 elements"},
        {with("/objects/0/sphere/center/1", true), "objects[0].sphere.center[1]: must be a number, is true"},
        {with("/objects/0/sphere", json::array()), "objects[0].sphere: must be an object, is an array"},
        {with("/objects/0/name", 7), "objects[0].name: must be a string, is a number"},
        {with("/objects/0", nullptr), "objects[0]: must be an object, is null"},
        {with("/objects", json::object()), "objects: must be an array, is an object"},
        {with("/base", "plane"), "base: must be an object, is a string"},
        {with("/base", json::object()),
         "base: must hold one of plane, sphere, cylinder, hollow_sphere, hollow_cylinder, hollow_cone, "
         "holds none"},
        {with("/objects/0", {{"name", "x"}}),
         "objects[0]: must hold one of plane, sphere, cylinder, hollow_sphere, hollow_cylinder, hollow_cone, "
         "holds none"},
        {with("/units", 1), "units: must be a string, is a number"},
        {with("/tolerance", "fine"), "tolerance: must be a number, is a string"},
        // Values are validate()'s to judge; the paths are the file's.
        {with("/objects/3/sphere/radius", -1), "objects[3].sphere.radius: must be >= 0, is -1"},
        {with("/objects/1/cylinder/radius", -0.5), "objects[1].cylinder.radius: must be >= 0, is -0.5"},
        {with("/objects/1/cylinder/axis", {0, 0, 0}), "objects[1].cylinder.axis: must not be zero"},
        {with("/base/plane/normal", {0, 0, 0}), "base.plane.normal: must not be zero"},
        {"[]", "must be an object, is an array"},
        {"{}", "vcell: missing"},
        {"", "line 1, column 1: expected an object, the text ends"},
        {"nonsense", "line 1, column 1: expected an object, found 'nonsense'"},
    };
    for (const auto& [text, message] : cases) {
        CAPTURE(text);
        CHECK(scene_complaint(text) == message);
    }
}

TEST_CASE("scene file: two kinds of one object, repeated keys, numbers that are none") {
    const std::string text = complete.dump();
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string t = text;
        const auto at = t.find(from);
        REQUIRE(at != t.npos);
        return t.replace(at, from.size(), to);
    };
    CHECK(
        scene_complaint(replaced("{\"name\":\"O1\"", "{\"plane\":{\"point\":[0,0,5],\"normal\":[0,0,1]}")) ==
        "objects[0].sphere: second kind of one object, it is a plane already");
    CHECK(scene_complaint(replaced("\"radius\":0.25", "\"radius\":0.25,\"radius\":0.25")) ==
          "objects[0].sphere.radius: given twice");
    CHECK(scene_complaint(replaced("\"units\":\"m\"", "\"units\":\"m\",\"units\":\"m\"")) ==
          "units: given twice");
    CHECK(scene_complaint(replaced("0.25", "1e999")) ==
          "objects[0].sphere.radius: must be a finite number, 1e999 is out of range");
    CHECK(scene_complaint(replaced("0.25", "NaN")) == "objects[0].sphere.radius: must be a finite number");
    CHECK(scene_complaint(replaced("0.25", "-Infinity")) ==
          "objects[0].sphere.radius: must be a finite number");
    CHECK(scene_complaint(replaced("0.25", ".25")).find("objects[0].sphere.radius: line 1, column ") == 0);
    CHECK(scene_complaint(text + "}") ==
          "line 1, column " + std::to_string(text.size() + 1) + ": expected the end of the text, found '}'");
}

TEST_CASE("scene file: the error knows its object and kind") {
    try {
        parse_scene(with("/objects/1/cylinder/axis/2", "x"));
        FAIL("accepted");
    } catch (const InputError& error) {
        CHECK(error.kind == InputError::Kind::WrongType);
        CHECK(error.object == 1);
        CHECK(error.path == "objects[1].cylinder.axis[2]");
    }
    try {
        parse_scene(with("/tolerance", "x"));
        FAIL("accepted");
    } catch (const InputError& error) {
        CHECK(error.object == InputError::no_object);
    }
}

TEST_CASE("scene file: plain balls over a plane") {
    TextSceneOptions options;
    options.base_plane = Plane{{0, 0, 0}, {0, 0, 1}};
    const Scene scene = parse_scene("# two balls\n0 0 2 0.5 # first\n\n+4 -3.5e0\t2 .25\r\n", options);
    REQUIRE(scene.objects.size() == 2);
    CHECK(std::get<Sphere>(scene.objects[1]).center == Vec3(4, -3.5, 2));
    CHECK(std::get<Sphere>(scene.objects[1]).radius == 0.25);
    CHECK(std::get<Plane>(scene.base).normal == Vec3(0, 0, 1));
    // Balls and their feet fill [-0.5, 4.25] x [-3.75, 0.5] x [0, 2.5].
    const double margin = 0.5 * Vec3(4.75, 4.25, 2.5).norm();
    CHECK((scene.box.min - Vec3(-0.5 - margin, -3.75 - margin, -margin)).norm() < 1e-12);
    CHECK((scene.box.max - Vec3(4.25 + margin, 0.5 + margin, 2.5 + margin)).norm() < 1e-12);
}

TEST_CASE("scene file: one of the balls as base") {
    TextSceneOptions options;
    options.base_ball = 1;
    options.box = Box{{-9, -9, -9}, {9, 9, 9}};
    const Scene scene = parse_scene("0 0 0 1\n5 0 0 1\n0 5 0 2\n", options);
    CHECK(std::get<Sphere>(scene.base).center == Vec3(5, 0, 0));
    REQUIRE(scene.objects.size() == 3);
    CHECK(std::get<Sphere>(scene.objects[2]).radius == 2);
    CHECK(scene.base_object == 1);
    CHECK(scene.objects[1] == scene.base);
    CHECK_FALSE(scene.competes(1));
    CHECK(scene.competes(0));
    CHECK(scene.box.max == Vec3(9, 9, 9));
    std::ostringstream written;
    write_scene(written, scene);
    const Scene again = parse_scene(written.str());
    CHECK(again.base_object == 1);
    CHECK(again.objects == scene.objects);
}

TEST_CASE("scene file: the base's own number must be that of an object like it") {
    CHECK(scene_complaint(with("/base_object", 2)) == "base_object: objects[2] is not the base");
    CHECK(scene_complaint(with("/base_object", 4)) ==
          "base_object: must be less than the number of objects, 4, is 4");
    CHECK(scene_complaint(with("/base_object", -1)) == "base_object: must be a non-negative integer, is -1");
}

TEST_CASE("scene file: a byte order mark before either form") {
    const std::string mark = "\xEF\xBB\xBF";
    CHECK(parse_scene(mark + complete.dump()).objects.size() == 4);
    TextSceneOptions options;
    options.base_ball = 0;
    CHECK(parse_scene(mark + "0 0 0 1\n5 0 0 1\n", options).objects.size() == 2);
    CHECK(parse_scene(mark + "# two balls\n0 0 0 1\n5 0 0 1\n", options).objects.size() == 2);
}

TEST_CASE("scene file: what is no scene is called by its name") {
    CHECK(scene_complaint("HEADER    PLANT PROTEIN                           30-APR-81   1CRN\n") ==
          "there is no atom among what is read");
    CHECK(scene_complaint("data_1CRN\n#\n").starts_with("_atom_site.cartn_x: missing"));
    CHECK(scene_complaint("\xFF\xFE{\0") == "this is UTF-16 text, a scene is UTF-8");
    CHECK(scene_complaint(cell_text(island_cell())).find("this is a cell, not a scene") == 0);
    CHECK(scene_complaint(with("/faces", 1)).find("this is a cell, not a scene") == 0);
}

TEST_CASE("scene file: mistakes in plain balls name the line, or the option") {
    TextSceneOptions plane;
    plane.base_plane = Plane{{0, 0, 0}, {0, 0, 1}};
    CHECK(text_complaint("0 0 1\n", plane) == "line 1: must be x y z r, has 3 of the 4 numbers");
    CHECK(text_complaint("# c\n0 0 1 1 1\n", plane) == "line 2: must be x y z r, has more");
    CHECK(text_complaint("0 0 1 1\n0 O 1 1\n", plane) == "line 2: 'O' is not a number");
    CHECK(text_complaint("0 0 nan 1\n", plane) == "line 1: must be a finite number, is nan");
    CHECK(text_complaint("0 0 inf 1\n", plane) == "line 1: must be a finite number, is inf");
    CHECK(text_complaint("0 0 1e999 1\n", plane) == "line 1: must be a finite number, is 1e999");
    CHECK(text_complaint("0 0 +-1 1\n", plane) == "line 1: '+-1' is not a number");
    CHECK(text_complaint("0 0 1 1\n0 0 1 -1\n", plane) == "line 2: a radius must be >= 0, is -1");
    CHECK(text_complaint("# nothing\n", plane) == "--box: missing, and there is no ball to derive it from");
    CHECK(text_complaint("0 0 1 1\n", {}) ==
          "--base: missing, and so is --base-plane: a file of balls does not say what its base is");
    TextSceneOptions ball;
    ball.base_ball = 2;
    CHECK(text_complaint("0 0 1 1\n0 0 5 1\n", ball) ==
          "--base: must be less than the number of balls, 2, is 2");
    ball.base_plane = plane.base_plane;
    CHECK(text_complaint("0 0 1 1\n", ball) == "--base: excludes --base-plane");
    CHECK(text_complaint(complete.dump(), plane) ==
          "--base-plane: is for files of balls, this scene is JSON");
}

TEST_CASE("scene file: hundreds of thousands of spheres") {
    std::string text = R"({"vcell":1,"base":{"plane":{"point":[0,0,0],"normal":[0,0,1]}},"objects":[)";
    const int n = rounds() > 1 ? 1'000'000 : 250'000;
    for (int i = 0; i < n; ++i) {
        if (i > 0) text += ',';
        text += R"({"sphere":{"center":[)" + std::to_string(i % 1000) + "." + std::to_string(i) + "," +
                std::to_string(i / 1000) + R"(.25,1.5],"radius":0.125}})";
    }
    text += R"(],"box":{"min":[0,0,0],"max":[1000,1000,9]}})";
    const Scene scene = parse_scene(text);
    REQUIRE(scene.objects.size() == static_cast<std::size_t>(n));
    CHECK(std::get<Sphere>(scene.objects[249'999]).center == Vec3(999.249999, 249.25, 1.5));
    CHECK(scene.names.empty());
}

TEST_CASE("scene file: a missing file and a directory are read errors") {
    CHECK_THROWS_AS(read_scene("/nowhere/scene.json"), ReadError);
    CHECK_THROWS_AS(read_scene("/"), ReadError);
}
