// What is nearest to each object of a scene, together, is the scene's box, wherever the objects lie to it;
// and two neighbours agree on the area between them.
#include "../../envelope/complete_measures.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../primitives/reference.hpp"
#include "../random_tubes.hpp"
#include "../test_support.hpp"

namespace vcell::complete_measures_test {
namespace {

const Box cube{Vec3::Zero(), Vec3::Constant(10)};

/// A base for each object, two of a plane, and whose it is.
struct Base {
    Object base;
    std::size_t object;
};

std::vector<Base> bases_of(const std::vector<Object>& objects) {
    std::vector<Base> bases;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        bases.push_back({objects[i], i});
        if (const auto* plane = std::get_if<Plane>(&objects[i]))
            bases.push_back({Plane{plane->point, -plane->normal}, i});
    }
    return bases;
}

Scene scene_of(const std::vector<Object>& objects, const Base& base) {
    Scene scene;
    scene.base = base.base;
    scene.objects = objects;
    scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(base.object));
    scene.box = cube;
    return scene;
}

/// How much of the box is nearest to the base among points at random.
double sampled_volume(const Scene& scene, int samples, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> coordinate(0, 10);
    int inside = 0;
    for (int i = 0; i < samples; ++i) {
        const double x = coordinate(rng), y = coordinate(rng), z = coordinate(rng);
        const Vec3 p(x, y, z);
        const double own = distance(scene.base, p);
        const auto* plane = std::get_if<Plane>(&scene.base);
        bool is_nearest = plane == nullptr || plane->normal.dot(p - plane->point) > 0;
        for (const Object& o : scene.objects) is_nearest = is_nearest && own <= distance(o, p);
        inside += is_nearest;
    }
    return 1000.0 * inside / samples;
}

/// Returns the volume of the cells as they are computed over the base's regions.
double check_tiling(const std::vector<Object>& objects, double most_bound) {
    struct Contact {
        double area = 0, error = 0;
    };
    std::mt19937_64 rng(test_seed());
    std::map<std::array<std::size_t, 2>, Contact> contacts;
    double volume = 0, bound = 0, over_regions = 0;
    for (const Base& base : bases_of(objects)) {
        CAPTURE(base.object);
        const Scene scene = scene_of(objects, base);
        const CompleteMeasures m = complete_measures(scene);
        volume += m.volume;
        bound += m.volume_error;
        double area = 0;
        for (const auto& n : m.neighbors) {
            Contact& contact = contacts[{base.object, n.object + (n.object >= base.object)}];
            contact.area += n.area;
            contact.error += n.area_error;
            area += n.area;
        }
        CHECK(std::abs(area - m.area) <= 2 * m.area_error + 1e-9);
        constexpr int samples = 2000;
        const double part = std::clamp(m.volume / 1000, 0.001, 0.999);
        CHECK(std::abs(sampled_volume(scene, samples, rng) - m.volume) <=
              6 * 1000 * std::sqrt(part * (1 - part) / samples));
        try {
            over_regions += voronoi_cell(scene).measures.volume;
        } catch (const InputError& e) {
            CHECK(e.kind == InputError::Kind::EmptyBox);
        }
    }
    CHECK(std::abs(volume - 1000) <= bound + 1e-9);
    CHECK(bound <= most_bound);
    for (const auto& [pair, contact] : contacts) {
        CAPTURE(pair[0]);
        CAPTURE(pair[1]);
        const auto back = contacts.find({pair[1], pair[0]});
        REQUIRE(back != contacts.end());
        const Contact& other = back->second;
        CHECK(std::abs(contact.area - other.area) <= 2 * contact.error + other.error + 1e-9);
    }
    return over_regions;
}

}  // namespace

TEST_CASE("complete measures: random oblique tubes tile their box") {
    std::mt19937_64 rng(test_seed());
    const int tubes = rounds() > 1 ? 30 : 8;
    for (int i = 0; i < rounds(); ++i) CHECK(check_tiling(random_tubes(rng, tubes, 0.15), 1e-3) < 980);
}

TEST_CASE("complete measures: tubes that fill much of their box tile it") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 2 * rounds(); ++i) CHECK(check_tiling(random_tubes(rng, 6, 0.6), 1e-3) < 980);
}

TEST_CASE("complete measures: planes that lean tile their box with what is between them") {
    const Vec3 normal(1, 2, 2);
    CHECK(check_tiling({Plane{{2, 2, 2}, normal}, Plane{{5, 5, 6}, normal}, Plane{{9, 9, 9}, normal}}, 1e-7) <
          800);
    CHECK(check_tiling({Plane{{2, 2, 2}, {1, 1.3, 2}}, Sphere{{7, 7, 7}, 1}, Sphere{{5, 6, 4}, 0.5}}, 1e-7) <
          800);
}

TEST_CASE("complete measures: planes that cut their box in a corner, or not at all") {
    const std::vector<Object> balls{Sphere{{7, 7, 7}, 1}, Sphere{{5, 6, 4}, 0.5},
                                    Sphere{{9.5, 9.7, 9}, 0.25}};
    for (const Plane& plane :
         {Plane{{0.5, 0, 0}, {1, 1, 1}}, Plane{{0.5, 0, 0}, {3, 2, 6}}, Plane{{-2, -2, -2}, {1, 1.3, 2}},
          Plane{{-1, 0, 0}, {1, 0, 0}}, Plane{{0, 0, -1}, {0, 0.5, 1}}}) {
        std::vector<Object> objects = balls;
        objects.emplace_back(plane);
        check_tiling(objects, 1e-7);
    }
}

TEST_CASE("complete measures: tubes along an edge of the box, through a corner, and beside it") {
    const Cylinder other{{6, 5, 3}, {1, -2, 2}, 0.5};
    for (const Cylinder& tube : {
             Cylinder{{0, 0, 0}, {0, 0, 1}, 0.25},             // along an edge
             Cylinder{{0, 0, 0}, {0, 0, 1}, 0},                // on it
             Cylinder{{0, 5, 0}, {0, 0, 1}, 0.25},             // on a side
             Cylinder{{0, 5, 5}, {0, 1, 1}, 0.25},             // on a side, obliquely
             Cylinder{{10, 0, 0}, {-1, 2, 2}, 0.25},           // through a corner
             Cylinder{{0, 0, 0}, {1, 1, 1}, 0.25},             // through two
             Cylinder{{0, 0, 4}, {1, 2, 3}, 0.25},             // through an edge
             Cylinder{{-1, 5, 5}, {0, 3, 4}, 1},               // touches a side from outside
             Cylinder{{-1, -1, 5}, {1, -1, 0}, std::sqrt(2)},  // touches an edge
             Cylinder{{-1, -2, 3}, {1, -2, 2}, 0.5},           // meets it nowhere
         }) {
        CAPTURE(tube.point.transpose());
        CAPTURE(tube.axis.transpose());
        CHECK(check_tiling({tube, other}, 1e-3) < 999);
    }
}

TEST_CASE("complete measures: tubes in small integers tile their box") {
    CHECK(check_tiling({Cylinder{{0, 0, 0}, {1, 2, 2}, 1}, Cylinder{{8, 0, 2}, {1, -2, 2}, 1},
                        Cylinder{{0, 8, 0}, {2, 1, 2}, 0}},
                       1e-3) < 980);
}

TEST_CASE("complete measures: balls outside the box, across its sides and about its corner") {
    check_tiling({Sphere{{-1, 5, 5}, 0.5}, Sphere{{0, 0, 0}, 1}, Sphere{{11, 11, 12}, 0.3},
                  Sphere{{6, 6, 6}, 1}, Sphere{{3, 0.2, 4}, 1}, Sphere{{5, 0, 8}, 0}},
                 1e-4);
    check_tiling({Sphere{{-1, 5, 5}, 0.5}, Cylinder{{5, 5, 5}, {1, 2, 3}, 1}, Sphere{{12, 12, 12}, 1}}, 1e-3);
}

TEST_CASE("complete measures: faces that slant towards a side of the box along which the axis runs") {
    // Across the tubes the bisector is a branch of a hyperbola, x = 1 - a sqrt(1 + z^2 / b^2) with foci at 0
    // and 2, a the half of what the radii differ by, up to where it meets the side x = 0.
    const double length = 8;
    for (const double a : {0.125, 0.25, 0.375}) {
        const double square = 1 - a * a, top = square / a;
        Scene scene;
        scene.base = Cylinder{{0, 0, 0}, {0, 1, 0}, 0.5};
        scene.objects = {Cylinder{{2, 0, 0}, {0, 1, 0}, 0.5 + 2 * a}};
        scene.box = {{0, 0, -8}, {8, length, 8}};
        constexpr int steps = 20000;
        double arc = 0;
        for (int i = 0; i < steps; ++i) {
            const double z = top * (i + 0.5) / steps, slope = a * z / square / std::sqrt(1 + z * z / square);
            arc += 2 * top / steps * std::sqrt(1 + slope * slope);
        }
        const CompleteMeasures m = complete_measures(scene);
        CAPTURE(a);
        CAPTURE(m.area - arc * length);
        CHECK(std::abs(m.area - arc * length) <= m.area_error);
        CHECK(m.area_error < 1e-5);
        REQUIRE(m.neighbors.size() == 1);
        CHECK(std::abs(m.neighbors[0].area - arc * length) <= m.neighbors[0].area_error);
    }
}

// The face with the last tube lies across a side of the box: all but a corner of it is taken away.
TEST_CASE("complete measures: a neighbour whose face is smaller than its bound is told by its edges") {
    Scene scene;
    scene.base = Cylinder{{22.40779254955122, 53.260290268721, 81.74176282147076},
                          {0.47668081418679514, 2.03356994680237, 1.299563208879239},
                          0.5};
    scene.objects = {Cylinder{{62.5432454224778, 74.21987150796559, 70.26436233656021},
                              {-0.30915096159090805, 0.04866508941055065, 0.25903623708180196},
                              0.5},
                     Cylinder{{30.224727042962606, 83.99953843959486, 97.27167778464195},
                              {-1.239081143794203, -0.3841856689916833, -0.29325195613856225},
                              0.5},
                     Cylinder{{48.35658957368232, 84.22860382968457, 76.64860434424992},
                              {0.9672734533206113, 0.6141533768299428, -0.05650585310039292},
                              0.5},
                     Cylinder{{34.22532475050119, 87.85813131933597, 92.59259223572725},
                              {-1.530238605380879, -0.025061431371218055, 1.5628319110659297},
                              0.5},
                     Cylinder{{73.45930652464952, 98.37578550804616, 43.335393910111776},
                              {1.8005561345611236, 2.0639722140569545, -0.3708263855187017},
                              0.5},
                     Cylinder{{76.55539046042276, 22.31422039380737, 26.830540310874838},
                              {-2.098789744268936, -0.5427545707626147, 1.6245899491042612},
                              0.5},
                     Cylinder{{51.99253554794395, 78.24537641761061, 58.088142477191994},
                              {0.7082993083442368, -0.45613160306967054, -1.5634907122667765},
                              0.5}};
    scene.box = {Vec3::Zero(), Vec3::Constant(100)};
    // On that side there is a point as near to both, and to no other.
    const Vec3 place(31.742, 87.303, 100);
    const double own = distance(scene.base, place);
    CHECK(std::abs(own - distance(scene.objects.back(), place)) < 1e-3);
    for (std::size_t i = 0; i + 1 < scene.objects.size(); ++i)
        CHECK(distance(scene.objects[i], place) > own + 0.02);
    const CompleteMeasures m = complete_measures(scene);
    const auto& last = m.neighbors.back();
    CHECK(last.object + 1 == scene.objects.size());
    CHECK(last.area < last.area_error);
    CellOptions options;
    options.complete = true;
    const Cell cell = voronoi_cell(scene, options);
    CHECK(m.neighbors.size() == cell.neighbors.size());
    CHECK(cell.neighbors.back() + 1 == scene.objects.size());
}

TEST_CASE("complete measures: they are the cell's where no ray comes from outside the box") {
    const std::vector<Object> objects{Sphere{{3, 3, 3}, 1}, Sphere{{7, 6, 4}, 0.5},
                                      Cylinder{{2, 8, 0}, {0, 0, 1}, 0.5}, Plane{{0, 0, 0.5}, {0, 0, 1}}};
    for (const Base& base : bases_of(objects)) {
        if (base.object == 2) continue;  // the plane cuts it
        Scene scene = scene_of(objects, base);
        if (base.object == 3) scene.objects.pop_back();
        const CompleteMeasures m = complete_measures(scene);
        const Cell cell = voronoi_cell(scene);
        CHECK(std::abs(m.volume - cell.measures.volume) <= m.volume_error + cell.measures.volume_error);
        CHECK(std::abs(m.area - cell.measures.area) <= m.area_error + cell.measures.area_error);
        CHECK(m.volume_error <= 1.5 * cell.measures.volume_error + 1e-12);
        REQUIRE(m.neighbors.size() == cell.neighbors.size());
        for (std::size_t i = 0; i < m.neighbors.size(); ++i)
            CHECK(m.neighbors[i].object == cell.neighbors[i]);
    }
}

TEST_CASE("complete measures: a scene times a power of two has them times its powers") {
    std::mt19937_64 rng(test_seed());
    const std::vector<Object> tubes = random_tubes(rng, 3, 0.3);
    Scene scene = scene_of(tubes, {tubes[0], 0});
    const CompleteMeasures m = complete_measures(scene);
    const auto times = [](Object& o, double factor) {
        auto& tube = std::get<Cylinder>(o);
        tube.point *= factor;
        tube.radius *= factor;
    };
    constexpr double factor = 0x1p40;
    times(scene.base, factor);
    for (Object& o : scene.objects) times(o, factor);
    scene.box.max *= factor;
    const CompleteMeasures large = complete_measures(scene);
    CHECK(large.volume == factor * factor * factor * m.volume);
    CHECK(large.volume_error == factor * factor * factor * m.volume_error);
    CHECK(large.area == factor * factor * m.area);
}

TEST_CASE("complete measures: an object that cuts the base outside the box is refused") {
    Scene scene;
    scene.base = Plane{{2, 5, 4}, {1, 0, 2}};
    scene.objects = {Sphere{{-2, 5, 6}, 0.75}};
    scene.box = cube;
    CHECK_NOTHROW(voronoi_cell(scene));
    try {
        complete_measures(scene);
        CHECK(false);
    } catch (const InputError& e) {
        CHECK(e.kind == InputError::Kind::TouchesBase);
        CHECK(e.object == 0);
    }
}

}  // namespace vcell::complete_measures_test
