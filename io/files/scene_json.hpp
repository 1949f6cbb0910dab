/// A scene as a JSON value, for the files that hold one, and what files of several kinds of scenes share.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../../primitives/objects/scene.hpp"
#include "json_reader.hpp"
#include "json_writer.hpp"

namespace vcell {

/// Structure and types are checked, values are not: validate() does that.
Scene read_scene_value(JsonReader& in);
void write_scene_value(JsonWriter& out, const Scene& scene);

/// The member "vcell" of every file of ours: the version of the format, 1.
void read_format_version(JsonReader& in);
inline constexpr int format_version = 1;

/// [x, y, z]
Vec3 read_vec3(JsonReader& in);
/// An object: exactly one kind, perhaps a name, and where `group` is there perhaps a group.
Object read_object(JsonReader& in, std::string& name, std::string* group = nullptr);
void write_object(JsonWriter& out, const Object& object, const std::string& name);
/// An array of them; names (and groups) stay empty where there are none.
void read_objects(JsonReader& in, std::vector<Object>& objects, std::vector<std::string>& names,
                  std::vector<std::string>* groups = nullptr);
Box read_box(JsonReader& in);

/// Does a text begin as lines of numbers do, and comments between them?
bool is_plain_text(std::string_view text);
/// Calls visit with the ball of each line "x y z r" and the words that follow it, most_words at most; blank
/// lines and comments count for nothing. Throws InputError with the line's number, where it says that a line
/// must be of that form.
void read_ball_lines(std::string_view text, std::string_view form, std::size_t most_words,
                     const std::function<void(const Sphere&, std::span<const std::string_view>)>& visit);
/// TextSceneOptions::box's default. Throws InputError where there is no ball.
Box default_box(std::span<const Sphere> balls, const std::optional<Plane>& base_plane);
/// Throws InputError for a whole file: "what" without a place.
[[noreturn]] void fail_format(const char* what);
/// Throws InputError, which says what it is, for files that people have at hand and that are no scenes.
void refuse_foreign_format(std::string_view text);

}  // namespace vcell
