// certify() on diagrams of balls among vessels, planes and tubes, as files have them: whole ones, and damaged
// ones.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "../../core/errors.hpp"
#include "../../io/files/diagram_file.hpp"
#include "../test_support.hpp"
#include "stored_diagrams.hpp"

using namespace vcell;

namespace {

// Eight balls about the origin, each in an octant of its own: no cell reaches around an axis.
std::vector<Object> in_octants(std::mt19937_64& rng) {
    std::uniform_real_distribution<double> at(0.45, 0.7), radius(0.2, 0.4);
    std::vector<Object> balls;
    for (int k = 0; k < 8; ++k) {
        const auto sign = [&](int bit) { return (k >> bit) % 2 == 0 ? 1.0 : -1.0; };
        balls.push_back(Sphere{{sign(0) * at(rng), sign(1) * at(rng), sign(2) * at(rng)}, radius(rng)});
    }
    return balls;
}

DiagramScene scene_with(std::vector<Object> balls, const std::vector<Object>& others) {
    DiagramScene scene;
    scene.objects = std::move(balls);
    scene.objects.insert(scene.objects.begin() + 3, others.begin(), others.end());
    scene.box = {Vec3::Constant(-1.5), Vec3::Constant(1.5)};
    return scene;
}

const Object round_wall = HollowSphere{{0, 0.0625, 0}, 1.75};
const Object tube_wall = HollowCylinder{{0, 0, 0.5}, {0.125, 0, 1}, 1.625};
const Object cone_wall = HollowCone{{0.125, 0, -3}, {0.0625, 0, 1}, 3, 5};
const Object flat_wall = Plane{{0, 0, -1.25}, {0, 0.125, 1}};
const Object fibre = Cylinder{{0, 0, 0}, {0, 0.0625, 1}, 0.125};

std::size_t wall_faces(const StoredDiagram& diagram) {
    std::size_t faces = 0;
    for (const auto& [object, cell] : diagram.cells)
        for (const CellFace& f : cell.faces)
            faces += f.site.is_object() && !std::holds_alternative<Sphere>(
                                               diagram.scene.objects[cell.scene.images[f.site.index].number]);
    return faces;
}

}  // namespace

TEST_CASE("check of a diagram with walls: silos, rooms and fibres are proved") {
    std::vector<const char*> names{"vessel", "room", "ball_tube_plane", "four_balls_two_planes"};
    if (rounds() > 1) names.insert(names.end(), {"hopper", "silo"});
    for (const char* name : names) {
        CAPTURE(name);
        const StoredDiagram diagram =
            stored(read_diagram_scene(VCELL_EXAMPLE_SCENES "/" + std::string(name) + ".json"));
        CHECK(wall_faces(diagram) > 0);
        const Certificate certificate = certify(diagram);
        check_proved(certificate);
        CHECK(certificate.elements.back().what.find("no balls") != std::string::npos);
    }
}

TEST_CASE("check of a diagram with walls: nothing is refuted among random balls, and little is left open") {
    std::mt19937_64 rng(test_seed());
    std::vector<Object> others;
    SUBCASE("in a sphere") { others = {round_wall}; }
    SUBCASE("in a tube, with a floor") { others = {tube_wall, flat_wall}; }
    SUBCASE("in a cone, with a floor") { others = {cone_wall, flat_wall}; }
    SUBCASE("about a fibre") { others = {fibre}; }
    const StoredDiagram diagram = stored(scene_with(in_octants(rng), others));
    CHECK(diagram.cells.size() == 8);
    CHECK(wall_faces(diagram) > 0);
    // Integrals of faces that are large as seen from their ball may stay open (docs/promises.md).
    for (const Element& e : certify(diagram, {50, 1, 6}).elements) {
        const bool is_integral = e.what.find("enclosed") != std::string::npos;
        CAPTURE(e.where);
        CAPTURE(e.what);
        CHECK((e.verdict == Verdict::proved || (e.verdict == Verdict::open && is_integral)));
    }
}

TEST_CASE("check of a diagram with walls: what is damaged is objected to") {
    std::mt19937_64 rng(test_seed() + 1);
    // A ball inside another one, one beyond the vessel's wall, and one that touches the wall from there.
    std::vector<Object> balls = in_octants(rng);
    Sphere inside = std::get<Sphere>(balls[4]);
    inside.radius *= 0.5;
    balls.push_back(inside);
    balls.push_back(Sphere{{1.4, 1.4, 1.4}, 0.25});
    balls.push_back(Sphere{{0, 2.0625, 0}, 0.25});
    const StoredDiagram whole = stored(scene_with(balls, {round_wall, flat_wall}));
    REQUIRE(whole.cells.size() == 8);
    StoredDiagram d = whole;
    Cell& cell = d.cells[2].second;
    const std::string name = "cells[" + std::to_string(d.cells[2].first) + "]";
    auto& vessel = std::get<HollowSphere>(d.scene.objects[3]);
    // Refuted integrals need not be enclosed well.
    const auto certify = [](const StoredDiagram& damaged) { return vcell::certify(damaged, {50, 1, 4}); };
    SUBCASE("nothing") { CHECK(certify(d).count(Verdict::refuted) == 0); }
    SUBCASE("a vessel's radius") {
        vessel.radius += 1e-6;
        CHECK(has_verdict(certify(d), "cells[", Verdict::refuted));
    }
    SUBCASE("a vessel that nobody has looked at") {
        d.scene.objects.push_back(HollowSphere{{0, 0, 0}, 1.25});
        CHECK(has_verdict(certify(d), "cells[", Verdict::refuted));
    }
    SUBCASE("a vessel that is a ball") {
        d.scene.objects[3] = Sphere{vessel.center, vessel.radius};
        CHECK(has_verdict(certify(d), "cells[", Verdict::refuted));
    }
    SUBCASE("a plane that has moved") {
        std::get<Plane>(d.scene.objects[4]).point.z() -= 1e-6;
        CHECK(has_verdict(certify(d), "cells[", Verdict::refuted));
    }
    SUBCASE("a cell that is not there") {
        d.cells.erase(d.cells.begin() + 2);
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name, Verdict::refuted));
        CHECK(has_verdict(c, "pairs[", Verdict::refuted));
    }
    SUBCASE("a ball that reaches in over the wall, and has no cell") {
        auto& beyond = std::get<Sphere>(d.scene.objects.back());
        beyond.radius += 1e-9;
        const Certificate c = certify(d);
        CHECK(has_verdict(c, "cells[" + std::to_string(d.scene.objects.size() - 1) + "]", Verdict::refuted));
    }
    SUBCASE("a vertex of one of its cells") {
        cell.vertices[0].point.z() += 1e-6;
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name + ".vertices[0]", Verdict::refuted));
        CHECK(has_verdict(c, "pairs[", Verdict::refuted));
    }
    SUBCASE("a face that is another object's") {
        for (CellFace& f : cell.faces)
            if (f.site.is_object() && cell.scene.images[f.site.index].number == 3) f.site.index = 0;
        CHECK(has_verdict(certify(d), name, Verdict::refuted));
    }
    SUBCASE("a volume, and more than the box has") {
        cell.measures.volume += 30;
        const Certificate c = certify(d);
        CHECK(objects_to(c, name + ".measures.volume"));
        CHECK(has_verdict(c, "volume", Verdict::refuted));
    }
}

TEST_CASE("diagram file: cells are of balls, whatever other objects there are") {
    std::mt19937_64 rng(test_seed());
    const std::string text = text_of(scene_with(in_octants(rng), {flat_wall}));
    const auto diagram = parse_diagram(text);
    REQUIRE(diagram);
    CHECK(diagram->scene.objects[3] == flat_wall);
    CHECK(diagram->cells.size() == 8);
    std::string changed = text;
    const std::string from = R"("object":4)";
    changed.replace(changed.find(from), from.size(), R"("object":3)");
    std::string path;
    try {
        parse_diagram(changed);
    } catch (const InputError& e) {
        path = e.path;
    }
    CHECK(path == "cells");
}
