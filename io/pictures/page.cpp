#include "page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "../files/json_writer.hpp"
#include "../files/scene_json.hpp"
#include "../files/text.hpp"
#include "bytes.hpp"
#include "page_parts.hpp"
#include "site_style.hpp"
#include "svg.hpp"

namespace vcell {

namespace {

// three.js asks that its notice stays with it.
constexpr std::string_view three_notice = R"(<!-- The first script below is three.js (threejs.org).
Copyright 2010-2019 three.js authors.

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions: The above copyright notice and
this permission notice shall be included in all copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. -->
)";

// The page may load nothing: whatever its scripts tried, the browser would refuse.
constexpr std::string_view policy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// One `script` element of JSON. `write` gets a JsonWriter.
template <class Write>
void data_element(std::ostream& out, std::string_view attributes, Write&& write) {
    std::ostringstream json;
    JsonWriter writer(json);
    write(writer);
    writer.finish();
    out << "<script type=\"application/json\" " << attributes << ">\n";
    // '<' stands in strings only. Without it no name ends the element, or begins a comment in it.
    std::string text;
    for (const char c : json.str())
        if (c == '<')
            text += "\\u003c";
        else
            text += c;
    out << text << "\n</script>\n";
}

std::string with(std::string text, std::string_view place, std::string_view by) {
    if (const std::size_t at = text.find(place); at != text.npos) text.replace(at, place.size(), by);
    return text;
}

void begin(std::ostream& out, const std::string& title, const std::string& summary,
           const std::string& diagram) {
    if (!has_pages()) throw std::logic_error("vcell was built without three.js: there are no pages");
    out << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
           "<meta http-equiv=\"Content-Security-Policy\" content=\""
        << policy << "\">\n<title>" << xml_escaped(title) << "</title>\n<style>\n"
        << page_parts::style << "</style>\n</head>\n<body>\n";
    std::string body(page_parts::body);
    body = with(std::move(body), "<!--title-->", xml_escaped(title));
    body = with(std::move(body), "<!--summary-->", xml_escaped(summary));
    out << with(std::move(body), "<!--diagram-->", diagram);
}

void end(std::ostream& out) {
    out << three_notice << "<script>" << page_parts::three << "</script>\n<script>\n"
        << page_parts::script << "</script>\n</body>\n</html>\n";
}

std::string plural(std::size_t n, const char* one, const char* many) {
    return fmt::format("{} {}", n, n == 1 ? one : many);
}

// ---- One cell as JSON ----------------------------------------------------------------------------

class CellData {
public:
    CellData(JsonWriter& out, const Cell& cell, const CellMesh& mesh) : out_(out), cell_(cell), mesh_(mesh) {
        for (const Vec3& p : mesh_.points) origin_ += p / static_cast<double>(mesh_.points.size());
        for (const Vec3& p : mesh_.points) scale_ = std::max(scale_, (p - origin_).lpNorm<Eigen::Infinity>());
        if (scale_ == 0) scale_ = 1;
    }

    /// `title(site)` is how the page calls it, `colour(site)` one of the palette, if it has one.
    template <class Title, class Colour>
    void members(Title&& title, Colour&& colour) {
        sites(title, colour);
        out_.line_key("measures").array([&] { measures(cell_.measures); });
        out_.line_key("faces").lines(cell_.faces, [&](const CellFace& f) { face(f); });
        out_.line_key("edges").lines(cell_.edges, [&](const CellEdge& e) { edge(e); });
        out_.line_key("vertices").lines(cell_.vertices, [&](const CellVertex& v) { vertex(v); });
        out_.line_key("warnings").value(cell_.report.warnings);
        out_.line_key("mesh").object([&] { mesh(); });
    }

private:
    template <class Title, class Colour>
    void sites(Title&& title, Colour&& colour) {
        std::map<Site, bool> all;
        for (const CellFace& f : cell_.faces) {
            all[f.site];
            for (const Site s : f.extra_sites) all[s];
        }
        for (const CellEdge& e : cell_.edges) {
            for (const Site s : e.sites) all[s];
            for (const Site s : e.extra_sites) all[s];
        }
        for (const CellVertex& v : cell_.vertices)
            for (const Site s : v.sites) all[s];
        out_.line_key("sites").object([&] {
            for (const auto& [site, _] : all)
                out_.line_key(to_string(site)).object([&] {
                    out_.key("title").value(title(site));
                    if (const std::optional<std::size_t> c = colour(site)) out_.key("colour").value(*c);
                });
        });
    }

    // A number that was not asked for is left out.
    void measure(const char* name, double value, double error, bool is_estimated) {
        if (!std::isfinite(value)) return;
        out_.object([&] {
            out_.key("name").value(name);
            number("value", value, error, is_estimated);
        });
    }
    void number(const char* key, double value, double error, bool is_estimated) {
        if (!std::isfinite(value)) return;
        out_.key(key).value(value);
        out_.key("error").value(error);
        if (is_estimated) out_.key("estimated").value(true);
    }
    void measures(const Measures& m) {
        measure("volume", m.volume, m.volume_error, m.is_estimated);
        measure("volume of the base's body", m.body_volume, m.body_volume_error, false);
        measure("area beside objects", m.area, m.area_error, m.is_estimated);
        measure("area on the box", m.box_area, m.box_area_error, m.is_estimated);
        measure("area of the base region", m.base_area, m.base_area_error, false);
        measure("least clearance", m.min_clearance, m.min_clearance_error, false);
        measure("largest clearance", m.max_clearance, m.max_clearance_error, false);
    }

    template <class Sites>
    void site_list(const Sites& sites) {
        for (const Site s : sites) out_.value(to_string(s));
    }

    void face(const CellFace& f) {
        out_.object([&] {
            out_.key("sites").array([&] {
                out_.value(to_string(f.site));
                site_list(f.extra_sites);
            });
            out_.key("bisector").value(f.bisector);
            number("area", f.area, f.area_error, f.is_estimated);
        });
    }

    void edge(const CellEdge& e) {
        out_.object([&] {
            out_.key("sites").array([&] {
                site_list(e.sites);
                site_list(e.extra_sites);
            });
            out_.key("kind").value(to_string(e.kind));
            number("length", e.length, e.length_error, e.is_estimated);
        });
    }

    void vertex(const CellVertex& v) {
        out_.object([&] {
            out_.key("point").value(v.point);
            out_.key("clearance").value(v.radius);
            out_.key("error").value(v.error);
            out_.key("sites").array([&] { site_list(v.sites); });
        });
    }

    // Scenes come in any unit, single precision does not hold all.
    Vec3 relative(const Vec3& p) const { return (p - origin_) / scale_; }

    // A viewer wants one normal to a point: corners of triangles that differ in one of them are points of
    // their own, and so are those of different faces.
    struct Part {
        const char* kind;
        std::uint32_t face;
        std::size_t begin, end;
    };
    void mesh() {
        Bytes points, normals, lines;
        const auto add_point = [&](Bytes& bytes, const Vec3& p) {
            for (int k = 0; k < 3; ++k) bytes.add(static_cast<float>(relative(p)[k]));
        };
        const auto add_normal = [&](const Vec3& n) {
            for (int k = 0; k < 3; ++k) normals.add(static_cast<std::int8_t>(std::lround(127 * n[k])));
        };
        std::uint32_t count = 0;
        std::vector<Part> parts;
        std::vector<std::uint32_t> corners;
        for (const CellMesh::Group& g : mesh_.groups) {
            const bool is_face = g.kind == CellMesh::Group::Kind::Face;
            const char* other = g.kind == CellMesh::Group::Kind::Walls ? "walls" : "base";
            parts.push_back({is_face ? "face" : other, g.face, g.begin, g.end});
            std::map<std::array<std::uint32_t, 2>, std::uint32_t> known;
            for (std::size_t t = g.begin; t < g.end; ++t)
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t p = mesh_.triangles[t][k], n = mesh_.corner_normals[t][k];
                    const auto [at, is_new] = known.try_emplace({p, n}, count);
                    if (is_new) {
                        add_point(points, mesh_.points[p]);
                        add_normal(mesh_.normals[n]);
                        ++count;
                    }
                    corners.push_back(at->second);
                }
        }
        Bytes triangles;  // two bytes a corner where that is enough
        for (const std::uint32_t c : corners)
            if (count > 65536)
                triangles.add(c);
            else
                triangles.add(static_cast<std::uint16_t>(c));
        out_.key("origin").value(origin_);
        out_.key("scale").value(scale_);
        out_.key("points").value(base64(points.text()));
        out_.key("normals").value(base64(normals.text()));
        out_.key("triangles").value(base64(triangles.text()));
        out_.line_key("parts").lines(parts, [&](const Part& part) {
            out_.object([&] {
                out_.key("kind").value(part.kind);
                if (std::string_view(part.kind) == "face") out_.key("face").value(part.face);
                out_.key("begin").value(part.begin);
                out_.key("end").value(part.end);
            });
        });
        out_.line_key("line_points").array([&] {
            for (const auto& line : mesh_.edge_lines) {
                out_.value(line.size());
                for (const std::uint32_t p : line) add_point(lines, mesh_.points[p]);
            }
        });
        out_.key("lines").value(base64(lines.text()));
    }

    JsonWriter& out_;
    const Cell& cell_;
    const CellMesh& mesh_;
    Vec3 origin_ = Vec3::Zero();
    double scale_ = 0;
};

void write_palette(JsonWriter& out) {
    out.line_key("palette").array([&] {
        for (const std::string_view colour : palette()) out.value(colour);
    });
}

const char* word_of(const Object& object) {
    constexpr std::array words{"plane", "ball", "tube"};  // in the order of the variant
    return words[object.index()];
}

}  // namespace

bool has_pages() { return !page_parts::three.empty(); }

void write_page(std::ostream& out, const Cell& cell, const CellMesh& mesh) {
    const Scene& scene = cell.scene;
    std::string title = fmt::format("Voronoi cell of a {}", word_of(scene.base));
    if (!scene.base_name.empty()) title += fmt::format(", {}", scene.base_name);
    const std::string summary =
        fmt::format("among {}: {}, {}, {}", plural(scene.objects.size(), "object", "objects"),
                    plural(cell.faces.size(), "face", "faces"), plural(cell.edges.size(), "edge", "edges"),
                    plural(cell.vertices.size(), "vertex", "vertices"));
    std::ostringstream diagram;
    write_svg(diagram, cell);
    begin(out, title, summary, diagram.str());
    data_element(out, "id=\"scene\"", [&](JsonWriter& json) {
        json.object([&] {
            json.key("kind").value("cell");
            write_palette(json);
            json.line_key("scene");
            write_scene_value(json, scene);
        });
    });
    const auto colours = object_colours(cell);
    data_element(out, "class=\"cell\"", [&](JsonWriter& json) {
        json.object([&] {
            json.key("title").value("the cell");
            CellData(json, cell, mesh)
                .members([&](Site s) { return site_title(scene, s); },
                         [&](Site s) -> std::optional<std::size_t> {
                             const auto c = s.is_object() ? colours.find(s.index) : colours.end();
                             if (c == colours.end()) return std::nullopt;
                             return c->second;
                         });
        });
    });
    end(out);
}

// ---- Whole diagrams ------------------------------------------------------------------------------

DiagramPage::DiagramPage(std::ostream& out, const DiagramScene& scene) : out_(out), scene_(scene) {
    begin(out_, "Voronoi diagram", plural(scene.objects.size(), "object", "objects"), "");
    Scene all;
    all.objects = scene.objects;
    all.names = scene.names;
    all.box = scene.box;
    all.units = scene.units;
    if (!all.objects.empty()) all.base = all.objects[0];
    data_element(out_, "id=\"scene\"", [&](JsonWriter& json) {
        json.object([&] {
            json.key("kind").value("diagram");
            write_palette(json);
            json.line_key("scene");
            write_scene_value(json, all);
        });
    });
}

void DiagramPage::add(std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
    const auto named = [](std::string title, const std::vector<std::string>& names, std::size_t i) {
        if (i < names.size() && !names[i].empty()) title += fmt::format(" ({})", names[i]);
        return title;
    };
    // Where the box repeats sites are places in the cell's own scene, as images have no numbers.
    const auto title = [&](Site s) {
        if (!s.is_object()) return site_title(cell.scene, s);
        if (!scene_.is_periodic()) return named(fmt::format("object {}", s.index), scene_.names, s.index);
        const auto* ball = std::get_if<Sphere>(&cell.scene.objects[s.index]);
        if (ball == nullptr) return object_title(cell.scene, s.index);
        const Vec3& c = ball->center;
        return named(fmt::format("the ball at ({:.4g}, {:.4g}, {:.4g})", c.x(), c.y(), c.z()),
                     cell.scene.names, s.index);
    };
    data_element(out_, "class=\"cell\"", [&](JsonWriter& json) {
        json.object([&] {
            json.key("object").value(object);
            json.key("title").value(named(fmt::format("object {}", object), scene_.names, object));
            json.key("colour").value(colours_.add(object, cell));
            CellData(json, cell, mesh).members(title, [](Site) { return std::optional<std::size_t>(); });
        });
    });
}

void DiagramPage::finish() { end(out_); }

}  // namespace vcell
