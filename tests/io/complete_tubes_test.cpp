// Cells of all of the box that is nearest to an oblique base tube: against complete_measures(), which gets
// there by other cells, against distances at random points, and as closed surfaces that fill the box
// together.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../../core/errors.hpp"
#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/pictures/svg.hpp"
#include "../random_tubes.hpp"
#include "../test_support.hpp"
#include "complete_checks.hpp"
#include "listing.hpp"

using namespace vcell;

namespace {

const Box cube{Vec3::Zero(), Vec3::Constant(10)};

Scene scene_of(const std::vector<Object>& objects, std::size_t base) {
    Scene scene;
    scene.base = objects[base];
    scene.objects = objects;
    scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(base));
    scene.box = cube;
    return scene;
}

/// Proved; where integrals are hard, with more effort.
void check_certificate_of_parts(const Cell& cell) {
    Certificate certificate = certify(cell);
    CHECK_MESSAGE(certificate.count(Verdict::refuted) == 0, listing(certificate));
    if (!certificate.holds()) {
        CheckOptions options;
        options.effort += 2;
        certificate = certify(cell, options);
    }
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
}

void check_tube_cell(const Cell& cell, std::mt19937_64& rng) {
    REQUIRE(cell.is_complete);
    CHECK(cell.measures.volume_error <= 5e-2);
    check_complete_measures(cell, complete_measures(cell.scene), cell.measures.area_error);
    check_certificate_of_parts(cell);
    const CellMesh mesh = checked_mesh(cell);
    check_points(cell, mesh, rng);
    // Chords are measured at their middles, and are a little longer elsewhere.
    for (const Vec3& p : mesh.points) {
        CHECK(p.minCoeff() > -1.5 * chord);
        CHECK(p.maxCoeff() < 10 + 1.5 * chord);
    }
}

/// The volume of the complete cells, and their bounds together.
std::array<double, 2> tile(const std::vector<Object>& objects, std::mt19937_64& rng) {
    std::array<double, 2> sum{};
    for (std::size_t i = 0; i < objects.size(); ++i) {
        CAPTURE(i);
        const Cell cell = complete_cell(scene_of(objects, i));
        check_tube_cell(cell, rng);
        sum[0] += cell.measures.volume;
        sum[1] += cell.measures.volume_error;
    }
    return sum;
}

}  // namespace

// Beside three others, not far from where its rays come in through a side, all that shows of them is three
// faces that meet in a vertex: so small that one piece holds them, whose rim tells nothing of them.
TEST_CASE("complete tubes: faces that nothing joins to others are islands of the face around them") {
    std::mt19937_64 rng(test_seed());
    const std::vector<Object> tubes{Cylinder{{9.215956608343024, 2.6051441598083325, 9.743597610384949},
                                             {-0.05593461247449121, -0.9357331707281962, 0.34824524738506474},
                                             0.04},
                                    Cylinder{{8.886746114696109, 0.14856980375721363, 8.008642576555111},
                                             {0.14913127730120931, -0.23931321610921236, -0.9594212040214534},
                                             0.04},
                                    Cylinder{{9.393355068865382, 0.7951648699113067, 9.02820604571657},
                                             {0.6795335394567411, -0.40855003539902435, -0.6093611714975362},
                                             0.04},
                                    Cylinder{{9.071420389970998, 1.8275298021214703, 9.975346310513752},
                                             {-0.23544532605100474, 0.9685393866782248, 0.0806036903231122},
                                             0.04}};
    check_tube_cell(complete_cell(scene_of(tubes, 0)), rng);
}

TEST_CASE("complete tubes: random oblique tubes tile their box") {
    std::mt19937_64 rng(test_seed());
    const int tubes = rounds() > 1 ? 30 : 8;
    for (int i = 0; i < rounds(); ++i) {
        const auto [volume, bound] = tile(random_tubes(rng, tubes, 0.15), rng);
        CHECK(std::abs(volume - 1000) <= bound + 1e-9);
        CHECK(bound <= 1e-2);
    }
}

TEST_CASE("complete tubes: thick ones tile their box, too") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(2); ++i) {
        const auto [volume, bound] = tile(random_tubes(rng, 5, 0.6), rng);
        CHECK(std::abs(volume - 1000) <= bound + 1e-9);
    }
}

TEST_CASE("complete tubes: in small integers they tile their box") {
    std::mt19937_64 rng(test_seed());
    const auto [volume, bound] = tile({Cylinder{{0, 0, 0}, {1, 2, 3}, 1}, Cylinder{{8, 0, 2}, {1, -2, 2}, 1},
                                       Cylinder{{0, 8, 0}, {2, 1, 3}, 0}},
                                      rng);
    CHECK(std::abs(volume - 1000) <= bound + 1e-9);
}

TEST_CASE("complete tubes: among balls and planes, and with the axis beside the box") {
    std::mt19937_64 rng(test_seed());
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{5, 4, 5}, {1, 2, 3}, 0.5};
    scene.objects = {Sphere{{8, 2, 5}, 1}, Sphere{{2, 8, 4}, 0.5}, Cylinder{{1, 1, 0}, {1, -1, 2}, 0.25}};
    check_tube_cell(complete_cell(scene), rng);
    scene.base = Cylinder{{-1, 5, 5}, {0.05, 3, 4}, 0.25};
    check_tube_cell(complete_cell(scene), rng);
}

namespace {

/// A thin tube through (5, 5, 5), or near it, along an axis of the box or not, a ball and a tube that hold
/// cross sections of it, and two balls beside it.
Scene held_scene(std::mt19937_64& rng, bool is_oblique) {
    std::uniform_real_distribution<double> part(-1, 1), coordinate(0, 10);
    const auto random = [&](auto& from) {
        const double x = from(rng), y = from(rng), z = from(rng);
        return Vec3(x, y, z);
    };
    Scene scene;
    scene.box = cube;
    const Vec3 axis = is_oblique ? random(part).normalized() : Vec3::UnitZ().eval(),
               middle = Vec3::Constant(5) + random(part);
    scene.base = Cylinder{middle, axis, 0.1 * (1 + part(rng))};
    const Vec3 aside = axis.unitOrthogonal(), along = axis.cross(aside) + (0.8 * part(rng)) * axis;
    scene.objects = {Sphere{middle + 2 * axis + 0.5 * aside, 1 + 0.2 * part(rng)},
                     Cylinder{middle - 2 * axis + 0.4 * part(rng) * aside, along, 1 + 0.2 * part(rng)},
                     Sphere{random(coordinate), 0.3}, Sphere{random(coordinate), 0.3}};
    return scene;
}

}  // namespace

TEST_CASE("complete tubes: what others hold of them is theirs") {
    std::mt19937_64 rng(test_seed());
    int cut = 0;
    for (int i = 0; i < long_rounds(3); ++i)
        for (const bool is_oblique : {false, true}) {
            const Scene scene = held_scene(rng, is_oblique);
            const Cell cell = complete_cell(scene);
            check_tube_cell(cell, rng);
            // Two gaps of the axis, each wider than half of what holds it there.
            const auto& base = std::get<Cylinder>(scene.base);
            std::vector<double> gaps;
            for (std::size_t k = 1; k < cell.parts.size(); ++k)
                gaps.push_back(base.axis.normalized().dot(cell.parts[k].ends[0] - cell.parts[k - 1].ends[1]));
            cut += std::ranges::count_if(gaps, [](double gap) { return gap > 1; }) == 2 ? 1 : 0;
            const Cell same = voronoi_cell(scene);  // it has no other
            CHECK(same.is_complete);
            CHECK(same.measures.volume == cell.measures.volume);
        }
    CHECK(cut > long_rounds(3));
}

// Half of a cube and more: what a ball of radius 1 and the paraboloids about it take from a line through its
// centre is rotated about that, and so are the volumes that integrals of one variable tell.
TEST_CASE("complete tubes: beside a ball on its axis a line has what is outside a paraboloid") {
    Scene scene;
    scene.box = {{-2, -2, -4}, {2, 2, 4}};
    scene.base = Cylinder{Vec3::Zero(), {0, 0, 1}, 0};
    scene.objects = {Sphere{Vec3::Zero(), 1}};
    const Cell cell = complete_cell(scene);
    check_certificate_of_parts(cell);
    // A point (rho, z) is as far from both where rho + 1 = |(rho, z)|: 2 rho = z^2 - 1. Before it comes to
    // the sides, at z^2 = 5, sections are discs; from there to where it comes to edges they are squares less
    // what is beyond the disc.
    const auto disc = [](double z) { return std::pow(0.5 * (z * z - 1), 2); };
    double expected = 0;
    constexpr int steps = 200000;
    for (int i = 0; i < steps; ++i) {
        const double z = 1 + 3 * (i + 0.5) / steps, r2 = disc(z);
        double section = 16;
        if (r2 <= 4) {
            section = std::numbers::pi * r2;
        } else if (r2 < 8) {
            const double half = std::sqrt(r2 - 4);
            section = 16 - 4 * ((2 - half) * (2 - half) -
                                (r2 * (std::asin(2 / std::sqrt(r2)) - std::asin(half / std::sqrt(r2))) / 2 -
                                 half * (2 - half)));
        }
        expected += 2 * section * 3 / steps;
    }
    CHECK(cell.measures.volume == doctest::Approx(expected).epsilon(1e-8));
}

// A plane across the axis meets the box in that edge last, and the point is the axis's mirror image there.
TEST_CASE("complete tubes: an object ties with two sides all along the last edge of the box") {
    Scene scene;
    scene.box = {Vec3::Constant(-6), Vec3::Constant(6)};
    scene.base = Cylinder{{-2, 1, -1}, {0, 1, 1}, 0};
    scene.objects = {Sphere{{-2, 5, 5}, 0}};
    const Cell cell = complete_cell(scene);
    check_complete_measures(cell, complete_measures(scene), cell.measures.area_error);
    const Certificate certificate = certify(cell);
    CHECK_MESSAGE(certificate.count(Verdict::refuted) == 0, listing(certificate));
    CHECK(is_proved(certificate, "measures.volume"));
}

// The bisector is two planes, and over the base next to their common line, where the face is, heights are
// beyond all bounds.
TEST_CASE("complete tubes: a tube of the base's radius may cross its axis beyond the box") {
    Scene scene;
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    scene.base = Cylinder{{2, 3, 2}, {0, 0, 1}, 0};
    scene.objects = {Cylinder{{2, -1, 3}, {1, 1, 1}, 0}, Cylinder{{1, 2, 2}, {1, 1, 0}, 0.25},
                     Sphere{{0, -3, -1}, 0}, Cylinder{{-3, -2, 2}, {1, 1, 1}, 0}};
    const Certificate certificate = certify(complete_cell(scene));
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
}

TEST_CASE("complete tubes: through edges and corners of the box, along its sides and beside it") {
    std::mt19937_64 rng(test_seed());
    const Cylinder other{{6, 5, 3}, {1, -2, 2}, 0.5};
    for (const Cylinder& tube : {
             Cylinder{{10, 0, 0}, {-1, 2, 2}, 0.25},  // through a corner
             Cylinder{{0, 0, 0}, {1, 1, 1}, 0.25},    // through two
             Cylinder{{0, 0, 4}, {1, 2, 3}, 0.25},    // through an edge
             Cylinder{{5, 5, 5}, {1, 1, 0}, 0.25},    // through two
             Cylinder{{5, 5, 5}, {1, 2, 2}, 0},       // through two
             Cylinder{{4, 5, 5}, {3, 4, 0}, 0.5},     // along two sides
             Cylinder{{5, 5, 5}, {1e-9, 3, 4}, 0.5},  // all but along two
             Cylinder{{-1, 5, 5}, {0, 3, 4}, 1},      // touches a side from outside
             Cylinder{{-1, -2, 3}, {1, -2, 2}, 0.5},  // meets the box nowhere
         }) {
        CAPTURE(tube.point.transpose());
        CAPTURE(tube.axis.transpose());
        const auto [volume, bound] = tile({tube, other}, rng);
        CHECK(std::abs(volume - 1000) <= bound + 1e-9);
    }
}

TEST_CASE("complete tubes: where the axis lies on a side of the box they are refused") {
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{0, 5, 5}, {0, 1, 1}, 0.25};
    scene.objects = {Cylinder{{6, 5, 3}, {1, -2, 2}, 0.5}};
    CHECK_THROWS_AS(complete_cell(scene), UndecidedError);
}

TEST_CASE("complete tubes: along an axis of the box they stay as they are") {
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{5, 4, 5}, {0, 0, 1}, 0.5};
    scene.objects = {Sphere{{8, 2, 5}, 1}};
    const Cell cell = complete_cell(scene);
    CHECK_FALSE(cell.is_complete);
    CHECK(cell.measures.volume == voronoi_cell(scene).measures.volume);
}

TEST_CASE("complete tubes: files hold them, pictures show them, and certificates say what is left out") {
    std::mt19937_64 rng(test_seed());
    const Cell cell = complete_cell(scene_of(random_tubes(rng, 4, 0.3), 0));
    std::stringstream file;
    write_cell(file, cell);
    const Cell read = parse_cell(file.str());
    CHECK(read.is_complete);
    REQUIRE(!cell.parts.empty());
    REQUIRE(read.parts.size() == cell.parts.size());
    for (std::size_t k = 0; k < cell.parts.size(); ++k) {
        CHECK(read.parts[k].ends == cell.parts[k].ends);
        CHECK(read.parts[k].faces == cell.parts[k].faces);
    }
    std::stringstream again;
    write_cell(again, read);
    CHECK(again.str() == file.str());
    const Certificate certificate = certify(read);  // with what closes it
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
    const auto slabs = std::ranges::find(certificate.elements, "parts", &Element::where);
    REQUIRE(slabs != certificate.elements.end());
    CHECK(slabs->amount > 0);
    CHECK(slabs->amount < 1e-4);
    CHECK(slabs->what.find("left out") != std::string::npos);
    std::stringstream picture;
    write_svg(picture, cell);
    CHECK(picture.str().find("class=\"face") != std::string::npos);
}

TEST_CASE("complete tubes: scaled and moved cells are proved, too") {
    std::mt19937_64 rng(test_seed());
    Scene scene = scene_of(random_tubes(rng, 3, 0.3), 0);
    const auto change = [](const Scene& from, double factor, const Vec3& way) {
        Scene to = from;
        const auto changed = [&](const Cylinder& tube) {
            return Cylinder{factor * tube.point + way, tube.axis, factor * tube.radius};
        };
        to.base = changed(std::get<Cylinder>(from.base));
        for (Object& o : to.objects) o = changed(std::get<Cylinder>(o));
        to.box = {factor * from.box.min + way, factor * from.box.max + way};
        return to;
    };
    for (const Scene& each : {change(scene, 0x1p-70, Vec3::Zero()), change(scene, 1, {-3, 40, 8}),
                              change(scene, 1e6, {5, 5, -5})}) {
        const Certificate certificate = certify(complete_cell(each));
        CHECK_MESSAGE(certificate.holds(), listing(certificate));
    }
    // So far out faces may stay open, but where the parts are is told: ends are as near to the planes of
    // sides as some roundings of their coordinates.
    const Cell far = complete_cell(change(scene, 1, {1e6, 1e6, -1e6}));
    const Certificate certificate = certify(far);
    for (std::size_t k = 0; k < far.parts.size(); ++k)
        CHECK(is_proved(certificate, "parts[" + std::to_string(k) + "]"));
}

// --- Damage ---------------------------------------------------------------------------------------------

namespace {

/// Below the box, where the axis comes no nearer, and close above the bottom a row of balls: what is nearest
/// to the tube beyond the row has no contact with what is before it.
Scene tube_below_a_row() {
    Scene scene;
    scene.base = Cylinder{{5, 5, -1}, {1, 0, 0.05}, 0.25};
    scene.box = cube;
    for (int i = 0; i < 16; ++i) scene.objects.push_back(Sphere{{4, 0.7 * i - 0.2, 0.55}, 0.4});
    scene.objects.push_back(Sphere{{8, 5, 4}, 1});
    return scene;
}

Scene damaged_scene() {
    Scene scene;
    scene.box = cube;
    scene.base = Cylinder{{5, 4, 5}, {1, 2, 3}, 0.5};
    scene.objects = {Sphere{{8, 2, 5}, 1}, Sphere{{2, 8, 4}, 0.5}, Cylinder{{1, 1, 0}, {1, -1, 2}, 0.25}};
    return scene;
}

/// The first part with a floor and the first without one that have faces.
std::array<std::size_t, 2> parts_of_both_kinds(const Cell& cell) {
    std::array<std::optional<std::size_t>, 2> found;
    for (std::size_t k = 0; k < cell.parts.size(); ++k) {
        const Vec3 middle = 0.5 * (cell.parts[k].ends[0] + cell.parts[k].ends[1]);
        const bool is_inside = (middle.array() > cell.scene.box.min.array()).all() &&
                               (middle.array() < cell.scene.box.max.array()).all();
        if (cell.parts[k].faces > 0 && !found[is_inside]) found[is_inside] = k;
    }
    return {found[0].value(), found[1].value()};
}

std::vector<int> times_without(const Cell& cell, std::size_t part) {
    std::vector<int> times;
    for (std::size_t k = 0; k < cell.parts.size(); ++k)
        times.insert(times.end(), cell.parts[k].faces, k == part ? 0 : 1);
    return times;
}

/// The first face of a part.
std::size_t first_face(const Cell& cell, std::size_t part) {
    std::size_t face = 0;
    for (std::size_t k = 0; k < part; ++k) face += cell.parts[k].faces;
    return face;
}

}  // namespace

TEST_CASE("complete tubes: faces that are dropped, moved or another's are refuted in parts of both kinds") {
    const Cell good = complete_cell(damaged_scene());
    struct Damage {
        const char* where;
        std::function<void(Cell&, std::size_t face, std::uint32_t edge, std::uint32_t vertex)> make;
    };
    const std::array damages{
        Damage{"edges",
               [&](Cell& c, std::size_t face, auto, auto) {
                   std::vector<int> times(good.faces.size(), 1);
                   times[face] = 0;
                   c = with_faces(good, times);
               }},
        Damage{"vertices[", [](Cell& c, auto, auto, std::uint32_t v) { c.vertices[v].point.x() += 1e-4; }},
        Damage{"edges[",
               [](Cell& c, auto, std::uint32_t edge, auto) {
                   for (Eigen::Vector4d& p : c.edges[edge].curve.points) p.y() += 1e-4;
               }},
        Damage{"",
               [](Cell& c, std::size_t face, auto, auto) {
                   Site& site = c.faces[face].site;
                   site = site == Site::object(0) ? Site::object(1) : Site::object(0);
               }},
        Damage{"faces[",
               [](Cell& c, std::size_t face, auto, auto) {
                   for (Eigen::Vector4d& p : c.faces[face].patches[0].surface.points) p.head<3>() *= 1 + 1e-5;
               }},
    };
    std::size_t turn = 0;
    for (const Damage& damage : damages)
        for (const std::size_t part : parts_of_both_kinds(good)) {
            if (rounds() == 1 && turn++ % 3 == 1) continue;
            CAPTURE(part);
            CAPTURE(damage.where);
            const std::size_t face = first_face(good, part);
            const std::uint32_t edge = *good.faces[face].patches[0].loops[0][0].edge;
            Cell bad = good;
            damage.make(bad, face, edge, good.edges[edge].vertices[0]);
            CHECK(is_refuted(certify(bad), damage.where));
        }
}

TEST_CASE("complete tubes: a part that is dropped, doubled or empty is not proved") {
    const Cell good = complete_cell(damaged_scene());
    REQUIRE(certify(good).holds());
    for (const std::size_t part : parts_of_both_kinds(good)) {
        CAPTURE(part);
        const Cell empty = with_faces(good, times_without(good, part));
        const std::string where = "parts[" + std::to_string(part) + "]";
        const Certificate certificate = certify(empty);
        CHECK_FALSE(
            is_proved(certificate, where + (part == parts_of_both_kinds(good)[0] ? ".entries" : ".faces")));
        CHECK_FALSE(certificate.holds());
        Cell dropped = empty;
        dropped.parts.erase(dropped.parts.begin() + static_cast<std::ptrdiff_t>(part));
        CHECK_FALSE(is_proved(certify(dropped), "parts"));
        Cell merged = good;
        merged.parts[part - 1].ends[1] = merged.parts[part].ends[1];
        merged.parts[part - 1].faces += merged.parts[part].faces;
        merged.parts.erase(merged.parts.begin() + static_cast<std::ptrdiff_t>(part));
        CHECK(is_refuted(certify(merged), "parts"));
        std::vector<int> times(good.faces.size(), 1);
        for (std::size_t f = 0; f < good.parts[part].faces; ++f) times[first_face(good, part) + f] = 2;
        CHECK_FALSE(certify(with_faces(good, times)).holds());
    }
    Cell none = good;
    none.parts.clear();
    CHECK_FALSE(certify(none).holds());
    Cell not_complete = good;
    not_complete.is_complete = false;
    CHECK(is_refuted(certify(not_complete), "parts"));
    Cell swapped = good;
    std::swap(swapped.parts[0], swapped.parts[1]);
    CHECK(is_refuted(certify(swapped), "parts"));
}

TEST_CASE("complete tubes: slabs that are moved, widened or off the axis are not proved") {
    const Cell good = complete_cell(damaged_scene());
    const Vec3 along = Vec3(1, 2, 3).normalized();
    for (std::size_t k = 1; k < good.parts.size(); ++k) {
        if (good.parts[k - 1].faces == 0 || good.parts[k].faces == 0) continue;
        for (const double by : {1e-3, -1e-3, 1e-7, -1e-7}) {
            Cell bad = good;
            bad.parts[k - 1].ends[1] += by * along;
            bad.parts[k].ends[0] += by * along;
            CHECK(certify(bad).count(Verdict::refuted) > 0);
        }
        Cell wide = good;
        wide.parts[k - 1].ends[1] -= 1e-5 * along;
        CHECK(certify(wide).count(Verdict::refuted) > 0);
        Cell aside = good;
        aside.parts[k].ends[0] += 1e-9 * along.unitOrthogonal();
        CHECK(is_refuted(certify(aside), "parts[" + std::to_string(k) + "].ends"));
    }
    Cell volume = good;
    volume.measures.volume += 10 * volume.measures.volume_error + 1e-6;
    CHECK_FALSE(is_proved(certify(volume), "measures.volume"));
    CHECK(is_proved(certify(good), "measures.volume"));
}

TEST_CASE("complete tubes: what is left out beside what others hold has to be held") {
    std::mt19937_64 rng(test_seed());
    const Cell good = complete_cell(held_scene(rng, true));
    CHECK(is_proved(certify(good), "parts"));
    // Gaps between parts are wide only where others hold the axis: with these elsewhere nobody does.
    Cell moved = good;
    auto& ball = std::get<Sphere>(moved.scene.objects[0]);
    ball.center += Vec3(0, 0, 20);
    CHECK_FALSE(is_proved(certify(moved), "parts"));
    Cell thin = good;
    std::get<Cylinder>(thin.scene.objects[1]).radius = 0.9 * std::get<Cylinder>(good.scene.base).radius;
    CHECK_FALSE(is_proved(certify(thin), "parts"));
}

TEST_CASE("complete tubes: what nothing joins to the others is there, once") {
    const Cell good = complete_cell(tube_below_a_row());
    const Certificate proof = certify(good);
    CHECK_MESSAGE(proof.holds(), listing(proof));
    const std::vector<std::uint32_t> roots = components(good);
    std::vector<int> without, twice;
    for (const std::uint32_t root : roots) {
        without.push_back(root == roots[0] ? 0 : 1);
        twice.push_back(root == roots[0] ? 2 : 1);
    }
    const Cell rest = with_faces(good, without);
    REQUIRE(!rest.faces.empty());
    const auto lacks_entries = [](const Cell& cell) {
        const Certificate certificate = certify(cell);
        bool lacks = false;
        for (std::size_t k = 0; k < cell.parts.size(); ++k)
            lacks = lacks || !is_proved(certificate, "parts[" + std::to_string(k) + "].entries");
        return lacks;
    };
    CHECK_FALSE(lacks_entries(good));
    CHECK(lacks_entries(rest));
    CHECK(lacks_entries(with_faces(good, twice)));
}

// Half-way between tube and balls is below the box.
TEST_CASE("complete tubes: the least clearance is that of the boundary") {
    const Cell cell = complete_cell(tube_below_a_row());
    double least = HUGE_VAL;
    for (const CellEdge& e : cell.edges) {
        constexpr int steps = 200;
        const double from = e.curve.domain_begin(), to = e.curve.domain_end();
        for (int k = 0; k <= steps; ++k) {
            const Vec3 p = e.curve.evaluate(from + (to - from) * k / steps);
            least = std::min(least, distance_from(cell.scene.base, p, true));
        }
    }
    CHECK(cell.measures.min_clearance == doctest::Approx(least).epsilon(1e-4));
}

// Next to a slab an edge between a side and an end all but runs through the axis. The plane ties at one of
// its ends, and its excess grows nowhere near the axis.
TEST_CASE("complete tubes: what is a little nearer at one end of an edge is told there") {
    Scene scene;
    scene.base = Cylinder{{-0.75, 0, 0.75}, {0.25, 1, 0}, 0.25};
    scene.objects = {Cylinder{{0, 0, 0.75}, {0.25, 1, 0}, 0.25},
                     Cylinder{{-0.375, 0, 1.75}, {0.25, 1, 0}, 0.125}, Plane{{0, 0, 0}, {0, 0, 1}}};
    scene.box = {{-1, -1, 0}, {1, 1, 2}};
    const Certificate certificate = certify(complete_cell(scene));
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
    CHECK(certificate.distance < 1e-6);
}

// The axis turns by its rounding, and is along the plane no longer: the scene's own numbers tell the name.
TEST_CASE("complete tubes: the bisector with a plane along the axis is a parabolic cylinder") {
    std::mt19937_64 rng(test_seed());
    std::uniform_int_distribution<int> digit(-3, 3);
    const auto random = [&] {
        const int x = digit(rng), y = digit(rng), z = digit(rng);
        return Vec3(x, y, z);
    };
    int faces = 0;
    for (int round = 0; round < 20; ++round) {
        const Vec3 axis = random(), normal = axis.cross(random());
        if ((axis.array() != 0).count() < 2 || normal.isZero()) continue;
        Scene scene;
        scene.box = cube;
        scene.base = Cylinder{{5, 5, 5}, axis, 0.25};
        scene.objects = {Plane{Vec3::Constant(5) + 2.5 * normal.normalized(), normal}};
        const Cell cell = complete_cell(scene);
        CAPTURE(axis.transpose());
        CAPTURE(normal.transpose());
        for (const CellFace& f : cell.faces) {
            if (!f.site.is_object()) continue;
            ++faces;
            CHECK(f.bisector == "parabolic cylinder");
        }
        const Certificate certificate = certify(cell);
        CHECK_MESSAGE(certificate.count(Verdict::refuted) == 0, listing(certificate));
    }
    CHECK(faces > 0);
}
