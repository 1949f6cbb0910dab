/// Scenes with cylinders for the envelope's tests: random families and degenerate ones.
#pragma once

#include <numbers>

#include "mixed_oracle.hpp"

namespace vcell::mixed {

inline double dyadic(double x, int bits = 20) { return std::ldexp(std::round(std::ldexp(x, bits)), -bits); }

/// The distance of a cylinder from the square |x|, |y| <= half of the base; negative where its axis meets the
/// square. It is convex: attained on the boundary unless the axis is parallel to the base, and then close to
/// it at least.
inline double gap(const CylinderForm& c, double half) {
    if (c.az != 0) {
        const double t = -c.pz / c.az;
        if (std::max(std::abs(c.px + t * c.ax), std::abs(c.py + t * c.ay)) <= half) return -c.rho;
    }
    double least = std::abs(c.az) < 1e-6 ? c.pz - c.rho - 1e-6 * half : HUGE_VAL;
    for (int i = 0; i <= 256; ++i) {
        const double s = half * (i / 128.0 - 1);
        for (const auto& [x, y] : {std::pair{s, -half}, {s, half}, {-half, s}, {half, s}})
            least = std::min(least, distance<double>(c, x, y, 0.0).value - half / 128);
    }
    return least;
}

/// Random solids over the square |x|, |y| <= half.
class RandomScenes {
public:
    explicit RandomScenes(std::mt19937_64& rng, double half = 2) : rng_(rng), half_(half) {}

    double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(rng_); }

    Scene start(const std::string& name) const {
        Scene s{.name = name, .circular = {}, .cylinders = {}};
        s.region = ConvexRegion::rectangle(-half_, -half_, half_, half_);
        return s;
    }
    void add_ball(Scene& s, double most_rho = 0.3) {
        const double rho = uniform(0, 1) < 0.15 ? 0 : uniform(0, most_rho);
        s.ball(uniform(-half_, half_), uniform(-half_, half_), rho + 0.1 + uniform(0, 1.5), rho);
    }
    void add_wall(Scene& s) {
        const double a = uniform(-0.4, 0.4), b = uniform(-0.4, 0.4);
        s.wall(a, b, uniform(0.5, 1.5) + half_ * (std::abs(a) + std::abs(b)), uniform(1, 2));
    }
    /// Of slope |az| to the base up to `slope`, low over the region.
    void add_flat_cylinder(Scene& s, double slope, double most_rho = 0.3) {
        for (;;) {
            const double angle = uniform(0, 2 * std::numbers::pi),
                         rho = uniform(0, 1) < 0.15 ? 0 : uniform(0, most_rho);
            const CylinderForm c{uniform(-half_, half_),
                                 uniform(-half_, half_),
                                 rho + 0.1 + uniform(0, 1.5),
                                 std::cos(angle),
                                 std::sin(angle),
                                 uniform(-slope, slope),
                                 rho};
            if (gap(c, half_) < 0.05) continue;
            s.cylinders.push_back(c);
            return;
        }
    }
    /// Whose axis meets the base outside of the region.
    void add_steep_cylinder(Scene& s) {
        for (;;) {
            const double angle = uniform(0, 2 * std::numbers::pi), rho = uniform(0, 0.5),
                         out = half_ * uniform(1.2, 2.5);
            const CylinderForm c{out * std::cos(angle), out * std::sin(angle), 0,  uniform(-1, 1),
                                 uniform(-1, 1),        uniform(0.3, 2),       rho};
            if (gap(c, half_) < 0.02) continue;
            s.cylinders.push_back(c);
            return;
        }
    }
    Scene mix(const std::string& name, int balls, int walls, int flat, int steep, double slope = 0.3) {
        Scene s = start(name);
        for (int i = 0; i < balls; ++i) add_ball(s);
        for (int i = 0; i < walls; ++i) add_wall(s);
        for (int i = 0; i < flat; ++i) add_flat_cylinder(s, slope);
        for (int i = 0; i < steep; ++i) add_steep_cylinder(s);
        return s;
    }

private:
    std::mt19937_64& rng_;
    double half_;
};

/// A convex polygon of n sides about the origin, none axis-parallel.
inline ConvexRegion polygon(int n, double radius, double turn) {
    ConvexRegion r;
    for (int i = 0; i < n; ++i) {
        const double angle = turn + 2 * std::numbers::pi * i / n;
        r.sides.push_back({-std::cos(angle), -std::sin(angle), radius * (1 + 0.1 * (i % 3))});
    }
    return r;
}

// --- Random families, not degenerate -----------------------------------------------------------------

/// One scene of each family.
inline std::vector<Scene> random_scenes(std::mt19937_64& rng) {
    RandomScenes random(rng);
    const auto count = [&](int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(rng); };
    std::vector<Scene> all;
    all.push_back(random.mix("mix", count(0, 6), count(0, 2), count(1, 5), count(0, 2)));
    all.push_back(random.mix("flat cylinders only", 0, 0, count(1, 8), 0));
    all.push_back(random.mix("steep cylinders only", 0, 0, 0, count(1, 6)));
    all.push_back(random.mix("horizontal", count(0, 3), 0, count(2, 5), 0, 0.0));
    all.push_back(random.mix("nearly horizontal, 1e-9", count(0, 3), 0, count(2, 5), 0, 1e-9));
    all.push_back(random.mix("nearly horizontal, 1e-100", count(0, 3), 0, count(2, 5), 0, 1e-100));
    all.push_back(random.mix("cylinders and planes", 0, count(1, 3), count(1, 4), count(0, 1)));
    {
        Scene s = random.mix("parallel", count(0, 2), 0, 1, 0);
        for (int i = 0; i < 4; ++i) {
            random.add_flat_cylinder(s, 0);
            s.cylinders.back().ax = s.cylinders.front().ax;
            s.cylinders.back().ay = s.cylinders.front().ay;
            s.cylinders.back().az = s.cylinders.front().az;
            if (gap(s.cylinders.back(), 2) < 0.05) s.cylinders.pop_back();
        }
        all.push_back(s);
    }
    {
        Scene s = random.mix("coincident directions, axes of other length", count(0, 2), 0, 3, 0, 0.0);
        for (std::size_t i = 1; i < s.cylinders.size(); ++i) {
            s.cylinders[i].ax = s.cylinders[0].ax * std::ldexp(1.0, static_cast<int>(i));
            s.cylinders[i].ay = s.cylinders[0].ay * std::ldexp(1.0, static_cast<int>(i));
        }
        all.push_back(s);
    }
    {
        Scene s = random.start("lines and points");
        for (int i = count(1, 5); i > 0; --i) random.add_ball(s, 0);
        for (int i = count(2, 5); i > 0; --i) random.add_flat_cylinder(s, 0.3, 0);
        all.push_back(s);
    }
    {
        Scene s = random.start("heavy-tailed radii");
        for (int i = count(2, 8); i > 0; --i) {
            const double rho = 0.01 * std::pow(1e-4 + random.uniform(0, 1), -0.8);
            s.ball(random.uniform(-3, 3), random.uniform(-3, 3), rho * (1 + random.uniform(0, 1)) + 0.02,
                   rho);
        }
        for (int i = count(1, 4); i > 0; --i) {
            const double rho = 0.01 * std::pow(1e-4 + random.uniform(0, 1), -0.8),
                         angle = random.uniform(0, 7);
            s.cylinder(random.uniform(-2, 2), random.uniform(-2, 2), rho * (1 + random.uniform(0, 1)) + 0.05,
                       std::cos(angle), std::sin(angle), 0, rho);
        }
        all.push_back(s);
    }
    {
        Scene s = random.mix("crossing axes, unequal radii", count(0, 2), 0, 0, 0);
        const double h = random.uniform(0.8, 1.2);
        for (int i = count(2, 3); i > 0; --i) {
            const double angle = random.uniform(0, 7);
            s.cylinder(0.125, -0.25, h, std::cos(angle), std::sin(angle), 0, random.uniform(0.05, 0.5));
        }
        all.push_back(s);
    }
    for (const int n : {3, 5, 6}) {
        Scene s =
            random.mix("oblique region, " + std::to_string(n) + " sides", count(1, 4), 1, count(1, 3), 0);
        s.region = polygon(n, 0.9, random.uniform(0, 1));
        all.push_back(s);
    }
    {
        // A small ball between the base and a low horizontal cylinder, or under a plane beside one.
        Scene s = random.mix("islands", 0, count(0, 1), count(1, 2), 0, 0.0);
        for (int i = count(1, 4); i > 0; --i)
            s.ball(random.uniform(-1.8, 1.8), random.uniform(-1.8, 1.8), 0.05, 0.02);
        all.push_back(s);
    }
    return all;
}

/// The scene `factor` times as large, `dx` and `dy` away; exact if these are powers of two and short.
inline Scene moved(Scene s, double factor, double dx, double dy) {
    for (Solid& solid : s.circular)
        if (Ball* b = std::get_if<Ball>(&solid)) {
            *b = {b->x * factor + dx, b->y * factor + dy, b->z * factor, b->rho * factor};
        } else {
            Wall& w = std::get<Wall>(solid);
            w.e = w.e * factor - (w.a * dx + w.b * dy);
        }
    for (CylinderForm& c : s.cylinders) {
        c.px = c.px * factor + dx;
        c.py = c.py * factor + dy;
        c.pz *= factor;
        c.rho *= factor;
    }
    for (auto& side : s.region.sides) side.c = side.c * factor - (side.a * dx + side.b * dy);
    return s;
}

// --- Degenerate scenes --------------------------------------------------------------------------------

/// Equal cylinders of a regulus of lines about the z axis: all are as near above the centre.
inline Scene regulus(const std::string& name, const std::vector<std::array<double, 2>>& directions,
                     double out, double az, double rho) {
    Scene s{.name = name, .circular = {}, .cylinders = {}};
    for (const auto& [x, y] : directions) s.cylinder(out * x, out * y, 1, -y, x, az, rho);
    return s;
}

inline const std::vector<std::array<double, 2>> four_ways{{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

inline const std::vector<std::array<double, 2>> eight_ways{{1, 0}, {0, 1}, {1, 1},  {1, -1},
                                                           {1, 2}, {2, 1}, {-1, 2}, {2, -1}};

inline std::vector<Scene> degenerate_scenes() {
    std::vector<Scene> all;
    const auto scene = [&](const std::string& name) -> Scene& {
        return all.emplace_back(Scene{.name = name, .circular = {}, .cylinders = {}});
    };

    all.push_back(regulus("four cylinders on a regulus", four_ways, 0.5, 0.25, 0.25));
    all.push_back(regulus("four lines on a regulus", four_ways, 0.5, 0.25, 0));
    all.push_back(regulus("four cylinders around the centre", four_ways, 1, 0, 0.25));
    // Unit vectors along (3, 4) and (4, 3) need no rounding up to their common length.
    all.push_back(regulus("eight cylinders around the centre",
                          {{5, 0}, {4, 3}, {3, 4}, {0, 5}, {-3, 4}, {-5, 0}, {-4, -3}, {0, -5}}, 0.125, 0,
                          0.25));
    scene("two equal cylinders that cross").cylinder(0, 0, 1, 1, 0, 0, 0.25).cylinder(0, 0, 1, 0, 1, 0, 0.25);
    scene("two equal cylinders that cross off the middle")
        .cylinder(0.25, -0.5, 1, 1, 0, 0, 0.25)
        .cylinder(0.25, -0.5, 1, 1, 2, 0, 0.25);
    scene("three equal cylinders through one point")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 1, 0, 1, 0, 0.25)
        .cylinder(0, 0, 1, 1, 1, 0, 0.25);
    {
        Scene& s = scene("eight equal cylinders through one point");
        for (const auto& [x, y] : eight_ways) s.cylinder(0.125, 0.25, 1, x, y, 0, 0.25);
    }
    scene("three equal tilted cylinders through one point")
        .cylinder(0.125, 0.25, 1, 1, 0.25, 0.125, 0.25)
        .cylinder(0.125, 0.25, 1, -0.25, 1, 0.125, 0.25)
        .cylinder(0.125, 0.25, 1, 0.75, 1.25, 0.25, 0.25);
    scene("a larger ball in the node of two cylinders")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 1, 0, 1, 0, 0.25)
        .ball(0, 0, 1.25, 0.5);
    scene("a smaller ball in the node of two cylinders")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 1, 0, 1, 0, 0.25)
        .ball(0, 0, 0.875, 0.125);
    scene("a plane through the node of two cylinders")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 1, 0, 1, 0, 0.25)
        .wall(0.5, 0, 0.375);
    scene("a ball in a cylinder, touching its bottom")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .ball(0, 0, 0.875, 0.125);
    scene("three equal cylinders cross over the rim")
        .cylinder(2, 0.5, 1, 1, 0, 0, 0.25)
        .cylinder(2, 0.5, 1, 0, 1, 0, 0.25)
        .cylinder(2, 0.5, 1, 1, 1, 0, 0.25);
    scene("three equal cylinders cross over a corner")
        .cylinder(2, 2, 1, 1, 0, 0, 0.25)
        .cylinder(2, 2, 1, 0, 1, 0, 0.25)
        .cylinder(2, 2, 1, 1, 1, 0, 0.25);
    scene("equal cylinders cross over an oblique rim")
        .cylinder(0.5, 0.5, 1, 1, 0, 0, 0.25)
        .cylinder(0.5, 0.5, 1, 1, 2, 0, 0.25)
        .region.sides = {{0, 1, 1}, {-1, -1, 1}, {1, 0, 1}};
    scene("a trisector touches the rim from inside")
        .cylinder(4, 0, 0.75, 0, 1, 0, 0.25)
        .ball(0, 0, 3.75, 0.25);
    scene("a trisector touches the rim from outside")
        .cylinder(0, 0, 0.75, 0, 1, 0, 0.25)
        .ball(4, 0, 3.75, 0.25);
    scene("a grid of four equal cylinders")
        .cylinder(0, 0.5, 1, 1, 0, 0, 0.25)
        .cylinder(0, -0.5, 1, 1, 0, 0, 0.25)
        .cylinder(0.5, 0, 1, 0, 1, 0, 0.25)
        .cylinder(-0.5, 0, 1, 0, 1, 0, 0.25);
    scene("equal cylinders cross over the rim")
        .cylinder(2, 0.5, 1, 1, 0.5, 0, 0.25)
        .cylinder(2, 0.5, 1, -0.25, 1, 0, 0.25);
    scene("equal cylinders cross over a corner")
        .cylinder(2, 2, 1, 1, 0, 0, 0.25)
        .cylinder(2, 2, 1, 0, 1, 0, 0.25);
    scene("crossing axes, unequal radii").cylinder(0, 0, 1, 1, 0, 0, 0.25).cylinder(0, 0, 1, 0, 1, 0, 0.125);
    scene("equal radii, one above the other")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 1.5, 0, 1, 0, 0.25);
    scene("tangent cylinders beside each other")
        .cylinder(0, 0.25, 1, 1, 0, 0, 0.25)
        .cylinder(0, -0.25, 1, 1, 0, 0, 0.25);
    scene("tangent cylinders across each other")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 1.5, 0, 1, 0, 0.25)
        .ball(1, 1, 1, 0.25);
    scene("a ball tangent to a cylinder").cylinder(0, 0, 1, 1, 0, 0, 0.25).ball(0, 0.5, 1, 0.25);
    scene("a trisector through a corner").cylinder(1, 2, 1, 0, 1, 0, 0.25).cylinder(2, 1, 1, 1, 0, 0, 0.25);
    scene("a vertex on the rim")
        .cylinder(2, -1, 1, 1, 0, 0, 0.25)
        .cylinder(2, 1, 1, 1, 0, 0, 0.25)
        .ball(1, 0, 1, 0.25);
    {
        Scene& s = scene("a lattice of balls under a cylinder far off");
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) s.ball(i - 1.5, j - 1.5, 1, 0.25);
        s.cylinder(0, 3, 1, 1, 0, 0, 0.25);
    }
    scene("a closed loop between a ball and a low cylinder")
        .cylinder(0, 0, 0.5, 1, 0, 0, 0.25)
        .ball(0.25, 0, 0.125, 0.0625);
    scene("a closed loop around the middle of a plane's face")
        .cylinder(0, 1.5, 0.75, 1, 0, 0, 0.25)
        .wall(0, 0, 1)
        .ball(-0.5, -0.75, 0.25, 0.125);
    scene("a cylinder and its mirror image's ball on the bisector")
        .cylinder(0, 1, 1, 1, 0, 0, 0.25)
        .cylinder(0, -1, 1, 1, 0, 0, 0.25)
        .ball(1, 0, 1, 0.25)
        .ball(-1, 0, 1, 0.25);
    scene("bottoms of unequal cylinders touch")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .cylinder(0, 0, 0.875, 0, 1, 0, 0.125);
    scene("the bottom of a larger ball touches a cylinder's")
        .cylinder(0, 0, 1, 1, 0, 0, 0.25)
        .ball(0, 0, 1.25, 0.5);
    scene("a point touches the trisector of two lines")
        .cylinder(0.125, 1, 1, 1, 0, 0, 0)
        .cylinder(0.125, -1, 1, 1, 0, 0, 0)
        .ball(0.125, 0, 2, 0);
    scene("a line touches the trisector of two others")
        .cylinder(1, 0.25, 1, 0, 1, 0, 0)
        .cylinder(-1, 0.25, 1, 0, 1, 0, 0)
        .cylinder(0, 0.25, 2, 1, 0, 0, 0);
    scene("a ball hides where a point touches the trisector of two lines")
        .cylinder(0.125, 1, 1, 1, 0, 0, 0)
        .cylinder(0.125, -1, 1, 1, 0, 0, 0)
        .ball(0.125, 0, 2, 0)
        .ball(0.15625, 0, 0.9375, 0.03125);
    scene("two points touch the trisector of two lines, where rounded")
        .cylinder(1.1, 0, 1, 0, 1, 0, 0)
        .cylinder(-0.9, 0, 1, 0, 1, 0, 0)
        .ball(0.1, 0.3, 2, 0)
        .ball(0.1, -0.7, 2, 0);
    return all;
}

}  // namespace vcell::mixed
