/// Solids over a region and their heights from their definition: the clearance r at which the point (x, y, r)
/// is r away from the object, solved for in long double, and in 100 digits where that does not tell. Shares
/// no code with lower_envelope() but the types.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include "oracle.hpp"

namespace vcell::mixed {

using oracle::Point;
using oracle::Real;
using Fast = long double;

/// Solids in canonical coordinates. A plane is given by its height (a x + b y + e) / w.
struct Ball {
    double x, y, z, rho;
};
struct Wall {
    double a, b, e, w;
};
using Solid = std::variant<Ball, Wall, CylinderForm>;

/// Solids over a region. Forms are numbered as in a FormFamily: cylinders after all others.
struct Scene {
    std::string name;
    std::vector<Solid> circular;
    std::vector<CylinderForm> cylinders;
    ConvexRegion region = ConvexRegion::rectangle(-2, -2, 2, 2);

    Scene& ball(double x, double y, double z, double rho) {
        circular.push_back(Ball{x, y, z, rho});
        return *this;
    }
    Scene& wall(double a, double b, double e, double w = 1) {
        circular.push_back(Wall{a, b, e, w});
        return *this;
    }
    Scene& cylinder(double px, double py, double pz, double ax, double ay, double az, double rho) {
        cylinders.push_back({px, py, pz, ax, ay, az, rho});
        return *this;
    }
    std::size_t size() const { return circular.size() + cylinders.size(); }
    Solid solid(std::size_t i) const {
        return i < circular.size() ? circular[i] : Solid(cylinders[i - circular.size()]);
    }

    FormFamily family() const {
        FormFamily f;
        for (const Solid& s : circular)
            if (const Ball* b = std::get_if<Ball>(&s))
                f.forms.push_back(
                    {1, b->x, b->y, 0, 0, (b->z - b->rho) * (b->z + b->rho), 2 * (b->z + b->rho)});
            else
                f.forms.push_back({0, 0, 0, std::get<Wall>(s).a, std::get<Wall>(s).b, std::get<Wall>(s).e,
                                   std::get<Wall>(s).w});
        f.exact = [all = circular](FormId id) {
            if (const Wall* p = std::get_if<Wall>(&all[id.value]))
                return ExactForm{{}, p->a, p->b, p->e, p->w};
            const Ball& b = std::get<Ball>(all[id.value]);
            const Exact x(b.x), y(b.y), z(b.z), rho(b.rho), two(2.0);
            return ExactForm{Exact(1.0), -two * x, -two * y, x * x + y * y + (z - rho) * (z + rho),
                             two * (z + rho)};
        };
        f.cylinders = cylinders;
        return f;
    }
};

// --- Heights ----------------------------------------------------------------------------------------

/// The distance of a point from a solid's surface, and the unit vector away from it.
template <class T>
struct Distance {
    T value;
    std::array<T, 3> away;
};

template <class T>
Distance<T> distance(const Ball& s, const T& x, const T& y, const T& z) {
    using oracle::root;
    const T dx = x - T(s.x), dy = y - T(s.y), dz = z - T(s.z);
    const T n = root(dx * dx + dy * dy + dz * dz);
    return {n - T(s.rho), {dx / n, dy / n, dz / n}};
}

// The plane a x + b y + c z + e = 0 whose normal is c + w long.
template <class T>
Distance<T> distance(const Wall& s, const T& x, const T& y, const T& z) {
    const T a(s.a), b(s.b), w(s.w), c = (a * a + b * b - w * w) / (2 * w), n = c + w;
    return {(a * x + b * y + c * z + T(s.e)) / n, {a / n, b / n, c / n}};
}

template <class T>
Distance<T> distance(const CylinderForm& s, const T& x, const T& y, const T& z) {
    using oracle::root;
    const T mx = x - T(s.px), my = y - T(s.py), mz = z - T(s.pz), ax(s.ax), ay(s.ay), az(s.az);
    const T cx = my * az - mz * ay, cy = mz * ax - mx * az, cz = mx * ay - my * ax;  // m x a
    const T cc = cx * cx + cy * cy + cz * cz, aa = ax * ax + ay * ay + az * az, scale = root(cc * aa);
    return {root(cc / aa) - T(s.rho),
            {(ay * cz - az * cy) / scale, (az * cx - ax * cz) / scale, (ax * cy - ay * cx) / scale}};
}

template <class T>
struct Height {
    T v, gx, gy;
    T sensitivity;  ///< of v to the rounding of distances
};

/// The clearance above (x, y). distance - r is convex and falls: from the left Newton's method ascends to the
/// root.
template <class T>
Height<T> height(const Solid& solid, const T& x, const T& y, T r = T(0)) {
    using std::abs;
    const T enough = std::numeric_limits<T>::epsilon() * T(2);
    Distance<T> d;
    for (int i = 0; i < 200; ++i) {
        d = std::visit([&](const auto& s) { return distance<T>(s, x, y, r); }, solid);
        const T step = (d.value - r) / (1 - d.away[2]);
        r += step;
        if (i > 0 && step <= enough * abs(r)) break;
    }
    const T slope = 1 - d.away[2];
    return {r, d.away[0] / slope, d.away[1] / slope, 1 / slope};
}

inline Fast size_of(const Solid& solid, Fast x, Fast y) {
    struct {
        Fast x, y;
        Fast operator()(const Ball& s) const { return std::hypot(x - s.x, y - s.y) + std::abs(s.z) + s.rho; }
        Fast operator()(const Wall& s) const {
            return (std::abs(s.a * x) + std::abs(s.b * y) + std::abs(s.e)) * 2 * s.w /
                   (s.a * s.a + s.b * s.b + s.w * s.w);
        }
        Fast operator()(const CylinderForm& s) const {
            return std::hypot(x - s.px, y - s.py) + std::abs(s.pz) + s.rho;
        }
    } const visitor{x, y};
    return std::visit(visitor, solid);
}

}  // namespace vcell::mixed
