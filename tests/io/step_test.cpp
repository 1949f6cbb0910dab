// STEP files, as text: every reference is there, shells are closed, and curves are the cell's.
#include "../../io/files/step_file.hpp"

#include <doctest/doctest.h>

#include <map>
#include <regex>
#include <sstream>
#include <string>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"

namespace vcell {
namespace {

std::map<int, std::string> entities(const std::string& file) {
    std::map<int, std::string> all;
    std::istringstream lines(file);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with('#')) {
            const std::size_t is = line.find('=');
            CHECK(line.back() == ';');
            all[std::stoi(line.substr(1))] = line.substr(is + 1);
        }
    return all;
}

std::size_t count(const std::map<int, std::string>& all, const std::string& kind) {
    std::size_t n = 0;
    for (const auto& [id, text] : all) n += text.starts_with(kind + "(");
    return n;
}

}  // namespace

TEST_CASE("step: a ball's cell is a closed solid of its faces, edges and vertices") {
    Scene scene;
    scene.base = Sphere{{0.1, 0, 0}, 0.25};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Sphere{{0.5, 1, 1.25}, 0.5}, Sphere{{-1, -0.5, 1}, 0.25}, Plane{{0, 0, -1}, {0.1, 0, 1}},
                     Sphere{{0, 0, 1.5}, 0.01}};
    scene.units = "um";
    const Cell cell = voronoi_cell(scene);
    std::ostringstream out;
    write_step(out, cell);
    const std::string file = out.str();
    CHECK(file.starts_with("ISO-10303-21;\n"));
    CHECK(file.ends_with("ENDSEC;\nEND-ISO-10303-21;\n"));
    CHECK(file.find("SI_UNIT(.MICRO.,.METRE.)") != file.npos);
    const auto all = entities(file);
    for (const auto& [id, text] : all) {
        for (std::size_t at = 0; (at = text.find('#', at)) != text.npos; ++at)
            CHECK(all.contains(std::stoi(text.substr(at + 1))));
        // Numbers have points: an integer would not be a REAL.
        if (text.starts_with("CARTESIAN_POINT"))
            CHECK(std::regex_match(
                text, std::regex(R"(CARTESIAN_POINT\('',\((-?\d+\.\d*(E-?\+?\d+)?,?){2,3}\)\);)")));
    }
    CHECK(count(all, "ADVANCED_FACE") == cell.faces.size());
    CHECK(count(all, "EDGE_CURVE") == cell.edges.size());
    CHECK(count(all, "CLOSED_SHELL") == 1);
    CHECK(count(all, "PCURVE") == 2 * cell.edges.size());
    CHECK(count(all, "STYLED_ITEM") == cell.faces.size());
    // Each edge is used once each way.
    std::map<int, int> balance;
    for (const auto& [id, text] : all)
        if (text.starts_with("ORIENTED_EDGE"))
            balance[std::stoi(text.substr(text.find('#') + 1))] += text.find(".T.") != text.npos ? 1 : -1;
    CHECK(balance.size() == cell.edges.size());
    for (const auto& [edge, sum] : balance) CHECK(sum == 0);
    std::ostringstream again;
    write_step(again, cell);
    CHECK(again.str() == file);
}

TEST_CASE("step: cells over planes and tubes are no closed solids") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Sphere{{0.5, 1, 1.25}, 0.25}};
    std::ostringstream out;
    CHECK_THROWS_AS(write_step(out, voronoi_cell(scene)), InputError);
    scene.base = Cylinder{{0, 0, 0}, {0, 1, 0}, 0.25};
    CHECK_THROWS_AS(write_step(out, voronoi_cell(scene)), InputError);
    CHECK(out.str().empty());
}

}  // namespace vcell
