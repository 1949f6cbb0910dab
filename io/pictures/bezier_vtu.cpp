#include "bezier_vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ostream>
#include <string_view>
#include <vector>

#include "../../core/curves/restricted_curve.hpp"
#include "../../envelope/whole/void_network.hpp"
#include "../files/files.hpp"
#include "mesh_formats.hpp"
#include "site_style.hpp"
#include "vtk_arrays.hpp"

namespace vcell {

namespace {

constexpr int largest_degree = 10;  // vtkHigherOrderInterpolation::MaxDegree
constexpr std::uint8_t bezier_curve = 75, bezier_quadrilateral = 77;

void require_degree(int degree, std::string_view kind, std::size_t number) {
    if (degree > largest_degree)
        throw WriteError(fmt::format("VTK's Bezier elements have degrees of {} at most, and {} {} has {}",
                                     largest_degree, kind, number, degree));
}

}  // namespace

void BezierElements::add(std::int32_t number, const Cell& cell) {
    for (std::size_t f = 0; f < cell.faces.size(); ++f)
        for (const TrimmedPatch& patch : cell.faces[f].patches)
            require_degree(std::max(patch.surface.degree_u, patch.surface.degree_v), "face", f);
    for (std::size_t e = 0; e < cell.edges.size(); ++e) require_degree(cell.edges[e].curve.degree, "edge", e);
    const auto label = [&](Site site) { return LabelledMesh::label(site_in_diagram(cell, site).site); };
    for (std::size_t f = 0; f < cell.faces.size(); ++f)
        for (const TrimmedPatch& patch : cell.faces[f].patches) {
            add_points(patch.surface);
            end(bezier_quadrilateral, {patch.surface.degree_u, patch.surface.degree_v},
                {number, static_cast<std::int32_t>(f), -1, label(cell.faces[f].site)});
        }
    for (std::size_t e = 0; e < cell.edges.size(); ++e) {
        const RationalCurve3& curve = cell.edges[e].curve;
        std::vector<double> ends(curve.knots.begin(), curve.knots.end());
        ends.erase(std::ranges::unique(ends).begin(), ends.end());
        for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
            add_points(restricted(curve, ends[i], ends[i + 1]));
            end(bezier_curve, {curve.degree, 0},
                {number, -1, static_cast<std::int32_t>(e), label(cell.edges[e].sites[0])});
        }
    }
}

void BezierElements::write(std::ostream& out) const {
    out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
           "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\""
        << weights_.size() << "\" NumberOfCells=\"" << types_.size()
        << "\">\n<PointData RationalWeights=\"RationalWeights\">\n";
    write_array(out, "type=\"Float64\" Name=\"RationalWeights\"", weights_);
    out << "</PointData>\n<CellData Scalars=\"neighbor\" HigherOrderDegrees=\"HigherOrderDegrees\">\n";
    const auto write_numbers = [&](std::string_view name, std::int32_t Element::*number) {
        std::vector<std::int32_t> numbers;
        for (const Element& e : elements_) numbers.push_back(e.*number);
        write_array(out, fmt::format("type=\"Int32\" Name=\"{}\"", name), numbers);
    };
    write_numbers("neighbor", &Element::neighbor);
    write_numbers("cell", &Element::cell);
    write_numbers("face", &Element::face);
    write_numbers("edge", &Element::edge);
    write_array(out, "type=\"Float64\" Name=\"HigherOrderDegrees\" NumberOfComponents=\"3\"", degrees_);
    out << "</CellData>\n<Points>\n";
    write_array(out, "type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", coordinates_);
    out << "</Points>\n<Cells>\n";
    // No element has a point of another one.
    std::vector<std::int64_t> points(weights_.size());
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = static_cast<std::int64_t>(i);
    write_array(out, "type=\"Int64\" Name=\"connectivity\"", points);
    write_array(out, "type=\"Int64\" Name=\"offsets\"", offsets_);
    write_array(out, "type=\"UInt8\" Name=\"types\"", types_);
    out << "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

void BezierElements::add_point(const Eigen::Vector4d& p) {
    for (int k = 0; k < 3; ++k) coordinates_.push_back(p[k]);
    weights_.push_back(p[3]);
}

// Corners, sides, what is inside: sides go up in their parameter, the one with v = 0 first, then that with
// the largest u, and so around.
void BezierElements::add_points(const RationalPatch& s) {
    const int m = s.degree_u, n = s.degree_v;
    for (const auto& [i, j] : {std::array{0, 0}, {m, 0}, {m, n}, {0, n}}) add_point(s.point(i, j));
    for (int i = 1; i < m; ++i) add_point(s.point(i, 0));
    for (int j = 1; j < n; ++j) add_point(s.point(m, j));
    for (int i = 1; i < m; ++i) add_point(s.point(i, n));
    for (int j = 1; j < n; ++j) add_point(s.point(0, j));
    for (int j = 1; j < n; ++j)
        for (int i = 1; i < m; ++i) add_point(s.point(i, j));
}

void BezierElements::add_points(const RationalCurve3& span) {
    add_point(span.points.front());
    add_point(span.points.back());
    for (std::size_t k = 1; k + 1 < span.points.size(); ++k) add_point(span.points[k]);
}

void BezierElements::end(std::uint8_t type, std::array<int, 2> degrees, const Element& element) {
    types_.push_back(type);
    offsets_.push_back(static_cast<std::int64_t>(weights_.size()));
    for (const int degree : {degrees[0], degrees[1], 0}) degrees_.push_back(degree);
    elements_.push_back(element);
}

void write_bezier_vtu(std::ostream& out, const Cell& cell) {
    BezierElements elements;
    elements.add(base_number(cell.scene), cell);
    elements.write(out);
}

}  // namespace vcell
