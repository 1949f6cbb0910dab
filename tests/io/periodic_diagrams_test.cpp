// certify() on diagrams in boxes that repeat, as files have them: whole ones, and damaged ones.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "../../core/errors.hpp"
#include "../../io/check/near_balls.hpp"
#include "../test_support.hpp"
#include "stored_diagrams.hpp"

using namespace vcell;

namespace {

DiagramScene repeating_balls(std::mt19937_64& rng, int count, double most_radius = 0.5) {
    std::uniform_real_distribution<double> at(0, 2), radius(0.1, most_radius);
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Constant(2)};
    scene.periodic = {true, true, true};
    for (int i = 0; i < count; ++i) scene.objects.push_back(Sphere{{at(rng), at(rng), at(rng)}, radius(rng)});
    return scene;
}

DiagramScene scaled(DiagramScene scene, double factor) {
    scene.box.min *= factor;
    scene.box.max *= factor;
    for (double& t : scene.tilt) t *= factor;
    for (Object& o : scene.objects) {
        auto& ball = std::get<Sphere>(o);
        ball.center *= factor;
        ball.radius *= factor;
    }
    return scene;
}

std::string name_of(const StoredDiagram& diagram, std::size_t k) {
    return "cells[" + std::to_string(diagram.cells[k].first) + "]";
}

bool is_moved(const Cell& cell, const Site& site) {
    return site.is_object() && cell.scene.images[site.index].image != check::ImageIndex{};
}

}  // namespace

TEST_CASE("check of a diagram that repeats: random balls are proved along any axes, and where it leans") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round) {
        DiagramScene scene = repeating_balls(rng, 5);
        SUBCASE("along all axes") {}
        SUBCASE("along one axis") { scene.periodic = {false, true, false}; }
        SUBCASE("leaning") { scene.tilt = {0.7, -0.4, 1.1}; }
        SUBCASE("with a ball in another, and one twice") {
            Sphere inside = std::get<Sphere>(scene.objects[0]);
            inside.radius *= 0.5;
            inside.center.x() += 2;
            scene.objects.insert(scene.objects.begin(), inside);
            scene.objects.push_back(scene.objects[2]);
            std::get<Sphere>(scene.objects.back()).center.y() -= 2;
        }
        SUBCASE("in a large unit") { scene = scaled(scene, 1e6); }
        SUBCASE("in a small unit") { scene = scaled(scene, 1e-6); }
        check_none_refuted(certify(stored(scene)));
    }
}

TEST_CASE("check of a diagram that repeats: a ball among its own images, also where these overlap") {
    for (const double radius : {0.0, 0.25, 0.625}) {
        DiagramScene scene;
        scene.box = {{0, 0, 0}, {1, 1, 1.5}};
        scene.periodic = {true, true, true};
        scene.objects = {Sphere{{0.25, 0.5, 2.75}, radius}};
        std::size_t faces = 6;
        SUBCASE("upright") {}
        SUBCASE("leaning") {
            scene.tilt = {0.5, 0.25, 0.25};
            faces = 14;
        }
        SUBCASE("along two axes") { scene.periodic[1] = false; }
        const StoredDiagram diagram = stored(scene);
        REQUIRE(diagram.cells.size() == 1);
        CHECK(diagram.cells[0].second.faces.size() == faces);
        check_proved(certify(diagram));
    }
}

TEST_CASE("check of a diagram that repeats: lattices of small integers, whose vertices are ties") {
    struct Lattice {
        std::vector<Vec3> places;
        std::size_t faces, most_sites;
    };
    for (const Lattice& lattice : {Lattice{{{0, 0, 0}}, 6, 7}, Lattice{{{0, 0, 0}, {1, 1, 1}}, 14, 3},
                                   Lattice{{{0, 0, 0}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}}, 12, 5}}) {
        CAPTURE(lattice.faces);
        DiagramScene scene;
        scene.box = {Vec3::Zero(), Vec3::Constant(2)};
        scene.periodic = {true, true, true};
        for (const Vec3& p : lattice.places) scene.objects.push_back(Sphere{p, 0.5});
        const StoredDiagram diagram = stored(scene);
        REQUIRE(diagram.cells.size() == lattice.places.size());
        for (const auto& [object, cell] : diagram.cells) {
            CHECK(cell.faces.size() == lattice.faces);
            std::size_t most = 0;
            for (const CellVertex& v : cell.vertices) most = std::max(most, v.sites.size());
            CHECK(most == lattice.most_sites);
        }
        check_proved(certify(diagram));

        // A site that a vertex lacks is told by its number and image.
        StoredDiagram damaged = diagram;
        Cell& cell = damaged.cells.back().second;
        auto& sites = cell.vertices[0].sites;
        const std::size_t last = sites.size() - 1;
        const std::string lost = "object " + to_string(cell.scene.images[sites[last].index]);
        sites.resize(last);
        const Certificate certificate = certify(damaged);
        CHECK(std::ranges::any_of(certificate.elements, [&](const Element& e) {
            return e.verdict == Verdict::refuted && e.where.ends_with(".vertices[0].sites") &&
                   e.what.find(lost) != std::string::npos;
        }));
    }
}

TEST_CASE("check of a diagram that repeats: what is damaged is objected to") {
    std::mt19937_64 rng(test_seed() + 2);
    const StoredDiagram whole = stored(repeating_balls(rng, 5));
    StoredDiagram d = whole;
    Cell& cell = d.cells[2].second;
    const std::string name = name_of(d, 2);
    SUBCASE("an image of a face") {
        const auto face =
            std::ranges::find_if(cell.faces, [&](const CellFace& f) { return is_moved(cell, f.site); });
        REQUIRE(face != cell.faces.end());
        // That of one face alone: the others may have the same.
        cell.scene.images.push_back(cell.scene.images[face->site.index]);
        for (auto& k : cell.scene.images.back().image) k = static_cast<std::int16_t>(-k);
        face->site.index = static_cast<std::uint32_t>(cell.scene.images.size() - 1);
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name, Verdict::refuted));
        CHECK(has_verdict(c, "pairs[", Verdict::refuted));
    }
    SUBCASE("an image wherever the cell names it") {
        const auto image = std::ranges::find_if(
            cell.scene.images, [](const ObjectImage& o) { return o.image != check::ImageIndex{}; });
        REQUIRE(image != cell.scene.images.end());
        image->image[0] = static_cast<std::int16_t>(image->image[0] + 1);
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name, Verdict::refuted));
        CHECK(has_verdict(c, "pairs[", Verdict::refuted));
    }
    SUBCASE("a cell that is not there") {
        d.cells.erase(d.cells.begin() + 2);
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name, Verdict::refuted));
        CHECK(has_verdict(c, "pairs[", Verdict::refuted));
        CHECK(has_verdict(c, "volume", Verdict::refuted));
    }
    SUBCASE("a volume, by less than its error") {
        cell.measures.volume += 0.25 * cell.measures.volume_error;
        CHECK_FALSE(has_verdict(certify(d), "", Verdict::refuted));
    }
    SUBCASE("a volume, by more") {
        cell.measures.volume += 1e-6;
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name + ".measures", Verdict::refuted));
        CHECK(has_verdict(c, "volume", Verdict::refuted));
    }
    SUBCASE("a vertex of one of its cells") {
        cell.vertices[0].point.z() += 1e-6;
        const Certificate c = certify(d);
        CHECK(has_verdict(c, name + ".vertices[0]", Verdict::refuted));
        CHECK(has_verdict(c, "pairs[", Verdict::refuted));
    }
    SUBCASE("a cell that is moved by an edge of the box") {
        for (CellVertex& v : cell.vertices) v.point.x() += 2;
        for (CellEdge& e : cell.edges)
            for (auto& p : e.curve.points) p[0] += 2;
        for (CellFace& f : cell.faces)
            for (TrimmedPatch& patch : f.patches)
                for (auto& p : patch.surface.points) p[0] += 2;
        CHECK(has_verdict(certify(d), name, Verdict::refuted));
    }
    SUBCASE("the box's edges") {
        d.scene.box.max.x() += 0x1p-10;
        const Certificate c = certify(d);
        CHECK(has_verdict(c, "cells[", Verdict::refuted));
        CHECK(has_verdict(c, "volume", Verdict::refuted));
    }
    SUBCASE("its tilt") {
        d.scene.tilt[1] = 0x1p-10;
        CHECK(has_verdict(certify(d), "cells[", Verdict::refuted));
    }
    SUBCASE("an axis along which it repeats") {
        d.scene.periodic[1] = false;
        CHECK(has_verdict(certify(d), "cells[", Verdict::refuted));
    }
    SUBCASE("a face on a side of the box that repeats") {
        cell.faces[0].site = Site::box_side(1);
        CHECK(has_verdict(certify(d), name + ".faces", Verdict::refuted));
    }
    SUBCASE("a clearance that hides what is near") {
        cell.measures.max_clearance *= 0.01;
        CHECK(has_verdict(certify(d), name, Verdict::refuted));
    }
    SUBCASE("a clearance without measure") {
        cell.measures.max_clearance = 1e50;
        CHECK(has_verdict(certify(d), name, Verdict::refuted));
    }
    SUBCASE("an object that nobody has looked at, in another image") {
        d.scene.objects.push_back(Sphere{cell.vertices[0].point + Vec3(2, -2, 0), 0.001});
        CHECK(has_verdict(certify(d), "cells[5]", Verdict::refuted));
    }
    SUBCASE("coordinates that are on no grid on which images are exact") {
        for (Object& o : d.scene.objects) {
            double& x = std::get<Sphere>(o).center.x();
            x = std::nextafter(x, 2.0);
        }
        CHECK(has_verdict(certify(d), "cells[", Verdict::open));
    }
}

TEST_CASE("check of a diagram that repeats: images that may be near are all found, where they are") {
    std::mt19937_64 rng(test_seed() + 3);
    std::uniform_int_distribution<int> edge(12, 40), lean(-12, 12), place(-64, 64), size(0, 24), axes(1, 7);
    for (int round = 0; round < 20 * rounds(); ++round) {
        DiagramScene scene;
        scene.box = {{-1, 2, -3}, Vec3(-1, 2, -3) + Vec3(edge(rng), edge(rng), edge(rng)) / 8};
        const int which = round % 2 == 0 ? 7 : axes(rng);
        for (std::size_t k = 0; k < 3; ++k) scene.periodic[k] = (which >> k) % 2 == 1;
        if (which == 7) scene.tilt = {lean(rng) / 8.0, lean(rng) / 8.0, lean(rng) / 8.0};
        for (int i = 0; i < 3; ++i)
            scene.objects.push_back(Sphere{Vec3(place(rng), place(rng), place(rng)) / 16, size(rng) / 16.0});
        const double reach = size(rng) / 8.0;
        const check::NearBalls balls(scene);
        const auto found = balls.search(2, reach);
        CHECK(found.lack.empty());
        CHECK(std::ranges::is_sorted(found.found, {}, &check::NearBalls::Found::object));
        // All images that are not far out, by edges that are columns; those are numbers of few digits.
        // Centres are within 8 of each other along each axis, and what is found within 6: edges of 1.5 or
        // more that lean by no more than that take no more of them.
        const Eigen::Matrix3d edges = scene.edges();
        const auto& self = std::get<Sphere>(scene.objects[2]);
        std::size_t near = 0;
        std::array<int, 3> most{40, 20, 10};
        for (std::size_t k = 0; k < 3; ++k) most[k] = scene.periodic[k] ? most[k] : 0;
        for (std::uint32_t j = 0; j < 3; ++j)
            for (int c = -most[2]; c <= most[2]; ++c)
                for (int b = -most[1]; b <= most[1]; ++b)
                    for (int a = -most[0]; a <= most[0]; ++a) {
                        if (j == 2 && a == 0 && b == 0 && c == 0) continue;
                        const auto& ball = std::get<Sphere>(scene.objects[j]);
                        const Vec3 center = ball.center + edges * Vec3(a, b, c);
                        if ((center - self.center).norm() > reach + self.radius + ball.radius) continue;
                        ++near;
                        const ObjectImage object{j,
                                                 {static_cast<std::int16_t>(a), static_cast<std::int16_t>(b),
                                                  static_cast<std::int16_t>(c)}};
                        const auto at = std::ranges::lower_bound(found.found, object, {},
                                                                 &check::NearBalls::Found::object);
                        REQUIRE(at != found.found.end());
                        CHECK(at->object == object);
                        CHECK(at->ball == Sphere{center, ball.radius});
                    }
        CHECK(found.found.size() == near);
    }
}

TEST_CASE("check of a diagram that repeats: too many images are told, not looked at") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), {1, 1, 0x1p-20}};
    scene.periodic = {true, true, true};
    scene.objects = {Sphere{{0.5, 0.5, 0}, 0.25}};
    const check::NearBalls balls(scene);
    CHECK_FALSE(balls.search(0, 1).lack.empty());
    CHECK(balls.farthest() >= 1);
    CHECK(balls.farthest() < 1 + 0x1p-15);
}

TEST_CASE("diagram that repeats: cells say which images their scene's objects are, and their files, too") {
    std::mt19937_64 rng(test_seed() + 4);
    DiagramScene scene = repeating_balls(rng, 4);
    scene.tilt = {0.5, 0.25, -0.75};
    const StoredDiagram read = stored(scene);
    DiagramOptions options;
    std::size_t visited = 0, moved = 0;
    options.visit = [&](std::uint32_t object, const Cell& cell) {
        const auto& [number, from_file] = read.cells[visited++];
        REQUIRE(number == object);
        REQUIRE(cell.scene.images.size() == cell.scene.objects.size());
        for (std::size_t i = 0; i < cell.scene.images.size(); ++i) {
            const auto& [of, image] = cell.scene.images[i];
            const auto& ball = std::get<Sphere>(read.scene.objects[of]);
            const Vec3 center = ball.center + read.scene.edges() * Vec3(image[0], image[1], image[2]);
            CHECK(std::get<Sphere>(cell.scene.objects[i]) == Sphere{center, ball.radius});
        }
        REQUIRE(from_file.faces.size() == cell.faces.size());
        for (std::size_t f = 0; f < cell.faces.size(); ++f) {
            CHECK(from_file.scene.images[from_file.faces[f].site.index] ==
                  cell.scene.images[cell.faces[f].site.index]);
            moved += is_moved(from_file, from_file.faces[f].site);
        }
        REQUIRE(from_file.neighbors.size() == cell.neighbors.size());
        for (std::size_t n = 0; n < cell.neighbors.size(); ++n)
            CHECK(from_file.scene.images[from_file.neighbors[n]] == cell.scene.images[cell.neighbors[n]]);
    };
    voronoi_diagram(scene, options);
    CHECK(visited == 4);
    CHECK(moved > 8);
}

TEST_CASE("diagram file: sites of a box that repeats have their images, and no others are read") {
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    scene.periodic = {true, false, true};
    scene.objects = {Sphere{{0.1, 0.5, 0.25}, 0.125}};
    const std::string text = text_of(scene);
    const auto diagram = parse_diagram(text);
    REQUIRE(diagram);
    // 0.1 has more digits than the grid.
    const double x = std::get<Sphere>(diagram->scene.objects[0]).center.x();
    CHECK(x != 0.1);
    CHECK(std::abs(x - 0.1) <= diagram->moved);
    CHECK(diagram->moved < 0x1p-43);
    CHECK(diagram->scene.periodic == scene.periodic);
    CHECK(text.find(R"x("site":"0(-1,0,0)")x") != std::string::npos);
    const auto refuses = [&](const std::string& from, const std::string& to) {
        std::string changed = text;
        const std::size_t at = changed.find(from);
        REQUIRE(at != std::string::npos);
        changed.replace(at, from.size(), to);
        try {
            parse_diagram(changed);
        } catch (const InputError&) {
            return true;
        }
        return false;
    };
    for (const char* image : {"0(-1,0)", "0(-1,0,0,0)", "0(-1,0,0) ", "0(0,0,0)", "0(+1,0,0)", "0(-01,0,0)",
                              "0(-1, 0,0)", "(-1,0,0)", "-1(1,0,0)", "0(-40000,0,0)", "0(-1,1,0)", "0"}) {
        CAPTURE(image);
        CHECK(refuses(R"x("0(-1,0,0)")x", '"' + std::string(image) + '"'));
    }
    CHECK_FALSE(refuses(R"x("0(-1,0,0)")x", R"x("0(-2,0,0)")x"));
    CHECK(refuses(R"("periodic":[true,)", R"("periodic":[false,)"));
}
