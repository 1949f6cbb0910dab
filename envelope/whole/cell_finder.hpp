/// The cells of a diagram, one by one, each among as few objects as prove it complete.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../cell.hpp"
#include "../voronoi_diagram.hpp"
#include "ball_tree.hpp"
#include "cell_bound.hpp"

namespace vcell::whole {

/// A scene that cells are computed of: what is periodic on its grid, balls in a tree, hidden balls known.
class DecidedDiagram {
public:
    using Image = std::array<std::int16_t, 3>;

    /// Throws as voronoi_diagram().
    explicit DecidedDiagram(const DiagramScene& scene);

    const DiagramScene& scene() const { return scene_; }
    double moved() const { return moved_; }
    bool is_ball(std::uint32_t i) const { return std::holds_alternative<Sphere>(scene_.objects[i]); }
    const Sphere& ball(std::uint32_t i) const { return std::get<Sphere>(scene_.objects[i]); }
    bool is_wall(std::uint32_t i) const {
        const Object& object = scene_.objects[i];
        return is_vessel(object) || (has_vessels_ && std::holds_alternative<Plane>(object));
    }
    /// Objects that are no balls, ascending.
    const std::vector<std::uint32_t>& others() const { return others_; }
    /// The box in which a ball's cell is computed: where the scene repeats, one that the cell does not reach
    /// the sides of, as it lies in that of the ball among its own images.
    Box room(std::uint32_t i) const;
    /// By how much an image of the box is moved; exact.
    Vec3 shift(const Image& image) const;

    /// Calls visit(ball, number, image) for all balls, images included, whose surfaces are less than `reach`
    /// from the point, but for those that are themselves hidden, and for (number, image) = (self, 0).
    template <class Visit>
    void within(const Vec3& point, double reach, std::uint32_t self, Visit&& visit) const {
        for_images(point, reach, [&](const Image& image) {
            const Vec3 by = shift(image);
            tree_.within(point - by, reach, [&](const BallTree::Entry& e) {
                if (e.number != self || image != Image{0, 0, 0})
                    visit(Sphere{e.ball.center + by, e.ball.radius}, e.number, image);
            });
        });
    }
    /// The same for balls that may touch the cell that the bound is of.
    template <class Visit>
    void touching(const CellBound& bound, std::uint32_t self, Visit&& visit) const {
        const Sphere& base = ball(self);
        for_images(base.center, base.radius + bound.reach(), [&](const Image& image) {
            const Vec3 by = shift(image);
            const auto may_hold = [&](const Box& box, double radius) {
                return bound.may_touch(Box{box.min + by, box.max + by}, radius);
            };
            tree_.search(may_hold, [&](const BallTree::Entry& e) {
                const Sphere moved{e.ball.center + by, e.ball.radius};
                if ((e.number != self || image != Image{0, 0, 0}) && bound.may_touch(moved))
                    visit(moved, e.number, image);
            });
        });
    }
    const BallTree& tree() const { return tree_; }

    /// Why the ball has no cell; empty: it has one.
    const std::string& hidden(std::uint32_t i) const { return hidden_[i]; }
    /// May object `x` touch the cell of object i, whose reach that is?
    bool may_touch(std::uint32_t x, std::uint32_t i, double reach) const;

private:
    /// Calls visit(image) for all images of the box that may hold centres of balls that near.
    template <class Visit>
    void for_images(const Vec3& point, double reach, Visit&& visit) const {
        if (!scene_.is_periodic() || tree_.entries().empty()) return visit(Image{0, 0, 0});
        // In coordinates in which the box is a unit cube.
        const Box& centers = tree_.centers();
        const Vec3 middle = to_unit_ * (point - 0.5 * (centers.min + centers.max)),
                   half = 0.5 * to_unit_.cwiseAbs() * (centers.max - centers.min);
        constexpr double rounding = 0x1p-20;  // and a margin: images too many cost little
        std::array<int, 3> low{}, high{};
        for (int k = 0; k < 3; ++k) {
            if (!scene_.periodic[k]) continue;
            const double margin =
                half[k] + std::max(0.0, reach + tree_.largest_radius()) * to_unit_.row(k).norm() + rounding;
            low[k] = static_cast<int>(std::ceil(middle[k] - margin));
            high[k] = static_cast<int>(std::floor(middle[k] + margin));
        }
        for (int a = low[0]; a <= high[0]; ++a)
            for (int b = low[1]; b <= high[1]; ++b)
                for (int c = low[2]; c <= high[2]; ++c)
                    visit(Image{static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                static_cast<std::int16_t>(c)});
    }
    void validate_diagram() const;
    void snap();
    void find_hidden();

    DiagramScene scene_;
    double moved_ = 0;
    Eigen::Matrix3d edges_, to_unit_;
    std::vector<std::uint32_t> others_;
    bool has_vessels_ = false;
    std::vector<std::string> hidden_;  // for each object why it has no cell; empty: it has one
    BallTree tree_;
};

/// The cell of an object. Where `cell` is asked for it gets that of a computed ball, whose sites are numbered
/// as the diagram's objects. Throws nothing that is about this cell alone.
DiagramCell find_cell(const DecidedDiagram& decided, std::uint32_t object, std::optional<Cell>* cell);

}  // namespace vcell::whole
