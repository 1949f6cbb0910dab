// Cells with cylinders: lifted patches, conics by name, splines with their stated errors, measures.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "../../core/errors.hpp"
#include "../../core/numbers/wide.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "cell_checks.hpp"
#include "test_support.hpp"

namespace vcell::cell_mixed_test {
using std::numbers::pi;

namespace {

Scene scene_of(std::vector<Object> objects, double height = 2) {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = std::move(objects);
    scene.box = {{-1, -1, 0}, {1, 1, height}};
    return scene;
}

std::vector<const CellEdge*> edges_between(const Cell& cell, Site a, Site b) {
    std::vector<const CellEdge*> found;
    for (const CellEdge& e : cell.edges)
        if ((e.sites[0] == a && e.sites[1] == b) || (e.sites[0] == b && e.sites[1] == a)) found.push_back(&e);
    return found;
}

void check_edges(const Cell& cell, Site a, Site b, CurveKind kind) {
    const auto edges = edges_between(cell, a, b);
    CHECK_FALSE(edges.empty());
    for (const CellEdge* e : edges) CHECK(to_string(e->kind) == to_string(kind));
}

const CellFace& face_of(const Cell& cell, Site site) {
    for (const CellFace& f : cell.faces)
        if (f.site == site) return f;
    FAIL("no face");
    return cell.faces.front();
}

// Against the midpoint rule, to its accuracy.
void check_measures(const Cell& cell, double tolerance) {
    const PlaneBaseProblem problem = plane_base_problem(cell.scene);
    const testing::SampledMeasures sampled = testing::sample_measures(problem, 400);
    const Measures& m = cell.measures;
    CHECK(m.volume == doctest::Approx(sampled.volume).epsilon(3e-3));
    CHECK(m.area == doctest::Approx(sampled.area).epsilon(6e-3));
    CHECK(m.min_clearance <= sampled.min_clearance + 1e-12);
    // Where a side of the box leans over the base, it comes down to it next to a sample.
    CHECK(m.min_clearance >= (1 - 5e-2) * sampled.min_clearance - sampled.min_within);
    CHECK(m.max_clearance >= sampled.max_clearance - 1e-12);
    CHECK(m.max_clearance == doctest::Approx(sampled.max_clearance).epsilon(3e-2));
    double off = tolerance;  // arcs by the tolerance, or by the vertices they end at
    for (const CellVertex& v : cell.vertices) off = std::max(off, v.error);
    CHECK(m.volume_error < 1e-11 + off * m.volume);
    CHECK(m.area_error < 1e-10 + 100 * off * (1 + m.area));
}

// A height with digits to spare, from the forms alone.
Wide height_of(const FormFamily& family, FormId form, const Eigen::Vector2d& p) {
    const Wide x(p.x()), y(p.y());
    if (!family.is_circular(form)) {
        const CylinderForm& f = family.cylinder(form);
        const auto [C, beta] = cylinder_terms(f, x, y);
        return C / (beta + sqrt(square(beta) + Wide(f.az) * Wide(f.az) * C));
    }
    const ExactForm f = family.exact(form);
    const auto wide = [](const Exact& a) { return Wide(a.enclosure()); };
    return (wide(f.K) * (x * x + y * y) + wide(f.A) * x + wide(f.B) * y + wide(f.C)) / wide(f.W);
}

// The true arc crosses the normal of the chart curve, shown by opposite signs on both sides of it, within the
// stated error of the spline's points.
void check_splines(const Cell& cell) {
    const PlaneBaseProblem problem = plane_base_problem(cell.scene);
    const auto form_of = [&](Site site) {
        for (std::uint32_t i = 0; i < problem.family.size(); ++i)
            for (const Site s : problem.sites[FormId{i}])
                if (s == site) return FormId{i};
        return FormId{};
    };
    for (const CellEdge& e : cell.edges) {
        if (e.kind != CurveKind::Spline) continue;
        const FormId left = form_of(e.sites[0]), right = form_of(e.sites[1]);
        const double begin = e.curve.domain_begin(), end = e.curve.domain_end();
        const int places = rounds() > 1 ? 200 : 50;
        for (int k = 0; k <= places; ++k) {
            const auto [world, world_tangent] =
                e.curve.evaluate_with_derivative(begin + (end - begin) * k / places);
            const Vec3 p = problem.frame.to_canonical(world),
                       tangent = problem.frame.rotation * world_tangent;
            const Eigen::Vector2d at = p.head<2>(), along = tangent.head<2>().normalized(),
                                  across(-along.y(), along.x());
            const auto difference = [&](double offset) {
                const Eigen::Vector2d q = at + offset * across;
                return height_of(problem.family, left, q) - height_of(problem.family, right, q);
            };
            const double reach = e.error + 1e-14;
            const auto before = difference(-reach).sign(), after = difference(reach).sign();
            REQUIRE(before.has_value());
            REQUIRE(after.has_value());
            CHECK(*before * *after == Sign::Negative);
            // Halve to the arc's point, to a part of the rounding allowed for, and compare in space.
            double low = -reach, high = reach;
            for (int i = 0; i < 50 && high - low > 1e-16; ++i) {
                const double middle = 0.5 * (low + high);
                (difference(middle).sign() == before ? low : high) = middle;
            }
            const Eigen::Vector2d q = at + low * across;
            const double z = height_of(problem.family, left, q).enclosure().mid();
            CHECK((p - Vec3(q.x(), q.y(), z)).norm() <= e.error + 1e-14);
        }
    }
}

void check(const Cell& cell, double tolerance) {
    testing::check_geometry(cell);
    check_measures(cell, tolerance);
    for (const CellEdge& e : cell.edges)
        CHECK(e.error <= 1.001 * tolerance + (e.kind == CurveKind::Spline ? 0 : 1e-10));
}

}  // namespace

TEST_CASE("mixed cell: a horizontal cylinder's bisector is a parabolic cylinder, to closed forms") {
    // Axis along y at height 1, radius 1/2: height (x^2 + 3/4) / 3, meets the lid 0.4 at x^2 = 0.45.
    const Scene scene = scene_of({Cylinder{{0, 0, 1}, {0, 1, 0}, 0.5}}, 0.4);
    const Cell cell = voronoi_cell(scene);
    check(cell, 1e-15);
    const CellFace& face = face_of(cell, Site::object(0));
    CHECK(face.bisector == "parabolic cylinder");
    check_edges(cell, Site::object(0), Site::box_side(5), CurveKind::Line);
    check_edges(cell, Site::object(0), Site::box_side(2), CurveKind::Parabola);
    const double a = std::sqrt(0.45), slope = 2 * a / 3;
    // y = x^2 / 3 has the arc length (w / 4)(s sqrt(1 + s^2) + asinh s) on [0, a], s = 2 a / w, w = 3.
    const double arc = 0.75 * (slope * std::sqrt(1 + slope * slope) + std::asinh(slope));
    CHECK(std::abs(cell.measures.area - 4 * arc) <= cell.measures.area_error);
    CHECK(cell.measures.area_error < 1e-11);
    const double volume = 2 * 2 * ((a * a * a / 3 + 0.75 * a) / 3 + (1 - a) * 0.4);
    CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error);
    CHECK(cell.measures.volume_error < 1e-12);
    CHECK(cell.measures.min_clearance == doctest::Approx(0.25).epsilon(1e-14));
    CHECK(edges_between(cell, Site::object(0), Site::box_side(2))[0]->length ==
          doctest::Approx(2 * arc).epsilon(1e-13));
}

TEST_CASE(
    "mixed cell: the least clearance beside a line next to the base is half its height, within the error") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<> angle(0, pi), shift(-0.5, 0.5);
    for (int i = 0; i < 10; ++i) {
        const double a = angle(rng), height = std::ldexp(1 + shift(rng), -8 - i);
        const Cell cell = voronoi_cell(
            scene_of({Cylinder{{shift(rng), shift(rng), height}, {std::cos(a), std::sin(a), 0}, 0},
                      Plane{{0, 0, 0.3}, {0, 0, 1}}}));
        const Measures& m = cell.measures;
        CAPTURE(height);
        CHECK(std::abs(m.min_clearance - 0.5 * height) <= m.min_clearance_error);
        CHECK(m.min_clearance_error < 1e-11);
    }
}

TEST_CASE("mixed cell: an upright cylinder beside the region has a circular cone") {
    // Height: distance from the axis (-2, 0) less the radius; the lid cuts it in a circle about the axis.
    const Scene scene = scene_of({Cylinder{{-2, 0, 5}, {0, 0, -3}, 0.5}}, 1.2);
    const Cell cell = voronoi_cell(scene);
    check(cell, 1e-15);
    CHECK(face_of(cell, Site::object(0)).bisector == "circular cone");
    check_edges(cell, Site::object(0), Site::box_side(5), CurveKind::Circle);
    check_edges(cell, Site::object(0), Site::box_side(0), CurveKind::Hyperbola);
    for (const CellEdge* e : edges_between(cell, Site::object(0), Site::box_side(5)))
        for (const double t : {0.0, 0.3, 0.9}) {
            const Vec3 p = e->curve.evaluate(t);
            CHECK(std::hypot(p.x() + 2, p.y()) == doctest::Approx(1.7).epsilon(1e-14));
            CHECK(p.z() == doctest::Approx(1.2).epsilon(1e-14));
        }
}

TEST_CASE("mixed cell: the edge on a side next to an axis, all but two lines") {
    const double beside = 1e-6;
    const Scene scene = scene_of({Cylinder{{1 + beside, 0.25, 0}, {-8.7e-6, -3.9e-6, 1}, 0}}, 2);
    const Cell cell = voronoi_cell(scene);
    const auto edges = edges_between(cell, Site::object(0), Site::box_side(1));
    REQUIRE(edges.size() == 1);
    CHECK(edges[0]->kind == CurveKind::Hyperbola);
    // Its height is the distance from the axis's foot, but for the axis's lean and distance.
    CHECK(std::abs(edges[0]->length - std::numbers::sqrt2 * (1.25 + 0.75)) <= 1e-4);
    CHECK(edges[0]->length_error < 1e-6);
}

TEST_CASE("mixed cell: beside the tip of a cone integrals end with a bound") {
    // The line meets the base just beyond the region's side.
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = {Cylinder{{-1.8823237457685806, -1.0495716582220769, 0.6164977389338517},
                              {-0.0015416368939749044, -0.8397210799108941, -0.5430157744568468},
                              0}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    const Cell cell = voronoi_cell(scene);
    REQUIRE(cell.faces.size() == 2);
    for (const CellFace& face : cell.faces) CHECK(face.area_error < 1e-3);
    CHECK(cell.measures.volume_error < 1e-3);
}

TEST_CASE("mixed cell: a tip on the region's side but for rounding is refused, not taken for a vertex") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {-0.27285974738253327, -0.14050574738063482, -0.9517382482654301}};
    scene.objects = {Cylinder{{2.0000000000000004, 1.3660254037844382, 1.339763025238506e-15},
                              {-3.6357659319872473e-16, 6.492827250843478e-16, 1.0000000000000013},
                              0}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    CHECK_THROWS_AS(voronoi_cell(scene), UndecidedError);
}

TEST_CASE("mixed cell: plane sections of an elliptic cone are named by exact signs") {
    // Axis (3, 0, 4) / 5 through the apex's foot; a plane of slope g along x has the eccentricity |4 g + 3|
    // / 5.
    struct Case {
        double slope;
        CurveKind kind;
    };
    for (const auto& [slope, kind] :
         {Case{0.25, CurveKind::Ellipse}, Case{0.5, CurveKind::Parabola},
          Case{0.5 + 0x1p-40, CurveKind::Hyperbola}, Case{0.5 - 0x1p-40, CurveKind::Ellipse},
          Case{1, CurveKind::Hyperbola}}) {
        CAPTURE(slope);
        // A plane whose bisector with z = 0 has the slope `slope` along x: at twice its angle.
        const double c = (1 - slope * slope), s = 2 * slope;
        const Scene scene =
            scene_of({Cylinder{{-3, 0, 0}, {3, 0, 4}, 0.25}, Plane{{-1.44 / slope, 0, 0}, {s, 0, -c}}}, 4);
        const Cell cell = voronoi_cell(scene);
        check(cell, 1e-15);
        CHECK(face_of(cell, Site::object(0)).bisector == "elliptic cone");
        check_edges(cell, Site::object(0), Site::object(1), kind);
    }
}

TEST_CASE("mixed cell: conics and splines of all pairs stay within what they state") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
        for (int round = 0; round < rounds(); ++round) {
            Scene scene =
                scene_of({Sphere{{0.6 * unit(rng), 0.6 * unit(rng), 0.7}, 0.2},
                          Cylinder{{0, 0.5 * unit(rng), 0.9}, {1, 0.3 * unit(rng), 0.3 * unit(rng)}, 0.1},
                          Cylinder{{0.5 * unit(rng), 0, 0.8}, {0.3 * unit(rng), 1, 0.3 * unit(rng)}, 0.15},
                          Cylinder{{-2.5, 0.5 * unit(rng), 0}, {0.5, 0.2, 1}, 0.1},
                          Plane{{0, 0, 0.9}, {0.2 * unit(rng), 0.2 * unit(rng), -1}}},
                         1.5);
            scene.tolerance = tolerance;
            CAPTURE(round);
            const Cell cell = voronoi_cell(scene);
            check(cell, tolerance);
            check_splines(cell);
        }
    }
}

TEST_CASE("mixed cell: pairs of cylinders in special position meet in lines and conics") {
    const Site first = Site::object(0), second = Site::object(1);
    SUBCASE("parallel axes of one height and radius: a straight ridge") {
        const Cell cell = voronoi_cell(
            scene_of({Cylinder{{-0.5, 0, 1}, {0, 1, 0}, 0.2}, Cylinder{{0.5, 0, 1}, {0, 2, 0}, 0.2}}));
        check(cell, 1e-15);
        check_edges(cell, first, second, CurveKind::Line);
    }
    SUBCASE("parallel tilted axes of one radius: the plane half-way cuts both cones in the same hyperbola") {
        const Cell cell = voronoi_cell(
            scene_of({Cylinder{{-0.5, 0, 2}, {0, 1, 1}, 0.2}, Cylinder{{0.5, 0, 2}, {0, -1, -1}, 0.2}}));
        check(cell, 1e-15);
        check_edges(cell, first, second, CurveKind::Hyperbola);
    }
    SUBCASE("parallel tilted axes of two radii") {
        const Cell cell = voronoi_cell(
            scene_of({Cylinder{{-0.5, 0.1, 2}, {0, 1, 1}, 0.2}, Cylinder{{0.5, 0, 2}, {0, 1, 1}, 0.3}}));
        check(cell, 1e-15);
        for (const CellEdge* e : edges_between(cell, first, second)) CHECK(e->kind != CurveKind::Spline);
    }
    SUBCASE("crossing axes of one radius: planes half-way") {
        const Cell cell = voronoi_cell(
            scene_of({Cylinder{{0, 0, 1}, {1, 0, 0}, 0.2}, Cylinder{{0, 0, 1}, {0, 1, 0}, 0.2}}));
        check(cell, 1e-15);
        CHECK(edges_between(cell, first, second).size() >= 4);
        check_edges(cell, first, second, CurveKind::Parabola);
    }
}

TEST_CASE("mixed cell: a leaning base, a steep cylinder behind and one over the region") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 3; ++round) {
        Scene scene = scene_of({Cylinder{{0, 0.2 * unit(rng), 0.8}, {1, unit(rng), 0.2 * unit(rng)}, 0.1},
                                Cylinder{{2.6, 0.3, 0}, {0.3, 0.1, 1}, 0.2}, Sphere{{-0.4, -0.4, 0.8}, 0.2}});
        // A side that leans by less comes down to the base between two samples.
        const auto lean = [&] {
            const double x = unit(rng);
            return std::copysign(0.04, x) + 0.06 * x;
        };
        scene.base = Plane{{0, 0, 0.1}, {lean(), lean(), 1}};
        CAPTURE(round);
        const Cell cell = voronoi_cell(scene);
        check(cell, 1e-7 * scene.box.diagonal());
        check_splines(cell);
    }
}

}  // namespace vcell::cell_mixed_test
