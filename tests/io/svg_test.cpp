#include "../../io/pictures/svg.hpp"

#include <doctest/doctest.h>

#include <boost/property_tree/xml_parser.hpp>
#include <cctype>
#include <set>
#include <sstream>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/pictures/labels.hpp"
#include "../../io/pictures/site_style.hpp"
#include "sample_cells.hpp"

using namespace vcell;
namespace pt = boost::property_tree;

namespace {

std::string svg_text(const Cell& cell) {
    std::ostringstream out;
    write_svg(out, cell);
    return out.str();
}

/// The elements of a class in the picture's group.
std::vector<pt::ptree> elements(const std::string& svg, const std::string& css_class) {
    std::istringstream in(svg);
    pt::ptree document;
    pt::read_xml(in, document);  // throws if it is not well formed
    std::vector<pt::ptree> found;
    for (const auto& [name, element] : document.get_child("svg.g"))
        if (const auto c = element.get<std::string>("<xmlattr>.class", "");
            (c + " ").find(css_class + " ") != std::string::npos)
            found.push_back(element);
    return found;
}

}  // namespace

TEST_CASE("svg: faces, edges and vertices are there, once each") {
    const std::string svg = svg_text(island_cell());
    CHECK(elements(svg, "face").size() == 2);
    CHECK(elements(svg, "edge").size() == 5);
    CHECK(elements(svg, "rim").size() == 4);
    CHECK(elements(svg, "box").size() == 1);
    REQUIRE(elements(svg, "vertex").size() == 4);
    CHECK(elements(svg, "vertex")[2].get<std::string>("<xmlattr>.cx") == "1");
    CHECK(elements(svg, "vertex")[2].get<std::string>("<xmlattr>.cy") == "1");
    CHECK(elements(svg, "vertex")[2].get<std::string>("title") ==
          "clearance 0.6, box side +x, box side +y, box side +z");
}

TEST_CASE("svg: circles are exact arcs, straight sides lines") {
    const std::string svg = svg_text(island_cell());
    const auto circle = elements(svg, "circle");
    REQUIRE(circle.size() == 1);
    // Radius 3/4, quarters, counter-clockwise in the flipped group.
    CHECK(circle[0].get<std::string>("<xmlattr>.d") ==
          "M0.75,0A0.75 0.75 0 0 1 0,0.75A0.75 0.75 0 0 1 -0.75,0A0.75 0.75 0 0 1 0,-0.75A0.75 0.75 0 0 1 "
          "0.75,0");
    const auto box = elements(svg, "box");
    CHECK(box[0].get<std::string>("<xmlattr>.d") ==
          "M-1,-1L1,-1L1,1L-1,1L-1,-1Z"
          "M0.75,0A0.75 0.75 0 0 0 0,-0.75A0.75 0.75 0 0 0 -0.75,0A0.75 0.75 0 0 0 0,0.75A0.75 0.75 0 0 0 "
          "0.75,0Z");
    CHECK(box[0].get<std::string>("<xmlattr>.fill-rule") == "evenodd");
}

TEST_CASE("svg: other curves become what SVG can say") {
    Cell cell = paraboloid_cell();
    auto& loop = cell.faces[0].patches[0].loops[0];
    // A parabola, a polynomial cubic, a hyperbola and an inner knot that is not repeated.
    loop[0].curve = {2, {0, 0, 0, 1, 1, 1}, {{-1, -1, 1}, {0, -2, 1}, {1, -1, 1}}};
    loop[1].curve = {3, {0, 0, 0, 0, 1, 1, 1, 1}, {{1, -1, 1}, {1.5, -0.5, 1}, {0.5, 0.5, 1}, {1, 1, 1}}};
    loop[2].curve = {2, {0, 0, 0, 1, 1, 1}, {{1, 1, 1}, {0, 2, 3}, {-1, 1, 1}}};
    loop[3].curve = {2, {0, 0, 0, 0.5, 1, 1, 1}, {{-1, 1, 1}, {-1.5, 0.5, 1}, {-0.5, -0.5, 1}, {-1, -1, 1}}};
    const auto edges = elements(svg_text(cell), "edge");
    REQUIRE(edges.size() == 4);
    CHECK(edges[0].get<std::string>("<xmlattr>.d") == "M-1,-1Q0,-2 1,-1");
    for (const int i : {1, 2, 3}) {
        const auto d = edges[static_cast<std::size_t>(i)].get<std::string>("<xmlattr>.d");
        CAPTURE(d);
        CHECK(d.find('C') != d.npos);
        CHECK(d.find_first_of("AQL") == d.npos);
    }
}

TEST_CASE("svg: faces over cylinders are drawn in the chart, not in their patches' parameters") {
    Scene scene;
    scene.objects = {Cylinder{{0, 0, 0.8}, {1, 0.3, 0.2}, 0.1},
                     Cylinder{{-0.5, 0.5, 0.9}, {0.2, 1, 0}, 0.15}};
    scene.box = {{-1, -1, 0}, {1, 1, 1.5}};
    const Cell cell = voronoi_cell(scene);
    const std::string svg = svg_text(cell);
    const auto vertices = elements(svg, "vertex");
    REQUIRE(vertices.size() == cell.vertices.size());
    for (const auto& v : vertices) {
        const Vec3& p = cell.vertices[v.get<std::size_t>("<xmlattr>.data-vertex")].point;
        CHECK(v.get<double>("<xmlattr>.cx") == doctest::Approx(p.x()).epsilon(1e-5));
        CHECK(v.get<double>("<xmlattr>.cy") == doctest::Approx(p.y()).epsilon(1e-5));
    }
    // Every face's path closes where it began, and stays in the region.
    for (const auto& f : elements(svg, "face")) {
        std::string d = f.get<std::string>("<xmlattr>.d");
        for (char& c : d)
            if (!std::isdigit(c) && c != '.' && c != '-' && c != 'e' && c != '+') c = ' ';
        std::istringstream words(d);
        std::vector<double> numbers;
        for (double x; words >> x;) numbers.push_back(x);
        REQUIRE(numbers.size() >= 6);
        for (const double x : numbers) CHECK(std::abs(x) <= 1.1);
        CHECK(numbers[numbers.size() - 2] == doctest::Approx(numbers[0]).epsilon(1e-5));
        CHECK(numbers.back() == doctest::Approx(numbers[1]).epsilon(1e-5));
    }
}

TEST_CASE("svg: coordinates far from the origin keep their digits") {
    Cell cell = island_cell();
    for (auto& face : cell.faces)
        for (auto& loop : face.patches[0].loops)
            for (auto& c : loop)
                for (auto& p : c.curve.points) p.x() += 1e8;
    const auto circle = elements(svg_text(cell), "circle");
    CHECK(circle[0].get<std::string>("<xmlattr>.d").find("M100000000.75,0A0.75 0.75") == 0);
}

TEST_CASE("svg: any name is fit for XML") {
    Cell cell = paraboloid_cell();
    cell.scene.names = {std::string("<&>\"' \x01\xFF\xEF\xBF\xBF") + '\0'};
    const auto faces = elements(svg_text(cell), "face");
    CHECK(faces[0].get<std::string>("title").find("object 0 (<&>\"' ") == 0);
}

TEST_CASE("svg: a cell without faces is an empty picture") {
    CHECK(elements(svg_text(Cell{}), "face").empty());
}

TEST_CASE("svg: names stand in their faces where there is room, lengths and hatches are explained") {
    Cell cell = island_cell();  // a disc of radius 0.75 in a square from -1 to 1
    cell.scene.names = {"A<B"};
    cell.scene.units = "cm";
    const std::string svg = svg_text(cell);
    // 2.04 units are 800 pixels.
    CHECK(svg.find("transform=\"translate(0 0) scale(0.00255)\" y=\"4.2\">A&lt;B</text>") != svg.npos);
    CHECK(svg.find("V0H196.08V") != svg.npos);
    CHECK(svg.find(">0.5 cm</text>") != svg.npos);
    CHECK(svg.find(">sides of the box</text>") != svg.npos);
    cell.scene.names = {std::string(200, 'x')};
    CHECK(svg_text(cell).find("words label") == svg.npos);
    cell.scene.names.clear();
    CHECK(svg_text(cell).find(">0</text>") != svg.npos);
    CHECK(svg_text(paraboloid_cell()).find("sides of the box") == svg.npos);
}

TEST_CASE("labels: a text lies in its polygons, which may have holes, or nowhere") {
    using Polygons = std::vector<std::vector<Vec2>>;
    const std::vector<Vec2> square{{0, 0}, {10, 0}, {10, 10}, {0, 10}}, hole{{1, 1}, {9, 1}, {9, 6}, {1, 6}};
    const auto place = place_of_text(Polygons{square, hole}, 5, 2);
    REQUIRE(place);
    CHECK(place->y() > 7);
    CHECK(place->y() < 9);
    CHECK(place->x() > 2.5);
    CHECK(place->x() < 7.5);
    CHECK_FALSE(place_of_text(Polygons{square, hole}, 5, 4));
    CHECK(place_of_text(Polygons{square}, 5, 4));
    CHECK_FALSE(place_of_text(Polygons{square}, 11, 1));
    CHECK_FALSE(place_of_text({}, 1, 1));
    // An L: its middle is outside.
    const std::vector<Vec2> corner{{0, 0}, {10, 0}, {10, 2}, {2, 2}, {2, 10}, {0, 10}};
    const auto in_corner = place_of_text(Polygons{corner}, 1, 1);
    REQUIRE(in_corner);
    CHECK(in_corner->minCoeff() < 1.5);
    for (const auto& [longest, round] :
         {std::pair{1.0, 1.0}, {1.99, 1.0}, {2.0, 2.0}, {4.9, 2.0}, {7.0, 5.0}, {0.3, 0.2}, {2e7, 2e7}})
        CHECK(round_length(longest) == doctest::Approx(round).epsilon(1e-12));
}

TEST_CASE("site style: neighbours differ in colour") {
    // A triangulated grid, sites numbered from 1000: planar, so eight colours are plenty.
    Cell cell;
    constexpr std::uint32_t n = 30;
    const auto site = [](std::uint32_t i, std::uint32_t j) { return Site::object(1000 + i * n + j); };
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            CellFace f;
            f.site = site(i, j);
            cell.faces.push_back(f);
            CellEdge e;
            if (i + 1 < n) e.sites = {site(i, j), site(i + 1, j)}, cell.edges.push_back(e);
            if (j + 1 < n) e.sites = {site(i, j), site(i, j + 1)}, cell.edges.push_back(e);
            if (i + 1 < n && j + 1 < n) e.sites = {site(i, j), site(i + 1, j + 1)}, cell.edges.push_back(e);
        }
    const auto colours = object_colours(cell);
    CHECK(colours.size() == n * n);
    for (const CellEdge& e : cell.edges) CHECK(colours.at(e.sites[0].index) != colours.at(e.sites[1].index));
    std::set<std::size_t> used;
    for (const auto& [object, colour] : colours) used.insert(colour);
    CHECK(used.size() == palette().size());
}
