// 3MF [Manufacturing21]: an archive of a model in XML and of what says that it is one.
#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "../files/text.hpp"
#include "mesh_formats.hpp"
#include "zip.hpp"

namespace vcell {

namespace {

constexpr const char* types =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";

constexpr const char* relations =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="model" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

std::string_view unit_of(const std::string& units) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 7> known{{{"m", "meter"},
                                                                                  {"cm", "centimeter"},
                                                                                  {"um", "micron"},
                                                                                  {"\u00b5m", "micron"},
                                                                                  {"in", "inch"},
                                                                                  {"ft", "foot"},
                                                                                  {"mm", "millimeter"}}};
    const auto unit = std::ranges::find(known, units, [](const auto& k) { return k.first; });
    return unit == known.end() ? std::string_view("millimeter") : unit->second;
}

/// Has every side its opposite, once each?
bool is_closed(const LabelledMesh& mesh, const LabelledMesh::Range& triangles) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides, opposite;
    for (std::size_t t = triangles.begin; t < triangles.end; ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            sides.emplace_back(a, b);
            opposite.emplace_back(b, a);
        }
    std::ranges::sort(sides);
    std::ranges::sort(opposite);
    return sides == opposite && std::ranges::adjacent_find(sides) == sides.end();
}

// Resources are numbered: 1 is all materials, objects come after it.
constexpr std::size_t first_object = 2;

class Model {
public:
    explicit Model(const LabelledMesh& mesh) : mesh_(mesh) {}

    std::string text() {
        print(FMT_COMPILE(
                  "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{}\" xml:lang=\"en-US\" "
                  "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n"),
              unit_of(mesh_.units));
        if (!mesh_.materials.empty()) {
            print(FMT_COMPILE("<basematerials id=\"1\">\n"));
            for (const LabelledMesh::Material& m : mesh_.materials)
                print(FMT_COMPILE("<base name=\"{}\" displaycolor=\"{}\"/>\n"), xml_escaped(m.name),
                      m.colour);
            print(FMT_COMPILE("</basematerials>\n"));
        }
        for (std::size_t i = 0; i < mesh_.parts.size(); ++i) add(mesh_.parts[i], i + first_object);
        print(FMT_COMPILE("</resources>\n<build>\n"));
        for (std::size_t i = 0; i < mesh_.parts.size(); ++i)
            if (has_triangles(mesh_.parts[i]))
                print(FMT_COMPILE("<item objectid=\"{}\"/>\n"), i + first_object);
        print(FMT_COMPILE("</build>\n</model>\n"));
        return std::move(text_);
    }

private:
    template <class Format, class... Args>
    void print(const Format& format, const Args&... args) {
        fmt::format_to(std::back_inserter(text_), format, args...);
    }

    static bool has_triangles(const LabelledMesh::Part& part) {
        return part.triangles.begin < part.triangles.end;
    }

    void add(const LabelledMesh::Part& part, std::size_t number) {
        if (!has_triangles(part)) return;
        const std::size_t material = mesh_.faces[part.faces.begin].material;
        print(FMT_COMPILE(
                  "<object id=\"{}\" type=\"{}\" name=\"{}\" pid=\"1\" pindex=\"{}\"><mesh>\n<vertices>\n"),
              number, is_closed(mesh_, part.triangles) ? "model" : "surface", xml_escaped(part.title),
              material);
        for (std::size_t i = part.points.begin; i < part.points.end; ++i)
            print(FMT_COMPILE("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n"), mesh_.points[i].x(),
                  mesh_.points[i].y(), mesh_.points[i].z());
        print(FMT_COMPILE("</vertices>\n<triangles>\n"));
        for (std::size_t f = part.faces.begin; f < part.faces.end; ++f) {
            const LabelledMesh::Face& face = mesh_.faces[f];
            for (std::size_t t = face.triangles.begin; t < face.triangles.end; ++t) {
                const auto corner = [&](std::size_t k) { return mesh_.triangles[t][k] - part.points.begin; };
                print(FMT_COMPILE("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\""), corner(0), corner(1),
                      corner(2));
                if (face.material != material) print(FMT_COMPILE(" pid=\"1\" p1=\"{}\""), face.material);
                print(FMT_COMPILE("/>\n"));
            }
        }
        print(FMT_COMPILE("</triangles>\n</mesh></object>\n"));
    }

    const LabelledMesh& mesh_;
    std::string text_;
};

}  // namespace

void write_3mf(std::ostream& out, const LabelledMesh& mesh) {
    std::vector<ZipEntry> entries;
    entries.push_back({"[Content_Types].xml", types});
    entries.push_back({"_rels/.rels", relations});
    entries.push_back({"3D/3dmodel.model", Model(mesh).text()});
    write_zip(out, entries);
}

}  // namespace vcell
