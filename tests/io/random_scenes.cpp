#include "random_scenes.hpp"

#include <Eigen/Core>

namespace vcell {

namespace {

double uniform(std::mt19937_64& rng, double lo, double hi) {
    return std::uniform_real_distribution(lo, hi)(rng);
}

Vec3 direction(std::mt19937_64& rng) {
    std::normal_distribution<double> normal;
    return Vec3(normal(rng), normal(rng), normal(rng)).normalized();
}

Scene in_box(const Object& base) {
    Scene scene;
    scene.base = base;
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    return scene;
}

}  // namespace

Scene scene_about_ball(std::mt19937_64& rng, int balls, int planes) {
    constexpr double radius = 0.5, gap = 0.1;
    Scene scene = in_box(Sphere{Vec3::Zero(), radius});
    for (int k = 0; k < balls; ++k) {
        const double own = k % 3 == 0 ? radius : uniform(rng, 0, 0.4);
        scene.objects.push_back(Sphere{(radius + own + gap + uniform(rng, 0, 1)) * direction(rng), own});
    }
    for (int k = 0; k < planes; ++k) {
        const Vec3 n = direction(rng);
        scene.objects.push_back(Plane{uniform(rng, radius + gap, 1.8) * n, n});
    }
    return scene;
}

Scene scene_over_plane(std::mt19937_64& rng, int balls, int planes) {
    Scene scene = in_box(Plane{Vec3::Zero(), Vec3::UnitZ()});
    for (int k = 0; k < balls; ++k) {
        const double own = k % 3 == 0 ? 0 : uniform(rng, 0, 0.3);
        scene.objects.push_back(
            Sphere{{uniform(rng, -2, 2), uniform(rng, -2, 2), own + uniform(rng, 0.1, 1.2)}, own});
    }
    // They meet the base plane outside the box.
    for (int k = 0; k < planes; ++k) {
        const Vec3 n = Vec3(uniform(rng, -0.2, 0.2), uniform(rng, -0.2, 0.2), 1);
        scene.objects.push_back(Plane{Vec3(0, 0, uniform(rng, 1.2, 1.8)), n});
    }
    return scene;
}

}  // namespace vcell
