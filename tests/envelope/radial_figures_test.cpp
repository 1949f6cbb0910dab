// Minimization diagrams over sphere and cylinder bases that are known: polyhedra, lattices, closed edges and
// holes, nested balls, points and lines; and what motions of a scene keep.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "../../core/errors.hpp"
#include "../../envelope/sphere/sphere_diagram.hpp"
#include "radial_answers.hpp"

namespace vcell::radial::radial_figures_test {
namespace {

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

/// Does insertion decide the scene, and in how many vertices and along how many edges do more forms tie than
/// need to?
struct Ties {
    bool is_inserted = false;
    std::size_t in_vertices = 0, along_edges = 0;
};

/// The ties of a scene whose diagram insertion, if it finds one, finds as pieces do.
Ties ties_both_ways(const Scene& s) {
    CAPTURE(in_words(s));
    const FormFamily family = radial_base_problem(s).family;
    EnvelopeOptions by_pieces;
    by_pieces.incremental = false;
    const auto discs = disc_diagram_on_sphere(family, {});
    const MinimizationDiagram pieces = lower_envelope_on_sphere(family, by_pieces);
    if (!discs) return {};
    CHECK(!discs->dcel.find_defect());
    CHECK(labels_of(*discs) == labels_of(pieces));
    std::multiset<std::vector<FormId>> labels, expected;
    Ties ties{true};
    for (const VertexId v : discs->vertices.ids()) {
        labels.insert({discs->label(v).begin(), discs->label(v).end()});
        if (discs->label(v).size() > 3) ++ties.in_vertices;
    }
    for (const VertexId v : pieces.vertices.ids())
        expected.insert({pieces.label(v).begin(), pieces.label(v).end()});
    CHECK(labels == expected);
    for (const EdgeId e : discs->edges.ids()) ties.along_edges += discs->label(e).size() > 2;
    return ties;
}

TEST_CASE("ties of four and more balls: insertion finds what pieces find") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    // A cube's corners before a crowd that they hide: the cell has six vertices of degree four.
    std::vector<Object> crowd = balls(cube(2), 0.5);
    for (int i = 0; i < 2000; ++i) {
        Vec3 p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        crowd.push_back(Sphere{random.uniform(9, 10) * p.normalized(), random.uniform(0, 0.1)});
    }
    const Ties of_crowd = ties_both_ways(around_ball(0.5, crowd, 20));
    CHECK(of_crowd.is_inserted);
    CHECK(of_crowd.in_vertices == 6);
    // Points of a lattice within a shell: ties of all kinds, and forms that touch in vertices.
    int inserted = 0;
    std::size_t ties = 0;
    for (int least = 1; least <= 40; ++least) {
        std::vector<Vec3> points;
        for (int x = -7; x <= 7; ++x)
            for (int y = -7; y <= 7; ++y)
                for (int z = -7; z <= 7; ++z)
                    if (const int square = x * x + y * y + z * z; square >= least && square <= least + 12)
                        points.push_back(Vec3(x, y, z));
        const Ties found = ties_both_ways(around_ball(0.25, balls(points, 0.125), 32));
        inserted += found.is_inserted;
        ties += found.in_vertices;
    }
    CHECK(inserted > 30);
    CHECK(ties > 1000);
}

TEST_CASE("ties along edges: insertion finds what pieces find") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    // In a simple cubic lattice all neighbours but six touch the cell along an edge or in a corner.
    std::vector<Vec3> lattice;
    for (int x = -3; x <= 3; ++x)
        for (int y = -3; y <= 3; ++y)
            for (int z = -3; z <= 3; ++z)
                if (x != 0 || y != 0 || z != 0) lattice.push_back(Vec3(x, y, z));
    const Ties of_lattice = ties_both_ways(around_ball(0.25, balls(lattice, 0.25), 16));
    CHECK(of_lattice.is_inserted);
    CHECK(of_lattice.in_vertices == 8);
    CHECK(of_lattice.along_edges == 12);
    // Balls with centres on a circle through the base's tie along its axis, whichever of them come first: a
    // ball that is nearer than a neighbour, and between two of them, has a face until that comes.
    int inserted = 0;
    std::size_t ties = 0;
    for (int i = 0; i < 60; ++i) {
        std::vector<Vec3> centers;
        for (const auto& [x, y] : {std::pair{24, 7},
                                   {20, 15},
                                   {15, 20},
                                   {7, 24},
                                   {0, 25},
                                   {-7, 24},
                                   {-15, 20},
                                   {-20, 15},
                                   {-24, 7},
                                   {-25, 0}})
            for (const int side : {-1, 1})
                if (random.uniform(0, 1) < 0.4) centers.push_back(Vec3(x - 25, side * y, 0));
        for (int k = 0; k < i % 7; ++k) {
            const Vec3 p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
            centers.push_back(random.uniform(30, 60) * p.normalized());
        }
        std::ranges::shuffle(centers, rng);
        const Ties found = ties_both_ways(around_ball(0.5, balls(centers, 0.5), 64));
        inserted += found.is_inserted;
        ties += found.along_edges;
    }
    CHECK(inserted > 40);
    CHECK(ties > 20);
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

TEST_CASE("overlapping balls: clearance is negative where the boundary runs inside the base") {
    const Scene s = around_ball(1, {Sphere{{1.5, 0, 0}, 1.25}, Sphere{{-0.5, 1, 0.25}, 0.75}}, 8);
    const Answer a = exact_judge(s);
    const Surroundings around(s, a.problem);
    const Eigen::Vector2d towards = a.problem.chart.chart_point({0.8, 0.6, 0}, 0);
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
    for (int i = 0; i < long_rounds(6); ++i) {
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
    for (int i = 0; i < long_rounds(6); ++i) {
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
                    const Vec3 p = n.inverse() * k;
                    if (!((n * p - k).norm() < 1e-9)) continue;  // parallel, or not finite
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
    for (int i = 0; i < long_rounds(6); ++i) {
        Scene s = i % 2 == 0 ? random.over_cylinder(0) : random.over_sphere(0);
        for (int k = random.count(2, 6); k > 0; --k) random.add_cylinder(s, 0);
        CHECK(judge(s, rng).diagram.decisions.assumed == 0);
    }
}

}  // namespace
}  // namespace vcell::radial::radial_figures_test
