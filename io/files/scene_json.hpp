/// A scene as a JSON value, for the files that hold one.
#pragma once

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

}  // namespace vcell
