/// What is asked of complete cells over every base.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>

#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "closed_meshes.hpp"

namespace vcell {

inline Cell complete_cell(const Scene& scene) {
    CellOptions options;
    options.complete = true;
    return voronoi_cell(scene, options);
}

/// Are its measures those of complete_measures(), which gets there by other cells? `left_out`: a bound on the
/// area that the cell's parts leave out between them.
inline void check_complete_measures(const Cell& cell, const CompleteMeasures& m, double left_out = 0) {
    CHECK(std::abs(cell.measures.volume - m.volume) <= cell.measures.volume_error + m.volume_error);
    CHECK(std::abs(cell.measures.area - m.area) <= cell.measures.area_error + m.area_error);
    std::map<std::uint32_t, std::array<double, 2>> areas;
    for (const CellFace& f : cell.faces)
        if (f.site.is_object()) {
            areas[f.site.index][0] += f.area;
            areas[f.site.index][1] += f.area_error;
        }
    for (const auto& n : m.neighbors) {
        REQUIRE(areas.contains(n.object));
        CHECK(std::abs(areas[n.object][0] - n.area) <= areas[n.object][1] + n.area_error + left_out);
    }
    if (left_out == 0) CHECK(areas.size() == cell.neighbors.size());
}

constexpr double chord = 0.01;

/// Its mesh with such chords, closed and of its volume.
inline CellMesh checked_mesh(const Cell& cell) {
    MeshOptions options;
    options.closed = true;
    options.chord = chord;
    CellMesh mesh = tessellate(cell, options);
    CHECK(is_closed(mesh));
    CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(0.01));
    return mesh;
}

}  // namespace vcell
