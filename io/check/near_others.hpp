/// Which images of objects that are no balls may be near to a place, in a diagram whose box repeats.
///
/// An object that is no ball may be where it was after some moves by edges (VoronoiDiagram::periods), which
/// are found here from the file's numbers alone, and hold exactly. Files name an image by any that is the
/// same; here representative() stands for all of them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "near_balls.hpp"

namespace vcell::check {

class NearOthers {
public:
    /// Pre: the scene is valid. Keeps references.
    NearOthers(const DiagramScene& scene, const NearBalls& balls);

    struct Found {
        ObjectImage object;
        Object shape;  // where the image is, exactly
    };
    struct Search {
        std::vector<Found> found;  // ascending
        std::string lack;          // as of NearBalls::Search
    };
    /// All images that may be nearer to the point than `reach`: none but the object itself where the box does
    /// not repeat, and of planes and vessels.
    Search search(const Vec3& point, double reach) const;

    /// Balls, and what is no object, have none.
    const std::vector<ImageIndex>& periods(std::uint32_t object) const {
        static const std::vector<ImageIndex> none;
        return object < periods_.size() ? periods_[object] : none;
    }
    /// Names one of all images that are one, as seen from an object that is also where it was after some
    /// moves.
    ImageIndex representative(const ObjectImage& image, std::optional<std::uint32_t> seen_from = {}) const;

    /// The axis of the box across which the cell of a tube is cut to one period: that which its axis has the
    /// most way along. None: the tube does not close on itself.
    std::optional<int> cut_of(const Cylinder& tube, std::uint32_t object) const;
    /// Why the box does not hold all of the cell of a tube or a plane, or one period of it; empty: it does.
    /// `edges`: those of the cell in that box, whose sides along which the scene repeats, but for the cut, it
    /// does not come to.
    std::string lack_of_room(const Box& box, std::uint32_t object, const std::vector<CellEdge>& edges) const;

private:
    bool repeats() const { return scene_.periodic[0] || scene_.periodic[1] || scene_.periodic[2]; }
    void find_periods(std::uint32_t object);
    Box piece(const Cylinder& tube, std::uint32_t object, const Vec3& point, double reach) const;
    std::string lack_of_period(const Box& box, int cut, const ImageIndex& period,
                               const std::vector<CellEdge>& edges) const;
    Box room(const Cylinder& tube) const;

    const DiagramScene& scene_;
    const NearBalls& balls_;
    std::vector<std::vector<ImageIndex>> periods_;
};

}  // namespace vcell::check
