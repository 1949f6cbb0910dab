#include "scene_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "files.hpp"
#include "scene_json.hpp"
#include "text.hpp"

namespace vcell {

Vec3 read_vec3(JsonReader& in) {
    Vec3 v;
    in.array_of(3, [&](std::size_t i) { v[static_cast<Eigen::Index>(i)] = in.number(); });
    return v;
}

void read_format_version(JsonReader& in) {
    const double version = in.number();
    if (version != format_version)
        in.fail(InputError::Kind::Unsupported, fmt::format("must be {}, is {}", format_version, version));
}

namespace {

Plane read_plane(JsonReader& in) {
    Plane plane;
    in.object(required_member("point", [&] { plane.point = read_vec3(in); }),
              required_member("normal", [&] { plane.normal = read_vec3(in); }));
    return plane;
}

Sphere read_sphere(JsonReader& in) {
    Sphere sphere;
    in.object(required_member("center", [&] { sphere.center = read_vec3(in); }),
              required_member("radius", [&] { sphere.radius = in.number(); }));
    return sphere;
}

Cylinder read_cylinder(JsonReader& in) {
    Cylinder cylinder;
    in.object(required_member("point", [&] { cylinder.point = read_vec3(in); }),
              required_member("axis", [&] { cylinder.axis = read_vec3(in); }),
              required_member("radius", [&] { cylinder.radius = in.number(); }));
    return cylinder;
}

HollowSphere read_hollow_sphere(JsonReader& in) {
    const Sphere wall = read_sphere(in);
    return {wall.center, wall.radius};
}

HollowCylinder read_hollow_cylinder(JsonReader& in) {
    const Cylinder wall = read_cylinder(in);
    return {wall.point, wall.axis, wall.radius};
}

// Half of its angle has a sine: as a quotient that is exact, or rounded once.
HollowCone read_hollow_cone(JsonReader& in) {
    HollowCone cone;
    std::optional<double> radius, slant, half_angle;
    in.object(
        required_member("apex", [&] { cone.apex = read_vec3(in); }),
        required_member("axis", [&] { cone.axis = read_vec3(in); }),
        optional_member("radius", [&] { radius = in.number(); }),
        optional_member("slant", [&] { slant = in.number(); }), optional_member("half_angle", [&] {
            const double degrees = in.number();
            // Rounded from more digits: that of 30 is one half.
            half_angle = static_cast<double>(std::sin(degrees * (std::numbers::pi_v<long double> / 180)));
            if (!(degrees < 90 && *half_angle > 0 && *half_angle < 1))
                in.fail(InputError::Kind::OutOfRange,
                        fmt::format("must be between 0 and 90 degrees, with a sine that is told from 0 and "
                                    "1, is {}",
                                    degrees));
        }));
    if (half_angle ? radius || slant : !(radius && slant))
        in.fail(InputError::Kind::MissingKey, "must hold either radius and slant, or half_angle");
    cone.radius = half_angle ? *half_angle : *radius;
    cone.slant = half_angle ? 1 : *slant;
    return cone;
}

}  // namespace

Object read_object(JsonReader& in, std::string& name, std::string* group) {
    Object object;
    const char* kind = nullptr;
    const auto set = [&](const char* new_kind, auto read) {
        if (kind)
            in.fail(InputError::Kind::WrongType,
                    fmt::format("second kind of one object, it is a {} already", kind));
        kind = new_kind;
        object = read(in);
    };
    const auto plane = optional_member("plane", [&] { set("plane", read_plane); });
    const auto sphere = optional_member("sphere", [&] { set("sphere", read_sphere); });
    const auto cylinder = optional_member("cylinder", [&] { set("cylinder", read_cylinder); });
    const auto ball = optional_member("hollow_sphere", [&] { set("hollow_sphere", read_hollow_sphere); });
    const auto tube =
        optional_member("hollow_cylinder", [&] { set("hollow_cylinder", read_hollow_cylinder); });
    const auto cone = optional_member("hollow_cone", [&] { set("hollow_cone", read_hollow_cone); });
    const auto named = optional_member("name", [&] { name = in.string(); });
    if (group == nullptr)
        in.object(plane, sphere, cylinder, ball, tube, cone, named);
    else
        in.object(plane, sphere, cylinder, ball, tube, cone, named,
                  optional_member("group", [&] { *group = in.string(); }));
    if (!kind)
        in.fail(InputError::Kind::MissingKey,
                "must hold one of plane, sphere, cylinder, hollow_sphere, hollow_cylinder, hollow_cone, "
                "holds none");
    return object;
}

void read_objects(JsonReader& in, std::vector<Object>& objects, std::vector<std::string>& names,
                  std::vector<std::string>* groups) {
    // Few scenes have names: none is stored before the first.
    const auto store = [](std::vector<std::string>& texts, std::size_t i, std::string text) {
        if (!text.empty()) texts.resize(i);
        if (!text.empty() || !texts.empty()) texts.push_back(std::move(text));
    };
    in.array([&](std::size_t i) {
        in.object_index = static_cast<std::uint32_t>(i);
        std::string name, group;
        objects.push_back(read_object(in, name, groups != nullptr ? &group : nullptr));
        store(names, i, std::move(name));
        if (groups != nullptr) store(*groups, i, std::move(group));
    });
    in.object_index = InputError::no_object;
}

Box read_box(JsonReader& in) {
    Box box;
    in.object(required_member("min", [&] { box.min = read_vec3(in); }),
              required_member("max", [&] { box.max = read_vec3(in); }));
    return box;
}

void write_object(JsonWriter& out, const Object& object, const std::string& name) {
    out.object([&] {
        if (const auto* plane = std::get_if<Plane>(&object))
            out.key("plane").object([&] {
                out.key("point").value(plane->point);
                out.key("normal").value(plane->normal);
            });
        const auto ball = [&](const char* key, const auto& o) {
            out.key(key).object([&] {
                out.key("center").value(o.center);
                out.key("radius").value(o.radius);
            });
        };
        const auto tube = [&](const char* key, const auto& o) {
            out.key(key).object([&] {
                out.key("point").value(o.point);
                out.key("axis").value(o.axis);
                out.key("radius").value(o.radius);
            });
        };
        if (const auto* sphere = std::get_if<Sphere>(&object)) ball("sphere", *sphere);
        if (const auto* cylinder = std::get_if<Cylinder>(&object)) tube("cylinder", *cylinder);
        if (const auto* vessel = std::get_if<HollowSphere>(&object)) ball("hollow_sphere", *vessel);
        if (const auto* vessel = std::get_if<HollowCylinder>(&object)) tube("hollow_cylinder", *vessel);
        if (const auto* cone = std::get_if<HollowCone>(&object))
            out.key("hollow_cone").object([&] {
                out.key("apex").value(cone->apex);
                out.key("axis").value(cone->axis);
                out.key("radius").value(cone->radius);
                out.key("slant").value(cone->slant);
            });
        if (!name.empty()) out.key("name").value(name);
    });
}

Scene read_scene_value(JsonReader& in) {
    Scene scene;
    in.object(
        required_member("vcell", [&] { read_format_version(in); }),
        required_member("base", [&] { scene.base = read_object(in, scene.base_name); }),
        required_member("objects", [&] { read_objects(in, scene.objects, scene.names); }),
        optional_member(
            "base_object",
            [&] { scene.base_object = static_cast<std::uint32_t>(in.unsigned_integer(UINT32_MAX - 1)); }),
        required_member("box", [&] { scene.box = read_box(in); }),
        optional_member("units", [&] { scene.units = in.string(); }),
        optional_member("tolerance", [&] { scene.tolerance = in.number(); }),
        optional_member("probe", [&] { scene.probe = in.number(); }));
    return scene;
}

void write_scene_value(JsonWriter& out, const Scene& scene) {
    out.object([&] {
        out.key("vcell").value(format_version);
        out.line_key("base");
        write_object(out, scene.base, scene.base_name);
        std::size_t i = 0;
        out.line_key("objects").lines(scene.objects, [&](const Object& object) {
            write_object(out, object, i < scene.names.size() ? scene.names[i] : std::string());
            ++i;
        });
        if (scene.base_object) out.line_key("base_object").value(*scene.base_object);
        out.line_key("box").object([&] {
            out.key("min").value(scene.box.min);
            out.key("max").value(scene.box.max);
        });
        out.line_key("units").value(scene.units);
        if (scene.tolerance) out.line_key("tolerance").value(*scene.tolerance);
        if (scene.probe) out.line_key("probe").value(*scene.probe);
    });
}

void write_scene(std::ostream& out, const Scene& scene) {
    JsonWriter writer(out);
    write_scene_value(writer, scene);
    writer.finish();
    out << '\n';
}

namespace {

[[noreturn]] void fail_option(const char* option, const std::string& what) {
    throw InputError(InputError::Kind::MissingKey, InputError::no_object, option, what);
}

}  // namespace

void read_ball_lines(std::string_view text, std::string_view form, std::size_t most_words,
                     const std::function<void(const Sphere&, std::span<const std::string_view>)>& visit) {
    std::size_t line_number = 0;
    std::vector<std::string_view> words;
    for (std::size_t at = 0; at < text.size();) {
        std::string_view line = next_line(text, at);
        ++line_number;
        const auto fail = [&](const std::string& what) {
            throw InputError(InputError::Kind::Syntax, InputError::no_object,
                             fmt::format("line {}", line_number),
                             fmt::format("must be {}, has {}", form, what));
        };
        words.clear();
        std::array<double, 4> numbers{};
        std::size_t count = 0;
        for (std::string_view word; !(word = next_word(line)).empty(); ++count) {
            if (count == 4 + most_words) fail("more");
            if (count < 4)
                numbers[count] =
                    count < 3 ? parse_number(word, line_number) : parse_radius(word, line_number);
            else
                words.push_back(word);
        }
        if (count == 0) continue;
        if (count < 4) fail(fmt::format("{} of the 4 numbers", count));
        visit({Vec3(numbers[0], numbers[1], numbers[2]), numbers[3]}, words);
    }
}

namespace {

std::vector<Sphere> read_balls(std::string_view text) {
    std::vector<Sphere> balls;
    read_ball_lines(text, "x y z r", 0,
                    [&](const Sphere& ball, std::span<const std::string_view>) { balls.push_back(ball); });
    return balls;
}

}  // namespace

Box default_box(std::span<const Sphere> balls, const std::optional<Plane>& base_plane) {
    if (balls.empty()) fail_option("--box", "missing, and there is no ball to derive it from");
    Box box{balls[0].center, balls[0].center};
    const auto include = [&](const Vec3& p) {
        box.min = box.min.cwiseMin(p);
        box.max = box.max.cwiseMax(p);
    };
    for (const Sphere& ball : balls) {
        include(ball.center - Vec3::Constant(ball.radius));
        include(ball.center + Vec3::Constant(ball.radius));
        if (base_plane) {
            const Vec3 n = base_plane->normal.stableNormalized();
            include(ball.center - n.dot(ball.center - base_plane->point) * n);
        }
    }
    const Vec3 margin = Vec3::Constant(0.5 * box.diagonal());
    return {box.min - margin, box.max + margin};
}

namespace {

// The scene of balls, of a file or of lines: one of them, or a plane, is the base.
Scene scene_of_balls(BallFile file, const TextSceneOptions& options) {
    if (options.base_ball && options.base_plane) fail_option("--base", "excludes --base-plane");
    if (!options.base_ball && !options.base_plane)
        fail_option("--base",
                    "missing, and so is --base-plane: a file of balls does not say what its base is");
    if (file.periodic != std::array{false, false, false})
        fail_format("the box of this file repeats; vcell diagram computes its cells");
    const std::vector<Sphere>& balls = file.balls;
    Scene scene;
    scene.names = std::move(file.names);
    if (!file.units.empty()) scene.units = file.units;
    const std::optional<Box>& box = options.box ? options.box : file.box;
    scene.box = box ? *box : default_box(balls, options.base_plane);
    scene.objects.assign(balls.begin(), balls.end());
    if (options.base_plane) {
        scene.base = *options.base_plane;
        return scene;
    }
    if (*options.base_ball >= balls.size())
        throw InputError(InputError::Kind::OutOfRange, InputError::no_object, "--base",
                         fmt::format("must be less than the number of balls, {}, is {}", balls.size(),
                                     *options.base_ball));
    scene.base = balls[*options.base_ball];
    if (!scene.names.empty()) scene.base_name = scene.names[*options.base_ball];
    scene.base_object = static_cast<std::uint32_t>(*options.base_ball);
    return scene;
}

}  // namespace

void fail_format(const char* what) {
    throw InputError(InputError::Kind::Syntax, InputError::no_object, "", what);
}

void refuse_foreign_format(std::string_view text) {
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
        fail_format("this is UTF-16 text, a scene is UTF-8");
}

bool is_plain_text(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    return first != text.npos && std::string_view("0123456789+-.#").find(text[first]) != text.npos;
}

namespace {

// What a cell file has at its top and a scene has not.
bool is_key_of_cell(std::string_view path) {
    for (const std::string_view key :
         {"scene", "vertices", "edges", "faces", "neighbors", "measures", "report"})
        if (path == key) return true;
    return false;
}

Scene parse_json_scene(std::string_view text) try {
    JsonReader reader(text);
    Scene scene = read_scene_value(reader);
    reader.end();
    return scene;
} catch (const InputError& e) {
    if (e.kind != InputError::Kind::UnknownKey || !is_key_of_cell(e.path)) throw;
    fail_format("this is a cell, not a scene: the scene is what it has under the key \"scene\"");
}

}  // namespace

Scene parse_scene(std::string_view text, const TextSceneOptions& options) {
    text = without_byte_order_mark(text);
    Scene scene;
    if (std::optional<BallFile> file = parse_ball_file(text, options.files)) {
        scene = scene_of_balls(*std::move(file), options);
    } else if (is_plain_text(text)) {
        BallFile lines;
        lines.balls = read_balls(text);
        scene = scene_of_balls(std::move(lines), options);
    } else {
        refuse_foreign_format(text);
        if (options.any())
            throw InputError(InputError::Kind::Unsupported, InputError::no_object,
                             options.base_ball    ? "--base"
                             : options.base_plane ? "--base-plane"
                                                  : "--box",
                             "is for files of balls, this scene is JSON");
        scene = parse_json_scene(text);
    }
    validate(scene);
    return scene;
}

Scene read_scene(const std::string& path, const TextSceneOptions& options) {
    return parse_scene(read_file(path), options);
}

}  // namespace vcell
