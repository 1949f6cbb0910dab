/// Families of scenes on which certified signs are hard to come by: exact ties, near ties, contact, extreme
/// places and scales. Every scene is legal: its objects stay clear of the base as voronoi_cell() asks.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <string>

#include "../../primitives/objects/scene.hpp"

namespace vcell::hunt {

enum class BaseKind : std::uint8_t { Plane, TiltedPlane, Ball, Tube, TiltedTube };
inline constexpr BaseKind base_kinds[] = {BaseKind::Plane, BaseKind::TiltedPlane, BaseKind::Ball,
                                          BaseKind::Tube, BaseKind::TiltedTube};
std::string to_string(BaseKind kind);  ///< "plane", "tilted-plane", "ball", "tube", "tilted-tube"

struct Family {
    const char* name;
    const char* about;
    Scene (*make)(std::mt19937_64& rng, BaseKind base);
};

std::span<const Family> families();

/// Does voronoi_cell() take the scene, as far as its objects' places count?
bool is_legal(const Scene& scene);

/// Times a factor, and then moved.
void transform(Object& object, double factor, const Vec3& shift);

}  // namespace vcell::hunt
