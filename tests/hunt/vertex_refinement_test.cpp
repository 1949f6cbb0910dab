// Vertices to more digits, against distances in 100 digits.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>

#include "../../core/errors.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../primitives/reference.hpp"
#include "families.hpp"
#include "test_support.hpp"

namespace vcell::vertex_refinement_test {
using namespace vcell::hunt;

namespace {

using RealPoint = std::array<Real, 3>;

Real middle(const Wide& side) { return Real(side.mid().lower()); }

Real dot(const Vec3& v, const RealPoint& p) { return v.x() * p[0] + v.y() * p[1] + v.z() * p[2]; }
Real norm(const Vec3& v) { return sqrt(dot(v, {v.x(), v.y(), v.z()})); }
RealPoint from(const Vec3& origin, RealPoint p) {
    for (int i = 0; i < 3; ++i) p[i] -= origin[i];
    return p;
}

// As distance() of reference.hpp, to 100 digits.
Real real_distance(const Object& object, const RealPoint& p) {
    if (const auto* s = std::get_if<Sphere>(&object)) {
        const RealPoint m = from(s->center, p);
        return sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]) - s->radius;
    }
    if (const auto* c = std::get_if<Cylinder>(&object)) {
        const RealPoint m = from(c->point, p);
        const Real along = dot(c->axis, m) / norm(c->axis);
        return sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2] - along * along) - c->radius;
    }
    if (const auto* s = std::get_if<HollowSphere>(&object))
        return -real_distance(Sphere{s->center, s->radius}, p);
    if (const auto* c = std::get_if<HollowCylinder>(&object))
        return -real_distance(Cylinder{c->point, c->axis, c->radius}, p);
    if (const auto* c = std::get_if<HollowCone>(&object)) {
        const Real sine = Real(c->radius) / c->slant, along = dot(c->axis, from(c->apex, p)) / norm(c->axis);
        return sine * along - sqrt(1 - sine * sine) * real_distance(Cylinder{c->apex, c->axis, 0}, p);
    }
    const auto& plane = std::get<Plane>(object);
    return abs(dot(plane.normal, from(plane.point, p))) / norm(plane.normal);
}

// How far the point is from what the site asks of a vertex of clearance r.
Real fault(const Scene& scene, Site site, const RealPoint& p, const Real& r) {
    if (site.is_object()) return abs(real_distance(scene.objects[site.index], p) - r);
    const auto beyond = [&](std::uint32_t side, const RealPoint& q) -> Real {
        return q[side / 2] - (side % 2 == 1 ? scene.box.max : scene.box.min)[side / 2];
    };
    if (site.kind == Site::Kind::BoxSide) {
        Real least = abs(beyond(site.index, p));
        if (const auto* base = std::get_if<Plane>(&scene.base)) {
            RealPoint foot = p;
            for (int i = 0; i < 3; ++i) foot[i] -= r * base->normal[i] / norm(base->normal);
            least = std::min(least, Real(abs(beyond(site.index, foot))));
        }
        return least;
    }
    // The circle around the axis through the point's foot on it reaches a side and crosses none.
    const auto& tube = std::get<Cylinder>(scene.base);
    const Real length = norm(tube.axis), along = dot(tube.axis, from(tube.point, p)) / length;
    Real farthest = -1e100;
    for (std::uint32_t side = 0; side < 6; ++side) {
        const int i = static_cast<int>(side / 2);
        const Real d = tube.axis[i] / length,
                   across = std::max(tube.radius, 0x1p-26 * scene.box.diagonal()) *
                            sqrt(std::max(Real(0), Real(1 - d * d))),
                   outwards = side % 2 == 1 ? 1 : -1;
        if (outwards * d * (site.index == 1 ? 1 : -1) <= 0) continue;
        RealPoint center;
        for (int k = 0; k < 3; ++k) center[k] = tube.point[k] + along * tube.axis[k] / length;
        farthest = std::max(farthest, Real(outwards * beyond(side, center) + across));
    }
    return abs(farthest);
}

struct Count {
    int refined = 0, left = 0;
};

// Where a wall meets a base plane the base is one of the three that fix the vertex, and no site.
bool is_on_wall(const Scene& scene, const CellVertex& vertex) {
    return std::holds_alternative<Plane>(scene.base) && vertex.radius == 0 &&
           std::ranges::any_of(vertex.sites, [&](const Site& site) {
               return site.is_object() && is_vessel(scene.objects[site.index]);
           });
}

void check(const Cell& cell, Count& count) {
    constexpr int bits = 240;
    const Real small = 16 * ldexp(Real(cell.scene.box.diagonal()), -bits);
    for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
        CAPTURE(v);
        const CellVertex& vertex = cell.vertices[v];
        const auto refined = refine(cell, v, bits);
        if (!refined) {
            count.left += !vertex.is_touching && !is_on_wall(cell.scene, vertex);
            continue;
        }
        ++count.refined;
        RealPoint p;
        for (int i = 0; i < 3; ++i) p[i] = middle(refined->box[i]);
        const Real r = middle(refined->box[3]);
        const RealPoint off = from(vertex.point, p);
        CHECK(off[0] * off[0] + off[1] * off[1] + off[2] * off[2] <=
              vertex.error * Real(vertex.error) + small);
        CHECK(abs(real_distance(cell.scene.base, p) - r) <= small);
        for (const Site& site : refined->sites) CHECK(fault(cell.scene, site, p, r) <= small);
        for (const Site& site : vertex.sites)
            CHECK(fault(cell.scene, site, p, r) <= refined->tie_width + small);
    }
}

}  // namespace

TEST_CASE("refine: vertices of every family over every base, to 240 bits") {
    std::mt19937_64 rng(test_seed());
    Count count;
    auto turn = rng() % 2;  // once round takes every other pair of a family and a base
    for (const Family& family : families()) {
        if (std::ranges::count(std::array{"twins", "contact", "nested"}, std::string(family.name))) continue;
        for (const BaseKind base : base_kinds) {
            if (rounds() == 1 && turn++ % 2 == 0) continue;
            const Scene scene = family.make(rng, base);
            if (!is_legal(scene)) continue;
            CAPTURE(std::string(family.name));
            CAPTURE(to_string(base));
            try {
                check(voronoi_cell(scene), count);
            } catch (const UndecidedError&) {
            }
        }
    }
    CHECK(count.refined > (rounds() == 1 ? 250 : 500));
    // Where no three sites are listed, and what the turn of a tilted base took apart.
    CHECK(count.left < count.refined / 25);
}

TEST_CASE("refine: vertices of caps are as far from the base as the probe says, to all digits") {
    // 0.1 + 0.7 is no double.
    Scene scene;
    scene.probe = 0.7;
    scene.objects = {Sphere{{1.1, 0.2, 0.3}, 0.1}, Cylinder{{-0.3, 0.6, 0.6}, {2, -1, 0}, 0.05},
                     Sphere{{0.1, -0.8, 1.2}, 0.2}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    const Object bases[] = {Sphere{{0, 0, 0}, 0.1}, Cylinder{{0, 0, 0}, {0, 0, 1}, 0.1},
                            Plane{{0, 0, -1.0 / 3}, {1, 2, 3}}, Plane{{0, 0, -0.1}, {0, 0, 1}}};
    for (const Object& base : bases) {
        scene.base = base;
        const Cell cell = voronoi_cell(scene);
        int of_cap = 0;
        for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
            const auto& sites = cell.vertices[v].sites;
            if (std::ranges::find(sites, Site::cap()) == sites.end()) continue;
            const auto refined = refine(cell, v, 240);
            if (!refined) continue;
            ++of_cap;
            CHECK(abs(middle(refined->box[3]) - Real(0.7)) < 1e-60);
        }
        CHECK(of_cap >= 2);
    }
}

TEST_CASE("refine: digits that are known, and ties") {
    // Equally far from the origin and three points.
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0};
    scene.objects = {Sphere{{3, 0, 0}, 0}, Sphere{{0, 3, 0}, 0}, Sphere{{0, 0, 3}, 0}, Sphere{{1, 1, -3}, 0}};
    scene.box = {Vec3::Constant(-5), Vec3::Constant(5)};
    const Cell cell = voronoi_cell(scene);
    const auto at = std::ranges::find_if(cell.vertices, [](const CellVertex& v) {
        return v.sites.size() == 3 && v.sites[0] == Site::object(0) && v.sites[1] == Site::object(1) &&
               v.sites[2] == Site::object(2);
    });
    REQUIRE(at != cell.vertices.end());
    const auto v = static_cast<std::size_t>(at - cell.vertices.begin());
    const auto refined = refine(cell, v, 250);
    REQUIRE(refined);
    for (int i = 0; i < 3; ++i) CHECK(refined->box[i].contains(1.5));
    // r^2 = 27 / 4.
    CHECK(abs(middle(square(refined->box[3])) - Real(6.75)) < 1e-70);
    CHECK(refined->tie_width == 0);

    SUBCASE("a vertex that is not within its error") {
        Cell moved = cell;
        moved.vertices[v].point.x() += 1e-3;
        CHECK(!refine(moved, v, 100));
        moved.vertices[v].error = 2e-3;
        CHECK(refine(moved, v, 100));
    }
    SUBCASE("sites that do not meet there") {
        Cell other = cell;
        other.vertices[v].sites[0] = Site::object(3);
        CHECK(!refine(other, v, 100));
    }
    SUBCASE("four sites that tie but for a rounding") {
        scene.objects[3] = Sphere{{3, 3, 3}, 0};
        const Cell tied = voronoi_cell(scene);
        scene.objects[3] = Sphere{{3, 3, std::nextafter(3.0, 4.0)}, 0};
        for (std::size_t k = 0; k < tied.vertices.size(); ++k) {
            if (tied.vertices[k].sites.size() < 4) continue;
            CHECK(refine(tied, k, 250)->tie_width < 1e-70);
            Cell blurred = tied;
            blurred.scene = scene;
            const auto all_but = refine(blurred, k, 250);
            REQUIRE(all_but);
            CHECK(all_but->tie_width > 1e-17);
            CHECK(all_but->tie_width < 1e-15);
        }
    }
}

}  // namespace vcell::vertex_refinement_test
