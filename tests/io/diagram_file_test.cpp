// Scenes of whole diagrams as files.
#include "../../io/files/diagram_file.hpp"

#include <doctest/doctest.h>

#include <sstream>

#include "../../core/errors.hpp"

namespace vcell {
namespace {

std::string complaint(const std::string& text, const DiagramSceneOptions& options = {}) {
    try {
        parse_diagram_scene(text, options);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("diagram file: everything in JSON arrives, a base is the last object") {
    const DiagramScene scene = parse_diagram_scene(
        R"({"vcell": 1, "base": {"plane": {"point": [0, 0, -1], "normal": [0, 0, 1]}, "name": "floor"},
            "objects": [{"sphere": {"center": [1, 2, 3], "radius": 0.5}},
                        {"sphere": {"center": [3, 2, 1], "radius": 0.25}, "name": "b", "group": "g"}],
            "box": {"min": [-1, -2, -3], "max": [4, 5, 6]}, "periodic": [true, false, true], "tilt": [0.5, 0, 0.25], "probe": 1.4,
            "units": "nm", "tolerance": 1e-5})");
    REQUIRE(scene.objects.size() == 3);
    CHECK(scene.objects[0] == Object(Sphere{{1, 2, 3}, 0.5}));
    CHECK(scene.objects[2] == Object(Plane{{0, 0, -1}, {0, 0, 1}}));
    CHECK(scene.names == std::vector<std::string>{"", "b", "floor"});
    CHECK(scene.groups == std::vector<std::string>{"", "g", ""});
    CHECK(scene.box.min == Vec3(-1, -2, -3));
    CHECK(scene.periodic == std::array{true, false, true});
    CHECK(scene.tilt == std::array{0.5, 0.0, 0.25});
    CHECK(scene.probe == 1.4);
    CHECK(scene.units == "nm");
    CHECK(scene.tolerance == 1e-5);
}

TEST_CASE("diagram file: a base that is among the objects is there once") {
    const DiagramScene scene = parse_diagram_scene(
        R"({"vcell": 1, "base": {"sphere": {"center": [1, 2, 3], "radius": 0.5}}, "base_object": 0,
            "objects": [{"sphere": {"center": [1, 2, 3], "radius": 0.5}}], "box": {"min": [0, 0, 0], "max": [4, 5, 6]}})");
    CHECK(scene.objects.size() == 1);
    // Where the base is another ball, or none of them, its cell would be missing without a word.
    const auto with_base = [](const std::string& radius, const std::string& number) {
        return complaint(R"({"vcell": 1, "base": {"sphere": {"center": [1, 2, 3], "radius": )" + radius +
                         R"(}}, "base_object": )" + number + R"(,
            "objects": [{"sphere": {"center": [1, 2, 3], "radius": 0.5}}], "box": {"min": [0, 0, 0], "max": [4, 5, 6]}})");
    };
    CHECK(with_base("0.5", "0") == "");
    CHECK(with_base("0.25", "0") == "base_object: objects[0] is not the base");
    CHECK(with_base("0.5", "1") == "base_object: must be less than the number of objects, 1, is 1");
}

TEST_CASE("diagram file: lines of balls with names and groups") {
    const DiagramScene scene =
        parse_diagram_scene("# x y z r\n0 0 0 1\n\n2 0 0 0.5 CA ALA-1\n4 0 0 0.5 CB\n");
    REQUIRE(scene.objects.size() == 3);
    CHECK(scene.names == std::vector<std::string>{"", "CA", "CB"});
    CHECK(scene.groups == std::vector<std::string>{"", "ALA-1", ""});
    CHECK(scene.box.max.x() > 4.5);
    DiagramSceneOptions options;
    options.box = Box{{-1, -1, -1}, {5, 1, 1}};
    options.periodic = {true, false, false};
    CHECK(parse_diagram_scene("0 0 0 1\n", options).box.max == Vec3(5, 1, 1));
    CHECK(parse_diagram_scene("0 0 0 1\n", options).periodic[0]);
}

TEST_CASE("diagram file: mistakes are named with their place") {
    CHECK(complaint("0 0 0 1 a b c\n") == "line 1: must be x y z r [name [group]], has more");
    CHECK(complaint("0 0 0 1\n1 2 x\n").starts_with("line 2: "));
    CHECK(complaint("# radii\n0 0 0 1\n1 2 3 -4 CA\n") == "line 3: a radius must be >= 0, is -4");
    CHECK(complaint("# nothing\n").starts_with("--box: missing"));
    CHECK(
        complaint(
            R"({"vcell": 1, "objects": [], "box": {"min": [0, 0, 0], "max": [1, 1, 1]}, "periodic": [true, 1, true]})")
            .starts_with("periodic[1]: "));
    CHECK(complaint(
              R"({"vcell": 1, "objects": [{"sphere": {"center": [0, 0, 0], "radius": 1}, "label": "a"}]})")
              .starts_with("objects[0].label: unknown key"));
    DiagramSceneOptions options;
    options.box = Box{{-1, -1, -1}, {5, 1, 1}};
    CHECK(complaint(R"({"vcell": 1})", options).starts_with("--box: "));
    CHECK(complaint("ATOM      1  N   THR A   1\n").find("PDB") != std::string::npos);
}

TEST_CASE("diagram file: a group called like the number of an object without one is not that object's") {
    const DiagramScene scene = parse_diagram_scene("0 0 0 0.5 a 1\n2 0 0 0.5 b\n0 2 0 0.25 c 1\n");
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    std::ostringstream groups;
    write_group_table(groups, scene, diagram, contacts(diagram));
    std::istringstream in(groups.str());
    std::vector<std::string> begins;
    for (std::string line; std::getline(in, line);)
        begins.push_back(line.substr(0, line.find('\t', line.find('\t') + 1)));
    CHECK(begins == std::vector<std::string>{"group\tcells", "1\t2", "object 1\t1"});
    CHECK(groups.str().find("\tobject 1\n") != std::string::npos);
}

TEST_CASE("diagram file: tables have as many columns in each line as in their header") {
    DiagramScene scene = parse_diagram_scene("0 0 0 0.5 a g\n2 0 0 0.5\n0 2 0 0.25 c g\n0.1 0 0 0.1\n");
    scene.names[0] = "with\ttab";
    const VoronoiDiagram diagram = voronoi_diagram(scene);
    const ContactTable table = contacts(diagram);
    std::ostringstream cells, pairs, groups, between;
    write_cell_table(cells, scene, diagram);
    write_contact_table(pairs, scene, table);
    write_group_table(groups, scene, diagram, table);
    write_group_contacts(between, scene, table);
    const auto lines_of = [](const std::string& text, std::size_t tabs) {
        std::size_t count = 0;
        std::istringstream in(text);
        for (std::string line; std::getline(in, line); ++count)
            CHECK(static_cast<std::size_t>(std::ranges::count(line, '\t')) == tabs);
        return count;
    };
    CHECK(lines_of(cells.str(), 18) == 5);
    CHECK(lines_of(pairs.str(), 11) == 1 + table.contacts.size());
    CHECK(lines_of(groups.str(), 9) == 1 + 3);  // g, and two objects of their own
    CHECK(cells.str().find("with tab") != std::string::npos);
    // g has both of its cells beside the one that is not hidden.
    CHECK(lines_of(between.str(), 4) == 1 + 1);
    double area = 0;
    for (const Contact& c : table.contacts)
        if (c.first == 1 || c.second == Site::object(1)) area += c.second.is_object() ? c.area : 0;
    const std::string row = between.str().substr(between.str().find('\n') + 1);
    CHECK(row.starts_with("g\t1\t2\t"));
    CHECK(std::stod(row.substr(6)) == doctest::Approx(area));
}

}  // namespace vcell
