/// Meshes of which other cells have drawn parts already.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mesh.hpp"

namespace vcell {

/// The parts of a cell's mesh that are known before it is made: points of vertices, polylines of edges, and
/// triangles of whole faces. The mesh begins with these points, and its own go on from there.
struct KnownMesh {
    struct Face {
        std::vector<Triangle> triangles;  ///< into KnownMesh::points
        std::vector<Vec3> normals;
        std::vector<Triangle> corner_normals;  ///< into normals
    };

    /// Those of vertices, lines and faces.
    std::vector<Vec3> points;
    /// Where the cell's vertices are drawn, one for each, into `points`.
    std::vector<std::uint32_t> vertices;
    /// For each edge of the cell its polyline from its start to its end, into `points`; empty: not known. It
    /// begins and ends with the edge's vertices; that of a closed edge without any, with one point, near
    /// where its curve begins.
    std::vector<std::vector<std::uint32_t>> lines;
    std::vector<std::optional<Face>> faces;  ///< for each face of the cell
    /// Null: not known.
    const Face* face(std::size_t f) const { return f < faces.size() && faces[f] ? &*faces[f] : nullptr; }
    /// For each edge of the cell, or none at all: parameters at which its polyline is to have a point.
    std::vector<std::vector<double>> breaks;
    /// For each face of the cell, or none at all: what may be no side inside of the face, ascending, as the
    /// cell beyond has it inside of another one.
    std::vector<std::vector<MeshSide>> taken;
    std::span<const MeshSide> taken_of(std::size_t f) const {
        return f < taken.size() ? std::span<const MeshSide>(taken[f]) : std::span<const MeshSide>();
    }
};

/// The mesh has grown beyond its bound, or a line beyond all halving.
struct TooFine {};

/// As tessellate(), with what is known as it is: points of polylines are taken for points of the edges, known
/// or not, and only lines that are not known are refined until no two sides of a face cross. Pre: all edges
/// of known faces have known lines, whose sides the faces' triangles have.
CellMesh tessellate(const Cell& cell, const MeshOptions& options, const KnownMesh& known);

/// That mesh has the chord that is asked for, and no other: TooFine is thrown where it takes more than
/// `most_triangles`, or more than 4096 pieces of an edge. Pre: there is such a bound.
CellMesh tessellate_with_chord(const Cell& cell, const MeshOptions& options, const KnownMesh& known);

/// Parameters of points that follow each other along a curve, the first one at its begin and the last one at
/// its end: of the nearest points of the curve, ascending.
std::vector<double> parameters_along(const RationalCurve3& curve, const std::vector<Vec3>& points);

/// The parameter of the curve's point that is nearest to p.
double nearest_parameter(const RationalCurve3& curve, const Vec3& p);

/// The distance of p from the curve, or if that is more than `enough`, no less: where p is near the curve's
/// middle parameter that is quickly seen.
double distance_from_curve(const RationalCurve3& curve, const Vec3& p, double enough);

}  // namespace vcell
