/// Cylinder bases: the scene in canonical position. See radial_base.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "radial_base.hpp"

namespace vcell {

/// What takes the place of a scene's box and of the stretch in it: rays start on this part of the axis, whose
/// circles may reach beyond the walls, and end there.
struct CylinderPart {
    Box walls;
    std::array<double, 2> stretch;  ///< canonical
    /// On which side of each wall the axis certainly runs, all along the stretch; or the wall is none.
    enum class Wall : std::uint8_t { Inside, Beyond, None };
    std::array<Wall, 6> sides{};
};

/// RadialBaseProblem::frame of a scene whose base is this cylinder.
BaseFrame cylinder_frame(const Scene& scene, const Cylinder& base);

/// Do two tubes of one radius have axes that meet in a point? Exact.
bool cross_equally(const Cylinder& a, const Cylinder& b);

/// A tube that has the base's radius and an axis that crosses the base's, so high over the base in its frame,
/// rounded. The bisector is two planes through there, walls on either side.
struct TubeCrossing {
    std::uint32_t place;  ///< in Scene::objects
    double y;
};
/// All of them, told exactly.
std::vector<TubeCrossing> crossing_tubes(const Scene& scene, const Cylinder& base);

/// radial_base_problem() of a scene whose base is this cylinder, or of a part of it.
RadialBaseProblem cylinder_base_problem(const Scene& scene, const Cylinder& base, double unit,
                                        const CylinderPart* part = nullptr);

/// The base, if it is a tube.
std::optional<Cylinder> base_tube(const Scene& scene);

/// Does the base run into sides of the box obliquely, so that no side is across its axis?
bool is_oblique(const Scene& scene, const Cylinder& base);

/// The radius of the circles that end the stretch of a base cylinder obliquely on the sides of the box: its
/// own, or half a double's digits of the box's diagonal. A line that runs into a side has no clearance there,
/// and distances just before are all but 0 on one side of it only; so far from it, the rounding of the axis
/// is as small a part of the last circle as that is of the box.
double end_radius(const Cylinder& base, const Box& box);

}  // namespace vcell
