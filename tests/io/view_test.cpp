// Pictures in space: what covers what, and where things are seen.
#include "../../io/pictures/view.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/pictures/solids.hpp"
#include "test_support.hpp"

namespace vcell {
namespace {

using Pixel = std::array<int, 3>;

Pixel pixel(const Image& image, std::size_t x, std::size_t y) {
    const std::uint8_t* p = image.bytes.data() + 3 * (y * image.width + x);
    return {p[0], p[1], p[2]};
}

constexpr Pixel white{255, 255, 255};
constexpr Colour red{1, 0, 0}, green{0, 1, 0}, black{0, 0, 0};
constexpr std::array<double, 3> lit{1, 1, 1};

/// A square of two triangles.
void add_square(Raster& raster, double low, double high, double z, const Colour& colour, float opacity) {
    const Vec3 a(low, low, z), b(high, low, z), c(high, high, z), d(low, high, z);
    raster.triangle({a, b, c}, lit, colour, opacity);
    raster.triangle({a, c, d}, lit, colour, opacity);
}

/// A ball, and another one beside it along x.
Scene two_balls() {
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 0.5};
    scene.objects = {Sphere{{2, 0, 0}, 0.5}};
    scene.box = {Vec3::Constant(-3), Vec3::Constant(3)};
    return scene;
}

Image view(const Scene& scene, const ViewOptions& options) {
    const Cell cell = voronoi_cell(scene);
    return draw_view(cell, tessellate(cell, {0.05}), options);
}

/// The columns and rows that are not white, first and last.
std::array<std::size_t, 4> extent(const Image& image) {
    std::array<std::size_t, 4> found{image.width, 0, image.height, 0};
    for (std::size_t y = 0; y < image.height; ++y)
        for (std::size_t x = 0; x < image.width; ++x)
            if (pixel(image, x, y) != white)
                found = {std::min(found[0], x), std::max(found[1], x), std::min(found[2], y),
                         std::max(found[3], y)};
    return found;
}

}  // namespace

TEST_CASE("raster: triangles that fill a square between them cover each of its pixels once") {
    std::mt19937_64 random(test_seed());
    std::uniform_real_distribution<double> inside(2, 30);
    for (int round = 0; round < 50; ++round) {
        Raster raster(32, 32);
        // A fan about a point: its sides go in every direction.
        const Vec3 middle(inside(random), inside(random), 0);
        std::vector<Vec3> ring{
            {1, 1, 0}, {1, inside(random), 0}, {1, 31, 0}, {31, 31, 0}, {inside(random), 1, 0}};
        ring.insert(ring.begin() + 4, Vec3(31, 1, 0));
        for (std::size_t i = 0; i < ring.size(); ++i)
            raster.triangle({middle, ring[i], ring[(i + 1) % ring.size()]}, lit, black, 0.5F);
        const Image image = raster.image(1);
        for (std::size_t y = 0; y < 32; ++y)
            for (std::size_t x = 0; x < 32; ++x) {
                const bool is_in = x >= 1 && x < 31 && y >= 1 && y < 31;
                CHECK(pixel(image, x, y) == (is_in ? Pixel{128, 128, 128} : white));
            }
    }
}

TEST_CASE("raster: what is nearer hides, whatever is drawn first, and what is translucent lets through") {
    for (const bool is_red_first : {true, false}) {
        Raster raster(8, 8);
        if (is_red_first) add_square(raster, 1, 6, 1, red, 1);
        add_square(raster, 2, 7, 2, green, 0.5F);
        if (!is_red_first) add_square(raster, 1, 6, 1, red, 1);
        const Image image = raster.image(1);
        CHECK(pixel(image, 1, 1) == Pixel{255, 0, 0});
        CHECK(pixel(image, 3, 3) == Pixel{128, 128, 0});
        CHECK(pixel(image, 6, 6) == Pixel{128, 255, 128});
        CHECK(pixel(image, 0, 0) == white);
    }
    Raster raster(8, 8);
    add_square(raster, 0, 8, 1, red, 1);
    raster.line({0, 4, 0.5}, {8, 4, 0.5}, 0.5, 1, black);
    raster.line({4, 0, -5}, {4, 8, -5}, 0.5, 1, black);
    const Image image = raster.image(1);
    CHECK(pixel(image, 2, 4) == Pixel{0, 0, 0});
    CHECK(pixel(image, 2, 3) == Pixel{255, 0, 0});
    CHECK(pixel(image, 4, 2) == Pixel{255, 0, 0});
}

TEST_CASE("view: x is to the right from the south, to the left from the north, and z is upwards") {
    const Scene scene = two_balls();
    ViewOptions options;
    options.size = 64;
    // Is the place at x, y from the middle, in parts of the box, of the colour of the object's balls: yellow,
    // blue, ... and no grey?
    const auto is_coloured = [&](double x, double y) {
        const Image image = view(scene, options);
        const double unit = 0.94 * 64 / 6;
        const Pixel p =
            pixel(image, static_cast<std::size_t>(32 + unit * x), static_cast<std::size_t>(32 - unit * y));
        return *std::ranges::max_element(p) - *std::ranges::min_element(p) > 30;
    };
    options.elevation = 90;
    options.azimuth = -90;
    CHECK(is_coloured(2, 0));
    CHECK_FALSE(is_coloured(-2, 0));
    options.azimuth = 90;
    CHECK(is_coloured(-2, 0));
    CHECK_FALSE(is_coloured(2, 0));
    options.azimuth = 0;
    CHECK(is_coloured(0, -2));
    CHECK_FALSE(is_coloured(0, 2));
    options.elevation = 0;
    options.azimuth = -90;
    CHECK(is_coloured(2, 0));
    CHECK_FALSE(is_coloured(-2, 0));
    options.has_objects = false;
    CHECK(view(scene, options).bytes.size() == 3 * 64 * 64);
    Scene turned = scene;
    turned.objects = {Sphere{{0, 0, 2}, 0.5}};
    options.has_objects = true;
    const Image image = view(turned, options);
    const Pixel high = pixel(image, 32, 12), low = pixel(image, 32, 52);
    CHECK(*std::ranges::max_element(high) - *std::ranges::min_element(high) > 30);
    CHECK(*std::ranges::max_element(low) - *std::ranges::min_element(low) < 10);
}

TEST_CASE("view: the picture is filled by what there is, and clips leave half of the cell") {
    const Scene scene = two_balls();
    ViewOptions options;
    options.size = 100;
    options.elevation = 90;
    options.azimuth = -90;
    options.has_objects = false;
    const auto whole = extent(view(scene, options));
    const std::size_t side = std::max(whole[1] - whole[0], whole[3] - whole[2]);
    CHECK(side >= 92);
    CHECK(side <= 97);
    options.clips = {Plane{Vec3::Zero(), -Vec3::UnitY()}};
    const auto half = extent(view(scene, options));
    CHECK(half[1] - half[0] > whole[1] - whole[0]);
    CHECK((half[3] - half[2]) * 10 < (half[1] - half[0]) * 8);
}

TEST_CASE("solids: surfaces are where the objects are, and end at the box") {
    const Box box{Vec3::Constant(-1), {1, 2, 1}};
    const std::array<Object, 6> objects{Plane{{0, 0, 0.25}, {1, 2, 3}},
                                        Sphere{{0.5, 0, 0}, 2},
                                        HollowSphere{{0, 0, 0}, 1.5},
                                        Cylinder{{0, 5, 0.5}, {0.1, 1, 0}, 0.25},
                                        HollowCylinder{{0, 0, 0}, {0, 0, 2}, 0.75},
                                        HollowCone{{0, 0, -0.5}, {0.5, 0, 1}, 3, 5}};
    for (const Object& object : objects) {
        const std::vector<CornerTriangle> triangles = surface_of(object, box);
        CHECK(triangles.size() > 1);
        for (const CornerTriangle& triangle : triangles)
            for (const Corner& c : triangle) {
                if (!std::holds_alternative<Sphere>(object)) {
                    CHECK((c.point.array() > box.min.array() - 1e-12).all());
                    CHECK((c.point.array() < box.max.array() + 1e-12).all());
                }
                struct {
                    Vec3 p;
                    double operator()(const Plane& o) const { return o.normal.normalized().dot(p - o.point); }
                    double operator()(const Sphere& o) const { return (p - o.center).norm() - o.radius; }
                    double operator()(const HollowSphere& o) const {
                        return (p - o.center).norm() - o.radius;
                    }
                    double from(const Vec3& point, const Vec3& axis, double radius) const {
                        return axis.normalized().cross(p - point).norm() - radius;
                    }
                    double operator()(const Cylinder& o) const { return from(o.point, o.axis, o.radius); }
                    double operator()(const HollowCylinder& o) const {
                        return from(o.point, o.axis, o.radius);
                    }
                    double operator()(const HollowCone& o) const {
                        const double sine = o.radius / o.slant;
                        return sine * o.axis.normalized().dot(p - o.apex) -
                               std::sqrt(1 - sine * sine) * from(o.apex, o.axis, 0);
                    }
                } distance{c.point};
                CHECK(std::abs(std::visit(distance, object)) < 0.01 * 2);
            }
    }
}

}  // namespace vcell
