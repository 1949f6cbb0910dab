/// Which objects may be near a point: a tree over the balls' centres, and lists of tubes and planes, of which
/// each is asked for its distance.
#pragma once

#include <cstdint>
#include <vector>

#include "../../primitives/objects/scene.hpp"

namespace vcell::check {

class SiteTree {
public:
    explicit SiteTree(const Scene& scene);

    /// Appends, in no order, all objects nearer to p than reach, and perhaps some others.
    void near(const Vec3& p, double reach, std::vector<std::uint32_t>& objects) const;

private:
    struct Ball {
        Vec3 center;
        double radius;
        std::uint32_t object;
    };
    struct Tube {
        Vec3 point, axis;  // of length one
        double radius;
        std::uint32_t object;
    };
    struct Wall {
        Vec3 point, normal;  // of length one
        std::uint32_t object;
    };
    struct Node {
        Vec3 lo, hi;  // of the centres
        double most;  // of the radii
        std::uint32_t begin, end;
        std::uint32_t right;  // the left one follows; 0: a leaf
    };
    void build(std::uint32_t begin, std::uint32_t end);

    std::vector<Ball> balls_;
    std::vector<Node> nodes_;
    std::vector<Tube> tubes_;
    std::vector<Wall> planes_;
    std::vector<std::uint32_t> vessels_;  // few, and around everything: always near
};

}  // namespace vcell::check
