// What two cells of a diagram share is the same triangles in both, number for number, so that what is left of
// all triangles when those are taken away bounds the box.
#include "../../io/pictures/conforming_meshes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "../../io/files/diagram_file.hpp"
#include "../../io/pictures/diagram_pictures.hpp"
#include "../random_tubes.hpp"
#include "../test_support.hpp"
#include "closed_meshes.hpp"

namespace vcell {
namespace {

/// All meshes of a diagram, as triangles in space.
struct Soup {
    struct Facet {
        std::array<Vec3, 3> corners;
        std::uint32_t cell;
        Site beyond;
    };
    DiagramScene scene;
    VoronoiDiagram diagram;
    std::vector<Facet> facets;
    std::map<std::uint32_t, double> volumes;  // of each object's meshes
    std::size_t not_closed = 0, drawn_again = 0, doubled_sides = 0, turned_over = 0;
    double most_beyond = 0;  // the box

    bool has_cell(const Site& site) const {
        return site.is_object() && diagram.cells[site.index].state == DiagramCell::State::Computed;
    }
};

// Sides that more than one triangle has in the same direction.
std::size_t doubled_sides(const CellMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
    return static_cast<std::size_t>(std::ranges::count_if(count, [](const auto& c) { return c.second > 1; }));
}

// Triangles of some extent that look the other way than the surface at their corners.
std::size_t turned_over(const CellMesh& mesh) {
    std::size_t count = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vec3 across = (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]);
        Vec3 normal = Vec3::Zero();
        for (const std::uint32_t n : mesh.corner_normals[t]) normal += mesh.normals[n];
        constexpr double extent = 1e-5;
        count += across.norm() > extent && across.dot(normal) < 0;
    }
    return count;
}

template <class MeshOf>
Soup soup_of(const DiagramScene& scene, MeshOf&& mesh_of) {
    Soup soup;
    soup.scene = scene;
    DiagramOptions options;
    options.complete = true;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        const CellMesh mesh = mesh_of(object, cell);
        if (!is_closed(mesh)) ++soup.not_closed;
        soup.volumes[object] += volume(mesh);
        soup.doubled_sides += doubled_sides(mesh);
        soup.turned_over += turned_over(mesh);
        for (const Vec3& p : mesh.points)
            soup.most_beyond =
                std::max({soup.most_beyond, (scene.box.min - p).maxCoeff(), (p - scene.box.max).maxCoeff()});
        for (const CellMesh::Group& g : mesh.groups)
            for (std::size_t t = g.begin; t < g.end; ++t) {
                const auto& [a, b, c] = mesh.triangles[t];
                const bool is_face = g.kind == CellMesh::Group::Kind::Face;
                soup.facets.push_back({{mesh.points[a], mesh.points[b], mesh.points[c]},
                                       object,
                                       is_face ? g.site : Site::base()});
            }
    };
    soup.diagram = voronoi_diagram(scene, options);
    return soup;
}

Soup conforming(const DiagramScene& scene) {
    ConformingMeshes meshes(scene);
    Soup soup =
        soup_of(scene, [&](std::uint32_t object, const Cell& cell) { return meshes.add(object, cell); });
    soup.drawn_again = meshes.drawn_again();
    return soup;
}

using Numbers = std::array<double, 9>;

// The corners in the order in which they follow each other, the least first.
template <class Place>
Numbers key_of(std::array<Vec3, 3> corners, bool is_turned, Place&& place) {
    std::array<std::array<double, 3>, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 at = place(corners[is_turned ? 2 - k : k]);
        p[k] = {at.x(), at.y(), at.z()};
    }
    // Two corners may have one place.
    auto least = p;
    for (int k = 0; k < 2; ++k) {
        std::ranges::rotate(p, p.begin() + 1);
        least = std::min(least, p);
    }
    p = least;
    return {p[0][0], p[0][1], p[0][2], p[1][0], p[1][1], p[1][2], p[2][0], p[2][1], p[2][2]};
}

// How many triangles between two cells have no counterpart in the other one: exactly, or where the box
// repeats, at the same place of one copy of it but for rounding.
std::size_t lone_triangles(const Soup& soup) {
    const Eigen::Matrix3d edges = soup.scene.edges(), to_unit = edges.inverse();
    const auto place = [&](const Vec3& p) -> Vec3 {
        if (!soup.scene.is_periodic()) return p;
        constexpr double cells = 1e8;
        Vec3 unit = to_unit * p;
        for (int k = 0; k < 3; ++k) {
            // Off the grid, so that places on faces of the box are not rounded both ways.
            unit[k] = std::floor(cells * unit[k] + 0.3125);
            if (soup.scene.periodic[k]) unit[k] -= cells * std::floor(unit[k] / cells);
        }
        return unit;
    };
    using Pair = std::pair<std::uint32_t, std::uint32_t>;
    std::map<std::pair<Numbers, Pair>, int> count;
    for (const Soup::Facet& f : soup.facets) {
        if (!soup.has_cell(f.beyond)) continue;
        const Pair pair(f.cell, f.beyond.index);
        ++count[{key_of(f.corners, false, place), pair}];
        --count[{key_of(f.corners, true, place), {pair.second, pair.first}}];
    }
    return static_cast<std::size_t>(std::ranges::count_if(count, [](const auto& c) { return c.second > 0; }));
}

// Of triangles on sides of the box, and towards what has no cell.
double outer_volume(const Soup& soup) {
    double six = 0;
    for (const Soup::Facet& f : soup.facets)
        if (!soup.has_cell(f.beyond)) six += f.corners[0].dot(f.corners[1].cross(f.corners[2]));
    return six / 6;
}

double all_volume(const Soup& soup) {
    double sum = 0;
    for (const auto& [object, volume] : soup.volumes) sum += volume;
    return sum;
}

// Points that are one but for rounding, and have different numbers in different cells. (A cell may have some
// that are as near to each other, along a curve that is run through unevenly.)
std::size_t doubled_points(const Soup& soup) {
    std::map<std::array<double, 3>, std::set<std::uint32_t>> cells;
    for (const Soup::Facet& f : soup.facets)
        for (const Vec3& p : f.corners) cells[{p.x(), p.y(), p.z()}].insert(f.cell);
    constexpr double near = 1e-11;
    std::size_t count = 0;
    for (auto a = cells.begin(); a != cells.end(); ++a)
        for (auto b = std::next(a); b != cells.end() && b->first[0] - a->first[0] < near; ++b) {
            const auto is_near = [&](std::size_t k) { return std::abs(b->first[k] - a->first[k]) < near; };
            const auto has_both = [&](std::uint32_t cell) { return b->second.contains(cell); };
            count += is_near(1) && is_near(2) && std::ranges::none_of(a->second, has_both);
        }
    return count;
}

double box_volume(const DiagramScene& scene) { return scene.edges().determinant(); }

// All that is asked for where all cells are there.
void check_fits(const DiagramScene& scene, double of_volume = 1e-12) {
    const Soup soup = conforming(scene);
    CHECK(soup.not_closed == 0);
    CHECK(soup.doubled_sides == 0);
    CHECK(soup.drawn_again == 0);
    REQUIRE(soup.facets.size() > 0);
    CHECK(lone_triangles(soup) == 0);
    CHECK(all_volume(soup) == doctest::Approx(box_volume(scene)).epsilon(of_volume));
    if (!scene.is_periodic()) {
        CHECK(outer_volume(soup) == doctest::Approx(box_volume(scene)).epsilon(of_volume));
        CHECK(doubled_points(soup) == 0);
    }
    for (const auto& [object, of_mesh] : soup.volumes) {
        CAPTURE(object);
        // Chords all over the surface of a cell that is a third as high as it is long.
        CHECK(of_mesh == doctest::Approx(soup.diagram.cells[object].volume).epsilon(0.06));
    }
}

DiagramScene scene_of(std::vector<Object> objects, const Box& box) {
    DiagramScene scene;
    scene.objects = std::move(objects);
    scene.box = box;
    return scene;
}

std::vector<Object> random_balls(std::mt19937_64& rng, int count, double most_radius) {
    std::uniform_real_distribution<double> place(0, 10), radius(0, most_radius);
    std::vector<Object> balls;
    for (int i = 0; i < count; ++i) {
        const double x = place(rng), y = place(rng), z = place(rng);
        balls.push_back(Sphere{{x, y, z}, radius(rng)});
    }
    return balls;
}

/// Places of small integers, in a random order.
template <class IsPlace>
std::vector<Object> lattice(std::mt19937_64& rng, int size, double radius, IsPlace&& is_place) {
    std::vector<Object> balls;
    for (int x = 0; x < size; ++x)
        for (int y = 0; y < size; ++y)
            for (int z = 0; z < size; ++z)
                if (is_place(x, y, z)) balls.push_back(Sphere{Vec3(x, y, z), radius});
    std::ranges::shuffle(balls, rng);
    return balls;
}

bool is_simple_place(int, int, int) { return true; }
bool is_face_centred(int x, int y, int z) { return (x + y + z) % 2 == 0; }
bool is_body_centred(int x, int y, int z) { return x % 2 == y % 2 && y % 2 == z % 2; }

}  // namespace

TEST_CASE("conforming meshes: cells of balls in a box share all triangles and fill it") {
    std::mt19937_64 rng(test_seed());
    const Box box{Vec3::Constant(-1), {11, 11.5, 12}};
    for (int round = 0; round < rounds(); ++round) {
        check_fits(scene_of(random_balls(rng, 40, 0.8), box));
        check_fits(scene_of(random_balls(rng, 12, 0), box));
        check_fits(scene_of(random_balls(rng, 2, 0.5), box));
    }
    DiagramScene molecule = read_diagram_scene(test_data("1CRN.xyzr"));
    molecule.objects.resize(50);
    molecule.names.clear();
    molecule.groups.clear();
    check_fits(molecule);
}

TEST_CASE("conforming meshes: a large ball's cell has faces that are fine enough for small ones") {
    std::mt19937_64 rng(test_seed());
    std::vector<Object> balls{Sphere{{5, 5, -24}, 24}};
    for (const Object& small : random_balls(rng, 20, 0.05))
        balls.push_back(Sphere{0.1 * std::get<Sphere>(small).center + Vec3(4, 4, 0.2), 0.05});
    check_fits(scene_of(balls, {{0, 0, -30}, {10, 10, 10}}));
}

TEST_CASE("conforming meshes: closed edges without vertices") {
    // A small ball between two large ones has two faces and one edge; of the large ones' face it is a hole.
    const std::vector<Object> balls{Sphere{{0, 0, 0}, 1}, Sphere{{4, 0, 0}, 1}, Sphere{{2, 0.1, 0}, 0.05}};
    for (const auto& order : {std::array{0, 1, 2}, std::array{2, 1, 0}, std::array{1, 2, 0}}) {
        std::vector<Object> ordered;
        for (const int i : order) ordered.push_back(balls[static_cast<std::size_t>(i)]);
        const DiagramScene scene = scene_of(ordered, {Vec3::Constant(-6), Vec3::Constant(10)});
        std::size_t closed_edges = 0;
        DiagramOptions options;
        options.visit = [&](std::uint32_t, const Cell& cell) {
            for (const CellEdge& e : cell.edges) closed_edges += e.vertices.empty();
        };
        voronoi_diagram(scene, options);
        CHECK(closed_edges == 3);
        check_fits(scene);
    }
}

TEST_CASE("conforming meshes: in lattices cells that meet in a vertex or an edge alone have its points") {
    std::mt19937_64 rng(test_seed());
    const auto box = [](int size) { return Box{Vec3::Constant(-0.5), Vec3::Constant(size - 0.5)}; };
    const DiagramScene cubes = scene_of(lattice(rng, 3, 0.25, is_simple_place), box(3));
    check_fits(cubes);
    const Soup soup = conforming(cubes);
    CHECK(soup.facets.size() == 27 * 12);
    check_fits(scene_of(lattice(rng, 4, 0.25, is_face_centred), box(4)));
    check_fits(scene_of(lattice(rng, 4, 0.25, is_body_centred), box(4)));
    check_fits(scene_of(lattice(rng, 4, 0.25, is_body_centred), {Vec3(-1, -2, -1), Vec3(4, 3.5, 5)}));
}

TEST_CASE("conforming meshes: vertices nearer to each other than their errors are told by their sites") {
    // Balls as far from the middle of the box as each other but for the rounding of their places.
    const std::array five{Vec3(0, -0.6, 0.8), Vec3(0, 0, -1), Vec3(-0.6, 0.8, 0), Vec3(1, 0, 0),
                          Vec3(0, 0.6, 0.8)};
    const std::array nine{Vec3(1, 0, 0),  Vec3(0.8, 0, -0.6), Vec3(0, 1, 0),
                          Vec3(-1, 0, 0), Vec3(0, 0, -1),     Vec3(0, -0.6, 0.8),
                          Vec3(0, -1, 0), Vec3(-0.8, 0, 0.6), Vec3(0, 0, 1)};
    std::mt19937_64 rng(test_seed());
    for (const std::span<const Vec3> places : {std::span<const Vec3>(five), std::span<const Vec3>(nine)}) {
        std::vector<Object> balls;
        for (const Vec3& p : places) balls.push_back(Sphere{p, 0.1});
        const DiagramScene scene = scene_of(balls, {Vec3::Constant(-2), Vec3::Constant(2)});
        for (int order = 0; order < 4; ++order) {
            DiagramScene shuffled = scene;
            if (order > 0) std::ranges::shuffle(shuffled.objects, rng);
            const Soup soup = conforming(shuffled);
            CHECK(soup.not_closed == 0);
            CHECK(soup.drawn_again == 0);
            CHECK(lone_triangles(soup) == 0);
            CHECK(all_volume(soup) == doctest::Approx(box_volume(scene)).epsilon(1e-12));
        }
    }
}

TEST_CASE("conforming meshes: no two faces that a cell takes over have one side inside of both") {
    // Balls of a millionth of the box: faces that go on to its sides have few triangles for their lines.
    const Vec3 at(0.3, 0.2, 0.1);
    const auto ball = [&](double x, double y, double z, double radius) {
        return Sphere{at + 1e-6 * Vec3(x, y, z), 1e-6 * radius};
    };
    const Soup soup =
        conforming(scene_of({ball(1.611, -0.646, -1.959, 0.423), ball(-1.444, 1.974, 1.344, 0.5),
                             ball(-1.266, -1.042, -0.142, 0), ball(1.582, 1.184, -0.938, 0.473)},
                            {at - Vec3::Ones(), at + Vec3::Ones()}));
    CHECK(soup.doubled_sides == 0);
    CHECK(soup.drawn_again == 0);
    CHECK(soup.not_closed == 0);
}

TEST_CASE("conforming meshes: edges no longer than the rounding of their places are not halved for that") {
    // A cubic lattice that stands on an edge, far from the origin: eight cells that all but meet in vertices.
    const std::array places{Vec3{94.64314575050761, 0.25, 100.3},
                            Vec3{106.66396103067893, 4.25, 101.00710678118655},
                            Vec3{108.78528137423856, 1.25, 103.12842712474618},
                            Vec3{101.00710678118655, 3.25, 101.00710678118655},
                            Vec3{105.24974746830584, 2.25, 98.17867965644035},
                            Vec3{101.71421356237309, 4.25, 103.12842712474618},
                            Vec3{103.83553390593273, 3.25, 99.59289321881344},
                            Vec3{93.22893218813452, 3.25, 97.47157287525381}};
    std::vector<Object> points;
    for (const Vec3& p : places) points.push_back(Sphere{p, 0});
    DiagramScene scene = scene_of(points, {Vec3::Zero(), Vec3(2.8284271247461903, 2.0, 1.414213562373095)});
    scene.periodic = {true, true, true};
    scene.tilt = {0, 1.414213562373095, 0};
    const Soup soup = conforming(scene);
    CHECK(soup.not_closed == 0);
    CHECK(soup.facets.size() < 50000);
    CHECK(all_volume(soup) == doctest::Approx(8).epsilon(1e-9));
}

TEST_CASE("conforming meshes: where the box repeats images have the same triangles, their own cell's, too") {
    std::mt19937_64 rng(test_seed());
    const Box box{Vec3::Zero(), Vec3::Constant(10)};
    for (const int count : {1, 2, 3, 20}) {
        CAPTURE(count);
        DiagramScene scene = scene_of(random_balls(rng, count, 0.8), box);
        scene.periodic = {true, true, true};
        check_fits(scene);
        scene.tilt = {3, -2, 1};
        check_fits(scene);
        scene.tilt = {0, 0, 0};
        scene.periodic = {false, true, false};
        check_fits(scene);
    }
    DiagramScene scene = scene_of(lattice(rng, 2, 0.25, is_face_centred), {Vec3::Zero(), Vec3::Constant(2)});
    scene.periodic = {true, true, true};
    check_fits(scene);
}

TEST_CASE("conforming meshes: cells of planes and of a tube along the box fit with those of balls") {
    const Box box{Vec3::Constant(-5), {6, 7, 8}};
    std::vector<Object> objects{Sphere{{1, 1, 1}, 0.5}, Sphere{{-2, 1, 2}, 0.75}, Sphere{{2, -2, 3}, 0.25},
                                Plane{{0, 0, -2}, {0, 0, 1}}, Sphere{{0, 0, -4}, 0.5}};
    check_fits(scene_of(objects, box));
    std::swap(objects[0], objects[3]);
    check_fits(scene_of(objects, box));
    objects.push_back(Cylinder{{0, -1, 5}, {1, 0, 0}, 0.25});
    objects.insert(objects.begin(), Cylinder{{0, 4, 1}, {1, 0, 0}, 0.5});
    check_fits(scene_of(objects, box));
}

TEST_CASE("conforming meshes: tubes along different axes of the box agree about its sides") {
    check_fits(scene_of({Sphere{{4, 1, 6}, 1}, Sphere{{5, 8, 2}, 1}, Cylinder{{5, 0, 0}, {0, 0, -1}, 1},
                         Cylinder{{0, 3, 3}, {0, -1, 0}, 2}},
                        {Vec3::Constant(-1), Vec3::Constant(9)}));
    check_fits(scene_of({Cylinder{{0, 3, 3}, {2, 0, 0}, 1}, Cylinder{{7, 7, 0}, {0, 0, 1}, 1}},
                        {Vec3::Constant(-1), Vec3::Constant(9)}));
}

TEST_CASE(
    "conforming meshes: a side is one of two triangles, in a part of a tube's cell as flat as that, too") {
    const Soup soup =
        conforming(scene_of({Cylinder{{6, 6, 8}, {0, -2, -1}, 0}, Cylinder{{6, 0, 7}, {2, 0, 1}, 1},
                             Sphere{{3, 0, 2}, 0}, Cylinder{{6, 7, 5}, {-1, 0, 2}, 0}},
                            {Vec3::Constant(-1), Vec3::Constant(9)}));
    CHECK(soup.facets.size() > 100);
    CHECK(soup.not_closed == 0);
    CHECK(soup.doubled_sides == 0);
}

TEST_CASE("conforming meshes: no triangle is turned over beyond an edge that bends inwards") {
    // A side of the box cuts the first one's face in an edge that inner sides of triangles nearly reach; in
    // the second one parameters run along two edges as they do nowhere near.
    const Soup cut =
        conforming(scene_of({Sphere{{0, 4, 7}, 2}, Cylinder{{0, 2, 8}, {0, 0, 1}, 1}, Sphere{{6, 4, 5}, 3},
                             Cylinder{{3, 3, 5}, {0, 0, 1}, 1}, Cylinder{{6, 7, 5}, {2, 1, -2}, 1},
                             Cylinder{{2, 6, 1}, {-1, -1, 1}, 0}},
                            {Vec3::Constant(-1), Vec3::Constant(9)}));
    const Soup bent =
        conforming(scene_of({Cylinder{{3, 8, 8}, {1, -2, -1}, 0}, Cylinder{{2, 8, 1}, {0, 0, -1}, 1},
                             Sphere{{1, 5, 8}, 1}, Cylinder{{3, 7, 8}, {1, 2, 1}, 0}},
                            {Vec3::Zero(), Vec3::Constant(8)}));
    for (const Soup* soup : {&cut, &bent}) {
        REQUIRE(soup->facets.size() > 100);
        CHECK(soup->not_closed == 0);
        CHECK(soup->turned_over == 0);
        CHECK(soup->most_beyond < 1e-9);
    }
}

TEST_CASE("conforming meshes: a closed edge that another cell has drawn from elsewhere on makes no crowd") {
    const DiagramScene scene = scene_of({Sphere{{6, 0, 7}, 1}, Sphere{{7, 2, 4}, 0}, Sphere{{5, 0, 5}, 0},
                                         Sphere{{0, 2, 3}, 0}, Sphere{{6, 0, 3}, 2}},
                                        {Vec3::Constant(-1), Vec3::Constant(9)});
    check_fits(scene);
    const Soup soup = conforming(scene);
    CHECK(soup.facets.size() < 4000);
    const auto is_point = [](const Soup::Facet& f) {
        return (f.corners[1] - f.corners[0]).norm() < 1e-6 || (f.corners[2] - f.corners[1]).norm() < 1e-6;
    };
    CHECK(std::ranges::none_of(soup.facets, is_point));
}

TEST_CASE("conforming meshes: in a vessel what is towards its wall bounds what balls have of it") {
    std::mt19937_64 rng(test_seed());
    std::vector<Object> objects;
    const Vec3 middle = Vec3::Constant(5);
    for (const Object& ball : random_balls(rng, 40, 0.3))
        if ((std::get<Sphere>(ball).center - middle).norm() < 4.5) objects.push_back(ball);
    objects.push_back(HollowSphere{middle, 5});
    const Soup soup = conforming(scene_of(objects, {Vec3::Constant(-1), Vec3::Constant(11)}));
    CHECK(soup.not_closed == 0);
    CHECK(soup.drawn_again == 0);
    CHECK(lone_triangles(soup) == 0);
    CHECK(doubled_points(soup) == 0);
    REQUIRE(soup.volumes.size() > 5);
    CHECK(outer_volume(soup) == doctest::Approx(all_volume(soup)).epsilon(1e-12));
    CHECK(all_volume(soup) == doctest::Approx(filled_volume(soup.scene, soup.diagram).volume).epsilon(0.03));
}

// Cells of tubes come in parts, which end in faces that other cells have whole.
TEST_CASE("conforming meshes: cells of tubes at any angle fit with all others and with each other") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round) {
        std::vector<Object> objects = random_tubes(rng, 3, 0.3);
        const std::size_t tubes = objects.size();
        for (const Object& ball : random_balls(rng, 12, 0)) {
            const Vec3 at = std::get<Sphere>(ball).center;
            const bool is_clear = std::ranges::none_of(objects, [&](const Object& o) {
                const auto* tube = std::get_if<Cylinder>(&o);
                return tube && tube->axis.normalized().cross(at - tube->point).norm() < tube->radius + 0.5;
            });
            if (is_clear) objects.push_back(Sphere{at, 0.25});
        }
        // Tubes come first, in the middle, or last.
        std::ranges::rotate(objects, objects.begin() + static_cast<std::ptrdiff_t>(rng() % tubes));
        check_fits(scene_of(objects, {Vec3::Zero(), Vec3::Constant(10)}), 1e-9);
    }
}

TEST_CASE("conforming meshes: in small integers tubes at any angle fit, too") {
    const Box box{Vec3::Zero(), Vec3::Constant(8)};
    check_fits(scene_of({Cylinder{{4, 6, 5}, {-1, 0, 2}, 0}, Cylinder{{2, 2, 6}, {1, 0, 2}, 1},
                         Cylinder{{6, 7, 2}, {2, 1, 1}, 0.5}},
                        box),
               1e-9);
    check_fits(scene_of({Sphere{{2, 6, 6}, 0.5}, Cylinder{{3, 4, 4}, {1, 1, 0}, 0.5},
                         Plane{{0, 0, 1}, {0, 0, 1}}, Sphere{{6, 2, 3}, 0}},
                        box),
               1e-9);
}

// Where the axis meets a plane and a side of the box in one place, a section is all but the apex of a cone.
TEST_CASE("conforming meshes: parts that meet near an apex have no triangle turned over") {
    // Some of them cut each other, and have no cells.
    const Soup soup = conforming(
        scene_of({Plane{{7, 5, 1}, {0, 1, -1}}, Cylinder{{2, 3, 7}, {-1, 2, -2}, 0},
                  Plane{{1, 5, 6}, {0, -1, -1}}, Cylinder{{7, 6, 6}, {-2, 2, 0}, 1}, Sphere{{3, 3, 7}, 0.5}},
                 {Vec3::Zero(), Vec3::Constant(8)}));
    REQUIRE(soup.facets.size() > 100);
    CHECK(soup.not_closed == 0);
    CHECK(soup.drawn_again == 0);
    CHECK(lone_triangles(soup) == 0);
    CHECK(soup.turned_over == 0);
}

// The face between tubes whose axes all but cross is folded by as little as lies between these, and its
// patches are strips that are narrower than a chord there.
TEST_CASE("conforming meshes: no triangle is turned over in strips of a sharply folded face") {
    const DiagramScene scene =
        scene_of({Cylinder{{4, 4, 4}, {2, 1, 0}, 0.25}, Cylinder{{4, 4, 4.125}, {-1, 1, 1}, 0.2499}},
                 {Vec3::Zero(), Vec3::Constant(8)});
    check_fits(scene, 1e-9);
    const Soup soup = conforming(scene);
    REQUIRE(soup.facets.size() > 10'000);
    CHECK(soup.facets.size() < 50'000);
    CHECK(soup.turned_over == 0);
}

TEST_CASE("conforming meshes: meshes that do not fit are seen") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = scene_of(random_balls(rng, 15, 0.5), {Vec3::Constant(-1), Vec3::Constant(11)});
    Soup soup = conforming(scene);
    REQUIRE(lone_triangles(soup) == 0);
    const auto inner =
        std::ranges::find_if(soup.facets, [&](const Soup::Facet& f) { return soup.has_cell(f.beyond); });
    const Vec3 before = inner->corners[0];
    inner->corners[0].x() = std::nextafter(before.x(), 20.0);
    CHECK(lone_triangles(soup) == 2);  // it, and what it fitted
    CHECK(doubled_points(soup) == 0);
    const Vec3 after = inner->corners[0];
    for (Soup::Facet& f : soup.facets)
        if (f.cell == inner->cell) std::ranges::replace(f.corners, before, after);
    CHECK(doubled_points(soup) == 1);
    const auto outer =
        std::ranges::find_if(soup.facets, [&](const Soup::Facet& f) { return !soup.has_cell(f.beyond); });
    soup.facets.erase(outer);
    CHECK(outer_volume(soup) != doctest::Approx(box_volume(scene)).epsilon(1e-12));
    // Each cell by itself.
    const Soup alone = soup_of(scene, [](std::uint32_t, const Cell& cell) {
        return tessellate(cell, {0.002 * cell_diagonal(cell), true});
    });
    CHECK(lone_triangles(alone) > 100);
    CHECK(all_volume(alone) != doctest::Approx(box_volume(scene)).epsilon(1e-8));
}

}  // namespace vcell
