#include "tube_bound.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "../object_distance.hpp"

namespace vcell::whole {

namespace {

// A ball in the object, near the point. None: it is no solid.
std::optional<Sphere> ball_in(const Object& object, const Vec3& point) {
    if (const auto* ball = std::get_if<Sphere>(&object)) return *ball;
    const auto* tube = std::get_if<Cylinder>(&object);
    if (tube == nullptr) return std::nullopt;
    const Vec3 along = tube->axis.stableNormalized();
    return Sphere{tube->point + along.dot(point - tube->point) * along, tube->radius};
}

}  // namespace

TubeBound::TubeBound(const Cylinder& tube, const std::array<Vec3, 2>& feet, const Box& box,
                     std::span<const Object> others, std::optional<double> probe)
    : tube_(tube), box_(box), others_(others), probe_(probe) {
    constexpr int most_divisions = 9;
    add(feet[0], feet[1], most_divisions);
}

TubeBound::Piece TubeBound::piece(const Vec3& begin, const Vec3& end) const {
    constexpr std::size_t few = 56;  // bound most cells nearly as well as all
    constexpr double rounding = 1 + 0x1p-40;
    const Vec3 middle = 0.5 * (begin + end);
    const double half = 0.5 * rounding * (end - begin).norm();
    const Sphere base{middle, tube_.radius + half};
    std::vector<std::pair<double, Sphere>> nearest;
    for (const Object& other : others_)
        if (const std::optional<Sphere> ball = ball_in(other, middle)) {
            // Neither ball may contain the other.
            const double apart = (ball->center - middle).norm();
            if (apart > rounding * std::abs(ball->radius - base.radius))
                nearest.emplace_back(apart - ball->radius, *ball);
        }
    const auto last = nearest.begin() + static_cast<std::ptrdiff_t>(std::min(few, nearest.size()));
    std::partial_sort(nearest.begin(), last, nearest.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
    CellBound bound(base);
    bound.add(box_);
    if (probe_) bound.add_cap(*probe_);
    // Feet are in the piece: planes at its ends are as far from balls of one size beside them.
    const Vec3 next = rounding * (end - begin);
    bound.add(Sphere{middle + next, base.radius});
    bound.add(Sphere{middle - next, base.radius});
    std::for_each(nearest.begin(), last, [&](const auto& near) { bound.add(near.second); });
    bound.settle(half);
    const double most = nearest.empty() ? infinity : std::prev(last)->first - tube_.radius;
    return {std::move(bound), half, most};
}

void TubeBound::add(const Vec3& begin, const Vec3& end, int divisions) {
    Piece whole = piece(begin, end);
    // A ball as large as the room among its neighbours is bounded badly.
    if (divisions == 0 || (4 * whole.half < whole.last && whole.of_ball.reach() < 4 * whole.last)) {
        pieces_.push_back(std::move(whole));
        return;
    }
    const Vec3 middle = 0.5 * (begin + end);
    add(begin, middle, divisions - 1);
    add(middle, end, divisions - 1);
}

double TubeBound::farthest() const {
    double most = 0;
    for (const Piece& piece : pieces_)
        most = std::max(most, 0.5 * piece.of_ball.reach() + piece.half + tube_.radius);
    return most;
}

bool TubeBound::may_touch(const Object& object) const {
    return std::ranges::any_of(pieces_, [&](const Piece& piece) {
        if (const auto* ball = std::get_if<Sphere>(&object))
            return piece.of_ball.may_touch(Sphere{ball->center, ball->radius + piece.half});
        return piece.of_ball.may_be_touched_by([&](const Vec3& p) {
            return least_distance(object, Sphere{p, piece.half});
        });
    });
}

}  // namespace vcell::whole
