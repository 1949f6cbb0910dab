// Cells of whole diagrams that share their faces, beside the same cells by the engine, each by itself.
#include <doctest/doctest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "../../envelope/whole/ball_cell.hpp"
#include "../../primitives/bases/sphere_base.hpp"
#include "../test_support.hpp"

namespace vcell::shared_faces_test {
namespace {

using State = DiagramCell::State;

// Scenes of some thirty balls, among them many in which more than four tie.
DiagramScene shared_scene(int kind, std::mt19937_64& rng) {
    const auto uniform = [&](double a, double b) {
        return std::uniform_real_distribution<double>(a, b)(rng);
    };
    const auto integer = [&](int below) { return static_cast<double>(rng() % below); };
    const auto random_radius = [&] { return std::pow(10, uniform(-4, -1)); };
    DiagramScene scene;
    scene.box = {Vec3::Zero(), Vec3::Ones()};
    switch (kind) {
        case 0:  // small integers, some of them one ball, some in another one
            scene.box.max = Vec3::Constant(6);
            for (int i = 0; i < 40; ++i)
                scene.objects.push_back(
                    Sphere{{1 + integer(5), 1 + integer(5), 1 + integer(5)}, 0.25 * integer(3)});
            break;
        case 1:  // the same, of two radii, in a box that repeats along two axes
            scene.box.max = Vec3::Constant(4);
            scene.periodic = {true, true, false};
            for (int i = 0; i < 30; ++i)
                scene.objects.push_back(
                    Sphere{{integer(4) + 0.5, integer(4) + 0.5, integer(4) + 0.5}, 0.5 * integer(2)});
            break;
        case 2:  // face-centred cubic
            scene.box.max = Vec3::Constant(4);
            scene.periodic = {true, true, true};
            for (int i = 0; i < 32; ++i) {
                constexpr std::array<std::array<int, 3>, 4> places{
                    {{0, 0, 0}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}}};
                const auto& p = places[static_cast<std::size_t>(i % 4)];
                scene.objects.push_back(
                    Sphere{Vec3(2 * (i / 4 % 2) + p[0], 2 * (i / 8 % 2) + p[1], 2 * (i / 16) + p[2]), 0.25});
            }
            break;
        case 3:  // radii over three decades
            for (int i = 0; i < 50; ++i)
                scene.objects.push_back(
                    Sphere{{uniform(0, 1), uniform(0, 1), uniform(0, 1)}, random_radius()});
            break;
        case 4:  // in a box that leans
            scene.periodic = {true, true, true};
            scene.tilt = {0.3, -0.2, 0.1};
            for (int i = 0; i < 40; ++i)
                scene.objects.push_back(
                    Sphere{{uniform(0, 1), uniform(0, 1), uniform(0, 1)}, random_radius()});
            break;
        case 5:  // all but one ball: what is between them is small against their radii
            for (int i = 0; i < 60; ++i)
                scene.objects.push_back(
                    Sphere{Vec3::Constant(0.5) + 0.01 * Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)),
                           uniform(0.2, 0.2001)});
            break;
        default:  // around a large one, which has more than one face with a neighbour
            scene.objects.push_back(Sphere{Vec3::Constant(0.5), uniform(0.05, 0.3)});
            for (int i = 0; i < 40; ++i) {
                const Vec3 way(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
                scene.objects.push_back(
                    Sphere{Vec3::Constant(0.5) + 0.4 * way.normalized(), 0.5 * random_radius()});
            }
    }
    return scene;
}

void check_same_cell(const DiagramCell& shared, const DiagramCell& alone) {
    REQUIRE(shared.state == alone.state);
    CHECK(shared.reason == alone.reason);
    if (shared.state != State::Computed) return;
    CHECK(std::abs(shared.volume - alone.volume) <= shared.volume_error + alone.volume_error);
    CHECK(std::abs(shared.area - alone.area) <= shared.area_error + alone.area_error);
    CHECK(shared.min_clearance == doctest::Approx(alone.min_clearance).epsilon(1e-9));
    CHECK(shared.max_clearance == doctest::Approx(alone.max_clearance).epsilon(1e-9));
    CHECK(shared.touches_box == alone.touches_box);
    CHECK(shared.assumed == 0);
    REQUIRE(shared.contacts.size() == alone.contacts.size());
    for (std::size_t k = 0; k < shared.contacts.size(); ++k) {
        const CellContact &a = shared.contacts[k], &b = alone.contacts[k];
        CHECK(a.site == b.site);
        CHECK(a.image == b.image);
        CHECK(a.faces == b.faces);
        CHECK(std::abs(a.area - b.area) <= a.area_error + b.area_error);
    }
}

}  // namespace

TEST_CASE("shared faces: the cells are those that the engine finds, each by itself") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round)
        for (int kind = 0; kind < 7; ++kind) {
            CAPTURE(round);
            CAPTURE(kind);
            const DiagramScene scene = shared_scene(kind, rng);
            const VoronoiDiagram shared = voronoi_diagram(scene);
            DiagramOptions options;
            options.visit = [](std::uint32_t, const Cell&) {};
            const VoronoiDiagram alone = voronoi_diagram(scene, options);
            for (std::size_t i = 0; i < scene.objects.size(); ++i) {
                CAPTURE(i);
                check_same_cell(shared.cells[i], alone.cells[i]);
            }
            const FilledVolume sum = filled_volume(scene, shared);
            CHECK(sum.fills());
            CHECK(sum.error < 1e-9 * sum.box);
        }
}

TEST_CASE("shared faces: a cell is the same to the last bit among any balls that its searches do not miss") {
    using namespace whole;
    std::mt19937_64 rng(test_seed() + 4);
    const auto check_equal = [](const std::optional<FoundCell>& a, const std::optional<FoundCell>& b) {
        REQUIRE(a.has_value() == b.has_value());
        if (!a) return false;
        CHECK(a->cell.volume == b->cell.volume);
        CHECK(a->cell.volume_error == b->cell.volume_error);
        CHECK(a->cell.area == b->cell.area);
        CHECK(a->cell.reach == b->cell.reach);
        CHECK(a->cell.candidates == b->cell.candidates);
        REQUIRE(a->cell.contacts.size() == b->cell.contacts.size());
        for (std::size_t k = 0; k < a->cell.contacts.size(); ++k) {
            CHECK(a->cell.contacts[k].site == b->cell.contacts[k].site);
            CHECK(a->cell.contacts[k].area == b->cell.contacts[k].area);
            CHECK(a->cell.contacts[k].area_error == b->cell.contacts[k].area_error);
        }
        REQUIRE(a->shared.parts.size() == b->shared.parts.size());
        for (std::size_t k = 0; k < a->shared.parts.size(); ++k)
            CHECK(a->shared.parts[k].volume == b->shared.parts[k].volume);
        return true;
    };
    std::size_t common = 0, left_out = 0;
    for (int kind = 0; kind < 7; ++kind) {
        CAPTURE(kind);
        const DiagramScene scene = shared_scene(kind, rng);
        const DecidedDiagram decided(scene);
        for (const BallTree::Leaf& leaf : decided.balls().tree().leaves()) {
            const Neighborhood around(decided, leaf);
            for (const BallTree::Entry& e : leaf.balls) {
                CAPTURE(e.number);
                const Sphere& ball = decided.ball(e.number);
                std::vector<BallSearch> searches;
                const auto alone = common_ball_cell(decided, e.number, searches);
                if (holds(decided.room(ball), ball.center))
                    check_equal(alone,
                                measured_ball_cell(decided, e.number, decided.room(ball), &around, true));
                // What is known: the ball, those that are nearest, and those that are found.
                std::vector<std::uint32_t> known{e.number};
                for (const ImageTree::Found& f : decided.competitors(e.number, 20).nearest)
                    known.push_back(f.number);
                const auto find = [&](const Sphere&, std::uint32_t number, const Image&) {
                    known.push_back(number);
                };
                for (const BallSearch& search : searches) {
                    if (search.marks) {
                        CellMarks marks(ball, *search.marks);
                        marks.look_between(search.from, search.to);
                        decided.balls().touching(marks, find);
                    } else {
                        decided.balls().within(ball.center, search.to, find);
                    }
                }
                std::ranges::sort(known);
                known.erase(std::ranges::unique(known).begin(), known.end());
                ScenePart part;
                part.scene = decided.scene();
                part.scene.objects.clear();
                for (const std::uint32_t number : known)
                    part.scene.objects.push_back(decided.scene().objects[number]);
                part.numbers = known;
                part.hidden.resize(known.size());
                part.balls = decided.balls().tree().entries().size();
                const DecidedDiagram of_part(std::move(part));
                std::vector<BallSearch> again;
                common += check_equal(alone, common_ball_cell(of_part, of_part.place(e.number), again));
                CHECK(again.size() == searches.size());
                left_out += scene.objects.size() - known.size();
            }
        }
    }
    CHECK(common > 100);
    CHECK(left_out > 0);
}

// Where the nearest balls leave a face much room on one side, it is not thought to have it on all sides.
TEST_CASE("shared faces: cells with a wide face among few of their neighbours find the others") {
    std::mt19937_64 rng(test_seed() + 5);
    std::uniform_real_distribution<double> at(0, 1);
    std::size_t lost = 0;
    for (int round = 0; round < 5; ++round) {
        DiagramScene scene;
        scene.box = {Vec3::Zero(), Vec3::Ones()};
        scene.periodic = {true, true, true};
        for (int i = 0; i < 300; ++i)
            scene.objects.push_back(Sphere{{at(rng), at(rng), at(rng)}, 0.03 * at(rng)});
        for (const DiagramCell& cell : voronoi_diagram(scene).cells) lost += cell.candidates > 400;
    }
    CHECK(lost <= 1);
}

TEST_CASE("shared faces: both cells of a pair have one area, whatever the number of threads") {
    std::mt19937_64 rng(test_seed() + 1);
    for (int kind = 0; kind < 7; ++kind) {
        CAPTURE(kind);
        const DiagramScene scene = shared_scene(kind, rng);
        DiagramOptions options;
        options.threads = 1;
        const VoronoiDiagram one = voronoi_diagram(scene, options);
        options.threads = 3;
        const VoronoiDiagram three = voronoi_diagram(scene, options);
        std::size_t equal = 0, all = 0;
        for (std::uint32_t i = 0; i < one.cells.size(); ++i) {
            const DiagramCell &a = one.cells[i], &b = three.cells[i];
            CHECK(a.volume == b.volume);
            CHECK(a.volume_error == b.volume_error);
            CHECK(a.reach == b.reach);
            REQUIRE(a.contacts.size() == b.contacts.size());
            for (std::size_t k = 0; k < a.contacts.size(); ++k) {
                CHECK(a.contacts[k].area == b.contacts[k].area);
                CHECK(a.contacts[k].area_error == b.contacts[k].area_error);
            }
        }
        for (std::uint32_t i = 0; i < one.cells.size(); ++i)
            for (const CellContact& mine : one.cells[i].contacts) {
                if (!mine.site.is_object()) continue;
                for (const CellContact& theirs : one.cells[mine.site.index].contacts) {
                    const bool is_back =
                        theirs.site == Site::object(i) && theirs.image[0] == -mine.image[0] &&
                        theirs.image[1] == -mine.image[1] && theirs.image[2] == -mine.image[2];
                    if (!is_back) continue;
                    ++all;
                    equal += mine.area == theirs.area ? 1 : 0;
                }
            }
        CHECK(all > 0);
        // Cells that the engine finds have areas of their own; in the lattice there are none.
        CHECK(equal > 0);
        if (kind == 2) CHECK(equal == all);
    }
}

TEST_CASE("tie_sign: agrees with whole numbers about points that are equally far from four balls") {
    std::mt19937_64 rng(test_seed() + 2);
    int zeros = 0, told = 0;
    for (int round = 0; round < 2000; ++round) {
        // Half of all have the same distance from the middle of a cube, so that they tie.
        std::array<std::array<long long, 3>, 4> n;
        const bool is_cube = round % 2 == 0;
        for (auto& p : n)
            for (long long& x : p)
                x = static_cast<long long>(rng() % 2) * 2 +
                    (is_cube ? 0 : static_cast<long long>(rng() % 9) - 4);
        Scene scene;
        scene.base = Sphere{{0.5, 0.25, -0.5}, 0.125};
        scene.box = {Vec3::Constant(-16), Vec3::Constant(16)};
        bool is_scene = true;
        for (std::size_t i = 0; i < 4; ++i) {
            is_scene = is_scene && n[i] != std::array<long long, 3>{0, 0, 0};
            for (std::size_t k = 0; k < i; ++k) is_scene = is_scene && n[i] != n[k];
            scene.objects.push_back(Sphere{Vec3(static_cast<double>(n[i][0]), static_cast<double>(n[i][1]),
                                                static_cast<double>(n[i][2])) +
                                               std::get<Sphere>(scene.base).center,
                                           0.125});
        }
        if (!is_scene) continue;
        // Cramer's rule: the point x with 2 n.x = n.n of the first three, times D.
        const auto square = [](const auto& p) { return p[0] * p[0] + p[1] * p[1] + p[2] * p[2]; };
        const auto minor = [&](const std::array<std::array<long long, 3>, 3>& m) {
            return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                   m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                   m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
        };
        const std::array<std::array<long long, 3>, 3> rows{n[0], n[1], n[2]};
        const long long D = minor(rows);
        long long along = 0;
        for (int k = 0; k < 3; ++k) {
            auto replaced = rows;
            for (int i = 0; i < 3; ++i) replaced[i][k] = square(n[i]);
            along += n[3][k] * minor(replaced);
        }
        const GrowingSphereProblem problem(scene, 1);
        const std::array<FormId, 3> tied{FormId{0}, FormId{1}, FormId{2}};
        for (const Sign value : {Sign::Negative, Sign::Positive}) {
            const auto sign = problem.tie_sign(FormId{3}, tied, value);
            if (D == 0) {
                CHECK(!sign);
                continue;
            }
            // A fourth ball is nearer to x than the base where 2 n.x > n.n; then its form is lower, forms
            // being -1 / t.
            const long long beyond = (square(n[3]) * D - along) * (D > 0 ? 1 : -1);
            REQUIRE(sign);
            CHECK(*sign == sign_of(beyond) * -value);
            zeros += beyond == 0 ? 1 : 0;
            ++told;
        }
    }
    CHECK(zeros > 100);
    CHECK(told > 1000);
    // Radii that differ are for the general way.
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.125};
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    scene.objects = {Sphere{{1, 0, 0}, 0.125}, Sphere{{0, 1, 0}, 0.125}, Sphere{{0, 0, 1}, 0.125},
                     Sphere{{1, 1, 1}, 0.25}};
    CHECK(!GrowingSphereProblem(scene, 1).tie_sign(FormId{3}, {FormId{0}, FormId{1}, FormId{2}},
                                                   Sign::Negative));
}

TEST_CASE("tie_along: three balls are equally far along a line where they lie on a circle with the base") {
    using Rational = boost::multiprecision::cpp_rational;
    std::mt19937_64 rng(test_seed() + 3);
    int circles = 0, told = 0;
    for (int round = 0; round < 2000; ++round) {
        // Corners of a cube whose origin is the base's centre lie on circles through it four at a time.
        std::array<std::array<int, 3>, 3> n;
        for (auto& p : n)
            for (int& x : p)
                x = static_cast<int>(rng() % 2) * 2 + (round % 2 == 0 ? 0 : static_cast<int>(rng() % 3) - 1);
        Scene scene;
        scene.base = Sphere{{0.5, 0.25, -0.5}, 0.125};
        scene.box = {Vec3::Constant(-16), Vec3::Constant(16)};
        bool is_scene = true;
        for (std::size_t i = 0; i < 3; ++i) {
            is_scene = is_scene && n[i] != std::array<int, 3>{0, 0, 0};
            for (std::size_t k = 0; k < i; ++k) is_scene = is_scene && n[i] != n[k];
            scene.objects.push_back(
                Sphere{Vec3(n[i][0], n[i][1], n[i][2]) + std::get<Sphere>(scene.base).center, 0.125});
        }
        if (!is_scene) continue;
        // An inversion about the origin takes circles through it to lines.
        std::array<std::array<Rational, 3>, 3> at;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                at[i][k] = Rational(n[i][k]) / (n[i][0] * n[i][0] + n[i][1] * n[i][1] + n[i][2] * n[i][2]);
        bool is_line = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3;
            is_line = is_line && (at[1][k] - at[0][k]) * (at[2][l] - at[0][l]) ==
                                     (at[1][l] - at[0][l]) * (at[2][k] - at[0][k]);
        }
        const auto along = GrowingSphereProblem(scene, 1).tie_along({FormId{0}, FormId{1}, FormId{2}});
        REQUIRE(along);
        CHECK(*along == is_line);
        circles += is_line ? 1 : 0;
        ++told;
    }
    CHECK(circles > 25);
    CHECK(told - circles > 500);
}

}  // namespace vcell::shared_faces_test
