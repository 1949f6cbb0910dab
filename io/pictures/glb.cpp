// Binary glTF [Gltf21]: one chunk of JSON, and one of the numbers that it points into.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../files/files.hpp"
#include "../files/json_writer.hpp"
#include "bytes.hpp"
#include "mesh_formats.hpp"
#include "site_style.hpp"

namespace vcell {

namespace {

// The names that glTF has for these as numbers.
constexpr std::uint32_t type_float = 5126, type_unsigned_int = 5125, vertices_target = 34962,
                        indices_target = 34963, mode_line_strip = 3, mode_triangles = 4;

constexpr std::size_t vector_size = 3 * sizeof(float), index_size = sizeof(std::uint32_t);

/// A run of vectors or of indices.
struct Accessor {
    bool is_index;
    std::size_t begin, count;        // in the bytes of its kind; elements
    std::optional<Box> bounds = {};  // of positions, as they are in the file
};

struct Primitive {
    std::size_t position;
    std::optional<std::size_t> normal, indices;  // without them: a strip of lines
    std::size_t material;
    std::int32_t neighbor;
};

class Glb {
public:
    explicit Glb(const LabelledMesh& mesh) : mesh_(mesh), line_material_(mesh.materials.size()) {
        for (const LabelledMesh::Part& part : mesh.parts) add(part);
    }

    void write(std::ostream& out) const {
        std::ostringstream text;
        write_json(text);
        std::string json = std::move(text).str();
        json.resize((json.size() + 3) / 4 * 4, ' ');
        const std::size_t size = vectors_.text().size() + indices_.text().size();
        constexpr std::size_t headers = 12 + 2 * 8;
        if (headers + json.size() + size > UINT32_MAX)
            throw WriteError("a .glb file holds no more than 4 GB");
        const auto number = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
        Bytes begin, middle;
        begin.add_text("glTF");
        begin.add(std::uint32_t{2});
        begin.add(number(headers - (size == 0 ? 8 : 0) + json.size() + size));
        begin.add(number(json.size()));
        begin.add_text("JSON");
        out << begin.text() << json;
        if (size == 0) return;
        middle.add(number(size));
        middle.add_text({"BIN\0", 4});
        out << middle.text() << vectors_.text() << indices_.text();
    }

private:
    struct Node {
        Vec3 center;
        std::vector<Primitive> primitives;
        std::size_t mesh;  // where there are primitives
    };

    void add(const LabelledMesh::Part& part) {
        Vec3 low = Vec3::Constant(INFINITY), high = -low;
        for (std::size_t i = part.points.begin; i < part.points.end; ++i) {
            low = low.cwiseMin(mesh_.points[i]);
            high = high.cwiseMax(mesh_.points[i]);
        }
        Node node{0.5 * (low + high), {}, meshes_};
        for (std::size_t f = part.faces.begin; f < part.faces.end; ++f)
            node.primitives.push_back(face(mesh_.faces[f], node.center));
        for (std::size_t i = part.lines.begin; i < part.lines.end; ++i) {
            std::vector<Vec3> points;
            for (const std::uint32_t p : mesh_.lines[i]) points.push_back(mesh_.points[p] - node.center);
            if (points.size() < 2) continue;
            node.primitives.push_back({positions(points), {}, {}, line_material_, 0});
            has_lines_ = true;
        }
        if (!node.primitives.empty()) ++meshes_;
        nodes_.push_back(std::move(node));
    }

    // Corners are the same vertex where point and normal are.
    Primitive face(const LabelledMesh::Face& face, const Vec3& center) {
        std::unordered_map<std::uint64_t, std::uint32_t> known;
        std::vector<Vec3> points, normals;
        Accessor indices{true, indices_.text().size(), 0};
        for (std::size_t t = face.triangles.begin; t < face.triangles.end; ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t p = mesh_.triangles[t][k], n = mesh_.corner_normals[t][k];
                const auto [vertex, is_new] =
                    known.try_emplace(std::uint64_t{p} << 32 | n, static_cast<std::uint32_t>(points.size()));
                if (is_new) {
                    points.push_back(mesh_.points[p] - center);
                    normals.push_back(mesh_.normals[n]);
                }
                indices_.add(vertex->second);
                ++indices.count;
            }
        const std::size_t position = positions(points), normal = vectors(normals);
        accessors_.push_back(indices);
        return {position, normal, accessors_.size() - 1, face.material, mesh_.neighbor[face.triangles.begin]};
    }

    std::size_t vectors(const std::vector<Vec3>& of) {
        accessors_.push_back({false, vectors_.text().size(), of.size()});
        for (const Vec3& v : of)
            for (const double x : v) vectors_.add(static_cast<float>(x));
        return accessors_.size() - 1;
    }
    std::size_t positions(const std::vector<Vec3>& of) {
        Box bounds{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
        for (const Vec3& p : of)
            for (int k = 0; k < 3; ++k) {
                const double rounded = static_cast<float>(p[k]);
                bounds.min[k] = std::min(bounds.min[k], rounded);
                bounds.max[k] = std::max(bounds.max[k], rounded);
            }
        const std::size_t result = vectors(of);
        accessors_[result].bounds = bounds;
        return result;
    }

    // ---- JSON -------------------------------------------------------------------------------------------

    void write_json(std::ostream& out) const {
        JsonWriter json(out);
        json.object([&] {
            json.key("asset").object([&] {
                json.key("version").value("2.0");
                json.key("generator").value("vcell");
            });
            json.key("scene").value(0);
            json.key("scenes").array(
                [&] { json.object([&] { json.key("nodes").value(std::vector<std::uint32_t>{0}); }); });
            write_nodes(json);
            // glTF has no empty arrays.
            if (accessors_.empty()) return;
            write_meshes(json);
            write_materials(json);
            write_accessors(json);
            write_buffer(json);
        });
        json.finish();
    }

    void write_nodes(JsonWriter& json) const {
        json.line_key("nodes").array([&] {
            json.object([&] {
                json.key("name").value("Voronoi cells");
                // glTF's y is upwards: a quarter turn about x takes z there.
                const double half = std::sqrt(0.5);
                json.key("rotation").value(std::vector<double>{-half, 0, 0, half});
                json.key("extras").object([&] { json.key("units").value(mesh_.units); });
                if (nodes_.empty()) return;
                json.key("children").array([&] {
                    for (std::size_t i = 0; i < nodes_.size(); ++i) json.value(std::uint64_t{i + 1});
                });
            });
            for (std::size_t i = 0; i < nodes_.size(); ++i)
                json.object([&] {
                    json.key("name").value(mesh_.parts[i].title);
                    json.key("translation").value(nodes_[i].center);
                    if (!nodes_[i].primitives.empty()) json.key("mesh").value(std::uint64_t{nodes_[i].mesh});
                });
        });
    }

    void write_meshes(JsonWriter& json) const {
        json.line_key("meshes").array([&] {
            for (std::size_t i = 0; i < nodes_.size(); ++i) {
                if (nodes_[i].primitives.empty()) continue;
                json.object([&] {
                    json.key("name").value(mesh_.parts[i].title);
                    json.key("primitives").lines(nodes_[i].primitives, [&](const Primitive& p) {
                        json.object([&] { write_primitive(json, p); });
                    });
                });
            }
        });
    }

    void write_primitive(JsonWriter& json, const Primitive& p) const {
        json.key("attributes").object([&] {
            json.key("POSITION").value(std::uint64_t{p.position});
            if (p.normal) json.key("NORMAL").value(std::uint64_t{*p.normal});
        });
        if (p.indices) json.key("indices").value(std::uint64_t{*p.indices});
        json.key("material").value(std::uint64_t{p.material});
        json.key("mode").value(p.indices ? mode_triangles : mode_line_strip);
        if (p.indices && p.material < mesh_.materials.size())
            json.key("extras").object([&] {
                json.key("material").value(mesh_.materials[p.material].name);
                json.key("neighbor").value(static_cast<double>(p.neighbor));
            });
    }

    void write_materials(JsonWriter& json) const {
        const auto write = [&](const std::string& name, std::string_view colour) {
            json.object([&] {
                json.key("name").value(name);
                json.key("doubleSided").value(true);
                json.key("pbrMetallicRoughness").object([&] {
                    std::vector<double> factor;
                    for (const int c : channels(colour)) factor.push_back(linear(c / 255.0));
                    factor.push_back(1);
                    json.key("baseColorFactor").value(factor);
                    json.key("metallicFactor").value(0.0);
                    json.key("roughnessFactor").value(0.75);
                });
            });
        };
        json.line_key("materials").array([&] {
            for (const LabelledMesh::Material& m : mesh_.materials) write(m.name, m.colour);
            if (has_lines_) write("edges", "#222222");
        });
    }

    // glTF's colours are linear in light [Gltf21, section 3.9.2]; those of the web are sRGB's.
    static double linear(double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); }

    void write_accessors(JsonWriter& json) const {
        json.line_key("accessors").lines(accessors_, [&](const Accessor& a) {
            json.object([&] {
                json.key("bufferView").value(a.is_index ? 1 : 0);
                json.key("byteOffset").value(std::uint64_t{a.begin});
                json.key("componentType").value(a.is_index ? type_unsigned_int : type_float);
                json.key("count").value(std::uint64_t{a.count});
                json.key("type").value(a.is_index ? "SCALAR" : "VEC3");
                if (!a.bounds) return;
                json.key("min").value(a.bounds->min);
                json.key("max").value(a.bounds->max);
            });
        });
    }

    void write_buffer(JsonWriter& json) const {
        const std::uint64_t vectors = vectors_.text().size(), indices = indices_.text().size();
        json.line_key("bufferViews").array([&] {
            json.object([&] {
                json.key("buffer").value(0);
                json.key("byteLength").value(vectors);
                json.key("byteStride").value(std::uint64_t{vector_size});
                json.key("target").value(vertices_target);
            });
            if (indices == 0) return;
            json.object([&] {
                json.key("buffer").value(0);
                json.key("byteOffset").value(vectors);
                json.key("byteLength").value(indices);
                json.key("target").value(indices_target);
            });
        });
        json.line_key("buffers").array(
            [&] { json.object([&] { json.key("byteLength").value(vectors + indices); }); });
    }

    const LabelledMesh& mesh_;
    const std::size_t line_material_;  // after the mesh's
    bool has_lines_ = false;
    Bytes vectors_, indices_;
    std::vector<Accessor> accessors_;
    std::vector<Node> nodes_;
    std::size_t meshes_ = 0;
};

}  // namespace

void write_glb(std::ostream& out, const LabelledMesh& mesh) { Glb(mesh).write(out); }

}  // namespace vcell
