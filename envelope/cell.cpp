#include "cell.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "../core/quadrature/bounded_sum.hpp"
#include "../core/threads.hpp"
#include "../primitives/bases/plane_base.hpp"
#include "../primitives/objects/decided_scene.hpp"

namespace vcell {

namespace {

// Below the normal numbers products are rounded: a bound's, and that of what it bounds.
void scale_bound(double& error, double factor) {
    if (error == 0) return;
    error *= factor;
    if (error < std::numeric_limits<double>::min()) error += 2 * std::numeric_limits<double>::denorm_min();
}

}  // namespace

std::string to_string(CurveKind kind) {
    switch (kind) {
        case CurveKind::Line: return "line";
        case CurveKind::Circle: return "circle";
        case CurveKind::Ellipse: return "ellipse";
        case CurveKind::Parabola: return "parabola";
        case CurveKind::Hyperbola: return "hyperbola";
        case CurveKind::Spline: break;
    }
    return "spline";
}

bool is_entered(const Cell& cell, const CellFace& face) {
    return cell.is_complete && face.site.kind == Site::Kind::BoxSide &&
           lets_rays_in(cell.scene, face.site.index);
}

// Lists of sites are ascending.
static void rename(Cell& cell, Site from, Site to) {
    for_each_site(cell, [&](Site& site) {
        if (site == from) site = to;
    });
    for (CellVertex& v : cell.vertices) std::ranges::sort(v.sites);
    for (CellEdge& e : cell.edges) std::ranges::sort(e.extra_sites);
    for (CellFace& f : cell.faces) std::ranges::sort(f.extra_sites);
    if (!cell.clearance_places) return;
    for (auto* place : {&cell.clearance_places->least, &cell.clearance_places->greatest})
        if (*place) std::ranges::sort((*place)->sites);
}

void name_cap(Cell& cell, Site cap, double probe) {
    rename(cell, cap, Site::cap());
    std::erase(cell.neighbors, cap.index);
    Measures& m = cell.measures;
    if (m.area == not_measured) return;
    // Edges of the cap are fitted.
    m.max_clearance = std::min(m.max_clearance, probe);
    BoundedSum area;
    for (const CellFace& face : cell.faces)
        if (face.site.is_object()) area.add(face.area, face.area_error);
    m.area = area.value();
    m.area_error = area.bound();
}

Cell with_cap_as_object(Cell cell) {
    cell.scene = with_cap(std::move(cell.scene));
    cell.scene.probe.reset();
    const Site cap = Site::object(cell.scene.number(cell.scene.objects.size() - 1));
    rename(cell, Site::cap(), cap);
    // Neighbours come by their faces' areas. The others stay in the order in which they are, which may be
    // wrong.
    const auto is_owned = [](const CellFace& f, Site site) {
        return f.site == site || std::ranges::count(f.extra_sites, site) > 0;
    };
    const auto area_of = [&](std::uint32_t object) {
        double area = 0;
        for (const CellFace& f : cell.faces)
            if (is_owned(f, Site::object(object))) area += f.area;
        return area;
    };
    double area = 0;
    bool has_face = false;
    for (const CellFace& f : cell.faces) {
        if (!is_owned(f, cap)) continue;
        has_face = true;
        if (cell.measures.area == not_measured) continue;
        area += f.area;
        if (f.site != cap) continue;
        cell.measures.area += f.area;
        cell.measures.area_error +=
            f.area_error + std::numeric_limits<double>::epsilon() * cell.measures.area;
    }
    if (has_face)
        cell.neighbors.insert(
            std::ranges::find_if(cell.neighbors, [&](std::uint32_t n) { return area_of(n) < area; }),
            cap.index);
    return cell;
}

void number_by_places(Cell& cell) {
    if (!cell.scene.numbers.empty()) {
        const auto to_place = [&](std::uint32_t& number) {
            number = static_cast<std::uint32_t>(cell.scene.place(number));
        };
        for_each_site(cell, [&](Site& site) {
            if (site.is_object()) to_place(site.index);
        });
        std::ranges::for_each(cell.neighbors, to_place);
    }
    cell.scene.numbers.clear();
    cell.scene.images.clear();
}

void scale(Cell& cell, double factor, double of_parameters, unsigned threads) {
    if (factor == 1) return;
    const double square = factor * factor, cube = square * factor;
    for_each(cell.vertices, threads, [&](CellVertex& v) {
        v.point *= factor;
        v.radius *= factor;
        v.error *= factor;
    });
    for_each(cell.edges, threads, [&](CellEdge& e) {
        for (double* length : {&e.error, &e.length, &e.length_error}) *length *= factor;
        for (Eigen::Vector4d& p : e.curve.points) p.head<3>() *= factor;
    });
    for_each(cell.faces, threads, [&](CellFace& f) {
        f.area *= square;
        scale_bound(f.area_error, square);
        for (TrimmedPatch& patch : f.patches) {
            for (Eigen::Vector4d& p : patch.surface.points) p.head<3>() *= factor;
            if (of_parameters == 1) continue;
            for (std::array<double, 2>* domain : {&patch.surface.domain_u, &patch.surface.domain_v})
                for (double& bound : *domain) bound *= of_parameters;
            for (std::vector<TrimCurve>& loop : patch.loops)
                for (TrimCurve& trim : loop)
                    for (Eigen::Vector3d& p : trim.curve.points) p.head<2>() *= of_parameters;
        }
    });
    for (CellPart& part : cell.parts)
        for (Vec3& end : part.ends) end *= factor;
    Measures& m = cell.measures;
    for (double* volume : {&m.volume, &m.body_volume}) *volume *= cube;
    for (double* error : {&m.volume_error, &m.body_volume_error}) scale_bound(*error, cube);
    for (double* area : {&m.area, &m.box_area, &m.base_area}) *area *= square;
    for (double* error : {&m.area_error, &m.box_area_error, &m.base_area_error}) scale_bound(*error, square);
    for (double* length :
         {&m.min_clearance, &m.min_clearance_error, &m.max_clearance, &m.max_clearance_error})
        *length *= factor;
    cell.report.moved *= factor;
}

}  // namespace vcell
