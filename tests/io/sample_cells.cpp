#include "sample_cells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/files/scene_file.hpp"
#include "hand_built_cells.hpp"

namespace vcell {

namespace {

Eigen::Vector4d weighted(const Vec3& p) { return {p.x(), p.y(), p.z(), 1}; }
Eigen::Vector3d weighted(const Vec2& p) { return {p.x(), p.y(), 1}; }

constexpr double e = 15.0 / 16, w = 2.5;  // z = (x^2 + y^2 + e) / w
double height_at(double x, double y) { return (x * x + y * y + e) / w; }

TrimmedPatch paraboloid() {
    TrimmedPatch p;
    p.surface.degree_u = p.surface.degree_v = 2;
    p.surface.domain_u = p.surface.domain_v = {-1, 1};
    constexpr double x[] = {-1, 0, 1}, square[] = {1, -1, 1};  // Bezier coefficients on [-1, 1]
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            p.surface.points.push_back({x[i], x[j], (square[i] + square[j] + e) / w, 1});
    return p;
}

TrimmedPatch ceiling(double height) {
    TrimmedPatch p;
    p.surface.domain_u = p.surface.domain_v = {-1, 1};
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0}) p.surface.points.push_back({x, y, height, 1});
    return p;
}

// The rim: corners counter-clockwise from (-1, -1), an edge from each to the next.
void add_rim(Cell& cell, TrimmedPatch& patch, Site site, bool curved, double height) {
    const Vec2 corners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const std::uint32_t sides[] = {2, 1, 3, 0};  // -y +x +y -x
    const auto lift = [&](const Vec2& p) {
        return Vec3(p.x(), p.y(), curved ? height_at(p.x(), p.y()) : height);
    };
    std::vector<TrimCurve> loop;
    for (std::uint32_t i = 0; i < 4; ++i) {
        const Vec2 from = corners[i], to = corners[(i + 1) % 4];
        CellVertex v{lift(from),
                     lift(from).z(),
                     {site, Site::box_side(sides[(i + 3) % 4]), Site::box_side(sides[i])},
                     0};
        std::sort(v.sites.begin(), v.sites.end());
        cell.vertices.push_back(v);

        CellEdge edge;
        edge.sites = {site, Site::box_side(sides[i])};
        edge.vertices = {i, (i + 1) % 4};
        edge.kind = curved ? CurveKind::Parabola : CurveKind::Line;
        edge.length = curved ? 2.0973 : 2;
        edge.length_error = curved ? 1e-4 : 0;
        const Vec3 a = lift(from), b = lift(to);
        edge.curve = {1, {0, 0, 1, 1}, {weighted(a), weighted(b)}};
        if (curved) {
            // The middle control point: along the side the square goes 1, -1, 1.
            const Vec3 m(0.5 * (from.x() + to.x()), 0.5 * (from.y() + to.y()), e / w);
            edge.curve = {2, {0, 0, 0, 1, 1, 1}, {weighted(a), weighted(m), weighted(b)}};
        }
        cell.edges.push_back(edge);
        loop.push_back({i, std::nullopt, false, {1, {0, 0, 1, 1}, {weighted(from), weighted(to)}}});
    }
    patch.loops.push_back(loop);
}

}  // namespace

Cell one_sphere_cell(double height) {
    const bool island = height < height_at(1, 1);
    Cell cell;
    cell.scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    cell.scene.objects = {Sphere{{0, 0, 1}, 0.25}};
    cell.scene.names = {"O1 <&>"};
    cell.scene.box = {{-1, -1, 0}, {1, 1, height}};
    cell.neighbors = {0};

    CellFace face;
    face.site = Site::object(0);
    face.bisector = "paraboloid";
    face.patches = {paraboloid()};
    if (!island) {
        add_rim(cell, face.patches[0], face.site, true, height);
        cell.faces = {face};
    } else {
        CellFace box;
        box.site = Site::box_side(5);
        box.bisector = "box";
        box.area = 3;
        box.area_error = 1;
        box.patches = {ceiling(height)};
        add_rim(cell, box.patches[0], box.site, false, height);
        const double r = std::sqrt(w * height - e);
        CellEdge rim;
        rim.sites = {face.site, box.site};
        rim.kind = CurveKind::Circle;
        rim.length = 2 * std::numbers::pi * r;
        rim.length_error = 1e-15;
        const RationalCurve2 c = hand_built::circle(r);
        rim.curve.degree = 2;
        rim.curve.knots = c.knots;
        for (const auto& p : c.points) rim.curve.points.push_back({p.x(), p.y(), height, p.z()});
        cell.edges.push_back(rim);
        box.patches[0].loops.push_back({{4u, std::nullopt, true, hand_built::reversed(c)}});
        face.patches[0].loops.push_back({{4u, std::nullopt, false, c}});
        cell.faces = {face, box};
    }
    cell.faces[0].area = 1.0 / 3;
    cell.faces[0].area_error = 10;
    cell.measures = {1.0 / 7, 1e-300, 0, 0, 2, 0, 1, 0, 4, 0, 0.25, 0, 0.5, 0, island};
    cell.report.decisions.by_exact = UINT64_MAX;
    cell.report.warnings = {"a \"quoted\"\nwarning \\ \x01"};
    return cell;
}

std::string cell_text(const Cell& cell) {
    std::ostringstream out;
    write_cell(out, cell);
    return out.str();
}

Cell ellipsoid_cell() {
    Scene scene;
    scene.base = Sphere{{6, 3, 6}, 1};
    scene.objects = {HollowSphere{{2, 5, 4}, 5}};
    scene.box = {Vec3::Zero(), Vec3::Constant(8)};
    return voronoi_cell(scene);
}

std::string scene_complaint(const std::string& text) {
    try {
        parse_scene(text);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

std::string cell_complaint(const std::string& text) {
    try {
        parse_cell(text);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

}  // namespace vcell
