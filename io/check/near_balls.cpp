#include "near_balls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "../../core/numbers/interval.hpp"

namespace vcell::check {

namespace {

// Images beyond these are too many to be looked at.
constexpr std::size_t most_found = 0x1p20;
// Distances are computed with a few roundings: a ball too many costs time alone.
constexpr double favour = 1 + 0x1p-40;

// The sum, where it is a double: what rounding took from it is computed without another [Knuth's TwoSum].
std::optional<double> exact_sum(double a, double b) {
    const double sum = a + b, rest = sum - a;
    if ((a - (sum - rest)) + (b - rest) != 0) return std::nullopt;
    return sum;
}
std::optional<double> exact_multiple(int n, double x) {
    const double product = n * x;
    if (std::fma(n, x, -product) != 0) return std::nullopt;
    return product;
}

}  // namespace

NearBalls::NearBalls(const DiagramScene& scene) : scene_(scene) {
    for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        const auto size = exact_sum(scene.box.max[axis], -scene.box.min[axis]);
        size_[k] = size.value_or(scene.box.max[axis] - scene.box.min[axis]);
        is_exact_ = is_exact_ && (size || !scene.periodic[k]);
    }
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (const auto* ball = std::get_if<Sphere>(&scene.objects[i])) balls_.push_back({*ball, i});
    if (balls_.empty()) return;
    low_ = high_ = balls_[0].ball.center;
    for (const Ball& b : balls_) {
        low_ = low_.cwiseMin(b.ball.center);
        high_ = high_.cwiseMax(b.ball.center);
        largest_ = std::max(largest_, b.ball.radius);
    }
    edge_ = std::max(std::cbrt((high_ - low_).prod() / static_cast<double>(balls_.size())),
                     0x1p-20 * (high_ - low_).maxCoeff());
    if (!(edge_ > 0)) edge_ = 1;
    for (std::uint32_t i = 0; i < balls_.size(); ++i) cubes_[cube(balls_[i].ball.center)].push_back(i);
}

NearBalls::Cube NearBalls::cube(const Vec3& p) const {
    constexpr double most = 0x1p60;
    Cube c;
    for (int k = 0; k < 3; ++k)
        c[static_cast<std::size_t>(k)] =
            static_cast<std::int64_t>(std::clamp(std::floor(p[k] / edge_), -most, most));
    return c;
}

// Calls visit(ball) for all whose centres may be no farther than that.
template <class Visit>
void NearBalls::in_cubes(const Vec3& p, double far, const Visit& visit) const {
    const Cube low = cube((p - Vec3::Constant(far)).cwiseMax(low_)),
               high = cube((p + Vec3::Constant(far)).cwiseMin(high_));
    double count = 1;
    for (std::size_t k = 0; k < 3; ++k) count *= std::max(0.0, static_cast<double>(high[k] - low[k]) + 1);
    if (!(count < static_cast<double>(balls_.size()))) {
        for (const Ball& b : balls_) visit(b);
        return;
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
            for (std::int64_t z = low[2]; z <= high[2]; ++z)
                if (const auto at = cubes_.find({x, y, z}); at != cubes_.end())
                    for (const std::uint32_t i : at->second) visit(balls_[i]);
}

NearBalls::Search NearBalls::search(const Sphere& self, std::uint32_t i, double reach) const {
    Search result;
    if (balls_.empty()) return result;
    bool is_exact = true;
    const auto look_at = [&](const Ball& b, const ImageIndex& image, const Vec3& by, double slack) {
        if (b.number == i && image == ImageIndex{}) return;
        const double away = (b.ball.center + by - self.center).norm();
        if (away > (reach + self.radius + b.ball.radius) * favour + slack) return;
        const auto center = moved(b.ball.center, image);
        is_exact = is_exact && center;
        result.found.push_back({{b.number, image}, {center.value_or(b.ball.center + by), b.ball.radius}});
    };
    const double far = (reach + self.radius + largest_) * favour;
    if (!repeats()) {
        in_cubes(self.center, far, [&](const Ball& b) { look_at(b, {}, Vec3::Zero(), 0); });
    } else {
        const bool is_all = for_images({low_, high_}, self.center, far, [&](const ImageIndex& image) {
            if (result.found.size() > most_found) return;
            const Vec3 by = shift(image);
            // Sums of four numbers of the size of the coordinates and the edges.
            const double slack =
                0x1p-46 * (self.center.norm() + by.norm() + low_.norm() + high_.norm() + far);
            in_cubes(self.center - by, far + slack, [&](const Ball& b) { look_at(b, image, by, slack); });
        });
        if (!is_all || result.found.size() > most_found)
            result.lack = "more images of balls may reach it than are looked at";
        else if (!is_exact_ || !is_exact)
            result.lack = "where an image of a ball is that may reach it is no double";
    }
    std::ranges::sort(result.found, {}, &Found::object);
    return result;
}

double NearBalls::farthest() const {
    if (!repeats()) return std::numeric_limits<double>::infinity();
    // Half of each edge that repeats, as the ball's own images are as near there, and the box otherwise.
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        ImageIndex one{};
        one[static_cast<std::size_t>(k)] = 1;
        sum += scene_.periodic[static_cast<std::size_t>(k)] ? 0.5 * shift(one).norm()
                                                            : size_[static_cast<std::size_t>(k)];
    }
    return sum * favour;
}

Vec3 NearBalls::shift(const ImageIndex& image) const {
    const auto& [xy, xz, yz] = scene_.tilt;
    const auto [a, b, c] = image;
    return {a * size_[0] + b * xy + c * xz, b * size_[1] + c * yz, c * size_[2]};
}

// The sum that shift() makes, without a rounding; nothing where one is needed.
std::optional<Vec3> NearBalls::moved(const Vec3& p, const ImageIndex& image) const {
    if (image == ImageIndex{}) return p;
    const auto& [xy, xz, yz] = scene_.tilt;
    const std::array<std::array<double, 3>, 3> rows{
        {{size_[0], xy, xz}, {0, size_[1], yz}, {0, 0, size_[2]}}};
    Vec3 sum = p;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t k = r; k < 3; ++k) {
            const auto step = exact_multiple(image[k], rows[r][k]);
            const auto next = step ? exact_sum(sum[static_cast<Eigen::Index>(r)], *step) : std::nullopt;
            if (!next) return std::nullopt;
            sum[static_cast<Eigen::Index>(r)] = *next;
        }
    return sum;
}

}  // namespace vcell::check
