// Cells of oblique tubes in one piece: what their parts have where they meet is one, and closes.
#include "../../io/solids/joined_parts.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "../../io/files/step_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/pictures/part_ends.hpp"
#include "../../io/pictures/trims.hpp"
#include "../../io/pictures/whole_elements.hpp"
#include "../../io/solids/solid.hpp"
#include "../random_tubes.hpp"
#include "../test_support.hpp"
#include "closed_meshes.hpp"
#include "complete_checks.hpp"

namespace vcell::joined_parts_test {
namespace {

Scene scene_of(const std::vector<Object>& objects, std::size_t base, const Box& box) {
    Scene scene;
    scene.base = objects[base];
    scene.objects = objects;
    scene.base_object = static_cast<std::uint32_t>(base);
    scene.box = box;
    return scene;
}

const Box cube{Vec3::Zero(), Vec3::Constant(10)};

/// How many trims are farther from their edges than these say, at places of the test's own. Edges bound it at
/// their places, between which there is next to nothing more.
std::size_t trims_off(const Cell& cell) {
    std::size_t count = 0;
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& c : loop) {
                    if (!c.edge) continue;
                    const CellEdge& e = cell.edges[*c.edge];
                    constexpr int steps = 41;
                    double off = 0;
                    for (int k = 0; k <= steps; ++k) {
                        const double s = static_cast<double>(k) / steps,
                                     t = (1 - s) * c.curve.domain_begin() + s * c.curve.domain_end();
                        const Vec2 uv = c.curve.evaluate(t);
                        off = std::max(off, (patch.surface.evaluate(uv.x(), uv.y()) -
                                             e.curve.evaluate(edge_parameter(c, e.curve, t)))
                                                .norm());
                    }
                    count += off > 1.5 * e.error + 1e-10;
                }
    return count;
}

/// Loops that do not go on where their last curve ended, in the patch's parameters.
std::size_t gaps(const Cell& cell, double most) {
    std::size_t count = 0;
    for (const CellFace& face : cell.faces)
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (std::size_t i = 0; i < loop.size(); ++i) {
                    const RationalCurve2 &c = loop[i].curve, &next = loop[(i + 1) % loop.size()].curve;
                    const Vec2 a = c.evaluate(c.domain_end()), b = next.evaluate(next.domain_begin());
                    count +=
                        (patch.surface.evaluate(a.x(), a.y()) - patch.surface.evaluate(b.x(), b.y())).norm() >
                        most;
                }
    return count;
}

/// Places of edges, on either side, where no trim begins with the parameter with which the one before ended.
std::size_t breaks(const Cell& cell) {
    using Side = std::pair<std::uint32_t, bool>;
    std::map<Side, std::vector<std::pair<double, double>>> trims;
    for (const CellFace& face : cell.faces)
        for (const TrimCurve& c : face.trims()) {
            if (!c.edge) continue;
            const RationalCurve3& edge = cell.edges[*c.edge].curve;
            const auto [from, to] = std::minmax({edge_parameter(c, edge, c.curve.domain_begin()),
                                                 edge_parameter(c, edge, c.curve.domain_end())});
            trims[{*c.edge, c.reversed}].emplace_back(from, to);
        }
    std::size_t count = 0;
    for (auto& [side, along] : trims) {
        const RationalCurve3& edge = cell.edges[side.first].curve;
        std::ranges::sort(along);
        double at = edge.domain_begin();
        const double rounding = 1e-14 * (edge.domain_end() - at);
        for (const auto& [from, to] : along) {
            count += std::abs(from - at) > rounding;
            at = to;
        }
        count += std::abs(edge.domain_end() - at) > rounding;
    }
    return count;
}

std::size_t ends(const Cell& cell) {
    const Shell shell = closed_shell(cell);
    return static_cast<std::size_t>(
        std::ranges::count_if(shell.faces, [](const CellFace& f) { return f.bisector == "end"; }));
}

void check_joined(const Cell& cell) {
    const double diagonal = cell.scene.box.diagonal(), most = 0x1p-20 * diagonal;
    const JoinedParts joined = joined_parts(cell);
    REQUIRE(joined.cell.parts.empty());
    CHECK(joined.cell.faces.size() == cell.faces.size());
    CHECK(ends(cell) > 0);
    CHECK(ends(joined.cell) == 0);
    CHECK(trims_off(joined.cell) == 0);
    CHECK(gaps(joined.cell, most) == 0);
    CHECK(breaks(joined.cell) == 0);
    // Joints are where parts end, and an edge goes on beyond each of their ends, or has its own there.
    const Vec3 axis = std::get<Cylinder>(cell.scene.base).axis.normalized();
    std::size_t joints = 0;
    for (std::size_t e = 0; e < joined.cell.edges.size(); ++e) {
        if (!joined.is_joint[e]) continue;
        ++joints;
        const RationalCurve3& curve = joined.cell.edges[e].curve;
        const double at = axis.dot(curve.evaluate(curve.domain_begin()));
        CHECK(std::abs(axis.dot(curve.evaluate(curve.domain_end())) - at) < 1e-6);
        CHECK(std::ranges::any_of(cell.parts, [&](const CellPart& part) {
            return std::ranges::any_of(part.ends,
                                       [&](const Vec3& end) { return std::abs(axis.dot(end) - at) < most; });
        }));
    }
    CHECK(joints > 0);
    const WholeElements whole(joined);
    std::size_t pieces = 0, most_pieces = 0;
    for (const WholeEdge& e : whole.edges) {
        pieces += e.pieces.size();
        most_pieces = std::max(most_pieces, e.pieces.size());
        for (std::size_t k = 1; k < e.pieces.size(); ++k) {
            const auto& before = e.pieces[k - 1];
            const auto& after = e.pieces[k];
            CHECK(joined.cell.edges[before.edge].vertices[before.reversed ? 0 : 1] ==
                  joined.cell.edges[after.edge].vertices[after.reversed ? 1 : 0]);
        }
    }
    CHECK(most_pieces > 1);
    CHECK(pieces + joints <= cell.edges.size());
    // As a solid each edge is used once each way (or solid_of() throws), and the surface is that of balls.
    const Shell shell = closed_shell(joined.cell);
    const Solid solid = solid_of(shell, joined.cell.faces.size(), 1e-7);
    CHECK(solid.off < most);
    std::vector<bool> is_end(solid.vertices.size(), false);
    std::size_t loops = 0;
    for (const Solid::Edge& e : solid.edges) is_end[e.vertices[0]] = is_end[e.vertices[1]] = true;
    for (const Solid::Face& f : solid.faces) loops += f.loops.size();
    const auto used = static_cast<std::size_t>(std::ranges::count(is_end, true));
    CHECK(used + 2 * solid.faces.size() == solid.edges.size() + loops + 2 * solid.parts.size());
    // Its mesh is closed, in as many pieces, and holds as much.
    MeshOptions options;
    options.closed = true;
    options.chord = 1e-3 * cell_diagonal(cell);
    const CellMesh mesh = tessellate(cell, options);
    CHECK(is_closed(mesh));
    const double bound = *options.chord * (cell.measures.area + cell.measures.box_area);
    CHECK(std::abs(volume(mesh) - cell.measures.volume) < bound + cell.measures.volume_error);
    std::vector<bool> has_triangle(mesh.points.size(), false);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t p : t) has_triangle[p] = true;
    CHECK(std::ranges::find(has_triangle, false) == has_triangle.end());
}

}  // namespace

TEST_CASE("joined parts: cells of random oblique tubes are solids without inner ends") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round) {
        const std::vector<Object> tubes = random_tubes(rng, 3, 0.3);
        for (std::size_t i = 0; i < tubes.size(); ++i) {
            CAPTURE(i);
            const Cell cell = complete_cell(scene_of(tubes, i, cube));
            // A tube that hardly comes into the box may have all of its cell in one part.
            const auto parts_with_faces =
                std::ranges::count_if(cell.parts, [](const CellPart& part) { return part.faces > 0; });
            if (parts_with_faces > 1) check_joined(cell);
        }
    }
}

TEST_CASE(
    "joined parts: where a part is no wider than a slab between edges of the box nothing is left of it") {
    const Cell cell = complete_cell(
        scene_of({Cylinder{{5, 6, 4}, {0, -2, -1}, 0}, Sphere{{8, 3, 3}, 0}}, 0, {{-1, 2, 2}, {6, 6, 6}}));
    check_joined(cell);
    std::ostringstream out;
    write_step(out, cell);
    const std::string file = out.str();
    const auto count = [&](const std::string& what) {
        std::size_t n = 0;
        for (std::size_t at = file.find(what); at != file.npos; at = file.find(what, at + 1)) ++n;
        return n;
    };
    CHECK(count("=CLOSED_SHELL(") == 1);
    CHECK(count("ADVANCED_FACE('end") == 0);
    CHECK(count("ADVANCED_FACE('0'") == count("ADVANCED_FACE('") - count("ADVANCED_FACE('box"));
}

TEST_CASE("joined parts: among balls and planes, in small integers") {
    const Box box{Vec3::Zero(), Vec3::Constant(8)};
    const std::vector<Object> tubes{Cylinder{{4, 6, 5}, {-1, 0, 2}, 0}, Cylinder{{2, 2, 6}, {1, 0, 2}, 1},
                                    Cylinder{{6, 7, 2}, {2, 1, 1}, 0.5}};
    for (std::size_t i = 0; i < tubes.size(); ++i) check_joined(complete_cell(scene_of(tubes, i, box)));
    check_joined(complete_cell(scene_of(
        {Cylinder{{3, 4, 4}, {1, 1, 0}, 0.5}, Sphere{{2, 6, 6}, 0.5}, Plane{{0, 0, 1}, {0, 0, 1}}}, 0, box)));
}

// The axes of the first two are a ninth of their diameter apart: the face between them is folded sharply and,
// as their radii differ, has more than a thousand patches, of which hundreds end along one joint.
TEST_CASE("joined parts: trims along a joint end where others begin, however many there are") {
    const std::vector<Object> tubes{Cylinder{{21.7, 42.2, 2.9}, {0.15, 0.81, -0.56}, 0.5},
                                    Cylinder{{23.1, 21.9, 46}, {0.09, -0.25, 0.96}, 0.4999},
                                    Cylinder{{33.3, 72.1, 71.1}, {-0.35, 0.86, -0.36}, 0.5},
                                    Cylinder{{83, 67, 30.3}, {-0.81, -0.5, 0.31}, 0.5},
                                    Cylinder{{58.9, 3.5, 24.3}, {-0.69, 0.21, -0.7}, 0.5}};
    const Cell cell = complete_cell(scene_of(tubes, 0, {Vec3::Zero(), Vec3::Constant(100)}));
    const JoinedParts joined = joined_parts(cell, 0x1p-16);
    CHECK(std::ranges::any_of(joined.cell.faces, [](const CellFace& f) { return f.patches.size() > 1000; }));
    CHECK(ends(joined.cell) == 0);
    CHECK(breaks(joined.cell) == 0);
    MeshOptions options;
    options.closed = true;
    options.chord = 0.02 * cell_diagonal(cell);
    CHECK(is_closed(tessellate(joined.cell, options)));
}

TEST_CASE("joined parts: what does not fit stays apart, and trims that are elsewhere are seen") {
    const std::vector<Object> tubes{Cylinder{{4, 6, 5}, {-1, 0, 2}, 0}, Cylinder{{2, 2, 6}, {1, 0, 2}, 1}};
    Cell cell = complete_cell(scene_of(tubes, 1, {Vec3::Zero(), Vec3::Constant(8)}));
    const std::size_t apart = ends(cell);
    const JoinedParts joined = joined_parts(cell);
    REQUIRE(ends(joined.cell) == 0);
    Cell damaged = joined.cell;
    const auto joint = std::ranges::find(joined.is_joint, true) - joined.is_joint.begin();
    for (Eigen::Vector4d& p : damaged.edges[static_cast<std::size_t>(joint)].curve.points) p[0] += 1e-3;
    CHECK(trims_off(damaged) > 0);
    // With another site somewhere around it a section is another one.
    for (CellFace& face : cell.faces)
        if (face.site == Site::object(0)) {
            face.site = Site::object(7);
            break;
        }
    CHECK(ends(joined_parts(cell).cell) > 0);
    CHECK(ends(joined_parts(cell).cell) < apart);
    CHECK(ends(joined_parts(cell, 0).cell) == apart);
}

TEST_CASE("joined parts: other cells stay as they are") {
    Scene scene = scene_of({Cylinder{{0, 0, 0}, {0, 1, 0}, 0.25}, Sphere{{1, 0, 1}, 0.25}}, 0,
                           {Vec3::Constant(-2), Vec3::Constant(2)});
    const Cell cell = complete_cell(scene);
    const JoinedParts joined = joined_parts(cell);
    CHECK(joined.cell.edges.size() == cell.edges.size());
    CHECK(std::ranges::none_of(joined.is_joint, [](bool is) { return is; }));
    CHECK(WholeElements(joined).edges.size() == WholeElements(cell).edges.size());
    CHECK(part_ends(scene.base, scene.box).empty());
}

TEST_CASE("part ends: a curve is met wherever it changes sides of a plane") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> coordinate(-1, 1), weight(0.5, 2);
    const auto random = [&] {
        const double x = coordinate(rng), y = coordinate(rng), z = coordinate(rng);
        return Vec3(x, y, z);
    };
    std::size_t found = 0;
    for (int round = 0; round < 40; ++round) {
        RationalCurve3 curve;
        curve.degree = 3;
        for (const double knot : {0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2}) curve.knots.push_back(knot);
        for (int i = 0; i < 7; ++i) {
            const Vec3 p = random();
            curve.points.push_back({p.x(), p.y(), p.z(), weight(rng)});
        }
        const Plane plane{0.5 * random(), random()};
        std::vector<double> at;
        add_crossings(curve, plane, at);
        const auto height = [&](double t) { return plane.normal.dot(curve.evaluate(t) - plane.point); };
        for (const double t : at) CHECK(std::abs(height(t)) < 1e-12);
        CHECK(std::ranges::is_sorted(at));
        // By brute force, on the same sixteen pieces.
        std::size_t changes = 0;
        for (int k = 0; k < 16; ++k) changes += (height(k / 8.0) > 0) != (height((k + 1) / 8.0) > 0);
        CHECK(at.size() == changes);
        found += changes;
    }
    CHECK(found > 20);
    const std::vector<Plane> planes = part_ends(Cylinder{{1, 1, 1}, {1, 2, 0}, 0.1}, cube);
    REQUIRE(planes.size() == 4);
    for (const Plane& plane : planes) {
        const auto is_on_side = [&](int k) {
            return std::abs(plane.point[k]) < 1e-12 || std::abs(plane.point[k] - 10) < 1e-12;
        };
        CHECK((is_on_side(0) || is_on_side(1)));
    }
}

}  // namespace vcell::joined_parts_test
