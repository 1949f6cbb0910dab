/// What is asked of complete cells over every base.
#pragma once

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <variant>

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

/// From the surface of a ball or a tube, less than 0 inside; from a base plane less than 0 behind it, from
/// any other plane on both sides alike.
inline double distance_from(const Object& object, const Vec3& p, bool is_base) {
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const double above = plane->normal.normalized().dot(p - plane->point);
        return is_base ? above : std::abs(above);
    }
    if (const auto* sphere = std::get_if<Sphere>(&object))
        return (p - sphere->center).norm() - sphere->radius;
    const auto& tube = std::get<Cylinder>(object);
    return tube.axis.normalized().cross(p - tube.point).norm() - tube.radius;
}

/// By how much the base is nearer to p than anything else; less than 0 behind a base plane.
inline double lead(const Scene& scene, const Vec3& p) {
    const double own = distance_from(scene.base, p, true);
    double least = std::holds_alternative<Plane>(scene.base) ? own : HUGE_VAL;
    for (const Object& o : scene.objects) least = std::min(least, distance_from(o, p, false) - own);
    return least;
}

/// The mesh winds once around what is nearest to the base, and not around the rest of the box.
inline void check_points(const Cell& cell, const CellMesh& mesh, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> unit(0, 1);
    const Box& box = cell.scene.box;
    for (int i = 0; i < 60; ++i) {
        const double x = unit(rng), y = unit(rng), z = unit(rng);
        const Vec3 p = box.min + (box.max - box.min).cwiseProduct(Vec3(x, y, z));
        const double ahead = lead(cell.scene, p);
        if (std::abs(ahead) < 0.05) continue;  // nearer than chords may be
        if (!std::holds_alternative<Plane>(cell.scene.base) &&
            distance_from(cell.scene.base, p, true) < chord)
            continue;
        CAPTURE(p.transpose());
        CHECK(winding(mesh, p) == doctest::Approx(ahead > 0 ? 1 : 0).epsilon(1e-6));
    }
}

}  // namespace vcell
