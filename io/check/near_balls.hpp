/// Which balls of a diagram may be near to one of them, images included where the box repeats.
///
/// Where an image is must be told without rounding: its coordinates are sums of the ball's and of multiples
/// of the box's edges, and each of these sums is a double if coordinates are multiples of one power of two
/// with few enough digits. So they are in a file, as the scene was moved to such a grid before anything was
/// decided (DiagramWriter); what is no double is told as such, and nothing is proved with it.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

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
    Search search(std::uint32_t i, double reach) const;

    /// No point of a cell is farther from the centre of its ball, which lies within the sides of the box that
    /// do not repeat: infinite where none does.
    double farthest() const;
    /// By how much an image is moved, rounded.
    Vec3 shift(const ImageIndex& image) const;

private:
    using Cube = std::array<std::int64_t, 3>;
    struct Ball {
        Sphere ball;
        std::uint32_t number;
    };

    Cube cube(const Vec3& p) const;
    template <class Visit>
    void in_cubes(const Vec3& p, double far, const Visit& visit) const;
    template <class Visit>
    bool for_images(const Vec3& p, double far, const Visit& visit) const;
    std::optional<Vec3> moved(const Vec3& p, const ImageIndex& image) const;
    bool repeats() const { return scene_.periodic[0] || scene_.periodic[1] || scene_.periodic[2]; }

    const DiagramScene& scene_;
    std::array<double, 3> size_{};  // of the box
    bool is_exact_ = true;          // its size along axes along which it repeats
    std::vector<Ball> balls_;
    Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();     // of the centres
    double edge_ = 1, largest_ = 0;                     // of cubes; the largest radius
    std::map<Cube, std::vector<std::uint32_t>> cubes_;  // places of balls where their centres are
};

}  // namespace vcell::check
