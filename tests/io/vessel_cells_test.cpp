/// Cells of balls in vessels: their files, and what certify() says of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/check/integrals.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/solids/moments.hpp"
#include "../test_support.hpp"
#include "closed_meshes.hpp"
#include "listing.hpp"

namespace vcell {
namespace {

// Six balls about one at the wall, in any vessel.
Scene near_wall(const Object& vessel) {
    Scene scene;
    scene.base = Sphere{{1.25, 0.125, 0.0625}, 0.5};
    scene.objects = {Sphere{{0.5, 1, 0.25}, 0.375},      Sphere{{0.5, -0.75, 0.25}, 0.4375},
                     Sphere{{0.125, 0.125, 0.125}, 0.5}, Sphere{{1, 0.25, 1.125}, 0.375},
                     Sphere{{0.875, 0, -1.125}, 0.5},    vessel};
    scene.names = {"", "", "", "", "", "wall"};
    scene.box = {{-2.25, -2.25, -2.25}, {2.25, 2.25, 2.25}};
    return scene;
}

const Object ball = HollowSphere{{0, 0.0625, 0}, 2};
const Object tube = HollowCylinder{{0, 0, 0.5}, {0.125, 0, 1}, 2};
// Nearly as wide about the balls, with 0.8 the cosine of half its angle.
const Object cone = HollowCone{{0.125, 0, -2.5}, {0.0625, 0, 1}, 3, 5};

// Three balls about one in a sphere.
Scene in_sphere() {
    Scene scene;
    scene.base = Sphere{{0.75, 0.5, 0.25}, 0.5};
    scene.objects = {Sphere{{-0.75, 0.5, 0.25}, 0.5}, Sphere{{0.25, -0.75, 0.5}, 0.375},
                     Sphere{{0, 0.25, -1.25}, 0.25}, HollowSphere{{0, 0, 0}, 2}};
    scene.box = {{-2.5, -2.5, -2.5}, {2.5, 2.5, 2.5}};
    return scene;
}

bool is_refuted(const Certificate& c, const std::string& where) {
    return std::ranges::any_of(c.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && e.where.starts_with(where);
    });
}

void check_file(const Cell& cell) {
    std::stringstream file;
    write_cell(file, cell);
    CHECK(certify(parse_cell(file.str())).holds());
}

// expect(where, damage): a cell with one of its faces damaged is refuted there.
struct DamagedFace {
    const Cell& cell;
    std::size_t face;

    void operator()(const std::string& where, const std::function<void(Cell&, CellFace&)>& damage) const {
        Cell bad = cell;
        damage(bad, bad.faces[face]);
        const Certificate c = certify(bad, {50, 1, 4});
        CHECK_MESSAGE(is_refuted(c, where), "expected ", where, ", found\n", listing(c));
    }
};

TEST_CASE("vessel cells: scenes and cells survive their files") {
    for (const Object& vessel : {ball, tube, cone}) {
        const Scene scene = near_wall(vessel);
        std::ostringstream out;
        write_scene(out, scene);
        const Scene read = parse_scene(out.str());
        CHECK(read.objects == scene.objects);
        CHECK(read.names == scene.names);
        std::ostringstream again;
        write_scene(again, read);
        CHECK(again.str() == out.str());
    }
    const auto path_of = [](const std::string& object) -> std::string {
        try {
            parse_scene(
                R"({"vcell": 1, "base": {"sphere": {"center": [0, 0, 0], "radius": 1}}, "objects": [)" +
                object + R"(], "box": {"min": [-3, -3, -3], "max": [3, 3, 3]}})");
        } catch (const InputError& e) {
            return e.path;
        }
        return "";
    };
    CHECK(path_of(R"({"hollow_sphere": {"center": [0, 0, 0], "radius": 2}})").empty());
    CHECK(path_of(R"({"hollow_sphere": {"center": [0, 0, 0], "radius": -2}})") ==
          "objects[0].hollow_sphere.radius");
    CHECK(path_of(R"({"hollow_sphere": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 2}})") ==
          "objects[0].hollow_sphere.axis");
    CHECK(path_of(R"({"hollow_cylinder": {"point": [0, 0, 0], "axis": [0, 0, 0], "radius": 2}})") ==
          "objects[0].hollow_cylinder.axis");
    const auto path_of_cone = [&](const std::string& rest) {
        return path_of(R"({"hollow_cone": {"apex": [0, 0, -3], "axis": [0, 0, 1])" + rest + "}}");
    };
    CHECK(path_of_cone(R"(, "radius": 3, "slant": 5)").empty());
    CHECK(path_of_cone(R"(, "half_angle": 30)").empty());
    CHECK(path_of_cone("") == "objects[0].hollow_cone");
    CHECK(path_of_cone(R"(, "radius": 3)") == "objects[0].hollow_cone");
    CHECK(path_of_cone(R"(, "radius": 3, "slant": 5, "half_angle": 30)") == "objects[0].hollow_cone");
    CHECK(path_of_cone(R"(, "radius": 5, "slant": 3)") == "objects[0].hollow_cone.slant");
    for (const char* angle : {"0", "-30", "90", "150", "1e-400"})
        CHECK(path_of_cone(std::string(R"(, "half_angle": )") + angle) ==
              "objects[0].hollow_cone.half_angle");
}

TEST_CASE("vessel cells: half a cone's angle in degrees is its sine, rounded") {
    const Scene scene = parse_scene(R"({"vcell": 1, "base": {"sphere": {"center": [0, 0, 0], "radius": 1}},
        "objects": [{"hollow_cone": {"apex": [0, 0, -3], "axis": [0, 0, 1], "half_angle": 30}},
                    {"hollow_cone": {"apex": [0, 0, -3], "axis": [0, 0, 1], "half_angle": 45}}],
        "box": {"min": [-1, -1, -1], "max": [1, 1, 1]}})");
    CHECK(scene.objects[0] == Object(HollowCone{{0, 0, -3}, {0, 0, 1}, 0.5, 1}));
    CHECK(std::get<HollowCone>(scene.objects[1]).sine() == std::sqrt(0.5));
}

TEST_CASE("vessel cells: certified, and refuted where they are damaged") {
    for (const Scene& scene : {in_sphere(), near_wall(tube), near_wall(cone)}) {
        const auto number_of_wall = static_cast<std::uint32_t>(scene.objects.size() - 1);
        CAPTURE(scene.objects.back().index());
        const Cell cell = voronoi_cell(scene);
        const Site wall = Site::object(number_of_wall);
        REQUIRE(std::ranges::any_of(cell.faces, [&](const CellFace& f) { return f.site == wall; }));
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));

        const auto expect = [&](const std::string& where, const std::function<void(Cell&)>& damage) {
            Cell bad = cell;
            damage(bad);
            const Certificate c = certify(bad);
            CHECK_MESSAGE(is_refuted(c, where), "expected ", where, ", found\n", listing(c));
        };
        // A wall that is as wide as a hair more.
        const auto widen = [](Cell& bad, double by) {
            if (auto* o = std::get_if<HollowSphere>(&bad.scene.objects.back())) o->radius += by;
            if (auto* o = std::get_if<HollowCylinder>(&bad.scene.objects.back())) o->radius += by;
            if (auto* o = std::get_if<HollowCone>(&bad.scene.objects.back())) o->apex.z() -= 2 * by;
        };
        expect("vertices", [&](Cell& bad) { widen(bad, 1e-6); });
        // One that comes in where the cell is.
        expect("faces", [&](Cell& bad) { widen(bad, -0.0625); });
        const auto at_wall = std::ranges::find_if(cell.vertices, [&](const CellVertex& v) {
            return std::ranges::find(v.sites, wall) != v.sites.end();
        });
        REQUIRE(at_wall != cell.vertices.end());
        const auto number = static_cast<std::size_t>(at_wall - cell.vertices.begin());
        expect("vertices[" + std::to_string(number),
               [&](Cell& bad) { bad.vertices[number].point.x() += 1e-7; });
        const auto face = std::ranges::find_if(cell.faces, [&](const CellFace& f) { return f.site == wall; });
        const auto at = static_cast<std::size_t>(face - cell.faces.begin());
        expect("faces[" + std::to_string(at),
               [&](Cell& bad) { bad.faces[at].patches[0].surface.points[0].x() += 1e-3; });
        expect("faces[" + std::to_string(at), [&](Cell& bad) { bad.faces[at].bisector = "hyperboloid"; });
        expect("measures.volume", [](Cell& bad) { bad.measures.volume *= 1 + 1e-4; });
    }
}

TEST_CASE("vessel cells: where a wall's face reaches far around the base nothing is refuted") {
    const Certificate c = certify(voronoi_cell(near_wall(ball)));
    CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
    CHECK(c.count(Verdict::open) <= 3);
}

// Rays that have left the box within the base's body were taken to reach its surface.
TEST_CASE("vessel cells: a base that reaches beyond a side of the box is not refuted") {
    const Certificate c = certify(voronoi_cell(read_scene(test_data("ball_beyond_side_in_vessel.json"))));
    CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
}

// The area of a face that is left open was taken for nothing: a neighbour after it seemed to own more.
TEST_CASE("vessel cells: a face at the wall whose area is left open refutes no order of neighbours") {
    const Certificate c = certify(voronoi_cell(read_scene(test_data("point_at_wall_of_hollow_cone.json"))));
    CHECK_MESSAGE(c.count(Verdict::refuted) == 0, listing(c));
}

TEST_CASE("vessel cells: one that is all of a sphere or of a spheroid is certified") {
    for (const double off : {0.0, 0.5, 1.25}) {
        CAPTURE(off);
        Scene scene;
        scene.base = Sphere{{off, 0, 0}, 0.5};
        scene.objects = {HollowSphere{{0, 0, 0}, 2}};
        scene.box = {{-3, -3, -3}, {3, 3, 3}};
        const Cell cell = voronoi_cell(scene);
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));
        Cell bad = cell;
        bad.faces[0].area *= 1 + 1e-9;
        CHECK(is_refuted(certify(bad), "faces[0].area"));
        bad = cell;
        bad.measures.volume *= 1 - 1e-9;
        CHECK(is_refuted(certify(bad), "measures.volume"));
        bad = cell;
        bad.scene.objects.push_back(Sphere{{0, 1.25, 0}, 0.25});
        CHECK_FALSE(certify(bad).holds());
    }
}

// ---- Around a vessel's axis -----------------------------------------------------------------------------

// A ball on the axis of a tube that all of its cell but the ends is about: the wall's face is r = (D^2 - z^2)
// / (2 D) away from the axis.
Scene on_axis() {
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.5};
    scene.objects = {HollowCylinder{{0, 0, 7}, {0, 0, 2}, 2}};
    scene.box = {{-4, -4, -1.5}, {4, 4, 1.5}};
    return scene;
}

// Three balls, of which the first is the base, in a tube or a cone about the z axis.
Scene few_balls(const Object& vessel) {
    Scene scene;
    scene.base = Sphere{{0.25, 0.125, 0}, 0.5};
    scene.objects = {Sphere{{-0.5, 0.25, 1.25}, 0.375}, Sphere{{0.75, -0.75, -1}, 0.25}, vessel};
    scene.box = {{-4, -4, -1.5}, {4, 4, 1.5}};
    return scene;
}

const CellFace& face_of(const Cell& cell, Site site) {
    const auto face = std::ranges::find(cell.faces, site, &CellFace::site);
    REQUIRE(face != cell.faces.end());
    return *face;
}

TEST_CASE("vessel cells: of a ball in the middle of a sphere, among balls and tubes, they are certified") {
    const Cylinder rod{{4, 6, 4}, Vec3::UnitY(), 0.25};
    const HollowSphere vessel{{3, 4, 3}, 3};
    Scene scene;
    scene.base = Sphere{{3, 4, 3}, 0.5};
    scene.box = {Vec3::Zero(), Vec3::Constant(8)};
    for (const auto& objects :
         {std::vector<Object>{Sphere{{2, 4, 1}, 0.5}, rod, vessel},
          {Sphere{{2, 5, 2}, 0.5}, Sphere{{4, 2, 2}, 0.5}, Sphere{{4, 5, 1}, 0.5}, Sphere{{5, 5, 3}, 0.5},
           Sphere{{2, 4, 1}, 0.5}, Cylinder{{3, 5, 5}, Vec3::UnitY(), 0.25}, rod, vessel}}) {
        scene.objects = objects;
        const Certificate c = certify(voronoi_cell(scene));
        CHECK_MESSAGE(c.holds(), listing(c));
    }
}

// Raises both degrees by one, which leaves the surface as it is.
void raise_degrees(RationalPatch& s) {
    const auto raised = [](const std::vector<Eigen::Vector4d>& row) {
        const auto n = static_cast<double>(row.size());
        std::vector<Eigen::Vector4d> result{row.front()};
        for (std::size_t i = 1; i < row.size(); ++i) {
            const double share = static_cast<double>(i) / n;
            result.push_back(share * row[i - 1] + (1 - share) * row[i]);
        }
        result.push_back(row.back());
        return result;
    };
    for (Eigen::Vector4d& p : s.points) p.head<3>() *= p.w();
    std::vector<std::vector<Eigen::Vector4d>> along_v;
    for (int i = 0; i <= s.degree_u; ++i) {
        const auto row = s.points.begin() + i * (s.degree_v + 1);
        along_v.push_back(raised({row, row + s.degree_v + 1}));
    }
    std::vector<std::vector<Eigen::Vector4d>> along_u;
    for (int k = 0; k <= s.degree_v + 1; ++k) {
        std::vector<Eigen::Vector4d> column;
        for (const auto& row : along_v) column.push_back(row[static_cast<std::size_t>(k)]);
        along_u.push_back(raised(column));
    }
    ++s.degree_u;
    ++s.degree_v;
    s.points.clear();
    for (std::size_t i = 0; i < along_u[0].size(); ++i)
        for (const auto& column : along_u) s.points.push_back(column[i]);
    for (Eigen::Vector4d& p : s.points) p.head<3>() /= p.w();
}

// Along a spline a patch of degree 24, as hollow tubes and cones may have it, is a polynomial of degree 240.
TEST_CASE("vessel cells: splines on spheroids, whatever the patches' degree, are certified") {
    Scene scene;
    scene.base = Sphere{{4, 4, 2}, 0.5};
    // The wall's face reaches around the base, to where a ball and a tube leave it little room for a pole.
    scene.objects = {Sphere{{2, 1, 1}, 0.4375}, Cylinder{{4, 5, 6}, Vec3::UnitX(), 0.5},
                     HollowSphere{{5, 3, 4}, 5}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(10)};
    Cell cell = voronoi_cell(scene);
    const Certificate c = certify(cell);
    CHECK_MESSAGE(c.holds(), listing(c));
    const auto wall = std::ranges::find(cell.faces, Site::object(2), &CellFace::site);
    REQUIRE(wall != cell.faces.end());
    for (TrimmedPatch& patch : wall->patches)
        while (patch.surface.degree_u < 24) raise_degrees(patch.surface);
    const Certificate raised = certify(cell);
    CHECK_MESSAGE(raised.holds(), listing(raised));
}

TEST_CASE("vessel cells: integrals of a face around the axis, and of one with a tip, have closed forms") {
    const Cell cell = voronoi_cell(on_axis());
    const check::Frame frame(cell.scene);
    const auto wall = static_cast<std::size_t>(&face_of(cell, Site::object(0)) - cell.faces.data());
    std::vector<std::vector<check::EdgeUse>> uses(cell.edges.size());
    for (std::size_t f = 0; f < cell.faces.size(); ++f)
        for (const TrimmedPatch& patch : cell.faces[f].patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop) {
                    if (!trim.edge) continue;
                    auto& of_edge = uses[*trim.edge];
                    if (std::ranges::find(of_edge, f, &check::EdgeUse::face) == of_edge.end())
                        of_edge.push_back({f, trim.reversed});
                }
    const std::vector<check::EdgeBand> bands(cell.edges.size(), {1e-9, 2});
    const std::vector<std::optional<check::Precision>> proofs(cell.faces.size(),
                                                              check::Precision{1e-12, 1e-12});
    const auto integrals = [&] {
        return check::integrate_faces(cell, frame, uses, bands, {1e-12, 1e-12, 1e-12}, 64, proofs)
            .faces[wall];
    };
    const double D = 2.5, h = 1.5, D2 = D * D, h2 = h * h, pi = std::numbers::pi;
    const double r = (D2 - h2) / (2 * D);
    const double volume =
        pi / (2 * D2) * h * (D2 * D2 - 2 * D2 * h2 / 3 + h2 * h2 / 5) - 2 * pi * r * r * h / 3;
    // 2 pi r sqrt(1 + r'^2) between z = -h and `to`, by Simpson's rule.
    const auto area_until = [&](double to) {
        double sum = 0;
        constexpr int parts = 1000;
        for (int i = 0; i <= parts; ++i) {
            const double z = -h + (to + h) * i / parts;
            sum += (D2 - z * z) / D * std::hypot(1, z / D) * (i == 0 || i == parts ? 1 : i % 2 == 1 ? 4 : 2);
        }
        return sum * pi * (to + h) / parts / 3;
    };
    const double unit = frame.unit();
    const check::FaceIntegrals whole = integrals();
    CHECK(whole.is_known);
    CHECK(whole.is_proved);
    // Edges are splines, off by less than 1e-6.
    CHECK(whole.volume.mid() * unit * unit * unit == doctest::Approx(volume).epsilon(1e-6));
    CHECK(whole.area.mid() * unit * unit == doctest::Approx(area_until(h)).epsilon(1e-6));
    CHECK(whole.area.width() < 1e-9);
    CHECK(whole.shadow.mid() > 0);
    // With one of its edges alone it goes on to where the bisector meets the axis, at z = D: pi r^2 adds up
    // to 8 pi D^3 / 60 from 0 on.
    std::erase_if(uses[0], [&](const check::EdgeUse& use) { return use.face == wall; });
    const check::FaceIntegrals beyond = integrals();
    CHECK(beyond.is_known);
    CHECK(beyond.is_proved);
    CHECK(beyond.volume.mid() * unit * unit * unit ==
          doctest::Approx(0.5 * volume + 2 * pi * D * D2 / 15).epsilon(1e-6));
    CHECK(beyond.area.mid() * unit * unit == doctest::Approx(area_until(D)).epsilon(1e-6));
    CHECK(beyond.area.width() < 1e-9);
}

TEST_CASE("vessel cells: faces around a vessel's axis are certified, meshed, and refuted where damaged") {
    const HollowCylinder upright{{0, 0, 0.5}, {0, 0, 1}, 2}, leaning{{0.25, 0, 0}, {0.125, -0.25, 2}, 2};
    const HollowCone funnel{{0, 0, -3.75}, {0, 0, 1}, 3, 5}, askew{{0.25, 0, -4}, {0.125, 0, 2}, 3, 5};
    const std::vector<Scene> scenes{on_axis(), few_balls(upright), few_balls(leaning), few_balls(funnel),
                                    few_balls(askew)};
    for (const Scene& scene : scenes) {
        const Site wall = Site::object(static_cast<std::uint32_t>(scene.objects.size() - 1));
        CAPTURE(scene.objects.size());
        CAPTURE(scene.objects.back().index());
        const Cell cell = voronoi_cell(scene);
        const CellFace& face = face_of(cell, wall);
        REQUIRE(face.patches.size() >= 3);
        const auto at = static_cast<std::size_t>(&face - cell.faces.data());
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));

        const CellMesh mesh = tessellate(cell);
        CHECK(is_closed(mesh));
        CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(4e-3));

        check_file(cell);
        const DamagedFace expect{cell, at};
        const std::string name = "faces[" + std::to_string(at) + "]";
        expect(name + ".area", [](Cell&, CellFace& f) { f.area *= 1 + 1e-4; });
        expect("measures.volume", [](Cell& bad, CellFace&) { bad.measures.volume *= 1 + 1e-4; });
        expect(name + ".patches[0", [](Cell&, CellFace& f) { f.patches[0].surface.points[1].x() += 1e-3; });
        expect("", [](Cell&, CellFace& f) { f.patches.pop_back(); });
        expect("", [](Cell&, CellFace& f) {
            for (auto& loop : f.patches[0].loops)
                for (TrimCurve& trim : loop)
                    if (trim.seam) trim.seam = *trim.seam + 1;
        });
    }
}

// Alone, and beside a ball, in vessels that end far away.
std::vector<Scene> with_tips() {
    const HollowCylinder upright{{0, 0, 0.5}, {0, 0, 1}, 2}, leaning{{0.25, 0, 0}, {0.125, -0.25, 2}, 2};
    const HollowCone funnel{{0, 0, -3.75}, {0, 0, 1}, 3, 5}, askew{{0.25, 0, -4}, {0.125, 0, 2}, 3, 5};
    std::vector<Scene> scenes;
    for (const Object& vessel : {Object(upright), Object(leaning), Object(funnel), Object(askew)}) {
        Scene scene;
        scene.base = Sphere{{0.25, -0.25, 0}, 0.5};
        scene.objects = {vessel};
        scene.box = {Vec3::Constant(-16), Vec3::Constant(16)};
        scenes.push_back(scene);
        scene.objects.insert(scene.objects.begin(), Sphere{{-0.5, 0.25, 1.25}, 0.375});
        scenes.push_back(scene);
        scene.box.max.z() = 1.5;
        scenes.push_back(scene);
    }
    return scenes;
}

TEST_CASE("vessel cells: faces with tips are certified, meshed, made solid, and refuted where damaged") {
    int single = 0;
    for (const Scene& scene : with_tips()) {
        const Site wall = Site::object(static_cast<std::uint32_t>(scene.objects.size() - 1));
        CAPTURE(scene.objects.size());
        CAPTURE(scene.objects.back().index());
        CAPTURE(scene.box.max.z());
        const Cell cell = voronoi_cell(scene);
        const CellFace& face = face_of(cell, wall);
        const auto at = static_cast<std::size_t>(&face - cell.faces.data());
        std::vector<const TrimCurve*> tips;
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop)
                    if (trim.is_tip()) tips.push_back(&trim);
        REQUIRE((tips.size() == 3 || tips.size() == 6));
        single += tips.size() == 3;
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));

        check_mesh_and_solid(cell, 6e-3);
        const auto scale = cell.measures.volume;
        const Moments moments = moments_of(cell);
        CHECK(std::isfinite(moments.centroid.norm()));
        CHECK(moments.centroid_error < 1e-4 * std::cbrt(scale));

        check_file(cell);
        const DamagedFace expect{cell, at};
        const auto for_tips = [](CellFace& f, const auto& change) {
            for (TrimmedPatch& patch : f.patches)
                for (auto& loop : patch.loops)
                    for (TrimCurve& trim : loop)
                        if (trim.is_tip()) change(patch, trim);
        };
        const std::string name = "faces[" + std::to_string(at) + "]";
        expect(name + ".area", [](Cell&, CellFace& f) { f.area *= 1 + 1e-4; });
        expect("measures.volume", [](Cell& bad, CellFace&) { bad.measures.volume *= 1 + 1e-4; });
        expect("measures.max_clearance",
               [](Cell& bad, CellFace&) { bad.measures.max_clearance *= 1 - 1e-4; });
        // Short of the tip, and the name of a seam.
        expect("", [&](Cell&, CellFace& f) {
            for_tips(f, [](const TrimmedPatch& patch, TrimCurve& trim) {
                const auto& [v0, v1] = patch.surface.domain_v;
                for (auto& p : trim.curve.points) p.y() += 1e-3 * (0.5 * (v0 + v1) - p.y());
            });
        });
        expect("", [&](Cell&, CellFace& f) {
            for_tips(f, [](const TrimmedPatch&, TrimCurve& trim) { trim.seam = 1000; });
        });
    }
    CHECK(single >= 2);
}

// ---- Around tubes ---------------------------------------------------------------------------------------

// A tube, leaning or along z, near the wall of any vessel, with balls and a tube about it.
Scene about_tube(const Vec3& axis, const Object& vessel) {
    Scene scene;
    scene.base = Cylinder{{0.75, 0.125, 0}, axis, 0.25};
    scene.objects = {Sphere{{-0.25, 0.5, 0.25}, 0.375}, Sphere{{0.5, -0.875, 0.25}, 0.25},
                     Sphere{{1.25, 0.75, -0.25}, 0.25}, Cylinder{{-0.5, -0.75, 0}, {0, 0, 1}, 0.25}, vessel};
    scene.box = {{-2.25, -2.25, -1}, {2.25, 2.25, 0.75}};
    return scene;
}

TEST_CASE("vessel cells: around tubes they are certified, and refuted where they are damaged") {
    const HollowCylinder along{{0, 0, 0}, {0, 0, 1}, 2};
    const auto with = [](const Vec3& axis, const Object& vessel) { return about_tube(axis, vessel); };
    for (const Scene& scene :
         {with({0, 0, 1}, along), with({0, 0, 1}, tube), with({0.125, 0.25, 1}, along), with({0, 0, 1}, ball),
          with({0.125, 0, 1}, ball), with({0, 0, 1}, cone), with({0.25, -0.125, 1}, cone)}) {
        CAPTURE(scene.objects.back().index());
        const Cell cell = voronoi_cell(scene);
        const Site wall = Site::object(4);
        const auto face = std::ranges::find_if(cell.faces, [&](const CellFace& f) { return f.site == wall; });
        REQUIRE(face != cell.faces.end());
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));

        const auto expect = [&](const std::string& where, const std::function<void(Cell&)>& damage) {
            Cell bad = cell;
            damage(bad);
            const Certificate c = certify(bad, {50, 1, 4});
            CHECK_MESSAGE(is_refuted(c, where), "expected ", where, ", found\n", listing(c));
        };
        expect("vertices", [&](Cell& bad) {
            Object& o = bad.scene.objects.back();
            if (auto* x = std::get_if<HollowSphere>(&o)) x->radius += 1e-6;
            if (auto* x = std::get_if<HollowCylinder>(&o)) x->radius += 1e-6;
            if (auto* x = std::get_if<HollowCone>(&o)) x->apex.z() -= 2e-6;
        });
        const auto at = static_cast<std::size_t>(face - cell.faces.begin());
        expect("faces[" + std::to_string(at), [&](Cell& bad) { bad.faces[at].bisector = "hyperboloid"; });
        expect("measures.max_clearance", [](Cell& bad) { bad.measures.max_clearance *= 1 + 1e-4; });
    }
}

// All along a line of the surface the parameters of a patch may be the same: next to where the tube would
// come out of the wall it runs through the face.
TEST_CASE("vessel cells: around a tube that leans towards the wall of a wide vessel") {
    for (const double R : {30.0, 1000.0}) {
        CAPTURE(R);
        // The wall is 0.25 away from the base's point, across the vessel's axis.
        const Vec3 point(0, -0.5, 0), axis(0.25, 0.25, 1);
        Vec3 out(0.0625, -1, 0);
        out -= out.dot(axis) / axis.squaredNorm() * axis;
        Scene scene;
        scene.base = Cylinder{point, {0, 0, 1}, 0.25};
        scene.objects = {HollowCylinder{point - (R - 0.25) * out.normalized(), axis, R}};
        scene.box = {{-1.5, -1.5, -0.5}, {1.5, 1.5, 0.5}};
        const Certificate c = certify(voronoi_cell(scene));
        CHECK_MESSAGE(c.holds(), listing(c));
    }
}

// Their parts end next to where the tubes come out: what is beyond is nobody's.
TEST_CASE("vessel cells: complete cells of tubes that come out of their vessel are certified") {
    const HollowSphere around{{0, 0.125, 0}, 1.5};
    for (const double top : {2.5, 1.0}) {
        CAPTURE(top);
        Scene scene = about_tube({0.25, 0.5, 1}, around);
        scene.base = Cylinder{{0.5, 0, 0}, {0.25, 0.125, 1}, 0.125};
        scene.objects.erase(scene.objects.begin() + 2);
        scene.box = {{-2, -2, -2.5}, {2, 2, top}};
        CHECK_THROWS_AS(voronoi_cell(scene), InputError);
        CellOptions options;
        options.complete = true;
        const Cell cell = voronoi_cell(scene, options);
        REQUIRE(cell.is_complete);
        REQUIRE_FALSE(cell.parts.empty());
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.count(Verdict::refuted) == 0, listing(good));
        CHECK_MESSAGE(good.count(Verdict::open) <= 3, listing(good));
        const auto verdict_of_parts = [](const Cell& c) {
            for (const Element& e : certify(c, {50, 1, 4}).elements)
                if (e.where == "parts") return e.verdict;
            return Verdict::open;
        };
        CHECK(verdict_of_parts(cell) == Verdict::proved);
        Cell bad = cell;
        // A part that ends a hundredth before it should.
        auto& ends = bad.parts.back().ends;
        ends[1] += 0.01 * (ends[0] - ends[1]);
        CHECK(verdict_of_parts(bad) != Verdict::proved);
        bad = cell;
        bad.measures.volume *= 1 + 1e-3;
        CHECK(is_refuted(certify(bad, {50, 1, 8}), "measures.volume"));
    }
}

TEST_CASE("vessel cells: the farthest place around a tube may be on no edge") {
    // Beyond the middle of a sphere, and of a tube that it crosses.
    for (const Object& vessel :
         {Object(HollowSphere{{0, 0, 0}, 2}), Object(HollowCylinder{{0, 0, 0}, {0, 0.5, 1}, 2}),
          Object(HollowCone{{0, 0, -2.5}, {0, 0.5, 1}, 3, 5})}) {
        CAPTURE(vessel.index());
        Scene scene;
        scene.base = Cylinder{{0.5, 0, 0}, {0, 0, 1}, 0.25};
        scene.objects = {vessel};
        scene.box = {{-3, -3, -1}, {3, 3, 1}};
        const Cell cell = voronoi_cell(scene);
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));
        if (vessel.index() == 3) CHECK(cell.measures.max_clearance == doctest::Approx(1.125).epsilon(1e-12));
        Cell bad = cell;
        bad.measures.max_clearance *= 1 - 1e-4;
        CHECK(is_refuted(certify(bad, {50, 1, 4}), "measures.max_clearance"));
    }
}

}  // namespace
}  // namespace vcell
