// The cells of all objects of a scene fill its box, and two neighbours agree on the area between them.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../test_support.hpp"

namespace vcell::tiling_test {
namespace {

Scene scene_of(const std::vector<Object>& objects, std::size_t base, const Box& box) {
    Scene scene;
    scene.base = objects[base];
    scene.box = box;
    scene.objects = objects;
    scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(base));
    return scene;
}

/// What the cells miss of their box, and say they may miss.
struct Gap {
    double volume, bound;
};

/// Pre: every cell reaches all that is nearest to its base (balls; cylinders along an axis of the box).
Gap check_tiling(const std::vector<Object>& objects, const Box& box) {
    struct Contact {
        double area = 0, error = 0;
    };
    std::map<std::array<std::size_t, 2>, Contact> contacts;
    double volume = 0, bound = 0;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const Cell cell = voronoi_cell(scene_of(objects, i, box));
        volume += cell.measures.volume;
        bound += cell.measures.volume_error;
        for (const CellFace& face : cell.faces) {
            if (!face.site.is_object()) continue;
            Contact& contact = contacts[{i, face.site.index + (face.site.index >= i)}];
            contact.area += face.area;
            contact.error += cell.measures.area_error;
        }
    }
    for (const auto& [pair, contact] : contacts) {
        CAPTURE(pair[0]);
        CAPTURE(pair[1]);
        const auto back = contacts.find({pair[1], pair[0]});
        REQUIRE(back != contacts.end());
        CHECK(std::abs(contact.area - back->second.area) <= contact.error + back->second.error);
    }
    const double whole = (box.max - box.min).prod();
    return {std::abs(volume - whole), bound + 0x1p-50 * whole * static_cast<double>(objects.size())};
}

TEST_CASE("tiling: the cells of all atoms of crambin fill their box") {
    std::ifstream file(test_data("1CRN.xyzr"));
    std::vector<Object> atoms;
    Box box{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
    for (std::string line; std::getline(file, line);) {
        std::istringstream in(line);
        Sphere s;
        if (!(in >> s.center[0] >> s.center[1] >> s.center[2] >> s.radius)) continue;
        atoms.push_back(s);
        box.min = box.min.cwiseMin(s.center - Vec3::Constant(s.radius + 1));
        box.max = box.max.cwiseMax(s.center + Vec3::Constant(s.radius + 1));
    }
    REQUIRE(atoms.size() == 327);
    const Gap gap = check_tiling(atoms, box);
    CHECK(gap.volume <= gap.bound);
    CHECK(gap.bound < 1e-9 * (box.max - box.min).prod());
}

TEST_CASE("tiling: the cells of a packing fill their box") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> shift(-0.2, 0.2), radius(0.05, 0.25);
    constexpr int side = 5;
    std::vector<Object> balls;
    for (int x = 0; x < side; ++x)
        for (int y = 0; y < side; ++y)
            for (int z = 0; z < side; ++z)
                balls.push_back(Sphere{Vec3(x + shift(rng), y + shift(rng), z + shift(rng)), radius(rng)});
    const Box box{Vec3::Constant(-0.5), Vec3::Constant(side - 0.5)};
    const Gap gap = check_tiling(balls, box);
    CHECK(gap.volume <= gap.bound);
    CHECK(gap.bound < 1e-9 * (box.max - box.min).prod());
}

TEST_CASE("tiling: the cells of parallel tubes fill their box") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> shift(-0.2, 0.2), radius(0, 0.25);
    constexpr int side = 4;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<Object> tubes;
        for (int x = 0; x < side; ++x)
            for (int y = 0; y < side; ++y) {
                Vec3 p = Vec3::Zero();
                p[(axis + 1) % 3] = x + shift(rng);
                p[(axis + 2) % 3] = y + shift(rng);
                tubes.push_back(Cylinder{p, Vec3::Unit(axis), radius(rng)});
            }
        const Box box{Vec3::Constant(-0.5), Vec3::Constant(side - 0.5)};
        const Gap gap = check_tiling(tubes, box);
        CHECK(gap.volume <= gap.bound);
        CHECK(gap.bound < 1e-6 * (box.max - box.min).prod());
    }
}

}  // namespace
}  // namespace vcell::tiling_test
