/// Cells of planes in hollow tubes and cones: their files, what certify() says of them, their meshes and
/// solids.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/measures/clearance_places.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/check/tips.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/svg.hpp"
#include "../../io/solids/moments.hpp"
#include "../envelope/vessel_oracle.hpp"
#include "closed_meshes.hpp"
#include "floors_in_tubes.hpp"
#include "hand_built_cells.hpp"
#include "listing.hpp"
#include "stored_diagrams.hpp"

namespace vcell {
namespace {

// The cell over a tube's rim, in four parts around the tip, with weights that the engine's patches have not.
// Pre: the tube is not level, and leans along x.
Cell built_by_hand(const Vessel& v) {
    Cell cell;
    cell.scene = floor_in(ground, {v.tube});
    const Vec3 axis = v.tube.axis.normalized(), middle = v.tube.point - v.tube.point.z() / axis.z() * axis,
               tip = middle + v.tube.radius / axis.z() * axis;
    const Site wall = Site::object(0);
    CellEdge rim;
    rim.sites = {wall, wall};
    rim.kind = v.rim;
    rim.curve.degree = 2;
    const RationalCurve2 circle = hand_built::circle(v.tube.radius);
    rim.curve.knots = circle.knots;
    for (const Eigen::Vector3d& p : circle.points)
        rim.curve.points.push_back({middle.x() + p.x() / axis.z(), middle.y() + p.y(), 0, p.z()});
    rim.error = 1e-15;
    rim.length = hand_built::length(rim.curve);
    rim.length_error = 1e-12;
    CellFace face;
    face.site = wall;
    face.bisector = v.bisector;
    face.area = v.area;
    face.area_error = 1e-13;
    const std::array<Vec2, 4> corners{Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
    for (std::uint32_t i = 0; i < 4; ++i) {
        TrimmedPatch& patch = face.patches.emplace_back();
        patch.surface.degree_u = 2;
        patch.surface.degree_v = 1;
        patch.surface.domain_u = patch.surface.domain_v = {0, 1};
        for (std::size_t k = 2 * i; k <= 2 * i + 2; ++k) {
            patch.surface.points.push_back(rim.curve.points[k]);
            patch.surface.points.push_back({tip.x(), tip.y(), tip.z(), rim.curve.points[k][3]});
        }
        std::vector<TrimCurve>& loop = patch.loops.emplace_back();
        for (std::size_t k = 0; k < 4; ++k)
            loop.push_back({{}, {}, false, hand_built::segment(corners[k], corners[(k + 1) % 4])});
        loop[0].edge = 0;
        for (double& knot : loop[0].curve.knots) knot += i;
        loop[1].seam = (i + 1) % 4;
        loop[3].seam = i;
    }
    cell.edges.push_back(std::move(rim));
    cell.faces.push_back(std::move(face));
    cell.neighbors = {0};
    Measures& m = cell.measures;
    m.volume = v.volume;
    m.area = v.area;
    m.box_area = m.body_volume = m.min_clearance = 0;
    m.base_area = v.base_area;
    m.max_clearance = v.highest;
    hand_built::set_errors(m, 1e-13);
    return cell;
}

// How high the cell is over a point of the base, by distances alone; none where there is none of it.
std::optional<double> height_by_distances(const Scene& scene, const Vec3& foot, const Vec3& up) {
    const auto is_in = [&](double t) {
        const Vec3 p = foot + t * up;
        return vessel_oracle::inside_box(scene.box, p) >= 0 &&
               std::ranges::all_of(scene.objects,
                                   [&](const Object& o) { return vessel_oracle::away(o, p) >= t; });
    };
    if (!is_in(0)) return std::nullopt;
    double low = 0, high = scene.box.diagonal();
    for (int i = 0; i < 45; ++i) (is_in(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return low;
}

// By a rule of points on a square grid, which is off by about its step where the region ends.
void check_by_distances(const Cell& cell) {
    const Scene& scene = cell.scene;
    const auto& base = std::get<Plane>(scene.base);
    const Vec3 up = base.normal.normalized(), x = up.unitOrthogonal(), y = up.cross(x);
    constexpr int rows = 160;
    const double size = 0.5 * scene.box.diagonal(), step = 2 * size / rows;
    const Vec3 middle = 0.5 * (scene.box.min + scene.box.max),
               origin = middle - up.dot(middle - base.point) * up;
    double volume_over = 0, base_area = 0, highest = 0;
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < rows; ++k) {
            const Vec3 foot = origin + (-size + (i + 0.5) * step) * x + (-size + (k + 0.5) * step) * y;
            const auto height = height_by_distances(scene, foot, up);
            if (!height) continue;
            volume_over += step * step * *height;
            base_area += step * step;
            highest = std::max(highest, *height);
        }
    const Measures& m = cell.measures;
    CHECK(m.volume == doctest::Approx(volume_over).epsilon(0.015));
    CHECK(m.base_area == doctest::Approx(base_area).epsilon(0.015));
    CHECK(m.max_clearance >= highest - m.max_clearance_error - 1e-9);
    CHECK(m.max_clearance == doctest::Approx(highest).epsilon(0.02));
}

void check_mesh(const Cell& cell) {
    const CellMesh mesh = tessellate(cell, {std::nullopt, true});
    CHECK(is_closed(mesh));
    CHECK(volume(mesh) == doctest::Approx(cell.measures.volume).epsilon(0.02));
    const Solid solid = solid_of(closed_shell(cell), cell.faces.size());
    CHECK(solid.parts.size() == 1);
    CHECK(solid.off < 1e-5);
    // What is a tip is a corner of triangles.
    const check::Space<Interval> space(cell.scene);
    for (const CellFace& face : cell.faces) {
        const auto trims = face.trims();
        if (std::ranges::none_of(trims, [](const TrimCurve& c) { return c.is_tip(); })) continue;
        const std::vector<check::Tip> tips = check::tips_of(space, cell.scene.objects[face.site.index]);
        REQUIRE(tips.size() == 1);
        const Vec3 tip = check::middle(tips[0].p);
        CHECK(std::ranges::any_of(mesh.points, [&](const Vec3& p) { return (p - tip).norm() < 1e-9; }));
    }
}

// What files of cells have if they are asked for it.
Cell with_places(Cell cell) {
    cell.clearance_places = clearance_places(cell);
    cell.moments = moments_of(cell);
    return cell;
}

// In the picture a face's outline is that on the base, however many patches it has, and edges are whole.
void check_picture(const Cell& cell) {
    std::ostringstream out;
    write_svg(out, cell);
    const std::string picture = out.str();
    const auto count = [&](const std::string& what) {
        std::size_t found = 0;
        for (std::size_t at = 0; (at = picture.find(what, at)) != std::string::npos; ++at) ++found;
        return found;
    };
    CHECK(count("class=\"face") == cell.faces.size());
    CHECK(count("class=\"edge") == cell.edges.size());
    // A rim has a face on one side alone.
    std::vector<std::array<bool, 2>> sides(cell.edges.size(), {false, false});
    for (const CellFace& face : cell.faces)
        for (const TrimCurve& c : face.trims())
            if (c.edge) sides[*c.edge][c.reversed ? 1 : 0] = true;
    const auto is_rim = [](const std::array<bool, 2>& side) { return side[0] != side[1]; };
    CHECK(count("class=\"edge rim") == static_cast<std::size_t>(std::ranges::count_if(sides, is_rim)));
}

// As wide as it is on a level base, with a hundredth of the larger extent on either side.
void check_width(const Cell& cell, const Vec2& extent) {
    std::ostringstream out;
    write_svg(out, cell);
    const std::string start = "viewBox=\"";
    std::istringstream box(out.str().substr(out.str().find(start) + start.size()));
    double x = 0, y = 0, width = 0;
    box >> x >> y >> width;
    CHECK(width == doctest::Approx(extent.x() + 0.02 * extent.maxCoeff()).epsilon(1e-3));
}

bool has_tip(const Cell& cell) {
    return std::ranges::any_of(cell.faces, [](const CellFace& face) {
        return std::ranges::any_of(face.trims(), [](const TrimCurve& c) { return c.is_tip(); });
    });
}

bool is_refuted_at(const Certificate& c, const std::string& where) {
    return std::ranges::any_of(c.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && e.where.starts_with(where);
    });
}

// Upright, leaning and level tubes with what else bounds cells; whether a face holds a tip.
struct Furnished {
    Scene scene;
    bool has_tip;
};

std::vector<Furnished> furnished() {
    const HollowCylinder silo{{0.25, 0, 0}, {0, 0, 1}, 1.25}, leaning{{0, 0, 0}, {0.25, -0.125, 1}, 1.25},
        pipe{{0, 0, 0.375}, {1, 0.25, 0}, 1.25};
    const Sphere ball{{0.875, 0.25, 0.5}, 0.25}, other{{-0.5, 0.125, 0.5}, 0.25},
        under_tip{{0.25, 0, 0.75}, 0.25};
    // Near enough to the wall and the floor to leave the tip to the silo.
    const Sphere low{{1.25, 0.125, 0.1875}, 0.125}, lower{{1.125, 0, 0.125}, 0.0625},
        left{{-0.875, 0.25, 0.1875}, 0.125}, on_slope{{1.25, -0.25, 0.25}, 0.0625};
    const Plane lid{{0, 0, 1}, {0.25, 0, 1}};
    const Cylinder rod{{0, 0.5, 0.5}, {1, 0.5, 0.125}, 0.125};
    const Plane slope{{0, 0, 0.125}, {0.125, 0.25, 1}};
    const HollowCone hopper{{0.25, 0, -1}, {0, 0, 1}, 3, 5}, roof{{0.25, 0, 1.5}, {0.125, 0, -1}, 3, 5},
        lying{{-1.5, 0, 0.25}, {1, 0.25, 0.125}, 4, 5}, funnel{{0, 0, -1.25}, {0.125, 0.25, 1}, 5, 8};
    const Sphere under_hopper{{0.90625, 0, 0.0625}, 0.03125};
    return {
        {floor_in(ground, {silo, low}), true},
        {floor_in(ground, {silo, ball}), false},
        {floor_in(ground, {silo, ball, other, under_tip}), false},
        {floor_in(ground, {silo, lid}), false},
        {floor_in(ground, {leaning, lower, left}), true},
        {floor_in(ground, {pipe, ball, lid}), false},
        {floor_in(slope, {silo, on_slope}), true},
        {floor_in(slope, {leaning, other, Sphere{{0.5, -0.5, 1}, 0.25}}), false},
        {floor_in(slope, {HollowCylinder{{0, 0, 0.375}, {1, -0.5, 0}, 1.25}, other}), false},
        {floor_in(ground, {silo, HollowCylinder{{-0.25, 0.125, 0}, {0.125, 0, 1}, 1.25}}), false},
        {floor_in(ground, {silo, pipe, ball}), false},
        {floor_in(ground, {leaning, HollowSphere{{-0.25, 0, 0.25}, 1.25}, ball}), false},
        {floor_in(ground, {silo, rod}), false},
        {floor_in(ground, {hopper, under_hopper}), true},
        {floor_in(ground, {hopper, ball, other}), false},
        {floor_in(ground, {roof, under_hopper}), true},
        {floor_in(ground, {roof, silo, ball}), false},
        {floor_in(ground, {lying, ball, other}), true},
        {floor_in(ground, {funnel, other}), false},
        {floor_in(ground, {HollowCone{{-1, 0, -0.5}, {4, 0, 3}, 3, 5}, ball, lid}), false},
        {floor_in(ground, {HollowCone{{-1, 0.25, 0.75}, {4, 0, -3}, 3, 5}, other}), false},
        {floor_in(slope, {hopper, leaning, other}), false},
        {floor_in(slope, {HollowCone{{0.25, 0, 1.75}, {0.25, 0, -1}, 3, 5}, lower}), true},
    };
}

}  // namespace

TEST_CASE("planes in tubes: cones around their tips that no lift has made are certified and closed") {
    for (const Vessel& v : lone_vessels()) {
        if (v.rim == CurveKind::Line) continue;
        CAPTURE(std::string(v.bisector));
        const Cell cell = built_by_hand(v);
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));
        check_mesh(cell);
        check_picture(cell);
        check_width(cell, {2 / v.tube.axis.normalized().z(), 2});
        Cell bad = cell;
        std::get<HollowCylinder>(bad.scene.objects[0]).radius += 1e-9;
        CHECK(is_refuted_at(certify(bad), "edges[0]"));
        bad = cell;
        bad.measures.base_area *= 1 + 1e-11;
        CHECK(is_refuted_at(certify(bad), "measures.base_area"));
        bad = cell;
        bad.measures.volume *= 1 - 1e-11;
        CHECK(is_refuted_at(certify(bad), "measures.volume"));
        bad = cell;
        bad.measures.max_clearance *= 1 + 1e-11;
        CHECK(is_refuted_at(certify(bad), "measures.max_clearance"));
        bad = cell;
        for (std::size_t k : {1, 3, 5}) bad.faces[0].patches[2].surface.points[k].z() += 1e-3;
        CHECK(is_refuted_at(certify(bad), "faces[0].patches[2]"));
        bad = cell;
        bad.faces[0].patches.pop_back();
        CHECK_FALSE(certify(bad).holds());
        // However small the region is in the box, rays are found that start in it.
        bad = cell;
        bad.scene.box = {Vec3::Constant(-64), Vec3::Constant(64)};
        bad.measures.volume *= 2;
        const Certificate small = certify(bad);
        CHECK(is_refuted_at(small, "measures.volume"));
        CHECK_MESSAGE(!is_refuted_at(small, "scene.box"), listing(small));
    }
}

void check_written(const Cell& cell) {
    std::stringstream file;
    write_cell(file, cell);
    const Certificate good = certify(parse_cell(file.str()));
    CHECK_MESSAGE(good.holds(), listing(good));
}

TEST_CASE("planes in tubes: alone a floor has a cone or an arch, as large as it is by hand") {
    for (const Vessel& v : lone_vessels()) {
        CAPTURE(std::string(v.bisector));
        const Cell cell = with_places(voronoi_cell(floor_in(ground, {v.tube})));
        const Measures& m = cell.measures;
        const auto check = [](double value, double error, double truth) {
            CHECK(std::abs(value - truth) <= error + 1e-14);
            CHECK(error < 1e-6);
        };
        check(m.base_area, m.base_area_error, v.base_area);
        check(m.volume, m.volume_error, v.volume);
        check(m.area, m.area_error, v.area);
        check(m.max_clearance, m.max_clearance_error, v.highest);
        check(m.min_clearance, m.min_clearance_error, 0);
        REQUIRE(cell.faces[0].site == Site::object(0));
        CHECK(cell.faces[0].bisector == v.bisector);
        CHECK(has_tip(cell) == (v.rim != CurveKind::Line));
        const auto rim =
            std::ranges::find_if(cell.edges, [](const CellEdge& e) { return e.sites[0] == e.sites[1]; });
        REQUIRE(rim != cell.edges.end());
        CHECK((rim->kind == v.rim || rim->kind == CurveKind::Spline));

        check_written(cell);
        check_mesh(cell);
        check_picture(cell);
    }
}

TEST_CASE("planes in tubes: cells among balls, planes, tubes and other vessels are certified and closed") {
    const std::vector<Furnished> all = furnished();
    for (std::size_t i = 0; i < all.size(); ++i) {
        CAPTURE(i);
        const Cell cell = with_places(voronoi_cell(all[i].scene));
        check_by_distances(cell);
        CHECK(has_tip(cell) == all[i].has_tip);
        check_written(cell);
        check_mesh(cell);
        check_picture(cell);
    }
}

TEST_CASE("planes in tubes: random floors among balls in random vessels are certified and closed") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto vector = [&](double size) -> Vec3 { return size * Vec3(unit(rng), unit(rng), unit(rng)); };
    int undecided = 0, empty = 0;
    const int rounds = long_rounds(24);
    for (int round = 0; round < rounds; ++round) {
        CAPTURE(round);
        const Plane base{vector(0.3), round % 3 == 0 ? Vec3(Vec3::UnitZ()) : vector(1)};
        Scene scene = floor_in(base, {});
        for (int i = 0; i <= round % 2; ++i) {
            const std::array axes{Vec3(base.normal), Vec3(base.normal.cross(vector(1))), vector(1),
                                  vector(1)};
            scene.objects.emplace_back(
                HollowCylinder{vector(0.4), axes[(round / 2 + i) % 4], 1.25 + 0.25 * unit(rng)});
        }
        if (round % 5 == 4) scene.objects.emplace_back(HollowSphere{vector(0.4), 1.5});
        if (round % 4 == 3) {
            const Vec3 axis = round % 8 == 3 ? Vec3(base.normal.normalized()) : vector(1).normalized();
            scene.objects[0] = HollowCone{vector(0.4) - axis, axis, 2 + unit(rng), 3.25};
        }
        for (int balls = round % 7; balls > 0;) {
            const Sphere ball{vector(1.25), 0.1875 + 0.0625 * unit(rng)};
            if (vessel_oracle::away(base, ball.center) < 1.0625 * ball.radius) continue;
            scene.objects.emplace_back(ball);
            --balls;
        }
        try {
            const Cell cell = with_places(voronoi_cell(scene));
            const Certificate good = certify(cell);
            CHECK_MESSAGE(good.count(Verdict::refuted) == 0, listing(good));
            CHECK_MESSAGE(good.count(Verdict::open) <= 1, listing(good));
            check_mesh(cell);
            check_picture(cell);
        } catch (const UndecidedError&) {
            ++undecided;  // an edge may run next to a tip
        } catch (const InputError& e) {
            CHECK(e.kind == InputError::Kind::EmptyBox);
            ++empty;  // a cone holds none of the base
        }
    }
    CHECK(undecided <= rounds / 8);
    CHECK(empty <= rounds / 16);
}

// The least of all heights over the tip is a clearance, whether or not the tip is there.
TEST_CASE("planes in tubes: where something touches the tip the largest clearance is known as well") {
    for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(-1, 0, 1)}) {
        CAPTURE(axis.transpose());
        Scene scene = floor_in(ground, {HollowCylinder{{0, 0, 0}, axis, 1}, Plane{{0, 0, 2}, {0, 0, 1}}});
        scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
        const Cell cell = voronoi_cell(scene);
        CHECK(std::abs(cell.measures.max_clearance - 1) <= cell.measures.max_clearance_error);
        CHECK(cell.measures.max_clearance_error < 1e-12);
        check_written(cell);
    }
}

// The tip of what is all but a parabolic cylinder is as far away as the axis is level.
TEST_CASE("planes in tubes: the less a tube leans from being level the farther away the tip is") {
    const Vessel level = lone_vessels()[2];
    for (const double lean : {0x1p-16, 0x1p-30, 0x1p-49, -0x1p-60}) {
        CAPTURE(lean);
        HollowCylinder tube = level.tube;
        tube.axis.z() = lean;
        const Cell cell = voronoi_cell(floor_in(ground, {tube}));
        CHECK(cell.faces[0].bisector == std::string("elliptic cone"));
        CHECK_FALSE(has_tip(cell));
        CHECK(cell.measures.volume == doctest::Approx(level.volume).epsilon(4 * std::abs(lean) + 1e-12));
        const Certificate good = certify(cell);
        CHECK_MESSAGE(good.holds(), listing(good));
    }
}

TEST_CASE("planes in tubes: complete cells of floors that lean are certified") {
    CellOptions options;
    options.complete = true;
    Scene scene = furnished()[6].scene;
    scene.box.min.z() = -0.25;
    const Cell cell = voronoi_cell(scene, options);
    CHECK(cell.is_complete);
    const Certificate good = certify(cell);
    CHECK_MESSAGE(good.holds(), listing(good));
}

TEST_CASE("planes in tubes: damage is refuted") {
    const Cell cell = voronoi_cell(furnished()[0].scene);
    const auto expect = [&](const std::string& where, const std::function<void(Cell&)>& damage) {
        Cell bad = cell;
        damage(bad);
        const Certificate c = certify(bad, {50, 1, 8});
        CHECK_MESSAGE(is_refuted_at(c, where), "expected ", where, ", found\n", listing(c));
    };
    const auto number_of = [](const auto& all, const auto& is_meant) {
        const auto found = std::ranges::find_if(all, is_meant);
        REQUIRE(found != all.end());
        return static_cast<std::size_t>(found - all.begin());
    };
    const std::size_t rim = number_of(cell.edges, [](const CellEdge& e) { return e.sites[0] == e.sites[1]; });
    const std::string at_rim = "edges[" + std::to_string(rim);
    expect(at_rim, [&](Cell& bad) {
        for (Eigen::Vector4d& p : bad.edges[rim].curve.points) p.x() = 0.25 + 0.999 * (p.x() - 0.25);
    });
    expect(at_rim, [&](Cell& bad) {
        for (Eigen::Vector4d& p : bad.edges[rim].curve.points) p.z() += 1e-6;
    });
    expect(at_rim, [&](Cell& bad) { bad.edges[rim].kind = CurveKind::Parabola; });
    // All of the wall is elsewhere than where the faces end, or leans.
    const auto wall = [](Cell& bad) -> HollowCylinder& {
        return std::get<HollowCylinder>(bad.scene.objects[0]);
    };
    expect(at_rim, [&](Cell& bad) { wall(bad).radius += 1e-6; });
    expect(at_rim, [&](Cell& bad) { wall(bad).axis.x() = 1e-3; });
    expect("measures.base_area", [](Cell& bad) { bad.measures.base_area *= 1 + 1e-9; });
    expect("measures.volume", [](Cell& bad) { bad.measures.volume *= 1 + 1e-5; });
    expect("measures.area", [](Cell& bad) { bad.measures.area *= 1 - 1e-5; });
    expect("measures.max_clearance", [](Cell& bad) { bad.measures.max_clearance *= 0.999; });
    expect("measures.max_clearance", [](Cell& bad) { bad.measures.max_clearance *= 1.001; });
    expect("measures.min_clearance", [](Cell& bad) { bad.measures.min_clearance = 1e-6; });
    expect("measures.touches_box", [](Cell& bad) { bad.measures.touches_box = true; });

    // The face about the tip: what is not on the bisector there, and one of its parts missing.
    const std::size_t face =
        number_of(cell.faces, [](const CellFace& f) { return f.site == Site::object(0); });
    const std::string at_face = "faces[" + std::to_string(face);
    const auto is_at_tip = [](const Eigen::Vector4d& p) {
        return (p.head<3>() - Vec3(0.25, 0, 1.25)).norm() < 1e-9;
    };
    const std::size_t patch = number_of(cell.faces[face].patches, [&](const TrimmedPatch& p) {
        return std::ranges::any_of(p.surface.points, is_at_tip);
    });
    const auto points_of = [&](Cell & bad) -> auto& { return bad.faces[face].patches[patch].surface.points; };
    const std::size_t tip = number_of(cell.faces[face].patches[patch].surface.points, is_at_tip);
    expect(at_face, [&](Cell& bad) { points_of(bad)[tip].z() += 1e-3; });
    expect(at_face, [&](Cell& bad) {
        for (Eigen::Vector4d& p : points_of(bad)) p.z() += 1e-5;
    });
    expect("", [&](Cell& bad) { bad.faces[face].patches.pop_back(); });
    expect(at_face, [&](Cell& bad) { bad.faces[face].bisector = "elliptic cone"; });
    // A ball in the midst of it.
    expect(at_face, [](Cell& bad) { bad.scene.objects.push_back(Sphere{{0.25, 0, 1}, 0.25}); });
}

TEST_CASE("planes in tubes: a diagram of balls over a floor in a silo is proved") {
    DiagramScene scene;
    scene.objects = {Plane{{0, 0, -0.5}, {0.25, 0, 1}}, HollowCylinder{{0, 0, 0}, {0, 0, 1}, 1.5},
                     Sphere{{0.25, 0, 0.5}, 0.375}, Sphere{{-0.5, 0.25, 0.25}, 0.25}};
    scene.box = {Vec3::Constant(-1.75), Vec3::Constant(1.75)};
    const StoredDiagram diagram = stored(scene, true);
    CHECK(std::ranges::count_if(diagram.cells, [](const auto& c) { return c.first == 0; }) == 2);
    check_proved(certify(diagram));
}

}  // namespace vcell
