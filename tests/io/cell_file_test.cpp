#include "../../io/files/cell_file.hpp"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "../../core/errors.hpp"
#include "../../io/files/scene_file.hpp"
#include "sample_cells.hpp"

using namespace vcell;
using nlohmann::json;

namespace {

/// "/faces/0/patches/1" as our messages say it: "faces[0].patches[1]".
std::string message_path(const json::json_pointer& pointer) {
    std::string result;
    std::string rest = pointer.to_string();
    while (!rest.empty()) {
        const auto end = rest.find('/', 1);
        const std::string token = rest.substr(1, end == rest.npos ? rest.npos : end - 1);
        rest = end == rest.npos ? "" : rest.substr(end);
        if (token.find_first_not_of("0123456789") == token.npos)
            result += "[" + token + "]";
        else
            result += (result.empty() ? "" : ".") + token;
    }
    return result;
}

/// Calls f(pointer, value) for a value and all inside it.
template <class F>
void for_each_value(const json& value, const json::json_pointer& pointer, F f) {
    f(pointer, value);
    if (value.is_object())
        for (const auto& [key, member] : value.items()) for_each_value(member, pointer / key, f);
    if (value.is_array())
        for (std::size_t i = 0; i < value.size(); ++i) for_each_value(value[i], pointer / i, f);
}

const std::set<std::string> optional_keys{"name", "units", "tolerance", "extra_sites", "seam", "closing"};

}  // namespace

TEST_CASE("cell file: writing, reading and writing again give the same text") {
    Cell empty;
    empty.scene.base = Plane{};
    empty.scene.box = {{0, 0, 0}, {1, 1, 1}};
    CHECK_THROWS_AS(cell_text(empty), InternalError);
    empty.measures = paraboloid_cell().measures;
    for (const Cell& cell : {paraboloid_cell(), island_cell(), empty}) {
        const std::string text = cell_text(cell);
        CHECK(cell_text(parse_cell(text)) == text);
        CHECK(json::accept(text));
    }
}

TEST_CASE("cell file: every field arrives") {
    Cell cell = island_cell();
    cell.edges[4].extra_sites = {Site::object(0), Site::base()};
    cell.faces[1].extra_sites = {Site::end(0), Site::end(1), Site::box_side(0)};
    cell.faces[0].patches[0].loops[0][0].edge.reset();
    cell.faces[0].patches[0].loops[0][0].seam = 12;
    cell.measures = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, true};
    cell.report.decisions = {1, 2, 3, 4, 5};
    cell.report.insertions = 7;
    cell.report.merges = 8;
    cell.report.pieces = 9;
    cell.report.seconds_bisectors = 1e-9;
    cell.report.seconds_envelope = 2;
    cell.report.seconds_patches = 3;
    const Cell read = parse_cell(cell_text(cell));
    CHECK(read.scene.names == cell.scene.names);
    CHECK(read.vertices[2].point == cell.vertices[2].point);
    CHECK(read.vertices[2].sites == cell.vertices[2].sites);
    CHECK(read.edges[4].sites == cell.edges[4].sites);
    CHECK(read.edges[4].extra_sites == cell.edges[4].extra_sites);
    CHECK(read.edges[4].vertices.empty());
    CHECK(read.edges[4].kind == CurveKind::Circle);
    CHECK(read.edges[4].length == cell.edges[4].length);
    CHECK(read.edges[4].length_error == cell.edges[4].length_error);
    CHECK(read.faces[1].area_error == cell.faces[1].area_error);
    CHECK(read.edges[4].curve.knots == cell.edges[4].curve.knots);
    CHECK(read.edges[4].curve.points == cell.edges[4].curve.points);
    CHECK(read.faces[1].extra_sites == cell.faces[1].extra_sites);
    CHECK(read.faces[0].bisector == "paraboloid");
    CHECK(read.faces[0].patches[0].surface.points == cell.faces[0].patches[0].surface.points);
    CHECK(read.faces[0].patches[0].surface.domain_v == cell.faces[0].patches[0].surface.domain_v);
    CHECK_FALSE(read.faces[0].patches[0].loops[0][0].edge);
    CHECK(read.faces[0].patches[0].loops[0][0].seam == 12u);
    CHECK(read.faces[1].patches[0].loops[1][0].reversed);
    CHECK(read.neighbors == cell.neighbors);
    CHECK(read.measures.volume == 1);
    CHECK(read.measures.volume_error == 2);
    CHECK(read.measures.body_volume == 3);
    CHECK(read.measures.body_volume_error == 4);
    CHECK(read.measures.area == 5);
    CHECK(read.measures.area_error == 6);
    CHECK(read.measures.box_area == 7);
    CHECK(read.measures.box_area_error == 8);
    CHECK(read.measures.base_area == 9);
    CHECK(read.measures.base_area_error == 10);
    CHECK(read.measures.min_clearance == 11);
    CHECK(read.measures.min_clearance_error == 12);
    CHECK(read.measures.max_clearance == 13);
    CHECK(read.measures.max_clearance_error == 14);
    CHECK(read.measures.touches_box);
    CHECK(read.report.decisions == cell.report.decisions);
    CHECK(read.report.insertions == 7);
    CHECK(read.report.merges == 8);
    CHECK(read.report.pieces == 9);
    CHECK(read.report.seconds_bisectors == 1e-9);
    CHECK(read.report.seconds_envelope == 2);
    CHECK(read.report.seconds_patches == 3);
    CHECK(read.report.warnings == cell.report.warnings);
}

TEST_CASE("cell file: errors that are estimated say so in their names") {
    Cell cell = island_cell();
    cell.edges[4].is_estimated = cell.faces[1].is_estimated = cell.measures.is_estimated = true;
    const json text = json::parse(cell_text(cell));
    CHECK(text["edges"][4].contains("length_error_estimate"));
    CHECK_FALSE(text["edges"][4].contains("length_error"));
    CHECK(text["edges"][0].contains("length_error"));
    CHECK(text["faces"][1].contains("area_error_estimate"));
    for (const char* key : {"volume_error_estimate", "area_error_estimate", "box_area_error_estimate"})
        CHECK(text["measures"].contains(key));
    const Cell read = parse_cell(text.dump());
    CHECK(read.edges[4].is_estimated);
    CHECK(read.edges[4].length_error == cell.edges[4].length_error);
    CHECK_FALSE(read.edges[0].is_estimated);
    CHECK(read.faces[1].is_estimated);
    CHECK(read.measures.is_estimated);
    CHECK(read.measures.volume_error == cell.measures.volume_error);
}

TEST_CASE("cell file: the layout is the documented one") {
    const json cell = json::parse(cell_text(island_cell()));
    CHECK(cell["vcell"] == 1);
    CHECK(cell["faces"][0]["site"] == 0);
    CHECK(cell["faces"][1]["site"] == "box:+z");
    CHECK(cell["edges"][4]["sites"] == json{0, "box:+z"});
    CHECK(cell["edges"][4]["kind"] == "circle");
    CHECK(cell["edges"][4]["vertices"] == json::array());
    CHECK(cell["faces"][0]["patches"][0]["degree"] == json{2, 2});
    CHECK(cell["faces"][0]["patches"][0]["points"].size() == 3);
    CHECK(cell["faces"][0]["patches"][0]["points"][1].size() == 3);
    CHECK(cell["faces"][0]["patches"][0]["points"][1][2][1] == 1.0);  // i = 1: x = 0; j = 2: y = 1
    CHECK(cell["faces"][0]["patches"][0]["loops"][0][0]["edge"] == 4);
    CHECK(cell["report"]["decisions"]["exact"] == UINT64_MAX);
}

TEST_CASE("cell file: every key is needed, and its absence named") {
    const json cell = json::parse(cell_text(island_cell()));
    int removed = 0;
    for_each_value(cell, json::json_pointer(), [&](const json::json_pointer& pointer, const json& value) {
        if (!value.is_object()) return;
        for (const auto& [key, member] : value.items()) {
            json damaged = cell;
            damaged[pointer].erase(key);
            const std::string complaint = cell_complaint(damaged.dump());
            const bool kind_of_object =
                pointer.to_string().starts_with("/scene/base") || pointer.to_string() == "/scene/objects/0";
            CAPTURE(key);
            if (optional_keys.contains(key))
                CHECK(complaint == "accepted");
            else if (kind_of_object && member.is_object())
                CHECK(complaint.ends_with("holds none"));
            else
                CHECK(complaint == message_path(pointer / key) + ": missing");
            ++removed;
        }
    });
    CHECK(removed > 100);
}

TEST_CASE("cell file: a key too many, a wrong type: named wherever it is") {
    const json cell = json::parse(cell_text(paraboloid_cell()));
    for_each_value(cell, json::json_pointer(), [&](const json::json_pointer& pointer, const json& value) {
        json damaged = cell;
        if (value.is_object()) {
            damaged[pointer]["surplus"] = 1;
            const std::string complaint = cell_complaint(damaged.dump());
            CAPTURE(complaint);
            CHECK(complaint.starts_with(message_path(pointer / "surplus") + ": unknown key"));
            damaged = cell;
        }
        damaged[pointer] = value.is_boolean() ? json("text") : json(true);
        const std::string complaint = cell_complaint(damaged.dump());
        const std::string path = message_path(pointer);
        CAPTURE(complaint);
        CHECK(complaint.starts_with(path.empty() ? "must be an object" : path + ": must be "));
    });
}

TEST_CASE("cell file: a scene is told from a cell") {
    std::ostringstream scene;
    write_scene(scene, island_cell().scene);
    try {
        parse_cell(scene.str());
        FAIL("accepted");
    } catch (const InputError& e) {
        CHECK(std::string(e.what()).find("this is a scene, not a cell") == 0);
    }
}

TEST_CASE("cell file: names of sites and kinds, shapes of patches") {
    json cell = json::parse(cell_text(paraboloid_cell()));
    const auto with = [&](const char* pointer, const json& value) {
        json damaged = cell;
        damaged[json::json_pointer(pointer)] = value;
        return cell_complaint(damaged.dump());
    };
    CHECK(with("/faces/0/site", "box:x") ==
          "faces[0].site: must be \"base\", \"cap\", a side as \"box:-x\" or an end as \"end:+\"");
    CHECK(with("/faces/0/site", "end:-") == "accepted");
    CHECK(with("/faces/0/site", -1) == "faces[0].site: must be a non-negative integer, is -1");
    CHECK(with("/faces/0/site", 4294967295u) == "faces[0].site: must be at most 4294967294, is 4294967295");
    CHECK(with("/edges/1/kind", "oval") ==
          "edges[1].kind: must be line, circle, ellipse, parabola, hyperbola or spline");
    CHECK(with("/edges/1/sites", {0}) == "edges[1].sites: must have 2 elements");
    CHECK(with("/faces/0/patches/0/degree", {2, 1}) ==
          "faces[0].patches[0]: points must be 3 rows of 2 by the degree");
    CHECK(with("/faces/0/patches/0/degree", {2147483647, 2}) ==
          "faces[0].patches[0].degree[0]: must be at most 2147483646, is 2147483647");
    CHECK(with("/faces/0/patches/0/points/1", json::array()) ==
          "faces[0].patches[0]: points must be 3 rows of 3 by the degree");
    CHECK(with("/faces/0/patches/0/points/1/2", {1, 2, 3}) ==
          "faces[0].patches[0].points[1][2]: must have 4 elements");
    CHECK(with("/faces/0/patches/0/loops/0/0/edge", nullptr) == "accepted");
    CHECK(with("/scene/objects/0/sphere/radius", -1) == "objects[0].sphere.radius: must be >= 0, is -1");
}

TEST_CASE("cell file: a result that is not finite is never written") {
    Cell cell = paraboloid_cell();
    cell.vertices[0].error = std::numeric_limits<double>::infinity();
    CHECK_THROWS_AS(cell_text(cell), InternalError);
}
