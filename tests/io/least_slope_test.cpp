#include "../../io/check/least_slope.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "../test_support.hpp"

namespace vcell::check {

namespace {

class SlopeScenes {
public:
    Vec3 point() { return {at(), at(), at()}; }
    Object object(int kind) {
        const Vec3 p = 2 * point(), d = point().normalized();
        if (kind == 0) return Plane{p, d};
        if (kind == 1) return Sphere{p, 0.5 * std::abs(at())};
        return Cylinder{p, d, 0.5 * std::abs(at())};
    }
    double at() { return std::uniform_real_distribution<>(-1, 1)(rng_); }

private:
    std::mt19937_64 rng_{test_seed()};
};

// The signed distance and the direction in which it grows, in doubles.
std::pair<double, Vec3> distance_and_gradient(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object))
        return {plane->normal.normalized().dot(p - plane->point), plane->normal.normalized()};
    if (const auto* ball = std::get_if<Sphere>(&object))
        return {(p - ball->center).norm() - ball->radius, (p - ball->center).normalized()};
    const auto& tube = std::get<Cylinder>(object);
    const Vec3 d = tube.axis.normalized(), way = p - tube.point, out = way - d.dot(way) * d;
    return {out.norm() - tube.radius, out.normalized()};
}

}  // namespace

TEST_CASE("least slope: no gradient is shorter where the excess is small, and at a point it is that of it") {
    SlopeScenes r;
    int told = 0;
    for (int round = 0; round < 4000; ++round) {
        Scene scene;
        scene.base = r.object(round % 3);
        scene.objects = {r.object(round / 3 % 3)};
        scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
        const Space<Interval> space(scene);
        const Vec3 middle = 2 * r.point();
        // A point, or the points about a bilinear patch, all the farther the flatter it is.
        const double half = round % 2 == 0 ? 0 : 0.2 * std::abs(r.at()), margin = half * 0.5 * (1 + r.at());
        std::array<Vec3, 4> corners;
        for (Vec3& c : corners) c = middle + (half - margin) * r.point();
        Net net(1, 1, Vec3::Zero());
        for (int k = 0; k < 4; ++k)
            net.at(k / 2, k % 2) = {corners[k].x(), corners[k].y(), corners[k].z(), 1.0};
        // Their own excesses are the ones asked about.
        double size = 0, least = HUGE_VAL;
        for (int i = 0; i < 20; ++i) {
            const double s = 0.5 * (1 + r.at()), t = 0.5 * (1 + r.at());
            const Vec3 on = (1 - s) * ((1 - t) * corners[0] + t * corners[1]) +
                            s * ((1 - t) * corners[2] + t * corners[3]),
                       p = on + margin * r.point().normalized();
            auto [d, n] = distance_and_gradient(scene.objects[0], p);
            const auto [h, u] = distance_and_gradient(scene.base, p);
            if (space.is_sided(0) && n.dot(check::middle(space.object(0).direction)) < 0) {
                d = -d;
                n = -n;
            }
            size = std::max(size, std::abs(d - h) * (1 + 1e-12));
            least = std::min(least, (n - u).norm());
        }
        const double slope = least_slope(space, 0, net, margin, size);
        CHECK(slope <= least * (1 + 1e-9) + 1e-12);
        if (slope > 0) ++told;
        // Where the excess is known it is the gradient's length itself.
        const auto [d, n] = distance_and_gradient(scene.objects[0], middle);
        const auto [h, u] = distance_and_gradient(scene.base, middle);
        if (half == 0 && std::abs(d - h) < 0.01 * std::abs(h) && slope > 0)
            CHECK(slope > 0.8 * (n - u).norm());
    }
    CHECK(told > 400);
}

}  // namespace vcell::check
