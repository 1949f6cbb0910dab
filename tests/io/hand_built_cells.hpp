/// Cells over the plane z = 0 and their parts, built by hand: check_cell() meets what no lift has made.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "../../envelope/voronoi_cell.hpp"

namespace vcell::hand_built {

/// The height (k |p - c|^2 + e) / w, and its lift.
struct Height {
    double k, cx, e, w;

    double operator()(double x, double y) const { return (k * ((x - cx) * (x - cx) + y * y) + e) / w; }
    Vec3 over(const Vec2& p) const { return {p.x(), p.y(), (*this)(p.x(), p.y())}; }

    RationalPatch patch(double x0, double x1, double y0, double y1) const {
        RationalPatch s;
        s.degree_u = s.degree_v = 2;
        s.domain_u = {x0, x1};
        s.domain_v = {y0, y1};
        const std::array us{x0, 0.5 * (x0 + x1), x1}, vs{y0, 0.5 * (y0 + y1), y1};
        const std::array u2{(x0 - cx) * (x0 - cx), (x0 - cx) * (x1 - cx), (x1 - cx) * (x1 - cx)};
        const std::array v2{y0 * y0, y0 * y1, y1 * y1};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) s.points.push_back({us[i], vs[j], (k * (u2[i] + v2[j]) + e) / w, 1});
        return s;
    }
};

inline RationalCurve2 segment(const Vec2& p, const Vec2& q) {
    RationalCurve2 c;
    c.degree = 2;
    c.knots = {0, 0, 0, 1, 1, 1};
    const Vec2 m = 0.5 * (p + q);
    c.points = {{p.x(), p.y(), 1}, {m.x(), m.y(), 1}, {q.x(), q.y(), 1}};
    return c;
}

inline RationalCurve2 circle(double r) {
    RationalCurve2 c;
    c.degree = 2;
    c.knots = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    const double w = std::numbers::sqrt2 / 2;
    c.points = {{r, 0, 1},   {r, r, w},  {0, r, 1},  {-r, r, w}, {-r, 0, 1},
                {-r, -r, w}, {0, -r, 1}, {r, -r, w}, {r, 0, 1}};
    return c;
}

inline RationalCurve2 reversed(RationalCurve2 c) {
    std::ranges::reverse(c.points);  // the knots above are symmetric
    return c;
}

/// A chart curve lifted to a height: on a segment the middle control point is the blossom, on a circle
/// about the height's axis the height is constant.
inline RationalCurve3 lifted(const RationalCurve2& c, const Height& h) {
    RationalCurve3 s;
    s.degree = c.degree;
    s.knots = c.knots;
    const Vec2 p = c.points.front().head<2>(), q = c.points.back().head<2>();
    for (std::size_t i = 0; i < c.points.size(); ++i) {
        const Vec2 x = c.points[i].head<2>();
        double z = h(p.x(), p.y());
        if (p != q && i == 1) z = 2 * h(x.x(), x.y()) - 0.5 * (z + h(q.x(), q.y()));
        if (p != q && i == 2) z = h(q.x(), q.y());
        s.points.push_back({x.x(), x.y(), z, c.points[i][2]});
    }
    return s;
}

inline double simpson(const std::function<double(double)>& f, double a, double b) {
    constexpr int n = 2000;
    double sum = f(a) + f(b);
    for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * f(a + (b - a) * i / n);
    return sum * (b - a) / (3 * n);
}

inline double length(const RationalCurve3& c) {
    double sum = 0;
    for (double t = 0; t < c.domain_end(); ++t)
        sum += simpson([&](double s) { return c.evaluate_with_derivative(s)[1].norm(); }, t, t + 1 - 1e-15);
    return sum;
}

inline void add_edge(Cell& cell, Site left, Site right, decltype(CellEdge::vertices) vertices, CurveKind kind,
                     const RationalCurve2& chart, const Height& h) {
    CellEdge e;
    e.sites = {left, right};
    e.vertices = std::move(vertices);
    e.kind = kind;
    e.curve = lifted(chart, h);
    e.length = length(e.curve);
    e.length_error = 1e-12;
    cell.edges.push_back(std::move(e));
}

inline void set_errors(Measures& m, double error) {
    m.volume_error = m.area_error = m.box_area_error = m.base_area_error = error;
    m.min_clearance_error = m.max_clearance_error = error;
    m.body_volume_error = 0;
}

constexpr std::array<std::array<double, 2>, 4> kCorners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};

inline Scene square_scene() {
    Scene s;
    s.base = Plane{};
    s.box = {{-1, -1, 0}, {1, 1, 2}};
    return s;
}

/// Two equal spheres: two faces that meet along a parabola over x = 0.
inline Cell two_spheres() {
    Cell cell;
    cell.scene = square_scene();
    cell.scene.objects = {Sphere{{-0.5, 0, 1}, 0.25}, Sphere{{0.5, 0, 1}, 0.25}};
    const Height left{1, -0.5, 15.0 / 16, 2.5}, right{1, 0.5, 15.0 / 16, 2.5};
    const Site a = Site::object(0), b = Site::object(1);
    const Site west = Site::box_side(0), east = Site::box_side(1), south = Site::box_side(2),
               north = Site::box_side(3);
    const std::vector<Vec2> p{{-1, -1}, {0, -1}, {1, -1}, {1, 1}, {0, 1}, {-1, 1}};
    const std::vector<decltype(CellVertex::sites)> sites{{a, west, south}, {a, b, south}, {b, east, south},
                                                         {b, east, north}, {a, b, north}, {a, west, north}};
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Vec3 x = (p[i].x() <= 0 ? left : right).over(p[i]);
        cell.vertices.push_back({x, x.z(), sites[i], 1e-15});
    }
    const std::vector<Site> sides{south, south, east, north, north, west};
    for (std::uint32_t i = 0; i < 6; ++i) {
        const bool is_left = i == 0 || i > 3;
        add_edge(cell, is_left ? a : b, sides[i], {i, (i + 1) % 6}, CurveKind::Parabola,
                 segment(p[i], p[(i + 1) % 6]), is_left ? left : right);
    }
    add_edge(cell, a, b, {1, 4}, CurveKind::Parabola, segment(p[1], p[4]), left);

    const auto trim = [&](std::uint32_t e, bool back) {
        const auto& ends = cell.edges[e].vertices;
        return TrimCurve{e, {}, back, segment(p[ends[back]], p[ends[!back]])};
    };
    // The area over x in [0, 1] is that over [-1/2, 1/2] from the axis: its inner integral is elementary.
    const double area = simpson(
        [&](double x) {
            return simpson([&](double y) { return std::sqrt(1 + (x * x + y * y) / (1.25 * 1.25)); }, -1, 1);
        },
        -0.5, 0.5);
    cell.faces.push_back(
        {a,
         {},
         "paraboloid",
         area,
         1e-14,
         {{left.patch(-1, 0, -1, 1), {{trim(0, false), trim(6, false), trim(4, false), trim(5, false)}}}}});
    cell.faces.push_back(
        {b,
         {},
         "paraboloid",
         area,
         1e-14,
         {{right.patch(0, 1, -1, 1), {{trim(1, false), trim(2, false), trim(3, false), trim(6, true)}}}}});
    cell.neighbors = {0, 1};
    // Half the square: 2 (1/12) / 2 + 2 / 3 + 15/8 over 2.5; walls by the mean of each parabola.
    cell.measures.volume = 2 * (1.0 / 6 + 2.0 / 3 + 15.0 / 8) / 2.5;
    cell.measures.area = 2 * area;
    set_errors(cell.measures, 1e-14);
    cell.measures.box_area = (4 * (1.0 / 12 + 1 + 15.0 / 16) + 2 * 2 * (0.25 + 1.0 / 3 + 15.0 / 16)) / 2.5;
    cell.measures.body_volume = 0;
    cell.measures.base_area = 4;
    cell.measures.min_clearance = 0.375;
    cell.measures.max_clearance = 0.875;
    cell.measures.touches_box = true;
    return cell;
}

/// two_spheres() with the left face cut along x = -1/2, which cuts edges 0 and 4 in their middles.
inline Cell two_patches() {
    Cell cell = two_spheres();
    const Height left{1, -0.5, 15.0 / 16, 2.5};
    const auto part = [](std::uint32_t e, double begin, double end, const Vec2& p, const Vec2& q) {
        TrimCurve trim{e, {}, false, segment(p, q)};
        for (double& k : trim.curve.knots) k = begin + k * (end - begin);
        return trim;
    };
    const auto seam = [](const Vec2& p, const Vec2& q) { return TrimCurve{{}, 3, false, segment(p, q)}; };
    const Vec2 south(-0.5, -1), north(-0.5, 1);
    const auto& loop = cell.faces[0].patches[0].loops[0];  // edges 0, 6, 4, 5
    const TrimmedPatch west{
        left.patch(-1, -0.5, -1, 1),
        {{part(0, 0, 0.5, {-1, -1}, south), seam(south, north), part(4, 0.5, 1, north, {-1, 1}), loop[3]}}};
    const TrimmedPatch east{
        left.patch(-0.5, 0, -1, 1),
        {{part(0, 0.5, 1, south, {0, -1}), loop[1], part(4, 0, 0.5, {0, 1}, north), seam(north, south)}}};
    cell.faces[0].patches = {west, east};
    return cell;
}

/// A sphere below a horizontal plane: an island with a closed edge and no vertex, in a face with a hole.
inline Cell island() {
    Cell cell;
    cell.scene = square_scene();
    cell.scene.objects = {Sphere{{0, 0, 1}, 0.25}, Plane{{0, 0, 0.95}, {0, 0, -1}}};
    const Height bowl{1, 0, 15.0 / 16, 2.5}, lid{0, 0, 0.475, 1};
    const Site sphere = Site::object(0), plane = Site::object(1);
    const std::array sides{Site::box_side(2), Site::box_side(1), Site::box_side(3), Site::box_side(0)};
    TrimmedPatch outer{lid.patch(-1, 1, -1, 1), {{}, {}}};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const Vec2 p(kCorners[i][0], kCorners[i][1]), q(kCorners[(i + 1) % 4][0], kCorners[(i + 1) % 4][1]);
        decltype(CellVertex::sites) sites{plane, sides[i], sides[(i + 3) % 4]};
        std::ranges::sort(sites);
        cell.vertices.push_back({lid.over(p), 0.475, sites, 1e-15});
        add_edge(cell, plane, sides[i], {i, (i + 1) % 4}, CurveKind::Line, segment(p, q), lid);
        outer.loops[0].push_back({i, {}, false, segment(p, q)});
    }
    add_edge(cell, sphere, plane, {}, CurveKind::Circle, circle(0.5), lid);
    outer.loops[1].push_back({4, {}, true, reversed(circle(0.5))});
    const TrimmedPatch inner{bowl.patch(-0.5, 0.5, -0.5, 0.5), {{{4, {}, false, circle(0.5)}}}};
    const double pi = std::numbers::pi;
    // [Over a disk of radius r, z = rho^2 / w has the area (pi w^2 / 6) ((1 + 4 r^2 / w^2)^(3/2) - 1).]
    const double bowl_area = pi * 6.25 / 6 * (std::pow(1 + 1 / 6.25, 1.5) - 1), lid_area = 4 - pi / 4;
    cell.faces.push_back({plane, {}, "plane", lid_area, 1e-14, {outer}});
    cell.faces.push_back({sphere, {}, "paraboloid", bowl_area, 1e-14, {inner}});
    cell.neighbors = {1, 0};
    cell.measures.volume = lid_area * 0.475 + (pi / 32 + 15.0 / 64 * pi) / 2.5;
    cell.measures.area = lid_area + bowl_area;
    set_errors(cell.measures, 1e-14);
    cell.measures.box_area = 8 * 0.475;
    cell.measures.body_volume = 0;
    cell.measures.base_area = 4;
    cell.measures.min_clearance = 0.375;
    cell.measures.max_clearance = 0.475;
    cell.measures.touches_box = true;
    return cell;
}

}  // namespace vcell::hand_built
