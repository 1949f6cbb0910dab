/// What the check of a diagram asks of its cells together: which objects have any, and that two cells agree
/// about what they share.
#pragma once

#include <algorithm>
#include <cstdint>
#include <variant>

#include "check_diagram.hpp"
#include "near_balls.hpp"
#include "near_others.hpp"

namespace vcell::check {

/// Numbers of a file are rounded (check.hpp).
inline constexpr double file_rounding = 0x1p-44;

/// Which objects have cells in the file.
class CellsOfDiagram {
public:
    explicit CellsOfDiagram(const StoredDiagram& diagram) : diagram_(diagram) {}

    bool is_ball(std::uint32_t i) const { return std::holds_alternative<Sphere>(diagram_.scene.objects[i]); }
    const Sphere& ball(std::uint32_t i) const { return std::get<Sphere>(diagram_.scene.objects[i]); }
    bool has_no_cell(std::uint32_t j) const {
        return !std::ranges::binary_search(diagram_.cells, j, {}, [](const auto& c) { return c.first; });
    }
    /// Does the file say that it has no cell of the object, or not all of it?
    bool is_lacking(std::uint32_t j) const {
        return std::ranges::binary_search(diagram_.lacking, j, {}, &StoredDiagram::Lacking::object);
    }
    /// Is a ball's centre on a side of the box or beyond it? There it may have no cell in the file, though it
    /// owns something. The box does not repeat along an axis along which it is.
    bool is_beyond(std::uint32_t i) const {
        const Vec3& c = ball(i).center;
        for (int k = 0; k < 3; ++k)
            if (!diagram_.scene.periodic[static_cast<std::size_t>(k)] &&
                !(c[k] > diagram_.scene.box.min[k] && c[k] < diagram_.scene.box.max[k]))
                return true;
        return false;
    }
    /// Is the object's cell to agree with others'? Numbers of no object are of pairs, too, to be refuted.
    /// Balls without a cell own nothing, but where they are beyond the box or the file lacks them.
    bool is_paired(std::uint32_t i) const {
        return i >= diagram_.scene.objects.size() || !has_no_cell(i) ||
               (is_ball(i) && !is_beyond(i) && !is_lacking(i));
    }

private:
    const StoredDiagram& diagram_;
};

/// Adds an element for each pair of cells: that they agree about what two of them share. `rounding`: of
/// points of a file, in the scene's unit.
///
/// Cells of planes and tubes that lean are decided about in scenes of their own, which moved by some
/// roundings (Report::moved): what two cells have in common may meet in one and not in the other. So a vertex
/// that one of them has alone is to lie on an edge of the other one, within both errors, which belongs to
/// sites of the vertex.
///
/// Tubes in a box that repeats have one period of their cells in a file, which cuts faces and edges: pairs
/// with these have one area between them, and those of a tube and a ball the same vertices. Pairs of tubes
/// have vertices that are the same after periods of either, and these are not compared.
void certify_pairs(const StoredDiagram& diagram, const NearBalls& balls, const NearOthers& others,
                   double rounding, Certificate& certificate);

}  // namespace vcell::check
