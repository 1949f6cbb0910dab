// Void networks against what lattices are known to have, sampled clearances and paths through a grid.
#include "../../envelope/whole/void_network.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "../../core/errors.hpp"
#include "../test_support.hpp"
#include "network_oracle.hpp"

namespace vcell::void_network_test {

using namespace network_oracle;

namespace {

DiagramScene cube(double edge, const std::vector<Vec3>& places, double radius) {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(edge)};
    scene.periodic = {true, true, true};
    for (const Vec3& p : places) scene.objects.push_back(Sphere{edge * p, radius});
    return scene;
}

DiagramScene random_periodic(std::mt19937_64& rng, std::size_t n, double least, double most) {
    std::uniform_real_distribution<double> place(0, 1), radius(least, most);
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.periodic = {true, true, true};
    for (std::size_t i = 0; i < n; ++i)
        scene.objects.push_back(Sphere{{place(rng), place(rng), place(rng)}, radius(rng)});
    return scene;
}

}  // namespace

TEST_CASE("void network: a cubic lattice has one vertex of eight balls, and three edges of four") {
    const double a = 2, r = 0.25;
    const DiagramScene scene = cube(a, {Vec3::Zero()}, r);
    const VoidNetwork network = void_network(scene);
    check_places(scene, network);
    REQUIRE(network.vertices.size() == 1);
    CHECK(network.vertices[0].sites.size() == 8);
    CHECK(network.edges.size() == 3);
    for (const NetworkEdge& e : network.edges) {
        CHECK(e.sites.size() == 4);
        CHECK(std::abs(e.length - a) <= e.length_error);
        CHECK(std::abs(e.bottleneck - (a / std::numbers::sqrt2 - r)) <= e.bottleneck_error);
    }
    CHECK(encloses(network.included, std::sqrt(3.0) * a - 2 * r));
    CHECK(encloses(network.free, std::sqrt(2.0) * a - 2 * r));
    for (const auto& along : network.free_along) CHECK(encloses(along, std::sqrt(2.0) * a - 2 * r));
    CHECK(encloses(network.included_along_free, std::sqrt(3.0) * a - 2 * r));
    CHECK(network.free->error < 1e-9);
}

TEST_CASE("void network: face-centred and body-centred lattices, in cubes and in leaning boxes") {
    const double a = 2, r = 0.3;
    const DiagramScene fcc_scene = cube(a, {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}}, r);
    const VoidNetwork fcc = void_network(fcc_scene);
    check_places(fcc_scene, fcc);
    std::map<std::size_t, int> kinds;
    for (const NetworkVertex& v : fcc.vertices) ++kinds[v.sites.size()];
    CHECK(kinds == std::map<std::size_t, int>{{4, 8}, {6, 4}});
    CHECK(fcc.edges.size() == 32);
    const double fcc_free = 2 * (a / std::sqrt(6.0) - r);
    CHECK(encloses(fcc.included, a - 2 * r));
    CHECK(encloses(fcc.free, fcc_free));
    CHECK(encloses(fcc.included_along_free, a - 2 * r));

    const VoidNetwork bcc = void_network(cube(a, {{0, 0, 0}, {0.5, 0.5, 0.5}}, r));
    CHECK(bcc.vertices.size() == 12);
    CHECK(bcc.edges.size() == 24);
    CHECK(std::ranges::all_of(degrees(bcc), [](std::size_t d) { return d == 4; }));
    CHECK(encloses(bcc.included, 2 * (std::sqrt(5.0) / 4 * a - r)));
    CHECK(encloses(bcc.free, 2 * (3 / (4 * std::numbers::sqrt2) * a - r)));

    // One ball in a primitive cell, and the same lattice in a cube.
    DiagramScene leaning;
    leaning.box = {Vec3::Zero(), {2, 1, 1}};
    leaning.tilt = {1, 1, 0};
    leaning.periodic = {true, true, true};
    leaning.objects = {Sphere{Vec3::Zero(), r}};
    DiagramScene straight;
    straight.box = {Vec3::Zero(), {2, 2, 2}};
    straight.periodic = {true, true, true};
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) straight.objects.push_back(Sphere{Vec3((i + j) % 2, i, j), r});
    const VoidNetwork primitive = void_network(leaning), whole = void_network(straight);
    check_places(leaning, primitive);
    check_places(straight, whole);
    CHECK(4 * primitive.vertices.size() == whole.vertices.size());
    CHECK(4 * primitive.edges.size() == whole.edges.size());
    CHECK(encloses(primitive.included, whole.included->diameter));
    CHECK(encloses(primitive.free, whole.free->diameter));
}

TEST_CASE("void network: a ball that a cell meets in a vertex alone is a site of it all the same") {
    // Corners of unit cubes, 24 of 64: the cell of 23 does not list 22 at the centre of the cube they share.
    const std::array<std::array<int, 3>, 24> corners{
        {{2, 0, 2}, {0, 3, 0}, {0, 3, 3}, {3, 1, 2}, {3, 3, 2}, {0, 2, 1}, {2, 3, 3}, {1, 1, 0},
         {3, 0, 3}, {1, 1, 3}, {2, 0, 1}, {2, 1, 2}, {2, 2, 1}, {0, 3, 2}, {1, 2, 1}, {1, 3, 2},
         {1, 1, 2}, {2, 0, 0}, {0, 3, 1}, {3, 1, 3}, {1, 2, 3}, {3, 1, 0}, {3, 3, 3}, {0, 0, 2}}};
    DiagramScene scene = cube(4, {}, 0.25);
    for (const auto& [x, y, z] : corners)
        scene.objects.push_back(Sphere{Vec3(x, y, z) + Vec3::Constant(0.5), 0.25});
    const VoidNetwork network = void_network(scene);
    check_places(scene, network);
    CHECK(std::ranges::any_of(network.vertices, [](const NetworkVertex& v) {
        std::vector<std::uint32_t> numbers;
        for (const NetworkSite& s : v.sites) numbers.push_back(s.site.index);
        return numbers == std::vector<std::uint32_t>{2, 4, 8, 13, 22, 23};
    }));
}

TEST_CASE("void network: balls of any radii, by brute force, vertices of degree four, and Euler's relation") {
    std::mt19937_64 rng(test_seed());
    for (const auto& [least, most] : {std::pair(0.0, 0.0), std::pair(0.02, 0.08), std::pair(0.0, 0.2)}) {
        CAPTURE(most);
        const DiagramScene scene = random_periodic(rng, 24, least, most);
        VoidNetworkBuilder builder(scene);
        DiagramOptions options;
        options.visit = [&](std::uint32_t object, const Cell& cell) { builder.add(object, cell); };
        const VoronoiDiagram diagram = voronoi_diagram(scene, options);
        const VoidNetwork network = builder.finish(diagram);
        check_places(scene, network);
        CHECK(std::ranges::all_of(degrees(network), [](std::size_t d) { return d == 4; }));
        if (most < 0.1) {
            // Points and balls nearly equal: faces are discs and cells are balls, which fill a torus.
            std::size_t faces = 0, cells = 0;
            for (const Contact& c : contacts(diagram).contacts) faces += c.faces;
            for (const DiagramCell& c : diagram.cells) cells += c.state == DiagramCell::State::Computed;
            CHECK(network.vertices.size() + faces == network.edges.size() + cells);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            REQUIRE(network.free_along[k].has_value());
            CHECK(network.free_along[k]->diameter <= network.free->diameter);
        }
        CHECK(network.free->diameter <= network.included_along_free->diameter);
        CHECK(network.included_along_free->diameter <= network.included->diameter);
    }
}

TEST_CASE("void network: what gets through is what gets through a grid") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < long_rounds(3); ++round) {
        CAPTURE(round);
        const DiagramScene scene = random_periodic(rng, 10, 0.05, 0.15);
        const VoidNetwork network = void_network(scene);
        const int n = rounds() > 1 ? 24 : 16;
        const std::array<double, 3> levels = grid_percolation(scene, n);
        for (std::size_t k = 0; k < 3; ++k) {
            CAPTURE(k);
            CHECK(std::abs(0.5 * network.free_along[k]->diameter - levels[k]) <= std::sqrt(3.0) / 2 / n);
        }
    }
}

TEST_CASE("void network: a moved, mirrored or renumbered scene has the same") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = random_periodic(rng, 16, 0.0, 0.15);
    DiagramScene other = scene;
    for (Object& o : other.objects) {
        Sphere& ball = std::get<Sphere>(o);
        ball.center = wrapped(other, Vec3(0.25 - ball.center.x(), ball.center.y() + 0.375, ball.center.z()));
    }
    std::ranges::shuffle(other.objects, rng);
    const VoidNetwork a = void_network(scene), b = void_network(other);
    CHECK(a.vertices.size() == b.vertices.size());
    CHECK(a.edges.size() == b.edges.size());
    const auto same = [](const std::optional<NetworkSphere>& p, const std::optional<NetworkSphere>& q) {
        return std::abs(p->diameter - q->diameter) <= p->error + q->error + 1e-12;
    };
    CHECK(same(a.included, b.included));
    CHECK(same(a.free, b.free));
    CHECK(same(a.included_along_free, b.included_along_free));
    for (std::size_t k = 0; k < 3; ++k) CHECK(same(a.free_along[k], b.free_along[k]));
    std::vector<double> widths_a, widths_b;
    for (const NetworkEdge& e : a.edges) widths_a.push_back(e.bottleneck);
    for (const NetworkEdge& e : b.edges) widths_b.push_back(e.bottleneck);
    std::ranges::sort(widths_a);
    std::ranges::sort(widths_b);
    for (std::size_t i = 0; i < widths_a.size(); ++i)
        CHECK(widths_a[i] == doctest::Approx(widths_b[i]).epsilon(1e-9));
}

TEST_CASE("void network: the least clearance along an edge is that of its sampled curve") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> place(0, 1), radius(0, 0.3);
    DiagramScene scene;
    scene.box = {Vec3::Constant(-0.2), Vec3::Constant(1.2)};
    for (int i = 0; i < 60; ++i)
        scene.objects.push_back(Sphere{{place(rng), place(rng), place(rng)}, radius(rng)});
    // By sites, ascending: the sampled least clearances of all edges of those.
    std::map<std::vector<NetworkSite>, std::vector<double>> sampled, found;
    std::map<CurveKind, int> kinds;
    VoidNetworkBuilder builder(scene);
    DiagramOptions options;
    int inner = 0;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        builder.add(object, cell);
        for (const CellEdge& e : cell.edges) {
            std::vector<NetworkSite> sites{{Site::object(object)}, {e.sites[0]}, {e.sites[1]}};
            if (!e.sites[0].is_object() || !e.sites[1].is_object() || !e.extra_sites.empty()) continue;
            std::ranges::sort(sites);
            if (sites[0].site.index != object) continue;
            ++kinds[e.kind];
            const Sphere ball = std::get<Sphere>(scene.objects[object]);
            double least = HUGE_VAL;
            constexpr int steps = 2000;
            for (int s = 0; s <= steps; ++s) {
                const double t = std::lerp(e.curve.domain_begin(), e.curve.domain_end(), s / double(steps));
                least = std::min(least, (e.curve.evaluate(t) - ball.center).norm() - ball.radius);
            }
            sampled[sites].push_back(least);
        }
    };
    const VoidNetwork network = [&] {
        const VoronoiDiagram diagram = voronoi_diagram(scene, options);
        return builder.finish(diagram);
    }();
    check_places(scene, network);
    for (const NetworkEdge& e : network.edges) {
        found[e.sites].push_back(e.bottleneck);
        if (!e.vertices) continue;
        const double ends = std::min(network.vertices[(*e.vertices)[0]].clearance,
                                     network.vertices[(*e.vertices)[1]].clearance);
        inner += e.bottleneck < ends - 1e-6;
    }
    CHECK(kinds[CurveKind::Ellipse] > 0);
    CHECK(kinds[CurveKind::Hyperbola] > 0);
    CHECK(inner > 0);
    REQUIRE(found.size() == sampled.size());
    for (auto& [sites, widths] : sampled) {
        std::vector<double>& others = found[sites];
        std::ranges::sort(widths);
        std::ranges::sort(others);
        REQUIRE(widths.size() == others.size());
        for (std::size_t i = 0; i < widths.size(); ++i) {
            CHECK(others[i] <= widths[i] + 1e-9);
            CHECK(others[i] >= widths[i] - 1e-5);
        }
    }
    CHECK(!network.free);
}

TEST_CASE("void network: balls centred outside the box, and cells that end at a probe, have none") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.1}, Sphere{{1.1, 0.5, 0.5}, 0.1}};
    CHECK_THROWS_AS(void_network(scene), InputError);
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.1}};
    scene.probe = 0.1;
    CHECK_THROWS_AS(void_network(scene), InputError);
    scene.probe.reset();
    // Nor has a diagram of which a cell is missing.
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.1}};
    VoidNetworkBuilder builder(scene);
    VoronoiDiagram diagram = voronoi_diagram(scene);
    diagram.cells[0].state = DiagramCell::State::Undecided;
    CHECK_THROWS_AS(builder.finish(diagram), UndecidedError);
}

}  // namespace vcell::void_network_test
