/// Good cells, places in them, and what is done to them there: the damages of damage_test.cpp.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <stdexcept>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"

namespace vcell::damages {

// --- Good cells ---------------------------------------------------------------------------------------

inline Scene example(const std::string& name) {
    return read_scene(VCELL_EXAMPLE_SCENES "/" + name + ".json");
}

inline Scene over_the_plane(std::vector<Object> objects, double half_width = 2, double height = 2) {
    Scene scene;
    scene.base = Plane{};
    scene.box = {{-half_width, -half_width, 0}, {half_width, half_width, height}};
    scene.objects = std::move(objects);
    return scene;
}

inline Scene balls() {
    return over_the_plane({Sphere{{-1.1, -0.9, 0.9}, 0.25}, Sphere{{0.9, -1.2, 0.7}, 0.2},
                           Sphere{{0.1, 0.2, 0.6}, 0.1}, Sphere{{1.3, 0.8, 1}, 0.4},
                           Sphere{{-1.2, 1.1, 0.8}, 0.3}, Sphere{{0.2, 1.4, 0.9}, 0.15},
                           Sphere{{-0.4, -0.3, 1.2}, 0.2}, Plane{{0, 0, 1.6}, {0.1, 0.05, -1}}});
}

/// Every inner vertex has four balls.
inline Scene lattice() {
    std::vector<Object> objects;
    for (const double x : {-1.0, 0.0, 1.0})
        for (const double y : {-1.0, 0.0, 1.0}) objects.push_back(Sphere{{x, y, 1}, 0.25});
    return over_the_plane(std::move(objects), 1.5);
}

/// Three tubes of a square lattice meet along each corner's edge.
inline Scene tube_lattice() {
    Scene scene;
    scene.base = Cylinder{{0, 0, 0}, {0, 0, 1}, 0.5};
    scene.box = {{-9, -9, -9}, {9, 9, 9}};
    for (const int i : {-1, 0, 1})
        for (const int j : {-1, 0, 1})
            if (i != 0 || j != 0) scene.objects.push_back(Cylinder{{2.0 * i, 2.0 * j, 0}, {0, 0, 1}, 0.5});
    return scene;
}

/// What ties about the hole in it is rounded, and assumed.
inline Scene hexagonal_tubes() {
    Scene scene;
    scene.base = Cylinder{{0, 0, 0}, {1, 0, 0}, 0.1};
    scene.box = {{-4, -4, -4}, {4, 4, 4}};
    const Vec3 u(0, 1, 0), v(0, 0.5, 0.5 * std::sqrt(3.0));
    for (const int i : {-2, -1, 0, 1, 2})
        for (const int j : {-2, -1, 0, 1, 2})
            if ((i != 0 || j != 0) && (i != 1 || j != 0))
                scene.objects.push_back(Cylinder{i * u + j * v, {1, 0, 0}, 0.1});
    return scene;
}

inline Scene tubes_around_a_tube() {
    Scene scene;
    scene.base = Cylinder{{0, 0, 0}, {0, 0, 1}, 0.5};
    scene.objects = {Sphere{{1.5, 0.25, 0.5}, 0.5},
                     Cylinder{{-1.25, 0.5, 0}, {0.25, 0.5, 1}, 0.25},
                     Cylinder{{0, -1.5, -0.5}, {1, 0.125, 0.125}, 0.5},
                     Sphere{{0.3, 1.4, -0.4}, 0.4},
                     Sphere{{1.3, -0.3, -0.7}, 0.3},
                     Sphere{{0.2, 1.5, 1}, 0.3}};
    scene.box = {{-3, -3, -2}, {3, 3, 2}};
    return scene;
}

/// Three balls so close to each other that their bisectors cut each other at angles of 10^-4.
inline Scene needle() {
    return over_the_plane(
        {Sphere{{0, 0, 1.1}, 0.1}, Sphere{{2e-4, 0, 1.1}, 0.1}, Sphere{{-1e-4, 1e-4, 1.1}, 0.1}});
}

inline const Cell& good(const std::string& name) {
    static const std::map<std::string, std::function<Scene()>> scenes{
        {"balls", balls},
        {"lattice", lattice},
        {"needle", needle},
        {"twin planes", [] { return read_scene(test_data("hostile/twin_planes_over_tilted_plane.json")); }},
        {"tube lattice", tube_lattice},
        {"hexagonal tubes", hexagonal_tubes},
        {"atom", [] { return example("atom_1crn"); }},
        {"tubes over a plane", [] { return example("leaning"); }},
        {"tubes around a tube", tubes_around_a_tube},
        {"around a cylinder", [] { return example("figure10"); }},
    };
    static std::map<std::string, Cell> cells;
    if (!cells.contains(name)) cells[name] = voronoi_cell(scenes.at(name)());
    return cells[name];
}

// --- Places -------------------------------------------------------------------------------------------

template <class Items, class Predicate>
std::uint32_t first(const Items& items, Predicate predicate) {
    const auto i = std::ranges::find_if(items, predicate);
    if (i == items.end()) throw std::logic_error("this cell has no such element");
    return static_cast<std::uint32_t>(i - items.begin());
}
inline bool is_inner(const CellVertex& v) { return std::ranges::all_of(v.sites, &Site::is_object); }
inline bool is_inner_edge(const CellEdge& e) { return std::ranges::all_of(e.sites, &Site::is_object); }
inline std::uint32_t inner_vertex(const Cell& c) { return first(c.vertices, is_inner); }
inline std::uint32_t inner_edge(const Cell& c) { return first(c.edges, is_inner_edge); }
inline std::uint32_t spline(const Cell& c) {
    return first(c.edges, [](const CellEdge& e) { return e.kind == CurveKind::Spline && is_inner_edge(e); });
}
inline std::uint32_t owned_face(const Cell& c) {
    return first(c.faces, [](const CellFace& f) { return f.site.is_object(); });
}

/// Beyond the base by most: objects of a molecule overlap it elsewhere.
inline std::uint32_t farthest_vertex(const Cell& c) {
    std::uint32_t best = inner_vertex(c);
    for (std::uint32_t v = 0; v < c.vertices.size(); ++v)
        if (is_inner(c.vertices[v]) && c.vertices[v].radius > c.vertices[best].radius) best = v;
    return best;
}

/// All trimming curves, with the face that they belong to.
template <class Visit>
void for_each_trim(Cell& c, Visit visit) {
    for (std::size_t f = 0; f < c.faces.size(); ++f)
        for (TrimmedPatch& patch : c.faces[f].patches)
            for (auto& loop : patch.loops)
                for (TrimCurve& trim : loop) visit(f, trim);
}
inline TrimCurve& seam(Cell& c) {
    TrimCurve* found = nullptr;
    for_each_trim(c, [&](std::size_t, TrimCurve& trim) {
        if (!found && trim.seam) found = &trim;
    });
    if (!found) throw std::logic_error("no seam");
    return *found;
}

// --- Damages ------------------------------------------------------------------------------------------

inline void scale(RationalPatch& surface, double factor) {
    for (auto& p : surface.points) p.head<3>() *= factor;
}

/// A bump as wide as 10^-3 of the curve's middle span, between t0 and t1, where nothing of it changes
/// elsewhere: the span's knots are made full there, and one control point moves. Pre: a polynomial curve.
template <int Dim>
void bump(RationalCurve<Dim>& c, const Eigen::Matrix<double, Dim, 1>& by) {
    using Point = Eigen::Matrix<double, Dim, 1>;
    using Control = typename RationalCurve<Dim>::ControlPoint;
    for (const auto& p : c.points) REQUIRE(p[Dim] == doctest::Approx(1));
    const std::size_t d = static_cast<std::size_t>(c.degree);
    // Insert a knot t (its multiplicity below d): Boehm's rule on every affected point.
    const auto insert = [&](double t) {
        std::size_t k = d;
        while (k + d + 2 < c.knots.size() && c.knots[k + 1] <= t) ++k;
        std::vector<Control> points;
        for (std::size_t i = 0; i <= c.points.size(); ++i) {
            const double width = i < c.points.size() && i > 0 ? c.knots[i + d] - c.knots[i] : 0;
            const double s = i + d <= k ? 1 : i > k ? 0 : width > 0 ? (t - c.knots[i]) / width : 0;
            if (s == 1)
                points.push_back(c.points[i]);
            else if (s == 0)
                points.push_back(c.points[i - 1]);
            else
                points.push_back((1 - s) * c.points[i - 1] + s * c.points[i]);
        }
        std::vector<double> knots(c.knots.begin(), c.knots.end());
        knots.insert(knots.begin() + static_cast<long>(k) + 1, t);
        c.knots = Knots();
        for (const double knot : knots) c.knots.push_back(knot);
        c.points.clear();
        for (const Control& p : points) c.points.push_back(p);
    };
    std::size_t middle = d + (c.knots.size() - 2 * d - 2) / 2;
    while (c.knots[middle] == c.knots[middle + 1]) ++middle;
    const double a = c.knots[middle], b = c.knots[middle + 1];
    REQUIRE(a < b);
    const double t0 = a + 0.5003 * (b - a), t1 = a + 0.5013 * (b - a);
    const Point before = c.evaluate(a + 0.7 * (b - a));
    for (const double t : {t0, t1})
        for (std::size_t i = 0; i < d; ++i) insert(t);
    CHECK((c.evaluate(a + 0.7 * (b - a)) - before).norm() < 1e-9);
    std::size_t k = 0;
    while (c.knots[k] < t0) ++k;
    c.points[k].template head<Dim>() += by;
}

/// Vertex v, of degree four, becomes two of degree three with an edge of length zero between them.
inline void split_vertex(Cell& c, std::uint32_t v) {
    struct Spoke {
        std::uint32_t edge;
        bool starts_here;
    };
    // The faces around v, counter-clockwise from the side on which a spoke leaves: left of an outgoing edge
    // comes before its right.
    std::vector<Spoke> spokes;
    for (std::uint32_t e = 0; e < c.edges.size(); ++e)
        for (const std::size_t end : {0, 1})
            if (c.edges[e].vertices.size() == 2 && c.edges[e].vertices[end] == v)
                spokes.push_back({e, end == 0});
    REQUIRE(spokes.size() == 4);
    const auto right = [&](const Spoke& s) { return c.edges[s.edge].sites[s.starts_here ? 1 : 0]; };
    const auto left = [&](const Spoke& s) { return c.edges[s.edge].sites[s.starts_here ? 0 : 1]; };
    for (std::size_t i = 0; i + 1 < spokes.size(); ++i)  // each spoke's left face is the next one's right
        for (std::size_t j = i + 1; j < spokes.size(); ++j)
            if (right(spokes[j]) == left(spokes[i])) {
                std::swap(spokes[i + 1], spokes[j]);
                break;
            }
    // Spokes 0 and 1 stay; 2 and 3 move to the new vertex. The new edge runs from v to it, between the faces
    // left of spoke 1 and right of spoke 0.
    // (`b` is on its left: there it follows spoke 0, which comes in, and spoke 3 goes out.)
    const Site a = left(spokes[1]), b = right(spokes[0]);
    const auto added = static_cast<std::uint32_t>(c.vertices.size());
    const auto bridge = static_cast<std::uint32_t>(c.edges.size());
    CellVertex w = c.vertices[v];
    c.vertices[v].sites = {a, b, left(spokes[0])};
    w.sites = {a, b, left(spokes[2])};
    for (auto* sites : {&c.vertices[v].sites, &w.sites}) std::ranges::sort(*sites);
    c.vertices.push_back(w);
    for (const std::size_t i : {2, 3})
        c.edges[spokes[i].edge].vertices[spokes[i].starts_here ? 0 : 1] = added;
    CellEdge edge;
    edge.sites = {b, a};
    edge.vertices = {v, added};
    edge.kind = CurveKind::Line;
    edge.length = 0;
    edge.curve.degree = 1;
    for (const double k : {0.0, 0.0, 1.0, 1.0}) edge.curve.knots.push_back(k);
    const Vec3 p = w.point;
    for (int k = 0; k < 2; ++k) edge.curve.points.push_back({p.x(), p.y(), p.z(), 1});
    c.edges.push_back(edge);
    // In a's loop the bridge runs back, after spoke 2 has come in and before spoke 1 goes out.
    const auto insert_after = [&](Site site, std::uint32_t coming, bool reversed) {
        for (CellFace& face : c.faces) {
            if (face.site != site) continue;
            for (auto& loop : face.patches[0].loops)
                for (std::size_t t = 0; t < loop.size(); ++t) {
                    if (loop[t].edge != coming) continue;
                    const std::size_t end = loop[t].reversed ? 0 : 1;
                    const std::uint32_t here = c.edges[coming].vertices[end];
                    if (here != v && here != added) continue;
                    TrimCurve trim{bridge, {}, reversed, {}};
                    trim.curve.degree = 1;
                    trim.curve.knots = c.edges[bridge].curve.knots;
                    const Vec2 uv = loop[t].curve.evaluate(loop[t].curve.domain_end());
                    for (int k = 0; k < 2; ++k) trim.curve.points.push_back({uv.x(), uv.y(), 1});
                    loop.insert(loop.begin() + static_cast<long>(t) + 1, trim);
                    return;
                }
        }
        throw std::logic_error("no such spoke");
    };
    insert_after(a, spokes[2].edge, true);
    insert_after(b, spokes[0].edge, false);
}

/// Over a plane: face f, with one loop of at least four edges, cut by an edge between it and itself from the
/// start of its first edge to that of its third.
inline void cut_face(Cell& c, std::uint32_t f) {
    CellFace& face = c.faces[f];
    REQUIRE(face.patches.size() == 1);
    REQUIRE(face.patches[0].loops.size() == 1);
    auto loop = face.patches[0].loops[0];
    REQUIRE(loop.size() >= 4);
    const auto start = [&](const TrimCurve& trim) {
        return c.edges[*trim.edge].vertices[trim.reversed ? 1 : 0];
    };
    const auto place = [](const TrimCurve& trim) { return trim.curve.evaluate(trim.curve.domain_begin()); };
    const Vec2 p = place(loop[0]), q = place(loop[2]), m = 0.5 * (p + q);
    const auto quadratic = [](auto& curve) {
        curve.degree = 2;
        for (const double k : {0.0, 0.0, 0.0, 1.0, 1.0, 1.0}) curve.knots.push_back(k);
    };
    const RationalPatch& surface = face.patches[0].surface;
    CellEdge edge;
    edge.sites = {face.site, face.site};
    edge.vertices = {start(loop[0]), start(loop[2])};
    edge.kind = CurveKind::Parabola;
    quadratic(edge.curve);
    const Vec3 a = surface.evaluate(p.x(), p.y()), b = surface.evaluate(q.x(), q.y());
    const Vec3 s = 2 * surface.evaluate(m.x(), m.y()) - 0.5 * (a + b);
    for (const Vec3& x : {a, s, b}) edge.curve.points.push_back({x.x(), x.y(), x.z(), 1});
    edge.length = (a - s).norm() + (s - b).norm();
    const auto cut = static_cast<std::uint32_t>(c.edges.size());
    c.edges.push_back(edge);
    const auto trim = [&](bool reversed) {
        TrimCurve t{cut, {}, reversed, {}};
        quadratic(t.curve);
        for (const Vec2& x : {reversed ? q : p, m, reversed ? p : q})
            t.curve.points.push_back({x.x(), x.y(), 1});
        return t;
    };
    CellFace other = face;
    auto& kept = face.patches[0].loops[0];
    auto& rest = other.patches[0].loops[0];
    kept = {loop[0], loop[1], trim(true)};
    rest.clear();
    rest.push_back(trim(false));
    rest.insert(rest.end(), loop.begin() + 2, loop.end());
    face.area *= 0.5;
    other.area = face.area;
    c.faces.push_back(other);
}

/// Unit direction from the nearest point of an object to p: the gradient of its distance.
inline Vec3 gradient(const Object& o, const Vec3& p) {
    if (const auto* s = std::get_if<Sphere>(&o)) return (p - s->center).normalized();
    if (const auto* plane = std::get_if<Plane>(&o)) {
        const Vec3 n = plane->normal.normalized();
        return n.dot(p - plane->point) < 0 ? Vec3(-n) : n;
    }
    const auto& t = std::get<Cylinder>(o);
    const Vec3 axis = t.axis.normalized(), q = p - t.point;
    return (q - axis.dot(q) * axis).normalized();
}

/// The cell of the scene less one ball, given out as that of the whole scene: structure and measures agree
/// with each other, and a face of `area` is missing. Where it is: about the point p of the boundary, where
/// `sites` meet.
inline Cell missing_face(const Cell& whole, const Vec3& p, std::span<const Site> sites, double area) {
    const Vec3 up = gradient(whole.scene.base, p);
    // The heights of sites over the base have slopes there, towards objects in directions d: -(d without its
    // part along up) / (1 + d up). The ball gets their mean, so that its face is as small as it reaches
    // little beyond p; and it is smaller than the objects.
    Vec3 slope = Vec3::Zero();
    double radius = 0.05, clearance = 0;
    for (const Site& s : sites) {
        const Object& o = whole.scene.objects[s.index];
        const Vec3 d = -gradient(o, p);
        slope -= (d - d.dot(up) * up) / (1 + d.dot(up)) / static_cast<double>(sites.size());
        if (const auto* ball = std::get_if<Sphere>(&o)) {
            radius = std::min(radius, 0.5 * ball->radius);
            clearance = (p - ball->center).norm() - ball->radius;
        } else if (const auto* tube = std::get_if<Cylinder>(&o)) {
            radius = std::min(radius, 0.5 * tube->radius);
            clearance = (p - tube->point).cross(tube->axis.normalized()).norm() - tube->radius;
        } else {
            const auto& plane = std::get<Plane>(o);
            clearance = std::abs(plane.normal.normalized().dot(p - plane.point));
        }
    }
    const double rise = (1 - slope.squaredNorm()) / (1 + slope.squaredNorm());
    const Vec3 towards = rise * up - (1 + rise) * slope;
    // It is nearer to p than the sites by `depth`.
    const auto with_ball = [&](double depth) {
        Scene scene = whole.scene;
        scene.objects.push_back(Sphere{p + (clearance - depth + radius) * towards, radius});
        if (!scene.names.empty()) scene.names.emplace_back();
        return scene;
    };
    const auto area_at = [&](double depth) {
        const Cell cell = voronoi_cell(with_ball(depth));
        const Site site = Site::object(static_cast<std::uint32_t>(whole.scene.objects.size()));
        double sum = 0;
        for (const CellFace& f : cell.faces)
            if (f.site == site) sum += f.area;
        return sum;
    };
    // In a face areas grow as the depth does, at a vertex as its square.
    double depth = 1e-3, at = area_at(depth);
    for (int k = 0; k < 12 && !(at > 0.5 * area && at < 2 * area); ++k) {
        depth *= at > 0 ? std::pow(area / at, 0.6) : 4;
        at = area_at(depth);
    }
    REQUIRE(at > 0.3 * area);
    REQUIRE(at < 3 * area);
    Cell cell = whole;
    cell.scene = with_ball(depth);
    return cell;
}

/// A point of an owned face, away from its edges: of a patch's parameters, the mean of its loop's corners.
inline Vec3 inside_of(const CellFace& face) {
    const TrimmedPatch& patch = face.patches[0];
    Vec2 sum = Vec2::Zero();
    for (const TrimCurve& trim : patch.loops[0]) sum += trim.curve.evaluate(trim.curve.domain_begin());
    const Vec2 uv = sum / static_cast<double>(patch.loops[0].size());
    return patch.surface.evaluate(uv.x(), uv.y());
}

/// The direction in which a vertex may move so that its distances hardly differ.
inline Vec3 bad_direction(const Cell& c, std::uint32_t v) {
    const CellVertex& vertex = c.vertices[v];
    const Vec3 base = gradient(c.scene.base, vertex.point);
    std::vector<Vec3> differences;
    for (const Site& site : vertex.sites)
        differences.push_back(gradient(c.scene.objects[site.index], vertex.point) - base);
    Vec3 across = Vec3::Zero();
    for (const Vec3& a : differences)
        for (const Vec3& b : differences)
            if (a.cross(b).norm() > across.norm()) across = a.cross(b);
    return across.normalized();
}

}  // namespace vcell::damages
