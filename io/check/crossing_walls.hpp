/// A tube of a base tube's radius whose axis crosses the base's own: both are equally near in two planes
/// through there. What of the cell has its feet on one side of the crossing lies between them, so that there
/// they take the tube's place, like sides of the box.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

#include "../../primitives/objects/exact_space.hpp"
#include "vectors.hpp"

namespace vcell::check {

/// Do the axes of two tubes of one radius cross in a point? Exact.
inline bool cross_equally(const Cylinder& a, const Cylinder& b) {
    if (a.radius != b.radius) return false;
    const ExactVector across = cross(ExactVector(a.axis), ExactVector(b.axis));
    return !across.is_zero() && dot(ExactVector(b.point) - ExactVector(a.point), across).sign() == Sign::Zero;
}

template <class T>
struct CrossingWalls {
    Vector<T> point;
    /// Unit, and outwards as seen from the base's axis beyond the crossing, or before it.
    std::array<Vector<T>, 2> normals;

    /// They are computed in Wide numbers, as axes may be all but parallel. Pre: these cross.
    CrossingWalls(const Cylinder& base, const Cylinder& tube, bool is_beyond) {
        const auto unit = [](const Vec3& v) {
            const Vector<Wide> w = to_vector<Wide>(v);
            return check::direction(w, sqrt(square(w)));
        };
        const Vector<Wide> d = unit(base.axis), e = unit(tube.axis), across = cross(d, e),
                           from = to_vector<Wide>(base.point), way = to_vector<Wide>(tube.point) - from;
        point = narrowed(from + dot(cross(way, e), across) / square(across) * d);
        const Wide sense(is_beyond ? 1.0 : -1.0);
        for (const std::size_t k : {0, 1}) {
            const Vector<Wide> n = k == 0 ? sense * (e - d) : -sense * (e + d);
            normals[k] = narrowed(check::direction(n, sqrt(square(n))));
        }
    }

    /// The distance from a wall inwards.
    T inside(std::size_t wall, const Vector<T>& p) const { return dot(normals[wall], point - p); }

private:
    static Vector<T> narrowed(const Vector<Wide>& v) {
        if constexpr (std::is_same_v<T, Wide>)
            return v;
        else
            return {v[0].enclosure(), v[1].enclosure(), v[2].enclosure()};
    }
};

}  // namespace vcell::check
