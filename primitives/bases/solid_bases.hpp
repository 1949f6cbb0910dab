/// Bases for the points that are equally far from three solids, wherever these overlap.
///
/// A solid is a ball, a tube, or the half space behind a plane; distances from it are signed, and points
/// count outside all three. Seen from the base along its rays the bisector with another solid is one height
/// still, and the heights of radial_base.hpp are right for it wherever C > 0. The round solid of the least
/// radius R0 is the base. Then C <= 0 says that the base point's centre or axis point is deeper in the other
/// solid than R0, all of its ray is nearer to that, and there is nothing to look for: around a ball nowhere
/// at all, around a tube over a part of its axis, which is left out. Near the ends of such a part C is all
/// but 0, and so are heights. Rays are nearest to the base outside the other solid alone, where t >= R0; and
/// where they are as far from the third one, which is e = d(f) from the axis point f, t >= (e + R0) / 2. So a
/// little more of the axis is left out, as far as intervals prove t to be half as much at most.
///
/// Half spaces may cut the base. With all three solids drawn in by one length s <= R0, distances are s more
/// and nothing else changes: of the base next to nothing is left, and the plane is clear of that wherever
/// C > 0. Radii stay exact, s being short; planes move by rounding.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "../objects/scene.hpp"
#include "radial_base.hpp"

namespace vcell {

/// Are they one surface, whatever describes it? Exact.
bool is_same_surface(const Object& a, const Object& b);

/// Does one of the solids lie in another one and touch it along a line? Then all points of a half plane
/// beyond that line are as far from both, and those equally far from the third are where no bisectors cross.
/// False where the third one lies in that other one, too, and has nothing there. Exact; planes are half
/// spaces.
bool touch_along_line(const std::array<Object, 3>& solids);

/// Is no point in both balls or tubes? True is proved; of planes it is never said.
bool are_certainly_apart(const Object& a, const Object& b);

/// The round object of the least radius, a ball if there are several; none among planes.
std::optional<std::size_t> thinnest(std::span<const Object> objects);

struct SolidProblems {
    Scene scene;       ///< what the problems are of: drawn in
    double moved = 0;  ///< bounds what rounding has moved in that
    std::vector<RadialBaseProblem> parts;
};

/// All that must be looked at: nothing, the base, or parts of its axis. The scene's planes are half spaces
/// with outward normals.
/// Throws as radial_base_problem() does where a problem is left that is none after all; UndecidedError where
/// solids touch so that doubles do not tell where the base is clear of them: a half space or tube that has
/// the base touch it from within, equal tubes whose axes cross.
/// Pre: validate(scene) has passed; the base is round, and no object is thinner.
SolidProblems solid_problems(const Scene& scene, double unit);

}  // namespace vcell
