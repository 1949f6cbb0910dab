#include <doctest/doctest.h>

#include <array>
#include <random>
#include <string>

#include "test_support.hpp"
#include "vcell/arrangement/dcel/half_edge_mesh.hpp"

namespace vcell::half_edge_mesh_test {

namespace {

struct HalfEdge {
    std::uint32_t next, prev, origin, face;
};

// Faces by number, 0 outside; what changes them is as in a diagram under construction.
class Mesh : public HalfEdgeMesh<HalfEdge> {
public:
    using HalfEdgeMesh::next;
    std::vector<bool> alive;
    Index vertices = 0, faces = 1;

    Index add_edge(Index from, Index to) {
        alive.push_back(true);
        half_edges_.push_back({none, none, from, none});
        half_edges_.push_back({none, none, to, none});
        return static_cast<Index>(half_edges_.size()) - 2;
    }
    // One face around which n edges run, and the outside.
    void start(Index n) {
        for (Index i = 0; i < n; ++i) add_edge(i, (i + 1) % n);
        for (Index i = 0; i < n; ++i) {
            link(2 * i, 2 * ((i + 1) % n));
            link(2 * ((i + 1) % n) + 1, 2 * i + 1);
            half_edges_[2 * i].face = 1;
            half_edges_[2 * i + 1].face = 0;
        }
        vertices = n;
        faces = 2;
    }
    void put_vertex(Index h) {
        const Index v = vertices++;
        split(h, v, add_edge(none, none) | (h & 1u));
    }
    // An edge from where h ends to where g ends; the face of h is new. Pre: both are of one cycle.
    void cross(Index h, Index g) {
        const Index after_h = next(h), after_g = next(g), e = add_edge(target(h), target(g));
        link(h, e);
        link(e, after_g);
        link(g, e + 1);
        link(e + 1, after_h);
        half_edges_[e + 1].face = half_edges_[h].face;
        const Index f = faces++;
        for_cycle(e, [&](Index k) { half_edges_[k].face = f; });
    }
    // Takes the edge between two faces out; they become one.
    void take_out(Index h) {
        const Index f = half_edges_[h].face, other = twin(h);
        for_cycle(other, [&](Index k) { half_edges_[k].face = f; });
        detach(h);
        detach(other);
        alive[h >> 1] = false;
    }
    bool is_smooth(Index h) const {
        return next_around_origin(next_around_origin(h)) == h && next_around_origin(h) != h;
    }
    void drop_origin(Index h) {
        const Index before = prev(h);
        join(before);
        alive[h >> 1] = false;
    }
    std::string defect() const {
        return find_defect([&](Index e) { return alive[e]; }).value_or("");
    }
    std::vector<HalfEdge>& raw() { return half_edges_; }
};
using Index = Mesh::Index;

}  // namespace

TEST_CASE("HalfEdgeMesh: sound after every change") {
    std::mt19937_64 rng(test_seed());
    std::array<int, 4> done{};
    for (int round = 0; round < 20 * rounds(); ++round) {
        Mesh mesh;
        mesh.start(3 + rng() % 3);
        REQUIRE(mesh.defect() == "");
        for (int step = 0; step < 60; ++step) {
            const auto h = static_cast<Index>(rng() % mesh.half_edges().size());
            if (!mesh.alive[h >> 1]) continue;
            const std::vector<HalfEdge>& all = mesh.half_edges();
            const int what = static_cast<int>(rng() % 4);
            if (what == 0) {
                mesh.put_vertex(h);
            } else if (what == 1) {
                Index g = h;
                for (auto k = rng() % 8; k > 0; --k) g = mesh.next(g);
                // A second edge between the ends of one would do, an edge to where it begins not.
                if (g == h || mesh.target(g) == mesh.target(h)) continue;
                mesh.cross(h, g);
            } else if (what == 2) {
                if (all[h].face == all[Mesh::twin(h)].face || mesh.is_smooth(h) ||
                    mesh.is_smooth(Mesh::twin(h)))
                    continue;
                mesh.take_out(h);
            } else {
                if (!mesh.is_smooth(h) || mesh.next(mesh.next(h)) == h) continue;
                mesh.drop_origin(h);
            }
            ++done[what];
            CAPTURE(step);
            CAPTURE(what);
            REQUIRE(mesh.defect() == "");
        }
    }
    for (const int of_a_kind : done) CHECK(of_a_kind > 20 * rounds());
}

TEST_CASE("HalfEdgeMesh: closed edges, and what find_defect sees") {
    Mesh mesh;
    mesh.start(4);
    mesh.cross(0, 4);
    const Index closed = mesh.add_edge(Mesh::none, Mesh::none);
    for (const Index h : {closed, closed + 1}) mesh.raw()[h] = {h, h, Mesh::none, h - closed + 1};
    REQUIRE(mesh.defect() == "");
    const auto says = [&](const char* part) {
        CAPTURE(mesh.defect());
        CHECK(mesh.defect().find(part) != std::string::npos);
    };
    SUBCASE("no next") {
        mesh.raw()[2].next = Mesh::none;
        says("h2 has no next");
    }
    SUBCASE("links one way") {
        mesh.raw()[0].next = 6;
        says("h0 is not the prev of its next h6");
    }
    SUBCASE("an edge that is gone") {
        mesh.alive[1] = false;
        says("has no");
    }
    SUBCASE("an origin") {
        mesh.raw()[2].origin = 3;
        says("does not end where its next begins");
    }
    SUBCASE("a face") {
        mesh.raw()[0].face = 7;
        says("has another face than its next");
    }
    SUBCASE("one end of a closed edge") {
        mesh.raw()[closed].origin = 2;
        says("h10");
    }
    SUBCASE("two vertices with one number") {
        // A second square with a corner's number of the first.
        Mesh two;
        two.start(3);
        for (HalfEdge h : std::vector<HalfEdge>(two.raw())) {
            h.next += 6, h.prev += 6;
            h.origin = h.origin == 0 ? 0 : h.origin + 3;
            two.raw().push_back(h);
        }
        two.alive.resize(6, true);
        CHECK(two.defect().find("does not meet all that leave its origin") != std::string::npos);
    }
    SUBCASE("a handle") {
        // Both diagonals of a square in one rotation that no plane has.
        Mesh torus;
        torus.add_edge(0, 0);
        torus.add_edge(0, 0);
        const Index cycle[] = {0, 2, 1, 3};
        for (int i = 0; i < 4; ++i) torus.raw()[cycle[i]] = {cycle[(i + 1) % 4], cycle[(i + 3) % 4], 0, 0};
        CHECK(torus.defect().find("V - E + cycles = 0") != std::string::npos);
    }
}

}  // namespace vcell::half_edge_mesh_test
