/// Lower bounds of excesses over a net by tangents, and the side of a plane that a base is on, by brute
/// force.
#include "../../io/check/tangents.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "../../io/check/containment.hpp"
#include "../../io/check/excess.hpp"
#include "../../io/check/middle_planes.hpp"
#include "../test_support.hpp"

namespace vcell::check {

namespace {

class TangentScenes {
public:
    double at(double most = 1) { return std::uniform_real_distribution<>(-most, most)(rng_); }
    Vec3 point(double most = 1) { return {at(most), at(most), at(most)}; }
    Object object(int kind) {
        const Vec3 p = point(2), d = point().normalized();
        if (kind == 0) return Plane{p, d};
        if (kind == 1) return Sphere{p, 0.5 * std::abs(at())};
        return Cylinder{p, d, 0.5 * std::abs(at())};
    }
    Scene scene(int base, int object) {
        Scene s;
        s.base = this->object(base);
        s.objects = {this->object(object)};
        s.box = {Vec3::Constant(-2), Vec3::Constant(2)};
        return s;
    }

private:
    std::mt19937_64 rng_{test_seed()};
};

double distance_in_doubles(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object))
        return plane->normal.normalized().dot(p - plane->point);
    if (const auto* ball = std::get_if<Sphere>(&object)) return (p - ball->center).norm() - ball->radius;
    const auto& tube = std::get<Cylinder>(object);
    return (p - tube.point).cross(tube.axis.normalized()).norm() - tube.radius;
}

double excess_in_doubles(const Scene& s, const Vec3& p) {
    const double d = distance_in_doubles(s.objects[0], p);
    return (std::holds_alternative<Plane>(s.objects[0]) ? std::abs(d) : d) - distance_in_doubles(s.base, p);
}

// Of degree (2, 1), about a point.
RationalPatch random_patch(TangentScenes& r, double size) {
    RationalPatch patch;
    patch.degree_u = 2;
    patch.degree_v = 1;
    patch.domain_u = patch.domain_v = {0, 1};
    const Vec3 middle = r.point(2);
    for (int i = 0; i < 6; ++i) {
        const Vec3 p = middle + r.point(size);
        patch.points.push_back({p.x(), p.y(), p.z(), 1.5 + r.at()});
    }
    return patch;
}

}  // namespace

TEST_CASE("tangents: no place of a net has a lesser excess, and one of a small net has little more") {
    TangentScenes r;
    int told = 0;
    for (int round = 0; round < 2000; ++round) {
        const Scene scene = r.scene(round % 3, round / 3 % 3);
        const Space<Interval> space(scene);
        const double size = round % 2 == 0 ? 1 : 1e-3;
        const RationalPatch patch = random_patch(r, size);
        const Net net(patch, patch.points[0].head<3>());
        const double bound = least_by_tangents(space, {Site::object(0)}, net);
        double least = HUGE_VAL, nearest = HUGE_VAL;
        for (int k = 0; k < 40; ++k) {
            const Vec3 p = evaluate(patch, k % 5 * 0.25, k / 5 / 7.0).p;
            least = std::min(least, excess_in_doubles(scene, p));
            for (const Object& o : {scene.base, scene.objects[0]}) {
                const auto* ball = std::get_if<Sphere>(&o);
                const auto* tube = std::get_if<Cylinder>(&o);
                const double radius = ball ? ball->radius : tube ? tube->radius : 1;
                nearest = std::min(nearest, std::abs(distance_in_doubles(o, p) + radius));
            }
        }
        CHECK(bound <= least + 1e-12);
        // A plane's distance is signed where it has the base on one side.
        if (size == 1 || nearest < 0.1 || space.is_sided(0)) continue;
        ++told;
        CHECK(bound >= least - 4 * size);
    }
    CHECK(told > 200);
}

TEST_CASE("tangents: what touches a plane all along a line is told at once") {
    for (const double slope : {0.0, 1.0, 0.3}) {
        CAPTURE(slope);
        Scene scene;
        scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
        scene.objects = {Cylinder{Vec3(0.1, 0.2, 0.75), Vec3(1, slope, 0), 0.25},
                         Sphere{Vec3(0.3, 0.1, 0.75), 0.25}, Cylinder{Vec3(0, 0, 0.5), Vec3(1, slope, 0), 0}};
        scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
        const Space<Interval> space(scene);
        RationalPatch patch;
        patch.degree_u = patch.degree_v = 1;
        patch.domain_u = patch.domain_v = {0, 1};
        constexpr double height = 0.2;
        for (const double x : {-2.0, 2.0})
            for (const double y : {-2.0, 2.0}) patch.points.push_back({x, y, height, 1});
        const Net net(patch, Vec3::Zero());
        for (const std::uint32_t i : {0u, 1u, 2u}) {
            CAPTURE(i);
            const double bound = least_by_tangents(space, {Site::object(i)}, net);
            CHECK(bound <= 0.5 - 2 * height);
            CHECK(bound >= 0.5 - 2 * height - 1e-14);
        }
        // A side of the box that the net ends at.
        CHECK(std::abs(least_by_tangents(space, {Site::box_side(0)}, net)) < 1e-14);
    }
}

TEST_CASE("sides of planes: a plane that cuts the base far from the box has it on one side") {
    Scene scene;
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    const auto side = [&](double height, double rise) {
        return side_of_base(Plane{Vec3(0, 0, height), Vec3(-rise, 0, 1)}, scene);
    };
    scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
    CHECK(side(1, 0) == Sign::Negative);
    CHECK(side(1, 0.01) == Sign::Negative);
    CHECK(side(-1, 0.01) == Sign::Positive);
    CHECK(side(1, 0.2) == Sign::Negative);
    CHECK(side(1, 0.5) == Sign::Zero);
    CHECK(side(0x1p-40, 0x1p-50) == Sign::Negative);
    scene.base = Cylinder{Vec3::Zero(), Vec3::UnitX(), 0.5};
    CHECK(side(1, 0) == Sign::Negative);
    CHECK(side(1, 0.1) == Sign::Negative);
    CHECK(side(1, 0.25) == Sign::Zero);
    CHECK(side(0.5, 0.01) == Sign::Zero);
    CHECK(side(-0.5 - 0x1p-40, 0x1p-50) == Sign::Positive);
}

TEST_CASE("sides of planes: where a plane is no nearer than the base the signed distance is its own") {
    TangentScenes r;
    int told = 0;
    for (int round = 0; round < 3000; ++round) {
        Scene scene = r.scene(round % 2 == 0 ? 0 : 2, 0);
        auto& plane = std::get<Plane>(scene.objects[0]);
        // Next to parallel ones.
        const Vec3 about = round % 2 == 0 ? std::get<Plane>(scene.base).normal
                                          : std::get<Cylinder>(scene.base).axis.unitOrthogonal();
        plane.normal = about + r.point(round % 4 < 2 ? 0.2 : 1e-3);
        const Sign side = side_of_base(plane, scene);
        if (side == Sign::Zero) continue;
        for (int k = 0; k < 20; ++k) {
            const Vec3 p = r.point(2);
            const double clearance = distance_in_doubles(scene.base, p), d = distance_in_doubles(plane, p);
            if (clearance < 0 || std::abs(d) < clearance) continue;
            ++told;
            CHECK((d > 0) == (side == Sign::Positive));
        }
    }
    CHECK(told > 1000);
}

TEST_CASE("twins of the base: excess and gradient are known to a part of how far apart they are") {
    TangentScenes r;
    int near = 0;
    for (int round = 0; round < 800; ++round) {
        CAPTURE(round);
        const double apart = std::pow(10, -3 * (1 + round / 2 % 4));
        Scene scene = r.scene(1 + round % 2, 0);
        scene.objects = {scene.base};
        if (auto* ball = std::get_if<Sphere>(&scene.objects[0])) {
            ball->center += apart * r.point();
            if (round % 16 < 8) ball->radius += apart * 0.5;
        } else {
            auto& tube = std::get<Cylinder>(scene.objects[0]);
            tube.point += apart * r.point();
            tube.axis += apart * r.point();
            if (round % 16 < 8) tube.axis *= -1;
        }
        const Space<Interval> space(scene);
        const Space<Wide> wide(scene);
        CHECK(space.is_twin_of_base(0));
        const Condition c{Site::object(0)};
        const Vec3 p = r.point(2), q = p + 1e-3 * r.point();
        const Interval e = space.excess(c, to_vector<Interval>(p));
        const Interval sharp = wide.excess(c, to_vector<Wide>(p)).enclosure();
        CHECK(e.lower() <= sharp.upper());
        CHECK(e.upper() >= sharp.lower());
        const Vector<Interval> g = space.gradient(c, to_vector<Interval>(p));
        const Vector<Wide> h = wide.gradient(c, to_vector<Wide>(p));
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(g[k].lower() <= h[k].enclosure().upper());
            CHECK(g[k].upper() >= h[k].enclosure().lower());
        }
        const auto radius = [&](const Object& o) {
            const auto* ball = std::get_if<Sphere>(&o);
            return ball ? ball->radius : std::get<Cylinder>(o).radius;
        };
        Net net(1, 0, p);
        for (std::size_t k = 0; k < 3; ++k) {
            net.at(0, 0)[k] = 0.0;
            net.at(1, 0)[k] = q[static_cast<Eigen::Index>(k)] - p[static_cast<Eigen::Index>(k)];
        }
        net.at(0, 0)[3] = net.at(1, 0)[3] = 1.0;
        const Interval along = ExcessAlong(space, net).excess(c);
        CHECK(along.lower() <= e.upper());
        CHECK(along.upper() >= e.lower());
        if (distance_in_doubles(scene.base, p) + radius(scene.base) < 0.1) continue;
        ++near;
        CHECK(e.radius() <= 1e-12 * apart);
        for (const Interval& x : g) CHECK(x.radius() <= 1e-11 * apart);
        CHECK(along.radius() <= 0.2 * apart);
    }
    CHECK(near > 400);
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.5};
    scene.objects = {Sphere{Vec3(0.5, 0, 0), 0.5}, Cylinder{Vec3::Zero(), Vec3::UnitX(), 0.5}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    const Space<Interval> space(scene);
    CHECK(!space.is_twin_of_base(0));
    CHECK(!space.is_twin_of_base(1));
}

TEST_CASE("middle planes: tubes whose axes cross are equally near in them, and others have none") {
    TangentScenes r;
    std::mt19937 rng(static_cast<unsigned>(test_seed()));
    std::uniform_int_distribution<int> whole(-3, 3);
    const auto integers = [&] { return Vec3(whole(rng), whole(rng), whole(rng)); };
    int crossing = 0;
    for (int round = 0; round < 400; ++round) {
        const Vec3 c = integers(), a = integers(), b = integers();
        if (a.isZero() || b.isZero()) continue;
        const Cylinder first{c + whole(rng) * a, a, 0.25}, second{c + whole(rng) * b, b, 0.25};
        const auto planes = middle_planes(first, second);
        CHECK(planes.has_value() == !a.cross(b).isZero());
        CHECK(!middle_planes(first, Cylinder{second.point, b, 0.5}));
        if (!planes) continue;
        ++crossing;
        const Vec3 off = second.point + 1e-14 * a.cross(b);
        CHECK(middle_planes(first, Cylinder{off, b, 0.25}).has_value() == (off == second.point));
        const Vec3 p = r.point(4);
        const double difference = std::pow(distance_in_doubles(first, p) + 0.25, 2) -
                                  std::pow(distance_in_doubles(second, p) + 0.25, 2);
        double product = 1;
        for (const MiddlePlane& plane : *planes) {
            Net net(0, 0, p);
            for (std::size_t k = 0; k < 3; ++k) net.at(0, 0)[k] = 0.0;
            net.at(0, 0)[3] = 1.0;
            const Interval at = plane.over(net);
            CHECK(at.radius() < 1e-12);
            product *= at.mid();
        }
        CHECK(std::abs(product - difference) < 1e-11);
    }
    CHECK(crossing > 200);
}

}  // namespace vcell::check
