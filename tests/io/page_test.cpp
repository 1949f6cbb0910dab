#include "../../io/pictures/page.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../io/pictures/bytes.hpp"
#include "../../io/pictures/site_style.hpp"
#include "base64.hpp"
#include "sample_cells.hpp"

using namespace vcell;
using nlohmann::json;

namespace {

std::string page_text(const Cell& cell) {
    std::ostringstream out;
    write_page(out, cell, tessellate(cell));
    return out.str();
}

/// What is in the elements `<script type="application/json" ...>` as a browser takes the page apart: an
/// element of text ends at the next "</script".
std::vector<std::string> data_elements(const std::string& page) {
    std::vector<std::string> found;
    const std::string begin = "<script type=\"application/json\"";
    for (std::size_t at = 0; (at = page.find(begin, at)) != page.npos;) {
        const std::size_t from = page.find('>', at) + 1;
        at = page.find("</script", from);
        found.push_back(page.substr(from, at - from));
    }
    return found;
}

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += what.size()) ++n;
    return n;
}

template <class T>
std::vector<T> numbers_of(const json& text) {
    const std::string bytes = testing::from_base64(text.get<std::string>());
    REQUIRE(bytes.size() % sizeof(T) == 0);
    std::vector<T> numbers(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

struct Shape {
    explicit Shape(const json& mesh) {
        const std::vector<float> numbers = numbers_of<float>(mesh["points"]);
        points = from(numbers, mesh);
        lines = from(numbers_of<float>(mesh["lines"]), mesh);
        normals = numbers_of<std::int8_t>(mesh["normals"]);
        if (points.size() > 65536)
            for (const std::uint32_t c : numbers_of<std::uint32_t>(mesh["triangles"])) corners.push_back(c);
        else
            for (const std::uint16_t c : numbers_of<std::uint16_t>(mesh["triangles"])) corners.push_back(c);
    }
    static std::vector<Vec3> from(const std::vector<float>& numbers, const json& mesh) {
        const Vec3 origin(mesh["origin"][0], mesh["origin"][1], mesh["origin"][2]);
        std::vector<Vec3> result;
        for (std::size_t i = 0; i + 2 < numbers.size(); i += 3)
            result.push_back(origin +
                             mesh["scale"].get<double>() * Vec3(numbers[i], numbers[i + 1], numbers[i + 2]));
        return result;
    }
    double area(std::size_t begin, std::size_t end) const {
        double sum = 0;
        for (std::size_t t = begin; t < end; ++t) {
            const Vec3 &a = points[corners[3 * t]], &b = points[corners[3 * t + 1]],
                       &c = points[corners[3 * t + 2]];
            sum += 0.5 * (b - a).cross(c - a).norm();
        }
        return sum;
    }
    std::vector<Vec3> points, lines;
    std::vector<std::int8_t> normals;
    std::vector<std::size_t> corners;
};

}  // namespace

TEST_CASE("bytes: base64 as the standard's examples have it") {
    CHECK(base64("") == "");
    CHECK(base64("f") == "Zg==");
    CHECK(base64("fo") == "Zm8=");
    CHECK(base64("foo") == "Zm9v");
    CHECK(base64("foobar") == "Zm9vYmFy");
}

TEST_CASE("page: without three.js there is none") {
    if (has_pages()) return;
    std::ostringstream out;
    const Cell cell = paraboloid_cell();
    CHECK_THROWS_AS(write_page(out, cell, tessellate(cell)), std::logic_error);
}

TEST_CASE("page: one file that may load nothing, with one diagram in it") {
    if (!has_pages()) return;
    const std::string page = page_text(island_cell());
    CHECK(page.starts_with("<!DOCTYPE html>"));
    CHECK(page.ends_with("</html>\n"));
    CHECK(count(page, "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';") == 1);
    CHECK(count(page, "<svg ") == 1);
    CHECK(count(page, "data-face=\"") == 2);
    CHECK(count(page, "data-edge=\"") == 5);
    CHECK(count(page, "data-vertex=\"") == 4);
    CHECK(count(page, "<!--") == 1);  // the notice of three.js: no place was left open
    // No address but namespaces, and a paper that three.js cites.
    const std::set<std::string> known{"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xhtml",
                                      "https://graphics.stanford.edu/papers/envmap/envmap.pdf"};
    for (std::size_t at = 0; (at = page.find("http", at)) != page.npos; ++at) {
        if (page.compare(at, 7, "http://") != 0 && page.compare(at, 8, "https://") != 0) continue;
        const std::string address = page.substr(at, page.find_first_of("\"' \n)<", at) - at);
        CAPTURE(address);
        CHECK(known.contains(address));
    }
    // In what comes before three.js.
    const std::string markup = page.substr(0, page.find("<!--"));
    for (const char* reference : {" src=", "<link", "@import", "url(http", "<iframe", "<object", "<img"})
        CHECK_MESSAGE(markup.find(reference) == markup.npos, std::string(reference));
}

TEST_CASE("page: the data has every face, edge and vertex, and numbers in full") {
    if (!has_pages()) return;
    for (const char* name : {"figure8.json", "figure10.json", "ball_tube_plane.json"}) {
        CAPTURE(name);
        const Scene scene = read_scene(std::string(VCELL_EXAMPLE_SCENES "/") + name, {});
        const Cell cell = voronoi_cell(scene);
        const std::vector<std::string> elements = data_elements(page_text(cell));
        REQUIRE(elements.size() == 2);
        const json page = json::parse(elements[0]), data = json::parse(elements[1]);
        CHECK(page["kind"] == "cell");
        CHECK(page["scene"]["objects"].size() == scene.objects.size());
        CHECK(page["palette"].size() == palette().size());

        REQUIRE(data["faces"].size() == cell.faces.size());
        const auto colours = object_colours(cell);
        for (std::size_t f = 0; f < cell.faces.size(); ++f) {
            const Site site = cell.faces[f].site;
            CHECK(data["faces"][f]["sites"][0] == to_string(site));
            CHECK(data["faces"][f]["area"] == cell.faces[f].area);
            CHECK(data["faces"][f]["error"] == cell.faces[f].area_error);
            const json& described = data["sites"][to_string(site)];
            CHECK(described["title"] == site_title(scene, site));
            if (site.is_object()) CHECK(described["colour"] == colours.at(site.index));
        }
        REQUIRE(data["edges"].size() == cell.edges.size());
        for (std::size_t e = 0; e < cell.edges.size(); ++e)
            CHECK(data["edges"][e]["length"] == cell.edges[e].length);
        REQUIRE(data["vertices"].size() == cell.vertices.size());
        for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
            CHECK(data["vertices"][v]["clearance"] == cell.vertices[v].radius);
            CHECK(data["vertices"][v]["point"][2] == cell.vertices[v].point.z());
            CHECK(data["vertices"][v]["sites"].size() == cell.vertices[v].sites.size());
        }
        std::map<std::string, double> measures;
        for (const json& m : data["measures"]) measures[m["name"]] = m["value"];
        CHECK(measures["volume"] == cell.measures.volume);
        CHECK(measures["area beside objects"] == cell.measures.area);
        CHECK(measures["largest clearance"] == cell.measures.max_clearance);
    }
}

TEST_CASE("page: its mesh has the faces' areas, its lines the edges' lengths, each in its part") {
    if (!has_pages()) return;
    for (const char* name : {"figure8.json", "figure10.json"}) {
        CAPTURE(name);
        const Cell cell = voronoi_cell(read_scene(std::string(VCELL_EXAMPLE_SCENES "/") + name, {}));
        const json data = json::parse(data_elements(page_text(cell)).at(1));
        const Shape shape(data["mesh"]);
        CHECK(shape.normals.size() == 3 * shape.points.size());
        REQUIRE(data["mesh"]["parts"].size() == cell.faces.size());
        for (const json& part : data["mesh"]["parts"]) {
            REQUIRE(part["kind"] == "face");
            const double area = cell.faces[part["face"]].area;
            CHECK(std::abs(shape.area(part["begin"], part["end"]) - area) < 0.01 * area);
        }
        CHECK(data["mesh"]["parts"].back()["end"] == shape.corners.size() / 3);
        std::size_t at = 0, e = 0;
        for (const std::size_t points : data["mesh"]["line_points"]) {
            double length = 0;
            for (std::size_t i = 1; i < points; ++i)
                length += (shape.lines.at(at + i) - shape.lines.at(at + i - 1)).norm();
            CHECK(std::abs(length - cell.edges[e].length) < 0.01 * cell.edges[e].length);
            at += points;
            ++e;
        }
        CHECK(e == cell.edges.size());
        CHECK(at == shape.lines.size());
    }
}

TEST_CASE("page: names end no element, begin no comment, and arrive as they are") {
    if (!has_pages()) return;
    const std::vector<std::string> names{"</script><script>alert(1)</script>",
                                         "<!--",
                                         "]]>",
                                         "\"quoted\" \\ & 'single'",
                                         "\xC3\xA9\xE2\x82\xAC\xF0\x9F\x94\xB5 \xE2\x80\xA8 line",
                                         "<!--diagram-->",
                                         "${0} `tick`"};
    Scene scene;
    scene.base = Plane{};
    scene.base_name = "</title></h1><script>alert(2)</script><!--summary-->";
    scene.box = {{-4, -4, 0}, {4, 4, 3}};
    for (std::size_t i = 0; i < names.size(); ++i)
        scene.objects.push_back(Sphere{{static_cast<double>(i) - 3, 0.1 * static_cast<double>(i), 1}, 0.25});
    scene.names = names;
    const std::string page = page_text(voronoi_cell(scene));
    CHECK(page.find("alert(1)</script>") == page.npos);
    CHECK(page.find("<script>alert") == page.npos);
    CHECK(count(page, "<!--") == 1);
    // The data, three.js and the page's own script.
    CHECK(count(page, "<script") == 4);
    CHECK(count(page, "</script") == 4);
    const std::vector<std::string> elements = data_elements(page);
    REQUIRE(elements.size() == 2);
    const json data = json::parse(elements[1]);
    const json objects = json::parse(elements[0])["scene"]["objects"];
    for (std::size_t i = 0; i < names.size(); ++i) {
        CHECK(objects[i]["name"] == names[i]);
        CHECK(data["sites"][std::to_string(i)]["title"] ==
              "object " + std::to_string(i) + " (" + names[i] + ")");
    }
}

TEST_CASE("page: scenes of any size, in single precision") {
    if (!has_pages()) return;
    for (const double unit : {1e-50, 1.0, 1e50}) {
        CAPTURE(unit);
        Scene scene;
        scene.base = Sphere{{0, 0, 0}, unit};
        scene.objects = {Sphere{{3 * unit, 0, 0}, unit}};
        scene.box = {Vec3::Constant(-2 * unit), Vec3::Constant(2 * unit)};
        const json data = json::parse(data_elements(page_text(voronoi_cell(scene))).at(1));
        double largest = 0;
        for (const Vec3& p : Shape(data["mesh"]).points)
            largest = std::max(largest, p.lpNorm<Eigen::Infinity>());
        CHECK(largest / unit == doctest::Approx(2));
    }
}

TEST_CASE("page: of a diagram every cell, with its object, and neighbours by their numbers") {
    if (!has_pages()) return;
    DiagramScene scene;
    scene.box = {Vec3::Constant(0), Vec3::Constant(4)};
    for (int i = 0; i < 8; ++i)
        scene.objects.push_back(
            Sphere{{1.0 + 2 * (i & 1), 1.0 + (i & 2), 1.0 + (i & 4) / 2}, 0.2 + 0.05 * i});
    scene.names.assign(8, "");
    scene.names[3] = "</script>";
    std::ostringstream out;
    DiagramPage page(out, scene);
    DiagramOptions options;
    std::size_t most_neighbours = 0;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        page.add(object, cell, tessellate(cell, {0.002 * cell_diagonal(cell), true}));
        most_neighbours = std::max(most_neighbours, cell.neighbors.size());
    };
    const VoronoiDiagram diagram = voronoi_diagram(scene, options);
    page.finish();
    REQUIRE(most_neighbours >= 3);
    const std::vector<std::string> elements = data_elements(out.str());
    REQUIRE(elements.size() == 9);
    CHECK(json::parse(elements[0])["kind"] == "diagram");
    for (std::size_t i = 0; i < 8; ++i) {
        const json cell = json::parse(elements[1 + i]);
        CHECK(cell["object"] == i);
        CHECK(cell["title"] == (i == 3 ? "object 3 (</script>)" : "object " + std::to_string(i)));
        for (const json& m : cell["measures"])
            if (m["name"] == "volume") CHECK(m["value"] == diagram.cells[i].volume);
        std::set<std::string> owners, contacts;
        for (const json& face : cell["faces"]) owners.insert(face["sites"][0].get<std::string>());
        for (const CellContact& contact : diagram.cells[i].contacts) contacts.insert(to_string(contact.site));
        CHECK(owners == contacts);
    }
}
