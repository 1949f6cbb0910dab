#include <doctest/doctest.h>

#include <string>

#include "vcell/arrangement/dcel/dcel.hpp"

namespace vcell::dcel_test {

namespace {

/// A triangle v0 v1 v2 with a pendant edge v0 - v3 outside it: one bounded face.
struct Triangle {
    Dcel dcel;
    EdgeId a, b, c, pendant;
    FaceId inside;

    static HalfEdgeId forth(EdgeId e) { return Dcel::half_edge(e, 0); }
    static HalfEdgeId back(EdgeId e) { return Dcel::half_edge(e, 1); }

    Triangle() {
        VertexId v[4];
        for (VertexId& x : v) x = dcel.add_vertex();
        a = dcel.add_edge(v[0], v[1]);
        b = dcel.add_edge(v[1], v[2]);
        c = dcel.add_edge(v[2], v[0]);
        pendant = dcel.add_edge(v[0], v[3]);
        cycle({forth(a), forth(b), forth(c)});
        cycle({back(a), forth(pendant), back(pendant), back(c), back(b)});
    }
    void cycle(std::initializer_list<HalfEdgeId> hs) {
        const HalfEdgeId* previous = hs.end() - 1;
        for (const HalfEdgeId& h : hs) {
            dcel.link(*previous, h);
            previous = &h;
        }
    }
    void add_faces() {
        inside = dcel.add_face();
        dcel.add_outer_ccb(inside, forth(a));
        dcel.add_inner_ccb(Dcel::unbounded_face(), back(a));
    }
};

std::string defect(const Dcel& d) {
    const auto found = d.find_defect();
    return found ? found->what : "";
}
#define CHECK_DEFECT(dcel, part)                        \
    do {                                                \
        const std::string message = defect(dcel);       \
        CAPTURE(message);                               \
        CHECK(message.find(part) != std::string::npos); \
    } while (false)

}  // namespace

TEST_CASE("Dcel: sound subdivisions have no defect") {
    CHECK(defect(Dcel()) == "");
    Triangle t;
    t.add_faces();
    CHECK(defect(t.dcel) == "");
    CHECK(t.dcel.face(Triangle::forth(t.b)) == t.inside);
    CHECK(t.dcel.face(Triangle::back(t.pendant)) == Dcel::unbounded_face());

    const VertexId isolated = t.dcel.add_vertex();
    t.dcel.add_isolated_vertex(t.inside, isolated);
    CHECK(defect(t.dcel) == "");

    // A closed edge without vertices inside the triangle: one more face.
    const EdgeId loop = t.dcel.add_edge({}, {});
    t.dcel.add_inner_ccb(t.inside, Triangle::back(loop));
    t.dcel.add_outer_ccb(t.dcel.add_face(), Triangle::forth(loop));
    CHECK(defect(t.dcel) == "");

    // A loop at one vertex, inside that.
    const VertexId v = t.dcel.add_vertex();
    const EdgeId ear = t.dcel.add_edge(v, v);
    t.cycle({Triangle::forth(ear)});
    t.cycle({Triangle::back(ear)});
    t.dcel.add_inner_ccb(t.dcel.face(Triangle::forth(loop)), Triangle::back(ear));
    t.dcel.add_outer_ccb(t.dcel.add_face(), Triangle::forth(ear));
    CHECK(defect(t.dcel) == "");
}

TEST_CASE("Dcel: find_defect sees every broken invariant") {
    Triangle t;
    Dcel& d = t.dcel;
    SUBCASE("an edge that is not linked") {
        t.add_faces();
        d.add_edge(VertexId{1}, VertexId{3});
        CHECK_DEFECT(d, "h8 has no next");
    }
    SUBCASE("a half-edge of no component") {
        d.add_outer_ccb(d.add_face(), Triangle::forth(t.a));
        CHECK_DEFECT(d, "belongs to no component");
    }
    SUBCASE("next without prev") {
        t.add_faces();
        d.link(Triangle::back(t.pendant), Triangle::forth(t.pendant));
        CHECK_DEFECT(d, "h1 is not the prev of its next h6");
    }
    SUBCASE("prev without next") {
        t.add_faces();
        d.link(Triangle::back(t.a), Triangle::back(t.c));
        CHECK_DEFECT(d, "h6 is not the next of its prev h1");
    }
    SUBCASE("a closed edge linked into a cycle") {
        const EdgeId e = d.add_edge({}, {});
        d.link(Triangle::forth(e), Triangle::back(e));
        d.link(Triangle::back(e), Triangle::forth(e));
        d.add_inner_ccb(Dcel::unbounded_face(), Triangle::forth(e));
        t.add_faces();
        CHECK_DEFECT(d, "has no vertices but is not its own next");
    }
    SUBCASE("a cycle that jumps between vertices") {
        t.cycle({Triangle::forth(t.a), Triangle::forth(t.c), Triangle::forth(t.b)});
        t.add_faces();
        CHECK_DEFECT(d, "ends at v1 but its next h4 starts at v2");
    }
    SUBCASE("a cycle that names two components") {
        t.add_faces();
        d.add_inner_ccb(t.inside, Triangle::forth(t.b));
        CHECK_DEFECT(d, "lies on the cycle of c0 but names c2");
    }
    SUBCASE("a half-edge that names a component of another cycle") {
        t.add_faces();
        // The pendant edge leaves the cycle of its component: the two closed paths share one name.
        d.link(Triangle::back(t.a), Triangle::back(t.c));
        d.link(Triangle::back(t.pendant), Triangle::forth(t.pendant));
        CHECK_DEFECT(d, "is not on the cycle of its component");
    }
    SUBCASE("a bounded face without outer component") {
        t.add_faces();
        d.add_face();
        CHECK_DEFECT(d, "f2 has no outer component");
    }
    SUBCASE("an unbounded face with an outer component") {
        d.add_outer_ccb(Dcel::unbounded_face(), Triangle::forth(t.a));
        d.add_inner_ccb(Dcel::unbounded_face(), Triangle::back(t.a));
        CHECK_DEFECT(d, "f0 is unbounded but has an outer component");
    }
    SUBCASE("two outer components of one face") {
        t.add_faces();
        const EdgeId e = d.add_edge({}, {});
        d.add_outer_ccb(t.inside, Triangle::forth(e));
        d.add_inner_ccb(Dcel::unbounded_face(), Triangle::back(e));
        CHECK_DEFECT(d, "c0 is listed 0 times");
    }
    SUBCASE("a vertex in no face") {
        t.add_faces();
        d.add_vertex();
        CHECK_DEFECT(d, "v4 has degree 0 and is listed as isolated 0 times");
    }
    SUBCASE("an isolated vertex listed twice") {
        t.add_faces();
        const VertexId v = d.add_vertex();
        d.add_isolated_vertex(t.inside, v);
        d.add_isolated_vertex(t.inside, v);
        CHECK_DEFECT(d, "v4 has degree 0 and is listed as isolated 2 times");
    }
    SUBCASE("an isolated vertex that two faces list") {
        t.add_faces();
        const VertexId v = d.add_vertex();
        d.add_isolated_vertex(t.inside, v);
        d.add_isolated_vertex(Dcel::unbounded_face(), v);
        CHECK_DEFECT(d, "f1 lists isolated v4, which does not name it");
    }
    SUBCASE("an isolated vertex with edges") {
        t.add_faces();
        d.add_isolated_vertex(t.inside, VertexId{1});
        CHECK_DEFECT(d, "v1 has degree 2 and is listed as isolated 1 times");
    }
    SUBCASE("two rotations at one vertex") {
        // Two triangles that share v0 but not the rotation there.
        const VertexId v = d.add_vertex(), w = d.add_vertex();
        const EdgeId e = d.add_edge(VertexId{0}, v), f = d.add_edge(v, w), g = d.add_edge(w, VertexId{0});
        t.cycle({Triangle::forth(e), Triangle::forth(f), Triangle::forth(g)});
        t.cycle({Triangle::back(g), Triangle::back(f), Triangle::back(e)});
        t.add_faces();
        d.add_outer_ccb(d.add_face(), Triangle::forth(e));
        d.add_inner_ccb(Dcel::unbounded_face(), Triangle::back(e));
        CHECK_DEFECT(d, "v0: the rotation from h0 does not meet all its half-edges");
    }
    SUBCASE("a connected component without an outside") {
        d.add_outer_ccb(d.add_face(), Triangle::forth(t.a));
        d.add_outer_ccb(d.add_face(), Triangle::back(t.a));
        CHECK_DEFECT(d, "has no inner component around it");
    }
    SUBCASE("a connected component with two outsides") {
        d.add_inner_ccb(Dcel::unbounded_face(), Triangle::forth(t.a));
        d.add_inner_ccb(Dcel::unbounded_face(), Triangle::back(t.a));
        CHECK_DEFECT(d, "are both the outside of one connected component");
    }
    SUBCASE("a graph on a torus") {
        Dcel torus;
        const VertexId v = torus.add_vertex();
        const EdgeId e = torus.add_edge(v, v), f = torus.add_edge(v, v);
        // Around v: e f e' f'. One cycle instead of three.
        torus.link(Triangle::forth(e), Triangle::forth(f));
        torus.link(Triangle::forth(f), Triangle::back(e));
        torus.link(Triangle::back(e), Triangle::back(f));
        torus.link(Triangle::back(f), Triangle::forth(e));
        torus.add_inner_ccb(Dcel::unbounded_face(), Triangle::forth(e));
        CHECK_DEFECT(torus, "it is not planar");
    }
    SUBCASE("islands inside each other") {
        t.add_faces();
        Dcel rings;
        const EdgeId e = rings.add_edge({}, {}), f = rings.add_edge({}, {});
        const FaceId in_e = rings.add_face(), in_f = rings.add_face();
        rings.add_outer_ccb(in_e, Triangle::forth(e));
        rings.add_outer_ccb(in_f, Triangle::forth(f));
        rings.add_inner_ccb(in_f, Triangle::back(e));
        rings.add_inner_ccb(in_e, Triangle::back(f));
        CHECK_DEFECT(rings, "lies inside itself");
    }
}

}  // namespace vcell::dcel_test
