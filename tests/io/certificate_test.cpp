/// certify(): what is proved is true, what is damaged is refuted; the parts it is made of.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <sstream>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/check/containment.hpp"
#include "../../io/check/excess.hpp"
#include "../../io/check/forms.hpp"
#include "../../io/check/krawczyk.hpp"
#include "../../io/check/scene.hpp"
#include "../../io/check/site_tree.hpp"
#include "../../io/check/turns.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"
#include "listing.hpp"

namespace vcell {
namespace {

Scene scene_named(const std::string& name) { return read_scene(VCELL_EXAMPLE_SCENES "/" + name + ".json"); }
Scene hostile(const std::string& name) { return read_scene(test_data("hostile/" + name + ".json")); }

void expect_refuted(const Cell& good, const std::string& where, const std::function<void(Cell&)>& damage) {
    Cell bad = good;
    damage(bad);
    const Certificate c = certify(bad);
    CHECK_FALSE(c.holds());
    const bool named = std::ranges::any_of(c.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && e.where.starts_with(where);
    });
    CHECK_MESSAGE(named, "expected ", where, ", found\n", listing(c));
}

/// Scales a scene's lengths.
Scene scaled(Scene s, double unit) {
    const auto scale = [unit](Object& o) {
        if (auto* p = std::get_if<Plane>(&o)) p->point *= unit;
        if (auto* b = std::get_if<Sphere>(&o)) b->center *= unit, b->radius *= unit;
        if (auto* c = std::get_if<Cylinder>(&o)) c->point *= unit, c->radius *= unit;
    };
    scale(s.base);
    for (Object& o : s.objects) scale(o);
    for (Vec3* corner : {&s.box.min, &s.box.max}) *corner *= unit;
    if (s.tolerance) *s.tolerance *= unit;
    return s;
}

}  // namespace

TEST_CASE("certify: proves a cell within a small distance, whatever its unit") {
    for (const std::string name : {"figure2", "figure6", "parallel"})
        for (const double unit : {1.0, 1e-40, 0x1p60}) {
            CAPTURE(name);
            CAPTURE(unit);
            const Scene scene = scaled(scene_named(name), unit);
            const Certificate c = certify(voronoi_cell(scene));
            CHECK_MESSAGE(c.holds(), listing(c));
            CHECK(c.distance > 0);
            CHECK(c.distance < 1e-6 * scene.box.diagonal());
        }
}

TEST_CASE("certify: proves hostile cells, and finds no error in them larger than it need be") {
    for (const char* name : {"near_twins",
                             "steep_face",
                             "uneven_weights",
                             "control_point_below",
                             "leaning_tube",
                             "bundle_of_lines",
                             "box_edge_in_bisector",
                             "scaled_ball",
                             "far_corners",
                             "line_beside_plane",
                             "tip_beside_region",
                             "small_face_far_out",
                             "needle_in_bundle",
                             "lines_an_ulp_apart",
                             "flat_hyperboloid",
                             "point_on_line",
                             "line_in_plane",
                             "ball_behind_base",
                             "hidden_tie",
                             "turning_twice",
                             "lever",
                             "volume_error_among_tubes",
                             "twin_tubes_over_plane",
                             "tie_along_edge_cut_to_a_point",
                             "needle_of_no_width",
                             "node_of_touching_tubes",
                             "twin_tubes_around_ball",
                             "tube_behind_plane",
                             "twin_lines_in_roundings",
                             "twins_at_the_pole",
                             "slab_of_roundings",
                             "tilted_slab",
                             "twin_lines_at_a_side",
                             "ring_of_three",
                             "ring_at_end",
                             "plane_leans_by_roundings",
                             "tube_along_slab",
                             "hole_below_errors",
                             "twins_opposite_the_pole",
                             "twin_of_base_point",
                             "point_beside_line",
                             "lines_cross_beside_tube",
                             "needle_around_tube",
                             "cusp_beside_tube",
                             "cusp_beside_tilted_tube",
                             "cap_of_leaning_tube",
                             "cap_touches_side",
                             "sphere_touches_tube",
                             "cone_along_leaning_tube",
                             "wall_about_leaning_tube",
                             "ball_behind_apex",
                             "axes_cross_beyond_base",
                             "tie_along_rim",
                             "tube_ties_along_rim",
                             "generator_in_a_corner",
                             "tube_touches_plane_beside_region",
                             "side_between_planes",
                             "tubes_touch_one_circle",
                             "cone_in_cone",
                             "walls_meet_on_plane",
                             "wall_touches_side_on_plane",
                             "rim_through_corner",
                             "lines_cross_in_a_tie"}) {
        CAPTURE(name);
        const Certificate c = certify(voronoi_cell(hostile(name)));
        CHECK_MESSAGE(c.holds(), listing(c));
    }
    // Beside a node two bisectors are nearly one: where another face may begin is left open.
    const Cell node = voronoi_cell(hostile("node_of_tubes"));
    CHECK(std::ranges::count(node.vertices, true, &CellVertex::is_touching) == 1);
    const Cell touched = voronoi_cell(hostile("touching_from_above"));
    CHECK(touched.vertices.size() == 4);
    for (const Cell* cell : {&node, &touched}) {
        const Certificate c = certify(*cell);
        CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
    }
    // Of two balls that are 1e-8 apart one is nearly as near as the other beside its edges, which is left
    // open; so are the length of a conic with a sharp turn, and edges of bisectors that are nearly parallel.
    // What is left open takes all the effort there is.
    CheckOptions options;
    if (rounds() == 1) options.effort = 6;
    for (const char* name : {"twins_over_plane",
                             "twins_over_tilted_plane",
                             "twins_around_ball",
                             "steep_cone",
                             "near_node",
                             "ball_on_line",
                             "plane_on_base",
                             "needle_in_tube",
                             "base_line_in_side",
                             "ends_at_a_tube",
                             "ball_at_the_base",
                             "points_and_ball_at_the_base",
                             "twin_lines_over_plane",
                             "tip_beside_side",
                             "hairpin",
                             "ball_on_tube",
                             "twin_planes_over_tilted_plane",
                             "tube_touches_line",
                             "point_touches_tube",
                             "plane_touches_line",
                             "twin_of_base_in_roundings"}) {
        CAPTURE(name);
        const Certificate c = certify(voronoi_cell(hostile(name)), options);
        CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
    }
}

TEST_CASE("certify: a vertical tube's cone is circular") {
    Scene scene;
    scene.base = Plane{};
    scene.objects = {Cylinder{{-0.41, -1.1, 2.8}, {0, 0, 1}, 0.036}};
    scene.box = {{-1, -1, 0}, {1, 1, 2.5}};
    const Certificate c = certify(voronoi_cell(scene));
    CHECK_MESSAGE(c.holds(), listing(c));
}

// The plane's side of the box leaves a face of 2e-31: halves of its trims do not shrink.
TEST_CASE("certify: a face as thin as its numbers' rounding") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {-2, 1, -1}};
    for (const double x : {-2, 2})
        for (const double y : {-1, 1})
            for (const double z : {-2, 2}) scene.objects.push_back(Sphere{{x, y, z}, 0});
    scene.box = {{-3, -3, -3}, {3, 3, 3}};
    const Cell cell = voronoi_cell(scene);
    REQUIRE(std::ranges::any_of(cell.faces, [](const CellFace& f) { return f.area < 1e-29; }));
    const Certificate c = certify(cell);
    CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
}

TEST_CASE("certify: kinds of conics about a sphere are told exactly") {
    using enum CurveKind;
    // Circles lie across an axis that all three centres share, and 2^-50 beside it are ellipses. A ball at
    // (4, 0, 3) meets a side x in an ellipse, a parabola, a hyperbola as its radius less the base's is above,
    // at or below 3.
    struct Case {
        std::vector<Object> balls;
        CurveKind kind, wrong;
    };
    const double radius = 3.5;
    for (const Case& c : {Case{{Sphere{{0, 0, 2}, 1.25}, Sphere{{0, 0, 4}, 3.125}}, Circle, Ellipse},
                          Case{{Sphere{{0x1p-50, 0, 2}, 1.25}, Sphere{{0, 0, 4}, 3.125}}, Ellipse, Circle},
                          Case{{Sphere{{4, 0, 3}, radius}}, Parabola, Ellipse},
                          Case{{Sphere{{4, 0, 3}, std::nextafter(radius, 4)}}, Ellipse, Parabola},
                          Case{{Sphere{{4, 0, 3}, std::nextafter(radius, 3)}}, Hyperbola, Parabola}}) {
        Scene scene;
        scene.base = Sphere{{0, 0, 0}, 0.5};
        scene.objects = c.balls;
        scene.box = {{-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}};
        const Cell good = voronoi_cell(scene);
        const auto edge = std::ranges::find_if(good.edges, [&](const CellEdge& e) {
            const auto is_side = [](const Site& site) {
                return site.kind == Site::Kind::BoxSide && site.index / 2 == 0;
            };
            const auto [p, q] = std::pair(e.sites[0], e.sites[1]);
            return c.balls.size() == 2 ? p.is_object() && q.is_object()
                                       : (p.is_object() && is_side(q)) || (q.is_object() && is_side(p));
        });
        REQUIRE(edge != good.edges.end());
        CHECK(to_string(edge->kind) == to_string(c.kind));
        const Certificate found = certify(good);
        CHECK_MESSAGE(found.count(Verdict::refuted) == 0, listing(found));
        const auto e = static_cast<std::size_t>(edge - good.edges.begin());
        expect_refuted(good, "edges[" + std::to_string(e) + "].kind",
                       [&](Cell& bad) { bad.edges[e].kind = c.wrong; });
    }
}

TEST_CASE("certify: does not believe stated errors") {
    const Cell good = voronoi_cell(scene_named("figure6"));
    REQUIRE(certify(good).holds());
    const auto spline = static_cast<std::size_t>(
        std::ranges::find(good.edges, CurveKind::Spline, &CellEdge::kind) - good.edges.begin());
    REQUIRE(spline < good.edges.size());
    const std::string edge = "edges[" + std::to_string(spline) + "]";
    expect_refuted(good, "edges[0].error", [](Cell& c) { c.edges[0].error = 1e6; });
    expect_refuted(good, "vertices[1].error", [](Cell& c) { c.vertices[1].error = 1e6; });
    expect_refuted(good, edge, [&](Cell& c) { c.edges[spline].error = 0; });
    expect_refuted(good, "vertices", [](Cell& c) {
        for (CellVertex& v : c.vertices) {
            v.error = 0;
            v.point[2] = std::nextafter(v.point[2], 10);
        }
    });
    expect_refuted(good, "", [](Cell& c) {
        for (CellVertex& v : c.vertices) v.error = 1e6;
        for (CellEdge& e : c.edges) e.error = 1e6;
        for (CellFace& f : c.faces)
            for (TrimmedPatch& p : f.patches)
                for (auto& x : p.surface.points) x[2] *= 1.25;
        c.measures.volume = 12345;
    });
}

TEST_CASE("certify: refutes a bump between sampled points of a spline") {
    Cell cell = voronoi_cell(scene_named("figure6"));
    for (std::size_t i = 0; i < cell.edges.size(); ++i) {
        CellEdge& e = cell.edges[i];
        if (e.kind != CurveKind::Spline) continue;
        // A knot span of a thousandth of the curve with a control point moved: an inner one of a span of its
        // own.
        const std::size_t inner = e.curve.points.size() / 2;
        expect_refuted(cell, "edges[" + std::to_string(i) + "]",
                       [&](Cell& c) { c.edges[i].curve.points[inner][2] += 1e-3; });
        break;
    }
}

TEST_CASE("certify: an edge has two sites, a degenerate vertex lists all") {
    const Cell good = voronoi_cell(scene_named("lattice"));
    REQUIRE(certify(good).holds());
    const auto v = static_cast<std::size_t>(
        std::ranges::find_if(good.vertices,
                             [](const CellVertex& x) {
                                 return x.sites.size() == 4 && std::ranges::all_of(x.sites, &Site::is_object);
                             }) -
        good.vertices.begin());
    REQUIRE(v < good.vertices.size());
    expect_refuted(good, "vertices[" + std::to_string(v) + "].sites", [&](Cell& c) {
        auto& sites = c.vertices[v].sites;
        sites = {sites[0], sites[1], sites[2]};
    });
    const auto e = static_cast<std::size_t>(
        std::ranges::find_if(
            good.edges, [](const CellEdge& x) { return x.sites[0].is_object() && x.sites[1].is_object(); }) -
        good.edges.begin());
    expect_refuted(good, "edges[" + std::to_string(e) + "]",
                   [&](Cell& c) { c.edges[e].sites[1] = c.edges[e].sites[0]; });
    const Certificate c = certify(good);
    const auto tie = std::ranges::find(c.elements, "vertices[" + std::to_string(v) + "]", &Element::where);
    REQUIRE(tie != c.elements.end());
    CHECK(tie->what.find("a tie of 4 sites") != std::string::npos);
}

TEST_CASE("certify: a vertex of nearly parallel bisectors is not moved unseen") {
    Scene scene;  // three balls almost in a row: their bisectors meet at flat angles
    scene.base = Plane{};
    scene.objects = {Sphere{{-0.5, 0, 1}, 0.25}, Sphere{{0, 0.01, 1}, 0.25}, Sphere{{0.5, 0, 1}, 0.25}};
    scene.box = {{-1, -20, 0}, {1, 20, 200}};
    const Cell good = voronoi_cell(scene);
    const Certificate proof = certify(good);
    REQUIRE_MESSAGE(proof.holds(), listing(proof));
    for (std::size_t v = 0; v < good.vertices.size(); ++v) {
        const CellVertex& x = good.vertices[v];
        if (!std::ranges::all_of(x.sites, &Site::is_object)) continue;
        expect_refuted(good, "vertices[" + std::to_string(v) + "]",
                       [&](Cell& c) { c.vertices[v].point.y() += 4 * c.vertices[v].error; });
    }
}

TEST_CASE("certify: the certificate as JSON names every element") {
    Cell cell = voronoi_cell(scene_named("figure2"));
    cell.vertices[3].point.x() += 1e-3;
    const Certificate c = certify(cell);
    std::stringstream out;
    write_certificate(out, c);
    const std::string text = out.str();
    CHECK(text.find("\"holds\":false") != std::string::npos);
    CHECK(text.find("\"where\":\"vertices[3]\",\"verdict\":\"refuted\"") != std::string::npos);
    CHECK(static_cast<std::size_t>(std::ranges::count(text, '\n')) >= c.elements.size());
}

TEST_CASE(
    "certify: balls about balls are proved in units far from one, where samples would miss their faces") {
    for (const std::string name : {"atom_1crn", "figure8"})
        for (const int power : {-100, 100}) {
            CAPTURE(name);
            CAPTURE(power);
            const Certificate c = certify(voronoi_cell(scaled(scene_named(name), std::ldexp(1.0, power))));
            CHECK_MESSAGE(c.holds(), listing(c));
        }
}

TEST_CASE("certify: one more ball is found if it takes a part of the boundary, and only then") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    int taken = 0, left = 0;
    for (const std::string name : {"six_spheres", "figure2", "atom_1crn", "octahedron", "figure9"}) {
        const Cell cell = voronoi_cell(scene_named(name));
        for (int k = 0; k < long_rounds(60); ++k) {
            // About a point of a vertex, an edge or a face, at its clearance but for a small part of it.
            Vec3 p;
            if (k % 3 == 0) {
                p = cell.vertices[rng() % cell.vertices.size()].point;
            } else if (k % 3 == 1) {
                const RationalCurve3& curve = cell.edges[rng() % cell.edges.size()].curve;
                p = curve.evaluate(
                    std::lerp(curve.domain_begin(), curve.domain_end(), 0.5 + 0.4 * unit(rng)));
            } else {
                const RationalPatch& s = cell.faces[rng() % cell.faces.size()].patches[0].surface;
                p = s.evaluate(std::midpoint(s.domain_u[0], s.domain_u[1]),
                               std::midpoint(s.domain_v[0], s.domain_v[1]));
            }
            const check::SceneGeometry geometry(cell.scene);
            const double clearance = geometry.height(p);
            // Straight away from the base, or to any side.
            const Vec3 way =
                (Vec3(unit(rng), unit(rng), unit(rng)) + (k % 4 ? 4.0 : 0.0) * geometry.up(p)).normalized();
            Sphere more;
            more.radius = 0.1 * std::abs(unit(rng)) * clearance;
            more.center = p + (clearance * (1 + unit(rng) * (k % 2 ? 0.1 : 1e-4)) + more.radius) * way;
            Cell claimed = cell;
            claimed.scene.objects.push_back(more);
            const auto last = static_cast<std::uint32_t>(cell.scene.objects.size());
            bool takes_part = false;
            try {
                takes_part = std::ranges::count(voronoi_cell(claimed.scene).neighbors, last) > 0;
            } catch (const InputError&) {
                continue;  // it touches the base
            }
            ++(takes_part ? taken : left);
            CAPTURE(name);
            CAPTURE(k);
            const Certificate c = certify(claimed);
            if (takes_part)
                CHECK(c.count(Verdict::refuted) > 0);
            else
                CHECK_MESSAGE(c.holds(), listing(c));
        }
    }
    CHECK(taken > long_rounds(50));
    CHECK(left > long_rounds(20));
}

TEST_CASE("check: a tube and a ball around a ball are told in few tiles and few parts of integrals") {
    const Cell cell = voronoi_cell(scene_named("ball_tube_plane"));
    // Sixteen tiles for each patch, times two to the effort. Where edges are left open patches are not named.
    std::size_t patches = 0;
    for (const Element& e : certify(cell, {.effort = 2}).elements) {
        if (e.where.find(".patches[") == std::string::npos) continue;
        CAPTURE(e.where);
        CAPTURE(e.what);
        CHECK(e.verdict == Verdict::proved);
        ++patches;
    }
    CHECK(patches > 0);
    // Two parts for each span.
    CHECK(certify(cell, {.effort = 5}).holds());
}

TEST_CASE("forms: products and ranges enclose the values") {
    using namespace check;
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto value = [](const Form& f, double s, double t) {
        double sum = 0;
        for (int i = 0; i <= f.degree_s(); ++i)
            for (int j = 0; j <= f.degree_t(); ++j)
                sum += f.at(i, j) * std::pow(s, i) * std::pow(1 - s, f.degree_s() - i) * std::pow(t, j) *
                       std::pow(1 - t, f.degree_t() - j);
        return sum;
    };
    const auto form = [&](int m, int n) {
        Form f(m, n);
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j) f.set(i, j, unit(rng));
        return f;
    };
    // Those of which the compiler knows the degrees, and one of which it does not.
    constexpr std::array<std::array<int, 4>, 8> degrees{{{2, 1, 1, 2},
                                                         {2, 2, 2, 2},
                                                         {4, 4, 4, 4},
                                                         {2, 0, 2, 0},
                                                         {5, 0, 5, 0},
                                                         {10, 0, 10, 0},
                                                         {8, 0, 2, 0},
                                                         {2, 0, 8, 0}}};
    for (const auto& [m, n, p, q] : degrees) {
        CAPTURE(m);
        const Form a = form(m, n), b = form(p, q), product = a * b, squared = square(a);
        Form sum = form(m + p, n + q);
        const Form before = sum;
        sum.add_product(-1, a, b);
        // What is kept of its size is no less than it is.
        CHECK(sum.norm() >= Form::combination<1>({{{1.0, &sum}}}).norm() * (1 - 1e-12));
        for (int k = 0; k < 100; ++k) {
            const double s = 0.5 + 0.5 * unit(rng), t = 0.5 + 0.5 * unit(rng);
            const double x = value(a, s, t), y = value(b, s, t);
            CHECK(std::abs(value(product, s, t) - x * y) < 1e-14);
            CHECK(std::abs(value(squared, s, t) - x * x) < 1e-14);
            CHECK(std::abs(value(sum, s, t) - (value(before, s, t) - x * y)) < 1e-14);
            CHECK(product.range().lower() <= x * y);
            CHECK(product.range().upper() >= x * y);
        }
    }
}

TEST_CASE("excess: bounds along a curve enclose those of its points") {
    using namespace check;
    for (const std::string name : {"figure6", "figure8", "figure10", "figure9"}) {
        const Cell cell = voronoi_cell(scene_named(name));
        const Space<Interval> space(cell.scene);
        for (const CellEdge& e : cell.edges)
            for (const auto& span : spans<3>(e.curve, Vec3(Vec3::Zero()))) {
                const Net net(span, Vec3::Zero());
                const ExcessAlong along(space, net);
                for (std::uint32_t i = 0; i < cell.scene.objects.size(); ++i) {
                    const Interval bound = along.excess({Site::object(i)});
                    for (const double s : {0.0, 0.125, 0.5, 0.75, 1.0}) {
                        const Vec3 p = e.curve.evaluate(std::lerp(span.begin, span.end, s));
                        const double x = space.excess({Site::object(i)}, to_vector<Interval>(p)).mid();
                        CHECK(x >= bound.lower() - 1e-13);
                        CHECK(x <= bound.upper() + 1e-13);
                    }
                }
            }
    }
}

TEST_CASE("space: slopes within a ball enclose those of its points") {
    using namespace check;
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    for (int k = 0; k < 300; ++k) {
        const std::array<Object, 3> objects{Plane{vector(), vector()}, Sphere{vector(), 0.25},
                                            Cylinder{vector(), vector(), 0.25}};
        const Object& object = objects[static_cast<std::size_t>(k % 3)];
        const Vec3 center = 2 * vector();
        const double radius = 0.5 * std::abs(unit(rng));
        const Slope slope = slope_within(object, center, radius, false);
        Scene scene;
        scene.base = Plane{};
        scene.objects = {object};
        scene.box = {Vec3::Constant(-1e6), Vec3::Constant(1e6)};  // so large that planes cut the base in it
        const Space<Interval> space(scene);
        for (int i = 0; i < 20; ++i) {
            const Vec3 p = center + radius * std::abs(unit(rng)) * vector().normalized();
            const Vec3 n = middle(space.object_gradient(0, to_vector<Interval>(p)));
            CHECK((n - slope.direction).norm() <= slope.turn + 1e-12);
        }
    }
}

TEST_CASE("containment: told exactly") {
    using check::base_contains, check::contains;
    const Cylinder line{{3, -1, 1}, {-2, -2, 1}, 0};
    const Plane sheet{{0, 3, 3}, {0, -1, -2}};
    CHECK(contains(line, Sphere{{1, -3, 2}, 0}));
    CHECK_FALSE(contains(line, Sphere{{1, -3, std::nextafter(2, 3)}, 0}));
    CHECK_FALSE(contains(line, Sphere{{1, -3, 2}, 0x1p-1000}));
    CHECK(contains(Cylinder{line.point, line.axis, 0.5}, Sphere{{1, -3, 2}, 0.5}));
    CHECK(contains(Cylinder{line.point, line.axis, 0.5}, Cylinder{{1, -3, 2}, {4, 4, -2}, 0.5}));
    CHECK_FALSE(contains(Cylinder{line.point, line.axis, 0.5},
                         Cylinder{{1, -3, 2}, {4, 4, std::nextafter(-2, 0)}, 0.25}));
    CHECK(contains(sheet, Cylinder{{0, 3, 3}, {-1, -2, 1}, 0}));
    CHECK_FALSE(contains(sheet, Cylinder{{0, 3, 3}, {-1, -2, 1}, 0x1p-1000}));
    CHECK(contains(sheet, Plane{{7, 5, 2}, {0, 3, 6}}));
    CHECK(contains(Sphere{{0, 0, 0}, 2}, Sphere{{0, 1.5, 0}, 0.5}));
    CHECK_FALSE(contains(Sphere{{0, 0, 0}, 2}, Sphere{{0, std::nextafter(1.5, 2), 0}, 0.5}));
    CHECK_FALSE(contains(sheet, Sphere{{0, 3, 3}, 1}));

    const Plane floor{{0, 0, 0}, {0, 0, 3}};
    CHECK(base_contains(floor, Sphere{{2, 3, -1.75}, 1.75}));
    CHECK_FALSE(base_contains(floor, Sphere{{2, 3, -1.75}, std::nextafter(1.75, 2)}));
    CHECK_FALSE(base_contains(floor, Sphere{{2, 3, 1.75}, 1.75}));
    CHECK(base_contains(floor, Cylinder{{2, 3, -1}, {1, 5, 0}, 1}));
    CHECK_FALSE(base_contains(floor, Cylinder{{2, 3, -1}, {1, 5, 0x1p-1000}, 1}));
    CHECK(base_contains(floor, Plane{{2, 3, -1}, {0, 0, -1}}));
    CHECK(base_contains(Sphere{{0, 0, 0}, 2}, Sphere{{0, 1.5, 0}, 0.5}));
}

TEST_CASE("site tree: finds what is near") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    Scene scene;
    scene.base = Plane{};
    for (int i = 0; i < 300; ++i)
        scene.objects.push_back(Sphere{{unit(rng), unit(rng), unit(rng)}, 0.2 * std::abs(unit(rng))});
    const auto direction = [&] { return Vec3(unit(rng), unit(rng), unit(rng)); };
    for (int i = 0; i < 60; ++i) {
        scene.objects.push_back(
            Cylinder{{unit(rng), unit(rng), unit(rng)}, direction(), 0.1 * std::abs(unit(rng))});
        scene.objects.push_back(Plane{{unit(rng), unit(rng), unit(rng)}, direction()});
    }
    const auto distance = [](const Object& o, const Vec3& p) {
        if (const auto* s = std::get_if<Sphere>(&o)) return (p - s->center).norm() - s->radius;
        if (const auto* c = std::get_if<Cylinder>(&o))
            return (p - c->point).cross(c->axis.normalized()).norm() - c->radius;
        const auto& w = std::get<Plane>(o);
        return std::abs(w.normal.normalized().dot(p - w.point));
    };
    const check::SiteTree tree(scene);
    std::size_t most = 0;
    for (int k = 0; k < 100; ++k) {
        const Vec3 p(unit(rng), unit(rng), unit(rng));
        const double reach = unit(rng);
        std::vector<std::uint32_t> found;
        tree.near(p, reach, found);
        std::ranges::sort(found);
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            const double apart = distance(scene.objects[i], p) - reach;
            const bool is_found = std::ranges::binary_search(found, i);
            if (apart < 0) CHECK(is_found);
            if (is_found) CHECK(apart < 1e-9);
        }
        most = std::max(most, found.size());
    }
    CHECK(most > 0);
}

TEST_CASE("krawczyk: encloses the common point of bisectors in either arithmetic") {
    using namespace check;
    Scene scene;
    scene.base = Plane{};
    scene.objects = {Sphere{{-0.5, 0, 1}, 0.25}, Sphere{{0.5, 0.125, 1}, 0.25}, Sphere{{0, 1, 1}, 0.25}};
    scene.box = {{-1, -1, 0}, {1, 1, 2}};
    const std::array<Condition, 3> three{Condition{Site::object(0)}, {Site::object(1)}, {Site::object(2)}};
    const Space<Interval> space(scene);
    const Space<Wide> wide(scene);
    // Equal heights: the foot is the centers' circumcenter. |f - a|^2 = |f - b|^2 gives x + y / 8 = 1 / 128,
    // and |f - a|^2 = |f - c|^2 gives x + 2 y = 3 / 4.
    const double y = (0.75 - 1.0 / 128) / 1.875, x = 0.75 - 2 * y;
    const double z = ((x + 0.5) * (x + 0.5) + y * y + 0.9375) / 2.5;
    const auto coarse = enclose(space, three, Vec3(x + 1e-5, y, z - 1e-5), 0.1, 4);
    const auto fine = enclose(wide, three, Vec3(x + 1e-5, y, z - 1e-5), 0.1, 16);
    REQUIRE(coarse);
    REQUIRE(fine);
    CHECK(coarse->distance({x, y, z}).upper() < 1e-8);
    CHECK(upper_bound(fine->offset[0] - fine->offset[0].mid()) < 1e-50);
    const Vector<Wide> point = fine->box();
    const Vector<Interval> rounded{point[0].enclosure(), point[1].enclosure(), point[2].enclosure()};
    for (const Condition& c : three) CHECK(space.excess(c, rounded).contains(0.0));
    // Two conditions twice do not fix a point.
    CHECK_FALSE(enclose(space, {three[0], three[1], three[1]}, Vec3(x, y, z), 0.1, 4));
}

}  // namespace vcell
