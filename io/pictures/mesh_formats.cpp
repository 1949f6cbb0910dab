#include "mesh_formats.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <ostream>
#include <string_view>

#include "../../envelope/object_distance.hpp"
#include "bytes.hpp"

namespace vcell {

namespace {

void write(std::ostream& out, const Bytes& data) {
    out.write(data.text().data(), static_cast<std::streamsize>(data.text().size()));
}

// An array of a .vtu: before its bytes goes their number.
template <class Fill>
void write_array(std::ostream& out, std::string_view attributes, std::size_t bytes, Fill&& fill) {
    Bytes data;
    data.add(static_cast<std::uint64_t>(bytes));
    fill(data);
    out << "<DataArray " << attributes << " format=\"binary\">\n";
    out << base64(data.text()) << "\n</DataArray>\n";
}
template <class T>
void write_array(std::ostream& out, std::string_view attributes, const std::vector<T>& values) {
    write_array(out, attributes, sizeof(T) * values.size(), [&](Bytes& data) {
        for (const T& value : values) data.add(value);
    });
}

std::int32_t label(Site site) {
    if (site.is_object()) return static_cast<std::int32_t>(site.index);
    return site.kind == Site::Kind::BoxSide ? -1 - static_cast<std::int32_t>(site.index)
                                            : LabelledMesh::beside_base;
}

}  // namespace

void LabelledMesh::add(std::int32_t number, const Cell& of, const CellMesh& mesh) {
    const auto before = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), mesh.points.begin(), mesh.points.end());
    for (const Vec3& p : mesh.points) clearance.push_back(distance_from(of.scene.base, p));
    for (const CellMesh::Group& group : mesh.groups) {
        const bool is_face = group.kind == CellMesh::Group::Kind::Face;
        const std::int32_t beyond = is_face ? label(of.faces[group.face].site) : beside_base;
        for (std::size_t t = group.begin; t < group.end; ++t) {
            const Triangle& v = mesh.triangles[t];
            triangles.push_back({before + v[0], before + v[1], before + v[2]});
            cell.push_back(number);
            neighbor.push_back(beyond);
        }
    }
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
    out << "</CellData>\n<Points>\n";
    write_array(out, "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"",
                3 * sizeof(double) * mesh.points.size(), [&](Bytes& data) {
                    for (const Vec3& p : mesh.points)
                        for (int k = 0; k < 3; ++k) data.add(p[k]);
                });
    out << "</Points>\n<Cells>\n";
    write_array(out, "type=\"Int64\" Name=\"connectivity\"", 3 * sizeof(std::int64_t) * count,
                [&](Bytes& data) {
                    for (const Triangle& t : mesh.triangles)
                        for (int k = 0; k < 3; ++k) data.add(static_cast<std::int64_t>(t[k]));
                });
    write_array(out, "type=\"Int64\" Name=\"offsets\"", sizeof(std::int64_t) * count, [&](Bytes& data) {
        for (std::size_t t = 1; t <= count; ++t) data.add(static_cast<std::int64_t>(3 * t));
    });
    write_array(out, "type=\"UInt8\" Name=\"types\"", count, [&](Bytes& data) {
        constexpr std::uint8_t triangle = 5;
        for (std::size_t t = 0; t < count; ++t) data.add(triangle);
    });
    out << "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

void write_mesh(std::ostream& out, std::string_view format, const LabelledMesh& mesh) {
    if (format == "stl") write_stl(out, mesh);
    if (format == "ply") write_ply(out, mesh);
    if (format == "vtu") write_vtu(out, mesh);
}

}  // namespace vcell
