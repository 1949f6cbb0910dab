// Cells with edges in which the bisectors with three objects meet (envelope/proofs/common_curves.hpp), as the
// check judges them: of balls in a row, tubes that touch one circle, and tubes that mirror each other between
// two sides of the box.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <variant>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../test_support.hpp"

using namespace vcell;

namespace {

class Dice {
public:
    int count(int from, int to) { return std::uniform_int_distribution(from, to)(rng_); }
    // A multiple of 1/8.
    double eighths(double from, double to) {
        return 0.125 * count(static_cast<int>(8 * from), static_cast<int>(8 * to));
    }

private:
    std::mt19937_64 rng_{test_seed()};
};

Scene over_plane(double half, std::vector<Object> objects) {
    Scene scene;
    scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
    scene.objects = std::move(objects);
    scene.box = {{-half, -half, -1}, {half, half, 2 * half}};
    return scene;
}

double radius_of(const Object& o) {
    const auto* ball = std::get_if<Sphere>(&o);
    return ball != nullptr ? ball->radius : std::get<Cylinder>(o).radius;
}
Vec3 place_of(const Object& o) {
    const auto* ball = std::get_if<Sphere>(&o);
    return ball != nullptr ? ball->center : std::get<Cylinder>(o).point;
}

// Do balls, and tubes along the x axis, touch neither each other nor the plane?
bool are_apart(const std::vector<Object>& objects) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (!(radius_of(objects[i]) >= 0 && place_of(objects[i]).z() > radius_of(objects[i]))) return false;
        for (std::size_t j = 0; j < i; ++j)
            if ((place_of(objects[i]) - place_of(objects[j])).norm() <=
                radius_of(objects[i]) + radius_of(objects[j]))
                return false;
    }
    return true;
}

// Balls whose tops are 2 s above the plane, all equally near to it along a line x = c: the clearance is
// ((x - x_i)^2 + (y - y_0)^2 + s^2 - 2 s r_i) / (2 s).
std::vector<Object> row_of_balls(Dice& dice) {
    constexpr double s = 4;
    const double c = dice.eighths(-1, 1), y = dice.eighths(-1, 1), most = dice.eighths(0.75, 1.25);
    const double middle = dice.eighths(-0.5, 0.5);
    std::vector<Object> balls;
    for (const double x : {-dice.eighths(2.5, 3.5), middle, dice.eighths(2.5, 3.5)}) {
        const double r = most - (9 - (x - c) * (x - c)) / (2 * s);
        balls.push_back(Sphere{{x, y, s - r}, r});
    }
    return balls;
}

// Tubes along the x axis that touch the circle of radius R which touches the plane at y = 0.
std::vector<Object> tubes_about_circle(Dice& dice) {
    constexpr double R = 4;
    std::vector<Object> tubes;
    const auto add = [&](double p, double q, double h) {  // p^2 + q^2 = h^2
        const double s = std::ceil(64 * (R + dice.eighths(0.125, 2)) / h) / 64;
        tubes.push_back(Cylinder{{0, s * p, R + s * q}, Vec3::UnitX(), s * h - R});
    };
    add(0, 1, 1);
    if (dice.count(0, 1) == 0)
        add(4, 3, 5);
    else
        add(3, 4, 5);
    add(-5, 12, 13);
    add(-12, 5, 13);
    return tubes;
}

// The edges that name a third object.
std::ptrdiff_t common_edges(const Cell& cell) {
    return std::ranges::count_if(cell.edges, [](const CellEdge& e) { return !e.extra_sites.empty(); });
}

void check_proved(const Cell& cell) {
    CHECK(cell.report.decisions.assumed == 0);
    const Certificate c = certify(cell);
    for (const Element& e : c.elements) {
        CAPTURE(e.where);
        CAPTURE(e.what);
        CHECK(e.verdict == Verdict::proved);
    }
}

}  // namespace

TEST_CASE("check of common curves: three balls in a row under a tube, and tubes that touch one circle") {
    Dice dice;
    std::ptrdiff_t common = 0, scenes = 0;
    for (int i = 0; i < long_rounds(12); ++i) {
        CAPTURE(i);
        const bool are_balls = i % 2 == 0;
        std::vector<Object> objects = are_balls ? row_of_balls(dice) : tubes_about_circle(dice);
        if (!are_apart(objects)) continue;
        ++scenes;
        if (are_balls)
            objects.push_back(Cylinder{{dice.eighths(-2, 2), dice.eighths(-2, 2), 10},
                                       {dice.eighths(-1, 1), 1, dice.eighths(-0.25, 0.25)},
                                       dice.eighths(0, 1)});
        else
            objects.push_back(Sphere{{dice.eighths(-3, 3), dice.eighths(-2, 2), 14}, dice.eighths(0, 1)});
        const Cell cell = voronoi_cell(over_plane(16, std::move(objects)));
        check_proved(cell);
        common += common_edges(cell);
    }
    CHECK(scenes > 0);
    CHECK(2 * common >= scenes);
}

TEST_CASE("check of common curves: vertices that do not name the third object are refused") {
    Dice dice;
    std::vector<Object> objects;
    do objects = row_of_balls(dice);
    while (!are_apart(objects));
    objects.push_back(Cylinder{{0, 0, 10}, {0.25, 1, 0}, 1});
    Cell cell = voronoi_cell(over_plane(16, std::move(objects)));
    REQUIRE(common_edges(cell) > 0);
    for (const CellEdge& e : cell.edges)
        for (const Site third : e.extra_sites)
            for (const std::uint32_t v : e.vertices) {
                auto& sites = cell.vertices[v].sites;
                sites.erase(std::ranges::find(sites, third));
            }
    const Certificate c = certify(cell);
    CHECK(std::ranges::count(c.elements, Verdict::refuted, &Element::verdict) > 0);
}

TEST_CASE("check of common curves: balls in a row beside a tube tie all around it, whatever its direction") {
    // Places u a + z n on a circle that touches the axis: 3 n, 2.5 n or 5 n is its centre.
    struct Row {
        Vec3 a, n;
        std::vector<std::array<double, 2>> places;
    };
    const std::array rows{Row{{1, 1, 0}, {0, 0, 1}, {{2, 2}, {-2, 2}, {2, 4}, {-2, 4}, {0, 6}}},
                          Row{{1, 1, 1}, {1, -1, 0}, {{2, 2}, {-2, 2}, {2, 3}, {-2, 3}, {0, 5}}},
                          Row{{0, 1, 0}, {1, 0, 0}, {{3, 1}, {-3, 1}, {3, 9}, {4, 2}, {-4, 8}, {0, 10}}}};
    Dice dice;
    for (int i = 0; i < long_rounds(9); ++i) {
        const Row& row = rows[static_cast<std::size_t>(i) % rows.size()];
        CAPTURE(i);
        const double radius = dice.eighths(0, 0.5);
        std::vector<std::array<double, 2>> places = row.places;
        Scene scene;
        scene.base = Cylinder{Vec3::Zero(), row.a, radius};
        for (int k = 0; k < 4; ++k) {
            const auto at = places.begin() + dice.count(0, static_cast<int>(places.size()) - 1);
            scene.objects.push_back(Sphere{(*at)[0] * row.a + (*at)[1] * row.n, radius});
            places.erase(at);
        }
        scene.objects.push_back(Sphere{-4 * row.n + dice.eighths(-1, 1) * row.a, dice.eighths(0, 1)});
        scene.box = {Vec3::Constant(-12), Vec3::Constant(13)};
        const Cell cell = voronoi_cell(scene);
        check_proved(cell);
    }
}

TEST_CASE("check of common curves: tubes that mirror each other in a plane through an edge of the box") {
    for (const double lean : {0.0, 0.5, 1.0}) {
        CAPTURE(lean);
        Scene scene;
        scene.base = Cylinder{{1.25, 0.75, 1}, {1, 1, lean}, 0.0625};
        scene.objects = {Cylinder{{0.75, 1.25, 1}, {1, 1, lean}, 0.0625}};
        scene.box = {Vec3::Zero(), Vec3::Constant(2)};
        CellOptions options;
        options.complete = true;
        const Cell cell = voronoi_cell(scene, options);
        check_proved(cell);
        CHECK(std::abs(cell.measures.volume - 4) <= cell.measures.volume_error);
    }
}
