/// The images of an object that is no ball, in a box that repeats.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "../object_distance.hpp"
#include "own_periods.hpp"

namespace vcell::whole {

class OtherImages {
public:
    /// Pre: own_periods() has some of the object, which is aligned to them, and its point is on the grid.
    OtherImages(const Lattice& lattice, const Object& object)
        : lattice_(lattice), object_(object), periods_(*own_periods(lattice, object)) {}

    const Object& object() const { return object_; }
    const std::vector<Image>& periods() const { return periods_; }
    /// Where the image is: representatives are moved exactly.
    Object moved(const Image& image) const {
        Object object = object_;
        if (auto* tube = std::get_if<Cylinder>(&object)) tube->point += lattice_.shift(image);
        return object;
    }

    /// Calls visit(object, image) for each image that may be less than `reach` from the point, ascending,
    /// those that are one being called once. Planes and vessels are always near.
    template <class Visit>
    void near(const Vec3& point, double reach, Visit&& visit) const {
        const auto* tube = std::get_if<Cylinder>(&object_);
        if (tube == nullptr || !lattice_.repeats()) return visit(object_, Image{0, 0, 0});
        std::vector<Image> found;
        lattice_.for_images(piece_at(*tube, point, reach), tube->radius, point, reach,
                            [&](const Image& image, const Vec3& by) {
                                const Cylinder moved{tube->point + by, tube->axis, tube->radius};
                                if (least_distance(moved, Sphere{point, 0}) < reach)
                                    found.push_back(representative(image, periods_));
                            });
        std::ranges::sort(found);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        for (const Image& image : found) visit(moved(image), image);
    }

private:
    // Holds a piece of the axis of which some image is where any image is that near to the point.
    Box piece_at(const Cylinder& tube, const Vec3& point, double reach) const {
        if (!periods_.empty()) return between(tube.point, tube.point + lattice_.shift(periods_.front()));
        int across = -1;
        for (int k = 0; k < 3; ++k)
            if (!lattice_.repeats(k) && (across < 0 || std::abs(tube.axis[k]) > std::abs(tube.axis[across])))
                across = k;
        const Vec3 step = tube.axis / tube.axis[across],
                   middle = tube.point + (point[across] - tube.point[across]) * step;
        const double far = std::max(0.0, reach + tube.radius);
        return between(middle - far * step, middle + far * step);
    }
    static Box between(const Vec3& a, const Vec3& b) { return {a.cwiseMin(b), a.cwiseMax(b)}; }

    Lattice lattice_;
    Object object_;
    std::vector<Image> periods_;
};

}  // namespace vcell::whole
