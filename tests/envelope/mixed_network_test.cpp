// Void networks among tubes, planes, balls and vessels, whose cells are cut where they repeat.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../test_support.hpp"
#include "network_oracle.hpp"

namespace vcell::mixed_network_test {

using namespace network_oracle;

namespace {

enum class Family { AlongAxes, Oblique, BetweenPlates, InBox, InTube, Leaning };
constexpr std::array all_families{Family::AlongAxes, Family::Oblique, Family::BetweenPlates,
                                  Family::InBox,     Family::InTube,  Family::Leaning};

class Generator {
public:
    explicit Generator(std::mt19937_64& rng) : rng_(rng) {}

    DiagramScene operator()(Family family) {
        DiagramScene scene;
        scene.box = {Vec3::Zero(), Vec3::Ones()};
        scene.periodic = {true, true, true};
        switch (family) {
            case Family::AlongAxes:
                add_tubes(scene, 2 + count(3), [&] { return Vec3(Vec3::Unit(count(3))); });
                break;
            case Family::Oblique: add_tubes(scene, 2 + count(2), [&] { return combination(3); }); break;
            case Family::BetweenPlates:
                scene.periodic[2] = false;
                scene.objects = {Plane{{0.5, 0, 0}, {0, 0, 1}}, Plane{{0, 0.5, 1}, {0, 0, -1}}};
                add_tubes(scene, 1 + count(3), [&] { return combination(2); });
                break;
            case Family::InBox:
                scene.periodic = {false, false, false};
                scene.objects = {Plane{{0, 0, 0}, {0, 0, 1}}};
                add_tubes(scene, 2 + count(2), [&] { return Vec3(normal(), normal(), 0); });
                break;
            case Family::InTube:
                scene.periodic = {false, false, true};
                scene.objects = {HollowCylinder{{0.5, 0.5, 0}, {0, 0, 1}, 0.6}};
                add_tubes(scene, 1 + count(2), [&] { return Vec3(0, 0, 1); });
                break;
            case Family::Leaning:
                scene.tilt = {uniform(-0.5, 0.5), uniform(-0.5, 0.5), uniform(-0.5, 0.5)};
                add_tubes(scene, 2 + count(2), [&] { return Vec3(scene.edges().col(count(3))); });
        }
        for (int n = 2 + count(3); n > 0; --n) scene.objects.push_back(Sphere{inner(), uniform(0, 0.1)});
        return scene;
    }

private:
    int count(int n) { return std::uniform_int_distribution(0, n - 1)(rng_); }
    double uniform(double a, double b) { return std::uniform_real_distribution(a, b)(rng_); }
    double normal() { return std::normal_distribution<>()(rng_); }
    Vec3 inner() { return {uniform(0.1, 0.9), uniform(0.1, 0.9), uniform(0.1, 0.9)}; }
    // Adds up so many edges of the unit cube, or takes them off.
    Vec3 combination(int edges) {
        Vec3 sum = Vec3::Zero();
        while (sum.isZero())
            for (int k = 0; k < edges; ++k) sum[k] = count(3) - 1;
        return sum;
    }
    template <class Direction>
    void add_tubes(DiagramScene& scene, int tubes, Direction direction) {
        for (; tubes > 0; --tubes) {
            const Vec3 axis = direction();
            scene.objects.push_back(Cylinder{inner(), axis, uniform(0.001, 0.05)});
        }
    }

    std::mt19937_64& rng_;
};

bool is_whole(const VoronoiDiagram& diagram) {
    return std::ranges::all_of(diagram.cells, [](const DiagramCell& c) {
        return c.state == DiagramCell::State::Computed || c.state == DiagramCell::State::Wall;
    });
}

/// Calls check(scene, network) for scenes of a family in which all objects have cells.
template <class Check>
void for_scenes(std::mt19937_64& rng, Family family, int scenes, Check check) {
    Generator generate(rng);
    int done = 0;
    for (int tries = 0; done < scenes && tries < 40 * scenes; ++tries) {
        const DiagramScene scene = generate(family);
        VoidNetworkBuilder builder(scene);
        DiagramOptions options;
        options.complete = true;
        options.visit = [&](std::uint32_t object, const Cell& cell) { builder.add(object, cell); };
        const VoronoiDiagram diagram = voronoi_diagram(scene, options);
        if (!is_whole(diagram)) continue;
        CAPTURE(static_cast<int>(family));
        CAPTURE(tries);
        check(scene, builder.finish(diagram));
        ++done;
    }
    CHECK(done == scenes);
}

/// Has each vertex of four objects an edge of each three of them?
void check_triples(const VoidNetwork& network) {
    using Numbers = std::multiset<std::uint32_t>;
    const auto numbers = [](const std::vector<NetworkSite>& sites) {
        Numbers all;
        for (const NetworkSite& s : sites) all.insert(s.site.index);
        return all;
    };
    std::map<std::uint32_t, std::multiset<Numbers>> ends;
    for (const NetworkEdge& e : network.edges)
        if (e.vertices)
            for (const std::uint32_t v : *e.vertices) ends[v].insert(numbers(e.sites));
    for (std::uint32_t i = 0; i < network.vertices.size(); ++i) {
        const NetworkVertex& v = network.vertices[i];
        if (v.sites.size() != 4 || v.is_touching) continue;
        std::multiset<Numbers> expected;
        for (std::size_t k = 0; k < 4; ++k) {
            std::vector<NetworkSite> three = v.sites;
            three.erase(three.begin() + static_cast<std::ptrdiff_t>(k));
            if (std::ranges::all_of(three, [](const NetworkSite& s) { return s.site.is_object(); }))
                expected.insert(numbers(three));
        }
        CHECK(ends[i] == expected);
    }
}

/// Tells a scene otherwise, so that cells are cut elsewhere: tubes by other points of theirs, everything
/// moved along what repeats, objects in another order.
DiagramScene retold(std::mt19937_64& rng, DiagramScene scene) {
    std::uniform_real_distribution<double> part(-1, 1);
    Vec3 by = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
        if (scene.periodic[static_cast<std::size_t>(k)]) by[k] = part(rng);
    for (Object& object : scene.objects) {
        if (auto* tube = std::get_if<Cylinder>(&object)) tube->point += part(rng) * tube->axis;
        place_of(object) += by;
        if (std::holds_alternative<Sphere>(object)) place_of(object) = wrapped(scene, place_of(object));
    }
    // A vessel moves along itself alone.
    for (Object& object : scene.objects)
        if (is_vessel(object)) place_of(object) -= by;
    std::ranges::shuffle(scene.objects, rng);
    return scene;
}

struct Width {
    double value, error;
};

// Bounds on the values of all elements, ascending: the k-th of the true ones is between the k-th bounds.
struct Bounds {
    std::vector<double> low, high;
};

template <class Of>
Bounds sorted(Of of, const auto& elements) {
    Bounds bounds;
    for (const auto& e : elements) {
        const Width width = of(e);
        bounds.low.push_back(width.value - width.error);
        bounds.high.push_back(width.value + width.error);
    }
    std::ranges::sort(bounds.low);
    std::ranges::sort(bounds.high);
    return bounds;
}

void check_same(const std::string& what, const Bounds& a, const Bounds& b) {
    CAPTURE(what);
    REQUIRE(a.low.size() == b.low.size());
    constexpr double moved = 1e-9;
    for (std::size_t i = 0; i < a.low.size(); ++i) {
        CHECK(a.low[i] <= b.high[i] + moved);
        CHECK(b.low[i] <= a.high[i] + moved);
    }
}

void check_same(const std::optional<NetworkSphere>& a, const std::optional<NetworkSphere>& b) {
    REQUIRE(a.has_value() == b.has_value());
    if (a) CHECK(std::abs(a->diameter - b->diameter) <= a->error + b->error + 1e-9);
}

}  // namespace

TEST_CASE("mixed networks: vertices and edges by brute force, and an edge for each three of four objects") {
    std::mt19937_64 rng(test_seed());
    std::size_t vertices = 0;
    for (const Family family : all_families)
        for_scenes(rng, family, long_rounds(3), [&](const DiagramScene& scene, const VoidNetwork& network) {
            check_places(scene, network);
            check_triples(network);
            vertices += network.vertices.size();
        });
    CHECK(vertices > 100);
}

TEST_CASE("mixed networks: a scene has the same where its cells are cut elsewhere") {
    std::mt19937_64 rng(test_seed());
    for (const Family family : all_families)
        for_scenes(rng, family, long_rounds(2), [&](const DiagramScene& scene, const VoidNetwork& network) {
            const VoidNetwork other = void_network(retold(rng, scene));
            const auto of_vertex = [](const NetworkVertex& v) { return Width{v.clearance, v.error}; };
            const auto bottleneck = [](const auto& e) { return Width{e.bottleneck, e.bottleneck_error}; };
            const auto length = [](const NetworkEdge& e) { return Width{e.length, e.length_error}; };
            check_same("clearances", sorted(of_vertex, network.vertices), sorted(of_vertex, other.vertices));
            check_same("bottlenecks", sorted(bottleneck, network.edges), sorted(bottleneck, other.edges));
            check_same("lengths", sorted(length, network.edges), sorted(length, other.edges));
            CHECK(network.passages.size() == other.passages.size());
            check_same(network.included, other.included);
            check_same(network.free, other.free);
            check_same(network.included_along_free, other.included_along_free);
            for (std::size_t k = 0; k < 3; ++k) check_same(network.free_along[k], other.free_along[k]);
        });
}

TEST_CASE("mixed networks: what gets through is what gets through a grid") {
    std::mt19937_64 rng(test_seed());
    const int n = rounds() > 1 ? 20 : 12;
    for (const Family family : {Family::AlongAxes, Family::Oblique, Family::BetweenPlates})
        for_scenes(rng, family, long_rounds(2), [&](const DiagramScene& scene, const VoidNetwork& network) {
            const std::array<double, 3> levels = grid_percolation(scene, n);
            for (std::size_t k = 0; k < 3; ++k) {
                if (!scene.periodic[k]) continue;
                CAPTURE(k);
                REQUIRE(network.free_along[k].has_value());
                const NetworkSphere& free = *network.free_along[k];
                CHECK(std::abs(0.5 * free.diameter - levels[k]) <= std::sqrt(3.0) / 2 / n + 0.5 * free.error);
            }
        });
}

TEST_CASE("mixed networks: parallel tubes have edges that wind, and passages between") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.periodic = {true, true, true};
    const double r = 0.2;
    scene.objects = {Cylinder{{0.25, 0.25, 0.1}, {0, 0, 1}, r}};
    const VoidNetwork square = void_network(scene);
    CHECK(square.vertices.empty());
    REQUIRE(square.edges.size() == 1);
    CHECK(square.edges[0].winds());
    CHECK(square.edges[0].sites.size() == 4);
    CHECK(square.passages.size() == 2);
    CHECK(encloses(square.included, std::numbers::sqrt2 - 2 * r));
    CHECK(encloses(square.free, std::numbers::sqrt2 - 2 * r));
    CHECK(encloses(square.included_along_free, std::numbers::sqrt2 - 2 * r));
    CHECK(encloses(square.free_along[0], 1 - 2 * r));
    CHECK(encloses(square.free_along[1], 1 - 2 * r));
    CHECK(encloses(square.free_along[2], std::numbers::sqrt2 - 2 * r));

    // Hexagons: three tubes around each edge, at two places.
    scene.box.max = {1, std::sqrt(3.0), 1};
    scene.objects = {Cylinder{{0.25, 0.25, 0}, {0, 0, 1}, r},
                     Cylinder{{0.75, 0.25 + 0.5 * std::sqrt(3.0), 0}, {0, 0, 1}, r}};
    const VoidNetwork hexagons = void_network(scene);
    CHECK(hexagons.edges.size() == 4);
    CHECK(encloses(hexagons.free_along[2], 2 / std::sqrt(3.0) - 2 * r));
    CHECK(std::abs(hexagons.free_along[0]->diameter - (1 - 2 * r)) <=
          hexagons.free_along[0]->error + 2 * hexagons.moved);
}

TEST_CASE("mixed networks: a tube between two plates lets pass what goes above it, or along it") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), {4, 4, 1}};
    scene.periodic = {true, true, false};
    const double r = 0.1, height = 0.375;
    scene.objects = {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{0, 0, 1}, {0, 0, -1}},
                     Cylinder{{1, 1, height}, {0, 1, 0}, r}};
    const VoidNetwork network = void_network(scene);
    CHECK(network.vertices.empty());
    CHECK(network.edges.size() == 2);
    CHECK(network.passages.size() == 3);
    CHECK(encloses(network.free_along[0], 1 - height - r));
    CHECK(encloses(network.free_along[1], 1));
    CHECK(!network.free_along[2]);
}

TEST_CASE("mixed networks: cells that have been changed do not agree, and what is cut does not go on") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.periodic = {true, true, true};
    scene.objects = {Cylinder{{0.3, 0.2, 0}, {0, 0, 1}, 0.05}, Cylinder{{0, 0.7, 0.4}, {1, 0, 0}, 0.1},
                     Cylinder{{0.8, 0, 0.9}, {0, 1, 0}, 0.1}};
    enum class Change { None, CutMoved, EdgeLost, VertexLost };
    for (const Change change : {Change::None, Change::CutMoved, Change::EdgeLost, Change::VertexLost}) {
        CAPTURE(static_cast<int>(change));
        VoidNetworkBuilder builder(scene);
        bool is_changed = false;
        DiagramOptions options;
        options.complete = true;
        options.visit = [&](std::uint32_t object, const Cell& cell) {
            Cell changed = cell;
            const auto is_of_objects = [](const CellEdge& e) {
                return e.sites[0].is_object() && e.sites[1].is_object() && !e.vertices.empty();
            };
            const auto is_cut = [](const CellVertex& v) {
                return std::ranges::any_of(v.sites, [](const Site& s) { return !s.is_object(); });
            };
            for (CellEdge& e : changed.edges) {
                if (is_changed || !is_of_objects(e)) continue;
                CellVertex& v = changed.vertices[e.vertices.front()];
                if (change == Change::CutMoved && is_cut(v)) {
                    v.point += Vec3::Constant(1e-3);
                    is_changed = true;
                } else if (change == Change::EdgeLost && object == 1 && !is_cut(v)) {
                    e.sites[0] = Site::box_side(0);
                    is_changed = true;
                } else if (change == Change::VertexLost && object == 1 && !is_cut(v)) {
                    v.sites = {Site::box_side(0), Site::box_side(1)};
                    e.sites[0] = Site::box_side(0);
                    for (CellEdge& other : changed.edges)
                        if (std::ranges::find(other.vertices, e.vertices.front()) != other.vertices.end())
                            other.sites[0] = Site::box_side(0);
                    is_changed = true;
                }
            }
            builder.add(object, changed);
        };
        const VoronoiDiagram diagram = voronoi_diagram(scene, options);
        REQUIRE(is_whole(diagram));
        CHECK(is_changed == (change != Change::None));
        if (change == Change::None)
            CHECK_NOTHROW(builder.finish(diagram));
        else
            CHECK_THROWS_AS(builder.finish(diagram), UndecidedError);
    }
}

TEST_CASE("mixed networks: a tube that is not complete has none") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.objects = {Sphere{{0.5, 0.5, 0.5}, 0.1}, Cylinder{{0.2, 0.2, 0}, {0, 0, 1}, 0.05}};
    VoidNetworkBuilder builder(scene);
    DiagramOptions options;
    options.visit = [&](std::uint32_t object, const Cell& cell) { builder.add(object, cell); };
    const VoronoiDiagram diagram = voronoi_diagram(scene, options);
    CHECK_THROWS_AS(builder.finish(diagram), InputError);
}

}  // namespace vcell::mixed_network_test
