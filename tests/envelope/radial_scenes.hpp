/// Scenes over sphere and cylinder bases.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <variant>

#include "../../primitives/objects/scene.hpp"

namespace vcell::radial {

/// Random scenes of size about 1, the base at the origin, its axis along z; move them with moved().
class RandomScenes {
public:
    explicit RandomScenes(std::mt19937_64& rng) : rng_(rng) {}

    double uniform(double a, double b) { return std::uniform_real_distribution(a, b)(rng_); }
    int count(int a, int b) { return std::uniform_int_distribution(a, b)(rng_); }
    Vec3 direction() {
        std::normal_distribution<double> n;
        const Vec3 v(n(rng_), n(rng_), n(rng_));
        return v.normalized();
    }

    Scene over_sphere(double radius = 0.3) {
        Scene s;
        s.base = Sphere{Vec3::Zero(), radius};
        s.box = {{-2.5, -2.25, -2.75}, {2.25, 2.75, 2.5}};
        return s;
    }
    Scene over_cylinder(double radius = 0.3) {
        Scene s;
        s.base = Cylinder{Vec3::Zero(), Vec3::UnitZ(), radius};
        s.box = {{-2.5, -2.25, -2.75}, {2.25, 2.75, 2.5}};
        return s;
    }
    void add_ball(Scene& s, double largest = 0.4) {
        while (true) {
            const double rho = uniform(0, 1) < 0.2 ? 0 : uniform(0, largest);
            if (add_if_clear(s, Sphere{place(), rho})) return;
        }
    }
    /// Its radius has a heavy tail: most are small, a few as large as the scene.
    void add_heavy_ball(Scene& s) {
        while (true) {
            const double rho = 0.02 * std::pow(uniform(1e-4, 1), -0.6);
            if (add_if_clear(s, Sphere{(1 + rho) * place(), rho})) return;
        }
    }
    void add_plane(Scene& s) {
        const bool cylinder = std::holds_alternative<Cylinder>(s.base);
        while (true) {
            Vec3 n = direction();
            if (cylinder) n.z() *= 0.2;
            if (add_if_clear(s, Plane{uniform(0.6, 2) * n.normalized(), uniform(0.5, 2) * n})) return;
        }
    }
    void add_cylinder(Scene& s, double largest = 0.3) {
        while (true) {
            const double rho = uniform(0, 1) < 0.2 ? 0 : uniform(0, largest);
            const Vec3 axis = direction();
            if (add_if_clear(s, Cylinder{place(), uniform(0.5, 2) * axis, rho})) return;
        }
    }
    void add(Scene& s, int balls, int planes, int cylinders) {
        for (int i = 0; i < balls; ++i) add_ball(s);
        for (int i = 0; i < planes; ++i) add_plane(s);
        for (int i = 0; i < cylinders; ++i) add_cylinder(s);
    }

    /// The gap between an object and a base in its initial place.
    static double gap(const Scene& s, const Object& object) {
        if (const auto* base = std::get_if<Sphere>(&s.base)) {
            if (const auto* b = std::get_if<Sphere>(&object))
                return b->center.norm() - b->radius - base->radius;
            if (const auto* p = std::get_if<Plane>(&object))
                return std::abs(p->normal.normalized().dot(p->point)) - base->radius;
            const auto& c = std::get<Cylinder>(object);
            return c.point.cross(c.axis.normalized()).norm() - c.radius - base->radius;
        }
        const double radius = std::get<Cylinder>(s.base).radius;
        if (const auto* b = std::get_if<Sphere>(&object))
            return b->center.head<2>().norm() - b->radius - radius;
        if (const auto* p = std::get_if<Plane>(&object)) {  // over the part of the axis in the box
            const Vec3 n = p->normal.normalized();
            const double low = n.dot(Vec3(0, 0, s.box.min.z()) - p->point),
                         high = n.dot(Vec3(0, 0, s.box.max.z()) - p->point);
            return low * high < 0 ? -1 : std::min(std::abs(low), std::abs(high)) - radius;
        }
        const auto& c = std::get<Cylinder>(object);
        const Vec3 across = c.axis.normalized().cross(Vec3::UnitZ());
        const double apart =
            across.norm() < 1e-3 ? c.point.head<2>().norm() : std::abs(across.normalized().dot(c.point));
        return apart - c.radius - radius;
    }

private:
    Vec3 place() { return {uniform(-2, 2), uniform(-2, 2), uniform(-2, 2)}; }
    bool add_if_clear(Scene& s, const Object& object) {
        if (gap(s, object) < 0.05) return false;
        s.objects.push_back(object);
        return true;
    }

    std::mt19937_64& rng_;
};

/// The object turned about the origin, scaled, and shifted.
inline Object moved(const Object& object, const Eigen::Matrix3d& turn, double factor, const Vec3& shift) {
    const auto place = [&](const Vec3& p) -> Vec3 { return factor * (turn * p) + shift; };
    if (const auto* s = std::get_if<Sphere>(&object)) return Sphere{place(s->center), factor * s->radius};
    if (const auto* p = std::get_if<Plane>(&object)) return Plane{place(p->point), turn * p->normal};
    const auto& c = std::get<Cylinder>(object);
    return Cylinder{place(c.point), turn * c.axis, factor * c.radius};
}

/// All of the scene moved but the box, which only is scaled and shifted.
inline Scene moved(Scene s, const Eigen::Matrix3d& turn, double factor, const Vec3& shift) {
    s.base = moved(s.base, turn, factor, shift);
    for (Object& o : s.objects) o = moved(o, turn, factor, shift);
    s.box = {factor * s.box.min + shift, factor * s.box.max + shift};
    return s;
}

}  // namespace vcell::radial
