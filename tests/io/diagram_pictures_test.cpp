// Pictures of whole diagrams: the sections of all cells tile the box's section, each around what is nearest
// in it, and meshes are closed.
#include "../../io/pictures/diagram_pictures.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../random_tubes.hpp"
#include "../test_support.hpp"
#include "closed_meshes.hpp"

namespace vcell {
namespace {

DiagramScene random_scene(std::mt19937_64& rng, int n) {
    std::uniform_real_distribution<double> place(0, 1), radius(0, 0.1);
    DiagramScene scene;
    scene.box = {Vec3::Constant(-0.1), {1.1, 1.2, 1.3}};
    for (int i = 0; i < n; ++i)
        scene.objects.push_back(Sphere{{place(rng), place(rng), place(rng)}, radius(rng)});
    scene.names.assign(scene.objects.size(), "");
    scene.names[1] = "a <b>";
    return scene;
}

template <class Visit>
void for_meshes(const DiagramScene& scene, Visit&& visit) {
    DiagramOptions options;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        visit(object, cell, tessellate(cell, {0.001 * cell_diagonal(cell), true}));
    };
    voronoi_diagram(scene, options);
}

/// The polygons of each cell's path, in pixels.
std::map<std::uint32_t, std::vector<std::vector<Vec2>>> paths(const std::string& svg) {
    std::map<std::uint32_t, std::vector<std::vector<Vec2>>> all;
    for (std::size_t at = 0; (at = svg.find("data-object=\"", at)) != svg.npos;) {
        at += 13;
        const auto object = static_cast<std::uint32_t>(std::stoul(svg.substr(at)));
        const std::size_t begin = svg.find(" d=\"", at) + 4, end = svg.find('"', begin);
        std::string path = svg.substr(begin, end - begin);
        for (char& c : path)
            if (c == ',' || c == 'L' || c == 'Z') c = ' ';
        std::istringstream loops(path);
        std::string loop;
        std::getline(loops, loop, 'M');
        while (std::getline(loops, loop, 'M')) {
            std::istringstream numbers(loop);
            auto& polygon = all[object].emplace_back();
            for (Vec2 p; numbers >> p[0] >> p[1];) polygon.push_back(p);
        }
    }
    return all;
}

bool contains(const std::vector<std::vector<Vec2>>& polygons, const Vec2& p) {
    bool inside = false;
    for (const auto& polygon : polygons)
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
            if ((a.y() > p.y()) == (b.y() > p.y())) continue;
            if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
        }
    return inside;
}

}  // namespace

namespace {

double distance_to(const Object& object, const Vec3& p) {
    if (const auto* plane = std::get_if<Plane>(&object))
        return std::abs(plane->normal.normalized().dot(p - plane->point));
    if (const auto* tube = std::get_if<Cylinder>(&object))
        return tube->axis.normalized().cross(p - tube->point).norm() - tube->radius;
    const auto& ball = std::get<Sphere>(object);
    return (p - ball.center).norm() - ball.radius;
}

// Each object's meshes are closed, of its cell's volume, and around each point there is that of what is
// nearest to it.
void check_complete_meshes(const DiagramScene& scene, std::mt19937_64& rng) {
    std::map<std::uint32_t, std::vector<CellMesh>> meshes;
    DiagramOptions options;
    options.complete = true;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        meshes[object].push_back(tessellate(cell, {0.01, true}));
        CHECK(is_closed(meshes[object].back()));
    };
    const VoronoiDiagram diagram = voronoi_diagram(scene, options), plain = voronoi_diagram(scene);
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        CAPTURE(i);
        REQUIRE(diagram.cells[i].state == DiagramCell::State::Computed);
        REQUIRE(meshes[i].size() == (std::holds_alternative<Plane>(scene.objects[i]) ? 2u : 1u));
        double sum = 0;
        for (const CellMesh& mesh : meshes[i]) sum += volume(mesh);
        CHECK(sum == doctest::Approx(diagram.cells[i].volume).epsilon(0.02));
        // A tube's is measured as the complete cell that was drawn, and without as other cells.
        const DiagramCell &drawn = diagram.cells[i], &alone = plain.cells[i];
        CHECK(std::abs(drawn.volume - alone.volume) <= drawn.volume_error + alone.volume_error);
        CHECK(std::abs(drawn.area - alone.area) <= drawn.area_error + alone.area_error);
        CHECK(drawn.touches_box == alone.touches_box);
        REQUIRE(drawn.contacts.size() == alone.contacts.size());
        for (std::size_t k = 0; k < drawn.contacts.size(); ++k) {
            const CellContact &a = drawn.contacts[k], &b = alone.contacts[k];
            CHECK(a.site == b.site);
            CHECK(std::abs(a.area - b.area) <= a.area_error + b.area_error);
        }
    }
    std::uniform_real_distribution<double> place(0, 10);
    for (int k = 0; k < 100; ++k) {
        const double x = place(rng), y = place(rng), z = place(rng);
        const Vec3 p(x, y, z);
        std::vector<std::pair<double, std::uint32_t>> nearest;
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
            nearest.emplace_back(distance_to(scene.objects[i], p), i);
        std::ranges::sort(nearest);
        // Nearer to a boundary than chords may be; on a plane between its two cells.
        if (nearest[1].first - nearest[0].first < 0.05 || std::abs(nearest[0].first) < 0.05) continue;
        for (const auto& [object, of_object] : meshes) {
            double turns = 0;
            for (const CellMesh& mesh : of_object) turns += winding(mesh, p);
            CAPTURE(object);
            CHECK(turns == doctest::Approx(object == nearest[0].second ? 1 : 0).epsilon(1e-6));
        }
    }
}

}  // namespace

TEST_CASE("diagram pictures: complete cells of tubes, planes and balls fill the box") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 2 * rounds(); ++round) {
        DiagramScene scene;
        scene.box = {Vec3::Zero(), Vec3::Constant(10)};
        if (round % 2 == 0)
            scene.objects = random_tubes(rng, 5, 0.3);
        else
            scene.objects.push_back(Plane{{5, 5, 4}, {0.3, 0.2, 1}});
        std::uniform_real_distribution<double> place(1, 9);
        for (int tries = 0; scene.objects.size() < 8u && tries < 1000; ++tries) {
            const double x = place(rng), y = place(rng), z = place(rng);
            const Sphere ball{{x, y, z}, 0.2};
            bool is_clear = true;
            for (const Object& o : scene.objects)
                is_clear = is_clear && distance_to(o, ball.center) > ball.radius + 0.02;
            if (is_clear) scene.objects.push_back(ball);
        }
        check_complete_meshes(scene, rng);
    }
}

TEST_CASE("diagram pictures: a cut shows at each place the cell of what is nearest there") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = random_scene(rng, 40);
    for (const int axis : {0, 1, 2}) {
        DiagramCut cut(scene, axis, 0.43);
        for_meshes(scene, [&](std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
            cut.add(object, cell, mesh);
        });
        std::ostringstream out;
        cut.write(out);
        const auto cells = paths(out.str());
        REQUIRE(cells.size() > 5);
        const Vec3 size = scene.box.max - scene.box.min;
        const int right = (axis + 1) % 3, up = (axis + 2) % 3;
        const double scale = 784 / std::max(size[right], size[up]);
        std::uniform_real_distribution<double> unit(0, 1);
        int sure = 0;
        for (int k = 0; k < 500; ++k) {
            Vec3 p = scene.box.min + Vec3(unit(rng), unit(rng), unit(rng)).cwiseProduct(size);
            p[axis] = 0.43;
            std::vector<std::pair<double, std::uint32_t>> distances;
            for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
                const auto& ball = std::get<Sphere>(scene.objects[i]);
                distances.emplace_back((p - ball.center).norm() - ball.radius, i);
            }
            std::sort(distances.begin(), distances.end());
            // Within the mesh's chord of a boundary the picture may be off.
            if (distances[1].first - distances[0].first < 0.01) continue;
            ++sure;
            const Vec2 pixel(8 + scale * (p[right] - scene.box.min[right]),
                             8 + scale * (scene.box.max[up] - p[up]));
            for (const auto& [object, polygons] : cells) {
                CAPTURE(object);
                CHECK(contains(polygons, pixel) == (object == distances[0].second));
            }
        }
        CHECK(sure > 300);
    }
}

TEST_CASE("diagram pictures: names are escaped, and stand where there is room") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.objects = {Sphere{{0.25, 0.5, 0.5}, 0.1}, Sphere{{0.75, 0.5, 0.5}, 0.1}};
    scene.names = {"", "a <b>"};
    DiagramCut cut(scene, 2, 0.5);
    for_meshes(scene, [&](std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
        cut.add(object, cell, mesh);
    });
    std::ostringstream out;
    cut.write(out);
    CHECK(out.str().find("a &lt;b&gt;</text>") != std::string::npos);
    CHECK(out.str().find("a <b>") == std::string::npos);
    CHECK(out.str().find(">0</text>") != std::string::npos);
}

TEST_CASE("diagram pictures: the OBJ of all cells has closed meshes that fill the box") {
    std::mt19937_64 rng(test_seed());
    const DiagramScene scene = random_scene(rng, 25);
    std::ostringstream out;
    DiagramObj obj(out, "all.mtl");
    std::size_t cells = 0;
    for_meshes(scene, [&](std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
        obj.add(object, cell, mesh);
        ++cells;
    });
    std::istringstream lines(out.str());
    std::vector<Vec3> points;
    std::map<std::pair<std::size_t, std::size_t>, int> sides;  // as often one way as the other
    std::size_t objects = 0, normals = 0;
    double volume = 0;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            Vec3 p;
            words >> p[0] >> p[1] >> p[2];
            points.push_back(p);
        }
        normals += kind == "vn";
        objects += kind == "o";
        if (kind != "f") continue;
        std::size_t v[3], n;
        for (std::size_t& k : v) {
            char slash;
            words >> k >> slash >> slash >> n;
            REQUIRE(k - 1 < points.size());
            REQUIRE(n - 1 < normals);
        }
        for (int k = 0; k < 3; ++k) {
            const std::size_t a = v[k], b = v[(k + 1) % 3];
            sides[std::minmax(a, b)] += a < b ? 1 : -1;
        }
        volume += points[v[0] - 1].dot(points[v[1] - 1].cross(points[v[2] - 1])) / 6;
    }
    CHECK(objects == cells);
    for (const auto& [side, balance] : sides) REQUIRE(balance == 0);
    CHECK(volume == doctest::Approx((scene.box.max - scene.box.min).prod()).epsilon(1e-3));
    CHECK(out.str().find("o cell_1_a_<b>\n") != std::string::npos);
    std::ostringstream materials;
    DiagramObj::write_mtl(materials);
    CHECK(materials.str().find("newmtl c7\n") != std::string::npos);
}

}  // namespace vcell
