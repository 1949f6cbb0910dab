// certify() on diagrams as files have them: whole ones, and damaged ones.
#include <doctest/doctest.h>

#include <random>
#include <sstream>

#include "../../core/errors.hpp"
#include "../test_support.hpp"
#include "stored_diagrams.hpp"

using namespace vcell;

namespace {

DiagramScene random_balls(std::mt19937_64& rng, int count) {
    std::uniform_real_distribution<double> at(-1, 1), radius(0.05, 0.4);
    DiagramScene scene;
    scene.box = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}};
    for (int i = 0; i < count; ++i) scene.objects.push_back(Sphere{{at(rng), at(rng), at(rng)}, radius(rng)});
    // One in another, and one twice.
    scene.objects.push_back(Sphere{std::get<Sphere>(scene.objects[0]).center, 0.01});
    scene.objects.push_back(scene.objects[1]);
    scene.names = {"first"};
    scene.names.resize(scene.objects.size());
    return scene;
}

}  // namespace

TEST_CASE("check of a diagram: cells of random balls are proved, and fill their box") {
    std::mt19937_64 rng(test_seed());
    const std::string text = text_of(random_balls(rng, 12));
    const auto diagram = parse_diagram(text);
    REQUIRE(diagram);
    const Certificate certificate = certify(*diagram);
    check_proved(certificate);
    std::ostringstream alone, together;
    write_certificate(alone, certificate);
    write_certificate(together, certify(*diagram, {}, 3));
    CHECK(alone.str() == together.str());
}

TEST_CASE("check of a diagram: what is damaged is objected to") {
    std::mt19937_64 rng(test_seed() + 1);
    const StoredDiagram whole = *parse_diagram(text_of(random_balls(rng, 12)));
    StoredDiagram d = whole;
    Cell& cell = d.cells[2].second;
    const std::string name = "cells[" + std::to_string(d.cells[2].first) + "]";
    SUBCASE("a vertex") {
        cell.vertices[0].point.x() += 1e-3;
        const Certificate c = certify(d);
        CHECK(objects_to(c, name + ".vertices[0]"));
        CHECK(objects_to(c, "pairs["));
    }
    SUBCASE("a volume") {
        cell.measures.volume *= 1.001;
        const Certificate c = certify(d);
        CHECK(objects_to(c, name + ".measures"));
        CHECK(objects_to(c, "volume"));
    }
    SUBCASE("a clearance that hides what is near") {
        cell.measures.max_clearance *= 0.01;
        CHECK(objects_to(certify(d), name));
    }
    SUBCASE("a face that only one of two cells has") {
        for (std::size_t i = 0; i < cell.faces.size(); ++i)
            if (cell.faces[i].site.is_object()) {
                cell.faces.erase(cell.faces.begin() + static_cast<std::ptrdiff_t>(i));
                break;
            }
        const Certificate c = certify(d);
        CHECK(objects_to(c, name));
        CHECK(objects_to(c, "pairs["));
    }
    SUBCASE("a cell that is not there") {
        d.cells.erase(d.cells.begin() + 2);
        const Certificate c = certify(d);
        CHECK(objects_to(c, name));
        CHECK(objects_to(c, "volume"));
    }
    SUBCASE("an object that has moved") {
        std::get<Sphere>(d.scene.objects[d.cells[2].first]).center.x() += 1e-3;
        CHECK(objects_to(certify(d), name));
    }
    SUBCASE("an object that nobody has looked at") {
        d.scene.objects.push_back(Sphere{d.cells[2].second.vertices[0].point, 0.001});
        d.scene.names.push_back("");
        const Certificate c = certify(d);
        CHECK(objects_to(c, "cells[" + std::to_string(d.scene.objects.size() - 1) + "]"));
    }
}

TEST_CASE("check of a diagram: cells that end at a probe are proved, and refuted where they are damaged") {
    std::mt19937_64 rng(test_seed() + 2);
    std::uniform_real_distribution<double> off(-0.05, 0.05);
    DiagramScene scene;
    scene.box = {Vec3::Constant(-1.5), Vec3::Constant(1.5)};
    for (int i = 0; i < 8; ++i)
        scene.objects.push_back(Sphere{{(i & 1 ? 0.4 : -0.4) + off(rng), (i & 2 ? 0.4 : -0.4) + off(rng),
                                        (i & 4 ? 0.4 : -0.4) + off(rng)},
                                       0.35 + off(rng)});
    scene.probe = 0.25;
    // Beyond the box: within the probe's reach of a side, out of it, and out of it towards a corner.
    const auto beyond = static_cast<std::uint32_t>(scene.objects.size());
    scene.objects.push_back(Sphere{{0, 0, 1.75}, 0.125});
    scene.objects.push_back(Sphere{{0, 1, 1.9}, 0.125});
    scene.objects.push_back(Sphere{{1.75, 1.75, 1.75}, 0.125});
    const std::string text = text_of(scene);
    StoredDiagram whole = *parse_diagram(text);
    CHECK(whole.scene.probe == scene.probe);
    REQUIRE(whole.lacking.size() == 1);
    CHECK(whole.lacking[0].object == beyond);
    const Certificate good = certify(whole);
    check_proved(good);
    CHECK(has_verdict(good, "cells[" + std::to_string(beyond + 1) + "]", Verdict::proved));
    CHECK(has_verdict(good, "cells[" + std::to_string(beyond + 2) + "]", Verdict::proved));
    const auto capped = std::ranges::find_if(whole.cells, [](const auto& c) {
        return std::ranges::any_of(c.second.faces, [](const CellFace& f) { return f.site == Site::cap(); });
    });
    REQUIRE(capped != whole.cells.end());
    const std::string name = "cells[" + std::to_string(capped->first) + "]";
    SUBCASE("another probe") {
        *whole.scene.probe *= 1 + 1e-4;
        CHECK(has_verdict(certify(whole), name, Verdict::refuted));
    }
    SUBCASE("none") {
        whole.scene.probe.reset();
        CHECK(objects_to(certify(whole), name));
    }
    SUBCASE("one that gets to the ball beyond the corner") {
        std::get<Sphere>(whole.scene.objects[beyond + 2]).radius = 0.2;
        CHECK(objects_to(certify(whole), "cells[" + std::to_string(beyond + 2) + "]"));
    }
    SUBCASE("a volume of more than the box") {
        capped->second.measures.volume += 27;
        CHECK(objects_to(certify(whole), "volume"));
    }
}

TEST_CASE("check of a diagram: a probe ends cells of planes and tubes, and such in boxes that repeat") {
    DiagramScene scene;
    scene.box = {Vec3::Constant(-1), Vec3::Constant(1)};
    scene.objects = {Plane{{0, 0, -0.9}, {0, 0, 1}}, Cylinder{{0, 0.5, 0}, {1, 0, 0}, 0.125},
                     Sphere{{0, -0.375, 0}, 0.25}};
    scene.probe = 0.5;
    check_proved(certify(stored(scene, true)));
    scene.objects = {Sphere{{0, 0, 0}, 0.25}, Sphere{{0.75, 0.5, 0.875}, 0.125}};
    scene.periodic = {true, true, false};
    check_proved(certify(stored(scene)));
}

// The vertex is one of both tubes that touch each other's caps, and of the third one's cap: in the cells of
// the two an edge runs through it. Likewise of the balls: the two images of a ball touch each other's caps
// there.
TEST_CASE("check of a diagram: caps may touch where only one of two cells has a vertex") {
    DiagramScene scene;
    scene.probe = 0.5;
    scene.box = {Vec3::Constant(-0.5), Vec3::Constant(2.5)};
    scene.objects = {Cylinder{{0, 2, 0}, {1, 0, 0}, 0.5}, Cylinder{{2, 0, 1}, {0, 1, 0}, 0.5},
                     Cylinder{{0, 2, 2}, {1, 0, 0}, 0.5}};
    SUBCASE("tubes") {}
    SUBCASE("images of balls") {
        scene.probe = 1;
        scene.box = {Vec3::Zero(), Vec3(4, 2, 4)};
        scene.periodic = {true, true, true};
        scene.objects = {Sphere{{1.5, 1, 3}, 0.5}, Sphere{{0.5, 2, 3.5}, 1}};
    }
    check_proved(certify(stored(scene, !scene.is_periodic())));
}

TEST_CASE("check of a diagram: tubes and planes that others hold own nothing") {
    DiagramScene scene;
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Cylinder{{0, 0.5, 0}, {1, 0, 0}, 0.25},
                     Cylinder{{1, 0.5, 0}, {-2, 0, 0}, 0.25},
                     Cylinder{{0, 0.5, 0.125}, {1, 0, 0}, 0.125},
                     Sphere{{1, 0.5, 0}, 0.25},
                     Plane{{0, 0, 1.5}, {0, 0, 1}},
                     Plane{{1, 1, 1.5}, {0, 0, -3}},
                     Cylinder{{0, 1, 1.5}, {1, 1, 0}, 0},
                     Sphere{{0, -1, 0}, 0.5},
                     Sphere{{0.5, -1, -1}, 0.25}};
    const StoredDiagram whole = stored(scene, true);
    CHECK(whole.lacking.empty());
    const Certificate good = certify(whole);
    check_proved(good);
    CHECK(good.elements.back().what.find("no cell here") == std::string::npos);
    for (const std::uint32_t hidden : {1, 2, 3, 5, 6})
        CHECK(has_verdict(good, "cells[" + std::to_string(hidden) + "]", Verdict::proved));
    StoredDiagram moved = whole;
    std::get<Cylinder>(moved.scene.objects[2]).point.z() = 0.126;
    const Certificate bad = certify(moved);
    CHECK_FALSE(has_verdict(bad, "cells[2]", Verdict::proved));
    CHECK_FALSE(bad.holds());
}

TEST_CASE("diagram file: what is none, or without balls, is refused") {
    CHECK_FALSE(parse_diagram(R"({"vcell": 1, "scene": {}})"));
    const auto path_of = [](const std::string& text) {
        try {
            parse_diagram(text);
        } catch (const InputError& e) {
            return e.path;
        }
        return std::string("none");
    };
    const std::string box = R"("box": {"min": [0, 0, 0], "max": [1, 1, 1]}})";
    CHECK(path_of(R"({"vcell": 1, "diagram": {"objects": [], )" + box + R"(, "cells": []})") == "objects");
    CHECK(path_of(R"({"vcell": 1, "diagram": {"objects": [], "colour": 1, )" + box + R"(, "cells": []})") ==
          "diagram.colour");
    CHECK(path_of(R"({"vcell": 1, "diagram": {"objects": [{"sphere": {"center": [0, 0, 0], "radius": 1}}], )"
                  R"("probe": -1, )" +
                  box + R"(, "cells": []})") == "probe");
}
