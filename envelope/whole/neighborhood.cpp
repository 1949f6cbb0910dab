// The balls around a leaf of the tree of all, or around one of them: what the cells of a neighbourhood are
// sought among first.
#include <algorithm>

#include "cell_finder.hpp"

namespace vcell::whole {

namespace {

// Balls whose surfaces are near a box, until there are too many.
class NearBox {
public:
    NearBox(const Box& box, double reach, const std::vector<ImageTree::Found>& found, std::size_t most)
        : box_(box), reach_(reach), found_(found), most_(most) {
        base_.center = 0.5 * (box.min + box.max);
        half_ = 0.5 * (box.max - box.min).norm();
    }

    const Sphere& base() const { return base_; }
    double extent(double) const { return half_ + reach_; }
    bool may_touch(const Sphere& ball) const { return may_touch(Box{ball.center, ball.center}, ball.radius); }
    bool may_touch(const Box& centers, double radius) const {
        if (found_.size() > most_) return false;
        const Vec3 away = (centers.min - box_.max).cwiseMax(box_.min - centers.max).cwiseMax(0);
        return away.norm() - radius <= reach_;
    }

private:
    Box box_;
    double reach_, half_;
    Sphere base_;
    const std::vector<ImageTree::Found>& found_;
    const std::size_t most_;
};

}  // namespace

Neighborhood::Neighborhood(const DecidedDiagram& decided, const BallTree::Leaf& leaf) : is_in_box_(true) {
    // Room for some sixty balls: enough to bound most cells, and few enough to be looked at one by one.
    constexpr double wide = 2.6;
    constexpr std::size_t least = 32, most = 1024;
    double largest = 0;
    for (const BallTree::Entry& e : leaf.balls) largest = std::max(largest, e.ball.radius);
    const Box& all = decided.scene().box;
    const double size = (all.max - all.min).norm() + leaf.box.max.norm() + leaf.box.min.norm();
    double reach = std::max(wide * leaf.spacing - largest, 0x1p-20 * size);
    // Beside a denser part of the scene there are too many: fewer may be too few, and then each cell looks
    // for its own.
    constexpr int most_narrowings = 8;
    for (int narrowings = 0;;) {
        balls_.clear();
        decided.balls().touching(NearBox(leaf.box, reach, balls_, most),
                                 [&](const Sphere& ball, std::uint32_t number, const Image& image) {
                                     balls_.push_back({0, number, image, ball});
                                 });
        if (balls_.size() > most) {
            reach *= 0.5;
            if (++narrowings < most_narrowings) continue;
            balls_.clear();  // the search has not ended
            reach = -infinity;
            break;
        } else if (balls_.size() >= least || narrowings > 0 || reach > 2 * size) {
            break;
        } else {
            reach *= 1.5;
        }
    }
    set_reach(reach, leaf.box);
}

Neighborhood::Neighborhood(const DecidedDiagram& decided, std::uint32_t object) {
    constexpr std::size_t count = 96;
    const Vec3& center = decided.ball(object).center;
    auto found = decided.competitors(object, count);
    balls_ = std::move(found.nearest);
    set_reach(balls_.size() < count ? found.reach : balls_.back().distance, {center, center});
}

void Neighborhood::set_reach(double reach, const Box& box) {
    constexpr double rounding = 0x1p-46;
    const double size = box.min.cwiseAbs().sum() + box.max.cwiseAbs().sum();
    reach_ = reach < infinity ? reach - rounding * (std::abs(reach) + size) : reach;
}

}  // namespace vcell::whole
