#include "obj.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <set>

#include "site_style.hpp"

namespace vcell {

namespace {

class Output {
public:
    explicit Output(std::ostream& out) : out_(out) {}
    ~Output() { flush(); }

    /// The format is one of FMT_COMPILE: taken apart for each number again, formats took half of the time.
    template <class Format, class... Args>
    void print(const Format& format, const Args&... args) {
        fmt::format_to(fmt::appender(buffer_), format, args...);
        constexpr std::size_t enough = 1 << 16;
        if (buffer_.size() > enough) flush();
    }

private:
    void flush() {
        out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
        buffer_.clear();
    }
    std::ostream& out_;
    fmt::memory_buffer buffer_;
};

/// "object_7", "box_-x"
std::string owner(Site site) {
    if (site.is_object()) return fmt::format("object_{}", site.index);
    std::string name = to_string(site);
    std::replace(name.begin(), name.end(), ':', '_');
    return name;
}

}  // namespace

// material(group) is the name of its material, empty for none.
template <class Material>
static void write_mesh(Output& out, const CellMesh& mesh, const ObjPart& part, Material&& material) {
    for (const Vec3& p : mesh.points) out.print(FMT_COMPILE("v {} {} {}\n"), p.x(), p.y(), p.z());
    for (const Vec3& n : mesh.normals)
        out.print(FMT_COMPILE("vn {:.6g} {:.6g} {:.6g}\n"), n.x(), n.y(), n.z());
    const std::size_t v0 = part.points + 1, n0 = part.normals + 1;
    for (const CellMesh::Group& g : mesh.groups) {
        std::string who = "base";
        std::string group = g.kind == CellMesh::Group::Kind::Walls ? "walls" : "base";
        if (g.kind == CellMesh::Group::Kind::Face) {
            who = owner(g.site);
            group = fmt::format("face_{}_{}", g.face, who);
        }
        out.print(FMT_COMPILE("g {}\n"), group);
        if (const std::string name = material(who); !name.empty())
            out.print(FMT_COMPILE("usemtl {}\n"), name);
        for (std::size_t t = g.begin; t < g.end; ++t) {
            const Triangle &v = mesh.triangles[t], &n = mesh.corner_normals[t];
            out.print(FMT_COMPILE("f {}//{} {}//{} {}//{}\n"), v0 + v[0], n0 + n[0], v0 + v[1], n0 + n[1],
                      v0 + v[2], n0 + n[2]);
        }
    }
}

void write_obj_mesh(std::ostream& stream, const CellMesh& mesh, const ObjPart& part) {
    Output out(stream);
    write_mesh(out, mesh, part, [&](const std::string&) { return part.material; });
}

void write_obj(std::ostream& stream, const Cell& cell, const CellMesh& mesh,
               const std::string& material_file) {
    Output out(stream);
    out.print(FMT_COMPILE("# Voronoi cell, {} faces\n"), cell.faces.size());
    if (!material_file.empty()) out.print(FMT_COMPILE("mtllib {}\n"), material_file);
    write_mesh(out, mesh, {},
               [&](const std::string& who) { return material_file.empty() ? std::string() : who; });
    out.print(FMT_COMPILE("g edges\n"));
    for (const auto& line : mesh.edge_lines) {
        if (line.empty()) continue;
        out.print(FMT_COMPILE("l"));
        for (const std::uint32_t p : line) out.print(FMT_COMPILE(" {}"), p + 1);
        out.print(FMT_COMPILE("\n"));
    }
}

void write_material(std::ostream& stream, const std::string& name, std::string_view colour) {
    const auto [red, green, blue] = channels(colour);
    Output(stream).print(FMT_COMPILE("newmtl {}\nKd {:.4f} {:.4f} {:.4f}\n"), name, red / 255.0,
                         green / 255.0, blue / 255.0);
}

void write_mtl(std::ostream& stream, const Cell& cell) {
    const auto colours = object_colours(cell);
    constexpr std::string_view grey = "#dddddd";
    std::set<Site> sites;
    for (const CellFace& f : cell.faces) sites.insert(f.site);
    for (const Site s : sites)
        write_material(stream, owner(s), s.is_object() ? palette()[colours.at(s.index)] : grey);
    write_material(stream, "base", grey);
}

}  // namespace vcell
