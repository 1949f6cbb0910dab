// Cells of cylinders where balls tie along rings and where faces end in cusps: rows and lattices.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "../../envelope/proofs/tie_fan.hpp"
#include "radial_cell_checks.hpp"

namespace vcell::cylinder_ties_test {
using namespace vcell::radial_cells;

// Orthogonal, of one length that is a double: along the axis, and across it.
constexpr std::array<std::array<double, 9>, 3> frames{
    {{0, 1, 0, 1, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, 1, 0, 1, 0}, {1, 2, 2, 2, 1, -2, 2, -2, 1}}};

struct Frame {
    Vec3 along, across, other;
};
Frame frame(const std::array<double, 9>& f) {
    return {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}, {f[6], f[7], f[8]}};
}

std::size_t edges_with(const Cell& cell, Site site) {
    return std::ranges::count_if(cell.edges, [&](const CellEdge& e) {
        return std::ranges::find(e.extra_sites, site) != e.extra_sites.end();
    });
}

TEST_CASE("cylinder cell: three balls of its radius in a row tie along a ring") {
    for (const std::size_t k : {0u, 1u, 2u}) {
        const auto [along, across, other] = frame(frames[k]);
        const double length = along.norm();
        for (const Vec3& base : {Vec3(0, 0, 0), Vec3(1, -2, 0.5)})
            for (const double radius : {0.0, 0.25}) {
                CAPTURE(k);
                CAPTURE(radius);
                const auto ball = [&](double x, double y) {
                    return Sphere{base + x * across + y * along, radius};
                };
                std::vector<Object> balls{ball(1, -1), ball(2, 0), ball(1, 1)};
                std::ranges::rotate(balls, balls.begin() + static_cast<long>(k % 3));
                const Site middle = Site::object(static_cast<std::uint32_t>((4 - k % 3) % 3));
                const Scene scene = about_tube({base, along, radius}, 3 * length, balls);
                const Cell cell = checked(scene);
                CHECK(cell.report.decisions.assumed == 0);
                CHECK(edges_with(cell, middle) == 1);
                for (const CellEdge& e : cell.edges) {
                    if (e.extra_sites.empty()) continue;
                    for (int i = 0; i <= 4; ++i)
                        CHECK(std::abs((e.curve.evaluate(i / 4.0) - base).dot(along)) <= 1e-6 * length);
                    for (const std::uint32_t v : e.vertices)
                        CHECK(std::ranges::find(cell.vertices[v].sites, middle) !=
                              cell.vertices[v].sites.end());
                }
                // No face of it, but where it is farther along than that.
                CHECK(std::ranges::none_of(cell.faces, [&](const CellFace& f) { return f.site == middle; }));
                // Without it there are the same elements.
                std::vector<Object> two = balls;
                two.erase(two.begin() + middle.index);
                const Cell without = checked(about_tube({base, along, radius}, 3 * length, two));
                CHECK(without.edges.size() == cell.edges.size());
                CHECK(without.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-12));
                // A tube along it through the middle ball ties there, too.
                balls.push_back(Cylinder{base + 2 * across + 5 * along, along, radius});
                const Cell more = checked(about_tube({base, along, radius}, 3 * length, balls));
                CHECK(more.report.decisions.assumed == 0);
                CHECK(edges_with(more, Site::object(3)) == 1);
            }
    }
}

TEST_CASE("cylinder cell: what ties at an end of it") {
    // C / k of the two is 1 + y^2 and (4 + (y + 1)^2) / 2: equal at y = 3 and y = -1.
    for (const double end : {3.0, -3.0}) {
        const double side = end > 0 ? 1 : -1;
        Scene scene =
            about_tube({{0, 0, 0}, {0, 1, 0}, 0.5}, 3, {Sphere{{1, 0, 0}, 0.5}, Sphere{{2, -side, 0}, 0.5}});
        scene.box = {{-8, -3, -8}, {8, 3, 8}};
        const Cell cell = checked(scene);
        CHECK(cell.report.decisions.assumed == 0);
        std::size_t at_end = 0;
        for (const CellVertex& v : cell.vertices) {
            const auto has = [&](Site s) { return std::ranges::find(v.sites, s) != v.sites.end(); };
            if (has(Site::end(side > 0)) && has(Site::object(0))) {
                CHECK(has(Site::object(1)));
                ++at_end;
            }
        }
        CHECK(at_end >= 2);
        CHECK(edges_with(cell, Site::object(1)) == 1);
        // A little longer it has a face beyond.
        const auto faces = [](const Cell& c, Site s) {
            return std::ranges::count_if(c.faces, [&](const CellFace& f) { return f.site == s; });
        };
        scene.box.min.y() -= 0.5;
        scene.box.max.y() += 0.5;
        const Cell longer = checked(scene);
        CHECK(faces(longer, Site::object(1)) > faces(cell, Site::object(1)));
    }
}

TEST_CASE("cylinder cell: faces that end in cusps where four balls tie") {
    const Scene scene = about_tube({{0, 0, 0}, {0, 1, 0}, 0.25}, 2.5,
                                   {Sphere{{0.5, 1.5, -0.5}, 0}, Sphere{{0.5, 1.5, 0.5}, 0},
                                    Sphere{{1, 1, 0}, 0}, Sphere{{1.5, 1.5, 0.5}, 0}});
    const Cell cell = checked(scene);
    CHECK(cell.report.decisions.assumed == 0);
    // In any order.
    std::vector<std::size_t> order{0, 1, 2, 3};
    while (std::ranges::next_permutation(order).found) {
        Scene other = scene;
        for (std::size_t i = 0; i < 4; ++i) other.objects[i] = scene.objects[order[i]];
        const Cell same = cell_of(other);
        CHECK(same.vertices.size() == cell.vertices.size());
        CHECK(same.edges.size() == cell.edges.size());
        CHECK(same.measures.volume == doctest::Approx(cell.measures.volume).epsilon(1e-12));
    }
}

TEST_CASE("cylinder cell: faces that end in cusps on the end in whose plane tubes cross it") {
    // Beside the end all that competes changes as it does across the tube: edges touch there, next to the
    // side of the box at the distance at which two others tie.
    const auto scenes = {
        about_tube({{0, 0, 0}, {0, 1, 0}, 0.5}, 2,
                   {Cylinder{{2, 0, 2}, {0, 1, 0}, 0.5}, Cylinder{{-2, 0, 0}, {0, 0, 1}, 0.5}}),
        about_tube({{0, 0, 0}, {0, 1, 0}, 0.25}, 2,
                   {Cylinder{{2, 0, 0}, {0, 0, 1}, 0.25}, Cylinder{{-2, 0, 0}, {0, 0, 1}, 0.25}})};
    for (Scene scene : scenes) {
        scene.box = {{-6, -2, -6}, {2, 2, 2}};
        const Cell both = checked(scene);
        scene.box.min.y() = 0;
        const Cell half = checked(scene);
        CHECK(both.report.decisions.assumed == 0);
        CHECK(half.report.decisions.assumed == 0);
        CHECK(half.measures.volume == doctest::Approx(0.5 * both.measures.volume).epsilon(1e-9));
        CHECK(std::ranges::any_of(half.vertices, [](const CellVertex& v) {
            return v.point.isApprox(Vec3(0, 0, 2)) && v.sites.size() >= 4;
        }));
    }
}

TEST_CASE("cylinder cell: in lattices of balls along its frame nothing is assumed") {
    std::mt19937_64 rng(test_seed());
    const auto number = [&](int low, int high) { return std::uniform_int_distribution(low, high)(rng); };
    for (int round = 0; round < 6 * rounds(); ++round) {
        CAPTURE(round);
        const auto [along, across, other] = frame(frames[number(0, 1) == 0 ? 0 : 2]);
        const double length = along.norm(), radius = 0.25 * number(0, 1);
        const int type = number(0, 2);
        std::vector<Object> balls;
        for (int x = -4; x <= 4; ++x)
            for (int y = -4; y <= 4; ++y)
                for (int z = -4; z <= 4; ++z) {
                    const int odd = (x & 1) + (y & 1) + (z & 1);
                    const bool is_site = type == 0 ? odd == 0 : type == 1 ? odd % 3 == 0 : odd % 2 == 0;
                    const Vec3 p = 0.5 * Vec3(x, y, z);
                    const double off = (p - p.dot(along) / (length * length) * along).norm();
                    if (is_site && p.norm() < 1.6 && off > 0.1) balls.push_back(Sphere{p, radius});
                }
        const Cell cell = checked(about_tube({{0, 0, 0}, along, radius}, 2.5, balls));
        CHECK(cell.report.decisions.assumed == 0);
    }
}

TEST_CASE("fan: between two functions a third one has a cusp, or nothing") {
    // x, -x and y all over a square, and between the first two s y^2, s = -1 or 1.
    const std::array<FormId, 4> forms{FormId{0}, FormId{1}, FormId{2}, FormId{3}};
    const auto gradient = [](double x, double y) { return TiedDifference{{Interval(x), Interval(y)}, {}}; };
    for (const double s : {1.0, -1.0}) {
        const Interval bend = s * Interval(-0.25, 0.25);  // its slope along y
        std::vector<std::vector<TiedDifference>> differences(4, std::vector<TiedDifference>(4));
        differences[0][1] = gradient(2, 0);
        differences[0][2] = gradient(1, -1);
        differences[1][2] = gradient(-1, -1);
        differences[0][3] = {{Interval(1), bend}, {}};
        differences[1][3] = {{Interval(-1), bend}, {}};
        differences[2][3] = {{Interval(0), 1.0 + bend}, {}};
        const std::array<TiedBetween, 1> between{{{3, {0, 1}, s > 0}}};
        const std::array<Eigen::Vector2d, 5> corners{
            {{1, 0.29}, {-0.29, 1}, {-1, -0.29}, {0.29, -1}, {1, 0.29}}};
        CHECK_FALSE(find_fan(forms, differences, {}, corners));
        const auto fan = find_fan(forms, differences, between, corners);
        REQUIRE(fan);
        CHECK(fan->first == FormId{1});
        std::vector<std::array<std::uint32_t, 2>> arms;
        for (const FanArm& arm : fan->arms) arms.push_back({arm.right.value, arm.left.value});
        const std::vector<std::array<std::uint32_t, 2>> cusp{{1, 3}, {3, 0}, {0, 2}, {2, 1}},
            none{{1, 0}, {0, 2}, {2, 1}};
        CHECK(arms == (s > 0 ? cusp : none));
    }
}

}  // namespace vcell::cylinder_ties_test
