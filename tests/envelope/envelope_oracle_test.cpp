/// lower_envelope() against brute force, on random and on degenerate scenes.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "../test_support.hpp"
#include "canonical.hpp"
#include "complaints.hpp"
#include "form_scenes.hpp"
#include "oracle.hpp"

namespace vcell::envelope_oracle_test {
namespace {

void judge(const FormScene& scene, std::mt19937_64& rng, const oracle::OracleOptions& options = {}) {
    CAPTURE(scene.name);
    const FormFamily family = scene.family();
    std::vector<std::string> complaints;
    CHECK_NOTHROW(complaints =
                      oracle::check_diagram(lower_envelope(family, scene.region()), family, rng, options));
    CHECK_MESSAGE(complaints.empty(), join(complaints));
}

// --- Motions that keep the combinatorial diagram ----------------------------------------------------

oracle::Renaming identity(const FormScene& s) {
    oracle::Renaming r;
    r.form.resize(s.numbers.size());
    std::iota(r.form.begin(), r.form.end(), 0u);
    r.side.resize(s.region().sides.size());
    std::iota(r.side.begin(), r.side.end(), 0u);
    return r;
}

void same_diagram(const FormScene& before, const FormScene& after, const oracle::Renaming& renaming,
                  const std::string& motion) {
    CAPTURE(before.name);
    CAPTURE(motion);
    std::vector<std::string> a, b;
    CHECK_NOTHROW(a = oracle::canonical(lower_envelope(before.family(), before.region()), renaming));
    CHECK_NOTHROW(b = oracle::canonical(lower_envelope(after.family(), after.region()), identity(after)));
    CHECK(a == b);
}

/// Pre: the region is a rectangle.
void invariances(const FormScene& s, std::mt19937_64& rng) {
    {
        FormScene t = s;
        oracle::Renaming r = identity(s);
        std::ranges::shuffle(r.form, rng);
        for (std::size_t i = 0; i < r.form.size(); ++i) t.numbers[r.form[i]] = s.numbers[i];
        same_diagram(s, t, r, "permutation");
    }
    {
        FormScene t = s;
        const double x = 37.5, y = -12.25;
        for (auto& n : t.numbers) {
            if (n.k != 0) n.cx += x, n.cy += y;
            n.e -= n.a * x + n.b * y;
        }
        t.rectangle = {s.rectangle[0] + x, s.rectangle[1] + y, s.rectangle[2] + x, s.rectangle[3] + y};
        same_diagram(s, t, identity(s), "translation");
    }
    for (const double scale : {0x1p-30, 0x1p20}) {
        FormScene t = s;
        for (auto& n : t.numbers) {
            n.cx *= scale, n.cy *= scale;
            n.e *= n.k != 0 ? scale * scale : scale;
            if (n.k != 0) n.w *= scale;
        }
        for (double& v : t.rectangle) v *= scale;
        same_diagram(s, t, identity(s), "scaling");
    }
    {
        FormScene t = s;
        for (auto& n : t.numbers) n.cx = -n.cx, n.a = -n.a;
        t.rectangle = {-s.rectangle[2], s.rectangle[1], -s.rectangle[0], s.rectangle[3]};
        oracle::Renaming r = identity(s);
        std::swap(r.side[1], r.side[3]);
        r.mirrored = true;
        same_diagram(s, t, r, "mirror");
    }
}

}  // namespace

TEST_CASE("lower_envelope: agrees with brute force on random spheres of several sizes and densities") {
    std::mt19937_64 rng(test_seed());
    for (const int n : {2, 3, 5, 8, 12, 30, 100, rounds() > 1 ? 400 : 150})
        for (const double density : {0.2, 1.0, 20.0})
            judge(random_spheres(rng, n, std::sqrt(n / density)), rng);
    for (int i = 0; i < long_rounds(50); ++i) judge(random_spheres(rng, 4 + i % 9, 2), rng, {.samples = 100});
}

TEST_CASE("lower_envelope: agrees with brute force on heavy-tailed radii") {
    std::mt19937_64 rng(test_seed());
    for (const int n : {5, 10, 16, 50, rounds() > 1 ? 500 : 150}) judge(heavy_tailed(rng, n), rng);
    for (int i = 0; i < long_rounds(50); ++i) judge(heavy_tailed(rng, 4 + i % 9), rng, {.samples = 100});
}

TEST_CASE("lower_envelope: agrees with brute force on spheres mixed with planes") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(65); ++i)
        judge(spheres_and_planes(rng, 1 + i % 13, 1 + i % 2), rng, {.samples = 100});
    for (const auto& [spheres, planes] :
         {std::pair{1, 1}, {0, 12}, {6, 6}, {50, 4}, {20, 60}, {rounds() > 1 ? 300 : 100, 20}}) {
        judge(spheres_and_planes(rng, spheres, planes), rng);
        judge(in_polygon(spheres_and_planes(rng, spheres + 1, planes)), rng);
    }
}

TEST_CASE("lower_envelope: agrees with brute force on degenerate families") {
    std::mt19937_64 rng(test_seed());
    for (const FormScene& s : degenerate_scenes())
        judge(s, rng, {.brute_force_forms = rounds() > 1 ? 40u : 20u});
}

TEST_CASE("lower_envelope: permutation, translation, scaling and mirror keep the diagram") {
    std::mt19937_64 rng(test_seed());
    for (const FormScene& s : degenerate_scenes()) invariances(s, rng);
    for (const int n : {3, 10, 60}) {
        invariances(random_spheres(rng, n, std::sqrt(n)), rng);
        invariances(heavy_tailed(rng, n), rng);
        invariances(spheres_and_planes(rng, n, 3), rng);
    }
}

TEST_CASE("lower_envelope: doubles and intervals decide random scenes") {
    std::mt19937_64 rng(test_seed());
    Decisions total;
    int with_exact_signs = 0, scenes = 0;
    for (int round = 0; round < 50; ++round)
        for (const int n : {4, 8, 16, 24, 100}) {
            const FormScene s = random_spheres(rng, n, std::sqrt(n));
            const Decisions d = lower_envelope(s.family(), s.region()).decisions;
            CHECK(d.assumed == 0);
            with_exact_signs += d.by_exact > 0;
            ++scenes;
            total += d;
        }
    CHECK(1000 * total.by_exact <= total.total());
    // Only a coincidence, such as two equal curvatures among these rounded numbers, takes an exact sign.
    CHECK(100 * with_exact_signs <= scenes);
    CHECK(total.by_interval > 0);
}

TEST_CASE("lower_envelope: doubles and intervals decide overlays of random scenes") {
    std::mt19937_64 rng(test_seed());
    EnvelopeOptions by_overlay;
    by_overlay.largest_piece = 1;
    Decisions total;
    for (int round = 0; round < 50; ++round)
        for (const int n : {8, 24}) {
            const FormScene s = random_spheres(rng, n, std::sqrt(n));
            total += lower_envelope(s.family(), s.region(), by_overlay).decisions;
        }
    CHECK(1000 * total.by_exact <= total.total());
}

TEST_CASE("oracle: sees a tie where all terms of the forms vanish") {
    // The vertex at the origin, refined, is off by as much as the forms' terms are there.
    FormScene s{.name = "three paraboloids through the origin", .numbers = {}, .polygon = {}};
    s.paraboloid(0.5, 1, -1.25, 1);
    s.paraboloid(0, 0.5, -0.25, 2);
    s.paraboloid(1, -0.5, -1.25, 1);
    std::mt19937_64 rng(test_seed());
    judge(s, rng);
}

TEST_CASE("oracle: accepts a diagram built by hand") {
    // Two equal spheres meet over x = 0; a third, lower and narrower, is an island on the right.
    FormScene scene{.name = "by hand", .numbers = {}, .polygon = {}};
    scene.paraboloid(-1, 0, 1, 2);
    scene.paraboloid(1, 0, 1, 2);
    scene.paraboloid(1, 0, 0.25, 1);  // lower than its neighbour where 2 (r^2 + 1/4) < r^2 + 1
    const FormFamily family = scene.family();

    MinimizationDiagram d;
    d.region = scene.region();
    d.forms = family.forms;
    const std::vector<Eigen::Vector2d> points{{-2, -2}, {0, -2}, {2, -2}, {2, 2}, {0, 2}, {-2, 2}};
    const std::vector<std::vector<std::uint32_t>> sides{{0, 3}, {0}, {0, 1}, {1, 2}, {2}, {2, 3}};
    const std::vector<std::vector<FormId>> labels{{{0}}, {{0}, {1}}, {{1}}, {{1}}, {{0}, {1}}, {{0}}};
    d.vertex_offsets_ = d.edge_offsets_ = d.side_offsets_ = {0};
    std::vector<VertexId> v;
    for (std::size_t i = 0; i < points.size(); ++i) {
        v.push_back(d.dcel.add_vertex());
        d.vertices.push_back({points[i], 0, family.forms[labels[i][0]](points[i].x(), points[i].y()), 1e-15});
        d.vertex_labels_.insert(d.vertex_labels_.end(), labels[i].begin(), labels[i].end());
        d.vertex_sides_.insert(d.vertex_sides_.end(), sides[i].begin(), sides[i].end());
        d.vertex_offsets_.push_back(d.vertex_labels_.size());
        d.side_offsets_.push_back(d.vertex_sides_.size());
    }
    const auto add_edge = [&](VertexId from, VertexId to, MinimizationDiagram::Edge edge) {
        d.dcel.add_edge(from, to);
        d.edge_labels_.push_back(edge.left);
        if (edge.right.valid()) d.edge_labels_.push_back(edge.right);
        std::sort(d.edge_labels_.begin() + d.edge_offsets_.back(), d.edge_labels_.end());
        d.edge_offsets_.push_back(d.edge_labels_.size());
        d.edges.push_back(edge);
    };
    const FormId none;
    const std::array<std::uint32_t, 6> rim_sides{0, 0, 1, 2, 2, 3};
    for (std::uint32_t i = 0; i < 6; ++i)
        add_edge(v[i], v[(i + 1) % 6], {{i == 0 || i > 3 ? 0u : 1u}, none, rim_sides[i]});
    add_edge(v[1], v[4], {{0}, {1}});
    add_edge({}, {}, {{2}, {1}});
    const auto half = [](std::uint32_t e, unsigned direction = 0) { return Dcel::half_edge({e}, direction); };
    const auto cycle = [&](std::vector<HalfEdgeId> h) {
        for (std::size_t i = 0; i < h.size(); ++i) d.dcel.link(h[i], h[(i + 1) % h.size()]);
    };
    cycle({half(0), half(6), half(4), half(5)});
    cycle({half(1), half(2), half(3), half(6, 1)});
    cycle({half(5, 1), half(4, 1), half(3, 1), half(2, 1), half(1, 1), half(0, 1)});
    d.face_forms.push_back(none);
    for (const std::uint32_t form : {0, 1, 2}) {
        d.dcel.add_face();
        d.face_forms.push_back({form});
    }
    d.dcel.add_inner_ccb({0}, half(0, 1));
    d.dcel.add_outer_ccb({1}, half(0));
    d.dcel.add_outer_ccb({2}, half(1));
    d.dcel.add_outer_ccb({3}, half(7));
    d.dcel.add_inner_ccb({2}, half(7, 1));

    std::mt19937_64 rng(test_seed());
    CHECK_MESSAGE(oracle::check_diagram(d, family, rng).empty(), join(oracle::check_diagram(d, family, rng)));
    std::swap(d.edges[{7}].left, d.edges[{7}].right);
    CHECK(!oracle::check_diagram(d, family, rng).empty());
}

TEST_CASE("oracle: objects to corrupted diagrams") {
    std::mt19937_64 rng(test_seed());
    FormScene scene{.name = "four spheres", .numbers = {}, .polygon = {}};
    scene.sphere(-1, -0.75, 1, 0.25);
    scene.sphere(1, -1, 1.25, 0.5);
    scene.sphere(-0.75, 1, 1, 0.125);
    scene.sphere(1, 1, 1.125, 0.25);
    const FormFamily family = scene.family();
    const MinimizationDiagram good = lower_envelope(family, scene.region());
    REQUIRE(oracle::check_diagram(good, family, rng).empty());

    const auto objects = [&](const char* damage, const auto& corrupt) {
        MinimizationDiagram bad = good;
        corrupt(bad);
        CHECK_MESSAGE(!oracle::check_diagram(bad, family, rng).empty(), damage);
    };
    const VertexId inner = [&] {
        VertexId v{0};
        while (!good.sides(v).empty()) ++v.value;
        return v;
    }();
    const EdgeId inner_edge = [&] {
        EdgeId e{0};
        while (good.edges[e].on_rim()) ++e.value;
        return e;
    }();

    objects("two faces exchange their forms",
            [](auto& d) { std::swap(d.face_forms[{1}], d.face_forms[{2}]); });
    objects("two faces and all that mentions them exchange their forms", [](auto& d) {
        const FormId a = d.face_forms[{1}], b = d.face_forms[{2}];
        const auto exchange = [&](FormId& f) { f = f == a ? b : f == b ? a : f; };
        for (FormId& f : d.face_forms) exchange(f);
        for (auto& e : d.edges) exchange(e.left), exchange(e.right);
        for (auto* labels : {&d.vertex_labels_, &d.edge_labels_}) {
            for (FormId& f : *labels) exchange(f);
        }
        for (auto* offsets : {&d.vertex_offsets_, &d.edge_offsets_}) {
            auto& labels = offsets == &d.vertex_offsets_ ? d.vertex_labels_ : d.edge_labels_;
            for (std::size_t i = 0; i + 1 < offsets->size(); ++i)
                std::sort(labels.begin() + (*offsets)[i], labels.begin() + (*offsets)[i + 1]);
        }
    });
    objects("a vertex with a wrong label", [&](auto& d) {
        FormId& f = d.vertex_labels_[d.vertex_offsets_[inner.value]];
        f.value = f.value == 0 ? 3 : f.value - 1;
    });
    objects("a vertex without one of its forms", [&](auto& d) {
        d.vertex_labels_.erase(d.vertex_labels_.begin() + d.vertex_offsets_[inner.value]);
        for (std::size_t i = inner.value + 1; i < d.vertex_offsets_.size(); ++i) --d.vertex_offsets_[i];
    });
    objects("a vertex moved", [&](auto& d) { d.vertices[inner].point.x() += 1e-9; });
    objects("a height changed", [&](auto& d) { d.vertices[inner].height += 1e-9; });
    objects("a vertex on a side that it does not touch", [&](auto& d) {
        d.vertex_sides_.insert(d.vertex_sides_.begin() + d.side_offsets_[inner.value], 0);
        for (std::size_t i = inner.value + 1; i < d.side_offsets_.size(); ++i) ++d.side_offsets_[i];
    });
    objects("an edge turned round",
            [&](auto& d) { std::swap(d.edges[inner_edge].left, d.edges[inner_edge].right); });
    objects("a rim edge on the wrong side", [&](auto& d) {
        for (auto& e : d.edges)
            if (e.on_rim()) {
                e.side = (e.side + 1) % 4;
                return;
            }
    });
}

}  // namespace vcell::envelope_oracle_test
