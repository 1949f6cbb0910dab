// What is decided about a scene as it comes in: its unit, its motion, and the mode of the processor.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "../../core/errors.hpp"
#include "../../core/platform.hpp"
#include "../../core/solver/roots/solver.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../primitives/objects/decided_scene.hpp"
#include "../test_support.hpp"

namespace vcell::decided_scene_test {
namespace {

Scene scaled(Scene scene, double s) {
    const auto scale_object = [s](Object& o) {
        if (auto* sphere = std::get_if<Sphere>(&o)) {
            sphere->center *= s;
            sphere->radius *= s;
        } else if (auto* plane = std::get_if<Plane>(&o)) {
            plane->point *= s;
        } else if (auto* cylinder = std::get_if<Cylinder>(&o)) {
            cylinder->point *= s;
            cylinder->radius *= s;
        }
    };
    scale_object(scene.base);
    for (Object& o : scene.objects) scale_object(o);
    scene.box.min *= s;
    scene.box.max *= s;
    return scene;
}

// A scene for each kind of base, with all kinds of objects.
std::vector<Scene> scenes_of_all_bases() {
    std::vector<Scene> scenes;
    const std::vector<Object> objects{Sphere{{0.5, 0.25, 1.25}, 0.25}, Sphere{{-0.75, 0.5, 1}, 0.125},
                                      Plane{{0, 0, 1.75}, {0.125, 0.25, -1}},
                                      Cylinder{{0, -1.25, 1.5}, {1, 0.125, 0.0625}, 0.25}};
    for (const Object& base :
         std::vector<Object>{Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{0, 0, 0}, {0.0625, 0.03125, 1}},
                             Sphere{{0, 0, 0}, 0.25}, Cylinder{{0, 0, 0}, {1, 0, 0.0625}, 0.125}}) {
        Scene scene;
        scene.base = base;
        scene.objects = objects;
        scene.box = {{-2, -2, -1}, {2, 2, 2}};
        scenes.push_back(scene);
    }
    return scenes;
}

// Bit for bit: not-a-numbers agree, too.
bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void check_scaled(const Cell& one, const Cell& other, double s) {
    REQUIRE(one.vertices.size() == other.vertices.size());
    REQUIRE(one.edges.size() == other.edges.size());
    REQUIRE(one.faces.size() == other.faces.size());
    for (std::size_t i = 0; i < one.vertices.size(); ++i) {
        const CellVertex &a = one.vertices[i], &b = other.vertices[i];
        CHECK(s * a.point == b.point);
        CHECK(s * a.radius == b.radius);
        CHECK(s * a.error == b.error);
        CHECK(std::vector(a.sites.begin(), a.sites.end()) == std::vector(b.sites.begin(), b.sites.end()));
    }
    for (std::size_t i = 0; i < one.edges.size(); ++i) {
        const CellEdge &a = one.edges[i], &b = other.edges[i];
        CHECK(a.kind == b.kind);
        CHECK(s * a.length == b.length);
        CHECK(s * a.error == b.error);
        REQUIRE(a.curve.points.size() == b.curve.points.size());
        for (std::size_t k = 0; k < a.curve.points.size(); ++k) {
            CHECK(s * a.curve.points[k].head<3>() == b.curve.points[k].head<3>());
            CHECK(a.curve.points[k].w() == b.curve.points[k].w());
        }
    }
    for (std::size_t i = 0; i < one.faces.size(); ++i) {
        CHECK(one.faces[i].site == other.faces[i].site);
        CHECK(one.faces[i].bisector == other.faces[i].bisector);
        CHECK(s * s * one.faces[i].area == other.faces[i].area);
    }
    CHECK(one.neighbors == other.neighbors);
    CHECK(same(s * s * s * one.measures.volume, other.measures.volume));
    CHECK(same(s * s * s * one.measures.volume_error, other.measures.volume_error));
    CHECK(same(s * one.measures.max_clearance, other.measures.max_clearance));
    CHECK(s * one.report.moved == other.report.moved);
}

std::map<std::size_t, int> vertices_by_sites(const Cell& cell) {
    std::map<std::size_t, int> counts;
    for (const CellVertex& v : cell.vertices) ++counts[v.sites.size()];
    return counts;
}

// A lattice over a plane in a box around all of it: its inner vertices.
int vertices_of_four(const Cell& cell) {
    int count = 0;
    for (const CellVertex& v : cell.vertices) {
        bool inside = v.sites.size() == 4;
        for (const Site site : v.sites) inside = inside && site.is_object();
        count += inside;
    }
    return count;
}

Scene between(double unit) {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.125 * unit};
    scene.objects = {Sphere{{0, 0, 2.5 * unit}, 2 * unit}, Sphere{{0, 0, -2.5 * unit}, 2 * unit}};
    scene.box = {Vec3::Constant(-unit), Vec3::Constant(unit)};
    return scene;
}

}  // namespace

TEST_CASE("decided scene: the unit is a power of two, about the box's size, and exact") {
    const Scene scene = scenes_of_all_bases()[3];
    const DecidedScene one = decide(scene);
    CHECK(one.unit == 4);
    CHECK(one.moved == 0);
    for (const int k : {-190, -3, 1, 190}) {
        const DecidedScene other = decide(scaled(scene, std::ldexp(1.0, k)));
        CHECK(other.unit == std::ldexp(one.unit, k));
        CHECK(other.scene.box.max == one.scene.box.max);
        CHECK(std::get<Cylinder>(other.scene.base).axis == std::get<Cylinder>(scene.base).axis);
        CHECK(std::get<Sphere>(other.scene.objects[0]).center ==
              std::get<Sphere>(one.scene.objects[0]).center);
    }
    // A far object keeps its coordinates in range.
    Scene far = scaled(scene, 1e-60);
    far.objects.push_back(Sphere{{0, 0, 1e60}, 0});
    CHECK(std::get<Sphere>(decide(far).scene.objects.back()).center.z() < 0x1p201);
}

TEST_CASE("cell: scaling a scene by a power of two scales its cell exactly, at every scale") {
    for (const Scene& scene : scenes_of_all_bases()) {
        CAPTURE(scene.base.index());
        const Cell cell = voronoi_cell(scene);
        for (const int k : {-195, -40, 3, 195})
            check_scaled(cell, voronoi_cell(scaled(scene, std::ldexp(1.0, k))), std::ldexp(1.0, k));
    }
}

TEST_CASE("cell: messages give places in the scene's own unit") {
    Scene scene = scenes_of_all_bases()[0];
    scene.objects = {Cylinder{{0.25, 0.5, 7}, {0, 0, 1}, 0.125}};
    CHECK_THROWS_WITH(voronoi_cell(scene), "objects[0].cylinder: cuts the base region at (0.25, 0.5, 0)");
    scene = scenes_of_all_bases()[2];
    scene.objects = {Plane{{0, 0, 0.125}, {0, 0, 1}}};
    CHECK_THROWS_WITH(voronoi_cell(scene), "objects[0].plane: cuts the base at (0, 0, 0.125)");
}

TEST_CASE("hostile: between_2e-180, between_2e180_hangs are one cell in two units") {
    const Cell one = voronoi_cell(between(1));
    for (const int k : {-180, 180})
        check_scaled(one, voronoi_cell(between(std::ldexp(1.0, k))), std::ldexp(1.0, k));
}

TEST_CASE("hostile: underflow: every vertex lies in the box") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.objects = {Sphere{{0, 0, 1e-60}, 1e-60}, Sphere{{-1e-164, 0, 1.0000001e-60}, 1.0000001e-60}};
    scene.box = {{1e-160, 0, 0}, {1e-60, 1e-60, 1e-59}};
    const Cell cell = voronoi_cell(scene);
    for (const CellVertex& v : cell.vertices)
        for (int i = 0; i < 3; ++i) {
            CHECK(v.point[i] >= scene.box.min[i] - 1e-75);
            CHECK(v.point[i] <= scene.box.max[i] + 1e-75);
        }
    CHECK(cell.report.decisions.assumed == 0);
    for (const CellFace& face : cell.faces) CHECK(face.area_error > 0);
}

TEST_CASE("hostile: tilted_lattice has the vertices of flat_lattice, of four balls each") {
    // Orthogonal, of length 7.
    const Vec3 e1(6, 2, -3), e2(-3, 6, -2), n(2, 3, 6);
    Scene flat, tilted;
    flat.base = Plane{{0, 0, 0}, {0, 0, 1}};
    tilted.base = Plane{{0, 0, 0}, n};
    for (int i = -2; i <= 2; ++i)
        for (int j = -2; j <= 2; ++j) {
            flat.objects.push_back(Sphere{{7.0 * i, 7.0 * j, 7}, 1});
            tilted.objects.push_back(Sphere{i * e1 + j * e2 + n, 1});
        }
    flat.box = {{-35, -35, -35}, {35, 35, 35}};
    tilted.box = flat.box;
    const Cell a = voronoi_cell(flat), b = voronoi_cell(tilted);
    CHECK(vertices_of_four(a) == 16);
    CHECK(vertices_of_four(b) == 16);
    CHECK(vertices_by_sites(b).rbegin()->first == 4);
    CHECK(a.report.moved == 0);
    // Sides of the box are rounded when they are turned.
    CHECK(b.report.moved <= 35 * 0x1p-44);
    CHECK(b.report.decisions.assumed == 0);
}

TEST_CASE("cell: tilted planes of any direction leave lattices of balls their vertices") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 6; ++round) {
        // Balls at the corners of squares, the squares' axes across the base only roughly.
        Scene scene;
        const Vec3 normal(0.1 * unit(rng), 0.1 * unit(rng), 1);
        scene.base = Plane{{0.01 * unit(rng), 0.01 * unit(rng), 0.01 * unit(rng)}, normal};
        for (int i = -1; i <= 2; ++i)
            for (int j = -1; j <= 2; ++j) scene.objects.push_back(Sphere{{i - 0.5, j - 0.5, 1.5}, 0.25});
        scene.box = {{-3, -3, -2}, {3, 3, 3}};
        const Cell cell = voronoi_cell(scene);
        CHECK(vertices_of_four(cell) == 9);
        CHECK(cell.report.moved > 0);
        CHECK(cell.report.moved <= 0x1p-44);
    }
}

TEST_CASE("cell: parallel tubes over tilted planes tie four at a time") {
    // On a circle of radius 5 about a line at height 4: from its points all are as far, and from one the base
    // is, too.
    for (const Vec3& normal : {Vec3(2, 3, 6), Vec3(1, 2, 7), Vec3(1, 0, 8)}) {
        CAPTURE(normal.transpose());
        Scene scene;
        scene.base = Plane{{0, 0, 0}, normal};
        for (const auto& [y, z] : {std::array{-3.0, 4.0}, {3.0, 4.0}, {-4.0, 3.0}, {4.0, 3.0}})
            scene.objects.push_back(Cylinder{{0, y, 4 + z}, {1, 0, 0}, 1});
        scene.box = {{-6, -6, -6}, {6, 6, 6}};
        const Cell cell = voronoi_cell(scene);
        CHECK(vertices_of_four(cell) == 1);
    }
}

TEST_CASE("hostile: par: an axis one ulp off the base's is not parallel to it") {
    Scene scene;
    scene.base = Cylinder{{0, 0, 0}, {1, 1, 0}, 0.5};
    scene.objects = {Cylinder{{0, 0, 2}, {1, 1 + 0x1p-52, 0}, 0.5}};
    scene.box = {{-4, -4, -4}, {4, 4, 4}};
    const Cell cell = voronoi_cell(scene);
    for (const CellFace& face : cell.faces)
        if (face.site.is_object()) CHECK(face.bisector != "plane");
    scene.objects = {Cylinder{{0, 0, 2}, {1, 1, 0}, 0.5}};
    for (const CellFace& face : voronoi_cell(scene).faces)
        if (face.site.is_object()) CHECK(face.bisector == "plane");
}

// ---- The mode of the processor -----------------------------------------------------------------------

namespace {

// Holds a rounding mode.
class Rounding {
public:
    explicit Rounding(int mode) : before_(std::fegetround()) { std::fesetround(mode); }
    ~Rounding() { std::fesetround(before_); }
    Rounding(const Rounding&) = delete;
    Rounding& operator=(const Rounding&) = delete;

private:
    int before_;
};

std::string complaint_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const EnvironmentError& e) {
        return e.what();
    }
    return "accepted";
}

struct Square {
    template <class T>
    std::array<T, 1> operator()(const std::array<T, 1>& x) const {
        return {x[0] * x[0] - T(2.0)};
    }
};

}  // namespace

TEST_CASE("environment: other rounding modes are refused, with what to do") {
    const Scene scene = scenes_of_all_bases()[0];
    const auto compute = [&] { voronoi_cell(scene); };
    const auto roots = [] { solve(Square{}, IntervalBox<1>{Interval(0, 2)}); };
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        std::string cell, solver;
        {
            const Rounding rounding(mode);
            cell = complaint_of(compute);
            solver = complaint_of(roots);
        }
        CHECK(
            cell.find(
                "voronoi_cell(): this thread does not round to nearest; call std::fesetround(FE_TONEAREST)") ==
            0);
        CHECK(solver.find("solve(): this thread does not round to nearest") == 0);
    }
    CHECK(complaint_of(compute) == "accepted");
    CHECK(complaint_of(roots) == "accepted");
    // A library that is called back and does not switch rounding back.
    CellOptions options;
    options.progress = [](const char*, double) { std::fesetround(FE_UPWARD); };
    const std::string late = complaint_of([&] { voronoi_cell(scene, options); });
    std::fesetround(FE_TONEAREST);
    CHECK(late.find("voronoi_cell(): this thread does not round to nearest") == 0);
}

TEST_CASE("cell: what touches a tilted base touches it, although the base has turned by rounding") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {-1, 1, -1}};
    scene.box = {{-4, -4, -4}, {4, 4, 4}};
    // Points of the base, within the box and beyond; and one that is a unit in the last place above it.
    scene.objects = {Sphere{{1, 0, -1}, 0}};
    CHECK_THROWS_WITH_AS(voronoi_cell(scene),
                         doctest::Contains("objects[0].sphere: touches the base region at (1"), InputError);
    scene.objects = {Sphere{{6, 0, -6}, 0}};
    CHECK(voronoi_cell(scene).neighbors.empty());
    // The base's own plane, and one through a corner of its region.
    for (const Plane& plane : {Plane{{1, 0, -1}, {2, -2, 2}}, Plane{{-4, -4, 0}, {1, 0, 0}}}) {
        scene.objects = {plane};
        CHECK_THROWS_WITH_AS(voronoi_cell(scene),
                             doctest::Contains("objects[0].plane: touches the base region at ("), InputError);
    }
    scene.objects = {Sphere{{1, 0x1p-40, -1}, 0}};
    const Measures m = voronoi_cell(scene).measures;
    CHECK(m.min_clearance >= 0);
    CHECK(m.min_clearance_error < 1e-12);
}

TEST_CASE("cell: where a tilted base runs through a corner of the box, the vertex has all three sides") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {-2, -1, 1}};
    scene.objects = {Sphere{{-3, 0, 3}, 1}};
    scene.box = {{-4, -4, -4}, {4, 4, 4}};
    int corners = 0;
    for (const CellVertex& v : voronoi_cell(scene).vertices) {
        const Vec3 p = v.point.cwiseAbs() - Vec3::Constant(4);
        if (p.cwiseAbs().maxCoeff() > 1e-12) continue;
        ++corners;
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const Site side = Site::box_side(2 * axis + (v.point[axis] > 0));
            CHECK(std::ranges::find(v.sites, side) != v.sites.end());
        }
    }
    CHECK(corners == 2);
}

TEST_CASE("cell: a scene far from the origin over a plane has the errors of the same scene near it") {
    const Scene near = scenes_of_all_bases()[0];
    const Vec3 shift(1 << 20, -(1 << 21), 1 << 19);
    Scene far = near;
    const auto move = [&](Object& o) {
        std::visit(
            [&](auto& object) {
                if constexpr (requires { object.center; })
                    object.center += shift;
                else if constexpr (requires { object.apex; })
                    object.apex += shift;
                else
                    object.point += shift;
            },
            o);
    };
    move(far.base);
    for (Object& o : far.objects) move(o);
    far.box.min += shift;
    far.box.max += shift;
    const Cell a = voronoi_cell(near), b = voronoi_cell(far);
    REQUIRE(a.edges.size() == b.edges.size());
    CHECK(a.measures.volume == b.measures.volume);
    CHECK(b.report.moved == a.report.moved);
    // What is written far away has fewer digits.
    const double digits = 128 * 0x1p-53 * shift.norm();
    for (std::size_t i = 0; i < a.edges.size(); ++i) {
        CAPTURE(i);
        CHECK(b.edges[i].error <= a.edges[i].error + digits);
        CHECK(b.edges[i].length == a.edges[i].length);
    }
}

#ifdef __SSE2__
TEST_CASE("cell: turning a base moves the edge between vessels that all but coincide by little") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {1, 1, 1}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    for (const double apart : {1e-3, 1e-6, 1e-9}) {
        CAPTURE(apart);
        scene.objects = {HollowSphere{{0.25, 0.125, 0.5}, 2}, HollowSphere{{0.25 + apart, 0.125, 0.5}, 2}};
        const Cell cell = voronoi_cell(scene);
        CHECK(cell.report.moved > 0);
        CHECK(cell.vertices.size() == 2);
        CHECK(cell.edges.size() == 3);
        for (const CellVertex& v : cell.vertices) CHECK(v.error < 1e-8);
        for (const CellEdge& e : cell.edges) CHECK(e.error < 1e-8);
    }
}

TEST_CASE("environment: flushed subnormals are refused, with what to do") {
    const Scene scene = scenes_of_all_bases()[0];
    for (const unsigned mode : {0x8000u, 0x0040u}) {
        const unsigned before = _mm_getcsr();
        _mm_setcsr(before | mode);
        const std::string text = complaint_of([&] { voronoi_cell(scene); });
        _mm_setcsr(before);
        CHECK(
            text.find(
                "voronoi_cell(): this thread takes subnormal numbers for zero; call _MM_SET_FLUSH_ZERO_MODE") ==
            0);
    }
}
#endif

}  // namespace vcell::decided_scene_test
