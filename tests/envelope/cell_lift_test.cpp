// Lifting alone: diagrams made by hand, cells with closed forms.
#include <doctest/doctest.h>

#include <numbers>

#include "../../envelope/lift/lift.hpp"
#include "cell_checks.hpp"

namespace vcell::cell_lift_test {
using std::numbers::pi;

namespace {

// The rectangle's rim around one face; labels are filled in by finish().
struct DiagramBuilder {
    MinimizationDiagram diagram;
    FaceId ground;
    const PlaneBaseProblem& problem;

    DiagramBuilder(const PlaneBaseProblem& p, FormId ground_form) : problem(p) {
        diagram.forms = p.family.forms;
        Dcel& dcel = diagram.dcel;
        for (const RegionSide& side : p.region) diagram.region.sides.push_back({side.a, side.b, side.c});
        diagram.face_forms.push_back({});
        for (const Eigen::Vector2d& corner : p.corners) {
            dcel.add_vertex();
            diagram.vertices.push_back(
                {corner, 0, p.family.forms[ground_form](corner.x(), corner.y()), 1e-16});
        }
        const auto n = static_cast<std::uint32_t>(p.corners.size());
        for (std::uint32_t i = 0; i < n; ++i) {
            dcel.add_edge({i}, {(i + 1) % n});
            diagram.edges.push_back({ground_form, {}, i});
        }
        for (std::uint32_t i = 0; i < n; ++i) {
            const EdgeId e{i}, f{(i + 1) % n};
            dcel.link(Dcel::half_edge(e), Dcel::half_edge(f));
            dcel.link(Dcel::half_edge(f, 1), Dcel::half_edge(e, 1));
        }
        ground = add_face(ground_form);
        dcel.add_outer_ccb(ground, Dcel::half_edge(EdgeId{0}));
        dcel.add_inner_ccb(Dcel::unbounded_face(), Dcel::half_edge(EdgeId{0}, 1));
    }
    FaceId add_face(FormId form) {
        diagram.face_forms.push_back(form);
        return diagram.dcel.add_face();
    }
    // A closed edge around an island of `inside` in the ground; half-edge 2e has the island on its left.
    void add_island(FormId inside, FormId outside) {
        const EdgeId e = diagram.dcel.add_edge({}, {});
        diagram.edges.push_back({inside, outside});
        diagram.dcel.add_outer_ccb(add_face(inside), Dcel::half_edge(e));
        diagram.dcel.add_inner_ccb(ground, Dcel::half_edge(e, 1));
    }
    Cell lift(const Scene& scene) {
        const auto n = static_cast<std::uint32_t>(problem.corners.size());
        diagram.vertex_offsets_ = diagram.edge_offsets_ = diagram.side_offsets_ = {0};
        for (std::uint32_t v = 0; v < n; ++v) {
            diagram.vertex_labels_.push_back(diagram.edges[EdgeId{v}].left);
            diagram.vertex_offsets_.push_back(v + 1);
            diagram.vertex_sides_.push_back((v + n - 1) % n);
            diagram.vertex_sides_.push_back(v);
            diagram.side_offsets_.push_back(2 * v + 2);
        }
        for (const MinimizationDiagram::Edge& edge : diagram.edges) {
            diagram.edge_labels_.push_back(edge.left);
            if (edge.right.valid()) diagram.edge_labels_.push_back(edge.right);
            diagram.edge_offsets_.push_back(static_cast<std::uint32_t>(diagram.edge_labels_.size()));
        }
        REQUIRE_FALSE(diagram.dcel.find_defect());
        Cell cell = lift_over_region(problem, diagram, 1e-7, true).cell;
        cell.scene = scene;
        return cell;
    }
};

Scene box_scene(const Vec3& min, const Vec3& max, std::vector<Object> objects = {}) {
    Scene scene;
    scene.base = Plane{{0, 0, min.z()}, {0, 0, 1}};
    scene.objects = std::move(objects);
    scene.box = {min, max};
    return scene;
}

}  // namespace

TEST_CASE("lift: without objects the cell is the box above the base") {
    const Scene scene = box_scene({-1, -2, 0}, {3, 2, 0.5});
    const PlaneBaseProblem problem = plane_base_problem(scene);
    const Cell cell = DiagramBuilder(problem, FormId{0}).lift(scene);
    testing::check_geometry(cell);
    REQUIRE(cell.faces.size() == 1);
    CHECK(cell.faces[0].site == Site::box_side(5));
    CHECK(cell.faces[0].bisector == "box");
    CHECK(cell.faces[0].area == 16);
    CHECK(cell.neighbors.empty());
    for (const CellVertex& v : cell.vertices) CHECK(v.sites.size() == 3);
    for (const CellEdge& e : cell.edges) {
        CHECK(e.kind == CurveKind::Line);
        CHECK(e.curve.degree == 1);
        CHECK(e.length == doctest::Approx(4).epsilon(1e-15));
        CHECK(e.sites[0] == Site::box_side(5));
    }
    const Measures& m = cell.measures;
    CHECK(std::abs(m.volume - 8) <= m.volume_error);
    CHECK(m.volume_error < 1e-12);
    CHECK(m.area == 0);
    CHECK(m.box_area == doctest::Approx(16 + 4 * 4 * 0.5).epsilon(1e-15));
    CHECK(m.base_area == 16);
    CHECK(m.body_volume == 0);
    CHECK(m.min_clearance == 0.5);
    CHECK(m.max_clearance == 0.5);
    CHECK(m.touches_box);
}

TEST_CASE("lift: one sphere under a lid is a paraboloid cap, to closed forms") {
    // Height (|p|^2 + z^2 - r^2) / (2 (z + r)) with w = 3 and apex 1/4; it meets the lid on |p|^2 = R2.
    const Scene scene = box_scene({-1, -1, 0}, {1, 1, 0.4}, {Sphere{{0.1, 0.2, 1}, 0.5}});
    const PlaneBaseProblem problem = plane_base_problem(scene);
    DiagramBuilder builder(problem, FormId{1});
    builder.add_island(FormId{0}, FormId{1});
    const Cell cell = builder.lift(scene);
    testing::check_geometry(cell);
    const double R2 = 0.4 * 3 - 0.75, w = 3;
    REQUIRE(cell.edges.size() == 5);
    const CellEdge& circle = cell.edges[4];
    CHECK(circle.kind == CurveKind::Circle);
    CHECK(circle.vertices.empty());
    CHECK(circle.sites == std::array{Site::object(0), Site::box_side(5)});
    CHECK(circle.curve.points.size() == 9);
    CHECK(circle.length == doctest::Approx(2 * pi * std::sqrt(R2)).epsilon(1e-14));
    for (const double t : {0.0, 0.1, 0.25, 0.6})
        CHECK(circle.curve.evaluate(t).z() == doctest::Approx(0.4).epsilon(1e-15));

    REQUIRE(cell.faces.size() == 2);
    CHECK(cell.faces[0].patches[0].loops.size() == 2);
    const CellFace& cap = cell.faces[1];
    CHECK(cap.bisector == "paraboloid");
    CHECK(cap.patches[0].surface.degree_u == 2);
    CHECK(cap.patches[0].surface.domain_u[0] == doctest::Approx(0.1 - std::sqrt(R2)).epsilon(1e-15));
    CHECK(cap.patches[0].surface.domain_v[1] == doctest::Approx(0.2 + std::sqrt(R2)).epsilon(1e-15));
    const double area = pi * w * w / 6 * (std::pow(1 + 4 * R2 / (w * w), 1.5) - 1);
    const double under_cap = pi / w * (R2 * R2 / 2 + 0.75 * R2);
    const Measures& m = cell.measures;
    CHECK(std::abs(m.area - area) <= m.area_error);
    CHECK(m.area_error < 1e-12);
    CHECK(cap.area == doctest::Approx(area).epsilon(1e-14));
    CHECK(std::abs(m.volume - (under_cap + (4 - pi * R2) * 0.4)) <= m.volume_error);
    CHECK(m.volume_error < 1e-12);
    CHECK(m.box_area == doctest::Approx(4 - pi * R2 + 8 * 0.4).epsilon(1e-14));
    CHECK(m.min_clearance == doctest::Approx(0.25).epsilon(1e-15));
    CHECK(m.max_clearance == doctest::Approx(0.4).epsilon(1e-15));
    CHECK(cell.neighbors == std::vector<std::uint32_t>{0});
}

TEST_CASE("lift: a steep paraboloid over the whole region, against a one-dimensional integral") {
    // w from 4e-3 to 6: the integrand's singularities come close to the rim of the region.
    for (const double z : {1e-3, 0.05, 0.4, 1.5}) {
        const double r = 1e-4, w = 2 * (z + r);
        const double top = 2 / w + 1;
        const Scene scene = box_scene({-1, -1, 0}, {1, 1, top + 1}, {Sphere{{0, 0, z}, r}});
        const PlaneBaseProblem problem = plane_base_problem(scene);
        const Cell cell = DiagramBuilder(problem, FormId{0}).lift(scene);
        REQUIRE(cell.faces.size() == 1);
        for (const CellEdge& e : cell.edges) CHECK(e.kind == CurveKind::Parabola);
        // Eight triangles: polar coordinates up to 1 / cos(phi), phi in [0, pi/4], Simpson's rule.
        const int n = 2000;
        double area = 0;
        for (int i = 0; i <= n; ++i) {
            const double phi = pi / 4 * i / n, s = 4 / (w * w * std::cos(phi) * std::cos(phi));
            const double radial = w * w / 12 * (std::pow(1 + s, 1.5) - 1);
            area += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * radial;
        }
        area *= 8 * pi / 4 / n / 3;
        const double volume = (4 * 2.0 / 3 + 4 * (z * z - r * r)) / w;
        CAPTURE(z);
        CHECK(cell.measures.area == doctest::Approx(area).epsilon(1e-12));
        CHECK(cell.measures.area_error < 1e-12 * area);
        CHECK(std::abs(cell.measures.volume - volume) <= cell.measures.volume_error);
        CHECK(cell.measures.volume_error < 1e-12 * volume);
        CHECK(cell.measures.min_clearance == doctest::Approx((z - r) / 2).epsilon(1e-13));
        // A side's parabola z = (x^2 + const) / w over [-1, 1], slope 2x/w.
        const double k = 2 / w, length = std::sqrt(1 + k * k) + std::asinh(k) / k;
        for (const CellEdge& e : cell.edges) CHECK(e.length == doctest::Approx(length).epsilon(1e-13));
    }
}

TEST_CASE("lift: a tilted lid cuts an ellipse, named by exact coefficients") {
    // The object plane's bisector is tilted however small the tilt: circle only when it is level.
    for (const double tilt : {0.0, 1e-200, 1e-12, 0.05}) {
        const Scene scene =
            box_scene({-1, -1, 0}, {1, 1, 5}, {Sphere{{0, 0, 1}, 0.5}, Plane{{0, 0, 0.8}, {tilt, 0, -1}}});
        const PlaneBaseProblem problem = plane_base_problem(scene);
        DiagramBuilder builder(problem, FormId{1});
        builder.add_island(FormId{0}, FormId{1});
        const Cell cell = builder.lift(scene);
        CAPTURE(tilt);
        testing::check_geometry(cell);
        CHECK(cell.edges[4].kind == (tilt == 0 ? CurveKind::Circle : CurveKind::Ellipse));
        CHECK(cell.faces[0].bisector == "plane");
        CHECK(cell.neighbors == std::vector<std::uint32_t>{1, 0});
    }
}

}  // namespace vcell::cell_lift_test
