// Minimization diagrams over sphere and cylinder bases against brute force: random scenes of every mix,
// motions, symmetric arrangements. VCELL_TEST_ROUNDS asks for more rounds than one.
#include <doctest/doctest.h>

#include <map>
#include <optional>
#include <set>

#include "../../core/errors.hpp"
#include "../../envelope/recursion/heights.hpp"
#include "../../envelope/sphere/sphere_diagram.hpp"
#include "../test_support.hpp"
#include "complaints.hpp"
#include "radial_oracle.hpp"
#include "radial_scenes.hpp"

namespace vcell::radial {
namespace {

struct Answer {
    RadialBaseProblem problem;
    MinimizationDiagram diagram;
};

Answer answer(const Scene& scene, const EnvelopeOptions& options = {}) {
    validate(scene);
    Answer a{radial_base_problem(scene), {}};
    const auto [low, high] = a.problem.stretch;
    a.diagram = a.problem.is_sphere ? lower_envelope_on_sphere(a.problem.family, options)
                                    : lower_envelope_on_cylinder(a.problem.family, low, high, options);
    return a;
}

std::string in_words(const Scene& s) {
    std::string text;
    const auto vector = [](const Vec3& p) {
        char line[100];
        std::snprintf(line, sizeof line, "%.17g, %.17g, %.17g", p.x(), p.y(), p.z());
        return "[" + std::string(line) + "]";
    };
    const auto number = [](double r) {
        char line[40];
        std::snprintf(line, sizeof line, "%.17g", r);
        return std::string(line);
    };
    const auto object = [&](const Object& o) {
        if (const auto* b = std::get_if<Sphere>(&o))
            return R"({"sphere": {"center": )" + vector(b->center) + R"(, "radius": )" + number(b->radius) +
                   "}}";
        if (const auto* p = std::get_if<Plane>(&o))
            return R"({"plane": {"point": )" + vector(p->point) + R"(, "normal": )" + vector(p->normal) +
                   "}}";
        const auto& c = std::get<Cylinder>(o);
        return R"({"cylinder": {"point": )" + vector(c.point) + R"(, "axis": )" + vector(c.axis) +
               R"(, "radius": )" + number(c.radius) + "}}";
    };
    text = R"({"vcell": 1, "base": )" + object(s.base) + R"(, "objects": [)";
    for (const Object& o : s.objects) text += (&o == s.objects.data() ? "" : ", ") + object(o);
    return text + R"(], "box": {"min": )" + vector(s.box.min) + R"(, "max": )" + vector(s.box.max) + "}}";
}

/// The scene's diagram, after it was judged.
Answer judge(const Scene& scene, std::mt19937_64& rng, const Options& options = {},
             const EnvelopeOptions& how = {}) {
    CAPTURE(in_words(scene));
    Answer a;
    std::vector<std::string> complaints{"no diagram"};
    CHECK_NOTHROW(
        (a = answer(scene, how), complaints = Judge(scene, a.problem, a.diagram).check(rng, options)));
    CHECK_MESSAGE(complaints.empty(), join(complaints));
    CHECK(a.diagram.assumptions.size() == a.diagram.decisions.assumed);
    return a;
}

// --- Random scenes ---------------------------------------------------------------------------------------

TEST_CASE("diagram over a sphere: agrees with brute force on random balls and planes") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 40 * rounds(); ++i) {
        Scene s = random.over_sphere(i % 5 == 0 ? 0 : random.uniform(0.05, 0.5));
        random.add(s, random.count(0, 24), random.count(0, 4), 0);
        EnvelopeOptions by_pieces;
        by_pieces.incremental = false;
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
        CHECK(judge(s, rng, {}, by_pieces).diagram.decisions.assumed == 0);
    }
}

/// Labels of vertices, in the order of their forms around them, of edges and of faces.
std::multiset<std::vector<FormId>> labels_of(const MinimizationDiagram& d) {
    std::multiset<std::vector<FormId>> out;
    for (const VertexId v : d.vertices.ids()) {
        std::vector<FormId> around;
        const HalfEdgeId start = d.dcel.outgoing(v);
        HalfEdgeId h = start;
        do {
            around.push_back(d.face_forms[d.dcel.face(h)]);
            h = d.dcel.next_around_origin(h);
        } while (h != start);
        std::ranges::rotate(around, std::ranges::min_element(around));
        around.push_back({});
        out.insert(around);
    }
    for (const EdgeId e : d.edges.ids()) out.insert({d.label(e).begin(), d.label(e).end()});
    for (const FormId f : d.face_forms) out.insert({f});
    return out;
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
    for (int i = 0; i < 15 * rounds(); ++i) {
        Scene s = random.over_sphere(random.uniform(0.01, 0.5));
        for (int k = random.count(5, 60); k > 0; --k) random.add_heavy_ball(s);
        s.box = {Vec3::Constant(-50), Vec3::Constant(50)};
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
    }
}

TEST_CASE("diagram over a sphere: agrees with brute force on scenes with cylinders") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 20 * rounds(); ++i) {
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
    for (int i = 0; i < 14 * rounds(); ++i) {
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
    for (int i = 0; i < 16 * rounds(); ++i) {
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
    for (int judged = 0; judged < 12 * rounds();) {
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
    for (int judged = 0; judged < 12 * rounds();) {
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

// --- Figures that are known
// -----------------------------------------------------------------------------------

/// Half-edges that leave a vertex.
int degree(const Dcel& dcel, VertexId v) {
    const HalfEdgeId first = dcel.outgoing(v);
    int n = 0;
    if (first.valid())
        for (HalfEdgeId h = first; n == 0 || h != first; h = dcel.next_around_origin(h)) ++n;
    return n;
}

/// How many vertices have each pair of degree and number of nearest sites (a form's sites all count).
std::map<std::pair<int, int>, int> vertex_types(const Answer& a) {
    std::map<std::pair<int, int>, int> types;
    for (const VertexId v : a.diagram.vertices.ids()) {
        int sites = 0;
        for (const FormId f : a.diagram.label(v)) sites += static_cast<int>(a.problem.sites[f].size());
        ++types[{degree(a.diagram.dcel, v), sites}];
    }
    return types;
}

struct Counts {
    std::size_t vertices, edges, faces;
    friend bool operator==(const Counts&, const Counts&) = default;
};

/// Of a diagram; faces with a label.
Counts counts(const Answer& a) {
    return {a.diagram.vertices.size(), a.diagram.edges.size(),
            static_cast<std::size_t>(
                std::ranges::count_if(a.diagram.face_forms, [](FormId f) { return f.valid(); }))};
}

Answer exact_judge(const Scene& s) {
    std::mt19937_64 rng(test_seed());
    Answer a = judge(s, rng);
    CHECK(a.diagram.decisions.assumed == 0);
    return a;
}

Scene around_ball(double radius, std::vector<Object> objects, double half) {
    Scene s;
    s.base = Sphere{Vec3::Zero(), radius};
    s.objects = std::move(objects);
    s.box = {Vec3::Constant(-half), Vec3::Constant(half)};
    return s;
}

std::vector<Object> balls(const std::vector<Vec3>& centers, double radius) {
    std::vector<Object> all;
    for (const Vec3& c : centers) all.push_back(Sphere{c, radius});
    return all;
}

std::vector<Vec3> octahedron(double r) {
    return {{r, 0, 0}, {-r, 0, 0}, {0, r, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}};
}

std::vector<Vec3> cube(double r) {
    std::vector<Vec3> all;
    for (const double x : {-r, r})
        for (const double y : {-r, r})
            for (const double z : {-r, r}) all.push_back({x, y, z});
    return all;
}

/// Cyclic permutations and all signs of (0, a, b).
std::vector<Vec3> rectangles(double a, double b) {
    std::vector<Vec3> all;
    for (const double s : {-1, 1})
        for (const double t : {-1, 1}) {
            all.push_back({0, s * a, t * b});
            all.push_back({s * a, t * b, 0});
            all.push_back({t * b, 0, s * a});
        }
    return all;
}

TEST_CASE("octahedron: six balls, planes or points leave a cube") {
    using Types = std::map<std::pair<int, int>, int>;
    const Types expected{{{3, 3}, 8}};
    std::vector<Object> planes;
    for (const Vec3& p : octahedron(2)) planes.push_back(Plane{p, p});
    for (const Scene& s :
         {around_ball(0.5, balls(octahedron(2), 0.5), 8), around_ball(0.5, balls(octahedron(2), 0.75), 8),
          around_ball(0, balls(octahedron(2), 0), 8), around_ball(1.5, balls(octahedron(2), 1.25), 8),
          around_ball(0.5, planes, 8), around_ball(0.5, {}, 8)}) {
        const Answer a = exact_judge(s);
        CHECK(vertex_types(a) == expected);
        CHECK(counts(a) == Counts{8, 12, 6});
    }
}

TEST_CASE("cube: eight balls, planes or points leave an octahedron with vertices of degree four") {
    using Types = std::map<std::pair<int, int>, int>;
    const Types expected{{{4, 4}, 6}};
    std::vector<Object> planes;
    for (const Vec3& p : cube(2)) planes.push_back(Plane{p, p});
    for (const Scene& s :
         {around_ball(0.5, balls(cube(2), 0.5), 16), around_ball(0.25, balls(cube(2), 1), 16),
          around_ball(0, balls(cube(2), 0), 16), around_ball(0.5, planes, 16)}) {
        const Answer a = exact_judge(s);
        CHECK(vertex_types(a) == expected);
        CHECK(counts(a) == Counts{6, 12, 8});
    }
}

TEST_CASE("ties of four and more balls: insertion finds what pieces find") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    const auto both = [&](const Scene& s) {
        const FormFamily family = radial_base_problem(s).family;
        EnvelopeOptions by_pieces;
        by_pieces.incremental = false;
        const auto discs = disc_diagram_on_sphere(family, {});
        const MinimizationDiagram pieces = lower_envelope_on_sphere(family, by_pieces);
        if (!discs) return std::pair(false, std::size_t{0});
        CHECK(!discs->dcel.find_defect());
        CHECK(labels_of(*discs) == labels_of(pieces));
        std::multiset<std::vector<FormId>> labels, expected;
        std::size_t ties = 0;
        for (const VertexId v : discs->vertices.ids()) {
            labels.insert({discs->label(v).begin(), discs->label(v).end()});
            if (discs->label(v).size() > 3) ++ties;
        }
        for (const VertexId v : pieces.vertices.ids())
            expected.insert({pieces.label(v).begin(), pieces.label(v).end()});
        CHECK(labels == expected);
        return std::pair(true, ties);
    };
    // A cube's corners before a crowd that they hide: the cell has six vertices of degree four.
    std::vector<Object> crowd = balls(cube(2), 0.5);
    for (int i = 0; i < 2000; ++i) {
        Vec3 p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        crowd.push_back(Sphere{random.uniform(9, 10) * p.normalized(), random.uniform(0, 0.1)});
    }
    const auto [is_crowd_inserted, crowd_ties] = both(around_ball(0.5, crowd, 20));
    CHECK(is_crowd_inserted);
    CHECK(crowd_ties == 6);
    // Points of a lattice within a shell: ties of all kinds, and forms that touch in vertices.
    int inserted = 0;
    std::size_t ties = 0;
    for (int least = 3; least <= 40; ++least) {
        std::vector<Vec3> points;
        for (int x = -7; x <= 7; ++x)
            for (int y = -7; y <= 7; ++y)
                for (int z = -7; z <= 7; ++z)
                    if (const int square = x * x + y * y + z * z; square >= least && square <= least + 12)
                        points.push_back(Vec3(x, y, z));
        const auto [is_inserted, tied] = both(around_ball(0.25, balls(points, 0.125), 32));
        inserted += is_inserted;
        ties += tied;
    }
    CHECK(inserted > 30);
    CHECK(ties > 1000);
}

TEST_CASE("icosahedron: twelve balls leave twenty vertices of degree three") {
    // Near the golden ratio: its vertices are not degenerate, any ratio near it does.
    const double golden = (1 + std::sqrt(5.0)) / 2;
    for (const double b : {golden, 1.625, 1.6}) {
        const Answer a = exact_judge(around_ball(0.25, balls(rectangles(1, b), 0.5), 8));
        CHECK(counts(a) == Counts{20, 30, 12});
        for (const auto& [type, count] : vertex_types(a)) CHECK(type == std::pair{3, 3});
    }
}

TEST_CASE("dodecahedron: twenty balls nearly tie by fives, and every tie is decided") {
    // In doubles the golden ratio's pentagons fall apart: each leaves a vertex of degree five or several
    // close ones.
    const double golden = (1 + std::sqrt(5.0)) / 2;
    std::vector<Vec3> centers = cube(1);
    for (const Vec3& p : rectangles(golden, 1 / golden)) centers.push_back(p);
    const Scene s = around_ball(0.25, balls(centers, 0.375), 8);
    const Answer a = answer(s);
    CHECK_FALSE(a.diagram.dcel.find_defect());
    CHECK(a.diagram.decisions.assumed == 0);
    CHECK(counts(a).faces == 20);
    int excess = 0;
    for (const auto& [type, count] : vertex_types(a)) {
        CHECK(type.first == type.second);
        excess += (type.first - 2) * count;
    }
    CHECK(excess == 2 * (20 - 2));  // Euler's relation on the sphere
}

TEST_CASE("lattices: the cells of their points, with every tie") {
    std::vector<Vec3> sc, bcc, fcc;
    for (int x = -4; x <= 4; ++x)
        for (int y = -4; y <= 4; ++y)
            for (int z = -4; z <= 4; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                const Vec3 p(x, y, z);
                if (x % 2 == 0 && y % 2 == 0 && z % 2 == 0) sc.push_back(p);
                if ((x - y) % 2 == 0 && (y - z) % 2 == 0) bcc.push_back(p);
                if ((x + y + z) % 2 == 0) fcc.push_back(p);
            }
    using Types = std::map<std::pair<int, int>, int>;
    for (const double radius : {0.0, 0.25, 0.75}) {
        CAPTURE(radius);
        const auto cell = [&](const std::vector<Vec3>& lattice) {
            return exact_judge(around_ball(radius, balls(lattice, radius), 16));
        };
        const Answer cube_cell = cell(sc), truncated_octahedron = cell(bcc), rhombic_dodecahedron = cell(fcc);
        CHECK(counts(cube_cell) == Counts{8, 12, 6});
        CHECK(vertex_types(cube_cell) == Types{{{3, 7}, 8}});
        for (const EdgeId e : cube_cell.diagram.edges.ids()) CHECK(cube_cell.diagram.label(e).size() == 3);
        CHECK(counts(truncated_octahedron) == Counts{24, 36, 14});
        CHECK(vertex_types(truncated_octahedron) == Types{{{3, 3}, 24}});
        CHECK(counts(rhombic_dodecahedron) == Counts{14, 24, 12});
        CHECK(vertex_types(rhombic_dodecahedron) == Types{{{3, 3}, 8}, {{4, 5}, 6}});
    }
}

// --- Closed edges, holes, faces all around
// -----------------------------------------------------------------------

TEST_CASE("a small ball between two large ones: a closed edge without vertices") {
    const Answer a = exact_judge(around_ball(0.25, {Sphere{{2.5, 0, 0}, 2}, Sphere{{-2.5, 0, 0}, 2}}, 16));
    CHECK(counts(a) == Counts{0, 1, 2});
    const Answer unequal =
        exact_judge(around_ball(0.25, {Sphere{{1, 2, 2}, 2.5}, Sphere{{-1, -2, -2.25}, 2.25}}, 64));
    CHECK(counts(unequal) == Counts{0, 1, 2});
}

TEST_CASE("small balls before large ones: faces with holes") {
    std::vector<Object> objects{Sphere{{0, 0, 8}, 7}, Sphere{{0, 0, -8}, 7}};
    for (const double x : {-0.2125, 0.2125})
        for (const double z : {-0.2125, 0.2125}) objects.push_back(Sphere{{x, 0, z}, 0.03125});
    const Answer a = exact_judge(around_ball(0.25, objects, 64));
    CHECK(counts(a) == Counts{0, 5, 6});
}

TEST_CASE("balls with centres in one plane: each edge goes from side to side of the box") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 5; ++i) {
        std::vector<Object> ring;
        for (int k = 0; k < 7; ++k) {
            const double angle = 2 * std::numbers::pi * (k + random.uniform(-0.2, 0.2)) / 7;
            ring.push_back(Sphere{{random.uniform(1.5, 1.75) * std::cos(angle),
                                   random.uniform(1.5, 1.75) * std::sin(angle), 0.25},
                                  random.uniform(0.25, 0.45)});
        }
        Scene s = around_ball(0.5, ring, 8);
        std::get<Sphere>(s.base).center.z() = 0.25;
        const Answer a = exact_judge(s);
        CHECK(counts(a) == Counts{14, 21, 9});
    }
}

TEST_CASE("over a cylinder: faces that go all around meet in a closed edge") {
    Scene s;
    s.base = Cylinder{Vec3::Zero(), Vec3::UnitY(), 0.5};
    s.objects = {Sphere{{0, 5, 0}, 2.5}, Sphere{{0, -5, 0}, 2.5}};
    s.box = {{-8, -2, -8}, {8, 2, 8}};
    CHECK(counts(exact_judge(s)) == Counts{0, 3, 2});
    s.objects.push_back(Sphere{{0.625, 1.375, 0}, 0.0625});  // and a hole
    CHECK(counts(exact_judge(s)) == Counts{0, 4, 3});
    s.objects.pop_back();
    s.objects.pop_back();  // one face
    s.box = {{-16, -2, -16}, {16, 2, 16}};
    CHECK(counts(exact_judge(s)) == Counts{0, 2, 1});
}

// --- Nested and overlapping balls
// ---------------------------------------------------------------------------------

TEST_CASE("overlapping balls: clearance is negative where the boundary runs inside the base") {
    const Scene s = around_ball(1, {Sphere{{1.5, 0, 0}, 1.25}, Sphere{{-0.5, 1, 0.25}, 0.75}}, 8);
    const Answer a = exact_judge(s);
    const Surroundings around(s, a.problem);
    const Eigen::Vector2d towards = a.problem.chart_point({0.8, 0.6, 0}, 0);
    const auto nearest = around.nearest(towards.x(), towards.y());
    CHECK(nearest.item == 0);
    CHECK(static_cast<double>(nearest.distance) == doctest::Approx(2.1875 / 2.9));  // within the base
}

TEST_CASE("nested balls: the inner one is left out and named") {
    const Scene s =
        around_ball(0.25, {Sphere{{2, 0, 0}, 1}, Sphere{{2.25, 0, 0}, 0.5}, Sphere{{0, 2, 0}, 1}}, 8);
    const Answer a = exact_judge(s);
    REQUIRE(a.problem.warnings.size() == 1);
    CHECK(a.problem.warnings[0].find("object 1") != std::string::npos);
    Scene without = s;
    without.objects.erase(without.objects.begin() + 1);
    CHECK(counts(a) == counts(exact_judge(without)));
}

// --- Motions
// ----------------------------------------------------------------------------------------------------------

/// The faces around each vertex and along each boundary of a face, by their sites: what a rotation keeps.
std::multiset<std::vector<Site>> cycles(const Answer& a) {
    std::multiset<std::vector<Site>> all;
    const Dcel& dcel = a.diagram.dcel;
    const auto add = [&](std::vector<Site> cycle, std::vector<Site> head) {
        std::vector<Site> least = cycle;
        for (std::size_t i = 0; i < cycle.size(); ++i) {
            std::ranges::rotate(cycle, cycle.begin() + 1);
            least = std::min(least, cycle);
        }
        head.insert(head.end(), least.begin(), least.end());
        all.insert(head);
    };
    const auto site = [&](FaceId f) { return a.problem.sites[a.diagram.face_forms[f]].front(); };
    for (const VertexId v : a.diagram.vertices.ids()) {
        std::vector<Site> cycle;
        const HalfEdgeId first = dcel.outgoing(v);
        HalfEdgeId h = first;
        do {
            cycle.push_back(site(dcel.face(h)));
            h = dcel.next_around_origin(h);
        } while (h != first);
        add(cycle, {});
    }
    for (std::uint32_t c = 0; c < dcel.ccb_count(); ++c) {
        std::vector<Site> cycle;
        const HalfEdgeId first = dcel.start({c});
        HalfEdgeId h = first;
        do {
            cycle.push_back(site(dcel.face(Dcel::twin(h))));
            h = dcel.next(h);
        } while (h != first);
        add(cycle, {site(dcel.face(CcbId{c})), Site::base()});
    }
    return all;
}

TEST_CASE("diagram over a sphere: a rotation of the scene keeps it") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 6 * rounds(); ++i) {
        // A cage keeps the box, which does not turn, out of sight.
        Scene s = around_ball(0.3, balls(rectangles(2, 3.2), 1), 64);
        random.add(s, random.count(5, 20), 0, i % 2 == 0 ? 0 : 2);
        const Answer before = answer(s);
        for (const FormId f : before.diagram.face_forms) REQUIRE(before.problem.sites[f].front().is_object());
        for (int k = 0; k < 4; ++k) {
            const Eigen::Matrix3d turn =
                Eigen::AngleAxisd(random.uniform(0, 3), random.direction()).toRotationMatrix();
            const Answer after = answer(moved(s, turn, 1, Vec3::Zero()));
            CHECK(cycles(after) == cycles(before));
            CHECK(after.diagram.decisions.assumed == 0);
        }
    }
}

TEST_CASE("diagram over a sphere: scaling by powers of two scales all coordinates") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 6 * rounds(); ++i) {
        Scene s = random.over_sphere();
        random.add(s, random.count(3, 10), random.count(0, 2), i % 2);
        const Answer before = answer(s);
        for (const double factor : {0x1p-20, 0x1p20}) {
            const Answer after = answer(moved(s, Eigen::Matrix3d::Identity(), factor, Vec3::Zero()));
            REQUIRE(cycles(after) == cycles(before));
            for (const VertexId v : before.diagram.vertices.ids()) {
                CHECK(after.diagram.vertices[v].point == before.diagram.vertices[v].point);
                CHECK(after.diagram.vertices[v].height == before.diagram.vertices[v].height / factor);
            }
        }
    }
}

// --- Points and lines
// ---------------------------------------------------------------------------------------------------

TEST_CASE("points: cells are intersections of half-spaces") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 5 * rounds(); ++i) {
        Scene s = random.over_sphere(0);
        for (int k = 0; k < 18; ++k) random.add_ball(s, 0);
        const Answer a = exact_judge(s);
        std::set<std::set<Site>> found, expected;
        for (const VertexId v : a.diagram.vertices.ids()) {
            std::set<Site> sites;
            for (const FormId f : a.diagram.label(v)) sites.insert(a.problem.sites[f].front());
            found.insert(sites);
        }
        // Half-spaces n . p <= k, and every point on three of their planes that lies in all.
        std::vector<std::pair<Site, Eigen::Vector4d>> half_spaces;
        for (std::uint32_t k = 0; k < s.objects.size(); ++k) {
            const Vec3 c = std::get<Sphere>(s.objects[k]).center;
            half_spaces.push_back({Site::object(k), {c.x(), c.y(), c.z(), c.squaredNorm() / 2}});
        }
        for (std::uint32_t side = 0; side < 6; ++side) {
            Eigen::Vector4d h = Eigen::Vector4d::Zero();
            h[side / 2] = side % 2 == 0 ? -1 : 1;
            h[3] = side % 2 == 0 ? -s.box.min[side / 2] : s.box.max[side / 2];
            half_spaces.push_back({Site::box_side(side), h});
        }
        for (std::size_t x = 0; x < half_spaces.size(); ++x)
            for (std::size_t y = 0; y < x; ++y)
                for (std::size_t z = 0; z < y; ++z) {
                    Eigen::Matrix3d n;
                    Vec3 k;
                    int row = 0;
                    for (const std::size_t j : {x, y, z}) {
                        n.row(row) = half_spaces[j].second.head<3>();
                        k[row++] = half_spaces[j].second[3];
                    }
                    const Vec3 p = n.fullPivLu().solve(k);
                    if (!((n * p - k).norm() < 1e-9)) continue;  // parallel
                    const bool inside = std::ranges::all_of(half_spaces, [&](const auto& h) {
                        return h.second.template head<3>().dot(p) <= h.second[3] + 1e-11;
                    });
                    if (inside)
                        expected.insert({half_spaces[x].first, half_spaces[y].first, half_spaces[z].first});
                }
        CHECK(found == expected);
    }
}

TEST_CASE("lines: cells of a line among lines and of a point among lines") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    for (int i = 0; i < 6 * rounds(); ++i) {
        Scene s = i % 2 == 0 ? random.over_cylinder(0) : random.over_sphere(0);
        for (int k = random.count(2, 6); k > 0; --k) random.add_cylinder(s, 0);
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
    }
}

}  // namespace
}  // namespace vcell::radial
