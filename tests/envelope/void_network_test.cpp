// Void networks against what lattices are known to have, sampled clearances and paths through a grid.
#include "../../envelope/whole/void_network.hpp"

#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "../../core/errors.hpp"
#include "../test_support.hpp"

namespace vcell::void_network_test {
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

bool encloses(const std::optional<NetworkSphere>& sphere, double diameter) {
    return sphere && std::abs(sphere->diameter - diameter) <= sphere->error + 1e-15;
}

Sphere placed(const DiagramScene& scene, const NetworkSite& site) {
    Sphere ball = std::get<Sphere>(scene.objects[site.site.index]);
    ball.center += scene.edges() * Vec3(site.image[0], site.image[1], site.image[2]);
    return ball;
}

/// The clearance by all balls, images about the box included.
double clearance(const DiagramScene& scene, const Vec3& p) {
    double least = HUGE_VAL;
    // Boxes that lean have near images farther off.
    const int x = 2 * scene.periodic[0], y = 2 * scene.periodic[1], z = 2 * scene.periodic[2];
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        for (int a = -x; a <= x; ++a)
            for (int b = -y; b <= y; ++b)
                for (int c = -z; c <= z; ++c) {
                    const Sphere ball =
                        placed(scene, {Site::object(i),
                                       {static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                        static_cast<std::int16_t>(c)}});
                    least = std::min(least, (p - ball.center).norm() - ball.radius);
                }
    return least;
}

Vec3 wrapped(const DiagramScene& scene, Vec3 p) {
    const Eigen::Matrix3d edges = scene.edges();
    const Vec3 parts = edges.inverse() * (p - scene.box.min);
    for (int k = 0; k < 3; ++k)
        if (scene.periodic[k]) p -= std::floor(parts[k]) * edges.col(k);
    return p;
}

std::vector<std::size_t> degrees(const VoidNetwork& network) {
    std::vector<std::size_t> degrees(network.vertices.size(), 0);
    for (const NetworkEdge& e : network.edges)
        if (e.vertices)
            for (const std::uint32_t v : *e.vertices) ++degrees[v];
    return degrees;
}

/// The largest clearance at which cells of a grid percolate along each axis: within half a cell's diagonal of
/// the true one, as clearances change no faster than places.
std::array<double, 3> grid_percolation(const DiagramScene& scene, int n) {
    std::vector<double> field(static_cast<std::size_t>(n * n * n));
    for (int i = 0; i < n * n * n; ++i)
        field[static_cast<std::size_t>(i)] = clearance(scene, Vec3(i / (n * n), i / n % n, i % n) / n);
    std::array<double, 3> levels{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    std::vector<int> order(field.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, [&](int a, int b) {
        return field[static_cast<std::size_t>(a)] > field[static_cast<std::size_t>(b)];
    });
    // Whole components are moved when they join: slow, and plain.
    std::vector<int> label(field.size(), -1);
    std::vector<std::array<int, 3>> turn(field.size());
    std::map<int, std::vector<int>> members;
    for (const int i : order) {
        label[static_cast<std::size_t>(i)] = i;
        turn[static_cast<std::size_t>(i)] = {0, 0, 0};
        members[i] = {i};
        const std::array at{i / (n * n), i / n % n, i % n};
        for (int step = 0; step < 27; ++step) {
            std::array<int, 3> to{}, around{};
            for (int k = 0; k < 3; ++k) {
                const int d = k == 0 ? step / 9 - 1 : k == 1 ? step / 3 % 3 - 1 : step % 3 - 1;
                const int next = at[static_cast<std::size_t>(k)] + d;
                around[static_cast<std::size_t>(k)] = next < 0 ? -1 : next >= n ? 1 : 0;
                to[static_cast<std::size_t>(k)] = (next + n) % n;
            }
            const int j = (to[0] * n + to[1]) * n + to[2];
            if (label[static_cast<std::size_t>(j)] < 0 || j == i) continue;
            const auto& ti = turn[static_cast<std::size_t>(i)];
            const auto& tj = turn[static_cast<std::size_t>(j)];
            std::array<int, 3> way{};
            for (std::size_t k = 0; k < 3; ++k) way[k] = ti[k] + around[k] - tj[k];
            const int a = label[static_cast<std::size_t>(i)], b = label[static_cast<std::size_t>(j)];
            if (a == b) {
                for (std::size_t k = 0; k < 3; ++k)
                    if (way[k] != 0) levels[k] = std::max(levels[k], field[static_cast<std::size_t>(i)]);
                continue;
            }
            const bool is_first_smaller = members[a].size() < members[b].size();
            const int from = is_first_smaller ? a : b, into = is_first_smaller ? b : a;
            for (const int m : members[from]) {
                label[static_cast<std::size_t>(m)] = into;
                for (std::size_t k = 0; k < 3; ++k)
                    turn[static_cast<std::size_t>(m)][k] += is_first_smaller ? -way[k] : way[k];
            }
            members[into].insert(members[into].end(), members[from].begin(), members[from].end());
            members.erase(from);
        }
    }
    return levels;
}

void check_places(const DiagramScene& scene, const VoidNetwork& network) {
    for (const NetworkVertex& v : network.vertices) {
        const double doubt = v.error + 4 * network.moved + 1e-12;
        CHECK(std::abs(clearance(scene, wrapped(scene, v.point)) - v.clearance) <= doubt);
        for (const NetworkSite& s : v.sites) {
            if (!s.site.is_object()) continue;
            const Sphere ball = placed(scene, s);
            CHECK(std::abs((v.point - ball.center).norm() - ball.radius - v.clearance) <= 2 * doubt);
        }
    }
    for (const NetworkEdge& e : network.edges) {
        CHECK(e.bottleneck_error < 1e-9);
        if (!e.vertices) continue;
        const NetworkVertex &a = network.vertices[(*e.vertices)[0]], &b = network.vertices[(*e.vertices)[1]];
        CHECK(e.bottleneck <= std::min(a.clearance + a.error, b.clearance + b.error) + e.bottleneck_error);
        // Both ends are equally far from the edge's balls, the second one in its image.
        const Vec3 end = b.point + scene.edges() * Vec3(e.image[0], e.image[1], e.image[2]);
        for (const NetworkSite& s : e.sites) {
            const Sphere ball = placed(scene, s);
            CHECK(std::abs((a.point - ball.center).norm() - ball.radius - a.clearance) < 1e-9);
            CHECK(std::abs((end - ball.center).norm() - ball.radius - b.clearance) < 1e-9);
        }
        CHECK((end - a.point).norm() <= e.length + e.length_error + a.error + b.error + 1e-12);
    }
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

TEST_CASE("void network: planes and balls centred outside the box have none") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.1}, Plane{{0, 0, 0.1}, {0, 0, 1}}};
    CHECK_THROWS_AS(void_network(scene), InputError);
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.1}, Sphere{{1.1, 0.5, 0.5}, 0.1}};
    CHECK_THROWS_AS(void_network(scene), InputError);
    // Nor have cells that end at a probe.
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
