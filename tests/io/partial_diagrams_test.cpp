// Diagrams of which some cells are lacking, and of cells that moved apart by roundings as they were decided
// about: small integers, where most ties are.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../test_support.hpp"
#include "stored_diagrams.hpp"

namespace vcell::partial_diagrams_test {

namespace {

const Box room{Vec3::Zero(), Vec3::Constant(8)};

DiagramScene among(std::vector<Object> objects) {
    DiagramScene scene;
    scene.objects = std::move(objects);
    scene.box = room;
    return scene;
}

// Planes that cut each other and two of the balls.
const DiagramScene cut =
    among({Plane{{0, 8, 0}, {0, -1, -1}}, Plane{{6, 0, 8}, {0, 1, -1}}, Sphere{{4, 4, 5}, 1},
           Sphere{{6, 2, 7}, 0.5}, Plane{{1, 2, 4}, {-1, 0, 1}}, Sphere{{3, 6, 6}, 0.5}});

Vec3 direction(std::mt19937_64& rng) {
    std::uniform_int_distribution<int> part(-1, 1);
    while (true) {
        const int x = part(rng), y = part(rng), z = part(rng);
        if (x != 0 || y != 0 || z != 0) return {double(x), double(y), double(z)};
    }
}

DiagramScene random_integers(std::mt19937_64& rng) {
    std::uniform_int_distribution<int> kind(0, 9), place(1, 7), half(0, 2), count(2, 5);
    std::vector<Object> objects;
    for (int left = count(rng); left > 0; --left) {
        const int x = place(rng), y = place(rng), z = place(rng), k = kind(rng);
        const Vec3 p(x, y, z);
        if (k < 6)
            objects.push_back(Sphere{p, 0.5 * half(rng)});
        else if (k < 8)
            objects.push_back(Plane{p, direction(rng)});
        else
            objects.push_back(Cylinder{p, direction(rng), 0.5});
    }
    return among(std::move(objects));
}

}  // namespace

TEST_CASE("check of a diagram: what has no cell competes all the same, and is named") {
    const StoredDiagram diagram = stored(cut, true);
    std::vector<std::uint32_t> lacking;
    for (const auto& l : diagram.lacking) {
        lacking.push_back(l.object);
        CHECK(l.reason.find("plane") != std::string::npos);
    }
    CHECK(lacking == std::vector<std::uint32_t>{0, 1, 2, 4, 5});
    REQUIRE(diagram.cells.size() == 1);
    const Cell& cell = diagram.cells.front().second;
    CHECK(std::ranges::any_of(cell.faces, [&](const CellFace& f) {
        return f.site.is_object() && cell.scene.images[f.site.index].number == 2;
    }));
    check_proved(certify(diagram));
    // A ball that is said to have a cell is to have one.
    StoredDiagram claiming = diagram;
    std::erase_if(claiming.lacking, [](const auto& l) { return l.object == 2; });
    CHECK(has_verdict(certify(claiming), "cells[2]", Verdict::refuted));
    // A ball in another one is no competitor, said to be lacking or not.
    StoredDiagram with_another = diagram;
    with_another.scene.objects.push_back(Sphere{{6, 2, 7}, 0.25});
    with_another.scene.names.resize(with_another.scene.objects.size());
    with_another.lacking.push_back({6, "lies in another one"});
    check_proved(certify(with_another));
}

TEST_CASE("diagram file: what it lacks are objects, ascending") {
    const std::string text = text_of(cut, true);
    const auto path_of = [&](const std::string& from, const std::string& to) {
        std::string changed = text;
        changed.replace(changed.find(from, changed.find("\"lacking\"")), from.size(), to);
        try {
            parse_diagram(changed);
        } catch (const InputError& e) {
            return e.path;
        }
        return std::string();
    };
    CHECK(path_of("\"object\":5", "\"object\":6") == "lacking");
    CHECK(path_of("\"object\":4", "\"object\":1").starts_with("lacking"));
}

TEST_CASE("check of a diagram: a vertex that only one cell has lies on the other one's edge") {
    StoredDiagram diagram;
    // The bisector of the planes and a ball pass through an edge of the box.
    SUBCASE("two planes that lean") {
        diagram = stored(among({Plane{{7, 2, 8}, {-1, 1, -1}}, Plane{{1, 0, 2}, {-1, -1, -1}},
                                Sphere{{5, 1, 5}, 1}, Sphere{{1, 5, 3}, 1}, Sphere{{5, 4, 7}, 0.5}}),
                         true);
    }
    // That of the ball and the oblique tube touches one.
    SUBCASE("a tube that leans") {
        diagram = stored(among({Sphere{{2, 3, 7}, 1}, Cylinder{{1, 3, 5}, {0, 0, 1}, 0.5},
                                Cylinder{{3, 5, 6}, {1, 1, -1}, 1}, Cylinder{{6, 5, 5}, {1, 1, 0}, 1},
                                Sphere{{6, 2, 3}, 0}}),
                         true);
    }
    check_proved(certify(diagram));
    // Where nothing moved they are to have the same vertices.
    StoredDiagram still = diagram;
    for (auto& [object, cell] : still.cells) cell.report.moved = 0;
    CHECK(has_verdict(certify(still), "pairs[", Verdict::refuted));
}

TEST_CASE("check of a diagram: nothing is refuted among objects in small integers that cut each other") {
    std::mt19937_64 rng(test_seed());
    std::size_t cells = 0;
    for (int k = 0; k < 8 * rounds(); ++k) {
        const StoredDiagram diagram = stored(random_integers(rng), true);
        cells += diagram.cells.size();
        for (const Element& e : certify(diagram).elements) {
            CAPTURE(e.where);
            CAPTURE(e.what);
            CHECK(e.verdict != Verdict::refuted);
        }
    }
    CHECK(cells > 4);
}

}  // namespace vcell::partial_diagrams_test
