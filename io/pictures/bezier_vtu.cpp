#include "bezier_vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ostream>
#include <vector>

#include "../../core/curves/restricted_curve.hpp"
#include "../files/files.hpp"
#include "mesh_formats.hpp"
#include "vtk_arrays.hpp"

namespace vcell {

namespace {

constexpr int largest_degree = 10;  // vtkHigherOrderInterpolation::MaxDegree
constexpr std::uint8_t bezier_curve = 75, bezier_quadrilateral = 77;

class BezierElements {
public:
    explicit BezierElements(const Cell& cell) {
        for (std::size_t f = 0; f < cell.faces.size(); ++f)
            for (const TrimmedPatch& patch : cell.faces[f].patches) {
                add(patch.surface);
                end(bezier_quadrilateral, {patch.surface.degree_u, patch.surface.degree_v},
                    {static_cast<std::int32_t>(f), -1}, cell.faces[f].site);
            }
        for (std::size_t e = 0; e < cell.edges.size(); ++e) {
            const RationalCurve3& curve = cell.edges[e].curve;
            std::vector<double> ends(curve.knots.begin(), curve.knots.end());
            ends.erase(std::ranges::unique(ends).begin(), ends.end());
            for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
                add(restricted(curve, ends[i], ends[i + 1]));
                end(bezier_curve, {curve.degree, 0}, {-1, static_cast<std::int32_t>(e)},
                    cell.edges[e].sites[0]);
            }
        }
    }

    void write(std::ostream& out) const {
        out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
               "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\""
            << weights_.size() << "\" NumberOfCells=\"" << types_.size()
            << "\">\n<PointData RationalWeights=\"RationalWeights\">\n";
        write_array(out, "type=\"Float64\" Name=\"RationalWeights\"", weights_);
        out << "</PointData>\n<CellData Scalars=\"neighbor\" HigherOrderDegrees=\"HigherOrderDegrees\">\n";
        write_array(out, "type=\"Int32\" Name=\"neighbor\"", neighbors_);
        write_array(out, "type=\"Int32\" Name=\"face\"", faces_);
        write_array(out, "type=\"Int32\" Name=\"edge\"", edges_);
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

private:
    void add(const Eigen::Vector4d& p) {
        for (int k = 0; k < 3; ++k) coordinates_.push_back(p[k]);
        weights_.push_back(p[3]);
    }
    // Corners, sides, what is inside: sides go up in their parameter, the one with v = 0 first, then that
    // with the largest u, and so around.
    void add(const RationalPatch& s) {
        const int m = s.degree_u, n = s.degree_v;
        for (const auto& [i, j] : {std::array{0, 0}, {m, 0}, {m, n}, {0, n}}) add(s.point(i, j));
        for (int i = 1; i < m; ++i) add(s.point(i, 0));
        for (int j = 1; j < n; ++j) add(s.point(m, j));
        for (int i = 1; i < m; ++i) add(s.point(i, n));
        for (int j = 1; j < n; ++j) add(s.point(0, j));
        for (int j = 1; j < n; ++j)
            for (int i = 1; i < m; ++i) add(s.point(i, j));
    }
    void add(const RationalCurve3& span) {
        add(span.points.front());
        add(span.points.back());
        for (std::size_t k = 1; k + 1 < span.points.size(); ++k) add(span.points[k]);
    }
    void end(std::uint8_t type, std::array<int, 2> degrees, std::array<std::int32_t, 2> of, Site site) {
        if (std::ranges::max(degrees) > largest_degree)
            throw WriteError(fmt::format("VTK's Bezier elements have degrees of {} at most, and {} {} has {}",
                                         largest_degree, of[0] < 0 ? "edge" : "face", std::ranges::max(of),
                                         std::ranges::max(degrees)));
        types_.push_back(type);
        offsets_.push_back(static_cast<std::int64_t>(weights_.size()));
        for (const int degree : {degrees[0], degrees[1], 0}) degrees_.push_back(degree);
        faces_.push_back(of[0]);
        edges_.push_back(of[1]);
        neighbors_.push_back(LabelledMesh::label(site));
    }

    std::vector<double> coordinates_, weights_, degrees_;
    std::vector<std::int32_t> neighbors_, faces_, edges_;
    std::vector<std::int64_t> offsets_;
    std::vector<std::uint8_t> types_;
};

}  // namespace

void write_bezier_vtu(std::ostream& out, const Cell& cell) { BezierElements(cell).write(out); }

}  // namespace vcell
