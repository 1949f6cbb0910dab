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

#include "../../core/errors.hpp"
#include "../voronoi_diagram.hpp"
#include "ball_tree.hpp"
#include "cell_bound.hpp"

namespace vcell::whole {

/// Of the box: moved by so many of its edges.
using Image = std::array<std::int16_t, 3>;
inline constexpr Image here{0, 0, 0};

/// Moved once more, so many times.
inline Image plus(const Image& a, const Image& b, int times = 1) {
    Image sum;
    for (std::size_t k = 0; k < 3; ++k) sum[k] = static_cast<std::int16_t>(a[k] + times * b[k]);
    return sum;
}
inline Image minus(const Image& a, const Image& b) { return plus(a, b, -1); }

class Lattice {
public:
    Lattice() = default;
    explicit Lattice(const DiagramScene& scene)
        : periodic_(scene.periodic),
          corner_(scene.box.min),
          edges_(scene.edges()),
          to_unit_(edges_.inverse()) {}

    bool repeats() const { return periodic_[0] || periodic_[1] || periodic_[2]; }
    bool repeats(int axis) const { return periodic_[static_cast<std::size_t>(axis)]; }
    /// A direction as a combination of edges.
    Vec3 in_edges(const Vec3& direction) const { return to_unit_ * direction; }
    const Eigen::Matrix3d& edges() const { return edges_; }
    /// Images are numbered as seen from others: those of balls in the box, and the box's, go so far.
    static constexpr int farthest = 1 << 13;
    /// Pre: otherwise no ball lies there (validate_diagram()).
    bool has_image_at(const Vec3& point) const { return edges_to(point).cwiseAbs().maxCoeff() < farthest; }
    /// The image of the box that a point lies in, or beside, where that does not repeat. Pre: there is one.
    Image image_at(const Vec3& point) const {
        const Vec3 at = edges_to(point);
        return {static_cast<std::int16_t>(at[0]), static_cast<std::int16_t>(at[1]),
                static_cast<std::int16_t>(at[2])};
    }
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
        constexpr double most = 0x1p24;       // images, of which one takes some nanoseconds
        double count = 1;
        std::array<int, 3> low{}, high{};
        for (int k = 0; k < 3; ++k) {
            if (!periodic_[k]) continue;
            const double margin = half[k] + std::max(0.0, reach + radius) * to_unit_.row(k).norm() + rounding;
            const double first = std::ceil(middle[k] - margin), last = std::floor(middle[k] + margin);
            count *= std::max(0.0, last - first + 1);
            if (!(count <= most && std::abs(first) < 2 * farthest && std::abs(last) < 2 * farthest))
                throw InputError(InputError::Kind::OutOfRange, InputError::no_object, "box",
                                 "repeats too often within the reach of its balls: it is too small for them");
            low[k] = static_cast<int>(first);
            high[k] = static_cast<int>(last);
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
    Vec3 edges_to(const Vec3& point) const {
        Vec3 at = to_unit_ * (point - corner_);
        for (int k = 0; k < 3; ++k) at[k] = periodic_[k] && (at[k] < 0 || at[k] > 1) ? std::floor(at[k]) : 0;
        return at;
    }

    std::array<bool, 3> periodic_{false, false, false};
    Vec3 corner_ = Vec3::Zero();
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
        : lattice_(lattice), tree_(take_home(std::move(balls))) {}

    const Lattice& lattice() const { return lattice_; }
    /// The tree holds those images that lie in the box itself, so that few images of it hold what is near.
    const BallTree& tree() const { return tree_; }
    /// Where a ball lies, as an image of what the tree has of it.
    Image home(std::uint32_t number) const {
        return number < homes_.size() ? homes_[number] : Image{0, 0, 0};
    }

    /// Calls visit(ball, number, image) for all balls, images included, whose surfaces are less than `reach`
    /// from the point, as BallTree::within().
    template <class Visit>
    void within(const Vec3& point, double reach, Visit&& visit) const {
        if (tree_.entries().empty()) return;
        lattice_.for_images(
            tree_.centers(), tree_.largest_radius(), point, reach, [&](const Image& image, const Vec3& by) {
                tree_.within(point - by, reach, [&](const BallTree::Entry& e) {
                    visit(Sphere{e.ball.center + by, e.ball.radius}, e.number, seen(e.number, image));
                });
            });
    }
    /// Calls visit for balls, images included, that may touch a cell: the bound is a CellBound, or CellMarks.
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
                                    if (bound.may_touch(moved)) visit(moved, e.number, seen(e.number, image));
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
    std::vector<BallTree::Entry> take_home(std::vector<BallTree::Entry> balls) {
        if (!lattice_.repeats()) return balls;
        for (BallTree::Entry& e : balls) {
            const Image home = lattice_.image_at(e.ball.center);
            if (home == Image{0, 0, 0}) continue;
            if (homes_.size() <= e.number) homes_.resize(e.number + 1, Image{0, 0, 0});
            homes_[e.number] = home;
            e.ball.center -= lattice_.shift(home);
        }
        return balls;
    }
    // As an image of the ball where it lies.
    Image seen(std::uint32_t number, Image image) const {
        if (number < homes_.size())
            for (int k = 0; k < 3; ++k) image[k] = static_cast<std::int16_t>(image[k] - homes_[number][k]);
        return image;
    }

    Lattice lattice_;
    std::vector<Image> homes_;  // of numbers up to the last that lies outside the box
    BallTree tree_;
};

}  // namespace vcell::whole
