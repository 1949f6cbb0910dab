/// Scenes of bench_growth: n objects of a mix about a base, such that the cell has O(n) faces.
///
/// Over a plane and around a tube the objects have constant density: over a square, or where tubes cross it
/// over a strip n / 8 long, and along a stretch n / 8 long. Around a ball, and tubes along a tube, they lie
/// in a shell that gets thinner as they get more, so that a constant part of them is seen. Objects of a
/// `shell` all touch one surface parallel to the base.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "../primitives/objects/scene.hpp"
#include "../tests/rotations.hpp"
#include "mixed_scene.hpp"

namespace vcell::bench {

enum class GrowthBase { Plane, TiltedPlane, Ball, Tube };
enum class Mix { Balls, Walls, OneRod, WallsAndRod, Rods, Shell, ParallelTubes, SkewTubes };

inline constexpr std::array growth_bases{GrowthBase::Plane, GrowthBase::TiltedPlane, GrowthBase::Ball,
                                         GrowthBase::Tube};
inline constexpr std::array mixes{Mix::Balls, Mix::Walls, Mix::OneRod,        Mix::WallsAndRod,
                                  Mix::Rods,  Mix::Shell, Mix::ParallelTubes, Mix::SkewTubes};

inline std::string name_of(GrowthBase base) {
    return std::array{"plane", "tilted_plane", "ball", "tube"}[static_cast<std::size_t>(base)];
}
inline std::string name_of(Mix mix) {
    return std::array{
        "balls",      "balls_walls", "balls_rod",      "balls_walls_rod",
        "balls_rods", "shell",       "parallel_tubes", "skew_tubes"}[static_cast<std::size_t>(mix)];
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
        if (base == GrowthBase::Plane || base == GrowthBase::TiltedPlane) over_plane();
        if (base == GrowthBase::TiltedPlane) tilt();
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
            case Mix::Balls:
            case Mix::Walls: return 0;
            case Mix::OneRod:
            case Mix::WallsAndRod: return 1;
            case Mix::Rods:
            case Mix::Shell: return n_ / rods_one_in;
            case Mix::ParallelTubes:
            case Mix::SkewTubes: break;
        }
        return n_;
    }
    bool has_walls() const { return mix_ == Mix::Walls || mix_ == Mix::WallsAndRod; }
    // How far an object is from the base, or from its centre.
    double distance(double low, double high) { return uniform(low, mix_ == Mix::Shell ? low : high); }

    // After planes, if there are any.
    template <class AddRod, class AddBall>
    void add_rods_and_balls(const AddRod& add_rod, const AddBall& add_ball) {
        for (std::uint32_t i = 0; i < rods(); ++i) add_rod();
        while (scene_.objects.size() < n_) add_ball();
    }

    void over_plane() {
        const bool is_strip = rods() > 1;
        const double length = is_strip ? n_ / 8.0 : std::sqrt(static_cast<double>(n_)),
                     width = is_strip ? 8 : length;
        scene_.base = Plane{};
        scene_.box = {{0, 0, 0}, {length, width, 6}};
        const auto place = [&] { return Vec3(uniform(0, length), uniform(0, width), uniform(0.4, 1.5)); };
        const auto touch_shell = [&](Vec3& p, double radius) {
            if (mix_ == Mix::Shell) p.z() = 1 + radius;
        };
        const auto add_rod = [&] {
            Vec3 p = is_strip ? place() : Vec3(length / 2, width / 2, uniform(0.4, 1.5));
            const double angle = uniform(0, turn), radius = uniform(0.02, 0.2);
            touch_shell(p, radius);
            const Vec3 axis = mix_ == Mix::ParallelTubes ? Vec3(0.25, 1, 0)
                              : mix_ == Mix::Shell       ? Vec3(uniform(-0.5, 0.5), 1, 0)
                              : is_strip                 ? Vec3(uniform(-0.5, 0.5), 1, uniform(-0.01, 0.01))
                                         : Vec3(std::cos(angle), std::sin(angle), 0.01 / length);
            scene_.objects.push_back(Cylinder{p, axis, radius});
        };
        if (has_walls())
            for (int i = 0; i < 4; ++i)
                scene_.objects.push_back(
                    Plane{{length / 2, width / 2, uniform(1.3, 1.5)},
                          {uniform(-0.5, 0.5) / length, uniform(-0.5, 0.5) / length, 1}});
        add_rods_and_balls(add_rod, [&] {
            Vec3 p = place();
            const double radius = uniform(0.02, std::min(0.25, p.z() - 0.1));
            touch_shell(p, radius);
            scene_.objects.push_back(Sphere{p, radius});
        });
    }

    // Turns all that is over the plane about the origin.
    void tilt() {
        const Vec3 normal(-0.125, 0.25, 1);
        const Eigen::Quaterniond turned = rotation_from_z(normal);
        scene_.base = Plane{Vec3::Zero(), normal};
        for (Object& o : scene_.objects)
            std::visit([&](auto& object) { turn_about_origin(object, turned); }, o);
        // There the plane is at z = 0.125 x - 0.25 y.
        scene_.box.min.z() -= 0.25 * scene_.box.max.y();
        scene_.box.max.z() += 0.125 * scene_.box.max.x();
    }
    static void turn_about_origin(Plane& plane, const Eigen::Quaterniond& q) {
        plane.point = q * plane.point;
        plane.normal = q * plane.normal;
    }
    static void turn_about_origin(Sphere& ball, const Eigen::Quaterniond& q) {
        ball.center = q * ball.center;
    }
    static void turn_about_origin(HollowSphere& vessel, const Eigen::Quaterniond& q) {
        vessel.center = q * vessel.center;
    }
    static void turn_about_origin(HollowCylinder& vessel, const Eigen::Quaterniond& q) {
        vessel.point = q * vessel.point;
        vessel.axis = q * vessel.axis;
    }
    static void turn_about_origin(HollowCone& vessel, const Eigen::Quaterniond& q) {
        vessel.apex = q * vessel.apex;
        vessel.axis = q * vessel.axis;
    }
    static void turn_about_origin(Cylinder& tube, const Eigen::Quaterniond& q) {
        tube.point = q * tube.point;
        tube.axis = q * tube.axis;
    }

    void around_ball() {
        const double thickness = 10.0 / n_;
        scene_.base = Sphere{Vec3::Zero(), 1};
        scene_.box = {Vec3::Constant(-8), Vec3::Constant(8)};
        const auto add_rod = [&] {
            const Vec3 axis = mix_ == Mix::ParallelTubes ? Vec3(1, 2, 2) / 3 : direction();
            const Vec3 out = axis.cross(direction()).normalized();
            const double radius = rods() == 1 ? uniform(0.02, 0.3) : uniform(0, 4.0 / n_);
            scene_.objects.push_back(Cylinder{(distance(2, 2 + thickness) + radius) * out, 3 * axis, radius});
        };
        if (has_walls())
            for (std::uint32_t i = 0; i < n_ / rods_one_in; ++i) {
                const Vec3 normal = direction();
                scene_.objects.push_back(Plane{uniform(2, 2 + thickness) * normal, normal});
            }
        add_rods_and_balls(add_rod, [&] {
            const double radius = uniform(0, 4.0 / n_);
            const double out = distance(2, 2 + thickness) + (mix_ == Mix::Shell ? radius : 0);
            scene_.objects.push_back(Sphere{out * direction(), radius});
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
            const Vec3 p = (distance(0.8, 1.6) + radius) * out + uniform(0, length) * Vec3::UnitZ();
            scene_.objects.push_back(Cylinder{p, across + uniform(-0.5, 0.5) * Vec3::UnitZ(), radius});
        };
        if (has_walls())
            for (const double angle : {0.2, 1.7, 3.1, 4.8}) {
                const Vec3 out(std::cos(angle), std::sin(angle), 0);
                scene_.objects.push_back(Plane{2 * out, out + 0.2 / length * Vec3::UnitZ()});
            }
        add_rods_and_balls(add_rod, [&] {
            const double angle = uniform(0, turn), radius = uniform(0.02, 0.2),
                         out = distance(0.8, 1.6) + radius;
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
