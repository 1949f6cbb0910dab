#include "ball_cell.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../primitives/bases/sphere_base.hpp"
#include "../diagram/settled_vertices.hpp"
#include "../lift/lift.hpp"
#include "../sphere/sphere_diagram.hpp"
#include "cell_marks.hpp"

namespace vcell::whole {

namespace {

using Neighbor = ImageTree::Found;

// Balls that are inserted before others are looked for; and others of a time, after which fewer of those that
// are left may touch the cell.
constexpr std::size_t first_balls = 20, more_balls = 24;
// Where the cell among the first has faces of which marks tell nothing.
constexpr std::size_t many_balls = 80;

class BallCellFinder {
public:
    BallCellFinder(const DecidedDiagram& decided, std::uint32_t object, const Box& room)
        : decided_(decided),
          object_(object),
          room_(room),
          base_(decided.ball(object)),
          candidates_(decided.competitors(object, first_balls).nearest) {
        for (const Neighbor& n : candidates_) {
            searched_ = std::max(searched_, n.distance);
            step_ = std::max(step_, 0.5 * (n.distance + n.ball.radius));
        }
        // In a unit of the cell's size heights are no steeper than directions tell, and vertices settled.
        if (candidates_.empty()) step_ = (room.max - room.min).maxCoeff();
        unit_ = std::ldexp(1.0, std::ilogb(step_));
    }

    std::optional<MeasuredBallCell> operator()() {
        Scene scene;
        const auto base = scaled(base_);
        const auto low = scaled(Sphere{room_.min, 0}), high = scaled(Sphere{room_.max, 0});
        if (!base || !low || !high) return std::nullopt;
        scene.base = *base;
        scene.box = {low->center, high->center};
        scene.objects.reserve(candidates_.size());
        for (const Neighbor& n : candidates_) {
            const auto ball = scaled(n.ball);
            if (!ball) return std::nullopt;
            scene.objects.emplace_back(*ball);
        }
        problem_.emplace(scene, unit_);
        const RadialBaseProblem& problem = problem_->problem();
        if (problem.moved != 0 || !problem.warnings.empty()) return std::nullopt;
        auto diagram = disc_diagram_on_sphere(problem.family, {},
                                              [this](const SphereMarks& marks) { return more(marks); });
        if (!diagram) return std::nullopt;
        settle_vertices(problem.family, *diagram, 1);
        Cell cell = measure_without_curves(problem, *diagram);
        scale(cell, unit_, 1);
        if (!is_finite(cell)) return std::nullopt;
        return MeasuredBallCell{std::move(cell), std::move(candidates_)};
    }

private:
    // None where that is not exact, or out of all proportion.
    std::optional<Sphere> scaled(const Sphere& ball) const {
        constexpr double most = 0x1p200;
        const double factor = 1 / unit_;
        const Sphere s{factor * ball.center, factor * ball.radius};
        const bool is_exact = unit_ * s.center == ball.center && unit_ * s.radius == ball.radius;
        if (!is_exact || !(s.center.cwiseAbs().maxCoeff() < most && s.radius < most)) return std::nullopt;
        return s;
    }

    // Balls that the marks leave and that are not among the forms, some at a time: the nearest, and of those
    // in ever larger reaches. A cell gets small soon, and what is far from it is not looked at one by one.
    MoreForms more(const SphereMarks& known) {
        CellMarks marks(base_, known, problem_->problem().chart.turn, unit_);
        if (!marks.are_bounds()) return is_widened_ ? MoreForms::GivenUp : widen();
        std::erase_if(waiting_, [&](const Neighbor& n) { return !marks.may_touch(n.ball); });
        while (waiting_.empty()) {
            if (searched_ >= marks.reach()) return MoreForms::None;
            const double to = std::min(searched_ + step_, marks.reach());
            marks.look_between(is_searched_ ? searched_ : -HUGE_VAL, to);
            decided_.balls().touching(marks,
                                      [&](const Sphere& ball, std::uint32_t place, const Image& image) {
                                          const Neighbor n{marks.distance(ball), place, image, ball};
                                          const bool is_base = place == object_ && image == Image{0, 0, 0};
                                          if (!is_base && !is_candidate(n)) waiting_.push_back(n);
                                      });
            is_searched_ = true;
            searched_ = to;
            step_ *= 2;
        }
        // The nearest last. The tree has an order of its own.
        std::ranges::sort(waiting_, std::ranges::greater(), &Neighbor::distance);
        for (std::size_t i = 0; i < more_balls && !waiting_.empty(); ++i) {
            if (!add(waiting_.back())) return MoreForms::GivenUp;
            waiting_.pop_back();
        }
        return MoreForms::Added;
    }
    // The cell among a few balls may have faces of which marks tell nothing.
    MoreForms widen() {
        is_widened_ = true;
        for (const Neighbor& n : decided_.competitors(object_, many_balls).nearest)
            if (!is_candidate(n) && !add(n)) return MoreForms::GivenUp;
        return MoreForms::Added;
    }

    bool is_candidate(const Neighbor& n) const {
        return std::ranges::any_of(candidates_, [&](const Neighbor& known) {
            return known.number == n.number && known.image == n.image;
        });
    }
    bool add(const Neighbor& n) {
        const auto ball = scaled(n.ball);
        const Site site = Site::object(static_cast<std::uint32_t>(candidates_.size()));
        if (!ball || !problem_->add(*ball, site)) return false;
        candidates_.push_back(n);
        return true;
    }

    static bool is_finite(const Cell& cell) {
        const Measures& m = cell.measures;
        return std::isfinite(m.volume + m.volume_error + m.area + m.area_error + m.min_clearance +
                             m.min_clearance_error + m.max_clearance + m.max_clearance_error) &&
               std::ranges::all_of(cell.faces,
                                   [](const CellFace& f) { return std::isfinite(f.area + f.area_error); });
    }

    const DecidedDiagram& decided_;
    const std::uint32_t object_;
    const Box& room_;
    const Sphere base_;
    double unit_ = 1;
    std::vector<Neighbor> candidates_;
    std::optional<GrowingSphereProblem> problem_;
    std::vector<Neighbor> waiting_;  // the nearest last
    bool is_searched_ = false, is_widened_ = false;
    // All balls whose surfaces are no farther than that from the base's centre have been asked about, and how
    // much farther it goes from there.
    double searched_ = 0, step_ = 0;
};

}  // namespace

std::optional<MeasuredBallCell> measured_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                                   const Box& room) {
    return BallCellFinder(decided, object, room)();
}

}  // namespace vcell::whole
