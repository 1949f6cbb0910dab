// Minimization diagrams over sphere and cylinder bases against brute force: random scenes of every mix
// at every scale, and the judge itself. VCELL_TEST_ROUNDS asks for more rounds than one.
#include <doctest/doctest.h>

#include <map>
#include <optional>
#include <set>

#include "../../core/errors.hpp"
#include "../../envelope/sphere/sphere_diagram.hpp"
#include "../../primitives/forms/heights.hpp"
#include "radial_answers.hpp"

namespace vcell::radial::radial_diagram_test {
namespace {

// --- Random scenes ---------------------------------------------------------------------------------------

TEST_CASE("diagram over a sphere: agrees with brute force on random balls and planes") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < long_rounds(20); ++i) {
        Scene s = random.over_sphere(i % 5 == 0 ? 0 : random.uniform(0.05, 0.5));
        random.add(s, random.count(0, 24), random.count(0, 4), 0);
        EnvelopeOptions by_pieces;
        by_pieces.incremental = false;
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
        CHECK(judge(s, rng, {}, by_pieces).diagram.decisions.assumed == 0);
    }
}

TEST_CASE("diagram over a sphere: insertion finds what pieces find") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    int inserted = 0;
    constexpr int scenes = 60;
    for (int i = 0; i < scenes; ++i) {
        Scene s = random.over_sphere(i % 3 == 0 ? 0 : random.uniform(0.05, 0.5));
        random.add(s, i % 2 == 0 ? random.count(1, 30) : random.count(100, 400), random.count(0, 3), 0);
        const FormFamily family = radial_base_problem(s).family;
        EnvelopeOptions by_pieces;
        by_pieces.incremental = false;
        const auto discs = disc_diagram_on_sphere(family, {});
        if (!discs) continue;
        ++inserted;
        CHECK(!discs->dcel.find_defect());
        CHECK(labels_of(*discs) == labels_of(lower_envelope_on_sphere(family, by_pieces)));
    }
    CHECK(inserted > scenes / 2);
}

TEST_CASE("diagram over a sphere: agrees with brute force on balls of heavy-tailed radii") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < long_rounds(8); ++i) {
        Scene s = random.over_sphere(random.uniform(0.01, 0.5));
        for (int k = random.count(5, 60); k > 0; --k) random.add_heavy_ball(s);
        s.box = {Vec3::Constant(-50), Vec3::Constant(50)};
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
    }
}

TEST_CASE("diagram over a sphere: agrees with brute force on scenes with cylinders") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < long_rounds(10); ++i) {
        Scene s = random.over_sphere(i % 5 == 0 ? 0 : random.uniform(0.05, 0.5));
        const bool lines_only = i % 4 == 0;
        random.add(s, lines_only ? 0 : random.count(0, 5), lines_only ? 0 : random.count(0, 2),
                   random.count(1, 5));
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
    }
}

TEST_CASE("diagram over a cylinder: agrees with brute force on random scenes") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 7 * rounds(); ++i) {
        Scene s = random.over_cylinder(i % 5 == 0 ? 0 : random.uniform(0.05, 0.5));
        const int kinds = 1 + i % 7;  // each mix of balls, planes and cylinders
        random.add(s, kinds & 1 ? random.count(1, 8) : 0, kinds & 2 ? random.count(1, 3) : 0,
                   kinds & 4 ? random.count(1, 5) : 0);
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
    }
}

/// The scene with its base turned, `factor` times as large, `far` times its size from the origin. None if a
/// plane that was clear of the base in the box is not so over the longer stretch that the box leaves it.
std::optional<Scene> somewhere(const Scene& s, RandomScenes& random, double factor, double far) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(random.uniform(0, 3), random.direction()).toRotationMatrix();
    const Scene t = moved(s, turn, factor, far * factor * random.direction());
    try {
        radial_base_problem(t);
    } catch (const InputError& error) {
        if (error.kind == InputError::Kind::TouchesBase) return std::nullopt;
        throw;
    }
    return t;
}

TEST_CASE("diagram over a sphere: agrees with brute force at every scale and distance from the origin") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < long_rounds(8); ++i) {
        Scene s = random.over_sphere();
        random.add(s, random.count(1, 6), random.count(0, 2), i % 4 == 0 ? 2 : 0);
        const double factor = std::pow(10, random.uniform(-6, 6));
        const auto t = somewhere(s, random, factor, i % 4 < 2 ? 0 : std::pow(10, random.uniform(0, 6)));
        REQUIRE(t);
        CHECK(judge(*t, rng).diagram.decisions.assumed == 0);
    }
}

TEST_CASE(
    "diagram over a cylinder: agrees with brute force at every scale, tilt and distance from the origin") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int judged = 0; judged < long_rounds(6);) {
        Scene s = random.over_cylinder();
        random.add(s, random.count(1, 6), random.count(0, 2), judged % 3 == 0 ? 2 : 0);
        const double factor = std::pow(10, random.uniform(-6, 6));
        const auto t = somewhere(s, random, factor, judged % 4 < 2 ? 0 : std::pow(10, random.uniform(0, 3)));
        if (!t) continue;
        CHECK(judge(*t, rng).diagram.decisions.assumed == 0);
        ++judged;
    }
}

TEST_CASE("diagram over a cylinder: agrees with brute force for every tilt of the base") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int judged = 0; judged < long_rounds(6);) {
        Scene s = random.over_cylinder();
        random.add(s, random.count(1, 6), random.count(0, 2), judged % 3 == 0 ? 2 : 0);
        const auto t = somewhere(s, random, 1, 0);
        if (!t) continue;
        CHECK(judge(*t, rng).diagram.decisions.assumed == 0);
        ++judged;
    }
}

// --- The judge ---------------------------------------------------------------------------------------------

TEST_CASE("heights over a cylinder with tips: the plain ones times the distances") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(0, 1);
    Scene scene;
    scene.base = Cylinder{Vec3::Zero(), {1, 2, 3}, 0.01};
    scene.box = {Vec3::Constant(-1), Vec3::Constant(1)};
    scene.objects = {Sphere{{0.5, 0, 0}, 0.1}, Cylinder{{0, 0.5, -0.5}, {1, 0, 0}, 0.05},
                     Plane{{0, 0, 1.25}, {0, 0, 1}}, Cylinder{{0, 0.75, -0.5}, {1, 2, 3}, 0.01}};
    const RadialBaseProblem problem = radial_base_problem(scene);
    const auto [low, high] = problem.stretch;
    for (const int ends : {1, 2, 3}) {
        FormFamily family = problem.family;
        if (ends & 1) family.tips[AxialEnd::Low] = low - 1e-3;
        if (ends & 2) family.tips[AxialEnd::High] = high + 1e-6;
        const Heights plain(problem.family), tipped(family);
        for (int round = 0; round < 200; ++round) {
            const double width = std::pow(10.0, -6 * unit(rng)), x0 = 4 * unit(rng) - 1,
                         y0 = low + unit(rng) * (high - low);
            const Interval x(x0, std::min(3.0, x0 + width)), y(y0, std::min(high, y0 + width));
            const double px = x.lower() + unit(rng) * (x.upper() - x.lower()),
                         py = y.lower() + unit(rng) * (y.upper() - y.lower());
            double d = 1, slope = 0, bend = 0;  // of the distances' product
            if (ends & 1) d = py - (low - 1e-3), slope = 1;
            if (ends & 2) {
                const double q = high + 1e-6 - py;
                bend = -2 * slope;
                slope = slope * q - d;
                d *= q;
            }
            for (std::uint32_t i = 0; i < family.size(); ++i) {
                CAPTURE(i);
                const FormId f{i};
                const Interval at_x(px), at_y(py);
                const HeightJet<Interval> p = plain.jet(f, at_x, at_y), over = tipped.jet(f, x, y);
                const HeightCurvature<Interval> c = plain.curvature(f, at_x, at_y),
                                                bends = tipped.curvature(f, x, y);
                const auto holds = [&](const Interval& box, double value) {
                    const double rounding =
                        1e-9 * (1 + std::abs(value) + std::abs(p.v.mid()) + std::abs(p.gy.mid()));
                    return box.lower() <= value + rounding && value - rounding <= box.upper();
                };
                CHECK(holds(over.v, d * p.v.mid()));
                CHECK(holds(over.gx, d * p.gx.mid()));
                CHECK(holds(over.gy, d * p.gy.mid() + slope * p.v.mid()));
                CHECK(holds(bends.xx, d * c.xx.mid()));
                CHECK(holds(bends.xy, d * c.xy.mid() + slope * p.gx.mid()));
                CHECK(holds(bends.yy, d * c.yy.mid() + 2 * slope * p.gy.mid() + bend * p.v.mid()));
                const HeightJet<Wide> wide = tipped.jet(f, Wide(px), Wide(py));
                CHECK(holds(wide.gy.enclosure(), d * p.gy.mid() + slope * p.v.mid()));
                const Interval height = tipped.value(f, at_x, at_y) * tipped.scale(at_x, at_y);
                CHECK(height.mid() == doctest::Approx((p.v * plain.scale(at_x, at_y)).mid()));
            }
        }
    }
}

TEST_CASE("judge: objects to every corruption of a diagram") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (const bool over_sphere : {true, false}) {
        Scene s = over_sphere ? random.over_sphere() : random.over_cylinder();
        random.add(s, 6, 1, 1);
        const Answer good = judge(s, rng);
        const auto objects_to = [&](const char* how, auto corrupt) {
            CAPTURE(how);
            MinimizationDiagram bad = good.diagram;
            corrupt(bad);
            CHECK_FALSE(Judge(s, good.problem, bad).check(rng).empty());
        };
        const FaceId face{over_sphere ? 0u : 2u};
        const FormId form = good.diagram.face_forms[face], other{form.value == 0 ? 1u : 0u};
        VertexId inner{0};
        while (!good.diagram.sides(inner).empty()) ++inner.value;
        EdgeId arc{0};
        while (good.diagram.pieces(arc).empty()) ++arc.value;
        objects_to("a face renamed", [&](MinimizationDiagram& d) { d.face_forms[face] = other; });
        objects_to("one form for another everywhere", [&](MinimizationDiagram& d) {
            const auto exchange = [&](FormId& f) { f = f == form ? other : f == other ? form : f; };
            for (FormId& f : d.face_forms) exchange(f);
            for (auto& e : d.edges) exchange(e.left), exchange(e.right);
            for (FormId& f : d.vertex_labels_) exchange(f);
            for (FormId& f : d.edge_labels_) exchange(f);
        });
        objects_to("an edge turned round",
                   [&](MinimizationDiagram& d) { std::swap(d.edges[arc].left, d.edges[arc].right); });
        objects_to("a vertex moved", [&](MinimizationDiagram& d) { d.vertices[inner].point.x() += 1e-7; });
        objects_to("a vertex without one of its labels", [&](MinimizationDiagram& d) {
            d.vertex_labels_.erase(d.vertex_labels_.begin() + d.vertex_offsets_[inner.value]);
            for (std::size_t v = inner.value + 1; v < d.vertex_offsets_.size(); ++v) --d.vertex_offsets_[v];
        });
        objects_to("a piece that leads away",
                   [&](MinimizationDiagram& d) { d.pieces_[d.piece_offsets_[arc.value]].direction *= -1; });
        objects_to("the diagram of other radii", [&](MinimizationDiagram& d) {
            Scene t = s;
            for (Object& o : t.objects)
                if (auto* ball = std::get_if<Sphere>(&o)) ball->radius *= 0.99;
            d = answer(t).diagram;
        });
    }
}

TEST_CASE("judge: objects to a hole in the wrong face") {
    // Two small balls before two large ones: a closed edge in each of two faces, whose own edge is closed
    // too.
    Scene s;
    s.base = Sphere{Vec3::Zero(), 0.25};
    s.objects = {Sphere{{2.5, 0, 0}, 2}, Sphere{{-2.5, 0, 0}, 2}, Sphere{{0.4375, 0, 0}, 0.0625},
                 Sphere{{-0.4375, 0, 0}, 0.0625}};
    s.box = {Vec3::Constant(-10), Vec3::Constant(10)};
    std::mt19937_64 rng(test_seed());
    const Answer good = judge(s, rng);
    const MinimizationDiagram& d = good.diagram;
    REQUIRE(d.vertices.size() == 0);
    REQUIRE(d.edges.size() == 3);
    REQUIRE(d.face_forms.size() == 4);
    std::map<FormId, FaceId> face;
    for (const FaceId f : d.face_forms.ids()) face[d.face_forms[f]] = f;
    MinimizationDiagram bad = d;
    bad.dcel = Dcel();
    for (std::size_t i = 1; i < d.face_forms.size(); ++i) bad.dcel.add_face();
    for (const EdgeId e : d.edges.ids()) {
        bad.dcel.add_edge({}, {});
        for (const unsigned side : {0u, 1u}) {
            const FormId form = side == 0 ? d.edges[e].left : d.edges[e].right,
                         beside = side == 0 ? d.edges[e].right : d.edges[e].left;
            FaceId f = face[form];
            // The edge of small ball 2 as a hole in the face of large ball 1.
            if (form.value == 0 && beside.value == 2) f = face[FormId{1}];
            const bool outer = bad.dcel.outer_ccb(f) == CcbId{} && f != Dcel::unbounded_face();
            outer ? bad.dcel.add_outer_ccb(f, Dcel::half_edge(e, side))
                  : bad.dcel.add_inner_ccb(f, Dcel::half_edge(e, side));
        }
    }
    for (const EdgeId e : d.edges.ids()) {
        bad.edges[e].left = d.face_forms[bad.dcel.face(Dcel::half_edge(e, 0))];
        bad.edges[e].right = d.face_forms[bad.dcel.face(Dcel::half_edge(e, 1))];
    }
    CHECK_FALSE(Judge(s, good.problem, bad).check(rng).empty());
}

}  // namespace
}  // namespace vcell::radial::radial_diagram_test
