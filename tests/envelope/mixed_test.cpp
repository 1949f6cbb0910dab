// Minimization diagrams with cylinders against brute force: random families, degenerate and nearly degenerate
// scenes, motions that keep the combinatorial diagram. VCELL_TEST_ROUNDS asks for more rounds than one.
#include <doctest/doctest.h>

#include <numeric>
#include <set>

#include "../../core/errors.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"
#include "canonical.hpp"
#include "complaints.hpp"
#include "mixed_oracle.hpp"
#include "mixed_scenes.hpp"

namespace vcell::mixed::mixed_test {
namespace {

MinimizationDiagram envelope(const Scene& s) { return lower_envelope(s.family(), s.region); }

/// The scene's diagram, after it was judged.
MinimizationDiagram judge(const Scene& scene, std::mt19937_64& rng, const Options& options = {}) {
    CAPTURE(scene.name);
    MinimizationDiagram diagram;
    std::vector<std::string> complaints{"no diagram"};
    CHECK_NOTHROW((diagram = envelope(scene), complaints = check_diagram(scene, diagram, rng, options)));
    CHECK_MESSAGE(complaints.empty(), join(complaints));
    CHECK(diagram.assumptions.size() == diagram.decisions.assumed);
    return diagram;
}

// --- Motions that keep the combinatorial diagram --------------------------------------------------------

oracle::Renaming identity(const Scene& s) {
    oracle::Renaming r;
    r.form.resize(s.size());
    std::iota(r.form.begin(), r.form.end(), 0u);
    r.side.resize(s.region.sides.size());
    std::iota(r.side.begin(), r.side.end(), 0u);
    return r;
}

void same_diagram(const std::vector<std::string>& expected, const Scene& after, const std::string& motion) {
    CAPTURE(after.name);
    CAPTURE(motion);
    std::vector<std::string> found;
    CHECK_NOTHROW(found = oracle::canonical(envelope(after), identity(after)));
    CHECK(join(found) == join(expected));
}

/// Each coordinate pair (x, y) becomes (xx x + xy y, yx x + yy y), a signed permutation.
Scene turned(Scene s, int xx, int xy, int yx, int yy) {
    const auto turn = [&](double& x, double& y) {
        const double u = xx * x + xy * y, v = yx * x + yy * y;
        x = u + 0.0;
        y = v + 0.0;
    };
    for (Solid& solid : s.circular)
        if (Ball* b = std::get_if<Ball>(&solid))
            turn(b->x, b->y);
        else
            turn(std::get<Wall>(solid).a, std::get<Wall>(solid).b);
    for (CylinderForm& c : s.cylinders) {
        turn(c.px, c.py);
        turn(c.ax, c.ay);
    }
    for (auto& side : s.region.sides) turn(side.a, side.b);
    if (xx * yy - xy * yx < 0) std::ranges::reverse(s.region.sides);
    return s;
}

void invariances(const Scene& s, std::mt19937_64& rng) {
    MinimizationDiagram diagram;
    CAPTURE(s.name);
    CHECK_NOTHROW(diagram = envelope(s));
    const auto unchanged = oracle::canonical(diagram, identity(s));
    {
        Scene t = s;
        oracle::Renaming r = identity(s);
        const auto split = r.form.begin() + static_cast<std::ptrdiff_t>(s.circular.size());
        std::shuffle(r.form.begin(), split, rng);
        std::shuffle(split, r.form.end(), rng);
        for (std::size_t i = 0; i < s.circular.size(); ++i) t.circular[r.form[i]] = s.circular[i];
        for (std::size_t i = 0; i < s.cylinders.size(); ++i)
            t.cylinders[r.form[s.circular.size() + i] - s.circular.size()] = s.cylinders[i];
        same_diagram(oracle::canonical(diagram, r), t, "permutation");
    }
    same_diagram(unchanged, moved(s, 1, 16, -8), "translation");
    same_diagram(unchanged, moved(s, 0x1p-20, 0, 0), "scaling down");
    same_diagram(unchanged, moved(s, 0x1p20, 0, 0), "scaling up");
    same_diagram(unchanged, turned(s, 0, -1, 1, 0), "rotation");
    {
        oracle::Renaming r = identity(s);
        std::ranges::reverse(r.side);
        r.mirrored = true;
        same_diagram(oracle::canonical(diagram, r), turned(s, 0, 1, 1, 0), "mirror");
    }
}

/// All coordinates to 2^-20: translations by short numbers are exact.
Scene rounded(Scene s) {
    for (Solid& solid : s.circular)
        if (Ball* b = std::get_if<Ball>(&solid))
            *b = {dyadic(b->x), dyadic(b->y), dyadic(b->z), dyadic(b->rho)};
        else
            solid = Wall{dyadic(std::get<Wall>(solid).a), dyadic(std::get<Wall>(solid).b),
                         dyadic(std::get<Wall>(solid).e), std::get<Wall>(solid).w};
    for (CylinderForm& c : s.cylinders) {
        c.px = dyadic(c.px);
        c.py = dyadic(c.py);
    }
    for (auto& side : s.region.sides) side = {dyadic(side.a), dyadic(side.b), dyadic(side.c)};
    return s;
}

// --- Connected components ----------------------------------------------------------------------------------

/// How many connected regions of one owner a grid of n by n points of the square |x|, |y| < half shows.
std::size_t components_on_grid(const Judge& judge, double half, std::size_t n) {
    std::vector<FormId> owner(n * n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            owner[i * n + j] = judge.owner(half * (2 * (j + 0.5) / n - 1), half * (2 * (i + 0.5) / n - 1));
    std::vector<bool> seen(n * n);
    std::vector<std::size_t> stack;
    std::size_t count = 0;
    for (std::size_t start = 0; start < n * n; ++start) {
        if (seen[start]) continue;
        ++count;
        seen[start] = true;
        stack.push_back(start);
        while (!stack.empty()) {
            const std::size_t p = stack.back(), row = p / n, column = p % n;
            stack.pop_back();
            const auto visit = [&](bool exists, std::size_t q) {
                if (!exists || seen[q] || owner[q] != owner[p]) return;
                seen[q] = true;
                stack.push_back(q);
            };
            visit(row > 0, p - n);
            visit(row + 1 < n, p + n);
            visit(column > 0, p - 1);
            visit(column + 1 < n, p + 1);
        }
    }
    return count;
}

}  // namespace

TEST_CASE("mixed envelope: agrees with brute force on random scenes of every family, nothing assumed") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round)
        for (const Scene& s : random_scenes(rng)) {
            const MinimizationDiagram d = judge(s, rng, {.samples = 200, .brute_force_forms = 5});
            CAPTURE(s.name);
            CHECK(d.decisions.assumed == 0);
        }
}

TEST_CASE("mixed envelope: agrees with brute force on large and on small coordinates") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round) {
        RandomScenes random(rng);
        const Scene s = rounded(random.mix("moved", 3, 1, 2, 1));
        for (const auto& [factor, dx, dy] :
             {std::array{0x1p20, 0.0, 0.0}, {0x1p-20, 0.0, 0.0}, {1.0, 1e6, -3e6}, {0x1p-20, 1.0, 2.0}}) {
            CAPTURE(factor);
            CAPTURE(dx);
            CHECK(judge(moved(s, factor, dx, dy), rng, {.samples = 200}).decisions.assumed == 0);
        }
    }
}

TEST_CASE("mixed envelope: many objects") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round)
        for (const int n : {20, rounds() > 1 ? 500 : 60}) {
            RandomScenes random(rng, std::sqrt(n));
            Scene s = random.mix("pile of " + std::to_string(n), n, n / 10, n / 4, n / 10);
            CHECK(judge(s, rng, {.samples = 200}).decisions.assumed == 0);
        }
}

TEST_CASE("mixed envelope: pieces with several vertices come to an end") {
    // In piles the turns of three gradients are often barely certain, and must be so in any order of the
    // three.
    for (int seed = 0; seed < 10 * rounds(); ++seed) {
        std::mt19937_64 rng(static_cast<std::uint64_t>(seed));
        RandomScenes random(rng, std::sqrt(60));
        const Scene s = random.mix("pile", 60, 6, 15, 6);
        CAPTURE(seed);
        MinimizationDiagram d;
        CHECK_NOTHROW(d = envelope(s));
        CHECK_FALSE(d.dcel.find_defect());
        CHECK(d.decisions.assumed == 0);
    }
}

TEST_CASE("mixed envelope: degenerate scenes, with coincidences assumed where they are") {
    std::mt19937_64 rng(test_seed());
    for (const Scene& scene : degenerate_scenes()) {
        const MinimizationDiagram d = judge(scene, rng, {.samples = 100, .brute_force_forms = 4});
        CAPTURE(scene.name);
        for (const Assumption& a : d.assumptions) {
            CAPTURE(a.place.x());
            CAPTURE(a.place.y());
            REQUIRE(a.forms.size() >= 2);
            // The forms agree there: what they differ by is what they change by within the width.
            Fast low = HUGE_VALL, high = 0, change = 0;
            for (const FormId f : a.forms) {
                const Height<Fast> h = height<Fast>(scene.solid(f.value), a.place.x(), a.place.y());
                low = std::min(low, h.v);
                high = std::max(high, h.v);
                change = std::max(change, std::abs(h.gx) + std::abs(h.gy));
            }
            CHECK(high - low <= 2 * change * (a.width + 4 * 0x1p-52) + 1e-17L);
        }
    }
}

TEST_CASE("mixed envelope: an exact coincidence is one vertex in its place, and decided") {
    struct Case {
        Scene scene;
        double x, y;
        std::size_t forms;
    };
    Scene straight, oblique, near_rim, bottoms;
    straight.cylinder(0, 0, 1, 1, 0, 0, 0.25).cylinder(0, 0, 1, 0, 1, 0, 0.25);
    oblique.cylinder(0.25, -0.5, 1, 1, 0, 0, 0.25).cylinder(0.25, -0.5, 1, 1, 2, 0, 0.25);
    near_rim.cylinder(0, 0, 1, 1, 0.5, 0, 0.25).cylinder(0, 0, 1, -0.25, 1, 0, 0.25);
    near_rim.region = ConvexRegion::rectangle(-0x1p-10, -2, 2, 2);
    bottoms.cylinder(0, 0, 1, 1, 0, 0, 0.25).ball(0, 0, 1.25, 0.5);
    for (const auto& [scene, x, y, forms] :
         {Case{straight, 0, 0, 2}, Case{oblique, 0.25, -0.5, 2}, Case{near_rim, 0, 0, 2},
          Case{bottoms, 0, 0, 2}, Case{regulus("", four_ways, 0.5, 0.25, 0.25), 0, 0, 4},
          Case{regulus("", four_ways, 0.5, 0.25, 0), 0, 0, 4}}) {
        const MinimizationDiagram d = envelope(scene);
        const auto there = [&](const Eigen::Vector2d& p, double error) {
            return std::hypot(p.x() - x, p.y() - y) <= error + 1e-15;
        };
        int found = 0;
        for (const VertexId v : d.vertices.ids()) {
            const auto& vertex = d.vertices[v];
            if (!d.sides(v).empty() || !there(vertex.point, vertex.error)) continue;
            ++found;
            CHECK(vertex.error < 1e-9);
            CHECK(d.label(v).size() == forms);
        }
        CHECK(found == 1);
        CHECK(d.assumptions.empty());
    }
}

TEST_CASE("mixed envelope: where many forms tie there is one vertex, with its edges and faces around it") {
    // Forms in the label, edges around it (those of the rim included), and faces of the whole diagram.
    // All ties are decided exactly.
    struct Case {
        std::string name;
        double x, y;
        std::size_t forms, edges, faces;
    };
    std::vector<Case> cases{
        {"two equal cylinders that cross", 0, 0, 2, 4, 4},
        {"three equal cylinders through one point", 0, 0, 3, 6, 6},
        {"three equal cylinders through one point, in rational directions", 0, 0, 3, 6, 6},
        {"eight equal cylinders through one point", 0.125, 0.25, 8, 16, 16},
        {"a larger ball in the node of two cylinders", 0, 0, 3, 4, 4},
        {"a smaller ball in the node of two cylinders", 0, 0, 3, 4, 4},
        {"a plane through the node of two cylinders", 0, 0, 3, 4, 6},
        {"a ball in a cylinder, touching its bottom", 0, 0, 2, 0, 1},
        {"equal cylinders cross over the rim", 2, 0.5, 2, 4, 3},
        {"equal cylinders cross over a corner", 2, 2, 2, 3, 2},
        {"three equal cylinders cross over the rim", 2, 0.5, 3, 5, 4},
        {"three equal cylinders cross over a corner", 2, 2, 3, 4, 3},
        {"equal cylinders cross over an oblique rim", 0.5, 0.5, 2, 4, 3},
        {"a trisector touches the rim from inside", 2, 0, 2, 4, 3},
        {"a trisector touches the rim from outside", 2, 0, 2, 2, 1},
        {"a vertex on the rim", 2, 0, 3, 4, 3},
        {"a point touches the trisector of two lines", 0.125, 0, 3, 2, 2},
        {"a grid of four equal cylinders", 0, 0, 4, 4, 12},
        {"four cylinders on a regulus", 0, 0, 4, 4, 8},
    };
    std::vector<Scene> scenes = degenerate_scenes();
    scenes.push_back({.name = cases[2].name, .circular = {}, .cylinders = {}});
    scenes.back()
        .cylinder(0, 0, 1, 4, 3, 0, 0.25)
        .cylinder(0, 0, 1, 0, 1, 0, 0.25)
        .cylinder(0, 0, 1, 3, 4, 0, 0.25);
    std::mt19937_64 rng(test_seed());
    for (const auto& [name, x, y, forms, edges, faces] : cases) {
        CAPTURE(name);
        const Scene& scene = *std::ranges::find(scenes, name, &Scene::name);
        const MinimizationDiagram d = judge(scene, rng, {.samples = 200});
        const auto there = [&](const Eigen::Vector2d& p, double error) {
            return std::hypot(p.x() - x, p.y() - y) <= error + 1e-15;
        };
        int found = 0;
        for (const VertexId v : d.vertices.ids()) {
            if (!there(d.vertices[v].point, std::max(d.vertices[v].error, 1e-6))) continue;
            ++found;
            CHECK(there(d.vertices[v].point, d.vertices[v].error));
            CHECK(d.vertices[v].error < 1e-12);
            CHECK(d.label(v).size() == forms);
            std::size_t around = 0;
            if (const HalfEdgeId first = d.dcel.outgoing(v); first.valid()) {
                HalfEdgeId h = first;
                do {
                    ++around;
                    h = d.dcel.next_around_origin(h);
                } while (h != first);
            }
            CHECK(around == edges);
        }
        CHECK(found == 1);
        CHECK(d.face_forms.size() - 1 == faces);
        CHECK(d.assumptions.empty());
        invariances(scene, rng);
    }
}

TEST_CASE("mixed envelope: arcs are divided into pieces up to where all forms tie") {
    for (const Scene& scene : degenerate_scenes()) {
        if (scene.name.find("node") == std::string::npos && scene.name.find("bottom") == std::string::npos)
            continue;
        CAPTURE(scene.name);
        const MinimizationDiagram d = envelope(scene);
        const FormFamily family = scene.family();
        const Heights heights(family);
        for (const EdgeId e : d.edges.ids()) {
            const auto pieces = d.pieces(e);
            for (std::size_t i = 0; i < pieces.size(); ++i) {
                const auto& [x0, x1, y0, y1] = pieces[i].box;
                const double width = std::max(x1 - x0, y1 - y0);
                if (width < 4 * 0x1p-25) continue;
                const auto [gx, gy] =
                    heights.gradient_difference(d.edges[e].left, d.edges[e].right, {x0, x1}, {y0, y1});
                CHECK((Interval(pieces[i].direction.x()) * gx + Interval(pieces[i].direction.y()) * gy)
                          .lower() > 0);
            }
        }
    }
}

TEST_CASE("mixed envelope: forms that tie along a curve are named, and the place") {
    Scene ball{.name = "a ball of a cylinder's radius on its axis", .circular = {}, .cylinders = {}};
    ball.ball(1, 1.5, 0.25, 0.125).ball(0.5, -1, 1, 0.25).cylinder(0, -1, 1, 1, 0, 0, 0.25);
    Scene rim{.name = "a tie along the rim", .circular = {}, .cylinders = {}};
    rim.ball(-1, -1, 0.25, 0.125).cylinder(2, 0.5, 1, 1, 1, 0, 0.25).cylinder(2, 0.5, 1, 1, -1, 0, 0.25);
    for (const auto& [scene, x] : {std::pair{ball, 0.5}, {rim, 2.0}}) {
        CAPTURE(scene.name);
        try {
            envelope(scene);
            FAIL("was decided");
        } catch (const TieError& e) {
            CHECK(e.tie.forms == std::vector{FormId{1}, FormId{2}});
            CHECK(e.tie.place.x() == doctest::Approx(x).epsilon(1e-3));
        }
    }
}

TEST_CASE("mixed envelope: forms that tie all along a side are refused by name of the place") {
    // The bisectors of the axes are x = 2 and y = 1/2.
    Scene s{.name = "a tie along the rim", .circular = {}, .cylinders = {}};
    s.cylinder(2, 0.5, 1, 1, 1, 0, 0.25).cylinder(2, 0.5, 1, 1, -1, 0, 0.25);
    CHECK_THROWS_AS(envelope(s), UndecidedError);
}

TEST_CASE("mixed envelope: shows as many faces as a fine grid has components") {
    std::mt19937_64 rng(test_seed());
    Scene s{.name = "islands in the faces of cylinders and a plane", .circular = {}, .cylinders = {}};
    s.wall(0, 0, 0.4);
    s.cylinder(0, 1.5, 0.75, 1, 0, 0, 0.25).cylinder(-1.5, 0, 0.6875, 0, 1, 0, 0.25);
    s.ball(1, 1.5, 0.25, 0.0625)
        .ball(0.25, -1.25, 0.25, 0.125)
        .ball(-1.375, -1, 0.25, 0.0625)
        .ball(1.25, 0, 0.375, 0.25);
    const MinimizationDiagram d = judge(s, rng);
    const Judge by_hand(s, d);
    CHECK(d.face_forms.size() - 1 == components_on_grid(by_hand, 2, 120));
    std::size_t holes = 0;
    for (const FaceId f : d.face_forms.ids())
        holes += f == Dcel::unbounded_face() ? 0 : d.dcel.inner_ccbs(f).size();
    CHECK(holes == 4);
}

TEST_CASE("mixed envelope: a closed edge without vertices may consist of pieces") {
    std::mt19937_64 rng(test_seed());
    for (const auto& [x, y] : {std::pair{0.25, 0.0}, {-0.5, 0.125}, {1.0, -0.0625}}) {
        Scene s{.name = "a small ball under a cylinder", .circular = {}, .cylinders = {}};
        s.cylinder(0, 0, 0.5, 1, 0.25, 0, 0.25).ball(x, y, 0.125, 0.0625);
        const MinimizationDiagram d = judge(s, rng);
        REQUIRE(d.face_forms.size() == 3);
        int closed = 0;
        for (const EdgeId e : d.edges.ids()) {
            if (d.dcel.origin(Dcel::half_edge(e)).valid()) continue;
            ++closed;
            CHECK(d.pieces(e).size() > 2);
        }
        CHECK(closed == 1);
    }
}

TEST_CASE("mixed envelope: motions of a scene do not change the combinatorial diagram") {
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < rounds(); ++round) {
        RandomScenes random(rng);
        invariances(rounded(random.mix("mix", 4, 1, 3, 1)), rng);
        invariances(rounded(random.mix("cylinders", 0, 0, 4, 1)), rng);
        Scene oblique = rounded(random.mix("oblique", 3, 0, 2, 0));
        oblique.region = polygon(5, 0.9, 0.3);
        invariances(rounded(oblique), rng);
    }
    // What is taken for a point only where doubles end need not look the same after a motion.
    const std::vector<Scene> degenerate = degenerate_scenes();
    for (std::size_t i = 0; i<degenerate.size(); i += rounds()> 1 ? 1 : 3)
        if (const Scene& s = degenerate[i];
            std::ranges::all_of(envelope(s).assumptions, [](const Assumption& a) { return a.width < 1e-25; }))
            invariances(s, rng);
}

TEST_CASE("mixed envelope: nearly symmetric scenes") {
    std::mt19937_64 rng(test_seed());
    const std::vector<Scene> symmetric = degenerate_scenes();
    const std::array<double, 3> sizes{1e-8, 1e-12, 1e-15};
    for (std::size_t i = 0; i < symmetric.size(); ++i) {
        const Scene& exact = symmetric[i];
        for (const double size : sizes) {
            if (rounds() == 1 && size != sizes[i % 3]) continue;
            Scene s = exact;
            std::uniform_real_distribution<double> shift(-size, size);
            for (CylinderForm& c : s.cylinders) {
                c.pz += shift(rng);
                c.px += shift(rng);
                c.py += shift(rng);
            }
            CAPTURE(size);
            judge(s, rng, {.samples = 50, .brute_force_forms = 0});
        }
    }
}

// The trisectors of the cylinders cross next to the one that both have with the plane, which is straight.
TEST_CASE("mixed envelope: a plane that all but runs through the node of two cylinders") {
    std::mt19937_64 rng(test_seed());
    const std::vector<Scene> symmetric = degenerate_scenes();
    const auto exact =
        std::ranges::find(symmetric, std::string("a plane through the node of two cylinders"), &Scene::name);
    REQUIRE(exact != symmetric.end());
    constexpr double size = 1e-15;
    std::uniform_real_distribution<double> shift(-size, size);
    for (int round = 0; round < 60 * rounds(); ++round) {
        CAPTURE(round);
        Scene s = *exact;
        for (CylinderForm& c : s.cylinders) {
            c.px += shift(rng);
            c.py += shift(rng);
            if (round % 2 == 0) c.pz += shift(rng);
        }
        judge(s, rng, {.samples = 5, .brute_force_forms = 0});
    }
}

TEST_CASE("mixed envelope: many cylinders through nearly one vertex") {
    std::mt19937_64 rng(test_seed());
    for (const double size : {1e-3, 1e-6, 1e-9}) {
        std::uniform_real_distribution<double> shift(-size, size);
        Scene s{.name = "twelve around the centre", .circular = {}, .cylinders = {}};
        for (int i = 0; i < 12; ++i) {
            const double angle = 2 * std::numbers::pi * i / 12, x = std::cos(angle), y = std::sin(angle);
            s.cylinder(x, y, 1 + shift(rng), -y, x, 0.2, 0.25);
        }
        CAPTURE(size);
        CHECK(judge(s, rng, {.samples = 200, .brute_force_forms = 0}).decisions.assumed == 0);
    }
}

TEST_CASE("mixed envelope: cylinders that are nearly the same are told apart, in few pieces") {
    std::mt19937_64 rng(test_seed());
    for (const double turn : {1e-1, 1e-3, 1e-6, 1e-9}) {
        for (const double rise : {0.0, 1e-9}) {
            Scene s{.name = "nearly parallel", .circular = {}, .cylinders = {}};
            s.cylinder(0, 0, 1, 1, 0, 0, 0.25).cylinder(0, 0, 1 + rise, 1, turn, 0, 0.25);
            CAPTURE(turn);
            CAPTURE(rise);
            const MinimizationDiagram d = judge(s, rng, {.samples = 100});
            // Axes that cross leave a node, two trisectors that do not are apart.
            CHECK(d.decisions.assumed == 0);
            CHECK(d.face_forms.size() - 1 == (rise == 0 ? 4 : 3));
            CHECK(d.pieces_.size() < 200);
        }
    }
}

TEST_CASE("mixed envelope: cylinders that graze the rim from outside") {
    std::mt19937_64 rng(test_seed());
    for (const double gap : {1e-3, 1e-6, 1e-9}) {
        Scene s{.name = "grazing", .circular = {}, .cylinders = {}};
        s.ball(0, 0, 1, 0.25)
            .cylinder(2.5 + gap, 0.25, 0, 0, 0, 1, 0.5)
            .cylinder(-0.25, -2.25 - gap, 0, 0.125, 0, 1, 0.25);
        CAPTURE(gap);
        CHECK(judge(s, rng, {.samples = 200}).decisions.assumed == 0);
    }
}

TEST_CASE("lowest_form: agrees with brute force where cylinders compete") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int round = 0; round < 10; ++round) {
        const Scene s = random.mix("", 3, 1, 3, 1);
        const FormFamily family = s.family();
        const MinimizationDiagram d = envelope(s);
        const Judge by_hand(s, d);
        for (int k = 0; k < 20; ++k) {
            const double x = random.uniform(-2, 2), y = random.uniform(-2, 2);
            CHECK(lowest_form(family, x, y) == by_hand.owner(x, y));
        }
    }
}

}  // namespace vcell::mixed::mixed_test
