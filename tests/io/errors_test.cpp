// Stated errors against the true cell: points of edges are compared with roots in 100 digits of the distances
// to the scene's own objects, needle cells with integrals in 50 digits.
#include <doctest/doctest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"

using namespace vcell;

namespace {

using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;
using Point = std::array<Real, 3>;

Real dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Point operator*(const Real& s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }
Point cross(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real norm(const Point& a) { return sqrt(dot(a, a)); }
Point exact(const Vec3& p) { return {Real(p.x()), Real(p.y()), Real(p.z())}; }

// The distance to an object's surface and its gradient.
struct Distance {
    Real value;
    Point gradient;
};
Distance distance(const Object& object, const Point& p) {
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const Point n = exact(plane->normal);
        const Real length = norm(n), d = dot(p - exact(plane->point), n) / length;
        return d < 0 ? Distance{-d, -1 / length * n} : Distance{d, 1 / length * n};
    }
    Point m;
    double radius;
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        m = p - exact(sphere->center);
        radius = sphere->radius;
    } else {
        const auto& cylinder = std::get<Cylinder>(object);
        const Point d = exact(cylinder.axis);
        m = p - exact(cylinder.point);
        m = m - dot(m, d) / dot(d, d) * d;
        radius = cylinder.radius;
    }
    const Real length = norm(m);
    return {length - radius, 1 / length * m};
}

// What vanishes where a site is as near as the base.
Distance equation(const Scene& scene, Site site, const Point& p) {
    if (site.kind == Site::Kind::BoxSide) {
        const unsigned axis = site.index / 2;
        const double bound = site.index % 2 == 0 ? scene.box.min[axis] : scene.box.max[axis];
        Point g{0, 0, 0};
        g[axis] = 1;
        return {p[axis] - bound, g};
    }
    const Distance a = distance(scene.objects[site.index], p), b = distance(scene.base, p);
    return {a.value - b.value, a.gradient - b.gradient};
}

// What vanishes on the wall over the rim where a side of the box meets a base plane.
Distance wall(const Scene& scene, Site site, const Point& p) {
    const auto& base = std::get<Plane>(scene.base);
    const unsigned axis = site.index / 2;
    const double bound = site.index % 2 == 0 ? scene.box.min[axis] : scene.box.max[axis];
    const Point n = 1 / norm(exact(base.normal)) * exact(base.normal);
    Point side{0, 0, 0};
    side[axis] = 1;
    // Of p + s n in the base the coordinate is the side's.
    const Real s = -dot(p - exact(base.point), n);
    return {p[axis] + s * n[axis] - bound, side - n[axis] * n};
}

// The point where three functions vanish, by Newton's method.
template <class F>
Point root(Point p, F equations) {
    for (int i = 0; i < 60; ++i) {
        const std::array<Distance, 3> e = equations(p);
        const Point bc = cross(e[1].gradient, e[2].gradient), ca = cross(e[2].gradient, e[0].gradient),
                    ab = cross(e[0].gradient, e[1].gradient);
        const Real det = dot(e[0].gradient, bc);
        const Point step = (1 / det) * (e[0].value * bc + e[1].value * ca + e[2].value * ab);
        p = p - step;
        if (norm(step) < Real(1e-60)) break;
    }
    return p;
}

// A Bezier span's point and direction, control points weighted.
template <int N>
std::array<std::array<Real, N>, 2> on_span(std::vector<std::array<Real, N>> b, const Real& s) {
    std::array<Real, N> direction{};
    for (std::size_t n = b.size() - 1; n > 0; --n) {
        if (n == 1)
            for (int k = 0; k < N; ++k) direction[k] = b[1][k] - b[0][k];
        for (std::size_t i = 0; i < n; ++i)
            for (int k = 0; k < N; ++k) b[i][k] += s * (b[i + 1][k] - b[i][k]);
    }
    return {b[0], direction};
}
template <int Dim>
std::vector<std::array<Real, Dim + 1>> span(const RationalCurve<Dim>& c, std::size_t i) {
    std::vector<std::array<Real, Dim + 1>> b;
    for (int k = 0; k <= c.degree; ++k) {
        const auto& p = c.points[i * c.degree + k];
        std::array<Real, Dim + 1> q;
        for (int d = 0; d < Dim; ++d) q[d] = Real(p[d]) * p[Dim];
        q[Dim] = p[Dim];
        b.push_back(q);
    }
    return b;
}
template <int Dim>
std::size_t span_count(const RationalCurve<Dim>& c) {
    return (c.points.size() - 1) / c.degree;
}

Point on_surface(const RationalPatch& s, const Real& u, const Real& v) {
    std::vector<std::array<Real, 4>> rows;
    for (int i = 0; i <= s.degree_u; ++i) {
        std::vector<std::array<Real, 4>> row;
        for (int j = 0; j <= s.degree_v; ++j) {
            const Eigen::Vector4d& p = s.point(i, j);
            row.push_back({Real(p.x()) * p.w(), Real(p.y()) * p.w(), Real(p.z()) * p.w(), Real(p.w())});
        }
        rows.push_back(on_span<4>(row, (v - s.domain_v[0]) / (Real(s.domain_v[1]) - s.domain_v[0]))[0]);
    }
    const auto p = on_span<4>(rows, (u - s.domain_u[0]) / (Real(s.domain_u[1]) - s.domain_u[0]))[0];
    return {p[0] / p[3], p[1] / p[3], p[2] / p[3]};
}

// Points of edges, vertices and trims against the true ones. Returns the largest part of a stated error that
// is used.
double check_errors(const Cell& cell) {
    const Scene& scene = cell.scene;
    double most = 0;
    const auto hold = [&](const Real& off, double error) {
        CHECK(off <= error);
        if (error > 0) most = std::max(most, static_cast<double>(off / error));
    };
    for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
        CAPTURE(i);
        const CellVertex& v = cell.vertices[i];
        // Over a tilted base the sides of the box are not the walls over its rim.
        const auto* base = std::get_if<Plane>(&scene.base);
        if (base != nullptr && base->normal.cwiseAbs().maxCoeff() < base->normal.norm() &&
            std::ranges::any_of(v.sites, [](Site s) { return s.kind == Site::Kind::BoxSide; }))
            continue;
        const Point p = exact(v.point);
        // The triple whose gradients are the least dependent.
        std::array<Site, 3> best{};
        Real largest = 0;
        for (std::size_t a = 0; a < v.sites.size(); ++a)
            for (std::size_t b = a + 1; b < v.sites.size(); ++b)
                for (std::size_t c = b + 1; c < v.sites.size(); ++c) {
                    const std::array sites{v.sites[a], v.sites[b], v.sites[c]};
                    if (std::ranges::any_of(sites, [](Site s) { return s.kind == Site::Kind::End; }))
                        continue;
                    const Real det = abs(dot(
                        equation(scene, sites[0], p).gradient,
                        cross(equation(scene, sites[1], p).gradient, equation(scene, sites[2], p).gradient)));
                    if (det > largest) best = sites;
                    largest = std::max(largest, det);
                }
        if (largest == 0) continue;
        const Point true_vertex = root(p, [&](const Point& q) {
            return std::array{equation(scene, best[0], q), equation(scene, best[1], q),
                              equation(scene, best[2], q)};
        });
        hold(norm(true_vertex - p), v.error);
    }
    std::vector<int> trims(cell.edges.size(), 0);
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop)
                    if (trim.edge) ++trims[*trim.edge];
    for (std::size_t i = 0; i < cell.edges.size(); ++i) {
        CAPTURE(i);
        const CellEdge& e = cell.edges[i];
        const bool on_rim = std::holds_alternative<Plane>(scene.base) && trims[i] == 1;
        const auto second = [&](const Point& x) {
            return on_rim ? wall(scene, e.sites[1], x) : equation(scene, e.sites[1], x);
        };
        if (e.sites[0].kind == Site::Kind::End || e.sites[1].kind == Site::Kind::End) continue;
        for (std::size_t k = 0; k < span_count(e.curve); ++k)
            for (const double s : {0.0, 0.13, 0.41, 0.5, 0.77, 1.0}) {
                const auto [q, d] = on_span<4>(span<3>(e.curve, k), Real(s));
                const Point p{q[0] / q[3], q[1] / q[3], q[2] / q[3]};
                const Point along = Point{d[0], d[1], d[2]} - d[3] * p;
                const Real length = norm(along);
                if (length == 0) continue;
                // Next to objects that touch, the equations do not tell the point.
                if (norm(cross(equation(scene, e.sites[0], p).gradient, second(p).gradient)) < Real(1e-9))
                    continue;
                const Point true_point = root(p, [&](const Point& x) {
                    return std::array{equation(scene, e.sites[0], x), second(x),
                                      Distance{dot(x - p, along) / length, 1 / length * along}};
                });
                hold(norm(true_point - p), e.error);
            }
    }
    for (std::size_t f = 0; f < cell.faces.size(); ++f)
        for (const TrimmedPatch& patch : cell.faces[f].patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop) {
                    if (!trim.edge) continue;
                    const CellEdge& e = cell.edges[*trim.edge];
                    CAPTURE(f);
                    CAPTURE(*trim.edge);
                    const std::size_t n = span_count(e.curve);
                    if (span_count(trim.curve) != n) continue;  // a part
                    for (std::size_t k = 0; k < n; ++k)
                        for (const double s : {0.0, 0.13, 0.5, 0.77, 1.0}) {
                            const auto c = on_span<3>(span<2>(trim.curve, k), Real(s))[0];
                            const auto q = on_span<4>(span<3>(e.curve, trim.reversed ? n - 1 - k : k),
                                                      Real(trim.reversed ? 1 - s : s))[0];
                            const Point p{q[0] / q[3], q[1] / q[3], q[2] / q[3]};
                            hold(norm(on_surface(patch.surface, c[0] / c[2], c[1] / c[2]) - p), e.error);
                        }
                }
    return most;
}

Cell hostile(const std::string& name) {
    return voronoi_cell(read_scene(test_data("hostile/" + name + ".json")));
}

double largest_edge_error(const Cell& cell) {
    double most = 0;
    for (const CellEdge& e : cell.edges) most = std::max(most, e.error);
    return most;
}

}  // namespace

TEST_CASE("errors: an ellipse between all but equal spheres states how far it may be off") {
    const Cell cell = hostile("e0");
    check_errors(cell);
    CHECK(largest_edge_error(cell) < 1e-3);
}

TEST_CASE("errors: trims beside a needle stay on their side of the box") {
    for (const char* name : {"trim_sphere_point_1e-06", "trim_sphere_point_1e-12", "trim_two_balls_5e-4"}) {
        CAPTURE(name);
        const Cell cell = hostile(name);
        check_errors(cell);
        CHECK(largest_edge_error(cell) < 1e-5);
    }
}

TEST_CASE("errors: a fit that cannot be proved ends, and says how far it may be off") {
    const Cell cell = hostile("oom_24");
    std::size_t points = 0;
    for (const CellEdge& e : cell.edges) {
        points += e.curve.points.size();
        CHECK(std::isfinite(e.error));
    }
    CHECK(points < 20'000);
    check_errors(cell);
}

TEST_CASE(
    "errors: hostile lines beside a plane: edges along a sharp bend are proved whole, areas have bounds") {
    CHECK(largest_edge_error(hostile("line_beside_plane")) < 1e-8);
    const Cell along = hostile("line_along_plane");
    CHECK(largest_edge_error(along) < 1e-8);
    for (const CellFace& face : along.faces) CHECK(face.area_error < 1e-4);
}

TEST_CASE("errors: hostile steep faces: areas have bounds") {
    for (const CellFace& face : hostile("steep_cone").faces) CHECK(face.area_error < 1e-4);
    // From the cone's tip, which is next to the region, its directions are known.
    for (const CellFace& face : hostile("tip_beside_region").faces) CHECK(face.area_error < 1e-10);
}

TEST_CASE("errors: hostile needles: edges that cut them are known, and patches end there") {
    for (const char* name : {"needle_cut_by_tube", "needle_in_tube", "slit_in_tube"}) {
        CAPTURE(name);
        const Cell cell = hostile(name);
        check_errors(cell);
        CHECK(largest_edge_error(cell) < 1e-6);
    }
}

TEST_CASE("errors: hostile touching tubes: integrals begin where distances are bounded") {
    // By adaptive quadrature of half the squared distance over angle and height, within 1e-9.
    for (const auto& [name, volume] : {std::pair("line_touches_tube", 32.0913983207),
                                       {"line_near_tube", 41.8363141079},
                                       {"tube_touches_line", 8.3849848036}}) {
        CAPTURE(name);
        const Measures m = hostile(name).measures;
        CHECK(std::abs(m.volume - volume) <= m.volume_error + 1e-9);
        CHECK(m.volume_error < 1e-9);
    }
}

TEST_CASE(
    "errors: hostile slits: integrals along a tube begin next to the face, not at one of its vertices") {
    const Measures m = hostile("line_beside_ball_between_planes").measures;
    CHECK(m.volume_error < 1e-9);
    CHECK(std::abs(m.volume - 1.863386) < 1e-6);
    CHECK(m.area_error < 1e-4);
}

TEST_CASE("errors: hostile needles: areas state what is rounded, not the sizes of all that is around") {
    for (const char* name : {"point_touches_tube", "tube_touches_point"}) {
        CAPTURE(name);
        const Cell cell = hostile(name);
        for (const CellFace& face : cell.faces) CHECK(face.area_error < 1e-4);
        CHECK(cell.measures.volume_error < 1e-9);
    }
}

TEST_CASE("errors: hostile slits: a needle takes errors across its rays as far as it leans against them") {
    for (const char* name : {"slit_along_tube", "narrow_slit_along_tube"}) {
        CAPTURE(name);
        const Cell cell = hostile(name);
        check_errors(cell);
        for (const CellEdge& e : cell.edges)
            if (e.kind == CurveKind::Line) CHECK(e.error < 1e-7);
    }
}

TEST_CASE("errors: hostile slits: edges state what their faces' patches lose beside them, not elsewhere") {
    const Cell cell = hostile("slit_beside_ball");
    CHECK(largest_edge_error(cell) > 1e-4);
    CHECK(std::ranges::count_if(cell.edges, [](const CellEdge& e) { return e.error > 2e-5; }) == 2);
}

TEST_CASE("errors: hostile contact: along an edge gradients may turn thousands of times by their length") {
    CHECK(largest_edge_error(hostile("plane_touches_line")) < 1e-5);
}

TEST_CASE("errors: hostile twins: an edge between all but equal lines is proved in few spans") {
    const Cell cell = hostile("twin_lines_over_plane");
    CHECK(largest_edge_error(cell) < 1e-5);
    for (const CellEdge& e : cell.edges) CHECK(e.curve.points.size() < 1000);
}

TEST_CASE("errors: hostile tips: a bend that rounding hides takes no halvings from the rest of a conic") {
    CHECK(largest_edge_error(hostile("tip_beside_side")) < 1e-9);
}

TEST_CASE("errors: hostile nodes: what rounding blurs takes no halvings from the rest of an edge") {
    for (const char* name : {"near_node", "ball_on_line"}) {
        CAPTURE(name);
        CHECK(largest_edge_error(hostile(name)) < 1e-4);
    }
}

TEST_CASE("errors: hostile hairpins: what divides an edge lies on it, not on its other strand") {
    CHECK(largest_edge_error(hostile("hairpin")) < 1e-3);
}

TEST_CASE("errors: hostile chords: what rounding blurs is enclosed about as closely as it is long") {
    CHECK(largest_edge_error(hostile("tubes_all_but_cross")) < 1e-4);
    CHECK(largest_edge_error(hostile("hairpin")) < 3e-4);
}

TEST_CASE("errors: hostile rounding: a tube near the base is told by its distance, not by where it reaches") {
    for (const CellEdge& e : hostile("hairpin").edges) CHECK(e.curve.points.size() < 1200);
}

TEST_CASE("errors: hostile rooms: spans that rounding blurs are proved where their surroundings are simple") {
    CHECK(largest_edge_error(hostile("point_on_plane")) < 1e-6);
}

TEST_CASE("errors: hostile twins: of balls 1e-8 apart vertices and edges state rounding") {
    // Seen from the base its twin's bisector is steep: the other heights tell a vertex.
    for (const auto& [name, most] : {std::pair("twins_over_plane", 1e-11),
                                     {"twins_around_ball", 1e-10},
                                     {"twins_over_tilted_plane", 1e-10},
                                     {"twin_of_base", 1e-10}}) {
        CAPTURE(name);
        const Cell cell = hostile(name);
        for (const CellVertex& v : cell.vertices) CHECK(v.error < most);
        for (const CellEdge& e : cell.edges) CHECK(e.error < most);
    }
}

TEST_CASE("errors: hostile twins: of planes 1e-14 apart vertices and edges state rounding") {
    const Cell cell = hostile("twin_planes_over_tilted_plane");
    for (const CellVertex& v : cell.vertices) CHECK(v.error < 1e-12);
    for (const CellEdge& e : cell.edges) CHECK(e.error < 1e-12);
}

TEST_CASE(
    "errors: hostile twins: an edge between tubes 3e-6 apart has few spans, and errs as rounding tells it") {
    const Cell cell = hostile("twin_tubes_over_plane");
    for (const CellEdge& e : cell.edges) {
        CHECK(e.error < 3e-5);
        CHECK(e.curve.points.size() < 500);
    }
}

TEST_CASE(
    "errors: hostile motion: what a scene moved by moves edges beside a twin of the base ball by as little") {
    CHECK(largest_edge_error(hostile("planes_beside_twin")) < 1e-7);
}

TEST_CASE("errors: hostile motion: edges are where they are, however badly their trims are told") {
    CHECK(largest_edge_error(hostile("needle_beside_plane")) < 1e-5);
}

TEST_CASE("errors: conics and splines of all bases stay within what they state") {
    const std::array bases{
        Object(Plane{{0, 0, -1}, {0, 0, 1}}), Object(Plane{{0.1, 0, -0.9}, {0.1, -0.2, 1}}),
        Object(Sphere{{0.1, 0.2, -0.3}, 0.3}), Object(Cylinder{{0, 0.1, -0.2}, {0, 1, 0}, 0.2}),
        Object(Cylinder{{0, 0.1, -0.2}, {0.1, 1, 0.2}, 0.2})};
    for (std::size_t i = 0; i < bases.size(); ++i) {
        CAPTURE(i);
        Scene scene;
        scene.base = bases[i];
        scene.box = {Vec3(-2, -2, -2), Vec3(2, 2, 2)};
        if (i == 0) scene.box.min.z() = -1;
        scene.objects = {Sphere{{0.9, 0.4, 0.9}, 0.3}, Sphere{{-0.7, 0.8, 1.1}, 0.2},
                         Plane{{0, 0, 1.6}, {0.1, 0.2, -1}}, Cylinder{{0.8, -1.1, 0.7}, {0.3, 0.2, 1}, 0.1},
                         Cylinder{{-1.2, -0.9, 0.8}, {1, 0.8, 0.1}, 0.25}};
        if (i < 2) scene.objects.erase(scene.objects.begin() + 3);  // cuts the base
        const Cell cell = voronoi_cell(scene);
        check_errors(cell);
        CHECK(largest_edge_error(cell) < 1e-5);
    }
}

TEST_CASE("errors: of a conic with uneven weights as of its parts") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = {Vec3(-2, -2, -2), Vec3(2, 2, 2)};
    scene.objects = {Cylinder{{-1.9660563480762456, -1.3128672014052924, 0.8128562680581415},
                              {-0.6683350326831824, 0.7435200789477416, 0.02249836193845066},
                              0.2512301518201435},
                     Cylinder{{1.7493030445418976, -1.6164153193437332, 1.188651342666951},
                              {0.2989194123125363, -0.050252668578053945, -0.9529542771001724},
                              0.029111304466082462},
                     Cylinder{{-0.6696955941466749, 0.951261843026526, -1.7152705870691092},
                              {0.7911748932529591, 0.4306553782997478, -0.4342559538194841},
                              0}};
    const Cell cell = voronoi_cell(scene);
    check_errors(cell);
    for (const CellEdge& e : cell.edges)
        if (e.kind != CurveKind::Spline) CHECK(e.error < 1e-9);
}

// The cell of the point a next to a ball (c, R) is what a sheet of a hyperboloid holds, clipped here by one
// side of the box. With z along the axis from a, away from the ball, e = |a - c| - R, k = (e / R) (2 + e / R)
// and b = e + e^2 / (2 R), the surface is |p| = (1 + e / R) z + b.
TEST_CASE("errors: the volume of a needle cell is within its error, which is of its size") {
    const Cell cell = hostile("volume_error_5.0_1e-08");
    const Scene& scene = cell.scene;
    const auto& ball = std::get<Sphere>(scene.objects[0]);
    const Point a = exact(std::get<Sphere>(scene.base).center), c = exact(ball.center);
    const Real R = ball.radius, apart = norm(a - c), e = apart - R, slope = apart / R,
               b = e + e * e / (2 * R), k = e / R * (2 + e / R);
    const Point axis = 1 / apart * (a - c);
    const Point x_axis = [&] {
        const Point across = cross(axis, Point{0, 0, 1});
        return 1 / norm(across) * across;
    }();
    const Point y_axis = cross(axis, x_axis);
    // The side that the axis leaves through.
    unsigned side = 0;
    Real exit = -1;
    for (unsigned i = 0; i < 3; ++i) {
        const Real z = ((axis[i] > 0 ? Real(scene.box.max[i]) : Real(scene.box.min[i])) - a[i]) / axis[i];
        if (exit < 0 || z < exit) {
            exit = z;
            side = i;
        }
    }
    const auto height = [&](const Real& r2) -> Real {
        return (r2 - b * b) / (slope * b + sqrt(slope * slope * b * b + k * (r2 - b * b)));
    };
    // Over each direction theta up to where surface and side meet, Simpson's rule in s = (r / r_max)^2, of
    // which the height is smooth; the trapezoidal rule around.
    constexpr int directions = 64, steps = 64;
    Real volume = 0;
    for (int i = 0; i < directions; ++i) {
        const double theta = 2 * std::numbers::pi * i / directions;
        const Real gx = -x_axis[side] / axis[side], gy = -y_axis[side] / axis[side];
        const Real tilt = gx * std::cos(theta) + gy * std::sin(theta);
        Real r = 0;
        for (int n = 0; n < 40; ++n) {
            const Real z = exit + tilt * r, t = slope * z + b;
            r = sqrt(t * t - z * z);
        }
        const auto f = [&](const Real& s) -> Real { return exit + tilt * r * sqrt(s) - height(s * r * r); };
        // The tilt's part is exact: the integral of tilt r^2.
        Real sum = 0;
        for (int n = 0; n <= steps; ++n) {
            const Real s = Real(n) / steps;
            const Real value = f(s) - tilt * r * sqrt(s);
            sum += value * (n == 0 || n == steps ? 1 : n % 2 == 1 ? 4 : 2);
        }
        volume += r * r / 2 * sum / (3 * steps) + tilt * r * r * r / 3;
    }
    volume *= 2 * std::numbers::pi / directions;
    const double expected = static_cast<double>(volume);
    CAPTURE(expected);
    CHECK(std::abs(cell.measures.volume - expected) <= cell.measures.volume_error + 1e-10 * expected);
    CHECK(cell.measures.volume_error < 1e-4 * expected);
}
