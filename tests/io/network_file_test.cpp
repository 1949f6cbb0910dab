// Void networks as other programs read them.
#include "../../io/files/network_file.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/whole/void_network.hpp"

namespace vcell {

// OpenPNM merges columns by their brackets, and takes rows up to the first blank one.
TEST_CASE("network: OpenPNM's columns have all pores and throats") {
    DiagramScene scene;
    scene.box = {{0, 0, 0}, {4, 4, 4}};
    scene.periodic = {true, true, true};
    scene.objects = {Sphere{{1, 1, 1}, 0.5}, Sphere{{3, 2, 1}, 0.25}, Sphere{{2, 3, 3}, 0.125}};
    const VoidNetwork network = void_network(scene);
    std::ostringstream out;
    write_openpnm(out, network);
    std::istringstream lines(out.str());
    std::map<std::string, std::vector<std::string>> columns;
    std::vector<std::string> names;
    for (std::string line; std::getline(lines, line);) {
        std::vector<std::string> words;
        line += ',';
        for (std::size_t at = 0; at < line.size(); at = line.find(',', at) + 1)
            words.push_back(line.substr(at, line.find(',', at) - at));
        if (names.empty())
            names = words;
        else {
            REQUIRE(words.size() == names.size());
            for (std::size_t k = 0; k < names.size(); ++k)
                if (!words[k].empty()) columns[names[k]].push_back(words[k]);
        }
    }
    REQUIRE(network.vertices.size() > 4);
    for (std::size_t i = 0; i < network.vertices.size(); ++i) {
        for (int k = 0; k < 3; ++k)
            CHECK(std::stod(columns["pore.coords[" + std::to_string(k) + "]"].at(i)) ==
                  network.vertices[i].point[k]);
        CHECK(std::stod(columns["pore.diameter"].at(i)) == 2 * network.vertices[i].clearance);
    }
    CHECK(columns["pore.coords[0]"].size() == network.vertices.size());
    std::size_t throats = 0;
    for (const NetworkEdge& e : network.edges) {
        if (!e.vertices) continue;
        const auto [low, high] = std::minmax((*e.vertices)[0], (*e.vertices)[1]);
        CHECK(std::stoul(columns["throat.conns[0]"].at(throats)) == low);
        CHECK(std::stoul(columns["throat.conns[1]"].at(throats)) == high);
        const int image = std::stoi(columns["throat.image[2]"].at(throats));
        CHECK(image == ((*e.vertices)[0] <= (*e.vertices)[1] ? e.image[2] : -e.image[2]));
        CHECK(std::stod(columns["throat.diameter"].at(throats)) == 2 * e.bottleneck);
        CHECK(std::stod(columns["throat.length"].at(throats)) == e.length);
        ++throats;
    }
    CHECK(throats > network.vertices.size());
    CHECK(columns["throat.conns[0]"].size() == throats);
}

TEST_CASE("network: edges that wind and passages are in the tables, not among pores and throats") {
    DiagramScene scene;
    scene.box = {{0, 0, 0}, {1, 1, 1}};
    scene.periodic = {true, true, true};
    scene.objects = {Cylinder{{0.25, 0.25, 0}, {0, 0, 1}, 0.2}};
    const VoidNetwork network = void_network(scene);
    std::ostringstream tables, openpnm;
    write_network(tables, network);
    const std::string text = tables.str();
    CHECK(text.find("\nvertex\tx\ty\tz\tclearance\terror\ttouching\tsites\n\nedge") != std::string::npos);
    CHECK(text.find("\n0\t-\t-\t0,0,1\t0 0(0,1,0) 0(1,0,0) 0(1,1,0)\t0.507106") != std::string::npos);
    CHECK(text.find("\npassage\tfirst\tsecond\timage\tsites\tbottleneck\tbottleneck_error\n0\t0\t0\t") !=
          std::string::npos);
    write_openpnm(openpnm, network);
    CHECK(std::ranges::count(openpnm.str(), '\n') == 1);
}

}  // namespace vcell
