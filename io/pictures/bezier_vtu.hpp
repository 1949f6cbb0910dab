/// Exact surfaces and curves of cells for VTK, as its rational Bezier elements.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "../../envelope/cell.hpp"

namespace vcell {

/// Each patch is a VTK_BEZIER_QUADRILATERAL over the rectangle of its parameters, which holds its loops and
/// is not trimmed by them, and each Bezier span of an edge a VTK_BEZIER_CURVE. Control points and weights are
/// the cells'. Cell data: `cell`, the number of the cell; in it `face` and `edge`, the number of what the
/// element is of (-1 of the other one); and `neighbor`, the site beyond a face, or the first one of an edge,
/// as LabelledMesh has it.
class BezierElements {
public:
    /// Elements of a cell: one after the other of a diagram (DiagramOptions::visit), or one alone. Throws
    /// WriteError for a patch or a curve of a degree above 10, which VTK has no room for and none that is
    /// computed has; then nothing of the cell is added.
    void add(std::int32_t number, const Cell& cell);

    /// VTK XML unstructured grid, arrays in base64.
    void write(std::ostream& out) const;

private:
    struct Element {
        std::int32_t cell, face, edge, neighbor;
    };
    void add_point(const Eigen::Vector4d& p);
    void add_points(const RationalPatch& surface);
    void add_points(const RationalCurve3& span);
    void end(std::uint8_t type, std::array<int, 2> degrees, const Element& element);

    std::vector<double> coordinates_, weights_, degrees_;
    std::vector<Element> elements_;
    std::vector<std::int64_t> offsets_;
    std::vector<std::uint8_t> types_;
};

/// The elements of a cell by itself: its number is the base's among the objects, or -1.
void write_bezier_vtu(std::ostream& out, const Cell& cell);

}  // namespace vcell
