#include "site_tree.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

namespace vcell::check {

namespace {

/// Distances are computed with a few roundings of their terms: comparisons are made in favour of being near.
constexpr double kFavour = 1 + 0x1p-40;
/// Relative to the way from a point of it: what a distance from an axis or a plane may be off by, its
/// direction's own rounding included.
constexpr double kAside = 0x1p-46;

}  // namespace

SiteTree::SiteTree(const Scene& scene) {
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        if (!scene.competes(i)) continue;
        if (const auto* s = std::get_if<Sphere>(&scene.objects[i]))
            balls_.push_back({s->center, s->radius, i});
        else if (const auto* c = std::get_if<Cylinder>(&scene.objects[i]))
            tubes_.push_back({c->point, c->axis.normalized(), c->radius, i});
        else if (const auto* w = std::get_if<Plane>(&scene.objects[i]))
            planes_.push_back({w->point, w->normal.normalized(), i});
        else
            vessels_.push_back(i);
    }
    if (!balls_.empty()) build(0, static_cast<std::uint32_t>(balls_.size()));
}

void SiteTree::build(std::uint32_t begin, std::uint32_t end) {
    constexpr std::uint32_t kLeaf = 8;
    Node node{balls_[begin].center, balls_[begin].center, 0, begin, end, 0};
    for (std::uint32_t i = begin; i < end; ++i) {
        node.lo = node.lo.cwiseMin(balls_[i].center);
        node.hi = node.hi.cwiseMax(balls_[i].center);
        node.most = std::max(node.most, balls_[i].radius);
    }
    const std::size_t here = nodes_.size();
    nodes_.push_back(node);
    if (end - begin <= kLeaf) return;
    int axis = 0;
    (node.hi - node.lo).maxCoeff(&axis);
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(balls_.begin() + begin, balls_.begin() + half, balls_.begin() + end,
                     [axis](const Ball& a, const Ball& b) { return a.center[axis] < b.center[axis]; });
    build(begin, half);
    nodes_[here].right = static_cast<std::uint32_t>(nodes_.size());
    build(half, end);
}

void SiteTree::near(const Vec3& p, double reach, std::vector<std::uint32_t>& objects) const {
    // What is not a number is near.
    for (const Tube& t : tubes_) {
        const Vec3 way = p - t.point;
        const double limit = std::max(0.0, kFavour * (reach + t.radius)) + kAside * way.norm();
        if (!(way.cross(t.axis).squaredNorm() > kFavour * limit * limit)) objects.push_back(t.object);
    }
    for (const Wall& w : planes_) {
        const Vec3 way = p - w.point;
        if (!(std::abs(w.normal.dot(way)) > kFavour * reach + kAside * way.norm()))
            objects.push_back(w.object);
    }
    objects.insert(objects.end(), vessels_.begin(), vessels_.end());
    if (nodes_.empty()) return;
    const auto within = [&](const Vec3& q, double radius) {
        const double limit = kFavour * (reach + radius);
        return limit > 0 && (p - q).squaredNorm() <= kFavour * limit * limit;
    };
    std::array<std::uint32_t, 64> stack;  // balanced: its depth is the logarithm of 2^32 at most
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::uint32_t at = stack[--depth];
        const Node& node = nodes_[at];
        if (!within(p.cwiseMax(node.lo).cwiseMin(node.hi), node.most)) continue;
        if (node.right != 0) {
            stack[depth++] = node.right;
            stack[depth++] = at + 1;
            continue;
        }
        for (std::uint32_t i = node.begin; i < node.end; ++i)
            if (within(balls_[i].center, balls_[i].radius)) objects.push_back(balls_[i].object);
    }
}

}  // namespace vcell::check
