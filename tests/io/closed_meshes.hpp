/// Closed triangle meshes: what they hold, and whether they are closed; and solids, that go with them.
#pragma once

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "../../io/pictures/mesh.hpp"
#include "../../io/solids/shell.hpp"
#include "../../io/solids/solid.hpp"

namespace vcell {

/// How often the mesh winds around p.
inline double winding(const CellMesh& mesh, const Vec3& p) {
    double sum = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3 a = mesh.points[t[0]] - p, b = mesh.points[t[1]] - p, c = mesh.points[t[2]] - p;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        sum +=
            2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return sum / (4 * M_PI);
}

inline double volume(const CellMesh& mesh) {
    double six = 0;
    for (const Triangle& t : mesh.triangles)
        six += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]]));
    return six / 6;
}

inline bool is_closed(const CellMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            ++sides[{t[k], t[(k + 1) % 3]}];
            --sides[{t[(k + 1) % 3], t[k]}];
        }
    return std::ranges::all_of(sides, [](const auto& side) { return side.second == 0; });
}

/// The cell's mesh is closed and has its volume but for a part that chords leave out, and it is one solid.
inline void check_mesh_and_solid(const Cell& cell, double part) {
    MeshOptions options;
    options.closed = true;
    const CellMesh mesh = tessellate(cell, options);
    CHECK(is_closed(mesh));
    CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(part));
    const Solid solid = solid_of(closed_shell(cell), cell.faces.size());
    CHECK(solid.parts.size() == 1);
    CHECK(solid.off < 1e-5);
}

}  // namespace vcell
