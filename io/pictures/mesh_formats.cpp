#include "mesh_formats.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <ostream>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "../../envelope/object_distance.hpp"
#include "bytes.hpp"
#include "site_style.hpp"
#include "vtk_arrays.hpp"

namespace vcell {

namespace {

void write(std::ostream& out, const Bytes& data) {
    out.write(data.text().data(), static_cast<std::streamsize>(data.text().size()));
}

}  // namespace

std::int32_t LabelledMesh::label(Site site) {
    if (site.is_object()) return static_cast<std::int32_t>(site.index);
    return site.kind == Site::Kind::BoxSide ? -1 - static_cast<std::int32_t>(site.index) : beside_base;
}

std::size_t LabelledMesh::material(const std::string& name, std::string_view colour) {
    const auto known = std::ranges::find(materials, name, &Material::name);
    if (known == materials.end()) materials.push_back({name, colour});
    return static_cast<std::size_t>(std::ranges::find(materials, name, &Material::name) - materials.begin());
}

void LabelledMesh::add(std::int32_t number, const Cell& of, const CellMesh& mesh,
                       std::optional<std::size_t> colour) {
    const auto before = static_cast<std::uint32_t>(points.size());
    const auto normals_before = static_cast<std::uint32_t>(normals.size());
    Part part{number,
              cell_title(number, of),
              {points.size(), 0},
              {triangles.size(), 0},
              {faces.size(), 0},
              {lines.size(), 0}};
    units = of.scene.units;
    const std::unordered_map<std::uint32_t, std::size_t> colours =
        colour ? std::unordered_map<std::uint32_t, std::size_t>() : object_colours(of);
    constexpr std::string_view grey = "#dddddd";
    const auto material_of = [&](const CellMesh::Group& group) {
        if (colour) return material("c" + std::to_string(*colour), palette()[*colour]);
        if (group.kind != CellMesh::Group::Kind::Face)
            return material(group.kind == CellMesh::Group::Kind::Walls ? "walls" : "the base", grey);
        const Site site = of.faces[group.face].site;
        return material(site_title(of.scene, site),
                        site.is_object() ? palette()[colours.at(site.index)] : grey);
    };

    points.insert(points.end(), mesh.points.begin(), mesh.points.end());
    for (const Vec3& p : mesh.points) clearance.push_back(distance_from(of.scene.base, p));
    for (const CellMesh::Group& group : mesh.groups) {
        const bool is_face = group.kind == CellMesh::Group::Kind::Face;
        const std::int32_t beyond = is_face ? label(group.site) : beside_base;
        for (std::size_t t = group.begin; t < group.end; ++t) {
            const Triangle& v = mesh.triangles[t];
            triangles.push_back({before + v[0], before + v[1], before + v[2]});
            const Triangle& n = mesh.corner_normals[t];
            corner_normals.push_back({normals_before + n[0], normals_before + n[1], normals_before + n[2]});
            cell.push_back(number);
            neighbor.push_back(beyond);
        }
        if (group.begin == group.end) continue;
        const Range range{triangles.size() - (group.end - group.begin), triangles.size()};
        if (colour && faces.size() > part.faces.begin)
            faces.back().triangles.end = range.end;
        else
            faces.push_back({range, material_of(group)});
    }
    normals.insert(normals.end(), mesh.normals.begin(), mesh.normals.end());
    if (!colour)
        for (const auto& line : mesh.edge_lines) {
            if (line.empty()) continue;
            lines.push_back(line);
            for (std::uint32_t& p : lines.back()) p += before;
        }
    part.points.end = points.size();
    part.triangles.end = triangles.size();
    part.faces.end = faces.size();
    part.lines.end = lines.size();
    parts.push_back(std::move(part));
}

void write_stl(std::ostream& out, const LabelledMesh& mesh) {
    std::string header = "Voronoi cell";
    header.resize(80, ' ');
    out << header;
    Bytes data;
    data.add(static_cast<std::uint32_t>(mesh.triangles.size()));
    const auto add = [&](const Vec3& p) {
        for (int k = 0; k < 3; ++k) data.add(static_cast<float>(p[k]));
    };
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        add((b - a).cross(c - a).stableNormalized());
        for (const Vec3* p : {&a, &b, &c}) add(*p);
        data.add(std::uint16_t{0});
    }
    write(out, data);
}

void write_ply(std::ostream& out, const LabelledMesh& mesh) {
    out << "ply\nformat binary_little_endian 1.0\ncomment Voronoi cells\nelement vertex "
        << mesh.points.size()
        << "\nproperty double x\nproperty double y\nproperty double z\nproperty double clearance\nelement face "
        << mesh.triangles.size()
        << "\nproperty list uchar int vertex_indices\nproperty int cell\nproperty int neighbor\nend_header\n";
    Bytes data;
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        for (int k = 0; k < 3; ++k) data.add(mesh.points[i][k]);
        data.add(mesh.clearance[i]);
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        data.add(std::uint8_t{3});
        for (int k = 0; k < 3; ++k) data.add(static_cast<std::int32_t>(mesh.triangles[t][k]));
        data.add(mesh.cell[t]);
        data.add(mesh.neighbor[t]);
    }
    write(out, data);
}

void write_vtu(std::ostream& out, const LabelledMesh& mesh) {
    const std::size_t count = mesh.triangles.size();
    out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\""
        << mesh.points.size() << "\" NumberOfCells=\"" << count << "\">\n<PointData Scalars=\"clearance\">\n";
    write_array(out, "type=\"Float64\" Name=\"clearance\"", mesh.clearance);
    out << "</PointData>\n<CellData Scalars=\"cell\">\n";
    write_array(out, "type=\"Int32\" Name=\"cell\"", mesh.cell);
    write_array(out, "type=\"Int32\" Name=\"neighbor\"", mesh.neighbor);
    for (const LabelledMesh::Numbers& numbers : mesh.numbers)
        write_array(out, fmt::format("type=\"Float64\" Name=\"{}\"", numbers.name), sizeof(double) * count,
                    [&](Bytes& data) {
                        for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
                            const LabelledMesh::Range& of = mesh.parts[p].triangles;
                            for (std::size_t t = of.begin; t < of.end; ++t) data.add(numbers.of_parts[p]);
                        }
                    });
    out << "</CellData>\n<Points>\n";
    write_array(out, "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
                3 * sizeof(double) * mesh.points.size(), [&](Bytes& data) {
                    for (const Vec3& p : mesh.points)
                        for (int k = 0; k < 3; ++k) data.add(p[k]);
                });
    out << "</Points>\n<Cells>\n";
    // VTK keeps numbers of 32 bits as they are, and they are a third of the file less.
    const auto write_numbers = [&]<class Number>(std::string_view type, Number) {
        write_array(out, fmt::format("type=\"{}\" Name=\"connectivity\"", type), 3 * sizeof(Number) * count,
                    [&](Bytes& data) {
                        for (const Triangle& t : mesh.triangles)
                            for (int k = 0; k < 3; ++k) data.add(static_cast<Number>(t[k]));
                    });
        write_array(out, fmt::format("type=\"{}\" Name=\"offsets\"", type), sizeof(Number) * count,
                    [&](Bytes& data) {
                        for (std::size_t t = 1; t <= count; ++t) data.add(static_cast<Number>(3 * t));
                    });
    };
    if (std::max(mesh.points.size(), 3 * count) <= INT32_MAX)
        write_numbers("Int32", std::int32_t());
    else
        write_numbers("Int64", std::int64_t());
    write_array(out, "type=\"UInt8\" Name=\"types\"", count, [&](Bytes& data) {
        constexpr std::uint8_t triangle = 5;
        for (std::size_t t = 0; t < count; ++t) data.add(triangle);
    });
    out << "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

namespace {
struct Format {
    std::string_view name;
    void (*write)(std::ostream&, const LabelledMesh&);
};
constexpr std::array<Format, 5> formats{
    {{"stl", write_stl}, {"ply", write_ply}, {"vtu", write_vtu}, {"glb", write_glb}, {"3mf", write_3mf}}};
}  // namespace

bool is_mesh_format(std::string_view name) {
    return std::ranges::find(formats, name, &Format::name) != formats.end();
}

void write_mesh(std::ostream& out, std::string_view format, const LabelledMesh& mesh) {
    std::ranges::find(formats, format, &Format::name)->write(out, mesh);
}

}  // namespace vcell
