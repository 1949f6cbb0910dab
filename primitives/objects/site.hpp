/// Who may own a piece of a cell's boundary.
#pragma once

#include "../../core/platform.hpp"

#include <cstdint>
#include <string>

namespace vcell {

/// An object of the scene, the base, a side of the box, an end of a base cylinder's stretch, or the cap where
/// clearance ends (Scene::probe).
struct Site {
    enum class Kind : std::uint8_t { Object, Base, BoxSide, End, Cap };

    /// A cap has this number where a scene is decided about: it is an object there (decided_scene.hpp).
    static constexpr std::uint32_t number_of_cap = UINT32_MAX;

    Kind kind = Kind::Base;
    /// Object: index into Scene::objects. BoxSide: 0..5 = -x +x -y +y -z +z. End: 0 = '-', 1 = '+'.
    std::uint32_t index = 0;

    static Site object(std::uint32_t i) { return {Kind::Object, i}; }
    static Site base() { return {Kind::Base, 0}; }
    static Site box_side(std::uint32_t side) { return {Kind::BoxSide, side}; }
    static Site end(std::uint32_t which) { return {Kind::End, which}; }
    static Site cap() { return {Kind::Cap, 0}; }

    bool is_object() const { return kind == Kind::Object; }
    friend auto operator<=>(const Site&, const Site&) = default;
};

/// "3", "base", "box:-x", "end:+", "cap": as files write it (objects as numbers).
std::string to_string(Site site);

}  // namespace vcell
