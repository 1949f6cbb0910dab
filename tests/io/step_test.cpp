// STEP files, as text: every reference is there, shells are closed, and curves are the cell's.
#include "../../io/files/step_file.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/solids/solid.hpp"
#include "../../io/solids/spline_surface.hpp"
#include "sample_cells.hpp"

namespace vcell {
namespace {

std::map<int, std::string> entities(const std::string& file) {
    std::map<int, std::string> all;
    std::istringstream lines(file);
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with('#')) {
            const std::size_t is = line.find('=');
            CHECK(line.back() == ';');
            all[std::stoi(line.substr(1))] = line.substr(is + 1);
        }
    return all;
}

std::size_t count(const std::map<int, std::string>& all, const std::string& kind) {
    std::size_t n = 0;
    for (const auto& [id, text] : all) n += text.starts_with(kind + "(");
    return n;
}

// Calls visit(face, use, the next one around the loop).
template <class Visit>
void for_uses(const Solid& solid, Visit&& visit) {
    for (const Solid::Face& face : solid.faces)
        for (const auto& loop : face.loops)
            for (std::size_t i = 0; i < loop.size(); ++i) visit(face, loop[i], loop[(i + 1) % loop.size()]);
}

void check_follows(const Solid& solid, const Solid::Use& use, const Solid::Use& next) {
    CHECK(solid.edges[use.edge].vertices[use.reversed ? 0 : 1] ==
          solid.edges[next.edge].vertices[next.reversed ? 1 : 0]);
}

}  // namespace

TEST_CASE("step: a ball's cell is a closed solid of its faces, edges and vertices") {
    Scene scene;
    scene.base = Sphere{{0.1, 0, 0}, 0.25};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Sphere{{0.5, 1, 1.25}, 0.5}, Sphere{{-1, -0.5, 1}, 0.25}, Plane{{0, 0, -1}, {0.1, 0, 1}},
                     Sphere{{0, 0, 1.5}, 0.01}};
    scene.units = "um";
    const Cell cell = voronoi_cell(scene);
    std::ostringstream out;
    write_step(out, cell);
    const std::string file = out.str();
    CHECK(file.starts_with("ISO-10303-21;\n"));
    CHECK(file.ends_with("ENDSEC;\nEND-ISO-10303-21;\n"));
    CHECK(file.find("SI_UNIT(.MICRO.,.METRE.)") != file.npos);
    const auto all = entities(file);
    for (const auto& [id, text] : all) {
        for (std::size_t at = 0; (at = text.find('#', at)) != text.npos; ++at)
            CHECK(all.contains(std::stoi(text.substr(at + 1))));
        // Numbers have points: an integer would not be a REAL.
        if (text.starts_with("CARTESIAN_POINT"))
            CHECK(std::regex_match(
                text, std::regex(R"(CARTESIAN_POINT\('',\((-?\d+\.\d*(E-?\+?\d+)?,?){2,3}\)\);)")));
    }
    CHECK(count(all, "ADVANCED_FACE") == cell.faces.size());
    CHECK(count(all, "EDGE_CURVE") == cell.edges.size());
    CHECK(count(all, "CLOSED_SHELL") == 1);
    CHECK(count(all, "PCURVE") == 2 * cell.edges.size());
    CHECK(count(all, "STYLED_ITEM") == cell.faces.size());
    // Each edge is used once each way.
    std::map<int, int> balance;
    for (const auto& [id, text] : all)
        if (text.starts_with("ORIENTED_EDGE"))
            balance[std::stoi(text.substr(text.find('#') + 1))] += text.find(".T.") != text.npos ? 1 : -1;
    CHECK(balance.size() == cell.edges.size());
    for (const auto& [edge, sum] : balance) CHECK(sum == 0);
    std::ostringstream again;
    write_step(again, cell);
    CHECK(again.str() == file);
}

TEST_CASE("step: over planes and around tubes walls, floor and ends are faces, and seams are edges") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0, 0, 1}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Sphere{{0.5, 1, 1.25}, 0.25}};
    const auto written = [&] {
        std::ostringstream out;
        write_step(out, voronoi_cell(scene));
        return entities(out.str());
    };
    const Cell over_plane = voronoi_cell(scene);
    auto all = written();
    CHECK(count(all, "ADVANCED_FACE") == over_plane.faces.size() + 5);
    CHECK(count(all, "PLANE") == 5);
    CHECK(count(all, "EDGE_CURVE") == over_plane.edges.size() + 8);
    CHECK(count(all, "CLOSED_SHELL") == 1);
    scene.base = Cylinder{{0, 0, 0}, {0, 1, 0}, 0.25};
    const Cell around_tube = voronoi_cell(scene);
    std::size_t patches = 0;
    std::set<std::uint32_t> seams;
    for (const CellFace& face : around_tube.faces)
        for (const TrimmedPatch& patch : face.patches) {
            ++patches;
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop)
                    if (trim.seam) seams.insert(*trim.seam);
        }
    all = written();
    CHECK(count(all, "ADVANCED_FACE") == patches + 2);
    CHECK(count(all, "PLANE") == 2);
    CHECK(count(all, "EDGE_CURVE") >= around_tube.edges.size() + seams.size());
    CHECK(count(all, "PCURVE") == 2 * count(all, "EDGE_CURVE"));
}

TEST_CASE("step: a base plane that leans has walls where the box goes on above its region alone") {
    Scene scene;
    scene.base = Plane{{0, 0, 0}, {0.5, 0, 1}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    scene.objects = {Sphere{{0.5, 0, 1.25}, 0.25}};
    for (const bool complete : {false, true}) {
        CAPTURE(complete);
        CellOptions options;
        options.complete = complete;
        const Cell cell = voronoi_cell(scene, options);
        CHECK(cell.is_complete == complete);
        const Shell shell = closed_shell(cell);
        // The base and the sides across y; the side -x leans inwards, where rays come in.
        std::multiset<std::string> closing;
        for (std::size_t f = cell.faces.size(); f < shell.faces.size(); ++f)
            closing.insert(to_string(shell.faces[f].site));
        CHECK(closing == (complete ? std::multiset<std::string>{"base", "box:+y", "box:-y"}
                                   : std::multiset<std::string>{"base", "box:+y", "box:-x", "box:-y"}));
        CHECK(shell.off_plane < 1e-12);
        const Solid solid = solid_of(shell, cell.faces.size());
        CHECK(solid.parts.size() == 1);
        CHECK(solid.off < 1e-6);
        CHECK(solid.vertices.size() + solid.faces.size() == solid.edges.size() + 2);
    }
}

TEST_CASE("step: a face without an edge has its seam for one, closed, with its curves on both patches") {
    const Cell cell = ellipsoid_cell();
    const Shell shell = closed_shell(cell);
    const Solid solid = solid_of(shell, cell.faces.size());
    CHECK(solid.vertices.size() == 1);
    REQUIRE(solid.edges.size() == 1);
    CHECK(solid.faces.size() == 2);
    CHECK(solid.parts.size() == 1);
    CHECK(solid.off < 1e-12);
    const RationalCurve3& curve = solid.edges[0].curve;
    for (const Solid::Face& face : solid.faces)
        for (int k = 0; k <= 100; ++k) {
            const double t = curve.domain_begin() + (curve.domain_end() - curve.domain_begin()) * k / 100;
            const Vec2 uv = face.loops.at(0).at(0).curve.evaluate(t);
            const Vec3 p = curve.evaluate(t);
            CHECK((face.surface.evaluate(uv.x(), uv.y()) - p).norm() < 1e-12);
            // As far from the ball as from the wall.
            CHECK((p - Vec3(6, 3, 6)).norm() + (p - Vec3(2, 5, 4)).norm() ==
                  doctest::Approx(6).epsilon(1e-13));
        }
}

TEST_CASE("step: where the base runs through a corner of the box no edge is a point") {
    const std::pair<Plane, Box> cases[] = {{{{5, 5, 3}, {-2, -1, 2}}, {{3, 1, 3}, {7, 8, 11}}},
                                           {{{6, 7, 3}, {-2, 2, 1}}, {{-1, 1, 1}, {6, 8, 9}}},
                                           {{{1, 7, 3}, {-1, -2, 2}}, {{-1, 1, 1}, {2, 6, 5}}}};
    for (const auto& [base, box] : cases) {
        Scene scene;
        scene.base = base;
        scene.box = box;
        const Cell cell = voronoi_cell(scene);
        const Shell shell = closed_shell(cell);
        const Solid solid = solid_of(shell, cell.faces.size(), 1e-7);
        CHECK(solid.parts.size() == 1);
        CHECK(solid.off < 1e-9);
        CHECK(solid.vertices.size() + solid.faces.size() == solid.edges.size() + 2);
        for (const Solid::Edge& e : solid.edges) {
            CHECK(e.vertices[0] != e.vertices[1]);
            CHECK((solid.vertices[e.vertices[0]] - solid.vertices[e.vertices[1]]).norm() > 1e-3);
        }
        for_uses(solid, [&](const Solid::Face&, const Solid::Use& use, const Solid::Use& next) {
            check_follows(solid, use, next);
        });
    }
}

namespace {

// Loops are closed in space and in the parameters, and lie on the edges at the same parameter.
void check_loops(const Solid& solid) {
    for_uses(solid, [&](const Solid::Face& face, const Solid::Use& use, const Solid::Use& next) {
        check_follows(solid, use, next);
        const auto end = [](const Solid::Use& of, bool is_last) {
            return of.curve.evaluate(is_last == of.reversed ? of.curve.domain_begin()
                                                            : of.curve.domain_end());
        };
        CHECK((end(use, true) - end(next, false)).norm() < 1e-9);
        const RationalCurve3& curve = solid.edges[use.edge].curve;
        for (int k = 0; k <= 64; ++k) {
            const double t = curve.domain_begin() + (curve.domain_end() - curve.domain_begin()) * k / 64;
            const Vec2 uv = use.curve.evaluate(t);
            CHECK((face.surface.evaluate(uv.x(), uv.y()) - curve.evaluate(t)).norm() <= solid.off + 1e-12);
        }
    });
}

}  // namespace

TEST_CASE("step: a tip is a corner of caps, and no side of a patch is a point") {
    const Sphere ball{{0.25, 0.125, 0}, 0.25}, low{{1.25, 0.125, 0.1875}, 0.125};
    const Plane floor{{0, 0, 0}, {0, 0, 1}};
    const Vec3 apex(0, 0, -2), other_apex(-0.28, 0.13, -2), in_silo(0.25, 0, 0);
    struct Tips {
        Object base;
        std::vector<Object> objects;
        Vec3 on_axis, axis;
        std::size_t number, patches;
    };
    const auto tube = [](const Object& base, const Vec3& p, const Vec3& axis, double radius,
                         std::size_t number, const std::vector<Object>& others) {
        Tips tips{base, {HollowCylinder{p, axis, radius}}, p, axis, number, 3};
        tips.objects.insert(tips.objects.end(), others.begin(), others.end());
        return tips;
    };
    const auto cone = [](const Object& base, const Vec3& p, const Vec3& axis, double slant) {
        return Tips{base, {HollowCone{p, axis, 1, slant}}, p, axis, 2, 3};
    };
    // In the second cone the degrees of a patch were raised, so that its weights are positive.
    for (const Tips& tips :
         {tube(ball, {0, 0, 0}, {0.25, 0.375, 1}, 1, 2, {}), cone(ball, apex, {0.125, 0.25, 1}, 2),
          cone(Sphere{{0, -0.15, -0.15}, 0.3}, other_apex, {0.19, 0.2, 1}, 3),
          tube(floor, in_silo, {0.125, 0, 1}, 1.25, 1, {}),
          tube(floor, in_silo, {0, 0, 1}, 1.25, 1, {low})}) {
        Scene scene;
        scene.base = tips.base;
        scene.objects = tips.objects;
        scene.box = {Vec3::Constant(-3), Vec3::Constant(3)};
        const Cell cell = voronoi_cell(scene);
        std::size_t patches = 0, sides_at_tips = 0;
        for (const CellFace& face : cell.faces) {
            patches += face.patches.size();
            sides_at_tips += static_cast<std::size_t>(
                std::ranges::count_if(face.trims(), [](const TrimCurve& c) { return c.is_tip(); }));
        }
        CHECK(sides_at_tips == tips.number * tips.patches);
        const Shell shell = closed_shell(cell);
        const Solid solid = solid_of(shell, cell.faces.size());
        CHECK(solid.parts.size() == 1);
        CHECK(solid.off < 1e-6);
        CHECK(solid.vertices.size() + solid.faces.size() == solid.edges.size() + 2);
        CHECK(solid.faces.size() == patches + sides_at_tips + shell.faces.size() - cell.faces.size());
        check_loops(solid);
        std::size_t on_axis = 0;
        for (std::uint32_t v = 0; v < solid.vertices.size(); ++v) {
            if ((solid.vertices[v] - tips.on_axis).cross(tips.axis.normalized()).norm() > 1e-9) continue;
            ++on_axis;
            const auto meets = [&](const Solid::Edge& e) { return std::ranges::count(e.vertices, v); };
            CHECK(std::accumulate(solid.edges.begin(), solid.edges.end(), std::ptrdiff_t{0},
                                  [&](std::ptrdiff_t sum, const Solid::Edge& e) { return sum + meets(e); }) ==
                  static_cast<std::ptrdiff_t>(tips.patches));
        }
        CHECK(on_axis == tips.number);
        for (const Solid::Face& face : solid.faces)
            for (const Eigen::Vector4d& p : face.surface.points) CHECK(p.w() > 0);
    }
}

TEST_CASE("step: the uncertainty is 1e-7 mm at least, in whatever unit") {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.25};
    scene.objects = {Sphere{Vec3(0.5, 1, 1.25), 0.25}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    const std::map<std::string, std::string> least{
        {"mm", "1.E-07"}, {"m", "1.E-10"}, {"cm", "1.E-08"}, {"um", "0.0001"}, {"nm", "0.1"}};
    for (const auto& [unit, uncertainty] : least) {
        scene.units = unit;
        std::ostringstream out;
        write_step(out, voronoi_cell(scene));
        CHECK(out.str().find("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(" + uncertainty + "),") !=
              std::string::npos);
    }
}

TEST_CASE("spline surface: knots leave the patch where it is") {
    RationalPatch patch;
    patch.degree_u = 2;
    patch.domain_u = {-1, 3};
    for (const double w : {1.0, 0.05, 2.0})
        for (const double v : {0.0, 1.0}) patch.points.push_back({w * v, v, w - v, w * (1 + v)});
    const SplineSurface s = with_knots(patch, 1e-10);
    CHECK(s.knots_u.size() > 6);
    CHECK(s.points.size() + 3 == s.knots_u.size());
    CHECK(s.points[0].size() + 2 == s.knots_v.size());
    // A curve of the surface's first row is the patch's along v = v0.
    RationalCurve3 row;
    row.degree = 2;
    row.knots.assign(s.knots_u.begin(), s.knots_u.end());
    for (const auto& along_v : s.points) row.points.push_back(along_v.front());
    for (double u = -1; u <= 3; u += 0.125) CHECK((row.evaluate(u) - patch.evaluate(u, 0)).norm() < 1e-13);
    CHECK(with_knots(patch, 1e10).knots_u.size() == 6);
}

}  // namespace vcell
