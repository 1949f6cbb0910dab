/// Scenes in cubes about the origin, and random places and directions for them.
#pragma once

#include <Eigen/Geometry>
#include <random>
#include <utility>
#include <vector>

#include "../../primitives/objects/scene.hpp"
#include "../test_support.hpp"

namespace vcell {

inline Scene scene_in_cube(const Object& base, std::vector<Object> objects, double half) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    scene.box = {Vec3::Constant(-half), Vec3::Constant(half)};
    return scene;
}

struct RandomPlaces {
    std::mt19937_64 rng{test_seed()};

    double uniform(double a, double b) { return std::uniform_real_distribution(a, b)(rng); }
    int count(int a, int b) { return std::uniform_int_distribution(a, b)(rng); }
    Vec3 place(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
    Vec3 direction() {
        std::normal_distribution<double> n;
        return Vec3(n(rng), n(rng), n(rng)).normalized();
    }
};

}  // namespace vcell
