/// Scenes of bench_growth: n objects of a mix about a base, such that the cell has O(n) faces.
///
/// Over a plane and around a tube the objects have constant density: over a square, or where tubes cross it
/// over a strip n / 8 long, and along a stretch n / 8 long. Around a ball, and tubes along a tube, they lie in a
/// shell that gets thinner as they get more, so that a constant part of them is seen.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "../primitives/scene.hpp"
#include "mixed_scene.hpp"

namespace vcell::bench {

enum class GrowthBase { Plane, Ball, Tube };
enum class Mix { Balls, OneRod, Rods, ParallelTubes, SkewTubes, WallsAndRod };

inline constexpr std::array growth_bases{GrowthBase::Plane, GrowthBase::Ball, GrowthBase::Tube};
inline constexpr std::array mixes{Mix::Balls,         Mix::OneRod,    Mix::Rods,
                                  Mix::ParallelTubes, Mix::SkewTubes, Mix::WallsAndRod};

inline std::string name_of(GrowthBase base) {
    return std::array{"plane", "ball", "tube"}[static_cast<std::size_t>(base)];
}
inline std::string name_of(Mix mix) {
    return std::array{"balls",          "balls_rod",  "balls_rods",
                      "parallel_tubes", "skew_tubes", "balls_walls_rod"}[static_cast<std::size_t>(mix)];
}

/// One object in so many is a rod, or around a ball a plane, where their share is constant.
inline constexpr std::uint32_t rods_one_in = 8;

class GrowthScenes {
public:
    GrowthScenes(std::uint32_t n, std::uint64_t seed) : n_(n), random_(seed) {}

    /// Pre: n >= 10.
    Scene make(GrowthBase base, Mix mix) {
        scene_ = {};
        mix_ = mix;
        if (base == GrowthBase::Plane) over_plane();
        if (base == GrowthBase::Ball) around_ball();
        if (base == GrowthBase::Tube) around_tube();
        return std::move(scene_);
    }

private:
    static constexpr double turn = 2 * std::numbers::pi;

    double uniform(double low, double high) { return random_.uniform(low, high); }
    Vec3 direction() {
        const double z = uniform(-1, 1), angle = uniform(0, turn), r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    // How many of the n objects are rods.
    std::uint32_t rods() const {
        switch (mix_) {
            case Mix::Balls: return 0;
            case Mix::OneRod:
            case Mix::WallsAndRod: return 1;
            case Mix::Rods: return n_ / rods_one_in;
            case Mix::ParallelTubes:
            case Mix::SkewTubes: break;
        }
        return n_;
    }
    // After planes, if there are any.
    template <class AddRod, class AddBall>
    void add_rods_and_balls(const AddRod& add_rod, const AddBall& add_ball) {
        for (std::uint32_t i = 0; i < rods(); ++i) add_rod();
        while (scene_.objects.size() < n_) add_ball();
    }

    void over_plane() {
        const bool is_strip = mix_ == Mix::Rods || mix_ == Mix::SkewTubes || mix_ == Mix::ParallelTubes;
        const double length = is_strip ? n_ / 8.0 : std::sqrt(static_cast<double>(n_)),
                     width = is_strip ? 8 : length;
        scene_.base = Plane{};
        scene_.box = {{0, 0, 0}, {length, width, 6}};
        const auto place = [&] { return Vec3(uniform(0, length), uniform(0, width), uniform(0.4, 1.5)); };
        const auto add_rod = [&] {
            const Vec3 p = is_strip ? place() : Vec3(length / 2, width / 2, uniform(0.4, 1.5));
            const double angle = uniform(0, turn);
            const Vec3 axis = mix_ == Mix::ParallelTubes ? Vec3(0.25, 1, 0)
                              : is_strip                 ? Vec3(uniform(-0.5, 0.5), 1, uniform(-0.01, 0.01))
                                         : Vec3(std::cos(angle), std::sin(angle), 0.01 / length);
            scene_.objects.push_back(Cylinder{p, axis, uniform(0.02, 0.2)});
        };
        if (mix_ == Mix::WallsAndRod)
            for (int i = 0; i < 4; ++i)
                scene_.objects.push_back(Plane{{length / 2, width / 2, uniform(1.3, 1.5)},
                                               {uniform(-0.5, 0.5) / length, uniform(-0.5, 0.5) / length, 1}});
        add_rods_and_balls(add_rod, [&] {
            const Vec3 p = place();
            scene_.objects.push_back(Sphere{p, uniform(0.02, std::min(0.25, p.z() - 0.1))});
        });
    }

    void around_ball() {
        const double thickness = 10.0 / n_;
        scene_.base = Sphere{Vec3::Zero(), 1};
        scene_.box = {Vec3::Constant(-8), Vec3::Constant(8)};
        const auto add_rod = [&] {
            const Vec3 axis = mix_ == Mix::ParallelTubes ? Vec3(1, 2, 2) / 3 : direction();
            const Vec3 out = axis.cross(direction()).normalized();
            const double radius = rods() == 1 ? uniform(0.02, 0.3) : uniform(0, 4.0 / n_);
            scene_.objects.push_back(Cylinder{(uniform(2, 2 + thickness) + radius) * out, 3 * axis, radius});
        };
        if (mix_ == Mix::WallsAndRod)
            for (std::uint32_t i = 0; i < n_ / rods_one_in; ++i) {
                const Vec3 normal = direction();
                scene_.objects.push_back(Plane{uniform(2, 2 + thickness) * normal, normal});
            }
        add_rods_and_balls(add_rod, [&] {
            scene_.objects.push_back(Sphere{uniform(2, 2 + thickness) * direction(), uniform(0, 4.0 / n_)});
        });
    }

    void around_tube() {
        const bool is_along = mix_ == Mix::ParallelTubes;
        const double length = is_along ? 4 : n_ / 8.0;
        scene_.base = Cylinder{Vec3::Zero(), Vec3::UnitZ(), 0.3};
        scene_.box = {{-3, -3, 0}, {3, 3, length}};
        const auto add_rod = [&] {
            const double angle = uniform(0, turn);
            const Vec3 out(std::cos(angle), std::sin(angle), 0), across(-out.y(), out.x(), 0);
            if (is_along) {
                const double radius = uniform(0, 2.0 / n_);
                scene_.objects.push_back(
                    Cylinder{(uniform(1, 1 + 5.0 / n_) + radius) * out, Vec3::UnitZ(), radius});
                return;
            }
            const double radius = uniform(0.02, 0.2);
            const Vec3 p = (uniform(0.8, 1.6) + radius) * out + uniform(0, length) * Vec3::UnitZ();
            scene_.objects.push_back(Cylinder{p, across + uniform(-0.5, 0.5) * Vec3::UnitZ(), radius});
        };
        if (mix_ == Mix::WallsAndRod)
            for (const double angle : {0.2, 1.7, 3.1, 4.8}) {
                const Vec3 out(std::cos(angle), std::sin(angle), 0);
                scene_.objects.push_back(Plane{2 * out, out + 0.2 / length * Vec3::UnitZ()});
            }
        add_rods_and_balls(add_rod, [&] {
            const double angle = uniform(0, turn), radius = uniform(0.02, 0.2), out = uniform(0.8, 1.6) + radius;
            scene_.objects.push_back(
                Sphere{{out * std::cos(angle), out * std::sin(angle), uniform(0, length)}, radius});
        });
    }

    std::uint32_t n_;
    RandomLengths random_;
    Scene scene_;
    Mix mix_ = Mix::Balls;
};

inline Scene growth_scene(GrowthBase base, Mix mix, std::uint32_t n, std::uint64_t seed) {
    return GrowthScenes(n, seed).make(base, mix);
}

}  // namespace vcell::bench
