/// What is asked of complete cells over every base.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
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

/// Numbers of the faces that hang together, as many as there are of them.
inline std::vector<std::uint32_t> components(const Cell& cell) {
    std::vector<std::uint32_t> part(cell.faces.size());
    for (std::uint32_t f = 0; f < part.size(); ++f) part[f] = f;
    const auto root = [&](std::uint32_t f) {
        while (part[f] != f) f = part[f];
        return f;
    };
    std::vector<std::optional<std::uint32_t>> beside(cell.edges.size());
    for (std::uint32_t f = 0; f < part.size(); ++f)
        for (const TrimmedPatch& patch : cell.faces[f].patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop) {
                    if (!trim.edge) continue;
                    std::optional<std::uint32_t>& first = beside[*trim.edge];
                    if (first) part[root(f)] = root(*first);
                    first = f;
                }
    for (std::uint32_t f = 0; f < part.size(); ++f) part[f] = root(f);
    return part;
}

/// The cell with faces as often as that says, in their order, and what they need of edges and vertices; those
/// of one copy hang together as before. Neighbours and measures stay as they are.
inline Cell with_faces(const Cell& cell, const std::vector<int>& times) {
    Cell result = cell;
    result.faces.clear();
    result.edges.clear();
    result.vertices.clear();
    const int most = times.empty() ? 0 : *std::ranges::max_element(times);
    using Numbers = std::vector<std::vector<std::uint32_t>>;
    Numbers edges(static_cast<std::size_t>(most), std::vector(cell.edges.size(), UINT32_MAX)),
        vertices(static_cast<std::size_t>(most), std::vector(cell.vertices.size(), UINT32_MAX));
    const auto copy = [&](std::size_t f, std::size_t k) {
        CellFace& face = result.faces.emplace_back(cell.faces[f]);
        for (TrimmedPatch& patch : face.patches)
            for (auto& loop : patch.loops)
                for (TrimCurve& trim : loop) {
                    if (!trim.edge) continue;
                    std::uint32_t& number = edges[k][*trim.edge];
                    if (number == UINT32_MAX) {
                        number = static_cast<std::uint32_t>(result.edges.size());
                        CellEdge& edge = result.edges.emplace_back(cell.edges[*trim.edge]);
                        for (std::uint32_t& v : edge.vertices) {
                            std::uint32_t& vertex = vertices[k][v];
                            if (vertex == UINT32_MAX) {
                                vertex = static_cast<std::uint32_t>(result.vertices.size());
                                result.vertices.push_back(cell.vertices[v]);
                            }
                            v = vertex;
                        }
                    }
                    trim.edge = number;
                }
    };
    std::size_t f = 0;
    const auto copy_up_to = [&](std::size_t end) {
        const std::size_t before = result.faces.size();
        for (; f < end; ++f)
            for (int k = 0; k < times[f]; ++k) copy(f, static_cast<std::size_t>(k));
        return static_cast<std::uint32_t>(result.faces.size() - before);
    };
    for (CellPart& part : result.parts) part.faces = copy_up_to(f + part.faces);
    copy_up_to(cell.faces.size());
    return result;
}

inline bool is_proved(const Certificate& certificate, const std::string& where) {
    return std::ranges::any_of(certificate.elements, [&](const Element& e) {
        return e.where == where && e.verdict == Verdict::proved;
    });
}
inline bool is_refuted(const Certificate& certificate, const std::string& where) {
    return std::ranges::any_of(certificate.elements, [&](const Element& e) {
        return e.where.starts_with(where) && e.verdict == Verdict::refuted;
    });
}

}  // namespace vcell
