/// Scenes of forms for the envelope's tests: random ones and degenerate ones.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"

namespace vcell {

/// Forms by their numbers, kept so that a scene can be moved. All numbers are dyadic and short: what is
/// degenerate in the drawing is degenerate in the doubles.
struct FormScene {
    struct Numbers {
        double k, cx, cy, a, b, e, w;
    };
    std::string name;
    std::vector<Numbers> numbers;
    std::array<double, 4> rectangle{-2, -2, 2, 2};
    std::optional<ConvexRegion> polygon;  // instead of the rectangle

    void sphere(double cx, double cy, double cz, double rho) {
        paraboloid(cx, cy, (cz - rho) * (cz + rho), 2 * (cz + rho));
    }
    void paraboloid(double cx, double cy, double e, double w) { numbers.push_back({1, cx, cy, 0, 0, e, w}); }
    void plane(double a, double b, double e, double w = 1) { numbers.push_back({0, 0, 0, a, b, e, w}); }

    ConvexRegion region() const {
        if (polygon) return *polygon;
        return ConvexRegion::rectangle(rectangle[0], rectangle[1], rectangle[2], rectangle[3]);
    }
    FormFamily family() const {
        FormFamily f;
        for (const Numbers& n : numbers) f.forms.push_back({n.k, n.cx, n.cy, n.a, n.b, n.e, n.w});
        f.exact = [all = numbers](FormId id) {
            const Numbers& n = all[id.value];
            const Exact k(n.k), cx(n.cx), cy(n.cy);
            return ExactForm{k, Exact(n.a) - Exact(2) * k * cx, Exact(n.b) - Exact(2) * k * cy,
                             Exact(n.e) + k * (cx * cx + cy * cy), Exact(n.w)};
        };
        return f;
    }
};

inline double dyadic(double x) { return std::ldexp(std::round(std::ldexp(x, 20)), -20); }

// --- Random scenes ----------------------------------------------------------------------------------

/// n spheres over the square [0, size]^2.
inline FormScene random_spheres(std::mt19937_64& rng, int n, double size) {
    std::uniform_real_distribution<double> u(0, 1);
    FormScene s{.name = "random spheres, n = " + std::to_string(n), .numbers = {}, .polygon = {}};
    s.rectangle = {0, 0, dyadic(size), dyadic(size)};
    for (int i = 0; i < n; ++i) {
        const double rho = dyadic(0.3 * u(rng));
        s.sphere(dyadic(size * u(rng)), dyadic(size * u(rng)), dyadic(rho + 0.1 + 2 * u(rng)), rho);
    }
    return s;
}

/// Radii by a power law and centres outside of the region too: big circles, small islands, deep nesting.
inline FormScene heavy_tailed(std::mt19937_64& rng, int n) {
    std::uniform_real_distribution<double> u(0, 1);
    FormScene s{.name = "heavy-tailed radii, n = " + std::to_string(n), .numbers = {}, .polygon = {}};
    for (int i = 0; i < n; ++i) {
        const double rho = dyadic(0.01 * std::pow(1e-4 + u(rng), -0.8));
        s.sphere(dyadic(6 * u(rng) - 3), dyadic(6 * u(rng) - 3), dyadic(rho * (1 + 2 * u(rng)) + 0.01), rho);
    }
    return s;
}

inline FormScene spheres_and_planes(std::mt19937_64& rng, int spheres, int planes) {
    std::uniform_real_distribution<double> u(-1, 1);
    FormScene s = random_spheres(rng, spheres, std::sqrt(spheres + planes));
    s.name = "spheres and planes, n = " + std::to_string(spheres + planes);
    const double middle = s.rectangle[2] / 2;
    for (int i = 0; i < planes; ++i) {
        const double a = dyadic(u(rng)), b = dyadic(u(rng));
        s.plane(a, b, dyadic(1.5 + 0.5 * u(rng) - (a + b) * middle), dyadic(1.25 + 0.5 * u(rng)));
    }
    return s;
}

inline FormScene in_polygon(FormScene s) {
    s.name += ", in a hexagon";
    const double m = s.rectangle[2];
    // Cuts two opposite corners off the square [0, m]^2.
    s.polygon =
        ConvexRegion{{{0, 1, 0}, {-1, 0, m}, {-1, -1, 1.5 * m}, {0, -1, m}, {1, 0, 0}, {2, 1, -0.5 * m}}};
    return s;
}

/// Forms with few different numbers: many coincidences of every kind.
inline FormScene coarse(std::mt19937_64& rng, int n) {
    FormScene s{.name = "coarse numbers, n = " + std::to_string(n), .numbers = {}, .polygon = {}};
    const auto pick = [&](int low, int high) {
        return std::uniform_int_distribution<int>(low, high)(rng) / 2.0;
    };
    while (static_cast<int>(s.numbers.size()) < n) {
        FormScene one = s;
        one.numbers.clear();
        if (pick(0, 4) == 0) {
            one.plane(pick(-2, 2), pick(-2, 2), pick(2, 6), pick(2, 4));
        } else {
            const double w = pick(1, 4), r = pick(0, 4);
            one.paraboloid(pick(-4, 4), pick(-4, 4), w - r * r, w);
        }
        // No function twice: a plane's numbers may be multiples of another's.
        const auto& m = one.numbers.front();
        const bool known = std::ranges::any_of(s.numbers, [&](const FormScene::Numbers& k) {
            return k.k * m.w == m.k * k.w && k.cx == m.cx && k.cy == m.cy && k.a * m.w == m.a * k.w &&
                   k.b * m.w == m.b * k.w && k.e * m.w == m.e * k.w;
        });
        if (!known) s.numbers.push_back(m);
    }
    return s;
}

// --- Degenerate scenes ------------------------------------------------------------------------------

inline FormScene lattice(const std::string& name, int n, double dx, double shear, double dy, double x0,
                         double y0) {
    FormScene s{.name = name, .numbers = {}, .polygon = {}};
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) s.sphere(x0 + i * dx + (j % 2) * shear, y0 + j * dy, 1, 0.25);
    return s;
}

/// Equal spheres centred on the circle of radius 65/64: all are equally near above its centre.
inline FormScene cocircular(double cx, double cy, const std::string& name) {
    FormScene s{.name = name, .numbers = {}, .polygon = {}};
    for (const auto& [x, y] :
         {std::pair{65, 0}, {63, 16}, {60, 25}, {56, 33}, {52, 39}, {39, 52}, {33, 56}, {25, 60}, {16, 63}})
        for (const auto& [p, q] : {std::pair{x, y}, {-y, x}, {-x, -y}, {y, -x}})
            s.sphere(cx + p / 64.0, cy + q / 64.0, 1, 0.5);
    return s;
}

inline std::vector<FormScene> degenerate_scenes() {
    std::vector<FormScene> all;
    const auto scene = [&](const std::string& name) -> FormScene& {
        all.push_back({.name = name, .numbers = {}, .polygon = {}});
        return all.back();
    };
    scene("empty");
    scene("one sphere").sphere(0.25, 0.5, 1, 0.5);
    scene("one plane").plane(0.25, 0, 2);

    all.push_back(lattice("square lattice", 6, 1, 0, 1, -2.5, -2.5));
    all.push_back(lattice("square lattice, rim through vertices and corners", 5, 1, 0, 1, -2.5, -2.5));
    all.push_back(lattice("square lattice, corners at centres, rim along bisectors", 5, 1, 0, 1, -2, -2));
    all.back().rectangle = {-1.5, -1, 1.5, 1};
    all.push_back(lattice("sheared lattice", 6, 1, 0.5, 0.875, -2.75, -2.25));
    all.push_back(lattice("hexagonal lattice, rounded", 6, 1, 0.5, std::sqrt(3) / 2, -2.75, -2.25));
    all.push_back(cocircular(0, 0, "36 cocircular"));
    all.push_back(cocircular(2, 0.5, "36 cocircular, centre on the rim"));
    all.push_back(cocircular(2, 2, "36 cocircular, centre in a corner"));
    all.push_back(cocircular(0, 0, "36 cocircular, one more in the middle"));
    all.back().sphere(0, 0, 1, 0.25);
    all.push_back(cocircular(0, 0, "36 cocircular, a plane through the vertex"));
    all.back().plane(0, 0, 1 + (65.0 * 65 / 4096 - 2.25) / 3);

    // Against the plane at height 1 a paraboloid (c, e = w - R^2, w) shows the disk |p - c| < R.
    const auto disk = [](FormScene& s, double x, double y, double r, double w) {
        s.paraboloid(x, y, w - r * r, w);
    };
    {
        FormScene& s = scene("tangent disks outside each other");
        s.plane(0, 0, 1);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) disk(s, i - 1.5, j - 1.5, 0.5, 2);
    }
    {
        FormScene& s = scene("tangent disks inside each other");
        s.plane(0, 0, 1);
        disk(s, 0, 0, 1.5, 4);
        disk(s, 0.5, 0, 1, 2);
        disk(s, 0.75, 0, 0.75, 1);
        disk(s, -1, 0, 0.5, 1);
    }
    {
        FormScene& s = scene("disks tangent to the rim");
        s.plane(0, 0, 1);
        disk(s, 1, 0, 1, 2);
        disk(s, -3, 0.5, 1, 2);
        disk(s, -1, -1, 1, 3);
    }
    {
        FormScene& s = scene("islands");
        s.plane(0, 0, 1);
        disk(s, 0, 0, 1.5, 8);
        for (int i = -1; i <= 1; ++i) s.paraboloid(i * 0.75, 0.125, 0.5 - 0.0625, 0.75);
    }
    {
        FormScene& s = scene("collinear centres, equal");
        for (int i = 0; i < 9; ++i) s.sphere(0.5 * i - 2, 0.25, 1, 0.25);
    }
    {
        FormScene& s = scene("collinear centres, unequal");
        for (int i = 0; i < 9; ++i) s.sphere(0.5 * i - 2, 0.25, 1 + 0.125 * (i % 3), 0.125 * (i % 4));
    }
    {
        FormScene& s = scene("concentric");
        for (int i = 1; i < 7; ++i) disk(s, 0.25, 0.125, 0.25 * i, 0.25 * i * (i + 1));
        s.plane(0, 0, 1);
    }
    {
        FormScene& s = scene("concentric, all equal on the axis");
        for (int i = 1; i < 7; ++i) s.paraboloid(0.25, 0.125, 0.75 * i, i);
    }
    {
        FormScene& s = scene("concentric, all through one circle");
        for (int i = 1; i < 6; ++i) disk(s, 0.25, 0.125, 1, i);
        s.plane(0, 0, 1);
    }
    {
        FormScene& s = scene("planes through one line");
        for (const double slope : {-1.0, -0.5, 0.0, 0.25, 1.0}) s.plane(slope, slope / 2, 5);
    }
    {
        FormScene& s = scene("planes through one line, met by spheres");
        for (const double slope : {-1.0, -0.5, 0.0, 0.25, 1.0}) s.plane(slope, 0, 2);
        s.sphere(0, 0.5, 1, 0.5);
        s.sphere(0, -1.25, 1.25, 0.25);
    }
    {
        FormScene& s = scene("planes through one point");
        for (const auto& [a, b] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, -1}})
            s.plane(a, b, 4);
    }
    {
        FormScene& s = scene("plane equal to another along the rim");
        s.plane(0, 0, 2);
        s.plane(1, 0, 0);   // 2 at x = 2, lower inside
        s.plane(-1, 0, 0);  // 2 at x = -2
    }
    {
        FormScene& s = scene("plane that touches along the rim only");
        s.plane(0, 0, 2);
        s.plane(-1, 0, 4);  // 2 at x = 2, higher inside
    }
    {
        FormScene& s = scene("centred on corners");
        for (const double x : {-2, 2})
            for (const double y : {-2, 2}) s.sphere(x, y, 1, 0.5);
    }
    {
        FormScene& s = scene("centred on corners, one in the middle");
        for (const double x : {-2, 2})
            for (const double y : {-2, 2}) s.sphere(x, y, 1, 0.5);
        s.sphere(0, 0, 1.5, 0.25);
    }
    {
        // 4 (|p - c|^2 + e) - 2 (|p|^2 + 2), of w = 2 against w = 4, has radius 0 about 2c for e = |c|^2 + 1.
        const auto touching = [](FormScene& s, double x, double y) {
            s.paraboloid(x / 2, y / 2, (x * x + y * y) / 4 + 1, 2);
        };
        const std::vector<std::pair<const char*, std::vector<std::array<double, 2>>>> places{
            {"inside", {{1, 0}, {-0.5, 1}}}, {"on the rim", {{2, 0.5}}}, {"in a corner", {{2, 2}}}};
        for (const auto& [where, points] : places) {
            FormScene& s = scene(std::string("paraboloids that touch in a point ") + where);
            s.paraboloid(0, 0, 2, 4);
            for (const auto& [x, y] : points) touching(s, x, y);
        }
    }
    {
        FormScene& s = scene("two that touch a third in the same point");
        s.paraboloid(0, 0, 2, 4);
        s.paraboloid(0.5, 0, 0.25 + 1, 2);
        s.plane(0.5, 0, 0.25);  // tangent plane at (1, 0)
        s.numbers.back().w = 1;
    }
    {
        FormScene& s = scene("tangent planes of a paraboloid");
        s.paraboloid(0, 0, 0.5, 1);
        s.plane(2, 0, -0.5);
        s.plane(0, 2, -0.5);
        s.plane(-2, -2, -1.5);
    }
    {
        FormScene& s = scene("a paraboloid touches an edge from above");
        s.sphere(-1, 0, 1, 0.25);
        s.sphere(1, 0, 1, 0.25);
        // At (0, 0) both are at (1 + 15/16) / 2.5 = 31/40 with slopes -+0.8; the third is flat there.
        s.paraboloid(0, 0, 31.0 / 64, 0.625);
    }
    return all;
}

}  // namespace vcell
