/// Scene files: the JSON form (docs/files.md, "Scene") and plain `x y z r` text.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>

#include "../../primitives/objects/scene.hpp"
#include "ball_file.hpp"

namespace vcell {

/// What files of balls do not say themselves. JSON scenes say it all and take none of these.
struct TextSceneOptions {
    /// The ball that is the base, counted from 0; Scene::base_object. All balls keep their numbers.
    std::optional<std::size_t> base_ball;
    /// The base plane; then every ball is an object.
    std::optional<Plane> base_plane;
    /// Default: the bounding box of the balls, and over a plane of their feet on it too, grown by half
    /// its diagonal on every side.
    std::optional<Box> box;
    BallFileOptions files;

    bool any() const { return base_ball || base_plane || box; }
};

/// A scene from text: a file of another program if it begins like one (ball_file.hpp), otherwise JSON unless
/// the first character that is not blank begins a number or a comment. In an `x y z r` file every line holds
/// one ball; '#' begins a comment; blank lines count for nothing. A byte order mark is skipped. The scene is
/// validated. Throws InputError; what is wrong with the options has a path like the program's: "--base".
Scene parse_scene(std::string_view text, const TextSceneOptions& options = {});

/// parse_scene of a file, of standard input for "-". Throws ReadError, InputError.
Scene read_scene(const std::string& path, const TextSceneOptions& options = {});

/// The JSON form; reading it gives the same scene.
void write_scene(std::ostream& out, const Scene& scene);

}  // namespace vcell
