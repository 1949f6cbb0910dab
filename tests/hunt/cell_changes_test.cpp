// Cells of changed scenes, against those of the same scenes from scratch.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "../../core/errors.hpp"
#include "../../envelope/cell_changes.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../../io/check/check.hpp"
#include "families.hpp"
#include "test_support.hpp"

namespace vcell::cell_changes_test {
using namespace vcell::hunt;

namespace {

std::optional<Cell> cell_of(const Scene& scene) {
    try {
        return voronoi_cell(scene);
    } catch (const UndecidedError&) {
        return std::nullopt;
    }
}

Scene without(Scene scene, std::size_t object) {
    scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(object));
    if (object < scene.names.size())
        scene.names.erase(scene.names.begin() + static_cast<std::ptrdiff_t>(object));
    return scene;
}

// What names an element whatever its number: its sites.
std::vector<Site> named(std::vector<Site> sites) {
    std::ranges::sort(sites);
    return sites;
}
template <class Sites>
std::vector<Site> named(const Sites& sites, const std::vector<Site>& more) {
    std::vector<Site> all(sites.begin(), sites.end());
    all.insert(all.end(), more.begin(), more.end());
    return named(std::move(all));
}

// One measure with its error under the element's name.
struct Measured {
    std::vector<Site> sites;
    double value, error;

    friend bool operator<(const Measured& a, const Measured& b) {
        return a.sites != b.sites ? a.sites < b.sites : a.value < b.value;
    }
};

struct Elements {
    std::vector<Measured> vertices, edges, faces;

    // Vertices are told apart by their place alone where their sites are not to be compared.
    Elements(const Cell& cell, bool have_vertices_names) {
        for (const CellVertex& v : cell.vertices)
            vertices.push_back(
                {have_vertices_names ? named(v.sites, {}) : std::vector<Site>(), v.point.sum(), 2 * v.error});
        for (const CellEdge& e : cell.edges)
            edges.push_back({named(e.sites, e.extra_sites), e.length, e.length_error});
        for (const CellFace& f : cell.faces)
            faces.push_back({named(std::array{f.site}, f.extra_sites), f.area, f.area_error});
        for (auto* list : {&vertices, &edges, &faces}) std::sort(list->begin(), list->end());
    }
};

// How the cells differ, beyond their errors; empty if not at all.
std::string difference(const std::vector<Measured>& a, const std::vector<Measured>& b, double slack) {
    if (a.size() != b.size()) return std::to_string(a.size()) + " and " + std::to_string(b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i].sites != b[i].sites) return "sites of number " + std::to_string(i);
        if (!(std::abs(a[i].value - b[i].value) <= a[i].error + b[i].error + slack))
            return std::to_string(a[i].value) + " and " + std::to_string(b[i].value);
    }
    return {};
}
std::string difference(const Cell& a, const Cell& b) {
    // Estimated errors and the ends' rounding, in the box's unit.
    const double size = a.scene.box.diagonal(), rounding = 1e-9 * size;
    // A coincidence that was taken for granted may name an object that is farther by less than its width: one
    // that owns nothing there, and that a cell of fewer objects has left out for certain.
    const bool have_names = a.report.decisions.assumed == 0 && b.report.decisions.assumed == 0;
    const Elements p(a, have_names), q(b, have_names);
    if (const auto d = difference(p.vertices, q.vertices, rounding); !d.empty()) return "vertices: " + d;
    if (const auto d = difference(p.edges, q.edges, rounding); !d.empty()) return "edges: " + d;
    if (const auto d = difference(p.faces, q.faces, rounding * size); !d.empty()) return "faces: " + d;
    if (!(std::abs(a.measures.volume - b.measures.volume) <=
          a.measures.volume_error + b.measures.volume_error + rounding * size * size))
        return "volumes";
    if (a.scene.objects != b.scene.objects) return "objects";
    std::vector<std::uint32_t> m = a.neighbors, n = b.neighbors;
    std::ranges::sort(m);
    std::ranges::sort(n);
    return m == n ? "" : "neighbours";
}

struct Count {
    int compared = 0, refused = 0;
};

// Calls changed(scene, cell of it, rng) -> {changed cell, scene from scratch} for scenes of the families over
// every base.
template <class Change>
Count compare(std::initializer_list<const char*> names, Change&& change) {
    std::mt19937_64 rng(test_seed());
    Count count;
    auto turn = rng() % 2;  // once round takes every other pair of a family and a base
    for (const char* name : names)
        for (const BaseKind base : base_kinds)
            for (int round = 0; round < rounds(); ++round) {
                if (rounds() == 1 && turn++ % 2 == 0) continue;
                const auto family = std::ranges::find(families(), std::string(name), &Family::name);
                const Scene scene = family->make(rng, base);
                if (scene.base_object || scene.objects.size() < 3 || !is_legal(scene)) continue;
                CAPTURE(std::string(name));
                CAPTURE(to_string(base));
                CAPTURE(round);
                try {
                    const auto [changed, expected] = change(scene, rng);
                    const std::optional<Cell> scratch = cell_of(expected);
                    if (!scratch) {
                        ++count.refused;
                        continue;
                    }
                    ++count.compared;
                    CHECK(difference(changed, *scratch) == "");
                } catch (const UndecidedError&) {
                    ++count.refused;
                }
            }
    return count;
}

std::size_t any_object(const Scene& scene, std::mt19937_64& rng) {
    return std::uniform_int_distribution<std::size_t>(0, scene.objects.size() - 1)(rng);
}

}  // namespace

TEST_CASE("insert: the cell of the scene with the object, over every base") {
    const Count count =
        compare({"balls", "mix", "tubes", "integers", "lattice", "bundle", "symmetric", "vessels", "silos"},
                [](const Scene& scene, std::mt19937_64& rng) {
                    const std::size_t i = any_object(scene, rng);
                    const Object object = scene.objects[i];
                    Scene fewer = without(scene, i), more = fewer;
                    more.objects.push_back(object);
                    more.names.clear();
                    fewer.names.clear();
                    return std::pair{insert(voronoi_cell(fewer), object), more};
                });
    CHECK(count.compared >= 10 * rounds());
    CHECK(count.refused <= 10 * rounds());
}

TEST_CASE("remove: the cell of the scene without the object, over every base") {
    const Count count = compare(
        {"balls", "mix", "tubes", "integers", "lattice", "bundle", "symmetric", "vessels", "silos"},
        [](const Scene& scene, std::mt19937_64& rng) {
            Cell cell = voronoi_cell(scene);
            // Rather one that matters.
            std::size_t i = any_object(scene, rng);
            if (!cell.neighbors.empty() && rng() % 4 != 0) i = cell.neighbors[rng() % cell.neighbors.size()];
            return std::pair{remove(std::move(cell), static_cast<std::uint32_t>(i)), without(scene, i)};
        });
    CHECK(count.compared >= 10 * rounds());
    CHECK(count.refused <= 10 * rounds());
}

TEST_CASE("merge: the cell among the objects of both, over every base") {
    const Count count =
        compare({"balls", "mix", "tubes", "integers", "lattice", "bundle", "symmetric", "vessels", "silos"},
                [](const Scene& scene, std::mt19937_64&) {
                    Scene first = scene, second = scene;
                    first.names.clear();
                    second.names.clear();
                    const auto half = static_cast<std::ptrdiff_t>(scene.objects.size() / 2);
                    first.objects.erase(first.objects.begin() + half, first.objects.end());
                    second.objects.erase(second.objects.begin(), second.objects.begin() + half);
                    return std::pair{merge(voronoi_cell(first), voronoi_cell(second)), scene};
                });
    CHECK(count.compared >= 10 * rounds());
    CHECK(count.refused <= 10 * rounds());
}

TEST_CASE("remove: a cell that the others leave within its own body") {
    // Object 0 is nearest where object 2 was. Clearances are negative everywhere, with either.
    Scene scene;
    scene.base = Sphere{{2, 2, 5}, 3};
    scene.objects = {Cylinder{{3, 6, 7}, {0, 0, 1}, 3}, Cylinder{{1, 2, 0}, {0, 0, -1}, 3},
                     Cylinder{{3, 4, 7}, {0, 0, 1}, 2}, Sphere{{3, 5, 2}, 2}};
    scene.box = {{-2, 1, 0}, {3, 4, 7}};
    for (const std::uint32_t i : {0u, 1u, 2u, 3u}) {
        CAPTURE(i);
        const Cell scratch = voronoi_cell(without(scene, i));
        CHECK(difference(remove(voronoi_cell(scene), i), scratch) == "");
    }
    // And a ball outside the box that is no farther from it than the base's surface is from its centre.
    scene.objects = {Sphere{{-1.5, 2.5, 5}, 3}, Sphere{{5.5, 2.5, 5}, 3}, Sphere{{-2.5, 2.5, 5}, 3.5}};
    scene.box = {{0, 0, 0}, {4, 5, 9}};
    for (const std::uint32_t i : {0u, 1u, 2u}) {
        CAPTURE(i);
        const Cell scratch = voronoi_cell(without(scene, i));
        CHECK(difference(remove(voronoi_cell(scene), i), scratch) == "");
    }
}

TEST_CASE("insert, remove and merge: what rays of complete cells end at before they come into the box") {
    // Object 3 owns all that the plane would in the corner (0, 2, 8), and shows nowhere on the plane's cell.
    Scene scene;
    scene.base = Plane{{3, 0, 1}, {1, 1, 1}};
    scene.objects = {Sphere{{0, 5, 3}, 2}, Sphere{{8, 8, 8}, 2}, Sphere{{3, 7, 4}, 2}, Sphere{{4, 3, 8}, 2}};
    scene.box = {{0, 2, 0}, {3, 12, 8}};
    const Sphere another{{3, 8, 0}, 0};
    Scene more = scene;
    more.objects.emplace_back(another);
    CellOptions complete;
    complete.complete = true;
    const Cell cell = voronoi_cell(scene, complete), scratch = voronoi_cell(more, complete);
    CHECK(std::ranges::find(cell.neighbors, 3) == cell.neighbors.end());
    CHECK(difference(insert(cell, another), scratch) == "");
    // A cell that is not complete becomes one.
    CHECK(difference(insert(voronoi_cell(scene), another, complete), scratch) == "");
    Scene fewer = scene;
    fewer.objects = {another};
    CHECK(difference(merge(cell, voronoi_cell(fewer)), scratch) == "");
    const Cell revealed = remove(cell, 3);
    CHECK(revealed.is_complete);
    CHECK(difference(revealed, voronoi_cell(without(scene, 3), complete)) == "");
    CHECK(revealed.measures.volume > cell.measures.volume + 0.01);
}

TEST_CASE("insert, remove and merge: cells of whole diagrams become cells of scenes of their own") {
    for (const bool repeats : {false, true}) {
        CAPTURE(repeats);
        DiagramScene scene;
        std::mt19937_64 rng(test_seed());
        std::uniform_real_distribution<double> place(0, 4);
        for (int i = 0; i < 40; ++i)
            scene.objects.emplace_back(Sphere{Vec3(place(rng), place(rng), place(rng)), 0.1});
        scene.box = {Vec3::Zero(), Vec3::Constant(4)};
        scene.periodic = {repeats, repeats, repeats};
        std::vector<Cell> cells;
        DiagramOptions options;
        options.visit = [&](std::uint32_t, const Cell& cell) { cells.push_back(cell); };
        voronoi_diagram(scene, options);
        const Cell& cell = cells.back();
        REQUIRE(cell.scene.objects.size() < cell.scene.numbers.size() + cell.scene.images.size() + 1);
        CHECK(certify(cell).holds());
        Scene own = cell.scene;
        own.numbers.clear();
        own.images.clear();
        const auto near_base = [&](double r) {
            const Sphere& base = std::get<Sphere>(own.base);
            return Sphere{base.center + Vec3(base.radius + r + 0.01, 0, 0), r};
        };
        const Object added = near_base(0.05);
        Scene more = own;
        more.objects.push_back(added);
        more.names.clear();
        own.names.clear();
        CHECK(difference(insert(cell, added), voronoi_cell(more)) == "");

        const std::uint32_t neighbor = cell.neighbors.front();
        const std::size_t removed = cell.scene.place(neighbor);
        CHECK(difference(remove(cell, neighbor), voronoi_cell(without(own, removed))) == "");
        CHECK_THROWS_AS(remove(cell, 1000), InputError);
        // What is no neighbour leaves the others with their places.
        for (std::size_t i = 0; i < own.objects.size(); ++i)
            if (std::ranges::find(cell.neighbors, cell.scene.number(i)) == cell.neighbors.end()) {
                CHECK(difference(remove(cell, cell.scene.number(i)), voronoi_cell(without(own, i))) == "");
                break;
            }

        Scene twice = own;
        twice.objects.insert(twice.objects.end(), own.objects.begin(), own.objects.end());
        CHECK(difference(merge(cell, cell), voronoi_cell(twice)) == "");
    }
}

TEST_CASE("insert, remove and merge: what they are not given is named") {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 1};
    scene.objects = {Sphere{{4, 0, 0}, 1}, Sphere{{-4, 0, 0}, 1}, Sphere{{-9, 0, 0}, 0.5}};
    scene.names = {"east", "west", "beyond"};
    scene.box = {Vec3::Constant(-10), Vec3::Constant(10)};
    const Cell cell = voronoi_cell(scene);

    SUBCASE("objects keep their numbers in messages, whichever are looked at") {
        // Object 2 is no neighbour and not looked at; the new one is number 3.
        CHECK_THROWS_WITH_AS(insert(cell, Sphere{{0.5, 0, 0}, 0.25}), doctest::Contains("objects[3].sphere"),
                             InputError);
        const Cell twice = insert(cell, Sphere{{-4, 0, 0}, 1});
        REQUIRE(twice.report.warnings.size() == 1);
        CHECK(twice.report.warnings[0].find("object 1 (west) and object 3: ") == 0);
        CHECK(twice.scene.names == std::vector<std::string>{"east", "west", "beyond", ""});
        CHECK(twice.neighbors.size() == 3);
    }
    SUBCASE("an object that is no neighbour leaves without a trace") {
        const Cell fewer = remove(cell, 2);
        CHECK(fewer.scene.objects.size() == 2);
        CHECK(fewer.measures.volume == cell.measures.volume);
        const Cell first = remove(remove(cell, 1), 0);  // number 2 is number 0 then, and a neighbour
        CHECK(first.neighbors == std::vector<std::uint32_t>{0});
        CHECK_THROWS_AS(remove(cell, 3), InputError);
    }
    SUBCASE("cells of different bases or boxes") {
        Scene other = scene;
        other.base = Sphere{{0, 0, 0}, 1.5};
        CHECK_THROWS_WITH_AS(merge(cell, voronoi_cell(other)), doctest::Contains("base"), InputError);
        other.base = scene.base;
        other.box.max.x() = 11;
        CHECK_THROWS_WITH_AS(merge(cell, voronoi_cell(other)), doctest::Contains("box"), InputError);
        other = scene;
        other.units = "A";
        CHECK_THROWS_WITH_AS(merge(cell, voronoi_cell(other)), doctest::Contains("units"), InputError);
    }
    SUBCASE("a base that is one of the objects") {
        scene.objects.insert(scene.objects.begin() + 1, scene.base);
        scene.names.clear();
        scene.base_object = 1;
        const Cell own = voronoi_cell(scene);
        CHECK_THROWS_AS(remove(own, 1), InputError);
        CHECK(remove(own, 0).scene.base_object == 0);
        const Cell both = merge(own, own);
        CHECK(both.scene.objects.size() == 7);
        CHECK(both.neighbors.size() == 2 * own.neighbors.size());
    }
}

}  // namespace vcell::cell_changes_test
