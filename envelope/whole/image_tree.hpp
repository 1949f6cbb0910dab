/// Balls in a box that repeats, or does not, and searches among all their images.
///
/// What a search finds is a matter of each ball alone, not of what else is in the tree: processes that know
/// different parts of a scene find the same balls where both know them.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "../voronoi_diagram.hpp"
#include "ball_tree.hpp"
#include "cell_bound.hpp"

namespace vcell::whole {

/// Of the box: moved by so many of its edges.
using Image = std::array<std::int16_t, 3>;

class Lattice {
public:
    Lattice() = default;
    explicit Lattice(const DiagramScene& scene)
        : periodic_(scene.periodic), edges_(scene.edges()), to_unit_(edges_.inverse()) {}

    bool repeats() const { return periodic_[0] || periodic_[1] || periodic_[2]; }
    const Eigen::Matrix3d& edges() const { return edges_; }
    /// By how much an image of the box is moved; exact where coordinates are on the scene's grid.
    Vec3 shift(const Image& image) const {
        if (image == Image{0, 0, 0}) return Vec3::Zero();
        return edges_ * Vec3(image[0], image[1], image[2]);
    }

    /// Calls visit(image, shift) for all images in which balls, centred in the box `centers` and of no more
    /// than that radius, may have surfaces less than `reach` from the point.
    template <class Visit>
    void for_images(const Box& centers, double radius, const Vec3& point, double reach, Visit&& visit) const {
        if (!repeats()) return visit(Image{0, 0, 0}, Vec3::Zero().eval());
        // In coordinates in which the box is a unit cube.
        const Vec3 middle = to_unit_ * (point - 0.5 * (centers.min + centers.max)),
                   half = 0.5 * to_unit_.cwiseAbs() * (centers.max - centers.min);
        constexpr double rounding = 0x1p-20;  // and a margin: images too many cost little
        std::array<int, 3> low{}, high{};
        for (int k = 0; k < 3; ++k) {
            if (!periodic_[k]) continue;
            const double margin = half[k] + std::max(0.0, reach + radius) * to_unit_.row(k).norm() + rounding;
            low[k] = static_cast<int>(std::ceil(middle[k] - margin));
            high[k] = static_cast<int>(std::floor(middle[k] + margin));
        }
        for (int a = low[0]; a <= high[0]; ++a)
            for (int b = low[1]; b <= high[1]; ++b)
                for (int c = low[2]; c <= high[2]; ++c) {
                    const Image image{static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                      static_cast<std::int16_t>(c)};
                    visit(image, shift(image));
                }
    }

private:
    std::array<bool, 3> periodic_{false, false, false};
    Eigen::Matrix3d edges_ = Eigen::Matrix3d::Identity(), to_unit_ = Eigen::Matrix3d::Identity();
};

class ImageTree {
public:
    struct Found {
        double distance;  // of the surface from the point
        std::uint32_t number;
        Image image;
        Sphere ball;

        auto key() const { return std::tie(distance, number, image); }
    };

    ImageTree() = default;
    ImageTree(const Lattice& lattice, std::vector<BallTree::Entry> balls)
        : lattice_(lattice), tree_(std::move(balls)) {}

    const Lattice& lattice() const { return lattice_; }
    const BallTree& tree() const { return tree_; }

    /// Calls visit(ball, number, image) for all balls, images included, whose surfaces are less than `reach`
    /// from the point, as BallTree::within().
    template <class Visit>
    void within(const Vec3& point, double reach, Visit&& visit) const {
        if (tree_.entries().empty()) return;
        lattice_.for_images(tree_.centers(), tree_.largest_radius(), point, reach,
                            [&](const Image& image, const Vec3& by) {
                                tree_.within(point - by, reach, [&](const BallTree::Entry& e) {
                                    visit(Sphere{e.ball.center + by, e.ball.radius}, e.number, image);
                                });
                            });
    }
    /// The same for balls that may touch the cell that the bound is of: a CellBound, or CellMarks.
    template <class Bound, class Visit>
    void touching(const Bound& bound, Visit&& visit) const {
        if (tree_.entries().empty()) return;
        lattice_.for_images(tree_.centers(), tree_.largest_radius(), bound.base().center,
                            bound.extent(tree_.largest_radius()), [&](const Image& image, const Vec3& by) {
                                const auto may_hold = [&](const Box& box, double radius) {
                                    return bound.may_touch(Box{box.min + by, box.max + by}, radius);
                                };
                                tree_.search(may_hold, [&](const BallTree::Entry& e) {
                                    const Sphere moved{e.ball.center + by, e.ball.radius};
                                    if (bound.may_touch(moved)) visit(moved, e.number, image);
                                });
                            });
    }

    /// The `count` nearest of within(point, reach), the lower numbers and images among equally near ones,
    /// ascending; of all balls where the box does not repeat. The image (self, 0) is left out.
    std::vector<Found> nearest(const Vec3& point, double reach, std::size_t count, std::uint32_t self) const {
        std::vector<Found> found;
        if (!lattice_.repeats()) {
            std::vector<std::pair<double, std::uint32_t>> places;
            tree_.nearest(point, count + 1, places);
            for (const auto& [distance, place] : places) {
                const BallTree::Entry& e = tree_.entries()[place];
                if (e.number != self) found.push_back({distance, e.number, {0, 0, 0}, e.ball});
            }
        } else {
            within(point, reach, [&](const Sphere& ball, std::uint32_t number, const Image& image) {
                if (number != self || image != Image{0, 0, 0})
                    found.push_back({(ball.center - point).norm() - ball.radius, number, image, ball});
            });
        }
        const auto middle = found.begin() + static_cast<std::ptrdiff_t>(std::min(found.size(), count));
        std::partial_sort(found.begin(), middle, found.end(),
                          [](const Found& a, const Found& b) { return a.key() < b.key(); });
        found.erase(middle, found.end());
        return found;
    }

private:
    Lattice lattice_;
    BallTree tree_;
};

}  // namespace vcell::whole
