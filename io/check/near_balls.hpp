/// Which balls of a diagram may be near to one of them, images included where the box repeats.
///
/// Where an image is must be told without rounding: its coordinates are sums of the ball's and of multiples
/// of the box's edges, and each of these sums is a double if coordinates are multiples of one power of two
/// with few enough digits. So they are in a file, as the scene was moved to such a grid before anything was
/// decided (DiagramWriter); what is no double is told as such, and nothing is proved with it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../envelope/voronoi_diagram.hpp"

namespace vcell::check {

/// By how many edges of the box something is moved.
using ImageIndex = std::array<std::int16_t, 3>;

class NearBalls {
public:
    /// Pre: the scene is valid. Keeps a reference.
    explicit NearBalls(const DiagramScene& scene);

    struct Found {
        ObjectImage object;
        Sphere ball;  // where the image is, exactly
    };
    struct Search {
        std::vector<Found> found;  // ascending
        std::string lack;          // why these may not be all, or not where they are; empty: they are
    };
    /// All balls and images whose surfaces may be nearer to that of ball i than `reach`, without the ball
    /// itself. Pre: object i is a ball.
    Search search(std::uint32_t i, double reach) const {
        return search(std::get<Sphere>(scene_.objects[i]), i, reach);
    }
    /// Searches around any ball, which needs not be one of the scene.
    Search search(const Sphere& around, double reach) const { return search(around, UINT32_MAX, reach); }

    /// No point of a cell is farther from the centre of its ball, which lies within the sides of the box that
    /// do not repeat: infinite where none does.
    double farthest() const;
    /// By how much an image is moved, rounded.
    Vec3 shift(const ImageIndex& image) const;
    /// Where a point is moved to; none where that is no double.
    std::optional<Vec3> moved(const Vec3& p, const ImageIndex& image) const;
    /// Calls visit(image) for all in which a point of the box `of` may be no farther from p than that; false
    /// where these are too many. The edges (x, 0, 0), (xy, y, 0) and (xz, yz, z) are counted one after the
    /// other, the last one first.
    template <class Visit>
    bool for_images(const Box& of, const Vec3& p, double far, const Visit& visit) const;

private:
    using Cube = std::array<std::int64_t, 3>;
    struct Ball {
        Sphere ball;
        std::uint32_t number;
    };

    Cube cube(const Vec3& p) const;
    template <class Visit>
    void in_cubes(const Vec3& p, double far, const Visit& visit) const;
    Search search(const Sphere& self, std::uint32_t i, double reach) const;
    // Images beyond these are too many to be looked at, or to be counted.
    static constexpr double most_images = 0x1p20, most_edges = 0x1p14;
    bool repeats() const { return scene_.periodic[0] || scene_.periodic[1] || scene_.periodic[2]; }

    const DiagramScene& scene_;
    std::array<double, 3> size_{};  // of the box
    bool is_exact_ = true;          // its size along axes along which it repeats
    std::vector<Ball> balls_;
    Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();     // of the centres
    double edge_ = 1, largest_ = 0;                     // of cubes; the largest radius
    std::map<Cube, std::vector<std::uint32_t>> cubes_;  // places of balls where their centres are
};

template <class Visit>
bool NearBalls::for_images(const Box& of, const Vec3& p, double far, const Visit& visit) const {
    const auto range = [&](int axis, const Interval& by) -> std::optional<std::array<int, 2>> {
        const auto k = static_cast<std::size_t>(axis);
        if (!scene_.periodic[k]) return std::array{0, 0};
        const Interval from = Interval(p[axis]) - Interval(of.min[axis], of.max[axis]) + Interval(-far, far),
                       n = (from - by) / Interval(size_[k]);
        if (!(n.lower() > -most_edges && n.upper() < most_edges)) return std::nullopt;
        return std::array{static_cast<int>(std::ceil(n.lower())), static_cast<int>(std::floor(n.upper()))};
    };
    const auto times = [](int n, double x) { return Interval(n) * Interval(x); };
    const auto& [xy, xz, yz] = scene_.tilt;
    double count = 0;
    const auto zs = range(2, Interval(0.0));
    if (!zs) return false;
    for (int c = (*zs)[0]; c <= (*zs)[1]; ++c) {
        const auto ys = range(1, times(c, yz));
        if (!ys) return false;
        for (int b = (*ys)[0]; b <= (*ys)[1]; ++b) {
            const auto xs = range(0, times(b, xy) + times(c, xz));
            if (!xs || (count += std::max(0, (*xs)[1] - (*xs)[0] + 1)) > most_images) return false;
            for (int a = (*xs)[0]; a <= (*xs)[1]; ++a)
                visit(ImageIndex{static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                 static_cast<std::int16_t>(c)});
        }
    }
    return true;
}

}  // namespace vcell::check
