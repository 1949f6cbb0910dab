// Objects behind mirrors of a base tube, against distances in random points.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "../../primitives/bases/mirror_ties.hpp"
#include "../test_support.hpp"
#include "reference.hpp"

using namespace vcell;

namespace {

std::vector<const Object*> pointers(const std::vector<Object>& objects) {
    std::vector<const Object*> list;
    for (const Object& o : objects) list.push_back(&o);
    return list;
}

// Small integers, so that images are frequent.
std::vector<Object> random_objects(std::mt19937_64& rng, int count) {
    std::uniform_int_distribution<int> place(-2, 2), kind(0, 3), radius(1, 2);
    std::vector<Object> objects;
    for (int i = 0; i < count; ++i) {
        const Vec3 p(place(rng), place(rng), place(rng));
        switch (kind(rng)) {
            case 0: objects.emplace_back(Sphere{p, 0.25 * radius(rng)}); break;
            case 1: objects.emplace_back(Cylinder{p, {0, 2, 0}, 0.25}); break;
            case 2: objects.emplace_back(Cylinder{p, {1, 0, 0}, 0.25 * radius(rng)}); break;
            default: objects.emplace_back(Cylinder{p, {place(rng) + 0.5, 1, 0}, 0.25});
        }
    }
    return objects;
}

}  // namespace

TEST_CASE("mirror ties: what is hidden is nowhere nearer than both others, and as near where these tie") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-4, 4);
    const Cylinder base{{0, 0, 0}, {0, 1, 0}, 0.25};
    std::size_t found = 0, with_balls = 0;
    for (int round = 0; round < 400 * rounds(); ++round) {
        const std::vector<Object> objects = random_objects(rng, 14);
        for (const MirrorTie& tie : find_mirror_ties(base, pointers(objects), 0)) {
            ++found;
            with_balls += std::holds_alternative<Sphere>(objects[tie.hidden]);
            CHECK(tie.off == 0);
            const Object &hidden = objects[tie.hidden], &mirrored = objects[tie.mirrored],
                         &mirror = objects[tie.mirror];
            const Vec3 w = std::get<Cylinder>(mirror).point.cwiseProduct(Vec3(1, 0, 1));
            for (int k = 0; k < 20; ++k) {
                const Vec3 p(unit(rng), unit(rng), unit(rng));
                const double d = distance(base, p);
                if (d <= distance(mirror, p)) CHECK(distance(hidden, p) >= distance(mirrored, p) - 1e-12);
                const Vec3 on_mirror = p - (w.dot(p) / w.squaredNorm() - 0.5) * w;
                CHECK(std::abs(distance(hidden, on_mirror) - distance(mirrored, on_mirror)) < 1e-12);
                CHECK(std::abs(distance(base, on_mirror) - distance(mirror, on_mirror)) < 1e-12);
            }
        }
    }
    CHECK(found > 50);
    CHECK(with_balls > 5);
}

TEST_CASE("mirror ties: all triples are found that a search of all finds, in any order") {
    std::mt19937_64 rng(test_seed());
    const Cylinder base{{0, 0, 0}, {0, 1, 0}, 0.25};
    const auto image = [](const Vec3& p, const Vec3& w) -> Vec3 {
        return p - 2 * (w.dot(p) / w.squaredNorm() - 0.5) * w;
    };
    for (int round = 0; round < 20 * rounds(); ++round) {
        const std::vector<Object> objects = random_objects(rng, 10);
        std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> expected, ties;
        for (const MirrorTie& tie : find_mirror_ties(base, pointers(objects), 0))
            ties.emplace(tie.hidden, tie.mirrored, tie.mirror);
        for (std::uint32_t t = 0; t < objects.size(); ++t) {
            const auto* mirror = std::get_if<Cylinder>(&objects[t]);
            if (mirror == nullptr || mirror->axis.x() != 0 || mirror->axis.z() != 0) continue;
            const Vec3 w = mirror->point.cwiseProduct(Vec3(1, 0, 1));
            if (w.isZero(0)) continue;
            for (std::uint32_t y = 0; y < objects.size(); ++y)
                for (std::uint32_t x = 0; x < objects.size(); ++x) {
                    if (x == y || x == t || y == t) continue;
                    if (const auto* a = std::get_if<Sphere>(&objects[y]),
                        *b = std::get_if<Sphere>(&objects[x]);
                        a && b) {
                        if (a->radius == b->radius && 2 * w.dot(a->center) < w.squaredNorm() &&
                            (image(a->center, w) - b->center).isZero(1e-12))
                            expected.emplace(x, y, t);
                    } else if (const auto* c = std::get_if<Cylinder>(&objects[y]),
                               *d = std::get_if<Cylinder>(&objects[x]);
                               c && d) {
                        if (c->radius == d->radius && c->axis.dot(w) == 0 &&
                            c->axis.cross(d->axis).isZero(0) && 2 * w.dot(c->point) < w.squaredNorm() &&
                            (image(c->point, w) - d->point).cross(c->axis).isZero(1e-12))
                            expected.emplace(x, y, t);
                    }
                }
        }
        // Only ties are missing by which something would be hidden by what it hides.
        CHECK(std::ranges::includes(expected, ties));
        std::set<std::array<std::uint32_t, 2>> hides;  // what is hidden, also by way of others, and by what
        for (const auto& [x, y, t] : ties) hides.insert({{x, y}, {x, t}});
        for (std::size_t before = 0; before != hides.size();) {
            before = hides.size();
            for (const auto& [x, y] : std::set(hides))
                for (const auto& [z, w] : std::set(hides))
                    if (y == z) hides.insert({x, w});
        }
        for (const auto& [x, y] : hides) CHECK(x != y);
        for (const auto& [x, y, t] : expected)
            CHECK((ties.contains({x, y, t}) || hides.contains({y, x}) || hides.contains({t, x})));
    }
}

// A tube at 20 is the image of that at -1 in the mirror half-way to 19, and the one at 19 that of 1 in the
// mirror half-way to 20.
TEST_CASE("mirror ties: nothing is hidden by what it hides") {
    const auto tube = [](double x) { return Cylinder{{x, 0, 0}, {0, 0, 1}, 0.25}; };
    const std::vector<Object> objects{tube(1), tube(-1), tube(19), tube(20)};
    int hidden[2] = {0, 0};
    for (const MirrorTie& tie : find_mirror_ties(tube(0), pointers(objects), 0))
        if (tie.hidden >= 2) ++hidden[tie.hidden - 2];
    CHECK((hidden[0] > 0) != (hidden[1] > 0));
}

TEST_CASE("mirror ties: what is off by rounding gives way by that, and by no more than is allowed") {
    const Cylinder base{{0.1, 0, 0.1}, {0, 1, 0}, 0.25};
    const double off = 0x1p-52;
    const std::vector<Object> objects{Cylinder{{0.1, 5, 0.3}, {0, 2, 0}, 0.25}, Sphere{{0.4, 0.7, 0}, 0.125},
                                      Sphere{{0.4 + off, 0.7, 0.4}, 0.125}};
    const std::vector<MirrorTie> ties = find_mirror_ties(base, pointers(objects), 0x1p-50);
    REQUIRE(ties.size() == 1);
    CHECK(ties[0].hidden == 2);
    CHECK(ties[0].mirrored == 1);
    CHECK(ties[0].mirror == 0);
    CHECK(ties[0].off >= off);
    CHECK(ties[0].off < 3 * off);
    CHECK(find_mirror_ties(base, pointers(objects), 0.5 * off).empty());
    // The image of the base's twin gives way by no more than a part of what the two are apart.
    const double apart = 0x1p-30;
    const std::vector<Object> twins{objects[0], Cylinder{{0.1 + apart, 0, 0.1 + off}, {0, 1, 0}, 0.25},
                                    Cylinder{{0.1 + apart, 0, 0.3}, {0, 1, 0}, 0.25}};
    CHECK(find_mirror_ties(base, pointers(twins), 0x1p-50).empty());
    const std::vector<Object> others{objects[0], Cylinder{{0.5, 0, 0.1 + off}, {0, 1, 0}, 0.25},
                                     Cylinder{{0.5, 0, 0.3}, {0, 1, 0}, 0.25}};
    CHECK(!find_mirror_ties(base, pointers(others), 0x1p-50).empty());
    std::vector<const Object*> without = pointers(objects);
    without[1] = nullptr;
    CHECK(find_mirror_ties(base, without, 1).empty());
}
