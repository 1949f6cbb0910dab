#include "coordinate_surface.hpp"

#include <Eigen/Geometry>

namespace vcell {

void CoordinateSurface::set_axes(Kind kind, const Vec3& x, const Vec3& y, const Vec3& origin) {
    kind_ = kind;
    axes_ = {x, y, x.cross(y)};
    origin_ = origin;
    if (kind == Kind::Planar || kind == Kind::Graph)
        coordinates_ = {PatchCoordinate::linear(x, origin), PatchCoordinate::linear(y, origin)};
    if (kind == Kind::Stereographic)
        coordinates_ = {PatchCoordinate::half_angle(origin, axes_[2], x, 0),
                        PatchCoordinate::half_angle(origin, axes_[2], y, 0)};
}

void CoordinateSurface::set_coordinates(const PatchCoordinate& u) {
    coordinates_[0] = u;
    coordinates_[1].numerator << along_, along_across_, along_start_;
}

}  // namespace vcell
