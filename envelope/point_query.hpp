/// Who owns a point's ray, and whether the point lies in the cell.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../primitives/objects/scene.hpp"
#include "../primitives/objects/site.hpp"

namespace vcell {

struct PointAnswer {
    /// Owner of the ray, the cap of a scene with a probe among them; of sites that tie, the first. None at
    /// the centre of a sphere or on a cylinder's axis, where rays of all directions start.
    std::optional<Site> site;
    double clearance = 0;  ///< of the cell's boundary on the ray, length; meaningless without an owner
    bool inside = false;   ///< the point lies in the closed cell
};

/// Answers questions about a scene's cell point by point, without computing the cell: O(n) to begin with,
/// O(log n) each where there are many (recursion/form_locator.hpp).
class PointQuery {
public:
    /// Throws InputError and UndecidedError as voronoi_cell() does for scenes that it refuses to begin with.
    explicit PointQuery(const Scene& scene);
    PointQuery(PointQuery&&) noexcept;
    PointQuery& operator=(PointQuery&&) noexcept;
    ~PointQuery();

    /// About the ray through a world point along the base's normal, decided exactly for the point that
    /// canonical position rounds it to. None: the ray starts outside the base region, or on a tube's axis
    /// where another object holds or crosses it (AxisParts).
    ///
    /// Over a sphere or a cylinder it is the ray from the centre or axis in the direction that the chart's
    /// coordinates, in double, round the canonical point's to; along it, the point's exact distance decides.
    /// At the pole of a sphere's chart it is a direction next to it, within 2^-30. What the cell's boundary
    /// leaves of the base's body belongs to the cell.
    std::optional<PointAnswer> operator()(const Vec3& world);

    /// What the scene's own warnings are (Report::warnings).
    const std::vector<std::string>& warnings() const;

private:
    struct Bases;
    std::unique_ptr<Bases> bases_;
};

}  // namespace vcell
