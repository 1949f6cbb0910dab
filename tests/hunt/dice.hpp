/// Random numbers, places and directions for families of scenes.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "../../primitives/objects/objects.hpp"

namespace vcell::hunt {

class Dice {
public:
    explicit Dice(std::mt19937_64& rng) : rng_(rng) {}

    double uniform(double a, double b) { return std::uniform_real_distribution(a, b)(rng_); }
    int count(int a, int b) { return std::uniform_int_distribution(a, b)(rng_); }
    bool chance(double p) { return uniform(0, 1) < p; }
    /// 10^-k for an even spread of k.
    double small(double least_digits, double most_digits) {
        return std::pow(10, -uniform(least_digits, most_digits));
    }
    Vec3 direction() {
        std::normal_distribution<double> n;
        return Vec3(n(rng_), n(rng_), n(rng_)).normalized();
    }
    Vec3 place(double half = 2) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
    Vec3 integers(int most) { return Vec3(count(-most, most), count(-most, most), count(-most, most)); }
    Vec3 integer_direction(int most) {
        for (;;)
            if (const Vec3 d = integers(most); !d.isZero()) return d;
    }
    /// One up or down in each coordinate's last digit, or none.
    Vec3 ulps(Vec3 p) {
        for (double& x : p)
            if (const int step = count(-1, 1)) x = std::nextafter(x, step * HUGE_VAL);
        return p;
    }

private:
    std::mt19937_64& rng_;
};

}  // namespace vcell::hunt
